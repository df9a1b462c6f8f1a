//! A convex polyhedron cut into Voronoi cells.
//!
//! The cell of a site is the part of the polyhedron that remains after a cut, for every other site,
//! along the plane half way between the two. All in double precision. A corner within [`ON_PLANE`]
//! of a cut counts as on it, for both cells, so that cells share their faces and nothing is lost
//! between them. Sites are processed from near to far; a cell is complete when the next site is
//! more than twice as far as the cell reaches [Rycroft09].

use std::sync::Arc;

use super::hull::{Hull, HullError};
use crate::base::double::{DVec3, greater};
use crate::base::math::Vec3;

/// Maximum distance from a cut that counts as on it, relative to the polyhedron's extent.
const ON_PLANE: f64 = 1.0e-9;

/// Maximum number of sites. The time for cells near each other grows as the square of their number.
pub(crate) const MAX_SITES: usize = 1024;

/// A piece of a hull.
#[derive(Clone, Debug)]
pub struct HullPiece {
    /// Hull of the piece, relative to its own center of mass.
    pub hull: Arc<Hull>,
    /// Its center of mass [m, frame of the hull that was cut].
    pub center: Vec3,
    /// Volume of the cell [m³]; the volumes of all pieces sum to that of the hull. The volume of
    /// `hull` differs slightly, since its corners are rounded to `f32`.
    pub volume: f64,
    /// Index of its site.
    pub site: usize,
}

/// Reasons why a hull cannot be cut.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum CutError {
    /// There are no sites, or more than 1024; the number given.
    Sites(usize),
    /// A coordinate of a site is infinite, NaN or beyond 1e7 m; its index.
    Site(usize),
    /// The minimum volume is negative or not finite.
    LeastVolume(f64),
    /// A piece has no hull in f32.
    Hull(HullError),
}

impl core::fmt::Display for CutError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self {
            Self::Sites(n) => {
                write!(f, "the number of sites must be from 1 to {MAX_SITES} (got {n})")
            }
            Self::Site(i) => write!(f, "site {i} is not finite or beyond 1e7 m"),
            Self::LeastVolume(v) => {
                write!(f, "the least volume must be a finite number of at least 0 (got {v})")
            }
            Self::Hull(e) => write!(f, "a piece has no hull: {e}"),
        }
    }
}

impl core::error::Error for CutError {}

impl Hull {
    /// Cuts the hull into the Voronoi cells of `sites` [m, local]: each point belongs to its
    /// nearest site. The pieces share their faces, do not overlap and leave nothing over.
    ///
    /// Sites may lie outside. A site is left out if its cell is empty, smaller than `min_volume`
    /// [m³], or too thin for a hull, and so is a second site at the same position. Its cell then
    /// goes to its neighbors. The pieces are sorted by site; there is at least one.
    ///
    /// # Errors
    /// See [`CutError`].
    pub fn cut(&self, sites: &[Vec3], min_volume: f64) -> Result<Vec<HullPiece>, CutError> {
        if sites.is_empty() || sites.len() > MAX_SITES {
            return Err(CutError::Sites(sites.len()));
        }
        let far = |p: &Vec3| !(p.abs().max_element() <= 1.0e7 && p.is_finite());
        if let Some(i) = sites.iter().position(far) {
            return Err(CutError::Site(i));
        }
        if !(min_volume >= 0.0 && min_volume.is_finite()) {
            return Err(CutError::LeastVolume(min_volume));
        }
        let places: Vec<DVec3> = sites.iter().map(|p| DVec3::from(*p)).collect();
        Cutter::new(Polyhedron::of(self), places).pieces(min_volume)
    }
}

/// A cell, and the sites whose planes cut it.
struct Cell {
    shape: Polyhedron,
    volume: f64,
    center: DVec3,
    neighbors: Vec<usize>,
}

/// The cells of the remaining sites.
struct Cutter {
    whole: Polyhedron,
    sites: Vec<DVec3>,
    is_left: Vec<bool>,
    /// `None`: the cell is empty, or is yet to be computed.
    cells: Vec<Option<Cell>>,
}

