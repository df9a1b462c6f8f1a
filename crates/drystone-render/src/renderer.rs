//! Draws on the graphics device: shadows first, then bodies, sky and lines.

mod frame;
mod pipelines;
mod targets;
mod texture;
mod visuals;

use std::collections::BTreeMap;
use std::ops::Range;
use std::sync::{Arc, Mutex, PoisonError};

use drystone::Vec3;

use self::frame::Frame;
use self::pipelines::{Pipelines, SHADOW_FORMAT};
use self::targets::Targets;
use self::visuals::{LoadedVisuals, Manner, VisualPipelines};
use crate::camera::Camera;
use crate::drawing::{Batch, Drawing, Instance, Line};
use crate::error::RenderError;
use crate::form::Form;

/// Width of the shadow map [px]; smaller in a browser, which may draw in software or on a phone.
const SHADOW_SIZE: u32 = if cfg!(target_arch = "wasm32") { 2048 } else { 4096 };
/// Maximum number of pixels of a picture. With its samples, such a picture takes 2 GiB.
const MOST_POINTS: u64 = 1 << 26;
/// Samples per pixel.
pub(crate) const SAMPLES: u32 = 4;

/// The limits that a renderer requires of a graphics device: those of a browser with WebGL 2, with
/// the device's own limits on textures and buffers.
#[must_use]
pub fn limits(adapter: &wgpu::Adapter) -> wgpu::Limits {
    let most = adapter.limits();
    let max_buffer_size = most.max_buffer_size;
    let usual = wgpu::Limits::downlevel_webgl2_defaults().using_resolution(most);
    wgpu::Limits { max_buffer_size, ..usual }
}

/// A part of a picture [px].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Area {
    /// Distance from the left.
    pub x: u32,
    /// Distance from the top.
    pub y: u32,
    /// Width in pixels.
    pub width: u32,
    /// Height in pixels.
    pub height: u32,
}

impl Area {
    /// The part of this area inside a picture of this size, at least one pixel.
    fn within(self, width: u32, height: u32) -> Self {
        let (x, y) = (self.x.min(width - 1), self.y.min(height - 1));
        let (across, down) = (self.width.min(width - x).max(1), self.height.min(height - y).max(1));
        Self { x, y, width: across, height: down }
    }
}

/// A form on the device.
#[derive(Debug)]
struct LoadedForm {
    /// Keeps the form alive, so that its address stays unique while it is a key.
    _form: Form,
    vertices: wgpu::Buffer,
    indices: wgpu::Buffer,
    count: u32,
}

/// Draws drawings on textures.
#[derive(Debug)]
pub struct Renderer {
    device: wgpu::Device,
    queue: wgpu::Queue,
    pipelines: Pipelines,
    shadow: wgpu::TextureView,
    uniform: wgpu::Buffer,
    frame_group: wgpu::BindGroup,
    shadow_group: wgpu::BindGroup,
    instances: wgpu::Buffer,
    lines: wgpu::Buffer,
    forms: BTreeMap<[usize; 3], LoadedForm>,
    /// Made when the first mesh of a file is drawn.
    visual_pipelines: Option<VisualPipelines>,
    visuals: Option<LoadedVisuals>,
    targets: Option<Targets>,
    encode: bool,
    failure: Arc<Mutex<Option<String>>>,
}

