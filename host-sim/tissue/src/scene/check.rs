//! Checks of values that the types do not limit, made before anything is built or written.

use palpate::{BuildError, GuardLimits, Vector3};

use super::{Drive, Scene, SceneError};

/// Smallest and largest side of a block [m]: a value outside means a wrong unit. A mesh file has
/// the same range.
const SIDE_M: std::ops::RangeInclusive<f64> = 1e-3..=2.0;
/// Smallest and largest number of nodes for the mesh of an organ or a surface file.
/// Numbers of nodes that a scene may ask for of an organ or a surface.
pub const ORGAN_NODES: std::ops::RangeInclusive<usize> = 100..=5000;
/// Smallest and largest Young's modulus [Pa], long-term or of an organ's region.
pub(super) const MODULUS_PA: std::ops::RangeInclusive<f64> = 1.0..=1e9;
/// Smallest and largest stiffening exponent of a region or a ball (1).
const STIFFENING: std::ops::RangeInclusive<f64> = 0.0..=100.0;
/// Cosine between the long side of a tip and the axis of the press above which the long side does
/// not lie on the surface.
const STEEP: f64 = 0.5;
/// Largest angle of a tilt [degrees]: presence in the core takes a steeper surface for a wall.
const MOST_TILT_DEG: f64 = 45.0;
/// Rounding error of that angle [degrees].
const ROUNDING_DEG: f64 = 1e-9;
/// Extensions of surface files.
const SURFACES: [&str; 2] = ["stl", "obj"];
/// Young's modulus [Pa] below which the unit is probably wrong: no organ is softer.
const SOFTEST_PA: f64 = 100.0;
/// Densities outside which the unit is probably wrong [kg/m^3]: lung has 260, bone 1900.
const DENSITY_KG_PER_M3: std::ops::RangeInclusive<f64> = 100.0..=5000.0;
/// Width of a probe, as a share of a block's narrower side, above which a unit is probably wrong
/// (1).
const WIDEST_SHARE: f64 = 1.0 / 3.0;
/// Longest run, in simulated time [s].
const LONGEST_S: f64 = 1000.0;

impl Scene {
    /// Checks every value that the types do not limit.
    ///
    /// # Errors
    /// Returns the first value outside its range, with its key.
    pub fn check(&self) -> Result<(), SceneError> {
        self.check_name()?;
        self.check_source()?;
        self.check_block()?;
        self.check_inclusions()?;
        self.check_relaxation()?;
        let up = self.check_along()?;
        self.check_tilt()?;
        self.params(up).check().map_err(|cause| SceneError::parameter(&self.file, cause))?;
        self.check_solver()?;
        self.check_drive()
    }

    /// Warnings about values that are allowed but probably in a wrong unit, one line each.
    #[must_use]
    pub fn warnings(&self) -> Vec<String> {
        let mut warnings = Vec::new();
        let e = self.tissue.youngs_modulus_pa;
        if e < SOFTEST_PA {
            let meant = e * 1e3;
            warnings.push(format!(
                "a Young's modulus of {e} Pa is softer than any organ: keys ending in _pa take pascals, {e} kPa is {meant}"
            ));
        }
        let density = self.tissue.density_kg_per_m3;
        if !DENSITY_KG_PER_M3.contains(&density) {
            warnings.push(format!(
                "no tissue has a density of {density} kg/m^3: density_kg_per_m3 takes kilograms per cubic metre, 1.06 g/cm^3 is 1060"
            ));
        }
        let width_m = 2.0 * self.probe.radius_m;
        let side_m = self.tissue.block_m.map_or(f64::INFINITY, |[x, y, _]| x.min(y));
        if width_m > WIDEST_SHARE * side_m {
            warnings.push(format!(
                "the probe is {:.1} mm wide, the block {:.1} mm: its sides are felt, and the force is not that of a wide tissue; radius_m is half the width, in metres",
                width_m * 1e3,
                side_m * 1e3
            ));
        }
        warnings
    }

    /// Returns an error about the value of a key.
    pub fn bad<T>(&self, key: &str, why: &str) -> Result<T, SceneError> {
        Err(SceneError::value(&self.file, key, why))
    }

