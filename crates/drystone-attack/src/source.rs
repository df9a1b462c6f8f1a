//! Writes a program as the source of a test: plain calls of the public API.

use std::collections::BTreeSet;
use std::fmt::{Debug, Write};

use drystone::{BodyDef, JointKind, WorldConfig};

use crate::finding::{Finding, Kind};
use crate::names::imports;
use crate::op::{
    BodyPlan, CouplingPlan, JointPlan, Label, LinkPlan, Op, PIECES, ParticleCall, Place, Program,
    QueryCall, ShapeCall,
};
use crate::source_calls::{body_call, joint_call};
use crate::text::plain;
use crate::values::{DEFAULTS, changes, form, seconds, shape_def, show};
use crate::variants::RESTORE_EVERY;

/// The source of a test that runs the program and asserts that the finding does not occur.
#[must_use]
pub fn test(program: &Program, seed: u64, finding: Option<&Finding>) -> String {
    let kind = finding.map(|f| f.kind);
    let is_compared = kind == Some(Kind::HashDiffers);
    let used = used_labels(program);
    let has_pieces = used.iter().any(|(kind, label)| *kind == 'b' && *label >= PIECES);
    let checks = Checks::default();
    let mut source =
        Source { text: String::new(), used, has_pieces, kind, checks, has_begun: false };
    let name = kind.map_or("program", Kind::name).replace('-', "_");
    source.line("#[test]");
    source.line(&format!("fn attack_{name}_{seed}() {{"));
    if is_compared {
        source.line("let run = |threads: usize, level: SimdLevel, restore_every: usize| {");
    }
    source.config("config", &program.config);
    source.line("let mut world = World::new(config).unwrap();");
    if is_compared {
        source.line("let equip = |world: &mut World| {");
        source.line("world.set_executor(Arc::new(Team::with_threads(threads)));");
        source.line("world.set_simd_level(level);");
        source.line("};");
        source.line("equip(&mut world);");
        source.line("let mut hashes = Vec::new();");
    }
    if has_pieces {
        source.line("let mut pieces: Vec<BodyId> = Vec::new();");
    }
    if kind == Some(Kind::Unpaired) {
        source.line("let mut pairs: BTreeSet<(ShapeId, ShapeId)> = BTreeSet::new();");
    }
    for op in &program.ops {
        source.op(op);
    }
    if is_compared {
        source.line("hashes");
        source.line("};");
    }
    source.ending();
    source.line("}");
    let why = finding
        .map(|f| format!("// {}: {} (step {} of seed {seed})\n", f.kind.name(), f.what, f.step));
    whole(&why.unwrap_or_default(), &source.text)
}

fn whole(why: &str, text: &str) -> String {
    let head = "// For crates/drystone/tests/it, under a name that says what must hold.\n";
    format!("{head}{why}{}\n{text}", imports(text))
}

/// Lines with the assertions of a test.
#[derive(Clone, Debug, Default)]
pub struct Checks {
    /// Bodies that the lines name.
    pub names: Vec<Label>,
    /// Lines before the first step.
    pub before: Vec<String>,
    /// Lines after each step.
    pub each: Vec<String>,
    /// Lines at the end.
    pub end: Vec<String>,
}

/// The source of a test of this name that runs the program and has these assertions.
#[must_use]
pub fn test_with(program: &Program, name: &str, checks: &Checks, finding: &Finding) -> String {
    let mut used = used_labels(program);
    used.extend(checks.names.iter().map(|label| ('b', *label)));
    let (kind, checks) = (Some(finding.kind), checks.clone());
    let has_pieces = false;
    let mut source =
        Source { text: String::new(), used, has_pieces, kind, checks, has_begun: false };
    source.line("#[test]");
    source.line(&format!("fn {name}() {{"));
    source.config("config", &program.config);
    source.line("let mut world = World::new(config).unwrap();");
    for op in &program.ops {
        source.op(op);
    }
    for line in source.checks.end.clone() {
        source.line(&line);
    }
    source.line("}");
    let Finding { kind, what, detail, step } = finding;
    let why = format!("// {}: {what} (step {step})\n// {detail}\n", kind.name());
    whole(&why, &source.text)
}

