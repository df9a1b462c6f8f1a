//! Load-adaptive inertia: what is squeezed hard answers slowly, so that stacks and heavy loads do not
//! sink into what carries them.
//!
//! A soft contact under a load N gives by N / (m ω²): in a tall stack the lowest contacts carry a hundred
//! times what one body weighs, and give a hundred times as much. Shock propagation makes the bodies below
//! infinitely heavy [Guendelman03]; this is its bounded heir. A body that is squeezed by more than a few
//! times what it weighs has mass and inertia multiplied by s, 1 to `most`, within the solver, and
//! forces on it keep their size, so that its acceleration is divided by s. Statics do not
//! know mass: loads, the limits of friction and of tipping stay exact; only the answer to a change is
//! slower. See docs/decisions/015-load-adaptive-inertia.md for what each number below does.
#![expect(unsafe_code, reason = "promises that rows are kept apart")]

use super::Solver;
use super::integrate;
use super::rounds::BodyState;
use crate::base::disjoint::{Apart, Rows};
use crate::base::jobs::{Jobs, for_shares};
use crate::base::math::Vec3;
use crate::state::bodies::{Body, Fineness, NONE};
use crate::state::contacts::Contact;

/// Bodies that turn faster than this get their own inertia back [rad/s]: toppling keeps its time. What is
/// larger than this [m], half the diagonal of a cube of 1 m, topples slower, as the root of its size; with
/// 0.2 rad/s for all, dominoes of 10 m fell 11 % late at 60 Hz, 36 % at 480. (Smaller ones for which the speed
/// goes up are late by that.)
const TURNING: f32 = 0.2;
const SIZE: f32 = 0.87;

/// The factor goes up if the load asks for this much more, and down if for this much less: between, the
/// ripples of impulses cannot pump energy.
const HYSTERESIS: f32 = 0.2;

/// Part of the way down in a step, slow, for to follow the load down at once pumps energy. Upward it is
/// followed at once.
const FALL: f32 = 0.03;

/// The load, over the greatest factor, from which on the factor grows on, and how many times the greatest it
/// may become. (With 16 for all loads a stack of 100 drifts by 0.2 m and an arch of 101 stones falls.)
const BEYOND: f32 = 5.0;
const GREATEST: f32 = 3.0;

/// A load below this part of the factor is gone: the body must not float, and loses this much of its
/// factor in a step. (All at once makes a tower hop: it loses its load at the top of each hop, sinks into
/// its soft contacts and is thrown again as the factor comes back.)
const GONE: f32 = 0.1;
const RELEASE: f32 = 0.5;

/// A load below this part of the threshold asks for no factor, and what a passing peak left of one goes by this part in
/// a step. (Within the hysteresis it would stay for good, and what is pushed would be too heavy for ever.)
const LIGHT: f32 = 1.0 / (1.0 + HYSTERESIS);
const EASE: f32 = 0.4;

/// So many contacts ahead of the one that is looked at are asked for from memory.
const AHEAD: usize = 8;

/// The numbers of a step.
#[derive(Clone, Copy, Debug)]
pub(crate) struct LoadInertia {
    /// Greatest factor for what stands; 1: off.
    pub(crate) most: f32,
    /// What bears much takes its substeps in parts, and greater loads have no greater factors: 2000:1 on ten boxes was
    /// thrown off.
    pub(crate) in_parts: bool,
    /// Load per mass above which the factor rises [m/s²].
    pub(crate) threshold: f32,
    /// Length of a typical body [m].
    pub(crate) length: f32,
}

impl LoadInertia {
    pub(crate) fn is_on(&self) -> bool {
        self.most > 1.0
    }

    /// True if its island needs more substeps: from three quarters of the greatest factor on, where loads may
    /// be beyond what that can carry, until it falls below a fifth. (With one limit for both a stack near it
    /// would never rest: contacts become four times as stiff, so it hops, is not loaded, and goes back.)
    pub(crate) fn wants_refining(&self, body: &Body) -> bool {
        body.inertia_factor
            >= self.most * if body.fineness == Fineness::Loaded { 0.2 } else { 0.75 }
    }

    /// The factor for a load that is so many times the threshold: the load itself, then `most`, and beyond
    /// [`BEYOND`] times that growing as its root. What no stack weighs, but what is dropped on one, so finds
    /// the resistance without which the stack would be crushed and fall.
    fn at_load(&self, raw: f32) -> f32 {
        let beyond = raw / (BEYOND * self.most);
        if beyond > 1.0 && !self.in_parts {
            self.most * beyond.sqrt().min(GREATEST)
        } else {
            raw.clamp(1.0, self.most)
        }
    }

