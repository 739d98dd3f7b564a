//! The body-centred cubic lattice that organs are cut out of, uniform or growing away from a place.
//!
//! Its points are the integer triples that are all even or all odd, in units of half a cube's edge.
//! A point has 14 neighbours: 6 at the length of an edge (*long*), 8 at `sqrt(3)/2` of it
//! (*short*). Every tet has two opposite long edges and four short ones; 12 tets fill a cube.
//!
//! The lattice suits the springs: with the stiffness of paper 000, eq 11 (`k` proportional to the
//! number of tets on the edge, here 4 and 6) the uniform lattice is an exactly isotropic solid,
//! `C11 = 3 C12 = 3 C44`, so `lambda = mu` (nu = 1/4), of 1.008 times the requested Young's
//! modulus.
//!
//! In a growing lattice, a point at distance `rho` from the place is moved along its ray to `r = R
//! (1 + w + g (w^2 + w^3/3))`, with `w = rho/R - 1`, the fine radius `R` and the growth `g`; inside
//! `R` it is not moved. With `g = 1`, `r` is `R ((rho/R)^3 + 2)/3`. No radial map preserves angles:
//! at depth an element is up to three times as long along the ray as across.

use super::parts::V3;
use super::{Fine, OrganError};

/// Largest number of integer triples in a lattice's box, which fit easily into a desktop's memory.
const MOST_POINTS: usize = 8_000_000;

/// Steps to the neighbours of a point in half edges: the first 6 have the length of an edge, the
/// other 8 `sqrt(3)/2` of it.
pub(super) const NEIGHBOURS: [[i32; 3]; 14] = [
    [-2, 0, 0],
    [2, 0, 0],
    [0, -2, 0],
    [0, 2, 0],
    [0, 0, -2],
    [0, 0, 2],
    [-1, -1, -1],
    [1, -1, -1],
    [-1, 1, -1],
    [1, 1, -1],
    [-1, -1, 1],
    [1, -1, 1],
    [-1, 1, 1],
    [1, 1, 1],
];

/// Number of long edges in [`NEIGHBOURS`].
pub(super) const LONG: usize = 6;

/// The lattice points in a box; the name of a point is its index in the box.
pub(super) struct Lattice {
    pub spacing_m: f64,
    at: V3,
    growth: Option<Growth>,
    /// Lowest index along each axis, and the number of indices.
    low: [i32; 3],
    size: [usize; 3],
}

#[derive(Clone, Copy)]
struct Growth {
    radius: f64,
    factor: f64,
    /// Largest stretch along the ray (1).
    most: f64,
}

/// Why a lattice cannot be built; [`Refusal::of`] adds the name of the organ.
#[derive(Debug)]
pub(super) enum Refusal {
    Number { what: &'static str, value: f64, wanted: &'static str },
    TooFine { spacing_m: f64, points: f64 },
}

impl Lattice {
    /// Builds a lattice with one spacing everywhere in the box. A point lies in the middle of the
    /// box, or, for a `shift` of 0 to 1, up to half a spacing from it.
    pub fn uniform(spacing_m: f64, [low, high]: [[f64; 3]; 2], shift: f64) -> Result<Self, Refusal> {
        let (low, high) = (V3::from(low), V3::from(high));
        let half: [f64; 3] = (0.5 * (high - low)).into();
        // the shift is along no axis of the lattice
        let middle = 0.5 * (low + high) + 0.5 * shift * spacing_m * V3::new(1.0, 0.6, 0.3);
        Self::around(spacing_m, middle, None, [half, half])
    }

    /// Builds a lattice with spacing that grows away from a place. Elements along a ray are at most
    /// `coarsest_m` long.
    pub fn fine(fine: &Fine, coarsest_m: f64, [low, high]: [[f64; 3]; 2]) -> Result<Self, Refusal> {
        length("radius_m", fine.radius_m)?;
        if !(0.0..=100.0).contains(&fine.growth) {
            return Err(Refusal::Number { what: "growth", value: fine.growth, wanted: "0 to 100" });
        }
        if let Some(value) = fine.at_m.into_iter().find(|v| !(-10.0..=10.0).contains(v)) {
            return Err(Refusal::Number { what: "at_m", value, wanted: "a place in the organ's frame, in metres" });
        }
        let most = (coarsest_m / fine.spacing_m).max(1.0);
        let growth = Growth { radius: fine.radius_m, factor: fine.growth, most };
        let reach = [low, high].map(|corner| std::array::from_fn(|k| growth.unmoved((corner[k] - fine.at_m[k]).abs())));
        Self::around(fine.spacing_m, fine.at_m.into(), Some(growth), reach)
    }

