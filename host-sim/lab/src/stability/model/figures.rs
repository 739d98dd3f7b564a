//! The two pictures of the model matrix: verdicts and margins.

use super::built_method::Row;
use super::margin::{Axis, Margin};
use super::matrix::Matrix;
use super::promise::LEAST_J;
use super::verdict::{Figures, Verdict};
use palpate_charts::{Figure, Form, Heat, HeatCell, HeatGroup, HeatRow, Tone};

/// Multiple of the standard value below which a margin is drawn as thin (1).
const THIN: f64 = 1.25;

/// The pictures `stability_model` and `stability_margins`.
pub fn figures(matrix: &Matrix) -> Vec<Figure> {
    let margins = (!matrix.margins.is_empty()).then(|| margins(matrix));
    std::iter::once(verdicts(matrix)).chain(margins).collect()
}

fn look(verdict: Verdict) -> HeatCell {
    let (tone, sign) = match verdict {
        Verdict::Pass => (Tone::Good, "·"),
        Verdict::Held => (Tone::Calm, "H"),
        Verdict::NonMonotone => (Tone::Slight, "N"),
        Verdict::Deformed => (Tone::Fault, "D"),
        Verdict::Restless => (Tone::Serious, "R"),
        Verdict::Pierced => (Tone::Severe, "P"),
        Verdict::Inverted => (Tone::Failure, "I"),
        Verdict::Diverged => (Tone::Lost, "X"),
    };
    tone.cell(sign)
}

fn meaning(verdict: Verdict) -> &'static str {
    match verdict {
        Verdict::Pass => "passes",
        Verdict::Held => "held at depth limit",
        Verdict::NonMonotone => "force falls",
        Verdict::Deformed => "does not return",
        Verdict::Restless => "moves on",
        Verdict::Pierced => "pierced",
        Verdict::Inverted => "tet inside out",
        Verdict::Diverged => "diverges",
    }
}

/// Look of a cell; a press that passes with a tet below the promised volume ratio has a look of its
/// own.
fn cell_look(figures: &Figures) -> HeatCell {
    if figures.verdict == Verdict::Pass && figures.lowest_j <= LEAST_J { squeezed() } else { look(figures.verdict) }
}

fn squeezed() -> HeatCell {
    Tone::Thin.cell("s")
}

fn empty() -> HeatCell {
    Tone::Empty.cell("")
}

/// Rows that were run, with a gap before the other configurations of the product and before the
/// other methods.
fn rows(matrix: &Matrix, cells: impl Fn(&Row) -> Vec<HeatCell>) -> Vec<HeatRow> {
    let run = |row: &&Row| matrix.cells.iter().any(|c| c.row == **row);
    let group = |row: &Row| (row.is_promised(), row.method.is_ours());
    let mut last = None;
    let with_gap = |row: &Row| {
        let apart = last.replace(group(row)).is_some_and(|before| before != group(row));
        HeatRow { name: format!("{}, {}", row.name(), steps(matrix, row)), apart, cells: cells(row) }
    };
    matrix.scope.rows.iter().filter(run).map(with_gap).collect()
}

/// Range of the substeps of a row, such as "1 step" or "1–8 steps".
fn steps(matrix: &Matrix, row: &Row) -> String {
    let substeps = matrix.cells.iter().filter(|c| c.row == *row).map(|c| c.substeps);
    let (least, most) = substeps.fold((u16::MAX, 0), |(least, most), n| (least.min(n), most.max(n)));
    match (least, most) {
        (1, 1) => "1 step".into(),
        (least, most) if least == most => format!("{most} steps"),
        (least, most) => format!("{least}–{most} steps"),
    }
}

