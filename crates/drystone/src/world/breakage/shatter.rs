//! Bodies that break into pieces where they are hit.

use std::sync::Arc;

use super::{Impact, Scratch};
use crate::base::double::DVec3;
use crate::base::id::BodyId;
use crate::base::math::{Vec3, bounded};
use crate::base::pose::Pose;
use crate::base::random::Random;
use crate::geometry::cells::HullPiece;
use crate::geometry::hull::Hull;
use crate::geometry::shape::Shape;
use crate::state::bodies::body::{Body, MassSource};
use crate::state::def::{BodyDef, DefError, Fracture, ShapeDef, position};
use crate::state::events::{FractureCause, FractureEvent};
use crate::state::shapes::ShapeRow;
use crate::state::tables::Tables;
use crate::world::{BodyMut, World};

/// Depth below the surface at which a hit point is placed, as a fraction of the distance to the
/// center.
const INSIDE: f32 = 0.05;

/// An impact that breaks a body.
struct Break {
    cause: FractureCause,
    /// Point of impact [m, world].
    point: Vec3,
    value: f32,
    limit: f32,
}

impl BodyMut<'_> {
    /// Breaks the body now, as if it had been hit at `point` [m, world], with the settings `how` in
    /// place of its own `fracture`. Returns its pieces. If the body is too small, or the world
    /// already has [`crate::config::BreakageConfig::max_pieces`], the body stays and the list is
    /// empty.
    ///
    /// # Errors
    /// The body is not a dynamic body of one box or hull, is glued, has an exact mass, or is
    /// disabled; or a field is out of range. Then nothing is changed.
    pub fn break_at(self, point: impl Into<Vec3>, how: &Fracture) -> Result<Vec<BodyId>, DefError> {
        how.validate()?;
        let point = point.into();
        position("point", point)?;
        self.world.check_breakable(self.row)?;
        if self.world.tables.bodies.at(self.row).record.disabled {
            return Err(DefError::unsuitable("body", "disabled", "an enabled body"));
        }
        Ok(self.world.shatter(self.row, how, point).unwrap_or_default())
    }

    /// Sets how the body breaks when it is hit; `None`: it does not break.
    ///
    /// # Errors
    /// A body that cannot break, as in [`Self::break_at`], or a field out of range. Then nothing is
    /// changed.
    pub fn set_fracture(&mut self, how: Option<Fracture>) -> Result<(), DefError> {
        let Some(how) = how else {
            self.world.tables.breakage.fractures.remove(&self.row);
            self.world.follow_breakage(self.row);
            return Ok(());
        };
        how.validate()?;
        self.world.check_breakable(self.row)?;
        self.world.tables.breakage.fractures.insert(self.row, how);
        self.body().record.breaks = true;
        Ok(())
    }
}

impl World {
    /// Breaks the bodies that were hit harder than their limits.
    pub(super) fn fracture_bodies(&mut self, scratch: &mut Scratch) {
        let mut rows = core::mem::take(&mut scratch.bodies);
        rows.clear();
        let tables = &self.tables;
        let hit = |row: &&u32| !scratch.impacts_of(**row).is_empty();
        rows.extend(tables.breakage.fractures.keys().filter(hit));
        for row in &rows {
            let Some(how) = self.tables.breakage.fractures.get(row).copied() else { continue };
            let body = self.tables.bodies.at(*row);
            let Some(found) = worst_impact(body, &how, scratch.impacts_of(*row)) else { continue };
            let id = self.tables.bodies.id(*row);
            let Some(made) = self.shatter(*row, &how, found.point) else { continue };
            let events = &mut self.tables.events;
            let pieces = [events.pieces.len(), made.len()];
            events.pieces.extend(made);
            events.fractures.push(FractureEvent {
                body: id,
                cause: found.cause,
                point: found.point,
                value: bounded(found.value),
                limit: found.limit,
                pieces: pieces.map(|n| u32::try_from(n).unwrap_or(u32::MAX)),
            });
        }
        scratch.bodies = rows;
    }

    /// Updates the flag by which contacts sum their impulses on a body: it can break and is
    /// dynamic.
    pub(in crate::world) fn follow_breakage(&mut self, row: u32) {
        let Tables { breakage, bodies, .. } = &mut self.tables;
        let body = bodies.at_mut(row);
        body.record.breaks = breakage.breaks(row) && body.is_dynamic();
    }

