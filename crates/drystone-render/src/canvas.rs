//! A renderer with a picture in memory; it needs no window and no display.

use crate::camera::Camera;
use crate::drawing::Drawing;
use crate::error::RenderError;
use crate::renderer::{Renderer, check_size, limits};

/// A picture: rows from the top, with red, green, blue and opacity (always 255) of each pixel, in
/// sRGB.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Picture {
    /// Width in pixels.
    pub width: u32,
    /// Height in pixels.
    pub height: u32,
    /// Four bytes per pixel.
    pub rgba: Vec<u8>,
}

/// Draws pictures into memory.
#[derive(Debug)]
pub struct Canvas {
    renderer: Renderer,
    name: String,
    texture: wgpu::Texture,
    copy: wgpu::Buffer,
}

const FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Rgba8UnormSrgb;

impl Canvas {
    /// Makes a canvas of this size [px] on the best device of the machine, which may be a software
    /// renderer.
    ///
    /// # Errors
    /// There is no device, or it cannot draw pictures of this size.
    pub fn new(width: u32, height: u32) -> Result<Self, RenderError> {
        Self::within(width, height, limits)
    }

    /// As [`Self::new`], on a device with these limits.
    fn within(
        width: u32,
        height: u32,
        limits: impl Fn(&wgpu::Adapter) -> wgpu::Limits,
    ) -> Result<Self, RenderError> {
        let (adapter, device, queue) = pollster::block_on(open(limits))?;
        check_size(&device, width, height)?;
        let info = adapter.get_info();
        // The renderer comes first because it keeps device errors from ending the program.
        let renderer = Renderer::new(device.clone(), queue, FORMAT);
        let texture = device.create_texture(&wgpu::TextureDescriptor {
            label: Some("canvas"),
            size: wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format: FORMAT,
            usage: wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::COPY_SRC,
            view_formats: &[],
        });
        let copy = device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("copy"),
            size: u64::from(stride(width)) * u64::from(height),
            usage: wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ,
            mapped_at_creation: false,
        });
        renderer.check()?;
        let name = format!("{} ({})", info.name, info.backend);
        Ok(Self { renderer, name, texture, copy })
    }

    /// The device's name.
    #[must_use]
    pub fn device_name(&self) -> &str {
        &self.name
    }

    /// Width and height [px].
    #[must_use]
    pub fn size(&self) -> (u32, u32) {
        (self.texture.width(), self.texture.height())
    }

    /// Draws a picture.
    ///
    /// # Errors
    /// The device failed.
    pub fn draw(&mut self, drawing: &Drawing, camera: &Camera) -> Result<Picture, RenderError> {
        self.order(drawing, camera)?;
        self.read(self.size())
    }

    /// Submits a picture to the device without waiting for it. A picture in a window costs its
    /// program the same.
    ///
    /// # Errors
    /// The device failed.
    pub fn order(&mut self, drawing: &Drawing, camera: &Camera) -> Result<(), RenderError> {
        let size = self.size();
        let view = self.texture.create_view(&wgpu::TextureViewDescriptor::default());
        self.renderer.draw(drawing, camera, &view, size)
    }

    fn read(&self, (width, height): (u32, u32)) -> Result<Picture, RenderError> {
        let (device, queue) = (self.renderer.device(), self.renderer.queue());
        let mut encoder = device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        encoder.copy_texture_to_buffer(
            self.texture.as_image_copy(),
            wgpu::TexelCopyBufferInfo {
                buffer: &self.copy,
                layout: wgpu::TexelCopyBufferLayout {
                    offset: 0,
                    bytes_per_row: Some(stride(width)),
                    rows_per_image: None,
                },
            },
            wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
        );
        queue.submit([encoder.finish()]);
        let (sender, receiver) = std::sync::mpsc::channel();
        self.copy.map_async(wgpu::MapMode::Read, .., move |result| {
            // The receiver waits below.
            let _ = sender.send(result);
        });
        let failed = |why: &dyn std::fmt::Display| RenderError::Device(why.to_string());
        device.poll(wgpu::PollType::wait_indefinitely()).map_err(|e| failed(&e))?;
        self.renderer.check()?;
        receiver.recv().map_err(|e| failed(&e))?.map_err(|e| failed(&e))?;
        let mut rgba = Vec::with_capacity(4 * width as usize * height as usize);
        {
            let mapped = self.copy.get_mapped_range(..).map_err(|e| failed(&e))?;
            for row in mapped.chunks_exact(stride(width) as usize) {
                rgba.extend_from_slice(&row[..4 * width as usize]);
            }
        }
        self.copy.unmap();
        Ok(Picture { width, height, rgba })
    }
}

/// Bytes per row of a copied picture, a multiple of the alignment that devices require.
const fn stride(width: u32) -> u32 {
    (4 * width).next_multiple_of(wgpu::COPY_BYTES_PER_ROW_ALIGNMENT)
}

async fn open(
    limits: impl Fn(&wgpu::Adapter) -> wgpu::Limits,
) -> Result<(wgpu::Adapter, wgpu::Device, wgpu::Queue), RenderError> {
    let instance = wgpu::Instance::new(wgpu::InstanceDescriptor {
        flags: wgpu::InstanceFlags::empty(),
        ..wgpu::InstanceDescriptor::new_without_display_handle()
    });
    let options = wgpu::RequestAdapterOptions {
        power_preference: wgpu::PowerPreference::HighPerformance,
        ..wgpu::RequestAdapterOptions::default()
    };
    let none = |reason: String| RenderError::NoDevice { reason };
    let adapter = instance.request_adapter(&options).await.map_err(|e| none(e.to_string()))?;
    let device = wgpu::DeviceDescriptor {
        label: None,
        required_limits: limits(&adapter),
        ..wgpu::DeviceDescriptor::default()
    };
    let (device, queue) = adapter.request_device(&device).await.map_err(|e| none(e.to_string()))?;
    Ok((adapter, device, queue))
}

#[cfg(test)]
mod tests {
    use super::{Canvas, limits};
    use crate::{Drawing, Look, RenderError, Subject};

    #[test]
    fn a_scene_too_large_for_the_device_is_an_error_and_the_next_one_is_drawn() {
        // Room for 3,800 bodies of 68 bytes.
        let small =
            |adapter: &wgpu::Adapter| wgpu::Limits { max_buffer_size: 1 << 18, ..limits(adapter) };
        let mut canvas = match Canvas::within(64, 64, small) {
            Err(RenderError::NoDevice { reason }) => {
                println!("SKIPPED: {reason}");
                return;
            }
            canvas => canvas.unwrap(),
        };
        let draw = |scene: &str, canvas: &mut Canvas| {
            let running = drystone_scene::named(scene).unwrap().build().unwrap();
            let subject = Subject::of(&running.world);
            let drawing = Drawing::of(&running.world, &subject, &Look::default());
            canvas.draw(&drawing, &subject.camera(subject.angles(), 1.0))
        };
        let hello = draw("hello", &mut canvas).unwrap();
        let why = draw("many_pyramids", &mut canvas).unwrap_err();
        assert!(matches!(&why, RenderError::Device(text) if !text.is_empty()), "{why}");
        canvas.renderer.forget();
        assert_eq!(draw("hello", &mut canvas).unwrap(), hello);
    }
}
