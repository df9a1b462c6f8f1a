//! Adding and removing bodies, shapes and joints.

use super::World;
use super::change::mass::{check_energy, check_mass, mass_of, principal_moments};
use crate::base::aabb::Aabb;
use crate::base::id::{BodyId, ShapeId};
use crate::base::math::Vec3;
use crate::base::pose::Pose;
use crate::base::quat::Quat;
use crate::geometry::mass::MassProperties;
use crate::geometry::shape::Shape;
use crate::state::bodies::NONE;
use crate::state::bodies::body::{Body, Forces, History, Inertia, Record, Sleep, Ties};
use crate::state::contacts::Contact;
use crate::state::def::reports::PackedReports;
use crate::state::def::{BodyDef, BodyKind, DefError, MassDef, ShapeDef, shape_suits};
use crate::state::shapes::{Here, ShapeRow};
use crate::state::tables::Tables;
use crate::step::context::StepContext;
use crate::step::partition;
use crate::step::reach::Need;

impl World {
    /// Adds a body with its shapes.
    ///
    /// # Errors
    /// The first field that is out of range; then nothing is added.
    pub fn add_body(&mut self, def: BodyDef) -> Result<BodyId, DefError> {
        def.validate()?;
        let mass = mass_of(&def)?;
        let (moments, principal) = principal_moments(&mass);
        if def.kind == BodyKind::Dynamic {
            check_mass(mass.mass, moments)?;
            check_energy(mass.mass, moments, [def.linear_velocity, def.angular_velocity])?;
        }
        let rotation = def.rotation.normalized();
        let body = Body {
            kind: def.kind,
            center: def.position + rotation.rotate(mass.center),
            rotation,
            // A static body has no velocity, even if its definition gives one.
            v: if def.kind == BodyKind::Static { Vec3::ZERO } else { def.linear_velocity },
            w: if def.kind == BodyKind::Static { Vec3::ZERO } else { def.angular_velocity },
            extent: 0.0,
            inertia: Inertia {
                local_center: mass.center,
                mass: mass.mass,
                moments,
                principal,
                source: def.mass.into(),
                locks: def.locks,
                hollow: true,
            },
            inner: f32::INFINITY,
            forces: Forces {
                gravity_scale: def.gravity_scale,
                linear_damping: def.linear_damping,
                angular_damping: def.angular_damping,
                step_force: Vec3::ZERO,
                step_torque: Vec3::ZERO,
                force: Vec3::ZERO,
                torque: Vec3::ZERO,
            },
            room: 0.0,
            ties: Ties::none(),
            record: Record {
                user_data: def.user_data,
                dragged: false,
                breaks: def.glue.is_some() || def.fracture.is_some(),
                is_piece: false,
                is_link: false,
                faulted: false,
                disabled: false,
            },
            sleep: Sleep::begin(def.sleep_speed.unwrap_or(-1.0)),
            history: History::begin(if def.kind == BodyKind::Dynamic { NONE } else { 0 }),
            can_sleep: def.can_sleep,
            out: false,
            flies: false,
            awake_row: NONE,
        };
        let still = body.v == Vec3::ZERO && body.w == Vec3::ZERO;
        let id = self.tables.bodies.insert(body);
        let row = id.index();
        if let MassDef::Exact { mass, center, inertia } = def.mass {
            let given = MassProperties { mass, center, inertia };
            self.tables.bodies.given.insert(row, given);
        }
        for shape in def.shapes {
            self.insert_shape(row, shape);
        }
        if let Some(glue) = &def.glue {
            self.glue_body(row, glue);
        }
        if let Some(fracture) = def.fracture {
            self.tables.breakage.fractures.insert(row, fracture);
        }
        match def.kind {
            BodyKind::Static => {}
            BodyKind::Kinematic => {
                if !still {
                    self.sets().wake(row);
                }
            }
            BodyKind::Dynamic => {
                let tables = &mut self.tables;
                tables.islands.create(row, &mut tables.bodies);
                if !def.asleep {
                    self.sets().wake(row);
                    // Adding a body awake causes no wake event.
                    self.pending.wake.retain(|b| *b != id);
                }
            }
        }
        if !def.enabled
            && let Some(mut body) = self.body_mut(id)
        {
            body.set_enabled(false);
            self.pending.wake.retain(|b| *b != id);
        }
        Ok(id)
    }