    /// Builds a lattice around a point; `reach` is its extent below and above that point, before
    /// growth [m].
    fn around(spacing_m: f64, at: V3, growth: Option<Growth>, reach: [[f64; 3]; 2]) -> Result<Self, Refusal> {
        length("spacing_m", spacing_m)?;
        // three more, for the neighbours of every inner point and for the shift
        let steps = reach.map(|side| side.map(|r| (2.0 * r / spacing_m).ceil() + 3.0));
        let size: [f64; 3] = std::array::from_fn(|k| steps[0][k] + steps[1][k] + 1.0);
        let points = size[0] * size[1] * size[2];
        if points > MOST_POINTS as f64 {
            return Err(Refusal::TooFine { spacing_m, points });
        }
        Ok(Self { spacing_m, at, growth, low: steps[0].map(|s| -(s as i32)), size: size.map(|s| s as usize) })
    }

    /// Number of integer triples in the box, including those that are not lattice points.
    pub fn len(&self) -> usize {
        self.size.iter().product()
    }

    /// Position of a lattice point [m].
    pub fn place(&self, triple: [i32; 3]) -> V3 {
        let [i, j, k] = triple.map(f64::from);
        let from = 0.5 * self.spacing_m * V3::new(i, j, k);
        match self.growth {
            Some(growth) => self.at + from * growth.stretch(from.norm()),
            None => self.at + from,
        }
    }

    /// All lattice points, including those in the outer two layers, in rising order of their names.
    pub fn points(&self) -> impl Iterator<Item = [i32; 3]> {
        let [nx, ny, nz] = self.size.map(|n| n as i32);
        let [x, y, z] = self.low;
        let all = (x..x + nx).flat_map(move |i| (y..y + ny).flat_map(move |j| (z..z + nz).map(move |k| [i, j, k])));
        all.filter(|[i, j, k]| (i ^ j) & 1 == 0 && (j ^ k) & 1 == 0)
    }

    /// Name of a point; `None` outside the box.
    pub fn name(&self, triple: [i32; 3]) -> Option<u32> {
        let mut name = 0;
        for ((t, low), size) in triple.into_iter().zip(self.low).zip(self.size) {
            let place = usize::try_from(t - low).ok().filter(|p| *p < size)?;
            name = name * size + place;
        }
        Some(name as u32)
    }

    /// Point with this name.
    pub fn triple(&self, name: u32) -> [i32; 3] {
        let (name, [_, ny, nz]) = (name as usize, self.size);
        let places = [name / (ny * nz), name / nz % ny, name % nz];
        std::array::from_fn(|k| places[k] as i32 + self.low[k])
    }
}

/// The four tets around the long edge from an all-even `point` along an axis: every tet of the
/// lattice belongs to one such edge. Each is positively oriented, with the first two corners on one
/// long edge and the last two on the other.
pub(super) fn tets_around(point: [i32; 3], axis: usize) -> [[[i32; 3]; 4]; 4] {
    let (right, up) = ((axis + 1) % 3, (axis + 2) % 3);
    let at = |along: i32, u: i32, v: i32| {
        let mut triple = point;
        triple[axis] += along;
        triple[right] += u;
        triple[up] += v;
        triple
    };
    let ring = [(1, 1), (-1, 1), (-1, -1), (1, -1)].map(|(u, v)| at(1, u, v));
    std::array::from_fn(|k| [point, at(2, 0, 0), ring[k], ring[(k + 1) % 4]])
}

/// Parity that differs between the two ends of a long edge.
pub(super) fn is_even([i, j, k]: [i32; 3]) -> bool {
    (i + j + k).div_euclid(2) & 1 == 0
}

impl Growth {
    /// Ratio of the distance after the map to that before.
    fn stretch(self, before: f64) -> f64 {
        if before <= self.radius {
            return 1.0;
        }
        let w = before / self.radius - 1.0;
        // value of w at which the stretch along the ray, 1 + g (2 w + w^2), reaches its limit
        let limit = if self.factor > 0.0 { (1.0 + (self.most - 1.0) / self.factor).sqrt() - 1.0 } else { f64::INFINITY };
        let grown = w.min(limit);
        let beyond = if w > limit { self.most * (w - limit) } else { 0.0 };
        self.radius * (1.0 + grown + self.factor * grown * grown * (1.0 + grown / 3.0) + beyond) / before
    }

    /// Distance before the map of a point that the map brings to the distance `after`, by
    /// bisection.
    fn unmoved(self, after: f64) -> f64 {
        let (mut low, mut high) = (0.0, after);
        for _ in 0..60 {
            let middle = 0.5 * (low + high);
            if middle * self.stretch(middle) < after { low = middle } else { high = middle }
        }
        high
    }
}

impl Refusal {
    pub fn of(self, organ: &str) -> OrganError {
        let organ = organ.to_owned();
        match self {
            Self::Number { what, value, wanted } => OrganError::Number { organ, what, value, wanted },
            Self::TooFine { spacing_m, points } => OrganError::TooFine { organ, spacing_m, points, limit: MOST_POINTS },
        }
    }
}

