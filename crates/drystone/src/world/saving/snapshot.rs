//! Snapshots: conversion of a whole world to bytes and back.

use std::borrow::Cow;

use postcard::ser_flavors::Flavor;
#[cfg(feature = "serde")]
use serde::{Deserialize, Serialize};

use super::library::{GeometryKey, Library, SavedShapes};
use crate::base::hash::StateHash;
use crate::state::events::Events;
use crate::state::tables::Tables;
use crate::world::World;

/// First bytes of a snapshot.
const MAGIC: [u8; 8] = *b"drystone";
/// Version of the layout; it increases whenever anything that is saved changes.
const VERSION: u32 = 9;
/// Magic, version, checksum.
const HEADER: usize = 8 + 4 + 8;

/// Reason why bytes are not a world.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum SnapshotError {
    /// They are not a snapshot.
    NotASnapshot,
    /// They are a snapshot of an unsupported version of the layout.
    Version {
        /// Version of the snapshot.
        found: u32,
        /// Supported version.
        read: u32,
    },
    /// They were truncated or changed after they were written.
    Damaged,
    /// They contain values that no world can have.
    Invalid(&'static str),
    /// They refer to a hull or mesh that the given library does not contain.
    MissingGeometry {
        /// Key of the hull or mesh.
        key: GeometryKey,
    },
}

impl core::fmt::Display for SnapshotError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self {
            Self::NotASnapshot => write!(f, "this is no snapshot of a world"),
            Self::Version { found, read } => {
                write!(f, "the snapshot must have version {read} (got {found})")
            }
            Self::Damaged => write!(f, "the snapshot was cut off or changed"),
            Self::Invalid(what) => write!(f, "the snapshot is of no world: {what}"),
            Self::MissingGeometry { key } => {
                write!(f, "the snapshot names the hull or mesh {key}, which is not in the library")
            }
        }
    }
}

impl core::error::Error for SnapshotError {}

/// The saved part of a world: all state that outlives a step.
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
struct Saved<'a> {
    tables: Cow<'a, Tables>,
    last_h: f32,
    pending: Cow<'a, Events>,
    shapes: SavedShapes<'a>,
}

/// Appends bytes to an existing list.
struct Append<'a>(&'a mut Vec<u8>);

impl Flavor for Append<'_> {
    type Output = ();

    fn try_push(&mut self, byte: u8) -> postcard::Result<()> {
        self.0.push(byte);
        Ok(())
    }

    fn try_extend(&mut self, bytes: &[u8]) -> postcard::Result<()> {
        self.0.extend_from_slice(bytes);
        Ok(())
    }

    fn finalize(self) -> postcard::Result<()> {
        Ok(())
    }
}

/// The hash of bytes.
pub(crate) fn checksum(bytes: &[u8]) -> u64 {
    let mut hash = StateHash::default();
    let (words, rest) = bytes.as_chunks::<4>();
    for word in words {
        hash.word(u32::from_le_bytes(*word));
    }
    for byte in rest {
        hash.word(u32::from(*byte));
    }
    hash.finish()
}

/// Removes the first `N` bytes and returns them.
pub(crate) fn split<const N: usize>(bytes: &mut &[u8]) -> Option<[u8; N]> {
    let (first, rest) = bytes.split_first_chunk::<N>()?;
    *bytes = rest;
    Some(*first)
}

impl World {
    /// The whole world as bytes. [`World::restore`] turns them into a world that continues with the
    /// same bits and the same ids, so ids held by the program stay valid. Each hull and mesh is
    /// stored once. The executor and the SIMD level, which change no result, and the ledger of
    /// [`World::begin_ledger`] are not stored.
    ///
    /// Bytes are identical across machines for equal thread counts. Other thread counts may order
    /// contacts differently; results do not change.
    ///
    /// ```
    /// # fn main() -> Result<(), Box<dyn std::error::Error>> {
    /// use drystone::{BodyDef, ShapeDef, World};
    ///
    /// let mut world = World::default();
    /// world.add_body(BodyDef::fixed().with_shape(ShapeDef::half_space([0.0, 1.0, 0.0], 0.0)))?;
    /// let ball = BodyDef::dynamic().with_position([0.0, 2.0, 0.0]);
    /// let ball = world.add_body(ball.with_shape(ShapeDef::sphere(0.5)))?;
    /// world.step(1.0 / 60.0);
    ///
    /// let mut later = World::restore(&world.snapshot())?;
    /// for _ in 0..100 {
    ///     world.step(1.0 / 60.0);
    ///     later.step(1.0 / 60.0);
    ///     assert_eq!(world.state_hash(), later.state_hash());
    /// }
    /// assert_eq!(world.body(ball).map(|b| b.position()), later.body(ball).map(|b| b.position()));
    /// # Ok(())
    /// # }
    /// ```
    #[must_use]
    pub fn snapshot(&self) -> Vec<u8> {
        let mut bytes = Vec::new();
        self.snapshot_into(&mut bytes);
        bytes
    }

