//! The table "region radius x edge treatment -> force error, cost".
//!
//! One whole mesh of a block, patches of several radii cut out of it, every treatment of [`super::edges`] at each cut. Forces are equilibria of [`crate::statics`]; the
//! error against dense S is the edge's alone, the one against the whole mesh of the same springs adds that the outside is linear and better resolved than those
//! springs, the one against finite elements adds the springs inside.

mod awake;
mod cost;
mod pictures;
mod presses;
mod timing;
mod write;

pub use awake::{Awake, Frozen, Needed, Stress, awake};
pub use cost::{Cost, m4f_rim_cycles};
pub use pictures::pictures;
pub use presses::{Errors, Presses, Setting};
pub use write::{Summary, write};

use super::condense::condense;
use super::cut::Cut;
use super::edges::{Edge, Edges};
use crate::error::Error;
use crate::patch::{Material, Patch, Tissue};
use crate::scene::Scene;
use crate::statics::Statics;
use crate::tissue::place;

/// Loads that rims are fitted to stand this far around the site [probe radii].
const LOADS_RADII: f64 = 1.5;
/// Rim springs are held to this from [`PROMISED_RADII`] on [%].
pub const PROMISED_PCT: f64 = 0.5;
/// Smallest patch that is held to it [probe radii].
pub const PROMISED_RADII: f64 = 2.0;

/// What is run.
#[derive(Clone, Debug, PartialEq)]
pub struct Plan {
    /// Nodes of the whole meshes.
    pub nodes: Vec<usize>,
    /// Radii of the patches [probe radii].
    pub radii: Vec<f64>,
    /// Directions in which the probe goes off the centre.
    pub directions: usize,
    /// Nodes of the whole meshes whose nodes are put to sleep.
    pub awake_nodes: Vec<usize>,
}

impl Plan {
    /// Two element sizes.
    #[must_use]
    pub fn full() -> Self {
        Self { nodes: vec![200, 410], radii: vec![1.5, 2.0, 2.5, 3.0, 4.0], directions: 8, awake_nodes: vec![130, 410] }
    }

    /// One.
    #[must_use]
    pub fn quick() -> Self {
        Self { nodes: vec![200], radii: vec![1.5, 2.0, 2.5, 3.0], directions: 4, awake_nodes: vec![130] }
    }
}

/// What stands for the organ in a row.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Kind {
    /// A patch with an edge treatment.
    Patch(Edge),
    /// All of it as springs.
    Whole,
    /// All of it as finite elements.
    Elements,
}

impl Kind {
    /// Name in files.
    #[must_use]
    pub fn name(self) -> String {
        match self {
            Self::Patch(edge) => edge.name(),
            Self::Whole => "whole-organ-springs".into(),
            Self::Elements => "whole-organ-elements".into(),
        }
    }
}

/// A row of the table.
#[derive(Clone, Debug)]
pub struct Row {
    /// Nodes of the mesh that the patch was cut out of.
    pub whole_nodes: usize,
    /// Radius of the patch [m]; `None` for the whole organ.
    pub radius_m: Option<f64>,
    /// What is pressed.
    pub kind: Kind,
    /// Its nodes, tets, rim nodes and rim edges.
    pub size: Size,
    /// Forces.
    pub presses: Presses,
    /// Against the same patch with dense S.
    pub against_dense: Option<presses::Errors>,
    /// Against the whole mesh of the same springs.
    pub against_whole: Option<presses::Errors>,
    /// Against finite elements, where the scene has them: centred presses [%].
    pub against_elements_pct: [Option<f64>; presses::DEPTHS],
    /// Smallest eigenvalue of what stands at the edge over E [m].
    pub lowest_m: Option<f64>,
    /// What a tick costs.
    pub cost: Option<Cost>,
}

/// How large a patch is.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Size {
    /// Nodes.
    pub nodes: usize,
    /// Tets.
    pub tets: usize,
    /// Free nodes on the cut.
    pub rim_nodes: usize,
    /// Edges between them.
    pub rim_edges: usize,
}

