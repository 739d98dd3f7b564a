//! Duration of each stage of the core's tick, by the board's clock.
//!
//! Springs, volume and rim are each called once separately, in addition to their part in the tick.
//! The forces of the separate calls are cleared before the tick sums its own, so the motion is that
//! of the normal tick.

use palpate::method::Method;
use palpate::stages::force::foundation::{self, Load};
use palpate::stages::force::{accumulate_inner, rim, spring, volume};
use palpate::stages::integrate;
use palpate::{BuildError, Fault, Model, PatchFile, Placement, ProbePose, State, Terms, Tuned, Vector3, tick_with};
use palpate_controller::patch::Memory;
use palpate_controller::script;

use crate::board::{clock_counts, feed_watchdog};

/// Ticks of a measured tap, which reaches its full depth in tick 23.
const TAP_TICKS: u32 = 30;
/// Ticks above the tissue before the tap begins.
const FIRST: u32 = 1;

/// Longest duration of each stage [counts], by its name.
pub type Times = [(&'static str, u32); 7];

/// State before the first measurement.
pub const NONE: Times =
    [("contact", 0), ("springs", 0), ("volume", 0), ("rim", 0), ("foundation", 0), ("integrate", 0), ("whole", 0)];

/// The core's own method, with the clock read at each stage.
struct Timed {
    terms: Terms,
    began: u32,
    times: Times,
}

impl Timed {
    fn keep(&mut self, stage: usize, since: u32) {
        let spent = clock_counts().wrapping_sub(since);
        if let Some((_, longest)) = self.times.get_mut(stage) {
            *longest = (*longest).max(spent);
        }
    }
}

impl Method for Timed {
    fn begin(&mut self, _: &Tuned, _: &State) {
        self.keep(0, self.began);
    }

    fn force(
        &mut self,
        model: &Model,
        tuned: &Tuned,
        state: &mut State,
        tip_m: Vector3<f32>,
        velocity_m_per_s: Vector3<f32>,
    ) -> Load {
        let start = clock_counts();
        spring::pull(model, tuned, state);
        self.keep(1, start);
        if self.terms.volume {
            let start = clock_counts();
            volume::resist(model, tuned, state);
            self.keep(2, start);
        }
        if self.terms.rim {
            let start = clock_counts();
            rim::hold(model, state);
            self.keep(3, start);
        }
        accumulate_inner(model, tuned, state);
        let start = clock_counts();
        let load = foundation::press(model, tuned, state, tip_m, velocity_m_per_s);
        self.keep(4, start);
        load
    }

    fn advance(&mut self, model: &Model, tuned: &Tuned, state: &mut State) -> Result<u16, Fault> {
        let start = clock_counts();
        let moved = integrate::advance(model, tuned, state);
        self.keep(5, start);
        moved
    }
}

/// Taps the patch with each stage measured, then once more with the normal tick measured as a
/// whole. If the patch cannot be opened, `times` stays unchanged.
pub fn time(bytes: &[u8], memory: &mut Memory, times: &mut Times) {
    let mut timed = Timed { terms: Terms::ALL, began: 0, times: NONE };
    let split = tap(bytes, memory, &mut timed, |model, tuned, state, pose, timed| {
        tick_with(model, tuned, state, pose, timed);
    });
    let whole = tap(bytes, memory, &mut timed, |model, tuned, state, pose, timed| {
        palpate::tick(model, tuned, state, pose);
        timed.keep(6, timed.began);
    });
    if split.is_ok() && whole.is_ok() {
        *times = timed.times;
    }
}

/// Runs one tap of a patch at rest.
#[inline(never)]
fn tap(
    bytes: &[u8],
    memory: &mut Memory,
    timed: &mut Timed,
    tick: fn(&Model, &Tuned, &mut State, ProbePose, &mut Timed),
) -> Result<(), BuildError> {
    let PatchFile { model, params, site_m, .. } = PatchFile::open(bytes)?;
    timed.terms = params.terms;
    let placement = Placement::new(site_m, params.probe.axis);
    let (tuned, mut state) = memory.start_in_rounds(&model, &params, &mut feed_watchdog)?;
    for number in 0..TAP_TICKS {
        let pose = placement.pose_to_patch(ProbePose { tip_m: script::sensed(number, FIRST).position_m });
        feed_watchdog();
        timed.began = clock_counts();
        tick(&model, &tuned, &mut state, pose, timed);
    }
    Ok(())
}
