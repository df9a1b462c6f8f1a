//! Bodies at rest on others: weight, tipping, piles, columns, arches.

use core::f64::consts::PI;

use drystone::{BodyDef, Hull, Shape, ShapeDef, vec3};
use drystone_bench::EngineError;
use drystone_scene::Scene;

use super::impact::add_666;
use crate::lab::{Lab, Protocol, Run};
use crate::numeric::{Random, narrow, single, turn, worst};
use crate::row::{Rows, Unit, limits};
use crate::setup::{G, Slope, Surface, add_floor, ball, block, empty};
use crate::test::Test;

pub(crate) const TESTS: &[Test] = &[
    Test::new(
        "A7",
        "force on the floor under 500 settled balls",
        "",
        "sum of the weights",
        floor_force,
    ),
    Test::new(
        "A34",
        "box on a slope, µ 2, 10 s",
        "slope 1 % (great: 0.3 %) below and above",
        "tips if tan > w/h",
        tipping,
    ),
    Test::new("A36", "column of unit cubes, 60 s", "cubes", "at rest", stack),
    Test::new(
        "A37",
        "large mass ratios, 60 s",
        "1000 kg on 1 kg, pyramid with a top 300 times as heavy",
        "at rest",
        mass_ratio,
    ),
    Test::new("A38", "arch, card house, tower of bricks", "size", "stands", masonry),
    Test::new("A38b", "ring of Kapla bricks (102 in all), 60 s and 600 s", "", "stands", kapla)
        .long(),
    Test::new(
        "S3",
        "SimBenchmark 666: 216 balls fall on the ground, e 0, 10 s",
        "",
        "no overlap; error: mean over steps of the sum of squared depths",
        balls_666,
    )
    .swept(),
    Test::new(
        "G20",
        "column 1 × 4 let go tilted",
        "angle 2 % below and above",
        "falls over if the angle > atan(1/4) = 14.04°",
        tilted_column,
    ),
    Test::new(
        "G21",
        "overhanging stack of 10 boxes, 20 s",
        "offset 3 % below and above",
        "stands if N d < w; harmonic offsets w/(2 k) are the limit",
        overhang,
    ),
    Test::new(
        "G22",
        "leaning column of 10 cubes: when its top is below 7/10 of its height",
        "offset of each",
        "the same with 64 substeps, and every cube's own inertia",
        falling_columns,
    ),
    Test::new("H1", "column of unit cubes, 600 s", "cubes", "at rest", tall_column),
    Test::new(
        "H3",
        "column of 10 × 1 kg under a heavy cube, 60 s",
        "mass of the top",
        "at rest",
        heavy_top,
    ),
    Test::new("H4", "pyramids", "top mass, size", "at rest", pyramids),
    Test::new("H4b", "pyramid of 80 rows, 10,000 steps", "", "stands", large_pyramid).long(),
    Test::new("H5", "jenga tower and card houses, 60 s", "size", "stands", houses),
    Test::new(
        "H6",
        "semicircular arch of 51 stones, µ 0.7",
        "thickness over radius",
        "stands above 0.1075",
        thin_arch,
    ),
];

fn floor_force(lab: &Lab, rows: &mut Rows) -> Result<(), EngineError> {
    let (mut random, mut scene) = (Random::new(7), empty("bin"));
    let floor = add_floor(&mut scene, Surface::rough(0.5));
    let mut walls = BodyDef::fixed();
    for normal in [[1.0, 0.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, 0.0, -1.0]] {
        // Walls have no friction, so that the floor carries the whole weight.
        let wall = ShapeDef::half_space(normal, -0.95);
        walls = walls.with_shape(Surface::rough(0.0).on(wall));
    }
    scene.add("walls", walls);
    for i in 0..500 {
        let cell = [i % 8, i / 64, i / 8 % 8].map(f64::from);
        let place = [0.22 * (cell[0] - 3.5), 0.12 + 0.22 * cell[1], 0.22 * (cell[2] - 3.5)];
        let place = place.map(|x| x + random.between(-0.009, 0.009));
        scene.add(format!("ball {i}"), ball(0.1, narrow(place), Surface::rough(0.5)));
    }
    let mut run = lab.start(scene)?;
    let weight: f64 = run.dynamic().map(|body| run.matter(body).mass * G).sum();
    run.until(9.0, |_| {});
    let (mut force, mut readings) = (0.0, 0.0);
    while run.time() < 10.0 {
        run.step();
        force -= run.contact_force(floor)?[1];
        readings += 1.0;
    }
    rows.relative("mean of a second", weight, force / readings, limits(0.005, 0.001));
    Ok(())
}

