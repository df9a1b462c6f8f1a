//! Journals: calls in order with their results, so that a run can be replayed and compared.

mod apply;
mod call;

#[cfg(feature = "serde")]
use serde::{Deserialize, Serialize};

pub use self::call::{Answer, AxisCall, BodyCall, Call, JointCall, ParticleCall, ShapeCall};
use super::snapshot::{SnapshotError, checksum, split};
use crate::base::id::BodyId;
use crate::state::def::DefError;
use crate::step::Stage;
use crate::world::StageHashes;
use crate::world::World;

/// Version of the layout; it increases whenever calls or snapshots change.
const VERSION: u32 = 2;

/// The initial state of a world and every later call with its result.
///
/// A bug report can be a journal. A replay gives the world in which the bug happened, and shows
/// whether another machine computes the same results. A server can send a journal to a client that
/// joins late. Every change of the world must go through [`Self::call`].
///
/// ```
/// # fn main() -> Result<(), Box<dyn std::error::Error>> {
/// use drystone::{BodyDef, ShapeDef, World};
/// use drystone::journal::{Call, Journal};
///
/// let mut world = World::default();
/// world.add_body(BodyDef::fixed().with_shape(ShapeDef::half_space([0.0, 1.0, 0.0], 0.0)))?;
/// let mut journal = Journal::begin(&world);
/// let ball = BodyDef::dynamic().with_position([0.0, 2.0, 0.0]).with_shape(ShapeDef::sphere(0.5));
/// journal.call(&mut world, Call::AddBody(Box::new(ball)))?;
/// for _ in 0..60 {
///     journal.call(&mut world, Call::Step(1.0 / 60.0))?;
/// }
///
/// let bytes = journal.to_bytes();
/// let mut again = World::default();
/// Journal::from_bytes(&bytes)?.replay(&mut again)?;
/// assert_eq!(again.state_hash(), world.state_hash());
/// # Ok(())
/// # }
/// ```
#[derive(Clone, Debug)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
pub struct Journal {
    start: Vec<u8>,
    entries: Vec<Entry>,
    /// Body hashes after the last call.
    known: BodyHashes,
}

/// A call and its result.
#[derive(Clone, Debug)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
struct Entry {
    call: Call,
    came: Came,
}

#[derive(Clone, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
enum Came {
    Refused,
    Answered(Answer),
    /// A step: hashes of the data that its stages left.
    Stepped {
        stages: StageHashes,
        /// Slots of the bodies whose hash changed in this step, with the new hashes.
        bodies: Vec<(u32, u32)>,
    },
}

/// A hash of each body by its slot; 0 for an empty slot.
#[derive(Clone, Debug, Default)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
struct BodyHashes(Vec<u32>);

impl BodyHashes {
    /// Updates the hashes. Returns the changed ones.
    fn look(&mut self, world: &World) -> Vec<(u32, u32)> {
        let rows = &world.tables.bodies.rows;
        let slots = u32::try_from(rows.slot_count().max(self.0.len())).unwrap_or(u32::MAX);
        let hash_of = |slot| {
            let body = rows.id_at(slot).and_then(|id| world.body(id));
            // Half of the bits suffice to detect a difference.
            #[expect(clippy::cast_possible_truncation, reason = "half of the bits")]
            body.map_or(0, |body| body.state_hash() as u32)
        };
        let changed = (0..slots).map(|slot| (slot, hash_of(slot)));
        let changed = changed.filter(|(slot, hash)| self.get(*slot) != *hash).collect::<Vec<_>>();
        self.follow(&changed);
        changed
    }

    fn get(&self, slot: u32) -> u32 {
        self.0.get(slot as usize).copied().unwrap_or(0)
    }

    /// Applies changed hashes. New slots follow the last one closely. A slot far beyond it, in a
    /// forged journal, is ignored.
    fn follow(&mut self, changed: &[(u32, u32)]) {
        for (slot, hash) in changed {
            let slot = *slot as usize;
            if slot >= self.0.len() && slot <= self.0.len() + changed.len() {
                self.0.resize(slot + 1, 0);
            }
            if let Some(place) = self.0.get_mut(slot) {
                *place = *hash;
            }
        }
    }

    /// The first slot with different hashes.
    fn difference(&self, other: &Self) -> Option<u32> {
        let slots = u32::try_from(self.0.len().max(other.0.len())).unwrap_or(u32::MAX);
        (0..slots).find(|slot| self.get(*slot) != other.get(*slot))
    }
}

