//! What a tick costs on which machine, estimated from the patch's size.
//!
//! Board figures: cycles per item from exact instruction counts in the emulator times the Cortex-M4F's documented cycle table; **not hardware
//! cycles** (`cargo test -p palpate-tests --release --test board_cost -- --nocapture` measures them anew). Desktop: measured, see the README.

use palpate::Model;

/// Cost of one item in one substep, and what a tick may cost.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Machine {
    /// Name on the command line.
    pub name: &'static str,
    /// What the units are: "cycles" or "ns".
    pub unit: &'static str,
    spring: f64,
    tet: f64,
    node: f64,
    /// A surface triangle of four foundation points that the probe presses.
    touched: f64,
    /// Each further point of it.
    point: f64,
    /// A surface triangle that it does not, per tick.
    passed: f64,
    rim_node: f64,
    rim_edge: f64,
    /// Per tick, whatever the patch.
    tick: f64,
    /// Units that 1 ms has.
    per_ms: f64,
    /// Share of the millisecond that the tick may use.
    pub load: f64,
}

const M4F_168: Machine = Machine {
    name: "m4f-168",
    unit: "cycles",
    spring: 95.0,
    tet: 291.0,
    node: 130.0,
    touched: 840.0,
    point: 160.0,
    passed: 61.0,
    rim_node: 75.0,
    rim_edge: 99.0,
    tick: 2300.0,
    per_ms: 168e3,
    load: 0.65,
};

/// Machines that `mesh pack --board` and the press budget know.
pub const MACHINES: [Machine; 3] = [
    Machine {
        name: "desktop",
        unit: "ns",
        spring: 2.0,
        tet: 4.0,
        node: 4.0,
        touched: 60.0,
        point: 12.0,
        passed: 3.0,
        rim_node: 6.0,
        rim_edge: 8.0,
        tick: 100.0,
        per_ms: 1e6,
        load: 1.0,
    },
    M4F_168,
    // the M4F's cycle table for want of a public one: dual issue can only make it faster
    Machine { name: "m7-480", per_ms: 480e3, ..M4F_168 },
];

/// What a tick of a patch costs at worst.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cost {
    /// Units of the machine.
    pub units: f64,
    /// Units that a tick may use.
    pub budget: f64,
}

impl Machine {
    /// The machine of this name.
    #[must_use]
    pub fn named(name: &str) -> Option<&'static Self> {
        MACHINES.iter().find(|m| m.name == name)
    }

    /// Cost of a tick with `touched` triangles under the probe.
    #[must_use]
    pub fn cost(&self, model: &Model, touched: usize, substeps: u16) -> Cost {
        let of = |count: usize, each: f64| count as f64 * each;
        let step = of(model.springs.len(), self.spring)
            + of(model.tets.len(), self.tet)
            + of(model.nodes.len(), self.node)
            + of(model.rim_nodes.len(), self.rim_node)
            + of(model.rim_edges.len(), self.rim_edge)
            + of(touched, self.touched + of(model.points_per_triangle() - 4, self.point));
        let units = self.tick + of(model.triangles.len(), self.passed) + f64::from(substeps) * step;
        Cost { units, budget: self.load * self.per_ms }
    }
}

/// Surface triangles that a probe of this radius, pressed to the patch's depth limit at `site_m`, can touch.
#[must_use]
pub fn triangles_in_reach(model: &Model, site_m: [f32; 3], radius_m: f32) -> usize {
    let near = |n: u16| {
        let x = model.nodes.get(usize::from(n)).map_or([f32::INFINITY; 3], |n| n.rest_m);
        let square: f32 = x.iter().zip(site_m).map(|(a, b)| (a - b) * (a - b)).sum();
        square <= radius_m * radius_m
    };
    model.triangles.iter().filter(|t| t.node.iter().any(|&n| near(n))).count()
}
