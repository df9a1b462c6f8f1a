// Shaders of everything except meshes of files. Positions are in meters from `frame`'s origin,
// colors are linear internally.

struct Frame {
    // Transform from world to clip space; depth is reversed: 1 at the near plane, 0 at infinity.
    view: mat4x4f,
    // Transform from world to the shadow map, depth 0 to 1.
    light: mat4x4f,
    // Eye [m]; distance of the near plane [m].
    eye: vec4f,
    // Vector across half the picture at distance 1; width of the picture [px].
    right: vec4f,
    // Vector up half the picture at distance 1; its height [px].
    above: vec4f,
    // Unit vector; size of a shadow map texel [m].
    forward: vec4f,
    // Direction against gravity, unit; radius of the subject [m].
    up: vec4f,
    // Direction toward the sun, unit; width of a grid cell [m].
    sun: vec4f,
    // Distance where fog begins [m], distance over which it grows [m], width of the shadow map
    // [px], and 1 if the target stores values unchanged instead of converting them to sRGB.
    fog: vec4f,
}

@group(0) @binding(0) var<uniform> frame: Frame;
@group(1) @binding(0) var shadow_map: texture_depth_2d;
@group(1) @binding(1) var shadow_sampler: sampler_comparison;

// Bits of `finish`.
const BEVEL: u32 = 1u;
const GRID: u32 = 2u;
const DIM: u32 = 4u;
const HIGHLIGHT: u32 = 8u;
const TINT: u32 = 16u;

struct Vertex {
    // Position in the form's units; -1, 0 or 1: the end of a capsule it belongs to.
    @location(0) place: vec4f,
    @location(1) normal: vec3f,
    // Origin [m]; half the distance between a capsule's ends [m].
    @location(2) position: vec4f,
    @location(3) rotation: vec4f,
    @location(4) scale: vec3f,
    @location(5) color: vec4f,
    @location(6) finish: u32,
}

struct Point {
    @builtin(position) clip: vec4f,
    @location(0) world: vec3f,
    @location(1) normal: vec3f,
    @location(2) local: vec3f,
    @location(3) local_normal: vec3f,
    @location(4) @interpolate(flat) rotation: vec4f,
    @location(5) @interpolate(flat) scale: vec3f,
    @location(6) @interpolate(flat) color: vec3f,
    @location(7) @interpolate(flat) finish: u32,
}

fn rotate(q: vec4f, v: vec3f) -> vec3f {
    let t = 2.0 * cross(q.xyz, v);
    return v + q.w * t + cross(q.xyz, t);
}

fn local_place(in: Vertex) -> vec3f {
    return in.place.xyz * in.scale + vec3f(0.0, in.place.w * in.position.w, 0.0);
}

fn to_linear(c: vec3f) -> vec3f {
    return pow(c, vec3f(2.2));
}

@vertex
fn body_vertex(in: Vertex) -> Point {
    let local = local_place(in);
    let world = in.position.xyz + rotate(in.rotation, local);
    var out: Point;
    out.clip = frame.view * vec4f(world, 1.0);
    out.world = world;
    out.local = local;
    out.local_normal = in.normal / in.scale;
    out.normal = rotate(in.rotation, out.local_normal);
    out.rotation = in.rotation;
    out.scale = in.scale;
    out.color = to_linear(in.color.rgb);
    out.finish = in.finish;
    return out;
}

@vertex
fn shadow_vertex(in: Vertex) -> @builtin(position) vec4f {
    let world = in.position.xyz + rotate(in.rotation, local_place(in));
    return frame.light * vec4f(world, 1.0);
}

const TAPS: i32 = 16;

// Visible fraction of the sun's disc from a surface point, 0 to 1.
fn sunlight(world: vec3f, normal: vec3f, facing: f32) -> f32 {
    let texel = frame.forward.w;
    // A wide sun: its edge blurs over some thousandths of the subject's radius, at least over 2
    // texels.
    let spread = max(2.0, 0.0045 * frame.up.w / texel);
    let p = frame.light * vec4f(world + normal * texel * 1.5, 1.0);
    let uv = p.xy * vec2f(0.5, -0.5) + 0.5;
    if any(uv < vec2f(0.0)) || any(uv > vec2f(1.0)) || p.z > 1.0 {
        return 1.0;
    }
    // Gradient of the surface's own depth over the map: without it a tilted surface would shadow
    // itself.
    let x = vec3f(frame.light[0].x, frame.light[1].x, frame.light[2].x);
    let y = vec3f(frame.light[0].y, frame.light[1].y, frame.light[2].y);
    let z = vec3f(frame.light[0].z, frame.light[1].z, frame.light[2].z);
    let half = 0.5 * texel * frame.fog.z;
    let steep = vec2f(dot(normal, x), -dot(normal, y)) / max(facing, 0.12);
    let slope = steep * (2.0 * half * half * length(z));
    let radius = spread / frame.fog.z;
    let bias = 1.0 * texel * length(z);
    var lit = 0.0;
    for (var i = 0; i < TAPS; i++) {
        // A sunflower pattern covers a disc evenly.
        let angle = f32(i) * 2.39996323;
        let r = sqrt((f32(i) + 0.5) / f32(TAPS)) * radius;
        let at = r * vec2f(cos(angle), sin(angle));
        let depth = p.z + dot(slope, at) - bias;
        lit += textureSampleCompareLevel(shadow_map, shadow_sampler, uv + at, depth);
    }
    return lit / f32(TAPS);
}