/// The first difference between a replay and its journal.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct Difference {
    /// Index of the call, from 0.
    pub call: usize,
    /// [`World::step_count`] after it.
    pub step: u64,
    /// The first stage of the step whose own data differ: see [`World::stage_hashes`]. `None`: the
    /// call was not a step, and its answer differs.
    pub stage: Option<Stage>,
    /// The first body in slot order whose pose or velocity differs.
    pub body: Option<BodyId>,
}

impl core::fmt::Display for Difference {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        let Self { call, step, stage, body } = self;
        write!(f, "call {call}, at step {step}: ")?;
        match stage {
            Some(stage) => write!(f, "stage {} comes to something else", stage.name())?,
            None => write!(f, "it answers something else")?,
        }
        match body {
            Some(body) => write!(f, ", at the body in slot {}", body.index()),
            None => Ok(()),
        }
    }
}

/// Why a journal cannot be read or replayed.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum JournalError {
    /// The bytes are not a journal.
    NotAJournal,
    /// They are a journal of an unsupported version of the layout.
    Version {
        /// Version of the journal.
        found: u32,
        /// Supported version.
        read: u32,
    },
    /// They were truncated or changed after they were written.
    Damaged,
    /// The initial state is not a valid world.
    Start(SnapshotError),
    /// The replay gave a different result.
    Differs(Difference),
}

impl core::fmt::Display for JournalError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self {
            Self::NotAJournal => write!(f, "this is no journal of a world"),
            Self::Version { found, read } => {
                write!(f, "the journal must have version {read} (got {found})")
            }
            Self::Damaged => write!(f, "the journal was cut off or changed"),
            Self::Start(why) => write!(f, "the start of the journal: {why}"),
            Self::Differs(difference) => write!(f, "{difference}"),
        }
    }
}

impl core::error::Error for JournalError {}

impl Journal {
    /// The first bytes of the result of [`Self::to_bytes`], which identify the file format.
    pub const KIND: [u8; 8] = *b"drydiary";

    /// An empty journal that begins with the current state of the world.
    #[must_use]
    pub fn begin(world: &World) -> Self {
        let mut known = BodyHashes::default();
        known.look(world);
        Self { start: world.snapshot(), entries: Vec::new(), known }
    }

    /// Makes a call and records it with its result, even if it is refused.
    ///
    /// # Errors
    /// The errors of [`World::apply`].
    pub fn call(&mut self, world: &mut World, call: Call) -> Result<Answer, DefError> {
        let answer = world.apply(&call);
        let came = came(world, &call, answer.as_ref(), &mut self.known);
        self.entries.push(Entry { call, came });
        answer
    }

    /// The calls, in order.
    #[must_use]
    pub fn calls(&self) -> impl ExactSizeIterator<Item = &Call> {
        self.entries.iter().map(|entry| &entry.call)
    }

    /// The snapshot of the initial state.
    #[must_use]
    pub fn start(&self) -> &[u8] {
        &self.start
    }

    /// Restores the initial state in `world` and makes all calls again. The world keeps its
    /// executor and SIMD level.
    ///
    /// # Errors
    /// The initial state is not a valid world, or a result differs. The world stays in the state
    /// after the first difference.
    pub fn replay(&self, world: &mut World) -> Result<(), JournalError> {
        self.replay_some(world, self.entries.len())
    }

    /// Like [`Self::replay`] for the first `calls` calls, for example to inspect the world just
    /// before an event.
    ///
    /// # Errors
    /// The same errors as those of [`Self::replay`].
    pub fn replay_some(&self, world: &mut World, calls: usize) -> Result<(), JournalError> {
        world.restore_from(&self.start).map_err(JournalError::Start)?;
        let mut own = BodyHashes::default();
        own.look(world);
        let mut then = own.clone();
        for (number, entry) in self.entries.iter().enumerate().take(calls) {
            let answer = world.apply(&entry.call);
            let came = came(world, &entry.call, answer.as_ref(), &mut own);
            if let Came::Stepped { bodies, .. } = &entry.came {
                then.follow(bodies);
            }
            if came != entry.came {
                let slot = own.difference(&then);
                return Err(JournalError::Differs(Difference {
                    call: number,
                    step: world.step_count(),
                    stage: different_stage(&came, &entry.came),
                    body: slot.and_then(|slot| world.tables.bodies.rows.id_at(slot)),
                }));
            }
        }
        Ok(())
    }

