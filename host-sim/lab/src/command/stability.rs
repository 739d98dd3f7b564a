//! The command `palpate stability`.

use std::ops::Range;

use serde::{Deserialize, Serialize};

use crate::stability::loop_matrix::{self, LoopSummary};
use crate::stability::model::{self, LEAST_J};
use palpate_sim::command::campaign::Campaign;
use palpate_sim::command::options::stability::{StabilityArgs, StabilityOptions};
use palpate_sim::command::progress::Progress;
use palpate_sim::command::verdict::Verdict;
use palpate_sim::error::Error;
use palpate_tissue::Error as TissueError;
use palpate_tissue::output::OutputFolder;

/// The campaign of methods and loops.
pub(super) struct Stability {
    options: StabilityOptions,
    /// Scope of the models; `None` with `--loop`.
    model: Option<model::Scope>,
    /// Scope of the loop; `None` with `--model`.
    of_loop: Option<loop_matrix::Scope>,
}

/// Counts over some cases.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(super) struct Counts {
    model: model::Part,
    #[serde(rename = "loop")]
    of_loop: loop_matrix::Part,
}

/// Contents of `summary.json`.
#[derive(Serialize)]
struct Summary {
    model: Option<model::Summary>,
    #[serde(rename = "loop")]
    of_loop: Option<LoopSummary>,
}

pub(super) fn run(args: &StabilityArgs) -> Result<(), Error> {
    Stability::start(args.options.clone(), &args.shards, &args.out)
}

impl Campaign for Stability {
    type Options = StabilityOptions;
    type Counts = Counts;
    const COMMAND: &'static str = "stability";

    fn load(options: StabilityOptions) -> Result<Self, Error> {
        let model = if options.quick { model::Scope::quick() } else { model::Scope::full() };
        let of_loop = if options.model { None } else { Some(loop_matrix::Scope::new(options.quick, options.full)?) };
        Ok(Self { model: (!options.only_loop).then_some(model), of_loop, options })
    }

    fn options(&self) -> &StabilityOptions {
        &self.options
    }

    fn cases(&self) -> u64 {
        (self.places() + self.of_loop.as_ref().map_or(0, loop_matrix::Scope::cases)) as u64
    }

    fn run(&self, cases: Range<u64>) -> Result<Counts, Error> {
        // cases are numbered with the methods first, then the loops
        let (first, end, places) = (cases.start as usize, cases.end as usize, self.places());
        let mut counts = Counts { model: model::Part::default(), of_loop: loop_matrix::Part::default() };
        if let Some(scope) = &self.model {
            let cases = first.min(places)..end.min(places);
            let progress = Progress::new(scope.steps(cases.clone()) as u64, "presses and margins");
            let part = model::run(scope, cases, &|| progress.inc(1));
            progress.finish();
            counts.model = part?;
        }
        if let Some(scope) = &self.of_loop {
            let cases = first.saturating_sub(places)..end.saturating_sub(places);
            let progress = Progress::new(scope.steps(cases.clone()) as u64, "loops");
            let part = loop_matrix::Part::measure(scope, cases, &|| progress.inc(1));
            progress.finish();
            counts.of_loop = part?;
        }
        Ok(counts)
    }

    fn add(counts: &mut Counts, next: Counts) {
        counts.model.cells.extend(next.model.cells);
        counts.model.margins.extend(next.model.margins);
        counts.of_loop.cells.extend(next.of_loop.cells);
        counts.of_loop.ceilings.extend(next.of_loop.ceilings);
    }

    fn report(&self, folder: OutputFolder, counts: Counts, all: bool) -> Result<(), Error> {
        let mut summary = Summary { model: None, of_loop: None };
        let mut pressed = None;
        if let Some(scope) = self.model.clone() {
            let matrix = model::Matrix { scope, cells: counts.model.cells, margins: counts.model.margins };
            let model = model::Summary::of(&matrix);
            model::write(&folder, &matrix)?;
            model::draw(&folder, &matrix)?;
            summary.model = Some(model);
            pressed = Some(matrix);
        }
        if self.of_loop.is_some() {
            let of_loop = LoopSummary::of(counts.of_loop);
            loop_matrix::write(&folder, &of_loop)?;
            loop_matrix::draw(&folder, &of_loop)?;
            summary.of_loop = Some(of_loop);
        }
        folder.write_summary(&summary)?;
        let verdict = Verdict::of(summary.judge(), || summary.in_words())?.first();
        if let (Some(matrix), Some(model)) = (&pressed, &summary.model) {
            print_model(matrix, model, all);
        }
        if let Some(of_loop) = &summary.of_loop {
            loop_matrix::print(of_loop, all);
        }
        if !all {
            println!("\n--all prints the methods and controllers that it is compared with");
        }
        println!("wrote {}: summary.json, tables as CSV, pictures as SVG and PNG", folder.publish()?.display());
        verdict.last()
    }
}

