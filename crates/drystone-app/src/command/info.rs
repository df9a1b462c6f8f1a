//! `drystone scenes`, `drystone methods`, `drystone info`: what there is to know before a run.

use std::collections::BTreeMap;
use std::process::ExitCode;

use drystone::BodyKind;
use drystone::method::Method;
use drystone_scene::{Parameter, Range, Scene, Script, StrandDef, catalog};

use crate::cli::Info;
use crate::load::{build, load};
use crate::output::{self, Failure, Outcome, one_line};
use crate::report::measure::lines_of;
use crate::report::page::{Page, count, si};

/// Lists the built-in scenes.
pub(crate) fn scenes() -> Outcome {
    let mut rows = Vec::new();
    for entry in catalog() {
        let scene = drystone_scene::named(entry.name).map_err(Failure::failed)?;
        let parameters: Vec<String> = entry.parameters.iter().map(shown).collect();
        rows.push([
            entry.name.to_owned(),
            (scene.bodies.len() + scene.script.joining().count()).to_string(),
            one_line(entry.summary),
            parameters.join(","),
        ]);
    }
    let name = width(&rows, 0).max(4);
    let summary = width(&rows, 2).max(10);
    let mut text =
        format!("{:<name$}  {:>6}  {:<summary$}  parameters\n", "name", "bodies", "shows");
    for [a, b, c, d] in &rows {
        text.push_str(format!("{a:<name$}  {b:>6}  {c:<summary$}  {d}").trim_end());
        text.push('\n');
    }
    output::print(&text)?;
    Ok(ExitCode::SUCCESS)
}

/// A parameter with its default, as it would be written.
fn shown(parameter: &Parameter) -> String {
    match parameter.range {
        Range::Whole { default, .. } => format!("{}={default}", parameter.name),
        Range::Number { default, .. } => format!("{}={default}", parameter.name),
    }
}

fn width<const N: usize>(rows: &[[String; N]], column: usize) -> usize {
    rows.iter().map(|row| row[column].chars().count()).max().unwrap_or(0)
}

/// Lists the stepping methods.
pub(crate) fn methods() -> Outcome {
    let default = Method::soft_step();
    let widest = Method::NAMES.iter().map(|name| name.len()).max().unwrap_or(0);
    let mut text = String::new();
    for method in Method::NAMES.iter().filter_map(|name| Method::named(name)) {
        let mark = if method.name() == default.name() { " (default)" } else { "" };
        text.push_str(&format!("{:<widest$}  {}{mark}\n", method.name(), method.summary()));
    }
    output::print(&text)?;
    Ok(ExitCode::SUCCESS)
}

/// Most bodies of a scene that are listed one by one.
const LISTED: usize = 40;

