//! Shapes: one row each, owned by a body. The world writes the rows; finalize writes the boxes.

use core::mem::replace;
use std::collections::{BTreeMap, VecDeque};
use std::sync::Arc;

#[cfg(feature = "serde")]
use serde::{Deserialize, Serialize};

use super::bodies::body::Body;
use super::contacts::Traits;
use super::def::material::{ContactSoftness, Filter, Material, SurfaceRule};
use super::def::reports::PackedReports;
use crate::base::aabb::Aabb;
use crate::base::copy;
use crate::base::id::ShapeId;
use crate::base::math::Vec3;
use crate::base::pose::Pose;
use crate::base::slot_map::SlotMap;
use crate::geometry::hull::Hull;
use crate::geometry::shape::Shape;
use crate::geometry::solid::{Core, Solid};

/// Niche for `Option<ShapeRow>`. It has the most invalid bit patterns of all fields, so the
/// compiler uses it to mark an empty slot. Otherwise that could be a field in a cache line that is
/// not read.
#[derive(Clone, Copy, Debug, Default)]
#[repr(u32)]
pub(crate) enum Here {
    #[default]
    Yes = 1,
}

/// A shape of a body. The data that narrowphase reads are in the first two cache lines.
#[derive(Debug)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
#[repr(C, align(64))]
pub(crate) struct ShapeRow {
    #[cfg_attr(feature = "serde", serde(skip))]
    pub(crate) here: Here,
    /// True if it is one-way or has hooks, according to its reports. A copy for narrowphase.
    pub(crate) is_asked: bool,
    #[cfg_attr(feature = "serde", serde(skip, default = "no_solid"))]
    pub(crate) solid: Solid,
    /// Box in the tree: the shape's box, enlarged [m, world].
    pub(crate) fat: Aabb,
    /// Local pose [frame of the body's center of mass].
    pub(crate) centered: Pose,
    pub(crate) body: u32,
    pub(crate) sensor: bool,
    /// True if it is in the tree of fixed shapes.
    pub(crate) fixed: bool,
    /// True for a hull, a half-space or a mesh, whose manifolds may be recycled.
    pub(crate) flat: bool,
    /// False if it is disabled: it is then in no tree, and only contributes mass.
    pub(crate) enabled: bool,

    #[cfg_attr(feature = "serde", serde(skip, default = "no_shape"))]
    pub(crate) shape: Shape,
    /// Local pose [frame of the body's origin].
    pub(crate) local: Pose,
    pub(crate) density: f32,
    pub(crate) material: Material,
    /// Radius for rolling and spinning resistance [m]; 0: does not roll.
    pub(crate) rolling_radius: f32,
    pub(crate) filter: Filter,
    /// Motion of its surface along the shape [m/s and rad/s about its origin, frame of the shape].
    pub(crate) surface_velocity: Vec3,
    pub(crate) surface_spin: Vec3,
    pub(crate) reports: PackedReports,
    pub(crate) user_data: u64,
}

impl Clone for ShapeRow {
    fn clone(&self) -> Self {
        Self { solid: self.solid.clone(), shape: self.shape.clone(), ..*self }
    }

    fn clone_from(&mut self, from: &Self) {
        // All threads count references to a shared hull. Checking that it is the same hull costs
        // less.
        let solid = match (&self.solid.core, &from.solid.core) {
            (Core::Hull(to), Core::Hull(from)) if Arc::ptr_eq(to, from) => {
                replace(&mut self.solid, Solid::POINT)
            }
            _ => from.solid.clone(),
        };
        let shape = match (&self.shape, &from.shape) {
            (Shape::Hull(to), Shape::Hull(from)) if Arc::ptr_eq(to, from) => {
                replace(&mut self.shape, no_shape())
            }
            _ => from.shape.clone(),
        };
        *self = Self { solid, shape, ..*from };
    }
}

const _: () = assert!(size_of::<Option<ShapeRow>>() == 256);

impl ShapeRow {
    /// Its pose, as a shape of `body` [world].
    #[inline]
    pub(crate) fn placed(&self, body: &Body) -> Pose {
        Pose { position: body.center, rotation: body.rotation }.compose(&self.centered)
    }

