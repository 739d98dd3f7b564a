//! Draws the probe as a wire model, through which the dent is visible.

use super::view::{V3, View, across};

/// Shape of the end of the probe that touches the tissue.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ProbeShape {
    /// Half a ball whose pole is the tip.
    Hemisphere,
    /// A whole ball.
    Sphere,
    /// The flat end of a cylinder.
    Flat,
    /// A ball swept along a segment.
    Capsule {
        /// Length of the segment [m].
        length_m: f64,
        /// Direction of the segment, of any non-zero length.
        along: [f64; 3],
    },
    /// A whole ellipsoid whose semi-axis along the probe's axis is `radius_m`.
    Ellipsoid {
        /// The two other semi-axes [m]; the first is along `along`.
        semi_axes_m: [f64; 2],
        /// Direction of the first of them, of any non-zero length.
        along: [f64; 3],
    },
}

/// Shape, size and pose of the probe.
#[derive(Clone, Copy, Debug)]
pub struct Probe {
    /// Shape of the end.
    pub shape: ProbeShape,
    /// Radius of the end [m].
    pub radius_m: f64,
    /// Position of the tip, the foremost point [m].
    pub tip_m: [f64; 3],
    /// Direction from the tip to the handle, of any non-zero length.
    pub axis: [f64; 3],
}

/// One line of the wire model.
pub struct Wire {
    /// Points of the line [m].
    pub points: Vec<V3>,
    /// Whether the line belongs to the outline; otherwise it shows the curvature.
    pub outline: bool,
}

/// Cosine and sine of 96 directions around a circle; the first is repeated at the end.
fn circle() -> impl Iterator<Item = (f64, f64)> + Clone {
    (0..=96).map(|k| (f64::from(k) * std::f64::consts::TAU / 96.0).sin_cos()).map(|(s, c)| (c, s))
}

impl Probe {
    /// The axis as a unit vector; straight up if the axis has zero length.
    pub fn direction(&self) -> V3 {
        V3::from(self.axis).try_normalize(0.0).unwrap_or_else(V3::z)
    }

    /// Length along the axis of the part that is drawn, from the tip [m].
    fn height_m(&self) -> f64 {
        match self.shape {
            ProbeShape::Sphere | ProbeShape::Capsule { .. } | ProbeShape::Ellipsoid { .. } => 2.0 * self.radius_m,
            ProbeShape::Hemisphere | ProbeShape::Flat => self.radius_m,
        }
    }

    /// Two unit vectors at right angles to the axis; the first is along the longer side if there is
    /// one.
    fn sides(&self) -> [V3; 2] {
        let axis = self.direction();
        let first = match self.shape {
            ProbeShape::Hemisphere | ProbeShape::Sphere | ProbeShape::Flat => across(axis, V3::x()),
            ProbeShape::Capsule { along, .. } | ProbeShape::Ellipsoid { along, .. } => {
                let along = V3::from(along);
                (along - axis * axis.dot(&along)).try_normalize(0.0).unwrap_or_else(|| across(axis, V3::x()))
            }
        };
        [first, axis.cross(&first)]
    }

    /// Maps a point of the unit sphere to the surface of the probe, relative to the probe's centre
    /// [m].
    fn drawn_out(&self, unit: V3) -> V3 {
        let [along, across] = self.sides();
        match self.shape {
            ProbeShape::Hemisphere | ProbeShape::Sphere | ProbeShape::Flat => unit * self.radius_m,
            ProbeShape::Capsule { length_m, .. } => unit * self.radius_m + along * (0.5 * length_m).copysign(unit.dot(&along)),
            ProbeShape::Ellipsoid { semi_axes_m: [a, b], .. } => {
                along * (a * unit.dot(&along))
                    + across * (b * unit.dot(&across))
                    + self.direction() * (self.radius_m * unit.dot(&self.direction()))
            }
        }
    }

    /// A direction in the space of the unit sphere: the great circle at right angles to it is
    /// mapped to the outline of the probe as seen from `eye`.
    fn limb(&self, eye: V3) -> V3 {
        let ProbeShape::Ellipsoid { semi_axes_m: [a, b], .. } = self.shape else { return eye };
        let ([along, across], axis) = (self.sides(), self.direction());
        along * (eye.dot(&along) / a) + across * (eye.dot(&across) / b) + axis * (eye.dot(&axis) / self.radius_m)
    }

    /// Corners of the box around the part that is drawn [m].
    pub fn hull(&self) -> impl Iterator<Item = V3> + Clone {
        let (tip_m, axis) = (V3::from(self.tip_m), self.direction());
        let [first, second] = match self.shape {
            ProbeShape::Hemisphere | ProbeShape::Sphere | ProbeShape::Flat => [self.radius_m; 2],
            ProbeShape::Capsule { length_m, .. } => [self.radius_m + 0.5 * length_m, self.radius_m],
            ProbeShape::Ellipsoid { semi_axes_m, .. } => semi_axes_m,
        };
        let [u, v] = self.sides();
        let (u, v) = (u * first, v * second);
        [0.0, self.height_m()].into_iter().flat_map(move |height| {
            let center = tip_m + axis * height;
            [center + u + v, center + u - v, center - u + v, center - u - v]
        })
    }

    /// The lines of the wire model, without those on the far side of the probe.
    pub fn wire(&self, view: &View) -> Vec<Wire> {
        let axis = self.direction();
        let (tip_m, radius) = (V3::from(self.tip_m), self.radius_m);
        let [u, v] = self.sides();
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
        let whole = self.shape != ProbeShape::Hemisphere;
        let at = |unit: V3| (center + self.drawn_out(unit), unit);
        let limb = self.limb(view.eye);
        let faces_eye = |(_, unit): &(V3, V3)| unit.dot(&limb) >= 0.0;
        let present = |(_, unit): &(V3, V3)| whole || unit.dot(&axis) <= 1e-9;

        // circles of latitude every 30 degrees, without the poles
        for (c, s) in circle().step_by(8).skip(1).take(5) {
            let rim = !whole && c.abs() < 1e-9;
            let points = circle().map(|(x, y)| at((u * x + v * y) * s - axis * c));
            if rim {
                wires.push(outline(points.map(|(point, _)| point).collect()));
            } else {
                wires.extend(runs(points, |p| faces_eye(p) && present(p), false));
            }
        }
        for (c, s) in circle().step_by(16).take(3) {
            let across = u * c + v * s;
            let meridian = circle().map(|(c, s)| at(axis * c + across * s));
            wires.extend(runs(meridian, |p| faces_eye(p) && present(p), false));
        }
        let first = match limb == view.eye {
            true => view.right,
            false => across(limb.normalize(), view.right),
        };
        let second = if limb == view.eye { view.up } else { limb.normalize().cross(&first) };
        let limb = circle().map(|(c, s)| at(first * c + second * s));
        wires.extend(runs(limb, present, true));
        wires
    }
}

fn outline(points: Vec<V3>) -> Wire {
    Wire { points, outline: true }
}

/// The contiguous pieces of a line whose points satisfy `keep`. Each point is paired with its
/// position on the unit sphere.
fn runs(points: impl Iterator<Item = (V3, V3)>, keep: impl Fn(&(V3, V3)) -> bool, outline: bool) -> Vec<Wire> {
    let mut wires = Vec::new();
    let mut piece = Vec::new();
    for place in points {
        if keep(&place) {
            piece.push(place.0);
        } else if !piece.is_empty() {
            wires.push(Wire { points: std::mem::take(&mut piece), outline });
        }
    }
    if !piece.is_empty() {
        wires.push(Wire { points: piece, outline });
    }
    wires
}
