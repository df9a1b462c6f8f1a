//! Hard limits against motors, loads and errors at the start.

use drystone::joint::{Hinge, Slider};
use drystone::{BodyDef, BodyId, JointDef, JointId, ShapeDef, Vec3, World, WorldConfig, vec3};

/// Frequency of swept joints over that of substeps.
const SOFT: f32 = 0.15;

/// Maximum closing speed of limits: of sliders [m/s], of hinges [rad/s].
const CLOSING: [f32; 2] = [3.0, 9.0];

/// A slider (0) or hinge (1) along or about x, at coordinate 0.
struct Stop {
    world: World,
    body: BodyId,
    joint: JointId,
}

/// `motor`: speed and maximum force.
fn stop(kind: usize, mass: f32, range: [f32; 2], motor: Option<[f32; 2]>, direct: bool) -> Stop {
    let config = WorldConfig { gravity: Vec3::ZERO, ..WorldConfig::default() };
    let mut world = World::new(config).unwrap();
    let post = world.add_body(BodyDef::fixed()).unwrap();
    // 2/5 m r² is m/10.
    let ball = BodyDef::dynamic().with_shape(ShapeDef::sphere(0.5)).with_mass(mass);
    let body = world.add_body(BodyDef { can_sleep: false, ..ball }).unwrap();
    let [low, high] = range;
    let def = if kind == 0 {
        let slider = Slider::new().with_limits(low, high);
        let slider = motor.map_or(slider, |[v, f]| slider.with_motor(v, f));
        JointDef::new(post, body, slider)
    } else {
        let hinge = Hinge::new().with_limits(low, high);
        let hinge = motor.map_or(hinge, |[v, f]| hinge.with_motor(v, f));
        JointDef::new(post, body, hinge)
    };
    let def = def.at(Vec3::ZERO).with_axis(Vec3::X).with_articulated(direct);
    let joint = world.add_joint(def).unwrap();
    Stop { world, body, joint }
}

impl Stop {
    fn place(&self, kind: usize) -> f32 {
        let joint = self.world.joint(self.joint).unwrap();
        if kind == 0 { joint.slider().unwrap().position() } else { joint.angle().unwrap() }
    }
}

/// On arrival the overshoot is less than a substep at 0.5 m/s. At rest the impulses of motor and
/// stop are opposite, and their rounding leaves 2⁻²³ of 4096 closing speeds a substep, twice. The
/// stop's spring takes that back at a rate of m ω/(4 + ω h), m = 0.82: at 30 Hz 37 /s.
#[test]
fn no_motor_runs_through_a_hard_stop() {
    for kind in [0, 1] {
        for (mass, force) in [
            (0.001, 1.0),
            (0.001, 1.0e7),
            (1.0, 1.0e4),
            (1.0, 1.0e7),
            (1.0e3, 1.0e3),
            (1.0e3, 1.0e7),
        ] {
            for hertz in [30.0, 60.0, 240.0] {
                for (speed, direct) in [(0.5, false), (-0.5, false), (0.5, true)] {
                    let mut at = stop(kind, mass, [-0.1, 0.1], Some([speed, force]), direct);
                    let (mut deepest, mut steps) = (0.0_f32, 0.0);
                    while steps < 2.0 * hertz {
                        at.world.step(1.0 / hertz);
                        deepest = deepest.max(at.place(kind).abs() - 0.1);
                        steps += 1.0;
                    }
                    let what = format!("{kind} {mass} kg {force} N {hertz} Hz {speed} {direct}");
                    let rounding = 2.0 * 4096.0 * CLOSING[kind] / 8_388_608.0;
                    let most = rounding / 37.0 + 1.0e-6;
                    assert!(deepest < 0.5 / (8.0 * hertz) + most, "{what}: {deepest} beyond");
                    let place = at.place(kind) * speed.signum();
                    assert!((place - 0.1).abs() < most, "{what}: at {place}");
                }
            }
        }
    }
}

/// A soft row yields by F/(m ω²), for any load. (With a bound on its load, 8 kN ran through.)
#[test]
fn a_stop_bears_any_load_that_bodies_press_on_it() {
    for force in [100.0, 2.0e4, 1.0e6] {
        for hertz in [60.0, 240.0] {
            let mut at = stop(0, 1.0, [-0.1, 0.1], None, false);
            let load = vec3(force, 0.0, 0.0);
            for _ in 0..240 {
                at.world.body_mut(at.body).unwrap().set_lasting_force(load);
                at.world.step(1.0 / hertz);
            }
            let omega = core::f32::consts::TAU * SOFT * 8.0 * hertz;
            let yielded = at.place(0) - 0.1;
            let ideal = force / (omega * omega);
            assert!(yielded < 1.05 * ideal + 1.0e-5, "{force} N, {hertz} Hz: {yielded}, {ideal}");
        }
    }
}

#[test]
fn a_limit_that_starts_violated_closes_at_a_bounded_speed() {
    for (kind, name) in [(0, "slider"), (1, "hinge")] {
        for mass in [0.001, 1.0, 1.0e3] {
            for direct in [false, true] {
                let mut at = stop(kind, mass, [0.5, 1.0], None, direct);
                for _ in 0..120 {
                    let before = at.place(kind);
                    at.world.step(1.0 / 60.0);
                    let speed = (at.place(kind) - before) * 60.0;
                    let what = format!("{name} of {mass} kg, {direct}");
                    assert!(speed < CLOSING[kind] * 1.001, "{what}: {speed}");
                }
                // A limit only pushes, so the axis may coast on, up to the other limit.
                let place = at.place(kind);
                assert!(place > 0.499 && place < 1.001, "{name} of {mass} kg, {direct}: {place}");
            }
        }
    }
}
