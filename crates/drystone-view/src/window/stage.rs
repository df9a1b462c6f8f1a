//! The window's surface: the picture below, the panel on it.

use std::sync::Arc;

use drystone_render::wgpu;
use drystone_render::{Area, RenderError, Renderer, limits};
use egui::{Color32, Frame, Id, Rect, Sense, ViewportId};
use web_time::Instant;
use winit::event::{DeviceId, Touch, WindowEvent};
use winit::event_loop::ActiveEventLoop;
use winit::window::{Window, WindowAttributes};

use crate::control::Control;
use crate::error::ViewError;
use crate::overlay::Overlays;
use crate::panel::{Panel, film_bar, help};
use crate::places::{self, Place};
use crate::sim::{Command, Shown};

/// Width of the panel [points of the screen].
const PANEL: f32 = 310.0;

pub(super) struct Stage {
    pub(super) window: Arc<Window>,
    surface: wgpu::Surface<'static>,
    config: wgpu::SurfaceConfiguration,
    renderer: Renderer,
    egui: egui_winit::State,
    painter: egui_wgpu::Renderer,
    control: Control,
    panel: Panel,
    shown: Option<Shown>,
    /// Why the device failed to draw this scene. It is not tried again.
    undrawn: Option<RenderError>,
    title: String,
    places: Vec<Place>,
}

impl Stage {
    /// Opens the window.
    pub(super) fn window(
        events: &ActiveEventLoop,
        attributes: WindowAttributes,
    ) -> Result<Window, ViewError> {
        let none = |reason: String| ViewError::NoDisplay { reason };
        events.create_window(attributes).map_err(|e| none(e.to_string()))
    }

    /// Finds a device that draws on the window.
    pub(super) async fn open(
        window: Window,
        overlays: Overlays,
        panel: Option<bool>,
    ) -> Result<Self, ViewError> {
        let window = Arc::new(window);
        let instance = wgpu::Instance::new(wgpu::InstanceDescriptor {
            flags: wgpu::InstanceFlags::empty(),
            ..wgpu::InstanceDescriptor::new_without_display_handle()
        });
        let no_device = |reason: String| ViewError::Render(RenderError::NoDevice { reason });
        let surface =
            instance.create_surface(Arc::clone(&window)).map_err(|e| no_device(e.to_string()))?;
        let options = wgpu::RequestAdapterOptions {
            power_preference: wgpu::PowerPreference::HighPerformance,
            compatible_surface: Some(&surface),
            ..wgpu::RequestAdapterOptions::default()
        };
        let adapter = instance.request_adapter(&options).await;
        let adapter = adapter.map_err(|e| no_device(e.to_string()))?;
        let device = wgpu::DeviceDescriptor {
            required_limits: limits(&adapter),
            ..wgpu::DeviceDescriptor::default()
        };
        let opened = adapter.request_device(&device).await;
        let (device, queue) = opened.map_err(|e| no_device(e.to_string()))?;
        let size = window.inner_size();
        let mut config = surface
            .get_default_config(&adapter, size.width.max(1), size.height.max(1))
            .ok_or_else(|| no_device("the device cannot draw on this window".to_owned()))?;
        // The panel's colors are blended as they are stored, not as light.
        let plain = config.format.remove_srgb_suffix();
        if surface.get_capabilities(&adapter).formats.contains(&plain) {
            config.format = plain;
        }
        // First of all: it keeps errors of the device from ending the program.
        let renderer = Renderer::new(device.clone(), queue, config.format);
        surface.configure(&device, &config);
        let painter =
            egui_wgpu::Renderer::new(&device, config.format, egui_wgpu::RendererOptions::default());
        let side = device.limits().max_texture_dimension_2d as usize;
        let context = context();
        let mut visuals = egui::Visuals::dark();
        visuals.override_text_color = Some(Color32::from_gray(222));
        context.set_visuals(visuals);
        let scale = egui_winit::pixels_per_point(&context, &window);
        let egui = egui_winit::State::new(
            context,
            ViewportId::ROOT,
            &window,
            Some(scale),
            None,
            Some(side),
        );
        Ok(Self {
            window,
            surface,
            config,
            renderer,
            egui,
            painter,
            control: Control::new(),
            panel: Panel::new(overlays, panel),
            shown: None,
            undrawn: None,
            title: String::new(),
            places: Vec::new(),
        })
    }

    /// Gives `look` what is shown, and the places of everything that can be clicked.
    #[cfg(target_arch = "wasm32")]
    pub(super) fn look<T>(&self, look: impl FnOnce(&Shown, &[Place]) -> T) -> Option<T> {
        self.shown.as_ref().map(|shown| look(shown, &self.places))
    }

