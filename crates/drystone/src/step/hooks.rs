//! A user's say in contacts, while narrowphase makes them.

use core::any::Any;
use core::sync::atomic::{AtomicBool, Ordering};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::{Mutex, PoisonError};

use crate::base::id::{BodyId, ShapeId};
use crate::base::limits;
use crate::base::math::Vec3;
use crate::base::pose::Pose;
use crate::geometry::manifold::Manifold;
use crate::state::bodies::Body;
use crate::state::shapes::ShapeRow;

/// A user's say in contacts: see [`World::step_with`](crate::World::step_with).
pub trait ContactHooks: Sync {
    /// Is asked in each step for each contact of a pair of which a shape [has hooks](crate::ShapeDef::with_hooks), before it is
    /// solved. It may drop it, or change its friction; that lasts for the step. A pair with a mesh has several contacts.
    ///
    /// Contacts are asked for by several threads at once, in no order. The step gives the same bits for any number of threads
    /// if the answer depends on nothing but the contact and what does not change in the step.
    fn contact(&self, contact: &mut HookedContact<'_>);
}

/// A contact that is about to be solved.
#[derive(Debug)]
pub struct HookedContact<'a> {
    pub(super) ids: [(ShapeId, BodyId); 2],
    pub(super) shapes: [&'a ShapeRow; 2],
    pub(super) bodies: [&'a Body; 2],
    pub(super) manifold: &'a Manifold,
    pub(super) pose_a: &'a Pose,
    pub(super) touched: bool,
    pub(super) friction: f32,
    pub(super) dropped: bool,
}

impl HookedContact<'_> {
    /// First shape.
    #[must_use]
    pub const fn shape_a(&self) -> ShapeId {
        self.ids[0].0
    }

    /// Second shape.
    #[must_use]
    pub const fn shape_b(&self) -> ShapeId {
        self.ids[1].0
    }

    /// Body of the first shape.
    #[must_use]
    pub const fn body_a(&self) -> BodyId {
        self.ids[0].1
    }

    /// Body of the second shape.
    #[must_use]
    pub const fn body_b(&self) -> BodyId {
        self.ids[1].1
    }

    /// The user's number of the first shape.
    #[must_use]
    pub const fn user_data_a(&self) -> u64 {
        self.shapes[0].user_data
    }

    /// The user's number of the second shape.
    #[must_use]
    pub const fn user_data_b(&self) -> u64 {
        self.shapes[1].user_data
    }

    /// Unit, from A to B [world].
    #[must_use]
    pub fn normal(&self) -> Vec3 {
        self.pose_a.direction(self.manifold.normal)
    }

    /// Its points, 1 to 4: where [m, world], and how far the surfaces are apart along the normal [m]; negative: overlap.
    /// Points that the bodies may come to in the step are among them.
    pub fn points(&self) -> impl Iterator<Item = (Vec3, f32)> + '_ {
        self.manifold.points().iter().map(|p| (self.pose_a.point(p.position), p.separation))
    }

    /// Velocity of B against A at a point [m/s, m, world].
    #[must_use]
    pub fn velocity_at(&self, point: impl Into<Vec3>) -> Vec3 {
        let point = point.into();
        let [a, b] = self.bodies.map(|body| body.velocity_at(point - body.center));
        b - a
    }

    /// Whether the pair touched before this step.
    #[must_use]
    pub const fn touched(&self) -> bool {
        self.touched
    }

    /// Coulomb friction coefficient of what sticks.
    #[must_use]
    pub const fn friction(&self) -> f32 {
        self.friction
    }

    /// Gives it another friction coefficient for this step, from 0 to 1e6; what is below counts as 0, what is above as 1e6, and
    /// NaN changes nothing. What slides has the same part of it as before.
    pub const fn set_friction(&mut self, friction: f32) {
        if !friction.is_nan() {
            self.friction = friction.clamp(0.0, limits::FRICTION.most);
        }
    }

    /// Lets the shapes pass each other here, in this step.
    pub const fn drop_contact(&mut self) {
        self.dropped = true;
    }
}

/// The hooks of a step. What they panic with goes on when the step is done; they are not asked again in it.
pub(crate) struct Hooks<'h> {
    hooks: &'h dyn ContactHooks,
    is_broken: AtomicBool,
    panic: Mutex<Option<Box<dyn Any + Send>>>,
}

impl core::fmt::Debug for Hooks<'_> {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.debug_struct("Hooks").finish_non_exhaustive()
    }
}

impl<'h> Hooks<'h> {
    pub(crate) const fn new(hooks: &'h dyn ContactHooks) -> Self {
        Self { hooks, is_broken: AtomicBool::new(false), panic: Mutex::new(None) }
    }

    /// What the hooks panicked with.
    pub(crate) fn into_panic(self) -> Option<Box<dyn Any + Send>> {
        self.panic.into_inner().unwrap_or_else(PoisonError::into_inner)
    }

    pub(super) fn ask(&self, contact: &mut HookedContact<'_>) {
        if self.is_broken.load(Ordering::Relaxed) {
            return;
        }
        let asked = catch_unwind(AssertUnwindSafe(|| self.hooks.contact(contact)));
        if let Err(payload) = asked {
            self.is_broken.store(true, Ordering::Relaxed);
            *self.panic.lock().unwrap_or_else(PoisonError::into_inner) = Some(payload);
        }
    }
}
