//! Wait test: decides for eight pairs at a time whether they still cannot touch. Most pairs in a
//! heap only come near each other, and this test is then all their work.
//!
//! A pair waits while no point of the smaller body can have crossed the gap found by the last test,
//! minus the distance by which the two may approach in this step. Lanes decide bit by bit as the
//! formulas of one pair do.

use fearless_simd::{Simd, SimdBase};

use crate::base::math::Vec3;
use crate::base::simd::wide::{
    LANES, Lanes, Mask, Vec3w, Wide, above, bits, gather_rows, load, max, min, select, splat, sqrt,
};
use crate::base::simd::wide_quat::Quatw;
use crate::state::bodies::Bodies;
use crate::state::bodies::body::Body;
use crate::state::contacts::{Probe, Watch};
use crate::step::context::StepContext;

/// Four numbers for each of eight pairs.
pub(super) type Rows = [[f32; 4]; LANES];

/// Inputs of eight pairs, in the layout of the body table: lanes transpose it. P is the body that
/// is larger or cannot be pushed; Q is seen in its frame.
#[derive(Clone, Debug, Default)]
#[repr(C, align(64))]
struct Pairs {
    /// Center of Q minus that of P, now and at the reference [world]; w: the gap, and the extent of
    /// Q.
    offset: Rows,
    offset_then: Rows,
    rotation_p: Rows,
    rotation_p_then: Rows,
    rotation_q: Rows,
    rotation_q_then: Rows,
    /// Velocities; w: the extents of A and B.
    v_p: Rows,
    v_q: Rows,
    /// Angular velocities; w: the smaller size of the dynamic bodies, and the sum of both sizes if
    /// both are dynamic.
    w_a: Rows,
    w_b: Rows,
    /// 1 if an impact may stop either body within the step.
    bounces: Lanes,
}

/// The inputs in lanes.
struct Seen<S: Simd> {
    gap: Wide<S>,
    offset: Vec3w<S>,
    offset_then: Vec3w<S>,
    extent_q: Wide<S>,
    rotation_p: Quatw<S>,
    rotation_p_then: Quatw<S>,
    rotation_q: Quatw<S>,
    rotation_q_then: Quatw<S>,
    v_p: Vec3w<S>,
    v_q: Vec3w<S>,
    extent_a: Wide<S>,
    extent_b: Wide<S>,
    w_a: Vec3w<S>,
    w_b: Vec3w<S>,
    size: Wide<S>,
    sizes: Wide<S>,
    bounces: Mask<S>,
}

/// Results for eight pairs.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Found {
    /// Speculative distance [m]; not computed if all pairs stand on each other, since such pairs
    /// are mostly recycled.
    pub(super) reach: Option<Lanes>,
    /// Lower bound on the distance of pairs that wait [m].
    pub(super) gap: Lanes,
    /// A bit for each pair that must be tested.
    pub(super) due: u32,
}

/// Tests up to eight pairs.
#[inline(always)]
pub(super) fn look<'a, S: Simd>(
    simd: S,
    ctx: &StepContext,
    bodies: &Bodies,
    pairs: impl ExactSizeIterator<Item = (&'a Watch, &'a Probe)> + Clone,
) -> Found {
    let mut found = Found { due: (1 << pairs.len().min(LANES)) - 1, ..Found::default() };
    // The speculative distance is at least the margin, so pairs that stand on each other cannot
    // wait.
    if pairs.clone().all(|(_, probe)| probe.gap <= ctx.margin) {
        return found;
    }
    let mut wide = Pairs::default();
    for (lane, (watch, probe)) in pairs.enumerate().take(LANES) {
        let (a, b) = (bodies.at(watch.body_a), bodies.at(watch.body_b));
        wide.fill(lane, probe, watch.bounces(), a, b);
    }
    let seen = wide.seen(simd);
    let margin = seen.margin(simd, ctx);
    margin.store_array(found.reach.insert([0.0; LANES]));
    let (moved, gap) = (seen.moved(simd), seen.gap);
    (gap - moved).store_array(&mut found.gap);
    // The gap is 0 where it is unknown.
    let room = select(above(gap, margin), gap - margin, splat(simd, 0.0));
    found.due ^= bits(above(room, moved));
    found
}

