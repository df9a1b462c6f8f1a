//! Definitions of joints, from names and dicts.

use core::f32::consts::FRAC_PI_2;

use drystone::breakage::{Fatigue, JointStrength};
use drystone::joint::{
    Ball, ConeTwist, Cylindrical, Distance, Fixed, Hinge, JointAxis, JointCone, JointDrive,
    JointMotion, JointSpring, Planar, Pulley, Rope, Servo, SixDof, Slider, Spring, Universal,
    Wheel,
};
use drystone::{Axis, BodyId, JointDef, JointKind, Vec3};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyString, PyTuple};

use crate::arrays::{real, reals, shown, vector, wrong_type};
use crate::errors::bad;
use crate::options::{Options, dict, one_of};

/// The kinds of joints, by name.
pub(crate) const KINDS: [&str; 13] = [
    "ball",
    "hinge",
    "slider",
    "fixed",
    "distance",
    "rope",
    "spring",
    "cone_twist",
    "universal",
    "cylindrical",
    "planar",
    "six_dof",
    "pulley",
];
/// More kinds, which hold a body to a pose, or a wheel to a car.
pub(crate) const MORE_KINDS: [&str; 2] = ["servo", "wheel"];

const AXES: [&str; 6] = ["x", "y", "z", "turn_x", "turn_y", "turn_z"];

/// The axis of this name.
pub(crate) fn axis_named(field: &str, value: &Bound<'_, PyAny>) -> PyResult<Axis> {
    one_of(field, value, &AXES).map(|place| Axis::ALL[place])
}

/// A joint of this kind between two bodies.
pub(crate) fn definition(
    kind: &str,
    [body_a, body_b]: [BodyId; 2],
    given: Option<&Bound<'_, PyDict>>,
) -> PyResult<JointDef> {
    let what = format!("a joint of kind '{kind}'");
    let options = Options::new(&what, given);
    let Some(kind) = kind_of(kind, &options)? else {
        let allowed = format!("one of {}, {}", KINDS.join(", "), MORE_KINDS.join(", "));
        return Err(bad("kind", &format!("'{kind}'"), &allowed));
    };
    let mut def = JointDef::new(body_a, body_b, kind);
    if let Some([a, b]) = options.with("anchors", two_points)? {
        def = def.with_anchors(a, b);
    }
    if let Some([a, b]) = options.with("between", two_points)? {
        def = def.between(a, b);
    }
    if let Some(point) = options.vector("at")? {
        def = def.at(point);
    }
    if let Some(axis) = options.vector("axis")? {
        def = def.with_axis(axis);
    }
    if let Some([x, y]) = options.with("axes", two_points)? {
        def = def.with_axes(x, y);
    }
    if let Some(rotation) = options.rotation("rotation")? {
        def = def.with_rotation(rotation);
    }
    options.set_flag("collide_connected", &mut def.collide_connected)?;
    options.set_flag("articulated", &mut def.articulated)?;
    options.set_flag("enabled", &mut def.enabled)?;
    options.set_whole("user_data", &mut def.user_data)?;
    def.strength = strength(&options)?;
    let places = ["anchors", "between", "at"];
    let turns = ["axis", "axes", "rotation"];
    for names in [places, turns] {
        let count = given.map_or(0, |given| {
            names.iter().filter(|name| given.contains(**name).unwrap_or(false)).count()
        });
        if count > 1 {
            return Err(bad(names[0], &format!("{count} of them"), &one_only(&names)));
        }
    }
    options.finish()?;
    Ok(def)
}

fn one_only(names: &[&str]) -> String {
    format!("only one of {}", names.join(", "))
}

fn strength(options: &Options<'_, '_>) -> PyResult<Option<JointStrength>> {
    let mut strength = JointStrength::default();
    options.set_real("break_force", &mut strength.force)?;
    options.set_real("break_torque", &mut strength.torque)?;
    options.set_real("break_impulse", &mut strength.impulse)?;
    if let Some(given) = options.dict("fatigue")? {
        let part = Options::new("fatigue", Some(&given));
        let mut fatigue = Fatigue { life: 1.0, exponent: 1, endurance: 0.0 };
        part.set_real("life", &mut fatigue.life)?;
        part.set_whole("exponent", &mut fatigue.exponent)?;
        part.set_real("endurance", &mut fatigue.endurance)?;
        part.finish()?;
        strength.fatigue = Some(fatigue);
    }
    Ok((strength != JointStrength::default()).then_some(strength))
}

fn two_points(field: &str, value: &Bound<'_, PyAny>) -> PyResult<[Vec3; 2]> {
    let (a, b) = pair_of(field, value, "two points")?;
    Ok([vector(field, &a)?, vector(field, &b)?])
}

