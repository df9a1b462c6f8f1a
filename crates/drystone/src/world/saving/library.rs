//! Hulls and meshes known to both sides of a snapshot, and how snapshots store or reference them.

use std::borrow::Cow;
use std::collections::BTreeMap;
use std::sync::Arc;

#[cfg(feature = "serde")]
use serde::{Deserialize, Serialize};

use super::snapshot::{SnapshotError, checksum};
use crate::base::math::Vec3;
use crate::geometry::hull::Hull;
use crate::geometry::mesh::Mesh;
use crate::geometry::shape::Shape;
use crate::state::shapes::Shapes;
use crate::world::World;

/// Key of a hull or mesh: a hash of its content, the same on every machine.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
pub struct GeometryKey(u64);

impl GeometryKey {
    /// The key as a number, for sending or storing.
    #[must_use]
    pub const fn to_bits(self) -> u64 {
        self.0
    }

    /// The key for a number from [`Self::to_bits`].
    #[must_use]
    pub const fn from_bits(bits: u64) -> Self {
        Self(bits)
    }

    /// The key of a hull or mesh. `kind` keeps the two types apart.
    fn of(item: &impl Serialize, kind: u64) -> Self {
        let bytes = postcard::to_stdvec(item).expect("lists of numbers can be written");
        Self(checksum(&bytes).wrapping_add(kind))
    }
}

impl core::fmt::Display for GeometryKey {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        write!(f, "{:016x}", self.0)
    }
}

/// Hulls and meshes that snapshots reference in place of storing them.
///
/// The meshes of a level are megabytes that never change. A program that saves often, or sends
/// states to a machine with the same level, puts them into a library. [`World::snapshot_with`] then
/// writes eight bytes for each. Restoring needs a library with the same content; its hulls and
/// meshes may have been built again.
///
/// ```
/// # fn main() -> Result<(), Box<dyn std::error::Error>> {
/// use std::sync::Arc;
/// use drystone::{BodyDef, Hull, Shape, ShapeDef, World, vec3};
/// use drystone::snapshot::{Library, SnapshotError};
///
/// let points = [vec3(0.0, 0.0, 0.0), vec3(1.0, 0.0, 0.0), vec3(0.0, 1.0, 0.0), vec3(0.0, 0.0, 1.0)];
/// let stone = Shape::Hull(Arc::new(Hull::from_points(&points)?));
/// let mut library = Library::default();
/// let key = library.add(&stone).ok_or("a hull has a key")?;
///
/// let mut world = World::default();
/// world.add_body(BodyDef::dynamic().with_shape(ShapeDef::new(stone)))?;
/// let mut bytes = Vec::new();
/// world.snapshot_with(&library, &mut bytes);
///
/// let mut other = World::default();
/// assert_eq!(other.restore_from(&bytes), Err(SnapshotError::MissingGeometry { key }));
/// other.restore_with(&library, &bytes)?;
/// assert_eq!(other.state_hash(), world.state_hash());
/// # Ok(())
/// # }
/// ```
#[derive(Clone, Debug, Default)]
pub struct Library {
    items: BTreeMap<GeometryKey, Shape>,
    /// Keys by memory address. The library holds the object, so the address cannot be reused.
    keys: BTreeMap<usize, (GeometryKey, Shape)>,
}

impl Library {
    /// Adds the hull or mesh of a shape and returns its key; `None` if the shape has neither.
    pub fn add(&mut self, shape: &Shape) -> Option<GeometryKey> {
        let place = place_of(shape)?;
        if let Some((key, _)) = self.keys.get(&place) {
            return Some(*key);
        }
        let key = match shape {
            Shape::Hull(hull) => GeometryKey::of(&**hull, 0),
            Shape::Mesh(mesh) => GeometryKey::of(&**mesh, 1),
            _ => return None,
        };
        self.items.entry(key).or_insert_with(|| shape.clone());
        self.keys.insert(place, (key, shape.clone()));
        Some(key)
    }

    /// Adds all hulls and meshes of a world.
    pub fn add_world(&mut self, world: &World) {
        for (_, row) in world.tables.shapes.rows.iter() {
            self.add(&row.shape);
        }
    }

    /// The hull or mesh of a key, as a shape.
    #[must_use]
    pub fn get(&self, key: GeometryKey) -> Option<&Shape> {
        self.items.get(&key)
    }

    /// All keys, in order.
    pub fn keys(&self) -> impl Iterator<Item = GeometryKey> {
        self.items.keys().copied()
    }

    /// Number of different hulls and meshes.
    #[must_use]
    pub fn len(&self) -> usize {
        self.items.len()
    }

    /// True if it is empty.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.items.is_empty()
    }

    fn key_at(&self, place: usize) -> Option<GeometryKey> {
        self.keys.get(&place).map(|(key, _)| *key)
    }
}

/// Memory address of the hull or mesh of a shape. It identifies shared objects.
fn place_of(shape: &Shape) -> Option<usize> {
    match shape {
        Shape::Hull(hull) => Some(Arc::as_ptr(hull).addr()),
        Shape::Mesh(mesh) => Some(Arc::as_ptr(mesh).addr()),
        _ => None,
    }
}

/// A hull or mesh in a snapshot.
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
enum Saved<'a, T: Clone> {
    Held(Cow<'a, T>),
    Named(GeometryKey),
}

/// All shapes of a world in the form of a snapshot.
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
pub(crate) struct SavedShapes<'a> {
    /// Each hull once, even if several shapes share it.
    hulls: Vec<Saved<'a, Hull>>,
    meshes: Vec<Saved<'a, Mesh>>,
    /// Shapes in the order of their rows.
    shapes: Vec<SavedShape>,
}

