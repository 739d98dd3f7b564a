//! Patches for a board: their cost, the elements that fit, and the mass floor that it accepts.

use palpate::{BuildError, Params};
use palpate_board::live_trace;
use palpate_controller::link::Refusal;
use palpate_controller::patch::step;
use palpate_fit::far_field::prepared::{Prepared, Recipe};
use palpate_tissue::Error as TissueError;
use palpate_tissue::budget::{CostModel, triangles_in_reach};
use palpate_tissue::patch::Patch;
use palpate_tissue::scene::Scene;
use palpate_tissue::session::Session;
use serde::{Deserialize, Serialize};

use super::super::boards;
use crate::error::Error;

/// Element sizes between which the smallest that fits is searched, if none is given [probe radii].
const ELEMENTS_RADII: [f64; 2] = [0.3, 0.9];
/// Number of halvings of this range, which leave a few tenths of a millimetre.
const HALVINGS: usize = 5;
/// Largest factor by which the mass floor of a fitted patch is raised, and smallest factor of one
/// step (1).
const MOST_FLOOR_RAISE: f32 = 2.0;
const FLOOR_STEP: f32 = 1.05;

/// Estimated cost of a tick on a board.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct Load {
    pub board: String,
    /// Number of substeps per tick.
    pub substeps: u16,
    /// Cost of a tick, and the largest allowed one, in `unit`.
    pub units: f64,
    pub budget: f64,
    pub unit: String,
}

impl Load {
    /// Cost of a tick with the scene's relaxation and friction, which the fit does not include.
    pub(super) fn of(patch: &Patch, scene: &Scene, machine: &CostModel, substeps: u16) -> Self {
        let model = patch.model();
        let touched = triangles_in_reach(&model, patch.site_m().into(), scene.probe.tip().reach_m() as f32);
        let cost = machine.cost_with(&model, &scene.params([0.0, 0.0, 1.0]), touched, substeps);
        let (board, unit) = (machine.name.to_owned(), machine.unit.to_owned());
        Self { board, substeps, units: cost.units, budget: cost.budget, unit }
    }

    /// Refuses a tick that is too expensive, of a patch with this number of nodes.
    pub(super) fn check(self, nodes: usize) -> Result<Self, Error> {
        let Self { board, units, budget, unit, .. } = &self;
        if units <= budget {
            return Ok(self);
        }
        Err(Error::Tissue(TissueError::TooSlow(format!(
            "{nodes} nodes take about {units:.0} {unit} a tick, {budget:.0} fit on {board}: take a larger --element, a smaller --radius or a faster board"
        ))))
    }

    pub(super) fn print(&self) {
        println!(
            "about {:.0} of at most {:.0} {} per tick on {} (estimate), {} substep(s) in a tick of 1 ms",
            self.units, self.budget, self.unit, self.board, self.substeps
        );
    }

    /// Cost of a tick as a share of the largest allowed one [%].
    pub(super) fn pct(&self) -> f64 {
        100.0 * self.units / self.budget
    }
}

/// Finds the smallest element with which a patch fits the machine in one substep [m].
pub(super) fn smallest_element(scene: &Scene, machine: &CostModel, recipe: &impl Fn(f64) -> Recipe) -> Result<f64, Error> {
    let fits = |fine_m: f64| {
        let patch = Prepared::of(scene, &recipe(fine_m))?.patch();
        Load::of(&patch, scene, machine, 1).check(patch.model().nodes.len()).map(drop)
    };
    let [mut small, mut large] = ELEMENTS_RADII.map(|r| r * scene.probe.radius_m);
    fits(large)?;
    for _ in 0..HALVINGS {
        let middle = 0.5 * (small + large);
        if fits(middle).is_ok() { large = middle } else { small = middle }
    }
    Ok(large)
}

/// Prepares a session of a fitted patch with a mass floor that a board accepts: the fit's
/// multipliers make nodes stiffer, and the masses of the floor may then be too light for one step
/// of 1 ms. Held forces do not depend on masses.
pub(super) fn on_board(patch: &Patch, mut params: Params, machine: &CostModel) -> Result<Session, Error> {
    let most = MOST_FLOOR_RAISE * params.mass_floor;
    loop {
        let session = Session::of_fitted(machine, patch.clone(), params)?;
        if !machine.is_board() || session.params.mass_floor >= most {
            return Ok(session);
        }
        let raise = match live_trace::fits(&packed(&session)) {
            Err(BuildError::OutOfRange { parameter: step::FLOOR, value, min, .. }) if value > 0.0 => min / value,
            _ if session.params.substeps > 1 => 1.0,
            _ => return Ok(session),
        };
        params.mass_floor = (params.mass_floor * raise.max(FLOOR_STEP)).min(most);
    }
}