    /// The journal as bytes.
    #[must_use]
    pub fn to_bytes(&self) -> Vec<u8> {
        let body = postcard::to_stdvec(self).expect("calls are numbers and lists");
        let mut bytes = Vec::with_capacity(20 + body.len());
        bytes.extend_from_slice(&Self::KIND);
        bytes.extend_from_slice(&VERSION.to_le_bytes());
        bytes.extend_from_slice(&checksum(&body).to_le_bytes());
        bytes.extend_from_slice(&body);
        bytes
    }

    /// The journal of [`Self::to_bytes`]; the bytes need not be trusted. It can be continued in the
    /// world of a replay.
    ///
    /// # Errors
    /// Reason why the bytes are not a journal. A replay shows whether its calls are valid.
    pub fn from_bytes(mut bytes: &[u8]) -> Result<Self, JournalError> {
        if split(&mut bytes) != Some(Self::KIND) {
            return Err(JournalError::NotAJournal);
        }
        let found = u32::from_le_bytes(split(&mut bytes).ok_or(JournalError::Damaged)?);
        if found != VERSION {
            return Err(JournalError::Version { found, read: VERSION });
        }
        let sum = u64::from_le_bytes(split(&mut bytes).ok_or(JournalError::Damaged)?);
        if sum != checksum(bytes) {
            return Err(JournalError::Damaged);
        }
        match postcard::take_from_bytes(bytes) {
            Ok((journal, [])) => Ok(journal),
            _ => Err(JournalError::Damaged),
        }
    }
}

fn came(
    world: &World,
    call: &Call,
    answer: Result<&Answer, &DefError>,
    known: &mut BodyHashes,
) -> Came {
    match (call, answer) {
        (Call::Step(_), _) => {
            Came::Stepped { stages: world.stage_hashes(), bodies: known.look(world) }
        }
        (_, Ok(answer)) => Came::Answered(answer.clone()),
        (_, Err(_)) => Came::Refused,
    }
}

/// The first stage in which two steps differ.
fn different_stage(now: &Came, then: &Came) -> Option<Stage> {
    let (Came::Stepped { stages: now, bodies }, Came::Stepped { stages: then, bodies: others }) =
        (now, then)
    else {
        return None;
    };
    match now.first_difference(then) {
        // The body hashes cover velocities too.
        None if bodies != others => Some(Stage::Finalize),
        first => first,
    }
}

#[cfg(test)]
mod tests {
    use super::{Answer, Came, Journal, JournalError};
    use crate::base::random::Random;
    use crate::world::saving::snapshot::checksum;
    use crate::{BodyDef, ShapeDef, Stage, World, vec3};
    use crate::{journal::BodyCall, journal::Call, journal::JournalError as Error};

    const DT: f32 = 1.0 / 60.0;

    /// Two boxes fall and are pushed. A third one is added after the third step.
    fn journal() -> (Journal, World) {
        let mut world = World::default();
        let ground = ShapeDef::half_space([0.0, 1.0, 0.0], 0.0);
        world.add_body(BodyDef::fixed().with_shape(ground)).unwrap();
        let mut journal = Journal::begin(&world);
        let cube = |x: f32| {
            let at = BodyDef::dynamic().with_position([x, 0.6, 0.0]);
            Call::AddBody(Box::new(at.with_shape(ShapeDef::box_half([0.5; 3]))))
        };
        let Ok(Answer::Body(first)) = journal.call(&mut world, cube(0.0)) else { panic!() };
        for step in 0..20 {
            if step == 3 {
                journal.call(&mut world, cube(3.0)).unwrap();
                let push = BodyCall::ApplyImpulse(vec3(100.0, 0.0, 0.0));
                journal.call(&mut world, Call::Body(first, push)).unwrap();
            }
            journal.call(&mut world, Call::Step(DT)).unwrap();
        }
        journal.call(&mut world, Call::SetGravity(vec3(f32::NAN, 0.0, 0.0))).unwrap_err();
        (journal, world)
    }

    fn replay(journal: &Journal) -> Result<u64, JournalError> {
        let mut world = World::default();
        journal.replay(&mut world).map(|()| world.state_hash())
    }

