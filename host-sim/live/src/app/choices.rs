//! Requests from the controls to the physics.

use eframe::egui;
use palpate_loop::live::{Choice, Exercise, Inside};

use super::App;
use crate::controls::{NODULE, Search};
use crate::message::Request;
use crate::shown::Colour;

impl App {
    /// Sends the present choices to the physics.
    pub(crate) fn choose(&mut self) {
        let controls = &mut self.controls;
        controls.choice.inside = match &controls.exercise {
            Some(search) => Inside::Nodule(search.exercise.hidden),
            None if controls.block => controls.inside,
            None => Inside::Own,
        };
        self.link.send(Request::Choose(controls.choice.clone(), controls.holding.clone()));
    }

    pub(crate) fn rechoose(&mut self, choice: Choice) {
        let controls = &mut self.controls;
        let same = choice.same_patch(&controls.choice);
        controls.choice = choice;
        controls.inside = controls.choice.inside;
        if let (true, Ok(scene)) = (same, controls.choice.scene()) {
            // the patch does not change, so no new body restores the sliders: they are set here
            controls.stiffness_kpa = scene.tissue.youngs_modulus_pa as f32 * 1e-3;
            controls.damping_per_s = scene.tissue.node_damping_per_s as f32;
            self.said = (format!("{} is as it began.", controls.title()), false);
            self.choose();
            return;
        }
        controls.put_by = Some((controls.exercise.take(), controls.found.take()));
        self.said = ("Preparing the tissue ...".into(), false);
        self.choose();
    }

    pub(crate) fn damp(&mut self, per_s: f32) {
        self.controls.damping_per_s = per_s.clamp(0.0, 200.0);
        self.controls.choice.node_damping_per_s = Some(f64::from(self.controls.damping_per_s));
        self.choose();
    }

    /// Puts the scene's own nodules into a block (or the nodule of the sliders if it has none), or
    /// removes them; does nothing while a nodule is searched for.
    pub(crate) fn put_nodule(&mut self, there: bool) {
        let controls = &mut self.controls;
        if controls.block && controls.exercise.is_none() {
            controls.found = None;
            controls.inside = match (there, controls.own.is_empty()) {
                (true, true) => Inside::Nodule(NODULE),
                (false, false) => Inside::Nothing,
                _ => Inside::Own,
            };
            self.choose();
        }
    }

    pub(crate) fn stiffen(&mut self, kpa: f32) {
        self.controls.stiffness_kpa = kpa.clamp(1.0, 100.0);
        self.controls.choice.youngs_modulus_pa = Some(f64::from(self.controls.stiffness_kpa) * 1e3);
        self.choose();
    }

    /// Starts or ends the exercise.
    pub(crate) fn search(&mut self) {
        let controls = &mut self.controls;
        controls.found = None;
        if controls.exercise.take().is_none() {
            controls.seed = controls.seed.wrapping_add(self.frame.ticks | 1);
            let exercise = Exercise::hide(controls.seed);
            controls.exercise = Some(Search { exercise, begun: None, peak_n: 0.0 });
            let nodes = controls.choice.nodes;
            controls.choice = Choice { nodes, ..Choice::preset("block") };
            (controls.shown.springs, controls.shown.cut, controls.inside) = (false, false, Inside::Own);
            // the plain block has no nodules of its own, unlike the scene before, perhaps
            controls.own.clear();
        }
        self.choose();
    }

    /// Takes the place under the tip as the answer of the exercise.
    pub(crate) fn answer(&mut self) {
        let place_m = self.pointer.place_m();
        // there is nothing to answer before the tissue of the exercise has appeared
        let Some(search) = self.controls.exercise.take_if(|s| s.begun.is_some()) else { return };
        let place_m = [f64::from(place_m.x), f64::from(place_m.y)];
        let found = search.exercise.judge(place_m, search.peak_n.into(), search.taken_s());
        self.said = (
            format!(
                "{}: score {:.2}, {:.1} mm off, strongest press {:.2} N, {:.0} s.",
                if found.found { "Found" } else { "Not found" },
                found.score,
                found.apart_m * 1e3,
                found.peak_n,
                found.time_s
            ),
            !found.found,
        );
        self.controls.found = Some((found, place_m, search.exercise.hidden));
        // the nodule stays, so that it can be felt again
        self.controls.inside = Inside::Nodule(search.exercise.hidden);
    }

    pub(crate) fn record(&mut self) {
        self.link.send(if self.frame.recorded.is_some() { Request::Finish } else { Request::Record });
    }

    pub(crate) fn recolour(&mut self) {
        self.colour(match self.controls.shown.colour {
            Colour::Displacement => Colour::J,
            Colour::J => Colour::Pressure,
            Colour::Pressure => Colour::Displacement,
        });
    }

    /// Colours the tissue by another quantity. A contact map is requested only while it is shown.
    pub(crate) fn colour(&mut self, colour: Colour) {
        self.controls.shown.colour = colour;
        self.link.send(Request::Map(colour == Colour::Pressure));
    }

    pub(crate) fn theme(&mut self, ctx: &egui::Context) {
        self.controls.light ^= true;
        ctx.set_theme(if self.controls.light { egui::Theme::Light } else { egui::Theme::Dark });
    }

    /// Opens files that were dropped or chosen: traces and scenes.
    pub(crate) fn opened(&mut self, ctx: &egui::Context) {
        for (name, bytes) in self.files.opened(ctx) {
            if bytes.starts_with(&palpate_loop::live::trace::MAGIC) {
                self.link.send(Request::Replay(bytes));
            } else if name.to_ascii_lowercase().ends_with(".toml") {
                if bytes.trim_ascii().is_empty() {
                    self.said = (format!("{name} is empty: give a scene, see host-sim/scenes."), true);
                    continue;
                }
                let text = String::from_utf8_lossy(&bytes).into_owned();
                self.rechoose(Choice { text, ..Choice::preset(&name) });
            } else {
                self.said = (format!("{name} is neither a live trace nor a scene (.toml): give one of these."), true);
            }
        }
    }

    /// Lets the user choose a trace or a scene.
    pub(crate) fn ask_for_a_file(&mut self) {
        if !self.files.ask() {
            self.path = Some(String::new());
        }
    }

    /// Shows the line in which a path is typed, on a desktop.
    pub(crate) fn typed(&mut self, ctx: &egui::Context) {
        let Some(path) = &mut self.path else { return };
        let (mut open, mut given) = (true, false);
        egui::Window::new("Open a trace or a scene").collapsible(false).resizable(false).open(&mut open).show(ctx, |ui| {
            let line = ui.add(egui::TextEdit::singleline(path).hint_text("out/live/live-1.trace").desired_width(360.0));
            given = line.lost_focus() && ui.input(|i| i.key_pressed(egui::Key::Enter));
            if !given {
                line.request_focus();
            }
            ui.weak("Enter opens, Esc leaves");
        });
        if given && let Some(why) = self.files.open(path.trim()) {
            self.said = (why, true);
        }
        if given || !open || ctx.input(|i| i.key_pressed(egui::Key::Escape)) {
            self.path = None;
        }
    }
}
