//! Accuracy of the force that inclusions add to a fitted patch.

use palpate_fit::scene_fit::BumpVerdict;
use serde::Serialize;

/// Errors of the force that inclusions add to a patch.
#[derive(Serialize)]
pub(super) struct BumpReport {
    /// Verdict on the fit of the plain block, in which the inclusions are scaled in.
    pub scaled_in: BumpVerdict,
    /// Verdict on the fitted patch.
    pub fitted: BumpVerdict,
    /// Estimated error of the finite elements' added force, relative to the highest [%].
    pub reference_error_pct: f64,
    /// Added force along the line, one entry per depth, the shallowest first.
    pub line: Vec<BumpLine>,
}

/// Force added along a line over the inclusions.
#[derive(Serialize)]
pub(super) struct BumpLine {
    pub depth_m: f64,
    /// Places along the line [m].
    pub x_m: Vec<f64>,
    /// Added force [N]: of the finite elements, of the fitted patch, and of the patch with the
    /// inclusions scaled in.
    pub finite_elements_n: Vec<f64>,
    pub fitted_n: Vec<f64>,
    pub scaled_in_n: Vec<f64>,
}

impl BumpReport {
    /// Prints the errors for every depth.
    pub(super) fn print(&self) {
        println!(
            "\nforce that the inclusions add, at {} places unknown to the fit, as a share of the highest",
            self.fitted.places
        );
        println!("{:>10} {:>16} {:>9} {:>9} {:>12}", "depth mm", "highest %force", "rms %", "worst %", "scaled in %");
        for (fitted, scaled_in) in self.fitted.depths.iter().zip(&self.scaled_in.depths) {
            println!(
                "{:>9.3}{} {:>+16.2} {:>9.2} {:>+9.2} {:>12.2}",
                fitted.depth_mm,
                if fitted.fitted_depth { ' ' } else { '*' },
                fitted.highest_pct,
                fitted.rms_pct,
                fitted.worst_pct,
                scaled_in.rms_pct
            );
        }
        println!(
            "all: {:.2} % rms, worst {:+.2} % (scaled in {:.2} and {:+.2} %); the finite elements' own within {:.1} %",
            self.fitted.rms_pct,
            self.fitted.worst_pct,
            self.scaled_in.rms_pct,
            self.scaled_in.worst_pct,
            self.reference_error_pct
        );
        if self.fitted.lost_presses > 0 {
            println!(
                "{} of {} presses could not be judged: the patch does not come to rest there",
                self.fitted.lost_presses, self.fitted.presses
            );
        }
    }
}
