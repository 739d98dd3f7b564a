//! The mutable state: every array that a tick writes, allocated by the caller before the first
//! tick.

use nalgebra::Vector3;

use crate::fault::{BuildError, Fault};
use crate::inertia::Floored;
use crate::lanes::{ROW, Row, add, row, vector};
use crate::model::Model;
use crate::params::MOST_TERMS;
use crate::stages::force::friction::{Bristle, Rubbed};

/// A node in motion.
#[derive(Clone, Copy, Debug)]
#[cfg_attr(not(target_os = "none"), repr(C, align(16)))]
#[cfg_attr(target_os = "none", repr(C), derive(bytemuck::Pod, bytemuck::Zeroable))]
pub struct Node {
    pub(crate) v: Row,
    /// Between the passes of one stage: the foundation's push over E [N/Pa], later the node's
    /// acceleration times the substep [m/s].
    pub(crate) pass: Row,
    // force, place and pressure side by side: the board loads them in one instruction
    pub(crate) f: Row,
    pub(crate) x: Row,
    /// Six times the volume of the node's tets [m^3], then its pressure over E (1).
    pub(crate) p: f32,
    /// Slope of the foundation at this node over E [m]; zero outside `foundation`.
    pub(crate) slope: f32,
    /// Share of the smooth fields' motion that contact leaves to this node (1).
    pub(crate) free: f32,
}

impl Node {
    /// At rest at the origin: the initial value of reserved memory.
    pub const ZERO: Self = Self { v: [0.0; ROW], pass: [0.0; ROW], f: [0.0; ROW], x: [0.0; ROW], p: 0.0, slope: 0.0, free: 1.0 };

    /// Puts the node to rest at a place [m].
    // inlined, it would take 700 bytes of a board's flash
    #[inline(never)]
    fn put_to_rest(&mut self, place_m: Vector3<f32>) {
        *self = Self { x: row(place_m), ..Self::ZERO };
    }

    /// Position [m].
    #[must_use]
    pub fn position_m(&self) -> Vector3<f32> {
        vector(&self.x)
    }

    /// Velocity [m/s].
    #[must_use]
    pub fn velocity_m_per_s(&self) -> Vector3<f32> {
        vector(&self.v)
    }

    /// Force of the last substep divided by Young's modulus [N/Pa]. At an anchor: the force of the
    /// tissue on the support, in tissue that relaxes before it fades.
    #[must_use]
    pub fn force_over_modulus(&self) -> Vector3<f32> {
        vector(&self.f)
    }
}

/// A node by index; past the end, which no checked model reaches, a node at rest at the origin.
/// The access has no branch that can panic.
#[inline(always)]
pub(crate) fn node(nodes: &[Node], index: u16) -> &Node {
    nodes.get(usize::from(index)).unwrap_or(&Node::ZERO)
}

/// Plane that the probe touched in the last tick.
#[derive(Clone, Copy, Debug)]
pub(crate) struct TouchPlane {
    /// Point of the *undeformed* surface under the probe [m].
    pub rest_m: Vector3<f32>,
    /// Outward unit normal: the direction of the push on the probe.
    pub normal: Vector3<f32>,
}

/// The part of a [`State`] outside the arrays that it borrows. With it a caller that owns the
/// arrays can drop a state between ticks and resume it.
#[derive(Clone, Copy, Debug, Default)]
pub struct Parked {
    near: usize,
    tip_m: Option<Vector3<f32>>,
    touch: Option<TouchPlane>,
    pressed: Option<TouchPlane>,
    been_outside: bool,
    apart: bool,
    offset_m: Vector3<f32>,
    limit_from_m: Option<Vector3<f32>>,
    over: Option<u16>,
    shaft: bool,
    seat: Seat,
    body: Seat,
    rubbing: usize,
    previous_m_per_s: Vector3<f32>,
    fault: Option<Fault>,
}

/// Forces that have faded at a node, over E and with their sign turned, term by term [N/Pa]
/// (`stages/force/relaxation.rs`).
#[derive(Clone, Copy, Debug)]
pub struct Faded(pub(crate) [Row; MOST_TERMS]);

impl Faded {
    /// Nothing faded: the initial value of reserved memory.
    pub const ZERO: Self = Self([[0.0; ROW]; MOST_TERMS]);

