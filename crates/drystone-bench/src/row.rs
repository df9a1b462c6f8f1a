//! A row of the benchmark: the result of running a scene with an engine, once or several times.

use std::fmt;

use serde::de::{MapAccess, Visitor};
use serde::ser::SerializeMap;
use serde::{Deserialize, Deserializer, Serialize, Serializer};

/// Wall time of a step [ms]. The figure of a run is the mean over its timed steps.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct MsPerStep {
    /// The minimum over the runs.
    pub min: f64,
    /// The median over the runs.
    pub median: f64,
    /// The 99th percentile over the steps of a run; its median over the runs.
    pub p99: f64,
}

/// Mean times of the stages of a step [ms], in execution order.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Stages(pub Vec<(String, f64)>);

/// A row, with the fields in the order of the JSON file.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Row {
    /// The scene as the user wrote it.
    pub scene: String,
    /// The engine.
    pub engine: String,
    /// Its version.
    pub version: String,
    /// Number of threads, including the caller.
    pub threads: usize,
    /// SIMD level in use.
    pub simd: String,
    /// Number of steps.
    pub steps: u64,
    /// Number of bodies at the end, including static ones.
    pub bodies: usize,
    /// Wall time per step.
    pub ms_per_step: MsPerStep,
    /// Hash of the end state, 16 hex digits; comparable between runs of one engine only.
    pub hash: String,
    /// Maximum overlap at the steps where poses were copied [m].
    pub max_penetration: f64,
    /// Whether the scene still stands at the end; `None` for scenes that are not meant to stand.
    pub stands: Option<bool>,
    /// Maximum distance between two anchors of a joint [m]; `None` without joints.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub max_joint_error: Option<f64>,
    /// Number of bodies whose final state is not finite.
    #[serde(default)]
    pub lost: usize,
    /// Number of runs in this row.
    #[serde(default = "one")]
    pub runs: usize,
    /// Times of the stages, as medians over the runs. Among the peers only Box3D reports some, with
    /// its own clock and names.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub stages_ms: Option<Stages>,
}

const fn one() -> usize {
    1
}

/// Two final states of runs of one engine that should be equal.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Deviation {
    /// The hash of the first run.
    pub first: String,
    /// A different hash of another run.
    pub other: String,
}

impl Row {
    /// Merges several runs of the same engine on the same scene into one row; `None` if there are
    /// none. All fields except times are those of the first run. The result also reports a run with
    /// a different final state.
    #[must_use]
    pub fn merge(runs: &[Self]) -> Option<(Self, Option<Deviation>)> {
        let first = runs.first()?;
        let of = |figure: fn(&Self) -> f64| median(runs.iter().map(figure).collect());
        let min = runs.iter().map(|r| r.ms_per_step.min).fold(f64::INFINITY, f64::min);
        let ms_per_step =
            MsPerStep { min, median: of(|r| r.ms_per_step.median), p99: of(|r| r.ms_per_step.p99) };
        let deepest = runs.iter().map(|r| r.max_penetration).fold(0.0, f64::max);
        let deviation = runs.iter().find(|r| r.hash != first.hash);
        let deviation =
            deviation.map(|r| Deviation { first: first.hash.clone(), other: r.hash.clone() });
        let row = Self {
            ms_per_step,
            max_penetration: deepest,
            // The scene stands if it stood in every run.
            stands: first.stands.map(|_| runs.iter().all(|r| r.stands == Some(true))),
            runs: runs.iter().map(|r| r.runs).sum(),
            stages_ms: first.stages_ms.as_ref().map(|stages| stages.medians(runs)),
            ..first.clone()
        };
        Some((row, deviation))
    }
}

impl Stages {
    fn get(&self, name: &str) -> Option<f64> {
        self.0.iter().find(|(known, _)| known == name).map(|(_, ms)| *ms)
    }