fn pair_of<'py>(
    field: &str,
    value: &Bound<'py, PyAny>,
    allowed: &str,
) -> PyResult<(Bound<'py, PyAny>, Bound<'py, PyAny>)> {
    let items: Vec<_> = match value.try_iter() {
        Ok(items) if !value.is_instance_of::<PyString>() => {
            items.take(3).collect::<PyResult<_>>()?
        }
        _ => return Err(wrong_type(field, value, allowed)),
    };
    match <[Bound<'py, PyAny>; 2]>::try_from(items) {
        Ok([a, b]) => Ok((a, b)),
        Err(_) => Err(bad(field, &shown(value), allowed)),
    }
}

/// The kind of a joint from its options; `None` for an unknown name.
fn kind_of(kind: &str, options: &Options<'_, '_>) -> PyResult<Option<JointKind>> {
    let free = JointAxis::FREE;
    let axis = |name| options.with(name, axis_def).map(|axis| axis.unwrap_or(free));
    let spring = |name| options.with(name, spring_def);
    Ok(Some(match kind {
        "ball" => Ball::new().with_friction(options.real("friction")?.unwrap_or(0.0)).into(),
        "hinge" => Hinge::of(axis_of(options, free)?).into(),
        "slider" => Slider::of(axis_of(options, free)?).into(),
        "fixed" => {
            let (linear, angular) = (spring("linear_spring")?, spring("angular_spring")?);
            Fixed { linear, angular }.into()
        }
        "distance" => distance(options)?,
        "rope" => Rope::new(needed(options, "length")?).into(),
        "spring" => sprung(options, needed(options, "rest_length")?)?.into(),
        "cone_twist" => cone(options)?,
        "universal" => Universal::of(axis("x")?, axis("y")?).into(),
        "cylindrical" => Cylindrical::of(axis("along")?, axis("about")?).into(),
        "planar" => Planar { y: axis("y")?, z: axis("z")?, turn: axis("turn")? }.into(),
        "six_dof" => JointKind::SixDof(six_dof(options)?),
        "pulley" => {
            let points = options.with("points", two_points)?;
            let points = points.ok_or_else(|| bad("points", "nothing", "two points"))?;
            let mut pulley = Pulley::rope(points, needed(options, "length")?);
            options.set_real("ratio", &mut pulley.ratio)?;
            options.set_flag("rigid", &mut pulley.is_rigid)?;
            pulley.into()
        }
        "servo" => {
            let linear = spring("spring")?.unwrap_or_else(|| JointSpring::hertz(5.0, 1.0));
            let angular = spring("angular_spring")?.unwrap_or(linear);
            let holds = options.flag("hold_rotation")?.unwrap_or(true);
            let max = |name| options.real(name).map(|max| max.unwrap_or(f32::INFINITY));
            let (max_force, max_torque) = (max("drive_force")?, max("drive_torque")?);
            Servo { linear, angular: holds.then_some(angular), max_force, max_torque }.into()
        }
        "wheel" => {
            let (suspension, spin) = (axis("suspension")?, axis("spin")?);
            let steering = options.with("steering", axis_def)?.unwrap_or(JointAxis::LOCKED);
            Wheel { suspension, spin, steering }.into()
        }
        _ => return Ok(None),
    }))
}

fn needed(options: &Options<'_, '_>, name: &'static str) -> PyResult<f32> {
    options.real(name)?.ok_or_else(|| bad(name, "nothing", "given"))
}

fn distance(options: &Options<'_, '_>) -> PyResult<JointKind> {
    let (length, min, max) = (options.real("length")?, options.real("min")?, options.real("max")?);
    let range = match (length, min, max) {
        (Some(length), None, None) => Distance::exact(length),
        (None, min, Some(max)) => Distance::between(min.unwrap_or(0.0), max),
        _ => return Err(bad("length", "nothing", "given, or `max` with or without `min`")),
    };
    let range = match options.dict("spring")? {
        Some(given) => {
            let part = Options::new("a spring", Some(&given));
            let spring = sprung(&part, needed(&part, "rest_length")?)?;
            part.finish()?;
            range.with_spring(spring)
        }
        None => range,
    };
    Ok(range.into())
}

fn sprung(options: &Options<'_, '_>, rest_length: f32) -> PyResult<Spring> {
    let hertz = needed(options, "hertz")?;
    Ok(Spring::new(rest_length, hertz, options.real("damping_ratio")?.unwrap_or(0.0)))
}