/// Tilt of a box of 0.5 × 1 m relative to its slope after 10 s [rad].
fn tilt_on_slope(lab: &Lab, part: f64) -> Result<f64, EngineError> {
    let slope = Slope { angle: part * 0.5_f64.atan() };
    let surface = Surface::rough(2.0);
    let mut scene = empty("tipping");
    slope.add(&mut scene, surface);
    let def = block([0.5, 1.0, 0.5], slope.place(0.0, 0.5, 0.0), surface);
    let body = scene.add("box", def.with_rotation(slope.turn()));
    let mut run = lab.start(scene)?;
    run.until(10.0, |_| {});
    let up = run.body(body).direction([0.0, 1.0, 0.0]);
    Ok(crate::numeric::dot(up, slope.normal()).clamp(-1.0, 1.0).acos())
}

fn tipping(lab: &Lab, rows: &mut Rows) -> Result<(), EngineError> {
    let stands = |part| Ok::<_, EngineError>(tilt_on_slope(lab, part)? < 0.05);
    rows.holds("stands", stands(0.99)?, stands(0.997)?);
    rows.holds("tips", !stands(1.01)?, !stands(1.003)?);
    Ok(())
}

/// A column of cubes of 1 m and these masses [kg].
fn column(masses: &[f64]) -> Scene {
    let mut scene = empty("column");
    add_floor(&mut scene, Surface::rough(0.6));
    for (i, mass) in masses.iter().enumerate() {
        let place = vec3(0.0, single(0.5 + i as f64), 0.0);
        let cube = block([1.0; 3], place, Surface::rough(0.6)).with_mass(single(*mass));
        scene.add(format!("cube {i}"), cube);
    }
    scene
}

/// Final state of a structure that should stay at rest.
struct Rest {
    stands: bool,
    /// Maximum sideways displacement of a body [m].
    drift: f64,
    /// Maximum descent of a body [m].
    sag: f64,
    /// Maximum overlap at ten moments [m].
    depth: f64,
}

fn rest(lab: &Lab, scene: Scene, seconds: f64) -> Result<Rest, EngineError> {
    let mut run = lab.start(scene)?;
    let mut depth = 0.0;
    for look in 1..=10 {
        run.until(seconds * f64::from(look) / 10.0, |_| {});
        depth = worst(depth, run.overlap()?.0);
    }
    // A collapsed heap may have no overlap; that does not measure the depth of a column.
    let stands = run.stands();
    let (drift, sag) = run.drift_and_sag();
    Ok(Rest { stands, drift, sag, depth: if stands { depth } else { f64::NAN } })
}

/// Maximum descent of the top of a column of `n` unit cubes [m]: 0.5, 2.5, 5 and 15 cm for 10, 30,
/// 50 and 100 cubes, with linear interpolation. A36 allows contacts 6 mm deep. The top of 20 cubes
/// therefore sinks more than the 5 mm it may drift. Drift continues for as long as the column
/// stands. Sinking happens once, so it has its own row.
fn column_sag(n: usize) -> f64 {
    let known: [(usize, f64); 4] = [(10, 0.005), (30, 0.025), (50, 0.05), (100, 0.15)];
    let after = known.partition_point(|(count, _)| *count < n).clamp(1, known.len() - 1);
    let ((n0, low), (n1, high)) = (known[after - 1], known[after]);
    low + (high - low) * (n as f64 - n0 as f64) / (n1 - n0) as f64
}

