//! Freezing: bodies that have come to rest stop one by one, and are immovable until something changes the
//! forces on them [Schmidl04].
//!
//! A body freezes when its energy was below a tenth of what gravity gives it in a step for as long as sleep asks
//! for (a throw is that slow at its top for two steps at most), something carries it, and all that carries it is
//! fixed, frozen or freezes with it. It wakes when an awake body meets it, and when the force or the torque of
//! its contacts is no longer what it was: a support went away, a load came or went, something pushes. Bodies
//! with joints do not freeze: they sleep by islands, as all do.

use crate::base::math::Vec3;
use crate::state::bodies::{Body, NONE};
use crate::state::config::SleepConfig;
use crate::state::sets::Sets;
use crate::step::context::StepContext;
use crate::step::solver::integrate;

/// Energy below which a body is at rest, in parts of what gravity gives it in a step. With all of it, the
/// paper's, a box that tips over its edge froze on the way.
const ENERGY: f32 = 0.1;

/// Part of its weight that must be carried, and by which the force on it may change while it is frozen (and by
/// which times its size the torque may).
const CARRIED: f32 = 0.5;
const CHANGE: f32 = 0.3;

/// Memory kept from step to step.
#[derive(Clone, Debug, Default)]
pub(super) struct Scratch {
    rows: Vec<u32>,
    /// Of each body, whether it may freeze in this step.
    may: Vec<bool>,
}

/// True if the body is at rest by its energy; `speed` is the world's and the least limit.
pub(crate) fn rests(ctx: &StepContext, speed: f32, body: &Body) -> bool {
    let w = (body.rotation * body.principal).unrotate(body.w);
    let m = body.moments;
    let turning = w.x * w.x * m.x + w.y * w.y * m.y + w.z * w.z * m.z;
    let gravity = ENERGY * ctx.gravity.length_squared() * (ctx.dt * ctx.dt);
    let least = body.still_speed(speed);
    body.v.length_squared() + turning / body.mass < gravity.max(least * least)
}

/// Force [N] and torque [N m, about the center] of the contacts on a body in the last step.
fn load(ctx: &StepContext, row: u32, sets: &Sets<'_>) -> (Vec3, Vec3) {
    let (mut force, mut torque) = (Vec3::ZERO, Vec3::ZERO);
    for (contact, side) in sets.contacts.of_body(sets.bodies, row) {
        let c = sets.contacts.at(contact);
        if c.count == 0 || c.sensor {
            continue;
        }
        let (sign, share) = (if side == 0 { -1.0 } else { 1.0 }, 1.0 / f32::from(c.count));
        for p in c.points() {
            let r = if side == 0 { p.r_a } else { c.r_b(p) };
            let j = (c.normal * p.impulse + c.tangent_impulse * share) * sign;
            force += j;
            torque += r.cross(j);
        }
    }
    (force * (1.0 / ctx.h), torque * (1.0 / ctx.h))
}

/// Wakes frozen bodies on which the load has changed. Only those that touch an awake one can have changed.
pub(super) fn thaw(ctx: &StepContext, config: &SleepConfig, sets: &mut Sets<'_>, s: &mut Scratch) {
    s.rows.clear();
    for [a, b] in sets.contacts.awake_pairs() {
        for row in [a, b] {
            let body = sets.bodies.at(row);
            if !body.active() && body.is_dynamic() && !body.faulted {
                s.rows.push(row);
            }
        }
    }
    s.rows.sort_unstable();
    s.rows.dedup();
    for i in 0..s.rows.len() {
        let row = s.rows[i];
        let (force, torque) = load(ctx, row, sets);
        let (old_force, old_torque) = sets.bodies.frozen_load(row);
        let body = sets.bodies.at(row);
        let most = CHANGE * weight(ctx, config, body);
        let changed = (force - old_force).length() > most
            || (torque - old_torque).length() > most * body.extent;
        // What fell asleep with its island may have had no load to compare with.
        if changed || !is_carried(ctx, CARRIED - CHANGE, row, sets) {
            sets.wake(row);
        }
    }
}

/// Weight of a body [N]; without gravity the force that would give it the speed of sleep in a step.
fn weight(ctx: &StepContext, config: &SleepConfig, body: &Body) -> f32 {
    let acceleration = integrate::acceleration(ctx, body).length();
    body.mass * acceleration.max(body.still_speed(config.speed) / ctx.dt)
}

/// Freezes what rests.
pub(super) fn freeze(
    ctx: &StepContext,
    config: &SleepConfig,
    sets: &mut Sets<'_>,
    s: &mut Scratch,
) {
    s.may.clear();
    s.may.resize(sets.bodies.rows.slot_count(), false);
    s.rows.clear();
    for row in &sets.bodies.awake {
        let body = sets.bodies.at(*row);
        let still = body.is_dynamic() && body.can_sleep && body.still_time >= config.time;
        if still && body.joints.is_empty() && is_carried(ctx, CARRIED, *row, sets) {
            s.may[*row as usize] = true;
            s.rows.push(*row);
        }
    }
    // What stands on something that moves does not freeze, nor what stands on that.
    loop {
        let before = s.rows.len();
        let Scratch { rows, may } = &mut *s;
        rows.retain(|row| {
            let stays = supports(ctx, *row, sets).all(|other| {
                let body = sets.bodies.at(other);
                !body.active() || may[other as usize]
            });
            may[*row as usize] = stays;
            stays
        });
        if rows.len() == before {
            break;
        }
    }
    for i in 0..s.rows.len() {
        let row = s.rows[i];
        let load = load(ctx, row, sets);
        sets.bodies.set_frozen_load(row, load);
    }
    sets.rest(&s.rows);
}

/// True if contacts carry at least this part of its weight.
fn is_carried(ctx: &StepContext, part: f32, row: u32, sets: &Sets<'_>) -> bool {
    let body = sets.bodies.at(row);
    let pull = integrate::acceleration(ctx, body);
    let Some(down) = pull.try_normalize() else { return true };
    let (force, _) = load(ctx, row, sets);
    -force.dot(down) >= part * body.mass * pull.length()
}

/// Bodies that push it against what pulls it.
fn supports<'a>(ctx: &StepContext, row: u32, sets: &'a Sets<'_>) -> impl Iterator<Item = u32> + 'a {
    let pull = integrate::acceleration(ctx, sets.bodies.at(row));
    sets.contacts.of_body(sets.bodies, row).filter_map(move |(contact, side)| {
        let c = sets.contacts.at(contact);
        let (other, sign) = if side == 0 { (c.body_b, -1.0) } else { (c.body_a, 1.0) };
        let press: f32 = c.points().iter().map(|p| p.impulse).sum();
        let carries = !c.sensor && press > 0.0 && pull.dot(c.normal * sign) < 0.0;
        (carries && other != NONE).then_some(other)
    })
}
