//! Keys for everything that the panel does without a slider; Tab and the arrow keys reach the
//! sliders.

use eframe::egui::{self, Key};
use palpate_loop::closed_loop::device::PROFILES;
use palpate_loop::closed_loop::hand::HANDS;
use palpate_loop::live::{Choice, SIZES};

use crate::app::App;
use crate::controls::presets;
use crate::message::Request;

/// Key bindings that the panel lists.
pub const KEYS: [&str; 11] = [
    "arrows: move · Space: press",
    "PageUp, PageDown: how deep",
    "[ ]: softer, stiffer · , .: damping",
    "1 .. 9: presets · M: mesh · O: nodule inside",
    "D: device · H: hand · C: clear a fault",
    "Shift arrows: orbit · + -: zoom · Home: reset",
    "V: cut through the tip, dent and mesh seen",
    "S springs · E edge · J colour · T light, dark",
    "N: find the nodule · Enter: it is here",
    "R: record · L: replay · W: save · X: CSV · P: picture",
    "F: open a trace or a scene",
];

const PRESET_KEYS: [Key; 9] = [Key::Num1, Key::Num2, Key::Num3, Key::Num4, Key::Num5, Key::Num6, Key::Num7, Key::Num8, Key::Num9];

const GRADUAL: [Key; 9] = [
    Key::Comma,
    Key::Equals,
    Key::Minus,
    Key::OpenBracket,
    Key::CloseBracket,
    Key::PageDown,
    Key::PageUp,
    Key::Period,
    Key::Plus,
];

/// The entry after `now`, or the first entry if `now` is the last or is not in the list.
fn next<T: Clone + PartialEq>(all: impl Iterator<Item = T> + Clone, now: &T) -> Option<T> {
    let (after, mut all) = (all.clone().skip_while(|one| one != now).nth(1), all);
    after.or_else(|| all.next())
}

impl App {
    /// Handles the keys, unless a field has the focus.
    pub(crate) fn keys(&mut self, ctx: &egui::Context) {
        if ctx.memory(|m| m.focused().is_some()) {
            return;
        }
        let pressed = ctx.input(|i| {
            let down = |event: &egui::Event| match event {
                // A held key repeats only if its effect is gradual. With Ctrl, Alt or Command a key
                // belongs to the browser or the desktop.
                egui::Event::Key { modifiers, .. } if modifiers.ctrl || modifiers.alt || modifiers.command => None,
                egui::Event::Key { key, pressed: true, repeat, .. } if !repeat || GRADUAL.contains(key) => Some(*key),
                _ => None,
            };
            i.events.iter().filter_map(down).collect::<Vec<_>>()
        });
        for key in pressed {
            self.key(key, ctx);
        }
    }

    fn key(&mut self, key: Key, ctx: &egui::Context) {
        let limit_m = self.shape.body.depth_limit_m;
        match key {
            Key::C => self.link.send(Request::Clear),
            Key::R => self.record(),
            Key::N => self.search(),
            Key::Enter => self.answer(),
            Key::P => self.files.photograph(ctx),
            Key::F => self.ask_for_a_file(),
            Key::L => self.said = self.files.replay(&mut *self.link),
            Key::W => self.said = self.files.save(),
            Key::X => self.said = self.files.tabulate(&mut *self.link),
            Key::S => self.controls.shown.springs ^= true,
            Key::V => self.controls.shown.cut ^= true,
            Key::E => self.controls.shown.rim ^= true,
            Key::J => self.recolour(),
            Key::T => self.theme(ctx),
            Key::D => self.next_device(),
            Key::H => self.next_hand(),
            Key::M => self.next_mesh(),
            Key::O => self.put_nodule(self.controls.nodules().is_empty()),
            Key::Plus | Key::Equals => self.camera.zoom(1.15),
            Key::Minus => self.camera.zoom(1.0 / 1.15),
            Key::Home => self.camera.reset(),
            Key::OpenBracket => self.stiffen(self.controls.stiffness_kpa / 1.25),
            Key::CloseBracket => self.stiffen(self.controls.stiffness_kpa * 1.25),
            Key::Comma => self.damp(self.controls.damping_per_s - 10.0),
            Key::Period => self.damp(self.controls.damping_per_s + 10.0),
            Key::PageDown => self.pointer.press_m = (self.pointer.press_m + 0.5e-3).min(limit_m),
            Key::PageUp => self.pointer.press_m = (self.pointer.press_m - 0.5e-3).max(0.0),
            _ => {
                let named = PRESET_KEYS.iter().position(|k| *k == key).and_then(|n| presets().nth(n));
                if let Some(name) = named {
                    self.rechoose(Choice::preset(name));
                }
            }
        }
    }

    fn next_device(&mut self) {
        let all = std::iter::once(None).chain(PROFILES.iter().map(|(name, _)| Some((*name).to_owned())));
        let holding = &mut self.controls.holding;
        holding.device = next(all, &holding.device).flatten();
        holding.delay_ticks = None;
        self.said = (format!("Device: {}.", holding.device.as_deref().unwrap_or("pointer")), false);
        self.choose();
    }

    fn next_hand(&mut self) {
        let holding = &mut self.controls.holding;
        if holding.device.is_none() {
            self.said = ("A hand needs a device: press D first.".into(), true);
            return;
        }
        holding.hand = next(HANDS[1..].iter().map(|h| h.id.to_owned()), &holding.hand).unwrap_or_default();
        self.choose();
    }

    fn next_mesh(&mut self) {
        let nodes = next(SIZES.into_iter(), &self.shape.body.rest_m.len()).filter(|_| self.controls.block);
        if let Some(nodes) = nodes {
            self.rechoose(Choice { nodes: Some(nodes), ..self.controls.choice.clone() });
        }
    }
}

#[cfg(test)]
mod tests {
    use super::next;

    #[test]
    fn a_key_goes_through_all_and_begins_again() {
        let after = |now| next([1, 2, 3].into_iter(), &now);
        assert_eq!([after(1), after(3), after(9)], [Some(2), Some(1), Some(1)]);
    }
}
