//! The way through the bodies of all models, from the outermost in. A stack stands for the way
//! back, so that no file can be too deep.

use std::collections::BTreeMap;

use drystone::geometry::MassProperties;
use drystone::{Pose, Quat, Vec3};

use super::defaults::View;
use super::describe;
use super::geom::{self, Geom};
use super::joint::{self, Read};
use super::mass;
use super::mesh::Meshes;
use super::model::Model;
use super::option::Options;
use crate::error::SceneError;
use crate::links::{Dof, Hold, Link, Weight};
use crate::read::xml::Element;
use crate::robot::{Robot, Site};

/// More bodies, shapes and copies than this are refused.
const MAX_THINGS: usize = 200_000;

/// Most models attached within each other.
const MAX_ATTACHED: usize = 16;

/// Most copies within each other: each adds to the names inside.
const MAX_COPIED: usize = 16;

/// Longest name, with its prefixes and suffixes [bytes]: each copy has one of its own.
const MAX_NAME: usize = 1000;

/// Things by their names as an instance of a model has them, each with what was put behind the
/// name.
pub(super) type Named<T> = BTreeMap<String, Vec<(String, T)>>;

/// Numbers of copies by the numbers of things.
#[derive(Default)]
pub(super) struct CopyOf {
    pub(super) joints: Vec<usize>,
    pub(super) sites: Vec<usize>,
    pub(super) links: Vec<usize>,
}

/// A model, as one of possibly many in the scene.
#[derive(Default)]
pub(super) struct Instance {
    pub(super) model: usize,
    pub(super) bodies: Named<usize>,
    /// Hinges and slides: numbers in [`Walk::joint_names`].
    pub(super) joints: Named<usize>,
    /// Sites: the link, and the point on it.
    pub(super) sites: Named<(usize, Vec3)>,
    /// Numbers of sites in the robot's description.
    pub(super) site_numbers: Named<usize>,
    /// In front of its names in the scene, and behind them.
    pub(super) prefix: String,
    pub(super) suffix: String,
}

impl Instance {
    /// A name of its model as it is in the scene; empty if it is.
    pub(super) fn name(&self, raw: &str, copy: &str) -> String {
        if raw.is_empty() {
            return String::new();
        }
        [&self.prefix, raw, copy, &self.suffix].concat()
    }
}

/// Where the walk is.
#[derive(Clone)]
struct Here {
    instance: usize,
    link: usize,
    /// The frame of the current element [frame of the link].
    pose: Pose,
    class: Option<usize>,
    prefix: String,
    /// Behind names within the instance, and behind those of the instance as a whole.
    inner: String,
    outer: String,
    /// How many models are around, and how many copies.
    attached: usize,
    copied: usize,
    /// Number of the innermost copy around, 0 without one.
    copy: usize,
}

impl Here {
    /// The same place, with another class.
    fn of(&self, class: Option<usize>) -> Self {
        Self { class, ..self.clone() }
    }

    /// The name of an element in the scene.
    fn name(&self, element: &Element<'_>, raw: &str) -> Result<String, SceneError> {
        let parts = [&self.prefix, raw, &self.inner, &self.outer];
        if parts.iter().map(|part| part.len()).sum::<usize>() <= MAX_NAME {
            return Ok(parts.concat());
        }
        let allowed = format!("names of up to {MAX_NAME} bytes, with those of copies and models");
        Err(element.error("its name is too long", &allowed))
    }
}

/// A task that is still to be done.
enum Task<'a> {
    /// Read the elements of a body, a frame or the world.
    Inside(Element<'a>, Here),
    /// One element of those.
    One(Element<'a>, Here),
    /// A copy and those behind it: its number, how many there are, where it is, and what is between
    /// two.
    Copy { element: Element<'a>, here: Here, number: usize, count: usize, between: Pose },
}

/// The walk, and its results.
pub(super) struct Walk<'a> {
    pub(super) models: &'a [Model<'a>],
    pub(super) option: Options,
    pub(super) links: Vec<Link<'a>>,
    pub(super) instances: Vec<Instance>,
    pub(super) notes: Vec<String>,
    /// Things of a kind that are left out, counted.
    pub(super) ignored: BTreeMap<String, usize>,
    /// Names of joints as they are in the scene.
    pub(super) joint_names: Vec<String>,
    /// Numbers of the same joints in the robot's description.
    pub(super) joint_numbers: Vec<usize>,
    /// Joints, sites and bodies that the user moves, for the robot's description.
    pub(super) robot: Robot,
    /// The copies that joints with names, sites and links are in: numbers in the order of the file,
    /// 0 for none.
    pub(super) copy_of: CopyOf,
    copies: usize,
    things: usize,
    stack: Vec<Task<'a>>,
    /// True of each link that the world holds.
    held: Vec<bool>,
    /// Masses of each link's geoms [frame of the link]; `None`: it is given another.
    geom_masses: Vec<Option<Vec<(Pose, MassProperties)>>>,
    /// The model that each link is of.
    model_of: Vec<usize>,
    hulls: Meshes<'a>,
}

