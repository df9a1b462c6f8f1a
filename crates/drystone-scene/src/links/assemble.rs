//! From links to bodies and joints.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

use drystone::geometry::MassProperties;
use drystone::joint::SixDof;
use drystone::math::Sym3;
use drystone::{Axis, BodyDef, BodyKind, JointKind, MassDef, Pose, Quat, ShapeDef, Vec3};

use super::compose::{self, stages};
use super::link::{Hold, Link, Weight};
use super::reduce::{self, InTree, Made};
use crate::error::SceneError;
use crate::mass::mass_of;
use crate::scene::{Scene, SceneCoupling, SceneFrame, SceneJoint};

/// If several joints hold a link, this part of its mass stands between each two of them that cannot
/// be one joint. A body needs a mass, and a much lighter one would make the joints soft.
const SHARE: f32 = 0.125;

/// A thin rod turns easily about itself, but its moment is not 0: it is at least this part of the
/// largest one, as rounding of the matrix alone can make more of it.
const LEAST_MOMENT: f32 = 1.0e-6;

/// A negative moment is a rounded 0 down to this part of the largest one.
const ROUNDING: f32 = 1.0e-5;

/// Whether a link collides with one that the world holds, if a joint is between them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Anchored {
    Collides,
    Passes,
}

/// Where links went.
#[derive(Clone, Debug)]
pub(crate) struct Assembled {
    /// The body of each link, as a number in the scene, and the link's place on it.
    pub(crate) place: Vec<(usize, Pose)>,
    /// Coordinates of joints, by the joints' names in the file.
    pub(crate) coordinates: BTreeMap<String, Coordinate>,
    /// Pairs of bodies, the smaller number first, that a joint keeps from colliding.
    apart: BTreeSet<[usize; 2]>,
    /// Groups of links in the order of their bodies, and places of joints in trees.
    made: Vec<Made>,
    in_trees: BTreeMap<String, InTree>,
}

/// A coordinate of a joint of the file.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Coordinate {
    /// Number of the joint in the scene.
    joint: usize,
    axis: Axis,
    /// The file's own is this times the scene's, plus the reference.
    sign: f32,
    reference: f32,
}

impl Coordinate {
    /// Lets the coordinate be `ratio` times another one plus `offset`, as the file counts both.
    fn follow(&self, other: &Self, ratio: f32, offset: f32) -> SceneCoupling {
        SceneCoupling {
            joint_a: other.joint,
            axis_a: other.axis,
            joint_b: self.joint,
            axis_b: self.axis,
            ratio: ratio * self.sign * other.sign,
            offset: self.sign * (offset + ratio * other.reference - self.reference),
        }
    }
}

impl Assembled {
    /// Lets a joint's coordinate be `ratio` times another one plus `offset`, as the file counts
    /// both.
    pub(crate) fn couple(
        &self,
        [own, other]: [&str; 2],
        [ratio, offset]: [f32; 2],
        scene: &mut Scene,
    ) {
        if let (Some(a), Some(b)) = (self.coordinates.get(own), self.coordinates.get(other)) {
            scene.couplings.push(a.follow(b, ratio, offset));
        }
        if let (Some(a), Some(b)) = (self.in_trees.get(own), self.in_trees.get(other)) {
            reduce::couple(*a, *b, [ratio, offset], scene);
        }
    }

    /// True if the two links are one body, or a joint keeps theirs from colliding.
    pub(crate) fn are_apart(&self, a: usize, b: usize) -> bool {
        let (a, b) = (self.place[a].0, self.place[b].0);
        a == b || self.apart.contains(&sorted(a, b))
    }

    /// Keeps two links from colliding.
    pub(crate) fn exclude(&mut self, scene: &mut Scene, a: usize, b: usize) {
        let (a, b) = (self.place[a].0, self.place[b].0);
        let is_fixed = |i: usize| scene.bodies[i].def.kind != BodyKind::Dynamic;
        if a == b || (is_fixed(a) && is_fixed(b)) || !self.apart.insert(sorted(a, b)) {
            return;
        }
        tie(scene, a, b);
    }
}