impl Renderer {
    /// A renderer on a device, for textures of this format.
    #[must_use]
    pub fn new(device: wgpu::Device, queue: wgpu::Queue, format: wgpu::TextureFormat) -> Self {
        let failure = Arc::new(Mutex::new(None));
        let seen = Arc::clone(&failure);
        // By default, an error of the device would end the program.
        device.on_uncaptured_error(Arc::new(move |error: wgpu::Error| {
            let mut first = seen.lock().unwrap_or_else(PoisonError::into_inner);
            first.get_or_insert_with(|| error.to_string());
        }));
        let pipelines = Pipelines::new(&device, format);
        let shadow = shadow_map(&device);
        let uniform = device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("frame"),
            size: size_of::<Frame>() as u64,
            usage: wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        let sampler = device.create_sampler(&wgpu::SamplerDescriptor {
            label: Some("shadow"),
            mag_filter: wgpu::FilterMode::Linear,
            min_filter: wgpu::FilterMode::Linear,
            compare: Some(wgpu::CompareFunction::LessEqual),
            ..wgpu::SamplerDescriptor::default()
        });
        let frame_group = device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("frame"),
            layout: &pipelines.frame_layout,
            entries: &[wgpu::BindGroupEntry { binding: 0, resource: uniform.as_entire_binding() }],
        });
        let shadow_group = device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("shadow"),
            layout: &pipelines.shadow_layout,
            entries: &[
                wgpu::BindGroupEntry {
                    binding: 0,
                    resource: wgpu::BindingResource::TextureView(&shadow),
                },
                wgpu::BindGroupEntry {
                    binding: 1,
                    resource: wgpu::BindingResource::Sampler(&sampler),
                },
            ],
        });
        let (instances, lines) = small_buffers(&device);
        Self {
            device,
            queue,
            pipelines,
            shadow,
            uniform,
            frame_group,
            shadow_group,
            instances,
            lines,
            forms: BTreeMap::new(),
            visual_pipelines: None,
            visuals: None,
            targets: None,
            encode: !format.is_srgb(),
            failure,
        }
    }

    /// The device it draws on.
    #[must_use]
    pub const fn device(&self) -> &wgpu::Device {
        &self.device
    }

    /// The queue it draws on.
    #[must_use]
    pub const fn queue(&self) -> &wgpu::Queue {
        &self.queue
    }

    /// Draws on a texture of this size [px], which must have the format the renderer was made for.
    ///
    /// # Errors
    /// Fails if the device cannot draw this size, or if it failed since the last call.
    pub fn draw(
        &mut self,
        drawing: &Drawing,
        camera: &Camera,
        target: &wgpu::TextureView,
        size: (u32, u32),
    ) -> Result<(), RenderError> {
        let all = Area { x: 0, y: 0, width: size.0, height: size.1 };
        self.draw_beside(&[(drawing, all)], camera, target, size)
    }

    /// Draws several drawings from one camera on a texture, each in its own area. Pixels outside
    /// all areas are black.
    ///
    /// # Errors
    /// As for [`Self::draw`].
    pub fn draw_beside(
        &mut self,
        drawings: &[(&Drawing, Area)],
        camera: &Camera,
        target: &wgpu::TextureView,
        (width, height): (u32, u32),
    ) -> Result<(), RenderError> {
        check_size(&self.device, width, height)?;
        let format = self.pipelines.format;
        if self.targets.as_ref().is_none_or(|t| t.size != (width, height)) {
            self.targets = Some(Targets::new(&self.device, format, (width, height)));
        }
        for (number, (drawing, area)) in drawings.iter().enumerate() {
            let area = area.within(width, height);
            let drawing = &*drawing.seen_from(camera.eye);
            self.load(drawing);
            let frame =
                Frame::new(drawing, camera, (area.width, area.height), SHADOW_SIZE, self.encode);
            self.queue.write_buffer(&self.uniform, 0, bytemuck::bytes_of(&frame));

            let mut encoder =
                self.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
            self.draw_shadows(&mut encoder, drawing);
            if let Some(targets) = &self.targets {
                let last = number + 1 == drawings.len();
                let target = last.then_some(target);
                // Eye of this drawing, and whether it is the first area.
                let eye = (number == 0, camera.eye - drawing.origin);
                self.draw_picture(&mut encoder, drawing, targets, target, area, eye);
            }
            self.queue.submit([encoder.finish()]);
        }
        self.check()
    }

    /// Releases everything on the device that belongs to the last drawing. This makes room for
    /// another drawing after one that exceeded the device's memory.
    pub fn forget(&mut self) {
        self.forms.clear();
        self.visuals = None;
        self.targets = None;
        (self.instances, self.lines) = small_buffers(&self.device);
    }

    /// The first failure of the device since the last call.
    ///
    /// # Errors
    /// Returns that failure.
    pub fn check(&self) -> Result<(), RenderError> {
        let mut failure = self.failure.lock().unwrap_or_else(PoisonError::into_inner);
        failure.take().map_or(Ok(()), |why| Err(RenderError::Device(why)))
    }

    /// Uploads the forms of the drawing, and releases all others.
    fn load(&mut self, drawing: &Drawing) {
        let mut forms = BTreeMap::new();
        for batch in &drawing.batches {
            let key = batch.form.key();
            let kept = self.forms.remove(&key);
            forms.insert(
                key,
                kept.unwrap_or_else(|| load_form(&self.device, &self.queue, &batch.form)),
            );
        }
        self.forms = forms;
        self.load_visuals(drawing);
        let count: usize = drawing.batches.iter().map(|b| b.instances.len()).sum();
        grow(&self.device, &mut self.instances, count * size_of::<Instance>());
        let mut at = 0;
        for batch in &drawing.batches {
            let bytes: &[u8] = bytemuck::cast_slice(&batch.instances);
            self.queue.write_buffer(&self.instances, at, bytes);
            at += bytes.len() as u64;
        }
        let bytes: &[u8] = bytemuck::cast_slice::<Line, u8>(&drawing.lines);
        grow(&self.device, &mut self.lines, bytes.len());
        self.queue.write_buffer(&self.lines, 0, bytes);
    }

    /// Uploads the materials of the drawing's file, and releases those of another file.
    fn load_visuals(&mut self, drawing: &Drawing) {
        let of = drawing.batches.iter().find_map(|batch| match &batch.form {
            Form::Visual(visuals, _) => Some(visuals),
            _ => None,
        });
        let Some(visuals) = of else { return };
        if self.visuals.as_ref().is_some_and(|loaded| loaded.are_of(visuals)) {
            return;
        }
        let (device, plain) = (&self.device, &self.pipelines);
        let pipelines =
            self.visual_pipelines.get_or_insert_with(|| VisualPipelines::new(device, plain));
        self.visuals = Some(LoadedVisuals::new(device, &self.queue, pipelines, visuals));
    }

    fn draw_shadows(&self, encoder: &mut wgpu::CommandEncoder, drawing: &Drawing) {
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("shadows"),
            depth_stencil_attachment: Some(depth(&self.shadow, 1.0, wgpu::StoreOp::Store)),
            ..wgpu::RenderPassDescriptor::default()
        });
        pass.set_pipeline(&self.pipelines.shadow);
        pass.set_bind_group(0, &self.frame_group, &[]);
        // The ground casts no shadow.
        self.draw_batches(&mut pass, drawing, |batch| !matches!(batch.form, Form::Square));
        self.draw_visuals(&mut pass, drawing, |pipelines, manner| {
            (!manner.blend).then(|| pipelines.in_shadow_map(manner))
        });
    }

    fn draw_picture(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        drawing: &Drawing,
        targets: &Targets,
        target: Option<&wgpu::TextureView>,
        area: Area,
        (first, eye): (bool, Vec3),
    ) {
        let color = wgpu::RenderPassColorAttachment {
            view: &targets.color,
            depth_slice: None,
            resolve_target: target,
            ops: wgpu::Operations {
                load: if first {
                    wgpu::LoadOp::Clear(wgpu::Color::BLACK)
                } else {
                    wgpu::LoadOp::Load
                },
                // Samples are kept for the next area; the last one resolves them all.
                store: if target.is_some() { wgpu::StoreOp::Discard } else { wgpu::StoreOp::Store },
            },
        };
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("picture"),
            color_attachments: &[Some(color)],
            depth_stencil_attachment: Some(depth(&targets.depth, 0.0, wgpu::StoreOp::Discard)),
            ..wgpu::RenderPassDescriptor::default()
        });
        #[expect(clippy::cast_precision_loss, reason = "sizes of pictures are far below 2^24")]
        let [x, y, width, height] = [area.x, area.y, area.width, area.height].map(|n| n as f32);
        pass.set_viewport(x, y, width, height, 0.0, 1.0);
        pass.set_scissor_rect(area.x, area.y, area.width, area.height);
        pass.set_bind_group(0, &self.frame_group, &[]);
        pass.set_bind_group(1, &self.shadow_group, &[]);
        pass.set_pipeline(&self.pipelines.body);
        self.draw_batches(&mut pass, drawing, |_| true);
        self.draw_visuals(&mut pass, drawing, |pipelines, manner| {
            (!manner.blend).then(|| pipelines.in_picture(manner))
        });
        pass.set_pipeline(&self.pipelines.sky);
        pass.draw(0..3, 0..1);
        self.draw_blended(&mut pass, drawing, eye);
        if !drawing.lines.is_empty() {
            pass.set_pipeline(&self.pipelines.line);
            pass.set_vertex_buffer(0, self.lines.slice(..));
            pass.draw(0..4, 0..count_of(drawing.lines.len()));
        }
    }

    fn draw_batches(
        &self,
        pass: &mut wgpu::RenderPass<'_>,
        drawing: &Drawing,
        wanted: impl Fn(&Batch) -> bool,
    ) {
        pass.set_vertex_buffer(1, self.instances.slice(..));
        for (batch, instances) in numbered(drawing) {
            if !matches!(batch.form, Form::Visual(..)) && wanted(batch) {
                self.draw_form(pass, batch, instances);
            }
        }
    }

    /// Draws the meshes of a file, each with the pipeline that `wanted` returns for it.
    fn draw_visuals<'a>(
        &'a self,
        pass: &mut wgpu::RenderPass<'_>,
        drawing: &Drawing,
        wanted: impl Fn(&'a VisualPipelines, Manner) -> Option<&'a wgpu::RenderPipeline>,
    ) {
        let (Some(pipelines), Some(visuals)) = (&self.visual_pipelines, &self.visuals) else {
            return;
        };
        for (batch, instances) in numbered(drawing) {
            let Form::Visual(_, mesh) = batch.form else { continue };
            let (manner, group) = visuals.material(mesh);
            let Some(pipeline) = wanted(pipelines, *manner) else { continue };
            pass.set_pipeline(pipeline);
            pass.set_bind_group(2, group, &[]);
            self.draw_form(pass, batch, instances);
        }
    }

    /// Draws transparent meshes, the farthest first.
    fn draw_blended(&self, pass: &mut wgpu::RenderPass<'_>, drawing: &Drawing, eye: Vec3) {
        let (Some(pipelines), Some(visuals)) = (&self.visual_pipelines, &self.visuals) else {
            return;
        };
        let mut all = Vec::new();
        for (batch, instances) in numbered(drawing) {
            let Form::Visual(_, mesh) = batch.form else { continue };
            let (manner, group) = visuals.material(mesh);
            if manner.blend {
                for (number, instance) in instances.zip(&batch.instances) {
                    let distance = (Vec3::from(instance.position) - eye).length_squared();
                    all.push((distance, number, batch, manner, group));
                }
            }
        }
        all.sort_by(|a, b| b.0.total_cmp(&a.0));
        for (_, number, batch, manner, group) in all {
            pass.set_pipeline(pipelines.in_picture(*manner));
            pass.set_bind_group(2, group, &[]);
            self.draw_form(pass, batch, number..number + 1);
        }
    }

    fn draw_form(&self, pass: &mut wgpu::RenderPass<'_>, batch: &Batch, instances: Range<u32>) {
        let form = self.forms.get(&batch.form.key());
        if let Some(form) = form.filter(|form| form.count > 0) {
            pass.set_vertex_buffer(0, form.vertices.slice(..));
            pass.set_index_buffer(form.indices.slice(..), wgpu::IndexFormat::Uint32);
            pass.draw_indexed(0..form.count, 0, instances);
        }
    }
}