// Color of the sky in a direction.
fn sky(direction: vec3f) -> vec3f {
    let height = dot(direction, frame.up.xyz);
    let horizon = vec3f(0.60, 0.68, 0.74);
    let zenith = vec3f(0.20, 0.36, 0.56);
    let below = vec3f(0.50, 0.52, 0.52);
    let up = mix(horizon, zenith, smoothstep(0.0, 0.9, sqrt(max(height, 0.0)) * 0.75));
    return mix(below, up, smoothstep(-0.5, 0.0, height));
}

// A color in the target's format.
fn shown(c: vec3f) -> vec3f {
    return select(c, pow(c, vec3f(1.0 / 2.2)), frame.fog.w > 0.5);
}

// Tone mapping from light to the screen's range: its shoulder keeps bright areas from clipping.
fn tone(c: vec3f) -> vec3f {
    return c * (1.0 + c * 0.12) / (1.0 + c * 0.55);
}

// Light of the sun.
const SUN: vec3f = vec3f(1.62, 1.50, 1.32);

// Ambient light on a surface.
fn ambient_light(n: vec3f) -> vec3f {
    let height = dot(n, frame.up.xyz);
    return mix(vec3f(0.34, 0.31, 0.28), vec3f(0.62, 0.70, 0.80), 0.5 + 0.5 * height);
}

// A color seen through fog; `v` points toward the eye.
fn faded(color: vec3f, v: vec3f, range: f32) -> vec3f {
    let fog = 1.0 - exp(-max(range - frame.fog.x, 0.0) / frame.fog.y);
    let far = sky(-v + frame.up.xyz * max(0.0, dot(v, frame.up.xyz)));
    return mix(color, far, fog);
}

// Strength of grid lines at a point of a plane [cells], antialiased.
fn lines(at: vec2f, width: f32) -> f32 {
    let pixel = max(fwidth(at), vec2f(1.0e-6));
    let off = abs(fract(at - 0.5) - 0.5);
    let line = 1.0 - smoothstep(vec2f(width), vec2f(width) + 1.2 * pixel, off);
    // Where lines are closer than pixels, only their mean remains.
    let fade = 1.0 - smoothstep(vec2f(0.15), vec2f(0.6), pixel);
    let seen = line * fade;
    return max(seen.x, seen.y);
}

fn grid(local: vec3f, n: vec3f) -> f32 {
    let a = abs(n);
    var at = local.xz;
    if a.x > a.y && a.x > a.z {
        at = local.yz;
    } else if a.z > a.y {
        at = local.xy;
    }
    at /= frame.sun.w;
    return max(0.55 * lines(at, 0.004), lines(at * 0.1, 0.0012));
}

// Makes a box's edges look rounded: the normal turns toward the neighboring face.
fn bevel(in: Point, n: vec3f) -> vec4f {
    let least = min(in.scale.x, min(in.scale.y, in.scale.z));
    let inside = max(in.scale - abs(in.local), vec3f(0.0));
    let width = min(0.14 * least, 0.03 * frame.up.w);
    let pixel = length(fwidth(in.local));
    let strength = clamp(width / max(pixel, 1.0e-9) - 0.4, 0.0, 1.0);
    let near = clamp(1.0 - inside / max(width, pixel), vec3f(0.0), vec3f(1.0)) * (1.0 - abs(n));
    let bent = normalize(n + sign(in.local) * near * near * 0.8 * strength);
    let edge = max(near.x, max(near.y, near.z));
    return vec4f(bent, 1.0 - 0.22 * edge * edge);
}

