//! Shapes: one row each, owned by a body. Written by the world; bounds by finalize.

use core::mem::replace;
use std::collections::{BTreeMap, VecDeque};
use std::sync::Arc;

#[cfg(feature = "serde")]
use serde::{Deserialize, Serialize};

use super::bodies::Body;
use super::contacts::Contact;
use super::material::{Filter, Material, SurfaceRule};
use super::reports::PackedReports;
use crate::base::aabb::Aabb;
use crate::base::copy;
use crate::base::id::ShapeId;
use crate::base::math::Vec3;
use crate::base::pose::Pose;
use crate::base::slot_map::SlotMap;
use crate::geometry::hull::Hull;
use crate::geometry::shape::Shape;
use crate::geometry::solid::{Core, Solid};

/// Tells a row that is there from an empty slot. Of all fields it leaves most values unused, so the compiler takes
/// those for the slot, and not some of a field in a cache line that is not read otherwise.
#[derive(Clone, Copy, Debug, Default)]
#[repr(u32)]
pub(crate) enum Here {
    #[default]
    Yes = 1,
}

/// A shape of a body. What the narrowphase reads of it stands in the first two cache lines.
#[derive(Debug)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
#[repr(C, align(64))]
pub(crate) struct ShapeRow {
    #[cfg_attr(feature = "serde", serde(skip))]
    pub(crate) here: Here,
    /// It holds from one side only or has hooks, as its reports say: here where narrowphase reads it.
    pub(crate) is_asked: bool,
    #[cfg_attr(feature = "serde", serde(skip, default = "no_solid"))]
    pub(crate) solid: Solid,
    /// Box in the tree: the shape's, grown [m, world].
    pub(crate) fat: Aabb,
    /// Where it sits [frame of the body's center of mass].
    pub(crate) centered: Pose,
    pub(crate) body: u32,
    pub(crate) sensor: bool,
    /// In the tree of what does not move by itself.
    pub(crate) fixed: bool,
    /// It is a hull, a half-space or a mesh: its manifolds may be recycled.
    pub(crate) flat: bool,
    /// It takes part; if not, it is in no tree, and only weighs.
    pub(crate) enabled: bool,

    #[cfg_attr(feature = "serde", serde(skip, default = "no_shape"))]
    pub(crate) shape: Shape,
    /// Where it sits [frame of the body's origin].
    pub(crate) local: Pose,
    pub(crate) density: f32,
    pub(crate) material: Material,
    /// Radius for rolling and spinning resistance [m]; 0: does not roll.
    pub(crate) rolling_radius: f32,
    pub(crate) filter: Filter,
    /// How its surface moves over it [m/s and rad/s about its origin, frame of the shape].
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
        // Who shares a hull is counted, by all threads: to see that it is the same one costs less.
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
    /// Where it is, as a shape of `body` [world].
    #[inline]
    pub(crate) fn placed(&self, body: &Body) -> Pose {
        Pose { position: body.center, rotation: body.rotation }.compose(&self.centered)
    }

    /// Whether it is in a tree, as a shape of `body`.
    pub(crate) const fn is_in(&self, body: &Body) -> bool {
        self.enabled && !body.out
    }

    /// Whether contacts of two shapes may be let through in a step: one holds from one side only, or has hooks.
    #[inline]
    pub(crate) const fn are_asked(a: &Self, b: &Self) -> bool {
        a.is_asked || b.is_asked
    }

    /// Whether the manifolds of two shapes may be recycled. What holds from one side only, or has hooks, is asked anew in each
    /// step.
    pub(crate) const fn are_recyclable(a: &Self, b: &Self) -> bool {
        a.flat && b.flat && !(a.sensor || b.sensor || Self::are_asked(a, b))
    }

    /// Whether it is a sensor that sees another shape. `fixed`: both are of static bodies.
    pub(crate) const fn sees(&self, other: &Self, fixed: bool) -> bool {
        self.sensor
            && (!other.sensor || self.reports.sees_sensors())
            && (!fixed || self.reports.sees_statics())
    }

    /// Whether it stops what comes to it.
    #[inline]
    pub(crate) const fn is_solid(&self) -> bool {
        self.enabled && !self.sensor
    }

    /// Tells the body of which it is how far it reaches from the center of mass, how thin it is, and whether it reaches
    /// around the center.
    pub(crate) fn widen(&self, body: &mut Body) {
        let center = Aabb::new(Vec3::ZERO, Vec3::ZERO);
        let thickness = self.solid.aabb(&Pose::IDENTITY).half_extents().min_element();
        let extent = self.solid.max_extent(self.centered.local_point(Vec3::ZERO));
        body.extent = body.extent.max(extent);
        body.inner = body.inner.min(thickness);
        body.hollow &= !self.solid.aabb(&self.centered).contains(&center);
    }

    /// Whether its surface moves over it.
    pub(crate) fn is_belt(&self) -> bool {
        self.surface_velocity != Vec3::ZERO || self.surface_spin != Vec3::ZERO
    }

    /// Whether what it stands on flat is a disc.
    fn has_round_base(&self) -> bool {
        matches!(self.shape, Shape::Cylinder { .. } | Shape::Cone { .. })
    }

    pub(crate) fn is_mesh(&self) -> bool {
        matches!(self.solid.core, Core::Mesh(_))
    }
}

/// Shapes are saved beside their rows, for they share hulls and meshes: see `world::snapshot`.
const fn no_shape() -> Shape {
    Shape::sphere(1.0)
}

fn no_solid() -> Solid {
    Solid::of(&no_shape())
}