    /// Like [`Self::snapshot`], and replaces the content of an existing list.
    pub fn snapshot_into(&self, bytes: &mut Vec<u8>) {
        self.snapshot_with(&Library::default(), bytes);
    }

    /// Like [`Self::snapshot_into`], with references to the hulls and meshes in `library` in place
    /// of copies. Restoring the world requires a library that contains them. Other hulls and meshes
    /// are stored. The library must contain the very objects that shapes of this world share
    /// ([`Library::add_world`]), not equal copies.
    pub fn snapshot_with(&self, library: &Library, bytes: &mut Vec<u8>) {
        let saved = Saved {
            tables: Cow::Borrowed(&self.tables),
            last_h: self.last_h,
            pending: Cow::Borrowed(&self.pending),
            shapes: SavedShapes::of(&self.tables.shapes, library),
        };
        bytes.clear();
        bytes.extend_from_slice(&MAGIC);
        bytes.extend_from_slice(&VERSION.to_le_bytes());
        // Space for the checksum.
        bytes.extend_from_slice(&[0; 8]);
        postcard::serialize_with_flavor(&saved, Append(bytes))
            .expect("tables of numbers and lists can be written");
        let sum = checksum(&bytes[HEADER..]);
        bytes[HEADER - 8..HEADER].copy_from_slice(&sum.to_le_bytes());
    }

    /// Restores the world of a [`World::snapshot`]. The bytes need not be trusted: invalid ones are
    /// refused. The world steps on the calling thread until it gets another executor.
    ///
    /// # Errors
    /// Reason why the bytes are not a world.
    pub fn restore(bytes: &[u8]) -> Result<Self, SnapshotError> {
        Self::read(bytes, &Library::default())
    }

    /// Returns to the world of a snapshot. This world keeps its memory, its executor and its SIMD
    /// level. An open ledger is closed.
    ///
    /// # Errors
    /// Reason why the bytes are not a world; then this world is unchanged.
    pub fn restore_from(&mut self, bytes: &[u8]) -> Result<(), SnapshotError> {
        self.restore_with(&Library::default(), bytes)
    }

    /// Like [`Self::restore_from`], for a snapshot with references to hulls and meshes of
    /// `library`: see [`Self::snapshot_with`].
    ///
    /// # Errors
    /// Reason why the bytes are not a world, or which hull or mesh is missing; then this world is
    /// unchanged.
    pub fn restore_with(&mut self, library: &Library, bytes: &[u8]) -> Result<(), SnapshotError> {
        let world = Self::read(bytes, library)?;
        self.copy_state(&world);
        Ok(())
    }

    fn read(mut bytes: &[u8], library: &Library) -> Result<Self, SnapshotError> {
        if split(&mut bytes) != Some(MAGIC) {
            return Err(SnapshotError::NotASnapshot);
        }
        let found = u32::from_le_bytes(split(&mut bytes).ok_or(SnapshotError::Damaged)?);
        if found != VERSION {
            return Err(SnapshotError::Version { found, read: VERSION });
        }
        let sum = u64::from_le_bytes(split(&mut bytes).ok_or(SnapshotError::Damaged)?);
        if sum != checksum(bytes) {
            return Err(SnapshotError::Damaged);
        }
        Self::decode(bytes, library)
    }