@fragment
fn body_fragment(in: Point, @builtin(front_facing) front: bool) -> @location(0) vec4f {
    let face = normalize(in.normal);
    var n = face;
    var albedo = in.color;
    var open = 1.0;
    let local_normal = normalize(in.local_normal);
    // Derivatives need all four pixels of a quad, so both are always computed.
    let rounded = bevel(in, local_normal);
    let ruled = grid(in.local, local_normal);
    if (in.finish & BEVEL) != 0u {
        n = rotate(in.rotation, rounded.xyz);
        open = rounded.w;
    }
    if (in.finish & GRID) != 0u {
        albedo *= 1.0 - 0.24 * ruled;
    }
    if (in.finish & DIM) != 0u {
        let grey = dot(albedo, vec3f(0.3, 0.5, 0.2));
        albedo = mix(albedo, vec3f(grey), 0.6) * 0.7;
    }
    if !front {
        n = -n;
    }
    let to_eye = frame.eye.xyz - in.world;
    let range = length(to_eye);
    let v = to_eye / range;
    let sun = frame.sun.xyz;
    let facing = clamp(dot(n, sun), 0.0, 1.0);
    var lit = 0.0;
    if facing > 0.0 {
        let side = select(-face, face, front);
        lit = sunlight(in.world, side, clamp(dot(side, sun), 0.0, 1.0));
    }
    let ambient = ambient_light(n);
    // A weak light from behind the camera separates faces in shadow.
    let fill = 0.16 * clamp(dot(n, v), 0.0, 1.0);
    let h = normalize(v + sun);
    let shine = 0.10 * pow(clamp(dot(n, h), 0.0, 1.0), 40.0) * facing;
    let rim = 0.10 * pow(1.0 - clamp(dot(n, v), 0.0, 1.0), 4.0);
    let matte = select(1.0, 0.0, (in.finish & GRID) != 0u);
    var color = albedo * (SUN * facing * lit + (ambient + fill) * open);
    color += matte * (SUN * shine * lit + ambient * rim * 0.6);
    if (in.finish & HIGHLIGHT) != 0u {
        color = mix(color, vec3f(1.0, 0.75, 0.2), 0.35);
    }
    return vec4f(shown(faded(tone(color), v, range)), 1.0);
}

struct SkyPoint {
    @builtin(position) clip: vec4f,
    @location(0) direction: vec3f,
}

@vertex
fn sky_vertex(@builtin(vertex_index) i: u32) -> SkyPoint {
    let at = vec2f(f32(i32(i & 1u) * 4 - 1), f32(i32(i >> 1u) * 4 - 1));
    var out: SkyPoint;
    out.clip = vec4f(at, 0.0, 1.0);
    out.direction = frame.forward.xyz + at.x * frame.right.xyz + at.y * frame.above.xyz;
    return out;
}

@fragment
fn sky_fragment(in: SkyPoint) -> @location(0) vec4f {
    return vec4f(shown(sky(normalize(in.direction))), 1.0);
}

struct LinePoint {
    @builtin(position) clip: vec4f,
    @location(0) color: vec4f,
}

// A segment from `a` to `b`, `a.w` pixels wide, drawn over everything else.
@vertex
fn line_vertex(
    @builtin(vertex_index) i: u32,
    @location(0) a: vec4f,
    @location(1) b: vec3f,
    @location(2) color: vec4f,
) -> LinePoint {
    let near = frame.eye.w;
    var start = frame.view * vec4f(a.xyz, 1.0);
    var end = frame.view * vec4f(b, 1.0);
    // A point behind the eye has no position in the picture.
    if start.w < near {
        start = mix(start, end, clamp((near - start.w) / max(end.w - start.w, 1.0e-9), 0.0, 1.0));
    }
    if end.w < near {
        end = mix(end, start, clamp((near - end.w) / max(start.w - end.w, 1.0e-9), 0.0, 1.0));
    }
    let size = vec2f(frame.right.w, frame.above.w);
    let along = (end.xy / end.w - start.xy / start.w) * size;
    let size_of = max(length(along), 1.0e-6);
    let across = vec2f(-along.y, along.x) / size_of / size;
    let ahead = along / size_of / size;
    let last = (i & 1u) == 1u;
    let side = select(-1.0, 1.0, (i >> 1u) == 1u);
    let point = select(start, end, last);
    let cap = select(-0.5, 0.5, last);
    var out: LinePoint;
    out.clip = vec4f(point.xy + (across * side + ahead * cap) * a.w * point.w, point.z, point.w);
    out.color = vec4f(to_linear(color.rgb), color.a);
    return out;
}

@fragment
fn line_fragment(in: LinePoint) -> @location(0) vec4f {
    return vec4f(shown(in.color.rgb), in.color.a);
}