    /// Adds a shape to a body. The body's center of mass and inertia are updated, and its mass
    /// unless that was given. An exact mass stays unchanged. The body keeps its pose, and each
    /// point of it keeps its velocity.
    ///
    /// # Errors
    /// The body does not exist, or a field or the body's mass is out of range. Then nothing is
    /// added.
    pub fn add_shape(&mut self, body: BodyId, def: ShapeDef) -> Result<ShapeId, DefError> {
        def.validate()?;
        let Some(row) = self.tables.bodies.rows.row(body) else {
            return Err(DefError::missing(
                "body",
                format_args!("BodyId {}", body.index()),
                "a body of this world",
            ));
        };
        shape_suits(self.tables.bodies.at(row).kind, &def.shape)?;
        if let Some(mass) = self.mass_with(row, Some(&def)) {
            check_mass(mass.mass, principal_moments(&mass).0)?;
        }
        let id = self.insert_shape(row, def);
        self.refresh_mass(row);
        self.sets().wake(row);
        Ok(id)
    }

    fn insert_shape(&mut self, body: u32, def: ShapeDef) -> ShapeId {
        let solid = self.tables.shapes.solid(&def.shape);
        let local = Pose { position: def.pose.position, rotation: def.pose.rotation.normalized() };
        let rolling_radius = rolling_radius(&def.shape);
        let flat = def.shape.is_flat();
        let b = self.tables.bodies.at(body);
        let centered =
            Pose { position: local.position - b.inertia.local_center, rotation: local.rotation };
        let fixed = b.kind == BodyKind::Static;
        let id = self.tables.shapes.insert(ShapeRow {
            here: Here::Yes,
            is_asked: false,
            body,
            shape: def.shape,
            solid,
            local,
            centered,
            density: def.density,
            material: def.material,
            filter: def.filter,
            sensor: def.sensor,
            fixed,
            fat: Aabb::EMPTY,
            rolling_radius,
            surface_velocity: def.surface_velocity,
            surface_spin: def.surface_spin,
            flat,
            enabled: def.enabled,
            reports: PackedReports::new(&def.reports, def.senses).with_hooks(def.hooks),
            user_data: def.user_data,
        });
        let front = def.one_way.and_then(Vec3::try_normalize);
        self.tables.shapes.set_one_way(id.index(), front);
        let b = self.tables.bodies.at_mut(body);
        b.ties.shapes.push(id.index());
        self.tables.shapes.at(id.index()).widen(b);
        b.room = 0.0;
        self.enter_bounds(id.index());
        id
    }

    /// Inserts a shape's box into its tree, unless the shape is out of the world.
    pub(super) fn enter_bounds(&mut self, shape: u32) {
        let ctx = self.context();
        let tables = &mut self.tables;
        let row = tables.shapes.at(shape);
        if !row.is_in(tables.bodies.at(row.body)) {
            return;
        }
        let fixed = tables.shapes.at(shape).fixed;
        let fat = tree_box(tables, shape, &ctx);
        tables.bounds.insert(shape, fixed, fat, &mut tables.shapes);
    }

    /// A context for the boxes of objects that change between steps.
    pub(super) fn context(&self) -> StepContext {
        StepContext::new(&self.tables.config, 1.0 / 60.0, self.last_h, self.level.0)
    }

    /// Updates all boxes of a body to the current poses of its shapes.
    pub(super) fn refresh_bounds(&mut self, body: u32) {
        let ctx = self.context();
        let tables = &mut self.tables;
        tables.bodies.at_mut(body).room = 0.0;
        for i in 0..tables.bodies.at(body).ties.shapes.len() {
            let shape = tables.bodies.at(body).ties.shapes[i];
            if !tables.shapes.at(shape).is_in(tables.bodies.at(body)) {
                continue;
            }
            let fat = tree_box(tables, shape, &ctx);
            tables.bounds.replace(shape, fat, &mut tables.shapes);
        }
    }

    /// Ends all contacts of a shape, or of a body if `shape` is `None`, and wakes the touched
    /// bodies.
    pub(super) fn end_contacts_of(&mut self, body: u32, shape: Option<u32>) {
        self.end_contacts_where(body, |_, c| {
            shape.is_none_or(|s| c.shape_a == s || c.shape_b == s)
        });
    }

    /// Ends the contacts of a body for which `ends` is true, and wakes the touched bodies.
    pub(super) fn end_contacts_where(
        &mut self,
        body: u32,
        ends: impl Fn(&Tables, &Contact) -> bool,
    ) {
        let tables = &self.tables;
        let over = tables.contacts.of_body(tables.bodies.at(body)).filter_map(|(row, side)| {
            let c = tables.contacts.at(row);
            let other = if side == 0 { c.body_b } else { c.body_a };
            (!c.is_part && ends(tables, c)).then_some((row, other))
        });
        for (row, other) in over.collect::<Vec<_>>() {
            self.sets().wake(other);
            self.end_contact(row);
        }
    }

