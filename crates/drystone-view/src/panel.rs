//! The panel beside the picture.

use std::collections::VecDeque;

use drystone::{Stage, WorldConfig};
use egui::containers::menu::{MenuButton, MenuConfig};
use egui::{
    Align, Align2, Area, CollapsingHeader, Color32, Context, Frame, Id, Layout, PopupCloseBehavior,
    RichText, ScrollArea, Slider, TextEdit, Ui,
};

use crate::overlay::{Overlays, Tint};
use crate::picked::Picked;
use crate::places;
use crate::plot::{STAGE_COLORS, plot, stacked};
use crate::settings;
use crate::sim::{Command, Deed, Sample, Shown};

/// Steps in the plots.
const PLOTTED: usize = 300;

/// Color of messages.
const WARNING: Color32 = Color32::from_rgb(255, 140, 90);

/// The state of the panel.
#[derive(Debug, Default)]
pub(crate) struct Panel {
    pub(crate) speed: f32,
    pub(crate) overlays: Overlays,
    /// The side whose settings and plots are shown.
    side: usize,
    scene: u64,
    samples: [VecDeque<Sample>; 2],
    /// Settings of a side that were sent and are not yet in force.
    asked: [Option<WorldConfig>; 2],
    /// Why the last choice among settings was refused.
    refused: Option<String>,
    /// The scene that is typed.
    typed: String,
    /// Whether keys are explained.
    pub(crate) help: bool,
    /// The message over the picture that was read and closed, with the scene's number.
    read: Option<(u64, Option<String>)>,
    /// Whether it is seen, if the user said so; else a narrow window leaves it out.
    pub(crate) open: Option<bool>,
}

impl Panel {
    pub(crate) fn new(overlays: Overlays, open: Option<bool>) -> Self {
        Self { speed: 1.0, overlays, open, ..Self::default() }
    }

    /// Takes over the numbers of the latest steps.
    pub(crate) fn learn(&mut self, shown: &Shown) {
        if self.scene != shown.scene {
            self.scene = shown.scene;
            self.samples = Default::default();
            self.asked = Default::default();
        }
        self.side = self.side.min(shown.views.len().saturating_sub(1));
        for (number, view) in shown.views.iter().enumerate().take(2) {
            let samples = &mut self.samples[number];
            samples.extend(&view.samples);
            let surplus = samples.len().saturating_sub(PLOTTED);
            samples.drain(..surplus);
            if self.asked[number].as_ref() == Some(&view.config) {
                self.asked[number] = None;
            }
        }
    }

    /// The side whose settings are shown.
    pub(crate) const fn side(&self) -> usize {
        self.side
    }

    pub(crate) fn show(&mut self, ui: &mut Ui, shown: &Shown, send: &mut dyn FnMut(Command)) {
        ui.add_space(4.0);
        ui.with_layout(Layout::right_to_left(Align::Min), |ui| {
            let hide = ui.small_button("hide");
            places::note(ui, "hide", &hide);
            if hide.clicked() {
                self.open = Some(false);
            }
            ui.with_layout(Layout::left_to_right(Align::Min), |ui| self.scenes(ui, shown, send));
        });
        time(ui, &mut self.speed, shown, send);
        if let Some(message) = &shown.message {
            ui.colored_label(WARNING, message);
        }
        ui.separator();
        ScrollArea::vertical().auto_shrink(false).show(ui, |ui| {
            notes(ui, shown);
            if let Some(picked) = &shown.picked {
                look_at(ui, picked, send);
                ui.separator();
            }
            self.sides(ui, shown, send);
            self.plots(ui);
            ui.separator();
            self.overlays(ui, send);
            ui.separator();
            self.settings(ui, shown, send);
            ui.separator();
            if ui.button("keys and mouse (F1)").clicked() {
                self.help = !self.help;
            }
        });
    }

