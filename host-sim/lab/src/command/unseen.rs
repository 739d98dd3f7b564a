//! The command `palpate unseen`.

use std::ops::Range;

use palpate_sim::command::options::unseen::UnseenOptions;
use palpate_sim::command::progress::Progress;
use palpate_sim::error::Error;
use palpate_tissue::Error as TissueError;

use crate::study::{Claim, Findings, Study, Table};
use crate::unseen::{Effort, Row, run};

/// Numbers of scenes if the command line gives none, without and with `--quick`.
const SCENES: [u64; 2] = [60, 1];
/// Share of the scenes in which the stated error must hold (1).
const HOLDS: f64 = 0.95;

/// Random scenes from a seed.
pub(super) struct Unseen {
    scenes: u64,
    seed: u64,
    quick: bool,
}

impl Unseen {
    pub(super) fn of(options: &UnseenOptions) -> Self {
        let scenes = options.scenes.unwrap_or(SCENES[usize::from(options.quick)]);
        Self { scenes, seed: options.seed, quick: options.quick }
    }
}

impl Study for Unseen {
    type Row = Row;

    fn cases(&self) -> u64 {
        self.scenes
    }

    fn run(&self, cases: Range<u64>) -> Result<Vec<(u64, Row)>, Error> {
        let progress = Progress::new(cases.end - cases.start, "scenes");
        let one = |case: u64| {
            let scratch = tempfile::tempdir().map_err(|source| TissueError::Write { path: std::env::temp_dir(), source })?;
            let row = run(case, self.seed, Effort { quick: self.quick }, scratch.path())?;
            progress.inc(1);
            Ok((case, row))
        };
        let rows = cases.map(one).collect();
        progress.finish();
        rows
    }

    fn findings(&self, rows: Vec<Row>) -> Result<Findings, Error> {
        let fitted = || rows.iter().filter(|row| row.is_fitted());
        let (count, holds, far) =
            (fitted().count(), fitted().filter(|row| row.holds()).count(), fitted().filter(|row| row.is_far()).count());
        let least = (HOLDS * count as f64).ceil() as usize;
        let claims = vec![
            Claim::promise(
                "scenes in which the stated error holds",
                format!("at least {least} of {count}"),
                format!("{holds} of {count}"),
                count > 0 && holds >= least,
            ),
            Claim::promise("scenes that are further off than 1.5 times the stated error", "none", far.to_string(), far == 0),
        ];
        let refused = rows.len() - count;
        let table = Table::rows("unseen", &rows)
            .col("scene", |row| row.scene)
            .col("words", |row| row.words.clone())
            .col("nodes", |row| row.nodes as u64)
            .col("stated_rms_pct", |row| row.stated_rms_pct)
            .col("stated_worst_pct", |row| row.stated_worst_pct)
            .col("found_rms_pct", |row| row.found_rms_pct)
            .col("found_worst_pct", |row| row.found_worst_pct)
            .col("worst_mm", |row| row.worst_mm)
            .col("elements_pct", |row| row.elements_pct)
            .col("holds", |row| row.is_fitted() && row.holds())
            .col("refused", |row| row.refused.clone())
            .all();
        let mut findings = Findings {
            headline: format!("the stated error holds in {holds} of {count} scenes, {refused} were refused"),
            claims,
            tables: vec![table],
            ..Findings::default()
        };
        findings.fact("seed", self.seed);
        findings.fact("scenes", rows.len());
        findings.fact("refused", refused);
        Ok(findings)
    }
}
