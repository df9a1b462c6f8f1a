//! What a user says of a joint, and how it is checked.

use serde::{Deserialize, Serialize};

use super::check::{above_zero, position, within};
use super::coupling::CouplingDef;
use super::def::DefError;
use super::sixdof::SixDof;
use crate::base::id::BodyId;
use crate::base::limits;
use crate::base::math::Vec3;

/// What a joint does.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
#[expect(clippy::large_enum_variant, reason = "the tables box it; a definition is short-lived")]
pub enum JointKind {
    /// The two anchors stay together; rotation is free.
    Ball,
    /// The distance of the two anchors stays between two lengths.
    Distance {
        /// Least distance [m]; at least 0.
        min: f32,
        /// Greatest distance [m]; at least `min`.
        max: f32,
        /// A spring toward a rest length, between the limits.
        spring: Option<Spring>,
    },
    /// Each of six axes is free, locked, limited, sprung or driven. Its anchors are the origins of its
    /// frames.
    SixDof(SixDof),
    /// A rope over fixed points.
    Pulley(Pulley),
    /// A coordinate of one joint follows one of another; made by [`crate::World::add_coupling`] only.
    Coupling(CouplingDef),
}

/// A rope from the first body over two fixed points to the second: `length_a + ratio · length_b` is no more than
/// its length, where the lengths are those from each anchor to its point.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Pulley {
    /// The points it goes over, that of the first body first [m, world].
    pub points: [Vec3; 2],
    /// Length of the rope [m]; above 0.
    pub length: f32,
    /// How many times the rope goes to the second body, as in a block and tackle; 1e-3 to 1e3.
    pub ratio: f32,
    /// It cannot go slack: a chain of rods. Default false.
    pub is_rigid: bool,
}

impl Pulley {
    /// A rope of this length [m] over these points [m, world].
    #[must_use]
    pub fn rope(points: [impl Into<Vec3>; 2], length: f32) -> Self {
        Self { points: points.map(Into::into), length, ratio: 1.0, is_rigid: false }
    }

    /// How much longer the way is than the rope [m], its anchors being here [m, world].
    pub(crate) fn excess(&self, anchors: [Vec3; 2]) -> f32 {
        let [a, b] = [0, 1].map(|i| (anchors[i] - self.points[i]).length());
        a + self.ratio * b - self.length
    }

    fn validate(&self) -> Result<(), DefError> {
        position("points[0]", self.points[0])?;
        position("points[1]", self.points[1])?;
        within("length", self.length, &limits::LENGTH)?;
        if (1.0e-3..=1.0e3).contains(&self.ratio) {
            return Ok(());
        }
        Err(DefError::new("ratio", self.ratio, "1e-3 to 1e3"))
    }
}

/// A damped spring.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Spring {
    /// Length without force [m]; at least 0.
    pub rest_length: f32,
    /// Undamped frequency of the two bodies on it [Hz]; above 0.
    pub hertz: f32,
    /// Damping ratio; at least 0; 1 is critical.
    pub damping_ratio: f32,
}

/// A joint between two bodies; one of them may be static or kinematic.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct JointDef {
    /// First body.
    pub body_a: BodyId,
    /// Second body.
    pub body_b: BodyId,
    /// Anchor on the first body [m, frame of its origin].
    pub anchor_a: Vec3,
    /// Anchor on the second body [m, frame of its origin].
    pub anchor_b: Vec3,
    /// What it does.
    pub kind: JointKind,
    /// Whether the two bodies collide with each other; default false.
    pub collide_connected: bool,
    /// What it can bear; `None`, the default: anything.
    pub strength: Option<JointStrength>,
    /// Solve the whole tree of joints that this one belongs to at once, whatever loads it carries; default
    /// false. Without it trees are that carry `joint.tree_ratio` times a link's mass. For robots and
    /// figures whose joints must hold exactly; a tree that closes a loop over bodies that move, or has a rod or
    /// rope in it, is solved joint by joint all the same.
    pub articulated: bool,
    /// Any number of the user's.
    pub user_data: u64,
}

