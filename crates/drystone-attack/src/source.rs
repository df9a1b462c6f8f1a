//! A program as the source of a test: plain calls of the public API.

use std::collections::BTreeSet;
use std::fmt::{Debug, Write};

use drystone::{
    BodyDef, Filter, Fracture, JointAxis, JointKind, JointStrength, Material, ParticleDef,
    ShapeDef, SixDof, WorldConfig,
};

use crate::finding::{Finding, Kind};
use crate::op::{
    BodyCall, BodyPlan, CouplingPlan, Form, JointPlan, Label, LinkPlan, Op, PIECES, ParticleCall,
    Place, Program, QueryCall, ShapeCall, ShapePlan,
};
use crate::text::{Default, plain};

/// The source of a test that does what the program does, and asserts what the finding says does not hold.
#[must_use]
pub fn test(program: &Program, seed: u64, finding: Option<&Finding>) -> String {
    let mut source = Source { text: String::new(), used: used_labels(program) };
    let kind = finding.map_or("program", |f| f.kind.name()).replace('-', "_");
    let steps = program.steps();
    source.line(0, "// Put into crates/drystone/tests/it/regression.rs under a name that says what must hold.");
    if let Some(finding) = finding {
        source.line(0, &format!("// {}: {} (step {})", finding.kind.name(), finding.what, finding.step));
    }
    source.line(0, "#![allow(unused)]");
    source.line(0, "use std::sync::Arc;");
    source.line(0, "use drystone::*;");
    source.line(0, "");
    source.line(0, "#[test]");
    source.line(0, &format!("fn attack_{kind}_{seed}() {{"));
    source.line(1, "let run = |threads: usize, level: SimdLevel, restore_at: u32| {");
    source.config("config", &program.config);
    source.line(2, "let mut world = World::new(config).unwrap();");
    source.line(2, "let equip = |world: &mut World| {");
    source.line(3, "world.set_executor(Arc::new(Team::with_threads(threads)));");
    source.line(3, "world.set_simd_level(level);");
    source.line(2, "};");
    source.line(2, "equip(&mut world);");
    source.line(2, "let mut pieces: Vec<BodyId> = Vec::new();");
    source.line(2, "let mut hashes: Vec<u64> = Vec::new();");
    for op in &program.ops {
        source.op(op);
    }
    source.line(2, "(world, hashes)");
    source.line(1, "};");
    source.line(1, "let levels = SimdLevel::available();");
    source.line(1, "let (world, hashes) = run(1, levels[0], u32::MAX);");
    source.ending(finding, steps);
    source.line(0, "}");
    source.text
}

/// Source in the making.
struct Source {
    text: String,
    /// Labels that operations name, by what they are of.
    used: BTreeSet<(char, Label)>,
}

