//! An output folder contains one complete result, even after a kill, a second run or a full disk,
//! and beside files that do not belong to it.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use palpate_tests::palpate_command::{Desk, binary, is_progress, palpate, repository};
use palpate_tests::press_run::{SMALL_BLOCK, edited};
use palpate_tissue::output::OutputFolder;

const SCRATCH: &str = env!("CARGO_TARGET_TMPDIR");
const PRESS: [&str; 5] = ["press", "--scene", "scene.toml", "--out", "out"];

/// Path and bytes of every file below a folder.
fn content(folder: &Path) -> BTreeMap<PathBuf, Vec<u8>> {
    let mut found = BTreeMap::new();
    for entry in std::fs::read_dir(folder).into_iter().flatten().flatten() {
        let path = entry.path();
        if path.is_dir() {
            found.extend(content(&path));
        } else {
            found.insert(path.clone(), std::fs::read(path).unwrap_or_default());
        }
    }
    found
}

/// A desk on which the small scene has been pressed into `out`, and the files there.
fn pressed() -> (Desk, BTreeMap<PathBuf, Vec<u8>>) {
    let desk = Desk::default();
    desk.put("scene.toml", SMALL_BLOCK);
    let outcome = palpate(SCRATCH, desk.folder(), &PRESS);
    assert_eq!((outcome.code, outcome.stderr.as_str()), (Some(0), ""));
    let result = content(&desk.folder().join("out"));
    assert!(result.len() > 10, "{:?}", result.keys());
    (desk, result)
}

#[cfg(unix)]
#[test]
fn ctrl_c_ends_a_run_with_one_line_about_what_stays() {
    let (desk, earlier) = pressed();
    desk.put("scene.toml", edited(SMALL_BLOCK, "hold_s = 0.3", "hold_s = 30.0"));
    for (out, says) in [("out", "out is as it was before this run"), ("new", "new was not written")] {
        let mut command = Command::new(binary(SCRATCH));
        command.args(["press", "--scene", "scene.toml", "--out", out]).current_dir(desk.folder());
        let mut run = command.stdout(Stdio::null()).stderr(Stdio::piped()).spawn().expect("palpate was built");
        assert!(until(&mut run, || desk.folder().join(format!(".{out}.draft")).exists()));
        let killed = Command::new("kill").args(["-INT", &run.id().to_string()]).status().unwrap();
        let ended = run.wait_with_output().unwrap();
        let why = String::from_utf8_lossy(&ended.stderr);
        assert!(killed.success() && ended.status.code() == Some(130) && why.contains(says), "{why}");
    }
    assert_eq!(content(&desk.folder().join("out")), earlier);
}

/// Starts `palpate` and does not wait for it.
fn start(desk: &Desk, arguments: &[&str]) -> Child {
    let mut command = Command::new(binary(SCRATCH));
    command.args(arguments).current_dir(desk.folder()).stdout(Stdio::null()).stderr(Stdio::null());
    command.spawn().expect("palpate was built")
}

/// Waits until a condition is met; returns false if the run ends first.
fn until(run: &mut Child, so: impl Fn() -> bool) -> bool {
    let begun = Instant::now();
    while begun.elapsed() < Duration::from_secs(120) {
        if so() {
            return true;
        }
        if run.try_wait().expect("it is our child").is_some() {
            return false;
        }
        std::thread::sleep(Duration::from_micros(200));
    }
    panic!("nothing happened in two minutes");
}

/// A scene with stiffer tissue and two holds: its numbers differ, and it gives one file fewer.
fn other_scene() -> String {
    edited(&edited(SMALL_BLOCK, "3500.0", "5000.0"), "[0.001, 0.002, 0.004]", "[0.001, 0.003]")
}

