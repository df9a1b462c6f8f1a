//! Vectors, rotations, and spatial vectors: motions (angular, linear) and forces (moment, force).
//!
//! All stand in world axes at one common point. So no transformation between links is needed:
//! inertias, forces and motions of different links add as they are [Featherstone08].

use core::ops::{Add, Mul, Neg, Sub};

use super::number::Number;

/// A vector of three components.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Vector<N>(pub(crate) [N; 3]);

impl<N: Number> Vector<N> {
    #[inline(always)]
    pub(super) fn zero() -> Self {
        Self([N::zero(); 3])
    }

    #[inline(always)]
    pub(super) fn splat(v: [f64; 3]) -> Self {
        Self(v.map(N::splat))
    }

    #[inline(always)]
    pub(super) fn dot(self, o: Self) -> N {
        self.0[0] * o.0[0] + self.0[1] * o.0[1] + self.0[2] * o.0[2]
    }

    #[inline(always)]
    pub(super) fn cross(self, o: Self) -> Self {
        let ([a, b, c], [x, y, z]) = (self.0, o.0);
        Self([b * z - c * y, c * x - a * z, a * y - b * x])
    }

    #[inline(always)]
    pub(super) fn length(self) -> N {
        self.dot(self).sqrt()
    }
}

impl<N: Number> Add for Vector<N> {
    type Output = Self;
    #[inline(always)]
    fn add(self, o: Self) -> Self {
        Self([self.0[0] + o.0[0], self.0[1] + o.0[1], self.0[2] + o.0[2]])
    }
}

impl<N: Number> Sub for Vector<N> {
    type Output = Self;
    #[inline(always)]
    fn sub(self, o: Self) -> Self {
        Self([self.0[0] - o.0[0], self.0[1] - o.0[1], self.0[2] - o.0[2]])
    }
}

impl<N: Number> Neg for Vector<N> {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        Self([-self.0[0], -self.0[1], -self.0[2]])
    }
}

impl<N: Number> Mul<N> for Vector<N> {
    type Output = Self;
    #[inline(always)]
    fn mul(self, s: N) -> Self {
        Self([self.0[0] * s, self.0[1] * s, self.0[2] * s])
    }
}

/// A unit quaternion: real part first, then i, j, k.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Rotation<N>(pub(crate) [N; 4]);

impl<N: Number> Rotation<N> {
    #[inline(always)]
    pub(super) fn identity() -> Self {
        Self([N::one(), N::zero(), N::zero(), N::zero()])
    }

    #[inline(always)]
    pub(super) fn splat(q: [f64; 4]) -> Self {
        Self(q.map(N::splat))
    }

    #[inline(always)]
    fn parts(self) -> (N, Vector<N>) {
        (self.0[0], Vector([self.0[1], self.0[2], self.0[3]]))
    }

    #[inline(always)]
    fn new(w: N, v: Vector<N>) -> Self {
        Self([w, v.0[0], v.0[1], v.0[2]])
    }

    /// The rotation `o`, followed by `self`.
    #[inline(always)]
    pub(super) fn times(self, o: Self) -> Self {
        let ((a, u), (b, v)) = (self.parts(), o.parts());
        Self::new(a * b - u.dot(v), v * a + u * b + u.cross(v))
    }

    #[inline(always)]
    pub(super) fn inverse(self) -> Self {
        let (w, v) = self.parts();
        Self::new(w, -v)
    }

    #[inline(always)]
    pub(super) fn rotate(self, p: Vector<N>) -> Vector<N> {
        let (w, v) = self.parts();
        let t = v.cross(p);
        let t = t + t;
        p + t * w + v.cross(t)
    }

    #[inline(always)]
    pub(super) fn unrotate(self, p: Vector<N>) -> Vector<N> {
        self.inverse().rotate(p)
    }

    /// Columns of the rotation matrix.
    #[inline(always)]
    pub(super) fn columns(self) -> [Vector<N>; 3] {
        let [w, x, y, z] = self.0;
        let (x2, y2, z2) = (x + x, y + y, z + z);
        let (xx, yy, zz) = (x * x2, y * y2, z * z2);
        let (xy, xz, yz) = (x * y2, x * z2, y * z2);
        let (wx, wy, wz) = (w * x2, w * y2, w * z2);
        let one = N::one();
        [
            Vector([one - (yy + zz), xy + wz, xz - wy]),
            Vector([xy - wz, one - (xx + zz), yz + wx]),
            Vector([xz + wy, yz - wx, one - (xx + yy)]),
        ]
    }

