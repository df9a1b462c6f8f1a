//! Features of a scene that glTF with physics cannot express.

use std::collections::BTreeMap;

use drystone::contact::Combine;
use drystone::events::{ContactReports, Senses};
use drystone::{AxisLocks, BodyDef, Material, ShapeDef, Vec3, WorldConfig};

use super::joints;
use crate::scene::{Scene, SceneJoint, Script};

/// A kind of thing that a format cannot say.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Unsaid {
    /// The thing, in words.
    pub what: String,
    /// How often a scene has it.
    pub count: usize,
}

/// Lists the features of a scene that [`super::save_scene`] leaves out or changes, a line for each
/// kind.
///
/// ```
/// use drystone_scene::bake::{self, Unsaid};
///
/// let scene = drystone_scene::named("rope")?;
/// let unsaid: Vec<Unsaid> = bake::unsaid(&scene);
/// assert_eq!((unsaid[0].what.as_str(), unsaid[0].count), ("a rope, cloth or cloud", 1));
/// # Ok::<(), drystone_scene::CatalogError>(())
/// ```
#[must_use]
pub fn unsaid(scene: &Scene) -> Vec<Unsaid> {
    let mut count = Count::default();
    let config = WorldConfig { gravity: scene.config.gravity, ..WorldConfig::default() };
    count.add(scene.config != config, "settings of the world beside gravity");
    for body in &scene.bodies {
        count.body(&body.def);
    }
    // If all frictions are equal, so are all their means.
    let mut materials = scene.bodies.iter().flat_map(|b| &b.def.shapes).map(|s| &s.material);
    let by_mean = |m: &&Material| m.friction_combine == Combine::GeometricMean;
    let first = materials.clone().next().map(|m| m.friction.to_bits());
    if materials.any(|m| Some(m.friction.to_bits()) != first) {
        let means = scene.bodies.iter().flat_map(|b| &b.def.shapes).map(|s| &s.material);
        let what = "the geometric mean of friction, which other programs take for the average";
        count.add_all(means.filter(by_mean).count(), what);
    }
    for joint in &scene.joints {
        count.joint(joint);
    }
    count.add_all(scene.couplings.len(), "a coupling of joints");
    count.add_all(scene.strands.len(), "a rope, cloth or cloud");
    count.add_all(scene.frames.len(), "a named place on a body");
    count.add_all(scene.never_collide.len(), "a pair of bodies that never collide");
    let rules = scene.surface_rules.len() + scene.surfaces_between.len();
    count.add_all(rules, "a rule of surfaces");
    count.add(!matches!(scene.script, Script::None), "a script (actions besides physics)");
    let joining = scene.script.joining().count();
    count.add_all(joining, "a body that joins while the scene runs");
    let all = count.0.into_iter();
    all.map(|(what, count)| Unsaid { what: what.to_owned(), count }).collect()
}

/// Counts of the features that were met, by their names.
#[derive(Default)]
struct Count(BTreeMap<&'static str, usize>);

impl Count {
    fn add(&mut self, is_there: bool, what: &'static str) {
        self.add_all(usize::from(is_there), what);
    }

    fn add_all(&mut self, count: usize, what: &'static str) {
        if count > 0 {
            *self.0.entry(what).or_default() += count;
        }
    }

    fn body(&mut self, def: &BodyDef) {
        let default = BodyDef::default();
        self.add(def.linear_damping > 0.0 || def.angular_damping > 0.0, "damping of a body");
        self.add(def.locks != AxisLocks::NONE, "locked axes of a body");
        let sleeps = def.asleep || !def.can_sleep || def.sleep_speed.is_some();
        self.add(sleeps, "sleep settings of a body");
        self.add(!def.enabled, "a body that starts disabled");
        self.add(def.glue.is_some(), "glue");
        self.add(def.fracture.is_some(), "a body that fractures");
        self.add(def.user_data != default.user_data, "user data of a body");
        for shape in &def.shapes {
            self.shape(shape);
        }
    }

    fn shape(&mut self, def: &ShapeDef) {
        let m = &def.material;
        let resists = m.rolling_resistance > 0.0 || m.spinning_resistance > 0.0;
        self.add(resists, "rolling and spinning resistance");
        let moves = def.surface_velocity != Vec3::ZERO || def.surface_spin != Vec3::ZERO;
        self.add(moves, "a surface that moves");
        self.add(def.one_way.is_some(), "a surface that holds from one side");
        self.add(def.hooks || def.reports != ContactReports::default(), "the reports of a shape");
        self.add(def.senses != Senses::default(), "further senses of a sensor");
        self.add(!def.enabled, "a shape that starts disabled");
        self.add(def.user_data != 0, "user data of a shape");
    }

    fn joint(&mut self, joint: &SceneJoint) {
        for what in joints::written(&joint.kind).unsaid {
            self.add(true, what);
        }
        self.add(joint.strength.is_some(), "the strength of a joint");
        self.add(joint.articulated, "a joint that is solved with its tree at once");
        self.add(!joint.enabled, "a joint that starts disabled");
        self.add(joint.user_data != 0, "user data of a joint");
    }
}
