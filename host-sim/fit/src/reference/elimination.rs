//! Order in which the nodes of a mesh are eliminated: approximate minimum degree (Amestoy, Davis,
//! Duff 1996), with some nodes at the end.

use faer::dyn_stack::{MemBuffer, MemStack};
use faer::sparse::SymbolicSparseColMatRef;
use faer::sparse::linalg::amd::{Control, order, order_scratch};

/// Order of all nodes, with those of `last` at the end in their given order; `None` if there is not
/// enough memory. `below` lists, for each node, the coupled nodes with a higher number.
pub fn eliminate<'a>(nodes: usize, below: impl Fn(usize) -> &'a [u32], last: &[u32]) -> Option<Vec<u32>> {
    const LAST: u32 = u32::MAX;
    let mut place = vec![0; nodes];
    last.iter().for_each(|n| place[*n as usize] = LAST);
    let first: Vec<u32> = (0..nodes as u32).filter(|n| place[*n as usize] != LAST).collect();
    (0_u32..).zip(&first).for_each(|(at, n)| place[*n as usize] = at);
    let (mut start, mut rows) = (vec![0], Vec::new());
    for n in &first {
        rows.extend(below(*n as usize).iter().map(|m| place[*m as usize]).filter(|at| *at != LAST).map(|at| at as usize));
        start.push(rows.len());
    }
    let size = first.len();
    let graph = SymbolicSparseColMatRef::new_checked(size, size, &start, None, &rows);
    let mut memory = MemBuffer::try_new(order_scratch::<usize>(size, rows.len())).ok()?;
    let (mut forward, mut inverse) = (vec![0; size], vec![0; size]);
    order(&mut forward, &mut inverse, graph, Control::default(), MemStack::new(&mut memory)).ok()?;
    Some(forward.into_iter().map(|at: usize| first[at]).chain(last.iter().copied()).collect())
}
