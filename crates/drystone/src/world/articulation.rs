//! Articulations of a world: adding, reading, driving and removing them.

mod bodies;
mod view;

use self::bodies::link_bodies;
pub use self::view::{ArticulationMut, ArticulationRef};
use super::World;
use super::body::BodyMut;
use crate::base::id::{ArticulationId, BodyId};
use crate::base::math::Vec3;
use crate::reduced::linked::LinkMotion;
use crate::reduced::{Articulation, TreeDef, TreeError, TreeStepConfig};
use crate::state::articulations::ArticulationRow;
use crate::state::def::{AxisLocks, BodyKind, DefError, ShapeDef};
use crate::state::joints::{Joint, JointModel};
use crate::state::tables::Tables;

/// Definition of an articulation: a tree of links in reduced coordinates, and their shapes.
///
/// ```
/// use drystone::articulation::{ArticulationDef, LinkDef, TreeDef, TreeJoint};
/// use drystone::{BodyDef, ShapeDef, World};
///
/// # fn main() -> Result<(), drystone::DefError> {
/// let mut world = World::default();
/// world.add_body(BodyDef::fixed().with_shape(ShapeDef::box_half([5.0, 0.5, 5.0])))?;
/// // An arm of two links on a hinge 1 m above the floor, and another between them.
/// let inertia = [0.02, 0.02, 0.02, 0.0, 0.0, 0.0];
/// let link = |parent| LinkDef::on(parent).with_mass(1.0, [0.25, 0.0, 0.0], inertia);
/// let hinge = TreeJoint::hinge([0.0, 0.0, 1.0]);
/// let upper = link(None).with_position([0.0, 1.0, 0.0]).with_joint(hinge.clone());
/// let lower = link(Some(0)).with_position([0.5, 0.0, 0.0]).with_joint(hinge);
/// let tree = TreeDef { links: vec![upper, lower], ..TreeDef::default() };
/// let rod = || ShapeDef::box_half([0.25, 0.05, 0.05]).with_position([0.25, 0.0, 0.0]);
/// let arm = ArticulationDef::new(tree).with_shape(0, rod()).with_shape(1, rod());
/// let arm = world.add_articulation(arm)?;
/// for _ in 0..60 {
///     world.step(1.0 / 60.0);
/// }
/// let angles = world.articulation(arm).map(|arm| arm.q().to_vec());
/// assert!(angles.is_some_and(|q| q[0] != 0.0));
/// # Ok(())
/// # }
/// ```
#[derive(Clone, Debug, Default)]
pub struct ArticulationDef {
    /// Links and joints. A first link without a parent stands on the world, or floats.
    pub tree: TreeDef,
    /// Shapes, each with the index of its link. They have the frame of the link, and add no mass.
    pub shapes: Vec<(usize, ShapeDef)>,
    /// Coordinates at the start \[m, rad, quaternions\]; default `None`: the references.
    pub q: Option<Vec<f64>>,
    /// Velocities at the start \[m/s, rad/s\]; default `None`: at rest.
    pub v: Option<Vec<f64>>,
    /// Tuning of the step.
    pub config: TreeStepConfig,
    /// Whether it may fall asleep; default true.
    pub can_sleep: bool,
    /// A number for the user, of each of its bodies.
    pub user_data: u64,
}

impl ArticulationDef {
    /// An articulation of this tree, without shapes.
    #[must_use]
    pub fn new(tree: TreeDef) -> Self {
        Self { tree, can_sleep: true, ..Self::default() }
    }

    /// With one more shape on a link.
    #[must_use]
    pub fn with_shape(mut self, link: usize, shape: ShapeDef) -> Self {
        self.shapes.push((link, shape));
        self
    }

    /// With the coordinates \[m, rad, quaternions\] and velocities \[m/s, rad/s\] at the start.
    #[must_use]
    pub fn with_state(mut self, q: impl Into<Vec<f64>>, v: impl Into<Vec<f64>>) -> Self {
        (self.q, self.v) = (Some(q.into()), Some(v.into()));
        self
    }
}