    /// The factor of a body that has rested under its load: that of a peak, fallen as far as it falls.
    pub(crate) fn at_rest(&self, body: &Body) -> f32 {
        let wanted = self.at_load(body.load / (body.mass * self.threshold));
        if wanted > 1.0 { wanted / (1.0 - HYSTERESIS) } else { 1.0 }
    }

    /// The body's factor in this step.
    pub(crate) fn factor(&self, body: &Body) -> f32 {
        let s = body.inertia_factor;
        // Most bodies: without a factor, and without a load that asks for one.
        if s <= 1.0 && body.load <= body.mass * self.threshold {
            return 1.0;
        }
        let raw = body.load / (body.mass * self.threshold);
        let size = (body.extent * (1.0 / (SIZE * self.length))).max(1.0);
        let turning = body.w.length_squared() * (size / (TURNING * TURNING));
        let wanted = 1.0 + (self.at_load(raw) - 1.0) / (1.0 + turning);
        if wanted > (1.0 + HYSTERESIS) * s {
            wanted
        } else if raw < GONE * s {
            s + RELEASE * (wanted - s)
        } else if raw < LIGHT {
            s + EASE * (wanted - s)
        } else if wanted < (1.0 - HYSTERESIS) * s {
            s + FALL * (wanted - s)
        } else {
            s
        }
    }
}

/// How a body of the solver is squeezed.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Squeeze {
    /// What its mass and inertia are multiplied by in this step.
    pub(crate) factor: f32,
    /// In what parts its island takes the substeps.
    pub(crate) fineness: Fineness,
    /// The normal impulses on it in the last substep: their vector sum, and the sum of their sizes
    /// [N s].
    pub(crate) impulse: [f32; 4],
}

impl Default for Squeeze {
    fn default() -> Self {
        Self { factor: 1.0, fineness: Fineness::Whole, impulse: [0.0; 4] }
    }
}

impl Squeeze {
    /// What presses the body from both sides [N s]: half of what its impulses are more than their sum. A
    /// body that is hit, or rests alone, is not squeezed.
    pub(crate) fn pressure(&self) -> f32 {
        let [x, y, z, all] = self.impulse;
        (0.5 * (all - (x * x + y * y + z * z).sqrt())).max(0.0)
    }
}

/// A weighted mean of velocities and angular velocities.
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

/// How an island moves: the mean of its bodies by mass, and that of what it stands on, by load.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Frame {
    pub(crate) island: Motion,
    pub(crate) support: Motion,
    /// Something that cannot be pushed carries or holds it. An island in free flight has no load that lasts,
    /// and with masses that are not their own its bodies would make momentum as they meet: in 60 s of 200
    /// bodies in zero gravity 3e-4 of it.
    pub(crate) held: bool,
}