/// Source under construction.
struct Source {
    text: String,
    /// Labels that operations name, with the kind of object.
    used: BTreeSet<(char, Label)>,
    has_pieces: bool,
    kind: Option<Kind>,
    checks: Checks,
    /// Whether there was a step.
    has_begun: bool,
}

/// The objects that later operations name: only these get a variable.
fn used_labels(program: &Program) -> BTreeSet<(char, Label)> {
    let mut used = BTreeSet::new();
    for op in &program.ops {
        let names: Vec<(char, Label)> = match op {
            Op::AddShape(b, _)
            | Op::RemoveBody(b)
            | Op::Body(b, _)
            | Op::FractureBody(b, ..)
            | Op::SetFracture(b, _)
            | Op::SetBondStrength(b, _) => vec![('b', *b)],
            Op::RemoveShape(s) | Op::Shape(s, _) => vec![('s', *s)],
            Op::AddJoint(plan) => plan.bodies.map(|b| ('b', b)).to_vec(),
            Op::AddCoupling(plan) => plan.joints.map(|j| ('j', j)).to_vec(),
            Op::RemoveJoint(j)
            | Op::SetJointAxes(j, _)
            | Op::SetJointDrive(j, ..)
            | Op::SetJointStrength(j, _)
            | Op::Joint(j, _) => vec![('j', *j)],
            Op::RemoveParticle(p) | Op::Detach(p) | Op::Particle(p, _) => vec![('p', *p)],
            Op::AddLink(plan) => plan.ends.map(|p| ('p', p)).to_vec(),
            Op::RemoveLink(l) | Op::SetLinkLength(l, _) => vec![('l', *l)],
            Op::Attach(p, b, _) => vec![('p', *p), ('b', *b)],
            _ => Vec::new(),
        };
        used.extend(names);
    }
    used
}

/// Name of a body in the source.
fn body(label: Label) -> String {
    if label >= PIECES { format!("pieces[{}]", label - PIECES) } else { format!("b{label}") }
}

impl Source {
    /// Adds a line, indented by the number of open brackets.
    fn line(&mut self, text: &str) {
        let count = |of: [char; 2], text: &str| text.matches(of).count();
        let depth = count(['{', '('], &self.text).saturating_sub(count(['}', ')'], &self.text));
        let depth = if text.starts_with('}') { depth.saturating_sub(1) } else { depth };
        // Writing to a string cannot fail.
        let _ = writeln!(self.text, "{}{text}", "    ".repeat(depth));
    }

    fn op(&mut self, op: &Op) {
        match op {
            Op::AddBody(plan) => self.add_body(plan),
            Op::AddShape(b, plan) => {
                let shape = shape_def(plan);
                let text = format!(
                    "{}world.add_shape({}, {shape}).unwrap();",
                    self.bind('s', plan.label),
                    body(*b)
                );
                self.line(&text);
            }
            Op::AddJoint(plan) => self.add_joint(plan),
            Op::AddCoupling(plan) => {
                let CouplingPlan { label, joints: [a, b], axes: [p, q], ratio, offset } = plan;
                let (ratio, offset) = (show(ratio), show(offset));
                let bind = self.bind('j', *label);
                self.line(&format!(
                    "{bind}world.add_coupling(CouplingDef {{ joint_a: j{a}, axis_a: Axis::{p:?}, joint_b: j{b}, \
                     axis_b: Axis::{q:?}, ratio: {ratio}, offset: {offset} }}).unwrap();"
                ));
            }
            Op::SetJointAxes(j, axes) => {
                let axes = show(axes);
                self.line(&format!("world.joint_mut(j{j}).unwrap().set_axes({axes}).unwrap();"));
            }
            Op::AddParticle(..)
            | Op::AddRope(..)
            | Op::AddCloth(..)
            | Op::AddCloud(..)
            | Op::AddLink(_) => self.particles(op),
            Op::SetConfig(config) => {
                self.config("config", config);
                self.line("world.set_config(config).unwrap();");
            }
            Op::Query(call) => self.query(call),
            Op::Step(dt, count) => {
                let dt = seconds(*dt);
                self.steps(&dt, *count);
            }
            _ => {
                let text = call(op);
                self.line(&text);
            }
        }
    }

