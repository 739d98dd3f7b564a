//! A damaged file gives a one-line error or a valid mesh, and never a panic.

use palpate_tissue::mesh::import::MIN_QUALITY;
use proptest::prelude::*;
use proptest::sample::Index;

use crate::mesh_import::write::{FORMATS, write};
use crate::mesh_import::{block, import_bytes};

#[derive(Clone, Debug)]
pub enum Damage {
    Byte(Index, u8),
    Truncate(Index),
    Remove(Index, usize),
    Repeat(Index, usize),
    RemoveLine(Index),
    SwapLines(Index, Index),
    Word(Index, &'static str),
}

pub fn damage() -> impl Strategy<Value = Damage> {
    let place = any::<Index>;
    let words = prop::sample::select(vec![
        "0",
        "1",
        "2",
        "4",
        "10",
        "-1",
        "1e400",
        "nan",
        "-0.0",
        "1e-320",
        "4.1",
        "1000000000000",
        "18446744073709551615",
        "99999999999999999999",
        "$",
        "$Nodes",
        "POINTS",
        "CELLS",
        "\u{2028}",
        "\u{0}",
        "é",
    ]);
    prop_oneof![
        (place(), any::<u8>()).prop_map(|(at, byte)| Damage::Byte(at, byte)),
        place().prop_map(Damage::Truncate),
        (place(), 1..40_usize).prop_map(|(at, n)| Damage::Remove(at, n)),
        (place(), 1..200_usize).prop_map(|(at, n)| Damage::Repeat(at, n)),
        place().prop_map(Damage::RemoveLine),
        (place(), place()).prop_map(|(a, b)| Damage::SwapLines(a, b)),
        (place(), words).prop_map(|(at, word)| Damage::Word(at, word)),
    ]
}

pub fn apply(bytes: &mut Vec<u8>, damage: &Damage) {
    if bytes.is_empty() {
        return;
    }
    let part = |at: &Index, length: usize, size: usize| {
        let from = at.index(size);
        from..size.min(from + length)
    };
    let lines = || bytes.split_inclusive(|&byte| byte == b'\n').map(<[u8]>::to_vec).collect::<Vec<_>>();
    match damage {
        Damage::Byte(at, byte) => {
            let at = at.index(bytes.len());
            bytes[at] = *byte;
        }
        Damage::Truncate(at) => bytes.truncate(at.index(bytes.len())),
        Damage::Remove(at, length) => drop(bytes.drain(part(at, *length, bytes.len()))),
        Damage::Repeat(at, length) => {
            let range = part(at, *length, bytes.len());
            let copy = bytes[range.clone()].to_vec();
            bytes.splice(range.start..range.start, copy);
        }
        Damage::RemoveLine(at) => {
            let mut lines = lines();
            lines.remove(at.index(lines.len()));
            *bytes = lines.concat();
        }
        Damage::SwapLines(a, b) => {
            let mut lines = lines();
            let (a, b) = (a.index(lines.len()), b.index(lines.len()));
            lines.swap(a, b);
            *bytes = lines.concat();
        }
        Damage::Word(at, word) => {
            let from = at.index(bytes.len());
            let is_space = |byte: &u8| byte.is_ascii_whitespace();
            let start = bytes[..from].iter().rposition(is_space).map_or(0, |space| space + 1);
            let end = bytes[from..].iter().position(is_space).map_or(bytes.len(), |space| from + space);
            bytes.splice(start.min(end)..end, word.bytes());
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, cases: 120, ..ProptestConfig::default() })]

    #[test]
    fn a_damaged_file_is_refused_in_one_line_or_sound(
        mesh in block::any(),
        damages in prop::collection::vec(damage(), 1..4),
    ) {
        for format in FORMATS {
            let (name, mut bytes) = write(format, &mesh, 3);
            for damage in &damages {
                apply(&mut bytes, damage);
            }
            match import_bytes(name, &bytes) {
                Err(error) => {
                    let line = error.to_string();
                    prop_assert!(!line.contains(['\n', '\r']), "{:?}", line);
                    prop_assert!(line.contains(": ") && line.len() < 500, "{:?}", line);
                }
                Ok(imported) => {
                    let mesh = imported.mesh;
                    prop_assert_eq!(mesh.tets.len(), mesh.regions.len());
                    prop_assert!(imported.report.worst_tet.quality >= MIN_QUALITY);
                    for &tet in &mesh.tets {
                        prop_assert!(tet.iter().all(|&node| (node as usize) < mesh.nodes_m.len()));
                        prop_assert!(block::six_volumes(&mesh, tet) > 0.0);
                    }
                }
            }
        }
    }
}
