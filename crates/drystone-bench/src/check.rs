//! Measures overlaps of bodies and errors of joints from poses alone, by the same code for every
//! engine.

use std::collections::BTreeSet;

use drystone::{BodyId, BodyKind, JointKind, Pose, Vec3, World, WorldConfig};
use drystone_scene::{Scene, SceneBody, SceneJoint};

use crate::engine::{BodyState, EngineError};

/// Length of the step that finds contacts [s]; nothing moves in it.
const MOMENT: f32 = 1.0e-6;

/// Measures overlaps and joint errors of a scene's bodies.
///
/// It holds a world of drystone without gravity, sleep and joints, in which bodies have the poses
/// of the engine under test. The narrowphase of a step too short for motion then measures the
/// overlaps. Between two looks it keeps only the faces or edges at which a pair touched; manifolds
/// are made anew.
#[derive(Debug)]
pub struct Checker<'a> {
    world: World,
    bodies: Vec<(&'a SceneBody, BodyId)>,
    joints: Vec<&'a SceneJoint>,
    /// Pairs connected by a joint that lets them overlap.
    may_overlap: BTreeSet<(BodyId, BodyId)>,
    max_penetration: f32,
    max_joint_error: f32,
}

impl<'a> Checker<'a> {
    /// Makes a checker for this scene.
    ///
    /// # Errors
    /// Fails if drystone refuses a part of the scene.
    pub fn new(scene: &'a Scene) -> Result<Self, EngineError> {
        let mut config = WorldConfig { gravity: Vec3::ZERO, substeps: 1, ..WorldConfig::default() };
        config.sleep.enabled = false;
        config.contact.recycle_distance = 0.0;
        let world = World::new(config).map_err(|e| EngineError(e.to_string()))?;
        let mut checker = Self {
            world,
            bodies: Vec::with_capacity(scene.bodies.len()),
            joints: Vec::new(),
            may_overlap: BTreeSet::new(),
            max_penetration: 0.0,
            max_joint_error: 0.0,
        };
        for body in &scene.bodies {
            checker.add(body)?;
        }
        scene.joints.iter().for_each(|joint| checker.join(joint));
        Ok(checker)
    }

    /// Adds a joint between bodies that were added before.
    pub fn join(&mut self, joint: &'a SceneJoint) {
        if let (Some(a), Some(b), false) =
            (self.id(joint.body_a), self.id(joint.body_b), joint.collide_connected)
        {
            self.may_overlap.insert((a.min(b), a.max(b)));
        }
        self.joints.push(joint);
    }

    /// Adds a body.
    ///
    /// # Errors
    /// Fails if drystone refuses it.
    pub fn add(&mut self, body: &'a SceneBody) -> Result<(), EngineError> {
        let refused = |e| EngineError(format!("body '{}': {e}", body.name));
        let id = self.world.add_body(body.def.clone()).map_err(refused)?;
        self.bodies.push((body, id));
        Ok(())
    }

    /// A body by its number in the scene.
    #[must_use]
    pub fn body(&self, number: usize) -> Option<&'a SceneBody> {
        self.bodies.get(number).map(|(body, _)| *body)
    }

    fn id(&self, number: usize) -> Option<BodyId> {
        self.bodies.get(number).map(|(_, id)| *id)
    }

    /// Measures at these states of the bodies `numbers`, which are all moving bodies that exist.
    /// Other moving bodies are moved out of the way. A body whose pose is NaN, or too far away,
    /// keeps its previous pose.
    pub fn look(&mut self, numbers: &[usize], states: &[BodyState]) {
        let mut poses: Vec<Option<Pose>> = vec![None; self.bodies.len()];
        for (&number, state) in numbers.iter().zip(states) {
            if let Some(pose) = poses.get_mut(number) {
                *pose = Some(state.pose);
            }
        }
        let stays = |from: &SceneBody| from.def.kind == BodyKind::Static;
        for (number, (&(from, id), pose)) in self.bodies.iter().zip(&poses).enumerate() {
            if stays(from) {
                continue;
            }
            let Some(mut body) = self.world.body_mut(id) else { continue };
            let away = || Pose::at([0.0, 1.0e6 + 1.0e3 * small(number), 0.0]);
            // A refused pose is one that the row counts as `lost`.
            body.set_pose(pose.unwrap_or_else(away));
            body.set_linear_velocity(Vec3::ZERO);
            body.set_angular_velocity(Vec3::ZERO);
        }
        let bodies = &self.bodies;
        let there = |number: usize| {
            bodies.get(number).is_some_and(|(from, _)| stays(from) || poses[number].is_some())
        };
        for joint in &self.joints {
            if there(joint.body_a) && there(joint.body_b) {
                self.max_joint_error = self.max_joint_error.max(self.joint_error(joint));
            }
        }
        self.world.step(MOMENT);
        for contact in self.world.contacts() {
            let (a, b) = (contact.body_a(), contact.body_b());
            if !self.may_overlap.contains(&(a.min(b), a.max(b))) {
                let depth = contact.points().fold(0.0_f32, |d, p| d.max(-p.separation));
                self.max_penetration = self.max_penetration.max(depth);
            }
        }
    }

    fn joint_error(&self, joint: &SceneJoint) -> f32 {
        let anchor = |number: usize, anchor: Vec3| {
            self.id(number).and_then(|id| self.world.body(id)).map(|b| b.pose().point(anchor))
        };
        let ends = (anchor(joint.body_a, joint.anchor_a), anchor(joint.body_b, joint.anchor_b));
        let (Some(a), Some(b)) = ends else { return 0.0 };
        // A joint between two bodies that do not move cannot hold them together.
        let moves = |n: usize| self.body(n).is_some_and(|b| b.def.kind == BodyKind::Dynamic);
        if !moves(joint.body_a) && !moves(joint.body_b) {
            return 0.0;
        }
        let distance = (b - a).length();
        match joint.kind {
            JointKind::Ball => distance,
            JointKind::Distance { min, max, .. } => (min - distance).max(distance - max).max(0.0),
            JointKind::SixDof(axes) => {
                let a_frame = self.id(joint.body_a).and_then(|id| self.world.body(id));
                let turn = a_frame.map_or(axes.frame_a, |a| a.rotation() * axes.frame_a);
                axes.linear_excess(turn.unrotate(b - a))
            }
            _ => 0.0,
        }
    }

    /// Maximum overlap of two shapes so far [m].
    #[must_use]
    pub fn max_penetration(&self) -> f64 {
        f64::from(self.max_penetration)
    }

    /// Maximum joint error so far [m]; `None` without joints.
    #[must_use]
    pub fn max_joint_error(&self) -> Option<f64> {
        (!self.joints.is_empty()).then_some(f64::from(self.max_joint_error))
    }
}