    /// The button in the corner while it is closed.
    pub(crate) fn corner(
        &mut self,
        context: &Context,
        shown: &Shown,
        send: &mut dyn FnMut(Command),
    ) {
        let corner = Area::new(Id::unique("corner")).anchor(Align2::RIGHT_TOP, [-6.0, 6.0]);
        corner.show(context, |ui| {
            ui.horizontal(|ui| {
                if shown.film.is_none() {
                    let play = ui.button(play_label(shown));
                    places::note(ui, "play", &play);
                    if play.clicked() {
                        send(Command::Play(!shown.playing));
                    }
                }
                let open = ui.button("panel");
                places::note(ui, "panel", &open);
                if open.clicked() {
                    self.open = Some(true);
                }
            });
        });
        let said = (shown.scene, shown.message.clone());
        let any = shown.message.is_some() || !shown.notes.is_empty();
        if any && self.read.as_ref() != Some(&said) && self.below(context, shown) {
            self.read = Some(said);
        }
    }

    /// Messages over the picture while the panel is closed; whether they were closed.
    fn below(&mut self, context: &Context, shown: &Shown) -> bool {
        let mut closed = false;
        // Above the time of a film.
        let up = if shown.film.is_some() { 46.0 } else { 6.0 };
        let area = Area::new(Id::unique("message")).anchor(Align2::CENTER_BOTTOM, [0.0, -up]);
        area.show(context, |ui| {
            Frame::popup(ui.style()).show(ui, |ui| {
                // Half the picture is left to see.
                ui.set_max_width((context.content_rect().width() - 40.0).clamp(80.0, 560.0));
                if let Some(message) = &shown.message {
                    ui.colored_label(WARNING, message);
                }
                if let Some(first) = shown.notes.first() {
                    ui.label(RichText::new(first).small().color(WARNING));
                }
                ui.horizontal(|ui| {
                    let close = ui.small_button("close");
                    places::note(ui, "close", &close);
                    closed = close.clicked();
                    let more = shown.notes.len().saturating_sub(1);
                    if more > 0 && ui.small_button(format!("{more} more")).clicked() {
                        self.open = Some(true);
                    }
                });
            });
        });
        closed
    }

    fn scenes(&mut self, ui: &mut Ui, shown: &Shown, send: &mut dyn FnMut(Command)) {
        // A click into the line must not close the list.
        let stay = MenuConfig::new().close_behavior(PopupCloseBehavior::CloseOnClickOutside);
        let name = RichText::new(format!("{} ...", shown.name)).heading();
        let (button, _) = MenuButton::new(name).config(stay).ui(ui, |ui| {
            ui.set_min_width(320.0_f32.min(ui.ctx().content_rect().width() - 40.0));
            ui.horizontal(|ui| {
                let hint = "name:key=value, or a path";
                let line = ui.add(TextEdit::singleline(&mut self.typed).hint_text(hint));
                let entered = line.lost_focus() && ui.input(|i| i.key_pressed(egui::Key::Enter));
                if (ui.button("open").clicked() || entered) && !self.typed.trim().is_empty() {
                    send(Command::Open(self.typed.trim().to_owned()));
                    ui.close();
                }
            });
            ui.label(RichText::new("or drop a .gltf, .glb or .obj file on the window").small());
            ScrollArea::vertical().max_height(460.0).show(ui, |ui| {
                for entry in drystone_scene::catalog() {
                    let keys: Vec<&str> = entry.parameters.iter().map(|p| p.name).collect();
                    let about = format!("{}\n{}", entry.summary, keys.join(", "));
                    let button = ui.button(entry.name);
                    if ui.clip_rect().contains_rect(button.rect) {
                        places::note(ui, &format!("scene {}", entry.name), &button);
                    }
                    if button.on_hover_text(about.trim_end()).clicked() {
                        send(Command::Open(entry.name.to_owned()));
                        entry.name.clone_into(&mut self.typed);
                        ui.close();
                    }
                }
            });
        });
        places::note(ui, "scenes", &button);
    }

    fn sides(&mut self, ui: &mut Ui, shown: &Shown, send: &mut dyn FnMut(Command)) {
        ui.horizontal(|ui| {
            let mut split = shown.views.len() > 1;
            if ui.checkbox(&mut split, "side by side").on_hover_text("V").changed() {
                send(Command::Split(split));
            }
            if shown.views.len() > 1 {
                ui.selectable_value(&mut self.side, 0, "left");
                ui.selectable_value(&mut self.side, 1, "right");
            }
        });
        let Some(view) = shown.views.get(self.side) else { return };
        let c = &view.counts;
        ui.label(format!("{} dynamic ({} asleep)", c.dynamic, c.asleep));
        ui.label(format!("{} kinematic, {} static", c.kinematic, c.fixed));
        ui.label(format!("{} shapes, {} joints, {} pairs", c.shapes, c.joints, c.pairs));
        ui.label(format!("{} contacts in {} colors", c.contacts, c.colors));
        ui.label(match view.hash {
            Some(hash) => format!("hash {hash:016x}"),
            None => "hash: when it stands still".to_owned(),
        });
    }

