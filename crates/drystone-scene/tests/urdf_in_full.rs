//! URDF as it is written in the field: what other readers accept is read, and what is not read is
//! named with its count and line.
#![expect(clippy::unwrap_used, reason = "a test may fail anywhere")]

use std::path::Path;

use drystone::{BodyKind, JointKind, MassDef, Shape, Vec3, vec3};
use drystone_scene::urdf::{self, Base, Options};
use drystone_scene::{Scene, SceneError};

mod running;

use running::run;

fn whole(text: &str) -> Result<Scene, SceneError> {
    urdf::from_text(text, Path::new(""), &Options::default())
}

fn read(inside: &str) -> Result<Scene, SceneError> {
    whole(&format!("<robot name=\"r\">{inside}</robot>"))
}

fn link(name: &str, mass: f32, inside: &str) -> String {
    format!(
        r#"<link name="{name}"><inertial><mass value="{mass}"/><inertia ixx="1" iyy="1" izz="1"/></inertial>{inside}</link>"#
    )
}

fn joint(kind: &str, parent: &str, child: &str, inside: &str) -> String {
    format!(
        r#"<joint name="{child}_joint" type="{kind}"><parent link="{parent}"/><child link="{child}"/>{inside}</joint>"#
    )
}

/// An arm of 1 kg on a base of 2 kg.
fn arm(of_joint: &str, of_arm: &str) -> String {
    link("base", 2.0, "")
        + &link("arm", 1.0, of_arm)
        + &joint("continuous", "base", "arm", of_joint)
}

fn mass(scene: &Scene, name: &str) -> (f32, Vec3) {
    let body = scene.bodies.iter().find(|b| b.name == name).unwrap();
    match body.def.mass {
        MassDef::Exact { mass, inertia, .. } => (mass, inertia.eigen().0),
        _ => (0.0, Vec3::ZERO),
    }
}

fn has(lines: &[String], part: &str) -> bool {
    lines.iter().any(|line| line.contains(part))
}

#[test]
fn what_is_not_read_is_named_with_count_and_first_line() {
    let collision = |more: &str| {
        format!("<collision {more}><geometry><sphere radius=\"1\"/></geometry></collision>")
    };
    for (inside, part) in [
        (arm("<dynamics spring_stiffness=\"1\"/>", ""), "<dynamics spring_stiffness>"),
        (arm("<joint_properties damping=\"1\"/>", ""), "<joint_properties>"),
        (arm("<nonsense/>", ""), "<nonsense>"),
        (arm("", &collision("group=\"1\"")), "<collision group>"),
        (arm("", "<contact><rolling_friction value=\"0.1\"/></contact>"), "<rolling_friction>"),
        (arm("", "<contact><stiffness value=\"1000\"/></contact>"), "<stiffness>"),
        (arm("", "<inertial/>"), "a second <inertial> of one <link>"),
        (arm("<limit lower=\"1\" damper=\"2\"/>", ""), "<limit damper>"),
        (arm("<axis xyz=\"1 0 0\" frame=\"base\"/>", ""), "<axis frame>"),
        (arm("", "") + "<gazebo reference=\"arm\"><mu1>1</mu1></gazebo>", "<mu1> of <gazebo>"),
        (arm("", "") + "<gazebo/>", "<gazebo>"),
        (arm("", "") + "<mujoco><compiler boundmass=\"1\"/></mujoco>", "<compiler boundmass> of"),
        (arm("", "") + "<loop_joint/>", "<loop_joint>"),
    ] {
        let scene = read(&inside).unwrap();
        assert!(has(&scene.left_out, part), "{inside}: {:?}", scene.left_out);
        assert!(scene.left_out.iter().all(|n| scene.notes.contains(n)), "{:?}", scene.notes);
    }
    let two = format!("\n{}\n\n{}", link("base", 1.0, "<a/>"), link("arm", 1.0, "<a/>"));
    let scene = read(&(two + &joint("fixed", "base", "arm", ""))).unwrap();
    assert_eq!(scene.left_out, ["<a>: not read (2 times, first in line 2, <a>)"]);
}

