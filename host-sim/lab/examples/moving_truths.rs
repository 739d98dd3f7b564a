//! Recomputes the stored references for moving probes and writes their tables.
//!
//! Run `cargo run --release --example moving_truths -- FOLDER [NAME...]`; without
//! names it recomputes all of them.

use std::path::PathBuf;
use std::time::Instant;

use palpate_lab::dynamic::truths::Computed;
use palpate_tissue::moving::truth::{TRUTHS, Truth};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut arguments = std::env::args().skip(1);
    let folder: PathBuf = arguments.next().ok_or("give the folder to write to, and names of truths")?.into();
    std::fs::create_dir_all(&folder)?;
    let names: Vec<String> = arguments.collect();
    let mut wanted = names.iter().map(|name| Truth::named(name)).collect::<Result<Vec<_>, _>>()?;
    if wanted.is_empty() {
        wanted = TRUTHS.to_vec();
    }
    for truth in wanted {
        let began = Instant::now();
        let settings = truth.settings();
        let history = truth.compute(&settings, |_| {})?;
        let text = truth.table(&history).to_csv(&truth.header(&settings, &history));
        std::fs::write(folder.join(format!("{}.csv", truth.name)), text)?;
        let [peak_mm2, end_mm2] = [history.peak_over_e_m2(), truth.table(&history).force_over_e_m2(f64::MAX)[2]].map(|f| f * 1e6);
        println!(
            "{}: {} nodes, {} iterations, peak {peak_mm2:.2} mm^2, end {end_mm2:.2} mm^2, {:.0} s",
            truth.name,
            history.nodes,
            history.iterations,
            began.elapsed().as_secs_f64()
        );
    }
    Ok(())
}