    fn plots(&self, ui: &mut Ui) {
        let samples = &self.samples[self.side];
        let last = samples.back().copied().unwrap_or_default();
        #[expect(clippy::cast_possible_truncation, reason = "a plot shows three digits")]
        let energy = samples.iter().map(|s| s.energy as f32);
        plot(ui, &format!("energy {:.4} kJ", 1.0e-3 * last.energy), energy);
        let overlap = samples.iter().map(|s| s.overlap);
        plot(ui, &format!("deepest overlap {:.3} mm", 1.0e3 * last.overlap), overlap);
        let text = format!("step {:.2} ms", last.step_ms());
        stacked(ui, &text, samples.iter().map(|s| s.stages));
        ui.horizontal_wrapped(|ui| {
            ui.spacing_mut().item_spacing.x = 6.0;
            for ((stage, color), ms) in Stage::ALL.iter().zip(STAGE_COLORS).zip(last.stages) {
                let text = RichText::new(format!("{} {ms:.2}", stage.name())).small();
                ui.colored_label(color, text);
            }
        });
    }

    fn overlays(&mut self, ui: &mut Ui, send: &mut dyn FnMut(Command)) {
        let o = &mut self.overlays;
        let before = *o;
        ui.columns(2, |columns| {
            columns[0].checkbox(&mut o.contacts, "contacts");
            columns[0].checkbox(&mut o.friction, "friction");
            columns[0].checkbox(&mut o.colors, "colors");
            columns[0].checkbox(&mut o.joints, "joints");
            columns[0].checkbox(&mut o.limits, "limits of joints");
            columns[1].checkbox(&mut o.colliders, "collision shapes");
            columns[1].checkbox(&mut o.bounds, "bounds");
            columns[1].checkbox(&mut o.centers, "centers");
            columns[1].checkbox(&mut o.velocities, "velocities");
            columns[1].checkbox(&mut o.sleeping, "asleep");
        });
        ui.horizontal(|ui| {
            ui.label("bodies by");
            ui.selectable_value(&mut o.tint, Tint::Own, "own");
            ui.selectable_value(&mut o.tint, Tint::Island, "island");
            ui.selectable_value(&mut o.tint, Tint::Level, "level");
        });
        if *o != before {
            send(Command::Overlays(*o));
        }
    }

    fn settings(&mut self, ui: &mut Ui, shown: &Shown, send: &mut dyn FnMut(Command)) {
        let side = self.side;
        let Some(view) = shown.views.get(side) else { return };
        let before = self.asked[side].as_ref().unwrap_or(&view.config);
        let mut config = before.clone();
        if let Some(why) = settings::show(ui, &mut config) {
            self.refused = Some(why);
        }
        if let Some(why) = &self.refused {
            ui.colored_label(WARNING, why);
        }
        if config != *before {
            self.refused = None;
            send(Command::Config(side, Box::new(config.clone())));
            self.asked[side] = Some(config);
        }
    }
}

/// Notes on the parts of the scene's file that were left out.
fn notes(ui: &mut Ui, shown: &Shown) {
    if shown.notes.is_empty() {
        return;
    }
    let title = match shown.notes.len() {
        1 => "a note on this file".to_owned(),
        count => format!("{count} notes on this file"),
    };
    let header = CollapsingHeader::new(RichText::new(title).color(WARNING));
    let header = header.id_salt(("notes", shown.scene)).default_open(true).show(ui, |ui| {
        for note in shown.notes.iter() {
            ui.label(RichText::new(note).small());
        }
    });
    places::note(ui, "notes", &header.header_response);
    ui.separator();
}

fn look_at(ui: &mut Ui, picked: &Picked, send: &mut dyn FnMut(Command)) {
    ui.label(RichText::new(&picked.title).strong());
    for line in &picked.lines {
        ui.label(RichText::new(line).small());
    }
    ui.horizontal(|ui| {
        if ui.button("delete").clicked() {
            send(Command::Act(Deed::Remove));
        }
        if ui.button("duplicate").on_hover_text("D").clicked() {
            send(Command::Act(Deed::Duplicate));
        }
        if let Some(frozen) = picked.frozen {
            let label = if frozen { "let go" } else { "freeze" };
            if ui.button(label).on_hover_text("Z").clicked() {
                send(Command::Act(Deed::Freeze));
            }
        }
    });
}

