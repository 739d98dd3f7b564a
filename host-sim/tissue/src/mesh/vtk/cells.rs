//! The `CELLS` of a VTK file in either layout, and the tets among them.

use super::{Word, Words};
use crate::mesh::error::{Defect, MeshError};
use crate::mesh::raw::{RawMesh, RawTet};

/// Nodes of all cells in one list, with the place of every cell in it.
#[derive(Default)]
pub(super) struct Cells {
    nodes: Vec<u64>,
    cells: Vec<Cell>,
}

#[derive(Clone, Copy)]
struct Cell {
    line: usize,
    first: usize,
    end: usize,
}

impl Cells {
    /// `CELLS n size`, in the layout that the next word shows.
    pub fn read(words: &mut Words) -> Result<Self, MeshError> {
        let count = words.whole("the number of cells")?;
        let size = words.whole("the size of the cell list")?;
        match words.next() {
            Some(word) if word.text.eq_ignore_ascii_case("OFFSETS") => Self::with_offsets(words, count, size),
            first => Self::with_counts(words, first, count, size),
        }
    }

    /// Up to version 4: `n` times `count nodes...`, `size` numbers in all.
    fn with_counts(words: &mut Words, mut first: Option<Word>, count: u64, size: u64) -> Result<Self, MeshError> {
        let mut cells = Self::default();
        for found in 0..count {
            let word = match first.take() {
                Some(word) => word,
                None => words.value("CELLS", "cells", count, found)?,
            };
            let first = cells.nodes.len();
            for _ in 0..word.whole("the number of nodes of a cell")? {
                let node = words.value("CELLS", "cells", count, found)?;
                cells.nodes.push(node.whole("a point number")?);
            }
            cells.cells.push(Cell { line: word.at.line, first, end: cells.nodes.len() });
        }
        let total = (cells.nodes.len() as u64).saturating_add(count);
        if total == size {
            return Ok(cells);
        }
        Err(words.at().error(Defect::Disagree { what: "CELLS size", says: size, found: total }))
    }

    /// From version 5.1: `n` offsets, the last one the end, then `size` nodes.
    fn with_offsets(words: &mut Words, count: u64, size: u64) -> Result<Self, MeshError> {
        words.required("the type of OFFSETS")?;
        let mut offsets = Vec::new();
        for found in 0..count {
            let offset = words.value("OFFSETS", "offsets", count, found)?;
            offsets.push((offset, offset.whole("an offset")?));
        }
        let keyword = words.required("CONNECTIVITY")?;
        if !keyword.text.eq_ignore_ascii_case("CONNECTIVITY") {
            return Err(keyword.unexpected("CONNECTIVITY"));
        }
        words.required("the type of CONNECTIVITY")?;
        let mut nodes = Vec::new();
        let mut lines = Vec::new();
        for found in 0..size {
            let node = words.value("CONNECTIVITY", "entries", size, found)?;
            nodes.push(node.whole("a point number")?);
            lines.push(node.at.line);
        }
        let mut cells = Vec::new();
        for (&(_, first), &(word, end)) in offsets.iter().zip(offsets.iter().skip(1)) {
            let (Ok(first), Ok(end)) = (usize::try_from(first), usize::try_from(end)) else {
                return Err(word.unexpected("an offset into CONNECTIVITY"));
            };
            if first > end || end > nodes.len() {
                return Err(word.unexpected("an offset that does not fall, into CONNECTIVITY"));
            }
            let line = lines.get(first).copied().unwrap_or(word.at.line);
            cells.push(Cell { line, first, end });
        }
        // Each cell begins where the one before ends, so these two leave no entry out.
        let (start, end) = (offsets.first(), offsets.last());
        if let Some(&(word, 1..)) = start {
            return Err(word.unexpected("the first offset 0"));
        }
        match end {
            Some(&(word, end)) if end != size => Err(word.unexpected("the last offset to be the size of CONNECTIVITY")),
            _ => Ok(Self { nodes, cells }),
        }
    }

    /// `CELL_TYPES n`, then one code a cell; the tets among them go to `mesh`.
    pub fn take_tets(&self, words: &mut Words, mesh: &mut RawMesh) -> Result<(), MeshError> {
        let announced = words.whole("the number of cell types")?;
        if announced != self.cells.len() as u64 {
            return Err(words.at().error(Defect::Disagree {
                what: "CELL_TYPES",
                says: announced,
                found: self.cells.len() as u64,
            }));
        }
        for (number, cell) in (0..).zip(&self.cells) {
            let code = words.value("CELL_TYPES", "types", announced, number)?;
            match code.whole("a cell type")? {
                TET => mesh.tets.push(RawTet { number, line: cell.line, nodes: self.corners(*cell, code)?, region: 0 }),
                24 | 71 | 78 => return Err(code.at.error(Defect::HigherOrder)),
                other => mesh.ignore(kind(other)),
            }
        }
        Ok(())
    }

    fn corners(&self, cell: Cell, code: Word) -> Result<[u64; 4], MeshError> {
        self.nodes
            .get(cell.first..cell.end)
            .and_then(|nodes| nodes.try_into().ok())
            .ok_or_else(|| code.unexpected("a type that fits the cell (a tet has 4 nodes)"))
    }
}

/// `VTK_TETRA`.
const TET: u64 = 10;

fn kind(code: u64) -> &'static str {
    match code {
        1 | 2 => "point",
        3 | 4 | 21 | 35 | 68 | 75 => "line",
        5 | 6 | 22 | 34 | 69 | 76 => "triangle",
        8 | 9 | 23 | 28 | 30 | 70 | 77 => "quad",
        11 | 12 | 25 | 29 | 33 | 72 | 79 => "hexahedron",
        13 | 26 | 31 | 32 | 73 | 80 => "prism",
        14 | 27 | 37 | 74 | 81 => "pyramid",
        _ => "other",
    }
}
