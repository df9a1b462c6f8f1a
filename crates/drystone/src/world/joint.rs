//! A joint as the user sees it.

use crate::base::id::{BodyId, JointId};
use crate::base::math::Vec3;
use crate::state::def::JointKind;
use crate::state::joints::Joint;
use crate::state::tables::Tables;

/// A joint, to read.
#[derive(Clone, Copy, Debug)]
pub struct JointRef<'w> {
    tables: &'w Tables,
    joint: &'w Joint,
    id: JointId,
}

impl<'w> JointRef<'w> {
    pub(super) fn new(tables: &'w Tables, id: JointId) -> Option<Self> {
        let row = tables.joints.rows.row(id)?;
        Some(Self { tables, joint: tables.joints.at(row), id })
    }

    /// Its id.
    #[must_use]
    pub const fn id(&self) -> JointId {
        self.id
    }

    /// What it does.
    #[must_use]
    pub const fn kind(&self) -> JointKind {
        self.joint.kind
    }

    /// Its first body.
    #[must_use]
    pub fn body_a(&self) -> BodyId {
        self.tables.bodies.id(self.joint.body_a)
    }

    /// Its second body.
    #[must_use]
    pub fn body_b(&self) -> BodyId {
        self.tables.bodies.id(self.joint.body_b)
    }

    /// Where its anchor on the first body is [m, world].
    #[must_use]
    pub fn anchor_a(&self) -> Vec3 {
        let body = self.tables.bodies.at(self.joint.body_a);
        body.center + body.rotation.rotate(self.joint.anchor_a)
    }

    /// Where its anchor on the second body is [m, world].
    #[must_use]
    pub fn anchor_b(&self) -> Vec3 {
        let body = self.tables.bodies.at(self.joint.body_b);
        body.center + body.rotation.rotate(self.joint.anchor_b)
    }

    /// How far it is from what it asks [m]: the gap of a ball joint, the excess of a distance.
    #[must_use]
    pub fn error(&self) -> f32 {
        self.joint.error(&self.tables.bodies)
    }
}
