//! The command `palpate pack`.

mod remedy;

use super::options::pack::{BoardArg, PackArgs};
use super::progress::told;
use super::verdict::Verdict;
use super::{Common, boards};
use crate::error::Error;
use palpate_fit::scene_fit::judged_again;
use palpate_tissue::Error as TissueError;
use palpate_tissue::budget::{Cost, CostModel, triangles_in_reach};
use palpate_tissue::fit_record::{FitRecord, checksum};
use palpate_tissue::output::OutputFolder;
use palpate_tissue::scene::Scene;
use palpate_tissue::session::Session;
use palpate_tissue::session::standing::Standing;
use palpate_tissue::tissue::DEFAULT_NODES;

/// Smallest number of nodes that the block generator can mesh.
const LEAST_NODES: usize = 30;
/// Numbers of nodes that are tried beyond the result of the bisection.
const LOOK_AHEAD: usize = 4;

impl PackArgs {
    pub(super) fn run(&self) -> Result<(), Error> {
        pack(&self.common, &self.board, self.nodes)
    }
}

fn pack(common: &Common, board: &BoardArg, nodes: Option<usize>) -> Result<(), Error> {
    let (machine, ceiling_n_per_m) = (board.machine()?, board.ceiling_n_per_m()?);
    let scene = common.load()?;
    if machine.is_board() {
        scene.refuse_what_boards_lack(machine.name)?;
    }
    scene.refuse_what_no_file_has()?;
    if nodes.is_some() && scene.tissue.block_m.is_none() {
        return Err(TissueError::Usage(format!(
            "--nodes is for a block; scene {} has a shape of its own: leave it out",
            scene.name
        ))
        .into());
    }
    let packed = |scene: &Scene| {
        let sized = |n: usize| {
            let mut scene = scene.clone();
            scene.tissue.nodes = Some(n);
            Packed::of(&scene, machine)
        };
        match (nodes, scene.tissue.block_m) {
            (Some(n), _) => sized(n),
            (None, Some(_)) => match scene.tissue.nodes {
                Some(n) => largest(sized, n),
                // a block may need more nodes than the default
                None => largest(sized, DEFAULT_NODES).or_else(|_| Packed::of(scene, machine)),
            },
            (None, None) => Packed::of(scene, machine),
        }
    };
    let Packed { session, cost, touched } = packed(&scene)?;
    let model = session.patch.model();
    if machine.is_board() {
        boards::refuse_points(&model, machine.name)?;
    }
    if cost.units > cost.budget {
        return Err(TissueError::TooSlow(format!(
            "{} nodes take about {:.0} {} a tick, {:.0} fit on {}: take fewer nodes or a faster board",
            model.nodes.len(),
            cost.units,
            machine.unit,
            cost.budget,
            machine.name
        ))
        .into());
    }
    let bytes = in_file(&session);
    let name = format!("{}-{}.patch", scene.name, machine.name);
    if machine.is_board() {
        let packs = |scene: &Scene| {
            scene.check().is_ok()
                && packed(scene).is_ok_and(|packed| {
                    packed.cost.units <= packed.cost.budget
                        && boards::contact_refusal(&in_file(&packed.session), ceiling_n_per_m).is_none()
                })
        };
        let refusal = boards::contact_refusal(&bytes, ceiling_n_per_m);
        boards::refuse_contact(&name, refusal.map(|refusal| remedy::tried(refusal, &scene, &packs)))?;
    }
    let folder = OutputFolder::add_to(&common.folder("pack"))?;
    folder.write(&name, &bytes)?;
    let mut standing = Standing::of(&scene, &session);
    if let (Standing::Calibrated { record, .. }, Some(patch_crc32)) = (&mut standing, checksum(&bytes)) {
        let judged = told("judging the patch", || judged_again(&scene, &session, record))?;
        *record = FitRecord { patch_crc32, nodes: model.nodes.len(), judged, ..record.clone() };
        record.write(&folder, &name)?;
    }
    let out = folder.publish()?;
    let file = out.join(name);
    let verdict = Verdict::ok(format!(
        "{} nodes for {}: a tick takes {:.0} % of what it may (estimate); {}",
        model.nodes.len(),
        machine.name,
        100.0 * cost.units / cost.budget,
        standing.short()
    ))
    .about(&scene)
    .first();
    println!(
        "{}: {} nodes, {} springs, {} tets, {touched} triangles in reach of the site, {} bytes",
        file.display(),
        model.nodes.len(),
        model.springs.len(),
        model.tets.len(),
        bytes.len()
    );
    println!("about {:.0} of at most {:.0} {} per tick on {} (estimate)", cost.units, cost.budget, machine.unit, machine.name);
    if let Some(bound) = boards::bound(&bytes, machine) {
        println!("{bound}");
    }
    println!("model: {}", standing.sentence(&scene));
    println!("{}", boards::runs_on(machine));
    if machine.name != "desktop" && !matches!(standing, Standing::Calibrated { .. }) {
        println!("palpate fit --board {} with the same scene makes a calibrated patch that fits this board", machine.name);
    }
    verdict.last()
}

fn in_file(session: &Session) -> Vec<u8> {
    session.patch.pack(&session.params, session.stable.pressed_s as f32)
}

/// A patch with its cost on a machine.
struct Packed {
    session: Session,
    cost: Cost,
    touched: usize,
}

impl Packed {
    fn of(scene: &Scene, machine: &CostModel) -> Result<Self, Error> {
        let session = told("meshing the tissue", || Session::prepare_on(machine, scene))?;
        // only on request, since with shorter substeps fewer nodes fit a board
        let session = match scene.solver.moving_error_pct {
            Some(_) => session.for_motion(machine, scene)?,
            None => session,
        };
        let model = session.patch.model();
        let touched = triangles_in_reach(&model, session.patch.site_m().into(), session.params.probe.reach_m());
        let cost = machine.cost_with(&model, &session.params, touched, session.params.substeps);
        Ok(Self { session, cost, touched })
    }
}

/// Finds the largest number of nodes, up to the scene's own, that fits the machine. The cost rises
/// with the number of nodes except for a scatter of a few percent between meshes, so the bisection
/// is followed by a try of the next few numbers.
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
