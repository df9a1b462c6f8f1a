//! Accelerates a fixed-point iteration `s ← g(s)`: combines the last steps into the mixture with
//! the minimum change [Anderson65].

/// Number of steps kept.
const DEPTH: usize = 6;

/// The last steps of the iteration.
#[derive(Clone, Debug, Default)]
pub(crate) struct Mixing {
    /// Last point, and its change by g.
    place: Vec<f64>,
    change: Vec<f64>,
    /// Differences of both from step to step, the oldest first.
    places: Vec<Vec<f64>>,
    changes: Vec<Vec<f64>>,
}

impl Mixing {
    pub(crate) fn forget(&mut self) {
        self.place.clear();
        self.places.clear();
        self.changes.clear();
    }

    /// Replaces `place`, which g would change by `change`, by the next point.
    pub(crate) fn advance(&mut self, place: &mut [f64], change: &[f64]) {
        if self.place.len() == place.len() {
            if self.places.len() == DEPTH {
                self.places.remove(0);
                self.changes.remove(0);
            }
            let minus = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a - b).collect();
            self.places.push(minus(place, &self.place));
            self.changes.push(minus(change, &self.change));
        }
        self.place.clear();
        self.place.extend_from_slice(place);
        self.change.clear();
        self.change.extend_from_slice(change);
        let parts = self.parts();
        for (i, value) in place.iter_mut().enumerate() {
            *value += change[i];
            for (k, part) in parts.iter().enumerate().take(self.places.len()) {
                *value -= part * (self.places[k][i] + self.changes[k][i]);
            }
        }
    }

    /// Coefficients of the differences whose sum is nearest to the current change.
    fn parts(&self) -> [f64; DEPTH] {
        let n = self.changes.len();
        let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        let (mut m, mut x) = ([[0.0; DEPTH]; DEPTH], [0.0; DEPTH]);
        for i in 0..n {
            for j in 0..n {
                m[i][j] = dot(&self.changes[i], &self.changes[j]);
            }
            // Regularize: parallel differences are distinguished by rounding errors only.
            m[i][i] *= 1.0 + 1.0e-10;
            x[i] = dot(&self.changes[i], &self.change);
        }
        for k in 0..n {
            if !(m[k][k] > 0.0) {
                return [0.0; DEPTH];
            }
            for i in k + 1..n {
                let part = m[i][k] / m[k][k];
                for j in k..n {
                    m[i][j] -= part * m[k][j];
                }
                x[i] -= part * x[k];
            }
        }
        for k in (0..n).rev() {
            for j in k + 1..n {
                x[k] -= m[k][j] * x[j];
            }
            x[k] /= m[k][k];
        }
        if x.iter().all(|x| x.is_finite()) { x } else { [0.0; DEPTH] }
    }
}

#[cfg(test)]
mod tests {
    use super::Mixing;

    #[test]
    fn a_linear_map_of_three_numbers_is_solved_in_four_steps_even_where_it_repels() {
        // g(s) = A s + b with an eigenvalue of -3 and one of 0.9.
        let g = |s: &[f64]| vec![-3.0 * s[0] + 8.0, 0.9 * s[1] + 0.1, 0.5 * s[2] + 0.2 * s[0]];
        let (mut mixing, mut s) = (Mixing::default(), vec![0.0; 3]);
        for _ in 0..5 {
            let change: Vec<f64> = g(&s).iter().zip(&s).map(|(a, b)| a - b).collect();
            mixing.advance(&mut s, &change);
        }
        for (value, wanted) in s.iter().zip([2.0, 1.0, 0.8]) {
            // The matrix of the last step is singular except for 1e-10.
            assert!((value - wanted).abs() < 1.0e-6, "{s:?}");
        }
    }
}
