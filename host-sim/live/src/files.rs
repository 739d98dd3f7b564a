//! Traces, tables and pictures out; traces and scenes in: the disk of a desktop, the downloads of a page.

use std::sync::{Arc, Mutex};

use eframe::egui::{ColorImage, Context, ScreenshotCallback, ViewportCommand};
use palpate_sim::live::replay::{self, Replayed};
use palpate_sim::live::trace::Trace;

use crate::link::Link;
use crate::message::Request;

/// The last recording, and where files go.
#[derive(Debug, Default)]
pub struct Files {
    trace: Option<Vec<u8>>,
    count: u32,
    picture: Arc<Mutex<Option<Arc<ColorImage>>>>,
    arrived: Arrived,
}

/// Files read so far, by name: a browser takes its time.
type Arrived = Arc<Mutex<Vec<(String, Vec<u8>)>>>;

impl Files {
    /// A recording ended: it is written at once, so that nothing is lost.
    pub fn recorded(&mut self, bytes: Vec<u8>) -> String {
        let kb = bytes.len() / 1024;
        self.count += 1;
        self.trace = Some(bytes);
        match keeps_at_once() {
            true => format!("{} {kb} kB", self.save().0),
            false => format!("Recorded {kb} kB: save it, or replay it here."),
        }
    }

    /// Its bytes.
    #[must_use]
    pub fn trace(&self) -> &[u8] {
        self.trace.as_deref().unwrap_or_default()
    }

    /// There is one.
    #[must_use]
    pub fn has_trace(&self) -> bool {
        self.trace.is_some()
    }

    /// Repeats it, here.
    pub fn replay(&self, link: &mut dyn Link) {
        if let Some(trace) = &self.trace {
            link.send(Request::Replay(trace.clone()));
        }
    }

    /// Writes the trace: a sentence, and whether it is bad news.
    pub fn save(&self) -> (String, bool) {
        self.trace.as_ref().map_or_else(nothing, |bytes| put(&format!("live-{}.trace", self.count), bytes))
    }

    /// Writes the ticks as a table.
    pub fn csv(&self) -> (String, bool) {
        let Some(bytes) = &self.trace else { return nothing() };
        let table = Trace::read(bytes).map_err(|e| e.to_string()).and_then(|trace| {
            let again: Replayed = replay::replay(&trace).map_err(|e| e.to_string())?;
            Ok(replay::table(&again))
        });
        match table {
            Ok(table) => put(&format!("live-{}.csv", self.count), table.as_bytes()),
            Err(why) => (why, true),
        }
    }

    /// Takes a picture of the next frame.
    pub fn photograph(&self, ctx: &Context) {
        let (picture, ctx2) = (Arc::clone(&self.picture), ctx.clone());
        ctx.send_viewport_cmd(ViewportCommand::Screenshot(ScreenshotCallback::new(move |image| {
            if let Ok(mut picture) = picture.lock() {
                *picture = Some(image);
            }
            ctx2.request_repaint();
        })));
    }

    /// Writes a picture that was taken.
    pub fn develop(&mut self) -> Option<(String, bool)> {
        let image = self.picture.lock().ok()?.take()?;
        self.count += 1;
        Some(match png(&image) {
            Some(bytes) => put(&format!("live-{}.png", self.count), &bytes),
            None => ("The picture could not be written.".into(), true),
        })
    }

    /// Files dropped, as they arrive: name and content.
    pub fn opened(&self, ctx: &Context) -> Vec<(String, Vec<u8>)> {
        for file in ctx.input(|i| i.raw.dropped_files.clone()) {
            fetch(&file, &self.arrived);
        }
        self.arrived.lock().map(|mut arrived| std::mem::take(&mut *arrived)).unwrap_or_default()
    }
}

fn nothing() -> (String, bool) {
    ("Nothing is recorded yet: press R first.".into(), true)
}

fn png(image: &ColorImage) -> Option<Vec<u8>> {
    let mut bytes = Vec::new();
    let [width, height] = image.size;
    let mut encoder = png::Encoder::new(&mut bytes, u32::try_from(width).ok()?, u32::try_from(height).ok()?);
    encoder.set_color(png::ColorType::Rgb);
    let mut writer = encoder.write_header().ok()?;
    let data: Vec<u8> = image.pixels.iter().flat_map(|p| [p.r(), p.g(), p.b()]).collect();
    writer.write_image_data(&data).ok()?;
    writer.finish().ok()?;
    Some(bytes)
}

#[cfg(not(target_family = "wasm"))]
mod place {
    use eframe::egui::DroppedFileHandle;

    use super::Arrived;

    /// A desktop has a folder for it.
    pub fn keeps_at_once() -> bool {
        true
    }

    /// Into out/live.
    pub fn put(name: &str, bytes: &[u8]) -> (String, bool) {
        let folder = std::env::var_os("PALPATE_LIVE_OUT").map_or_else(|| "out/live".into(), std::path::PathBuf::from);
        let path = folder.join(name);
        match std::fs::create_dir_all(&folder).and_then(|()| std::fs::write(&path, bytes)) {
            Ok(()) => (format!("Wrote {}.", path.display()), false),
            Err(why) => (format!("Cannot write {}: {why}: start in a folder that can be written.", path.display()), true),
        }
    }

    pub fn fetch(file: &DroppedFileHandle, arrived: &Arrived) {
        if let (Ok(bytes), Ok(mut arrived)) = (file.bytes(), arrived.lock()) {
            arrived.push((file.path().display().to_string(), bytes));
        }
    }
}

#[cfg(target_family = "wasm")]
mod place {
    use eframe::egui::DroppedFileHandle;

    use super::Arrived;
    use wasm_bindgen::JsCast;

    /// A page asks before it writes.
    pub fn keeps_at_once() -> bool {
        false
    }

    /// As a download.
    pub fn put(name: &str, bytes: &[u8]) -> (String, bool) {
        match download(name, bytes) {
            Some(()) => (format!("Saved {name} with your downloads."), false),
            None => (format!("The browser did not take {name}."), true),
        }
    }

    fn download(name: &str, bytes: &[u8]) -> Option<()> {
        let parts = js_sys::Array::of1(&js_sys::Uint8Array::from(bytes));
        let blob = web_sys::Blob::new_with_u8_array_sequence(&parts).ok()?;
        let url = web_sys::Url::create_object_url_with_blob(&blob).ok()?;
        let document = web_sys::window()?.document()?;
        let anchor: web_sys::HtmlAnchorElement = document.create_element("a").ok()?.dyn_into().ok()?;
        anchor.set_href(&url);
        anchor.set_download(name);
        anchor.click();
        web_sys::Url::revoke_object_url(&url).ok()
    }

    pub fn fetch(file: &DroppedFileHandle, arrived: &Arrived) {
        let (file, arrived) = (DroppedFileHandle::clone(file), Arrived::clone(arrived));
        wasm_bindgen_futures::spawn_local(async move {
            if let Ok(bytes) = file.bytes_async().await
                && let Ok(mut arrived) = arrived.lock()
            {
                arrived.push((file.path().display().to_string(), bytes));
            }
        });
    }
}

use place::{fetch, keeps_at_once, put};
