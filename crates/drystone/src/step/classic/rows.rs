//! Rows of the classic methods: single bodies and pairs, in plain velocities.
//!
//! Symbols: n: normal from A to B; u: velocity of B's point less that of A's; s: separation; K:
//! collision matrix (base/collision.rs); j: impulse on B, the opposite on A.

use crate::base::collision::{mobility, push};
use crate::base::math::Vec3;
use crate::base::sym3::Sym3;

/// A body; row 0 stands for everything that never moves.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Mover {
    pub(crate) v: Vec3,
    pub(crate) w: Vec3,
    /// Motion since the step's start: of the center [m], and as a rotation vector [rad].
    pub(crate) x: Vec3,
    pub(crate) t: Vec3,
    /// For each world axis; 0 if it is locked, and for bodies that cannot be pushed.
    pub(crate) inv_mass: Vec3,
    pub(crate) inv_inertia: Sym3,
    /// Velocity change by forces and free rotation in a substep, and the factor by damping.
    pub(crate) add_v: Vec3,
    pub(crate) add_w: Vec3,
    pub(crate) decay_v: f32,
    pub(crate) decay_w: f32,
    /// Velocity before the last forces.
    pub(crate) old_v: Vec3,
    pub(crate) old_w: Vec3,
    /// Level in the contact graph; 0: cannot be pushed.
    pub(crate) level: u32,
    /// Shock propagation has passed it.
    pub(crate) frozen: bool,
    /// Some row pushed it in this step.
    pub(crate) pushed: bool,
}

impl Mover {
    /// True if no impulse can move it.
    pub(crate) fn is_fixed(&self) -> bool {
        self.inv_mass == Vec3::ZERO && self.inv_inertia == Sym3::ZERO
    }

    fn velocity_at(&self, r: Vec3) -> Vec3 {
        self.v + self.w.cross(r)
    }

    /// Its part of the collision matrix.
    pub(crate) fn mobility(&self, r: Vec3) -> Sym3 {
        if self.frozen || self.is_fixed() {
            return Sym3::ZERO;
        }
        mobility(self.inv_mass, &self.inv_inertia, r)
    }

    /// Change of its angular velocity by an angular impulse.
    pub(crate) fn turns_by(&self, j: Vec3) -> Vec3 {
        if self.frozen { Vec3::ZERO } else { self.inv_inertia.mul(j) }
    }

    pub(crate) fn take_turn(&mut self, j: Vec3) {
        if !self.frozen {
            self.w += self.inv_inertia.mul(j);
            self.pushed = true;
        }
    }

    pub(crate) fn take(&mut self, r: Vec3, j: Vec3) {
        if !self.frozen {
            self.v += push(self.inv_mass, j);
            self.w += self.inv_inertia.mul(r.cross(j));
            self.pushed = true;
        }
    }

    /// Displaces its position as an impulse would change its velocity.
    fn shift(&mut self, r: Vec3, j: Vec3) {
        if !self.frozen {
            self.x += push(self.inv_mass, j);
            self.t += self.inv_inertia.mul(r.cross(j));
            self.pushed = true;
        }
    }
}

/// A point of a pair.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct PairPoint {
    pub(crate) r_a: Vec3,
    pub(crate) r_b: Vec3,
    /// Separation at the step's start [m].
    pub(crate) s0: f32,
    /// Impulse of the substep along the normal, and along the surface [N s].
    pub(crate) press: f32,
    pub(crate) rub: Vec3,
    /// Approach velocity for the bounce: velocity along the normal at the substep's start, or 0.
    pub(crate) arrival: f32,
}

/// Two bodies in contact.
#[derive(Clone, Debug, Default)]
pub(crate) struct Pair {
    /// Row of the contact.
    pub(crate) contact: u32,
    pub(crate) a: u32,
    pub(crate) b: u32,
    pub(crate) normal: Vec3,
    /// Static and kinetic.
    pub(crate) friction: [f32; 2],
    pub(crate) restitution: f32,
    /// Resistance to rolling and spinning, times radius [m].
    pub(crate) rolling: f32,
    pub(crate) spinning: f32,
    /// Surface velocity over the bodies: B's less A's [m/s].
    pub(crate) belt: Vec3,
    pub(crate) count: u8,
    pub(crate) points: [PairPoint; 4],
    /// Level of the higher body.
    pub(crate) level: u32,
    /// Some point of it pushed in this step.
    pub(crate) pressed: bool,
}

impl Pair {
    pub(crate) fn points(&self) -> &[PairPoint] {
        &self.points[..usize::from(self.count.min(4))]
    }

    /// Velocity of B's point less that of A's [m/s].
    pub(crate) fn slip(&self, p: &PairPoint, movers: &[Mover]) -> Vec3 {
        let (a, b) = (&movers[self.a as usize], &movers[self.b as usize]);
        b.velocity_at(p.r_b) - a.velocity_at(p.r_a) + self.belt
    }

    /// Current separation [m]; normal and lever arms are those of the step's start.
    pub(crate) fn separation(&self, p: &PairPoint, movers: &[Mover]) -> f32 {
        let (a, b) = (&movers[self.a as usize], &movers[self.b as usize]);
        let moved = b.x + b.t.cross(p.r_b) - a.x - a.t.cross(p.r_a);
        p.s0 + self.normal.dot(moved)
    }

    pub(crate) fn matrix(&self, p: &PairPoint, movers: &[Mover]) -> Sym3 {
        let (a, b) = (&movers[self.a as usize], &movers[self.b as usize]);
        a.mobility(p.r_a).plus(b.mobility(p.r_b))
    }

    /// Applies an impulse at a point.
    pub(crate) fn push(&self, p: &PairPoint, j: Vec3, movers: &mut [Mover]) {
        movers[self.a as usize].take(p.r_a, -j);
        movers[self.b as usize].take(p.r_b, j);
    }

    /// Applies an impulse at a point to positions.
    pub(crate) fn shift(&self, p: &PairPoint, j: Vec3, movers: &mut [Mover]) {
        movers[self.a as usize].shift(p.r_a, -j);
        movers[self.b as usize].shift(p.r_b, j);
    }

    /// Applies rolling and spinning resistance of a contact under the normal impulse `press` [N s].
    pub(crate) fn resist_rolling(&self, press: f32, movers: &mut [Mover]) {
        if !(self.rolling > 0.0 || self.spinning > 0.0) || press <= 0.0 {
            return;
        }
        let (a, b) = (&movers[self.a as usize], &movers[self.b as usize]);
        let inertia = |m: &Mover| if m.frozen { Sym3::ZERO } else { m.inv_inertia };
        let Some(k) = inertia(a).plus(inertia(b)).inverse() else { return };
        // The angular impulse that would stop all rotation; each part is then clamped to its limit.
        let l = -k.mul(b.w - a.w);
        let spin = self.normal * l.dot(self.normal);
        let roll = l - spin;
        let limited = |v: Vec3, maximum: f32| {
            let size = v.length();
            if size > maximum { v * (maximum / size) } else { v }
        };
        let l = limited(spin, self.spinning * press) + limited(roll, self.rolling * press);
        for (row, sign) in [(self.a, -1.0), (self.b, 1.0)] {
            let mover = &mut movers[row as usize];
            if !mover.frozen {
                mover.w += mover.inv_inertia.mul(l) * sign;
            }
        }
    }
}
