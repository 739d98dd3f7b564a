//! The table as CSV and JSON.

use serde::Serialize;

use super::presses::{ASIDE_DEPTH_RADII, ASIDE_RADII, DEPTHS, Errors, Setting};
use super::{Awake, PROMISED_PCT, PROMISED_RADII, Row, Table};
use crate::error::Error;
use palpate_tissue::output::OutputFolder;

/// Contents of `summary.json`.
#[derive(Clone, Debug, Serialize)]
pub struct Summary {
    /// Name of the scene.
    pub scene: String,
    /// Processor on which ticks were timed; the file states it in its provenance.
    #[serde(skip)]
    pub machine: String,
    /// Version and build profile; times of different profiles are not comparable.
    #[serde(skip)]
    pub build: String,
    /// Depths of the centred presses [m].
    pub depths_m: [f64; DEPTHS],
    /// Depth of the presses beside the site [m].
    pub aside_depth_m: f64,
    /// Distances of these presses from the site [m].
    pub aside_distances_m: Vec<f64>,
    /// Largest error relative to dense S that is promised for rim springs [%].
    pub promised_pct: f64,
    /// Radius of the smallest patch to which that limit applies [probe radii].
    pub promised_from_probe_radii: f64,
    /// One sentence for each row in which rim springs exceed that limit or are not positive.
    pub broken: Vec<String>,
    /// One sentence for each patch that could not be cut, with the reason.
    pub left_out: Vec<String>,
    /// Origin of the cycle figures.
    pub cycles: &'static str,
    /// Rows of the table.
    pub rows: Vec<RowSummary>,
    /// Smallest shares of the nodes that must be awake.
    pub awake_needed: Vec<NeededSummary>,
}

/// A row of the table; `null` where a force has no equilibrium or a column does not apply.
#[derive(Clone, Debug, Serialize)]
pub struct RowSummary {
    fine_m: f64,
    radius_m: f64,
    edge: String,
    nodes: usize,
    tets: usize,
    rim_nodes: usize,
    rim_edges: usize,
    force_over_e_m2: [Option<f64>; DEPTHS],
    glued_press_over_e_m: Option<f64>,
    glued_shear_over_e_m: Option<f64>,
    against_dense: Option<Errors>,
    against_whole: Option<Errors>,
    against_elements: Option<Errors>,
    lowest_eigenvalue_m: Option<f64>,
    rim_flops: Option<usize>,
    rim_bytes: Option<usize>,
    tick_us: Option<f64>,
    tick_over_rim_springs: Option<f64>,
    rim_m4f_cycles: Option<f64>,
    tick_m4f_cycles: Option<f64>,
}

/// Smallest shares of the nodes that must be awake to keep a tolerance.
#[derive(Clone, Debug, Serialize)]
pub struct NeededSummary {
    whole_nodes: usize,
    aside_m: f64,
    tolerance_pct: f64,
    frozen_share: Option<f64>,
    rim_springs_share: Option<f64>,
    rim_springs_from_elements_share: Option<f64>,
}

impl RowSummary {
    fn of(row: &Row) -> Self {
        let cost = row.cost.as_ref();
        Self {
            fine_m: row.fine_m,
            radius_m: row.radius_m,
            edge: row.kind.name(),
            nodes: row.size.nodes,
            tets: row.size.tets,
            rim_nodes: row.size.rim_nodes,
            rim_edges: row.size.rim_edges,
            force_over_e_m2: row.presses.centred,
            glued_press_over_e_m: row.presses.glued_m[0],
            glued_shear_over_e_m: row.presses.glued_m[1],
            against_dense: row.against_dense,
            against_whole: row.against_whole,
            against_elements: row.against_elements,
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
    /// Collects the parts of the report.
    #[must_use]
    pub fn of(scene: &str, setting: &Setting, table: &Table, awake: &Awake) -> Self {
        let radius_m = setting.radius_m();
        Self {
            scene: scene.into(),
            machine: palpate_tissue::machine::processor(),
            build: palpate_tissue::machine::build(),
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
                    rim_springs_from_elements_share: n.rim_springs_from_elements_share,
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
    folder.write_summary(summary)?;
    folder.write("far_field.csv", rows_csv(summary).as_bytes())?;
    folder.write("awake.csv", awake_csv(awake).as_bytes())?;
    Ok(folder.write("stress_rule.csv", stress_csv(awake).as_bytes())?)
}

fn cell(value: Option<f64>, digits: usize) -> String {
    value.map_or(String::new(), |v| format!("{v:.digits$}"))
}

fn rows_csv(summary: &Summary) -> String {
    let mm = |m: &f64| format!("{}", (m * 1e6).round() / 1e3);
    let of = |what: &str| {
        let centred = summary.depths_m.iter().map(|d| format!("force_{}mm_{what}_pct", mm(d)));
        let aside = summary.aside_distances_m.iter().map(|a| format!("worst_{}mm_aside_{what}_pct", mm(a)));
        let glued = ["press", "shear"].map(|way| format!("glued_{way}_{what}_pct"));
        centred.chain(aside).chain(glued).collect::<Vec<_>>().join(",")
    };
    let forces = summary.depths_m.iter().map(|d| format!("force_{}mm_over_e_m2", mm(d))).collect::<Vec<_>>().join(",");
    let mut text = format!(
        "fine_m,radius_m,edge,nodes,tets,rim_nodes,rim_edges,{forces},glued_press_over_e_m,glued_shear_over_e_m,{},{},{},lowest_eigenvalue_m,rim_flops,rim_bytes,tick_us,tick_over_rim_springs,rim_m4f_cycles_estimate,tick_m4f_cycles_estimate\n",
        of("vs_dense"),
        of("vs_whole"),
        of("vs_elements")
    );
    let tiny = |v: Option<f64>| v.map_or(String::new(), |v| format!("{v:.6e}"));
    for row in &summary.rows {
        let mut cells = vec![format!("{:.5}", row.fine_m), format!("{:.5}", row.radius_m), row.edge.clone()];
        cells.extend([row.nodes, row.tets, row.rim_nodes, row.rim_edges].map(|n| n.to_string()));
        cells.extend(row.force_over_e_m2.map(tiny));
        cells.extend([row.glued_press_over_e_m, row.glued_shear_over_e_m].map(tiny));
        for errors in [row.against_dense, row.against_whole, row.against_elements] {
            let errors = errors.unwrap_or(Errors::NONE);
            cells.extend(errors.centred_pct.iter().chain(&errors.aside_pct).chain(&errors.glued_pct).map(|e| cell(*e, 3)));
        }
        cells.push(tiny(row.lowest_eigenvalue_m));
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
        let edge = r.held.name();
        let [quarter, half] = r.error_pct.map(|e| cell(e, 3));
        text.push_str(&format!("{},{:.5},{edge},{:.5},{:.4},{quarter},{half}\n", r.whole_nodes, r.aside_m, r.radius_m, r.share));
    }
    text
}

fn stress_csv(awake: &Awake) -> String {
    let mut text = String::from("whole_nodes,aside_m,pressure,contact_pa,least_stress_pa,radius_m,awake_share,error_pct\n");
    for s in &awake.stress {
        let pressure = format!("{:?}", s.pressure);
        text.push_str(&format!(
            "{},{:.5},{pressure},{:.2},{:.3},{:.5},{:.4},{}\n",
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
