//! Robots in URDF: what they are read into, how they move, what is refused and how.
#![expect(clippy::unwrap_used, reason = "a test may fail anywhere")]

use std::fs;
use std::path::{Path, PathBuf};

use drystone::joint::JointMotion;
use drystone::{BodyKind, JointKind, MassDef, Pose, Quat, Shape, Vec3, vec3};
use drystone_scene::urdf::{self, Base, Options};
use drystone_scene::{Running, Scene, SceneError};

mod damage;
mod running;

use running::run;

fn data(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/robots").join(name)
}

fn anymal() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../drystone-validate/data/anymal.urdf")
}

fn load(path: &Path) -> Scene {
    urdf::load(path, &Options::default()).unwrap()
}

fn read(inside: &str) -> Result<Scene, SceneError> {
    let text = format!("<robot name=\"r\">{inside}</robot>");
    urdf::from_text(&text, Path::new(""), &Options::default())
}

/// A box of 1 kg on which something hangs.
const BASE: &str = r#"<link name="base"><inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1"/></inertial>
  <collision><geometry><box size="0.1 0.1 0.1"/></geometry></collision></link>"#;

/// A link whose center and axes of inertia are not those of its frame.
fn arm(joint: &str) -> String {
    format!(
        r#"{BASE}<link name="arm"><inertial><origin xyz="0 0 0.5" rpy="0 0 1.5707963"/><mass value="2"/>
        <inertia ixx="1" iyy="2" izz="2.5"/></inertial></link>
        <joint name="j" {joint}<parent link="base"/><child link="arm"/></joint>"#
    )
}