impl Cutter {
    fn new(whole: Polyhedron, sites: Vec<DVec3>) -> Self {
        let n = sites.len();
        let mut cutter =
            Self { whole, sites, is_left: vec![true; n], cells: Vec::with_capacity(n) };
        for site in 0..n {
            let cell = cutter.cell(site);
            cutter.cells.push(cell);
        }
        cutter
    }

    /// Returns the pieces; leaves out the sites whose pieces are too small or have no hull.
    fn pieces(mut self, min_volume: f64) -> Result<Vec<HullPiece>, CutError> {
        loop {
            let mut smallest: Option<(f64, usize)> = None;
            for (site, cell) in self.cells.iter().enumerate() {
                if let Some(cell) = cell
                    && smallest.is_none_or(|(minimum, _)| cell.volume < minimum)
                {
                    smallest = Some((cell.volume, site));
                }
            }
            let refused = match smallest {
                Some((volume, site)) if volume <= min_volume => (site, HullError::Flat(0.0)),
                _ => match self.hulls() {
                    Ok(pieces) => return Ok(pieces),
                    Err(refused) => refused,
                },
            };
            // The last site has the whole hull.
            if self.is_left.iter().filter(|left| **left).count() == 1 {
                return Err(CutError::Hull(refused.1));
            }
            self.leave_out(refused.0);
        }
    }

    /// Returns the hulls of the cells; or a site whose cell has none, and the reason.
    fn hulls(&self) -> Result<Vec<HullPiece>, (usize, HullError)> {
        let mut pieces = Vec::new();
        for (site, cell) in self.cells.iter().enumerate() {
            let Some(Cell { shape, volume, center, .. }) = cell else { continue };
            let corners: Vec<Vec3> =
                shape.vertices.iter().map(|v| (*v - *center).single()).collect();
            let hull = Hull::from_points(&corners).map_err(|e| (site, e))?;
            let (hull, center) = (Arc::new(hull), center.single());
            pieces.push(HullPiece { hull, center, volume: *volume, site });
        }
        Ok(pieces)
    }

    /// Gives a site's cell to its neighbors.
    fn leave_out(&mut self, site: usize) {
        self.is_left[site] = false;
        self.cells[site] = None;
        for other in 0..self.sites.len() {
            let stays = self.cells[other].as_ref().is_some_and(|c| !c.neighbors.contains(&site));
            if self.is_left[other] && !stays {
                self.cells[other] = self.cell(other);
            }
        }
    }

    /// Returns the Voronoi cell of a site; `None` if it is empty.
    fn cell(&self, site: usize) -> Option<Cell> {
        let own = self.sites[site];
        let mut others: Vec<(f64, usize)> = (0..self.sites.len())
            .filter(|other| *other != site && self.is_left[*other])
            .map(|other| ((self.sites[other] - own).length(), other))
            .collect();
        others.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        let tiny = ON_PLANE * self.whole.extent;
        let mut shape = self.whole.clone();
        let mut reach = shape.reach(own);
        let mut neighbors = Vec::new();
        for (distance, other) in others {
            if distance > 2.0 * reach {
                break;
            }
            if distance <= tiny {
                // Two sites at one position: the first has the cell.
                if other < site {
                    return None;
                }
                continue;
            }
            let normal = (self.sites[other] - own) * (1.0 / distance);
            let middle = (self.sites[other] + own) * 0.5;
            match shape.cut(normal, normal.dot(middle), tiny) {
                Left::All => {}
                Left::Part => {
                    reach = shape.reach(own);
                    neighbors.push(other);
                }
                Left::Nothing => return None,
            }
        }
        let (volume, center) = shape.volume();
        Some(Cell { shape, volume, center, neighbors })
    }
}

/// A convex polyhedron.
#[derive(Clone, Debug, Default)]
pub(crate) struct Polyhedron {
    vertices: Vec<DVec3>,
    /// Corners of each face, counter-clockwise seen from outside.
    faces: Vec<Vec<usize>>,
    extent: f64,
}

/// Result of a cut.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Left {
    All,
    Part,
    Nothing,
}

impl Polyhedron {
    pub(crate) fn of(hull: &Hull) -> Self {
        let vertices: Vec<DVec3> = hull.vertices().iter().map(|v| DVec3::from(*v)).collect();
        let faces = (0..hull.face_count())
            .map(|f| hull.face(f).into_iter().map(usize::from).collect())
            .collect();
        let size = hull.bounds().max - hull.bounds().min;
        Self { vertices, faces, extent: f64::from(size.max_element()) }
    }

