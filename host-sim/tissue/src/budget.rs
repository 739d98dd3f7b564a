//! Cost of a tick on each machine, estimated from the patch's size.
//!
//! The figures for boards are cycles per item: exact instruction counts from the emulator, times
//! the documented cycle table of the Cortex-M4F. They are **not hardware cycles** (`cargo test -p
//! palpate-tests --release --test board board_cost -- --nocapture` measures them again). The
//! figures for the desktop are measured, see the README.

use palpate::{Model, Params, Terms};

/// Cost of each kind of item in one substep, and the budget of a tick.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CostModel {
    /// Name on the command line.
    pub name: &'static str,
    /// Unit of the costs: "cycles" or "ns".
    pub unit: &'static str,
    spring: f64,
    /// Part of a spring's cost that is due to compensation: zero on the M4F, where one loop serves
    /// both cases. A tet's barrier is not counted.
    compensation: f64,
    /// Addition to a spring's cost if the mass floor is relative to neighbours.
    neighbour: f64,
    /// Addition to a node's cost in that case: its share of the smooth fields.
    smooth: f64,
    /// Addition to a node's cost if only one smooth field is used.
    field: f64,
    tet: f64,
    node: f64,
    /// Additions to a node's cost if forces relax: a constant, and one for each term.
    relaxing: [f64; 2],
    /// Addition to the cost of a pressed triangle under friction.
    rubbed: f64,
    /// Additions to the costs of a spring, a node and a pressed triangle if the tissue stiffens;
    /// zero on boards, which do not have the term.
    stiffening: [f64; 3],
    /// Cost of a surface triangle that the probe presses, with four foundation points.
    touched: f64,
    /// Cost of each further point on a pressed triangle.
    extra_point: f64,
    /// Cost of the contact search for each surface triangle, per tick.
    passed: f64,
    rim_node: f64,
    rim_edge: f64,
    /// Constant part of the cost, per tick.
    tick: f64,
    /// Units of the machine in 1 ms.
    pub per_ms: f64,
    /// Share of the millisecond that a tick may use (1).
    pub load: f64,
    /// Factor by which a tick is lengthened by waits for code in the flash that the chip's cache
    /// does not hold (1). Not in the costs; `board_cost` derives it from the executed addresses.
    pub waits: f64,
    /// Memory; `None` if it is not limited.
    room: Option<Room>,
    /// Whether the mass floor may act relative to neighbours on this machine. The M4F has time for
    /// only one smooth field, and at 3.5 kPa its patches have hardly any floored nodes.
    relative_mass: bool,
    /// Least damping of the foundation ([`Params::contact_damping`]). With large elements, only a
    /// full dashpot keeps the contact from creating energy.
    contact_damping: f32,
}

/// Capacity that a board's firmware keeps for a patch.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Room {
    /// Number of nodes whose state the firmware reserves (`firmware/controller/src/patch.rs`).
    nodes: usize,
    /// Number of surface triangles whose state the firmware reserves.
    triangles: usize,
    /// Flash for the patch file [bytes], that of `memory.x` less an eighth for the program; or RAM.
    flash_bytes: usize,
}

/// Largest ratio of the bound on a tick to the cycles that a board counts (1). The bound is that of
/// the default patch, by its image: every block as often as in any tick, with the most triangles.
pub const BOUND: f64 = 1.05;
/// Largest ratio of that bound to the longest emulated tick (1); `board_cost` asserts both.
pub const TIGHTNESS: f64 = 1.10;

/// The smallest board: 1 MB of flash, 128 KB of RAM.
const LEAST_BOARD: Room = Room { nodes: 480, triangles: 1024, flash_bytes: 7 * 128 * 1024 };
/// A board that copies its patch to RAM (the controller's feature `small-ram`).
const SMALL_RAM: Room = Room { nodes: 160, triangles: 512, flash_bytes: 24 * 1024 };
/// State of a node on a board [bytes]: position, velocity, force, push, pressure, slope, share in
/// contact, inertia with its smooth fields, and the memory of the check at the start.
const NODE_BYTES: usize = 15 * 4 + 7 * 4 + 2 * 4;
/// State of a surface triangle on a board [bytes]: its place in the list of contact candidates.
const TRIANGLE_BYTES: usize = 2;

