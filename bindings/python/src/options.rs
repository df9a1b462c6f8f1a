//! Keyword arguments: each is read by its name, and one that nobody reads is refused.

use std::cell::RefCell;

use drystone::{Quat, Vec3};
use pyo3::exceptions::PyTypeError;
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::arrays::{real, reals, rotation, shown, vector, wrong_type};
use crate::errors::bad;

/// Keyword arguments of a call, or a dict of a nested definition.
pub(crate) struct Options<'a, 'py> {
    /// The thing that they define, for messages.
    what: &'a str,
    given: Option<&'a Bound<'py, PyDict>>,
    known: RefCell<Vec<&'static str>>,
}

impl<'a, 'py> Options<'a, 'py> {
    pub(crate) const fn new(what: &'a str, given: Option<&'a Bound<'py, PyDict>>) -> Self {
        Self { what, given, known: RefCell::new(Vec::new()) }
    }

    /// The value of this name; `None` where it is not given or is None.
    pub(crate) fn get(&self, name: &'static str) -> PyResult<Option<Bound<'py, PyAny>>> {
        self.known.borrow_mut().push(name);
        let Some(given) = self.given else { return Ok(None) };
        Ok(given.get_item(name)?.filter(|value| !value.is_none()))
    }

    /// The same value, converted.
    pub(crate) fn with<T>(
        &self,
        name: &'static str,
        convert: impl FnOnce(&str, &Bound<'py, PyAny>) -> PyResult<T>,
    ) -> PyResult<Option<T>> {
        self.get(name)?.map(|value| convert(name, &value)).transpose()
    }

    pub(crate) fn real(&self, name: &'static str) -> PyResult<Option<f32>> {
        self.with(name, real)
    }

    pub(crate) fn vector(&self, name: &'static str) -> PyResult<Option<Vec3>> {
        self.with(name, vector)
    }

    pub(crate) fn rotation(&self, name: &'static str) -> PyResult<Option<Quat>> {
        self.with(name, rotation)
    }

    pub(crate) fn pair(&self, name: &'static str) -> PyResult<Option<[f32; 2]>> {
        self.with(name, reals::<2>)
    }

    pub(crate) fn flag(&self, name: &'static str) -> PyResult<Option<bool>> {
        self.with(name, |field, value| {
            value.extract().map_err(|_| wrong_type(field, value, "True or False"))
        })
    }

    pub(crate) fn word(&self, name: &'static str) -> PyResult<Option<String>> {
        self.with(name, |field, value| {
            value.extract().map_err(|_| wrong_type(field, value, "a string"))
        })
    }

    /// A whole number that fits `T`.
    pub(crate) fn whole<T: TryFrom<u64>>(&self, name: &'static str) -> PyResult<Option<T>> {
        self.with(name, whole)
    }

    /// A nested dict.
    pub(crate) fn dict(&self, name: &'static str) -> PyResult<Option<Bound<'py, PyDict>>> {
        self.with(name, dict)
    }

    /// Replaces the number where one is given.
    pub(crate) fn set_real(&self, name: &'static str, to: &mut f32) -> PyResult<()> {
        if let Some(value) = self.real(name)? {
            *to = value;
        }
        Ok(())
    }

    pub(crate) fn set_vector(&self, name: &'static str, to: &mut Vec3) -> PyResult<()> {
        if let Some(value) = self.vector(name)? {
            *to = value;
        }
        Ok(())
    }

    pub(crate) fn set_flag(&self, name: &'static str, to: &mut bool) -> PyResult<()> {
        if let Some(value) = self.flag(name)? {
            *to = value;
        }
        Ok(())
    }

    pub(crate) fn set_whole<T: TryFrom<u64>>(
        &self,
        name: &'static str,
        to: &mut T,
    ) -> PyResult<()> {
        if let Some(value) = self.whole(name)? {
            *to = value;
        }
        Ok(())
    }

    /// One of these words, as its place in the list.
    pub(crate) fn one_of(&self, name: &'static str, words: &[&str]) -> PyResult<Option<usize>> {
        self.with(name, |field, value| one_of(field, value, words))
    }

    /// Refuses names that were not read.
    pub(crate) fn finish(self) -> PyResult<()> {
        let Some(given) = self.given else { return Ok(()) };
        let known = self.known.into_inner();
        for key in given.keys() {
            let name: String = key.extract().map_err(|_| wrong_type(self.what, &key, "names"))?;
            if !known.contains(&name.as_str()) {
                return Err(PyTypeError::new_err(format!(
                    "{} has no option '{name}'; it has {}",
                    self.what,
                    known.join(", ")
                )));
            }
        }
        Ok(())
    }
}

/// The place of a word in a list.
pub(crate) fn one_of(field: &str, value: &Bound<'_, PyAny>, words: &[&str]) -> PyResult<usize> {
    let word: String = value.extract().map_err(|_| wrong_type(field, value, "a string"))?;
    let found = words.iter().position(|known| *known == word);
    found.ok_or_else(|| bad(field, &shown(value), &format!("one of {}", words.join(", "))))
}

/// A whole number that fits `T`.
pub(crate) fn whole<T: TryFrom<u64>>(field: &str, value: &Bound<'_, PyAny>) -> PyResult<T> {
    let allowed = "a whole number of at least 0";
    let number = value.extract::<u64>().map_err(|e| {
        if e.is_instance_of::<PyTypeError>(value.py()) {
            return wrong_type(field, value, allowed);
        }
        bad(field, &shown(value), allowed)
    })?;
    T::try_from(number).map_err(|_| bad(field, &shown(value), "a smaller number"))
}

pub(crate) fn dict<'py>(field: &str, value: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyDict>> {
    value.cast::<PyDict>().cloned().map_err(|_| wrong_type(field, value, "a dict"))
}
