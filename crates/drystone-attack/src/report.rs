//! The report of a campaign: counts by subject, and a file for each finding.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write;
use std::path::{Path, PathBuf};

use crate::finding::{Finding, Kind};
use crate::hunt::Scene;
use crate::op::Style;
use crate::unit::{Subject, Unit};

/// Maximum number of files with findings of one cause; more are only counted.
const MOST_FILES: u64 = 10;

/// Maximum number of seeds listed for one oracle and one kind of scene.
const MOST_SEEDS: usize = 10;

/// Counts for one subject, or for one style of worlds.
#[derive(Clone, Copy, Debug, Default)]
struct Row {
    units: u64,
    tried: u64,
    steps: u64,
    refused: u64,
    faulty: u64,
    faults: u64,
    wild: u64,
    cut: u64,
    failed: u64,
}

impl Row {
    fn add(&mut self, unit: &Unit) {
        self.units += 1;
        self.tried += unit.tried;
        self.steps += unit.steps;
        self.refused += unit.refused;
        self.faulty += u64::from(unit.faults > 0);
        self.faults += unit.faults;
        self.wild += u64::from(unit.is_wild);
        self.cut += u64::from(unit.is_cut);
        self.failed += u64::from(unit.failed);
    }
}

/// The results of a campaign.
#[derive(Clone, Debug, Default)]
pub struct Report {
    /// Duration [s].
    pub seconds: f64,
    out: PathBuf,
    subjects: BTreeMap<Subject, Row>,
    styles: BTreeMap<Style, Row>,
    /// Known causes, as `subject kind what`.
    known: BTreeSet<String>,
    /// Number of findings by subject, kind and cause, and the first seeds.
    causes: BTreeMap<(Subject, Kind, String), (u64, Vec<u64>)>,
    /// Number of worlds of each kind of scene with findings of an oracle, and the first seeds.
    scenes: BTreeMap<(Scene, Kind), (u64, Vec<u64>)>,
}

impl Report {
    /// Makes the report of a campaign with findings in this folder; `known` lists known causes, one
    /// per line.
    #[must_use]
    pub fn new(out: &Path, known: &str) -> Self {
        let lines = known.lines().map(str::trim).filter(|line| !line.starts_with('#'));
        let known = lines.filter(|line| !line.is_empty()).map(str::to_owned).collect();
        Self { out: out.to_owned(), known, ..Self::default() }
    }

    fn is_known(&self, (subject, kind, what): &(Subject, Kind, String)) -> bool {
        if let Subject::Scene(scene) = subject {
            // For physics, the cause is an oracle and a kind of scene.
            return self.known.contains(&format!("{} {}", kind.name(), scene.name()));
        }
        self.known.contains(&format!("{} {} {what}", subject.name(), kind.name()))
    }

    /// Number of units tried of a subject.
    #[must_use]
    pub fn tried(&self, subject: Subject) -> u64 {
        self.subjects.get(&subject).map_or(0, |row| row.tried)
    }

    /// Number of worlds tried of all kinds.
    #[must_use]
    pub fn worlds(&self) -> u64 {
        let is_world = |s: &Subject| matches!(s, Subject::Worlds | Subject::Scene(_));
        self.subjects.iter().filter(|(s, _)| is_world(s)).map(|(_, row)| row.tried).sum()
    }

    /// Whether there are findings that are not known.
    #[must_use]
    pub fn has_findings(&self) -> bool {
        self.causes.keys().any(|cause| !self.is_known(cause))
    }

    /// Counts a unit.
    pub fn add(&mut self, subject: Subject, unit: &Unit) {
        self.subjects.entry(subject).or_default().add(unit);
        if let Some(style) = unit.style {
            self.styles.entry(style).or_default().add(unit);
        }
    }

