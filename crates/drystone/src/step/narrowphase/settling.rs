//! Settling: moves the rest surface of a contact whose compression under load is large for bodies
//! as thin as its own.
//!
//! A soft contact is a spring, whose depth follows from the load and the substep: 52 cards of 3 mm
//! would be pressed to two thirds of their height. With a stiffer spring a tall stack swings, for
//! one sweep does not spread its load. So the spring stays, and its rest surface moves out slowly
//! until the depth is within the limit for the thickness. See docs/decisions/040-thin-stacks.md.

use crate::base::math::Vec3;
use crate::state::bodies::body::Body;
use crate::state::contacts::{Contact, Point, Traits};
use crate::step::context::softness::Softness;
use crate::step::context::{GIVES, StepContext};

/// Speed that an impulse of 1 N s along `n`, at `r` from the center, gives a body there [1/kg].
pub(crate) fn answer(body: &Body, r: Vec3, n: Vec3) -> f32 {
    if !body.is_dynamic() {
        return 0.0;
    }
    let arm = r.cross(n);
    (1.0 / body.inertia.mass + arm.dot(body.turn_by(arm))) / body.history.inertia_factor.max(1.0)
}

/// Time in which the excess depth falls to a third, for each weight of the bodies that the contact
/// carries [s], and the bounds of that time [s]. A stack swings slower the higher it is, one of
/// fifty once in 0.6 s, and settling must not excite it.
const TIME: f32 = 0.04;

const TIMES: [f32; 2] = [0.05, 4.0];

/// The surface stays while the bodies move against each other faster than this multiple of its own
/// speed.
const STIRS: f32 = 2.0;

/// Maximum shift of the surface, in half thicknesses of the thinner body. Beyond it a stack swings
/// without end, and a wedged body is pressed without end.
const MAX: f32 = 4.0;

/// Springs of substeps shorter than this [s] are stiffer than those of a usual step.
const USUAL: f32 = 1.0 / 480.0;

/// A thin body that is placed is compressed by less than this multiple of its final depth.
const FEW: f32 = 4.0;

/// Upper bound on a point's speed for an impulse there, in multiples of that of the centers: more
/// than at a cube's corner, 7, and at a rod's end, 4.
const LEVER: f32 = 8.0;

/// Moves the rest surface of the contact's spring.
pub(super) fn settle(ctx: &StepContext, contact: &mut Contact, bodies: [&Body; 2]) {
    let [a, b] = bodies;
    let maximum = ctx.max_give(bodies);
    let soft = spring(ctx, bodies);
    let inverse = |body: &Body| if body.is_dynamic() { 1.0 / body.inertia.mass } else { 0.0 };
    let load = contact.points().iter().map(|p| p.impulse).fold(0.0, f32::max);
    let speed = load * (inverse(a) + inverse(b)) * LEVER;
    let is_thick = ctx.rest_offset <= maximum && !(speed * soft.impulse > maximum * soft.rate);
    let settled = contact.settled();
    if is_thick && settled == 0.0 || !ctx.is_soft || contact.sensor || !(soft.rate > 0.0) {
        return;
    }
    if is_thick && !contact.traits.any(Traits::SETTLES) {
        // A body was placed here and has not moved. A point moves at most twice as much under a
        // load as the centers do.
        let (mut load, mut lowest) = (0.0, f32::MAX);
        for p in contact.points() {
            (load, lowest) = (load + p.impulse, p.separation.min(lowest));
        }
        let gives = 2.0 * load * (inverse(a) + inverse(b)) * ctx.impulse_scale;
        if lowest <= ctx.rest_offset && settled * soft.rate <= gives * soft.impulse {
            return;
        }
    }
    let is_another = (ctx.impulse_scale - 1.0).abs() > 1.0e-6;
    if settled != 0.0 && is_another && is_still(contact, bodies, ctx.gravity.length() * ctx.h) {
        // Substeps of another length have another spring, which the body must not follow.
        return;
    }
    let (mut next, mut goes) = (0.0, false);
    if !contact.traits.may_soften()
        && let Some(Pressed { separation, speed, answer }) = pressed(ctx, contact, bodies)
    {
        // The rest offset is smaller for thin bodies too.
        let rest = ctx.rest_offset.min(maximum);
        let excess = separation - separation.clamp(rest - maximum, rest);
        let weights = answer / (ctx.gravity.length() * ctx.h);
        let time = (TIME * weights).clamp(TIMES[0], TIMES[1]);
        next = settled;
        if speed.abs() * time <= STIRS * excess.abs() {
            // Springs get stiffer where time slows down; a body that was placed before stays where
            // it is.
            let shorter = (USUAL / ctx.h).max(1.0);
            let gives = answer * (soft.impulse / soft.rate) * (shorter * shorter);
            let gives = gives.min(MAX / GIVES * maximum);
            next = (settled - excess * (ctx.dt / time).min(0.5)).min(gives).max(-ctx.rest_offset);
        }
        // A contact far from its final depth must not sleep.
        goes = excess.abs() > maximum && (next - settled).abs() * time > 0.1 * maximum * ctx.dt;
    }
    contact.set_settled(next);
    if goes != contact.traits.any(Traits::SETTLES) {
        contact.traits = contact.traits.with(Traits::SETTLES, goes);
    }
}

