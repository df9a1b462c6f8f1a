//! Box3D with the settings of its own benchmark program and 4 substeps. Coefficients, masses and
//! sleep settings come from the scene.

#![expect(unsafe_code, reason = "a C library")]

use core::f32::consts::FRAC_PI_2;
use core::time::Duration;

use drystone::config::SleepConfig;
use drystone::contact::Combine;
use drystone::{BodyKind, Hull, Material, Mesh, Pose, Quat, Shape, ShapeDef, Vec3, vec3};
use drystone_bench::{
    BodyState, Engine, EngineError, Linkage, StageClock, Stages, Turn, density_factor, linkages,
};
use drystone_scene::{Scene, SceneBody, Wave};

use box3d_sys as b3;

use crate::hulls::Shared;
use crate::queries::Asked;

/// Substeps per step, as in its benchmark program.
const SUBSTEPS: i32 = 4;
/// Half extents of the box that replaces a half space [m].
const GROUND: Vec3 = vec3(500.0, 10.0, 500.0);

/// Box3D.
pub(crate) struct Box3d {
    world: b3::b3WorldId,
    bodies: Vec<b3::b3BodyId>,
    hulls: Shared<*mut b3::b3HullData>,
    meshes: Shared<*mut b3::b3MeshData>,
    sleep: SleepConfig,
    /// The stage times that Box3D reports.
    clock: StageClock,
}

impl Drop for Box3d {
    fn drop(&mut self) {
        // SAFETY: made in `build`, destroyed once. Hulls and meshes live until the process ends.
        unsafe { b3::b3DestroyWorld(self.world) }
    }
}

impl Engine for Box3d {
    const NAME: &'static str = "box3d";

    fn version() -> String {
        // SAFETY: no arguments.
        let version = unsafe { b3::b3GetVersion() };
        let (major, minor, revision) = (version.major, version.minor, version.revision);
        format!("{major}.{minor}.{revision} (box3d-sys {})", crate::versions::BOX3D_SYS)
    }

    fn build(scene: &Scene, threads: usize) -> Result<Self, EngineError> {
        let count = |kind: BodyKind| {
            let bodies = scene.bodies.iter().filter(|b| b.def.kind == kind);
            bodies.fold((0, 0), |(n, shapes), b| (n + 1, shapes + b.def.shapes.len()))
        };
        let (fixed, dynamic) = (count(BodyKind::Static), count(BodyKind::Dynamic));
        // SAFETY: no arguments.
        let mut def = unsafe { b3::b3DefaultWorldDef() };
        def.gravity = vector(scene.config.gravity);
        def.enableSleep = scene.config.sleep.enabled;
        def.workerCount = u32::try_from(threads).map_err(|e| EngineError(e.to_string()))?;
        // Its benchmark program also gives capacities, so that no table grows during timed steps.
        def.capacity.staticBodyCount = int(fixed.0)?;
        def.capacity.staticShapeCount = int(fixed.1)?;
        def.capacity.dynamicBodyCount = int(dynamic.0)?;
        def.capacity.dynamicShapeCount = int(dynamic.1)?;
        def.capacity.contactCount = int(8 * dynamic.0)?;
        // SAFETY: the definition is complete and outlives the call.
        let world = unsafe { b3::b3CreateWorld(&raw const def) };
        let mut this = Self {
            world,
            bodies: Vec::with_capacity(scene.bodies.len()),
            hulls: Shared::default(),
            meshes: Shared::default(),
            sleep: scene.config.sleep,
            clock: StageClock::new(),
        };
        for body in &scene.bodies {
            this.add(body)?;
        }
        linkages(&scene.joints)?.iter().for_each(|linkage| this.link(linkage));
        // SAFETY: the world lives. Static trees are balanced before timing begins, as in the other
        // engines.
        unsafe { b3::b3World_RebuildStaticTree(world) };
        Ok(this)
    }

