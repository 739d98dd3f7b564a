//! The rigid probe: shape, size and orientation.

use nalgebra::Vector3;

#[cfg(feature = "long-tips")]
use crate::fault::BuildError;
#[cfg(feature = "long-tips")]
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
    /// the tissue [m]; zero where `up` is the axis.
    #[inline(always)]
    pub(crate) fn below_tip_m(&self, up: &Vector3<f32>) -> f32 {
        let r = self.radius_m;
        let cosine = self.axis.dot(up);
        match self.shape {
            ProbeShape::Flat => 0.0,
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
