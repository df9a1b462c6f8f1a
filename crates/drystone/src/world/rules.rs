//! Rules for pairs: bodies that never collide, and surface properties between layers.

use super::World;
use crate::base::id::BodyId;
use crate::state::def::DefError;
use crate::state::def::material::SurfaceRule;
use crate::state::shapes::{PairSurface, Shapes};
use crate::state::tables::Tables;

/// Maximum number of surface rules. Each new contact is compared with all of them.
const MAX_RULES: usize = 256;

impl World {
    /// Sets whether two bodies may collide, in addition to their filters. For example, a thrower
    /// and its projectile need not collide. If that changes something, both wake, and contacts that
    /// are no longer allowed end. The rule lasts until one of the bodies is removed; pieces of a
    /// broken body do not inherit it. False if one of them is not of this world, or both are the
    /// same.
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
            // Both bodies search for pairs again.
            for body in [a, b] {
                self.refresh_bounds(body);
            }
        }
        true
    }

    /// False if the two bodies are set to never collide: see [`Self::set_bodies_collide`].
    #[must_use]
    pub fn bodies_collide(&self, a: BodyId, b: BodyId) -> bool {
        let bodies = &self.tables.bodies;
        let rows = bodies.rows.row(a).zip(bodies.rows.row(b));
        rows.is_none_or(|(a, b)| !bodies.are_strangers(a, b))
    }

    /// Replaces the surface rules, at most 256. Bodies whose contacts get another surface wake.
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
        if rules.len() > MAX_RULES {
            return Err(DefError::new("rules", rules.len(), "at most 256 in number"));
        }
        rules.iter().try_for_each(SurfaceRule::validate)?;
        let all: Vec<u32> = self.tables.contacts.iter().map(|(row, _)| row).collect();
        self.change_rules(&all, |shapes| shapes.rules = rules);
        Ok(())
    }

    /// Sets a surface rule for two bodies, which takes precedence over the rules of layers. Values
    /// that it does not set come from those rules and the materials. `None` removes it. Both bodies
    /// wake if they touch and that changes something. The rule lasts until one of the bodies is
    /// removed; pieces of a broken body do not inherit it.
    ///
    /// ```
    /// use drystone::{BodyDef, ShapeDef, World};
    /// use drystone::contact::{ContactSoftness, SurfaceRule};
    ///
    /// let mut world = World::default();
    /// let bed = world.add_body(BodyDef::fixed().with_shape(ShapeDef::box_half([2.0, 0.5, 2.0])))?;
    /// let ball = BodyDef::dynamic().with_position([0.0, 1.0, 0.0]);
    /// let ball = world.add_body(ball.with_shape(ShapeDef::sphere(0.5)))?;
    /// let soft = ContactSoftness { hertz: 3.0, damping_ratio: 0.2 };
    /// let springy = SurfaceRule { softness: Some(soft), ..SurfaceRule::ANY };
    /// world.set_surface_between(bed, ball, Some(springy))?;
    /// for _ in 0..300 {
    ///     world.step(1.0 / 60.0);
    /// }
    /// // It lies in its dent: g / (2πf)² is 28 mm.
    /// assert!(world.body(ball).is_some_and(|ball| (ball.position().y - 0.972).abs() < 1e-3));
    /// # Ok::<(), drystone::DefError>(())
    /// ```
    ///
    /// # Errors
    /// A number of the rule is out of range, one of the bodies is not of this world, or both are
    /// the same. Then nothing is changed.
    pub fn set_surface_between(
        &mut self,
        a: BodyId,
        b: BodyId,
        rule: Option<SurfaceRule>,
    ) -> Result<(), DefError> {
        rule.as_ref().map_or(Ok(()), SurfaceRule::validate)?;
        let row = |name, id: BodyId| {
            let row = self.tables.bodies.rows.row(id);
            row.ok_or_else(|| {
                DefError::missing(
                    name,
                    format_args!("BodyId {}", id.index()),
                    "a body of this world",
                )
            })
        };
        let (a, b) = (row("a", a)?, row("b", b)?);
        if a == b {
            return Err(DefError::unsuitable("b", "the same body", "a body other than `a`"));
        }
        let contacts = &self.tables.contacts;
        let of_a = contacts.of_body(self.tables.bodies.at(a)).map(|(row, _)| row);
        let is_of_b = |row: &u32| [contacts.at(*row).body_a, contacts.at(*row).body_b].contains(&b);
        let all: Vec<u32> = of_a.filter(is_of_b).collect();
        let pair = (a.min(b), a.max(b));
        self.change_rules(&all, |shapes| {
            match rule {
                Some(rule) => shapes.between.insert(pair, rule),
                None => shapes.between.remove(&pair),
            };
        });
        Ok(())
    }

    /// The surface rule for two bodies, if there is one: see [`Self::set_surface_between`].
    #[must_use]
    pub fn surface_between(&self, a: BodyId, b: BodyId) -> Option<SurfaceRule> {
        let (a, b) = self.tables.bodies.rows.row(a).zip(self.tables.bodies.rows.row(b))?;
        self.tables.shapes.between.get(&(a.min(b), a.max(b))).copied()
    }

    /// Changes rules, updates the surfaces of these contacts, and wakes the bodies of contacts
    /// whose surface changed.
    fn change_rules(&mut self, contacts: &[u32], change: impl FnOnce(&mut Shapes)) {
        let tables = &self.tables;
        let surface_of = |tables: &Tables, row: u32| {
            let c = tables.contacts.at(row);
            tables.shapes.surface_of(c.shape_a, c.shape_b)
        };
        let before: Vec<PairSurface> =
            contacts.iter().map(|row| surface_of(tables, *row)).collect();
        change(&mut self.tables.shapes);
        for (row, before) in contacts.iter().zip(before) {
            let surface = surface_of(&self.tables, *row);
            if surface != before {
                let c = self.tables.contacts.at(*row);
                let bodies = [c.body_a, c.body_b];
                let mut sets = self.sets();
                sets.set_surface(*row, &surface);
                bodies.into_iter().for_each(|body| sets.wake(body));
            }
        }
    }

    /// The surface rules, in order of precedence.
    #[must_use]
    pub fn surface_rules(&self) -> &[SurfaceRule] {
        &self.tables.shapes.rules
    }
}