/// All rows, and what could not be had.
#[derive(Clone, Debug, Default)]
pub struct Table {
    /// Mesh by mesh, radius by radius.
    pub rows: Vec<Row>,
    /// Patches that could not be cut, and why.
    pub left_out: Vec<String>,
}

/// Fills the table. `progress` hears of each finished patch and how many there will be.
///
/// # Errors
/// A scene that is no block, a block that cannot be meshed, a patch that is not stiff at rest, or no patch at all.
pub fn table(scene: &Scene, plan: &Plan, progress: &mut dyn FnMut(usize, usize, &str)) -> Result<Table, Error> {
    let setting = Setting::of(scene, plan.directions)?;
    let mut table = Table::default();
    let total = plan.nodes.len() * (plan.radii.len() + 1);
    let mut done = 0;
    for &nodes in &plan.nodes {
        progress(done, total, &format!("{nodes} nodes, whole"));
        let tissue = whole(scene, nodes)?;
        let patch = Patch::build(&tissue, &setting.material(), None);
        let statics = Statics::of(&patch.model(), &setting.params)?;
        let own = setting.press(&statics)?;
        done += 1;
        let mut whole_us: Option<f64> = None;
        let first = table.rows.len();
        for &radii in &plan.radii {
            let radius_m = radii * setting.radius_m();
            progress(done, total, &format!("{nodes} nodes, patch of {:.0} mm", radius_m * 1e3));
            done += 1;
            let sizes = super::Sizes { radius_m, fine_m: 0.0, fine_radius_m: 0.0, growth: 0.0, stroke_m: [0.0; 3] };
            match Cut::of(&tissue, &sizes) {
                Err(cause) => table.left_out.push(format!("{nodes} nodes: {cause}")),
                Ok(cut) => {
                    let us = patch_rows(&setting, &cut, (nodes, radius_m), (&patch, &own), &mut table.rows)?;
                    whole_us = whole_us.into_iter().chain(us).reduce(f64::min);
                }
            }
        }
        if table.rows.len() == first {
            continue;
        }
        let size = Size { nodes: tissue.mesh.nodes_m.len(), tets: tissue.mesh.tets.len(), ..Size::default() };
        table.rows.push(Row {
            whole_nodes: nodes,
            radius_m: None,
            kind: Kind::Whole,
            size,
            against_dense: None,
            against_whole: None,
            against_elements_pct: setting.against_elements(&own),
            presses: own,
            lowest_m: None,
            cost: Some(Cost::whole(&setting, &patch, whole_us)),
        });
        if let Some(elements) = setting.elements() {
            let whole = &table.rows[table.rows.len() - 1].presses;
            table.rows.push(Row {
                whole_nodes: nodes,
                radius_m: None,
                kind: Kind::Elements,
                size: Size::default(),
                against_dense: None,
                against_whole: Some(elements.against(whole)),
                against_elements_pct: [None; presses::DEPTHS],
                presses: elements,
                lowest_m: None,
                cost: None,
            });
        }
    }
    if table.rows.is_empty() {
        return Err(Error::Usage(table.left_out.join("; ")));
    }
    Ok(table)
}

/// The scene's block, meshed with so many nodes.
///
/// # Errors
/// No block, or a node count that its proportions do not take.
pub fn whole(scene: &Scene, nodes: usize) -> Result<Tissue, Error> {
    if scene.tissue.block_m.is_none() {
        let why = format!("{}: the table is made of a block, and tissue.block_m is not there: take --scene block", scene.file);
        return Err(Error::Usage(why));
    }
    let mut sized = scene.clone();
    sized.tissue.nodes = Some(nodes);
    Ok(place(&sized, &[])?.tissue)
}

