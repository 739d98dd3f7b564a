//! `press`: an emulated finger presses the scene at 1 kHz in virtual time.
//!
//! The ticks follow each other without waiting; the CPU time of each is compared with the budget of
//! 1 ms.

pub mod contact;
mod promise;

use palpate::{ClampFlags, ContactMap, Fault, Model, Output, Probe, ProbePose, State, Tuned, Vector3, tick};

use crate::clock::thread_time;
use crate::error::Error;
use crate::finger::Finger;
use crate::measure;
use crate::patch::Memory;
use crate::probe_surface::outer_face_m;
use crate::scene::Scene;
use crate::scene::TICK_S;
use crate::session::Session;

/// Time after the release within which the tissue should return to its rest shape [s].
pub const SETTLE_S: f64 = 0.5;
/// Height above the surface at which the finger starts and ends, as a share of the probe's radius
/// (1).
const CLEAR_RADII: f64 = 1.0 / 16.0;

/// Time budget of a tick [us].
const BUDGET_US: f32 = TICK_S as f32 * 1e6;
/// Number of times that a tick over the budget is repeated from the same state, with the same bits:
/// a tick that is really too slow is slow every time, unlike one that was interrupted by other
/// processes.
const REPEATS: usize = 3;

/// One tick of a run.
#[derive(Clone, Copy, Debug)]
pub struct TickRow {
    /// Time of the run at which the tick starts [s].
    pub t_s: f64,
    /// Commanded position of the tip [m].
    pub tip_m: Vector3<f32>,
    /// Commanded depth of the tip below the rest surface along the press, negative above [m].
    pub command_m: f64,
    /// Output of the core.
    pub output: Output,
    /// CPU time of the tick, the shortest if it was repeated [us].
    pub tick_us: f32,
}

/// State at the end of a hold.
#[derive(Clone, Debug)]
pub struct Hold {
    /// Target of the hold: depth [m], force [N] or position of the hand [m], by the kind of drive.
    pub target: f64,
    /// Commanded depth of the tip along the press [m].
    pub command_m: f64,
    /// Depth reached, along the contact normal [m].
    pub depth_m: f64,
    /// Force along the press [N], positive out of the tissue.
    pub force_n: f64,
    /// Smallest ratio of a tet's volume to its rest volume (1).
    pub min_j: f64,
    /// Change of the total volume [%].
    pub volume_change_pct: f64,
    /// Start of the last tick of the hold [s].
    pub t_s: f64,
    /// Commanded position of the tip in that tick [m].
    pub tip_m: Vector3<f32>,
    /// Displacement of every node [m].
    pub displacement_m: Vec<Vector3<f32>>,
    /// Displacement of every node [m]; for a surface node inside the probe, the displacement of the
    /// foundation's outer face, which touches the probe.
    pub surface_displacement_m: Vec<Vector3<f32>>,
    /// Mean pressure on each surface triangle [Pa].
    pub pressure_pa: Vec<f32>,
}

/// Record of a run.
#[derive(Clone, Debug)]
pub struct Press {
    /// One row per tick.
    pub ticks: Vec<TickRow>,
    /// One entry per hold.
    pub holds: Vec<Hold>,
    /// Largest displacement of a node that remains at the end of the run [m].
    pub residual_m: f64,
    /// Number of ticks that took longer than 1 ms.
    pub deadline_misses: usize,
    /// Fault that ended the run.
    pub fault: Option<Fault>,
    /// All quantities that were clamped in at least one tick.
    pub limiters: ClampFlags,
    /// Hash of the final state.
    pub state_hash: u64,
    /// Machine on which the tick times were measured.
    pub timed_on: String,
}

/// Source of the tip positions of a run.
enum Tips {
    Finger(Finger),
    Recorded(std::vec::IntoIter<[f32; 3]>),
}

/// Runs a scene; `progress` is called after every tick with the number of ticks so far.
///
/// # Errors
/// A model or parameters that the core refuses to build.
pub fn run(scene: &Scene, session: &Session, progress: impl FnMut(usize)) -> Result<Press, Error> {
    run_seen(scene, session, progress, |_, _, _, _| ())
}

