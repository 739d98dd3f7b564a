//! The method without nodes: a law that gives the force from the tip's place, depth and speed.
//!
//! Where tissue and tip are those that the law was fitted to, nothing else is needed: no node, no
//! spring, no step that could be unstable. The guard, the presence and the output of a tick are
//! those of a patch; of the mesh they need only the rest shape, a dozen tets.
//!
//! Over Young's modulus, with the depth d of the tip below the height h(x, y) at which it touches,
//! and the outward `n = (-dh/dx, -dh/dy, 1)`:
//!
//! ```text
//! held    -grad U,  dU/dd = d^(3/2) (a0 + a1 d + a2 d^2 + a3 d^3),  a and h splines over (x, y)
//! moving  + n sum c g (g u - z),  g^2 = sqrt(d) or d
//! ```
//! u is the tip's speed into the tissue over `w = sqrt(E / density)`. Each branch is a dashpot c
//! (radiation, Lysmer and Richart 1966) that leads to a rod of tissue with the same impedance, a
//! length L and a free end, whose near end moves at z: what was radiated comes back after `2 L /
//! w`. The rod is a chain of `LUMPS` equal masses, which the node damping alpha holds back, and
//! the springs between them. With L infinite it is at rest, and the branch a dashpot to the ground.
//! One mass instead of a rod is 0.3 % of the peak worse; springs in series with dashpots, fitted
//! with non-negative constants, vanish.
//!
//! Tissue that relaxes has Maxwell branches on `q = sqrt(2 U)`: the held force is multiplied by
//! `1 - sum g s / q` with `s' = (q - s) / tau`. Held, this is the Prony series of a patch.
//!
//! **Passive by construction**: the held part has a potential, and every c, L, alpha and share is
//! non-negative, so that dashpots dissipate what springs and masses do not store. The tissue never
//! pulls. Where it would, the tip has left it: then the rods are not driven, and the relaxing
//! branches follow the tissue's own surface, not the tip.
//!
//! Beyond the places of the table the law answers as at its edge, and a limiter flag says so;
//! beyond the depth limit acts the guard.
//!
//! * in: the shown tip and its speed
//! * out: the probe's load on the tissue
//! * cost: about 60 floating-point operations, 70 more for a branch with a rod, 200 more for a
//!   table
//! * failures: none

use nalgebra::Vector3;

use crate::lanes::sqrt;
use crate::law::{FIELDS, Law, LawShape, MOST_BRANCHES};
use crate::model::Model;
use crate::params::{MOST_TERMS, Tuned};
use crate::stages::force::foundation::Load;
use crate::state::State;

/// Number of masses of a rod: with three, a tap is 0.1 % of its peak worse.
const LUMPS: usize = 4;
/// Number of nodes that keep a rod.
const NODES: usize = 2;

/// Rod of a branch, in the branch's coordinate.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Rod {
    /// Velocity of each mass over w; the first is the near end.
    moves: [f32; LUMPS],
    /// Force with which the mass before pushes each mass, over c; not used at the first.
    pushes: [f32; LUMPS],
}

impl Rod {
    /// Moves and pushes of the masses that one node keeps.
    #[inline]
    fn pairs(&mut self) -> impl Iterator<Item = (&mut [f32; LUMPS / NODES], &mut [f32; LUMPS / NODES])> {
        self.moves.as_chunks_mut().0.iter_mut().zip(self.pushes.as_chunks_mut().0)
    }