fn stack(lab: &Lab, rows: &mut Rows) -> Result<(), EngineError> {
    for n in [10_u16, 20] {
        let count = usize::from(n);
        let Rest { drift, sag, depth, .. } = rest(lab, column(&vec![1000.0; count]), 60.0)?;
        rows.at_most(format!("{n}, drift"), drift, Unit::Meter, limits(0.005, 0.0005));
        // `great`: half a millimeter per contact, as for the depth below.
        let great = 0.0005 * f64::from(n);
        rows.at_most(format!("{n}, sag"), sag, Unit::Meter, limits(column_sag(count), great));
        // `must`: the usual slop, 5 mm, and 1 mm.
        rows.at_most(format!("{n}, depth"), depth, Unit::Meter, limits(0.006, 0.0005));
    }
    Ok(())
}

/// A flat pyramid of cubes of edge `size`; its top cube is `ratio` times as heavy as the others.
fn pyramid(base: usize, size: f64, ratio: f64) -> Scene {
    let mut scene = empty("pyramid");
    add_floor(&mut scene, Surface::rough(0.6));
    let pitch = 1.05 * size;
    for row in 0..base {
        for i in 0..base - row {
            let x = pitch * (i as f64 - 0.5 * (base - row - 1) as f64);
            let place = narrow([x, size * (row as f64 + 0.5), 0.0]);
            let density = if row + 1 == base { 1000.0 * ratio } else { 1000.0 };
            let cube = ShapeDef::box_full(narrow([size; 3])).with_density(single(density));
            let cube =
                BodyDef::dynamic().with_position(place).with_shape(Surface::rough(0.6).on(cube));
            scene.add(format!("cube {row}/{i}"), cube);
        }
    }
    scene
}

fn mass_ratio(lab: &Lab, rows: &mut Rows) -> Result<(), EngineError> {
    let cases =
        [("1:1000", column(&[1.0, 1000.0])), ("pyramid, top × 300", pyramid(10, 1.0, 300.0))];
    for (case, scene) in cases {
        let Rest { stands, depth, .. } = rest(lab, scene, 60.0)?;
        rows.holds(format!("{case}, stands"), stands, stands);
        rows.at_most(format!("{case}, depth"), depth, Unit::Meter, limits(0.015, 0.006));
    }
    Ok(())
}

/// Whether a scene of the catalog still stands after `seconds`.
fn named_stands(lab: &Lab, spec: &str, seconds: f64) -> Result<bool, EngineError> {
    let mut run = lab.start(lab.named(spec)?)?;
    run.until(seconds, |_| {});
    Ok(run.stands())
}

fn masonry(lab: &Lab, rows: &mut Rows) -> Result<(), EngineError> {
    let stands = |spec: &str| named_stands(lab, spec, 60.0);
    rows.holds("arch of 25 (great: 101)", stands("arch:stones=25")?, stands("arch:stones=101")?);
    let houses = stands("card_house:levels=3")? && stands("card_house:levels=4")?;
    rows.holds("card house of 2 (great: 3 and 4)", stands("card_house:levels=2")?, houses);
    Ok(())
}

