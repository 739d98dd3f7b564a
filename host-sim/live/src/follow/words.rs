//! The state of a board, and its comparison with this machine's patch, in words.

use palpate::haptic::mode::Mode;
use palpate_loop::board_trace::Row;

use super::following::Phase;
use super::twin::Apart;

/// Name of the board's mode with this number.
#[must_use]
pub fn mode(number: u8) -> &'static str {
    match Mode::ALL.get(usize::from(number)) {
        Some(Mode::Boot | Mode::SelfTest) => "starts up: no force",
        Some(Mode::Idle) => "idle: no force",
        Some(Mode::Arming) => "arming: no force before the tip is still, outside the tissue",
        Some(Mode::Active) => "active: the force is felt",
        Some(Mode::Degraded) => "degraded: felt, scaled down for this contact",
        Some(Mode::SafeRamp) => "safe ramp: the force falls to nothing",
        Some(Mode::Fault) => "fault: no force",
        None => "a mode of another version",
    }
}

/// A time span [s] in a suitable unit.
#[must_use]
pub fn span(s: f64) -> String {
    match s {
        _ if s < 9.95 => format!("{s:.1} s"),
        _ if s < 120.0 => format!("{s:.0} s"),
        _ if s < 7200.0 => format!("{:.0} min", s / 60.0),
        _ => format!("{:.0} h", s / 3600.0),
    }
}

/// Why there is no current record, and what to do about it; `None` while records arrive.
#[must_use]
pub fn absence(phase: &Phase, silent_s: f64, path: &str) -> Option<[String; 2]> {
    let arm = format!("palpate board arm --stream {path} --port PORT");
    match phase {
        Phase::Live => None,
        Phase::Absent => Some(["No file yet: waiting for it.".into(), arm]),
        Phase::Begun => Some(["No record yet: waiting for the first one.".into(), format!("{path} is there")]),
        Phase::Silent => Some([
            format!("No record for {}: no force is shown.", span(silent_s)),
            "palpate board has ended, or lost its port; a file that begins anew is followed".into(),
        ]),
        // the window's font has no backquote
        Phase::Bad(why) => Some(["This is no table of a board's records.".into(), why.replace('`', "\"")]),
    }
}

/// Force of the board with its unit; a dash if there is no current record.
#[must_use]
pub fn force(row: Option<&Row>, of: fn(&Row) -> [f32; 3]) -> String {
    row.map_or_else(|| "-".into(), |row| format!("{:.3} N", length(of(row))))
}

/// Length of a vector.
#[must_use]
pub fn length(vector: [f32; 3]) -> f32 {
    vector.iter().map(|part| part * part).sum::<f32>().sqrt()
}

/// A sentence on the difference of the two forces: its value, absolute and relative, or why it is
/// not known.
#[must_use]
pub fn difference(differs_n: Result<f32, Apart>, model_n: f32) -> String {
    /// Least force for which the relative difference is given [N].
    const LEAST_N: f32 = 0.01;
    match differs_n {
        Ok(differs_n) if model_n >= LEAST_N => {
            format!("differs by {:.1} mN, {:.1} %", differs_n * 1e3, differs_n / model_n * 100.0)
        }
        Ok(differs_n) => format!("differs by {:.1} mN", differs_n * 1e3),
        Err(why) => format!("not compared: {}", apart(why)),
    }
}

fn apart(why: Apart) -> String {
    match why {
        Apart::Rests => "the board's patch rests in this mode".into(),
        Apart::OtherPatch => "the board has another patch; give its file with --patch".into(),
        Apart::Modulus(pa) => format!("the board's {pa} Pa cannot be set here"),
        Apart::UnknownWay => "records before this one are missing".into(),
        Apart::HeldBack => "the tip was too fast, or began inside".into(),
        Apart::Stopped => "the patch here stopped".into(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_a_live_file_is_without_a_sentence() {
        let said = |phase: &Phase| absence(phase, 12.3, "out/felt.csv");
        assert_eq!(said(&Phase::Live), None);
        assert!(said(&Phase::Absent).unwrap()[1].contains("board arm --stream out/felt.csv"));
        assert!(said(&Phase::Begun).unwrap()[0].starts_with("No record yet"));
        assert_eq!(said(&Phase::Silent).unwrap()[0], "No record for 12 s: no force is shown.");
        assert_eq!(said(&Phase::Bad("felt.csv:1: why: give `it`".into())).unwrap()[1], "felt.csv:1: why: give \"it\"");
    }

    #[test]
    fn a_force_that_is_not_present_is_a_dash() {
        let row = Row { applied_n: [0.0, 0.3, 0.4], model_n: [0.0, 0.0, 2.0], ..Row::default() };
        assert_eq!(force(Some(&row), |row| row.applied_n), "0.500 N");
        assert_eq!(force(Some(&row), |row| row.model_n), "2.000 N");
        assert_eq!(force(None, |row| row.applied_n), "-");
    }

    #[test]
    fn a_difference_has_a_share_where_there_is_a_force() {
        assert_eq!(difference(Ok(0.002), 0.2), "differs by 2.0 mN, 1.0 %");
        assert_eq!(difference(Ok(0.0001), 0.0), "differs by 0.1 mN");
        assert!(difference(Err(Apart::OtherPatch), 0.2).contains("not compared: the board has another patch; give its file"));
        assert!(difference(Err(Apart::Modulus(9000.0)), 0.2).contains("9000 Pa"));
    }

    #[test]
    fn every_mode_says_whether_there_is_a_force() {
        for (number, mode_of) in Mode::ALL.into_iter().enumerate() {
            let said = mode(number as u8);
            assert_eq!(said.contains("no force"), !mode_of.allows_force(), "{said}");
        }
        assert_eq!(mode(8), "a mode of another version");
        assert_eq!([5.04, 61.0, 130.0, 9000.0].map(span), ["5.0 s", "61 s", "2 min", "2 h"]);
    }
}
