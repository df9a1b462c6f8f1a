//! Scenes of MuJoCo: what they are read into, how they move, what is refused and how.
#![expect(clippy::unwrap_used, clippy::panic, reason = "a test may fail anywhere")]

use std::fs;
use std::path::{Path, PathBuf};

use drystone::joint::{JointMotion, SixDof};
use drystone::{BodyKind, JointKind, MassDef, Pose, Quat, Shape, Vec3, vec3};
use drystone_scene::{Running, Scene, SceneError, mjcf};

mod damage;
mod running;

use running::run;

fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/mujoco")
}

fn load(name: &str) -> Scene {
    mjcf::load(&folder().join(name)).unwrap()
}

fn read(inside: &str) -> Result<Scene, SceneError> {
    mjcf::from_text(&format!("<mujoco>{inside}</mujoco>"), &folder())
}

fn body(running: &Running, name: &str) -> Pose {
    let number = running.names.iter().position(|n| n == name).unwrap_or_else(|| panic!("{name}"));
    let body = running.world.body(running.bodies[number]).unwrap();
    Pose::new(body.position(), body.rotation())
}

/// Largest error of any joint [m], by the engine.
fn joint_error(running: &Running) -> f32 {
    running.world.joints().map(|j| j.error()).fold(0.0, f32::max)
}

fn mass(scene: &Scene, body: usize) -> (f32, Vec3) {
    match scene.bodies[body].def.mass {
        MassDef::Exact { mass, center, .. } => (mass, center),
        other => panic!("{other:?}"),
    }
}

fn six(scene: &Scene, joint: usize) -> SixDof {
    match scene.joints[joint].kind {
        JointKind::SixDof(six) => six,
        other => panic!("{other:?}"),
    }
}

#[test]
fn classes_are_inherited_and_overridden() {
    let scene = read(
        r#"<default><geom density="500" size="0.1"/>
             <default class="a b"><geom type="box" size="0.1 0.2 0.3" friction="0.3"/>
               <default class="c"><geom density="2000"/></default></default></default>
           <worldbody>
             <body name="x" childclass="a b"><freejoint/><geom/><body><geom class="c" pos="1 0 0"/></body></body>
             <body name="y"><freejoint/><geom/></body>
           </worldbody>"#,
    )
    .unwrap();
    let shapes = &scene.bodies[1].def.shapes;
    assert!(shapes.iter().all(
        |s| matches!(s.shape, Shape::Box { half_extents } if half_extents == vec3(0.1, 0.2, 0.3))
    ));
    assert!((shapes[0].density, shapes[1].density) == (500.0, 2000.0));
    assert!((shapes[1].material.friction - 0.3).abs() < 1.0e-6);
    // The body without a joint is one with the other, four times as heavy, 1 m away.
    let (m, center) = mass(&scene, 1);
    assert!((m - 5.0 * 24.0).abs() < 1.0e-3 && (center.x - 0.8).abs() < 1.0e-5, "{m} {center:?}");
    assert!(matches!(scene.bodies[2].def.shapes[0].shape, Shape::Sphere { .. }));
}

