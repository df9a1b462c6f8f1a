//! Every field of a world's configuration, to change while it runs.

use drystone::WorldConfig;
use drystone::config::ParticleForm;
use drystone::method::{Damping, Integration, Method, Order, Overlap, Persistence, Rest, Shock};
use egui::{ComboBox, DragValue, Grid, Ui};

use crate::places;

const OWN: &str = "0: the method's own";
const HERTZ: &str = "Hz; 0: the method's own";

/// Shows the fields; they are changed in `config`. Returns why a choice was refused.
pub(crate) fn show(ui: &mut Ui, config: &mut WorldConfig) -> Option<String> {
    let mut refused = None;
    Grid::new("settings").num_columns(2).show(ui, |ui| {
        ui.label("method");
        method(ui, &mut config.method);
        ui.end_row();
        refused = options(ui, config);
        row(ui, "substeps", OWN, DragValue::new(&mut config.substeps).range(0..=256));
        ui.label("gravity").on_hover_text("m/s²");
        ui.horizontal(|ui| {
            ui.spacing_mut().item_spacing.x = 2.0;
            for axis in 0..3 {
                ui.add(DragValue::new(&mut config.gravity[axis]).speed(0.1));
            }
        });
        ui.end_row();
        numbers(ui, config);
        ui.label("inertia.max_factor").on_hover_text(OWN);
        let most = &mut config.inertia.max_factor;
        if ui.add(DragValue::new(most).range(0.0..=64.0).speed(0.1)).changed() && *most < 1.0 {
            // Between them is nothing: 0 is the method's own, 1 is off.
            *most = most.round();
        }
        ui.end_row();
        row(ui, "inertia.refine", "", DragValue::new(&mut config.inertia.refine).range(1..=8));
        row(ui, "joint.refine", "", DragValue::new(&mut config.joint.refine).range(1..=8));
        row(
            ui,
            "particle.sweeps",
            OWN,
            DragValue::new(&mut config.particle.sweeps).range(0..=1000),
        );
        let most = &mut config.breakage.max_pieces;
        row(ui, "breakage.max_pieces", "", DragValue::new(most));
        ui.label("sleep.enabled");
        ui.checkbox(&mut config.sleep.enabled, "");
        ui.end_row();
    });
    refused
}

/// Choices of the method's options. Options that do not go together are refused.
fn options(ui: &mut Ui, config: &mut WorldConfig) -> Option<String> {
    let o = *config.method.options();
    let mut refused = None;
    for (path, word, words) in [
        ("method.order", o.order.word(), Order::WORDS),
        ("method.shock", o.shock.word(), Shock::WORDS),
        ("method.persistence", o.persistence.word(), Persistence::WORDS),
        ("method.overlap", o.overlap.word(), Overlap::WORDS),
        ("method.rest", o.rest.word(), Rest::WORDS),
        ("method.integration", o.integration.word(), Integration::WORDS),
        ("method.damping", o.damping.word(), Damping::WORDS),
        ("particle.form", config.particle.form.word(), ParticleForm::WORDS),
    ] {
        ui.label(path);
        let mut chosen = word;
        ComboBox::from_id_salt(path).selected_text(word).show_ui(ui, |ui| {
            for known in words {
                ui.selectable_value(&mut chosen, *known, *known);
            }
        });
        ui.end_row();
        if chosen != word {
            refused = config.set(path, chosen).err().map(|e| e.to_string());
        }
    }
    let mut sweeps = o.sweeps;
    row(ui, "method.sweeps", OWN, DragValue::new(&mut sweeps).range(0..=1000));
    if sweeps != o.sweeps {
        refused = config.set("method.sweeps", &sweeps.to_string()).err().map(|e| e.to_string());
    }
    refused
}

fn numbers(ui: &mut Ui, config: &mut WorldConfig) {
    let (c, i) = (&mut config.contact, &mut config.inertia);
    let (j, s, p) = (&mut config.joint, &mut config.sleep, &mut config.penalty);
    let length = &mut config.length_scale;
    // Name, unit, field, least value, how fast it changes under the mouse.
    for (name, unit, value, least, speed) in [
        ("length_scale", "length of a typical body in the world's unit", length, 1.0e-4, 0.1),
        ("contact.hertz", HERTZ, &mut c.hertz, 0.0, 0.5),
        ("contact.damping_ratio", "", &mut c.damping_ratio, 0.0, 0.05),
        ("contact.push_speed", "m/s", &mut c.push_speed, 1.0e-6, 0.01),
        ("contact.rest_offset", "m", &mut c.rest_offset, 0.0, 1.0e-5),
        ("contact.margin", "m", &mut c.margin, 1.0e-6, 1.0e-3),
        ("contact.recycle_distance", "m", &mut c.recycle_distance, 0.0, 1.0e-3),
        ("contact.restitution_speed", "m/s", &mut c.restitution_speed, 0.0, 0.01),
        ("contact.hit_speed", "m/s", &mut c.hit_speed, 0.0, 0.01),
        ("inertia.threshold", "m/s²", &mut i.threshold, 1.0e-6, 0.5),
        ("joint.hertz", HERTZ, &mut j.hertz, 0.0, 0.5),
        ("joint.damping_ratio", "", &mut j.damping_ratio, 0.0, 0.05),
        ("joint.tree_ratio", "", &mut j.tree_ratio, 0.0, 0.1),
        ("particle.hertz", HERTZ, &mut config.particle.hertz, 0.0, 0.5),
        ("particle.damping_ratio", "", &mut config.particle.damping_ratio, 0.0, 0.05),
        ("penalty.hertz", "Hz", &mut p.hertz, 1.0e-3, 0.5),
        ("penalty.damping_ratio", "", &mut p.damping_ratio, 0.0, 0.05),
        ("sleep.speed", "m/s", &mut s.speed, 0.0, 1.0e-3),
        ("sleep.time", "s", &mut s.time, 0.0, 0.01),
    ] {
        let value = DragValue::new(value).range(least..=f32::MAX).speed(speed);
        row(ui, name, unit, value.max_decimals(6));
    }
}

fn row(ui: &mut Ui, name: &str, about: &str, value: DragValue<'_>) {
    ui.label(name).on_hover_text(about);
    ui.add(value);
    ui.end_row();
}

fn method(ui: &mut Ui, method: &mut Method) {
    let mut name = method.name();
    let choice = ComboBox::from_id_salt("method").selected_text(name).show_ui(ui, |ui| {
        for known in Method::NAMES.iter().copied() {
            let summary = Method::named(known).map_or_else(String::new, |m| m.summary().to_owned());
            let row = ui.selectable_value(&mut name, known, known);
            places::note(ui, &format!("method {known}"), &row);
            row.on_hover_text(summary);
        }
    });
    if ui.clip_rect().contains_rect(choice.response.rect) {
        places::note(ui, "method", &choice.response);
    }
    if name != method.name()
        && let Some(new) = Method::named(name)
    {
        *method = new;
    }
}

/// The method after this one in the list of all.
pub(crate) fn next_method(method: &Method) -> Option<Method> {
    let at = Method::NAMES.iter().position(|n| *n == method.name()).unwrap_or(0);
    Method::named(Method::NAMES[(at + 1) % Method::NAMES.len()])
}

#[cfg(test)]
mod tests {
    use drystone::WorldConfig;

    /// A new field of the configuration is missing here until it is added.
    #[test]
    fn every_field_has_a_row() {
        let source = include_str!("settings.rs");
        for path in WorldConfig::PATHS {
            assert!(source.contains(&format!("\"{path}\"")), "{path}");
        }
    }
}
