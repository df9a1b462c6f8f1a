//! The classic methods: solve the contacts, joints and islands of the default methods with rows one
//! by one.
//!
//! They serve study and comparison, so they are simple: one thread, no lanes, one idea per file.
//!
//! Reads: bodies, shapes, contacts, joints, colors. Writes: contacts and joints (impulses), solver
//! bodies (of mass and inertia one: their motion is the bodies' own). Runs: serially, for any
//! number of workers.
//!
//! References: manual/methods.md, [Guendelman03], [Catto05], [Jakobsen01].

mod accumulate;
mod analytic;
mod couplings;
mod gather;
mod joints;
mod levels;
mod rows;
mod six_dof;
mod springs;
mod sweeps;
pub(crate) mod sequence;

use self::accumulate::Law;
use self::analytic::Analytic;
use self::joints::JointRow;
use self::levels::Graph;
use self::rows::{Mover, Pair};
use self::sequence::Sequence;
use self::springs::Springs;
use super::context::StepContext;
use super::context::softness::Softness;
use super::solver::body::row::Aux;
use super::solver::body::solved::Solved;
use super::solver::body::squeeze::Squeeze;
use super::solver::contact::store::approach;
use super::solver::input::Input;
use super::solver::totals_rows::{ContactTotals, POINTS, SumRequests};
use super::solver_body::{SolverBody, Whitening};
use crate::base::double::greater;
use crate::base::math::{Vec3, bounded};
use crate::base::sym3::Sym3;
use crate::state::colors::Colors;
use crate::state::contacts::Contacts;
use crate::state::def::method::{Method, Pass, Settings};
use crate::state::def::options::{Integration, Order, Overlap, Shock};
use crate::state::joints::{JointModel as JointLink, Joints};

/// Alternations of joints and contacts in the analytic method.
const JOINT_ROUNDS: u32 = 20;

/// Memory kept from step to step.
#[derive(Clone, Debug, Default)]
pub(crate) struct Scratch {
    movers: Vec<Mover>,
    /// Body row of each mover; the first mover has none.
    bodies: Vec<u32>,
    pairs: Vec<Pair>,
    links: Vec<JointRow>,
    /// Pairs in the order of the method, and by levels from the ground up.
    sequence: Sequence,
    ground_up: Sequence,
    graph: Graph,
    change: Vec<(Vec3, Vec3)>,
    analytic: Analytic,
    /// Maximum relative residual of the last step's substeps in the analytic method; else 0.
    pub(crate) residual: f64,
    pub(crate) too_large: bool,
    /// Rows of contacts that were pressed for the first time.
    pub(crate) begun: Vec<u32>,
    /// Impulses of contacts that landed or report forces.
    pub(crate) given: Vec<ContactTotals>,
    /// Sweeps over the contacts in the last step.
    pub(crate) sweeps: u32,
    /// A classic method made the last step.
    was_here: bool,
}

impl Scratch {
    /// Takes over the statistics of the last step from `from`.
    pub(crate) fn start_from(&mut self, from: &Self) {
        (self.residual, self.too_large) = (from.residual, from.too_large);
        self.sweeps = from.sweeps;
        // Solver bodies of a classic step must be cleared later, whichever world made it.
        self.was_here |= from.was_here;
    }

    /// Hands over to another method for this step; true if a classic one made the last step.
    pub(crate) fn leave(&mut self, solver_row_of: &mut [u32]) -> bool {
        let was_here = core::mem::take(&mut self.was_here);
        if was_here {
            (self.residual, self.too_large, self.sweeps) = (0.0, false, 0);
            solver_row_of.fill(0);
            self.begun.clear();
            self.given.clear();
        }
        was_here
    }
}

/// Runs the step of a classic method.
pub(crate) fn solve(
    ctx: &StepContext,
    method: &Method,
    input: Input<'_>,
    joints: &mut Joints,
    contacts: &mut Contacts,
    colors: &Colors,
    scratch: &mut Scratch,
    solved: &mut Solved,
) {
    let settings = method.settle().expect("options are checked when they are given");
    let c = scratch;
    c.was_here = true;
    let solver_row_of = &mut solved.solver_row_of;
    solver_row_of.clear();
    solver_row_of.resize(input.bodies.rows.slot_count(), 0);
    c.gather_bodies(ctx, &settings, input, solver_row_of);
    c.gather_pairs(ctx, input, contacts, colors, solver_row_of);
    c.gather_links(ctx, input, joints, colors, solver_row_of);
    (c.sweeps, c.residual, c.too_large) = (0, 0.0, false);
    let converging = method.substep().iter().filter(|p| matches!(p, Pass::Converge)).count();
    #[expect(clippy::cast_possible_truncation, reason = "a method has a few passes")]
    let converging = converging as u32;
    c.analytic.begin_step(ctx.substeps * converging * c.rounds());
    for substep in 0..ctx.substeps {
        c.begin(ctx, &settings, substep);
        for pass in method.substep() {
            c.sweeps += c.run(*pass, ctx, &settings);
        }
    }
    let Input { bodies, shapes, breakage, .. } = input;
    c.store(ctx, SumRequests { bodies, shapes, breakage }, contacts, joints);
    c.write_bodies(&settings, solved);
}

