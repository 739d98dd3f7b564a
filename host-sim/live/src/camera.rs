//! The camera: it orbits the tissue, and maps positions to pixels and pixels to rays.

use eframe::egui::{Pos2, Rect, Vec2, pos2};
use palpate::Vector3;

type V = Vector3<f32>;

/// An eye that looks at a point, and orbits it.
#[derive(Clone, Copy, Debug)]
pub struct Camera {
    /// Point that the eye looks at [m].
    at_m: V,
    /// Angle about the vertical, 0 from the front (+x) [rad].
    pub turn: f32,
    /// Elevation above the horizontal [rad].
    pub height: f32,
    /// Distance from the eye to its target [m].
    pub distance_m: f32,
    size_m: f32,
}

/// Tangent of half of the vertical angle of view.
const HALF_VIEW: f32 = 0.32;

/// The camera's projection into a rectangle of the screen.
#[derive(Clone, Copy, Debug)]
pub struct Lens {
    eye_m: V,
    right: V,
    up: V,
    forward: V,
    rect: Rect,
    per_tangent: f32,
}

impl Camera {
    /// Creates a camera that looks at the middle of a body of this size [m].
    #[must_use]
    pub fn of(at_m: V, size_m: f32) -> Self {
        Self { at_m, turn: -0.65, height: 0.62, distance_m: 2.6 * size_m, size_m }
    }

    /// Orbits by a drag [pixels].
    pub fn orbit(&mut self, by: Vec2) {
        self.turn -= by.x * 0.008;
        self.height = (self.height + by.y * 0.008).clamp(-1.5, 1.5);
    }

    /// Moves nearer for a factor above 1.
    pub fn zoom(&mut self, factor: f32) {
        self.distance_m = (self.distance_m / factor.clamp(0.2, 5.0)).clamp(0.4 * self.size_m, 6.0 * self.size_m);
    }

    /// Returns to the initial position.
    pub fn reset(&mut self) {
        *self = Self::of(self.at_m, self.size_m);
    }

    /// Projection into a rectangle of the screen.
    #[must_use]
    pub fn lens(&self, rect: Rect) -> Lens {
        let (st, ct, sh, ch) = (self.turn.sin(), self.turn.cos(), self.height.sin(), self.height.cos());
        let back = V::new(ct * ch, st * ch, sh);
        let right = V::new(-st, ct, 0.0);
        let per_tangent = rect.height().min(rect.width()).max(1.0) / (2.0 * HALF_VIEW);
        let eye_m = self.at_m + back * self.distance_m;
        Lens { eye_m, right, up: back.cross(&right), forward: -back, rect, per_tangent }
    }
}

impl Lens {
    /// Pixel of a position, and its distance along the line of sight [m]; `None` behind the eye.
    #[must_use]
    pub fn project(&self, at_m: &V) -> Option<(Pos2, f32)> {
        let from = at_m - self.eye_m;
        let far_m = from.dot(&self.forward);
        if far_m < 1e-4 {
            return None;
        }
        let scale = self.per_tangent / far_m;
        let middle = self.rect.center();
        Some((pos2(middle.x + from.dot(&self.right) * scale, middle.y - from.dot(&self.up) * scale), far_m))
    }

    /// Unit direction through a pixel.
    #[must_use]
    pub fn ray(&self, pixel: Pos2) -> V {
        let off = (pixel - self.rect.center()) / self.per_tangent;
        (self.forward + self.right * off.x - self.up * off.y).normalize()
    }

    /// Position of the eye [m].
    #[must_use]
    pub fn eye_m(&self) -> V {
        self.eye_m
    }

    /// Direction of the light, which comes from over the eye's left shoulder.
    #[must_use]
    pub fn light(&self) -> V {
        (-self.forward * 0.8 + self.up * 0.7 - self.right * 0.35).normalize()
    }

    /// Directions in which the arrow keys move the tip: right and up on the screen, in the plane
    /// perpendicular to `axis`.
    #[must_use]
    pub fn along(&self, axis: &V) -> [V; 2] {
        let flat = |v: V| (v - axis * v.dot(axis)).try_normalize(1e-3);
        let right = flat(self.right).unwrap_or(self.right);
        [right, flat(self.up).or(flat(self.forward)).unwrap_or_else(|| axis.cross(&right))]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_ray_through_the_pixel_of_a_place_meets_it() {
        let mut camera = Camera::of(V::new(0.0, 0.0, -0.02), 0.08);
        camera.orbit(Vec2::new(40.0, -25.0));
        let lens = camera.lens(Rect::from_min_size(pos2(10.0, 20.0), Vec2::new(900.0, 500.0)));
        let place = V::new(0.013, -0.021, 0.004);
        let (pixel, _) = lens.project(&place).unwrap();
        let to = (place - lens.eye_m()).normalize();
        assert!((lens.ray(pixel) - to).norm() < 1e-4);
    }
}
