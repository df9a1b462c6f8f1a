//! Invariance to the world's origin and orientation, the order of bodies, and the step.

use drystone::{BodyDef, Quat, ShapeDef};
use drystone_bench::EngineError;
use drystone_scene::Scene;

use super::impact::mixed;
use super::rolling::pushed_plate;
use crate::lab::{Lab, Protocol, Run};
use crate::numeric::{
    Crossings, D3, Random, add, narrow, norm, scale, single, sub, turn, wide, worst,
};
use crate::row::{Rows, Unit, limits};
use crate::setup::{G, Surface, add_floor, ball, block, empty};
use crate::test::Test;

pub(crate) const TESTS: &[Test] = &[
    Test::new(
        "A44",
        "a column and a heap, moved, turned, mirrored, added in another order",
        "what is changed",
        "the column rests as before, the heap has the same height and width",
        invariance,
    ),
    Test::new(
        "A45",
        "convergence: the step halved, 60 to 120 Hz",
        "A9, A22 (90°), A24, S1",
        "error falls to a half; one below 1e-5 is rounding",
        convergence,
    ),
    Test::new(
        "A46a",
        "billiard break, e 0.95",
        "",
        "E never grows, p of the balls is kept",
        billiards,
    ),
    Test::new(
        "A46b",
        "domino run of 30 pieces",
        "height 0.1, 1 and 10 m",
        "all fall; speed over √(g h) is the same",
        dominoes,
    ),
];

/// Ten cubes stacked on a large box, placed at `place`, or added from the top.
fn column(place: D3, reversed: bool) -> Scene {
    let surface = Surface::rough(0.6);
    let mut scene = empty("column");
    let ground = surface.on(ShapeDef::box_half([10.0, 1.0, 10.0]));
    let low = narrow(add(place, [0.0, -1.0, 0.0]));
    scene.add("ground", BodyDef::fixed().with_position(low).with_shape(ground));
    for i in 0..10 {
        let i = if reversed { 9 - i } else { i };
        let at = narrow(add(place, [0.0, 0.5 + f64::from(i), 0.0]));
        scene.add(format!("cube {i}"), block([1.0; 3], at, surface));
    }
    scene
}

/// A heap of 60 bodies that fell from a grid: mean height and mean distance from the middle after
/// 10 s.
fn heap(lab: &Lab, change: impl Fn(&mut Scene)) -> Result<[f64; 2], EngineError> {
    let (mut random, surface) = (Random::new(44), Surface::rough(0.6));
    let mut scene = empty("heap");
    add_floor(&mut scene, surface);
    for i in 0..60 {
        let cell = [i % 4, i / 16, i / 4 % 4].map(|n| n as f64);
        let place = [0.9 * (cell[0] - 1.5), 0.8 + 0.9 * cell[1], 0.9 * (cell[2] - 1.5)];
        let size = random.between(0.3, 0.45);
        scene.add(format!("body {i}"), mixed(i, &mut random, size, place, surface));
    }
    change(&mut scene);
    let mut run = lab.start(scene)?;
    run.until(10.0, |_| {});
    let places: Vec<D3> = run.dynamic().map(|body| run.body(body).center).collect();
    let count = places.len() as f64;
    let middle = scale(places.iter().fold([0.0; 3], |s, p| add(s, *p)), 1.0 / count);
    let wide = |p: &D3| (p[0] - middle[0]).hypot(p[2] - middle[2]);
    Ok([middle[1], places.iter().map(wide).sum::<f64>() / count])
}

fn each_moving(scene: &mut Scene, change: impl Fn(&mut BodyDef)) {
    for body in scene.bodies.iter_mut().skip(1) {
        change(&mut body.def);
    }
}

