//! The table "region radius x edge treatment -> force error, cost".
//!
//! Every patch is cut out of a mesh of the whole block, and every treatment of
//! [`super::rim_method`] is applied to its rim. Forces are equilibria of [`palpate_fit::statics`].
//! The error relative to the dense condensed stiffness S is due to the treatment alone. The error
//! against the whole mesh of the same springs also contains the difference between those springs
//! and the condensed outside, which is linear and better resolved. The error against finite
//! elements also contains that of the springs inside, which are not calibrated here.

mod awake;
mod cost;
mod figures;
mod presses;
mod report;
mod timing;

pub use awake::{Awake, Frozen, Needed, Stress, Surroundings, awake};
pub use cost::{Cost, m4f_rim_cycles};
pub use figures::draw;
pub use presses::{Errors, Presses, Setting};
pub use report::{Summary, write};

use super::rim_method::{RimMethod, RimMethods};
use crate::error::Error;
use palpate_fit::far_field::{FarField, FarFieldError, Sizes, whole};
use palpate_fit::statics::Statics;
use palpate_tissue::Error as TissueError;
use palpate_tissue::patch::{Material, Patch};
use palpate_tissue::scene::Scene;
use palpate_tissue::tissue::Tissue;
use palpate_tissue::tissue::place;
/// Largest error that is promised for rim springs on patches of at least [`PROMISED_RADII`] [%].
pub const PROMISED_PCT: f64 = 0.5;
/// Radius of the smallest patch to which this promise applies [probe radii].
pub const PROMISED_RADII: f64 = 2.0;

/// Scope of a run: meshes, patch radii and directions.
#[derive(Clone, Debug, PartialEq)]
pub struct Scope {
    /// Edge length under the probe [probe radii] and its growth per distance (1), for each
    /// resolution.
    pub fine: Vec<(f64, f64)>,
    /// Radii of the patches [probe radii].
    pub radii: Vec<f64>,
    /// Number of directions in which presses are offset from the centre.
    pub directions: usize,
    /// Node counts of the whole meshes on which parts are frozen.
    pub awake_nodes: Vec<usize>,
}

impl Scope {
    /// The whole table at two resolutions, at which a patch of two probe radii has about 75 and 165
    /// nodes.
    #[must_use]
    pub fn full() -> Self {
        let fine = vec![(0.575, 0.45), (0.4, 0.4)];
        Self { fine, radii: vec![1.5, 2.0, 2.5, 3.0, 4.0], directions: 8, awake_nodes: vec![130, 410] }
    }

    /// A short table of one resolution and four radii, which takes less than a minute.
    #[must_use]
    pub fn quick() -> Self {
        Self { fine: vec![(0.5, 0.45)], radii: vec![1.5, 2.0, 2.5, 3.0], directions: 4, awake_nodes: vec![130] }
    }
}

/// Model of the organ in a row.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Kind {
    /// A patch with an edge treatment.
    Patch(RimMethod),
    /// The whole organ as springs.
    Whole,
    /// The whole organ as finite elements.
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
    /// Edge length under the probe [m].
    pub fine_m: f64,
    /// Radius of the patch, or in other rows of the patch for which the mesh was made [m].
    pub radius_m: f64,
    /// Model that is pressed.
    pub kind: Kind,
    /// Numbers of nodes, tets, rim nodes and rim edges of the model.
    pub size: Size,
    /// Forces of all presses.
    pub presses: Presses,
    /// Errors relative to the same patch with the dense condensed stiffness S.
    pub against_dense: Option<presses::Errors>,
    /// Errors relative to the whole mesh of the same springs.
    pub against_whole: Option<presses::Errors>,
    /// Errors relative to finite elements; `None` if these were not solved for the scene.
    pub against_elements: Option<presses::Errors>,
    /// Smallest eigenvalue of the treatment's stiffness over E [m].
    pub lowest_m: Option<f64>,
    /// Cost of a tick.
    pub cost: Option<Cost>,
}

