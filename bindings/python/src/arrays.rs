//! Values from Python, checked; and arrays for Python: plain ones, and structured ones of columns.

use drystone::{Pose, Quat, Vec3, vec3};
use numpy::{Element, PyArray1, PyArrayDyn, PyArrayMethods as _, PyUntypedArrayMethods as _};
use pyo3::exceptions::PyTypeError;
use pyo3::intern;
use pyo3::prelude::*;
use pyo3::sync::PyOnceLock;
use pyo3::types::{PyDict, PyList, PyString, PyTuple};

use crate::errors::bad;

/// The module numpy. It is imported at first use, so that `import drystone` does not wait for it.
pub(crate) fn numpy(py: Python<'_>) -> PyResult<&Bound<'_, PyModule>> {
    static NUMPY: PyOnceLock<Py<PyModule>> = PyOnceLock::new();
    Ok(NUMPY.get_or_try_init(py, || py.import("numpy").map(Bound::unbind))?.bind(py))
}

/// A value as it stands in a message; long ones are cut off.
pub(crate) fn shown(value: &Bound<'_, PyAny>) -> String {
    let text = value.repr().map_or_else(|_| "?".to_owned(), |text| text.to_string());
    let mut short: String = text.chars().take(80).collect();
    if short.len() < text.len() {
        short.push('…');
    }
    short
}

/// A number as f32; the engine checks its range.
#[expect(clippy::cast_possible_truncation, reason = "the engine counts in f32")]
pub(crate) fn real(field: &str, value: &Bound<'_, PyAny>) -> PyResult<f32> {
    match value.extract::<f64>() {
        Ok(number) => Ok(number as f32),
        Err(_) => Err(wrong_type(field, value, "a number")),
    }
}

pub(crate) fn wrong_type(field: &str, value: &Bound<'_, PyAny>, allowed: &str) -> PyErr {
    let name = value.get_type().name().map_or_else(|_| "?".to_owned(), |name| name.to_string());
    PyTypeError::new_err(format!(
        "`{field}` must be {allowed} (got {} of type {name})",
        shown(value)
    ))
}

/// N numbers from any sequence or array.
pub(crate) fn reals<const N: usize>(field: &str, value: &Bound<'_, PyAny>) -> PyResult<[f32; N]> {
    let allowed = format!("{N} numbers");
    if value.is_instance_of::<PyString>() {
        return Err(wrong_type(field, value, &allowed));
    }
    let items = value.try_iter().map_err(|_| wrong_type(field, value, &allowed))?;
    let mut numbers = [0.0; N];
    let mut count = 0;
    for item in items {
        let Some(place) = numbers.get_mut(count) else {
            return Err(bad(field, &shown(value), &allowed));
        };
        *place = real(field, &item?)?;
        count += 1;
    }
    if count == N { Ok(numbers) } else { Err(bad(field, &shown(value), &allowed)) }
}

pub(crate) fn vector(field: &str, value: &Bound<'_, PyAny>) -> PyResult<Vec3> {
    reals::<3>(field, value).map(Vec3::from)
}

/// A rotation from `[w, x, y, z]`; the engine checks its length.
pub(crate) fn rotation(field: &str, value: &Bound<'_, PyAny>) -> PyResult<Quat> {
    reals::<4>(field, value).map(|[w, x, y, z]| Quat::new(x, y, z, w))
}

/// A pose from a position and an optional rotation.
pub(crate) fn pose(
    position: &Bound<'_, PyAny>,
    turned: Option<&Bound<'_, PyAny>>,
) -> PyResult<Pose> {
    let rotation = turned.map_or(Ok(Quat::IDENTITY), |value| rotation("rotation", value))?;
    Ok(Pose { position: vector("position", position)?, rotation })
}

/// The rotation as `[w, x, y, z]`.
pub(crate) const fn wxyz(q: Quat) -> [f32; 4] {
    [q.w, q.x, q.y, q.z]
}

/// A small array of f32.
pub(crate) fn small<'py, const N: usize>(
    py: Python<'py>,
    numbers: [f32; N],
) -> PyResult<Bound<'py, PyAny>> {
    array(py, numbers.to_vec(), &[N])
}

pub(crate) fn vec_out(py: Python<'_>, v: Vec3) -> PyResult<Bound<'_, PyAny>> {
    small(py, v.to_array())
}

/// An array of this shape, which takes over the numbers.
pub(crate) fn array<'py, T: Element>(
    py: Python<'py>,
    numbers: Vec<T>,
    shape: &[usize],
) -> PyResult<Bound<'py, PyAny>> {
    numpy(py)?;
    let flat = PyArray1::from_vec(py, numbers);
    if shape.len() == 1 {
        return Ok(flat.into_any());
    }
    flat.reshape(shape.to_vec()).map(Bound::into_any)
}

