//! The mutable state: every array that a tick writes, allocated by the caller before the first
//! tick.

use nalgebra::Vector3;

use crate::bristle::{Bristle, Rubbed};
use crate::fault::{BuildError, Fault};
use crate::inertia::Floored;
use crate::lanes::{ROW, Row, add, row, vector};
use crate::model::Model;
use crate::params::MOST_TERMS;

/// A node in motion.
#[derive(Clone, Copy, Debug)]
#[cfg_attr(not(target_os = "none"), repr(C, align(16)))]
#[cfg_attr(target_os = "none", repr(C), derive(bytemuck::Pod, bytemuck::Zeroable))]
pub struct Node {
    pub(crate) v: Row,
    /// Scratch memory between the passes of a stage: first the foundation's push over E [N/Pa],
    /// later the node's acceleration times the substep [m/s].
    pub(crate) pass: Row,
    // force, position and pressure side by side: the board loads them in one instruction
    pub(crate) f: Row,
    pub(crate) x: Row,
    /// Six times the volume of the node's tets [m^3], then the node's pressure over E (1).
    pub(crate) p: f32,
    /// Tangent stiffness of the foundation at this node over E [m]; zero outside `foundation`.
    pub(crate) slope: f32,
    /// Share in which this node takes part in the motion of the smooth fields (1); below 1 in
    /// contact.
    pub(crate) free: f32,
}

impl Node {
    /// At rest at the origin: the initial value of reserved memory.
    pub const ZERO: Self = Self { v: [0.0; ROW], pass: [0.0; ROW], f: [0.0; ROW], x: [0.0; ROW], p: 0.0, slope: 0.0, free: 1.0 };

    /// Puts the node to rest at a position [m].
    // inlining it would cost 700 bytes of a board's flash
    #[inline(never)]
    fn put_to_rest(&mut self, place_m: Vector3<f32>) {
        *self = Self { x: row(place_m), ..Self::ZERO };
    }

    /// Present position, patch frame [m].
    #[must_use]
    pub fn position_m(&self) -> Vector3<f32> {
        vector(&self.x)
    }

    /// Velocity after the last substep, patch frame [m/s].
    #[must_use]
    pub fn velocity_m_per_s(&self) -> Vector3<f32> {
        vector(&self.v)
    }

    /// Force of the last substep divided by Young's modulus [N/Pa]. At an anchor it is the force of
    /// the tissue on the support; in tissue that relaxes, it is that force before it fades.
    #[must_use]
    pub fn force_over_modulus(&self) -> Vector3<f32> {
        vector(&self.f)
    }
}

/// Returns a node by index; for an index past the end, which no checked model contains, a node at
/// rest at the origin. The access has no branch that can panic.
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

/// Defines [`Parked`], and how a [`State`] gives and takes it, from one list of fields.
macro_rules! parked {
    ($($field:ident: $kind:ty,)*) => {
        /// The part of a [`State`] outside the arrays that it borrows. With it, a caller that owns
        /// the arrays can drop a state between ticks and resume it later.
        #[derive(Clone, Copy, Debug, Default)]
        pub struct Parked {
            $($field: $kind,)*
        }

        impl State<'_> {
            /// The part of the state outside the borrowed arrays.
            #[must_use]
            pub fn held(&self) -> Parked {
                Parked { $($field: self.$field,)* }
            }

            fn hold(&mut self, held: Parked) {
                $(self.$field = held.$field;)*
            }
        }
    };
}
parked! {
    near: usize,
    tip_m: Option<Vector3<f32>>,
    touch: Option<TouchPlane>,
    pressed: Option<TouchPlane>,
    been_outside: bool,
    apart: bool,
    offset_m: Vector3<f32>,
    limit: Option<TouchPlane>,
    over: Option<u16>,
    shaft: bool,
    seat: Seat,
    body: Seat,
    rubbing: usize,
    previous_m_per_s: Vector3<f32>,
    fault: Option<Fault>,
}

/// Faded part of the force at a node, over E and with its sign reversed, term by term [N/Pa]
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
    /// Results kept between the passes of the volume stage, and before that between those of the
    /// stiffening springs.
    #[cfg_attr(target_os = "none", expect(dead_code, reason = "the board computes it twice"))]
    pub(crate) shapes: &'a mut [TetShapes],
    /// Memory of the relaxation filter, shape \[nodes\]; may be empty if the tissue does not relax.
    pub(crate) faded: &'a mut [Faded],
    /// Bristles of the nodes in contact; may be empty without friction.
    pub(crate) bristles: &'a mut [Bristle],
    /// Surface triangles near the probe in this tick.
    pub(crate) candidates: &'a mut [u16],
    /// Number of valid entries in `candidates`.
    pub(crate) near: usize,
    /// Probe tip that the patch was given in the last tick [m].
    pub(crate) tip_m: Option<Vector3<f32>>,
    pub(crate) touch: Option<TouchPlane>,
    /// The last plane touched, kept while the tip is below the rest surface there: tissue that is
    /// thrown off the probe loses contact for a tick or two.
    pub(crate) pressed: Option<TouchPlane>,
    /// True if the probe has been outside the tissue since the last reset, and since it last
    /// entered or left the tissue other than through the surface.
    pub(crate) been_outside: bool,
    /// True if the tip that the patch was given last differs from the sensed one.
    pub(crate) apart: bool,
    /// Displacement that the depth limit withholds from the patch [m]: it is added to the sensed
    /// tip before the speed limits are applied.
    pub(crate) offset_m: Vector3<f32>,
    /// Where the depth limit was met: from this point on the force continues along this normal.
    pub(crate) limit: Option<TouchPlane>,
    /// Surface triangle that carried the largest share of the last push; `None` once the sensed tip
    /// is outside.
    pub(crate) over: Option<u16>,
    /// True if the probe's shaft can touch, because its tip is inside the tissue.
    pub(crate) shaft: bool,
    /// Walk that locates the sensed tip.
    pub(crate) seat: Seat,
    /// Walk that locates the probe's body.
    pub(crate) body: Seat,
    /// Number of entries in `bristles` that touched in the last substep.
    pub(crate) rubbing: usize,
    /// Friction of this tick; zero without friction.
    pub(crate) rubbed: Rubbed,
    /// Power that the mass added by the floor absorbs in this tick.
    pub(crate) floored: Floored,
    /// The probe's velocity in the last tick [m/s].
    pub(crate) previous_m_per_s: Vector3<f32>,
    pub(crate) fault: Option<Fault>,
}

