//! Mass, center of mass and inertia of shapes.
//!
//! Round shapes use closed forms. Hulls and meshes are exact: sums over the tetrahedra between the
//! triangles of the surface and one point, which is the divergence theorem of [Mirtich95].

#[cfg(feature = "serde")]
use serde::{Deserialize, Serialize};

use super::hull::Hull;
use super::mesh::Mesh;
use super::shape::Shape;
use crate::base::double::DVec3;
use crate::base::math::{Vec3, vec3};
use crate::base::pose::Pose;
use crate::base::sym3::Sym3;

const PI: f64 = core::f64::consts::PI;

/// Mass properties of a solid.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
pub struct MassProperties {
    /// Mass [kg].
    pub mass: f32,
    /// Center of mass [m, local].
    pub center: Vec3,
    /// Inertia about the center of mass [kg m², local axes].
    pub inertia: Sym3,
}

impl MassProperties {
    /// Mass properties of a solid `shape` of this density [kg/m³]; all zero for a half-space and
    /// for a mesh without a closed volume.
    #[must_use]
    pub fn of(shape: &Shape, density: f32) -> Self {
        let d = f64::from(density);
        match shape {
            Shape::Sphere { radius } => {
                let r = f64::from(*radius);
                let mass = 4.0 / 3.0 * PI * r * r * r * d;
                let i = 0.4 * mass * r * r;
                Self::axial(mass, 0.0, i, i)
            }
            Shape::Capsule { half_height, radius } => {
                capsule(f64::from(*half_height), f64::from(*radius), d)
            }
            Shape::Box { half_extents } => {
                let h = DVec3::from(*half_extents);
                let mass = 8.0 * h.x * h.y * h.z * d;
                let (x, y, z) = (h.x * h.x, h.y * h.y, h.z * h.z);
                let third = mass / 3.0;
                let i = DVec3 { x: third * (y + z), y: third * (x + z), z: third * (x + y) };
                let inertia = Sym3::diagonal(i.single());
                Self { mass: single(mass), center: Vec3::ZERO, inertia }
            }
            Shape::Cylinder { half_height, radius } => {
                let r = f64::from(*radius);
                frustum(f64::from(*half_height), r, r, d)
            }
            Shape::Cone { half_height, radius_bottom, radius_top } => {
                let (bottom, top) = (f64::from(*radius_bottom), f64::from(*radius_top));
                frustum(f64::from(*half_height), bottom, top, d)
            }
            Shape::Hull(hull) => Self::of_hull(hull, density),
            Shape::HalfSpace { .. } => Self::default(),
            Shape::Mesh(mesh) => of_mesh(mesh, d),
        }
    }

    pub(crate) fn of_hull(hull: &Hull, density: f32) -> Self {
        let mut moments = Moments::about(hull.bounds().center());
        let v = hull.vertices();
        for f in 0..hull.face_count() {
            let face = hull.face(f);
            for k in 2..face.len() {
                let corner = |i: usize| v[usize::from(face[i])];
                moments.add(corner(0), corner(k - 1), corner(k));
            }
        }
        moments.finish(f64::from(density))
    }

    /// Mass properties of a body of revolution about y, with the center of mass at `y`.
    fn axial(mass: f64, y: f64, across: f64, along: f64) -> Self {
        let (across, along) = (single(across), single(along));
        Self {
            mass: single(mass),
            center: vec3(0.0, single(y), 0.0),
            inertia: Sym3::diagonal(vec3(across, along, across)),
        }
    }

    /// Mass properties of several solids as one rigid body, each with its pose in the body's frame.
    /// Overlaps count twice.
    #[must_use]
    pub fn combine(parts: &[(Pose, Self)]) -> Self {
        let mut mass = 0.0;
        let mut sum = DVec3::ZERO;
        for (pose, part) in parts {
            let m = f64::from(part.mass);
            mass += m;
            sum = sum + DVec3::from(pose.point(part.center)) * m;
        }
        if mass <= 0.0 {
            return Self::default();
        }
        let center = sum * (1.0 / mass);
        let mut inertia = Tensor::default();
        for (pose, part) in parts {
            inertia.add_rotated(pose, part.inertia);
            let arm = DVec3::from(pose.point(part.center)) - center;
            inertia.add_point(arm, f64::from(part.mass));
        }
        Self { mass: single(mass), center: center.single(), inertia: inertia.single() }
    }

