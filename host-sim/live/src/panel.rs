//! The panel: presets, sliders, device and hand, view, exercise, recording.

use eframe::egui::{ComboBox, RichText, Slider, SliderClamping, Ui};
use palpate_loop::closed_loop::device::PROFILES;
use palpate_loop::closed_loop::hand::HANDS;
use palpate_loop::live::{Choice, Nodule, SIZES};

use crate::app::App;
use crate::controls::{presets, short};
use crate::keys::KEYS;
use crate::view::Colour;
use crate::words;

/// A slider rounds what it shows; what was not touched keeps its value.
const EDITS: SliderClamping = SliderClamping::Edits;

/// As much of a file's name as fits beside the mesh.
fn clipped(name: &str) -> String {
    const MOST: usize = 12;
    if name.chars().count() <= MOST { name.into() } else { name.chars().take(MOST - 2).collect::<String>() + ".." }
}

impl App {
    /// Everything that can be chosen, from the tissue down to the keys.
    pub(crate) fn controls(&mut self, ui: &mut Ui) {
        // with the longest name and number beside it, a slider is as wide as the panel
        ui.spacing_mut().slider_width = 104.0;
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
            for line in KEYS {
                ui.label(RichText::new(line).size(12.0));
            }
            ui.label(RichText::new("Tab: fields and sliders, arrows change, Esc leaves").size(12.0));
        });
    }

    fn tissue(&mut self, ui: &mut Ui) {
        ui.strong("Tissue");
        let mut preset = None;
        ui.horizontal(|ui| {
            ComboBox::from_id_salt("preset").selected_text(clipped(short(&self.controls.choice.scene))).show_ui(ui, |ui| {
                for name in presets() {
                    if ui.selectable_label(self.controls.choice.scene == name, name).clicked() {
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
        if ui
            .add(Slider::new(&mut kpa, 1.0..=100.0).logarithmic(true).fixed_decimals(1).clamping(EDITS).text("stiffness kPa"))
            .changed()
        {
            self.stiffen(kpa);
        }
        let mut per_s = self.controls.damping_per_s;
        if ui.add(Slider::new(&mut per_s, 0.0..=200.0).fixed_decimals(0).clamping(EDITS).text("damping 1/s")).changed() {
            self.damp(per_s);
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
        ui.weak(words::terms(body.lasting_share, body.stiffening_b, body.friction));
    }

    fn nodule(&mut self, ui: &mut Ui) {
        let mut there = self.controls.nodule.is_some();
        if ui.checkbox(&mut there, "nodule inside").changed() {
            self.put_nodule(there);
        }
        let Some(mut nodule) = self.controls.nodule else { return };
        let (mut moved, mut released) = (false, false);
        let [mut x, mut y] = nodule.place_m.map(|m| m * 1e3);
        let (mut depth, mut radius) = (nodule.depth_m * 1e3, nodule.radius_m * 1e3);
        for (value, range, name) in [
            (&mut x, -20.0..=20.0, "x mm"),
            (&mut y, -20.0..=20.0, "y mm"),
            (&mut depth, 4.0..=25.0, "depth mm"),
            (&mut radius, 3.0..=12.0, "radius mm"),
            (&mut nodule.ratio, 0.2..=20.0, "times as stiff"),
        ] {
            let before = *value;
            let response = ui.add(Slider::new(value, range).fixed_decimals(1).clamping(EDITS).text(name));
            let changed = (*value - before).abs() > 1e-6;
            moved |= changed;
            // the patch is rebuilt once, not at every pixel
            released |= response.drag_stopped() || (changed && !response.dragged());
        }
        if moved {
            nodule = Nodule { place_m: [x * 1e-3, y * 1e-3], depth_m: depth * 1e-3, radius_m: radius * 1e-3, ..nodule };
            self.controls.nodule = Some(nodule);
        }
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
            for (colour, name) in [(Colour::Displacement, "moved"), (Colour::J, "J"), (Colour::Pressure, "pressure")] {
                if ui.selectable_label(self.controls.shown.colour == colour, name).clicked() {
                    self.colour(colour);
                }
            }
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
        if self.controls.shown.colour == Colour::Pressure {
            ui.label(words::contact(self.frame.map.as_ref()));
        }
    }

    fn exercise(&mut self, ui: &mut Ui) {
        ui.strong("Find the nodule");
        if let Some(search) = &self.controls.exercise {
            ui.label(format!("{:.0} s, strongest press {:.2} N", search.taken_s(), search.peak_n));
            ui.label("Press around; where it is stiffest, press Enter.");
            if ui.button("give up").clicked() {
                self.search();
            }
        } else if ui.button("hide one (N)").clicked() {
            self.search();
        }
        if let Some((found, ..)) = &self.controls.found {
            let [place, gentle, soon] = found.marks;
            let how = if found.found { "found" } else { "not found" };
            ui.label(RichText::new(format!("{how}: score {:.2} of 1", found.score)).strong());
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
                    self.said = self.files.replay(&mut *self.link);
                }
                if ui.button("save").clicked() {
                    self.said = self.files.save();
                }
                if ui.button("CSV").clicked() {
                    self.said = self.files.tabulate(&mut *self.link);
                }
            });
        }
        ui.horizontal(|ui| {
            if ui.button("open (F)").clicked() {
                self.ask_for_a_file();
            }
            ui.weak("or drop a trace, a scene");
        });
    }
}
