//! Joints of `KHR_physics_rigid_bodies`: limits and drives to joints of six axes.
//!
//! A limit of one axis becomes a limit of one axis here. A limit of several axes bounds a distance
//! or an angle of all of them together. With equal bounds it locks each. Three motions become a
//! distance joint of their own. Two turns become a cone, about an axis that becomes our x. The
//! others are bounded axis by axis, with a note.

use drystone::joint::{JointAxis, JointCone, JointDrive, JointMotion, JointSpring, SixDof};
use drystone::{JointKind, Quat};

use crate::error::SceneError;
use crate::read::json::At;

/// A joint of the file, in the frames of its two nodes, each turned by this.
pub(crate) struct Described {
    pub(crate) turn: Quat,
    pub(crate) kinds: Vec<JointKind>,
}

/// Describes an entry of the list of joints; `notes` gets a line for each property that is
/// approximated.
pub(crate) fn describe(at: &At<'_>, notes: &mut Vec<String>) -> Result<Described, SceneError> {
    let at = at.clone().object()?;
    let free = [JointAxis::FREE; 3];
    let mut reader = Reader {
        axes: SixDof { linear: free, angular: free, ..SixDof::FIXED },
        swing: None,
        range: None,
        notes,
    };
    for limit in at.list("limits")? {
        reader.limit(&limit.object()?)?;
    }
    for drive in at.list("drives")? {
        reader.drive(&drive.object()?)?;
    }
    Ok(reader.finish())
}

/// A limit of two turns together: the axis that they leave, its greatest angle, its spring.
struct Swing {
    about: usize,
    max: f32,
    spring: Option<JointSpring>,
}

struct Reader<'a> {
    axes: SixDof,
    swing: Option<Swing>,
    /// Bounds of the distance of the two frames.
    range: Option<(f32, f32)>,
    notes: &'a mut Vec<String>,
}