fn sorted(a: usize, b: usize) -> [usize; 2] {
    [a.min(b), a.max(b)]
}

/// Adds a joint that holds nothing and keeps its bodies from colliding.
fn tie(scene: &mut Scene, a: usize, b: usize) {
    let free = JointKind::SixDof(compose::FREE);
    scene.joints.push(SceneJoint::new((a, Vec3::ZERO), (b, Vec3::ZERO), free));
}

/// Links that are one body.
struct Group {
    /// The first of them, whose frame is the body's.
    head: usize,
    /// All of them, with their places on the body.
    members: Vec<(usize, Pose)>,
}

/// Adds bodies, joints and frames for the links, which stand behind their parents.
pub(crate) fn assemble(
    links: &[Link<'_>],
    anchored: Anchored,
    scene: &mut Scene,
) -> Result<Assembled, SceneError> {
    let noted = scene.notes.len();
    let mut groups: Vec<Group> = Vec::new();
    let mut group_of: Vec<usize> = Vec::with_capacity(links.len());
    let mut world: Vec<Pose> = Vec::with_capacity(links.len());
    for (i, link) in links.iter().enumerate() {
        let above = link.parent.map_or(Pose::IDENTITY, |p| world[p]);
        world.push(normalized(above.compose(&link.pose)));
        match link.parent {
            Some(p) if link.hold == Hold::Fast => {
                let group = group_of[p];
                let on = normalized(world[groups[group].head].relative(&world[i]));
                groups[group].members.push((i, on));
                group_of.push(group);
            }
            _ => {
                group_of.push(groups.len());
                groups.push(Group { head: i, members: vec![(i, Pose::IDENTITY)] });
            }
        }
    }
    let mut names = Names::default();
    let mut body_of = vec![0; groups.len()];
    let mut out = Assembled {
        place: vec![(0, Pose::IDENTITY); links.len()],
        coordinates: BTreeMap::new(),
        apart: BTreeSet::new(),
        made: Vec::new(),
        in_trees: BTreeMap::new(),
    };
    for (g, group) in groups.iter().enumerate() {
        let link = &links[group.head];
        let mut def = body(links, group, &mut scene.notes)?;
        def = def.with_position(world[group.head].position);
        def = def.with_rotation(world[group.head].rotation);
        let mut chain = Chain { links, out: &mut out, anchored, world: &world };
        let parent = link.parent.map(|p| (body_of[group_of[p]], p));
        body_of[g] = chain.add(group, parent, def, &mut names, scene)?;
        for &(i, on) in &group.members {
            out.place[i] = (body_of[g], on);
        }
    }
    for group in &groups {
        for &(i, on) in group.members.iter().skip(1) {
            let (body, _) = out.place[i];
            let link = &links[i];
            let center = match link.weight {
                Weight::Given(m) => m.center,
                _ => mass_of(&link.shapes).center,
            };
            let name = names.unique(&link.name, i);
            scene.frames.push(SceneFrame { name, body, pose: on, center: on.point(center) });
        }
    }
    out.in_trees = reduce::trees(links, &out.made, &world, scene).into_iter().collect();
    let apart = scene.joints.iter().filter(|j| !j.collide_connected);
    out.apart = apart.map(|j| sorted(j.body_a, j.body_b)).collect();
    let left_out = scene.notes.iter().skip(noted).filter(|n| n.contains("left out"));
    scene.left_out.extend(left_out.cloned());
    Ok(out)
}

/// Rounding of many turns in a row is taken out.
fn normalized(pose: Pose) -> Pose {
    Pose { position: pose.position, rotation: pose.rotation.normalized() }
}

/// Names that were given.
#[derive(Default)]
struct Names {
    taken: BTreeSet<String>,
}

impl Names {
    fn unique(&mut self, name: &str, index: usize) -> String {
        let mut name = if name.is_empty() { format!("#{index}") } else { name.to_owned() };
        if self.taken.contains(&name) {
            name = format!("{name}#{index}");
        }
        while !self.taken.insert(name.clone()) {
            name.push('\'');
        }
        name
    }
}

/// Adds a body and its joints.
struct Chain<'a> {
    links: &'a [Link<'a>],
    out: &'a mut Assembled,
    anchored: Anchored,
    world: &'a [Pose],
}