    /// Rotation about the unit vector `axis` by `angle` [rad].
    #[inline(always)]
    pub(super) fn about(axis: Vector<N>, angle: N) -> Self {
        let (s, c) = (angle * N::splat(0.5)).sin_cos();
        Self::new(c, axis * s)
    }

    /// Rotation about the vector `v` by its length [rad].
    #[inline(always)]
    pub(super) fn from_vector(v: Vector<N>) -> Self {
        let angle = v.length();
        let (s, c) = (angle * N::splat(0.5)).sin_cos();
        // Below the tiny angle, sin(a/2)/a is 1/2 in every digit.
        let tiny = N::splat(1.0e-12);
        let safe = tiny.if_less(angle, angle, N::one());
        let ratio = tiny.if_less(angle, s / safe, N::splat(0.5));
        Self::new(c, v * ratio)
    }

    /// The vector about which, and by whose length [rad], this rotates: length 0 to π.
    pub(super) fn vector(self) -> Vector<N> {
        let (w, v) = self.parts();
        let sign = w.if_less(N::zero(), -N::one(), N::one());
        let length = v.length();
        let angle = length.atan2(w * sign);
        let tiny = N::splat(1.0e-12);
        let safe = tiny.if_less(length, length, N::one());
        let ratio = tiny.if_less(length, angle / safe, N::one());
        v * (sign * (ratio + ratio))
    }

    #[inline(always)]
    pub(super) fn normalized(self) -> Self {
        let [a, b, c, d] = self.0;
        let scale = N::one() / (a * a + b * b + c * c + d * d).sqrt();
        Self([a * scale, b * scale, c * scale, d * scale])
    }
}

/// A motion (angular, linear at the reference point) or a force (moment about the reference point,
/// force).
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Spatial<N> {
    /// Angular part of a motion [rad/s, world], or moment about the reference point [N m, world].
    pub(crate) angular: Vector<N>,
    /// Linear part of a motion at the reference point [m/s, world], or force [N, world].
    pub(crate) linear: Vector<N>,
}

impl<N: Number> Spatial<N> {
    #[inline(always)]
    pub(super) fn zero() -> Self {
        Self { angular: Vector::zero(), linear: Vector::zero() }
    }

    /// Power of a force (`self`) on a motion, or the reverse.
    #[inline(always)]
    pub(super) fn dot(self, o: Self) -> N {
        self.angular.dot(o.angular) + self.linear.dot(o.linear)
    }

    /// Rate of the motion `o` that moves with `self`.
    #[inline(always)]
    pub(super) fn cross_motion(self, o: Self) -> Self {
        Self {
            angular: self.angular.cross(o.angular),
            linear: self.angular.cross(o.linear) + self.linear.cross(o.angular),
        }
    }

    /// Rate of the force `o` that moves with `self`.
    #[inline(always)]
    pub(super) fn cross_force(self, o: Self) -> Self {
        Self {
            angular: self.angular.cross(o.angular) + self.linear.cross(o.linear),
            linear: self.angular.cross(o.linear),
        }
    }

    /// Velocity of the point `p` [m, from the reference point], for a motion.
    #[inline(always)]
    pub(super) fn at(self, p: Vector<N>) -> Vector<N> {
        self.linear + self.angular.cross(p)
    }
}

impl<N: Number> Add for Spatial<N> {
    type Output = Self;
    #[inline(always)]
    fn add(self, o: Self) -> Self {
        Self { angular: self.angular + o.angular, linear: self.linear + o.linear }
    }
}

impl<N: Number> Sub for Spatial<N> {
    type Output = Self;
    #[inline(always)]
    fn sub(self, o: Self) -> Self {
        Self { angular: self.angular - o.angular, linear: self.linear - o.linear }
    }
}

impl<N: Number> Mul<N> for Spatial<N> {
    type Output = Self;
    #[inline(always)]
    fn mul(self, s: N) -> Self {
        Self { angular: self.angular * s, linear: self.linear * s }
    }
}

/// A symmetric matrix: xx, yy, zz, xy, xz, yz.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Symmetric<N>(pub(super) [N; 6]);

impl<N: Number> Symmetric<N> {
    #[inline(always)]
    pub(super) fn zero() -> Self {
        Self([N::zero(); 6])
    }

