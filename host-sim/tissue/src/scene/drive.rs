//! Motion of the probe in a scene.

use std::path::PathBuf;

use serde::Deserialize;

/// Motion of the probe, by its kind.
#[derive(Clone, Debug, Deserialize, PartialEq)]
#[serde(try_from = "Table")]
pub enum Drive {
    /// The tip moves to each depth in turn and waits there.
    Depth {
        /// Depths of the holds [m].
        holds_m: Vec<f64>,
        /// Speed between the holds [m/s].
        ramp_m_per_s: f64,
        /// Duration of each hold [s].
        hold_s: f64,
    },
    /// A finger pushes with each force in turn and holds it.
    Force {
        /// Forces of the holds [N].
        holds_n: Vec<f64>,
        /// Largest speed of the approach [m/s].
        ramp_m_per_s: f64,
        /// Duration of each hold [s].
        hold_s: f64,
    },
    /// A compliant finger, whose hand moves to each depth in turn.
    Hand {
        /// Depths of the hand's target [m].
        holds_m: Vec<f64>,
        /// Speed of the target [m/s].
        ramp_m_per_s: f64,
        /// Duration of each hold [s].
        hold_s: f64,
    },
    /// The tip follows the probe columns of a `trace.csv`.
    Trace {
        /// Path of the trace, relative to the scene file.
        trace: PathBuf,
        /// Depth limit of the patch [m]. It determines the substeps, so that a run reproduces the
        /// recorded bits only with the depth limit of the recorded run (`report.depth_limit_mm` in
        /// its summary.json). Without this key the limit follows from the deepest tip of the trace.
        depth_limit_m: Option<f64>,
    },
}

impl Drive {
    /// Speed between holds [m/s]; `None` for a trace.
    #[must_use]
    pub fn ramp_m_per_s(&self) -> Option<f64> {
        match self {
            Self::Depth { ramp_m_per_s, .. } | Self::Force { ramp_m_per_s, .. } | Self::Hand { ramp_m_per_s, .. } => {
                Some(*ramp_m_per_s)
            }
            Self::Trace { .. } => None,
        }
    }

    /// Returns the targets of the holds: depths [m], forces [N] or hand targets [m].
    #[must_use]
    pub fn targets(&self) -> &[f64] {
        match self {
            Self::Depth { holds_m, .. } | Self::Hand { holds_m, .. } => holds_m,
            Self::Force { holds_n, .. } => holds_n,
            Self::Trace { .. } => &[],
        }
    }
}

/// Motion of the probe. A whole run takes at most 1000 s.
// The keys of `[drive]` as they are written: with a tagged enum, serde would lose the line of a
// value of the wrong type.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Table {
    /// Kind of motion.
    kind: Kind,
    /// Depths of the probe (`depth`) or of the hand's target (`hand`) at each hold, in order [m].
    ///
    /// * range: above 0
    holds_m: Option<Vec<f64>>,
    /// Forces with which the finger pushes at each hold (`force`), in order [N].
    ///
    /// * range: above 0 to 12
    holds_n: Option<Vec<f64>>,
    /// Speed between holds [m/s]; for `force`, the largest speed of the approach.
    ///
    /// * range: above 0 to 1
    ramp_m_per_s: Option<f64>,
    /// Duration of each hold [s].
    ///
    /// * range: 0.001 to 60
    hold_s: Option<f64>,
    /// File with the probe columns of a `trace.csv`, relative to the scene file (`trace`).
    trace: Option<PathBuf>,
    /// Depth limit of the patch [m] (`trace`). It determines the substeps: a run reproduces the
    /// recorded bits only with the depth limit of the recorded run (`report.depth_limit_mm` in its
    /// summary.json).
    ///
    /// * range: above 0
    /// * default: from the deepest tip of the trace
    depth_limit_m: Option<f64>,
}

#[derive(Clone, Copy, Deserialize, PartialEq)]
#[serde(rename_all = "lowercase")]
enum Kind {
    /// The tip moves to each depth in turn and waits there.
    Depth,
    /// A finger pushes with each force in turn and holds it.
    Force,
    /// A compliant finger, whose hand moves to each depth in turn.
    Hand,
    /// The tip repeats a recorded trace.
    Trace,
}

impl TryFrom<Table> for Drive {
    type Error = String;

    fn try_from(table: Table) -> Result<Self, String> {
        let Table { kind, holds_m, holds_n, ramp_m_per_s, hold_s, trace, depth_limit_m } = table;
        // (key, whether the scene gives it, kinds that accept it)
        let keys = [
            ("holds_m", holds_m.is_some(), [Kind::Depth, Kind::Hand].as_slice()),
            ("holds_n", holds_n.is_some(), &[Kind::Force]),
            ("ramp_m_per_s", ramp_m_per_s.is_some(), &[Kind::Depth, Kind::Hand, Kind::Force]),
            ("hold_s", hold_s.is_some(), &[Kind::Depth, Kind::Hand, Kind::Force]),
            ("trace", trace.is_some(), &[Kind::Trace]),
            ("depth_limit_m", depth_limit_m.is_some(), &[Kind::Trace]),
        ];
        let of_this_kind = || keys.iter().filter(|(.., kinds)| kinds.contains(&kind)).map(|(key, ..)| format!("`{key}`"));
        if let Some((key, ..)) = keys.iter().find(|(_, there, kinds)| *there && !kinds.contains(&kind)) {
            let known = of_this_kind().collect::<Vec<_>>().join(", ");
            return Err(format!("unknown field `{key}`, expected {known}"));
        }
        let missing = |key: &str| format!("missing field `{key}`");
        let ramp = || ramp_m_per_s.ok_or_else(|| missing("ramp_m_per_s"));
        let hold = || hold_s.ok_or_else(|| missing("hold_s"));
        let depths = || holds_m.clone().ok_or_else(|| missing("holds_m"));
        Ok(match kind {
            Kind::Depth => Self::Depth { holds_m: depths()?, ramp_m_per_s: ramp()?, hold_s: hold()? },
            Kind::Hand => Self::Hand { holds_m: depths()?, ramp_m_per_s: ramp()?, hold_s: hold()? },
            Kind::Force => {
                Self::Force { holds_n: holds_n.ok_or_else(|| missing("holds_n"))?, ramp_m_per_s: ramp()?, hold_s: hold()? }
            }
            Kind::Trace => Self::Trace { trace: trace.ok_or_else(|| missing("trace"))?, depth_limit_m },
        })
    }
}
