//! The window and the page: display, mouse and keys.

mod choices;
mod lapse;

use std::path::PathBuf;

use eframe::egui::{self, CentralPanel, Color32, Panel, RichText, Ui};
use palpate::Vector3;
use palpate_loop::live::{Choice, Holding};
use web_time::{Duration, Instant};

use lapse::Lapse;

use crate::accepted;
use crate::camera::Camera;
use crate::controls::Controls;
use crate::drawn_body::DrawnBody;
use crate::files::Files;
use crate::link::Link;
use crate::look::{dress, ground, legend};
use crate::message::{Answer, Ended, Frame, Request, SILENCE_S};
use crate::pointer::Pointer;
use crate::shown::Shown;
use crate::strips::Strips;
use crate::touch::Touch;
use crate::view;
use crate::words;

/// Everything on the screen.
pub struct App {
    pub(crate) link: Box<dyn Link>,
    pub(crate) files: Files,
    pub(crate) shape: DrawnBody,
    pub(crate) frame: Frame,
    pub(crate) camera: Camera,
    pub(crate) pointer: Pointer,
    pub(crate) strips: Strips,
    pub(crate) touch: Touch,
    pub(crate) controls: Controls,
    /// The last sentence for the user, and whether it reports a failure.
    pub(crate) said: (String, bool),
    /// A path that the user is typing.
    pub(crate) path: Option<String>,
    /// Whether the panel's contents fit into its width.
    pub(crate) panel_fits: bool,
    begun: Instant,
    drawn: Vec<f64>,
    /// Time from the start to the first force that was felt [s].
    pub(crate) first_touch_s: Option<f64>,
    lapse: Lapse,
    /// Time of the last answer from the physics [s].
    heard_s: f64,
}

/// Hint of the mouse, in the picture's corner.
const HOW: &str = "button: press · drag: slide · wheel: how deep · right drag: orbit · Ctrl wheel: zoom";
/// Longest wait for the recording when the window closes.
const LAST_WORD: Duration = Duration::from_secs(3);

impl App {
    /// Creates the window; `link` leads to a physics that was created with `choice` and `holding`.
    #[must_use]
    pub fn new(ctx: &egui::Context, link: Box<dyn Link>, choice: Choice, holding: Holding) -> Self {
        dress(ctx);
        Self {
            link,
            files: Files::default(),
            shape: DrawnBody::default(),
            frame: Frame::default(),
            camera: Camera::of(Vector3::zeros(), 0.08),
            pointer: Pointer::default(),
            strips: Strips::default(),
            touch: Touch::default(),
            controls: Controls::new(choice, holding),
            said: ("Preparing the tissue ...".into(), false),
            path: None,
            panel_fits: true,
            begun: Instant::now(),
            drawn: Vec::new(),
            first_touch_s: None,
            lapse: Lapse::default(),
            heard_s: 0.0,
        }
    }

    /// Sets the folder for recordings, on a desktop.
    #[must_use]
    pub fn into_folder(mut self, folder: PathBuf) -> Self {
        self.files = Files::of(folder);
        self
    }

    /// Number of frames drawn in the last second.
    pub(crate) fn frames_per_s(&self) -> usize {
        self.drawn.len()
    }

    /// The bytes of the last recording.
    #[must_use]
    pub fn trace(&self) -> &[u8] {
        self.files.trace()
    }

    /// Returns the displayed state in numbers, as JSON, for scripts that drive the window.
    #[must_use]
    pub fn numbers(&self) -> serde_json::Value {
        let frame = &self.frame;
        let moved_m = self.shape.moved_m(&frame.nodes_m).into_iter().fold(0.0, f32::max);
        serde_json::json!({
            "force_n": Vector3::from(frame.force_n).norm(), "along_n": Vector3::from(frame.along_n).norm(), "depth_m": frame.depth_m, "moved_m": moved_m,
            "contact_m2": frame.map.as_ref().map(|map| map.area_m2), "peak_pa": frame.map.as_ref().map(|map| map.peak_pa),
            "mode": words::mode(frame.mode), "fault": words::fault(frame.fault), "limiters": words::limiters(frame.limiters),
            "ticks": frame.ticks, "dropped": frame.dropped, "ticks_per_s": frame.hz, "longest_tick_us": frame.worst_us,
            "frames_per_s": self.frames_per_s(), "first_touch_s": self.first_touch_s, "nodes": frame.nodes_m.len(),
            "stiffness_pa": self.shape.body.youngs_modulus_pa, "said": self.said.0, "refused": self.said.1,
            "recorded_ticks": frame.recorded, "body": frame.body, "tip_m": frame.tip_m, "controls": self.controls.numbers(),
            "touch": self.touch.numbers(),
            "panel_fits": self.panel_fits, "place_m": <[f32; 3]>::from(self.pointer.place_m()),
        })
    }