impl Pairs {
    #[inline(always)]
    fn fill(&mut self, lane: usize, probe: &Probe, bounces: bool, a: &Body, b: &Body) {
        let (dynamic_a, dynamic_b) = (a.is_dynamic(), b.is_dynamic());
        let seen_from_a = !dynamic_a || (dynamic_b && b.extent <= a.extent);
        let (p, q) = if seen_from_a { (a, b) } else { (b, a) };
        let then = if seen_from_a { probe.offset } else { -probe.offset };
        let (p_then, q_then) = if seen_from_a {
            (probe.rotation_a, probe.rotation_b)
        } else {
            (probe.rotation_b, probe.rotation_a)
        };
        let size_a = if dynamic_a { a.extent } else { f32::INFINITY };
        let size_b = if dynamic_b { b.extent } else { f32::INFINITY };
        let size = if size_a < size_b { size_a } else { size_b };
        let both = dynamic_a && dynamic_b;
        self.offset[lane] = with(q.center - p.center, probe.gap);
        self.offset_then[lane] = with(then, q.extent);
        self.rotation_p[lane] = bytemuck::cast(p.rotation);
        self.rotation_p_then[lane] = bytemuck::cast(p_then);
        self.rotation_q[lane] = bytemuck::cast(q.rotation);
        self.rotation_q_then[lane] = bytemuck::cast(q_then);
        self.v_p[lane] = with(p.v, a.extent);
        self.v_q[lane] = with(q.v, b.extent);
        self.w_a[lane] = with(a.w, size);
        self.w_b[lane] = with(b.w, if both { a.extent + b.extent } else { 0.0 });
        self.bounces[lane] = if bounces && both { 1.0 } else { 0.0 };
    }

    #[inline(always)]
    fn seen<S: Simd>(&self, simd: S) -> Seen<S> {
        let (offset, gap) = columns(simd, &self.offset);
        let (offset_then, extent_q) = columns(simd, &self.offset_then);
        let (v_p, extent_a) = columns(simd, &self.v_p);
        let (v_q, extent_b) = columns(simd, &self.v_q);
        let (w_a, size) = columns(simd, &self.w_a);
        let (w_b, sizes) = columns(simd, &self.w_b);
        Seen {
            gap,
            offset,
            offset_then,
            extent_q,
            rotation_p: Quatw::of_rows(simd, &self.rotation_p),
            rotation_p_then: Quatw::of_rows(simd, &self.rotation_p_then),
            rotation_q: Quatw::of_rows(simd, &self.rotation_q),
            rotation_q_then: Quatw::of_rows(simd, &self.rotation_q_then),
            v_p,
            v_q,
            extent_a,
            extent_b,
            w_a,
            w_b,
            size,
            sizes,
            bounces: above(load(simd, &self.bounces), splat(simd, 0.0)),
        }
    }
}

/// A vector and a number.
#[inline(always)]
pub(super) const fn with(v: Vec3, w: f32) -> [f32; 4] {
    [v.x, v.y, v.z, w]
}

/// Vectors and fourth numbers of eight rows, in lanes.
#[inline(always)]
pub(super) fn columns<S: Simd>(simd: S, rows: &Rows) -> (Vec3w<S>, Wide<S>) {
    let [x, y, z, w] = gather_rows(simd, rows);
    (Vec3w { x, y, z }, w)
}

impl<S: Simd> Seen<S> {
    /// [`speculative_margin`](crate::step::reach::speculative_margin) for eight pairs.
    #[inline(always)]
    fn margin(&self, simd: S, ctx: &StepContext) -> Wide<S> {
        let (v_p, v_q) = (self.v_p, self.v_q);
        let along = v_q - v_p;
        let speed = length(along);
        let either = max(max(speed, length(v_p)), length(v_q));
        let speed = select(self.bounces, either, speed);
        let spin_a = length(self.w_a) * self.extent_a;
        let spin_b = length(self.w_b) * self.extent_b;
        let speed = speed + spin_a + spin_b;
        let displacement = splat(simd, 1.1) * speed * splat(simd, ctx.dt);
        let (size, sizes) = (self.size, self.sizes);
        let meets = self.will_meet(simd, along * splat(simd, 1.1 * ctx.dt), sizes);
        // Bodies that cannot be pushed have no size here.
        let maximum = select(meets, max(size, sizes), size);
        max(splat(simd, ctx.margin), min(displacement, maximum))
    }

    /// [`will_meet`](super::will_meet) for eight pairs.
    #[inline(always)]
    fn will_meet(&self, simd: S, displacement: Vec3w<S>, near: Wide<S>) -> Mask<S> {
        let apart = self.offset;
        let (zero, one) = (splat(simd, 0.0), splat(simd, 1.0));
        let displacements = max(displacement.dot(displacement), splat(simd, f32::MIN_POSITIVE));
        let nearest = min(max(-apart.dot(displacement) / displacements, zero), one);
        let then = apart + displacement * nearest;
        !above(then.dot(then), near * near)
    }

