//! Power spectrum of a force.

use nalgebra::Complex;

/// Samples per segment; each segment overlaps the one before by half.
const SEGMENT: usize = 1024;

/// Amplitude spectral density by Welch's method, Hann window, at 1 kHz: (frequency [Hz], density
/// [N/sqrt(Hz)]), without the constant part. Empty for a record shorter than a segment.
#[must_use]
pub fn density(force_n: &[f64]) -> Vec<(f64, f64)> {
    let window: Vec<f64> = (0..SEGMENT).map(|n| 0.5 - 0.5 * (std::f64::consts::TAU * n as f64 / SEGMENT as f64).cos()).collect();
    let weight: f64 = window.iter().map(|w| w * w).sum();
    let mut power = vec![0.0; SEGMENT / 2];
    let mut segments = 0;
    for start in (0..).step_by(SEGMENT / 2).take_while(|s| s + SEGMENT <= force_n.len()) {
        let part = &force_n[start..start + SEGMENT];
        let mean = part.iter().sum::<f64>() / SEGMENT as f64;
        let windowed: Vec<Complex<f64>> = part.iter().zip(&window).map(|(f, w)| Complex::new((f - mean) * w, 0.0)).collect();
        let bins = transform(&windowed);
        for (sum, bin) in power.iter_mut().zip(&bins) {
            *sum += 2.0 * bin.norm_sqr() / (1000.0 * weight);
        }
        segments += 1;
    }
    if segments == 0 {
        return Vec::new();
    }
    let hz = |n: usize| n as f64 * 1000.0 / SEGMENT as f64;
    power.iter().enumerate().skip(1).map(|(n, p)| (hz(n), (p / f64::from(segments)).sqrt())).collect()
}

/// Discrete Fourier transform of a power of two of samples, by halves (Cooley and Tukey 1965).
fn transform(samples: &[Complex<f64>]) -> Vec<Complex<f64>> {
    let count = samples.len();
    if count < 2 {
        return samples.to_vec();
    }
    let half = |from: usize| transform(&samples.iter().copied().skip(from).step_by(2).collect::<Vec<_>>());
    let (even, odd) = (half(0), half(1));
    let turned = |k: usize| {
        let (sine, cosine) = (-std::f64::consts::TAU * k as f64 / count as f64).sin_cos();
        Complex::new(cosine, sine) * odd[k]
    };
    let first = (0..count / 2).map(|k| even[k] + turned(k));
    first.chain((0..count / 2).map(|k| even[k] - turned(k))).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_density_integrates_to_the_power_of_a_tone() {
        let tone: Vec<f64> = (0..8192).map(|n| 3.0 + 0.5 * (std::f64::consts::TAU * 62.5 * f64::from(n) * 1e-3).sin()).collect();
        let density = density(&tone);
        let width = 1000.0 / 1024.0;
        let power: f64 = density.iter().map(|(_, d)| d * d * width).sum();
        assert!((power / 0.125 - 1.0).abs() < 1e-3, "{power}");
        let peak = density.iter().max_by(|a, b| a.1.total_cmp(&b.1)).unwrap();
        assert!((peak.0 - 62.5).abs() < width);
    }
}