    /// Mass properties of the same solid with another density, such that its mass is `mass` [kg].
    /// Without a mass to begin with, everything stays zero.
    #[must_use]
    pub fn scaled_to(self, mass: f32) -> Self {
        if self.mass <= 0.0 {
            return self;
        }
        Self { mass, center: self.center, inertia: self.inertia.scaled(mass / self.mass) }
    }
}

#[expect(clippy::cast_possible_truncation, reason = "rounding is what is asked for")]
fn single(x: f64) -> f32 {
    x as f32
}

fn capsule(h: f64, r: f64, density: f64) -> MassProperties {
    let tube = PI * r * r * 2.0 * h * density;
    let ends = 4.0 / 3.0 * PI * r * r * r * density;
    let along = tube * r * r / 2.0 + ends * 0.4 * r * r;
    // The mass center of a half ball lies 3/8 r from its flat side.
    let across = tube * (r * r / 4.0 + h * h / 3.0) + ends * (0.4 * r * r + h * h + 0.75 * h * r);
    MassProperties::axial(tube + ends, 0.0, across, along)
}

/// Cone frustum with radius R (1 - s) + r s over s = y/h from 0 to 1. It needs the integrals of the
/// squared radius, of s and s² times it, and of the radius's fourth power.
fn frustum(half_height: f64, bottom: f64, top: f64, density: f64) -> MassProperties {
    let h = 2.0 * half_height;
    let (rr, rs, ss) = (bottom * bottom, bottom * top, top * top);
    let mass = PI * h * density * (rr + rs + ss) / 3.0;
    if mass <= 0.0 {
        return MassProperties::default();
    }
    let first = PI * h * h * density * (rr + 2.0 * rs + 3.0 * ss) / 12.0;
    let second = PI * h * h * h * density * (rr + 3.0 * rs + 6.0 * ss) / 30.0;
    let along = PI * h * density * (rr * rr + rr * rs + rr * ss + rs * ss + ss * ss) / 10.0;
    let y = first / mass;
    let across = along / 2.0 + second - mass * y * y;
    MassProperties::axial(mass, y - half_height, across, along)
}

fn of_mesh(mesh: &Mesh, density: f64) -> MassProperties {
    let bounds = mesh.bounds();
    let mut moments = Moments::about(bounds.center());
    let (mut area, mut total) = (DVec3::ZERO, 0.0);
    for t in mesh.triangles() {
        let [a, b, c] = t.map(|i| mesh.vertices()[i as usize]);
        moments.add(a, b, c);
        let (a, b, c) = (DVec3::from(a), DVec3::from(b), DVec3::from(c));
        let side = (b - a).cross(c - a);
        area = area + side;
        total += side.length();
    }
    // The sides of a closed surface sum to zero area; a hole leaves its own area over.
    let open = area.length() > 1.0e-3 * total;
    let size = DVec3::from(bounds.max - bounds.min).length();
    // No real volume: a flat sheet, a double-sided one, or triangles of mixed winding.
    let empty = moments.volume.abs() <= 1.0e-6 * size * total;
    if open || empty { MassProperties::default() } else { moments.finish(density) }
}

/// Integrals of 1, x and x xᵀ over a volume, about a reference point.
struct Moments {
    reference: DVec3,
    volume: f64,
    first: DVec3,
    /// xx, yy, zz, xy, xz, yz.
    second: [f64; 6],
}

impl Moments {
    fn about(reference: Vec3) -> Self {
        let reference = DVec3::from(reference);
        Self { reference, volume: 0.0, first: DVec3::ZERO, second: [0.0; 6] }
    }

    /// Adds the tetrahedron of the reference point and a triangle, counter-clockwise seen from
    /// outside.
    /// With the corner sum s = a + b + c and D = det(a, b, c): V = D/6, first = D s/24,
    /// second = D (s sᵀ + a aᵀ + b bᵀ + c cᵀ)/120.
    fn add(&mut self, a: Vec3, b: Vec3, c: Vec3) {
        let [a, b, c] = [a, b, c].map(|p| DVec3::from(p) - self.reference);
        let det = a.cross(b).dot(c);
        let s = a + b + c;
        self.volume += det / 6.0;
        self.first = self.first + s * (det / 24.0);
        for p in [s, a, b, c] {
            let products = [p.x * p.x, p.y * p.y, p.z * p.z, p.x * p.y, p.x * p.z, p.y * p.z];
            for (sum, product) in self.second.iter_mut().zip(products) {
                *sum += product * (det / 120.0);
            }
        }
    }

