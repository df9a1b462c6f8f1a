//! Affine maps, their rotation and scale, and rotations between two others.

use drystone::math::{Mat3, trig};
use drystone::{Quat, Vec3, vec3};

/// A linear map and a translation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Affine {
    pub(crate) linear: Mat3,
    pub(crate) translation: Vec3,
}

impl Affine {
    pub(crate) fn point(&self, p: Vec3) -> Vec3 {
        self.linear * p + self.translation
    }

    pub(crate) fn compose(&self, inner: &Self) -> Self {
        Self { linear: self.linear * inner.linear, translation: self.point(inner.translation) }
    }
}

/// Some rotation near to a linear map: its axes made orthogonal one after the other.
pub(crate) fn nearest_rotation(m: Mat3) -> Quat {
    let x = m.x.normalize_or(Vec3::X);
    let y = (m.y - x * x.dot(m.y)).try_normalize().unwrap_or_else(|| x.any_perpendicular());
    Quat::from_mat3(Mat3 { x, y, z: x.cross(y) })
}

/// `linear` as rotation times scale: of all ways to choose the signs of the scale the one whose
/// rotation is closest to `turn`, the product of the nodes' own rotations. The third result says
/// that no rotation times scale gives `linear`.
pub(crate) fn split(linear: Mat3, turn: Quat) -> (Quat, Vec3, bool) {
    let axes = [linear.x, linear.y, linear.z];
    let lengths = axes.map(Vec3::length);
    let longest = lengths[0].max(lengths[1]).max(lengths[2]);
    let degenerate = lengths.iter().any(|&l| l <= 1.0e-6 * longest || l <= 1.0e-12);
    let mut rotation = turn;
    if !degenerate {
        let unit = nearest_rotation(linear).to_mat3();
        let mut best = -1.0;
        for (sx, sy) in [(1.0, 1.0), (-1.0, 1.0), (1.0, -1.0), (-1.0, -1.0)] {
            // The third axis follows from the first two.
            let x = unit.x * sx;
            let y = unit.y * sy;
            let q = Quat::from_mat3(Mat3 { x, y, z: x.cross(y) });
            let dot = q.x * turn.x + q.y * turn.y + q.z * turn.z + q.w * turn.w;
            if dot.abs() > best + 1.0e-4 {
                best = dot.abs();
                rotation = if dot < 0.0 { Quat::new(-q.x, -q.y, -q.z, -q.w) } else { q };
            }
        }
    }
    // If the nodes' own rotations explain the map, they are exact: keep their bits.
    let own = turn.to_mat3();
    let off = |r: &Mat3| {
        let rows = axes.map(|a| r.transpose_mul(a));
        let off = [rows[0].y, rows[0].z, rows[1].x, rows[1].z, rows[2].x, rows[2].y];
        off.iter().fold(0.0_f32, |m, v| m.max(v.abs()))
    };
    let tolerance = 1.0e-4 * longest;
    if off(&own) <= tolerance {
        rotation = turn;
    }
    let r = rotation.to_mat3();
    let scale = vec3(r.x.dot(linear.x), r.y.dot(linear.y), r.z.dot(linear.z));
    (rotation, scale, off(&r) > tolerance)
}

/// The cosine of half the angle between two rotations, with the sign of their hemisphere.
pub(crate) fn dot(a: Quat, b: Quat) -> f32 {
    a.x * b.x + a.y * b.y + a.z * b.z + a.w * b.w
}

/// Spherical interpolation, as viewers do it between two keys.
pub(crate) fn slerp(a: Quat, b: Quat, t: f32) -> Quat {
    let d = dot(a, b);
    let (d, s) = if d < 0.0 { (-d, -1.0) } else { (d, 1.0) };
    let (u, v) = if d > 0.9995 {
        (1.0 - t, t)
    } else {
        let angle = trig::acos(d);
        let k = 1.0 / trig::sin_cos(angle).0;
        (trig::sin_cos(angle * (1.0 - t)).0 * k, trig::sin_cos(angle * t).0 * k)
    };
    let v = v * s;
    Quat::new(u * a.x + v * b.x, u * a.y + v * b.y, u * a.z + v * b.z, u * a.w + v * b.w)
        .normalized()
}

#[cfg(test)]
mod tests {
    use super::{Mat3, Quat, split};
    use drystone::{Vec3, vec3};

    #[test]
    fn rotation_and_scale_come_apart_again_also_mirrored() {
        let turn = Quat::from_axis_angle(vec3(1.0, 2.0, -0.5), 1.1);
        let r = turn.to_mat3();
        for scale in [Vec3::ONE, vec3(2.0, -1.0, 0.5), vec3(-1.0, -1.0, -3.0), vec3(1.0, 0.0, 1.0)]
        {
            let m = Mat3 { x: r.x * scale.x, y: r.y * scale.y, z: r.z * scale.z };
            let (q, s, sheared) = split(m, turn);
            assert!((s - scale).length() < 1e-5 && !sheared, "{s:?}");
            assert!((q.rotate(Vec3::X) - r.x).length() < 1e-5);
        }
        let (_, _, sheared) =
            split(Mat3 { x: Vec3::X, y: vec3(0.5, 1.0, 0.0), z: Vec3::Z }, Quat::IDENTITY);
        assert!(sheared);
    }

    #[test]
    fn a_mirrored_parent_leaves_a_proper_rotation() {
        // Scale (-1, 1, 1) of the parent, then a turn about z in the child: the map is a turn the
        // other way with mirrored x.
        let turn = Quat::from_axis_angle(Vec3::Z, 0.4).to_mat3();
        let flip = Mat3::diagonal(vec3(-1.0, 1.0, 1.0));
        let m = flip * turn;
        let (q, s, sheared) = split(m, Quat::from_axis_angle(Vec3::Z, 0.4));
        let r = q.to_mat3();
        let back = Mat3 { x: r.x * s.x, y: r.y * s.y, z: r.z * s.z };
        assert!(!sheared && (back * vec3(1.0, 2.0, 3.0) - m * vec3(1.0, 2.0, 3.0)).length() < 1e-5);
    }
}
