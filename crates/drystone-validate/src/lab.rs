//! The laboratory: an engine behind a small trait, the protocol, and a scene that runs under it.

use drystone::math::Sym3;
use drystone::{BodyDef, BodyKind, Vec3, World};
use drystone_bench::{BodyState, Checker, Engine, EngineError, still_stands};
use drystone_scene::{Scene, SceneBody, Script};

use crate::numeric::{
    D3, add, cross, dot, norm, rotate, scale, single, unrotate, whole, wide, worst,
};

/// An engine with a scene in it, of any type.
pub trait Subject {
    /// See [`Engine::push`].
    ///
    /// # Errors
    /// Fails if the engine refuses it.
    fn push(&mut self, body: usize, force: Vec3, dt: f32) -> Result<(), EngineError>;
    /// See [`Engine::contact_force`].
    fn contact_force(&self, body: usize, dt: f32) -> Option<Vec3>;
    /// See [`Engine::step`].
    fn step(&mut self, dt: f32);
    /// See [`Engine::state`].
    fn state(&self, body: usize) -> BodyState;
}

impl<E: Engine> Subject for E {
    fn push(&mut self, body: usize, force: Vec3, dt: f32) -> Result<(), EngineError> {
        Engine::push(self, body, force, dt)
    }

    fn contact_force(&self, body: usize, dt: f32) -> Option<Vec3> {
        Engine::contact_force(self, body, dt)
    }

    fn step(&mut self, dt: f32) {
        Engine::step(self, dt);
    }

    fn state(&self, body: usize) -> BodyState {
        Engine::state(self, body)
    }
}

type Build = fn(&Scene, usize) -> Result<Box<dyn Subject>, EngineError>;

/// An engine to be tested.
#[derive(Clone, Debug)]
pub struct Candidate {
    /// Its name.
    pub name: &'static str,
    /// Its version.
    pub version: String,
    build: Build,
}

impl Candidate {
    /// A candidate for this engine.
    #[must_use]
    pub fn of<E: Engine + 'static>() -> Self {
        let build: Build = |scene, threads| Ok(Box::new(E::build(scene, threads)?));
        Self { name: E::NAME, version: E::version(), build }
    }

    /// Whether it is drystone itself, which reports more than motion.
    #[must_use]
    pub fn is_own(&self) -> bool {
        self.name == drystone_bench::Own::NAME
    }
}

/// Settings of the tests. The default is the protocol: 60 steps per second, the method's own number
/// of substeps, sleep off.
#[derive(Clone, Debug)]
pub struct Protocol {
    /// Steps per second.
    pub hz: f64,
    /// Substeps per step; 0 selects the method's own number.
    pub substeps: u32,
    /// Number of threads, including the caller.
    pub threads: usize,
    /// Fields of the world's configuration by path; they override the settings of a test.
    pub set: Vec<(String, String)>,
    /// Skips long tests.
    pub short: bool,
}

impl Default for Protocol {
    fn default() -> Self {
        Self { hz: 60.0, substeps: 0, threads: 1, set: Vec::new(), short: false }
    }
}

/// An engine and the protocol.
#[derive(Clone, Debug)]
pub struct Lab {
    /// The engine.
    pub candidate: Candidate,
    /// The protocol.
    pub protocol: Protocol,
}

impl Lab {
    /// Length of a step [s], rounded as the engine gets it.
    #[must_use]
    pub fn dt(&self) -> f64 {
        f64::from(single(1.0 / self.protocol.hz))
    }

    /// The same laboratory with another protocol.
    #[must_use]
    pub fn with(&self, protocol: Protocol) -> Self {
        Self { candidate: self.candidate.clone(), protocol }
    }

    /// Fails for engines other than drystone, which alone supports `what`.
    ///
    /// # Errors
    /// Fails if it is another engine.
    pub fn own(&self, what: &str) -> Result<(), EngineError> {
        if self.candidate.is_own() {
            return Ok(());
        }
        Err(EngineError(format!("{what} is read from drystone only")))
    }

    /// A scene of the catalog.
    ///
    /// # Errors
    /// Fails if the catalog has no scene of this name.
    pub fn named(&self, spec: &str) -> Result<Scene, EngineError> {
        drystone_scene::named(spec).map_err(|e| EngineError(e.to_string()))
    }

    /// Starts a scene under the protocol, ready for its first step.
    ///
    /// # Errors
    /// Fails if the engine refuses a part of the scene, or a setting is unknown.
    pub fn start(&self, mut scene: Scene) -> Result<Run, EngineError> {
        if !matches!(scene.script, Script::None) {
            return Err(EngineError("scenes with a script are not run here".to_owned()));
        }
        scene.config.sleep.enabled = false;
        scene.config.substeps = self.protocol.substeps;
        scene.hz = single(self.protocol.hz);
        for (path, value) in &self.protocol.set {
            scene.config.set(path, value).map_err(|e| EngineError(e.to_string()))?;
        }
        let subject = (self.candidate.build)(&scene, self.protocol.threads)?;
        let matter = scene.bodies.iter().map(matter).collect::<Result<_, _>>()?;
        Ok(Run { scene, subject, matter, dt: single(1.0 / self.protocol.hz), steps: 0 })
    }
}