impl Summary {
    fn judge(&self) -> Result<(), Error> {
        if let Some(model) = &self.model
            && let [first, ..] = model.broken.as_slice()
        {
            let (broken, cells) = (model.broken.len(), model.product.cells);
            return Err(TissueError::Check(format!(
                "{broken} of {cells} promised cells of the product do not hold, the first: {first}"
            ))
            .into());
        }
        self.of_loop.as_ref().map_or(Ok(()), |of_loop| Ok(of_loop.check()?))
    }

    fn in_words(&self) -> String {
        let model = self.model.as_ref().map(|model| {
            format!(
                "all {} presses that our patches promise to survive are survived; the tet squeezed most keeps {:.3} of its volume (more than {LEAST_J} promised)",
                model.product.cells, model.product.lowest_j
            )
        });
        let of_loop = self
            .of_loop
            .as_ref()
            .map(|_| "our loop holds a wall of 400 N/m in each of seven hands, neither shaking nor giving energy".to_owned());
        [model, of_loop].into_iter().flatten().collect::<Vec<_>>().join("; ")
    }
}

impl Stability {
    fn places(&self) -> usize {
        self.model.as_ref().map_or(0, model::Scope::places)
    }
}

/// Prints the rows of the product, or of every method.
fn print_model(matrix: &model::Matrix, summary: &model::Summary, all: bool) {
    let moduli: Vec<String> = matrix.scope.moduli_pa.iter().map(|pa| (pa * 1e-3).to_string()).collect();
    println!(
        "{}; each row in {} presses and taps: how many ended in which way (good: pass, and held, where our guard stopped the tip)",
        summary.scene,
        matrix.scope.moduli_pa.len() * matrix.scope.cases.len()
    );
    println!("{:<28} {:<22} ended in", "method", format!("substeps {} kPa", moduli.join("/")));
    let ours: Vec<String> = matrix.scope.rows.iter().filter(|row| row.is_promised()).map(model::Row::name).collect();
    for row in summary.rows.iter().filter(|row| all || ours.contains(&row.row)) {
        let substeps: Vec<String> = row.substeps.iter().map(u16::to_string).collect();
        let verdicts: Vec<String> = row.verdicts.iter().map(|(v, n)| format!("{n} {}", v.name())).collect();
        println!("{:<28} {:<22} {}", row.row, substeps.join("/"), verdicts.join(", "));
    }
    println!(
        "\nmargins: a press to 8 mm and a tap of 0.5 m/s pass at a tick of 1 ms; below, how far one of these numbers can go before the method fails, and in which way (≥: it did not fail)"
    );
    println!(
        "{:<28} {:>5} {:>18} {:>18} {:>18} {:>18}",
        "passes up to", "kPa", "tick [ms]", "depth [mm]", "tap [m/s]", "E [kPa]"
    );
    for cells in matrix.margins.chunks(model::Axis::ALL.len()) {
        let Some(first) = cells.first().filter(|cell| all || cell.row.is_promised()) else { continue };
        print!("{:<28} {:>5}", first.row.name(), first.youngs_modulus_pa * 1e-3);
        for cell in cells {
            print!(" {:>18}", margin_words(cell));
        }
        println!();
    }
    let worst = summary.product;
    println!(
        "\nours, at worst in the {} presses that it promises to survive: J (volume of a tet over that at rest, 0 is flat) {:.3} in a tick and {:.3} in a hold; a dent of {:.4} mm is left; on the way down the force falls by {:.2} %, or {:.0} % where the pose jitters",
        worst.cells, worst.lowest_j, worst.held_j, worst.residual_mm, worst.drop_pct, worst.jitter_drop_pct
    );
    for line in &summary.broken {
        println!("  does not hold: {line}");
    }
}

fn margin_words(cell: &model::MarginCell) -> String {
    let beyond = cell.margin.beyond.map_or("", model::Verdict::name);
    match cell.margin.passes {
        None => format!("- {beyond}"),
        Some(v) => format!("{} {beyond}", cell.axis.said(v, cell.margin.beyond.is_none())),
    }
}