    fn steps(&mut self, dt: &str, count: u32) {
        if !core::mem::replace(&mut self.has_begun, true) {
            for line in self.checks.before.clone() {
                self.line(&line);
            }
        }
        self.line(&format!("for _ in 0..{count} {{"));
        let is_compared = self.kind == Some(Kind::HashDiffers);
        if is_compared {
            self.line("if hashes.len() % restore_every == restore_every - 1 {");
            self.line("world = World::restore(&world.snapshot()).unwrap();");
            self.line("equip(&mut world);");
            self.line("}");
        }
        self.line(&format!("world.step({dt});"));
        for line in self.checks.each.clone() {
            self.line(&line);
        }
        if self.has_pieces {
            self.line("pieces.extend(world.events().pieces.iter().copied());");
        }
        if is_compared {
            self.line("hashes.push(world.state_hash());");
        }
        if self.kind == Some(Kind::Unpaired) {
            self.line("let (events, pair) = (world.events(), |a: ShapeId, b: ShapeId| (a.min(b), a.max(b)));");
            for (end, begin, a, b) in [
                ("contact_end", "contact_begin", "shape_a", "shape_b"),
                ("sensor_exit", "sensor_enter", "sensor", "visitor"),
            ] {
                self.line(&format!("for e in &events.{end} {{"));
                self.line(&format!("assert!(pairs.remove(&pair(e.{a}, e.{b})), \"{{e:?}}\");"));
                self.line("}");
                self.line(&format!("for e in &events.{begin} {{"));
                self.line(&format!("assert!(pairs.insert(pair(e.{a}, e.{b})), \"{{e:?}}\");"));
                self.line("}");
            }
        }
        self.line("}");
    }

    /// `let NAME = ` if a later operation names the object.
    fn bind(&self, kind: char, label: Label) -> String {
        let is_used = self.used.contains(&(kind, label));
        if is_used { format!("let {kind}{label} = ") } else { String::new() }
    }

    fn add_body(&mut self, plan: &BodyPlan) {
        let b = plan.label;
        let mut def =
            plain(&format!("{:?}", BodyDef { shapes: Vec::new(), ..plan.def.clone() }), DEFAULTS);
        for shape in &plan.shapes {
            let _ = write!(def, "\n            .with_shape({})", shape_def(shape));
        }
        self.line(&format!("let def = {def};"));
        if let Some((gap, strength)) = &plan.glue {
            let (gap, strength) = (show(gap), show(strength));
            self.line(&format!(
                "let glue = Glue::touching(&def.shapes, {gap}, {strength}).unwrap();"
            ));
            self.line("let def = def.with_glue(glue);");
        }
        let has_shapes = plan.shapes.iter().any(|s| self.used.contains(&('s', s.label)));
        let bind = if has_shapes { format!("let b{b} = ") } else { self.bind('b', b) };
        self.line(&format!("{bind}world.add_body(def).unwrap();"));
        for (i, shape) in plan.shapes.iter().enumerate() {
            if self.used.contains(&('s', shape.label)) {
                let s = shape.label;
                self.line(&format!(
                    "let s{s} = world.body(b{b}).unwrap().shapes().nth({i}).unwrap();"
                ));
            }
        }
    }

    fn add_joint(&mut self, plan: &JointPlan) {
        let JointPlan { label, bodies, place, kind, collide_connected, strength, .. } = plan;
        let (articulated, enabled) = (plan.articulated, plan.enabled);
        let [a, b] = bodies.map(body);
        match (place, kind) {
            (Place::Along(anchor, axis), JointKind::SixDof(axes)) => {
                let (anchor, axis, axes) = (show(anchor), show(axis), show(axes));
                self.line(&format!(
                    "let def = JointDef::new({a}, {b}, {axes}).at({anchor}).with_axis({axis});"
                ));
            }
            (Place::Along(p, q) | Place::Anchors(p, q), kind) => {
                let (p, q, kind) = (show(p), show(q), show(kind));
                self.line(&format!(
                    "let def = JointDef::new({a}, {b}, {kind}).with_anchors({p}, {q});"
                ));
            }
        }
        let strength = show(strength);
        self.line(&format!(
            "let def = JointDef {{ collide_connected: {collide_connected}, strength: {strength}, \
             articulated: {articulated}, enabled: {enabled}, ..def }};"
        ));
        let bind = self.bind('j', *label);
        self.line(&format!("{bind}world.add_joint(def).unwrap();"));
    }

