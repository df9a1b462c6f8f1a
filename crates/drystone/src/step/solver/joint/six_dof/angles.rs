//! Computes the joint angles of eight six-axis joints, as [`crate::state::six_dof`] does for one.

use fearless_simd::{Simd, SimdFloat};

use crate::base::simd::wide::{
    LANES, Mask, Vec3w, Wide, above, gather4, inverse_or_zero, max, select, splat, sqrt,
};
use crate::base::simd::wide_quat::{Quatw, atan2};
use crate::state::six_dof::{MIN_TWIST, NO_SWING, SixDofLaws};

/// Rotation axes, angles, and the direction of the swing.
pub(crate) struct Angles<S: Simd> {
    pub(crate) rows: [Vec3w<S>; 3],
    pub(crate) angles: [Wide<S>; 3],
    pub(crate) swing: [Wide<S>; 2],
}

/// Frames of eight joints: their axes, and B relative to A.
struct Frames<S: Simd> {
    a: [Vec3w<S>; 3],
    b: [Vec3w<S>; 3],
    q: Quatw<S>,
}

/// Selects one of three vectors: the one marked by a 1.
#[inline(always)]
fn marked<S: Simd>(of: &[Vec3w<S>; 3], mark: Vec3w<S>) -> Vec3w<S> {
    of[0] * mark.x + of[1] * mark.y + of[2] * mark.z
}

/// `new` where `mask` is set and the number is marked by a 1, else `old`.
#[inline(always)]
fn put<S: Simd>(simd: S, mask: Mask<S>, mark: Wide<S>, new: Wide<S>, old: Wide<S>) -> Wide<S> {
    select(mask, select(above(mark, splat(simd, 0.5)), new, old), old)
}

#[inline(always)]
fn put_row<S: Simd>(
    simd: S,
    mask: Mask<S>,
    mark: Wide<S>,
    new: Vec3w<S>,
    old: Vec3w<S>,
) -> Vec3w<S> {
    Vec3w::select(mask, Vec3w::select(above(mark, splat(simd, 0.5)), new, old), old)
}

impl<S: Simd> Angles<S> {
    /// Computes the angles from the frames of A and B. `turnings` lists the kinds of joints among
    /// them, `last` are the former angles.
    #[inline(always)]
    pub(crate) fn new(
        simd: S,
        laws: &[&SixDofLaws; LANES],
        turnings: u8,
        [frame_a, frame_b]: [Quatw<S>; 2],
        a: [Vec3w<S>; 3],
        last: [Wide<S>; 3],
    ) -> Self {
        let (zero, one, two) = (splat(simd, 0.0), splat(simd, 1.0), splat(simd, 2.0));
        let q = frame_a.conjugate().after(frame_b).shorter(simd);
        let at = Frames { a, b: frame_b.axes(simd), q };
        let Vec3w { x, y, z } = q.u;
        let mut turns = Self { rows: a, angles: [x * two, y * two, z * two], swing: [one, zero] };
        let mut of = [&laws[0].turning; LANES];
        for lane in 1..LANES {
            of[lane] = &laws[lane].turning;
        }
        let [x, y, z, kind] = gather4(simd, of);
        let mark = Vec3w { x, y, z };
        // Each of the kinds 1, 2 and 4 overwrites the ones before.
        if turnings & SixDofLaws::HINGE != 0 {
            turns.hinge(simd, &at, above(kind, splat(simd, 0.5)), mark, last);
        }
        if turnings & SixDofLaws::UNIVERSAL != 0 {
            turns.universal(simd, &at, above(kind, splat(simd, 1.5)), mark);
        }
        if turnings & SixDofLaws::SWING != 0 {
            turns.swing(simd, &at, above(kind, splat(simd, 3.0)), laws);
        }
        turns
    }

    /// Rotation about the marked axis.
    #[inline(always)]
    fn hinge(
        &mut self,
        simd: S,
        at: &Frames<S>,
        mask: Mask<S>,
        mark: Vec3w<S>,
        last: [Wide<S>; 3],
    ) {
        let turn = splat(simd, 2.0 * core::f32::consts::PI);
        let off = marked(&at.a, mark).cross(marked(&at.b, mark));
        let before = last[0] * mark.x + last[1] * mark.y + last[2] * mark.z;
        let angle = atan2(simd, at.q.u.dot(mark), at.q.w) * splat(simd, 2.0);
        let angle = angle + turn * ((before - angle) / turn).round_ties_even();
        let marks = [mark.x, mark.y, mark.z];
        for i in 0..3 {
            let other = select(mask, off.dot(at.a[i]), self.angles[i]);
            self.angles[i] = put(simd, mask, marks[i], angle, other);
        }
        for i in 0..3 {
            self.rows[i] = Vec3w::select(mask, at.a[i], self.rows[i]);
        }
    }

