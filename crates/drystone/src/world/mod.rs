//! Layer 4: the public API. It checks the user's arguments and translates ids to rows. It keeps the
//! tables consistent when something is added, changed or removed.

mod add;
mod articulation;
mod audit;
mod body;
mod breakage;
mod change;
mod clock;
mod draw;
mod faults;
mod frame;
mod impact;
mod joint;
mod mover;
mod particle;
mod origin;
mod rules;
mod shape;
mod touches;
mod view;
pub(crate) mod refused;
pub(crate) mod saving;

pub use self::articulation::{ArticulationDef, ArticulationMut, ArticulationRef};
pub use self::body::{BodyMut, BodyRef};
pub use self::breakage::BondRef;
pub use self::clock::Clock;
pub use self::draw::{DebugColor, DebugDraw, DebugDrawOptions, DebugTint};
pub use self::impact::{Impact, ImpactBody, ImpactSurface, impact};
pub use self::joint::JointRef;
pub use self::joint::axis::{AxisMut, AxisRef};
pub use self::joint::change::JointMut;
pub use self::mover::{Moved, Mover, MoverHit};
pub use self::particle::strand::{ClothDef, RopeDef, Strand};
pub use self::particle::{LinkMut, LinkRef, ParticleMut, ParticleRef};
#[cfg(feature = "snapshot")]
pub use self::saving::delta::{DeltaError, apply_delta, write_delta};
pub use self::saving::hashes::StageHashes;
#[cfg(feature = "snapshot")]
pub use self::saving::journal::{
    Answer, AxisCall, BodyCall, Call, Difference, JointCall, Journal, JournalError, ParticleCall,
    ShapeCall,
};
#[cfg(feature = "snapshot")]
pub use self::saving::library::{GeometryKey, Library};
#[cfg(feature = "snapshot")]
pub use self::saving::snapshot::SnapshotError;
pub use self::shape::ShapeMut;
pub use self::view::{ContactPoint, ContactRef, WorldCounts};

use core::num::NonZeroUsize;
use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};
use std::sync::Arc;

use crate::base::grow::Slack;
use crate::base::id::{BodyId, JointId, ShapeId};
use crate::base::limits;
use crate::base::math::Vec3;
use crate::base::simd::wide::SimdLevel;
use crate::base::threads::checked::{Checked, Claims};
use crate::base::threads::jobs::{Executor, Inline};
use crate::base::threads::team::Team;
use crate::query::Query;
use crate::query::audit::Books;
use crate::query::particles::particle_sums;
use crate::query::shape::ShapeRef;
use crate::state::def::DefError;
use crate::state::def::config::WorldConfig;
use crate::state::events::{Events, Fault, FaultKind};
use crate::state::sets::Sets;
use crate::state::tables::Tables;
use crate::step::context::StepContext;
use crate::step::hooks::{ContactHooks, Hooks};
use crate::step::{self, Scratch, Stage};

/// A world of bodies.
///
/// It owns everything in it, can be cloned, and can be sent to another thread. The same calls give
/// the same bits for any number of threads, at any SIMD level, in debug and release.
///
/// The manual: [first steps](crate::manual::first_steps), and [all chapters](crate::manual).
#[derive(Debug)]
pub struct World {
    tables: Tables,
    scratch: Scratch,
    jobs: Arc<dyn Executor>,
    claims: Claims,
    level: SimdLevel,
    /// Length of the last substep [s]; 0 before the first.
    last_h: f32,
    /// Events caused by the user's calls since the last step. The next step reports them.
    pending: Events,
    /// Tracks the spare capacity of the lists of contacts that began and ended.
    slack: Slack,
    breaking: breakage::Scratch,
    /// Energy and momentum ledger, open since [`World::begin_ledger`].
    books: Option<Box<Books>>,
}