/// Numbers of an array-like of exactly this shape, in C order.
pub(crate) fn numbers(
    field: &str,
    value: &Bound<'_, PyAny>,
    shape: &[usize],
) -> PyResult<Vec<f32>> {
    let (numbers, found) = numbers_of(field, value)?;
    if found != shape {
        return Err(bad(
            field,
            &format!("shape {found:?}"),
            &format!("an array of shape {shape:?}"),
        ));
    }
    Ok(numbers)
}

/// Numbers of an array-like of rows of `columns`, in C order.
pub(crate) fn rows(field: &str, value: &Bound<'_, PyAny>, columns: usize) -> PyResult<Vec<f32>> {
    let (numbers, found) = numbers_of(field, value)?;
    if found.len() != 2 || found[1] != columns {
        let allowed = format!("an array of shape [n, {columns}]");
        return Err(bad(field, &format!("shape {found:?}"), &allowed));
    }
    Ok(numbers)
}

pub(crate) fn vectors(field: &str, value: &Bound<'_, PyAny>) -> PyResult<Vec<Vec3>> {
    let numbers = rows(field, value, 3)?;
    Ok(numbers.as_chunks::<3>().0.iter().map(|v| Vec3::from(*v)).collect())
}

#[expect(clippy::cast_possible_truncation, reason = "the engine counts in f32")]
fn numbers_of(field: &str, value: &Bound<'_, PyAny>) -> PyResult<(Vec<f32>, Vec<usize>)> {
    let any = plain(field, value, "fiu", "an array of numbers")?;
    if let Ok(exact) = any.cast::<PyArrayDyn<f32>>() {
        return Ok((exact.readonly().to_vec()?, exact.shape().to_vec()));
    }
    // Numpy warns of numbers beyond f32; the engine refuses infinity anyway.
    let wide = any.call_method1(intern!(value.py(), "astype"), ("float64",))?;
    let wide = wide.cast::<PyArrayDyn<f64>>()?;
    let numbers = wide.readonly().to_vec()?.into_iter().map(|x| x as f32).collect();
    Ok((numbers, wide.shape().to_vec()))
}

/// Whole numbers of an array-like with rows of three.
pub(crate) fn triangles(field: &str, value: &Bound<'_, PyAny>) -> PyResult<Vec<[u32; 3]>> {
    let any = plain(field, value, "iu", "an array of whole numbers")?;
    let shape: Vec<usize> = any.getattr("shape")?.extract()?;
    if shape.len() != 2 || shape[1] != 3 {
        return Err(bad(field, &format!("shape {shape:?}"), "an array of shape [n, 3]"));
    }
    let cast = any.call_method1("astype", ("int64",))?;
    let cast = cast.cast::<PyArrayDyn<i64>>()?.readonly();
    let mut triangles = Vec::with_capacity(shape[0]);
    for corners in cast.to_vec()?.as_chunks::<3>().0 {
        let [a, b, c] = corners.map(u32::try_from);
        let (Ok(a), Ok(b), Ok(c)) = (a, b, c) else {
            return Err(bad(field, &format!("{corners:?}"), "numbers of vertices"));
        };
        triangles.push([a, b, c]);
    }
    Ok(triangles)
}

/// A mask of `count` booleans, or the numbers of the chosen ones; `None`: all.
pub(crate) fn mask(
    field: &str,
    value: Option<&Bound<'_, PyAny>>,
    count: usize,
) -> PyResult<Vec<bool>> {
    let Some(value) = value else { return Ok(vec![true; count]) };
    let any = plain(field, value, "biu", "booleans, or whole numbers")?;
    let shape: Vec<usize> = any.getattr("shape")?.extract()?;
    let is_mask = any.getattr("dtype")?.getattr("kind")?.extract::<String>()? == "b";
    if shape.len() != 1 || (is_mask && shape[0] != count) {
        let allowed = format!("{count} booleans, or a list of numbers below {count}");
        return Err(bad(field, &format!("shape {shape:?}"), &allowed));
    }
    if is_mask {
        return Ok(any.cast::<PyArrayDyn<bool>>()?.readonly().to_vec()?);
    }
    let cast = any.call_method1("astype", ("int64",))?;
    let mut chosen = vec![false; count];
    for number in cast.cast::<PyArrayDyn<i64>>()?.readonly().to_vec()? {
        let place = usize::try_from(number).ok().and_then(|n| chosen.get_mut(n));
        let Some(place) = place else {
            return Err(bad(
                field,
                &number.to_string(),
                &format!("a number from 0 to {}", count - 1),
            ));
        };
        *place = true;
    }
    Ok(chosen)
}

