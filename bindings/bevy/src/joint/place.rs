//! The ends of a joint.

use bevy_ecs::entity::Entity;
use bevy_math::{Quat, Vec3};
use bevy_reflect::Reflect;
use drystone::JointDef;

use crate::convert::{to_quat, to_vec};

/// The two bodies of a joint, and its place on them.
#[derive(Clone, Copy, Debug, PartialEq, Reflect)]
pub struct JointEnds {
    /// Entity of the first body.
    pub body1: Entity,
    /// Entity of the second body.
    pub body2: Entity,
    /// Its place.
    pub place: JointPlace,
}

/// The place of a joint on its bodies. Its axis is the pin of a revolute joint, the rail of a
/// prismatic one, and the limb of a spherical one with limits.
#[derive(Clone, Copy, Debug, PartialEq, Reflect)]
pub enum JointPlace {
    /// A point in the world for each body, for the poses of the bodies when the joint is made. It
    /// then stays on the bodies.
    World {
        /// Point on the first body [m, world].
        point1: Vec3,
        /// Point on the second body [m, world].
        point2: Vec3,
        /// Direction of the axis [world, any length].
        axis: Vec3,
    },
    /// A frame on each body. Its x axis is the axis of the joint.
    Local {
        /// Anchor on the first body [m, frame of the body, unscaled].
        anchor1: Vec3,
        /// Anchor on the second body [m, frame of the body, unscaled].
        anchor2: Vec3,
        /// Rotation of the joint's frame on the first body.
        rotation1: Quat,
        /// Rotation of the joint's frame on the second body.
        rotation2: Quat,
    },
}

impl JointEnds {
    /// A joint at the origins of two bodies.
    #[must_use]
    pub const fn new(body1: Entity, body2: Entity) -> Self {
        let (anchor1, anchor2) = (Vec3::ZERO, Vec3::ZERO);
        let (rotation1, rotation2) = (Quat::IDENTITY, Quat::IDENTITY);
        Self { body1, body2, place: JointPlace::Local { anchor1, anchor2, rotation1, rotation2 } }
    }

    /// At a point for each body [m, world].
    pub(super) fn between(&mut self, point1: Vec3, point2: Vec3) {
        let axis = match self.place {
            JointPlace::World { axis, .. } => axis,
            JointPlace::Local { .. } => Vec3::X,
        };
        self.place = JointPlace::World { point1, point2, axis };
    }

    /// With its axis in this direction [world].
    pub(super) fn turn(&mut self, to: Vec3) {
        match &mut self.place {
            JointPlace::World { axis, .. } => *axis = to,
            JointPlace::Local { rotation1, rotation2, .. } => {
                let turn = drystone::Quat::from_arc(
                    drystone::Vec3::X,
                    to_vec(to).normalize_or(drystone::Vec3::X),
                );
                (*rotation1, *rotation2) =
                    (crate::convert::from_quat(turn), crate::convert::from_quat(turn));
            }
        }
    }

    /// With these anchors [m, frame of each body].
    pub(super) fn anchor(&mut self, first: Vec3, second: Vec3) {
        let (rotation1, rotation2) = match self.place {
            JointPlace::Local { rotation1, rotation2, .. } => (rotation1, rotation2),
            JointPlace::World { .. } => (Quat::IDENTITY, Quat::IDENTITY),
        };
        self.place = JointPlace::Local { anchor1: first, anchor2: second, rotation1, rotation2 };
    }

    /// The definition at this place.
    pub(super) fn place(&self, def: JointDef) -> JointDef {
        match self.place {
            JointPlace::World { point1, point2, axis } => {
                def.with_axis(to_vec(axis)).between(to_vec(point1), to_vec(point2))
            }
            JointPlace::Local { anchor1, anchor2, rotation1, rotation2 } => def
                .with_anchors(to_vec(anchor1), to_vec(anchor2))
                .with_frames(to_quat(rotation1), to_quat(rotation2)),
        }
    }
}
