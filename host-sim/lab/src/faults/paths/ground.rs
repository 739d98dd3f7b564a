//! Every shipped patch with its geometry at rest, and every device, for the paths to run on.

use std::borrow::Cow;
use std::sync::Arc;

use palpate::{BuildError, Params, Probe, ProbeShape, Vector3};
use rayon::prelude::*;

use palpate_loop::closed_loop::device::{DeviceProfile, PROFILES};
use palpate_loop::closed_loop::stimulus::Site;
use palpate_loop::closed_loop::surface::{depth_at_m, force_at_n, static_curve};
use palpate_loop::closed_loop::watch::{RestShape, RestSolid};
use palpate_tissue::error::Error;
use palpate_tissue::patch::Patch;
use palpate_tissue::session::packed;

/// Static force at the guard's depth, as a multiple of the device's maximum force (1).
const GUARD_SHARE: f64 = 1.09;

/// A tip (`None` is the patch's own), and the number of paths out of five that use it.
type Tip = (Option<ProbeShape>, u32);
/// Name, bytes and share of a shipped patch.
type Shipped = (&'static str, &'static [u8], u32);

/// Tips for every patch: its own, and two of half its radius with which no shipped patch was
/// calibrated. Each has the number of paths out of five that use it.
const TIPS: [Tip; 3] = [(None, 3), (Some(ProbeShape::Sphere), 1), (Some(ProbeShape::Flat), 1)];
/// Radius of the other tips, relative to the patch's own (1).
const OTHER_TIP: f32 = 0.5;

/// The shipped patches, and the number of paths out of 1000 that run on each: a tick of the large
/// ones costs ten times as much.
const SHIPPED: [Shipped; 7] = [
    ("block-m4f-168", include_bytes!("../../../../../firmware/patches/block-m4f-168.patch"), 400),
    ("liver-m4f-168", include_bytes!("../../../../../firmware/patches/liver-m4f-168.patch"), 400),
    ("block-m7-480", include_bytes!("../../../../../firmware/patches/block-m7-480.patch"), 100),
    ("nodule-m7-480", include_bytes!("../../../../../firmware/patches/nodule-m7-480.patch"), 50),
    ("block-130", include_bytes!("../../../../patches/block-130.patch"), 35),
    ("block-410", include_bytes!("../../../../patches/block-410.patch"), 10),
    ("block-1020", include_bytes!("../../../../patches/block-1020.patch"), 5),
];

/// A patch, ready for paths.
#[derive(Clone, Debug)]
pub struct PathPatch {
    /// File name of the patch, without its extension.
    pub name: &'static str,
    /// The patch as it was packed.
    pub patch: Patch,
    /// Parameters that the patch was packed with.
    pub params: Params,
    /// Number of paths out of 5000 that run on this patch with this tip.
    pub share: u32,
    /// Geometry of the patch at rest.
    pub shape: Arc<RestSolid>,
    /// Place of the tip where it touches the site, with its axes.
    pub site: Site,
    /// Lower and upper corner of the patch along the site's axes `along`, `across`, `normal`,
    /// relative to the site [m].
    pub extent_m: [[f64; 3]; 2],
    /// Static force against depth, with the force divided by Young's modulus [m, N/Pa].
    curve: Vec<(f64, f64)>,
}

/// Every patch under every tip, and every device.
#[derive(Clone, Debug)]
pub struct PathGround {
    /// The shipped patches, each under its own tip and then under the others.
    pub patches: Vec<PathPatch>,
    /// Every shipped device.
    pub devices: Vec<DeviceProfile>,
}

impl PathGround {
    /// Loads every shipped patch and profile.
    pub fn load() -> Result<Self, Error> {
        let pairs: Vec<_> = SHIPPED.iter().flat_map(|shipped| TIPS.iter().map(move |tip| (shipped, tip))).collect();
        let patch = |((name, bytes, share), (shape, of_five)): &(&Shipped, &Tip)| {
            let (patch, mut params) = packed::unpack(bytes)?;
            if let Some(shape) = *shape {
                params.probe = Probe { shape, radius_m: OTHER_TIP * params.probe.radius_m, ..params.probe };
            }
            PathPatch::under(name, patch, params, share * of_five)
        };
        let patches: Result<Vec<PathPatch>, BuildError> = pairs.par_iter().map(patch).collect();
        let devices: Result<Vec<DeviceProfile>, Error> = PROFILES.iter().map(|(name, _)| DeviceProfile::load(name)).collect();
        Ok(Self { patches: patches?, devices: devices? })
    }
}

impl PathPatch {
    /// Returns the same patch under another probe, in this orientation.
    pub fn with_probe(&self, probe: Probe, orientation: [f32; 4]) -> Result<Self, BuildError> {
        Self::under(self.name, self.patch.clone(), Params { probe, orientation, ..self.params }, self.share)
    }

    fn under(name: &'static str, patch: Patch, params: Params, share: u32) -> Result<Self, BuildError> {
        let shape = Arc::new(RestSolid::of(&patch.model(), &params.turned_probe()));
        let site = Site::new(patch.touch_m(&params).cast(), params.probe.axis.cast());
        let extent_m = shape.extent_m(&site.at_m, &[site.along, site.across(), site.normal]);
        let per_pascal = 1.0 / f64::from(params.youngs_modulus_pa);
        let curve =
            static_curve(&patch, &params)?.into_iter().map(|(depth_m, force_n)| (depth_m, force_n * per_pascal)).collect();
        Ok(Self { name, patch, params, share, shape, site, extent_m, curve })
    }

    /// Names of patch and tip, for tables.
    pub fn label(&self) -> Cow<'static, str> {
        let Probe { shape, radius_m, .. } = self.params.probe;
        match shape {
            ProbeShape::Hemisphere => self.name.into(),
            _ => {
                let tilt_deg = self.params.turned_probe().axis.angle(&self.params.probe.axis).to_degrees();
                let tilted = if tilt_deg > 0.5 { format!(", tilted by {tilt_deg:.0} degrees") } else { String::new() };
                format!("{} under {shape:?} of {:.1} mm{tilted}", self.name, 1e3 * radius_m).into()
            }
        }
    }

    /// Depth limit of the guard for a device [m]: the static force there is 1.09 times the device's
    /// maximum force.
    pub fn guard_depth_m(&self, youngs_modulus_pa: f64, force_limit_n: f64) -> f64 {
        depth_at_m(&self.curve, GUARD_SHARE * force_limit_n / youngs_modulus_pa)
    }

    /// Static force at a depth [N].
    pub fn force_n(&self, youngs_modulus_pa: f64, depth_m: f64) -> f64 {
        force_at_n(&self.curve, depth_m) * youngs_modulus_pa
    }

    /// Whether a tip at this position touches the patch at rest [m].
    pub fn shape_touches(&self, tip_m: &Vector3<f64>) -> bool {
        self.shape.inside(tip_m)
    }

    /// Position of a point given by its coordinates along the site's axes [m].
    pub fn point_m(&self, at: &[f64; 3]) -> Vector3<f64> {
        self.site.point_m(-at[2], at[0], at[1])
    }
}
