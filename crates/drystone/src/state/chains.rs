//! Chains: consecutive rods and threads, which are solved directly. Chains are searched again when
//! links or attachments are added or removed.
//!
//! Two rods or threads belong to one chain if exactly two meet at a particle that is not attached
//! to a body. In a cloth, chains follow the lines of the cloth.

use core::cmp::Reverse;
use core::ops::Range;

#[cfg(feature = "serde")]
use serde::{Deserialize, Serialize};

use super::particles::{LaneKind, Particles};
use crate::base::simd::wide::{LANES, Lanes};

/// Place of a chain's link in the blocks of links.
#[derive(Clone, Copy, Debug)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
pub(crate) struct Spot {
    pub(crate) color: u32,
    pub(crate) block: u32,
    pub(crate) lane: u8,
    /// True if the chain runs from the link's second particle to its first.
    pub(crate) turned: bool,
}

/// One particle of each of eight chains, and the links to their next particles.
#[derive(Clone, Debug)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
#[repr(C, align(64))]
pub(crate) struct ChainRow {
    /// Lines of the particles; 0 for an idle lane.
    pub(crate) solver_row: [u32; LANES],
    pub(crate) length: Lanes,
    /// 1 if the link can go slack.
    pub(crate) slack: Lanes,
    /// 1 if the link acts in this step.
    pub(crate) live: Lanes,
    /// Impulse of a substep along `n` on the next particle [N s]; negative: it pulls.
    pub(crate) impulse: Lanes,
    /// Sum of the impulses over substeps, beside a classic method.
    pub(crate) total: Lanes,
    /// Vector to the next particle at the step's start [m].
    pub(crate) gap: [Lanes; 3],
    /// Unit vector along which `impulse` was applied.
    pub(crate) n: [Lanes; 3],
    /// Working data of a pass: see the kernels.
    pub(crate) work: ChainWork,
}

/// Working data of a row in a pass.
#[derive(Clone, Debug)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
#[repr(C, align(32))]
pub(crate) struct ChainWork {
    /// Velocity [m/s], and 1/mass [1/kg].
    pub(crate) v: [Lanes; 3],
    pub(crate) w: Lanes,
    /// Current vector to the next particle [m].
    pub(crate) now: [Lanes; 3],
    /// Direction in which the pass pushes.
    pub(crate) along: [Lanes; 3],
    /// Impulse that rotates the link's impulse to the new direction, and the velocities after it.
    pub(crate) turn: [Lanes; 3],
    pub(crate) bend: [Lanes; 3],
    /// Velocity along the link to remove [m/s].
    pub(crate) error: Lanes,
    /// Diagonal of the system, and the off-diagonal entry toward the next link.
    pub(crate) k: Lanes,
    pub(crate) beside: Lanes,
    /// Intermediate values of the elimination.
    pub(crate) up: Lanes,
    pub(crate) change: Lanes,
    /// 1 if the link is solved, 0 if it is slack.
    pub(crate) active: Lanes,
}

const ZERO: Lanes = [0.0; LANES];
const ZERO3: [Lanes; 3] = [ZERO; 3];

impl Default for ChainRow {
    fn default() -> Self {
        let work = ChainWork {
            v: ZERO3,
            w: ZERO,
            now: ZERO3,
            along: ZERO3,
            turn: ZERO3,
            bend: ZERO3,
            error: ZERO,
            k: ZERO,
            beside: ZERO,
            up: ZERO,
            change: ZERO,
            active: ZERO,
        };
        Self {
            solver_row: [0; LANES],
            length: ZERO,
            slack: ZERO,
            live: ZERO,
            impulse: ZERO,
            total: ZERO,
            gap: ZERO3,
            n: [ZERO, [1.0; LANES], ZERO],
            work,
        }
    }
}

/// Up to eight chains side by side; a block of a chain attached to bodies has only one.
#[derive(Debug, Default)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
pub(crate) struct ChainBlock {
    /// Rows: one more than the number of links of the longest chain.
    pub(crate) rows: Vec<ChainRow>,
    /// Links of each row's lanes.
    pub(crate) spots: Vec<[Option<Spot>; LANES]>,
    /// Indices of the attachments of the first and the last particle, if they are attached to
    /// bodies.
    pub(crate) holds: [Option<u32>; 2],
}

impl Clone for ChainBlock {
    fn clone(&self) -> Self {
        let mut copy = Self::default();
        copy.clone_from(self);
        copy
    }

    /// Reuses the existing lists.
    fn clone_from(&mut self, from: &Self) {
        let Self { rows, spots, holds } = from;
        self.rows.clone_from(rows);
        self.spots.clone_from(spots);
        self.holds = *holds;
    }
}

