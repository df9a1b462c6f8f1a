//! Visuals of several files together.

use crate::visual::{PlacedMesh, Visuals};

/// Adds the visuals of another scene.
pub(super) fn merge(visuals: &mut Visuals, more: &Visuals) {
    let (meshes, materials, images) =
        (visuals.meshes.len(), visuals.materials.len(), visuals.images.len());
    for material in &more.materials {
        let mut material = material.clone();
        let textures = [
            &mut material.base_texture,
            &mut material.surface_texture,
            &mut material.normal_texture,
            &mut material.occlusion_texture,
            &mut material.emissive_texture,
        ];
        textures.into_iter().flatten().for_each(|texture| texture.image += images);
        visuals.materials.push(material);
    }
    for mesh in &more.meshes {
        let mut mesh = mesh.clone();
        mesh.material = mesh.material.map(|material| material + materials);
        visuals.meshes.push(mesh);
    }
    visuals.images.extend(more.images.iter().cloned());
    let placed = |placed: &PlacedMesh| PlacedMesh { mesh: placed.mesh + meshes, ..*placed };
    for (key, worn) in &more.worn {
        visuals.worn.entry(*key).or_default().extend(worn.iter().map(placed));
    }
    visuals.scenery.extend(more.scenery.iter().map(placed));
}
