//! The four pipelines: shadows, bodies, sky, lines. `visuals` has the pipelines for meshes of
//! files.

use wgpu::{BlendState, CompareFunction, Face, PrimitiveTopology};

use super::SAMPLES;
use crate::drawing::{Instance, Line};
use crate::form::Vertex;

pub(super) const DEPTH_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Depth32Float;
pub(super) const SHADOW_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Depth32Float;

const VERTEX: [wgpu::VertexAttribute; 2] = wgpu::vertex_attr_array![0 => Float32x4, 1 => Float32x3];
pub(super) const INSTANCE: [wgpu::VertexAttribute; 5] = wgpu::vertex_attr_array![
    2 => Float32x4, 3 => Float32x4, 4 => Float32x3, 5 => Unorm8x4, 6 => Uint32];
const LINE: [wgpu::VertexAttribute; 3] =
    wgpu::vertex_attr_array![0 => Float32x4, 1 => Float32x3, 2 => Unorm8x4];

/// The pipelines and layouts of the device.
#[derive(Debug)]
pub(super) struct Pipelines {
    pub(super) format: wgpu::TextureFormat,
    pub(super) frame_layout: wgpu::BindGroupLayout,
    pub(super) shadow_layout: wgpu::BindGroupLayout,
    pub(super) shadow: wgpu::RenderPipeline,
    pub(super) body: wgpu::RenderPipeline,
    pub(super) sky: wgpu::RenderPipeline,
    pub(super) line: wgpu::RenderPipeline,
}

/// The properties in which the pipelines differ.
#[derive(Clone, Copy)]
pub(super) struct Way<'a> {
    pub(super) label: &'a str,
    pub(super) vertex: &'a str,
    pub(super) fragment: Option<&'a str>,
    pub(super) buffers: &'a [Option<wgpu::VertexBufferLayout<'a>>],
    pub(super) layout: &'a wgpu::PipelineLayout,
    pub(super) topology: PrimitiveTopology,
    pub(super) cull: Option<Face>,
    /// Depth comparison, and whether depths are written.
    pub(super) depth: (CompareFunction, bool),
    pub(super) blend: Option<BlendState>,
    /// Draws depths for shadows, no colors.
    pub(super) in_shadow_map: bool,
}

impl Pipelines {
    pub(super) fn new(device: &wgpu::Device, format: wgpu::TextureFormat) -> Self {
        let module = device.create_shader_module(wgpu::ShaderModuleDescriptor {
            label: Some("scene"),
            source: wgpu::ShaderSource::Wgsl(include_str!("../shaders/scene.wgsl").into()),
        });
        let frame_layout = frame_layout(device);
        let shadow_layout = shadow_layout(device);
        let layout = |groups: &[Option<&wgpu::BindGroupLayout>]| {
            device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
                label: None,
                bind_group_layouts: groups,
                immediate_size: 0,
            })
        };
        let lone = layout(&[Some(&frame_layout)]);
        let both = layout(&[Some(&frame_layout), Some(&shadow_layout)]);
        let bodies = [
            Some(buffer(&VERTEX, size_of::<Vertex>(), wgpu::VertexStepMode::Vertex)),
            Some(buffer(&INSTANCE, size_of::<Instance>(), wgpu::VertexStepMode::Instance)),
        ];
        let lines = [Some(buffer(&LINE, size_of::<Line>(), wgpu::VertexStepMode::Instance))];
        let make = |way: &Way<'_>| pipeline(device, &module, format, way);
        let body = Way {
            label: "bodies",
            vertex: "body_vertex",
            fragment: Some("body_fragment"),
            buffers: &bodies,
            layout: &both,
            topology: PrimitiveTopology::TriangleList,
            // Meshes are visible from both sides.
            cull: None,
            depth: (CompareFunction::Greater, true),
            blend: None,
            in_shadow_map: false,
        };
        let shadow = Way {
            label: "shadows",
            vertex: "shadow_vertex",
            fragment: None,
            layout: &lone,
            depth: (CompareFunction::Less, true),
            in_shadow_map: true,
            ..body
        };
        let sky = Way {
            label: "sky",
            vertex: "sky_vertex",
            fragment: Some("sky_fragment"),
            buffers: &[],
            layout: &both,
            depth: (CompareFunction::GreaterEqual, false),
            ..body
        };
        let line = Way {
            label: "lines",
            vertex: "line_vertex",
            fragment: Some("line_fragment"),
            buffers: &lines,
            layout: &both,
            topology: PrimitiveTopology::TriangleStrip,
            depth: (CompareFunction::Always, false),
            blend: Some(BlendState::ALPHA_BLENDING),
            ..body
        };
        Self {
            format,
            shadow: make(&shadow),
            body: make(&body),
            sky: make(&sky),
            line: make(&line),
            frame_layout,
            shadow_layout,
        }
    }
}