impl<'a> Walk<'a> {
    pub(super) fn new(models: &'a [Model<'a>], option: Options) -> Self {
        let world = Link {
            name: "world".to_owned(),
            element: models[0].root,
            parent: None,
            pose: Pose::IDENTITY,
            hold: Hold::World,
            weight: Weight::Unsaid,
            shapes: Vec::new(),
            left_out: None,
            gravity_scale: 1.0,
        };
        Self {
            models,
            option,
            links: vec![world],
            instances: Vec::new(),
            notes: Vec::new(),
            ignored: BTreeMap::new(),
            joint_names: Vec::new(),
            joint_numbers: Vec::new(),
            robot: Robot::default(),
            copy_of: CopyOf { links: vec![0], ..CopyOf::default() },
            copies: 0,
            things: 0,
            stack: Vec::new(),
            held: vec![true],
            geom_masses: vec![None],
            model_of: vec![0],
            hulls: Meshes::default(),
        }
    }

    pub(super) fn ignore(&mut self, what: &str) {
        *self.ignored.entry(what.to_owned()).or_default() += 1;
    }

    fn count(&mut self, element: &Element<'a>) -> Result<(), SceneError> {
        self.things += 1;
        if self.things <= MAX_THINGS {
            return Ok(());
        }
        let problem = "the scene has more than 200000 bodies, shapes and copies here";
        Err(element.error(problem, "fewer"))
    }

    /// Walks through the first model and all that it attaches.
    pub(super) fn run(&mut self) -> Result<(), SceneError> {
        let model = &self.models[0];
        let here = Here {
            instance: self.instance(0),
            link: 0,
            pose: Pose::IDENTITY,
            class: None,
            prefix: String::new(),
            inner: String::new(),
            outer: String::new(),
            attached: 0,
            copied: 0,
            copy: 0,
        };
        let worlds: Vec<Element<'a>> = model.sections("worldbody").collect();
        let tasks = worlds.into_iter().map(|w| Task::Inside(w, here.clone()));
        self.stack.extend(tasks.collect::<Vec<_>>().into_iter().rev());
        while let Some(task) = self.stack.pop() {
            match task {
                Task::Inside(element, here) => self.inside(&element, &here)?,
                Task::One(element, here) => self.one(element, here)?,
                Task::Copy { element, here, number, count, between } => {
                    self.copy(element, here, number, count, between)?;
                }
            }
        }
        self.weigh();
        for (tag, count) in model.tags() {
            match tag {
                "option" | "compiler" | "default" | "worldbody" | "contact" | "equality" => {}
                "asset" | "tendon" | "visual" | "statistic" | "size" | "include" => {}
                other => *self.ignored.entry(format!("<{other}>: not read")).or_default() += count,
            }
        }
        Ok(())
    }

    fn instance(&mut self, model: usize) -> usize {
        self.instances.push(Instance { model, ..Instance::default() });
        self.instances.len() - 1
    }

    fn model(&self, here: &Here) -> &'a Model<'a> {
        &self.models[self.instances[here.instance].model]
    }

    fn inside(&mut self, element: &Element<'a>, here: &Here) -> Result<(), SceneError> {
        let children = self.model(here).children(element)?;
        self.stack.extend(children.into_iter().rev().map(|c| Task::One(c, here.clone())));
        Ok(())
    }

    fn one(&mut self, element: Element<'a>, here: Here) -> Result<(), SceneError> {
        match element.tag() {
            "geom" => self.geom(element, &here),
            "site" => self.site(element, &here),
            "body" => self.body(element, &here),
            "frame" => {
                let model = self.model(&here);
                let own = model.pose(&View::bare(element))?;
                let class = model.defaults.named(&element, "childclass")?.or(here.class);
                let pose = here.pose.compose(&own);
                self.inside(&element, &Here { pose, class, ..here })
            }
            "replicate" => self.replicate(element, here),
            "attach" => self.attach(element, here),
            // Read with their body; of pictures.
            "joint" | "freejoint" | "inertial" | "light" | "camera" => Ok(()),
            other => {
                self.ignore(&format!("<{other}> of bodies: not read"));
                Ok(())
            }
        }
    }

    fn geom(&mut self, element: Element<'a>, here: &Here) -> Result<(), SceneError> {
        self.count(&element)?;
        let model = self.model(here);
        let view = model.defaults.view(element, here.class)?;
        let Geom { shape, mass, note } = geom::read(&view, model, &mut self.hulls)?;
        let owner = self.links[here.link].name.clone();
        if let Some(note) = note {
            self.ignore(&format!("geoms: {note}"));
        }
        match shape {
            Ok(mut shape) => {
                shape.pose = here.pose.compose(&shape.pose);
                if let (Some(parts), Some((on, mass))) = (&mut self.geom_masses[here.link], mass) {
                    parts.push((here.pose.compose(&on), mass));
                }
                let is_plane = matches!(shape.shape, drystone::Shape::HalfSpace { .. });
                if is_plane && !self.held[here.link] {
                    self.notes.push(format!("{owner}: a plane that moves is left out"));
                    return Ok(());
                }
                self.links[here.link].shapes.push(shape);
            }
            Err(why) => {
                self.notes.push(format!("{owner}: a geom is left out: {why}"));
                self.links[here.link].left_out.get_or_insert(why);
            }
        }
        Ok(())
    }

    fn site(&mut self, element: Element<'a>, here: &Here) -> Result<(), SceneError> {
        let Some(name) = element.get("name") else { return Ok(()) };
        let whole = here.name(&element, name)?;
        let model = self.model(here);
        let view = model.defaults.view(element, here.class)?;
        let at = match view.numbers::<6>("fromto")? {
            Some([a, b, c, d, e, f]) => (Vec3::from([a, b, c]) + Vec3::from([d, e, f])) * 0.5,
            None => view.vec3("pos")?.unwrap_or(Vec3::ZERO),
        };
        let found = (here.link, here.pose.point(at));
        let number = self.robot.sites.len();
        let rotation = match view.numbers::<6>("fromto")? {
            // Its z points from the second end to the first, as MuJoCo's.
            Some([a, b, c, d, e, f]) => (Vec3::from([a, b, c]) - Vec3::from([d, e, f]))
                .try_normalize()
                .map_or(Quat::IDENTITY, |z| Quat::from_arc(Vec3::Z, z)),
            None => model.pose(&view)?.rotation,
        };
        let pose = here.pose.compose(&Pose { position: at, rotation });
        self.robot.sites.push(Site { name: whole, link: self.link_name(here.link), pose });
        self.copy_of.sites.push(here.copy);
        let instance = &mut self.instances[here.instance];
        register(&mut instance.sites, name, &here.inner, found);
        register(&mut instance.site_numbers, name, &here.inner, number);
        Ok(())
    }

    /// The name of a link, which has one in the scene in any case.
    pub(super) fn link_name(&self, link: usize) -> String {
        match self.links[link].name.as_str() {
            "" => format!("#{link}"),
            name => name.to_owned(),
        }
    }

    fn body(&mut self, element: Element<'a>, here: &Here) -> Result<(), SceneError> {
        self.count(&element)?;
        let model = self.model(here);
        let class = model.defaults.named(&element, "childclass")?.or(here.class);
        let own = model.pose(&View::bare(element))?;
        let mut dofs: Vec<Dof> = Vec::new();
        let joints = self.robot.joints.len();
        let mut is_free = false;
        let mut given =
            (model.settings.inertia_from_geoms == Some(false)).then(MassProperties::default);
        for (child, pose, class) in self.holding(&element, &here.of(class))? {
            if child.tag() == "inertial" {
                if model.settings.inertia_from_geoms != Some(true) {
                    given = Some(joint::inertial(&View::bare(child), model)?);
                }
                continue;
            }
            let view = model.defaults.view(child, class)?;
            let raw = child.get("name").unwrap_or_default();
            let name = if raw.is_empty() {
                format!("joint of #{}.{}", self.links.len(), dofs.len())
            } else {
                here.name(&child, raw)?
            };
            if !raw.is_empty() {
                let known = &mut self.instances[here.instance].joints;
                register(known, raw, &here.inner, self.joint_names.len());
                self.joint_names.push(name.clone());
                self.joint_numbers.push(self.robot.joints.len());
                self.copy_of.joints.push(here.copy);
            }
            let whole = if raw.is_empty() { "" } else { &name };
            self.robot.joints.push(describe::joint(&view, model, &pose, whole)?);
            match joint::read(&view, model, &self.option, &pose, &name)? {
                Read::Free => is_free = true,
                Read::Joint(dof) => dofs.push(dof),
            }
            if view.number("armature")?.is_some_and(|a| a > 0.0) {
                self.ignore("joints: their armature counts only with --reduced");
            }
        }
        if is_free && !dofs.is_empty() {
            return Err(element.error("it has a free joint and others", "a free joint alone"));
        }
        let hold = match (is_free, dofs.is_empty(), element.get("mocap")) {
            (_, true, Some("true")) => Hold::Kinematic,
            (true, _, _) => Hold::Free,
            (false, true, _) => Hold::Fast,
            (false, false, _) => Hold::Joints(dofs),
        };
        let raw = element.get("name").unwrap_or_default();
        let name = if raw.is_empty() { String::new() } else { here.name(&element, raw)? };
        let number = self.links.len();
        let at = here.pose.compose(&own);
        if hold == Hold::Kinematic {
            self.robot.mocap.push(at);
        }
        self.copy_of.links.push(here.copy);
        self.held.push(hold == Hold::World || (hold == Hold::Fast && self.held[here.link]));
        self.geom_masses.push(given.is_none().then(Vec::new));
        self.model_of.push(self.instances[here.instance].model);
        self.links.push(Link {
            name,
            element,
            parent: Some(here.link),
            pose: at,
            hold,
            weight: given.map_or(Weight::Unsaid, Weight::Given),
            shapes: Vec::new(),
            left_out: None,
            gravity_scale: 1.0 - element.number("gravcomp")?.unwrap_or(0.0),
        });
        if !raw.is_empty() {
            register(&mut self.instances[here.instance].bodies, raw, &here.inner, number);
        }
        let link = self.link_name(number);
        describe::place(&mut self.robot, joints, &link, &at);
        self.inside(&element, &Here { link: number, pose: Pose::IDENTITY, class, ..here.clone() })
    }

    /// Joints and `<inertial>` of a body, those in its frames among them: the element, the pose of
    /// the frame around it [body] and its class.
    fn holding(
        &self,
        body: &Element<'a>,
        here: &Here,
    ) -> Result<Vec<(Element<'a>, Pose, Option<usize>)>, SceneError> {
        let model = self.model(here);
        let mut out = Vec::new();
        let mut stack = vec![(*body, Pose::IDENTITY, here.class)];
        while let Some((element, pose, class)) = stack.pop() {
            match element.tag() {
                "joint" | "freejoint" | "inertial" => {
                    out.push((element, pose, class));
                    continue;
                }
                "frame" => {
                    let own = model.pose(&View::bare(element))?;
                    let class = model.defaults.named(&element, "childclass")?.or(class);
                    let inside = model.children(&element)?.into_iter().rev();
                    stack.extend(inside.map(|c| (c, pose.compose(&own), class)));
                }
                _ if element == *body => {
                    let inside = model.children(&element)?.into_iter().rev();
                    stack.extend(inside.map(|c| (c, pose, class)));
                }
                _ => {}
            }
        }
        Ok(out)
    }

    /// Gives links the mass of their geoms, and changes masses as the compilers say.
    fn weigh(&mut self) {
        for (i, parts) in self.geom_masses.iter().enumerate().skip(1) {
            let link = &mut self.links[i];
            if let Some(parts) = parts {
                link.weight = Weight::Given(MassProperties::combine(parts));
            }
            if let Weight::Given(own) = &mut link.weight {
                mass::bound(own, &self.models[self.model_of[i]].settings.masses);
            }
        }
        let total = self.models[0].settings.masses.total;
        let weights = self.links.iter_mut().filter_map(|l| match &mut l.weight {
            Weight::Given(own) => Some(own),
            Weight::Unsaid => None,
        });
        if total > 0.0 {
            mass::scale(weights, total);
        }
    }

    fn replicate(&mut self, element: Element<'a>, here: Here) -> Result<(), SceneError> {
        let count = element.need("count")?.trim().parse::<usize>().ok();
        let allowed = "a whole number from 1 to 200000";
        let count = count
            .filter(|c| (1..=MAX_THINGS).contains(c))
            .ok_or_else(|| element.wrong("count", allowed))?;
        if here.copied >= MAX_COPIED {
            return Err(element.error("copies stand within copies", "16 deep"));
        }
        let offset = element.vec3("offset")?.unwrap_or(Vec3::ZERO);
        let turn = element.numbers::<3>("euler")?.map(|angles| self.model(&here).euler(angles));
        let between = Pose::new(offset, turn.unwrap_or(Quat::IDENTITY));
        self.stack.push(Task::Copy { element, here, number: 0, count, between });
        Ok(())
    }

    /// Does the copy of that number and leaves the next one for later.
    fn copy(
        &mut self,
        element: Element<'a>,
        here: Here,
        number: usize,
        count: usize,
        between: Pose,
    ) -> Result<(), SceneError> {
        self.count(&element)?;
        let digits = (count - 1).to_string().len();
        let suffix = format!("{}{number:0digits$}", element.get("sep").unwrap_or_default());
        // Outer copies count behind inner ones.
        let inner = format!("{suffix}{}", here.inner);
        self.copies += 1;
        let copy = Here { inner, copied: here.copied + 1, copy: self.copies, ..here.clone() };
        // Here too, for there may be nothing with a name inside.
        copy.name(&element, "")?;
        if number + 1 < count {
            let next = here.pose.compose(&between);
            let pose = Pose { rotation: next.rotation.normalized(), ..next };
            let here = Here { pose, ..here };
            self.stack.push(Task::Copy { element, here, number: number + 1, count, between });
        }
        self.inside(&element, &copy)
    }

    /// Puts a body of another model here.
    fn attach(&mut self, element: Element<'a>, here: Here) -> Result<(), SceneError> {
        self.count(&element)?;
        let name = element.need("model")?;
        let Some(&number) = self.model(&here).models.get(name) else {
            return Err(element.wrong("model", "a model of <asset>"));
        };
        if here.attached >= MAX_ATTACHED {
            return Err(element.error("models attach each other without end", "16 deep"));
        }
        let model = &self.models[number];
        let prefix = format!("{}{}", here.prefix, element.get("prefix").unwrap_or_default());
        let suffix = format!("{}{}", here.inner, here.outer);
        let instance = self.instance(number);
        self.instances[instance].prefix.clone_from(&prefix);
        self.instances[instance].suffix.clone_from(&suffix);
        let inside = Here {
            instance,
            class: None,
            prefix,
            inner: String::new(),
            outer: suffix,
            attached: here.attached + 1,
            ..here
        };
        inside.name(&element, "")?;
        let mut stack: Vec<Element<'a>> = model.sections("worldbody").collect();
        let Some(body) = element.get("body") else {
            self.stack.extend(stack.into_iter().rev().map(|w| Task::Inside(w, inside.clone())));
            return Ok(());
        };
        while let Some(at) = stack.pop() {
            for child in model.children(&at)? {
                if child.tag() == "body" && child.get("name") == Some(body) {
                    self.stack.push(Task::One(child, inside));
                    return Ok(());
                }
                if ["body", "frame"].contains(&child.tag()) {
                    stack.push(child);
                }
            }
        }
        Err(element.wrong("body", "a body of that model"))
    }
}

/// Keeps a thing by its name, and by its name with what was put behind it.
pub(super) fn register<T: Copy>(names: &mut Named<T>, raw: &str, suffix: &str, thing: T) {
    names.entry(raw.to_owned()).or_default().push((suffix.to_owned(), thing));
    if !suffix.is_empty() {
        let whole = format!("{raw}{suffix}");
        names.entry(whole).or_default().push((String::new(), thing));
    }
}
