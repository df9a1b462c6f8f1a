//! The interface of an engine to the benchmark.

use drystone::{BodyDef, MassDef, Pose, Vec3, World};
use drystone_scene::{Load, Scene, SceneBody, Wave};

use crate::row::Stages;

/// An engine that runs a scene of the catalog. Bodies are identified by their number in the scene;
/// bodies that are added later get the next numbers, in order.
pub trait Engine: Sized {
    /// Its name on the command line and in rows.
    const NAME: &'static str;

    /// Its version.
    fn version() -> String;

    /// Builds the scene in this engine, ready for the first step, with `threads` threads including
    /// the caller.
    ///
    /// # Errors
    /// Fails if the scene needs a feature that the engine lacks; the engine is then not compared on
    /// it.
    fn build(scene: &Scene, threads: usize) -> Result<Self, EngineError>;

    /// Adds a body.
    ///
    /// # Errors
    /// Fails if the body needs a feature that the engine lacks.
    fn add(&mut self, body: &SceneBody) -> Result<(), EngineError>;

    /// Gives a kinematic body the velocity that moves its origin to `position` [m, world] in the
    /// next step of `dt` [s], without rotation.
    ///
    /// # Errors
    /// Fails if the engine refuses it.
    fn aim(&mut self, body: usize, position: Vec3, dt: f32) -> Result<(), EngineError>;

    /// Applies a lasting force [N] to a dynamic body at its center of mass, from now on.
    ///
    /// # Errors
    /// Fails if the engine has no such force.
    fn pull(&mut self, _load: &Load) -> Result<(), EngineError> {
        Err(EngineError("lasting forces are not translated".to_owned()))
    }

    /// Removes bodies, and adds bodies with their joints.
    ///
    /// # Errors
    /// Fails if the engine refuses a body, or does not support this.
    fn bring(&mut self, wave: &Wave) -> Result<(), EngineError> {
        let _ = wave;
        Err(EngineError("bodies that come and go in groups are not translated".to_owned()))
    }

    /// Pushes a dynamic body at its center of mass with a force [N, world] during the next step of
    /// `dt` [s].
    ///
    /// # Errors
    /// Fails if the engine refuses it, or its forces are not translated.
    fn push(&mut self, body: usize, force: Vec3, dt: f32) -> Result<(), EngineError> {
        let _ = (body, force, dt);
        Err(EngineError("forces are not translated".to_owned()))
    }

    /// Force of the contacts on a body in the last substep of the last step of `dt` [s], along
    /// their normals [N, world]; `None` if the engine does not report it.
    fn contact_force(&self, body: usize, dt: f32) -> Option<Vec3> {
        let _ = (body, dt);
        None
    }

    /// Advances time by `dt` [s]. The benchmark times this call.
    fn step(&mut self, dt: f32);

    /// The state of a body.
    fn state(&self, body: usize) -> BodyState;

    /// Name of the SIMD level in use.
    fn simd(&self) -> String;

    /// The engine's own hash of the world's state; without one, poses and velocities are hashed.
    fn hash(&self) -> Option<u64> {
        None
    }

    /// Restarts the clock after the warm-up steps.
    fn restart_clock(&mut self) {}

    /// Mean times of the stages of a step [ms] over the last `steps`, if the engine reports them.
    fn stages_ms(&self, steps: u64) -> Option<Stages> {
        let _ = steps;
        None
    }
}

/// The reason an engine cannot run a scene.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{0}")]
pub struct EngineError(pub String);

/// Pose and velocities of a body.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BodyState {
    /// Pose of its origin [m, world].
    pub pose: Pose,
    /// Velocity of its center of mass [m/s, world].
    pub linear_velocity: Vec3,
    /// Angular velocity [rad/s, world].
    pub angular_velocity: Vec3,
}

impl BodyState {
    fn numbers(&self) -> [f32; 13] {
        let (p, q) = (self.pose.position, self.pose.rotation);
        let (v, w) = (self.linear_velocity, self.angular_velocity);
        [p.x, p.y, p.z, q.x, q.y, q.z, q.w, v.x, v.y, v.z, w.x, w.y, w.z]
    }

    /// True if all its numbers are finite.
    #[must_use]
    pub fn is_finite(&self) -> bool {
        self.numbers().iter().all(|n| n.is_finite())
    }
}

/// A hash of the bits of these states (64-bit FNV-1a): equal runs have equal hashes.
#[must_use]
pub fn hash_states(states: &[BodyState]) -> u64 {
    let bytes = states.iter().flat_map(BodyState::numbers).flat_map(f32::to_le_bytes);
    bytes.fold(0xcbf2_9ce4_8422_2325, |hash, byte| {
        (hash ^ u64::from(byte)).wrapping_mul(0x0000_0100_0000_01b3)
    })
}

/// Factor on the densities of a body's shapes that gives the mass in its definition, for engines
/// that take densities.
///
/// # Errors
/// Fails if the definition also gives center and inertia, or drystone refuses it.
pub fn density_factor(def: &BodyDef) -> Result<f32, EngineError> {
    let mass = match def.mass {
        MassDef::FromShapes => return Ok(1.0),
        MassDef::Mass(mass) => mass,
        MassDef::Exact { .. } => {
            return Err(EngineError("a body with a given inertia is not translated".to_owned()));
        }
    };
    let plain = BodyDef { mass: MassDef::FromShapes, ..def.clone() };
    let mut world = World::default();
    let id = world.add_body(plain).map_err(|e| EngineError(e.to_string()))?;
    let own = world.body(id).map_or(0.0, |body| body.mass());
    if own > 0.0 { Ok(mass / own) } else { Err(EngineError("a body without density".to_owned())) }
}

#[cfg(test)]
mod tests {
    use drystone::{BodyDef, ShapeDef, Vec3};

    use super::{BodyState, Pose, density_factor, hash_states};

    #[test]
    fn a_hash_sees_every_number_and_the_order() {
        let rest = BodyState {
            pose: Pose::IDENTITY,
            linear_velocity: Vec3::ZERO,
            angular_velocity: Vec3::ZERO,
        };
        let moved = BodyState { angular_velocity: Vec3::Z * 1.0e-30, ..rest };
        assert_ne!(hash_states(&[rest]), hash_states(&[moved]));
        assert_ne!(hash_states(&[rest, moved]), hash_states(&[moved, rest]));
        assert!(moved.is_finite());
        let lost = BodyState { linear_velocity: Vec3::splat(f32::NAN), ..rest };
        assert!(!lost.is_finite());
    }

    #[test]
    fn densities_are_scaled_to_the_mass_that_was_given() {
        // A cube of 1 m³ has a mass of 1000 kg.
        let cube = BodyDef::dynamic().with_shape(ShapeDef::box_half(Vec3::splat(0.5)));
        assert_eq!(density_factor(&cube).unwrap().to_bits(), 1.0_f32.to_bits());
        let factor = density_factor(&cube.with_mass(250.0)).unwrap();
        assert!((factor - 0.25).abs() < 1.0e-6, "{factor}");
    }
}
