//! A sum of squares of few unknowns, and its least solution.

/// Normal equations of a sum of squares.
#[derive(Clone, Debug)]
pub(super) struct Squares {
    count: usize,
    /// Symmetric matrix, row by row.
    normal: Vec<f64>,
    right: Vec<f64>,
}

impl Squares {
    /// The empty sum.
    pub(super) fn new(count: usize) -> Self {
        Self { count, normal: vec![0.0; count * count], right: vec![0.0; count] }
    }

    /// Adds the square of `sum c x - wanted`, for pairs of an unknown and its c.
    pub(super) fn add(&mut self, row: &[(usize, f64)], wanted: f64) {
        for (i, a) in row {
            self.right[*i] += a * wanted;
            for (j, b) in row {
                self.normal[i * self.count + j] += a * b;
            }
        }
    }

    /// Values of some unknowns that minimise the sum with all others zero, and the reduction that
    /// they bring; `None` if the sum does not determine them.
    pub(super) fn solve(&self, chosen: &[usize]) -> Option<(f64, Vec<f64>)> {
        let n = chosen.len();
        // Cholesky, the lower triangle row by row
        let mut lower = vec![0.0; n * n];
        let mut x = vec![0.0; n];
        for i in 0..n {
            for j in 0..=i {
                let done: f64 = (0..j).map(|k| lower[i * n + k] * lower[j * n + k]).sum();
                let left = self.normal[chosen[i] * self.count + chosen[j]] - done;
                lower[i * n + j] = match i == j {
                    true if left > 1e-12 * self.normal[chosen[i] * (self.count + 1)] => left.sqrt(),
                    true => return None,
                    false => left / lower[j * n + j],
                };
            }
            let done: f64 = (0..i).map(|k| lower[i * n + k] * x[k]).sum();
            x[i] = (self.right[chosen[i]] - done) / lower[i * n + i];
        }
        let reduction = x.iter().map(|y| y * y).sum();
        for i in (0..n).rev() {
            let done: f64 = (i + 1..n).map(|k| lower[k * n + i] * x[k]).sum();
            x[i] = (x[i] - done) / lower[i * n + i];
        }
        Some((reduction, x))
    }

    /// Non-negative values of some unknowns that minimise the sum, and the reduction that they
    /// bring: the best of all sets in which the others are zero.
    pub(super) fn non_negative(&self, chosen: &[usize]) -> (f64, Vec<f64>) {
        let mut best = (0.0, vec![0.0; chosen.len()]);
        for set in 1..1_usize << chosen.len() {
            let active: Vec<usize> = (0..chosen.len()).filter(|n| set >> n & 1 == 1).collect();
            let of: Vec<usize> = active.iter().map(|n| chosen[*n]).collect();
            let Some((reduction, x)) = self.solve(&of) else { continue };
            if reduction > best.0 && x.iter().all(|c| *c >= 0.0) {
                best = (reduction, vec![0.0; chosen.len()]);
                active.iter().zip(x).for_each(|(n, c)| best.1[*n] = c);
            }
        }
        best
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_least_squares_are_those_of_the_closed_form_and_non_negative_where_asked() {
        let mut squares = Squares::new(2);
        for t in 0..10 {
            let t = f64::from(t);
            squares.add(&[(0, 1.0), (1, t)], 6.0 - 0.5 * t);
        }
        let (_, free) = squares.solve(&[0, 1]).unwrap();
        assert!((free[0] - 6.0).abs() < 1e-9 && (free[1] + 0.5).abs() < 1e-9, "{free:?}");
        // the slope would be negative, so it is zero, and the constant is the mean
        let (_, signed) = squares.non_negative(&[0, 1]);
        assert!((signed[0] - 3.75).abs() < 1e-9 && signed[1] == 0.0, "{signed:?}");
        squares.add(&[(0, 1.0), (1, 1.0)], 0.0);
        assert!(Squares::new(1).solve(&[0]).is_none());
    }
}