/// All chains.
#[derive(Debug, Default)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
pub(crate) struct Chains {
    /// Chains without attachments, by color. No two chains of a color share a particle.
    pub(crate) colors: Vec<Vec<ChainBlock>>,
    /// Chains attached to bodies, one per block.
    pub(crate) held: Vec<ChainBlock>,
    #[cfg_attr(feature = "serde", serde(skip))]
    search: Search,
}

impl Clone for Chains {
    fn clone(&self) -> Self {
        let mut copy = Self::default();
        copy.clone_from(self);
        copy
    }

    /// Reuses the existing lists.
    fn clone_from(&mut self, from: &Self) {
        let Self { colors, held, search: _ } = from;
        self.colors.clone_from(colors);
        self.held.clone_from(held);
    }
}

/// Memory that is reused between searches. Threads tear within steps, and a warm step allocates
/// nothing.
#[derive(Clone, Debug, Default)]
struct Search {
    members: Vec<Member>,
    /// Number of members at each line; and line, thread and index of each member's ends.
    degree: Vec<u32>,
    ends: Vec<(u32, u32, u32)>,
    /// The steps of all runs in order: a member, and whether it is traversed from its second end.
    steps: Vec<(u32, bool)>,
    runs: Vec<Run>,
    /// Colors that are used at the line, one bit each.
    used: Vec<u64>,
    spare: Vec<ChainBlock>,
}

/// A chain during the search: a range of steps.
#[derive(Clone, Copy, Debug)]
struct Run {
    first: u32,
    end: u32,
    color: u32,
}

impl Run {
    const fn range(&self) -> Range<usize> {
        self.first as usize..self.end as usize
    }
}

impl Chains {
    /// All blocks.
    pub(crate) fn blocks_mut(&mut self) -> impl Iterator<Item = &mut ChainBlock> {
        self.colors.iter_mut().flatten().chain(&mut self.held)
    }
}

/// Maximum number of colors of chains. Chains without a color are solved link by link.
const COLORS: u32 = 64;

/// A rod or thread during the search.
#[derive(Clone, Copy, Debug)]
struct Member {
    thread: u32,
    ends: [u32; 2],
    spot: Spot,
    /// The next member beyond each end.
    next: [Option<u32>; 2],
    taken: bool,
}

/// Finds the chains of all particles.
pub(crate) fn find(particles: &mut Particles) {
    let mut chains = core::mem::take(&mut particles.chains);
    let Chains { colors, held, search } = &mut chains;
    // Blocks are taken from the end in their previous order, because a search finds mostly the same
    // chains as the last one.
    let idle = search.spare.len();
    search.spare.append(held);
    search.spare.extend(colors.iter_mut().flat_map(|color| color.drain(..)));
    search.spare[idle..].reverse();
    find_members(particles, &mut search.members);
    join(search, particles);
    find_runs(search);
    search.used.clear();
    search.used.resize(particles.states.len(), 0);
    let mut count = 0;
    for i in 0..search.runs.len() {
        let mut run = search.runs[i];
        if first_line(search, &run) == last_line(search, &run) {
            // A noose: its last link is solved by itself.
            run.end = run.end.saturating_sub(1).max(run.first);
        }
        if run.range().is_empty() {
            continue;
        }
        let holds = [first_line(search, &run), last_line(search, &run)];
        let holds = [hold_of(particles, holds[0]), hold_of(particles, holds[1])];
        if holds != [None, None] {
            let mut block = block_of(search, &[run]);
            block.holds = holds;
            held.push(block);
        } else if run.range().len() >= 2
            && let Some(color) = take_color(search, &run)
        {
            search.runs[count] = Run { color, ..run };
            count += 1;
        }
    }
    search.runs.truncate(count);
    // Chains of similar length are grouped by eight.
    search.runs.sort_unstable_by_key(|r| (r.color, Reverse(r.range().len()), r.first));
    let runs = core::mem::take(&mut search.runs);
    for runs in runs.chunk_by(|a, b| a.color == b.color) {
        let color = runs[0].color as usize;
        if colors.len() <= color {
            colors.resize_with(color + 1, Vec::new);
        }
        colors[color].extend(runs.chunks(LANES).map(|runs| block_of(search, runs)));
    }
    search.runs = runs;
    particles.chains = chains;
    mark(particles);
}

/// Takes a color that no chain uses at the run's lines.
fn take_color(search: &mut Search, run: &Run) -> Option<u32> {
    let Search { members, steps, used, .. } = search;
    let ends = || steps[run.range()].iter().flat_map(|(i, _)| members[*i as usize].ends);
    let taken = ends().fold(0, |bits, solver_row| bits | used[solver_row as usize]);
    let color = (!taken).trailing_zeros();
    if color >= COLORS {
        return None;
    }
    for solver_row in ends() {
        used[solver_row as usize] |= 1 << color;
    }
    Some(color)
}