    /// Rotation about all but the marked axis k: about i of body A and j of body B.
    #[inline(always)]
    fn universal(&mut self, simd: S, at: &Frames<S>, mask: Mask<S>, k: Vec3w<S>) {
        let (one, two) = (splat(simd, 1.0), splat(simd, 2.0));
        // i is y where k is x, else x; j is y where k is z, else z.
        let i = Vec3w { x: one - k.x, y: k.x, z: splat(simd, 0.0) };
        let j = Vec3w { x: splat(simd, 0.0), y: k.z, z: one - k.z };
        // i × j is k or -k.
        let sign = one - two * k.y;
        let (a_i, a_j, a_k) = (marked(&at.a, i), marked(&at.a, j), marked(&at.a, k));
        let (b_i, b_j, b_k) = (marked(&at.b, i), marked(&at.b, j), marked(&at.b, k));
        let across = a_i.cross(b_j);
        let size = sqrt(across.dot(across));
        let is_there = above(size, splat(simd, 1.0e-18));
        let across = Vec3w::select(is_there, across * inverse_or_zero(simd, size), a_k) * sign;
        let about_i = atan2(simd, sign * b_j.dot(a_k), b_j.dot(a_j));
        let about_j = atan2(simd, sign * a_i.dot(b_k), a_i.dot(b_i));
        let about_k = -(sign * a_i.dot(b_j));
        let (marks_i, marks_j) = ([i.x, i.y, i.z], [j.x, j.y, j.z]);
        let marks_k = [k.x, k.y, k.z];
        for n in 0..3 {
            let angle = self.angles[n];
            let angle = put(simd, mask, marks_i[n], about_i, angle);
            let angle = put(simd, mask, marks_j[n], about_j, angle);
            self.angles[n] = put(simd, mask, marks_k[n], about_k, angle);
            let row = self.rows[n];
            let row = put_row(simd, mask, marks_i[n], a_i, row);
            let row = put_row(simd, mask, marks_j[n], b_j, row);
            self.rows[n] = put_row(simd, mask, marks_k[n], across, row);
        }
    }

    /// A twist about x and a swing; its direction is computed where there is a cone.
    #[inline(always)]
    fn swing(&mut self, simd: S, at: &Frames<S>, mask: Mask<S>, laws: &[&SixDofLaws; LANES]) {
        let (zero, one, two) = (splat(simd, 0.0), splat(simd, 1.0), splat(simd, 2.0));
        let Quatw { u, w } = at.q;
        let r = sqrt(w * w + u.x * u.x);
        let is_twisted = above(r, zero);
        let (c, s) = (select(is_twisted, w / r, one), select(is_twisted, u.x / r, zero));
        let (y, z) = (u.y * c - u.z * s, u.y * s + u.z * c);
        let sine = sqrt(y * y + z * z);
        let twist = atan2(simd, u.x, w) * two;
        let size = atan2(simd, sine, r) * two;
        let [a0, a1, a2] = at.a;
        let middle = a0 + at.b[0];
        let close = middle.dot(middle) * splat(simd, 0.5);
        let row = middle * (one / max(close, splat(simd, MIN_TWIST)));
        let is_swung = above(sine, splat(simd, NO_SWING));
        let (y, z) = (select(is_swung, y / sine, one), select(is_swung, z / sine, zero));

        let mut cones = [&laws[0].cone; LANES];
        for lane in 1..LANES {
            cones[lane] = &laws[lane].cone;
        }
        let [.., cone, _] = gather4(simd, cones);
        let is_cone = above(cone, splat(simd, 0.5));
        let angles = [twist, select(is_cone, size, y * size), select(is_cone, zero, z * size)];
        let rows = [
            row,
            Vec3w::select(is_cone, a1 * y + a2 * z, a1),
            Vec3w::select(is_cone, a2 * y - a1 * z, a2),
        ];
        for i in 0..3 {
            self.angles[i] = select(mask, angles[i], self.angles[i]);
            self.rows[i] = Vec3w::select(mask, rows[i], self.rows[i]);
        }
        let [along, across] = self.swing;
        let y = select(mask, select(is_cone, y, one), along);
        let z = select(mask, select(is_cone, z, zero), across);
        self.swing = [y, z];
    }
}

#[cfg(test)]
mod tests {
    use fearless_simd::{SimdBase, dispatch};

    use super::{Angles, LANES, Quatw, SixDofLaws, Wide};
    use crate::base::math::vec3;
    use crate::base::quat::Quat;
    use crate::base::random::Random;
    use crate::base::simd::wide::{SimdLevel, at};
    use crate::base::trig;
    use crate::state::def::named::ConeTwist;
    use crate::state::def::six_dof::{JointAxis, SixDof};
    use crate::state::six_dof::{self, Turning};

