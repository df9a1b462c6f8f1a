//! Tendons.

use super::{Describe, Finder, Kind, Made, Own, bounds, in_order, limit, powers};
use crate::error::SceneError;
use crate::mjcf::defaults::View;
use crate::mjcf::model::Model;
use crate::mjcf::walk::{Instance, register};
use crate::read::xml::Element;
use crate::robot::{Stage, Tendon};

impl<'a> Describe<'_, 'a> {
    pub(super) fn tendons(
        &mut self,
        instance: &Instance,
        is_main: bool,
        own: &mut Own,
    ) -> Result<(), SceneError> {
        let model = self.model(instance);
        let none = Own::default();
        let finder = Finder::new(instance, &none, is_main);
        let mut made = Vec::new();
        for section in model.sections("tendon").collect::<Vec<_>>() {
            for element in model.children(&section)? {
                if !["fixed", "spatial"].contains(&element.tag()) {
                    self.leave_out(&element, "it is no tendon");
                    continue;
                }
                let parts = model.children(&element)?;
                let lists = parts.iter().map(|part| {
                    part.get("joint").map_or_else(
                        || part.get("site").and_then(|name| finder.all(Kind::Site, name)),
                        |name| finder.all(Kind::Joint, name),
                    )
                });
                for (suffix, copy) in self.copies(lists) {
                    limit(made.len(), &element)?;
                    let Some(path) = self.path(&parts, &finder, &suffix)? else { continue };
                    let view = model.defaults.view(element, None)?;
                    let raw = element.get("name").unwrap_or_default();
                    let name = instance.name(raw, &suffix);
                    let thing = tendon(name, path, &view, model)?;
                    made.push(Made { copy, raw, suffix, thing });
                }
            }
        }
        for Made { copy, raw, suffix, thing } in in_order(made) {
            if !raw.is_empty() {
                register(&mut own.tendons, raw, &suffix, self.robot.tendons.len());
            }
            self.copy_of_tendons.push(copy);
            self.robot.tendons.push(thing);
        }
        Ok(())
    }

    /// The parts of a tendon; `None`: one of them is not there.
    fn path(
        &self,
        parts: &[Element<'a>],
        finder: &Finder<'_>,
        suffix: &str,
    ) -> Result<Option<Vec<Stage>>, SceneError> {
        let mut out = Vec::with_capacity(parts.len());
        for part in parts {
            let stage = match part.tag() {
                "joint" => {
                    let coefficient = part.number("coef")?.unwrap_or(0.0);
                    let found = finder.find(part, Kind::Joint, part.need("joint")?, suffix)?;
                    found.map(|i| Stage::Joint(self.walk.joint_numbers[i], coefficient))
                }
                "site" => {
                    finder.find(part, Kind::Site, part.need("site")?, suffix)?.map(Stage::Site)
                }
                "geom" => {
                    let side = match part.get("sidesite") {
                        Some(site) => finder.find(part, Kind::Site, site, suffix)?,
                        None => None,
                    };
                    Some(Stage::Geom(finder.instance.name(part.need("geom")?, suffix), side))
                }
                "pulley" => Some(Stage::Pulley(part.above_zero("divisor")?)),
                _ => {
                    return Err(
                        part.error("a tendon has no such part", "joint, site, geom or pulley")
                    );
                }
            };
            let Some(stage) = stage else { return Ok(None) };
            out.push(stage);
        }
        Ok(Some(out))
    }
}

fn tendon<'a>(
    name: String,
    path: Vec<Stage>,
    view: &View<'a>,
    model: &Model<'a>,
) -> Result<Tendon, SceneError> {
    let range = if view.is_limited(model.settings.autolimits)? {
        view.numbers::<2>("range")?
    } else {
        None
    };
    // One number is both; below zero the tendon's own length is meant.
    let spring_length = match view.list("springlength", 2)?[..] {
        [both] if both >= 0.0 => Some([both; 2]),
        [least, greatest] if least >= 0.0 => Some([least, greatest]),
        _ => None,
    };
    Ok(Tendon {
        name,
        path,
        range,
        margin: view.number("margin")?.unwrap_or(0.0),
        stiffness: powers(view, "stiffness")?,
        damping: powers(view, "damping")?,
        spring_length,
        friction: view.number("frictionloss")?.unwrap_or(0.0),
        armature: view.number("armature")?.unwrap_or(0.0),
        force_range: bounds(view, model, "actuatorfrclimited", "actuatorfrcrange")?,
    })
}
