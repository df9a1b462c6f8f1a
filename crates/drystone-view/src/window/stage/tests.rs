//! The window without its surface: mouse and keys in, commands out.

use egui::{Event, Key, Modifiers, PointerButton, Pos2, RawInput, TouchPhase, pos2, vec2};

use super::{Control, Overlays, Panel, Rect, Shown, arrange, context, places};
use crate::sim::tests::simulation;
use crate::sim::{Command, Simulation};

/// The window without its surface.
struct Desk {
    context: egui::Context,
    control: Control,
    panel: Panel,
    simulation: Simulation,
    shown: Shown,
    size: egui::Vec2,
}

impl Desk {
    fn new() -> Self {
        let mut simulation = simulation("stack:n=1");
        let shown = simulation.shown();
        let panel = Panel::new(Overlays::default(), None);
        let context = context();
        let (control, size) = (Control::new(), vec2(1000.0, 600.0));
        let mut desk = Self { context, control, panel, simulation, shown, size };
        // Sizes are known after the first pictures.
        desk.frame(vec![]);
        desk.frame(vec![]);
        desk
    }

    /// One picture; what it sends is obeyed at once.
    fn frame(&mut self, events: Vec<Event>) -> Vec<Command> {
        let rect = Rect::from_min_size(Pos2::ZERO, self.size);
        let input = RawInput { screen_rect: Some(rect), events, ..RawInput::default() };
        let mut sent = Vec::new();
        let (control, panel, shown) = (&mut self.control, &mut self.panel, &self.shown);
        let output = self.context.run_ui(input, |ui| {
            arrange(ui, shown, control, panel, &mut |c| sent.push(c));
        });
        output.drop_without_applying_deltas();
        for command in &sent {
            self.simulation.obey(command.clone());
        }
        self.shown = self.simulation.shown();
        sent
    }

    fn button(at: Pos2, pressed: bool) -> Event {
        let modifiers = Modifiers::NONE;
        Event::PointerButton { pos: at, button: PointerButton::Primary, pressed, modifiers }
    }
}

/// Where the middle of what is framed is seen, beside the panel.
const MIDDLE: Pos2 = pos2(345.0, 300.0);

#[test]
fn a_drag_over_a_body_pulls_it_and_leaves_the_camera() {
    let mut desk = Desk::new();
    let camera = desk.control.camera;
    desk.frame(vec![Event::PointerMoved(MIDDLE)]);
    desk.frame(vec![Desk::button(MIDDLE, true)]);
    for i in 1..12_u8 {
        desk.frame(vec![Event::PointerMoved(MIDDLE + vec2(f32::from(i) * 8.0, -30.0))]);
    }
    assert!(desk.shown.held.is_some());
    let (from, to) = desk.shown.held.unwrap();
    assert!(to.y > from.y && (to - from).length() > 0.1, "{from:?} {to:?}");
    assert_eq!(desk.control.camera, camera);
    let sent = desk.frame(vec![Desk::button(MIDDLE, false)]);
    assert!(matches!(sent.as_slice(), [.., Command::Release]), "{sent:?}");
    assert!(desk.shown.held.is_none());
}

fn touch(finger: u64, phase: TouchPhase, at: Pos2) -> Event {
    let (device_id, id) = (egui::TouchDeviceId(1), egui::TouchId(finger));
    Event::Touch { device_id, id, phase, pos: at, force: None }
}

/// A finger takes hold of the cube, after two seconds of rest, and pulls it up. As the window has
/// it, each event of the first finger is one of the mouse too.
fn pulled_by_finger() -> (Desk, Pos2) {
    let mut desk = Desk::new();
    let down = touch(1, TouchPhase::Start, MIDDLE);
    desk.frame(vec![down, Event::PointerMoved(MIDDLE), Desk::button(MIDDLE, true)]);
    // Each picture is a sixtieth of a second later.
    for _ in 0..120 {
        desk.frame(vec![]);
    }
    let mut at = MIDDLE;
    for _ in 0..11 {
        at -= vec2(0.0, 10.0);
        desk.frame(vec![touch(1, TouchPhase::Move, at), Event::PointerMoved(at)]);
    }
    (desk, at)
}

#[test]
fn a_finger_pulls_a_body_however_long_it_rested() {
    let (mut desk, at) = pulled_by_finger();
    let (from, to) = desk.shown.held.unwrap();
    assert!(to.y > from.y + 0.1, "{from:?} {to:?}");
    let up = touch(1, TouchPhase::End, at);
    let sent = desk.frame(vec![up, Desk::button(at, false), Event::PointerGone]);
    assert!(sent.iter().any(|c| matches!(c, Command::Release)), "{sent:?}");
    assert!(!sent.iter().any(|c| matches!(c, Command::Pick(..))), "{sent:?}");
}