    /// Ends a contact, and reports the end if it touched.
    pub(super) fn end_contact(&mut self, row: u32) {
        let Tables { bodies, joints, contacts, islands, colors, shapes, .. } = &mut self.tables;
        let events = &mut self.pending;
        let ends = events.contact_end.len();
        let mut sets =
            crate::state::sets::Sets { bodies, joints, contacts, islands, colors, events };
        partition::end_contact(row, shapes, &mut sets);
        if self.pending.contact_end.len() > ends {
            self.cancel_last_end();
        }
    }

    /// Removes a body with its shapes and joints, detaches its particles, and wakes the bodies that
    /// it touched. False if there is no such body.
    pub fn remove_body(&mut self, id: BodyId) -> bool {
        let Some(row) = self.tables.bodies.rows.row(id) else { return false };
        self.free_links_of(row);
        for joint in self.tables.bodies.at(row).ties.joints.clone() {
            if let Some(joint) = self.tables.joints.rows.id_at(joint) {
                self.remove_joint(joint);
            }
        }
        self.detach_all(row);
        self.end_contacts_of(row, None);
        for shape in self.tables.bodies.at(row).ties.shapes.clone() {
            let tables = &mut self.tables;
            tables.bounds.remove(shape, &tables.shapes);
            tables.shapes.remove(shape);
        }
        self.sets().put_to_sleep(&[row]);
        self.pending.wake.retain(|b| *b != id);
        self.pending.sleep.retain(|b| *b != id);
        let tables = &mut self.tables;
        tables.bodies.given.remove(&row);
        tables.bodies.strangers.retain(|(a, b)| *a != row && *b != row);
        tables.shapes.between.retain(|(a, b), _| *a != row && *b != row);
        tables.breakage.forget(row, tables.bodies.at(row).record.is_piece);
        tables.islands.remove(row, &mut tables.bodies);
        tables.bodies.rows.remove(id);
        true
    }

    /// Removes a shape from its body. The mass is updated as in [`Self::add_shape`], but a body
    /// whose last solid shape is removed keeps its mass. False if there is no such shape.
    pub fn remove_shape(&mut self, id: ShapeId) -> bool {
        let Some(row) = self.tables.shapes.rows.row(id) else { return false };
        let body = self.tables.shapes.at(row).body;
        self.end_contacts_of(body, Some(row));
        self.sets().wake(body);
        let tables = &mut self.tables;
        tables.bounds.remove(row, &tables.shapes);
        tables.bodies.at_mut(body).ties.shapes.retain(|s| *s != row);
        tables.shapes.remove(row);
        if let Some(glued) = tables.breakage.glued.get_mut(&body) {
            glued.retain(|shape| shape != row);
        }
        self.refresh_mass(body);
        true
    }

    /// Moves the origin of a body to a pose: see [`super::BodyMut`].
    pub(super) fn put_body(&mut self, row: u32, position: Vec3, rotation: Quat) {
        let body = self.tables.bodies.at_mut(row);
        body.set_pose(&Pose { position, rotation });
        self.bring_back(row);
        let tables = &mut self.tables;
        let links: Vec<(u32, u32)> = tables.contacts.of_body(tables.bodies.at(row)).collect();
        let mut of_statics = Vec::new();
        for (contact, _) in links {
            tables.contacts.forget_gap(contact, &tables.bodies.tracks);
            let c = tables.contacts.at(contact);
            let is_static = |row: u32| tables.bodies.at(row).kind == BodyKind::Static;
            if !c.is_part && is_static(c.body_a) && is_static(c.body_b) {
                of_statics.push(contact);
            }
        }
        // Static sensors that overlap static shapes: a step updates these overlaps only when the
        // shapes are new.
        for contact in of_statics {
            self.end_contact(contact);
        }
        self.refresh_bounds(row);
    }
}

/// Radius for rolling and spinning resistance [m]; 0: does not roll.
pub(super) fn rolling_radius(shape: &Shape) -> f32 {
    match *shape {
        Shape::Sphere { radius }
        | Shape::Capsule { radius, .. }
        | Shape::Cylinder { radius, .. } => radius,
        Shape::Cone { radius_bottom, radius_top, .. } => radius_bottom.max(radius_top),
        _ => 0.0,
    }
}

/// The box of a shape in its tree at its current pose. A fixed shape needs no margin for motion.
fn tree_box(tables: &Tables, shape: u32, ctx: &StepContext) -> Aabb {
    let row = tables.shapes.at(shape);
    let body = tables.bodies.at(row.body);
    let need = Need::of_shape(&tables.shapes, shape, body, ctx);
    let fits = need.fits();
    if row.fixed { fits } else { need.with_room(&fits, body, ctx) }
}
