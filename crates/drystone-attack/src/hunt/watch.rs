//! Runs a program to its end under all oracles.

use std::collections::BTreeMap;
use std::sync::Mutex;
use std::time::{Duration, Instant};

use drystone::{BodyKind, Pose, World};

use super::energy::Conservation;
use super::events::Told;
use super::facts::Facts;
use super::moment::{Look, Moment};
use super::moving::Motions;
use super::places::Places;
use super::rest::Rest;
use crate::apply::{Done, Ids, apply};
use crate::finding::{Findings, Kind};
use crate::op::{Label, Op, Program};
use crate::run::guarded;

/// Maximum duration of a run; a slower one is ended early, which is not a finding.
const LONGEST: Duration = Duration::from_secs(8);

/// Time after everything has come to rest in which nothing more can be found [s]: an oracle of rest
/// checks every 30 steps.
const AFTER_REST: f32 = 1.5;

/// Result of a run.
#[derive(Clone, Debug, Default)]
pub(super) struct Watched {
    pub(super) steps: u64,
    pub(super) refused: u32,
    /// Whether each operation was done.
    pub(super) done: Vec<bool>,
    pub(super) findings: Findings,
    pub(super) is_cut: bool,
    /// Bodies were created overlapping.
    pub(super) is_overlapped: bool,
    /// For each body the time of its first touch [s], and its final state.
    pub(super) ends: BTreeMap<Label, End>,
    /// Time since which everything is at rest [s].
    pub(super) rest_since: Option<f32>,
    pub(super) hash: u64,
}

/// Summary of a body's motion.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct End {
    pub(super) touched: Option<f32>,
    pub(super) pose: Pose,
    pub(super) large: f32,
}

/// Runs a program under all oracles.
pub(super) fn watch(program: &Program, say: Option<fn(&str)>) -> Watched {
    guard(program, true, false, say)
}

/// Runs a program only for its final state, optionally restoring its own snapshot in the middle.
pub(super) fn follow(program: &Program, restores: bool) -> Watched {
    guard(program, false, restores, None)
}

fn guard(program: &Program, judges: bool, restores: bool, say: Option<fn(&str)>) -> Watched {
    let run = Mutex::new(Run { judges, restores, say, ..Run::default() });
    let caught = guarded(|| {
        let mut run = run.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
        run.all(program);
    });
    let run = run.into_inner().unwrap_or_else(std::sync::PoisonError::into_inner);
    let mut watched = run.watched;
    if let Err(panic) = caught {
        let step = u32::try_from(watched.steps).unwrap_or(u32::MAX);
        watched.findings.add(Kind::Panic, panic.place, panic.message, step);
    }
    watched
}

/// A run in progress.
#[derive(Debug, Default)]
struct Run {
    judges: bool,
    restores: bool,
    say: Option<fn(&str)>,
    facts: Facts,
    ids: Ids,
    moment: Moment,
    watched: Watched,
    energy: Conservation,
    places: Places,
    rest: Rest,
    motions: Motions,
    told: Told,
    time: f32,
    /// Time of the last call between steps [s].
    last_call: f32,
    step: u32,
}