impl Default for World {
    /// An empty world with the default configuration.
    fn default() -> Self {
        Self {
            tables: Tables::default(),
            scratch: Scratch::default(),
            jobs: Arc::new(Inline),
            claims: Claims::default(),
            level: SimdLevel::best(),
            last_h: 0.0,
            pending: Events::default(),
            slack: Slack::default(),
            breaking: breakage::Scratch::default(),
            books: None,
        }
    }
}

/// Worlds can be sent to other threads and read by several threads at once.
const _: () = {
    const fn is_send_and_sync<T: Send + Sync>() {}
    is_send_and_sync::<World>();
};

impl World {
    /// An empty world.
    ///
    /// # Errors
    /// The first field of the configuration that is out of range.
    pub fn new(config: WorldConfig) -> Result<Self, DefError> {
        config.validate()?;
        let tables = Tables { config, ..Tables::default() };
        Ok(Self { tables, ..Self::default() })
    }

    /// Runs the work of this world on `jobs`, for example a [`crate::threads::Team`]. The result of
    /// a step does not depend on the executor.
    #[must_use]
    pub fn with_executor(mut self, jobs: Arc<dyn Executor>) -> Self {
        self.jobs = jobs;
        self
    }

    /// Runs the work of this world on this many threads, including the caller's; 0: as many as the
    /// machine has cores. The result of a step does not depend on the number of threads.
    ///
    /// A new world uses only the caller's thread. Each call starts its own threads, which end with
    /// the world. Worlds that take turns can share one [`Team`] through [`Self::with_executor`].
    ///
    /// ```
    /// use drystone::World;
    ///
    /// let mut world = World::default().with_threads(0);
    /// world.step(1.0 / 60.0);
    /// ```
    #[must_use]
    pub fn with_threads(self, threads: usize) -> Self {
        let all = || std::thread::available_parallelism().map_or(1, NonZeroUsize::get);
        let threads = if threads == 0 { all() } else { threads };
        let jobs: Arc<dyn Executor> =
            if threads > 1 { Arc::new(Team::new(threads)) } else { Arc::new(Inline) };
        self.with_executor(jobs)
    }

    /// Runs the work of steps on `jobs`.
    pub fn set_executor(&mut self, jobs: Arc<dyn Executor>) {
        self.jobs = jobs;
    }

    /// The SIMD level in use; default: the best level that the machine has.
    #[must_use]
    pub const fn simd_level(&self) -> SimdLevel {
        self.level
    }

    /// Sets the SIMD level. The result of a step does not depend on it.
    pub fn set_simd_level(&mut self, level: SimdLevel) {
        self.level = level;
    }

    /// The configuration.
    #[must_use]
    pub const fn config(&self) -> &WorldConfig {
        &self.tables.config
    }

    /// Replaces the configuration. Wakes all bodies if gravity changed, or if only one of the two
    /// methods freezes bodies one by one.
    ///
    /// # Errors
    /// The first field that is out of range; then nothing is changed.
    pub fn set_config(&mut self, config: WorldConfig) -> Result<(), DefError> {
        config.validate()?;
        if config.method.is_classic() && !self.tables.articulations.rows.is_empty() {
            return Err(DefError::unsuitable(
                "method",
                "a classic method, for a world with articulations",
                "a default method",
            ));
        }
        let old = &self.tables.config;
        let wake = config.gravity != old.gravity || config.method.freezes() != old.method.freezes();
        let has_length = config.length_scale.to_bits() == old.length_scale.to_bits();
        if config.contact_lengths().margin > old.contact_lengths().margin || !has_length {
            // Shapes that fitted their fat boxes may no longer fit.
            for body in self.tables.bodies.rows.values_mut().iter_mut().flatten() {
                body.room = 0.0;
            }
        }
        self.tables.config = config;
        if !has_length {
            self.tables.contacts.forget_gaps(&self.tables.bodies.tracks);
        }
        if wake {
            self.wake_all();
        }
        Ok(())
    }

