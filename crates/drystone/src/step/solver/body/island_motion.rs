//! Computes the mean motion of islands and of the supports of bodies.

use crate::base::math::Vec3;
use crate::state::bodies::body::Body;

/// Weighted mean of velocities and angular velocities.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Motion {
    weight: f64,
    v: [f64; 3],
    w: [f64; 3],
}

impl Motion {
    pub(crate) fn add(&mut self, weight: f32, v: Vec3, w: Vec3) {
        let weight = f64::from(weight);
        self.weight += weight;
        for i in 0..3 {
            self.v[i] += weight * f64::from(v[i]);
            self.w[i] += weight * f64::from(w[i]);
        }
    }

    #[expect(clippy::cast_possible_truncation, reason = "a mean of f32")]
    fn mean(&self) -> Option<(Vec3, Vec3)> {
        let each = |x: [f64; 3]| {
            let of = |i: usize| (x[i] / self.weight) as f32;
            Vec3 { x: of(0), y: of(1), z: of(2) }
        };
        (self.weight > 0.0).then(|| (each(self.v), each(self.w)))
    }
}

/// Motion of an island: the mean of its bodies by mass, and the mean of its supports by load.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Frame {
    pub(crate) island: Motion,
    pub(crate) support: Motion,
    /// A body that cannot be pushed carries or holds the island. An island in free flight has no
    /// lasting load. With increased masses its bodies would create momentum when they meet: 3e-4 of
    /// it in 60 s of 200 bodies in zero gravity.
    pub(crate) held: bool,
}

impl Frame {
    /// Velocities of a body whose factor rises. It keeps its momentum while it becomes heavier,
    /// relative to the motion of its island or of the island's support, whichever is nearer to its
    /// own. One frame alone is not enough: the mean motion would pull a swaying tower along, and
    /// the ground would brake a stack on a cart.
    pub(crate) fn slowed(&self, body: &Body, factor: f32) -> (Vec3, Vec3) {
        let part = 1.0 - body.history.inertia_factor / factor;
        let (mut v, mut w) = (Vec3::ZERO, Vec3::ZERO);
        let (mut near_v, mut near_w) = (f32::INFINITY, f32::INFINITY);
        for (mean_v, mean_w) in [self.island.mean(), self.support.mean()].into_iter().flatten() {
            let (off_v, off_w) = (mean_v - body.v, mean_w - body.w);
            if off_v.length_squared() < near_v {
                (v, near_v) = (off_v, off_v.length_squared());
            }
            if off_w.length_squared() < near_w {
                (w, near_w) = (off_w, off_w.length_squared());
            }
        }
        (body.v + v * part, body.w + w * part)
    }
}

/// A body's contribution to the motion of its island.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct MemberMotion {
    pub(crate) island: u32,
    pub(crate) mass: f32,
    pub(crate) v: Vec3,
    pub(crate) w: Vec3,
    /// The body grows heavier in this step.
    pub(crate) heavier: bool,
}

/// Motion of the islands of a group, in a step in which one of their bodies grows heavier.
#[derive(Clone, Debug, Default)]
pub(crate) struct Frames {
    /// One for each solver body, if several workers fill them.
    pub(crate) members: Vec<MemberMotion>,
    /// Sorted.
    islands: Vec<u32>,
    pub(crate) frames: Vec<Frame>,
    /// Rows of the contacts with bodies that cannot be pushed, sorted.
    pub(crate) supports: Vec<u32>,
}

impl Frames {
    /// Sums the motion of the islands of `n` members.
    pub(crate) fn begin(&mut self, n: usize, member: impl Fn(&Self, usize) -> MemberMotion) {
        self.islands.clear();
        for k in 0..n {
            let island = member(self, k).island;
            if self.islands.last() != Some(&island) {
                self.islands.push(island);
            }
        }
        self.islands.sort_unstable();
        self.islands.dedup();
        self.frames.clear();
        self.frames.resize(self.islands.len(), Frame::default());
        for k in 0..n {
            let MemberMotion { island, mass, v, w, .. } = member(self, k);
            self.of(island).island.add(mass, v, w);
        }
    }

    pub(crate) fn place(&self, island: u32) -> usize {
        self.islands.binary_search(&island).expect("the group's bodies are in its islands")
    }

    pub(crate) fn of(&mut self, island: u32) -> &mut Frame {
        let at = self.place(island);
        &mut self.frames[at]
    }
}