/// The value as an array in C order whose type is of one of these kinds.
fn plain<'py>(
    field: &str,
    value: &Bound<'py, PyAny>,
    kinds: &str,
    allowed: &str,
) -> PyResult<Bound<'py, PyAny>> {
    let py = value.py();
    let made = numpy(py)?.call_method1(intern!(py, "asarray"), (value,));
    // A ragged list is a `ValueError` of numpy with a message about arrays.
    let any = made.map_err(|e| wrong_type(field, value, &format!("{allowed}: {e}")))?;
    let dtype = any.getattr(intern!(py, "dtype"))?;
    let kind: String = dtype.getattr(intern!(py, "kind"))?.extract()?;
    let size: usize = any.getattr(intern!(py, "size"))?.extract()?;
    if size > 0 && !kinds.contains(&kind) {
        return Err(PyTypeError::new_err(format!(
            "`{field}` must be {allowed} (got dtype {dtype})"
        )));
    }
    if size == 0 && kind != "b" {
        let whole = if kinds.contains('f') { "float32" } else { "int64" };
        return any.call_method1("astype", (whole,));
    }
    let flags = any.getattr(intern!(py, "flags"))?;
    let is = |name: &Bound<'py, PyString>| flags.getattr(name)?.is_truthy();
    if is(intern!(py, "c_contiguous"))? && is(intern!(py, "aligned"))? {
        return Ok(any);
    }
    any.call_method0(intern!(py, "copy"))
}

/// Columns of a structured array, each with one entry or one row for each record.
pub(crate) struct Table<'py> {
    py: Python<'py>,
    count: usize,
    columns: Vec<(&'static str, Bound<'py, PyAny>)>,
}

impl<'py> Table<'py> {
    pub(crate) const fn new(py: Python<'py>, count: usize) -> Self {
        Self { py, count, columns: Vec::new() }
    }

    pub(crate) fn column<T: Element>(
        mut self,
        name: &'static str,
        items: impl Iterator<Item = T>,
    ) -> PyResult<Self> {
        let made = array(self.py, items.collect(), &[self.count])?;
        self.columns.push((name, made));
        Ok(self)
    }

    pub(crate) fn vectors(
        mut self,
        name: &'static str,
        items: impl Iterator<Item = Vec3>,
    ) -> PyResult<Self> {
        let numbers: Vec<f32> = items.flat_map(Vec3::to_array).collect();
        self.columns.push((name, array(self.py, numbers, &[self.count, 3])?));
        Ok(self)
    }

    /// A column of words.
    pub(crate) fn words(
        mut self,
        name: &'static str,
        items: impl Iterator<Item = &'static str>,
        length: usize,
    ) -> PyResult<Self> {
        let list = PyList::new(self.py, items.collect::<Vec<_>>())?;
        let made = numpy(self.py)?.call_method1("array", (list, format!("U{length}")))?;
        self.columns.push((name, made));
        Ok(self)
    }

    /// The columns as one structured array.
    pub(crate) fn finish(self) -> PyResult<Bound<'py, PyAny>> {
        let py = self.py;
        let mut fields = Vec::with_capacity(self.columns.len());
        for (name, column) in &self.columns {
            let dtype = column.getattr(intern!(py, "dtype"))?;
            let shape = column.getattr(intern!(py, "shape"))?.cast_into::<PyTuple>()?;
            let rest = shape.get_slice(1, shape.len());
            fields.push((*name, dtype, rest));
        }
        let options = PyDict::new(py);
        options.set_item(intern!(py, "align"), true)?;
        let fields = (PyList::new(py, fields)?,);
        let dtype = numpy(py)?.call_method(intern!(py, "dtype"), fields, Some(&options))?;
        let records = numpy(py)?.call_method1(intern!(py, "empty"), (self.count, dtype))?;
        for (name, column) in self.columns {
            records.set_item(name, column)?;
        }
        Ok(records)
    }
}

/// Vector of a record that has none.
pub(crate) const NO_VECTOR: Vec3 = vec3(f32::NAN, f32::NAN, f32::NAN);
