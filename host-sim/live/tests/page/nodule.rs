//! The exercise: the hidden nodule is found by pressing, and a guess does not count.

use std::time::Duration;

use serde_json::Value;

use crate::driver::Browser;
use crate::{MIDDLE, active, let_go, number, page, press, says, until};

/// Maps positions on the surface to pixels: from the displacement of the tip over a few pixels,
/// corrected by the tip's resulting position.
struct Map {
    /// Displacement of the tip per pixel to the right, and per pixel down [m].
    per_pixel_m: [[f64; 2]; 2],
}

impl Map {
    const STEP: u32 = 40;

    fn of(browser: &mut Browser) -> Self {
        let [x, y] = MIDDLE;
        let (from_m, right, down) = (at(browser, [x, y]), at(browser, [x + Self::STEP, y]), at(browser, [x, y + Self::STEP]));
        let per = |to: [f64; 2]| [0, 1].map(|k| (to[k] - from_m[k]) / f64::from(Self::STEP));
        Self { per_pixel_m: [per(right), per(down)] }
    }

    /// Moves the mouse to a position on the surface and returns its pixel.
    fn go(&self, browser: &mut Browser, place_m: [f64; 2]) -> [u32; 2] {
        let [a, b] = self.per_pixel_m;
        let det = a[0] * b[1] - a[1] * b[0];
        let mut pixel = MIDDLE.map(f64::from);
        for _ in 0..4 {
            let now_m = at(browser, pixel.map(|p| p.round() as u32));
            let way = [place_m[0] - now_m[0], place_m[1] - now_m[1]];
            if way[0].hypot(way[1]) < 1e-3 {
                break;
            }
            pixel[0] += (way[0] * b[1] - way[1] * b[0]) / det;
            pixel[1] += (a[0] * way[1] - a[1] * way[0]) / det;
        }
        pixel.map(|p| p.round() as u32)
    }
}

/// Position of the tip with the mouse over a pixel [m].
fn at(browser: &mut Browser, [x, y]: [u32; 2]) -> [f64; 2] {
    browser.mouse(x, y, None);
    std::thread::sleep(Duration::from_millis(500));
    let tip = &browser.shown()["tip_m"];
    [0, 1].map(|k| tip[k].as_f64().unwrap())
}

/// Force of a press at a position [N], and the actual position [m].
fn feel(browser: &mut Browser, map: &Map, place_m: [f64; 2]) -> ([f64; 2], f64) {
    let pixel = map.go(browser, place_m);
    press(browser, pixel, 4e-3);
    std::thread::sleep(Duration::from_millis(400));
    let felt = browser.shown();
    let_go(browser, pixel);
    ([0, 1].map(|k| felt["tip_m"][k].as_f64().unwrap()), number(&felt, "force_n"))
}

/// Position of the stiffest press: the mean of the positions, weighted by the square of the force
/// above the smallest one.
fn stiffest(felt: &[([f64; 2], f64)]) -> [f64; 2] {
    let least_n = felt.iter().map(|f| f.1).fold(f64::MAX, f64::min);
    let weight = |force_n: f64| (force_n - least_n).powi(2);
    let all: f64 = felt.iter().map(|f| weight(f.1)).sum();
    [0, 1].map(|k| felt.iter().map(|(place_m, force_n)| place_m[k] * weight(*force_n)).sum::<f64>() / all)
}

#[test]
fn a_nodule_is_found_by_pressing_and_not_by_guessing() {
    let Some((mut browser, _)) = page() else { return };
    browser.key("n");
    let searching = |s: &Value| s["controls"]["searching"] == true && says(s, "nodule is hidden");
    until(&mut browser, "a hidden nodule", searching);
    active(&mut browser);
    // two notches deeper than the first press
    (0..2).for_each(|_| browser.key("\u{e00f}"));
    let map = Map::of(&mut browser);
    let around = |[x, y]: [f64; 2], radius_m: f64| {
        let turns = (0..6).map(move |k| f64::from(k) * std::f64::consts::FRAC_PI_3);
        turns.map(move |a| [x + radius_m * a.cos(), y + radius_m * a.sin()]).chain([[x, y]])
    };
    let mut felt: Vec<_> = around([0.0; 2], 10e-3).map(|place_m| feel(&mut browser, &map, place_m)).collect();
    let near_m = stiffest(&felt);
    felt = around(near_m, 4e-3).map(|place_m| feel(&mut browser, &map, place_m)).collect();
    map.go(&mut browser, stiffest(&felt));
    browser.key("\u{e007}");
    let scored = until(&mut browser, "score", |s| s["controls"]["score"].is_number());
    println!("{}", scored["said"]);
    assert_eq!(scored["controls"]["found"], true, "{scored}");
    if let Some(folder) = std::env::var_os("PALPATE_LIVE_PICTURES") {
        browser.key("t");
        std::thread::sleep(Duration::from_secs(1));
        std::fs::write(std::path::Path::new(&folder).join("live-page.png"), browser.screenshot()).unwrap();
        browser.key("t");
    }

    // a quick and gentle guess at the edge of the block is made
    browser.key("n");
    until(&mut browser, "another nodule", searching);
    map.go(&mut browser, [-25e-3, 0.0]);
    browser.key("\u{e007}");
    let guessed = until(&mut browser, "score of a guess", |s| s["controls"]["score"].is_number());
    assert!(guessed["controls"]["found"] == false && says(&guessed, "Not found"), "{guessed}");
}