fn verdicts(matrix: &Matrix) -> Figure {
    let scope = &matrix.scope;
    let kpa = |pa: &f64| (pa * 1e-3).to_string();
    // there is room only for the first and the last of many labels
    let ends = [0, scope.moduli_pa.len().saturating_sub(1)];
    let foot = |(n, pa): (usize, &f64)| if ends.contains(&n) { kpa(pa) } else { String::new() };
    let group = |case: &super::LoadCase| HeatGroup {
        label: case.label.map(String::from),
        feet: scope.moduli_pa.iter().enumerate().map(foot).collect(),
    };
    let groups: Vec<HeatGroup> = scope.cases.iter().map(group).collect();
    let of_row = |row: &Row| {
        let places = scope.cases.iter().flat_map(|case| scope.moduli_pa.iter().map(move |pa| (case.name, *pa)));
        let cell = |(case, pa)| {
            let found = matrix.cells.iter().find(|c| c.row == *row && c.case.name == case && c.youngs_modulus_pa == pa);
            found.map_or_else(empty, |c| cell_look(&c.figures))
        };
        places.map(cell).collect()
    };
    let rows = rows(matrix, of_row);
    let mut key: Vec<(HeatCell, String)> = Verdict::ALL.map(|v| (look(v), meaning(v).to_owned())).into();
    key.insert(1, (squeezed(), "a tet below 1/5".to_owned()));
    key.push((empty(), "refused, or has no such term".to_owned()));
    let moduli: Vec<String> = scope.moduli_pa.iter().map(kpa).collect();
    let below = format!(
        "Block of {} nodes, 40 mm high, hemisphere R = 8 mm; presses at 40 mm/s; 8 mm if not said; from left {} kPa",
        scope.nodes,
        moduli.join(", "),
    );
    Figure {
        name: "stability_model".into(),
        title: "Where the methods fail".into(),
        below,
        form: Form::Heat(Heat { groups, rows, key, foot: "stiffness [kPa]".into() }),
    }
}

fn margins(matrix: &Matrix) -> Figure {
    let moduli = &matrix.scope.margins_at_pa;
    let label = |axis: Axis| match axis {
        Axis::Tick => ["longest tick [ms]", "press and tap"],
        Axis::Depth => ["deepest press [mm]", "at 40 mm/s"],
        Axis::Speed => ["fastest tap [m/s]", "to 8 mm"],
        Axis::Stiffness => ["stiffest tissue [kPa]", "press and tap"],
    };
    let groups: Vec<HeatGroup> = Axis::ALL
        .iter()
        .map(|axis| HeatGroup {
            label: label(*axis).map(String::from),
            feet: moduli.iter().map(|pa| format!("from {} kPa", pa * 1e-3)).collect(),
        })
        .collect();
    let of_row = |row: &Row| {
        let places = Axis::ALL.iter().flat_map(|axis| moduli.iter().map(move |pa| (*axis, *pa)));
        let cell = |(axis, pa)| {
            let found = matrix.margins.iter().find(|c| c.row == *row && c.axis == axis && c.youngs_modulus_pa == pa);
            found.map_or_else(empty, |c| margin_look(axis, pa, &c.margin))
        };
        places.map(cell).collect()
    };
    let rows = rows(matrix, of_row);
    let key = [
        (Tone::Good, "stands 1.25 times the standard and more"),
        (Tone::Slight, "stands the standard"),
        (Tone::Failure, "does not stand it"),
        (Tone::Empty, "the letter: what comes beyond (as in the verdicts)"),
    ];
    let key = key.map(|(tone, meaning)| (tone.cell(""), meaning.to_owned())).into();
    let below = "One quantity grows, the rest stays at the standard: 1 ms, 8 mm, 0.5 m/s, the stiffness below each column";
    Figure {
        name: "stability_margins".into(),
        title: "How much more the methods stand before they fail".into(),
        below: below.into(),
        form: Form::Heat(Heat { groups, rows, key, foot: String::new() }),
    }
}

fn margin_look(axis: Axis, youngs_modulus_pa: f64, margin: &Margin) -> HeatCell {
    let letter = margin.beyond.map_or(String::new(), |v| format!("  {}", look(v).sign));
    let Some(value) = margin.passes else { return Tone::Failure.cell(format!("–{letter}")) };
    let over = value / axis.standard(youngs_modulus_pa);
    let tone = match over {
        over if over >= THIN => Tone::Good,
        // the search may end below the standard by its resolution
        over if over >= 0.95 => Tone::Slight,
        _ => Tone::Failure,
    };
    tone.cell(format!("{}{letter}", axis.said(value, margin.beyond.is_none())))
}
