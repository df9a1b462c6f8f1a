//! Changes to existing joints.

use drystone::breakage::JointStrength;
use drystone::joint::{
    Ball, CouplingDef, Distance, Hinge, JointAxis, JointDrive, JointMotion, JointSpring, Pulley,
    SixDof, Slider, Spring,
};
use drystone::journal::{Call, JointCall};
use drystone::{
    Axis, BodyDef, BodyId, BodyKind, DefError, JointDef, JointId, JointKind, JointMut, Quat,
    ShapeDef, Vec3, World, vec3,
};

use super::{DT, Floor, GRAVITY, JOLT, Stack, goes_on};

/// One joint of each kind and a gear; all bodies hang from a beam.
struct Machine {
    world: World,
    beam: BodyId,
    ball: JointId,
    rope: JointId,
    hinges: [JointId; 2],
    gear: JointId,
    pulley: JointId,
}

impl Machine {
    fn new() -> Self {
        let mut world = World::default();
        let beam = BodyDef::fixed().with_position([0.0, 10.0, 0.0]);
        let beam = world.add_body(beam.with_shape(ShapeDef::box_half([9.0, 0.1, 0.1]))).unwrap();
        let weight = |world: &mut World, x: f32| {
            let cube = BodyDef::dynamic().with_position([x, 8.0, 0.0]);
            world.add_body(cube.with_shape(ShapeDef::box_half([0.3; 3]))).unwrap()
        };
        let a = weight(&mut world, -8.0);
        let ball =
            JointDef::new(beam, a, Ball::new()).with_anchors([-8.0, -0.5, 0.0], [0.0, 1.5, 0.0]);
        let ball = world.add_joint(ball).unwrap();
        let b = weight(&mut world, -5.0);
        let rope = JointDef::new(beam, b, Distance::exact(1.7))
            .with_anchors([-5.0, 0.0, 0.0], [0.0, 0.3, 0.0]);
        let kind = JointKind::Distance { min: 0.0, max: 1.7, spring: None };
        let rope = world.add_joint(JointDef { kind, user_data: 5, ..rope }).unwrap();
        let hinges = [-2.0, 0.0].map(|x| {
            let arm = weight(&mut world, x);
            let axes = Hinge::new().six_dof();
            let def = JointDef::new(beam, arm, axes).at([x, 9.5, 0.0]).with_axis(Vec3::Z);
            world.add_joint(def).unwrap()
        });
        let gear = world.add_coupling(CouplingDef::gear(hinges[0], hinges[1], 1.0)).unwrap();
        let (c, d) = (weight(&mut world, 3.0), weight(&mut world, 6.0));
        let over = Pulley::rope([vec3(3.0, 9.5, 0.0), vec3(6.0, 9.5, 0.0)], 2.4);
        let top = [0.0, 0.3, 0.0];
        let pulley = world.add_joint(JointDef::new(c, d, over).with_anchors(top, top)).unwrap();
        for _ in 0..20 {
            world.step(DT);
        }
        Self { world, beam, ball, rope, hinges, gear, pulley }
    }

    fn all(&self) -> [JointId; 6] {
        [self.ball, self.rope, self.hinges[0], self.hinges[1], self.gear, self.pulley]
    }

    fn steps(&mut self, count: u32) {
        for _ in 0..count {
            self.world.step(DT);
        }
    }

    /// The body that hangs from a joint.
    fn hung(&self, joint: JointId) -> BodyId {
        self.world.joint(joint).unwrap().body_b()
    }
}

type Change = fn(&mut Machine) -> Result<(), DefError>;

