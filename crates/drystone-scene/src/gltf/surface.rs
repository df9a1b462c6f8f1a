//! Physics materials and collision filters.

use drystone::contact::Combine;
use drystone::{Filter, Material};

use crate::error::SceneError;
use crate::read::json::At;

/// A collider without a material leaves the rule to the other side: the geometric mean is the
/// weakest.
pub(crate) fn bare() -> Material {
    Material {
        friction: 0.6,
        restitution: 0.0,
        friction_combine: Combine::GeometricMean,
        restitution_combine: Combine::GeometricMean,
        ..Material::default()
    }
}

/// The members of a material that name its rules.
pub(crate) const COMBINE: [&str; 2] = ["frictionCombine", "restitutionCombine"];

/// A rule that the extension does not have. It stands in the material's `extras`, beside one of the
/// extension's rules for other programs; [`crate::bake`] writes it.
pub(crate) const GEOMETRIC_MEAN: &str = "geometricMean";

/// The rule of a material by the member that names it.
fn rule_of(material: &At<'_>, key: &str) -> Result<Combine, SceneError> {
    match material.dig(&["extras", key]).map(|at| at.text()).transpose() {
        Ok(Some(GEOMETRIC_MEAN)) => Ok(Combine::GeometricMean),
        // Extras may hold anything of anybody's.
        _ => combine(material.get(key)),
    }
}

fn combine(at: Option<At<'_>>) -> Result<Combine, SceneError> {
    let Some(at) = at else { return Ok(Combine::Average) };
    match at.text()? {
        "average" => Ok(Combine::Average),
        "minimum" => Ok(Combine::Minimum),
        "maximum" => Ok(Combine::Maximum),
        "multiply" => Ok(Combine::Multiply),
        _ => Err(at.wrong("\"average\", \"minimum\", \"maximum\" or \"multiply\"")),
    }
}

/// The materials of the document. In the engine kinetic friction is never more than static
/// friction.
pub(crate) fn materials(
    extension: Option<&At<'_>>,
    notes: &mut Vec<String>,
) -> Result<Vec<Material>, SceneError> {
    let mut out = Vec::new();
    let Some(extension) = extension else { return Ok(out) };
    for at in extension.list("physicsMaterials")? {
        let friction = |key: &str| at.get(key).map_or(Ok(0.6), |v| v.at_least_zero());
        let (fixed, sliding) = (friction("staticFriction")?, friction("dynamicFriction")?);
        if sliding > fixed {
            let used = "the static one is used for both";
            notes.push(format!(
                "{}: static friction {fixed}, dynamic {sliding}: {used}",
                at.place()
            ));
        }
        let mut restitution = at.get("restitution").map_or(Ok(0.0), |v| v.at_least_zero())?;
        if restitution > 1.0 {
            notes.push(format!("{}: restitution {restitution} is taken as 1", at.place()));
            restitution = 1.0;
        }
        out.push(Material {
            friction: fixed,
            kinetic_friction: (sliding < fixed).then_some(sliding),
            restitution,
            friction_combine: rule_of(&at, COMBINE[0])?,
            restitution_combine: rule_of(&at, COMBINE[1])?,
            ..Material::default()
        });
    }
    Ok(out)
}

/// A collision filter as the file has it.
#[derive(Clone, Debug, Default, PartialEq)]
struct Systems {
    member: Vec<String>,
    with: Option<Vec<String>>,
    not_with: Option<Vec<String>>,
}

impl Systems {
    /// One side of the rule: a system of `self` is in `other.with`, and none is in
    /// `other.not_with`. A collider in no system is in no list of either kind.
    ///
    /// One system in common is enough, as the samples of the extension's author need it: their
    /// floor is in two systems and carries bodies that collide with one of them.
    fn admitted_by(&self, other: &Self) -> bool {
        let shared = |list: &Vec<String>| self.member.iter().any(|m| list.contains(m));
        other.with.as_ref().is_none_or(shared) && !other.not_with.as_ref().is_some_and(shared)
    }
}

/// The filters of the document, then the one of colliders without filter.
///
/// Each different filter of the file gets a layer of its own, and its mask the layers of those it
/// collides with. So the engine's masks give exactly the format's rule about sets of systems.
pub(crate) fn filters(
    extension: Option<&At<'_>>,
    notes: &mut Vec<String>,
) -> Result<Vec<Filter>, SceneError> {
    let mut all = Vec::new();
    if let Some(extension) = extension {
        for at in extension.list("collisionFilters")? {
            let names = |key: &str| -> Result<Option<Vec<String>>, SceneError> {
                let Some(list) = at.get(key) else { return Ok(None) };
                list.items()?
                    .iter()
                    .map(|n| n.text().map(str::to_owned))
                    .collect::<Result<_, _>>()
                    .map(Some)
            };
            all.push(Systems {
                member: names("collisionSystems")?.unwrap_or_default(),
                with: names("collideWithSystems")?,
                not_with: names("notCollideWithSystems")?,
            });
        }
    }
    all.push(Systems::default());
    let mut classes: Vec<&Systems> = Vec::new();
    let mut class_of = Vec::new();
    for systems in &all {
        let found = classes.iter().position(|c| *c == systems);
        class_of.push(found.unwrap_or(classes.len()));
        if found.is_none() {
            classes.push(systems);
        }
    }
    if classes.len() > 64 {
        notes.push(format!(
            "of {} different collision filters the first 64 are kept",
            classes.len()
        ));
    }
    let filter = |class: usize| {
        if class >= 64 {
            return Filter::default();
        }
        let mine = classes[class];
        let meets = |other: &Systems| mine.admitted_by(other) && other.admitted_by(mine);
        let mask = classes.iter().take(64).enumerate().filter(|(_, c)| meets(c));
        // Never all ones, which would mean any shape: bits without a class stay clear.
        Filter::layers(1 << class, mask.fold(0, |m, (i, _)| m | 1 << i))
    };
    // A file without filters keeps the engine's default.
    if classes.len() == 1 {
        return Ok(vec![Filter::default(); all.len()]);
    }
    Ok(class_of.into_iter().map(filter).collect())
}
