//! A tree of axis-aligned boxes over triangles or tetrahedra: queries for the nearest item and for
//! an item that contains a point.

/// Items in a leaf at most.
const LEAF: usize = 4;

/// Lower and upper corner of a box [m].
pub(super) type Corners = [[f64; 3]; 2];

#[derive(Clone, Copy, Debug)]
struct Branch {
    corners: Corners,
    /// First item of a leaf, or index of the second child; the first child follows its parent.
    at: u32,
    /// Items of a leaf; zero for a branch.
    items: u32,
}

/// The tree.
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
    /// A tree over these boxes; queries name an item by its index in `boxes`.
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

    /// Whether `holds` is true of an item whose box, widened by `wider_m`, contains the point.
    pub(super) fn any(&self, p: &[f64; 3], wider_m: f64, mut holds: impl FnMut(usize) -> bool) -> bool {
        let mut open = vec![0_usize];
        while let Some(at) = open.pop() {
            let Some(branch) = self.branches.get(at) else { continue };
            if square_to(&branch.corners, p) > wider_m * wider_m {
                continue;
            }
            match branch.items {
                0 => open.extend([branch.at as usize, at + 1]),
                count => {
                    let items = &self.order[branch.at as usize..(branch.at + count) as usize];
                    if items.iter().any(|n| holds(*n as usize)) {
                        return true;
                    }
                }
            }
        }
        false
    }

    /// The item nearest to a point and the square of its distance; `square_m2` measures one item.
    pub(super) fn nearest(&self, p: &[f64; 3], mut square_m2: impl FnMut(usize) -> f64) -> Option<(usize, f64)> {
        let mut best: Option<(usize, f64)> = None;
        let mut open = vec![(0_usize, 0.0)];
        while let Some((at, least)) = open.pop() {
            let Some(branch) = self.branches.get(at) else { continue };
            if best.is_some_and(|(_, found)| least >= found) {
                continue;
            }
            if branch.items == 0 {
                let mut children = [at + 1, branch.at as usize].map(|n| (n, square_to(&self.branches[n].corners, p)));
                // the nearer child is opened first: it is pushed last
                children.sort_by(|a, b| b.1.total_cmp(&a.1));
                open.extend(children);
                continue;
            }
            for n in &self.order[branch.at as usize..(branch.at + branch.items) as usize] {
                let square = square_m2(*n as usize);
                if best.is_none_or(|(_, found)| square < found) {
                    best = Some((*n as usize, square));
                }
            }
        }
        best
    }
}
