//! Conversions to and from `glam` and `mint`: the same numbers in the same order.

#[cfg(feature = "glam")]
mod with_glam {
    use crate::base::math::{Mat3, Vec3, vec3};
    use crate::base::pose::Pose;
    use crate::base::quat::Quat;

    impl From<glam::Vec3> for Vec3 {
        fn from(v: glam::Vec3) -> Self {
            vec3(v.x, v.y, v.z)
        }
    }

    impl From<Vec3> for glam::Vec3 {
        fn from(v: Vec3) -> Self {
            Self::new(v.x, v.y, v.z)
        }
    }

    impl From<glam::Vec3A> for Vec3 {
        fn from(v: glam::Vec3A) -> Self {
            vec3(v.x, v.y, v.z)
        }
    }

    impl From<Vec3> for glam::Vec3A {
        fn from(v: Vec3) -> Self {
            Self::new(v.x, v.y, v.z)
        }
    }

    impl From<glam::Quat> for Quat {
        fn from(q: glam::Quat) -> Self {
            Self { x: q.x, y: q.y, z: q.z, w: q.w }
        }
    }

    impl From<Quat> for glam::Quat {
        fn from(q: Quat) -> Self {
            Self::from_xyzw(q.x, q.y, q.z, q.w)
        }
    }

    impl From<glam::Mat3> for Mat3 {
        fn from(m: glam::Mat3) -> Self {
            Self { x: m.x_axis.into(), y: m.y_axis.into(), z: m.z_axis.into() }
        }
    }

    impl From<Mat3> for glam::Mat3 {
        fn from(m: Mat3) -> Self {
            Self::from_cols(m.x.into(), m.y.into(), m.z.into())
        }
    }

    /// Rotation first, then translation.
    impl From<Pose> for glam::Affine3A {
        fn from(pose: Pose) -> Self {
            Self::from_rotation_translation(pose.rotation.into(), pose.position.into())
        }
    }

    /// Rotation first, then translation.
    impl From<Pose> for glam::Mat4 {
        fn from(pose: Pose) -> Self {
            Self::from_rotation_translation(pose.rotation.into(), pose.position.into())
        }
    }
}

#[cfg(feature = "mint")]
mod with_mint {
    use crate::base::math::{Mat3, Vec3, vec3};
    use crate::base::quat::Quat;

    impl From<mint::Vector3<f32>> for Vec3 {
        fn from(v: mint::Vector3<f32>) -> Self {
            vec3(v.x, v.y, v.z)
        }
    }

    impl From<Vec3> for mint::Vector3<f32> {
        fn from(v: Vec3) -> Self {
            Self { x: v.x, y: v.y, z: v.z }
        }
    }

    impl From<mint::Point3<f32>> for Vec3 {
        fn from(p: mint::Point3<f32>) -> Self {
            vec3(p.x, p.y, p.z)
        }
    }

    impl From<Vec3> for mint::Point3<f32> {
        fn from(v: Vec3) -> Self {
            Self { x: v.x, y: v.y, z: v.z }
        }
    }

    impl From<mint::Quaternion<f32>> for Quat {
        fn from(q: mint::Quaternion<f32>) -> Self {
            Self { x: q.v.x, y: q.v.y, z: q.v.z, w: q.s }
        }
    }

    impl From<Quat> for mint::Quaternion<f32> {
        fn from(q: Quat) -> Self {
            Self { v: mint::Vector3 { x: q.x, y: q.y, z: q.z }, s: q.w }
        }
    }

    impl From<mint::ColumnMatrix3<f32>> for Mat3 {
        fn from(m: mint::ColumnMatrix3<f32>) -> Self {
            Self { x: m.x.into(), y: m.y.into(), z: m.z.into() }
        }
    }

    impl From<Mat3> for mint::ColumnMatrix3<f32> {
        fn from(m: Mat3) -> Self {
            Self { x: m.x.into(), y: m.y.into(), z: m.z.into() }
        }
    }
}

#[cfg(all(test, any(feature = "glam", feature = "mint")))]
mod tests {
    use crate::base::math::{Vec3, vec3};
    use crate::base::quat::Quat;

    const TURN: Quat = Quat { x: 0.5, y: 0.5, z: 0.5, w: 0.5 };
    const POINT: Vec3 = vec3(1.0, 2.0, 4.0);

    #[cfg(feature = "glam")]
    #[test]
    fn glam_turns_a_point_as_we_do() {
        use crate::base::pose::Pose;

        let turned = glam::Quat::from(TURN) * glam::Vec3::from(POINT);
        assert_eq!(Vec3::from(turned), TURN.rotate(POINT));
        assert_eq!(Quat::from(glam::Quat::from(TURN)), TURN);
        let pose = Pose::new(vec3(8.0, 0.0, -8.0), TURN);
        let there = glam::Affine3A::from(pose).transform_point3(POINT.into());
        assert_eq!(Vec3::from(there), pose.point(POINT));
        let there = glam::Mat4::from(pose).transform_point3(POINT.into());
        assert_eq!(Vec3::from(there), pose.point(POINT));
        let matrix = glam::Mat3::from(TURN.to_mat3());
        assert_eq!(Vec3::from(matrix * glam::Vec3::from(POINT)), TURN.rotate(POINT));
    }

    #[cfg(feature = "mint")]
    #[test]
    fn mint_gives_back_what_it_got() {
        assert_eq!(Vec3::from(mint::Vector3::from(POINT)), POINT);
        assert_eq!(Vec3::from(mint::Point3::from(POINT)), POINT);
        assert_eq!(Quat::from(mint::Quaternion::from(TURN)), TURN);
        let q = mint::Quaternion::from(Quat { x: 1.0, y: 2.0, z: 3.0, w: 4.0 });
        assert_eq!((q.v.x, q.v.y, q.v.z, q.s), (1.0, 2.0, 3.0, 4.0));
    }
}