    /// Decodes the world that follows the header.
    fn decode(bytes: &[u8], library: &Library) -> Result<Self, SnapshotError> {
        let unread = |_| SnapshotError::Invalid("a list or a number is not what it should be");
        let (saved, rest) = postcard::take_from_bytes::<Saved<'_>>(bytes).map_err(unread)?;
        if !rest.is_empty() {
            return Err(SnapshotError::Invalid("there is more than a world"));
        }
        let Saved { tables, last_h, pending, shapes } = saved;
        let mut tables = tables.into_owned();
        shapes.load(&mut tables.shapes, library)?;
        tables.check().map_err(SnapshotError::Invalid)?;
        if !(0.0..=10.0).contains(&last_h) {
            return Err(SnapshotError::Invalid("its last step is out of range"));
        }
        Ok(Self { tables, last_h, pending: pending.into_owned(), ..Self::default() })
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::{HEADER, Library, SnapshotError};
    use crate::base::random::Random;
    use crate::base::trig;
    use crate::method::Method;
    use crate::state::breakage::GlueBond;
    use crate::state::contacts::Contact;
    use crate::state::tables::Tables;
    use crate::{
        BodyDef, Hull, JointDef, Mesh, Quat, Shape, ShapeDef, Vec3, World, WorldConfig, vec3,
    };
    use crate::{breakage::BondStrength, breakage::Fracture, breakage::Glue};
    use crate::{
        joint::Ball, joint::CouplingDef, joint::Hinge, joint::JointAxis, joint::JointDrive,
        joint::Pulley,
    };
    use crate::{particle::ClothDef, particle::LinkKind, particle::RopeDef};

    const DT: f32 = 1.0 / 60.0;

    /// A world with some objects of every type, after some steps.
    fn everything(method: &str) -> World {
        let method = Method::named(method).unwrap();
        let mut world = World::new(WorldConfig { method, ..WorldConfig::default() }).unwrap();
        let corner = |x: f32, z: f32| vec3(x, 0.1 * (x + z), z);
        let corners = [(-9.0, -9.0), (9.0, -9.0), (9.0, 9.0), (-9.0, 9.0), (0.0, 0.0)];
        let corners = corners.map(|(x, z)| corner(x, z)).to_vec();
        let triangles = vec![[0, 1, 4], [1, 2, 4], [2, 3, 4], [3, 0, 4]];
        let mesh = Arc::new(Mesh::new(corners, triangles).unwrap());
        let ground = BodyDef::fixed().with_shape(ShapeDef::new(Shape::Mesh(mesh)));
        let ground = world.add_body(ground).unwrap();
        let stone: Vec<Vec3> = (0..6_u8)
            .flat_map(|i| {
                let (s, c) = trig::sin_cos(f32::from(i) * 1.1);
                [vec3(c, 0.4, s), vec3(0.8 * s, -0.5, c)]
            })
            .collect();
        let stone = Arc::new(Hull::from_points(&stone).unwrap());
        let at = |x: f32, y: f32, z: f32| BodyDef::dynamic().with_position([x, y, z]);
        let cube = ShapeDef::box_half([0.4; 3]).with_restitution(0.2);
        for i in 0..4_u8 {
            let i = f32::from(i);
            world.add_body(at(0.1 * i, 0.6 + 0.8 * i, 0.0).with_shape(cube.clone())).unwrap();
            let stone = ShapeDef::new(Shape::Hull(Arc::clone(&stone)));
            world.add_body(at(-3.0 + 2.0 * i, 3.0, -4.0).with_shape(stone)).unwrap();
        }
        world.add_body(at(6.0, 3.0, 6.0).with_shape(ShapeDef::sphere(0.5))).unwrap();
        let hung = |shape| at(-5.0, 5.0, 2.0).with_shape(shape);
        let arm = world.add_body(hung(ShapeDef::capsule(0.5, 0.1))).unwrap();
        let hand = at(-5.0, 4.0, 2.0).with_shape(ShapeDef::cylinder(0.3, 0.1));
        let hand = world.add_body(hand).unwrap();
        let mut hinge = |a, b, y: f32| {
            let axis = JointAxis::driven(JointDrive::motor(1.0, 500.0));
            let about = Hinge::of(axis).six_dof();
            let def = JointDef::new(a, b, about).at([-5.0, y, 2.0]).with_axis(Vec3::Z);
            world.add_joint(def.with_strength(1.0e6, 1.0e6)).unwrap()
        };
        let joints = [hinge(ground, arm, 6.0), hinge(arm, hand, 4.5)];
        world.add_coupling(CouplingDef::gear(joints[0], joints[1], -2.0)).unwrap();
        let weight = |x: f32| at(x, 4.0, 5.0).with_shape(ShapeDef::sphere(0.3));
        let (left, right) =
            (world.add_body(weight(-2.0)).unwrap(), world.add_body(weight(2.0)).unwrap());
        let points = [vec3(-2.0, 8.0, 5.0), vec3(2.0, 8.0, 5.0)];
        let over = Pulley { points, ratio: 1.0, length: 8.0, is_rigid: false };
        world.add_joint(JointDef::new(left, right, over)).unwrap();
        let swing = world.add_body(at(-7.0, 4.0, -2.0).with_shape(ShapeDef::sphere(0.3))).unwrap();
        world
            .add_joint(
                JointDef::new(ground, swing, Ball::new())
                    .with_anchors([-8.0, 5.0, -2.0], [-1.0, 1.0, 0.0]),
            )
            .unwrap();
        let rope = RopeDef {
            kind: LinkKind::Equal,
            ..RopeDef::between([5.0, 6.0, 0.0], [5.0, 4.0, 0.0], 5)
        };
        let rope = world.add_rope(rope).unwrap();
        let load = world.add_body(at(5.0, 3.7, 0.0).with_shape(ShapeDef::sphere(0.3))).unwrap();
        world
            .particle_mut(rope.particles[5])
            .expect("there")
            .attach(load, [0.0, 0.3, 0.0])
            .unwrap();
        world.particle_mut(rope.particles[0]).unwrap().set_pinned(true);
        let cloth = ClothDef::new([2.0, 3.0, -1.0], [Vec3::X, Vec3::Z], [3, 3]);
        world.add_cloth(cloth).unwrap();
        let piece =
            |i: u8| ShapeDef::box_half([0.3; 3]).with_position(vec3(0.6 * f32::from(i), 0.0, 0.0));
        let shapes: Vec<ShapeDef> = (0..3).map(piece).collect();
        let glue = Glue::touching(&shapes, 1.0e-3, BondStrength::both(1.0e5)).unwrap();
        let rod = BodyDef { shapes, ..at(-6.0, 3.0, 6.0) };
        world.add_body(rod.with_glue(glue)).unwrap();
        let brittle = at(4.0, 3.0, 4.0).with_shape(ShapeDef::box_half([0.4; 3]));
        let brittle =
            BodyDef { fracture: Some(Fracture::by_impulse(100.0).with_pieces(4)), ..brittle };
        world.add_body(brittle).unwrap();
        let gate = ShapeDef { sensor: true, ..ShapeDef::box_half([2.0, 2.0, 2.0]) };
        world.add_body(BodyDef::fixed().with_shape(gate)).unwrap();
        let mill = BodyDef::kinematic()
            .with_position([3.0, 1.0, -6.0])
            .with_angular_velocity([0.0, 1.0, 0.0]);
        let mill = mill.with_rotation(Quat::from_axis_angle(Vec3::Y, 0.3));
        world.add_body(mill.with_shape(ShapeDef::box_half([2.0, 0.2, 0.2]))).unwrap();
        let gone = world.add_body(at(0.0, 50.0, 0.0).with_shape(ShapeDef::sphere(1.0))).unwrap();
        world.remove_body(gone);
        let asleep = BodyDef { asleep: true, ..at(0.0, 90.0, 0.0) };
        world.add_body(asleep.with_shape(ShapeDef::sphere(1.0))).unwrap();
        for _ in 0..40 {
            world.step(DT);
        }
        world
    }

    #[test]
    fn what_is_no_snapshot_is_refused() {
        let bytes = everything("soft-step").snapshot();
        assert_eq!(World::restore(b"").unwrap_err(), SnapshotError::NotASnapshot);
        assert_eq!(World::restore(b"drystont....").unwrap_err(), SnapshotError::NotASnapshot);
        for end in [8, 11, 19, HEADER, bytes.len() - 1] {
            assert_eq!(World::restore(&bytes[..end]).unwrap_err(), SnapshotError::Damaged, "{end}");
        }
        let mut later = bytes.clone();
        later[8] += 1;
        let error = World::restore(&later).unwrap_err();
        assert!(matches!(error, SnapshotError::Version { found: 10, read: 9 }), "{error}");
        let mut changed = bytes;
        changed[HEADER + 100] ^= 1;
        assert_eq!(World::restore(&changed).unwrap_err(), SnapshotError::Damaged);
    }

    /// The checksum is correct, as in a forged file. Accepted bytes must give a valid world.
    #[test]
    fn changed_bytes_are_refused_or_give_a_world_that_steps() {
        let count = std::env::var("DRYSTONE_FUZZ").ok().and_then(|n| n.parse().ok()).unwrap_or(400);
        for method in ["soft-step", "guendelman"] {
            let bytes = everything(method).snapshot().split_off(HEADER);
            let mut random = Random::new(7);
            let mut below = |n: usize| usize::try_from(random.next() % n as u64).unwrap();
            let mut taken = 0;
            for case in 0..count {
                let mut changed = bytes.clone();
                for _ in 0..=below(3) {
                    let at = below(changed.len());
                    match below(6) {
                        0 => changed[at] ^= 1 << below(8),
                        1 => changed[at] = changed[at].wrapping_add(1),
                        2 => changed[at] = [0, 1, 0x7f, 0x80, 0xff][below(5)],
                        3 => {
                            changed.remove(at);
                        }
                        4 => changed.truncate(at),
                        _ => {
                            let from = below(changed.len());
                            let n = below(40).min(changed.len() - from.max(at));
                            changed.copy_within(from..from + n, at);
                        }
                    }
                    if changed.is_empty() {
                        break;
                    }
                }
                let run = std::panic::catch_unwind(|| {
                    let Ok(mut world) = World::decode(&changed, &Library::default()) else {
                        return false;
                    };
                    for _ in 0..30 {
                        world.step(DT);
                    }
                    let _ = world.audit();
                    let again = World::restore(&world.snapshot());
                    assert!(again.is_ok(), "{}", again.unwrap_err());
                    true
                });
                taken += usize::from(run.unwrap_or_else(|_| panic!("{method}, case {case}")));
            }
            println!("{method}: {taken} of {count} are worlds");
            assert!(taken * 20 > count, "{taken} of {count}: hardly any is looked at");
        }
    }

    /// Changes the first contact with points.
    fn press(tables: &mut Tables, change: fn(&mut Contact)) {
        let found = tables.contacts.iter().find(|(_, c)| c.count > 0 && !c.sensor);
        let row = found.map(|(row, _)| row).unwrap();
        change(tables.contacts.at_mut(row));
    }

    /// Changes the first bond.
    fn glue(tables: &mut Tables, change: fn(&mut GlueBond)) {
        let first = tables.breakage.glued.values_mut().flat_map(|glued| &mut glued.bonds).next();
        change(first.unwrap());
    }

    /// Changes the first hull.
    fn hull(tables: &mut Tables, change: fn(&mut Hull)) {
        let rows = tables.shapes.rows.values_mut().iter_mut().flatten();
        let mut hulls = rows.filter_map(|row| match &mut row.shape {
            Shape::Hull(hull) => Some(hull),
            _ => None,
        });
        change(Arc::make_mut(hulls.next().unwrap()));
    }

    /// Some finite numbers are invalid in a step too: a normal that is not a unit vector would
    /// generate energy.
    #[test]
    fn numbers_that_no_step_can_leave_are_refused() {
        type Change = (&'static str, fn(&mut Tables));
        let world = everything("soft-step");
        assert!(World::restore(&world.snapshot()).is_ok());
        let changes: [Change; 20] = [
            ("length of a rotation", |t| t.bodies.at_mut(0).rotation.w *= 1.03),
            ("normal", |t| press(t, |c| c.normal *= 1.0e-20)),
            ("offset", |t| press(t, |c| c.offset.x = 1.0e30)),
            ("arm", |t| press(t, |c| c.points[0].r_a.y = -1.0e30)),
            ("separation", |t| press(t, |c| c.points[0].separation = 1.0e30)),
            ("friction", |t| press(t, |c| c.friction = f32::INFINITY)),
            ("kinetic friction", |t| press(t, |c| c.kinetic = 2.0)),
            ("restitution", |t| press(t, |c| c.restitution = 1.0e9)),
            // Some of these numbers would be valid for another pair.
            ("restitution of others", |t| press(t, |c| c.restitution = 1.0e-30)),
            ("resistance of others", |t| press(t, |c| c.rolling += 1.0e-3)),
            ("base of others", |t| press(t, |c| c.round_patch = !c.round_patch)),
            ("flatness of others", |t| press(t, |c| c.recyclable = !c.recyclable)),
            ("speed of arrival", |t| press(t, |c| c.set_approach(f32::NAN))),
            ("area of a bond", |t| glue(t, |bond| bond.area = f32::INFINITY)),
            ("no area of a bond", |t| glue(t, |bond| bond.area = 0.0)),
            ("normal of a bond", |t| glue(t, |bond| bond.normal *= 1.0e10)),
            ("normal of a face", |t| hull(t, |hull| hull.planes[0].normal *= 1.0e-20)),
            ("distance of a face", |t| hull(t, |hull| hull.planes[1].offset += 0.5)),
            ("corner", |t| hull(t, |hull| hull.vertices[0] *= 3.0)),
            ("half extents", |t| hull(t, |hull| hull.cuboid = Some(Vec3::splat(0.3)))),
        ];
        for (what, change) in changes {
            let mut changed = world.clone();
            change(&mut changed.tables);
            assert!(World::restore(&changed.snapshot()).is_err(), "{what}");
        }
    }
}
