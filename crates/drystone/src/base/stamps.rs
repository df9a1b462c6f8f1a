//! In debug builds: which chunk of which phase took a row of a table, so that a second chunk of that phase fails. It makes every test
//! of a debug build look for races, by one thread too: chunks that run one after the other still have numbers of their own.
//!
//! Claims stand in a table of fixed size, found by the row's address; a claim there of another row is forgotten, so that some
//! races are missed, but none is made up: address, phase and chunk are compared whole, and numbers of phases do not come again.

#[cfg(debug_assertions)]
pub(crate) use self::kept::{claim, is_in_chunk, look, phases, within};

/// What is done by one chunk.
#[cfg(not(debug_assertions))]
#[inline(always)]
pub(crate) fn within<R>(_phase: u64, _chunk: usize, run: impl FnOnce() -> R) -> R {
    run()
}

/// Numbers for so many phases: the first.
#[cfg(not(debug_assertions))]
#[inline(always)]
pub(crate) const fn phases(_n: usize) -> u64 {
    0
}

/// Whether this thread runs a chunk. Never, where nothing is compared.
#[cfg(not(debug_assertions))]
#[inline(always)]
pub(crate) const fn is_in_chunk() -> bool {
    true
}

#[cfg(debug_assertions)]
mod kept {
    use core::any::type_name;
    use core::cell::Cell;
    use core::sync::atomic::{AtomicU64, Ordering};

    /// Claims that are remembered at a time, a power of two: 256 KiB.
    const CLAIMS: usize = 1 << 14;
    /// Bits of a chunk's number in a stamp; those above are the phase's. 2⁴⁰ phases are years of steps.
    const CHUNK: u32 = 24;
    /// Stands for a row's address while a claim is compared.
    const TAKEN: u64 = u64::MAX;

    struct Claim {
        row: AtomicU64,
        stamp: AtomicU64,
    }

    static TABLE: [Claim; CLAIMS] =
        [const { Claim { row: AtomicU64::new(0), stamp: AtomicU64::new(0) } }; CLAIMS];
    static PHASE: AtomicU64 = AtomicU64::new(1);

    thread_local! {
        /// Phase and chunk of what this thread does; 0 where it does no chunk.
        static NOW: Cell<u64> = const { Cell::new(0) };
    }

    /// Gives back what was there before, also where a chunk panics.
    struct Before(u64);

    impl Drop for Before {
        fn drop(&mut self) {
            NOW.set(self.0);
        }
    }

    /// What is done by one chunk. A phase within a chunk is the chunk's own: it keeps its stamp.
    pub(crate) fn within<R>(phase: u64, chunk: usize, run: impl FnOnce() -> R) -> R {
        let _before = Before(NOW.get());
        if NOW.get() == 0 {
            NOW.set(phase << CHUNK | chunk as u64 & ((1 << CHUNK) - 1));
        }
        run()
    }

    /// Numbers for so many phases: the first.
    pub(crate) fn phases(n: usize) -> u64 {
        PHASE.fetch_add(n as u64, Ordering::Relaxed)
    }

    /// Whether this thread runs a chunk.
    pub(crate) fn is_in_chunk() -> bool {
        NOW.get() != 0
    }

    fn place<T>(row: *const T) -> (u64, &'static Claim) {
        let row = row.addr() as u64;
        let hash = row.wrapping_mul(0x9e37_79b9_7f4a_7c15) >> (64 - CLAIMS.ilog2());
        (row, &TABLE[usize::try_from(hash).unwrap_or(0)])
    }

    /// A chunk takes a row to write it. What is done outside of chunks is alone.
    #[track_caller]
    pub(crate) fn claim<T>(row: *const T, number: usize) {
        let now = NOW.get();
        if now == 0 || size_of::<T>() == 0 {
            return;
        }
        let (row, claim) = place(row);
        let is_mine = claim.row.load(Ordering::Relaxed) == row;
        if is_mine && claim.stamp.load(Ordering::Relaxed) == now {
            return;
        }
        compare::<T>(claim, row, now, true, number);
    }

    /// A chunk reads a row, which no other writes.
    #[track_caller]
    pub(crate) fn look<T>(row: *const T, number: usize) {
        let now = NOW.get();
        if now == 0 || size_of::<T>() == 0 {
            return;
        }
        let (row, claim) = place(row);
        let suspect = claim.row.load(Ordering::Relaxed) == row
            && other_chunk(claim.stamp.load(Ordering::Relaxed), now);
        if suspect {
            compare::<T>(claim, row, now, false, number);
        }
    }

