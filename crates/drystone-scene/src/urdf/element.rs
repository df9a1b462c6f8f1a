//! The elements of a robot's file, each by itself.

use std::collections::BTreeMap;

use drystone::{Material, Pose, Quat, Vec3};

use crate::error::SceneError;
use crate::links::{Dof, Hold, Way};
use crate::read::xml::{self, Element};

/// Kinds of joints.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum JointType {
    Fixed,
    Revolute,
    Continuous,
    Prismatic,
    Planar,
    Floating,
    Ball,
    Universal,
}

/// A joint as the file has it.
pub(super) struct Joint<'a> {
    pub(super) name: &'a str,
    pub(super) parent: usize,
    pub(super) child: usize,
    /// Where the child is [frame of the parent].
    pub(super) origin: Pose,
    pub(super) hold: Hold,
    pub(super) note: Option<String>,
    /// The joint that it follows: its name, multiplier and offset.
    pub(super) mimic: Option<(&'a str, f32, f32)>,
}

/// A rotation by roll, pitch and yaw about fixed axes [rad].
fn rotation([roll, pitch, yaw]: [f32; 3]) -> Quat {
    let about = |axis: Vec3, angle: f32| Quat::from_axis_angle(axis, angle);
    (about(Vec3::Z, yaw) * about(Vec3::Y, pitch) * about(Vec3::X, roll)).normalized()
}

/// Numbers of a list, between which commas may stand; PyBullet and Drake read them so.
pub(super) fn list(element: &Element<'_>, name: &str) -> Result<Vec<f32>, SceneError> {
    let Some(text) = element.get(name) else { return Ok(Vec::new()) };
    let text = text.replace(',', " ");
    xml::numbers(&text, 16).map_err(|allowed| element.wrong(name, &allowed))
}

/// Three numbers, if the attribute is there: of more, as PyBullet does, the first three.
pub(super) fn triple(element: &Element<'_>, name: &str) -> Result<Option<[f32; 3]>, SceneError> {
    match list(element, name)?[..] {
        _ if element.get(name).is_none() => Ok(None),
        [a, b, c, ..] => Ok(Some([a, b, c])),
        _ => Err(element.wrong(name, "3 finite numbers")),
    }
}

/// A bound, which may be infinite: no number beyond this is meant as one [m; rad; N; N m].
pub(super) const NO_BOUND: f64 = 1.0e30;

/// A bound of a joint, if the attribute is there; infinite if it is none.
fn bound(element: &Element<'_>, name: &str) -> Result<Option<f32>, SceneError> {
    let Some(text) = element.get(name) else { return Ok(None) };
    match text.trim().parse::<f64>() {
        Ok(x) if x > NO_BOUND => Ok(Some(f32::INFINITY)),
        Ok(x) if x < -NO_BOUND => Ok(Some(f32::NEG_INFINITY)),
        #[expect(clippy::cast_possible_truncation, reason = "checked")]
        Ok(x) if !x.is_nan() => Ok(Some(x as f32)),
        _ => Err(element.wrong(name, "a number or inf")),
    }
}

/// The `<origin>` of an element; without one, no shift.
pub(super) fn origin(element: &Element<'_>) -> Result<Pose, SceneError> {
    let Some(at) = element.child("origin") else { return Ok(Pose::IDENTITY) };
    let position = triple(&at, "xyz")?.map_or(Vec3::ZERO, Vec3::from);
    Ok(Pose::new(position, rotation(triple(&at, "rpy")?.unwrap_or_default())))
}

/// `lateral_friction` and `restitution`, which Bullet reads, of a link's `<contact>`.
pub(super) fn material(link: &Element<'_>) -> Result<Material, SceneError> {
    let mut material = Material::default();
    let Some(contact) = link.child("contact") else { return Ok(material) };
    if let Some(at) = contact.child("lateral_friction") {
        material.friction = at.at_least_zero("value")?.unwrap_or(material.friction);
    }
    if let Some(at) = contact.child("restitution") {
        let e = at.at_least_zero("value")?.unwrap_or(0.0);
        if e > 1.0 {
            return Err(at.wrong("value", "0 to 1"));
        }
        material.restitution = e;
    }
    Ok(material)
}

