//! Properties that must hold for any world after any operations.

use std::collections::BTreeSet;

use drystone::events::Events;
use drystone::math::Sym3;
use drystone::particle::{LinkId, ParticleId};
use drystone::{BodyId, BodyRef, JointId, JointRef, Quat, Shape, ShapeId, Vec3, World};

use crate::finding::{Findings, Kind};

/// Checks numbers that a user can get.
#[derive(Debug)]
struct Numbers<'a> {
    findings: &'a mut Findings,
    step: u32,
    /// Owner of the numbers, appended to their names.
    whose: &'static str,
}

impl Numbers<'_> {
    fn one(&mut self, name: &str, x: f32) {
        self.double(name, f64::from(x));
    }

    fn double(&mut self, name: &str, x: f64) {
        if !x.is_finite() {
            self.findings.add(
                Kind::BadNumber,
                format!("{name}{}", self.whose),
                x.to_string(),
                self.step,
            );
        }
    }

    fn vector(&mut self, name: &str, v: Vec3) {
        if !v.is_finite() {
            let what = format!("{name}{}", self.whose);
            self.findings.add(Kind::BadNumber, what, format!("{v:?}"), self.step);
        }
    }

    fn rotation(&mut self, name: &str, q: Quat) {
        if !q.is_finite() {
            let what = format!("{name}{}", self.whose);
            self.findings.add(Kind::BadNumber, what, format!("{q:?}"), self.step);
        }
    }

    fn symmetric(&mut self, name: &str, m: Sym3) {
        if !m.is_finite() {
            let what = format!("{name}{}", self.whose);
            self.findings.add(Kind::BadNumber, what, format!("{m:?}"), self.step);
        }
    }

    /// Checks all numbers of a value by the names of its fields, as `Debug` prints them.
    fn fields(&mut self, of: &str, text: &str) {
        if let Some(path) = bad_field(text) {
            let what = format!("{of}.{path}{}", self.whose);
            let detail: String = text.chars().take(600).collect();
            self.findings.add(Kind::BadNumber, what, detail, self.step);
        }
    }
}

/// The path of the first field in a `Debug` text that is infinite or NaN.
fn bad_field(text: &str) -> Option<String> {
    let mut path: Vec<&str> = Vec::new();
    let mut field = "";
    let words = text.split_inclusive(['{', '}', ':', ',', ' ', '[', ']', '(', ')']);
    for word in words {
        let (name, end) = word.split_at(word.len() - word.chars().last().map_or(0, char::len_utf8));
        match end {
            ":" if !name.is_empty() => field = name,
            "{" => path.push(field),
            "}" => {
                path.pop();
            }
            _ => {}
        }
        if matches!(name, "NaN" | "inf" | "-inf") || matches!(word, "NaN" | "inf" | "-inf") {
            path.retain(|name| !name.is_empty());
            path.push(field);
            return Some(path.join("."));
        }
    }
    None
}

/// Cheap checks after each step.
pub fn quick(world: &World, findings: &mut Findings, step: u32) {
    for body in world.bodies() {
        let whose = if body.is_faulted() { " of a faulted body" } else { "" };
        let mut n = Numbers { findings, step, whose };
        n.vector("BodyRef::position", body.position());
        n.vector("BodyRef::linear_velocity", body.linear_velocity());
        n.vector("BodyRef::angular_velocity", body.angular_velocity());
        n.rotation("BodyRef::rotation", body.rotation());
    }
    let mut n = Numbers { findings, step, whose: "" };
    for particle in world.particles() {
        n.vector("ParticleRef::position", particle.position());
        n.vector("ParticleRef::velocity", particle.velocity());
    }
}

/// The speed of the fastest body [m/s].
#[must_use]
pub fn fastest(world: &World) -> f32 {
    world.bodies().map(|b| b.linear_velocity().length()).fold(0.0, f32::max)
}

