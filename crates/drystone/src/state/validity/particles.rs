//! Checks of particles: the rows and their lines, links in their lanes, chains of links.

use super::{Check, Invalid, Seen, all_finite, at_least_zero, holds, is_place};
use crate::base::limits;
use crate::base::simd::wide::LANES;
use crate::state::bodies::Bodies;
use crate::state::chains::ChainBlock;
use crate::state::def::particle_def::{MAX_RATE, check_length, check_mass};
use crate::state::particles::{CROWD, LaneKind, LinkColor, Particles};

/// Touches need no check, because they are only compared with new ones.
pub(crate) fn check_particles(particles: &Particles, bodies: &Bodies) -> Check {
    let Particles { rows, states, x, links, colors, attachments, .. } = particles;
    rows.check()?;
    links.check()?;
    let slots = rows.slot_count();
    let fits = states.len() == x.len() && states.len() == if slots == 0 { 0 } else { slots + 1 };
    holds(fits, "particles have not one solver_row each")?;
    let lives = |solver_row: u32| solver_row > 0 && rows.at(solver_row - 1).is_some();
    for (id, p) in rows.iter() {
        let solver_row = id.index() + 1;
        let (at, [.., radius]) = (particles.position(solver_row), x[solver_row as usize]);
        holds(is_place(at) && (1.0e-4..=1.0e3).contains(&radius), "a particle is nowhere")?;
        check_mass(p.mass).map_err(|_| "a particle has no mass that can be")?;
        p.material.validate().map_err(|_| "a material is out of range")?;
        let row = &states[solver_row as usize];
        holds(all_finite(row.v.iter().chain(&row.x)), "a particle moves by no number")?;
        let inverse = row.inverse_mass();
        holds(inverse.is_finite() && inverse >= 0.0, "a particle has no mass that can be")?;
        let is_valid = limits::DAMPING.admits(p.damping) && at_least_zero(&[p.still_time]);
        let is_valid = is_valid && limits::GRAVITY_SCALE.admits(p.gravity_scale);
        holds(is_valid, "a number of a particle is out of range")?;
        // Strands that will be searched again may refer to removed particles.
        let strand = particles.strands_changed || lives(p.strand) && p.strand <= solver_row;
        holds(strand, "a particle is of no strand")?;
        let held = p.attachment == 0
            || attachments
                .get(p.attachment as usize - 1)
                .is_some_and(|a| a.solver_row == solver_row);
        holds(held, "a particle is not held where it says")?;
    }
    for (number, a) in (1..).zip(attachments) {
        let own = lives(a.solver_row) && particles.at(a.solver_row).attachment == number;
        let body = bodies.rows.at(a.body).is_some() && is_place(a.anchor);
        holds(own && body && a.impulse.is_finite(), "an attachment is of nothing")?;
    }
    holds(colors.len() <= CROWD + 1, "links have too many colors")?;
    let mut ends = vec![0_u32; states.len()];
    let mut count = 0;
    for (number, color) in colors.iter().enumerate() {
        count += check_links(color, number, particles, &mut ends)?;
    }
    holds(count == links.len(), "a link is nowhere")?;
    let mut taken: Vec<Seen> =
        colors.iter().map(|c| Seen::none_of(c.blocks.len() * LANES)).collect();
    for (_, link) in links.iter() {
        let lane = link.block.checked_mul(8).and_then(|n| n.checked_add(u32::from(link.lane)));
        let color = taken.get_mut(link.color as usize).zip(lane.filter(|_| link.lane < 8));
        holds(color.is_some_and(|(seen, lane)| seen.is_new(lane)), "a link is nowhere")?;
        let (block, lane) = particles.block_of(link);
        holds(block.kinds[lane] != LaneKind::Idle, "a link is nowhere")?;
    }
    for (id, p) in rows.iter() {
        holds(ends[id.index() as usize + 1] == p.links, "a particle miscounts its links")?;
    }
    check_chains(particles, &taken)
}

fn is_rate(rate: &f32) -> bool {
    (0.0..=MAX_RATE).contains(rate)
}

