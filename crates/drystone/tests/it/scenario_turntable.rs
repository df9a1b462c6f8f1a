//! Bodies on a rotating body move with it, whether it is kinematic or free: at any size, step and
//! weight.

use drystone::joint::Hinge;
use drystone::{BodyDef, BodyId, JointDef, ShapeDef, Vec3, World, vec3};

const GRAVITY: f32 = 9.81;

/// A plate of 2 sizes that rotates about a hinge without friction. Two cubes are at 1.5 sizes from
/// the axis, on opposite sides so that nothing tilts.
struct Table {
    world: World,
    plate: BodyId,
    cubes: [BodyId; 2],
    size: f32,
    began: f32,
}

impl Table {
    /// `density` is that of the cubes [kg/m³]; the plate's is 1000. All rotate at `speed` [rad/s].
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
        let cubes = [1.5, -1.5].map(|x| {
            let at = vec3(x * size, 0.175 * size, 0.0);
            let cube = ShapeDef::box_half([0.125 * size; 3]).with_friction(friction);
            let cube = BodyDef::dynamic().with_shape(cube.with_density(density)).with_position(at);
            let cube = cube.with_linear_velocity(spin.cross(at)).with_angular_velocity(spin);
            world.add_body(cube).unwrap()
        });
        Self { world, plate, cubes, size, began: speed }
    }

    /// Steps until the table has rotated by `angle` [rad] at its initial speed.
    fn turn(&mut self, angle: f32, dt: f32) {
        let mut turned = 0.0;
        while turned < angle {
            self.world.step(dt);
            turned += self.began * dt;
        }
    }

    /// Distance of each cube from the axis, in sizes.
    fn radii(&self) -> [f32; 2] {
        self.cubes.map(|cube| {
            let at = self.world.body(cube).unwrap().position();
            vec3(at.x, 0.0, at.z).length() / self.size
        })
    }

    fn speed(&self) -> f32 {
        self.world.body(self.plate).unwrap().angular_velocity().y
    }
}

#[test]
fn what_lies_on_a_plate_that_turns_freely_goes_round_with_it() {
    // 0.033 rad per step at most. At twice that a cube rocks, on a kinematic plate as well, if its
    // friction is six tenths of the force that tips it.
    for (size, hertz, speed) in [
        (1.0, 30.0, 1.0),
        (1.0, 60.0, 2.0),
        (1.0, 120.0, 2.0),
        (0.01, 60.0, 2.0),
        (100.0, 60.0, 2.0),
    ] {
        // Both cubes have this part of the plate's moment of inertia about the axis.
        for (density, part) in [(720.0, 0.02), (3600.0, 0.1)] {
            // Froude's law: at all sizes friction carries the same fraction of its limit.
            let speed = speed / f32::sqrt(size);
            let mut table = Table::new(size, density, speed, 1.0);
            let dt = f32::sqrt(size) / hertz;
            // In the first radian friction adapts to its load.
            table.turn(1.0, dt);
            let began = table.radii();
            table.turn(20.0, dt);
            let of = format!("size {size}, {hertz} Hz, {density} kg/m³");
            // Nothing brakes or drives. With the rows of a step's start and an angle θ per step,
            // the cubes drift outward by θ/2 of their radius per radian. They drive the plate by
            // θ/2 of their fraction of its inertia.
            let first_order = 20.0 * 0.5 * speed * dt;
            let (radii, ratio) = (table.radii(), table.speed() / speed);
            let drifts = [0, 1].map(|i| radii[i] - began[i]);
            assert!(
                drifts.iter().all(|drift| drift.abs() < 0.01 * 1.5 * first_order),
                "{of}: {began:?} {radii:?}"
            );
            assert!((ratio - 1.0).abs() < 0.1 * part * first_order, "{of}: {ratio}");
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
        let radii = table.radii();
        assert!(radii.iter().all(|r| ((r - 1.5).abs() < 0.01) == holds), "{radii:?}");
    }
}