    fn finish(self, density: f64) -> MassProperties {
        if self.volume.abs() <= 0.0 {
            return MassProperties::default();
        }
        // A surface turned inside out has all signs reversed.
        let k = if self.volume < 0.0 { -density } else { density };
        let mass = self.volume * k;
        let arm = self.first * (1.0 / self.volume);
        let [xx, yy, zz, xy, xz, yz] = self.second.map(|v| v * k);
        let mut inertia =
            Tensor { xx: yy + zz, yy: xx + zz, zz: xx + yy, xy: -xy, xz: -xz, yz: -yz };
        inertia.add_point(arm, -mass);
        MassProperties {
            mass: single(mass),
            center: (self.reference + arm).single(),
            inertia: inertia.single(),
        }
    }
}

/// An inertia tensor in double precision.
#[derive(Default)]
struct Tensor {
    xx: f64,
    yy: f64,
    zz: f64,
    xy: f64,
    xz: f64,
    yz: f64,
}

impl Tensor {
    /// Adds a point mass at `r`: m (r·r 1 - r rᵀ).
    fn add_point(&mut self, r: DVec3, mass: f64) {
        self.xx += mass * (r.y * r.y + r.z * r.z);
        self.yy += mass * (r.x * r.x + r.z * r.z);
        self.zz += mass * (r.x * r.x + r.y * r.y);
        self.xy -= mass * r.x * r.y;
        self.xz -= mass * r.x * r.z;
        self.yz -= mass * r.y * r.z;
    }

    /// Adds R I Rᵀ.
    fn add_rotated(&mut self, pose: &Pose, inertia: Sym3) {
        let i = inertia.to_mat3();
        let rotation = pose.rotation.to_mat3().transpose();
        // Rows of R, and I times them: entry (j, k) is row_j · I row_k.
        let rows = [rotation.x, rotation.y, rotation.z].map(DVec3::from);
        let [x, y, z] = [i.x, i.y, i.z].map(DVec3::from);
        let entry = |j: usize, k: usize| {
            let v = rows[k];
            rows[j].dot(DVec3 { x: x.dot(v), y: y.dot(v), z: z.dot(v) })
        };
        self.xx += entry(0, 0);
        self.yy += entry(1, 1);
        self.zz += entry(2, 2);
        self.xy += entry(0, 1);
        self.xz += entry(0, 2);
        self.yz += entry(1, 2);
    }

