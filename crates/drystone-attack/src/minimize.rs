//! Shrinks a failing program while it still fails in the same way.

use std::time::{Duration, Instant};

use drystone::events::{ContactReports, Senses};
use drystone::joint::JointMotion;
use drystone::{Filter, MassDef, Material, Pose, Quat, Vec3, WorldConfig};

use crate::finding::{Finding, Findings, Kind};
use crate::generate;
use crate::numbers;
use crate::op::{Form, Op, Program};
use crate::run::{Conditions, Run, run};
use crate::variants;

/// Findings in the program of a seed, under all conditions.
#[must_use]
pub fn findings_of(seed: u64, strict: bool) -> Vec<Finding> {
    let program = generate::program(seed);
    let conditions = Conditions { strict, ..Conditions::BASE };
    let base = run(&program, &conditions);
    let mut findings = base.findings.clone();
    let _ = variants::compare(&program, &base, &mut findings);
    findings.all
}

/// The smallest program found within a time that fails like the program of a seed.
#[must_use]
pub fn minimize(seed: u64, like: &Finding, strict: bool, time: Duration) -> Program {
    let conditions = Conditions { strict, ..Conditions::BASE };
    minimize_program(generate::program(seed), like, &conditions, time)
}

/// As `minimize`, for any program under these conditions.
#[must_use]
pub fn minimize_program(
    program: Program,
    like: &Finding,
    conditions: &Conditions,
    time: Duration,
) -> Program {
    minimize_by(program, like, time, &|program| {
        let mut base = run(program, conditions);
        let is_compared =
            matches!(like.kind, Kind::HashDiffers | Kind::Panic | Kind::SnapshotRefused);
        if is_compared && !base.findings.have(like) {
            let mut findings = Findings::default();
            let _ = variants::compare(program, &base, &mut findings);
            base.findings = findings;
        }
        base
    })
}

/// As `minimize`, for any program and any judge that returns its findings.
#[must_use]
pub fn minimize_by(
    program: Program,
    like: &Finding,
    time: Duration,
    judge: &dyn Fn(&Program) -> Run,
) -> Program {
    let mut search =
        Search { best: program, like: like.clone(), judge, end: Instant::now() + time };
    loop {
        let before = format!("{:?}", search.best);
        search.drop_undone();
        search.cut_end();
        search.drop_ops();
        search.fewer_steps();
        search.fewer_parts();
        if search.is_over() || format!("{:?}", search.best) == before {
            break;
        }
    }
    if !search.is_of_ordinary() {
        search.simpler_numbers();
        search.drop_ops();
    }
    search.best
}

/// The state of a search for a smaller program.
struct Search<'a> {
    best: Program,
    like: Finding,
    judge: &'a dyn Fn(&Program) -> Run,
    end: Instant,
}

