//! Chains: rods and threads in a row, which are solved at once. Found anew when links or attachments come or go.
//!
//! Where exactly two rods or threads meet at a particle that no body holds, they are of one chain; in a
//! cloth, those of one line of it.

use super::particles::{LaneKind, Particles};
use crate::base::wide::{LANES, Lanes};

/// Where a link of a chain stands among the blocks of links.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Spot {
    pub(crate) color: u32,
    pub(crate) block: u32,
    pub(crate) lane: u8,
    /// The chain runs from its second particle to its first.
    pub(crate) turned: bool,
}

/// One particle of each of eight chains, and the links to their next ones.
#[derive(Clone, Debug)]
#[repr(C, align(64))]
pub(crate) struct ChainRow {
    /// Lines of the particles; 0 for an idle lane.
    pub(crate) line: [u32; LANES],
    pub(crate) length: Lanes,
    /// 1 where the link can go slack.
    pub(crate) slack: Lanes,
    /// 1 where the link acts in this step.
    pub(crate) live: Lanes,
    /// Impulse of a substep along `n` on the next particle [N s]; below 0: it pulls.
    pub(crate) impulse: Lanes,
    /// Its sum over substeps, beside a classic method.
    pub(crate) total: Lanes,
    /// To the next particle at the step's start [m].
    pub(crate) gap: [Lanes; 3],
    /// Unit, along which `impulse` was applied.
    pub(crate) n: [Lanes; 3],
    /// What a pass works with: see the kernels.
    pub(crate) work: ChainWork,
}

