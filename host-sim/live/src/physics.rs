//! The loop beside the drawing: paces virtual time to real time, takes requests and returns frames.

use palpate::Vector3;
use palpate::haptic::cycle::Ask;
use palpate_loop::live::replay::{Replayed, replay, table};
use palpate_loop::live::trace::{MOST_TICKS, Trace};
use palpate_loop::live::{CLEAR_M, Choice, Holding, Live};
use palpate_tissue::error::Error;

use crate::message::{Answer, Body, Contact, Ended, Frame, Request, SILENCE_S, Sample};

/// Largest number of overdue ticks that are run at once; further ones are dropped and reported.
pub const MOST_BEHIND: u64 = 60;
/// Ticks per sample of the strips.
const SAMPLE_EVERY: u64 = 4;
/// Largest number of samples that are kept for a frame that is late.
const MOST_SAMPLES: usize = 500;

/// The loop, paced to real time.
pub struct Physics {
    live: Live,
    body: u32,
    target_m: Vector3<f64>,
    heard_s: f64,
    /// Real time of tick zero [s]; `None` before the first call of [`Self::advance`], since
    /// preparing a patch takes time.
    start_s: Option<f64>,
    ticks: u64,
    dropped: u64,
    second: Second,
    /// Whether frames contain a contact map.
    maps: bool,
    samples: Vec<Sample>,
    last: Frame,
}

/// Tick statistics of the last second of real time.
#[derive(Default)]
struct Second {
    from_s: f64,
    ticks: u64,
    worst_us: f32,
    hz: f32,
    told_worst_us: f32,
}

impl Physics {
    /// Creates a loop that is about to arm.
    ///
    /// # Errors
    /// A scene that does not fit.
    pub fn new(choice: &Choice, holding: &Holding, now_s: f64) -> Result<Self, Error> {
        let live = Live::new(choice, holding)?;
        let mut physics = Self {
            target_m: Vector3::zeros(),
            live,
            body: 1,
            heard_s: now_s,
            start_s: None,
            ticks: 0,
            dropped: 0,
            second: Second { from_s: now_s, ..Second::default() },
            maps: false,
            samples: Vec::new(),
            last: Frame::default(),
        };
        physics.target_m = physics.clear_m();
        Ok(physics)
    }

    /// Position at which the tip waits above the site [m].
    fn clear_m(&self) -> Vector3<f64> {
        let tissue = self.live.tissue();
        tissue.patch().site_m().cast() + tissue.params().probe.axis.cast() * CLEAR_M
    }

    /// Returns the body to draw.
    #[must_use]
    pub fn body(&self) -> Answer {
        Answer::Body(Box::new(Body::of(self.live.tissue(), self.body, Some(self.live.choice()))))
    }

    /// Handles a request; `clock` gives real time [s]. Long work, such as preparing a patch or
    /// replaying a trace, stops the tissue's time.
    pub fn take(&mut self, request: Request, clock: &dyn Fn() -> f64, answer: &mut dyn FnMut(Answer)) {
        let now_s = clock();
        self.follow(request, now_s, answer);
        let spent_s = clock() - now_s;
        self.start_s = self.start_s.map(|start_s| start_s + spent_s);
        self.heard_s += spent_s;
    }

    fn follow(&mut self, request: Request, now_s: f64, answer: &mut dyn FnMut(Answer)) {
        match request {
            Request::Aim(target_m) => {
                self.heard_s = now_s;
                self.target_m = target_m.map_or_else(|| self.away_m(), Vector3::from);
                answer(Answer::Frame(Box::new(self.frame())));
            }
            Request::Choose(choice, holding) => {
                let same = choice.same_patch(self.live.choice()) && holding == *self.live.holding();
                match self.live.choose(&choice, &holding) {
                    Err(error) => {
                        answer(Answer::Refused(error.to_string()));
                        answer(Answer::Kept(Box::new((self.live.choice().clone(), self.live.holding().clone()))));
                    }
                    Ok(_) if same => {}
                    Ok(ended) => {
                        self.body += 1;
                        self.target_m = self.clear_m();
                        // the force on the previous tissue is no longer shown
                        self.samples.clear();
                        self.last = Frame::default();
                        answer(self.body());
                        if let Some(trace) = ended {
                            answer(Answer::Trace(trace, Ended::Changed));
                        }
                    }
                }
            }
            Request::Map(maps) => self.maps = maps,
            Request::Clear => self.live.ask(Ask::Clear),
            Request::Record => match self.live.record() {
                Ok(()) => answer(Answer::Said("Recording: the loop arms anew, then press.".into())),
                Err(error) => answer(Answer::Refused(error.to_string())),
            },
            Request::Finish => match self.live.finish() {
                Some(trace) => answer(Answer::Trace(trace, Ended::Asked)),
                None => answer(Answer::Refused("No recording runs: start one first.".into())),
            },
            Request::Replay(bytes) => answer(repeated(&bytes)),
            Request::Table(bytes) => {
                answer(again(&bytes).map_or_else(Answer::Refused, |(_, again)| Answer::Table(table(&again))));
            }
        }
    }

