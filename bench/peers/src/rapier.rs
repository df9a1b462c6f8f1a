//! rapier3d with its default solver settings. Coefficients, masses and sleep settings come from the
//! scene.

use drystone::contact::Combine;
use drystone::{BodyKind, Material, Pose, Quat, Shape, ShapeDef, Vec3};
use drystone_bench::{BodyState, Engine, EngineError, Linkage, Turn, density_factor, linkages};
use drystone_scene::{Scene, SceneBody, Wave};
use rapier3d::prelude as rapier;
use rapier3d::prelude::CoefficientCombineRule as Rule;

use crate::hulls::Shared;
use crate::queries::Asked;

/// Ratio of friction torque to speed for a joint that friction holds still [1/s]: far above
/// anything a step resolves.
const STIFF: f32 = 1.0e6;

/// rapier3d.
pub(crate) struct Rapier {
    world: rapier::PhysicsWorld,
    bodies: Vec<rapier::RigidBodyHandle>,
    shapes: Shared<rapier::SharedShape>,
    sleep: drystone::config::SleepConfig,
    /// Bodies with a force for the next step: rapier's forces last until they are removed.
    pushed: Vec<rapier::RigidBodyHandle>,
}

impl Engine for Rapier {
    const NAME: &'static str = "rapier";

    fn version() -> String {
        crate::versions::RAPIER.to_owned()
    }

    fn build(scene: &Scene, threads: usize) -> Result<Self, EngineError> {
        let mut world =
            rapier::PhysicsWorld { gravity: vector(scene.config.gravity), ..Default::default() };
        world.integration_parameters.dt = scene.hz.recip();
        world
            .physics_pipeline
            .configure_thread_pool(threads)
            .map_err(|e| EngineError(format!("threads: {e}")))?;
        let mut this = Self {
            world,
            bodies: Vec::new(),
            shapes: Shared::default(),
            sleep: scene.config.sleep,
            pushed: Vec::new(),
        };
        for body in &scene.bodies {
            this.add(body)?;
        }
        linkages(&scene.joints)?.iter().for_each(|linkage| this.link(linkage));
        Ok(this)
    }

    fn add(&mut self, body: &SceneBody) -> Result<(), EngineError> {
        let def = &body.def;
        let builder = match def.kind {
            BodyKind::Static => rapier::RigidBodyBuilder::fixed(),
            BodyKind::Kinematic => rapier::RigidBodyBuilder::kinematic_velocity_based(),
            BodyKind::Dynamic => rapier::RigidBodyBuilder::dynamic(),
        };
        let builder = builder
            .pose(pose(&Pose::new(def.position, def.rotation)))
            .linvel(vector(def.linear_velocity))
            .angvel(vector(def.angular_velocity))
            .gravity_scale(def.gravity_scale)
            .linear_damping(def.linear_damping)
            .angular_damping(def.angular_damping)
            .can_sleep(self.sleep.enabled && def.can_sleep);
        if def.locks.any() || def.asleep {
            return Err(EngineError(
                "locked axes and sleeping starts are not translated".to_owned(),
            ));
        }
        let mut built = builder.build();
        if self.sleep.enabled && def.can_sleep {
            let activation = built.activation_mut();
            activation.normalized_linear_threshold = def.sleep_speed.unwrap_or(self.sleep.speed);
            activation.time_until_sleep = self.sleep.time;
        }
        let handle = self.world.bodies.insert(built);
        let factor = density_factor(def)?;
        for shape in &def.shapes {
            let collider = self.collider(shape, factor)?;
            let world = &mut self.world;
            world.colliders.insert_with_parent(collider, handle, &mut world.bodies);
        }
        self.bodies.push(handle);
        Ok(())
    }

    fn aim(&mut self, body: usize, position: Vec3, dt: f32) -> Result<(), EngineError> {
        let handle = self.bodies[body];
        if let Some(body) = self.world.bodies.get_mut(handle) {
            let velocity = (vector(position) - body.translation()) / dt;
            body.set_linvel(velocity, true);
            body.set_angvel(vector(Vec3::ZERO), true);
        }
        Ok(())
    }

