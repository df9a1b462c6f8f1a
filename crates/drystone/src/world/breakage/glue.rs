//! Glued bodies: loads on their pieces, breaking bonds, and separation.

use super::bonds::Lump;
use super::{Impact, Scratch};
use crate::base::double::DVec3;
use crate::base::id::ShapeId;
use crate::base::math::{Vec3, bounded};
use crate::base::pose::Pose;
use crate::base::quat::Quat;
use crate::geometry::mass::MassProperties;
use crate::state::bodies::body::MassSource;
use crate::state::breakage::{GlueBond, Glued};
use crate::state::def::{BondStrength, DefError, Glue};
use crate::state::events::{BondBreak, FractureCause, FractureEvent};
use crate::state::joints::{Joint, JointModel};
use crate::state::tables::Tables;
use crate::world::{BodyMut, World};

/// A bond of a glued body, read-only.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BondRef {
    /// The two bonded shapes.
    pub shapes: [ShapeId; 2],
    /// Center of its face [m, world].
    pub point: Vec3,
    /// Normal from the first shape to the second [world].
    pub normal: Vec3,
    /// Area of its face [m²].
    pub area: f32,
    /// The stress at which it breaks.
    pub strength: BondStrength,
    /// The maximum of tension and shear in the last step, each divided by its strength. The bond
    /// breaks at 1.
    pub load: f32,
}

/// The bonds of the body in row `row`.
pub(in crate::world) fn bonds_of(tables: &Tables, row: u32) -> impl Iterator<Item = BondRef> + '_ {
    let pose = tables.bodies.at(row).pose();
    tables.breakage.glued.get(&row).into_iter().flat_map(move |glued| {
        glued.bonds.iter().map(move |bond| BondRef {
            shapes: bond.pieces.map(|p| tables.shapes.id(glued.pieces[p])),
            point: pose.point(bond.point),
            normal: pose.direction(bond.normal),
            area: bond.area,
            strength: bond.strength,
            load: bounded(bond.load),
        })
    })
}

impl BodyMut<'_> {
    /// Sets the strength of all its bonds, and wakes it.
    ///
    /// # Errors
    /// A limit is out of range, or the body is not glued. Then nothing is changed.
    pub fn set_bond_strength(&mut self, strength: BondStrength) -> Result<(), DefError> {
        strength.validate()?;
        let Some(glued) = self.world.tables.breakage.glued.get_mut(&self.row) else {
            return Err(DefError::unsuitable("body", "not glued", "a body with glue"));
        };
        for bond in &mut glued.bonds {
            bond.strength = strength;
        }
        // The stored loads are fractions of the strength.
        glued.lack.clear();
        self.wake();
        Ok(())
    }
}

impl World {
    /// Stores the bonds of a new body, whose shapes are in the order of its definition.
    pub(in crate::world) fn glue_body(&mut self, row: u32, glue: &Glue) {
        let tables = &mut self.tables;
        let rows = &tables.bodies.at(row).ties.shapes;
        let mut number = vec![usize::MAX; rows.len()];
        let mut glued = Glued::default();
        for (i, shape) in rows.iter().enumerate() {
            if !tables.shapes.at(*shape).sensor {
                number[i] = glued.pieces.len();
                glued.pieces.push(*shape);
            }
        }
        glued.bonds.extend(glue.bonds.iter().map(|b| GlueBond {
            pieces: b.shapes.map(|s| number[s]),
            point: b.point,
            normal: b.normal.normalize_or(Vec3::Y),
            area: b.area,
            strength: b.strength,
            load: 0.0,
        }));
        tables.breakage.glued.insert(row, glued);
    }

    /// Breaks the overloaded bonds, and splits the bodies that come apart.
    pub(super) fn break_glue(&mut self, scratch: &mut Scratch, dt: f32) {
        let mut rows = core::mem::take(&mut scratch.bodies);
        rows.clear();
        let tables = &self.tables;
        let can_part =
            |row: &&u32| tables.bodies.at(**row).active() && tables.bodies.at(**row).record.breaks;
        rows.extend(tables.breakage.glued.keys().filter(can_part));
        for row in &rows {
            // Taking the value instead of removing the entry keeps its memory.
            let Some(slot) = self.tables.breakage.glued.get_mut(row) else { continue };
            let mut glued = core::mem::take(slot);
            load_pieces(&self.tables, *row, &glued, scratch);
            let body = self.tables.bodies.at(*row);
            let spin = DVec3::from(body.rotation.unrotate(body.w));
            scratch.bonds.find_broken(&mut glued, spin, f64::from(dt));
            // A removed shape may have connected others.
            let is_whole = scratch.bonds.part.iter().all(|part| *part == 0);
            if scratch.bonds.broken.is_empty() && is_whole {
                if let Some(slot) = self.tables.breakage.glued.get_mut(row) {
                    *slot = glued;
                }
                continue;
            }
            self.tables.breakage.glued.remove(row);
            self.report_broken(*row, &glued, scratch);
            self.part_glued(*row, glued, scratch);
        }
        scratch.bodies = rows;
    }