/// Condenses and fits what can stand at the edge of a cut.
///
/// # Errors
/// Memory runs out, or the patch with its far field is not stiff at rest.
pub fn edges<'a>(setting: &Setting, cut: &'a Cut, free: &Statics) -> Result<Edges<'a>, Error> {
    let poisson_ratio = f64::from(setting.params.poisson_ratio);
    let nodes = cut.outside.mesh.nodes_m.len();
    let outside_m = condense(&cut.outside, poisson_ratio)
        .ok_or_else(|| Error::Check(format!("the outside of {nodes} nodes cannot be condensed: take fewer nodes")))?;
    Edges::of(cut, outside_m, free, LOADS_RADII * setting.radius_m()).map_err(|cause| Error::Check(cause.to_string()))
}

/// Adds a row for each treatment; the time of a tick of the whole mesh, measured in turn with theirs [us].
fn patch_rows(
    setting: &Setting,
    cut: &Cut,
    (whole_nodes, radius_m): (usize, f64),
    (whole, own): (&Patch, &Presses),
    rows: &mut Vec<Row>,
) -> Result<Option<f64>, Error> {
    let patch = Patch::build(&cut.patch, &setting.material(), None);
    let free = Statics::of(&patch.model(), &setting.params)?;
    let edges = edges(setting, cut, &free)?;
    let dense = setting.press(&edges.statics(&free, Edge::Dense)?)?;
    let times = timing::tick_times(setting, &edges, &patch, whole)?;
    let size = Size {
        nodes: cut.patch.mesh.nodes_m.len(),
        tets: cut.patch.mesh.tets.len(),
        rim_nodes: cut.rim.len(),
        rim_edges: edges.springs.blocks.len() - cut.rim.len(),
    };
    for edge in Edge::ALL {
        let statics = edges.statics(&free, edge)?;
        let presses = if edge == Edge::Dense { dense.clone() } else { setting.press(&statics)? };
        rows.push(Row {
            whole_nodes,
            radius_m: Some(radius_m),
            kind: Kind::Patch(edge),
            size,
            against_dense: (edge != Edge::Dense).then(|| presses.against(&dense)),
            against_whole: Some(presses.against(own)),
            against_elements_pct: setting.against_elements(&presses),
            presses,
            lowest_m: statics.rim.as_ref().and_then(|rim| lowest(&rim.stiffness_m)),
            cost: Some(Cost::of(setting, &patch, edge, size, &times)),
        });
    }
    Ok(times.whole_us)
}

fn lowest(matrix: &faer::Mat<f64>) -> Option<f64> {
    let values = matrix.self_adjoint_eigenvalues(faer::Side::Lower).ok()?;
    values.into_iter().reduce(f64::min)
}

impl Table {
    /// Rim springs that are further from dense S than promised or not positive, each as a sentence.
    #[must_use]
    pub fn broken(&self, probe_radius_m: f64) -> Vec<String> {
        let ours = self.rows.iter().filter(|r| r.kind == Kind::Patch(Edge::RimSprings));
        let mut broken = Vec::new();
        for row in ours {
            let (Some(errors), Some(radius_m)) = (&row.against_dense, row.radius_m) else { continue };
            let named = format!("rim springs at {:.0} mm, {} nodes", radius_m * 1e3, row.whole_nodes);
            if row.lowest_m.is_none_or(|l| l <= 0.0) {
                broken.push(format!("{named} are not positive"));
            }
            let worst = errors.centred_pct[..presses::PROMISED_DEPTHS].iter().chain(&errors.aside_pct);
            let worst = worst.map(|e| e.map_or(f64::INFINITY, f64::abs)).fold(0.0, f64::max);
            if radius_m >= (PROMISED_RADII - 1e-9) * probe_radius_m && worst > PROMISED_PCT {
                broken.push(format!("{named} are {worst:.2} % off dense S, promised {PROMISED_PCT} %"));
            }
        }
        broken
    }
}

impl Setting {
    /// What the tissue is made of.
    #[must_use]
    pub fn material(&self) -> Material {
        Material { poisson_ratio: f64::from(self.params.poisson_ratio), ..Material::default() }
    }
}