    /// Refuses holds deeper than `most_m`; `because` ends the message after "is deeper than".
    pub fn refuse_deeper_than(&self, most_m: f64, because: &str) -> Result<(), SceneError> {
        let (Drive::Depth { holds_m, .. } | Drive::Hand { holds_m, .. }) = &self.drive else { return Ok(()) };
        // a limit from a patch file is rounded to single precision
        match holds_m.iter().position(|h| *h > most_m * (1.0 + f64::from(f32::EPSILON))) {
            None => Ok(()),
            Some(n) => {
                let why = format!("= {} is deeper than {because} ({most_m:.4} m): press less deep", holds_m[n]);
                self.bad(&format!("drive.holds_m[{n}]"), &why)
            }
        }
    }

    /// Checks the name, which is printed in tables and is part of file names.
    fn check_name(&self) -> Result<(), SceneError> {
        if self.name.is_empty() || self.name.contains(|c: char| c.is_control() || c == '/' || c == '\\') {
            return self.bad("name", "must be one line of text without slashes, it becomes part of file names: rename the scene");
        }
        Ok(())
    }

    /// Refuses a tilted tip, for what works on an upright one: `why` says where and why.
    ///
    /// # Errors
    /// The tilt is not zero.
    pub fn refuse_tilt(&self, why: &str) -> Result<(), SceneError> {
        if self.probe.tilt_deg == [0.0; 3] {
            return Ok(());
        }
        self.bad("probe.tilt_deg", &format!("= {:?}: {why}", self.probe.tilt_deg))
    }

    /// Refuses what no patch file holds, for commands that write one.
    ///
    /// # Errors
    /// The tip is tilted.
    pub fn refuse_what_no_file_has(&self) -> Result<(), SceneError> {
        self.refuse_tilt("a patch is made for an upright tip and serves any tilt: set [0, 0, 0] here, and give the tilt to press")
    }

    /// Refuses the terms that no board's image contains: tissue that stiffens, a capsule or an
    /// ellipsoid, a tilted tip.
    ///
    /// # Errors
    /// A stiffening exponent is above zero, or the tip is a capsule or an ellipsoid, or tilted.
    pub fn refuse_what_boards_lack(&self, board: &str) -> Result<(), SceneError> {
        if !self.probe.shape.is_round() {
            let why = format!(
                "= {}: the image of {board} has no room for it: take \"hemisphere\", \"sphere\" or \"flat\", or --board desktop",
                self.probe.tip()
            );
            return self.bad("probe.shape", &why);
        }
        self.refuse_tilt(&format!("a tip cannot tilt on {board}: leave it out, or press on the desktop"))?;
        let (key, b) = self.tissue.most_stiffening();
        if b == 0.0 {
            return Ok(());
        }
        let why = format!("= {b}: {board} has no time for tissue that stiffens: leave it out, or take --board desktop");
        self.bad(&key, &why)
    }

    /// Refuses what only nodes can answer, where a law answers; `why` names the law.
    ///
    /// # Errors
    /// The probe is tilted or has friction, or the tissue has weight, a nodule, or parts that
    /// stiffen more than the rest.
    pub fn refuse_what_a_law_lacks(&self, why: &str) -> Result<(), SceneError> {
        let (key, what) = match () {
            () if self.probe.tilt_deg != [0.0; 3] => ("probe.tilt_deg", "a tilted tip, which presses nodes"),
            () if self.probe.friction > 0.0 => ("probe.friction", "friction, which slides over nodes"),
            () if self.tissue.most_stiffening_b() > self.tissue.stiffening_b => {
                ("tissue", "parts that stiffen more, which nodes do")
            }
            () if self.tissue.gravity_m_per_s2 != [0.0; 3] => ("tissue.gravity_m_per_s2", "weight, which nodes carry"),
            () if !self.tissue.inclusion.is_empty() => ("tissue.inclusion", "a nodule of its own, which nodes feel"),
            () => return Ok(()),
        };
        self.bad(key, &format!("asks for {what}, but {why}: leave it out, or fit a patch with `palpate fit` without --law"))
    }