#[test]
fn joints_change_in_any_state() {
    let changes: &[(&str, Change)] = &[
        ("ball's anchors", |m| {
            m.world.joint_mut(m.ball).unwrap().set_anchors([-8.0, 0.0, 0.0], [0.0, 2.0, 0.0])
        }),
        ("pulley's anchors", |m| {
            m.world.joint_mut(m.pulley).unwrap().set_anchors([0.1, 0.3, 0.0], [0.0; 3])
        }),
        ("lengths", |m| {
            m.world.joint_mut(m.rope).unwrap().set_lengths(0.5, 0.9);
            Ok(())
        }),
        ("spring", |m| {
            let spring = Spring { rest_length: 1.0, hertz: 2.0, damping_ratio: 0.5 };
            m.world.joint_mut(m.rope).unwrap().set_spring(Some(spring))?;
            m.world.joint_mut(m.rope).unwrap().set_lengths(0.0, 5.0);
            Ok(())
        }),
        ("rope", |m| {
            let points = [vec3(3.0, 9.7, 0.0), vec3(6.0, 9.0, 0.0)];
            m.world.joint_mut(m.pulley).unwrap().set_pulley(Pulley::rope(points, 2.0))
        }),
        ("gear", |m| m.world.joint_mut(m.gear).unwrap().set_coupling(-2.0, 0.1)),
        ("ball becomes a rod", |m| {
            m.world.joint_mut(m.ball).unwrap().set_kind(Distance::exact(1.0))
        }),
        ("rope becomes fixed", |m| m.world.joint_mut(m.rope).unwrap().set_kind(SixDof::FIXED)),
        ("hinge becomes fixed but for its gear", |m| {
            let axes = Hinge::new().six_dof();
            m.world.joint_mut(m.hinges[0]).unwrap().set_kind(axes)
        }),
        ("pulley becomes a spring", |m| {
            m.world.joint_mut(m.pulley).unwrap().set_kind(Spring::new(2.0, 1.0, 0.5))
        }),
        ("motion", |m| {
            let motion = JointMotion::Limited { min: 0.2, max: 0.5, spring: None };
            m.world.joint_mut(m.hinges[0]).unwrap().set_motion(motion)
        }),
        ("slides too", |m| {
            let mut joint = m.world.joint_mut(m.hinges[1]).unwrap();
            joint.axis(Axis::X).unwrap().set_motion(JointMotion::Free)
        }),
        ("collide", |m| {
            m.world.joint_mut(m.ball).unwrap().set_collide_connected(true);
            Ok(())
        }),
        ("off", |m| {
            m.all().into_iter().for_each(|id| m.world.joint_mut(id).unwrap().set_enabled(false));
            Ok(())
        }),
        ("one hinge off", |m| {
            m.world.joint_mut(m.hinges[0]).unwrap().set_enabled(false);
            Ok(())
        }),
        ("off and on", |m| {
            let all = m.all();
            all.into_iter().for_each(|id| m.world.joint_mut(id).unwrap().set_enabled(false));
            m.world.step(DT);
            all.into_iter().for_each(|id| m.world.joint_mut(id).unwrap().set_enabled(true));
            Ok(())
        }),
        ("one body static, one out", |m| {
            let (a, b) = (m.hung(m.hinges[0]), m.hung(m.pulley));
            m.world.body_mut(a).unwrap().set_kind(BodyKind::Static)?;
            m.world.body_mut(b).unwrap().set_enabled(false);
            Ok(())
        }),
        ("number", |m| {
            m.world.joint_mut(m.gear).unwrap().set_user_data(9);
            Ok(())
        }),
    ];
    in_any_state(changes);
}

/// Makes each change while the machine swings and while it rests, and continues.
fn in_any_state(changes: &[(&str, Change)]) {
    for (name, change) in changes {
        for rests in [0, 1200] {
            let mut machine = Machine::new();
            for hinge in machine.hinges {
                let id = machine.hung(hinge);
                machine.world.body_mut(id).unwrap().set_damping(0.5, 0.5);
            }
            machine.steps(rests);
            change(&mut machine).expect(name);
            goes_on(name, &mut machine.world, |_| ());
        }
    }
}

