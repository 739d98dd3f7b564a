//! The table as CSV and JSON.

use serde::Serialize;

use super::presses::{ASIDE_DEPTH_RADII, ASIDE_RADII, DEPTHS, Errors, Setting};
use super::{Awake, PROMISED_PCT, PROMISED_RADII, Row, Table};
use crate::error::Error;
use crate::output::OutputFolder;

/// `summary.json`.
#[derive(Clone, Debug, Serialize)]
pub struct Summary {
    /// Scene.
    pub scene: String,
    /// Processor.
    pub machine: String,
    /// Version and profile: times of another profile are not comparable.
    pub build: String,
    /// Depths of centred presses [m].
    pub depths_m: [f64; DEPTHS],
    /// Depth of presses beside the site [m].
    pub aside_depth_m: f64,
    /// Their distances from it [m].
    pub aside_distances_m: Vec<f64>,
    /// What rim springs are held to against dense S [%], from patches of so many probe radii on.
    pub promised_pct: f64,
    /// See there.
    pub promised_from_probe_radii: f64,
    /// Where they do not keep it; empty if they do.
    pub broken: Vec<String>,
    /// Patches that could not be cut, and why.
    pub left_out: Vec<String>,
    /// What the cycles are.
    pub cycles: &'static str,
    /// The table.
    pub rows: Vec<RowSummary>,
    /// Share of nodes that must be awake.
    pub awake_needed: Vec<NeededSummary>,
}

/// A row of the table; `null` where a force has no equilibrium or a column does not apply.
#[derive(Clone, Debug, Serialize)]
pub struct RowSummary {
    whole_nodes: usize,
    radius_m: Option<f64>,
    edge: String,
    nodes: usize,
    tets: usize,
    rim_nodes: usize,
    rim_edges: usize,
    force_over_e_m2: [Option<f64>; DEPTHS],
    against_dense_pct: Option<[Option<f64>; DEPTHS]>,
    aside_against_dense_pct: Option<Vec<Option<f64>>>,
    against_whole_pct: Option<[Option<f64>; DEPTHS]>,
    aside_against_whole_pct: Option<Vec<Option<f64>>>,
    against_elements_pct: [Option<f64>; DEPTHS],
    lowest_eigenvalue_m: Option<f64>,
    rim_flops: Option<usize>,
    rim_bytes: Option<usize>,
    tick_us: Option<f64>,
    tick_over_rim_springs: Option<f64>,
    rim_m4f_cycles: Option<f64>,
    tick_m4f_cycles: Option<f64>,
}

/// A share that must be awake.
#[derive(Clone, Debug, Serialize)]
pub struct NeededSummary {
    whole_nodes: usize,
    aside_m: f64,
    tolerance_pct: f64,
    frozen_share: Option<f64>,
    rim_springs_share: Option<f64>,
}

impl RowSummary {
    fn of(row: &Row) -> Self {
        let centred = |e: &Option<Errors>| e.as_ref().map(|e| e.centred_pct);
        let aside = |e: &Option<Errors>| e.as_ref().map(|e| e.aside_pct.to_vec());
        let cost = row.cost.as_ref();
        Self {
            whole_nodes: row.whole_nodes,
            radius_m: row.radius_m,
            edge: row.kind.name(),
            nodes: row.size.nodes,
            tets: row.size.tets,
            rim_nodes: row.size.rim_nodes,
            rim_edges: row.size.rim_edges,
            force_over_e_m2: row.presses.centred,
            against_dense_pct: centred(&row.against_dense),
            aside_against_dense_pct: aside(&row.against_dense),
            against_whole_pct: centred(&row.against_whole),
            aside_against_whole_pct: aside(&row.against_whole),
            against_elements_pct: row.against_elements_pct,
            lowest_eigenvalue_m: row.lowest_m,
            rim_flops: cost.map(|c| c.rim_flops),
            rim_bytes: cost.map(|c| c.rim_bytes),
            tick_us: cost.and_then(|c| c.tick_us),
            tick_over_rim_springs: cost.and_then(|c| c.over_rim_springs),
            rim_m4f_cycles: cost.map(|c| c.rim_m4f_cycles),
            tick_m4f_cycles: cost.map(|c| c.tick_m4f_cycles),
        }
    }
}

impl Summary {
    /// Of everything.
    #[must_use]
    pub fn of(scene: &str, setting: &Setting, table: &Table, awake: &Awake) -> Self {
        let radius_m = setting.radius_m();
        Self {
            scene: scene.into(),
            machine: crate::summary::machine(),
            build: crate::chart::build(),
            depths_m: setting.depths_m(),
            aside_depth_m: ASIDE_DEPTH_RADII * radius_m,
            aside_distances_m: ASIDE_RADII.iter().map(|a| a * radius_m).collect(),
            promised_pct: PROMISED_PCT,
            promised_from_probe_radii: PROMISED_RADII,
            broken: table.broken(radius_m),
            left_out: table.left_out.clone(),
            cycles: "Cortex-M4F, estimated: springs from instruction counts in the emulator, modes, low rank and dense from their operations; not hardware cycles",
            rows: table.rows.iter().map(RowSummary::of).collect(),
            awake_needed: awake
                .needed
                .iter()
                .map(|n| NeededSummary {
                    whole_nodes: n.whole_nodes,
                    aside_m: n.aside_m,
                    tolerance_pct: n.tolerance_pct,
                    frozen_share: n.frozen_share,
                    rim_springs_share: n.rim_springs_share,
                })
                .collect(),
        }
    }
}

