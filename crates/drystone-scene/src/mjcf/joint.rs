//! Joints, and the mass that a body is given.

use drystone::geometry::MassProperties;
use drystone::math::Sym3;
use drystone::{Pose, Vec3};

use super::defaults::View;
use super::model::Model;
use super::option::Options;
use crate::error::SceneError;
use crate::links::{Dof, Way};

/// A joint, or the lack of any.
pub(super) enum Read {
    Free,
    Joint(Dof),
}

/// A joint of a body, `pose` being that of the frame around it on the body.
pub(super) fn read<'a>(
    view: &View<'a>,
    model: &Model<'a>,
    option: &Options,
    pose: &Pose,
    name: &str,
) -> Result<Read, SceneError> {
    let way = match view.get("type").unwrap_or("hinge") {
        _ if view.element().tag() == "freejoint" => return Ok(Read::Free),
        "free" => return Ok(Read::Free),
        "hinge" => Way::Hinge,
        "slide" => Way::Slide,
        "ball" => Way::Ball,
        _ => return Err(view.wrong("type", "free, ball, slide or hinge")),
    };
    let axis = view.vec3("axis")?.unwrap_or(Vec3::Z);
    let Some(axis) = axis.try_normalize() else {
        return Err(view.wrong("axis", "a direction that is not zero"));
    };
    let anchor = pose.point(view.vec3("pos")?.unwrap_or(Vec3::ZERO));
    let mut dof = Dof::new(name, way, pose.direction(axis), anchor);
    let turns = |x: f32| if way == Way::Slide { x } else { model.radians(x) };
    let rest = turns(view.number("ref")?.unwrap_or(0.0));
    dof.reference = rest;
    let range = view.numbers::<2>("range")?;
    if view.is_limited(model.settings.autolimits)? && option.limits {
        let Some([min, max]) = range else {
            return Err(view.wrong("limited", "a range with it"));
        };
        // A range that leaves no room is none, unless the file insists.
        if min < max || (way == Way::Ball && max > 0.0) {
            dof.range = Some([turns(min) - rest, turns(max) - rest]);
        } else if view.get("limited") == Some("true") {
            return Err(view.wrong("range", "two numbers, the first below the second"));
        }
    }
    let (stiffness, damping) = (view.list("stiffness", 8)?, view.list("damping", 8)?);
    // A negative one, which would feed the motion, is taken as 0 and named as not read.
    let first = |list: &[f32]| list.first().map_or(0.0, |x| x.max(0.0));
    let (stiffness, damping) = (first(&stiffness), first(&damping));
    if option.springs {
        let loose = turns(view.number("springref")?.unwrap_or(0.0));
        dof.spring = [loose - rest, stiffness, damping];
    }
    dof.armature = view.at_least_zero("armature")?;
    if option.friction {
        dof.friction = view.at_least_zero("frictionloss")?;
    }
    Ok(Read::Joint(dof))
}

/// The mass that `<inertial>` gives [frame of the body].
pub(super) fn inertial<'a>(
    view: &View<'a>,
    model: &Model<'a>,
) -> Result<MassProperties, SceneError> {
    let element = view.element();
    let at = model.pose(view)?;
    element.need("mass")?;
    let mass = element.at_least_zero("mass")?.unwrap_or(0.0);
    let diagonal = element.vec3("diaginertia")?;
    let full = element.numbers::<6>("fullinertia")?;
    let inertia = match (diagonal, full) {
        (Some(d), None) => Sym3::diagonal(d),
        (None, Some([xx, yy, zz, xy, xz, yz])) => Sym3 { xx, yy, zz, xy, xz, yz },
        _ => return Err(element.error("its inertia is not clear", "diaginertia or fullinertia")),
    };
    let own = MassProperties { mass, center: Vec3::ZERO, inertia };
    Ok(MassProperties::combine(&[(at, own)]))
}
