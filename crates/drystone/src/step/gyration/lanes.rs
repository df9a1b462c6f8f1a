//! Free rotation of eight bodies at a time.

use fearless_simd::{Simd, SimdBase, SimdFloat, SimdMask, dispatch};

use super::{COARSE_TURN, LARGEST_TURN, MAX_PARTS, Order, Spin, rotate_freely};
use crate::base::double::DVec3;
use crate::base::math::Vec3;
use crate::base::quat::Quat;
use crate::base::simd::double_wide::{
    DLanes, DMask, DQuatw, DVec3w, DWide, load, select, splat, widened,
};
use crate::base::simd::wide::LANES;
use crate::state::bodies::body::Body;
use crate::step::context::StepContext;

/// Angular velocities of up to eight bodies after a free rotation [rad/s]; 0 for empty slots.
pub(crate) fn turned_eight(
    ctx: &StepContext,
    spins: &[Option<(Spin, Vec3)>; LANES],
) -> [Vec3; LANES] {
    let mut turned = [Vec3::ZERO; LANES];
    let Some(first) = spins.iter().flatten().next() else { return turned };
    // For so few bodies the lanes are no faster.
    if spins.iter().flatten().count() <= 2 {
        for (turned, spin) in turned.iter_mut().zip(spins) {
            if let Some((spin, w)) = spin {
                *turned = rotate_freely(spin, DVec3::from(*w), ctx.dt, ctx.substeps).w;
            }
        }
        return turned;
    }
    let mut tops = Tops::default();
    for (lane, spin) in spins.iter().enumerate() {
        // Idle lanes repeat the first body.
        let (spin, w) = spin.as_ref().unwrap_or(first);
        tops.fill(lane, spin, DVec3::from(*w));
    }
    let mut ends = Ends::default();
    dispatch!(ctx.level, simd => turn_eight(simd, &tops, ctx.dt, ctx.substeps, &mut ends));
    for (lane, (turned, spin)) in turned.iter_mut().zip(spins).enumerate() {
        if spin.is_some() {
            *turned = ends.w(lane).single();
        }
    }
    turned
}

/// Inputs of eight freely turning bodies.
#[derive(Clone, Debug, Default)]
#[repr(C, align(64))]
pub(crate) struct Tops {
    rotation: [[f32; LANES]; 4],
    principal: [[f32; LANES]; 4],
    moments: [[f32; LANES]; 3],
    w: [DLanes; 3],
    /// Numbers of the axes in rising order of the inverse moments, see [`Order`].
    axes: [DLanes; 3],
    sign: DLanes,
}

impl Tops {
    #[inline(always)]
    pub(crate) fn fill(&mut self, lane: usize, spin: &Spin, w: DVec3) {
        let (q, p) = (spin.rotation.to_array(), spin.principal.to_array());
        for i in 0..4 {
            (self.rotation[i][lane], self.principal[i][lane]) = (q[i], p[i]);
        }
        (self.w[0][lane], self.w[1][lane], self.w[2][lane]) = (w.x, w.y, w.z);
        let m = spin.moments.to_array();
        // Moments are above 0, and different `f32` moments have different inverses.
        let order = Order::of(-DVec3::from(spin.moments));
        for i in 0..3 {
            self.moments[i][lane] = m[i];
            self.axes[i][lane] = [0.0, 1.0, 2.0][order.axes[i]];
        }
        self.sign[lane] = order.sign;
    }
}

/// Results of free rotation for eight bodies.
#[derive(Clone, Debug, Default)]
#[repr(C, align(64))]
pub(crate) struct Ends {
    rotation: [[f32; LANES]; 4],
    w: [DLanes; 3],
}

impl Ends {
    fn w(&self, lane: usize) -> DVec3 {
        DVec3 { x: self.w[0][lane], y: self.w[1][lane], z: self.w[2][lane] }
    }

    #[inline(always)]
    pub(crate) fn put(&self, lane: usize, body: &mut Body) {
        let [x, y, z, w] = &self.rotation;
        body.rotation = Quat::new(x[lane], y[lane], z[lane], w[lane]);
        let exact = self.w(lane);
        body.w = exact.single();
        body.history.w_low = (exact - DVec3::from(body.w)).single();
    }
}