impl Scratch {
    /// Number of times that joints and contacts alternate: joints are rows of single precision and
    /// are solved between the contacts.
    const fn rounds(&self) -> u32 {
        if self.links.is_empty() { 1 } else { JOINT_ROUNDS }
    }

    /// Runs a pass; returns its number of sweeps over the contacts.
    fn run(&mut self, pass: Pass, ctx: &StepContext, settings: &Settings) -> u32 {
        let (h, caps, rounds) = (ctx.h, &ctx.caps, self.rounds());
        let Self { movers, pairs, links, sequence, ground_up, .. } = self;
        let mut join = |movers: &mut [Mover]| {
            for link in links.iter_mut() {
                link.solve(h, caps, movers);
            }
        };
        match pass {
            Pass::Forces => {
                for m in movers.iter_mut() {
                    (m.old_v, m.old_w) = (m.v, m.w);
                    m.v = (m.v + m.add_v) * m.decay_v;
                    m.w = (m.w + m.add_w) * m.decay_w;
                }
                self.rate_levels(settings);
                0
            }
            Pass::Positions => {
                for m in movers {
                    m.x += m.v * h;
                    m.t += m.w * h;
                }
                0
            }
            Pass::WarmStart => {
                accumulate::warm_start(sequence, movers, pairs);
                links.iter().for_each(|link| link.warm_start(movers));
                0
            }
            Pass::Bounce { sweeps: maximum, before_forces } => {
                let maximum = if maximum > 0 { maximum } else { settings.sweeps };
                if !before_forces {
                    // The baseline method has joints too.
                    join(movers);
                }
                sweeps::bounce(sequence, maximum, h, before_forces, movers, pairs)
            }
            Pass::Stop => sweeps::stop(sequence, settings.sweeps, h, movers, pairs, join),
            Pass::Shock if settings.shock == Shock::Full => {
                sweeps::shock(ground_up, h, movers, pairs)
            }
            Pass::PushOut if settings.overlap == Overlap::PushOut => {
                sweeps::push_out(ground_up, movers, pairs);
                0
            }
            Pass::Accumulate => {
                let law = match settings.overlap {
                    Overlap::VelocityBias | Overlap::Relax => Law::biased(h, ctx.length),
                    _ => Law::rigid(h),
                };
                accumulate::accumulate(sequence, settings.sweeps, &law, movers, pairs, join)
            }
            Pass::AccumulateRelaxed if settings.overlap == Overlap::Relax => {
                let law = Law::rigid(h);
                accumulate::accumulate(sequence, settings.sweeps, &law, movers, pairs, join)
            }
            Pass::Springs => {
                join(movers);
                let springs = Springs {
                    h,
                    omega: 2.0 * core::f32::consts::PI * ctx.penalty.hertz,
                    damping_ratio: ctx.penalty.damping_ratio,
                };
                springs::push_apart(&springs, sequence, movers, pairs, &mut self.change);
                1
            }
            Pass::ImplicitSprings => {
                let p = ctx.penalty;
                let law = Law::spring(h, Softness::new(p.hertz, p.damping_ratio, h));
                accumulate::accumulate(sequence, settings.sweeps, &law, movers, pairs, join)
            }
            Pass::Converge => {
                let has_bias = settings.overlap == Overlap::VelocityBias;
                let slop = analytic::SLOP * f64::from(ctx.length);
                let slop = if has_bias { slop } else { f64::INFINITY };
                let mut sweeps = 0;
                for _ in 0..rounds {
                    for link in links.iter_mut() {
                        link.solve(h, caps, movers);
                    }
                    let outcome = self.analytic.solve(sequence, h, slop, movers, pairs);
                    sweeps += outcome.sweeps;
                    self.residual = greater(outcome.residual, self.residual);
                    self.too_large |= outcome.too_large;
                }
                sweeps
            }
            Pass::Project => {
                let law = Law::projection(h);
                accumulate::accumulate(sequence, settings.sweeps, &law, movers, pairs, join)
            }
            // Passes that are switched off, and passes over blocks.
            _ => 0,
        }
    }

    /// Prepares a substep: finds arriving points, and resets impulses that do not persist.
    fn begin(&mut self, ctx: &StepContext, settings: &Settings, substep: u32) {
        let movers = &self.movers;
        for pair in &mut self.pairs {
            for i in 0..pair.points().len() {
                let mut p = pair.points[i];
                let u = pair.slip(&p, movers).dot(pair.normal);
                // The speed that forces alone add in a step is no arrival, because a body at rest
                // has it, too.
                let (a, b) = (&movers[pair.a as usize], &movers[pair.b as usize]);
                let slow = 2.0 * a.add_v.length().max(b.add_v.length());
                let meets = pair.separation(&p, movers) + ctx.h * u < 0.0;
                let arrives = meets && u < -slow.max(ctx.restitution_speed);
                p.arrival = if arrives { u } else { 0.0 };
                if substep > 0 && !settings.persistence {
                    (p.press, p.rub) = (0.0, Vec3::ZERO);
                }
                pair.points[i] = p;
            }
        }
        for link in &mut self.links {
            if let Some(axes) = &mut link.axes {
                axes.begin();
            }
            if let Some(coupled) = &mut link.coupled {
                coupled.impulse = 0.0;
            }
        }
        if substep > 0 && !settings.persistence {
            self.links.iter_mut().for_each(|link| link.impulse = Vec3::ZERO);
        }
    }

