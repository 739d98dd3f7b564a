//! C and C++ programs that use the library, compiled with this machine's compilers and run.

use std::path::{Path, PathBuf};
use std::process::Command;

use palpate::Vector3;
use palpate_loop::haptic_session::{HapticSession, Input};
use palpate_tests::c_compiler::{Language, compile, has, run};
use palpate_tests::palpate_command::repository;

const SANITIZERS: [&str; 2] = ["-fsanitize=address,undefined", "-fno-sanitize-recover=all"];

pub fn example(name: &str) -> PathBuf {
    repository().join("host-sim/bindings/examples").join(name)
}

pub fn source(name: &str) -> PathBuf {
    repository().join("tests/tests/bindings").join(name)
}

/// A small patch, because valgrind slows every instruction down.
fn patch() -> PathBuf {
    repository().join("firmware/patches/block-m4f-168.patch")
}

/// An armed session, opened as in the examples.
pub fn session() -> HapticSession {
    let mut session = HapticSession::open("block", None, "touch").unwrap();
    session.arm().unwrap();
    session
}

pub fn force_n(session: &mut HapticSession, tip_m: [f64; 3]) -> [u32; 3] {
    let record = session.tick(&Input::at(Vector3::from(tip_m).cast()));
    assert_eq!(record.fault, None);
    record.applied_n.map(f32::to_bits).into()
}

pub fn numbers(line: &str) -> Vec<f64> {
    line.split_whitespace().filter_map(|word| word.parse().ok()).collect()
}

pub fn bits(force_n: &[f64]) -> [u32; 3] {
    std::array::from_fn(|k| (force_n[k] as f32).to_bits())
}