    /// Whether it is in a tree, as a shape of `body`.
    pub(crate) const fn is_in(&self, body: &Body) -> bool {
        self.enabled && !body.out
    }

    /// Whether a step may drop contacts of two shapes: one of them is one-way or has hooks.
    #[inline]
    pub(crate) const fn are_asked(a: &Self, b: &Self) -> bool {
        a.is_asked || b.is_asked
    }

    /// Whether the manifolds of two shapes may be recycled. Contacts of one-way shapes and of
    /// shapes with hooks are decided again in each step.
    pub(crate) const fn are_recyclable(a: &Self, b: &Self) -> bool {
        a.flat && b.flat && !(a.sensor || b.sensor || Self::are_asked(a, b))
    }

    /// Whether it is a sensor that detects another shape. `fixed`: both belong to static bodies.
    pub(crate) const fn sees(&self, other: &Self, fixed: bool) -> bool {
        self.sensor
            && (!other.sensor || self.reports.sees_sensors())
            && (!fixed || self.reports.sees_statics())
    }

    /// Whether it blocks other shapes.
    #[inline]
    pub(crate) const fn is_solid(&self) -> bool {
        self.enabled && !self.sensor
    }

    /// Updates the extent of its body from the center of mass, its thickness, and whether the shape
    /// surrounds the center.
    pub(crate) fn widen(&self, body: &mut Body) {
        let center = Aabb::new(Vec3::ZERO, Vec3::ZERO);
        let thickness = self.solid.aabb(&Pose::IDENTITY).half_extents().min_element();
        let extent = self.solid.max_extent(self.centered.local_point(Vec3::ZERO));
        body.extent = body.extent.max(extent);
        body.inner = body.inner.min(thickness);
        body.inertia.hollow &= !self.solid.aabb(&self.centered).contains(&center);
    }

    /// Whether its surface moves.
    pub(crate) fn is_belt(&self) -> bool {
        self.surface_velocity != Vec3::ZERO || self.surface_spin != Vec3::ZERO
    }

    /// Whether its flat base is a disc.
    fn has_round_base(&self) -> bool {
        matches!(self.shape, Shape::Cylinder { .. } | Shape::Cone { .. })
    }

    pub(crate) fn is_mesh(&self) -> bool {
        matches!(self.solid.core, Core::Mesh(_))
    }
}

/// Shapes are saved separately from their rows, because they share hulls and meshes: see
/// `world::snapshot`.
const fn no_shape() -> Shape {
    Shape::sphere(1.0)
}

fn no_solid() -> Solid {
    Solid::of(&no_shape())
}

/// The combined surface properties of two shapes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct PairSurface {
    /// Static friction coefficient.
    pub(crate) friction: f32,
    /// Ratio of kinetic to static friction, at most 1.
    pub(crate) kinetic: f32,
    pub(crate) restitution: f32,
    /// Coefficients of resistance times radius [m].
    pub(crate) rolling: f32,
    pub(crate) spinning: f32,
    /// Softness; `None`: that of the world's contacts.
    pub(crate) softness: Option<ContactSoftness>,
    pub(crate) traits: Traits,
    /// True if a flat contact is a disc.
    pub(crate) round_patch: bool,
}

impl PairSurface {
    /// Applies a surface rule.
    fn ruled(self, rule: &SurfaceRule) -> Self {
        let friction = rule.friction.unwrap_or(self.friction);
        let kinetic = match rule.kinetic_friction {
            Some(sliding) if sliding < friction => sliding / friction,
            Some(_) => 1.0,
            None => self.kinetic,
        };
        let restitution = rule.restitution.unwrap_or(self.restitution);
        let softness = rule.softness.or(self.softness);
        let traits = self.traits.with(Traits::SOFT, softness.is_some());
        Self { friction, kinetic, restitution, softness, traits, ..self }
    }