/// What a joint can bear. It breaks at the end of a step in which it had to bear more: it is removed, and
/// [`crate::Events::joint_break`] tells of it. Force and torque are the means of each substep of the
/// step, in whatever parts an island takes it.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct JointStrength {
    /// Greatest force [N]; above 0; may be infinite, as by default.
    pub force: f32,
    /// Greatest torque of a joint of six axes [N m]; above 0; may be infinite, as by default.
    pub torque: f32,
    /// Greatest impulse in a step [N s]: the force times time, summed over the step; above 0; may be infinite, as by
    /// default. A blow passes it in whichever substep it comes.
    pub impulse: f32,
    /// Loads below these limits wear the joint out; default `None`: they do not.
    pub fatigue: Option<Fatigue>,
}

/// How loads below its limits wear a joint out: damage grows by (load / limit)^`exponent` × time / `life` while that
/// ratio, the largest of force and torque, is at least `endurance`, and the joint breaks when it reaches 1.
/// Damage adds up in whatever order loads come [Miner45], at a rate that is a power of the load
/// [Basquin10]. The impulse has no part in it.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Fatigue {
    /// How long a load as large as the limit is borne [s]; above 0.
    pub life: f32,
    /// Power of the load, 1 to 32; metals have 3 to 10.
    pub exponent: u32,
    /// Part of the limits below which a load does no harm; 0 to 1.
    pub endurance: f32,
}

impl Default for JointStrength {
    /// Bears anything.
    fn default() -> Self {
        let force = f32::INFINITY;
        Self { force, torque: force, impulse: force, fatigue: None }
    }
}

impl JointStrength {
    pub(crate) fn validate(&self) -> Result<(), DefError> {
        let limits = [("force", self.force), ("torque", self.torque), ("impulse", self.impulse)];
        for (name, value) in limits {
            if value != f32::INFINITY {
                above_zero(name, value)?;
            }
        }
        let Some(fatigue) = self.fatigue else { return Ok(()) };
        fatigue.validate().map_err(|e| e.within("fatigue"))
    }
}

impl Fatigue {
    fn validate(&self) -> Result<(), DefError> {
        above_zero("life", self.life)?;
        if !(1..=32).contains(&self.exponent) {
            return Err(DefError::new("exponent", self.exponent, "1 to 32"));
        }
        if !(0.0..=1.0).contains(&self.endurance) {
            return Err(DefError::new("endurance", self.endurance, "0 to 1"));
        }
        Ok(())
    }

    /// Damage that a load of this part of the limit does in a time [s].
    pub(crate) fn damage(&self, part: f32, time: f32) -> f32 {
        if !(part >= self.endurance) {
            return 0.0;
        }
        (0..self.exponent).fold(time / self.life, |damage, _| damage * part)
    }
}

impl JointKind {
    /// Checks every field; whether the joints that a coupling names exist is checked by the world.
    pub(crate) fn validate(&self) -> Result<(), DefError> {
        match self {
            Self::Ball => Ok(()),
            Self::Pulley(pulley) => pulley.validate().map_err(|e| e.within("pulley")),
            Self::SixDof(six) => six.validate(),
            Self::Coupling(coupling) => coupling.validate(),
            Self::Distance { min, max, spring } => {
                within("min", *min, &limits::DISTANCE)?;
                within("max", *max, &limits::DISTANCE)?;
                if max < min {
                    return Err(DefError::new("max", max, "at least min"));
                }
                let Some(s) = spring else { return Ok(()) };
                within("spring.rest_length", s.rest_length, &limits::DISTANCE)?;
                above_zero("spring.hertz", s.hertz)?;
                within("spring.hertz", s.hertz, &limits::FREQUENCY)?;
                within("spring.damping_ratio", s.damping_ratio, &limits::DAMPING_RATIO)
            }
        }
    }
}