    fn single(&self) -> Sym3 {
        Sym3 {
            xx: single(self.xx),
            yy: single(self.yy),
            zz: single(self.zz),
            xy: single(self.xy),
            xz: single(self.xz),
            yz: single(self.yz),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::MassProperties;
    use crate::base::math::{Vec3, vec3};
    use crate::base::pose::Pose;
    use crate::base::quat::Quat;
    use crate::geometry::hull::Hull;
    use crate::geometry::mesh::Mesh;
    use crate::geometry::shape::Shape;
    use parry3d::math::Vector;
    use parry3d::shape::{Ball, Capsule, Cone, Cuboid, Cylinder, Shape as Reference};
    use std::sync::Arc;

    fn close(a: &MassProperties, b: &MassProperties) {
        let size = b.inertia.xx.abs() + b.inertia.yy.abs() + b.inertia.zz.abs();
        assert!((a.mass - b.mass).abs() <= 2e-6 * b.mass, "{a:?} {b:?}");
        assert!((a.center - b.center).length() <= 2e-6 * (1.0 + b.center.length()), "{a:?} {b:?}");
        let (i, k) = (a.inertia.to_mat3(), b.inertia.to_mat3());
        for (p, q) in [(i.x, k.x), (i.y, k.y), (i.z, k.z)] {
            assert!((p - q).length() <= 1e-5 * size, "{a:?} {b:?}");
        }
    }

    #[test]
    fn round_shapes_and_boxes_agree_with_parry() {
        let half = vec3(0.5, 1.0, 2.0);
        let pairs: [(Shape, Box<dyn Reference>); 5] = [
            (Shape::sphere(0.7), Box::new(Ball::new(0.7))),
            (Shape::capsule(0.8, 0.3), Box::new(Capsule::new_y(0.8, 0.3))),
            (Shape::box_half(half), Box::new(Cuboid::new(Vector::from(half.to_array())))),
            (Shape::cylinder(0.4, 1.5), Box::new(Cylinder::new(0.4, 1.5))),
            (Shape::cone(0.9, 0.6), Box::new(Cone::new(0.9, 0.6))),
        ];
        for (shape, reference) in pairs {
            let theirs = reference.mass_properties(800.0);
            let inertia = theirs.reconstruct_inertia_matrix();
            let diagonal = vec3(inertia.x_axis.x, inertia.y_axis.y, inertia.z_axis.z);
            let expected = MassProperties {
                mass: theirs.mass(),
                center: Vec3::from(theirs.local_com.to_array()),
                inertia: crate::base::sym3::Sym3::diagonal(diagonal),
            };
            close(&MassProperties::of(&shape, 800.0), &expected);
        }
    }

    #[test]
    fn a_truncated_cone_is_a_cone_less_its_tip_and_a_turned_one_is_its_mirror() {
        let cone = |half_height, radius_bottom, radius_top| {
            MassProperties::of(&Shape::Cone { half_height, radius_bottom, radius_top }, 3.0)
        };
        // Radius 2 at y = -2, 1 at 0, 0 at 2.
        let parts = [
            (Pose::at([0.0, -1.0, 0.0]), cone(1.0, 2.0, 1.0)),
            (Pose::at([0.0, 1.0, 0.0]), cone(1.0, 1.0, 0.0)),
        ];
        close(&MassProperties::combine(&parts), &cone(2.0, 2.0, 0.0));
        let flipped = Pose::new(Vec3::ZERO, Quat::from_axis_angle(Vec3::X, core::f32::consts::PI));
        close(&MassProperties::combine(&[(flipped, cone(1.0, 2.0, 0.5))]), &cone(1.0, 0.5, 2.0));
    }

    fn box_triangles(half: Vec3) -> (Vec<Vec3>, Vec<[u32; 3]>) {
        let hull = Hull::cuboid(half);
        let triangles = (0..hull.face_count()).flat_map(|f| {
            let face: Vec<u32> = hull.face(f).into_iter().map(u32::from).collect();
            [[face[0], face[1], face[2]], [face[0], face[2], face[3]]]
        });
        (hull.vertices().to_vec(), triangles.collect())
    }

    #[test]
    fn a_turned_box_as_hull_and_as_mesh_of_either_winding_has_the_boxs_inertia() {
        let half = vec3(0.5, 1.0, 2.0);
        let pose = Pose::new([3.0, -1.0, 20.0], Quat::from_axis_angle(vec3(1.0, 2.0, -1.0), 0.9));
        let expected =
            MassProperties::combine(&[(pose, MassProperties::of(&Shape::box_half(half), 5.0))]);
        let (vertices, mut triangles) = box_triangles(half);
        let vertices: Vec<Vec3> = vertices.into_iter().map(|v| pose.point(v)).collect();
        let hull = Hull::from_points(&vertices).unwrap();
        close(&MassProperties::of(&Shape::Hull(Arc::new(hull)), 5.0), &expected);
        for _ in 0..2 {
            let mesh = Mesh::new(vertices.clone(), triangles.clone()).unwrap();
            close(&MassProperties::of(&Shape::Mesh(Arc::new(mesh)), 5.0), &expected);
            triangles.iter_mut().for_each(|t| t.swap(0, 1));
        }
    }

    #[test]
    fn an_open_or_mixed_mesh_and_a_half_space_have_no_mass() {
        let (vertices, triangles) = box_triangles(Vec3::ONE);
        let mass = |t: Vec<[u32; 3]>| {
            let mesh = Mesh::new(vertices.clone(), t).unwrap();
            MassProperties::of(&Shape::Mesh(Arc::new(mesh)), 1.0)
        };
        let closed = mass(triangles.clone());
        assert!((closed.mass - 8.0).abs() < 1e-5);
        assert_eq!(mass(triangles[1..].to_vec()), MassProperties::default());
        let mut mixed = triangles;
        mixed[4].swap(0, 1);
        assert_eq!(mass(mixed), MassProperties::default());
        let ground = Shape::half_space(Vec3::Y, 0.0);
        assert_eq!(MassProperties::of(&ground, 1.0), MassProperties::default());
    }

    #[test]
    fn scaling_keeps_the_shape_of_the_inertia() {
        let ball = MassProperties::of(&Shape::sphere(0.5), 1000.0);
        let light = ball.scaled_to(2.0);
        assert!((light.mass - 2.0).abs() < 1e-9 && (light.inertia.xx - 0.2).abs() < 1e-6);
        assert_eq!(MassProperties::default().scaled_to(3.0), MassProperties::default());
        assert_eq!(MassProperties::combine(&[]), MassProperties::default());
    }
}
