//! Freezing: bodies at rest stop individually, and are immovable until the forces on them change
//! [Schmidl04].
//!
//! A body freezes under three conditions. For the configured sleep time, its energy was below a
//! tenth of the energy that gravity gives it in a step. (A thrown body is that slow at its top for
//! two steps at most.) Something carries it. Every body that carries it is static, frozen, or
//! freezes with it. It wakes when an awake body meets it, and when the force or the torque of its
//! contacts changes: a support was removed, a load came or went, something pushes. Bodies with
//! joints do not freeze: they sleep by islands, like all others.

use crate::base::math::Vec3;
use crate::state::bodies::Load;
use crate::state::bodies::body::Body;
use crate::state::def::config::SleepConfig;
use crate::state::sets::Sets;
use crate::state::shapes::Shapes;
use crate::step::context::StepContext;
use crate::step::solver::body::integrate;

/// Energy below which a body is at rest, as a part of the energy that gravity gives it in a step.
/// The paper's value, all of it, is 0.16 m/s at 60 Hz: a body that begins to tip over its edge is
/// slower than that for longer than the sleep time.
const ENERGY: f32 = 0.1;

/// Part of its weight that must be carried, and by which the force on it may change while it is
/// frozen (the torque: this times its size). If its load is greater, the load counts instead of the
/// weight. Deep in a pile contact forces are not unique, and with a part of the weight a thousand
/// cubes woke each other for ever.
const CARRIED: f32 = 0.5;

const CHANGE: f32 = 0.3;

/// Part of the sleep time after which a body woken by its load may freeze again, if it has not
/// moved. It was still before, and the longer it is awake the more neighbors it wakes.
const AGAIN: f32 = 0.2;

/// Memory kept from step to step.
#[derive(Clone, Debug, Default)]
pub(super) struct Scratch {
    rows: Vec<u32>,
    /// Frozen bodies that awake ones touch; true if one of those moves.
    touched: Vec<(u32, bool)>,
    /// For each body: true if it may freeze in this step, and true if it must be checked again.
    may: Vec<bool>,
    waits: Vec<bool>,
    queue: Vec<u32>,
}

/// Maximum speed of a body without spin at rest [m/s]; `minimum` is the world's for sleep.
pub(crate) fn rest_speed(ctx: &StepContext, minimum: f32) -> f32 {
    (ENERGY.sqrt() * ctx.gravity.length() * ctx.dt).max(minimum)
}

/// True if the body is at rest by its energy; `speed` is the world's, and a lower bound of the
/// limit.
pub(crate) fn rests(ctx: &StepContext, speed: f32, body: &Body) -> bool {
    let w = (body.rotation * body.inertia.principal).unrotate(body.w);
    let m = body.inertia.moments;
    let turning = w.x * w.x * m.x + w.y * w.y * m.y + w.z * w.z * m.z;
    let maximum = rest_speed(ctx, body.still_speed(speed));
    body.v.length_squared() + turning / body.inertia.mass < maximum * maximum
}

/// Force and torque of the contacts on a body in the last step.
fn load(ctx: &StepContext, row: u32, sets: &Sets<'_>) -> Load {
    let (mut force, mut torque, mut size) = (Vec3::ZERO, Vec3::ZERO, 0.0);
    for (contact, side) in sets.contacts.of_body(sets.bodies.at(row)) {
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
            size += j.length();
        }
    }
    let per = 1.0 / ctx.h;
    Load { force: force * per, torque: torque * per, size: size * per }
}

/// Still time of a body that its load has just woken [s].
fn still_after_load(config: &SleepConfig) -> f32 {
    (1.0 - AGAIN) * config.time
}

/// Wakes frozen bodies whose load has changed. Only a body that touches an awake one can have a
/// changed load.
pub(super) fn thaw(ctx: &StepContext, config: &SleepConfig, sets: &mut Sets<'_>, s: &mut Scratch) {
    s.touched.clear();
    let settled = still_after_load(config);
    for pair in sets.contacts.awake_pairs() {
        for (row, other) in [(pair[0], pair[1]), (pair[1], pair[0])] {
            let body = sets.bodies.at(row);
            if !body.active() && body.is_dynamic() && !body.out {
                let other = sets.bodies.at(other);
                s.touched.push((row, !other.is_dynamic() || other.sleep.still_time < settled));
            }
        }
    }
    // Keeps one entry per body, true if a moving one touches it: true sorts first.
    s.touched.sort_unstable_by_key(|(row, moves)| (*row, !*moves));
    s.touched.dedup_by_key(|(row, _)| *row);
    for i in 0..s.touched.len() {
        let (row, moves) = s.touched[i];
        let (now, old) = (load(ctx, row, sets), sets.bodies.frozen_load(row));
        let body = sets.bodies.at(row);
        let maximum = CHANGE * weight(ctx, config, body).max(old.size);
        let changed = (now.force - old.force).length() > maximum
            || (now.torque - old.torque).length() > maximum * body.extent;
        // Deep in a pile a small part of the load is all of the weight. There, a weight that is not
        // carried is significant only where a support can have been removed. With this test for
        // neighbors at rest too, cubes of a pile woke each other for 20 s.
        let lost = moves && !is_carried(ctx, CARRIED - CHANGE, row, sets, |_| true);
        if changed || lost {
            let before = sets.bodies.at(row).sleep.still_time;
            sets.wake(row);
            sets.bodies.at_mut(row).sleep.still_time = settled;
            sets.bodies.stillness[row as usize].go_back(before - settled);
        }
    }
}

