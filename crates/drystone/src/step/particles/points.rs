//! Contacts of particles with shapes: solves eight at a time, for eight particles and as many
//! bodies.
//!
//! Symbols: w = 1/m of the particle; α, S, v̂, ŵ of the body as in the solver's rows; n the normal
//! from the body to the particle, r the arm from the body's center, both of the step's start. Along
//! each of its three directions d the body has the row (α d, S (r × d)), so a sweep multiplies no
//! matrix.
//!
//! Contacts with bodies that can be pushed come first, then those with immovable ones. Both are
//! colored anew in each step, in the order of rows and shapes.

mod both;

use fearless_simd::{Simd, SimdBase, dispatch};

use super::meet::{MAX, Meeting};
use super::pace::{Form, ParticlePass, SolverBodies};
use super::rows::Ground;
use crate::base::math::{Vec3, vec3};
use crate::base::simd::wide::{
    LANES, Lanes, Vec3w, above, at, bits, inverse_or_zero, load, max, put, select, splat, sqrt,
};
use crate::base::threads::disjoint::ReadRows;
use crate::base::threads::jobs::{Jobs, for_items, grain};
use crate::state::bodies::Bodies;
use crate::state::particles::Touch;
use crate::step::particles::points::both::read;
use crate::step::solver_body::{Whitening, load_motion, read_lanes};

/// Part of an overlap that a substep removes.
const PUSH_OUT: f32 = 0.2;

/// Number of colors of contacts with bodies that can be pushed. If a body has more contacts than
/// colors, the remaining ones are in the last color, whose contacts are solved one by one.
const PUSHING: usize = 64;

const CROWD: usize = PUSHING - 1;

/// Number of colors of all contacts. A particle's first contact with an immovable shape has the
/// first of the further colors, its second the next, and so on.
const COLORS: usize = PUSHING + MAX;

/// Eight contacts that share no particle, and no body that can be pushed.
#[derive(Clone, Debug, Default)]
#[repr(C, align(64))]
pub(crate) struct PointBlock {
    /// Lines of the particles; 0 for an idle lane.
    solver_row: [u32; LANES],
    /// Rows of the solver bodies; 0: it cannot be pushed.
    body: [u32; LANES],
    alpha: Lanes,
    separation: Lanes,
    n: [Lanes; 3],
    /// S (r × d) of the normal and of the two directions along the surface.
    turns: [[Lanes; 3]; 3],
    /// Velocity of the surface itself along each direction [m/s].
    drift: [Lanes; 3],
    mass: Lanes,
    /// Impulses of a substep on the particle [N s]: along the normal, and along the surface.
    press: Lanes,
    rub: [Lanes; 2],
    mass_slide: Lanes,
    friction: Lanes,
    t1: [Lanes; 3],
    t2: [Lanes; 3],
    /// Maximum `press` in the step.
    maximum: Lanes,
    /// Normal velocity at the step's start if it is an impact; else 0.
    arrival: Lanes,
    restitution: Lanes,
    seed: Seed,
    bounces: bool,
}

/// Inputs of a block as vectors [world].
#[derive(Clone, Debug, Default)]
struct Seed {
    r: [Lanes; 3],
    drift: [Lanes; 3],
    rub: [Lanes; 3],
}

/// Contacts of a step.
#[derive(Clone, Debug)]
pub(crate) struct Contacts {
    /// Blocks, by color.
    blocks: Vec<PointBlock>,
    /// First block of each color, and the end of the last one.
    starts: [usize; COLORS + 1],
    /// Color of each meeting, and its number within the color.
    seats: Vec<(u32, u32)>,
    /// Colors of each body, by row.
    of_body: Vec<u64>,
}

impl Default for Contacts {
    fn default() -> Self {
        Self { blocks: Vec::new(), starts: [0; COLORS + 1], seats: Vec::new(), of_body: Vec::new() }
    }
}

