//! The panel: figures of the board and of this machine's patch, and the view options.

use eframe::egui::{Grid, RichText, Ui};

use super::screen::Follow;
use super::words;
use crate::shown::Colour;

/// Meaning of the picture.
const MEASURED: &str =
    "Tip, mode, fault and forces under this heading are the board's own records, 500 per second. Nothing is sent to it.";
const COMPUTED: &str = "The shape of the tissue and the force under this heading are computed here, from the board's tips: \
     straight from one to the next, since nothing was measured between them.";

/// Key bindings.
const KEYS: [&str; 3] = ["V cut · S springs · E edge · J colour", "T light, dark · P picture", "+ - zoom · Home: reset the view"];

fn vector(numbers: [f32; 3], factor: f32, digits: usize) -> String {
    // a part that is rounded to zero has no sign
    let least = 0.5 * 0.1_f32.powi(digits as i32);
    let round = |n: f32| if n.abs() < least { 0.0 } else { n };
    numbers.map(|n| format!("{:.*}", digits, round(n * factor))).join(", ")
}

impl Follow {
    pub(super) fn panel(&mut self, ui: &mut Ui) {
        self.board(ui);
        ui.separator();
        self.here(ui);
        ui.separator();
        self.view(ui);
        ui.separator();
        for line in KEYS {
            ui.label(RichText::new(line).size(12.0));
        }
    }

    fn board(&self, ui: &mut Ui) {
        ui.strong("Measured by the board");
        ui.label(RichText::new(MEASURED).size(12.0));
        ui.add_space(4.0);
        let row = self.present();
        let told = |of: &dyn Fn(&palpate_loop::board_trace::Row) -> String| row.map_or_else(|| "-".into(), of);
        let figures = [
            (
                "force applied",
                words::force(row, |row| row.applied_n),
                "Force that the board's motors were asked for, after its limits.",
            ),
            ("x, y, z", told(&|row| format!("{} N", vector(row.applied_n, 1.0, 3))), "Its parts in the frame of the device."),
            (
                "force of its patch",
                words::force(row, |row| row.model_n),
                "Force of the tissue on the board, before damping and limits.",
            ),
            ("depth", told(&|row| format!("{:.2} mm", row.depth_m * 1e3)), "Depth of the tip below the surface at rest."),
            (
                "tip x, y, z",
                told(&|row| format!("{} mm", vector(row.tip_m, 1e3, 2))),
                "In the frame of the device: the site of the patch is at 0, 0, 0, outside is z > 0.",
            ),
            ("outputs", told(&|row| if row.outputs_on { "on" } else { "off" }.into()), "Enable line of the motors."),
            (
                "tick",
                told(&|row| row.tick_us.map_or_else(|| "not timed".into(), |us| format!("{us:.0} us of 1000"))),
                "Time from the sensors to the outputs.",
            ),
            (
                "patch",
                told(&|row| match row.patch_checksum {
                    0 => "none".into(),
                    sum => format!("{sum:08x}, {} Pa", row.youngs_modulus_pa),
                }),
                "Checksum of the patch file and Young's modulus.",
            ),
        ];
        Grid::new("figures").num_columns(2).spacing([8.0, 3.0]).show(ui, |ui| {
            for (name, value, tip) in figures {
                ui.label(RichText::new(name).size(12.0)).on_hover_text(tip);
                ui.label(value).on_hover_text(tip);
                ui.end_row();
            }
        });
        let warn = ui.visuals().error_fg_color;
        if let Some(row) = row {
            ui.label(words::mode(row.mode));
            if let Some(fault) = row.fault_words() {
                ui.label(RichText::new(fault).color(warn).strong());
            }
        } else {
            self.absence(ui);
        }
    }

    fn here(&self, ui: &mut Ui) {
        ui.strong("Computed on this machine");
        ui.label(RichText::new(COMPUTED).size(12.0));
        ui.add_space(4.0);
        let nodes = self.shape.body.rest_m.len();
        match &self.patch {
            Ok(name) => ui.label(format!("patch {name}, {nodes} nodes")),
            Err(why) if why.is_empty() => ui.weak("the patch is chosen with the first record"),
            Err(why) => ui.label(RichText::new(format!("no patch: {why}")).color(ui.visuals().error_fg_color)),
        };
        let Some((row, answer)) = self.present().zip(self.state.answer) else { return };
        if let Some(force_n) = answer.force_n {
            ui.label(format!("its force at the board's tip: {:.3} N", words::length(force_n)));
        }
        let difference = ui.label(words::difference(answer.differs_n, words::length(row.model_n)));
        difference
            .on_hover_text("From the force of the board's patch. A tap between two records is not straight: it differs more.");
    }

    fn view(&mut self, ui: &mut Ui) {
        ui.strong("View");
        ui.horizontal(|ui| {
            for (colour, name, tip) in [
                (Colour::Displacement, "moved", "Colour by displacement in mm (J)."),
                (Colour::J, "J", "Colour by volume over volume at rest (J)."),
            ] {
                if ui.selectable_label(self.shown.colour == colour, name).on_hover_text(tip).clicked() {
                    self.shown.colour = colour;
                }
            }
            if ui.button("reset").on_hover_text("Puts the eye back to where it began (Home).").clicked() {
                self.camera.reset();
            }
            let other = if self.shown.dark { "light" } else { "dark" };
            if ui.button(other).on_hover_text("Changes between light and dark (T).").clicked() {
                let ctx = ui.ctx().clone();
                self.theme(&ctx);
            }
            if ui.button("picture").on_hover_text("Writes the window as a PNG (P).").clicked() {
                self.files.photograph(ui.ctx());
            }
        });
        ui.horizontal(|ui| {
            let shown = &mut self.shown;
            ui.checkbox(&mut shown.cut, "cut-away").on_hover_text("Cuts the tissue through the tip (V).");
            ui.checkbox(&mut shown.springs, "springs").on_hover_text("Draws every spring of the mesh (S).");
            ui.checkbox(&mut shown.rim, "edge")
                .on_hover_text("Marks fixed nodes in black, and those with a far field behind them in orange (E).");
        });
    }
}

#[cfg(test)]
mod tests {
    use super::vector;

    #[test]
    fn a_part_that_is_rounded_away_has_no_sign() {
        assert_eq!(vector([-0.0004, 0.0006, -0.0006], 1.0, 3), "0.000, 0.001, -0.001");
        assert_eq!(vector([0.001, -0.0, -0.0023], 1e3, 2), "1.00, 0.00, -2.30");
    }
}
