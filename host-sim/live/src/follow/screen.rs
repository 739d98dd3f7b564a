//! The window that shows a board.

use std::path::PathBuf;

use eframe::egui::{self, Align2, CentralPanel, Color32, FontId, Key, Panel, Pos2, Rect, RichText, Ui, vec2};
use palpate::Vector3;
use palpate_loop::board_trace::Row;
use web_time::Instant;

use super::feed::{Feed, Heard, State};
use super::following::Phase;
use super::strips::Strips;
use super::words;
use crate::camera::Camera;
use crate::drawn_body::DrawnBody;
use crate::files::Files;
use crate::look::{dress, ground, legend};
use crate::message::{Frame, SILENCE_S};
use crate::shown::{Colour, Shown};
use crate::view;

/// Hint of the mouse, in the picture's corner.
const HOW: &str = "tip and arrow: measured by the board · shape: computed here · drag: orbit · wheel: zoom";
const DIM: Color32 = Color32::from_rgba_premultiplied(20, 24, 30, 190);

/// Everything on the screen.
pub struct Follow {
    pub(super) feed: Feed,
    /// File that is followed, with the path that the user gave.
    pub(super) path: String,
    pub(super) state: State,
    /// Time of the last message from the thread [s].
    heard_s: f64,
    begun: Instant,
    pub(super) shape: DrawnBody,
    /// Name of this machine's patch, or why there is none.
    pub(super) patch: Result<String, String>,
    frame: Frame,
    pub(super) camera: Camera,
    pub(super) shown: Shown,
    strips: Strips,
    pub(super) files: Files,
    /// The last sentence about a file of this window, and whether it reports a failure.
    pub(super) said: (String, bool),
    /// Whether the panel's contents fit into its width.
    panel_fits: bool,
}

impl Follow {
    /// Creates the screen for `feed`, which reads `path`; pictures go into `folder`.
    #[must_use]
    pub fn new(ctx: &egui::Context, feed: Feed, path: String, folder: PathBuf) -> Self {
        dress(ctx);
        Self {
            feed,
            path,
            state: State::default(),
            heard_s: 0.0,
            begun: Instant::now(),
            shape: DrawnBody::default(),
            patch: Err(String::new()),
            frame: Frame::default(),
            camera: Camera::of(Vector3::zeros(), 0.08),
            shown: Shown::FIRST,
            strips: Strips::default(),
            files: Files::of(folder),
            said: (String::new(), false),
            panel_fits: true,
        }
    }

    fn now_s(&self) -> f64 {
        self.begun.elapsed().as_secs_f64()
    }

    fn hear(&mut self) {
        for heard in self.feed.poll() {
            self.heard_s = self.now_s();
            self.take(heard);
        }
    }

    pub(super) fn take(&mut self, heard: Heard) {
        match heard {
            Heard::Body(body, name) => {
                self.shape = DrawnBody::of(*body);
                let (at_m, size_m) = self.shape.extent_m();
                self.camera = Camera::of(at_m, size_m);
                self.shown.most_m = self.shape.body.depth_limit_m * 0.6;
                self.patch = Ok(name);
                self.frame = Frame::default();
            }
            Heard::NoPatch(why) => {
                self.patch = Err(why);
                self.shape = DrawnBody::default();
            }
            Heard::State(mut state) => {
                if state.anew || state.row.is_none() {
                    self.strips.clear();
                    self.frame = Frame::default();
                }
                self.strips.add(&state.dots);
                if let Some(frame) = state.frame.take() {
                    self.frame = frame;
                }
                self.state = *state;
            }
        }
    }

    /// State of the file; it counts as silent also if this machine is too busy to read it.
    pub(super) fn phase(&self) -> Phase {
        match &self.state.phase {
            Phase::Live if self.now_s() - self.heard_s > SILENCE_S => Phase::Silent,
            phase => phase.clone(),
        }
    }

    pub(super) fn silent_s(&self) -> f64 {
        self.state.silent_s + (self.now_s() - self.heard_s)
    }