#[test]
fn places_are_said_in_six_ways() {
    let at = |how: &str, compiler: &str| {
        let inside = format!(
            r#"<compiler {compiler}/><worldbody><body name="b" {how}><freejoint/><geom size="1"/></body></worldbody>"#
        );
        read(&inside).unwrap().bodies[1].def.rotation
    };
    let quarter = Quat::from_axis_angle(Vec3::Z, core::f32::consts::FRAC_PI_2);
    for (how, compiler) in [
        ("quat=\"2 0 0 2\"", ""),
        ("axisangle=\"0 0 3 90\"", ""),
        ("euler=\"0 0 90\"", ""),
        ("euler=\"0 0 1.57079633\"", "angle=\"radian\""),
        ("xyaxes=\"0 2 0 -1 0.5 0\"", ""),
        ("euler=\"90 0 0\"", "eulerseq=\"zyx\""),
    ] {
        let q = at(how, compiler);
        assert!((q.conjugate() * quarter).angle() < 1.0e-3, "{how}: {q:?}");
    }
    let z = at("zaxis=\"1 0 0\"", "").rotate(Vec3::Z);
    assert!((z - Vec3::X).length() < 1.0e-6);
    // About the axes as turned, and about those of the parent.
    let turned = at("euler=\"90 90 0\"", "").rotate(Vec3::X);
    assert!(
        (turned - vec3(0.0, 1.0, 0.0)).length() < 1.0e-5 || turned.y.abs() > 0.99,
        "{turned:?}"
    );
    let fixed = at("euler=\"90 90 0\"", "eulerseq=\"XYZ\"").rotate(Vec3::X);
    assert!((fixed - vec3(0.0, 0.0, -1.0)).length() < 1.0e-5, "{fixed:?}");
}

