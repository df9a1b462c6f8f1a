//! Keyframes.

use drystone::{Pose, Quat, Vec3};

use super::Describe;
use crate::error::SceneError;
use crate::mjcf::walk::Instance;
use crate::read::xml::Element;
use crate::robot::{Keyframe, Robot};

/// Most numbers of a list.
const MOST: usize = 10_000_000;

/// Most keyframes that a size asks for.
const MOST_KEYS: usize = 1000;

impl Describe<'_, '_> {
    /// Keyframes of the first model: an attached one has another number of coordinates.
    pub(super) fn keyframes(
        &mut self,
        instance: &Instance,
        is_main: bool,
    ) -> Result<(), SceneError> {
        let model = self.model(instance);
        for section in model.sections("keyframe").collect::<Vec<_>>() {
            for element in model.children(&section)? {
                if element.tag() == "key" && is_main {
                    let key = keyframe(&element, &self.robot)?;
                    self.robot.keyframes.push(key);
                } else {
                    self.leave_out(&element, "it is a keyframe of an attached model");
                }
            }
        }
        // A size asks for more, which are the file's pose.
        for size in model.sections("size").filter(|_| is_main) {
            let count = size.get("nkey").and_then(|n| n.trim().parse::<usize>().ok());
            while self.robot.keyframes.len() < count.unwrap_or(0).min(MOST_KEYS) {
                let key = keyframe(&size, &self.robot)?;
                self.robot.keyframes.push(Keyframe { name: String::new(), time: 0.0, ..key });
            }
        }
        Ok(())
    }
}

fn keyframe(element: &Element<'_>, robot: &Robot) -> Result<Keyframe, SceneError> {
    let list = |name: &str, normal: Vec<f32>| {
        let count = normal.len();
        match element.list(name, MOST)? {
            None => Ok(normal),
            Some(given) if given.len() == count => Ok(given),
            Some(given) => {
                let problem = format!("{name} has {} numbers", given.len());
                Err(element.error(problem, &format!("{count}, as the model has")))
            }
        }
    };
    let positions: Vec<f32> = robot.mocap.iter().flat_map(|p| p.position.to_array()).collect();
    let rotations: Vec<f32> = robot
        .mocap
        .iter()
        .flat_map(|p| [p.rotation.w, p.rotation.x, p.rotation.y, p.rotation.z])
        .collect();
    let (at, turn) = (list("mpos", positions)?, list("mquat", rotations)?);
    let mocap = at.chunks_exact(3).zip(turn.chunks_exact(4)).map(|(p, r)| Pose {
        position: Vec3::from([p[0], p[1], p[2]]),
        rotation: Quat::new(r[1], r[2], r[3], r[0]).normalized(),
    });
    Ok(Keyframe {
        name: element.get("name").unwrap_or_default().to_owned(),
        time: element.number("time")?.unwrap_or(0.0),
        q: list("qpos", robot.start.clone())?,
        v: list("qvel", vec![0.0; robot.velocities()])?,
        activations: list("act", vec![0.0; robot.activations()])?,
        controls: list("ctrl", vec![0.0; robot.actuators.len()])?,
        mocap: mocap.collect(),
    })
}
