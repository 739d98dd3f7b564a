//! `palpate live --follow` refuses a file that does not come from a board before it builds a
//! window, and waits for a file that does not exist yet.

use std::process::Command;

use palpate_loop::board_trace::COLUMNS;
use palpate_tests::palpate_command::{Desk, binary, repository};

/// Exit code and standard error of `palpate live` without a display and without a cargo that could
/// build the window.
fn live(desk: &Desk, arguments: &[&str]) -> (Option<i32>, String) {
    let mut command = Command::new(binary(env!("CARGO_TARGET_TMPDIR")));
    command.arg("live").args(arguments).current_dir(desk.folder()).env("CARGO", desk.folder().join("no-cargo"));
    let outcome = command.env_remove("WAYLAND_DISPLAY").env_remove("WAYLAND_SOCKET").env("DISPLAY", "").output().unwrap();
    assert!(outcome.stdout.is_empty(), "{}", String::from_utf8_lossy(&outcome.stdout));
    (outcome.status.code(), String::from_utf8_lossy(&outcome.stderr).into_owned())
}

#[test]
fn what_is_no_table_of_a_board_is_refused_in_a_line_before_anything_is_built() {
    let desk = Desk::default();
    desk.put("press.csv", "t_s,probe_x_m,probe_y_m\n0,0,0\n");
    desk.put("semicolons.csv", "tick;mode;fault\n1;0;0\n");
    desk.put("long.csv", vec![b'x'; 70_000]);
    desk.put("cut.patch", &std::fs::read(repository().join("firmware/patches/block-m4f-168.patch")).unwrap()[..5_000]);
    let fix = "give the file of `palpate board arm --stream FILE.csv`";
    for (arguments, says) in [
        (vec!["--follow", "press.csv"], ["press.csv:1: no record of a board: it has no column tick", fix]),
        (vec!["--follow", "semicolons.csv"], ["semicolons.csv:1: cells separated by semicolons", "save it with commas"]),
        (vec!["--follow", "long.csv"], ["long.csv:1: no record of a board: no line ends", fix]),
        (vec!["--follow", "."], [".: cannot be read: it is a folder", fix]),
        (vec!["--follow", "felt.csv", "--patch", "cut.patch"], ["cut.patch: ", "checksum"]),
        (vec!["--follow", "felt.csv", "--patch", "none.patch"], ["none.patch", "check the path"]),
        (vec!["--follow", "felt.csv", "--scene", "blok"], ["blok", "block"]),
    ] {
        let (code, why) = live(&desk, &arguments);
        assert_eq!((code, why.lines().count()), (Some(2), 1), "{arguments:?}: {why}");
        assert!(says.iter().all(|says| why.contains(says)), "{arguments:?}: {why}");
    }
}

#[test]
fn options_that_do_not_fit_are_refused() {
    let desk = Desk::default();
    for arguments in [
        &["--follow", "felt.csv", "--page"][..],
        &["--patch", "a.patch"],
        &["--follow", "felt.csv", "--patch", "a.patch", "--scene", "block"],
    ] {
        let (code, why) = live(&desk, arguments);
        assert!(code == Some(2) && !why.contains("no window"), "{arguments:?}: {why}");
    }
}

#[test]
fn a_file_that_may_become_one_is_waited_for() {
    let desk = Desk::default();
    let head = format!("{}\n", COLUMNS.join(","));
    for text in [None, Some(""), Some(&head[..20]), Some(head.as_str())] {
        if let Some(text) = text {
            desk.put("felt.csv", text);
        }
        // the file is accepted: only the display is missing
        let (code, why) = live(&desk, &["--follow", "felt.csv"]);
        assert_eq!(code, Some(2), "{why}");
        assert!(why.contains("no window: neither DISPLAY") && why.contains("start it on a desktop"), "{text:?}: {why}");
        assert!(!why.contains("--page"), "a page follows no file: {why}");
    }
}