    fn bring(&mut self, wave: &Wave) -> Result<(), EngineError> {
        for handle in &self.bodies[wave.removed.clone()] {
            self.world.remove_body(*handle);
        }
        wave.bodies.iter().try_for_each(|body| self.add(body))?;
        linkages(&wave.joints)?.iter().for_each(|linkage| self.link(linkage));
        Ok(())
    }

    fn push(&mut self, body: usize, force: Vec3, _: f32) -> Result<(), EngineError> {
        let handle = self.bodies[body];
        if let Some(body) = self.world.bodies.get_mut(handle) {
            body.add_force(vector(force), true);
            self.pushed.push(handle);
        }
        Ok(())
    }

    fn step(&mut self, dt: f32) {
        self.world.integration_parameters.dt = dt;
        self.world.step();
        for handle in self.pushed.drain(..) {
            if let Some(body) = self.world.bodies.get_mut(handle) {
                body.reset_forces(false);
            }
        }
    }

    fn state(&self, body: usize) -> BodyState {
        let body = &self.world.bodies[self.bodies[body]];
        let (p, q) = (body.translation(), body.rotation());
        let own = |v: rapier::Vector| drystone::vec3(v.x, v.y, v.z);
        BodyState {
            pose: Pose { position: own(p), rotation: Quat::new(q.x, q.y, q.z, q.w) },
            linear_velocity: own(body.linvel()),
            angular_velocity: own(body.angvel()),
        }
    }

    fn simd(&self) -> String {
        "8 lanes, native".to_owned()
    }
}

impl Rapier {
    /// Adds a joint. rapier has one limit and one motor per axis, so a spring is a separate joint.
    /// It has no cone, so each swing axis has its own limit.
    fn link(&mut self, linkage: &Linkage) {
        use rapier::JointAxis::{AngX, AngY, AngZ};
        let (locked, free, about_x, cone) = match linkage.turn {
            Turn::Ball { cone, twist } => {
                let locked = rapier::JointAxesMask::LOCKED_SPHERICAL_AXES;
                (locked, &[AngX, AngY, AngZ][..], twist, cone)
            }
            Turn::Hinge { limits } => {
                (rapier::JointAxesMask::LOCKED_REVOLUTE_AXES, &[AngX][..], limits, None)
            }
        };
        let joint = |locked| {
            rapier::GenericJointBuilder::new(locked)
                .local_frame1(pose(&linkage.frames[0]))
                .local_frame2(pose(&linkage.frames[1]))
                .contacts_enabled(linkage.collide_connected)
        };
        let mut held = joint(locked);
        if let Some([y, z]) = cone {
            held = held.limits(AngY, [-y, y]).limits(AngZ, [-z, z]);
        }
        if let Some(limits) = about_x {
            held = held.limits(AngX, limits);
        }
        if linkage.friction > 0.0 {
            for axis in free {
                held =
                    held.motor_velocity(*axis, 0.0, STIFF).motor_max_force(*axis, linkage.friction);
            }
        }
        let [a, b] = linkage.bodies.map(|number| self.bodies[number]);
        self.world.insert_impulse_joint(a, b, held.build());
        if let Some((hertz, ratio)) = linkage.spring {
            let omega = core::f32::consts::TAU * hertz;
            let mut spring = joint(rapier::JointAxesMask::empty());
            for axis in free {
                spring = spring
                    .motor_model(*axis, rapier::MotorModel::AccelerationBased)
                    .motor_position(*axis, 0.0, omega * omega, 2.0 * ratio * omega);
            }
            self.world.insert_impulse_joint(a, b, spring.build());
        }
    }

