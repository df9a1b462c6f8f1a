//! Free rotation of rigid bodies: one, and eight at a time.
//!
//! Twice the energy is a |l|² + (b - a) l_b² + (c - a) l_c², where a is the middle one of the
//! inverse moments. The first term turns the body about its momentum; it commutes with the others
//! and is applied at once. The others are turns about two principal axes, composed as b(h/2) c(h)
//! b(h/2) [Dullweber97] [Touma94]. Each factor is orthogonal, so the momentum is conserved. The
//! angles are differences of rates, so a body with two equal moments turns exactly, in one part.
//! All of it is in double precision: rounding to `f32` at every step would let the momentum wander
//! by 1e-5 in seconds.
//!
//! [`Spins`] rotates free bodies eight at a time. Each lane has the same bits as [`rotate_freely`]:
//! the operations and their order are the same, and a lane that needs fewer parts or doublings than
//! its neighbors keeps its value. So the result does not depend on which bodies share a group.

pub(crate) mod lanes;

use crate::base::double::{DQuat, DVec3};
use crate::base::math::Vec3;
use crate::base::quat::Quat;
use crate::state::bodies::body::Body;

/// Maximum turn of one symplectic rotation step [rad]. The error of Strang splitting in a step is
/// at most about a twelfth of its cube, 7e-7 rad here, and its period is off by the square.
const LARGEST_TURN: f64 = 0.02;

/// Maximum turn of one rotation step for bodies that turn by several radians in a step, which take
/// more parts [rad]. The energy oscillates by about a 24th of its square, 0.4 %. With the substeps
/// alone it oscillated by twice itself at 3,000 rad/s.
const COARSE_TURN: f64 = 0.3;

const MAX_PARTS: u32 = 256;

/// Number of parts that a free rotation by two turns of these sizes [rad] takes in a step: as many
/// as the substeps for a fast one. The commutator error is a product of three angles.
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
    while parts < MAX_PARTS && !enough(parts) {
        parts += 1;
    }
    parts
}

/// Free rotation of one body over the time `dt`.
pub(crate) fn rotate_freely(spin: &Spin, w: DVec3, dt: f32, substeps: u32) -> Turned {
    if w == DVec3::ZERO {
        return Turned { rotation: spin.rotation, w: Vec3::ZERO, w_low: Vec3::ZERO };
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
    // Half the angle of a part, per unit of momentum.
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
    // The momentum in the world frame is that of the step's start: rounding cannot spin a body up
    // or down.
    let l = q.unrotate(momentum);
    let local = DVec3 { x: l.x * inverse.x, y: l.y * inverse.y, z: l.z * inverse.z };
    let rotation = q.times(DQuat { v: -principal.v, w: principal.w }).normalized();
    Turned::rounded(rotation.single(), spin.principal, local)
}

/// A freely turning body: its orientation, and its principal axes [body] and moments [kg m²].
pub(crate) struct Spin {
    pub(crate) rotation: Quat,
    pub(crate) principal: Quat,
    pub(crate) moments: Vec3,
}

impl Spin {
    pub(crate) fn of(body: &Body) -> Self {
        Self {
            rotation: body.rotation,
            principal: body.inertia.principal,
            moments: body.inertia.moments,
        }
    }
}

/// Result of a free rotation.
pub(crate) struct Turned {
    pub(crate) rotation: Quat,
    pub(crate) w: Vec3,
    pub(crate) w_low: Vec3,
}

impl Turned {
    /// Angular velocity with the part `local` along the principal axes, and its rounding remainder.
    /// So the angular velocity in the body frame stays exact, including the rounding of the
    /// orientation. Near the middle axis a body stays between two flips for as long as its energy
    /// is near that of a turn about this axis; by rounding to `f32` alone it was 0.2 s late after
    /// 20 s.
    fn rounded(rotation: Quat, principal: Quat, local: DVec3) -> Self {
        let q = DQuat::widened(rotation).times(DQuat::widened(principal)).normalized();
        let exact = q.rotate(local);
        let w = exact.single();
        Self { rotation, w, w_low: (exact - DVec3::from(w)).single() }
    }
}

/// The axes in rising order of a number. `sign` is -1 where that order is left-handed: the axis of
/// a rotation and a momentum then change sign.
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

/// Two numbers, not both small, in proportion to sine and cosine of `x`. Small angles use the
/// continued fraction of the tangent, at most 1.3e-8 off; larger ones use doubling.
#[inline(always)]
fn half_turn(x: f64) -> (f64, f64) {
    let (mut part, mut doublings) = (x, 0);
    // No real body turns by a million radians in a step.
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
    /// Turns about axis `i` by twice `rate` times the momentum about it; does not normalize the
    /// quaternion. `[i, j, k]` are the axes in cyclic order.
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