    /// Takes over the next picture.
    pub(super) fn learn(&mut self, mut shown: Shown) {
        self.panel.learn(&shown);
        if self.shown.as_ref().is_none_or(|old| old.scene != shown.scene) {
            self.control.camera = None;
            self.undrawn = None;
        }
        if let Some(why) = &self.undrawn {
            tell_undrawn(&mut shown, why);
        }
        let methods: Vec<&str> = shown.views.iter().map(|v| v.config.method.name()).collect();
        let title = format!("{} - {} - drystone", shown.name, methods.join(" | "));
        if title != self.title {
            self.window.set_title(&title);
            self.title = title;
        }
        self.shown = Some(shown);
    }

    /// Takes in an event.
    pub(super) fn take_in(&mut self, event: &WindowEvent) {
        if let WindowEvent::Resized(size) = event {
            let most = self.renderer.device().limits().max_texture_dimension_2d;
            self.config.width = size.width.clamp(1, most);
            self.config.height = size.height.clamp(1, most);
            self.surface.configure(self.renderer.device(), &self.config);
            self.window.request_redraw();
        }
        let together = of_one_screen(event);
        if self.egui.on_window_event(&self.window, together.as_ref().unwrap_or(event)).repaint {
            self.window.request_redraw();
        }
    }

    /// Stops drawing a scene that the device failed to draw, and frees its data. The picture is
    /// black from then on, and a message says why.
    ///
    /// # Errors
    /// It failed without a scene: it will fail again.
    fn give_up(&mut self, why: RenderError) -> Result<(), RenderError> {
        let Some(shown) = self.shown.as_mut().filter(|_| self.undrawn.is_none()) else {
            return Err(why);
        };
        tell_undrawn(shown, &why);
        self.undrawn = Some(why);
        self.renderer.forget();
        self.window.request_redraw();
        Ok(())
    }

    /// Draws; returns when to draw again even if nothing happens.
    #[expect(clippy::iter_over_hash_type, reason = "textures do not depend on each other")]
    pub(super) fn draw(
        &mut self,
        send: &mut dyn FnMut(Command),
    ) -> Result<Option<Instant>, RenderError> {
        if self.window.inner_size().width == 0 {
            // A page's canvas has no size at first. A panel laid out then would take the screen for
            // a vast one, and would open however small the page is. The event with the size
            // redraws.
            return Ok(None);
        }
        let input = self.egui.take_egui_input(&self.window);
        let context = self.egui.egui_ctx().clone();
        let (control, panel, shown) = (&mut self.control, &mut self.panel, self.shown.as_ref());
        let output = context.run_ui(input, |ui| {
            if let Some(shown) = shown {
                arrange(ui, shown, control, panel, send);
            }
        });
        self.places = places::take(&context);
        self.egui.handle_platform_output(&self.window, output.platform_output);
        let wait = output.viewport_output.get(&ViewportId::ROOT).map(|v| v.repaint_delay);
        let scale = output.pixels_per_point;
        let shapes = context.tessellate(output.shapes, scale);
        let mut textures = output.textures_delta;
        let presented = self.present(&shapes, &textures, scale);
        for id in &textures.free {
            self.painter.free_texture(id);
        }
        // egui takes textures that are left in here when it is dropped for forgotten ones.
        textures.clear();
        presented.or_else(|why| self.give_up(why))?;
        Ok(wait.and_then(|wait| Instant::now().checked_add(wait)))
    }

    #[expect(clippy::iter_over_hash_type, reason = "textures do not depend on each other")]
    fn present(
        &mut self,
        shapes: &[egui::ClippedPrimitive],
        textures: &egui::TexturesDelta,
        scale: f32,
    ) -> Result<(), RenderError> {
        let (device, queue) = (self.renderer.device().clone(), self.renderer.queue().clone());
        for (id, deltas) in &textures.set {
            for delta in deltas {
                self.painter.update_texture(&device, &queue, *id, delta);
            }
        }
        let surface = match self.surface.get_current_texture() {
            wgpu::CurrentSurfaceTexture::Success(texture)
            | wgpu::CurrentSurfaceTexture::Suboptimal(texture) => texture,
            wgpu::CurrentSurfaceTexture::Outdated | wgpu::CurrentSurfaceTexture::Lost => {
                self.surface.configure(&device, &self.config);
                self.window.request_redraw();
                return self.renderer.check();
            }
            _ => return self.renderer.check(),
        };
        let view = surface.texture.create_view(&wgpu::TextureViewDescriptor::default());
        let size = (self.config.width, self.config.height);
        let shown = self.shown.as_ref().filter(|_| self.undrawn.is_none());
        let mut load = wgpu::LoadOp::Clear(wgpu::Color::BLACK);
        if let (Some(shown), Some(camera)) = (shown, &self.control.camera) {
            let areas = self.control.parts.iter().map(|part| area(*part, scale));
            let drawings: Vec<_> = shown.views.iter().map(|v| &v.drawing).zip(areas).collect();
            self.renderer.draw_beside(&drawings, camera, &view, size)?;
            load = wgpu::LoadOp::Load;
        }
        let screen = egui_wgpu::ScreenDescriptor {
            size_in_pixels: [size.0, size.1],
            pixels_per_point: scale,
        };
        let mut encoder = device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        let mut commands =
            self.painter.update_buffers(&device, &queue, &mut encoder, shapes, &screen);
        {
            let pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
                label: Some("panel"),
                color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                    view: &view,
                    depth_slice: None,
                    resolve_target: None,
                    ops: wgpu::Operations { load, store: wgpu::StoreOp::Store },
                })],
                ..wgpu::RenderPassDescriptor::default()
            });
            self.painter.render(&mut pass.forget_lifetime(), shapes, &screen);
        }
        commands.push(encoder.finish());
        queue.submit(commands);
        self.window.pre_present_notify();
        queue.present(surface);
        self.renderer.check()
    }
}

