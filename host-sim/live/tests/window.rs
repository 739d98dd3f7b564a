//! The window under Xvfb, driven by xdotool's mouse and keys: the tissue is pressed, stiffened and
//! recorded, and the trace repeats bit for bit. Another test opens a window that follows a board
//! through a growing file.
//!
//! The tests are skipped, with a message, if Xvfb or xdotool is not installed.

use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use palpate_loop::board_trace::RECORD_TICKS;
use serde_json::Value;

/// Time limit for whatever is waited for, which must not hang the tests; a busy machine needs some
/// of it.
const LONGEST: Duration = Duration::from_secs(300);

struct Window {
    screen: Child,
    program: Child,
    display: String,
    folder: tempfile::TempDir,
}

impl Window {
    fn open() -> Option<Self> {
        Self::open_with(|_| Vec::new())
    }

    /// Opens the window with these arguments, which may name files in its folder.
    fn open_with(arguments: impl Fn(&Path) -> Vec<String>) -> Option<Self> {
        Command::new("xdotool").arg("version").stdout(Stdio::null()).stderr(Stdio::null()).status().ok()?;
        let folder = tempfile::tempdir().ok()?;
        static NEXT: std::sync::atomic::AtomicU32 = std::sync::atomic::AtomicU32::new(0);
        let next = NEXT.fetch_add(1, std::sync::atomic::Ordering::Relaxed);
        let display = format!(":{}", 100 + 2 * (std::process::id() % 400) + next % 2);
        let quiet = |command: &mut Command| command.stdout(Stdio::null()).stderr(Stdio::null()).spawn().ok();
        let screen = quiet(Command::new("Xvfb").args([&display, "-screen", "0", "1400x800x24"]))?;
        std::thread::sleep(Duration::from_secs(2));
        let mut program = Command::new(env!("CARGO_BIN_EXE_palpate-live"));
        program
            .env("DISPLAY", &display)
            .env_remove("WAYLAND_DISPLAY")
            .env("LIBGL_ALWAYS_SOFTWARE", "1")
            .args(arguments(folder.path()))
            .arg("--out")
            .arg(folder.path());
        let program = quiet(program.arg("--numbers").arg(folder.path().join("numbers.json")))?;
        Some(Self { screen, program, display, folder })
    }

    fn x(&self, words: &str) {
        let status = Command::new("xdotool").args(words.split(' ')).env("DISPLAY", &self.display).status().unwrap();
        assert!(status.success(), "xdotool {words}");
        std::thread::sleep(Duration::from_millis(150));
    }

    fn until(&mut self, what: &str, holds: impl Fn(&Value) -> bool) -> Value {
        let begun = Instant::now();
        loop {
            let text = std::fs::read_to_string(self.folder.path().join("numbers.json")).unwrap_or_default();
            let shown: Value = serde_json::from_str(&text).unwrap_or_default();
            if holds(&shown) {
                return shown;
            }
            let ended = self.program.try_wait().unwrap();
            assert!(begun.elapsed() < LONGEST && ended.is_none(), "{what}: {ended:?} {shown}");
            std::thread::sleep(Duration::from_millis(100));
        }
    }
}

impl Drop for Window {
    fn drop(&mut self) {
        for child in [&mut self.program, &mut self.screen] {
            let _ended = child.kill();
            let _reaped = child.wait();
        }
    }
}

fn number(shown: &Value, key: &str) -> f64 {
    shown[key].as_f64().unwrap_or(f64::NAN)
}

/// Waits for a file with this ending and returns its path.
fn written(folder: &Path, ending: &str) -> std::path::PathBuf {
    let begun = Instant::now();
    loop {
        let found =
            std::fs::read_dir(folder).unwrap().flatten().map(|f| f.path()).find(|p| p.to_string_lossy().ends_with(ending));
        if let Some(path) = found {
            std::thread::sleep(Duration::from_millis(300));
            return path;
        }
        assert!(begun.elapsed() < LONGEST, "no {ending} was written");
        std::thread::sleep(Duration::from_millis(100));
    }
}

