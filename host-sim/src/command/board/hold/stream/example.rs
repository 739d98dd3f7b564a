//! A record of a board, for tests.

use palpate_controller::link::{Identity, Record};

pub(in super::super) const RECORD: Record = Record {
    tick: 4_000_000_000,
    mode: 4,
    fault: 8,
    refused: false,
    limiters: 64,
    position_m: [0.001, 0.002, -0.003],
    model_n: [0.1, 0.2, 0.3],
    point_m: [0.7, 0.8, 0.9],
    normal: [0.0, 0.6, 0.8],
    depth_m: 0.0031,
    active_nodes: 5,
    patch_limiters: 1,
    wanted_n: [1.0, 1.1, 1.2],
    applied_n: [0.01, 0.02, 0.03],
    energy_j: [-1e-6, 1.7, 1.8],
    enabled: true,
    codes: [7, -8, 9],
    spent_counts: 200,
};

pub(in super::super) fn identity() -> Identity {
    Identity {
        name: [0; 32],
        built_day: 0,
        clock_hz: 100_000_000,
        image: 0,
        patch_checksum: 0x0bad_cafe,
        youngs_modulus_pa: 3500.0,
        predicted_cycles: 0.0,
        longest_counts: 0,
    }
}
