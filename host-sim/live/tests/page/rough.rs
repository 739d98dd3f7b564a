//! Mishaps of a page: a tab behind another, a mouse that leaves, a page without a size, a foreign
//! file. Each time the page says what happened, no force acts, and nothing is lost.

use std::time::Duration;

use palpate_loop::live::trace::{MAGIC, VERSION};
use serde_json::json;

use crate::{MIDDLE, active, let_go, number, page, press, recorded_here, repeated, says, until};

/// Ticks in a row without a force that the recording must contain.
const ASLEEP: usize = 2000;

#[test]
fn a_tab_that_sleeps_lets_go_and_keeps_its_recording() {
    let Some((mut browser, _)) = page() else { return };
    browser
        .run("window.hid = 0; document.addEventListener('visibilitychange', () => { if (document.hidden) window.hid += 1; });");
    browser.key("r");
    until(&mut browser, "recording", |s| s["recorded_ticks"].as_u64().is_some_and(|t| t > 800));
    press(&mut browser, MIDDLE, 3e-3);
    browser.behind_another_tab(5);
    assert!(browser.run("return window.hid;").as_u64() >= Some(1), "the tab was never hidden: this shows nothing");
    let_go(&mut browser, MIDDLE);
    active(&mut browser);
    press(&mut browser, MIDDLE, 3e-3);
    let_go(&mut browser, MIDDLE);
    browser.key("r");
    until(&mut browser, "recorded", |s| says(s, "Recorded"));
    let again = repeated(&browser.trace());
    let felt: Vec<bool> = again.telemetry.iter().map(|t| t.applied_n.norm() > 0.0).collect();
    let (first, last) = (felt.iter().position(|f| *f).unwrap(), felt.iter().rposition(|f| *f).unwrap());
    let silent = felt[first..last].chunk_by(|a, b| a == b).filter(|run| !run[0]).map(<[bool]>::len).max();
    println!("{} ticks recorded, {silent:?} of them without force behind another tab", felt.len());
    assert!(silent >= Some(ASLEEP), "{silent:?}");
}

#[test]
fn a_mouse_that_leaves_the_window_with_its_button_down_lets_go() {
    let Some((mut browser, _)) = page() else { return };
    press(&mut browser, MIDDLE, 3e-3);
    let [x, y] = [-40, -40];
    browser.devtools("Input.dispatchMouseEvent", &json!({"type": "mouseMoved", "x": x, "y": y, "button": "left", "buttons": 1}));
    let left = until(&mut browser, "no force outside", |s| number(s, "force_n") == 0.0 && number(s, "depth_m") == 0.0);
    assert!(number(&left, "tip_m").is_nan() && left["fault"].is_null(), "{left}");
    browser.devtools(
        "Input.dispatchMouseEvent",
        &json!({"type": "mouseReleased", "x": x, "y": y, "button": "left", "buttons": 0, "clickCount": 1}),
    );
    press(&mut browser, MIDDLE, 3e-3);
    let_go(&mut browser, MIDDLE);
}

#[test]
fn a_picture_without_a_size_lets_go_and_comes_back() {
    let Some((mut browser, _)) = page() else { return };
    let ticks = |s: &serde_json::Value| s["ticks"].as_u64().unwrap_or(0);
    for size in ["width = '0px'", "height = '0px'", "display = 'none'"] {
        let before = press(&mut browser, MIDDLE, 3e-3);
        browser.run(&format!("document.getElementById('picture').style.{size};"));
        std::thread::sleep(Duration::from_secs(2));
        let none = browser.shown();
        browser.run("document.getElementById('picture').style = '';");
        browser.mouse(MIDDLE[0], MIDDLE[1], Some(false));
        println!("{size}: {} N, {} ticks on", none["force_n"], ticks(&none) - ticks(&before));
        assert_eq!(number(&none, "force_n"), 0.0, "{size}: {none}");
        let from = ticks(&before) + 1000;
        until(&mut browser, "its tissue went on", |s| ticks(s) > from);
        active(&mut browser);
    }
    press(&mut browser, MIDDLE, 3e-3);
    let_go(&mut browser, MIDDLE);
}

#[test]
fn foreign_files_get_a_sentence_and_take_nothing_away() {
    let Some((mut browser, _)) = page() else { return };
    browser.key("r");
    until(&mut browser, "recording", |s| s["recorded_ticks"].as_u64().is_some_and(|t| t > 800));
    let mut newer = MAGIC.to_vec();
    newer.extend((VERSION + 1).to_le_bytes());
    newer.extend([0; 64]);
    let mut damaged = recorded_here();
    let half = damaged.len() / 2;
    damaged[half] ^= 1;
    let unfit = include_str!("../../../scenes/block.toml").replace("3500.0", "-1.0");
    let misspelt = "name = \"misspelt\"\n[tissue]\nblock = [0.08, 0.08, 0.04]\n";
    for (name, bytes, said) in [
        ("newer.trace", &newer[..], "version 3"),
        ("damaged.trace", &damaged, "checksum"),
        ("unfit.toml", unfit.as_bytes(), "youngs_modulus_pa"),
        ("misspelt.toml", misspelt.as_bytes(), "block"),
        ("holiday.jpg", &[0xff, 0xd8, 0xff], "neither"),
    ] {
        browser.drop_file(name, bytes);
        let shown = until(&mut browser, name, |s| says(s, said));
        let text = shown["said"].as_str().unwrap();
        println!("{name}: {text}");
        assert!(shown["refused"] == true && !text.contains('\n') && number(&shown, "force_n") == 0.0, "{shown}");
    }
    // the recording, the scene and its sliders are unchanged
    let kept = browser.shown();
    assert!(kept["controls"]["scene"] == "block" && kept["recorded_ticks"].is_u64(), "{kept}");
    let soft = press(&mut browser, MIDDLE, 3e-3);
    let_go(&mut browser, MIDDLE);
    (0..3).for_each(|_| browser.key("]"));
    let stiff = press(&mut browser, MIDDLE, 3e-3);
    assert!(number(&stiff, "force_n") > 1.5 * number(&soft, "force_n"), "{stiff}");
    let_go(&mut browser, MIDDLE);
    browser.key("r");
    until(&mut browser, "recorded", |s| says(s, "Recorded"));
    assert!(repeated(&browser.trace()).telemetry.len() > 1000);
}
