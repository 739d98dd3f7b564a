use std::io::Write;

use palpate::PatchFile;
use palpate::haptic::mode::Mode;
use palpate_loop::board_trace::COLUMNS;

use super::super::following::Phase;
use super::*;

const PATCH: &[u8] = include_bytes!("../../../../../firmware/patches/block-m4f-168.patch");

fn line(tick: u32, mode: Mode, z_m: f32, applied_n: f32, patch: u32) -> String {
    let mode = mode as u8;
    format!("{tick},{mode},0,0,0,{z_m},{},0,0,0.1,0,0,{applied_n},1,0,0,0,9,0,0,0,,{patch:08x},3500\n", -z_m)
}

struct Followed {
    _folder: tempfile::TempDir,
    file: std::fs::File,
    follower: Follower,
}

impl Followed {
    fn begin() -> Self {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("felt.csv");
        let mut file = std::fs::File::create(&path).unwrap();
        writeln!(file, "{}", COLUMNS.join(",")).unwrap();
        Self { _folder: folder, file, follower: Follower::of(&path, Given::Nothing) }
    }

    fn add(&mut self, line: &str) {
        self.file.write_all(line.as_bytes()).unwrap();
    }

    /// Names of the new patches, and the state.
    fn look(&mut self, now_s: f64) -> (Vec<String>, State) {
        let (mut names, mut states) = (Vec::new(), Vec::new());
        for heard in self.follower.look(now_s) {
            match heard {
                Heard::Body(body, name) => {
                    assert!(!body.rest_m.is_empty());
                    names.push(name);
                }
                Heard::State(state) => states.push(*state),
                Heard::NoPatch(why) => panic!("{why}"),
            }
        }
        (names, states.pop().unwrap())
    }
}

#[test]
fn the_first_record_brings_the_boards_own_patch_and_each_its_own_force() {
    let own = PatchFile::checksum(PATCH).unwrap();
    let mut followed = Followed::begin();
    let (names, state) = followed.look(0.0);
    assert_eq!((names.len(), state.phase, state.row), (0, Phase::Begun, None));
    for n in 0..200_u16 {
        let z_m = 0.003 - 3e-5 * f32::from(n);
        followed.add(&line(u32::from(n) * RECORD_TICKS, Mode::Active, z_m, 0.04, own));
        let (names, state) = followed.look(f64::from(n) * 0.002);
        assert_eq!(names.len(), usize::from(n == 0), "{names:?}");
        let frame = state.frame.unwrap();
        // the force that acts comes from the file, not from the patch
        assert_eq!((frame.force_n, state.row.unwrap().applied_n[2]), ([0.0, 0.0, 0.04], 0.04));
        assert_eq!(state.dots.len(), 1);
    }
    let (_, state) = followed.look(0.5);
    assert_eq!((state.phase, state.frame.is_none(), state.dots.len(), state.records), (Phase::Live, true, 0, [200, 0]));
    let answer = state.answer.unwrap();
    let twin_n = length(answer.force_n.unwrap());
    assert!(twin_n > 0.03 && (answer.differs_n.unwrap() - (twin_n - 0.1).abs()).abs() < 5e-3, "{answer:?}");
    assert_eq!(followed.look(9.0).1.phase, Phase::Silent);
}

#[test]
fn another_board_brings_another_patch_and_its_dots_are_its_own() {
    let own = PatchFile::checksum(PATCH).unwrap();
    let mut followed = Followed::begin();
    followed.add(&(line(RECORD_TICKS, Mode::Active, 0.002, 0.0, own) + &line(3 * RECORD_TICKS, Mode::Idle, 0.002, 0.0, own)));
    let (names, state) = followed.look(0.0);
    assert_eq!((names, state.records), (vec!["block-m4f-168".to_owned()], [2, 1]));
    let times: Vec<f64> = state.dots.iter().map(|dot| dot.t_s).collect();
    assert!((times[1] - times[0] - 2e-3 * f64::from(RECORD_TICKS)).abs() < 1e-9, "by the board's ticks: {times:?}");
    assert!(state.dots[0].twin_n.is_some() && state.dots[1].twin_n.is_none(), "an idle board has no patch that runs");
    followed.add(&line(4 * RECORD_TICKS, Mode::Active, 0.002, 0.0, own + 1));
    let (names, state) = followed.look(0.1);
    assert_eq!(names, ["block"], "one that does not ship");
    assert_eq!(state.answer.unwrap().differs_n, Err(super::super::twin::Apart::OtherPatch));
}