    fn report_broken(&mut self, row: u32, glued: &Glued, scratch: &Scratch) {
        let tables = &mut self.tables;
        let pose = tables.bodies.at(row).pose();
        for (number, tension, shear, _) in &scratch.bonds.broken {
            let bond = &glued.bonds[*number];
            tables.events.bond_break.push(BondBreak {
                body: tables.bodies.id(row),
                shapes: bond.pieces.map(|p| tables.shapes.id(glued.pieces[p])),
                point: pose.point(bond.point),
                tension: *tension,
                shear: *shear,
            });
        }
    }

    /// Removes the broken bonds. Disconnected parts become separate bodies.
    fn part_glued(&mut self, row: u32, mut glued: Glued, scratch: &Scratch) {
        let broken = &scratch.bonds.broken;
        let pose = self.tables.bodies.at(row).pose();
        let (mut point, mut worst) = (pose.position, 0.0);
        for (bond, _, _, load) in broken {
            if *load > worst {
                (point, worst) = (pose.point(glued.bonds[*bond].point), *load);
            }
        }
        let id = self.tables.bodies.id(row);
        let mut number = 0..;
        glued.bonds.retain(|_| number.next().is_some_and(|i| broken.iter().all(|b| b.0 != i)));
        // Parts in the order of their first pieces. The heaviest part keeps the body.
        let mut parts: Vec<(f64, Vec<u32>)> = Vec::new();
        let mut place = vec![usize::MAX; glued.pieces.len()];
        for (i, shape) in glued.pieces.iter().enumerate() {
            let first = scratch.bonds.part[i];
            if first == i {
                place[i] = parts.len();
                parts.push((0.0, Vec::new()));
            }
            let part = &mut parts[place[first]];
            part.0 += scratch.bonds.lumps[i].mass;
            part.1.push(*shape);
        }
        if parts.len() < 2 {
            self.tables.breakage.glued.insert(row, glued);
            return;
        }
        let mut heaviest = 0;
        for (i, part) in parts.iter().enumerate() {
            if part.0 > parts[heaviest].0 {
                heaviest = i;
            }
        }
        let (_, kept) = parts.remove(heaviest);
        let leaving: Vec<Vec<u32>> = parts.into_iter().map(|(_, shapes)| shapes).collect();
        let first = self.tables.events.pieces.len();
        let made = self.split_body(row, &leaving);
        for (new, shapes) in made.iter().zip(&leaving) {
            self.glue_part(*new, &glued, shapes);
        }
        self.glue_part(row, &glued, &kept);
        let ids = made.iter().map(|new| self.tables.bodies.id(*new));
        self.tables.events.pieces.extend(ids);
        #[expect(clippy::cast_possible_truncation, reason = "to be shown")]
        let value = bounded(worst as f32);
        self.tables.events.fractures.push(FractureEvent {
            body: id,
            cause: FractureCause::Glue,
            point,
            value,
            limit: 1.0,
            pieces: [first, made.len()].map(|n| u32::try_from(n).unwrap_or(u32::MAX)),
        });
    }

    /// Gives a body that has these pieces their bonds.
    fn glue_part(&mut self, row: u32, glued: &Glued, shapes: &[u32]) {
        // Most parts are single pieces.
        let is_glued = shapes.len() > 1;
        self.tables.bodies.at_mut(row).record.breaks = is_glued;
        if is_glued {
            let mut own = glued.clone();
            own.retain(|shape| shapes.contains(&shape));
            self.tables.breakage.glued.insert(row, own);
        }
    }
}