#[test]
fn what_only_motors_and_pictures_need_is_no_physics() {
    let limits = r#"<limit effort="5" velocity="inf"/><safety_controller k_velocity="1"/><calibration rising="0"/>"#;
    let seen = r#"<visual><geometry><box size="1 1 1"/></geometry></visual>"#;
    let driven = r#"<transmission name="t"><type>x</type><joint name="arm_joint"/></transmission>
        <ros2_control name="c" type="system"/><material name="m"/><gazebo><plugin name="p"/></gazebo>"#;
    let scene = read(&(arm(limits, seen) + driven)).unwrap();
    assert!(scene.left_out.is_empty(), "{:?}", scene.left_out);
    for part in [
        "<limit effort>: not read (once, first in line 1, <limit>); only motors",
        "<limit velocity>",
        "<safety_controller>",
        "<calibration>",
        "<type> of <transmission>",
        "<joint> of <transmission>",
        "<ros2_control>",
        "<plugin> of <gazebo>",
    ] {
        assert!(has(&scene.notes, part), "{part}: {:?}", scene.notes);
    }
    assert!(!has(&scene.notes, "visual") && !has(&scene.notes, "material"), "{:?}", scene.notes);
    let none = read(&arm("", "<contact><rolling_friction value=\"0\"/></contact>")).unwrap();
    assert!(none.left_out.is_empty(), "{:?}", none.left_out);
}

#[test]
fn a_root_without_a_mass_is_static_and_told_so() {
    let floor = r#"<collision><geometry><box size="9 9 1"/></geometry></collision>"#;
    let bare = "<link name=\"base\"/>".to_owned();
    let hanging = link("arm", 1.0, "")
        + &joint("continuous", "base", "arm", "")
        + &link("leg", 1.0, "")
        + &joint("continuous", "base", "leg", "");
    let fixed = "<link name=\"foot\"/><link name=\"base\"/>".to_owned()
        + &joint("fixed", "foot", "base", "");
    for inside in [link("base", 0.0, floor), bare.clone(), bare + &hanging, fixed + &hanging] {
        let scene = read(&inside).unwrap();
        assert_eq!(scene.bodies[0].def.kind, BodyKind::Static, "{inside}");
        assert!(
            has(&scene.notes, "fixed to the world, because it has no mass"),
            "{:?}",
            scene.notes
        );
        assert!(scene.left_out.is_empty(), "{:?}", scene.left_out);
    }
    // Asked to float, it is refused.
    let text = "<robot name=\"r\"><link name=\"base\"/></robot>";
    let options = Options { base: Base::Floating, ground: None };
    let e = urdf::from_text(text, Path::new(""), &options).unwrap_err().to_string();
    assert!(e.contains("'base' moves and has a mass of 0 kg"), "{e}");
    // Shapes without an inertial have their own mass.
    let shaped = read(&format!("<link name=\"a\">{floor}</link>")).unwrap();
    assert_eq!(shaped.bodies[0].def.kind, BodyKind::Dynamic);
}

#[test]
fn a_massless_link_between_two_joints_makes_one_joint_of_two_axes() {
    let inside = link("base", 2.0, "")
        + "<link name=\"cross\"/>"
        + &link("arm", 1.0, "")
        + &joint("continuous", "base", "cross", "<origin xyz=\"0 0 1\"/><axis xyz=\"1 0 0\"/>")
        + &joint(
            "revolute",
            "cross",
            "arm",
            "<origin rpy=\"0 0 1.57079632\"/><axis xyz=\"1 0 0\"/><limit lower=\"-1\" upper=\"2\"/>",
        );
    let scene = read(&inside).unwrap();
    assert_eq!((scene.bodies.len(), scene.joints.len()), (2, 1), "{:?}", scene.notes);
    let JointKind::SixDof(six) = scene.joints[0].kind else { panic!() };
    let free = six.angular.iter().filter(|a| a.motion != drystone::joint::JointMotion::Locked);
    assert_eq!(free.count(), 2);
    // The masses are those of the file, and so is the place of the arm.
    assert!((mass(&scene, "arm").0 - 1.0).abs() < 1.0e-6);
    assert!((scene.bodies[1].def.position - vec3(0.0, 0.0, 1.0)).length() < 1.0e-6);
    assert!(has(&scene.notes, "'cross' has no mass"), "{:?}", scene.notes);
    assert!(scene.frames.iter().any(|f| f.name == "cross"));
    run(&scene, 1.0, |_| ());
}

