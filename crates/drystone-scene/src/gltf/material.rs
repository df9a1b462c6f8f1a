//! Materials of meshes, with their textures and images. Broken parts of a material are noted and
//! left out.

use std::collections::BTreeMap;

use super::accessor;
use super::document::{Document, resource};
use super::image::decode;
use crate::error::SceneError;
use crate::file::Kind;
use crate::read::json::At;
use crate::visual::{Alpha, Image, Texture, VisualMaterial, Wrap};

/// Points of all images together; images beyond them are left out.
const MOST_POINTS: u64 = if cfg!(target_arch = "wasm32") { 1 << 24 } else { 1 << 26 };

/// Materials that were read, and the images that they use.
pub(super) struct Materials<'a> {
    document: &'a Document,
    pub(super) list: Vec<VisualMaterial>,
    pub(super) images: Vec<Image>,
    /// Number of a material of the file in the list, and where its textures lie.
    made: BTreeMap<usize, (usize, Option<Mapping>)>,
    /// Number of an image of the file in the list; none if it cannot be shown.
    pictures: BTreeMap<usize, Option<usize>>,
    points: u64,
}

/// Which texture coordinates are used, and how they are moved.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Mapping {
    /// Number of the set.
    pub(super) set: usize,
    offset: [f32; 2],
    /// Sine and cosine of the turn.
    turn: [f32; 2],
    scale: [f32; 2],
}

impl Mapping {
    /// As KHR_texture_transform has it: scaled, turned, then moved. v goes down, so the turn is the
    /// other way around.
    pub(super) fn apply(&self, [u, v]: [f32; 2]) -> [f32; 2] {
        let ([s, c], [x, y]) = (self.turn, [u * self.scale[0], v * self.scale[1]]);
        [c * x + s * y + self.offset[0], c * y - s * x + self.offset[1]]
    }
}

impl<'a> Materials<'a> {
    pub(super) fn new(document: &'a Document) -> Self {
        let (list, images) = (Vec::new(), Vec::new());
        let (made, pictures) = (BTreeMap::new(), BTreeMap::new());
        Self { document, list, images, made, pictures, points: 0 }
    }

    /// The number of the material that a primitive names, and how its textures lie.
    pub(super) fn get(
        &mut self,
        reference: &At<'_>,
        notes: &mut Vec<String>,
    ) -> Result<(usize, Option<Mapping>), SceneError> {
        let root = At::root(&self.document.json);
        let at = root.entry("materials", reference)?;
        let number = reference.size()?;
        if let Some(made) = self.made.get(&number) {
            return Ok(*made);
        }
        let (material, mapping) = self.read(&at, notes);
        self.list.push(material);
        let made = (self.list.len() - 1, mapping);
        self.made.insert(number, made);
        Ok(made)
    }

    fn read(&mut self, at: &At<'_>, notes: &mut Vec<String>) -> (VisualMaterial, Option<Mapping>) {
        let mut mapping = None;
        let mut material = factors(at).unwrap_or_else(|e| {
            notes.push(format!("{e}: a plain material is used"));
            VisualMaterial::default()
        });
        let pbr = at.get("pbrMetallicRoughness");
        let inner = |key: &str| pbr.as_ref().and_then(|pbr| pbr.get(key));
        let mut texture =
            |at, notes: &mut Vec<String>| self.texture_or_note(at, &mut mapping, notes);
        material.base_texture = texture(inner("baseColorTexture"), notes);
        material.surface_texture = texture(inner("metallicRoughnessTexture"), notes);
        material.emissive_texture = texture(at.get("emissiveTexture"), notes);
        material.normal_texture = texture(at.get("normalTexture"), notes);
        // Often it has coordinates of its own: with others it would darken the wrong places.
        let occlusion = at.get("occlusionTexture");
        let (other, fitting) = match (occlusion, mapping) {
            (Some(at), Some(used)) if own_mapping(&at).is_ok_and(|own| own != used) => {
                (Some(at), None)
            }
            (at, _) => (None, at),
        };
        if let Some(other) = other {
            let why = "it has texture coordinates of its own";
            notes.push(format!("{}: not drawn: {why}", other.place()));
        }
        material.occlusion_texture = self.texture_or_note(fitting, &mut mapping, notes);
        (material, mapping)
    }

    /// A texture; none, and a note, if it is broken.
    fn texture_or_note(
        &mut self,
        at: Option<At<'_>>,
        mapping: &mut Option<Mapping>,
        notes: &mut Vec<String>,
    ) -> Option<Texture> {
        let found = self.texture(&at?, mapping, notes);
        found.unwrap_or_else(|e| {
            notes.push(format!("{e}: drawn without this texture"));
            None
        })
    }

