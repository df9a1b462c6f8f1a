//! The objects of a program so far, and random numbers in its style.

use drystone::events::{ContactReports, Senses};
use drystone::{Axis, Filter, Material, Quat, Vec3};

use crate::op::{Label, Op, PIECES, Style};
use crate::rng::Rng;

/// A body of the program.
#[derive(Clone, Debug)]
pub(super) struct KnownBody {
    pub(super) label: Label,
    pub(super) position: Vec3,
    pub(super) rotation: Quat,
    /// Radius of a ball around the body [m].
    pub(super) radius: f32,
    pub(super) shapes: Vec<Label>,
}

/// A joint of the program.
#[derive(Clone, Debug)]
pub(super) struct KnownJoint {
    pub(super) label: Label,
    /// Axes that are not locked, for a six-axis joint without a cone.
    pub(super) free_axes: Vec<Axis>,
    pub(super) is_six: bool,
}

/// A program under construction.
#[derive(Clone, Debug)]
pub(super) struct Draw {
    pub(super) rng: Rng,
    pub(super) style: Style,
    pub(super) ops: Vec<Op>,
    pub(super) bodies: Vec<KnownBody>,
    pub(super) joints: Vec<KnownJoint>,
    pub(super) particles: Vec<Label>,
    pub(super) links: Vec<Label>,
    /// Typical size of objects in this world [m].
    pub(super) size: f32,
    next: Label,
}

impl Draw {
    pub(super) fn new(mut rng: Rng, style: Style) -> Self {
        let size = match style {
            Style::Ordinary | Style::Edge => rng.scale(0.1, 2.5),
            Style::Wide | Style::Torture => 1.0,
        };
        Self {
            rng,
            style,
            ops: Vec::new(),
            bodies: Vec::new(),
            joints: Vec::new(),
            particles: Vec::new(),
            links: Vec::new(),
            size,
            next: 0,
        }
    }

    /// Reserves `count` labels and returns the first.
    pub(super) fn labels(&mut self, count: usize) -> Label {
        let first = self.next;
        self.next += u32::try_from(count).unwrap_or(1);
        first
    }

    pub(super) fn label(&mut self) -> Label {
        self.labels(1)
    }

    /// A random half length of a shape [m].
    pub(super) fn length(&mut self) -> f32 {
        match self.style {
            Style::Ordinary | Style::Edge => self.size * self.rng.between(0.5, 2.0),
            Style::Wide => self.rng.scale(0.01, 50.0),
            Style::Torture => self.rng.scale(0.02, 5.0),
        }
    }

    /// A random offset of about the size of the world's objects [m].
    pub(super) fn offset(&mut self, factor: f32) -> Vec3 {
        let half = factor * self.size;
        self.rng.vector(half)
    }

    /// A random velocity [m/s].
    pub(super) fn speed(&mut self) -> Vec3 {
        let most = match self.style {
            Style::Ordinary | Style::Edge => 5.0,
            Style::Wide => 20.0,
            Style::Torture => 100.0,
        };
        let most = self.rng.between(0.0, most);
        self.rng.vector(most)
    }

    /// A random angular velocity [rad/s].
    pub(super) fn spin(&mut self) -> Vec3 {
        let most = if self.style == Style::Torture { 60.0 } else { 8.0 };
        let most = self.rng.between(0.0, most);
        self.rng.vector(most)
    }

    /// A random force or impulse in proportion to typical masses [N or N s]. In ordinary worlds an
    /// impulse accelerates most objects by up to 1 m/s, and the lightest by 30 m/s. Other worlds
    /// get up to thirty times as much.
    pub(super) fn push(&mut self) -> Vec3 {
        let weight = 3000.0 * self.size * self.size * self.size;
        let part = if self.style == Style::Ordinary { 0.03 } else { 1.0 };
        let most = part * self.rng.scale(0.01, 10.0) * weight;
        self.rng.vector(most)
    }

    pub(super) fn material(&mut self) -> Material {
        let mut material = Material::default();
        if self.rng.chance(0.5) {
            return material;
        }
        material.friction = self.rng.pick(&[0.0, 0.1, 0.3, 0.6, 1.0, 2.0]);
        if self.rng.chance(0.2) {
            material.kinetic_friction = Some(0.8 * material.friction);
        }
        if self.rng.chance(0.4) {
            material.restitution = self.rng.pick(&[0.0, 0.3, 0.5, 0.8, 1.0]);
        }
        if self.rng.chance(0.2) {
            material.rolling_resistance = self.rng.between(0.0, 0.2);
        }
        if self.rng.chance(0.2) {
            material.spinning_resistance = self.rng.between(0.0, 0.2);
        }
        let rules = [
            drystone::contact::Combine::GeometricMean,
            drystone::contact::Combine::Multiply,
            drystone::contact::Combine::Maximum,
            drystone::contact::Combine::Minimum,
            drystone::contact::Combine::Average,
        ];
        material.friction_combine = self.rng.pick(&rules);
        material.restitution_combine = self.rng.pick(&rules);
        material
    }

    pub(super) fn reports(&mut self) -> ContactReports {
        let hit_speed = self.rng.chance(0.5).then(|| self.rng.scale(0.01, 10.0));
        let [touches, hits, forces] = [0.8, 0.8, 0.7].map(|share| self.rng.chance(share));
        ContactReports { touches, hits, hit_speed, forces }
    }

    pub(super) fn senses(&mut self) -> Senses {
        let [statics, sensors] = [0, 1].map(|_| self.rng.chance(0.7));
        Senses { statics, sensors }
    }

    pub(super) fn filter(&mut self) -> Filter {
        if self.rng.chance(0.85) {
            return Filter::default();
        }
        let layers = self.rng.below(4) as u64;
        let mask = if self.rng.chance(0.5) { u64::MAX } else { self.rng.below(8) as u64 };
        let exclude = if self.rng.chance(0.2) { self.rng.below(4) as u64 } else { 0 };
        Filter { layers, mask, exclude }
    }

    /// The label of this body, or of a piece of a broken body.
    pub(super) fn any_body_or_piece(&mut self, of: &KnownBody) -> Label {
        if self.rng.chance(0.05) { PIECES + self.rng.below_u32(4) } else { of.label }
    }

    /// A random body, possibly removed; `None` if there never was any.
    pub(super) fn any_body(&mut self) -> Option<KnownBody> {
        let at = self.rng.below(self.bodies.len());
        self.bodies.get(at).cloned()
    }
}
