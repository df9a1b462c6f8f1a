//! Free rotation of rigid bodies: one, and eight at a time.
//!
//! Twice the energy is a |l|² + (b - a) l_b² + (c - a) l_c², where a is the middle one of the inverse moments:
//! the first term turns the body about its momentum, which commutes with all and is done at once; the others
//! are turns about two principal axes, put together b(h/2) c(h) b(h/2) [Dullweber97] [Touma94]. Each is
//! orthogonal, so the momentum is kept; their angles are differences of rates, so a body of two equal moments
//! turns exactly, in one part. In double precision: rounding of `f32` at every step would let the momentum
//! wander by 1e-5 in seconds.
//!
//! What flies is turned by [`Spins`], eight bodies at a time, lane by lane with the bits of [`rotate_freely`]:
//! the same operations in the same order, and a lane that needs fewer parts or doublings than its neighbors
//! keeps what it has. So it does not show which bodies were turned together.

use fearless_simd::{Simd, SimdBase, SimdFloat, SimdMask, dispatch};

use crate::base::disjoint::Rows;
use crate::base::double::{DQuat, DVec3};
use crate::base::double_wide::{
    DLanes, DMask, DQuatw, DVec3w, DWide, load, select, splat, widened,
};
use crate::base::math::Vec3;
use crate::base::quat::Quat;
use crate::base::wide::LANES;
use crate::state::bodies::Body;
use crate::step::context::StepContext;

/// The largest turn of one symplectic rotation step [rad]. The error of Strang splitting in a step is
/// at most about a twelfth of its cube, 7e-7 rad here, and its period is off by the square.
const LARGEST_TURN: f64 = 0.02;

/// The same for what turns by several radians in a step, with more parts: the energy comes and goes by
/// about a 24th of its square, 0.4 %. With the substeps alone it came and went by twice itself at 3,000 rad/s.
const COARSE_TURN: f64 = 0.3;
const MOST_PARTS: u32 = 256;

/// How many parts of a step a free rotation takes by two turns of these sizes [rad]: as many as the
/// substeps for a fast one. What they do not commute by is a product of three angles.
fn turning_parts(substeps: u32, a: f64, b: f64) -> u32 {
    let product = a * b * (a + b);
    let mut parts = 1;
    let mut reach = LARGEST_TURN;
    while parts < substeps && reach * reach * reach < product {
        parts += 1;
        reach += LARGEST_TURN;
    }
    let enough = |parts: u32| {
        let reach = COARSE_TURN * f64::from(parts);
        reach * reach * reach >= product
    };
    while parts < MOST_PARTS && !enough(parts) {
        parts += 1;
    }
    parts
}

/// Free rotation of one body in the time `dt`.
pub(super) fn rotate_freely(spin: &Spin, w: DVec3, dt: f32, substeps: u32) -> Turned {
    if w == DVec3::ZERO {
        return Turned { rotation: spin.rotation, w: Vec3::ZERO, w_rest: Vec3::ZERO };
    }
    let principal = DQuat::widened(spin.principal);
    let q = DQuat::widened(spin.rotation).times(principal).normalized();
    let m = DVec3::from(spin.moments);
    let local = q.unrotate(w);
    let l = DVec3 { x: local.x * m.x, y: local.y * m.y, z: local.z * m.z };
    let (momentum, size) = (q.rotate(l), l.length());
    let dt = f64::from(dt);
    let inverse = DVec3 { x: 1.0 / m.x, y: 1.0 / m.y, z: 1.0 / m.z };
    let order = Order::of(inverse);
    let [b, a, c] = order.apply(inverse, 1.0);
    let rates = [dt * (b - a), dt * (c - a)];
    let parts = turning_parts(substeps, (size * rates[0]).abs(), (size * rates[1]).abs());
    // Half an angle in a part for each unit of momentum.
    let [b, c] = [0.5 * rates[0] / f64::from(parts), 0.5 * rates[1] / f64::from(parts)];
    let [x, y, z] = order.apply(q.v, order.sign);
    let mut top = Top { q: [x, y, z, q.w], l: order.apply(l, order.sign) };
    top.turn([0, 1, 2], 0.5 * b);
    for part in 1..=parts {
        top.turn([2, 0, 1], c);
        top.turn([0, 1, 2], if part < parts { b } else { 0.5 * b });
    }
    let (sine, cosine) = half_turn(0.5 * dt * a * size);
    let about = DQuat { v: momentum * (sine / size), w: cosine };
    let [x, y, z, scalar] = top.q;
    let q = about.times(DQuat { v: order.undo([x, y, z], order.sign), w: scalar }).normalized();
    // The world's momentum is that of the step's start: rounding cannot spin a body up or down.
    let l = q.unrotate(momentum);
    let local = DVec3 { x: l.x * inverse.x, y: l.y * inverse.y, z: l.z * inverse.z };
    let rotation = q.times(DQuat { v: -principal.v, w: principal.w }).normalized();
    Turned::rounded(rotation.single(), spin.principal, local)
}

