//! What mouse and keys do over the picture.

use drystone::Vec3;
use drystone_render::{Camera, Subject};
use egui::{Key, PointerButton, Rect, Response, Ui};

use crate::sim::{Command, Shown};

/// The camera and what the mouse is at.
#[derive(Debug)]
pub(crate) struct Control {
    pub(crate) camera: Option<Camera>,
    /// The whole picture [points of the screen].
    picture: Rect,
    /// Number of the last grab that was asked for, while the left button is down.
    grab: Option<u64>,
    asked: u64,
}

/// Radians for a point of the screen.
const TURN: f32 = 0.006;

impl Control {
    pub(crate) fn new() -> Self {
        Self { camera: None, picture: Rect::NOTHING, grab: None, asked: 0 }
    }

    /// Shows all of the subject left of a panel `panel` wide [points of the screen].
    pub(crate) fn frame(&mut self, subject: &Subject, picture: Rect, panel: f32) {
        let free = (picture.width() - panel).max(1.0);
        let camera = subject.camera(subject.angles(), free / picture.height().max(1.0));
        self.camera = Some(camera.panned(panel / picture.height().max(1.0), 0.0));
    }

    /// Takes in what the mouse did on `area`, the part of the picture that no panel covers.
    pub(crate) fn mouse(
        &mut self,
        ui: &Ui,
        area: &Response,
        picture: Rect,
        shown: &Shown,
        send: &mut dyn FnMut(Command),
    ) {
        self.picture = picture;
        let Some(camera) = self.camera else { return };
        let pointer = area.interact_pointer_pos().or(area.hover_pos());
        let ray = pointer.map(|at| self.ray(&camera, at));
        let (shift, scroll, moved) =
            ui.input(|i| (i.modifiers.shift, i.smooth_scroll_delta().y, i.pointer.delta()));
        if let Some((origin, direction)) = ray {
            if area.drag_started_by(PointerButton::Primary) && !shift {
                self.asked += 1;
                self.grab = Some(self.asked);
                // What was under the pointer when the button went down, not where the drag was noticed.
                let pressed = ui.input(|i| i.pointer.press_origin());
                let (o, d) = pressed.map_or((origin, direction), |at| self.ray(&camera, at));
                send(Command::Grab(o, d));
            }
            if self.holds(shown) && area.dragged_by(PointerButton::Primary) {
                send(Command::Drag(origin, direction));
            }
            if area.double_clicked() {
                send(Command::Shoot(origin, direction));
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
            let half = 0.5 * picture.height().max(1.0);
            camera.panned(-moved.x / half, moved.y / half)
        } else if orbit {
            camera.orbited(-moved.x * TURN, moved.y * TURN)
        } else {
            camera
        };
        let zoom = if area.hovered() { (1.0 - 0.002 * scroll).clamp(0.5, 2.0) } else { 1.0 };
        self.camera = Some(camera.dollied(zoom));
    }

    /// Takes in keys. Returns whether the camera is to frame all again.
    pub(crate) fn keys(&self, ui: &Ui, shown: &Shown, send: &mut dyn FnMut(Command)) -> bool {
        let pressed = |key| ui.input_mut(|i| i.consume_key(egui::Modifiers::NONE, key));
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
        if pressed(Key::S) {
            let at = ui.input(|i| i.pointer.hover_pos()).unwrap_or(self.picture.center());
            if let Some(camera) = &self.camera {
                let (origin, direction) = self.ray(camera, at);
                send(Command::Shoot(origin, direction));
            }
        }
        pressed(Key::F)
    }

    /// Eye and direction through a point of the screen.
    fn ray(&self, camera: &Camera, at: egui::Pos2) -> (Vec3, Vec3) {
        let size = self.picture.size().max(egui::Vec2::splat(1.0));
        let from_center = at - self.picture.center();
        let (x, y) = (2.0 * from_center.x / size.x, -2.0 * from_center.y / size.y);
        (camera.eye, camera.ray(x, y, size.x / size.y))
    }

    /// Whether the physics thread has not yet said if the mouse met a body.
    fn waits(&self, shown: &Shown) -> bool {
        self.grab.is_some_and(|number| number > shown.grabs.0)
    }

    fn holds(&self, shown: &Shown) -> bool {
        self.grab.is_some_and(|number| (number, true) == shown.grabs)
    }
}