    /// Counts a finding, and writes its file.
    pub fn found(&mut self, subject: Subject, seed: u64, finding: &Finding) {
        let key = (subject, finding.kind, finding.what.clone());
        if let Subject::Scene(scene) = subject {
            let (worlds, seeds) = self.scenes.entry((scene, finding.kind)).or_default();
            // Findings of one world are consecutive.
            if seeds.last() != Some(&seed) {
                *worlds += 1;
                seeds.truncate(MOST_SEEDS);
                seeds.push(seed);
            }
        }
        let (count, seeds) = self.causes.entry(key).or_default();
        *count += 1;
        if *count > MOST_FILES {
            return;
        }
        seeds.push(seed);
        let name = format!("{}-{}-{seed}.txt", subject.name(), finding.kind.name());
        let task = if matches!(subject, Subject::Scene(_)) { "hunt" } else { "attack" };
        let again = format!("cargo xtask {task} repeat {}:{seed}", subject.name());
        let text = format!(
            "seed    {}:{seed}\nkind    {}\nwhat    {}\nstep    {}\ndetail  {}\nagain   {again}\n\n",
            subject.name(),
            finding.kind.name(),
            finding.what,
            finding.step,
            finding.detail
        );
        let path = self.out.join(name);
        // Findings of one seed share a file.
        let before = std::fs::read_to_string(&path).unwrap_or_default();
        if !before.contains(&text) {
            // If writing fails, the finding is still in the table.
            let _ = std::fs::write(&path, before + &text);
        }
    }

    /// A line for the progress bar.
    #[must_use]
    pub fn line(&self) -> String {
        let findings: u64 = self.causes.values().map(|(count, _)| count).sum();
        let worlds = self.worlds();
        format!("{worlds} worlds, {findings} findings of {} causes", self.causes.len())
    }

    /// The tables.
    #[must_use]
    pub fn table(&self) -> String {
        if self.subjects.keys().any(|subject| matches!(subject, Subject::Scene(_))) {
            return self.hunt_table();
        }
        let mut text = String::new();
        let kinds = [
            Kind::Panic,
            Kind::Hang,
            Kind::Crash,
            Kind::BadNumber,
            Kind::Disagree,
            Kind::HashDiffers,
            Kind::SnapshotRefused,
            Kind::Unpaired,
            Kind::Stale,
            Kind::Growth,
            Kind::Command,
        ];
        text.push_str("| subject | tried | steps | refused ");
        kinds.iter().for_each(|kind| push(&mut text, format_args!("| {} ", kind.name())));
        text.push_str("|\n|---|---|---|---");
        kinds.iter().for_each(|_| text.push_str("|---"));
        text.push_str("|\n");
        for (subject, row) in &self.subjects {
            let Row { tried, steps, refused, .. } = row;
            push(&mut text, format_args!("| {} | {tried} | {steps} | {refused} ", subject.name()));
            for kind in kinds {
                push(&mut text, format_args!("| {} ", self.count(*subject, kind)));
            }
            text.push_str("|\n");
        }
        text.push_str(
            "\n| style | worlds | steps | with faults | faults | over 1000 m/s | too slow |\n",
        );
        text.push_str("|---|---|---|---|---|---|---|\n");
        for (style, row) in &self.styles {
            let Row { tried, steps, faulty, faults, wild, cut, .. } = row;
            let name = style.name();
            push(
                &mut text,
                format_args!(
                    "| {name} | {tried} | {steps} | {faulty} | {faults} | {wild} | {cut} |\n"
                ),
            );
        }
        self.causes_to(&mut text);
        #[expect(clippy::cast_precision_loss, reason = "for reading")]
        let rate = self.worlds() as f64 / self.seconds.max(1.0e-3);
        push(&mut text, format_args!("\n{:.0} s, {rate:.1} worlds/s\n", self.seconds));
        text
    }