impl Chain<'_> {
    /// Adds the body of a group and what holds it on its parent's body; returns its number.
    fn add(
        &mut self,
        group: &Group,
        parent: Option<(usize, usize)>,
        mut def: BodyDef,
        names: &mut Names,
        scene: &mut Scene,
    ) -> Result<usize, SceneError> {
        let link = &self.links[group.head];
        let name = names.unique(&link.name, group.head);
        let (Hold::Joints(dofs), Some((parent, parent_link))) = (&link.hold, parent) else {
            let body = scene.add(name, def);
            self.out.made.push(Made::alone(group.head, body));
            return Ok(body);
        };
        let (first_joint, first_body) = (scene.joints.len(), scene.bodies.len());
        let stages = stages(dofs, &mut scene.notes);
        let between = stages.len().saturating_sub(1);
        let mut above = parent;
        if between > 0 {
            let told: Vec<&str> = stages.iter().map(|s| s.last.as_str()).collect();
            scene.notes.push(format!(
                "{name}: between its joints {} stand bodies that take {SHARE} of its mass each",
                told.join(", "),
            ));
        }
        // The frames coincide at rest, so one pose serves all stages.
        let on_parent = {
            let (_, place) = self.out.place[parent_link];
            let body = self.world[parent_link].compose(&place.inverse());
            normalized(body.relative(&self.world[group.head]))
        };
        let mut on_above = on_parent;
        let is_held = scene.bodies[parent].def.kind != BodyKind::Dynamic;
        let collides = is_held && self.anchored == Anchored::Collides;
        for (k, stage) in stages.iter().enumerate() {
            let number = if k < between {
                let part = share(&mut def)?;
                let inner = names.unique(&format!("{name}/{}", stage.last), group.head);
                scene.add(inner, part)
            } else {
                scene.add(name.clone(), def.clone())
            };
            let ends = ((above, on_above.point(stage.anchor)), (number, stage.anchor));
            let joint = |kind: JointKind| SceneJoint {
                collide_connected: collides && k == 0,
                ..SceneJoint::new(ends.0, ends.1, on_first(kind, on_above.rotation))
            };
            for (of, axis, sign, reference) in &stage.coordinates {
                let (axis, sign, reference) = (*axis, *sign, *reference);
                let joint = scene.joints.len();
                let at = Coordinate { joint, axis, sign, reference };
                self.out.coordinates.insert(of.clone(), at);
            }
            scene.joints.push(joint(stage.kind));
            (above, on_above) = (number, Pose::IDENTITY);
        }
        if between > 0 && !collides {
            tie(scene, parent, above);
        }
        let share = (0..between).fold(1.0, |rest: f32, _| rest * (1.0 - SHARE));
        self.out.made.push(Made {
            head: group.head,
            body: above,
            parent: Some(parent),
            joints: first_joint..scene.joints.len(),
            between: first_body..above,
            share,
        });
        Ok(above)
    }
}

/// The joint with its frame on the first body turned so.
fn on_first(kind: JointKind, turn: Quat) -> JointKind {
    match kind {
        JointKind::SixDof(six) => {
            JointKind::SixDof(SixDof { frame_a: (turn * six.frame_a).normalized(), ..six })
        }
        other => other,
    }
}

/// Takes a share of a body's mass for a body of its own, which stands in the same place.
fn share(def: &mut BodyDef) -> Result<BodyDef, SceneError> {
    let MassDef::Exact { mass, center, inertia } = def.mass else {
        return Err(SceneError::new(Path::new(""), "", "a body between joints has no mass", ""));
    };
    let mut part = def.clone();
    part.shapes.clear();
    part.mass = MassDef::Exact { mass: mass * SHARE, center, inertia: inertia.scaled(SHARE) };
    let rest = 1.0 - SHARE;
    def.mass = MassDef::Exact { mass: mass * rest, center, inertia: inertia.scaled(rest) };
    Ok(part)
}

