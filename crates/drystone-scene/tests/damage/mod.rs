//! Files of XML that are damaged, and what must come of them.

use drystone_scene::{Scene, SceneError};

/// The next number of a simple generator.
fn next(state: &mut u64) -> usize {
    *state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
    usize::try_from(*state >> 33).unwrap()
}

/// Texts that are no XML with this outermost element, each with a part of its error.
pub(crate) fn broken_xml(tag: &str) -> Vec<(String, &'static str)> {
    let bombs = "<!DOCTYPE x [<!ENTITY a \"aaaa\"><!ENTITY b \"&a;&a;&a;&a;\">]>";
    vec![
        (String::new(), "broken XML"),
        ("hello".to_owned(), "broken XML"),
        (format!("<{tag}>"), "broken XML"),
        (format!("<{tag}><link name=\"a\"</{tag}>"), "broken XML"),
        ("<other/>".to_owned(), "the outermost element is <other>"),
        (format!("{bombs}<{tag}>&b;</{tag}>"), "DTD"),
        (format!("<{tag}>&lost;</{tag}>"), "broken XML"),
        ("<a>".repeat(100_000), "broken XML"),
    ]
}

/// Attributes whose values are exchanged.
fn values(text: &str) -> Vec<(usize, usize)> {
    let mut out = Vec::new();
    let mut at = 0;
    while let Some(begin) = text[at..].find("=\"") {
        let begin = at + begin + 2;
        let Some(length) = text[begin..].find('"') else { break };
        out.push((begin, begin + length));
        at = begin + length + 1;
    }
    out
}

/// Hands damaged texts on.
pub(crate) fn each(texts: &[String], count: usize, mut read: impl FnMut(&str)) {
    let odd = [
        "",
        "0",
        "-1",
        "1",
        "0 0 0",
        "1e30",
        "-1e30 0 1",
        "1e-30",
        "nan",
        "inf",
        "1 2 3 4 5 6 7",
        "x",
        "true",
        "false",
        "90",
        "1e9",
        "world",
        "0.5 0.5 0.5",
        "-0",
        "4294967295",
        "box",
        "mesh",
        "hinge",
        "slide",
        "ball",
        "free",
    ];
    let mut state = 11;
    for i in 0..count {
        let mut text = texts[next(&mut state) % texts.len()].clone();
        if i % 3 == 0 {
            let mut bytes = text.into_bytes();
            for _ in 0..1 + next(&mut state) % 3 {
                let at = next(&mut state) % bytes.len();
                bytes[at] ^= 1 << (next(&mut state) % 7);
            }
            let Ok(damaged) = String::from_utf8(bytes) else { continue };
            text = damaged;
        } else {
            for _ in 0..1 + next(&mut state) % 4 {
                let all = values(&text);
                let (begin, end) = all[next(&mut state) % all.len()];
                text.replace_range(begin..end, odd[next(&mut state) % odd.len()]);
            }
        }
        read(&text);
    }
}

/// Reads damaged texts, and steps what can be read; nothing of that may panic, and what is refused
/// is refused in one line.
pub(crate) fn never_panics(
    texts: &[String],
    count: usize,
    read: impl Fn(&str) -> Result<Scene, SceneError>,
) {
    let (mut good, mut bad) = (0, 0);
    each(texts, count, |text| match read(text) {
        Ok(scene) => {
            good += 1;
            let Ok(mut running) = scene.build() else { return };
            for _ in 0..2 {
                running.step(1.0 / 60.0).unwrap();
            }
        }
        Err(e) => {
            bad += 1;
            let line = e.to_string();
            assert!(!line.contains('\n') && line.len() < 1500, "{line}");
        }
    });
    assert!(good > count / 20 && bad > count / 20, "{good} read, {bad} refused");
}