impl Contacts {
    /// Makes the contacts of these meetings, with the impulses of the last step from `touches`, in
    /// the same order; applies them to particles and bodies.
    pub(super) fn begin(
        &mut self,
        (meetings, touches): (&[Meeting], &[Touch]),
        bodies: &Bodies,
        to: &SolverBodies<'_>,
        ground: &Ground<'_>,
        jobs: &Jobs<'_>,
    ) {
        self.color(meetings, bodies.rows.slot_count());
        let mut next = 0;
        for (i, m) in meetings.iter().enumerate() {
            let key = (m.solver_row, m.shape);
            while touches.get(next).is_some_and(|t| (t.solver_row, t.shape) < key) {
                next += 1;
            }
            let known = touches.get(next).filter(|t| (t.solver_row, t.shape) == key);
            let scale = ground.pace.impulse_scale;
            let kept = known.map_or((0.0, Vec3::ZERO), |t| (t.press * scale, t.rub * scale));
            let body = if m.pushes { to.solver_row_of[m.body as usize] } else { 0 };
            let arrival = arrival(ground, m, bodies);
            let (block, lane) = self.place(i);
            self.blocks[block].sit(lane, m, body, kept, arrival);
        }
        self.each(jobs, &|blocks, pushes| {
            dispatch!(ground.pace.level, simd => {
                for block in blocks {
                    prepare(simd, block, &to.whitening, ground, pushes);
                }
            });
        });
    }

    /// Assigns a color to each contact, and makes empty blocks for all.
    fn color(&mut self, meetings: &[Meeting], bodies: usize) {
        self.seats.clear();
        self.of_body.clear();
        self.of_body.resize(bodies, 0);
        let mut counts = [0_u32; COLORS];
        let (mut solver_row, mut of_line, mut fixed) = (0, 0_u64, PUSHING);
        for m in meetings {
            if solver_row != m.solver_row {
                (solver_row, of_line, fixed) = (m.solver_row, 0, PUSHING);
            }
            let color = if m.pushes {
                let of_body = &mut self.of_body[m.body as usize];
                let color = ((!(of_line | *of_body)).trailing_zeros() as usize).min(CROWD);
                if color < CROWD {
                    of_line |= 1 << color;
                    *of_body |= 1 << color;
                }
                color
            } else {
                fixed += 1;
                fixed - 1
            };
            self.seats.push((small(color), counts[color]));
            counts[color] += 1;
        }
        for (color, count) in counts.iter().enumerate() {
            let lanes = if color == CROWD { 1 } else { LANES };
            self.starts[color + 1] = self.starts[color] + (*count as usize).div_ceil(lanes);
        }
        self.blocks.clear();
        self.blocks.resize(self.starts[COLORS], PointBlock::default());
    }

    /// Block and lane of a meeting.
    fn place(&self, meeting: usize) -> (usize, usize) {
        let (color, number) = self.seats[meeting];
        let (start, number) = (self.starts[color as usize], number as usize);
        if color as usize == CROWD {
            (start + number, 0)
        } else {
            (start + number / LANES, number % LANES)
        }
    }

    /// Calls `f` with all blocks, color by color, and true if their bodies can be pushed.
    fn each(&mut self, jobs: &Jobs<'_>, f: &(dyn Fn(&mut [PointBlock], bool) + Sync)) {
        for color in 0..COLORS {
            let (start, end) = (self.starts[color], self.starts[color + 1]);
            let n = end - start;
            // Contacts of the crowd share bodies.
            let minimum = if color == CROWD { n } else { grain(jobs, n, 32) };
            for_items(jobs, &mut self.blocks[start..end], minimum, |_, blocks| {
                f(blocks, color < PUSHING);
            });
        }
    }

    /// Solves each contact once.
    pub(super) fn sweep(&mut self, kind: ParticlePass, ground: &Ground<'_>, jobs: &Jobs<'_>) {
        self.each(jobs, &|blocks, pushes| {
            dispatch!(ground.pace.level, simd => {
                for block in blocks {
                    solve(simd, block, ground, kind, pushes);
                }
            });
        });
    }

    /// Applies restitution to contacts with an impact.
    pub(super) fn bounce(&mut self, ground: &Ground<'_>, jobs: &Jobs<'_>) {
        self.each(jobs, &|blocks, pushes| {
            dispatch!(ground.pace.level, simd => {
                for block in blocks {
                    if block.bounces {
                        bounce(simd, block, ground, pushes);
                    }
                }
            });
        });
    }

    /// Stores the impulses of touching contacts, in the order of their meetings.
    pub(super) fn store(&self, meetings: &[Meeting], touches: &mut Vec<Touch>) {
        touches.clear();
        for (i, m) in meetings.iter().enumerate() {
            let (block, lane) = self.place(i);
            let block = &self.blocks[block];
            let press = block.press[lane];
            if press > 0.0 {
                let [t1, t2] = [at(&block.t1, lane), at(&block.t2, lane)];
                let rub = t1 * block.rub[0][lane] + t2 * block.rub[1][lane];
                touches.push(Touch { solver_row: m.solver_row, shape: m.shape, press, rub });
            }
        }
    }
}