    fn particles(&mut self, op: &Op) {
        let strand = match op {
            Op::AddParticle(label, def) => {
                let bind = self.bind('p', *label);
                self.line(&format!("{bind}world.add_particle({}).unwrap();", show(def)));
                return;
            }
            Op::AddLink(plan) => {
                let LinkPlan { label, ends: [a, b], kind, length, tear_strain, tear_force } = plan;
                let [length, strain, force] = [length, tear_strain, tear_force].map(show);
                let bind = self.bind('l', *label);
                self.line(&format!(
                    "{bind}world.add_link(LinkDef {{ length: {length}, tear_strain: {strain}, \
                     tear_force: {force}, ..LinkDef::new(p{a}, p{b}, {}) }}).unwrap();",
                    show(kind)
                ));
                return;
            }
            Op::AddRope(p, l, def) => {
                self.line(&format!("let strand = world.add_rope({}).unwrap();", show(def)));
                (*p, *l)
            }
            Op::AddCloth(p, l, def) => {
                self.line(&format!("let strand = world.add_cloth({}).unwrap();", show(def)));
                (*p, *l)
            }
            Op::AddCloud(p, points, def) => {
                let (points, def) = (show(points), show(def));
                self.line(&format!("let particles = world.add_cloud({points}, {def}).unwrap();"));
                self.line("let strand = Strand { particles, ..Strand::default() };");
                (*p, Label::MAX)
            }
            _ => return,
        };
        let (first, link) = strand;
        let named: Vec<(char, Label)> = self.used.iter().copied().collect();
        for (kind, label) in named {
            // No other object has a label between the first and the last of a strand.
            match kind {
                'p' if label >= first && label < first + 200 => {
                    self.strand(&format!("p{label}"), "particles", label - first);
                }
                'l' if label >= link && label < link + 200 => {
                    self.strand(&format!("l{label}"), "links", label - link);
                }
                _ => {}
            }
        }
    }

    fn strand(&mut self, name: &str, list: &str, number: Label) {
        self.line(&format!("let {name} = strand.{list}.get({number}).copied();"));
        self.line(&format!("let Some({name}) = {name} else {{ unreachable!() }};"));
    }

    fn query(&mut self, call: &QueryCall) {
        if let QueryCall::Pair(both, reach) = call {
            let [(a, at_a), (b, at_b)] = &**both;
            let (a, b, reach) = (form(a), form(b), show(reach));
            let (at_a, at_b) = (show(at_a), show(at_b));
            self.line(&format!(
                "let answer = ({a}).closest_points({at_a}, &{b}, {at_b}, {reach});"
            ));
            self.line("let text = format!(\"{answer:?}\");");
            self.line("assert!(!text.contains(\"NaN\") && !text.contains(\"inf\"), \"{text}\");");
            return;
        }
        let (name, args, filter) = match call {
            QueryCall::Ray(o, d, f) => ("cast_ray", format!("{}, {}", show(o), show(d)), f),
            QueryCall::OverlapBounds(bounds, f) => ("overlap_bounds", show(bounds), f),
            QueryCall::OverlapPoint(p, f) => ("overlap_point", show(p), f),
            QueryCall::OverlapShape(s, at, f) => {
                ("overlap_shape", format!("&{}, {}", form(s), show(at)), f)
            }
            QueryCall::CastShape(s, at, [way, turn], f) => {
                let motion = format!("Motion::by({}).with_turn({})", show(way), show(turn));
                ("cast_shape", format!("&{}, {}, {motion}", form(s), show(at)), f)
            }
            QueryCall::Pair(..) => return,
            QueryCall::Nearest(s, at, reach, f) => {
                ("nearest_shape", format!("&{}, {}, {}", form(s), show(at), show(reach)), f)
            }
        };
        let filter = show(filter);
        self.line(&format!("let answer = world.query().{name}({args}, {filter});"));
        self.line("let text = format!(\"{answer:?}\");");
        self.line("assert!(!text.contains(\"NaN\") && !text.contains(\"inf\"), \"{text}\");");
    }

