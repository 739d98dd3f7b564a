//! Shape of the probe in scene files and stored results.

use std::fmt;

use nalgebra::Vector3;
use palpate::{Probe, ProbeShape};
use serde::{Deserialize, Serialize};

use super::error::FOREIGN;

/// Shape of the probe in a scene file.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Shape {
    /// Cylinder with a half-sphere at its tip.
    Hemisphere,
    /// Full sphere.
    Sphere,
    /// Cylinder with a flat end.
    Flat,
    /// A rounded finger that lies on the tissue: all points within the radius of a line segment.
    Capsule {
        /// Length of the segment, without the rounded ends [m].
        length_m: f64,
        /// Direction of the segment; only its component at right angles to the probe's axis counts.
        along: [f64; 3],
    },
    /// Full ellipsoid; `radius_m` of the tip is its semi-axis along the probe's axis.
    Ellipsoid {
        /// Semi-axes along `along`, and at right angles to it and to the probe's axis [m].
        semi_axes_m: [f64; 2],
        /// Direction of the first semi-axis; only its component at right angles to the probe's axis
        /// counts.
        along: [f64; 3],
    },
}

/// A shape with its radius: the part of the probe that touches the tissue.
#[derive(Clone, Copy, Debug, Deserialize, PartialEq, Serialize)]
#[serde(try_from = "TipKeys", into = "TipKeys")]
pub struct Tip {
    /// Shape of the tip, with the dimensions that only this shape has.
    pub shape: Shape,
    /// Radius of the tip [m]; for an ellipsoid, its semi-axis along the probe's axis.
    pub radius_m: f64,
}

/// Names of the shapes in scene files.
#[derive(Clone, Copy, Debug, Deserialize, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub(super) enum Name {
    /// Cylinder with a half-sphere at its tip.
    Hemisphere,
    /// Full sphere.
    Sphere,
    /// Cylinder with a flat end.
    Flat,
    /// Rounded finger that lies on the tissue. Boards do not have it.
    Capsule,
    /// Full ellipsoid. Boards do not have it.
    Ellipsoid,
}

/// Keys of a tip in a file.
#[derive(Clone, Copy, Debug, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub(super) struct TipKeys {
    pub shape: Name,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub radius_m: Option<f64>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub length_m: Option<f64>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub semi_axes_m: Option<[f64; 3]>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub along: Option<[f64; 3]>,
}

impl TryFrom<TipKeys> for Tip {
    type Error = String;

    fn try_from(keys: TipKeys) -> Result<Self, String> {
        // in serde's words, so that errors of scene files name the table and the line
        fn needed<T>(key: &str, value: Option<T>) -> Result<T, String> {
            value.ok_or_else(|| format!("missing field `{key}`"))
        }
        let long = matches!(keys.shape, Name::Capsule | Name::Ellipsoid);
        let foreign = [
            ("radius_m", keys.radius_m.is_some() && keys.shape == Name::Ellipsoid, "a tip with one radius"),
            ("length_m", keys.length_m.is_some() && keys.shape != Name::Capsule, "a capsule"),
            ("semi_axes_m", keys.semi_axes_m.is_some() && keys.shape != Name::Ellipsoid, "an ellipsoid"),
            ("along", keys.along.is_some() && !long, "a capsule or an ellipsoid"),
        ];
        if let Some((key, _, owner)) = foreign.iter().find(|(_, given, _)| *given) {
            return Err(format!("{key}{FOREIGN}{owner}"));
        }
        let shape = match keys.shape {
            Name::Hemisphere => Shape::Hemisphere,
            Name::Sphere => Shape::Sphere,
            Name::Flat => Shape::Flat,
            Name::Capsule => Shape::Capsule { length_m: needed("length_m", keys.length_m)?, along: needed("along", keys.along)? },
            Name::Ellipsoid => {
                let [a, b, radius_m] = needed("semi_axes_m", keys.semi_axes_m)?;
                let along = needed("along", keys.along)?;
                return Ok(Self { shape: Shape::Ellipsoid { semi_axes_m: [a, b], along }, radius_m });
            }
        };
        Ok(Self { shape, radius_m: needed("radius_m", keys.radius_m)? })
    }
}