    /// Joints of every kind of rotation.
    fn kinds() -> Vec<SixDof> {
        let (free, locked) = (JointAxis::FREE, JointAxis::LOCKED);
        let mut kinds: Vec<SixDof> = (0..8_u8)
            .map(|bits| {
                let angular = [0, 1, 2].map(|i| if bits >> i & 1 != 0 { free } else { locked });
                SixDof { angular, ..SixDof::FIXED }
            })
            .collect();
        kinds.push(ConeTwist::of(free, 0.4, 0.7).six_dof());
        kinds
    }

    #[test]
    fn eight_joints_turn_as_each_of_them() {
        let mut random = Random::new(7);
        let kinds = kinds();
        for round in 0..200 {
            let mut number = || {
                #[expect(clippy::cast_possible_truncation, reason = "any number will do")]
                let number = (2.0 * random.unit() - 1.0) as f32;
                number
            };
            let mut turn = |size: f32| {
                let axis = vec3(number(), number(), number());
                Quat::from_axis_angle(axis, size * number())
            };
            // Every ninth round has frames near zero rotation.
            let size = if round % 9 == 0 { 1.0e-4 } else { 3.0 };
            let defs: [SixDof; LANES] = core::array::from_fn(|i| kinds[(round + i) % kinds.len()]);
            let frames: [Quat; LANES] = core::array::from_fn(|_| turn(3.0));
            let others = frames.map(|frame| frame * turn(size));
            let last = [4.0, -7.0, 13.0];
            let laws = defs.map(|def| SixDofLaws::new(&def));
            let turnings = laws.iter().fold(0, |all, laws| all | laws.flags.turnings);
            for SimdLevel(level) in SimdLevel::available() {
                let mut rows = [[[0.0; LANES]; 3]; 3];
                let mut angles = [[0.0; LANES]; 3];
                let mut swing = [[0.0; LANES]; 2];
                dispatch!(level, simd => {
                    let frames = [&frames, &others]
                        .map(|of| Quatw::of_rows(simd, &of.map(|q| q.to_array())));
                    let turns = Angles::new(
                        simd,
                        &laws.each_ref(),
                        turnings,
                        frames,
                        frames[0].axes(simd),
                        last.map(|angle| Wide::splat(simd, angle)),
                    );
                    for i in 0..3 {
                        turns.rows[i].store(&mut rows[i]);
                        turns.angles[i].store_array(&mut angles[i]);
                    }
                    for i in 0..2 {
                        turns.swing[i].store_array(&mut swing[i]);
                    }
                });
                for lane in 0..LANES {
                    let one = defs[lane].joint_angles(frames[lane], others[lane], last);
                    let got = six_dof::JointAngles {
                        rows: [0, 1, 2].map(|i| at(&rows[i], lane)),
                        angles: [0, 1, 2].map(|i| angles[i][lane]),
                        swing: [0, 1].map(|i| swing[i][lane]),
                    };
                    same(&one, &got, &defs[lane]);
                }
            }
        }
    }

    /// Conditioning of a joint's angles. Universal joint: the sine of the angle between its two
    /// axes. Swing: the sines of half the swing and of its distance to opposite axes.
    fn sharpness(def: &SixDof, turns: &six_dof::JointAngles) -> f32 {
        match def.turning() {
            Turning::Still | Turning::Hinge(_) => 1.0,
            Turning::Universal(k) => (1.0 - turns.angles[k] * turns.angles[k]).max(0.0).sqrt(),
            Turning::Swing => {
                let [_, y, z] = turns.angles;
                let (s, c) = trig::sin_cos(0.5 * (y * y + z * z).sqrt());
                if def.cone.is_some() { s.min(c) } else { c }
            }
        }
    }

    /// Products of two and three unit quaternions have rounding errors of 1e-7 per product, and
    /// twice that as angles.
    fn same(one: &six_dof::JointAngles, got: &six_dof::JointAngles, def: &SixDof) {
        let longest = one.rows.iter().map(|row| row.length()).fold(1.0, f32::max);
        let allowed = 2.0e-6 * longest * longest / sharpness(def, one).max(1.0e-6);
        let near = |a: f32, b: f32| {
            assert!((a - b).abs() < allowed, "{one:?}\n{got:?}\n{:?} {allowed}", def.turning());
        };
        for i in 0..3 {
            near((one.rows[i] - got.rows[i]).length(), 0.0);
            near(one.angles[i], got.angles[i]);
        }
        near(one.swing[0], got.swing[0]);
        near(one.swing[1], got.swing[1]);
    }
}
