//! Record of a tick for the host: the cycle's telemetry, the outputs, and the time that the tick
//! took.

use palpate::Fault;
use palpate::haptic::cycle::Telemetry;
use palpate::haptic::mode::Mode;
use serde::{Deserialize, Serialize};

use crate::force_out::Outputs;

/// One tick. Modes, faults and limiters are given as their numbers.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Record {
    /// Number of haptic cycles begun; it wraps.
    pub tick: u32,
    /// Mode at the end of the tick.
    pub mode: u8,
    /// Latched fault; 0 is none.
    pub fault: u8,
    /// Whether a request was made that the mode does not accept, or does not accept yet.
    pub refused: bool,
    /// Flags of the quantities that the patch's guard and the loop limited.
    pub limiters: u8,
    /// Tip position that was rendered [m]; as for all vectors here, in the device frame.
    pub position_m: [f32; 3],
    /// Force of the patch on the probe [N].
    pub model_n: [f32; 3],
    /// Centre of the contact [m].
    pub point_m: [f32; 3],
    /// Unit normal of the contact.
    pub normal: [f32; 3],
    /// Depth of the tip below the undeformed surface [m].
    pub depth_m: f32,
    /// Number of nodes that moved.
    pub active_nodes: u16,
    /// Flags of the inputs that the patch's guard limited.
    pub patch_limiters: u8,
    /// Force with damping, before gains and limits [N].
    pub wanted_n: [f32; 3],
    /// Force on the device [N].
    pub applied_n: [f32; 3],
    /// Energy [J] given to the hand since the touch, created by this contact, and that the hand may
    /// still be given.
    pub energy_j: [f32; 3],
    /// Whether the enable line is on.
    pub enabled: bool,
    /// Converter code of each axis or joint.
    pub codes: [i16; 3],
    /// Time from reading the sensors to writing the converters, in counts of the board's clock; 0
    /// on the desktop.
    pub spent_counts: u32,
}

impl Record {
    /// Builds the record of a tick.
    #[must_use]
    pub fn new(telemetry: &Telemetry, outputs: Outputs, spent_counts: u32) -> Self {
        let output = &telemetry.output;
        let energy = &telemetry.energy;
        Self {
            tick: telemetry.tick,
            mode: telemetry.mode as u8,
            fault: telemetry.fault.map_or(0, |fault| fault as u8),
            refused: telemetry.refused,
            limiters: telemetry.limiters.bits(),
            position_m: telemetry.position_m.into(),
            model_n: output.force_n.into(),
            point_m: output.point_m.into(),
            normal: output.normal.into(),
            depth_m: output.depth_m,
            active_nodes: output.active_nodes,
            patch_limiters: output.limiters.bits(),
            wanted_n: telemetry.wanted_n.into(),
            applied_n: telemetry.applied_n.into(),
            energy_j: [energy.given_j, energy.created_j, energy.balance_j],
            enabled: outputs.enabled,
            codes: outputs.codes.map(|code| code.0),
            spent_counts,
        }
    }

    /// The mode; `None` if the number is no mode of this version.
    #[must_use]
    pub fn mode(&self) -> Option<Mode> {
        Mode::ALL.into_iter().find(|mode| *mode as u8 == self.mode)
    }

    /// The latched fault; `None` if there is none, or the number is no fault of this version.
    #[must_use]
    pub fn fault(&self) -> Option<Fault> {
        Fault::ALL.into_iter().find(|fault| *fault as u8 == self.fault)
    }