impl From<Tip> for TipKeys {
    fn from(Tip { shape, radius_m }: Tip) -> Self {
        let round = |shape| Self { shape, radius_m: Some(radius_m), length_m: None, semi_axes_m: None, along: None };
        match shape {
            Shape::Hemisphere => round(Name::Hemisphere),
            Shape::Sphere => round(Name::Sphere),
            Shape::Flat => round(Name::Flat),
            Shape::Capsule { length_m, along } => Self { length_m: Some(length_m), along: Some(along), ..round(Name::Capsule) },
            Shape::Ellipsoid { semi_axes_m: [a, b], along } => {
                let semi_axes_m = Some([a, b, radius_m]);
                Self { semi_axes_m, along: Some(along), radius_m: None, ..round(Name::Ellipsoid) }
            }
        }
    }
}

impl Shape {
    /// Whether the shape is symmetric under rotation about the probe's axis.
    #[must_use]
    pub fn is_round(self) -> bool {
        match self {
            Self::Hemisphere | Self::Sphere | Self::Flat => true,
            Self::Capsule { .. } | Self::Ellipsoid { .. } => false,
        }
    }

    /// Whether the shape is symmetric about the planes x = 0 and y = 0 if the probe's axis is z.
    #[must_use]
    pub fn mirrors(self) -> [bool; 2] {
        match self.along() {
            None => [true; 2],
            Some([x, y, _]) => [x == 0.0 || y == 0.0; 2],
        }
    }

    /// Direction of the long side; `None` for a round shape.
    #[must_use]
    pub fn along(self) -> Option<[f64; 3]> {
        match self {
            Self::Hemisphere | Self::Sphere | Self::Flat => None,
            Self::Capsule { along, .. } | Self::Ellipsoid { along, .. } => Some(along),
        }
    }

    /// The shape in the core's form; `axis` leads from the tip to the handle.
    #[must_use]
    pub fn of_core(self, axis: [f64; 3]) -> ProbeShape {
        let level = |along| level(along, axis.into()).cast::<f32>();
        match self {
            Self::Hemisphere => ProbeShape::Hemisphere,
            Self::Sphere => ProbeShape::Sphere,
            Self::Flat => ProbeShape::Flat,
            Self::Capsule { length_m, along } => ProbeShape::Capsule { length_m: length_m as f32, along: level(along) },
            Self::Ellipsoid { semi_axes_m, along } => {
                ProbeShape::Ellipsoid { semi_axes_m: semi_axes_m.map(|a| a as f32), along: level(along) }
            }
        }
    }
}

/// Component of a direction at right angles to a unit axis, scaled to length one; the direction
/// itself if that component vanishes.
#[must_use]
pub fn level(along: [f64; 3], axis: Vector3<f64>) -> Vector3<f64> {
    let along = Vector3::from(along);
    let across = along - axis * axis.dot(&along);
    // the core refuses a direction along the axis by the angle between them
    across.try_normalize(1e-6 * along.norm()).unwrap_or(along)
}

impl Tip {
    /// The tip of a probe as the core describes it.
    #[must_use]
    pub fn of_core(probe: &Probe) -> Self {
        let given = |along: palpate::Vector3<f32>| along.cast::<f64>().into();
        let shape = match probe.shape {
            ProbeShape::Hemisphere => Shape::Hemisphere,
            ProbeShape::Sphere => Shape::Sphere,
            ProbeShape::Flat => Shape::Flat,
            ProbeShape::Capsule { length_m, along } => Shape::Capsule { length_m: f64::from(length_m), along: given(along) },
            ProbeShape::Ellipsoid { semi_axes_m, along } => {
                Shape::Ellipsoid { semi_axes_m: semi_axes_m.map(f64::from), along: given(along) }
            }
        };
        Self { shape, radius_m: f64::from(probe.radius_m) }
    }

