//! Accuracy of a world: energy balance, momentum, overlaps, joint errors, friction cones, and the
//! errors that contacts left unsolved. The audit measures the tables as they are, and assumes
//! nothing about the solver that filled them.

mod contacts;
mod energy;
mod ledger;
mod springs;

pub use self::contacts::{ConeUse, ContactPair, ContactResidual, Penetration};
pub use self::energy::{Energy, Momentum};
pub use self::ledger::Ledger;

pub(crate) use self::ledger::Books;

use self::contacts::ContactAudit;
use crate::base::id::{BodyId, JointId};
use crate::state::joints::{Joint, JointModel};
use crate::state::tables::Tables;

/// Errors of joints.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct JointErrors {
    /// Maximum linear error [m]: the gap of a ball joint, the excess of a distance joint, the
    /// excess of the linear axes of a six-axis joint.
    pub linear: f32,
    /// The joint with this error; `None` if no joint has one.
    pub linear_joint: Option<JointId>,
    /// Maximum angular error [rad]: of the angular axes of six-axis joints.
    pub angular: f32,
    /// The joint with this error; `None` if no joint has one.
    pub angular_joint: Option<JointId>,
}

/// A contact or a joint.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum ConstraintId {
    /// A contact.
    Contact(ContactPair),
    /// A joint.
    Joint(JointId),
}

/// The constraint with the largest error.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct WorstConstraint {
    /// The contact or joint.
    pub id: ConstraintId,
    /// Its error [m]: the depth of an overlap, the gap or excess of a joint.
    pub error: f32,
}

/// Result of [`crate::World::audit`].
///
/// Impulses are those of the last substep, as the solver stores them for its warm start. Sleeping
/// shapes are included in the state in which they fell asleep. Sums over bodies cover dynamic ones.
/// The manual: [audit](crate::manual::audit).
#[derive(Clone, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct Audit {
    /// Steps that the world has taken.
    pub step: u64,
    /// Current energy.
    pub energy: Energy,
    /// Energy balance since [`crate::World::begin_ledger`]; `None` before that call.
    pub ledger: Option<Ledger>,
    /// Current momentum.
    pub momentum: Momentum,
    /// Overlaps.
    pub penetration: Penetration,
    /// Joint errors.
    pub joints: JointErrors,
    /// The contact that uses the largest part of its friction cone; `None` if no contact carries
    /// load.
    pub cone: Option<ConeUse>,
    /// Errors that the contacts left unsolved.
    pub residual: ContactResidual,
    /// The contact or joint with the largest error [m]; `None` if all are exact.
    pub worst: Option<WorstConstraint>,
    /// Bodies out of the simulation because their state became infinite or NaN, sorted by slot.
    pub non_finite: Vec<BodyId>,
}

/// Measures everything. `h` is the last substep [s], 0 before the first; `substeps` is the number
/// of substeps in a step.
pub(crate) fn audit(tables: &Tables, books: Option<&Books>, h: f32, substeps: u32) -> Audit {
    let contacts = ContactAudit::of(tables, h, substeps);
    let joints = joint_errors(tables);
    let bodies = tables.bodies.rows.iter();
    let broken = bodies.filter(|(_, b)| {
        let finite = b.center.is_finite() && b.rotation.is_finite();
        b.record.faulted || !(finite && b.v.is_finite() && b.w.is_finite())
    });
    Audit {
        step: tables.steps,
        energy: Energy::of(tables),
        ledger: books.map(|books| books.ledger(tables)),
        momentum: Momentum::of(tables),
        penetration: contacts.penetration,
        joints,
        cone: contacts.cone,
        residual: contacts.residual,
        worst: worst(&contacts, &joints),
        non_finite: broken.map(|(id, _)| id).collect(),
    }
}

/// Returns the constraint with the largest error.
pub(crate) fn worst_constraint(tables: &Tables) -> Option<WorstConstraint> {
    worst(&ContactAudit::of(tables, 0.0, 0), &joint_errors(tables))
}

fn joint_errors(tables: &Tables) -> JointErrors {
    let mut errors = JointErrors::default();
    let acts = |joint: &Joint| !joint.is_idle(&tables.bodies);
    for (id, joint) in tables.joints.rows.iter().filter(|(_, joint)| acts(joint)) {
        let (mut error, mut angle) =
            (joint.error(&tables.bodies), joint.angular_error(&tables.bodies));
        if let JointModel::Coupling(coupling) = &joint.model {
            let off = coupling.error(&tables.joints, &tables.bodies).abs();
            *(if coupling.def.axis_b.is_turn() { &mut angle } else { &mut error }) = off;
        }
        if error > errors.linear {
            (errors.linear, errors.linear_joint) = (error, Some(id));
        }
        if angle > errors.angular {
            (errors.angular, errors.angular_joint) = (angle, Some(id));
        }
    }
    errors
}

fn worst(contacts: &ContactAudit, joints: &JointErrors) -> Option<WorstConstraint> {
    let p = &contacts.penetration;
    let contact = p.at.map(|pair| (ConstraintId::Contact(pair), p.max));
    let joint = joints.linear_joint.map(|id| (ConstraintId::Joint(id), joints.linear));
    let (id, error) = match (contact, joint) {
        (Some(c), Some(j)) => {
            if j.1 > c.1 {
                j
            } else {
                c
            }
        }
        (c, j) => c.or(j)?,
    };
    Some(WorstConstraint { id, error })
}
