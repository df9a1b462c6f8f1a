//! Fills the data that few contacts have: restitution, rolling resistance, a lower kinetic
//! friction, the drift of belts and kinematic bodies.

use fearless_simd::Simd;

use super::block::Extra;
use super::raw::{Raw, Source};
use crate::base::math::Vec3;
use crate::base::simd::wide::{LANES, Lanes, Vec3w, above, put, splat};
use crate::base::sym3::Sym3;
use crate::state::bodies::body::Body;
use crate::state::contacts::{Contact, Softened, Traits};
use crate::state::shapes::ShapeRow;
use crate::step::context::softness::Softness;
use crate::step::narrowphase;

#[inline(always)]
fn put_sym(lanes: &mut [Lanes; 6], lane: usize, s: Sym3, sign: f32) {
    for (i, v) in [s.xx, s.yy, s.zz, s.xy, s.xz, s.yz].into_iter().enumerate() {
        lanes[i][lane] = v * sign;
    }
}

/// Fills restitution, rolling and drift of one contact; true if it may bounce in this step.
pub(crate) fn pack_extra<const FIXED: bool>(
    source: &Source<'_>,
    raw: &Raw<'_>,
    (lane, row): (usize, u32),
    extra: &mut Extra,
) -> bool {
    let mut arrives = false;
    let c = raw.contacts[lane];
    let (a, b) = (source.bodies.at(c.body_a), source.bodies.at(c.body_b));
    if c.restitution > 0.0 {
        arrives = pack_bounce(source, c, [a, b], lane, extra);
    }
    if c.rolling > 0.0 {
        extra.rolls = true;
        extra.rolling[lane] = c.rolling;
        if !FIXED {
            let s = source.whitening.read(raw.row_a[lane] as usize).s();
            put_sym(&mut extra.s_a, lane, s, 1.0);
        }
        let s = source.whitening.read(raw.row_b[lane] as usize).s();
        put_sym(&mut extra.s_b, lane, s, raw.sign[lane]);
        let impulse = c.rolling_impulse() * source.ctx.impulse_scale;
        put(&mut extra.rolling_impulse, lane, impulse);
    }
    if c.kinetic < 1.0 {
        extra.slips = true;
        extra.kinetic[lane] = c.kinetic;
    }
    if c.traits.may_soften()
        && let Some(softness) = softness_of(source, c, row)
    {
        let Softness { rate, mass, impulse } = source.ctx.soft_contact(&softness);
        extra.softens = true;
        (extra.soft_rate[lane], extra.soft_mass[lane]) = (rate, mass);
        extra.soft_impulse[lane] = impulse;
    }
    if c.traits.any(Traits::BELT) || moves(a) || moves(b) {
        extra.drifts = true;
        let (mut r_a, mut r_b) = (Vec3::ZERO, Vec3::ZERO);
        let share = 1.0 / f32::from(c.count.max(1));
        for (j, p) in c.points().iter().enumerate() {
            let v = drift_velocity(b, c.r_b(p)) - drift_velocity(a, p.r_a);
            extra.drift[j][lane] = c.normal.dot(v);
            r_a += p.r_a * share;
            r_b += c.r_b(p) * share;
        }
        let (sa, sb) = (source.shapes.at(c.shape_a), source.shapes.at(c.shape_b));
        // Positions of the other body's anchors now: the own ones fall behind on a moving belt.
        let offset = b.center - a.center;
        let (from, to) = (Carry::of(a, sa, r_b + offset), Carry::of(b, sb, r_a - offset));
        let rate = to.rate - from.rate;
        // A sweep solves the velocity of the substep after it, at that substep's middle.
        let velocity = to.velocity - from.velocity + rate * (0.5 * source.ctx.h);
        let t1 = c.normal.any_perpendicular();
        let t2 = t1.cross(c.normal);
        (extra.drift_t[0][lane], extra.drift_rate[0][lane]) = (t1.dot(velocity), t1.dot(rate));
        (extra.drift_t[1][lane], extra.drift_rate[1][lane]) = (t2.dot(velocity), t2.dot(rate));
        extra.drift_t[2][lane] = c.normal.dot(to.spin - from.spin);
    }
    arrives
}

/// Softness of a contact, if it has its own: set by hooks in this step, or else by the rules of its
/// shapes.
fn softness_of(source: &Source<'_>, c: &Contact, row: u32) -> Softened {
    if c.traits.any(Traits::HOOKED)
        && let Some(softened) = source.softened.get(row as usize)
    {
        return *softened;
    }
    source.shapes.surface_of(c.shape_a, c.shape_b).softness
}