pub(super) fn joint<'a>(
    element: &Element<'a>,
    number: &BTreeMap<&str, usize>,
) -> Result<Joint<'a>, SceneError> {
    let name = element.need("name")?;
    let end = |tag: &'static str| {
        let Some(at) = element.child(tag) else {
            return Err(element.error(format!("it has no <{tag}>"), "one with a link"));
        };
        let link = at.need("link")?;
        number.get(link).copied().ok_or_else(|| {
            element.error(format!("its {tag} is '{link}', which is no link"), "a link of the file")
        })
    };
    let (parent, child) = (end("parent")?, end("child")?);
    if parent == child {
        return Err(element.error("its parent is its child", "two links"));
    }
    let kind = match element.need("type")? {
        "fixed" => JointType::Fixed,
        "revolute" => JointType::Revolute,
        "continuous" => JointType::Continuous,
        "prismatic" => JointType::Prismatic,
        "planar" => JointType::Planar,
        "floating" => JointType::Floating,
        // PyBullet's name, and Drake's of a `drake:joint`.
        "spherical" | "ball" => JointType::Ball,
        "universal" => JointType::Universal,
        _ => {
            let allowed = "fixed, revolute, continuous, prismatic, planar, floating, spherical, ball or universal";
            return Err(element.wrong("type", allowed));
        }
    };
    let axis = match element.child("axis") {
        Some(at) => {
            at.need("xyz")?;
            let v = triple(&at, "xyz")?.map_or(Vec3::ZERO, Vec3::from);
            // Many files name the axis of joints that have none.
            match direction(&at, "xyz", v) {
                Err(_) if !kind.has_axis() => Vec3::X,
                other => other?,
            }
        }
        None => Vec3::X,
    };
    let way = match kind {
        JointType::Fixed | JointType::Floating | JointType::Planar => Way::Planar,
        JointType::Revolute | JointType::Continuous | JointType::Universal => Way::Hinge,
        JointType::Prismatic => Way::Slide,
        JointType::Ball => Way::Ball,
    };
    let mut dof = Dof::new(name, way, axis, Vec3::ZERO);
    let mut note = None;
    let is_bounded = matches!(kind, JointType::Revolute | JointType::Prismatic);
    match element.child("limit") {
        Some(limit) if is_bounded => match range(&limit)? {
            Ok(range) => dof.range = range,
            Err(why) => note = Some(format!("joint {name}: {why}, it moves freely")),
        },
        None if is_bounded => {
            note = Some(format!("joint {name}: it has no limits, it moves freely"));
        }
        Some(limit) if kind == JointType::Continuous => {
            let bounds = (bound(&limit, "lower")?, bound(&limit, "upper")?);
            let [lower, upper] = [bounds.0.unwrap_or(0.0), bounds.1.unwrap_or(0.0)];
            if lower < upper {
                let why = "as a continuous joint it turns freely";
                note =
                    Some(format!("joint {name}: it has limits of {lower} and {upper}, but {why}"));
            }
        }
        _ => {}
    }
    if let Some(dynamics) = element.child("dynamics") {
        dof.spring = [0.0, 0.0, dynamics.at_least_zero("damping")?.unwrap_or(0.0)];
        dof.friction = dynamics.at_least_zero("friction")?.unwrap_or(0.0);
        if kind == JointType::Planar && dof.friction > 0.0 {
            note = Some(format!("joint {name}: the friction of a planar joint is left out"));
        }
    }
    let hold = match kind {
        JointType::Fixed => Hold::Fast,
        JointType::Floating => Hold::Free,
        // Drake's turns about x, then about y.
        JointType::Universal => {
            let turn = |axis: Vec3, name: &str| Dof { axis, name: name.to_owned(), ..dof.clone() };
            Hold::Joints(vec![turn(Vec3::X, name), turn(Vec3::Y, &format!("{name}/y"))])
        }
        _ => Hold::Joints(vec![dof]),
    };
    let mut mimic = None;
    if let Some(at) = element.child("mimic") {
        let ratio = at.number("multiplier")?.unwrap_or(1.0);
        mimic = Some((at.need("joint")?, ratio, at.number("offset")?.unwrap_or(0.0)));
    }
    let origin = origin(element)?;
    Ok(Joint { name, parent, child, origin, hold, note, mimic })
}

/// A direction; the file may give it any length.
fn direction(element: &Element<'_>, name: &str, v: Vec3) -> Result<Vec3, SceneError> {
    v.try_normalize().ok_or_else(|| element.wrong(name, "a direction that is not zero"))
}

impl JointType {
    /// Whether an axis matters to it; many files name one for joints that have none.
    const fn has_axis(self) -> bool {
        !matches!(self, Self::Fixed | Self::Floating | Self::Ball | Self::Universal)
    }
}

/// Least and greatest coordinate, if one of them is bounded; or why there are none.
fn range(limit: &Element<'_>) -> Result<Result<Option<[f32; 2]>, String>, SceneError> {
    let lower = bound(limit, "lower")?.unwrap_or(0.0);
    let upper = bound(limit, "upper")?.unwrap_or(0.0);
    if lower == f32::NEG_INFINITY && upper == f32::INFINITY {
        return Ok(Ok(None));
    }
    if lower < upper && lower < f32::INFINITY {
        return Ok(Ok(Some([lower, upper])));
    }
    Ok(Err(format!("its limits {lower} to {upper} leave no room")))
}
