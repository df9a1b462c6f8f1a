//! A symmetric positive definite matrix over bodies, with six rows for each. A row is stored from
//! its first nonzero entry to the diagonal; Cholesky factors fill no more than that.

use crate::base::double::lesser;

/// Rows of a body.
pub(crate) const SIX_DOF: usize = 6;

/// Maximum multiplications of a factorization: a fifth of a second.
const MAX_WORK: f64 = 2.0e8;

/// The matrix and its memory.
#[derive(Clone, Debug, Default)]
pub(crate) struct Skyline {
    /// Position of each body in the order of rows.
    place: Vec<u32>,
    /// First column of each row, and its index in `values`.
    first: Vec<usize>,
    start: Vec<usize>,
    values: Vec<f64>,
    edges: Vec<(u32, u32)>,
    /// First edge of each body, and the state of the search.
    from: Vec<usize>,
    queue: Vec<u32>,
    seen: Vec<bool>,
    by_degree: Vec<u32>,
    /// Multiplications of a factorization.
    work: f64,
}

impl Skyline {
    /// Builds the profile from the couplings between `n` bodies. False if factorizing would be too
    /// expensive.
    pub(crate) fn shape(&mut self, n: usize, couplings: impl Iterator<Item = (u32, u32)>) -> bool {
        self.edges.clear();
        for (a, b) in couplings {
            self.edges.push((a, b));
            self.edges.push((b, a));
        }
        self.edges.sort_unstable();
        self.edges.dedup();
        self.from.clear();
        self.from.resize(n + 1, 0);
        for (a, _) in &self.edges {
            self.from[*a as usize + 1] += 1;
        }
        for i in 0..n {
            self.from[i + 1] += self.from[i];
        }
        self.order_bodies(n);
        self.first.clear();
        self.start.clear();
        let (mut size, mut work) = (0, 0.0);
        for i in 0..n {
            let body = self.queue[i] as usize;
            let lowest = self.edges[self.from[body]..self.from[body + 1]]
                .iter()
                .map(|(_, other)| self.place[*other as usize] as usize)
                .fold(i, usize::min);
            for k in 0..SIX_DOF {
                let width = SIX_DOF * (i - lowest) + k + 1;
                self.first.push(SIX_DOF * lowest);
                self.start.push(size);
                size += width;
                #[expect(clippy::cast_precision_loss, reason = "far below 2^52")]
                let width = lesser(width as f64, 1.0e6);
                work += width * width;
            }
        }
        self.work = work;
        if work > MAX_WORK {
            return false;
        }
        self.values.resize(size, 0.0);
        true
    }

    /// Multiplications of a factorization.
    pub(crate) const fn work(&self) -> f64 {
        self.work
    }

    /// Orders bodies from the outside to the middle, so that neighbors are close to each other:
    /// reverse Cuthill-McKee order.
    fn order_bodies(&mut self, n: usize) {
        let Self { edges, from, queue, seen, by_degree, place, .. } = self;
        let degree = |b: u32| from[b as usize + 1] - from[b as usize];
        seen.clear();
        seen.resize(n, false);
        queue.clear();
        by_degree.clear();
        by_degree.extend(0..u32::try_from(n).expect("fewer than 2^32 bodies"));
        by_degree.sort_unstable_by_key(|b| (degree(*b), *b));
        for root in by_degree {
            if core::mem::replace(&mut seen[*root as usize], true) {
                continue;
            }
            let mut next = queue.len();
            queue.push(*root);
            while next < queue.len() {
                let body = queue[next] as usize;
                next += 1;
                let found = queue.len();
                for (_, other) in &edges[from[body]..from[body + 1]] {
                    if !core::mem::replace(&mut seen[*other as usize], true) {
                        queue.push(*other);
                    }
                }
                queue[found..].sort_unstable_by_key(|b| (degree(*b), *b));
            }
        }
        queue.reverse();
        place.clear();
        place.resize(n, 0);
        for (i, body) in (0_u32..).zip(&*queue) {
            place[*body as usize] = i;
        }
    }

    /// Sets it to the identity.
    pub(crate) fn reset(&mut self) {
        self.values.fill(0.0);
        for (row, start) in self.start.iter().enumerate() {
            self.values[start + row - self.first[row]] = 1.0;
        }
    }

    /// Adds `weight` times the outer product of a row that is `g` on these bodies; a body out of
    /// range is skipped.
    pub(crate) fn add(&mut self, weight: f64, bodies: [u32; 2], g: &[[f64; SIX_DOF]; 2]) {
        for (i, of) in bodies.iter().enumerate() {
            for (j, by) in bodies.iter().enumerate() {
                let (Some(of), Some(by)) =
                    (self.place.get(*of as usize), self.place.get(*by as usize))
                else {
                    continue;
                };
                if by > of {
                    continue;
                }
                for k in 0..SIX_DOF {
                    let row = SIX_DOF * *of as usize + k;
                    let at = self.start[row] + SIX_DOF * *by as usize - self.first[row];
                    let maximum = if by == of { k + 1 } else { SIX_DOF };
                    for (value, x) in self.values[at..at + maximum].iter_mut().zip(&g[j]) {
                        *value += weight * g[i][k] * x;
                    }
                }
            }
        }
    }