/// Six floors of 8 base bricks of 0.05 × 0.25 × 0.1 m and 9 wall bricks of 0.2 × 0.05 × 0.1 m, 10
/// kg each. The published scene gives sizes and numbers; the layout is ours. The base bricks are
/// spokes, 8 wall bricks connect neighboring spokes, and the ninth lies across the inner ends of
/// two.
fn kapla(lab: &Lab, rows: &mut Rows) -> Result<(), EngineError> {
    let mut scene = empty("kapla");
    add_floor(&mut scene, Surface::rough(0.8));
    let step = PI / 4.0;
    // Keeps wall bricks of 0.2 m apart at the inner corners: 0.2 + 0.05 tan(22.5°), and a
    // millimeter.
    let side = 0.2 + 0.05 * (0.5 * step).tan() + 0.001;
    let radius = 0.5 * side / (0.5 * step).sin();
    let mut brick = |size: [f64; 3], from_middle: f64, height: f64, angle: f64| {
        let place = [from_middle * angle.cos(), height, from_middle * angle.sin()];
        let def = block(size, narrow(place), Surface::rough(0.8)).with_mass(10.0);
        let name = format!("brick {}", scene.bodies.len());
        // The brick's z axis is along the radius.
        scene.add(name, def.with_rotation(turn([0.0, 1.0, 0.0], 0.5 * PI - angle)));
    };
    for floor in 0..6 {
        let low = 0.2 * f64::from(floor) + 0.05;
        for i in 0..8 {
            let angle = step * f64::from(i);
            brick([0.05, 0.1, 0.25], radius, low, angle);
            let between = angle + 0.5 * step;
            brick([0.2, 0.1, 0.05], radius * (0.5 * step).cos(), low + 0.1, between);
        }
        let turned = step * (f64::from(3 * floor) + 0.5);
        brick([0.2, 0.1, 0.05], 0.19, low + 0.1, turned);
    }
    let mut run = lab.start(scene)?;
    run.until(60.0, |_| {});
    let minute = run.stands();
    run.until(600.0, |_| {});
    let all = run.stands();
    rows.holds("60 s (great: 600 s)", minute, all);
    Ok(())
}

fn balls_666(lab: &Lab, rows: &mut Rows) -> Result<(), EngineError> {
    let mut scene = empty("666");
    add_666(&mut scene, 0.101, 0.0);
    let mut run = lab.start(scene)?;
    let (mut sum, mut steps) = (0.0, 0.0);
    run.until(10.0, |run| {
        sum += squared_depths(run);
        steps += 1.0;
    });
    rows.at_most("mean of sums", sum / steps, Unit::SquareMeter, limits(0.02, 0.002));
    Ok(())
}

/// Sum of squared depths over all pairs of balls of 0.1 m, and balls and the ground [m²].
fn squared_depths(run: &Run) -> f64 {
    let mut places: Vec<[f64; 3]> = run.dynamic().map(|body| run.body(body).center).collect();
    let mut sum = 0.0;
    // Balls are sorted along x, and only near ones are compared; NaN stays NaN in the sum.
    places.sort_by(|a, b| a[0].total_cmp(&b[0]));
    for (i, a) in places.iter().enumerate() {
        let low = 0.1 - a[1];
        sum += if low <= 0.0 { 0.0 } else { low * low };
        for b in places[i + 1..].iter().take_while(|b| b[0] - a[0] < 0.2) {
            let depth = 0.2 - crate::numeric::norm(crate::numeric::sub(*a, *b));
            sum += if depth <= 0.0 { 0.0 } else { depth * depth };
        }
    }
    sum
}

fn tilted_column(lab: &Lab, rows: &mut Rows) -> Result<(), EngineError> {
    let falls = |part: f64| {
        let angle = part * 0.25_f64.atan();
        let mut scene = empty("tilted column");
        add_floor(&mut scene, Surface::rough(1.0));
        // Tilted about its lower right edge, which stays in place.
        let (s, c) = angle.sin_cos();
        let place = [0.5 - 0.5 * c + 2.0 * s, 0.5 * s + 2.0 * c, 0.0];
        let def = block([1.0, 4.0, 1.0], narrow(place), Surface::rough(1.0));
        let body = scene.add("column", def.with_rotation(turn([0.0, 0.0, 1.0], -angle)));
        let mut run = lab.start(scene)?;
        run.until(6.0, |_| {});
        Ok::<_, EngineError>(run.body(body).direction([0.0, 1.0, 0.0])[1] < 0.7)
    };
    let (below, above) = (!falls(0.98)?, falls(1.02)?);
    rows.holds("stands up", below, below);
    rows.holds("falls over", above, above);
    Ok(())
}