    /// Maximum distance of a corner from a point.
    fn reach(&self, from: DVec3) -> f64 {
        self.vertices.iter().map(|v| (*v - from).length()).fold(0.0, greater)
    }

    /// Removes the part beyond the plane `normal · p = offset`; corners within `tiny` of it count
    /// as on it.
    fn cut(&mut self, normal: DVec3, offset: f64, tiny: f64) -> Left {
        let heights: Vec<f64> = self.vertices.iter().map(|v| normal.dot(*v) - offset).collect();
        let side = |i: usize| -> i8 { i8::from(heights[i] > tiny) - i8::from(heights[i] < -tiny) };
        let count = heights.len();
        if !(0..count).any(|i| side(i) > 0) {
            return Left::All;
        }
        if !(0..count).any(|i| side(i) < 0) {
            return Left::Nothing;
        }
        // New corners by their edge, lower vertex number first: both faces find the same corner.
        let mut new: Vec<((usize, usize), usize)> = Vec::new();
        let mut faces: Vec<Vec<usize>> = Vec::with_capacity(self.faces.len() + 1);
        for face in &self.faces {
            let mut kept: Vec<usize> = Vec::with_capacity(face.len() + 1);
            for (k, &a) in face.iter().enumerate() {
                let b = face[(k + 1) % face.len()];
                if side(a) <= 0 {
                    kept.push(a);
                }
                if side(a) * side(b) < 0 {
                    let edge = (a.min(b), a.max(b));
                    let known = new.iter().find(|(e, _)| *e == edge).map(|(_, i)| *i);
                    kept.push(known.unwrap_or_else(|| {
                        let (p, q) = (self.vertices[edge.0], self.vertices[edge.1]);
                        let t = heights[edge.0] / (heights[edge.0] - heights[edge.1]);
                        self.vertices.push(p + (q - p) * t);
                        new.push((edge, self.vertices.len() - 1));
                        self.vertices.len() - 1
                    }));
                }
            }
            // A face that only touches the plane is part of the cut's own face.
            if kept.len() >= 3 && kept.iter().any(|i| *i < count && side(*i) < 0) {
                faces.push(kept);
            }
        }
        let mut rim: Vec<usize> = faces.iter().flatten().copied().collect();
        rim.sort_unstable();
        rim.dedup();
        rim.retain(|i| *i >= count || side(*i) == 0);
        self.faces = faces;
        if rim.len() >= 3 {
            self.close(normal, rim);
        }
        self.forget_unused();
        if self.faces.len() < 4 { Left::Nothing } else { Left::Part }
    }

    /// Adds the face of a cut, with its corners in counter-clockwise order about the normal.
    fn close(&mut self, normal: DVec3, rim: Vec<usize>) {
        #[expect(clippy::cast_precision_loss, reason = "few corners")]
        let share = 1.0 / rim.len() as f64;
        let middle = rim.iter().fold(DVec3::ZERO, |s, i| s + self.vertices[*i]) * share;
        let (u, v) = across(normal);
        let mut turns: Vec<(f64, usize)> = rim
            .into_iter()
            .map(|i| {
                let p = self.vertices[i] - middle;
                (turn(u.dot(p), v.dot(p)), i)
            })
            .collect();
        turns.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        self.faces.push(turns.into_iter().map(|(_, i)| i).collect());
    }

    fn forget_unused(&mut self) {
        let mut number = vec![usize::MAX; self.vertices.len()];
        let mut kept = Vec::with_capacity(self.vertices.len());
        for i in self.faces.iter_mut().flatten() {
            if number[*i] == usize::MAX {
                number[*i] = kept.len();
                kept.push(self.vertices[*i]);
            }
            *i = number[*i];
        }
        self.vertices = kept;
    }

    /// Volume [m³] and center: sums over the tetrahedra between one corner and the triangles of
    /// the faces.
    pub(crate) fn volume(&self) -> (f64, DVec3) {
        let Some(&from) = self.vertices.first() else { return (0.0, DVec3::ZERO) };
        let (mut volume, mut first) = (0.0, DVec3::ZERO);
        for face in &self.faces {
            let p = |k: usize| self.vertices[face[k]] - from;
            for k in 2..face.len() {
                let (a, b, c) = (p(0), p(k - 1), p(k));
                let six_dof = a.cross(b).dot(c);
                volume += six_dof / 6.0;
                first = first + (a + b + c) * (six_dof / 24.0);
            }
        }
        if volume > 0.0 { (volume, from + first * (1.0 / volume)) } else { (0.0, from) }
    }
}

