//! The viewer's state for the page.

use drystone::Vec3;
use drystone_view::places::Place;
use drystone_view::sim::Shown;
use serde_json::{Map, Value, json};

/// The state as JSON, for a page or a program that drives it.
pub(crate) fn json(shown: &Shown, places: &[Place]) -> String {
    let vec = |v: Vec3| json!([v.x, v.y, v.z]);
    let views: Vec<Value> = shown
        .views
        .iter()
        .map(|view| {
            let c = &view.counts;
            json!({
                "method": view.config.method.name(),
                "hash": view.hash.map(|hash| format!("{hash:016x}")),
                "dynamic": c.dynamic,
                "asleep": c.asleep,
                "contacts": c.contacts,
                "step_ms": view.samples.last().map(drystone_view::sim::Sample::step_ms),
            })
        })
        .collect();
    let places: Map<String, Value> = places
        .iter()
        .map(|(name, r)| (name.clone(), json!([r.left(), r.top(), r.right(), r.bottom()])))
        .collect();
    json!({
        "scene": shown.name,
        "opened": shown.scene,
        "step": shown.step,
        "furthest": shown.furthest,
        "film": shown.film,
        "dt": shown.dt,
        "playing": shown.playing,
        "views": views,
        "held": shown.held.map(|(from, to)| json!({ "from": vec(from), "to": vec(to) })),
        "picked": shown.picked.as_ref().map(|p| p.title.clone()),
        "message": shown.message,
        "notes": shown.notes.as_ref(),
        "places": places,
    })
    .to_string()
}
