//! Building worlds by hand: bodies, joints, rules.

use drystone::breakage::{BondStrength, Fracture, Glue};
use drystone::contact::{ContactSoftness, SurfaceRule};
use drystone::joint::CouplingDef;
use drystone::journal::{Answer, Call};
use drystone::math::Sym3;
use drystone::{Axis, AxisLocks, BodyDef, BodyKind, MassDef, Vec3};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyString};

use super::{PyWorld, body_id, gone, joint_id};
use crate::arrays::{numbers, real, reals, shown, vector};
use crate::body::PyBody;
use crate::errors::{bad, refused};
use crate::joint::{axis_named, definition};
use crate::joint_ref::PyJoint;
use crate::options::{Options, one_of};
use crate::shape::shapes;

#[pymethods]
impl PyWorld {
    /// Adds a body; `kind` is 'dynamic', 'static' or 'kinematic'.
    ///
    /// Keywords: `shapes` (a Shape or a list), `position` [m, world], `rotation` [w, x, y, z],
    /// `linear_velocity` [m/s, world], `angular_velocity` [rad/s, world], `name`;
    /// `mass` [kg], alone or with `center_of_mass` [m, body] and `inertia` (3 or 3 by 3) [kg m²];
    /// `density` [kg/m³], `friction` and `restitution` of all its shapes; `gravity_scale`,
    /// `linear_damping` [1/s], `angular_damping` [1/s], `lock_linear`, `lock_angular` (3 flags,
    /// world axes), `can_sleep`, `sleep_speed` [m/s], `asleep`, `enabled`, `user_data`;
    /// `glue` ([Pa], or tension and shear) with `glue_gap` [m]; `fracture`, a dict.
    #[pyo3(signature = (kind="dynamic", **options))]
    fn add_body(
        slf: &Bound<'_, Self>,
        kind: &str,
        options: Option<&Bound<'_, PyDict>>,
    ) -> PyResult<PyBody> {
        let (def, name) = body_def(slf.py(), kind, options)?;
        let mut state = slf.get().lock()?;
        if !name.is_empty() && state.named(&name).is_some() {
            return Err(bad("name", &format!("'{name}'"), "a name that no other body has"));
        }
        let id = state.run.world.add_body(def).map_err(|e| refused(&e))?;
        if !name.is_empty() {
            state.names.insert(name, id);
        }
        Ok(PyBody { world: slf.clone().unbind(), id })
    }

    /// The body of a name, or of an id.
    fn body(slf: &Bound<'_, Self>, body: &Bound<'_, PyAny>) -> PyResult<PyBody> {
        let id = body_id(slf, "body", body)?;
        Ok(PyBody { world: slf.clone().unbind(), id })
    }

    /// Removes a body with its shapes and joints.
    fn remove_body(slf: &Bound<'_, Self>, body: &Bound<'_, PyAny>) -> PyResult<()> {
        let id = body_id(slf, "body", body)?;
        match slf.get().apply(&Call::RemoveBody(id))? {
            Answer::Nothing => Err(gone("body", id.to_bits())),
            _ => Ok(()),
        }
    }

    /// Adds a joint of this kind between two bodies (`Body`, id or name).
    ///
    /// Place: `at` a point, `between` two points [m, world], or `anchors` [m, each body]; `axis`,
    /// `axes` (x and y) or `rotation` [world]. All kinds: `collide_connected`, `articulated`,
    /// `enabled`, `break_force` [N], `break_torque` [N m], `break_impulse` [N s], `fatigue`,
    /// `user_data`. The README lists the kinds and the options of each.
    #[pyo3(signature = (kind, body_a, body_b, **options))]
    fn add_joint(
        slf: &Bound<'_, Self>,
        kind: &str,
        body_a: &Bound<'_, PyAny>,
        body_b: &Bound<'_, PyAny>,
        options: Option<&Bound<'_, PyDict>>,
    ) -> PyResult<PyJoint> {
        let bodies = [body_id(slf, "body_a", body_a)?, body_id(slf, "body_b", body_b)?];
        let def = definition(kind, bodies, options)?;
        let id = slf.get().lock()?.run.world.add_joint(def).map_err(|e| refused(&e))?;
        Ok(PyJoint { world: slf.clone().unbind(), id })
    }