/// Two directions perpendicular to a unit vector n, with u × v = n (right-handed).
pub(crate) fn across(n: DVec3) -> (DVec3, DVec3) {
    let unit = |x: f64, y: f64, z: f64| DVec3 { x, y, z };
    let (x, y, z) = (n.x.abs(), n.y.abs(), n.z.abs());
    let axis = if x <= y && x <= z {
        unit(1.0, 0.0, 0.0)
    } else if y <= z {
        unit(0.0, 1.0, 0.0)
    } else {
        unit(0.0, 0.0, 1.0)
    };
    let u = axis - n * n.dot(axis);
    let u = u * (1.0 / u.length());
    (u, n.cross(u))
}

/// Grows from 0 to 4 with the angle of (x, y), so that sorting by angle needs no trigonometry.
pub(crate) fn turn(x: f64, y: f64) -> f64 {
    let size = x.abs() + y.abs();
    if size <= 0.0 {
        return 0.0;
    }
    let part = y / size;
    if x < 0.0 {
        2.0 - part
    } else if y < 0.0 {
        4.0 + part
    } else {
        part
    }
}

#[cfg(test)]
mod tests {
    use super::{CutError, Polyhedron};
    use crate::base::double::DVec3;
    use crate::base::math::{Vec3, vec3};
    use crate::base::random::Random;
    use crate::geometry::hull::Hull;
    use crate::geometry::mass::MassProperties;

    #[expect(clippy::cast_possible_truncation, reason = "any number will do")]
    fn points(random: &mut Random, n: usize, half: Vec3) -> Vec<Vec3> {
        let mut one = |h: f32| (2.0 * random.unit() - 1.0) as f32 * h;
        (0..n).map(|_| vec3(one(half.x), one(half.y), one(half.z))).collect()
    }

    /// Checks that the pieces together have the volume, center and inertia of the hull.
    fn is_a_partition(hull: &Hull, sites: &[Vec3], minimum: f64) -> usize {
        let pieces = hull.cut(sites, minimum).unwrap();
        let whole = MassProperties::of_hull(hull, 1.0);
        let cells: f64 = pieces.iter().map(|p| p.volume).sum();
        let exact = Polyhedron::of(hull).volume().0;
        // A face with more than three corners is flat only up to the rounding of its hull. Its
        // volume depends on its triangulation, which a cut changes. The bounding box has more
        // surface than the hull.
        let corners = |f: usize| hull.face(f).into_iter().map(|v| hull.vertices()[usize::from(v)]);
        let off =
            |f: usize| corners(f).map(|v| hull.planes()[f].distance(v).abs()).fold(0.0, f32::max);
        let bend = (0..hull.face_count()).map(off).fold(0.0, f32::max);
        let box_size = hull.bounds().max - hull.bounds().min;
        let sides =
            2.0 * (box_size.x * box_size.y + box_size.y * box_size.z + box_size.z * box_size.x);
        let allowed = 1.0e-9 * exact + f64::from(bend * sides);
        assert!((cells - exact).abs() < allowed, "{cells} {exact} {allowed}");
        let mut parts = Vec::new();
        for piece in &pieces {
            assert!(piece.volume > minimum);
            let mut own = MassProperties::of_hull(&piece.hull, 1.0);
            own.center += piece.center;
            parts.push((crate::base::pose::Pose::IDENTITY, own));
        }
        let sum = MassProperties::combine(&parts);
        let size = (hull.bounds().max - hull.bounds().min).max_element();
        assert!((sum.mass - whole.mass).abs() < 1.0e-5 * whole.mass, "{sum:?} {whole:?}");
        assert!((sum.center - whole.center).length() < 1.0e-5 * size, "{sum:?} {whole:?}");
        let (i, k) = (sum.inertia.to_mat3(), whole.inertia.to_mat3());
        for (p, q) in [(i.x, k.x), (i.y, k.y), (i.z, k.z)] {
            assert!((p - q).length() < 1.0e-5 * whole.mass * size * size, "{sum:?} {whole:?}");
        }
        pieces.len()
    }