impl<'a> State<'a> {
    /// Creates a patch at rest in the caller's memory, which must have at least one entry per node
    /// (`nodes`) and per surface triangle (`candidates`), and [`TetShapes::count`] entries in
    /// `shapes` (none on the board).
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

    /// Resumes a state from the part that [`Self::held`] returned, in the same memory.
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
        Ok(Self {
            shapes: &mut shapes[..TetShapes::count(model)],
            faded: &mut [],
            bristles: &mut [],
            nodes: &mut nodes[..model.nodes.len()],
            candidates: &mut candidates[..model.triangles.len()],
            near: held.near,
            tip_m: held.tip_m,
            touch: held.touch,
            pressed: held.pressed,
            been_outside: held.been_outside,
            apart: held.apart,
            offset_m: held.offset_m,
            limit: held.limit,
            over: held.over,
            shaft: held.shaft,
            seat: held.seat,
            body: held.body,
            rubbing: held.rubbing,
            rubbed: Rubbed::NONE,
            floored: Floored::NONE,
            previous_m_per_s: held.previous_m_per_s,
            fault: held.fault,
        })
    }

    /// Gives the state the memory that relaxing tissue needs, at least one entry per node: zeros
    /// for a patch at rest, or the previous contents for a state that was parked. Without this
    /// memory the tick of a relaxing patch fails with [`Fault::SizeMismatch`].
    ///
    /// # Errors
    /// [`BuildError::TooLarge`], if `faded` has fewer entries than the patch has nodes.
    pub fn with_relaxation(mut self, faded: &'a mut [Faded]) -> Result<Self, BuildError> {
        let (need, have) = (self.nodes.len(), faded.len());
        self.faded = faded.get_mut(..need).ok_or(BuildError::TooLarge { item: "nodes that relax", need, have })?;
        Ok(self)
    }

    /// Gives the state the memory that a probe with friction needs, one entry per node that may
    /// touch at once; further nodes slide freely. Without it the tick fails with
    /// [`Fault::SizeMismatch`].
    #[must_use]
    pub fn with_friction(mut self, bristles: &'a mut [Bristle]) -> Self {
        self.bristles = bristles;
        self
    }

    /// Returns to rest and clears a latched fault.
    pub fn reset(&mut self, model: &Model) {
        for (node, rest) in self.nodes.iter_mut().zip(model.nodes) {
            node.put_to_rest(rest.rest_m.into());
        }
        self.faded.fill(Faded::ZERO);
        self.hold(Parked::default());
        (self.rubbed, self.floored) = (Rubbed::NONE, Floored::NONE);
    }

    /// Copies another state of the same model: positions, velocities, memories, contact, fault.
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
        self.hold(other.held());
        (self.rubbed, self.floored) = (other.rubbed, other.floored);
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
    /// step of its own, and for starting from a recorded state. An index past the end is ignored.
    pub fn place(&mut self, node: usize, position_m: Vector3<f32>, velocity_m_per_s: Vector3<f32>) {
        if let Some(n) = self.nodes.get_mut(node) {
            n.x = row(position_m);
            n.v = row(velocity_m_per_s);
        }
    }

    /// Adds a force over Young's modulus [N/Pa] to the forces of a node's next step: for a
    /// [`crate::method::Method`] with forces of its own. An index past the end is ignored.
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

    /// Adds bytes to the hash, in order.
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

/// Gradients and volumes of four tets, which the volume forces use twice per substep. In tissue
/// that stiffens, the memory of the gradients holds the forces of twelve springs before that. On a
/// desktop, storing these values saves a quarter of the tick compared with computing them twice; on
/// the board RAM is scarcer than cycles (117 k against 118 k cycles measured for 435 tets), so
/// there it is empty.
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

    /// Number of entries that a model needs.
    #[must_use]
    pub fn count(model: &Model) -> usize {
        if cfg!(target_os = "none") { 0 } else { model.tets.len() / 4 }
    }
}

/// Walk of [`crate::stages::presence`] from tet to tet, kept from one tick to the next.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Seat {
    /// Tet at which the last walk ended.
    pub(crate) tet: u32,
    /// True if the point was inside that tet.
    pub(crate) inside: bool,
    /// True if the point was outside, above a face of that tet that a probe can touch and that
    /// faces the probe's handle.
    pub(crate) above: bool,
    /// True if the walk has not ended and continues in the next tick.
    pub(crate) walking: bool,
    /// Number of steps taken (wraps). It varies the choice between several exit faces, so that no
    /// walk cycles.
    pub(crate) steps: u8,
}

impl Seat {
    /// Whether the point was located inside the rest volume.
    pub(crate) fn inside(self) -> bool {
        self.inside
    }
}
