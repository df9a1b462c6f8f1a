//! Which contacts a pair lets act, where that is asked in each step: of surfaces that hold from one side only, and of shapes
//! with hooks.

use super::Pairs;
use crate::base::id::{BodyId, ShapeId};
use crate::base::pose::Pose;
use crate::geometry::manifold::Manifold;
use crate::state::bodies::Body;
use crate::state::contacts::Contact;
use crate::state::shapes::ShapeRow;
use crate::step::context::StepContext;
use crate::step::hooks::{HookedContact, Hooks};
use crate::step::one_way::{self, Fronts};

/// What decides over the contacts of a pair.
pub(super) struct Gate<'a> {
    fronts: Fronts,
    hooks: Option<&'a Hooks<'a>>,
    ids: [(ShapeId, BodyId); 2],
    shapes: [&'a ShapeRow; 2],
    bodies: [&'a Body; 2],
    /// It had points before.
    held: bool,
    touched: bool,
    /// That of the surfaces.
    friction: f32,
}

impl<'a> Pairs<'a> {
    pub(super) fn gate(&self, contact: &Contact) -> Gate<'a> {
        let ends = [(contact.shape_a, contact.body_a), (contact.shape_b, contact.body_b)];
        let (table, bodies) = (self.shapes, self.bodies);
        let shapes = ends.map(|(shape, _)| table.at(shape));
        let has_hooks = shapes.iter().any(|shape| shape.reports.has_hooks());
        Gate {
            fronts: ends.map(|(shape, body)| one_way::front(table, shape, bodies.at(body))),
            hooks: self.hooks.filter(|_| has_hooks),
            ids: ends.map(|(shape, body)| (table.id(shape), bodies.id(body))),
            shapes,
            bodies: ends.map(|(_, body)| bodies.at(body)),
            held: contact.touching || contact.count > 0,
            touched: contact.touching,
            friction: table.surface_of(contact.shape_a, contact.shape_b).friction,
        }
    }
}

impl Gate<'_> {
    /// The friction coefficient of a contact with this manifold; `None` if it is let through.
    pub(super) fn admit(
        &self,
        ctx: &StepContext,
        manifold: &Manifold,
        pose_a: &Pose,
    ) -> Option<f32> {
        if !one_way::holds(ctx, &self.fronts, self.bodies, (manifold, pose_a), self.held) {
            return None;
        }
        let Some(hooks) = self.hooks else { return Some(self.friction) };
        let Self { ids, shapes, bodies, touched, friction, .. } = *self;
        let dropped = false;
        let mut contact =
            HookedContact { ids, shapes, bodies, manifold, pose_a, touched, friction, dropped };
        hooks.ask(&mut contact);
        (!contact.dropped).then_some(contact.friction)
    }
}