    /// Upper bound on the displacement of a point of Q in the frame of P since the reference [m].
    #[inline(always)]
    fn moved(&self, simd: S) -> Wide<S> {
        let (p, p_then) = (self.rotation_p, self.rotation_p_then);
        let (q, q_then) = (self.rotation_q, self.rotation_q_then);
        let shift = p.unrotate(simd, self.offset) - p_then.unrotate(simd, self.offset_then);
        let chord = p.to(q).chord(simd, p_then.to(q_then));
        length(shift) + chord * self.extent_q
    }
}

#[inline(always)]
fn length<S: Simd>(v: Vec3w<S>) -> Wide<S> {
    sqrt(v.dot(v))
}

#[cfg(test)]
mod tests {
    use fearless_simd::dispatch;

    use super::look;
    use crate::base::math::{Vec3, vec3};
    use crate::base::pose::Pose;
    use crate::base::quat::Quat;
    use crate::base::simd::wide::LANES;
    use crate::base::simd::wide::SimdLevel;
    use crate::base::threads::disjoint::Apart;
    use crate::base::threads::jobs::Jobs;
    use crate::geometry::collide::collide;
    use crate::geometry::manifold::PairCache;
    use crate::state::bodies::Track;
    use crate::state::bodies::body::Body;
    use crate::state::contacts::{Lent, Probe};
    use crate::state::def::config::WorldConfig;
    use crate::state::def::{BodyDef, ShapeDef};
    use crate::step::context::StepContext;
    use crate::step::narrowphase::look_ahead;
    use crate::step::narrowphase::rebuild::chord;
    use crate::step::reach::speculative_margin;
    use crate::world::World;

    /// Upper bound on the approach of a point of one body to the other since the reference [m]: the
    /// motion of the smaller body in the frame of the larger or unpushable one.
    fn moved(r: &Probe, a: &Body, b: &Body) -> f32 {
        let seen_from_a = !a.is_dynamic() || (b.is_dynamic() && b.extent <= a.extent);
        let (p, q) = if seen_from_a { (a, b) } else { (b, a) };
        let (offset, p0, q0) = if seen_from_a {
            (r.offset, r.rotation_a, r.rotation_b)
        } else {
            (-r.offset, r.rotation_b, r.rotation_a)
        };
        let shift = p.rotation.unrotate(q.center - p.center) - p0.unrotate(offset);
        let turn = chord(&(p.rotation.conjugate() * q.rotation), &(p0.conjugate() * q0));
        shift.length() + turn * q.extent
    }

    /// Boxes of two sizes and balls that fall, spin and bounce on a ground, and balls that are shot
    /// into them.
    fn heap() -> World {
        let mut world = World::default();
        world.add_body(BodyDef::fixed().with_shape(ShapeDef::half_space(Vec3::Y, 0.0))).unwrap();
        for i in 0..48_u8 {
            let at = |k: u8| f32::from(k % 4) * 0.5;
            let shape = match i % 3 {
                0 => ShapeDef::box_half(vec3(0.1, 0.2, 0.3)),
                1 => ShapeDef::box_half(vec3(0.2, 0.2, 0.2)),
                _ => ShapeDef::sphere(0.2).with_restitution(0.8),
            };
            let body = BodyDef::dynamic()
                .with_position(vec3(at(i), 0.4 + 0.5 * f32::from(i / 16), at(i / 4)))
                .with_angular_velocity(vec3(f32::from(i % 5) - 2.0, 1.0, f32::from(i % 7) - 3.0))
                .with_shape(shape);
            world.add_body(body).unwrap();
        }
        for i in 0..12_u8 {
            let from =
                vec3(-2.0 - 3.0 * f32::from(i), 0.3 + 0.1 * f32::from(i), 0.1 * f32::from(i));
            let shot = BodyDef::dynamic().with_position(from).with_shape(ShapeDef::sphere(0.1));
            world.add_body(shot.with_linear_velocity(vec3(30.0, 0.0, 0.0))).unwrap();
        }
        world
    }