#[test]
fn a_run_that_is_killed_leaves_the_earlier_result_whole() {
    let (desk, earlier) = pressed();
    desk.put("scene.toml", other_scene());
    let out = desk.folder().join("out");
    // counts a run's files wherever the run puts them: in the folder itself or beside it
    let written = || {
        let beside = content(desk.folder());
        beside.iter().filter(|(path, bytes)| !path.ends_with("scene.toml") && earlier.get(*path) != Some(*bytes)).count()
    };
    let mut killed = 0;
    for files in [1, 2, 3, 5, 8, 12] {
        let mut run = start(&desk, &PRESS);
        let in_time = until(&mut run, || written() >= files);
        run.kill().expect("SIGKILL");
        run.wait().expect("it ended");
        let left = content(&out);
        if left.get(&out.join("summary.json")) != earlier.get(&out.join("summary.json")) && left.len() == earlier.len() - 1 {
            // it finished before the signal: restore the earlier result and continue
            desk.put("scene.toml", SMALL_BLOCK);
            assert_eq!(palpate(SCRATCH, desk.folder(), &PRESS).code, Some(0));
            desk.put("scene.toml", other_scene());
            continue;
        }
        killed += usize::from(in_time);
        let changed: Vec<_> = left.keys().chain(earlier.keys()).filter(|path| left.get(*path) != earlier.get(*path)).collect();
        assert!(changed.is_empty(), "killed after {files} files, {changed:?} are not the earlier run's");
    }
    assert!(killed >= 3, "only {killed} runs were killed while they wrote");

    // the next run removes what the killed one left and replaces the whole result: the third hold
    // is gone
    let outcome = palpate(SCRATCH, desk.folder(), &PRESS);
    assert_eq!((outcome.code, outcome.stderr.as_str()), (Some(0), ""));
    assert_eq!(desk.listing(), ["out", "scene.toml"]);
    let now = content(&out);
    assert!(now.keys().all(|path| !path.ends_with("surface_2.csv")) && now.len() == earlier.len() - 1, "{:?}", now.keys());
}

#[test]
fn a_second_run_into_the_same_folder_is_refused_at_once() {
    let desk = Desk::default();
    desk.put("scene.toml", edited(SMALL_BLOCK, "hold_s = 0.3", "hold_s = 30.0"));
    let mut first = start(&desk, &PRESS);
    assert!(until(&mut first, || desk.listing().len() > 1), "the first run ended before it began to write");
    for out in ["out", "./out", "out/"] {
        let begun = Instant::now();
        let second = palpate(SCRATCH, desk.folder(), &["press", "--scene", "scene.toml", "--out", out]);
        assert_eq!(second.code, Some(2), "{second:?}");
        assert!(second.stderr.lines().count() == 1 && second.stderr.contains(": another run of palpate"), "{second:?}");
        assert!(second.stderr.contains("--out") && second.stdout.is_empty(), "{second:?}");
        println!("refused after {:?}", begun.elapsed());
    }
    // a run into another folder is allowed
    desk.put("short.toml", SMALL_BLOCK);
    let beside = palpate(SCRATCH, desk.folder(), &["press", "--scene", "short.toml", "--out", "beside"]);
    assert_eq!((beside.code, beside.stderr.as_str()), (Some(0), ""));
    assert!(first.try_wait().unwrap().is_none(), "the first run ended while it should hold the folder");
    assert!(first.wait().unwrap().success());
    assert_eq!(desk.listing(), ["beside", "out", "scene.toml", "short.toml"]);
    assert_eq!(content(&desk.folder().join("out")).len(), content(&desk.folder().join("beside")).len());
}