#[test]
fn axes_drives_and_strengths_change_in_any_state() {
    let changes: &[(&str, Change)] = &[
        ("frames", |m| {
            let turn = Quat::from_axis_angle(Vec3::X, 0.3);
            m.world.joint_mut(m.hinges[0]).unwrap().set_frames(turn, turn)
        }),
        ("axes", |m| {
            let limits = JointMotion::Limited { min: -0.2, max: 0.2, spring: None };
            let turn = JointAxis { motion: limits, ..JointAxis::FREE };
            let axes =
                SixDof { angular: [turn, JointAxis::LOCKED, JointAxis::LOCKED], ..SixDof::FIXED };
            m.world.joint_mut(m.hinges[1]).unwrap().set_axes(axes)
        }),
        ("articulated", |m| {
            m.world.joint_mut(m.hinges[0]).unwrap().set_articulated(true);
            Ok(())
        }),
        ("weak", |m| {
            let weak = JointStrength { force: 10.0, ..JointStrength::default() };
            m.all()
                .into_iter()
                .try_for_each(|id| m.world.joint_mut(id).unwrap().set_strength(Some(weak)))
        }),
        ("strong", |m| {
            let strong = JointStrength { force: 1.0e7, ..JointStrength::default() };
            m.all()
                .into_iter()
                .try_for_each(|id| m.world.joint_mut(id).unwrap().set_strength(Some(strong)))
        }),
        ("drive", |m| {
            let motor = JointDrive::motor(1.0, 500.0);
            m.world.joint_mut(m.hinges[0]).unwrap().set_drive(Some(motor))
        }),
        ("motor", |m| {
            m.world.joint_mut(m.hinges[0]).unwrap().set_motor(-1.0, 1.0e4);
            Ok(())
        }),
        ("servo", |m| {
            let spring = JointSpring::hertz(2.0, 1.0);
            m.world.joint_mut(m.hinges[1]).unwrap().set_servo(0.4, spring, 1.0e4);
            Ok(())
        }),
        ("motor of the axis, and none again", |m| {
            let mut joint = m.world.joint_mut(m.hinges[0]).unwrap();
            joint.hinge().unwrap().set_motor(2.0, 1.0e4);
            joint.hinge().unwrap().set_drive(None)
        }),
        ("servo of the axis", |m| {
            let mut joint = m.world.joint_mut(m.hinges[0]).unwrap();
            joint.hinge().unwrap().set_servo(-0.4, JointSpring::hertz(2.0, 1.0), 1.0e4);
            Ok(())
        }),
        ("limits", |m| m.world.joint_mut(m.hinges[0]).unwrap().set_limits(-0.1, 0.1)),
        ("limits of the axis", |m| {
            m.world.joint_mut(m.hinges[1]).unwrap().hinge().unwrap().set_limits(0.3, 0.5)
        }),
        ("friction", |m| m.world.joint_mut(m.hinges[0]).unwrap().set_friction(50.0)),
        ("friction of the axis", |m| {
            m.world.joint_mut(m.hinges[1]).unwrap().hinge().unwrap().set_friction(f32::INFINITY)
        }),
        ("all of an axis", |m| {
            let axis = JointAxis { friction: 20.0, ..JointAxis::FREE };
            m.world.joint_mut(m.hinges[0]).unwrap().hinge().unwrap().set(axis)
        }),
        ("target", |m| {
            let free = SixDof { angular: [JointAxis::FREE; 3], ..SixDof::FIXED };
            m.world.joint_mut(m.ball).unwrap().set_kind(free)?;
            let turn = Quat::from_axis_angle(vec3(0.6, 0.0, 0.8), 0.5);
            let spring = JointSpring::hertz(1.0, 1.0);
            m.world.joint_mut(m.ball).unwrap().set_target_rotation(turn, spring, 1.0e4);
            Ok(())
        }),
        ("slides", |m| {
            m.world.joint_mut(m.rope).unwrap().set_kind(Slider::new())?;
            m.world.joint_mut(m.rope).unwrap().slider().unwrap().set_motor(0.2, 1.0e4);
            Ok(())
        }),
        ("woken", |m| {
            m.all().into_iter().for_each(|id| m.world.joint_mut(id).unwrap().wake());
            Ok(())
        }),
    ];
    in_any_state(changes);
}

#[test]
fn lengths_and_anchors_lead_where_they_say_and_the_same_ones_move_nothing() {
    let mut machine = Machine::new();
    machine.steps(60);
    let mut twin = machine.world.clone();
    let [a, b] = twin.joint(machine.ball).unwrap().local_anchors();
    assert!((a - vec3(-8.0, -0.5, 0.0)).length() < 1.0e-6 && (b - Vec3::Y * 1.5).length() < 1.0e-6);
    twin.joint_mut(machine.ball).unwrap().set_anchors(a, b).unwrap();
    twin.joint_mut(machine.rope).unwrap().set_lengths(0.0, 1.7);
    for id in machine.all() {
        assert!(!twin.joint(id).unwrap().is_idle());
    }
    for step in 0..60 {
        twin.step(DT);
        for body in twin.bodies() {
            let speed = body.linear_velocity().length();
            let hangs = machine.hinges.iter().all(|id| machine.hung(*id) != body.id());
            let hangs = hangs && machine.hung(machine.pulley) != body.id();
            assert!(!hangs || speed < 10.0 * JOLT, "{:?}: {speed} m/s in step {step}", body.id());
        }
    }
    let weight = machine.hung(machine.rope);
    machine.world.joint_mut(machine.rope).unwrap().set_lengths(0.0, 0.7);
    machine
        .world
        .joint_mut(machine.ball)
        .unwrap()
        .set_anchors([-7.5, -0.5, 0.0], [0.0, 1.0, 0.0])
        .unwrap();
    machine.steps(600);
    let errors = machine.world.audit().joints;
    assert!(errors.linear < 5.0e-3, "{errors:?}");
    // The top of the cube is 0.7 m below the beam's middle.
    let y = machine.world.body(weight).unwrap().position().y;
    assert!((y - (10.0 - 0.7 - 0.3)).abs() < 0.05, "{y} m");
}