    /// Factorizes and solves: `x`, six numbers for each body, is the right side and becomes the
    /// solution. False if a pivot is not positive.
    pub(crate) fn solve(&mut self, x: &mut [[f64; SIX_DOF]], flat: &mut Vec<f64>) -> bool {
        let n = self.first.len();
        for i in 0..n {
            let (above, row) = self.values.split_at_mut(self.start[i]);
            let first = self.first[i];
            for j in first..i {
                let from = first.max(self.first[j]);
                let other = &above[self.start[j] + from - self.first[j]..];
                let (done, rest) = row.split_at_mut(j - first);
                let sum = dot(&done[from - first..], &other[..j - from]);
                rest[0] = (rest[0] - sum) / other[j - from];
            }
            let (done, rest) = row.split_at_mut(i - first);
            let pivot = rest[0] - dot(done, done);
            if !(pivot > 0.0 && pivot.is_finite()) {
                return false;
            }
            rest[0] = pivot.sqrt();
        }
        flat.clear();
        flat.extend(self.queue.iter().flat_map(|body| x[*body as usize]));
        for i in 0..n {
            let (row, first) = (&self.values[self.start[i]..], self.first[i]);
            let sum = dot(&row[..i - first], &flat[first..i]);
            flat[i] = (flat[i] - sum) / row[i - first];
        }
        for i in (0..n).rev() {
            let (row, first) = (&self.values[self.start[i]..], self.first[i]);
            flat[i] /= row[i - first];
            let value = flat[i];
            for (y, l) in flat[first..i].iter_mut().zip(row) {
                *y -= value * l;
            }
        }
        for (part, body) in flat.chunks_exact(SIX_DOF).zip(&self.queue) {
            x[*body as usize].copy_from_slice(part);
        }
        true
    }
}

/// Dot product in four partial sums, always in the same order.
fn dot(a: &[f64], b: &[f64]) -> f64 {
    let mut sums = [0.0; 4];
    let (heads_a, heads_b) = (a.chunks_exact(4), b.chunks_exact(4));
    let (tail_a, tail_b) = (heads_a.remainder(), heads_b.remainder());
    for (x, y) in heads_a.zip(heads_b) {
        for i in 0..4 {
            sums[i] += x[i] * y[i];
        }
    }
    for i in 0..tail_a.len().min(tail_b.len()) {
        sums[i] += tail_a[i] * tail_b[i];
    }
    (sums[0] + sums[1]) + (sums[2] + sums[3])
}

#[cfg(test)]
mod tests {
    use super::{SIX_DOF, Skyline};

    #[test]
    fn it_solves_what_a_full_matrix_would() {
        // A ring of five bodies, a sixth alone, and a row on one body only.
        let couplings = [(0, 3), (3, 1), (1, 4), (4, 2), (2, 0)];
        let mut matrix = Skyline::default();
        assert!(matrix.shape(6, couplings.iter().copied()));
        matrix.reset();
        let mut full = vec![[0.0; 36]; 36];
        for (i, row) in full.iter_mut().enumerate() {
            row[i] = 1.0;
        }
        let mut seed = 1_u32;
        let mut number = || {
            seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            f64::from(seed >> 8) / f64::from(1 << 24) - 0.5
        };
        let rows: Vec<(u32, u32)> = couplings.into_iter().chain([(5, u32::MAX), (0, 3)]).collect();
        for (a, b) in rows {
            let g = [[(); SIX_DOF]; 2].map(|side| side.map(|()| number()));
            matrix.add(30.0, [a, b], &g);
            let dense = |i: usize| {
                let (body, k) = (i / SIX_DOF, i % SIX_DOF);
                [a, b]
                    .iter()
                    .zip(&g)
                    .filter(|(x, _)| **x as usize == body)
                    .map(|(_, g)| g[k])
                    .sum::<f64>()
            };
            for (i, row) in full.iter_mut().enumerate() {
                for (j, value) in row.iter_mut().enumerate() {
                    *value += 30.0 * dense(i) * dense(j);
                }
            }
        }
        let right: Vec<[f64; SIX_DOF]> = (0..6).map(|_| [(); SIX_DOF].map(|()| number())).collect();
        let mut x = right.clone();
        assert!(matrix.solve(&mut x, &mut Vec::new()));
        let x: Vec<f64> = x.into_iter().flatten().collect();
        for (row, wanted) in full.iter().zip(right.iter().flatten()) {
            let got: f64 = row.iter().zip(&x).map(|(a, b)| a * b).sum();
            // Rounding of 36 products times a condition number of some hundred.
            assert!((got - wanted).abs() < 1.0e-12, "{got} {wanted}");
        }
    }

    #[test]
    fn a_column_is_narrow_and_a_crowd_is_too_large() {
        let mut matrix = Skyline::default();
        assert!(matrix.shape(1000, (0..999).map(|i| (i, i + 1))));
        assert!(matrix.values.len() < 1000 * SIX_DOF * 2 * SIX_DOF);
        let all = (0..200_u32).flat_map(|i| (0..i).map(move |j| (i, j)));
        assert!(!matrix.shape(200, all));
    }
}
