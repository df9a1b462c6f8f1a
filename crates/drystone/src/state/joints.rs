//! Joints: one row each. Impulses are written by the solver.

use core::mem::replace;

#[cfg(feature = "serde")]
use serde::{Deserialize, Serialize};

use super::bodies::Bodies;
use super::colors::Place;
use super::coupling::Coupling;
use super::def::{JointKind, JointStrength, Pulley, Spring};
use super::six_dof::{SixDofJoint, SixDofState};
use crate::base::id::JointId;
use crate::base::math::{Vec3, bounded, vec3};
use crate::base::slot_map::SlotMap;

/// The kind of a joint with its runtime data. Joints of six axes store theirs in a box.
#[derive(Debug)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
pub(crate) enum JointModel {
    Ball,
    Distance {
        min: f32,
        max: f32,
        spring: Option<Spring>,
    },
    SixDof(Box<SixDofJoint>),
    Coupling(Box<Coupling>),
    Pulley(Box<Pulley>),
    /// A link of an articulation and its parent; the articulation solves it.
    Link,
}

impl Clone for JointModel {
    fn clone(&self) -> Self {
        match self {
            Self::Ball => Self::Ball,
            Self::Link => Self::Link,
            Self::Distance { min, max, spring } => {
                Self::Distance { min: *min, max: *max, spring: *spring }
            }
            Self::SixDof(six_dof) => Self::SixDof(six_dof.clone()),
            Self::Coupling(coupling) => Self::Coupling(coupling.clone()),
            Self::Pulley(pulley) => Self::Pulley(pulley.clone()),
        }
    }

    /// Reuses the existing box, if it has this kind.
    fn clone_from(&mut self, from: &Self) {
        match (&mut *self, from) {
            (Self::SixDof(to), Self::SixDof(from)) => to.clone_from(from),
            (Self::Coupling(to), Self::Coupling(from)) => to.clone_from(from),
            (Self::Pulley(to), Self::Pulley(from)) => to.clone_from(from),
            _ => *self = from.clone(),
        }
    }
}

impl JointModel {
    pub(crate) fn new(kind: JointKind) -> Self {
        match kind {
            JointKind::Ball => Self::Ball,
            JointKind::Link => Self::Link,
            JointKind::Distance { min, max, spring } => Self::Distance { min, max, spring },
            JointKind::SixDof(def) => Self::SixDof(Box::new(SixDofJoint::new(def))),
            JointKind::Pulley(def) => Self::Pulley(Box::new(def)),
            JointKind::Coupling(def) => Self::Coupling(Box::new(Coupling { def, impulse: 0.0 })),
        }
    }

    pub(crate) fn kind(&self) -> JointKind {
        match self {
            Self::Ball => JointKind::Ball,
            Self::Link => JointKind::Link,
            Self::Distance { min, max, spring } => {
                JointKind::Distance { min: *min, max: *max, spring: *spring }
            }
            Self::SixDof(six_dof) => JointKind::SixDof(six_dof.def),
            Self::Pulley(pulley) => JointKind::Pulley(**pulley),
            Self::Coupling(coupling) => JointKind::Coupling(coupling.def),
        }
    }
}

/// Whether a joint is enabled.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
pub(crate) enum Switch {
    On,
    Off,
}

/// A joint.
#[derive(Debug)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
pub(crate) struct Joint {
    pub(crate) body_a: u32,
    pub(crate) body_b: u32,
    /// Anchors [m, frame of the body's center of mass].
    pub(crate) anchor_a: Vec3,
    pub(crate) anchor_b: Vec3,
    pub(crate) model: JointModel,
    pub(crate) collide_connected: bool,
    pub(crate) switch: Switch,
    pub(crate) user_data: u64,
    /// Accumulated impulse of a substep. For a ball joint: a vector [N s, world]. For a distance
    /// joint: lower limit, upper limit and spring. For a pulley: x along its length, negative where
    /// it pulls.
    pub(crate) impulse: Vec3,
    /// Whether it is currently solved directly with its tree; and whether its definition requests
    /// that.
    pub(crate) is_direct: bool,
    pub(crate) articulated: bool,
    pub(crate) strength: Option<JointStrength>,
    /// Impulses on B in the last step [N s, N m s, world]; known while something can break.
    pub(crate) given: [Vec3; 2],
    /// Maximum impulse magnitudes of a substep in the last step [N s, N m s]; known while something
    /// can break.
    pub(crate) peak: [f32; 2],
    /// Fatigue damage; the joint breaks at 1.
    pub(crate) damage: f32,
    pub(crate) place: Place,
}

impl Clone for Joint {
    fn clone(&self) -> Self {
        Self { model: self.model.clone(), ..*self }
    }

    fn clone_from(&mut self, from: &Self) {
        let mut model = replace(&mut self.model, JointModel::Ball);
        model.clone_from(&from.model);
        *self = Self { model, ..*from };
    }
}