/// `sh` limits the size of a file, in blocks of 512 or 1024 bytes. Writing beyond it fails, as on a
/// full disk.
#[cfg(unix)]
#[test]
fn a_full_disk_leaves_the_earlier_result_whole() {
    let (desk, earlier) = pressed();
    // with few rows the tables are within the limit, but the pictures are not
    let short = edited(&other_scene(), "hold_s = 0.3", "hold_s = 0.01");
    desk.put("scene.toml", edited(&short, "ramp_m_per_s = 0.04", "ramp_m_per_s = 0.2"));
    let out = desk.folder().join("out");
    let program = binary(SCRATCH).display();
    let line = format!("trap '' XFSZ; ulimit -f 90; exec '{program}' press --scene scene.toml --out out");
    let run = Command::new("sh").args(["-c", &line]).current_dir(desk.folder()).output().expect("sh starts");
    let stderr = String::from_utf8_lossy(&run.stderr);
    assert_eq!(run.status.code(), Some(2), "{stderr}");
    let told: Vec<&str> = stderr.lines().filter(|line| !is_progress(line)).collect();
    assert!(told.len() == 1 && told[0].contains("cannot write") && told[0].contains("--out"), "{stderr}");
    let left = content(&out);
    let changed: Vec<_> = left.keys().chain(earlier.keys()).filter(|path| left.get(*path) != earlier.get(*path)).collect();
    assert!(changed.is_empty(), "{changed:?} are not the earlier run's");
    assert_eq!(desk.listing(), ["out", "scene.toml"]);
}

#[test]
fn files_of_others_stay_and_a_folder_of_others_is_refused() {
    let (desk, _) = pressed();
    let out = desk.folder().join("out");
    desk.put("out/notes.txt", "mine");
    desk.put("out/kept.patch", "not packed by palpate");
    std::fs::create_dir(out.join("views")).unwrap();
    desk.put("out/views/top.pvsm", "mine too");
    desk.put("scene.toml", other_scene());
    let outcome = palpate(SCRATCH, desk.folder(), &PRESS);
    assert_eq!((outcome.code, outcome.stderr.as_str()), (Some(0), ""));
    for (name, text) in [("notes.txt", "mine"), ("kept.patch", "not packed by palpate"), ("views/top.pvsm", "mine too")] {
        assert_eq!(std::fs::read_to_string(out.join(name)).unwrap(), text);
    }
    assert!(!out.join("surface_2.csv").exists() && out.join("surface_1.csv").exists());

    // a folder that has the name of one of the files cannot be replaced: nothing is lost or changed
    std::fs::remove_file(out.join("trace.csv")).unwrap();
    std::fs::create_dir(out.join("trace.csv")).unwrap();
    desk.put("out/trace.csv/mine.txt", "mine");
    let before = content(&out);
    let refused = palpate(SCRATCH, desk.folder(), &PRESS);
    assert_eq!(refused.code, Some(2), "{refused:?}");
    assert!(refused.stderr.contains("trace.csv is a folder") && content(&out) == before, "{refused:?}");

    // a folder that never contained a result
    std::fs::create_dir(desk.folder().join("thesis")).unwrap();
    desk.put("thesis/summary.json", "mine");
    let refused = palpate(SCRATCH, desk.folder(), &["press", "--scene", "scene.toml", "--out", "thesis"]);
    assert_eq!((refused.code, refused.stdout.as_str()), (Some(2), ""), "{refused:?}");
    assert!(refused.stderr.lines().count() == 1 && refused.stderr.contains("thesis: it holds \"summary.json\""), "{refused:?}");
    assert_eq!(content(&desk.folder().join("thesis")).len(), 1);
    assert_eq!(std::fs::read_to_string(desk.folder().join("thesis/summary.json")).unwrap(), "mine");

    // a patch is a result of its own: it is added, and the next press keeps it
    let pack =
        |out: &str| palpate(SCRATCH, desk.folder(), &["pack", "--scene", "scene.toml", "--board", "desktop", "--out", out]);
    assert_eq!([pack("thesis").code, pack("new").code], [Some(0), Some(0)]);
    assert_eq!(std::fs::read_to_string(desk.folder().join("thesis/summary.json")).unwrap(), "mine");
    let again = palpate(SCRATCH, desk.folder(), &["press", "--scene", "scene.toml", "--out", "new"]);
    assert_eq!((again.code, again.stderr.as_str()), (Some(0), ""));
    assert!(["thesis", "new"].iter().all(|out| desk.folder().join(out).join("small-desktop.patch").is_file()));
}

