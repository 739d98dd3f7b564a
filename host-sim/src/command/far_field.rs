//! The command `palpate far-field`.

use clap::Args;

use super::Common;
use super::progress::Steps;
use super::verdict::Verdict;
use crate::error::Error;
use crate::provenance;
use palpate_lab::far_field::sliding::{Sliding, report};
use palpate_lab::far_field::table::{Awake, Errors, Kind, Row, Scope, Setting, Summary, Table, awake, draw, table, write};
use palpate_tissue::Error as TissueError;
use palpate_tissue::output::OutputFolder;

/// Name of the product's treatment of the edge.
const OURS: &str = "rim-springs";

#[derive(Args, Clone, Debug)]
pub(super) struct FarFieldArgs {
    #[command(flatten)]
    common: Common,
    /// Use one mesh and fewer places: 8 s of processor time, with --sliding 20 s.
    #[arg(long)]
    quick: bool,
    /// Move the contact: slide 30 mm over the default block, on patches as long as the stroke and
    /// with other methods.
    #[arg(long)]
    sliding: bool,
    /// Print every treatment of the edge; otherwise only rim springs, the product's own, are
    /// printed.
    #[arg(long)]
    all: bool,
}

impl FarFieldArgs {
    pub(super) fn run(&self) -> Result<(), Error> {
        if self.sliding {
            return self.slide();
        }
        let scene = self.common.load()?;
        scene.refuse_stiffening()?;
        let scope = if self.quick { Scope::quick() } else { Scope::full() };
        let setting = Setting::of(&scene, scope.directions)?;
        let folder = self.common.open("far-field", &scene)?;
        let steps = Steps::new("far field", 0);
        let table = table(&scene, &scope, &mut |done, total, what| steps.show(done, total, what))?;
        let awake = awake(&scene, &scope, &mut |done, total, what| steps.show(done, total, what))?;
        steps.finish();
        let summary = Summary::of(&scene.name, &setting, &table, &awake);
        write(&folder, &summary, &awake)?;
        draw(&folder, &scene.name, &setting, &table, &awake)?;
        let check = if summary.broken.is_empty() { Ok(()) } else { Err(TissueError::Check(summary.broken.join("; "))) };
        let verdict = Verdict::of(check, || {
            format!(
                "with rim springs in place of the tissue outside, every patch of {} probe radii or more is off by {:.2} % at most ({} % allowed), and their stiffness is positive",
                summary.promised_from_probe_radii,
                table.worst_promised_pct(setting.radius_m()),
                summary.promised_pct
            )
        })?
        .first();
        print_table(&setting, &table, &summary, self.all);
        print_awake(&awake);
        let names = "summary.json, far_field.csv, awake.csv, stress_rule.csv, pictures as SVG and PNG";
        println!("\nwrote {}: {names}", folder.publish()?.display());
        verdict.last()
    }
}

impl FarFieldArgs {
    fn slide(&self) -> Result<(), Error> {
        if self.common.scene != "block" || !self.common.changes.is_empty() {
            let why =
                format!("--scene {}: sliding is measured on the default block: leave --scene and --set out", self.common.scene);
            return Err(TissueError::Usage(why).into());
        }
        let folder = OutputFolder::open(&self.common.folder("far-field"))?.made_by(provenance::of(None));
        let steps = Steps::new("sliding", 0);
        let sliding = report(&folder, self.quick, &mut |done, total, what| steps.show(done, total, what))?;
        steps.finish();
        folder.write_summary(&sliding)?;
        let verdict = Verdict::of(sliding.check(), || slid_in_words(&sliding))?.first();
        print_sliding(&sliding);
        let out = folder.publish()?;
        println!("\nwrote {}: summary.json, sliding.csv, sliding_stroke.csv, traces, pictures as SVG and PNG", out.display());
        verdict.last()
    }
}

fn slid_in_words(sliding: &Sliding) -> String {
    let speed = sliding.speed_mm_per_s;
    let worst_pct = sliding.methods.first().and_then(|ours| ours.at(speed)).map_or(f64::NAN, |at| at.worst_pct);
    format!(
        "a patch as long as the stroke is {:.1} % off at worst (at most {:.0} % allowed) while the probe slides at {speed:.0} mm/s",
        worst_pct.abs(),
        sliding.tolerance_pct
    )
}

fn print_sliding(sliding: &Sliding) {
    let (stroke, depth, speed) = (sliding.stroke_mm, sliding.depth_mm, sliding.speed_mm_per_s);
    println!(
        "probe slides {stroke:.0} mm forth and back, {depth:.0} mm deep, {speed:.0} mm/s; normal force against finite elements at rest"
    );
    println!(
        "{:<44} {:>5} {:>8} {:>7} {:>8} {:>9} {:>9} {:>8} {:>12}",
        "method", "nodes", "worst %", "mean %", "step mN", "region mN", "lateral %", "work mJ", "leaves mm/s"
    );
    for m in &sliding.methods {
        let Some(at) = m.at(speed) else {
            println!("{:<44} {:>5} ended in a fault", m.name, m.nodes);
            continue;
        };
        println!(
            "{:<44} {:>5} {:>+8.1} {:>+7.1} {:>8.1} {:>9.1} {:>+9.1} {:>+8.3} {:>12}",
            m.name,
            m.nodes,
            at.worst_pct,
            at.mean_pct,
            at.step_n * 1e3,
            at.region_step_n * 1e3,
            at.lateral_pct,
            at.work_mj,
            m.leaves_at_mm_per_s.map_or("> 500".into(), |v| format!("{v:.0}"))
        );
    }
    println!(
        "region: largest step of the force where the set of moving nodes changed; work: of the tissue on the probe, below zero is lost;"
    );
    println!("leaves: slowest speed at which the force is more than {:.0} % off", sliding.tolerance_pct);
}

