//! Ropes, cloths and clouds: many particles and links at once.

#[cfg(feature = "serde")]
use serde::{Deserialize, Serialize};

use crate::base::id::{LinkId, ParticleId};
use crate::base::math::Vec3;
use crate::state::def::DefError;
use crate::state::def::check::position;
use crate::state::def::particle_def::{LinkDef, LinkKind, LinkSpring, ParticleDef};
use crate::world::World;

/// A rope: particles in a row, each linked to the next.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
pub struct RopeDef {
    /// Position of the first end [m, world].
    pub from: Vec3,
    /// Position of the last end [m, world].
    pub to: Vec3,
    /// Number of links, 1 to 1,000,000. The number of particles is one more.
    pub links: usize,
    /// Length of the rope [m]; `None` (the default): the distance of its ends. The particles start
    /// on the straight line, so a longer rope is slack at first.
    pub length: Option<f32>,
    /// Total mass [kg], spread evenly over the particles; default 1.
    pub mass: f32,
    /// Kind of the links; default [`LinkKind::AtMost`].
    pub kind: LinkKind,
    /// Whether the first and the last particle are pinned; default neither.
    pub pinned: [bool; 2],
    /// Other settings of the particles; default radius 0.02 m.
    pub particle: ParticleDef,
    /// See [`LinkDef::tear_strain`].
    pub tear_strain: Option<f32>,
    /// See [`LinkDef::tear_force`].
    pub tear_force: Option<f32>,
}

impl RopeDef {
    /// A rope between two points [m, world].
    #[must_use]
    pub fn between(from: impl Into<Vec3>, to: impl Into<Vec3>, links: usize) -> Self {
        Self {
            from: from.into(),
            to: to.into(),
            links,
            length: None,
            mass: 1.0,
            kind: LinkKind::AtMost,
            pinned: [false; 2],
            particle: ParticleDef { radius: 0.02, ..ParticleDef::default() },
            tear_strain: None,
            tear_force: None,
        }
    }
}

/// A rectangle of cloth: a grid of particles. Links connect neighbors (stretch), diagonals (shear)
/// and particles two squares apart (bend).
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
pub struct ClothDef {
    /// Position of the first corner [m, world].
    pub corner: Vec3,
    /// The two sides, as vectors from the first corner [m, world].
    pub sides: [Vec3; 2],
    /// Number of squares along each side, each 1 to 4,000.
    pub squares: [usize; 2],
    /// Total mass [kg], spread evenly over the particles; default 1.
    pub mass: f32,
    /// Kind of the links along the threads; default [`LinkKind::AtMost`].
    pub stretch: LinkKind,
    /// Kind of the diagonal links; `None`: no such links. Default: springs of 20 Hz.
    pub shear: Option<LinkKind>,
    /// Kind of the links over two squares, which resist bending; `None`: no such links. Default:
    /// springs of 5 Hz.
    pub bend: Option<LinkKind>,
    /// Other settings of the particles; default radius 0.02 m, damping 0.1/s.
    pub particle: ParticleDef,
    /// See [`LinkDef::tear_strain`]; for the links along the threads.
    pub tear_strain: Option<f32>,
    /// See [`LinkDef::tear_force`]; for the links along the threads.
    pub tear_force: Option<f32>,
}

impl ClothDef {
    /// A cloth with this corner [m, world], these sides [m, world] and these numbers of squares
    /// along them.
    #[must_use]
    pub fn new(corner: impl Into<Vec3>, sides: [Vec3; 2], squares: [usize; 2]) -> Self {
        let spring = |hertz: f32| LinkSpring::Frequency { hertz, damping_ratio: 0.5 };
        Self {
            corner: corner.into(),
            sides,
            squares,
            mass: 1.0,
            stretch: LinkKind::AtMost,
            shear: Some(LinkKind::Spring(spring(20.0))),
            bend: Some(LinkKind::Spring(spring(5.0))),
            particle: ParticleDef { radius: 0.02, damping: 0.1, ..ParticleDef::default() },
            tear_strain: None,
            tear_force: None,
        }
    }
}

/// Particles and links that were added together.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
pub struct Strand {
    /// The particles: a rope's from its first end, a cloth's row by row along its first side.
    pub particles: Vec<ParticleId>,
    /// The links: a rope's from its first end; a cloth's along the first side, along the second
    /// side, across the squares, and over two squares.
    pub links: Vec<LinkId>,
}

/// Maximum number of links of a rope.
const MAX_LINKS: usize = 1_000_000;
const MAX_SQUARES: usize = 4000;

/// Maximum number of squares of a cloth in total; they take some hundred megabytes.
const MAX_SQUARES_IN_ALL: usize = 1_000_000;

#[expect(clippy::cast_precision_loss, reason = "far below 2^24")]
const fn real(n: usize) -> f32 {
    n as f32
}

fn number(n: usize) -> u32 {
    u32::try_from(n).expect("at most 4,000 squares a side")
}

