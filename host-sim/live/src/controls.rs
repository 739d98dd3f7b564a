//! The panel: presets, sliders, device and hand, recording, the exercise; and the keys for all of it.

use eframe::egui::{self, Align2, Color32, ComboBox, FontId, Key, Painter, Rect, RichText, Slider, Stroke, Ui, pos2, vec2};
use palpate::Vector3;
use palpate_sim::closed_loop::device::PROFILES;
use palpate_sim::closed_loop::hand::HANDS;
use palpate_sim::live::{Choice, Exercise, Found, Holding, Nodule, SIZES};
use palpate_sim::scene::PRESETS;
use web_time::Instant;

use crate::app::App;
use crate::camera::Lens;
use crate::message::{Body, Frame, Request};
use crate::shape::Shape;
use crate::view::{Colour, LEAST_J, Shown, scale, screen};

/// A nodule as the slider begins with it.
const NODULE: Nodule = Nodule { place_m: [0.004, 0.0], depth_m: 9e-3, radius_m: 6e-3, ratio: 10.0 };

/// What the user chose.
pub struct Controls {
    /// What is pressed.
    pub choice: Choice,
    /// Who holds the probe.
    pub holding: Holding,
    /// What is drawn.
    pub shown: Shown,
    /// Stiffness [kPa] and damping [1/s] on the sliders.
    stiffness_kpa: f32,
    damping_per_s: f32,
    nodule: Option<Nodule>,
    block: bool,
    exercise: Option<Search>,
    found: Option<(Found, [f64; 2], Nodule)>,
    seed: u64,
    light: bool,
}

/// An exercise under way.
struct Search {
    exercise: Exercise,
    begun: Instant,
    peak_n: f32,
}

impl Controls {
    /// As the physics was told.
    #[must_use]
    pub fn new(choice: Choice, holding: Holding) -> Self {
        let shown = Shown { colour: Colour::Displacement, springs: false, rim: false, dark: false, most_m: 4e-3 };
        Self {
            nodule: choice.nodule,
            choice,
            holding,
            shown,
            stiffness_kpa: 3.5,
            damping_per_s: 40.0,
            block: true,
            exercise: None,
            found: None,
            seed: 1,
            light: true,
        }
    }

    /// Another body is there.
    pub fn of_body(&mut self, body: &Body) {
        self.stiffness_kpa = body.youngs_modulus_pa * 1e-3;
        self.damping_per_s = body.node_damping_per_s;
        self.block = body.block;
        self.shown.most_m = body.depth_limit_m * 0.6;
        if let Some(choice) = &body.choice {
            self.choice = choice.clone();
        }
    }

    /// What is chosen, in numbers.
    #[must_use]
    pub fn numbers(&self) -> serde_json::Value {
        serde_json::json!({
            "stiffness_kpa": self.stiffness_kpa, "searching": self.exercise.is_some(),
            "score": self.found.map(|(found, ..)| found.score), "device": self.holding.device,
        })
    }

    /// What is pressed, for a title.
    #[must_use]
    pub fn title(&self) -> String {
        match &self.exercise {
            Some(_) => "Find the nodule".into(),
            None => self.choice.scene.clone(),
        }
    }

    /// What a frame told.
    pub fn felt(&mut self, frame: &Frame) {
        if let Some(search) = &mut self.exercise {
            search.peak_n = search.peak_n.max(Vector3::from(frame.force_n).norm());
        }
    }