/// Mass and inertia of a body in its own frame, in f64.
#[derive(Clone, Copy, Debug)]
pub struct Matter {
    /// Mass [kg]; 0 unless the body is dynamic.
    pub mass: f64,
    center: D3,
    inertia: Sym3,
}

impl Matter {
    /// Inertia times `w`, both in the body's axes [kg m²/s].
    #[must_use]
    pub fn inertia_times(&self, w: D3) -> D3 {
        let i = &self.inertia;
        let row = |a: f32, b: f32, c: f32| dot([f64::from(a), f64::from(b), f64::from(c)], w);
        [row(i.xx, i.xy, i.xz), row(i.xy, i.yy, i.yz), row(i.xz, i.yz, i.zz)]
    }
}

fn matter(body: &SceneBody) -> Result<Matter, EngineError> {
    let mut world = World::default();
    let def =
        BodyDef { position: Vec3::ZERO, rotation: drystone::Quat::IDENTITY, ..body.def.clone() };
    let refused = |e| EngineError(format!("body '{}': {e}", body.name));
    let id = world.add_body(def).map_err(refused)?;
    let none = Matter { mass: 0.0, center: [0.0; 3], inertia: Sym3::ZERO };
    Ok(world.body(id).filter(|b| b.kind() == BodyKind::Dynamic).map_or(none, |b| Matter {
        mass: f64::from(b.mass()),
        center: wide(b.center_of_mass()),
        inertia: b.inertia(),
    }))
}

/// State of a body at the end of a step, in f64.
#[derive(Clone, Copy, Debug)]
pub struct Moment {
    /// Pose and velocities from the engine.
    pub state: BodyState,
    /// Its center of mass [m, world].
    pub center: D3,
    /// Velocity of its center of mass [m/s, world].
    pub v: D3,
    /// Angular velocity [rad/s, world].
    pub w: D3,
    matter: Matter,
}

impl Moment {
    /// Its angular momentum about its center of mass [kg m²/s, world].
    #[must_use]
    pub fn spin(&self) -> D3 {
        let q = self.state.pose.rotation;
        rotate(q, self.matter.inertia_times(unrotate(q, self.w)))
    }

    /// Its angular velocity in its own axes [rad/s, body].
    #[must_use]
    pub fn w_body(&self) -> D3 {
        unrotate(self.state.pose.rotation, self.w)
    }

    /// Its rotational energy [J].
    #[must_use]
    pub fn rotational_energy(&self) -> f64 {
        0.5 * dot(self.w, self.spin())
    }

    /// Its kinetic energy [J].
    #[must_use]
    pub fn kinetic_energy(&self) -> f64 {
        0.5 * self.matter.mass * dot(self.v, self.v) + self.rotational_energy()
    }

    /// Its momentum [kg m/s, world].
    #[must_use]
    pub fn momentum(&self) -> D3 {
        scale(self.v, self.matter.mass)
    }

    /// Its angular momentum about the origin [kg m²/s, world].
    #[must_use]
    pub fn angular_momentum(&self) -> D3 {
        add(cross(self.center, self.momentum()), self.spin())
    }

    /// Velocity of the body's material at a point [m/s; m, world].
    #[must_use]
    pub fn velocity_at(&self, point: D3) -> D3 {
        add(self.v, cross(self.w, crate::numeric::sub(point, self.center)))
    }

    /// A local direction in the world [world].
    #[must_use]
    pub fn direction(&self, local: D3) -> D3 {
        rotate(self.state.pose.rotation, local)
    }
}

/// A scene running in an engine.
pub struct Run {
    /// The scene.
    pub scene: Scene,
    subject: Box<dyn Subject>,
    matter: Vec<Matter>,
    dt: f32,
    steps: u64,
}

impl core::fmt::Debug for Run {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.debug_struct("Run").field("scene", &self.scene.name).field("steps", &self.steps).finish()
    }
}

impl Run {
    /// Takes one step.
    pub fn step(&mut self) {
        self.subject.step(self.dt);
        self.steps += 1;
    }

    /// Steps until the time is `seconds`, and calls `each` after every step.
    pub fn until(&mut self, seconds: f64, mut each: impl FnMut(&Self)) {
        let end = whole(seconds / f64::from(self.dt));
        while self.steps < end {
            self.step();
            each(self);
        }
    }

    /// Time since the start [s]: number of steps over the rate, without rounding.
    #[must_use]
    pub fn time(&self) -> f64 {
        self.steps as f64 * f64::from(self.dt)
    }

