//! A shape in the form that the narrowphase uses: a core, rounded by a radius.

use std::sync::Arc;

use fearless_simd::Simd;

use super::hull::Hull;
use super::mesh::Mesh;
use super::shape::Shape;
use crate::base::aabb::Aabb;
use crate::base::math::{Mat3, Vec3, greater, vec3};
use crate::base::pose::Pose;

/// The sharp part of a solid, in its own frame.
#[derive(Clone, Debug)]
pub(crate) enum Core {
    /// The origin: a sphere's core.
    Point,
    /// The segment from (0, -half_height, 0) to (0, half_height, 0): a capsule's core.
    Segment { half_height: f32 },
    /// A polytope, including boxes.
    Hull(Arc<Hull>),
    /// A body of revolution about y: cylinder, cone, truncated cone.
    Frustum { half_height: f32, radius_bottom: f32, radius_top: f32 },
    /// Points with `normal · p <= offset`.
    HalfSpace { normal: Vec3, offset: f32 },
    /// Triangles.
    Mesh(Arc<Mesh>),
}

/// All points within `radius` of the core.
#[derive(Clone, Debug)]
pub(crate) struct Solid {
    pub(crate) core: Core,
    /// Rounding [m]; 0 for sharp shapes.
    pub(crate) radius: f32,
}

impl Solid {
    /// A point.
    pub(crate) const POINT: Self = Self { core: Core::Point, radius: 0.0 };

    /// The solid of a validated shape.
    pub(crate) fn of(shape: &Shape) -> Self {
        let sharp = |core| Self { core, radius: 0.0 };
        match shape {
            Shape::Sphere { radius } => Self { core: Core::Point, radius: *radius },
            Shape::Capsule { half_height, radius } => {
                Self { core: Core::Segment { half_height: *half_height }, radius: *radius }
            }
            Shape::Box { half_extents } => sharp(Core::Hull(Arc::new(Hull::cuboid(*half_extents)))),
            Shape::Cylinder { half_height, radius } => sharp(Core::Frustum {
                half_height: *half_height,
                radius_bottom: *radius,
                radius_top: *radius,
            }),
            Shape::Cone { half_height, radius_bottom, radius_top } => sharp(Core::Frustum {
                half_height: *half_height,
                radius_bottom: *radius_bottom,
                radius_top: *radius_top,
            }),
            Shape::Hull(hull) => sharp(Core::Hull(Arc::clone(hull))),
            Shape::HalfSpace { normal, offset } => {
                sharp(Core::HalfSpace { normal: *normal, offset: *offset })
            }
            Shape::Mesh(mesh) => sharp(Core::Mesh(Arc::clone(mesh))),
        }
    }

    /// Returns true for a mesh or a half-space, which have no inside.
    pub(crate) const fn is_surface(&self) -> bool {
        matches!(self.core, Core::HalfSpace { .. } | Core::Mesh(_))
    }

    /// Smallest bounding box of the solid at `pose`; infinite for a half-space.
    pub(crate) fn aabb(&self, pose: &Pose) -> Aabb {
        let around = |center: Vec3, half: Vec3| Aabb::new(center - half, center + half);
        // A closure, since a ball does not need the matrix.
        let turn = || pose.rotation.to_mat3();
        let sharp = match &self.core {
            Core::Point => around(pose.position, Vec3::ZERO),
            Core::Segment { half_height } => around(pose.position, (turn().y * *half_height).abs()),
            Core::Hull(hull) => match hull.cuboid {
                Some(half) => {
                    let r = turn();
                    let extent = r.x.abs() * half.x + r.y.abs() * half.y + r.z.abs() * half.z;
                    around(pose.position, extent)
                }
                None => {
                    let rows = turn().transpose();
                    // Not a mapped array: compilers make calls of that.
                    let (low_x, high_x) = hull.lanes.reach_along(rows.x);
                    let (low_y, high_y) = hull.lanes.reach_along(rows.y);
                    let (low_z, high_z) = hull.lanes.reach_along(rows.z);
                    let (min, max) = (vec3(low_x, low_y, low_z), vec3(high_x, high_y, high_z));
                    Aabb::new(pose.position + min, pose.position + max)
                }
            },
            Core::Frustum { half_height, radius_bottom, radius_top } => {
                // A disc of radius R with axis y reaches R sqrt(1 - y_i^2) along world axis i.
                let reach = |y: f32| greater(1.0 - y * y, 0.0).sqrt();
                let r = turn();
                let disc = vec3(reach(r.y.x), reach(r.y.y), reach(r.y.z));
                let axis = r.y * *half_height;
                around(pose.position - axis, disc * *radius_bottom)
                    .union(&around(pose.position + axis, disc * *radius_top))
            }
            Core::HalfSpace { .. } => Aabb::new(Vec3::splat(-1.0e30), Vec3::splat(1.0e30)),
            Core::Mesh(mesh) => {
                let b = mesh.bounds();
                let half = b.half_extents();
                let r = turn();
                let extent = r.x.abs() * half.x + r.y.abs() * half.y + r.z.abs() * half.z;
                around(pose.point(b.center()), extent)
            }
        };
        sharp.grown(self.radius)
    }

