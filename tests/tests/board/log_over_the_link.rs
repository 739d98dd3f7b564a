//! `palpate board` prints a board's log, which it decodes with the ELF file of the board's image.
//! If no file here matches, it says how to read the log.

use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::sync::OnceLock;

use palpate_board::EmulatedBoard;
use palpate_board::defmt_log;
use palpate_tests::board_on_a_port::{BoardOnAPort, Pace};
use palpate_tests::emulator::build_firmware;
use palpate_tests::palpate_command::{Desk, Outcome, binary, palpate, repository};

const SCRATCH: &str = env!("CARGO_TARGET_TMPDIR");
const PATIENT: Pace = Pace::ByHost(15);
/// Log lines of a board that has just started, in this order.
const START: [&str; 5] = [
    "INFO started after power-on or the reset button",
    "INFO no profile found: three axes, not homed",
    "INFO patch opened: 56 nodes, checksum ",
    "INFO mode self-test, was boot",
    "INFO mode idle, was self-test",
];
/// Opening a patch takes longer than a period; this line may come before or after its neighbours.
const LATE: &str = "WARN late since the start: 0 ticks, ";

fn image() -> &'static Path {
    static IMAGE: OnceLock<PathBuf> = OnceLock::new();
    IMAGE.get_or_init(|| build_firmware(Path::new(SCRATCH).parent().unwrap(), &[]).unwrap())
}

fn started() -> BoardOnAPort {
    let _built = (binary(SCRATCH), image());
    BoardOnAPort::start(image(), EmulatedBoard::M4f, PATIENT)
}

fn board(folder: &Path, on: &BoardOnAPort, arguments: &[&str]) -> Outcome {
    palpate(SCRATCH, folder, &[&["board"], arguments, &["--port", on.port()]].concat())
}

/// Log lines in a command's output, without their prefix.
fn logged(text: &str) -> Vec<&str> {
    text.lines().filter_map(|line| line.strip_prefix("log: ")).collect()
}

/// Checks that the lines contain these words, one entry per line and in this order. Lines about
/// missed periods are ignored.
fn says(lines: &[&str], words: &[&str]) {
    let lines: Vec<&&str> = lines.iter().filter(|line| !line.contains(LATE)).collect();
    let agree = lines.len() == words.len() && lines.iter().zip(words).all(|(line, words)| line.contains(words));
    assert!(agree, "{lines:#?} are not {words:#?}");
}

#[test]
fn a_board_tells_its_start_uploads_refusals_and_faults_once() {
    let (desk, on, elf) = (Desk::default(), started(), image().to_str().unwrap());
    let run = |arguments: &[&str]| board(desk.folder(), &on, &[arguments, &["--image", elf]].concat());
    // asks for the board's identity and does not read the log
    assert_eq!(palpate(SCRATCH, desk.folder(), &["board", "list", on.port()]).code, Some(0));
    let watched = run(&["watch", "--seconds", "2"]);
    assert_eq!(watched.code, Some(0), "{watched:?}");
    let lines = logged(&watched.stderr);
    says(&lines, &START);
    // each line begins with the board's time
    let times: Vec<f64> = lines.iter().map(|line| line.split(' ').next().unwrap().parse().unwrap()).collect();
    assert!(times.is_sorted() && times[0] >= 0.0, "{times:?}");

    let status = run(&["status"]);
    assert!(status.stdout.contains("log     nothing since it was last read") && logged(&status.stderr).is_empty(), "{status:?}");
    let refused = run(&["modulus", "9000"]);
    assert_eq!(refused.code, Some(2), "{refused:?}");
    says(&logged(&refused.stderr), &["WARN refused: ModulusOutOfRange", "INFO patch opened: 56 nodes"]);
    let patch = repository().join("firmware/patches/liver-m4f-168.patch");
    let sent = run(&["upload", patch.to_str().unwrap()]);
    let bytes = format!("INFO upload begun: {} bytes", std::fs::metadata(&patch).unwrap().len());
    says(&logged(&sent.stderr), &[&bytes, "INFO patch opened: 42 nodes, checksum "]);
    assert!(sent.stderr.contains(LATE), "{sent:?}");

    // the script's press, until the hand is moved far away
    let mut arm = Command::new(binary(SCRATCH));
    arm.args(["board", "arm", "--port", on.port(), "--image", elf]).current_dir(desk.folder());
    let arming = arm.stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    on.wait_for_force();
    on.hand_astray(true);
    let ended = arming.wait_with_output().unwrap();
    let text = String::from_utf8_lossy(&ended.stderr);
    let told = [
        "INFO mode arming, was idle",
        "INFO mode active, was arming",
        "ERROR fault 8: the probe moved too fast under force",
        "INFO mode fault, was active",
    ];
    assert_eq!(ended.status.code(), Some(1), "{text}");
    let lines = logged(&text);
    println!("{lines:#?}"); // at 4 ns per instruction; a line costs the time to the next
    says(&lines, &told);
    on.hand_astray(false);
    let status = run(&["status"]);
    assert!(status.stdout.contains("mode    fault") && status.stdout.contains("log     nothing since"), "{status:?}");
}