impl Reader<'_> {
    fn note(&mut self, at: &At<'_>, what: &str) {
        self.notes.push(format!("{}: {what}", at.place()));
    }

    fn limit(&mut self, at: &At<'_>) -> Result<(), SceneError> {
        let (motions, turns) = (at.get("linearAxes"), at.get("angularAxes"));
        let (list, is_turn) = match (motions, turns) {
            (Some(list), None) => (list, false),
            (None, Some(list)) => (list, true),
            _ => return Err(at.error("its axes are not clear", "linearAxes or angularAxes")),
        };
        let mut which = Vec::new();
        for item in list.items()? {
            let axis = item.index(3, "axes")?;
            if which.contains(&axis) {
                return Err(item.error(format!("axis {axis} is there twice"), "each axis once"));
            }
            which.push(axis);
        }
        if which.is_empty() {
            return Err(list.error("is empty", "1 to 3 axes"));
        }
        let bound = |key: &str, without: f32| at.get(key).map_or(Ok(without), |v| v.f32());
        let (min, max) = (bound("min", f32::NEG_INFINITY)?, bound("max", f32::INFINITY)?);
        if max < min {
            return Err(at.error(format!("max {max} is below min {min}"), "max of at least min"));
        }
        let damping = at.get("damping").map(|d| d.at_least_zero()).transpose()?;
        let spring = match at.get("stiffness") {
            Some(k) => Some(JointSpring::new(k.at_least_zero()?, damping.unwrap_or(0.0))),
            None => None,
        };
        if spring.is_none() && damping.is_some_and(|d| d > 0.0) {
            self.note(at, "damping without stiffness has no effect: the limit is hard");
        }
        self.apply(at, &which, is_turn, (min, max), spring)
    }

    fn apply(
        &mut self,
        at: &At<'_>,
        which: &[usize],
        is_turn: bool,
        (min, max): (f32, f32),
        spring: Option<JointSpring>,
    ) -> Result<(), SceneError> {
        let limited = JointMotion::Limited { min, max, spring };
        let locked = if spring.is_none() { JointMotion::Locked } else { limited };
        if let [one] = which {
            let motion = if min == 0.0 && max == 0.0 { locked } else { limited };
            return self.bound(at, is_turn, *one, motion);
        }
        // Lengths and angles of several axes have no sign.
        if max < 0.0 {
            let allowed = "a max of at least 0 for several axes together";
            return Err(at.error(format!("max is {max}"), allowed));
        }
        if max == 0.0 {
            let motion = if spring.is_none() {
                locked
            } else {
                JointMotion::Limited { min: 0.0, max, spring }
            };
            return which.iter().try_for_each(|i| self.bound(at, is_turn, *i, motion));
        }
        match (is_turn, which.len()) {
            (false, 3) if spring.is_none() && self.range.is_none() => {
                self.range = Some((min.max(0.0), max));
                return Ok(());
            }
            (true, 2) if self.swing.is_none() => {
                if min > 0.0 {
                    self.note(at, "a cone's min is not kept, only its max");
                }
                let about = 3 - which[0] - which[1];
                self.swing = Some(Swing { about, max, spring });
                return Ok(());
            }
            _ => {}
        }
        self.note(at, "the limit of several axes together is taken for each axis by itself");
        let each = JointMotion::Limited { min: -max, max, spring };
        which.iter().try_for_each(|i| self.bound(at, is_turn, *i, each))
    }

    /// Bounds an axis, within what other limits have left.
    fn bound(
        &mut self,
        at: &At<'_>,
        is_turn: bool,
        i: usize,
        motion: JointMotion,
    ) -> Result<(), SceneError> {
        let axis = if is_turn { &mut self.axes.angular[i] } else { &mut self.axes.linear[i] };
        axis.motion = match (axis.motion, motion) {
            (JointMotion::Free, new) => new,
            (JointMotion::Locked, _) | (_, JointMotion::Locked) => JointMotion::Locked,
            (
                JointMotion::Limited { min: a, max: b, spring: None },
                JointMotion::Limited { min, max, spring: None },
            ) => {
                let (min, max) = (a.max(min), b.min(max));
                if max < min {
                    let problem = "no place is within this limit and another of the same axis";
                    return Err(at.error(problem, "limits that leave room"));
                }
                JointMotion::Limited { min, max, spring: None }
            }
            (old, new) => {
                let is_hard =
                    |m: &JointMotion| matches!(m, JointMotion::Limited { spring: None, .. });
                let kept = if is_hard(&old) { old } else { new };
                self.note(at, "an axis with several limits of which one is soft keeps one");
                let axis =
                    if is_turn { &mut self.axes.angular[i] } else { &mut self.axes.linear[i] };
                axis.motion = kept;
                return Ok(());
            }
        };
        Ok(())
    }

    fn drive(&mut self, at: &At<'_>) -> Result<(), SceneError> {
        let kind = at.need("type")?;
        let is_turn = match kind.text()? {
            "linear" => false,
            "angular" => true,
            _ => return Err(kind.wrong("\"linear\" or \"angular\"")),
        };
        let per_mass = match at.get("mode") {
            None => false,
            Some(mode) => match mode.text()? {
                "force" => false,
                "acceleration" => true,
                _ => return Err(mode.wrong("\"force\" or \"acceleration\"")),
            },
        };
        let i = at.need("axis")?.index(3, "axes")?;
        let number = |key: &str| at.get(key).map_or(Ok(0.0), |v| v.f32());
        let positive = |key: &str| at.get(key).map_or(Ok(0.0), |v| v.at_least_zero());
        let drive = JointDrive {
            position: number("positionTarget")?,
            velocity: number("velocityTarget")?,
            spring: JointSpring {
                stiffness: positive("stiffness")?,
                damping: positive("damping")?,
                per_mass,
            },
            max_force: at.get("maxForce").map_or(Ok(f32::INFINITY), |v| v.at_least_zero())?,
        };
        let axis = if is_turn { &mut self.axes.angular[i] } else { &mut self.axes.linear[i] };
        if axis.drive.replace(drive).is_some() {
            self.note(at, "an axis has several drives, the last one is kept");
        }
        Ok(())
    }

    fn finish(mut self) -> Described {
        let mut turn = Quat::IDENTITY;
        if let Some(swing) = self.swing.take() {
            turn = self.make_cone(&swing);
        }
        let mut kinds = Vec::new();
        let six = &self.axes;
        let is = |axes: &[JointAxis; 3], what: JointAxis| axes.iter().all(|a| *a == what);
        let turns_freely = is(&six.angular, JointAxis::FREE) && six.cone.is_none();
        if turns_freely && is(&six.linear, JointAxis::LOCKED) {
            kinds.push(JointKind::Ball);
        } else if !(turns_freely && is(&six.linear, JointAxis::FREE)) {
            kinds.push(JointKind::SixDof(*six));
        }
        if let Some((min, max)) = self.range {
            kinds.push(JointKind::Distance { min, max, spring: None });
        }
        Described { turn, kinds }
    }

    /// Takes the axis of a cone for x; returns the frame that has it there.
    fn make_cone(&mut self, swing: &Swing) -> Quat {
        let k = swing.about;
        let [x, y, z] = [k, (k + 1) % 3, (k + 2) % 3];
        let a = self.axes.angular;
        let law = |axis: &JointAxis| axis.drive.map(|d| (d.spring, d.max_force));
        if [a[y].motion, a[z].motion] != [JointMotion::Free; 2] || law(&a[y]) != law(&a[z]) {
            self.notes.push(
                "a joint's cone is taken for each swing by itself: they have limits of their own, \
                 or are driven differently"
                    .to_owned(),
            );
            for i in [y, z] {
                let axis = &mut self.axes.angular[i];
                if axis.motion == JointMotion::Free {
                    let (min, max) = (-swing.max, swing.max);
                    axis.motion = JointMotion::Limited { min, max, spring: swing.spring };
                }
            }
            return Quat::IDENTITY;
        }
        let l = self.axes.linear;
        self.axes = SixDof {
            linear: [l[x], l[y], l[z]],
            angular: [a[x], a[y], a[z]],
            cone: Some(JointCone { swing: [swing.max; 2], spring: swing.spring }),
            ..self.axes
        };
        // A third of a turn about the diagonal takes x to y, y to z, z to x.
        let third = Quat::new(0.5, 0.5, 0.5, 0.5);
        match k {
            0 => Quat::IDENTITY,
            1 => third,
            _ => third.conjugate(),
        }
    }
}

impl Described {
    /// One of its kinds with the frames of the two nodes [frames of their bodies].
    pub(crate) fn in_frames(&self, kind: JointKind, a: Quat, b: Quat) -> JointKind {
        match kind {
            JointKind::SixDof(axes) => {
                let at = |frame: Quat| (frame * self.turn).normalized();
                JointKind::SixDof(SixDof { frame_a: at(a), frame_b: at(b), ..axes })
            }
            other => other,
        }
    }
}
