//! Files of a page, which hands them to the browser and receives them from it.

use std::path::Path;

use eframe::egui::DroppedFileHandle;
use wasm_bindgen::JsCast;
use wasm_bindgen::prelude::Closure;
use wasm_bindgen_futures::{JsFuture, spawn_local};
use web_sys::{Document, HtmlAnchorElement, HtmlInputElement};

use super::Arrived;

/// Returns `false`: a page asks the user before it writes.
pub fn keeps_at_once() -> bool {
    false
}

/// Returns `least`, since a browser never overwrites a download.
pub fn free(_folder: &Path, least: u32) -> u32 {
    least
}

/// Saves bytes as a download.
pub fn put(_folder: &Path, name: &str, bytes: &[u8]) -> (String, bool) {
    match download(name, bytes) {
        Some(()) => (format!("Saved {name} with your downloads."), false),
        None => (format!("The browser did not take {name}."), true),
    }
}

fn document() -> Option<Document> {
    web_sys::window()?.document()
}

fn download(name: &str, bytes: &[u8]) -> Option<()> {
    let parts = js_sys::Array::of1(&js_sys::Uint8Array::from(bytes));
    let blob = web_sys::Blob::new_with_u8_array_sequence(&parts).ok()?;
    let url = web_sys::Url::create_object_url_with_blob(&blob).ok()?;
    let anchor: HtmlAnchorElement = document()?.create_element("a").ok()?.dyn_into().ok()?;
    anchor.set_href(&url);
    anchor.set_download(name);
    anchor.click();
    web_sys::Url::revoke_object_url(&url).ok()
}

pub fn fetch(file: &DroppedFileHandle, arrived: &Arrived) {
    let (file, arrived) = (DroppedFileHandle::clone(file), Arrived::clone(arrived));
    spawn_local(async move {
        if let Ok(bytes) = file.bytes_async().await
            && let Ok(mut arrived) = arrived.lock()
        {
            arrived.push((file.path().display().to_string(), bytes));
        }
    });
}

/// Opens the browser's file chooser.
pub fn choose(arrived: &Arrived) -> bool {
    let input = document().and_then(|d| d.create_element("input").ok()).and_then(|e| e.dyn_into::<HtmlInputElement>().ok());
    let Some(input) = input else { return false };
    input.set_type("file");
    input.set_accept(".trace,.toml");
    let (chosen, arrived) = (input.clone(), Arrived::clone(arrived));
    let came = Closure::once_into_js(move || {
        let Some(file) = chosen.files().and_then(|files| files.get(0)) else { return };
        spawn_local(async move {
            if let Ok(buffer) = JsFuture::from(file.array_buffer()).await
                && let Ok(mut arrived) = arrived.lock()
            {
                arrived.push((file.name(), js_sys::Uint8Array::new(&buffer).to_vec()));
            }
        });
    });
    input.set_onchange(Some(came.unchecked_ref()));
    input.click();
    true
}

pub fn read(_path: &str, _arrived: &Arrived) -> Option<String> {
    None
}
