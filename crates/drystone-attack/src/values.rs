//! Values of definitions and configurations as source.

use std::fmt::Debug;

use drystone::breakage::{Fracture, JointStrength};
use drystone::events::ContactReports;
use drystone::joint::{JointAxis, SixDof};
use drystone::particle::ParticleDef;
use drystone::{BodyDef, Filter, Material, ShapeDef, WorldConfig};

use crate::op::{Form, ShapePlan};
use crate::text::{Default, plain};

pub(crate) fn seconds(dt: f32) -> String {
    for hertz in [30.0_f32, 50.0, 60.0, 90.0, 120.0, 144.0, 240.0] {
        if dt.to_bits() == (1.0 / hertz).to_bits() {
            return format!("1.0 / {hertz:?}");
        }
    }
    show(&dt)
}

pub(crate) fn form(form: &Form) -> String {
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

/// A shape whose fields are those of [`ShapeDef::new`], with some exceptions.
pub(crate) fn shape_def(plan: &ShapePlan) -> String {
    let (def, usual) = (&plan.def, ShapeDef::sphere(1.0));
    let fields: [(&str, String, String); 13] = [
        ("pose", show(&def.pose), show(&usual.pose)),
        ("density", show(&def.density), show(&usual.density)),
        ("material", show(&def.material), show(&usual.material)),
        ("filter", show(&def.filter), show(&usual.filter)),
        ("sensor", show(&def.sensor), show(&usual.sensor)),
        ("reports", show(&def.reports), show(&usual.reports)),
        ("senses", show(&def.senses), show(&usual.senses)),
        ("enabled", show(&def.enabled), show(&usual.enabled)),
        ("hooks", show(&def.hooks), show(&usual.hooks)),
        ("one_way", show(&def.one_way), show(&usual.one_way)),
        ("surface_velocity", show(&def.surface_velocity), show(&usual.surface_velocity)),
        ("surface_spin", show(&def.surface_spin), show(&usual.surface_spin)),
        ("user_data", show(&def.user_data), show(&usual.user_data)),
    ];
    let changed = fields.iter().filter(|(_, own, usual)| own != usual);
    let changed: String = changed.map(|(name, own, _)| format!("{name}: {own}, ")).collect();
    let made = format!("ShapeDef::new({})", form(&plan.form));
    if changed.is_empty() { made } else { format!("ShapeDef {{ {changed}..{made} }}") }
}

/// A value as source, converted from its `Debug` text.
pub(crate) fn show<T: Debug + ?Sized>(value: &T) -> String {
    plain(&format!("{value:?}"), DEFAULTS)
}

/// Sources of fields that are not written.
pub(crate) const DEFAULTS: &[Default] = &[
    ("BodyDef", "BodyDef::default()", || format!("{:?}", BodyDef::default())),
    ("ParticleDef", "ParticleDef::default()", || format!("{:?}", ParticleDef::default())),
    ("Material", "Material::default()", || format!("{:?}", Material::default())),
    ("ContactReports", "ContactReports::default()", || format!("{:?}", ContactReports::default())),
    ("Filter", "Filter::default()", || format!("{:?}", Filter::default())),
    ("Fracture", "Fracture::default()", || format!("{:?}", Fracture::default())),
    ("JointStrength", "JointStrength::default()", || format!("{:?}", JointStrength::default())),
    ("JointAxis", "JointAxis::FREE", || format!("{:?}", JointAxis::FREE)),
    ("SixDof", "SixDof::FIXED", || format!("{:?}", SixDof::FIXED)),
];

/// Paths and values of the fields that differ from their defaults.
pub(crate) fn changes(config: &WorldConfig) -> Vec<(&'static str, String)> {
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
        ("inertia.max_factor", c.inertia.max_factor.to_string()),
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
