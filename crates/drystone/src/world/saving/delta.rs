//! Differences between two snapshots, for replays on disk and for clients that join late.
//!
//! A delta is a list of pieces: some new bytes, then a run that is copied from the base. Bytes that
//! change in place keep the positions in base and snapshot in step, so a body that moved costs only
//! its changed numbers. Where rows were added or removed, hashes of the base's blocks find the
//! position where the run continues.

use super::snapshot::{checksum, split};

/// First bytes of a delta.
const MAGIC: [u8; 8] = *b"drydelta";
const VERSION: u32 = 1;

/// Hashed parts of the base begin at multiples of this, and are twice as long [bytes].
const BLOCK: usize = 8;
/// Minimum length of a run in step with the base; encoding it takes about 3 bytes. A run shorter
/// than two blocks may consist of zeros, which occur everywhere, so a longer run elsewhere takes
/// precedence.
const MIN: usize = 6;
/// Maximum ratio of a snapshot's length to that of base and delta together. It keeps a few forged
/// bytes from requesting all memory.
const MAX: usize = 16;

/// Reason why bytes are not a delta of a base.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum DeltaError {
    /// They are not a delta.
    NotADelta,
    /// They are a delta of an unsupported version of the layout.
    Version {
        /// Version of the delta.
        found: u32,
        /// Supported version.
        read: u32,
    },
    /// They belong to another base.
    WrongBase {
        /// Hash of the base that the delta names.
        named: u64,
        /// Hash of the given base.
        given: u64,
    },
    /// They were truncated or changed after they were written.
    Damaged,
}

impl core::fmt::Display for DeltaError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self {
            Self::NotADelta => write!(f, "this is no delta of a snapshot"),
            Self::Version { found, read } => {
                write!(f, "the delta must have version {read} (got {found})")
            }
            Self::WrongBase { named, given } => {
                write!(f, "the delta is of the base {named:016x}, not of {given:016x}")
            }
            Self::Damaged => write!(f, "the delta was cut off or changed"),
        }
    }
}

impl core::error::Error for DeltaError {}

/// Writes the difference of `snapshot` from `base` into `delta`, and replaces its content. The two
/// are snapshots of one world, or any other bytes. If little moved since the base, the delta is
/// small. It identifies its base by a hash.
///
/// ```
/// # fn main() -> Result<(), Box<dyn std::error::Error>> {
/// use drystone::{BodyDef, ShapeDef, World};
/// use drystone::snapshot::{apply_delta, write_delta};
///
/// let mut world = World::default();
/// for i in 0..50_u8 {
///     let at = BodyDef::dynamic().with_position([2.0 * f32::from(i), 0.0, 0.0]);
///     world.add_body(BodyDef { asleep: i > 0, ..at }.with_shape(ShapeDef::sphere(0.5)))?;
/// }
/// let base = world.snapshot();
/// world.step(1.0 / 60.0);
/// let (later, mut delta, mut again) = (world.snapshot(), Vec::new(), Vec::new());
/// write_delta(&base, &later, &mut delta);
/// assert!(delta.len() < later.len() / 10, "one of the balls fell: {}", delta.len());
/// apply_delta(&base, &delta, &mut again)?;
/// assert!(again == later);
/// # Ok(())
/// # }
/// ```
pub fn write_delta(base: &[u8], snapshot: &[u8], delta: &mut Vec<u8>) {
    delta.clear();
    delta.extend_from_slice(&MAGIC);
    delta.extend_from_slice(&VERSION.to_le_bytes());
    for word in [checksum(base), snapshot.len() as u64, checksum(snapshot)] {
        delta.extend_from_slice(&word.to_le_bytes());
    }
    let blocks = Blocks::of(base);
    // Bytes not yet written begin at `new`; the last run ended at `place` in the base.
    let (mut new, mut place) = (0, 0);
    let mut at = 0;
    while at < snapshot.len() {
        let in_step = place + (at - new);
        let run = common(base.get(in_step..).unwrap_or_default(), &snapshot[at..]);
        let ends = at + run == snapshot.len();
        let (from, run) = if run >= 2 * BLOCK || (ends && run > 0) {
            (in_step, run)
        } else if let Some(from) = blocks.find(base, &snapshot[at..]) {
            // The run began before this block.
            let last = snapshot[new..at].iter().rev().zip(base[..from].iter().rev());
            let back = last.take_while(|(a, b)| a == b).count();
            at -= back;
            (from - back, back + common(&base[from..], &snapshot[at + back..]))
        } else if run >= MIN {
            (in_step, run)
        } else {
            at += 1;
            continue;
        };
        put(delta, &snapshot[new..at], (from, run), place + (at - new));
        (at, place) = (at + run, from + run);
        new = at;
    }
    if new < at {
        put(delta, &snapshot[new..], (0, 0), 0);
    }
}

