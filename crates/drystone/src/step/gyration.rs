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

pub(crate) mod lanes;

use crate::base::double::{DQuat, DVec3};
use crate::base::math::Vec3;
use crate::base::quat::Quat;
use crate::state::bodies::Body;

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
pub(crate) fn rotate_freely(spin: &Spin, w: DVec3, dt: f32, substeps: u32) -> Turned {
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
pub(crate) struct Spin {
    pub(crate) rotation: Quat,
    pub(crate) principal: Quat,
    pub(crate) moments: Vec3,
}

impl Spin {
    pub(crate) fn of(body: &Body) -> Self {
        Self { rotation: body.rotation, principal: body.principal, moments: body.moments }
    }
}

/// What free rotation makes of it.
pub(crate) struct Turned {
    pub(crate) rotation: Quat,
    pub(crate) w: Vec3,
    pub(crate) w_rest: Vec3,
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