    /// The colours' scale.
    pub fn legend(&self, painter: &Painter, rect: Rect, dark: bool) {
        let ink = if dark { Color32::from_gray(225) } else { Color32::from_gray(50) };
        let (title, ends) = match self.shown.colour {
            Colour::Displacement => ("moved by, mm", ["0".into(), format!("{:.1}", self.shown.most_m * 1e3)]),
            Colour::J => ("J, volume / rest volume", ["1".into(), format!("{LEAST_J}")]),
        };
        let bar = Rect::from_min_size(rect.left_top() + vec2(14.0, 30.0), vec2(150.0, 10.0));
        painter.text(bar.left_top() - vec2(0.0, 4.0), Align2::LEFT_BOTTOM, title, FontId::proportional(13.0), ink);
        for k in 0..50_u8 {
            let x = bar.left() + f32::from(k) * 3.0;
            let piece = Rect::from_min_size(pos2(x, bar.top()), vec2(3.0, 10.0));
            painter.rect_filled(piece, 0.0, screen(scale(f32::from(k) / 49.0)));
        }
        let [low, high] = ends;
        painter.text(bar.left_bottom() + vec2(0.0, 2.0), Align2::LEFT_TOP, low, FontId::proportional(12.0), ink);
        painter.text(bar.right_bottom() + vec2(0.0, 2.0), Align2::RIGHT_TOP, high, FontId::proportional(12.0), ink);
        let how = "button: press · drag: slide · wheel: how deep · right drag: orbit · Ctrl wheel: zoom";
        painter.text(
            rect.right_top() + vec2(-12.0, 8.0),
            Align2::RIGHT_TOP,
            how,
            FontId::proportional(12.0),
            ink.gamma_multiply(0.7),
        );
    }

    /// Where the answer was, and where the nodule.
    pub fn marks(&self, painter: &Painter, lens: &Lens, shape: &Shape) {
        let Some((_, answer, nodule)) = &self.found else { return };
        let top_m = shape.body.site_m[2] + 0.5e-3;
        for (place, radius_m, colour, name) in [
            (nodule.place_m, nodule.radius_m as f32, Color32::from_rgb(200, 40, 40), "nodule"),
            (*answer, 1.5e-3, Color32::from_rgb(20, 60, 160), "your answer"),
        ] {
            let middle = Vector3::new(place[0] as f32, place[1] as f32, top_m);
            let ring = (0..=32_u8).filter_map(|k| {
                let turn = f32::from(k) * std::f32::consts::TAU / 32.0;
                lens.project(&(middle + Vector3::new(turn.cos(), turn.sin(), 0.0) * radius_m)).map(|p| p.0)
            });
            painter.add(egui::Shape::line(ring.collect(), Stroke::new(2.5, colour)));
            if let Some((pixel, _)) = lens.project(&(middle + Vector3::x() * radius_m)) {
                painter.text(pixel + vec2(6.0, 0.0), Align2::LEFT_CENTER, name, FontId::proportional(14.0), colour);
            }
        }
    }
}

impl App {
    /// Tells the physics what is chosen now.
    fn choose(&mut self) {
        let controls = &mut self.controls;
        controls.choice.nodule =
            controls.exercise.as_ref().map(|s| s.exercise.hidden).or(controls.nodule.filter(|_| controls.block));
        self.link.send(Request::Choose(controls.choice.clone(), controls.holding.clone()));
    }

    fn rechoose(&mut self, choice: Choice) {
        self.controls.choice = choice;
        self.controls.nodule = self.controls.choice.nodule;
        (self.controls.exercise, self.controls.found) = (None, None);
        self.said = ("Preparing the tissue ...".into(), false);
        self.choose();
    }

    fn stiffen(&mut self, kpa: f32) {
        self.controls.stiffness_kpa = kpa.clamp(1.0, 100.0);
        self.controls.choice.youngs_modulus_pa = Some(f64::from(self.controls.stiffness_kpa) * 1e3);
        self.choose();
    }

    /// Starts or ends the exercise.
    fn search(&mut self) {
        let controls = &mut self.controls;
        controls.found = None;
        if controls.exercise.take().is_none() {
            controls.seed = controls.seed.wrapping_add(self.frame.ticks | 1);
            let exercise = Exercise::hide(controls.seed);
            controls.exercise = Some(Search { exercise, begun: Instant::now(), peak_n: 0.0 });
            let nodes = controls.choice.nodes;
            controls.choice = Choice { nodes, ..Choice::preset("block") };
            (controls.shown.springs, controls.nodule) = (false, None);
        }
        self.choose();
    }