/// Restores the snapshot from a delta and its base into `snapshot`, and replaces its content.
///
/// # Errors
/// Reason why the bytes are not a delta of this base; then `snapshot` is empty.
pub fn apply_delta(
    base: &[u8],
    mut delta: &[u8],
    snapshot: &mut Vec<u8>,
) -> Result<(), DeltaError> {
    snapshot.clear();
    if split(&mut delta) != Some(MAGIC) {
        return Err(DeltaError::NotADelta);
    }
    let found = u32::from_le_bytes(split(&mut delta).ok_or(DeltaError::Damaged)?);
    if found != VERSION {
        return Err(DeltaError::Version { found, read: VERSION });
    }
    let mut word = || split(&mut delta).map(u64::from_le_bytes).ok_or(DeltaError::Damaged);
    let (named, len, sum) = (word()?, word()?, word()?);
    let given = checksum(base);
    if named != given {
        return Err(DeltaError::WrongBase { named, given });
    }
    let made = join(base, delta, len, snapshot).filter(|()| checksum(snapshot) == sum);
    if made.is_none() {
        snapshot.clear();
    }
    made.ok_or(DeltaError::Damaged)
}

/// Joins all pieces; `None` if their total length is not `len` bytes.
fn join(base: &[u8], mut pieces: &[u8], len: u64, snapshot: &mut Vec<u8>) -> Option<()> {
    let len = usize::try_from(len).ok()?;
    let maximum = (base.len() + pieces.len()).saturating_mul(MAX);
    if len > maximum {
        return None;
    }
    snapshot.reserve(len);
    let mut place = 0_usize;
    while !pieces.is_empty() {
        let [new, run, jump] = [take(&mut pieces)?, take(&mut pieces)?, take(&mut pieces)?];
        let (bytes, rest) = pieces.split_at_checked(usize::try_from(new).ok()?)?;
        snapshot.extend_from_slice(bytes);
        pieces = rest;
        // Inverse of the folding in `put`: even is forward, odd is backward.
        let (by, back) = (usize::try_from(jump >> 1).ok()?, jump & 1 == 1);
        place = place.checked_add(bytes.len())?;
        place = if back { place.checked_sub(by)? } else { place.checked_add(by)? };
        let run = usize::try_from(run).ok()?;
        let end = place.checked_add(run)?;
        snapshot.extend_from_slice(base.get(place.min(base.len())..end.min(base.len()))?);
        if snapshot.len() > len || (run > 0 && end > base.len()) {
            return None;
        }
        place = end;
    }
    (snapshot.len() == len).then_some(())
}

/// Adds a piece: new bytes, and the run of the base that follows. `in_step`: position of the run if
/// those bytes had only changed in place.
fn put(delta: &mut Vec<u8>, new: &[u8], (from, run): (usize, usize), in_step: usize) {
    let jump = if run == 0 {
        0
    } else if from >= in_step {
        (from - in_step) << 1
    } else {
        ((in_step - from) << 1) | 1
    };
    for number in [new.len(), run, jump] {
        let mut left = number;
        while left >= 0x80 {
            delta.push(low_byte(left) | 0x80);
            left >>= 7;
        }
        delta.push(low_byte(left));
    }
    delta.extend_from_slice(new);
}

const fn low_byte(number: usize) -> u8 {
    #[expect(clippy::cast_possible_truncation, reason = "the low byte is what is wanted")]
    let byte = number as u8;
    byte
}

/// Reads a number, seven bits per byte, lowest first.
fn take(bytes: &mut &[u8]) -> Option<u64> {
    let mut number = 0;
    for shift in (0..63).step_by(7) {
        let [byte] = split(bytes)?;
        number |= u64::from(byte & 0x7f) << shift;
        if byte < 0x80 {
            return Some(number);
        }
    }
    None
}

/// Length of the common prefix.
fn common(a: &[u8], b: &[u8]) -> usize {
    let whole = a.as_chunks::<BLOCK>().0.iter().zip(b.as_chunks::<BLOCK>().0);
    let n = BLOCK * whole.take_while(|(a, b)| a == b).count();
    n + a[n..].iter().zip(&b[n..]).take_while(|(a, b)| a == b).count()
}

/// Positions of blocks of the base, by their hashes.
struct Blocks {
    /// Block index + 1; 0: none. Of several blocks with one hash, the first is stored.
    first: Vec<u32>,
}

impl Blocks {
    fn of(base: &[u8]) -> Self {
        let count = base.len() / BLOCK;
        let room = (2 * count).next_power_of_two();
        let mut first = vec![0; room];
        for number in 0..count {
            let Some(hash) = Self::hash(&base[number * BLOCK..]) else { continue };
            let place = &mut first[hash & (room - 1)];
            if let (0, Ok(number)) = (*place, u32::try_from(number + 1)) {
                *place = number;
            }
        }
        Self { first }
    }

