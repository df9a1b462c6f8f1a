//! Sensors.

use super::{Describe, Finder, Kind, Made, Own, in_order, limit};
use crate::error::SceneError;
use crate::mjcf::walk::Instance;
use crate::read::xml::Element;
use crate::robot::{Object, Sensor};

/// Kinds of sensors by the number of their readings.
const SIZES: [(usize, &str); 5] = [
    (
        1,
        "touch jointpos jointvel tendonpos tendonvel actuatorpos actuatorvel actuatorfrc jointactuatorfrc \
         tendonactuatorfrc jointlimitpos jointlimitvel jointlimitfrc tendonlimitpos tendonlimitvel tendonlimitfrc \
         insidesite distance e_potential e_kinetic clock",
    ),
    (2, "camprojection"),
    (
        3,
        "accelerometer velocimeter gyro force torque magnetometer ballangvel framepos framexaxis frameyaxis \
         framezaxis framelinvel frameangvel framelinacc frameangacc subtreecom subtreelinvel subtreeangmom normal",
    ),
    (4, "ballquat framequat"),
    (6, "fromto"),
];

/// Attributes that name an object, the first that is there counts, and those that name a reference.
const OBJECTS: [&str; 7] = ["joint", "tendon", "actuator", "site", "body", "geom1", "body1"];
const REFERENCES: [&str; 3] = ["geom2", "body2", "camera"];

impl<'a> Describe<'_, 'a> {
    pub(super) fn sensors(
        &mut self,
        instance: &Instance,
        is_main: bool,
        own: &Own,
    ) -> Result<(), SceneError> {
        let model = self.model(instance);
        let finder = Finder::new(instance, own, is_main);
        let mut made = Vec::new();
        for section in model.sections("sensor").collect::<Vec<_>>() {
            for element in model.children(&section)? {
                if element.tag() == "plugin" {
                    self.leave_out(&element, "plugins are not read");
                    continue;
                }
                let lists = element.attributes().map(|(attribute, name)| match attribute {
                    "joint" => finder.all(Kind::Joint, name),
                    "tendon" => finder.all(Kind::Tendon, name),
                    "actuator" => finder.all(Kind::Actuator, name),
                    "site" => finder.all(Kind::Site, name),
                    "body" => finder.all(Kind::Body, name),
                    "objname" if element.get("objtype") == Some("site") => {
                        finder.all(Kind::Site, name)
                    }
                    "objname" => finder.all(Kind::Body, name),
                    _ => None,
                });
                for (suffix, copy) in self.copies(lists) {
                    limit(made.len(), &element)?;
                    if let Some(thing) = self.sensor(&element, &finder, &suffix)? {
                        made.push(Made { copy, raw: "", suffix, thing });
                    }
                }
            }
        }
        self.robot.sensors.extend(in_order(made).into_iter().map(|m| m.thing));
        Ok(())
    }

    /// A sensor; `None`: what it is about is not there.
    fn sensor(
        &self,
        element: &Element<'a>,
        finder: &Finder<'_>,
        suffix: &str,
    ) -> Result<Option<Sensor>, SceneError> {
        let one = |kind: &str, name: &str| self.object(element, finder, kind, name, suffix);
        let named = |names: &[&str]| {
            let first = names.iter().find_map(|n| Some((*n, element.get(n)?)));
            first.map(|(kind, name)| one(kind.trim_end_matches(['1', '2']), name)).transpose()
        };
        let typed = |kind: &str, name: &str| {
            let (kind, name) = (element.get(kind), element.get(name));
            kind.zip(name).map(|(kind, name)| one(kind, name)).transpose()
        };
        let object = match typed("objtype", "objname")? {
            Some(object) => Some(object),
            None => named(&OBJECTS)?,
        };
        let reference = match typed("reftype", "refname")? {
            Some(reference) => Some(reference),
            None => named(&REFERENCES)?,
        };
        if object == Some(None) || reference == Some(None) {
            return Ok(None);
        }
        let kind = element.tag();
        let has = |list: &str| list.split_whitespace().any(|word| word == kind);
        let size = match SIZES.iter().find(|(_, kinds)| has(kinds)) {
            Some((size, _)) => Some(*size),
            // One for each ray and each datum.
            None if kind == "rangefinder" && element.get("data").is_none() => Some(1),
            None if kind == "user" => element.get("dim").and_then(|d| d.trim().parse().ok()),
            None => None,
        };
        Ok(Some(Sensor {
            name: finder.instance.name(element.get("name").unwrap_or_default(), suffix),
            kind: kind.to_owned(),
            object: object.flatten(),
            reference: reference.flatten(),
            size,
            cutoff: element.number("cutoff")?.unwrap_or(0.0),
            noise: element.number("noise")?.unwrap_or(0.0),
        }))
    }

    fn object(
        &self,
        element: &Element<'a>,
        finder: &Finder<'_>,
        kind: &str,
        name: &str,
        suffix: &str,
    ) -> Result<Option<Object>, SceneError> {
        let number = |kind: Kind| finder.find(element, kind, name, suffix);
        Ok(match kind {
            "joint" => number(Kind::Joint)?.map(|i| Object::Joint(self.walk.joint_numbers[i])),
            "tendon" => number(Kind::Tendon)?.map(Object::Tendon),
            "actuator" => number(Kind::Actuator)?.map(Object::Actuator),
            "site" => number(Kind::Site)?.map(Object::Site),
            "body" | "xbody" => number(Kind::Body)?.map(|link| Object::Link {
                name: self.walk.link_name(link),
                inertial: kind == "body",
            }),
            "geom" => Some(Object::Geom(finder.instance.name(name, suffix))),
            other => Some(Object::Other(other.to_owned(), finder.instance.name(name, suffix))),
        })
    }
}
