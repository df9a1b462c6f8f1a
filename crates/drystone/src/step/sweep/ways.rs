//! How bodies moved in the step.

use crate::base::math::Vec3;
use crate::base::pose::Pose;
use crate::base::sparse::Sparse;
use crate::geometry::toi::Way;
use crate::state::bodies::{Bodies, Body, Track};
use crate::state::bounds::Bounds;
use crate::state::shapes::Shapes;
use crate::step::context::StepContext;
use crate::step::finalize::most_moved;
use crate::step::notes::Flight;
use crate::step::reach::Need;

/// Puts a body elsewhere than where it came to.
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
    let moved = Track::at_least(most_moved(body, center, rotation) * ctx.per_track);
    let way = &mut bodies.tracks[row as usize].way;
    *way = way.wrapping_add(moved);
    for i in 0..bodies.at(row).shapes.len() {
        let body = bodies.at(row);
        let shape = body.shapes[i];
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

/// Two that move less against each other than this part of the thinner one's half thickness, and were apart, are not so deep
/// in each other that a contact does not know on which side the other is.
const NEARLY_STILL: f32 = 0.5;

/// The ways of all bodies: of those that are fast as they went, up to where they are now. Others stand where they
/// ended: they moved less than contacts bear.
#[derive(Clone, Copy)]
pub(super) struct Ways<'a> {
    pub(super) ctx: &'a StepContext,
    pub(super) fast: &'a [Flight],
    /// Number of each body's flight.
    pub(super) flight_of: &'a Sparse,
    pub(super) bodies: &'a Bodies,
}

pub(super) const fn pose_of(body: &Body) -> Pose {
    Pose { position: body.center, rotation: body.rotation }
}

impl Ways<'_> {
    pub(super) fn flight(&self, row: u32) -> Option<&Flight> {
        self.fast.get(self.flight_of.get(row) as usize)
    }

    pub(super) fn way(&self, row: u32) -> Way {
        let body = self.bodies.at(row);
        self.flight(row).map_or_else(
            || Way::standing(pose_of(body)),
            |flight| {
                let from = Pose { position: flight.from, rotation: flight.stood };
                Way::between(from, &pose_of(body), body.w * self.ctx.dt)
            },
        )
    }

    /// False if they moved too little against each other to end deep in each other or past each other: that is true of
    /// most that fall together, and told before anything is known of their shapes.
    pub(super) fn may_pass(&self, a: u32, b: u32) -> bool {
        let ((shift_a, swing_a), (shift_b, swing_b)) = (self.motion(a), self.motion(b));
        let [a, b] = [a, b].map(|row| self.bodies.at(row));
        let half = a.inner.min(b.inner);
        !((shift_b - shift_a).length() + swing_a + swing_b <= NEARLY_STILL * half)
    }

    /// By how much a body moved, and how far turns moved a point of it, at most [m].
    fn motion(&self, row: u32) -> (Vec3, f32) {
        let Some(flight) = self.flight(row) else { return (Vec3::ZERO, 0.0) };
        let body = self.bodies.at(row);
        let shift = body.center - flight.from;
        let by_poses = most_moved(body, flight.from, flight.stood) - shift.length();
        (shift, by_poses.max(body.w.length() * (self.ctx.dt * body.extent)))
    }
}