/// [`rotate_freely`] for eight bodies.
#[inline(always)]
pub(crate) fn turn_eight<S: Simd>(simd: S, tops: &Tops, dt: f32, substeps: u32, ends: &mut Ends) {
    let (one, half) = (splat(simd, 1.0), splat(simd, 0.5));
    let principal = DQuatw::widened(simd, &tops.principal);
    let q = DQuatw::widened(simd, &tops.rotation).times(principal).normalized(simd);
    let [x, y, z] = &tops.moments;
    let m = DVec3w { x: widened(simd, x), y: widened(simd, y), z: widened(simd, z) };
    let l = q.unrotate(simd, DVec3w::load(simd, &tops.w)).each(m);
    let (momentum, size) = (q.rotate(simd, l), l.length());
    let dt = splat(simd, f64::from(dt));
    let inverse = DVec3w { x: one / m.x, y: one / m.y, z: one / m.z };
    let order = Orders::load(simd, &tops.axes, &tops.sign);
    let [b, a, c] = order.sorted(inverse);
    let rates = [dt * (b - a), dt * (c - a)];
    let parts = parts_of(simd, substeps, (size * rates[0]).abs(), (size * rates[1]).abs());
    let [b, c] = [half * rates[0] / parts, half * rates[1] / parts];
    let ([x, y, z], l) = (order.apply(q.v), order.apply(l));
    let mut top = Topw { q: [x, y, z, q.w], l };
    let mut count = [0.0; LANES];
    parts.store_array(&mut count);
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "1 to MOST_PARTS, or as many substeps"
    )]
    let maximum = count.iter().fold(1, |maximum, parts| maximum.max(*parts as u32));
    top.turn(simd, [0, 1, 2], half * b, parts.simd_ge(one));
    for part in 1..=maximum {
        let part = splat(simd, f64::from(part));
        let takes_part = parts.simd_ge(part);
        top.turn(simd, [2, 0, 1], c, takes_part);
        let rate = select(parts.simd_gt(part), b, half * b);
        top.turn(simd, [0, 1, 2], rate, takes_part);
    }
    let (sine, cosine) = half_turns(simd, half * dt * a * size);
    let about = DQuatw { v: momentum * (sine / size), w: cosine };
    let [x, y, z, scalar] = top.q;
    let q = about.times(DQuatw { v: order.undo([x, y, z]), w: scalar }).normalized(simd);
    let local = q.unrotate(simd, momentum).each(inverse);
    let rotation = q.times(principal.conjugate()).normalized(simd);
    ends.rotation = rotation.single();
    let rounded = DQuatw::widened(simd, &ends.rotation).times(principal).normalized(simd);
    let w = rounded.rotate(simd, local);
    w.x.store_array(&mut ends.w[0]);
    w.y.store_array(&mut ends.w[1]);
    w.z.store_array(&mut ends.w[2]);
}

/// [`turning_parts`] for eight bodies.
#[inline(always)]
pub(crate) fn parts_of<S: Simd>(simd: S, substeps: u32, a: DWide<S>, b: DWide<S>) -> DWide<S> {
    let product = a * b * (a + b);
    let (one, step) = (splat(simd, 1.0), splat(simd, LARGEST_TURN));
    let (mut parts, mut reach) = (one, step);
    for _ in 1..substeps {
        let more = product.simd_gt(reach * reach * reach);
        if !more.any_true() {
            break;
        }
        parts = select(more, parts + one, parts);
        reach = select(more, reach + step, reach);
    }
    let maximum = splat(simd, f64::from(MAX_PARTS));
    loop {
        let reach = splat(simd, COARSE_TURN) * parts;
        let enough = (reach * reach * reach).simd_ge(product);
        let more = maximum.simd_gt(parts) & !enough;
        if !more.any_true() {
            return parts;
        }
        parts = select(more, parts + one, parts);
    }
}

