//! Training score of paper 004, section 3.6: three physicians mark every intern before and after
//! the training, and their marks are combined into one value per intern.
//!
//! Equation (14): `y_i = sum_j x_ij / 10 * w_j`, with marks `x_ij` from 0 to 10 and weights of 0.45
//! for the chief, 0.35 for the associate chief and 0.20 for the attending physician.

/// Weights of the chief, the associate chief and the attending physician (1).
pub const PAPER_WEIGHTS: [f64; 3] = [0.45, 0.35, 0.20];

/// Equation (14): the value, from 0 to 1, that follows from marks from 0 to 10.
pub fn value(marks: [f64; 3], weights: [f64; 3]) -> f64 {
    marks.iter().zip(weights).map(|(x, w)| x / 10.0 * w).sum()
}

#[cfg(test)]
mod tests {
    use super::{PAPER_WEIGHTS, value};

    /// Table 1: groups 1 and 2 before the training, groups 1 and 2 after it.
    const PRINTED: [[f64; 4]; 10] = [
        [0.525, 0.400, 0.955, 0.790],
        [0.500, 0.460, 0.945, 0.795],
        [0.400, 0.500, 0.955, 0.725],
        [0.375, 0.320, 0.900, 0.820],
        [0.400, 0.400, 1.000, 0.670],
        [0.600, 0.545, 0.955, 0.840],
        [0.590, 0.300, 0.900, 0.900],
        [0.510, 0.400, 1.000, 0.710],
        [0.415, 0.435, 0.855, 0.790],
        [0.500, 0.480, 0.920, 0.795],
    ];

    #[test]
    fn values_by_hand() {
        // 0.4 * 0.45 + 0.5 * 0.35 + 0.6 * 0.20 and 0.9 * 0.45 + 0.8 * 0.35 + 1.0 * 0.20
        let values = [[4.0, 5.0, 6.0], [9.0, 8.0, 10.0]].map(|marks| value(marks, PAPER_WEIGHTS));
        assert!((values[0] - 0.475).abs() < 1e-12 && (values[1] - 0.885).abs() < 1e-12);
        assert_eq!(value([10.0; 3], PAPER_WEIGHTS), 1.0);
    }

    /// Every printed value follows from whole marks with the paper's weights, and not with others.
    #[test]
    fn every_printed_value_is_one_that_whole_marks_give() {
        let ways = |printed: f64, weights| {
            let all = (0..1331).map(|n| [n / 121, n / 11 % 11, n % 11].map(f64::from));
            all.filter(|marks| (value(*marks, weights) - printed).abs() <= 5e-4 + 1e-9).count()
        };
        assert!(PRINTED.iter().flatten().all(|printed| ways(*printed, PAPER_WEIGHTS) > 0));
        // in whole numbers 200 y = 9 a + 7 b + 4 c, which 190 and 199 are not
        assert_eq!((ways(0.95, PAPER_WEIGHTS), ways(0.995, PAPER_WEIGHTS)), (0, 0));
        assert!(PRINTED.iter().flatten().any(|printed| ways(*printed, [0.5, 0.3, 0.2]) == 0));
        // column sums of the printed table
        let sum = |column: usize| PRINTED.iter().map(|row| row[column]).sum::<f64>();
        assert!([4.815, 4.240, 9.385, 7.835].into_iter().enumerate().all(|(n, wanted)| (sum(n) - wanted).abs() < 1e-9));
    }
}
