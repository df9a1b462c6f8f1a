//! The elements of a robot's file, each by itself.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use drystone::geometry::MassProperties;
use drystone::math::Sym3;
use drystone::{Material, Pose, Quat, Shape, ShapeDef, Vec3};

use crate::error::SceneError;
use crate::links::{Dof, Hold, Hulls, Way};
use crate::read::xml::Element;

/// Kinds of joints.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum JointType {
    Fixed,
    Revolute,
    Continuous,
    Prismatic,
    Planar,
    Floating,
}

/// A joint as the file has it.
pub(super) struct Joint<'a> {
    pub(super) name: &'a str,
    pub(super) kind: JointType,
    pub(super) parent: usize,
    pub(super) child: usize,
    /// Where the child is [frame of the parent].
    pub(super) origin: Pose,
    pub(super) hold: Hold,
    pub(super) note: Option<String>,
    /// The joint that it follows: its name, multiplier and offset.
    pub(super) mimic: Option<(&'a str, f32, f32)>,
    /// True if effort or velocity is bounded.
    pub(super) has_motor_limits: bool,
}

/// A rotation by roll, pitch and yaw about fixed axes [rad].
fn rotation([roll, pitch, yaw]: [f32; 3]) -> Quat {
    let about = |axis: Vec3, angle: f32| Quat::from_axis_angle(axis, angle);
    (about(Vec3::Z, yaw) * about(Vec3::Y, pitch) * about(Vec3::X, roll)).normalized()
}

/// The `<origin>` of an element; without one, no shift.
fn origin(element: &Element<'_>) -> Result<Pose, SceneError> {
    let Some(at) = element.child("origin") else { return Ok(Pose::IDENTITY) };
    let position = at.vec3("xyz")?.unwrap_or(Vec3::ZERO);
    Ok(Pose::new(position, rotation(at.numbers("rpy")?.unwrap_or_default())))
}

