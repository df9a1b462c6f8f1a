//! Bouncing bodies on joints: an impact takes energy, and a bounce returns no more than that.

use drystone::method::Method;
use drystone::{BodyDef, JointDef, JointKind, Quat, ShapeDef, Vec3, World, WorldConfig, vec3};

const DT: f32 = 1.0 / 60.0;

/// A drop takes a second.
const STEPS: u32 = 60;

/// Two bricks with a ball joint at their ends, thrown onto a floor.
fn thrown(method: &str, restitution: f32, way: f32) -> World {
    let method = Method::named(method).unwrap();
    let mut world = World::new(WorldConfig { method, ..WorldConfig::default() }).unwrap();
    let floor = ShapeDef::half_space([0.0, 1.0, 0.0], 0.0).with_restitution(restitution);
    world.add_body(BodyDef::fixed().with_shape(floor)).unwrap();
    // Rotations that never repeat, by the golden angle.
    let turn = |k: f32| {
        let part = |share: f32| (share * k) % 1.0 - 0.5;
        let axis = vec3(part(0.37), part(0.61), part(0.83)).normalize_or(Vec3::X);
        Quat::from_axis_angle(axis, 2.399_963 * k)
    };
    let meet = vec3(0.0, 1.2, 0.0);
    let mut ends = Vec::new();
    for (side, half) in [(-1.0, vec3(0.4, 0.1, 0.2)), (1.0, vec3(0.3, 0.05, 0.1))] {
        let rotation = turn(way + 0.5 * side);
        let arm = vec3(-side * half.x, 0.0, 0.0);
        let shape = ShapeDef::box_half(half).with_restitution(restitution).with_friction(0.5);
        let def = BodyDef::dynamic()
            .with_position(meet - rotation.rotate(arm))
            .with_rotation(rotation)
            .with_linear_velocity([3.0, -8.0, 0.0])
            .with_shape(shape);
        ends.push((world.add_body(def).unwrap(), arm));
    }
    let [(a, arm_a), (b, arm_b)] = [ends[0], ends[1]];
    world.add_joint(JointDef::new(a, b, JointKind::Ball).with_anchors(arm_a, arm_b)).unwrap();
    world
}

#[test]
fn a_pair_on_a_joint_that_bounces_gains_no_energy() {
    for method in ["soft-step", "soft-step-relax"] {
        for restitution in [0.5, 1.0] {
            for way in 0..60_u8 {
                let mut world = thrown(method, restitution, f32::from(way));
                let energy = |world: &World| world.kinetic_energy() + world.potential_energy();
                let start = energy(&world);
                let mut most = start;
                for _ in 0..STEPS {
                    world.step(DT);
                    most = most.max(energy(&world));
                }
                // Energy stored in joints and returned: up to a twentieth of the total in a second.
                assert!(
                    most < 1.05 * start,
                    "{method}, e = {restitution}, {way}: {start} J, then {most} J"
                );
            }
        }
    }
}
