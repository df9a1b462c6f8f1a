//! Diagnostics of a world: its accuracy, and why bodies are awake.

use super::World;
use crate::base::id::BodyId;
use crate::query::audit::{self, Audit, Books, Ledger, WorstConstraint};
use crate::query::stiffness::{PenaltyLimit, penalty_limit};
use crate::query::why_awake::{WhyAwake, why_awake};
use crate::state::def::method::Method;

impl World {
    /// Measures the accuracy of the current state: energy, momentum, overlaps, joint errors,
    /// friction cones, and the unsolved remainder of the last step's contacts. It only reads, and
    /// walks over all bodies, contacts and joints.
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

    /// Stiffness of the current contacts as springs of the configuration's `penalty`, and the
    /// longest substep for which the method `penalty` is stable. Additional bodies at rest on each
    /// other make it shorter.
    #[must_use]
    pub fn penalty_limit(&self) -> PenaltyLimit {
        penalty_limit(&self.tables)
    }

    /// Residual of the method `analytic` in the last step: the largest remaining demand of a row,
    /// as a fraction of the maximum speed of a contact point before the solve. 0 with other
    /// methods. Above 1e-6 the solve failed: [`Self::warnings`] gives the reason.
    #[must_use]
    pub fn contact_residual(&self) -> f64 {
        self.scratch.residual().0
    }

    /// Warnings about steps of `dt` [s], one sentence each: `penalty` is beyond its limit of
    /// stability, or `analytic` failed in the last step.
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

    /// The contact or joint with the largest error [m]; `None` if no error is above 0.
    #[must_use]
    pub fn worst_constraint(&self) -> Option<WorstConstraint> {
        audit::worst_constraint(&self.tables)
    }

    /// Opens a ledger of energy that enters and leaves the world: see [`Audit::ledger`]. A ledger
    /// that is already open starts again. It costs two walks over the dynamic bodies in each step,
    /// including sleeping ones: some 450 instructions per body, 2 % of a step of a large pyramid.
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

    /// Closes the ledger and returns it. `None` if none was open.
    pub fn end_ledger(&mut self) -> Option<Ledger> {
        self.books.take().map(|books| books.ledger(&self.tables))
    }

    /// The reason why a body is awake: the cause that keeps its island awake, the body with that
    /// cause, and the path to it over contacts and joints. `None` if there is no such body. It only
    /// reads, and walks over the island.
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