    #[inline(always)]
    pub(super) fn times(self, v: Vector<N>) -> Vector<N> {
        let [xx, yy, zz, xy, xz, yz] = self.0;
        let [x, y, z] = v.0;
        Vector([xx * x + xy * y + xz * z, xy * x + yy * y + yz * z, xz * x + yz * y + zz * z])
    }

    /// Adds `a bᵀ`, where the product is symmetric up to rounding, times `s`.
    #[inline(always)]
    pub(super) fn add_outer(&mut self, a: Vector<N>, b: Vector<N>, s: N) {
        let ([ax, ay, az], [bx, by, bz]) = ((a * s).0, b.0);
        let terms = [ax * bx, ay * by, az * bz, ax * by, ax * bz, ay * bz];
        for (mine, term) in self.0.iter_mut().zip(terms) {
            *mine = *mine + term;
        }
    }

    /// The solution x of `self x = v`, for a positive definite matrix.
    pub(super) fn solve(self, v: Vector<N>) -> Vector<N> {
        let [xx, yy, zz, xy, xz, yz] = self.0;
        // Links in a line have no inertia about it; a pivot is never less than rounding.
        let minimum = (xx + yy + zz) * N::splat(4.0 * N::EPSILON) + N::splat(1.0e-36);
        let xx = xx.greater(minimum);
        let inverse = N::one() / xx;
        let (l1, l2) = (xy * inverse, xz * inverse);
        let d1 = (yy - l1 * xy).greater(minimum);
        let m = yz - l1 * xz;
        let l3 = m / d1;
        let d2 = (zz - l2 * xz - l3 * m).greater(minimum);
        let [a, b, c] = v.0;
        let b = b - l1 * a;
        let c = c - l2 * a - l3 * b;
        let z = c / d2;
        let y = b / d1 - l3 * z;
        let x = a * inverse - l1 * y - l2 * z;
        Vector([x, y, z])
    }
}

/// Inertia of a link, or of several, about the reference point.
#[derive(Clone, Copy, Debug)]
pub(super) struct Inertia<N> {
    /// [kg]
    pub(super) mass: N,
    /// Mass times center of mass [kg m, world, from the reference point].
    pub(super) moment: Vector<N>,
    /// About the reference point [kg m², world].
    pub(super) about: Symmetric<N>,
}

impl<N: Number> Inertia<N> {
    #[inline(always)]
    pub(super) fn zero() -> Self {
        Self { mass: N::zero(), moment: Vector::zero(), about: Symmetric::zero() }
    }

    /// Inertia of a mass whose center is at `c` and whose inertia about it is the sum of
    /// `g gᵀ` over the three columns `g`.
    #[inline(always)]
    pub(super) fn new(mass: N, c: Vector<N>, columns: [Vector<N>; 3]) -> Self {
        let mut about = Symmetric::zero();
        for g in columns {
            about.add_outer(g, g, N::one());
        }
        let moment = c * mass;
        let square = moment.dot(c);
        about.add_outer(moment, c, -N::one());
        for axis in 0..3 {
            about.0[axis] = about.0[axis] + square;
        }
        Self { mass, moment, about }
    }

    /// Momentum at the velocity `v`: angular about the reference point, and linear.
    #[inline(always)]
    pub(super) fn times(&self, v: Spatial<N>) -> Spatial<N> {
        Spatial {
            angular: self.about.times(v.angular) + self.moment.cross(v.linear),
            linear: v.linear * self.mass - self.moment.cross(v.angular),
        }
    }

    #[inline(always)]
    pub(super) fn plus(&self, o: &Self) -> Self {
        let mut about = self.about;
        for (mine, theirs) in about.0.iter_mut().zip(o.about.0) {
            *mine = *mine + theirs;
        }
        Self { mass: self.mass + o.mass, moment: self.moment + o.moment, about }
    }

    /// The motion that has this momentum.
    pub(super) fn velocity_of(&self, momentum: Spatial<N>) -> Spatial<N> {
        let c = self.moment * (N::one() / self.mass);
        let mut central = self.about;
        central.add_outer(self.moment, c, N::one());
        let square = self.moment.dot(c);
        for axis in 0..3 {
            central.0[axis] = central.0[axis] - square;
        }
        let angular = central.solve(momentum.angular - c.cross(momentum.linear));
        let linear = momentum.linear * (N::one() / self.mass) - angular.cross(c);
        Spatial { angular, linear }
    }
}
