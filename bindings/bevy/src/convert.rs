//! Numbers between Bevy and the engine, and places in a hierarchy.
//!
//! The engine's own arithmetic computes places, because its results have the same bits everywhere.

use bevy_transform::components::Transform;
use drystone::{Pose, Quat, Vec3, vec3};

/// The engine's vector with the same numbers.
pub(crate) const fn to_vec(v: bevy_math::Vec3) -> Vec3 {
    vec3(v.x, v.y, v.z)
}

/// Bevy's vector with the same numbers.
pub(crate) const fn from_vec(v: Vec3) -> bevy_math::Vec3 {
    bevy_math::Vec3::new(v.x, v.y, v.z)
}

/// The engine's rotation with the same numbers.
pub(crate) fn to_quat(q: bevy_math::Quat) -> Quat {
    Quat::new(q.x, q.y, q.z, q.w)
}

/// Bevy's rotation with the same numbers.
pub(crate) const fn from_quat(q: Quat) -> bevy_math::Quat {
    bevy_math::Quat::from_xyzw(q.x, q.y, q.z, q.w)
}

/// True if two numbers have the same bits.
pub(crate) const fn same(a: f32, b: f32) -> bool {
    a.to_bits() == b.to_bits()
}

/// True if two vectors have the same bits.
pub(crate) fn same_vec(a: bevy_math::Vec3, b: bevy_math::Vec3) -> bool {
    a.to_array().map(f32::to_bits) == b.to_array().map(f32::to_bits)
}

/// True if two poses have the same bits; their scales do not count.
pub(crate) fn same_place(a: &Transform, b: &Transform) -> bool {
    let turns = |t: &Transform| t.rotation.to_array().map(f32::to_bits);
    same_vec(a.translation, b.translation) && turns(a) == turns(b)
}

/// A pose with a scale: the place of an entity in the world, or in the frame of another entity.
///
/// A parent with an uneven scale shears a turned child. As in Bevy's `Transform::mul_transform`,
/// the shear is left out.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Placement {
    pub(crate) pose: Pose,
    pub(crate) scale: Vec3,
}

impl Placement {
    pub(crate) const IDENTITY: Self = Self { pose: Pose::IDENTITY, scale: Vec3::ONE };

    pub(crate) fn of(transform: &Transform) -> Self {
        let pose =
            Pose { position: to_vec(transform.translation), rotation: to_quat(transform.rotation) };
        Self { pose, scale: to_vec(transform.scale) }
    }

    /// The place of a child, whose own place in this frame is `inner`.
    pub(crate) fn child(&self, inner: &Self) -> Self {
        let position = self.pose.point(times(self.scale, inner.pose.position));
        let rotation = self.pose.rotation * inner.pose.rotation;
        Self { pose: Pose { position, rotation }, scale: times(self.scale, inner.scale) }
    }

    /// The pose in this frame of a child at `pose` [m, world]. Along an axis of scale 0 every
    /// position is the same, and 0 is returned.
    pub(crate) fn local(&self, pose: &Pose) -> Pose {
        let at = self.pose.rotation.unrotate(pose.position - self.pose.position);
        let part = |x: f32, scale: f32| if scale == 0.0 { 0.0 } else { x / scale };
        let scale = self.scale;
        let position = vec3(part(at.x, scale.x), part(at.y, scale.y), part(at.z, scale.z));
        let rotation = (self.pose.rotation.conjugate() * pose.rotation).normalized();
        Pose { position, rotation }
    }
}

/// Products of the components.
pub(crate) fn times(a: Vec3, b: Vec3) -> Vec3 {
    vec3(a.x * b.x, a.y * b.y, a.z * b.z)
}

#[cfg(test)]
mod tests {
    use super::{Placement, from_vec, to_quat, to_vec};
    use bevy_math::{Quat, Vec3};
    use bevy_transform::components::Transform;

    /// A frame turned by a quarter about y takes x to -z; the child lies at twice its own offset.
    #[test]
    fn a_child_lies_where_its_scaled_and_turned_parent_says() {
        let half = core::f32::consts::FRAC_1_SQRT_2;
        let parent = Transform {
            translation: Vec3::new(0.0, 1.0, 0.0),
            rotation: Quat::from_xyzw(0.0, half, 0.0, half),
            scale: Vec3::splat(2.0),
        };
        let child = Transform::from_xyz(3.0, 0.0, 0.0);
        let place = Placement::of(&parent).child(&Placement::of(&child));
        let error = from_vec(place.pose.position) - Vec3::new(0.0, 1.0, -6.0);
        // Three roundings of numbers of size 6.
        assert!(error.length() < 3.0 * 6.0 * f32::EPSILON, "{error}");
        let back = Placement::of(&parent).local(&place.pose);
        assert!((back.position - to_vec(child.translation)).length() < 12.0 * f32::EPSILON);
        assert!((back.rotation * to_quat(Quat::IDENTITY).conjugate()).angle() < 1e-3);
    }

    #[test]
    fn a_flattened_parent_gives_finite_places() {
        let parent = Placement::of(&Transform::from_scale(Vec3::new(1.0, 0.0, 1.0)));
        let local = parent.local(&drystone::Pose::at([1.0, 2.0, 3.0]));
        assert_eq!(local.position, drystone::vec3(1.0, 0.0, 3.0));
    }
}
