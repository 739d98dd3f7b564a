//! `palpate loop`, run as a user runs it: verdicts, files, refused input.

use palpate_tests::palpate_command::{Desk, palpate};

const SCRATCH: &str = env!("CARGO_TARGET_TMPDIR");

#[test]
fn a_wall_is_quiet_in_every_hand_and_its_files_say_so() {
    let desk = Desk::default();
    let outcome = palpate(SCRATCH, desk.folder(), &["loop", "--wall", "400", "--quick", "--out", "o"]);
    assert_eq!(outcome.code, Some(0), "{outcome:?}");
    let read = |name: &str| std::fs::read_to_string(desk.folder().join("o").join(name)).unwrap();
    let summary: serde_json::Value = serde_json::from_str(&read("summary.json")).unwrap();
    let runs = summary["runs"].as_array().unwrap();
    assert_eq!(runs.len(), 7 * 15);
    assert!(runs.iter().all(|r| r["verdict"] == "quiet"));
    assert_eq!(read("runs.csv").lines().count(), 1 + runs.len());
    let trace = read("trace.csv");
    assert!(
        trace.lines().count() > 1000
            && trace.lines().nth(1).unwrap().split(',').count() == trace.lines().next().unwrap().split(',').count()
    );
    for picture in ["force", "depth", "energy", "spectrum"] {
        for kind in ["svg", "png"] {
            assert!(desk.folder().join(format!("o/loop_{picture}.{kind}")).exists(), "{picture}.{kind}");
        }
    }
}

#[test]
fn a_loop_that_shakes_fails_the_command_and_leaves_its_trace() {
    let desk = Desk::default();
    let arguments = [
        "loop",
        "--wall",
        "3000",
        "--device",
        "frictionless",
        "--hand",
        "H0",
        "--stimulus",
        "S1-0.2",
        "--count-m",
        "0",
        "--out",
        "o",
    ];
    let outcome = palpate(SCRATCH, desk.folder(), &arguments);
    assert_eq!(outcome.code, Some(1), "{outcome:?}");
    assert!(outcome.stderr.contains("check failed: H0 S1-0.2: "), "{outcome:?}");
    assert!(desk.folder().join("o/trace.csv").exists() && desk.folder().join("o/loop_force.png").exists());
}

#[test]
fn what_no_device_is_and_what_leaves_it_is_refused() {
    let touch =
        std::fs::read_to_string(palpate_tests::palpate_command::repository().join("host-sim/devices/touch.toml")).unwrap();
    let desk = Desk::default();
    desk.put("heavy.toml", touch.replace("mass_kg = 0.045", "mass_kg = -0.045"));
    desk.put("small.toml", touch.replace("workspace_m = [0.16, 0.12, 0.12]", "workspace_m = [0.16, 0.12, 0.02]"));
    desk.put("typed.toml", touch.replace("friction_n", "fricton_n"));
    for (arguments, says) in [
        (["loop", "--device", "nope"].as_slice(), ["device \"nope\" is no profile", "give one of touch"]),
        (&["loop", "--device", "nope.toml"], ["nope.toml", "check the path"]),
        (&["loop", "--device", "heavy.toml"], ["heavy.toml:", "mass_kg = -0.045"]),
        (&["loop", "--device", "typed.toml"], ["typed.toml:", "fricton_n"]),
        (&["loop", "--wall", "400", "--device", "small.toml"], ["leave its workspace", "20 mm"]),
        (&["loop", "--hand", "H9"], ["--hand H9", "give one of H0"]),
        (&["loop", "--stimulus", "S99"], ["--stimulus S99", "give one of S1-0.05"]),
        (&["loop", "--wall", "-3"], ["--wall -3", "in that range"]),
        (&["loop", "--delay-ticks", "9"], ["delay_ticks = 9", "in that range"]),
        (&["loop", "--count-m", "nan"], ["count_m = NaN", "in that range"]),
        (&["loop", "--depth-m", "0.1"], ["--depth: 100 mm", "in that range"]),
        (&["loop", "--wll", "3"], ["unexpected argument '--wll'", "see --help"]),
        (&["loop", "--wall", "400", "--scene", "block"], ["cannot be used with '--scene", "see --help"]),
    ] {
        let before = desk.listing();
        let outcome = palpate(SCRATCH, desk.folder(), arguments);
        assert_eq!(outcome.code, Some(2), "{arguments:?}: {outcome:?}");
        assert!(says.iter().all(|s| outcome.stderr.contains(s)), "{arguments:?}: {outcome:?}");
        assert_eq!(outcome.stderr.lines().count(), 1, "{arguments:?}: {outcome:?}");
        assert_eq!(desk.listing(), before, "{arguments:?}: nothing is written");
    }
}
