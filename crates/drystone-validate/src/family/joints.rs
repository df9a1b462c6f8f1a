//! Bodies on joints: pendulums, chains, a seesaw.

use core::f64::consts::{FRAC_PI_2, FRAC_PI_4, PI};

use drystone::{BodyDef, JointKind, ShapeDef, vec3};
use drystone_bench::EngineError;
use drystone_scene::{Scene, SceneJoint};

use crate::lab::Lab;
use crate::numeric::{
    Crossings, D3, add, elliptic_k, narrow, norm, root, runge_kutta, scale, single, sub, turn,
    worst,
};
use crate::row::{Limits, Rows, Unit, limits};
use crate::setup::{G, Surface, add_ball_joint, ball, block, empty};
use crate::test::Test;

pub(crate) const TESTS: &[Test] = &[
    Test::new(
        "A22",
        "pendulum of 1 m, 60 s",
        "amplitude, ball joint and rod",
        "T = 4 √(L/g) K(sin(a/2)); E constant",
        pendulum,
    )
    .swept(),
    Test::new(
        "A24",
        "double pendulum let go from horizontal",
        "",
        "equations of motion (Runge-Kutta), 1 s; E constant, 10 s",
        double_pendulum,
    )
    .swept(),
    Test::new(
        "A30",
        "hanging chain of 50 links between fixed ends",
        "",
        "sag of the catenary of 50 rigid links",
        hanging_chain,
    ),
    Test::new(
        "A31",
        "chain of 16 links with a ball 1000 times as heavy as a link, 10 s",
        "hanging, swinging from 45°",
        "length constant",
        heavy_chain,
    ),
    Test::new(
        "A35",
        "seesaw on two ball joints",
        "lever 2 % (great: 0.5 %) longer on a side",
        "tips to the side of the larger m d",
        seesaw,
    ),
    Test::new(
        "G13",
        "pendulum, period over that of small swings",
        "amplitude",
        "2 K(sin(a/2))/π",
        period_ratio,
    ),
    Test::new(
        "H8",
        "chain of 10, 50 and 100 links with a ball of 1000 times a link, 10 s",
        "links",
        "length constant",
        long_chains,
    ),
];

/// Radius of a pendulum's ball [m].
const BOB: f64 = 0.05;

#[derive(Clone, Copy, PartialEq)]
enum Hold {
    Ball,
    Rod,
}

struct Swing {
    period: f64,
    loss: f64,
    gain: f64,
    stretch: f64,
}

/// Length of the simple pendulum with the same period [m].
fn equivalent_length(hold: Hold) -> f64 {
    // On a ball joint the ball rotates with the pendulum: (L² + 2/5 r²)/L. On a rod it does not.
    if hold == Hold::Ball { 1.0 + 0.4 * BOB * BOB } else { 1.0 }
}

fn swing(lab: &Lab, hold: Hold, angle: f64, seconds: f64) -> Result<Swing, EngineError> {
    let mut scene = empty("pendulum");
    let start = [angle.sin(), -angle.cos(), 0.0];
    let bob = scene.add("bob", ball(BOB, narrow(start), Surface::rough(0.5)));
    let post = scene.add("post", BodyDef::fixed());
    match hold {
        Hold::Ball => add_ball_joint(&mut scene, post, bob, [0.0; 3])?,
        Hold::Rod => {
            let kind = JointKind::Distance { min: 1.0, max: 1.0, spring: None };
            let ends = [post, bob].map(|number| (number, drystone::Vec3::ZERO));
            scene.joints.push(SceneJoint::new(ends[0], ends[1], kind));
        }
    }
    let mut run = lab.start(scene)?;
    let (e0, size) = (run.energy(), run.matter(bob).mass * G * (1.0 - angle.cos()));
    let mut seen = Crossings::default();
    let mut swing = Swing { period: 0.0, loss: 0.0, gain: 0.0, stretch: 0.0 };
    run.until(seconds, |run| {
        let place = run.body(bob).center;
        seen.read(run.time(), place[0].atan2(-place[1]));
        let change = (run.energy() - e0) / size;
        swing.gain = worst(swing.gain, change);
        swing.loss = worst(swing.loss, -change);
        swing.stretch = worst(swing.stretch, (norm(place) - 1.0).abs());
    });
    swing.period = seen.period();
    Ok(swing)
}

/// Period of a simple pendulum [s].
fn period(length: f64, angle: f64) -> f64 {
    let k = (0.5 * angle).sin();
    4.0 * (length / G).sqrt() * elliptic_k(k * k)
}

