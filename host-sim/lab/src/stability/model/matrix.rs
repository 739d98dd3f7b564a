//! Runs every row at every stiffness through every case, and finds the margins.

use rayon::prelude::*;

use super::built_method::{BuiltMethod, ROWS, Row};
use super::load_case::{CASES, CaseTissue, LoadCase, QUICK_CASES};
use super::margin::{Axis, Margin, margin};
use super::verdict::Figures;
use crate::error::Error;

/// Scope of a run: rows, stiffnesses and columns, and where margins are searched.
#[derive(Clone, Debug)]
pub struct Scope {
    /// Nodes of the block.
    pub nodes: usize,
    /// Rows.
    pub rows: Vec<Row>,
    /// Stiffnesses [Pa].
    pub moduli_pa: Vec<f64>,
    /// Columns.
    pub cases: Vec<LoadCase>,
    /// Stiffnesses at which margins are searched, of those above [Pa].
    pub margins_at_pa: Vec<f64>,
}

/// A verdict with its place.
#[derive(Clone, Debug)]
pub struct Cell {
    /// Row.
    pub row: Row,
    /// Stiffness [Pa].
    pub youngs_modulus_pa: f64,
    /// Column.
    pub case: LoadCase,
    /// Substeps of a tick.
    pub substeps: u16,
    /// Figures of the press, with the verdict.
    pub figures: Figures,
}

/// A margin with its place.
#[derive(Clone, Debug)]
pub struct MarginCell {
    /// Row.
    pub row: Row,
    /// Stiffness [Pa].
    pub youngs_modulus_pa: f64,
    /// Substeps of a tick.
    pub substeps: u16,
    /// Quantity that grew.
    pub axis: Axis,
    /// How far.
    pub margin: Margin,
}

/// Everything that came out, in the scope's order: rows, stiffnesses, columns.
#[derive(Clone, Debug)]
pub struct Matrix {
    /// The scope.
    pub scope: Scope,
    /// Verdicts.
    pub cells: Vec<Cell>,
    /// Margins.
    pub margins: Vec<MarginCell>,
}

impl Scope {
    /// The whole matrix on the block of 410 nodes.
    #[must_use]
    pub fn full() -> Self {
        Self {
            nodes: 410,
            rows: ROWS.to_vec(),
            moduli_pa: vec![1e3, 3.5e3, 20e3, 100e3, 200e3],
            cases: CASES.to_vec(),
            margins_at_pa: vec![3.5e3, 100e3],
        }
    }

    /// Two stiffnesses and eight columns on the block of 130 nodes, margins at one.
    #[must_use]
    pub fn quick() -> Self {
        Self {
            nodes: 130,
            moduli_pa: vec![3.5e3, 100e3],
            cases: CASES.into_iter().filter(|c| QUICK_CASES.contains(&c.name)).collect(),
            margins_at_pa: vec![3.5e3],
            ..Self::full()
        }
    }

    /// Steps that [`run`] reports.
    #[must_use]
    pub fn steps(&self) -> usize {
        let places = self.rows.len() * self.moduli_pa.len();
        places * (self.tissues().len() + self.cases.len()) + self.rows.len() * self.margins_at_pa.len() * Axis::ALL.len()
    }

    /// The tissues that the columns ask for.
    fn tissues(&self) -> Vec<CaseTissue> {
        CaseTissue::ALL.into_iter().filter(|tissue| self.cases.iter().any(|c| c.tissue == *tissue)).collect()
    }
}

/// Runs a scope; `done` is called after every step.
///
/// # Errors
/// A method that cannot be built.
pub fn run(scope: &Scope, done: &(dyn Fn() + Sync)) -> Result<Matrix, Error> {
    let tissues = scope.tissues();
    let mut places = Vec::new();
    for &row in &scope.rows {
        for &youngs_modulus_pa in &scope.moduli_pa {
            places.extend(tissues.iter().map(|&tissue| (row, youngs_modulus_pa, tissue)));
        }
    }
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
    Ok(Matrix { scope: scope.clone(), cells, margins })
}
