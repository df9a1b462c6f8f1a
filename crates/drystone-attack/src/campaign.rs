//! A campaign: units of all subjects in child processes. A hang or a crash costs one unit and is
//! reported with its seed.

use std::io::{BufRead, BufReader, Write};
use std::path::PathBuf;
use std::process::{Child, Command, Stdio};
use std::sync::mpsc::{Receiver, RecvTimeoutError, channel};
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressStyle};

use crate::finding::{Finding, Kind};
use crate::op::Style;
use crate::process::{resident_bytes, worked_seconds};
use crate::report::Report;
use crate::rng::mix;
use crate::unit::{Places, Subject, Unit, run_unit};

/// Options of a campaign.
#[derive(Clone, Debug)]
pub struct Options {
    /// Maximum duration.
    pub time: Duration,
    /// Number of worlds, which fixes the number of units of the other subjects too
    /// ([`Subject::units_of`]). The units are then always the same, if the time suffices.
    pub worlds: Option<u64>,
    /// Seed of the units' seeds.
    pub seed: u64,
    /// Subjects to attack.
    pub only: Vec<Subject>,
    /// Number of parallel processes.
    pub jobs: usize,
    /// Folder for findings.
    pub out: PathBuf,
    /// Paths of files and programs.
    pub places: Places,
}

/// Maximum time that one worker spends on one subject before the next one.
const SLICE: Duration = Duration::from_secs(10);

/// Interval between checks of a silent child.
const TICK: Duration = Duration::from_millis(500);

/// Factor on the time limit for a child that uses no processor time.
const WAIT: f64 = 10.0;

/// Maximum memory of a child before it is killed [bytes].
const MOST_MEMORY: u64 = 4 << 30;

/// The seed of a unit of a campaign.
#[must_use]
pub fn unit_seed(campaign: u64, number: u64) -> u64 {
    mix(mix(campaign) ^ number)
}

/// Runs a campaign, and returns its report.
///
/// # Errors
/// Fails if the folder of findings cannot be written, or no worker can be started.
pub fn run(options: &Options) -> Result<Report, String> {
    std::fs::create_dir_all(&options.out).map_err(|e| format!("{}: {e}", options.out.display()))?;
    let hunts = options.only.iter().all(|subject| matches!(subject, Subject::Scene(_)));
    let list = if hunts { "hunt-known.txt" } else { "known.txt" };
    let known = options.places.root.join("crates/drystone-attack").join(list);
    let known = std::fs::read_to_string(known).unwrap_or_default();
    let report = Mutex::new(Report::new(&options.out, &known));
    let bar = ProgressBar::new(options.time.as_secs());
    if let Ok(style) = ProgressStyle::with_template("{wide_bar} {elapsed} {msg}") {
        bar.set_style(style);
    }
    let start = Instant::now();
    let failed = std::thread::scope(|scope| {
        let slots: Vec<_> = (0..options.jobs.max(1))
            .map(|slot| {
                let (report, bar) = (&report, &bar);
                scope.spawn(move || Slot::new(options, slot, report, bar, start).work())
            })
            .collect();
        let results = slots.into_iter().map(|slot| slot.join().unwrap_or(Ok(())));
        results.filter_map(Result::err).next()
    });
    bar.finish_and_clear();
    let mut report = report.into_inner().unwrap_or_else(PoisonError::into_inner);
    report.seconds = start.elapsed().as_secs_f64();
    failed.map_or(Ok(report), Err)
}

/// One of the parallel processes.
struct Slot<'a> {
    options: &'a Options,
    slot: usize,
    report: &'a Mutex<Report>,
    bar: &'a ProgressBar,
    start: Instant,
    /// Number of units of each subject so far, and their duration [s].
    spent: Vec<(Subject, u64, f64)>,
}

impl<'a> Slot<'a> {
    fn new(
        options: &'a Options,
        slot: usize,
        report: &'a Mutex<Report>,
        bar: &'a ProgressBar,
        start: Instant,
    ) -> Self {
        let spent = options.only.iter().map(|subject| (*subject, 0, 0.0)).collect();
        Self { options, slot, report, bar, start, spent }
    }

