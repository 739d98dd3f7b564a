//! Loading of the page, from servers of several kinds. If it fails, the page gives the reason, and
//! does not stay at "Preparing the tissue" for ever.

use std::path::Path;
use std::time::{Duration, Instant};

use crate::driver::{Browser, serve};
use crate::{LONGEST, MIDDLE, active, empty, let_go, page, press, repeated, until};

/// The sentence that the page shows, once it is no longer the first one.
fn sentence(browser: &mut Browser) -> String {
    let begun = Instant::now();
    loop {
        let shown = browser.run("const p = document.getElementById('said'); return p.hidden ? '' : p.textContent;");
        let shown = shown.as_str().unwrap_or_default().to_owned();
        if !shown.is_empty() && !shown.starts_with("Preparing") {
            println!("{shown}");
            return shown;
        }
        assert!(begun.elapsed() < LONGEST, "no sentence: {shown:?}");
        std::thread::sleep(Duration::from_millis(50));
    }
}

/// Maps the content of a file to its new content; `None` removes the file.
type Change<'a> = &'a dyn Fn(Vec<u8>) -> Option<Vec<u8>>;

/// A copy of the page's folder with one file changed.
fn changed(folder: &Path, name: &str, change: Change) -> tempfile::TempDir {
    let copy = tempfile::tempdir().unwrap();
    for file in std::fs::read_dir(folder).unwrap().flatten() {
        let bytes = std::fs::read(file.path()).unwrap();
        let bytes = if file.file_name() == name { change(bytes) } else { Some(bytes) };
        if let Some(bytes) = bytes {
            std::fs::write(copy.path().join(file.file_name()), bytes).unwrap();
        }
    }
    copy
}

#[test]
fn a_server_that_unpacks_what_is_packed_is_no_obstacle() {
    let Some((mut browser, folder)) = empty() else { return };
    browser.go(&serve(&folder, true));
    active(&mut browser);
}

#[test]
fn as_one_file_the_page_needs_no_server() {
    let Some((mut browser, _)) = empty() else { return };
    let Some(file) = std::env::var_os("PALPATE_LIVE_ONE_FILE") else {
        println!("skipped: PALPATE_LIVE_ONE_FILE names no file: host-sim/live/test makes it");
        return;
    };
    // the file is in a folder of its own, so nothing beside it can be loaded
    let alone = tempfile::tempdir().unwrap();
    let page = alone.path().join("page.html");
    std::fs::copy(file, &page).unwrap();
    browser.go(&format!("file://{}", page.display()));
    active(&mut browser);
    browser.key("r");
    until(&mut browser, "recording", |s| s["recorded_ticks"].as_u64().is_some_and(|t| t > 800));
    press(&mut browser, MIDDLE, 3e-3);
    let_go(&mut browser, MIDDLE);
    browser.key("r");
    until(&mut browser, "recorded", |s| s["recorded_ticks"].is_null());
    assert!(repeated(&browser.trace()).telemetry.iter().any(|t| t.applied_n.norm() > 0.05));
}

#[test]
fn a_page_that_cannot_start_says_why() {
    let Some((mut browser, folder)) = empty() else { return };
    browser.go(&format!("file://{}/index.html", folder.canonicalize().unwrap().display()));
    assert!(sentence(&mut browser).contains("serve this folder"));
    let packed = "palpate_live.wasm.gz";
    let none = |_| None;
    let other = |_| Some(b"<!doctype html>".to_vec());
    let half = |bytes: Vec<u8>| Some(bytes[..bytes.len() / 2].to_vec());
    let cases: [(&str, Change, &str); 8] = [
        ("page.js", &none, "page.js does not load"),
        ("page.js", &|_| Some(b"no script".to_vec()), "did not start (Uncaught SyntaxError"),
        ("palpate_live.js", &none, "palpate_live.js"),
        (packed, &none, "404"),
        (packed, &other, "something else"),
        (packed, &half, "cut off"),
        ("worker.js", &none, "worker.js does not start"),
        ("worker.js", &planted, "The physics stopped (planted)"),
    ];
    for (name, change, says) in cases {
        let copy = changed(&folder, name, change);
        browser.go(&serve(copy.path(), false));
        let shown = sentence(&mut browser);
        assert!(shown.contains(says), "{name}: {shown}");
    }
}

/// The page's script, with a worker that fails in a promise as it starts.
fn planted(bytes: Vec<u8>) -> Option<Vec<u8>> {
    let script = String::from_utf8(bytes).unwrap();
    let failing = script.replace("await init(", "throw new Error('planted'); await init(");
    assert_ne!(script, failing);
    Some(failing.into_bytes())
}

#[test]
fn a_page_that_records_asks_before_it_closes() {
    let Some((mut browser, _)) = page() else { return };
    let asks = "return !dispatchEvent(new Event('beforeunload', { cancelable: true }));";
    assert_eq!(browser.run(asks), false);
    browser.key("r");
    until(&mut browser, "recording", |s| s["recorded_ticks"].is_u64());
    assert_eq!(browser.run(asks), true);
    browser.key("r");
    until(&mut browser, "recorded", |s| s["recorded_ticks"].is_null());
    assert_eq!(browser.run(asks), false);
}