    /// The first field whose bits differ, by name and with both values; `spent_counts` is not
    /// compared.
    #[must_use]
    pub fn first_difference(&self, other: &Self) -> Option<(&'static str, [f32; 2])> {
        let whole = |name, a: u32, b: u32| (a != b).then_some((name, [a as f32, b as f32]));
        let real = |name, a: f32, b: f32| (a.to_bits() != b.to_bits()).then_some((name, [a, b]));
        let vector = |name, a: [f32; 3], b: [f32; 3]| a.into_iter().zip(b).find_map(|(a, b)| real(name, a, b));
        let codes = || self.codes.iter().zip(other.codes).find(|(a, b)| **a != *b);
        whole("tick", self.tick, other.tick)
            .or_else(|| whole("mode", self.mode.into(), other.mode.into()))
            .or_else(|| whole("fault", self.fault.into(), other.fault.into()))
            .or_else(|| whole("refused", self.refused.into(), other.refused.into()))
            .or_else(|| whole("limiters", self.limiters.into(), other.limiters.into()))
            .or_else(|| vector("position_m", self.position_m, other.position_m))
            .or_else(|| vector("model_n", self.model_n, other.model_n))
            .or_else(|| vector("point_m", self.point_m, other.point_m))
            .or_else(|| vector("normal", self.normal, other.normal))
            .or_else(|| real("depth_m", self.depth_m, other.depth_m))
            .or_else(|| whole("active_nodes", self.active_nodes.into(), other.active_nodes.into()))
            .or_else(|| whole("patch_limiters", self.patch_limiters.into(), other.patch_limiters.into()))
            .or_else(|| vector("wanted_n", self.wanted_n, other.wanted_n))
            .or_else(|| vector("applied_n", self.applied_n, other.applied_n))
            .or_else(|| vector("energy_j", self.energy_j, other.energy_j))
            .or_else(|| whole("enabled", self.enabled.into(), other.enabled.into()))
            .or_else(|| codes().map(|(a, b)| ("codes", [f32::from(*a), f32::from(b)])))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const RECORD: Record = Record {
        tick: 1,
        mode: 2,
        fault: 3,
        refused: false,
        limiters: 4,
        position_m: [0.1, 0.2, 0.3],
        model_n: [0.4, 0.5, 0.6],
        point_m: [0.7, 0.8, 0.9],
        normal: [0.0, 0.6, 0.8],
        depth_m: 1e-3,
        active_nodes: 5,
        patch_limiters: 6,
        wanted_n: [1.0, 1.1, 1.2],
        applied_n: [1.3, 1.4, 1.5],
        energy_j: [1.6, 1.7, 1.8],
        enabled: true,
        codes: [7, 8, 9],
        spent_counts: 10,
    };

    #[test]
    fn modes_and_faults_are_found_by_their_numbers() {
        for mode in Mode::ALL {
            assert_eq!(Record { mode: mode as u8, ..RECORD }.mode(), Some(mode));
        }
        for fault in Fault::ALL {
            assert_eq!(Record { fault: fault as u8, ..RECORD }.fault(), Some(fault));
        }
        let later = Record { mode: 200, fault: 200, ..RECORD };
        assert_eq!((later.mode(), later.fault()), (None, None), "of a later version");
        assert_eq!(Record { fault: 0, ..RECORD }.fault(), None);
    }

    #[test]
    fn a_difference_is_named_with_both_values_and_the_time_is_none() {
        assert_eq!(RECORD.first_difference(&RECORD), None);
        assert_eq!(RECORD.first_difference(&Record { spent_counts: 11, ..RECORD }), None);
        let changed = [
            (Record { tick: 12, ..RECORD }, "tick", [1.0, 12.0]),
            (Record { mode: 12, ..RECORD }, "mode", [2.0, 12.0]),
            (Record { fault: 12, ..RECORD }, "fault", [3.0, 12.0]),
            (Record { refused: true, ..RECORD }, "refused", [0.0, 1.0]),
            (Record { limiters: 12, ..RECORD }, "limiters", [4.0, 12.0]),
            (Record { position_m: [0.1, 0.2, 12.0], ..RECORD }, "position_m", [0.3, 12.0]),
            (Record { model_n: [0.4, 12.0, 0.6], ..RECORD }, "model_n", [0.5, 12.0]),
            (Record { point_m: [12.0, 0.8, 0.9], ..RECORD }, "point_m", [0.7, 12.0]),
            (Record { normal: [-0.0, 0.6, 0.8], ..RECORD }, "normal", [0.0, -0.0]),
            (Record { depth_m: 12.0, ..RECORD }, "depth_m", [1e-3, 12.0]),
            (Record { active_nodes: 12, ..RECORD }, "active_nodes", [5.0, 12.0]),
            (Record { patch_limiters: 12, ..RECORD }, "patch_limiters", [6.0, 12.0]),
            (Record { wanted_n: [1.0, 1.1, 12.0], ..RECORD }, "wanted_n", [1.2, 12.0]),
            (Record { applied_n: [1.3, 1.4, 12.0], ..RECORD }, "applied_n", [1.5, 12.0]),
            (Record { energy_j: [1.6, 1.7, 12.0], ..RECORD }, "energy_j", [1.8, 12.0]),
            (Record { enabled: false, ..RECORD }, "enabled", [1.0, 0.0]),
            (Record { codes: [7, 12, 9], ..RECORD }, "codes", [8.0, 12.0]),
        ];
        for (other, name, values) in changed {
            assert_eq!(RECORD.first_difference(&other), Some((name, values)));
        }
    }
}
