//! A tree of axis-aligned boxes over triangles or tetrahedra: queries for the nearest item and for
//! an item that contains a point.

/// Largest number of items in a leaf.
const LEAF: usize = 4;

/// Lower and upper corner of a box [m].
pub(super) type Corners = [[f64; 3]; 2];

#[derive(Clone, Copy, Debug)]
struct Branch {
    corners: Corners,
    /// First item of a leaf, or index of the second child; the first child follows its parent.
    at: u32,
    /// Number of items in a leaf; zero for a branch.
    items: u32,
}

/// Branches of the tree, and the items in the order of its leaves.
#[derive(Clone, Debug, Default)]
pub(super) struct BoxTree {
    branches: Vec<Branch>,
    order: Vec<u32>,
}

/// The smallest box around some points.
pub(super) fn around<'a>(points: impl IntoIterator<Item = &'a [f64; 3]>) -> Corners {
    points.into_iter().fold([[f64::INFINITY; 3], [f64::NEG_INFINITY; 3]], |[low, high], p| {
        [std::array::from_fn(|k| low[k].min(p[k])), std::array::from_fn(|k| high[k].max(p[k]))]
    })
}

/// Square of the distance between a point and a box [m^2].
fn square_to(corners: &Corners, p: &[f64; 3]) -> f64 {
    (0..3).map(|k| (corners[0][k] - p[k]).max(p[k] - corners[1][k]).max(0.0).powi(2)).sum()
}

impl BoxTree {
    /// Builds a tree over these boxes; queries name an item by its index in `boxes`.
    pub(super) fn over(boxes: &[Corners]) -> Self {
        let mut tree = Self { branches: Vec::new(), order: (0..boxes.len() as u32).collect() };
        if !boxes.is_empty() {
            tree.grow(boxes, 0, boxes.len());
        }
        tree
    }

    fn grow(&mut self, boxes: &[Corners], from: usize, to: usize) {
        let of = |n: &u32| &boxes[*n as usize];
        let corners = around(self.order[from..to].iter().flat_map(&of));
        let here = self.branches.len();
        self.branches.push(Branch { corners, at: from as u32, items: (to - from) as u32 });
        if to - from <= LEAF {
            return;
        }
        let side = |k: usize| corners[1][k] - corners[0][k];
        let axis = (0..3).max_by(|a, b| side(*a).total_cmp(&side(*b))).unwrap_or_default();
        let middle = |n: &u32| of(n)[0][axis] + of(n)[1][axis];
        let half = from + (to - from) / 2;
        self.order[from..to].select_nth_unstable_by((to - from) / 2, |a, b| middle(a).total_cmp(&middle(b)));
        self.grow(boxes, from, half);
        self.branches[here].at = self.branches.len() as u32;
        self.branches[here].items = 0;
        self.grow(boxes, half, to);
    }

    /// Whether `holds` is true for any item whose box, widened by `wider_m`, contains the point.
    pub(super) fn any(&self, p: &[f64; 3], wider_m: f64, mut holds: impl FnMut(usize) -> bool) -> bool {
        self.any_below(0, p, wider_m * wider_m, &mut holds)
    }

    // these searches are recursive: a list of open branches would be allocated for every query
    fn any_below(&self, at: usize, p: &[f64; 3], square_m2: f64, holds: &mut impl FnMut(usize) -> bool) -> bool {
        let Some(branch) = self.branches.get(at) else { return false };
        if square_to(&branch.corners, p) > square_m2 {
            return false;
        }
        match branch.items {
            0 => self.any_below(at + 1, p, square_m2, holds) || self.any_below(branch.at as usize, p, square_m2, holds),
            count => self.order[branch.at as usize..(branch.at + count) as usize].iter().any(|n| holds(*n as usize)),
        }
    }

    /// The item nearest to a point, and the square of its distance; `square_m2` returns that square
    /// for one item.
    pub(super) fn nearest(&self, p: &[f64; 3], mut square_m2: impl FnMut(usize) -> f64) -> Option<(usize, f64)> {
        let mut best = None;
        self.nearest_below((0, 0.0), p, &mut square_m2, &mut best);
        best
    }

    /// Searches below the branch at index `at`, the square of whose distance is at least
    /// `least_m2`.
    fn nearest_below(
        &self,
        (at, least_m2): (usize, f64),
        p: &[f64; 3],
        square_m2: &mut impl FnMut(usize) -> f64,
        best: &mut Option<(usize, f64)>,
    ) {
        let Some(branch) = self.branches.get(at) else { return };
        if best.is_some_and(|(_, found)| least_m2 >= found) {
            return;
        }
        if branch.items == 0 {
            let mut children = [branch.at as usize, at + 1].map(|n| (n, square_to(&self.branches[n].corners, p)));
            // the nearer child is searched first; the second child if both are equally near
            if children[1].1 < children[0].1 {
                children.swap(0, 1);
            }
            children.into_iter().for_each(|child| self.nearest_below(child, p, square_m2, best));
            return;
        }
        for n in &self.order[branch.at as usize..(branch.at + branch.items) as usize] {
            let square = square_m2(*n as usize);
            if best.is_none_or(|(_, found)| square < found) {
                *best = Some((*n as usize, square));
            }
        }
    }
}
