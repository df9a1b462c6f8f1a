//! Meshes of files on the device: their pipelines and materials.

use std::collections::BTreeMap;
use std::sync::Arc;

use bytemuck::{Pod, Zeroable};
use drystone_scene::visual::{Alpha, Texture, VisualMaterial, Visuals, Wrap};
use wgpu::{BlendState, CompareFunction, Face, PrimitiveTopology};

use super::pipelines::{INSTANCE, Pipelines, Way, buffer, pipeline};
use super::texture;
use crate::drawing::Instance;
use crate::form::VisualCorner;

const VERTEX: [wgpu::VertexAttribute; 4] =
    wgpu::vertex_attr_array![0 => Float32x4, 1 => Float32x3, 7 => Float32x2, 8 => Float32x4];

/// Properties of a material that select the pipeline.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Manner {
    pub(super) double_sided: bool,
    /// Transparent: drawn over the objects behind it.
    pub(super) blend: bool,
    /// Texels below the cutoff opacity are discarded.
    pub(super) masked: bool,
}

/// The pipelines for meshes of files.
#[derive(Debug)]
pub(super) struct VisualPipelines {
    material_layout: wgpu::BindGroupLayout,
    shadow: wgpu::RenderPipeline,
    masked_shadow: wgpu::RenderPipeline,
    /// One-sided, two-sided.
    solid: [wgpu::RenderPipeline; 2],
    blended: [wgpu::RenderPipeline; 2],
}

impl VisualPipelines {
    pub(super) fn new(device: &wgpu::Device, plain: &Pipelines) -> Self {
        let source =
            concat!(include_str!("../shaders/scene.wgsl"), include_str!("../shaders/visual.wgsl"));
        let module = device.create_shader_module(wgpu::ShaderModuleDescriptor {
            label: Some("visuals"),
            source: wgpu::ShaderSource::Wgsl(source.into()),
        });
        let material_layout = material_layout(device);
        let layout = |groups: &[Option<&wgpu::BindGroupLayout>]| {
            device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
                label: None,
                bind_group_layouts: groups,
                immediate_size: 0,
            })
        };
        let all = layout(&[
            Some(&plain.frame_layout),
            Some(&plain.shadow_layout),
            Some(&material_layout),
        ]);
        let shaded = layout(&[Some(&plain.frame_layout), None, Some(&material_layout)]);
        let buffers = [
            Some(buffer(&VERTEX, size_of::<VisualCorner>(), wgpu::VertexStepMode::Vertex)),
            Some(buffer(&INSTANCE, size_of::<Instance>(), wgpu::VertexStepMode::Instance)),
        ];
        let solid = Way {
            label: "visuals",
            vertex: "visual_vertex",
            fragment: Some("visual_fragment"),
            buffers: &buffers,
            layout: &all,
            topology: PrimitiveTopology::TriangleList,
            cull: None,
            depth: (CompareFunction::Greater, true),
            blend: None,
            in_shadow_map: false,
        };
        let blended = Way {
            depth: (CompareFunction::Greater, false),
            blend: Some(BlendState::ALPHA_BLENDING),
            ..solid
        };
        let masked_shadow = Way {
            label: "shadows of visuals",
            vertex: "visual_shadow_vertex",
            fragment: Some("visual_shadow_fragment"),
            layout: &shaded,
            depth: (CompareFunction::Less, true),
            in_shadow_map: true,
            ..solid
        };
        let shadow = Way { fragment: None, ..masked_shadow };
        let make = |way: &Way<'_>| pipeline(device, &module, plain.format, way);
        let sides = |way: &Way<'_>| [make(&Way { cull: Some(Face::Back), ..*way }), make(way)];
        Self {
            shadow: make(&shadow),
            masked_shadow: make(&masked_shadow),
            solid: sides(&solid),
            blended: sides(&blended),
            material_layout,
        }
    }

    pub(super) const fn in_picture(&self, manner: Manner) -> &wgpu::RenderPipeline {
        let sides = if manner.blend { &self.blended } else { &self.solid };
        if manner.double_sided { &sides[1] } else { &sides[0] }
    }

    pub(super) const fn in_shadow_map(&self, manner: Manner) -> &wgpu::RenderPipeline {
        if manner.masked { &self.masked_shadow } else { &self.shadow }
    }
}

/// `Material` of the shaders.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C)]
struct Uniform {
    base: [f32; 4],
    emissive: [f32; 4],
    surface: [f32; 4],
    relief: [f32; 4],
}

/// The materials of a file on the device.
#[derive(Debug)]
pub(super) struct LoadedVisuals {
    /// Keeps the visuals alive, so that their address stays unique.
    of: Arc<Visuals>,
    groups: Vec<(Manner, wgpu::BindGroup)>,
    /// For meshes without a material: they take the colors of their bodies.
    plain: (Manner, wgpu::BindGroup),
}

impl LoadedVisuals {
    pub(super) fn new(
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        pipelines: &VisualPipelines,
        visuals: &Arc<Visuals>,
    ) -> Self {
        let white = texture::load(device, queue, &texture::white(), true);
        let mut loaded: BTreeMap<(usize, bool), wgpu::TextureView> = BTreeMap::new();
        for material in &visuals.materials {
            for (texture, srgb) in textures(material) {
                let image = texture.and_then(|t| Some((t.image, visuals.images.get(t.image)?)));
                if let Some((number, image)) = image {
                    loaded
                        .entry((number, srgb))
                        .or_insert_with(|| texture::load(device, queue, image, srgb));
                }
            }
        }
        let group = |material: &VisualMaterial, plain: bool| {
            let found = textures(material).map(|(texture, srgb)| {
                let view = texture.and_then(|t| loaded.get(&(t.image, srgb)));
                (view.unwrap_or(&white), sampler(device, texture))
            });
            let manner = Manner {
                double_sided: plain || material.double_sided,
                blend: material.alpha == Alpha::Blend,
                masked: matches!(material.alpha, Alpha::Mask(_)),
            };
            (manner, group((device, queue), pipelines, material, &found, plain))
        };
        Self {
            of: Arc::clone(visuals),
            groups: visuals.materials.iter().map(|material| group(material, false)).collect(),
            plain: group(&VisualMaterial { roughness: 0.8, ..VisualMaterial::default() }, true),
        }
    }

