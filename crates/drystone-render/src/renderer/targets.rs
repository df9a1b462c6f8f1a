//! The multisampled textures that a picture is drawn on.

use super::SAMPLES;
use super::pipelines::DEPTH_FORMAT;

/// Color and depth with several samples per pixel.
#[derive(Debug)]
pub(super) struct Targets {
    pub(super) size: (u32, u32),
    pub(super) color: wgpu::TextureView,
    pub(super) depth: wgpu::TextureView,
}

impl Targets {
    pub(super) fn new(
        device: &wgpu::Device,
        format: wgpu::TextureFormat,
        size: (u32, u32),
    ) -> Self {
        let texture = |format| {
            let texture = device.create_texture(&wgpu::TextureDescriptor {
                label: Some("samples"),
                size: wgpu::Extent3d { width: size.0, height: size.1, depth_or_array_layers: 1 },
                mip_level_count: 1,
                sample_count: SAMPLES,
                dimension: wgpu::TextureDimension::D2,
                format,
                usage: wgpu::TextureUsages::RENDER_ATTACHMENT,
                view_formats: &[],
            });
            texture.create_view(&wgpu::TextureViewDescriptor::default())
        };
        Self { size, color: texture(format), depth: texture(DEPTH_FORMAT) }
    }
}