fn invariance(lab: &Lab, rows: &mut Rows) -> Result<(), EngineError> {
    for (case, place, reversed) in [
        ("at 100 m", [100.0, 0.0, 0.0], false),
        ("at 1 km", [1000.0, 0.0, 0.0], false),
        ("from the top", [0.0; 3], true),
    ] {
        let mut run = lab.start(column(place, reversed))?;
        run.until(60.0, |_| {});
        rows.holds(format!("column {case}, stands"), run.stands(), run.stands());
        // The limit of A36.
        rows.at_most(
            format!("column {case}, drift"),
            run.drift(),
            Unit::Meter,
            limits(0.005, 0.0005),
        );
        rows.at_most(
            format!("column {case}, depth"),
            run.overlap()?.0,
            Unit::Meter,
            limits(0.006, 0.0005),
        );
    }
    let plain = heap(lab, |_| {})?;
    let quarter = turn([0.0, 1.0, 0.0], core::f64::consts::FRAC_PI_2);
    let turned = heap(lab, |scene| {
        each_moving(scene, |def| {
            def.position = quarter.rotate(def.position);
            def.rotation = quarter * def.rotation;
        });
    })?;
    let mirrored = heap(lab, |scene| {
        each_moving(scene, |def| {
            def.position.x = -def.position.x;
            // The mirror image of a rotation has the opposite sense about the axes in the mirror
            // plane. The shapes are their own mirror images.
            let q = def.rotation;
            def.rotation = Quat::new(q.x, -q.y, -q.z, q.w);
        });
    })?;
    let moved = |x: f32| heap(lab, move |s| each_moving(s, |def| def.position.x += x));
    let (near, far) = (moved(100.0)?, moved(1000.0)?);
    let shuffled = heap(lab, |scene| scene.bodies[1..].reverse())?;
    // Only the `great` limit applies, because a heap is chaotic.
    let free = limits(f64::MAX, 0.01);
    for (case, other) in [
        ("turned by 90°", turned),
        ("mirrored", mirrored),
        ("at 100 m", near),
        ("at 1 km", far),
        ("shuffled", shuffled),
    ] {
        rows.relative(format!("heap {case}, height"), plain[0], other[0], free);
        rows.relative(format!("heap {case}, width"), plain[1], other[1], free);
    }
    Ok(())
}

/// Runs another test and returns the error of its first row whose name ends with `case`.
fn error_of(lab: &Lab, id: &str, case: &str) -> Result<f64, EngineError> {
    let missing = || EngineError(format!("{id} has no row '{case}'"));
    let test = crate::test::all().find(|test| test.id == id).ok_or_else(missing)?;
    let mut rows = Rows::new(test.id, test.name, test.closed_form);
    (test.run)(lab, &mut rows)?;
    rows.list.iter().find(|row| row.case == case).map(|row| row.error).ok_or_else(missing)
}

fn convergence(lab: &Lab, rows: &mut Rows) -> Result<(), EngineError> {
    let twice = Protocol { hz: 2.0 * lab.protocol.hz, ..lab.protocol.clone() };
    let fine = lab.with(twice);
    for (id, case) in
        [("A9", "x"), ("A22", "ball joint, 90°, T"), ("A24", "path, 1 s"), ("S1", "y")]
    {
        // S1 reports a squared error. As published, its plate starts 2e-5 m deep and its balls 6e-5
        // m deep. A contact of another stiffness, hence another rate, ejects the plate at another
        // speed. How long it then sticks or flies has no order in the step. Here it is pushed after
        // it has come to rest.
        let [coarse, half] = [lab, &fine].map(|lab| match id {
            "S1" => pushed_plate(lab, [0.0, 0.0, 1.0], 1.0).map(f64::sqrt),
            _ => error_of(lab, id, case),
        });
        let (coarse, half) = (coarse?, half?);
        let ratio = half / coarse;
        let error = if half < 1.0e-5 { ratio.min(0.5) } else { ratio };
        rows.error(id, (0.5, ratio), error, Unit::Part, limits(0.6, 0.5));
    }
    Ok(())
}