/// Writes `summary.json`, `far_field.csv`, `awake.csv` and `stress_rule.csv`.
///
/// # Errors
/// The folder cannot be written.
pub fn write(folder: &OutputFolder, summary: &Summary, awake: &Awake) -> Result<(), Error> {
    folder.write_json("summary.json", summary)?;
    folder.write("far_field.csv", rows_csv(summary).as_bytes())?;
    folder.write("awake.csv", awake_csv(awake).as_bytes())?;
    folder.write("stress_rule.csv", stress_csv(awake).as_bytes())
}

fn cell(value: Option<f64>, digits: usize) -> String {
    value.map_or(String::new(), |v| format!("{v:.digits$}"))
}

fn rows_csv(summary: &Summary) -> String {
    let mm = |m: &f64| format!("{}", (m * 1e6).round() / 1e3);
    let of = |what: &str| {
        let centred = summary.depths_m.iter().map(|d| format!("force_{}mm_{what}_pct", mm(d)));
        let aside = summary.aside_distances_m.iter().map(|a| format!("worst_{}mm_aside_{what}_pct", mm(a)));
        centred.chain(aside).collect::<Vec<_>>().join(",")
    };
    let forces = summary.depths_m.iter().map(|d| format!("force_{}mm_over_e_m2", mm(d))).collect::<Vec<_>>().join(",");
    let elements = summary.depths_m.iter().map(|d| format!("force_{}mm_vs_elements_pct", mm(d))).collect::<Vec<_>>().join(",");
    let mut text = format!(
        "whole_nodes,radius_m,edge,nodes,tets,rim_nodes,rim_edges,{forces},{},{},{elements},lowest_eigenvalue_m,rim_flops,rim_bytes,tick_us,tick_over_rim_springs,rim_m4f_cycles_estimate,tick_m4f_cycles_estimate\n",
        of("vs_dense"),
        of("vs_whole")
    );
    for row in &summary.rows {
        let mut cells = vec![
            row.whole_nodes.to_string(),
            cell(row.radius_m, 4),
            row.edge.clone(),
            row.nodes.to_string(),
            row.tets.to_string(),
            row.rim_nodes.to_string(),
            row.rim_edges.to_string(),
        ];
        cells.extend(row.force_over_e_m2.map(|f| f.map_or(String::new(), |f| format!("{f:.6e}"))));
        for (centred, aside) in
            [(row.against_dense_pct, &row.aside_against_dense_pct), (row.against_whole_pct, &row.aside_against_whole_pct)]
        {
            cells.extend(centred.unwrap_or_default().map(|e| cell(e, 3)));
            let none = vec![None; summary.aside_distances_m.len()];
            cells.extend(aside.as_ref().unwrap_or(&none).iter().map(|e| cell(*e, 3)));
        }
        cells.extend(row.against_elements_pct.map(|e| cell(e, 3)));
        cells.push(row.lowest_eigenvalue_m.map_or(String::new(), |l| format!("{l:.3e}")));
        cells.extend([row.rim_flops, row.rim_bytes].map(|n| n.map_or(String::new(), |n| n.to_string())));
        cells.extend([cell(row.tick_us, 2), cell(row.tick_over_rim_springs, 3)]);
        cells.extend([cell(row.rim_m4f_cycles, 0), cell(row.tick_m4f_cycles, 0)]);
        text.push_str(&cells.join(","));
        text.push('\n');
    }
    text
}

fn awake_csv(awake: &Awake) -> String {
    let mut text =
        String::from("whole_nodes,aside_m,edge,radius_m,awake_share,error_quarter_radius_deep_pct,error_half_radius_deep_pct\n");
    for r in &awake.regions {
        let edge = if r.rim_springs { "rim-springs" } else { "frozen" };
        let [quarter, half] = r.error_pct.map(|e| cell(e, 3));
        text.push_str(&format!("{},{},{edge},{:.5},{:.4},{quarter},{half}\n", r.whole_nodes, r.aside_m, r.radius_m, r.share));
    }
    text
}

fn stress_csv(awake: &Awake) -> String {
    let mut text = String::from("whole_nodes,aside_m,pressure,contact_pa,least_stress_pa,radius_m,awake_share,error_pct\n");
    for s in &awake.stress {
        let pressure = format!("{:?}", s.pressure);
        text.push_str(&format!(
            "{},{},{pressure},{:.2},{:.3},{:.5},{:.4},{}\n",
            s.whole_nodes,
            s.aside_m,
            s.contact_pa,
            s.least_stress_pa,
            s.radius_m,
            s.share,
            cell(s.error_pct, 3)
        ));
    }
    text
}
