//! What a world can say of itself: how right it is, and why it is awake.

use super::World;
use crate::base::id::BodyId;
use crate::query::audit::{self, Audit, Books, Ledger, WorstConstraint};
use crate::query::stiffness::{PenaltyLimit, penalty_limit};
use crate::query::why_awake::{WhyAwake, why_awake};
use crate::state::method::Method;

impl World {
    /// How right the world is now: energy, momentum, overlaps, joint errors, friction cones, what the
    /// contacts of the last step left unsolved. Only reads; takes a walk over all bodies, contacts and
    /// joints.
    ///
    /// ```
    /// # fn main() -> Result<(), drystone::DefError> {
    /// use drystone::{BodyDef, ShapeDef, World};
    ///
    /// let mut world = World::default();
    /// world.add_body(BodyDef::fixed().with_shape(ShapeDef::half_space([0.0, 1.0, 0.0], 0.0)))?;
    /// let cube = BodyDef::dynamic().with_position([0.0, 0.5, 0.0]);
    /// world.add_body(cube.with_shape(ShapeDef::box_half([0.5; 3])))?;
    /// for _ in 0..20 {
    ///     world.step(1.0 / 60.0);
    /// }
    /// let audit = world.audit();
    /// assert_eq!(audit.momentum.mass, 1000.0);
    /// assert_eq!(audit.penetration.points, 4);
    /// assert!(audit.penetration.max < 1.0e-4, "{} m", audit.penetration.max);
    /// assert!(audit.residual.relative < 0.01);
    /// assert!(audit.non_finite.is_empty());
    /// # Ok(())
    /// # }
    /// ```
    #[must_use]
    pub fn audit(&self) -> Audit {
        audit::audit(&self.tables, self.books.as_deref(), self.last_h, self.context().substeps)
    }

    /// How stiff the contacts of now are as springs of the configuration's `penalty`, and the longest substep
    /// with which the method `penalty` stays stable. Bodies that come to lie on each other make it shorter.
    #[must_use]
    pub fn penalty_limit(&self) -> PenaltyLimit {
        penalty_limit(&self.tables)
    }

    /// How far the method `analytic` was from solving the contacts in the last step: what a row still asked
    /// for, as a part of the greatest speed of a contact point before; 0 with other methods. Above 1e-6 it
    /// gave up: [`Self::warnings`] says why.
    #[must_use]
    pub fn contact_residual(&self) -> f64 {
        self.scratch.residual().0
    }

    /// What will go wrong with steps of `dt` [s], as far as it can be known: that `penalty` is beyond its
    /// limit of stability, or that `analytic` gave up in the last step. A sentence each.
    #[must_use]
    pub fn warnings(&self, dt: f32) -> Vec<String> {
        let config = &self.tables.config;
        let mut warnings = Vec::new();
        if config.method.name() == Method::penalty().name() && dt > 0.0 {
            let substeps = self.context().substeps;
            #[expect(clippy::cast_precision_loss, reason = "at most 256")]
            let h = dt / substeps as f32;
            let limit = self.penalty_limit();
            if h > limit.longest_substep {
                warnings.push(format!(
                    "substeps of {h:.6} s are longer than {:.6} s, the limit of stability of the contact \
                     springs (penalty.hertz={}, up to {:.1} Hz with the contacts of now): overlaps will \
                     grow; use more substeps, a lower penalty.hertz or penalty-implicit",
                    limit.longest_substep, config.penalty.hertz, limit.hertz
                ));
            }
        }
        let (residual, too_large) = self.scratch.residual();
        if residual > 1.0e-6 {
            let why = if too_large {
                "they are too many and too entangled for a direct solve"
            } else {
                "no impulses were found that keep Coulomb's law at all of them"
            };
            warnings.push(format!(
                "analytic left the contacts of the last step at a residual of {residual:.1e}, not 1e-6: {why}"
            ));
        }
        warnings
    }

    /// The contact or joint that is farthest from what it asks [m]; `None` if all do.
    #[must_use]
    pub fn worst_constraint(&self) -> Option<WorstConstraint> {
        audit::worst_constraint(&self.tables)
    }

    /// From now on keeps a ledger of energy, [`Audit::ledger`]: what came in, what went out. One that was
    /// open begins anew. It costs two walks over the dynamic bodies in each step,
    /// sleeping ones too: some 450 instructions a body, 2 % of a step of a large pyramid.
    ///
    /// ```
    /// # fn main() -> Result<(), drystone::DefError> {
    /// use drystone::{BodyDef, ShapeDef, World};
    ///
    /// let mut world = World::default();
    /// world.set_gravity([0.0; 3]);
    /// let ball = world.add_body(BodyDef::dynamic().with_shape(ShapeDef::sphere(0.5)))?;
    /// world.begin_ledger();
    /// for _ in 0..60 {
    ///     if let Some(mut body) = world.body_mut(ball) {
    ///         body.add_step_force([100.0, 0.0, 0.0]);
    ///     }
    ///     world.step(1.0 / 60.0);
    /// }
    /// let ledger = world.end_ledger().unwrap_or_default();
    /// // A force on a free body: all of its work is motion.
    /// assert!((ledger.forces - ledger.now.kinetic()).abs() < 1.0e-5 * ledger.forces);
    /// # Ok(())
    /// # }
    /// ```
    pub fn begin_ledger(&mut self) {
        self.books = Some(Box::new(Books::open(&self.tables)));
    }

    /// Closes the ledger; what it said. `None` if none was open.
    pub fn end_ledger(&mut self) -> Option<Ledger> {
        self.books.take().map(|books| books.ledger(&self.tables))
    }

    /// Why a body is awake: what keeps its island from sleeping, which body that is said of, and the
    /// way there over contacts and joints. `None` if there is no such body. Only reads; takes a walk over
    /// the island.
    ///
    /// ```
    /// # fn main() -> Result<(), drystone::DefError> {
    /// use drystone::{BodyDef, ShapeDef, World};
    /// use drystone::audit::AwakeCause;
    ///
    /// let mut world = World::default();
    /// let ball = BodyDef::dynamic().with_shape(ShapeDef::sphere(0.5));
    /// let ball = world.add_body(ball)?;
    /// world.step(1.0 / 60.0);
    /// let why = world.why_awake(ball).map(|why| why.cause);
    /// assert!(matches!(why, Some(AwakeCause::TooFast { .. })), "it falls");
    /// # Ok(())
    /// # }
    /// ```
    #[must_use]
    pub fn why_awake(&self, body: BodyId) -> Option<WhyAwake> {
        let row = self.tables.bodies.rows.row(body)?;
        Some(why_awake(&self.tables, row))
    }
}
