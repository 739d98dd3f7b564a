//! The Python package, installed from its folder into a new virtual environment.

use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::OnceLock;

use palpate::Vector3;
use palpate_loop::haptic_session::{HapticSession, Input};
use palpate_tests::c_compiler::run;
use palpate_tests::palpate_command::repository;
use palpate_tissue::press;
use palpate_tissue::scene::Scene;
use palpate_tissue::session::Session;

/// Python with the package installed; `None`, with a message, if that is not possible.
fn python() -> Option<&'static Path> {
    static INSTALLED: OnceLock<Option<PathBuf>> = OnceLock::new();
    INSTALLED.get_or_init(install).as_deref()
}

fn install() -> Option<PathBuf> {
    let scratch = Path::new(env!("CARGO_TARGET_TMPDIR"));
    let (environment, package) = (scratch.join("python"), repository().join("host-sim/bindings/python"));
    let python = environment.join("bin/python");
    let enough = "import sys; sys.exit(sys.version_info < (3, 10))";
    if !tried(Command::new("python3").args(["-c", enough]), "Python 3.10 or later is not on this machine") {
        return None;
    }
    let tools = ["-m", "pip", "install", "--quiet", "--disable-pip-version-check", "numpy>=1.23", "maturin>=1.9,<2"];
    let equipped = Command::new(&python).args(["-c", "import numpy, maturin"]).output().is_ok_and(|found| found.status.success());
    let equip = || {
        tried(Command::new("python3").args(["-m", "venv"]).arg(&environment), "this Python makes no environments")
            && tried(Command::new(&python).args(tools), "numpy and maturin cannot be installed")
    };
    if !equipped && !equip() {
        return None;
    }
    let manifest = package.join("Cargo.toml");
    let fetch = ["fetch", "--locked", "--quiet", "--manifest-path"];
    if !tried(Command::new("cargo").args(fetch).arg(&manifest), "crates of the package cannot be had") {
        return None;
    }
    let path =
        std::env::join_paths([environment.join("bin")].into_iter().chain(std::env::split_paths(&std::env::var_os("PATH")?)));
    let _installed = run(Command::new(&python)
        .args(["-m", "pip", "install", "--quiet", "--disable-pip-version-check"])
        .args(["--no-build-isolation", "--no-deps", "--force-reinstall"])
        .arg(&package)
        .env("PATH", path.ok()?)
        // the target folder of the tests, so that compiled libraries are shared
        .env("CARGO_TARGET_DIR", scratch.parent()?));
    Some(python)
}

fn tried(command: &mut Command, without: &str) -> bool {
    let done = command.output();
    if done.as_ref().is_ok_and(|output| output.status.success()) {
        return true;
    }
    let why = done.map_or_else(|error| error.to_string(), |output| String::from_utf8_lossy(&output.stderr).trim().into());
    println!("skipped: {without}, so the Python package is not tested ({})", why.lines().last().unwrap_or_default());
    false
}

fn script(name: &str) -> PathBuf {
    repository().join("tests/tests/bindings").join(name)
}

fn bits(words: &[&str]) -> Vec<u32> {
    words.iter().map(|word| (word.parse::<f64>().unwrap() as f32).to_bits()).collect()
}

fn vector_bits(v: Vector3<f32>) -> Vec<u32> {
    v.iter().map(|c| c.to_bits()).collect()
}

#[test]
fn a_loop_and_a_press_in_python_equal_rust_to_the_bit() {
    let Some(python) = python() else { return };
    let said = run(Command::new(python).arg(script("trace.py")));
    let lines: Vec<Vec<&str>> = said.lines().map(|line| line.split(' ').collect()).collect();
    let rows = |name: &str| lines.iter().filter(|line| line[0] == name).map(|line| &line[1..]).collect::<Vec<_>>();

    let mut session = HapticSession::open("block", None, "touch").unwrap();
    session.arm().unwrap();
    let mut felt = 0;
    assert_eq!(rows("tick").len(), 2500);
    for (tick, row) in rows("tick").iter().enumerate() {
        let tip_m: Vec<f64> = row[..3].iter().map(|word| word.parse().unwrap()).collect();
        let record = session.tick(&Input::at(Vector3::from_row_slice(&tip_m).cast()));
        assert_eq!(vector_bits(record.applied_n), bits(&row[3..]), "tick {tick}");
        felt += usize::from(record.applied_n.z > 0.1);
    }
    assert!(felt > 100, "felt in {felt} ticks");
    assert_eq!(rows("state"), [[session.hash().to_string()]]);

    let scene = Scene::load("block").unwrap();
    let pressed = press::run(&scene, &Session::prepare(&scene).unwrap(), |_| ()).unwrap();
    let forces: Vec<Vec<u32>> = pressed.ticks.iter().map(|row| vector_bits(row.output.force_n)).collect();
    assert_eq!(rows("press").into_iter().map(bits).collect::<Vec<_>>(), forces);
    assert_eq!(rows("pressed"), [[pressed.state_hash.to_string()]]);
}