impl Search<'_> {
    fn is_over(&self) -> bool {
        Instant::now() > self.end
    }

    fn run(&self, program: &Program) -> Run {
        (self.judge)(program)
    }

    /// True if the finding counts in ordinary worlds only. Simpler parts and rounder numbers could
    /// make such a world extraordinary: its joints would start open, or its steps would take a
    /// second.
    const fn is_of_ordinary(&self) -> bool {
        matches!(self.like.kind, Kind::Fault | Kind::Wild)
    }

    /// Whether a program fails in the same way.
    fn breaks(&self, program: &Program) -> bool {
        self.run(program).findings.have(&self.like)
    }

    /// Adopts a program if it fails in the same way.
    fn take(&mut self, program: Program) -> bool {
        let is_good = !self.is_over() && self.breaks(&program);
        if is_good {
            self.best = program;
        }
        is_good
    }

    /// Removes operations that were refused, or had nothing to act on.
    fn drop_undone(&mut self) {
        let done = self.run(&self.best).done;
        let mut next = self.best.clone();
        let mut number = 0;
        next.ops.retain(|_| {
            number += 1;
            done.get(number - 1).copied().unwrap_or(false)
        });
        if next.ops.len() < self.best.ops.len() {
            // An operation that panics does not count as done, but must stay.
            self.take(next);
        }
    }

    /// Removes operations after the finding.
    fn cut_end(&mut self) {
        let found = self.run(&self.best).findings;
        let Some(last) = found.all.iter().find(|f| f.is_like(&self.like)).map(|f| f.step) else {
            return;
        };
        let mut next = Program { ops: Vec::new(), ..self.best.clone() };
        let mut step = 0;
        for op in &self.best.ops {
            if step > last {
                break;
            }
            let Op::Step(dt, count) = op else {
                next.ops.push(op.clone());
                continue;
            };
            let count = (*count).min(last - step);
            step += count;
            if count > 0 {
                next.ops.push(Op::Step(*dt, count));
            }
            if step == last {
                step += 1;
            }
        }
        self.take(next);
    }

    /// Removes unnecessary operations: halves first, single ones last.
    fn drop_ops(&mut self) {
        let mut size = self.best.ops.len() / 2;
        while size > 0 {
            let mut at = 0;
            while at < self.best.ops.len() && !self.is_over() {
                let mut next = self.best.clone();
                let end = (at + size).min(next.ops.len());
                next.ops.drain(at..end);
                if !self.take(next) {
                    at += size;
                }
            }
            size /= 2;
        }
    }

    /// Reduces the number of steps, and makes all steps equally long.
    fn fewer_steps(&mut self) {
        for i in 0..self.best.ops.len() {
            while let Some(Op::Step(dt, count)) = self.best.ops.get(i) {
                let (dt, count) = (*dt, *count);
                let mut one = |count: u32| {
                    let mut next = self.best.clone();
                    next.ops[i] = Op::Step(dt, count);
                    self.take(next)
                };
                if !(count > 1 && (one(count / 2) || one(count - 1))) {
                    break;
                }
            }
        }
        let mut next = self.best.clone();
        for op in &mut next.ops {
            if let Op::Step(dt, _) = op {
                *dt = 1.0 / 60.0;
            }
        }
        self.take(next);
        self.join_steps();
    }

    /// Merges consecutive steps of equal length into one operation.
    fn join_steps(&mut self) {
        let mut next = Program { ops: Vec::new(), ..self.best.clone() };
        for op in &self.best.ops {
            match (next.ops.last_mut(), op) {
                (Some(Op::Step(last, sum)), Op::Step(dt, count))
                    if last.to_bits() == dt.to_bits() =>
                {
                    *sum += count;
                }
                _ => next.ops.push(op.clone()),
            }
        }
        self.take(next);
    }

    /// Makes each object as simple as possible.
    fn fewer_parts(&mut self) {
        let mut next = self.best.clone();
        next.config = WorldConfig::default();
        if !self.take(next) {
            for i in 0..8 {
                let mut next = self.best.clone();
                plain_config(&mut next.config, i);
                self.take(next);
            }
        }
        if self.is_of_ordinary() {
            return;
        }
        for i in 0..self.best.ops.len() {
            for way in 0..WAYS {
                let mut next = self.best.clone();
                if plain_op(&mut next.ops[i], way) {
                    self.take(next);
                }
            }
            self.fewer_shapes(i);
            self.fewer_points(i);
        }
    }

    fn fewer_shapes(&mut self, i: usize) {
        let mut k = 0;
        loop {
            let mut next = self.best.clone();
            let Some(Op::AddBody(plan)) = next.ops.get_mut(i) else { return };
            if k >= plan.shapes.len() {
                return;
            }
            plan.shapes.remove(k);
            if !self.take(next) {
                k += 1;
            }
        }
    }

    /// Removes points of hulls and triangles of meshes.
    fn fewer_points(&mut self, i: usize) {
        let Some(Op::AddBody(plan)) = self.best.ops.get(i) else { return };
        for k in 0..plan.shapes.len() {
            let mut at = 0;
            loop {
                let mut next = self.best.clone();
                let Some(Op::AddBody(plan)) = next.ops.get_mut(i) else { return };
                let Some(shape) = plan.shapes.get_mut(k) else { break };
                if self.is_over() || !without_part(&mut shape.form, at) {
                    break;
                }
                if !self.take(next) {
                    at += 1;
                }
            }
        }
    }

    /// Makes each number as short as possible.
    fn simpler_numbers(&mut self) {
        for i in 0..self.best.ops.len() {
            let mut count = 0;
            numbers::of_op(&mut self.best.ops[i].clone(), &mut |_| count += 1);
            for number in 0..count {
                if self.is_over() {
                    return;
                }
                let value = nth(&self.best.ops[i], number);
                // Most fields with short values have their default value.
                if rounded(value, 2).to_bits() == value.to_bits() {
                    continue;
                }
                for simple in
                    [0.0, 1.0, -1.0, rounded(value, 1), rounded(value, 2), rounded(value, 3)]
                {
                    if simple.to_bits() == value.to_bits() {
                        break;
                    }
                    let mut next = self.best.clone();
                    set_nth(&mut next.ops[i], number, simple);
                    if self.take(next) {
                        break;
                    }
                }
            }
        }
    }
}

