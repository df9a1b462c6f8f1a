//! Mass properties of meshes at a density of 1, from their own triangles.

use drystone::geometry::MassProperties;
use drystone::math::Sym3;
use drystone::{Vec3, vec3};

use super::mesh::Triangles;

/// How the triangles of a mesh make a mass, by MuJoCo's names.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Filling {
    /// The volume inside, with its sign: exact for closed, oriented surfaces.
    Exact,
    /// Volumes of the tetrahedra from the surface's center, all counted as positive: for surfaces
    /// that are open or not oriented. Too much for those that their center does not see.
    Legacy,
    /// A skin of mass 1 per area.
    Shell,
}

/// A point or vector in double precision.
type Point = [f64; 3];

fn minus(a: Point, b: Point) -> Point {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

fn cross(a: Point, b: Point) -> Point {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

fn dot(a: Point, b: Point) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// Sums over parts: mass, its first moments, and its second moments xx, yy, zz, xy, xz, yz.
#[derive(Clone, Copy, Debug, Default)]
struct Sums {
    mass: f64,
    first: Point,
    second: [f64; 6],
}

const PAIRS: [(usize, usize); 6] = [(0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2)];

impl Sums {
    /// Adds a simplex of this mass whose corners are these and, if it is a tetrahedron, the origin.
    /// The second moment of a simplex with n corners is m/(n (n+1)) (Σ pᵢ pᵢᵀ + s sᵀ), s = Σ pᵢ.
    fn add(&mut self, mass: f64, corners: [Point; 3], with_origin: bool) {
        let n = if with_origin { 4.0 } else { 3.0 };
        let sum: Point = core::array::from_fn(|k| corners.iter().map(|p| p[k]).sum());
        self.mass += mass;
        for k in 0..3 {
            self.first[k] += mass * sum[k] / n;
        }
        for (second, (i, j)) in self.second.iter_mut().zip(PAIRS) {
            let products: f64 = corners.iter().map(|p| p[i] * p[j]).sum();
            *second += mass / (n * (n + 1.0)) * (products + sum[i] * sum[j]);
        }
    }

    /// The mass, its center from `origin`, and its inertia about it; nothing without a mass.
    #[expect(clippy::cast_possible_truncation, reason = "the engine's numbers have 32 bits")]
    fn properties(&self, origin: Point) -> Option<MassProperties> {
        let c = self.first.map(|x| x / self.mass);
        let mut central = [0.0; 6];
        for ((out, second), (i, j)) in central.iter_mut().zip(self.second).zip(PAIRS) {
            *out = second - self.mass * c[i] * c[j];
        }
        let [xx, yy, zz, xy, xz, yz] = central;
        let own = MassProperties {
            mass: self.mass as f32,
            center: vec3(
                (origin[0] + c[0]) as f32,
                (origin[1] + c[1]) as f32,
                (origin[2] + c[2]) as f32,
            ),
            inertia: Sym3 {
                xx: (yy + zz) as f32,
                yy: (xx + zz) as f32,
                zz: (xx + yy) as f32,
                xy: -xy as f32,
                xz: -xz as f32,
                yz: -yz as f32,
            },
        };
        let is_solid = own.mass > 0.0 && own.center.is_finite() && own.inertia.is_finite();
        is_solid.then_some(own)
    }
}

impl Triangles {
    /// Mass properties at a density of 1; `None` if the surface has no volume (or no area).
    pub(crate) fn mass(&self, filling: Filling) -> Option<MassProperties> {
        let exact = |v: Vec3| v.to_array().map(f64::from);
        let at = |i: u32| self.points.get(i as usize).copied().map(exact);
        let corners: Vec<[Point; 3]> = self
            .triangles
            .iter()
            .filter_map(|[a, b, c]| Some([at(*a)?, at(*b)?, at(*c)?]))
            .collect();
        let double_area = |[a, b, c]: [Point; 3]| {
            let normal = cross(minus(b, a), minus(c, a));
            dot(normal, normal).sqrt()
        };
        // All is counted from the center of the surface, where numbers are small.
        let mut shell = Sums::default();
        for t in &corners {
            shell.add(0.5 * double_area(*t), *t, false);
        }
        let origin = shell.first.map(|x| x / shell.mass.max(f64::MIN_POSITIVE));
        let sum_about = |origin: Point| {
            let mut sums = Sums::default();
            for t in &corners {
                let t = t.map(|p| minus(p, origin));
                let volume = dot(t[0], cross(t[1], t[2])) / 6.0;
                match filling {
                    Filling::Exact => sums.add(volume, t, true),
                    Filling::Legacy => sums.add(volume.abs(), t, true),
                    Filling::Shell => sums.add(0.5 * double_area(t), t, false),
                }
            }
            sums
        };
        let mut sums = sum_about(origin);
        if filling == Filling::Legacy {
            // Counted twice, as MuJoCo does: the second time from the center that the first time
            // gave, which stays the center.
            let center = core::array::from_fn(|k| origin[k] + sums.first[k] / sums.mass);
            sums = Sums { first: [0.0; 3], ..sum_about(center) };
            return sums.properties(center);
        }
        if sums.mass < 0.0 {
            // Oriented inwards, or mirrored by a negative scale.
            sums.mass = -sums.mass;
            sums.first = sums.first.map(|x| -x);
            sums.second = sums.second.map(|x| -x);
        }
        sums.properties(origin)
    }
}

#[cfg(test)]
mod tests {
    use super::{Filling, Triangles};
    use drystone::vec3;

    /// A cube of edge 2 at (5, 0, 0) has 8, its inertia 8·4/6; its skin 24 and Σ over faces.
    #[test]
    fn a_cube_has_the_mass_of_the_textbook() {
        let points = (0..8_u8)
            .map(|i| {
                let side = |bit: u8| if i & bit == 0 { -1.0 } else { 1.0 };
                vec3(5.0 + side(1), side(2), side(4))
            })
            .collect();
        let faces =
            [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
        let triangles = faces.iter().flat_map(|[a, b, c, d]| [[*a, *b, *c], [*a, *c, *d]]);
        let mut cube = Triangles { points, triangles: triangles.collect() };
        for filling in [Filling::Exact, Filling::Legacy] {
            let m = cube.mass(filling).unwrap();
            assert!((m.mass - 8.0).abs() < 1.0e-5 && (m.center.x - 5.0).abs() < 1.0e-5, "{m:?}");
            assert!((m.inertia.xx - 16.0 / 3.0).abs() < 1.0e-5 && m.inertia.xy.abs() < 1.0e-5);
        }
        let skin = cube.mass(Filling::Shell).unwrap();
        // Two faces of 4 (2²/6), four of 4 (2²/12 + 1).
        assert!((skin.mass - 24.0).abs() < 1.0e-5);
        assert!((skin.inertia.zz - (2.0 * 8.0 / 3.0 + 16.0 * 4.0 / 3.0)).abs() < 1.0e-4);
        cube.triangles.iter_mut().for_each(|t| t.swap(0, 1));
        assert!(
            (cube.mass(Filling::Exact).unwrap().mass - 8.0).abs() < 1.0e-5,
            "turned inside out"
        );
        cube.triangles.clear();
        assert!(cube.mass(Filling::Exact).is_none());
    }
}