fn pendulum(lab: &Lab, rows: &mut Rows) -> Result<(), EngineError> {
    for (hold, name) in [(Hold::Ball, "ball joint"), (Hold::Rod, "rod")] {
        for (degrees, must, great) in [
            (10.0, 0.002, 0.0002),
            (45.0, 0.002, 0.0002),
            (90.0, 0.005, 0.002),
            (150.0, 0.03, 0.015),
        ] {
            let angle = f64::to_radians(degrees);
            let swing = match swing(lab, hold, angle, 60.0) {
                Ok(swing) => swing,
                // Peers are only required to have ball joints.
                Err(_) if hold == Hold::Rod && !lab.candidate.is_own() => return Ok(()),
                Err(e) => return Err(e),
            };
            let case = |what: &str| format!("{name}, {degrees}°, {what}");
            let exact = period(equivalent_length(hold), angle);
            rows.relative(case("T"), exact, swing.period, limits(must, great));
            rows.at_most(case("E lost"), swing.loss, Unit::Part, limits(0.03, 0.01));
            rows.at_most(case("E gained"), swing.gain, Unit::Part, limits(0.01, 0.002));
            rows.at_most(case("stretch"), swing.stretch, Unit::Part, limits(0.003, 0.001));
        }
    }
    Ok(())
}

/// Period relative to that of small swings, within the limits of A22 for amplitudes up to 60°, up
/// to 90°, and beyond.
fn period_ratio(lab: &Lab, rows: &mut Rows) -> Result<(), EngineError> {
    for degrees in [5.0, 15.0, 30.0, 45.0, 60.0, 90.0, 120.0, 150.0, 170.0] {
        let swing = swing(lab, Hold::Ball, f64::to_radians(degrees), 60.0)?;
        let small = 2.0 * PI * (equivalent_length(Hold::Ball) / G).sqrt();
        let k = (0.5 * f64::to_radians(degrees)).sin();
        let near: Limits = match degrees {
            d if d <= 60.0 => limits(0.002, 0.0002),
            d if d <= 90.0 => limits(0.005, 0.002),
            _ => limits(0.03, 0.015),
        };
        let exact = 2.0 * elliptic_k(k * k) / PI;
        rows.relative(format!("{degrees}°"), exact, swing.period / small, near);
    }
    Ok(())
}

/// Rates of two equal pendulums of 1 m, from their angles from the vertical and the rates of these.
/// The balls rotate with the pendulums.
fn double_rates([a, b, u, v]: &[f64; 4]) -> [f64; 4] {
    let spin = 0.4 * BOB * BOB;
    let (s, c) = (a - b).sin_cos();
    let (m11, m12, m22) = (2.0 + spin, c, 1.0 + spin);
    let f1 = -s * v * v - 2.0 * G * a.sin();
    let f2 = s * u * u - G * b.sin();
    let det = m11 * m22 - m12 * m12;
    [*u, *v, (m22 * f1 - m12 * f2) / det, (m11 * f2 - m12 * f1) / det]
}

fn double_pendulum(lab: &Lab, rows: &mut Rows) -> Result<(), EngineError> {
    let mut scene = empty("double pendulum");
    let upper = scene.add("upper", ball(BOB, vec3(1.0, 0.0, 0.0), Surface::rough(0.5)));
    let lower = scene.add("lower", ball(BOB, vec3(2.0, 0.0, 0.0), Surface::rough(0.5)));
    let post = scene.add("post", BodyDef::fixed());
    add_ball_joint(&mut scene, post, upper, [0.0; 3])?;
    add_ball_joint(&mut scene, upper, lower, [1.0, 0.0, 0.0])?;
    let mut run = lab.start(scene)?;
    let (e0, mass) = (run.energy(), run.matter(upper).mass);
    let mut x = [FRAC_PI_2, FRAC_PI_2, 0.0, 0.0];
    let (mut off, mut change) = (0.0, 0.0);
    run.until(10.0, |run| {
        let parts = 100;
        for _ in 0..parts {
            x = runge_kutta(&x, lab.dt() / f64::from(parts), double_rates);
        }
        let first = [x[0].sin(), -x[0].cos(), 0.0];
        let second = add(first, [x[1].sin(), -x[1].cos(), 0.0]);
        if run.time() < 1.0 + 0.5 * lab.dt() {
            off = worst(off, norm(sub(run.body(upper).center, first)));
            off = worst(off, norm(sub(run.body(lower).center, second)));
        }
        // Relative to the energy above the lowest position: 1 m for the upper ball, 2 m for the
        // lower one.
        change = worst(change, (run.energy() - e0).abs() / (3.0 * mass * G));
    });
    rows.at_most("path, 1 s", off, Unit::Meter, limits(0.01, 0.003));
    rows.at_most("E, 10 s", change, Unit::Part, limits(0.02, 0.005));
    Ok(())
}