/// Tells what was understood of a scene.
pub(crate) fn info(args: &Info) -> Outcome {
    let mut loaded = load(&args.source, None)?;
    loaded.read_visuals();
    let scene = loaded.scene();
    let running = build(scene, &args.source.scene)?;
    let mut page = Page::default();
    page.row("scene", &one_line(&format!("{} - {}", args.source.scene, scene.summary)));
    let (g, c) = (scene.config.gravity, &scene.config);
    page.row("gravity", &format!("({}, {}, {}) m/s2", g.x, g.y, g.z));
    let substeps = if c.substeps == 0 { c.method.substeps() } else { c.substeps };
    page.row(
        "made for",
        &format!(
            "{} s at {} Hz, {}, {}",
            scene.seconds,
            scene.hz,
            c.method.name(),
            count(substeps, "substep")
        ),
    );
    let joining = scene.script.joining().count();
    let mut kinds: BTreeMap<&str, usize> = BTreeMap::new();
    let mut shapes: BTreeMap<&str, usize> = BTreeMap::new();
    let mut sensors = 0;
    for body in scene.bodies.iter().chain(scene.script.joining()) {
        *kinds.entry(kind_word(body.def.kind)).or_default() += 1;
        for shape in &body.def.shapes {
            *shapes.entry(shape.shape.kind()).or_default() += 1;
            sensors += usize::from(shape.sensor);
        }
    }
    page.row("bodies", &list(&kinds));
    if joining > 0 {
        page.row("", &format!("{joining} of them are added while it runs"));
    }
    page.row("shapes", &list(&shapes));
    if sensors > 0 {
        page.row("", &format!("{sensors} of them are sensors"));
    }
    page.row("joints", &scene.joints.len().to_string());
    if !scene.visuals.is_empty() {
        let v = &scene.visuals;
        let (parts, materials) =
            (count(v.meshes.len(), "visible part"), count(v.materials.len(), "material"));
        page.row("shown", &format!("{parts}, {materials}, {}", count(v.images.len(), "image")));
    }
    if !scene.couplings.is_empty() {
        page.row("", &format!("{} of them follow another", scene.couplings.len()));
    }
    rows_of_rest(scene, &mut page);
    let masses: Vec<f64> = running
        .world
        .bodies()
        .filter(|b| b.kind() == BodyKind::Dynamic)
        .map(|b| f64::from(b.mass()))
        .collect();
    if !masses.is_empty() {
        let least = masses.iter().copied().fold(f64::INFINITY, f64::min);
        let most = masses.iter().copied().fold(0.0, f64::max);
        let total: f64 = masses.iter().sum();
        page.row("mass", &format!("{total:.6} kg in all; {least} to {most} kg a body"));
    }
    let energy = (running.world.kinetic_energy(), running.world.potential_energy());
    page.row("energy", &format!("kinetic {}, potential {}", si(energy.0, "J"), si(energy.1, "J")));
    if scene.bodies.len() <= LISTED {
        for (body, &id) in scene.bodies.iter().zip(&running.bodies) {
            let mass = running.world.body(id).filter(|b| b.kind() == BodyKind::Dynamic);
            let mass = mass.map_or_else(String::new, |b| format!(", {} kg", b.mass()));
            let mut shapes: BTreeMap<&str, usize> = BTreeMap::new();
            for shape in &body.def.shapes {
                *shapes.entry(shape.shape.kind()).or_default() += 1;
            }
            let (name, kind) = (one_line(&body.name), kind_word(body.def.kind));
            page.row("body", &format!("{name}: {kind}, {}{mass}", list(&shapes)));
        }
    }
    for note in lines_of(&scene.notes) {
        page.row("note", &note);
    }
    if scene.notes.is_empty() {
        page.row("note", "nothing was ignored");
    }
    output::print(&page.text)?;
    Ok(ExitCode::SUCCESS)
}

/// Particles, rules and the script, where there are some.
fn rows_of_rest(scene: &Scene, page: &mut Page) {
    let mut strands: BTreeMap<&str, usize> = BTreeMap::new();
    for strand in &scene.strands {
        let kind = match strand.def {
            StrandDef::Rope(_) => "rope",
            StrandDef::Cloth(_) => "cloth",
            _ => "cloud",
        };
        *strands.entry(kind).or_default() += 1;
    }
    if !strands.is_empty() {
        page.row("particles", &list(&strands));
    }
    if !scene.surface_rules.is_empty() {
        page.row("rules", &format!("{} of surfaces", count(scene.surface_rules.len(), "rule")));
    }
    if !scene.never_collide.is_empty() {
        page.row(
            "rules",
            &format!("{}, which never collide", count(scene.never_collide.len(), "pair")),
        );
    }
    let script = match &scene.script {
        Script::None => return,
        Script::Orbit { .. } => "a body goes round",
        Script::Drop { .. } => "bodies join one after the other",
        Script::Loads { .. } => "forces act on bodies",
        Script::Waves(_) => "bodies come and go",
        _ => "bodies follow a film",
    };
    page.row("script", script);
}

const fn kind_word(kind: BodyKind) -> &'static str {
    match kind {
        BodyKind::Static => "static",
        BodyKind::Kinematic => "kinematic",
        BodyKind::Dynamic => "dynamic",
    }
}

/// `3 box, 2 sphere`, or `none`.
fn list(counts: &BTreeMap<&str, usize>) -> String {
    if counts.is_empty() {
        return "none".to_owned();
    }
    let parts: Vec<String> = counts.iter().map(|(word, n)| format!("{n} {word}")).collect();
    parts.join(", ")
}