/// Sets the rest surface of a contact that was placed with its load, so that the spring holds the
/// body where it is.
pub(super) fn settle_at_once(ctx: &StepContext, contact: &mut Contact, bodies: [&Body; 2]) {
    let maximum = ctx.max_give(bodies);
    let soft = spring(ctx, bodies);
    let Some(Pressed { separation, answer, .. }) = pressed(ctx, contact, bodies) else { return };
    if contact.traits.may_soften() || !(soft.rate > 0.0) {
        return;
    }
    let gives = answer * (soft.impulse / soft.rate);
    let gives = gives.min(MAX / GIVES * maximum);
    if ctx.rest_offset > maximum {
        // For a thin body only a large compression is removed: a body that is to topple stands as
        // it would by itself.
        if gives > FEW * maximum {
            contact.set_settled(gives - 0.5 * maximum);
        }
        return;
    }
    let settled = separation - ctx.rest_offset + gives;
    contact.set_settled(settled.min(gives).max(-ctx.rest_offset));
}

/// True if the bodies of a contact move against each other more slowly than this at all of its
/// points [m/s].
pub(super) fn is_still(contact: &Contact, [a, b]: [&Body; 2], minimum: f32) -> bool {
    let speed = |p: &Point| b.velocity_at(contact.r_b(p)) - a.velocity_at(p.r_a);
    contact.points().iter().all(|p| speed(p).length() < minimum)
}

/// Softness of the contact's spring.
fn spring<'a>(ctx: &'a StepContext, [a, b]: [&Body; 2]) -> &'a Softness {
    if a.is_dynamic() && b.is_dynamic() { &ctx.soft } else { &ctx.soft_fixed }
}

/// Means over the points of a contact, weighted by their impulses.
struct Pressed {
    /// [m]
    separation: f32,
    /// Speed at which the points separate [m/s].
    speed: f32,
    /// Speed at which their impulses alone would separate them in a substep [m/s].
    answer: f32,
}

/// `None` if no point has an impulse.
fn pressed(ctx: &StepContext, contact: &Contact, [a, b]: [&Body; 2]) -> Option<Pressed> {
    let (normal, offset) = (contact.normal, contact.offset);
    let mut sum = 0.0_f32;
    let mut of = Pressed { separation: 0.0, speed: 0.0, answer: 0.0 };
    for p in contact.points() {
        let r_b = p.r_a - offset;
        sum += p.impulse;
        of.separation += p.impulse * p.separation;
        of.speed += p.impulse * normal.dot(b.velocity_at(r_b) - a.velocity_at(p.r_a));
        of.answer += p.impulse * (p.impulse * (answer(a, p.r_a, normal) + answer(b, r_b, normal)));
    }
    let mean = |x: f32| x / sum;
    let Pressed { separation, speed, answer } = of;
    (sum > 0.0).then(|| Pressed {
        separation: mean(separation),
        speed: mean(speed),
        answer: mean(answer) * ctx.impulse_scale,
    })
}
