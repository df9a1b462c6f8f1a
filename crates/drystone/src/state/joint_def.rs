//! What a user says of a joint, and how it is checked.

use super::check::{above_zero, at_least_zero, position};
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
    /// Solve the whole tree of joints that this one belongs to at once, whatever loads it carries; default
    /// false. Without it trees are that carry `joint.tree_ratio` times a link's mass. For robots and
    /// figures whose joints must hold exactly; a tree that closes a loop over bodies that move, or has a rod or
    /// rope in it, is solved joint by joint all the same.
    pub articulated: bool,
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
            articulated: false,
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