const fn play_label(shown: &Shown) -> &'static str {
    if shown.playing { "pause" } else { "play" }
}

fn time(ui: &mut Ui, speed: &mut f32, shown: &Shown, send: &mut dyn FnMut(Command)) {
    let wide = ui.available_width() - 8.0;
    let usual = std::mem::replace(&mut ui.spacing_mut().slider_width, wide.max(40.0));
    ui.horizontal(|ui| {
        let mut button = |label, about, place, command| {
            let button = ui.button(label);
            places::note(ui, place, &button);
            if button.on_hover_text(about).clicked() {
                send(command);
            }
        };
        button("|<", "to the beginning (R)", "first", Command::Seek(0));
        let before = Command::Seek(shown.step.saturating_sub(1));
        button("<", "a step back (left arrow)", "back", before);
        button(play_label(shown), "space", "play", Command::Play(!shown.playing));
        button(">", "a step (right arrow)", "step", Command::Step);
    });
    let mut step = shown.step;
    let furthest = shown.film.unwrap_or(shown.furthest).max(1);
    if ui.add(Slider::new(&mut step, 0..=furthest).show_value(false)).changed() {
        send(Command::Seek(step));
    }
    #[expect(clippy::cast_precision_loss, reason = "steps are far below 2^52")]
    let seconds = |steps: u64| steps as f64 * f64::from(shown.dt);
    ui.label(format!(
        "step {} of {}, {:.2} s of {:.2} s",
        shown.step,
        furthest,
        seconds(shown.step),
        seconds(furthest)
    ));
    let slider = Slider::new(speed, 0.01..=4.0).logarithmic(true).show_value(false);
    if ui.add(slider).on_hover_text("how fast time goes (comma, period)").changed() {
        send(Command::Speed(*speed));
    }
    ui.label(format!("speed ×{speed:.2}"));
    ui.spacing_mut().slider_width = usual;
}

/// The time of a film, below its picture.
pub(crate) fn film_bar(ui: &mut Ui, shown: &Shown, send: &mut dyn FnMut(Command)) {
    ui.horizontal(|ui| {
        let play = ui.button(play_label(shown));
        places::note(ui, "play", &play);
        if play.clicked() {
            send(Command::Play(!shown.playing));
        }
        #[expect(clippy::cast_precision_loss, reason = "steps are far below 2^52")]
        let time = shown.step as f64 * f64::from(shown.dt);
        let text = format!("{time:6.2} s");
        ui.spacing_mut().slider_width = (ui.available_width() - 80.0).max(40.0);
        let mut step = shown.step;
        let end = shown.film.unwrap_or(shown.furthest).max(1);
        let slider = ui.add(Slider::new(&mut step, 0..=end).show_value(false));
        places::note(ui, "time", &slider);
        if slider.changed() {
            send(Command::Seek(step));
        }
        ui.label(text);
    });
}

/// Explains keys and mouse.
pub(crate) fn help(ui: &mut Ui) {
    let rows = [
        ("drag a body", "pull and throw it"),
        ("click a body", "look closer at it"),
        ("drag beside, right drag", "turn the view"),
        ("shift or middle drag", "move the view"),
        ("wheel", "nearer and farther"),
        ("two fingers", "move the view, nearer and farther"),
        ("F", "see all"),
        ("space", "run or stand still"),
        ("right, left arrow", "a step, a step back"),
        (",  .", "slower, faster"),
        ("R", "to the beginning"),
        ("S, double click", "shoot a ball"),
        ("B", "shoot a box"),
        ("delete", "take the picked body away"),
        ("D", "a second one of it"),
        ("Z", "freeze it, let it go"),
        ("M", "the next method"),
        ("V", "two runs side by side"),
        ("F1, H", "this list"),
    ];
    egui::Grid::new("help").num_columns(2).spacing([18.0, 4.0]).show(ui, |ui| {
        for (what, does) in rows {
            ui.label(RichText::new(what).strong());
            ui.label(does);
            ui.end_row();
        }
    });
}