/// Adds a capsule as a link between two points, and returns its number.
fn add_link(scene: &mut Scene, from: D3, to: D3, mass: f64) -> usize {
    let along = sub(to, from);
    let length = norm(along);
    let radius = 0.15 * length;
    let angle = along[1].atan2(along[0]) - FRAC_PI_2;
    let shape = ShapeDef::capsule(single(0.5 * length - radius), single(radius));
    let def = BodyDef::dynamic()
        .with_position(narrow(scale(add(from, to), 0.5)))
        .with_rotation(turn([0.0, 0.0, 1.0], angle))
        .with_shape(shape)
        .with_mass(single(mass));
    scene.add(format!("link {}", scene.bodies.len()), def)
}

/// Sag of an even number of rigid links of equal length between two points `span` apart [m].
fn sag(links: u32, length: f64, span: f64) -> f64 {
    // The force at a link's middle acts along it: H horizontally, the weight below it vertically.
    let sums = |h: f64| {
        (1..=links / 2).fold((0.0, 0.0), |(x, y), k| {
            let slope = (f64::from(k) - 0.5) / h;
            let c = 1.0 / (1.0 + slope * slope).sqrt();
            (x + length * c, y + length * c * slope)
        })
    };
    let h = root(1.0e-3, 1.0e6, |h| sums(h).0 - 0.5 * span);
    sums(h).1
}

fn hanging_chain(lab: &Lab, rows: &mut Rows) -> Result<(), EngineError> {
    let (links, length, span) = (50_u32, 0.2, 8.0);
    let mut scene = empty("chain");
    let post = scene.add("posts", BodyDef::fixed());
    // The chain starts as a V: 5 m of chain on each side, 3 m deep.
    let point = |i: u32| {
        let way = f64::from(i) * length;
        if way <= 5.0 {
            [0.8 * way, -0.6 * way, 0.0]
        } else {
            [0.8 * way, -0.6 * (10.0 - way), 0.0]
        }
    };
    let mut bodies = vec![post];
    for i in 0..links {
        let link = add_link(&mut scene, point(i), point(i + 1), 1.0);
        // Damping brings the chain to rest.
        scene.bodies[link].def.linear_damping = 0.5;
        scene.bodies[link].def.angular_damping = 0.5;
        bodies.push(link);
    }
    bodies.push(post);
    for (pair, i) in bodies.windows(2).zip(0..) {
        add_ball_joint(&mut scene, pair[0], pair[1], point(i))?;
    }
    let middle = bodies[usize::try_from(links / 2).unwrap_or(0)];
    let mut run = lab.start(scene)?;
    run.until(40.0, |_| {});
    let now = run.body(middle);
    let low = add(now.center, scale(now.direction([0.0, 1.0, 0.0]), 0.5 * length));
    rows.relative("sag", sag(links, length, span), -low[1], limits(0.01, 0.003));
    rows.at_most("gap", run.overlap()?.1, Unit::Meter, limits(0.002, 0.0005));
    Ok(())
}

/// Maximum stretch of a chain in 10 s, as a fraction of its length. Its links have 0.2 m and 1 kg,
/// with a ball of 1000 kg at the end. It starts at an angle from the vertical.
fn stretch(lab: &Lab, links: u32, angle: f64) -> Result<f64, EngineError> {
    let (length, radius) = (0.2, 0.3);
    let way = [angle.sin(), -angle.cos(), 0.0];
    let point = |i: u32| scale(way, f64::from(i) * length);
    let mut scene = empty("heavy chain");
    let mut last = scene.add("post", BodyDef::fixed());
    for i in 0..links {
        let link = add_link(&mut scene, point(i), point(i + 1), 1.0);
        add_ball_joint(&mut scene, last, link, point(i))?;
        last = link;
    }
    let end = f64::from(links) * length;
    let weight = ball(radius, narrow(scale(way, end + radius)), Surface::rough(0.5));
    let weight = scene.add("ball", weight.with_mass(1000.0));
    add_ball_joint(&mut scene, last, weight, point(links))?;
    let mut run = lab.start(scene)?;
    let mut most = 0.0;
    run.until(10.0, |run| {
        let now = run.body(weight);
        // The ball's anchor, on its surface.
        let anchor = now.direction(scale(way, -radius));
        let reach = norm(add(now.center, anchor));
        most = worst(most, reach / end - 1.0);
    });
    Ok(most)
}

