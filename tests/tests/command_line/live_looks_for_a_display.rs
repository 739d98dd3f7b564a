//! `palpate live` without a display ends before it builds a window.

use std::process::Command;

use palpate_tests::palpate_command::binary;

#[test]
fn without_a_display_nothing_is_built_and_one_line_names_the_page() {
    let folder = tempfile::tempdir().unwrap();
    for (display, says) in [("", "neither DISPLAY nor WAYLAND_DISPLAY is set"), (":4711", "DISPLAY=:4711 does not answer")] {
        let outcome = Command::new(binary(env!("CARGO_TARGET_TMPDIR")))
            .arg("live")
            .current_dir(folder.path())
            .env_remove("WAYLAND_DISPLAY")
            .env_remove("WAYLAND_SOCKET")
            .env("DISPLAY", display)
            // starting a build would give another error message
            .env("CARGO", folder.path().join("no-cargo"))
            .output()
            .unwrap();
        let (said, why) = (String::from_utf8_lossy(&outcome.stdout), String::from_utf8_lossy(&outcome.stderr));
        assert!(outcome.status.code() == Some(2) && said.is_empty() && why.lines().count() == 1, "{said}{why}");
        assert!(why.contains(says) && why.contains("`palpate live --page`") && !why.contains("building"), "{why}");
    }
}
