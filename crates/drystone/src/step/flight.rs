//! Free flight: motion of bodies without contacts and joints, as a parabola and an exact free
//! rotation.

use fearless_simd::dispatch;

use super::context::StepContext;
use super::gyration::Spin;
use super::gyration::lanes::{Ends, Tops, turn_eight};
use super::solver::body::integrate::{acceleration, roots_of_inertia};
use crate::base::double::DVec3;
use crate::base::math::Vec3;
use crate::base::simd::wide::LANES;
use crate::base::threads::disjoint::Rows;
use crate::state::bodies::body::{Body, Subdivision};

/// Bodies that wait for their free rotation, in two lists. Bodies with two equal moments need one
/// part only; in lanes with a neighbor that needs eight they would be as slow as that.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Spins {
    rows: [[u32; LANES]; 2],
    counts: [usize; 2],
}

impl Spins {
    /// Adds a body, and rotates eight when the list is full.
    pub(crate) fn add(
        &mut self,
        ctx: &StepContext,
        row: u32,
        moments: Vec3,
        bodies: &Rows<'_, Option<Body>>,
    ) {
        let [x, y, z] = moments.to_array().map(f32::to_bits);
        let list = usize::from(x != y && y != z && z != x);
        self.rows[list][self.counts[list]] = row;
        self.counts[list] += 1;
        if self.counts[list] == LANES {
            self.turn(ctx, list, bodies);
        }
    }

    /// Rotates the remaining bodies.
    pub(crate) fn finish(&mut self, ctx: &StepContext, bodies: &Rows<'_, Option<Body>>) {
        for list in 0..2 {
            self.turn(ctx, list, bodies);
        }
    }

    fn turn(&mut self, ctx: &StepContext, list: usize, bodies: &Rows<'_, Option<Body>>) {
        let count = core::mem::take(&mut self.counts[list]);
        if count == 0 {
            return;
        }
        let rows = &self.rows[list][..count];
        let mut tops = Tops::default();
        for lane in 0..LANES {
            // Idle lanes repeat the first body.
            let row = rows.get(lane).or(rows.first());
            if let Some(body) = row.and_then(|row| bodies.read(*row as usize).as_ref()) {
                let w = DVec3::from(body.w) + DVec3::from(body.history.w_low);
                tops.fill(lane, &Spin::of(body), w);
            }
        }
        let mut ends = Ends::default();
        dispatch!(ctx.level, simd => turn_eight(simd, &tops, ctx.dt, ctx.substeps, &mut ends));
        for (lane, row) in rows.iter().enumerate() {
            if let Some(body) = bodies.row(*row as usize) {
                ends.put(lane, body);
            }
        }
    }
}

/// Moves a body that nothing touches along its exact parabola. True if its free rotation remains to
/// be computed by [`Spins`].
pub(crate) fn fly(ctx: &StepContext, body: &mut Body) -> bool {
    (body.history.inertia_factor, body.history.load, body.history.subdivision) =
        (1.0, 0.0, Subdivision::Whole);
    let acc = acceleration(ctx, body);
    let decay_v = super::context::softness::exact_decay(body.forces.linear_damping, ctx.dt);
    let next = (body.v + acc * ctx.dt) * decay_v;
    let mut mean = (body.v + next) * 0.5;
    let mut v = next;
    for i in 0..3 {
        if body.inertia.locks.linear[i] {
            (mean[i], v[i]) = (0.0, 0.0);
        }
    }
    body.center += mean * ctx.dt;
    body.v = v;

    let torque = body.forces.torque + body.forces.step_torque;
    if torque != Vec3::ZERO {
        let (s, _) = roots_of_inertia(body, body.rotation);
        body.w += s.mul(s.mul(torque)) * ctx.dt;
    }
    body.w *= super::context::softness::exact_decay(body.forces.angular_damping, ctx.dt);
    let m = body.inertia.moments;
    let round = m.max_element() - m.min_element() <= 1.0e-3 * m.max_element();
    if m.min_element() <= 0.0 || body.inertia.locks.angular != [false; 3] {
        let (s, s_inv) = roots_of_inertia(body, body.rotation);
        body.w = s.mul(s_inv.mul(body.w));
        body.rotation = body.rotation.turned_by(body.w * ctx.dt);
    } else if round {
        body.rotation = body.rotation.turned_by(body.w * ctx.dt);
    } else if DVec3::from(body.w) + DVec3::from(body.history.w_low) == DVec3::ZERO {
        (body.w, body.history.w_low) = (Vec3::ZERO, Vec3::ZERO);
    } else {
        return true;
    }
    false
}