    /// See [`Self::set_gravity`].
    pub(super) fn try_set_gravity(&mut self, gravity: impl Into<Vec3>) -> Result<(), DefError> {
        self.set_config(WorldConfig { gravity: gravity.into(), ..self.tables.config.clone() })
    }

    /// Wakes all bodies and particles.
    pub fn wake_all(&mut self) {
        let rows: Vec<u32> = self.tables.bodies.rows.iter().map(|(id, _)| id.index()).collect();
        for row in rows {
            self.sets().wake(row);
        }
        self.tables.particles.wake_all();
    }

    /// Advances time by `dt` [s], 1e-6 to 10.
    ///
    /// A step cannot fail. A body that becomes non-finite is stopped, left out of further steps and
    /// reported in [`Events::faults`]. A `dt` out of range is reported there too, and no time
    /// passes.
    pub fn step(&mut self, dt: f32) {
        self.advance(dt, None, &mut |_| {});
        if let Some(payload) = self.claims.take_panic() {
            resume_unwind(payload);
        }
    }

    /// Like [`Self::step`], and calls `hooks` for each contact of shapes that [have
    /// hooks](crate::ShapeDef::with_hooks).
    ///
    /// A hook may drop the contact, or change its friction, restitution and softness for this step.
    /// Several threads call hooks at once: see [`ContactHooks`]. A fast body also passes through
    /// contacts that hooks drop. If a hook panics, no hook is called again in this step. The step
    /// is completed, and then the panic resumes.
    ///
    /// ```
    /// use drystone::{BodyDef, ShapeDef, World};
    /// use drystone::contact::{ContactHooks, HookedContact};
    ///
    /// /// Ghosts, whose shapes have the number 1, pass everything.
    /// struct Ghosts;
    ///
    /// impl ContactHooks for Ghosts {
    ///     fn contact(&self, contact: &mut HookedContact<'_>) {
    ///         if contact.user_data_a() == 1 || contact.user_data_b() == 1 {
    ///             contact.drop_contact();
    ///         }
    ///     }
    /// }
    ///
    /// # fn main() -> Result<(), drystone::DefError> {
    /// let mut world = World::default();
    /// world.add_body(BodyDef::fixed().with_shape(ShapeDef::half_space([0.0, 1.0, 0.0], 0.0)))?;
    /// let shape = ShapeDef { user_data: 1, ..ShapeDef::sphere(0.5).with_hooks() };
    /// let ghost = BodyDef::dynamic().with_position([0.0, 0.5, 0.0]);
    /// let ghost = world.add_body(ghost.with_shape(shape))?;
    /// for _ in 0..60 {
    ///     world.step_with(1.0 / 60.0, &Ghosts);
    /// }
    /// assert!(world.body(ghost).is_some_and(|ghost| ghost.position().y < -3.0));
    /// # Ok(())
    /// # }
    /// ```
    pub fn step_with(&mut self, dt: f32, hooks: &dyn ContactHooks) {
        let hooks = Hooks::new(hooks);
        self.advance(dt, Some(&hooks), &mut |_| {});
        if let Some(payload) = hooks.into_panic().or_else(|| self.claims.take_panic()) {
            resume_unwind(payload);
        }
    }

    /// Like [`Self::step`], and calls `after` when each stage is done, for example to measure
    /// times. If `after` panics, it is not called again in this step. The step is completed, and
    /// then the panic resumes.
    pub fn step_observed(&mut self, dt: f32, after: &mut dyn FnMut(Stage)) {
        // A step that has begun is completed. A panic of the observer resumes when the world is
        // consistent.
        let mut panic = None;
        let mut guarded = |stage| {
            if panic.is_none() {
                panic = catch_unwind(AssertUnwindSafe(|| after(stage))).err();
            }
        };
        self.advance(dt, None, &mut guarded);
        if let Some(payload) = panic.or_else(|| self.claims.take_panic()) {
            resume_unwind(payload);
        }
    }

