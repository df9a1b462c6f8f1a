//! Mouse and keys over the picture.

use drystone::Vec3;
use drystone_render::{Camera, Subject};
use egui::{Key, Modifiers, PointerButton, Pos2, Rect, Response, Ui};

use crate::panel::Panel;
use crate::settings::next_method;
use crate::sim::{Command, Deed, Shown};

/// The camera and the state of the mouse.
#[derive(Debug)]
pub(crate) struct Control {
    pub(crate) camera: Option<Camera>,
    /// Where the runs are drawn, from left to right [points of the screen].
    pub(crate) parts: Vec<Rect>,
    /// Number of the last grab that was sent, while the left button is down.
    grab: Option<u64>,
    asked: u64,
}

/// Radians for a point of the screen.
const TURN: f32 = 0.006;

impl Control {
    pub(crate) const fn new() -> Self {
        Self { camera: None, parts: Vec::new(), grab: None, asked: 0 }
    }

    /// Divides the picture among the runs.
    pub(crate) fn divide(&mut self, picture: Rect, runs: usize) {
        #[expect(clippy::cast_precision_loss, reason = "one or two")]
        let width = picture.width() / runs.max(1) as f32;
        let size = egui::vec2(width, picture.height());
        let left = |run: f32| picture.min + egui::vec2(run * width, 0.0);
        self.parts.clear();
        self.parts.extend(
            [0.0, 1.0].into_iter().take(runs).map(|run| Rect::from_min_size(left(run), size)),
        );
    }

    /// Shows all of the subject.
    pub(crate) fn frame(&mut self, subject: &Subject) {
        let size = self.parts.first().map_or(egui::Vec2::splat(1.0), Rect::size);
        let aspect = size.x.max(1.0) / size.y.max(1.0);
        self.camera = Some(subject.camera(subject.angles(), aspect));
    }

    /// Takes in the mouse's moves over the picture.
    pub(crate) fn mouse(
        &mut self,
        ui: &Ui,
        area: &Response,
        shown: &Shown,
        send: &mut dyn FnMut(Command),
    ) {
        let Some(camera) = self.camera else { return };
        if let Some(touch) = ui.input(egui::InputState::multi_touch) {
            // Two fingers move the view; the body that the first one holds is let go.
            if self.grab.take().is_some() {
                send(Command::Release);
            }
            let half = 0.5 * self.parts.first().map_or(1.0, Rect::height).max(1.0);
            let moved = touch.translation_delta;
            let camera = camera.panned(-moved.x / half, moved.y / half);
            self.camera = Some(camera.dollied(touch.zoom_delta.clamp(0.5, 2.0).recip()));
            return;
        }
        let pointer = area.interact_pointer_pos().or(area.hover_pos());
        let (shift, scroll, moved, pressed) = ui.input(|i| {
            let pointer = &i.pointer;
            (i.modifiers.shift, i.smooth_scroll_delta().y, pointer.delta(), pointer.press_origin())
        });
        if let Some(at) = pointer {
            let (origin, direction, side) = self.ray(&camera, at);
            if area.drag_started_by(PointerButton::Primary) && !shift {
                self.asked += 1;
                self.grab = Some(self.asked);
                // The body under the pointer when the button went down, not where the drag was
                // noticed.
                let (o, d, side) = self.ray(&camera, pressed.unwrap_or(at));
                send(Command::Grab(o, d, side));
            }
            if self.holds(shown) && area.dragged_by(PointerButton::Primary) {
                send(Command::Drag(origin, direction));
            }
            if area.double_clicked() {
                send(Command::Shoot(origin, direction, false));
            } else if area.clicked() {
                send(Command::Pick(origin, direction, side));
            }
        }
        if area.drag_stopped() && self.grab.take().is_some() {
            send(Command::Release);
        }
        let free = !self.waits(shown) && !self.holds(shown);
        let pan = area.dragged_by(PointerButton::Middle)
            || area.dragged_by(PointerButton::Primary) && shift;
        let orbit = area.dragged_by(PointerButton::Secondary)
            || area.dragged_by(PointerButton::Primary) && free;
        let camera = if pan {
            let half = 0.5 * self.parts.first().map_or(1.0, Rect::height).max(1.0);
            camera.panned(-moved.x / half, moved.y / half)
        } else if orbit {
            camera.orbited(-moved.x * TURN, moved.y * TURN)
        } else {
            camera
        };
        let zoom = if area.hovered() { (1.0 - 0.002 * scroll).clamp(0.5, 2.0) } else { 1.0 };
        self.camera = Some(camera.dollied(zoom));
    }