/// The ROS 2 node, with stand-ins of rclpy and of the messages.
#[test]
fn a_press_through_the_ros_node_equals_rust_to_the_bit() {
    let Some(python) = python() else { return };
    let node = repository().join("host-sim/bindings/python/examples/ros2_node.py");
    assert!(std::fs::read_to_string(&node).unwrap().contains("UNTESTED WITH ROS"));
    let said = run(Command::new(python).arg(script("ros2_press.py")).arg(node));
    let lines: Vec<&str> = said.lines().collect();
    let (ticks, end) = lines.split_at(2500);
    let mut session = HapticSession::open("block", None, "touch").unwrap();
    session.arm().unwrap();
    let (site_m, mut felt): (Vector3<f64>, _) = (session.tissue().patch().site_m().cast(), 0);
    for (tick, line) in ticks.iter().enumerate() {
        let words: Vec<&str> = line.split(' ').collect();
        let tip_m = site_m + Vector3::from_iterator(words[..3].iter().map(|word| word.parse::<f64>().unwrap()));
        let record = session.tick(&Input::at(tip_m.cast()));
        assert_eq!(vector_bits(record.applied_n), bits(&words[3..6]), "tick {tick}");
        felt += usize::from(record.applied_n.z > 0.1);
    }
    assert!(felt > 100, "felt in {felt} ticks");
    assert!(end[0].starts_with("gap 0.0 0.0 [") && end[0].contains("ticks ended too late"), "{end:?}");
    assert!(end[2].starts_with("frame [") && end[2].contains("sensor cannot be trusted"), "{end:?}");
    // an orientation that is none is named once, and the ticks go on
    assert_eq!(end[3], "turn [0.001, 0.002, 0.005] [0.001, 0.002, 0.005] 1 True");
    assert_eq!([end[1], end[4]], ["cleared None True", "end ['destroyed', 'shut down']"]);
}

#[test]
fn misuse_of_the_package_raises_and_says_why() {
    let Some(python) = python() else { return };
    let patch = repository().join("firmware/patches/block-m4f-168.patch");
    assert_eq!(run(Command::new(python).arg(script("misuse.py")).arg(patch)), "0 wrong\n");
}

#[test]
fn the_example_runs_and_so_do_the_notebook_s_cells() {
    let Some(python) = python() else { return };
    let examples = repository().join("host-sim/bindings/python/examples");
    let said = run(Command::new(python).arg(examples.join("press.py")));
    assert_eq!(said.lines().count(), 25);
    let deepest = said.lines().find(|line| line.starts_with("1600 ms")).unwrap();
    assert!(deepest.contains("0.14") && deepest.ends_with("active"), "{deepest}");

    // the last cell is left out: it draws with matplotlib, a large package
    let notebook: serde_json::Value =
        serde_json::from_str(&std::fs::read_to_string(examples.join("press.ipynb")).unwrap()).unwrap();
    let cells = notebook["cells"].as_array().unwrap().iter().filter(|cell| cell["cell_type"] == "code");
    let text =
        |cell: &serde_json::Value| cell["source"].as_array().unwrap().iter().filter_map(|l| l.as_str()).collect::<String>();
    let code: Vec<String> = cells.map(text).filter(|code| !code.contains("matplotlib")).collect();
    assert_eq!(code.len(), 2, "the notebook has other cells");
    let asked = format!("{}\nprint(max(traces[1.0]), max(traces[1.5]))", code.join("\n"));
    let said = run(Command::new(python).args(["-c", &asked]));
    let peaks_n: Vec<f64> = said.split_whitespace().map(|word| word.parse().unwrap()).collect();
    let ratio = peaks_n[1] / peaks_n[0];
    assert!((1.4..1.6).contains(&ratio), "half as stiff again, force times {ratio}");
}
