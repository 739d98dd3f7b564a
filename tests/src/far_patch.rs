//! Calibrated patches with a far field, fitted during the test, and the same patches in organs with
//! stiffer or softer inclusions.

use std::collections::BTreeMap;
use std::path::Path;
use std::sync::{Mutex, OnceLock, PoisonError};

use palpate::Params;
use palpate_fit::calibrate::{Calibration, Settings};
use palpate_fit::far_field::prepared::{Prepared, Recipe};
use palpate_fit::scene_fit::{Judging, Level, PIECE_JUDGED_RADII, PLACES, PiecePresses, Verdict};
use palpate_fit::solved::Solved;
use palpate_tissue::budget::MACHINES;
use palpate_tissue::scene::{Drive, Inclusion, Scene};
use palpate_tissue::session::Session;
use palpate_tissue::stable_step::limits;

use crate::bench::Bench;

/// Depth of the deepest press of the fit [m].
const DEEPEST_M: f64 = 0.008;

/// A patch of the default block, before and after its fit.
#[derive(Clone, Debug)]
pub struct FarPatch {
    scene: Scene,
    recipe: Recipe,
    /// The patch before the fit.
    pub prepared: Prepared,
    /// The patch after the fit.
    pub fitted: Calibration,
    /// Its errors.
    pub verdict: Verdict,
}

impl FarPatch {
    /// A patch of this radius [m] and element size [m] with a quick fit, which runs once per test
    /// program.
    ///
    /// # Panics
    /// Panics if the sizes do not fit the default block.
    pub fn quick(radius_m: f64, fine_m: f64) -> &'static Self {
        static FITTED: Mutex<BTreeMap<[u64; 2], &'static OnceLock<FarPatch>>> = Mutex::new(BTreeMap::new());
        let sizes = [radius_m, fine_m].map(f64::to_bits);
        let own =
            *FITTED.lock().unwrap_or_else(PoisonError::into_inner).entry(sizes).or_insert_with(|| Box::leak(Box::default()));
        own.get_or_init(|| Self::fit(radius_m, fine_m))
    }

    fn fit(radius_m: f64, fine_m: f64) -> Self {
        let mut scene = Scene::load("block").expect("a preset");
        let Drive::Depth { holds_m, .. } = &mut scene.drive else { panic!("the preset is pressed to a depth") };
        holds_m.push(DEEPEST_M);
        let recipe = Recipe::new(radius_m, fine_m, scene.probe.radius_m);
        let settings = Settings { places: 40, rounds: 8, ..Settings::default() };
        let prepared = Prepared::of(&scene, &recipe).expect("a patch of the block");
        // the answer for the default block is stored, so nothing is solved
        let solved = Solved::beside(Path::new("unused"));
        let presses =
            PiecePresses::of(&scene, &prepared.placed, (Level::Quick, true), &solved, |_, _| ()).expect("a stored answer");
        let fitted = presses.fit_piece(&prepared, &settings, &mut |_| ()).expect("a fit");
        let judging = Judging {
            known: presses.known.reference(),
            fitted_m: &presses.fitted_m,
            unseen: &presses.unseen,
            disc_radii: PIECE_JUDGED_RADII,
            places: PLACES,
            reference_error: presses.error,
        };
        let session = Session::of_fitted(&MACHINES[0], fitted.patch.clone(), fitted.params).expect("a patch that runs");
        let verdict = judging.judge(&session).expect("a reference of the whole disc");
        Self { scene, recipe, prepared, fitted, verdict }
    }

    /// The patch, ready to run to the depth `deep_m` [m], with the limits that follow from its
    /// elements.
    pub fn bench(&self, deep_m: f32) -> Bench {
        let mut patch = self.fitted.patch.clone();
        patch.set_depth_limit_m(deep_m);
        let params = Params { limits: limits(&patch, f64::from(self.fitted.params.tick_s)), ..self.fitted.params };
        Bench { patch, params }
    }

    /// Returns the patch, ready to run to the depth `deep_m` [m], in an organ with spherical
    /// inclusions, and that organ. Inside the patch the inclusions scale the fitted constants;
    /// outside it they change the target of its far field.
    ///
    /// # Panics
    /// Panics if the scene refuses the inclusions.
    pub fn with_balls(&self, balls: &[Inclusion], deep_m: f32) -> (Bench, Prepared) {
        let mut scene = self.scene.clone();
        scene.tissue.inclusion = balls.to_vec();
        let prepared = Prepared::of(&scene, &self.recipe).expect("the same block with balls in it");
        let mut bench = self.bench(deep_m);
        bench.patch = bench.patch.with_inclusions(balls);
        bench.patch.set_rim(&prepared.far.springs);
        (bench, prepared)
    }
}