    fn add(&mut self, body: &SceneBody) -> Result<(), EngineError> {
        let from = &body.def;
        if from.locks.any() || from.asleep {
            let what = "locked axes and sleeping starts are not translated";
            return Err(EngineError(what.to_owned()));
        }
        // SAFETY: no arguments.
        let mut def = unsafe { b3::b3DefaultBodyDef() };
        def.type_ = match from.kind {
            BodyKind::Static => b3::b3BodyType_b3_staticBody,
            BodyKind::Kinematic => b3::b3BodyType_b3_kinematicBody,
            BodyKind::Dynamic => b3::b3BodyType_b3_dynamicBody,
        };
        def.position = vector(from.position);
        def.rotation = quaternion(from.rotation);
        def.linearDamping = from.linear_damping;
        def.angularDamping = from.angular_damping;
        def.gravityScale = from.gravity_scale;
        def.enableSleep = from.can_sleep;
        def.sleepThreshold = from.sleep_speed.unwrap_or(self.sleep.speed);
        // SAFETY: the world lives; the definition outlives the call.
        let id = unsafe { b3::b3CreateBody(self.world, &raw const def) };
        let factor = density_factor(from)?;
        for (i, shape) in from.shapes.iter().enumerate() {
            let last = i + 1 == from.shapes.len();
            self.add_shape(id, shape, factor, last)?;
        }
        // Velocities in the definition would be those of the origin, and change with the center of
        // mass.
        if from.kind != BodyKind::Static {
            // SAFETY: the body lives.
            unsafe { b3::b3Body_SetLinearVelocity(id, vector(from.linear_velocity)) };
            // SAFETY: the body lives.
            unsafe { b3::b3Body_SetAngularVelocity(id, vector(from.angular_velocity)) };
        }
        self.bodies.push(id);
        Ok(())
    }

    fn aim(&mut self, body: usize, position: Vec3, dt: f32) -> Result<(), EngineError> {
        let target = transform(&Pose { rotation: self.state(body).pose.rotation, position });
        // SAFETY: the body lives.
        unsafe { b3::b3Body_SetTargetTransform(self.bodies[body], target, dt, true) };
        Ok(())
    }

    fn bring(&mut self, wave: &Wave) -> Result<(), EngineError> {
        for id in &self.bodies[wave.removed.clone()] {
            // SAFETY: the body lives, because a removed body is not named again.
            unsafe { b3::b3DestroyBody(*id) };
        }
        wave.bodies.iter().try_for_each(|body| self.add(body))?;
        linkages(&wave.joints)?.iter().for_each(|linkage| self.link(linkage));
        Ok(())
    }

    fn push(&mut self, body: usize, force: Vec3, _: f32) -> Result<(), EngineError> {
        // SAFETY: the body lives. The force acts in the next step only.
        unsafe { b3::b3Body_ApplyForceToCenter(self.bodies[body], vector(force), true) };
        Ok(())
    }

    fn step(&mut self, dt: f32) {
        // SAFETY: the world lives.
        unsafe { b3::b3World_Step(self.world, dt, SUBSTEPS) };
        // SAFETY: as above; the result is copied.
        let told = unsafe { b3::b3World_GetProfile(self.world) };
        // `solver` matches our stage: the plan and all work on constraints.
        let stages = [
            ("pairs", told.pairs),
            ("collide", told.collide),
            ("solver", told.solverSetup + told.constraints),
            ("transforms", told.transforms),
            ("refit", told.refit),
        ];
        for (name, ms) in stages {
            self.clock.add(name, Duration::from_secs_f64(1.0e-3 * f64::from(ms).max(0.0)));
        }
    }

    fn state(&self, body: usize) -> BodyState {
        let id = self.bodies[body];
        // SAFETY: the body lives.
        let transform = unsafe { b3::b3Body_GetTransform(id) };
        // SAFETY: the body lives.
        let v = unsafe { b3::b3Body_GetLinearVelocity(id) };
        // SAFETY: the body lives.
        let w = unsafe { b3::b3Body_GetAngularVelocity(id) };
        let own = |v: b3::b3Vec3| vec3(v.x, v.y, v.z);
        let q = transform.q;
        BodyState {
            pose: Pose {
                position: own(transform.p),
                rotation: Quat::new(q.v.x, q.v.y, q.v.z, q.s),
            },
            linear_velocity: own(v),
            angular_velocity: own(w),
        }
    }

    fn restart_clock(&mut self) {
        self.clock = StageClock::new();
    }

    fn stages_ms(&self, steps: u64) -> Option<Stages> {
        Some(self.clock.stages(steps))
    }

    fn simd(&self) -> String {
        "4 lanes, sse2".to_owned()
    }
}