fn length(what: &'static str, value: f64) -> Result<(), Refusal> {
    if (1e-5..=1.0).contains(&value) {
        Ok(())
    } else {
        Err(Refusal::Number { what, value, wanted: "a length of 0.00001 to 1 m" })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeMap;

    type Edge = [[i32; 3]; 2];

    /// Number of tets on every edge of a block of the lattice; only edges around its middle have
    /// all of their tets.
    fn tets_on_edges() -> BTreeMap<Edge, u32> {
        let mut count = BTreeMap::new();
        let range = || (-4..=4).step_by(2);
        for point in range().flat_map(|i| range().flat_map(move |j| range().map(move |k| [i, j, k]))) {
            for tet in (0..3).flat_map(|axis| tets_around(point, axis)) {
                for (n, a) in tet.iter().enumerate() {
                    for b in &tet[n + 1..] {
                        *count.entry([*a.min(b), *a.max(b)]).or_insert(0) += 1;
                    }
                }
            }
        }
        count
    }

    #[test]
    fn with_the_springs_of_eq_11_the_lattice_is_an_isotropic_cauchy_solid() {
        // Cauchy-Born: C_ijkl = 1/V sum over the springs of a cell of k l^2 n_i n_j n_k n_l; a cell
        // of edge 2 has 2 points, here those at 0 and (1,1,1)
        let tets = tets_on_edges();
        let volume = 8.0 / 12.0;
        let edge_length = (12.0 * volume / 2.0_f64.sqrt()).cbrt();
        let mut stiffness = BTreeMap::new();
        for point in [[0, 0, 0], [1, 1, 1]] {
            for step in NEIGHBOURS {
                let other: [i32; 3] = std::array::from_fn(|k| point[k] + step[k]);
                let on_edge = f64::from(tets[&[point.min(other), point.max(other)]]);
                let k = on_edge * 2.0 * 2.0_f64.sqrt() / 25.0 * edge_length;
                let n = step.map(f64::from);
                let square: f64 = n.iter().map(|c| c * c).sum();
                for index in 0..81 {
                    let axes = [index / 27, index / 9 % 3, index / 3 % 3, index % 3];
                    // half: each spring is counted from both of its ends
                    let part = 0.5 * k * axes.iter().map(|a| n[*a]).product::<f64>() / square / 8.0;
                    *stiffness.entry(axes).or_insert(0.0) += part;
                }
            }
        }
        let (c11, c12, c44) = (stiffness[&[0, 0, 0, 0]], stiffness[&[0, 0, 1, 1]], stiffness[&[0, 1, 0, 1]]);
        assert!((c11 - 3.0 * c12).abs() < 1e-12 && (c44 - c12).abs() < 1e-12, "{c11} {c12} {c44}");
        assert!(stiffness[&[0, 0, 0, 1]].abs() < 1e-12 && stiffness[&[0, 0, 1, 2]].abs() < 1e-12);
        // E = mu (3 lambda + 2 mu)/(lambda + mu), lambda = mu
        assert!((2.5 * c44 - 1.008).abs() < 5e-4, "E_eff/E = {}", 2.5 * c44);
    }

    #[test]
    fn names_and_triples_are_inverse_and_rise() {
        let lattice = Lattice::uniform(0.3, [[0.0; 3], [1.0, 0.7, 0.5]], 0.0).unwrap();
        let names: Vec<u32> = lattice.points().map(|t| lattice.name(t).unwrap()).collect();
        assert!(names.is_sorted_by(|a, b| a < b));
        assert!(lattice.points().zip(&names).all(|(t, n)| lattice.triple(*n) == t));
        assert!(lattice.name([1000, 0, 0]).is_none());
    }

    #[test]
    fn growth_is_smooth_at_the_fine_radius_and_inverted_by_unmoved() {
        let growth = Growth { radius: 0.01, factor: 1.0, most: f64::INFINITY };
        for after in [0.004, 0.01, 0.0101, 0.05, 0.2] {
            let before = growth.unmoved(after);
            assert!((before * growth.stretch(before) - after).abs() < 1e-12);
        }
        // R ((rho/R)^3 + 2)/3 at rho = 2 R
        assert!((0.02 * growth.stretch(0.02) - 0.01 * 10.0 / 3.0).abs() < 1e-15);
    }

    #[test]
    fn a_stretch_at_its_limit_stays_there() {
        let growth = Growth { radius: 0.01, factor: 1.0, most: 4.0 };
        let slope = |at: f64| ((at + 1e-6) * growth.stretch(at + 1e-6) - (at - 1e-6) * growth.stretch(at - 1e-6)) / 2e-6;
        // the stretch along the ray is (rho/R)^2, until it reaches 4
        for (at, expected) in [(0.005, 1.0), (0.015, 2.25), (0.0199, 3.9601), (0.021, 4.0), (0.1, 4.0)] {
            assert!((slope(at) - expected).abs() < 1e-6, "{at}: {}", slope(at));
        }
    }
}
