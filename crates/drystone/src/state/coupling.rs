//! Couplings: a coordinate of one joint follows a coordinate of another, as in gears, racks and
//! coupled fingers.

#[cfg(feature = "serde")]
use serde::{Deserialize, Serialize};

use super::bodies::Bodies;
use super::def::DefError;
use super::def::axis::Axis;
use super::def::check::within;
use super::def::six_dof::{JointMotion, SixDof};
use super::joints::{Joint, JointModel, Joints};
use super::six_dof::SixDofJoint;
use crate::base::id::JointId;
use crate::base::limits;

/// Holds `coordinate b = ratio · coordinate a + offset` between coordinates of joints of six axes
/// ([`crate::JointRef::coordinates`]). It acts on the bodies of both joints, including those of the
/// first.
///
/// ```
/// use drystone::joint::{CouplingDef, Hinge};
/// use drystone::{BodyDef, JointDef, ShapeDef, World};
///
/// # fn main() -> Result<(), drystone::DefError> {
/// let mut world = World::default();
/// let post = world.add_body(BodyDef::fixed())?;
/// let mut wheel = |x| {
///     let disc = BodyDef::dynamic().with_position([x, 0.0, 0.0]);
///     let disc = world.add_body(disc.with_shape(ShapeDef::sphere(0.5)))?;
///     let axle = JointDef::new(post, disc, Hinge::new()).at([x, 0.0, 0.0]);
///     world.add_joint(axle.with_axis([0.0, 0.0, 1.0]))
/// };
/// let (first, second) = (wheel(0.0)?, wheel(1.0)?);
/// // Their rims meet: they turn against each other, the second half as fast.
/// world.add_coupling(CouplingDef::gear(first, second, -0.5))?;
/// # Ok(())
/// # }
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
pub struct CouplingDef {
    /// The driving joint.
    pub joint_a: JointId,
    /// Its axis.
    pub axis_a: Axis,
    /// The driven joint. It may be the same joint with another axis, which makes a screw.
    pub joint_b: JointId,
    /// Its axis.
    pub axis_b: Axis,
    /// Change of b per unit of a [m or rad, per m or rad]; magnitude 1e-6 to 1e6.
    pub ratio: f32,
    /// Value of b when a is 0 [m or rad].
    pub offset: f32,
}

impl CouplingDef {
    /// Gears: hinge b turns `ratio` times as far as hinge a. For wheels that touch at their rims,
    /// with both axes in the same direction, the ratio is -radius a / radius b.
    #[must_use]
    pub const fn gear(joint_a: JointId, joint_b: JointId, ratio: f32) -> Self {
        Self { joint_a, axis_a: Axis::TurnX, joint_b, axis_b: Axis::TurnX, ratio, offset: 0.0 }
    }

    /// Rack and pinion: the slider moves by the pinion's radius [m] for each radian of the hinge.
    #[must_use]
    pub const fn rack(hinge: JointId, slider: JointId, radius: f32) -> Self {
        Self {
            joint_a: hinge,
            axis_a: Axis::TurnX,
            joint_b: slider,
            axis_b: Axis::X,
            ratio: radius,
            offset: 0.0,
        }
    }

    /// Checks every field. The world checks whether the joints exist and have such axes.
    ///
    /// # Errors
    /// The first field that is out of range.
    pub fn validate(&self) -> Result<(), DefError> {
        if self.joint_a == self.joint_b && self.axis_a == self.axis_b {
            return Err(DefError::new(
                "axis_b",
                self.axis_b,
                "an axis or joint other than that of `a`",
            ));
        }
        if !(1.0e-6..=1.0e6).contains(&self.ratio.abs()) {
            return Err(DefError::new("ratio", self.ratio, "a number of magnitude 1e-6 to 1e6"));
        }
        within("offset", self.offset, &limits::TARGET)
    }
}

/// A coupling in the tables.
#[derive(Clone, Debug)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
pub(crate) struct Coupling {
    pub(crate) def: CouplingDef,
    /// Impulse of a substep along b [N s; N m s].
    pub(crate) impulse: f32,
}

impl CouplingDef {
    /// The constraint value C for these coordinates [m or rad]. It is computed in f64: the angles
    /// of gears reach hundreds of radians, and their rounding in f32 would act as a load.
    pub(crate) fn excess(&self, a: f64, b: f64) -> f32 {
        let c = b - f64::from(self.ratio) * a - f64::from(self.offset);
        #[expect(clippy::cast_possible_truncation, reason = "a small difference")]
        let c = c as f32;
        c
    }
}

impl Coupling {
    /// Deviation of b from its target [m or rad].
    pub(crate) fn error(&self, joints: &Joints, bodies: &Bodies) -> f32 {
        let at = |id: JointId, axis: Axis| {
            let joint = joints.at(joints.rows.row(id)?);
            let JointModel::SixDof(six_dof) = &joint.model else { return None };
            Some(coordinate(joint, six_dof, bodies, axis.index()))
        };
        let (a, b) = (at(self.def.joint_a, self.def.axis_a), at(self.def.joint_b, self.def.axis_b));
        a.zip(b).map_or(0.0, |(a, b)| self.def.excess(a, b))
    }
}

/// A coordinate of a joint [m or rad], with full turns counted exactly.
pub(crate) fn coordinate(
    joint: &Joint,
    six_dof: &SixDofJoint,
    bodies: &Bodies,
    axis: usize,
) -> f64 {
    let (a, b) = (bodies.at(joint.body_a), bodies.at(joint.body_b));
    if axis < 3 {
        let gap = (b.center + b.rotation.rotate(joint.anchor_b))
            - (a.center + a.rotation.rotate(joint.anchor_a));
        let gap = (a.rotation * six_dof.def.frame_a).unrotate(gap);
        return f64::from([gap.x, gap.y, gap.z][axis]);
    }
    let wound = six_dof.joint_angles(a.rotation, b.rotation).angles[axis - 3];
    let frames = [a.rotation * six_dof.def.frame_a, b.rotation * six_dof.def.frame_b];
    let within = six_dof.def.joint_angles(frames[0], frames[1], [0.0; 3]).angles[axis - 3];
    let turn = 2.0 * core::f64::consts::PI;
    f64::from(within) + turn * ((f64::from(wound) - f64::from(within)) / turn).round()
}

/// Checks that an axis of a joint can be coupled.
pub(crate) fn check_axis(name: &str, def: &SixDof, axis: Axis) -> Result<(), DefError> {
    let at = def.axis(axis);
    let allowed = "an axis that is not locked, on a joint without a cone";
    let is_free = at.locked_at().is_none() && at.motion != JointMotion::Locked;
    if is_free && (!matches!(axis, Axis::TurnY | Axis::TurnZ) || def.cone.is_none()) {
        return Ok(());
    }
    Err(DefError::new(name, axis, allowed))
}
