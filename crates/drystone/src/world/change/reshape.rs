//! Changes of a living shape: its filter, density, place on the body, and geometry.

use super::mass::{check_mass, principal_moments};
use crate::base::limits;
use crate::base::math::Vec3;
use crate::base::pose::Pose;
use crate::geometry::shape::Shape;
use crate::state::bodies::body::MassSource;
use crate::state::def::material::Filter;
use crate::state::def::reports::Senses;
use crate::state::def::{
    BodyKind, DefError, check_front, check_shape, position, shape_suits, unit, within,
};
use crate::state::shapes::ShapeRow;
use crate::step::broadphase::rank;
use crate::world::add::rolling_radius;
use crate::world::shape::ShapeMut;

impl ShapeMut<'_> {
    /// Sets the collision filter. Contacts that are no longer allowed end, and the touched bodies
    /// wake. Contacts with overlapping shapes that are now allowed start in the next step.
    pub fn set_filter(&mut self, filter: Filter) {
        if self.world.tables.shapes.at(self.row).filter == filter {
            return;
        }
        self.world.tables.shapes.at_mut(self.row).filter = filter;
        let body = self.body();
        self.world.end_forbidden(body);
        self.meet_anew();
        // Surface rules depend on layers.
        self.refresh_contacts();
    }

    /// Sets the objects that it detects as a sensor. Objects that it may no longer detect leave it.
    /// Objects that it also detects now enter it in the next step.
    pub fn set_senses(&mut self, senses: Senses) {
        let reports = self.get().reports();
        let packed = self.packed(&reports, senses);
        if self.world.tables.shapes.at(self.row).reports == packed {
            return;
        }
        let (row, body) = (self.row, self.body());
        self.world.end_contacts_of(body, Some(row));
        self.world.tables.shapes.set_reports(row, packed);
        self.meet_anew();
    }

    /// Sets whether [`ContactHooks`](crate::contact::ContactHooks) are called for its contacts.
    /// Touching bodies wake.
    pub fn set_hooks(&mut self, hooks: bool) {
        let shapes = &mut self.world.tables.shapes;
        let packed = shapes.at(self.row).reports.with_hooks(hooks);
        shapes.set_reports(self.row, packed);
        self.refresh_contacts();
        self.renew_contacts();
    }

    /// Makes it block only shapes that come from the direction `front` [frame of the shape, any
    /// length]; `None`: it blocks from all sides. Touching bodies wake, and their contacts are
    /// decided again.
    ///
    /// # Errors
    /// The direction is not finite, or has no length; then nothing is changed.
    pub fn set_one_way(&mut self, front: Option<Vec3>) -> Result<(), DefError> {
        let front = front.map(check_front).transpose()?;
        self.world.tables.shapes.set_one_way(self.row, front);
        self.renew_contacts();
        Ok(())
    }

    /// Makes it a sensor, or a solid shape. Its contacts or sensor overlaps end, and the new ones
    /// begin in the next step. A sensor has no mass: the mass of the body is updated, but a body
    /// that loses its last solid shape keeps its mass. A piece of a glued body loses its bonds. The
    /// body wakes.
    ///
    /// # Errors
    /// The body's mass would be out of range; then nothing is changed.
    pub fn set_sensor(&mut self, sensor: bool) -> Result<(), DefError> {
        let (row, body) = (self.row, self.body());
        if self.world.tables.shapes.at(row).sensor == sensor {
            return Ok(());
        }
        self.check_change(|shape| shape.sensor = sensor)?;
        // The old kind of the shape determines which events end.
        self.world.end_contacts_of(body, Some(row));
        self.world.tables.shapes.at_mut(row).sensor = sensor;
        let tables = &mut self.world.tables;
        if let Some(glued) = tables.breakage.glued.get_mut(&body) {
            glued.retain(|shape| shape != row);
        }
        self.meet_anew();
        self.follow();
        Ok(())
    }

    /// Sets its density [kg/m³], at least 0 (0: no mass). The center of mass and inertia of a
    /// dynamic body are updated, and its mass unless that was given. An exact mass stays unchanged.
    /// The body keeps its pose, and each point of it keeps its velocity. It wakes.
    ///
    /// # Errors
    /// The density or the body's mass is out of range, or the density of a breakable body is 0.
    /// Then nothing is changed.
    pub fn set_density(&mut self, density: f32) -> Result<(), DefError> {
        within("density", density, &limits::DENSITY)?;
        let body = self.body();
        let tables = &self.world.tables;
        if tables.breakage.breaks(body) && !tables.shapes.at(self.row).sensor && !(density > 0.0) {
            return Err(DefError::unsuitable(
                "density",
                density,
                "above 0, because each piece has a mass",
            ));
        }
        self.check_change(|shape| shape.density = density)?;
        self.world.tables.shapes.at_mut(self.row).density = density;
        self.follow();
        Ok(())
    }

    /// Sets its pose on its body [m, frame of the body's origin]. Contacts continue where the
    /// shapes still touch. The center of mass and inertia of a dynamic body are updated as with
    /// [`Self::set_density`]. The body and the bodies that the shape touches wake.
    ///
    /// # Errors
    /// A number is not finite or too large, the rotation is not a unit quaternion, the body's mass
    /// would be out of range, or bonds hold the shape. Then nothing is changed.
    pub fn set_local_pose(&mut self, pose: Pose) -> Result<(), DefError> {
        position("pose.position", pose.position)?;
        unit("pose.rotation", pose.rotation)?;
        self.check_bonds()?;
        let local = Pose { position: pose.position, rotation: pose.rotation.normalized() };
        self.check_change(|shape| shape.local = local)?;
        let center = self.world.tables.bodies.at(self.body()).inertia.local_center;
        let shape = self.world.tables.shapes.at_mut(self.row);
        shape.local = local;
        shape.centered = Pose { position: local.position - center, rotation: local.rotation };
        self.renew_contacts();
        self.follow();
        Ok(())
    }

    /// Replaces its geometry. Contacts continue where the shapes still touch, except if the old or
    /// the new geometry is a mesh or a half-space. The center of mass and inertia of a dynamic body
    /// are updated as with [`Self::set_density`], and its mass unless that was given. The body and
    /// the bodies that the shape touches wake.
    ///
    /// # Errors
    /// A number of the geometry or the body's mass would be out of range; the body cannot have such
    /// a shape; bonds hold the shape; or the body fractures and the geometry is not a box or hull.
    /// Then nothing is changed.
    pub fn set_geometry(&mut self, form: Shape) -> Result<(), DefError> {
        check_shape(&form)?;
        let body = self.body();
        let tables = &mut self.world.tables;
        shape_suits(tables.bodies.at(body).kind, &form)?;
        self.check_bonds()?;
        let tables = &mut self.world.tables;
        let can_fracture = matches!(form, Shape::Box { .. } | Shape::Hull(_));
        let fractures = tables.breakage.fractures.contains_key(&body);
        if fractures && !tables.shapes.at(self.row).sensor && !can_fracture {
            return Err(DefError::unsuitable(
                "shape",
                form.kind(),
                "a box or hull on a body that fractures",
            ));
        }
        let solid = tables.shapes.solid(&form);
        let (flat, rolling_radius) = (form.is_flat(), rolling_radius(&form));
        let reform = |shape: &mut ShapeRow| {
            (shape.shape, shape.solid) = (form, solid);
            (shape.flat, shape.rolling_radius) = (flat, rolling_radius);
        };
        let old_rank = rank(tables.shapes.at(self.row));
        let mut new = tables.shapes.at(self.row).clone();
        reform(&mut new);
        self.check_change(|shape| *shape = new.clone())?;
        if rank(&new) != old_rank {
            self.world.end_contacts_of(body, Some(self.row));
        }
        *self.world.tables.shapes.at_mut(self.row) = new;
        self.refresh_contacts();
        self.renew_contacts();
        self.follow();
        Ok(())
    }

    /// Disables (false) or enables (true) the shape. A disabled shape touches nothing, and no query
    /// finds it. It stays on its body and keeps its share of the mass. Its contacts end, and the
    /// touched bodies and its own body wake.
    pub fn set_enabled(&mut self, enabled: bool) {
        let (row, body) = (self.row, self.body());
        if self.world.tables.shapes.at(row).enabled == enabled {
            return;
        }
        if !enabled {
            self.world.end_contacts_of(body, Some(row));
            let tables = &mut self.world.tables;
            tables.bounds.remove(row, &tables.shapes);
            // Particles at rest on it check their contacts again.
            tables.bounds.fixed_changes += 1;
        }
        let tables = &mut self.world.tables;
        tables.shapes.at_mut(row).enabled = enabled;
        tables.bodies.at_mut(body).room = 0.0;
        if enabled {
            self.world.enter_bounds(row);
        }
        self.world.sets().wake(body);
    }

    fn body(&self) -> u32 {
        self.world.tables.shapes.at(self.row).body
    }

    /// Refuses a piece of a glued body. Its bonds lie at its faces, and would hold nothing after
    /// the change.
    fn check_bonds(&self) -> Result<(), DefError> {
        let glued = self.world.tables.breakage.glued.get(&self.body());
        let is_bound = glued.is_some_and(|glued| {
            let number = glued.pieces.iter().position(|shape| *shape == self.row);
            number.is_some_and(|n| glued.bonds.iter().any(|bond| bond.pieces.contains(&n)))
        });
        if !is_bound {
            return Ok(());
        }
        Err(DefError::unsuitable("shape", "a piece of a glued body", "a shape that no bond holds"))
    }

    /// Checks the mass that the body of the shape would have after a change.
    fn check_change(&mut self, change: impl FnOnce(&mut ShapeRow)) -> Result<(), DefError> {
        let body = self.body();
        let row = self.world.tables.shapes.at_mut(self.row);
        let was = row.clone();
        let was_solid = !was.sensor;
        change(row);
        let is_solid = !row.sensor;
        let made = self.world.mass_with(body, None);
        *self.world.tables.shapes.at_mut(self.row) = was;
        let owner = self.world.tables.bodies.at(body);
        match made {
            Some(mass) => check_mass(mass.mass, principal_moments(&mass).0),
            // A shape that becomes a sensor counts like a removed one.
            None if owner.kind == BodyKind::Dynamic
                && owner.inertia.source == MassSource::Shapes
                && was_solid
                && is_solid =>
            {
                let allowed = "above 0: add shapes with volume and density, or give an exact mass";
                Err(DefError::unsuitable("mass", 0.0, allowed))
            }
            None => Ok(()),
        }
    }

    /// Updates the mass, extent and boxes of the body, and wakes it.
    fn follow(&mut self) {
        let body = self.body();
        let before = self.world.tables.bodies.at(body).inertia.mass;
        self.world.refresh_mass(body);
        let more = self.world.tables.bodies.at(body).inertia.mass - before;
        if more != 0.0 {
            self.world.follow_weight(body, more);
        }
        let tables = &mut self.world.tables;
        if let Some(glued) = tables.breakage.glued.get_mut(&body) {
            // The stored loads belong to the old masses.
            glued.give.clear();
            glued.lack.clear();
        }
        self.world.sets().wake(body);
    }

    /// Makes the shape search for pairs in the next step.
    fn meet_anew(&mut self) {
        let tables = &mut self.world.tables;
        let shape = tables.shapes.at(self.row);
        if shape.is_in(tables.bodies.at(shape.body)) {
            let fat = shape.fat;
            tables.bounds.replace(self.row, fat, &mut tables.shapes);
        }
        // Particles at rest on it check their contacts again.
        tables.bounds.fixed_changes += 1;
    }

    /// Rebuilds the manifolds of its contacts in the next step. They keep their impulses, and the
    /// touched bodies wake.
    fn renew_contacts(&mut self) {
        let body = self.body();
        for row in self.contacts() {
            let tables = &mut self.world.tables;
            let (a, b) = (tables.contacts.at(row).shape_a, tables.contacts.at(row).shape_b);
            let (a, b) = (tables.shapes.at(a), tables.shapes.at(b));
            let recyclable = ShapeRow::are_recyclable(a, b);
            let contact = tables.contacts.at_mut(row);
            contact.recyclable = recyclable;
            let other = if contact.body_a == body { contact.body_b } else { contact.body_a };
            if !contact.is_part {
                tables.contacts.forget_manifolds(row, &tables.bodies.tracks);
            }
            self.world.sets().wake(other);
        }
        self.world.tables.bounds.fixed_changes += 1;
        self.world.sets().wake(body);
    }
}
