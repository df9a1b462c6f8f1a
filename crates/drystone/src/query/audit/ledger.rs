//! The ledger: energy that entered and left the world, summed step by step.
//!
//! The user's changes between steps are the difference between the energy after one step and the
//! energy before the next, so no call has to report to the ledger. Forces and kinematic bodies act
//! within the step; the ledger computes their work as force times displacement.

use super::energy::Energy;
use crate::base::double::DVec3;
use crate::base::math::Vec3;
use crate::base::quat::Quat;
use crate::state::bodies::body::Body;
use crate::state::contacts::Contact;
use crate::state::def::BodyKind;
use crate::state::joints::{Joint, JointModel};
use crate::state::tables::Tables;

/// Energy that entered and left the world [J], since [`crate::World::begin_ledger`].
///
/// start + forces + impulses + changes + kinematic = now + dissipated. The work of gravity is part
/// of the potential energy.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct Ledger {
    /// Number of steps that it covers.
    pub steps: u64,
    /// Energy at its start.
    pub start: Energy,
    /// Current energy.
    pub now: Energy,
    /// Work of the user's forces and torques, both one-step and lasting: force times the
    /// displacement of the center of mass, torque times the rotation.
    pub forces: f64,
    /// Kinetic energy that the user's calls between steps added: impulses, new velocities, moving
    /// bodies added and removed.
    pub impulses: f64,
    /// Potential and elastic energy that the user's calls between steps added: moved bodies, bodies
    /// and springs added and removed, a changed gravity.
    pub changes: f64,
    /// Work of kinematic bodies through contacts and joints. It is an estimate: it takes each
    /// substep's impulses to equal those of the last substep, which is exact where they are
    /// constant within a step. It misses the work of an impact on a kinematic body, which
    /// `dissipated` then lacks.
    pub kinematic: f64,
    /// Energy lost to friction, impacts without bounce, damping and sleep. It is the difference of
    /// all other terms, so it includes the integration error. Negative: energy was gained.
    pub dissipated: f64,
}

/// A body on which the user's forces act in a step.
#[derive(Clone, Copy, Debug)]
struct Pushed {
    row: u32,
    force: Vec3,
    torque: Vec3,
    center: Vec3,
    rotation: Quat,
}

/// The open ledger of a world.
#[derive(Debug)]
pub(crate) struct Books {
    steps: u64,
    start: Energy,
    /// Energy after the last step.
    last: Energy,
    forces: f64,
    impulses: f64,
    changes: f64,
    kinematic: f64,
    pushed: Vec<Pushed>,
}

// The list of pushed bodies is valid within a step only.
impl Clone for Books {
    fn clone(&self) -> Self {
        Self { pushed: Vec::new(), ..*self }
    }

    fn clone_from(&mut self, from: &Self) {
        let pushed = core::mem::take(&mut self.pushed);
        *self = Self { pushed, ..*from };
    }
}

impl Books {
    /// Opens the ledger at the current state.
    pub(crate) fn open(tables: &Tables) -> Self {
        let start = Energy::of(tables);
        Self {
            steps: 0,
            start,
            last: start,
            forces: 0.0,
            impulses: 0.0,
            changes: 0.0,
            kinematic: 0.0,
            pushed: Vec::new(),
        }
    }

    /// Runs before a step: adds the user's changes since the last step, and records the bodies with
    /// forces in this one.
    pub(crate) fn before_step(&mut self, tables: &Tables) {
        let now = Energy::of(tables);
        self.impulses += now.kinetic() - self.last.kinetic();
        self.changes += now.stored() - self.last.stored();
        self.pushed.clear();
        for row in &tables.bodies.awake {
            let body = tables.bodies.at(*row);
            let (force, torque) = (
                body.forces.force + body.forces.step_force,
                body.forces.torque + body.forces.step_torque,
            );
            if body.is_dynamic() && (force != Vec3::ZERO || torque != Vec3::ZERO) {
                let (center, rotation) = (body.center, body.rotation);
                self.pushed.push(Pushed { row: *row, force, torque, center, rotation });
            }
        }
    }

