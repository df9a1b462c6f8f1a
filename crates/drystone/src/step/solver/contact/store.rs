//! Stores blocks in their contacts after the last sweep, and sums the load on bodies.

use fearless_simd::{Simd, SimdBase};

use super::block::{ContactBlock, Extra};
use crate::base::math::Vec3;
use crate::base::simd::wide::{LANES, Vec3w, above, at, load, scatter4, splat};
use crate::base::threads::disjoint::Rows;
use crate::state::bodies::Bodies;
use crate::state::bodies::body::Body;
use crate::state::contacts::{Contact, Point, Slots, Traits};
use crate::step::context::StepContext;
use crate::step::solver::body::integrate;
use crate::step::solver::body::squeeze::Squeeze;
use crate::step::solver::totals_rows::POINTS;

/// Adds a block's normal impulses, times `scale`, to the squeeze of its bodies.
#[inline(always)]
pub(crate) fn weigh<S: Simd>(
    simd: S,
    block: &ContactBlock,
    squeezes: &Rows<'_, Squeeze>,
    scale: f32,
) {
    let mut total = load(simd, &block.points[0].impulse);
    for point in &block.points[1..usize::from(block.count.clamp(1, 4))] {
        total += load(simd, &point.impulse);
    }
    let total = total * splat(simd, scale);
    // Push on B; a row with flipped sign has a negative beta.
    let turned = above(splat(simd, 0.0), load(simd, &block.beta));
    let push = Vec3w::load(simd, &block.n) * total;
    let push = Vec3w::select(turned, push * splat(simd, -1.0), push);
    let of_b = scatter4([push.x, push.y, push.z, total]);
    for lane in 0..LANES {
        let mut impulse = [0.0; 4];
        of_b[lane].store_array(&mut impulse);
        let (a, b) = (block.row_a[lane], block.row_b[lane]);
        if b != 0 {
            for (sum, x) in squeezes.row(b as usize).impulse.iter_mut().zip(impulse) {
                *sum += x;
            }
        }
        if a != 0 {
            let [x, y, z, size] = impulse;
            for (sum, x) in squeezes.row(a as usize).impulse.iter_mut().zip([-x, -y, -z, size]) {
                *sum += x;
            }
        }
    }
}

/// Writes a block's impulses back, times `scale`. Returns a bit for each lane whose touch is new.
#[inline(always)]
pub(crate) fn store<S: Simd>(
    simd: S,
    block: &ContactBlock,
    extra: Option<&Extra>,
    (owners, before): (&[u32; LANES], u8),
    (contacts, bodies): (&Slots<'_>, &Bodies),
    (ctx, elapsed): (&StepContext, Option<f32>),
) -> u8 {
    let scale = ctx.store_scale();
    let wide = splat(simd, scale);
    let (f1, f2) = (load(simd, &block.friction[0]), load(simd, &block.friction[1]));
    let t = (Vec3w::load(simd, &block.t1) * f1 + Vec3w::load(simd, &block.t2) * f2) * wide;
    let rub = scatter4([t.x, t.y, t.z, load(simd, &block.friction[2]) * wide]);
    let p = &block.points;
    let push = scatter4([
        load(simd, &p[0].impulse) * wide,
        load(simd, &p[1].impulse) * wide,
        load(simd, &p[2].impulse) * wide,
        load(simd, &p[3].impulse) * wide,
    ]);
    let mut begun = 0;
    for lane in 0..LANES {
        if owners[lane] == u32::MAX {
            continue;
        }
        let Some(c) = contacts.row(owners[lane] as usize) else { continue };
        let (mut push_of, mut rub_of) = ([0.0; 4], [0.0; 4]);
        push[lane].store_array(&mut push_of);
        rub[lane].store_array(&mut rub_of);
        let mut pressed = block.pressed >> lane & 1 == 1;
        for j in 0..usize::from(c.count.min(4)) {
            c.points[j].impulse = push_of[j];
            pressed |= push_of[j] > 0.0 || c.points[j].separation <= 0.0;
        }
        let hit = block.hit >> lane & 1 == 1;
        pressed |= hit;
        let struck = hit && !(c.restitution > 0.0);
        if struck != c.traits.any(Traits::STRUCK) {
            c.traits = c.traits.with(Traits::STRUCK, struck);
        }
        let parts = block.parting >> lane & 1 == 1;
        if parts != c.traits.any(Traits::PARTING) {
            c.traits = c.traits.with(Traits::PARTING, parts);
        }
        let [x, y, z, twist] = rub_of;
        (c.tangent_impulse, c.twist_impulse) = (Vec3 { x, y, z }, twist);
        if let Some(extra) = extra
            && c.rolling > 0.0
        {
            c.set_rolling_impulse(at(&extra.rolling_impulse, lane) * scale);
        }
        if pressed && !c.touching && before >> lane & 1 == 0 {
            begun |= 1 << lane;
            let ends = (bodies.at(c.body_a), bodies.at(c.body_b));
            let approach = approach(c, POINTS, ends, (ctx, elapsed));
            c.set_approach(approach);
        }
    }
    begun
}

/// Approach speed of the points of a contact that was pressed for the first time in this step
/// [m/s], from the velocities at the step's start. Forces add speed on the way, v² = v₀² + 2 a s,
/// but at most that of a whole step. `elapsed` [s]: time since the step's start, for a contact that
/// was rebuilt since. `which`: bits of the points; all points count for a rebuilt contact.
pub(crate) fn approach(
    c: &Contact,
    which: u8,
    (a, b): (&Body, &Body),
    (ctx, elapsed): (&StepContext, Option<f32>),
) -> f32 {
    let fall = |body: &Body| {
        if body.is_dynamic() { integrate::acceleration(ctx, body) } else { Vec3::ZERO }
    };
    let gain = c.normal.dot(fall(a) - fall(b));
    let elapsed = elapsed.or_else(|| c.is_renewed().then(|| ctx.step()));
    let speed = |p: &Point| {
        let v = -c.normal.dot(b.velocity_at(c.r_b(p)) - a.velocity_at(p.r_a));
        if gain <= 0.0 || v < 0.0 {
            return v;
        }
        if let Some(elapsed) = elapsed {
            return v + gain * elapsed;
        }
        let end = (v * v + 2.0 * gain * p.separation.max(0.0)).sqrt();
        end.min(v + gain * ctx.step())
    };
    let which = if elapsed.is_some() { POINTS } else { which };
    let points = c.points().iter().enumerate().filter(|(j, _)| which >> j & 1 == 1);
    points.map(|(_, p)| speed(p)).fold(0.0, f32::max)
}