    /// Refuses bodies that cannot break into pieces.
    fn check_breakable(&self, row: u32) -> Result<(), DefError> {
        let body = self.tables.bodies.at(row);
        let exact = body.inertia.source == MassSource::Exact;
        let one = self.solid_shape(row).is_some();
        if !body.is_dynamic() || exact || !one || self.tables.breakage.glued.contains_key(&row) {
            let allowed =
                "a dynamic body of one box or hull, without glue and without an exact mass";
            return Err(DefError::unsuitable("body", row, allowed));
        }
        Ok(())
    }

    /// The only solid shape of a body, as a hull, if it is a box or a hull.
    fn solid_shape(&self, row: u32) -> Option<(u32, Arc<Hull>)> {
        let shapes = &self.tables.shapes;
        let all = self.tables.bodies.at(row).ties.shapes.iter();
        let mut solid = all.filter(|s| !shapes.at(**s).sensor);
        let (shape, none) = (*solid.next()?, solid.next());
        let hull = match &shapes.at(shape).shape {
            Shape::Box { half_extents } => Arc::new(Hull::cuboid(*half_extents)),
            Shape::Hull(hull) => Arc::clone(hull),
            _ => return None,
        };
        none.is_none().then_some((shape, hull))
    }

    /// Replaces a body by its pieces. Returns `None` and changes nothing if there would be fewer
    /// than two.
    fn shatter(&mut self, row: u32, how: &Fracture, point: Vec3) -> Option<Vec<BodyId>> {
        let (shape, hull) = self.solid_shape(row)?;
        let maximum = self.tables.config.breakage.max_pieces as usize;
        let room = maximum.saturating_sub(self.tables.breakage.pieces);
        let count = (how.pieces as usize).min(room);
        if count < 2 || !(f64::from(hull.volume()) >= 2.0 * how.min_volume()) {
            return None;
        }
        let body = self.tables.bodies.at(row);
        let s = self.tables.shapes.at(shape);
        let at = body.pose().compose(&s.local);
        let one_way = self.tables.shapes.one_way.get(&shape).copied();
        let mut random = Random::new(how.seed);
        let pieces = cut(&hull, at.local_point(point), how, count, &mut random);
        if pieces.len() < 2 {
            return None;
        }
        let whole: f64 = pieces.iter().map(|p| p.volume).sum();
        let mut defs: Vec<(BodyDef, Option<Fracture>)> = Vec::with_capacity(pieces.len());
        for piece in pieces {
            #[expect(clippy::cast_possible_truncation, reason = "rounding is what is asked for")]
            let part = (piece.volume / whole) as f32;
            let mut def = piece_def(body, s, &at, &piece, part);
            def.shapes[0].one_way = one_way;
            if def.validate().is_err() {
                return None;
            }
            defs.push((def, how.of_piece(part, &mut random)));
        }
        let mut made = Vec::with_capacity(defs.len());
        for (def, again) in defs {
            // The definition was checked above.
            let Ok(id) = self.add_body(def) else { continue };
            let body = self.tables.bodies.at_mut(id.index());
            body.record.is_piece = true;
            body.record.breaks = again.is_some();
            self.tables.breakage.pieces += 1;
            if let Some(again) = again {
                self.tables.breakage.fractures.insert(id.index(), again);
            }
            made.push(id);
        }
        self.hang_joints(row, &made);
        let id = self.tables.bodies.id(row);
        self.remove_body(id);
        Some(made)
    }

    /// Moves each joint of a body to the piece that is nearest to the joint's anchor.
    fn hang_joints(&mut self, row: u32, made: &[BodyId]) {
        for joint in self.tables.bodies.at(row).ties.joints.clone() {
            let tables = &self.tables;
            let j = tables.joints.at(joint);
            let old = tables.bodies.at(row);
            let own = if j.body_a == row { j.anchor_a } else { j.anchor_b };
            let point = old.center + old.rotation.rotate(own);
            let mut best: Option<(f32, u32, Vec3)> = None;
            for id in made {
                let piece = tables.bodies.at(id.index());
                let at = piece.pose().local_point(point);
                let Some(shape) = piece.ties.shapes.first() else { continue };
                let bounds = tables.shapes.at(*shape).solid.aabb(&Pose::IDENTITY);
                let away = (at - at.max(bounds.min).min(bounds.max)).length();
                if best.is_none_or(|(minimum, _, _)| away < minimum) {
                    best = Some((away, id.index(), at));
                }
            }
            if let Some((_, to, at)) = best {
                self.move_joint(joint, row, to, at);
            }
        }
    }
}