    /// The place under the tip is the answer.
    fn answer(&mut self) {
        let place_m = self.pointer.place_m();
        let Some(search) = self.controls.exercise.take() else { return };
        let place_m = [f64::from(place_m.x), f64::from(place_m.y)];
        let found = search.exercise.judge(place_m, search.peak_n.into(), search.begun.elapsed().as_secs_f64());
        self.said = (
            format!(
                "Score {:.2}: {:.1} mm off, strongest press {:.2} N, {:.0} s.",
                found.score,
                found.apart_m * 1e3,
                found.peak_n,
                found.time_s
            ),
            false,
        );
        self.controls.found = Some((found, place_m, search.exercise.hidden));
        // what was felt stays, to be felt again
        self.controls.nodule = Some(search.exercise.hidden);
    }

    fn record(&mut self) {
        self.link.send(if self.frame.recorded.is_some() { Request::Finish } else { Request::Record });
    }

    /// Keys, unless a field has the focus.
    pub(crate) fn keys(&mut self, ctx: &egui::Context) {
        if ctx.memory(|m| m.focused().is_some()) {
            return;
        }
        let pressed = ctx.input(|i| {
            let all = [
                Key::C,
                Key::D,
                Key::E,
                Key::Enter,
                Key::N,
                Key::P,
                Key::R,
                Key::S,
                Key::T,
                Key::J,
                Key::Minus,
                Key::Plus,
                Key::Equals,
                Key::OpenBracket,
                Key::CloseBracket,
                Key::Home,
                Key::PageDown,
                Key::PageUp,
                Key::L,
            ];
            all.into_iter().filter(|k| i.key_pressed(*k)).collect::<Vec<_>>()
        });
        let limit_m = self.shape.body.depth_limit_m;
        for key in pressed {
            match key {
                Key::C => self.link.send(Request::Clear),
                Key::R => self.record(),
                Key::N => self.search(),
                Key::Enter => self.answer(),
                Key::P => self.files.photograph(ctx),
                Key::L => self.files.replay(&mut *self.link),
                Key::S => self.controls.shown.springs ^= true,
                Key::E => self.controls.shown.rim ^= true,
                Key::J => self.recolour(),
                Key::T | Key::D => self.theme(ctx),
                Key::Plus | Key::Equals => self.camera.zoom(1.15),
                Key::Minus => self.camera.zoom(1.0 / 1.15),
                Key::Home => self.camera.reset(),
                Key::OpenBracket => self.stiffen(self.controls.stiffness_kpa / 1.25),
                Key::CloseBracket => self.stiffen(self.controls.stiffness_kpa * 1.25),
                Key::PageDown => self.pointer.press_m = (self.pointer.press_m + 0.5e-3).min(limit_m),
                Key::PageUp => self.pointer.press_m = (self.pointer.press_m - 0.5e-3).max(0.0),
                _ => {}
            }
        }
    }

    fn recolour(&mut self) {
        let colour = &mut self.controls.shown.colour;
        *colour = if *colour == Colour::J { Colour::Displacement } else { Colour::J };
    }

    fn theme(&mut self, ctx: &egui::Context) {
        self.controls.light ^= true;
        ctx.set_theme(if self.controls.light { egui::Theme::Light } else { egui::Theme::Dark });
    }

    /// A dropped or opened file: a trace or a scene.
    pub(crate) fn opened(&mut self, ctx: &egui::Context) {
        for (name, bytes) in self.files.opened(ctx) {
            if bytes.starts_with(&palpate_sim::live::trace::MAGIC) {
                self.link.send(Request::Replay(bytes));
            } else if name.ends_with(".toml") {
                let text = String::from_utf8_lossy(&bytes).into_owned();
                self.rechoose(Choice { text, ..Choice::preset(&name) });
            } else {
                self.said = (format!("{name} is neither a live trace nor a scene (.toml): drop one of these."), true);
            }
        }
    }

