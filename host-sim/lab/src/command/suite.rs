//! The command `palpate suite`.

use std::ops::Range;

use palpate_charts::{Figure, Form, Heat, HeatCell, HeatGroup, HeatRow, Tone};
use palpate_sim::command::options::suite::SuiteOptions;
use palpate_sim::command::progress::Progress;
use palpate_sim::error::Error;
use serde::{Deserialize, Serialize};

use crate::methods::Method;
use crate::study::{Findings, Study, Table};
use crate::suite::{FIRST_NODES, SCENES, SuiteRow, cheapest, run};

/// Numbers of nodes of the meshes.
const SIZES: [usize; 3] = [57, FIRST_NODES, 410];
/// Errors for which the cheapest method is named [%].
const WITHIN_PCT: [f64; 2] = [2.0, 5.0];
/// Longest tick of a method that counts as able to hold a scene [us].
const IN_US: f64 = 100.0;

/// Every method on every scene.
pub(super) struct Suite {
    /// Index of the scene, and nodes.
    cases: Vec<(usize, usize)>,
}

/// Rows of one scene and mesh.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(super) struct Rows {
    rows: Vec<SuiteRow>,
}

/// A line of the table: a scene, the errors of the law, the cheapest methods, and who alone is
/// within 5 % and 100 us.
#[derive(Serialize)]
struct Line {
    scene: &'static str,
    law_held_pct: Option<f64>,
    law_moving_pct: Option<f64>,
    within_2_pct: String,
    within_5_pct: String,
    only: &'static str,
}

impl Suite {
    pub(super) fn of(options: &SuiteOptions) -> Self {
        let sizes = if options.quick { &[FIRST_NODES][..] } else { &SIZES[..] };
        Self { cases: (0..SCENES.len()).flat_map(|scene| sizes.iter().map(move |nodes| (scene, *nodes))).collect() }
    }
}

impl Study for Suite {
    type Row = Rows;

    fn cases(&self) -> u64 {
        self.cases.len() as u64
    }

    fn run(&self, cases: Range<u64>) -> Result<Vec<(u64, Rows)>, Error> {
        let chosen = self.cases.iter().enumerate().skip(cases.start as usize).take((cases.end - cases.start) as usize);
        let steps = Progress::new(cases.end - cases.start, "suite");
        let mut rows = Vec::new();
        for (n, (scene, nodes)) in chosen {
            let scene = &SCENES[*scene];
            rows.push((n as u64, Rows { rows: run(scene, *nodes)? }));
            steps.one(&format!("{}, {nodes} nodes", scene.name));
        }
        steps.finish();
        Ok(rows)
    }

    fn findings(&self, parts: Vec<Rows>) -> Result<Findings, Error> {
        let rows: Vec<SuiteRow> = parts.into_iter().flat_map(|part| part.rows).collect();
        let name = |row: &SuiteRow| {
            let nodes = if row.nodes > 0 { format!(" {}", row.nodes) } else { String::new() };
            format!("{}{nodes} ({:.1} %, {:.2} us)", row.method, row.worst_pct().unwrap_or(f64::NAN), row.tick_us)
        };
        let line = |scene: &'static str| {
            let law = rows.iter().find(|row| row.scene == scene && row.is_law());
            let [within_2_pct, within_5_pct] =
                WITHIN_PCT.map(|pct| cheapest(&rows, scene, pct).map_or_else(|| "none".into(), name));
            let [law_held_pct, law_moving_pct] = [law.and_then(|law| law.held_pct), law.and_then(|law| law.moving_pct)];
            Line { scene, law_held_pct, law_moving_pct, within_2_pct, within_5_pct, only: only(&rows, scene) }
        };
        let lines: Vec<Line> = SCENES.iter().map(|scene| line(scene.name)).collect();
        let count = |who: &str| lines.iter().filter(|line| line.only == who).count();
        let (patches, laws) = (count(PATCH), count(LAW));
        let mut findings = Findings {
            headline: format!(
                "of {} scenes, a patch of ours is the only method within 5 % and {IN_US} us on {patches}, our law on {laws}, only the two on {}",
                lines.len(),
                count(BOTH)
            ),
            tables: vec![
                Table::of("suite", &lines)?
                    .about("what each scene needs at least: the cheapest method within 2 % and within 5 %, held and moving"),
                Table::of("rows", &rows)?.quiet(),
            ],
            figures: vec![figure(&rows)],
            ..Findings::default()
        };
        findings.fact("patch_alone", patches);
        findings.fact("law_alone", laws);
        Ok(findings)
    }
}

const PATCH: &str = "patch";
const LAW: &str = "law";
const BOTH: &str = "law and patch";

/// Names of those of our law and patches that alone hold a scene within 5 % and 100 us.
fn only(rows: &[SuiteRow], scene: &str) -> &'static str {
    let able = rows
        .iter()
        .filter(|row| row.scene == scene && row.tick_us <= IN_US && row.worst_pct().is_some_and(|pct| pct <= WITHIN_PCT[1]));
    let [mut law, mut patch, mut other] = [false; 3];
    for row in able {
        match (row.is_law(), row.is_patch()) {
            (true, _) => law = true,
            (_, true) => patch = true,
            _ => other = true,
        }
    }
    match (law, patch, other) {
        (_, _, true) => "others too",
        (true, true, _) => BOTH,
        (true, false, _) => LAW,
        (false, true, _) => PATCH,
        (false, false, _) => "none",
    }
}

/// The smallest error of every method on every scene among its ticks under 100 us.
fn figure(rows: &[SuiteRow]) -> Figure {
    let cell = |method: Method, scene: &str| -> HeatCell {
        let own = rows.iter().filter(|row| row.scene == scene && row.method == method.name() && row.tick_us <= IN_US);
        match own.filter_map(SuiteRow::worst_pct).reduce(f64::min) {
            None => Tone::Empty.cell("–"),
            Some(pct) => look(pct).cell(if pct < 10.0 { format!("{pct:.1}") } else { format!("{pct:.0}") }),
        }
    };
    let ours = [Method::Law, Method::Calibrated, Method::Palpate];
    let order = ours.into_iter().chain(Method::ALL.into_iter().filter(|method| !ours.contains(method)));
    let heat = Heat {
        groups: SCENES
            .iter()
            .map(|scene| HeatGroup { label: scene.label.map(String::from), feet: vec![String::new()] })
            .collect(),
        rows: order
            .enumerate()
            .map(|(n, method)| HeatRow {
                name: method.name().into(),
                apart: n == ours.len(),
                cells: SCENES.iter().map(|scene| cell(method, scene.name)).collect(),
            })
            .collect(),
        key: vec![
            (Tone::Good.cell(""), "within 2 %".into()),
            (Tone::Thin.cell(""), "within 5 %".into()),
            (Tone::Slight.cell(""), "within 15 %".into()),
            (Tone::Failure.cell(""), "more".into()),
            (Tone::Empty.cell("–"), "cannot hold the scene, or takes longer".into()),
        ],
        foot: String::new(),
    };
    Figure {
        name: "suite".into(),
        title: "What each scene needs: least error of a tick under 100 us".into(),
        below: "RMS force error [%] against finite elements, the larger of held and moving".into(),
        form: Form::Heat(heat),
    }
}

fn look(pct: f64) -> Tone {
    match pct {
        pct if pct <= WITHIN_PCT[0] => Tone::Good,
        pct if pct <= WITHIN_PCT[1] => Tone::Thin,
        pct if pct <= 15.0 => Tone::Slight,
        _ => Tone::Failure,
    }
}
