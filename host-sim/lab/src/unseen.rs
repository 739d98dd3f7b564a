//! The stated error of fits of random scenes, against finite elements that no fit saw.
//!
//! ```text
//! drawn (a scene from a seed) ─┬─ fit ─ patch ─ judge ─ stated error
//! bodies (closed surfaces) ────┘           └── finite elements on another mesh ─ found error
//! ```
//!
//! The finite elements that judge have a finer mesh of their own, places of their own, and depths
//! between those of the fit.

mod bodies;
mod drawn;

use std::path::Path;

use palpate_fit::calibrate::Settings;
use palpate_fit::far_field::organ_reference::{PlaceForces, organ_reference};
use palpate_fit::far_field::prepared::{Prepared, Recipe};
use palpate_fit::far_field::whole::whole;
use palpate_fit::scene_fit::{Judging, Level, PIECE_JUDGED_RADII, PIECE_RADII, PLACES, PiecePresses, element_for};
use palpate_fit::solved::Solved;
use palpate_tissue::answer::{Answer, HoldAnswer};
use palpate_tissue::budget::MACHINES;
use palpate_tissue::error::Error;
use palpate_tissue::scene::Scene;
use palpate_tissue::session::Session;
use serde::{Deserialize, Serialize};

use drawn::Drawn;

/// Number of nodes of each patch.
const NODES: usize = 100;
/// Edge of the elements that judge, over that of the patch (1).
const FINER: f64 = 0.75;
/// Number of unseen places besides the site.
const UNSEEN_PLACES: usize = 3;
/// Unseen depths, as shares of the deepest press (1): the shallowest of the fit, and two between
/// those of the fit.
const UNSEEN_SHARES: [f64; 3] = [0.13, 0.33, 0.85];
/// Ratio of the found to the stated error beyond which a scene counts as far off (1).
const FAR: f64 = 1.5;

/// Effort of the fits.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Effort {
    /// Whether the fits are those of `fit --quick`.
    pub quick: bool,
}

/// One scene.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Row {
    /// Number of the scene.
    pub scene: u64,
    /// The scene in words.
    pub words: String,
    /// Number of nodes of the patch; zero if it was refused.
    pub nodes: usize,
    /// Stated errors, rms and at worst [%].
    pub stated_rms_pct: f64,
    /// Largest stated error [%].
    pub stated_worst_pct: f64,
    /// Errors against the unseen finite elements, rms [%].
    pub found_rms_pct: f64,
    /// Largest of these errors, with its sign [%].
    pub found_worst_pct: f64,
    /// Depth of that press [mm].
    pub worst_mm: f64,
    /// Largest difference of the fit's own finite elements from the unseen ones, with its sign [%].
    pub elements_pct: f64,
    /// Reason for which the scene has no patch; empty if it has one.
    pub refused: String,
}

impl Row {
    /// Whether the scene has a patch.
    pub fn is_fitted(&self) -> bool {
        self.refused.is_empty()
    }

    /// Whether no unseen press is further off than the stated worst.
    pub fn holds(&self) -> bool {
        self.found_worst_pct.abs() <= self.stated_worst_pct.abs()
    }

    /// Whether some unseen press is more than half further off than the stated worst.
    pub fn is_far(&self) -> bool {
        self.found_worst_pct.abs() > FAR * self.stated_worst_pct.abs()
    }
}

/// Draws a scene, fits it in `folder`, and judges its patch. A scene that the fit refuses is a row
/// with the reason.
pub fn run(number: u64, seed: u64, effort: Effort, folder: &Path) -> Result<Row, Error> {
    let drawn = Drawn::draw(number, seed);
    let scene = drawn.scene(folder)?;
    let refused = |cause: Error| Row { refused: cause.to_string(), ..Row::default() };
    let row = fitted(&scene, &drawn, effort, folder).unwrap_or_else(refused);
    Ok(Row { scene: number, words: drawn.words(), ..row })
}

/// The errors of a scene, in a row without its number and words.
fn fitted(scene: &Scene, drawn: &Drawn, effort: Effort, folder: &Path) -> Result<Row, Error> {
    let radius_m = PIECE_RADII * scene.probe.radius_m;
    let recipe = Recipe::new(radius_m, element_for(scene, radius_m, NODES)?, scene.probe.radius_m);
    let prepared = Prepared::of(scene, &recipe)?;
    let level = if effort.quick { Level::Quick } else { Level::Full };
    let solved = Solved::beside(&folder.join("solved"));
    let presses = PiecePresses::of(scene, &prepared.placed, (level, false), &solved, |_, _| ())?;
    let (places, rounds) = if effort.quick { (80, 3) } else { (250, 10) };
    let settings = Settings { places, rounds, least_gain: 0.005 };
    let fit = presses.fit_piece(&prepared, &settings, &mut |_| ())?;
    let session = Session::of_fitted(&MACHINES[0], fit.patch, fit.params)?;
    let judging = Judging {
        known: presses.known.reference(),
        fitted_m: &presses.fitted_m,
        unseen: &presses.unseen,
        disc_radii: PIECE_JUDGED_RADII,
        places: PLACES,
        reference_error: presses.error,
    };
    let stated = judging.judge(&session)?;
    let sizes = palpate_fit::far_field::Sizes { fine_m: FINER * recipe.sizes.fine_m, ..recipe.sizes };
    let placed = whole(scene, &[], &sizes)?;
    let mut offsets_m = vec![[0.0; 2]];
    offsets_m.extend(drawn.places_m(UNSEEN_PLACES, PIECE_JUDGED_RADII * scene.probe.radius_m));
    let deepest_m = drawn.deepest_m;
    let truth = organ_reference(scene, &placed, &offsets_m, &UNSEEN_SHARES.map(|share| share * deepest_m), None, |_, _| ())?;
    let mut row = Row {
        nodes: session.report.nodes,
        stated_rms_pct: stated.rms_pct(),
        stated_worst_pct: stated.worst_pct(),
        ..Row::default()
    };
    for (d, depth_m) in truth.depths_m.iter().enumerate() {
        let hold = |place: &PlaceForces| {
            let place_m = std::array::from_fn(|k| place.place_m[k] - placed.tissue.site_m[k]);
            HoldAnswer { place_m, depth_m: *depth_m, force_over_e_m2: place.force_over_e_m2[d], surface: None }
        };
        let holds: Vec<HoldAnswer> = truth.places.iter().map(hold).collect();
        for hold in &holds {
            if let Some(own_m2) = judging.known.force(hold.place_m.into(), *depth_m) {
                row.elements_pct = larger(row.elements_pct, 100.0 * (own_m2 / hold.force_over_e_m2 - 1.0));
            }
        }
        let unseen = Answer { holds, glued: Vec::new(), ..presses.unseen.clone() };
        let found = Judging { fitted_m: &[], unseen: &unseen, places: 0, reference_error: 0.0, ..judging }.judge(&session)?;
        row.found_rms_pct += found.unseen_rms_pct.powi(2) / truth.depths_m.len() as f64;
        if found.unseen_worst_pct.abs() > row.found_worst_pct.abs() {
            (row.found_worst_pct, row.worst_mm) = (found.unseen_worst_pct, depth_m * 1e3);
        }
    }
    row.found_rms_pct = row.found_rms_pct.sqrt();
    Ok(row)
}

/// The larger of two signed numbers.
fn larger(a: f64, b: f64) -> f64 {
    if b.abs() > a.abs() { b } else { a }
}