#[test]
fn the_window_is_pressed_and_its_trace_repeats() {
    let Some(mut window) = Window::open() else {
        println!("skipped: Xvfb or xdotool is missing: install them (Debian: xvfb xdotool libgl1-mesa-dri)");
        return;
    };
    window.until("the loop is active", |s| s["mode"].as_str().is_some_and(|m| m.starts_with("active")));
    // without a window manager the window has no keyboard focus
    window.x("search --onlyvisible --name Palpate windowfocus");
    window.x("mousemove 480 250 mousedown 1");
    let soft = window.until("force", |s| number(s, "depth_m") > 2.9e-3);
    assert!(number(&soft, "force_n") > 0.05 && number(&soft, "moved_m") > 1e-3, "{soft}");
    window.until("a second of ticks", |s| number(s, "ticks_per_s") > 0.0);
    window.x("key p");
    let picture = written(window.folder.path(), ".png");
    if let Some(folder) = std::env::var_os("PALPATE_LIVE_PICTURES") {
        std::fs::copy(&picture, Path::new(&folder).join("live-window.png")).unwrap();
    }
    assert!(std::fs::metadata(&picture).unwrap().len() > 20_000, "an empty picture");
    window.x("mouseup 1");
    window.until("let go", |s| number(s, "force_n") == 0.0);
    window.x("key bracketright key bracketright key bracketright");
    window.x("key r");
    window.until("recording", |s| s["recorded_ticks"].as_u64().is_some_and(|t| t > 800));
    window.x("mousedown 1");
    let stiff = window.until("stiffer force", |s| number(s, "depth_m") > 2.9e-3);
    assert!(number(&stiff, "force_n") > 1.5 * number(&soft, "force_n"), "{stiff}");
    window.x("mousemove 1150 600");
    window.until("no force beside the tissue", |s| number(s, "force_n") == 0.0);
    window.x("mouseup 1 key r");
    let bytes = std::fs::read(written(window.folder.path(), ".trace")).unwrap();
    if let Some(folder) = std::env::var_os("PALPATE_LIVE_PICTURES") {
        std::fs::write(Path::new(&folder).join("window.trace"), &bytes).unwrap();
    }
    let again = palpate_loop::live::replay::replay(&palpate_loop::live::trace::Trace::read(&bytes).unwrap()).unwrap();
    assert_eq!(again.differs, None);
    assert!(again.telemetry.iter().any(|t| f64::from(t.applied_n.norm()) > number(&soft, "force_n")));
    // the preset with a nodule, zoomed in and cut through the tip
    window.x("key 4");
    let nodule = |s: &Value| s["controls"]["scene"] == "nodule" && s["controls"]["nodule"] == true;
    window.until("a nodule of the scene's own", |s| nodule(s) && s["mode"].as_str().is_some_and(|m| m.starts_with("active")));
    (0..3).for_each(|_| window.x("key plus"));
    window.x("key v mousemove 480 180 mousedown 1");
    window.until("the cut", |s| s["controls"]["cut"] == true && number(s, "depth_m") > 2.9e-3);
    std::thread::sleep(Duration::from_secs(1));
    std::fs::remove_file(&picture).unwrap();
    window.x("key p");
    let cut = written(window.folder.path(), ".png");
    if let Some(folder) = std::env::var_os("PALPATE_LIVE_PICTURES") {
        std::fs::copy(&cut, Path::new(&folder).join("live-cut.png")).unwrap();
    }
    println!(
        "{} ticks/s, {} frames/s, longest tick {} us",
        stiff["ticks_per_s"], stiff["frames_per_s"], stiff["longest_tick_us"]
    );
}

#[test]
fn a_window_bears_a_mouse_that_leaves_and_no_size_and_its_keys_reach_everything() {
    let Some(mut window) = Window::open() else {
        println!("skipped: Xvfb or xdotool is missing: install them (Debian: xvfb xdotool libgl1-mesa-dri)");
        return;
    };
    let active = |s: &Value| s["mode"].as_str().is_some_and(|m| m.starts_with("active"));
    let deep = |s: &Value| number(s, "depth_m") > 2.9e-3 && number(s, "force_n") > 0.03;
    window.until("the loop is active", active);
    window.x("search --onlyvisible --name Palpate windowfocus");
    window.x("mousemove 480 250 mousedown 1");
    window.until("force", deep);
    window.x("mousemove 1390 790");
    window.until("no force outside", |s| number(s, "force_n") == 0.0 && number(s, "depth_m") == 0.0);
    window.x("mouseup 1 mousemove 480 250 mousedown 1");
    let before = window.until("force again", deep);
    window.x("search --onlyvisible --name Palpate windowsize 1 1");
    std::thread::sleep(Duration::from_secs(2));
    window.x("search --name Palpate windowsize 1280 720");
    window.x("mouseup 1");
    let ticks = |s: &Value| s["ticks"].as_u64().unwrap_or(0);
    let after = ticks(&before) + 1500;
    window.until("it went on without a size", |s| ticks(s) > after && number(s, "force_n") == 0.0 && active(s));
    window.x("mousedown 1");
    window.until("force after it", deep);
    window.x("mouseup 1");

    // keys for device, hand, damping, nodule, mesh, preset, light and dark
    let chosen = |s: &Value, key: &str| s["controls"][key].clone();
    window.x("key d");
    window.until("a device", |s| chosen(s, "device") == "touch");
    window.x("key h");
    window.until("another hand", |s| chosen(s, "hand") == "H3");
    window.x("key period");
    window.until("more damping", |s| chosen(s, "damping_per_s").as_f64().is_some_and(|d| (d - 50.0).abs() < 0.1));
    window.x("key m");
    window.until("another mesh", |s| s["nodes"].as_u64().is_some_and(|n| n > 800) && active(s));
    // each tissue is awaited, since it takes time to load
    let body = |s: &Value| s["body"].as_u64().unwrap_or(0);
    let mut newest = 0;
    for (key, scene, nodule) in [("5", "abdomen", false), ("1", "block", false), ("o", "block", true)] {
        newest = newest.max(window.until("a tissue", active)["body"].as_u64().unwrap_or(0));
        window.x(&format!("key {key}"));
        window.until(scene, |s| chosen(s, "scene") == scene && chosen(s, "nodule") == nodule && body(s) > newest && active(s));
    }
    window.x("key t");
    window.until("dark", |s| chosen(s, "dark") == true);
    window.x("key s key j mousedown 1");
    window.until("the device's force", |s| number(s, "depth_m") > 1.5e-3 && number(s, "force_n") > 0.05);
    std::thread::sleep(Duration::from_secs(1));
    window.x("key p");
    let picture = written(window.folder.path(), ".png");
    if let Some(folder) = std::env::var_os("PALPATE_LIVE_PICTURES") {
        std::fs::copy(&picture, Path::new(&folder).join("live-window-dark.png")).unwrap();
    }
}