    /// Runs after a step of `substeps` substeps: adds the work of forces and kinematic bodies.
    pub(crate) fn after_step(&mut self, tables: &Tables, substeps: u32) {
        for p in &self.pushed {
            let body = tables.bodies.at(p.row);
            let displacement = DVec3::from(body.center) - DVec3::from(p.center);
            let turn = (body.rotation * p.rotation.conjugate()).to_rotation_vector();
            self.forces += DVec3::from(p.force).dot(displacement)
                + DVec3::from(p.torque).dot(DVec3::from(turn));
        }
        for row in &tables.bodies.awake {
            if tables.bodies.at(*row).kind == BodyKind::Kinematic {
                // The impulse of the last substep stands for each substep.
                self.kinematic += f64::from(substeps) * work_of(*row, tables);
            }
        }
        self.last = Energy::of(tables);
        self.steps += 1;
    }

    /// The current ledger.
    pub(crate) fn ledger(&self, tables: &Tables) -> Ledger {
        let now = Energy::of(tables);
        let impulses = self.impulses + now.kinetic() - self.last.kinetic();
        let changes = self.changes + now.stored() - self.last.stored();
        let (forces, kinematic) = (self.forces, self.kinematic);
        let came = self.start.total() + forces + impulses + changes + kinematic;
        Ledger {
            steps: self.steps,
            start: self.start,
            now,
            forces,
            impulses,
            changes,
            kinematic,
            dissipated: came - now.total(),
        }
    }
}

/// Work of a kinematic body on dynamic ones in a substep [J].
fn work_of(row: u32, tables: &Tables) -> f64 {
    let (bodies, contacts) = (&tables.bodies, &tables.contacts);
    let body = bodies.at(row);
    let mut work = 0.0;
    for (contact, side) in contacts.of_body(bodies.at(row)) {
        let c = contacts.at(contact);
        if c.count > 0 && c.place.is_somewhere() {
            work += through_contact(body, c, side);
        }
    }
    for joint in &body.ties.joints {
        let joint = tables.joints.at(*joint);
        if joint.place.is_somewhere() {
            work += through_joint(body, joint, row, tables);
        }
    }
    work
}

/// Impulses act on B, and with opposite sign on A. The work of the moving side is the product of
/// impulse and velocity.
fn through_contact(body: &Body, c: &Contact, side: u32) -> f64 {
    let mut work = 0.0;
    let mut middle = Vec3::ZERO;
    for p in c.points() {
        let r = if side == 0 { p.r_a } else { c.r_b(p) };
        let v = body.velocity_at(r);
        work += f64::from(p.impulse) * f64::from(c.normal.dot(v));
        middle += v;
    }
    // Friction acts on the mean velocity of the points, as in the solver.
    let v = middle * (1.0 / f32::from(c.count.max(1)));
    work += f64::from(c.tangent_impulse.dot(v));
    let turn = c.normal * c.twist_impulse + c.rolling_impulse();
    work += f64::from(turn.dot(body.w));
    if side == 0 { work } else { -work }
}

fn through_joint(body: &Body, joint: &Joint, row: u32, tables: &Tables) -> f64 {
    let (a, b) = (tables.bodies.at(joint.body_a), tables.bodies.at(joint.body_b));
    let (ra, rb) = (a.rotation.rotate(joint.anchor_a), b.rotation.rotate(joint.anchor_b));
    let impulse = match &joint.model {
        JointModel::Ball => joint.impulse,
        JointModel::Pulley(pulley) => {
            let i = usize::from(joint.body_a != row);
            let (of, r) = [(a, ra), (b, rb)][i];
            let along = (of.center + r - pulley.points[i]).normalize_or(Vec3::Y);
            let force = joint.impulse.x * [1.0, pulley.ratio][i];
            return -f64::from((along * force).dot(body.velocity_at(r)));
        }
        // A coupling acts through the joints that it couples.
        JointModel::Coupling(_) | JointModel::Link => return 0.0,
        JointModel::SixDof(six_dof) => {
            // The force acts at anchor B on both bodies.
            let is_a = joint.body_a == row;
            let r = if is_a { b.center + rb - a.center } else { rb };
            let work = f64::from(six_dof.state.force.dot(body.velocity_at(r)))
                + f64::from(six_dof.state.torque.dot(body.w));
            return if is_a { work } else { -work };
        }
        JointModel::Distance { .. } => {
            let gap = (b.center - a.center) + (rb - ra);
            let p = joint.impulse;
            gap.normalize_or(Vec3::Y) * (p.x - p.y + p.z)
        }
    };
    let is_a = joint.body_a == row;
    let work = f64::from(impulse.dot(body.velocity_at(if is_a { ra } else { rb })));
    if is_a { work } else { -work }
}