    /// The panel.
    pub(crate) fn controls(&mut self, ui: &mut Ui) {
        ui.spacing_mut().slider_width = 120.0;
        self.tissue(ui);
        ui.separator();
        self.held_by(ui);
        ui.separator();
        self.shown(ui);
        ui.separator();
        self.exercise(ui);
        ui.separator();
        self.recording(ui);
        ui.separator();
        ui.collapsing("Keys", |ui| {
            for line in [
                "arrows: move · Space: press",
                "PageUp, PageDown: how deep",
                "[ ]: softer, stiffer",
                "Shift arrows: orbit · + -: zoom · Home: reset",
                "S springs · E edge · J colour · T light, dark",
                "N: find the nodule · Enter: it is here",
                "R: record · L: replay · P: picture · C: clear a fault",
            ] {
                ui.label(RichText::new(line).size(12.0));
            }
        });
    }

    fn tissue(&mut self, ui: &mut Ui) {
        ui.strong("Tissue");
        let mut preset = None;
        ui.horizontal(|ui| {
            ComboBox::from_id_salt("preset").selected_text(self.controls.choice.scene.clone()).show_ui(ui, |ui| {
                for (name, _) in PRESETS.iter().filter(|(name, _)| *name != "liver") {
                    if ui.selectable_label(self.controls.choice.scene == *name, *name).clicked() {
                        preset = Some(Choice::preset(name));
                    }
                }
            });
            if self.controls.block {
                let nodes = self.shape.body.rest_m.len();
                ComboBox::from_id_salt("nodes").selected_text(format!("{nodes} nodes")).width(90.0).show_ui(ui, |ui| {
                    for size in SIZES {
                        if ui.selectable_label(nodes == size, format!("{size} nodes")).clicked() {
                            preset = Some(Choice { nodes: Some(size), ..self.controls.choice.clone() });
                        }
                    }
                });
            }
        });
        if let Some(choice) = preset {
            self.rechoose(choice);
        }
        let mut kpa = self.controls.stiffness_kpa;
        if ui.add(Slider::new(&mut kpa, 1.0..=100.0).logarithmic(true).text("stiffness kPa")).changed() {
            self.stiffen(kpa);
        }
        if ui.add(Slider::new(&mut self.controls.damping_per_s, 0.0..=200.0).text("damping 1/s")).changed() {
            self.controls.choice.node_damping_per_s = Some(f64::from(self.controls.damping_per_s));
            self.choose();
        }
        if self.frame.waits {
            ui.weak("changes when you let go");
        }
        if self.controls.block && self.controls.exercise.is_none() {
            self.nodule(ui);
        }
        let fitted = match self.shape.body.fitted_places {
            0 => "by formulas, not calibrated".to_owned(),
            places => format!("calibrated over {places} places"),
        };
        let body = &self.shape.body;
        ui.weak(format!("{} nodes, {} springs, {} tets; {fitted}", body.rest_m.len(), body.springs.len(), body.tets.len()));
    }

    fn nodule(&mut self, ui: &mut Ui) {
        let mut there = self.controls.nodule.is_some();
        if ui.checkbox(&mut there, "nodule inside").changed() {
            self.controls.nodule = there.then_some(NODULE);
            self.controls.found = None;
            self.choose();
        }
        let Some(mut nodule) = self.controls.nodule else { return };
        let mut released = false;
        let [mut x, mut y] = nodule.place_m.map(|m| m * 1e3);
        let (mut depth, mut radius) = (nodule.depth_m * 1e3, nodule.radius_m * 1e3);
        for (value, range, name) in [
            (&mut x, -20.0..=20.0, "x mm"),
            (&mut y, -20.0..=20.0, "y mm"),
            (&mut depth, 4.0..=25.0, "depth mm"),
            (&mut radius, 3.0..=12.0, "radius mm"),
            (&mut nodule.ratio, 0.2..=20.0, "times as stiff"),
        ] {
            let response = ui.add(Slider::new(value, range).fixed_decimals(1).text(name));
            // the patch is made anew: once, not at every pixel
            released |= response.drag_stopped() || (response.changed() && !response.dragged());
        }
        nodule = Nodule { place_m: [x * 1e-3, y * 1e-3], depth_m: depth * 1e-3, radius_m: radius * 1e-3, ..nodule };
        self.controls.nodule = Some(nodule);
        if released {
            self.choose();
        }
    }