    fn hear(&mut self, now_s: f64, drawn_s: f64) {
        let answers = self.link.poll();
        if !answers.is_empty() {
            self.heard_s = now_s;
        } else if now_s - self.heard_s > SILENCE_S {
            (self.frame.force_n, self.frame.along_n, self.frame.depth_m) = ([0.0; 3], [0.0; 3], 0.0);
        }
        for answer in answers {
            match answer {
                Answer::Body(body) => {
                    let first = self.shape.body.number == 0;
                    let same_size = self.shape.extent_m();
                    self.controls.of_body(&body);
                    self.shape = DrawnBody::of(*body);
                    let (at_m, size_m) = self.shape.extent_m();
                    if first || (at_m, size_m) != same_size {
                        self.camera = Camera::of(at_m, size_m);
                    }
                    self.pointer.begin(&self.shape.body);
                    // the force of the previous tissue is no longer shown
                    self.frame = Frame {
                        body: self.shape.body.number,
                        nodes_m: self.shape.body.rest_m.clone(),
                        ticks: self.frame.ticks,
                        dropped: self.frame.dropped,
                        ..Frame::default()
                    };
                    self.strips.clear();
                    self.touch = Touch::default();
                    self.said = (self.controls.ready(), false);
                }
                // this frame is of the previous tissue, which is gone
                Answer::Frame(frame) if frame.body != self.shape.body.number => {}
                Answer::Frame(frame) => {
                    self.strips.add(&frame.samples);
                    self.touch.add(&frame.samples);
                    self.lapse.count(frame.dropped, drawn_s);
                    if self.first_touch_s.is_none() && Vector3::from(frame.force_n).norm() > 1e-3 {
                        self.first_touch_s = Some(self.begun.elapsed().as_secs_f64());
                    }
                    self.controls.felt(&frame);
                    self.frame = *frame;
                }
                Answer::Trace(bytes, why) => {
                    let (message, bad) = self.files.recorded(bytes);
                    let why = match why {
                        Ended::Asked => "",
                        Ended::Changed => "The recording ended with the change. ",
                        Ended::Full => "The recording is ten minutes long and ended here. ",
                    };
                    self.said = (format!("{why}{message}"), bad);
                }
                Answer::Table(table) => self.said = self.files.tabulated(&table),
                Answer::Said(text) => self.said = (text, false),
                Answer::Refused(text) => self.said = (text, true),
                Answer::Kept(kept) => self.controls.kept(kept.0, kept.1, &self.shape.body),
            }
        }
    }

    fn top(&mut self, ui: &mut Ui) {
        ui.horizontal_wrapped(|ui| {
            let force_n = Vector3::from(self.frame.force_n).norm();
            ui.label(RichText::new(self.controls.title()).strong().size(16.0));
            ui.separator();
            ui.label(RichText::new(format!("{force_n:.3} N")).strong().size(16.0));
            if self.shape.body.friction > 0.0 {
                ui.label(format!("along the surface {:.3} N", Vector3::from(self.frame.along_n).norm()));
            }
            ui.label(format!("at {:.2} mm", self.frame.depth_m * 1e3));
            ui.weak(format!("a press goes {:.1} mm deep", self.pointer.press_m * 1e3)).on_hover_text("wheel, PageUp, PageDown");
            ui.separator();
            let warn = ui.visuals().error_fg_color;
            let silent = self.begun.elapsed().as_secs_f64() - self.heard_s > SILENCE_S;
            let mode = RichText::new(if silent { "the tissue is busy: no force" } else { words::mode(self.frame.mode) });
            ui.label(if self.frame.fault == 0 { mode } else { mode.color(warn) });
            if let Some(fault) = words::fault(self.frame.fault) {
                ui.label(RichText::new(fault).color(warn).strong());
            }
            // no limiter is reported while no force is output
            let felt = words::felt(self.frame.mode);
            for limited in words::limiters(self.frame.limiters).into_iter().filter(|_| felt) {
                ui.label(RichText::new(limited).color(Color32::from_rgb(190, 120, 20)));
            }
        });
    }