impl Run {
    fn all(&mut self, program: &Program) {
        let Ok(mut world) = World::new(program.config.clone()) else {
            self.watched.refused += 1;
            return;
        };
        self.facts = Facts::of(program);
        if self.judges {
            world.begin_ledger();
        }
        let (start, total) = (Instant::now(), program.steps());
        for (number, op) in program.ops.iter().enumerate() {
            let Op::Step(dt, count) = op else {
                let done =
                    apply(&mut world, &mut self.ids, op, &mut self.watched.findings, self.step);
                self.watched.refused += u32::from(done == Done::Refused);
                self.watched.done.push(done == Done::Yes);
                if self.say.is_some() && done != Done::Yes {
                    self.tell(&format!("{done:?}: {op:?}"));
                }
                // A change between steps must not look like motion since the previous step.
                self.moment = Moment::of(&world, &self.ids, &self.facts);
                self.last_call = self.time;
                continue;
            };
            self.watched.done.push(true);
            let is_last = !program.ops[number + 1..].iter().any(|op| matches!(op, Op::Step(..)));
            for i in 0..*count {
                if self.restores
                    && self.step == total / 2
                    && let Ok(again) = World::restore(&world.snapshot())
                {
                    world = again;
                }
                let is_end = is_last && i + 1 == *count;
                #[expect(clippy::cast_precision_loss, reason = "a part")]
                let part = if is_last { i as f32 / *count as f32 } else { 0.0 };
                self.one(&mut world, *dt, part, is_end);
                if start.elapsed() > LONGEST {
                    self.watched.is_cut = true;
                    return;
                }
                if is_last && self.is_over() {
                    self.end(&world, *dt);
                    self.watched.hash = world.state_hash();
                    return;
                }
            }
        }
        self.watched.hash = world.state_hash();
    }

    fn tell(&self, line: &str) {
        if let Some(say) = self.say {
            say(line);
        }
    }

    fn one(&mut self, world: &mut World, dt: f32, part: f32, is_end: bool) {
        world.step(dt);
        self.step += 1;
        self.watched.steps += 1;
        self.time += dt;
        let now = Moment::of(world, &self.ids, &self.facts);
        let before = core::mem::replace(&mut self.moment, now);
        let now = core::mem::take(&mut self.moment);
        let quiet = self.time - self.last_call;
        let look = Look {
            world,
            facts: &self.facts,
            before: &before,
            now: &now,
            dt,
            time: self.time,
            quiet,
            step: self.step,
        };
        for touch in &now.touches {
            for id in touch.bodies {
                let Some(body) = now.bodies.get(&id) else { continue };
                // A contact may stop a fast body slightly before the touch or after.
                let near = 0.02 * body.large.min(1.0e3);
                if !touch.is_pressed() && touch.points.iter().all(|p| p.separation > near) {
                    continue;
                }
                self.watched.ends.entry(body.label).or_default().touched.get_or_insert(self.time);
            }
        }
        let findings = &mut self.watched.findings;
        let known = findings.all.len();
        if self.judges {
            self.energy.see(&look, findings);
            self.places.see(&look, findings);
            self.motions.see(&look, findings);
            self.told.see(&look, findings);
        }
        self.rest.see(&look);
        if self.judges {
            self.rest.judge(&look, findings);
            self.rest.mark(&look, part);
        }
        self.watched.rest_since = self.rest.rest_since;
        self.watched.is_overlapped = self.places.is_overlapped();
        for (_, body) in now.bodies.iter().filter(|(_, b)| b.kind == BodyKind::Dynamic) {
            let end = self.watched.ends.entry(body.label).or_default();
            (end.pose, end.large) = (body.pose, body.large);
        }
        if self.say.is_some() {
            self.tell_of(world, &now, known);
        }
        self.moment = now;
        if is_end {
            self.end(world, dt);
        }
    }

    /// Writes the state of all bodies: every step at first, rarely later.
    fn tell_of(&self, world: &World, now: &Moment, known: usize) {
        for f in &self.watched.findings.all[known..] {
            self.tell(&format!("!! {} {}: {} (step {})", f.kind.name(), f.what, f.detail, f.step));
        }
        let rare = if self.step < 60 {
            4
        } else if self.step < 600 {
            20
        } else {
            200
        };
        let is_new = self.watched.findings.all.len() > known;
        if !self.step.is_multiple_of(rare) && !is_new {
            return;
        }
        let energy = world.kinetic_energy() + world.potential_energy();
        self.tell(&format!("step {} t {:.4} energy {energy:.6e}", self.step, self.time));
        for (_, b) in now.dynamic() {
            let (p, v, w) = (b.center, b.v, b.w);
            let sleep = if b.is_asleep { " asleep" } else { "" };
            self.tell(&format!(
                "   {} at {:.5} {:.5} {:.5} v {:.4} {:.4} {:.4} w {:.3} {:.3} {:.3}{sleep}",
                b.label, p.x, p.y, p.z, v.x, v.y, v.z, w.x, w.y, w.z
            ));
        }
        for t in &now.touches {
            let labels = t.bodies.map(|id| now.bodies.get(&id).map_or(0, |b| b.label));
            let points: Vec<_> = t.points.iter().map(|p| (p.separation, p.impulse)).collect();
            self.tell(&format!("      touch {labels:?} normal {:?} {points:?}", t.normal));
        }
        for j in world.joints() {
            self.tell(&format!("      joint gap {} angle {}", j.error(), j.angular_error()));
        }
    }