#[test]
fn a_press_in_c_equals_rust_to_the_bit_and_sanitizers_find_nothing() {
    if !Language::C.is_here() {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let (mut own, file) = (session(), example("press.c"));
    assert!(std::fs::read_to_string(&file).unwrap().lines().count() < 40, "the example is short");
    let said = run(&mut Command::new(compile(&file, folder.path(), "press", true, &SANITIZERS)));
    let site_m: [f64; 3] = own.tissue().patch().site_m().cast().into();
    let axis: [f64; 3] = own.tissue().params().probe.axis.cast().into();
    let (mut lines, mut deepest_n) = (said.lines(), 0.0_f64);
    for tick in 0..2500_i32 {
        let steps = if tick < 700 { 0 } else { (tick - 700).min(2500 - tick) };
        let depth_m = 1e-5 * f64::from(steps) - 5e-3;
        let found = force_n(&mut own, std::array::from_fn(|k| site_m[k] - axis[k] * depth_m));
        if tick % 100 == 99 {
            let line = numbers(lines.next().unwrap());
            assert_eq!((line[0], bits(&line[2..])), (f64::from(tick + 1), found), "tick {tick}");
            deepest_n = deepest_n.max(line[4]);
        }
    }
    assert!(lines.next().is_none() && deepest_n > 0.1, "{deepest_n} N at the deepest");
}

#[test]
fn a_servo_callback_in_cpp_equals_rust_to_the_bit() {
    if !Language::Cpp.is_here() {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let program = compile(&example("servo.cpp"), folder.path(), "servo", true, &[]);
    let said = run(Command::new(program).args(["fast", "trace"]));
    let (mut own, mut felt) = (session(), 0);
    assert_eq!(said.lines().count(), 2500);
    for (tick, line) in said.lines().map(numbers).enumerate() {
        let found = force_n(&mut own, [line[0], line[1], line[2]]);
        assert_eq!(bits(&line[3..]), found, "tick {tick}");
        felt += usize::from(line[5] > 0.01);
    }
    assert!(felt > 500, "felt in {felt} ticks");
}

#[test]
fn misuse_gives_codes_and_sanitizers_find_nothing() {
    if !Language::C.is_here() {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let program = compile(&source("misuse.c"), folder.path(), "misuse", true, &SANITIZERS);
    let said = run(Command::new(program).arg(patch()));
    assert_eq!(said, "0 wrong\n");
}

#[test]
fn valgrind_finds_no_error_and_no_lost_memory() {
    if !Language::C.is_here() || !has("valgrind", "--version", "memory is judged by the sanitizers alone") {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let program = compile(&source("misuse.c"), folder.path(), "misuse", true, &[]);
    let suppressions = repository().join("host-sim/bindings/valgrind.supp");
    let said = run(Command::new("valgrind")
        .args(["--quiet", "--leak-check=full", "--show-leak-kinds=definite,indirect,possible", "--error-exitcode=3"])
        .arg(format!("--suppressions={}", suppressions.display()))
        .arg(program)
        .arg(patch()));
    assert_eq!(said, "0 wrong\n");
}

#[test]
#[cfg(target_os = "linux")]
fn ticks_over_the_boundary_allocate_nothing() {
    if !Language::C.is_here() {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let wraps = ["-Wl,--wrap=malloc", "-Wl,--wrap=calloc", "-Wl,--wrap=realloc", "-Wl,--wrap=posix_memalign"];
    let program = compile(&source("allocations.c"), folder.path(), "allocations", true, &wraps);
    let said = run(Command::new(program).arg(patch()));
    assert!(said.ends_with(" allocations when opened, 0 afterwards, pressed\n"), "{said}");
    assert!(!said.starts_with("0 "), "the count counts: {said}");
}

/// Each adapter also presses with a fake device library, which then fails: the force is zero, and
/// the program says which fault it was.
#[test]
fn adapters_compile_against_our_stubs() {
    if !Language::Cpp.is_here() {
        return;
    }
    let (folder, fake) = (tempfile::tempdir().unwrap(), source("fake_devices.cpp"));
    let clock = format!("-I{}", source("").display());
    let clock = ["-DADAPTER_CLOCK=FakeClock", "-include", "fake_clock.h", &clock];
    let late = "ticks ended too late";
    for (name, device, stopped) in [
        ("touch", "touch", "sensor"),
        ("omega", "omega3", "sensor"),
        ("inverse3", "inverse3", late),
        ("chai3d", "chai3d", "sensor"),
    ] {
        let file = example("adapters").join(name).with_extension("cpp");
        assert!(std::fs::read_to_string(&file).unwrap().contains("UNTESTED ON A DEVICE"), "{name}");
        let program = compile(&file, folder.path(), name, true, &[&clock[..], &[&fake.display().to_string()]].concat());
        // the last argument is the profile of your own device
        let own = ["PORT", "block", "mine.toml"];
        let refused = Command::new(&program).args(if name == "inverse3" { &own[..] } else { &own[1..] }).output().unwrap();
        assert!(String::from_utf8_lossy(&refused.stderr).contains("cannot read mine.toml"), "{name}: {refused:?}");
        for (does, says) in [("nothing", "ended"), ("late", late), ("stops", stopped), ("jumps", "moved too fast")] {
            let ended = Command::new(&program).env("FAKE", does).output().unwrap();
            let said = String::from_utf8_lossy(&ended.stdout);
            let why = said
                .lines()
                .find(|line| line.starts_with(&format!("{device}: ")) && !line.contains("Ctrl-C"))
                .unwrap_or_default();
            assert!(why.contains(says), "{name} {does}: {ended:?}");
            assert_eq!(ended.status.code(), Some(i32::from(does != "nothing")), "{name} {does}: {ended:?}");
            let forces = numbers(said.lines().find(|line| line.starts_with("before")).unwrap_or_default());
            assert!(forces[0] > 0.05 && (forces[1] > 0.0) == (does == "nothing"), "{name} {does}: {ended:?}");
            assert!(String::from_utf8_lossy(&ended.stderr).contains("0.5 N"), "cautions: {ended:?}");
        }
    }
}

/// The object of a CHAI3D world: forces, and the vertices that it draws.
#[test]
fn the_object_of_chai3d_equals_rust_to_the_bit() {
    if !Language::Cpp.is_here() {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let adapters = format!("-I{}", example("adapters").display());
    let program = compile(&source("chai3d_press.cpp"), folder.path(), "press", true, &[&SANITIZERS[..], &[&adapters]].concat());
    let said = run(&mut Command::new(program));
    let (mut own, mut felt) = (session(), 0);
    let (ticks, drawn) = said.trim_end().rsplit_once('\n').unwrap();
    assert_eq!(ticks.lines().count(), 1600);
    let site_m: [f64; 3] = own.tissue().patch().site_m().cast().into();
    for (tick, line) in ticks.lines().map(numbers).enumerate() {
        let found = force_n(&mut own, std::array::from_fn(|k| line[k] + site_m[k]));
        assert_eq!(bits(&line[3..]), found, "tick {tick}");
        felt += usize::from(line[5] > 0.01);
    }
    assert!(felt > 250, "felt in {felt} ticks");
    // the last tick is a multiple of 16, so the mesh shows the nodes as they are now
    let nodes = own.tissue().nodes().iter().map(|node| f64::from(node.position_m().z) - site_m[2]);
    let squares = nodes.fold(0.0, |sum, z_m| sum + z_m * z_m);
    let (model, drawn) = (own.tissue().patch().model(), numbers(drawn));
    assert_eq!(drawn, [model.nodes.len() as f64, model.triangles.len() as f64, squares]);
}

#[test]
#[ignore = "long: cargo builds the library anew in a folder of its own, a minute or two"]
fn cmake_builds_library_and_examples() {
    if !has("cmake", "--version", "the CMake file is not tested: pip install cmake, or the system's package") {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let own = |arguments: &[&str], path: &Path| run(Command::new("cmake").args(arguments).arg(path).current_dir(folder.path()));
    let _configured = own(&["-S", &repository().join("host-sim/bindings").display().to_string(), "-B"], folder.path());
    let _built = own(&["--build"], folder.path());
    let said = run(&mut Command::new(folder.path().join("press")));
    assert_eq!(said.lines().count(), 25);
}
