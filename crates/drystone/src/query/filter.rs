//! Filters: the shapes that a query sees.

use core::fmt;
use core::ops::BitOr;

use super::shape::ShapeRef;
use crate::base::id::{BodyId, ShapeId};
use crate::state::def::BodyKind;
use crate::state::def::material::Filter;
use crate::state::tables::Tables;

/// A set of kinds of bodies, joined with `|`.
///
/// ```
/// use drystone::BodyKind;
/// use drystone::query::BodyKinds;
///
/// let moving = BodyKinds::KINEMATIC | BodyKinds::DYNAMIC;
/// assert!(moving.contains(BodyKind::Dynamic) && !moving.contains(BodyKind::Static));
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BodyKinds(u8);

impl BodyKinds {
    /// Static bodies.
    pub const STATIC: Self = Self(1);
    /// Kinematic bodies.
    pub const KINEMATIC: Self = Self(2);
    /// Dynamic bodies.
    pub const DYNAMIC: Self = Self(4);
    /// Bodies of every kind.
    pub const ALL: Self = Self(7);

    /// True if the set has this kind.
    #[must_use]
    pub const fn contains(self, kind: BodyKind) -> bool {
        self.0 & Self::of(kind).0 != 0
    }

    const fn of(kind: BodyKind) -> Self {
        match kind {
            BodyKind::Static => Self::STATIC,
            BodyKind::Kinematic => Self::KINEMATIC,
            BodyKind::Dynamic => Self::DYNAMIC,
        }
    }
}

impl Default for BodyKinds {
    fn default() -> Self {
        Self::ALL
    }
}

impl From<BodyKind> for BodyKinds {
    fn from(kind: BodyKind) -> Self {
        Self::of(kind)
    }
}

impl BitOr for BodyKinds {
    type Output = Self;

    fn bitor(self, other: Self) -> Self {
        Self(self.0 | other.0)
    }
}

/// How rays and shape casts treat a shape in which they start.
///
/// A start within a few roundings of the surface counts as outside: a cast that enters hits at
/// fraction 0, and one that leaves does not hit. A mesh has no inside; a cast shape that intersects
/// its triangles overlaps it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Inside {
    /// Shapes are solid: the cast hits at once, at fraction 0. This is the default, since it misses
    /// nothing in the cast's path.
    #[default]
    Solid,
    /// Shapes are hollow: a ray hits the far side of the surface from within. A shape cast treats
    /// this as [`Self::Ignore`].
    Hollow,
    /// The cast does not see the shape: a bullet leaves the barrel in which it starts.
    Ignore,
}

/// Selects the shapes that a query sees. All queries of [`Query`](crate::query::Query) take one, or
/// a [`Filter`] alone.
///
/// The default sees the shapes of all layers on bodies of all kinds, but no sensors. A query sees
/// sensors only where it includes them.
///
/// ```
/// use drystone::{BodyDef, DefError, ShapeDef, ShapeRef, World};
/// use drystone::query::{BodyKinds, QueryFilter};
///
/// fn main() -> Result<(), DefError> {
///     let mut world = World::default();
///     let gunner = world.add_body(BodyDef::dynamic().with_shape(ShapeDef::sphere(0.5)))?;
///     let target = BodyDef::dynamic().with_position([9.0, 0.0, 0.0]);
///     let target = world.add_body(target.with_shape(ShapeDef::sphere(0.5)))?;
///     // The lists and the predicate are borrowed: they have names, to live as long as the filter.
///     let (me, is_plain) = ([gunner], |shape: ShapeRef<'_>| shape.user_data() == 0);
///     let others = QueryFilter::default()
///         .with_kinds(BodyKinds::DYNAMIC)
///         .without(&me)
///         .with_predicate(&is_plain);
///     let hit = world.query().cast_ray([0.0; 3], [20.0, 0.0, 0.0], others)?;
///     assert_eq!(hit.map(|hit| hit.body), Some(target));
///     Ok(())
/// }
/// ```
#[derive(Clone, Copy, Default)]
pub struct QueryFilter<'a> {
    /// The query sees the shapes that collide with this filter. Both sides count: a shape whose
    /// mask lacks the layers given here is not seen. `None`, the default, sees shapes of all
    /// layers.
    pub filter: Option<Filter>,
    /// Kinds of bodies whose shapes the query sees; all by default.
    pub kinds: BodyKinds,
    /// Whether the query sees sensors; false by default. It sees solid shapes in either case.
    pub sensors: bool,
    /// Bodies whose shapes the query does not see; none by default. Each candidate is compared with
    /// all of them.
    pub exclude: &'a [BodyId],
    /// Shapes that the query does not see; none by default. Each candidate is compared with all of
    /// them.
    pub exclude_shapes: &'a [ShapeId],
    /// The query sees a shape only if this returns true; none by default. It is called last, for
    /// shapes near the query, in unspecified order, and by several threads at once in a batch. It
    /// must return the same value for the same shape.
    pub predicate: Option<&'a (dyn Fn(ShapeRef<'_>) -> bool + Sync)>,
    /// How rays and shape casts treat a shape in which they start; default [`Inside::Solid`].
    pub inside: Inside,
}

