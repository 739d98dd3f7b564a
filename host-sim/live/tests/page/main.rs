//! The page in a real browser, driven by mouse and keys through `chromedriver`: the page loads, and
//! the tissue yields to a press, is stiffened, and is recorded and replayed.
//!
//! The tests are skipped, with a message, if `chromedriver` or `chromium` is not installed, or if
//! the page is not built (`PALPATE_LIVE_PAGE` names its folder).

mod arrival;
mod driver;
mod long;
mod nodule;
mod rough;

use std::path::PathBuf;
use std::time::{Duration, Instant};

use driver::Browser;
use palpate_loop::live::replay::{Replayed, replay};
use palpate_loop::live::trace::Trace;
use palpate_loop::live::{Choice, Holding, Live};
use serde_json::Value;

/// Pixel of the site.
const MIDDLE: [u32; 2] = [504, 200];

/// Time limit for whatever is waited for, which must not hang the tests; a busy machine needs some
/// of it.
const LONGEST: Duration = Duration::from_secs(300);

fn until(browser: &mut Browser, what: &str, holds: impl Fn(&Value) -> bool) -> Value {
    let begun = Instant::now();
    loop {
        let shown = browser.shown();
        if holds(&shown) {
            return shown;
        }
        assert!(begun.elapsed() < LONGEST, "still waited for: {what}: {shown}");
        std::thread::sleep(Duration::from_millis(50));
    }
}

fn number(shown: &Value, key: &str) -> f64 {
    shown[key].as_f64().unwrap_or(f64::NAN)
}

fn says(shown: &Value, text: &str) -> bool {
    shown["said"].as_str().is_some_and(|t| t.contains(text))
}

fn active(browser: &mut Browser) -> Value {
    until(browser, "the loop is active", |s| s["mode"].as_str().is_some_and(|m| m.starts_with("active")))
}

/// The page, loaded and armed; `None`, with a message, if the browser or the page is missing.
fn page() -> Option<(Browser, PathBuf)> {
    let (mut browser, folder) = empty()?;
    browser.go(&driver::serve(&folder, false));
    active(&mut browser);
    Some((browser, folder))
}

/// A browser that shows nothing yet, and the page's folder; `None`, with a message, if one is
/// missing.
fn empty() -> Option<(Browser, PathBuf)> {
    let Some(folder) = std::env::var_os("PALPATE_LIVE_PAGE").map(PathBuf::from) else {
        println!("skipped: PALPATE_LIVE_PAGE names no page: palpate live --page --no-serve builds it");
        return None;
    };
    let Some(browser) = Browser::start() else {
        println!("skipped: chromedriver or chromium is missing: install them (Debian: chromium chromium-driver)");
        return None;
    };
    Some((browser, folder))
}

/// Presses with the mouse until the tip is `depth_m` deep in the tissue.
fn press(browser: &mut Browser, [x, y]: [u32; 2], depth_m: f64) -> Value {
    browser.mouse(x, y, Some(true));
    until(browser, "a press", |s| number(s, "depth_m") > depth_m - 1e-4 && number(s, "force_n") > 0.02)
}

fn let_go(browser: &mut Browser, [x, y]: [u32; 2]) {
    browser.mouse(x, y, Some(false));
    until(browser, "let go", |s| number(s, "force_n") == 0.0);
}

/// Replays a recording of the page on this machine, which must compute the same bits.
fn repeated(trace: &[u8]) -> Replayed {
    let again = replay(&Trace::read(trace).unwrap()).unwrap();
    assert_eq!(again.differs, None, "the browser's bits are not this machine's");
    again
}

#[test]
fn the_page_is_pressed_and_replays_its_own_bits() {
    let Some((mut browser, folder)) = page() else { return };
    let pictures = std::env::var_os("PALPATE_LIVE_PICTURES").map(PathBuf::from);
    let bytes: u64 = std::fs::read_dir(&folder).unwrap().flatten().map(|f| f.metadata().unwrap().len()).sum();
    println!("page {:.2} MB", bytes as f64 * 1e-6);

    let ready = browser.seconds_since_load();
    let rest = browser.screenshot();

    // the mouse presses, and the tissue yields, in numbers and in pixels
    browser.mouse(MIDDLE[0], MIDDLE[1], Some(true));
    let soft = until(&mut browser, "force", |s| number(s, "depth_m") > 2.9e-3);
    println!("ready {ready:.2} s after load; first touch {} s", soft["first_touch_s"]);
    assert!(number(&soft, "force_n") > 0.05 && number(&soft, "moved_m") > 1e-3, "{soft}");
    let pressed = browser.screenshot();
    assert_ne!(rest, pressed, "the picture did not change");
    browser.mouse(MIDDLE[0], MIDDLE[1], Some(false));
    until(&mut browser, "let go", |s| number(s, "force_n") == 0.0);

    // the tissue is stiffened by the key, then pressed again
    (0..3).for_each(|_| browser.key("]"));
    browser.mouse(MIDDLE[0], MIDDLE[1], Some(true));
    let stiff = until(&mut browser, "stiffer force", |s| number(s, "depth_m") > 2.9e-3);
    assert!(number(&stiff, "force_n") > 1.5 * number(&soft, "force_n"), "{stiff}");
    // the mouse leaves the window: the force ends
    browser.mouse(1200, 400, None);
    until(&mut browser, "no force beside the tissue", |s| number(s, "force_n") == 0.0);
    browser.mouse(1200, 400, Some(false));

    // a recording is replayed in the page
    browser.key("r");
    until(&mut browser, "recording", |s| s["recorded_ticks"].as_u64().is_some_and(|t| t > 800));
    browser.mouse(MIDDLE[0], MIDDLE[1], Some(true));
    until(&mut browser, "force in the recording", |s| number(s, "depth_m") > 2.9e-3);
    browser.mouse(MIDDLE[0], MIDDLE[1], Some(false));
    browser.key("r");
    until(&mut browser, "recorded", |s| s["said"].as_str().is_some_and(|t| t.starts_with("Recorded")));
    browser.key("l");
    let replayed = until(&mut browser, "replayed", |s| s["said"].as_str().is_some_and(|t| t.starts_with("Replayed")));
    assert_eq!(replayed["refused"], false, "{replayed}");
    println!("{}", replayed["said"]);
    let trace = browser.trace();
    assert!(repeated(&trace).telemetry.iter().any(|t| t.applied_n.norm() > 0.05));
    if let Some(folder) = &pictures {
        std::fs::write(folder.join("page.trace"), &trace).unwrap();
    }

    // a recording of this machine is dropped on the page
    browser.drop_file("mine.trace", &recorded_here());
    let same = until(&mut browser, "a trace of this machine", |s| says(s, "Replayed 1.2 s"));
    assert!(says(&same, "every bit the same") && same["refused"] == false, "{same}");
    println!("{} ticks/s, {} frames/s, longest tick {} us", same["ticks_per_s"], same["frames_per_s"], same["longest_tick_us"]);
}

fn recorded_here() -> Vec<u8> {
    let mut live = Live::new(&Choice { nodes: Some(130), ..Choice::preset("block") }, &Holding::default()).unwrap();
    live.record().unwrap();
    for tick in 0..1200 {
        let depth_m = if tick < 700 { -5e-3 } else { 3e-3 };
        live.tick(palpate::Vector3::new(0.0, 0.0, -depth_m), true);
    }
    live.finish().unwrap()
}
