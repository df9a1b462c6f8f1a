//! Gate: decides which manifolds of a pair become contacts, for one-way surfaces and for shapes
//! with hooks.

use super::lent::Pairs;
use crate::base::id::{BodyId, ShapeId};
use crate::base::pose::Pose;
use crate::base::threads::disjoint::Rows;
use crate::geometry::manifold::Manifold;
use crate::state::bodies::body::Body;
use crate::state::contacts::{Contact, Softened};
use crate::state::shapes::{PairSurface, ShapeRow};
use crate::step::context::StepContext;
use crate::step::hooks::{HookedContact, Hooks, Motion, Surface};
use crate::step::one_way;
use crate::step::one_way::Fronts;

/// Inputs of the decision on the contacts of a pair.
pub(super) struct Gate<'a> {
    fronts: Fronts,
    hooks: Option<&'a Hooks<'a>>,
    ids: [(ShapeId, BodyId); 2],
    shapes: [&'a ShapeRow; 2],
    bodies: [&'a Body; 2],
    /// The pair had points before.
    held: bool,
    touched: bool,
    /// Friction, restitution and softness that follow from the shapes.
    surface: Surface,
}

/// Surface properties of an admitted contact.
#[derive(Clone, Copy)]
pub(super) struct Admitted {
    surface: Surface,
    is_hooked: bool,
}

impl Admitted {
    /// Stores them in the contact, whose row is given.
    pub(super) fn tell(&self, row: u32, contact: &mut Contact, softened: &Rows<'_, Softened>) {
        let Surface { friction, restitution, softness } = self.surface;
        (contact.friction, contact.restitution) = (friction, restitution);
        if self.is_hooked {
            *softened.row(row as usize) = softness;
        }
    }
}

impl<'a> Pairs<'a> {
    pub(super) fn gate(&self, contact: &Contact) -> Gate<'a> {
        let ends = [(contact.shape_a, contact.body_a), (contact.shape_b, contact.body_b)];
        let (table, bodies) = (self.shapes, self.bodies);
        let shapes = ends.map(|(shape, _)| table.at(shape));
        let has_hooks = shapes.iter().any(|shape| shape.reports.has_hooks());
        let surface = table.surface_of(contact.shape_a, contact.shape_b);
        let PairSurface { friction, restitution, softness, .. } = surface;
        Gate {
            fronts: ends.map(|(shape, body)| one_way::front(table, shape, bodies.at(body))),
            hooks: self.asked.hooks.filter(|_| has_hooks),
            ids: ends.map(|(shape, body)| (table.id(shape), bodies.id(body))),
            shapes,
            bodies: ends.map(|(_, body)| bodies.at(body)),
            held: contact.touching || contact.count > 0,
            touched: contact.touching,
            surface: Surface { friction, restitution, softness },
        }
    }
}

impl Gate<'_> {
    /// Surface properties of a contact with this manifold; `None` if the shapes pass each other.
    pub(super) fn admit(
        &self,
        ctx: &StepContext,
        manifold: &Manifold,
        pose_a: &Pose,
    ) -> Option<Admitted> {
        if !one_way::holds(ctx, &self.fronts, self.bodies, (manifold, pose_a), self.held) {
            return None;
        }
        let Self { ids, shapes, bodies, touched, surface, .. } = *self;
        let Some(hooks) = self.hooks else { return Some(Admitted { surface, is_hooked: false }) };
        let mut contact = HookedContact {
            ids,
            shapes,
            motions: bodies.map(Motion::of),
            manifold,
            pose_a,
            touched,
            is_sweep: false,
            surface,
            dropped: false,
        };
        hooks.call(&mut contact);
        let admitted = Admitted { surface: contact.surface, is_hooked: true };
        (!contact.dropped).then_some(admitted)
    }
}
