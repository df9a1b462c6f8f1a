//! Public access to contacts and counts.

use super::BodyRef;
use crate::base::id::{BodyId, ShapeId};
use crate::base::math::Vec3;
use crate::query::shape::ShapeRef;
use crate::state::contacts::Contact;
use crate::state::def::BodyKind;
use crate::state::tables::Tables;

/// A contact point.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct ContactPoint {
    /// Position at the beginning of the step [m, world].
    pub position: Vec3,
    /// Distance of the surfaces along the normal at the beginning of the step [m]; negative:
    /// overlap.
    pub separation: f32,
    /// Impulse along the normal in the last substep [N s].
    pub impulse: f32,
}

/// A contact with points, read-only.
#[derive(Clone, Copy, Debug)]
pub struct ContactRef<'w> {
    tables: &'w Tables,
    contact: &'w Contact,
}

impl ContactRef<'_> {
    /// First shape.
    #[must_use]
    pub fn shape_a(&self) -> ShapeId {
        self.tables.shapes.id(self.contact.shape_a)
    }

    /// Second shape.
    #[must_use]
    pub fn shape_b(&self) -> ShapeId {
        self.tables.shapes.id(self.contact.shape_b)
    }

    /// Body of the first shape.
    #[must_use]
    pub fn body_a(&self) -> BodyId {
        self.tables.bodies.id(self.contact.body_a)
    }

    /// Body of the second shape.
    #[must_use]
    pub fn body_b(&self) -> BodyId {
        self.tables.bodies.id(self.contact.body_b)
    }

    /// The other body of the contact; `None` if `body` is not part of it.
    ///
    /// ```
    /// use drystone::{BodyDef, DefError, ShapeDef, World};
    ///
    /// fn main() -> Result<(), DefError> {
    ///     let mut world = World::default();
    ///     let ground = BodyDef::fixed().with_shape(ShapeDef::half_space([0.0, 1.0, 0.0], 0.0));
    ///     let ground = world.add_body(ground)?;
    ///     let ball = BodyDef::dynamic().with_position([0.0, 0.5, 0.0]);
    ///     let ball = world.add_body(ball.with_shape(ShapeDef::sphere(0.5)))?;
    ///     world.step(1.0 / 60.0);
    ///     let under: Vec<_> = world.body(ball).into_iter().flat_map(|b| b.contacts().collect::<Vec<_>>()).collect();
    ///     assert_eq!(under.first().and_then(|contact| contact.other_body(ball)), Some(ground));
    ///     assert_eq!(world.contacts_between(ground, ball).count(), 1);
    ///     Ok(())
    /// }
    /// ```
    #[must_use]
    pub fn other_body(&self, body: BodyId) -> Option<BodyId> {
        let (a, b) = (self.body_a(), self.body_b());
        if body == a { Some(b) } else { (body == b).then_some(a) }
    }

    /// Contact normal from A to B [world, unit].
    #[must_use]
    pub const fn normal(&self) -> Vec3 {
        self.contact.normal
    }

    /// Friction impulse on B in the last substep [N s, world].
    #[must_use]
    pub const fn friction_impulse(&self) -> Vec3 {
        self.contact.tangent_impulse
    }

    /// Solver color of the contact; `None` while it sleeps. Contacts with a static or kinematic
    /// body have their own color numbers.
    #[must_use]
    pub fn color(&self) -> Option<u32> {
        self.contact.place.is_somewhere().then_some(self.contact.place.color)
    }

    /// The contact points, 1 to 4.
    pub fn points(&self) -> impl Iterator<Item = ContactPoint> {
        let center = self.tables.bodies.at(self.contact.body_a).center;
        self.contact.points().iter().map(move |p| ContactPoint {
            position: center + p.r_a,
            separation: p.separation,
            impulse: p.impulse,
        })
    }
}

pub(super) fn contacts(tables: &Tables) -> impl Iterator<Item = ContactRef<'_>> {
    tables
        .contacts
        .iter()
        .filter(|(_, c)| c.count > 0 && !c.sensor)
        .map(|(_, contact)| ContactRef { tables, contact })
}

/// Contacts with points of the body in row `body`, in the order of the body's list.
fn of_body(tables: &Tables, body: u32) -> impl Iterator<Item = ContactRef<'_>> {
    let rows = tables.contacts.of_body(tables.bodies.at(body)).map(|(row, _)| row);
    let contacts = rows.map(|row| tables.contacts.at(row));
    let solid = contacts.filter(|c| c.count > 0 && !c.sensor);
    solid.map(|contact| ContactRef { tables, contact })
}

impl<'w> BodyRef<'w> {
    /// The contacts of this body that have points, in no promised order that is the same for any
    /// number of threads. Only the body's own contact list is walked. Sensors have no contacts: see
    /// [`ShapeRef::sensor_overlaps`].
    pub fn contacts(&self) -> impl Iterator<Item = ContactRef<'w>> + use<'w> {
        of_body(self.tables(), self.id().index())
    }
}

