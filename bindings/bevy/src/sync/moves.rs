//! Transforms that the user wrote: teleports of dynamic bodies, targets of kinematic ones, moves of
//! static ones, and scales.
//!
//! The plugin compares a transform with the bits that it read or wrote last. There is no tolerance,
//! and a change tick alone means nothing.

use bevy_ecs::entity::Entity;
use bevy_ecs::query::{Changed, With};
use bevy_ecs::system::Query;
use bevy_transform::components::Transform;
use drystone::{BodyKind, Pose};

use super::Sync;
use crate::body::BodyLink;
use crate::convert::{same_place, same_vec};
use crate::scene::BodiesBelow;

impl Sync<'_, '_, '_, '_, '_> {
    /// Lists the bodies and colliders whose transform, or that of an ancestor, has changed.
    pub(super) fn collect_places(
        &mut self,
        trees: &Query<'_, '_, Entity, (With<BodiesBelow>, Changed<Transform>)>,
    ) {
        for entity in core::mem::take(&mut self.state.placed) {
            let Ok(record) = self.records.bodies.get(entity) else { continue };
            let has_link = record.link.is_some();
            let is_rescaled = !same_vec(record.local.scale, self.scene.transform(entity).scale);
            if has_link {
                self.moved.push((entity, false));
            }
            if !has_link || is_rescaled {
                self.mark(entity);
            }
        }
        for entity in trees {
            let record = self.records.bodies.get(entity).ok();
            let record = record.filter(|record| record.link.is_some());
            // Under a body that moves, its own shapes stay where they are on it.
            let now = self.scene.transform(entity);
            let stays = record.is_some_and(|record| same_vec(record.local.scale, now.scale));
            let scene = self.scene;
            scene.each_below(entity, |below| {
                let is_body = self.link(below).is_some();
                if is_body {
                    self.moved.push((below, true));
                }
                if !stays {
                    self.mark(below);
                }
            });
        }
    }

    /// Takes back the velocities that targets gave to kinematic bodies in the last step.
    pub(super) fn end_targets(&mut self) {
        let mut links = Vec::new();
        for entity in core::mem::take(&mut self.state.targets) {
            if let Ok(mut record) = self.records.bodies.get_mut(entity) {
                record.targeted = false;
                links.extend(record.link.map(|link| (link, entity)));
            }
        }
        links.sort_unstable_by_key(|(link, _)| (link.world, link.body));
        for (link, entity) in links {
            if self.scene.kind(entity) == Some(BodyKind::Kinematic) {
                self.write_velocity(link, entity);
            }
        }
    }

    /// Moves the bodies whose transforms the user wrote, or that follow an ancestor.
    pub(super) fn move_bodies(&mut self) {
        let mut moved: Vec<(BodyLink, Entity, bool)> = Vec::new();
        for (entity, by_ancestor) in core::mem::take(&mut self.moved) {
            // New bodies are where their transforms are.
            if self.added.binary_search(&entity).is_ok() {
                continue;
            }
            moved.extend(self.link(entity).map(|link| (link, entity, by_ancestor)));
        }
        moved.sort_unstable_by_key(|(link, _, by_ancestor)| (link.world, link.body, *by_ancestor));
        moved.dedup();
        for (link, entity, by_ancestor) in moved {
            self.move_body(link, entity, by_ancestor);
        }
    }

    fn move_body(&mut self, link: BodyLink, entity: Entity, by_ancestor: bool) {
        let Ok(mut record) = self.records.bodies.get_mut(entity) else { return };
        let now = self.scene.transform(entity);
        let is_written = !same_place(&record.local, &now);
        record.local = now;
        if !is_written && !by_ancestor {
            return;
        }
        let pose = self.scene.place(entity).pose;
        let Ok(mut physics) = self.records.worlds.get_mut(link.world) else { return };
        let Some(mut body) = physics.world.body_mut(link.body) else { return };
        let stays = same_pose(&body.get().pose(), &pose);
        let moves =
            record.linear != bevy_math::Vec3::ZERO || record.angular != bevy_math::Vec3::ZERO;
        match body.get().kind() {
            BodyKind::Static => {
                if !stays {
                    body.set_pose(pose);
                }
            }
            BodyKind::Kinematic if is_written || !moves => {
                if stays {
                    return;
                }
                body.move_to(pose, self.dt);
                record.targeted = true;
                self.state.targets.push(entity);
            }
            BodyKind::Dynamic if is_written => {
                if !stays {
                    body.set_pose(pose);
                    // A teleport is shown at once.
                    record.before = now;
                }
            }
            BodyKind::Kinematic | BodyKind::Dynamic => self.state.rewrite.push(entity),
        }
    }
}

/// Whether two poses are equal. The engine stores rotations normalized.
fn same_pose(now: &Pose, wanted: &Pose) -> bool {
    now == wanted
        || (now.position == wanted.position && now.rotation == wanted.rotation.normalized())
}
