//! The foundation points of a triangle: where they lie, and how values pass between them and the
//! corners.

/// Barycentric weights of the four points, corner by corner: the centroid last, before it the
/// middles between it and the corners.
const FOUR: [[f32; 3]; 4] = [
    [2.0 / 3.0, 1.0 / 6.0, 1.0 / 6.0],
    [1.0 / 6.0, 2.0 / 3.0, 1.0 / 6.0],
    [1.0 / 6.0, 1.0 / 6.0, 2.0 / 3.0],
    [1.0 / 3.0, 1.0 / 3.0, 1.0 / 3.0],
];

/// Barycentric weights of nine points: centroids of the triangle's nine equal parts, first those
/// with its orientation.
pub(crate) const NINE: [[f32; 3]; 9] = [
    [7.0 / 9.0, 1.0 / 9.0, 1.0 / 9.0],
    [1.0 / 9.0, 7.0 / 9.0, 1.0 / 9.0],
    [1.0 / 9.0, 1.0 / 9.0, 7.0 / 9.0],
    [4.0 / 9.0, 4.0 / 9.0, 1.0 / 9.0],
    [1.0 / 9.0, 4.0 / 9.0, 4.0 / 9.0],
    [4.0 / 9.0, 1.0 / 9.0, 4.0 / 9.0],
    [5.0 / 9.0, 2.0 / 9.0, 2.0 / 9.0],
    [2.0 / 9.0, 5.0 / 9.0, 2.0 / 9.0],
    [2.0 / 9.0, 2.0 / 9.0, 5.0 / 9.0],
];

/// Barycentric weights of a triangle's points: four, or nine.
#[must_use]
pub fn point_weights(per_triangle: usize) -> &'static [[f32; 3]] {
    if per_triangle == NINE.len() { &NINE } else { &FOUR }
}

const THIRD: f32 = 1.0 / 3.0;
const SIXTH: f32 = 1.0 / 6.0;
const NINTH: f32 = 1.0 / 9.0;

/// The points of a triangle.
pub(crate) trait Points<const Q: usize> {
    /// A quantity at the points, from its values at the corners: the weights with fewer operations.
    fn at<T: Copy + core::ops::Add<Output = T> + core::ops::Mul<f32, Output = T>>(corners: [T; 3]) -> [T; Q];
    /// Distributes a force at the points to the corners: the transpose of `at`.
    fn shared<T: Copy + core::ops::Add<Output = T> + core::ops::Mul<f32, Output = T>>(on: [T; Q]) -> [T; 3];
}

pub(crate) struct Four;
pub(crate) struct Nine;

impl Points<4> for Four {
    #[inline(always)]
    fn at<T: Copy + core::ops::Add<Output = T> + core::ops::Mul<f32, Output = T>>([a, b, c]: [T; 3]) -> [T; 4] {
        let middle = (a + b + c) * THIRD;
        [(a + middle) * 0.5, (b + middle) * 0.5, (c + middle) * 0.5, middle]
    }

    #[inline(always)]
    fn shared<T: Copy + core::ops::Add<Output = T> + core::ops::Mul<f32, Output = T>>([a, b, c, middle]: [T; 4]) -> [T; 3] {
        let all = (a + b + c) * SIXTH + middle * THIRD;
        [all + a * 0.5, all + b * 0.5, all + c * 0.5]
    }
}

impl Points<9> for Nine {
    #[inline(always)]
    fn at<T: Copy + core::ops::Add<Output = T> + core::ops::Mul<f32, Output = T>>([a, b, c]: [T; 3]) -> [T; 9] {
        let (a, b, c) = (a * THIRD, b * THIRD, c * THIRD);
        let m = (a + b + c) * THIRD;
        let (ma, mb, mc) = (m + a, m + b, m + c);
        [ma + a, mb + b, mc + c, ma + b, mb + c, mc + a, m + ma, m + mb, m + mc]
    }

    #[inline(always)]
    fn shared<T: Copy + core::ops::Add<Output = T> + core::ops::Mul<f32, Output = T>>(on: [T; 9]) -> [T; 3] {
        let [a, b, c, ab, bc, ca, ma, mb, mc] = on;
        let inner = ma + mb + mc;
        let all = ((a + b + c) + (ab + bc + ca) + (inner + inner)) * NINTH;
        [all + (a + a + ab + ca + ma) * THIRD, all + (b + b + ab + bc + mb) * THIRD, all + (c + c + bc + ca + mc) * THIRD]
    }
}
