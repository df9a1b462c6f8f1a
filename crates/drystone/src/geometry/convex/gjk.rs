//! Distance of two convex sets given by support mappings [Gilbert88].
//!
//! The simplex is in double precision. Supports are f32 points, whose differences are so exact
//! there that a thin simplex needs none of the usual repairs.

use crate::base::math::Vec3;

/// A vector in double precision, for internal use in [`distance`] and `epa`.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Wide {
    pub(crate) x: f64,
    pub(crate) y: f64,
    pub(crate) z: f64,
}

impl Wide {
    pub(crate) fn of(v: Vec3) -> Self {
        Self { x: f64::from(v.x), y: f64::from(v.y), z: f64::from(v.z) }
    }

    #[expect(clippy::cast_possible_truncation, reason = "results are wanted in f32")]
    pub(crate) fn narrow(self) -> Vec3 {
        Vec3 { x: self.x as f32, y: self.y as f32, z: self.z as f32 }
    }

    pub(crate) fn dot(self, o: Self) -> f64 {
        self.x * o.x + self.y * o.y + self.z * o.z
    }

    pub(crate) fn minus(self, o: Self) -> Self {
        Self { x: self.x - o.x, y: self.y - o.y, z: self.z - o.z }
    }

    pub(crate) fn plus(self, o: Self) -> Self {
        Self { x: self.x + o.x, y: self.y + o.y, z: self.z + o.z }
    }

    pub(crate) fn times(self, s: f64) -> Self {
        Self { x: self.x * s, y: self.y * s, z: self.z * s }
    }

    pub(crate) fn cross(self, o: Self) -> Self {
        Self {
            x: self.y * o.z - self.z * o.y,
            y: self.z * o.x - self.x * o.z,
            z: self.x * o.y - self.y * o.x,
        }
    }
}

/// The closest points of two sets that do not touch.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Closest {
    /// Distance [m].
    pub(crate) distance: f32,
    pub(crate) point_a: Vec3,
    pub(crate) point_b: Vec3,
    /// Unit normal, from A to B.
    pub(crate) normal: Vec3,
}

/// Smooth sets converge linearly, in 20 to 30 rounds; polytopes take 3 to 8.
const MAX_ROUNDS: usize = 64;
/// Supports have the rounding of f32: below this fraction of their size a distance is noise.
const TOUCHING: f64 = 4.0e-7;
/// Remaining gain, relative to the squared distance, at which the search ends.
const GAP: f64 = 1.0e-9;

#[derive(Clone, Copy, Default)]
struct Corner {
    /// Point of A minus point of B.
    w: Wide,
    a: Vec3,
    b: Vec3,
    weight: f64,
}

#[derive(Default)]
struct Simplex {
    corners: [Corner; 4],
    count: usize,
}

/// Returns the closest points of two sets in a common frame, or `None` where they touch or overlap.
/// `start` is any guess of the direction from A to B.
pub(crate) fn distance(
    support_a: impl Fn(Vec3) -> Vec3,
    support_b: impl Fn(Vec3) -> Vec3,
    start: Vec3,
) -> Option<Closest> {
    let corner = |d: Vec3| {
        let (a, b) = (support_a(d), support_b(-d));
        Corner { w: Wide::of(a).minus(Wide::of(b)), a, b, weight: 1.0 }
    };
    let first = corner(start.normalize_or(Vec3::Y));
    let mut simplex = Simplex { count: 1, ..Simplex::default() };
    simplex.corners[0] = first;
    let mut v = first.w;
    let mut size = v.dot(v);
    for _ in 0..MAX_ROUNDS {
        let square = v.dot(v);
        // Also ends a search with numbers that are not finite.
        if !(square > TOUCHING * TOUCHING * size && square > 1.0e-30) {
            return None;
        }
        let new = corner(v.times(-1.0 / square.sqrt()).narrow());
        let known = simplex.corners[..simplex.count].iter().any(|c| c.w == new.w);
        if known || square - v.dot(new.w) <= GAP * square {
            break;
        }
        let weights = simplex.weights_with(new)?;
        let next = simplex.point(&weights);
        if next.dot(next) >= square {
            break;
        }
        let reach = new.w.dot(new.w);
        size = if reach > size { reach } else { size };
        simplex.keep(&weights);
        v = next;
    }
    let length = v.dot(v).sqrt();
    let (mut a, mut b) = (Wide::default(), Wide::default());
    for c in &simplex.corners[..simplex.count] {
        a = a.plus(Wide::of(c.a).times(c.weight));
        b = b.plus(Wide::of(c.b).times(c.weight));
    }
    #[expect(clippy::cast_possible_truncation, reason = "results are wanted in f32")]
    let distance = length as f32;
    let normal = v.times(-1.0 / length).narrow().try_normalize()?;
    Some(Closest { distance, point_a: a.narrow(), point_b: b.narrow(), normal })
}