impl World {
    /// Adds an articulation: a body for each link, which collides as any other body. A link and its
    /// parent do not collide. A link that nothing moves is a static body.
    ///
    /// # Errors
    /// The first field that is out of range, a shape on a link that does not exist, or a method of
    /// [`crate::method`] that solves no articulations. Then nothing is added.
    pub fn add_articulation(&mut self, def: ArticulationDef) -> Result<ArticulationId, DefError> {
        self.check_method()?;
        let gravity = self.tables.config.gravity.to_array().map(f64::from);
        let refused = |e: TreeError| def_error(e, "tree");
        let mut model = Articulation::new(&def.tree, gravity).map_err(refused)?;
        let q = def.q.unwrap_or_else(|| model.q().to_vec());
        let v = def.v.unwrap_or_else(|| model.v().to_vec());
        model.set_state(&q, &v).map_err(|e| def_error(e, "state"))?;
        model.set_config(def.config);
        let mut bodies = link_bodies(&def.tree, &model);
        for (link, shape) in def.shapes {
            let count = bodies.len();
            let Some(body) = bodies.get_mut(link) else {
                let allowed = format!("on a link from 0 to {}", count - 1);
                return Err(DefError::new("shapes", link, &allowed));
            };
            body.shapes.push(shape);
        }
        for (link, body) in bodies.iter_mut().enumerate() {
            (body.can_sleep, body.user_data) = (def.can_sleep, def.user_data);
            body.validate().map_err(|e| e.within(&format!("links[{link}]")))?;
        }
        let mut ids = Vec::new();
        for (link, body) in bodies.into_iter().enumerate() {
            match self.add_body(body) {
                Ok(id) => ids.push(id),
                Err(e) => {
                    for id in ids {
                        self.remove_body(id);
                    }
                    return Err(e.within(&format!("links[{link}]")));
                }
            }
        }
        Ok(self.insert_articulation(def.tree, model, &ids))
    }

    /// Makes bodies of this world the links of an articulation, in the order of the links. They
    /// keep their shapes and materials. Their masses become those of the tree, and their poses and
    /// velocities follow from its coordinates at the references. Joints that hold them should be
    /// removed before.
    ///
    /// # Errors
    /// The first field that is out of range; a body that does not exist, stands twice, is a link
    /// already, or is not dynamic (of a link that nothing moves: not static); another number of
    /// bodies than of links; a classic method. Then nothing is changed.
    pub fn articulate(
        &mut self,
        tree: TreeDef,
        bodies: &[BodyId],
    ) -> Result<ArticulationId, DefError> {
        self.check_method()?;
        let gravity = self.tables.config.gravity.to_array().map(f64::from);
        let model = Articulation::new(&tree, gravity).map_err(|e| def_error(e, "tree"))?;
        if bodies.len() != model.link_count() {
            let allowed = format!("{} bodies, one for each link", model.link_count());
            return Err(DefError::new("bodies", format!("{} bodies", bodies.len()), &allowed));
        }
        let masses = link_bodies(&tree, &model);
        for (link, (id, def)) in bodies.iter().zip(&masses).enumerate() {
            let field = format!("bodies[{link}]");
            let Some(row) = self.tables.bodies.rows.row(*id) else {
                let value = format_args!("BodyId {}", id.index());
                return Err(DefError::missing(&field, value, "a body of this world"));
            };
            let body = self.tables.bodies.at(row);
            let is_link = self.tables.articulations.of_body(row).is_some();
            let suits = body.kind == def.kind && !is_link && !body.out;
            if !suits || bodies[..link].contains(id) {
                let allowed = match def.kind {
                    BodyKind::Dynamic => "a dynamic body, enabled and in no other articulation",
                    _ => "a static body, because nothing moves its link",
                };
                return Err(DefError::unsuitable(&field, format_args!("{:?}", body.kind), allowed));
            }
            def.mass.validate().map_err(|e| e.within(&format!("tree.links[{link}]")))?;
        }
        for (id, def) in bodies.iter().zip(masses) {
            let Some(mut body) = self.body_mut(*id) else { continue };
            if def.kind == BodyKind::Dynamic {
                let still = Vec3::ZERO;
                body.set_velocities(still, still);
                body.set_locks(AxisLocks::default());
                body.set_mass(def.mass)?;
            }
        }
        Ok(self.insert_articulation(tree, model, bodies))
    }

    /// # Errors
    /// The method solves no articulations.
    fn check_method(&self) -> Result<(), DefError> {
        if self.tables.config.method.is_classic() {
            return Err(DefError::unsuitable(
                "articulation",
                "an articulation in a world with a classic method",
                "in a world with a default method",
            ));
        }
        Ok(())
    }

    fn insert_articulation(
        &mut self,
        def: TreeDef,
        model: Articulation,
        ids: &[BodyId],
    ) -> ArticulationId {
        let bodies: Vec<u32> = ids.iter().map(|id| id.index()).collect();
        for (link, row) in bodies.iter().enumerate() {
            let body = self.tables.bodies.at_mut(*row);
            body.record.is_link = model.tree.moves(link);
        }
        let parents: Vec<Option<usize>> = def.links.iter().map(|link| link.parent).collect();
        let row = ArticulationRow { model, def, bodies: bodies.clone() };
        let id = self.tables.articulations.insert(row);
        for (link, parent) in parents.into_iter().enumerate() {
            let Some(parent) = parent else { continue };
            let (a, b) = (bodies[parent], bodies[link]);
            let moves = |row: u32| self.tables.bodies.at(row).is_dynamic();
            if moves(a) || moves(b) {
                let joint = Joint::new(a, b, JointModel::Link);
                self.insert_joint(Joint { collide_connected: false, ..joint });
            }
        }
        self.tables.colors.bodies_changed = true;
        self.place_links(id.index());
        id
    }