/// What turns freely: an orientation, and the principal axes [body] and moments [kg m²] that it turns by.
pub(super) struct Spin {
    pub(super) rotation: Quat,
    pub(super) principal: Quat,
    pub(super) moments: Vec3,
}

impl Spin {
    pub(super) fn of(body: &Body) -> Self {
        Self { rotation: body.rotation, principal: body.principal, moments: body.moments }
    }
}

/// What free rotation makes of it.
pub(super) struct Turned {
    pub(super) rotation: Quat,
    pub(super) w: Vec3,
    pub(super) w_rest: Vec3,
}

impl Turned {
    /// Angular velocity with this part along the principal axes, and what its rounding leaves: what the body
    /// turns with in its own axes stays exact, rounding of the orientation too. Near the middle axis a body
    /// is on its way between two flips for as long as its energy is near that of a turn about this axis, and by
    /// rounding to `f32` alone it was 0.2 s late after 20 s.
    fn rounded(rotation: Quat, principal: Quat, local: DVec3) -> Self {
        let q = DQuat::widened(rotation).times(DQuat::widened(principal)).normalized();
        let exact = q.rotate(local);
        let w = exact.single();
        Self { rotation, w, w_rest: (exact - DVec3::from(w)).single() }
    }
}

/// The axes in rising order of a number; `sign` is -1 where that order is left-handed: a rotation's
/// axis and a momentum then change their sign with it.
#[derive(Clone, Copy)]
struct Order {
    axes: [usize; 3],
    sign: f64,
}

impl Order {
    fn of(v: DVec3) -> Self {
        let up = |a: f64, b: f64| a <= b;
        let (axes, sign) = match (up(v.x, v.y), up(v.y, v.z), up(v.x, v.z)) {
            (true, true, _) => ([0, 1, 2], 1.0),
            (true, false, true) => ([0, 2, 1], -1.0),
            (true, false, false) => ([2, 0, 1], 1.0),
            (false, true, true) => ([1, 0, 2], -1.0),
            (false, true, false) => ([1, 2, 0], 1.0),
            (false, false, _) => ([2, 1, 0], -1.0),
        };
        Self { axes, sign }
    }

    fn apply(&self, v: DVec3, sign: f64) -> [f64; 3] {
        let (v, [i, j, k]) = ([v.x, v.y, v.z], self.axes);
        [sign * v[i], sign * v[j], sign * v[k]]
    }

    fn undo(&self, v: [f64; 3], sign: f64) -> DVec3 {
        let mut out = [0.0; 3];
        for (x, axis) in v.into_iter().zip(self.axes) {
            out[axis] = sign * x;
        }
        let [x, y, z] = out;
        DVec3 { x, y, z }
    }
}

/// Two numbers, not both small, in proportion to sine and cosine of `x`: of small angles by the
/// continued fraction of the tangent, 1.3e-8 off at most, of others by doubling.
#[inline(always)]
fn half_turn(x: f64) -> (f64, f64) {
    let (mut part, mut doublings) = (x, 0);
    // Nothing turns by a million radians in a step in earnest.
    while part.abs() > 0.25 && doublings < 24 {
        part *= 0.5;
        doublings += 1;
    }
    let square = part * part;
    let (mut sine, mut cosine) = (part * (1.0 - square * (1.0 / 15.0)), 1.0 - 0.4 * square);
    if doublings > 0 {
        let k = 1.0 / (sine * sine + cosine * cosine).sqrt();
        (sine, cosine) = (k * sine, k * cosine);
        for _ in 0..doublings {
            (sine, cosine) = (2.0 * sine * cosine, cosine * cosine - sine * sine);
        }
    }
    (sine, cosine)
}