    /// A texture; none if its image cannot be shown, which was noted.
    fn texture(
        &mut self,
        at: &At<'_>,
        mapping: &mut Option<Mapping>,
        notes: &mut Vec<String>,
    ) -> Result<Option<Texture>, SceneError> {
        let root = At::root(&self.document.json);
        let own = own_mapping(at)?;
        if *mapping.get_or_insert(own) != own {
            notes.push(format!(
                "{}: its own texture coordinates are not read, those of the material's first texture are used",
                at.place()
            ));
        }
        let texture = root.entry("textures", &at.need("index")?)?;
        let Some(source) = texture.get("source") else {
            return Err(texture.error("names no PNG or JPEG image", "a \"source\""));
        };
        let (mut wrap, mut nearest) = ([Wrap::Repeat; 2], false);
        if let Some(reference) = texture.get("sampler") {
            let sampler = root.entry("samplers", &reference)?;
            for (wrap, key) in wrap.iter_mut().zip(["wrapS", "wrapT"]) {
                let Some(at) = sampler.get(key) else { continue };
                *wrap = match at.size()? {
                    10497 => Wrap::Repeat,
                    33648 => Wrap::Mirror,
                    33071 => Wrap::Clamp,
                    _ => return Err(at.wrong("10497, 33071 or 33648")),
                };
            }
            nearest = sampler.get("magFilter").map_or(Ok(0), |f| f.size())? == 9728;
        }
        let image = self.image(&source, notes)?;
        Ok(image.map(|image| Texture { image, wrap, nearest }))
    }

    fn image(
        &mut self,
        reference: &At<'_>,
        notes: &mut Vec<String>,
    ) -> Result<Option<usize>, SceneError> {
        let root = At::root(&self.document.json);
        let at = root.entry("images", reference)?;
        let number = reference.size()?;
        if let Some(known) = self.pictures.get(&number) {
            return Ok(*known);
        }
        let found = match self.points_of(&at) {
            Ok(image) => {
                self.points += u64::from(image.width) * u64::from(image.height);
                self.images.push(image);
                Some(self.images.len() - 1)
            }
            Err(e) => {
                notes.push(format!("{e}: drawn without it"));
                None
            }
        };
        self.pictures.insert(number, found);
        Ok(found)
    }

    fn points_of(&self, at: &At<'_>) -> Result<Image, SceneError> {
        let allowed = "a PNG or JPEG image";
        let (read, place);
        let bytes = if let Some(uri) = at.get("uri") {
            read = resource(&uri, &self.document.folder, Kind::Image)?;
            place = uri;
            read.as_slice()
        } else {
            place = at.need("bufferView")?;
            accessor::bytes(self.document, &place)?
        };
        let room = MOST_POINTS.saturating_sub(self.points);
        decode(bytes, room).map_err(|problem| place.error(problem, allowed))
    }
}

/// How the coordinates of a texture lie.
fn own_mapping(at: &At<'_>) -> Result<Mapping, SceneError> {
    let number = |at: Option<At<'_>>| at.map(|at| at.size()).transpose();
    let mut set = number(at.get("texCoord"))?.unwrap_or(0);
    let (mut offset, mut turn, mut scale) = ([0.0; 2], 0.0, [1.0; 2]);
    if let Some(moved) = at.dig(&["extensions", "KHR_texture_transform"]) {
        offset = moved.get("offset").map_or(Ok(offset), |at| at.numbers())?;
        scale = moved.get("scale").map_or(Ok(scale), |at| at.numbers())?;
        turn = moved.get("rotation").map_or(Ok(turn), |at| at.f32())?;
        set = number(moved.get("texCoord"))?.unwrap_or(set);
    }
    let (s, c) = drystone::math::trig::sin_cos(turn);
    Ok(Mapping { set, offset, turn: [s, c], scale })
}

/// A material without its textures.
fn factors(at: &At<'_>) -> Result<VisualMaterial, SceneError> {
    let pbr = at.get("pbrMetallicRoughness");
    let inner = |key: &str| pbr.as_ref().and_then(|pbr| pbr.get(key));
    let part = |at: Option<At<'_>>, usual: f32| {
        at.map_or(Ok(usual), |at| at.at_least_zero().map(|x| x.min(1.0)))
    };
    let mut material = VisualMaterial {
        base_color: inner("baseColorFactor").map_or(Ok([1.0; 4]), |at| at.numbers())?,
        metallic: part(inner("metallicFactor"), 1.0)?,
        roughness: part(inner("roughnessFactor"), 1.0)?,
        emissive: at.get("emissiveFactor").map_or(Ok([0.0; 3]), |at| at.numbers())?,
        double_sided: at.flag("doubleSided")?,
        normal_scale: at
            .dig(&["normalTexture", "scale"])
            .map_or(Ok(1.0), |at| at.f32().map(|x| x.clamp(-1.0e3, 1.0e3)))?,
        occlusion_strength: part(at.dig(&["occlusionTexture", "strength"]), 1.0)?,
        unlit: at.dig(&["extensions", "KHR_materials_unlit"]).is_some(),
        ..VisualMaterial::default()
    };
    material.base_color = material.base_color.map(|x| x.clamp(0.0, 1.0));
    if let Some(strength) =
        at.dig(&["extensions", "KHR_materials_emissive_strength", "emissiveStrength"])
    {
        let strength = strength.at_least_zero()?;
        material.emissive = material.emissive.map(|x| x * strength);
    }
    material.emissive = material.emissive.map(|x| x.clamp(0.0, 1.0e3));
    if let Some(mode) = at.get("alphaMode") {
        material.alpha = match mode.text()? {
            "OPAQUE" => Alpha::Opaque,
            "MASK" => Alpha::Mask(part(at.get("alphaCutoff"), 0.5)?),
            "BLEND" => Alpha::Blend,
            _ => return Err(mode.wrong("\"OPAQUE\", \"MASK\" or \"BLEND\"")),
        };
    }
    Ok(material)
}