    /// Places the bodies of links at the coordinates.
    fn place_links(&mut self, row: u32) {
        let Some(articulation) = self.tables.articulations.rows.at(row) else { return };
        let model = &articulation.model;
        let motions: Vec<(u32, LinkMotion)> = (0..)
            .zip(&articulation.bodies)
            .map(|(link, body)| (*body, model.tree.link_motion(link, &model.work)))
            .collect();
        for (row, motion) in motions {
            let state = crate::step::solver::link_state(&motion);
            let body = self.tables.bodies.at(row);
            let arm = state.rotation.rotate(body.inertia.local_center);
            self.put_body(row, state.center - arm, state.rotation);
            let body = self.tables.bodies.at_mut(row);
            (body.center, body.rotation) = (state.center, state.rotation);
            if body.is_dynamic() {
                (body.v, body.w, body.history.w_low) = (state.v, state.w, Vec3::ZERO);
            }
        }
    }

    /// An articulation.
    #[must_use]
    pub fn articulation(&self, id: ArticulationId) -> Option<ArticulationRef<'_>> {
        let tables = &self.tables;
        let row = tables.articulations.rows.row(id)?;
        let row = tables.articulations.rows.at(row)?;
        Some(ArticulationRef::new(tables, row, id))
    }

    /// An articulation for changes.
    pub fn articulation_mut(&mut self, id: ArticulationId) -> Option<ArticulationMut<'_>> {
        let row = self.tables.articulations.rows.row(id)?;
        Some(ArticulationMut::new(self, row, id))
    }

    /// All articulations, in the order of their slots.
    pub fn articulations(&self) -> impl Iterator<Item = ArticulationRef<'_>> {
        let tables = &self.tables;
        tables.articulations.rows.iter().map(|(id, row)| ArticulationRef::new(tables, row, id))
    }

    /// Removes an articulation with all its bodies. False if there is no such articulation.
    pub fn remove_articulation(&mut self, id: ArticulationId) -> bool {
        let Some(row) = self.tables.articulations.rows.row(id) else { return false };
        let bodies: Vec<BodyId> =
            self.bodies_of_articulation(row).map(|row| self.tables.bodies.id(row)).collect();
        self.free_links(row);
        for body in bodies {
            self.remove_body(body);
        }
        true
    }

    /// Clears the velocities of articulations that fell asleep.
    pub(super) fn stop_sleeping_articulations(&mut self) {
        let Tables { articulations, bodies, .. } = &mut self.tables;
        for row in articulations.rows.values_mut().iter_mut().flatten() {
            let sleeps = row.bodies.iter().any(|body| bodies.at(*body).sleeps());
            if sleeps && row.model.state.v.iter().any(|v| *v != 0.0) {
                row.model.state.v.fill(0.0);
                row.model.update();
            }
        }
    }

    /// Rows of the bodies of an articulation.
    pub(super) fn bodies_of_articulation(&self, row: u32) -> impl Iterator<Item = u32> + use<> {
        let row = self.tables.articulations.rows.at(row);
        row.map(|row| row.bodies.clone()).unwrap_or_default().into_iter()
    }

    /// Removes an articulation of which something else was removed. Its moving links stay as free
    /// bodies.
    pub(super) fn free_links(&mut self, row: u32) {
        let Some(id) = self.tables.articulations.rows.id_at(row) else { return };
        let bodies: Vec<u32> = self.bodies_of_articulation(row).collect();
        self.tables.articulations.remove(id);
        self.tables.colors.bodies_changed = true;
        for body in bodies {
            self.tables.bodies.at_mut(body).record.is_link = false;
            let joints = &self.tables.joints;
            let links = self.tables.bodies.at(body).ties.joints.iter();
            let links = links.filter(|row| matches!(joints.at(**row).model, JointModel::Link));
            let links: Vec<_> = links.filter_map(|row| joints.rows.id_at(*row)).collect();
            for joint in links {
                self.remove_joint(joint);
            }
            self.sets().wake(body);
        }
    }

    /// Frees the links of the articulation of a body.
    pub(super) fn free_links_of(&mut self, body: u32) {
        if let Some(row) = self.tables.articulations.of_body(body) {
            self.free_links(row);
        }
    }
}

impl BodyMut<'_> {
    /// # Errors
    /// The body is a link of an articulation, which the call does not suit.
    pub(super) fn check_free(&mut self, field: &str) -> Result<(), DefError> {
        if self.body().record.is_link {
            return Err(DefError::unsuitable(
                field,
                "a link of an articulation",
                "set for a body that is no link",
            ));
        }
        Ok(())
    }
}

/// The error of a tree as one of a definition, for a field inside `outer`.
fn def_error(e: TreeError, outer: &str) -> DefError {
    let [value, allowed] = e.told();
    DefError::new(e.place(), value, allowed).within(outer)
}
