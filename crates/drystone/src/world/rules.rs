//! Rules between pairs: two bodies that never meet, and what surfaces of some layers do to each other.

use super::World;
use crate::base::id::BodyId;
use crate::state::def::DefError;
use crate::state::material::SurfaceRule;

/// So many rules of surfaces at most: each new contact is compared with all of them.
const MOST_RULES: usize = 256;

impl World {
    /// Lets two bodies collide, or never, whatever their filters say: a thrower and what it throws, for example. Both wake if
    /// that changes something; touches that may not be any longer end. The rule lasts until one of the bodies is removed;
    /// pieces that come off a body do not take it over. False if one of them is not of this world, or both are the same.
    ///
    /// ```
    /// use drystone::{BodyDef, ShapeDef, World};
    ///
    /// let mut world = World::default();
    /// let ball = || BodyDef::dynamic().with_shape(ShapeDef::sphere(0.5));
    /// let (hand, stone) = (world.add_body(ball())?, world.add_body(ball())?);
    /// world.set_bodies_collide(hand, stone, false);
    /// world.step(1.0 / 60.0);
    /// assert_eq!(world.contacts().count(), 0);
    /// # Ok::<(), drystone::DefError>(())
    /// ```
    pub fn set_bodies_collide(&mut self, a: BodyId, b: BodyId, collide: bool) -> bool {
        let bodies = &mut self.tables.bodies;
        let (Some(a), Some(b)) = (bodies.rows.row(a), bodies.rows.row(b)) else { return false };
        if a == b {
            return false;
        }
        let pair = (a.min(b), a.max(b));
        let changes =
            if collide { bodies.strangers.remove(&pair) } else { bodies.strangers.insert(pair) };
        if changes {
            self.sets().wake(a);
            self.sets().wake(b);
            self.end_forbidden(a);
            // They look for pairs again.
            for body in [a, b] {
                self.refresh_bounds(body);
            }
        }
        true
    }

    /// False if two bodies were told never to collide: see [`Self::set_bodies_collide`].
    #[must_use]
    pub fn bodies_collide(&self, a: BodyId, b: BodyId) -> bool {
        let bodies = &self.tables.bodies;
        let rows = bodies.rows.row(a).zip(bodies.rows.row(b));
        rows.is_none_or(|(a, b)| !bodies.are_strangers(a, b))
    }

    /// Replaces the rules of surfaces, 256 at most. What touches and now has another surface wakes.
    ///
    /// ```
    /// use drystone::World;
    /// use drystone::contact::SurfaceRule;
    ///
    /// let (ice, rubber) = (1 << 1, 1 << 2);
    /// let mut world = World::default();
    /// let slick = SurfaceRule { friction: Some(0.05), ..SurfaceRule::between(ice, rubber) };
    /// world.set_surface_rules(vec![slick])?;
    /// # Ok::<(), drystone::DefError>(())
    /// ```
    ///
    /// # Errors
    /// A coefficient is out of range, or there are too many rules. Then nothing is changed.
    pub fn set_surface_rules(&mut self, rules: Vec<SurfaceRule>) -> Result<(), DefError> {
        if rules.len() > MOST_RULES {
            return Err(DefError::new("rules", rules.len(), "at most 256"));
        }
        rules.iter().try_for_each(SurfaceRule::validate)?;
        self.tables.shapes.rules = rules;
        let rows: Vec<u32> = self.tables.contacts.iter().map(|(row, _)| row).collect();
        for row in rows {
            let c = self.tables.contacts.at(row);
            let surface = self.tables.shapes.surface_of(c.shape_a, c.shape_b);
            if !surface.is_of(c) {
                let bodies = [c.body_a, c.body_b];
                let mut sets = self.sets();
                sets.set_surface(row, &surface);
                bodies.into_iter().for_each(|body| sets.wake(body));
            }
        }
        Ok(())
    }

    /// The rules of surfaces, in the order in which they are asked.
    #[must_use]
    pub fn surface_rules(&self) -> &[SurfaceRule] {
        &self.tables.shapes.rules
    }
}