/// Collects the pieces as rigid bodies in the body's frame, with the impulses on them in the step.
fn load_pieces(tables: &Tables, row: u32, glued: &Glued, scratch: &mut Scratch) {
    let body = tables.bodies.at(row);
    let lumps = &mut scratch.bonds.lumps;
    lumps.clear();
    let mut total = 0.0;
    for shape in &glued.pieces {
        let s = tables.shapes.at(*shape);
        let own = MassProperties::of(&s.shape, s.density);
        total += f64::from(own.mass);
        lumps.push(lump(&own, &s.local));
    }
    // If the mass of the body was given, each piece gets its share of it.
    if let MassSource::Mass(mass) = body.inertia.source {
        let scale = f64::from(mass) / total;
        for l in lumps.iter_mut() {
            l.mass *= scale;
            l.inertia = l.inertia.map(|r| r.map(|x| x * scale));
        }
    }
    let local = |v: Vec3| DVec3::from(body.rotation.unrotate(kept(v)));
    let mut push = |piece: usize, arm: Vec3, impulse: Vec3, turn: Vec3| {
        let l = &mut scratch.bonds.lumps[piece];
        let (force, at) = (local(impulse), local(arm) + DVec3::from(body.inertia.local_center));
        l.force = l.force + force;
        l.torque = l.torque + (at - l.center).cross(force) + local(turn);
    };
    let first = scratch.impacts.partition_point(|b| b.body < row);
    for Impact { shape, arm, impulse, .. } in
        scratch.impacts[first..].iter().take_while(|b| b.body == row)
    {
        if let Some(piece) = glued.pieces.iter().position(|s| s == shape) {
            push(piece, *arm, *impulse, Vec3::ZERO);
        }
    }
    for joint in body.ties.joints.iter().map(|j| tables.joints.at(*j)) {
        let (anchor, impulse, turn) = joint_load(tables, row, joint);
        let own = if joint.body_a == row { joint.anchor_a } else { joint.anchor_b };
        let at = own + body.inertia.local_center;
        let all = glued.pieces.iter().copied();
        if let Some(shape) = nearest(tables, all, at)
            && let Some(piece) = glued.pieces.iter().position(|s| *s == shape)
        {
            push(piece, anchor, impulse, turn);
        }
    }
}

/// Clamps a vector to numbers that can be rotated and summed in f32. A larger impulse breaks every
/// bond that can break, and must stay finite.
fn kept(v: Vec3) -> Vec3 {
    const MAX: f32 = 1.0e37;
    v.bounded().min(Vec3::splat(MAX)).max(Vec3::splat(-MAX))
}

/// The load of a joint on one of its bodies in the step: point of action relative to the body's
/// center of mass [m, world], linear and angular impulse.
fn joint_load(tables: &Tables, row: u32, joint: &Joint) -> (Vec3, Vec3, Vec3) {
    let (a, b) = (tables.bodies.at(joint.body_a), tables.bodies.at(joint.body_b));
    let at_b = b.rotation.rotate(joint.anchor_b);
    let [impulse, turn] = joint.given;
    if joint.body_b == row {
        return (at_b, impulse, turn);
    }
    let arm = match joint.model {
        JointModel::SixDof(_) => b.center + at_b - a.center,
        _ => a.rotation.rotate(joint.anchor_a),
    };
    (arm, -impulse, -turn)
}

/// The shape whose box is nearest to a point [m, frame of the body's origin]; the first of equals.
pub(super) fn nearest(
    tables: &Tables,
    shapes: impl Iterator<Item = u32>,
    point: Vec3,
) -> Option<u32> {
    let mut best: Option<(f32, u32)> = None;
    for shape in shapes {
        let s = tables.shapes.at(shape);
        let bounds = s.solid.aabb(&s.local);
        let away = (point - point.max(bounds.min).min(bounds.max)).length();
        if best.is_none_or(|(minimum, _)| away < minimum) {
            best = Some((away, shape));
        }
    }
    best.map(|(_, shape)| shape)
}

/// The lump of a solid in the body's frame.
fn lump(own: &MassProperties, at: &Pose) -> Lump {
    let mut inertia = [[0.0; 3]; 3];
    let m = own.inertia.to_mat3();
    let axes = Quat::to_mat3(at.rotation);
    // R I Rᵀ.
    let columns = [m.x, m.y, m.z].map(DVec3::from);
    let r = [axes.x, axes.y, axes.z].map(DVec3::from);
    let entry = |v: DVec3, i: usize| [v.x, v.y, v.z][i];
    for i in 0..3 {
        for j in 0..3 {
            let mut sum = 0.0;
            for k in 0..3 {
                for l in 0..3 {
                    sum += entry(r[k], i) * entry(columns[l], k) * entry(r[l], j);
                }
            }
            inertia[i][j] = sum;
        }
    }
    Lump {
        mass: f64::from(own.mass),
        center: DVec3::from(at.point(own.center)),
        inertia,
        ..Lump::default()
    }
}
