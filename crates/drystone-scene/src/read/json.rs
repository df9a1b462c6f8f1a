//! A JSON value together with its place in the file, so that every wrong value can be named.

use std::path::Path;

use drystone::{Quat, Vec3};
use serde_json::Value;

use crate::error::SceneError;

/// A value and where it stands.
#[derive(Clone, Debug)]
pub(crate) struct At<'a> {
    value: &'a Value,
    place: String,
}

/// Texts with more values are refused: in memory each takes more than thirty bytes, and two in a
/// text.
const MOST_VALUES: usize = 20_000_000;

/// The value of a text.
///
/// # Errors
/// If it is no JSON, or too much of it.
pub(crate) fn parse(text: &[u8]) -> Result<Value, SceneError> {
    let fail =
        |problem: String, allowed: &str| Err(SceneError::new(Path::new(""), "", problem, allowed));
    let (mut values, mut is_string, mut is_escaped) = (1_usize, false, false);
    for byte in text {
        match byte {
            _ if is_escaped => is_escaped = false,
            b'\\' => is_escaped = is_string,
            b'"' => is_string = !is_string,
            b',' | b':' | b'[' | b'{' if !is_string => values += 1,
            _ => {}
        }
    }
    if values > MOST_VALUES {
        return fail(format!("it has more than {MOST_VALUES} values"), "fewer values in the JSON");
    }
    match serde_json::from_slice(text) {
        Ok(value) => Ok(value),
        Err(e) => fail(format!("broken JSON: {e}"), "JSON as RFC 8259 has it"),
    }
}

/// A word for a value in an error line.
fn describe(value: &Value) -> String {
    match value {
        Value::Array(a) => format!("is a list of {}", a.len()),
        Value::Object(_) => "is an object".to_owned(),
        other => format!("is {other}"),
    }
}

impl<'a> At<'a> {
    pub(crate) fn root(value: &'a Value) -> Self {
        Self { value, place: String::new() }
    }

    pub(crate) fn place(&self) -> &str {
        &self.place
    }

    /// An error about this value in words.
    pub(crate) fn error(&self, problem: impl core::fmt::Display, allowed: &str) -> SceneError {
        SceneError::new(Path::new(""), &self.place, problem, allowed)
    }

    /// An error with this value and the values that are allowed.
    pub(crate) fn wrong(&self, allowed: &str) -> SceneError {
        self.error(describe(self.value), allowed)
    }

    /// The names of the members of an object.
    pub(crate) fn keys(&self) -> impl Iterator<Item = &'a str> + use<'a> {
        self.value.as_object().into_iter().flatten().map(|(key, _)| key.as_str())
    }