/// Checks every number that a user can get.
pub fn full(world: &World, findings: &mut Findings, step: u32) {
    quick(world, findings, step);
    for body in world.bodies() {
        body_numbers(world, &body, findings, step);
    }
    for joint in world.joints() {
        joint_numbers(&joint, findings, step);
    }
    let mut n = Numbers { findings, step, whose: "" };
    for contact in world.contacts() {
        n.vector("ContactRef::normal", contact.normal());
        n.vector("ContactRef::friction_impulse", contact.friction_impulse());
        for point in contact.points() {
            n.vector("ContactPoint::position", point.position);
            n.one("ContactPoint::separation", point.separation);
            n.one("ContactPoint::impulse", point.impulse);
        }
    }
    for particle in world.particles() {
        n.one("ParticleRef::mass", particle.mass());
        n.one("ParticleRef::kinetic_energy", particle.kinetic_energy());
        n.vector("ParticleRef::attachment_force", particle.attachment_force());
    }
    for link in world.links() {
        n.one("LinkRef::length", link.length());
        n.one("LinkRef::distance", link.distance());
        n.one("LinkRef::error", link.error());
        n.one("LinkRef::tension", link.tension());
        n.double("LinkRef::elastic_energy", link.elastic_energy());
    }
    n.double("World::kinetic_energy", world.kinetic_energy());
    n.double("World::potential_energy", world.potential_energy());
    n.vector("World::momentum", world.momentum());
    n.one("World::particle_penetration", world.particle_penetration());
    n.double("World::contact_residual", world.contact_residual());
    let limit = world.penalty_limit();
    n.one("PenaltyLimit::hertz", limit.hertz);
    n.one("PenaltyLimit::longest_substep", limit.longest_substep);
    let mut audit = world.audit();
    if let Some(cone) = audit.cone.as_mut().filter(|cone| cone.ratio.is_infinite()) {
        // Infinity is documented here: friction without normal impulse.
        cone.ratio = 1.0;
    }
    n.fields("Audit", &format!("{audit:?}"));
    n.fields("WorstConstraint", &format!("{:?}", world.worst_constraint()));
    n.fields("Events", &format!("{:?}", world.events()));
    let _ = (world.counts(), world.warnings(1.0 / 60.0), world.stage_hashes());
}

fn body_numbers(world: &World, body: &BodyRef<'_>, findings: &mut Findings, step: u32) {
    let whose = if body.is_faulted() { " of a faulted body" } else { "" };
    let mut n = Numbers { findings, step, whose };
    n.vector("BodyRef::center_of_mass", body.center_of_mass());
    n.vector("BodyRef::velocity_at", body.velocity_at(body.position()));
    n.one("BodyRef::mass", body.mass());
    n.fields("MassDef", &format!("{:?}", body.mass_def()));
    n.symmetric("BodyRef::inertia", body.inertia());
    n.one("BodyRef::kinetic_energy", body.kinetic_energy());
    n.one("BodyRef::potential_energy", body.potential_energy());
    for bond in body.bonds() {
        n.vector("BondRef::point", bond.point);
        n.one("BondRef::area", bond.area);
        n.one("BondRef::load", bond.load);
    }
    if let Some(why) = world.why_awake(body.id()) {
        n.fields("WhyAwake", &format!("{:?}", why.cause));
    }
    for shape in body.shapes().filter_map(|id| world.shape(id)) {
        n.vector("ShapeRef::pose", shape.pose().position);
        if !matches!(shape.shape(), Shape::HalfSpace { .. }) {
            let bounds = shape.bounds();
            n.vector("ShapeRef::bounds", bounds.min);
            n.vector("ShapeRef::bounds", bounds.max);
        }
        n.one("ShapeRef::density", shape.density());
    }
}

fn joint_numbers(joint: &JointRef<'_>, findings: &mut Findings, step: u32) {
    let whose = match joint.kind() {
        drystone::JointKind::Ball => " of a ball joint",
        drystone::JointKind::Distance { .. } => " of a distance",
        drystone::JointKind::SixDof(_) => " of six axes",
        drystone::JointKind::Pulley(_) => " of a pulley",
        _ => " of a coupling",
    };
    let mut n = Numbers { findings, step, whose };
    n.vector("JointRef::anchor_a", joint.anchor_a());
    n.vector("JointRef::anchor_b", joint.anchor_b());
    for anchor in joint.local_anchors() {
        n.vector("JointRef::local_anchors", anchor);
    }
    n.vector("JointRef::force", joint.force());
    n.vector("JointRef::torque", joint.torque());
    n.one("JointRef::error", joint.error());
    n.one("JointRef::angular_error", joint.angular_error());
    n.one("JointRef::damage", joint.damage());
    n.one("JointRef::tension", joint.tension().unwrap_or(0.0));
    n.one("JointRef::coupling_force", joint.coupling_force().unwrap_or(0.0));
    for v in joint.coordinates().unwrap_or_default() {
        n.vector("JointRef::coordinates", v);
    }
}

/// Pairs of touching shapes, according to the events.
#[derive(Clone, Debug, Default)]
pub struct Pairs {
    touching: BTreeSet<(ShapeId, ShapeId)>,
    inside: BTreeSet<(ShapeId, ShapeId)>,
}