    fn collider(&mut self, def: &ShapeDef, factor: f32) -> Result<rapier::Collider, EngineError> {
        let mut place = def.pose;
        let shape = match &def.shape {
            Shape::Sphere { radius } => rapier::SharedShape::ball(*radius),
            Shape::Capsule { half_height, radius } => {
                rapier::SharedShape::capsule_y(*half_height, *radius)
            }
            Shape::Box { half_extents: h } => rapier::SharedShape::cuboid(h.x, h.y, h.z),
            Shape::Cylinder { half_height, radius } => {
                rapier::SharedShape::cylinder(*half_height, *radius)
            }
            Shape::Cone { half_height, radius_bottom, radius_top } if *radius_top == 0.0 => {
                rapier::SharedShape::cone(*half_height, *radius_bottom)
            }
            Shape::HalfSpace { normal, offset } => {
                place.position = place.point(*normal * *offset);
                rapier::SharedShape::halfspace(vector(*normal))
            }
            Shape::Hull(hull) => self.shapes.hull(hull, || {
                let points: Vec<rapier::Vector> =
                    hull.vertices().iter().map(|v| vector(*v)).collect();
                rapier::SharedShape::convex_hull(&points)
            })?,
            Shape::Mesh(mesh) => self.shapes.mesh(mesh, || {
                let vertices = mesh.vertices().iter().map(|v| vector(*v)).collect();
                rapier::SharedShape::trimesh(vertices, mesh.triangles().to_vec()).ok()
            })?,
            other => return Err(EngineError(format!("a {} is not translated", other.kind()))),
        };
        let Material { friction, restitution, friction_combine, restitution_combine, .. } =
            def.material;
        Ok(rapier::ColliderBuilder::new(shape)
            .position(pose(&place))
            .density(def.density * factor)
            .friction(friction)
            .friction_combine_rule(rule(friction_combine))
            .restitution(restitution)
            .restitution_combine_rule(rule(restitution_combine))
            .collision_groups(groups(def.filter)?)
            .sensor(def.sensor)
            .build())
    }
}

const fn rule(combine: Combine) -> Rule {
    match combine {
        Combine::GeometricMean => Rule::GeometricMean,
        Combine::Multiply => Rule::Multiply,
        Combine::Maximum => Rule::Max,
        Combine::Minimum => Rule::Min,
        Combine::Average => Rule::Average,
    }
}

/// Layers as rapier's groups, of which there are 32.
fn groups(filter: drystone::Filter) -> Result<rapier::InteractionGroups, EngineError> {
    let few = |bits: u64| u32::try_from(bits);
    let (Ok(layers), Ok(mask)) =
        (few(filter.layers), few(filter.mask & !filter.exclude & 0xffff_ffff))
    else {
        return Err(EngineError("a filter has more than 32 layers".to_owned()));
    };
    let group = rapier::Group::from_bits_truncate;
    let mode = rapier::InteractionTestMode::And;
    Ok(rapier::InteractionGroups::new(group(layers), group(mask), mode))
}

const fn vector(v: Vec3) -> rapier::Vector {
    rapier::Vector::new(v.x, v.y, v.z)
}

fn pose(pose: &Pose) -> rapier::Pose {
    let q = pose.rotation;
    let rotation = rapier::Rotation::from_xyzw(q.x, q.y, q.z, q.w);
    rapier::Pose::from_parts(vector(pose.position), rotation)
}

impl Rapier {
    fn asked(&self) -> rapier::QueryPipeline<'_> {
        let world = &self.world;
        let how = world.narrow_phase.query_dispatcher();
        let filter = rapier::QueryFilter::default();
        world.broad_phase.as_query_pipeline(how, &world.bodies, &world.colliders, filter)
    }
}

impl Asked for Rapier {
    fn ray(&self, origin: Vec3, delta: Vec3) -> f32 {
        let ray = rapier::Ray::new(vector(origin), vector(delta));
        // With the normal, which the other engines also return.
        let hit = self.asked().cast_ray_and_get_normal(&ray, 1.0, true);
        hit.map_or(1.0, |(_, hit)| hit.time_of_impact)
    }

    fn cast(&self, radius: f32, origin: Vec3, delta: Vec3) -> f32 {
        let how = rapier3d::parry::query::ShapeCastOptions::with_max_time_of_impact(1.0);
        let ball = rapier::Ball::new(radius);
        let hit = self.asked().cast_shape(&pose(&Pose::at(origin)), vector(delta), &ball, how);
        hit.map_or(1.0, |(_, hit)| hit.time_of_impact)
    }

    fn overlap(&self, radius: f32, center: Vec3) -> u32 {
        let found = self.asked();
        let found =
            found.intersect_shape(pose(&Pose::at(center)), &rapier::Ball::new(radius)).count();
        u32::try_from(found).unwrap_or(u32::MAX)
    }
}