    /// Computes the levels of the contact graph and their order, if the method needs them.
    fn rate_levels(&mut self, settings: &Settings) {
        let by_level = matches!(settings.order, Order::Levels | Order::TopDown);
        if settings.order == Order::Random {
            self.sequence.shuffle();
        }
        if !(by_level || settings.shock == Shock::Full || settings.overlap == Overlap::PushOut) {
            return;
        }
        let Self { movers, pairs, graph, ground_up, sequence, .. } = self;
        graph.rate(movers, pairs);
        ground_up.pairs.clear();
        ground_up.pairs.extend(0..u32::try_from(pairs.len()).expect("fewer than 2^32 contacts"));
        ground_up.pairs.sort_unstable_by_key(|i| {
            let pair = &pairs[*i as usize];
            (pair.level, pair.contact)
        });
        ground_up.end_levels(pairs);
        if by_level {
            sequence.clone_from(ground_up);
        }
        if settings.order == Order::TopDown {
            sequence.pairs.reverse();
            sequence.end_levels(pairs);
        }
    }

    /// Writes the impulses to contacts and joints.
    fn store(
        &mut self,
        ctx: &StepContext,
        sum_requests: SumRequests<'_>,
        contacts: &mut Contacts,
        joints: &mut Joints,
    ) {
        let bodies = sum_requests.bodies;
        self.begun.clear();
        self.given.clear();
        // The classic methods keep no sums: the last substep stands for all.
        #[expect(clippy::cast_precision_loss, reason = "at most 256")]
        let n = ctx.substeps as f32;
        for pair in &self.pairs {
            let c = contacts.at_mut(pair.contact);
            let mut pressed = pair.pressed;
            let mut rub = Vec3::ZERO;
            let (mut points, mut landing) = ([0.0; 4], 0);
            for (j, (point, p)) in c.points.iter_mut().zip(pair.points()).enumerate() {
                landing |= u8::from(point.impulse == 0.0 && p.press > 0.0) << j;
                points[j] = p.press * n;
                point.impulse = p.press;
                rub += p.rub;
                pressed |= point.separation <= 0.0;
            }
            (c.tangent_impulse, c.twist_impulse) = (rub, 0.0);
            if pressed && !c.touching {
                landing = POINTS;
                self.begun.push(pair.contact);
            }
            let landed = landing;
            if landed != 0 {
                let ends = (bodies.at(c.body_a), bodies.at(c.body_b));
                c.set_approach(approach(c, landing, ends, (ctx, None)));
            }
            let asked = sum_requests.include(c);
            if landed != 0 || asked {
                let [p, q, r, s] = points;
                let peaks = [p, q, r, s, p + q + r + s].map(|p| bounded(p / ctx.dt));
                let push = (c.normal * (p + q + r + s) + rub * n).bounded();
                let (contact, points) = (pair.contact, points.map(bounded));
                self.given.push(ContactTotals { contact, points, push, peaks, landed, asked });
            }
        }
        for link in &self.links {
            let joint = joints.at_mut(link.row);
            joint.impulse = link.impulse;
            joint.given = [link.linear() * n, Vec3::ZERO];
            joint.peak = [link.linear().length(), 0.0];
            if let (JointLink::Coupling(coupling), Some(row)) = (&mut joint.model, &link.coupled) {
                coupling.impulse = row.impulse;
            }
            if let (JointLink::SixDof(six_dof), Some(axes)) = (&mut joint.model, &link.axes) {
                six_dof.state.angles = axes.angles;
                (six_dof.state.force, six_dof.state.torque) = (axes.force, axes.torque);
                joint.given = [axes.force * n, axes.torque * n];
                joint.peak = [axes.force.length(), axes.torque.length()];
            }
        }
    }

    /// Writes the motion as solver bodies of mass and inertia one.
    fn write_bodies(&self, settings: &Settings, s: &mut Solved) {
        let one = Whitening::new(1.0, &Sym3::diagonal(Vec3::ONE));
        let four = |v: Vec3| [v.x, v.y, v.z, 0.0];
        s.solver_bodies.clear();
        s.whitening.clear();
        s.squeezes.clear();
        s.aux.clear();
        s.free.clear();
        for (i, m) in self.movers.iter().enumerate() {
            s.solver_bodies.push(SolverBody {
                v: four(m.v),
                w: four(m.w),
                x: four(m.x),
                t: four(m.t),
            });
            s.whitening.push(one);
            s.aux.push(Aux::default());
            s.squeezes.push(Squeeze { factor: 1.0, ..Squeeze::default() });
            s.free.push(Some(i > 0 && settings.integration == Integration::Exact && !m.pushed));
        }
    }
}
