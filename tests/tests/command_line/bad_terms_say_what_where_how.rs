//! Impossible properties of tissue and probe and impossible moving errors give exit code 2 and one
//! line that names the remedy.

use palpate_tests::palpate_command::Desk;
use palpate_tests::press_run::{SMALL_BLOCK, edited};

use crate::bad_input_says_what_where_how::{refused, refused_edit, refused_scene};

#[test]
fn a_relaxation_that_cannot_be() {
    let term = |share: &str, time: &str| format!("[[tissue.relaxation]]\nshare = {share}\ntime_s = {time}\n");
    let refused = |terms: &str, says: &[&str]| refused_edit("[probe]", &format!("{terms}[probe]"), says);
    for share in ["0.0", "-0.2", "nan"] {
        refused(&term(share, "1.0"), &["tissue.relaxation[0].share", "above zero", "remove the term"]);
    }
    refused(&(term("0.5", "1.0") + &term("0.5", "2.0")), &["tissue.relaxation", "sum to 1.000", "at most 0.99 may fade"]);
    for time in ["0.0", "-1.0", "nan", "0.0009", "1e3"] {
        refused(&term("0.5", time), &["tissue.relaxation[0].time_s", "outside 0.001 .. 200"]);
    }
    refused(&term("0.1", "1.0").repeat(4), &["tissue.relaxation has 4 terms", "3 fit", "smallest shares"]);
    refused(&term("0.5", "1.0").replace("time_s", "tau_s"), &["scene.toml:10: ", "\"tau_s\"", "did you mean \"time_s\"?"]);
    refused_edit(
        "nodes = 129",
        "nodes = 129\nlong_term_modulus_pa = 2e3",
        &["has both youngs_modulus_pa", "long_term_modulus_pa", "keep one"],
    );
    for value in ["0.0", "-3.5", "nan", "inf"] {
        let long = format!("long_term_modulus_pa = {value}");
        refused_edit("youngs_modulus_pa = 3500.0", &long, &["tissue.long_term_modulus_pa", "out of range"]);
    }
}

#[test]
fn a_friction_that_cannot_be() {
    for value in ["-0.1", "nan", "5.5", "inf"] {
        let with = format!("shape = \"hemisphere\"\nfriction = {value}");
        refused_edit("shape = \"hemisphere\"", &with, &["probe.friction", "outside 0 .. 5", "choose a value in that range"]);
    }
    let with = "shape = \"hemisphere\"\nfrictoin = 0.5";
    refused_edit("shape = \"hemisphere\"", with, &["\"frictoin\"", "did you mean \"friction\"?"]);
}

#[test]
fn a_stiffening_that_cannot_be() {
    for value in ["-0.3", "nan", "inf", "101.0"] {
        let says = &["tissue.stiffening_b", "outside 0 .. 100"];
        refused_edit("nodes = 129", &format!("nodes = 129\nstiffening_b = {value}"), says);
    }
    let ball = "[[tissue.inclusion]]\ncenter_m = [0.0, 0.0, -0.012]\nradius_m = 0.006\nstiffness_ratio = 10.0\nstiffening_b = ";
    for value in ["-0.3", "nan", "inf", "101.0"] {
        let says = &["tissue.inclusion[0].stiffening_b", "must be from 0 to 100"];
        refused_edit("[probe]", &format!("{ball}{value}\n[probe]"), says);
    }
    let desk = Desk::default();
    desk.put("scene.toml", edited(SMALL_BLOCK, "[probe]", &format!("{ball}3.0\n[probe]")));
    desk.put("scene.toml", edited(SMALL_BLOCK, "nodes = 129", "nodes = 129\nstiffening_b = 3.0"));
    let on_a_board = |arguments: &[&str], board: &str| {
        refused(&desk, arguments, &["scene.toml: ", "tissue.stiffening_b = 3", board, "has no time", "leave it out"]);
    };
    on_a_board(&["pack", "--scene", "scene.toml", "--board", "m7-480"], "m7-480");
    on_a_board(&["emulate", "--scene", "scene.toml"], "a board");
    on_a_board(&["loop", "--emulated", "--quick", "--scene", "scene.toml"], "a board");
    on_a_board(&["fit", "--smallest", "--board", "m4f-168", "--scene", "scene.toml"], "m4f-168");
    let law = ["fit", "--law", "--scene", "scene.toml", "--set", "probe.friction=0.3"];
    refused(&desk, &law, &["probe.friction", "friction, which slides over nodes", "without --law"]);
}

#[test]
fn a_moving_error_that_cannot_be_kept() {
    let solver = |pct: &str| format!("[solver]\nmoving_error_pct = {pct}\n[probe]");
    for pct in ["0.0", "-1.0", "nan", "100.5"] {
        refused_edit("[probe]", &solver(pct), &["solver.moving_error_pct", "above 0, at most 100"]);
    }
    refused_edit("[probe]", "[solver]\nmoving_error = 5\n[probe]", &["did you mean \"moving_error_pct\"?"]);
    let fast = edited(&edited(SMALL_BLOCK, "[probe]", &solver("0.001")), "ramp_m_per_s = 0.04", "ramp_m_per_s = 0.8");
    refused_scene(
        &Desk::default(),
        &fast,
        &[
            "scene.toml: solver.moving_error_pct = 0.001",
            "at 800 mm/s floored masses put the 129 nodes",
            "least that was reached",
            "move more slowly",
        ],
    );
}
