// Shaders of meshes of files with their materials. This source follows scene.wgsl.

struct Material {
    // Linear red, green, blue, opacity.
    base: vec4f,
    // Emitted light; the opacity below which a texel is discarded.
    emissive: vec4f,
    // Metallic, roughness, 1 if the material is unlit, 1 if it has the color of its body.
    surface: vec4f,
    // Scale of the normal texture, strength of the occlusion texture.
    relief: vec4f,
}

@group(2) @binding(0) var<uniform> material: Material;
@group(2) @binding(1) var base_map: texture_2d<f32>;
@group(2) @binding(2) var base_sampler: sampler;
@group(2) @binding(3) var surface_map: texture_2d<f32>;
@group(2) @binding(4) var surface_sampler: sampler;
@group(2) @binding(5) var emissive_map: texture_2d<f32>;
@group(2) @binding(6) var emissive_sampler: sampler;
@group(2) @binding(7) var normal_map: texture_2d<f32>;
@group(2) @binding(8) var normal_sampler: sampler;
@group(2) @binding(9) var occlusion_map: texture_2d<f32>;
@group(2) @binding(10) var occlusion_sampler: sampler;

struct VisualVertex {
    @location(0) place: vec4f,
    @location(1) normal: vec3f,
    @location(2) position: vec4f,
    @location(3) rotation: vec4f,
    @location(4) scale: vec3f,
    @location(5) color: vec4f,
    @location(6) finish: u32,
    @location(7) uv: vec2f,
    @location(8) shade: vec4f,
}

struct VisualPoint {
    @builtin(position) clip: vec4f,
    @location(0) world: vec3f,
    @location(1) normal: vec3f,
    @location(2) uv: vec2f,
    @location(3) shade: vec4f,
    @location(4) @interpolate(flat) color: vec3f,
    @location(5) @interpolate(flat) finish: u32,
}

fn visual_world(in: VisualVertex) -> vec3f {
    return in.position.xyz + rotate(in.rotation, in.place.xyz * in.scale);
}

@vertex
fn visual_vertex(in: VisualVertex) -> VisualPoint {
    var out: VisualPoint;
    out.world = visual_world(in);
    out.clip = frame.view * vec4f(out.world, 1.0);
    out.normal = rotate(in.rotation, in.normal / in.scale);
    out.uv = in.uv;
    out.shade = in.shade;
    out.color = to_linear(in.color.rgb);
    out.finish = in.finish;
    return out;
}

struct VisualShadow {
    @builtin(position) clip: vec4f,
    @location(0) uv: vec2f,
    @location(1) opacity: f32,
}

@vertex
fn visual_shadow_vertex(in: VisualVertex) -> VisualShadow {
    var out: VisualShadow;
    out.clip = frame.light * vec4f(visual_world(in), 1.0);
    out.uv = in.uv;
    out.opacity = in.shade.a;
    return out;
}

@fragment
fn visual_shadow_fragment(in: VisualShadow) {
    let seen = textureSample(base_map, base_sampler, in.uv).a;
    if seen * in.opacity * material.base.a < material.emissive.w {
        discard;
    }
}

const PI: f32 = 3.14159265;
// White in full light is white in the picture, and no brighter.
const EXPOSURE: f32 = 0.72;

// Specular reflection of the sun toward the eye, times pi: GGX for facets, Smith for their
// shadowing, Schlick for their reflectance.
fn mirrored(n: vec3f, v: vec3f, l: vec3f, rough: f32, f0: vec3f) -> vec3f {
    let h = normalize(v + l);
    let nl = max(dot(n, l), 0.0);
    let nv = max(dot(n, v), 1.0e-3);
    let nh = max(dot(n, h), 0.0);
    let vh = max(dot(v, h), 0.0);
    let a = rough * rough;
    let a2 = a * a;
    let d = nh * nh * (a2 - 1.0) + 1.0;
    let facets = a2 / (d * d);
    let hidden = 0.5 / (nl * sqrt(nv * nv * (1.0 - a2) + a2) + nv * sqrt(nl * nl * (1.0 - a2) + a2));
    let fresnel = f0 + (1.0 - f0) * pow(1.0 - vh, 5.0);
    return facets * hidden * nl * fresnel;
}