impl Pairs {
    /// Applies the events of a step.
    pub fn follow(&mut self, world: &World, findings: &mut Findings, step: u32) {
        let events: &Events = world.events();
        let pair = |a: ShapeId, b: ShapeId| (a.min(b), a.max(b));
        let ends = events.contact_end.iter().map(|e| pair(e.shape_a, e.shape_b));
        let begins = events.contact_begin.iter().map(|e| pair(e.shape_a, e.shape_b));
        change(&mut self.touching, ends, begins, "contact", findings, step);
        let exits = events.sensor_exit.iter().map(|e| (e.sensor, e.visitor));
        let enters = events.sensor_enter.iter().map(|e| (e.sensor, e.visitor));
        change(&mut self.inside, exits, enters, "sensor", findings, step);
        let gone =
            |(a, b): &&(ShapeId, ShapeId)| world.shape(*a).is_none() || world.shape(*b).is_none();
        for (name, set) in [("contact", &self.touching), ("sensor", &self.inside)] {
            // A body that broke in this step reports its contacts in the next step.
            let broke = !events.fractures.is_empty();
            if let Some(pair) = set.iter().find(gone).filter(|_| !broke) {
                let what = format!("{name} of a shape that is gone did not end");
                findings.add(Kind::Unpaired, what, format!("{pair:?}"), step);
            }
        }
    }
}

/// Applies ends and begins. A pair that ended may begin again in the same step, and the reverse.
fn change(
    set: &mut BTreeSet<(ShapeId, ShapeId)>,
    ends: impl Iterator<Item = (ShapeId, ShapeId)>,
    begins: impl Iterator<Item = (ShapeId, ShapeId)>,
    name: &str,
    findings: &mut Findings,
    step: u32,
) {
    let mut late = Vec::new();
    for pair in ends {
        if !set.remove(&pair) {
            late.push(pair);
        }
    }
    for pair in begins {
        if !set.insert(pair) {
            let what = format!("{name} began twice");
            findings.add(Kind::Unpaired, what, format!("{pair:?}"), step);
        }
    }
    for pair in late {
        if !set.remove(&pair) {
            let what = format!("{name} ended without having begun");
            findings.add(Kind::Unpaired, what, format!("{pair:?}"), step);
        }
    }
}

/// Ids of removed objects.
#[derive(Clone, Debug, Default)]
pub struct Gone {
    /// Bodies.
    pub bodies: Vec<BodyId>,
    /// Shapes.
    pub shapes: Vec<ShapeId>,
    /// Joints.
    pub joints: Vec<JointId>,
    /// Particles.
    pub particles: Vec<ParticleId>,
    /// Links.
    pub links: Vec<LinkId>,
}

impl Gone {
    /// Checks that none of them names an object.
    pub fn check(&self, world: &World, findings: &mut Findings, step: u32) {
        let mut stale = |what: &str, found: bool| {
            if found {
                findings.add(Kind::Stale, format!("a {what} that is gone is found"), "", step);
            }
        };
        stale("body", self.bodies.iter().any(|id| world.body(*id).is_some()));
        stale("shape", self.shapes.iter().any(|id| world.shape(*id).is_some()));
        stale("joint", self.joints.iter().any(|id| world.joint(*id).is_some()));
        stale("particle", self.particles.iter().any(|id| world.particle(*id).is_some()));
        stale("link", self.links.iter().any(|id| world.link(*id).is_some()));
    }
}

/// Checks that a world accepts its own snapshot and stays the same.
pub fn own_snapshot(world: &World, findings: &mut Findings, step: u32) {
    let bytes = world.snapshot();
    match World::restore(&bytes) {
        Err(why) => findings.add(Kind::SnapshotRefused, why.to_string(), "", step),
        Ok(again) if again.state_hash() != world.state_hash() => {
            findings.add(Kind::SnapshotRefused, "restored to another state", "", step);
        }
        Ok(again) if again.snapshot() != bytes => {
            findings.add(
                Kind::SnapshotRefused,
                "the snapshot of what was restored differs",
                "",
                step,
            );
        }
        Ok(_) => {}
    }
}

#[cfg(test)]
mod tests {
    use super::bad_field;

    #[test]
    fn the_path_of_a_bad_number_is_found() {
        let text = "Audit { step: 3, energy: Energy { linear: 1.0, angular: NaN }, p: None }";
        assert_eq!(bad_field(text).as_deref(), Some("energy.angular"));
        let text = "Audit { at: Some(Vec3 { x: -inf, y: 0.0 }) }";
        assert_eq!(bad_field(text).as_deref(), Some("at.x"));
        assert_eq!(bad_field("A { information: 1.0, b: [1e9, inferior] }"), None);
    }
}
