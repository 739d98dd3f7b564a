//! The foundation points of a triangle: their positions, and the interpolation between points and
//! corners.

/// Barycentric weights of the four points: the middles between the centroid and each corner, then
/// the centroid.
const FOUR: [[f32; 3]; 4] = [
    [2.0 / 3.0, 1.0 / 6.0, 1.0 / 6.0],
    [1.0 / 6.0, 2.0 / 3.0, 1.0 / 6.0],
    [1.0 / 6.0, 1.0 / 6.0, 2.0 / 3.0],
    [1.0 / 3.0, 1.0 / 3.0, 1.0 / 3.0],
];

/// Barycentric weights of nine points: the centroids of the triangle's nine equal parts, those of
/// the parts with its orientation first.
const NINE: [[f32; 3]; 9] = [
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

/// Barycentric weights of sixteen points: the centroids of the triangle's sixteen equal parts,
/// those of the parts with its orientation first.
#[cfg(not(target_os = "none"))]
const SIXTEEN: [[f32; 3]; 16] = [
    [5.0 / 6.0, TWELFTH, TWELFTH],
    [TWELFTH, 5.0 / 6.0, TWELFTH],
    [TWELFTH, TWELFTH, 5.0 / 6.0],
    [7.0 / 12.0, THIRD, TWELFTH],
    [THIRD, 7.0 / 12.0, TWELFTH],
    [TWELFTH, 7.0 / 12.0, THIRD],
    [TWELFTH, THIRD, 7.0 / 12.0],
    [THIRD, TWELFTH, 7.0 / 12.0],
    [7.0 / 12.0, TWELFTH, THIRD],
    [THIRD, THIRD, THIRD],
    [2.0 / 3.0, SIXTH, SIXTH],
    [SIXTH, 2.0 / 3.0, SIXTH],
    [SIXTH, SIXTH, 2.0 / 3.0],
    [5.0 / 12.0, 5.0 / 12.0, SIXTH],
    [SIXTH, 5.0 / 12.0, 5.0 / 12.0],
    [5.0 / 12.0, SIXTH, 5.0 / 12.0],
];

/// Barycentric weights of a triangle's points: four, nine, or sixteen.
#[must_use]
pub fn point_weights(per_triangle: usize) -> &'static [[f32; 3]] {
    match per_triangle {
        #[cfg(not(target_os = "none"))]
        16 => &SIXTEEN,
        9 => &NINE,
        _ => &FOUR,
    }
}

const THIRD: f32 = 1.0 / 3.0;
const SIXTH: f32 = 1.0 / 6.0;
const NINTH: f32 = 1.0 / 9.0;
#[cfg(not(target_os = "none"))]
const TWELFTH: f32 = 1.0 / 12.0;

/// The points of a triangle.
pub(crate) trait Points<const Q: usize> {
    /// Interpolates from the corners to the points: applies the weights with fewer operations.
    fn at<T: Copy + core::ops::Add<Output = T> + core::ops::Mul<f32, Output = T>>(corners: [T; 3]) -> [T; Q];
    /// Distributes a force at the points to the corners: the transpose of `at`.
    fn shared<T: Copy + core::ops::Add<Output = T> + core::ops::Mul<f32, Output = T>>(on: [T; Q]) -> [T; 3];
}

pub(crate) struct Four;
pub(crate) struct Nine;
#[cfg(not(target_os = "none"))]
pub(crate) struct Sixteen;

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

#[cfg(not(target_os = "none"))]
impl Points<16> for Sixteen {
    #[inline(always)]
    fn at<T: Copy + core::ops::Add<Output = T> + core::ops::Mul<f32, Output = T>>([a, b, c]: [T; 3]) -> [T; 16] {
        let (a, b, c) = (a * 0.25, b * 0.25, c * 0.25);
        let m = (a + b + c) * THIRD;
        let (ma, mb, mc) = (m + a, m + b, m + c);
        let (mab, mbc, mca) = (ma + b, mb + c, mc + a);
        let (aa, bb, cc) = (a + a, b + b, c + c);
        [
            ma + aa,
            mb + bb,
            mc + cc,
            mab + a,
            mab + b,
            mbc + b,
            mbc + c,
            mca + c,
            mca + a,
            mab + c,
            (m + m) + aa,
            (m + m) + bb,
            (m + m) + cc,
            m + mab,
            m + mbc,
            m + mca,
        ]
    }

    #[inline(always)]
    fn shared<T: Copy + core::ops::Add<Output = T> + core::ops::Mul<f32, Output = T>>(on: [T; 16]) -> [T; 3] {
        let [a, b, c, aab, abb, bbc, bcc, cca, caa, abc, ma, mb, mc, mab, mbc, mca] = on;
        let inner = (ma + mb + mc) + (mab + mbc + mca);
        let all = ((a + b + c) + ((aab + abb) + (bbc + bcc) + (cca + caa)) + abc + (inner + inner)) * TWELFTH;
        // weights of a corner's values beyond `all`, in quarters: three, two or one
        let of = |thrice: T, twice: T, once: T| all + ((thrice + twice) + (thrice + twice) + (thrice + once)) * 0.25;
        [
            of(a, aab + caa + ma, abb + cca + abc + mab + mca),
            of(b, abb + bbc + mb, aab + bcc + abc + mab + mbc),
            of(c, bcc + cca + mc, bbc + caa + abc + mbc + mca),
        ]
    }
}