/// Checks the links of a color. Returns their number.
fn check_links(
    color: &LinkColor,
    number: usize,
    particles: &Particles,
    ends: &mut [u32],
) -> Result<usize, Invalid> {
    let mut seen = Seen::none_of(particles.states.len());
    let mut count = 0;
    for block in &color.blocks {
        for lane in 0..LANES {
            let both = [block.row_a[lane], block.row_b[lane]];
            if block.kinds[lane] == LaneKind::Idle {
                holds(both == [0, 0], "a link that is none has ends")?;
                continue;
            }
            count += 1;
            let lives =
                |solver_row: u32| solver_row > 0 && particles.rows.at(solver_row - 1).is_some();
            holds(
                both.iter().all(|solver_row| lives(*solver_row)) && both[0] != both[1],
                "a link has no ends",
            )?;
            check_length(block.length[lane]).map_err(|_| "a link has no length that can be")?;
            let along = [0, 1, 2].map(|k| block.n[k][lane]);
            let kept = all_finite(along.iter().chain([&block.impulse[lane]]));
            holds(kept, "a link has an impulse that is no number")?;
            let spring = [block.stiffness[lane], block.damping[lane]];
            holds(spring.iter().all(is_rate), "a link is out of range")?;
            let [a, b] = both.map(|solver_row| particles.at(solver_row));
            let alike = a.frozen == b.frozen || a.faulted || b.faulted;
            holds(alike, "a link has one end at rest")?;
            for solver_row in both {
                ends[solver_row as usize] += 1;
                let alone = number == CROWD
                    || seen.is_new(solver_row)
                        && particles.at(solver_row).colors >> number & 1 == 1;
                holds(alone, "links of a color share a particle")?;
            }
        }
    }
    holds(color.is_valid(), "lanes of links are miscounted")?;
    Ok(count)
}

/// Checks the chains. Chains that will be searched again may refer to removed links, and are
/// dropped unchecked.
fn check_chains(particles: &Particles, taken: &[Seen]) -> Check {
    if particles.chains_changed {
        return Ok(());
    }
    let chains = &particles.chains;
    holds(chains.colors.len() <= CROWD + 1, "chains have too many colors")?;
    for color in chains.colors.iter().chain([&chains.held]) {
        let mut seen = Seen::none_of(particles.states.len());
        for block in color {
            let free = core::ptr::eq(color, &raw const chains.held);
            check_chain(block, particles, taken, (!free).then_some(&mut seen))?;
        }
    }
    Ok(())
}

fn check_chain(
    block: &ChainBlock,
    particles: &Particles,
    taken: &[Seen],
    mut seen: Option<&mut Seen>,
) -> Check {
    holds(block.rows.len() == block.spots.len() + 1, "a chain is cut")?;
    let holds_any = block.holds.iter().flatten();
    let held = holds_any.clone().all(|n| (*n as usize) < particles.attachments.len());
    holds(held, "a chain is held by nothing")?;
    for lane in 0..LANES {
        let mut last = 0;
        for (row, spots) in block.spots.iter().enumerate() {
            let (solver_row, next) =
                (block.rows[row].solver_row[lane], block.rows[row + 1].solver_row[lane]);
            let Some(spot) = spots[lane] else {
                holds(solver_row == last, "a chain has an end in its middle")?;
                last = 0;
                continue;
            };
            let Some(color) = taken.get(spot.color as usize) else {
                return Err("a chain is of no link");
            };
            let place = spot.block as usize * LANES + usize::from(spot.lane);
            let lives = usize::from(spot.lane) < LANES && color.0.get(place) == Some(&true);
            holds(lives, "a chain is of no link")?;
            let links = &particles.colors[spot.color as usize].blocks[spot.block as usize];
            let lane = usize::from(spot.lane);
            let (a, b) = (links.row_a[lane], links.row_b[lane]);
            let ends = if spot.turned { [b, a] } else { [a, b] };
            holds(
                ends == [solver_row, next] && links.chained[lane],
                "a chain is not of its links",
            )?;
            let alone = seen.as_mut().is_none_or(|seen| seen.is_new(solver_row));
            holds(alone, "chains of a color share a particle")?;
            last = next;
        }
        let end = block.rows[block.spots.len()].solver_row[lane];
        holds(end == last, "a chain has an end in its middle")?;
        let alone = last == 0 || seen.as_mut().is_none_or(|seen| seen.is_new(last));
        holds(alone, "chains of a color share a particle")?;
    }
    Ok(())
}
