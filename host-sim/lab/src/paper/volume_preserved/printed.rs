//! Numbers printed in paper 000, for comparison with ours: Table 1 and sections 3.3 and 3.4. Pairs
//! of values belong to the small and to the large move.

/// Table 1: for markers 1 to 7 and each move, displacement by tomography, estimated displacement
/// and error [mm].
pub const TABLE_1_MM: [[[f64; 3]; 2]; 7] = [
    [[28.7457, 31.2330, 2.7084], [58.4756, 61.6608, 4.4024]],
    [[14.7709, 15.7711, 1.5620], [38.9963, 41.4500, 3.4310]],
    [[10.7932, 13.0685, 2.3248], [30.8646, 27.5830, 3.5275]],
    [[10.6665, 11.7714, 1.1251], [28.8311, 31.7520, 3.0398]],
    [[4.9477, 5.7381, 1.2013], [19.3340, 17.8716, 3.9076]],
    [[4.3042, 5.3377, 1.1951], [6.6086, 6.7473, 1.6022]],
    [[1.8389, 1.8769, 0.4002], [2.3040, 2.6638, 0.6117]],
];

/// Values that the text gives for one resolution.
pub struct Printed {
    /// Mean landmark error [mm].
    pub landmarks_mm: [f64; 2],
    /// Mean surface error [mm].
    pub surface_mm: [f64; 2],
    /// Mean error of the two landmarks inside the organ [mm]; `None` where the paper does not give
    /// it.
    pub inside_mm: Option<[f64; 2]>,
    /// Change of the total volume [%].
    pub volume_pct: [f64; 2],
    /// Frames per second.
    pub frames_per_s: f64,
}

/// Full resolution: 12 958 + 5 423 tets.
pub const FULL: Printed = Printed {
    landmarks_mm: [1.5024, 2.9317],
    surface_mm: [1.2905, 2.6400],
    inside_mm: Some([1.6245, 2.6431]),
    volume_pct: [0.22, 0.59],
    frames_per_s: 15.0,
};

/// Sparse resolution: 1 698 + 1 157 tets.
pub const SPARSE: Printed = Printed {
    landmarks_mm: [2.5879, 5.2715],
    surface_mm: [2.7279, 4.2015],
    inside_mm: None,
    volume_pct: [0.56, 1.24],
    frames_per_s: 40.0,
};
