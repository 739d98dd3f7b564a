//! Butterworth filters of fourth order at 1 kHz, by the bilinear transform.

use palpate::Vector3;

/// Quality factors of the two sections.
const Q: [f64; 2] = [0.541_196_1, 1.306_563];

/// A filter of a vector, axis by axis. It begins settled at zero.
#[derive(Clone, Copy, Debug)]
pub struct Butterworth([Section; 2]);

impl Butterworth {
    /// Passes what is above this frequency [Hz].
    #[must_use]
    pub fn high(hz: f64) -> Self {
        Self(Q.map(|q| Section::new(hz, q, |_, gain| [gain, -2.0 * gain, gain])))
    }

    /// Passes what is below this frequency [Hz].
    #[must_use]
    pub fn low(hz: f64) -> Self {
        Self(Q.map(|q| Section::new(hz, q, |w, gain| [1.0, 2.0, 1.0].map(|b| b * w * w * gain))))
    }

    /// Filters the next sample.
    pub fn next(&mut self, x: Vector3<f64>) -> Vector3<f64> {
        self.0.iter_mut().fold(x, |x, section| section.next(x))
    }
}

#[derive(Clone, Copy, Debug)]
struct Section {
    a: [f64; 2],
    b: [f64; 3],
    x: [Vector3<f64>; 2],
    y: [Vector3<f64>; 2],
}

impl Section {
    fn new(hz: f64, q: f64, b: fn(f64, f64) -> [f64; 3]) -> Self {
        let w = (std::f64::consts::PI * hz * 1e-3).tan();
        let gain = 1.0 / (1.0 + w / q + w * w);
        let a = [2.0 * (w * w - 1.0) * gain, (1.0 - w / q + w * w) * gain];
        Self { a, b: b(w, gain), x: [Vector3::zeros(); 2], y: [Vector3::zeros(); 2] }
    }

    fn next(&mut self, x: Vector3<f64>) -> Vector3<f64> {
        let ([b0, b1, b2], [a1, a2]) = (self.b, self.a);
        let y = x * b0 + self.x[0] * b1 + self.x[1] * b2 - self.y[0] * a1 - self.y[1] * a2;
        self.x = [x, self.x[0]];
        self.y = [y, self.y[0]];
        y
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn both_filters_have_the_closed_form_of_a_butterworth() {
        let warp = |f: f64| (std::f64::consts::PI * f * 1e-3).tan();
        for hz in [15.0, 20.0, 50.0] {
            for tone_hz in [5.0, 20.0, 50.0, 120.0, 300.0] {
                let ratio = (warp(hz) / warp(tone_hz)).powi(8);
                for (mut filter, closed) in
                    [(Butterworth::high(hz), 1.0 / (1.0 + ratio)), (Butterworth::low(hz), ratio / (1.0 + ratio))]
                {
                    let tone = |n: u32| (std::f64::consts::TAU * tone_hz * f64::from(n) * 1e-3).sin();
                    let passed: Vec<f64> = (0..3000).map(|n| filter.next(Vector3::z() * tone(n)).z).collect();
                    let rms = (passed[2000..].iter().map(|y| y * y).sum::<f64>() / 1000.0).sqrt() * std::f64::consts::SQRT_2;
                    assert!((rms - closed.sqrt()).abs() < 5e-3, "{tone_hz} Hz, {hz} Hz: {rms}, closed form {}", closed.sqrt());
                }
            }
        }
    }
}