#[test]
fn without_the_image_the_lines_are_counted_and_a_wrong_one_is_named() {
    let (desk, on) = (Desk::default(), started());
    let status = board(desk.folder(), &on, &["status"]);
    assert_eq!(status.code, Some(0), "{status:?}");
    let says = format!("log     {} lines came and no image here explains them", START.len());
    assert!(status.stdout.contains(&says) && status.stdout.contains("--image ELF"), "{status:?}");

    let elf = std::fs::read(image()).unwrap();
    let board_s = defmt_log::checksum(&elf).unwrap().to_le_bytes();
    let mut other = elf.clone();
    let places: Vec<usize> = (0..elf.len() - 3).filter(|at| elf[*at..at + 4] == board_s).collect();
    places.iter().for_each(|at| other[*at] ^= 1);
    desk.put("other.elf", &other);
    desk.put("no.elf", "an ELF file begins otherwise");
    for (file, words) in [
        ("other.elf", "not the image that the board runs"),
        ("no.elf", "no image of palpate with a log"),
        ("missing.elf", "give the ELF file that was flashed"),
    ] {
        let outcome = board(desk.folder(), &on, &["status", "--image", file]);
        assert_eq!((outcome.code, outcome.stderr.lines().count()), (Some(2), 1), "{outcome:?}");
        assert!(outcome.stderr.contains(words) && outcome.stderr.contains(file), "{outcome:?}");
    }

    // the last image built is used if it matches the board's, and otherwise ignored
    let place = desk.folder().join("target/thumbv7em-none-eabihf/firmware");
    std::fs::create_dir_all(&place).unwrap();
    std::fs::create_dir_all(desk.folder().join("firmware")).unwrap();
    desk.put("firmware/Cargo.toml", "");
    desk.put("memory.x", "");
    for (built, words) in [(&elf, "WARN refused: ModulusOutOfRange"), (&other, "3 lines came and no image here")] {
        std::fs::write(place.join("palpate-firmware"), built).unwrap();
        let refused = palpate_in(&desk, &on, &["modulus", "9000"]);
        assert!(refused.code == Some(2) && logged(&refused.stderr).iter().any(|line| line.contains(words)), "{refused:?}");
    }
}

/// Runs a command in the desk's folder with cargo's default target folder.
fn palpate_in(desk: &Desk, on: &BoardOnAPort, arguments: &[&str]) -> Outcome {
    let mut command = Command::new(binary(SCRATCH));
    command.arg("board").args(arguments).args(["--port", on.port()]).current_dir(desk.folder());
    let output = command.env_remove("CARGO_TARGET_DIR").output().unwrap();
    let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
    Outcome { code: output.status.code(), stdout: text(&output.stdout), stderr: text(&output.stderr) }
}