/// Runs a scene as [`run`] does; `see` is called after every tick with the state and the tick's
/// row.
///
/// # Errors
/// Errors of [`run`].
pub fn run_seen(
    scene: &Scene,
    session: &Session,
    mut progress: impl FnMut(usize),
    mut see: impl FnMut(&Model, &Tuned, &mut State, &TickRow),
) -> Result<Press, Error> {
    let model = session.patch.wide_model();
    let mut memory = Memory::for_model(&model);
    let (tuned, mut state) = memory.start(&model, &session.params)?;
    let axis = session.params.probe.axis;
    let mut tips = match Finger::new(&scene.drive, clear_m(scene, session), TICK_S, SETTLE_S) {
        Some(finger) => Tips::Finger(finger),
        None => Tips::Recorded(session.tips_m.clone().into_iter()),
    };
    let targets = scene.drive.targets();

    let mut spare = Memory::for_model(&model);
    let (_, mut before) = spare.start(&model, &session.params)?;
    let mut press = Press::empty(crate::machine::processor());
    let mut force_n = 0.0;
    while press.fault.is_none() {
        let (tip_m, hold_ends) = match &mut tips {
            Tips::Finger(finger) => match finger.next(force_n) {
                Some(step) => (session.tip_m(step.depth_m), step.hold_ends),
                None => break,
            },
            Tips::Recorded(tips) => match tips.next() {
                Some(tip) => (tip.into(), None),
                None => break,
            },
        };
        before.copy_from(&state);
        let timed = |state: &mut State| {
            let started = thread_time();
            let output = tick(&model, &tuned, state, ProbePose { tip_m });
            (output, (thread_time() - started).as_secs_f32() * 1e6)
        };
        let (output, mut tick_us) = timed(&mut state);
        for _ in 0..REPEATS {
            if tick_us <= BUDGET_US {
                break;
            }
            state.copy_from(&before);
            let (_, again_us) = timed(&mut state);
            tick_us = tick_us.min(again_us);
        }

        force_n = f64::from(output.force_n.dot(&axis));
        let t_s = press.ticks.len() as f64 * TICK_S;
        let command_m = f64::from((session.touch_m() - tip_m).dot(&axis));
        let row = TickRow { t_s, tip_m, command_m, output, tick_us };
        press.ticks.push(row);
        press.deadline_misses += usize::from(tick_us > BUDGET_US);
        press.limiters.set(output.limiters);
        press.fault = output.fault;
        see(&model, &tuned, &mut state, &row);
        if let Some(n) = hold_ends {
            let mut held = hold(&model, &session.params.turned_probe(), &state, targets[n], force_n, &row);
            let _map = ContactMap::read(&model, &tuned, &mut state, &mut held.pressure_pa);
            press.holds.push(held);
        }
        progress(press.ticks.len());
    }
    press.residual_m = measure::largest_displacement_m(&model, &state);
    press.state_hash = state.hash();
    Ok(press)
}

/// Height above the surface at which the finger starts [m]: at least two ticks at the speed of the
/// ramp, since a run whose first pose is not outside counts as started inside the tissue.
pub fn clear_m(scene: &Scene, session: &Session) -> f64 {
    let ramp_step_m = scene.drive.ramp_m_per_s().unwrap_or(0.0) * TICK_S;
    (CLEAR_RADII * f64::from(session.params.probe.radius_m)).max(2.0 * ramp_step_m)
}

/// Creates the record of a hold at its end.
pub fn hold(model: &Model, probe: &Probe, state: &State, target: f64, force_n: f64, row: &TickRow) -> Hold {
    let (min_j, volume_change_pct) = measure::volumes(model, state);
    let displacement_m = measure::displacements(model, state);
    let mut surface_displacement_m = displacement_m.clone();
    for n in model.triangles.iter().flat_map(|t| t.node).map(usize::from) {
        let rest_m = Vector3::from(model.nodes[n].rest_m);
        let face_m = outer_face_m(probe, row.tip_m.cast(), (rest_m + displacement_m[n]).cast());
        surface_displacement_m[n] = face_m.cast() - rest_m;
    }
    Hold {
        target,
        command_m: row.command_m,
        depth_m: f64::from(row.output.depth_m),
        force_n,
        min_j,
        volume_change_pct,
        t_s: row.t_s,
        tip_m: row.tip_m,
        displacement_m,
        surface_displacement_m,
        pressure_pa: vec![0.0; model.triangles.len()],
    }
}

impl Press {
    /// Creates the record of a run before its first tick.
    pub fn empty(timed_on: String) -> Self {
        Self {
            ticks: Vec::new(),
            holds: Vec::new(),
            residual_m: 0.0,
            deadline_misses: 0,
            fault: None,
            limiters: ClampFlags::default(),
            state_hash: 0,
            timed_on,
        }
    }

    /// Tick times [us]: median, 99th percentile, largest.
    #[must_use]
    pub fn tick_us(&self) -> [f32; 3] {
        let mut times: Vec<f32> = self.ticks.iter().map(|t| t.tick_us).collect();
        times.sort_by(f32::total_cmp);
        let at = |share: f64| times.get(((times.len().max(1) - 1) as f64 * share) as usize).copied().unwrap_or(0.0);
        [at(0.5), at(0.99), at(1.0)]
    }
}