    /// Of the same phase.
    fn other_chunk(stamp: u64, now: u64) -> bool {
        stamp != now && stamp >> CHUNK == now >> CHUNK
    }

    /// Who finds the claim taken leaves: that race is missed.
    #[track_caller]
    fn compare<T>(claim: &Claim, row: u64, now: u64, write: bool, number: usize) {
        let there = claim.row.swap(TAKEN, Ordering::Acquire);
        if there == TAKEN {
            return;
        }
        let stamp = claim.stamp.load(Ordering::Relaxed);
        if write {
            claim.stamp.store(now, Ordering::Relaxed);
        }
        claim.row.store(if write { row } else { there }, Ordering::Release);
        assert!(
            there != row || !other_chunk(stamp, now),
            "row {number} of {} is {} by chunk {}, but chunk {} of the same phase has taken it",
            type_name::<T>(),
            if write { "taken" } else { "read" },
            now & ((1 << CHUNK) - 1),
            stamp & ((1 << CHUNK) - 1),
        );
    }
}

#[cfg(all(test, debug_assertions))]
mod tests {
    #![expect(unsafe_code, reason = "promises what is not so; chunks run one after the other here")]

    use std::panic::{AssertUnwindSafe, catch_unwind};

    use crate::base::disjoint::{Apart, Rows};
    use crate::base::jobs::{Jobs, for_each, for_ranges};
    use crate::base::pieces::Pieces;
    use crate::base::team::Team;

    fn lent<T>(items: &mut [T]) -> Rows<'_, T> {
        // SAFETY: by one thread, and each row is let go of at once.
        Rows::new(items, unsafe { Apart::promise() })
    }

    /// What a phase of eight chunks, one after the other, panics with.
    fn complaint(chunk: impl Fn(usize) + Sync) -> Option<String> {
        let run = || for_each(&Jobs::Inline, 8, |_, k| chunk(k));
        catch_unwind(AssertUnwindSafe(run)).err().and_then(|text| text.downcast_ref().cloned())
    }

    #[test]
    fn the_second_chunk_that_takes_a_row_fails() {
        let mut numbers = [0_u32; 64];
        let rows = lent(&mut numbers);
        let said = complaint(|k| *rows.row(k / 2) += 1).unwrap();
        assert!(said.contains("row 0 of u32 is taken by chunk 1, but chunk 0 of"), "{said}");
        let said = complaint(|k| rows.slice(7 * k..7 * k + 8).fill(1)).unwrap();
        assert!(said.contains("row 7 of u32 is taken by chunk 1, but chunk 0 of"), "{said}");
        let said = complaint(|k| *rows.row(k) = *rows.read(k ^ 1)).unwrap();
        assert!(said.contains("row 0 of u32 is read by chunk 1, but chunk 0 of"), "{said}");
        let mut table = Pieces::<u64>::default();
        (0..8).for_each(|_| table.push_default());
        // SAFETY: as above.
        let rows = table.lend(unsafe { Apart::promise() });
        let said = complaint(|k| *rows.row(k % 7) += 1).unwrap();
        assert!(said.contains("row 0 of u64 is taken by chunk 7, but chunk 0 of"), "{said}");
    }

    #[test]
    fn what_is_kept_apart_passes() {
        let mut numbers = vec![0_usize; 10_000];
        let nothing = &mut [(); 3];
        let (rows, nothing) = (lent(&mut numbers), lent(nothing));
        let team = Team::with_threads(3);
        for jobs in [Jobs::Inline, Jobs::Team(&team)] {
            // The same rows in one phase after the other, by other chunks.
            for grain in [100, 70, 300] {
                for_ranges(&jobs, 9_000, grain, |range| {
                    for i in range {
                        *rows.row(i) += *rows.read(9_500);
                        *rows.row(i) += 1;
                        assert!(*rows.read(i) > 0);
                        // What takes no memory is nobody's; what a chunk makes is its own, wherever it stood before.
                        *nothing.row(0) = ();
                        let mut own = vec![0_u64; 4];
                        *lent(&mut own).row(i % 4) = 1;
                    }
                });
            }
        }
        // Nor is what is done outside of chunks compared.
        rows.row(0);
        assert!(numbers[..9_000].iter().all(|n| *n == 6));
    }
}
