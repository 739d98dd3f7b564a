//! This machine's patch, moved along the tips that a board measured: it gives the shape of the
//! tissue, and a force to compare with the board's.
//!
//! Nothing was measured between two records. The patch moves straight from one tip to the next,
//! with one tick per tick of the board; its force is that at the measured tip.

use palpate::haptic::cycle::Renderer;
use palpate::haptic::mode::Mode;
use palpate::{ClampFlags, Output, Params, Placement, ProbePose, Vector3};
use palpate_loop::board_trace::{RECORD_TICKS, Row};
use palpate_loop::live::{CLEAR_M, LiveTissue};

use super::following::Step;
use super::patches::Chosen;
use crate::message::Frame;

type V = Vector3<f32>;

/// Number of ticks in which the patch approaches a tip if the path to it is unknown; also the
/// largest number of ticks between two records.
const WAY_TICKS: u32 = 200;
/// Number of records after an unknown part of the path until the patch has forgotten it, 0.2 s.
const SETTLING: u32 = 200 / RECORD_TICKS;

/// Reason why the two forces are not compared.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Apart {
    /// The board's patch does not run in this mode.
    Rests,
    /// This machine's patch is not the board's.
    OtherPatch,
    /// This machine's patch cannot have the board's Young's modulus [Pa].
    Modulus(f32),
    /// Part of the path to this tip is unknown: these are the first records, or the first ones
    /// after a gap.
    UnknownWay,
    /// Board or patch was shown another tip than the measured one, since the tip was too fast or
    /// began inside the tissue.
    HeldBack,
    /// This machine's patch stopped with a fault.
    Stopped,
}

/// Answer of this machine's patch to a record.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Answer {
    /// Force of the patch in the frame of the device [N]; `None` if the patch gives no answer.
    pub force_n: Option<[f32; 3]>,
    /// Magnitude of the difference from the force of the board's patch [N], or why they are not
    /// compared.
    pub differs_n: Result<f32, Apart>,
}

/// The patch, placed under the device as it is on the board.
pub struct Twin {
    tissue: LiveTissue,
    placement: Placement,
    checksum: Option<u32>,
    /// Tip in the frame of the device [m]; `None` for a patch at rest.
    tip_m: Option<V>,
    settling: u32,
    output: Output,
}

impl Twin {
    /// Creates the twin of the chosen patch, at rest.
    #[must_use]
    pub fn of(chosen: Chosen) -> Self {
        let Chosen { tissue, checksum, .. } = chosen;
        let placement = Placement::new(tissue.patch().site_m(), tissue.params().probe.axis);
        Self { tissue, placement, checksum, tip_m: None, settling: 0, output: Output::NONE }
    }

    /// Puts the patch to rest and forgets the path so far.
    pub fn forget(&mut self) {
        self.tissue.restart();
        (self.tip_m, self.output) = (None, Output::NONE);
    }

    /// Moves to the tip of a record.
    pub fn go(&mut self, step: &Step) -> Answer {
        let row = &step.row;
        let runs = Mode::ALL.get(usize::from(row.mode)).is_some_and(|mode| mode.runs_patch());
        if !runs {
            // on the board, too, the patch is put to rest before it runs again
            self.forget();
            return Answer { force_n: None, differs_n: Err(Apart::Rests) };
        }
        if row.limited_by(ClampFlags::BURIED) {
            // the board's patch gives no force until the tip has been outside
            self.forget();
            return Answer { force_n: None, differs_n: Err(Apart::HeldBack) };
        }
        let own = self.checksum == Some(row.patch_checksum);
        let tuned = !own || self.tune(row);
        let to_m = V::from(row.tip_m);
        let known = self.tip_m.filter(|_| step.ticks.is_some());
        self.settling = if known.is_some() && step.lost() == 0 { self.settling.saturating_sub(1) } else { SETTLING };
        let (from_m, ticks) = match (known, step.ticks) {
            (Some(from_m), Some(ticks)) => (from_m, ticks.clamp(1, WAY_TICKS)),
            _ => {
                // the tip approaches from straight above: a patch whose tip begins inside would
                // give no force
                self.forget();
                (to_m + V::z() * (row.depth_m.max(0.0) + CLEAR_M as f32), WAY_TICKS)
            }
        };
        let mut limiters = ClampFlags::DEFAULT;
        for tick in 1..=ticks {
            let share = tick as f32 / ticks as f32;
            let at_m = if tick == ticks { to_m } else { from_m + (to_m - from_m) * share };
            self.output = self.tissue.render(self.placement.pose_to_patch(ProbePose { tip_m: at_m }));
            limiters.set(self.output.limiters);
        }
        // a patch that has stopped begins again with the next record
        self.tip_m = self.output.fault.is_none().then_some(to_m);
        let stopped = self.output.fault.is_some();
        let force_n = self.placement.turn_to_device(self.output.force_n);
        let held_back = |flag: ClampFlags| limiters.contains(flag) || row.limited_by(flag);
        let differs_n = match () {
            () if !own => Err(Apart::OtherPatch),
            () if !tuned => Err(Apart::Modulus(row.youngs_modulus_pa)),
            () if stopped => Err(Apart::Stopped),
            () if self.settling > 0 => Err(Apart::UnknownWay),
            () if held_back(ClampFlags::SPEED) || held_back(ClampFlags::BURIED) => Err(Apart::HeldBack),
            () => Ok((force_n - V::from(row.model_n)).norm()),
        };
        Answer { force_n: (!stopped).then(|| force_n.into()), differs_n }
    }

    /// Sets the board's modulus; returns false if the patch cannot have it.
    fn tune(&mut self, row: &Row) -> bool {
        let params = *self.tissue.params();
        let youngs_modulus_pa = row.youngs_modulus_pa;
        params.youngs_modulus_pa == youngs_modulus_pa || self.tissue.retune(Params { youngs_modulus_pa, ..params }).is_ok()
    }

    /// The picture in the frame of the patch: the board's tip and force, and the nodes of this
    /// machine's patch.
    #[must_use]
    pub fn frame(&self, row: &Row, body: u32) -> Frame {
        let tip_m = self.placement.to_patch(row.tip_m.into());
        let touches = self.output.normal != V::zeros();
        Frame {
            body,
            nodes_m: self.tissue.nodes().iter().map(|n| n.position_m().into()).collect(),
            tip_m: tip_m.into(),
            mode: row.mode,
            fault: row.fault,
            limiters: row.limiters,
            force_n: self.placement.turn_to_patch(row.applied_n.into()).into(),
            depth_m: row.depth_m,
            contact_m: if touches { self.output.point_m.into() } else { tip_m.into() },
            ..Frame::default()
        }
    }
}

#[cfg(test)]
mod tests;