impl JointDef {
    /// A ball joint with these anchors [m, each in the frame of its body's origin].
    #[must_use]
    pub fn ball(
        body_a: BodyId,
        anchor_a: impl Into<Vec3>,
        body_b: BodyId,
        anchor_b: impl Into<Vec3>,
    ) -> Self {
        Self {
            body_a,
            body_b,
            anchor_a: anchor_a.into(),
            anchor_b: anchor_b.into(),
            kind: JointKind::Ball,
            collide_connected: false,
            strength: None,
            articulated: false,
            user_data: 0,
        }
    }

    /// Solved at once with the tree of joints that it belongs to: see [`Self::articulated`].
    #[must_use]
    pub fn with_articulated(self, articulated: bool) -> Self {
        Self { articulated, ..self }
    }

    /// Breaks where it would have to bear more than this force [N] or torque [N m].
    #[must_use]
    pub fn with_strength(self, force: f32, torque: f32) -> Self {
        let strength = JointStrength { force, torque, ..self.strength.unwrap_or_default() };
        Self { strength: Some(strength), ..self }
    }

    /// Breaks under more than this impulse in a step [N s].
    #[must_use]
    pub fn with_impulse_limit(self, impulse: f32) -> Self {
        let strength = JointStrength { impulse, ..self.strength.unwrap_or_default() };
        Self { strength: Some(strength), ..self }
    }

    /// Wears out under loads below its limits.
    #[must_use]
    pub fn with_fatigue(self, fatigue: Fatigue) -> Self {
        let fatigue = Some(fatigue);
        let strength = JointStrength { fatigue, ..self.strength.unwrap_or_default() };
        Self { strength: Some(strength), ..self }
    }

    /// A rod of fixed length [m] between two anchors [m, each in the frame of its body's origin].
    #[must_use]
    pub fn rod(
        body_a: BodyId,
        anchor_a: impl Into<Vec3>,
        body_b: BodyId,
        anchor_b: impl Into<Vec3>,
        length: f32,
    ) -> Self {
        let kind = JointKind::Distance { min: length, max: length, spring: None };
        Self { kind, ..Self::ball(body_a, anchor_a, body_b, anchor_b) }
    }

    /// A rope between these anchors [m, each in the frame of its body's origin], over fixed points.
    #[must_use]
    pub fn pulley(
        body_a: BodyId,
        anchor_a: impl Into<Vec3>,
        body_b: BodyId,
        anchor_b: impl Into<Vec3>,
        pulley: Pulley,
    ) -> Self {
        let kind = JointKind::Pulley(pulley);
        let ball = Self::ball(body_a, anchor_a, body_b, anchor_b);
        Self { kind, collide_connected: true, ..ball }
    }

    /// A joint of six axes, whose frames are at these anchors [m, each in the frame of its body's origin].
    #[must_use]
    pub fn six_dof(
        body_a: BodyId,
        anchor_a: impl Into<Vec3>,
        body_b: BodyId,
        anchor_b: impl Into<Vec3>,
        axes: SixDof,
    ) -> Self {
        Self { kind: JointKind::SixDof(axes), ..Self::ball(body_a, anchor_a, body_b, anchor_b) }
    }

    /// Checks every field; whether the bodies exist is checked by the world.
    ///
    /// # Errors
    /// The first field that is out of range.
    pub fn validate(&self) -> Result<(), DefError> {
        position("anchor_a", self.anchor_a)?;
        position("anchor_b", self.anchor_b)?;
        if self.body_a == self.body_b {
            return Err(DefError::new("body_b", "the same as body_a", "another body"));
        }
        if let JointKind::Coupling(_) = self.kind {
            return Err(DefError::new("kind", "a coupling", "what World::add_coupling is given"));
        }
        self.kind.validate()?;
        if let Some(strength) = self.strength {
            strength.validate().map_err(|e| e.within("strength"))?;
        }
        Ok(())
    }
}