    /// Moves the rod by a step of `share` masses' crossing times, with the dashpot's other end at
    /// `drive`; `slow` is one plus the damping of the step. Returns the speed of the near end.
    /// Backward Euler, which is passive for every step: the chain is eliminated from its far end.
    // inlined, it would take kilobytes of a board's flash
    #[cfg_attr(target_os = "none", inline(never))]
    fn step(&mut self, share: f32, slow: f32, drive: f32) -> f32 {
        let square = share * share;
        let Self { moves, pushes } = self;
        let (mut weight, mut sum) = (slow, moves[LUMPS - 1]);
        let mut after = [[0.0; 2]; LUMPS];
        for n in (1..LUMPS).rev() {
            let part = 1.0 / (weight + square);
            let own = sum + share * pushes[n];
            after[n] = [part, own];
            sum = moves[n - 1] - share * pushes[n] + square * own * part;
            weight = slow + square * weight * part;
        }
        let mut before = (sum + share * drive) / (weight + share);
        moves[0] = before;
        for n in 1..LUMPS {
            let [part, own] = after[n];
            moves[n] = (own + square * before) * part;
            pushes[n] += share * (before - moves[n]);
            before = moves[n];
        }
        moves[0]
    }
}

/// Memory of a law, from one tick to the next.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct LawMemory {
    /// Rod of each branch.
    rods: [Rod; MOST_BRANCHES],
    /// Faded part of the coordinate of the held force, term by term, with its sign reversed.
    faded: [f32; MOST_TERMS],
}

/// Values of the splines at a place, and their slopes along x and y.
struct At {
    value: [f32; FIELDS],
    slopes: [[f32; FIELDS]; 2],
    beyond: bool,
}