impl Joint {
    /// A joint between the centers of two bodies that has done nothing yet. Its bodies collide.
    pub(crate) const fn new(body_a: u32, body_b: u32, model: JointModel) -> Self {
        Self {
            body_a,
            body_b,
            anchor_a: Vec3::ZERO,
            anchor_b: Vec3::ZERO,
            model,
            collide_connected: true,
            switch: Switch::On,
            user_data: 0,
            impulse: Vec3::ZERO,
            given: [Vec3::ZERO; 2],
            peak: [0.0; 2],
            damage: 0.0,
            is_direct: false,
            articulated: false,
            strength: None,
            place: Place::NOWHERE,
        }
    }

    /// False if it is disabled.
    pub(crate) fn is_on(&self) -> bool {
        self.switch == Switch::On
    }

    /// True if it acts on nothing: it is disabled, or it can move neither of its bodies.
    pub(crate) fn is_idle(&self, bodies: &Bodies) -> bool {
        let (a, b) = (bodies.at(self.body_a), bodies.at(self.body_b));
        !self.is_on() || a.out || b.out || !(a.is_dynamic() || b.is_dynamic())
    }

    /// False if a number that it stores between steps is not finite.
    pub(crate) fn is_finite(&self) -> bool {
        let kept = [self.impulse, self.given[0], self.given[1]];
        let own = match &self.model {
            JointModel::SixDof(six_dof) => six_dof.state.is_finite(),
            JointModel::Coupling(coupling) => coupling.impulse.is_finite(),
            JointModel::Ball
            | JointModel::Distance { .. }
            | JointModel::Pulley(_)
            | JointModel::Link => true,
        };
        let numbers = [self.peak[0], self.peak[1], self.damage];
        own && kept.iter().all(|v| v.is_finite()) && numbers.iter().all(|x| x.is_finite())
    }

    /// Clears its impulses. Its fatigue damage stays.
    pub(crate) fn forget(&mut self) {
        (self.impulse, self.given, self.peak) = (Vec3::ZERO, [Vec3::ZERO; 2], [0.0; 2]);
        match &mut self.model {
            JointModel::SixDof(six_dof) => six_dof.state = SixDofState::IDLE,
            JointModel::Coupling(coupling) => coupling.impulse = 0.0,
            JointModel::Ball
            | JointModel::Distance { .. }
            | JointModel::Pulley(_)
            | JointModel::Link => {}
        }
        self.damage = bounded(self.damage);
    }

    /// Constraint error [m].
    pub(crate) fn error(&self, bodies: &Bodies) -> f32 {
        let (a, b) = (bodies.at(self.body_a), bodies.at(self.body_b));
        let p_a = a.center + a.rotation.rotate(self.anchor_a);
        let p_b = b.center + b.rotation.rotate(self.anchor_b);
        let distance = (p_b - p_a).length();
        match &self.model {
            JointModel::Ball => distance,
            JointModel::SixDof(six_dof) => {
                let gap = (a.rotation * six_dof.def.frame_a).unrotate(p_b - p_a);
                six_dof.def.linear_excess(gap)
            }
            JointModel::Distance { min, max, .. } => (min - distance).max(distance - max).max(0.0),
            JointModel::Pulley(pulley) => {
                let excess = pulley.excess([p_a, p_b]);
                if pulley.is_rigid { excess.abs() } else { excess.max(0.0) }
            }
            // The error depends on other joints: see Coupling::error.
            JointModel::Coupling(_) => 0.0,
            // Reduced coordinates cannot drift.
            JointModel::Link => 0.0,
        }
    }

    /// Angular constraint error [rad].
    pub(crate) fn angular_error(&self, bodies: &Bodies) -> f32 {
        let JointModel::SixDof(six_dof) = &self.model else { return 0.0 };
        let (a, b) = (bodies.at(self.body_a), bodies.at(self.body_b));
        let turns = six_dof.joint_angles(a.rotation, b.rotation);
        let [.., x, y, z] = six_dof.def.acting(turns.swing);
        let [p, q, r] = turns.angles;
        // Angles count full turns, and limits may be far from them.
        bounded(vec3(x.excess(p), y.excess(q), z.excess(r)).length())
    }
}

/// All joints.
#[derive(Debug, Default)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
pub(crate) struct Joints {
    pub(crate) rows: SlotMap<JointId, Joint>,
    /// Number of joints that can break.
    pub(crate) breakable: usize,
}

impl Clone for Joints {
    fn clone(&self) -> Self {
        let mut copy = Self::default();
        copy.clone_from(self);
        copy
    }

    /// Reuses the existing lists.
    fn clone_from(&mut self, from: &Self) {
        let Self { rows, breakable } = from;
        self.rows.clone_from(rows);
        self.breakable = *breakable;
    }
}

impl Joints {
    #[inline]
    pub(crate) fn at(&self, row: u32) -> &Joint {
        self.rows.at(row).expect("tables name living joints only")
    }

    #[inline]
    pub(crate) fn at_mut(&mut self, row: u32) -> &mut Joint {
        self.rows.at_mut(row).expect("tables name living joints only")
    }
}