/// Of a row, in a pass.
#[derive(Clone, Debug)]
#[repr(C, align(32))]
pub(crate) struct ChainWork {
    /// Velocity [m/s], and 1/mass [1/kg].
    pub(crate) v: [Lanes; 3],
    pub(crate) w: Lanes,
    /// To the next particle, now [m].
    pub(crate) now: [Lanes; 3],
    /// Direction in which the pass pushes.
    pub(crate) along: [Lanes; 3],
    /// Impulse that turns the one of the link; and what the velocities become by it.
    pub(crate) turn: [Lanes; 3],
    pub(crate) bend: [Lanes; 3],
    /// Velocity along the link that is to go [m/s].
    pub(crate) error: Lanes,
    /// Diagonal of the system, and what is beside it toward the next link.
    pub(crate) k: Lanes,
    pub(crate) beside: Lanes,
    /// Of the elimination.
    pub(crate) up: Lanes,
    pub(crate) change: Lanes,
    /// 1 where the link is solved, 0 where it is slack.
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
            line: [0; LANES],
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

/// Up to eight chains side by side; of those that bodies hold, one.
#[derive(Clone, Debug, Default)]
pub(crate) struct ChainBlock {
    /// A row more than the longest has links.
    pub(crate) rows: Vec<ChainRow>,
    /// Of each row the links of its lanes.
    pub(crate) spots: Vec<[Option<Spot>; LANES]>,
    /// Numbers of the attachments of the first and the last particle, if bodies hold them.
    pub(crate) holds: [Option<u32>; 2],
}

/// All chains.
#[derive(Clone, Debug, Default)]
pub(crate) struct Chains {
    /// Those that no body holds, by color: of one color no two share a particle.
    pub(crate) colors: Vec<Vec<ChainBlock>>,
    /// Those that bodies hold, each alone.
    pub(crate) held: Vec<ChainBlock>,
}

impl Chains {
    /// All blocks.
    pub(crate) fn blocks_mut(&mut self) -> impl Iterator<Item = &mut ChainBlock> {
        self.colors.iter_mut().flatten().chain(&mut self.held)
    }
}

/// Most colors of chains; what finds none is solved link by link.
const COLORS: usize = 64;

/// A rod or thread while chains are found.
#[derive(Clone, Copy)]
struct Member {
    thread: u32,
    ends: [u32; 2],
    spot: Spot,
    /// The next member beyond each end.
    next: [Option<u32>; 2],
    taken: bool,
}

/// A chain: members, each with whether it is run through from its second end.
type Run = Vec<(u32, bool)>;

/// Finds the chains of all particles.
pub(crate) fn find(particles: &mut Particles) {
    let mut members = members(particles);
    join(&mut members, particles);
    let runs = runs(&mut members);
    let mut chains = Chains::default();
    let mut sorted: Vec<Vec<Run>> = Vec::new();
    // Colors that have a chain at the particle, a bit each.
    let mut used = vec![0_u64; particles.lines.len()];
    for mut run in runs {
        if first_line(&members, &run) == last_line(&members, &run) {
            // A noose: its last link is solved by itself.
            run.pop();
        }
        let ends = [first_line(&members, &run), last_line(&members, &run)];
        let holds = [hold_of(particles, ends[0]), hold_of(particles, ends[1])];
        if holds != [None, None] {
            let mut block = block_of(&members, &[run]);
            block.holds = holds;
            chains.held.push(block);
            continue;
        }
        if run.len() < 2 {
            continue;
        }
        let taken = run.iter().fold(0, |bits, (i, _)| {
            let [a, b] = members[*i as usize].ends;
            bits | used[a as usize] | used[b as usize]
        });
        let color = (!taken).trailing_zeros() as usize;
        if color >= COLORS {
            continue;
        }
        for (i, _) in &run {
            for line in members[*i as usize].ends {
                used[line as usize] |= 1 << color;
            }
        }
        if sorted.len() <= color {
            sorted.resize_with(color + 1, Vec::new);
        }
        sorted[color].push(run);
    }
    for mut color in sorted {
        // Eight of about one length; the sort is stable.
        color.sort_by_key(|run| core::cmp::Reverse(run.len()));
        chains.colors.push(color.chunks(LANES).map(|runs| block_of(&members, runs)).collect());
    }
    particles.chains = chains;
    mark(particles);
}

/// Blocks of links that have nothing but links of chains need no sweep of their own.
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

fn hold_of(particles: &Particles, line: u32) -> Option<u32> {
    particles.at(line).attachment.checked_sub(1)
}

fn first_line(members: &[Member], run: &[(u32, bool)]) -> u32 {
    run.first().map_or(0, |(i, turned)| members[*i as usize].ends[usize::from(*turned)])
}

fn last_line(members: &[Member], run: &[(u32, bool)]) -> u32 {
    run.last().map_or(0, |(i, turned)| members[*i as usize].ends[usize::from(!*turned)])
}

/// Rods and threads, in the order of their slots.
fn members(particles: &Particles) -> Vec<Member> {
    let mut members = Vec::new();
    for (_, link) in particles.links.iter() {
        let (block, lane) = particles.block_of(link);
        if matches!(block.kinds[lane], LaneKind::Equal | LaneKind::AtMost) {
            members.push(Member {
                thread: link.thread,
                ends: [block.row_a[lane], block.row_b[lane]],
                spot: Spot { color: link.color, block: link.block, lane: link.lane, turned: false },
                next: [None; 2],
                taken: false,
            });
        }
    }
    members
}

/// Finds which members follow each other.
fn join(members: &mut [Member], particles: &Particles) {
    let mut degree = vec![0_u32; particles.lines.len()];
    let mut at: Vec<(u32, u32, u32)> = Vec::with_capacity(2 * members.len());
    for (i, member) in (0_u32..).zip(members.iter()) {
        for line in member.ends {
            degree[line as usize] += 1;
            at.push((line, member.thread, i));
        }
    }
    at.sort_unstable();
    for group in at.chunk_by(|a, b| (a.0, a.1) == (b.0, b.1)) {
        let [(line, thread, i), (_, _, k)] = *group else { continue };
        let alone = thread != 0 || degree[line as usize] == 2;
        if !alone || particles.at(line).attachment != 0 {
            continue;
        }
        for (me, other) in [(i, k), (k, i)] {
            let member = &mut members[me as usize];
            member.next[usize::from(member.ends[1] == line)] = Some(other);
        }
    }
}

/// Walks along what was joined. Of a ring the last link stays out.
fn runs(members: &mut [Member]) -> Vec<Run> {
    let mut runs = Vec::new();
    for rings in [false, true] {
        for start in 0..members.len() {
            let member = &members[start];
            let end = if member.next[0].is_none() {
                false
            } else if rings || member.next[1].is_none() {
                true
            } else {
                continue;
            };
            if !member.taken {
                runs.push(walk(members, start, end && !rings, rings));
            }
        }
    }
    runs
}

fn walk(members: &mut [Member], start: usize, turned: bool, ring: bool) -> Run {
    let mut run = Run::new();
    let (mut i, mut turned) = (start, turned);
    loop {
        members[i].taken = true;
        run.push((u32::try_from(i).expect("fewer than 2^32 links"), turned));
        let (line, next) = {
            let far = usize::from(!turned);
            (members[i].ends[far], members[i].next[far])
        };
        let Some(next) = next.map(|n| n as usize).filter(|n| !members[*n].taken) else { break };
        turned = members[next].ends[1] == line;
        i = next;
    }
    if ring {
        run.pop();
    }
    run
}

/// Chains side by side.
fn block_of(members: &[Member], runs: &[Run]) -> ChainBlock {
    let longest = runs.iter().map(Vec::len).max().unwrap_or(0);
    let mut block = ChainBlock {
        rows: vec![ChainRow::default(); longest + 1],
        spots: vec![[None; LANES]; longest],
        holds: [None; 2],
    };
    for (lane, run) in runs.iter().enumerate() {
        for (row, (i, turned)) in run.iter().enumerate() {
            let member = &members[*i as usize];
            block.rows[row].line[lane] = member.ends[usize::from(*turned)];
            block.spots[row][lane] = Some(Spot { turned: *turned, ..member.spot });
        }
        block.rows[run.len()].line[lane] = last_line(members, run);
    }
    block
}