    /// Pushes a body during the next step [N, world].
    ///
    /// # Errors
    /// Fails if the engine refuses it.
    pub fn push(&mut self, body: usize, force: Vec3) -> Result<(), EngineError> {
        self.subject.push(body, force, self.dt)
    }

    /// Force of the contacts on a body in the last substep [N, world].
    ///
    /// # Errors
    /// Fails if the engine does not report contact forces.
    pub fn contact_force(&self, body: usize) -> Result<D3, EngineError> {
        let force = self.subject.contact_force(body, self.dt);
        force.map(wide).ok_or_else(|| EngineError("contact forces are not read".to_owned()))
    }

    /// Current state of a body.
    #[must_use]
    pub fn body(&self, body: usize) -> Moment {
        let state = self.subject.state(body);
        let matter = self.matter[body];
        let center = add(wide(state.pose.position), rotate(state.pose.rotation, matter.center));
        let (v, w) = (wide(state.linear_velocity), wide(state.angular_velocity));
        Moment { state, center, v, w, matter }
    }

    /// Mass and inertia of a body.
    #[must_use]
    pub fn matter(&self, body: usize) -> Matter {
        self.matter[body]
    }

    /// Numbers of the dynamic bodies.
    pub fn dynamic(&self) -> impl Iterator<Item = usize> + '_ {
        let bodies = self.scene.bodies.iter().enumerate();
        bodies.filter(|(_, b)| b.def.kind == BodyKind::Dynamic).map(|(number, _)| number)
    }

    /// Gravity [m/s², world].
    #[must_use]
    pub fn gravity(&self) -> D3 {
        wide(self.scene.config.gravity)
    }

    /// Kinetic and potential energy of all bodies [J]; potential energy is zero at the origin.
    #[must_use]
    pub fn energy(&self) -> f64 {
        let g = self.gravity();
        let of = |body: usize| {
            let now = self.body(body);
            now.kinetic_energy() - self.matter[body].mass * dot(g, now.center)
        };
        self.dynamic().map(of).sum()
    }

    /// Momentum of all bodies [kg m/s, world].
    #[must_use]
    pub fn momentum(&self) -> D3 {
        self.dynamic().fold([0.0; 3], |sum, body| add(sum, self.body(body).momentum()))
    }

    /// Angular momentum of all bodies about the origin [kg m²/s, world].
    #[must_use]
    pub fn angular_momentum(&self) -> D3 {
        self.dynamic().fold([0.0; 3], |sum, body| add(sum, self.body(body).angular_momentum()))
    }

    /// Sum of the bodies' speeds times masses [kg m/s], the scale for drifts of momentum.
    #[must_use]
    pub fn momentum_scale(&self) -> f64 {
        self.dynamic().map(|body| norm(self.body(body).momentum())).sum()
    }

    fn states(&self) -> Vec<BodyState> {
        (0..self.scene.bodies.len()).map(|body| self.subject.state(body)).collect()
    }

    /// The maximum overlap [m] and maximum joint error [m] now, from poses alone.
    ///
    /// # Errors
    /// Fails if drystone, which measures them, refuses the scene.
    pub fn overlap(&self) -> Result<(f64, f64), EngineError> {
        let mut checker = Checker::new(&self.scene)?;
        let numbers: Vec<usize> = (0..self.scene.bodies.len()).collect();
        checker.look(&numbers, &self.states());
        Ok((checker.max_penetration(), checker.max_joint_error().unwrap_or(0.0)))
    }

    /// Whether all bodies still stand in place, by the criterion of the benchmarks.
    #[must_use]
    pub fn stands(&self) -> bool {
        let bodies: Vec<&SceneBody> = self.scene.bodies.iter().collect();
        still_stands(self.scene.config.gravity, &bodies, &self.states(), 0.0).unwrap_or(false)
    }

    /// Maximum displacement of a body from its initial position [m].
    #[must_use]
    pub fn drift(&self) -> f64 {
        let moved = |body: usize| {
            let start = wide(self.scene.bodies[body].def.position);
            norm(crate::numeric::sub(wide(self.subject.state(body).pose.position), start))
        };
        self.dynamic().map(moved).fold(0.0, worst)
    }

    /// Maximum displacement of a body perpendicular to gravity, and maximum descent of a body [m].
    #[must_use]
    pub fn drift_and_sag(&self) -> (f64, f64) {
        let down = scale(self.gravity(), 1.0 / norm(self.gravity()));
        let (mut drift, mut sag) = (0.0, 0.0);
        for body in self.dynamic() {
            let start = wide(self.scene.bodies[body].def.position);
            let moved = crate::numeric::sub(wide(self.subject.state(body).pose.position), start);
            let fallen = dot(moved, down);
            sag = worst(sag, fallen);
            drift = worst(drift, norm(crate::numeric::sub(moved, scale(down, fallen))));
        }
        (drift, sag)
    }
}
