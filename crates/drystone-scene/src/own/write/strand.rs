//! Particles, and scripts.

use drystone::Vec3;
use drystone::particle::{ClothDef, LinkKind, LinkSpring, ParticleDef, RopeDef};

use super::names::Names;
use super::said::{other, refuse, unless, unless_vec};
use super::shape::filter;
use crate::error::SceneError;
use crate::own::document::{
    Cloth, Cloud, Drop, Hold, Link, LinkKind as KindOf, LinkSpring as SpringOf, Load, Loads, Orbit,
    Particle, Removed, Rope, Script as ScriptOf, Strand, Wave,
};
use crate::scene::{SceneStrand, Script, StrandDef};

impl Names {
    pub(super) fn strand(&self, strand: &SceneStrand) -> Result<Strand, SceneError> {
        let mut made = Strand {
            name: Some(strand.name.clone()),
            pins: strand.pins.clone(),
            ..Strand::default()
        };
        match &strand.def {
            StrandDef::Rope(def) => {
                let default = RopeDef::between(def.from, def.to, def.links);
                made.rope = Some(Rope {
                    from: def.from.to_array(),
                    to: def.to.to_array(),
                    links: def.links,
                    length: def.length,
                    mass: unless(def.mass, default.mass),
                    kind: other(def.kind, &default.kind).map(kind).transpose()?,
                    pinned: other(def.pinned, &default.pinned),
                    particle: self.particle(&def.particle, &default.particle),
                    tear_strain: def.tear_strain,
                    tear_force: def.tear_force,
                });
            }
            StrandDef::Cloth(def) => {
                let default = ClothDef::new(def.corner, def.sides, def.squares);
                let or_none = |link: Option<LinkKind>| link.map_or(Ok(KindOf::None), kind);
                made.cloth = Some(Cloth {
                    corner: def.corner.to_array(),
                    sides: def.sides.map(Vec3::to_array),
                    squares: def.squares,
                    mass: unless(def.mass, default.mass),
                    stretch: other(def.stretch, &default.stretch).map(kind).transpose()?,
                    shear: other(def.shear, &default.shear).map(or_none).transpose()?,
                    bend: other(def.bend, &default.bend).map(or_none).transpose()?,
                    particle: self.particle(&def.particle, &default.particle),
                    tear_strain: def.tear_strain,
                    tear_force: def.tear_force,
                });
            }
            StrandDef::Cloud(points, def) => {
                made.cloud = Some(Cloud {
                    points: points.iter().map(|p| p.to_array()).collect(),
                    particle: self.particle(def, &ParticleDef::default()),
                });
            }
        }
        made.holds.extend(strand.holds.iter().map(|hold| Hold {
            particle: hold.particle,
            body: self.body(hold.body),
            point: hold.point.to_array(),
        }));
        for link in &strand.links {
            made.links.push(Link {
                a: link.a,
                b: link.b,
                kind: kind(link.kind)?,
                length: link.length,
                tear_strain: link.tear_strain,
                tear_force: link.tear_force,
            });
        }
        Ok(made)
    }

    /// The properties of a particle that differ from its strand's; its place is the strand's.
    fn particle(&self, def: &ParticleDef, default: &ParticleDef) -> Option<Particle> {
        let at = ParticleDef { position: default.position, ..*def };
        (at != *default).then(|| Particle {
            velocity: unless_vec(def.velocity, default.velocity),
            mass: unless(def.mass, default.mass),
            radius: unless(def.radius, default.radius),
            pinned: other(def.pinned, &default.pinned),
            gravity_scale: unless(def.gravity_scale, default.gravity_scale),
            damping: unless(def.damping, default.damping),
            material: self.material(&def.material),
            filter: filter(def.filter),
        })
    }

    pub(super) fn script(&self, script: &Script) -> Result<Option<ScriptOf>, SceneError> {
        Ok(Some(match script {
            Script::None => return Ok(None),
            Script::Orbit { body, center, radius, degrees_per_step } => ScriptOf::Orbit(Orbit {
                body: self.body(*body),
                center: center.to_array(),
                radius: *radius,
                degrees_per_step: *degrees_per_step,
            }),
            Script::Drop { every, bodies } => {
                let mut made = Vec::with_capacity(bodies.len());
                for body in bodies {
                    made.push(self.write_body(body)?);
                }
                ScriptOf::Drop(Drop { every: (*every).max(1), bodies: made })
            }
            Script::Loads { from, loads } => ScriptOf::Loads(Loads {
                from: other(*from, &0),
                loads: loads
                    .iter()
                    .map(|load| Load {
                        body: self.body(load.body),
                        force: unless_vec(load.force, Vec3::ZERO),
                        torque: unless_vec(load.torque, Vec3::ZERO),
                    })
                    .collect(),
            }),
            Script::Waves(waves) => {
                let mut made = Vec::with_capacity(waves.len());
                for wave in waves {
                    let count = wave.removed.len();
                    let first = self.body(wave.removed.start);
                    let mut next = Wave {
                        step: wave.step,
                        removed: (count > 0).then_some(Removed { first, count }),
                        ..Wave::default()
                    };
                    for body in &wave.bodies {
                        next.bodies.push(self.write_body(body)?);
                    }
                    for joint in &wave.joints {
                        next.joints.push(self.joint(joint)?);
                    }
                    made.push(next);
                }
                ScriptOf::Waves(made)
            }
            Script::Film(_) => {
                let problem = "it plays the animations of a glTF file";
                return Err(refuse("script", problem, "orbit, drop, loads or waves"));
            }
        }))
    }
}

fn kind(kind: LinkKind) -> Result<KindOf, SceneError> {
    Ok(match kind {
        LinkKind::Equal => KindOf::Equal,
        LinkKind::AtMost => KindOf::AtMost,
        LinkKind::Spring(LinkSpring::Rate { stiffness, damping }) => KindOf::Spring(SpringOf {
            stiffness: Some(stiffness),
            damping: Some(damping),
            ..SpringOf::default()
        }),
        LinkKind::Spring(LinkSpring::Frequency { hertz, damping_ratio }) => {
            KindOf::Spring(SpringOf {
                hertz: Some(hertz),
                damping_ratio: Some(damping_ratio),
                ..SpringOf::default()
            })
        }
        other => return Err(refuse("strands", format!("{other:?} has no name in it"), "")),
    })
}