impl Law<'_> {
    /// Splines at a place relative to the origin [m]. Beyond the disc, the place is the nearest one
    /// on its edge.
    // inlined, it would take kilobytes of a board's flash
    #[cfg_attr(target_os = "none", inline(never))]
    fn at(&self, mut place_m: [f32; 2]) -> At {
        let LawShape { reach_m, side, .. } = *self.shape;
        let [x, y] = place_m;
        let square = x * x + y * y;
        let beyond = square > reach_m * reach_m;
        let first = self.table.first().copied().unwrap_or_default();
        let mut at = At { value: first, slopes: [[0.0; FIELDS]; 2], beyond };
        if side == 1 {
            return at;
        }
        let away_m = if beyond { sqrt(square) } else { reach_m };
        let nearer = reach_m / away_m;
        place_m = [x * nearer, y * nearer];
        let per_m = (side - 3) as f32 / (2.0 * reach_m);
        let [(column, wx, dx), (row, wy, dy)] = place_m.map(|m| weights((m + reach_m) * per_m, side - 4));
        at.value = [0.0; FIELDS];
        // not a constant: unrolled, the sum would take a kilobyte of a board's flash
        let four = (side as usize).min(4);
        for ((n, wy), dy) in (row..).zip(wy).zip(dy).take(four) {
            let rows = self.table.get(n * side as usize + column..).unwrap_or_default();
            for ((values, wx), dx) in rows.iter().zip(wx).zip(dx).take(four) {
                let (w, along, across) = (wx * wy, dx * wy * per_m, wx * dy * per_m);
                for (k, value) in values.iter().enumerate() {
                    at.value[k] += w * value;
                    at.slopes[0][k] += along * value;
                    at.slopes[1][k] += across * value;
                }
            }
        }
        if beyond {
            // the answer is that of the edge, so only the motion along the edge changes it
            let [x, y] = [x / away_m, y / away_m];
            for k in 0..FIELDS {
                let around = (at.slopes[1][k] * x - at.slopes[0][k] * y) * nearer;
                (at.slopes[0][k], at.slopes[1][k]) = (-around * y, around * x);
            }
        }
        at
    }

    /// The probe's load on the tissue.
    #[cfg_attr(target_os = "none", inline(never))]
    pub(crate) fn load(
        &self,
        model: &Model,
        tuned: &Tuned,
        state: &mut State,
        tip_m: Vector3<f32>,
        m_per_s: Vector3<f32>,
    ) -> Load {
        let (axis, along) = (tuned.probe.axis, Vector3::from(self.shape.along));
        let across = axis.cross(&along);
        let from_m = tip_m - Vector3::from(self.shape.origin_m);
        let at = self.at([from_m.dot(&along), from_m.dot(&across)]);
        let [dx, dy] = at.slopes;
        let d = at.value[0] - from_m.dot(&axis);
        let mut memory = LawMemory::of(state);
        let under = if d > 0.0 { under(model, state, tip_m, axis) } else { None };
        let Some(triangle) = under else {
            self.rest(tuned, &mut memory);
            memory.keep(state);
            return Load::NONE;
        };
        let outward = axis - along * dx[0] - across * dy[0];
        let sink = -m_per_s.dot(&outward) * per_wave(tuned);
        let (push, share) = self.push(tuned, &mut memory, &at.value, d, sink);
        memory.keep(state);
        if push <= 0.0 {
            return Load::NONE;
        }
        let aside = (along * energy(&dx, d) + across * energy(&dy, d)) * share;
        Load {
            force: aside - outward * push,
            push,
            point: tip_m * push,
            rest: (tip_m + axis * d) * push,
            strongest: (push, triangle),
            limited: at.beyond,
            ..Load::NONE
        }
    }

    /// Push along n over E [m^2], zero or less if the tissue has lost the tip, and the share of the
    /// held force that is left (1), with the tip `d` deep and sinking at `sink` over w.
    // inlined, it would take kilobytes of a board's flash
    #[cfg_attr(target_os = "none", inline(never))]
    fn push(&self, tuned: &Tuned, memory: &mut LawMemory, at: &[f32; FIELDS], d: f32, sink: f32) -> (f32, f32) {
        let [_, a0, a1, a2, a3] = at;
        let root = sqrt(d);
        let held = d * root * (a0 + d * (a1 + d * (a2 + d * a3)));
        let share = if tuned.relaxes() { memory.fade(tuned, sqrt(2.0 * energy(at, d))) } else { 1.0 };
        let before = memory.rods;
        let push = held * share + self.drive(tuned, &mut memory.rods, [sqrt(root), root], sink);
        if share < 0.0 || push <= 0.0 && sink < 0.0 {
            // a tip that has left the tissue, or has not met it again, does not move its rods
            memory.rods = before;
            self.drift(tuned, &mut memory.rods);
            return (0.0, share);
        }
        (push, share)
    }

    /// Moves the rods with a tip that sinks at this speed over w; returns the sum of their pushes
    /// over E [m^2].
    // inlined, it would take kilobytes of a board's flash
    #[cfg_attr(target_os = "none", inline(never))]
    fn drive(&self, tuned: &Tuned, rods: &mut [Rod; MOST_BRANCHES], [low, high]: [f32; 2], sink: f32) -> f32 {
        let (mut push, waves_m) = (0.0, LUMPS as f32 * tuned.substep_s / per_wave(tuned));
        for ((branch, rod), g) in self.shape.branches.iter().zip(rods).zip([low, low, high, high]) {
            if branch.c > 0.0 {
                let z = rod.step(waves_m / branch.length_m, 2.0 - tuned.keep, g * sink);
                push += branch.c * g * (g * sink - z);
            }
        }
        push
    }

    /// Slows the rods of a surface that the tip does not touch.
    #[inline]
    fn drift(&self, tuned: &Tuned, rods: &mut [Rod; MOST_BRANCHES]) {
        self.drive(tuned, rods, [0.0; 2], 0.0);
    }

    /// One tick without contact.
    #[inline]
    fn rest(&self, tuned: &Tuned, memory: &mut LawMemory) {
        self.drift(tuned, &mut memory.rods);
        if tuned.relaxes() {
            memory.fade(tuned, 0.0);
        }
    }
}

/// One over the speed of the tissue's waves, `sqrt(density / E)` [s/m].
#[inline]
fn per_wave(tuned: &Tuned) -> f32 {
    sqrt(tuned.density_rate * tuned.substep_s)
}

