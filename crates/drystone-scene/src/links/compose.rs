//! From the joints of a link, one after the other, to as few joints of six axes as say the same.
//!
//! Slides at right angles and then hinges at right angles through one point are one joint. One or
//! two hinges are exact; three become a ball whose swing takes the first two. A joint that does not
//! fit begins another stage, with a body in between.

use core::f32::consts::PI;

use drystone::joint::{JointAxis, JointDrive, JointMotion, JointSpring, Planar, SixDof};
use drystone::math::Mat3;
use drystone::{Axis, JointKind, Quat, Vec3};

use super::link::{Dof, Way};

/// Joints that act as one.
#[derive(Clone, Debug)]
pub(crate) struct Stage {
    /// Where they are [m, frame of the link].
    pub(crate) anchor: Vec3,
    /// Their kind, with both frames as seen from the link at rest.
    pub(crate) kind: JointKind,
    /// Name of the last of them.
    pub(crate) last: String,
    /// Axis and sign of the coordinate of each of them, by its name: 0 to 2 motions, 3 to 5 turns.
    /// None of balls.
    pub(crate) coordinates: Vec<(String, Axis, f32, f32)>,
}

/// The stages of a link's joints; approximations are noted in `notes`.
pub(crate) fn stages(dofs: &[Dof], notes: &mut Vec<String>) -> Vec<Stage> {
    let mut out = Vec::new();
    let mut rest = dofs;
    while !rest.is_empty() {
        let count = fitting(rest);
        out.push(stage(&rest[..count], notes));
        rest = &rest[count..];
    }
    out
}

fn is_square(a: Vec3, b: Vec3) -> bool {
    a.dot(b).abs() < 1.0e-4
}

fn is_parallel(a: Vec3, b: Vec3) -> bool {
    a.dot(b).abs() > 1.0 - 1.0e-6
}

/// How many of the joints, at least one, fit into one joint of six axes.
fn fitting(dofs: &[Dof]) -> usize {
    if !matches!(dofs[0].way, Way::Hinge | Way::Slide) {
        return 1;
    }
    let mut count = 0;
    while count < dofs.len().min(6) {
        let (before, next) = (&dofs[..count], &dofs[count]);
        let fits = match next.way {
            Way::Slide => {
                count < 3
                    && before.iter().all(|d| d.way == Way::Slide && is_square(d.axis, next.axis))
            }
            Way::Hinge => {
                let mut hinges = before.iter().filter(|d| d.way == Way::Hinge);
                hinges.all(|d| is_square(d.axis, next.axis) && d.anchor == next.anchor)
            }
            Way::Ball | Way::Planar => false,
        };
        if !fits || frame(&dofs[..=count]).is_none() {
            break;
        }
        count += 1;
    }
    count.max(1)
}

/// Axes of a joint to which every one of these is parallel, ordered as the engine counts angles.
fn frame(dofs: &[Dof]) -> Option<Mat3> {
    let of = |way: Way| dofs.iter().filter(move |d| d.way == way).map(|d| d.axis);
    let (hinges, slides): (Vec<Vec3>, Vec<Vec3>) =
        (of(Way::Hinge).collect(), of(Way::Slide).collect());
    let (x, y) = match hinges[..] {
        // The turn next to the second body is the twist, the others are its swing.
        [first, _, third] => (third, first),
        [first, second] => (first, second),
        [x] => {
            let across = slides.iter().copied().find(|s| !is_parallel(*s, x));
            (x, across.unwrap_or_else(|| x.any_perpendicular()))
        }
        _ => match slides[..] {
            [x] => (x, x.any_perpendicular()),
            [x, y, ..] => (x, y),
            [] => return None,
        },
    };
    let x = x.try_normalize()?;
    let y = (y - x * x.dot(y)).try_normalize()?;
    let axes = Mat3 { x, y, z: x.cross(y) };
    let aligned = |u: &Vec3| [axes.x, axes.y, axes.z].iter().any(|a| a.dot(*u).abs() > 0.9999);
    dofs.iter().map(|d| d.axis).all(|u| aligned(&u)).then_some(axes)
}

