//! Tissue to press: a scene, and the changes made with the sliders.

use palpate::Vector3;
use serde::{Deserialize, Serialize};

use super::tissue::LiveTissue;
use palpate_tissue::error::Error;
use palpate_tissue::scene::{Drive, Inclusion, Scene};
use palpate_tissue::session::{Session, calibrated};
use palpate_tissue::tissue::DEPTH_MARGIN;

/// Node counts offered for the block: those with a calibrated patch, and one without.
pub const SIZES: [usize; 4] = [130, 230, 410, 1020];

/// A ball that is stiffer than the tissue around it.
#[derive(Clone, Copy, Debug, Deserialize, PartialEq, Serialize)]
pub struct Nodule {
    /// Position of the centre along the surface [m].
    pub place_m: [f64; 2],
    /// Depth of the centre [m].
    pub depth_m: f64,
    /// Radius of the ball [m].
    pub radius_m: f64,
    /// Stiffness as a multiple of the tissue's.
    pub ratio: f64,
}

impl Nodule {
    /// Converts an inclusion of a scene, in a block whose top is at z = 0.
    #[must_use]
    pub fn of(ball: &Inclusion) -> Self {
        let [x, y, z] = ball.center_m;
        Self { place_m: [x, y], depth_m: -z, radius_m: ball.radius_m, ratio: ball.stiffness_ratio }
    }

    /// The nodule as an inclusion of a scene, in a block whose top is at z = 0.
    #[must_use]
    pub fn inclusion(&self) -> Inclusion {
        let [x, y] = self.place_m;
        Inclusion { center_m: [x, y, -self.depth_m], radius_m: self.radius_m, stiffness_ratio: self.ratio, stiffening_b: None }
    }
}

/// Nodules in a block.
#[derive(Clone, Copy, Debug, Default, Deserialize, PartialEq, Serialize)]
pub enum Inside {
    /// The nodules of the scene.
    #[default]
    Own,
    /// No nodule, even where the scene has some.
    Nothing,
    /// This nodule, in place of the scene's.
    Nodule(Nodule),
}

/// Scene to press, and the changes to it.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
pub struct Choice {
    /// Name of a preset, or of the scene file whose content is `text`.
    pub scene: String,
    /// Text of a scene file; empty for a preset.
    pub text: String,
    /// Nodes of the mesh; the scene's own if `None`.
    pub nodes: Option<usize>,
    /// Young's modulus [Pa]; the scene's own if `None`.
    pub youngs_modulus_pa: Option<f64>,
    /// Damping of the nodes [1/s]; the scene's own if `None`.
    pub node_damping_per_s: Option<f64>,
    /// Nodules of a block; other tissue keeps those of the scene.
    pub inside: Inside,
}

impl Choice {
    /// An unchanged preset.
    #[must_use]
    pub fn preset(name: &str) -> Self {
        Self {
            scene: name.into(),
            text: String::new(),
            nodes: None,
            youngs_modulus_pa: None,
            node_damping_per_s: None,
            inside: Inside::Own,
        }
    }

    /// Returns the scene with every change applied, after checking it.
    ///
    /// # Errors
    /// Returns the first error in the scene, with its position.
    pub fn scene(&self) -> Result<Scene, Error> {
        let mut scene = if self.text.is_empty() { Scene::load(&self.scene)? } else { Scene::parse(&self.scene, &self.text)? };
        let tissue = &mut scene.tissue;
        if self.nodes.is_some() {
            tissue.nodes = self.nodes;
        }
        tissue.youngs_modulus_pa = self.youngs_modulus_pa.unwrap_or(tissue.youngs_modulus_pa);
        tissue.node_damping_per_s = self.node_damping_per_s.unwrap_or(tissue.node_damping_per_s);
        match self.inside {
            Inside::Nothing if tissue.block_m.is_some() => tissue.inclusion.clear(),
            Inside::Nodule(nodule) if tissue.block_m.is_some() => tissue.inclusion = vec![nodule.inclusion()],
            _ => {}
        }
        scene.check()?;
        scene.refuse_tilt("the live view shows an upright tip: leave it out, or use press")?;
        Ok(scene)
    }

    /// The scene's own nodules, even if `inside` replaces them.
    ///
    /// # Errors
    /// Errors of [`Self::scene`].
    pub fn own_nodules(&self) -> Result<Vec<Nodule>, Error> {
        let own = Self { inside: Inside::Own, ..self.clone() };
        Ok(own.scene()?.tissue.inclusion.iter().map(Nodule::of).collect())
    }

    /// Returns whether both choices are equal except for what [`LiveTissue::retune`] can change.
    #[must_use]
    pub fn same_patch(&self, other: &Self) -> bool {
        let bare = |c: &Self| Self { youngs_modulus_pa: None, node_damping_per_s: None, ..c.clone() };
        bare(self) == bare(other)
    }

    /// Builds the tissue of this choice.
    ///
    /// # Errors
    /// A scene that does not fit, or a model that cannot keep 1 kHz.
    pub fn tissue(&self) -> Result<LiveTissue, Error> {
        let mut scene = self.scene()?;
        if let Some((patch, params)) = calibrated::as_shipped(&scene) {
            return Ok(LiveTissue::new(patch, params)?);
        }
        // the patch is prepared for presses as deep as the probe's radius, the depth up to which
        // the contact law was measured, and not for the scene's own drive
        let deepest_m = scene.probe.radius_m as f32;
        if scene.tissue.block_m.is_some() {
            let holds_m = vec![scene.probe.radius_m / DEPTH_MARGIN];
            scene.drive = Drive::Depth { holds_m, ramp_m_per_s: 0.04, hold_s: 0.3 };
        }
        let session = Session::prepare(&scene)?;
        let mut patch = session.patch;
        if patch.model().depth_limit_m > deepest_m {
            patch.set_depth_limit_m(deepest_m);
        }
        Ok(LiveTissue::new(patch, session.params)?)
    }
}

/// Outward normal of the tissue at the site of the press.
#[must_use]
pub(super) fn axis(tissue: &LiveTissue) -> Vector3<f64> {
    tissue.params().probe.axis.cast()
}