impl Simplex {
    /// Stores one more corner behind the others, not yet counted, and returns the weights of the
    /// point closest to the origin; `None` if the origin is inside.
    fn weights_with(&mut self, new: Corner) -> Option<[f64; 4]> {
        self.corners[self.count] = new;
        let w = |i: usize| self.corners[i].w;
        Some(match self.count {
            0 => [1.0, 0.0, 0.0, 0.0],
            1 => {
                let s = on_segment(w(0), w(1));
                [s[0], s[1], 0.0, 0.0]
            }
            2 => {
                let t = on_triangle(w(0), w(1), w(2));
                [t[0], t[1], t[2], 0.0]
            }
            _ => on_tetrahedron(&[w(0), w(1), w(2), w(3)])?,
        })
    }

    /// Returns the point with these weights of the corners.
    fn point(&self, weights: &[f64; 4]) -> Wide {
        let mut point = Wide::default();
        for (corner, weight) in self.corners.iter().zip(weights) {
            if *weight > 0.0 {
                point = point.plus(corner.w.times(*weight));
            }
        }
        point
    }

    /// Keeps the corners with positive weights.
    fn keep(&mut self, weights: &[f64; 4]) {
        self.count = 0;
        for (i, weight) in weights.iter().enumerate() {
            if *weight > 0.0 {
                self.corners[self.count] = Corner { weight: *weight, ..self.corners[i] };
                self.count += 1;
            }
        }
    }
}

/// Weights of the point of segment `ab` closest to the origin.
fn on_segment(a: Wide, b: Wide) -> [f64; 2] {
    let ab = b.minus(a);
    let length = ab.dot(ab);
    let t = -a.dot(ab);
    if t <= 0.0 || length <= 0.0 {
        return [1.0, 0.0];
    }
    if t >= length {
        return [0.0, 1.0];
    }
    [1.0 - t / length, t / length]
}

/// Weights of the point of triangle `abc` closest to the origin, by Voronoi regions.
fn on_triangle(a: Wide, b: Wide, c: Wide) -> [f64; 3] {
    let (ab, ac) = (b.minus(a), c.minus(a));
    let (d1, d2) = (-ab.dot(a), -ac.dot(a));
    if d1 <= 0.0 && d2 <= 0.0 {
        return [1.0, 0.0, 0.0];
    }
    let (d3, d4) = (-ab.dot(b), -ac.dot(b));
    if d3 >= 0.0 && d4 <= d3 {
        return [0.0, 1.0, 0.0];
    }
    let (d5, d6) = (-ab.dot(c), -ac.dot(c));
    if d6 >= 0.0 && d5 <= d6 {
        return [0.0, 0.0, 1.0];
    }
    let vc = d1 * d4 - d3 * d2;
    if vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0 {
        let s = on_segment(a, b);
        return [s[0], s[1], 0.0];
    }
    let vb = d5 * d2 - d1 * d6;
    if vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0 {
        let s = on_segment(a, c);
        return [s[0], 0.0, s[1]];
    }
    let va = d3 * d6 - d5 * d4;
    if va <= 0.0 && d4 - d3 >= 0.0 && d5 - d6 >= 0.0 {
        let s = on_segment(b, c);
        return [0.0, s[0], s[1]];
    }
    let k = 1.0 / (va + vb + vc);
    [va * k, vb * k, vc * k]
}

