//! A user's steps with a paddle, by the commands of `firmware/controller/README.md`: store the
//! profile, declare the home pose, arm, feel a press of 4 mm.

use std::path::Path;

use palpate::haptic::mode::Mode;
use palpate_board::EmulatedBoard;
use palpate_sim::port::device_file;
use palpate_tests::board_on_a_port::{BoardOnAPort, Hand, Pace};
use palpate_tests::emulator::build_firmware;
use palpate_tests::palpate_command::{Desk, Outcome, binary, palpate, repository};

const SCRATCH: &str = env!("CARGO_TARGET_TMPDIR");

#[test]
fn the_guide_takes_at_most_ten_lines_and_its_patch_is_calibrated() {
    let guide = std::fs::read_to_string(repository().join("firmware/controller/README.md")).unwrap();
    let lines: Vec<&str> = guide.split("```sh\n").nth(1).unwrap().split("```").next().unwrap().lines().collect();
    assert!(lines.len() <= 10 && lines[1].contains(" -- fit --scene block "), "{lines:?}");
    let steps = lines.iter().filter_map(|line| line.split(" -- board ").nth(1)?.split(' ').next());
    assert_eq!(steps.collect::<Vec<_>>(), ["status", "profile", "home", "arm"], "those of the test below");
}

#[test]
fn a_paddle_is_given_its_profile_shown_its_home_pose_armed_and_felt() {
    let image = build_firmware(Path::new(SCRATCH).parent().unwrap(), &[]).unwrap();
    let _built = binary(SCRATCH);
    let file = repository().join("firmware/controller/devices/paddle.toml");
    let mechanism = device_file::load(file.to_str().unwrap()).unwrap().1.mechanism.unwrap();
    let desk = Desk::default();
    let on = BoardOnAPort::start_with(&image, EmulatedBoard::M4f, Pace::ByHost(15), Hand::Joints(mechanism));
    let board = |arguments: &[&str]| -> Outcome {
        palpate(SCRATCH, desk.folder(), &[&["board"], arguments, &["--port", on.port()]].concat())
    };
    let status = board(&["status", "--image", image.to_str().unwrap()]);
    assert!(status.code == Some(0) && status.stdout.contains("error   calibrated to finite elements"), "{status:?}");
    desk.put("weak.toml", std::fs::read_to_string(&file).unwrap().replace("full_scale_a = [2.0]", "full_scale_a = [0.2]"));
    let weak = board(&["profile", "--device", "weak.toml"]);
    assert!(weak.code == Some(2) && weak.stderr.contains("weak.toml: [mechanism]: the motors are too weak"), "{weak:?}");
    assert_eq!(weak.stderr.lines().count(), 1, "{weak:?}");

    // nobody holds the operator switch: the board stays idle, and the command does not wait forever
    desk.put("switch.toml", std::fs::read_to_string(&file).unwrap().replacen("axes = 1", "axes = 1\noperator_switch = true", 1));
    assert_eq!(board(&["profile", "--device", "switch.toml"]).code, Some(0));
    assert_eq!(board(&["home"]).code, Some(0));
    let idle = board(&["arm", "--seconds", "60", "--out", "idle.csv"]);
    assert!(idle.code == Some(2) && idle.stderr.contains("Hold the operator's switch"), "{idle:?}");
    assert_eq!(on.truth().largest_n, 0.0);

    let taken = board(&["profile", "--device", file.to_str().unwrap()]);
    assert!(taken.code == Some(0) && taken.stdout.contains("run `palpate board home"), "{taken:?}");
    let early = board(&["arm", "--seconds", "1"]);
    assert!(early.code == Some(2) && early.stderr.contains("the home pose is not known"), "{early:?}");
    let home = board(&["home"]);
    assert!(home.code == Some(0) && home.stdout.contains("the home pose is known"), "{home:?}");
    let armed = board(&["arm", "--seconds", "4", "--out", "press.csv"]);
    assert_eq!(armed.code, Some(0), "{armed:?}");
    let truth = on.truth();
    println!("{:.3} N at most; {}", truth.largest_n, armed.stdout);
    assert!(truth.largest_n > 0.1 && truth.mode() == Some(Mode::Idle) && truth.force_n() == 0.0, "{truth:?}");
    let csv = std::fs::read_to_string(desk.folder().join("press.csv")).unwrap();
    let head: Vec<&str> = csv.lines().next().unwrap().split(',').collect();
    let column = |name: &str| head.iter().position(|it| *it == name).unwrap();
    let rows: Vec<Vec<f64>> =
        csv.lines().skip(1).map(|row| row.split(',').map(|cell| cell.parse().unwrap_or(f64::NAN)).collect()).collect();
    let depth_m = rows.iter().map(|row| row[column("depth_m")]).fold(0.0, f64::max);
    assert!((3.5e-3..4.5e-3).contains(&depth_m), "{depth_m} m deep");
    // the paddle has one motor, so the other converters stay at zero
    assert!(rows.iter().any(|row| row[column("code_x")] > 100.0));
    assert!(rows.iter().all(|row| row[column("code_y")] == 0.0 && row[column("code_z")] == 0.0));
}