    /// Checks the direction of a capsule or an ellipsoid. Returns an axis of the press for the
    /// core's checks: that of a block, or, where the surface decides, one that the long side is not
    /// along.
    fn check_along(&self) -> Result<[f64; 3], SceneError> {
        let (x, up) = ([1.0, 0.0, 0.0], [0.0, 0.0, 1.0]);
        let Some(along) = self.probe.shape.along() else { return Ok(up) };
        let key = "probe.along";
        let length = along.iter().map(|c| c * c).sum::<f64>().sqrt();
        if !(length.is_finite() && length > 0.0) {
            return self.bad(key, &format!("= {along:?} has no direction: give the way of the long side, as [1.0, 0.0, 0.0]"));
        }
        let steep = along[2].abs() > STEEP * length;
        match (steep, self.tissue.block_m.is_some()) {
            (true, true) => {
                let why = format!("= {along:?} points out of the block's top: lay the long side on it, as [1.0, 0.0, 0.0]");
                self.bad(key, &why)
            }
            (true, false) => Ok(x),
            (false, _) => Ok(up),
        }
    }

    /// Checks the angle of the tilt as it is given: 400 degrees are a mistake, not 40.
    fn check_tilt(&self) -> Result<(), SceneError> {
        let (key, tilt) = ("probe.tilt_deg", self.probe.tilt_deg);
        if let Some(n) = tilt.iter().position(|part| !part.is_finite()) {
            let why = format!("= {} is not a number of degrees: give one, as in [0.0, 15.0, 0.0]", tilt[n]);
            return self.bad(&format!("{key}[{n}]"), &why);
        }
        let degrees = Vector3::from(tilt).norm();
        if degrees > MOST_TILT_DEG + ROUNDING_DEG {
            let why =
                format!("= {tilt:?} tilts the tip by {degrees:.1} degrees: give at most {MOST_TILT_DEG}, as [0.0, 15.0, 0.0]");
            return self.bad(key, &why);
        }
        Ok(())
    }

    /// Checks the bound on the moving error.
    fn check_solver(&self) -> Result<(), SceneError> {
        match self.solver.moving_error_pct {
            Some(pct) if !(pct > 0.0 && pct <= 100.0) => {
                let why = format!("= {pct}: give a percentage above 0, at most 100");
                self.bad("solver.moving_error_pct", &why)
            }
            _ => Ok(()),
        }
    }

    /// Checks that the scene has one source of tissue, and only keys that belong to it.
    fn check_source(&self) -> Result<(), SceneError> {
        let (tissue, probe) = (&self.tissue, &self.probe);
        match (tissue.block_m.is_some(), tissue.mesh.is_some(), tissue.organ.is_some()) {
            (false, false, false) if self.solver.patch.is_none() => {
                return self.bad("tissue", "has neither block_m nor mesh nor organ: give one");
            }
            (true, true, _) => return self.bad("tissue", "has both block_m and mesh: keep one"),
            (true, _, true) => return self.bad("tissue", "has both block_m and organ: keep one"),
            (_, true, true) => return self.bad("tissue", "has both mesh and organ: keep one"),
            _ => {}
        }
        if tissue.up.is_some() && tissue.mesh.is_none() {
            return self.bad("tissue.up", "turns a mesh file: remove it");
        }
        if tissue.organ.is_some() {
            return self.check_organ();
        }
        if !tissue.region.is_empty() {
            return self.bad("tissue.region", "belongs to an organ: remove it");
        }
        if tissue.mesh.is_none() {
            if tissue.length_unit.is_some() {
                return self.bad("tissue.length_unit", "belongs to a mesh file; block_m is in metres: remove it");
            }
            if probe.site.is_some() {
                return self.bad("probe.site", "belongs to a mesh or an organ; a block has position_m = [x, y]: use that");
            }
            return Ok(());
        }
        if tissue.length_unit.is_none() {
            return self.bad(
                "tissue.length_unit",
                "is missing: say \"m\", \"cm\", \"mm\", \"um\" or the number of metres of one unit of the mesh file",
            );
        }
        let is_surface = |path: &std::path::PathBuf| {
            path.extension().is_some_and(|e| SURFACES.iter().any(|surface| e.eq_ignore_ascii_case(surface)))
        };
        if tissue.mesh.as_ref().is_some_and(is_surface) {
            self.check_nodes()?;
        } else if tissue.nodes.is_some() {
            return self.refuse_nodes();
        }
        self.check_site("a mesh")
    }

    /// Refuses a number of nodes for a mesh file of tets, which has its own nodes.
    pub(crate) fn refuse_nodes<T>(&self) -> Result<T, SceneError> {
        self.bad(
            "tissue.nodes",
            "belongs to a block, an organ or a surface (.stl, .obj); a mesh file has its own nodes: remove it",
        )
    }

