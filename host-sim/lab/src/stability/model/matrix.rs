//! Runs every row through every case at every stiffness, and finds the margins.

use std::ops::Range;

use rayon::prelude::*;
use serde::{Deserialize, Deserializer, Serialize, Serializer};

use super::built_method::{BuiltMethod, ROWS, Row};
use super::load_case::{CASES, CaseTissue, LoadCase, QUICK_CASES};
use super::margin::{Axis, Margin, margin};
use super::verdict::Figures;
use crate::error::Error;

/// Scope of a run: rows, stiffnesses and columns, and the stiffnesses at which margins are
/// searched.
#[derive(Clone, Debug)]
pub struct Scope {
    /// Number of nodes of the block.
    pub nodes: usize,
    /// Rows that are run.
    pub rows: Vec<Row>,
    /// Young's moduli that are run [Pa].
    pub moduli_pa: Vec<f64>,
    /// Columns that are run.
    pub cases: Vec<LoadCase>,
    /// Young's moduli, among those of `moduli_pa`, at which margins are searched [Pa].
    pub margins_at_pa: Vec<f64>,
}

/// A verdict with its row, stiffness and column.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Cell {
    /// Row of the matrix.
    pub row: Row,
    /// Young's modulus [Pa].
    pub youngs_modulus_pa: f64,
    /// Column of the matrix.
    #[serde(serialize_with = "name", deserialize_with = "named")]
    pub case: LoadCase,
    /// Substeps per tick.
    pub substeps: u16,
    /// Figures of the press, including the verdict.
    pub figures: Figures,
}

/// A margin with its row, stiffness and quantity.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct MarginCell {
    /// Row of the matrix.
    pub row: Row,
    /// Young's modulus [Pa].
    pub youngs_modulus_pa: f64,
    /// Substeps per tick.
    pub substeps: u16,
    /// Quantity that was increased.
    pub axis: Axis,
    /// Margin to failure.
    pub margin: Margin,
}

fn name<S: Serializer>(case: &LoadCase, to: S) -> Result<S::Ok, S::Error> {
    to.serialize_str(case.name)
}

fn named<'de, D: Deserializer<'de>>(from: D) -> Result<LoadCase, D::Error> {
    let name = String::deserialize(from)?;
    let known = CASES.into_iter().find(|case| case.name == name);
    known.ok_or_else(|| serde::de::Error::custom(format!("no column is called {name}")))
}

/// Results of some of the places, ordered by row, then stiffness, then column.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct Part {
    /// Cells with their verdicts.
    pub cells: Vec<Cell>,
    /// Margins of the rows at the stiffnesses at which they are searched.
    pub margins: Vec<MarginCell>,
}

/// All results, ordered by row, then stiffness, then column.
#[derive(Clone, Debug)]
pub struct Matrix {
    /// Scope of the run.
    pub scope: Scope,
    /// Cells with their verdicts.
    pub cells: Vec<Cell>,
    /// Margins of the rows at the stiffnesses at which they are searched.
    pub margins: Vec<MarginCell>,
}

impl Scope {
    /// The whole matrix on the block of 410 nodes.
    pub fn full() -> Self {
        Self {
            nodes: 410,
            rows: ROWS.to_vec(),
            moduli_pa: vec![1e3, 3.5e3, 20e3, 100e3, 200e3],
            cases: CASES.to_vec(),
            margins_at_pa: vec![3.5e3, 100e3],
        }
    }

    /// The short matrix: two stiffnesses and eight columns on the block of 130 nodes, with margins
    /// at one stiffness.
    pub fn quick() -> Self {
        Self {
            nodes: 130,
            moduli_pa: vec![3.5e3, 100e3],
            cases: CASES.into_iter().filter(|c| QUICK_CASES.contains(&c.name)).collect(),
            margins_at_pa: vec![3.5e3],
            ..Self::full()
        }
    }

    /// Number of places; a place is a row at a stiffness, and [`run`] numbers them.
    pub fn places(&self) -> usize {
        self.rows.len() * self.moduli_pa.len()
    }

    /// Number of steps that [`run`] reports for these places.
    pub fn steps(&self, places: Range<usize>) -> usize {
        let margins = self.at(places.clone()).filter(|(_, pa)| self.margins_at_pa.contains(pa)).count();
        places.len() * (self.tissues().len() + self.cases.len()) + margins * Axis::ALL.len()
    }

    fn at(&self, places: Range<usize>) -> impl Iterator<Item = (Row, f64)> {
        let all = self.rows.iter().flat_map(|row| self.moduli_pa.iter().map(move |pa| (*row, *pa)));
        all.take(places.end).skip(places.start)
    }

    /// Tissues that the columns need.
    fn tissues(&self) -> Vec<CaseTissue> {
        CaseTissue::ALL.into_iter().filter(|tissue| self.cases.iter().any(|c| c.tissue == *tissue)).collect()
    }
}

/// Runs the places with these numbers; `done` is called after every step.
pub fn run(scope: &Scope, places: Range<usize>, done: &(dyn Fn() + Sync)) -> Result<Part, Error> {
    let tissues = scope.tissues();
    let places = scope.at(places).flat_map(|(row, pa)| tissues.iter().map(move |&tissue| (row, pa, tissue)));
    let places: Vec<(Row, f64, CaseTissue)> = places.collect();
    let set_up = |&(row, youngs_modulus_pa, tissue): &(Row, f64, CaseTissue)| {
        let method = BuiltMethod::new(row, scope.nodes, youngs_modulus_pa, tissue);
        done();
        Ok(method?.map(|s| (youngs_modulus_pa, tissue, s)))
    };
    let built: Vec<Option<(f64, CaseTissue, BuiltMethod)>> = places.par_iter().map(set_up).collect::<Result<_, Error>>()?;
    let built: Vec<(f64, CaseTissue, BuiltMethod)> = built.into_iter().flatten().collect();
    let of_case = |case: &LoadCase, (_, tissue, _): &(f64, CaseTissue, BuiltMethod)| case.tissue == *tissue;

    let mut trials: Vec<(&(f64, CaseTissue, BuiltMethod), &LoadCase)> = Vec::new();
    let mut searches = Vec::new();
    for method in &built {
        trials.extend(scope.cases.iter().filter(|c| of_case(c, method)).map(|c| (method, c)));
        if method.1 == CaseTissue::Plain && scope.margins_at_pa.contains(&method.0) {
            searches.extend(Axis::ALL.map(|axis| (method, axis)));
        }
    }
    let try_one = |((youngs_modulus_pa, _, method), case): &(&(f64, CaseTissue, BuiltMethod), &LoadCase)| {
        let figures = method.stand(&case.stimulus)?;
        done();
        let (row, substeps) = (method.row, method.substeps);
        Ok(Cell { row, youngs_modulus_pa: *youngs_modulus_pa, case: **case, substeps, figures })
    };
    let search_one = |((youngs_modulus_pa, _, method), axis): &(&(f64, CaseTissue, BuiltMethod), Axis)| {
        let margin = margin(method, *axis)?;
        done();
        let (row, substeps) = (method.row, method.substeps);
        Ok(MarginCell { row, youngs_modulus_pa: *youngs_modulus_pa, substeps, axis: *axis, margin })
    };
    let cells = trials.par_iter().map(try_one).collect::<Result<_, Error>>()?;
    let margins = searches.par_iter().map(search_one).collect::<Result<_, Error>>()?;
    Ok(Part { cells, margins })
}
