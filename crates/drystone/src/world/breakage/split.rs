//! Splits a body: groups of its shapes become new bodies. Mass, momentum and angular velocity are
//! preserved.

use super::glue::nearest;
use crate::base::math::Vec3;
use crate::base::pose::Pose;
use crate::geometry::mass::MassProperties;
use crate::state::bodies::NONE;
use crate::state::bodies::body::{Body, History, Inertia, MassSource, Record, Sleep, Ties};
use crate::state::joints::JointModel;
use crate::state::tables::Tables;
use crate::world::World;
use crate::world::change::mass::principal_moments;

impl World {
    /// Makes a new body from each of these groups of a body's shapes. The body keeps its other
    /// shapes. Returns the rows of the new bodies.
    pub(super) fn split_body(&mut self, row: u32, leaving: &[Vec<u32>]) -> Vec<u32> {
        self.sets().wake(row);
        for shape in leaving.iter().flatten() {
            self.end_contacts_of(row, Some(*shape));
        }
        let old = self.tables.bodies.at(row).clone();
        let whole = mass_of(&self.tables, &old.ties.shapes).mass;
        let mut made = Vec::with_capacity(leaving.len());
        for shapes in leaving {
            let body = self.part_of(&old, shapes, whole);
            let local_center = body.inertia.local_center;
            let tables = &mut self.tables;
            let new = tables.bodies.insert(body).index();
            for shape in shapes {
                let s = tables.shapes.at_mut(*shape);
                s.body = new;
                s.centered.position = s.local.position - local_center;
            }
            tables.islands.create(new, &mut tables.bodies);
            made.push(new);
        }
        let kept: Vec<u32> = old
            .ties
            .shapes
            .iter()
            .copied()
            .filter(|s| !leaving.iter().flatten().any(|l| l == s))
            .collect();
        self.shrink(row, &old, kept, whole);
        self.deal_joints(row, &old, &made);
        for new in &made {
            self.refresh_extent(*new);
            self.refresh_bounds(*new);
            self.sets().wake(*new);
            // Creating a body awake causes no wake event.
            let id = self.tables.bodies.id(*new);
            self.pending.wake.retain(|b| *b != id);
        }
        made
    }

    /// A new body with some of the shapes of `old`, and the velocity that they had in `old`.
    /// `whole`: mass of all shapes.
    fn part_of(&self, old: &Body, shapes: &[u32], whole: f32) -> Body {
        let mut total = mass_of(&self.tables, shapes);
        let source = share(old.inertia.source, total.mass, whole);
        if let MassSource::Mass(mass) = source {
            total = total.scaled_to(mass);
        }
        let arm = old.rotation.rotate(total.center - old.inertia.local_center);
        let (moments, principal) = principal_moments(&total);
        Body {
            center: old.center + arm,
            v: old.velocity_at(arm),
            inertia: Inertia {
                local_center: total.center,
                mass: total.mass,
                moments,
                principal,
                source,
                ..old.inertia
            },
            forces: old.forces.without_forces(),
            room: 0.0,
            ties: Ties { shapes: shapes.into(), ..Ties::none() },
            // Particles are still attached to the old body. The next step detects particles that
            // push the new ones.
            record: Record { dragged: false, breaks: false, ..old.record },
            sleep: Sleep::begin(old.sleep.speed),
            history: History::begin(NONE),
            awake_row: NONE,
            flies: false,
            ..old.clone()
        }
    }

    /// Reduces the body to these shapes.
    fn shrink(&mut self, row: u32, old: &Body, kept: Vec<u32>, whole: f32) {
        let mut total = mass_of(&self.tables, &kept);
        let source = share(old.inertia.source, total.mass, whole);
        if let MassSource::Mass(mass) = source {
            total = total.scaled_to(mass);
        }
        let body = self.tables.bodies.at_mut(row);
        (body.ties.shapes, body.inertia.source) = (kept.into(), source);
        body.history.w_low = Vec3::ZERO;
        self.set_mass(row, &total);
        self.refresh_extent(row);
        self.refresh_bounds(row);
    }

    /// Moves each joint of the body to the part whose shapes are nearest to the joint's anchor.
    fn deal_joints(&mut self, row: u32, old: &Body, made: &[u32]) {
        for joint in &old.ties.joints {
            let j = self.tables.joints.at(*joint);
            // The anchors of the remaining part have already been moved to its new center.
            let own = if j.body_a == row { j.anchor_a } else { j.anchor_b };
            let at = own + self.tables.bodies.at(row).inertia.local_center;
            let all = old.ties.shapes.iter().copied();
            if let Some(shape) = nearest(&self.tables, all, at) {
                let to = self.tables.shapes.at(shape).body;
                if made.contains(&to) {
                    self.move_joint(*joint, row, to, at);
                }
            }
        }
    }

    /// Moves a joint's end to another body, at this anchor [m, frame of its origin]. Its couplings
    /// are updated.
    pub(super) fn move_joint(&mut self, joint: u32, from: u32, to: u32, anchor: Vec3) {
        if matches!(self.tables.joints.at(joint).model, JointModel::Coupling(_)) {
            return;
        }
        let id = self.tables.joints.rows.id_at(joint);
        let couplings = id.map_or_else(Vec::new, |id| self.each_coupling_of(id));
        self.sets().uncolor_joint(joint);
        let tables = &mut self.tables;
        tables.islands.cut(from, &tables.bodies);
        tables.bodies.at_mut(from).ties.joints.retain(|j| *j != joint);
        tables.bodies.at_mut(to).ties.joints.push(joint);
        let anchor = anchor - tables.bodies.at(to).inertia.local_center;
        let j = tables.joints.at_mut(joint);
        if j.body_a == from {
            (j.body_a, j.anchor_a) = (to, anchor);
        } else {
            (j.body_b, j.anchor_b) = (to, anchor);
        }
        tables.colors.bodies_changed = true;
        self.enter_joint(joint);
        for coupling in couplings {
            self.follow_joints(coupling, false);
        }
    }
}

/// Mass properties of some shapes, in the frame of their body's origin.
fn mass_of(tables: &Tables, shapes: &[u32]) -> MassProperties {
    let solid = shapes.iter().map(|s| tables.shapes.at(*s));
    let parts: Vec<(Pose, MassProperties)> = solid
        .filter(|s| !s.sensor && s.density > 0.0)
        .map(|s| (s.local, MassProperties::of(&s.shape, s.density)))
        .collect();
    MassProperties::combine(&parts)
}

/// A given mass, scaled to the share of some of the shapes.
fn share(mass: MassSource, part: f32, whole: f32) -> MassSource {
    match mass {
        MassSource::Mass(mass) => MassSource::Mass(mass * (part / whole)),
        other => other,
    }
}
