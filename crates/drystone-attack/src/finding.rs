//! Findings, in a form that can be compared, counted and searched for again.

/// Kind of a failure.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Kind {
    /// A panic.
    Panic,
    /// No sign of life for longer than the limit.
    Hang,
    /// The process died by a signal or ended early.
    Crash,
    /// A public getter returned infinity or NaN.
    BadNumber,
    /// Two queries whose answers follow from each other disagree.
    Disagree,
    /// Two runs that must be equal differ.
    HashDiffers,
    /// A world refused its own snapshot, or restored to another state.
    SnapshotRefused,
    /// An end event has no begin event, or the reverse.
    Unpaired,
    /// An id of a removed object names an object.
    Stale,
    /// An ordinary world had a fault; reported only on request.
    Fault,
    /// A body of an ordinary world exceeded any plausible speed; reported only on request.
    Wild,
    /// Memory grew over a run that removed as many objects as it added.
    Growth,
    /// The command exited with a wrong status, or wrote wrong output.
    Command,
    /// Energy increases without a source.
    Energy,
    /// Momentum changes without a source.
    Momentum,
    /// A body passes through another, or is deep inside it.
    Through,
    /// Bodies at rest overlap visibly.
    Overlap,
    /// A joint stays separated.
    Gap,
    /// A body rests without being in equilibrium.
    Balance,
    /// Bodies that must come to rest do not.
    Restless,
    /// A driven or carried body does not move.
    Stalled,
    /// A stack falls.
    Fallen,
    /// A body that slides without friction leaves its straight path.
    Glide,
    /// A body without restitution bounces.
    Bounce,
    /// A landing or a sensor crossing has no event.
    Missed,
    /// A world and its twin differ.
    Twin,
}

impl Kind {
    /// All kinds.
    pub const ALL: [Self; 26] = [
        Self::Panic,
        Self::Hang,
        Self::Crash,
        Self::BadNumber,
        Self::Disagree,
        Self::HashDiffers,
        Self::SnapshotRefused,
        Self::Unpaired,
        Self::Stale,
        Self::Fault,
        Self::Wild,
        Self::Growth,
        Self::Command,
        Self::Energy,
        Self::Momentum,
        Self::Through,
        Self::Overlap,
        Self::Gap,
        Self::Balance,
        Self::Restless,
        Self::Stalled,
        Self::Fallen,
        Self::Glide,
        Self::Bounce,
        Self::Missed,
        Self::Twin,
    ];

    /// The kinds that only the hunt finds.
    pub const PHYSICS: [Self; 13] = [
        Self::Energy,
        Self::Momentum,
        Self::Through,
        Self::Overlap,
        Self::Gap,
        Self::Balance,
        Self::Restless,
        Self::Stalled,
        Self::Fallen,
        Self::Glide,
        Self::Bounce,
        Self::Missed,
        Self::Twin,
    ];

    /// Its name.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Panic => "panic",
            Self::Hang => "hang",
            Self::Crash => "crash",
            Self::BadNumber => "bad-number",
            Self::Disagree => "disagree",
            Self::HashDiffers => "hash-differs",
            Self::SnapshotRefused => "snapshot-refused",
            Self::Unpaired => "unpaired",
            Self::Stale => "stale",
            Self::Fault => "fault",
            Self::Wild => "wild",
            Self::Growth => "growth",
            Self::Command => "command",
            Self::Energy => "energy",
            Self::Momentum => "momentum",
            Self::Through => "through",
            Self::Overlap => "overlap",
            Self::Gap => "gap",
            Self::Balance => "balance",
            Self::Restless => "restless",
            Self::Stalled => "stalled",
            Self::Fallen => "fallen",
            Self::Glide => "glide",
            Self::Bounce => "bounce",
            Self::Missed => "missed",
            Self::Twin => "twin",
        }
    }

    /// The kind of this name.
    #[must_use]
    pub fn named(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|kind| kind.name() == name)
    }
}

/// A failure.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Finding {
    /// Its kind.
    pub kind: Kind,
    /// Description without numbers of this case, the same for all cases of one cause as far as
    /// possible.
    pub what: String,
    /// Details of this case.
    pub detail: String,
    /// The step in which it was detected.
    pub step: u32,
}

impl Finding {
    /// Whether both probably have the same cause.
    #[must_use]
    pub fn is_like(&self, other: &Self) -> bool {
        self.kind == other.kind && self.what == other.what
    }

    /// Formats the finding as a line of a worker's report.
    #[must_use]
    pub fn to_line(&self) -> String {
        let flat = |text: &str| text.replace(['\t', '\n', '\r'], " ");
        let (kind, what, detail) = (self.kind.name(), flat(&self.what), flat(&self.detail));
        format!("{kind}\t{what}\t{detail}\t{}", self.step)
    }

    /// Parses such a line.
    #[must_use]
    pub fn from_line(line: &str) -> Option<Self> {
        let mut parts = line.split('\t');
        let kind = Kind::named(parts.next()?)?;
        let (what, detail) = (parts.next()?.to_owned(), parts.next()?.to_owned());
        Some(Self { kind, what, detail, step: parts.next()?.parse().ok()? })
    }
}

/// Findings of one unit of work, one for each cause.
#[derive(Clone, Debug, Default)]
pub struct Findings {
    /// Findings so far.
    pub all: Vec<Finding>,
}

/// Maximum number of findings kept from one unit; later ones follow from the first.
const MOST: usize = 8;

impl Findings {
    /// Adds a finding, unless a similar one exists.
    pub fn add(
        &mut self,
        kind: Kind,
        what: impl Into<String>,
        detail: impl Into<String>,
        step: u32,
    ) {
        let what = what.into();
        if self.all.len() < MOST && !self.all.iter().any(|f| f.kind == kind && f.what == what) {
            self.all.push(Finding { kind, what, detail: detail.into(), step });
        }
    }

    /// Whether a similar finding exists.
    #[must_use]
    pub fn have(&self, like: &Finding) -> bool {
        self.all.iter().any(|f| f.is_like(like))
    }
}

#[cfg(test)]
mod tests {
    use super::{Finding, Kind};

    #[test]
    fn a_finding_survives_being_written() {
        let detail = "index\tout\nof bounds".to_owned();
        let finding = Finding { kind: Kind::Panic, what: "a.rs:1".into(), detail, step: 7 };
        let read = Finding::from_line(&finding.to_line()).unwrap();
        assert!(read.is_like(&finding) && read.step == 7 && read.detail == "index out of bounds");
        assert!(Kind::ALL.into_iter().all(|kind| Kind::named(kind.name()) == Some(kind)));
    }
}