#[test]
fn a_massless_link_with_two_joints_on_it_takes_a_part_of_the_next_mass() {
    let inside = link("base", 2.0, "")
        + "<link name=\"hub\"/>"
        + &link("a", 1.0, "")
        + &link("b", 1.0, "")
        + &joint("continuous", "base", "hub", "")
        + &joint("continuous", "hub", "a", "<axis xyz=\"0 1 0\"/>")
        + &joint("continuous", "hub", "b", "<axis xyz=\"0 1 0\"/>");
    let scene = read(&inside).unwrap();
    assert_eq!((scene.bodies.len(), scene.joints.len()), (4, 3));
    let total: f32 = ["hub", "a", "b"].map(|n| mass(&scene, n).0).iter().sum();
    assert!((total - 2.0).abs() < 1.0e-6, "{total}");
    run(&scene, 1.0, |_| ());
}

#[test]
fn a_massless_link_at_the_end_is_held_fast_and_named() {
    let of_base = mass(&read(&arm("", "")).unwrap(), "arm").1;
    for tip in ["<link name=\"tip\"/>".to_owned(), link("tip", 0.0, "")] {
        let inside =
            arm("", "") + &tip + &joint("continuous", "arm", "tip", "<origin xyz=\"0 0 1\"/>");
        let scene = read(&inside).unwrap();
        assert_eq!(scene.joints.len(), 1);
        assert_eq!(mass(&scene, "arm").1, of_base, "no mass has no inertia");
        assert!(has(&scene.left_out, "joint tip_joint: 'tip' and what hangs on it have no mass"));
        let frame = scene.frames.iter().find(|f| f.name == "tip").unwrap();
        assert!((frame.pose.position - vec3(0.0, 0.0, 1.0)).length() < 1.0e-6);
        // It follows nothing, then.
        let mimic = inside.replace("</joint>", "<mimic joint=\"tip_joint\"/></joint>");
        assert!(has(&read(&mimic).unwrap().left_out, "its mimic is left out"));
    }
}

#[test]
fn long_chains_without_a_mass_take_no_time() {
    let chain = |end: &str| {
        let mut inside = link("l0", 1.0, "");
        for i in 1..20_000 {
            let (above, own) = (format!("l{}", i - 1), format!("l{i}"));
            inside += &format!("<link name=\"{own}\"/>{}", joint("continuous", &above, &own, ""));
        }
        inside + end
    };
    let scene = read(&chain("")).unwrap();
    assert_eq!((scene.bodies.len(), scene.joints.len()), (1, 0));
    let end = link("end", 1.0, "") + &joint("continuous", "l19999", "end", "");
    assert!(read(&chain(&end)).unwrap_err().to_string().contains("mass"));
}

