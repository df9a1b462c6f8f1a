//! Trees of six-axis joints with direct solving.

use std::sync::Arc;

use drystone::joint::{Hinge, JointAxis, JointDrive, JointSpring, Servo, SixDof, Universal};
use drystone::threads::{SimdLevel, Team};
use drystone::{BodyDef, BodyId, JointDef, JointId, ShapeDef, Vec3, World, WorldConfig, vec3};

const DT: f32 = 1.0 / 60.0;
const G: f32 = 9.81;

fn world(gravity: Vec3) -> World {
    World::new(WorldConfig { gravity, ..WorldConfig::default() }).unwrap()
}

fn link(world: &mut World, position: Vec3, mass: f32) -> BodyId {
    let link = BodyDef::dynamic()
        .with_position(position)
        .with_shape(ShapeDef::box_full([0.5, 0.1, 0.1]))
        .with_mass(mass);
    world.add_body(BodyDef { can_sleep: false, ..link }).unwrap()
}

fn join(
    world: &mut World,
    [a, b]: [BodyId; 2],
    at: Vec3,
    axes: SixDof,
    articulated: bool,
) -> JointId {
    let def = JointDef::new(a, b, axes).at(at).with_axis(Vec3::Z).with_articulated(articulated);
    world.add_joint(def).unwrap()
}

/// Links of half a meter along x with these masses in order; the first is joined to a post at the
/// origin.
fn arm(
    world: &mut World,
    masses: &[f32],
    axes: SixDof,
    articulated: bool,
) -> (Vec<BodyId>, Vec<JointId>) {
    let mut last = world.add_body(BodyDef::fixed()).unwrap();
    let (mut links, mut joints) = (Vec::new(), Vec::new());
    for (i, mass) in (0_u8..).zip(masses) {
        let start = 0.5 * f32::from(i);
        let next = link(world, vec3(start + 0.25, 0.0, 0.0), *mass);
        joints.push(join(world, [last, next], vec3(start, 0.0, 0.0), axes, articulated));
        links.push(next);
        last = next;
    }
    (links, joints)
}

fn lowest(world: &World, links: &[BodyId]) -> f32 {
    let height = |id: &BodyId| world.body(*id).unwrap().position().y;
    links.iter().map(height).fold(f32::INFINITY, f32::min)
}

/// A beam of five links of 1 kg, glued end to end, that carries 100 kg at its end.
#[test]
fn a_beam_of_fixed_joints_does_not_bend() {
    let sag = |articulated: bool| {
        let mut world = world(vec3(0.0, -G, 0.0));
        let mut config = world.config().clone();
        config.joint.tree_ratio = 1.0e9;
        world.set_config(config).unwrap();
        let masses = [1.0, 1.0, 1.0, 1.0, 1.0, 100.0];
        let (links, joints) = arm(&mut world, &masses, SixDof::FIXED, articulated);
        for _ in 0..120 {
            world.step(DT);
        }
        (-lowest(&world, &links), world.joint(joints[0]).unwrap().force().y.abs())
    };
    let ((loose, _), (held, force)) = (sag(false), sag(true));
    println!("sag {loose} joint by joint, {held} at once; force {force}");
    // Each joint acts as a spring of 120 Hz on the inertia of the tree about its center: 1 kg at
    // 2.5, 2, 1.5, 1 and 0.5 m and 2.2 of the heavy link itself, 16 kg m². It carries 981 N at r =
    // 2.75, 2.25, ... 0.25 m, rotates by 981 r/((2 π 120)² 16) and lowers the end by r times that:
    // 1.9 mm in total. Allowed: twice that.
    assert!(held < 4.0e-3, "{held}");
    assert!(loose > 50.0 * held, "{loose}");
    // It carries all weights.
    assert!((force / (105.0 * G) - 1.0).abs() < 1.0e-3, "{force}");
}

#[test]
fn joints_that_become_articulated_are_as_if_they_had_been() {
    let masses = [1.0, 1.0, 50.0];
    let run = |from: bool| {
        let mut world = world(vec3(0.0, -G, 0.0));
        let (_, joints) = arm(&mut world, &masses, SixDof::FIXED, from);
        for joint in joints {
            world.joint_mut(joint).unwrap().set_articulated(true);
        }
        for _ in 0..30 {
            world.step(DT);
        }
        world.state_hash()
    };
    assert_eq!(run(false), run(true));
}

/// Motors hold an arm with a heavy load as if it were rigid, and then rotate it.
#[test]
fn motors_move_what_the_whole_arm_weighs() {
    let mut world = world(vec3(0.0, -G, 0.0));
    let axis = JointAxis::driven(JointDrive::motor(0.0, f32::INFINITY));
    let (links, joints) = arm(&mut world, &[1.0, 1.0, 1.0, 50.0], Hinge::of(axis).six_dof(), true);
    for _ in 0..120 {
        world.step(DT);
    }
    let held = -lowest(&world, &links);
    for _ in 0..120 {
        world.step(DT);
    }
    let later = -lowest(&world, &links);
    println!("sank {held} m, then {}", later - held);
    // Before the rounds have found the torques it sags by less than the fall h² g in each of some
    // 100 substeps. After that it hardly creeps: rounds end at 1e-6 rad/s, which at 2 m is 2e-6 m/s
    // per motor.
    assert!(held < 1.0e-2, "{held}");
    assert!(later - held < 2.0 * 4.0 * 2.0e-6 + 1.0e-5, "{held} {later}");
    let torque = world.joint(joints[0]).unwrap().torque().z.abs();
    let load = G * (0.25 + 0.75 + 1.25 + 50.0 * 1.75);
    assert!((torque / load - 1.0).abs() < 2.0e-3, "{torque} {load}");
    // The last joint rotates its heavy link at 1 rad/s.
    let axes = Hinge::of(JointAxis::driven(JointDrive::motor(1.0, f32::INFINITY))).six_dof();
    world.joint_mut(joints[3]).unwrap().set_axes(axes).unwrap();
    let start = world.joint(joints[3]).unwrap().coordinates().unwrap()[1].x;
    for _ in 0..30 {
        world.step(DT);
    }
    let turned = world.joint(joints[3]).unwrap().coordinates().unwrap()[1].x - start;
    assert!((turned - 0.5).abs() < 5.0e-3, "{turned}");
    assert!(-lowest(&world, &links[..3]) < 1.0e-2);
}