/// Converts a small count.
#[expect(clippy::cast_precision_loss, reason = "only to spread bodies")]
const fn small(n: usize) -> f32 {
    n as f32
}

#[cfg(test)]
mod tests {
    use drystone::{Pose, Quat, Vec3, vec3};
    use drystone_scene::named;

    use super::Checker;
    use crate::engine::BodyState;

    fn at(position: Vec3) -> BodyState {
        BodyState {
            pose: Pose::at(position),
            linear_velocity: Vec3::X,
            angular_velocity: Vec3::ZERO,
        }
    }

    #[test]
    fn a_known_overlap_is_found_and_the_deepest_is_kept() {
        // Cubes of edge 1 above ground at y = 0. Velocities do not matter.
        let scene = named("stack:n=2").unwrap();
        let mut checker = Checker::new(&scene).unwrap();
        checker.look(&[1, 2], &[at(vec3(0.0, 0.5, 0.0)), at(vec3(0.0, 1.6, 0.0))]);
        assert!(checker.max_penetration() < 1.0e-6, "{}", checker.max_penetration());
        // The upper cube is 0.04 m deep in the lower one and rotated about y; the lower one is 0.01
        // m deep in the ground.
        let turned = Quat::from_axis_angle(Vec3::Y, 0.3);
        let mut upper = at(vec3(0.1, 1.45, 0.05));
        upper.pose.rotation = turned;
        checker.look(&[1, 2], &[at(vec3(0.0, 0.49, 0.0)), upper]);
        assert!((checker.max_penetration() - 0.04).abs() < 1.0e-5, "{}", checker.max_penetration());
        checker.look(&[1, 2], &[at(vec3(0.0, 0.5, 0.0)), at(vec3(0.0, 5.0, 0.0))]);
        assert!((checker.max_penetration() - 0.04).abs() < 1.0e-5, "{}", checker.max_penetration());
        assert_eq!(checker.max_joint_error(), None);
    }

    #[test]
    fn looking_twice_at_the_same_poses_finds_the_same() {
        let scene = named("stack:n=2").unwrap();
        let states = [at(vec3(0.0, 0.47, 0.0)), at(vec3(0.0, 1.46, 0.0))];
        let found = |looks: usize| {
            let mut checker = Checker::new(&scene).unwrap();
            (0..looks).for_each(|_| checker.look(&[1, 2], &states));
            checker.max_penetration()
        };
        assert!((found(1) - 0.03).abs() < 1.0e-5);
        assert!((found(1) - found(9)).abs() < 1.0e-6, "{} {}", found(1), found(9));
    }

    #[test]
    fn joints_are_measured_and_excuse_overlap_of_what_they_join() {
        let scene = named("cradle:balls=2,pulled=0").unwrap();
        let mut checker = Checker::new(&scene).unwrap();
        let [a, b] = [1, 2].map(|n: usize| scene.bodies[n].def.position);
        checker.look(&[1, 2], &[at(a), at(b)]);
        assert!(checker.max_joint_error().unwrap() < 1.0e-6);
        checker.look(&[1, 2], &[at(a + vec3(0.0, 0.25, 0.0)), at(b)]);
        assert!((checker.max_joint_error().unwrap() - 0.25).abs() < 1.0e-6);
        // A ball inside the beam from which it hangs.
        checker.look(&[1, 2], &[at(a + vec3(0.0, 5.0, 0.0)), at(b)]);
        assert!(checker.max_penetration() < 1.0e-6, "{}", checker.max_penetration());
    }

    #[test]
    fn what_is_lost_does_not_stop_the_look() {
        let scene = named("stack:n=2").unwrap();
        let mut checker = Checker::new(&scene).unwrap();
        checker.look(&[1, 2], &[at(Vec3::splat(f32::NAN)), at(vec3(0.0, 1.0e30, 0.0))]);
        assert!(checker.max_penetration() < 1.0e-6);
        checker.look(&[1], &[at(vec3(0.0, 0.5, 0.0))]);
    }
}