#[test]
fn a_folder_that_cannot_be_replaced_is_refused_before_anything_is_computed() {
    let desk = Desk::default();
    desk.put("scene.toml", SMALL_BLOCK);
    let mut places = vec![".", "/"];
    if cfg!(target_os = "linux") {
        places.extend(["/proc", "/proc/palpate/out"]);
    }
    for out in places {
        let refused = palpate(SCRATCH, desk.folder(), &["press", "--scene", "scene.toml", "--out", out]);
        assert_eq!((refused.code, refused.stdout.as_str()), (Some(2), ""), "{out}: {refused:?}");
        assert!(refused.stderr.lines().count() == 1 && refused.stderr.contains("--out"), "{out}: {refused:?}");
        assert_eq!(desk.listing(), ["scene.toml"], "{out}");
    }
    // after bad input not even the parent folders are created
    desk.put("scene.toml", edited(SMALL_BLOCK, "nodes = 129", "nodes = 129\nmesh = \"none.msh\""));
    assert_eq!(palpate(SCRATCH, desk.folder(), &["fit", "--scene", "scene.toml", "--out", "a/b/c"]).code, Some(2));
    assert_eq!(desk.listing(), ["scene.toml"]);
    // a folder whose parent folders do not exist yet
    desk.put("scene.toml", SMALL_BLOCK);
    let deep = palpate(SCRATCH, desk.folder(), &["press", "--scene", "scene.toml", "--out", "a/b/c"]);
    assert_eq!((deep.code, deep.stderr.as_str()), (Some(0), ""));
    assert!(desk.folder().join("a/b/c/summary.json").is_file());
    assert_eq!(std::fs::read_dir(desk.folder().join("a/b")).unwrap().count(), 1);
}

fn write(out: &Path, force: &str, names: &[&str]) {
    let folder = OutputFolder::open(out).unwrap();
    names.iter().for_each(|name| folder.write(name, force.as_bytes()).unwrap());
    folder.publish().unwrap();
}

/// All states in which a kill can leave the folder and its neighbours, and the result after the
/// next run.
#[test]
fn a_run_restores_the_result_whenever_the_one_before_was_killed() {
    let earlier = &["force.csv", "force.svg", "surface_2.csv"];
    let later = &["force.csv", "force.svg"];
    // places of the earlier and the later result, and which of them is the result afterwards
    let states = [
        (Some("out"), None, "1 N"),
        (Some("out"), Some(".out.draft"), "1 N"),
        (Some(".out.old"), Some(".out.draft"), "1 N"),
        (Some(".out.old"), Some("out"), "2 N"),
        (Some(".out.draft"), Some("out"), "2 N"),
        (None, Some(".out.draft"), ""),
    ];
    for (first, second, force) in states {
        let desk = Desk::default();
        let at = |name: &str| desk.folder().join(name);
        write(&at("out"), "1 N", earlier);
        // the earlier result's copy has the same record; the later result has a higher run number
        std::fs::create_dir(at("copy")).unwrap();
        content(&at("out"))
            .iter()
            .for_each(|(path, bytes)| std::fs::write(at("copy").join(path.file_name().unwrap()), bytes).unwrap());
        write(&at("out"), "2 N", later);
        std::fs::rename(at("out"), at("later")).unwrap();
        desk.put("copy/notes.txt", "mine");
        for (from, to) in [("copy", first), ("later", second)] {
            match to {
                Some(to) => std::fs::rename(at(from), at(to)).unwrap(),
                None => std::fs::remove_dir_all(at(from)).unwrap(),
            }
        }
        drop(OutputFolder::open(&at("out")).unwrap());
        let state = format!("{first:?} {second:?}");
        if force.is_empty() {
            assert_eq!(desk.listing(), [""; 0], "{state}");
            continue;
        }
        assert_eq!(desk.listing(), ["out"], "{state}");
        let text = |name: &str| std::fs::read_to_string(at("out").join(name)).ok();
        assert_eq!([text("force.csv"), text("force.svg")], [Some(force.to_owned()), Some(force.to_owned())], "{state}");
        assert_eq!(text("surface_2.csv").is_some(), force == "1 N", "{state}");
        assert_eq!(text("notes.txt").as_deref(), Some("mine"), "{state}");
        // then the next result replaces it
        write(&at("out"), "3 N", later);
        assert_eq!(
            (text("force.csv").as_deref(), text("surface_2.csv"), text("notes.txt").as_deref()),
            (Some("3 N"), None, Some("mine"))
        );
    }

    // killed while writing: without a record it is not a result
    let desk = Desk::default();
    std::fs::create_dir(desk.folder().join(".out.draft")).unwrap();
    desk.put(".out.draft/force.csv", "2 N");
    desk.put(".out.lock", "");
    write(&desk.folder().join("out"), "1 N", &["force.svg"]);
    assert_eq!(desk.listing(), ["out"]);
    assert!(!desk.folder().join("out/force.csv").exists());
}

