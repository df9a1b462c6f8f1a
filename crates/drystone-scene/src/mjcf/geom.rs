//! Geoms: shapes, surfaces, and which of them collide.

use core::f32::consts::{FRAC_PI_2, PI};
use drystone::contact::Combine;
use drystone::geometry::MassProperties;
use drystone::math::trig;
use drystone::{Filter, Material, Pose, Quat, Shape, ShapeDef, Vec3, vec3};

use super::defaults::View;
use super::mass;
use super::mesh::Meshes;
use super::model::Model;
use crate::error::SceneError;
use crate::links::Link;
use crate::read::mesh::hull_of_points;

/// A shape, or why it is left out; with its mass, and a note.
pub(super) struct Geom {
    pub(super) shape: Result<ShapeDef, String>,
    /// Its mass, which is about the pose [frame of the body]; `None`: it counts for nothing.
    pub(super) mass: Option<(Pose, MassProperties)>,
    pub(super) note: Option<String>,
}

impl Geom {
    fn left_out(why: impl Into<String>) -> Self {
        Self { shape: Err(why.into()), mass: None, note: None }
    }
}

/// A geom in the frame of its body.
pub(super) fn read<'a>(
    view: &View<'a>,
    model: &Model<'a>,
    meshes: &mut Meshes<'a>,
) -> Result<Geom, SceneError> {
    let named = view.get("type");
    let kind = named.unwrap_or(if view.get("mesh").is_some() { "mesh" } else { "sphere" });
    let is_skin = flag(view, "shellinertia")?;
    let mut note = None;
    // At a density of 1.
    let mut weight = None;
    let (shape, pose) = match kind {
        "plane" => (Shape::half_space([0.0, 0.0, 1.0], 0.0), model.pose(view)?),
        "sphere" | "capsule" | "cylinder" | "box" | "ellipsoid" => {
            let (half, pose) = match (view.get("mesh"), meshes.named(view, model)?) {
                (None, _) => extents(view, model, kind)?,
                (Some(_), Ok(mesh)) => {
                    let scale = view.number("fitscale")?.unwrap_or(1.0);
                    let (half, on) = mesh.fitted(kind, model.settings.masses.fit_box);
                    (half * scale, model.pose(view)?.compose(&on))
                }
                (Some(_), Err(why)) => return Ok(Geom::left_out(why)),
            };
            let turn = if matches!(kind, "capsule" | "cylinder") {
                // Along z there, along y here.
                Quat::from_axis_angle(Vec3::X, FRAC_PI_2)
            } else {
                Quat::IDENTITY
            };
            let own = mass::of_primitive(kind, half, is_skin);
            weight = own.map(|m| (pose, m));
            let shape = match kind {
                "sphere" => Shape::sphere(half.x),
                "capsule" => Shape::capsule(half.z, half.x),
                "cylinder" => Shape::cylinder(half.z, half.x),
                "box" => Shape::box_half(half),
                _ => {
                    note = Some("an ellipsoid collides as a hull of points on it".to_owned());
                    match hull_of_points(&ball_points(half)) {
                        Ok(hull) => hull,
                        Err(why) => return Ok(Geom::left_out(format!("ellipsoid: {why}"))),
                    }
                }
            };
            (shape, Pose::new(pose.position, (pose.rotation * turn).normalized()))
        }
        "mesh" => match meshes.named(view, model)? {
            Ok(mesh) => {
                let pose = model.pose(view)?;
                weight = Some((pose, mesh.weight));
                note.clone_from(&mesh.note);
                (mesh.hull.clone(), pose)
            }
            Err(why) => return Ok(Geom::left_out(why)),
        },
        "hfield" | "sdf" => {
            return Ok(Geom::left_out(format!("geoms of type {kind} are not read")));
        }
        _ => {
            let allowed = "plane, sphere, capsule, cylinder, box, ellipsoid or mesh";
            return Err(view.wrong("type", allowed));
        }
    };
    shape.validate().map_err(|e| {
        view.element().error(format!("{} of the {kind} is {}", e.field, e.value), e.allowed)
    })?;
    let mut def = ShapeDef::new(shape).with_pose(pose).with_material(surface(view)?);
    let density = view.source("density").at_least_zero("density")?.unwrap_or(1000.0);
    let given = view.get("mass").map(|_| view.at_least_zero("mass")).transpose()?;
    let group = view.number("group")?.unwrap_or(0.0);
    let [first, last] = model.settings.masses.groups;
    let mass = weight
        .filter(|_| (first..=last).contains(&group))
        .map(|(on, own)| (on, own.scaled_to(given.unwrap_or(density * own.mass))));
    if mass.is_some_and(|(_, m)| !(m.mass.is_finite() && m.inertia.is_finite())) {
        return Err(view.element().error("its mass is not finite", "a smaller density or mass"));
    }
    // The body has its mass from `mass`; the shape's own is that of its volume.
    let volume = MassProperties::of(&def.shape, 1.0).mass;
    def.density = mass.map_or(0.0, |(_, m)| if volume > 0.0 { m.mass / volume } else { 0.0 });
    if !def.density.is_finite() {
        def.density = 0.0;
    }
    let [kind, affinity] = [bits(view, "contype")?, bits(view, "conaffinity")?];
    def.user_data = u64::from(kind) << 32 | u64::from(affinity);
    Ok(Geom { shape: Ok(def), mass, note })
}

fn flag(view: &View<'_>, name: &str) -> Result<bool, SceneError> {
    match view.get(name) {
        None | Some("false") => Ok(false),
        Some("true") => Ok(true),
        Some(_) => Err(view.wrong(name, "true or false")),
    }
}

