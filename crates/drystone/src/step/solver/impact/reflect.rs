//! Stops hits that bodies link together, and reflects them. See [`super::impact`].

use fearless_simd::Simd;

use super::candidate::{Candidate, Hit, Source};
use super::response::{Reaction, Response};
use crate::base::threads::disjoint::{ReadRows, Rows};

/// Maximum sweeps over the points of one round. One point needs one sweep; the error of two balls
/// side by side falls by a factor of 16 in each.
const SWEEPS: u32 = 24;

/// A round has converged when no impulse changes a speed by more than this part of the maximum one.
/// The remaining errors of speed and energy are of that order.
const PRECISION: f32 = 1.0e-5;

/// Hits that bodies link.
pub(crate) struct Part<'a, S: Simd> {
    pub(crate) simd: S,
    pub(crate) source: &'a Source<'a>,
    pub(crate) candidates: &'a ReadRows<'a, Candidate>,
    pub(crate) responses: &'a Rows<'a, Response>,
    pub(crate) hits: &'a mut [Hit],
}

impl<S: Simd> Part<'_, S> {
    /// Calls `f` with each response and its hits; returns the sum of the results. If all hits are
    /// of one contact, the reaction is kept until the end of the round.
    #[inline(always)]
    fn each<const ALONE: bool>(
        &mut self,
        kept: &mut Reaction<S>,
        mut f: impl FnMut(&mut Response, &mut Reaction<S>, &mut [Hit]) -> f32,
    ) -> f32 {
        if ALONE {
            let response = self.responses.row(self.hits[0].response as usize);
            return f(response, kept, self.hits);
        }
        let mut sum = 0.0;
        for hits in self.hits.chunk_by_mut(|one, next| one.candidate == next.candidate) {
            let response = self.responses.row(hits[0].response as usize);
            let mut reaction = response.reaction(self.simd, self.source);
            sum += f(response, &mut reaction, hits);
            response.deliver(self.simd, &reaction, self.source);
        }
        sum
    }

    /// Stops all hits together, with friction. Then applies their impulses once more, times their
    /// gains, but with no more energy than the stop removed [Poisson's hypothesis], and friction
    /// again.
    #[inline(always)]
    pub(crate) fn reflect<const ALONE: bool>(mut self, pass: u16) {
        let simd = self.simd;
        let (mut fastest, mut driven) = (0.0_f32, false);
        for hit in self.hits.iter() {
            let response = self.responses.row(hit.response as usize);
            if hit.fresh {
                *response = Response::new(self.candidates.read(hit.candidate as usize));
            }
            response.couple(simd, self.source, pass);
            fastest = fastest.max(-hit.speed);
            driven |= response.driven;
        }
        let first = self.hits[0].response as usize;
        let mut kept = if ALONE {
            self.responses.read(first).reaction(simd, self.source)
        } else {
            Reaction::none(simd)
        };
        let mut work = 0.0;
        for _ in 0..SWEEPS {
            let mut change = 0.0_f32;
            work += self.each::<ALONE>(&mut kept, |response, reaction, hits| {
                let mut work = 0.0;
                for hit in hits {
                    let j = usize::from(hit.point);
                    let mass = response.mass[j];
                    let new = (hit.impulse - mass * (reaction.speeds()[j] + hit.keeps)).max(0.0);
                    let d = new - hit.impulse;
                    hit.impulse = new;
                    work += response.push(simd, reaction, j, d);
                    change = change.max(d.abs() / mass);
                }
                work + response.rub(simd, reaction)
            });
            if change <= PRECISION * fastest {
                break;
            }
        }
        let rate = self.each::<ALONE>(&mut kept, |_, reaction, hits| {
            let mut rate = 0.0;
            for hit in hits {
                rate += hit.e * hit.impulse * reaction.speeds()[usize::from(hit.point)];
            }
            rate
        });
        let returned = self.each::<ALONE>(&mut kept, |response, reaction, hits| {
            let mut returned = 0.0;
            for hit in hits {
                let d = hit.e * hit.impulse;
                returned += response.push(simd, reaction, usize::from(hit.point), d);
            }
            returned
        });
        // Where friction and normal impulses interact, the full impulse can add energy (Kane). The
        // work of kinematic bodies is not limited.
        let mut part = 1.0;
        let square = returned - rate;
        if !driven && work + returned > -PRECISION * work && square > 0.0 {
            let root = (rate * rate - 4.0 * square * work).max(0.0).sqrt();
            part = ((root - rate) / (2.0 * square)).clamp(0.0, 1.0);
        }
        self.each::<ALONE>(&mut kept, |response, reaction, hits| {
            for hit in hits {
                let d = hit.impulse * (hit.gain * part - hit.e);
                response.push(simd, reaction, usize::from(hit.point), d);
            }
            response.rub(simd, reaction)
        });
        if ALONE {
            self.responses.row(first).deliver(simd, &kept, self.source);
        }
    }
}
