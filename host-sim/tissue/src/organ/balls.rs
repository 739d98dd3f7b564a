//! Balls that a distance is known to keep on one side of the surface: deep inside a body, where
//! many triangles are about equally near, a distance takes the longest to find.

use super::parts::V3;

/// Largest number of balls that are kept.
const MOST: usize = 16;
/// Share of a distance within which a point is on the same side, rounding included (1).
const SAME_SIDE: f64 = 0.999;

pub(super) struct Balls {
    of_distance: bool,
    /// Centre of each, and the distance there [m], the largest first.
    known: Vec<(V3, f64)>,
}

impl Balls {
    /// For an implicit function that is a distance or, if not `of_distance`, any other, of which
    /// nothing is known.
    pub fn new(of_distance: bool) -> Self {
        Self { of_distance, known: Vec::new() }
    }

    /// The function at a place, or for a distance a value of the same sign that is nearer to zero.
    pub fn value_m(&mut self, at: V3, implicit_m: &dyn Fn(V3) -> f64) -> f64 {
        let within = |(centre, distance_m): &(V3, f64)| {
            let left_m = SAME_SIDE * distance_m.abs() - (at - centre).norm();
            (left_m > 0.0).then(|| left_m.copysign(*distance_m))
        };
        if let Some(value_m) = self.known.iter().find_map(within) {
            return value_m;
        }
        let value_m = implicit_m(at);
        if self.of_distance {
            let place = self.known.partition_point(|(_, known_m)| known_m.abs() > value_m.abs());
            self.known.insert(place, (at, value_m));
            self.known.truncate(MOST);
        }
        value_m
    }
}
