//! `palpate stability`.

use std::path::PathBuf;

use clap::Args;
use serde::Serialize;

use super::progress::Progress;
use super::stability_loop::run_loop;
use crate::error::Error;
use palpate_lab::stability::loop_matrix::LoopSummary;
use palpate_lab::stability::model;
use palpate_tissue::Error as TissueError;
use palpate_tissue::output::OutputFolder;

#[derive(Args, Clone, Debug)]
pub(super) struct StabilityArgs {
    /// The methods alone, without a device in the loop.
    #[arg(long, conflicts_with = "only_loop")]
    model: bool,
    /// The loop alone, without the methods.
    #[arg(long = "loop")]
    only_loop: bool,
    /// A smaller mesh, two stiffnesses, five ways to press, one device: under a minute.
    #[arg(long)]
    quick: bool,
    /// The loop on every shipped device too, at its own delay.
    #[arg(long, conflicts_with_all = ["quick", "model"])]
    full: bool,
    /// Output folder, made if it is not there; replaces an earlier result in it when the run is
    /// done.
    #[arg(long, value_name = "FOLDER", default_value = "out/stability")]
    out: PathBuf,
}

/// `summary.json`.
#[derive(Serialize)]
struct Summary {
    model: Option<model::Summary>,
    #[serde(rename = "loop")]
    of_loop: Option<LoopSummary>,
}

impl StabilityArgs {
    pub(super) fn run(&self) -> Result<(), Error> {
        let folder = OutputFolder::open(&self.out)?;
        let mut summary = Summary { model: None, of_loop: None };
        if !self.only_loop {
            summary.model = Some(self.methods(&folder)?);
        }
        if !self.model {
            summary.of_loop = Some(run_loop(&folder, self.quick, self.full)?);
        }
        folder.write_json("summary.json", &summary)?;
        println!("\nwrote {}: summary.json, tables as CSV, pictures as SVG and PNG", folder.publish()?.display());
        if let Some(model) = &summary.model
            && let [first, ..] = model.broken.as_slice()
        {
            let (broken, cells) = (model.broken.len(), model.product.cells);
            return Err(TissueError::Check(format!(
                "{broken} of {cells} promised cells of the product do not hold, the first: {first}"
            ))
            .into());
        }
        summary.of_loop.map_or(Ok(()), |of_loop| Ok(of_loop.check()?))
    }

    fn methods(&self, folder: &OutputFolder) -> Result<model::Summary, Error> {
        let scope = if self.quick { model::Scope::quick() } else { model::Scope::full() };
        let progress = Progress::new(scope.steps() as u64, "presses and margins");
        let matrix = model::run(&scope, &|| progress.inc(1));
        progress.finish();
        let matrix = matrix?;
        let summary = model::Summary::of(&matrix);
        model::write(folder, &matrix)?;
        model::draw(folder, &matrix)?;
        print_model(&matrix, &summary);
        Ok(summary)
    }
}

fn print_model(matrix: &model::Matrix, summary: &model::Summary) {
    let moduli: Vec<String> = matrix.scope.moduli_pa.iter().map(|pa| (pa * 1e-3).to_string()).collect();
    println!("{}; verdicts of {} cells a row", summary.scene, matrix.scope.moduli_pa.len() * matrix.scope.cases.len());
    println!("{:<28} {:<18} verdicts", "method", format!("steps {} kPa", moduli.join("/")));
    for row in &summary.rows {
        let substeps: Vec<String> = row.substeps.iter().map(u16::to_string).collect();
        let verdicts: Vec<String> = row.verdicts.iter().map(|(v, n)| format!("{n} {}", v.name())).collect();
        println!("{:<28} {:<18} {}", row.row, substeps.join("/"), verdicts.join(", "));
    }
    println!(
        "\n{:<28} {:>5} {:>18} {:>18} {:>18} {:>18}",
        "passes up to", "kPa", "tick [ms]", "depth [mm]", "tap [m/s]", "E [kPa]"
    );
    for cells in matrix.margins.chunks(model::Axis::ALL.len()) {
        let Some(first) = cells.first() else { continue };
        print!("{:<28} {:>5}", first.row.name(), first.youngs_modulus_pa * 1e-3);
        for cell in cells {
            print!(" {:>18}", margin_words(cell));
        }
        println!();
    }
    let worst = summary.product;
    println!(
        "\nproduct, {} promised cells: smallest J {:.3} in a tick, {:.3} in a hold; {:.4} mm left; force falls by {:.2} % at most, {:.0} % with jitter",
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