#[test]
fn a_second_finger_lets_go_and_both_move_the_view() {
    let (mut desk, at) = pulled_by_finger();
    let before = desk.control.camera.unwrap();
    let other = at + vec2(-80.0, 60.0);
    desk.frame(vec![touch(2, TouchPhase::Start, other)]);
    assert!(desk.shown.held.is_none());
    let apart = vec2(30.0, -20.0);
    let moves = [touch(1, TouchPhase::Move, at + apart), touch(2, TouchPhase::Move, other - apart)];
    desk.frame(moves.to_vec());
    let after = desk.control.camera.unwrap();
    assert!(after.distance() < 0.9 * before.distance(), "fingers that part bring it nearer");
}

#[test]
fn a_drag_beside_bodies_turns_the_view() {
    let mut desk = Desk::new();
    let before = desk.control.camera.unwrap();
    let corner = pos2(20.0, 20.0);
    desk.frame(vec![Event::PointerMoved(corner)]);
    desk.frame(vec![Desk::button(corner, true)]);
    for i in 1..12_u8 {
        desk.frame(vec![Event::PointerMoved(corner + vec2(f32::from(i) * 8.0, 0.0))]);
    }
    let after = desk.control.camera.unwrap();
    assert!(desk.shown.held.is_none());
    assert!((after.eye - before.eye).length() > 0.3);
    assert!((after.distance() - before.distance()).abs() < 1.0e-3);
}

#[test]
fn keys_pause_step_and_go_back() {
    let mut desk = Desk::new();
    let mut press = |key| {
        let event = |pressed| Event::Key {
            key,
            physical_key: None,
            pressed,
            repeat: false,
            modifiers: Modifiers::NONE,
        };
        desk.frame(vec![event(true), event(false)]);
        (desk.shown.step, desk.shown.playing)
    };
    assert_eq!(press(Key::ArrowRight), (1, false));
    assert_eq!(press(Key::ArrowRight), (2, false));
    assert_eq!(press(Key::ArrowLeft), (1, false));
    assert_eq!(press(Key::Space), (1, true));
    assert_eq!(press(Key::R), (0, false));
}

#[test]
fn a_click_picks_and_keys_act_on_it() {
    let mut desk = Desk::new();
    let key = |key| Event::Key {
        key,
        physical_key: None,
        pressed: true,
        repeat: false,
        modifiers: Modifiers::NONE,
    };
    desk.frame(vec![Event::PointerMoved(MIDDLE)]);
    desk.frame(vec![Desk::button(MIDDLE, true)]);
    desk.frame(vec![Desk::button(MIDDLE, false)]);
    assert!(desk.shown.picked.as_ref().is_some_and(|p| p.title.contains("cube 0")));
    let dynamic = |desk: &Desk| desk.shown.views[0].counts.dynamic;
    desk.frame(vec![key(Key::D)]);
    assert_eq!(dynamic(&desk), 2);
    desk.frame(vec![key(Key::B)]);
    assert_eq!(dynamic(&desk), 3);
    desk.frame(vec![key(Key::Delete)]);
    assert_eq!((dynamic(&desk), desk.shown.picked.is_none()), (2, true));
    let before = desk.shown.views[0].config.method.name();
    desk.frame(vec![key(Key::V)]);
    desk.frame(vec![key(Key::M)]);
    let names: Vec<_> = desk.shown.views.iter().map(|v| v.config.method.name()).collect();
    assert_eq!(names.len(), 2);
    assert!(names[0] != before && names[1] == before, "{names:?}");
    desk.frame(vec![key(Key::F1)]);
    assert!(desk.panel.help);
    desk.frame(vec![]);
}

#[test]
fn each_half_is_seen_through_its_own_middle() {
    let mut desk = Desk::new();
    desk.simulation.obey(Command::Split(true));
    desk.frame(vec![]);
    desk.frame(vec![]);
    for (side, part) in desk.control.parts.clone().into_iter().enumerate() {
        let at = part.center();
        desk.frame(vec![Event::PointerMoved(at)]);
        desk.frame(vec![Desk::button(at, true)]);
        let sent = desk.frame(vec![Desk::button(at, false)]);
        let picks = |c: &Command| matches!(c, Command::Pick(_, _, s) if *s == side);
        assert!(sent.iter().any(picks), "{sent:?}");
        assert!(desk.shown.picked.as_ref().is_some_and(|p| p.title.contains("cube 0")));
        desk.frame(vec![Event::PointerMoved(pos2(5.0, 5.0))]);
    }
}

#[test]
fn a_window_that_shrinks_closes_its_panel_unless_its_user_opened_it() {
    let mut desk = Desk::new();
    let is_open = |desk: &mut Desk| {
        drop(places::take(&desk.context));
        desk.frame(vec![]);
        places::take(&desk.context).iter().any(|(name, _)| name == "hide")
    };
    assert!(is_open(&mut desk));
    desk.size = vec2(400.0, 300.0);
    assert!(!is_open(&mut desk));
    desk.panel.open = Some(true);
    assert!(is_open(&mut desk));
}

#[test]
fn looking_at_the_panel_changes_no_setting() {
    let mut desk = Desk::new();
    for _ in 0..5 {
        let sent = desk.frame(vec![]);
        assert!(sent.is_empty(), "{sent:?}");
    }
}