/// Marks blocks that contain only links of chains; these need no sweep.
fn mark(particles: &mut Particles) {
    let Particles { chains, colors, .. } = particles;
    for block in colors.iter_mut().flat_map(|c| &mut c.blocks) {
        block.chained = [false; LANES];
    }
    for spot in chains.blocks_mut().flat_map(|b| &b.spots).flatten().flatten() {
        let block = &mut colors[spot.color as usize].blocks[spot.block as usize];
        block.chained[usize::from(spot.lane)] = true;
    }
}

fn hold_of(particles: &Particles, solver_row: u32) -> Option<u32> {
    particles.at(solver_row).attachment.checked_sub(1)
}

fn first_line(search: &Search, run: &Run) -> u32 {
    let first = search.steps[run.range()].first();
    first.map_or(0, |(i, turned)| search.members[*i as usize].ends[usize::from(*turned)])
}

fn last_line(search: &Search, run: &Run) -> u32 {
    let last = search.steps[run.range()].last();
    last.map_or(0, |(i, turned)| search.members[*i as usize].ends[usize::from(!*turned)])
}

/// Collects rods and threads in the order of their slots.
fn find_members(particles: &Particles, members: &mut Vec<Member>) {
    members.clear();
    for (_, link) in particles.links.iter() {
        let (block, lane) = particles.block_of(link);
        let ends = [block.row_a[lane], block.row_b[lane]];
        let acts = ends.iter().all(|solver_row| !particles.at(*solver_row).faulted);
        if acts && matches!(block.kinds[lane], LaneKind::Equal | LaneKind::AtMost) {
            members.push(Member {
                thread: link.thread,
                ends,
                spot: Spot { color: link.color, block: link.block, lane: link.lane, turned: false },
                next: [None; 2],
                taken: false,
            });
        }
    }
}

/// Links members that follow each other.
fn join(search: &mut Search, particles: &Particles) {
    let Search { members, degree, ends, .. } = search;
    degree.clear();
    degree.resize(particles.states.len(), 0);
    ends.clear();
    for (i, member) in (0_u32..).zip(members.iter()) {
        for solver_row in member.ends {
            degree[solver_row as usize] += 1;
            ends.push((solver_row, member.thread, i));
        }
    }
    ends.sort_unstable();
    for group in ends.chunk_by(|a, b| (a.0, a.1) == (b.0, b.1)) {
        let [(solver_row, thread, i), (_, _, k)] = *group else { continue };
        let alone = thread != 0 || degree[solver_row as usize] == 2;
        if !alone || particles.at(solver_row).attachment != 0 {
            continue;
        }
        for (me, other) in [(i, k), (k, i)] {
            let member = &mut members[me as usize];
            member.next[usize::from(member.ends[1] == solver_row)] = Some(other);
        }
    }
}

/// Walks along linked members. The last link of a ring is left out.
fn find_runs(search: &mut Search) {
    search.steps.clear();
    search.runs.clear();
    for rings in [false, true] {
        for start in 0..search.members.len() {
            let member = &search.members[start];
            let end = if member.next[0].is_none() {
                false
            } else if rings || member.next[1].is_none() {
                true
            } else {
                continue;
            };
            if !member.taken {
                walk(search, start, end && !rings, rings);
            }
        }
    }
}

fn walk(search: &mut Search, start: usize, turned: bool, ring: bool) {
    let Search { members, steps, runs, .. } = search;
    let first = number(steps.len());
    let (mut i, mut turned) = (start, turned);
    loop {
        members[i].taken = true;
        steps.push((number(i), turned));
        let (solver_row, next) = {
            let far = usize::from(!turned);
            (members[i].ends[far], members[i].next[far])
        };
        let Some(next) = next.map(|n| n as usize).filter(|n| !members[*n].taken) else { break };
        turned = members[next].ends[1] == solver_row;
        i = next;
    }
    runs.push(Run { first, end: number(steps.len()) - u32::from(ring), color: 0 });
}

fn number(n: usize) -> u32 {
    u32::try_from(n).expect("fewer than 2^32 links")
}

/// Builds a block of chains side by side.
fn block_of(search: &mut Search, runs: &[Run]) -> ChainBlock {
    let mut block = search.spare.pop().unwrap_or_default();
    let longest = runs.iter().map(|run| run.range().len()).max().unwrap_or(0);
    block.rows.clear();
    block.rows.resize(longest + 1, ChainRow::default());
    block.spots.clear();
    block.spots.resize(longest, [None; LANES]);
    block.holds = [None; 2];
    for (lane, run) in runs.iter().enumerate() {
        for (row, (i, turned)) in search.steps[run.range()].iter().enumerate() {
            let member = &search.members[*i as usize];
            block.rows[row].solver_row[lane] = member.ends[usize::from(*turned)];
            block.spots[row][lane] = Some(Spot { turned: *turned, ..member.spot });
        }
        block.rows[run.range().len()].solver_row[lane] = last_line(search, run);
    }
    block
}