    /// Half-widths of the tip along its long side and at right angles to it [m].
    #[must_use]
    pub fn half_widths_m(&self) -> [f64; 2] {
        match self.shape {
            Shape::Hemisphere | Shape::Sphere | Shape::Flat => [self.radius_m; 2],
            Shape::Capsule { length_m, .. } => [self.radius_m + 0.5 * length_m, self.radius_m],
            Shape::Ellipsoid { semi_axes_m, .. } => semi_axes_m,
        }
    }

    /// Radius of a disc as wide as the tip on average [m]: the geometric mean of its half-widths.
    #[must_use]
    pub fn mean_radius_m(&self) -> f64 {
        let [a, b] = self.half_widths_m();
        if self.shape.is_round() { self.radius_m } else { (a * b).sqrt() }
    }

    /// Largest distance of a point of the tip from its axis [m].
    #[must_use]
    pub fn reach_m(&self) -> f64 {
        let [a, b] = self.half_widths_m();
        a.max(b)
    }

    /// Largest distance of the contact from the axis [m]: the radius at which a paraboloid of the
    /// tip's curvature rises by half of the depth, or the tip's own edge if that is nearer.
    #[must_use]
    pub fn contact_radius_m(&self, depth_m: f64) -> f64 {
        let radius_m = self.radius_m;
        let ball_m = (radius_m * depth_m.min(radius_m)).sqrt();
        match self.shape {
            Shape::Flat => radius_m,
            Shape::Hemisphere | Shape::Sphere => ball_m,
            Shape::Capsule { length_m, .. } => ball_m + 0.5 * length_m,
            Shape::Ellipsoid { .. } => ball_m * self.reach_m() / radius_m,
        }
    }

    /// Force over E [m^2] on a half-space whose plane-strain modulus is `plane` times E: Hertz for
    /// a sphere, the rigid punch for a flat end. For the other shapes, the stiffness `2 E* sqrt(A /
    /// pi)` of a round punch with the area of the contact is integrated over the depth. That is
    /// exact for the sphere and a few percent low for a long contact (Barber and Billings, Int. J.
    /// Mech. Sci. 32, 1990).
    #[must_use]
    pub fn half_space_m2(&self, plane: f64, depth_m: f64) -> f64 {
        let radius_m = self.radius_m;
        let ball_m2 = 4.0 / 3.0 * plane * radius_m.sqrt() * depth_m.powf(1.5);
        match self.shape {
            Shape::Flat => 2.0 * radius_m * plane * depth_m,
            Shape::Hemisphere | Shape::Sphere => ball_m2,
            Shape::Ellipsoid { semi_axes_m: [a, b], .. } => ball_m2 * (a * b).sqrt() / radius_m,
            Shape::Capsule { length_m, .. } => {
                // integrated over the half-width w of the contact, whose depth is w^2 / R
                let rate = |w: f64| (w * w + 2.0 * length_m * w / std::f64::consts::PI).sqrt() * w;
                let (widest_m, panels) = ((radius_m * depth_m).sqrt(), 64);
                let step = widest_m / f64::from(panels);
                let sum: f64 = (0..panels).map(|n| rate((f64::from(n) + 0.5) * step)).sum();
                4.0 * plane * sum * step / radius_m
            }
        }
    }
}

impl fmt::Display for Tip {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        // rounded to micrometres, because a tip from the core has been through single precision
        let mm = |m: f64| (m * 1e6).round() / 1e3;
        match self.shape {
            Shape::Hemisphere => write!(f, "hemisphere R {} mm", mm(self.radius_m)),
            Shape::Sphere => write!(f, "sphere R {} mm", mm(self.radius_m)),
            Shape::Flat => write!(f, "flat R {} mm", mm(self.radius_m)),
            Shape::Capsule { length_m, .. } => write!(f, "capsule R {} mm, {} mm long", mm(self.radius_m), mm(length_m)),
            Shape::Ellipsoid { semi_axes_m: [a, b], .. } => {
                write!(f, "ellipsoid {} x {} x {} mm", mm(a), mm(b), mm(self.radius_m))
            }
        }
    }
}