    fn of_materials(a: &ShapeRow, b: &ShapeRow) -> Self {
        let (ma, mb) = (&a.material, &b.material);
        let rub = |fa, fb| ma.friction_combine.apply(mb.friction_combine, fa, fb);
        let friction = rub(ma.friction, mb.friction);
        let sliding = |m: &Material| m.kinetic_friction.unwrap_or(m.friction);
        let kinetic = rub(sliding(ma), sliding(mb));
        let resist = |ka: f32, kb: f32| (ka * a.rolling_radius).max(kb * b.rolling_radius);
        let bounce = ma.restitution_combine;
        let has_hooks = a.reports.has_hooks() || b.reports.has_hooks();
        Self {
            friction,
            kinetic: if kinetic < friction { kinetic / friction } else { 1.0 },
            restitution: bounce.apply(mb.restitution_combine, ma.restitution, mb.restitution),
            rolling: resist(ma.rolling_resistance, mb.rolling_resistance),
            spinning: resist(ma.spinning_resistance, mb.spinning_resistance),
            softness: None,
            traits: Traits::default()
                .with(Traits::BELT, a.is_belt() || b.is_belt())
                .with(Traits::HOOKED, has_hooks),
            round_patch: a.has_round_base() || b.has_round_base(),
        }
    }
}

/// All shapes.
#[derive(Debug, Default)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
pub(crate) struct Shapes {
    pub(crate) rows: SlotMap<ShapeId, ShapeRow>,
    /// Number of shapes that report forces, and number of shapes with their own hit speed.
    pub(crate) report_forces: u32,
    pub(crate) give_hit_speed: u32,
    /// Number of sensors of static bodies that detect static shapes.
    pub(crate) see_statics: u32,
    /// Front directions of one-way shapes, by rows [frame of the shape; unit].
    pub(crate) one_way: BTreeMap<u32, Vec3>,
    /// Surface rules of layers.
    pub(crate) rules: Vec<SurfaceRule>,
    /// Surface rules of two bodies, by their rows, the lower first.
    pub(crate) between: BTreeMap<(u32, u32), SurfaceRule>,
    /// Hulls of the boxes added last, at most [`Self::BOXES`]. Boxes of one size share a hull.
    #[cfg_attr(feature = "serde", serde(skip))]
    boxes: VecDeque<Arc<Hull>>,
}

impl Clone for Shapes {
    fn clone(&self) -> Self {
        let mut copy = Self::default();
        copy.clone_from(self);
        copy
    }

    /// Reuses the existing lists.
    fn clone_from(&mut self, from: &Self) {
        let Self { rows, report_forces, give_hit_speed, see_statics, .. } = from;
        let Self { one_way, rules, between, boxes, .. } = from;
        self.rows.clone_from(rows);
        self.boxes.clone_from(boxes);
        copy::map(&mut self.one_way, one_way);
        copy::map(&mut self.between, between);
        self.rules.clone_from(rules);
        (self.report_forces, self.give_hit_speed) = (*report_forces, *give_hit_speed);
        self.see_statics = *see_statics;
    }
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

    /// Adds a shape.
    pub(crate) fn insert(&mut self, shape: ShapeRow) -> ShapeId {
        self.count(shape.reports, true);
        let is_asked = shape.reports.is_asked();
        self.rows.insert(ShapeRow { is_asked, ..shape })
    }

    /// Removes the shape of a row.
    pub(crate) fn remove(&mut self, row: u32) {
        if let Some(id) = self.rows.id_at(row)
            && let Some(shape) = self.rows.remove(id)
        {
            self.count(shape.reports, false);
            self.one_way.remove(&row);
        }
    }

    /// The surface properties of two shapes. A rule for their bodies takes precedence, then the
    /// first rule that matches their layers.
    pub(crate) fn surface_of(&self, a: u32, b: u32) -> PairSurface {
        let (a, b) = (self.at(a), self.at(b));
        let mut surface = PairSurface::of_materials(a, b);
        let is_of = |rule: &&SurfaceRule| rule.is_of(a.filter.layers, b.filter.layers);
        if let Some(rule) = self.rules.iter().find(is_of) {
            surface = surface.ruled(rule);
        }
        if !self.between.is_empty() {
            let pair = (a.body.min(b.body), a.body.max(b.body));
            if let Some(rule) = self.between.get(&pair).filter(is_of) {
                surface = surface.ruled(rule);
            }
        }
        surface
    }