fn heavy_chain(lab: &Lab, rows: &mut Rows) -> Result<(), EngineError> {
    for (case, angle) in [("hanging", 0.0), ("swinging", FRAC_PI_4)] {
        let most = stretch(lab, 16, angle)?;
        rows.at_most(case, most, Unit::Part, limits(0.02, 0.002));
    }
    Ok(())
}

fn long_chains(lab: &Lab, rows: &mut Rows) -> Result<(), EngineError> {
    for links in [10, 50, 100] {
        let most = stretch(lab, links, 0.0)?;
        rows.at_most(format!("{links} links"), most, Unit::Part, limits(0.02, 0.002));
    }
    Ok(())
}

/// Height of the right end above the left end after 2 s [m]. The right lever has `part` times the
/// length that balances.
fn seesaw_tilt(lab: &Lab, part: f64) -> Result<f64, EngineError> {
    let surface = Surface::rough(0.8);
    let mut scene = empty("seesaw");
    let plank = block([5.0, 0.1, 0.5], vec3(0.0, 1.0, 0.0), surface).with_mass(10.0);
    let plank = scene.add("plank", plank);
    let post = scene.add("post", BodyDef::fixed());
    for z in [-0.25, 0.25] {
        add_ball_joint(&mut scene, post, plank, [0.0, 1.0, z])?;
    }
    for (x, mass) in [(-1.5, 20.0), (2.0 * part, 15.0)] {
        let weight = block([0.4; 3], narrow([x, 1.25, 0.0]), surface).with_mass(mass);
        scene.add(format!("weight {mass}"), weight);
    }
    let mut run = lab.start(scene)?;
    run.until(2.0, |_| {});
    Ok(5.0 * run.body(plank).direction([1.0, 0.0, 0.0])[1])
}

fn seesaw(lab: &Lab, rows: &mut Rows) -> Result<(), EngineError> {
    let heights = [0.98, 0.995, 1.005, 1.02].map(|part| seesaw_tilt(lab, part));
    let [left, left_harder, right_harder, right] = heights;
    // At least 1 mm, to the correct side.
    rows.holds("left is heavier", left? > 1.0e-3, left_harder? > 1.0e-3);
    rows.holds("right is heavier", right? < -1.0e-3, right_harder? < -1.0e-3);
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::{BOB, G, Hold, double_rates, equivalent_length, period, sag};
    use crate::numeric::runge_kutta;

    #[test]
    fn periods_are_those_of_the_list() {
        for (degrees, t) in [(10.0, 2.0099), (45.0, 2.0863), (90.0, 2.3678), (150.0, 3.5351)] {
            let own = period(equivalent_length(Hold::Rod), f64::to_radians(degrees));
            assert!((own - t).abs() < 6.0e-5, "{degrees}: {own}");
        }
        assert!((equivalent_length(Hold::Ball) - 1.001).abs() < 1.0e-12);
    }

    #[test]
    fn the_double_pendulum_keeps_its_energy() {
        let spin = 0.4 * BOB * BOB;
        let energy = |x: &[f64; 4]| {
            let [a, b, u, v] = *x;
            let turning = 0.5 * (2.0 + spin) * u * u + 0.5 * (1.0 + spin) * v * v;
            turning + u * v * (a - b).cos() - G * (2.0 * a.cos() + b.cos())
        };
        let mut x = [1.5, 1.0, 0.3, -0.2];
        let e0 = energy(&x);
        for _ in 0..20_000 {
            x = runge_kutta(&x, 1.0e-4, double_rates);
        }
        assert!((energy(&x) - e0).abs() < 1.0e-9, "{}", energy(&x) - e0);
    }

    #[test]
    fn many_links_hang_like_the_catenary() {
        // Length 10, span 8: 2 c sinh(4/c) = 10, sag c (cosh(4/c) − 1).
        let c = crate::numeric::root(1.0, 100.0, |c| 2.0 * c * (4.0 / c).sinh() - 10.0);
        let exact = c * ((4.0 / c).cosh() - 1.0);
        assert!((sag(50, 0.2, 8.0) / exact - 1.0).abs() < 2.0e-3, "{}", sag(50, 0.2, 8.0));
        assert!((sag(2000, 0.005, 8.0) / exact - 1.0).abs() < 1.0e-5);
    }
}
