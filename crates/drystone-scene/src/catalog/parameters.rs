//! Parameters of catalog scenes: their ranges, how a text `key=value,key=value` is read, and the
//! errors about it.

use core::fmt::{self, Display};

use drystone::geometry::{HullError, MeshError};

/// The range and the default of a parameter.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Range {
    /// A whole number.
    Whole {
        /// If nothing is said.
        default: u32,
        /// Least.
        min: u32,
        /// Greatest.
        max: u32,
    },
    /// Any number.
    Number {
        /// If nothing is said.
        default: f32,
        /// Least.
        min: f32,
        /// Greatest.
        max: f32,
    },
}

impl Display for Range {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Whole { min, max, .. } => write!(f, "a whole number from {min} to {max}"),
            Self::Number { min, max, .. } => write!(f, "a number from {min} to {max}"),
        }
    }
}

/// A parameter of a catalog scene.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Parameter {
    /// Its key.
    pub name: &'static str,
    /// Its range.
    pub range: Range,
    /// Its meaning, with its unit.
    pub meaning: &'static str,
}

impl Parameter {
    pub(super) const fn whole(
        name: &'static str,
        default: u32,
        (min, max): (u32, u32),
        meaning: &'static str,
    ) -> Self {
        Self { name, range: Range::Whole { default, min, max }, meaning }
    }

    pub(super) const fn number(
        name: &'static str,
        default: f32,
        (min, max): (f32, f32),
        meaning: &'static str,
    ) -> Self {
        Self { name, range: Range::Number { default, min, max }, meaning }
    }

    fn default_value(&self) -> Value {
        match self.range {
            Range::Whole { default, .. } => Value::Whole(default),
            Range::Number { default, .. } => Value::Number(default),
        }
    }

    fn read(&self, text: &str) -> Option<Value> {
        match self.range {
            Range::Whole { min, max, .. } => {
                text.parse().ok().filter(|v| (min..=max).contains(v)).map(Value::Whole)
            }
            Range::Number { min, max, .. } => {
                text.parse().ok().filter(|v| (min..=max).contains(v)).map(Value::Number)
            }
        }
    }
}

