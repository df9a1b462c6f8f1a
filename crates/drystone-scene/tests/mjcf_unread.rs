//! Attributes of an MJCF file that are not read are named.
#![expect(clippy::unwrap_used, reason = "a test may fail anywhere")]

use std::path::Path;

use drystone_scene::{Scene, mjcf};

fn read(inside: &str) -> Scene {
    mjcf::from_text(&format!("<mujoco>{inside}</mujoco>"), Path::new("")).unwrap()
}

fn body(joint: &str, geom: &str) -> String {
    format!(
        "<worldbody><body name=\"b\"><joint {joint}/><geom size=\".1\" {geom}/></body></worldbody>"
    )
}

#[test]
fn physics_that_is_left_out_is_named_with_count_and_line() {
    let two = "<geom size=\".1\" margin=\".01\"/><geom size=\".1\" margin=\".02\"/>";
    let scene = read(&format!("\n<worldbody><body><freejoint/>\n{two}</body></worldbody>"));
    let note = "<geom margin>: not read (2 times, first in line 3, <geom>)";
    assert!(scene.left_out.iter().any(|n| n == note), "{:?}", scene.left_out);
    assert!(scene.notes.iter().any(|n| n == note));
    for (inside, part) in [
        (body("springdamper=\".1 1\"", ""), "<joint springdamper>"),
        (body("armature=\".1\"", ""), "armature"),
        (body("damping=\"-1\"", ""), "<joint damping>"),
        (body("stiffness=\"1 2\"", ""), "<joint stiffness>"),
        (body("actuatorfrcrange=\"-1 1\"", ""), "<joint actuatorfrcrange>"),
        (body("", "condim=\"6\""), "<geom condim>"),
        (body("", "solimp=\".5 .6 .1\""), "<geom solimp>"),
        (body("", "solref=\".1 1\""), "<geom solref>"),
        (body("", "priority=\"1\""), "<geom priority>"),
        (body("", "nonsense=\"1\""), "<geom nonsense>"),
        (format!("<option density=\"1000\"/>{}", body("", "")), "<option density>"),
        (body("type=\"free\" damping=\"1\"", ""), "1 free joints: their damping"),
        (
            format!("<default><joint frictionloss=\"1\"/></default>{}", body("type=\"free\"", "")),
            "1 free joints: their damping",
        ),
        (format!("<option cone=\"pyramidal\"/>{}", body("", "")), "<option cone>"),
        (format!("<option impratio=\"10\"/>{}", body("", "")), "<option impratio>"),
        (
            format!("<option actuatorgroupdisable=\"1\"/>{}", body("", "")),
            "<option actuatorgroupdisable>",
        ),
        (
            format!("<option><flag clampctrl=\"disable\"/></option>{}", body("", "")),
            "<flag clampctrl>",
        ),
        (format!("<option><flag damper=\"disable\"/></option>{}", body("", "")), "<flag damper>"),
        (
            format!("<option><flag override=\"enable\"/></option>{}", body("", "")),
            "<flag override>",
        ),
        (
            format!("<option><flag filterparent=\"disable\"/></option>{}", body("", "")),
            "<flag filterparent>",
        ),
        (format!("<compiler coordinate=\"global\"/>{}", body("", "")), "<compiler coordinate>"),
        (format!("<option wind=\"1 0 0\"/>{}", body("", "")), "<option wind>"),
        (format!("<default><geom gap=\".1\"/></default>{}", body("", "")), "<geom gap>"),
        (format!("<actuator><motor/></actuator>{}", body("", "")), "<actuator>"),
    ] {
        let scene = read(&inside);
        assert!(scene.left_out.iter().any(|n| n.contains(part)), "{inside}: {:?}", scene.left_out);
        assert!(scene.left_out.iter().all(|n| scene.notes.contains(n)), "{:?}", scene.notes);
    }
}

#[test]
fn what_is_read_and_what_has_no_effect_is_not_named() {
    let inside = format!(
        "<compiler angle=\"radian\"/><option gravity=\"0 0 -1\" iterations=\"50\"/><default><geom rgba=\"1 0 0 1\"/>\
         </default>{}<sensor/><keyframe/>",
        body(
            "name=\"j\" range=\"-1 1\" damping=\"1\" springdamper=\"0 0\"",
            "margin=\"0\" condim=\"3\" solref=\"0.02 1\" solimp=\"0.9 0.95 0.001 0.5 2\" material=\"m\""
        )
    );
    let scene = read(&inside);
    assert!(scene.left_out.is_empty(), "{:?}", scene.left_out);
}

#[test]
fn what_tunes_the_solver_is_named_and_is_no_physics() {
    let option = "<option iterations=\"50\" solver=\"PGS\" integrator=\"RK4\" noslip_iterations=\"3\">\
                  <flag warmstart=\"disable\" eulerdamp=\"disable\" multiccd=\"enable\"/></option>";
    let scene = read(&format!("{option}{}", body("", "")));
    assert!(scene.left_out.is_empty(), "{:?}", scene.left_out);
    for name in [
        "<option iterations>",
        "<option solver>",
        "<option integrator>",
        "<option noslip_iterations>",
        "<flag warmstart>",
        "<flag eulerdamp>",
        "<flag multiccd>",
    ] {
        let said = format!("{name}: not read (once, first in line 1, <");
        assert!(scene.notes.iter().any(|n| n.starts_with(&said)), "{name}: {:?}", scene.notes);
    }
    let neutral = "<option impratio=\"1\" integrator=\"Euler\" cone=\"elliptic\">\
                   <flag warmstart=\"enable\" clampctrl=\"enable\" actuation=\"disable\"/></option>";
    let scene = read(&format!("{neutral}{}", body("", "")));
    assert!(!scene.notes.iter().any(|n| n.contains("not read")), "{:?}", scene.notes);
}