    /// Sets the event reports of a shape.
    pub(crate) fn set_reports(&mut self, row: u32, reports: PackedReports) {
        let shape = self.at_mut(row);
        shape.is_asked = reports.is_asked();
        let before = replace(&mut shape.reports, reports);
        self.count(before, false);
        self.count(reports, true);
    }

    /// Sets the front of a one-way shape; `None`: it blocks from all sides.
    pub(crate) fn set_one_way(&mut self, row: u32, front: Option<Vec3>) {
        let shape = self.at_mut(row);
        shape.reports = shape.reports.with_one_way(front.is_some());
        shape.is_asked = shape.reports.is_asked();
        match front {
            Some(front) => self.one_way.insert(row, front),
            None => self.one_way.remove(&row),
        };
    }

    /// Whether the fronts match the rows.
    pub(crate) fn fronts_hold(&self) -> bool {
        let rows = self.rows.iter().filter(|(_, shape)| shape.reports.is_one_way()).count();
        let is_of = |row: &u32| self.rows.at(*row).is_some_and(|shape| shape.reports.is_one_way());
        rows == self.one_way.len() && self.one_way.keys().all(is_of)
    }

    /// Whether the counts match the rows.
    pub(crate) fn counts_hold(&self) -> bool {
        let count = |asks: fn(PackedReports) -> bool| {
            self.rows.iter().filter(|(_, shape)| asks(shape.reports)).count()
        };
        self.rows.iter().all(|(_, shape)| shape.is_asked == shape.reports.is_asked())
            && count(|reports| reports.forces) == self.report_forces as usize
            && count(PackedReports::has_hit_speed) == self.give_hit_speed as usize
            && count(PackedReports::sees_statics) == self.see_statics as usize
    }

    fn count(&mut self, reports: PackedReports, more: bool) {
        let asked = [reports.forces, reports.has_hit_speed(), reports.sees_statics()];
        let counts = [&mut self.report_forces, &mut self.give_hit_speed, &mut self.see_statics];
        for (count, asks) in counts.into_iter().zip(asked) {
            *count = if more { *count + u32::from(asks) } else { *count - u32::from(asks) };
        }
    }

    /// Number of recent box sizes whose hulls are shared. A body has boxes of a few sizes, and many
    /// bodies are alike.
    const BOXES: usize = 32;

    /// The solid of a validated shape that is about to be added.
    pub(crate) fn solid(&mut self, shape: &Shape) -> Solid {
        if let Shape::Box { half_extents } = shape
            && let Some(same) = self.boxes.iter().find(|hull| hull.cuboid == Some(*half_extents))
        {
            return Solid { core: Core::Hull(Arc::clone(same)), radius: 0.0 };
        }
        let solid = Solid::of(shape);
        if let (Shape::Box { .. }, Core::Hull(hull)) = (shape, &solid.core) {
            self.boxes.truncate(Self::BOXES - 1);
            self.boxes.push_front(Arc::clone(hull));
        }
        solid
    }

    pub(crate) fn id(&self, row: u32) -> ShapeId {
        self.rows.id_of(row)
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::{Core, Hull, Shape, Shapes};
    use crate::base::math::Vec3;

    fn hull_of(shapes: &mut Shapes, size: f32) -> Arc<Hull> {
        match shapes.solid(&Shape::Box { half_extents: Vec3::splat(size) }).core {
            Core::Hull(hull) => hull,
            _ => panic!("a box is a hull"),
        }
    }

    #[test]
    fn boxes_of_a_few_sizes_share_their_hulls_and_few_sizes_are_kept() {
        let mut shapes = Shapes::default();
        let first = [1.0, 2.0].map(|size| hull_of(&mut shapes, size));
        let again = [1.0, 2.0].map(|size| hull_of(&mut shapes, size));
        for (a, b) in first.iter().zip(&again) {
            assert!(Arc::ptr_eq(a, b));
        }
        assert!(!Arc::ptr_eq(&first[0], &first[1]));
        for size in 3..100_u8 {
            hull_of(&mut shapes, f32::from(size));
        }
        assert_eq!(shapes.boxes.len(), Shapes::BOXES);
        assert!(!Arc::ptr_eq(&first[0], &hull_of(&mut shapes, 1.0)));
    }
}
