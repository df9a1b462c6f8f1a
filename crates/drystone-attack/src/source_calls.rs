//! Calls on bodies and joints as source.

use std::fmt::Debug;

use drystone::joint::Spring;

use crate::op::{BodyCall, JointCall, Label};
use crate::values::show;

/// A call that returns nothing.
fn call(name: &str, args: &[&dyn Debug]) -> String {
    let args: Vec<String> = args.iter().map(show).collect();
    format!("{name}({})", args.join(", "))
}

pub(crate) fn body_call(call: &BodyCall) -> String {
    let one = |name: &str, x: &dyn Debug| format!("{name}({}).unwrap()", show(&x));
    match call {
        BodyCall::Wake => "wake()".to_owned(),
        BodyCall::Pose(pose) => self::call("set_pose", &[&pose]),
        BodyCall::LinearVelocity(v) => self::call("set_linear_velocity", &[&v]),
        BodyCall::AngularVelocity(v) => self::call("set_angular_velocity", &[&v]),
        BodyCall::MoveTo(pose, dt) => self::call("move_to", &[&pose, &dt]),
        BodyCall::Impulse(v) => self::call("apply_impulse", &[&v]),
        BodyCall::ImpulseAt(v, at) => self::call("apply_impulse_at", &[&v, &at]),
        BodyCall::AngularImpulse(v) => self::call("apply_angular_impulse", &[&v]),
        BodyCall::StepForce(v) => self::call("add_step_force", &[&v]),
        BodyCall::StepForceAt(v, at) => self::call("add_step_force_at", &[&v, &at]),
        BodyCall::StepTorque(v) => self::call("add_step_torque", &[&v]),
        BodyCall::LastingForce(v) => self::call("set_lasting_force", &[&v]),
        BodyCall::LastingTorque(v) => self::call("set_lasting_torque", &[&v]),
        BodyCall::GravityScale(x) => self::call("set_gravity_scale", &[&x]),
        BodyCall::Damping(x, y) => self::call("set_damping", &[&x, &y]),
        BodyCall::Locks(locks) => format!("set_locks({})", show(locks)),
        BodyCall::CanSleep(can) => format!("set_can_sleep({can})"),
        BodyCall::UserData(data) => format!("set_user_data({data})"),
        BodyCall::Kind(kind) => format!("set_kind(BodyKind::{kind:?}).unwrap()"),
        BodyCall::Mass(mass) => one("set_mass", mass),
        BodyCall::Enabled(enabled) => format!("set_enabled({enabled})"),
        BodyCall::Sleep => "sleep()".to_owned(),
        BodyCall::SleepSpeed(speed) => one("set_sleep_speed", speed),
        BodyCall::Correct(pose, v, w) => {
            let (pose, v, w) = (show(pose), show(v), show(w));
            format!("correct_state({pose}, {v}, {w}).unwrap()")
        }
    }
}

pub(crate) fn joint_call(j: Label, call: &JointCall) -> String {
    let two = |name: &str, a: &dyn Debug, b: &dyn Debug| {
        format!("{name}({}, {}).unwrap()", show(&a), show(&b))
    };
    let call = match call {
        JointCall::Anchors(a, b) => two("set_anchors", a, b),
        JointCall::Frames(a, b) => two("set_frames", a, b),
        JointCall::Lengths(min, max) => self::call("set_lengths", &[&min, &max]),
        JointCall::Kind(kind) => format!("set_kind({}).unwrap()", show(kind)),
        JointCall::Spring(None) => "set_spring(None).unwrap()".to_owned(),
        JointCall::Spring(Some(spring)) => {
            let Spring { rest_length, hertz, damping_ratio } = spring;
            let (length, hertz, ratio) = (show(rest_length), show(hertz), show(damping_ratio));
            format!("set_spring(Some(Spring::new({length}, {hertz}, {ratio}))).unwrap()")
        }
        JointCall::Motion(axis, motion) => {
            format!("axis(Axis::{axis:?}).unwrap().set_motion({}).unwrap()", show(motion))
        }
        JointCall::Limits(min, max) => two("set_limits", min, max),
        JointCall::Motor(speed, max_force) => self::call("set_motor", &[&speed, &max_force]),
        JointCall::Friction(friction) => format!("set_friction({}).unwrap()", show(friction)),
        JointCall::TargetRotation(rotation, spring, torque) => {
            let (rotation, spring, torque) = (show(rotation), show(spring), show(torque));
            format!("set_target_rotation({rotation}, {spring}, {torque})")
        }
        JointCall::CollideConnected(collide) => format!("set_collide_connected({collide})"),
        JointCall::Enabled(enabled) => format!("set_enabled({enabled})"),
        JointCall::Coupling(ratio, offset) => two("set_coupling", ratio, offset),
    };
    format!("world.joint_mut(j{j}).unwrap().{call};")
}