    #[test]
    fn cells_of_any_sites_divide_boxes_and_hulls_without_rest() {
        let mut random = Random::new(7);
        for round in 0..40 {
            let half = vec3(0.5, 1.0 + 0.1 * round as f32, 0.05 + 0.02 * round as f32);
            let sites = points(&mut random, 1 + 3 * round, half);
            assert!(is_a_partition(&Hull::cuboid(half), &sites, 0.0) <= sites.len());
            let hull = Hull::from_points(&points(&mut random, 30, half)).unwrap();
            is_a_partition(&hull, &sites, 0.0);
            // Some sites are far outside.
            let sites = points(&mut random, 20, half * 4.0);
            is_a_partition(&hull, &sites, 1.0e-3 * f64::from(hull.volume()));
        }
    }

    #[test]
    fn a_grid_of_sites_cuts_a_cube_into_equal_cubes() {
        // All cuts go through corners of other cells: every degenerate case at once.
        let mut sites = Vec::new();
        for i in 0..64_u8 {
            let at = |bits: u8| f32::from(i >> bits & 3) * 0.5 - 0.75;
            sites.push(vec3(at(0), at(2), at(4)));
        }
        let cube = Hull::cuboid(Vec3::ONE);
        assert_eq!(is_a_partition(&cube, &sites, 0.0), 64);
        for piece in cube.cut(&sites, 0.0).unwrap() {
            assert!((piece.volume - 0.125).abs() < 1e-12, "{}", piece.volume);
            assert_eq!((piece.hull.face_count(), piece.hull.vertices().len()), (6, 8));
        }
    }

    #[test]
    fn equal_flat_and_far_sites_are_left_out_and_bad_ones_refused() {
        let cube = Hull::cuboid(Vec3::ONE);
        let here = vec3(0.3, 0.1, 0.0);
        let pieces = cube.cut(&[here, here, -here, here], 0.0).unwrap();
        assert_eq!(pieces.iter().map(|p| p.site).collect::<Vec<_>>(), [0, 2]);
        // A slice of a millionth of a meter has no hull: its neighbor gets it.
        let thin = [vec3(1.0 - 1e-6, 0.0, 0.0), vec3(1.0, 0.0, 0.0), Vec3::ZERO];
        let pieces = cube.cut(&thin, 0.0).unwrap();
        assert!(pieces.len() <= 3 && !pieces.is_empty());
        let one = cube.cut(&[vec3(100.0, 0.0, 0.0)], 0.0).unwrap();
        assert!((one[0].volume - 8.0).abs() < 1e-12);
        // Cells smaller than the minimum go to their neighbors, up to the whole.
        assert_eq!(cube.cut(&[here, -here], 5.0).unwrap().len(), 1);
        assert_eq!(cube.cut(&[], 0.0).unwrap_err(), CutError::Sites(0));
        assert_eq!(cube.cut(&vec![here; 5000], 0.0).unwrap_err(), CutError::Sites(5000));
        let bad = [here, vec3(f32::NAN, 0.0, 0.0)];
        assert_eq!(cube.cut(&bad, 0.0).unwrap_err(), CutError::Site(1));
        assert!(matches!(cube.cut(&[here], -1.0).unwrap_err(), CutError::LeastVolume(_)));
    }

    #[test]
    fn a_cut_through_corners_and_edges_keeps_a_closed_surface() {
        let half = 0.5_f64.sqrt();
        let normals = [
            DVec3 { x: half, y: half, z: 0.0 },
            DVec3 { x: half, y: 0.0, z: -half },
            DVec3 { x: 1.0, y: 0.0, z: 0.0 },
        ];
        for n in normals {
            let mut a = Polyhedron::of(&Hull::cuboid(Vec3::ONE));
            let mut b = a.clone();
            a.cut(n, 0.0, 1e-9);
            b.cut(-n, 0.0, 1e-9);
            let (a, b) = (a.volume().0, b.volume().0);
            assert!((a - 4.0).abs() < 1e-12 && (b - 4.0).abs() < 1e-12, "{a} {b}");
        }
    }
}
