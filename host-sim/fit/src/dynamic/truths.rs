//! The stored truths: which scenes and motions they are of, how they are computed, and their
//! tables.
//!
//! A table is a CSV file in `data/moving`: lines that begin with `#` say how it was computed, one
//! line names the columns, and the rows are in SI units at a fixed spacing in time. The example
//! `moving_truths` computes them anew.

use palpate_tissue::scene::Scene;

use super::compute_with;
use super::error::DynamicError;
use super::history::History;
use super::motion::Motion;
use super::settings::Settings;
use super::table::Table;

/// Tissue and place of a stored truth.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Site {
    /// The preset block, pressed at its centre.
    Centre,
    /// The preset block, pressed 7.85 mm off its centre along x.
    Aside,
    /// The preset block, pressed as far off its centre, but along no plane of symmetry.
    Askew,
    /// The preset nodule, pressed above the stiff ball.
    Nodule,
}

/// Movement of a stored truth.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Course {
    /// Ramp to 4 mm, and a hold.
    Ramp {
        /// Speed [mm/s].
        speed_mm_per_s: u32,
        /// Time held [ms].
        hold_ms: u32,
    },
    /// Drag of 12 mm at 3 mm depth, after a ramp at 40 mm/s and 50 ms of rest.
    Drag {
        /// Speed across [mm/s].
        speed_mm_per_s: u32,
    },
}

/// A stored truth.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Truth {
    /// Name, also of its file.
    pub name: &'static str,
    /// Tissue and place.
    pub site: Site,
    /// Young's modulus [Pa].
    pub youngs_modulus_pa: f64,
    /// Movement.
    pub course: Course,
    /// Text of its file.
    text: &'static str,
}

macro_rules! truth {
    ($name:literal, $site:ident, $kpa:literal, $course:ident { $($field:ident: $value:literal),* }) => {
        Truth {
            name: $name,
            site: Site::$site,
            youngs_modulus_pa: $kpa * 1e3,
            course: Course::$course { $($field: $value),* },
            text: include_str!(concat!("../../data/moving/", $name, ".csv")),
        }
    };
}

/// Every stored truth.
pub const TRUTHS: [Truth; 22] = [
    truth!("centre-3.5kpa-40", Centre, 3.5, Ramp { speed_mm_per_s: 40, hold_ms: 100 }),
    truth!("centre-3.5kpa-100", Centre, 3.5, Ramp { speed_mm_per_s: 100, hold_ms: 100 }),
    truth!("centre-3.5kpa-200", Centre, 3.5, Ramp { speed_mm_per_s: 200, hold_ms: 100 }),
    truth!("centre-3.5kpa-500", Centre, 3.5, Ramp { speed_mm_per_s: 500, hold_ms: 60 }),
    truth!("centre-20kpa-40", Centre, 20.0, Ramp { speed_mm_per_s: 40, hold_ms: 100 }),
    truth!("centre-20kpa-100", Centre, 20.0, Ramp { speed_mm_per_s: 100, hold_ms: 100 }),
    truth!("centre-20kpa-200", Centre, 20.0, Ramp { speed_mm_per_s: 200, hold_ms: 100 }),
    truth!("centre-20kpa-500", Centre, 20.0, Ramp { speed_mm_per_s: 500, hold_ms: 60 }),
    truth!("centre-100kpa-40", Centre, 100.0, Ramp { speed_mm_per_s: 40, hold_ms: 100 }),
    truth!("centre-100kpa-100", Centre, 100.0, Ramp { speed_mm_per_s: 100, hold_ms: 100 }),
    truth!("centre-100kpa-200", Centre, 100.0, Ramp { speed_mm_per_s: 200, hold_ms: 100 }),
    truth!("centre-100kpa-500", Centre, 100.0, Ramp { speed_mm_per_s: 500, hold_ms: 60 }),
    truth!("nodule-3.5kpa-40", Nodule, 3.5, Ramp { speed_mm_per_s: 40, hold_ms: 100 }),
    truth!("nodule-3.5kpa-200", Nodule, 3.5, Ramp { speed_mm_per_s: 200, hold_ms: 100 }),
    truth!("aside-3.5kpa-40", Aside, 3.5, Ramp { speed_mm_per_s: 40, hold_ms: 40 }),
    truth!("aside-3.5kpa-200", Aside, 3.5, Ramp { speed_mm_per_s: 200, hold_ms: 40 }),
    truth!("aside-20kpa-40", Aside, 20.0, Ramp { speed_mm_per_s: 40, hold_ms: 40 }),
    truth!("aside-20kpa-200", Aside, 20.0, Ramp { speed_mm_per_s: 200, hold_ms: 40 }),
    truth!("aside-100kpa-40", Aside, 100.0, Ramp { speed_mm_per_s: 40, hold_ms: 40 }),
    truth!("aside-100kpa-200", Aside, 100.0, Ramp { speed_mm_per_s: 200, hold_ms: 40 }),
    truth!("askew-3.5kpa-200", Askew, 3.5, Ramp { speed_mm_per_s: 200, hold_ms: 40 }),
    truth!("drag-3.5kpa-60", Centre, 3.5, Drag { speed_mm_per_s: 60 }),
];