/// Why there is no scene of that name and parameters.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum CatalogError {
    /// No scene has this name.
    #[error("there is no scene '{name}'; {}", suggestion(nearest))]
    UnknownScene {
        /// The name given.
        name: String,
        /// The names closest to it.
        nearest: Vec<&'static str>,
    },
    /// A parameter was not given as `key=value`.
    #[error("scene {scene}: '{text}' is not of the form key=value; {}", known(keys))]
    NotAPair {
        /// The scene.
        scene: &'static str,
        /// The text that was given.
        text: String,
        /// The keys that the scene has.
        keys: Vec<&'static str>,
    },
    /// The scene has no parameter of this name.
    #[error("scene {scene} has no parameter '{key}'; {}", known(keys))]
    UnknownKey {
        /// The scene.
        scene: &'static str,
        /// The key given.
        key: String,
        /// The keys that the scene has.
        keys: Vec<&'static str>,
    },
    /// A parameter was given twice.
    #[error("scene {scene}: parameter '{key}' is given twice")]
    RepeatedKey {
        /// The scene.
        scene: &'static str,
        /// The key.
        key: &'static str,
    },
    /// A value is not a number, or out of range.
    #[error("scene {scene}: {key} is '{value}', expected {allowed}")]
    BadValue {
        /// The scene.
        scene: &'static str,
        /// The key.
        key: &'static str,
        /// The value given.
        value: String,
        /// The values that are allowed.
        allowed: Range,
    },
    /// Values that are allowed one by one, but not together.
    #[error("scene {scene}: {problem}")]
    Together {
        /// The scene.
        scene: &'static str,
        /// The problem, and the values that are allowed.
        problem: String,
    },
    /// The engine refused a hull of the scene.
    #[error("a hull of the scene: {0}")]
    Hull(#[from] HullError),
    /// The engine refused bonds of the scene.
    #[error("bonds of the scene: {0}")]
    Glue(#[from] drystone::DefError),
    /// The engine refused a mesh of the scene.
    #[error("a mesh of the scene: {0}")]
    Mesh(#[from] MeshError),
}

fn suggestion(nearest: &[&str]) -> String {
    if nearest.is_empty() {
        "the command `drystone scenes` lists them".to_owned()
    } else {
        format!("the nearest names are {}", nearest.join(", "))
    }
}

fn known(keys: &[&str]) -> String {
    if keys.is_empty() {
        "it has no parameters".to_owned()
    } else {
        format!("it has {}", keys.join(", "))
    }
}

#[derive(Clone, Copy, Debug)]
enum Value {
    Whole(u32),
    Number(f32),
}

/// A value for each parameter of a scene.
#[derive(Clone, Debug)]
pub struct Values {
    values: Vec<(&'static str, Value)>,
}

impl Values {
    /// From `key=value,key=value`; parameters that are left out have their defaults.
    pub(super) fn read(
        scene: &'static str,
        parameters: &'static [Parameter],
        text: Option<&str>,
    ) -> Result<Self, CatalogError> {
        let mut values: Vec<_> = parameters.iter().map(|p| (p.name, p.default_value())).collect();
        let keys = || parameters.iter().map(|p| p.name).collect();
        let mut given = vec![false; parameters.len()];
        for pair in text.into_iter().flat_map(|t| t.split(',')) {
            let Some((key, value)) = pair.split_once('=') else {
                return Err(CatalogError::NotAPair { scene, text: pair.to_owned(), keys: keys() });
            };
            let (key, value) = (key.trim(), value.trim());
            let Some(at) = parameters.iter().position(|p| p.name == key) else {
                return Err(CatalogError::UnknownKey { scene, key: key.to_owned(), keys: keys() });
            };
            let parameter = &parameters[at];
            if given[at] {
                return Err(CatalogError::RepeatedKey { scene, key: parameter.name });
            }
            given[at] = true;
            values[at].1 = parameter.read(value).ok_or_else(|| CatalogError::BadValue {
                scene,
                key: parameter.name,
                value: value.to_owned(),
                allowed: parameter.range,
            })?;
        }
        Ok(Self { values })
    }

    fn get(&self, name: &str) -> Option<Value> {
        let found = self.values.iter().find(|v| v.0 == name).map(|v| v.1);
        debug_assert!(found.is_some(), "parameter {name} stands in the scene's table");
        found
    }

    /// The whole number `name`; 0 if the scene has no such parameter.
    pub(super) fn whole(&self, name: &str) -> usize {
        match self.get(name) {
            Some(Value::Whole(v)) => v as usize,
            _ => 0,
        }
    }

    /// The number `name`; 0 if the scene has no such parameter.
    pub(super) fn number(&self, name: &str) -> f32 {
        match self.get(name) {
            Some(Value::Number(v)) => v,
            _ => 0.0,
        }
    }
}

/// Insertions, deletions and replacements that lead from `a` to `b`.
fn edit_distance(a: &str, b: &str) -> usize {
    let b: Vec<char> = b.chars().collect();
    let mut row: Vec<usize> = (0..=b.len()).collect();
    for (i, ca) in a.chars().enumerate() {
        let mut diagonal = row[0];
        row[0] = i + 1;
        for (j, cb) in b.iter().enumerate() {
            let replaced = diagonal + usize::from(ca != *cb);
            diagonal = row[j + 1];
            row[j + 1] = replaced.min(row[j] + 1).min(diagonal + 1);
        }
    }
    row[b.len()]
}

/// Up to three of `names` that `name` may have meant, nearest first: those that contain it or are
/// contained in it, and those with few letters wrong.
pub(super) fn nearest(name: &str, names: impl Iterator<Item = &'static str>) -> Vec<&'static str> {
    // Beyond this the edit distance of a long text costs more than it is worth.
    let name: String = name.to_lowercase().chars().take(64).collect();
    let mut ranked: Vec<(usize, &'static str)> = names
        .filter_map(|n| {
            let distance = edit_distance(&name, n);
            let inside = name.len() >= 3 && (n.contains(name.as_str()) || name.contains(n));
            let limit = 1 + name.chars().count() / 3;
            (inside || distance <= limit).then_some((distance, n))
        })
        .collect();
    ranked.sort_unstable();
    ranked.truncate(3);
    ranked.into_iter().map(|r| r.1).collect()
}
