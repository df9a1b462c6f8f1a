//! Joints with wide gaps, as after a body was moved: classic methods close them at a common speed,
//! and throw nothing.

use drystone::joint::SixDof;
use drystone::method::Method;
use drystone::{BodyDef, JointDef, JointKind, ShapeDef, Vec3, World, WorldConfig};

const DT: f32 = 1.0 / 60.0;

/// Joints close at 3 m/s, and wide gaps at up to 10 m/s more.
const FASTEST: f32 = 13.0;

/// Maximum speed at which a joint closes this gap: of the ball's displacement per step, or its
/// stored velocity.
fn speed_of_closing(method: &str, kind: JointKind, gap: f32) -> f32 {
    let method = Method::named(method).unwrap();
    let mut world =
        World::new(WorldConfig { method, gravity: Vec3::ZERO, ..WorldConfig::default() }).unwrap();
    let post = world.add_body(BodyDef::fixed()).unwrap();
    let ball = BodyDef::dynamic().with_position([gap, 0.0, 0.0]).with_shape(ShapeDef::sphere(0.1));
    let ball = world.add_body(ball).unwrap();
    let joint = JointDef::new(post, ball, kind).with_anchors(Vec3::ZERO, Vec3::ZERO);
    world.add_joint(joint).unwrap();
    let (mut most, mut last) = (0.0_f32, Vec3::X * gap);
    for _ in 0..30 {
        world.step(DT);
        let ball = world.body(ball).unwrap();
        let way = (ball.position() - last).length() / DT;
        most = most.max(way).max(ball.linear_velocity().length());
        last = ball.position();
    }
    most
}

#[test]
fn a_wide_gap_closes_no_faster_than_the_caps_in_classic_methods() {
    let kinds: [(&str, JointKind); 3] = [
        ("ball", JointKind::Ball),
        ("rope", JointKind::Distance { min: 0.0, max: 0.1, spring: None }),
        ("fixed", JointKind::SixDof(SixDof::FIXED)),
    ];
    for method in Method::NAMES.iter().filter(|name| !name.starts_with("soft-step")) {
        for (name, kind) in kinds {
            for gap in [2.0, 20.0, 200.0] {
                let speed = speed_of_closing(method, kind, gap);
                // A displacement is the difference of two positions, each rounded to 2^-24 of the
                // gap.
                let rounding = 2.0 * gap * f32::EPSILON / DT + 10.0 * FASTEST * f32::EPSILON;
                assert!(
                    speed > 1.0 && speed < FASTEST + rounding,
                    "{method}, {name}, {gap} m: {speed} m/s"
                );
            }
        }
    }
}