/// A freely floating figure keeps its momentum, and gains no energy.
#[test]
fn a_floating_figure_keeps_momentum_and_energy() {
    let mut world = world(Vec3::ZERO);
    let spring = JointSpring::new(20.0, 0.0);
    let bend = JointAxis::driven(JointDrive::servo(0.0, spring, f32::INFINITY));
    let axes = Universal::of(bend, bend).six_dof();
    let mut links = vec![link(&mut world, vec3(0.25, 0.0, 0.0), 5.0)];
    for i in 1..5_u8 {
        let start = 0.5 * f32::from(i);
        let next = link(&mut world, vec3(start + 0.25, 0.0, 0.0), 1.0);
        let last = links[usize::from(i) - 1];
        join(&mut world, [last, next], vec3(start, 0.0, 0.0), axes, true);
        links.push(next);
    }
    let mut body = world.body_mut(links[4]).unwrap();
    body.set_linear_velocity(vec3(0.0, 2.0, 1.0));
    let momentum = |world: &World| {
        let (mut p, mut l, mut e) = (Vec3::ZERO, Vec3::ZERO, 0.0);
        for id in &links {
            let body = world.body(*id).unwrap();
            let (m, v, w) = (body.mass(), body.linear_velocity(), body.angular_velocity());
            p += v * m;
            l += body.center_of_mass().cross(v) * m + body.inertia().mul(w);
            e += body.kinetic_energy();
        }
        (p, l, e)
    };
    world.step(DT);
    let (p, l, e) = momentum(&world);
    let mut most = e;
    for _ in 0..600 {
        world.step(DT);
        most = most.max(momentum(&world).2);
    }
    let (q, k, _) = momentum(&world);
    println!("{p:?} {q:?}; {l:?} {k:?}; {e} {most}");
    // 4800 substeps with random errors of about 6e-8 each: 1e-5 of the largest terms. The angular
    // momentum also has the error of geometric stiffness (decision 017).
    assert!((q - p).length() < 1.0e-4 * p.length(), "{p:?} {q:?}");
    assert!((k - l).length() < 2.0e-2 * l.length(), "{l:?} {k:?}");
    // Springs store some energy at times; the joints add none.
    assert!(most < 1.02 * e, "{e} {most}");
}

/// Many trees in one group, some with limits and drives, for all numbers of threads and lanes.
#[test]
fn trees_give_the_same_bits_by_any_threads_and_lanes() {
    let run = |threads: usize, level: SimdLevel| {
        let mut world = world(vec3(0.0, -G, 0.0));
        world.set_executor(Arc::new(Team::with_threads(threads)));
        world.set_simd_level(level);
        let ground = ShapeDef::box_half([50.0, 0.5, 50.0]);
        let ground = BodyDef::fixed().with_position([0.0, -1.0, 0.0]).with_shape(ground);
        world.add_body(ground).unwrap();
        let limit = JointAxis::limited(-0.5, 0.5).with_friction(2.0);
        for i in 0..20_u8 {
            let at = vec3(0.0, 0.2 + 0.1 * f32::from(i % 3), f32::from(i));
            let mut last = link(&mut world, at, 3.0);
            for k in 1..4_u8 {
                let next = link(&mut world, at + vec3(0.5 * f32::from(k), 0.0, 0.0), 1.0);
                let joint = at + vec3(0.5 * f32::from(k) - 0.25, 0.0, 0.0);
                join(&mut world, [last, next], joint, Hinge::of(limit).six_dof(), i % 4 > 0);
                last = next;
            }
        }
        for _ in 0..60 {
            world.step(DT);
        }
        world.state_hash()
    };
    let hash = run(1, SimdLevel::available()[0]);
    for threads in [1, 3] {
        for level in SimdLevel::available() {
            assert_eq!(run(threads, level), hash, "{threads} {level:?}");
        }
    }
}

/// Joints that are added and removed while their tree is solved directly, and joints that hold
/// nothing.
#[test]
fn trees_change_while_they_are_solved() {
    let mut world = world(vec3(0.0, -G, 0.0));
    let (links, joints) = arm(&mut world, &[1.0; 4], Hinge::new().six_dof(), true);
    let hand = world.add_body(BodyDef::kinematic().with_position([2.0, 0.0, 0.0])).unwrap();
    let grab = Servo::grab(JointSpring::hertz(5.0, 1.0), 100.0).six_dof();
    let def = JointDef::new(hand, links[3], grab).with_anchors(Vec3::ZERO, [0.25, 0.0, 0.0]);
    let grab = world.add_joint(def).unwrap();
    for step in 0..240 {
        match step {
            60 => assert!(world.remove_joint(grab)),
            120 => assert!(world.remove_joint(joints[2])),
            180 => assert!(world.remove_body(links[1])),
            _ => {}
        }
        world.step(DT);
        for joint in &joints {
            if let Some(joint) = world.joint(*joint) {
                assert!(joint.error() < 1.0e-3, "{step} {}", joint.error());
            }
        }
    }
    // The two released links fall freely.
    let y = world.body(links[3]).unwrap().position().y;
    assert!(y < -10.0, "{y}");
}