fn moves(body: &Body) -> bool {
    !body.is_dynamic() && body.active()
}

/// Sets the restitution of one contact; true if it arrives in this step. It arrives if some point
/// reaches the surface faster than forces alone move a body in a step. A resting contact does not.
fn pack_bounce(
    source: &Source<'_>,
    c: &Contact,
    [a, b]: [&Body; 2],
    lane: usize,
    extra: &mut Extra,
) -> bool {
    // The relax sweep looks a substep ahead of the step's end.
    let (dt, ahead) = (source.ctx.dt, source.ctx.dt + source.ctx.h);
    let along = |body: u32| {
        c.normal.dot(*source.acceleration.read(source.solver_row_of[body as usize] as usize))
    };
    let (of_a, of_b) = (along(c.body_a), along(c.body_b));
    let fall = of_b - of_a;
    let slow = of_a.abs().max(of_b.abs()) * dt;
    extra.bounces = true;
    extra.restitution[lane] = c.restitution;
    (extra.fall[lane], extra.slow[lane]) = (fall, slow);
    c.points().iter().any(|p| {
        let speed = c.normal.dot(b.velocity_at(c.r_b(p)) - a.velocity_at(p.r_a));
        let s = p.separation - source.ctx.rest_offset;
        let faster = fall.min(0.0) * ahead;
        let meets = s + (speed + 0.6 * faster) * ahead < 0.0 && speed + faster < 0.0;
        let square = speed * speed - 2.0 * fall * s.max(0.0);
        let minimum = source.ctx.restitution_speed.max(slow);
        meets && square > minimum * minimum
    })
}

/// Velocity of a point of a moving kinematic body; zero for any other body.
fn drift_velocity(body: &Body, r: Vec3) -> Vec3 {
    if moves(body) { body.velocity_at(r) } else { Vec3::ZERO }
}

/// Surface motion that no impulse can stop: with its kinematic body, or over its shape as a belt.
struct Carry {
    velocity: Vec3,
    spin: Vec3,
    /// Centripetal acceleration of a carried body. Without it the body would leave a turntable
    /// along the tangent, by half of ω² r dt per second.
    rate: Vec3,
}

impl Carry {
    fn of(body: &Body, shape: &ShapeRow, r: Vec3) -> Self {
        let (mut velocity, mut spin) = (Vec3::ZERO, Vec3::ZERO);
        let mut carried = Vec3::ZERO;
        if moves(body) {
            (velocity, spin) = (body.v, body.w);
            carried = body.w.cross(r);
        }
        if shape.surface_velocity != Vec3::ZERO || shape.surface_spin != Vec3::ZERO {
            let pose = shape.placed(body);
            let turn = pose.direction(shape.surface_spin);
            let arm = r - (pose.position - body.center);
            carried += pose.direction(shape.surface_velocity) + turn.cross(arm);
            spin += turn;
        }
        Self { velocity: velocity + carried, spin, rate: spin.cross(carried) }
    }
}

/// Acceleration between two bodies that rotate together, each by `turn` in half of the step, and
/// the lever arms in the middle of the step. Forces along the lever arms of its start would make
/// them rotate faster and faster.
#[inline(always)]
pub(crate) fn corotation<S: Simd>(
    simd: S,
    turns: &[[Lanes; 3]; 2],
    arms: [Vec3w<S>; 2],
    half: f32,
) -> ([Vec3w<S>; 2], Vec3w<S>) {
    let (one_half, zero) = (splat(simd, 0.5), splat(simd, 0.0));
    let [a, b] = [0, 1].map(|i| {
        let turn = Vec3w::load(simd, &turns[i]);
        let once = turn.cross(arms[i]);
        let turned = arms[i] + (once + turn.cross(once) * one_half);
        // Other lanes stay unchanged, down to the sign of zero.
        let turned = Vec3w::select(above(turn.dot(turn), zero), turned, arms[i]);
        (turned, turn.cross(turn.cross(turned)))
    });
    let rate = (b.1 - a.1) * splat(simd, 1.0 / (half * half));
    ([a.0, b.0], rate)
}

/// Bit for each lane that may get an impact in this step.
#[inline(never)]
pub(crate) fn may_impact(source: &Source<'_>, raw: &Raw<'_>, owners: &[u32; LANES]) -> u8 {
    let mut lanes = 0;
    for (lane, (row, c)) in owners.iter().zip(raw.contacts).enumerate() {
        let ends = [c.body_a, c.body_b].map(|body| source.bodies.at(body));
        let is_one = *row != u32::MAX && narrowphase::turning::may_impact(source.ctx, c, ends);
        lanes |= u8::from(is_one) << lane;
    }
    lanes
}
