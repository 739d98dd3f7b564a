//! The panel: presets, sliders, device and hand, view, exercise, recording.

use eframe::egui::{ComboBox, RichText, Slider, SliderClamping, Ui};
use palpate_loop::closed_loop::device::PROFILES;
use palpate_loop::closed_loop::hand::HANDS;
use palpate_loop::live::{Choice, Inside, Nodule, SIZES};

use crate::app::App;
use crate::controls::{presets, short};
use crate::keys::KEYS;
use crate::shown::Colour;
use crate::words;

/// Clamping of a slider: it rounds the number that it displays, but changes only a value that the
/// user moves.
const EDITS: SliderClamping = SliderClamping::Edits;

/// Text that says how the exercise affects the present scene.
const HIDE: &str = "Hides a nodule somewhere in the plain block; this scene and its own nodule are left for that.";

/// The part of a file's name that fits beside the mesh.
fn clipped(name: &str) -> String {
    const MOST: usize = 12;
    if name.chars().count() <= MOST { name.into() } else { name.chars().take(MOST - 2).collect::<String>() + ".." }
}

impl App {
    /// Draws all controls, from the tissue down to the keys.
    pub(crate) fn controls(&mut self, ui: &mut Ui) {
        // a slider with the longest name and number beside it is then as wide as the panel
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
        let keys = ui.collapsing("Keys", |ui| {
            for line in KEYS {
                ui.label(RichText::new(line).size(12.0));
            }
            ui.label(RichText::new("Tab: fields and sliders, arrows change, Esc leaves").size(12.0));
        });
        keys.header_response.on_hover_text("Lists the keys of every control.");
    }

    fn tissue(&mut self, ui: &mut Ui) {
        ui.strong("Tissue");
        let mut preset = None;
        ui.horizontal(|ui| {
            let scenes = ComboBox::from_id_salt("preset").selected_text(clipped(short(&self.controls.choice.scene)));
            let scenes = scenes.show_ui(ui, |ui| {
                for name in presets() {
                    if ui.selectable_label(self.controls.choice.scene == name, name).clicked() {
                        preset = Some(Choice::preset(name));
                    }
                }
            });
            scenes.response.on_hover_text("Tissue to press (keys 1 to 9).");
            if self.controls.block {
                let nodes = self.shape.body.rest_m.len();
                let sizes = ComboBox::from_id_salt("nodes").selected_text(format!("{nodes} nodes")).width(90.0);
                let sizes = sizes.show_ui(ui, |ui| {
                    for size in SIZES {
                        if ui.selectable_label(nodes == size, format!("{size} nodes")).clicked() {
                            preset = Some(Choice { nodes: Some(size), ..self.controls.choice.clone() });
                        }
                    }
                });
                sizes.response.on_hover_text("Nodes of the mesh: more are more accurate and take longer per tick (M).");
            }
        });
        if let Some(choice) = preset {
            self.rechoose(choice);
        }
        let mut kpa = self.controls.stiffness_kpa;
        let stiffness = Slider::new(&mut kpa, 1.0..=100.0).logarithmic(true).fixed_decimals(1).clamping(EDITS);
        let stiffness = ui.add(stiffness.text("stiffness kPa"));
        if stiffness.on_hover_text("Young's modulus of the tissue in kPa ([ and ]).").changed() {
            self.stiffen(kpa);
        }
        let mut per_s = self.controls.damping_per_s;
        let damping = ui.add(Slider::new(&mut per_s, 0.0..=200.0).fixed_decimals(0).clamping(EDITS).text("damping 1/s"));
        if damping.on_hover_text("Share of its speed that a node loses per second, in 1/s (comma and dot).").changed() {
            self.damp(per_s);
        }
        if self.frame.waits {
            ui.weak("changes when you let go");
        }
        if self.controls.exercise.is_none() {
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
        let (own, mut there) = (self.controls.own.len(), !self.controls.nodules().is_empty());
        if !self.controls.block {
            if own > 0 {
                ui.weak(format!("{}: in a block it can be changed", words::own_nodules(own)));
            }
            return;
        }
        let name = match self.controls.inside {
            Inside::Own if own > 0 => words::own_nodules(own),
            _ => "nodule inside".into(),
        };
        let tip = if own > 0 {
            "Takes the scene's own nodule out, and puts it back (O)."
        } else {
            "Puts a stiffer ball into the block, and takes it out (O)."
        };
        if ui.checkbox(&mut there, name).on_hover_text(tip).changed() {
            self.put_nodule(there);
        }
        // one set of sliders can show only one nodule
        let &[mut nodule] = self.controls.nodules() else { return };
        let (mut moved, mut released) = (false, false);
        let [mut x, mut y] = nodule.place_m.map(|m| m * 1e3);
        let (mut depth, mut radius) = (nodule.depth_m * 1e3, nodule.radius_m * 1e3);
        for (value, range, name, tip) in [
            (&mut x, -20.0..=20.0, "x mm", "Place of the nodule towards you, in mm from the middle."),
            (&mut y, -20.0..=20.0, "y mm", "Place of the nodule to the right, in mm from the middle."),
            (&mut depth, 4.0..=25.0, "depth mm", "Depth of the nodule's centre below the surface, in mm."),
            (&mut radius, 3.0..=12.0, "radius mm", "Radius of the nodule in mm."),
            (&mut nodule.ratio, 0.2..=20.0, "times as stiff", "Stiffness of the nodule over that of the tissue (1)."),
        ] {
            let before = *value;
            let response = ui.add(Slider::new(value, range).fixed_decimals(1).clamping(EDITS).text(name)).on_hover_text(tip);
            let changed = (*value - before).abs() > 1e-6;
            moved |= changed;
            // the patch is rebuilt once when the slider is released, not at every pixel
            released |= response.drag_stopped() || (changed && !response.dragged());
        }
        if moved {
            nodule = Nodule { place_m: [x * 1e-3, y * 1e-3], depth_m: depth * 1e-3, radius_m: radius * 1e-3, ..nodule };
            self.controls.inside = Inside::Nodule(nodule);
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
            let devices = ComboBox::from_id_salt("device").width(110.0).selected_text(device);
            let devices = devices.show_ui(ui, |ui| {
                ui.selectable_value(&mut holding.device, None, "pointer");
                for (name, _) in PROFILES {
                    ui.selectable_value(&mut holding.device, Some(name.to_owned()), name);
                }
            });
            devices.response.on_hover_text("Emulated device between hand and tissue; the pointer has no mass (D).");
            if holding.device.is_some() {
                let hands = ComboBox::from_id_salt("hand").width(110.0).selected_text(holding.hand.clone());
                let hands = hands.show_ui(ui, |ui| {
                    for hand in &HANDS[1..] {
                        ui.selectable_value(&mut holding.hand, hand.id.to_owned(), format!("{} {}", hand.id, hand.name));
                    }
                });
                hands.response.on_hover_text("Emulated hand that holds the device (H).");
            }
        });
        if holding.device.is_some() {
            let mut delay = holding.delay_ticks.unwrap_or(1);
            let slider = ui.add(Slider::new(&mut delay, 0..=7).text("delay ms"));
            if slider.on_hover_text("Time from a force to the device's amplifier, in ms.").changed() {
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
            for (colour, name, tip) in [
                (Colour::Displacement, "moved", "Colour by displacement in mm (J)."),
                (Colour::J, "J", "Colour by volume over volume at rest (J)."),
                (Colour::Pressure, "pressure", "Colour by the probe's pressure in kPa (J)."),
            ] {
                if ui.selectable_label(self.controls.shown.colour == colour, name).on_hover_text(tip).clicked() {
                    self.colour(colour);
                }
            }
            if ui.button("reset").on_hover_text("Puts the eye back to where it began (Home).").clicked() {
                self.camera.reset();
            }
        });
        let shown = &mut self.controls.shown;
        ui.horizontal(|ui| {
            ui.checkbox(&mut shown.cut, "cut-away")
                .on_hover_text("Cuts the tissue through the tip: the dent and the mesh below it are seen (V).");
            ui.checkbox(&mut shown.springs, "springs").on_hover_text("Draws every spring of the mesh (S).");
            ui.checkbox(&mut shown.rim, "edge")
                .on_hover_text("Marks fixed nodes in black, and those with a far field behind them in orange (E).");
        });
        let other = if self.controls.light { "dark" } else { "light" };
        if ui.button(other).on_hover_text("Changes between light and dark (T).").clicked() {
            let ctx = ui.ctx().clone();
            self.theme(&ctx);
        }
        if self.controls.shown.colour == Colour::Pressure {
            ui.label(words::contact(self.frame.map.as_ref()));
        }
    }