/// The session as it is, or with a larger mass floor, if the machine accepts its patch.
pub(super) fn accepted(session: &Session, scene: &Scene, machine: &CostModel) -> Option<Session> {
    let accepts = |session: &Session| !machine.is_board() || live_trace::fits(&packed(session)).is_ok();
    if accepts(session) {
        return Some(session.clone());
    }
    let raised = on_board(&session.patch, session.params, machine).ok()?;
    raised.for_motion_as(machine, scene, accepts).ok().flatten()
}

fn packed(session: &Session) -> Vec<u8> {
    session.patch.pack(&session.params, session.stable.pressed_s as f32)
}

/// Name and bytes of the patch file of a session.
pub(super) fn file(
    session: &Session,
    scene: &Scene,
    machine: &CostModel,
    ceiling_n_per_m: f32,
) -> Result<(String, Vec<u8>), Error> {
    let (name, bytes) = (format!("{}-{}.patch", scene.name, machine.name), packed(session));
    if machine.is_board() {
        boards::refuse_points(&session.patch.model(), machine.name)?;
        boards::refuse_contact(&name, boards::contact_refusal(&bytes, ceiling_n_per_m))?;
        live_trace::fits(&bytes).map_err(|cause| {
            let why = Refusal::from(cause);
            TissueError::Check(format!("{name}: {why}; nothing is written, and smaller or larger elements may pass"))
        })?;
    }
    Ok((name, bytes))
}

#[cfg(test)]
mod tests {
    use palpate_tissue::session::calibrated;

    use super::*;

    #[test]
    fn relaxation_and_friction_of_the_scene_are_counted() {
        let patch = calibrated::sized(130).unwrap().0;
        let machine = CostModel::named("m4f-168").unwrap();
        let of = |name: &str, friction: f64| {
            let mut scene = Scene::load(name).unwrap();
            scene.probe.friction = friction;
            Load::of(&patch, &scene, machine, 1).units
        };
        let [plain, relaxes, both] = [("block", 0.0), ("beef", 0.0), ("beef", 0.5)].map(|(name, friction)| of(name, friction));
        assert!(relaxes > plain + 1e4 && both > relaxes + 1e3, "{plain}, {relaxes}, {both}");
    }

    #[test]
    fn a_floor_that_is_too_light_for_a_board_is_raised() {
        let (patch, mut params) = calibrated::sized(130).unwrap();
        let machine = CostModel::named("m7-480").unwrap();
        let opened = |session: &Session| live_trace::fits(&packed(session)).map_err(Refusal::from);
        let kept = on_board(&patch, params, machine).unwrap();
        assert_eq!((kept.params.mass_floor, opened(&kept)), (params.mass_floor, Ok(())));
        params.mass_floor *= 0.5;
        let light = Session::of_fitted(machine, patch.clone(), params).unwrap();
        assert_eq!(opened(&light), Err(Refusal::PatchStep));
        let raised = on_board(&patch, params, machine).unwrap();
        assert!(raised.params.mass_floor > params.mass_floor && opened(&raised) == Ok(()), "{}", raised.params.mass_floor);
    }

    #[test]
    fn no_file_is_made_for_a_board_that_refuses_it() {
        let scene = Scene::load("block").unwrap();
        let (patch, params) = calibrated::sized(130).unwrap();
        let mut session = Session::of_fitted(CostModel::named("desktop").unwrap(), patch, params).unwrap();
        session.params.mass_floor = 0.1;
        let of = |board: &str| file(&session, &scene, CostModel::named(board).unwrap(), f32::MAX);
        assert_eq!(of("desktop").unwrap().0, "block-desktop.patch");
        let refused = of("m7-480").unwrap_err().to_string();
        assert!(refused.contains("more substeps or a larger mass floor; nothing is written"), "{refused}");
    }

    #[test]
    fn a_patch_that_its_board_refuses_gets_a_larger_mass_floor_or_is_no_model() {
        let scene = Scene::load("block").unwrap();
        let machine = CostModel::named("m7-480").unwrap();
        let of = |share: f32| {
            let (patch, mut params) = calibrated::sized(130).unwrap();
            params.mass_floor *= share;
            let session = Session::of_fitted(machine, patch, params).unwrap();
            accepted(&session, &scene, machine).map(|kept| kept.params.mass_floor / session.params.mass_floor)
        };
        assert_eq!(of(1.0), Some(1.0));
        assert!(of(0.5).is_some_and(|raised| raised > 1.0));
        assert_eq!(of(0.02), None);
    }
}