/// Cuts a hull into at most `count` pieces around a point [m, hull].
fn cut(
    hull: &Hull,
    point: Vec3,
    how: &Fracture,
    count: usize,
    random: &mut Random,
) -> Vec<HullPiece> {
    let bounds = hull.bounds();
    let middle = bounds.center();
    // A hit point lies on the surface, or slightly off it.
    let hit = point.max(bounds.min).min(bounds.max);
    let hit = hit + (middle - hit) * INSIDE;
    let corners = [bounds.min, bounds.max].map(DVec3::from);
    let inside = |p: DVec3| hull.planes().iter().all(|plane| plane.distance(p.single()) <= 0.0);
    let sites = how.sites(DVec3::from(hit), corners, count, random, inside);
    let sites: Vec<Vec3> = sites.into_iter().map(DVec3::single).collect();
    hull.cut(&sites, how.min_volume()).unwrap_or_default()
}

/// A piece of a body's shape. The shape has the pose `at` [world]; `part` is the piece's share of
/// the body's mass.
fn piece_def(body: &Body, s: &ShapeRow, at: &Pose, piece: &HullPiece, part: f32) -> BodyDef {
    let arm = at.direction(piece.center) + (at.position - body.center);
    let shape = ShapeDef {
        // This density keeps the mass correct although rounding of corners changed the volume.
        density: body.inertia.mass * part / piece.hull.volume(),
        material: s.material,
        filter: s.filter,
        surface_velocity: s.surface_velocity,
        surface_spin: s.surface_spin,
        reports: s.reports.unpacked(),
        senses: s.reports.senses(),
        hooks: s.reports.has_hooks(),
        user_data: s.user_data,
        ..ShapeDef::new(Shape::Hull(Arc::clone(&piece.hull)))
    };
    BodyDef {
        position: body.center + arm,
        rotation: at.rotation.normalized(),
        linear_velocity: body.velocity_at(arm),
        angular_velocity: body.w,
        gravity_scale: body.forces.gravity_scale,
        linear_damping: body.forces.linear_damping,
        angular_damping: body.forces.angular_damping,
        locks: body.inertia.locks,
        can_sleep: body.can_sleep,
        sleep_speed: (body.sleep.speed >= 0.0).then_some(body.sleep.speed),
        shapes: vec![shape],
        user_data: body.record.user_data,
        ..BodyDef::default()
    }
}

/// The strongest impact by one other body, if it exceeds a limit.
fn worst_impact(body: &Body, how: &Fracture, impacts: &[Impact]) -> Option<Break> {
    let mut worst: Option<(f32, Break)> = None;
    for (i, first) in impacts.iter().enumerate() {
        if impacts[..i].iter().any(|b| b.other == first.other) {
            continue;
        }
        let (mut impulse, mut arm, mut size) = (Vec3::ZERO, Vec3::ZERO, 0.0);
        for b in impacts[i..].iter().filter(|b| b.other == first.other) {
            let length = b.impulse.length();
            impulse += b.impulse;
            arm += b.arm * length;
            size += length;
        }
        if !(size > 0.0) {
            continue;
        }
        let arm = arm * (1.0 / size);
        let length = impulse.length();
        let energy = energy_of(body, arm, impulse);
        let parts = [
            (FractureCause::Impulse, length, how.impulse),
            (FractureCause::Energy, energy, how.energy),
        ];
        for (cause, value, limit) in parts {
            let part = value / limit;
            if part > 1.0 && worst.as_ref().is_none_or(|(maximum, _)| part > *maximum) {
                worst = Some((part, Break { cause, point: body.center + arm, value, limit }));
            }
        }
    }
    worst.map(|(_, found)| found)
}

/// Kinetic energy that an impulse at an arm gives to a free body at rest [J]: ½ p·(p/m) + ½ L·I⁻¹L.
fn energy_of(body: &Body, arm: Vec3, impulse: Vec3) -> f32 {
    let frame = body.rotation * body.inertia.principal;
    let turn = frame.unrotate(arm.cross(impulse));
    let part = |l: f32, i: f32| if i > 0.0 { l * l / i } else { 0.0 };
    let m = body.inertia.moments;
    let spin = part(turn.x, m.x) + part(turn.y, m.y) + part(turn.z, m.z);
    0.5 * (impulse.length_squared() / body.inertia.mass + spin)
}