    /// x, y, z of all terms together [N/Pa].
    #[inline(always)]
    pub(crate) fn sum(&self) -> Vector3<f32> {
        let [a, b, c] = &self.0;
        vector(a) + vector(b) + vector(c)
    }
}

/// The mutable half of a patch.
#[derive(Debug)]
pub struct State<'a> {
    pub(crate) nodes: &'a mut [Node],
    /// Memory of the volume stage between its passes, and of stiffening springs between theirs.
    #[cfg_attr(target_os = "none", expect(dead_code, reason = "the board computes it twice"))]
    pub(crate) shapes: &'a mut [TetShapes],
    /// Memory of the relaxation, shape \[nodes\]; may be empty where nothing relaxes.
    pub(crate) faded: &'a mut [Faded],
    /// Bristles of nodes that touch; may be empty without friction.
    pub(crate) bristles: &'a mut [Bristle],
    /// Surface triangles near the probe in this tick.
    pub(crate) candidates: &'a mut [u16],
    /// Number of valid entries in `candidates`.
    pub(crate) near: usize,
    /// Probe tip that the patch saw last [m].
    pub(crate) tip_m: Option<Vector3<f32>>,
    pub(crate) touch: Option<TouchPlane>,
    /// The last touch, kept while the tip is below the rest surface there: tissue thrown off the
    /// probe loses contact for a tick or two.
    pub(crate) pressed: Option<TouchPlane>,
    /// The probe has been outside the tissue since the last reset.
    pub(crate) been_outside: bool,
    /// The tip that the patch was given last differs from the sensed one.
    pub(crate) apart: bool,
    /// From the sensed tip to the target of the tip given to the patch [m]: the displacement
    /// withheld by the depth limit.
    pub(crate) offset_m: Vector3<f32>,
    /// Sensed tip at which the depth limit began to act [m].
    pub(crate) limit_from_m: Option<Vector3<f32>>,
    /// Surface triangle that carried most of the last push, until the sensed tip is outside.
    pub(crate) over: Option<u16>,
    /// The probe's shaft can touch: its tip is inside the tissue.
    pub(crate) shaft: bool,
    /// Tet at which the sensed tip was located last.
    pub(crate) seat: Seat,
    /// Tet at which the probe's body was located last.
    pub(crate) body: Seat,
    /// Number of entries in `bristles` that touched in the last substep.
    pub(crate) rubbing: usize,
    /// Friction of this tick; zero without friction.
    pub(crate) rubbed: Rubbed,
    /// Power that the mass floor takes in this tick.
    pub(crate) floored: Floored,
    /// The probe's velocity in the last tick [m/s].
    pub(crate) previous_m_per_s: Vector3<f32>,
    pub(crate) fault: Option<Fault>,
}

impl<'a> State<'a> {
    /// A patch at rest in the caller's memory: at least one entry per node (`nodes`) and per
    /// surface triangle (`candidates`), and [`TetShapes::count`] `shapes` (none on the board).
    ///
    /// # Errors
    /// [`BuildError::TooLarge`] names the memory that is too small.
    pub fn new(
        model: &Model,
        nodes: &'a mut [Node],
        candidates: &'a mut [u16],
        shapes: &'a mut [TetShapes],
    ) -> Result<Self, BuildError> {
        let mut state = Self::resume(model, nodes, candidates, shapes, Parked::default())?;
        state.reset(model);
        Ok(state)
    }

    /// Resumes a state where [`Self::held`] left it, in the same memory.
    ///
    /// # Errors
    /// Errors of [`Self::new`].
    pub fn resume(
        model: &Model,
        nodes: &'a mut [Node],
        candidates: &'a mut [u16],
        shapes: &'a mut [TetShapes],
        held: Parked,
    ) -> Result<Self, BuildError> {
        let fits = |item, need, have| match need <= have {
            true => Ok(()),
            false => Err(BuildError::TooLarge { item, need, have }),
        };
        fits("nodes", model.nodes.len(), nodes.len())?;
        fits("surface triangles", model.triangles.len(), candidates.len())?;
        fits("tet shapes", TetShapes::count(model), shapes.len())?;
        let Parked {
            near,
            tip_m,
            touch,
            pressed,
            been_outside,
            apart,
            offset_m,
            limit_from_m,
            over,
            shaft,
            seat,
            body,
            rubbing,
            previous_m_per_s,
            fault,
        } = held;
        Ok(Self {
            shapes: &mut shapes[..TetShapes::count(model)],
            faded: &mut [],
            bristles: &mut [],
            nodes: &mut nodes[..model.nodes.len()],
            candidates: &mut candidates[..model.triangles.len()],
            near,
            tip_m,
            touch,
            pressed,
            been_outside,
            apart,
            offset_m,
            limit_from_m,
            over,
            shaft,
            seat,
            body,
            rubbing,
            rubbed: Rubbed::NONE,
            floored: Floored::NONE,
            previous_m_per_s,
            fault,
        })
    }