    /// Runs one step. `after` does not panic.
    fn advance(&mut self, dt: f32, hooks: Option<&Hooks<'_>>, after: &mut dyn FnMut(Stage)) {
        let checked = Checked::new(&*self.jobs, &self.claims);
        let jobs = checked.jobs();
        let events = &mut self.tables.events;
        let maximum = events.contact_begin.len().max(events.contact_end.len());
        events.clear();
        if let Some(enough) = self.slack.look(maximum) {
            events.contact_begin.shrink_to(enough);
            events.contact_end.shrink_to(enough);
        }
        // Swapping keeps the memory of both lists.
        let (events, pending) = (&mut self.tables.events, &mut self.pending);
        pending.settle_sleep();
        core::mem::swap(&mut events.wake, &mut pending.wake);
        // Sleeping by hand is rare. Swapping these lists would keep two lists at full capacity.
        events.sleep.append(&mut pending.sleep);
        core::mem::swap(&mut events.contact_end, &mut pending.contact_end);
        core::mem::swap(&mut events.sensor_exit, &mut pending.sensor_exit);
        core::mem::swap(&mut events.detached, &mut pending.detached);
        core::mem::swap(&mut events.faults, &mut pending.faults);
        let begun = core::mem::take(&mut pending.contact_begin);
        pending.clear();
        if !limits::TIME_STEP.admits(dt) {
            let step = self.tables.steps + 1;
            let kind = FaultKind::BadTimeStep;
            let fault = Fault { body: None, joint: None, particle: None, kind, step };
            self.tables.events.faults.push(fault);
            self.tell_begun(begun);
            return;
        }
        let ctx = StepContext::new(&self.tables.config, dt, self.last_h, self.level.0);
        if let Some(books) = &mut self.books {
            books.before_step(&self.tables);
        }
        step::step(&ctx, &mut self.tables, &mut self.scratch, &jobs, hooks, after);
        self.tell_begun(begun);
        self.take_out_faulted();
        self.stop_sleeping_articulations();
        self.break_joints(ctx.inv_h, dt);
        self.tables.steps += 1;
        self.last_h = ctx.h;
        if let Some(books) = &mut self.books {
            books.after_step(&self.tables, ctx.substeps);
        }
        // Breakage conserves energy, and the ledger identifies bodies by their rows.
        self.break_bodies(dt);
        after(Stage::Breakage);
    }

    /// Access to the tables for tests of a stage.
    #[cfg(test)]
    pub(crate) fn tables_mut(&mut self) -> &mut Tables {
        &mut self.tables
    }

    /// Number of steps taken.
    #[must_use]
    pub const fn step_count(&self) -> u64 {
        self.tables.steps
    }

    /// Number of sweeps over the contacts in the last step, summed over all substeps. The solver
    /// time grows with it.
    #[must_use]
    pub const fn sweep_count(&self) -> u32 {
        self.scratch.sweeps()
    }

    /// Events of the last step.
    #[must_use]
    pub const fn events(&self) -> &Events {
        &self.tables.events
    }