    /// Couples an axis of two joints: coordinate b = ratio · coordinate a + offset. The axes are
    /// 'x', 'y', 'z', 'turn_x', 'turn_y' or 'turn_z'.
    #[pyo3(signature = (joint_a, joint_b, ratio, *, offset=0.0, axis_a=None, axis_b=None))]
    fn add_coupling(
        slf: &Bound<'_, Self>,
        joint_a: &Bound<'_, PyAny>,
        joint_b: &Bound<'_, PyAny>,
        ratio: f32,
        offset: f32,
        axis_a: Option<&Bound<'_, PyAny>>,
        axis_b: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<PyJoint> {
        let axis = |name: &str, given: Option<&Bound<'_, PyAny>>| {
            given.map_or(Ok(Axis::TurnX), |given| axis_named(name, given))
        };
        let (axis_a, axis_b) = (axis("axis_a", axis_a)?, axis("axis_b", axis_b)?);
        let (joint_a, joint_b) =
            (joint_id(slf, "joint_a", joint_a)?, joint_id(slf, "joint_b", joint_b)?);
        let def = CouplingDef { joint_a, axis_a, joint_b, axis_b, ratio, offset };
        let id = slf.get().lock()?.run.world.add_coupling(def).map_err(|e| refused(&e))?;
        Ok(PyJoint { world: slf.clone().unbind(), id })
    }

    /// All joints and couplings, in the order of their ids.
    #[getter]
    fn joints(slf: &Bound<'_, Self>) -> PyResult<Vec<PyJoint>> {
        let state = slf.get().lock()?;
        let world = |id| PyJoint { world: slf.clone().unbind(), id };
        Ok(state.run.world.joints().map(|joint| world(joint.id())).collect())
    }

    /// Sets whether two bodies collide at all.
    fn set_bodies_collide(
        slf: &Bound<'_, Self>,
        body_a: &Bound<'_, PyAny>,
        body_b: &Bound<'_, PyAny>,
        collide: bool,
    ) -> PyResult<()> {
        let (a, b) = (body_id(slf, "body_a", body_a)?, body_id(slf, "body_b", body_b)?);
        slf.get().lock()?.run.world.set_bodies_collide(a, b, collide);
        Ok(())
    }

    /// Replaces the rules for surfaces of some layers: dicts of `first` and `second` (layers, as
    /// bits), `friction`, `kinetic_friction`, `restitution`, `hertz` and `damping_ratio`. The first
    /// rule that matches a pair is used.
    fn set_surface_rules(&self, rules: Vec<Bound<'_, PyDict>>) -> PyResult<()> {
        let rules: Vec<_> = rules.iter().map(|rule| surface_rule(rule)).collect::<PyResult<_>>()?;
        self.lock()?.run.world.set_surface_rules(rules).map_err(|e| refused(&e))
    }

    /// Sets the rule for the surfaces of two bodies; None removes it.
    fn set_surface_between(
        slf: &Bound<'_, Self>,
        body_a: &Bound<'_, PyAny>,
        body_b: &Bound<'_, PyAny>,
        rule: Option<&Bound<'_, PyDict>>,
    ) -> PyResult<()> {
        let (a, b) = (body_id(slf, "body_a", body_a)?, body_id(slf, "body_b", body_b)?);
        let rule = rule.map(surface_rule).transpose()?;
        let world = &mut slf.get().lock()?.run.world;
        world.set_surface_between(a, b, rule).map_err(|e| refused(&e))
    }
}

fn surface_rule(given: &Bound<'_, PyDict>) -> PyResult<SurfaceRule> {
    let options = Options::new("a surface rule", Some(given));
    let mut rule = SurfaceRule::ANY;
    options.set_whole("first", &mut rule.first)?;
    options.set_whole("second", &mut rule.second)?;
    rule.friction = options.real("friction")?;
    rule.kinetic_friction = options.real("kinetic_friction")?;
    rule.restitution = options.real("restitution")?;
    let (hertz, damping_ratio) = (options.real("hertz")?, options.real("damping_ratio")?);
    rule.softness = match (hertz, damping_ratio) {
        (None, None) => None,
        (Some(hertz), damping_ratio) => {
            Some(ContactSoftness { hertz, damping_ratio: damping_ratio.unwrap_or(1.0) })
        }
        (None, Some(_)) => return Err(bad("damping_ratio", "a number", "given with `hertz`")),
    };
    options.finish()?;
    Ok(rule)
}

