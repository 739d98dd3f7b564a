//! Detects a nodule by net force and by the contact map. The nodule is 8 mm across, ten times as
//! stiff as the tissue, and its centre is 10 mm below a line of nine presses on the calibrated
//! patch.
//!
//! A trial is a line of presses with or without the nodule, in tissue of unknown stiffness. The
//! hand does not keep the depth of 3 mm exactly, and the readings of each press are noisy. An
//! observer reads some of force, area, centre and peak pressure of all presses and combines them
//! with optimal linear weights (Fisher's discriminant, trained on other trials). The area under its
//! ROC curve is the share of pairs of lines in which it picks the line with the nodule; 0.5 is
//! chance.

use palpate::{ContactMap, Params, ProbePose, Vector3, tick};
use palpate_tests::bench::Noise;
use palpate_tissue::patch::{Memory, Patch};
use palpate_tissue::scene::Inclusion;
use palpate_tissue::session::calibrated;
use palpate_tissue::stable_step::limits;

/// Number of presses per line, and their spacing [m]; the nodule is below the middle press.
const PRESSES: usize = 9;
const STEP_M: f64 = 3e-3;
/// Distances of the lines from the nodule's centre [m]; each line meets the mesh differently.
const LINES_M: [f64; 5] = [-3e-3, -1.5e-3, 0.0, 1.5e-3, 3e-3];
/// Depths at which a press is solved [m]; readings between them are interpolated.
const DEPTHS_M: [f64; 6] = [1.0e-3, 1.8e-3, 2.6e-3, 3.4e-3, 4.2e-3, 5.0e-3];
/// Intended depth of the hand [m].
const MEANT_M: f64 = 3e-3;
/// Standard deviation of Young's modulus between trials, relative to its mean (1).
const MODULUS: f64 = 0.15;
/// Number of trials with and as many without the nodule, for training and again for testing.
const TRIALS: usize = 1500;

/// Readings of a press: logarithm of the force, logarithm of the area, centre along the line
/// relative to the tip [m], logarithm of the peak pressure.
type Touch = [f64; 4];
const FORCE: &[usize] = &[0];
const MAP: &[usize] = &[1, 2, 3];
const BOTH: &[usize] = &[0, 1, 2, 3];

/// Readings on a patch, shape \[lines\]\[presses\]\[depths\].
fn touches(patch: &Patch, params: &Params) -> Vec<Vec<Vec<Touch>>> {
    let model = patch.wide_model();
    let mut memory = Memory::for_model(&model);
    let (tuned, mut state) = memory.start(&model, params).unwrap();
    let mut press = |x_m: f64, y_m: f64| {
        state.reset(&model);
        let mut depth_m = -5e-4_f64;
        let mut hold = |to_m: &f64| {
            let mut force_n = 0.0;
            for _ in 0..150 {
                depth_m = (depth_m + 2e-5).min(*to_m);
                let tip_m = Vector3::new(x_m, y_m, -depth_m).cast();
                let output = tick(&model, &tuned, &mut state, ProbePose { tip_m });
                assert_eq!(output.fault, None);
                force_n = f64::from(output.force_n.z);
            }
            let map = ContactMap::read(&model, &tuned, &mut state, &mut []);
            let beside_m = f64::from(map.centre_m.x) - x_m;
            [force_n.ln(), f64::from(map.area_m2).ln(), beside_m, f64::from(map.peak_pressure_pa).ln()]
        };
        DEPTHS_M.iter().map(&mut hold).collect()
    };
    let along_m = |k: usize| (k as f64 - 4.0) * STEP_M;
    LINES_M.iter().map(|y_m| (0..PRESSES).map(|k| press(along_m(k), *y_m)).collect()).collect()
}

/// A nearly normal random number of mean 0 and variance 1.
fn normal(noise: &mut Noise) -> f64 {
    (0..12).map(|_| 0.5 * noise.uniform()).sum()
}

/// Readings of a line. `unsteady` is the relative standard deviation of the depth (1), `sensor` the
/// standard deviation of each reading.
fn read(lines: &[Vec<Vec<Touch>>], noise: &mut Noise, unsteady: f64, sensor: &Touch) -> Vec<f64> {
    let line = &lines[((noise.uniform() + 1.0) * 0.5 * lines.len() as f64) as usize % lines.len()];
    let stiffer = MODULUS * normal(noise);
    let mut felt = Vec::new();
    for press in line {
        let depth_m = (MEANT_M * (1.0 + unsteady * normal(noise))).clamp(DEPTHS_M[0], DEPTHS_M[5]);
        let above = DEPTHS_M.iter().position(|d| *d >= depth_m).unwrap().max(1);
        let t = (depth_m / DEPTHS_M[above - 1]).ln() / (DEPTHS_M[above] / DEPTHS_M[above - 1]).ln();
        for (m, sensor) in sensor.iter().enumerate() {
            let modulus = if m == 0 || m == 3 { stiffer } else { 0.0 };
            felt.push(press[above - 1][m] * (1.0 - t) + press[above][m] * t + modulus + sensor * normal(noise));
        }
    }
    felt
}

