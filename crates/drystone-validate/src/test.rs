//! The definition of a test, and the list of all tests.

use drystone_bench::EngineError;

use crate::family;
use crate::lab::Lab;
use crate::row::Rows;

/// Duration class of a test.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Cost {
    /// Up to about a second: part of every change's checks.
    Short,
    /// Longer.
    Long,
}

/// A test: one setup with a known answer, and its variants.
#[derive(Clone, Copy, Debug)]
pub struct Test {
    /// Its id in the list of tests, `A16`.
    pub id: &'static str,
    /// Its name, in a few words.
    pub name: &'static str,
    /// The varied parameters.
    pub varied: &'static str,
    /// The closed form, in words.
    pub closed_form: &'static str,
    /// Its duration class.
    pub cost: Cost,
    /// Whether its error should fall with the step, so that it is part of the sweep.
    pub sweeps: bool,
    /// Runs the test.
    pub run: fn(&Lab, &mut Rows) -> Result<(), EngineError>,
}

impl Test {
    /// A short test.
    pub(crate) const fn new(
        id: &'static str,
        name: &'static str,
        varied: &'static str,
        closed_form: &'static str,
        run: fn(&Lab, &mut Rows) -> Result<(), EngineError>,
    ) -> Self {
        Self { id, name, varied, closed_form, cost: Cost::Short, sweeps: false, run }
    }

    /// This test as a long one.
    pub(crate) const fn long(self) -> Self {
        Self { cost: Cost::Long, ..self }
    }

    /// This test as part of the sweep.
    pub(crate) const fn swept(self) -> Self {
        Self { sweeps: true, ..self }
    }
}

/// A family of tests: its topic and its tests.
#[derive(Clone, Copy, Debug)]
pub struct Family {
    /// The topic.
    pub title: &'static str,
    /// The tests.
    pub tests: &'static [Test],
}

/// All tests, by family.
pub const FAMILIES: &[Family] = &[
    Family { title: "Free flight", tests: family::flight::TESTS },
    Family { title: "Rotation", tests: family::rotation::TESTS },
    Family { title: "Friction", tests: family::friction::TESTS },
    Family { title: "Rolling", tests: family::rolling::TESTS },
    Family { title: "Impacts", tests: family::impact::TESTS },
    Family { title: "Stacks", tests: family::stacks::TESTS },
    Family { title: "Joints", tests: family::joints::TESTS },
    Family { title: "Mechanisms", tests: family::mechanisms::TESTS },
    Family { title: "Robots", tests: family::robots::TESTS },
    Family { title: "Geometry", tests: family::geometry::TESTS },
    Family { title: "Invariance and convergence", tests: family::invariance::TESTS },
];

/// All tests, in order.
pub fn all() -> impl Iterator<Item = &'static Test> {
    FAMILIES.iter().flat_map(|family| family.tests)
}

/// Tests of the list that require an unfinished part of the engine: id, name, missing part.
pub const WAITING: &[(&str, &str, &str)] =
    &[("A44b", "large worlds, 1e7 m", "positions of more than f32")];

#[cfg(test)]
mod tests {
    use super::{WAITING, all};

    #[test]
    fn every_test_has_an_id_of_its_own() {
        let mut ids: Vec<&str> = all().map(|test| test.id).collect();
        ids.extend(WAITING.iter().map(|(id, _, _)| *id));
        let count = ids.len();
        ids.sort_unstable();
        ids.dedup();
        assert_eq!(ids.len(), count);
    }
}