    /// Queries: rays, shape casts, overlaps and nearest shapes.
    #[must_use]
    pub fn query(&self) -> Query<'_> {
        Query::new(&self.tables, &*self.jobs, self.level)
    }

    /// The body, unless it was removed.
    #[must_use]
    pub fn body(&self, id: BodyId) -> Option<BodyRef<'_>> {
        BodyRef::new(&self.tables, id)
    }

    /// The body for changes, unless it was removed.
    #[must_use]
    pub fn body_mut(&mut self, id: BodyId) -> Option<BodyMut<'_>> {
        BodyMut::new(self, id)
    }

    /// All bodies in the order of their slots.
    pub fn bodies(&self) -> impl Iterator<Item = BodyRef<'_>> {
        self.tables.bodies.rows.iter().filter_map(|(id, _)| self.body(id))
    }

    fn enabled(&self) -> impl Iterator<Item = BodyRef<'_>> {
        self.bodies().filter(BodyRef::is_enabled)
    }

    /// The bodies that the last step may have moved: awake bodies and bodies that fell asleep at
    /// the end of the step. Bodies moved by the user's calls are not included. Each body appears
    /// once, in an unspecified order that is the same for any number of threads.
    ///
    /// The cost grows with the number of these bodies, not of all bodies. Use it to copy poses to
    /// another place.
    pub fn moved_bodies(&self) -> impl Iterator<Item = BodyRef<'_>> {
        let bodies = &self.tables.bodies;
        let awake = bodies.awake.iter().map(|row| bodies.id(*row));
        let asleep = self.tables.events.sleep.iter().copied();
        let still =
            asleep.filter(|id| bodies.rows.row(*id).is_some_and(|row| !bodies.at(row).active()));
        awake.chain(still).filter_map(|id| self.body(id))
    }

    /// The shape, unless it was removed.
    #[must_use]
    pub fn shape(&self, id: ShapeId) -> Option<ShapeRef<'_>> {
        ShapeRef::new(&self.tables, id)
    }

    /// The shape for changes, unless it was removed.
    pub fn shape_mut(&mut self, id: ShapeId) -> Option<ShapeMut<'_>> {
        ShapeMut::new(self, id)
    }

    /// The joint, unless it was removed.
    #[must_use]
    pub fn joint(&self, id: JointId) -> Option<JointRef<'_>> {
        JointRef::new(&self.tables, id, self.last_h)
    }

    /// The joint for changes, unless it was removed.
    #[must_use]
    pub fn joint_mut(&mut self, id: JointId) -> Option<JointMut<'_>> {
        JointMut::new(self, id)
    }

    /// All joints in the order of their slots.
    pub fn joints(&self) -> impl Iterator<Item = JointRef<'_>> {
        self.tables.joints.rows.iter().filter_map(|(id, _)| self.joint(id))
    }

    /// All contacts that have points, in the order of their rows.
    pub fn contacts(&self) -> impl Iterator<Item = ContactRef<'_>> {
        view::contacts(&self.tables)
    }

    /// The contacts between two bodies that have points, in no promised order; none if a body was
    /// removed. The search walks the contact list of one body. If only one body is dynamic, it
    /// walks that body's list.
    pub fn contacts_between(&self, a: BodyId, b: BodyId) -> impl Iterator<Item = ContactRef<'_>> {
        view::contacts_between(&self.tables, a, b)
    }

    /// Numbers of bodies, shapes, joints and so on.
    #[must_use]
    pub fn counts(&self) -> WorldCounts {
        view::counts(&self.tables)
    }

    /// Kinetic energy of all dynamic bodies and particles [J].
    #[must_use]
    pub fn kinetic_energy(&self) -> f64 {
        let bodies: f64 = self.enabled().map(|b| f64::from(b.kinetic_energy())).sum();
        bodies + particle_sums(&self.tables).linear
    }

    /// Potential energy of all dynamic bodies and particles in the world's gravity [J], zero at the
    /// origin.
    #[must_use]
    pub fn potential_energy(&self) -> f64 {
        let bodies: f64 = self.enabled().map(|b| f64::from(b.potential_energy())).sum();
        bodies + particle_sums(&self.tables).potential
    }

    /// Linear momentum of all dynamic bodies and particles [kg m/s, world].
    #[must_use]
    pub fn momentum(&self) -> Vec3 {
        let free = self.particles().filter(|p| !p.is_pinned());
        let particles = free.fold(Vec3::ZERO, |sum, p| sum + p.velocity() * p.mass());
        let bodies = self.enabled();
        bodies.fold(particles, |sum, b| sum + b.linear_velocity() * b.mass())
    }

    fn sets(&mut self) -> Sets<'_> {
        let Tables { bodies, joints, contacts, islands, colors, .. } = &mut self.tables;
        Sets { bodies, joints, contacts, islands, colors, events: &mut self.pending }
    }
}
