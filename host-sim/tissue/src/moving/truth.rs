//! The stored dynamic references (*truths*): their scenes, motions and tables.
//!
//! A table is a CSV file in `references/moving`: lines that begin with `#` say how it was computed,
//! one line names the columns, and the rows are in SI units at a fixed spacing in time. The example
//! `moving_truths` of `host-sim/lab` computes them.

use super::table::Table;
use crate::scene::{Scene, SceneError, TissueScene};
use crate::truth_error::TruthError;

/// Tissue and place of a stored reference.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Site {
    /// The preset block, pressed at its centre.
    Centre,
    /// The preset block, pressed 7.85 mm off its centre along x.
    Aside,
    /// The preset block, pressed at the same distance from its centre, but off its planes of
    /// symmetry.
    Askew,
    /// The preset nodule, pressed above the stiff ball.
    Nodule,
}

/// Motion of a stored reference.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Trajectory {
    /// Ramp to 4 mm, followed by a hold.
    Ramp {
        /// Speed of the ramp [mm/s].
        speed_mm_per_s: u32,
        /// Duration of the hold [ms].
        hold_ms: u32,
    },
    /// Ramp to 4 mm, 20 ms there, back to the rest surface at the same speed, and 20 ms there.
    Tap {
        /// Speed in both directions [mm/s].
        speed_mm_per_s: u32,
    },
    /// Two swings by 1.5 mm about a depth of 2.5 mm, after a ramp at 40 mm/s and 50 ms of rest.
    Swing {
        /// Frequency of the swings [Hz].
        frequency_hz: u32,
    },
    /// Drag of 12 mm at 3 mm depth, after a ramp at 40 mm/s and 50 ms of rest.
    Drag {
        /// Speed of the drag [mm/s].
        speed_mm_per_s: u32,
    },
}

impl Trajectory {
    /// Largest speed of the main part of the motion [mm/s], rounded down.
    #[must_use]
    pub fn speed_mm_per_s(self) -> u32 {
        match self {
            Self::Ramp { speed_mm_per_s, .. } | Self::Tap { speed_mm_per_s } | Self::Drag { speed_mm_per_s } => speed_mm_per_s,
            Self::Swing { frequency_hz } => (std::f64::consts::TAU * f64::from(frequency_hz) * Self::SWING_M[1] * 1e3) as u32,
        }
    }

    /// Name of the motion in a report.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Ramp { .. } => "stop",
            Self::Tap { .. } => "tap",
            Self::Swing { .. } => "swing",
            Self::Drag { .. } => "drag",
        }
    }

    /// Mean depth and amplitude of a swing [m].
    pub const SWING_M: [f64; 2] = [0.0025, 0.0015];
}

/// A stored dynamic reference.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Truth {
    /// Name of the reference, which is also that of its file.
    pub name: &'static str,
    /// Tissue and place of the press.
    pub site: Site,
    /// Young's modulus of the tissue [Pa].
    pub youngs_modulus_pa: f64,
    /// Motion of the probe.
    pub trajectory: Trajectory,
    /// Text of its CSV file.
    text: &'static str,
}

macro_rules! truth {
    ($name:literal, $site:ident, $kpa:literal, $trajectory:ident { $($field:ident: $value:literal),* }) => {
        Truth {
            name: $name,
            site: Site::$site,
            youngs_modulus_pa: $kpa * 1e3,
            trajectory: Trajectory::$trajectory { $($field: $value),* },
            text: include_str!(concat!("../../../references/moving/", $name, ".csv")),
        }
    };
}

/// All stored references.
pub const TRUTHS: [Truth; 29] = [
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
    truth!("tap-3.5kpa-200", Centre, 3.5, Tap { speed_mm_per_s: 200 }),
    truth!("swing-3.5kpa-10hz", Centre, 3.5, Swing { frequency_hz: 10 }),
    truth!("tap-20kpa-200", Centre, 20.0, Tap { speed_mm_per_s: 200 }),
    truth!("swing-20kpa-10hz", Centre, 20.0, Swing { frequency_hz: 10 }),
    truth!("tap-100kpa-200", Centre, 100.0, Tap { speed_mm_per_s: 200 }),
    truth!("swing-100kpa-10hz", Centre, 100.0, Swing { frequency_hz: 10 }),
    truth!("tap-aside-20kpa-100", Aside, 20.0, Tap { speed_mm_per_s: 100 }),
    truth!("drag-3.5kpa-60", Centre, 3.5, Drag { speed_mm_per_s: 60 }),
];

impl Truth {
    /// Finds a stored reference by its name.
    ///
    /// # Errors
    /// Fails with [`TruthError::Unknown`] if no stored reference has this name.
    pub fn named(name: &str) -> Result<Self, TruthError> {
        TRUTHS.into_iter().find(|truth| truth.name == name).ok_or_else(|| TruthError::Unknown { name: name.to_owned() })
    }

    /// Scene with the tissue and the place of the reference.
    ///
    /// # Errors
    /// Fails if the preset cannot be read.
    pub fn scene(&self) -> Result<Scene, SceneError> {
        let preset = if self.site == Site::Nodule { "nodule" } else { "block" };
        let mut scene = Scene::load(preset)?;
        scene.tissue.youngs_modulus_pa = self.youngs_modulus_pa;
        match self.site {
            Site::Aside => scene.probe.position_m = Some([0.00785, 0.0]),
            Site::Askew => scene.probe.position_m = Some([0.0073, 0.0029]),
            Site::Centre | Site::Nodule => {}
        }
        Ok(scene)
    }

    /// Whether a scene has the tissue, probe and place of this reference; its number of nodes and
    /// its drive do not matter.
    #[must_use]
    pub fn is_of(&self, scene: &Scene) -> bool {
        self.scene().is_ok_and(|own| {
            let place = |scene: &Scene| scene.probe.position_m.unwrap_or_default();
            let tissue = TissueScene { nodes: scene.tissue.nodes, ..own.tissue.clone() };
            tissue == scene.tissue
                && (own.probe.shape, own.probe.radius_m) == (scene.probe.shape, scene.probe.radius_m)
                && own.probe.tilt_deg == scene.probe.tilt_deg
                && place(&own) == place(scene)
        })
    }

    /// Reads the stored table of the reference.
    ///
    /// # Errors
    /// Fails with [`TruthError::Table`] if the stored table is invalid.
    pub fn stored(&self) -> Result<Table, TruthError> {
        Table::parse(self.name, self.text)
    }
}
