//! Six-axis joints that lock all axes.

use drystone::joint::{JointAxis, SixDof, Slider};
use drystone::{
    BodyDef, BodyId, JointDef, JointKind, Quat, ShapeDef, Vec3, World, WorldConfig, vec3,
};

const DT: f32 = 1.0 / 60.0;

fn add_bar(world: &mut World, at: Vec3, spin: Vec3) -> BodyId {
    let bar = BodyDef::dynamic()
        .with_position(at)
        .with_shape(ShapeDef::box_full([1.0, 0.1, 0.2]))
        .with_mass(1.0);
    world.add_body(BodyDef { angular_velocity: spin, can_sleep: false, ..bar }).unwrap()
}

/// Positions of the second of two bars that tumble without gravity on a joint with this change.
fn flight(axes: SixDof, change: impl Fn(&mut JointDef)) -> Vec<Vec3> {
    let still = WorldConfig { gravity: Vec3::ZERO, ..WorldConfig::default() };
    let mut world = World::new(still).unwrap();
    let a = add_bar(&mut world, vec3(-0.5, 0.0, 0.0), vec3(0.3, 1.0, -0.5));
    let b = add_bar(&mut world, vec3(0.5, 0.0, 0.0), Vec3::ZERO);
    let frame = Quat::from_axis_angle(vec3(1.0, 2.0, -1.0), 0.7);
    let def = JointDef::new(a, b, axes).at(Vec3::ZERO).with_rotation(frame);
    let mut def = world.place_joint(def).unwrap();
    change(&mut def);
    world.add_joint(def).unwrap();
    let step = |_| {
        world.step(DT);
        world.body(b).unwrap().position()
    };
    (0..60).map(step).collect()
}

#[test]
fn a_motion_held_at_a_place_is_an_anchor_that_is_there() {
    let place = 0.2;
    for angular in [SixDof::FIXED.angular, [JointAxis::FREE; 3]] {
        let plain = SixDof { angular, ..SixDof::FIXED };
        let mut linear = plain.linear;
        linear[1] = JointAxis::limited(place, place);
        // The joint starts with a gap, and closes.
        let held = flight(SixDof { linear, ..plain }, |_| {});
        let moved = flight(plain, |def| {
            let JointKind::SixDof(axes) = def.kind else { panic!("six axes") };
            def.anchor_a += axes.frame_a.rotate(vec3(0.0, place, 0.0));
        });
        // Speeds of up to 3 m/s are rounded by 2e-7 m/s in each of 480 substeps: after a second at
        // most 1e-4 m.
        for (held, moved) in held.into_iter().zip(moved) {
            assert!((held - moved).length() < 1.0e-4, "{held:?} {moved:?}");
        }
    }
}

#[test]
fn a_joint_that_held_all_motions_lets_one_go_when_it_is_told_to() {
    let mut world = World::new(WorldConfig::default()).unwrap();
    let post = world.add_body(BodyDef::fixed()).unwrap();
    let bar = add_bar(&mut world, Vec3::ZERO, Vec3::ZERO);
    let fixed = JointDef::new(post, bar, SixDof::FIXED).at(Vec3::ZERO).with_axis(Vec3::Y);
    let joint = world.add_joint(fixed).unwrap();
    for _ in 0..6 {
        world.step(DT);
    }
    // Soft joints yield slightly under a load.
    let before = world.body(bar).unwrap().position().y;
    assert!(before.abs() < 1.0e-3, "{before}");
    let JointKind::SixDof(axes) = world.joint(joint).unwrap().kind() else { panic!("six axes") };
    let slider = SixDof { linear: Slider::new().six_dof().linear, ..axes };
    world.joint_mut(joint).unwrap().set_axes(slider).unwrap();
    for _ in 0..30 {
        world.step(DT);
    }
    // g t²/2 after half a second, and the small swing in the soft joint: at most h g t more,
    // because a substep moves with the speed at its end.
    let fallen = before - world.body(bar).unwrap().position().y;
    let exact = 0.5 * 9.81 * 0.25;
    assert!((fallen - exact).abs() < 9.81 * DT / 8.0 * 0.5 + 1.0e-3, "{fallen}");
}
