//! Actuators.

use super::laws::{Laws, TAGS, over};
use super::{Describe, Finder, Kind, Made, Own, bounds, in_order, limit, powers};
use crate::error::SceneError;
use crate::mjcf::defaults::View;
use crate::mjcf::model::Model;
use crate::mjcf::walk::{Instance, register};
use crate::read::xml::Element;
use crate::robot::{Actuator, Dynamics, Transmission};

impl<'a> Describe<'_, 'a> {
    pub(super) fn actuators(
        &mut self,
        instance: &Instance,
        is_main: bool,
        own: &mut Own,
    ) -> Result<(), SceneError> {
        let model = self.model(instance);
        let finder = Finder::new(instance, own, is_main);
        let mut made = Vec::new();
        for section in model.sections("actuator").collect::<Vec<_>>() {
            for element in model.children(&section)? {
                if !TAGS.contains(&element.tag()) {
                    self.leave_out(&element, "actuators of this kind are not read");
                    continue;
                }
                let said = model.defaults.said(&element, None, &TAGS)?;
                let lists = element.attributes().map(|(attribute, name)| match attribute {
                    "joint" | "jointinparent" => finder.all(Kind::Joint, name),
                    "tendon" => finder.all(Kind::Tendon, name),
                    "site" | "refsite" | "cranksite" | "slidersite" => finder.all(Kind::Site, name),
                    "body" => finder.all(Kind::Body, name),
                    _ => None,
                });
                for (suffix, copy) in self.copies(lists) {
                    limit(made.len(), &element)?;
                    let view = View::of(element, &said);
                    let found = self.transmission(&element, &view, &finder, &suffix)?;
                    let Some(transmission) = found else { continue };
                    let raw = element.get("name").unwrap_or_default();
                    let name = instance.name(raw, &suffix);
                    let thing =
                        Actuator { name, ..self.actuator(&view, &said, model, transmission)? };
                    made.push(Made { copy, raw, suffix, thing });
                }
            }
        }
        for Made { copy, raw, suffix, thing } in in_order(made) {
            if !raw.is_empty() {
                register(&mut own.actuators, raw, &suffix, self.robot.actuators.len());
            }
            self.copy_of_actuators.push(copy);
            self.robot.actuators.push(thing);
        }
        Ok(())
    }

    /// The transmission of an actuator; `None`: it is not there.
    fn transmission(
        &self,
        element: &Element<'a>,
        view: &View<'a>,
        finder: &Finder<'_>,
        suffix: &str,
    ) -> Result<Option<Transmission>, SceneError> {
        let site = |name: &str| finder.find(element, Kind::Site, name, suffix);
        for (attribute, in_parent) in [("joint", false), ("jointinparent", true)] {
            if let Some(name) = element.get(attribute) {
                let found = finder.find(element, Kind::Joint, name, suffix)?;
                let number = |i: usize| self.walk.joint_numbers[i];
                return Ok(found.map(|i| Transmission::Joint { joint: number(i), in_parent }));
            }
        }
        if let Some(name) = element.get("tendon") {
            let found = finder.find(element, Kind::Tendon, name, suffix)?;
            return Ok(found.map(Transmission::Tendon));
        }
        if let Some(crank) = element.get("cranksite") {
            let ends = site(crank)?.zip(site(element.need("slidersite")?)?);
            let length = view.number("cranklength")?.unwrap_or(0.0);
            let crank = |(crank, slider)| Transmission::Crank { crank, slider, length };
            return Ok(ends.map(crank));
        }
        if let Some(name) = element.get("site") {
            let reference = element.get("refsite").map(site).transpose()?;
            if reference == Some(None) {
                return Ok(None);
            }
            let reference = reference.flatten();
            return Ok(site(name)?.map(|site| Transmission::Site { site, reference }));
        }
        if let Some(name) = element.get("body") {
            let found = finder.find(element, Kind::Body, name, suffix)?;
            return Ok(found.map(|link| Transmission::Link(self.walk.link_name(link))));
        }
        Err(element.error("it pulls at nothing", "a joint, a tendon, a site or a body"))
    }

    /// An actuator without its name.
    fn actuator(
        &self,
        view: &View<'a>,
        said: &[Element<'a>],
        model: &Model<'a>,
        transmission: Transmission,
    ) -> Result<Actuator, SceneError> {
        let element = view.element();
        let mut laws = Laws::default();
        let mut gear = [1.0, 0.0, 0.0, 0.0, 0.0, 0.0];
        // From the outermost class in.
        for source in said.iter().rev().chain([element]) {
            laws.apply(source)?;
            over(&mut gear, source, "gear")?;
        }
        let ratio = laws.ratio();
        let mut control_range = bounds(view, model, "ctrllimited", "ctrlrange")?;
        let mut activation_range = bounds(view, model, "actlimited", "actrange")?;
        if ["damper", "adhesion"].contains(&element.tag()) {
            control_range = view.numbers::<2>("ctrlrange")?;
        }
        if element.tag() == "intvelocity" {
            activation_range = view.numbers::<2>("actrange")?;
        }
        let given = if laws.dynamics == Dynamics::Integrator { "actrange" } else { "ctrlrange" };
        let inherits = matches!(view.first(&["inheritrange", given]), Some(("inheritrange", _)));
        if laws.inherited > 0.0 && inherits {
            let range = self.range(&transmission).ok_or_else(|| {
                element.error("it inherits a range from what has none", "a joint with a range")
            })?;
            let (middle, half) = (0.5 * (range[0] + range[1]), 0.5 * (range[1] - range[0]));
            let part = [middle - laws.inherited * half, middle + laws.inherited * half];
            if laws.dynamics == Dynamics::Integrator {
                activation_range = Some(part);
            } else {
                control_range = Some(part);
            }
        }
        let count = view.number("actdim")?.filter(|n| *n >= 1.0);
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "at least 1")]
        let activations = match laws.dynamics {
            Dynamics::None => 0,
            _ => count.map_or(1, |n| n as usize),
        };
        Ok(Actuator {
            name: String::new(),
            transmission,
            gear,
            control_range,
            force_range: bounds(view, model, "forcelimited", "forcerange")?,
            activation_range,
            length_range: view.numbers::<2>("lengthrange")?,
            activations,
            dynamics: laws.dynamics,
            dynamics_numbers: laws.dynamics_numbers,
            acts_early: view.get("actearly") == Some("true"),
            gain: laws.gain,
            gain_numbers: laws.gain_numbers,
            bias: laws.bias,
            bias_numbers: laws.bias_numbers,
            damping_ratio: ratio,
            armature: view.number("armature")?.unwrap_or(0.0),
            damping: powers(view, "damping")?,
        })
    }

    /// The range of what an actuator pulls at.
    fn range(&self, transmission: &Transmission) -> Option<[f32; 2]> {
        match transmission {
            Transmission::Joint { joint, .. } => self.robot.joints.get(*joint)?.range,
            Transmission::Tendon(tendon) => self.robot.tendons.get(*tendon)?.range,
            _ => None,
        }
    }
}