/// A spinning body: orientation (a quaternion of any length) and momentum in its own frame.
struct Top {
    q: [f64; 4],
    l: [f64; 3],
}

impl Top {
    /// A turn about axis `i` by twice `rate` times the momentum about it; the quaternion's length is
    /// left for later. `[i, j, k]` are the axes in cyclic order.
    #[inline(always)]
    fn turn(&mut self, [i, j, k]: [usize; 3], rate: f64) {
        let (q, l) = (&mut self.q, &mut self.l);
        let half = rate * l[i];
        if half == 0.0 {
            return;
        }
        let (s, c) = half_turn(half);
        let scale = 1.0 / (c * c + s * s);
        let (cos, sin) = ((c * c - s * s) * scale, 2.0 * s * c * scale);
        (l[j], l[k]) = (cos * l[j] + sin * l[k], cos * l[k] - sin * l[j]);
        (q[i], q[j], q[k], q[3]) =
            (c * q[i] + s * q[3], c * q[j] + s * q[k], c * q[k] - s * q[j], c * q[3] - s * q[i]);
    }
}

/// Bodies that are to be turned freely, in two lists: those of two equal moments turn in one part, which a
/// neighbor that takes eight would make as slow as itself.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Spins {
    rows: [[u32; LANES]; 2],
    counts: [usize; 2],
}

impl Spins {
    /// Enters a body, and turns eight when there are that many.
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

