//! What lies on a body that turns goes round with it, whether that body is carried by itself or by nothing: at any size, step and
//! weight.

use drystone::joint::Hinge;
use drystone::{BodyDef, BodyId, JointDef, ShapeDef, Vec3, World, vec3};

const GRAVITY: f32 = 9.81;

/// A cube at 1.5 sizes from the axis of a plate of 2 sizes that turns about a hinge without friction.
struct Table {
    world: World,
    plate: BodyId,
    cube: BodyId,
    size: f32,
}

impl Table {
    /// `density` is that of the cube [kg/m³], the plate's is 1000. Both turn at `speed` [rad/s].
    fn new(size: f32, density: f32, speed: f32, friction: f32) -> Self {
        let mut world = World::default();
        let mut config = world.config().clone();
        config.length_scale = size;
        world.set_config(config).unwrap();
        let spin = vec3(0.0, speed, 0.0);
        let plate = ShapeDef::cylinder(0.05 * size, 2.0 * size).with_friction(friction);
        let plate = BodyDef::dynamic().with_shape(plate).with_angular_velocity(spin);
        let plate = world.add_body(plate).unwrap();
        let ground = world.add_body(BodyDef::fixed()).unwrap();
        let axle = JointDef::new(ground, plate, Hinge::new()).at(Vec3::ZERO).with_axis(Vec3::Y);
        world.add_joint(axle).unwrap();
        let at = vec3(1.5 * size, 0.175 * size, 0.0);
        let cube = ShapeDef::box_half([0.125 * size; 3]).with_friction(friction);
        let cube = BodyDef::dynamic().with_shape(cube.with_density(density)).with_position(at);
        let cube = cube.with_linear_velocity(spin.cross(at)).with_angular_velocity(spin);
        let cube = world.add_body(cube).unwrap();
        Self { world, plate, cube, size }
    }

    /// How far the cube is from the axis, in sizes.
    fn radius(&self) -> f32 {
        let at = self.world.body(self.cube).unwrap().position();
        vec3(at.x, 0.0, at.z).length() / self.size
    }

    fn speed(&self) -> f32 {
        self.world.body(self.plate).unwrap().angular_velocity().y
    }
}

#[test]
fn what_lies_on_a_plate_that_turns_freely_goes_round_with_it() {
    for (size, hertz) in [(1.0, 30.0), (1.0, 60.0), (1.0, 120.0), (0.01, 60.0), (100.0, 60.0)] {
        // The cube has a hundredth of the plate's moment of inertia about the axis, or half of it.
        for density in [720.0, 36_000.0] {
            // Froude's law: at all sizes friction bears the same part of what it can.
            let speed = 2.0 / f32::sqrt(size);
            let mut table = Table::new(size, density, speed, 1.0);
            let dt = f32::sqrt(size) / hertz;
            let steps = 0..(10.0 / (dt * speed) * 2.0) as u32;
            steps.for_each(|_| table.world.step(dt));
            let of = format!("size {size}, {hertz} Hz, {density} kg/m³");
            // Nothing brakes and nothing drives. Rows frozen in the middle of a step of the angle θ err by θ²/24 in length and
            // direction, 2e-4 at 30 Hz; without them the cube went out by θ/2 of its radius with each radian, which is 0.6 here.
            let (radius, ratio) = (table.radius(), table.speed() / speed);
            assert!((radius - 1.5).abs() < 1.5e-3, "{of}: {radius}");
            assert!((ratio - 1.0).abs() < 1.0e-3, "{of}: {ratio}");
        }
    }
}

#[test]
fn what_friction_cannot_hold_slips_off_a_plate_that_turns() {
    // It holds up to √(µ g / r): 1.98 rad/s.
    for (speed, holds) in [(1.9, true), (2.1, false)] {
        let mut table = Table::new(1.0, 720.0, speed, 0.6);
        assert!((f32::sqrt(0.6 * GRAVITY / 1.5) - 1.98).abs() < 0.01);
        (0..600).for_each(|_| table.world.step(1.0 / 60.0));
        assert_eq!((table.radius() - 1.5).abs() < 0.01, holds, "{}", table.radius());
    }
}