    /// Gives the state memory for a relaxing tissue, at least one entry per node: zero in a patch
    /// at rest, or its contents when the state was parked. Without it the tick of a relaxing
    /// patch fails with [`Fault::SizeMismatch`].
    ///
    /// # Errors
    /// [`BuildError::TooLarge`]: an entry per node does not fit.
    pub fn with_relaxation(mut self, faded: &'a mut [Faded]) -> Result<Self, BuildError> {
        let (need, have) = (self.nodes.len(), faded.len());
        self.faded = faded.get_mut(..need).ok_or(BuildError::TooLarge { item: "nodes that relax", need, have })?;
        Ok(self)
    }

    /// Gives the state memory for a probe with friction, one entry per node that may touch at once;
    /// further nodes slide freely. Without it a patch with friction is [`Fault::SizeMismatch`].
    #[must_use]
    pub fn with_friction(mut self, bristles: &'a mut [Bristle]) -> Self {
        self.bristles = bristles;
        self
    }

    /// The part of the state outside the borrowed arrays.
    #[must_use]
    pub fn held(&self) -> Parked {
        let Self {
            near,
            tip_m,
            touch,
            pressed,
            been_outside,
            apart,
            offset_m,
            limit_from_m,
            over,
            shaft,
            seat,
            body,
            rubbing,
            previous_m_per_s,
            fault,
            ..
        } = *self;
        Parked {
            near,
            tip_m,
            touch,
            pressed,
            been_outside,
            apart,
            offset_m,
            limit_from_m,
            over,
            shaft,
            seat,
            body,
            rubbing,
            previous_m_per_s,
            fault,
        }
    }

    /// Returns to rest and clears a latched fault.
    pub fn reset(&mut self, model: &Model) {
        for (node, rest) in self.nodes.iter_mut().zip(model.nodes) {
            node.put_to_rest(rest.rest_m.into());
        }
        self.faded.fill(Faded::ZERO);
        self.near = 0;
        self.tip_m = None;
        self.touch = None;
        self.pressed = None;
        self.been_outside = false;
        self.apart = false;
        self.offset_m = Vector3::zeros();
        self.limit_from_m = None;
        self.over = None;
        self.shaft = false;
        self.seat = Seat::default();
        self.body = Seat::default();
        (self.rubbing, self.rubbed, self.floored) = (0, Rubbed::NONE, Floored::NONE);
        self.previous_m_per_s = Vector3::zeros();
        self.fault = None;
    }

    /// Takes over another state of the same model: positions, velocities, contact, fault.
    pub fn copy_from(&mut self, other: &State) {
        for (to, from) in self.nodes.iter_mut().zip(other.nodes.iter()) {
            *to = *from;
        }
        for (to, from) in self.candidates.iter_mut().zip(other.candidates.iter()) {
            *to = *from;
        }
        for (to, from) in self.faded.iter_mut().zip(other.faded.iter()) {
            *to = *from;
        }
        for (to, from) in self.bristles.iter_mut().zip(other.bristles.iter()) {
            *to = *from;
        }
        self.near = other.near;
        self.tip_m = other.tip_m;
        self.touch = other.touch;
        self.pressed = other.pressed;
        self.been_outside = other.been_outside;
        self.apart = other.apart;
        self.offset_m = other.offset_m;
        self.limit_from_m = other.limit_from_m;
        self.over = other.over;
        self.shaft = other.shaft;
        self.seat = other.seat;
        self.body = other.body;
        (self.rubbing, self.rubbed, self.floored) = (other.rubbing, other.rubbed, other.floored);
        self.previous_m_per_s = other.previous_m_per_s;
        self.fault = other.fault;
    }

    /// The nodes, in the model's order.
    #[must_use]
    pub fn nodes(&self) -> &[Node] {
        self.nodes
    }