// Change of the texture coordinates from pixel to pixel, from the surface position and its
// coordinates.
struct Slope {
    across: vec3f,
    down: vec3f,
    uv_across: vec2f,
    uv_down: vec2f,
}

// A unit normal, rotated by the normal texture. Directions along the image come from screen-space
// derivatives, so a mesh needs no tangents.
fn bent(n: vec3f, slope: Slope, texel: vec3f) -> vec3f {
    let down = cross(slope.down, n);
    let across = cross(n, slope.across);
    // Its sign is that of the picture's axes as seen from the normal's side.
    let side = sign(dot(slope.across, down));
    let along_u = side * (down * slope.uv_across.x + across * slope.uv_down.x);
    let along_v = side * (down * slope.uv_across.y + across * slope.uv_down.y);
    let size = inverseSqrt(max(max(dot(along_u, along_u), dot(along_v, along_v)), 1.0e-30));
    let at = (texel * 2.0 - 1.0) * vec3f(material.relief.x, material.relief.x, 1.0);
    // v goes down the image, green up.
    return normalize(n * max(at.z, 0.01) + (along_u * at.x - along_v * at.y) * size);
}

@fragment
fn visual_fragment(in: VisualPoint, @builtin(front_facing) front: bool) -> @location(0) vec4f {
    let surface = textureSample(surface_map, surface_sampler, in.uv);
    let glow = textureSample(emissive_map, emissive_sampler, in.uv).rgb * material.emissive.rgb;
    let texel = textureSample(normal_map, normal_sampler, in.uv).rgb;
    let seen = textureSample(occlusion_map, occlusion_sampler, in.uv).r;
    let slope = Slope(dpdx(in.world), dpdy(in.world), dpdx(in.uv), dpdy(in.uv));
    let base = textureSample(base_map, base_sampler, in.uv) * material.base * in.shade;
    if base.a < material.emissive.w {
        discard;
    }
    var albedo = base.rgb;
    let own = material.surface.w > 0.5;
    if own {
        albedo *= in.color;
    } else if (in.finish & TINT) != 0u {
        albedo = mix(albedo, in.color, 0.75);
    }
    if (in.finish & DIM) != 0u {
        let grey = dot(albedo, vec3f(0.3, 0.5, 0.2));
        albedo = mix(albedo, vec3f(grey), 0.6) * 0.7;
    }
    let face = normalize(in.normal);
    let side = select(-face, face, front);
    var n = side;
    if material.relief.x != 0.0 {
        n = bent(side, slope, texel);
    }
    let to_eye = frame.eye.xyz - in.world;
    let range = length(to_eye);
    let v = to_eye / range;
    let sun = frame.sun.xyz;
    var color = albedo;
    if material.surface.z < 0.5 {
        let facing = clamp(dot(n, sun), 0.0, 1.0);
        var lit = 0.0;
        if facing > 0.0 {
            lit = sunlight(in.world, side, clamp(dot(side, sun), 0.0, 1.0));
        }
        let metallic = material.surface.x * surface.b;
        // A mirror would show the sun as a point too bright for a screen.
        let rough = clamp(material.surface.y * surface.g, 0.08, 1.0);
        let f0 = mix(vec3f(0.04), albedo, metallic);
        // Occlusion affects only ambient light, not the sun.
        let open = 1.0 + material.relief.y * (seen - 1.0);
        let around = ambient_light(n) * open;
        let fill = 0.16 * clamp(dot(n, v), 0.0, 1.0);
        color = albedo * (1.0 - metallic) * (SUN * facing * lit + around + fill);
        color += mirrored(n, v, sun, rough, f0) * SUN * lit;
        // Reflection of the sky, which is blurrier for rougher surfaces.
        let behind = mix(sky(reflect(-v, n)) * open, around, rough);
        let edge = pow(1.0 - clamp(dot(n, v), 0.0, 1.0), 5.0);
        color += (f0 + (max(vec3f(1.0 - rough), f0) - f0) * edge) * behind;
        color = tone(color * EXPOSURE);
    }
    color += glow;
    if (in.finish & HIGHLIGHT) != 0u {
        color = mix(color, vec3f(1.0, 0.75, 0.2), 0.35);
    }
    return vec4f(shown(faded(color, v, range)), select(1.0, base.a, material.emissive.w < 0.0));
}
