//! Merges the corners of triangles that are at the same place.

/// The largest extent.
pub(super) fn extent(vertices: &[[f64; 3]]) -> f64 {
    let along = |k: usize| {
        let places = vertices.iter().map(|at| at[k]);
        places.clone().fold(f64::NEG_INFINITY, f64::max) - places.fold(f64::INFINITY, f64::min)
    };
    along(0).max(along(1)).max(along(2))
}

/// Merges vertices at the same place; returns those in use, and the triangles that still have three
/// corners. With a `tolerance` above zero, a vertex within it of an earlier one is merged with
/// that.
pub(super) fn weld(vertices: &[[f64; 3]], triangles: &[[u32; 3]], tolerance: f64) -> (Vec<[f64; 3]>, Vec<[u32; 3]>) {
    // Adding zero makes -0 and 0 equal.
    let cell = |at: &[f64; 3]| at.map(|x| if tolerance > 0.0 { (x / tolerance).floor() } else { x + 0.0 });
    let compare = |a: &[f64; 3], b: &[f64; 3]| a[0].total_cmp(&b[0]).then(a[1].total_cmp(&b[1])).then(a[2].total_cmp(&b[2]));
    let mut cells: Vec<([f64; 3], u32)> = vertices.iter().map(&cell).zip(0..).collect();
    cells.sort_unstable_by(|a, b| compare(&a.0, &b.0).then(a.1.cmp(&b.1)));
    let in_cell = |wanted: [f64; 3]| {
        let from = cells.partition_point(|(cell, _)| compare(cell, &wanted).is_lt());
        cells[from..].iter().take_while(move |(cell, _)| compare(cell, &wanted).is_eq()).map(|(_, vertex)| *vertex)
    };
    let near = |a: u32, b: u32| {
        let (a, b) = (vertices[a as usize], vertices[b as usize]);
        (0..3).map(|k| (a[k] - b[k]).powi(2)).sum::<f64>() <= tolerance * tolerance
    };
    let steps = [-1.0, 0.0, 1.0];
    let first_of = |vertex: u32| {
        let own = cell(&vertices[vertex as usize]);
        let mut first = vertex;
        for x in steps {
            for y in steps {
                for z in steps {
                    let there = in_cell([own[0] + x, own[1] + y, own[2] + z]);
                    // the vertices of a cell are in rising order
                    first = there.take_while(|other| *other < first).find(|other| near(*other, vertex)).unwrap_or(first);
                }
            }
        }
        first
    };
    let mut stands_for: Vec<u32> = (0..vertices.len() as u32).collect();
    if tolerance > 0.0 {
        for vertex in 0..stands_for.len() {
            // earlier vertices already have their place
            stands_for[vertex] = stands_for[first_of(vertex as u32) as usize];
        }
    } else {
        for same in cells.chunk_by(|a, b| compare(&a.0, &b.0).is_eq()) {
            same.iter().for_each(|(_, vertex)| stands_for[*vertex as usize] = same[0].1);
        }
    }
    let merged = triangles.iter().map(|triangle| triangle.map(|vertex| stands_for[vertex as usize]));
    let merged: Vec<[u32; 3]> = merged.filter(|[a, b, c]| a != b && b != c && c != a).collect();
    in_use(vertices, &merged)
}

/// The vertices that triangles have, and the triangles with their new indices.
pub(super) fn in_use(vertices: &[[f64; 3]], triangles: &[[u32; 3]]) -> (Vec<[f64; 3]>, Vec<[u32; 3]>) {
    let mut kept = Vec::new();
    let mut new_index = vec![u32::MAX; vertices.len()];
    let mut out = Vec::with_capacity(triangles.len());
    for triangle in triangles {
        out.push(triangle.map(|vertex| {
            let index = &mut new_index[vertex as usize];
            if *index == u32::MAX {
                *index = kept.len() as u32;
                kept.push(vertices[vertex as usize]);
            }
            *index
        }));
    }
    (kept, out)
}