fn cone(options: &Options<'_, '_>) -> PyResult<JointKind> {
    let swing = options.with("swing", |field, value| match value.extract::<f64>() {
        Ok(_) => real(field, value).map(|swing| [swing; 2]),
        Err(_) => reals::<2>(field, value),
    })?;
    let [y, z] = swing.unwrap_or([FRAC_PI_2; 2]);
    let twist = options.with("twist", axis_def)?.unwrap_or(JointAxis::FREE);
    let mut joint = ConeTwist::of(twist, y, z);
    options.set_real("friction", &mut joint.swing_friction)?;
    if let Some(spring) = options.with("cone_spring", spring_def)? {
        joint = joint.with_soft_cone(spring);
    }
    Ok(joint.into())
}

fn six_dof(options: &Options<'_, '_>) -> PyResult<SixDof> {
    let mut joint = SixDof::FIXED;
    for (name, axis) in AXES.iter().zip(Axis::ALL) {
        if let Some(def) = options.with(name, axis_def)? {
            joint = joint.with_axis(*axis, def);
        }
    }
    if let Some(swing) = options.pair("cone")? {
        let spring = options.with("cone_spring", spring_def)?;
        joint.cone = Some(JointCone { swing, spring });
    }
    Ok(joint)
}

/// An axis: `'free'`, `'locked'`, or a dict of its options.
fn axis_def(field: &str, value: &Bound<'_, PyAny>) -> PyResult<JointAxis> {
    if value.is_instance_of::<PyString>() {
        let motions = [JointAxis::FREE, JointAxis::LOCKED];
        return one_of(field, value, &["free", "locked"]).map(|place| motions[place]);
    }
    let given = dict(field, value)?;
    let options = Options::new("an axis", Some(&given));
    let axis = axis_of(&options, JointAxis::FREE)?;
    options.finish()?;
    Ok(axis)
}

/// An axis from options that stand beside others.
fn axis_of(options: &Options<'_, '_>, mut axis: JointAxis) -> PyResult<JointAxis> {
    let spring = options.with("limit_spring", spring_def)?;
    if let Some([min, max]) = options.pair("limits")? {
        axis.motion = JointMotion::Limited { min, max, spring };
    } else if spring.is_some() {
        return Err(bad("limit_spring", "a spring", "given with `limits`"));
    }
    let (motor, servo) = (options.with("motor", motor_def)?, options.with("servo", servo_def)?);
    if motor.is_some() && servo.is_some() {
        return Err(bad("motor", "a motor and a servo", &one_only(&["motor", "servo"])));
    }
    axis.drive = motor.or(servo);
    options.set_real("friction", &mut axis.friction)?;
    Ok(axis)
}

/// A motor: speed [m/s; rad/s] and maximum force [N; N m].
fn motor_def(field: &str, value: &Bound<'_, PyAny>) -> PyResult<JointDrive> {
    reals::<2>(field, value).map(|[speed, max]| JointDrive::motor(speed, max))
}

/// A servo: target [m; rad], spring, and maximum force [N; N m] if it is limited.
fn servo_def(field: &str, value: &Bound<'_, PyAny>) -> PyResult<JointDrive> {
    let allowed = "a tuple of target, spring and, if it is limited, maximum force";
    let parts = value.cast::<PyTuple>().map_err(|_| wrong_type(field, value, allowed))?;
    let max = match parts.len() {
        2 => f32::INFINITY,
        3 => real(field, &parts.get_item(2)?)?,
        _ => return Err(bad(field, &shown(value), allowed)),
    };
    let target = real(field, &parts.get_item(0)?)?;
    Ok(JointDrive::servo(target, spring_def(field, &parts.get_item(1)?)?, max))
}

/// A spring: `hertz` and `damping_ratio`, alone or for a `load`, or `stiffness` and `damping`.
pub(crate) fn spring_def(field: &str, value: &Bound<'_, PyAny>) -> PyResult<JointSpring> {
    let given = dict(field, value)?;
    let options = Options::new("a spring", Some(&given));
    let (hertz, stiffness) = (options.real("hertz")?, options.real("stiffness")?);
    let spring = match (hertz, stiffness) {
        (Some(hertz), None) => {
            let ratio = options.real("damping_ratio")?.unwrap_or(1.0);
            match options.real("load")? {
                Some(load) => JointSpring::for_load(hertz, ratio, load),
                None => JointSpring::hertz(hertz, ratio),
            }
        }
        (None, Some(stiffness)) => {
            JointSpring::new(stiffness, options.real("damping")?.unwrap_or(0.0))
        }
        _ => return Err(bad(field, &shown(value), "a dict with either `hertz` or `stiffness`")),
    };
    options.finish()?;
    Ok(spring)
}
