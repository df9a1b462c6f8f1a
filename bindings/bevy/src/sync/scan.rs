//! The search for transforms and velocities that the user wrote.
//!
//! A change filter lists the candidates, among them all that the plugin wrote in the last step; the
//! bits decide. The search is a system of its own, because it reads records in their memory order.

use bevy_ecs::entity::Entity;
use bevy_ecs::query::{Changed, Or};
use bevy_ecs::system::{Query, ResMut};
use bevy_transform::components::Transform;

use super::SyncState;
use crate::body::{AngularVelocity, LinearVelocity, PhysicsBody};
use crate::convert::{same_place, same_vec};

type Velocities = (Entity, &'static LinearVelocity, &'static AngularVelocity, &'static PhysicsBody);
type VelocityChanges = Or<(Changed<LinearVelocity>, Changed<AngularVelocity>)>;

/// The system that lists what differs from the plugin's own writes.
pub(crate) fn scan(
    places: Query<'_, '_, (Entity, &Transform, &PhysicsBody), Changed<Transform>>,
    velocities: Query<'_, '_, Velocities, VelocityChanges>,
    mut state: ResMut<'_, SyncState>,
) {
    let state = &mut *state;
    state.placed.clear();
    for (entity, now, record) in &places {
        // A child collider has no body of its own, and no record of its last place.
        let is_same = same_place(now, &record.local) && same_vec(now.scale, record.local.scale);
        if record.link.is_none() || !is_same {
            state.placed.push(entity);
        }
    }
    state.pushed.clear();
    for (entity, linear, angular, record) in &velocities {
        if !same_vec(linear.0, record.linear) || !same_vec(angular.0, record.angular) {
            state.pushed.push(entity);
        }
    }
}