    #[test]
    fn a_journal_comes_to_the_same_and_can_be_stopped_on_the_way() {
        let (journal, world) = journal();
        assert_eq!(replay(&journal), Ok(world.state_hash()));
        let read = Journal::from_bytes(&journal.to_bytes()).unwrap();
        assert_eq!(replay(&read), Ok(world.state_hash()));
        // The journal can be continued.
        let (mut longer, mut on) = (read.clone(), World::default());
        longer.replay(&mut on).unwrap();
        for _ in 0..10 {
            longer.call(&mut on, Call::Step(DT)).unwrap();
        }
        assert_eq!(replay(&longer), Ok(on.state_hash()));
        let mut some = World::default();
        read.replay_some(&mut some, 4).unwrap();
        assert_eq!((some.step_count(), some.counts().dynamic), (3, 1));
        assert_eq!(read.calls().len(), 24);
    }

    #[test]
    fn the_first_difference_is_named_by_call_step_stage_and_body() {
        let (journal, _) = journal();
        let differs = |journal: &Journal| match replay(journal) {
            Err(Error::Differs(d)) => (d.call, d.step, d.stage, d.body.map(|b| b.index())),
            other => panic!("{other:?}"),
        };
        // With a slightly smaller push, the box in slot 1 moves differently in that step because of
        // the solver's friction.
        let mut pushed = journal.clone();
        let Call::Body(_, push) = &mut pushed.entries[5].call else { panic!() };
        *push = BodyCall::ApplyImpulse(vec3(99.0, 0.0, 0.0));
        let (call, step, stage, body) = differs(&pushed);
        assert_eq!((call, step, body), (6, 4, Some(1)));
        assert!(matches!(stage, Some(Stage::Narrowphase | Stage::Solver | Stage::Finalize)));
        // The added box gets another position.
        let mut moved = journal.clone();
        let Call::AddBody(def) = &mut moved.entries[4].call else { panic!() };
        def.position.x = 4.0;
        assert_eq!(differs(&moved), (6, 4, Some(Stage::Finalize), Some(2)));
        // The box is not added. The answer of the call differs before any step does.
        let mut gone = journal.clone();
        gone.entries[4].call = Call::WakeAll;
        let (call, step, stage, _) = differs(&gone);
        assert_eq!((call, step, stage), (4, 3, None));
        // A recorded hash is wrong.
        let mut hashed = journal;
        let Came::Stepped { stages, .. } = &mut hashed.entries[9].came else { panic!() };
        stages.change(Stage::Report);
        assert_eq!(differs(&hashed), (9, 7, Some(Stage::Report), None));
    }

    /// The checksum is correct, as in a forged file.
    #[test]
    fn damaged_journals_are_refused_or_run() {
        let bytes = journal().0.to_bytes();
        assert_eq!(Journal::from_bytes(b"").unwrap_err(), Error::NotAJournal);
        for end in [8, 11, 19, 20, bytes.len() - 1] {
            assert_eq!(Journal::from_bytes(&bytes[..end]).unwrap_err(), Error::Damaged, "{end}");
        }
        let mut later = bytes.clone();
        later[8] += 1;
        assert!(matches!(Journal::from_bytes(&later), Err(Error::Version { found: 3, read: 2 })));
        let start = journal().0.start.len();
        let mut random = Random::new(11);
        let mut below = |n: usize| usize::try_from(random.next() % n as u64).unwrap();
        let mut read = 0;
        for case in 0..600 {
            let mut body = bytes[20..].to_vec();
            for _ in 0..=below(3) {
                // The start is a snapshot with its own valid checksum.
                let at = start + below(body.len() - start);
                match below(4) {
                    0 => body[at] ^= 1 << below(8),
                    1 => body[at] = [0, 1, 0x7f, 0x80, 0xff][below(5)],
                    2 => drop(body.remove(at)),
                    _ => body.truncate(at),
                }
            }
            let mut damaged = bytes[..12].to_vec();
            damaged.extend(checksum(&body).to_le_bytes());
            damaged.extend(body);
            let run =
                std::panic::catch_unwind(|| Journal::from_bytes(&damaged).map(|j| replay(&j)));
            read += usize::from(run.unwrap_or_else(|_| panic!("case {case}")).is_ok());
        }
        assert!(read > 60, "hardly any is looked at: {read}");
    }
}
