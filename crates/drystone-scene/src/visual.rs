//! The look of bodies and their surroundings, where a file gives one: meshes, materials, images. It
//! does not depend on any graphics.

use std::collections::BTreeMap;

use drystone::Pose;

/// The visible part of a scene, beside or in place of its collision shapes.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Visuals {
    /// All meshes.
    pub meshes: Vec<VisualMesh>,
    /// All materials.
    pub materials: Vec<VisualMaterial>,
    /// All images.
    pub images: Vec<Image>,
    /// Meshes that bodies wear, by the [`drystone::BodyDef::user_data`] that a body has from its
    /// file.
    pub worn: BTreeMap<u64, Vec<PlacedMesh>>,
    /// Meshes that are part of no body; poses in the world.
    pub scenery: Vec<PlacedMesh>,
}

/// A mesh at a place.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PlacedMesh {
    /// Number of the mesh.
    pub mesh: usize,
    /// Where it is [m, frame of the body, or the world].
    pub pose: Pose,
}

/// Triangles of one material.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct VisualMesh {
    /// Corners.
    pub vertices: Vec<VisualVertex>,
    /// Three vertices a triangle, counter-clockwise as seen from its front.
    pub indices: Vec<u32>,
    /// Number of the material; none: as its body is colored.
    pub material: Option<usize>,
}

/// A corner of a triangle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct VisualVertex {
    /// Place [m].
    pub place: [f32; 3],
    /// Direction that the surface faces: unit.
    pub normal: [f32; 3],
    /// Place in the textures: right and down, 0 to 1 over an image.
    pub uv: [f32; 2],
    /// Factor of the material's color: linear red, green, blue, opacity.
    pub color: [f32; 4],
}

/// How a surface reflects light, by metallic and roughness factors.
#[derive(Clone, Debug, PartialEq)]
pub struct VisualMaterial {
    /// Linear red, green, blue, opacity.
    pub base_color: [f32; 4],
    /// Times this one, sRGB.
    pub base_texture: Option<Texture>,
    /// 0 to 1.
    pub metallic: f32,
    /// 0 to 1.
    pub roughness: f32,
    /// Roughness times its green, metallic times its blue, linear.
    pub surface_texture: Option<Texture>,
    /// Where the surface faces beside its normal: red along the image's rows, green up, blue out,
    /// linear.
    pub normal_texture: Option<Texture>,
    /// Factor of its red and green.
    pub normal_scale: f32,
    /// Light from around that reaches the surface: its red, linear.
    pub occlusion_texture: Option<Texture>,
    /// How much of it is followed, 0 to 1.
    pub occlusion_strength: f32,
    /// Light of its own: linear red, green, blue.
    pub emissive: [f32; 3],
    /// Times this one, sRGB.
    pub emissive_texture: Option<Texture>,
    /// The meaning of opacity.
    pub alpha: Alpha,
    /// Seen from behind too.
    pub double_sided: bool,
    /// Its color is shown as it is, whatever light falls on it.
    pub unlit: bool,
}

/// The meaning of a material's opacity.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Alpha {
    /// Nothing.
    #[default]
    Opaque,
    /// Points with an opacity below this are not drawn.
    Mask(f32),
    /// Surfaces behind shine through.
    Blend,
}

/// An image on a surface.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Texture {
    /// Number of the image.
    pub image: usize,
    /// Continuation beyond its edges, right and down.
    pub wrap: [Wrap; 2],
    /// Points are seen as squares where they are large.
    pub nearest: bool,
}

/// Continuation of an image beyond its edges.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Wrap {
    /// The image again.
    #[default]
    Repeat,
    /// The image again, every other one mirrored.
    Mirror,
    /// Its edge.
    Clamp,
}

/// An image: rows from the top, red, green, blue and opacity of each point.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Image {
    /// Points across, at least 1.
    pub width: u32,
    /// Points down, at least 1.
    pub height: u32,
    /// Four bytes a point.
    pub rgba: Vec<u8>,
}

impl Image {
    /// Half as many points on each side, rounded down. `mean` gives the byte in place of four, by
    /// its channel 0 to 3. Bytes that are missing count as 0.
    #[must_use]
    pub fn halved(&self, mean: impl Fn(usize, [u8; 4]) -> u8) -> Self {
        let (width, height) = ((self.width / 2).max(1), (self.height / 2).max(1));
        let byte = |x: u32, y: u32, channel: usize| {
            let x = x.min(self.width.saturating_sub(1)) as usize;
            let y = y.min(self.height.saturating_sub(1)) as usize;
            self.rgba.get(4 * (y * self.width as usize + x) + channel).copied().unwrap_or(0)
        };
        let mut rgba = Vec::with_capacity(4 * width as usize * height as usize);
        for (x, y) in (0..height).flat_map(|y| (0..width).map(move |x| (2 * x, 2 * y))) {
            for channel in 0..4 {
                let corners = [(0, 0), (1, 0), (0, 1), (1, 1)];
                rgba.push(mean(channel, corners.map(|(i, j)| byte(x + i, y + j, channel))));
            }
        }
        Self { width, height, rgba }
    }
}

impl Visuals {
    /// The meshes that a body wears, by its user data.
    #[must_use]
    pub fn of(&self, user_data: u64) -> &[PlacedMesh] {
        self.worn.get(&user_data).map_or(&[], Vec::as_slice)
    }

    /// Whether there is nothing to see.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.worn.is_empty() && self.scenery.is_empty()
    }
}

impl Default for VisualMaterial {
    /// White and rough.
    fn default() -> Self {
        Self {
            base_color: [1.0; 4],
            base_texture: None,
            metallic: 0.0,
            roughness: 1.0,
            surface_texture: None,
            normal_texture: None,
            normal_scale: 1.0,
            occlusion_texture: None,
            occlusion_strength: 1.0,
            emissive: [0.0; 3],
            emissive_texture: None,
            alpha: Alpha::Opaque,
            double_sided: false,
            unlit: false,
        }
    }
}
