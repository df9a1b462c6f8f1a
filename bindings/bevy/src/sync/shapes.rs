//! The shapes of colliders: definitions from components, additions, changes, removals.

use bevy_ecs::entity::Entity;
use drystone::events::{ContactReports, Senses};
use drystone::{BodyId, BodyKind, DefError, Material, Pose, Shape, ShapeDef, ShapeId, Vec3};

use super::Sync;
use crate::body::BodyLink;
use crate::convert::{same, to_vec};
use crate::scale::scaled;
use crate::scene::SurfaceDataItem;
use crate::world::GoneShape;

impl Sync<'_, '_, '_, '_, '_> {
    /// The definitions of a collider's shapes on a body of this kind, and the collider's scale.
    pub(super) fn shape_defs(
        &self,
        entity: Entity,
        host: Entity,
        kind: BodyKind,
    ) -> Result<(Vec<ShapeDef>, Vec3), String> {
        let Ok(data) = self.scene.colliders.get(entity) else {
            return Ok((Vec::new(), Vec3::ONE));
        };
        let place = self.scene.place_in(entity, host);
        // The body's own entity lies at the body's origin, whatever its transform is.
        let frame = if entity == host { Pose::IDENTITY } else { place.pose };
        let of_host = self.scene.surfaces.get(host).ok().filter(|_| host != entity);
        let surface = Surface::of(&data.surface, of_host.as_ref());
        let velocity = data.velocity.copied().unwrap_or_default();
        let senses = data.senses.copied().unwrap_or_default();
        let mut defs = Vec::with_capacity(data.collider.parts.len());
        for part in data.collider.parts.iter() {
            let (pose, shape) = scaled(part, place.scale)?;
            suits(kind, &shape)?;
            let def = ShapeDef {
                pose: frame.compose(&pose),
                density: surface.density,
                material: surface.material,
                filter: surface.filter,
                sensor: data.is_sensor,
                senses: Senses { statics: senses.statics, sensors: senses.sensors },
                surface_velocity: to_vec(velocity.linear),
                surface_spin: to_vec(velocity.angular),
                one_way: data.one_way.map(|front| to_vec(front.0)),
                reports: surface.reports,
                hooks: data.has_hooks,
                enabled: !data.is_disabled,
                user_data: entity.to_bits(),
                ..ShapeDef::new(shape)
            };
            def.validate().map_err(|e| e.to_string())?;
            defs.push(def);
        }
        Ok((defs, place.scale))
    }

    /// Brings the shapes of a collider on an existing body in line with its components.
    pub(super) fn update_collider(
        &mut self,
        entity: Entity,
        host: Entity,
        link: BodyLink,
        kind: BodyKind,
    ) {
        let (defs, scale) = match self.shape_defs(entity, host, kind) {
            Ok(made) => made,
            Err(text) => {
                self.remove_shapes(entity);
                self.fault(link.world, Some(entity), text);
                return;
            }
        };
        let made_of = self.scene.colliders.get(entity).ok().map(|data| data.collider.clone());
        let Ok(record) = self.records.colliders.get(entity) else { return };
        let known = record.made_of.as_ref();
        let is_same = made_of.as_ref().zip(known).is_some_and(|(now, (then, size))| {
            std::sync::Arc::ptr_eq(&now.parts, &then.parts) && *size == scale
        });
        let ids = record.shapes.clone();
        let Ok(mut physics) = self.records.worlds.get_mut(link.world) else { return };
        let world = &mut physics.world;
        let belongs =
            |id: &ShapeId| world.shape(*id).is_some_and(|shape| shape.body() == link.body);
        let mut errors = Vec::new();
        if ids.len() == defs.len() && ids.iter().all(belongs) {
            for (id, def) in ids.iter().zip(defs) {
                let form = if is_same { None } else { Some(def.shape.clone()) };
                change_shape(world, *id, &def, form, &mut errors);
            }
        } else {
            self.remove_shapes(entity);
            let Ok(mut physics) = self.records.worlds.get_mut(link.world) else { return };
            let added: Vec<_> =
                defs.into_iter().map(|def| physics.world.add_shape(link.body, def)).collect();
            let mut ids = Vec::new();
            for shape in added {
                match shape {
                    Ok(id) => ids.push(id),
                    Err(error) => errors.push(error),
                }
            }
            self.link_shapes(entity, host, link.world, ids);
        }
        if let Ok(mut record) = self.records.colliders.get_mut(entity) {
            record.made_of = made_of.map(|form| (form, scale));
        }
        for error in errors {
            self.fault(link.world, Some(entity), error.to_string());
        }
    }

    /// Records the shapes of a collider.
    pub(super) fn link_shapes(
        &mut self,
        entity: Entity,
        host: Entity,
        world: Entity,
        shapes: Vec<ShapeId>,
    ) {
        if let Ok(mut record) = self.records.colliders.get_mut(entity) {
            record.world = Some(world);
            record.owner = Some(host);
            record.shapes = shapes;
        }
    }

    /// Removes the shapes of a collider from its world.
    pub(super) fn remove_shapes(&mut self, entity: Entity) {
        let Ok(mut record) = self.records.colliders.get_mut(entity) else { return };
        let shapes = core::mem::take(&mut record.shapes);
        (record.made_of, record.owner) = (None, None);
        if let Some(world) = record.world.take() {
            for shape in shapes {
                self.remove_shape(world, shape);
            }
        }
    }

    /// Removes a shape, and notes its entities for the events of the next step.
    pub(super) fn remove_shape(&mut self, world: Entity, shape: ShapeId) {
        let Ok(mut physics) = self.records.worlds.get_mut(world) else { return };
        let Some(found) = physics.world.shape(shape) else { return };
        let (collider, body) = (found.user_data(), found.body());
        self.lost_shapes.push((world, body));
        let owner = physics.entity_of(body);
        if let (Some(collider), Some(body)) = (Entity::try_from_bits(collider), owner) {
            physics.gone.push(GoneShape { shape, collider, body });
        }
        physics.world.remove_shape(shape);
    }

    /// The shapes of a body, with their entities.
    pub(super) fn shapes_of(&self, world: Entity, body: BodyId) -> Vec<(ShapeId, Entity)> {
        let Ok(physics) = self.records.worlds.get(world) else { return Vec::new() };
        let Some(body) = physics.world.body(body) else { return Vec::new() };
        let entity = |id: ShapeId| {
            let data = physics.world.shape(id)?.user_data();
            Some((id, Entity::try_from_bits(data)?))
        };
        body.shapes().filter_map(entity).collect()
    }
}

