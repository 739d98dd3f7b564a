//! The half sphere under the top face, along which a patch will be cut out of the block.
//!
//! Some nodes are held on this shell and the others are kept off it, so that Delaunay tets respect
//! it: each tet is then inside or outside, never both.

use super::grading::Grading;
use super::seed::{Domain, Side, points};
use super::vector::{Vec3, add_scaled, distance, sub};
use std::f64::consts::PI;

/// Half the thickness, in shell radii, of the layer whose points are projected onto the shell to
/// sample it.
const LAYER: f64 = 0.125;
/// Number of points that sample the element size on the shell.
const SAMPLES: usize = 1024;

impl Grading {
    /// Distance to the spot.
    pub fn away(&self, p: Vec3) -> f64 {
        distance(p, self.spot)
    }

    /// Largest element that fits twice between shell and wall at `p`; infinite without a shell.
    pub fn room(&self, p: Vec3) -> f64 {
        match self.shell {
            Some(radius) => 0.5 * (self.wall_distance(p) + (self.away(p) - radius).abs()),
            None => f64::INFINITY,
        }
    }

    /// Distance to the nearest of the four sides and the bottom.
    fn wall_distance(&self, p: Vec3) -> f64 {
        let sides = (0..2).map(|k| (p[k] - self.low[k]).min(self.high[k] - p[k]));
        sides.fold(p[2] - self.low[2], f64::min)
    }

    /// Size of the smallest element anywhere.
    pub fn least_size(&self) -> f64 {
        let gap = self.shell.map_or(f64::INFINITY, |radius| self.wall_distance(self.spot) - radius);
        self.fine_size.min(0.5 * gap)
    }

    /// Side of the shell on which `p` lies; never `Shell`, which is assigned to nodes explicitly.
    pub fn side_of(&self, p: Vec3) -> Side {
        if self.shell.is_some_and(|radius| self.away(p) < radius) { Side::Inside } else { Side::Outside }
    }

    /// Moves `p` radially: onto the shell, or to at least `off` from it on the given side.
    pub fn hold(&self, side: Side, p: Vec3, off: f64) -> Vec3 {
        let Some(radius) = self.shell else { return p };
        let away = self.away(p);
        let target = match side {
            Side::Shell => radius,
            Side::Inside => away.min(radius - off.min(0.5 * radius)),
            Side::Outside => away.max(radius + off),
        };
        if target == away || away == 0.0 {
            return p;
        }
        add_scaled(self.spot, target / away, sub(p, self.spot))
    }

    /// Point of the shell nearest to `p`, if `p` is close to the shell.
    pub fn near_shell(&self, p: Vec3) -> Option<Vec3> {
        let radius = self.shell?;
        ((self.away(p) - radius).abs() < LAYER * radius).then(|| self.hold(Side::Shell, p, 0.0))
    }

    /// Corners of a box around all points that [`Self::near_shell`] accepts.
    pub fn shell_box(&self) -> [Vec3; 2] {
        let reach = self.shell.unwrap_or(0.0) * (1.0 + LAYER);
        [self.spot.map(|x| x - reach), [self.spot[0] + reach, self.spot[1] + reach, self.spot[2]]]
    }

    /// Numbers of elements along the circle where the shell meets the top face, and on the shell's
    /// area.
    pub fn shell_elements(&self) -> [f64; 2] {
        let radius = self.shell.unwrap_or(0.0);
        let mean = |domain: Domain, power: i32| {
            let sum: f64 = points(self, domain, 0, SAMPLES).map(|p| self.size_at(p).powi(-power)).sum();
            sum / SAMPLES as f64
        };
        let circle = 2.0 * PI * radius * mean(Domain::Circle, 1);
        let area = 2.0 * PI * radius * radius * mean(Domain::Shell, 2);
        [circle, area]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn off_centre() -> Grading {
        Grading {
            low: [-0.5, -0.5, -0.5],
            high: [0.5, 0.5, 0.0],
            spot: [0.1, 0.0, 0.0],
            shell: Some(0.2),
            fine_radius: 0.1,
            fine_size: 0.05,
            growth: 0.4,
        }
    }

    #[test]
    fn a_shell_node_lands_on_the_half_sphere_and_others_stay_off_it() {
        let grading = off_centre();
        for p in [[0.05, 0.02, -0.1], [0.45, 0.1, -0.3], [-0.3, -0.2, 0.0], [0.12, 0.15, -0.14]] {
            let on = grading.hold(Side::Shell, p, 0.0);
            assert!((grading.away(on) - 0.2).abs() < 1e-15);
            assert_eq!(on[2] == 0.0, p[2] == 0.0, "a node of the top face stays there");
            assert!(grading.away(grading.hold(Side::Inside, p, 0.03)) < 0.17 + 1e-15);
            assert!(grading.away(grading.hold(Side::Outside, p, 0.03)) > 0.23 - 1e-15);
        }
    }

    #[test]
    fn shell_elements_are_length_and_area_over_the_size() {
        // The size is .05 + .4 * .1 on the whole shell; walls this far away do not limit it.
        let grading = Grading { low: [-1.0; 3], high: [1.0, 1.0, 0.0], ..off_centre() };
        let [circle, area] = grading.shell_elements();
        let size = 0.09;
        assert!((circle * size - 0.4 * PI).abs() < 1e-9);
        assert!((area * size * size - 0.08 * PI).abs() < 1e-9);
    }

    #[test]
    fn two_elements_fit_between_shell_and_wall() {
        let grading = Grading { fine_size: 0.3, ..off_centre() };
        // The nearest wall is at x = .5; the shell ends at .3.
        for i in 0..=10 {
            let p = [0.3 + 0.02 * f64::from(i), 0.0, 0.0];
            assert!(grading.size_at(p) < 0.1 + 1e-12);
        }
        assert!((grading.least_size() - 0.1).abs() < 1e-12);
    }
}
