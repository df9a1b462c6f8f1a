//! Edges of shapes, and circles for shapes without edges.

use core::f32::consts::TAU;

use super::{DebugColor, Pen};
use crate::base::aabb::Aabb;
use crate::base::math::{Vec3, vec3};
use crate::base::pose::Pose;
use crate::base::trig::sin_cos;
use crate::geometry::hull::Hull;
use crate::geometry::mesh::Mesh;
use crate::geometry::shape::Shape;

/// Segments of a circle.
const PARTS: u16 = 24;

/// Half the edge length of the square drawn for a half-space [m], times the world's length scale.
const SQUARE: f32 = 5.0;

impl Pen<'_> {
    /// Draws the outline of a shape at a pose [world].
    pub(super) fn outline(&mut self, shape: &Shape, pose: &Pose, color: DebugColor) {
        match shape {
            Shape::Sphere { radius } => {
                for [u, v] in [[Vec3::X, Vec3::Y], [Vec3::Y, Vec3::Z], [Vec3::Z, Vec3::X]] {
                    self.circle(pose, Vec3::ZERO, [u * *radius, v * *radius], color);
                }
            }
            Shape::Capsule { half_height, radius } => {
                self.capsule(pose, *half_height, *radius, color);
            }
            Shape::Box { half_extents } => self.cuboid(pose, *half_extents, color),
            Shape::Cylinder { half_height, radius } => {
                self.frustum(pose, *half_height, [*radius; 2], color);
            }
            Shape::Cone { half_height, radius_bottom, radius_top } => {
                self.frustum(pose, *half_height, [*radius_bottom, *radius_top], color);
            }
            Shape::HalfSpace { normal, offset } => {
                let side = SQUARE * self.tables.config.length_scale;
                let (at, u) = (*normal * *offset, normal.any_perpendicular() * side);
                let v = normal.cross(u);
                let corners = [u + v, v - u, -u - v, u - v].map(|corner| pose.point(at + corner));
                for k in 0..4 {
                    self.line(corners[k], corners[(k + 1) % 4], color);
                }
                self.line(pose.point(at), pose.point(at + *normal * self.size), color);
            }
            Shape::Hull(hull) => self.hull(hull, pose, color),
            Shape::Mesh(mesh) => self.mesh(mesh, pose, color),
        }
    }

    pub(super) fn cuboid(&mut self, pose: &Pose, half: Vec3, color: DebugColor) {
        let corner = |x: f32, y: f32, z: f32| pose.point(half.mul_each(vec3(x, y, z)));
        for (s, t) in [(-1.0, -1.0), (-1.0, 1.0), (1.0, -1.0), (1.0, 1.0)] {
            self.line(corner(-1.0, s, t), corner(1.0, s, t), color);
            self.line(corner(s, -1.0, t), corner(s, 1.0, t), color);
            self.line(corner(s, t, -1.0), corner(s, t, 1.0), color);
        }
    }

    /// Draws a whole circle about the local point `at`; `axes` are its two half axes.
    fn circle(&mut self, pose: &Pose, at: Vec3, axes: [Vec3; 2], color: DebugColor) {
        self.arc(pose, at, axes, TAU, color);
    }

    /// Draws an arc from the first half axis through `angle` [rad].
    fn arc(&mut self, pose: &Pose, at: Vec3, [u, v]: [Vec3; 2], angle: f32, color: DebugColor) {
        let mut before = pose.point(at + u);
        for part in 1..=PARTS {
            let (sin, cos) = sin_cos(angle * (f32::from(part) / f32::from(PARTS)));
            let next = pose.point(at + u * cos + v * sin);
            self.line(before, next, color);
            before = next;
        }
    }

    fn capsule(&mut self, pose: &Pose, half_height: f32, radius: f32, color: DebugColor) {
        let (x, z) = (Vec3::X * radius, Vec3::Z * radius);
        for side in [-1.0, 1.0] {
            let end = Vec3::Y * (side * half_height);
            let up = Vec3::Y * (side * radius);
            self.circle(pose, end, [x, z], color);
            for across in [x, z] {
                self.arc(pose, end, [across, up], 0.5 * TAU, color);
            }
        }
        self.sides(pose, half_height, [radius; 2], color);
    }

    /// Draws the rims and sides of a cone or cylinder.
    fn frustum(&mut self, pose: &Pose, half_height: f32, radii: [f32; 2], color: DebugColor) {
        for (side, radius) in [-1.0, 1.0].into_iter().zip(radii) {
            let end = Vec3::Y * (side * half_height);
            if radius > 0.0 {
                self.circle(pose, end, [Vec3::X * radius, Vec3::Z * radius], color);
            }
        }
        self.sides(pose, half_height, radii, color);
    }

    fn sides(&mut self, pose: &Pose, half_height: f32, [low, high]: [f32; 2], color: DebugColor) {
        for out in [Vec3::X, Vec3::Z, -Vec3::X, -Vec3::Z] {
            let bottom = pose.point(out * low - Vec3::Y * half_height);
            self.line(bottom, pose.point(out * high + Vec3::Y * half_height), color);
        }
    }

    fn hull(&mut self, hull: &Hull, pose: &Pose, color: DebugColor) {
        // Twin half-edges are adjacent in the list.
        for twins in hull.edges.chunks_exact(2) {
            let [a, b] = [twins[0], twins[1]].map(|edge| hull.vertices[usize::from(edge.origin)]);
            self.line(pose.point(a), pose.point(b), color);
        }
    }

    fn mesh(&mut self, mesh: &Mesh, pose: &Pose, color: DebugColor) {
        for corners in mesh.triangles() {
            let at = corners.map(|corner| pose.point(mesh.vertices()[corner as usize]));
            if self.sees(&Aabb::of_points(at)) {
                for k in 0..3 {
                    self.line(at[k], at[(k + 1) % 3], color);
                }
            }
        }
    }
}