/// The engine refuses the whole body otherwise.
fn suits(kind: BodyKind, shape: &Shape) -> Result<(), String> {
    let is_fine = match shape {
        Shape::HalfSpace { .. } => kind == BodyKind::Static,
        Shape::Mesh(_) => kind != BodyKind::Dynamic,
        _ => true,
    };
    let allowed = "`Collider` must be a shape that suits the body: a half-space needs a static \
                   body, a mesh a static or kinematic one; decompose a mesh into hulls for a \
                   dynamic body";
    if is_fine { Ok(()) } else { Err(format!("{allowed} (got a {})", shape.kind())) }
}

/// Changes what differs between a shape and its definition. `form`: its new geometry.
fn change_shape(
    world: &mut drystone::World,
    id: ShapeId,
    def: &ShapeDef,
    form: Option<Shape>,
    errors: &mut Vec<DefError>,
) {
    let Some(mut shape) = world.shape_mut(id) else { return };
    let mut note = |result: Result<(), DefError>| errors.extend(result.err());
    if let Some(form) = form {
        note(shape.set_geometry(form));
    }
    let rotation = def.pose.rotation;
    let now = shape.get().local_pose();
    // A definition's rotation is normalized when it is set; normalized again it is the same.
    if now.position != def.pose.position || now.rotation != rotation.normalized() {
        note(shape.set_local_pose(def.pose));
    }
    if !same(shape.get().density(), def.density) {
        note(shape.set_density(def.density));
    }
    if shape.get().is_sensor() != def.sensor {
        note(shape.set_sensor(def.sensor));
    }
    if shape.get().senses() != def.senses {
        shape.set_senses(def.senses);
    }
    if shape.get().material() != def.material {
        note(shape.set_material(def.material));
    }
    if shape.get().filter() != def.filter {
        shape.set_filter(def.filter);
    }
    if shape.get().surface_velocity() != def.surface_velocity {
        shape.set_surface_velocity(def.surface_velocity);
    }
    if shape.get().surface_spin() != def.surface_spin {
        shape.set_surface_spin(def.surface_spin);
    }
    if shape.get().one_way() != def.one_way.and_then(Vec3::try_normalize) {
        note(shape.set_one_way(def.one_way));
    }
    if shape.get().reports() != def.reports {
        note(shape.set_reports(def.reports));
    }
    if shape.get().has_hooks() != def.hooks {
        shape.set_hooks(def.hooks);
    }
    if shape.get().is_enabled() != def.enabled {
        shape.set_enabled(def.enabled);
    }
}

/// A collider's surface, from its own components or those of its body.
struct Surface {
    material: Material,
    filter: drystone::Filter,
    density: f32,
    reports: ContactReports,
}

impl Surface {
    fn of(own: &SurfaceDataItem<'_, '_>, host: Option<&SurfaceDataItem<'_, '_>>) -> Self {
        let friction = own.friction.or_else(|| host?.friction).copied().unwrap_or_default();
        let bounce = own.restitution.or_else(|| host?.restitution).copied().unwrap_or_default();
        let material = Material {
            friction: friction.coefficient,
            kinetic_friction: own.kinetic.or_else(|| host?.kinetic).map(|kinetic| kinetic.0),
            restitution: bounce.coefficient,
            rolling_resistance: own.rolling.or_else(|| host?.rolling).map_or(0.0, |r| r.0),
            spinning_resistance: own.spinning.or_else(|| host?.spinning).map_or(0.0, |r| r.0),
            friction_combine: friction.combine_rule.rule(),
            restitution_combine: bounce.combine_rule.rule(),
        };
        let layers = own.layers.or_else(|| host?.layers).copied().unwrap_or_default();
        let hit_speed = own.hit_speed.or_else(|| host?.hit_speed).map(|speed| speed.0);
        Self {
            material,
            filter: layers.filter(),
            density: own.density.or_else(|| host?.density).copied().unwrap_or_default().0,
            reports: ContactReports { hit_speed, ..ContactReports::default() },
        }
    }
}
