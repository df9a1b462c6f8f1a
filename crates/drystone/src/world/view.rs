//! Contacts and counts as the user sees them.

use crate::base::id::{BodyId, ShapeId};
use crate::base::math::Vec3;
use crate::state::contacts::Contact;
use crate::state::def::BodyKind;
use crate::state::tables::Tables;

/// A point of a contact.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ContactPoint {
    /// Where, as it was when the step began [m, world].
    pub position: Vec3,
    /// Distance of the surfaces along the normal as the step began [m]; negative: overlap.
    pub separation: f32,
    /// Impulse along the normal in the last substep [N s].
    pub impulse: f32,
}

/// A contact with points, to read.
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

    /// Unit, from A to B [world].
    #[must_use]
    pub const fn normal(&self) -> Vec3 {
        self.contact.normal
    }

    /// Friction impulse in the last substep, as it acts on B [N s, world].
    #[must_use]
    pub const fn friction_impulse(&self) -> Vec3 {
        self.contact.tangent_impulse
    }

    /// Number of the color it is solved with, counted apart for contacts with a static or kinematic
    /// body; none while it sleeps.
    #[must_use]
    pub fn color(&self) -> Option<u32> {
        self.contact.place.is_somewhere().then_some(self.contact.place.color)
    }

    /// Its points, 1 to 4.
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

/// How many of everything a world has.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
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
    /// Pairs of shapes whose boxes overlap, sleeping ones too.
    pub pairs: usize,
    /// Contacts with points that are solved.
    pub contacts: usize,
    /// Colors of contacts in use.
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
                counts.asleep += usize::from(body.sleeps() && !body.disabled);
            }
        }
    }
    counts
}
