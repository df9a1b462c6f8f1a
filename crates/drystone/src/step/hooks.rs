//! Hooks: user callbacks that may change or drop contacts while the narrowphase makes them.

use core::any::Any;
use core::sync::atomic::{AtomicBool, Ordering};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::{Mutex, PoisonError};

use crate::base::id::{BodyId, ShapeId};
use crate::base::limits;
use crate::base::math::Vec3;
use crate::base::pose::Pose;
use crate::geometry::manifold::Manifold;
use crate::state::bodies::body::Body;
use crate::state::def::material::ContactSoftness;
use crate::state::shapes::ShapeRow;

/// User callbacks on contacts: see [`World::step_with`](crate::World::step_with).
pub trait ContactHooks: Sync {
    /// Called in each step for each contact of a pair, before the contact is solved, if one of the
    /// shapes [has hooks](crate::ShapeDef::with_hooks). The callback may drop the contact, or
    /// change its friction, restitution and softness, for this step only. A pair with a mesh has
    /// several contacts. If one body is so fast that it would pass the other within the step, the
    /// callback runs again: see [`HookedContact::is_sweep`].
    ///
    /// Several threads call it at once, in no order. The step gives the same bits for any number of
    /// threads if the answer depends only on the contact and on data that does not change in the
    /// step.
    fn contact(&self, contact: &mut HookedContact<'_>);
}

/// A contact that is about to be solved.
#[derive(Debug)]
pub struct HookedContact<'a> {
    pub(super) ids: [(ShapeId, BodyId); 2],
    pub(super) shapes: [&'a ShapeRow; 2],
    pub(super) motions: [Motion; 2],
    pub(super) manifold: &'a Manifold,
    pub(super) pose_a: &'a Pose,
    pub(super) touched: bool,
    pub(super) is_sweep: bool,
    pub(super) surface: Surface,
    pub(super) dropped: bool,
}

/// Motion of a body: center of mass [m], velocities [m/s, rad/s], all in the world frame.
#[derive(Clone, Copy, Debug)]
pub(super) struct Motion {
    pub(super) center: Vec3,
    pub(super) v: Vec3,
    pub(super) w: Vec3,
}

impl Motion {
    pub(super) const fn of(body: &Body) -> Self {
        Self { center: body.center, v: body.v, w: body.w }
    }
}

/// Properties of a contact that hooks may change.
#[derive(Clone, Copy, Debug)]
pub(super) struct Surface {
    pub(super) friction: f32,
    pub(super) restitution: f32,
    pub(super) softness: Option<ContactSoftness>,
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

    /// Normal, a unit vector from A to B [world].
    #[must_use]
    pub fn normal(&self) -> Vec3 {
        self.pose_a.direction(self.manifold.normal)
    }

    /// The contact's points, 1 to 4: position [m, world] and separation along the normal [m];
    /// negative: overlap. They include speculative points, which the bodies may reach in the step.
    pub fn points(&self) -> impl Iterator<Item = (Vec3, f32)> + '_ {
        self.manifold.points().iter().map(|p| (self.pose_a.point(p.position), p.separation))
    }

    /// Velocity of B relative to A at a point [m/s, m, world].
    #[must_use]
    pub fn velocity_at(&self, point: impl Into<Vec3>) -> Vec3 {
        let point = point.into();
        let [a, b] = self.motions.map(|body| body.v + body.w.cross(point - body.center));
        b - a
    }

    /// Whether the pair touched before this step.
    #[must_use]
    pub const fn touched(&self) -> bool {
        self.touched
    }

    /// True if a body is so fast that it would pass the other one in this step, or end deep in it.
    /// The answer decides whether it is stopped at the impact. Points and normal are those of the
    /// impact, velocities those of the end of the step, and only
    /// [`drop_contact`](Self::drop_contact) has an effect. A pair may get several such calls in a
    /// step.
    #[must_use]
    pub const fn is_sweep(&self) -> bool {
        self.is_sweep
    }

    /// Coulomb friction coefficient of sticking contacts.
    #[must_use]
    pub const fn friction(&self) -> f32 {
        self.surface.friction
    }

    /// Coefficient of restitution.
    #[must_use]
    pub const fn restitution(&self) -> f32 {
        self.surface.restitution
    }

    /// Softness of the contact; `None`: that of the world's contacts.
    #[must_use]
    pub const fn softness(&self) -> Option<ContactSoftness> {
        self.surface.softness
    }

    /// Sets the friction coefficient for this step, from 0 to 1e6. Smaller values count as 0,
    /// larger ones as 1e6, and NaN changes nothing. Sliding friction keeps its ratio to this
    /// coefficient.
    pub const fn set_friction(&mut self, friction: f32) {
        if !friction.is_nan() {
            self.surface.friction = friction.clamp(0.0, limits::FRICTION.maximum);
        }
    }

    /// Sets the coefficient of restitution for this step, from 0 to 1. Smaller values count as 0,
    /// larger ones as 1, and NaN changes nothing. A pair bounces in the step in which it meets, so
    /// give the same answer from the first point on.
    pub const fn set_restitution(&mut self, restitution: f32) {
        if !restitution.is_nan() {
            self.surface.restitution = restitution.clamp(0.0, limits::RESTITUTION.maximum);
        }
    }

    /// Sets the softness for this step, or with `None` that of the world's contacts. Values out of
    /// range are clamped, and NaN changes nothing.
    pub const fn set_softness(&mut self, softness: Option<ContactSoftness>) {
        let Some(ContactSoftness { hertz, damping_ratio }) = softness else {
            self.surface.softness = None;
            return;
        };
        if hertz.is_nan() || damping_ratio.is_nan() {
            return;
        }
        let (minimum, maximum) =
            (limits::SPRING_FREQUENCY.minimum, limits::SPRING_FREQUENCY.maximum);
        let hertz = hertz.clamp(minimum, maximum);
        let damping_ratio = damping_ratio.clamp(0.0, limits::DAMPING_RATIO.maximum);
        self.surface.softness = Some(ContactSoftness { hertz, damping_ratio });
    }

    /// Lets the shapes pass each other at this contact, in this step.
    pub const fn drop_contact(&mut self) {
        self.dropped = true;
    }
}

/// The hooks of a step. A panic of a hook is resumed after the step; no hook is called after it in
/// that step.
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

    /// Payload of the first panic of a hook.
    pub(crate) fn into_panic(self) -> Option<Box<dyn Any + Send>> {
        self.panic.into_inner().unwrap_or_else(PoisonError::into_inner)
    }

    pub(super) fn call(&self, contact: &mut HookedContact<'_>) {
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
