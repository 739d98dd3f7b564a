//! The rigid probe: shape, size and orientation.

use nalgebra::Vector3;

use super::Params;
#[cfg(feature = "long-tips")]
use crate::fault::BuildError;
use crate::lanes::sqrt;

/// Shape of the rigid probe. The last two require the feature `long-tips`, which images for boards
/// leave out for lack of flash.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ProbeShape {
    /// A cylinder with a half-sphere at its tip, such as a fingertip or a rounded tool.
    Hemisphere,
    /// A full sphere.
    Sphere,
    /// A cylinder with a flat end.
    Flat,
    /// A rounded rod that lies on the tissue: everything within the probe's radius of a segment.
    /// The segment's middle is one radius above the tip. It has no handle that could touch the
    /// tissue.
    #[cfg(feature = "long-tips")]
    Capsule {
        /// Length of the segment, without the rounded ends [m]; zero gives a sphere.
        length_m: f32,
        /// Unit vector along the segment, at right angles to the probe's axis.
        along: Vector3<f32>,
    },
    /// A full ellipsoid. The probe's radius is its semi-axis along the probe's axis.
    #[cfg(feature = "long-tips")]
    Ellipsoid {
        /// Semi-axes along `along`, and at right angles to it and to the probe's axis [m].
        semi_axes_m: [f32; 2],
        /// Unit vector at right angles to the probe's axis.
        along: Vector3<f32>,
    },
}

/// The probe. Its position always means that of its **tip**, the point furthest along `-axis`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Probe {
    /// Shape of the end that touches the tissue.
    pub shape: ProbeShape,
    /// Radius of the end and of the cylinder above it [m]; of an ellipsoid, the semi-axis along
    /// `axis`.
    pub radius_m: f32,
    /// Unit vector from the tip to the handle.
    pub axis: Vector3<f32>,
}

/// Radius of the flat probe's rounded edge, as a share of the probe's radius (1). With a sharp edge
/// the force jumps when a point slips over it, and the tissue never comes to rest.
pub const FLAT_EDGE: f32 = 1.0 / 16.0;
/// Largest permitted ratio of two semi-axes of an ellipsoid (1). The Newton steps are tested up to
/// it.
#[cfg(feature = "long-tips")]
const MOST_RATIO: f32 = 4.0;
/// Longest segment of a capsule [m].
#[cfg(feature = "long-tips")]
const MOST_LENGTH_M: f32 = 1.0;
/// Largest permitted cosine between `along` and the axis (1), which must be at right angles.
#[cfg(feature = "long-tips")]
const LEANS: f32 = 1e-3;
/// Smallest cosine of the angle by which a probe may be turned away from the press (1). Beyond 45
/// degrees a surface counts as a wall ([`crate::stages::presence`]).
#[cfg(feature = "long-tips")]
const LEAST_UPRIGHT: f32 = 0.7;

impl ProbeShape {
    /// Whether the probe has a handle, which the tissue can touch where the tip has entered.
    #[inline(always)]
    pub(crate) fn has_handle(self) -> bool {
        match self {
            Self::Hemisphere | Self::Flat => true,
            Self::Sphere => false,
            #[cfg(feature = "long-tips")]
            Self::Capsule { .. } | Self::Ellipsoid { .. } => false,
        }
    }
}

impl Probe {
    /// Half of the width of a box around the probe along coordinate `k` [m]. The extent along the
    /// probe's axis is not included.
    #[inline(always)]
    #[cfg_attr(not(feature = "long-tips"), expect(unused_variables, reason = "a ball is as wide along each"))]
    pub(crate) fn half_width_m(&self, k: usize) -> f32 {
        match self.shape {
            #[cfg(feature = "long-tips")]
            ProbeShape::Capsule { length_m, along } => self.radius_m + 0.5 * length_m * along[k].abs(),
            #[cfg(feature = "long-tips")]
            ProbeShape::Ellipsoid { semi_axes_m: [a, b], along } => a * along[k].abs() + b * self.axis.cross(&along)[k].abs(),
            _ => self.radius_m,
        }
    }

    /// Largest distance of a point of the probe's end from the probe's axis [m].
    #[must_use]
    #[inline(always)]
    pub fn reach_m(&self) -> f32 {
        match self.shape {
            #[cfg(feature = "long-tips")]
            ProbeShape::Capsule { length_m, .. } => self.radius_m + 0.5 * length_m,
            #[cfg(feature = "long-tips")]
            ProbeShape::Ellipsoid { semi_axes_m: [a, b], .. } => {
                let longest = if a > b { a } else { b };
                if longest > self.radius_m { longest } else { self.radius_m }
            }
            _ => self.radius_m,
        }
    }

