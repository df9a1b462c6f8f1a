//! A tree with its state and memory: the interface for users, in double precision.

use super::def::{TreeDef, TreeError};
use super::spatial::{Spatial, Vector};
use super::step::{TreeState, TreeStepConfig};
use super::tree::Tree;
use super::work::TreeWork;

/// A tree of links with its state: coordinates `q`, velocities `v`, and forces of the joints.
///
/// Coordinates and velocities are sized and ordered as in MuJoCo; the module has the conventions.
/// All results belong to the present state.
#[derive(Clone, Debug)]
pub struct Articulation {
    pub(crate) tree: Tree<f64>,
    pub(crate) work: TreeWork<f64>,
    pub(crate) state: TreeState<f64>,
    pub(crate) tau: Vec<f64>,
    pub(crate) config: TreeStepConfig,
    pub(crate) recovered: f64,
}

impl Articulation {
    /// The tree at rest at its references, under `gravity` \[m/s², world\].
    ///
    /// # Errors
    /// A number that is not finite or out of range, a cycle, an impossible inertia, or a joint that
    /// moves no inertia and has no armature.
    pub fn new(def: &TreeDef, gravity: [f64; 3]) -> Result<Self, TreeError> {
        let tree = Tree::new(def, gravity)?;
        let work = TreeWork::new(&tree);
        let state = TreeState::new(&tree);
        let tau = vec![0.0; tree.v_count()];
        let config = TreeStepConfig::default();
        let mut new = Self { tree, work, state, tau, config, recovered: 0.0 };
        new.update();
        Ok(new)
    }

    /// Takes a saved state, bit by bit.
    ///
    /// # Errors
    /// A wrong number of values, or one out of range.
    #[cfg(feature = "serde")]
    pub(crate) fn restore(
        &mut self,
        q: Vec<f64>,
        v: Vec<f64>,
        tau: Vec<f64>,
        config: TreeStepConfig,
        recovered: f64,
    ) -> Result<(), TreeError> {
        self.tree.check_state(&q, &v)?;
        self.rates("tau", &tau)?;
        finite("recovered", &[recovered])?;
        (self.state.q, self.state.v, self.tau) = (q, v, tau);
        (self.config, self.recovered) = (config, recovered);
        self.update();
        Ok(())
    }

    /// Places links and velocities at the state.
    pub(crate) fn update(&mut self) {
        self.tree.place(&self.state.q, &mut self.work);
        self.tree.move_links(&self.state.v, &mut self.work);
    }

    /// Coordinates \[rad, m, and unit quaternions\].
    #[must_use]
    pub fn q(&self) -> &[f64] {
        &self.state.q
    }

    /// Velocities \[rad/s, m/s\].
    #[must_use]
    pub fn v(&self) -> &[f64] {
        &self.state.v
    }

    /// Number of links.
    #[must_use]
    pub const fn link_count(&self) -> usize {
        self.tree.link_count()
    }

    /// Where the coordinates and velocities of a joint begin in `q` and `v`, if the link has it.
    #[must_use]
    pub fn joint_start(&self, link: usize, joint: usize) -> Option<(usize, usize)> {
        self.tree.joint_start(link, joint)
    }

    /// Sets coordinates and velocities; quaternions are scaled to length 1. The state is all that
    /// a step depends on, besides forces and tuning.
    ///
    /// # Errors
    /// A wrong number of values, one that is not finite or beyond 1e12, or a quaternion of length
    /// 0. Nothing is changed then.
    pub fn set_state(&mut self, q: &[f64], v: &[f64]) -> Result<(), TreeError> {
        self.tree.check_state(q, v)?;
        self.state.q.copy_from_slice(q);
        self.state.v.copy_from_slice(v);
        self.tree.normalize(&mut self.state.q);
        self.update();
        Ok(())
    }

