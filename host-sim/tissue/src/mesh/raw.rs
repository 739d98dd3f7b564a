//! A mesh as it is in its file: in file units, with the file's own numbers, and not checked yet.

use std::collections::BTreeMap;

use super::Up;
use super::element::{Kind, Shape, eight_tets};

/// Nodes, solids and faces with the numbers that they have in their file. Solids other than tets
/// are divided into tets as they are added.
pub(super) struct RawMesh {
    pub format: &'static str,
    /// Name of the file, for messages.
    pub file: String,
    /// Axis that points up by the file's own words.
    pub up: Option<Up>,
    pub nodes: Vec<RawNode>,
    pub tets: Vec<RawTet>,
    /// Tets with nodes on their edges, which [`Self::complete`] makes into tets.
    second_order: Vec<SecondOrder>,
    /// Numbers of the corners of all faces, and the end of each face in that list.
    pub face_corners: Vec<u64>,
    pub face_ends: Vec<usize>,
    /// Number of elements that are no part of a body, by kind, and of faces.
    pub ignored: BTreeMap<&'static str, usize>,
    /// Number of solids of kinds that are not read, by kind.
    pub unread: BTreeMap<&'static str, usize>,
    /// Number of solids divided into tets, by kind.
    pub divided: BTreeMap<&'static str, usize>,
    /// Number of elements of second order that are read by their corners alone, by kind.
    pub by_corners: BTreeMap<&'static str, usize>,
}

pub(super) struct RawNode {
    pub number: u64,
    /// Line in the file, counted from 1; `None` in a binary file.
    pub line: Option<usize>,
    /// Position in file units.
    pub position: [f64; 3],
}

pub(super) struct RawTet {
    pub number: u64,
    /// Line in the file, counted from 1; `None` in a binary file.
    pub line: Option<usize>,
    /// Numbers of its four nodes.
    pub nodes: [u64; 4],
    pub region: u32,
    /// Whether it is a part of another solid, and so has no orientation of its own.
    pub is_part: bool,
}

struct SecondOrder {
    number: u64,
    line: Option<usize>,
    nodes: [u64; 10],
    region: u32,
}

impl RawMesh {
    pub fn new(format: &'static str, file: &str) -> Self {
        Self {
            format,
            file: file.to_owned(),
            up: None,
            nodes: Vec::new(),
            tets: Vec::new(),
            second_order: Vec::new(),
            face_corners: Vec::new(),
            face_ends: Vec::new(),
            ignored: BTreeMap::new(),
            unread: BTreeMap::new(),
            divided: BTreeMap::new(),
            by_corners: BTreeMap::new(),
        }
    }

    /// Adds an element with its nodes in the order of VTK; those of an element that is not read may
    /// be left out.
    pub fn add(&mut self, kind: Kind, number: u64, line: Option<usize>, nodes: &[u64], region: u32) {
        match kind {
            Kind::Solid { shape: Shape::Tet, .. } => {
                if let Ok(nodes) = nodes.try_into() {
                    self.second_order.push(SecondOrder { number, line, nodes, region });
                } else if let Some(Ok(corners)) = nodes.get(..4).map(TryInto::try_into) {
                    self.tets.push(RawTet { number, line, nodes: corners, region, is_part: false });
                }
            }
            Kind::Solid { shape, nodes: all } => {
                let tets = shape.tets(nodes).into_iter();
                self.tets.extend(tets.map(|nodes| RawTet { number, line, nodes, region, is_part: true }));
                *self.divided.entry(shape.name()).or_default() += 1;
                if all > shape.corners() {
                    *self.by_corners.entry(shape.name()).or_default() += 1;
                }
            }
            Kind::Face { corners, nodes: all } => {
                self.add_face(&nodes[..corners]);
                *self.ignored.entry(kind.name()).or_default() += 1;
                if all > corners {
                    *self.by_corners.entry(kind.name()).or_default() += 1;
                }
            }
            Kind::Unread(name) => *self.unread.entry(name).or_default() += 1,
            Kind::Other(name) => *self.ignored.entry(name).or_default() += 1,
        }
    }

    pub fn add_face(&mut self, corners: &[u64]) {
        self.face_corners.extend(corners);
        self.face_ends.push(self.face_corners.len());
    }

    /// Makes tets of those of second order once all elements are read: eight of each, which keep
    /// its curved edges; or one of its corners, if it has neighbours of other kinds, whose quads
    /// have no such eight.
    pub fn complete(&mut self) {
        let second_order = std::mem::take(&mut self.second_order);
        let alone = self.tets.is_empty();
        for SecondOrder { number, line, nodes, region } in second_order {
            if alone {
                self.tets.extend(eight_tets(&nodes).map(|nodes| RawTet { number, line, nodes, region, is_part: true }));
                *self.divided.entry("tet of second order").or_default() += 1;
            } else {
                let [a, b, c, d, ..] = nodes;
                self.tets.push(RawTet { number, line, nodes: [a, b, c, d], region, is_part: false });
                *self.by_corners.entry("tet").or_default() += 1;
            }
        }
    }

    /// Whether the file has solids, read or not.
    pub fn has_solids(&self) -> bool {
        !self.tets.is_empty() || !self.unread.is_empty()
    }
}