pub(super) fn inertial(element: &Element<'_>) -> Result<MassProperties, SceneError> {
    let at = origin(element)?;
    let Some(mass) = element.child("mass") else {
        return Err(element.error("it has no <mass>", "one with a value"));
    };
    mass.need("value")?;
    let mass = mass.at_least_zero("value")?.unwrap_or(0.0);
    let mut inertia = Sym3::default();
    if let Some(i) = element.child("inertia") {
        let part = |name: &str| Ok::<f32, SceneError>(i.number(name)?.unwrap_or(0.0));
        for name in ["ixx", "iyy", "izz"] {
            i.at_least_zero(name)?;
        }
        inertia = Sym3 {
            xx: part("ixx")?,
            yy: part("iyy")?,
            zz: part("izz")?,
            xy: part("ixy")?,
            xz: part("ixz")?,
            yz: part("iyz")?,
        };
    }
    // A part by itself, turned into the link's axes.
    let own = MassProperties { mass, center: Vec3::ZERO, inertia };
    if mass > 0.0 {
        return Ok(MassProperties::combine(&[(at, own)]));
    }
    Ok(MassProperties { center: at.position, ..own })
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

/// A shape with a note, or why it is left out.
type Found = Result<(ShapeDef, Option<String>), String>;

pub(super) fn collision(
    element: &Element<'_>,
    folder: &Path,
    hulls: &mut Hulls,
) -> Result<Found, SceneError> {
    let mut at = origin(element)?;
    let shape = element.child("geometry").and_then(|g| g.children().next());
    let Some(shape) = shape else {
        return Err(element.error("it has no <geometry> with a shape", "one shape"));
    };
    let mut note = None;
    let made = match shape.tag() {
        "box" => {
            shape.need("size")?;
            let size = shape.vec3("size")?.unwrap_or(Vec3::ZERO);
            if size.min_element() <= 0.0 {
                return Err(shape.wrong("size", "three numbers above 0"));
            }
            Shape::box_half(size * 0.5)
        }
        "sphere" => Shape::sphere(shape.above_zero("radius")?),
        "cylinder" => {
            Shape::cylinder(0.5 * shape.above_zero("length")?, shape.above_zero("radius")?)
        }
        "capsule" => Shape::capsule(0.5 * shape.above_zero("length")?, shape.above_zero("radius")?),
        "mesh" => {
            let name = shape.need("filename")?;
            let scale = shape.vec3("scale")?.unwrap_or(Vec3::splat(1.0));
            if scale.abs().min_element() <= 0.0 {
                return Err(shape.wrong("scale", "three numbers that are not 0"));
            }
            let made = find(name, folder).and_then(|path| hulls.of_file(&path, scale));
            match made {
                Ok(hull) => {
                    note = Some(format!("mesh {name} collides as its hull"));
                    hull
                }
                Err(why) => return Ok(Err(format!("mesh {name}: {why}"))),
            }
        }
        other => return Ok(Err(format!("<{other}> is not known"))),
    };
    if matches!(made, Shape::Cylinder { .. } | Shape::Capsule { .. }) {
        // Along z there, along y here.
        at.rotation = at.rotation * Quat::from_axis_angle(Vec3::X, core::f32::consts::FRAC_PI_2);
    }
    made.validate().map_err(|e| shape.error(format!("{} is {}", e.field, e.value), e.allowed))?;
    Ok(Ok((ShapeDef::new(made).with_pose(at), note)))
}

/// The file that a name stands for: beside the robot's file, or in a folder above it that has the
/// package, or is the package.
fn find(name: &str, folder: &Path) -> Result<PathBuf, String> {
    let name = name.trim().replace('\\', "/");
    let name = name.as_str();
    let packaged = name.strip_prefix("package://").or_else(|| name.strip_prefix("model://"));
    let Some(packaged) = packaged else {
        let relative = name.strip_prefix("file://").unwrap_or(name);
        if relative.contains("://") {
            return Err("only files of this machine are read".to_owned());
        }
        // Joining with an absolute path gives that path alone.
        let path = folder.join(relative);
        return if path.is_file() { Ok(path) } else { Err("there is no such file".to_owned()) };
    };
    let inside = packaged.split_once('/').map_or(packaged, |(_, inside)| inside);
    let start = folder.canonicalize().map_err(|e| e.to_string())?;
    for above in start.ancestors().take(12) {
        for path in [above.join(packaged), above.join(inside)] {
            if path.is_file() {
                return Ok(path);
            }
        }
    }
    Err("no folder at or above the robot's file has it".to_owned())
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
        _ => {
            let allowed = "fixed, revolute, continuous, prismatic, planar or floating";
            return Err(element.wrong("type", allowed));
        }
    };
    let axis = match element.child("axis") {
        Some(at) => {
            at.need("xyz")?;
            let v = at.vec3("xyz")?.unwrap_or(Vec3::ZERO);
            // Many files name the axis of joints that have none.
            match direction(&at, "xyz", v) {
                Err(_) if matches!(kind, JointType::Fixed | JointType::Floating) => Vec3::X,
                other => other?,
            }
        }
        None => Vec3::X,
    };
    let way = match kind {
        JointType::Fixed | JointType::Floating | JointType::Planar => Way::Planar,
        JointType::Revolute | JointType::Continuous => Way::Hinge,
        JointType::Prismatic => Way::Slide,
    };
    let mut dof = Dof::new(name, way, axis, Vec3::ZERO);
    let mut note = None;
    let mut has_motor_limits = false;
    if let Some(limit) = element.child("limit") {
        for bound in ["effort", "velocity"] {
            has_motor_limits |= limit.at_least_zero(bound)?.is_some_and(|x| x > 0.0);
        }
        let lower = limit.number("lower")?.unwrap_or(0.0);
        let upper = limit.number("upper")?.unwrap_or(0.0);
        if matches!(kind, JointType::Revolute | JointType::Prismatic) {
            if lower < upper {
                dof.range = Some([lower, upper]);
            } else {
                note = Some(format!(
                    "joint {name}: its limits {lower} to {upper} leave no room, it moves freely"
                ));
            }
        }
    } else if matches!(kind, JointType::Revolute | JointType::Prismatic) {
        note = Some(format!("joint {name}: it has no limits, it moves freely"));
    }
    if let Some(dynamics) = element.child("dynamics") {
        dof.spring = [0.0, 0.0, dynamics.at_least_zero("damping")?.unwrap_or(0.0)];
        dof.friction = dynamics.at_least_zero("friction")?.unwrap_or(0.0);
    }
    let hold = match kind {
        JointType::Fixed => Hold::Fast,
        JointType::Floating => Hold::Free,
        _ => Hold::Joints(vec![dof]),
    };
    let mut mimic = None;
    if let Some(at) = element.child("mimic") {
        let ratio = at.number("multiplier")?.unwrap_or(1.0);
        mimic = Some((at.need("joint")?, ratio, at.number("offset")?.unwrap_or(0.0)));
    }
    let origin = origin(element)?;
    Ok(Joint { name, kind, parent, child, origin, hold, note, mimic, has_motor_limits })
}

/// A direction; the file may give it any length.
fn direction(element: &Element<'_>, name: &str, v: Vec3) -> Result<Vec3, SceneError> {
    v.try_normalize().ok_or_else(|| element.wrong(name, "a direction that is not zero"))
}