/// Energy of the held force over E [m^3] at a depth, or its slope, of these values of the splines
/// or of their slopes.
// inlined, it would take kilobytes of a board's flash
#[cfg_attr(target_os = "none", inline(never))]
fn energy([_, a0, a1, a2, a3]: &[f32; FIELDS], d: f32) -> f32 {
    let mean = a0 * (1.0 / 2.5) + d * (a1 * (1.0 / 3.5) + d * (a2 * (1.0 / 4.5) + d * (a3 * (1.0 / 5.5))));
    d * d * sqrt(d) * mean
}

impl LawMemory {
    /// Reads the memory that the last tick kept in a state.
    #[inline]
    fn of(state: &State) -> Self {
        let mut memory = Self::default();
        for (rod, nodes) in memory.rods.iter_mut().zip(state.nodes.chunks(NODES)) {
            for ((moves, pushes), node) in rod.pairs().zip(nodes) {
                let ([a, b, ..], [c, d, ..]) = (node.v, node.pass);
                (*moves, *pushes) = ([a, b], [c, d]);
            }
        }
        if let Some(faded) = state.faded.first() {
            memory.faded = faded.0.map(|row| row[0]);
        }
        memory
    }

    /// Keeps the memory: the rods in the first nodes, which do not move, and what has faded at the
    /// first node.
    #[inline]
    fn keep(&mut self, state: &mut State) {
        for (rod, nodes) in self.rods.iter_mut().zip(state.nodes.chunks_mut(NODES)) {
            for ((moves, pushes), node) in rod.pairs().zip(nodes) {
                (node.v[0], node.v[1]) = (moves[0], moves[1]);
                (node.pass[0], node.pass[1]) = (pushes[0], pushes[1]);
            }
        }
        if let Some(faded) = state.faded.first_mut() {
            for (row, s) in faded.0.iter_mut().zip(self.faded) {
                row[0] = s;
            }
        }
    }

    /// Lets the branches of relaxation follow the coordinate q of the held force, or that of the
    /// tissue's own surface where the tip has left it; returns the share of the held force that
    /// acts (1), which is negative there.
    // inlined, it would take kilobytes of a board's flash
    #[cfg_attr(target_os = "none", inline(never))]
    fn fade(&mut self, tuned: &Tuned, q: f32) -> f32 {
        let prony = &tuned.prony;
        let faded: f32 = self.faded.iter().sum();
        let left = prony.at_once * q + faded;
        let surface = if left < 0.0 { -faded / prony.at_once } else { q };
        for ((s, rise), fade) in self.faded.iter_mut().zip(prony.rises).zip(prony.fades) {
            *s -= fade * (*s + rise * surface);
        }
        if q > 0.0 { left / q } else { 0.0 }
    }
}

/// First control value, weights and slopes of the four values around `t`, in cells; `last` is the
/// last cell.
#[inline]
fn weights(t: f32, last: u32) -> (usize, [f32; 4], [f32; 4]) {
    let whole = (t as u32).min(last);
    let f = t - whole as f32;
    let (e, f2) = (1.0 - f, f * f);
    let w = [e * e * e, 4.0 + f2 * (3.0 * f - 6.0), 1.0 + 3.0 * f * (1.0 + f * e), f * f2].map(|w| w * (1.0 / 6.0));
    let slopes = [-0.5 * e * e, f * (1.5 * f - 2.0), 0.5 + f - 1.5 * f2, 0.5 * f2];
    (whole as usize, w, slopes)
}