    fn report(&self) -> std::sync::MutexGuard<'_, Report> {
        self.report.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn work(&mut self) -> Result<(), String> {
        loop {
            let left = self.options.time.saturating_sub(self.start.elapsed());
            if left.is_zero() {
                return Ok(());
            }
            // The subject that is farthest behind its share of the time.
            let behind = |(subject, _, spent): &(Subject, u64, f64)| spent / subject.weight();
            let next = (0..self.spent.len())
                .filter(|i| self.left(self.spent[*i].0, self.spent[*i].1) > 0)
                .min_by(|a, b| behind(&self.spent[*a]).total_cmp(&behind(&self.spent[*b])));
            let Some(next) = next else { return Ok(()) };
            // Each subject gets several turns.
            let turns = u32::try_from(3 * self.spent.len()).unwrap_or(u32::MAX).max(12);
            let part = (self.options.time / turns).clamp(Duration::from_millis(500), SLICE);
            let begin = Instant::now();
            let (subject, first, _) = self.spent[next];
            let units = self.slice(subject, first, left.min(part))?;
            self.spent[next].1 += units;
            self.spent[next].2 += begin.elapsed().as_secs_f64();
        }
    }

    /// Number of units of a subject that remain for this slot after `done` units. A counted
    /// campaign has the same units for any number of slots.
    fn left(&self, subject: Subject, done: u64) -> u64 {
        let Some(worlds) = self.options.worlds else { return u64::MAX };
        let (jobs, slot) = (self.options.jobs.max(1) as u64, self.slot as u64);
        let each = subject.units_of(worlds, self.options.only.len());
        each.saturating_sub(slot).div_ceil(jobs).saturating_sub(done)
    }

    /// Runs a child for a while; returns the number of units it finished.
    fn slice(&self, subject: Subject, first: u64, time: Duration) -> Result<u64, String> {
        let jobs = self.options.jobs.max(1) as u64;
        let first_number = first * jobs + self.slot as u64;
        let most = self.left(subject, first);
        let mut child = self.child(subject, [first_number, jobs, most], time)?;
        let lines = lines_of(&mut child);
        let (limit, process) = (subject.limit(), child.id().to_string());
        let (mut units, mut current): (u64, Option<u64>) = (0, None);
        let mut last = (Instant::now(), 0.0);
        loop {
            match lines.recv_timeout(TICK) {
                Ok(line) => {
                    last = (Instant::now(), worked_seconds(&process));
                    let (word, rest) = line.split_once(' ').unwrap_or((&line, ""));
                    match word {
                        "begin" => current = rest.parse().ok(),
                        "finding" => {
                            if let (Some(seed), Some(finding)) = (current, Finding::from_line(rest))
                            {
                                self.report().found(subject, seed, &finding);
                            }
                        }
                        "done" => {
                            self.report().add(subject, &from_line(rest));
                            (units, current) = (units + 1, None);
                        }
                        _ => {}
                    }
                    self.show();
                }
                Err(RecvTimeoutError::Timeout) => {
                    // Measured in the child's processor time; a child that waits for ever uses
                    // none.
                    let is_late = worked_seconds(&process) - last.1 > limit
                        || last.0.elapsed().as_secs_f64() > WAIT * limit;
                    let is_large = resident_bytes(&process) > MOST_MEMORY;
                    if !is_late && !is_large {
                        continue;
                    }
                    let _ = child.kill();
                    let _ = child.wait();
                    if is_late {
                        let what = format!("no end within {limit} s of work");
                        self.lost(subject, current, Kind::Hang, what);
                    } else {
                        self.lost(subject, current, Kind::Growth, "over 4 GB".to_owned());
                    }
                    return Ok(units + 1);
                }
                Err(RecvTimeoutError::Disconnected) => {
                    let status = child.wait().map_err(|e| format!("a worker: {e}"))?;
                    if !status.success() {
                        self.lost(subject, current, Kind::Crash, status.to_string());
                        return Ok(units + 1);
                    }
                    return Ok(units);
                }
            }
        }
    }