/// Weights of the point of a tetrahedron closest to the origin; `None` if the origin is inside.
fn on_tetrahedron(w: &[Wide; 4]) -> Option<[f64; 4]> {
    // Each face, and the corner opposite to it.
    const FACES: [[usize; 4]; 4] = [[0, 1, 2, 3], [0, 2, 3, 1], [0, 3, 1, 2], [1, 3, 2, 0]];
    let mut best = None;
    let mut minimum = f64::INFINITY;
    for [i, j, k, across] in FACES {
        let n = w[j].minus(w[i]).cross(w[k].minus(w[i]));
        let origin_side = -n.dot(w[i]);
        let across_side = n.dot(w[across].minus(w[i]));
        if origin_side * across_side > 0.0 {
            continue;
        }
        let t = on_triangle(w[i], w[j], w[k]);
        let p = w[i].times(t[0]).plus(w[j].times(t[1])).plus(w[k].times(t[2]));
        if p.dot(p) < minimum {
            minimum = p.dot(p);
            let mut weights = [0.0; 4];
            (weights[i], weights[j], weights[k]) = (t[0], t[1], t[2]);
            best = Some(weights);
        }
    }
    best
}

#[cfg(test)]
mod tests {
    use super::distance;
    use crate::base::math::{Vec3, vec3};
    use crate::base::pose::Pose;
    use crate::base::quat::Quat;

    fn corner(half: Vec3) -> impl Fn(Vec3) -> Vec3 {
        move |d| {
            let pick = |d: f32, h: f32| if d < 0.0 { -h } else { h };
            vec3(pick(d.x, half.x), pick(d.y, half.y), pick(d.z, half.z))
        }
    }

    #[test]
    fn boxes_of_every_size_are_measured_to_a_part_in_ten_thousand() {
        // A second box, turned by 45° about z, near a face, edge and corner of a box at 0.
        let turn = Quat::from_axis_angle(Vec3::Z, core::f32::consts::FRAC_PI_4);
        for size in [0.1_f32, 1.0, 10.0, 100.0] {
            for other in [0.1_f32, 1.0, 10.0, 100.0] {
                for gap in [0.01, 0.1, 1.0] {
                    let gap = gap * size;
                    let reach = other * 2.0_f32.sqrt();
                    let b = Pose::new([0.3 * size, size + gap + reach, 0.0], turn);
                    let found = distance(
                        corner(Vec3::splat(size)),
                        |d| b.point(corner(Vec3::splat(other))(b.local_direction(d))),
                        b.position,
                    )
                    .unwrap();
                    let scale = if size > other { size } else { other };
                    assert!((found.distance - gap).abs() < 1.0e-4 * gap + 1.0e-6 * scale);
                    assert!((found.normal - Vec3::Y).length() < 1.0e-4 * (1.0 + scale / gap));
                    assert!((found.point_a.y - size).abs() < 1.0e-5 * scale);
                }
            }
        }
    }

    #[test]
    fn sets_that_overlap_or_touch_have_no_distance() {
        let cube = || corner(Vec3::ONE);
        for x in [0.0, 0.5, 1.9, 2.0] {
            let p = vec3(x, 0.3, 0.1);
            assert_eq!(distance(cube(), |d| cube()(d) + p, p), None);
        }
        let far = vec3(3.0, 3.0, 3.0);
        let found = distance(cube(), |d| cube()(d) + far, -far).unwrap();
        assert!((found.distance - 3.0_f32.sqrt()).abs() < 1.0e-6);
        assert_eq!((found.point_a, found.point_b), (Vec3::ONE, Vec3::splat(2.0)));
    }

    #[test]
    fn numbers_that_are_not_finite_have_no_distance() {
        for x in [f32::NAN, f32::INFINITY] {
            let p = vec3(x, 0.0, 0.0);
            let found = distance(|_| Vec3::ZERO, |_| p, p);
            assert!(found.is_none_or(|c| c.normal.is_finite()), "{found:?}");
        }
    }
}