/// Area under the ROC curve of an observer that uses these readings of every press (1).
fn found(learn: &[Vec<Vec<f64>>; 2], judge: &[Vec<Vec<f64>>; 2], reads: &[usize]) -> f64 {
    let size = PRESSES * reads.len();
    let pick = |felt: &Vec<f64>| felt.chunks(4).flat_map(|touch| reads.iter().map(|m| touch[*m])).collect::<Vec<f64>>();
    let mean = |trials: &Vec<Vec<f64>>| {
        let mut sum = vec![0.0; size];
        trials.iter().for_each(|felt| sum.iter_mut().zip(pick(felt)).for_each(|(sum, f)| *sum += f / TRIALS as f64));
        sum
    };
    let means = learn.each_ref().map(mean);
    let mut spread = vec![vec![0.0; size]; size];
    for (trials, mean) in learn.iter().zip(&means) {
        for felt in trials {
            let d: Vec<f64> = pick(felt).iter().zip(mean).map(|(f, m)| f - m).collect();
            spread.iter_mut().zip(&d).for_each(|(row, a)| row.iter_mut().zip(&d).for_each(|(s, b)| *s += a * b));
        }
    }
    let weights = solved(spread, means[1].iter().zip(&means[0]).map(|(a, b)| a - b).collect());
    let score = |felt: &Vec<f64>| pick(felt).iter().zip(&weights).map(|(f, w)| f * w).sum::<f64>();
    let [without, with] = judge.each_ref().map(|trials| trials.iter().map(score).collect::<Vec<_>>());
    let named: usize = with.iter().map(|score| without.iter().filter(|other| *other < score).count()).sum();
    named as f64 / (TRIALS * TRIALS) as f64
}

/// Solves a positive definite system by Gaussian elimination.
fn solved(mut a: Vec<Vec<f64>>, mut b: Vec<f64>) -> Vec<f64> {
    for k in 0..b.len() {
        let row = a[k].clone();
        for i in k + 1..b.len() {
            let factor = a[i][k] / row[k];
            a[i].iter_mut().zip(&row).for_each(|(x, y)| *x -= factor * y);
            b[i] -= factor * b[k];
        }
    }
    for k in (0..b.len()).rev() {
        b[k] = (b[k] - (k + 1..b.len()).map(|j| a[k][j] * b[j]).sum::<f64>()) / a[k][k];
    }
    b
}

#[test]
#[ignore = "long: 90 presses held at six depths, 5 s"]
fn an_unsteady_hand_finds_by_the_map_what_it_misses_by_force() {
    let (patch, packed) = calibrated::sized(410).unwrap();
    let params = Params { limits: limits(&patch, 1e-3), substeps: 2, node_damping_per_s: 60.0, ..packed };
    let nodule = Inclusion { center_m: [0.0, 0.0, -10e-3], radius_m: 4e-3, stiffness_ratio: 10.0, stiffening_b: None };
    let lines = [patch.clone(), patch.with_inclusions(&[nodule])].map(|patch| touches(&patch, &params));
    let mut noise = Noise::new(1);
    // noise of two tactile arrays: of force, area and peak (relative) and of the centre [m]
    for (array, sensor) in [("good", [0.01, 0.03, 1e-4, 0.05]), ("plain", [0.02, 0.06, 2e-4, 0.10])] {
        for unsteady in [0.0, 0.05, 0.10, 0.20, 0.30] {
            let mut trials =
                || lines.each_ref().map(|lines| (0..TRIALS).map(|_| read(lines, &mut noise, unsteady, &sensor)).collect());
            let (learn, judge) = (trials(), trials());
            let [force, map, both] = [FORCE, MAP, BOTH].map(|reads| found(&learn, &judge, reads));
            println!("{array} array, depth +-{:.0} %: force {force:.2}, map {map:.2}, both {both:.2}", unsteady * 100.0);
            if unsteady == 0.0 {
                // the depth is known exactly, so no reading is better than the force
                assert!(force > 0.99 && force >= map, "{force} {map}");
            }
            if unsteady >= 0.2 {
                assert!(force < 0.68 && map > if array == "good" { 0.92 } else { 0.76 }, "{force} {map}");
            }
            assert!(both > force.max(map) - 0.02, "{both} {force} {map}");
        }
    }
}
