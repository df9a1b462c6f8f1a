//! Calls the hooks for shapes that meet within the step, to decide whether they stop each other: a
//! projectile passes through contacts that a hook drops.

use crate::base::id::{BodyId, ShapeId};
use crate::base::pose::Pose;
use crate::geometry::collide::{MAX_PARTS, MeshScratch, Reach, collide, collide_mesh};
use crate::geometry::manifold::{Manifold, PairCache};
use crate::geometry::solid::Core;
use crate::state::bodies::Bodies;
use crate::state::shapes::{PairSurface, ShapeRow, Shapes};
use crate::step::broadphase::rank;
use crate::step::context::StepContext;
use crate::step::hooks::{HookedContact, Hooks, Motion, Surface};

/// The hooks of a step, with the tables for their arguments.
#[derive(Clone, Copy)]
pub(super) struct HookCalls<'a> {
    pub(super) ctx: &'a StepContext,
    pub(super) hooks: &'a Hooks<'a>,
    pub(super) bodies: &'a Bodies,
    pub(super) shapes: &'a Shapes,
}

impl HookCalls<'_> {
    /// True if a pair has hooks.
    pub(super) fn are_of(&self, a: u32, b: u32) -> bool {
        [a, b].iter().any(|shape| self.shapes.at(*shape).reports.has_hooks())
    }

    /// True if the hooks let two shapes stop each other, with the centers of mass of their bodies
    /// at `poses` at the impact.
    pub(super) fn stop(&self, rows: [u32; 2], poses: [Pose; 2]) -> bool {
        let ([a, b], [at_a, at_b]) = self.in_order(rows, poses);
        let (shape_a, shape_b) = (self.shapes.at(a), self.shapes.at(b));
        let pose_a = at_a.compose(&shape_a.centered);
        let b_in_a = pose_a.relative(&at_b.compose(&shape_b.centered));
        // At the impact they are apart by a part of the thinner one's size.
        let inner = |shape: &ShapeRow| self.bodies.at(shape.body).inner;
        let near = self.ctx.margin + inner(shape_a).min(inner(shape_b));
        let mut made = [Manifold::default(); MAX_PARTS];
        let count = if let Core::Mesh(mesh) = &shape_a.solid.core {
            let (ctx, scratch) = (self.ctx, &mut MeshScratch::default());
            let (level, reach) = (ctx.level, Reach::still(near).in_lengths(ctx.length));
            collide_mesh(level, mesh, &shape_b.solid, &b_in_a, &reach, scratch, &mut made)
        } else {
            let cache = &mut PairCache::default();
            let (a, b) = (&shape_a.solid, &shape_b.solid);
            made[0] = collide(self.ctx.level, a, b, &b_in_a, near, cache);
            usize::from(made[0].count > 0)
        };
        let mut all = made[..count].iter();
        count == 0 || all.any(|manifold| self.admits([a, b], [at_a, at_b], manifold))
    }

    /// True if the hooks admit a contact of two shapes, in the order of the contact.
    fn admits(&self, rows: [u32; 2], poses: [Pose; 2], manifold: &Manifold) -> bool {
        let shapes = rows.map(|row| self.shapes.at(row));
        let PairSurface { friction, restitution, softness, .. } =
            self.shapes.surface_of(rows[0], rows[1]);
        let id = |i: usize| -> (ShapeId, BodyId) {
            (self.shapes.id(rows[i]), self.bodies.id(shapes[i].body))
        };
        let motion = |i: usize| {
            let body = self.bodies.at(shapes[i].body);
            Motion { center: poses[i].position, ..Motion::of(body) }
        };
        let mut contact = HookedContact {
            ids: [id(0), id(1)],
            shapes,
            motions: [motion(0), motion(1)],
            manifold,
            pose_a: &poses[0].compose(&shapes[0].centered),
            touched: false,
            is_sweep: true,
            surface: Surface { friction, restitution, softness },
            dropped: false,
        };
        self.hooks.call(&mut contact);
        !contact.dropped
    }

    /// The shapes and poses in the order of their contact.
    fn in_order(&self, [a, b]: [u32; 2], [at_a, at_b]: [Pose; 2]) -> ([u32; 2], [Pose; 2]) {
        let of = |row: u32| (rank(self.shapes.at(row)), row);
        if of(b) < of(a) { ([b, a], [at_b, at_a]) } else { ([a, b], [at_a, at_b]) }
    }
}