fn small(color: usize) -> u32 {
    u32::try_from(color).expect("colors are few")
}

impl PointBlock {
    fn sit(&mut self, lane: usize, m: &Meeting, body: u32, kept: (f32, Vec3), arrival: f32) {
        (self.solver_row[lane], self.body[lane]) = (m.solver_row, body);
        put(&mut self.n, lane, m.n);
        put(&mut self.seed.r, lane, m.r);
        put(&mut self.seed.drift, lane, m.drift);
        put(&mut self.seed.rub, lane, kept.1);
        self.press[lane] = kept.0;
        self.separation[lane] = m.separation;
        self.friction[lane] = m.friction;
        self.arrival[lane] = arrival;
        self.restitution[lane] = m.restitution;
        self.bounces |= arrival < 0.0;
    }
}

/// Normal velocity of a meeting if it can bounce, else 0.
fn arrival(ground: &Ground<'_>, m: &Meeting, bodies: &Bodies) -> f32 {
    let pace = ground.pace;
    if m.restitution <= 0.0 || pace.form == Form::Verlet {
        return 0.0;
    }
    let of_body = if m.pushes { bodies.at(m.body).velocity_at(m.r) } else { Vec3::ZERO };
    let v = ground.before.read(m.solver_row as usize);
    let arrival = m.n.dot(vec3(v[0], v[1], v[2]) - of_body - m.drift);
    // A speed that forces alone produce in a step is that of a particle at rest, not an impact.
    #[expect(clippy::cast_precision_loss, reason = "at most 256")]
    let dt = pace.h * pace.substeps as f32;
    let slow = (2.0 * pace.gravity.length() * dt).max(pace.restitution_speed);
    if -arrival > slow { arrival } else { 0.0 }
}

/// Computes a block's constants for this step, and applies its stored impulses to particles and
/// bodies.
#[inline(always)]
fn prepare<S: Simd>(
    simd: S,
    block: &mut PointBlock,
    whitening: &ReadRows<'_, Whitening>,
    ground: &Ground<'_>,
    pushes: bool,
) {
    let n = Vec3w::load(simd, &block.n);
    let t1 = n.any_perpendicular(simd);
    let t2 = n.cross(t1);
    t1.store(&mut block.t1);
    t2.store(&mut block.t2);
    let axes = [n, t1, t2];
    let drift = Vec3w::load(simd, &block.seed.drift);
    let mut squares = [splat(simd, 0.0); 3];
    if pushes {
        let (alpha, s) = Whitening::gather(simd, read_lanes(whitening, &block.body));
        alpha.store_array(&mut block.alpha);
        let r = Vec3w::load(simd, &block.seed.r);
        for axis in 0..3 {
            let turn = s.mul(r.cross(axes[axis]));
            turn.store(&mut block.turns[axis]);
            squares[axis] = alpha * alpha + turn.dot(turn);
        }
    }
    for axis in 0..3 {
        axes[axis].dot(drift).store_array(&mut block.drift[axis]);
    }
    let mut q = read(simd, block, ground, pushes);
    inverse_or_zero(simd, q.w + squares[0]).store_array(&mut block.mass);
    // For both directions together: at least the greater of the two.
    let slide = q.w + squares[1] + squares[2] - q.alpha * q.alpha;
    inverse_or_zero(simd, slide).store_array(&mut block.mass_slide);
    let rub = Vec3w::load(simd, &block.seed.rub);
    let press = load(simd, &block.press);
    let p = [press, t1.dot(rub), t2.dot(rub)];
    p[1].store_array(&mut block.rub[0]);
    p[2].store_array(&mut block.rub[1]);
    if bits(above(press, splat(simd, 0.0))) != 0 {
        for axis in 0..3 {
            q.push(simd, block, ground, (axis, axes[axis]), p[axis], pushes);
        }
        q.write(simd, block, ground, pushes);
    }
}

