//! Finds the uniform spacing and the position of the lattice that give a wanted number of tets.

use super::lattice::Lattice;
use super::parts::V3;
use super::{Organ, OrganError, sound, stuffing};
use crate::mesh::TetMesh;

/// Largest accepted deviation from the wanted number (1).
const WORST_SHARE: f64 = 0.1;
/// Deviation at which the search stops (1).
const GOOD_SHARE: f64 = 0.004;
/// Number of bisections of the spacing.
const HALVINGS: u32 = 10;
/// Number of spacings that are then tried around the result: the number of tets jumps by a percent
/// from one to the next.
const TRIES: u32 = 64;
/// Half-width of the range of these spacings, as a share of the result (1).
const WINDOW: f64 = 0.03;
/// Shift of the lattice from one of these spacings to the next, as a share of the spacing: on a
/// symmetric shape whole layers would otherwise appear and vanish at once.
const SHIFT: f64 = 0.382;
/// Number of samples along each axis for the volume.
const GRID: u32 = 48;

impl Organ {
    pub(super) fn counted(&self, wanted: usize) -> Result<TetMesh, OrganError> {
        if wanted == 0 {
            let organ = self.name.to_owned();
            return Err(OrganError::Number { organ, what: "number of tets", value: 0.0, wanted: "one or more" });
        }
        // twelve tets fill a cube of the lattice; tets that are cut at the surface add some
        let guess_m = (12.0 * self.volume_m3() / wanted as f64).cbrt();
        let (mut low, mut high) = (0.8 * guess_m, 2.0 * guess_m);
        let mut best = Best { wanted, mesh: None, nearest: 0 };
        for _ in 0..HALVINGS {
            let middle = 0.5 * (low + high);
            if best.offer(self.unchecked(middle, 0.0)?) > wanted { low = middle } else { high = middle }
        }
        let around_m = 0.5 * (low + high);
        for i in 0..=TRIES {
            if best.is_good() {
                break;
            }
            let share = 2.0 * f64::from(i) / f64::from(TRIES) - 1.0;
            best.offer(self.unchecked(around_m * (1.0 + WINDOW * share), (f64::from(i) * SHIFT).fract())?);
        }
        best.off().filter(|off| *off <= WORST_SHARE).and(best.mesh).ok_or_else(|| OrganError::Count {
            organ: self.name.to_owned(),
            wanted,
            nearest: best.nearest,
        })
    }

    /// Mesh for a spacing and a shift of the lattice, with unchecked topology; `None` if nothing of
    /// the organ is left or tets are inverted.
    fn unchecked(&self, spacing_m: f64, shift: f64) -> Result<Option<TetMesh>, OrganError> {
        let lattice = Lattice::uniform(spacing_m, self.box_m, shift).map_err(|refusal| refusal.of(self.name))?;
        match stuffing::cut_out(self.name, &self.implicit, &lattice) {
            Ok(mesh) => Ok(Some(mesh)),
            Err(OrganError::Empty { .. } | OrganError::Inverted { .. }) => Ok(None),
            Err(other) => Err(other),
        }
    }

    /// Volume of the organ [m^3], within one percent, from the boxes of a grid whose centres are
    /// inside.
    fn volume_m3(&self) -> f64 {
        let [low, high] = self.box_m.map(V3::from);
        let cell = (high - low) / f64::from(GRID);
        let centre = |i: u32| f64::from(i) + 0.5;
        let triples =
            (0..GRID).flat_map(|i| (0..GRID).flat_map(move |j| (0..GRID).map(move |k| V3::new(centre(i), centre(j), centre(k)))));
        let inside = triples.filter(|t| self.value(low + cell.component_mul(t)) < 0.0).count();
        inside as f64 * cell.product()
    }
}

/// The sound mesh whose number of tets is nearest to the wanted number.
struct Best {
    wanted: usize,
    mesh: Option<TetMesh>,
    nearest: usize,
}

impl Best {
    /// Keeps a mesh if it is sound and better than the last; returns its number of tets in any
    /// case.
    fn offer(&mut self, mesh: Option<TetMesh>) -> usize {
        let Some(mesh) = mesh else { return 0 };
        let tets = mesh.tets.len();
        let better = self.mesh.is_none() || tets.abs_diff(self.wanted) < self.nearest.abs_diff(self.wanted);
        if better && sound::defect(&mesh.tets).is_none() {
            self.nearest = tets;
            self.mesh = Some(mesh);
        }
        tets
    }

    fn off(&self) -> Option<f64> {
        self.mesh.as_ref().map(|_| self.nearest.abs_diff(self.wanted) as f64 / self.wanted as f64)
    }

    fn is_good(&self) -> bool {
        self.off().is_some_and(|off| off <= GOOD_SHARE)
    }
}