#[test]
fn joints_of_a_body_act_one_after_the_other() {
    let one = |joints: &str| {
        read(&format!(r#"<worldbody><body name="b"><geom size="0.1"/>{joints}</body></worldbody>"#))
            .unwrap()
    };
    let hinge =
        one(r#"<joint axis="0 2 0" range="-30 60" stiffness="4" springref="10" damping="0.5"/>"#);
    let axes = six(&hinge, 0);
    let JointMotion::Limited { min, max, .. } = axes.angular[0].motion else { panic!() };
    assert!((min.to_degrees() + 30.0).abs() < 1.0e-4 && (max.to_degrees() - 60.0).abs() < 1.0e-4);
    let drive = axes.angular[0].drive.unwrap();
    assert!((drive.position.to_degrees() - 10.0).abs() < 1.0e-4);
    assert!((axes.frame_b.rotate(Vec3::X) - Vec3::Y).length() < 1.0e-6);
    assert!(hinge.joints[0].collide_connected, "what hangs on the world collides with it");
    // A planar body: two slides and a hinge are one joint.
    let planar = one(
        r#"<joint type="slide" axis="1 0 0"/><joint type="slide" axis="0 0 1"/><joint type="hinge" axis="0 1 0"/>"#,
    );
    assert_eq!((planar.bodies.len(), planar.joints.len()), (2, 1));
    let free = |axes: &[drystone::joint::JointAxis]| {
        axes.iter().filter(|a| a.motion == JointMotion::Free).count()
    };
    assert_eq!((free(&six(&planar, 0).linear), free(&six(&planar, 0).angular)), (2, 1));
    // Two hinges in one point are a universal joint, in two points there is a body between.
    let universal = one(r#"<joint axis="0 0 1"/><joint axis="0 1 0"/>"#);
    assert_eq!((universal.bodies.len(), universal.joints.len()), (2, 1));
    let apart = one(r#"<joint axis="0 0 1"/><joint axis="0 1 0" pos="0.1 0 0"/>"#);
    assert_eq!(apart.bodies.len(), 3);
    let total = mass(&apart, 1).0 + mass(&apart, 2).0;
    assert!((total - mass(&hinge, 1).0).abs() < 1.0e-5);
    assert!(matches!(one(r#"<joint type="ball"/>"#).joints[0].kind, JointKind::Ball));
}

#[test]
fn a_spring_swings_at_its_frequency() {
    // √(k/m)/(2π) of 2 kg on 200 N/m, from 0.1 m beside its rest.
    let scene = read(
        r#"<option gravity="0 0 0"/><worldbody><body name="b"><inertial pos="0 0 0" mass="2" diaginertia="1 1 1"/>
           <joint type="slide" axis="1 0 0" stiffness="200" springref="0.1"/></body></worldbody>"#,
    )
    .unwrap();
    let mut last = (0.0_f32, -0.1_f32);
    let mut crossings = Vec::new();
    let mut time = 0.0_f32;
    run(&scene, 5.0, |running| {
        time += 1.0 / 60.0;
        let x = body(running, "b").position.x - 0.1;
        if last.1 < 0.0 && x >= 0.0 {
            crossings.push(last.0 + (time - last.0) * last.1 / (last.1 - x));
        }
        last = (time, x);
    });
    let count = crossings.len() - 1;
    let period = (crossings[count] - crossings[0]) / f32::from(u8::try_from(count).unwrap());
    let exact = 2.0 * core::f32::consts::PI * 0.1;
    // Linear interpolation between steps of 1/38 of a period, twice, over seven periods; the
    // method's own error at 480 Hz is (ω h)²/24 = 2e-5.
    assert!((period / exact - 1.0).abs() < 1.0e-3, "{period} s, {exact} s");
}

#[test]
fn copies_are_numbered_and_stand_where_they_are_turned_to() {
    let scene = read(
        r#"<worldbody><replicate count="12" euler="0 0 30" sep="-"><body name="b" pos="2 0 1"><freejoint/>
           <geom size="0.1"/></body></replicate></worldbody>"#,
    )
    .unwrap();
    assert_eq!(scene.bodies.len(), 13);
    assert_eq!((scene.bodies[1].name.as_str(), scene.bodies[12].name.as_str()), ("b-00", "b-11"));
    assert!((scene.bodies[4].def.position - vec3(0.0, 2.0, 1.0)).length() < 1.0e-5);
    let humanoids = load("22_humanoids.xml");
    let torsos = humanoids.bodies.iter().filter(|b| b.name.starts_with("_torso-"));
    assert_eq!(torsos.count(), 22);
    let names: std::collections::BTreeSet<&str> =
        humanoids.bodies.iter().map(|b| b.name.as_str()).collect();
    assert_eq!(names.len(), humanoids.bodies.len());
}

#[test]
fn contact_bits_and_excludes_say_who_collides() {
    let inside = |relations: &str| {
        format!(
            r#"<worldbody><geom type="plane" size="1 1 1" contype="1" conaffinity="0"/>
            <body name="a" pos="0 0 1"><freejoint/><geom size="0.1" contype="2" conaffinity="1"/></body>
            <body name="b" pos="0 0 1.1"><freejoint/><geom size="0.1" contype="2" conaffinity="2"/></body>
            <body name="c" pos="0 0 1.2"><freejoint/><geom size="0.1" contype="0" conaffinity="2"/></body>
            </worldbody>{relations}"#
        )
    };
    let scene = read(&inside("")).unwrap();
    let filter = |i: usize| scene.bodies[i].def.shapes[0].filter;
    let meet = |i: usize, j: usize| filter(i).collides_with(filter(j));
    assert!(meet(0, 1) && !meet(0, 2) && meet(1, 2) && meet(2, 3) && meet(1, 3) && !meet(0, 3));
    assert!(scene.joints.is_empty());
    let excluded = read(&inside(r#"<contact><exclude body1="a" body2="b"/></contact>"#)).unwrap();
    assert!(excluded.joints.len() == 1 && !excluded.joints[0].collide_connected);
}

#[test]
fn the_world_is_a_body_of_relations() {
    let ball = |more: &str| {
        let floor = r#"<geom type="plane" size="1 1 1"/>"#;
        let ball = r#"<body name="ball" pos="0 0 1"><freejoint/><geom size="0.1"/></body>"#;
        read(&format!("<worldbody>{floor}{ball}</worldbody>{more}")).unwrap()
    };
    let height = |scene: &Scene| body(&run(scene, 2.0, |_| ()), "ball").position.z;
    assert!((height(&ball("")) - 0.1).abs() < 0.01, "it lies on the floor");
    for (a, b) in [("world", "ball"), ("ball", "world")] {
        let names = format!("body1=\"{a}\" body2=\"{b}\"");
        let through = ball(&format!("<contact><exclude {names}/></contact>"));
        assert!(height(&through) < -10.0, "nothing stops it");
        for kind in ["weld", "connect"] {
            let held = ball(&format!("<equality><{kind} {names} anchor=\"0 0 0\"/></equality>"));
            // An anchor is a point of the second body for a weld, of the first for a connection.
            // That is the ball's own center, or the origin of the world, a meter below, about which
            // the ball falls over.
            let least = if kind == "weld" || a == "ball" { 0.99 } else { 0.09 };
            assert!(height(&held) > least, "{kind} {names}: {}", height(&held));
        }
    }
    let copies = r#"<worldbody><replicate count="3" offset="1 0 0"><body name="b" pos="0 0 1"><freejoint/>
        <geom size="0.1"/></body></replicate></worldbody>
        <equality><weld body1="world" body2="b"/></equality>"#;
    assert_eq!(read(copies).unwrap().joints.len(), 3, "each copy is held");
    // A file may have a body of that name, which MuJoCo refuses: then it is that one.
    let own = r#"<worldbody><body name="world" pos="0 0 1"><freejoint/><geom size="0.1"/></body></worldbody>
        <equality><weld body1="world"/></equality>"#;
    assert_eq!(read(own).unwrap().joints.len(), 1);
}

#[test]
fn a_mesh_that_is_missing_is_told_before_the_mass_that_it_leaves() {
    let text = read(
        r#"<asset><mesh name="m" file="gone.stl"/></asset>
        <worldbody><body name="b"><freejoint/><geom type="mesh" mesh="m"/></body></worldbody>"#,
    )
    .unwrap_err()
    .to_string();
    assert!(text.find("gone.stl").unwrap() < text.find("mass").unwrap(), "{text}");
}

#[test]
fn the_humanoid_falls_and_stays_in_one_piece() {
    let scene = load("humanoid.xml");
    // Mass of the geoms of the file at 1000 kg/m³.
    let total: f32 = (1..scene.bodies.len()).map(|i| mass(&scene, i).0).sum();
    assert!((total - 40.844).abs() < 0.01, "{total}");
    let mut worst = 0.0_f32;
    let start = scene.build().unwrap();
    let energy = start.world.kinetic_energy() + start.world.potential_energy();
    let running = run(&scene, 10.0, |r| worst = worst.max(joint_error(r)));
    let torso = body(&running, "torso").position;
    assert!(torso.z < 0.5 && torso.z > 0.05, "{torso:?}");
    // In one piece: no joint opens by the radius of the thinnest part, a foot.
    println!("largest joint error {worst} m");
    assert!(worst < 0.027, "{worst}");
    let end = running.world.kinetic_energy() + running.world.potential_energy();
    assert!(end < energy);
}

#[test]
fn stacked_boxes_slide_into_the_corner_and_stand() {
    let scene = load("stacked_boxes.xml");
    let running = run(&scene, 10.0, |_| {});
    for (name, id) in running.names.iter().zip(&running.bodies).skip(1) {
        let b = running.world.body(*id).unwrap();
        assert!(b.linear_velocity().length() < 1.0e-3, "{name} moves");
        let (p, up) = (b.position(), b.rotation().rotate(Vec3::Z));
        assert!(up.z > 0.999, "{name} has tipped");
        let level = (p.z - 0.05) / 0.1;
        // Two levels of nine, each within slop of where it belongs.
        assert!((level - level.round()).abs() < 0.02 && level < 1.5, "{name}: {p:?}");
        assert!(p.x > -0.66 && p.y < 0.66, "{name} is in the wall: {p:?}");
    }
}

#[test]
fn the_cradle_passes_momentum_on() {
    let scene = load("newton_cradle.xml");
    assert_eq!(scene.joints.len(), 14, "a string for each pair of sites, in each copy");
    let start = |name: &str| scene.bodies.iter().find(|b| b.name == name).unwrap().def.position.x;
    let names = ["equilibrium0", "equilibrium1", "equilibrium2", "equilibrium3", "equilibrium4"];
    let mut farthest = [0.0_f32; 5];
    let mut stretch = 0.0_f32;
    let swing = scene.bodies.iter().find(|b| b.name == "perturbed0").unwrap().def.position.x - 0.04;
    // Half a swing of a string of 0.16 m takes 0.4 s: they go, and do not come back yet.
    run(&scene, 0.5, |running| {
        for (far, name) in farthest.iter_mut().zip(names) {
            *far = far.max(start(name) - body(running, name).position.x);
        }
        stretch = stretch.max(joint_error(running));
    });
    // Two balls came, two go, as far as those came from; the others stay.
    println!("farthest {farthest:?} of {swing} m, strings {stretch} m");
    let parts = farthest.map(|far| far / swing);
    for part in &parts[3..] {
        // The acceptance list requires 0.97 of the speed of a cradle, to which the way is in
        // proportion.
        assert!((part - 1.0).abs() < 0.03, "{parts:?}");
    }
    // The others have no more than the energy that is left of two.
    let energy = |parts: &[f32]| parts.iter().map(|p| p * p).sum::<f32>();
    assert!(energy(&parts) < 2.0 + 2.0e-3, "{parts:?}");
    assert!(stretch < 1.0e-3, "{stretch}");
}

#[test]
fn a_joint_follows_another_as_an_equality_says() {
    let scene = read(
        r#"<option gravity="0 0 0"/><worldbody>
        <body name="a"><joint name="j" axis="0 0 1" ref="20"/><geom size="0.1"/></body>
        <body name="b" pos="1 0 0"><joint name="k" type="slide" axis="0 -1 0"/><geom size="0.1"/></body></worldbody>
        <equality><joint joint1="k" joint2="j" polycoef="0 0.5 0 0 0"/></equality>"#,
    )
    .unwrap();
    assert_eq!(scene.couplings.len(), 1);
    let running = run(&scene, 1.0, |_| {});
    // The slide's count is half the hinge's, which the file has at 20°.
    let coordinates =
        |i: usize| running.world.joint(running.joints[i]).unwrap().coordinates().unwrap();
    let (turn, way) = (coordinates(0)[1].x + 20.0_f32.to_radians(), coordinates(1)[0].x);
    assert!((way - 0.5 * turn).abs() < 1.0e-4, "{way} m, {turn} rad");
    assert!(way.abs() > 0.001 && body(&running, "b").position.y < 0.0);
}

/// A crank of 0.1 m, a rod of 0.3 m that `connect` closes to a slider, let go from level.
const CRANK: &str = r#"<worldbody>
  <body name="crank"><joint axis="0 1 0"/><geom type="capsule" size=".01" fromto="0 0 0 .1 0 0" contype="0" conaffinity="0"/>
    <body name="rod" pos=".1 0 0"><joint axis="0 1 0"/>
      <geom type="capsule" size=".01" fromto="0 0 0 .3 0 0" contype="0" conaffinity="0"/></body></body>
  <body name="slider" pos=".4 0 0"><joint type="slide" axis="1 0 0"/>
    <geom type="box" size=".02 .02 .02" contype="0" conaffinity="0"/></body></worldbody>
  <equality><connect body1="rod" body2="slider" anchor=".3 0 0"/></equality>"#;

#[test]
fn the_slider_crank_closes_its_loop() {
    let scene = read(CRANK).unwrap();
    assert_eq!(scene.joints.len(), 4);
    let (r, l) = (0.1_f32, 0.3_f32);
    let (mut off, mut gap, mut turned) = (0.0_f32, 0.0_f32, 0.0_f32);
    run(&scene, 5.0, |running| {
        let x = body(running, "crank").rotation.rotate(Vec3::X);
        let exact = r * x.x + (l * l - r * r * x.z * x.z).sqrt();
        let slider = body(running, "slider").position;
        off = off.max((slider - vec3(exact, 0.0, 0.0)).length());
        gap = gap.max((body(running, "rod").point(vec3(l, 0.0, 0.0)) - slider).length());
        turned = turned.max(1.0 - x.x);
    });
    println!("slider {off} m, loop {gap} m");
    assert!(turned > 1.0, "it swings beyond straight down");
    // The acceptance list requires 2 mm of a slider-crank.
    assert!(off < 2.0e-3 && gap < 2.0e-3, "{off} {gap}");
}

/// The pendulum of a hinge, a slide, a ball and a hinge over five seconds. Returns its energy's
/// largest difference to the first [J], its largest energy of motion [J], and its fastest spin
/// [rad/s].
fn pendulum(scene: &Scene) -> (f64, f64, f32) {
    let energy = |running: &Running| {
        let (first, second) = (body(running, "#1"), body(running, "#2"));
        // The slide is 0 where the file has it: 0.1 m along the first body.
        let x = f64::from(first.local_point(second.position).x) - 0.1;
        running.world.kinetic_energy() + running.world.potential_energy() + 100.0 * x * x
    };
    let start = energy(&scene.build().unwrap());
    let (mut off, mut motion, mut spin) = (0.0_f64, 0.0_f64, 0.0_f32);
    run(scene, 5.0, |running| {
        off = off.max((energy(running) - start).abs());
        motion = motion.max(running.world.kinetic_energy());
        spin = running.world.bodies().map(|b| b.angular_velocity().length()).fold(spin, f32::max);
    });
    (off, motion, spin)
}

#[test]
fn the_energy_of_the_pendulum_of_hinge_slide_ball_and_hinge_is_kept() {
    let mut drift = Vec::new();
    for hz in [120.0_f32, 480.0, 1920.0] {
        let mut scene = load("energy_conserving_pendulum.xml");
        scene.hz = hz;
        scene.config.sleep.enabled = false;
        // Parts of substeps would take away at 120 Hz what the rate is to.
        scene.config.joint.refine = 1;
        assert_eq!((scene.bodies.len(), scene.joints.len()), (5, 4));
        let (off, motion, spin) = pendulum(&scene);
        println!("{hz} Hz: {off} J of {motion} J, spin up to {spin} rad/s");
        // Its thin parts spin so fast that a step turns them by an angle of order one. A quantity
        // that is frozen over a step is off by that angle, and energy with it, to first order and
        // not in one direction.
        let angle = f64::from(spin / hz);
        assert!(off < angle * motion, "{hz} Hz: {off} J, {angle} rad");
        drift.push(off / motion);
    }
    // A sixteenth of the step: a sixteenth of the error if all were of first order. Rates beside
    // each other are in no order, for errors of either sign add up (240 Hz is better than 480).
    assert!(drift[2] < 0.25 * drift[0], "{drift:?}");
}

/// At 60 Hz a step turns its parts by a radian. Quantities are frozen only over a round, which is a
/// substep of the world, and energy is off by its angle to first order. Its motion is chaotic, so
/// one path says little: 48 of them are off by less than that in the mean. (Frozen over a step it
/// gained up to 10 J, or left the finite numbers, depending on the path.)
#[test]
fn the_pendulum_keeps_its_energy_at_60_hz() {
    let paths = 48_u8;
    let mut sum = 0.0;
    for path in 0..paths {
        let mut scene = load("energy_conserving_pendulum.xml");
        (scene.hz, scene.config.substeps) = (60.0, 8);
        scene.config.gravity.z = -9.7 - 0.02 * f32::from(path);
        let (off, motion, spin) = pendulum(&scene);
        println!("{}: {off} J of {motion} J, spin up to {spin} rad/s", scene.config.gravity.z);
        let angle = f64::from(spin / (60.0 * 8.0));
        sum += off / (angle * motion);
    }
    let mean = sum / f64::from(paths);
    println!("in the mean {mean} of the angle");
    assert!(mean < 1.0, "{mean}");
}

#[test]
fn all_scenes_run_for_ten_seconds() {
    for entry in fs::read_dir(folder()).unwrap() {
        let path = entry.unwrap().path();
        if path.extension().is_none_or(|e| e != "xml") {
            continue;
        }
        let scene = mjcf::load(&path).unwrap();
        let running = run(&scene, 10.0_f32.min(12_000.0 / scene.hz), |_| {});
        for (name, id) in running.names.iter().zip(&running.bodies) {
            let b = running.world.body(*id).unwrap();
            let inside = b.position().length() < 100.0;
            assert!(inside, "{}: {name} at {:?}", path.display(), b.position());
        }
    }
}

#[test]
fn what_is_wrong_is_said_in_one_line() {
    let body = |inside: &str| format!("<worldbody><body name=\"b\">{inside}</body></worldbody>");
    let geom = |geom: &str| body(&format!("<freejoint/><geom {geom}/>"));
    let joint = |joint: &str| body(&format!("<joint {joint}/><geom size=\".1\"/>"));
    let copies = |inside: &str| format!("<worldbody>{inside}</worldbody>");
    let ball = "<body><freejoint/><geom size=\"1\"/></body>";
    let nested = (0..4).fold(ball.to_owned(), |inside, _| {
        format!("<replicate count=\"100\" offset=\"1 0 0\">{inside}</replicate>")
    });
    let two = "<worldbody><body name=\"a\"/></worldbody>";
    let table: Vec<(String, &str)> = vec![
        (body("<freejoint/>"), "'b' moves and has a mass of 0 kg"),
        (geom("size=\"0\""), "size=\"0\", expected 1 numbers above 0 for a sphere"),
        (geom("size=\"nan\""), "size=\"nan\""),
        (geom("type=\"box\" size=\"1 1\""), "3 numbers above 0 for a box"),
        (geom("type=\"capsule\""), "size is missing"),
        (geom("type=\"blob\" size=\"1\""), "type=\"blob\""),
        (geom("type=\"capsule\" size=\"1\" fromto=\"0 0 0 0 0 0\""), "two points that differ"),
        (geom("type=\"mesh\" mesh=\"m\""), "a mesh of <asset>"),
        (geom("type=\"mesh\""), "it names no mesh"),
        (geom("size=\"1\" class=\"c\""), "class=\"c\", expected a class of <default>"),
        (geom("size=\"1\" density=\"-1\""), "density=\"-1\""),
        (geom("size=\"1\" contype=\"-7\""), "contype=\"-7\""),
        (geom("size=\"1\" quat=\"0 0 0 0\""), "a quaternion that is not zero"),
        (geom("size=\"1\" pos=\"1 2\""), "pos=\"1 2\", expected 3 finite numbers"),
        (joint("type=\"screw\""), "type=\"screw\""),
        (joint("axis=\"0 0 0\""), "axis=\"0 0 0\""),
        (joint("limited=\"true\" range=\"2 1\""), "range=\"2 1\""),
        (joint("limited=\"true\""), "a range with it"),
        (body("<freejoint/><joint/><geom size=\"1\"/>"), "a free joint and others"),
        (body("<freejoint/><inertial pos=\"0 0 0\" mass=\"1\"/>"), "its inertia is not clear"),
        (
            body("<freejoint/><inertial pos=\"0 0 0\" mass=\"1\" diaginertia=\"1 -1 1\"/>"),
            "principal moments of",
        ),
        (
            copies(&format!("<replicate count=\"1000000000\">{ball}</replicate>")),
            "count=\"1000000000\"",
        ),
        (copies(&format!("<replicate count=\"0\">{ball}</replicate>")), "count=\"0\""),
        (copies(&nested), "more than 200000 bodies"),
        (copies("<attach model=\"m\"/>"), "model=\"m\", expected a model of <asset>"),
        ("<include file=\"none.xml\"/>".to_owned(), "none.xml"),
        ("<include file=\"/etc/passwd\"/>".to_owned(), "a path relative to the file"),
        ("<compiler angle=\"turns\"/>".to_owned(), "degree or radian"),
        ("<compiler eulerseq=\"xyw\"/>".to_owned(), "three of xyzXYZ"),
        ("<option timestep=\"0\"/>".to_owned(), "timestep=\"0\""),
        ("<option><flag contact=\"maybe\"/></option>".to_owned(), "enable or disable"),
        (
            "<default><default class=\"a\"/><default class=\"a\"/></default>".to_owned(),
            "another class is called \"a\"",
        ),
        ("<default><default/></default>".to_owned(), "class is missing"),
        (
            format!("{two}<contact><exclude body1=\"a\" body2=\"z\"/></contact>"),
            "there is no body 'z'",
        ),
        (format!("{two}<equality><connect anchor=\"0 0 0\"/></equality>"), "body1 is missing"),
    ];
    for (inside, part) in table {
        let e = match read(&inside) {
            Err(e) => e.to_string(),
            Ok(_) => panic!("read: {inside}"),
        };
        assert!(e.contains(part), "{e}\n  should say: {part}");
        assert!(!e.contains('\n') && e.len() < 1000, "{e}");
        assert!(e.contains("line "), "no place: {e}");
    }
    for (text, part) in damage::broken_xml("mujoco") {
        let e = mjcf::from_text(&text, Path::new("")).unwrap_err().to_string();
        assert!(e.contains(part), "{e}");
    }
}

#[test]
fn files_that_name_themselves_end() {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("mjcf");
    fs::create_dir_all(&folder).unwrap();
    let ball = "<body name=\"b\"><freejoint/><geom size=\"1\"/></body>";
    let file = |name: &str, inside: &str| {
        fs::write(folder.join(name), format!("<mujoco>{inside}</mujoco>")).unwrap();
        mjcf::load(&folder.join(name))
    };
    let e = file("a.xml", "<include file=\"a.xml\"/><worldbody/>").unwrap_err();
    assert!(e.to_string().contains("without end"), "{e}");
    let own = "<asset><model name=\"m\" file=\"c.xml\"/></asset><worldbody><attach model=\"m\" prefix=\"p\"/></worldbody>";
    let e = file("c.xml", own).unwrap_err();
    assert!(e.to_string().contains("without end"), "{e}");
    file("part.xml", ball).unwrap();
    let whole = file("d.xml", "<worldbody><include file=\"part.xml\"/></worldbody>").unwrap();
    assert_eq!(whole.bodies.len(), 2);
    fs::write(folder.join("bad.xml"), "<mujoco><worldbody>").unwrap();
    let e = file("e.xml", "<include file=\"bad.xml\"/>").unwrap_err().to_string();
    assert!(e.contains("bad.xml line 1"), "{e}");
}

#[test]
fn bodies_within_bodies_can_be_any_depth() {
    let deep = "<body><joint/><geom size=\".1\"/>".repeat(5_000) + &"</body>".repeat(5_000);
    let scene = read(&format!("<worldbody>{deep}</worldbody>")).unwrap();
    assert_eq!((scene.bodies.len(), scene.joints.len()), (5_001, 5_000));
    assert_eq!(scene.bodies[0].def.kind, BodyKind::Static);
}

#[test]
fn damaged_files_never_panic() {
    let names = [
        "boxbox_deep.xml",
        "edge_edge.xml",
        "energy_conserving_pendulum.xml",
        "humanoid.xml",
        "newton_cradle.xml",
        "slider_crank.xml",
        "stacked_boxes.xml",
    ];
    let mut texts: Vec<String> =
        names.iter().map(|n| fs::read_to_string(folder().join(n)).unwrap()).collect();
    texts.push(format!("<mujoco>{CRANK}</mujoco>"));
    damage::never_panics(&texts, 1500, |text| mjcf::from_text(text, &folder()));
}
