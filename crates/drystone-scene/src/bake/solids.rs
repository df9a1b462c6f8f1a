//! Triangles to look at for each kind of shape.

use drystone::math::trig;
use drystone::{Hull, Shape, Vec3, vec3};

/// Half the edge of the square that shows a half-space [m].
const GROUND: f32 = 100.0;
/// Corners around a round shape.
const AROUND: u16 = 32;
/// Rings from pole to equator of a ball.
const RINGS: u16 = 8;

/// A surface; without normals it is flat.
#[derive(Clone, Debug, Default)]
pub struct Surface {
    /// Places [m, frame of the shape].
    pub points: Vec<Vec3>,
    /// A unit normal for each place, or none.
    pub normals: Vec<Vec3>,
    /// Places by number, counterclockwise from outside.
    pub triangles: Vec<[u32; 3]>,
}

/// The surface of a shape in the shape's frame; of a half-space the square around the foot of its
/// normal, as if the normal were y and the offset 0.
#[must_use]
pub fn of(shape: &Shape) -> Surface {
    match shape {
        Shape::Sphere { radius } => revolve(&[arc(*radius, 0.0, -1.0, 1.0)]),
        Shape::Capsule { half_height, radius } => {
            let mut profile = arc(*radius, -half_height, -1.0, 0.0);
            profile.extend(arc(*radius, *half_height, 0.0, 1.0));
            revolve(&[profile])
        }
        Shape::Box { half_extents } => cuboid(*half_extents),
        Shape::Cylinder { half_height, radius } => frustum(*half_height, *radius, *radius),
        Shape::Cone { half_height, radius_bottom, radius_top } => {
            frustum(*half_height, *radius_bottom, *radius_top)
        }
        Shape::Hull(hull) => polytope(hull),
        Shape::HalfSpace { .. } => ground(),
        Shape::Mesh(mesh) => Surface {
            points: mesh.vertices().to_vec(),
            normals: Vec::new(),
            triangles: mesh.triangles().to_vec(),
        },
        _ => Surface::default(),
    }
}

/// A point of a profile: distance from the axis, height, and the normal in that plane.
type Profile = Vec<(f32, f32, f32, f32)>;

/// Part of a circle about (0, height): from `from` to `to` quarters above the equator.
fn arc(radius: f32, height: f32, from: f32, to: f32) -> Profile {
    let steps = if to - from > 1.5 { 2 * RINGS } else { RINGS };
    let point = |k: u16| {
        let quarter = from + (to - from) * f32::from(k) / f32::from(steps);
        let (s, c) = trig::sin_cos(quarter * core::f32::consts::FRAC_PI_2);
        // Poles exactly on the axis.
        let c = if c.abs() < 1.0e-6 { 0.0 } else { c };
        (radius * c, height + radius * s, c, s)
    };
    (0..=steps).map(point).collect()
}

/// Bottom, side and top of a cylinder or cone.
fn frustum(half: f32, bottom: f32, top: f32) -> Surface {
    let slope = vec3(2.0 * half, bottom - top, 0.0).normalize_or(Vec3::X);
    let mut profiles = vec![vec![(bottom, -half, slope.x, slope.y), (top, half, slope.x, slope.y)]];
    if bottom > 0.0 {
        profiles.push(vec![(0.0, -half, 0.0, -1.0), (bottom, -half, 0.0, -1.0)]);
    }
    if top > 0.0 {
        profiles.push(vec![(top, half, 0.0, 1.0), (0.0, half, 0.0, 1.0)]);
    }
    revolve(&profiles)
}

/// Profiles (from low to high, solid on the axis side) turned about y.
fn revolve(profiles: &[Profile]) -> Surface {
    let mut out = Surface::default();
    for profile in profiles {
        let base = u32::try_from(out.points.len()).unwrap_or(0);
        for (radius, height, across, along) in profile {
            for k in 0..=AROUND {
                let (s, c) =
                    trig::sin_cos(core::f32::consts::TAU * f32::from(k) / f32::from(AROUND));
                out.points.push(vec3(radius * c, *height, radius * s));
                out.normals.push(vec3(across * c, *along, across * s).normalize_or(Vec3::Y));
            }
        }
        let row = u32::from(AROUND) + 1;
        for (r, pair) in (0_u32..).zip(profile.windows(2)) {
            for k in 0..u32::from(AROUND) {
                let a = base + r * row + k;
                let (b, c, d) = (a + 1, a + row, a + row + 1);
                if pair[0].0 > 0.0 {
                    out.triangles.push([a, c, b]);
                }
                if pair[1].0 > 0.0 {
                    out.triangles.push([b, c, d]);
                }
            }
        }
    }
    out
}