/// The batches of a drawing, with the range of their instances among all instances.
fn numbered(drawing: &Drawing) -> impl Iterator<Item = (&Batch, Range<u32>)> {
    drawing.batches.iter().scan(0, |first, batch| {
        let instances = *first..*first + count_of(batch.instances.len());
        *first = instances.end;
        Some((batch, instances))
    })
}

/// Whether the device can draw a picture of this size.
pub(crate) fn check_size(
    device: &wgpu::Device,
    width: u32,
    height: u32,
) -> Result<(), RenderError> {
    let limits = device.limits();
    let most = limits.max_texture_dimension_2d;
    // Four bytes per pixel; rows of a copy are padded to 256 bytes.
    let points = MOST_POINTS.min(limits.max_buffer_size / 4);
    let asked = u64::from(width).next_multiple_of(64) * u64::from(height);
    if (1..=most).contains(&width) && (1..=most).contains(&height) && asked <= points {
        Ok(())
    } else {
        Err(RenderError::Size { width, height, most, points })
    }
}

fn load_form(device: &wgpu::Device, queue: &wgpu::Queue, form: &Form) -> LoadedForm {
    let (vertices, indices) = form.bytes();
    LoadedForm {
        vertices: filled(device, queue, "form", &vertices, wgpu::BufferUsages::VERTEX),
        indices: filled(
            device,
            queue,
            "form",
            bytemuck::cast_slice(&indices),
            wgpu::BufferUsages::INDEX,
        ),
        count: count_of(indices.len()),
        _form: form.clone(),
    }
}