impl Box3d {
    fn link(&mut self, linkage: &Linkage) {
        // Its joint axes are z.
        let axes = Quat::from_axis_angle(Vec3::Y, FRAC_PI_2);
        let frame = |pose: &Pose| transform(&Pose::new(pose.position, pose.rotation * axes));
        let base = |mut base: b3::b3JointDef| {
            base.bodyIdA = self.bodies[linkage.bodies[0]];
            base.bodyIdB = self.bodies[linkage.bodies[1]];
            base.localFrameA = frame(&linkage.frames[0]);
            base.localFrameB = frame(&linkage.frames[1]);
            base.collideConnected = linkage.collide_connected;
            base
        };
        let (hertz, ratio) = linkage.spring.unwrap_or_default();
        match linkage.turn {
            Turn::Ball { cone, twist } => {
                // SAFETY: no arguments.
                let mut def = unsafe { b3::b3DefaultSphericalJointDef() };
                def.base = base(def.base);
                def.enableConeLimit = cone.is_some();
                // Its cones are round: as wide as ours at their widest.
                def.coneAngle = cone.map_or(0.0, |[y, z]| y.max(z));
                def.enableTwistLimit = twist.is_some();
                [def.lowerTwistAngle, def.upperTwistAngle] = twist.unwrap_or_default();
                def.enableMotor = linkage.friction > 0.0;
                def.maxMotorTorque = linkage.friction;
                def.enableSpring = linkage.spring.is_some();
                (def.hertz, def.dampingRatio) = (hertz, ratio);
                // SAFETY: the world and its bodies live; the definition outlives the call.
                unsafe { b3::b3CreateSphericalJoint(self.world, &raw const def) };
            }
            Turn::Hinge { limits } => {
                // SAFETY: no arguments.
                let mut def = unsafe { b3::b3DefaultRevoluteJointDef() };
                def.base = base(def.base);
                def.enableLimit = limits.is_some();
                [def.lowerAngle, def.upperAngle] = limits.unwrap_or_default();
                def.enableMotor = linkage.friction > 0.0;
                def.maxMotorTorque = linkage.friction;
                def.enableSpring = linkage.spring.is_some();
                (def.hertz, def.dampingRatio) = (hertz, ratio);
                // SAFETY: as above.
                unsafe { b3::b3CreateRevoluteJoint(self.world, &raw const def) };
            }
        }
    }

    fn add_shape(
        &mut self,
        body: b3::b3BodyId,
        from: &ShapeDef,
        factor: f32,
        last: bool,
    ) -> Result<(), EngineError> {
        let Material { friction, restitution, rolling_resistance, friction_combine, .. } =
            from.material;
        let usual = (Combine::GeometricMean, Combine::Maximum);
        if (friction_combine, from.material.restitution_combine) != usual {
            return Err(EngineError("its rules for combining materials are fixed".to_owned()));
        }
        // SAFETY: no arguments.
        let mut def = unsafe { b3::b3DefaultShapeDef() };
        def.density = from.density * factor;
        def.baseMaterial.friction = friction;
        def.baseMaterial.restitution = restitution;
        def.baseMaterial.rollingResistance = rolling_resistance;
        def.filter.categoryBits = from.filter.layers;
        def.filter.maskBits = from.filter.mask & !from.filter.exclude;
        def.isSensor = from.sensor;
        // The mass is computed once, with the last shape.
        def.updateBodyMass = last;
        let def = &raw const def;
        let place = transform(&from.pose);
        match &from.shape {
            Shape::Sphere { radius } => {
                let ball = b3::b3Sphere { center: vector(from.pose.position), radius: *radius };
                // SAFETY: the body lives; definition and shape outlive the call.
                unsafe { b3::b3CreateSphereShape(body, def, &raw const ball) };
            }
            Shape::Capsule { half_height, radius } => {
                let end = vec3(0.0, *half_height, 0.0);
                let capsule = b3::b3Capsule {
                    center1: vector(from.pose.point(-end)),
                    center2: vector(from.pose.point(end)),
                    radius: *radius,
                };
                // SAFETY: as above.
                unsafe { b3::b3CreateCapsuleShape(body, def, &raw const capsule) };
            }
            Shape::Box { half_extents } => add_box(body, def, *half_extents, place),
            Shape::HalfSpace { normal, offset } => {
                let turn = Quat::from_arc(Vec3::Y, *normal);
                let middle = *normal * (*offset - GROUND.y);
                let place = from.pose.compose(&Pose { position: middle, rotation: turn });
                add_box(body, def, GROUND, transform(&place));
            }
            Shape::Hull(hull) => {
                let made = self.hulls.hull(hull, || make_hull(hull))?;
                // SAFETY: as above; the hull lives until the process ends.
                unsafe {
                    b3::b3CreateTransformedHullShape(body, def, made, place, vector(Vec3::ONE))
                };
            }
            Shape::Mesh(mesh) if from.pose == Pose::IDENTITY => {
                let made = self.meshes.mesh(mesh, || make_mesh(mesh))?;
                // SAFETY: as above; the mesh lives until the process ends.
                unsafe { b3::b3CreateMeshShape(body, def, made, vector(Vec3::ONE)) };
            }
            other => return Err(EngineError(format!("it has no shape for a {}", other.kind()))),
        }
        Ok(())
    }
}

fn add_box(body: b3::b3BodyId, def: *const b3::b3ShapeDef, half: Vec3, place: b3::b3Transform) {
    // SAFETY: takes numbers; returns a hull by value.
    let made = unsafe { b3::b3MakeTransformedBoxHull(half.x, half.y, half.z, place) };
    // SAFETY: the body lives; definition and hull outlive the call, which copies the hull.
    unsafe { b3::b3CreateHullShape(body, def, &raw const made.base) };
}

