//! The pull of the mouse on a body.

use drystone::query::{Inside, QueryFilter};
use drystone::{BodyId, BodyKind, Vec3, World};

use crate::history::Input;

/// Frequency of the spring between mouse and body [Hz].
const GRAB_HERTZ: f32 = 3.0;
/// Time in which the grip takes most of the turning from the body [s].
const GRIP_TIME: f32 = 0.3;

/// A body that the mouse holds.
#[derive(Clone, Copy, Debug)]
pub(super) struct Grab {
    pub(super) body: BodyId,
    /// Where on it [m, its frame].
    local: Vec3,
    /// Distance from the eye [m].
    pub(super) distance: f32,
    /// Where it is pulled [m, world].
    pub(super) target: Vec3,
}

impl Grab {
    /// Takes hold of the dynamic body on a ray: origin, unit direction [m, world].
    pub(super) fn of(world: &World, origin: Vec3, direction: Vec3) -> Option<Self> {
        let (id, point) = meet(world, origin, direction)?;
        let body = world.body(id).filter(|b| b.kind() == BodyKind::Dynamic)?;
        let local = body.pose().local_point(point);
        Some(Self { body: id, local, distance: (point - origin).length(), target: point })
    }

    /// From where on the body to where it is pulled [m, world].
    pub(super) fn line(&self, world: &World) -> Option<(Vec3, Vec3)> {
        Some((world.body(self.body)?.pose().point(self.local), self.target))
    }

    /// The force in a step of `dt` [s]: a critically damped spring, as strong as the point's
    /// effective mass bears at this step, and the body's weight.
    pub(super) fn pull(&self, world: &World, dt: f32) -> Option<Input> {
        let body = world.body(self.body)?;
        let at = body.pose().point(self.local);
        let arm = at - body.center_of_mass();
        let inertia = body.inertia();
        let least = inertia.xx.min(inertia.yy).min(inertia.zz).max(1.0e-12);
        let mass = 1.0 / (1.0 / body.mass().max(1.0e-9) + arm.length_squared() / least);
        // Explicit, so no faster than a quarter of the steps allows.
        let omega = (core::f32::consts::TAU * GRAB_HERTZ).min(0.5 / dt);
        let pulled = (self.target - at) * (omega * omega) - body.velocity_at(at) * (2.0 * omega);
        let longest = 400.0;
        let pulled = pulled * (longest / pulled.length().max(longest));
        let force = pulled * mass - world.config().gravity * body.mass();
        // Without friction in the grip the body would swing for ever.
        let calm = GRIP_TIME.max(2.0 * dt);
        let torque = inertia.mul(body.angular_velocity()) * -calm.recip();
        Some(Input::Force { body: self.body, force, at, torque })
    }
}

/// The body that a ray meets, and where [m, world].
pub(super) fn meet(world: &World, origin: Vec3, direction: Vec3) -> Option<(BodyId, Vec3)> {
    let delta = direction * 1.0e4;
    // A camera in a body sees the bodies before it.
    let outside = QueryFilter::default().with_inside(Inside::Ignore);
    let hit = world.query().cast_ray(origin, delta, outside).ok().flatten()?;
    Some((hit.body, hit.point))
}