    /// Sets the generalized forces \[N m, N\] that act in all following steps; 0 at first.
    ///
    /// # Errors
    /// A wrong number of values, or one that is not finite or beyond 1e12.
    pub fn set_forces(&mut self, tau: &[f64]) -> Result<(), TreeError> {
        self.rates("tau", tau)?;
        self.tau.copy_from_slice(tau);
        Ok(())
    }

    /// Adds to the generalized forces a force \[N, world\] at a point of a link \[m, link\], and a
    /// moment \[N m, world\], at the present pose.
    ///
    /// # Errors
    /// A link that does not exist, or a number that is not finite.
    pub fn add_force(
        &mut self,
        link: usize,
        point: [f64; 3],
        force: [f64; 3],
        moment: [f64; 3],
    ) -> Result<(), TreeError> {
        self.link(link)?;
        for (name, value) in [("point", point), ("force", force), ("moment", moment)] {
            finite(name, &value)?;
        }
        let wrench = Spatial { angular: Vector(moment), linear: Vector(force) };
        self.tree.add_wrench(link, Vector(point), wrench, &self.work, &mut self.tau);
        Ok(())
    }

    /// Tuning of the step.
    #[must_use]
    pub const fn config(&self) -> &TreeStepConfig {
        &self.config
    }

    /// Sets the tuning of the step; numbers out of range count as the nearest in it.
    pub const fn set_config(&mut self, config: TreeStepConfig) {
        self.config = config;
    }

    /// Advances the state by `h` \[s\], above 0 and at most 1.
    ///
    /// # Errors
    /// A time out of range, or a state that would not be finite; the state is unchanged then.
    pub fn step(&mut self, h: f64) -> Result<(), TreeError> {
        if !(h > 0.0 && h <= 1.0) {
            return Err(TreeError::new("h", h, "above 0 and at most 1 s"));
        }
        let before = self.state.clone();
        let report = self.tree.step(&mut self.state, &self.tau, h, &self.config, &mut self.work);
        if let Err(error) = self.tree.check_state(&self.state.q, &self.state.v) {
            self.state = before;
            self.update();
            return Err(error);
        }
        self.recovered += report.recovery_work;
        self.update();
        Ok(())
    }

    /// Work against gravity and springs with which violated limits and closures were closed, in
    /// all steps \[J\]. It is the only energy that a passive tree gains.
    #[must_use]
    pub const fn recovery_work(&self) -> f64 {
        self.recovered
    }

    /// Origin of a link \[m, world\] and its rotation, a unit quaternion with the real part first.
    #[must_use]
    pub fn pose(&self, link: usize) -> Option<([f64; 3], [f64; 4])> {
        self.tree.pose(link, &self.work).map(|(position, rotation)| (position.0, rotation.0))
    }

    /// Velocity of a point of a link \[m, link\]: angular \[rad/s, world\], linear \[m/s, world\].
    #[must_use]
    pub fn velocity(&self, link: usize, point: [f64; 3]) -> Option<[[f64; 3]; 2]> {
        let velocity = self.tree.point_velocity(link, Vector(point), &self.work)?;
        Some([velocity.angular.0, velocity.linear.0])
    }

    /// Jacobian of a point of a link \[m, link\]: for each velocity the angular \[rad/s, world\]
    /// and linear velocity \[m/s, world\] of the point at a rate of 1.
    #[must_use]
    pub fn jacobian(&self, link: usize, point: [f64; 3]) -> Option<Vec<[[f64; 3]; 2]>> {
        self.link(link).ok()?;
        let mut columns = vec![Spatial::zero(); self.tree.v_count()];
        self.tree.jacobian(link, Vector(point), &self.work, &mut columns);
        Some(columns.iter().map(|s| [s.angular.0, s.linear.0]).collect())
    }

    /// Mass matrix with armature, row by row \[kg, kg m, kg m²\].
    #[must_use]
    pub fn mass_matrix(&mut self) -> Vec<f64> {
        self.tree.mass_matrix(&mut self.work)
    }