impl<'a> QueryFilter<'a> {
    /// This filter, limited to shapes that collide with `filter`.
    #[must_use]
    pub const fn with_filter(self, filter: Filter) -> Self {
        Self { filter: Some(filter), ..self }
    }

    /// This filter, limited to bodies of these kinds.
    #[must_use]
    pub fn with_kinds(self, kinds: impl Into<BodyKinds>) -> Self {
        Self { kinds: kinds.into(), ..self }
    }

    /// This filter, with sensors included.
    #[must_use]
    pub const fn with_sensors(self) -> Self {
        Self { sensors: true, ..self }
    }

    /// This filter with these bodies excluded; replaces the bodies excluded before.
    #[must_use]
    pub const fn without(self, exclude: &'a [BodyId]) -> Self {
        Self { exclude, ..self }
    }

    /// This filter with these shapes excluded; replaces the shapes excluded before.
    #[must_use]
    pub const fn without_shapes(self, exclude_shapes: &'a [ShapeId]) -> Self {
        Self { exclude_shapes, ..self }
    }

    /// This filter, limited to shapes for which `predicate` returns true.
    #[must_use]
    pub const fn with_predicate(
        self,
        predicate: &'a (dyn Fn(ShapeRef<'_>) -> bool + Sync),
    ) -> Self {
        Self { predicate: Some(predicate), ..self }
    }

    /// This filter with another treatment of shapes in which a ray or cast starts.
    #[must_use]
    pub const fn with_inside(self, inside: Inside) -> Self {
        Self { inside, ..self }
    }

    /// Returns whether the filter sees a shape. Cheap tests come first.
    pub(super) fn sees(&self, tables: &Tables, row: u32) -> bool {
        let shape = tables.shapes.at(row);
        (self.sensors || !shape.sensor)
            && self.filter.is_none_or(|filter| filter.collides_with(shape.filter))
            && (self.kinds == BodyKinds::ALL
                || self.kinds.contains(tables.bodies.at(shape.body).kind))
            && (self.exclude.is_empty() || !self.exclude.contains(&tables.bodies.id(shape.body)))
            && (self.exclude_shapes.is_empty()
                || !self.exclude_shapes.contains(&tables.shapes.id(row)))
            && self.predicate.is_none_or(|sees| sees(ShapeRef::at(tables, row)))
    }
}

impl From<Filter> for QueryFilter<'_> {
    fn from(filter: Filter) -> Self {
        Self::default().with_filter(filter)
    }
}

impl<'a> From<&QueryFilter<'a>> for QueryFilter<'a> {
    fn from(filter: &QueryFilter<'a>) -> Self {
        *filter
    }
}

impl fmt::Debug for QueryFilter<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("QueryFilter")
            .field("filter", &self.filter)
            .field("kinds", &self.kinds)
            .field("sensors", &self.sensors)
            .field("exclude", &self.exclude)
            .field("exclude_shapes", &self.exclude_shapes)
            .field("predicate", &self.predicate.is_some())
            .field("inside", &self.inside)
            .finish()
    }
}
