//! Debug builds only: records which chunk of which phase took a row of a table, so that a second
//! chunk of that phase fails. Every test of a debug build thus checks for races, even with one
//! thread: successive chunks still have different numbers.
//!
//! A table of fixed size holds the claims, indexed by a hash of the row's address. A new claim
//! overwrites another row's claim in the same slot, so some races are missed. No race is reported
//! by mistake: address, phase and chunk are compared in full, and phase numbers do not recur.

#[cfg(debug_assertions)]
pub(crate) use self::{kept::claim, kept::is_in_chunk, kept::look, kept::phases, kept::within};

/// Runs the work of one chunk.
#[cfg(not(debug_assertions))]
#[inline(always)]
pub(crate) fn within<R>(_phase: u64, _chunk: usize, run: impl FnOnce() -> R) -> R {
    run()
}

/// Returns the first of `n` new phase numbers.
#[cfg(not(debug_assertions))]
#[inline(always)]
pub(crate) const fn phases(_n: usize) -> u64 {
    0
}

/// Returns whether this thread runs a chunk; true where nothing is checked.
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

    /// Number of claims in the table, a power of two: 256 KiB.
    const CLAIMS: usize = 1 << 14;
    /// Bits of the chunk number in a stamp; the phase number is above them. 2⁴⁰ phases are years
    /// of steps.
    const CHUNK: u32 = 24;
    /// Replaces a row's address while its claim is compared.
    const TAKEN: u64 = u64::MAX;

    struct Claim {
        row: AtomicU64,
        stamp: AtomicU64,
    }

    static TABLE: [Claim; CLAIMS] =
        [const { Claim { row: AtomicU64::new(0), stamp: AtomicU64::new(0) } }; CLAIMS];
    static PHASE: AtomicU64 = AtomicU64::new(1);

    thread_local! {
        /// Phase and chunk that this thread runs; 0 if it runs none.
        static NOW: Cell<u64> = const { Cell::new(0) };
    }

    /// Restores the previous stamp, even if a chunk panics.
    struct Before(u64);

    impl Drop for Before {
        fn drop(&mut self) {
            NOW.set(self.0);
        }
    }

    /// Runs the work of one chunk. A phase within a chunk belongs to the chunk and keeps its stamp.
    pub(crate) fn within<R>(phase: u64, chunk: usize, run: impl FnOnce() -> R) -> R {
        let _before = Before(NOW.get());
        if NOW.get() == 0 {
            NOW.set(phase << CHUNK | chunk as u64 & ((1 << CHUNK) - 1));
        }
        run()
    }

    /// Returns the first of `n` new phase numbers.
    pub(crate) fn phases(n: usize) -> u64 {
        PHASE.fetch_add(n as u64, Ordering::Relaxed)
    }

    /// Returns whether this thread runs a chunk.
    pub(crate) fn is_in_chunk() -> bool {
        NOW.get() != 0
    }

    fn place<T>(row: *const T) -> (u64, &'static Claim) {
        let row = row.addr() as u64;
        let hash = row.wrapping_mul(0x9e37_79b9_7f4a_7c15) >> (64 - CLAIMS.ilog2());
        (row, &TABLE[usize::try_from(hash).unwrap_or(0)])
    }

    /// Records that a chunk takes a row to write it. Work outside of chunks has no concurrency.
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

    /// Checks that no other chunk writes a row that this chunk reads.
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

    /// Returns whether a stamp is of another chunk of the same phase.
    fn other_chunk(stamp: u64, now: u64) -> bool {
        stamp != now && stamp >> CHUNK == now >> CHUNK
    }

    /// Compares a claim, and replaces it if `write`. If another thread compares it now, this
    /// returns early and may miss a race.
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

    use crate::base::threads::disjoint::{Apart, Rows};
    use crate::base::threads::jobs::{Jobs, for_each, for_ranges};
    use crate::base::threads::pieces::Pieces;
    use crate::base::threads::team::Team;

    fn lent<T>(items: &mut [T]) -> Rows<'_, T> {
        // SAFETY: only one thread uses the rows, and each reference ends at once.
        Rows::new(items, unsafe { Apart::promise() })
    }

    /// Returns the panic message of a phase of eight chunks that run one after the other.
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
            // The same rows in successive phases, by other chunks.
            for grain in [100, 70, 300] {
                for_ranges(&jobs, 9_000, grain, |range| {
                    for i in range {
                        *rows.row(i) += *rows.read(9_500);
                        *rows.row(i) += 1;
                        assert!(*rows.read(i) > 0);
                        // Zero-sized rows belong to no chunk. Memory that a chunk allocates is its
                        // own, whatever was at the address before.
                        *nothing.row(0) = ();
                        let mut own = vec![0_u64; 4];
                        *lent(&mut own).row(i % 4) = 1;
                    }
                });
            }
        }
        // Work outside of chunks is not compared either.
        rows.row(0);
        assert!(numbers[..9_000].iter().all(|n| *n == 6));
    }
}
