//! Output of traces, tables and pictures, and input of traces and scenes: on the disk of a desktop,
//! or as downloads of a page.

use std::path::PathBuf;
use std::sync::{Arc, Mutex};

use eframe::egui::{ColorImage, Context, ScreenshotCallback, ViewportCommand};

use crate::link::Link;
use crate::message::Request;

/// The last recording, and the place for files.
#[derive(Debug, Default)]
pub struct Files {
    folder: PathBuf,
    trace: Option<Vec<u8>>,
    /// Number of the last recording, and of the last file of any kind.
    number: u32,
    last: u32,
    picture: Arc<Mutex<Option<Arc<ColorImage>>>>,
    arrived: Arrived,
}

/// Files that have been read, with their names: a browser reads asynchronously.
type Arrived = Arc<Mutex<Vec<(String, Vec<u8>)>>>;

impl Files {
    /// Keeps files in a folder of a desktop's disk.
    #[must_use]
    pub fn of(folder: PathBuf) -> Self {
        Self { folder, ..Self::default() }
    }

    /// Writes a recording as soon as it ends, so that nothing is lost. Returns a sentence, and
    /// whether it reports a failure.
    pub fn recorded(&mut self, bytes: Vec<u8>) -> (String, bool) {
        let kb = bytes.len() / 1024;
        let message = match keeps_at_once() {
            true => {
                let (message, number) = self.keep("trace", &bytes);
                self.number = number;
                message
            }
            false => {
                self.number += 1;
                (format!("Recorded {kb} kB: save it (W), or replay it here (L)."), false)
            }
        };
        self.trace = Some(bytes);
        message
    }

    /// Writes a file under an unused number; returns a sentence, whether it reports a failure, and
    /// the number.
    fn keep(&mut self, ending: &str, bytes: &[u8]) -> ((String, bool), u32) {
        self.last = free(&self.folder, self.last + 1);
        (put(&self.folder, &format!("live-{}.{ending}", self.last), bytes), self.last)
    }

    /// Bytes of the recorded trace.
    #[must_use]
    pub fn trace(&self) -> &[u8] {
        self.trace.as_deref().unwrap_or_default()
    }

    /// Whether there is a recorded trace.
    #[must_use]
    pub fn has_trace(&self) -> bool {
        self.trace.is_some()
    }

    /// Replays the recorded trace on this machine.
    pub fn replay(&self, link: &mut dyn Link) -> (String, bool) {
        let Some(trace) = &self.trace else { return nothing() };
        link.send(Request::Replay(trace.clone()));
        ("Repeating the recording ...".into(), false)
    }

    /// Writes the trace; returns a sentence, and whether it reports a failure.
    pub fn save(&self) -> (String, bool) {
        self.trace.as_ref().map_or_else(nothing, |bytes| put(&self.folder, &format!("live-{}.trace", self.number), bytes))
    }

    /// Requests a table of the trace's ticks, for which the physics replays the trace.
    pub fn tabulate(&self, link: &mut dyn Link) -> (String, bool) {
        let Some(bytes) = &self.trace else { return nothing() };
        link.send(Request::Table(bytes.clone()));
        ("Repeating the recording for its table ...".into(), false)
    }

    /// Writes the received table.
    pub fn tabulated(&self, table: &str) -> (String, bool) {
        put(&self.folder, &format!("live-{}.csv", self.number), table.as_bytes())
    }

    /// Requests a picture of the next frame.
    pub fn photograph(&self, ctx: &Context) {
        let (picture, ctx2) = (Arc::clone(&self.picture), ctx.clone());
        ctx.send_viewport_cmd(ViewportCommand::Screenshot(ScreenshotCallback::new(move |image| {
            if let Ok(mut picture) = picture.lock() {
                *picture = Some(image);
            }
            ctx2.request_repaint();
        })));
    }

    /// Writes the requested picture once it has arrived.
    pub fn develop(&mut self) -> Option<(String, bool)> {
        let image = self.picture.lock().ok()?.take()?;
        Some(match png(&image) {
            Some(bytes) => self.keep("png", &bytes).0,
            None => ("The picture could not be written.".into(), true),
        })
    }

    /// Lets the user choose a file; returns `false` on a desktop, where the user types a path
    /// instead.
    pub fn ask(&self) -> bool {
        choose(&self.arrived)
    }

    /// Reads a file by its path, on a desktop.
    pub fn open(&self, path: &str) -> Option<String> {
        read(path, &self.arrived)
    }

    /// Files that were dropped or chosen and have arrived: name and content.
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
#[path = "files/disk.rs"]
mod place;
#[cfg(target_family = "wasm")]
#[path = "files/downloads.rs"]
mod place;

use place::{choose, fetch, free, keeps_at_once, put, read};
