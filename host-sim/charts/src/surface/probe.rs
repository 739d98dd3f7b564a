//! The probe as a wire, so that the dent shows through it.

use super::view::{V3, View, across};

/// The end of the probe that touches the tissue.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ProbeShape {
    /// Half a ball, tip first.
    Hemisphere,
    /// A whole ball.
    Sphere,
    /// The flat end of a cylinder.
    Flat,
}

/// Where the probe is.
#[derive(Clone, Copy, Debug)]
pub struct Probe {
    /// Shape of the end.
    pub shape: ProbeShape,
    /// Radius [m].
    pub radius_m: f64,
    /// Foremost point [m].
    pub tip_m: [f64; 3],
    /// From the tip to the handle, any length but zero.
    pub axis: [f64; 3],
}

/// A line of the wire.
pub struct Wire {
    /// Points [m].
    pub points: Vec<V3>,
    /// True for the outline, false for the lines that show the curvature.
    pub outline: bool,
}

/// Cosine and sine of 96 directions around a circle, closed.
fn circle() -> impl Iterator<Item = (f64, f64)> + Clone {
    (0..=96).map(|k| (f64::from(k) * std::f64::consts::TAU / 96.0).sin_cos()).map(|(s, c)| (c, s))
}

impl Probe {
    /// The axis at length one; straight up if it has no length.
    pub fn direction(&self) -> V3 {
        V3::from(self.axis).try_normalize(0.0).unwrap_or_else(V3::z)
    }

    /// How far the drawn part reaches from the tip along the axis [m].
    fn height_m(&self) -> f64 {
        match self.shape {
            ProbeShape::Sphere => 2.0 * self.radius_m,
            ProbeShape::Hemisphere | ProbeShape::Flat => self.radius_m,
        }
    }

    /// Corners of the box around the drawn part [m].
    pub fn hull(&self) -> impl Iterator<Item = V3> + Clone {
        let (tip_m, radius, axis) = (V3::from(self.tip_m), self.radius_m, self.direction());
        let u = across(axis, V3::x()) * radius;
        let v = axis.cross(&u);
        [0.0, self.height_m()].into_iter().flat_map(move |height| {
            let center = tip_m + axis * height;
            [center + u + v, center + u - v, center - u + v, center - u - v]
        })
    }

    /// The lines to draw, with the far side of the probe left out.
    pub fn wire(&self, view: &View) -> Vec<Wire> {
        let axis = self.direction();
        let (tip_m, radius) = (V3::from(self.tip_m), self.radius_m);
        let u = across(axis, V3::x());
        let v = axis.cross(&u);
        let ring = |height: f64, radius: f64| {
            let center = tip_m + axis * height;
            circle().map(move |(c, s)| center + (u * c + v * s) * radius)
        };
        let mut wires = Vec::new();
        if self.shape == ProbeShape::Flat {
            for height in [0.0, self.height_m()] {
                wires.push(outline(ring(height, radius).collect()));
            }
            for side in [1.0, -1.0] {
                let foot = tip_m + view.right * (side * radius);
                wires.push(outline(vec![foot, foot + axis * self.height_m()]));
            }
            return wires;
        }
        let center = tip_m + axis * radius;
        let whole = self.shape == ProbeShape::Sphere;
        let faces_eye = |p: &V3| p.dot(&view.eye) >= center.dot(&view.eye);
        let present = |p: &V3| whole || p.dot(&axis) <= center.dot(&axis) + 1e-9 * radius;

        // lines of latitude every 30 degrees, without the poles
        for (c, s) in circle().step_by(8).skip(1).take(5) {
            let rim = !whole && c.abs() < 1e-9;
            let points = ring(radius * (1.0 - c), radius * s);
            if rim {
                wires.push(outline(points.collect()));
            } else {
                wires.extend(runs(points, |p| faces_eye(p) && present(p), false));
            }
        }
        for (c, s) in circle().step_by(16).take(3) {
            let across = u * c + v * s;
            let meridian = circle().map(|(c, s)| center + (axis * c + across * s) * radius);
            wires.extend(runs(meridian, |p| faces_eye(p) && present(p), false));
        }
        let limb = circle().map(|(c, s)| center + (view.right * c + view.up * s) * radius);
        wires.extend(runs(limb, present, true));
        wires
    }
}

fn outline(points: Vec<V3>) -> Wire {
    Wire { points, outline: true }
}

/// The unbroken pieces of a line on which `keep` holds.
fn runs(points: impl Iterator<Item = V3>, keep: impl Fn(&V3) -> bool, outline: bool) -> Vec<Wire> {
    let mut wires = Vec::new();
    let mut piece = Vec::new();
    for point in points {
        if keep(&point) {
            piece.push(point);
        } else if !piece.is_empty() {
            wires.push(Wire { points: std::mem::take(&mut piece), outline });
        }
    }
    if !piece.is_empty() {
        wires.push(Wire { points: piece, outline });
    }
    wires
}
