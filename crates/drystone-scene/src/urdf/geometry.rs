//! The shapes of links, and the files of meshes.

use std::path::{Path, PathBuf};

use drystone::{Pose, Quat, Shape, ShapeDef, Vec3};

use super::element::{list, origin, triple};
use crate::error::SceneError;
use crate::links::Hulls;
use crate::read::ending;
use crate::read::xml::Element;

/// Lengths below this are those of a marker, which marks a place and touches nothing [m].
const SMALLEST: f32 = 1.0e-5;

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
        "mesh" => {
            let name = shape.need("filename")?;
            let scale = scale(&shape)?;
            let made = find(name, folder).and_then(|path| match ending(&path).as_str() {
                "dae" => Err("COLLADA is not read, a .stl or .obj of the same mesh is".to_owned()),
                _ => hulls.of_file(&path, scale),
            });
            match made {
                Ok(hull) => {
                    note = Some(format!("mesh {name} collides as its hull"));
                    hull
                }
                Err(why) => return Ok(Err(format!("mesh {name}: {why}"))),
            }
        }
        "plane" => {
            let normal = triple(&shape, "normal")?.map_or(Vec3::Z, Vec3::from);
            let Some(normal) = normal.try_normalize() else {
                return Err(shape.wrong("normal", "a direction that is not zero"));
            };
            // A half-space has no place of its own.
            let normal = at.direction(normal);
            let offset = normal.dot(at.position);
            at = Pose::IDENTITY;
            Shape::HalfSpace { normal, offset }
        }
        _ => match primitive(&shape)? {
            Ok(made) => made,
            Err(why) => return Ok(Err(why)),
        },
    };
    if matches!(made, Shape::Cylinder { .. } | Shape::Capsule { .. }) {
        // Along z there, along y here.
        at.rotation = at.rotation * Quat::from_axis_angle(Vec3::X, core::f32::consts::FRAC_PI_2);
    }
    made.validate().map_err(|e| shape.error(format!("{} is {}", e.field, e.value), e.allowed))?;
    Ok(Ok((ShapeDef::new(made).with_pose(at), note)))
}

/// A shape of few numbers, or why it is left out.
fn primitive(shape: &Element<'_>) -> Result<Result<Shape, String>, SceneError> {
    let length = |name: &str| {
        shape.need(name)?;
        Ok::<f32, SceneError>(shape.at_least_zero(name)?.unwrap_or(0.0))
    };
    let (made, smallest) = match shape.tag() {
        "box" => {
            shape.need("size")?;
            let size = triple(shape, "size")?.map_or(Vec3::ZERO, Vec3::from);
            if size.min_element() < 0.0 {
                return Err(shape.wrong("size", "three numbers of at least 0"));
            }
            (Shape::box_half(size * 0.5), size.min_element())
        }
        "sphere" => {
            let radius = length("radius")?;
            (Shape::sphere(radius), radius)
        }
        "cylinder" => {
            let (length, radius) = (length("length")?, length("radius")?);
            (Shape::cylinder(0.5 * length, radius), length.min(radius))
        }
        "capsule" => {
            let (length, radius) = (length("length")?, length("radius")?);
            (Shape::capsule(0.5 * length, radius), radius)
        }
        _ => return Ok(Err(format!("<{}> is not read", shape.full_tag()))),
    };
    if smallest < 2.0 * SMALLEST {
        let sides = ["size", "radius", "length"].iter();
        let sides: Vec<String> =
            sides.filter_map(|name| Some(format!("{name}=\"{}\"", shape.get(name)?))).collect();
        return Ok(Err(format!("a {} of {} has no size", shape.tag(), sides.join(" "))));
    }
    Ok(Ok(made))
}

/// The scale of a mesh; one number is that of all axes, as PyBullet reads it.
fn scale(shape: &Element<'_>) -> Result<Vec3, SceneError> {
    let scale = match list(shape, "scale")?[..] {
        _ if shape.get("scale").is_none() => Vec3::splat(1.0),
        [all] => Vec3::splat(all),
        _ => triple(shape, "scale")?.map_or(Vec3::splat(1.0), Vec3::from),
    };
    if scale.abs().min_element() <= 0.0 {
        return Err(shape.wrong("scale", "three numbers that are not 0"));
    }
    Ok(scale)
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