    /// The current record; `None` if records no longer arrive.
    pub(super) fn present(&self) -> Option<&Row> {
        self.state.row.as_ref().filter(|_| self.phase() == Phase::Live)
    }

    /// Returns the displayed state in numbers, as JSON, for scripts that drive the window.
    #[must_use]
    pub fn numbers(&self) -> serde_json::Value {
        let (row, answer) = (self.present(), self.state.answer);
        let absence = words::absence(&self.phase(), self.silent_s(), &self.path);
        let moved_m = self.shape.moved_m(&self.frame.nodes_m).into_iter().fold(0.0, f32::max);
        serde_json::json!({
            "phase": format!("{:?}", self.phase()), "says": absence.map(|[says, _]| says), "silent_s": self.silent_s(),
            "force_n": row.map(|row| words::length(row.applied_n)), "model_n": row.map(|row| words::length(row.model_n)),
            "twin_n": row.and(answer).and_then(|a| a.force_n).map(words::length),
            "differs_n": row.and(answer).and_then(|a| a.differs_n.ok()),
            "depth_m": row.map(|row| row.depth_m), "tip_m": row.map(|row| row.tip_m),
            "mode": row.map(|row| words::mode(row.mode)),
            "fault": row.and_then(Row::fault_words), "patch": self.patch.as_ref().ok(), "moved_m": moved_m,
            "nodes": self.shape.body.rest_m.len(), "records": self.state.records[0], "lost": self.state.records[1],
            "dots": self.strips.len(), "arrow_n": Vector3::from(self.drawn().force_n).norm(), "panel_fits": self.panel_fits,
        })
    }

    /// Frame to draw, with no force if there is no current record.
    fn drawn(&self) -> Frame {
        let force_n = if self.present().is_some() { self.frame.force_n } else { [0.0; 3] };
        Frame { force_n, ..self.frame.clone() }
    }

    fn top(&self, ui: &mut Ui) {
        ui.horizontal_wrapped(|ui| {
            ui.label(RichText::new("Board").strong().size(16.0));
            ui.separator();
            ui.label(RichText::new(words::force(self.present(), |row| row.applied_n)).strong().size(16.0));
            let warn = ui.visuals().error_fg_color;
            let Some(row) = self.present() else {
                self.absence(ui);
                return;
            };
            ui.label(format!("at {:.2} mm", row.depth_m * 1e3));
            ui.separator();
            let mode = RichText::new(words::mode(row.mode));
            ui.label(if row.fault == 0 { mode } else { mode.color(warn) });
            if let Some(fault) = row.fault_words() {
                ui.label(RichText::new(fault).color(warn).strong());
            }
            for limited in crate::words::limiters(row.limiters).into_iter().filter(|_| crate::words::felt(row.mode)) {
                ui.label(RichText::new(limited).color(Color32::from_rgb(190, 120, 20)));
            }
        });
    }

    /// Says why there is no current record, in the colour of a failure only if there was one
    /// before.
    pub(super) fn absence(&self, ui: &mut Ui) {
        let phase = self.phase();
        if let Some([says, _]) = words::absence(&phase, self.silent_s(), &self.path) {
            let says = RichText::new(says);
            let bad = matches!(phase, Phase::Silent | Phase::Bad(_));
            ui.label(if bad { says.color(ui.visuals().error_fg_color) } else { says });
        }
    }

