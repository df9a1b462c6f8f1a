//! What a user says of a joint, and how it is checked.

use super::check::{above_zero, at_least_zero, position};
use super::coupling::CouplingDef;
use super::def::DefError;
use super::sixdof::SixDof;
use crate::base::id::BodyId;
use crate::base::math::Vec3;

/// What a joint does.
#[derive(Clone, Copy, Debug, PartialEq)]
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
#[derive(Clone, Copy, Debug, PartialEq)]
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
        above_zero("length", self.length)?;
        if (1.0e-3..=1.0e3).contains(&self.ratio) {
            return Ok(());
        }
        Err(DefError::new("ratio", self.ratio, "1e-3 to 1e3"))
    }
}

/// A damped spring.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Spring {
    /// Length without force [m]; at least 0.
    pub rest_length: f32,
    /// Undamped frequency of the two bodies on it [Hz]; above 0.
    pub hertz: f32,
    /// Damping ratio; at least 0; 1 is critical.
    pub damping_ratio: f32,
}

/// A joint between two bodies; one of them may be static or kinematic.
#[derive(Clone, Copy, Debug, PartialEq)]
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
}

/// What a joint can bear. It breaks at the end of a step in which it had to hold more in some substep of a joint of six
/// axes, or in the last one of another kind: it is removed, and [`crate::Events::joint_break`] tells of it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct JointStrength {
    /// Greatest force [N]; above 0; may be infinite.
    pub force: f32,
    /// Greatest torque of a joint of six axes [N m]; above 0; may be infinite.
    pub torque: f32,
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
        }
    }

    /// Breaks where it would have to bear more than this force [N] or torque [N m].
    #[must_use]
    pub fn with_strength(self, force: f32, torque: f32) -> Self {
        Self { strength: Some(JointStrength { force, torque }), ..self }
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
        if let JointKind::Pulley(pulley) = self.kind {
            pulley.validate().map_err(|e| e.within("pulley"))?;
        }
        if let JointKind::SixDof(six) = self.kind {
            six.validate()?;
        }
        if let Some(JointStrength { force, torque }) = self.strength {
            for (name, value) in [("strength.force", force), ("strength.torque", torque)] {
                if value != f32::INFINITY {
                    above_zero(name, value)?;
                }
            }
        }
        if let JointKind::Distance { min, max, spring } = self.kind {
            at_least_zero("min", min)?;
            at_least_zero("max", max)?;
            if max < min {
                return Err(DefError::new("max", max, "at least min"));
            }
            if let Some(s) = spring {
                at_least_zero("spring.rest_length", s.rest_length)?;
                above_zero("spring.hertz", s.hertz)?;
                at_least_zero("spring.damping_ratio", s.damping_ratio)?;
            }
        }
        Ok(())
    }
}
