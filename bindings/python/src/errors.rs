//! Exceptions with attributes, and the conversion of the engine's errors into them.

use std::path::Path;

use drystone::DefErrorKind;
use drystone_scene::{BuildError, SceneError as ReadError};
use pyo3::create_exception;
use pyo3::exceptions::{PyRuntimeError, PyValueError};
use pyo3::prelude::*;

create_exception!(
    drystone,
    DefError,
    PyValueError,
    "A refused definition or call; nothing was changed.\n\nAttributes: `field`, `value`, `allowed`, \
     and `kind`: 'value', 'missing' (a stale id, or one of another world) or 'unsuitable'."
);
create_exception!(
    drystone,
    SceneError,
    PyValueError,
    "A scene that cannot be read, written or built.\n\nAttributes: `file`, `place`, `line` (None \
     where there is none), `problem`, `allowed`."
);
create_exception!(
    drystone,
    SnapshotError,
    PyValueError,
    "Bytes or a pickle that are no snapshot.\n\nAttribute: `problem`."
);

/// Adds attributes to an exception. An exception that takes none would be a defect of Python.
fn with_attributes(error: PyErr, attributes: &[(&str, &str)]) -> PyErr {
    Python::attach(|py| {
        let value = error.value(py);
        for (name, text) in attributes {
            value.setattr(*name, *text)?;
        }
        Ok(())
    })
    .map_or_else(|failed: PyErr| failed, |()| error)
}

/// The exception of a refused value.
pub(crate) fn refused(error: &drystone::DefError) -> PyErr {
    let kind = match error.kind() {
        DefErrorKind::Missing => "missing",
        DefErrorKind::Unsuitable => "unsuitable",
        _ => "value",
    };
    definition(&error.to_string(), error.field(), error.value(), error.allowed(), kind)
}

fn definition(text: &str, field: &str, value: &str, allowed: &str, kind: &str) -> PyErr {
    let attributes = [("field", field), ("value", value), ("allowed", allowed), ("kind", kind)];
    with_attributes(DefError::new_err(text.to_owned()), &attributes)
}

/// The exception of a value that this crate refuses, worded like the engine's.
pub(crate) fn bad(field: &str, value: &str, allowed: &str) -> PyErr {
    let text = format!("`{field}` must be {allowed} (got {value})");
    definition(&text, field, value, allowed, "value")
}

/// The exception of a value that is good by itself but does not suit its use.
pub(crate) fn unsuitable(field: &str, value: &str, allowed: &str) -> PyErr {
    let text = format!("`{field}` must be {allowed} (got {value})");
    definition(&text, field, value, allowed, "unsuitable")
}

/// The exception of an id that refers to nothing in the world.
pub(crate) fn missing(field: &str, value: &str, allowed: &str) -> PyErr {
    let text = format!("`{field}` must be {allowed} (got {value})");
    definition(&text, field, value, allowed, "missing")
}

/// The exception of a scene that cannot be read or written.
pub(crate) fn unreadable(error: &ReadError) -> PyErr {
    let (file, place) = (error.file(), error.place());
    scene(&error.to_string(), file, place, error.problem(), error.allowed())
}

/// The exception of a scene of `source` that the engine refuses.
pub(crate) fn unbuildable(source: &str, error: &BuildError) -> PyErr {
    let path = Path::new(source);
    let is_json = path.extension().is_some_and(|end| end.eq_ignore_ascii_case("json"));
    if is_json
        && matches!(drystone_scene::own::kind_of(path), Ok(drystone_scene::own::JsonKind::Own))
    {
        return unreadable(&drystone_scene::own::refused(path, error));
    }
    let problem = error.to_string();
    let text = if source.is_empty() { problem.clone() } else { format!("{source}: {problem}") };
    scene(&text, source, "", &problem, "")
}

/// The exception of a scene.
pub(crate) fn scene(text: &str, file: &str, place: &str, problem: &str, allowed: &str) -> PyErr {
    let attributes = [("file", file), ("place", place), ("problem", problem), ("allowed", allowed)];
    let error = with_attributes(SceneError::new_err(text.to_owned()), &attributes);
    Python::attach(|py| match error.value(py).setattr("line", line_of(place)) {
        Ok(()) => error,
        Err(failed) => failed,
    })
}

/// The number after the word `line` in a place such as `line 5 column 3: bodies[0]`.
fn line_of(place: &str) -> Option<u64> {
    let (_, rest) = place.split_once("line ")?;
    let end = rest.find(|c: char| !c.is_ascii_digit()).unwrap_or(rest.len());
    rest[..end].parse().ok()
}

/// The exception of bytes that are no snapshot.
pub(crate) fn no_snapshot(problem: &str) -> PyErr {
    let error = SnapshotError::new_err(problem.to_owned());
    with_attributes(error, &[("problem", problem)])
}

/// The exception of an object that another thread uses.
pub(crate) fn busy(what: &str) -> PyErr {
    PyRuntimeError::new_err(format!(
        "the {what} is in use by another thread; use one {what} in one thread at a time, or copies"
    ))
}

/// The exception of an object that a panic left half changed.
pub(crate) fn broken(what: &str) -> PyErr {
    PyRuntimeError::new_err(format!(
        "an earlier call on this {what} failed with a defect of the engine; it cannot be used any more"
    ))
}