    /// Takes in keys.
    pub(crate) fn keys(
        &mut self,
        ui: &Ui,
        panel: &mut Panel,
        shown: &Shown,
        send: &mut dyn FnMut(Command),
    ) {
        let pressed = |key| ui.input_mut(|i| i.consume_key(Modifiers::NONE, key));
        if pressed(Key::Space) {
            send(Command::Play(!shown.playing));
        }
        if pressed(Key::ArrowRight) {
            send(Command::Step);
        }
        if pressed(Key::ArrowLeft) {
            send(Command::Seek(shown.step.saturating_sub(1)));
        }
        if pressed(Key::R) || pressed(Key::Home) {
            send(Command::Seek(0));
        }
        for (key, times) in [(Key::Comma, 0.5), (Key::Period, 2.0)] {
            if pressed(key) {
                panel.speed = (panel.speed * times).clamp(0.01, 4.0);
                send(Command::Speed(panel.speed));
            }
        }
        for (key, boxed) in [(Key::S, false), (Key::B, true)] {
            if pressed(key)
                && let Some(camera) = &self.camera
            {
                let middle = self.parts.first().map_or(Pos2::ZERO, Rect::center);
                let at = ui.input(|i| i.pointer.hover_pos()).unwrap_or(middle);
                let (origin, direction, _) = self.ray(camera, at);
                send(Command::Shoot(origin, direction, boxed));
            }
        }
        for (key, deed) in [
            (Key::Delete, Deed::Remove),
            (Key::Backspace, Deed::Remove),
            (Key::D, Deed::Duplicate),
            (Key::Z, Deed::Freeze),
        ] {
            if pressed(key) {
                send(Command::Act(deed));
            }
        }
        let side = panel.side();
        if pressed(Key::M)
            && let Some(view) = shown.views.get(side)
            && let Some(method) = next_method(&view.config.method)
        {
            let config = drystone::WorldConfig { method, ..view.config.clone() };
            send(Command::Config(side, Box::new(config)));
        }
        if pressed(Key::V) {
            send(Command::Split(shown.views.len() == 1));
        }
        if pressed(Key::F1) || pressed(Key::H) {
            panel.help = !panel.help;
        }
        if pressed(Key::F) {
            self.frame(&shown.subject);
        }
    }

    /// Eye and direction through a point of the screen, and the run that is seen there.
    fn ray(&self, camera: &Camera, at: Pos2) -> (Vec3, Vec3, usize) {
        let side = self.parts.iter().position(|part| part.contains(at)).unwrap_or(0);
        let part = self.parts.get(side).copied().unwrap_or(Rect::NOTHING);
        let size = part.size().max(egui::Vec2::splat(1.0));
        let from_center = at - part.center();
        let (x, y) = (2.0 * from_center.x / size.x, -2.0 * from_center.y / size.y);
        (camera.eye, camera.ray(x, y, size.x / size.y), side)
    }

    /// Whether the physics thread has not yet said if the mouse met a body.
    fn waits(&self, shown: &Shown) -> bool {
        self.grab.is_some_and(|number| number > shown.grabs.0)
    }

    fn holds(&self, shown: &Shown) -> bool {
        self.grab.is_some_and(|number| (number, true) == shown.grabs)
    }
}