    fn check_nodes(&self) -> Result<(), SceneError> {
        if let Some(nodes) = self.tissue.nodes.filter(|n| !ORGAN_NODES.contains(n)) {
            let why = format!("= {nodes}: give a number from {} to {}", ORGAN_NODES.start(), ORGAN_NODES.end());
            return self.bad("tissue.nodes", &why);
        }
        Ok(())
    }

    /// Checks the keys of an organ and its regions.
    fn check_organ(&self) -> Result<(), SceneError> {
        let tissue = &self.tissue;
        if tissue.length_unit.is_some() {
            return self.bad("tissue.length_unit", "belongs to a mesh file; organs are in metres: remove it");
        }
        self.check_nodes()?;
        for (n, region) in tissue.region.iter().enumerate() {
            self.check_exponent(&format!("tissue.region[{n}]"), region.stiffening_b)?;
            let e = region.youngs_modulus_pa;
            if !MODULUS_PA.contains(&e) {
                let why = format!("= {e} is out of range: give {} .. {}", MODULUS_PA.start(), MODULUS_PA.end());
                return self.bad(&format!("tissue.region[{n}].youngs_modulus_pa"), &why);
            }
        }
        self.check_site("an organ")
    }

    /// Checks the place of the press; `what` names the tissue in the message.
    fn check_site(&self, what: &str) -> Result<(), SceneError> {
        if self.probe.position_m.is_some() {
            return self.bad("probe.position_m", &format!("belongs to a block; {what} has site = [x, y, z]: use that"));
        }
        match self.probe.site {
            None => self.bad("probe.site", &format!("is missing: {what} needs the place to press, site = [x, y, z] in metres")),
            Some(site) if !site.iter().all(|c| c.is_finite()) => {
                self.bad("probe.site", &format!("= {site:?} is not finite: give x, y, z in metres"))
            }
            Some(_) => Ok(()),
        }
    }

    fn check_block(&self) -> Result<(), SceneError> {
        let Some(block_m) = self.tissue.block_m else { return Ok(()) };
        for (axis, side) in block_m.iter().enumerate() {
            if !SIDE_M.contains(side) {
                let why = format!("= {side} must be from {} to {}: give metres", SIDE_M.start(), SIDE_M.end());
                return self.bad(&format!("tissue.block_m[{axis}]"), &why);
            }
        }
        for (axis, place) in self.probe.position_m.iter().flatten().enumerate() {
            let half = 0.5 * block_m[axis];
            if place.is_nan() || place.abs() > half {
                let why = format!("= {place} is outside the block's top: stay within -{half} .. {half}");
                return self.bad(&format!("probe.position_m[{axis}]"), &why);
            }
        }
        Ok(())
    }

    fn check_inclusions(&self) -> Result<(), SceneError> {
        for (n, ball) in self.tissue.inclusion.iter().enumerate() {
            for (key, value) in [("radius_m", ball.radius_m), ("stiffness_ratio", ball.stiffness_ratio)] {
                if !(value.is_finite() && value > 0.0) {
                    return self
                        .bad(&format!("tissue.inclusion[{n}].{key}"), &format!("= {value} must be above zero and finite"));
                }
            }
            self.check_exponent(&format!("tissue.inclusion[{n}]"), ball.stiffening_b)?;
            if !ball.center_m.iter().all(|c| c.is_finite()) {
                let why = format!("= {:?} is not finite: give x, y, z in metres", ball.center_m);
                return self.bad(&format!("tissue.inclusion[{n}].center_m"), &why);
            }
            let Some([x, y, z]) = self.tissue.block_m else { continue };
            let off = |at: f64, low: f64, high: f64| (low - at).max(at - high).max(0.0);
            let [a, b, c] = ball.center_m;
            let away = [off(a, -0.5 * x, 0.5 * x), off(b, -0.5 * y, 0.5 * y), off(c, -z, 0.0)];
            if away.iter().map(|d| d * d).sum::<f64>() >= ball.radius_m * ball.radius_m {
                let why = format!(
                    "= {:?}: the ball lies outside the block: give metres, x within +-{}, y within +-{}, z from -{z} (bottom) to 0 (top)",
                    ball.center_m,
                    0.5 * x,
                    0.5 * y
                );
                return self.bad(&format!("tissue.inclusion[{n}].center_m"), &why);
            }
            let farthest = [a.abs() + 0.5 * x, b.abs() + 0.5 * y, c.abs().max((c + z).abs())];
            if farthest.iter().map(|d| d * d).sum::<f64>() <= ball.radius_m * ball.radius_m {
                return self.refuse_all_inclusion(n);
            }
        }
        Ok(())
    }

