//! The command `palpate suite`.

use std::ops::Range;

use palpate_sim::command::options::suite::SuiteOptions;
use palpate_sim::command::progress::Progress;
use palpate_sim::error::Error;
use serde::{Deserialize, Serialize};

use crate::methods::Method;
use crate::study::{Findings, Study, Table};
use crate::suite::{SCENES, SuiteRow, cheapest, run};

/// Numbers of nodes of the meshes.
const SIZES: [usize; 3] = [57, 130, 410];
/// Errors for which the cheapest method is named [%].
const WITHIN_PCT: [f64; 2] = [2.0, 5.0];

/// Every method on every scene.
pub(super) struct Suite {
    cases: Vec<(Method, usize)>,
}

/// Rows of one method and mesh.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(super) struct Rows {
    rows: Vec<SuiteRow>,
}

/// A line of the table: a scene, what the law is off there, and the cheapest methods.
#[derive(Serialize)]
struct Line {
    scene: &'static str,
    law_pct: Option<f64>,
    within_2_pct: String,
    within_5_pct: String,
}

impl Suite {
    pub(super) fn of(options: &SuiteOptions) -> Self {
        let sizes = if options.quick { &SIZES[..1] } else { &SIZES[..] };
        let own = |nodes: usize| Method::ALL.into_iter().map(move |method| (method, nodes));
        let cases =
            sizes.iter().flat_map(|nodes| own(*nodes)).filter(|(method, nodes)| *method != Method::Law || *nodes == SIZES[0]);
        Self { cases: cases.collect() }
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
        for (n, (method, nodes)) in chosen {
            rows.push((n as u64, Rows { rows: run(*method, *nodes)? }));
            steps.one(&format!("{} {nodes} nodes", method.name()));
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
            let law = rows.iter().find(|row| row.scene == scene && row.method == Method::Law.name());
            let [within_2_pct, within_5_pct] =
                WITHIN_PCT.map(|pct| cheapest(&rows, scene, pct).map_or_else(|| "none".into(), name));
            Line { scene, law_pct: law.and_then(SuiteRow::worst_pct), within_2_pct, within_5_pct }
        };
        let lines: Vec<Line> = SCENES.iter().map(|scene| line(scene.name)).collect();
        let by_law = lines.iter().filter(|line| line.within_5_pct.starts_with(Method::Law.name())).count();
        let by_patch = lines.iter().filter(|line| line.within_5_pct.starts_with("palpate")).count() - by_law;
        Ok(Findings {
            headline: format!(
                "of {} scenes the law of the plain block is the cheapest method within 5 % on {by_law}, a patch on {by_patch}",
                lines.len()
            ),
            tables: vec![
                Table::of("suite", &lines)?
                    .about("what each scene needs at least: the cheapest method within 2 % and within 5 %"),
                Table::of("rows", &rows)?.quiet(),
            ],
            ..Findings::default()
        })
    }
}
