//! Attributes and elements of a robot's file that are not read.
//!
//! The tables list what is read, what only concerns pictures and names, and what only concerns
//! motors, sensors and their software. All else may be physics.

use std::collections::BTreeMap;

use super::element::list;
use crate::read::xml::Element;

/// An element by its tag: elements inside it that are read, then its attributes that are read.
type Read = (&'static str, &'static str, &'static str);

const READ: [Read; 24] = [
    ("robot", "link joint drake:joint", "name"),
    ("link", "inertial collision contact", "name"),
    ("inertial", "origin mass inertia", ""),
    ("mass", "", "value"),
    ("inertia", "", "ixx iyy izz ixy ixz iyz"),
    ("origin", "", "xyz rpy"),
    ("collision", "origin geometry", ""),
    ("geometry", "box sphere cylinder capsule drake:capsule mesh plane", ""),
    ("box", "", "size"),
    ("sphere", "", "radius"),
    ("cylinder", "", "radius length"),
    ("capsule", "", "radius length"),
    ("mesh", "", "filename scale"),
    ("plane", "", "normal"),
    ("contact", "lateral_friction restitution", ""),
    ("lateral_friction", "", "value"),
    ("restitution", "", "value"),
    ("joint", "origin parent child axis limit dynamics mimic", "name type"),
    ("parent", "", "link"),
    ("child", "", "link"),
    ("axis", "", "xyz"),
    ("limit", "", "lower upper"),
    ("dynamics", "", "damping friction"),
    ("mimic", "", "joint multiplier offset"),
];

/// Elements that an element may have several of.
const MANY: [&str; 4] = ["link", "joint", "drake:joint", "collision"];

/// Elements and attributes, by where they stand, that only concern pictures, names and versions.
const STILL: [(&str, &str); 8] = [
    ("robot", "material"),
    ("robot", "version"),
    ("link", "visual"),
    ("link", "material"),
    ("collision", "name"),
    ("collision", "material"),
    ("collision", "verbose"),
    ("inertial", "name"),
];

/// Elements and attributes that only concern motors, sensors, and the software that drives and
/// reads them.
const DRIVEN: [(&str, &str); 16] = [
    ("limit", "effort"),
    ("limit", "velocity"),
    ("limit", "acceleration"),
    ("limit", "jerk"),
    ("limit", "deceleration"),
    ("joint", "safety_controller"),
    ("joint", "calibration"),
    ("joint", "hardwareInterface"),
    ("robot", "ros2_control"),
    ("robot", "sensor"),
    ("link", "sensor"),
    ("link", "type"),
    ("robot", "transmission"),
    ("gazebo", "sensor"),
    ("gazebo", "plugin"),
    ("gazebo", "material"),
];

/// Elements whose parts are named one by one, though none is read.
const OPENED: [&str; 3] = ["gazebo", "mujoco", "transmission"];

/// Attributes of MuJoCo's `compiler` that only concern files and pictures.
const COMPILED: &str = "meshdir strippath discardvisual fusestatic";

/// Values of attributes, by name, that are as good as none.
const NEUTRAL: [(&str, f64); 4] = [
    ("rolling_friction", 0.0),
    ("spinning_friction", 0.0),
    ("inertia_scaling", 1.0),
    ("contact_cfm", 0.0),
];

/// Things that are not read, each in a line.
#[derive(Debug, Default)]
pub(super) struct Unread {
    /// Things that may be physics.
    pub(super) physics: Vec<String>,
    /// Things that only concern motors, sensors and their software.
    pub(super) driven: Vec<String>,
}

/// Things that are not read: what they are, and whether they only concern motors, with their count
/// and first place.
type Found = BTreeMap<(String, bool), (usize, String)>;

/// An element as seen from the one around it.
#[derive(Clone, Copy)]
enum Place {
    Known,
    /// One of which there should be one.
    Second(&'static str),
    Unknown(&'static str),
}

/// Looks through a file.
pub(super) fn all(robot: &Element<'_>) -> Unread {
    let mut found = Found::new();
    // A stack stands for the way back, so that no file can be too deep.
    let mut stack = vec![(*robot, Place::Known)];
    while let Some((element, place)) = stack.pop() {
        match place {
            Place::Known => {}
            Place::Second(around) => {
                let what = format!("a second <{}> of one <{around}>", element.full_tag());
                add(&mut found, what, false, &element);
                continue;
            }
            Place::Unknown(around) => {
                unknown(&mut found, around, &element);
                continue;
            }
        }
        let Some(&(tag, inside, attributes)) = READ.iter().find(|(tag, ..)| *tag == element.tag())
        else {
            continue;
        };
        for (name, _) in element.attributes() {
            if !has(attributes, name) {
                attribute(&mut found, &element, tag, name);
            }
        }
        too_many(&mut found, &element);
        let mut seen: Vec<&str> = Vec::new();
        let mut places = Vec::new();
        for child in element.children() {
            let full = child.full_tag();
            let place = if !has(inside, &full) {
                Place::Unknown(tag)
            } else if seen.contains(&child.tag()) && !MANY.contains(&full.as_ref()) {
                Place::Second(tag)
            } else {
                Place::Known
            };
            if matches!(place, Place::Known) && !seen.contains(&child.tag()) {
                seen.push(child.tag());
            }
            places.push((child, place));
        }
        stack.extend(places.into_iter().rev());
    }
    told(found)
}

fn has(list: &str, name: &str) -> bool {
    list.split_whitespace().any(|word| word == name)
}

fn add(found: &mut Found, what: String, is_driven: bool, at: &Element<'_>) {
    let entry = found.entry((what, is_driven)).or_insert_with(|| (0, at.place()));
    entry.0 += 1;
}

/// Notes an attribute, unless it has no effect.
fn attribute(found: &mut Found, at: &Element<'_>, around: &str, name: &str) {
    let is = |table: &[(&str, &str)]| table.contains(&(around, name));
    if !is(&STILL) {
        add(found, format!("<{around} {name}>"), is(&DRIVEN), at);
    }
}

/// Notes an element that is not read: as a whole, or part by part.
fn unknown(found: &mut Found, around: &str, element: &Element<'_>) {
    let full = element.full_tag();
    let is_neutral = NEUTRAL.iter().any(|(name, none)| {
        let value = element.get("value").and_then(|v| v.trim().parse::<f64>().ok());
        *name == full && value == Some(*none)
    });
    if is_neutral {
        return;
    }
    // An element and an attribute may have the same name.
    let is = |table: &[(&str, &str)]| table.iter().any(|(a, b)| *a == around && *b == full);
    if is(&STILL) {
        return;
    }
    if OPENED.contains(&full.as_ref()) && element.children().next().is_some() {
        for child in element.children() {
            let name = child.full_tag();
            let is_driven =
                full == "transmission" || DRIVEN.iter().any(|(a, b)| *a == full && *b == name);
            if full != "mujoco" || child.attributes().next().is_none() {
                add(found, format!("<{name}> of <{full}>"), is_driven, &child);
                continue;
            }
            for (attribute, _) in child.attributes().filter(|(a, _)| !has(COMPILED, a)) {
                add(found, format!("<{name} {attribute}> of <{full}>"), false, &child);
            }
        }
        return;
    }
    add(found, format!("<{full}>"), is(&DRIVEN) || full == "transmission", element);
}

/// Notes lists of which only the first three numbers are read.
fn too_many(found: &mut Found, element: &Element<'_>) {
    for name in ["xyz", "rpy", "size", "scale", "normal"] {
        if list(element, name).is_ok_and(|numbers| numbers.len() > 3) {
            let what = format!("<{} {name}> beyond three numbers", element.tag());
            add(found, what, false, element);
        }
    }
}

fn told(found: Found) -> Unread {
    let mut out = Unread::default();
    for ((what, is_driven), (count, place)) in found {
        let times = if count == 1 { "once".to_owned() } else { format!("{count} times") };
        let line = format!("{what}: not read ({times}, first in {place})");
        if is_driven {
            out.driven.push(format!("{line}; only motors and sensors need it"));
        } else {
            out.physics.push(line);
        }
    }
    out
}
