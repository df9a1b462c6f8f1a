//! Articulations of a world: adding, reading, driving and removing them.

use super::World;
use super::body::BodyMut;
use super::change::mass::principal_moments;
use crate::base::id::{ArticulationId, BodyId};
use crate::base::math::{Vec3, vec3};
use crate::base::sym3::Sym3;
use crate::geometry::mass::MassProperties;
use crate::reduced::linked::LinkMotion;
use crate::reduced::{Articulation, LinkDef, TreeDef, TreeError, TreeStepConfig};
use crate::state::articulations::ArticulationRow;
use crate::state::colors::Place;
use crate::state::def::{AxisLocks, BodyDef, BodyKind, DefError, MassDef, ShapeDef};
use crate::state::joints::{Joint, JointModel, Switch};
use crate::state::tables::Tables;

/// Part of an articulation's mass that a link has in contacts at least.
const MIN_PART: f64 = 1.0e-6;

/// Part of a link's largest moment of inertia that each of its moments is at least.
const MIN_MOMENT: f32 = 1.0e-5;

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
/// let link = || LinkDef::default().with_mass(1.0, [0.25, 0.0, 0.0], [0.02, 0.02, 0.02, 0.0, 0.0, 0.0]);
/// let hinge = TreeJoint::hinge([0.0, 0.0, 1.0]);
/// let upper = link().with_position([0.0, 1.0, 0.0]).with_joint(hinge.clone());
/// let lower = LinkDef { parent: Some(0), ..link() }.with_position([0.5, 0.0, 0.0]).with_joint(hinge);
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

/// An articulation of a world, read-only.
#[derive(Clone, Copy, Debug)]
pub struct ArticulationRef<'w> {
    tables: &'w Tables,
    row: &'w ArticulationRow,
    id: ArticulationId,
}

impl<'w> ArticulationRef<'w> {
    /// Its id.
    #[must_use]
    pub const fn id(&self) -> ArticulationId {
        self.id
    }

    /// The tree with its present state: coordinates, kinematics, Jacobians, dynamics.
    #[must_use]
    pub const fn model(&self) -> &'w Articulation {
        &self.row.model
    }

    /// Its definition, without shapes.
    #[must_use]
    pub const fn tree(&self) -> &'w TreeDef {
        &self.row.def
    }

    /// Coordinates \[m, rad, unit quaternions\].
    #[must_use]
    pub fn q(&self) -> &'w [f64] {
        self.row.model.q()
    }

    /// Velocities \[m/s, rad/s\].
    #[must_use]
    pub fn v(&self) -> &'w [f64] {
        self.row.model.v()
    }

    /// Number of links.
    #[must_use]
    pub const fn link_count(&self) -> usize {
        self.row.model.link_count()
    }

    /// The body of a link.
    #[must_use]
    pub fn body(&self, link: usize) -> Option<BodyId> {
        Some(self.tables.bodies.id(*self.row.bodies.get(link)?))
    }

    /// The bodies of all links, in their order.
    pub fn bodies(&self) -> impl Iterator<Item = BodyId> + use<'w> {
        let bodies = &self.tables.bodies;
        self.row.bodies.iter().map(|row| bodies.id(*row))
    }

    /// Whether it sleeps.
    #[must_use]
    pub fn is_asleep(&self) -> bool {
        self.row.bodies.iter().any(|row| self.tables.bodies.at(*row).sleeps())
    }
}

/// An articulation of a world for changes.
#[derive(Debug)]
pub struct ArticulationMut<'w> {
    world: &'w mut World,
    row: u32,
    id: ArticulationId,
}