impl World {
    /// Adds a rope.
    ///
    /// # Errors
    /// The first field that is out of range; then nothing is added.
    pub fn add_rope(&mut self, def: RopeDef) -> Result<Strand, DefError> {
        if !(1..=MAX_LINKS).contains(&def.links) {
            return Err(DefError::new("links", def.links, "a number from 1 to 1,000,000"));
        }
        position("from", def.from)?;
        position("to", def.to)?;
        let length = def.length.unwrap_or_else(|| (def.to - def.from).length());
        let part = length / real(def.links);
        let mass = def.mass / real(def.links + 1);
        let mut strand = Strand::default();
        let made = self.fill(&mut strand, |world, strand| {
            for i in 0..=def.links {
                let pinned = (i == 0 && def.pinned[0]) || (i == def.links && def.pinned[1]);
                let position = def.from.lerp(def.to, real(i) / real(def.links));
                let particle = ParticleDef { position, mass, pinned, ..def.particle };
                strand.particles.push(world.add_particle(particle)?);
            }
            for i in 0..def.links {
                let (a, b) = (strand.particles[i], strand.particles[i + 1]);
                let link = LinkDef {
                    length: Some(part),
                    tear_strain: def.tear_strain,
                    tear_force: def.tear_force,
                    ..LinkDef::new(a, b, def.kind)
                };
                strand.links.push(world.add_link(link)?);
            }
            Ok(())
        });
        made.map(|()| strand)
    }

    /// Adds a cloth.
    ///
    /// # Errors
    /// The first field that is out of range; then nothing is added.
    pub fn add_cloth(&mut self, def: ClothDef) -> Result<Strand, DefError> {
        let [n, m] = def.squares;
        let fits = (1..=MAX_SQUARES).contains(&n) && (1..=MAX_SQUARES).contains(&m);
        if !(fits && n * m <= MAX_SQUARES_IN_ALL) {
            let allowed = "1 to 4,000 per side and at most 1,000,000 in total";
            return Err(DefError::new("squares", format!("{n} by {m}"), allowed));
        }
        position("corner", def.corner)?;
        position("sides[0]", def.sides[0])?;
        position("sides[1]", def.sides[1])?;
        let mass = def.mass / (real(n + 1) * real(m + 1));
        let mut strand = Strand::default();
        let made = self.fill(&mut strand, |world, strand| {
            for k in 0..=m {
                for i in 0..=n {
                    let along = def.sides[0] * (real(i) / real(n));
                    let position = def.corner + along + def.sides[1] * (real(k) / real(m));
                    let particle = ParticleDef { position, mass, ..def.particle };
                    strand.particles.push(world.add_particle(particle)?);
                }
            }
            // The rows and columns are solved as chains.
            let rows = world.tables.particles.threads.wrapping_add(1);
            let columns = rows.wrapping_add(number(m + 1));
            world.tables.particles.threads = columns.wrapping_add(number(n));
            // The links are added by kind and offset, so that the colors fill one after the other.
            let tears = (def.tear_strain, def.tear_force);
            let threads = [(1, 0, Some(def.stretch), tears), (0, 1, Some(def.stretch), tears)];
            let across = [(1, 1, def.shear, (None, None)), (-1, 1, def.shear, (None, None))];
            let over = [(2, 0, def.bend, (None, None)), (0, 2, def.bend, (None, None))];
            for (di, dk, kind, (tear_strain, tear_force)) in
                threads.into_iter().chain(across).chain(over)
            {
                let Some(kind) = kind else { continue };
                for k in 0..=m {
                    for i in 0..=n {
                        let (Some(i2), k2) = (i.checked_add_signed(di), k + dk) else { continue };
                        if i2 > n || k2 > m {
                            continue;
                        }
                        let at = |i: usize, k: usize| strand.particles[k * (n + 1) + i];
                        let link = LinkDef::new(at(i, k), at(i2, k2), kind);
                        let link = LinkDef { tear_strain, tear_force, ..link };
                        let thread = match (di, dk) {
                            (1, 0) => rows.wrapping_add(number(k)),
                            (0, 1) => columns.wrapping_add(number(i)),
                            _ => 0,
                        };
                        strand.links.push(world.add_link_of(link, thread)?);
                    }
                }
            }
            Ok(())
        });
        made.map(|()| strand)
    }

    /// Adds a particle at each of these points [m, world], with the other settings of `def`. Use it
    /// for dust.
    ///
    /// # Errors
    /// The first field or point that is out of range; then nothing is added.
    pub fn add_cloud(
        &mut self,
        points: impl IntoIterator<Item = Vec3>,
        def: ParticleDef,
    ) -> Result<Vec<ParticleId>, DefError> {
        let mut strand = Strand::default();
        let made = self.fill(&mut strand, |world, strand| {
            for position in points {
                let particle = ParticleDef { position, ..def };
                strand.particles.push(world.add_particle(particle)?);
            }
            Ok(())
        });
        made.map(|()| strand.particles)
    }

    /// Removes the additions of `make` if it fails.
    fn fill(
        &mut self,
        strand: &mut Strand,
        make: impl FnOnce(&mut Self, &mut Strand) -> Result<(), DefError>,
    ) -> Result<(), DefError> {
        let made = make(self, strand);
        if made.is_err() {
            for link in strand.links.drain(..) {
                self.remove_link(link);
            }
            for particle in strand.particles.drain(..) {
                self.remove_particle(particle);
            }
        }
        made
    }
}
