//! Minutes of use by a script, during which memory and the page's own counters must not grow. Only
//! `host-sim/live/test minutes` runs this test.

use std::time::{Duration, Instant};

use serde_json::{Value, json};

use crate::driver::Browser;
use crate::{MIDDLE, active, let_go, number, page, press, says, until};

/// Memory that each call of the driver leaves in the page's JavaScript, even if nothing touches the
/// page [MB].
const LEFT_BY_A_CALL_MB: f64 = 0.7e-3;

/// Memory after garbage collection [MB]: of the page's JavaScript, without the memory that the
/// driver left there, and of all processes of the page as the system counts it.
fn memory_mb(browser: &mut Browser) -> [f64; 2] {
    browser.devtools("HeapProfiler.enable", &json!({}));
    browser.devtools("HeapProfiler.collectGarbage", &json!({}));
    let script = browser.run("return performance.memory.usedJSHeapSize;").as_f64().unwrap_or(f64::NAN);
    [script * 1e-6 - LEFT_BY_A_CALL_MB * f64::from(browser.calls()), browser.resident_mb()]
}

#[test]
#[ignore = "minutes: by name"]
fn minutes_of_use_do_not_grow_in_memory() {
    let minutes = std::env::var("PALPATE_LIVE_MINUTES").ok().and_then(|m| m.parse().ok()).unwrap_or(10.0);
    let Some((mut browser, _)) = page() else { return };
    let begun = Instant::now();
    let (mut rounds, mut next_s, mut seen) = (0_u32, 0.0, Vec::new());
    while begun.elapsed() < Duration::from_secs_f64(minutes * 60.0) {
        let [x, y] = MIDDLE;
        let at = [x - 60 + 20 * (rounds % 7), y - 20 + 10 * (rounds % 5)];
        press(&mut browser, at, 3e-3);
        browser.mouse(at[0] + 30, at[1], None);
        std::thread::sleep(Duration::from_millis(500));
        let_go(&mut browser, [at[0] + 30, at[1]]);
        match rounds % 6 {
            1 => browser.key("]"),
            3 => browser.key("["),
            4 => {
                browser.key("r");
                until(&mut browser, "recording", |s| s["recorded_ticks"].as_u64().is_some_and(|t| t > 1500));
                browser.key("r");
                until(&mut browser, "recorded", |s| says(s, "Recorded"));
                browser.key("l");
                until(&mut browser, "replayed", |s| says(s, "Replayed"));
                active(&mut browser);
            }
            5 => {
                browser.key("o");
                until(&mut browser, "another tissue", |s| says(s, "ready"));
                active(&mut browser);
            }
            _ => {}
        }
        rounds += 1;
        let now_s = begun.elapsed().as_secs_f64();
        if now_s >= next_s {
            next_s = now_s + 30.0;
            let [script, resident] = memory_mb(&mut browser);
            let shown: Value = browser.shown();
            let (hz, fps) = (number(&shown, "ticks_per_s"), number(&shown, "frames_per_s"));
            println!(
                "{now_s:5.0} s, {rounds} rounds: {script:.1} MB of JavaScript, {resident:.0} MB resident, {hz:.0} ticks/s, {fps} frames/s"
            );
            seen.push([script, resident]);
        }
    }
    // the first minute fills caches
    let settled = &seen[(seen.len() / 4).min(seen.len() - 1)..];
    let [first, last] = [settled[0], settled[settled.len() - 1]];
    assert!(last[0] < 1.2 * first[0] + 2.0 && last[1] < 1.15 * first[1], "{seen:?}");
}

#[test]
#[ignore = "figures: by name"]
fn the_pages_own_counters_with_two_meshes() {
    let Some((mut browser, _)) = page() else { return };
    let loaded_s = browser.seconds_since_load();
    for (nodes, keys) in [(410, 0), (230, 3)] {
        for _ in 0..keys {
            browser.key("m");
            until(&mut browser, "another mesh", |s| says(s, "ready"));
        }
        until(&mut browser, "the mesh", |s| s["nodes"].as_u64().is_some_and(|n| n.abs_diff(nodes) < 20));
        std::thread::sleep(Duration::from_secs(2));
        active(&mut browser);
        let before = press(&mut browser, MIDDLE, 3e-3);
        std::thread::sleep(Duration::from_secs(10));
        let shown = browser.shown();
        let passed = |key: &str| number(&shown, key) - number(&before, key);
        println!(
            "{} nodes pressed for 10 s: {:.1} ticks/s, {} ticks and {} dropped, longest tick {:.0} us, {} frames/s",
            shown["nodes"],
            number(&shown, "ticks_per_s"),
            passed("ticks"),
            passed("dropped"),
            number(&shown, "longest_tick_us"),
            shown["frames_per_s"]
        );
        let_go(&mut browser, MIDDLE);
    }
    println!("active {loaded_s:.2} s after load, first touch by the page's counter {} s", browser.shown()["first_touch_s"]);
}