/// Numbers of nodes, tets, rim nodes and rim edges.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Size {
    /// Number of nodes.
    pub nodes: usize,
    /// Number of tets.
    pub tets: usize,
    /// Number of free nodes on the cut.
    pub rim_nodes: usize,
    /// Number of edges between these nodes.
    pub rim_edges: usize,
}

/// All rows, and the patches that could not be cut.
#[derive(Clone, Debug, Default)]
pub struct Table {
    /// Rows by mesh, then by radius.
    pub rows: Vec<Row>,
    /// One sentence for each patch that could not be cut, with the reason.
    pub left_out: Vec<String>,
}

/// Fills the table. `progress` is called before each patch with the number done, the total and the
/// patch.
///
/// # Errors
/// Fails if the scene has no block, if the stiffness of a patch is not positive at rest, or if no
/// patch could be cut.
pub fn table(scene: &Scene, scope: &Scope, progress: &mut dyn FnMut(usize, usize, &str)) -> Result<Table, Error> {
    let setting = Setting::of(scene, scope.directions)?;
    let mut table = Table::default();
    let tasks: Vec<_> = scope.fine.iter().flat_map(|fine| scope.radii.iter().map(move |radii| (*fine, *radii))).collect();
    for (done, &((fine, growth), radii)) in tasks.iter().enumerate() {
        let r = setting.radius_m();
        let sizes = Sizes { radius_m: radii * r, fine_m: fine * r, fine_radius_m: r, growth, stroke_m: [0.0; 3] };
        progress(done, tasks.len(), &format!("patch of {:.0} mm", sizes.radius_m * 1e3));
        let named = |cause: &dyn std::fmt::Display| format!("patch of {:.0} mm: {cause}", sizes.radius_m * 1e3);
        let tissue = match whole::whole(scene, &[], &sizes) {
            Ok(placed) => placed.tissue,
            Err(cause) => {
                table.left_out.push(named(&cause));
                continue;
            }
        };
        match FarField::of(&tissue, &sizes, &setting.material(), &setting.params) {
            Ok(far) => patch_rows(&setting, &sizes, &tissue, &far, &mut table.rows)?,
            Err(FarFieldError::Cut(cause)) => table.left_out.push(named(&cause)),
            Err(cause) => return Err(TissueError::Check(cause.to_string()).into()),
        }
    }
    if table.rows.is_empty() {
        return Err(TissueError::Usage(table.left_out.join("; ")).into());
    }
    Ok(table)
}

/// Sides of the scene's block [m].
fn block_of(scene: &Scene) -> Result<[f64; 3], Error> {
    Ok(scene.tissue.block_m.ok_or_else(|| {
        TissueError::Usage(format!(
            "{}: tissue.block_m is not there, and the table is made of a block: take --scene block",
            scene.file
        ))
    })?)
}

/// The scene's block, meshed with this many nodes.
///
/// # Errors
/// Fails if the scene has no block, or if its proportions do not permit the number of nodes.
pub fn graded(scene: &Scene, nodes: usize) -> Result<Tissue, Error> {
    block_of(scene)?;
    let mut sized = scene.clone();
    sized.tissue.nodes = Some(nodes);
    Ok(place(&sized, &[])?.tissue)
}