/// The definition of a body and its name.
fn body_def(
    py: Python<'_>,
    kind: &str,
    given: Option<&Bound<'_, PyDict>>,
) -> PyResult<(BodyDef, String)> {
    let options = Options::new("a body", given);
    let kinds = [BodyKind::Dynamic, BodyKind::Static, BodyKind::Kinematic];
    let names = ["dynamic", "static", "kinematic"];
    let kind = kinds[one_of("kind", PyString::new(py, kind).as_any(), &names)?];
    let mut def = BodyDef { kind, ..BodyDef::default() };
    let name = options.word("name")?.unwrap_or_default();
    if let Some(made) = options.with("shapes", shapes)? {
        def.shapes = made;
    }
    options.set_vector("position", &mut def.position)?;
    if let Some(rotation) = options.rotation("rotation")? {
        def.rotation = rotation;
    }
    options.set_vector("linear_velocity", &mut def.linear_velocity)?;
    options.set_vector("angular_velocity", &mut def.angular_velocity)?;
    for shape in &mut def.shapes {
        options.set_real("density", &mut shape.density)?;
        options.set_real("friction", &mut shape.material.friction)?;
        options.set_real("restitution", &mut shape.material.restitution)?;
    }
    if def.shapes.is_empty() {
        for name in ["density", "friction", "restitution"] {
            if options.get(name)?.is_some() {
                return Err(bad(name, "a number", "given to a body with shapes"));
            }
        }
    }
    def.mass = mass(&options)?;
    options.set_real("gravity_scale", &mut def.gravity_scale)?;
    options.set_real("linear_damping", &mut def.linear_damping)?;
    options.set_real("angular_damping", &mut def.angular_damping)?;
    let AxisLocks { linear, angular } = &mut def.locks;
    for (name, locks) in [("lock_linear", linear), ("lock_angular", angular)] {
        if let Some(flags) = options.with(name, reals::<3>)? {
            *locks = flags.map(|flag| flag != 0.0);
        }
    }
    options.set_flag("can_sleep", &mut def.can_sleep)?;
    def.sleep_speed = options.real("sleep_speed")?;
    options.set_flag("asleep", &mut def.asleep)?;
    options.set_flag("enabled", &mut def.enabled)?;
    options.set_whole("user_data", &mut def.user_data)?;
    let gap = options.real("glue_gap")?;
    if let Some(strength) = options.with("glue", bond_strength)? {
        let glue = Glue::touching(&def.shapes, gap.unwrap_or(1.0e-3), strength);
        def.glue = Some(glue.map_err(|e| refused(&e))?);
    } else if gap.is_some() {
        return Err(bad("glue_gap", "a length", "given with `glue`"));
    }
    def.fracture = options.dict("fracture")?.map(|given| fracture(&given)).transpose()?;
    options.finish()?;
    Ok((def, name))
}

fn mass(options: &Options<'_, '_>) -> PyResult<MassDef> {
    let mass = options.real("mass")?;
    let inertia = options.with("inertia", inertia)?;
    let center = options.vector("center_of_mass")?;
    match (mass, inertia, center) {
        (None, None, None) => Ok(MassDef::FromShapes),
        (Some(mass), None, None) => Ok(MassDef::Mass(mass)),
        (Some(mass), Some(inertia), center) => {
            Ok(MassDef::Exact { mass, center: center.unwrap_or(Vec3::ZERO), inertia })
        }
        (None, ..) => Err(bad("mass", "nothing", "given with `inertia` or `center_of_mass`")),
        (_, None, Some(_)) => Err(bad("inertia", "nothing", "given with `center_of_mass`")),
    }
}

/// A diagonal, or a symmetric matrix.
fn inertia(field: &str, value: &Bound<'_, PyAny>) -> PyResult<Sym3> {
    if value.len().is_ok_and(|length| length == 3) && value.get_item(0)?.extract::<f64>().is_ok() {
        return vector(field, value).map(Sym3::diagonal);
    }
    let m = numbers(field, value, &[3, 3])?;
    let is_symmetric = [(1, 3), (2, 6), (5, 7)]
        .into_iter()
        .all(|(i, k)| (m[i] - m[k]).abs() <= 1.0e-5 * (m[0].abs() + m[4].abs() + m[8].abs()));
    if !is_symmetric {
        return Err(bad(field, &shown(value), "a symmetric matrix"));
    }
    Ok(Sym3 { xx: m[0], yy: m[4], zz: m[8], xy: m[1], xz: m[2], yz: m[5] })
}

/// A stress [Pa], or a tension and a shear.
fn bond_strength(field: &str, value: &Bound<'_, PyAny>) -> PyResult<BondStrength> {
    if value.extract::<f64>().is_ok() {
        return real(field, value).map(BondStrength::both);
    }
    reals::<2>(field, value).map(|[tension, shear]| BondStrength { tension, shear })
}

/// Settings of a fracture from a dict of their names.
pub(crate) fn fracture(given: &Bound<'_, PyDict>) -> PyResult<Fracture> {
    let options = Options::new("a fracture", Some(given));
    let mut how = Fracture::default();
    options.set_real("impulse", &mut how.impulse)?;
    options.set_real("energy", &mut how.energy)?;
    options.set_whole("pieces", &mut how.pieces)?;
    options.set_real("min_size", &mut how.min_size)?;
    options.set_whole("focus", &mut how.focus)?;
    options.set_whole("generations", &mut how.generations)?;
    options.set_whole("seed", &mut how.seed)?;
    options.finish()?;
    Ok(how)
}
