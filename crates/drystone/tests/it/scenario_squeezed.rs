//! Bodies squeezed between two immovable ones.

use drystone::{BodyDef, Pose, ShapeDef, Vec3, World, vec3};

const DT: f32 = 1.0 / 60.0;

/// A kinematic body drives a crate into a wall and on through it. No result can be right then, but
/// the crate must not be thrown. It leaves no faster than overlaps are pushed out, 6/s of its depth
/// in either body, plus the speed of the kinematic body.
#[test]
fn a_crate_that_is_crushed_against_a_wall_is_not_thrown() {
    let (speed, depth) = (1.5, 0.4);
    let most = speed + 6.0 * depth;
    let capsule = ShapeDef::capsule(0.5, 0.3);
    let block = ShapeDef::box_half([0.3, 0.8, 0.3]);
    for (name, pusher) in [("capsule", capsule), ("box", block)] {
        for mass in [4.0, 40.0, 400.0] {
            let mut world = World::default();
            let ground = ShapeDef::half_space(Vec3::Y, 0.0);
            world.add_body(BodyDef::fixed().with_shape(ground)).unwrap();
            let wall = BodyDef::fixed().with_position([4.0, 1.0, 0.0]);
            world.add_body(wall.with_shape(ShapeDef::box_half([0.5, 1.0, 2.0]))).unwrap();
            let pusher =
                BodyDef::kinematic().with_position([0.0, 0.81, 0.0]).with_shape(pusher.clone());
            let pusher = world.add_body(pusher).unwrap();
            let crate_ = BodyDef::dynamic().with_position([1.5, 0.4, 0.0]).with_mass(mass);
            let crate_ = world.add_body(crate_.with_shape(ShapeDef::box_half([0.4; 3]))).unwrap();
            let (mut x, mut fastest) = (0.0, 0.0_f32);
            for _ in 0..240 {
                x += speed * DT;
                world.body_mut(pusher).unwrap().move_to(Pose::at(vec3(x, 0.81, 0.0)), DT);
                world.step(DT);
                fastest = fastest.max(world.body(crate_).unwrap().linear_velocity().length());
            }
            println!("{name}, {mass} kg: {fastest} m/s, at most {most}");
            assert!(fastest < most, "{name}, {mass} kg: {fastest} m/s");
        }
    }
}