    /// Position clear of the tissue, straight above the target [m].
    fn away_m(&self) -> Vector3<f64> {
        let axis = self.live.tissue().params().probe.axis.cast();
        let clear_m = self.clear_m();
        let below_m = (clear_m - self.target_m).dot(&axis);
        if below_m > 0.0 { self.target_m + axis * below_m } else { self.target_m }
    }

    /// Runs the ticks that are due; `clock` gives real time [s].
    pub fn advance(&mut self, clock: &dyn Fn() -> f64, answer: &mut dyn FnMut(Answer)) {
        let now_s = clock();
        let start_s = *self.start_s.get_or_insert(now_s);
        let due = (((now_s - start_s) * 1e3) as u64).saturating_sub(self.ticks + self.dropped);
        let run = due.min(MOST_BEHIND);
        self.dropped += due - run;
        let heard = now_s - self.heard_s < SILENCE_S;
        let target_m = if heard { self.target_m } else { self.away_m() };
        let first = self.samples.len();
        for _ in 0..run {
            let step = self.live.tick(target_m, heard);
            self.ticks += 1;
            let t = &step.telemetry;
            if self.ticks.is_multiple_of(SAMPLE_EVERY) && self.samples.len() < MOST_SAMPLES {
                self.samples.push(Sample {
                    t_s: self.ticks as f64 * 1e-3,
                    force_n: t.applied_n.norm(),
                    along_n: step.along_n().norm(),
                    depth_m: t.output.depth_m,
                    energy_j: t.energy.given_j,
                    tick_us: 0.0,
                });
            }
            self.last.tip_m = step.at_m.cast::<f32>().into();
            self.last.mode = t.mode as u8;
            self.last.fault = t.fault.map_or(0, |f| f as u8);
            self.last.limiters = t.limiters.bits();
            self.last.force_n = t.applied_n.into();
            self.last.along_n = step.along_n().into();
            self.last.depth_m = t.output.depth_m;
            self.last.contact_m = t.output.point_m.into();
        }
        if run > 0 {
            // the time of a batch is divided by its ticks, since a browser's clock is too coarse
            // for a single one
            let tick_us = ((clock() - now_s) * 1e6 / run as f64) as f32;
            self.samples.iter_mut().skip(first).for_each(|s| s.tick_us = tick_us);
            self.count(now_s, run, tick_us);
        }
        if self.live.recorded().is_some_and(|ticks| ticks >= MOST_TICKS)
            && let Some(trace) = self.live.finish()
        {
            answer(Answer::Trace(trace, Ended::Full));
        }
    }

    fn count(&mut self, now_s: f64, run: u64, tick_us: f32) {
        let second = &mut self.second;
        second.ticks += run;
        second.worst_us = second.worst_us.max(tick_us);
        let passed_s = now_s - second.from_s;
        if passed_s >= 1.0 {
            (second.hz, second.told_worst_us) = ((second.ticks as f64 / passed_s) as f32, second.worst_us);
            (second.from_s, second.ticks, second.worst_us) = (now_s, 0, 0.0);
        }
    }

    fn frame(&mut self) -> Frame {
        Frame {
            body: self.body,
            map: self.maps.then(|| mapped(&mut self.live)),
            nodes_m: self.live.tissue().nodes().iter().map(|n| n.position_m().into()).collect(),
            samples: std::mem::take(&mut self.samples),
            ticks: self.ticks,
            dropped: self.dropped,
            hz: self.second.hz,
            worst_us: self.second.told_worst_us,
            recorded: self.live.recorded(),
            waits: self.live.waits(),
            ..self.last.clone()
        }
    }
}

fn mapped(live: &mut Live) -> Contact {
    let (map, pressure_pa) = live.contact();
    let half_axes_m = [0, 1].map(|k| (map.axes[k] * map.half_lengths_m[k]).into());
    Contact { area_m2: map.area_m2, centre_m: map.centre_m.into(), half_axes_m, peak_pa: map.peak_pressure_pa, pressure_pa }
}

/// Replays a trace here.
fn again(bytes: &[u8]) -> Result<(Trace, Replayed), String> {
    let trace = Trace::read(bytes).map_err(|cause| format!("{cause}."))?;
    let again = replay(&trace).map_err(|error| error.to_string())?;
    Ok((trace, again))
}

fn repeated(bytes: &[u8]) -> Answer {
    let (trace, again) = match again(bytes) {
        Ok(both) => both,
        Err(why) => return Answer::Refused(why),
    };
    let seconds = f64::from(trace.ticks) * 1e-3;
    match again.differs {
        None => Answer::Said(format!(
            "Replayed {seconds:.1} s of {}: every bit the same, nodes {:016x}.",
            trace.head.scene, again.hash
        )),
        Some((tick, what)) => Answer::Refused(format!("Replayed {seconds:.1} s: {what} differs at tick {tick}.")),
    }
}