/// Surface triangle near the probe that the tip is above or below; the one of the last tick first.
#[inline]
fn under(model: &Model, state: &State, tip_m: Vector3<f32>, axis: Vector3<f32>) -> Option<u16> {
    let contains = |index: &u16| {
        let corners = model.triangles.get(usize::from(*index)).map(|triangle| {
            triangle.node.map(|n| model.nodes.get(usize::from(n)).map_or(tip_m, |node| Vector3::from(node.rest_m)) - tip_m)
        });
        corners.is_some_and(|[a, b, c]| [(a, b), (b, c), (c, a)].iter().all(|(from, to)| from.cross(to).dot(&axis) >= 0.0))
    };
    let mut near = state.candidates.iter().take(state.near).copied();
    let last = state.over.filter(|over| state.near > 0 && contains(over));
    last.or_else(|| near.find(contains))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::law::Branch;
    use crate::params::{Params, PronyTerm};

    const AT: [f32; FIELDS] = [0.0, 0.153, 3.3, -764.0, 35_800.0];

    /// Energy stored over E [m^3]: of the masses, and of the held force with its Maxwell branches
    /// on the tissue's own surface.
    fn stored(law: &Law, tuned: &Tuned, memory: &LawMemory, d: f32) -> f32 {
        let prony = &tuned.prony;
        let q = if d > 0.0 { sqrt(2.0 * energy(&AT, d)) } else { 0.0 };
        let free = -memory.faded.iter().sum::<f32>() / prony.at_once;
        let q = if free > q { free } else { q };
        let masses = law.shape.branches.iter().zip(memory.rods).filter(|(branch, _)| branch.c > 0.0);
        let squares = |values: &[f32]| values.iter().map(|value| value * value).sum::<f32>();
        let rod = |(branch, rod): (&Branch, Rod)| {
            branch.c * branch.length_m / LUMPS as f32 * (squares(&rod.moves) + squares(&rod.pushes))
        };
        let masses: f32 = masses.map(rod).sum();
        let springs = memory.faded.iter().zip(prony.rises).filter(|(_, rise)| *rise > 0.0);
        let springs: f32 = springs.map(|(s, rise)| (s + rise * q) * (s + rise * q) / rise).sum();
        0.5 * (prony.stays * q * q + masses + springs)
    }

    #[test]
    fn every_tick_stores_at_most_the_work_that_it_takes() {
        let branch = |c, length_m| Branch { c, length_m };
        let shape = LawShape {
            origin_m: [0.0; 3],
            along: [1.0, 0.0, 0.0],
            reach_m: 12e-3,
            side: 1,
            branches: [branch(6.5e-4, 48e-3), branch(0.0, 1.0), branch(19e-3, 48e-3), branch(4e-3, 5e-3)],
        };
        let law = Law { shape: &shape, table: &[AT] };
        let term = |share, time_s| PronyTerm { share, time_s };
        for relaxation in [[PronyTerm::NONE; MOST_TERMS], [term(0.3, 0.004), term(0.3, 0.05), term(0.2, 1.0)]] {
            let tuned = Params { relaxation, ..Params::default() }.derive(&mut [], [0.0; 4]);
            let (mut memory, mut d, mut seed, mut lost) = (LawMemory::default(), -1e-3, 1_u32, 0);
            for _ in 0..20_000 {
                seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
                let to = f32::from((seed >> 16) as u16) * (7e-3 / 65_536.0) - 2e-3;
                // jerks, and now and then a slow way
                let next = if seed & 0x7000 == 0 { to } else { d + (to - d) * 0.02 };
                let sink = (next - d) / (tuned.substep_s / per_wave(&tuned));
                let before = stored(&law, &tuned, &memory, d);
                let push = if next > 0.0 {
                    law.push(&tuned, &mut memory, &AT, next, sink).0
                } else {
                    law.rest(&tuned, &mut memory);
                    0.0
                };
                let work = if push > 0.0 { push * (next - d) } else { 0.0 };
                lost += u32::from(next > 0.0 && push <= 0.0);
                let gained = stored(&law, &tuned, &memory, next) - before;
                assert!(gained <= work + 1e-5 * before.max(gained), "{gained} m^3 for {work}, {d} to {next} m");
                d = next;
            }
            assert!(lost > 100, "{lost}");
        }
    }
}