impl Truth {
    /// Finds a stored truth by its name.
    ///
    /// # Errors
    /// [`DynamicError::Unknown`].
    pub fn named(name: &str) -> Result<Self, DynamicError> {
        TRUTHS.into_iter().find(|truth| truth.name == name).ok_or_else(|| DynamicError::Unknown { name: name.to_owned() })
    }

    /// Scene whose tissue and place the truth has.
    ///
    /// # Errors
    /// A preset that cannot be read.
    pub fn scene(&self) -> Result<Scene, DynamicError> {
        let preset = if self.site == Site::Nodule { "nodule" } else { "block" };
        let mut scene = Scene::load(preset).map_err(palpate_tissue::error::Error::from)?;
        scene.tissue.youngs_modulus_pa = self.youngs_modulus_pa;
        match self.site {
            Site::Aside => scene.probe.position_m = Some([0.00785, 0.0]),
            Site::Askew => scene.probe.position_m = Some([0.0073, 0.0029]),
            Site::Centre | Site::Nodule => {}
        }
        Ok(scene)
    }

    /// Motion of the probe.
    #[must_use]
    pub fn motion(&self) -> Motion {
        let speed = |mm_per_s: u32| f64::from(mm_per_s) / 1000.0;
        match self.course {
            Course::Ramp { speed_mm_per_s, hold_ms } => Motion::ramp(speed(speed_mm_per_s), 0.004, f64::from(hold_ms) / 1000.0),
            Course::Drag { speed_mm_per_s } => Motion::drag([0.04, 0.05], 0.003, speed(speed_mm_per_s), 0.012),
        }
    }

    /// Time between two rows of the table [s].
    #[must_use]
    pub fn spacing_s(&self) -> f64 {
        match self.course {
            Course::Ramp { speed_mm_per_s, .. } if speed_mm_per_s >= 200 => 5e-4,
            Course::Ramp { .. } | Course::Drag { .. } => 1e-3,
        }
    }

    /// Settings that the table is computed with.
    #[must_use]
    pub fn settings(&self) -> Settings {
        // fine where the contact begins, so that its edge moves from one small element to the next
        let (corner_nodes, fine_radius_m) = match (self.site, self.course) {
            (_, Course::Drag { .. }) => (500, 0.003),
            (Site::Centre, _) => (500, 0.0035),
            (Site::Nodule, _) => (600, 0.006),
            (Site::Aside, _) => (500, 0.004),
            (Site::Askew, _) => (700, 0.004),
        };
        let (Course::Ramp { speed_mm_per_s, .. } | Course::Drag { speed_mm_per_s }) = self.course;
        let step_s = if speed_mm_per_s < 100 { 2e-3 } else { 1e-3 };
        Settings { corner_nodes, fine_radius_m: Some(fine_radius_m), step_s, ..Settings::default() }
    }

    /// Computes the truth; `progress` is called with the time [s] after every step.
    ///
    /// # Errors
    /// As [`super::compute`].
    pub fn compute(&self, settings: &Settings, progress: impl FnMut(f64)) -> Result<History, DynamicError> {
        compute_with(&self.scene()?, &self.motion(), settings, progress)
    }

    /// Table of a history of this truth.
    #[must_use]
    pub fn table(&self, history: &History) -> Table {
        Table::of(history, &self.motion(), self.spacing_s())
    }

    /// Reads the stored table.
    ///
    /// # Errors
    /// [`DynamicError::Table`].
    pub fn stored(&self) -> Result<Table, DynamicError> {
        Table::parse(self.name, self.text)
    }

    /// Lines that say how a table was computed.
    #[must_use]
    pub fn header(&self, settings: &Settings, history: &History) -> Vec<String> {
        let Settings { corner_nodes, step_s, first_step_share, step_growth, spectral_radius, softness, tolerance, .. } = settings;
        let fine_radius_m = settings.fine_radius_m.map_or("by default".to_owned(), |radius_m| radius_m.to_string());
        let scene = if self.site == Site::Nodule { "nodule" } else { "block" };
        vec![
            format!("version = {}, truth = {}", Table::VERSION, self.name),
            format!("scene = {scene}, site = {:?}, youngs_modulus_pa = {}", self.site, self.youngs_modulus_pa),
            format!("motion = {:?}", self.course),
            format!("corner_nodes = {corner_nodes}, fine_radius_m = {fine_radius_m}, quadratic_nodes = {}", history.nodes),
            format!("step_s = {step_s}, first_step_share = {first_step_share}, step_growth = {step_growth}"),
            format!("spectral_radius = {spectral_radius}, softness = {softness}, tolerance = {tolerance}"),
        ]
    }
}
