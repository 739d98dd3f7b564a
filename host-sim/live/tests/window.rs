//! The window under Xvfb, driven by xdotool's mouse and keys: pressed, stiffened, recorded; the
//! trace repeats bit for bit.
//!
//! Skipped, saying so, where Xvfb or xdotool are not installed.

use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use serde_json::Value;

struct Window {
    screen: Child,
    program: Child,
    display: String,
    folder: tempfile::TempDir,
}

impl Window {
    fn open() -> Option<Self> {
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
        let end = Instant::now() + Duration::from_secs(30);
        loop {
            let text = std::fs::read_to_string(self.folder.path().join("numbers.json")).unwrap_or_default();
            let shown: Value = serde_json::from_str(&text).unwrap_or_default();
            if holds(&shown) {
                return shown;
            }
            let ended = self.program.try_wait().unwrap();
            assert!(Instant::now() < end && ended.is_none(), "{what}: {ended:?} {shown}");
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

/// The file with this ending that was written, once it is there.
fn written(folder: &Path, ending: &str) -> std::path::PathBuf {
    let end = Instant::now() + Duration::from_secs(20);
    loop {
        let found =
            std::fs::read_dir(folder).unwrap().flatten().map(|f| f.path()).find(|p| p.to_string_lossy().ends_with(ending));
        if let Some(path) = found {
            std::thread::sleep(Duration::from_millis(300));
            return path;
        }
        assert!(Instant::now() < end, "no {ending} was written");
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
    // without a window manager it has no keyboard focus
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
    // the preset with a nodule, nearer and cut through the tip
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

    // keys: device, hand, damping, nodule, mesh, preset, light and dark
    let chosen = |s: &Value, key: &str| s["controls"][key].clone();
    window.x("key d");
    window.until("a device", |s| chosen(s, "device") == "touch");
    window.x("key h");
    window.until("another hand", |s| chosen(s, "hand") == "H3");
    window.x("key period");
    window.until("more damping", |s| chosen(s, "damping_per_s").as_f64().is_some_and(|d| (d - 50.0).abs() < 0.1));
    window.x("key m");
    window.until("another mesh", |s| s["nodes"].as_u64().is_some_and(|n| n > 800) && active(s));
    // one after the other: a tissue takes time to load
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