    /// Hash of the first two blocks; `None` if all their bytes are equal, because runs of zeros
    /// occur everywhere.
    fn hash(bytes: &[u8]) -> Option<usize> {
        let (a, b) = bytes.first_chunk::<{ 2 * BLOCK }>()?.split_at(BLOCK);
        let [a, b] = [a, b].map(|half| half.iter().rev().fold(0, |h, x| (h << 8) | u64::from(*x)));
        if a == b {
            return None;
        }
        let mixed = (a ^ b.rotate_left(29)).wrapping_mul(0x9e37_79b9_7f4a_7c15);
        usize::try_from(mixed >> 33).ok()
    }

    /// Position in the base of the first two blocks of `bytes`.
    fn find(&self, base: &[u8], bytes: &[u8]) -> Option<usize> {
        let place = Self::hash(bytes)? & (self.first.len() - 1);
        let from = BLOCK * (self.first[place].checked_sub(1)? as usize);
        (common(base.get(from..from + 2 * BLOCK)?, bytes) == 2 * BLOCK).then_some(from)
    }
}

#[cfg(test)]
mod tests {
    use super::{DeltaError, apply_delta, write_delta};
    use crate::base::random::Random;

    fn delta(base: &[u8], snapshot: &[u8]) -> Vec<u8> {
        let (mut delta, mut again) = (vec![7; 9], vec![7; 9]);
        write_delta(base, snapshot, &mut delta);
        apply_delta(base, &delta, &mut again).unwrap();
        assert!(again == snapshot);
        delta
    }

    fn below(random: &mut Random, n: usize) -> usize {
        usize::try_from(random.next() % n.max(1) as u64).unwrap()
    }

    fn bytes(random: &mut Random, n: usize) -> Vec<u8> {
        (0..n).map(|_| random.next().to_le_bytes()[3]).collect()
    }

    #[test]
    fn a_delta_gives_back_any_bytes_and_is_small_where_they_are_alike() {
        let mut random = Random::new(3);
        let header = delta(&[], &[]).len();
        for case in 0..300 {
            let n = below(&mut random, 3000);
            let base = bytes(&mut random, n);
            assert!(delta(&base, &base).len() <= header + 5);
            // Changes: numbers changed in place, rows added, rows removed, a part moved.
            let (mut other, mut new) = (base.clone(), 0);
            for _ in 0..below(&mut random, 4) {
                let (at, n) = (below(&mut random, other.len()), below(&mut random, 40));
                let n = n.min(other.len() - at);
                match random.next() % 4 {
                    0 => {
                        let changed = bytes(&mut random, n);
                        other[at..at + n].copy_from_slice(&changed);
                        new += n;
                    }
                    1 => {
                        other.splice(at..at, bytes(&mut random, n));
                        new += n;
                    }
                    2 => drop(other.drain(at..at + n)),
                    _ => other.rotate_left(at),
                }
            }
            let delta = delta(&base, &other);
            // Each change costs its bytes and, at both ends, the rest of a block and the encoding
            // of runs.
            assert!(delta.len() <= header + new + 4 * 64, "{case}: {} of {new}", delta.len());
        }
        let (a, b) = (bytes(&mut random, 2000), bytes(&mut random, 900));
        assert!(delta(&a, &b).len() <= header + b.len() + 8);
        assert!(delta(&[], &a).len() <= header + a.len() + 8);
        assert!(delta(&[0; 5000], &[0; 3000]).len() <= header + 8);
        assert!(delta(&[0; 50], &[0; 3000]).len() < header + 3000);
    }

    #[test]
    fn what_is_no_delta_of_the_base_is_refused() {
        let mut random = Random::new(5);
        let base = bytes(&mut random, 600);
        let mut other = base.clone();
        other.splice(100..150, bytes(&mut random, 70));
        let whole = delta(&base, &other);
        let apply = |base: &[u8], delta: &[u8]| {
            let mut made = Vec::new();
            let result = apply_delta(base, delta, &mut made);
            assert!(result.is_ok() || made.is_empty());
            result.map(|()| made)
        };
        assert_eq!(apply(&base, b"").unwrap_err(), DeltaError::NotADelta);
        assert!(matches!(apply(&other, &whole), Err(DeltaError::WrongBase { .. })));
        let mut later = whole.clone();
        later[8] += 1;
        assert_eq!(apply(&base, &later).unwrap_err(), DeltaError::Version { found: 2, read: 1 });
        for end in 12..whole.len() {
            assert!(apply(&base, &whole[..end]).is_err(), "{end}");
        }
        for _ in 0..3000 {
            let mut damaged = whole.clone();
            for _ in 0..=below(&mut random, 3) {
                let at = 12 + below(&mut random, whole.len() - 12);
                damaged[at] = random.next().to_le_bytes()[3];
            }
            // Damage that gives the same result is harmless.
            assert!(apply(&base, &damaged).map_or(true, |made| made == other));
        }
    }
}