/// The body of a group, without its place.
fn body(links: &[Link<'_>], group: &Group, notes: &mut Vec<String>) -> Result<BodyDef, SceneError> {
    let link = &links[group.head];
    let kind = match link.hold {
        Hold::World | Hold::Fast => BodyKind::Static,
        Hold::Kinematic => BodyKind::Kinematic,
        Hold::Free | Hold::Joints(_) => BodyKind::Dynamic,
    };
    let mut shapes: Vec<ShapeDef> = Vec::new();
    let mut parts = Vec::new();
    for &(i, on) in &group.members {
        let member = &links[i];
        shapes.extend(member.shapes.iter().map(|s| {
            let pose = normalized(on.compose(&s.pose));
            ShapeDef { pose, ..s.clone() }
        }));
        parts.push((
            on,
            match member.weight {
                Weight::Given(mass) => mass,
                Weight::Unsaid => MassProperties::default(),
            },
        ));
    }
    let mut def = BodyDef { kind, shapes, gravity_scale: link.gravity_scale, ..BodyDef::dynamic() };
    if kind != BodyKind::Dynamic {
        return Ok(def);
    }
    // There is no mass because a shape could not be read, which the user can mend.
    let left_out = group.members.iter().find_map(|(i, _)| links[*i].left_out.as_deref());
    let fail = |problem: String, allowed: &str| {
        let problem = match left_out {
            Some(why) => format!("{why}; so {problem}"),
            None => problem,
        };
        Err(link.element.error(problem, allowed))
    };
    let own = mass_of(&def.shapes);
    let mut whole = MassProperties::combine(&parts);
    let is_unsaid = group.members.iter().any(|(i, _)| links[*i].weight == Weight::Unsaid);
    if whole.mass <= 0.0 && is_unsaid && own.mass > 0.0 {
        notes.push(format!(
            "{}: it has no inertial, its mass of {} kg is that of its collision shapes at 1000 kg/m3",
            link.name, own.mass
        ));
        whole = own;
    }
    if !(whole.mass > 0.0 && whole.mass.is_finite()) {
        let problem = format!("'{}' moves and has a mass of {} kg", link.name, whole.mass);
        return fail(problem, "a mass above 0, given or from shapes");
    }
    let (moments, turn) = whole.inertia.eigen();
    let (least, most) = (moments.min_element(), moments.max_element());
    let told = {
        let Vec3 { x, y, z } = moments;
        format!("the inertia of '{}' has principal moments of {x}, {y} and {z} kg m2", link.name)
    };
    if !(moments.is_finite() && most > 0.0) {
        if own.mass <= 0.0 {
            let problem = format!("'{}' moves and has no inertia", link.name);
            return fail(problem, "principal moments above 0, given or from shapes");
        }
        notes.push(format!(
            "{}: its inertia is 0, that of its shapes at its mass is taken",
            link.name
        ));
        whole.inertia = own.scaled_to(whole.mass).inertia;
    } else if least < -ROUNDING * most {
        if own.mass <= 0.0 {
            return fail(told, "moments above 0, given or from shapes");
        }
        notes.push(format!(
            "{told}, which no body has: it is left out, that of its shapes at its mass is taken"
        ));
        whole.inertia = own.scaled_to(whole.mass).inertia;
    } else if least < LEAST_MOMENT * most {
        notes.push(format!("{told}: those below a millionth of the largest are raised to that"));
        let raised = moments.max(Vec3::splat(LEAST_MOMENT * most));
        whole.inertia = Sym3::rotated_diagonal(turn, raised);
    }
    let MassProperties { mass, center, inertia } = whole;
    def.mass = MassDef::Exact { mass, center, inertia };
    def.validate().map_err(|e| {
        let problem = format!("{} of its body is {}", e.field(), e.value());
        link.element.error(problem, e.allowed())
    })?;
    Ok(def)
}
