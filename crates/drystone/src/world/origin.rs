//! Another origin of the world: everything is told from there, and goes on as if nothing had happened.

use super::{Clock, World};
use crate::base::limits;
use crate::base::math::Vec3;
use crate::state::bodies::Track;
use crate::state::def::{DefError, position};
use crate::state::events::Events;
use crate::state::joints::Link;
use crate::state::tables::Tables;
use crate::step::context::StepContext;

impl World {
    /// Puts the origin of the world at `origin` [m, world]: from then on all places are told from there, so that each is what it
    /// was less `origin`. For worlds that are wide: f32 knows places 16 km from the origin to a millimeter, and a player that goes
    /// far takes the origin along. Call it between steps.
    ///
    /// Bodies, shapes, particles, contacts, trees, pulleys' points and the places in the events of the last step move; nothing
    /// wakes, no event comes of it, and no contact loses what it carries. Where the new coordinates are rounded nothing moves by more
    /// than that, half of the last digit; where they are not (the origin a multiple of the last digit, and no coordinate coming to
    /// have more) the world goes on with the same bits. Poses that a program keeps are its own to move; a [`Clock`] moves with the
    /// world by [`Clock::shift_origin`]. The potential energy of an open ledger changes as if all bodies were put elsewhere.
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
    /// A coordinate is not finite or beyond 1e7 m, or something would be farther than 1e9 m from there, or a pulley than 1e7 m;
    /// then nothing is changed.
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
            if let Link::Pulley(pulley) = &mut joint.link {
                pulley.points = pulley.points.map(|point| point - origin);
            }
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

    /// Checks that nothing would be where nothing can be.
    fn check_reach(&self, origin: Vec3) -> Result<(), DefError> {
        let Tables { bodies, joints, particles, .. } = &self.tables;
        let is_within = |place: Vec3, most: f32| (place - origin).is_below(most);
        let kept = limits::POSITION_KEPT.most;
        let bodies = bodies.rows.iter().all(|(_, body)| is_within(body.center, kept));
        let lines = particles.rows.iter().map(|(id, _)| id.index() + 1);
        let particles = lines.map(|line| particles.position(line)).all(|at| is_within(at, kept));
        let pulleys = joints.rows.iter().all(|(_, joint)| match &joint.link {
            Link::Pulley(pulley) => {
                pulley.points.iter().all(|point| is_within(*point, limits::POSITION.most))
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
                // It moved by so much against its box, and against others.
                body.room = less(body.room, off);
                let way = &mut bodies.tracks[row].way;
                *way = way.wrapping_add(Track::at_least(off * per_track));
            }
        }
        bodies.stillness.iter_mut().for_each(|known| known.shift(origin));
    }
}

impl Clock {
    /// Puts the origin of a world and of the poses that this clock keeps of it at `origin` [m, world]: see
    /// [`World::shift_origin`]. Pictures go on between the last two steps.
    ///
    /// # Errors
    /// Those of [`World::shift_origin`]; then nothing is changed.
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

/// A place as it is told from another origin, and by how much rounding may have moved it [m].
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
    // Along all three axes that is √3 times as much.
    (now, 2.0 * off)
}

/// A room [m] that is smaller by so much; 0: not known.
fn less(room: f32, by: f32) -> f32 {
    (room - by).max(0.0)
}

fn shift_events(events: &mut Events, origin: Vec3) {
    events.hits.iter_mut().for_each(|hit| hit.point -= origin);
    events.force_points.iter_mut().for_each(|point| point.position -= origin);
    events.bond_break.iter_mut().for_each(|bond| bond.point -= origin);
    events.fractures.iter_mut().for_each(|fracture| fracture.point -= origin);
}