impl Frame {
    /// Velocities of a body whose factor rises: it keeps its momentum as it becomes heavier, against the
    /// motion of its island or of what that stands on, whichever is nearer to its own. Against one
    /// frame only, it would not do: a tower that sways is pulled along by its mean motion, and a
    /// stack on a cart braked by the ground.
    pub(crate) fn slowed(&self, body: &Body, factor: f32) -> (Vec3, Vec3) {
        let part = 1.0 - body.inertia_factor / factor;
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

/// What of a body counts for the motion of its island.
#[derive(Clone, Copy, Debug, Default)]
struct MemberMotion {
    island: u32,
    mass: f32,
    v: Vec3,
    w: Vec3,
    /// It grows heavier in this step.
    heavier: bool,
}

/// How the islands of a group move, in a step in which one of their bodies grows heavier.
#[derive(Clone, Debug, Default)]
pub(crate) struct Frames {
    /// Of each line, where several workers make them.
    members: Vec<MemberMotion>,
    /// In order.
    islands: Vec<u32>,
    frames: Vec<Frame>,
    /// Rows of the contacts with what cannot be pushed, in order.
    supports: Vec<u32>,
}

impl Frames {
    /// Sums up how the islands of so many members move.
    fn begin(&mut self, n: usize, member: impl Fn(&Self, usize) -> MemberMotion) {
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

    fn place(&self, island: u32) -> usize {
        self.islands.binary_search(&island).expect("the group's bodies are in its islands")
    }

    fn of(&mut self, island: u32) -> &mut Frame {
        let at = self.place(island);
        &mut self.frames[at]
    }
}

impl Solver<'_> {
    /// Bodies that grow heavier join the motion of their island. Sums are made in the order of bodies and of
    /// contacts' rows, which neither grouping nor the number of workers changes.
    pub(super) fn slow_heavier(&self, number: usize, jobs: &Jobs<'_>) {
        let (group, frames) = (&self.plan.groups[number], self.frames.row(number));
        let (first, n) = (group.lines.start, group.lines.len());
        let body_of = |i: usize| self.bodies.at(self.plan.members[i - 1]);
        let read = |k: usize| {
            let body = body_of(first + k);
            MemberMotion {
                island: body.island,
                mass: body.mass,
                v: body.v,
                w: body.w,
                heavier: self.squeezes.read(first + k).factor > body.inertia_factor,
            }
        };
        // Bodies are far from each other. One worker would gain nothing by a copy of what is summed up of them.
        let copies = jobs.workers() > 1;
        if copies {
            frames.members.resize(n, MemberMotion::default());
            // SAFETY: each member is of one part.
            let members = Rows::new(&mut frames.members, unsafe { Apart::promise() });
            for_shares(jobs, n, 64, |part| part.for_each(|k| *members.row(k) = read(k)));
        }
        let member = |frames: &Frames, k: usize| if copies { frames.members[k] } else { read(k) };
        frames.begin(n, member);
        let mut supports = core::mem::take(&mut frames.supports);
        supports.clear();
        for batch in self.plan.contacts.batches[group.contacts.clone()].iter().filter(|b| b.fixed) {
            let rows = self.plan.contacts.owners[batch.blocks.clone()].iter().flatten();
            supports.extend(rows.copied().filter(|row| *row != NONE));
        }
        supports.sort_unstable();
        for (k, row) in supports.iter().enumerate() {
            if let Some(soon) = supports.get(k + AHEAD) {
                self.contacts.prefetch(*soon as usize, 4);
            }
            if let Some(contact) = self.contacts.read(*row as usize) {
                self.add_support(contact, frames);
            }
        }
        frames.supports = supports;
        // Joints are far away: they are asked only where no contact carries the island.
        let members = if frames.frames.iter().all(|frame| frame.held) { 0 } else { n };
        for k in 0..members {
            let island = member(frames, k).island;
            let frame = frames.of(island);
            if !frame.held {
                let joints = &body_of(first + k).joints;
                frame.held = joints.iter().any(|row| self.is_to_fixed(*row));
            }
        }
        for_shares(jobs, n, 64, |part| {
            for k in part.filter(|k| member(frames, *k).heavier) {
                let i = first + k;
                let (body, factor) = (body_of(i), self.squeezes.read(i).factor);
                let frame = &frames.frames[frames.place(body.island)];
                if frame.held {
                    let (v, w) = frame.slowed(body, factor);
                    self.put_slowed(i, body, factor, &BodyState { v, w, ..BodyState::of(body) });
                } else {
                    self.put_slowed(i, body, body.inertia_factor, &BodyState::of(body));
                }
            }
        });
    }

    fn put_slowed(&self, i: usize, body: &Body, factor: f32, start: &BodyState) {
        self.put_line(i, body, factor, start, integrate::gyration(self.ctx, body, start));
    }

    /// True for a joint to what cannot be pushed.
    fn is_to_fixed(&self, joint: u32) -> bool {
        let free = |row: u32| self.bodies.at(row).is_dynamic();
        let joint = self.joint_slots.read(joint as usize).as_ref();
        joint.is_some_and(|j| !free(j.body_a) || !free(j.body_b))
    }

    /// Enters the motion of the fixed side of a contact in its island's frame.
    fn add_support(&self, c: &Contact, frames: &mut Frames) {
        let (a, b) = (self.bodies.at(c.body_a), self.bodies.at(c.body_b));
        let (support, island) = match [c.body_a, c.body_b].map(|row| self.line_of[row as usize]) {
            // A body that was put aside may still be named by a contact.
            [0, 0] => return,
            [0, _] => (a, b.island),
            _ => (b, a.island),
        };
        let frame = frames.of(island);
        for p in c.points() {
            let r = a.center + p.r_a - support.center;
            frame.support.add(p.impulse, support.velocity_at(r), support.w);
            frame.held |= p.impulse > 0.0;
        }
    }
}
