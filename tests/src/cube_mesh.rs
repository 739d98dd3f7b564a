//! A cube and a chain of tets as mesh files.

use std::fmt::Write;

/// A cube from the origin to (`side`, `side`, `side`) as Gmsh 1 text, with `n`^3 nodes and six tets
/// per cell (Kuhn).
///
/// # Panics
/// Never panics: writing to a string does not fail.
pub fn cube(n: usize, side: f64) -> String {
    let node = |[x, y, z]: [usize; 3]| 1 + x + n * (y + n * z);
    let all = |m: usize| (0..m * m * m).map(move |i| [i % m, i / m % m, i / m / m]);
    let mut text = format!("$NOD\n{}\n", n * n * n);
    for at in all(n) {
        let [x, y, z] = at.map(|c| side * c as f64 / (n - 1) as f64);
        writeln!(text, "{} {x} {y} {z}", node(at)).unwrap();
    }
    writeln!(text, "$ENDNOD\n$ELM\n{}", 6 * (n - 1).pow(3)).unwrap();
    let mut tet = 0;
    for at in all(n - 1) {
        for order in [[0, 1, 2], [0, 2, 1], [1, 0, 2], [1, 2, 0], [2, 0, 1], [2, 1, 0]] {
            let mut corner = at;
            let mut nodes = node(corner).to_string();
            for axis in order {
                corner[axis] += 1;
                write!(nodes, " {}", node(corner)).unwrap();
            }
            tet += 1;
            writeln!(text, "{tet} 4 1 1 4 {nodes}").unwrap();
        }
    }
    text + "$ENDELM\n"
}

/// A chain of tets as Gmsh 1 text: each tet joins a node to the last three nodes of the tet before.
///
/// # Panics
/// Never panics: writing to a string does not fail.
pub fn chain(nodes: usize) -> String {
    let mut text = format!("$NOD\n{nodes}\n");
    for node in 1..=nodes {
        writeln!(text, "{node} {node} 0 0").unwrap();
    }
    writeln!(text, "$ENDNOD\n$ELM\n{}", nodes - 3).unwrap();
    for tet in 1..=nodes - 3 {
        writeln!(text, "{tet} 4 1 1 4 {tet} {} {} {}", tet + 1, tet + 2, tet + 3).unwrap();
    }
    text + "$ENDELM\n"
}