    /// Depth of the deepest point of the probe's end below its tip, along a unit vector `up` out of
    /// the tissue [m]; zero where `up` is the axis. For a flat end it is a point of the rounded
    /// edge.
    #[inline(always)]
    pub(crate) fn below_tip_m(&self, up: &Vector3<f32>) -> f32 {
        let r = self.radius_m;
        let cosine = self.axis.dot(up);
        match self.shape {
            ProbeShape::Flat => {
                let (edge, across) = (FLAT_EDGE * r, self.axis.cross(up));
                (r - edge) * sqrt(across.dot(&across)) + edge * (1.0 - cosine)
            }
            #[cfg(feature = "long-tips")]
            ProbeShape::Capsule { length_m, along } => r * (1.0 - cosine) + 0.5 * length_m * along.dot(up).abs(),
            #[cfg(feature = "long-tips")]
            ProbeShape::Ellipsoid { semi_axes_m: [a, b], along } => {
                let part = Vector3::new(a * along.dot(up), b * self.axis.cross(&along).dot(up), r * cosine);
                sqrt(part.dot(&part)) - r * cosine
            }
            _ => r * (1.0 - cosine),
        }
    }

    /// The probe turned about its tip by a quaternion x, y, z, w, whose length does not matter.
    #[cfg(feature = "long-tips")]
    #[must_use]
    pub fn turned(&self, [x, y, z, w]: [f32; 4]) -> Self {
        let part = Vector3::new(x, y, z);
        let twice = 2.0 / (part.dot(&part) + w * w);
        let turn = |v: Vector3<f32>| {
            let across = part.cross(&v);
            v + (across * w + part.cross(&across)) * twice
        };
        let shape = match self.shape {
            ProbeShape::Capsule { length_m, along } => ProbeShape::Capsule { length_m, along: turn(along) },
            ProbeShape::Ellipsoid { semi_axes_m, along } => ProbeShape::Ellipsoid { semi_axes_m, along: turn(along) },
            round => round,
        };
        Self { shape, axis: turn(self.axis), ..*self }
    }

    /// Displacement of the tip of a turned probe [m], after which its deepest point along `up` is
    /// as deep as the tip was, and its middle is where it was across `up`.
    #[cfg(feature = "long-tips")]
    pub(crate) fn levelled_m(&self, up: &Vector3<f32>) -> Vector3<f32> {
        let arm_m = if self.shape == ProbeShape::Flat { 0.0 } else { self.radius_m };
        up * self.below_tip_m(up) - (self.axis - up * self.axis.dot(up)) * arm_m
    }

    /// Checks an orientation of this upright probe.
    #[cfg(feature = "long-tips")]
    pub(crate) fn check_turn(&self, turn: [f32; 4]) -> Result<(), BuildError> {
        let square: f32 = turn.iter().map(|part| part * part).sum();
        BuildError::within("length of the unit quaternion probe.orientation", sqrt(square), 0.999, 1.001)?;
        let cosine = self.turned(turn).axis.dot(&self.axis);
        BuildError::within("cosine of the tilt (at most 45 degrees) by probe.orientation", cosine, LEAST_UPRIGHT, 1.001)
    }

    /// Checks the values that a capsule or an ellipsoid has in addition to radius and axis.
    #[cfg(feature = "long-tips")]
    pub(crate) fn check_shape(&self) -> Result<(), BuildError> {
        let along = match self.shape {
            ProbeShape::Hemisphere | ProbeShape::Sphere | ProbeShape::Flat => return Ok(()),
            ProbeShape::Capsule { length_m, along } => {
                BuildError::within("probe.length_m", length_m, 0.0, MOST_LENGTH_M)?;
                along
            }
            ProbeShape::Ellipsoid { semi_axes_m: [a, b], along } => {
                let (least, most) = (self.radius_m / MOST_RATIO, self.radius_m * MOST_RATIO);
                BuildError::within("probe.semi_axes_m[0]", a, least, most)?;
                BuildError::within("probe.semi_axes_m[1]", b, least, most)?;
                BuildError::within("probe.semi_axes_m[0]", a, b / MOST_RATIO, b * MOST_RATIO)?;
                along
            }
        };
        BuildError::within("probe.along length", sqrt(along.dot(&along)), 0.999, 1.001)?;
        BuildError::within("cosine of probe.along and probe.axis", along.dot(&self.axis), -LEANS, LEANS)
    }
}

impl Params {
    /// Orientation of a probe that is not turned.
    #[cfg(feature = "long-tips")]
    pub const UPRIGHT: [f32; 4] = [0.0, 0.0, 0.0, 1.0];

    /// The probe in its orientation.
    #[must_use]
    #[inline(always)]
    pub fn turned_probe(&self) -> Probe {
        #[cfg(feature = "long-tips")]
        if self.orientation != Self::UPRIGHT {
            return self.probe.turned(self.orientation);
        }
        self.probe
    }

    /// Displacement of the tip from a place on the surface to where the turned probe touches that
    /// place [m]: with its deepest point level with it and with its middle above it; zero for an
    /// upright probe.
    #[cfg(feature = "long-tips")]
    #[must_use]
    pub fn touch_offset_m(&self) -> Vector3<f32> {
        if self.orientation == Self::UPRIGHT {
            return Vector3::new(0.0, 0.0, 0.0);
        }
        self.turned_probe().levelled_m(&self.probe.axis)
    }
}
