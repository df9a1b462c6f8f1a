//! Articulations: trees of links in reduced coordinates. Their links are rows of the table of
//! bodies, whose poses and velocities follow from the coordinates.

use std::collections::BTreeMap;

#[cfg(feature = "serde")]
use serde::{Deserialize, Deserializer, Serialize, Serializer};

use super::bodies::Bodies;
use crate::base::id::ArticulationId;
use crate::base::slot_map::SlotMap;
use crate::reduced::{Articulation, TreeDef};
#[cfg(feature = "serde")]
use crate::reduced::{TreeError, TreeStepConfig};

/// An articulation of a world.
#[derive(Clone, Debug)]
pub(crate) struct ArticulationRow {
    pub(crate) model: Articulation,
    pub(crate) def: TreeDef,
    /// Row in the table of bodies of each link.
    pub(crate) bodies: Vec<u32>,
}

impl ArticulationRow {
    /// Moves it by `shift` [m, world].
    pub(crate) fn shift(&mut self, shift: [f64; 3]) {
        let Self { model, def, .. } = self;
        model.tree.shift(&mut model.state.q, shift);
        model.update();
        let loops = def.loops.iter_mut().filter(|closure| closure.link_b.is_none());
        let points = loops.map(|closure| &mut closure.point_b);
        let base = (!model.tree.floats()).then(|| &mut def.links[0].position);
        for point in points.chain(base) {
            for (x, by) in point.iter_mut().zip(shift) {
                *x += by;
            }
        }
    }
}

/// The saved part of a row; the rest is computed from it.
#[cfg(feature = "serde")]
#[derive(Serialize, Deserialize)]
struct Saved {
    def: TreeDef,
    bodies: Vec<u32>,
    q: Vec<f64>,
    v: Vec<f64>,
    tau: Vec<f64>,
    config: TreeStepConfig,
    recovered: f64,
}

#[cfg(feature = "serde")]
impl Serialize for ArticulationRow {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let model = &self.model;
        let saved = Saved {
            def: self.def.clone(),
            bodies: self.bodies.clone(),
            q: model.state.q.clone(),
            v: model.state.v.clone(),
            tau: model.tau.clone(),
            config: model.config,
            recovered: model.recovered,
        };
        saved.serialize(serializer)
    }
}

#[cfg(feature = "serde")]
impl<'de> Deserialize<'de> for ArticulationRow {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        Saved::deserialize(deserializer)?.restored().map_err(serde::de::Error::custom)
    }
}

#[cfg(feature = "serde")]
impl Saved {
    fn restored(self) -> Result<ArticulationRow, TreeError> {
        let Self { def, bodies, q, v, tau, config, recovered } = self;
        let mut model = Articulation::new(&def, [0.0; 3])?;
        model.restore(q, v, tau, config, recovered)?;
        Ok(ArticulationRow { model, def, bodies })
    }
}

/// All articulations.
#[derive(Debug, Default)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
pub(crate) struct Articulations {
    pub(crate) rows: SlotMap<ArticulationId, ArticulationRow>,
    /// Row of the articulation of each body that is a link.
    #[cfg_attr(feature = "serde", serde(skip))]
    links: BTreeMap<u32, u32>,
}

impl Clone for Articulations {
    fn clone(&self) -> Self {
        Self { rows: self.rows.clone(), links: self.links.clone() }
    }

    fn clone_from(&mut self, from: &Self) {
        self.rows.clone_from(&from.rows);
        self.links.clone_from(&from.links);
    }
}

impl Articulations {
    /// Row of the articulation of which a body is a link.
    pub(crate) fn of_body(&self, body: u32) -> Option<u32> {
        self.links.get(&body).copied()
    }

    pub(crate) fn insert(&mut self, row: ArticulationRow) -> ArticulationId {
        let bodies = row.bodies.clone();
        let id = self.rows.insert(row);
        self.links.extend(bodies.into_iter().map(|body| (body, id.index())));
        id
    }

    pub(crate) fn remove(&mut self, id: ArticulationId) {
        let removed = self.rows.remove(id);
        for body in removed.into_iter().flat_map(|row| row.bodies) {
            self.links.remove(&body);
        }
    }

    /// Finds the links among the bodies anew, for tables that were saved without them.
    pub(in crate::state) fn find_links(&mut self) {
        let bodies = self
            .rows
            .iter()
            .flat_map(|(id, row)| row.bodies.iter().map(move |body| (*body, id.index())));
        self.links = bodies.collect();
    }

    /// Whether the links are bodies of their own, and marked as links.
    pub(in crate::state) fn are_valid(&self, bodies: &Bodies) -> bool {
        let (mut moving, mut count) = (0, 0);
        for (_, row) in self.rows.iter() {
            if row.bodies.len() != row.model.link_count() {
                return false;
            }
            for (link, body) in row.bodies.iter().enumerate() {
                let Some(body) = bodies.rows.at(*body) else { return false };
                let moves = row.model.tree.moves(link);
                if body.record.is_link != moves || moves != body.is_dynamic() {
                    return false;
                }
                moving += usize::from(moves);
                count += 1;
            }
        }
        let marked = bodies.rows.iter().filter(|(_, body)| body.record.is_link).count();
        self.links.len() == count && marked == moving
    }
}