fn pct(value: Option<f64>) -> String {
    value.map_or("-".into(), |v| if v.abs() < 9.95 { format!("{v:+.2}") } else { format!("{v:+.0}") })
}

/// Prints one line per row that fits a terminal; the CSV has every figure.
fn print_table(setting: &Setting, table: &Table, summary: &Summary, all: bool) {
    let mm = |m: f64| format!("{:.3}", m * 1e3).trim_end_matches('0').trim_end_matches('.').to_owned();
    let [_, _, half, full] = setting.depths_m().map(mm);
    let aside = mm(summary.aside_distances_m.iter().copied().fold(0.0, f64::max));
    println!(
        "force error in % of four loads: {half} and {full} mm deep at the centre; aside: {half} mm deep, {aside} mm off the centre, worst direction; shear: a glued disc"
    );
    println!(
        "the verdict is on the edge alone, against the exact stiffness of the outside, at the centre to {half} mm and aside; the other columns are for comparison"
    );
    println!("{:40} {:^27}  {:^27}", "", "against the exact outside", "against whole springs");
    let presses =
        [format!("{half} mm"), format!("{full} mm"), "aside".into(), "shear".into()].map(|p| format!("{p:>6}")).join(" ");
    println!(
        "{:>5} {:>5} {:<20} {:>5} {:>4} {presses:>27} {presses:>27} {:>6} {:>6} {:>6} {:>5}",
        "el.mm", "r mm", "edge", "nodes", "rim", "FE rms", "us", "x ours", "kcyc"
    );
    let shown = |row: &&Row| if all { row.kind != Kind::Elements } else { row.kind.name() == OURS };
    table.rows.iter().filter(shown).for_each(print_row);
    if !all {
        println!("--all prints every treatment of the edge");
    }
    for left_out in &table.left_out {
        println!("left out: {left_out}");
    }
    println!(
        "el.: element size under the probe; r: radius of the patch; rim: nodes at its edge; FE rms: % against finite elements at the centre, most of it due to the uncalibrated springs inside"
    );
    println!(
        "us: time of a tick on this machine; x ours: its cost over that of rim springs; kcyc: thousands of Cortex-M4F cycles per tick (estimate); {}; {}",
        summary.machine, summary.build
    );
}

fn print_row(row: &Row) {
    let errors = |e: &Option<Errors>| {
        let shown = |e: &Errors| [e.centred_pct[2], e.centred_pct[3], e.aside_pct[1], e.glued_pct[1]].map(pct);
        e.as_ref().map_or(String::new(), |e| shown(e).map(|c| format!("{c:>6}")).join(" "))
    };
    let number = |v: Option<f64>, digits: usize| v.map_or("-".into(), |v| format!("{v:.digits$}"));
    let rms = row.against_elements.and_then(|e| {
        let all: Option<Vec<f64>> = e.centred_pct.into_iter().collect();
        all.map(|all| (all.iter().map(|e| e * e).sum::<f64>() / all.len() as f64).sqrt())
    });
    let cost = row.cost.as_ref();
    let count = |n: usize| if n > 0 { n.to_string() } else { "-".into() };
    println!(
        "{:>5.1} {:>5.0} {:<20} {:>5} {:>4} {:>27} {:>27} {:>6} {:>6} {:>6} {:>5}",
        row.fine_m * 1e3,
        row.radius_m * 1e3,
        row.kind.name(),
        count(row.size.nodes),
        count(row.size.rim_nodes),
        errors(&row.against_dense),
        errors(&row.against_whole),
        number(rms, 1),
        number(cost.and_then(|c| c.tick_us), 1),
        number(cost.and_then(|c| c.over_rim_springs), 2),
        number(cost.map(|c| c.tick_m4f_cycles * 1e-3), 0),
    );
}

fn print_awake(awake: &Awake) {
    println!(
        "\nleast share of the nodes that has to be simulated for a force error within so many % (a smaller share is cheaper), pressed so many mm off the centre;"
    );
    println!(
        "the other nodes stand still, or rim springs replace them, fitted to the springs of the whole or, as ours are, to its finite elements (-: more than was tried)"
    );
    println!(
        "{:>5} {:>7} {:>8} {:>18} {:>12} {:>20}",
        "nodes", "mm off", "within %", "rest stands still", "rim springs", "fitted to elements"
    );
    let share = |s: Option<f64>| s.map_or("-".into(), |s| format!("{:.0} %", 100.0 * s));
    for n in &awake.needed {
        println!(
            "{:>5} {:>7.0} {:>8} {:>18} {:>12} {:>20}",
            n.whole_nodes,
            n.aside_m * 1e3,
            n.tolerance_pct,
            share(n.frozen_share),
            share(n.rim_springs_share),
            share(n.rim_springs_from_elements_share)
        );
    }
}