/// Boxes of 1 × 0.5 × 1 m, each offset to the right of the one below by the given distance [m].
fn leaning(lab: &Lab, offsets: &[f64]) -> Result<bool, EngineError> {
    let mut scene = empty("overhang");
    add_floor(&mut scene, Surface::rough(0.8));
    let mut x = 0.0;
    for (i, offset) in offsets.iter().enumerate() {
        x += offset;
        let place = narrow([x, 0.25 + 0.5 * i as f64, 0.0]);
        scene.add(format!("box {i}"), block([1.0, 0.5, 1.0], place, Surface::rough(0.8)));
    }
    let mut run = lab.start(scene)?;
    run.until(20.0, |_| {});
    Ok(run.stands())
}

fn overhang(lab: &Lab, rows: &mut Rows) -> Result<(), EngineError> {
    // The lowest box must carry the nine others.
    let constant = |part: f64| {
        let mut offsets = [0.1 * part; 10];
        offsets[0] = 0.0;
        leaning(lab, &offsets)
    };
    // The k-th box from the top overhangs by w/(2 k).
    let harmonic = |part: f64| {
        let mut offsets: Vec<f64> = (1..10).map(|k| part * 0.5 / f64::from(k)).collect();
        offsets.push(0.0);
        offsets.reverse();
        leaning(lab, &offsets)
    };
    for (name, below, above) in [
        ("constant", constant(0.97)?, !constant(1.03)?),
        ("harmonic", harmonic(0.97)?, !harmonic(1.03)?),
    ] {
        rows.holds(format!("{name}, stands"), below, below);
        rows.holds(format!("{name}, falls"), above, above);
    }
    Ok(())
}

fn falling_columns(lab: &Lab, rows: &mut Rows) -> Result<(), EngineError> {
    lab.own("a reference of 64 substeps")?;
    let mut set = lab.protocol.set.clone();
    set.push(("inertia.max_factor".to_owned(), "1".to_owned()));
    let fine = lab.with(Protocol { substeps: 64, set, ..lab.protocol.clone() });
    for lean in [0.15, 0.12, 0.105] {
        let (exact, found) = (fall_time(&fine, lean)?, fall_time(lab, lean)?);
        rows.relative(format!("{lean} m"), exact, found, limits(0.15, 0.05));
    }
    let stands = fall_time(lab, 0.09)?.is_infinite();
    rows.holds("0.09 m, stands", stands, stands);
    Ok(())
}

/// Time when the top of a leaning column falls below 7/10 of its height [s]; infinite after 12 s.
fn fall_time(lab: &Lab, lean: f64) -> Result<f64, EngineError> {
    let scene = lab.named(&format!("leaning_stack:n=10,lean={lean}"))?;
    let top = scene.bodies.len() - 1;
    let mut run = lab.start(scene)?;
    let height = run.body(top).center[1];
    while run.time() < 12.0 {
        run.step();
        if run.body(top).center[1] < 0.7 * height {
            return Ok(run.time());
        }
    }
    Ok(f64::INFINITY)
}

fn tall_column(lab: &Lab, rows: &mut Rows) -> Result<(), EngineError> {
    for n in [10, 20, 30, 50] {
        let Rest { stands, drift, sag, depth } = rest(lab, column(&vec![1000.0; n]), 600.0)?;
        rows.holds(format!("{n}, stands"), stands, stands);
        rows.at_most(format!("{n}, drift"), drift, Unit::Meter, limits(0.01, 0.01));
        let most = column_sag(n);
        rows.at_most(format!("{n}, sag"), sag, Unit::Meter, limits(most, most));
        rows.at_most(format!("{n}, depth"), depth, Unit::Meter, limits(0.0015, 0.0015));
    }
    Ok(())
}