    /// Whether everything has rested for a while, and nothing moves that could change that.
    fn is_over(&self) -> bool {
        let asleep = self.moment.dynamic().all(|(_, b)| b.is_asleep);
        let carried = self.facts.has_carriers || self.facts.has_belts || self.facts.has_drives;
        let rested = self.rest.rest_since.is_some_and(|since| self.time - since > AFTER_REST);
        asleep && rested && !carried && self.time - self.last_call > AFTER_REST
    }

    fn end(&mut self, world: &World, dt: f32) {
        if !self.judges {
            return;
        }
        let (time, step) = (self.time, self.step);
        let quiet = time - self.last_call;
        let (facts, now) = (&self.facts, &self.moment);
        let look = Look { world, facts, before: now, now, dt, time, quiet, step };
        let findings = &mut self.watched.findings;
        self.places.end(&look, findings);
        self.rest.end(&look, findings);
        self.motions.end(&look, findings);
        self.told.end(&look, findings);
    }
}

#[cfg(test)]
mod tests {
    use drystone::{BodyDef, Shape, Vec3, World, WorldConfig, vec3};

    use super::{Facts, Look, Moment, watch};
    use crate::apply::{Ids, apply};
    use crate::finding::{Findings, Kind};
    use crate::hunt::draw::{Draw, Solid};
    use crate::hunt::energy::Conservation;
    use crate::hunt::events::Told;
    use crate::hunt::floors::Floor;
    use crate::hunt::moving::Motions;
    use crate::hunt::places::Places;
    use crate::hunt::rest::Rest;
    use crate::hunt::{Scene, twins};
    use crate::op::{Op, Program};

    /// A cube of 1 m above a floor, with earth's gravity and 60 steps per second.
    fn cube(height: f32, v: Vec3, friction: f32, steps: u32) -> Program {
        let mut d = Draw::new(1, Scene::Drops);
        d.config = WorldConfig::default();
        d.material = drystone::Material { friction, ..drystone::Material::default() };
        d.floor_of(Floor::Box, 20.0);
        let position = vec3(0.0, 0.5 + height, 0.0);
        let def = BodyDef { position, linear_velocity: v, ..BodyDef::default() };
        d.body(&Solid::of(Shape::box_half([0.5; 3])), def);
        d.ops.push(Op::Step(1.0 / 60.0, steps));
        d.finish()
    }

    #[test]
    fn a_cube_that_falls_lies_and_breaks_nothing_and_nor_do_its_twins() {
        let program = cube(1.0, Vec3::ZERO, 0.6, 300);
        let facts = Facts::of(&program);
        assert!(facts.lands_flat && !facts.stands && facts.must_rest());
        let watched = watch(&program, None);
        let mut findings = watched.findings.clone();
        let steps = twins::compare(&program, &watched, &mut findings);
        assert!(findings.all.is_empty() && steps > 1000, "{:?}", findings.all);
        assert!(watched.rest_since.is_some_and(|t| t < 1.0));
    }

