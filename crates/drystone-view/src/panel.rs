//! The panel beside the picture.

use std::collections::VecDeque;

use drystone::{Method, WorldConfig};
use egui::{ComboBox, DragValue, RichText, ScrollArea, Slider, Ui};

use crate::overlay::Overlays;
use crate::plot::plot;
use crate::sim::{Command, Sample, Shown};

/// Steps in the plots.
const PLOTTED: usize = 400;

/// What the panel remembers.
#[derive(Debug, Default)]
pub(crate) struct Panel {
    speed: f32,
    pub(crate) overlays: Overlays,
    samples: VecDeque<Sample>,
    /// Settings that were asked for and are not yet in force.
    asked: Option<WorldConfig>,
}

impl Panel {
    pub(crate) fn new(overlays: Overlays) -> Self {
        Self { speed: 1.0, overlays, ..Self::default() }
    }

    /// Takes over the numbers of the latest steps.
    pub(crate) fn learn(&mut self, shown: &Shown) {
        self.samples.extend(&shown.samples);
        let surplus = self.samples.len().saturating_sub(PLOTTED);
        self.samples.drain(..surplus);
        if self.asked.as_ref() == Some(&shown.config) {
            self.asked = None;
        }
    }

    pub(crate) fn show(
        &mut self,
        ui: &mut Ui,
        name: &str,
        shown: &Shown,
        send: &mut dyn FnMut(Command),
    ) {
        ui.add_space(4.0);
        ui.label(RichText::new(name).heading());
        time(ui, &mut self.speed, shown, send);
        ui.separator();
        ScrollArea::vertical().show(ui, |ui| {
            counts(ui, shown);
            self.plots(ui, shown);
            ui.separator();
            self.overlays(ui, send);
            ui.separator();
            self.settings(ui, shown, send);
            ui.separator();
            help(ui);
        });
    }

    fn plots(&self, ui: &mut Ui, shown: &Shown) {
        let last = self.samples.back().copied().unwrap_or_default();
        let text = format!("step {:.2} ms", last.step_ms);
        plot(ui, &text, self.samples.iter().map(|s| s.step_ms));
        #[expect(clippy::cast_possible_truncation, reason = "a plot shows three digits")]
        let energy = self.samples.iter().map(|s| s.energy as f32);
        plot(ui, &format!("energy {:.4} kJ", 1.0e-3 * last.energy), energy);
        #[expect(clippy::cast_precision_loss, reason = "a plot shows three digits")]
        let contacts = self.samples.iter().map(|s| s.contacts as f32);
        plot(ui, &format!("contacts {}", shown.counts.contacts), contacts);
    }

    fn overlays(&mut self, ui: &mut Ui, send: &mut dyn FnMut(Command)) {
        let o = &mut self.overlays;
        let before = *o;
        ui.columns(2, |columns| {
            columns[0].checkbox(&mut o.contacts, "contacts");
            columns[0].checkbox(&mut o.joints, "joints");
            columns[0].checkbox(&mut o.bounds, "bounds");
            columns[1].checkbox(&mut o.sleeping, "asleep");
            columns[1].checkbox(&mut o.islands, "islands");
        });
        if *o != before {
            send(Command::Overlays(*o));
        }
    }

    fn settings(&mut self, ui: &mut Ui, shown: &Shown, send: &mut dyn FnMut(Command)) {
        let before = self.asked.as_ref().unwrap_or(&shown.config);
        let mut config = before.clone();
        egui::Grid::new("settings").num_columns(2).show(ui, |ui| {
            ui.label("method");
            let mut name = config.method.name();
            ComboBox::from_id_salt("method").selected_text(name).show_ui(ui, |ui| {
                for known in Method::NAMES {
                    ui.selectable_value(&mut name, known, known);
                }
            });
            if name != config.method.name()
                && let Some(method) = Method::named(name)
            {
                config.method = method;
            }
            ui.end_row();
            ui.label("substeps");
            ui.add(DragValue::new(&mut config.substeps).range(0..=64))
                .on_hover_text("0: the method's own");
            ui.end_row();
            ui.label("gravity [m/s²]");
            ui.horizontal(|ui| {
                for axis in 0..3 {
                    ui.add(DragValue::new(&mut config.gravity[axis]).speed(0.1));
                }
            });
            ui.end_row();
            ui.label("contact.hertz");
            ui.add(DragValue::new(&mut config.contact.hertz).speed(0.5))
                .on_hover_text("0: the method's own");
            ui.end_row();
            ui.label("sleep");
            ui.checkbox(&mut config.sleep.enabled, "");
            ui.end_row();
        });
        if config != *before {
            send(Command::Config(Box::new(config.clone())));
            self.asked = Some(config);
        }
    }
}

fn time(ui: &mut Ui, speed: &mut f32, shown: &Shown, send: &mut dyn FnMut(Command)) {
    let wide = ui.available_width() - 8.0;
    let usual = std::mem::replace(&mut ui.spacing_mut().slider_width, wide.max(40.0));
    ui.horizontal(|ui| {
        if ui.button("|<").on_hover_text("to the beginning (R)").clicked() {
            send(Command::Seek(0));
        }
        if ui.button("<").on_hover_text("a step back (left arrow)").clicked() {
            send(Command::Seek(shown.step.saturating_sub(1)));
        }
        let label = if shown.playing { "pause" } else { "play" };
        if ui.button(label).on_hover_text("space").clicked() {
            send(Command::Play(!shown.playing));
        }
        if ui.button(">").on_hover_text("a step (right arrow)").clicked() {
            send(Command::Step);
        }
    });
    let mut step = shown.step;
    let furthest = shown.furthest.max(1);
    if ui.add(Slider::new(&mut step, 0..=furthest).show_value(false)).changed() {
        send(Command::Seek(step));
    }
    #[expect(clippy::cast_precision_loss, reason = "steps are far below 2^52")]
    let seconds = |steps: u64| steps as f64 * f64::from(shown.dt);
    ui.label(format!(
        "step {} of {}, {:.2} s of {:.2} s",
        shown.step,
        shown.furthest,
        seconds(shown.step),
        seconds(shown.furthest)
    ));
    let slider = Slider::new(speed, 0.05..=4.0).logarithmic(true).show_value(false);
    if ui.add(slider).on_hover_text("how fast time goes").changed() {
        send(Command::Speed(*speed));
    }
    ui.label(format!("speed ×{speed:.2}"));
    ui.spacing_mut().slider_width = usual;
    if let Some(message) = &shown.message {
        ui.colored_label(egui::Color32::from_rgb(255, 140, 90), message);
    }
}

fn counts(ui: &mut Ui, shown: &Shown) {
    let c = &shown.counts;
    ui.label(format!(
        "{} dynamic ({} asleep), {} kinematic, {} static",
        c.dynamic, c.asleep, c.kinematic, c.fixed
    ));
    ui.label(format!("{} shapes, {} joints, {} pairs", c.shapes, c.joints, c.pairs));
}

fn help(ui: &mut Ui) {
    let lines = [
        "drag a body: pull it",
        "drag beside, or right: turn the view",
        "shift or middle drag: move the view",
        "wheel: nearer and farther",
        "double click, S: shoot a ball",
        "F: see all   R: restart",
        "space: pause   arrows: step",
    ];
    for line in lines {
        ui.label(RichText::new(line).small());
    }
}