    /// The lower end of [`Self::aabb`] along x [m].
    pub(crate) fn min_x(&self, pose: &Pose) -> f32 {
        match &self.core {
            Core::Hull(hull) if hull.cuboid.is_none() => {
                let row = pose.rotation.to_mat3().transpose().x;
                pose.position.x + hull.lanes.reach_along(row).0 - self.radius
            }
            _ => self.aabb(pose).min.x,
        }
    }

    /// Returns the same bits as [`Self::aabb`], computed with the machine's SIMD lanes. `turn` is
    /// the pose's rotation matrix, if the caller has it.
    #[inline(always)]
    pub(crate) fn aabb_with<S: Simd>(&self, simd: S, pose: &Pose, turn: Option<Mat3>) -> Aabb {
        match &self.core {
            Core::Hull(hull) if hull.cuboid.is_none() => {
                let turn = turn.unwrap_or_else(|| pose.rotation.to_mat3());
                let (min, max) = hull.lanes.turned_bounds(simd, &turn);
                Aabb::new(pose.position + min, pose.position + max).grown(self.radius)
            }
            _ => self.aabb(pose),
        }
    }

    /// Bounding box of the core along its own axes [m, local]; empty at the origin for a core
    /// without one.
    pub(crate) fn core_box(&self) -> Aabb {
        let half = match &self.core {
            Core::Hull(hull) => return hull.bounds(),
            Core::Segment { half_height } => vec3(0.0, *half_height, 0.0),
            Core::Frustum { half_height, radius_bottom, radius_top } => {
                let wide = greater(*radius_bottom, *radius_top);
                vec3(wide, *half_height, wide)
            }
            Core::Point | Core::HalfSpace { .. } | Core::Mesh(_) => Vec3::ZERO,
        };
        Aabb::new(-half, half)
    }

    /// A bounding ball of a bounded convex solid: center and radius [m, local].
    pub(crate) fn ball(&self) -> (Vec3, f32) {
        let core = self.core_box();
        (core.center(), core.half_extents().length() + self.radius)
    }

    /// Maximum distance of a point of the solid from `center` [m]; 0 for a half-space.
    pub(crate) fn max_extent(&self, center: Vec3) -> f32 {
        let far = match &self.core {
            Core::Point => center.length(),
            Core::Segment { half_height } => {
                let tip = vec3(0.0, *half_height, 0.0);
                greater((tip - center).length(), (tip + center).length())
            }
            Core::Hull(hull) => {
                hull.vertices().iter().map(|v| (*v - center).length()).fold(0.0, greater)
            }
            Core::Frustum { half_height, radius_bottom, radius_top } => {
                let side = vec3(center.x, 0.0, center.z).length();
                let rim = |r: f32, y: f32| vec3(side + r, y - center.y, 0.0).length();
                greater(rim(*radius_bottom, -half_height), rim(*radius_top, *half_height))
            }
            Core::HalfSpace { .. } => return 0.0,
            Core::Mesh(mesh) => {
                mesh.vertices().iter().map(|v| (*v - center).length()).fold(0.0, greater)
            }
        };
        far + self.radius
    }
}