/// Which things later operations name: only these get a variable.
fn used_labels(program: &Program) -> BTreeSet<(char, Label)> {
    let mut used = BTreeSet::new();
    for op in &program.ops {
        let names: Vec<(char, Label)> = match op {
            Op::AddShape(b, _) | Op::RemoveBody(b) | Op::Body(b, _) | Op::FractureBody(b, ..)
            | Op::SetFracture(b, _) | Op::SetBondStrength(b, _) => vec![('b', *b)],
            Op::RemoveShape(s) | Op::Shape(s, _) => vec![('s', *s)],
            Op::AddJoint(plan) => plan.bodies.map(|b| ('b', b)).to_vec(),
            Op::AddCoupling(plan) => plan.joints.map(|j| ('j', j)).to_vec(),
            Op::RemoveJoint(j) | Op::SetJointAxes(j, _) | Op::SetJointDrive(j, ..)
            | Op::SetJointStrength(j, _) => vec![('j', *j)],
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

/// What a body is called in the source.
fn body(label: Label) -> String {
    if label >= PIECES { format!("pieces[{}]", label - PIECES) } else { format!("b{label}") }
}

impl Source {
    fn line(&mut self, depth: usize, text: &str) {
        // A string takes all there is.
        let _ = writeln!(self.text, "{}{text}", "    ".repeat(depth));
    }

    fn op(&mut self, op: &Op) {
        match op {
            Op::AddBody(plan) => self.add_body(plan),
            Op::AddShape(b, plan) => {
                let shape = shape_def(plan);
                let text = format!("let s{} = world.add_shape({}, {shape}).unwrap();", plan.label, body(*b));
                self.line(2, &text);
            }
            Op::AddJoint(plan) => self.add_joint(plan),
            Op::AddCoupling(plan) => {
                let CouplingPlan { label, joints: [a, b], axes: [p, q], ratio, offset } = plan;
                let (ratio, offset) = (show(ratio), show(offset));
                self.line(2, &format!(
                    "let j{label} = world.add_coupling(CouplingDef {{ joint_a: j{a}, axis_a: {p}, joint_b: j{b}, \
                     axis_b: {q}, ratio: {ratio}, offset: {offset} }}).unwrap();"
                ));
            }
            Op::SetJointAxes(j, axes) => {
                self.line(2, &format!(
                    "let JointKind::SixDof(now) = world.joint(j{j}).unwrap().kind() else {{ unreachable!() }};"
                ));
                self.line(2, &format!(
                    "world.set_joint_axes(j{j}, SixDof {{ frame_a: now.frame_a, frame_b: now.frame_b, ..{} }}).unwrap();",
                    show(axes)
                ));
            }
            Op::AddParticle(..) | Op::AddRope(..) | Op::AddCloth(..) | Op::AddCloud(..)
            | Op::AddLink(_) => self.particles(op),
            Op::SetConfig(config) => {
                self.config("config", config);
                self.line(2, "world.set_config(config).unwrap();");
            }
            Op::Query(call) => self.query(call),
            Op::Step(dt, count) => {
                let dt = seconds(*dt);
                self.line(2, &format!("for _ in 0..{count} {{"));
                self.line(3, "if world.step_count() == u64::from(restore_at) {");
                self.line(4, "world = World::restore(&world.snapshot()).unwrap();");
                self.line(4, "equip(&mut world);");
                self.line(3, "}");
                self.line(3, &format!("world.step({dt});"));
                self.line(3, "pieces.extend(world.events().pieces.iter().copied());");
                self.line(3, "hashes.push(world.state_hash());");
                self.line(2, "}");
            }
            _ => {
                let text = call(op);
                self.line(2, &text);
            }
        }
    }

    fn add_body(&mut self, plan: &BodyPlan) {
        let b = plan.label;
        let mut def = plain(&format!("{:?}", BodyDef { shapes: Vec::new(), ..plan.def.clone() }), DEFAULTS);
        for shape in &plan.shapes {
            let _ = write!(def, "\n            .with_shape({})", shape_def(shape));
        }
        self.line(2, &format!("let def = {def};"));
        if let Some((gap, strength)) = &plan.glue {
            let (gap, strength) = (show(gap), show(strength));
            self.line(2, &format!("let glue = Glue::touching(&def.shapes, {gap}, {strength}).unwrap();"));
            self.line(2, "let def = def.with_glue(glue);");
        }
        self.line(2, &format!("let b{b} = world.add_body(def).unwrap();"));
        for (i, shape) in plan.shapes.iter().enumerate() {
            if self.used.contains(&('s', shape.label)) {
                let s = shape.label;
                self.line(2, &format!("let s{s} = world.body(b{b}).unwrap().shapes().nth({i}).unwrap();"));
            }
        }
    }

    fn add_joint(&mut self, plan: &JointPlan) {
        let JointPlan { label, bodies, place, kind, collide_connected, strength, articulated } = plan;
        let [a, b] = bodies.map(body);
        match (place, kind) {
            (Place::Along(anchor, axis), JointKind::SixDof(axes)) => {
                let (anchor, axis, axes) = (show(anchor), show(axis), show(axes));
                self.line(2, &format!("let def = world.joint_along({a}, {b}, {anchor}, {axis}, {axes}).unwrap();"));
            }
            (Place::Along(p, q) | Place::Anchors(p, q), kind) => {
                let (p, q, kind) = (show(p), show(q), show(kind));
                self.line(2, &format!(
                    "let def = JointDef {{ kind: {kind}, ..JointDef::ball({a}, {p}, {b}, {q}) }};"
                ));
            }
        }
        let strength = show(strength);
        self.line(2, &format!(
            "let def = JointDef {{ collide_connected: {collide_connected}, strength: {strength}, \
             articulated: {articulated}, ..def }};"
        ));
        self.line(2, &format!("let j{label} = world.add_joint(def).unwrap();"));
    }

    fn particles(&mut self, op: &Op) {
        let strand = match op {
            Op::AddParticle(label, def) => {
                self.line(2, &format!("let p{label} = world.add_particle(&{}).unwrap();", show(def)));
                return;
            }
            Op::AddLink(plan) => {
                let LinkPlan { label, ends: [a, b], kind, length, tear_strain, tear_force } = plan;
                let [length, strain, force] = [length, tear_strain, tear_force].map(|x| show(x));
                self.line(2, &format!(
                    "let l{label} = world.add_link(LinkDef {{ length: {length}, tear_strain: {strain}, \
                     tear_force: {force}, ..LinkDef::new(p{a}, p{b}, {}) }}).unwrap();",
                    show(kind)
                ));
                return;
            }
            Op::AddRope(p, l, def) => {
                self.line(2, &format!("let strand = world.add_rope(&{}).unwrap();", show(def)));
                (*p, *l)
            }
            Op::AddCloth(p, l, def) => {
                self.line(2, &format!("let strand = world.add_cloth(&{}).unwrap();", show(def)));
                (*p, *l)
            }
            Op::AddCloud(p, points, def) => {
                let (points, def) = (show(points), show(def));
                self.line(2, &format!("let particles = world.add_cloud({points}, &{def}).unwrap();"));
                self.line(2, "let strand = Strand { particles, ..Strand::default() };");
                (*p, Label::MAX)
            }
            _ => return,
        };
        let (first, link) = strand;
        let named: Vec<(char, Label)> = self.used.iter().copied().collect();
        for (kind, label) in named {
            // Nothing else has a label between the first one of a strand and its last.
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
        self.line(2, &format!("let {name} = strand.{list}.get({number}).copied();"));
        self.line(2, &format!("let Some({name}) = {name} else {{ unreachable!() }};"));
    }

    fn query(&mut self, call: &QueryCall) {
        let (name, args, filter) = match call {
            QueryCall::Ray(o, d, f) => ("cast_ray", format!("{}, {}", show(o), show(d)), f),
            QueryCall::OverlapBox(bounds, f) => ("overlap_box", show(bounds), f),
            QueryCall::OverlapPoint(p, f) => ("overlap_point", show(p), f),
            QueryCall::OverlapShape(s, at, f) => {
                ("overlap_shape", format!("&{}, {}", form(s), show(at)), f)
            }
            QueryCall::CastShape(s, at, d, f) => {
                ("cast_shape", format!("&{}, {}, {}", form(s), show(at), show(d)), f)
            }
            QueryCall::Nearest(s, at, reach, f) => {
                ("nearest_shape", format!("&{}, {}, {}", form(s), show(at), show(reach)), f)
            }
        };
        let filter = show(filter);
        self.line(2, &format!("let answer = world.query().{name}({args}, {filter});"));
        self.line(2, "let text = format!(\"{answer:?}\");");
        self.line(2, "assert!(!text.contains(\"NaN\") && !text.contains(\"inf\"), \"{text}\");");
    }

    fn config(&mut self, name: &str, config: &WorldConfig) {
        self.line(2, &format!("let mut {name} = WorldConfig::default();"));
        for (path, value) in changes(config) {
            self.line(2, &format!("{name}.set(\"{path}\", \"{value}\").unwrap();"));
        }
    }

    fn ending(&mut self, finding: Option<&Finding>, steps: u32) {
        match finding.map(|f| f.kind) {
            Some(Kind::HashDiffers) => {
                self.line(1, "let lowest = *levels.last().unwrap();");
                self.line(1, "assert_eq!(hashes, run(2, levels[0], u32::MAX).1);");
                self.line(1, "assert_eq!(hashes, run(4, lowest, u32::MAX).1);");
                self.line(1, &format!("assert_eq!(hashes, run(1, lowest, {}).1);", steps / 2));
            }
            Some(Kind::SnapshotRefused) => {
                self.line(1, "let again = World::restore(&world.snapshot()).unwrap();");
                self.line(1, "assert_eq!(again.state_hash(), world.state_hash());");
            }
            Some(Kind::Fault | Kind::Wild) => {
                self.line(1, "assert!(world.bodies().all(|b| !b.is_faulted()));");
                self.line(1, "assert!(world.bodies().all(|b| b.linear_velocity().length() < 1000.0));");
            }
            Some(Kind::BadNumber) => {
                self.line(1, "for body in world.bodies() {");
                self.line(2, "assert!(body.kinetic_energy().is_finite() && body.pose().is_finite());");
                self.line(1, "}");
                self.line(1, "for joint in world.joints() {");
                self.line(2, "assert!(joint.force().is_finite() && joint.torque().is_finite());");
                self.line(2, "assert!(joint.error().is_finite() && joint.angular_error().is_finite());");
                self.line(1, "}");
                self.line(1, "for contact in world.contacts() {");
                self.line(2, "assert!(contact.friction_impulse().is_finite());");
                self.line(1, "}");
                self.line(1, "for particle in world.particles() {");
                self.line(2, "assert!(particle.velocity().is_finite() && particle.attachment_force().is_finite());");
                self.line(1, "}");
                self.line(1, "for link in world.links() {");
                self.line(2, "assert!(link.tension().is_finite() && link.error().is_finite());");
                self.line(1, "}");
                self.line(1, "let audit = format!(\"{:?} {:?}\", world.audit(), world.events());");
                self.line(1, "assert!(!audit.contains(\"NaN\") && !audit.contains(\"inf\"), \"{audit}\");");
            }
            _ => self.line(1, "assert!(world.bodies().all(|b| b.pose().is_finite()));"),
        }
    }
}

/// A call that makes nothing that has a name.
fn call(op: &Op) -> String {
    match op {
        Op::RemoveBody(b) => format!("world.remove_body({});", body(*b)),
        Op::RemoveShape(s) => format!("world.remove_shape(s{s});"),
        Op::RemoveJoint(j) => format!("world.remove_joint(j{j});"),
        Op::RemoveParticle(p) => format!("world.remove_particle(p{p});"),
        Op::RemoveLink(l) => format!("world.remove_link(l{l});"),
        Op::Detach(p) => format!("world.detach_particle(p{p});"),
        Op::SetJointDrive(j, axis, drive) => {
            format!("world.set_joint_drive(j{j}, {axis}, {}).unwrap();", show(drive))
        }
        Op::SetJointStrength(j, strength) => {
            format!("world.set_joint_strength(j{j}, {}).unwrap();", show(strength))
        }
        Op::SetLinkLength(l, length) => {
            format!("world.set_link_length(l{l}, {}).unwrap();", show(length))
        }
        Op::Attach(p, b, point) => {
            format!("world.attach_particle(p{p}, {}, {}).unwrap();", body(*b), show(point))
        }
        Op::Body(b, call) => format!("world.body_mut({}).unwrap().{};", body(*b), body_call(call)),
        Op::Shape(s, call) => {
            let call = match call {
                ShapeCall::Material(m) => format!("set_material({})", show(m)),
                ShapeCall::SurfaceVelocity(v) => format!("set_surface_velocity({})", show(v)),
                ShapeCall::SurfaceSpin(v) => format!("set_surface_spin({})", show(v)),
            };
            format!("world.shape_mut(s{s}).unwrap().{call}.unwrap();")
        }
        Op::Particle(p, call) => {
            let call = match call {
                ParticleCall::Position(x) => format!("set_position({}).unwrap()", show(x)),
                ParticleCall::Velocity(v) => format!("set_velocity({}).unwrap()", show(v)),
                ParticleCall::Impulse(v) => format!("apply_impulse({}).unwrap()", show(v)),
                ParticleCall::Mass(m) => format!("set_mass({}).unwrap()", show(m)),
                ParticleCall::Pinned(pinned) => format!("set_pinned({pinned})"),
            };
            format!("world.particle_mut(p{p}).unwrap().{call};")
        }
        Op::FractureBody(b, point, how) => {
            format!("world.fracture_body({}, {}, &{}).unwrap();", body(*b), show(point), show(how))
        }
        Op::SetFracture(b, how) => format!("world.set_fracture({}, {}).unwrap();", body(*b), show(how)),
        Op::SetBondStrength(b, strength) => {
            format!("world.set_bond_strength({}, {}).unwrap();", body(*b), show(strength))
        }
        Op::SetGravity(g) => format!("world.set_gravity({}).unwrap();", show(g)),
        Op::WakeAll => "world.wake_all();".to_owned(),
        Op::BeginLedger => "world.begin_ledger();".to_owned(),
        Op::EndLedger => "let _ = world.end_ledger();".to_owned(),
        Op::Impact(bodies, surface) => {
            format!("let _ = impact(&{}, &{}, &{});", show(&bodies[0]), show(&bodies[1]), show(surface))
        }
        _ => String::new(),
    }
}

fn body_call(call: &BodyCall) -> String {
    let one = |name: &str, x: &dyn Debug| format!("{name}({}).unwrap()", show(&x));
    let two = |name: &str, x: &dyn Debug, y: &dyn Debug| {
        format!("{name}({}, {}).unwrap()", show(&x), show(&y))
    };
    match call {
        BodyCall::Wake => "wake()".to_owned(),
        BodyCall::Pose(pose) => one("set_pose", pose),
        BodyCall::LinearVelocity(v) => one("set_linear_velocity", v),
        BodyCall::AngularVelocity(v) => one("set_angular_velocity", v),
        BodyCall::MoveTo(pose, dt) => two("move_to", pose, dt),
        BodyCall::Impulse(v) => one("apply_impulse", v),
        BodyCall::ImpulseAt(v, at) => two("apply_impulse_at", v, at),
        BodyCall::AngularImpulse(v) => one("apply_angular_impulse", v),
        BodyCall::StepForce(v) => one("add_step_force", v),
        BodyCall::StepForceAt(v, at) => two("add_step_force_at", v, at),
        BodyCall::StepTorque(v) => one("add_step_torque", v),
        BodyCall::LastingForce(v) => one("set_lasting_force", v),
        BodyCall::LastingTorque(v) => one("set_lasting_torque", v),
        BodyCall::GravityScale(x) => one("set_gravity_scale", x),
        BodyCall::Damping(x, y) => two("set_damping", x, y),
        BodyCall::Locks(locks) => format!("set_locks({})", show(locks)),
        BodyCall::CanSleep(can) => format!("set_can_sleep({can})"),
        BodyCall::UserData(data) => format!("set_user_data({data})"),
    }
}

fn seconds(dt: f32) -> String {
    for hertz in [30.0_f32, 50.0, 60.0, 90.0, 120.0, 144.0, 240.0] {
        if dt.to_bits() == (1.0 / hertz).to_bits() {
            return format!("1.0 / {hertz:?}");
        }
    }
    show(&dt)
}

fn form(form: &Form) -> String {
    match form {
        Form::Plain(shape) => show(shape),
        Form::Hull(points) => {
            format!("Shape::Hull(Arc::new(Hull::from_points(&{}).unwrap()))", show(points))
        }
        Form::Mesh(points, triangles) => format!(
            "Shape::Mesh(Arc::new(Mesh::new(vec!{}, vec!{triangles:?}).unwrap()))",
            show(points)
        ),
    }
}

/// A shape whose fields are those of [`ShapeDef::new`] but for some.
fn shape_def(plan: &ShapePlan) -> String {
    let (def, usual) = (&plan.def, ShapeDef::sphere(1.0));
    let fields: [(&str, String, String); 8] = [
        ("pose", show(&def.pose), show(&usual.pose)),
        ("density", show(&def.density), show(&usual.density)),
        ("material", show(&def.material), show(&usual.material)),
        ("filter", show(&def.filter), show(&usual.filter)),
        ("sensor", show(&def.sensor), show(&usual.sensor)),
        ("surface_velocity", show(&def.surface_velocity), show(&usual.surface_velocity)),
        ("surface_spin", show(&def.surface_spin), show(&usual.surface_spin)),
        ("user_data", show(&def.user_data), show(&usual.user_data)),
    ];
    let changed = fields.iter().filter(|(_, own, usual)| own != usual);
    let changed: String = changed.map(|(name, own, _)| format!("{name}: {own}, ")).collect();
    let made = format!("ShapeDef::new({})", form(&plan.form));
    if changed.is_empty() { made } else { format!("ShapeDef {{ {changed}..{made} }}") }
}

/// A value as source, by what `Debug` writes of it.
fn show<T: Debug + ?Sized>(value: &T) -> String {
    plain(&format!("{value:?}"), DEFAULTS)
}

/// What fields that are not written are taken from.
const DEFAULTS: &[Default] = &[
    ("BodyDef", "BodyDef::default()", || format!("{:?}", BodyDef::default())),
    ("ParticleDef", "ParticleDef::default()", || format!("{:?}", ParticleDef::default())),
    ("Material", "Material::default()", || format!("{:?}", Material::default())),
    ("Filter", "Filter::default()", || format!("{:?}", Filter::default())),
    ("Fracture", "Fracture::default()", || format!("{:?}", Fracture::default())),
    ("JointStrength", "JointStrength::default()", || format!("{:?}", JointStrength::default())),
    ("JointAxis", "JointAxis::FREE", || format!("{:?}", JointAxis::FREE)),
    ("SixDof", "SixDof::FIXED", || format!("{:?}", SixDof::FIXED)),
];

/// Paths and values of what is not as it is by default.
fn changes(config: &WorldConfig) -> Vec<(&'static str, String)> {
    let (own, usual) = (values(config), values(&WorldConfig::default()));
    let name = config.method.name();
    let mut changed = Vec::new();
    if name != WorldConfig::default().method.name() {
        changed.push(("method", name.to_owned()));
    }
    for (own, usual) in own.into_iter().zip(usual) {
        if own != usual {
            changed.push(own);
        }
    }
    changed
}

fn values(c: &WorldConfig) -> Vec<(&'static str, String)> {
    let g = c.gravity;
    let options = c.method.options();
    vec![
        ("gravity", format!("{:?},{:?},{:?}", g.x, g.y, g.z)),
        ("method.order", options.order.word().to_owned()),
        ("method.shock", options.shock.word().to_owned()),
        ("method.persistence", options.persistence.word().to_owned()),
        ("method.overlap", options.overlap.word().to_owned()),
        ("method.rest", options.rest.word().to_owned()),
        ("method.integration", options.integration.word().to_owned()),
        ("method.damping", options.damping.word().to_owned()),
        ("method.sweeps", options.sweeps.to_string()),
        ("substeps", c.substeps.to_string()),
        ("contact.hertz", c.contact.hertz.to_string()),
        ("contact.damping_ratio", c.contact.damping_ratio.to_string()),
        ("contact.push_speed", c.contact.push_speed.to_string()),
        ("contact.rest_offset", c.contact.rest_offset.to_string()),
        ("contact.margin", c.contact.margin.to_string()),
        ("contact.recycle_distance", c.contact.recycle_distance.to_string()),
        ("contact.restitution_speed", c.contact.restitution_speed.to_string()),
        ("contact.hit_speed", c.contact.hit_speed.to_string()),
        ("inertia.most", c.inertia.most.to_string()),
        ("inertia.threshold", c.inertia.threshold.to_string()),
        ("inertia.refine", c.inertia.refine.to_string()),
        ("joint.hertz", c.joint.hertz.to_string()),
        ("joint.damping_ratio", c.joint.damping_ratio.to_string()),
        ("joint.tree_ratio", c.joint.tree_ratio.to_string()),
        ("joint.refine", c.joint.refine.to_string()),
        ("particle.form", c.particle.form.word().to_owned()),
        ("particle.sweeps", c.particle.sweeps.to_string()),
        ("particle.hertz", c.particle.hertz.to_string()),
        ("particle.damping_ratio", c.particle.damping_ratio.to_string()),
        ("penalty.hertz", c.penalty.hertz.to_string()),
        ("penalty.damping_ratio", c.penalty.damping_ratio.to_string()),
        ("sleep.enabled", c.sleep.enabled.to_string()),
        ("sleep.speed", c.sleep.speed.to_string()),
        ("sleep.time", c.sleep.time.to_string()),
        ("breakage.max_pieces", c.breakage.max_pieces.to_string()),
    ]
}