#[test]
fn a_joint_that_is_off_does_nothing_and_takes_over_again() {
    let mut machine = Machine::new();
    let id = machine.hung(machine.ball);
    machine.steps(300);
    machine.world.joint_mut(machine.ball).unwrap().set_enabled(false);
    let joint = machine.world.joint(machine.ball).unwrap();
    assert!(!joint.is_enabled() && joint.is_idle() && joint.force() == Vec3::ZERO);
    let before = machine.world.body(id).unwrap().position().y;
    machine.steps(20);
    let fall = before - machine.world.body(id).unwrap().position().y;
    let expected = 0.5 * GRAVITY * (20.0 * DT) * (20.0 * DT + DT / 8.0);
    assert!((fall - expected).abs() < 0.02, "{fall} m");
    // The audit ignores its error meanwhile.
    assert!(machine.world.audit().joints.linear < 0.05);
    machine.world.joint_mut(machine.ball).unwrap().set_enabled(true);
    machine.steps(300);
    assert!(machine.world.joint(machine.ball).unwrap().error() < 5.0e-3);
    assert_eq!(machine.world.joint(machine.rope).unwrap().user_data(), 5);
}

#[test]
fn a_joint_of_another_kind_holds_what_that_kind_holds() {
    let mut machine = Machine::new();
    let id = machine.hung(machine.ball);
    // A rod of 1 m from the beam's anchor to the cube's.
    machine.world.joint_mut(machine.ball).unwrap().set_kind(Distance::exact(1.0)).unwrap();
    // A pendulum of 2.5 m has a period of three seconds: after 30 s its swing is damped out, and so
    // is the force of the swing.
    machine.world.body_mut(id).unwrap().set_damping(2.0, 2.0);
    machine.steps(1800);
    // Damping removes a fraction of the speed that gravity adds in each substep, and the same
    // fraction of the force.
    machine.world.body_mut(id).unwrap().set_damping(0.0, 0.0);
    machine.world.body_mut(id).unwrap().wake();
    machine.steps(60);
    let joint = machine.world.joint(machine.ball).unwrap();
    assert!(matches!(joint.kind(), JointKind::Distance { .. }));
    let weight = machine.world.body(id).unwrap().mass() * GRAVITY;
    let force = joint.force().length();
    assert!((force / weight - 1.0).abs() < 1.0e-3, "{force} N of {weight}");
    // Held in its current pose at any rotation of its bodies, because the frames belong to the
    // bodies and the joint holds their relative angle.
    let before = machine.world.body(id).unwrap().pose();
    let top = before.point(vec3(0.0, 1.5, 0.0));
    let on_beam = machine.world.body(machine.beam).unwrap().pose().local_point(top);
    let mut joint = machine.world.joint_mut(machine.ball).unwrap();
    joint.set_anchors(on_beam, Vec3::Y * 1.5).unwrap();
    let frame = before.rotation.conjugate();
    joint.set_kind(SixDof { frame_b: frame, ..SixDof::FIXED }).unwrap();
    machine.steps(60);
    let after = machine.world.body(id).unwrap().pose();
    assert!((after.position - before.position).length() < 2.0e-3, "{before:?} {after:?}");
}

#[test]
fn a_motor_that_is_off_lets_its_body_sleep_and_on_wakes_it() {
    let mut machine = Machine::new();
    let pole = machine.beam;
    let wheel = BodyDef::dynamic().with_position([0.0, 3.0, 0.0]).with_shape(ShapeDef::sphere(0.5));
    let wheel = BodyDef { gravity_scale: 0.0, angular_damping: 5.0, ..wheel };
    let wheel = machine.world.add_body(wheel).unwrap();
    let spin = Hinge::of(JointAxis::driven(JointDrive::motor(2.0, 1.0e6))).six_dof();
    let def = JointDef::new(pole, wheel, spin).at([0.0, 3.0, 0.0]).with_axis(Vec3::Z);
    let hinge = machine.world.add_joint(def).unwrap();
    machine.steps(200);
    let speed = |world: &World| world.body(wheel).unwrap().angular_velocity().z;
    assert!((speed(&machine.world) - 2.0).abs() < 0.01);
    machine.world.joint_mut(hinge).unwrap().set_enabled(false);
    machine.steps(200);
    assert!(machine.world.body(wheel).unwrap().is_asleep());
    machine.world.joint_mut(hinge).unwrap().set_enabled(true);
    assert!(!machine.world.body(wheel).unwrap().is_asleep());
    machine.steps(20);
    assert!((speed(&machine.world) - 2.0).abs() < 0.01);
}