#[cfg(test)]
mod tests {
    use super::{Spin, Spins};
    use crate::base::double::DVec3;
    use crate::base::math::{Vec3, vec3};
    use crate::base::random::Random;
    use crate::base::simd::wide::{LANES, SimdLevel};
    use crate::base::threads::disjoint::{Apart, Rows};
    use crate::state::bodies::body::Body;
    use crate::state::def::config::WorldConfig;
    use crate::state::def::{BodyDef, ShapeDef};
    use crate::step::context::StepContext;
    use crate::step::gyration::lanes::turned_eight;
    use crate::step::gyration::rotate_freely;
    use crate::world::World;

    /// Boxes with all orders of sides, some with two equal ones, that turn slowly, fast, or about
    /// one axis.
    fn spinning() -> Vec<Option<Body>> {
        let mut world = World::default();
        let mut random = Random::new(7);
        #[expect(clippy::cast_possible_truncation, reason = "any number will do")]
        let mut between =
            |minimum: f32, maximum: f32| minimum + (maximum - minimum) * random.unit() as f32;
        for i in 0..61_u8 {
            let mut half = vec3(between(0.1, 1.0), between(0.1, 1.0), between(0.1, 1.0));
            if i % 5 == 0 {
                half.y = half.x;
            }
            let speed = [0.01, 1.0, 30.0, 3_000.0][usize::from(i % 4)];
            let w = vec3(between(-1.0, 1.0), between(-1.0, 1.0), between(-1.0, 1.0)) * speed;
            let w = if i % 7 == 0 { vec3(0.0, w.y, 0.0) } else { w };
            let body = BodyDef::dynamic()
                .with_position(vec3(10.0 * f32::from(i), 0.0, 0.0))
                .with_angular_velocity(w)
                .with_shape(ShapeDef::box_half(half));
            world.add_body(body).unwrap();
        }
        // Some steps later they are tilted, and `w_low` holds a rounding remainder.
        for _ in 0..10 {
            world.step(1.0 / 60.0);
        }
        world.tables_mut().bodies.rows.values_mut().to_vec()
    }

    #[test]
    fn eight_bodies_turn_as_each_does_alone() {
        for level in SimdLevel::available() {
            let dt = 1.0 / 60.0;
            let ctx = StepContext::new(&WorldConfig::default(), dt, dt, level.0);
            let alone = spinning();
            let mut together = alone.clone();
            #[expect(unsafe_code, reason = "promises that rows are kept apart")]
            // SAFETY: by one thread, a row at a time.
            let apart = unsafe { Apart::promise() };
            let rows = Rows::new(&mut together, apart);
            let mut spins = Spins::default();
            for (row, body) in (0..).zip(&alone) {
                spins.add(&ctx, row, body.as_ref().map_or(Vec3::ONE, |b| b.inertia.moments), &rows);
            }
            spins.finish(&ctx, &rows);
            let mut rested = 0;
            for (a, b) in alone.iter().flatten().zip(together.iter().flatten()) {
                let w = DVec3::from(a.w) + DVec3::from(a.history.w_low);
                let turned = rotate_freely(&Spin::of(a), w, ctx.dt, ctx.substeps);
                let bits = |x: [f32; 4]| x.map(f32::to_bits);
                let of = |v: Vec3| bits([v.x, v.y, v.z, 0.0]);
                assert_eq!(bits(b.rotation.to_array()), bits(turned.rotation.to_array()));
                assert_eq!((of(b.w), of(b.history.w_low)), (of(turned.w), of(turned.w_low)));
                rested += usize::from(a.history.w_low != Vec3::ZERO);
            }
            assert!(rested > 30, "{rested}");
        }
    }

    #[test]
    fn what_gyrates_together_gyrates_as_each_does_alone() {
        for level in SimdLevel::available() {
            let dt = 1.0 / 60.0;
            let ctx = StepContext::new(&WorldConfig::default(), dt, dt, level.0);
            let bodies = spinning();
            for (n, eight) in bodies.chunks(LANES).enumerate() {
                let some = |k: usize| eight.get(k)?.as_ref().filter(|_| !(n + k).is_multiple_of(3));
                let spins = core::array::from_fn(|k| some(k).map(|b| (Spin::of(b), b.w)));
                let together = turned_eight(&ctx, &spins);
                for k in 0..LANES {
                    let alone = some(k).map_or(Vec3::ZERO, |body| {
                        let w = DVec3::from(body.w);
                        rotate_freely(&Spin::of(body), w, ctx.dt, ctx.substeps).w
                    });
                    let bits = |v: Vec3| v.to_array().map(f32::to_bits);
                    assert_eq!(bits(together[k]), bits(alone), "{n} {k}");
                }
            }
        }
    }
}