impl ArticulationMut<'_> {
    /// The articulation, read-only.
    #[must_use]
    pub fn get(&self) -> ArticulationRef<'_> {
        self.world.articulation(self.id).expect("what is borrowed is not removed")
    }

    fn model(&mut self) -> &mut Articulation {
        let rows = &mut self.world.tables.articulations.rows;
        &mut rows.at_mut(self.row).expect("what is borrowed is not removed").model
    }

    /// Wakes it.
    pub fn wake(&mut self) {
        for body in self.world.bodies_of_articulation(self.row) {
            self.world.sets().wake(body);
        }
    }

    /// Sets coordinates \[m, rad, quaternions of any length\] and velocities \[m/s, rad/s\]. Moves
    /// its bodies and wakes them. An articulation that a fault took out of the world comes back.
    ///
    /// # Errors
    /// A wrong number of values, one that is not finite or beyond 1e12, or a quaternion of length
    /// 0. Nothing is changed then.
    pub fn set_state(&mut self, q: &[f64], v: &[f64]) -> Result<(), TreeError> {
        self.model().set_state(q, v)?;
        self.world.place_links(self.row);
        self.wake();
        Ok(())
    }

    /// Sets the generalized forces \[N m, N\] that act in all following steps; 0 at first. Wakes
    /// it if they change.
    ///
    /// # Errors
    /// A wrong number of values, or one that is not finite or beyond 1e12.
    pub fn set_forces(&mut self, tau: &[f64]) -> Result<(), TreeError> {
        let same = self.model().tau == tau;
        self.model().set_forces(tau)?;
        if !same {
            self.wake();
        }
        Ok(())
    }

    /// Sets the tuning of the step; numbers out of range count as the nearest in it.
    pub fn set_config(&mut self, config: TreeStepConfig) {
        self.model().set_config(config);
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
        let refused = |e: TreeError| e.into_def_error("tree");
        let mut model = Articulation::new(&def.tree, gravity).map_err(refused)?;
        let q = def.q.unwrap_or_else(|| model.q().to_vec());
        let v = def.v.unwrap_or_else(|| model.v().to_vec());
        model.set_state(&q, &v).map_err(|e| e.into_def_error("state"))?;
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
        let model = Articulation::new(&tree, gravity).map_err(|e| e.into_def_error("tree"))?;
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
            let suits = body.kind == def.kind && !body.record.is_link && !body.out;
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
        let id = self.tables.articulations.rows.insert(row);
        self.tables.articulations.find_links();
        for (link, parent) in parents.into_iter().enumerate() {
            let Some(parent) = parent else { continue };
            let (a, b) = (bodies[parent], bodies[link]);
            let moves = |row: u32| self.tables.bodies.at(row).is_dynamic();
            if moves(a) || moves(b) {
                self.insert_joint(link_joint(a, b));
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
        Some(ArticulationRef { tables, row, id })
    }

    /// An articulation for changes.
    pub fn articulation_mut(&mut self, id: ArticulationId) -> Option<ArticulationMut<'_>> {
        let row = self.tables.articulations.rows.row(id)?;
        Some(ArticulationMut { world: self, row, id })
    }

    /// All articulations, in the order of their slots.
    pub fn articulations(&self) -> impl Iterator<Item = ArticulationRef<'_>> {
        let tables = &self.tables;
        tables.articulations.rows.iter().map(|(id, row)| ArticulationRef { tables, row, id })
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
        self.tables.articulations.rows.remove(id);
        self.tables.articulations.find_links();
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
        if let Some((row, _)) = self.tables.articulations.of_body(body) {
            self.free_links(row);
        } else if let Some(row) = self.tables.articulations.on_body(body) {
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

/// Bodies for the links of a tree, without shapes.
fn link_bodies(def: &TreeDef, model: &Articulation) -> Vec<BodyDef> {
    let total: f64 = def.links.iter().map(|link| link.mass).sum();
    let least = (total * MIN_PART).max(1.0e-6);
    let body = |(index, link): (usize, &LinkDef)| {
        let motion = model.tree.link_motion(index, &model.work);
        let state = crate::step::solver::link_state(&motion);
        let moves = model.tree.moves(index);
        let kind = if moves { BodyKind::Dynamic } else { BodyKind::Static };
        let mass = MassDef::Exact {
            mass: narrow(link.mass.max(least)),
            center: vec3(narrow(link.center[0]), narrow(link.center[1]), narrow(link.center[2])),
            inertia: moments_of(link, least),
        };
        let mut body = BodyDef { kind, ..BodyDef::dynamic() };
        if moves {
            body.mass = mass;
            (body.linear_velocity, body.angular_velocity) = (state.v, state.w);
            let center =
                vec3(narrow(link.center[0]), narrow(link.center[1]), narrow(link.center[2]));
            body.position = state.center - state.rotation.rotate(center);
        } else {
            let (position, _) = model.pose(index).unwrap_or_default();
            body.position = vec3(narrow(position[0]), narrow(position[1]), narrow(position[2]));
        }
        body.rotation = state.rotation;
        body
    };
    def.links.iter().enumerate().map(body).collect()
}

/// Inertia of a link for contacts: no axis has much less than the others.
fn moments_of(link: &LinkDef, least: f64) -> Sym3 {
    let [xx, yy, zz, xy, xz, yz] = link.inertia.map(narrow);
    let inertia = Sym3 { xx, yy, zz, xy, xz, yz };
    let mass = MassProperties { mass: 1.0, center: Vec3::ZERO, inertia };
    let moments = principal_moments(&mass).0;
    // A link without inertia turns as a ball of 1 cm.
    let floor = (moments.max_element() * MIN_MOMENT).max(narrow(4.0e-5 * least));
    if moments.min_element() >= floor {
        return inertia;
    }
    Sym3 { xx: xx + floor, yy: yy + floor, zz: zz + floor, ..inertia }
}

#[expect(clippy::cast_possible_truncation, reason = "bodies have this precision")]
const fn narrow(x: f64) -> f32 {
    x as f32
}

fn link_joint(body_a: u32, body_b: u32) -> Joint {
    Joint {
        body_a,
        body_b,
        anchor_a: Vec3::ZERO,
        anchor_b: Vec3::ZERO,
        model: JointModel::Link,
        collide_connected: false,
        switch: Switch::On,
        user_data: 0,
        impulse: Vec3::ZERO,
        given: [Vec3::ZERO; 2],
        peak: [0.0; 2],
        damage: 0.0,
        is_direct: false,
        articulated: false,
        strength: None,
        place: Place::NOWHERE,
    }
}