    /// The member `key`, if it is there.
    pub(crate) fn get(&self, key: &str) -> Option<At<'a>> {
        let value = self.value.get(key)?;
        let place =
            if self.place.is_empty() { key.to_owned() } else { format!("{}.{key}", self.place) };
        Some(At { value, place })
    }

    /// The member `key`.
    pub(crate) fn need(&self, key: &str) -> Result<At<'a>, SceneError> {
        self.get(key).ok_or_else(|| self.error(format!("\"{key}\" is missing"), "a value there"))
    }

    /// The member of a path of keys, if all are there.
    pub(crate) fn dig(&self, keys: &[&str]) -> Option<At<'a>> {
        keys.iter().try_fold(self.clone(), |at, key| at.get(key))
    }

    /// The items of a list.
    pub(crate) fn items(&self) -> Result<Vec<At<'a>>, SceneError> {
        let list = self.value.as_array().ok_or_else(|| self.wrong("a list"))?;
        let item = |(i, value)| At { value, place: format!("{}[{i}]", self.place) };
        Ok(list.iter().enumerate().map(item).collect())
    }

    /// The items of the list `key`; none if it is missing.
    pub(crate) fn list(&self, key: &str) -> Result<Vec<At<'a>>, SceneError> {
        self.get(key).map_or_else(|| Ok(Vec::new()), |at| at.items())
    }

    /// The entry of the list `key` of this object that `reference` names, without a walk over the
    /// list.
    pub(crate) fn entry(&self, key: &str, reference: &At<'_>) -> Result<At<'a>, SceneError> {
        let list = self.value.get(key).and_then(Value::as_array);
        let i = reference.index(list.map_or(0, Vec::len), key)?;
        self.nth(key, i).ok_or_else(|| reference.wrong("an entry of that list"))
    }

    /// Entry `i` of the list `key` of this object.
    pub(crate) fn nth(&self, key: &str, i: usize) -> Option<At<'a>> {
        let value = self.value.get(key)?.get(i)?;
        let dot = if self.place.is_empty() { "" } else { "." };
        Some(At { value, place: format!("{}{dot}{key}[{i}]", self.place) })
    }

    /// The object, or an error.
    pub(crate) fn object(self) -> Result<Self, SceneError> {
        if self.value.is_object() { Ok(self) } else { Err(self.wrong("an object")) }
    }

    pub(crate) fn text(&self) -> Result<&'a str, SceneError> {
        self.value.as_str().ok_or_else(|| self.wrong("a text"))
    }

    pub(crate) fn bool(&self) -> Result<bool, SceneError> {
        self.value.as_bool().ok_or_else(|| self.wrong("true or false"))
    }

    /// A whole number of at least 0.
    pub(crate) fn size(&self) -> Result<usize, SceneError> {
        let allowed = "a whole number of at least 0";
        // A number such as 3.0 is a whole number too.
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "checked")]
        let whole = |v: f64| ((0.0..=9.0e15).contains(&v) && v.fract() <= 0.0).then_some(v as u64);
        let n = self.value.as_u64().or_else(|| self.value.as_f64().and_then(whole));
        n.and_then(|n| usize::try_from(n).ok()).ok_or_else(|| self.wrong(allowed))
    }

    /// A place in a list of `count` things called `what`.
    pub(crate) fn index(&self, count: usize, what: &str) -> Result<usize, SceneError> {
        let i = self.size()?;
        if i < count {
            return Ok(i);
        }
        let allowed = if count == 0 {
            format!("none: there are no {what}")
        } else {
            format!("0 to {} ({what})", count - 1)
        };
        Err(self.wrong(&allowed))
    }

    /// A finite number that is finite as f32 too.
    pub(crate) fn f32(&self) -> Result<f32, SceneError> {
        #[expect(clippy::cast_possible_truncation, reason = "checked to be finite")]
        let v = self.value.as_f64().map(|v| v as f32);
        v.filter(|v| v.is_finite()).ok_or_else(|| self.wrong("a finite number"))
    }

    /// A finite number of at least 0.
    pub(crate) fn at_least_zero(&self) -> Result<f32, SceneError> {
        let v = self.f32()?;
        if v >= 0.0 { Ok(v) } else { Err(self.wrong("a finite number of at least 0")) }
    }

    /// A finite number above 0.
    pub(crate) fn above_zero(&self) -> Result<f32, SceneError> {
        let v = self.f32()?;
        if v > 0.0 { Ok(v) } else { Err(self.wrong("a finite number above 0")) }
    }

    /// A list of exactly `N` finite numbers.
    pub(crate) fn numbers<const N: usize>(&self) -> Result<[f32; N], SceneError> {
        let items = self.items()?;
        if items.len() != N {
            return Err(self.wrong(&format!("a list of {N} numbers")));
        }
        let mut out = [0.0; N];
        for (o, item) in out.iter_mut().zip(&items) {
            *o = item.f32()?;
        }
        Ok(out)
    }

    pub(crate) fn vec3(&self) -> Result<Vec3, SceneError> {
        Ok(Vec3::from(self.numbers::<3>()?))
    }

    /// A unit quaternion `[x, y, z, w]`, normalized.
    pub(crate) fn quat(&self) -> Result<Quat, SceneError> {
        let q = self.numbers::<4>()?;
        let n: f32 = q.iter().map(|v| v * v).sum();
        if !(0.81..1.21).contains(&n) {
            let value = format!("is [{}, {}, {}, {}]", q[0], q[1], q[2], q[3]);
            return Err(self.error(value, "a unit quaternion"));
        }
        Ok(Quat::from(q).normalized())
    }

    /// [`Self::vec3`] of the member `key`, or `default`.
    pub(crate) fn vec3_or(&self, key: &str, default: Vec3) -> Result<Vec3, SceneError> {
        self.get(key).map_or(Ok(default), |at| at.vec3())
    }

    /// [`Self::bool`] of the member `key`, or false.
    pub(crate) fn flag(&self, key: &str) -> Result<bool, SceneError> {
        self.get(key).map_or(Ok(false), |at| at.bool())
    }
}
