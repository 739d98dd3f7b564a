//! Runs every hand with every stimulus, and checks the promises.

use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use palpate::haptic::account::EnergyAccount;
use palpate::haptic::cycle::Settings;
use palpate::{BuildError, ClampFlags, Vector3};

use super::device::DeviceProfile;
use super::fidelity::{LEAST_J, TAPS};
use super::hand::{self, Grip, Hand};
use super::prepared::{DEPTH_M, FORCE_SHARE, Prepared, encoder_ceiling_n_per_m};
use super::run::{Run, Setup, run};
use super::stimulus::{self, Site, Stimulus};
use super::surface::{Wall, with_tissue};

/// Energy that a contact may create [J].
const CREATED_J: f64 = 0.01e-3;
/// Young's moduli [Pa], and the largest RMS force above 50 Hz in a slow press on tissue up to each
/// [N].
const BUZZ: [(f64, f64); 3] = [(3.5e3, 10e-3), (20e3, 25e-3), (100e3, 40e-3)];
/// Largest RMS force above 50 Hz in a hold, for a slope below the encoder's ceiling [N].
const HOLD_BUZZ_N: f64 = 20e-3;

/// Surface to touch.
#[derive(Clone, Debug)]
pub enum Target {
    /// A wall of this stiffness [N/m].
    Wall(f64),
    /// A scene's patch and its Young's modulus [Pa].
    Tissue(Box<Prepared>, f64),
}

impl Target {
    /// Depth at which presses rest [m], and force [N] and slope [N/m] at that depth.
    #[must_use]
    pub fn rest(&self, device: &DeviceProfile) -> (f64, f64, f64) {
        match self {
            Self::Wall(n_per_m) => {
                let depth_m = (FORCE_SHARE * device.force_limit_n / n_per_m).min(DEPTH_M);
                (depth_m, n_per_m * depth_m, *n_per_m)
            }
            Self::Tissue(tissue, _) => (tissue.depth_m, tissue.static_n, tissue.slope_n_per_m),
        }
    }

    /// Site of the press.
    #[must_use]
    pub fn site(&self) -> Site {
        match self {
            Self::Wall(_) => Site::new(Vector3::zeros(), Vector3::z()),
            Self::Tissue(tissue, _) => Site::new(tissue.patch.touch_m(&tissue.params).cast(), tissue.params.probe.axis.cast()),
        }
    }

    /// Sets up one run.
    #[must_use]
    pub fn setup<'a>(&self, device: &'a DeviceProfile, hand: Hand, stimulus: Stimulus) -> Setup<'a> {
        let (depth_m, static_n, _) = self.rest(device);
        let limits = device.limits(Vector3::zeros());
        let settings = Settings { limits: device.limit_values(), ..Settings::safe(&limits) };
        Setup { device, hand, stimulus, settings, depth_m, static_n }
    }

    /// Runs one hand with one motion.
    ///
    /// # Errors
    /// Propagates build errors of the core.
    pub fn run(&self, device: &DeviceProfile, hand: Hand, stimulus: Stimulus) -> Result<Run, BuildError> {
        let setup = self.setup(device, hand, stimulus);
        match self {
            Self::Wall(n_per_m) => run(&setup, &mut Wall::new(*n_per_m, device.force_limit_n, Vector3::z())),
            Self::Tissue(tissue, _) => with_tissue(&tissue.patch, &tissue.params, |surface| run(&setup, surface))?,
        }
    }
}

/// Figures of one run.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Row {
    /// Id of the hand.
    #[serde(deserialize_with = "hand::id")]
    pub hand: hand::Id,
    /// Id of the stimulus.
    #[serde(deserialize_with = "stimulus::id")]
    pub stimulus: stimulus::Id,
    /// Verdict on anything felt besides the tissue: `quiet`, or the first violation.
    pub verdict: String,
    /// Peak-to-peak motion of the handle in the last half second [um].
    pub swing_um: Option<f64>,
    /// Force above 20 Hz in the last half second, RMS [mN].
    pub shake_mn: Option<f64>,
    /// Energy created by the worst contact [mJ].
    pub created_mj: f64,
    /// Force above 50 Hz in a slow press, RMS [mN].
    pub buzz_mn: Option<f64>,
    /// Force above 50 Hz in the last half second, RMS [mN].
    pub hold_buzz_mn: Option<f64>,
    /// Force that the controller adds to the model's force at the end, relative to the model's
    /// force [%].
    pub static_error_pct: Option<f64>,
    /// Largest turn of the force in a tick [degrees].
    pub turn_deg: Option<f64>,
    /// Largest force [N].
    pub peak_n: f64,
    /// Whether a count toggles because no count balances the hand, which is not a fault of the
    /// loop.
    pub count_toggles: bool,
    /// Whether the force is scaled down until the contact ends, because the contact was at the
    /// force limit for long.
    pub weakened: bool,
}

