//! Shifts of the world's origin that do not disturb the simulation.

use super::{Clock, World};
use crate::base::limits;
use crate::base::math::Vec3;
use crate::state::bodies::Track;
use crate::state::def::{DefError, position};
use crate::state::events::Events;
use crate::state::joints::JointModel;
use crate::state::tables::Tables;
use crate::step::context::StepContext;

impl World {
    /// Moves the origin of the world to `origin` [m, world]. Every position then becomes its old
    /// value minus `origin`. Use it in large worlds, where a distant player can carry the origin
    /// along: 16 km from the origin, f32 resolves positions to a millimeter. Call it between steps.
    ///
    /// Bodies, shapes, particles, contacts, trees, pulley points and the positions in the events of
    /// the last step are shifted. Nothing wakes, there is no event, and contacts keep their
    /// impulses. Rounding moves an object by at most half of the last digit of its new coordinates.
    /// Without rounding the world continues with the same bits. That is so if the origin is a
    /// multiple of the last digit and no coordinate needs more digits than before. Poses stored by
    /// the program are not shifted; a [`Clock`] is shifted together with the world by
    /// [`Clock::shift_origin`]. The potential energy in an open ledger changes as if all bodies had
    /// been moved.
    ///
    /// ```
    /// use drystone::{BodyDef, ShapeDef, World};
    ///
    /// let mut world = World::default();
    /// let ball = BodyDef::dynamic().with_position([2048.0, 1.0, 0.0]);
    /// let ball = world.add_body(ball.with_shape(ShapeDef::sphere(0.5)))?;
    /// world.shift_origin([2048.0, 0.0, 0.0])?;
    /// assert!(world.body(ball).is_some_and(|ball| ball.position().x == 0.0));
    /// # Ok::<(), drystone::DefError>(())
    /// ```
    ///
    /// # Errors
    /// A coordinate is not finite or beyond 1e7 m, or an object would be farther than 1e9 m, or a
    /// pulley farther than 1e7 m, from the new origin. Then nothing is changed.
    pub fn shift_origin(&mut self, origin: impl Into<Vec3>) -> Result<(), DefError> {
        let origin = origin.into();
        position("origin", origin)?;
        if origin == Vec3::ZERO {
            return Ok(());
        }
        self.check_reach(origin)?;
        self.shift_bodies(origin);
        let tables = &mut self.tables;
        for shape in tables.shapes.rows.values_mut().iter_mut().flatten() {
            shape.fat = shape.fat.told_from(origin);
        }
        tables.bounds.fixed.shift(origin);
        tables.bounds.moving.shift(origin);
        for joint in tables.joints.rows.values_mut().iter_mut().flatten() {
            if let JointModel::Pulley(pulley) = &mut joint.model {
                pulley.points = pulley.points.map(|point| point - origin);
            }
        }
        let moved = (Vec3::ZERO - origin).to_array().map(f64::from);
        for articulation in tables.articulations.rows.values_mut().iter_mut().flatten() {
            articulation.shift(moved);
        }
        let particles = &mut tables.particles;
        for (slot, row) in particles.rows.values_mut().iter_mut().enumerate() {
            let Some(particle) = row else { continue };
            let x = &mut particles.x[slot + 1];
            let (now, off) = told_from(Vec3::from([x[0], x[1], x[2]]), origin);
            (x[0], x[1], x[2]) = (now.x, now.y, now.z);
            particle.room = less(particle.room, off);
        }
        for events in [&mut tables.events, &mut self.pending] {
            shift_events(events, origin);
        }
        Ok(())
    }

    /// Checks that everything stays in range.
    fn check_reach(&self, origin: Vec3) -> Result<(), DefError> {
        let Tables { bodies, joints, particles, .. } = &self.tables;
        let is_within = |place: Vec3, maximum: f32| (place - origin).is_below(maximum);
        let kept = limits::POSITION_KEPT.maximum;
        let bodies = bodies.rows.iter().all(|(_, body)| is_within(body.center, kept));
        let states = particles.rows.iter().map(|(id, _)| id.index() + 1);
        let particles =
            states.map(|solver_row| particles.position(solver_row)).all(|at| is_within(at, kept));
        let pulleys = joints.rows.iter().all(|(_, joint)| match &joint.model {
            JointModel::Pulley(pulley) => {
                pulley.points.iter().all(|point| is_within(*point, limits::POSITION.maximum))
            }
            _ => true,
        });
        if bodies && particles && pulleys {
            return Ok(());
        }
        let allowed = "a point with everything within 1e9 m and every pulley within 1e7 m of it";
        Err(DefError::new("origin", format!("{origin:?}"), allowed))
    }

    fn shift_bodies(&mut self, origin: Vec3) {
        let per_track = StepContext::per_track_of(self.tables.config.length_scale);
        let bodies = &mut self.tables.bodies;
        for (row, slot) in bodies.rows.values_mut().iter_mut().enumerate() {
            let Some(body) = slot else { continue };
            let (now, off) = told_from(body.center, origin);
            body.center = now;
            if off > 0.0 {
                // Rounding moved it by up to `off` relative to its box and to other bodies.
                body.room = less(body.room, off);
                let path = &mut bodies.tracks[row].path;
                *path = path.wrapping_add(Track::at_least(off * per_track));
            }
        }
        bodies.stillness.iter_mut().for_each(|known| known.shift(origin));
    }
}

impl Clock {
    /// Moves the origin of a world, and of the poses that this clock stores for it, to `origin` [m,
    /// world]: see [`World::shift_origin`]. Interpolation between the last two steps continues.
    ///
    /// # Errors
    /// The errors of [`World::shift_origin`]; then nothing is changed.
    pub fn shift_origin(
        &mut self,
        world: &mut World,
        origin: impl Into<Vec3>,
    ) -> Result<(), DefError> {
        let origin = origin.into();
        let known: Vec<usize> = self.known(world).collect();
        world.shift_origin(origin)?;
        for slot in known {
            self.shift(world, slot, origin);
        }
        Ok(())
    }
}

/// A position relative to another origin, and the maximum displacement by rounding [m].
fn told_from(place: Vec3, origin: Vec3) -> (Vec3, f32) {
    let now = place - origin;
    let off = |now: f32, place: f32, origin: f32| {
        let exact = f64::from(place) - f64::from(origin);
        #[expect(clippy::cast_possible_truncation, reason = "a rounding of f32")]
        let off = (exact - f64::from(now)).abs() as f32;
        off
    };
    let off = off(now.x, place.x, origin.x)
        .max(off(now.y, place.y, origin.y))
        .max(off(now.z, place.z, origin.z));
    // Over all three axes the displacement is up to √3 times as large.
    (now, 2.0 * off)
}

/// A margin [m] reduced by `by`; 0: not known.
fn less(room: f32, by: f32) -> f32 {
    (room - by).max(0.0)
}

fn shift_events(events: &mut Events, origin: Vec3) {
    events.hits.iter_mut().for_each(|hit| hit.point -= origin);
    events.force_points.iter_mut().for_each(|point| point.position -= origin);
    events.bond_break.iter_mut().for_each(|bond| bond.point -= origin);
    events.fractures.iter_mut().for_each(|fracture| fracture.point -= origin);
}
