//! Particles, and scripts.

use drystone::particle::{ClothDef, LinkKind, LinkSpring, ParticleDef, RopeDef};
use drystone::{BodyDef, Pose, Vec3, World};

use super::reader::Reader;
use crate::error::SceneError;
use crate::own::document;
use crate::own::place::Place;
use crate::scene::{Load, SceneBody, SceneHold, SceneLink, SceneStrand, Script, StrandDef, Wave};

/// Particles of all ropes and cloths together: a short text can ask for any number of them.
const MOST_PARTICLES: usize = 4_000_000;

impl Reader<'_> {
    pub(super) fn strand(
        &mut self,
        place: &Place,
        strand: &document::Strand,
    ) -> Result<SceneStrand, SceneError> {
        let def = match (&strand.rope, &strand.cloth, &strand.cloud) {
            (Some(rope), None, None) => self.rope(&place.key("rope"), rope)?,
            (None, Some(cloth), None) => self.cloth(&place.key("cloth"), cloth)?,
            (None, None, Some(cloud)) => {
                let at = place.key("cloud").key("particle");
                let particle =
                    self.particle(&at, cloud.particle.as_ref(), ParticleDef::default())?;
                StrandDef::Cloud(cloud.points.iter().map(|p| Vec3::from(*p)).collect(), particle)
            }
            _ => {
                let allowed = "one of rope, cloth, cloud";
                return Err(self.fail(place, "it has no kind, or more than one", allowed));
            }
        };
        let count = particles_of(&def);
        // Each point of a cloud stands in the file.
        let asked = if let StrandDef::Cloud(..) = def { 0 } else { count };
        self.loading.particles = self.loading.particles.saturating_add(asked);
        if self.loading.particles > MOST_PARTICLES {
            let problem = format!("brings all strands to {} particles", self.loading.particles);
            let allowed = format!("up to {MOST_PARTICLES} in ropes and cloths");
            return Err(self.fail(place, problem, &allowed));
        }
        let mut made = SceneStrand::new(
            strand.name.clone().unwrap_or_else(|| format!("#{}", self.scene.strands.len())),
            def,
        );
        let in_strand = |place: Place, number: usize| {
            let allowed = format!("below {count}, as it has so many particles");
            let is_there = number < count;
            if is_there { Ok(()) } else { Err(self.fail(&place, format!("is {number}"), &allowed)) }
        };
        for (i, pin) in strand.pins.iter().enumerate() {
            in_strand(place.nth("pins", i), *pin)?;
        }
        made.pins.clone_from(&strand.pins);
        for (i, hold) in strand.holds.iter().enumerate() {
            in_strand(place.nth("holds", i).key("particle"), hold.particle)?;
            let at = place.nth("holds", i).key("body");
            made.holds.push(SceneHold {
                particle: hold.particle,
                body: self.body_number(&at, &hold.body)?,
                point: hold.point.into(),
            });
        }
        for (i, link) in strand.links.iter().enumerate() {
            in_strand(place.nth("links", i).key("a"), link.a)?;
            in_strand(place.nth("links", i).key("b"), link.b)?;
            let at = place.nth("links", i).key("kind");
            let kind = self
                .link(&at, &link.kind)?
                .ok_or_else(|| self.fail(&at, "is \"none\"", "a link that is there"))?;
            made.links.push(SceneLink {
                a: link.a,
                b: link.b,
                kind,
                length: link.length,
                tear_strain: link.tear_strain,
                tear_force: link.tear_force,
            });
        }
        Ok(made)
    }

    fn rope(&self, place: &Place, rope: &document::Rope) -> Result<StrandDef, SceneError> {
        let mut def = RopeDef::between(rope.from, rope.to, rope.links);
        def.length = rope.length;
        def.mass = rope.mass.unwrap_or(def.mass);
        if let Some(kind) = &rope.kind {
            let at = place.key("kind");
            def.kind = self
                .link(&at, kind)?
                .ok_or_else(|| self.fail(&at, "is \"none\"", "a link that is there"))?;
        }
        def.pinned = rope.pinned.unwrap_or(def.pinned);
        def.particle =
            self.particle(&place.key("particle"), rope.particle.as_ref(), def.particle)?;
        def.tear_strain = rope.tear_strain;
        def.tear_force = rope.tear_force;
        Ok(StrandDef::Rope(def))
    }

    fn cloth(&self, place: &Place, cloth: &document::Cloth) -> Result<StrandDef, SceneError> {
        let mut def = ClothDef::new(cloth.corner, cloth.sides.map(Vec3::from), cloth.squares);
        def.mass = cloth.mass.unwrap_or(def.mass);
        if let Some(kind) = &cloth.stretch {
            let at = place.key("stretch");
            def.stretch = self
                .link(&at, kind)?
                .ok_or_else(|| self.fail(&at, "is \"none\"", "a link that is there"))?;
        }
        if let Some(kind) = &cloth.shear {
            def.shear = self.link(&place.key("shear"), kind)?;
        }
        if let Some(kind) = &cloth.bend {
            def.bend = self.link(&place.key("bend"), kind)?;
        }
        let at = place.key("particle");
        def.particle = self.particle(&at, cloth.particle.as_ref(), def.particle)?;
        def.tear_strain = cloth.tear_strain;
        def.tear_force = cloth.tear_force;
        Ok(StrandDef::Cloth(def))
    }

    /// The kind of a link; `None` if there is none.
    fn link(
        &self,
        place: &Place,
        kind: &document::LinkKind,
    ) -> Result<Option<LinkKind>, SceneError> {
        let spring = match kind {
            document::LinkKind::None => return Ok(None),
            document::LinkKind::Equal => return Ok(Some(LinkKind::Equal)),
            document::LinkKind::AtMost => return Ok(Some(LinkKind::AtMost)),
            document::LinkKind::Spring(spring) => spring,
        };
        let document::LinkSpring { stiffness, damping, hertz, damping_ratio } = *spring;
        let made = match (stiffness, hertz) {
            (Some(stiffness), None) if damping_ratio.is_none() => {
                LinkSpring::Rate { stiffness, damping: damping.unwrap_or(0.0) }
            }
            (None, Some(hertz)) if damping.is_none() => {
                LinkSpring::Frequency { hertz, damping_ratio: damping_ratio.unwrap_or(1.0) }
            }
            _ => {
                let allowed = "stiffness and damping, or hertz and damping_ratio";
                return Err(self.fail(&place.key("spring"), "it is not one law", allowed));
            }
        };
        Ok(Some(LinkKind::Spring(made)))
    }

    fn particle(
        &self,
        place: &Place,
        particle: Option<&document::Particle>,
        mut def: ParticleDef,
    ) -> Result<ParticleDef, SceneError> {
        let Some(said) = particle else { return Ok(def) };
        def.velocity = said.velocity.map_or(def.velocity, Vec3::from);
        def.mass = said.mass.unwrap_or(def.mass);
        def.radius = said.radius.unwrap_or(def.radius);
        def.pinned = said.pinned.unwrap_or(def.pinned);
        def.gravity_scale = said.gravity_scale.unwrap_or(def.gravity_scale);
        def.damping = said.damping.unwrap_or(def.damping);
        if let Some(material) = &said.material {
            def.material = self.material_of(&place.key("material"), material)?;
        }
        if let Some(filter) = &said.filter {
            def.filter = self.filter(&place.key("filter"), filter)?;
        }
        def.validate().map_err(|e| self.refused(place, &e))?;
        Ok(def)
    }

    /// The engine's own check of strands, which it makes where it adds them.
    pub(super) fn check_strands(&self) -> Result<(), SceneError> {
        let mut world = World::default();
        for (i, strand) in self.scene.strands.iter().enumerate() {
            let place = Place::default().nth("strands", i);
            let (key, made) = match &strand.def {
                StrandDef::Rope(def) => ("rope", world.add_rope(*def)),
                StrandDef::Cloth(def) => ("cloth", world.add_cloth(*def)),
                StrandDef::Cloud(points, def) => {
                    let bad = points.iter().position(|point| {
                        ParticleDef { position: *point, ..*def }.validate().is_err()
                    });
                    if let Some(bad) = bad {
                        let at = place.key("cloud").nth("points", bad);
                        let problem = format!("is {:?}", points[bad].to_array());
                        return Err(self.fail(&at, problem, "finite numbers up to 1e7 m"));
                    }
                    continue;
                }
            };
            made.map_err(|e| self.refused(&place.key(key), &e))?;
            world = World::default();
        }
        Ok(())
    }

    pub(super) fn script(
        &mut self,
        place: &Place,
        script: &document::Script,
    ) -> Result<Script, SceneError> {
        match script {
            document::Script::Orbit(orbit) => {
                let at = place.key("orbit");
                let numbers = [orbit.center[0], orbit.center[1], orbit.center[2], orbit.radius];
                let turn = orbit.degrees_per_step;
                if numbers.iter().any(|v| !(v.abs() <= 1.0e7)) || !turn.is_finite() {
                    return Err(self.fail(&at, "is out of range", "numbers up to 1e7 m"));
                }
                let at = at.key("body");
                Ok(Script::Orbit {
                    body: self.body_number(&at, &orbit.body)?,
                    center: orbit.center.into(),
                    radius: orbit.radius,
                    degrees_per_step: orbit.degrees_per_step,
                })
            }
            document::Script::Drop(drop) => {
                let at = place.key("drop");
                if drop.every == 0 {
                    return Err(self.fail(&at.key("every"), "is 0", "at least 1 step"));
                }
                let bodies = self.joining(&at, &drop.bodies)?;
                Ok(Script::Drop { every: drop.every, bodies })
            }
            document::Script::Loads(loads) => {
                let at = place.key("loads");
                let mut made = Vec::with_capacity(loads.loads.len());
                for (i, load) in loads.loads.iter().enumerate() {
                    made.push(self.load(&at.nth("loads", i), load)?);
                }
                Ok(Script::Loads { from: loads.from.unwrap_or(0), loads: made })
            }
            document::Script::Waves(waves) => self.waves(&place.key("waves"), waves),
        }
    }

    fn load(&self, place: &Place, load: &document::Load) -> Result<Load, SceneError> {
        let vector = |v: Option<[f32; 3]>| v.map_or(Vec3::ZERO, Vec3::from);
        let made = Load {
            body: self.body_number(&place.key("body"), &load.body)?,
            force: vector(load.force),
            torque: vector(load.torque),
        };
        for (key, v) in [("force", made.force), ("torque", made.torque)] {
            if !v.is_finite() {
                let problem = format!("is {:?}", v.to_array());
                return Err(self.fail(&place.key(key), problem, "finite numbers"));
            }
        }
        Ok(made)
    }

    fn joining(
        &mut self,
        place: &Place,
        bodies: &[document::Body],
    ) -> Result<Vec<SceneBody>, SceneError> {
        let mut made = Vec::with_capacity(bodies.len());
        for (i, body) in bodies.iter().enumerate() {
            let at = place.nth("bodies", i);
            let body = self.body(&at, body)?;
            let BodyDef { position, rotation, .. } = body.def;
            self.learn(&at, &body.name, Pose::new(position, rotation))?;
            made.push(body);
        }
        Ok(made)
    }

    fn waves(&mut self, place: &Place, waves: &[document::Wave]) -> Result<Script, SceneError> {
        let mut made: Vec<Wave> = Vec::with_capacity(waves.len());
        for (i, wave) in waves.iter().enumerate() {
            let at = place.item(i);
            if made.last().is_some_and(|last| last.step >= wave.step) {
                let problem = format!("is {}", wave.step);
                let allowed = "more than that of the wave before it";
                return Err(self.fail(&at.key("step"), problem, allowed));
            }
            let removed = match &wave.removed {
                None => 0..0,
                Some(removed) => {
                    let at = at.key("removed");
                    let first = self.body_number(&at.key("first"), &removed.first)?;
                    let end = first.checked_add(removed.count);
                    let end = end.filter(|end| *end <= self.seats.len()).ok_or_else(|| {
                        let problem = format!("is {}", removed.count);
                        let allowed = format!("up to {}", self.seats.len() - first);
                        self.fail(&at.key("count"), problem, &allowed)
                    })?;
                    first..end
                }
            };
            let bodies = self.joining(&at, &wave.bodies)?;
            let mut joints = Vec::with_capacity(wave.joints.len());
            for (k, joint) in wave.joints.iter().enumerate() {
                joints.push(self.joint(&at.nth("joints", k), joint)?);
            }
            made.push(Wave { step: wave.step, removed, bodies, joints });
        }
        Ok(Script::Waves(made))
    }
}

/// How many particles a strand has.
fn particles_of(def: &StrandDef) -> usize {
    match def {
        StrandDef::Rope(rope) => rope.links.saturating_add(1),
        StrandDef::Cloth(cloth) => {
            let [a, b] = cloth.squares.map(|n| n.saturating_add(1));
            a.saturating_mul(b)
        }
        StrandDef::Cloud(points, _) => points.len(),
    }
}