    #[test]
    fn what_a_program_promises_follows_from_its_operations() {
        let still = Facts::of(&cube(0.0, Vec3::ZERO, 0.6, 9));
        assert!(still.stands && still.glider.is_none());
        let glides = Facts::of(&cube(0.0, Vec3::X, 0.0, 9));
        assert!(glides.glider.is_some() && !glides.must_rest());
        assert!(Facts::of(&cube(0.0, Vec3::X, 0.6, 9)).slider.is_some());
    }

    /// Findings of all oracles in a step in which the cube changed its state by magic.
    fn judged(program: &Program, change: impl Fn(&mut super::super::moment::Body)) -> Vec<Kind> {
        let facts = Facts::of(program);
        let (mut world, mut ids) = (World::default(), Ids::default());
        for op in &program.ops {
            apply(&mut world, &mut ids, op, &mut Findings::default(), 0);
        }
        let before = Moment::of(&world, &ids, &facts);
        let mut now = before.clone();
        now.bodies.values_mut().filter(|b| b.is_dynamic()).for_each(change);
        let (mut places, mut findings) = (Places::default(), Findings::default());
        let look = |before, now, step| {
            let (dt, time, quiet) = (1.0 / 60.0, 1.0, 1.0);
            Look { world: &world, facts: &facts, before, now, dt, time, quiet, step }
        };
        places.see(&look(&before, &before, 1), &mut findings);
        let look = look(&before, &now, 30);
        places.see(&look, &mut findings);
        Motions::default().see(&look, &mut findings);
        Told::default().see(&look, &mut findings);
        let mut rest = Rest::default();
        rest.see(&look);
        rest.judge(&look, &mut findings);
        findings.all.iter().map(|f| f.kind).collect()
    }

    #[test]
    fn magic_is_seen() {
        let falls = cube(2.0, Vec3::ZERO, 0.6, 9);
        assert_eq!(judged(&falls, |_| {}), []);
        let down = |body: &mut super::super::moment::Body| {
            body.pose.position.y -= 4.0;
            body.center.y -= 4.0;
        };
        assert_eq!(judged(&falls, down), [Kind::Through]);
        assert_eq!(judged(&falls, |body| body.is_asleep = true), [Kind::Balance]);
        assert_eq!(judged(&falls, |body| body.v.y = 2.0), [Kind::Bounce]);
        let glides = cube(0.0, Vec3::X, 0.0, 9);
        assert_eq!(judged(&glides, |body| body.v.x = 0.5), [Kind::Glide]);
        let stands = cube(0.0, Vec3::ZERO, 0.6, 9);
        assert_eq!(judged(&stands, |body| body.pose.position.x += 0.2), [Kind::Fallen]);
    }

    #[test]
    fn energy_that_nothing_gives_is_seen() {
        // A belt supplies the energy; without the belt in the facts, the energy balance fails.
        let mut program = cube(0.0, Vec3::ZERO, 0.6, 9);
        if let Some(Op::AddBody(plan)) = program.ops.first_mut() {
            plan.shapes.iter_mut().for_each(|s| s.def.surface_velocity = vec3(3.0, 0.0, 0.0));
        }
        let facts = Facts { has_belts: false, ..Facts::of(&program) };
        let (mut world, mut ids) = (World::default(), Ids::default());
        for op in &program.ops {
            apply(&mut world, &mut ids, op, &mut Findings::default(), 0);
        }
        world.begin_ledger();
        let (mut books, mut findings) = (Conservation::default(), Findings::default());
        for step in 1..60 {
            world.step(1.0 / 60.0);
            let now = Moment::of(&world, &ids, &facts);
            let (before, now) = (&now, &now);
            let (dt, time) = (1.0 / 60.0, 0.5);
            let look =
                Look { world: &world, facts: &facts, before, now, dt, time, quiet: time, step };
            books.see(&look, &mut findings);
        }
        assert_eq!(findings.all.iter().map(|f| f.kind).collect::<Vec<_>>(), [Kind::Energy]);
    }
}
