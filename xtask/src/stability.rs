//! `cargo xtask stability`: writes long runs of scenes that must stand into docs/stability.md. It
//! lists their sag and drift, and the time of a step with load-adaptive inertia and without.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::path::Path;
use std::process::Command;

use serde_json::Value;

use crate::{Outcome, release_command, root, target, write_whole};

/// Scene, seconds, further flags, and whether it must stand.
type Case = (&'static str, u32, &'static [&'static str], bool);

const REFINED: &[&str] = &["--set", "inertia.refine=2"];
const NO_RECYCLING: &[&str] = &["--set", "contact.recycle_distance=0"];

const CASES: [Case; 47] = [
    ("stack:n=10", 600, &[], true),
    ("stack:n=20", 600, &[], true),
    ("stack:n=30", 600, &[], true),
    ("stack:n=50", 600, &[], true),
    ("stack:n=100", 600, &[], true),
    ("stack:n=30", 600, REFINED, true),
    ("stack:n=100", 600, REFINED, true),
    ("stack:n=11,top_mass_ratio=10", 60, &[], true),
    ("stack:n=11,top_mass_ratio=100", 60, &[], true),
    ("stack:n=11,top_mass_ratio=300", 60, &[], true),
    ("stack:n=11,top_mass_ratio=1000", 60, &[], true),
    ("stack:n=11,top_mass_ratio=2000", 60, &[], true),
    ("stack:n=11,top_mass_ratio=100", 60, REFINED, true),
    ("stack:n=11,top_mass_ratio=1000", 60, REFINED, true),
    ("stack:n=11,top_mass_ratio=2000", 60, REFINED, true),
    ("pyramid:base=60", 60, &[], true),
    ("pyramid:base=60", 60, NO_RECYCLING, true),
    ("pyramid:base=80", 60, &[], true),
    ("large_pyramid", 167, &[], true),
    ("tiny_pyramid", 60, &[], true),
    ("wall", 60, &[], true),
    ("tower", 60, &[], true),
    ("jenga:layers=30", 60, &[], true),
    ("jenga:layers=30", 60, REFINED, true),
    ("card_house:levels=2,thickness=0.01", 60, &[], true),
    ("card_house:levels=3,thickness=0.01", 60, &[], true),
    ("card_house:levels=5,thickness=0.01", 60, &[], true),
    ("card_house:levels=2,thickness=0.02", 60, &[], true),
    ("card_house:levels=5,thickness=0.02", 60, &[], true),
    ("arch:stones=25", 60, &[], true),
    ("arch:stones=101", 60, &[], true),
    ("catenary_arch:stones=25,gap=0", 60, &[], true),
    ("catenary_arch:stones=101,gap=0", 60, &[], true),
    ("kapla", 600, &[], true),
    ("stack_drop:mass_ratio=100", 20, &[], true),
    ("stack_drop:mass_ratio=140", 20, &[], true),
    ("stack_drop:mass_ratio=180", 20, &[], true),
    ("stack_drop:mass_ratio=220", 20, &[], true),
    ("stack_drop:mass_ratio=260", 20, &[], true),
    ("stack_drop:mass_ratio=300", 20, &[], true),
    ("stack_drop:mass_ratio=340", 20, &[], true),
    ("stack_drop:mass_ratio=380", 20, &[], true),
    ("stack_drop:mass_ratio=420", 20, &[], true),
    ("stack_drop:mass_ratio=460", 20, &[], true),
    ("stack_drop:mass_ratio=500", 20, &[], true),
    ("falling_tower", 20, &[], false),
    ("tower_minus_base", 20, &[], false),
];

/// A body has fallen if it sank or drifted by this fraction of the scene's height.
const FALLEN: f64 = 0.2;

struct Figures {
    sag: f64,
    drift: f64,
    overlap: f64,
    height: f64,
    ms: f64,
}

impl Figures {
    fn stands(&self) -> bool {
        self.sag < FALLEN * self.height && self.drift < FALLEN * self.height
    }
}

/// Runs all cases and writes the page. Fails if a scene stands that must fall, or falls that must
/// stand.
pub fn run() -> Outcome {
    let (binary, target) = (release_command()?, target());
    let mut page = String::from(HEAD);
    let mut wrong = Vec::new();
    for (scene, seconds, flags, must_stand) in CASES {
        let with = measure(&binary, &target, scene, seconds, flags)?;
        // For the time of a step: a tenth of the run is enough, and the minimum of three
        // alternating runs.
        let off = [flags, &["--set", "inertia.max_factor=1"]].concat();
        let (mut same, mut without) = (f64::INFINITY, f64::INFINITY);
        for _ in 0..3 {
            let time = |flags| measure(&binary, &target, scene, (seconds / 10).clamp(5, 20), flags);
            same = same.min(time(flags)?.ms);
            without = without.min(time(&off)?.ms);
        }
        let name = [&[scene], flags].concat().join(" ").replace("--set ", "");
        let verdict = match (with.stands(), must_stand) {
            (true, true) => "stands",
            (false, true) => "**falls**",
            (true, false) => "**stands**",
            (false, false) => "falls, as it must",
        };
        let Figures { sag, drift, overlap, .. } = with;
        let line = format!(
            "| `{name}` | {seconds} | {verdict} | {sag:.4} | {drift:.4} | {:.2} | {:.3} | {:.3} |",
            1000.0 * overlap,
            same,
            without,
        );
        println!("{line}");
        let _ = writeln!(page, "{line}");
        if with.stands() != must_stand {
            wrong.push(name);
        }
    }
    let path = root().join("docs/stability.md");
    write_whole(&path, &page)?;
    if wrong.is_empty() { Ok(()) } else { Err(format!("not as it must: {}", wrong.join(", "))) }
}

const HEAD: &str = "# Stability

What must stand, and what must fall. Default method, 60 Hz, its own substeps, one thread, sleep off. Written by `cargo xtask stability`.

*Sag* and *drift*: how far the body that went farthest came down, and sideways [m]. *Overlap*: the deepest one at the end [mm]. The last columns: milliseconds
a step over the first seconds, with load-adaptive inertia and with `inertia.max_factor=1`, which has none (what falls without it has less to do).

| scene | seconds | | sag | drift | overlap | ms | ms without |
| --- | ---: | --- | ---: | ---: | ---: | ---: | ---: |
";

fn measure(
    binary: &Path,
    folder: &Path,
    scene: &str,
    seconds: u32,
    flags: &[&str],
) -> Result<Figures, String> {
    let (report, trace) = (folder.join("stability.json"), folder.join("stability.csv"));
    let steps = seconds * 60;
    let mut command = Command::new(binary);
    command.args(["simulate", scene, "--steps", &steps.to_string(), "--threads", "1"]);
    command.args(["--set", "sleep.enabled=false", "--hz", "60"]).args(flags);
    command.arg("--report").arg(&report);
    command.arg("--trace").arg(&trace).args(["--every", &steps.to_string()]);
    let output = command.output().map_err(|e| format!("{}: {e}", binary.display()))?;
    if !output.status.success() {
        return Err(format!("{scene}: {}", String::from_utf8_lossy(&output.stderr)));
    }
    let text = std::fs::read_to_string(&report).map_err(|e| format!("{scene}: {e}"))?;
    let report: Value = serde_json::from_str(&text).map_err(|e| format!("{scene}: {e}"))?;
    let number = |group: &str, key: &str| {
        report[group][key]
            .as_f64()
            .ok_or_else(|| format!("{scene}: no {group}.{key} in the report"))
    };
    let text = std::fs::read_to_string(&trace).map_err(|e| format!("{scene}: {e}"))?;
    let (sag, drift, height) =
        moved(&text).ok_or_else(|| format!("{scene}: its trace has no positions"))?;
    let (overlap, ms) = (number("penetration", "end_max")?, number("wall_ms", "step_median")?);
    Ok(Figures { sag, drift, overlap, height, ms })
}

/// Maximum sag, maximum drift and height of the bodies in a trace, from its first lines to its
/// last.
fn moved(trace: &str) -> Option<(f64, f64, f64)> {
    let mut lines = trace.lines();
    let names: Vec<&str> = lines.next()?.split(',').collect();
    let column = |name: &str| names.iter().position(|n| *n == name);
    let (body, axes) = (column("body")?, [column("px")?, column("py")?, column("pz")?]);
    let mut first: BTreeMap<&str, [f64; 3]> = BTreeMap::new();
    let (mut sag, mut drift) = (0.0_f64, 0.0_f64);
    let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
    for line in lines {
        let cells: Vec<&str> = line.split(',').collect();
        // The body that is dropped on the others.
        if cells.get(body) == Some(&"heavy cube") {
            continue;
        }
        let at = |i: usize| cells.get(i).and_then(|c| c.parse::<f64>().ok());
        let now = [at(axes[0])?, at(axes[1])?, at(axes[2])?];
        let then = *first.entry(cells.get(body)?).or_insert(now);
        sag = sag.max(then[1] - now[1]);
        drift = drift.max((now[0] - then[0]).hypot(now[2] - then[2]));
        (low, high) = (low.min(then[1]), high.max(then[1]));
    }
    (high >= low).then_some((sag, drift, high - low))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_trace_tells_how_far_bodies_went() {
        let trace = "step,time,body,px,py,pz,asleep\n0,0,a,0,1,0,0\n0,0,b,0,5,0,0\n\
                     9,1,a,0,0.75,0,0\n9,1,b,3,5,4,0\n";
        assert_eq!(moved(trace), Some((0.25, 5.0, 4.0)));
        assert_eq!(moved("step,time\n"), None);
    }

    #[test]
    fn what_fell_does_not_stand() {
        let at = |sag, drift| Figures { sag, drift, overlap: 0.0, height: 10.0, ms: 1.0 };
        assert!(at(0.1, 0.1).stands());
        assert!(!at(2.1, 0.1).stands() && !at(0.1, 2.1).stands());
    }
}