    #[test]
    fn lanes_decide_as_one_pair_does() {
        let mut world = heap();
        let dt = 1.0 / 60.0;
        let ctx = StepContext::new(&WorldConfig::default(), dt, dt, SimdLevel::best().0);
        let (mut tested, mut waited, mut on_course) = (0, 0, 0);
        for _ in 0..90 {
            world.step(dt);
            let mut now = world.clone();
            let tables = now.tables_mut();
            #[expect(unsafe_code, reason = "promises that rows are kept apart")]
            // SAFETY: no row is taken at all.
            let apart = unsafe { Apart::promise() };
            let Lent { watches, probes, .. } = tables.contacts.watched_mut(apart);
            let bodies = &tables.bodies;
            for (watches, probes) in watches.chunks(LANES).zip(probes.chunks(LANES)) {
                let pairs = watches.iter().zip(probes.iter());
                let found = dispatch!(ctx.level, simd => look(simd, &ctx, bodies, pairs.clone()));
                assert_eq!(found.due >> probes.len(), 0);
                for (lane, (watch, probe)) in pairs.enumerate() {
                    let (a, b) = (bodies.at(watch.body_a), bodies.at(watch.body_b));
                    let margin = speculative_margin(&ctx, a, b, watch.bounces());
                    let moved = moved(probe, a, b);
                    let waits = probe.gap > margin && moved < probe.gap - margin;
                    let reach = found.reach.map_or(margin, |reach| reach[lane]);
                    assert_eq!(reach.to_bits(), margin.to_bits());
                    assert_eq!(found.due >> lane & 1 == 0, waits);
                    assert!(!waits || found.gap[lane].to_bits() == (probe.gap - moved).to_bits());
                    tested += u32::from(!waits);
                    waited += u32::from(waits);
                    let dynamic = a.is_dynamic() && b.is_dynamic();
                    on_course += u32::from(dynamic && margin > a.extent.min(b.extent));
                }
            }
        }
        assert!(tested > 1000 && waited > 1000 && on_course > 50, "{tested} {waited} {on_course}");
    }

    /// The heap, with a long arm that sweeps through it about its end, and a plate above it.
    fn swept_heap() -> (World, crate::BodyId) {
        let mut world = heap();
        let arm = ShapeDef::box_half(vec3(1.5, 0.05, 0.05)).with_position(vec3(1.5, 0.0, 0.0));
        let arm = BodyDef::kinematic()
            .with_position(vec3(-1.0, 0.3, -1.0))
            .with_angular_velocity(vec3(0.0, -3.0, 0.0))
            .with_shape(arm);
        world.add_body(arm).unwrap();
        let plate = BodyDef::fixed().with_shape(ShapeDef::box_half(vec3(2.0, 0.02, 2.0)));
        let plate = world.add_body(plate.with_position(vec3(0.0, 5.0, 0.0))).unwrap();
        (world, plate)
    }

    #[test]
    fn what_waits_has_nothing_within_reach() {
        let (mut world, plate) = swept_heap();
        let dt = 1.0 / 60.0;
        let ctx = StepContext::new(&WorldConfig::default(), dt, dt, SimdLevel::best().0);
        let (mut near, mut waited) = (0, 0);
        for step in 0..150_u8 {
            world.step(dt);
            if step % 5 == 4 {
                // The plate jumps, down on the heap.
                let pose = Pose::new(vec3(0.5, 1.5 - 0.006 * f32::from(step), 0.5), Quat::IDENTITY);
                world.body_mut(plate).unwrap().set_pose(pose);
            }
            let mut now = world.clone();
            let tables = now.tables_mut();
            look_ahead(&ctx, &mut tables.bodies, &Jobs::Inline);
            let (bodies, shapes) = (&tables.bodies, &tables.shapes);
            let margin = Track::at_least(ctx.margin * ctx.per_track);
            let contacts = &tables.contacts;
            for watch in contacts.awake_watches() {
                let contact = contacts.at(watch.row());
                let (a, b) = (bodies.at(watch.body_a), bodies.at(watch.body_b));
                let (x, y) = (shapes.at(contact.shape_a), shapes.at(contact.shape_b));
                let reach = speculative_margin(&ctx, a, b, watch.bounces());
                let b_in_a = x.placed(a).relative(&y.placed(b));
                let cache = &mut PairCache::default();
                let is_near =
                    collide(ctx.level, &x.solid, &y.solid, &b_in_a, reach, cache).count > 0;
                let waits = watch.waits(margin, &bodies.tracks);
                assert!(!(waits && is_near), "{step}: {watch:?}");
                near += u32::from(is_near);
                waited += u32::from(waits);
            }
        }
        assert!(near > 1000 && waited > 1000, "{near} {waited}");
    }
}