/// [`half_turn`] for eight angles.
#[inline(always)]
fn half_turns<S: Simd>(simd: S, x: DWide<S>) -> (DWide<S>, DWide<S>) {
    let (one, half, two) = (splat(simd, 1.0), splat(simd, 0.5), splat(simd, 2.0));
    let (mut part, mut doublings, mut maximum) = (x, splat(simd, 0.0), 0_u32);
    while maximum < 24 {
        let far = part.abs().simd_gt(splat(simd, 0.25));
        if !far.any_true() {
            break;
        }
        part = select(far, part * half, part);
        doublings = select(far, doublings + one, doublings);
        maximum += 1;
    }
    let square = part * part;
    let mut sine = part * (one - square * splat(simd, 1.0 / 15.0));
    let mut cosine = one - splat(simd, 0.4) * square;
    if maximum > 0 {
        let k = one / (sine * sine + cosine * cosine).sqrt();
        let doubled = doublings.simd_gt(splat(simd, 0.0));
        (sine, cosine) = (select(doubled, k * sine, sine), select(doubled, k * cosine, cosine));
        for done in 0..maximum {
            let more = doublings.simd_gt(splat(simd, f64::from(done)));
            let (s, c) = (two * sine * cosine, cosine * cosine - sine * sine);
            (sine, cosine) = (select(more, s, sine), select(more, c, cosine));
        }
    }
    (sine, cosine)
}

/// Eight [`Order`]s: whether the first, second and third axis is x, and whether it is y.
pub(crate) struct Orders<S: Simd> {
    is_x: [DMask<S>; 3],
    is_y: [DMask<S>; 3],
    sign: DWide<S>,
}

impl<S: Simd> Orders<S> {
    #[inline(always)]
    fn load(simd: S, axes: &[DLanes; 3], sign: &DLanes) -> Self {
        let (zero, one) = (splat(simd, 0.0), splat(simd, 1.0));
        let [i, j, k] = [load(simd, &axes[0]), load(simd, &axes[1]), load(simd, &axes[2])];
        Self {
            is_x: [i.simd_eq(zero), j.simd_eq(zero), k.simd_eq(zero)],
            is_y: [i.simd_eq(one), j.simd_eq(one), k.simd_eq(one)],
            sign: load(simd, sign),
        }
    }

    #[inline(always)]
    fn sorted(&self, v: DVec3w<S>) -> [DWide<S>; 3] {
        let (x, y) = (&self.is_x, &self.is_y);
        [
            select(x[0], v.x, select(y[0], v.y, v.z)),
            select(x[1], v.x, select(y[1], v.y, v.z)),
            select(x[2], v.x, select(y[2], v.y, v.z)),
        ]
    }

    #[inline(always)]
    fn apply(&self, v: DVec3w<S>) -> [DWide<S>; 3] {
        let [i, j, k] = self.sorted(v);
        [self.sign * i, self.sign * j, self.sign * k]
    }

    #[inline(always)]
    fn undo(&self, [i, j, k]: [DWide<S>; 3]) -> DVec3w<S> {
        let (x, y) = (&self.is_x, &self.is_y);
        let [i, j, k] = [self.sign * i, self.sign * j, self.sign * k];
        DVec3w {
            x: select(x[0], i, select(x[1], j, k)),
            y: select(y[0], i, select(y[1], j, k)),
            z: select(x[0] | y[0], select(x[1] | y[1], k, j), i),
        }
    }
}

/// Eight [`Top`]s.
pub(crate) struct Topw<S: Simd> {
    q: [DWide<S>; 4],
    l: [DWide<S>; 3],
}

impl<S: Simd> Topw<S> {
    /// [`Top::turn`] for the lanes in `turns`.
    #[inline(always)]
    fn turn(&mut self, simd: S, [i, j, k]: [usize; 3], rate: DWide<S>, turns: DMask<S>) {
        let (q, l) = (&mut self.q, &mut self.l);
        let half = rate * l[i];
        let turns = turns & !half.simd_eq(splat(simd, 0.0));
        if !turns.any_true() {
            return;
        }
        let (s, c) = half_turns(simd, half);
        let scale = splat(simd, 1.0) / (c * c + s * s);
        let (cos, sin) = ((c * c - s * s) * scale, splat(simd, 2.0) * s * c * scale);
        let turned = [cos * l[j] + sin * l[k], cos * l[k] - sin * l[j]];
        (l[j], l[k]) = (select(turns, turned[0], l[j]), select(turns, turned[1], l[k]));
        let turned =
            [c * q[i] + s * q[3], c * q[j] + s * q[k], c * q[k] - s * q[j], c * q[3] - s * q[i]];
        q[i] = select(turns, turned[0], q[i]);
        q[j] = select(turns, turned[1], q[j]);
        q[k] = select(turns, turned[2], q[k]);
        q[3] = select(turns, turned[3], q[3]);
    }
}