/// Adds a row for each treatment of a patch, one for the whole mesh, and one for finite elements.
fn patch_rows(setting: &Setting, sizes: &Sizes, tissue: &Tissue, far: &FarField, rows: &mut Vec<Row>) -> Result<(), Error> {
    let whole = Patch::build(tissue, &setting.material(), None);
    let own = setting.press(&Statics::of(&whole.model(), &setting.params)?)?;
    let patch = Patch::build(&far.cut.patch, &setting.material(), None);
    let free = Statics::of(&patch.model(), &setting.params)?;
    let edges = RimMethods::of(far, &free, setting.radius_m())?;
    let dense = setting.press(&edges.statics(&free, RimMethod::Dense)?)?;
    let times = timing::tick_times(setting, &edges, &patch, &whole)?;
    let row = |kind: Kind, size: Size, presses: Presses| Row {
        fine_m: sizes.fine_m,
        radius_m: sizes.radius_m,
        kind,
        size,
        against_dense: (kind != Kind::Patch(RimMethod::Dense)).then(|| presses.against(&dense)),
        against_whole: (kind != Kind::Whole).then(|| presses.against(&own)),
        against_elements: setting.against_elements(&presses).filter(|_| kind != Kind::Elements),
        presses,
        lowest_m: None,
        cost: None,
    };
    let size = Size {
        nodes: far.cut.patch.mesh.nodes_m.len(),
        tets: far.cut.patch.mesh.tets.len(),
        rim_nodes: far.cut.rim.len(),
        rim_edges: far.springs.blocks.len() - far.cut.rim.len(),
    };
    for edge in RimMethod::ALL {
        let statics = edges.statics(&free, edge)?;
        let presses = if edge == RimMethod::Dense { dense.clone() } else { setting.press(&statics)? };
        let lowest_m = statics.rim.as_ref().and_then(|rim| lowest(&rim.stiffness_m));
        let cost = Some(Cost::of(setting, &patch, edge, size, &times));
        rows.push(Row { lowest_m, cost, ..row(Kind::Patch(edge), size, presses) });
    }
    let size = Size { nodes: tissue.mesh.nodes_m.len(), tets: tissue.mesh.tets.len(), ..Size::default() };
    let cost = Some(Cost::whole(setting, &whole, times.whole_us));
    rows.push(Row { cost, ..row(Kind::Whole, size, own.clone()) });
    if let Some(elements) = setting.elements() {
        rows.push(row(Kind::Elements, Size::default(), elements));
    }
    Ok(())
}

fn lowest(matrix: &faer::Mat<f64>) -> Option<f64> {
    let values = matrix.self_adjoint_eigenvalues(faer::Side::Lower).ok()?;
    values.into_iter().reduce(f64::min)
}

impl Table {
    /// One sentence for each row whose rim springs are not positive, or deviate from dense S by
    /// more than promised.
    #[must_use]
    pub fn broken(&self, probe_radius_m: f64) -> Vec<String> {
        let ours = self.rows.iter().filter(|r| r.kind == Kind::Patch(RimMethod::RimSprings));
        let mut broken = Vec::new();
        for row in ours {
            let Some(errors) = &row.against_dense else { continue };
            let named = format!("rim springs at {:.0} mm, elements of {:.1} mm,", row.radius_m * 1e3, row.fine_m * 1e3);
            if row.lowest_m.is_none_or(|l| l <= 0.0) {
                broken.push(format!("{named} are not positive"));
            }
            let worst = worst_pct(errors);
            if is_promised(row, probe_radius_m) && worst > PROMISED_PCT {
                broken.push(format!("{named} are {worst:.2} % off dense S, promised {PROMISED_PCT} %"));
            }
        }
        broken
    }

    /// Largest error of rim springs among the rows and presses to which the promise applies [%].
    #[must_use]
    pub fn worst_promised_pct(&self, probe_radius_m: f64) -> f64 {
        let ours = self.rows.iter().filter(|r| r.kind == Kind::Patch(RimMethod::RimSprings) && is_promised(r, probe_radius_m));
        ours.filter_map(|row| row.against_dense.as_ref()).map(worst_pct).fold(0.0, f64::max)
    }
}

fn is_promised(row: &Row, probe_radius_m: f64) -> bool {
    row.radius_m >= (PROMISED_RADII - 1e-9) * probe_radius_m
}

/// Largest error among the presses to which the promise applies [%].
fn worst_pct(errors: &Errors) -> f64 {
    let promised = errors.centred_pct[..presses::PROMISED_DEPTHS].iter().chain(&errors.aside_pct);
    promised.map(|e| e.map_or(f64::INFINITY, f64::abs)).fold(0.0, f64::max)
}

impl Setting {
    /// Material of the springs, with the Poisson's ratio of the scene.
    #[must_use]
    pub fn material(&self) -> Material {
        Material { poisson_ratio: f64::from(self.params.poisson_ratio), ..Material::default() }
    }
}