    fn config(&mut self, name: &str, config: &WorldConfig) {
        let changed = changes(config);
        let mutable = if changed.is_empty() { "let " } else { "let mut " };
        self.line(&format!("{mutable}{name} = WorldConfig::default();"));
        for (path, value) in changed {
            self.line(&format!("{name}.set(\"{path}\", \"{value}\").unwrap();"));
        }
    }

    fn ending(&mut self) {
        match self.kind {
            Some(Kind::HashDiffers) => {
                self.line("let levels = SimdLevel::available();");
                self.line("let (best, lowest) = (levels[0], levels[levels.len() - 1]);");
                self.line("let hashes = run(1, best, usize::MAX);");
                self.line("assert_eq!(hashes, run(2, best, usize::MAX));");
                self.line("assert_eq!(hashes, run(4, lowest, usize::MAX));");
                self.line(&format!("assert_eq!(hashes, run(1, lowest, {}));", RESTORE_EVERY));
            }
            Some(Kind::SnapshotRefused) => {
                self.line("let again = World::restore(&world.snapshot()).unwrap();");
                self.line("assert_eq!(again.state_hash(), world.state_hash());");
            }
            Some(Kind::Fault | Kind::Wild) => {
                self.line("assert!(world.bodies().all(|b| !b.is_faulted()));");
                self.line(
                    "assert!(world.bodies().all(|b| b.linear_velocity().length() < 1000.0));",
                );
            }
            Some(Kind::BadNumber) => {
                self.line("for body in world.bodies() {");
                self.line("assert!(body.kinetic_energy().is_finite() && body.pose().is_finite());");
                self.line("}");
                self.line("for joint in world.joints() {");
                self.line("assert!(joint.force().is_finite() && joint.torque().is_finite());");
                self.line(
                    "assert!(joint.error().is_finite() && joint.angular_error().is_finite());",
                );
                self.line("}");
                self.line("for contact in world.contacts() {");
                self.line("assert!(contact.friction_impulse().is_finite());");
                self.line("}");
                self.line("for particle in world.particles() {");
                self.line("assert!(particle.velocity().is_finite() && particle.attachment_force().is_finite());");
                self.line("}");
                self.line("for link in world.links() {");
                self.line("assert!(link.tension().is_finite() && link.error().is_finite());");
                self.line("}");
                self.line("let audit = format!(\"{:?} {:?}\", world.audit(), world.events());");
                self.line(
                    "assert!(!audit.contains(\"NaN\") && !audit.contains(\"inf\"), \"{audit}\");",
                );
            }
            Some(Kind::Unpaired) => {}
            _ => self.line("assert!(world.bodies().all(|b| b.pose().is_finite()));"),
        }
    }
}