/// Weight of a body [N]; without gravity, the force that would give it the sleep speed in a step.
fn weight(ctx: &StepContext, config: &SleepConfig, body: &Body) -> f32 {
    let acceleration = integrate::acceleration(ctx, body).length();
    body.inertia.mass * acceleration.max(body.still_speed(config.speed) / ctx.dt)
}

/// Freezes bodies at rest.
pub(super) fn freeze(
    ctx: &StepContext,
    config: &SleepConfig,
    (shapes, spacing): (&Shapes, f32),
    sets: &mut Sets<'_>,
    s: &mut Scratch,
) {
    for list in [&mut s.may, &mut s.waits] {
        list.clear();
        list.resize(sets.bodies.rows.slot_count(), false);
    }
    s.rows.clear();
    for row in &sets.bodies.awake {
        let body = sets.bodies.at(*row);
        let still = body.is_dynamic() && body.can_sleep && body.sleep.still_time >= config.time;
        let may =
            still && body.ties.joints.is_empty() && is_carried(ctx, CARRIED, *row, sets, |_| true);
        if may
            && super::drives::drives_of(sets, shapes, (spacing, ctx.length)).driver(*row).is_none()
        {
            (s.may[*row as usize], s.waits[*row as usize]) = (true, true);
            s.rows.push(*row);
        }
    }
    // A body on a moving one does not freeze, nor do bodies on it.
    s.queue.clone_from(&s.rows);
    while let Some(row) = s.queue.pop() {
        s.waits[row as usize] = false;
        let may = &s.may;
        let stands = is_carried(ctx, CARRIED, row, sets, |other| {
            !sets.bodies.at(other).active() || may[other as usize]
        });
        if stands {
            continue;
        }
        s.may[row as usize] = false;
        // Queue each neighbor once: the removed body can no longer carry it.
        for (contact, side) in sets.contacts.of_body(sets.bodies.at(row)) {
            let c = sets.contacts.at(contact);
            let other = if side == 0 { c.body_b } else { c.body_a };
            if c.count > 0 && s.may[other as usize] && !s.waits[other as usize] {
                s.waits[other as usize] = true;
                s.queue.push(other);
            }
        }
    }
    let may = &s.may;
    s.rows.retain(|row| may[*row as usize]);
    note_loads(ctx, &s.rows, sets);
    sets.put_to_sleep(&s.rows);
}

/// Stores the loads of the awake ones of these bodies, which are about to rest.
pub(crate) fn note_loads(ctx: &StepContext, rows: &[u32], sets: &mut Sets<'_>) {
    for row in rows {
        if sets.bodies.at(*row).active() {
            let load = load(ctx, *row, sets);
            sets.bodies.set_frozen_load(*row, load);
        }
    }
}

/// True if the contacts with those bodies carry at least this part of its weight.
fn is_carried(
    ctx: &StepContext,
    part: f32,
    row: u32,
    sets: &Sets<'_>,
    by: impl Fn(u32) -> bool,
) -> bool {
    let body = sets.bodies.at(row);
    let pull = integrate::acceleration(ctx, body);
    let Some(down) = pull.try_normalize() else { return true };
    let mut up = 0.0;
    for (contact, side) in sets.contacts.of_body(sets.bodies.at(row)) {
        let c = sets.contacts.at(contact);
        let (other, sign) = if side == 0 { (c.body_b, -1.0) } else { (c.body_a, 1.0) };
        if c.count == 0 || c.sensor || !by(other) {
            continue;
        }
        let press: f32 = c.points().iter().map(|p| p.impulse).sum();
        up -= sign * (c.normal * press + c.tangent_impulse).dot(down);
    }
    up >= part * body.inertia.mass * pull.length() * ctx.h
}
