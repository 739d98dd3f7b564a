//! The contact map at the deepest point of a press.

use palpate::{ContactMap, Model, State, Tuned, Vector3};

use super::TickRow;

/// Contact map of the tick with the deepest tip. Of several equally deep ticks it is the last, in
/// which the tissue has settled most.
#[derive(Clone, Debug)]
pub struct DeepestContact {
    /// Start of that tick [s].
    pub t_s: f64,
    /// Commanded depth of the tip [m].
    pub depth_m: f64,
    /// Contact map of that tick: force, centre of pressure, area and axes.
    pub map: ContactMap,
    /// Pressure on every surface triangle [Pa], shape \[triangles\].
    pub pressure_pa: Vec<f32>,
    /// Node positions in that tick [m], shape \[nodes\].
    pub nodes_m: Vec<Vector3<f32>>,
}

impl DeepestContact {
    /// Inspects a tick that has just run: its map replaces `deepest`, unless an earlier tick was
    /// deeper or the probe does not touch.
    pub fn see(deepest: &mut Option<Self>, model: &Model, tuned: &Tuned, state: &mut State, row: &TickRow) {
        let beaten = deepest.as_ref().is_some_and(|before| row.command_m < before.depth_m);
        if beaten || !state.in_contact() {
            return;
        }
        let mut pressure_pa = deepest.take().map_or_else(|| vec![0.0; model.triangles.len()], |before| before.pressure_pa);
        let map = ContactMap::read(model, tuned, state, &mut pressure_pa);
        let nodes_m = state.nodes().iter().map(palpate::Node::position_m).collect();
        *deepest = Some(Self { t_s: row.t_s, depth_m: row.command_m, map, pressure_pa, nodes_m });
    }
}