fn nth(op: &Op, number: usize) -> f32 {
    let (mut i, mut value) = (0, 0.0);
    numbers::of_op(&mut op.clone(), &mut |x| {
        if i == number {
            value = *x;
        }
        i += 1;
    });
    value
}

fn set_nth(op: &mut Op, number: usize, value: f32) {
    let mut i = 0;
    numbers::of_op(op, &mut |x| {
        if i == number {
            *x = value;
        }
        i += 1;
    });
}

/// Rounds to this number of digits.
fn rounded(value: f32, digits: usize) -> f32 {
    format!("{value:.*e}", digits - 1).parse().unwrap_or(value)
}

fn plain_config(config: &mut WorldConfig, part: usize) {
    let plain = WorldConfig::default();
    match part {
        0 => config.gravity = plain.gravity,
        1 => config.method = plain.method,
        2 => config.substeps = plain.substeps,
        3 => config.contact = plain.contact,
        4 => config.inertia = plain.inertia,
        5 => config.joint = plain.joint,
        6 => (config.particle, config.penalty) = (plain.particle, plain.penalty),
        _ => (config.sleep, config.breakage) = (plain.sleep, plain.breakage),
    }
}

/// Removes one point of a hull or one triangle of a mesh; returns false if impossible.
fn without_part(form: &mut Form, at: usize) -> bool {
    match form {
        Form::Hull(points) if at < points.len() && points.len() > 4 => {
            points.remove(at);
            true
        }
        Form::Mesh(points, triangles) if at < triangles.len() && triangles.len() > 1 => {
            triangles.remove(at);
            let mut used: Vec<u32> = triangles.iter().flatten().copied().collect();
            used.sort_unstable();
            used.dedup();
            let place = |vertex: u32| used.binary_search(&vertex).ok();
            let kept = used.iter().filter_map(|v| points.get(*v as usize).copied()).collect();
            for vertex in triangles.iter_mut().flatten() {
                let number = place(*vertex).and_then(|n| u32::try_from(n).ok());
                *vertex = number.unwrap_or(u32::MAX);
            }
            *points = kept;
            true
        }
        _ => false,
    }
}

/// Number of simplifications of an operation.
const WAYS: usize = 14;