/// One joint for these.
fn stage(dofs: &[Dof], notes: &mut Vec<String>) -> Stage {
    let last = &dofs[dofs.len() - 1];
    let (anchor, name) = (last.anchor, last.name.clone());
    let mut coordinates = Vec::new();
    let kind = match last.way {
        Way::Ball => ball(last, notes),
        Way::Planar => planar(last),
        Way::Hinge | Way::Slide => aligned(dofs, notes, &mut coordinates),
    };
    Stage { anchor, kind, last: name, coordinates }
}

pub(super) const FREE: SixDof =
    SixDof { linear: [JointAxis::FREE; 3], angular: [JointAxis::FREE; 3], ..SixDof::FIXED };

fn with_frame(axes: SixDof, frame: Quat) -> JointKind {
    JointKind::SixDof(SixDof { frame_a: frame, frame_b: frame, ..axes })
}

/// Axes with x along the joint's.
fn along(axis: Vec3) -> Quat {
    Quat::from_arc(Vec3::X, axis)
}

/// Hinges and slides along the axes of one frame.
fn aligned(
    dofs: &[Dof],
    notes: &mut Vec<String>,
    coordinates: &mut Vec<(String, Axis, f32, f32)>,
) -> JointKind {
    let last = &dofs[dofs.len() - 1];
    let axes = frame(dofs);
    let turn = axes.map_or_else(|| along(last.axis), |m| Quat::from_mat3(m).normalized());
    let m = turn.to_mat3();
    let hinges = dofs.iter().filter(|d| d.way == Way::Hinge).count();
    let mut six = SixDof::FIXED;
    for dof in dofs {
        let dots = [m.x, m.y, m.z].map(|a| a.dot(dof.axis));
        let i = (0..3).max_by(|&a, &b| dots[a].abs().total_cmp(&dots[b].abs())).unwrap_or(0);
        let sign = if dots[i] < 0.0 { -1.0 } else { 1.0 };
        let is_turn = dof.way == Way::Hinge;
        let named = Axis::ALL[if is_turn { i + 3 } else { i }];
        coordinates.push((dof.name.clone(), named, sign, dof.reference));
        let motion = match dof.range {
            None => JointMotion::Free,
            Some([min, max]) => {
                let (min, max) = if sign < 0.0 { (-max, -min) } else { (min, max) };
                JointMotion::Limited { min, max, spring: None }
            }
        };
        let axis = JointAxis { motion, drive: dof.drive(sign), friction: dof.friction };
        six = six.with_axis(named, axis);
    }
    if hinges == 3 {
        let names: Vec<&str> = dofs.iter().map(|d| d.name.as_str()).collect();
        notes.push(format!(
            "joints {}: taken as one ball joint with these limits and springs; the angles of the first two are \
             those of its swing, which differ from the file's by up to half their product",
            names.join(", ")
        ));
    }
    with_frame(six, turn)
}

fn ball(dof: &Dof, notes: &mut Vec<String>) -> JointKind {
    let drive = dof.drive(1.0).map(|d| JointDrive { position: 0.0, ..d });
    let axis = JointAxis { motion: JointMotion::Free, drive, friction: dof.friction };
    if axis == JointAxis::FREE && dof.range.is_none() {
        return JointKind::Ball;
    }
    let mut six = SixDof { angular: [axis; 3], ..SixDof::FIXED };
    if let Some([_, max]) = dof.range
        && max < PI
    {
        notes.push(format!(
            "joint {}: the limit of its whole turn is taken as one of its swing and one of its twist",
            dof.name
        ));
        six.cone = Some(drystone::joint::JointCone { swing: [max; 2], spring: None });
        six.angular[0].motion = JointMotion::Limited { min: -max, max, spring: None };
    }
    with_frame(six, along(dof.axis))
}

fn planar(dof: &Dof) -> JointKind {
    let mut six = Planar::new().six_dof();
    let [_, _, damping] = dof.spring;
    if damping > 0.0 {
        let damped = JointAxis::driven(JointDrive::servo(
            0.0,
            JointSpring::new(0.0, damping),
            f32::INFINITY,
        ));
        six.linear = [JointAxis::LOCKED, damped, damped];
        six.angular[0] = damped;
    }
    with_frame(six, along(dof.axis))
}