#[test]
fn bodies_of_a_joint_begin_and_cease_to_collide() {
    let mut stack = Stack::new(Floor::Box, 1.0, BodyKind::Dynamic);
    let [a, b] = [stack.cubes[3], stack.cubes[4]];
    let axes = SixDof::FIXED;
    let def = JointDef::new(a, b, axes).at(stack.places()[4]).with_axis(Vec3::X);
    let joint = stack.world.add_joint(JointDef { collide_connected: true, ..def }).unwrap();
    stack.steps(20);
    assert!(stack.world.joint(joint).unwrap().collide_connected());
    let touch =
        |world: &World| world.contacts().filter(|c| [c.body_a(), c.body_b()] == [a, b]).count();
    assert_eq!(touch(&stack.world), 1);
    stack.world.joint_mut(joint).unwrap().set_collide_connected(false);
    stack.world.step(DT);
    assert_eq!((touch(&stack.world), stack.world.events().contact_end.len()), (0, 1));
    stack.stands("held by the joint", 20, 0.01);
    stack.world.joint_mut(joint).unwrap().set_collide_connected(true);
    stack.stands("held by both", 20, 0.01);
    assert_eq!(touch(&stack.world), 1);
}

#[test]
fn what_no_joint_can_be_is_refused_by_name() {
    let mut machine = Machine::new();
    let before = machine.world.snapshot();
    let Machine { world, beam, ball, rope, hinges, gear, pulley } = &mut machine;
    // On a copy, because a refused per-frame call is a fault in the next step.
    let lengths = |world: &World, id: JointId, min: f32, max: f32| {
        let call = Call::Joint(id, JointCall::SetLengths(min, max));
        world.clone().apply(&call).unwrap_err().field().to_owned()
    };
    assert_eq!(lengths(world, *rope, 2.0, 1.0), "max");
    assert_eq!(lengths(world, *rope, -1.0, 1.0), "min");
    assert_eq!(lengths(world, *ball, 0.0, 1.0), "joint");
    let mut set = |id: JointId, change: &dyn Fn(JointMut<'_>) -> Result<(), DefError>| {
        change(world.joint_mut(id).unwrap()).unwrap_err().field().to_owned()
    };
    assert_eq!(set(*ball, &|mut j| j.set_anchors([f32::NAN; 3], [0.0; 3])), "anchor_a");
    assert_eq!(set(*gear, &|mut j| j.set_anchors([0.0; 3], [0.0; 3])), "joint");
    let points = [Vec3::ZERO; 2];
    assert_eq!(set(*ball, &|mut j| j.set_pulley(Pulley::rope(points, 1.0))), "joint");
    let rope_of_no_length = Pulley::rope(points, f32::NAN);
    assert_eq!(set(*pulley, &|mut j| j.set_pulley(rope_of_no_length)), "pulley.length");
    assert_eq!(set(*rope, &|mut j| j.set_coupling(1.0, 0.0)), "joint");
    let (first, second) = (hinges[0], hinges[1]);
    let of_gear = move || JointKind::Coupling(CouplingDef::gear(first, second, 1.0));
    assert_eq!(set(*ball, &|mut j| j.set_kind(of_gear())), "kind");
    assert_eq!(set(*gear, &|mut j| j.set_kind(Ball::new())), "kind");
    assert_eq!(set(hinges[0], &|mut j| j.set_kind(Distance::exact(1.0))), "kind");
    let fixed = set(hinges[0], &|mut j| j.set_kind(SixDof::FIXED));
    assert!(fixed.contains("coupling"), "{fixed}");
    assert_eq!(set(*ball, &|mut j| j.set_kind(Distance::exact(-1.0))), "min");
    assert_eq!(set(*rope, &|mut j| j.set_limits(0.0, 1.0)), "joint");
    let lock = set(hinges[0], &|mut j| j.set_motion(JointMotion::Locked));
    assert!(lock.contains("coupling"), "{lock}");
    assert!(world.joint_mut(*ball).unwrap().axis(Axis::X).is_none());
    assert!(world.snapshot() == before);
    let gone = *ball;
    assert!(world.remove_joint(gone));
    assert!(world.joint_mut(gone).is_none() && world.joint(gone).is_none());
    assert!(world.body(*beam).is_some());
}