/// A set of bits, all of which may be set.
fn bits(view: &View<'_>, name: &str) -> Result<u32, SceneError> {
    let Some(text) = view.get(name) else { return Ok(1) };
    let number = text.trim().parse::<i64>().ok();
    number
        .and_then(|n| u32::try_from(n).ok().or_else(|| (n == -1).then_some(u32::MAX)))
        .ok_or_else(|| view.wrong(name, "a whole number from 0 to 4294967295"))
}

/// Half sizes along x, y and z, and the place; for round shapes, x is the radius and z half the
/// straight part.
fn extents<'a>(view: &View<'a>, model: &Model<'a>, kind: &str) -> Result<(Vec3, Pose), SceneError> {
    let sizes = view.list("size", 3)?;
    let along = if kind == "sphere" { None } else { view.numbers::<6>("fromto")? };
    let needed = match (kind, along.is_some()) {
        ("sphere", _) | (_, true) => 1,
        ("capsule" | "cylinder", _) => 2,
        _ => 3,
    };
    if sizes.len() < needed || sizes[..needed].iter().any(|s| *s <= 0.0) {
        let allowed = format!("{needed} numbers above 0 for a {kind}");
        let source = view.source("size");
        let problem = source
            .get("size")
            .map_or_else(|| "size is missing".to_owned(), |size| format!("size=\"{size}\""));
        return Err(source.error(problem, &allowed));
    }
    let at = |i: usize| sizes.get(i).copied().unwrap_or(sizes[0]);
    if let Some([a, b, c, d, e, f]) = along {
        let (from, to) = (vec3(a, b, c), vec3(d, e, f));
        let Some(axis) = (to - from).try_normalize() else {
            return Err(view.wrong("fromto", "two points that differ"));
        };
        let pose = Pose::new((from + to) * 0.5, Quat::from_arc(Vec3::Z, axis));
        return Ok((vec3(at(0), at(0), 0.5 * (to - from).length()), pose));
    }
    let half = match kind {
        "capsule" | "cylinder" => vec3(at(0), at(0), at(1)),
        _ => vec3(at(0), at(1), at(2)),
    };
    Ok((half, model.pose(view)?))
}

/// Points on an ellipsoid, in rings.
fn ball_points(half: Vec3) -> Vec<Vec3> {
    const RINGS: u8 = 8;
    let mut points = vec![vec3(0.0, 0.0, half.z), vec3(0.0, 0.0, -half.z)];
    for ring in 1..RINGS {
        let (s, c) = trig::sin_cos(PI * f32::from(ring) / f32::from(RINGS));
        for k in 0..2 * RINGS {
            let (sk, ck) = trig::sin_cos(PI * f32::from(k) / f32::from(RINGS));
            points.push(vec3(s * ck, s * sk, c).mul_each(half));
        }
    }
    points
}

/// Friction and restitution. MuJoCo takes the larger friction of two geoms, and none where both ask
/// for contacts without.
fn surface(view: &View<'_>) -> Result<Material, SceneError> {
    let friction = view.list("friction", 3)?.first().copied().unwrap_or(1.0);
    if friction < 0.0 {
        return Err(view.wrong("friction", "numbers of at least 0"));
    }
    let directions = view.number("condim")?.unwrap_or(3.0);
    Ok(Material {
        friction: if directions < 2.0 { 0.0 } else { friction },
        restitution: restitution(&view.list("solref", 2)?),
        friction_combine: Combine::Maximum,
        restitution_combine: Combine::Maximum,
        ..Material::default()
    })
}

/// Restitution of a contact that is a damped spring: e^(-π ζ / √(1 - ζ²)) of the speed it meets,
/// where ζ is its damping ratio. Two positive numbers are a time and that ratio, two others
/// stiffness and damping per mass.
fn restitution(solref: &[f32]) -> f32 {
    let [first, second] = solref else { return 0.0 };
    let ratio = if *first > 0.0 { *second } else { -second / (2.0 * (-first).max(1.0e-30).sqrt()) };
    if !(ratio < 1.0) {
        return 0.0;
    }
    let ratio = ratio.max(0.0);
    trig::exp(-PI * ratio / (1.0 - ratio * ratio).sqrt()).clamp(0.0, 1.0)
}

/// Turns contact bits into filters; a note if there are too many kinds.
///
/// Two geoms collide if one's `contype` and the other's `conaffinity` have a bit in common. Each
/// different pair of both gets a layer of its own, and its mask the layers of those it collides
/// with.
pub(super) fn filters(contacts: bool, links: &mut [Link<'_>]) -> Option<String> {
    let mut kinds: Vec<u64> = Vec::new();
    for shape in links.iter().flat_map(|l| &l.shapes) {
        if !kinds.contains(&shape.user_data) && kinds.len() < 65 {
            kinds.push(shape.user_data);
        }
    }
    let meet = |a: u64, b: u64| {
        contacts && ((a >> 32) & (b & 0xFFFF_FFFF) != 0 || (b >> 32) & (a & 0xFFFF_FFFF) != 0)
    };
    let plain = contacts && kinds.iter().all(|k| *k == 1 << 32 | 1);
    for shape in links.iter_mut().flat_map(|l| &mut l.shapes) {
        let own = shape.user_data;
        shape.user_data = 0;
        let place = kinds.iter().position(|k| *k == own).filter(|i| *i < 64);
        if let (false, Some(i)) = (plain, place) {
            let others = kinds.iter().take(64).enumerate().filter(|(_, k)| meet(own, **k));
            shape.filter = Filter::layers(1 << i, others.fold(0, |m, (j, _)| m | 1 << j));
        }
    }
    let told = "contact bits: of more than 64 different kinds the first 64 are kept".to_owned();
    (kinds.len() > 64).then_some(told)
}