/// A [`Shape`] with the index of its hull or mesh.
#[derive(Clone, Copy)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
enum SavedShape {
    Sphere { radius: f32 },
    Capsule { half_height: f32, radius: f32 },
    Box { half_extents: Vec3 },
    Cylinder { half_height: f32, radius: f32 },
    Cone { half_height: f32, radius_bottom: f32, radius_top: f32 },
    Hull(u32),
    HalfSpace { normal: Vec3, offset: f32 },
    Mesh(u32),
}

/// Shared geometry in the order of first use.
struct Pool<'a, T: Clone> {
    library: &'a Library,
    items: Vec<Saved<'a, T>>,
    /// Indices by memory address.
    numbers: BTreeMap<usize, u32>,
}

impl<'a, T: Clone> Pool<'a, T> {
    const fn new(library: &'a Library) -> Self {
        Self { library, items: Vec::new(), numbers: BTreeMap::new() }
    }

    fn number(&mut self, item: &'a Arc<T>) -> u32 {
        let next = u32::try_from(self.items.len()).expect("fewer than 2^32 shapes");
        let place = Arc::as_ptr(item).addr();
        *self.numbers.entry(place).or_insert_with(|| {
            let named = self.library.key_at(place).map(Saved::Named);
            self.items.push(named.unwrap_or(Saved::Held(Cow::Borrowed(item))));
            next
        })
    }
}

/// Stored geometry as it is, and referenced geometry from `named`.
fn find_all<T: Clone>(
    saved: Vec<Saved<'_, T>>,
    named: impl Fn(GeometryKey) -> Option<Arc<T>>,
) -> Result<Vec<Arc<T>>, SnapshotError> {
    let item = |saved| match saved {
        Saved::Held(item) => Ok(Arc::new(Cow::into_owned(item))),
        Saved::Named(key) => named(key).ok_or(SnapshotError::MissingGeometry { key }),
    };
    saved.into_iter().map(item).collect()
}

impl<'a> SavedShapes<'a> {
    /// The shapes in the rows of a world. Geometry in the library is stored as a reference.
    pub(crate) fn of(shapes: &'a Shapes, library: &'a Library) -> Self {
        let (mut hulls, mut meshes) = (Pool::new(library), Pool::new(library));
        let save = |shape: &'a Shape| match *shape {
            Shape::Sphere { radius } => SavedShape::Sphere { radius },
            Shape::Capsule { half_height, radius } => SavedShape::Capsule { half_height, radius },
            Shape::Box { half_extents } => SavedShape::Box { half_extents },
            Shape::Cylinder { half_height, radius } => SavedShape::Cylinder { half_height, radius },
            Shape::Cone { half_height, radius_bottom, radius_top } => {
                SavedShape::Cone { half_height, radius_bottom, radius_top }
            }
            Shape::Hull(ref hull) => SavedShape::Hull(hulls.number(hull)),
            Shape::HalfSpace { normal, offset } => SavedShape::HalfSpace { normal, offset },
            Shape::Mesh(ref mesh) => SavedShape::Mesh(meshes.number(mesh)),
        };
        let shapes = shapes.rows.iter().map(|(_, row)| &row.shape).map(save).collect();
        Self { hulls: hulls.items, meshes: meshes.items, shapes }
    }

    /// Restores the shapes of the rows.
    pub(crate) fn load(self, rows: &mut Shapes, library: &Library) -> Result<(), SnapshotError> {
        let hulls = find_all(self.hulls, |key| match library.get(key) {
            Some(Shape::Hull(hull)) => Some(Arc::clone(hull)),
            _ => None,
        })?;
        let meshes = find_all(self.meshes, |key| match library.get(key) {
            Some(Shape::Mesh(mesh)) => Some(Arc::clone(mesh)),
            _ => None,
        })?;
        let unsound = |what| Err(SnapshotError::Invalid(what));
        if self.shapes.len() != rows.rows.len() {
            return unsound("shapes have not one row each");
        }
        let mut saved = self.shapes.iter();
        for place in 0..rows.rows.slot_count() {
            let Ok(row) = u32::try_from(place) else { return unsound("there are too many shapes") };
            if rows.rows.at(row).is_none() {
                continue;
            }
            let shape = saved.next().and_then(|saved| saved.load(&hulls, &meshes));
            let Some(shape) = shape else { return unsound("a shape has no hull or mesh") };
            if shape.validate().is_err() {
                return unsound("a shape is out of range");
            }
            let solid = rows.solid(&shape);
            let row = rows.at_mut(row);
            (row.shape, row.solid) = (shape, solid);
        }
        Ok(())
    }
}

impl SavedShape {
    fn load(self, hulls: &[Arc<Hull>], meshes: &[Arc<Mesh>]) -> Option<Shape> {
        Some(match self {
            Self::Sphere { radius } => Shape::Sphere { radius },
            Self::Capsule { half_height, radius } => Shape::Capsule { half_height, radius },
            Self::Box { half_extents } => Shape::Box { half_extents },
            Self::Cylinder { half_height, radius } => Shape::Cylinder { half_height, radius },
            Self::Cone { half_height, radius_bottom, radius_top } => {
                Shape::Cone { half_height, radius_bottom, radius_top }
            }
            Self::Hull(number) => Shape::Hull(Arc::clone(hulls.get(number as usize)?)),
            Self::HalfSpace { normal, offset } => Shape::HalfSpace { normal, offset },
            Self::Mesh(number) => Shape::Mesh(Arc::clone(meshes.get(number as usize)?)),
        })
    }
}