const M4F_168: CostModel = CostModel {
    name: "m4f-168",
    unit: "cycles",
    spring: 80.0,
    compensation: 0.0,
    neighbour: 70.0,
    smooth: 110.0,
    field: 34.0,
    tet: 215.0,
    node: 165.0,
    relaxing: [50.0, 30.0],
    rubbed: 240.0,
    stiffening: [0.0; 3],
    touched: 840.0,
    extra_point: 160.0,
    passed: 61.0,
    rim_node: 75.0,
    rim_edge: 99.0,
    tick: 2300.0,
    per_ms: 168e3,
    load: 0.65,
    waits: 1.0,
    room: Some(LEAST_BOARD),
    relative_mass: false,
    contact_damping: 1.0,
};

/// Machines known to `pack --board` and the press budget.
pub const MACHINES: [CostModel; 3] = [
    CostModel {
        name: "desktop",
        unit: "ns",
        spring: 2.0,
        compensation: 0.2,
        neighbour: 1.6,
        smooth: 1.5,
        field: 0.5,
        tet: 4.0,
        node: 4.0,
        relaxing: [0.6, 0.5],
        rubbed: 12.0,
        stiffening: [1.0, 0.8, 15.0],
        touched: 60.0,
        extra_point: 12.0,
        passed: 3.0,
        rim_node: 6.0,
        rim_edge: 8.0,
        tick: 100.0,
        per_ms: 1e6,
        load: 1.0,
        waits: 1.0,
        room: None,
        relative_mass: true,
        contact_damping: 0.0,
    },
    M4F_168,
    // costs by the M4F's cycle table, since none is public for the M7, whose dual issue can only
    // make it faster
    CostModel { name: "m7-480", per_ms: 480e3, relative_mass: true, ..M4F_168 },
];

/// Chips with a Cortex-M4F's instructions at another clock, which `--board` accepts as well: the
/// boards of `firmware/PORTING.md`. Each cycle of the M33's 150 MHz counts as 0.8: conflicts
/// between code and data in the banks of its RAM, and reads of its serial flash, are in no cost.
pub const CHIPS: [CostModel; 4] = [
    CostModel { name: "m7-400", per_ms: 400e3, relative_mass: true, ..M4F_168 },
    CostModel { name: "m4f-180", per_ms: 180e3, waits: 1.11, room: Some(SMALL_RAM), ..M4F_168 },
    CostModel { name: "m4f-170", per_ms: 170e3, waits: 1.01, room: Some(SMALL_RAM), ..M4F_168 },
    CostModel { name: "m33-150", per_ms: 120e3, ..M4F_168 },
];

/// Worst-case cost of a tick of a patch.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cost {
    /// Worst-case cost of the tick, in units of the machine.
    pub units: f64,
    /// Budget of the tick, in units of the machine.
    pub budget: f64,
}

/// Numbers of a patch's items that cost time.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize)]
pub struct Counts {
    /// Number of nodes.
    pub nodes: usize,
    /// Number of springs.
    pub springs: usize,
    /// Number of tets.
    pub tets: usize,
    /// Number of surface triangles.
    pub triangles: usize,
    /// Number of surface triangles that the probe can touch.
    pub touched: usize,
    /// Number of foundation points on each of these triangles.
    pub points: usize,
    /// Number of rim nodes.
    pub rim_nodes: usize,
    /// Number of rim edges.
    pub rim_edges: usize,
}

impl Counts {
    /// Counts the items of a model, with `touched` triangles under the probe.
    #[must_use]
    pub fn of(model: &Model, touched: usize) -> Self {
        Self {
            nodes: model.nodes.len(),
            springs: model.springs.len(),
            tets: model.tets.len(),
            triangles: model.triangles.len(),
            touched,
            points: model.points_per_triangle(),
            rim_nodes: model.rim_nodes.len(),
            rim_edges: model.rim_edges.len(),
        }
    }

    /// Memory for the state that a tick changes, on a board [bytes].
    #[must_use]
    pub fn ram_bytes(&self) -> usize {
        NODE_BYTES * self.nodes + TRIANGLE_BYTES * self.triangles
    }
}