#[test]
fn links_have_the_mass_center_and_inertia_of_their_own_frame() {
    let scene = read(&arm(r#"type="continuous"><axis xyz="0 0 3"/>"#)).unwrap();
    let MassDef::Exact { mass, center, inertia } = scene.bodies[1].def.mass else { panic!() };
    assert!((mass - 2.0).abs() < 1.0e-6 && (center - vec3(0.0, 0.0, 0.5)).length() < 1.0e-6);
    // A quarter turn about z: x and y change places.
    let off = [inertia.xx - 2.0, inertia.yy - 1.0, inertia.zz - 2.5, inertia.xy];
    assert!(off.iter().all(|x| x.abs() < 1.0e-5), "{inertia:?}");
    assert_eq!(scene.config.gravity, vec3(0.0, 0.0, -9.81));
    assert_eq!(scene.bodies[0].def.kind, BodyKind::Static, "one joint moves on the base");
}

#[test]
fn fixed_links_are_one_body_and_keep_their_names() {
    let inside = format!(
        r#"{BASE}<link name="head"><inertial><mass value="3"/><inertia ixx="1" iyy="1" izz="1"/></inertial></link>
        <link name="tip"/>
        <joint name="a" type="fixed"><parent link="base"/><child link="head"/><origin xyz="0 0 2"/></joint>
        <joint name="b" type="fixed"><parent link="head"/><child link="tip"/><origin xyz="1 0 0" rpy="0 0 1"/></joint>"#
    );
    let scene = read(&inside).unwrap();
    assert_eq!((scene.bodies.len(), scene.joints.len()), (1, 0));
    let MassDef::Exact { mass, center, inertia } = scene.bodies[0].def.mass else { panic!() };
    assert!((mass - 4.0).abs() < 1.0e-6 && (center.z - 1.5).abs() < 1.0e-6);
    // Two of 1 kg m², and a reduced mass of 3/4 kg at 2 m.
    assert!((inertia.xx - 5.0).abs() < 1.0e-5 && (inertia.zz - 2.0).abs() < 1.0e-5);
    let names: Vec<&str> = scene.frames.iter().map(|f| f.name.as_str()).collect();
    assert_eq!(names, ["head", "tip"]);
    assert!((scene.frames[1].pose.position - vec3(1.0, 0.0, 2.0)).length() < 1.0e-6);
    assert_eq!(scene.bodies[0].def.kind, BodyKind::Dynamic, "nothing moves on it: it is free");
    assert!(scene.notes.iter().any(|n| n.contains("base 'base': free")));
}

#[test]
fn joints_are_what_they_are_called() {
    let six = |joint: &str| match read(&arm(joint)).unwrap().joints[0].kind {
        JointKind::SixDof(six) => six,
        other => panic!("{other:?}"),
    };
    let limit = r#"<limit lower="-0.5" upper="1.5" effort="1" velocity="2"/>"#;
    let hinge = six(&format!(r#"type="revolute">{limit}<dynamics damping="0.3" friction="0.2"/>"#));
    assert!(matches!(hinge.angular[0].motion, JointMotion::Limited { min: -0.5, max: 1.5, .. }));
    let drive = hinge.angular[0].drive.unwrap();
    assert_eq!((drive.spring.stiffness, drive.spring.damping), (0.0, 0.3));
    let slider = six(&format!(r#"type="prismatic"><axis xyz="0 1 0"/>{limit}"#));
    assert!(matches!(slider.linear[0].motion, JointMotion::Limited { .. }));
    assert!((slider.frame_a.rotate(Vec3::X) - Vec3::Y).length() < 1.0e-6);
    let planar = six(r#"type="planar"><axis xyz="0 0 1"/>"#);
    assert_eq!(planar.linear[0].motion, JointMotion::Locked);
    assert_eq!([planar.linear[1].motion, planar.angular[0].motion], [JointMotion::Free; 2]);
    let floating = read(&arm(r#"type="floating">"#)).unwrap();
    assert!(floating.joints.is_empty() && floating.bodies[1].def.kind == BodyKind::Dynamic);
    assert_eq!(floating.bodies[0].def.kind, BodyKind::Static);
}

#[test]
fn the_base_is_held_as_it_looks_or_as_it_is_told() {
    let kind = |path: &Path, base: Base| {
        urdf::load(path, &Options { base, ground: None }).unwrap().bodies[0].def.kind
    };
    let pendulum = data("double_pendulum_simple.urdf");
    assert_eq!(kind(&pendulum, Base::Auto), BodyKind::Static);
    assert_eq!(kind(&pendulum, Base::Floating), BodyKind::Dynamic);
    assert_eq!(kind(&anymal(), Base::Auto), BodyKind::Dynamic);
    assert_eq!(kind(&anymal(), Base::Fixed), BodyKind::Static);
    assert_eq!(kind(&data("panda_collision.urdf"), Base::Auto), BodyKind::Static);
}

#[test]
fn the_world_is_a_parent_with_and_without_a_link() {
    let joint = |kind: &str| {
        format!(
            r#"<joint name="to_world" type="{kind}"><origin xyz="0 0 2"/><parent link="world"/><child link="base"/></joint>"#
        )
    };
    for link in ["", "<link name=\"world\"/>"] {
        let scene = read(&format!("{link}{BASE}{}", joint("fixed"))).unwrap();
        assert_eq!(scene.bodies.len(), 1, "the base is one with the world");
        assert_eq!(scene.bodies[0].def.kind, BodyKind::Static);
        assert!((scene.bodies[0].def.shapes[0].pose.position.z - 2.0).abs() < 1.0e-6);
        let base = scene.frames.iter().find(|f| f.name == "base").unwrap();
        assert!((base.pose.position.z - 2.0).abs() < 1.0e-6);

        let scene = read(&format!("{link}{BASE}{}", joint("continuous"))).unwrap();
        let kinds: Vec<_> = scene.bodies.iter().map(|b| b.def.kind).collect();
        assert_eq!(kinds, [BodyKind::Static, BodyKind::Dynamic]);
        assert!(matches!(scene.joints[0].kind, JointKind::SixDof(_)));

        // A base that floats from the world falls.
        let scene = read(&format!("{link}{BASE}{}", joint("floating"))).unwrap();
        let running = run(&scene, 1.0, |_| ());
        let at = running.names.iter().position(|n| n == "base").unwrap();
        let height = running.world.body(running.bodies[at]).unwrap().position().z;
        assert!((height - (2.0 - 0.5 * 9.81)).abs() < 0.1, "{height}");
    }
    // A child of that name needs a link, and two firsts are refused as ever.
    let child =
        r#"<joint name="j" type="fixed"><parent link="base"/><child link="world"/></joint>"#;
    assert!(read(&format!("{BASE}{child}")).is_err());
    let lone = format!("{BASE}<link name=\"lone\"/>{}", joint("fixed"));
    assert!(read(&lone).unwrap_err().problem().contains("lone"));
}

#[test]
fn a_mesh_that_is_missing_is_told_before_the_mass_that_it_leaves() {
    let mesh = |inertial: &str| {
        let mesh = r#"<collision><geometry><mesh filename="gone.stl"/></geometry></collision>"#;
        let link = format!("<link name=\"arm\">{inertial}{mesh}</link>");
        let joint =
            r#"<joint name="j" type="continuous"><parent link="base"/><child link="arm"/></joint>"#;
        read(&format!("{BASE}{link}{joint}"))
    };
    let text = mesh("").unwrap_err().to_string();
    assert!(text.find("gone.stl").unwrap() < text.find("mass").unwrap(), "{text}");
    let no_inertia = mesh(r#"<inertial><mass value="1"/></inertial>"#).unwrap();
    assert!(no_inertia.left_out.iter().any(|n| n.contains("gone.stl")), "{:?}", no_inertia.notes);
    assert!(no_inertia.notes.iter().any(|n| n.contains("that of a ball of 1 cm is taken")));
    let whole = r#"<inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1"/></inertial>"#;
    let scene = mesh(whole).unwrap();
    assert!(scene.notes.iter().any(|n| n.contains("gone.stl")), "with a mass it is a note");
}

#[test]
fn meshes_beside_the_file_are_hulls_and_missing_ones_are_told() {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("urdf/robot");
    fs::create_dir_all(folder.join("meshes")).unwrap();
    let corners = ["0 0 0", "1 0 0", "0 1 0", "0 0 1"];
    let faces = [[0, 1, 2], [0, 1, 3], [0, 2, 3], [1, 2, 3]];
    let mut stl = "solid t\n".to_owned();
    for face in faces {
        stl.push_str("facet normal 0 0 0\nouter loop\n");
        face.iter().for_each(|i| stl.push_str(&format!("vertex {}\n", corners[*i])));
        stl.push_str("endloop\nendfacet\n");
    }
    fs::write(folder.join("meshes/t.stl"), stl).unwrap();
    let obj: String = corners.iter().map(|c| format!("v {c}\n")).collect();
    fs::write(folder.join("t.obj"), obj + "f 1 2 3\nf 1 2 4\nf 1 3 4\nf 2 3 4\n").unwrap();
    fs::write(folder.join("t.dae"), "<COLLADA/>").unwrap();
    let collision = |name: &str| {
        format!(
            r#"<collision><geometry><mesh filename="{name}" scale="2 1 1"/></geometry></collision>"#
        )
    };
    let names =
        ["package://robot/meshes/t.stl", "t.obj", "meshes/none.stl", "t.dae", "/etc/passwd"];
    let shapes: String = names.iter().map(|n| collision(n)).collect();
    let text = format!(r#"<robot name="m"><link name="a">{shapes}</link></robot>"#);
    fs::write(folder.join("m.urdf"), text).unwrap();
    let scene = load(&folder.join("m.urdf"));
    assert_eq!(scene.bodies[0].def.shapes.len(), 2);
    for shape in &scene.bodies[0].def.shapes {
        let Shape::Hull(hull) = &shape.shape else { panic!() };
        assert!((hull.volume() - 1.0 / 3.0).abs() < 1.0e-5);
    }
    for part in [
        "none.stl: there is no such file",
        "t.dae: COLLADA is not read, a .stl or .obj of the same mesh is",
        "passwd: a . file is not read",
    ] {
        assert!(scene.notes.iter().any(|n| n.contains(part)), "{part}: {:?}", scene.notes);
    }
    assert!(scene.notes.iter().any(|n| n.contains("a: it has no inertial")));
}

/// Angles of the two links from up, and their rates, of the double pendulum of the file under this
/// gravity [y, z]: Lagrange's equations, with the damping of its joints.
fn pendulum_rates([a, b, u, v]: [f64; 4], gravity: [f64; 2]) -> [f64; 4] {
    let (m1, m2, i1, i2) = (0.2, 0.3, 0.000_177_083, 0.001_015_625);
    let (l, c1, c2, damping) = (0.1, 0.05, 0.1, 0.05);
    let (s, c) = (a - b).sin_cos();
    let (m11, m12, m22) = (i1 + m1 * c1 * c1 + m2 * l * l, m2 * l * c2 * c, i2 + m2 * c2 * c2);
    // A turn about x takes up to (0, -sin, cos).
    let pull = |q: f64, weight: f64| weight * (-gravity[0] * q.cos() - gravity[1] * q.sin());
    let between = damping * (v - u);
    let f1 = pull(a, m1 * c1 + m2 * l) - m2 * l * c2 * s * v * v - damping * u + between;
    let f2 = pull(b, m2 * c2) + m2 * l * c2 * s * u * u - between;
    let det = m11 * m22 - m12 * m12;
    [u, v, (m22 * f1 - m12 * f2) / det, (m11 * f2 - m12 * f1) / det]
}

/// Runge and Kutta's step of fourth order.
fn runge_kutta(x: [f64; 4], h: f64, rates: impl Fn([f64; 4]) -> [f64; 4]) -> [f64; 4] {
    let along = |k: [f64; 4], h: f64| core::array::from_fn(|i| x[i] + h * k[i]);
    let k1 = rates(x);
    let k2 = rates(along(k1, 0.5 * h));
    let k3 = rates(along(k2, 0.5 * h));
    let k4 = rates(along(k3, h));
    core::array::from_fn(|i| x[i] + h / 6.0 * (k1[i] + 2.0 * k2[i] + 2.0 * k3[i] + k4[i]))
}

#[test]
fn the_double_pendulum_swings_as_its_equations_say() {
    // It stands upright in the file; gravity from the side makes it swing.
    let gravity = [6.0, -7.76];
    let mut errors = Vec::new();
    for hz in [60.0_f32, 240.0] {
        let mut scene = load(&data("double_pendulum_simple.urdf"));
        scene.config.gravity = vec3(0.0, 6.0, -7.76);
        scene.config.sleep.enabled = false;
        let mut running = scene.build().unwrap();
        let mut x = [0.0; 4];
        let (mut off, mut fastest) = (0.0_f64, 0.0_f64);
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "120 or 480")]
        let steps = (2.0 * hz) as u32;
        for _ in 0..steps {
            running.step(hz.recip()).unwrap();
            for _ in 0..100 {
                x = runge_kutta(x, f64::from(hz.recip()) / 100.0, |x| pendulum_rates(x, gravity));
            }
            let [a, b, u, v] = x;
            let exact = [-0.1 * a.sin() - 0.2 * b.sin(), 0.1 * a.cos() + 0.2 * b.cos()];
            let body = running.world.body(running.bodies[2]).unwrap();
            let end = Pose::new(body.position(), body.rotation()).point(vec3(0.0, 0.0, 0.2));
            let gap = [f64::from(end.y) - exact[0], f64::from(end.z) - exact[1]];
            off = off.max(gap[0].hypot(gap[1]));
            fastest = fastest.max(0.1 * u.abs() + 0.2 * v.abs());
        }
        // It ends where gravity pulls it, far from where it began.
        assert!(x[0].abs() > 0.5 && fastest > 0.3, "{x:?}");
        println!("{hz} Hz: {off} m at up to {fastest} m/s");
        errors.push(off);
        // The acceleration is known to a step: it is off by no more than the way of a step at the
        // greatest speed.
        assert!(off < fastest / f64::from(hz), "{hz} Hz: {off}, {fastest} m/s");
    }
    // First order in the step: a quarter.
    assert!(errors[1] < 0.3 * errors[0], "{errors:?}");
}

#[test]
fn anymal_falls_onto_the_ground_and_comes_to_rest_in_one_piece() {
    let options = Options { ground: Some(-1.0), ..Options::default() };
    let scene = urdf::load(&anymal(), &options).unwrap();
    let links = scene.bodies.len() + scene.frames.len() - 1;
    assert_eq!(links, 23, "every link has a name");
    let running = run(&scene, 10.0, |_| {});
    for (name, id) in running.names.iter().zip(&running.bodies).skip(1) {
        let body = running.world.body(*id).unwrap();
        assert!(body.position().z > -1.01, "{name} at {:?}", body.position());
        assert!(body.linear_velocity().length() < 0.2, "{name}: {:?}", body.linear_velocity());
    }
    let start = scene.bodies[1].def.position.z;
    let base = running.world.body(running.bodies[1]).unwrap().position().z;
    assert!(base < start - 0.4, "it fell from {start} m to {base} m");
}

#[test]
fn fingers_that_mimic_go_together() {
    let mut scene = load(&data("panda_collision.urdf"));
    assert_eq!(scene.couplings.len(), 1);
    scene.config.gravity = Vec3::ZERO;
    let mut running = scene.build().unwrap();
    let id = running.couplings[0];
    let finger = running.names.iter().position(|n| n == "panda_leftfinger").unwrap();
    let finger = running.bodies[finger];
    let coordinates = |running: &Running| {
        let all = running.world.joints().filter_map(|j| j.coordinates());
        let ways: Vec<f32> = all.map(|c| c[0].x).collect();
        [ways[7], ways[8]]
    };
    let (mut worst, mut fastest, mut last) = (0.0_f32, 0.0_f32, coordinates(&running));
    for step in 0..240 {
        // One finger is pulled along its slider, which is across the hand, and pushed back later.
        let hand = running.world.body(running.bodies[7]).unwrap().rotation();
        let way = hand
            .rotate(Quat::from_axis_angle(Vec3::Z, -core::f32::consts::FRAC_PI_4).rotate(Vec3::Y));
        let push = way * if step < 120 { 0.1 } else { -0.1 };
        running.world.body_mut(finger).unwrap().set_lasting_force(push);
        running.step(1.0 / 60.0).unwrap();
        let now = coordinates(&running);
        worst = worst.max(running.world.joint(id).unwrap().error());
        fastest = fastest.max(60.0 * (now[0] - last[0]).abs());
        last = now;
        if step == 119 {
            assert!((now[0] - 0.04).abs() < 1.0e-3 && (now[1] - 0.04).abs() < 1.0e-3, "{now:?}");
        }
    }
    println!("fingers off by up to {worst} m, {fastest} m/s, at {last:?} in the end");
    // Each goes its way alone for a substep at most when the other strikes its limit.
    assert!(fastest > 0.05 && worst < 2.0 * fastest / 480.0, "{worst} m, {fastest} m/s");
    assert!(last[0].abs() < 1.0e-3 && last[1].abs() < 1.0e-3, "{last:?}");
}

#[test]
fn what_is_coupled_counts_as_the_file_does() {
    let inside = format!(
        r#"{BASE}<link name="a"><inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1"/></inertial></link>
        <link name="b"><inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1"/></inertial></link>
        <joint name="j" type="continuous"><axis xyz="0 0 1"/><parent link="base"/><child link="a"/></joint>
        <joint name="k" type="continuous"><axis xyz="0 0 -1"/><parent link="base"/><child link="b"/>
          <mimic joint="j" multiplier="-3" offset="0.25"/></joint>"#
    );
    let options = Options { base: Base::Fixed, ground: None };
    let text = format!("<robot name=\"r\">{inside}</robot>");
    let scene = urdf::from_text(&text, Path::new(""), &options).unwrap();
    let mut running = scene.build().unwrap();
    let a = running.bodies[1];
    running.world.body_mut(a).unwrap().apply_angular_impulse([0.0, 0.0, 1.0]);
    for _ in 0..120 {
        running.step(1.0 / 60.0).unwrap();
    }
    let turn =
        |i: usize| running.world.joint(running.joints[i]).unwrap().coordinates().unwrap()[1].x;
    assert!((turn(1) + 3.0 * turn(0) - 0.25).abs() < 1.0e-3, "{} {}", turn(0), turn(1));
    // 1 N m s on 1 kg m² and nine times that through the coupling, less what its offset turned at
    // first.
    assert!(turn(0) > 0.1, "{}", turn(0));
    for (part, wrong) in [("joint=\"j\"", "joint=\"x\""), ("joint=\"j\"", "joint=\"k\"")] {
        let scene = read(&inside.replace(part, wrong)).unwrap();
        assert!(scene.left_out.iter().any(|n| n.contains("it mimics")), "{:?}", scene.left_out);
        assert!(scene.couplings.is_empty());
    }
}

#[test]
fn all_robots_run_for_ten_seconds() {
    for path in [data("double_pendulum_simple.urdf"), data("panda_collision.urdf"), anymal()] {
        let running = run(&load(&path), 10.0, |_| {});
        let finite = |p: Vec3| p.is_finite();
        assert!(running.world.bodies().all(|b| finite(b.position())), "{}", path.display());
    }
}

#[test]
fn what_is_wrong_is_said_in_one_line() {
    let link = |name: &str| format!("<link name=\"{name}\"/>");
    let joint = |name: &str, parent: &str, child: &str| {
        format!(
            "<joint name=\"{name}\" type=\"fixed\"><parent link=\"{parent}\"/><child link=\"{child}\"/></joint>"
        )
    };
    let shape = |inside: &str| {
        format!("<link name=\"a\"><collision><geometry>{inside}</geometry></collision></link>")
    };
    let mass = |inside: &str| {
        let one = r#"type="continuous"><axis xyz="1 0 0"/>"#;
        arm(one).replace(r#"<mass value="2"/>"#, inside)
    };
    let table: Vec<(String, &str)> = vec![
        (String::new(), "it has no link"),
        (link("a") + &link("a"), "another link has this name"),
        ("<link/>".to_owned(), "name is missing"),
        (link("a") + &link("b"), "no joint is above 'a', nor above 'b'"),
        (link("a") + &link("b") + &joint("j", "a", "c"), "its child is 'c', which is no link"),
        (link("a") + &joint("j", "x", "a"), "its parent is 'x', which is no link"),
        (link("a") + &joint("j", "a", "a"), "its parent is its child"),
        (
            link("a") + &link("b") + &joint("j", "a", "b") + &joint("k", "b", "a"),
            "its joints form a loop",
        ),
        (
            link("r") + &link("a") + &link("b") + &joint("j", "a", "b") + &joint("k", "b", "a"),
            "form a loop that the first link is not in",
        ),
        (
            link("a") + &link("b") + &joint("j", "a", "b") + &joint("k", "a", "b"),
            "its child 'b' is the child of joint 'j' already",
        ),
        (
            link("a") + &link("b") + &joint("j", "a", "b") + &joint("j", "a", "b"),
            "another joint has this name",
        ),
        (arm("type=\"magic\">"), "type=\"magic\", expected fixed, revolute"),
        (arm("type=\"continuous\"><axis xyz=\"0 0 0\"/>"), "a direction that is not zero"),
        (arm("type=\"continuous\"><axis xyz=\"0 0\"/>"), "3 finite numbers"),
        (arm("type=\"continuous\"><origin xyz=\"0 nan 0\"/>"), "xyz=\"0 nan 0\""),
        (arm("type=\"continuous\"><origin xyz=\"0 1e400 0\"/>"), "finite numbers"),
        (arm("type=\"continuous\"><dynamics damping=\"-1\"/>"), "damping=\"-1\""),
        (mass("<mass value=\"-2\"/>"), "value=\"-2\", expected a number of at least 0"),
        (mass("<mass value=\"NaN\"/>"), "value=\"NaN\""),
        (mass(""), "it has no <mass>"),
        (
            arm("type=\"continuous\">")
                .replace("ixx=\"1\" iyy=\"2\"", "ixx=\"1\" ixy=\"3\" iyy=\"2\""),
            "principal moments of",
        ),
        (shape("<box size=\"1 -1 1\"/>"), "three numbers of at least 0"),
        (shape("<sphere radius=\"-1\"/>"), "radius=\"-1\""),
        (shape("<cylinder radius=\"1\"/>"), "length is missing"),
        (shape(""), "it has no <geometry> with a shape"),
    ];
    for (inside, part) in table {
        let e = read(&inside).unwrap_err().to_string();
        assert!(e.contains(part), "{e}\n  should say: {part}");
        assert!(!e.contains('\n') && e.len() < 1000, "{e}");
        assert!(inside.is_empty() || e.contains("line "), "no place: {e}");
    }
    let whole = |text: &str| {
        urdf::from_text(text, Path::new(""), &Options::default()).unwrap_err().to_string()
    };
    for (text, part) in damage::broken_xml("robot") {
        let e = whole(&text);
        assert!(e.contains(part), "{e}");
    }
    let none = urdf::load(&data("none.urdf"), &Options::default()).unwrap_err().to_string();
    assert!(none.contains("none.urdf"), "{none}");
}

#[test]
fn a_long_chain_is_read_without_end_of_the_stack() {
    let mut inside = String::from("<link name=\"l0\"/>");
    for i in 1..20_000 {
        inside.push_str(&format!(
            "<link name=\"l{i}\"/><joint name=\"j{i}\" type=\"fixed\"><parent link=\"l{}\"/><child link=\"l{i}\"/></joint>",
            i - 1
        ));
    }
    let inside = inside.replacen("<link name=\"l0\"/>", &BASE.replace("base", "l0"), 1);
    let scene = read(&inside).unwrap();
    assert_eq!((scene.bodies.len(), scene.frames.len()), (1, 19_999));
}

#[test]
fn damaged_files_never_panic() {
    let texts: Vec<String> =
        [data("double_pendulum_simple.urdf"), data("panda_collision.urdf"), anymal()]
            .iter()
            .map(|path| fs::read_to_string(path).unwrap())
            .collect();
    let read = |text: &str| urdf::from_text(text, &data(""), &Options::default());
    damage::never_panics(&texts, 600, read);
}
