//! Attributes of a file that are not read.
//!
//! The table lists what is read, and what has no effect on motion (names, pictures, files, and what
//! MuJoCo's compiler solves without a change of the model). All else is named with its count and
//! first place, whether it is an attribute of the format or not. What only tunes MuJoCo's solver is
//! named too, but it is no physics: another solver has its own.

use std::collections::BTreeMap;

use super::model::Model;
use crate::read::xml::Element;

/// An element by its tag, or its section and tag: attributes that are read, then those without an
/// effect.
type Known = (&'static str, &'static str, &'static str);

/// Attributes of places.
const PLACE: &str = "pos quat axisangle xyaxes zaxis euler";

const TABLE: [Known; 21] = [
    ("mujoco", "model", ""),
    ("include", "file", ""),
    (
        "compiler",
        "angle eulerseq autolimits inertiafromgeom inertiagrouprange settotalmass balanceinertia boundmass \
         boundinertia fitaabb meshdir assetdir strippath",
        "texturedir discardvisual usethread fusestatic alignfree saveinertial",
    ),
    ("option", "gravity timestep cone", "apirate"),
    (
        "flag",
        "constraint contact limit frictionloss equality passive spring gravity actuation",
        "energy fwdinv invdiscrete sensor",
    ),
    ("default", "class", ""),
    ("body", "childclass mocap gravcomp name", "user"),
    ("frame", "childclass", "name"),
    ("replicate", "count offset euler sep", ""),
    ("attach", "model body prefix", ""),
    ("inertial", "mass diaginertia fullinertia", ""),
    (
        "geom",
        "type size fromto mesh density mass group friction solref contype conaffinity condim shellinertia fitscale class \
         name",
        "rgba material user",
    ),
    (
        "joint",
        "name type axis ref range limited stiffness damping springref frictionloss class armature",
        "group user",
    ),
    ("freejoint", "name", "group align"),
    ("site", "name fromto class", "type size rgba group material user"),
    (
        "mesh",
        "name file vertex face scale refpos refquat inertia class",
        "normal texcoord smoothnormal content_type material",
    ),
    ("equality", "name active class body1 body2 site1 site2 joint1 joint2 anchor polycoef", ""),
    ("exclude", "name body1 body2", ""),
    ("tendon", "name class range limited", "rgba width group material user"),
    ("path", "site joint coef", ""),
    ("model", "name file", "content_type"),
];

/// Attributes of MuJoCo's own solver, by their elements.
const SOLVER: [(&str, &str); 3] = [
    (
        "option",
        "integrator iterations tolerance ls_iterations ls_tolerance noslip_iterations noslip_tolerance \
         ccd_iterations ccd_tolerance mpr_iterations mpr_tolerance sdf_iterations sdf_initpoints solver jacobian",
    ),
    ("flag", "multiccd island midphase nativeccd autoreset warmstart refsafe eulerdamp"),
    ("mesh", "maxhullvert"),
];

/// Values that are as good as none: what the format takes without the attribute.
const NEUTRAL: [(&str, &str); 31] = [
    ("coordinate", "local"),
    ("impratio", "1"),
    ("integrator", "Euler"),
    ("noslip_iterations", "0"),
    ("maxhullvert", "-1"),
    ("damper", "enable"),
    ("clampctrl", "enable"),
    ("override", "disable"),
    ("warmstart", "enable"),
    ("refsafe", "enable"),
    ("eulerdamp", "enable"),
    ("autoreset", "enable"),
    ("margin", "0"),
    ("gap", "0"),
    ("priority", "0"),
    ("solmix", "1"),
    ("density", "0"),
    ("viscosity", "0"),
    ("wind", "0 0 0"),
    ("fluidshape", "none"),
    ("springdamper", "0 0"),
    ("springlength", "-1"),
    ("stiffness", "0"),
    ("damping", "0"),
    ("frictionloss", "0"),
    ("sleep", "auto"),
    ("filterparent", "enable"),
    ("torquescale", "1"),
    ("actuatorgravcomp", "false"),
    ("solimp", "0.9 0.95 0.001 0.5 2"),
    ("solreflimit", "0.02 1"),
];

/// Sections that are named as a whole, or that only concern pictures and memory.
const WHOLE: [&str; 11] = [
    "actuator",
    "sensor",
    "keyframe",
    "custom",
    "extension",
    "deformable",
    "visual",
    "statistic",
    "size",
    "light",
    "camera",
];

/// Attributes that are not read, each in a line.
#[derive(Debug, Default)]
pub(super) struct Unread {
    pub(super) physics: Vec<String>,
    /// Attributes of MuJoCo's solver.
    pub(super) solver: Vec<String>,
}

/// Attributes of the models' files that are neither read nor without effect.
pub(super) fn attributes(models: &[Model<'_>]) -> Unread {
    let mut found: BTreeMap<(String, String, bool), (usize, String)> = BTreeMap::new();
    let mut stack: Vec<(Element<'_>, &str)> =
        models.iter().rev().flat_map(Model::documents).map(|root| (root, "")).collect();
    while let Some((element, around)) = stack.pop() {
        let tag = element.tag();
        if WHOLE.contains(&tag) {
            continue;
        }
        // Inside `<default>` a tag stands for its section.
        let kind = match (around, tag) {
            ("equality", "connect" | "weld" | "joint" | "tendon" | "flex") => "equality",
            ("tendon", "spatial" | "fixed") => "tendon",
            ("fixed" | "spatial", _) => "path",
            // An included file has its sections around the include.
            (_, "connect" | "weld") => "equality",
            (_, "joint") if element.get("joint1").is_some() => "equality",
            (_, "spatial" | "fixed") => "tendon",
            (_, "joint") if element.get("joint").is_some() => "path",
            _ => tag,
        };
        if let Some(&(_, read, still)) = TABLE.iter().find(|(known, ..)| *known == kind) {
            let is_placed = ["body", "frame", "inertial", "geom", "site", "joint"].contains(&kind);
            for (name, value) in element.attributes() {
                let listed = |list: &str| has(list, name);
                let is_known = listed(read) || listed(still) || (is_placed && listed(PLACE));
                if (is_known && is_read(name, value)) || is_neutral(name, value) {
                    continue;
                }
                let is_solver = SOLVER.iter().any(|(of, names)| *of == kind && has(names, name));
                let key = (tag.to_owned(), name.to_owned(), is_solver);
                found.entry(key).or_insert_with(|| (0, element.place())).0 += 1;
            }
        }
        let inside: Vec<Element<'_>> = element.children().collect();
        stack.extend(inside.into_iter().rev().map(|child| (child, tag)));
    }
    let mut out = Unread::default();
    for ((tag, name, is_solver), (count, place)) in found {
        let times = if count == 1 { "once".to_owned() } else { format!("{count} times") };
        let line = format!("<{tag} {name}>: not read ({times}, first in {place})");
        if is_solver {
            out.solver.push(format!("{line}; it tunes MuJoCo's solver"));
        } else {
            out.physics.push(line);
        }
    }
    out
}

fn has(list: &str, name: &str) -> bool {
    list.split_whitespace().any(|word| word == name)
}

/// Whether the value of an attribute is one that is read, of those that are read in part.
fn is_read(name: &str, value: &str) -> bool {
    let first = value.split_whitespace().next().and_then(|word| word.parse::<f64>().ok());
    match name {
        // Friction is a cone here, a pyramid is not read.
        "cone" => value == "elliptic",
        // Friction about the normal and of rolling.
        "condim" => first.is_none_or(|n| n <= 3.0),
        // The damping ratio of contacts is read, their stiffness is not.
        "solref" => first.is_none_or(|time| (time - 0.02).abs() < 1.0e-9),
        // Neither negative ones nor polynomials.
        "damping" | "stiffness" => {
            first.is_none_or(|x| x >= 0.0) && value.split_whitespace().count() <= 1
        }
        _ => true,
    }
}

fn is_neutral(name: &str, value: &str) -> bool {
    let numbers = |text: &str| -> Option<Vec<f64>> {
        text.split_whitespace().map(|word| word.parse().ok()).collect()
    };
    NEUTRAL.iter().filter(|(known, _)| *known == name).any(|(_, neutral)| {
        match (numbers(value), numbers(neutral)) {
            (Some(own), Some(none)) => own == none,
            _ => value.trim() == *neutral,
        }
    })
}
