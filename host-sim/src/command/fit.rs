//! `palpate fit`: from a scene to a calibrated patch with a measured error.

mod added_force;
mod block;
mod board;
mod bump;
mod law;
mod piece;
mod report;
mod scenes;
mod search_report;
mod smallest;
mod stages;
mod store;
mod worth;

use self::board::Load;
pub(super) use self::scenes::FitScenes;
use self::store::StoredFit;
use super::campaign::Campaign;
use super::options::fit::{FitArgs, FitOptions};
use super::verdict::Verdict as Line;
use crate::error::Error;
use palpate_fit::calibrate::Settings;
use palpate_fit::scene_fit::{Verdict, WORST_RATIO, check};
use palpate_tissue::Error as TissueError;
use palpate_tissue::budget::CostModel;
use palpate_tissue::fit_record::FitRecord;
use palpate_tissue::scene::{NO_PATCH, Scene};
use palpate_tissue::session::Session;
use palpate_tissue::trials::Trial;

/// Largest number of nodes of a block's mesh.
const MOST_NODES: f64 = 5000.0;
/// Product of the numbers of places and nodes, if no number of places is given: patches of few
/// nodes are fitted sooner, and gain more from another place.
const PLACES_TIMES_NODES: usize = 33_000;
const PLACES: std::ops::RangeInclusive<usize> = 80..=250;
/// Largest number of rounds of a fit, without and with `--quick`: later rounds gain little.
const ROUNDS: usize = 10;
const QUICK_ROUNDS: usize = 3;
/// Share of the objective that a round must gain for the fit to continue: five more rounds would
/// bring the force error of 410 nodes from 0.88 to 0.84 %.
const LEAST_GAIN: f64 = 0.03;

/// A patch file, before it is written.
struct PatchFile {
    name: String,
    bytes: Vec<u8>,
    /// Cost of a tick, for a board.
    load: Option<Load>,
}

impl PatchFile {
    /// The file of a fit, named by its number of nodes.
    fn of(scene: &Scene, session: &Session, fit: &StoredFit) -> Self {
        Self { name: format!("{}-{}.patch", scene.name, session.report.nodes), bytes: fit.patch(), load: None }
    }
}

/// A written patch.
struct Written {
    /// Name of the patch file.
    name: String,
    record: FitRecord,
    /// The model in words: its nodes, or the constants of a law.
    model: String,
    /// Cost of a tick, for a board.
    load: Option<Load>,
}

/// Results of a fit.
struct Fitted {
    /// The written patch; `None` if the search for the smallest found none.
    patch: Option<Written>,
    trials: Vec<Trial>,
    /// A suggested remedy, if the patch misses the tolerance.
    missed: Option<String>,
}

impl Fitted {
    fn verdict(&self, tolerance_pct: f64) -> Result<Line, Error> {
        let check = self.missed.as_ref().map_or(Ok(()), |missed| Err(TissueError::Check(missed.clone())));
        Line::of(check, || {
            let Some(Written { record, load, model, .. }) = &self.patch else { return String::new() };
            let judged = record.judged;
            let known = record
                .reference_error_pct
                .map_or_else(String::new, |pct| format!(", with the finite elements' own {pct:.2} %{}", record.quickly()));
            let load = load.as_ref().map_or_else(String::new, |load| {
                format!("; a tick takes {:.0} % of what it may on {} (estimate)", load.pct(), load.board)
            });
            format!(
                "{model}, {:.2} % rms off finite elements at {} places that the fit did not see, {:+.2} % at worst ({tolerance_pct} % rms and {:.1} % asked for){known}{load}",
                judged.rms_pct,
                judged.places,
                judged.worst_pct,
                WORST_RATIO * tolerance_pct
            )
        })
    }
}

impl FitArgs {
    pub(super) fn run(&self) -> Result<(), Error> {
        if let Some(scenes) = self.scenes.clone() {
            let out = self.common.folder("fit");
            return FitScenes::of(self, &scenes, &out)?.start(&self.cases, &out);
        }
        let verdict = self.fit_scene()?.verdict(self.options.tolerance_pct)?;
        verdict.warning_if(self.options.quick).about(&self.common.load()?).last()
    }

    fn fit_scene(&self) -> Result<Fitted, Error> {
        let machine = self.boards()?.first().copied();
        let mut scene = self.scene(machine)?;
        let mut for_law = scene.refuse_what_a_law_lacks("a law has no nodes");
        if self.options.law {
            for_law.map_err(TissueError::from)?;
            return self.fit_law(&scene, machine);
        }
        let (key, b) = scene.tissue.most_stiffening();
        if b > 0.0 {
            for_law =
                for_law.and_then(|()| scene.bad(&key, "is left out of a search: take `palpate fit --law`, which contains it"));
            println!("note: {key} = {b} is left out of the fit: press and loop add the stiffening to the patch");
            scene.tissue = scene.tissue.elastic();
        }
        let whole = self.options.radius_m.is_none() && self.options.element_m.is_none();
        match (machine, scene.tissue.block_m) {
            (Some(machine), _) if self.options.smallest => self.fit_smallest(&scene, for_law, machine),
            (None, Some(size_m)) if whole => self.fit_block(&scene, size_m),
            (machine, _) => self.fit_piece(&scene, machine),
        }
    }

