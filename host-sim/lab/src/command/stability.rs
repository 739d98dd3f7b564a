//! The command `palpate stability`.

use std::ops::Range;

use palpate_sim::command::options::stability::StabilityOptions;
use palpate_sim::command::progress::Progress;
use palpate_sim::error::Error;
use serde::{Deserialize, Serialize};

use crate::stability::loop_matrix::{self, LoopSummary};
use crate::stability::model;
use crate::study::{Findings, Study};

/// Methods, and loops.
pub(super) struct Stability {
    /// Scope of the models; `None` with `--loop`.
    model: Option<model::Scope>,
    /// Scope of the loop; `None` with `--model`.
    of_loop: Option<loop_matrix::Scope>,
}

/// Cells of some cases.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub(super) struct Cells {
    model: model::Part,
    #[serde(rename = "loop")]
    of_loop: loop_matrix::Part,
}

impl Study for Stability {
    type Row = Cells;

    fn cases(&self) -> u64 {
        (self.places() + self.of_loop.as_ref().map_or(0, loop_matrix::Scope::cases)) as u64
    }

    fn run(&self, cases: Range<u64>) -> Result<Vec<(u64, Cells)>, Error> {
        // cases are numbered with the methods first, then the loops
        let (first, end, places) = (cases.start as usize, cases.end as usize, self.places());
        let mut cells = Cells::default();
        if let Some(scope) = &self.model {
            let cases = first.min(places)..end.min(places);
            let progress = Progress::new(scope.steps(cases.clone()) as u64, "presses and margins");
            let part = model::run(scope, cases, &|| progress.inc(1));
            progress.finish();
            cells.model = part?;
        }
        if let Some(scope) = &self.of_loop {
            let cases = first.saturating_sub(places)..end.saturating_sub(places);
            let progress = Progress::new(scope.steps(cases.clone()) as u64, "loops");
            let part = loop_matrix::Part::measure(scope, cases, &|| progress.inc(1));
            progress.finish();
            cells.of_loop = part?;
        }
        Ok(vec![(cases.start, cells)])
    }

    fn findings(&self, parts: Vec<Cells>) -> Result<Findings, Error> {
        let mut cells = Cells::default();
        for part in parts {
            cells.model.cells.extend(part.model.cells);
            cells.model.margins.extend(part.model.margins);
            cells.of_loop.cells.extend(part.of_loop.cells);
            cells.of_loop.ceilings.extend(part.of_loop.ceilings);
        }
        let mut findings = Findings::default();
        if let Some(scope) = self.model.clone() {
            let matrix = model::Matrix { scope, cells: cells.model.cells, margins: cells.model.margins };
            model::report(&matrix, &mut findings);
        }
        if self.of_loop.is_some() {
            loop_matrix::report(&LoopSummary::of(cells.of_loop), &mut findings)?;
        }
        Ok(findings)
    }
}

impl Stability {
    pub(super) fn of(options: &StabilityOptions) -> Result<Self, Error> {
        let model = if options.quick { model::Scope::quick() } else { model::Scope::full() };
        let of_loop = if options.model { None } else { Some(loop_matrix::Scope::new(options.quick, options.full)?) };
        Ok(Self { model: (!options.only_loop).then_some(model), of_loop })
    }

    fn places(&self) -> usize {
        self.model.as_ref().map_or(0, model::Scope::places)
    }
}