    /// Refuses an inclusion that contains the whole tissue.
    ///
    /// # Errors
    /// In every case.
    pub(crate) fn refuse_all_inclusion(&self, n: usize) -> Result<(), SceneError> {
        let radius_m = self.tissue.inclusion.get(n).map_or(f64::NAN, |ball| ball.radius_m);
        let why = format!(
            "= {radius_m}: the ball holds the whole tissue: give metres ({radius_m} mm is {}), or change youngs_modulus_pa",
            radius_m / 1e3
        );
        self.bad(&format!("tissue.inclusion[{n}].radius_m"), &why)
    }

    /// Refuses a stiffening exponent of a region or a ball that is out of range.
    fn check_exponent(&self, table: &str, b: Option<f64>) -> Result<(), SceneError> {
        match b {
            Some(b) if !STIFFENING.contains(&b) => {
                let why = format!("= {b} must be from {} to {}", STIFFENING.start(), STIFFENING.end());
                self.bad(&format!("{table}.stiffening_b"), &why)
            }
            _ => Ok(()),
        }
    }

    fn check_drive(&self) -> Result<(), SceneError> {
        let (key, ramp, hold_s) = match self.drive {
            Drive::Depth { ramp_m_per_s, hold_s, .. } | Drive::Hand { ramp_m_per_s, hold_s, .. } => {
                ("drive.holds_m", ramp_m_per_s, hold_s)
            }
            Drive::Force { ramp_m_per_s, hold_s, .. } => ("drive.holds_n", ramp_m_per_s, hold_s),
            Drive::Trace { depth_limit_m: Some(limit_m), .. } if !(limit_m.is_finite() && limit_m > 0.0) => {
                let why = format!("= {limit_m} must be above zero and finite");
                return self.bad("drive.depth_limit_m", &why);
            }
            Drive::Trace { .. } => return Ok(()),
        };
        let holds = self.drive.targets();
        if holds.is_empty() {
            return self.bad(key, "is empty: give at least one");
        }
        for (n, target) in holds.iter().enumerate() {
            if !(target.is_finite() && *target > 0.0) {
                return self.bad(&format!("{key}[{n}]"), &format!("= {target} must be above zero and finite"));
            }
            let most_n = f64::from(GuardLimits::HIGHEST.max_force_n);
            if matches!(self.drive, Drive::Force { .. }) && *target > most_n {
                return self
                    .bad(&format!("{key}[{n}]"), &format!("= {target} must be at most {most_n}: no larger force is rendered"));
            }
        }
        let fastest = f64::from(GuardLimits::HIGHEST.max_speed_m_per_s);
        if !(ramp > 0.0 && ramp <= fastest) {
            return self.bad("drive.ramp_m_per_s", &format!("= {ramp} must be above zero and at most {fastest}"));
        }
        if !((0.001..=60.0).contains(&hold_s)) {
            return self.bad("drive.hold_s", &format!("= {hold_s} must be from 0.001 to 60"));
        }
        // the path of a force drive is not known; its retreat is taken as one probe radius long
        let displacement_m = match &self.drive {
            Drive::Force { .. } => self.probe.radius_m,
            _ => holds.iter().fold((0.0, 0.0), |(sum, from): (f64, f64), to| (sum + (to - from).abs(), *to)).0,
        };
        let run_s = displacement_m / ramp + holds.len() as f64 * hold_s;
        if run_s > LONGEST_S {
            let why =
                format!("makes a run of {run_s:.0} s, at most {LONGEST_S} fit: ramp faster, hold shorter or hold less often");
            return self.bad("drive", &why);
        }
        Ok(())
    }
}

impl SceneError {
    /// An error for a parameter that the core refuses, named by its key in the scene.
    pub(crate) fn parameter(file: &str, cause: BuildError) -> Self {
        let table = match cause {
            BuildError::OutOfRange { parameter, .. } if parameter.starts_with("probe.") => "",
            BuildError::OutOfRange { parameter: "friction", .. } => "probe.",
            _ => "tissue.",
        };
        Self::Parameter { file: file.into(), table, cause }
    }
}