/// A buffer with these bytes. It is not mapped: if the device is out of memory, a mapped buffer has
/// no memory to write to, which ends the program.
fn filled(
    device: &wgpu::Device,
    queue: &wgpu::Queue,
    label: &str,
    bytes: &[u8],
    usage: wgpu::BufferUsages,
) -> wgpu::Buffer {
    let buffer = device.create_buffer(&wgpu::BufferDescriptor {
        label: Some(label),
        // A buffer cannot be empty.
        size: (bytes.len() as u64).max(4),
        usage: usage | wgpu::BufferUsages::COPY_DST,
        mapped_at_creation: false,
    });
    queue.write_buffer(&buffer, 0, bytes);
    buffer
}

fn count_of(n: usize) -> u32 {
    u32::try_from(n).unwrap_or(u32::MAX)
}

fn vertex_buffer(device: &wgpu::Device, size: u64) -> wgpu::Buffer {
    device.create_buffer(&wgpu::BufferDescriptor {
        label: Some("places"),
        size,
        usage: wgpu::BufferUsages::VERTEX | wgpu::BufferUsages::COPY_DST,
        mapped_at_creation: false,
    })
}

/// Makes room for `bytes`; the old content is lost when the buffer grows.
fn grow(device: &wgpu::Device, buffer: &mut wgpu::Buffer, bytes: usize) {
    let needed = bytes as u64;
    if buffer.size() < needed {
        let most = device.limits().max_buffer_size;
        *buffer = vertex_buffer(device, needed.next_power_of_two().min(most).max(needed));
    }
}

/// Buffers for the instances of bodies and for lines.
fn small_buffers(device: &wgpu::Device) -> (wgpu::Buffer, wgpu::Buffer) {
    (vertex_buffer(device, 1 << 12), vertex_buffer(device, 1 << 10))
}

fn shadow_map(device: &wgpu::Device) -> wgpu::TextureView {
    let size = wgpu::Extent3d { width: SHADOW_SIZE, height: SHADOW_SIZE, depth_or_array_layers: 1 };
    let texture = device.create_texture(&wgpu::TextureDescriptor {
        label: Some("shadow"),
        size,
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format: SHADOW_FORMAT,
        usage: wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::TEXTURE_BINDING,
        view_formats: &[],
    });
    texture.create_view(&wgpu::TextureViewDescriptor::default())
}

fn depth(
    view: &wgpu::TextureView,
    clear: f32,
    store: wgpu::StoreOp,
) -> wgpu::RenderPassDepthStencilAttachment<'_> {
    wgpu::RenderPassDepthStencilAttachment {
        view,
        depth_ops: Some(wgpu::Operations { load: wgpu::LoadOp::Clear(clear), store }),
        stencil_ops: None,
    }
}