fn heavy_top(lab: &Lab, rows: &mut Rows) -> Result<(), EngineError> {
    for (top, most) in [(10.0, 0.005), (100.0, 0.03), (1000.0, 0.23)] {
        let mut masses = vec![1.0; 10];
        masses.push(top);
        let Rest { stands, sag, depth, .. } = rest(lab, column(&masses), 60.0)?;
        rows.holds(format!("{top} kg, stands"), stands, stands);
        rows.at_most(format!("{top} kg, sag"), sag, Unit::Meter, limits(most, most));
        rows.at_most(format!("{top} kg, depth"), depth, Unit::Meter, limits(0.002, 0.002));
    }
    Ok(())
}

fn pyramids(lab: &Lab, rows: &mut Rows) -> Result<(), EngineError> {
    for ratio in [100.0, 200.0, 300.0] {
        let Rest { stands, .. } = rest(lab, pyramid(10, 1.0, ratio), 60.0)?;
        rows.holds(format!("base 10, top × {ratio}"), stands, stands);
    }
    let Rest { stands, .. } = rest(lab, pyramid(30, 0.05, 1.0), 60.0)?;
    rows.holds("base 30 of 5 cm", stands, stands);
    Ok(())
}

fn large_pyramid(lab: &Lab, rows: &mut Rows) -> Result<(), EngineError> {
    let mut run = lab.start(pyramid(80, 1.0, 1.0))?;
    run.until(10_000.0 * lab.dt(), |_| {});
    rows.holds("base 80", run.stands(), run.stands());
    Ok(())
}

fn houses(lab: &Lab, rows: &mut Rows) -> Result<(), EngineError> {
    for spec in
        ["jenga:layers=30", "card_house:levels=3", "card_house:levels=4", "card_house:levels=5"]
    {
        let stands = named_stands(lab, spec, 60.0)?;
        rows.holds(spec, stands, stands);
    }
    Ok(())
}

/// A half ring of stones with a mean radius of 2.5 m.
fn ring(stones: u32, thickness: f64) -> Result<Scene, EngineError> {
    let mut scene = empty("ring");
    add_floor(&mut scene, Surface::rough(0.7));
    let middle = 2.5;
    let half = 0.5 * PI / f64::from(stones);
    let mut points = Vec::new();
    for z in [-0.25, 0.25] {
        for r in [middle - 0.5 * thickness, middle + 0.5 * thickness] {
            for side in [-half, half] {
                points.push(narrow([r * side.cos() - middle, r * side.sin(), z]));
            }
        }
    }
    let hull = Hull::from_points(&points).map_err(|e| EngineError(format!("{e}")))?;
    let shape = ShapeDef::new(Shape::Hull(std::sync::Arc::new(hull)));
    for i in 0..stones {
        let angle = PI * (f64::from(i) + 0.5) / f64::from(stones);
        let def = BodyDef::dynamic()
            .with_position(narrow([middle * angle.cos(), middle * angle.sin(), 0.0]))
            .with_rotation(turn([0.0, 0.0, 1.0], angle))
            .with_shape(Surface::rough(0.7).on(shape.clone()));
        scene.add(format!("stone {i}"), def);
    }
    Ok(scene)
}

fn thin_arch(lab: &Lab, rows: &mut Rows) -> Result<(), EngineError> {
    for (ratio, should) in [(0.10, false), (0.12, true), (0.20, true)] {
        let mut run = lab.start(ring(51, ratio * 2.5)?)?;
        run.until(60.0, |_| {});
        let right = run.stands() == should;
        let what = if should { "stands" } else { "falls" };
        rows.holds(format!("{ratio}, {what}"), right, right);
    }
    Ok(())
}