    fn lost(&self, subject: Subject, seed: Option<u64>, kind: Kind, what: String) {
        let Some(seed) = seed else { return };
        let finding = Finding { kind, what, detail: String::new(), step: 0 };
        let mut report = self.report();
        report.add(subject, &Unit { tried: 1, ..Unit::default() });
        report.found(subject, seed, &finding);
    }

    fn show(&self) {
        self.bar.set_position(self.start.elapsed().as_secs());
        if !self.bar.is_hidden() {
            self.bar.set_message(self.report().line());
        }
    }

    fn child(&self, subject: Subject, units: [u64; 3], time: Duration) -> Result<Child, String> {
        let program = std::env::current_exe().map_err(|e| format!("the program itself: {e}"))?;
        let places = &self.options.places;
        let mut command = Command::new(program);
        command.arg("worker").arg(subject.name()).args(units.map(|n| n.to_string()));
        command.arg(time.as_millis().to_string()).arg(self.options.seed.to_string());
        command.arg("--root").arg(&places.root);
        command.arg("--scratch").arg(places.scratch.join(self.slot.to_string()));
        if let Some(path) = &places.command {
            command.arg("--command").arg(path);
        }
        if places.strict {
            command.arg("--strict");
        }
        let child =
            command.stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::null()).spawn();
        child.map_err(|e| format!("a worker: {e}"))
    }
}

fn lines_of(child: &mut Child) -> Receiver<String> {
    let (sender, receiver) = channel();
    if let Some(stream) = child.stdout.take() {
        std::thread::spawn(move || {
            for line in BufReader::new(stream).lines().map_while(Result::ok) {
                if sender.send(line).is_err() {
                    return;
                }
            }
        });
    }
    receiver
}

/// The work of a child: units one after the other, each reported before and after on the standard
/// output. The arguments are the first unit, the stride, the number, the time [ms] and the
/// campaign's seed.
///
/// # Errors
/// Fails if the output is closed.
pub fn worker(
    subject: Subject,
    [first, stride, most, milliseconds, campaign]: [u64; 5],
    places: &Places,
) -> std::io::Result<()> {
    let start = Instant::now();
    let mut out = std::io::stdout().lock();
    let (mut number, mut done) = (first, 0);
    while done < most && start.elapsed() < Duration::from_millis(milliseconds) {
        let seed = unit_seed(campaign, number);
        writeln!(out, "begin {seed}")?;
        out.flush()?;
        let unit = run_unit(subject, seed, places);
        for finding in &unit.findings.all {
            writeln!(out, "finding {}", finding.to_line())?;
        }
        writeln!(out, "done {}", to_line(&unit))?;
        out.flush()?;
        (number, done) = (number + stride, done + 1);
    }
    Ok(())
}

fn to_line(unit: &Unit) -> String {
    let style = unit.style.map_or("-", Style::name);
    let Unit { tried, steps, refused, faults, is_wild, is_cut, .. } = unit;
    let [wild, cut, failed] =
        [*is_wild, *is_cut, unit.failed || !unit.findings.all.is_empty()].map(u8::from);
    format!("{tried} {steps} {refused} {faults} {wild} {cut} {failed} {style}")
}

fn from_line(line: &str) -> Unit {
    let mut words = line.split(' ');
    let mut number = || words.next().and_then(|word| word.parse().ok()).unwrap_or(0);
    let [tried, steps, refused, faults, wild, cut, failed] = [0; 7].map(|_: u8| number());
    let style = words.next().and_then(|name| Style::ALL.into_iter().find(|s| s.name() == name));
    let (is_wild, is_cut, failed) = (wild > 0, cut > 0, failed > 0);
    Unit { tried, steps, refused, faults, is_wild, is_cut, failed, style, ..Unit::default() }
}

#[cfg(test)]
mod tests {
    use super::{from_line, to_line};
    use crate::op::Style;
    use crate::unit::Unit;

    #[test]
    fn what_a_unit_came_to_survives_being_written() {
        let unit = Unit {
            tried: 3,
            steps: 700,
            is_wild: true,
            style: Some(Style::Edge),
            ..Unit::default()
        };
        assert_eq!(to_line(&from_line(&to_line(&unit))), to_line(&unit));
        assert_eq!(to_line(&unit), "3 700 0 0 1 0 0 edge");
    }
}
