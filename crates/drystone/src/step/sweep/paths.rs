//! Paths of bodies within the step.

use crate::base::math::Vec3;
use crate::base::pose::Pose;
use crate::base::sparse::Sparse;
use crate::geometry::toi::Motion;
use crate::state::bodies::body::Body;
use crate::state::bodies::{Bodies, Track};
use crate::state::bounds::Bounds;
use crate::state::shapes::Shapes;
use crate::step::context::StepContext;
use crate::step::finalize::max_moved;
use crate::step::notes::Flight;
use crate::step::reach::Need;

/// Moves a body to another pose, with its boxes in the tree.
pub(crate) fn put(
    ctx: &StepContext,
    row: u32,
    pose: Pose,
    bodies: &mut Bodies,
    shapes: &mut Shapes,
    bounds: &mut Bounds,
) {
    let body = bodies.at_mut(row);
    let (center, rotation) = (body.center, body.rotation);
    (body.center, body.rotation, body.room) = (pose.position, pose.rotation, 0.0);
    let moved = Track::at_least(max_moved(body, center, rotation) * ctx.per_track);
    let path = &mut bodies.tracks[row as usize].path;
    *path = path.wrapping_add(moved);
    for i in 0..bodies.at(row).ties.shapes.len() {
        let body = bodies.at(row);
        let shape = body.ties.shapes[i];
        if !shapes.at(shape).enabled {
            continue;
        }
        let need = Need::of_shape(shapes, shape, body, ctx);
        let fits = need.fits();
        if !shapes.at(shape).fat.contains(&fits) {
            let fat = need.with_room(&fits, body, ctx);
            bounds.replace(shape, fat, shapes);
        }
    }
}

/// Minimum motion of two bodies against each other for a test, as a part of the thinner one's half
/// thickness. With less motion, bodies that were apart overlap so little that a contact still finds
/// the correct side.
const NEARLY_STILL: f32 = 0.5;

/// Paths of all bodies. A fast body has its actual path, up to its present pose. Other bodies stand
/// at their final pose, since they moved less than contacts can resolve.
#[derive(Clone, Copy)]
pub(super) struct Paths<'a> {
    pub(super) ctx: &'a StepContext,
    pub(super) fast: &'a [Flight],
    /// Index of each body's flight.
    pub(super) flight_of: &'a Sparse,
    pub(super) bodies: &'a Bodies,
}

pub(super) const fn pose_of(body: &Body) -> Pose {
    Pose { position: body.center, rotation: body.rotation }
}

impl Paths<'_> {
    pub(super) fn flight(&self, row: u32) -> Option<&Flight> {
        self.fast.get(self.flight_of.get(row) as usize)
    }

    pub(super) fn path(&self, row: u32) -> Motion {
        let body = self.bodies.at(row);
        self.flight(row).map_or_else(
            || Motion::standing(pose_of(body)),
            |flight| {
                let from = Pose { position: flight.from, rotation: flight.stood };
                Motion::between(from, &pose_of(body), body.w * self.ctx.dt)
            },
        )
    }

    /// False if the bodies moved too little against each other to end deep in each other or past
    /// each other. This holds for most bodies that fall together, and needs no data of their
    /// shapes.
    pub(super) fn may_pass(&self, a: u32, b: u32) -> bool {
        let ((shift_a, swing_a), (shift_b, swing_b)) = (self.motion(a), self.motion(b));
        let [a, b] = [a, b].map(|row| self.bodies.at(row));
        let half = a.inner.min(b.inner);
        !((shift_b - shift_a).length() + swing_a + swing_b <= NEARLY_STILL * half)
    }

    /// Displacement of a body, and the maximum displacement of its points by rotation [m].
    fn motion(&self, row: u32) -> (Vec3, f32) {
        let Some(flight) = self.flight(row) else { return (Vec3::ZERO, 0.0) };
        let body = self.bodies.at(row);
        let shift = body.center - flight.from;
        let by_poses = max_moved(body, flight.from, flight.stood) - shift.length();
        (shift, by_poses.max(body.w.length() * (self.ctx.dt * body.extent)))
    }
}
