//! The body of a tissue, for drawing.

use palpate::{Probe, ProbeShape};
use palpate_loop::live::{Choice, LiveTissue};

use crate::message::{Body, Tip};

impl Body {
    /// Describes a tissue as the body with this number; `choice` is `None` if its patch came from a
    /// file.
    #[must_use]
    pub fn of(tissue: &LiveTissue, number: u32, choice: Option<&Choice>) -> Self {
        let (model, params) = (tissue.patch().model(), tissue.params());
        Self {
            number,
            choice: choice.cloned(),
            rest_m: model.nodes.iter().map(|n| n.rest_m).collect(),
            skin: model.triangles.iter().map(|t| t.node).collect(),
            tets: model.tets.iter().map(|t| t.node).collect(),
            springs: model.springs.iter().map(|s| [s.i, s.j]).collect(),
            rim: model.rim_nodes.iter().map(|r| r.node as u16).collect(),
            anchors: model.anchors.to_vec(),
            site_m: tissue.patch().site_m().into(),
            axis: params.probe.axis.into(),
            radius_m: params.probe.radius_m,
            tip: drawn(&params.probe),
            depth_limit_m: model.depth_limit_m,
            youngs_modulus_pa: params.youngs_modulus_pa,
            node_damping_per_s: params.node_damping_per_s,
            lasting_share: 1.0 - params.relaxation.iter().map(|term| term.share).sum::<f32>(),
            stiffening_b: params.stiffening_b,
            friction: params.friction,
            block: choice.is_some_and(|choice| choice.scene().is_ok_and(|s| s.tissue.block_m.is_some())),
            own_nodules: choice.and_then(|choice| choice.own_nodules().ok()).unwrap_or_default(),
            fitted_places: tissue.patch().fitted_places(),
        }
    }
}

/// Shape of the tip as it is drawn.
fn drawn(probe: &Probe) -> Tip {
    match probe.shape {
        ProbeShape::Hemisphere | ProbeShape::Sphere => Tip::Ball,
        ProbeShape::Flat => Tip::Flat,
        ProbeShape::Capsule { length_m, along } => Tip::Capsule { half_m: (along * (0.5 * length_m)).into() },
        ProbeShape::Ellipsoid { semi_axes_m: [a, b], along } => {
            Tip::Ellipsoid { semi_axes_m: [(along * a).into(), (probe.axis.cross(&along) * b).into()] }
        }
    }
}