impl<'w> ShapeRef<'w> {
    /// The contacts of this shape that have points. The contact list of its body is walked.
    pub fn contacts(&self) -> impl Iterator<Item = ContactRef<'w>> + use<'w> {
        let (tables, row) = (self.tables(), self.id().index());
        let of_shape =
            move |c: &ContactRef<'_>| c.contact.shape_a == row || c.contact.shape_b == row;
        of_body(tables, tables.shapes.at(row).body).filter(of_shape)
    }

    /// The shapes in this sensor or, if this shape is not a sensor, the sensors that contain it.
    /// The state is that of the last step: overlaps with an enter
    /// [`SensorEvent`](crate::events::SensorEvent) and no exit event since. The contact list of the
    /// body is walked. A sensor does not detect other sensors.
    ///
    /// ```
    /// use drystone::{BodyDef, DefError, ShapeDef, World};
    ///
    /// fn main() -> Result<(), DefError> {
    ///     let mut world = World::default();
    ///     let zone = ShapeDef { sensor: true, ..ShapeDef::box_half([1.0; 3]) };
    ///     let zone = world.add_body(BodyDef::fixed().with_shape(zone))?;
    ///     let ball = world.add_body(BodyDef::dynamic().with_shape(ShapeDef::sphere(0.5)))?;
    ///     world.step(1.0 / 60.0);
    ///     let zone = world.body(zone).and_then(|b| b.shapes().next());
    ///     let zone = zone.and_then(|id| world.shape(id));
    ///     let inside: Vec<_> = zone.into_iter().flat_map(|z| z.sensor_overlaps()).collect();
    ///     assert_eq!(inside, world.body(ball).map_or(vec![], |b| b.shapes().collect()));
    ///     Ok(())
    /// }
    /// ```
    pub fn sensor_overlaps(&self) -> impl Iterator<Item = ShapeId> + use<'w> {
        let (tables, row) = (self.tables(), self.id().index());
        let rows = tables.contacts.of_body(tables.bodies.at(tables.shapes.at(row).body));
        let contacts = rows.map(move |(contact, _)| tables.contacts.at(contact));
        let touching = contacts.filter(|c| c.sensor && c.touching && !c.is_part);
        touching.filter_map(move |c| match row {
            row if row == c.shape_a => Some(tables.shapes.id(c.shape_b)),
            row if row == c.shape_b => Some(tables.shapes.id(c.shape_a)),
            _ => None,
        })
    }
}

/// Contacts between two bodies that have points. The shorter list is walked where it is known,
/// because static bodies may have thousands of contacts.
pub(super) fn contacts_between(
    tables: &Tables,
    a: BodyId,
    b: BodyId,
) -> impl Iterator<Item = ContactRef<'_>> {
    let rows = tables.bodies.rows.row(a).zip(tables.bodies.rows.row(b));
    rows.into_iter().flat_map(move |(a, b)| {
        let is_dynamic = tables.bodies.at(a).kind == BodyKind::Dynamic;
        let (walked, other) = if is_dynamic { (a, b) } else { (b, a) };
        of_body(tables, walked)
            .filter(move |c| c.contact.body_a == other || c.contact.body_b == other)
    })
}

/// Numbers of bodies, shapes, joints and so on in a world.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub struct WorldCounts {
    /// Static bodies.
    pub fixed: usize,
    /// Kinematic bodies.
    pub kinematic: usize,
    /// Dynamic bodies.
    pub dynamic: usize,
    /// Dynamic bodies that are asleep.
    pub asleep: usize,
    /// Shapes.
    pub shapes: usize,
    /// Joints.
    pub joints: usize,
    /// Particles.
    pub particles: usize,
    /// Particles that are asleep.
    pub particles_asleep: usize,
    /// Links between particles.
    pub links: usize,
    /// Pairs of shapes whose boxes overlap, including sleeping pairs.
    pub pairs: usize,
    /// Contacts with points that take part in the solve.
    pub contacts: usize,
    /// Contact colors in use.
    pub colors: usize,
}

pub(super) fn counts(tables: &Tables) -> WorldCounts {
    let mut counts = WorldCounts {
        shapes: tables.shapes.rows.len(),
        joints: tables.joints.rows.len(),
        particles: tables.particles.rows.len(),
        particles_asleep: tables.particles.rows.iter().filter(|(_, p)| p.frozen).count(),
        links: tables.particles.links.len(),
        pairs: tables.contacts.iter().filter(|(_, c)| !c.is_part).count(),
        contacts: tables.colors.contacts.len() + tables.colors.contacts_fixed.len(),
        ..WorldCounts::default()
    };
    for coloring in [&tables.colors.contacts, &tables.colors.contacts_fixed] {
        counts.colors += coloring.colors.iter().filter(|c| !c.members.is_empty()).count();
    }
    for (_, body) in tables.bodies.rows.iter() {
        match body.kind {
            BodyKind::Static => counts.fixed += 1,
            BodyKind::Kinematic => counts.kinematic += 1,
            BodyKind::Dynamic => {
                counts.dynamic += 1;
                counts.asleep += usize::from(body.sleeps() && !body.record.disabled);
            }
        }
    }
    counts
}