    /// Forces of gravity and velocity products \[N m, N\]: those that the joints must bear at no
    /// acceleration.
    #[must_use]
    pub fn bias(&mut self) -> Vec<f64> {
        self.tree.bias(&mut self.work);
        self.work.tau.clone()
    }

    /// Generalized forces \[N m, N\] that give the accelerations `a` \[rad/s², m/s²\]. Springs,
    /// damping and friction of joints are not in them.
    ///
    /// # Errors
    /// A wrong number of values, or one that is not finite.
    pub fn inverse_dynamics(&mut self, a: &[f64]) -> Result<Vec<f64>, TreeError> {
        self.rates("a", a)?;
        let (q, v) = (&self.state.q, &self.state.v);
        Ok(self.tree.inverse_dynamics(q, v, a, &mut self.work).to_vec())
    }

    /// Generalized forces \[N m, N\] that hold the tree against gravity.
    #[must_use]
    pub fn gravity_compensation(&mut self) -> Vec<f64> {
        let tau = self.tree.gravity_compensation(&self.state.q, &mut self.work).to_vec();
        self.update();
        tau
    }

    /// Accelerations \[rad/s², m/s²\] under the forces, springs and damping, without limits,
    /// friction, couplings, tendons and closures.
    #[must_use]
    pub fn accelerations(&mut self) -> Vec<f64> {
        let mut out = vec![0.0; self.tree.v_count()];
        let (q, v) = (&self.state.q, &self.state.v);
        self.tree.forward_dynamics(q, v, &self.tau, &mut self.work, &mut out);
        out
    }

    /// Mass \[kg\] and center of mass \[m, world\].
    #[must_use]
    pub fn center_of_mass(&self) -> (f64, [f64; 3]) {
        let (mass, center) = self.tree.center_of_mass(&self.work);
        (mass, center.0)
    }

    /// Angular momentum about the center of mass \[kg m²/s, world\] and linear momentum
    /// \[kg m/s, world\].
    #[must_use]
    pub fn momentum(&self) -> [[f64; 3]; 2] {
        let momentum = self.tree.momentum(&self.work);
        [momentum.angular.0, momentum.linear.0]
    }

    /// Kinetic energy \[J\], with that of armatures.
    #[must_use]
    pub fn kinetic_energy(&self) -> f64 {
        self.tree.kinetic_energy(&self.state.v, &self.work)
    }

    /// Energy of gravity, 0 at the world's origin, and of springs \[J\].
    #[must_use]
    pub fn potential_energy(&self) -> f64 {
        self.tree.gravity_energy(&self.work) + self.tree.spring_energy(&self.state.q)
    }

    /// Energy of the joints' springs \[J\].
    pub(crate) fn spring_energy(&self) -> f64 {
        self.tree.spring_energy(&self.state.q)
    }

    /// Kinetic energy of the joints' rotors \[J\].
    pub(crate) fn rotor_energy(&self) -> f64 {
        self.tree.rotor_energy(&self.state.v)
    }

    fn link(&self, link: usize) -> Result<(), TreeError> {
        if link < self.tree.link_count() {
            return Ok(());
        }
        Err(TreeError::new("link", link, "the index of a link"))
    }

    /// Checks numbers that belong to the velocities.
    fn rates(&self, name: &str, values: &[f64]) -> Result<(), TreeError> {
        if values.len() != self.tree.v_count() {
            let allowed = format!("{} numbers", self.tree.v_count());
            return Err(TreeError::new(name, format!("{} numbers", values.len()), &allowed));
        }
        finite(name, values)
    }
}

/// Checks that numbers are finite and at most 1e12.
fn finite(name: &str, values: &[f64]) -> Result<(), TreeError> {
    match values.iter().position(|x| !(x.abs() <= 1.0e12)) {
        None => Ok(()),
        Some(i) => Err(TreeError::new(format!("{name}[{i}]"), values[i], "-1e12 to 1e12")),
    }
}
