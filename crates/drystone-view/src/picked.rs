//! The engine's data on the body that is picked.

use drystone::audit::AwakeCause;
use drystone::{BodyId, BodyKind, Vec3};
use drystone_scene::Running;

/// A body that is looked at.
#[derive(Clone, Debug, PartialEq)]
pub struct Picked {
    /// Its name and kind.
    pub title: String,
    /// Its data, a line each.
    pub lines: Vec<String>,
    /// From its middle over those that it touches to the one that keeps it awake [m, world].
    pub path: Vec<Vec3>,
    /// Whether it can be held where it is, and is so.
    pub frozen: Option<bool>,
}

/// The data of a body; nothing if it is gone.
pub(crate) fn look(running: &Running, id: BodyId) -> Option<Picked> {
    let world = &running.world;
    let body = world.body(id)?;
    let kind = match body.kind() {
        BodyKind::Static => "static",
        BodyKind::Kinematic => "kinematic",
        BodyKind::Dynamic => "dynamic",
    };
    let place = |v: Vec3| format!("{:.3}, {:.3}, {:.3}", v.x, v.y, v.z);
    let mut lines = vec![format!("at {} m", place(body.position()))];
    if body.kind() != BodyKind::Static {
        let (speed, spin) = (body.linear_velocity().length(), body.angular_velocity().length());
        lines.push(format!("{speed:.4} m/s, {spin:.4} rad/s"));
    }
    if body.kind() == BodyKind::Dynamic {
        lines.push(format!("{:.4} kg, {:.4} J", body.mass(), body.kinetic_energy()));
    }
    let own = world.contacts().filter(|c| c.body_a() == id || c.body_b() == id);
    let (mut contacts, mut points, mut impulse) = (0, 0, 0.0);
    for contact in own {
        contacts += 1;
        for point in contact.points() {
            points += 1;
            impulse += point.impulse;
        }
    }
    lines.push(format!("{contacts} contacts of {points} points, {impulse:.4} N s"));
    if let Some(level) = body.support_level() {
        lines.push(format!("{level} above what stands fast"));
    }
    let mut path = Vec::new();
    if let Some(why) = world.why_awake(id).filter(|_| body.kind() == BodyKind::Dynamic) {
        let asleep = matches!(why.cause, AwakeCause::Asleep);
        let whose =
            if why.body == id { String::new() } else { format!("{}: ", name(running, why.body)) };
        lines.push(if asleep {
            "asleep".to_owned()
        } else {
            format!("awake: {whose}{}", why.cause)
        });
        path =
            why.path.iter().filter_map(|id| world.body(*id)).map(|b| b.center_of_mass()).collect();
    }
    let frozen = (body.kind() == BodyKind::Dynamic).then(|| body.locks().any());
    Some(Picked { title: format!("{} ({kind})", name(running, id)), lines, path, frozen })
}

fn name(running: &Running, id: BodyId) -> String {
    let number = running.bodies.iter().position(|b| *b == id);
    let name = number.and_then(|n| running.names.get(n));
    name.map_or_else(|| format!("body {}", id.index()), Clone::clone)
}