#[test]
fn what_follows_a_joint_that_is_held_follows_together() {
    let mimic = |ratio: f32, offset: f32| {
        format!("<mimic joint=\"tip_joint\" multiplier=\"{ratio}\" offset=\"{offset}\"/>")
    };
    let inside = link("base", 2.0, "")
        + "<link name=\"tip\"/>"
        + &joint("continuous", "base", "tip", "")
        + &link("a", 1.0, "")
        + &joint("continuous", "base", "a", &mimic(2.0, 0.5))
        + &link("b", 1.0, "")
        + &joint("continuous", "base", "b", &mimic(-3.0, 0.25));
    let scene = read(&inside).unwrap();
    let [coupling] = scene.couplings[..] else { panic!("{:?}", scene.couplings) };
    // b = -3 q + 0.25 with q = (a - 0.5) / 2, and all axes are x.
    assert_eq!([coupling.joint_a, coupling.joint_b], [0, 1]);
    assert!((coupling.ratio + 1.5).abs() < 1.0e-6 && (coupling.offset - 1.0).abs() < 1.0e-6);
    assert!(has(&scene.notes, "joint a_joint: for 'tip_joint', which does not move, it leads"));
}

#[test]
fn marks_of_no_size_are_left_out_by_name() {
    for (shape, said) in [
        ("<sphere radius=\"0\"/>", "a sphere of radius=\"0\" has no size"),
        ("<sphere radius=\"1e-7\"/>", "a sphere of radius=\"1e-7\" has no size"),
        (
            "<cylinder radius=\"0\" length=\"0\"/>",
            "a cylinder of radius=\"0\" length=\"0\" has no size",
        ),
        ("<box size=\"0 0 0\"/>", "a box of size=\"0 0 0\" has no size"),
        ("<cone radius=\"1\"/>", "<cone> is not read"),
    ] {
        let collision = format!("<collision><geometry>{shape}</geometry></collision>");
        let scene = read(&arm("", &collision)).unwrap();
        assert!(
            has(&scene.left_out, &format!("arm: a collision is left out: {said}")),
            "{:?}",
            scene.notes
        );
        assert!(scene.bodies[1].def.shapes.is_empty());
    }
    let ball = "<collision><geometry><capsule radius=\".1\" length=\"0\"/></geometry></collision>";
    assert_eq!(read(&arm("", ball)).unwrap().bodies[1].def.shapes.len(), 1);
}

/// A link with this inertia, alone.
fn body(inertia: &str, inside: &str) -> Result<Scene, SceneError> {
    read(&format!(
        r#"<link name="b"><inertial><mass value="0.5"/><inertia {inertia}/></inertial>{inside}</link>"#
    ))
}