    /// The latched fault.
    #[must_use]
    pub fn fault(&self) -> Option<Fault> {
        self.fault
    }

    /// Gives a node another position [m] and velocity [m/s]: for a [`crate::method::Method`] with a
    /// step of its own, and for starting from a recorded state. Ignored past the end.
    pub fn place(&mut self, node: usize, position_m: Vector3<f32>, velocity_m_per_s: Vector3<f32>) {
        if let Some(n) = self.nodes.get_mut(node) {
            n.x = row(position_m);
            n.v = row(velocity_m_per_s);
        }
    }

    /// Adds a force over Young's modulus [N/Pa] to the forces of a node's next step: for a
    /// [`crate::method::Method`] with forces of its own. Ignored past the end.
    pub fn add_force(&mut self, node: usize, force_over_modulus: Vector3<f32>) {
        if let Some(n) = self.nodes.get_mut(node) {
            add(&mut n.f, &row(force_over_modulus));
        }
    }

    /// True if the last tick pressed the probe against the tissue.
    #[must_use]
    pub fn in_contact(&self) -> bool {
        self.touch.is_some()
    }

    /// FNV-1a over the bits of all positions and velocities: equal hashes on desktop and board mean
    /// equal states.
    #[must_use]
    pub fn hash(&self) -> u64 {
        let mut hash = Fnv::default();
        for node in self.nodes.iter() {
            hash.vector(vector(&node.x));
            hash.vector(vector(&node.v));
        }
        hash.finish()
    }
}

/// FNV-1a, 64 bits.
#[derive(Clone, Copy, Debug)]
pub struct Fnv(u64);

impl Default for Fnv {
    fn default() -> Self {
        Self(0xcbf2_9ce4_8422_2325)
    }
}

impl Fnv {
    /// Adds the bits of x, y, z.
    pub fn vector(&mut self, v: Vector3<f32>) {
        for c in [v.x, v.y, v.z] {
            self.bytes(&c.to_bits().to_le_bytes());
        }
    }

    /// Adds bytes.
    #[inline]
    pub fn bytes(&mut self, bytes: &[u8]) {
        for byte in bytes {
            self.0 = (self.0 ^ u64::from(*byte)).wrapping_mul(0x0100_0000_01b3);
        }
    }

    /// The hash so far.
    #[must_use]
    pub fn finish(self) -> u64 {
        self.0
    }
}

/// Gradients and volumes of four tets, which the volume forces use twice in a substep; before that,
/// in tissue that stiffens, the forces of twelve springs in place of the gradients. On a desktop
/// storing it saves a quarter of the tick over computing it twice; on the board RAM is scarcer than
/// cycles (117 k against 118 k cycles measured for 435 tets), so there it is empty.
#[derive(Clone, Copy, Debug)]
pub struct TetShapes {
    #[cfg(not(target_os = "none"))]
    pub(crate) gradients: [Vector3<wide::f32x4>; 3],
    #[cfg(not(target_os = "none"))]
    pub(crate) six_volume: wide::f32x4,
}

impl TetShapes {
    /// Initial value of reserved memory.
    pub const ZERO: Self = Self {
        #[cfg(not(target_os = "none"))]
        gradients: [Vector3::new(wide::f32x4::ZERO, wide::f32x4::ZERO, wide::f32x4::ZERO); 3],
        #[cfg(not(target_os = "none"))]
        six_volume: wide::f32x4::ZERO,
    };

    /// Number that a model needs.
    #[must_use]
    pub fn count(model: &Model) -> usize {
        if cfg!(target_os = "none") { 0 } else { model.tets.len() / 4 }
    }
}

/// Tet in which the walk of [`crate::stages::presence`] ended in the last tick.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Seat {
    /// Tet in which the last walk ended.
    pub(crate) tet: u32,
    /// The tip was inside that tet.
    pub(crate) inside: bool,
    /// The tip was outside, over a face of that tet that a probe can touch and that faces its
    /// handle.
    pub(crate) above: bool,
    /// The walk has not ended: it goes on in the next tick.
    pub(crate) walking: bool,
    /// Steps taken, wrapping: varies the choice between several exit faces, so that no walk cycles.
    pub(crate) steps: u8,
}

impl Seat {
    /// Whether the tip was located inside the rest volume.
    pub(crate) fn inside(self) -> bool {
        self.inside
    }
}
