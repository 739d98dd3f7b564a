//! Other methods allocate nothing in a tick either: allocations would make them slower on the
//! chart.

use palpate_lab::methods::{Block, Method};

use crate::allocations::allocations;

#[test]
fn other_methods_allocate_nothing_either() {
    let block = Block::standard(57, 3500.0).unwrap();
    for method in Method::ALL {
        let run = method.run(&block, 2, |running| {
            let mut pressed = 0;
            let (count, ()) = allocations(|| {
                for n in 0..200_i32 {
                    let force_n = running.tick(block.tip_m(1e-5 * f64::from((n - 20).min(150)))).unwrap();
                    pressed += usize::from(force_n.z > 0.0);
                }
            });
            (count, pressed)
        });
        // a method that is not available (no calibrated patch) cannot allocate
        if let Some((count, pressed)) = run.unwrap() {
            assert_eq!(count, 0, "allocations of {}", method.name());
            assert!(pressed > 100, "{} pressed in {pressed} ticks", method.name());
        }
    }
}