    /// Turns those that are left.
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
            // Idle lanes do what the first one does.
            let row = rows.get(lane).or(rows.first());
            if let Some(body) = row.and_then(|row| bodies.read(*row as usize).as_ref()) {
                let w = DVec3::from(body.w) + DVec3::from(body.w_rest);
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

/// What free rotation makes of the angular velocities [rad/s] of up to eight bodies; 0 where there is none.
pub(super) fn turned_eight(
    ctx: &StepContext,
    spins: &[Option<(Spin, Vec3)>; LANES],
) -> [Vec3; LANES] {
    let mut turned = [Vec3::ZERO; LANES];
    let Some(first) = spins.iter().flatten().next() else { return turned };
    // Of few, lanes are no faster.
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
        // Idle lanes do what the first one does.
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

/// What is read of eight bodies that turn freely.
#[derive(Clone, Debug, Default)]
#[repr(C, align(64))]
struct Tops {
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
    fn fill(&mut self, lane: usize, spin: &Spin, w: DVec3) {
        let (q, p) = (spin.rotation.to_array(), spin.principal.to_array());
        for i in 0..4 {
            (self.rotation[i][lane], self.principal[i][lane]) = (q[i], p[i]);
        }
        (self.w[0][lane], self.w[1][lane], self.w[2][lane]) = (w.x, w.y, w.z);
        let m = spin.moments.to_array();
        // Moments are above 0, and of different `f32` the inverse is different too.
        let order = Order::of(-DVec3::from(spin.moments));
        for i in 0..3 {
            self.moments[i][lane] = m[i];
            self.axes[i][lane] = [0.0, 1.0, 2.0][order.axes[i]];
        }
        self.sign[lane] = order.sign;
    }
}

/// What free rotation makes of eight bodies.
#[derive(Clone, Debug, Default)]
#[repr(C, align(64))]
struct Ends {
    rotation: [[f32; LANES]; 4],
    w: [DLanes; 3],
}

impl Ends {
    fn w(&self, lane: usize) -> DVec3 {
        DVec3 { x: self.w[0][lane], y: self.w[1][lane], z: self.w[2][lane] }
    }

    #[inline(always)]
    fn put(&self, lane: usize, body: &mut Body) {
        let [x, y, z, w] = &self.rotation;
        body.rotation = Quat::new(x[lane], y[lane], z[lane], w[lane]);
        let exact = self.w(lane);
        body.w = exact.single();
        body.w_rest = (exact - DVec3::from(body.w)).single();
    }
}

/// As [`rotate_freely`].
#[inline(always)]
fn turn_eight<S: Simd>(simd: S, tops: &Tops, dt: f32, substeps: u32, ends: &mut Ends) {
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
    let most = count.iter().fold(1, |most, parts| most.max(*parts as u32));
    top.turn(simd, [0, 1, 2], half * b, parts.simd_ge(one));
    for part in 1..=most {
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

/// As [`turning_parts`].
#[inline(always)]
fn parts_of<S: Simd>(simd: S, substeps: u32, a: DWide<S>, b: DWide<S>) -> DWide<S> {
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
    let most = splat(simd, f64::from(MOST_PARTS));
    loop {
        let reach = splat(simd, COARSE_TURN) * parts;
        let enough = (reach * reach * reach).simd_ge(product);
        let more = most.simd_gt(parts) & !enough;
        if !more.any_true() {
            return parts;
        }
        parts = select(more, parts + one, parts);
    }
}

/// As [`half_turn`].
#[inline(always)]
fn half_turns<S: Simd>(simd: S, x: DWide<S>) -> (DWide<S>, DWide<S>) {
    let (one, half, two) = (splat(simd, 1.0), splat(simd, 0.5), splat(simd, 2.0));
    let (mut part, mut doublings, mut most) = (x, splat(simd, 0.0), 0_u32);
    while most < 24 {
        let far = part.abs().simd_gt(splat(simd, 0.25));
        if !far.any_true() {
            break;
        }
        part = select(far, part * half, part);
        doublings = select(far, doublings + one, doublings);
        most += 1;
    }
    let square = part * part;
    let mut sine = part * (one - square * splat(simd, 1.0 / 15.0));
    let mut cosine = one - splat(simd, 0.4) * square;
    if most > 0 {
        let k = one / (sine * sine + cosine * cosine).sqrt();
        let doubled = doublings.simd_gt(splat(simd, 0.0));
        (sine, cosine) = (select(doubled, k * sine, sine), select(doubled, k * cosine, cosine));
        for done in 0..most {
            let more = doublings.simd_gt(splat(simd, f64::from(done)));
            let (s, c) = (two * sine * cosine, cosine * cosine - sine * sine);
            (sine, cosine) = (select(more, s, sine), select(more, c, cosine));
        }
    }
    (sine, cosine)
}

/// Eight of [`Order`]: whether the first, second and third axis is x, and whether it is y.
struct Orders<S: Simd> {
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

/// Eight of [`Top`].
struct Topw<S: Simd> {
    q: [DWide<S>; 4],
    l: [DWide<S>; 3],
}

impl<S: Simd> Topw<S> {
    /// As [`Top::turn`], where `turns`.
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

#[cfg(test)]
mod tests {
    use super::{Spin, Spins, rotate_freely, turned_eight};
    use crate::base::disjoint::{Apart, Rows};
    use crate::base::double::DVec3;
    use crate::base::math::{Vec3, vec3};
    use crate::base::random::Random;
    use crate::base::wide::{LANES, SimdLevel};
    use crate::state::bodies::Body;
    use crate::state::config::WorldConfig;
    use crate::state::def::{BodyDef, ShapeDef};
    use crate::step::context::StepContext;
    use crate::world::World;

    /// Boxes of all orders of sides, some of two equal ones, that turn slowly, fast, or about one axis.
    fn spinning() -> Vec<Option<Body>> {
        let mut world = World::default();
        let mut random = Random::new(7);
        #[expect(clippy::cast_possible_truncation, reason = "any number will do")]
        let mut between = |least: f32, most: f32| least + (most - least) * random.unit() as f32;
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
        // Some steps later they stand askew, and rounding has left something.
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
                spins.add(&ctx, row, body.as_ref().map_or(Vec3::ONE, |b| b.moments), &rows);
            }
            spins.finish(&ctx, &rows);
            let mut rested = 0;
            for (a, b) in alone.iter().flatten().zip(together.iter().flatten()) {
                let w = DVec3::from(a.w) + DVec3::from(a.w_rest);
                let turned = rotate_freely(&Spin::of(a), w, ctx.dt, ctx.substeps);
                let bits = |x: [f32; 4]| x.map(f32::to_bits);
                let of = |v: Vec3| bits([v.x, v.y, v.z, 0.0]);
                assert_eq!(bits(b.rotation.to_array()), bits(turned.rotation.to_array()));
                assert_eq!((of(b.w), of(b.w_rest)), (of(turned.w), of(turned.w_rest)));
                rested += usize::from(a.w_rest != Vec3::ZERO);
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
