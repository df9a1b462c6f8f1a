//! Values of existing bodies: settings, velocities, forces, sleep.

use bevy_ecs::change_detection::DetectChangesMut;
use bevy_ecs::entity::Entity;
use bevy_ecs::query::Changed;
use bevy_ecs::system::Query;
use drystone::DefError;

use super::Sync;
use crate::body::BodyLink;
use crate::convert::{same, same_vec, to_vec};
use crate::forces::PendingForces;

impl Sync<'_, '_, '_, '_, '_> {
    /// Sets what differs between a body and its components.
    pub(super) fn update_body(&mut self, entity: Entity) {
        self.set_mass(entity);
        let Some(link) = self.link(entity) else { return };
        let Ok(data) = self.scene.hosts.get(entity) else { return };
        let Ok(mut physics) = self.records.worlds.get_mut(link.world) else { return };
        let Some(mut body) = physics.world.body_mut(link.body) else { return };
        let scale = data.gravity_scale.copied().unwrap_or_default().0;
        if !same(body.get().gravity_scale(), scale) {
            body.set_gravity_scale(scale);
        }
        let linear = data.linear_damping.copied().unwrap_or_default().0;
        let angular = data.angular_damping.copied().unwrap_or_default().0;
        let [now_linear, now_angular] = body.get().damping();
        if !same(now_linear, linear) || !same(now_angular, angular) {
            body.set_damping(linear, angular);
        }
        let locks = data.locks.copied().unwrap_or_default().locks();
        if body.get().locks() != locks {
            body.set_locks(locks);
        }
        if body.get().can_sleep() == data.is_sleepless {
            body.set_can_sleep(!data.is_sleepless);
        }
        let mut error: Option<DefError> = None;
        let threshold = data.threshold.map(|threshold| threshold.0);
        if body.get().sleep_speed() != threshold {
            error = body.set_sleep_speed(threshold).err();
        }
        if body.get().is_enabled() == data.is_disabled {
            body.set_enabled(!data.is_disabled);
        }
        if let Some(error) = error {
            self.fault(link.world, Some(entity), error.to_string());
        }
        self.set_lasting(entity, link);
        self.set_fracture(entity, link);
    }

    /// Sets how a body breaks, where it differs.
    pub(super) fn set_fracture(&mut self, entity: Entity, link: BodyLink) {
        let Ok(data) = self.scene.hosts.get(entity) else { return };
        let how = data.fracture.map(|fracture| fracture.how());
        let Ok(mut physics) = self.records.worlds.get_mut(link.world) else { return };
        let Some(mut body) = physics.world.body_mut(link.body) else { return };
        if body.get().fracture() != how
            && let Err(error) = body.set_fracture(how)
        {
            self.fault(link.world, Some(entity), error.to_string());
        }
    }

    /// Puts bodies to sleep and wakes them, where the user inserted or removed
    /// [`Sleeping`](crate::Sleeping).
    pub(super) fn apply_sleep(&mut self, sleepers: &[Entity]) {
        let link = |entity: &Entity| self.link(*entity).map(|link| (link, *entity));
        let mut links: Vec<(BodyLink, Entity)> = sleepers.iter().filter_map(link).collect();
        links.sort_unstable_by_key(|(link, _)| (link.world, link.body));
        links.dedup();
        for (link, entity) in links {
            let Ok(data) = self.scene.hosts.get(entity) else { continue };
            let Ok(mut record) = self.records.bodies.get_mut(entity) else { continue };
            if record.asleep == data.is_asleep {
                continue;
            }
            record.asleep = data.is_asleep;
            let Ok(mut physics) = self.records.worlds.get_mut(link.world) else { continue };
            let Some(mut body) = physics.world.body_mut(link.body) else { continue };
            if data.is_asleep {
                body.sleep();
            } else {
                body.wake();
            }
        }
    }

    /// Sets the lasting force and torque of a body, where the components have changed.
    pub(super) fn set_lasting(&mut self, entity: Entity, link: BodyLink) {
        let Ok(data) = self.scene.hosts.get(entity) else { return };
        let Ok(mut record) = self.records.bodies.get_mut(entity) else { return };
        let force = data.force.copied().unwrap_or_default().0;
        let torque = data.torque.copied().unwrap_or_default().0;
        if same_vec(record.force, force) && same_vec(record.torque, torque) {
            return;
        }
        let Ok(mut physics) = self.records.worlds.get_mut(link.world) else { return };
        let Some(mut body) = physics.world.body_mut(link.body) else { return };
        body.set_lasting_force(to_vec(force));
        body.set_lasting_torque(to_vec(torque));
        (record.force, record.torque) = (force, torque);
    }

    /// Sets the velocities that the user wrote. Velocities that the plugin wrote have its bits.
    pub(super) fn set_velocities(&mut self) {
        let mut links: Vec<(BodyLink, Entity)> = Vec::new();
        for entity in core::mem::take(&mut self.state.pushed) {
            // New bodies have their velocities.
            if self.added.binary_search(&entity).is_err() {
                links.extend(self.link(entity).map(|link| (link, entity)));
            }
        }
        links.sort_unstable_by_key(|(link, _)| (link.world, link.body));
        for (link, entity) in links {
            self.write_velocity(link, entity);
        }
    }

    /// Gives a body the velocities of its components.
    pub(super) fn write_velocity(&mut self, link: BodyLink, entity: Entity) {
        let Ok(data) = self.scene.hosts.get(entity) else { return };
        let Ok(mut record) = self.records.bodies.get_mut(entity) else { return };
        let linear = data.linear.copied().unwrap_or_default().0;
        let angular = data.angular.copied().unwrap_or_default().0;
        (record.linear, record.angular) = (linear, angular);
        let Ok(mut physics) = self.records.worlds.get_mut(link.world) else { return };
        let Some(mut body) = physics.world.body_mut(link.body) else { return };
        // After a rollback the components differ from the record but not from the body.
        if body.get().linear_velocity() != to_vec(linear) {
            body.set_linear_velocity(to_vec(linear));
        }
        if body.get().angular_velocity() != to_vec(angular) {
            body.set_angular_velocity(to_vec(angular));
        }
    }

    /// Applies forces and impulses, in the order of bodies, and for each in that of the calls.
    pub(super) fn apply_forces(
        &mut self,
        changed: &mut Query<'_, '_, (Entity, &'static mut PendingForces), Changed<PendingForces>>,
    ) {
        let mut pushes = Vec::new();
        for (entity, mut pending) in changed.iter_mut() {
            if pending.pushes.is_empty() {
                continue;
            }
            let taken = core::mem::take(&mut pending.bypass_change_detection().pushes);
            if let Some(link) = self.link(entity) {
                pushes.push((link, taken));
            }
        }
        pushes.sort_by_key(|(link, _)| (link.world, link.body));
        for (link, taken) in pushes {
            let Ok(mut physics) = self.records.worlds.get_mut(link.world) else { continue };
            let Some(mut body) = physics.world.body_mut(link.body) else { continue };
            for push in taken {
                push.apply(&mut body);
            }
        }
    }
}