/// A command that does not publish its folder would print numbers and leave no files.
#[test]
fn every_command_that_opens_a_folder_publishes_it() {
    // files whose functions pass the folder on by value, and the files that publish it
    let handed = [
        ("command/fit/block.rs", "command/fit/report.rs"),
        ("command/fit/piece.rs", "command/fit/report.rs"),
        ("command/fit/smallest.rs", "command/fit/search_report.rs"),
        ("paper/local_compression.rs", "study/findings.rs"),
        ("paper/volume_preserved.rs", "study/findings.rs"),
    ];
    // draws a picture to time it and discards it
    let thrown_away = "paper/volume_preserved/figures.rs";
    // contains `Common::open`, whose callers publish
    let opens_for_others = "command.rs";
    let mut openers = 0;
    for root in ["host-sim/src", "host-sim/lab/src"].map(|folder| repository().join(folder)) {
        for (path, bytes) in content(&root) {
            let text = String::from_utf8_lossy(&bytes);
            let name = path.strip_prefix(&root).unwrap().to_string_lossy().replace('\\', "/");
            let opens = ["OutputFolder::open(", "OutputFolder::add_to(", "common.open(\""].iter().any(|call| text.contains(call));
            if !opens || [thrown_away, opens_for_others].contains(&name.as_str()) {
                continue;
            }
            openers += 1;
            let publisher = handed.iter().find(|(from, _)| *from == name).map_or(name.as_str(), |(_, to)| to);
            let publishes = std::fs::read_to_string(root.join(publisher)).unwrap().matches(".publish()").count();
            assert!(publishes > 0, "{name} opens an output folder, {publisher} does not publish it");
        }
    }
    assert!(openers > 12, "{openers}");
}

/// A plan that finds no patch must remove the patch of the plan before it; other patches stay.
#[test]
fn an_earlier_patch_stays_unless_it_is_dropped() {
    let desk = Desk::default();
    let out = desk.folder().join("out");
    write(&out, "1 N", &["a.patch", "b.patch", "summary.json"]);
    let mut folder = OutputFolder::open(&out).unwrap();
    folder.drop_earlier("a.patch");
    folder.write("summary.json", b"2 N").unwrap();
    folder.publish().unwrap();
    let left: Vec<_> = content(&out).into_keys().map(|path| path.file_name().unwrap().to_string_lossy().into_owned()).collect();
    assert_eq!(left, [".palpate", "b.patch", "summary.json"]);
}

/// A long fit writes notes. They remain if the run is stopped and are removed when it finishes.
#[test]
fn notes_outlive_a_stopped_run_and_no_finished_one() {
    let desk = Desk::default();
    let out = desk.folder().join("out");
    write(&out, "1 N", &["summary.json"]);
    let folder = OutputFolder::open(&out).unwrap();
    folder.write_note("walk.json", &[1, 2]).unwrap();
    drop(folder);
    assert_eq!(content(&out).len(), 2, "a note is no part of a result");
    let folder = OutputFolder::open(&out).unwrap();
    assert!(folder.read_note("walk.json").is_some_and(|note| note.contains('2')));
    folder.write("summary.json", b"2 N").unwrap();
    folder.publish().unwrap();
    assert_eq!(desk.listing(), ["out"]);
}