    fn bottom(&self, ui: &mut Ui) {
        ui.horizontal_wrapped(|ui| {
            let now_s = ui.input(|i| i.time);
            // the reason for dropped time is shown for a while, then the last sentence appears
            // again
            let lapse = self.lapse.sentence(now_s);
            let (text, bad) = lapse.as_ref().map_or((&self.said.0, self.said.1), |told| (told, true));
            let text = RichText::new(text);
            ui.label(if bad { text.color(ui.visuals().error_fg_color).strong() } else { text });
            ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
                let touch = self.first_touch_s.map_or(String::new(), |s| format!("first touch {s:.1} s · "));
                let lapse = self.lapse.ms(now_s).map_or(String::new(), |ms| format!("{ms} ms dropped · "));
                ui.weak(format!(
                    "{touch}{:.0} ticks/s, longest {:.0} us · {lapse}{} frames/s",
                    self.frame.hz,
                    self.frame.worst_us,
                    self.frames_per_s()
                ));
            });
        });
    }

    fn picture(&mut self, ui: &mut Ui) {
        let rect = ui.available_rect_before_wrap();
        let response = ui.allocate_rect(rect, egui::Sense::click_and_drag());
        if rect.width() < 2.0 || rect.height() < 2.0 {
            // a window without a size contains nothing to aim at
            self.link.send(Request::Aim(None));
            return;
        }
        let aim = self.pointer.aim(ui, &response, &mut self.camera, &self.shape, &self.frame);
        self.link.send(Request::Aim(aim));
        let lens = self.camera.lens(rect);
        let dark = ui.visuals().dark_mode;
        let painter = ui.painter_at(rect);
        ground(&painter, rect, dark);
        let shown = Shown { dark, most_pa: self.controls.stiffness_kpa * 1e3, ..self.controls.shown };
        view::draw(&painter, &lens, &self.shape, &self.frame, &shown, self.controls.nodules());
        self.touch.draw(&painter, rect, dark, self.shape.body.friction);
        accepted::draw(&painter, rect, dark, &self.controls.choice.scene);
        legend(&painter, rect, &shown, HOW);
        self.controls.marks(&painter, &lens, &self.shape, view::cut(&lens, &self.shape, &self.frame, &shown).as_ref());
    }

    /// Draws one frame.
    pub(crate) fn show(&mut self, ui: &mut Ui) {
        let now_s = self.begun.elapsed().as_secs_f64();
        self.drawn.retain(|t| *t > now_s - 1.0);
        self.drawn.push(now_s);
        self.hear(now_s, ui.input(|i| i.time));
        self.keys(ui.ctx());
        self.opened(ui.ctx());
        self.typed(ui.ctx());
        if let Some(said) = self.files.develop() {
            self.said = said;
        }
        Panel::top("state").show(ui, |ui| self.top(ui));
        Panel::bottom("said").show(ui, |ui| self.bottom(ui));
        Panel::right("controls").exact_size(272.0).show(ui, |ui| {
            let most = ui.available_width();
            let shown = egui::ScrollArea::vertical().show(ui, |ui| self.controls(ui));
            self.panel_fits = shown.content_size.x <= most;
        });
        Panel::bottom("strips").exact_size(170.0).show(ui, |ui| self.strips.show(ui));
        CentralPanel::no_frame().show(ui, |ui| self.picture(ui));
        ui.ctx().request_repaint();
    }
}

impl eframe::App for App {
    fn ui(&mut self, ui: &mut Ui, _frame: &mut eframe::Frame) {
        self.show(ui);
    }

    /// Ends a running recording and writes it, so that it is not lost.
    fn on_exit(&mut self, _gl: Option<&eframe::glow::Context>) {
        if self.frame.recorded.is_none() {
            return;
        }
        self.link.send(Request::Finish);
        let begun = Instant::now();
        while begun.elapsed() < LAST_WORD {
            for answer in self.link.poll() {
                if let Answer::Trace(bytes, _) = answer {
                    eprintln!("{}", self.files.recorded(bytes).0);
                    return;
                }
            }
            std::thread::sleep(Duration::from_millis(1));
        }
        eprintln!("palpate: the recording could not be ended within {} s", LAST_WORD.as_secs());
    }

    #[cfg(target_family = "wasm")]
    fn as_any_mut(&mut self) -> Option<&mut dyn std::any::Any> {
        Some(&mut *self)
    }
}

#[cfg(test)]
mod tests;
