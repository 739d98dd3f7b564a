//! The algebra of the energy bound holds: z3 proves it (`tests/energy_bound`, SAFETY.md).

use std::process::Command;

use palpate_tests::palpate_command::repository;

#[test]
#[ignore = "long: needs Python and z3, and is skipped where they are missing"]
fn the_energy_bound_is_proven() {
    let Ok(ran) = Command::new("python3").arg("tests/energy_bound").current_dir(repository()).output() else {
        println!("skipped: python3 is missing");
        return;
    };
    let (said, wrong) = (String::from_utf8_lossy(&ran.stdout), String::from_utf8_lossy(&ran.stderr));
    println!("{said}");
    assert!(ran.status.success(), "{said}{wrong}");
    let proven = said.lines().filter(|line| line.starts_with("proven: ")).count();
    assert!(said.starts_with("skipped: ") || proven == 32, "{proven} claims:\n{said}");
}