/// A call that makes no named object.
fn call(op: &Op) -> String {
    match op {
        Op::RemoveBody(b) => format!("world.remove_body({});", body(*b)),
        Op::RemoveShape(s) => format!("world.remove_shape(s{s});"),
        Op::RemoveJoint(j) => format!("world.remove_joint(j{j});"),
        Op::RemoveParticle(p) => format!("world.remove_particle(p{p});"),
        Op::RemoveLink(l) => format!("world.remove_link(l{l});"),
        Op::Detach(p) => format!("world.particle_mut(p{p}).unwrap().detach();"),
        Op::SetJointDrive(j, axis, drive) => {
            let drive = show(drive);
            format!(
                "world.joint_mut(j{j}).unwrap().axis(Axis::{axis:?}).unwrap().set_drive({drive}).unwrap();"
            )
        }
        Op::SetJointStrength(j, strength) => {
            let strength = show(strength);
            format!("world.joint_mut(j{j}).unwrap().set_strength({strength}).unwrap();")
        }
        Op::Joint(j, call) => joint_call(*j, call),
        Op::SetLinkLength(l, length) => {
            format!("world.link_mut(l{l}).unwrap().set_length({});", show(length))
        }
        Op::Attach(p, b, point) => {
            format!(
                "world.particle_mut(p{p}).unwrap().attach({}, {}).unwrap();",
                body(*b),
                show(point)
            )
        }
        Op::Body(b, call) => format!("world.body_mut({}).unwrap().{};", body(*b), body_call(call)),
        Op::Shape(s, call) => {
            let call = match call {
                ShapeCall::Material(m) => format!("set_material({})", show(m)),
                ShapeCall::Sensor(sensor) => format!("set_sensor({sensor})"),
                ShapeCall::Density(density) => format!("set_density({})", show(density)),
                ShapeCall::LocalPose(pose) => format!("set_local_pose({})", show(pose)),
                ShapeCall::Geometry(shape) => format!("set_geometry({})", form(shape)),
                ShapeCall::Reports(reports) => format!("set_reports({})", show(reports)),
                ShapeCall::OneWay(front) => format!("set_one_way({})", show(front)),
                // These return nothing.
                ShapeCall::SurfaceVelocity(v) => {
                    let v = show(v);
                    return format!("world.shape_mut(s{s}).unwrap().set_surface_velocity({v});");
                }
                ShapeCall::SurfaceSpin(v) => {
                    let v = show(v);
                    return format!("world.shape_mut(s{s}).unwrap().set_surface_spin({v});");
                }
                ShapeCall::Senses(senses) => {
                    return format!("world.shape_mut(s{s}).unwrap().set_senses({});", show(senses));
                }
                ShapeCall::Filter(filter) => {
                    return format!("world.shape_mut(s{s}).unwrap().set_filter({});", show(filter));
                }
                ShapeCall::Enabled(enabled) => {
                    return format!("world.shape_mut(s{s}).unwrap().set_enabled({enabled});");
                }
            };
            format!("world.shape_mut(s{s}).unwrap().{call}.unwrap();")
        }
        Op::Particle(p, call) => {
            let call = match call {
                ParticleCall::Position(x) => format!("set_position({})", show(x)),
                ParticleCall::Velocity(v) => format!("set_velocity({})", show(v)),
                ParticleCall::Impulse(v) => format!("apply_impulse({})", show(v)),
                ParticleCall::Mass(m) => format!("set_mass({}).unwrap()", show(m)),
                ParticleCall::Pinned(pinned) => format!("set_pinned({pinned})"),
            };
            format!("world.particle_mut(p{p}).unwrap().{call};")
        }
        Op::FractureBody(b, point, how) => {
            let (b, point, how) = (body(*b), show(point), show(how));
            format!("world.body_mut({b}).unwrap().break_at({point}, &{how}).unwrap();")
        }
        Op::SetFracture(b, how) => {
            format!("world.body_mut({}).unwrap().set_fracture({}).unwrap();", body(*b), show(how))
        }
        Op::SetBondStrength(b, strength) => {
            format!(
                "world.body_mut({}).unwrap().set_bond_strength({}).unwrap();",
                body(*b),
                show(strength)
            )
        }
        Op::SetGravity(g) => format!("world.set_gravity({});", show(g)),
        Op::ShiftOrigin(origin) => format!("world.shift_origin({}).unwrap();", show(origin)),
        Op::SurfaceBetween(a, b, rule) => {
            let (a, b) = (body(*a), body(*b));
            format!("world.set_surface_between({a}, {b}, {}).unwrap();", show(rule))
        }
        Op::WakeAll => "world.wake_all();".to_owned(),
        Op::BeginLedger => "world.begin_ledger();".to_owned(),
        Op::EndLedger => "let _ = world.end_ledger();".to_owned(),
        Op::Impact(bodies, surface) => {
            format!(
                "let _ = impact(&{}, &{}, &{});",
                show(&bodies[0]),
                show(&bodies[1]),
                show(surface)
            )
        }
        _ => String::new(),
    }
}