fn cuboid(h: Vec3) -> Surface {
    let mut out = Surface::default();
    let faces = [
        (Vec3::X, Vec3::Y, Vec3::Z),
        (-Vec3::X, Vec3::Z, Vec3::Y),
        (Vec3::Y, Vec3::Z, Vec3::X),
        (-Vec3::Y, Vec3::X, Vec3::Z),
        (Vec3::Z, Vec3::X, Vec3::Y),
        (-Vec3::Z, Vec3::Y, Vec3::X),
    ];
    for (n, u, v) in faces {
        out.square((n.mul_each(h), u.mul_each(h), v.mul_each(h)), n);
    }
    out
}

fn ground() -> Surface {
    let mut out = Surface::default();
    out.square((Vec3::ZERO, Vec3::Z * GROUND, Vec3::X * GROUND), Vec3::Y);
    out
}

impl Surface {
    /// A rectangle: middle and half sides, whose cross product is along `normal`.
    fn square(&mut self, (middle, u, v): (Vec3, Vec3, Vec3), normal: Vec3) {
        let base = u32::try_from(self.points.len()).unwrap_or(0);
        self.points.extend([middle - u - v, middle + u - v, middle + u + v, middle - u + v]);
        self.normals.extend([normal; 4]);
        self.triangles.extend([[base, base + 1, base + 2], [base, base + 2, base + 3]]);
    }
}

fn polytope(hull: &Hull) -> Surface {
    let mut triangles = Vec::new();
    for f in 0..hull.planes().len() {
        let corners = hull.face(f);
        for k in 1..corners.len().saturating_sub(1) {
            triangles.push([corners[0], corners[k], corners[k + 1]].map(u32::from));
        }
    }
    Surface { points: hull.vertices().to_vec(), normals: Vec::new(), triangles }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::{Shape, Vec3, of};
    use drystone::Hull;

    #[test]
    fn surfaces_are_closed_and_face_outward() {
        let corners: Vec<Vec3> = (0..8_u8)
            .map(|i| Vec3::from([f32::from(i & 1), f32::from(i >> 1 & 1), f32::from(i >> 2 & 1)]))
            .collect();
        let hull = Shape::Hull(Arc::new(Hull::from_points(&corners).unwrap()));
        // Volume from the divergence theorem: right only if closed and turned outward.
        let pi = core::f32::consts::PI;
        let table = [
            (Shape::sphere(1.0), 4.0 / 3.0 * pi, 0.03),
            (Shape::capsule(0.5, 1.0), 7.0 / 3.0 * pi, 0.03),
            (Shape::box_half([1.0, 2.0, 3.0]), 48.0, 1e-5),
            (Shape::cylinder(1.0, 1.0), 2.0 * pi, 0.01),
            (Shape::cone(1.0, 1.0), 2.0 / 3.0 * pi, 0.01),
            (
                Shape::Cone { half_height: 0.5, radius_bottom: 1.0, radius_top: 0.5 },
                1.75 / 3.0 * pi,
                0.01,
            ),
            (hull, 1.0, 1e-5),
        ];
        for (shape, volume, tolerance) in table {
            let s = of(&shape);
            let mut sum = 0.0;
            for t in &s.triangles {
                let [a, b, c] = t.map(|i| s.points[i as usize]);
                sum += a.dot(b.cross(c)) / 6.0;
                if !s.normals.is_empty() {
                    let n = s.normals[t[0] as usize];
                    assert!((b - a).cross(c - a).dot(n) > 0.0, "{}", shape.kind());
                }
            }
            assert!(
                (sum - volume).abs() < tolerance * volume,
                "{}: {sum} for {volume}",
                shape.kind()
            );
        }
    }
}