/// Applies one simplification to an operation; returns false if it changes nothing.
fn plain_op(op: &mut Op, way: usize) -> bool {
    let before = format!("{op:?}");
    match op {
        Op::AddBody(plan) => {
            let def = &mut plan.def;
            match way {
                0 => (def.rotation, def.can_sleep) = (Quat::IDENTITY, true),
                1 => def.linear_velocity = Vec3::ZERO,
                2 => def.angular_velocity = Vec3::ZERO,
                3 => def.mass = MassDef::FromShapes,
                4 => (def.gravity_scale, def.sleep_speed, def.asleep) = (1.0, None, false),
                5 => (def.linear_damping, def.angular_damping) = (0.0, 0.0),
                6 => def.locks = drystone::AxisLocks::NONE,
                7 => (def.fracture, def.user_data, def.enabled) = (None, 0, true),
                8 => plan.glue = None,
                _ => plan.shapes.iter_mut().for_each(|shape| plain_shape(&mut shape.def, way)),
            }
        }
        Op::AddShape(_, plan) => plain_shape(&mut plan.def, way),
        Op::AddJoint(plan) => match way {
            0 => (plan.articulated, plan.enabled) = (false, true),
            1 => plan.collide_connected = false,
            2 => plan.strength = None,
            _ => {
                if let drystone::JointKind::SixDof(axes) = &mut plan.kind {
                    let all = axes.linear.iter_mut().chain(&mut axes.angular);
                    if let Some(axis) = all.into_iter().nth(way - 3) {
                        if axis.motion != JointMotion::Locked {
                            *axis = drystone::joint::JointAxis::FREE;
                        }
                    } else {
                        axes.cone = None;
                    }
                }
            }
        },
        Op::AddRope(_, _, def) => plain_particle(&mut def.particle, way),
        Op::AddCloth(_, _, def) => plain_particle(&mut def.particle, way),
        Op::AddCloud(_, _, def) | Op::AddParticle(_, def) => plain_particle(def, way),
        _ => return false,
    }
    format!("{op:?}") != before
}

fn plain_shape(def: &mut drystone::ShapeDef, way: usize) {
    match way {
        9 => def.material = Material::default(),
        10 => def.filter = Filter::default(),
        11 => def.pose = Pose::IDENTITY,
        12 => def.density = 1000.0,
        13 => {
            (def.surface_velocity, def.surface_spin) = (Vec3::ZERO, Vec3::ZERO);
            def.sensor = false;
            (def.reports, def.senses) = (ContactReports::default(), Senses::default());
            (def.one_way, def.hooks, def.enabled) = (None, false, true);
        }
        _ => {}
    }
}

fn plain_particle(def: &mut drystone::particle::ParticleDef, way: usize) {
    match way {
        0 => def.material = Material::default(),
        1 => def.filter = Filter::default(),
        2 => def.velocity = Vec3::ZERO,
        3 => (def.gravity_scale, def.damping) = (1.0, 0.0),
        _ => {}
    }
}

#[cfg(test)]
mod tests {
    use std::time::Duration;

    use drystone::World;

    use super::minimize_program;
    use crate::generate::program_of;
    use crate::op::{Op, Style};
    use crate::run::{Conditions, run};
    use crate::source;

    /// A judge that fails every world with a sphere that fell for a while.
    fn has_a_deep_sphere(world: &World) -> bool {
        world.bodies().any(|b| {
            let is_sphere = |id| world.shape(id).is_some_and(|s| s.shape().kind() == "sphere");
            b.shapes().any(is_sphere) && b.linear_velocity().y < -0.5
        })
    }

    #[test]
    fn a_planted_fault_is_found_and_shrunk_to_the_body_that_has_it() {
        let conditions = Conditions { plant: Some(has_a_deep_sphere), ..Conditions::BASE };
        let found = (0..100).find_map(|seed| {
            let program = program_of(seed, Style::Ordinary);
            let found = run(&program, &conditions).findings;
            found.all.into_iter().find(|f| f.what == "planted").map(|f| (program, f))
        });
        let (program, finding) = found.unwrap();
        let small = minimize_program(program, &finding, &conditions, Duration::from_secs(20));
        assert!(run(&small, &conditions).findings.have(&finding));
        let bodies = small.ops.iter().filter(|op| matches!(op, Op::AddBody(_))).count();
        assert!(bodies == 1 && small.ops.len() <= 3, "{:?}", small.ops);
        let text = source::test(&small, 1, Some(&finding));
        assert!(text.contains("Shape::Sphere") && text.contains("world.add_body("), "{text}");
    }
}
