//! The cells of a VTK file in any layout.

use super::kind::{STRIP, in_order, kind};
use super::{Word, Words};
use crate::mesh::element::Kind;
use crate::mesh::error::{Defect, MeshError};
use crate::mesh::raw::RawMesh;

/// Nodes of all cells in one list, with the position of every cell in it.
#[derive(Default)]
pub(super) struct Cells {
    nodes: Vec<u64>,
    cells: Vec<Cell>,
}

#[derive(Clone, Copy)]
struct Cell {
    /// Line in the file, counted from 1; `None` in a file without lines.
    line: Option<usize>,
    first: usize,
    end: usize,
}

impl Cells {
    /// Reads `CELLS n size`, in the layout that the next word shows.
    pub fn read(words: &mut Words) -> Result<Self, MeshError> {
        let count = words.whole("the number of cells")?;
        let size = words.whole("the size of the cell list")?;
        match words.next() {
            Some(word) if word.text.eq_ignore_ascii_case("OFFSETS") => Self::with_offsets(words, count, size),
            first => Self::with_counts(words, first, count, size),
        }
    }

    /// Reads cells up to version 4: `n` times `count nodes...`, `size` numbers in all.
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
            cells.cells.push(Cell { line: Some(word.at.line), first, end: cells.nodes.len() });
        }
        cells.has_size(size).map_err(|defect| words.at().error(defect))?;
        Ok(cells)
    }

    /// Checks the size that version 4 announces: the number of nodes in all cells, plus one for
    /// each cell.
    pub fn has_size(&self, size: u64) -> Result<(), Defect> {
        let total = (self.nodes.len() + self.cells.len()) as u64;
        if total == size { Ok(()) } else { Err(Defect::Disagree { what: "CELLS size", says: size, found: total }) }
    }

    pub fn push(&mut self, line: Option<usize>, nodes: &[u64]) {
        let first = self.nodes.len();
        self.nodes.extend(nodes);
        self.cells.push(Cell { line, first, end: self.nodes.len() });
    }

    /// Makes cells whose nodes follow each other in `nodes`, each up to its entry in `ends`.
    pub fn of_lists(nodes: Vec<u64>, ends: &[u64]) -> Result<Self, Defect> {
        let mut cells = Vec::new();
        let mut first = 0;
        for offset in ends {
            let end = usize::try_from(*offset).ok().filter(|end| (first..=nodes.len()).contains(end));
            let end = end.ok_or_else(|| Defect::Expected {
                what: "an offset that does not fall, into the connectivity",
                found: offset.to_string(),
            })?;
            cells.push(Cell { line: None, first, end });
            first = end;
        }
        if first == nodes.len() {
            return Ok(Self { nodes, cells });
        }
        Err(Defect::Disagree { what: "the last offset", says: first as u64, found: nodes.len() as u64 })
    }

    /// Reads cells from version 5.1 on: `n` offsets, of which the last is the end, then `size`
    /// nodes.
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
            cells.push(Cell { line: Some(line), first, end });
        }
        // Each cell begins where the previous one ends, so that no entry is left out.
        let (start, end) = (offsets.first(), offsets.last());
        if let Some(&(word, 1..)) = start {
            return Err(word.unexpected("the first offset 0"));
        }
        match end {
            Some(&(word, end)) if end != size => Err(word.unexpected("the last offset to be the size of CONNECTIVITY")),
            _ => Ok(Self { nodes, cells }),
        }
    }

    /// Checks that each cell has a type.
    pub fn as_many_types(&self, announced: u64) -> Result<(), Defect> {
        let found = self.cells.len() as u64;
        if announced == found { Ok(()) } else { Err(Defect::Disagree { what: "CELL_TYPES", says: announced, found }) }
    }

    /// Adds all cells as faces, of POLYGONS or `TRIANGLE_STRIPS`.
    pub fn take_faces(&self, number: &dyn Fn(u64) -> u64, strips: bool, mesh: &mut RawMesh) -> Result<(), Defect> {
        let code = if strips { STRIP } else { POLYGON };
        (0..self.cells.len() as u64).try_for_each(|cell| self.take(cell, code, number, mesh))
    }

    /// Adds the cell of this number to `mesh`; `number` gives the number of each of its points.
    pub fn take(&self, own: u64, code: u64, number: &dyn Fn(u64) -> u64, mesh: &mut RawMesh) -> Result<(), Defect> {
        let cell = usize::try_from(own).ok().and_then(|own| self.cells.get(own));
        let nodes = cell.and_then(|cell| self.nodes.get(cell.first..cell.end)).unwrap_or_default();
        let mut nodes: Vec<u64> = nodes.iter().map(|node| number(*node)).collect();
        if code == STRIP {
            for (n, three) in nodes.windows(3).enumerate() {
                let [a, b, c] = [three[0], three[1 + n % 2], three[2 - n % 2]];
                mesh.add(Kind::Face { corners: 3, nodes: 3 }, own, None, &[a, b, c], 0);
            }
            return Ok(());
        }
        let kind = kind(code, nodes.len());
        if let Kind::Solid { nodes: wanted, .. } | Kind::Face { nodes: wanted, .. } = kind
            && wanted != nodes.len()
        {
            let what = "a type that fits the cell (a tet has 4 nodes)";
            return Err(Defect::Expected { what, found: code.to_string() });
        }
        in_order(code, &mut nodes);
        mesh.add(kind, own, cell.and_then(|cell| cell.line), &nodes, 0);
        Ok(())
    }
}

const POLYGON: u64 = 7;
