//! Every shipped patch with its geometry at rest, and every device, for the paths to run on.

use std::borrow::Cow;
use std::sync::Arc;

use palpate::{BuildError, Params, Probe, ProbeShape, Vector3};
use rayon::prelude::*;

use crate::closed_loop::device::{DeviceProfile, PROFILES};
use crate::closed_loop::stimulus::Site;
use crate::closed_loop::surface::{depth_at_m, static_curve};
use crate::closed_loop::watch::RestSolid;
use palpate_tissue::error::Error;
use palpate_tissue::patch::Patch;
use palpate_tissue::session::packed;

/// Static force at the guard's depth, as a multiple of the device's maximum force (1).
const GUARD_SHARE: f64 = 1.09;

/// A tip, `None` for the patch's own, and the number of paths in five that use it.
type Tip = (Option<ProbeShape>, u32);
/// Name, bytes and share of a shipped patch.
type Shipped = (&'static str, &'static [u8], u32);

/// Tips that touch every patch: its own, and two of half its radius that the finite elements of no
/// shipped patch know. Of five paths on a patch, the number that each takes.
const TIPS: [Tip; 3] = [(None, 3), (Some(ProbeShape::Sphere), 1), (Some(ProbeShape::Flat), 1)];
/// Radius of the other tips, as a share of the own one (1).
const OTHER_TIP: f32 = 0.5;

/// The shipped patches, and the share of 1000 paths that run on each: the large ones cost ten times
/// as much per tick.
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
    /// File name without its ending.
    pub name: &'static str,
    /// The patch.
    pub patch: Patch,
    /// Parameters that the patch was packed with.
    pub params: Params,
    /// Number of paths of 5000 that run on this patch and tip.
    pub share: u32,
    /// Geometry of the patch at rest.
    pub shape: Arc<RestSolid>,
    /// Site of the press, and axes.
    pub site: Site,
    /// Extent along the site's axes `along`, `across`, `normal`, from the site [m].
    pub extent_m: [[f64; 3]; 2],
    /// Static force over depth, both per pascal as packed [m, N/Pa].
    curve: Vec<(f64, f64)>,
}

/// Every patch under every tip, and every device.
#[derive(Clone, Debug)]
pub struct PathGround {
    /// The shipped patches, each under its own tip and then under the others.
    pub patches: Vec<PathPatch>,
    /// The devices.
    pub devices: Vec<DeviceProfile>,
}

impl PathGround {
    /// Loads every shipped patch and profile.
    ///
    /// # Errors
    /// A patch or a profile that the core refuses.
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
    /// The patch under another probe.
    ///
    /// # Errors
    /// A probe that the core refuses.
    pub fn with_probe(&self, probe: Probe) -> Result<Self, BuildError> {
        Self::under(self.name, self.patch.clone(), Params { probe, ..self.params }, self.share)
    }

    fn under(name: &'static str, patch: Patch, params: Params, share: u32) -> Result<Self, BuildError> {
        let shape = Arc::new(RestSolid::of(&patch.model(), &params.probe));
        let site = Site::new(patch.site_m().cast(), params.probe.axis.cast());
        let extent_m = shape.extent_m(&site.at_m, &[site.along, site.across(), site.normal]);
        let per_pascal = 1.0 / f64::from(params.youngs_modulus_pa);
        let curve =
            static_curve(&patch, &params)?.into_iter().map(|(depth_m, force_n)| (depth_m, force_n * per_pascal)).collect();
        Ok(Self { name, patch, params, share, shape, site, extent_m, curve })
    }

    /// Patch and tip in words.
    #[must_use]
    pub fn label(&self) -> Cow<'static, str> {
        let Probe { shape, radius_m, .. } = self.params.probe;
        match shape {
            ProbeShape::Hemisphere => self.name.into(),
            _ => format!("{} under {shape:?} of {:.1} mm", self.name, 1e3 * radius_m).into(),
        }
    }

    /// Depth of the guard for a device: where the static force is 1.09 times the device's largest
    /// [m].
    #[must_use]
    pub fn guard_depth_m(&self, youngs_modulus_pa: f64, force_limit_n: f64) -> f64 {
        depth_at_m(&self.curve, GUARD_SHARE * force_limit_n / youngs_modulus_pa)
    }

    /// A point by its distances along the site's axes [m].
    #[must_use]
    pub fn point_m(&self, at: &[f64; 3]) -> Vector3<f64> {
        self.site.point_m(-at[2], at[0], at[1])
    }
}