    fn print_scene(&self, scene: &Scene, nodes: usize, points: usize, fitted_m: &[f64]) {
        let beside = if points > 9 { ", which no board runs (--points 9 for a board)" } else { "" };
        println!(
            "scene {}: {nodes} nodes, nu {}, {}, {:.2} to {:.2} mm deep, {points} foundation points on a triangle{beside}",
            scene.name,
            scene.tissue.poisson_ratio,
            scene.probe.tip(),
            fitted_m.first().unwrap_or(&f64::NAN) * 1e3,
            fitted_m.last().unwrap_or(&f64::NAN) * 1e3,
        );
        for warning in scene.warnings() {
            println!("  warning   {warning}");
        }
    }

    /// Loads the scene, and checks that it can be fitted for a board.
    fn scene(&self, machine: Option<&CostModel>) -> Result<Scene, Error> {
        let mut scene = self.common.load()?;
        self.options.check()?;
        check(&scene)?;
        if let Some(machine) = machine.filter(|machine| machine.is_board()) {
            // a law contains the stiffening
            let tissue = if self.options.law { scene.tissue.elastic() } else { scene.tissue.clone() };
            Scene { tissue, ..scene.clone() }.refuse_what_boards_lack(machine.name)?;
        }
        // the scene may already name the patch that is about to be fitted
        scene.solver.patch = Some(NO_PATCH.into());
        // for a piece the option gives its own nodes, not those of the tissue
        if scene.tissue.block_m.is_some() {
            scene.tissue.nodes = self.options.nodes.or(scene.tissue.nodes);
        }
        Ok(scene)
    }

    /// Settings of a fit for this many nodes.
    fn settings(&self, nodes: usize, least_gain: f64) -> Settings {
        let rounds = if self.options.quick { QUICK_ROUNDS } else { ROUNDS };
        let places = self.options.places.unwrap_or((PLACES_TIMES_NODES / nodes.max(1)).clamp(*PLACES.start(), *PLACES.end()));
        Settings { places, rounds, least_gain }
    }

    /// The written patch, with a remedy if it misses the tolerance.
    fn judged(&self, (patch, trials): (Written, Vec<Trial>), verdict: &Verdict) -> Fitted {
        let missed = self.options.missed(patch.record.nodes, patch.load.is_some(), verdict);
        Fitted { patch: Some(patch), trials, missed }
    }
}

impl FitOptions {
    /// Compares the error with the requested one; if it is larger, or too many presses have none,
    /// suggests a remedy.
    fn missed(&self, nodes: usize, on_board: bool, verdict: &Verdict) -> Option<String> {
        let (rms, worst) = (verdict.rms_pct(), verdict.worst_pct());
        if verdict.lost_too_many() {
            return Some(format!(
                "{} of {} presses could not be judged, because the patch does not come to rest there; the others are {rms:.2} % rms off, {worst:+.2} % at worst; all is written: try another --nodes, or press less deep",
                verdict.lost_presses, verdict.presses
            ));
        }
        let (asked, keeps) = (self.tolerance_pct, verdict.keeps_pct());
        if keeps <= asked {
            return None;
        }
        // the error falls roughly with the square root of the number of nodes
        let would_do = match nodes as f64 * (keeps / asked).powi(2) {
            _ if self.quick => "leave out --quick, or ask for".to_owned(),
            _ if self.law => "press less deep, let --smallest look for a patch, or ask for".to_owned(),
            _ if on_board => "take a faster board, let --smallest choose radius and elements, or ask for".to_owned(),
            n if n > MOST_NODES => "more nodes than a block is meshed with would (an estimate): ask for".to_owned(),
            n => format!("try --nodes {:.0} (an estimate), or", (n / 10.0).ceil() * 10.0),
        };
        Some(format!(
            "{rms:.2} % rms and {worst:+.2} % at the worst unseen press, {asked} % rms and {:.1} % were asked for; all is written: {would_do} --tolerance-pct {:.1}",
            WORST_RATIO * asked,
            (keeps * 10.0).ceil() / 10.0
        ))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_verdict_that_leaves_out_many_presses_is_not_ok_however_small_its_error() {
        let options = FitOptions {
            nodes: None,
            radius_m: None,
            element_m: None,
            smallest: false,
            law: false,
            places: None,
            points: None,
            tolerance_pct: 2.0,
            quick: false,
            device: Default::default(),
        };
        let verdict = |lost_presses| Verdict {
            reference_pct: 0.0,
            depths: Vec::new(),
            unseen_rms_pct: 1.0,
            unseen_worst_pct: 2.0,
            unseen_presses: 100 - lost_presses,
            disc_rms_pct: 1.0,
            disc_worst_pct: 2.0,
            disc_places: 0,
            limited_presses: 0,
            lost_presses,
            presses: 100,
            disc_radius_m: 0.01,
            surfaces: Vec::new(),
            glued: None,
        };
        assert_eq!([0, 2].map(|lost| options.missed(60, false, &verdict(lost))), [None, None]);
        let missed = options.missed(60, false, &verdict(3)).unwrap();
        assert!(missed.starts_with("3 of 100 presses could not be judged"), "{missed}");
    }
}