/// Has the window say why a scene is not drawn, if it has nothing else to say.
fn tell_undrawn(shown: &mut Shown, why: &RenderError) {
    let message = || format!("this scene is too much to draw, open another one: {why}");
    shown.message.get_or_insert_with(message);
}

/// A finger's event as one of the only screen there is. In a browser each finger counts as a device
/// of its own, and fingers of different devices make no gesture.
fn of_one_screen(event: &WindowEvent) -> Option<WindowEvent> {
    let WindowEvent::Touch(touch) = event else { return None };
    Some(WindowEvent::Touch(Touch { device_id: DeviceId::dummy(), ..*touch }))
}

/// The context that lays out the panel and distinguishes clicks from drags.
fn context() -> egui::Context {
    let context = egui::Context::default();
    // By default a finger that rests longer than a click opens a menu, and can drag nothing from
    // then on. There is no such menu here, and a user who pulls a body rests on it first. A pointer
    // that has moved is a drag, however long it took.
    context.options_mut(|options| options.input_options.max_click_duration = f64::INFINITY);
    context
}

/// Points of the picture from points of the screen.
fn area(part: Rect, scale: f32) -> Area {
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "clamped")]
    let px = |x: f32| (x * scale).round().clamp(0.0, 1.0e6) as u32;
    let (x, y) = (px(part.left()), px(part.top()));
    Area {
        x,
        y,
        width: px(part.right()).saturating_sub(x),
        height: px(part.bottom()).saturating_sub(y),
    }
}

/// The panel at the right, the picture beside it.
fn arrange(
    ui: &mut egui::Ui,
    shown: &Shown,
    control: &mut Control,
    panel: &mut Panel,
    send: &mut dyn FnMut(Command),
) {
    // A line that is left with the return key was still typed in.
    let typing = ui.ctx().egui_wants_keyboard_input();
    let frame = Frame::new().fill(Color32::from_rgb(30, 33, 37));
    let frame = frame.inner_margin(egui::Margin::symmetric(10, 6));
    let width = ui.available_width();
    if panel.open.unwrap_or(width >= 2.0 * PANEL) {
        // The frame's margins and its line come on top.
        let side = egui::Panel::right("panel").resizable(false).exact_size(PANEL.min(width - 24.0));
        side.frame(frame).show(ui, |ui| panel.show(ui, shown, send));
    } else {
        if shown.film.is_some() {
            egui::Panel::bottom("film").frame(frame).show(ui, |ui| film_bar(ui, shown, send));
        }
        panel.corner(ui.ctx(), shown, send);
    }
    let free = ui.available_rect_before_wrap();
    places::note_rect(ui.ctx(), "picture", free);
    let area = ui.interact(free, Id::unique("picture"), Sense::click_and_drag());
    let before = control.parts.len();
    control.divide(free, shown.views.len());
    if let Some(camera) = control.camera.filter(|_| before > 0 && before != control.parts.len()) {
        // Half the width shows the same from farther off.
        control.camera = Some(camera.dollied(if before == 1 { 1.6 } else { 1.0 / 1.6 }));
    }
    if control.camera.is_none() {
        control.frame(&shown.subject);
    }
    control.mouse(ui, &area, shown, send);
    if !typing && !ui.ctx().egui_wants_keyboard_input() {
        control.keys(ui, panel, shown, send);
    }
    if shown.views.len() > 1 {
        for (view, part) in shown.views.iter().zip(&control.parts) {
            let at = part.center_top() + egui::vec2(0.0, 8.0);
            let text = view.config.method.name();
            let font = egui::FontId::proportional(15.0);
            ui.painter().text(at, egui::Align2::CENTER_TOP, text, font, Color32::from_gray(30));
        }
        let middle = free.center().x;
        ui.painter().vline(middle, free.y_range(), egui::Stroke::new(2.0, Color32::from_gray(40)));
    }
    let mut open = panel.help;
    egui::Window::new("keys and mouse").open(&mut open).collapsible(false).show(ui.ctx(), help);
    panel.help = open;
}

#[cfg(test)]
mod tests;