/// What the surfaces of two shapes do together.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PairSurface {
    /// Static friction coefficient.
    pub(crate) friction: f32,
    /// Kinetic friction as a part of it, at most 1.
    pub(crate) kinetic: f32,
    pub(crate) restitution: f32,
    /// Coefficients of resistance times radius [m].
    pub(crate) rolling: f32,
    pub(crate) spinning: f32,
    /// One of the surfaces moves over its shape.
    pub(crate) belt: bool,
    /// A flat contact is a disc.
    pub(crate) round_patch: bool,
}

impl PairSurface {
    /// The first of the rules that is of their layers counts.
    fn of(a: &ShapeRow, b: &ShapeRow, rules: &[SurfaceRule]) -> Self {
        let of_materials = Self::of_materials(a, b);
        let rule = rules.iter().find(|rule| rule.is_of(a.filter.layers, b.filter.layers));
        let Some(rule) = rule else { return of_materials };
        let friction = rule.friction.unwrap_or(of_materials.friction);
        let kinetic = match rule.kinetic_friction {
            Some(sliding) if sliding < friction => sliding / friction,
            Some(_) => 1.0,
            None => of_materials.kinetic,
        };
        let restitution = rule.restitution.unwrap_or(of_materials.restitution);
        Self { friction, kinetic, restitution, ..of_materials }
    }

    /// Whether a contact has this surface.
    pub(crate) fn is_of(&self, c: &Contact) -> bool {
        let bits = |own: [f32; 3]| own.map(f32::to_bits);
        bits([self.friction, self.kinetic, self.restitution])
            == bits([c.friction, c.kinetic, c.restitution])
    }

    fn of_materials(a: &ShapeRow, b: &ShapeRow) -> Self {
        let (ma, mb) = (&a.material, &b.material);
        let rub = |fa, fb| ma.friction_combine.apply(mb.friction_combine, fa, fb);
        let friction = rub(ma.friction, mb.friction);
        let sliding = |m: &Material| m.kinetic_friction.unwrap_or(m.friction);
        let kinetic = rub(sliding(ma), sliding(mb));
        let resist = |ka: f32, kb: f32| (ka * a.rolling_radius).max(kb * b.rolling_radius);
        let bounce = ma.restitution_combine;
        Self {
            friction,
            kinetic: if kinetic < friction { kinetic / friction } else { 1.0 },
            restitution: bounce.apply(mb.restitution_combine, ma.restitution, mb.restitution),
            rolling: resist(ma.rolling_resistance, mb.rolling_resistance),
            spinning: resist(ma.spinning_resistance, mb.spinning_resistance),
            belt: a.is_belt() || b.is_belt(),
            round_patch: a.has_round_base() || b.has_round_base(),
        }
    }
}

/// All shapes.
#[derive(Debug, Default)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
pub(crate) struct Shapes {
    pub(crate) rows: SlotMap<ShapeId, ShapeRow>,
    /// The hulls of the boxes that were added last, [`Self::BOXES`] at most: boxes of one size share theirs.
    /// Shapes that report forces, and those that give a hit speed of their own.
    pub(crate) report_forces: u32,
    pub(crate) give_hit_speed: u32,
    /// And those that see static shapes as sensors of static bodies.
    pub(crate) see_statics: u32,
    /// By rows: directions of the fronts of those that hold from one side only [frame of the shape; unit].
    pub(crate) one_way: BTreeMap<u32, Vec3>,
    /// What surfaces of some layers do to each other.
    pub(crate) rules: Vec<SurfaceRule>,
    #[cfg_attr(feature = "serde", serde(skip))]
    boxes: VecDeque<Arc<Hull>>,
}

impl Clone for Shapes {
    fn clone(&self) -> Self {
        let mut copy = Self::default();
        copy.clone_from(self);
        copy
    }

    /// Into the lists that are there.
    fn clone_from(&mut self, from: &Self) {
        let Self { rows, report_forces, give_hit_speed, see_statics, one_way, rules, boxes } = from;
        self.rows.clone_from(rows);
        self.boxes.clone_from(boxes);
        copy::map(&mut self.one_way, one_way);
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

    /// What the surfaces of two shapes do together.
    pub(crate) fn surface_of(&self, a: u32, b: u32) -> PairSurface {
        PairSurface::of(self.at(a), self.at(b), &self.rules)
    }

    /// Lets a shape report other events.
    pub(crate) fn set_reports(&mut self, row: u32, reports: PackedReports) {
        let shape = self.at_mut(row);
        shape.is_asked = reports.is_asked();
        let before = replace(&mut shape.reports, reports);
        self.count(before, false);
        self.count(reports, true);
    }

    /// Lets a shape hold from one side only, or from all.
    pub(crate) fn set_one_way(&mut self, row: u32, front: Option<Vec3>) {
        let shape = self.at_mut(row);
        shape.reports = shape.reports.with_one_way(front.is_some());
        shape.is_asked = shape.reports.is_asked();
        match front {
            Some(front) => self.one_way.insert(row, front),
            None => self.one_way.remove(&row),
        };
    }

    /// Whether the fronts are those of the rows.
    pub(crate) fn fronts_hold(&self) -> bool {
        let rows = self.rows.iter().filter(|(_, shape)| shape.reports.is_one_way()).count();
        let is_of = |row: &u32| self.rows.at(*row).is_some_and(|shape| shape.reports.is_one_way());
        rows == self.one_way.len() && self.one_way.keys().all(is_of)
    }

    /// Whether the counts are those of the rows.
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

    /// So many sizes of boxes are known again: a body has boxes of a few, and many bodies are alike.
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
