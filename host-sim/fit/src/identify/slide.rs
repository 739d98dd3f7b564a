//! Friction from the part of a test in which the pressed tip slides along the surface.

/// Number of parts of a slide whose means are compared, and Student's t for a 90 % interval of
/// their mean (1).
const PARTS: usize = 8;
const STUDENT_90: f64 = 1.895;
/// Force over its peak above which the tip counts as pressed (1).
const PRESSED: f64 = 0.3;
/// Largest ratio of the forces along and across a surface that is believed (1).
const MOST: f64 = 3.0;

/// A slide of a pressed tip.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Slide {
    /// Way along the surface [m].
    pub travel_m: f64,
    /// Mean speed along the surface [m/s].
    pub speed_m_per_s: f64,
    /// Force along the surface over the force across it (1).
    pub friction: f64,
    /// The 90 % interval of the friction, from the spread of the slide's parts (1).
    pub interval: [f64; 2],
    /// Standard deviation of the ratio from row to row, over its mean (1).
    pub pulsing: f64,
}

impl Slide {
    /// Friction of a test from rows of time [s], depth [m] and force [N], and from positions [m]
    /// and forces [N] along the surface; `None` if the tip does not move along the surface. The
    /// first half of each stroke is left out, as the surface follows the tip there before it slips.
    ///
    /// # Errors
    /// One sentence: the slide is too short, or its force is none of friction.
    pub fn of(name: &str, rows: &[[f64; 3]], along: &[[f64; 2]], contact_radius_m: f64) -> Result<Option<Self>, String> {
        let peak_n = rows.iter().map(|row| row[2]).fold(0.0, f64::max);
        let free: Vec<f64> = rows.iter().zip(along).take_while(|(row, _)| row[2] < 0.02 * peak_n).map(|(_, a)| a[1]).collect();
        let zero_n = free.iter().sum::<f64>() / free.len().max(1) as f64;
        let pressed: Vec<usize> = (0..rows.len()).filter(|n| rows[*n][2] > PRESSED * peak_n).collect();
        let way_m = |a: usize, b: usize| along[b][0] - along[a][0];
        let travel_m: f64 = pressed.windows(2).map(|w| way_m(w[0], w[1]).abs()).sum();
        if travel_m <= 0.0 {
            return Ok(None);
        }
        // strokes end where the direction changes
        let mut strokes: Vec<Vec<usize>> = Vec::new();
        for pair in pressed.windows(2).filter(|w| way_m(w[0], w[1]) != 0.0) {
            let forth = way_m(pair[0], pair[1]) > 0.0;
            match strokes.last_mut() {
                Some(stroke) if (way_m(stroke[0], stroke[stroke.len() - 1]) > 0.0) == forth => stroke.push(pair[1]),
                _ => strokes.push(vec![pair[0], pair[1]]),
            }
        }
        let mut slid: Vec<[f64; 2]> = Vec::new();
        let mut time_s = 0.0;
        for stroke in strokes {
            let last = stroke[stroke.len() - 1];
            let whole_m = way_m(stroke[0], last);
            time_s += rows[last][0] - rows[stroke[0]][0];
            // in the row in which the tip turns back the force may have turned already
            let late = stroke[..stroke.len() - 1]
                .iter()
                .filter(|n| way_m(stroke[0], **n).abs() > 0.5 * whole_m.abs() && whole_m.abs() > contact_radius_m);
            slid.extend(late.map(|n| [-whole_m.signum() * (along[*n][1] - zero_n), rows[*n][2]]));
        }
        if slid.len() < 2 * PARTS {
            return Err(format!(
                "{name}: the tip slides {:.2} mm along the surface in {} rows, too short a way to slip: slide further than {:.1} mm in one direction, or leave the columns along the surface out",
                travel_m * 1e3,
                slid.len(),
                4.0 * contact_radius_m * 1e3
            ));
        }
        // a sensor may give the force on the tissue
        let ratio = |rows: &[[f64; 2]]| rows.iter().map(|r| r[0]).sum::<f64>() / rows.iter().map(|r| r[1]).sum::<f64>();
        let sign = ratio(&slid).signum();
        let friction = sign * ratio(&slid);
        if friction > MOST {
            return Err(format!(
                "{name}: the force along the surface is {friction:.1} times the force across it, which no tissue has: the columns seem to be swapped, or a unit is wrong; check their names"
            ));
        }
        let parts: Vec<f64> =
            (0..PARTS).map(|k| sign * ratio(&slid[k * slid.len() / PARTS..(k + 1) * slid.len() / PARTS])).collect();
        let spread = parts.iter().map(|part| (part - friction).powi(2)).sum::<f64>() / (PARTS - 1) as f64;
        let half = STUDENT_90 * (spread / PARTS as f64).sqrt();
        let rough =
            slid.iter().map(|[along, across]| (sign * along / across - friction).powi(2)).sum::<f64>() / slid.len() as f64;
        Ok(Some(Self {
            travel_m,
            speed_m_per_s: travel_m / time_s.max(1e-9),
            friction,
            interval: [(friction - half).max(0.0), friction + half],
            pulsing: if friction > 0.0 { rough.sqrt() / friction } else { 0.0 },
        }))
    }
}