fn make_hull(hull: &Hull) -> Option<*mut b3::b3HullData> {
    let points: Vec<b3::b3Vec3> = hull.vertices().iter().map(|v| vector(*v)).collect();
    let count = i32::try_from(points.len()).ok()?;
    // SAFETY: the points outlive the call, `count` is their number.
    let made = unsafe { b3::b3CreateHull(points.as_ptr(), count, count) };
    (!made.is_null()).then_some(made)
}

fn make_mesh(mesh: &Mesh) -> Option<*mut b3::b3MeshData> {
    let mut vertices: Vec<b3::b3Vec3> = mesh.vertices().iter().map(|v| vector(*v)).collect();
    let indices = mesh.triangles().iter().flatten().map(|i| i32::try_from(*i).ok());
    let mut indices: Vec<i32> = indices.collect::<Option<_>>()?;
    let def = b3::b3MeshDef {
        vertices: vertices.as_mut_ptr(),
        indices: indices.as_mut_ptr(),
        vertexCount: i32::try_from(vertices.len()).ok()?,
        triangleCount: i32::try_from(mesh.triangles().len()).ok()?,
        identifyEdges: true,
        useMedianSplit: true,
        ..b3::b3MeshDef::default()
    };
    // SAFETY: vertices and indices outlive the call, and their counts are correct.
    let made = unsafe { b3::b3CreateMesh(&raw const def, core::ptr::null_mut(), 0) };
    (!made.is_null()).then_some(made)
}

fn int(n: usize) -> Result<i32, EngineError> {
    i32::try_from(n).map_err(|_| EngineError(format!("{n} bodies are too many")))
}

const fn vector(v: Vec3) -> b3::b3Vec3 {
    b3::b3Vec3 { x: v.x, y: v.y, z: v.z }
}

const fn quaternion(q: Quat) -> b3::b3Quat {
    b3::b3Quat { v: b3::b3Vec3 { x: q.x, y: q.y, z: q.z }, s: q.w }
}

const fn transform(pose: &Pose) -> b3::b3Transform {
    b3::b3Transform { p: vector(pose.position), q: quaternion(pose.rotation) }
}

/// Stores the fraction of the nearest hit so far, and shortens the cast to it.
unsafe extern "C" fn nearest(
    _: b3::b3ShapeId,
    _: b3::b3Pos,
    _: b3::b3Vec3,
    fraction: f32,
    _: u64,
    _: i32,
    _: i32,
    least: *mut core::ffi::c_void,
) -> f32 {
    // SAFETY: the pointer from `cast`, to a number that outlives the call and is not shared.
    unsafe { *least.cast::<f32>() = fraction };
    fraction
}

/// Counts shapes.
unsafe extern "C" fn count(_: b3::b3ShapeId, found: *mut core::ffi::c_void) -> bool {
    // SAFETY: the pointer from `overlap`, to a number that outlives the call and is not shared.
    unsafe { *found.cast::<u32>() += 1 };
    true
}

impl Asked for Box3d {
    fn ray(&self, origin: Vec3, delta: Vec3) -> f32 {
        // SAFETY: no arguments.
        let all = unsafe { b3::b3DefaultQueryFilter() };
        // SAFETY: the world lives.
        let hit =
            unsafe { b3::b3World_CastRayClosest(self.world, vector(origin), vector(delta), all) };
        if hit.hit { hit.fraction } else { 1.0 }
    }

    fn cast(&self, radius: f32, origin: Vec3, delta: Vec3) -> f32 {
        let (center, mut least) = (vector(Vec3::ZERO), 1.0_f32);
        let ball = b3::b3ShapeProxy { points: &raw const center, count: 1, radius };
        let to = (&raw mut least).cast();
        // SAFETY: no arguments.
        let all = unsafe { b3::b3DefaultQueryFilter() };
        let (at, way) = (vector(origin), vector(delta));
        // SAFETY: the world lives; the ball and the number outlive the call.
        unsafe {
            b3::b3World_CastShape(self.world, at, &raw const ball, way, all, Some(nearest), to)
        };
        least
    }

    fn overlap(&self, radius: f32, at: Vec3) -> u32 {
        let (center, mut found) = (vector(Vec3::ZERO), 0_u32);
        let ball = b3::b3ShapeProxy { points: &raw const center, count: 1, radius };
        let to = (&raw mut found).cast();
        // SAFETY: no arguments.
        let all = unsafe { b3::b3DefaultQueryFilter() };
        // SAFETY: the world lives; the ball and the number outlive the call.
        unsafe {
            b3::b3World_OverlapShape(self.world, vector(at), &raw const ball, all, Some(count), to)
        };
        found
    }
}
