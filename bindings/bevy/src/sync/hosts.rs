//! The bodies of entities: additions, changes of kind, removals.

use bevy_ecs::entity::Entity;
use drystone::math::Sym3;
use drystone::{BodyDef, BodyKind, MassDef, ShapeId};

use super::Sync;
use crate::body::{BodyLink, PhysicsBody};
use crate::convert::to_vec;
use crate::scene::HostDataItem;
use crate::world::GoneShape;

/// A collider and its body, in the order in which shapes are added.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Attached {
    host_key: (u64, u32),
    /// The collider on the entity of the body comes first.
    is_child: bool,
    key: (u64, u32),
    pub(super) host: Entity,
    pub(super) collider: Entity,
}

impl Sync<'_, '_, '_, '_, '_> {
    /// Removes a body. Its joints are looked at again, its shapes noted for the events of the next
    /// step.
    pub(super) fn remove_body(&mut self, world: Entity, body: drystone::BodyId) {
        let Ok(mut physics) = self.records.worlds.get_mut(world) else { return };
        let Some(found) = physics.world.body(body) else { return };
        let owner = Entity::try_from_bits(found.user_data());
        let joint = |id| physics.world.joint(id).map(|joint| joint.user_data());
        let joints: Vec<u64> = found.joints().filter_map(joint).collect();
        let shape = |id: ShapeId| Some((id, physics.world.shape(id)?.user_data()));
        let shapes: Vec<(ShapeId, u64)> = found.shapes().filter_map(shape).collect();
        physics.world.remove_body(body);
        for (shape, data) in shapes {
            if let (Some(collider), Some(body)) = (Entity::try_from_bits(data), owner) {
                physics.gone.push(GoneShape { shape, collider, body });
            }
        }
        self.pending.joints.extend(joints.into_iter().filter_map(Entity::try_from_bits));
    }

    /// Removes the bodies of entities that describe none any more, or one of another world. Lists
    /// the colliders of all bodies to look at, since they depend on the body. Grows while it runs.
    pub(super) fn unlink_stale(&mut self) {
        let mut stale = Vec::new();
        let mut next = 0;
        while let Some(entity) = self.dirty.get(next).copied() {
            next += 1;
            // A body that was refused is tried again with its new collider.
            if self.scene.colliders.contains(entity) {
                let owner = self.scene.owner(entity);
                if self.link(owner).is_none() {
                    self.mark(owner);
                }
            }
            if self.scene.kind(entity).is_some() {
                let scene = self.scene;
                scene.each_below(entity, |below| self.mark(below));
            }
            let Some(link) = self.link(entity) else { continue };
            for (_, collider) in self.shapes_of(link.world, link.body) {
                self.mark(collider);
            }
            let physics = self.records.worlds.get(link.world);
            let is_there = physics.is_ok_and(|p| p.entity_of(link.body) == Some(entity));
            let is_wanted =
                self.scene.kind(entity).is_some() && self.scene.world(entity) == link.world;
            if is_there && is_wanted {
                continue;
            }
            if is_there {
                stale.push((link.world, link.body));
            }
            if let Ok(mut record) = self.records.bodies.get_mut(entity) {
                record.link = None;
            }
        }
        // The order of removals decides which slots are free first.
        stale.sort_unstable();
        for (world, body) in stale {
            self.remove_body(world, body);
        }
    }

    /// Sorts the entities to look at: colliders by body, and bodies that exist already. Removes the
    /// shapes of colliders that are none any more, or belong to another body now.
    pub(super) fn sort_out(&mut self) -> (Vec<Attached>, Vec<Entity>) {
        let (mut attached, mut existing) = (Vec::new(), Vec::new());
        let mut dirty = self.dirty.clone();
        dirty.sort_unstable_by_key(|entity| self.scene.key(*entity));
        for entity in dirty {
            let owner = self.scene.colliders.contains(entity).then(|| self.scene.owner(entity));
            let record = self.records.colliders.get(entity);
            let (was, of) = record.map_or((None, None), |record| (record.owner, record.world));
            if was.is_some() {
                let link = owner.and_then(|owner| self.link(owner));
                if was != owner || link.map(|link| link.world) != of {
                    self.remove_shapes(entity);
                }
            }
            if let Some(host) = owner {
                attached.push(Attached {
                    host_key: self.scene.key(host),
                    is_child: host != entity,
                    key: self.scene.key(entity),
                    host,
                    collider: entity,
                });
            }
            if self.link(entity).is_some() {
                existing.push(entity);
            }
        }
        attached.sort_unstable();
        (attached, existing)
    }

    pub(super) fn link(&self, entity: Entity) -> Option<BodyLink> {
        self.records.bodies.get(entity).ok()?.link
    }

    /// Adds the bodies of entities that have none yet.
    pub(super) fn add_hosts(&mut self, attached: &[Attached]) {
        let is_new =
            |entity: &Entity| self.link(*entity).is_none() && self.scene.kind(*entity).is_some();
        let new = self.dirty.iter().copied().filter(is_new);
        let mut new: Vec<((u64, u32), Entity)> =
            new.map(|entity| (self.scene.key(entity), entity)).collect();
        new.sort_unstable();
        for (key, entity) in new {
            let from = attached.partition_point(|a| a.host_key < key);
            let own = attached[from..].iter().take_while(|a| a.host == entity);
            self.add_host(entity, &own.map(|a| a.collider).collect::<Vec<_>>());
        }
        self.added.sort_unstable();
    }

    fn add_host(&mut self, entity: Entity, colliders: &[Entity]) {
        let Some(kind) = self.scene.kind(entity) else { return };
        let world = self.scene.world(entity);
        if self.records.worlds.get(world).is_err() {
            let text = format!("`InWorld` must be an entity with a PhysicsWorld (got {world})");
            self.fault(world, Some(entity), text);
            return;
        }
        let mut shapes = Vec::new();
        let mut parts = Vec::new();
        for collider in colliders {
            match self.shape_defs(*collider, entity, kind) {
                Ok((defs, scale)) => {
                    parts.push((*collider, defs.len(), scale));
                    shapes.extend(defs);
                }
                Err(text) => self.fault(world, Some(*collider), text),
            }
        }
        let has_mass = shapes.iter().any(|shape| !shape.sensor && shape.density > 0.0);
        let Ok(data) = self.scene.hosts.get(entity) else { return };
        let pose = self.scene.place(entity).pose;
        let def = BodyDef {
            kind,
            position: pose.position,
            rotation: pose.rotation,
            linear_velocity: data.linear.map_or(drystone::Vec3::ZERO, |v| to_vec(v.0)),
            angular_velocity: data.angular.map_or(drystone::Vec3::ZERO, |w| to_vec(w.0)),
            mass: mass_def(&data, has_mass),
            gravity_scale: data.gravity_scale.copied().unwrap_or_default().0,
            linear_damping: data.linear_damping.copied().unwrap_or_default().0,
            angular_damping: data.angular_damping.copied().unwrap_or_default().0,
            locks: data.locks.copied().unwrap_or_default().locks(),
            can_sleep: !data.is_sleepless,
            sleep_speed: data.threshold.map(|threshold| threshold.0),
            asleep: data.is_asleep,
            enabled: !data.is_disabled,
            shapes,
            user_data: entity.to_bits(),
            ..BodyDef::default()
        };
        let (linear, angular) = (data.linear.copied(), data.angular.copied());
        let is_asleep = data.is_asleep;
        let Ok(mut physics) = self.records.worlds.get_mut(world) else { return };
        let body = match physics.world.add_body(def) {
            Ok(body) => body,
            Err(error) => {
                self.fault(world, Some(entity), error.to_string());
                return;
            }
        };
        let mut ids: Vec<ShapeId> =
            physics.world.body(body).map(|b| b.shapes().collect()).unwrap_or_default();
        self.added.push(entity);
        self.state.has_new_bodies = true;
        let local = self.scene.transform(entity);
        if let Ok(mut record) = self.records.bodies.get_mut(entity) {
            *record = PhysicsBody {
                link: Some(BodyLink { world, body }),
                local,
                linear: linear.unwrap_or_default().0,
                angular: angular.unwrap_or_default().0,
                asleep: is_asleep,
                round: record.round,
                before: local,
                ..PhysicsBody::default()
            };
        }
        for (collider, count, scale) in parts {
            let rest = ids.split_off(count.min(ids.len()));
            let own = core::mem::replace(&mut ids, rest);
            self.link_shapes(collider, entity, world, own);
            let form = self.scene.colliders.get(collider).ok().map(|c| c.collider.clone());
            if let Ok(mut record) = self.records.colliders.get_mut(collider) {
                record.made_of = form.map(|form| (form, scale));
            }
        }
        self.set_lasting(entity, BodyLink { world, body });
        self.set_fracture(entity, BodyLink { world, body });
    }

    /// Brings existing bodies and their colliders in line with their components.
    ///
    /// A kind that admits more shapes is set before the shapes change, one that admits fewer after.
    pub(super) fn update_hosts(&mut self, attached: &[Attached], existing: &[Entity]) {
        for entity in existing {
            self.set_kind(*entity, true);
        }
        let mut heavier = Vec::new();
        for Attached { host, collider, .. } in attached.iter().copied() {
            let (Some(link), Some(kind)) = (self.link(host), self.scene.kind(host)) else {
                continue;
            };
            // The bodies that were added in this round are complete.
            if self.added.binary_search(&host).is_err() {
                self.update_collider(collider, host, link, kind);
                heavier.push(host);
            }
        }
        self.update_masses(heavier);
        for entity in existing {
            self.set_kind(*entity, false);
            self.update_body(*entity);
        }
    }

    /// Sets the kind of a body, if it admits more shapes than the last one, or fewer, as `more`
    /// says.
    fn set_kind(&mut self, entity: Entity, more: bool) {
        let (Some(link), Some(kind)) = (self.link(entity), self.scene.kind(entity)) else { return };
        let Ok(data) = self.scene.hosts.get(entity) else { return };
        let Ok(mut physics) = self.records.worlds.get_mut(link.world) else { return };
        let has_mass = has_mass(&physics.world, link.body);
        let Some(mut body) = physics.world.body_mut(link.body) else { return };
        let rank = |kind: BodyKind| match kind {
            BodyKind::Static => 0,
            BodyKind::Kinematic => 1,
            BodyKind::Dynamic => 2,
        };
        let now = body.get().kind();
        if now == kind || (rank(kind) < rank(now)) != more {
            return;
        }
        let mass = mass_def(&data, has_mass);
        let mut result = Ok(());
        if kind == BodyKind::Dynamic && body.get().mass_def() != mass {
            result = body.set_mass(mass);
        }
        let result = result.and_then(|()| body.set_kind(kind));
        // Velocities of static bodies are 0, whatever their components say.
        if result.is_ok() && now == BodyKind::Static {
            body.set_linear_velocity(data.linear.map_or(drystone::Vec3::ZERO, |v| to_vec(v.0)));
            body.set_angular_velocity(data.angular.map_or(drystone::Vec3::ZERO, |w| to_vec(w.0)));
        }
        // A joint that was refused between two bodies that do not move may hold now.
        self.state.has_new_bodies |= result.is_ok();
        if let Err(error) = result {
            self.fault(link.world, Some(entity), error.to_string());
        }
    }

    /// Sets the masses of bodies whose colliders changed.
    fn update_masses(&mut self, mut hosts: Vec<Entity>) {
        for (world, body) in core::mem::take(&mut self.lost_shapes) {
            hosts.extend(self.records.worlds.get(world).ok().and_then(|p| p.entity_of(body)));
        }
        hosts.sort_unstable_by_key(|host| self.scene.key(*host));
        hosts.dedup();
        for host in hosts {
            self.set_mass(host);
        }
    }

    /// Sets the mass of a body, if it differs from that of its components.
    pub(super) fn set_mass(&mut self, host: Entity) {
        let Some(link) = self.link(host) else { return };
        let Ok(data) = self.scene.hosts.get(host) else { return };
        let Ok(mut physics) = self.records.worlds.get_mut(link.world) else { return };
        let mass = mass_def(&data, has_mass(&physics.world, link.body));
        let Some(mut body) = physics.world.body_mut(link.body) else { return };
        if body.get().mass_def() != mass
            && let Err(error) = body.set_mass(mass)
        {
            self.fault(link.world, Some(host), error.to_string());
        }
    }
}

/// Whether a body has a solid shape with a density.
fn has_mass(world: &drystone::World, body: drystone::BodyId) -> bool {
    let solid = |id: ShapeId| world.shape(id).is_some_and(|s| !s.is_sensor() && s.density() > 0.0);
    world.body(body).is_some_and(|body| body.shapes().any(solid))
}

/// The mass that the components of a body give. `has_mass`: whether a collider has a mass.
fn mass_def(data: &HostDataItem<'_, '_>, has_mass: bool) -> MassDef {
    if let Some(given) = data.properties {
        let (d, p) = (given.moments, given.products);
        let inertia = Sym3 { xx: d.x, yy: d.y, zz: d.z, xy: p.x, xz: p.y, yz: p.z };
        return MassDef::Exact { mass: given.mass, center: to_vec(given.center), inertia };
    }
    match data.mass {
        Some(mass) => MassDef::Mass(mass.0),
        None if has_mass => MassDef::FromShapes,
        None => MassDef::Mass(1.0),
    }
}