/// Solves eight contacts once; without bias in a relax sweep.
#[inline(always)]
fn solve<S: Simd>(
    simd: S,
    block: &mut PointBlock,
    ground: &Ground<'_>,
    kind: ParticlePass,
    pushes: bool,
) {
    let pace = ground.pace;
    let soft = pace.form == Form::Soft;
    let zero = splat(simd, 0.0);
    let (h, inv_h) = (splat(simd, pace.h), splat(simd, pace.inv_h));
    let mut q = read(simd, block, ground, pushes);
    let n = Vec3w::load(simd, &block.n);
    let mut old = load(simd, &block.press);
    let was_pressed = bits(above(old, zero)) != 0;
    if matches!(kind, ParticlePass::Solve { first: true }) && was_pressed {
        let (t1, t2) = (Vec3w::load(simd, &block.t1), Vec3w::load(simd, &block.t2));
        let rub = [load(simd, &block.rub[0]), load(simd, &block.rub[1])];
        if pushes {
            let back = splat(simd, -ground.repeat());
            q.push_body(simd, block, (0, n), old * back);
            q.push_body(simd, block, (1, t1), rub[0] * back);
            q.push_body(simd, block, (2, t2), rub[1] * back);
        }
        let keep = splat(simd, pace.keep);
        old *= keep;
        (rub[0] * keep).store_array(&mut block.rub[0]);
        (rub[1] * keep).store_array(&mut block.rub[1]);
    }
    // Approach of particle and surface since the step's start.
    let time = if soft { ground.elapsed } else { ground.elapsed + pace.h };
    let mut displacement = q.x;
    if pace.form == Form::Aim {
        displacement = displacement + q.v * h;
    }
    let mut went = load(simd, &block.drift[0]) * splat(simd, time);
    if pushes {
        let mut body = load_motion(simd, &ground.bodies, &block.body);
        if !soft {
            // At the same time as the particle's displacement.
            body.v = body.v + q.body.v * h;
            body.w = body.w + q.body.w * h;
        }
        let turn = Vec3w::load(simd, &block.turns[0]);
        went = went + n.dot(body.v) * q.alpha + turn.dot(body.w);
    }
    let gap = load(simd, &block.separation) + (n.dot(displacement) - went);
    let vn = q.along(simd, block, (0, n));
    let close = gap * inv_h;
    let speed = if soft {
        let minimum = splat(simd, -pace.push_speed);
        let deep = match kind {
            ParticlePass::Relax => vn,
            ParticlePass::Solve { .. } => vn + max(close * splat(simd, PUSH_OUT), minimum),
        };
        select(above(gap, zero), vn + close, deep)
    } else {
        // The gap is that of the substep's end and includes the velocity.
        close
    };
    let press = max(old - load(simd, &block.mass) * speed, zero);
    if !was_pressed && bits(above(press, zero)) == 0 {
        // The contact is near but does not touch, as most shapes beside edges.
        return;
    }
    press.store_array(&mut block.press);
    max(load(simd, &block.maximum), press).store_array(&mut block.maximum);
    q.push(simd, block, ground, (0, n), press - old, pushes);
    // Friction uses the velocity after the normal's impulse.
    let (t1, t2) = (Vec3w::load(simd, &block.t1), Vec3w::load(simd, &block.t2));
    let slide = load(simd, &block.mass_slide);
    let rub = [load(simd, &block.rub[0]), load(simd, &block.rub[1])];
    let wanted = [
        rub[0] - q.along(simd, block, (1, t1)) * slide,
        rub[1] - q.along(simd, block, (2, t2)) * slide,
    ];
    let size = sqrt(wanted[0] * wanted[0] + wanted[1] * wanted[1]);
    let limit = load(simd, &block.friction) * press;
    let part = select(above(size, limit), limit / size, splat(simd, 1.0));
    let new = [wanted[0] * part, wanted[1] * part];
    new[0].store_array(&mut block.rub[0]);
    new[1].store_array(&mut block.rub[1]);
    q.push(simd, block, ground, (1, t1), new[0] - rub[0], pushes);
    q.push(simd, block, ground, (2, t2), new[1] - rub[1], pushes);
    q.write(simd, block, ground, pushes);
}

/// Gives contacts with an impact and an impulse the velocity that restitution requires.
#[inline(always)]
fn bounce<S: Simd>(simd: S, block: &mut PointBlock, ground: &Ground<'_>, pushes: bool) {
    let mut q = read(simd, block, ground, pushes);
    let (zero, n) = (splat(simd, 0.0), Vec3w::load(simd, &block.n));
    let arrival = load(simd, &block.arrival);
    let vn = q.along(simd, block, (0, n));
    let p = load(simd, &block.mass) * (vn + load(simd, &block.restitution) * arrival);
    let p = max(-p, zero);
    let p = select(above(zero, arrival), p, zero);
    let p = select(above(load(simd, &block.maximum), zero), p, zero);
    q.push(simd, block, ground, (0, n), p, pushes);
    q.write(simd, block, ground, pushes);
}
