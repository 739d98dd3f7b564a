//! Computes the stored references for moving probes ([`palpate_tissue::moving`]).

use palpate_tissue::error::Error;
use palpate_tissue::moving::table::{Row, Table};
use palpate_tissue::moving::truth::{Site, Trajectory, Truth};

use super::compute_with;
use super::error::DynamicError;
use super::history::History;
use super::motion::Motion;
use super::settings::Settings;

/// Computation of a stored truth.
pub trait Computed {
    /// Motion of the probe.
    fn motion(&self) -> Motion;

    /// Time between two rows of the table [s].
    fn spacing_s(&self) -> f64;

    /// Settings with which the stored table was computed.
    fn settings(&self) -> Settings;

    /// Computes the truth; `progress` is called with the time [s] after every step.
    fn compute(&self, settings: &Settings, progress: impl FnMut(f64)) -> Result<History, DynamicError>;

    /// Samples a history of this truth at the spacing of the table. The press must be along z.
    fn table(&self, history: &History) -> Table;

    /// Header lines that document the computation of a table.
    fn header(&self, settings: &Settings, history: &History) -> Vec<String>;
}

impl Computed for Truth {
    fn motion(&self) -> Motion {
        let speed = |mm_per_s: u32| f64::from(mm_per_s) / 1000.0;
        match self.trajectory {
            Trajectory::Ramp { speed_mm_per_s, hold_ms } => {
                Motion::ramp(speed(speed_mm_per_s), 0.004, f64::from(hold_ms) / 1000.0)
            }
            Trajectory::Tap { speed_mm_per_s } => Motion::tap(speed(speed_mm_per_s), 0.004, 0.02),
            Trajectory::Swing { frequency_hz } => {
                let [mean_m, amplitude_m] = Trajectory::SWING_M;
                Motion::sinusoid([0.04, 0.05], mean_m, amplitude_m, f64::from(frequency_hz), 2.0)
            }
            Trajectory::Drag { speed_mm_per_s } => Motion::drag([0.04, 0.05], 0.003, speed(speed_mm_per_s), 0.012),
        }
    }

    fn spacing_s(&self) -> f64 {
        match self.trajectory {
            Trajectory::Ramp { speed_mm_per_s, .. } if speed_mm_per_s >= 200 => 5e-4,
            Trajectory::Tap { .. } => 5e-4,
            Trajectory::Ramp { .. } | Trajectory::Swing { .. } | Trajectory::Drag { .. } => 1e-3,
        }
    }

    fn settings(&self) -> Settings {
        // the mesh is fine where the contact begins, so that the contact's edge moves from one
        // small element to the next
        let (corner_nodes, fine_radius_m) = match (self.site, self.trajectory) {
            (_, Trajectory::Drag { .. }) => (500, 0.003),
            (Site::Centre, _) => (500, 0.0035),
            (Site::Nodule, _) => (600, 0.006),
            (Site::Aside, _) => (500, 0.004),
            (Site::Askew, _) => (700, 0.004),
        };
        let slow = !matches!(self.trajectory, Trajectory::Swing { .. }) && self.trajectory.speed_mm_per_s() < 100;
        let step_s = if slow { 2e-3 } else { 1e-3 };
        Settings { corner_nodes, fine_radius_m: Some(fine_radius_m), step_s, ..Settings::default() }
    }

    fn compute(&self, settings: &Settings, progress: impl FnMut(f64)) -> Result<History, DynamicError> {
        compute_with(&self.scene().map_err(Error::from)?, &self.motion(), settings, progress)
    }

    fn table(&self, history: &History) -> Table {
        let (motion, spacing_s) = (self.motion(), self.spacing_s());
        let count = (motion.duration_s() / spacing_s).round() as u32;
        let row = |n: u32| {
            let t_s = f64::from(n) * spacing_s;
            let pose = motion.pose(t_s);
            Row { t_s, depth_m: pose.depth_m, across_m: pose.across_m[0], force_over_e_m2: history.force_over_e_m2(t_s) }
        };
        Table { rows: (0..=count).map(row).collect() }
    }

    fn header(&self, settings: &Settings, history: &History) -> Vec<String> {
        let Settings { corner_nodes, step_s, first_step_share, step_growth, spectral_radius, softness, tolerance, .. } = settings;
        let fine_radius_m = settings.fine_radius_m.map_or("by default".to_owned(), |radius_m| radius_m.to_string());
        let scene = if self.site == Site::Nodule { "nodule" } else { "block" };
        vec![
            format!("version = {}, truth = {}", Table::VERSION, self.name),
            format!("scene = {scene}, site = {:?}, youngs_modulus_pa = {}", self.site, self.youngs_modulus_pa),
            format!("motion = {:?}", self.trajectory),
            format!("corner_nodes = {corner_nodes}, fine_radius_m = {fine_radius_m}, quadratic_nodes = {}", history.nodes),
            format!("step_s = {step_s}, first_step_share = {first_step_share}, step_growth = {step_growth}"),
            format!("spectral_radius = {spectral_radius}, softness = {softness}, tolerance = {tolerance}"),
        ]
    }
}
