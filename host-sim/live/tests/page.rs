//! The page in a real browser, driven by mouse and keys through `chromedriver`: it loads, is pressed, gives, stiffens, records and replays.
//!
//! Skipped, saying so, where `chromedriver` and `chromium` are not installed or the page is not built (`PALPATE_LIVE_PAGE` names its folder).

mod driver;

use std::path::PathBuf;
use std::time::{Duration, Instant};

use driver::Browser;
use serde_json::Value;

fn until(browser: &mut Browser, what: &str, seconds: u64, holds: impl Fn(&Value) -> bool) -> Value {
    let end = Instant::now() + Duration::from_secs(seconds);
    loop {
        let shown = browser.shown();
        if holds(&shown) {
            return shown;
        }
        assert!(Instant::now() < end, "{what} in {seconds} s: {shown}");
        std::thread::sleep(Duration::from_millis(50));
    }
}

fn number(shown: &Value, key: &str) -> f64 {
    shown[key].as_f64().unwrap_or(f64::NAN)
}

#[test]
fn the_page_is_pressed_and_replays_its_own_bits() {
    let Some(folder) = std::env::var_os("PALPATE_LIVE_PAGE").map(PathBuf::from) else {
        println!("skipped: PALPATE_LIVE_PAGE names no page: palpate live --page --no-serve builds it");
        return;
    };
    let pictures = std::env::var_os("PALPATE_LIVE_PICTURES").map(PathBuf::from);
    let Some(mut browser) = Browser::open(&folder) else {
        println!("skipped: chromedriver or chromium is missing: install them (Debian: chromium chromium-driver)");
        return;
    };
    let bytes: u64 = std::fs::read_dir(&folder).unwrap().flatten().map(|f| f.metadata().unwrap().len()).sum();
    println!("page {:.2} MB", bytes as f64 * 1e-6);

    until(&mut browser, "the loop is active", 30, |s| s["mode"].as_str().is_some_and(|m| m.starts_with("active")));
    let ready = browser.seconds_since_load();
    let rest = browser.screenshot();

    // the mouse presses; the tissue gives, in numbers and in pixels
    browser.mouse(480, 250, Some(true));
    let soft = until(&mut browser, "force", 20, |s| number(s, "depth_m") > 2.9e-3);
    println!("ready {ready:.2} s after load; first touch {} s", soft["first_touch_s"]);
    assert!(number(&soft, "force_n") > 0.05 && number(&soft, "moved_m") > 1e-3, "{soft}");
    let pressed = browser.screenshot();
    assert_ne!(rest, pressed, "the picture did not change");
    if let Some(folder) = &pictures {
        std::fs::write(folder.join("live-page.png"), &pressed).unwrap();
    }
    browser.mouse(480, 250, Some(false));
    until(&mut browser, "let go", 20, |s| number(s, "force_n") == 0.0);

    // stiffer by the key, then pressed again
    (0..3).for_each(|_| browser.key("]"));
    browser.mouse(480, 250, Some(true));
    let stiff = until(&mut browser, "stiffer force", 20, |s| number(s, "depth_m") > 2.9e-3);
    assert!(number(&stiff, "force_n") > 1.5 * number(&soft, "force_n"), "{stiff}");
    // the mouse leaves the window: the force goes
    browser.mouse(1200, 400, None);
    until(&mut browser, "no force beside the tissue", 20, |s| number(s, "force_n") == 0.0);
    browser.mouse(1200, 400, Some(false));

    // a recording, replayed in the page
    browser.key("r");
    until(&mut browser, "recording", 20, |s| s["recorded_ticks"].as_u64().is_some_and(|t| t > 800));
    browser.mouse(480, 250, Some(true));
    until(&mut browser, "force in the recording", 20, |s| number(s, "depth_m") > 2.9e-3);
    browser.mouse(480, 250, Some(false));
    browser.key("r");
    until(&mut browser, "recorded", 20, |s| s["said"].as_str().is_some_and(|t| t.starts_with("Recorded")));
    browser.key("l");
    let replayed = until(&mut browser, "replayed", 60, |s| s["said"].as_str().is_some_and(|t| t.starts_with("Replayed")));
    assert_eq!(replayed["refused"], false, "{replayed}");
    println!("{}", replayed["said"]);
    // and on this machine: the page's trace has the desktop's bits
    let trace = browser.trace();
    let again = palpate_sim::live::replay::replay(&palpate_sim::live::trace::Trace::read(&trace).unwrap()).unwrap();
    assert_eq!(again.differs, None, "the browser's bits are not this machine's");
    assert!(again.told.iter().any(|t| t.applied_n.norm() > 0.05));

    // the exercise begins and is answered
    browser.key("n");
    until(&mut browser, "a hidden nodule", 60, |s| {
        s["controls"]["searching"] == true && s["said"].as_str().is_some_and(|t| t.contains("ready"))
    });
    browser.mouse(480, 250, Some(true));
    until(&mut browser, "pressed while searching", 60, |s| number(s, "depth_m") > 2e-3);
    browser.mouse(480, 250, Some(false));
    browser.key("\u{e007}");
    let scored = until(&mut browser, "score", 20, |s| s["controls"]["score"].is_number());
    println!("{}", scored["said"]);
    println!(
        "{} ticks/s, {} frames/s, longest tick {} us",
        scored["ticks_per_s"], scored["frames_per_s"], scored["longest_tick_us"]
    );
}