#[test]
fn a_board_is_followed_in_a_file_that_grows_stops_and_begins_anew() {
    let file = |folder: &Path| folder.join("felt.csv");
    let Some(mut window) = Window::open_with(|folder| vec!["--follow".into(), file(folder).display().to_string()]) else {
        println!("skipped: Xvfb or xdotool is missing: install them (Debian: xvfb xdotool libgl1-mesa-dri)");
        return;
    };
    let path = file(window.folder.path());
    window.until("it waits", |s| s["phase"] == "Absent" && s["says"].as_str().is_some_and(|s| s.starts_with("No file yet")));
    let bytes = include_bytes!("../../../firmware/patches/block-m4f-168.patch");
    let patch = palpate::PatchFile::checksum(bytes).unwrap();
    let head = format!("{}\n", palpate_loop::board_trace::COLUMNS.join(","));
    // the tip moves down to 3 mm within a second and stays there
    let line = move |n: u32| {
        let z_m = 0.003 - 0.006 * (f64::from(n) / 500.0).min(1.0);
        let tick = RECORD_TICKS * n;
        format!("{tick},4,0,0,0,{z_m},{},0,0,0.09,0,0,0.08,1,0,0,0,9,0,0,0,230.00,{patch:08x},3500\n", (-z_m).max(0.0))
    };
    std::fs::write(&path, &head).unwrap();
    window.until("it waits for a record", |s| s["phase"] == "Begun");
    let mut growing = std::fs::OpenOptions::new().append(true).open(&path).unwrap();
    let writes = std::thread::spawn(move || {
        for n in 0..250 {
            // rows are written in two pieces, since a reader may come in between
            let rows: String = (10 * n..10 * (n + 1)).map(line).collect();
            for piece in [&rows[..7], &rows[7..]] {
                std::io::Write::write_all(&mut growing, piece.as_bytes()).unwrap();
                std::thread::sleep(Duration::from_millis(10));
            }
        }
    });
    let pressed = window.until("the board's press", |s| number(s, "depth_m") > 2.9e-3 && number(s, "differs_n").is_finite());
    assert_eq!((number(&pressed, "force_n") * 1e3).round(), 80.0, "the file's force: {pressed}");
    assert!((number(&pressed, "arrow_n") - 0.08).abs() < 1e-6 && pressed["patch"] == "block-m4f-168", "{pressed}");
    assert!((number(&pressed, "twin_n") - 0.09).abs() < 0.02 && number(&pressed, "moved_m") > 1e-3, "{pressed}");
    writes.join().unwrap();
    let silent = window.until("silence", |s| s["phase"] == "Silent");
    assert!(silent["force_n"].is_null() && number(&silent, "arrow_n") == 0.0 && silent["records"] == 2500, "{silent}");
    // the file is begun anew by a board with a fault, which continues to write records during the
    // wait
    let faulty =
        |n: usize| format!("{},7,8,0,0,0.01,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,,{patch:08x},3500\n", RECORD_TICKS as usize * n);
    let rows = std::cell::Cell::new(0);
    let anew = window.until("a new file", |s| {
        rows.set(rows.get() + 1);
        std::fs::write(&path, (0..rows.get()).fold(head.clone(), |text, n| text + &faulty(n))).unwrap();
        s["phase"] == "Live" && s["records"].as_u64().is_some_and(|records| (1..2500).contains(&records)) && !s["fault"].is_null()
    });
    assert!(anew["fault"].as_str().is_some_and(|f| f.starts_with("fault 8: ")) && number(&anew, "force_n") == 0.0, "{anew}");
    std::fs::write(&path, "t_s,probe_x_m\n0,0\n").unwrap();
    window
        .until("another table", |s| s["phase"].as_str().is_some_and(|p| p.contains("no column tick")) && s["force_n"].is_null());
}