fn billiards(lab: &Lab, rows: &mut Rows) -> Result<(), EngineError> {
    let surface = Surface { mu: 0.1, e: 0.95 };
    let radius = 0.028_575;
    let mut scene = empty("billiards");
    add_floor(&mut scene, Surface { mu: 0.2, e: 0.0 });
    for row in 0..5_u32 {
        for i in 0..=row {
            let x = f64::from(row) * radius * 2.0 * 0.75_f64.sqrt() * 1.000_01;
            let z = (f64::from(i) - 0.5 * f64::from(row)) * 2.0 * radius * 1.000_01;
            let def = ball(radius, narrow([x, radius, z]), surface).with_mass(0.17);
            scene.add(format!("ball {row}/{i}"), def);
        }
    }
    let cue = ball(radius, narrow([-0.5, radius, 0.002]), surface).with_mass(0.17);
    // Rolling.
    let cue = cue.with_linear_velocity(narrow([8.0, 0.0, 0.0])).with_angular_velocity(narrow([
        0.0,
        0.0,
        -8.0 / radius,
    ]));
    let cue = scene.add("cue", cue);
    let mut run = lab.start(scene)?;
    let (start, mut least, mut grown) = (run.energy(), run.energy(), 0.0);
    run.until(2.0, |run| {
        let energy = run.energy();
        grown = worst(grown, (energy - least) / start);
        least = least.min(energy);
    });
    rows.at_most("E, growth", grown, Unit::Part, limits(1.0e-3, 1.0e-3));
    let spread = run.dynamic().filter(|b| *b != cue && moved_far(&run, *b)).count();
    rows.holds("the balls part", spread >= 12, spread == 15);
    Ok(())
}

fn moved_far(run: &Run, body: usize) -> bool {
    norm(sub(run.body(body).center, wide(run.scene.bodies[body].def.position))) > 0.05
}

/// Speed over √(g h) of the wave through the middle of a row of dominoes of this height, if all
/// fall.
fn wave(lab: &Lab, height: f64) -> Result<Option<f64>, EngineError> {
    let (thick, wide, pitch) = (height / 8.0, 0.5 * height, 0.5 * height);
    let surface = Surface::rough(0.6);
    let mut scene = empty("dominoes");
    add_floor(&mut scene, surface);
    let mut bodies = Vec::new();
    for i in 0..30 {
        let place = narrow([pitch * f64::from(i), 0.5 * height, 0.0]);
        let mut def = block([thick, height, wide], place, surface);
        if i == 0 {
            // Rotates about its lower front edge.
            let w = 2.0 * (G / height).sqrt();
            def = def.with_angular_velocity([0.0, 0.0, single(-w)]).with_linear_velocity(narrow([
                0.5 * w * height,
                0.5 * w * thick,
                0.0,
            ]));
        }
        bodies.push(scene.add(format!("domino {i}"), def));
    }
    let mut run = lab.start(scene)?;
    // The time at which a piece is tilted by 20°. At a height of 0.1 m a piece falls every third
    // step, so step ends would resolve speeds only to 2 %.
    let mut tilted = vec![Crossings::default(); bodies.len()];
    for tilted in &mut tilted {
        // A reading of the upright piece; at 50 Hz the first small piece crosses 20° in the first
        // step.
        tilted.read(0.0, 0.06);
    }
    run.until(40.0 * (height / G).sqrt() + 2.0, |run| {
        for (body, tilted) in bodies.iter().zip(&mut tilted) {
            tilted.read(run.time(), run.body(*body).direction([0.0, 1.0, 0.0])[1] - 0.94);
        }
    });
    let first = |tilted: &Crossings| tilted.times.first().map(|(time, _)| *time);
    let all: Option<Vec<f64>> = tilted.iter().map(first).collect();
    // The wave has its final speed from the 10th piece on.
    Ok(all.map(|t| 15.0 * pitch / (t[25] - t[10]) / (G * height).sqrt()))
}

fn dominoes(lab: &Lab, rows: &mut Rows) -> Result<(), EngineError> {
    let speeds = [0.1, 1.0, 10.0].map(|height| wave(lab, height));
    let [small, middle, large] = speeds;
    let (small, middle, large) = (small?, middle?, large?);
    let fell = [small, middle, large].iter().all(Option::is_some);
    rows.holds("all fall", fell, fell);
    let middle = middle.unwrap_or(f64::NAN);
    for (case, speed) in [("0.1 m", small), ("10 m", large)] {
        // The list of tests gives no limits here: 5 % and 1 %.
        rows.relative(case, middle, speed.unwrap_or(f64::NAN), limits(0.05, 0.01));
    }
    Ok(())
}
