//! The window's surface: the picture below, the panel on it.

use std::sync::Arc;
use std::time::Instant;

use drystone_render::wgpu;
use drystone_render::{RenderError, Renderer, limits};
use egui::{Color32, Frame, Id, Rect, Sense, ViewportId};
use winit::event::WindowEvent;
use winit::event_loop::ActiveEventLoop;
use winit::window::Window;

use crate::ViewError;
use crate::control::Control;
use crate::overlay::Overlays;
use crate::panel::Panel;
use crate::sim::{Command, Shown};

/// Width of the panel [points of the screen].
const PANEL: f32 = 250.0;

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
}

impl Stage {
    /// Opens the window.
    pub(super) fn open(
        events: &ActiveEventLoop,
        name: &str,
        overlays: Overlays,
    ) -> Result<Self, ViewError> {
        let attributes = Window::default_attributes()
            .with_title(format!("{name} - drystone"))
            .with_inner_size(winit::dpi::LogicalSize::new(1280.0, 800.0));
        let none = |reason: String| ViewError::NoDisplay { reason };
        let window = events.create_window(attributes).map_err(|e| none(e.to_string()))?;
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
        let adapter = pollster::block_on(instance.request_adapter(&options));
        let adapter = adapter.map_err(|e| no_device(e.to_string()))?;
        let device = wgpu::DeviceDescriptor {
            required_limits: limits(&adapter),
            ..wgpu::DeviceDescriptor::default()
        };
        let (device, queue) = pollster::block_on(adapter.request_device(&device))
            .map_err(|e| no_device(e.to_string()))?;
        let size = window.inner_size();
        let mut config = surface
            .get_default_config(&adapter, size.width.max(1), size.height.max(1))
            .ok_or_else(|| no_device("the device cannot draw on this window".to_owned()))?;
        // The panel's colors are blended as they are stored, not as light.
        let plain = config.format.remove_srgb_suffix();
        if surface.get_capabilities(&adapter).formats.contains(&plain) {
            config.format = plain;
        }
        surface.configure(&device, &config);
        let painter =
            egui_wgpu::Renderer::new(&device, config.format, egui_wgpu::RendererOptions::default());
        let side = device.limits().max_texture_dimension_2d as usize;
        let renderer = Renderer::new(device, queue, config.format);
        let context = egui::Context::default();
        context.set_visuals(egui::Visuals::dark());
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
            panel: Panel::new(overlays),
            shown: None,
        })
    }

    /// Takes over what is to be shown.
    pub(super) fn learn(&mut self, shown: Shown) {
        self.panel.learn(&shown);
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
        if self.egui.on_window_event(&self.window, event).repaint {
            self.window.request_redraw();
        }
    }

    /// Draws; returns when to draw again even if nothing happens.
    pub(super) fn draw(
        &mut self,
        name: &str,
        send: &mut dyn FnMut(Command),
    ) -> Result<Option<Instant>, RenderError> {
        let input = self.egui.take_egui_input(&self.window);
        let context = self.egui.egui_ctx().clone();
        let (control, panel, shown) = (&mut self.control, &mut self.panel, self.shown.as_ref());
        let output = context.run_ui(input, |ui| {
            if let Some(shown) = shown {
                arrange(ui, name, shown, control, panel, send);
            }
        });
        self.egui.handle_platform_output(&self.window, output.platform_output);
        let wait = output.viewport_output.get(&ViewportId::ROOT).map(|v| v.repaint_delay);
        let scale = output.pixels_per_point;
        let shapes = context.tessellate(output.shapes, scale);
        self.present(&shapes, &output.textures_delta, scale)?;
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
        if let (Some(shown), Some(camera)) = (&self.shown, &self.control.camera) {
            self.renderer.draw(&shown.drawing, camera, &view, size)?;
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
                    ops: wgpu::Operations { load: wgpu::LoadOp::Load, store: wgpu::StoreOp::Store },
                })],
                ..wgpu::RenderPassDescriptor::default()
            });
            self.painter.render(&mut pass.forget_lifetime(), shapes, &screen);
        }
        commands.push(encoder.finish());
        queue.submit(commands);
        self.window.pre_present_notify();
        queue.present(surface);
        for id in &textures.free {
            self.painter.free_texture(id);
        }
        self.renderer.check()
    }
}

/// The panel at the right, the picture beside and below it.
fn arrange(
    ui: &mut egui::Ui,
    name: &str,
    shown: &Shown,
    control: &mut Control,
    panel: &mut Panel,
    send: &mut dyn FnMut(Command),
) {
    let picture: Rect = ui.max_rect();
    let back = Frame::new().fill(Color32::from_rgba_unmultiplied(30, 33, 37, 225));
    let frame = back.inner_margin(egui::Margin::symmetric(10, 6));
    egui::Panel::right("panel").resizable(false).exact_size(PANEL).frame(frame).show(ui, |ui| {
        panel.show(ui, name, shown, send);
    });
    let free = ui.available_rect_before_wrap();
    let area = ui.interact(free, Id::unique("picture"), Sense::click_and_drag());
    if control.camera.is_none() {
        control.frame(&shown.subject, picture, PANEL);
    }
    control.mouse(ui, &area, picture, shown, send);
    if !ui.ctx().egui_wants_keyboard_input() && control.keys(ui, shown, send) {
        control.frame(&shown.subject, picture, PANEL);
    }
}