impl Row {
    fn of(run: &Run, hand: Hand, stimulus: Stimulus, count_n: Option<f64>) -> Self {
        let cycles = run.hold.is_some_and(|h| h.limit_cycle());
        // a count toggles if the motion is within two counts, does not grow, and has no more force
        // than one count at this depth
        let count_toggles = count_n
            .is_some_and(|most_n| run.hold.is_some_and(|h| h.swing_m <= h.most_swing_m && !h.grows && h.shake_n <= most_n));
        let verdict = match (run.fault, run.broken.first()) {
            (Some(fault), _) => fault.to_string(),
            (None, Some(broken)) => format!("{}: {}", broken.id, broken.what),
            (None, None) if run.created_j > CREATED_J => "creates energy".into(),
            (None, None) if cycles && count_toggles => "a count toggles".into(),
            (None, None) if cycles => "limit cycle".into(),
            (None, None) => "quiet".into(),
        };
        // a released hand and one that changes its grip do not press slowly: any shaking is their
        // own
        let steady = !matches!(hand.grip, Grip::Released | Grip::Changing { .. });
        // a contact that was at the force limit for long is weakened on purpose until it ends
        let relieved = run.rows.last().is_some_and(|r| r.telemetry.limiters.contains(ClampFlags::GAIN));
        let still = run.hold.filter(|h| h.swing_m <= 1e-9 && !relieved);
        Self {
            hand: hand.id,
            stimulus: stimulus.id,
            verdict,
            swing_um: run.hold.map(|h| h.swing_m * 1e6),
            shake_mn: run.hold.map(|h| h.shake_n * 1e3),
            created_mj: run.created_j * 1e3,
            buzz_mn: run.buzz_n.filter(|_| steady).map(|b| b * 1e3),
            hold_buzz_mn: run.hold.map(|_| run.hold_buzz_n * 1e3),
            static_error_pct: still.map(|_| run.static_error * 100.0),
            turn_deg: run.turn_deg,
            peak_n: run.peak_n,
            count_toggles,
            weakened: relieved,
        }
    }

    /// Whether nothing is felt besides the tissue.
    #[must_use]
    pub fn good(&self) -> bool {
        matches!(self.verdict.as_str(), "quiet" | "a count toggles")
    }
}

/// All runs of a device, in the order of hands and stimuli.
#[derive(Clone, Debug, Serialize)]
pub struct Report {
    /// The device's name.
    pub device: String,
    /// Name of the touched surface.
    pub target: String,
    /// Depth of presses [mm].
    pub depth_mm: f64,
    /// Force at that depth [N].
    pub static_n: f64,
    /// Slope at that depth [N/m].
    pub slope_n_per_m: f64,
    /// Slope up to which one count is not felt [N/m].
    pub encoder_ceiling_n_per_m: f64,
    /// One encoder count [m].
    pub count_m: f64,
    /// The most energy that the device can give the hand at once, beyond what the hand gives [mJ].
    pub bound_at_once_mj: f64,
    /// The most at once if the device misses four periods in a row and holds its force [mJ].
    pub bound_after_four_missed_mj: f64,
    /// Energy given within ten seconds [mJ].
    pub bound_in_ten_seconds_mj: f64,
    /// Substeps per tick.
    pub substeps: u16,
    /// RMS error of taps at 0.2 and 0.5 m/s [%].
    pub tap_error_pct: Option<[f64; 2]>,
    /// One row per run.
    pub runs: Vec<Row>,
    /// Promises that did not hold.
    pub broken: Vec<String>,
}

/// Every hand with every stimulus for which the device has enough axes.
#[must_use]
pub fn pairs(device: &DeviceProfile, hands: &[Hand], stimuli: &[Stimulus]) -> Vec<(Hand, Stimulus)> {
    let pairs = hands.iter().flat_map(|h| stimuli.iter().map(move |s| (*h, *s)));
    // a paddle cannot move along the surface: such a run would be a hold
    pairs.filter(|(_, s)| device.axes > 1 || !s.crosses_edges()).collect()
}

/// Runs each of these pairs of hand and stimulus with `run`.
///
/// # Errors
/// Returns the first error of a run.
pub fn rows<E: Send>(
    target: &Target,
    device: &DeviceProfile,
    pairs: &[(Hand, Stimulus)],
    run: &(dyn Fn(Hand, Stimulus) -> Result<Run, E> + Sync),
) -> Result<Vec<Row>, E> {
    let (_, _, slope_n_per_m) = target.rest(device);
    let count_n = (slope_n_per_m > encoder_ceiling_n_per_m(device)).then_some(slope_n_per_m * device.count_m);
    pairs.par_iter().map(|(hand, stimulus)| Ok(Row::of(&run(*hand, *stimulus)?, *hand, *stimulus, count_n))).collect()
}

