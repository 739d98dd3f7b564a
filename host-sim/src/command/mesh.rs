//! `palpate mesh check` and `palpate mesh pack`.

use std::path::PathBuf;

use clap::Subcommand;

use super::Common;
use super::pack::FarArgs;
use crate::budget::{Cost, MACHINES, Machine, triangles_in_reach};
use crate::error::Error;
use crate::mesh::import::import;
use crate::output::OutputFolder;
use crate::scene::Scene;
use crate::session::Session;
use crate::tissue::DEFAULT_NODES;

/// Fewest nodes that the block generator meshes.
const LEAST_NODES: usize = 30;
/// Counts tried beyond the bisection's answer.
const LOOK_AHEAD: usize = 4;

#[derive(Clone, Debug, Subcommand)]
pub(super) enum MeshCommand {
    /// Import a mesh file and report what was found.
    ///
    /// Reads Gmsh 1, 2.2 and 4.1 ASCII, TetGen .node/.ele and legacy ASCII VTK. Writes nothing.
    Check {
        /// The mesh file.
        file: PathBuf,
        /// Metres in one unit of the file: 1 for metres, 0.001 for millimetres.
        #[arg(long, value_name = "METRES", default_value_t = 1.0)]
        unit_m: f64,
    },
    /// Build a scene's patch and write it as a patch file for a board.
    ///
    /// Writes <scene>-<board>.patch. The firmware takes it in, and a scene presses it with patch = "FILE" under [solver]. With --radius-m only the tissue around
    /// the site is packed, graded to the organ's surface; rim springs stand in for the rest, and the patch is calibrated against finite elements of the whole
    /// organ (summary.json and accuracy.csv say how right it came out).
    Pack {
        #[command(flatten)]
        common: Common,
        /// Board whose budget a tick of the patch must meet: m4f-168 (Cortex-M4F, 168 MHz), m7-480 (Cortex-M7, 480 MHz) or desktop.
        #[arg(long, value_name = "BOARD", default_value = "m4f-168")]
        board: String,
        /// Nodes of the block's mesh [default: the most that fit the board, up to the scene's].
        #[arg(long, value_name = "COUNT")]
        nodes: Option<usize>,
        #[command(flatten)]
        far: FarArgs,
    },
}

impl MeshCommand {
    pub(super) fn run(&self) -> Result<(), Error> {
        match self {
            Self::Check { file, unit_m } => check(file, *unit_m),
            Self::Pack { common, board, nodes, far } => match far.asked() {
                Some(radius_m) => far.pack(common, machine(board)?, radius_m),
                None => pack(common, machine(board)?, *nodes),
            },
        }
    }
}

fn check(file: &std::path::Path, unit_m: f64) -> Result<(), Error> {
    let report = import(file, unit_m)?.report;
    let [x, y, z] = report.size_m.map(|m| m * 1e3);
    println!("{}: {}", file.display(), report.format);
    println!("  {} nodes, {} tets; {x:.2} x {y:.2} x {z:.2} mm, {:.3} cm^3", report.nodes, report.tets, report.volume_m3 * 1e6);
    println!("  worst tet {} (quality {:.4}, 1 is regular)", report.worst_tet.index, report.worst_tet.quality);
    println!("  {} tets turned round, {} unused nodes left out", report.flipped_tets, report.unused_nodes);
    for (kind, count) in &report.ignored {
        println!("  {count} {kind} left out");
    }
    Ok(())
}

/// The machine of this name.
pub(super) fn machine(board: &str) -> Result<&'static Machine, Error> {
    Machine::named(board).ok_or_else(|| {
        let names = MACHINES.map(|m| m.name).join(", ");
        Error::Usage(format!("no board \"{board}\": choose one of {names}"))
    })
}

fn pack(common: &Common, machine: &Machine, nodes: Option<usize>) -> Result<(), Error> {
    let scene = Scene::load(&common.scene)?;
    if nodes.is_some() && scene.tissue.block_m.is_none() {
        return Err(Error::Usage(format!("--nodes is for a block; scene {} brings its own mesh: leave it out", scene.name)));
    }
    let sized = |n: usize| {
        let mut scene = scene.clone();
        scene.tissue.nodes = Some(n);
        Packed::of(&scene, machine)
    };
    let packed = match (nodes, scene.tissue.block_m) {
        (Some(n), _) => sized(n)?,
        (None, Some(_)) => largest(sized, scene.tissue.nodes.unwrap_or(DEFAULT_NODES))?,
        (None, None) => Packed::of(&scene, machine)?,
    };
    let Packed { session, cost, touched } = packed;
    let model = session.patch.model();
    if cost.units > cost.budget {
        return Err(Error::TooSlow(format!(
            "{} nodes take about {:.0} {} a tick, {:.0} fit on {}: take fewer nodes or a faster board",
            model.nodes.len(),
            cost.units,
            machine.unit,
            cost.budget,
            machine.name
        )));
    }
    let folder = OutputFolder::add_to(&common.folder("mesh-pack"))?;
    let bytes = session.patch.pack(&session.params, session.stable.pressed_s as f32);
    let name = format!("{}-{}.patch", scene.name, machine.name);
    folder.write(&name, &bytes)?;
    let out = folder.publish()?;
    println!(
        "{}: {} nodes, {} springs, {} tets, {touched} triangles in reach, {} bytes; about {:.0} of {:.0} {} a tick on {} (estimate)",
        out.join(name).display(),
        model.nodes.len(),
        model.springs.len(),
        model.tets.len(),
        bytes.len(),
        cost.units,
        cost.budget,
        machine.unit,
        machine.name
    );
    Ok(())
}

/// A patch with its cost on a machine.
struct Packed {
    session: Session,
    cost: Cost,
    touched: usize,
}

impl Packed {
    fn of(scene: &Scene, machine: &Machine) -> Result<Self, Error> {
        let session = Session::prepare(scene)?;
        let model = session.patch.model();
        let touched = triangles_in_reach(&model, session.patch.site_m().into(), session.params.probe.radius_m);
        let cost = machine.cost(&model, touched, session.params.substeps);
        Ok(Self { session, cost, touched })
    }
}

/// The most nodes, up to the scene's own, that fit the machine. Cost grows with the nodes but for a few percent of scatter between meshes, so
/// the bisection is followed by a look at the next few counts.
fn largest(sized: impl Fn(usize) -> Result<Packed, Error>, most: usize) -> Result<Packed, Error> {
    let fits = |n: usize| sized(n).ok().filter(|p| p.cost.units <= p.cost.budget);
    if let Some(packed) = fits(most) {
        return Ok(packed);
    }
    let (mut low, mut high) = (LEAST_NODES, most);
    while high - low > 1 {
        let middle = low.midpoint(high);
        if fits(middle).is_some() { low = middle } else { high = middle }
    }
    (low..(low + LOOK_AHEAD).min(most)).rev().find_map(fits).map_or_else(|| sized(LEAST_NODES), Ok)
}
