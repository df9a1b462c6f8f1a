//! Shapes: one row each, owned by a body. Written by the world; bounds by finalize.

use std::sync::Arc;

use super::bodies::Body;
use super::material::{Filter, Material};
use crate::base::aabb::Aabb;
use crate::base::id::ShapeId;
use crate::base::pose::Pose;
use crate::base::slot_map::SlotMap;
use crate::geometry::hull::Hull;
use crate::geometry::shape::Shape;
use crate::geometry::solid::{Core, Solid};

/// A shape of a body.
#[derive(Clone, Debug)]
pub(crate) struct ShapeRow {
    pub(crate) body: u32,
    pub(crate) shape: Shape,
    pub(crate) solid: Solid,
    /// Where it sits [frame of the body's origin].
    pub(crate) local: Pose,
    /// Where it sits [frame of the body's center of mass].
    pub(crate) centered: Pose,
    pub(crate) density: f32,
    pub(crate) material: Material,
    pub(crate) filter: Filter,
    pub(crate) sensor: bool,
    /// In the tree of what does not move by itself.
    pub(crate) fixed: bool,
    /// Box in the tree: the shape's, grown [m, world].
    pub(crate) fat: Aabb,
    /// Radius for rolling resistance [m]; 0: does not roll.
    pub(crate) rolling_radius: f32,
    /// It is a hull, a half-space or a mesh: its manifolds may be recycled.
    pub(crate) flat: bool,
    pub(crate) user_data: u64,
}

impl ShapeRow {
    /// Where it is, as a shape of `body` [world].
    #[inline]
    pub(crate) fn placed(&self, body: &Body) -> Pose {
        Pose { position: body.center, rotation: body.rotation }.compose(&self.centered)
    }

    pub(crate) fn is_mesh(&self) -> bool {
        matches!(self.solid.core, Core::Mesh(_))
    }
}

/// All shapes.
#[derive(Clone, Debug, Default)]
pub(crate) struct Shapes {
    pub(crate) rows: SlotMap<ShapeId, ShapeRow>,
    /// The hull of the box that was added last: boxes of one size share theirs.
    last_box: Option<Arc<Hull>>,
}

impl Shapes {
    #[inline]
    pub(crate) fn at(&self, row: u32) -> &ShapeRow {
        self.rows.at(row).expect("tables name living shapes only")
    }

    #[inline]
    pub(crate) fn at_mut(&mut self, row: u32) -> &mut ShapeRow {
        self.rows.at_mut(row).expect("tables name living shapes only")
    }

    /// The solid of a validated shape that is about to be added.
    pub(crate) fn solid(&mut self, shape: &Shape) -> Solid {
        if let (Shape::Box { half_extents }, Some(last)) = (shape, &self.last_box)
            && last.cuboid == Some(*half_extents)
        {
            return Solid { core: Core::Hull(Arc::clone(last)), radius: 0.0 };
        }
        let solid = Solid::of(shape);
        if let (Shape::Box { .. }, Core::Hull(hull)) = (shape, &solid.core) {
            self.last_box = Some(Arc::clone(hull));
        }
        solid
    }

    pub(crate) fn id(&self, row: u32) -> ShapeId {
        self.rows.id_at(row).expect("tables name living shapes only")
    }
}
