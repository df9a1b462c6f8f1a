//! Queries of a world, and of shapes without one: rays, shape casts, nearest shapes, overlaps. The
//! manual: [queries](crate::manual::queries).
// Sibling of step: it never writes.

pub(crate) mod audit;
pub(crate) mod cast;
pub(crate) mod filter;
pub(crate) mod nearest;
pub(crate) mod overlap;
pub(crate) mod pair;
pub(crate) mod particles;
pub(crate) mod ray;
pub(crate) mod shape;
pub(crate) mod stiffness;
pub(crate) mod why_awake;

pub use self::cast::{Motion, ShapeHit, ShapeQuery};
pub use self::filter::{BodyKinds, Inside};
pub use self::nearest::NearestShape;
pub use self::pair::{CastHit, ClosestPoints, ShapeContact, ShapeContactPoint};
pub use self::ray::{RayHit, RayQuery};

use std::panic::resume_unwind;

use smallvec::SmallVec;

pub use self::filter::QueryFilter;
use crate::base::aabb::Aabb;
use crate::base::math::{Vec3, greater};
use crate::base::pose::Pose;
use crate::base::simd::wide::SimdLevel;
use crate::base::threads::checked::{Checked, Claims};
use crate::base::threads::jobs::{Executor, Jobs};
use crate::geometry::approach::{self, ALONG, Sliding};
use crate::geometry::shape::Shape;
use crate::geometry::solid::Solid;
use crate::state::def::{DefError, position, unit};
use crate::state::shapes::ShapeRow;
use crate::state::tables::Tables;

/// Relative rounding error of positions and displacements: two f32 roundings for each of two
/// bodies.
const ROUNDING: f32 = 2.4e-7;

/// Rows of candidates; short lists need no heap memory.
type Rows = SmallVec<[u32; 32]>;

/// Queries of the world in its current state: rays, shape casts, nearest shapes, overlaps.
///
/// Each takes a [`QueryFilter`], or a [`Filter`](crate::Filter) alone. Sensors are seen only where
/// the filter includes them. Queries never see disabled shapes, shapes of disabled bodies, or
/// bodies out of the simulation. The manual: [queries](crate::manual::queries).
#[derive(Clone, Copy, Debug)]
pub struct Query<'w> {
    tables: &'w Tables,
    executor: &'w dyn Executor,
    level: SimdLevel,
}

impl<'w> Query<'w> {
    pub(crate) const fn new(
        tables: &'w Tables,
        executor: &'w dyn Executor,
        level: SimdLevel,
    ) -> Self {
        Self { tables, executor, level }
    }

    fn pose(&self, shape: &ShapeRow) -> Pose {
        self.tables.bodies.at(shape.body).pose().compose(&shape.local)
    }

    /// Calls `visit` with each shape that the filter sees and whose bounding box in the trees
    /// overlaps `bounds`, until `visit` returns false.
    fn each_near(
        &self,
        bounds: &Aabb,
        filter: &QueryFilter<'_>,
        mut visit: impl FnMut(u32) -> bool,
    ) {
        let mut goes_on = true;
        for tree in [&self.tables.bounds.fixed, &self.tables.bounds.moving] {
            if goes_on {
                tree.query(bounds, |row| {
                    goes_on = !filter.sees(self.tables, row) || visit(row);
                    goes_on
                });
            }
        }
    }

    /// Returns the shapes of [`Self::each_near`], sorted by row.
    fn candidates(&self, bounds: &Aabb, filter: &QueryFilter<'_>) -> Rows {
        let mut found = Rows::new();
        self.each_near(bounds, filter, |row| {
            found.push(row);
            true
        });
        found.sort_unstable();
        found
    }

    /// Finds the surfaces that a shape touches at its start and slides along, and returns the
    /// displacement along all of them.
    ///
    /// The cast keeps the shape above these surfaces. It therefore hits only what stands out of
    /// them, not what is flush with them, such as the next tile or triangle.
    fn sliding(
        &self,
        solid: &Solid,
        pose: &Pose,
        delta: Vec3,
        filter: &QueryFilter<'_>,
    ) -> (Sliding, Vec3) {
        let far = greater(pose.position.abs().max_element(), delta.abs().max_element());
        let slack = ROUNDING * far;
        let (mut displacement, mut off) = (delta, Vec3::ZERO);
        let mut normals: SmallVec<[Vec3; 8]> = SmallVec::new();
        for row in self.candidates(&solid.aabb(pose).grown(slack), filter) {
            let other = self.tables.shapes.at(row);
            let at = self.pose(other);
            approach::touched(&other.solid, solid, &at.relative(pose), slack, |normal| {
                let normal = at.direction(normal);
                if normal.dot(delta) >= -ALONG * delta.length() {
                    normals.push(normal);
                }
            });
        }
        for normal in &normals {
            off += *normal * greater(1.0 - normal.dot(off), 0.0);
            displacement += *normal * greater(-normal.dot(displacement), 0.0);
        }
        // Two surfaces that face each other leave no room to be above both.
        if normals.iter().any(|normal| normal.dot(off) < 0.5) {
            return (Sliding::default(), delta);
        }
        (Sliding { off, minimum: 2.0 * slack }, displacement)
    }

    /// Runs `work` with the threads of the world's executor. A panic of the executor resumes after
    /// the work is done.
    fn with_jobs(&self, work: impl FnOnce(&Jobs<'_>)) {
        let mut claims = Claims::default();
        work(&Checked::new(self.executor, &claims).jobs());
        if let Some(payload) = claims.take_panic() {
            resume_unwind(payload);
        }
    }
}

/// Checks a convex shape and its pose, and returns the solid.
fn convex(shape: &Shape, pose: &Pose) -> Result<Solid, DefError> {
    placed("pose", shape, pose)?;
    if matches!(shape, Shape::Mesh(_) | Shape::HalfSpace { .. }) {
        return Err(DefError::unsuitable("shape", shape.kind(), "a convex shape"));
    }
    Ok(Solid::of(shape))
}

/// Checks a shape and its pose.
fn placed(field: &str, shape: &Shape, pose: &Pose) -> Result<(), DefError> {
    shape.validate()?;
    position("position", pose.position).map_err(|e| e.within(field))?;
    unit("rotation", pose.rotation).map_err(|e| e.within(field))
}