    fn bottom(&self, ui: &mut Ui) {
        ui.horizontal_wrapped(|ui| {
            let text = RichText::new(&self.said.0);
            ui.label(if self.said.1 { text.color(ui.visuals().error_fg_color).strong() } else { text });
            ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
                let [records, lost] = self.state.records;
                ui.weak(format!("{records} records, {lost} lost · following {}", self.path));
            });
        });
    }

    fn picture(&mut self, ui: &mut Ui) {
        let rect = ui.available_rect_before_wrap();
        let response = ui.allocate_rect(rect, egui::Sense::click_and_drag());
        if rect.width() < 2.0 || rect.height() < 2.0 {
            return;
        }
        if response.dragged() {
            self.camera.orbit(response.drag_delta());
        }
        if response.hovered() {
            let (wheel, pinch) = ui.input(|i| (i.smooth_scroll_delta().y, i.zoom_delta()));
            self.camera.zoom(pinch * (1.0 + wheel * 0.003));
        }
        let lens = self.camera.lens(rect);
        let painter = ui.painter_at(rect);
        ground(&painter, rect, self.shown.dark);
        view::draw(&painter, &lens, &self.shape, &self.drawn(), &self.shown, &[]);
        legend(&painter, rect, &self.shown, HOW);
        if let Some(says) = words::absence(&self.phase(), self.silent_s(), &self.path) {
            over(&painter, rect, &says);
        }
    }

    fn keys(&mut self, ctx: &egui::Context) {
        if ctx.memory(|m| m.focused().is_some()) {
            return;
        }
        let down = |key| ctx.input(|i| i.key_pressed(key) && !i.modifiers.ctrl && !i.modifiers.alt && !i.modifiers.command);
        let shown = &mut self.shown;
        shown.cut ^= down(Key::V);
        shown.springs ^= down(Key::S);
        shown.rim ^= down(Key::E);
        if down(Key::J) {
            shown.colour = if shown.colour == Colour::J { Colour::Displacement } else { Colour::J };
        }
        if down(Key::T) {
            self.theme(ctx);
        }
        if down(Key::P) {
            self.files.photograph(ctx);
        }
        if down(Key::Home) {
            self.camera.reset();
        }
        for (key, factor) in [(Key::Plus, 1.15), (Key::Equals, 1.15), (Key::Minus, 1.0 / 1.15)] {
            if down(key) {
                self.camera.zoom(factor);
            }
        }
    }

    pub(super) fn theme(&mut self, ctx: &egui::Context) {
        self.shown.dark ^= true;
        ctx.set_theme(if self.shown.dark { egui::Theme::Dark } else { egui::Theme::Light });
    }

    /// Draws one frame.
    pub(super) fn show(&mut self, ui: &mut Ui) {
        self.hear();
        self.keys(ui.ctx());
        if let Some(said) = self.files.develop() {
            self.said = said;
        }
        Panel::top("state").show(ui, |ui| self.top(ui));
        Panel::bottom("said").show(ui, |ui| self.bottom(ui));
        Panel::right("board").exact_size(292.0).show(ui, |ui| {
            let most = ui.available_width();
            let shown = egui::ScrollArea::vertical().show(ui, |ui| self.panel(ui));
            self.panel_fits = shown.content_size.x <= most;
        });
        let live = self.present().is_some();
        Panel::bottom("strips").exact_size(170.0).show(ui, |ui| self.strips.show(ui, live));
        CentralPanel::no_frame().show(ui, |ui| self.picture(ui));
        ui.ctx().request_repaint_after(std::time::Duration::from_millis(16));
    }
}

/// Draws two sentences over a picture that is not current.
fn over(painter: &egui::Painter, rect: Rect, [says, how]: &[String; 2]) {
    let font = |size| FontId::proportional(size);
    let width = (rect.width() - 60.0).max(80.0);
    let says = painter.layout(says.clone(), font(20.0), Color32::WHITE, width);
    let how = painter.layout(how.clone(), font(13.0), Color32::from_gray(215), width);
    let size = vec2(says.size().x.max(how.size().x), says.size().y + how.size().y + 6.0);
    let place = Align2::CENTER_CENTER.anchor_size(rect.center(), size);
    painter.rect_filled(place.expand(14.0), 6.0, DIM);
    let centred = |galley: &egui::Galley, y: f32| Pos2::new(rect.center().x - galley.size().x / 2.0, y);
    let (first, second) = (centred(&says, place.top()), centred(&how, place.top() + says.size().y + 6.0));
    painter.galley(first, says, Color32::WHITE);
    painter.galley(second, how, Color32::WHITE);
}

impl eframe::App for Follow {
    fn ui(&mut self, ui: &mut Ui, _frame: &mut eframe::Frame) {
        self.show(ui);
    }
}

#[cfg(test)]
mod tests;
