//! Mouse and keys move the tip over the surface and into it, and move the eye around it.

use eframe::egui::{Key, PointerButton, Response, Ui};
use palpate::{ClampFlags, Vector3};
use palpate_loop::live::CLEAR_M;

use crate::camera::Camera;
use crate::drawn_body::DrawnBody;
use crate::message::{Body, Frame};
use crate::words;

type V = Vector3<f32>;

/// Initial depth of a press with the button [m].
const PRESS_M: f32 = 3e-3;
/// Change of depth by one notch of the wheel [m].
const NOTCH_M: f32 = 0.5e-3;
/// Largest speed into the tissue, that of a careful press [m/s].
const INTO_M_PER_S: f32 = 12e-3;
/// Speed along the surface while a key is held [m/s].
const ALONG_M_PER_S: f32 = 25e-3;
/// Time in which the loop ramps the force in after it was armed, and a little more [s].
const RAMP_IN_S: f32 = 0.6;

/// Position and depth of the tip that the user moves.
#[derive(Clone, Copy, Debug)]
pub struct Pointer {
    /// Position on the surface [m].
    place_m: V,
    /// Depth below the surface while a button presses [m]; the wheel sets it.
    pub press_m: f32,
    /// Present depth, which changes at the speed of a hand [m].
    depth_m: f32,
    /// Whether the tip is over the tissue.
    over: bool,
    /// Whether the keyboard moved the tip last; the position of the mouse is then ignored.
    by_key: bool,
    /// Whether the tip presses now.
    pub pressing: bool,
    /// Time since the loop was armed [s].
    armed_s: f32,
}

impl Default for Pointer {
    fn default() -> Self {
        Self {
            place_m: V::zeros(),
            press_m: PRESS_M,
            depth_m: -CLEAR_M as f32,
            over: false,
            by_key: false,
            pressing: false,
            armed_s: 0.0,
        }
    }
}

impl Pointer {
    /// Puts the pointer over the site of another body.
    pub fn begin(&mut self, body: &Body) {
        *self = Self { place_m: body.site_m.into(), press_m: self.press_m, ..Self::default() };
    }

    /// Position of the pointer on the surface [m].
    #[must_use]
    pub fn place_m(&self) -> V {
        self.place_m
    }

    /// Whether a press is felt in full: the loop is armed, and its force was ramped in. Until then
    /// the tip waits above the tissue, so that no press is lost.
    fn may_press(&mut self, frame: &Frame, dt_s: f32) -> bool {
        self.armed_s = if words::felt(frame.mode) { self.armed_s + dt_s } else { 0.0 };
        // tissue that is stiffer than the device renders is scaled down for good
        let ramping = frame.limiters & ClampFlags::GAIN.bits() != 0 && self.armed_s < RAMP_IN_S;
        self.armed_s > 0.0 && (self.depth_m > 0.0 || !ramping)
    }

    /// Target of the tip [m]; `None` if the pointer is not over the tissue.
    pub fn aim(
        &mut self,
        ui: &Ui,
        response: &Response,
        camera: &mut Camera,
        shape: &DrawnBody,
        frame: &Frame,
    ) -> Option<[f64; 3]> {
        let lens = camera.lens(response.rect);
        let axis = V::from(shape.body.axis);
        let typing = ui.ctx().memory(|m| m.focused().is_some());
        let (wheel, ctrl, pinch, dt_s, keys) = ui.input(|i| {
            let held = |k: Key| !typing && i.key_down(k);
            let step = |more: Key, less: Key| f32::from(i8::from(held(more)) - i8::from(held(less)));
            let keys =
                (step(Key::ArrowRight, Key::ArrowLeft), step(Key::ArrowUp, Key::ArrowDown), held(Key::Space), i.modifiers.shift);
            (i.smooth_scroll_delta().y, i.modifiers.ctrl, i.zoom_delta(), i.stable_dt.min(0.1), keys)
        });
        let (right, up, space, shift) = keys;
        if response.dragged_by(PointerButton::Secondary) || response.dragged_by(PointerButton::Middle) {
            camera.orbit(response.drag_delta());
        }
        if shift {
            camera.orbit(eframe::egui::vec2(-right, up) * (150.0 * dt_s));
        } else if right != 0.0 || up != 0.0 {
            let [side, ahead] = lens.along(&axis);
            let displacement_m = (side * right + ahead * up) * (ALONG_M_PER_S * dt_s);
            let from_m = self.place_m + displacement_m + axis * 0.5;
            if let Some(place_m) = shape.meets(&from_m, &-axis) {
                self.place_m = place_m;
            }
            (self.by_key, self.over) = (true, true);
        }
        if response.hovered() {
            if ctrl || pinch != 1.0 {
                camera.zoom(pinch * (1.0 + wheel * 0.003));
            } else if wheel != 0.0 {
                self.press_m = (self.press_m - wheel / 50.0 * NOTCH_M).clamp(0.0, shape.body.depth_limit_m);
            }
        }
        let button = response.is_pointer_button_down_on() && ui.input(|i| i.pointer.primary_down());
        let moved = ui.input(|i| i.pointer.delta() != eframe::egui::Vec2::ZERO);
        if moved || button {
            self.by_key = false;
        }
        if !self.by_key {
            // outside the window the pointer has no position; a drag that leaves the picture ends
            // the press as well
            let pixel = response.hover_pos().or(response.interact_pointer_pos()).filter(|p| response.rect.contains(*p));
            let inside = ui.input(|i| i.pointer.has_pointer());
            let place_m = pixel.filter(|_| inside).and_then(|p| shape.meets(&lens.eye_m(), &lens.ray(p)));
            self.over = place_m.is_some();
            self.place_m = place_m.unwrap_or(self.place_m);
        }
        self.over |= space;
        self.pressing = self.over && (button || space);
        if !self.over || frame.nodes_m.is_empty() {
            self.depth_m = -CLEAR_M as f32;
            return None;
        }
        // the tip moves to the surface at once, into the tissue slowly, and out of it at once
        let may_press = self.may_press(frame, dt_s);
        let goal_m = if self.pressing && may_press { self.press_m } else { -CLEAR_M as f32 };
        let most_m = self.depth_m.max(0.0) + INTO_M_PER_S * dt_s;
        self.depth_m = goal_m.min(most_m);
        Some((self.place_m - axis * self.depth_m).cast::<f64>().into())
    }
}