    /// Whether these are the materials of this file.
    pub(super) fn are_of(&self, visuals: &Arc<Visuals>) -> bool {
        Arc::ptr_eq(&self.of, visuals)
    }

    /// The pipeline and material of a mesh.
    pub(super) fn material(&self, mesh: usize) -> &(Manner, wgpu::BindGroup) {
        let material = self.of.meshes.get(mesh).and_then(|mesh| mesh.material);
        material.and_then(|number| self.groups.get(number)).unwrap_or(&self.plain)
    }
}

/// The textures of a material, and whether their values are colors.
const fn textures(material: &VisualMaterial) -> [(Option<Texture>, bool); 5] {
    [
        (material.base_texture, true),
        (material.surface_texture, false),
        (material.emissive_texture, true),
        (material.normal_texture, false),
        (material.occlusion_texture, false),
    ]
}

fn group(
    (device, queue): (&wgpu::Device, &wgpu::Queue),
    pipelines: &VisualPipelines,
    material: &VisualMaterial,
    textures: &[(&wgpu::TextureView, wgpu::Sampler); 5],
    plain: bool,
) -> wgpu::BindGroup {
    let [r, g, b] = material.emissive;
    // A negative cutoff means that opacity is blended.
    let cutoff = match material.alpha {
        Alpha::Opaque => 0.0,
        Alpha::Mask(cutoff) => cutoff,
        Alpha::Blend => -1.0,
    };
    let surface = [material.metallic, material.roughness, material.unlit.into(), plain.into()];
    // Without its texture the scale has no effect.
    let scale = material.normal_texture.map_or(0.0, |_| material.normal_scale);
    let strength = material.occlusion_texture.map_or(0.0, |_| material.occlusion_strength);
    let relief = [scale, strength, 0.0, 0.0];
    let (base, emissive) = (material.base_color, [r, g, b, cutoff]);
    let uniform = Uniform { base, emissive, surface, relief };
    let bytes: &[u8] = bytemuck::bytes_of(&uniform);
    let uniform = super::filled(device, queue, "material", bytes, wgpu::BufferUsages::UNIFORM);
    let mut entries =
        vec![wgpu::BindGroupEntry { binding: 0, resource: uniform.as_entire_binding() }];
    for (binding, (view, sampler)) in (1..).step_by(2).zip(textures) {
        let resource = wgpu::BindingResource::TextureView(view);
        entries.push(wgpu::BindGroupEntry { binding, resource });
        let resource = wgpu::BindingResource::Sampler(sampler);
        entries.push(wgpu::BindGroupEntry { binding: binding + 1, resource });
    }
    device.create_bind_group(&wgpu::BindGroupDescriptor {
        label: Some("material"),
        layout: &pipelines.material_layout,
        entries: &entries,
    })
}

fn sampler(device: &wgpu::Device, texture: Option<Texture>) -> wgpu::Sampler {
    let mode = |wrap: Wrap| match wrap {
        Wrap::Repeat => wgpu::AddressMode::Repeat,
        Wrap::Mirror => wgpu::AddressMode::MirrorRepeat,
        Wrap::Clamp => wgpu::AddressMode::ClampToEdge,
    };
    let [across, down] = texture.map_or([Wrap::Repeat; 2], |t| t.wrap).map(mode);
    let near = texture.is_some_and(|t| t.nearest);
    device.create_sampler(&wgpu::SamplerDescriptor {
        label: Some("texture"),
        address_mode_u: across,
        address_mode_v: down,
        mag_filter: if near { wgpu::FilterMode::Nearest } else { wgpu::FilterMode::Linear },
        min_filter: wgpu::FilterMode::Linear,
        mipmap_filter: wgpu::MipmapFilterMode::Linear,
        ..wgpu::SamplerDescriptor::default()
    })
}

fn material_layout(device: &wgpu::Device) -> wgpu::BindGroupLayout {
    let entry = |binding, ty| wgpu::BindGroupLayoutEntry {
        binding,
        visibility: wgpu::ShaderStages::FRAGMENT,
        ty,
        count: None,
    };
    let uniform = wgpu::BindingType::Buffer {
        ty: wgpu::BufferBindingType::Uniform,
        has_dynamic_offset: false,
        min_binding_size: None,
    };
    let image = wgpu::BindingType::Texture {
        sample_type: wgpu::TextureSampleType::Float { filterable: true },
        view_dimension: wgpu::TextureViewDimension::D2,
        multisampled: false,
    };
    let sampler = wgpu::BindingType::Sampler(wgpu::SamplerBindingType::Filtering);
    device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
        label: Some("material"),
        entries: &[
            entry(0, uniform),
            entry(1, image),
            entry(2, sampler),
            entry(3, image),
            entry(4, sampler),
            entry(5, image),
            entry(6, sampler),
            entry(7, image),
            entry(8, sampler),
            entry(9, image),
            entry(10, sampler),
        ],
    })
}