#[test]
fn inertias_are_taken_as_given_or_repaired_by_name() {
    let moments = |inertia: &str| {
        let scene = body(inertia, "").unwrap();
        let (_, m) = mass(&scene, "b");
        let mut sorted = m.to_array();
        sorted.sort_by(f32::total_cmp);
        (sorted, scene)
    };
    // A placeholder that is far too large for its mass is legal.
    let (m, scene) = moments(r#"ixx="100" iyy="100" izz="100""#);
    assert!(
        m.iter().all(|x| (x - 100.0).abs() < 1.0e-3) && !has(&scene.notes, "kg m2"),
        "{:?}",
        scene.notes
    );
    // So is one that no body has, with a word.
    let (m, scene) = moments(r#"ixx="1" iyy="1" izz="5""#);
    assert!((m[2] - 5.0).abs() < 1.0e-4 && has(&scene.notes, "no body has its principal moments"));
    // A planar one is that of a thin rod: at least a millionth of the others.
    let (m, scene) = moments(r#"ixx="1" iyy="1" izz="0""#);
    assert!(m[0] > 0.9e-6 && m[0] < 1.1e-6 && (m[1] - 1.0).abs() < 1.0e-5, "{m:?}");
    assert!(has(&scene.notes, "raised"), "{:?}", scene.notes);
    assert!(scene.left_out.is_empty(), "{:?}", scene.left_out);
    // Rounded below zero.
    let (m, scene) = moments(r#"ixx="-5.4e-20" iyy="1e-4" izz="1e-4""#);
    assert!(
        m[0] > 0.0 && has(&scene.notes, "its ixx of -0.000000000000000000054 is taken as 0"),
        "{:?}",
        scene.notes
    );
    let (_, scene) = moments(r#"ixx="-5.4e-20" iyy="-5.4e-20" izz="1e-4""#);
    assert!(scene.left_out.is_empty(), "{:?}", scene.left_out);
    // Two digits of a rod along the diagonal of x and y: 0.01, less than rounding below zero.
    let (m, scene) = moments(r#"ixx="0.01" iyy="0.01" izz="0.02" ixy="-0.01005""#);
    assert!(m[0] > 0.0 && has(&scene.notes, "is taken as 0"), "{:?}", scene.notes);
    // No body: refused, or that of its shapes if it has some.
    let impossible = r#"ixx="1" iyy="2" izz="2" ixy="3""#;
    assert!(body(impossible, "").unwrap_err().to_string().contains("principal moments of"));
    let shaped = "<collision><geometry><sphere radius=\"1\"/></geometry></collision>";
    let scene = body(impossible, shaped).unwrap();
    assert!((mass(&scene, "b").1 - Vec3::splat(0.2)).length() < 1.0e-5);
    assert!(has(&scene.left_out, "which no body has: it is left out"), "{:?}", scene.left_out);
    assert!(
        body(r#"ixx="-1" iyy="1" izz="1""#, "").unwrap_err().to_string().contains("ixx=\"-1\"")
    );
    // A mass alone is a small ball.
    let alone = r#"<link name="b"><inertial><mass value="0.5"/></inertial></link>"#;
    let scene =
        read(&(link("base", 1.0, "") + alone + &joint("continuous", "base", "b", ""))).unwrap();
    assert!((mass(&scene, "b").1.x - 0.4 * 0.5 * 1.0e-4).abs() < 1.0e-9);
    assert!(has(&scene.notes, "that of a ball of 1 cm"));
    // Rounding is no moment either.
    let scene = body(r#"ixx="-5.4e-20" iyy="3e-22" izz="5.4e-20" ixy="1e-20""#, "").unwrap();
    assert!((mass(&scene, "b").1.x - 0.4 * 0.5 * 1.0e-4).abs() < 1.0e-9);
}

#[test]
fn a_planar_inertia_falls_and_rests() {
    let ball = "<collision><geometry><box size=\".1 .1 .1\"/></geometry></collision>";
    let text = format!(
        r#"<robot name="r"><link name="b"><inertial><mass value="0.1"/><inertia ixx="1" iyy="1" izz="0"/></inertial>{ball}</link></robot>"#
    );
    let options = Options { base: Base::Floating, ground: Some(-0.5) };
    let scene = urdf::from_text(&text, Path::new(""), &options).unwrap();
    let running = run(&scene, 3.0, |_| ());
    let body = running.world.body(running.bodies[1]).unwrap();
    assert!((body.position().z + 0.45).abs() < 1.0e-3, "{}", body.position().z);
    assert!(body.linear_velocity().length() < 1.0e-3, "{:?}", body.linear_velocity());
}

#[test]
fn files_that_are_almost_xml_are_read_and_lines_are_kept() {
    let one = link("a", 1.0, "<odd/>");
    for text in [
        format!("\n\n<?xml version=\"1.0\"?>\n<robot name=\"r\">{one}</robot>"),
        format!("<!-- made\nby hand --><?xml version=\"1.0\"?>\n\n<robot name=\"r\">{one}</robot>"),
        format!("<?xml version=\"1.0\"?>\n<!DOCTYPE robot>\n\n<robot name=\"r\">{one}</robot>"),
        format!("\n\n\n<robot name=\"r\">{one}</robot>\r\n\0"),
        format!("\n\n\n<robot name=\"r\">{one}<drake:thing/><p:q p:r=\"1\"/></robot>"),
    ] {
        let scene = whole(&text).unwrap();
        assert!(
            has(&scene.left_out, "<odd>: not read (once, first in line 4, <odd>)"),
            "{:?}",
            scene.left_out
        );
    }
    let scene = whole(&format!("<robot name=\"r\">{one}<drake:thing/></robot>")).unwrap();
    assert!(has(&scene.left_out, "<drake:thing>"), "{:?}", scene.left_out);
    for text in
        ["<!DOCTYPE", "<?xml", "<!--", "<", "<a:", " \u{feff}<?xml ?>\u{fc}", "<a:b", "<p:\u{fc}"]
    {
        assert!(whole(text).is_err());
    }
}

#[test]
fn lists_may_have_commas_and_more_or_fewer_numbers() {
    let origin = "<origin xyz=\"1, 2,3\" rpy=\"0,0,0\"/>";
    let scene = read(&arm(origin, "")).unwrap();
    assert!((scene.bodies[1].def.position - vec3(1.0, 2.0, 3.0)).length() < 1.0e-6);
    assert!(scene.left_out.is_empty(), "{:?}", scene.left_out);
    let scene = read(&arm("<origin xyz=\"1 2 3 4\"/>", "")).unwrap();
    assert!((scene.bodies[1].def.position - vec3(1.0, 2.0, 3.0)).length() < 1.0e-6);
    assert!(has(&scene.left_out, "<origin xyz> beyond three numbers: not read (once"));
    for bad in ["1 2", "1;2;3", "", "1, nan, 2", "1 2 3 x"] {
        assert!(read(&arm(&format!("<origin xyz=\"{bad}\"/>"), "")).is_err(), "{bad}");
    }
}

#[test]
fn bounds_may_be_infinite() {
    let range = |limit: &str| {
        let inside = arm(limit, "").replace("continuous", "revolute");
        let scene = read(&inside).unwrap();
        let JointKind::SixDof(six) = scene.joints[0].kind else { panic!() };
        (six.angular[0].motion, scene)
    };
    use drystone::joint::JointMotion::{Free, Limited};
    let (motion, scene) =
        range("<limit lower=\"-inf\" upper=\"1.8e308\" effort=\"inf\" velocity=\"3.4e38\"/>");
    assert!(motion == Free && !has(&scene.notes, "no room"), "{:?}", scene.notes);
    let (motion, scene) = range("<limit lower=\"-1\" upper=\"1e300\"/>");
    assert!(matches!(motion, Limited { min: -1.0, max: f32::INFINITY, .. }), "{motion:?}");
    run(&scene, 0.5, |_| ());
    for bad in ["nan", "x", ""] {
        let inside = arm(&format!("<limit lower=\"{bad}\" upper=\"1\"/>"), "");
        assert!(read(&inside.replace("continuous", "revolute")).is_err(), "{bad}");
    }
}

#[test]
fn what_a_kind_of_joint_cannot_have_is_named() {
    let scene = read(&arm("<limit lower=\"-1\" upper=\"1\"/>", "")).unwrap();
    assert!(has(&scene.notes, "joint arm_joint: it has limits of -1 and 1, but as a continuous"));
    assert!(scene.left_out.is_empty(), "{:?}", scene.left_out);
    let planar = arm("<dynamics friction=\"1\"/>", "").replace("continuous", "planar");
    assert!(has(&read(&planar).unwrap().left_out, "the friction of a planar joint is left out"));
    let none =
        read(&arm("<limit lower=\"0\" upper=\"0\"/><dynamics friction=\"1\"/>", "")).unwrap();
    assert!(!has(&none.notes, "it has limits") && none.left_out.is_empty());
}

#[test]
fn xacro_is_named_with_the_way_to_expand_it() {
    let call = "<xacro:macro name=\"m\"/>";
    for text in [
        format!("<robot xmlns:xacro=\"http://www.ros.org/wiki/xacro\">{call}</robot>"),
        format!("<robot name=\"r\">{call}</robot>"),
        format!("<robot name=\"r\">\n{}</robot>", arm("<origin xyz=\"${x} 0 0\"/>", "")),
        format!("<robot name=\"$(arg name)\">{}</robot>", arm("", "")),
    ] {
        let e = whole(&text).unwrap_err().to_string();
        assert!(e.contains("it is a xacro file") && e.contains("xacro FILE > robot.urdf"), "{e}");
    }
    // The output of xacro keeps its namespace, and definitions change nothing.
    let text = format!(
        "<robot name=\"r\" xmlns:xacro=\"http://x\"><xacro:property name=\"x\" value=\"1\"/>{}</robot>",
        arm("", "")
    );
    assert!(whole(&text).is_ok());
}

#[test]
fn joints_of_pybullet_and_drake_are_read() {
    let spherical = arm("", "").replace("continuous", "spherical");
    assert!(matches!(read(&spherical).unwrap().joints[0].kind, JointKind::Ball));
    let drake = arm("", "").replace("<joint", "<drake:joint").replace("</joint", "</drake:joint");
    let ball = read(&drake.replace("continuous", "ball")).unwrap();
    assert!(matches!(ball.joints[0].kind, JointKind::Ball) && ball.left_out.is_empty());
    let universal = read(&drake.replace("continuous", "universal")).unwrap();
    let JointKind::SixDof(six) = universal.joints[0].kind else { panic!() };
    let free = six.angular.iter().filter(|a| a.motion == drystone::joint::JointMotion::Free);
    assert_eq!(free.count(), 2);
    let screw = read(&drake.replace("continuous", "screw")).unwrap_err().to_string();
    assert!(screw.contains("type=\"screw\", expected fixed, revolute"), "{screw}");
}

#[test]
fn planes_are_grounds_and_nothing_else() {
    let plane = "<collision><origin xyz=\"0 0 -2\"/><geometry><plane normal=\"0 0 3\"/></geometry></collision>";
    let scene = read(&link("ground", 0.0, plane)).unwrap();
    let Shape::HalfSpace { normal, offset } = scene.bodies[0].def.shapes[0].shape else { panic!() };
    assert!((normal - Vec3::Z).length() < 1.0e-6 && (offset + 2.0).abs() < 1.0e-6);
    let moving = read(&arm("", plane)).unwrap();
    assert!(has(&moving.left_out, "arm: a plane that moves is left out"), "{:?}", moving.left_out);
}

#[test]
fn placeholder_inertias_of_whole_robots_are_taken_as_given() {
    let file = |name: &str| {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/robots").join(name);
        urdf::load(&path, &Options::default()).unwrap()
    };
    for (name, links) in [("free_flight_star6.urdf", 7), ("free_flight_star8.urdf", 9)] {
        let scene = file(name);
        assert_eq!((scene.bodies.len(), scene.joints.len()), (links, links - 1), "{name}");
        for (i, body) in scene.bodies.iter().enumerate() {
            let MassDef::Exact { mass, inertia, .. } = body.def.mass else { panic!("{name}") };
            let expected = if i == 0 { 3.2 } else { 0.25 };
            assert!((mass - expected).abs() < 1.0e-6, "{name}: {mass}");
            assert!(
                (inertia.eigen().0 - Vec3::splat(1.0)).length() < 1.0e-5,
                "{name}: {inertia:?}"
            );
        }
        assert!(scene.left_out.is_empty(), "{:?}", scene.left_out);
    }
    // Four legs of an upper and a lower link, whose feet are fixed to it.
    let quad = file("quad_restitution_gain.urdf");
    assert_eq!((quad.bodies.len(), quad.joints.len(), quad.frames.len()), (9, 8, 4));
    let whole: f32 = quad.bodies.iter().map(|b| mass(&quad, &b.name).0).sum();
    assert!((whole - (1.43 + 4.0 * (0.148 + 0.0307 + 0.0069))).abs() < 1.0e-5, "{whole}");
    let shapes = quad.bodies.iter().flat_map(|b| &b.def.shapes);
    assert!(
        shapes.clone().count() == 4
            && shapes.clone().all(|s| (s.material.restitution - 0.5).abs() < 1.0e-6)
    );
    assert!(quad.left_out.is_empty(), "{:?}", quad.left_out);
}