    fn medians(&self, runs: &[Row]) -> Self {
        let of = |name: &str| {
            median(runs.iter().filter_map(|r| r.stages_ms.as_ref()?.get(name)).collect())
        };
        Self(self.0.iter().map(|(name, _)| (name.clone(), of(name))).collect())
    }
}

/// The middle value, or the mean of the two middle values; 0 if there are none.
fn median(mut values: Vec<f64>) -> f64 {
    values.sort_unstable_by(f64::total_cmp);
    let (low, high) = (values.len().saturating_sub(1) / 2, values.len() / 2);
    match (values.get(low), values.get(high)) {
        (Some(a), Some(b)) => 0.5 * (a + b),
        _ => 0.0,
    }
}

impl Serialize for Stages {
    fn serialize<S: Serializer>(&self, to: S) -> Result<S::Ok, S::Error> {
        let mut map = to.serialize_map(Some(self.0.len()))?;
        for (name, ms) in &self.0 {
            map.serialize_entry(name, ms)?;
        }
        map.end()
    }
}

impl<'de> Deserialize<'de> for Stages {
    fn deserialize<D: Deserializer<'de>>(from: D) -> Result<Self, D::Error> {
        struct InOrder;
        impl<'de> Visitor<'de> for InOrder {
            type Value = Stages;

            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("times by name")
            }

            fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<Stages, A::Error> {
                let mut stages = Vec::new();
                while let Some(entry) = map.next_entry()? {
                    stages.push(entry);
                }
                Ok(Stages(stages))
            }
        }
        from.deserialize_map(InOrder)
    }
}

#[cfg(test)]
pub(crate) mod tests {
    use super::{MsPerStep, Row, Stages};

    /// A row whose run took `ms` per step.
    pub(crate) fn row(engine: &str, threads: usize, ms: f64) -> Row {
        Row {
            scene: "stack".to_owned(),
            engine: engine.to_owned(),
            version: "1".to_owned(),
            threads,
            simd: "avx2".to_owned(),
            steps: 10,
            bodies: 11,
            ms_per_step: MsPerStep { min: ms, median: ms, p99: 2.0 * ms },
            hash: "00".to_owned(),
            max_penetration: 0.001,
            stands: Some(true),
            max_joint_error: None,
            lost: 0,
            runs: 1,
            stages_ms: Some(Stages(vec![("solver".to_owned(), ms), ("a".to_owned(), 0.5 * ms)])),
        }
    }

    #[test]
    fn merging_takes_medians_and_tells_of_deviations() {
        let mut runs = vec![row("self", 1, 3.0), row("self", 1, 1.0), row("self", 1, 2.0)];
        let (merged, deviation) = Row::merge(&runs).unwrap();
        assert_eq!(merged.ms_per_step, MsPerStep { min: 1.0, median: 2.0, p99: 4.0 });
        assert_eq!((merged.runs, merged.stands, deviation), (3, Some(true), None));
        let stages = vec![("solver".to_owned(), 2.0), ("a".to_owned(), 1.0)];
        assert_eq!(merged.stages_ms, Some(Stages(stages)));
        runs[1].stands = Some(false);
        runs[2].hash = "01".to_owned();
        runs[2].max_penetration = 0.5;
        let (merged, deviation) = Row::merge(&runs).unwrap();
        assert_eq!((merged.stands, merged.max_penetration), (Some(false), 0.5));
        assert_eq!(deviation.unwrap().other, "01");
        assert!(Row::merge(&[]).is_none());
    }

    #[test]
    fn a_row_is_read_back_from_json_with_its_stages_in_order() {
        let row = row("self", 2, 1.5);
        let text = serde_json::to_string(&row).unwrap();
        let start = r#"{"scene":"stack","engine":"self","version":"1","threads":2,"simd":"avx2","#;
        assert!(text.starts_with(start), "{text}");
        assert!(text.contains(r#""ms_per_step":{"min":1.5,"median":1.5,"p99":3.0}"#), "{text}");
        assert_eq!(serde_json::from_str::<Row>(&text).unwrap(), row);
    }
}