#[cfg(test)]
mod tests {
    use super::Slide;

    /// Number between -0.5 and 0.5 that looks drawn by lot.
    fn noise(k: u64) -> f64 {
        let mut x = k.wrapping_add(1).wrapping_mul(0x9E37_79B9_7F4A_7C15);
        x = (x ^ (x >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        x = (x ^ (x >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        ((x ^ (x >> 31)) >> 11) as f64 / 9_007_199_254_740_992.0 - 0.5
    }

    /// Rows and columns along the surface of a tip that is pressed for a second and then slides
    /// back and forth against a friction that pulses by a share of itself.
    fn made(friction: f64, stroke_m: f64, pulse: f64, seed: u64) -> (Vec<[f64; 3]>, Vec<[f64; 2]>) {
        let row = |n: u64| {
            let t = n as f64 * 0.01;
            let (force_n, phase) = (2.0 * t.min(1.0), (t - 1.0).max(0.0) % 4.0);
            let at_m = stroke_m * if phase < 2.0 { 0.5 * phase } else { 2.0 - 0.5 * phase };
            let way_m = stroke_m * 0.5 * (phase % 2.0);
            let held = friction * force_n * (way_m / 1e-3).min(1.0) * (1.0 + pulse * noise(1000 * seed + n));
            let along_n = if t > 1.0 { held * if phase < 2.0 { -1.0 } else { 1.0 } } else { 0.0 };
            ([t, 1e-3 * t.min(1.0), force_n], [at_m, along_n + 0.05])
        };
        (0..900).map(row).unzip()
    }

    #[test]
    fn friction_is_the_ratio_after_the_surface_has_slipped() {
        for (truth, pulse) in [(0.1, 0.05), (0.46, 0.2), (1.4, 0.5)] {
            let mut inside = 0;
            for seed in 0..40 {
                let (rows, along) = made(truth, 12e-3, pulse, seed);
                let slide = Slide::of("made up", &rows, &along, 2e-3).unwrap().unwrap();
                assert!((slide.friction / truth - 1.0).abs() < 0.03, "{slide:?}, made with {truth}");
                // the deviation of an even spread is its width over the root of twelve
                assert!((slide.pulsing / (pulse / 12_f64.sqrt()) - 1.0).abs() < 0.1, "{slide:?}");
                inside += u32::from(slide.interval[0] <= truth && truth <= slide.interval[1]);
            }
            assert!((32..=40).contains(&inside), "{truth} in {inside} of 40 intervals of 90 %");
        }
    }

    #[test]
    fn a_slide_that_tells_no_friction_is_none_or_says_so() {
        let (rows, along) = made(0.3, 12e-3, 0.0, 0);
        let still: Vec<[f64; 2]> = along.iter().map(|a| [0.0, a[1]]).collect();
        assert_eq!(Slide::of("made up", &rows, &still, 2e-3), Ok(None));
        let (rows, short) = made(0.3, 1e-3, 0.0, 0);
        assert!(Slide::of("made up", &rows, &short, 2e-3).unwrap_err().contains("slide further than"));
        let swapped: Vec<[f64; 2]> = along.iter().map(|a| [a[0], a[1] * 100.0]).collect();
        assert!(Slide::of("made up", &rows, &swapped, 2e-3).unwrap_err().contains("seem to be swapped"));
    }
}