    fn held_by(&mut self, ui: &mut Ui) {
        ui.strong("Device and hand");
        let before = self.controls.holding.clone();
        let holding = &mut self.controls.holding;
        let device = holding.device.clone().unwrap_or_else(|| "pointer".into());
        ui.horizontal(|ui| {
            ComboBox::from_id_salt("device").width(110.0).selected_text(device).show_ui(ui, |ui| {
                ui.selectable_value(&mut holding.device, None, "pointer");
                for (name, _) in PROFILES {
                    ui.selectable_value(&mut holding.device, Some(name.to_owned()), name);
                }
            });
            if holding.device.is_some() {
                ComboBox::from_id_salt("hand").width(110.0).selected_text(holding.hand.clone()).show_ui(ui, |ui| {
                    for hand in &HANDS[1..] {
                        ui.selectable_value(&mut holding.hand, hand.id.to_owned(), format!("{} {}", hand.id, hand.name));
                    }
                });
            }
        });
        if holding.device.is_some() {
            let mut delay = holding.delay_ticks.unwrap_or(1);
            if ui.add(Slider::new(&mut delay, 0..=7).text("delay ms")).changed() {
                holding.delay_ticks = Some(delay);
            }
        } else {
            holding.delay_ticks = None;
        }
        if self.controls.holding != before {
            self.choose();
        }
    }

    fn shown(&mut self, ui: &mut Ui) {
        ui.strong("View");
        ui.horizontal(|ui| {
            ui.selectable_value(&mut self.controls.shown.colour, Colour::Displacement, "displacement");
            ui.selectable_value(&mut self.controls.shown.colour, Colour::J, "J");
            if ui.button("reset").clicked() {
                self.camera.reset();
            }
        });
        ui.horizontal(|ui| {
            ui.checkbox(&mut self.controls.shown.springs, "springs");
            ui.checkbox(&mut self.controls.shown.rim, "edge");
            if ui.button(if self.controls.light { "dark" } else { "light" }).clicked() {
                let ctx = ui.ctx().clone();
                self.theme(&ctx);
            }
        });
    }

    fn exercise(&mut self, ui: &mut Ui) {
        ui.strong("Find the nodule");
        if let Some(search) = &self.controls.exercise {
            ui.label(format!("{:.0} s, strongest press {:.2} N", search.begun.elapsed().as_secs_f64(), search.peak_n));
            ui.label("Press around; where it is stiffest, press Enter.");
            if ui.button("give up").clicked() {
                self.search();
            }
        } else if ui.button("hide one (N)").clicked() {
            self.search();
        }
        if let Some((found, ..)) = &self.controls.found {
            let [place, gentle, soon] = found.marks;
            ui.label(RichText::new(format!("score {:.2} of 1", found.score)).strong());
            ui.label(format!("= 0.45 x {place:.1}/10 place + 0.35 x {gentle:.1}/10 gentle + 0.20 x {soon:.1}/10 soon"));
        }
    }

    fn recording(&mut self, ui: &mut Ui) {
        ui.strong("Recording");
        ui.horizontal(|ui| {
            let label = match self.frame.recorded {
                Some(ticks) => format!("stop ({:.1} s)", f64::from(ticks) * 1e-3),
                None => "record (R)".into(),
            };
            if ui.button(label).clicked() {
                self.record();
            }
            if ui.button("picture").clicked() {
                self.files.photograph(ui.ctx());
            }
        });
        if self.files.has_trace() {
            ui.horizontal(|ui| {
                if ui.button("replay").clicked() {
                    self.files.replay(&mut *self.link);
                }
                if ui.button("save").clicked() {
                    self.said = self.files.save();
                }
                if ui.button("CSV").clicked() {
                    self.said = self.files.csv();
                }
            });
        }
        ui.weak("drop a trace or a scene file here");
    }
}