/// Judges the promises over all runs.
#[must_use]
pub fn report(name: &str, target: &Target, device: &DeviceProfile, runs: Vec<Row>) -> Report {
    let (depth_m, static_n, slope_n_per_m) = target.rest(device);
    let ceiling = encoder_ceiling_n_per_m(device);
    let limits = device.limits(Vector3::zeros());
    let settings = Settings::safe(&limits);
    let bound_of = |missed| EnergyAccount::bound(&settings.account, &limits, settings.tick_s, missed);
    let bound = bound_of(0);
    let (substeps, tap_error_pct) = match target {
        Target::Wall(_) => (1, None),
        Target::Tissue(tissue, _) => (tissue.params.substeps, Some(tissue.tap_errors.map(|e| e * 100.0))),
    };
    let mut report = Report {
        device: device.name.clone(),
        target: name.into(),
        depth_mm: depth_m * 1e3,
        static_n,
        slope_n_per_m,
        encoder_ceiling_n_per_m: ceiling,
        count_m: device.count_m,
        bound_at_once_mj: f64::from(bound.at_once_j) * 1e3,
        bound_after_four_missed_mj: f64::from(bound_of(4).at_once_j) * 1e3,
        bound_in_ten_seconds_mj: f64::from(bound.within_j(10.0)) * 1e3,
        substeps,
        tap_error_pct,
        runs,
        broken: Vec::new(),
    };
    report.broken = report.promises(target);
    report
}

impl Report {
    fn promises(&self, target: &Target) -> Vec<String> {
        let mut broken = Vec::new();
        for row in self.runs.iter().filter(|r| !r.good()) {
            broken.push(format!("{} {}: {}", row.hand, row.stimulus, row.verdict));
        }
        let error_pct = self.most(|r| r.static_error_pct).unwrap_or(0.0);
        if error_pct > 0.1 {
            broken.push(format!("the controller changes the static force by {error_pct:.2} %"));
        }
        let Target::Tissue(tissue, youngs_modulus_pa) = target else { return broken };
        if !tissue.fast_taps_held {
            broken.push(format!(
                "taps of 1 m/s diverge with any number of substeps tried: a smaller stiffening_b (now {}) or less depth",
                tissue.params.stiffening_b
            ));
        }
        if tissue.substeps_chosen && !tissue.taps_held {
            let [slow, fast] = tissue.tap_errors.map(|e| e * 100.0);
            if tissue.tap_errors.iter().zip(TAPS).any(|(e, (_, most))| *e > most) {
                broken.push(format!("taps at 0.2 and 0.5 m/s are {slow:.1} and {fast:.1} % off (2 and 7.5 are promised)"));
            }
            if tissue.lowest_j <= LEAST_J {
                let without = if tissue.params.stiffening_b > 0.0 { " without stiffening_b" } else { "" };
                broken.push(format!(
                    "a tap of 0.5 m/s as deep as the probe's radius, or as the patch allows, crushes a tet to {:.2} of its volume (more than {LEAST_J} is \
                     promised): press the patch that palpate fit makes of this scene{without}",
                    tissue.lowest_j
                ));
            }
            if tissue.tap_errors.iter().any(|e| e.is_nan()) {
                broken.push(
                    "a tap could not be compared: the mesh has a sliver, or no number of substeps up to 16 holds it".into(),
                );
            }
        }
        let buzz_mn = self.most(|r| r.buzz_mn).unwrap_or(0.0);
        if let Some((_, most_n)) = BUZZ.iter().find(|(e, _)| *youngs_modulus_pa <= *e)
            && buzz_mn > most_n * 1e3
        {
            broken.push(format!("a slow press buzzes with {buzz_mn:.1} mN, at most {:.0} were promised", most_n * 1e3));
        }
        let below = self.slope_n_per_m <= self.encoder_ceiling_n_per_m;
        let hold_mn = self.most(|r| r.hold_buzz_mn).unwrap_or(0.0);
        if below && hold_mn > HOLD_BUZZ_N * 1e3 {
            broken.push(format!("a hold buzzes with {hold_mn:.1} mN"));
        }
        broken
    }

    /// The largest value over all runs that measured it.
    #[must_use]
    pub fn most(&self, number: impl Fn(&Row) -> Option<f64>) -> Option<f64> {
        self.runs.iter().filter_map(number).reduce(f64::max)
    }
}