impl CostModel {
    /// The machine or chip with this name.
    #[must_use]
    pub fn named(name: &str) -> Option<&'static Self> {
        MACHINES.iter().chain(&CHIPS).find(|m| m.name == name)
    }

    /// Whether the machine is a board, with limited memory.
    #[must_use]
    pub fn is_board(&self) -> bool {
        self.room.is_some()
    }

    /// The parameters with the variants of masses and contact that this machine runs.
    #[must_use]
    pub fn adapt(&self, params: &Params) -> Params {
        let relative_mass = params.terms.relative_mass && self.relative_mass;
        let smooth_mass = params.terms.smooth_mass || params.terms.relative_mass && !self.relative_mass;
        let contact_damping = params.contact_damping.max(self.contact_damping);
        Params { terms: Terms { relative_mass, smooth_mass, ..params.terms }, contact_damping, ..*params }
    }

    /// Cost of rim springs in a substep, for this many rim nodes and rim edges.
    #[must_use]
    pub fn rim(&self, nodes: usize, edges: usize) -> f64 {
        nodes as f64 * self.rim_node + edges as f64 * self.rim_edge
    }

    /// Cost of a tick with `touched` triangles under the probe, for tissue that neither relaxes nor
    /// stiffens and a probe without friction.
    #[must_use]
    pub fn cost(&self, model: &Model, touched: usize, substeps: u16) -> Cost {
        self.cost_with(model, &Params::default(), touched, substeps)
    }

    /// Cost of a tick for the tissue and the probe of `params`, with the mass floor of this
    /// machine.
    #[must_use]
    pub fn cost_with(&self, model: &Model, params: &Params, touched: usize, substeps: u16) -> Cost {
        let terms = Terms { relative_mass: self.relative_mass, smooth_mass: !self.relative_mass, ..Terms::ALL };
        self.cost_of(&Counts::of(model, touched), &Params { terms, ..*params }, substeps)
    }

    /// Cost of a tick from the counts of a patch, with only the terms that `params` has on.
    #[must_use]
    pub fn cost_of(&self, counts: &Counts, params: &Params, substeps: u16) -> Cost {
        let terms = params.terms;
        let of = |count: usize, each: f64| count as f64 * each;
        let on = |term: bool| if term { 1.0 } else { 0.0 };
        let inertia = match (terms.relative_mass, terms.smooth_mass) {
            (true, _) => self.smooth,
            (false, true) => self.field,
            (false, false) => 0.0,
        };
        let step = of(
            counts.springs,
            self.spring - on(!terms.compensation) * self.compensation + on(terms.relative_mass) * self.neighbour,
        ) + on(terms.volume) * of(counts.tets, self.tet)
            + of(counts.nodes, self.node + inertia)
            + on(terms.rim) * self.rim(counts.rim_nodes, counts.rim_edges)
            + of(counts.touched, self.touched + of(counts.points.saturating_sub(4), self.extra_point));
        let step = step + self.added(counts, params);
        let units = self.tick + of(counts.triangles, self.passed) + f64::from(substeps) * step;
        Cost { units, budget: self.load * self.per_ms }
    }

    /// Cost that relaxation, friction and stiffening add to a substep.
    fn added(&self, counts: &Counts, params: &Params) -> f64 {
        let of = |count: usize, each: f64| count as f64 * each;
        let fading = params.relaxation.iter().filter(|term| params.terms.relaxation && term.share > 0.0).count();
        let [relaxing, term] = self.relaxing;
        let [spring, node, touched] = self.stiffening;
        let mut units = 0.0;
        if fading > 0 {
            units += of(counts.nodes, relaxing + of(fading, term));
        }
        if params.terms.friction && params.friction > 0.0 {
            units += of(counts.touched, self.rubbed);
        }
        if params.terms.stiffening && params.stiffening_b > 0.0 {
            units += of(counts.springs, spring) + of(counts.nodes, node) + of(counts.touched, touched);
        }
        units
    }

    /// Whether the state and a patch file of `patch_bytes` fit into the memory.
    #[must_use]
    pub fn has_room(&self, counts: &Counts, patch_bytes: usize) -> bool {
        self.room.is_none_or(|room| {
            counts.nodes <= room.nodes && counts.triangles <= room.triangles && patch_bytes <= room.flash_bytes
        })
    }

    /// Budget of a tick on this machine, in its units.
    #[must_use]
    pub fn budget(&self) -> f64 {
        self.load * self.per_ms
    }
}

/// Number of surface triangles with a corner within `radius_m` of `site_m` at rest: those that a
/// probe of this radius can touch when it is pressed there to the patch's depth limit.
#[must_use]
pub fn triangles_in_reach(model: &Model, site_m: [f32; 3], radius_m: f32) -> usize {
    let near = |n: u16| {
        let x = model.nodes.get(usize::from(n)).map_or([f32::INFINITY; 3], |n| n.rest_m);
        let square: f32 = x.iter().zip(site_m).map(|(a, b)| (a - b) * (a - b)).sum();
        square <= radius_m * radius_m
    };
    model.triangles.iter().filter(|t| t.node.iter().any(|&n| near(n))).count()
}
