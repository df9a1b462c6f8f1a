//! Particles: loose, as ropes, cloths and clouds; links that tear; attachments to bodies.

use drystone::particle::{ClothDef, LinkKind, LinkSpring, ParticleDef, RopeDef};
use drystone::{Vec3, vec3};

use super::draw::Draw;
use crate::op::{LinkPlan, Op, Style};

impl Draw {
    /// Adds some particles.
    pub(super) fn particles(&mut self) {
        for _ in 0..self.rng.from_to(1, 2) {
            match self.rng.below(4) {
                0 => self.rope(),
                1 => self.cloth(),
                2 => self.cloud(),
                _ => self.loose(),
            }
        }
        for _ in 0..self.rng.below(3) {
            self.attach();
        }
    }

    pub(super) fn particle_def(&mut self) -> ParticleDef {
        let mut def = ParticleDef { radius: 0.02 * self.size, ..ParticleDef::default() };
        def.radius = def.radius.max(0.001);
        def.material = self.material();
        def.filter = self.filter();
        def.position = vec3(0.0, 3.0 * self.size, 0.0) + self.offset(2.0);
        if self.rng.chance(0.3) {
            def.velocity = self.speed();
        }
        if self.rng.chance(0.4) {
            let reach = if self.style == Style::Torture { 1.0e5 } else { 30.0 };
            def.mass = 0.1 * self.rng.scale(1.0 / reach, reach);
        }
        if self.rng.chance(0.1) {
            def.gravity_scale = self.rng.pick(&[0.0, -0.5, 2.0]);
        }
        if self.rng.chance(0.2) {
            def.damping = self.rng.scale(0.01, 10.0);
        }
        def
    }

    fn link_kind(&mut self) -> LinkKind {
        match self.rng.below(4) {
            0 => LinkKind::Equal,
            1 => LinkKind::AtMost,
            2 => LinkKind::Spring(LinkSpring::Frequency {
                hertz: self.rng.scale(0.5, 100.0),
                damping_ratio: self.rng.pick(&[0.0, 0.5, 1.0]),
            }),
            _ => LinkKind::Spring(LinkSpring::Rate {
                stiffness: self.rng.scale(1.0, 1.0e5),
                damping: self.rng.scale(0.01, 100.0),
            }),
        }
    }

    fn tears(&mut self) -> [Option<f32>; 2] {
        let strain = if self.rng.chance(0.15) { Some(self.rng.scale(0.01, 2.0)) } else { None };
        let force = if self.rng.chance(0.15) { Some(self.rng.scale(0.1, 1000.0)) } else { None };
        [strain, force]
    }

    fn rope(&mut self) {
        let links = self.rng.from_to(1, 12);
        let from = vec3(0.0, 4.0 * self.size, 0.0) + self.offset(2.0);
        let to = from + self.offset(4.0);
        let [tear_strain, tear_force] = self.tears();
        let mut def = RopeDef {
            kind: self.link_kind(),
            pinned: [self.rng.chance(0.5), self.rng.chance(0.2)],
            particle: self.particle_def(),
            tear_strain,
            tear_force,
            ..RopeDef::between(from, to, links)
        };
        if self.rng.chance(0.3) {
            def.mass = self.rng.scale(0.01, 100.0);
        }
        if self.rng.chance(0.2) {
            def.length = Some((to - from).length() * self.rng.between(0.8, 1.5));
        }
        let (first, link) = (self.labels(links + 1), self.labels(links));
        self.know(first, links + 1, link, links);
        self.ops.push(Op::AddRope(first, link, Box::new(def)));
    }

    fn cloth(&mut self) {
        let squares = [self.rng.from_to(1, 5), self.rng.from_to(1, 5)];
        let corner = vec3(0.0, 4.0 * self.size, 0.0) + self.offset(2.0);
        let side = 2.0 * self.size;
        let sides = [Vec3::X * side, self.rng.pick(&[Vec3::Z, Vec3::Y]) * side];
        let [tear_strain, tear_force] = self.tears();
        let mut def = ClothDef { tear_strain, tear_force, ..ClothDef::new(corner, sides, squares) };
        def.particle = ParticleDef { position: Vec3::ZERO, ..self.particle_def() };
        if self.rng.chance(0.3) {
            def.stretch = self.link_kind();
            def.shear = self.rng.chance(0.5).then(|| self.link_kind());
            def.bend = self.rng.chance(0.5).then(|| self.link_kind());
        }
        let count = (squares[0] + 1) * (squares[1] + 1);
        // The maximum number of links: along two sides, across both diagonals, and over two cells
        // in both directions.
        let (first, link) = (self.labels(count), self.labels(6 * count));
        self.know(first, count, link, count);
        self.ops.push(Op::AddCloth(first, link, Box::new(def)));
    }

    fn cloud(&mut self) {
        let count = self.rng.from_to(2, 30);
        let def = self.particle_def();
        let points = (0..count).map(|_| def.position + self.offset(2.0)).collect();
        let first = self.labels(count);
        self.know(first, count, 0, 0);
        self.ops.push(Op::AddCloud(first, points, Box::new(def)));
    }

    fn loose(&mut self) {
        for _ in 0..self.rng.from_to(1, 4) {
            let mut def = self.particle_def();
            def.pinned = self.rng.chance(0.2);
            let label = self.label();
            self.know(label, 1, 0, 0);
            self.ops.push(Op::AddParticle(label, Box::new(def)));
        }
        for _ in 0..self.rng.below(3) {
            self.free_link();
        }
    }

    pub(super) fn free_link(&mut self) {
        if self.particles.len() < 2 {
            return;
        }
        let particles = self.particles.clone();
        let ends = [self.rng.pick(&particles), self.rng.pick(&particles)];
        let [tear_strain, tear_force] = self.tears();
        let length = if self.rng.chance(0.2) { Some(self.size) } else { None };
        let (label, kind) = (self.label(), self.link_kind());
        self.links.push(label);
        let plan = LinkPlan { label, ends, kind, length, tear_strain, tear_force };
        self.ops.push(Op::AddLink(plan));
    }

    pub(super) fn attach(&mut self) {
        if self.particles.is_empty() {
            return;
        }
        let particles = self.particles.clone();
        let particle = self.rng.pick(&particles);
        let Some(body) = self.any_body() else { return };
        let point = self.rng.direction() * body.radius;
        self.ops.push(Op::Attach(particle, body.label, point));
    }

    fn know(&mut self, first: u32, count: usize, link: u32, links: usize) {
        let number = |n: usize| u32::try_from(n).unwrap_or(0);
        self.particles.extend(first..first + number(count));
        self.links.extend(link..link + number(links));
    }
}