    fn exercise(&mut self, ui: &mut Ui) {
        ui.strong("Find the nodule");
        if let Some(search) = &self.controls.exercise {
            ui.label(format!("{:.0} s, strongest press {:.2} N", search.taken_s(), search.peak_n));
            ui.label("Press around; where it is stiffest, press Enter.");
            if ui.button("give up").on_hover_text("Ends the search without a score (N).").clicked() {
                self.search();
            }
        } else if ui.button("hide one (N)").on_hover_text(HIDE).clicked() {
            self.search();
        }
        if let Some((found, ..)) = &self.controls.found {
            let [place, gentle, soon] = found.marks;
            let how = if found.found { "found" } else { "not found" };
            ui.label(RichText::new(format!("{how}: score {:.2} of 1", found.score)).strong());
            ui.label(format!("place {place:.1} of 10, which counts for all; gentleness {gentle:.1}; time {soon:.1}"));
        }
    }

    fn recording(&mut self, ui: &mut Ui) {
        ui.strong("Recording");
        ui.horizontal(|ui| {
            let label = match self.frame.recorded {
                Some(ticks) => format!("stop ({:.1} s)", f64::from(ticks) * 1e-3),
                None => "record (R)".into(),
            };
            if ui.button(label).on_hover_text("Records every tick of 1 ms, up to ten minutes (R).").clicked() {
                self.record();
            }
            if ui.button("picture").on_hover_text("Writes the window as a PNG (P).").clicked() {
                self.files.photograph(ui.ctx());
            }
        });
        if self.files.has_trace() {
            ui.horizontal(|ui| {
                if ui.button("replay").on_hover_text("Repeats the recording and compares every bit (L).").clicked() {
                    self.said = self.files.replay(&mut *self.link);
                }
                if ui.button("save").on_hover_text("Writes the recording as a trace (W).").clicked() {
                    self.said = self.files.save();
                }
                if ui.button("CSV").on_hover_text("Writes a row per tick, in s, m and N (X).").clicked() {
                    self.said = self.files.tabulate(&mut *self.link);
                }
            });
        }
        ui.horizontal(|ui| {
            if ui.button("open (F)").on_hover_text("Opens a trace or a scene (.toml).").clicked() {
                self.ask_for_a_file();
            }
            ui.weak("or drop a trace, a scene");
        });
    }
}