    /// Tested and failed worlds by kind of scene and oracle, and the first seeds of each.
    fn hunt_table(&self) -> String {
        let mut text = "| scene | worlds | cut | failed ".to_owned();
        let kinds: Vec<Kind> = Kind::ALL
            .into_iter()
            .filter(|kind| {
                Kind::PHYSICS.contains(kind) || self.scenes.keys().any(|(_, other)| other == kind)
            })
            .collect();
        kinds.iter().for_each(|kind| push(&mut text, format_args!("| {} ", kind.name())));
        text.push_str("|\n|---|---|---|---");
        kinds.iter().for_each(|_| text.push_str("|---"));
        text.push_str("|\n");
        for (subject, row) in &self.subjects {
            let Subject::Scene(scene) = subject else { continue };
            let Row { tried, cut, failed, .. } = row;
            push(&mut text, format_args!("| {} | {tried} | {cut} | {failed} ", subject.name()));
            for kind in &kinds {
                let count = self.scenes.get(&(*scene, *kind)).map_or(0, |(worlds, _)| *worlds);
                push(&mut text, format_args!("| {count} "));
            }
            text.push_str("|\n");
        }
        text.push('\n');
        for ((scene, kind), (count, seeds)) in &self.scenes {
            let (scene, kind) = (scene.name(), kind.name());
            let is_known = self.known.contains(&format!("{kind} {scene}"));
            let mark = if is_known { " (known)" } else { "" };
            let seeds: Vec<String> = seeds.iter().take(MOST_SEEDS).map(u64::to_string).collect();
            push(
                &mut text,
                format_args!("{count:6} x {kind} in {scene}{mark}: {}\n", seeds.join(" ")),
            );
        }
        self.causes_to(&mut text);
        #[expect(clippy::cast_precision_loss, reason = "for reading")]
        let rate = self.worlds() as f64 / self.seconds.max(1.0e-3);
        push(&mut text, format_args!("\n{:.0} s, {rate:.1} worlds/s\n", self.seconds));
        text
    }

    fn causes_to(&self, text: &mut String) {
        if self.causes.is_empty() {
            text.push_str("\nnothing found\n");
            return;
        }
        push(text, format_args!("\nfindings, in {}:\n", self.out.display()));
        let mut causes: Vec<_> = self.causes.iter().collect();
        causes.sort_by_key(|(_, (count, _))| core::cmp::Reverse(*count));
        for (cause, (count, seeds)) in causes.iter().take(60) {
            let seed = seeds.first().copied().unwrap_or_default();
            let mark = if self.is_known(cause) { " (known)" } else { "" };
            let (subject, kind, what) = (cause.0.name(), cause.1.name(), &cause.2);
            push(text, format_args!("{count:8} x {kind}: {what}   [{subject}:{seed}]{mark}\n"));
        }
    }

    fn count(&self, subject: Subject, kind: Kind) -> u64 {
        let of = self.causes.iter().filter(|((s, k, _), _)| (*s, *k) == (subject, kind));
        of.map(|(_, (count, _))| count).sum()
    }
}

fn push(text: &mut String, what: core::fmt::Arguments<'_>) {
    // Writing to a string cannot fail.
    let _ = text.write_fmt(what);
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::Report;
    use crate::finding::{Finding, Kind};
    use crate::unit::Subject;

    #[test]
    fn what_is_known_is_counted_and_is_no_failure() {
        let finding = |what: &str| {
            let (kind, what, detail) = (Kind::BadNumber, what.to_owned(), String::new());
            Finding { kind, what, detail, step: 1 }
        };
        let folder = Path::new("/nonexistent");
        let mut report = Report::new(folder, "# list\nworlds bad-number a force\n");
        report.found(Subject::Worlds, 7, &finding("a force"));
        assert!(!report.has_findings() && report.table().contains("[worlds:7] (known)"));
        report.found(Subject::Worlds, 8, &finding("a torque"));
        report.found(Subject::Worlds, 9, &finding("a torque"));
        assert!(report.has_findings());
        assert!(report.table().contains("2 x bad-number: a torque   [worlds:8]\n"));
    }
}