pub(super) fn buffer(
    attributes: &[wgpu::VertexAttribute],
    stride: usize,
    step_mode: wgpu::VertexStepMode,
) -> wgpu::VertexBufferLayout<'_> {
    wgpu::VertexBufferLayout { array_stride: stride as u64, step_mode, attributes }
}

fn frame_layout(device: &wgpu::Device) -> wgpu::BindGroupLayout {
    device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
        label: Some("frame"),
        entries: &[wgpu::BindGroupLayoutEntry {
            binding: 0,
            visibility: wgpu::ShaderStages::VERTEX_FRAGMENT,
            ty: wgpu::BindingType::Buffer {
                ty: wgpu::BufferBindingType::Uniform,
                has_dynamic_offset: false,
                min_binding_size: None,
            },
            count: None,
        }],
    })
}

fn shadow_layout(device: &wgpu::Device) -> wgpu::BindGroupLayout {
    let entry = |binding, ty| wgpu::BindGroupLayoutEntry {
        binding,
        visibility: wgpu::ShaderStages::FRAGMENT,
        ty,
        count: None,
    };
    device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
        label: Some("shadow"),
        entries: &[
            entry(
                0,
                wgpu::BindingType::Texture {
                    sample_type: wgpu::TextureSampleType::Depth,
                    view_dimension: wgpu::TextureViewDimension::D2,
                    multisampled: false,
                },
            ),
            entry(1, wgpu::BindingType::Sampler(wgpu::SamplerBindingType::Comparison)),
        ],
    })
}

pub(super) fn pipeline(
    device: &wgpu::Device,
    module: &wgpu::ShaderModule,
    format: wgpu::TextureFormat,
    way: &Way<'_>,
) -> wgpu::RenderPipeline {
    let (compare, write) = way.depth;
    let targets = [Some(wgpu::ColorTargetState {
        format,
        blend: way.blend,
        write_mask: wgpu::ColorWrites::ALL,
    })];
    let fragment = way.fragment.map(|entry| wgpu::FragmentState {
        module,
        entry_point: Some(entry),
        compilation_options: wgpu::PipelineCompilationOptions::default(),
        targets: if way.in_shadow_map { &[] } else { &targets },
    });
    let (depth, samples) =
        if way.in_shadow_map { (SHADOW_FORMAT, 1) } else { (DEPTH_FORMAT, SAMPLES) };
    device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
        label: Some(way.label),
        layout: Some(way.layout),
        vertex: wgpu::VertexState {
            module,
            entry_point: Some(way.vertex),
            compilation_options: wgpu::PipelineCompilationOptions::default(),
            buffers: way.buffers,
        },
        primitive: wgpu::PrimitiveState {
            topology: way.topology,
            cull_mode: way.cull,
            ..wgpu::PrimitiveState::default()
        },
        depth_stencil: Some(wgpu::DepthStencilState {
            format: depth,
            depth_write_enabled: Some(write),
            depth_compare: Some(compare),
            stencil: wgpu::StencilState::default(),
            bias: wgpu::DepthBiasState::default(),
        }),
        multisample: wgpu::MultisampleState { count: samples, ..wgpu::MultisampleState::default() },
        fragment,
        multiview_mask: None,
        cache: None,
    })
}
