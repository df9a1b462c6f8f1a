//! What was found, in a form that can be told apart, counted and looked for again.

/// What kind of thing broke.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Kind {
    /// A panic.
    Panic,
    /// Nothing was heard for longer than the limit.
    Hang,
    /// The process died by a signal or ended early.
    Crash,
    /// A public getter gave infinity or NaN.
    BadNumber,
    /// Two queries whose answers follow from each other gave other ones.
    Disagree,
    /// Two runs that must be the same were not.
    HashDiffers,
    /// A world refused its own snapshot, or became another one by it.
    SnapshotRefused,
    /// An event that ends has no beginning, or the other way round.
    Unpaired,
    /// An id of something that is gone names something.
    Stale,
    /// An ordinary world had a fault; only if asked for.
    Fault,
    /// A body of an ordinary world became faster than anything could make it; only if asked for.
    Wild,
    /// Memory grew over a run in which as much went as came.
    Growth,
    /// The command ended with a status, or wrote something, that it must not.
    Command,
    /// Energy comes from nothing.
    Energy,
    /// Momentum comes from nothing.
    Momentum,
    /// A body passes through another, or is deep in it.
    Through,
    /// What rests overlaps by more than one does not see.
    Overlap,
    /// A joint stays open.
    Gap,
    /// A body rests where it is in no equilibrium.
    Balance,
    /// What must come to rest does not.
    Restless,
    /// What is driven or carried stands.
    Stalled,
    /// A stack does not stand.
    Fallen,
    /// What slides without friction does not go straight on.
    Glide,
    /// What has no restitution bounces.
    Bounce,
    /// A landing or a passage has no event.
    Missed,
    /// A world and its twin differ.
    Twin,
}

impl Kind {
    /// All of them.
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

    /// Those that only the hunt finds.
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

/// Something that broke.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Finding {
    /// What kind of thing.
    pub kind: Kind,
    /// What it was, without numbers of this case: the same for all cases of one cause, as far as that can be told.
    pub what: String,
    /// What it was in this case.
    pub detail: String,
    /// The step in which it was noticed.
    pub step: u32,
}

impl Finding {
    /// Whether both are most likely of the same cause.
    #[must_use]
    pub fn is_like(&self, other: &Self) -> bool {
        self.kind == other.kind && self.what == other.what
    }

    /// As a line of a worker's report.
    #[must_use]
    pub fn to_line(&self) -> String {
        let flat = |text: &str| text.replace(['\t', '\n', '\r'], " ");
        let (kind, what, detail) = (self.kind.name(), flat(&self.what), flat(&self.detail));
        format!("{kind}\t{what}\t{detail}\t{}", self.step)
    }

    /// From such a line.
    #[must_use]
    pub fn from_line(line: &str) -> Option<Self> {
        let mut parts = line.split('\t');
        let kind = Kind::named(parts.next()?)?;
        let (what, detail) = (parts.next()?.to_owned(), parts.next()?.to_owned());
        Some(Self { kind, what, detail, step: parts.next()?.parse().ok()? })
    }
}

/// Findings of one unit of work, one of each cause.
#[derive(Clone, Debug, Default)]
pub struct Findings {
    /// Those found so far.
    pub all: Vec<Finding>,
}

/// More of one unit are not kept: they follow from the first ones.
const MOST: usize = 8;

impl Findings {
    /// Adds one, unless there is one like it.
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

    /// Whether there is one like this.
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
