//! The place in a file of a thing that the engine refused when the scene was built.

use std::path::Path;

use drystone::DefError;
use serde_json::Value;

use super::place::Place;
use crate::build::BuildError;
use crate::error::SceneError;
use crate::read::{UTF8, text};

/// The engine's error about a scene that was read from the file at `path`. It has line and field if
/// the thing stands in the file itself, and the thing's name if a part brought it.
#[must_use]
pub fn refused(path: &Path, e: &BuildError) -> SceneError {
    let text = text(path, UTF8).unwrap_or_default();
    in_text(&text, e).in_file(path)
}

fn in_text(text: &str, e: &BuildError) -> SceneError {
    let value: Value = serde_json::from_str(text).unwrap_or_default();
    let Some((place, error)) = place(&value, e) else {
        return SceneError::new(Path::new(""), "", e, "");
    };
    let place = place.field(error.field());
    let (line, column) = place.find(text);
    let at = format!("line {line} column {column}: {place}");
    SceneError::new(Path::new(""), &at, format!("is {}", error.value()), error.allowed())
}

fn place<'a>(value: &Value, e: &'a BuildError) -> Option<(Place, &'a DefError)> {
    let root = Place::default();
    let count = |key: &str| value.get(key).and_then(Value::as_array).map_or(0, Vec::len);
    let called = |key: &str, name: &str| {
        let list = value.get(key).and_then(Value::as_array)?;
        let own = |i: usize, item: &Value| match item.get("name").and_then(Value::as_str) {
            Some(own) => own == name,
            None => name == format!("#{i}"),
        };
        list.iter().enumerate().find(|(i, item)| own(*i, item)).map(|(i, _)| i)
    };
    Some(match e {
        BuildError::Config(error) => (root.key("world"), error),
        BuildError::Body { name, error } => (root.nth("bodies", called("bodies", name)?), error),
        // Joints and couplings of the file come before those of its parts.
        BuildError::Joint { number, error, .. } if *number < count("joints") => {
            (root.nth("joints", *number), error)
        }
        BuildError::Coupling { number, error } if *number < count("couplings") => {
            (root.nth("couplings", *number), error)
        }
        BuildError::Strand { name, error } => {
            (root.nth("strands", called("strands", name)?), error)
        }
        BuildError::SurfaceRules(error) => (root.key("surface_rules"), error),
        _ => return None,
    })
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::in_text;
    use crate::own;

    #[test]
    fn what_the_engine_refuses_is_told_with_its_line() {
        let ball = "{\"mass\": {\"mass\": 1, \"inertia\": [1, 1, 1]}}";
        let table = [
            (format!("{{}},\n {ball}],\n\"joints\": []"), "line 1 column 28: bodies[0].mass: is 0"),
            (
                format!(
                    "{ball}, {ball}],\n\"joints\": [\n {{\"body_a\": 0, \"body_b\": 1, \"hinge\": {{}}}}],\n\
                     \"couplings\": [\n  {{\"joint_a\": 0, \"axis_a\": \"turn_x\", \"joint_b\": 0, \
                     \"axis_b\": \"turn_x\", \"ratio\": 0}}]"
                ),
                "line 5 column",
            ),
        ];
        for (inner, expected) in table {
            let text = format!("{{\"drystone\": 1, \"bodies\": [{inner}}}");
            let scene = own::from_text(&text, "x", Path::new("")).unwrap();
            let told = in_text(&text, &scene.build().unwrap_err()).to_string();
            assert!(told.starts_with(expected), "{told}");
        }
    }
}
