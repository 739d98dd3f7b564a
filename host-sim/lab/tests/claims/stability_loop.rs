//! Walls with every controller: theory is met where it applies, the product keeps its promise, and
//! each other controller fails as expected.

use palpate_lab::stability::controller::Controller;
use palpate_lab::stability::loop_matrix::{HELD_N_PER_M, LoopSetup, STEP, TapResult, passive_n_per_m};
use palpate_loop::closed_loop::device::DeviceProfile;
use palpate_loop::closed_loop::hand::{HANDS, Hand};

fn touch(delay_ticks: u8) -> DeviceProfile {
    DeviceProfile { delay_ticks, ..DeviceProfile::load("touch").unwrap() }
}

fn held(control: Controller, device: &DeviceProfile, hand: Hand) -> TapResult {
    LoopSetup { device, hand, control }.tap(HELD_N_PER_M).unwrap()
}
#[test]
fn a_raw_loop_ends_where_another_simulation_found_it() {
    // found by an independent simulation of one axis at 100 kHz; the last is the arm (H3), for
    // which the size of a count does not matter
    for (delay, hand, count_m, found_n_per_m) in
        [(0, 0, 55e-6, 678.0), (1, 0, 55e-6, 139.0), (1, 1, 55e-6, 952.0), (1, 3, 1e-6, 5836.0)]
    {
        let device = DeviceProfile { count_m, ..touch(delay) };
        let case = LoopSetup { device: &device, hand: HANDS[hand], control: Controller::Direct };
        let steps = (case.climb().unwrap().n_per_m / found_n_per_m).ln() / STEP.ln();
        assert!(steps.abs() < 2.1, "delay {delay}, H{hand}: {steps} steps from {found_n_per_m} N/m");
    }
}

#[test]
fn a_viscous_device_meets_the_closed_form() {
    for delay_ticks in [0, 1, 2] {
        let device = DeviceProfile { damping_n_s_per_m: 1.1, friction_n: 0.0, count_m: 0.0, ..touch(delay_ticks) };
        let case = LoopSetup { device: &device, hand: HANDS[0], control: Controller::Direct };
        let (found, closed) = (case.climb().unwrap().n_per_m, passive_n_per_m(&device));
        assert!((found / closed - 1.0).abs() < 0.3, "delay {delay_ticks}: {found} N/m, closed form {closed} N/m");
    }
}

#[test]
fn ours_keeps_its_promise_where_raw_creates_energy() {
    for delay in [0, 1, 2] {
        let device = touch(delay);
        for hand in HANDS {
            let ours = held(Controller::Ours, &device, hand);
            assert!(ours.holds() && ours.created_mj <= 0.01, "delay {delay}, {}: {ours:?}", hand.id);
            assert!(ours.static_error.is_some_and(|e| e.abs() <= 1e-3), "delay {delay}, {}: {ours:?}", hand.id);
        }
        let raw_mj = HANDS.iter().map(|h| held(Controller::Direct, &device, *h).created_mj).fold(0.0, f64::max);
        assert!(raw_mj > 5.0, "delay {delay}: {raw_mj} mJ");
    }
    // with hand H0 (released), which adds no stiffness or damping of its own
    let device = touch(1);
    let stiffest = |control| LoopSetup { device: &device, hand: HANDS[0], control }.climb().unwrap().n_per_m;
    let (ours, raw) = (stiffest(Controller::Ours), stiffest(Controller::Direct));
    assert!(ours > 4.0 * raw, "ours {ours} N/m, raw {raw} N/m");
}

#[test]
fn every_other_controller_fails_as_it_is_known_to() {
    let device = touch(1);
    let [released, firm] = [HANDS[0], HANDS[2]];
    let raw = held(Controller::Direct, &device, released);
    assert!(!raw.quiet && raw.static_error.is_none(), "{raw:?}");
    // a coupling of 500 N/m in series with 400 N/m
    let coupled = held(Controller::VirtualCoupling, &device, firm);
    assert!(coupled.static_error.is_some_and(|e| (e + 400.0 / 900.0).abs() < 0.01), "{coupled:?}");
    let bounded = held(Controller::EnergyBounding, &device, firm);
    assert!(bounded.static_error.is_some_and(|e| e < -0.2), "200 of 400 N/m: {bounded:?}");
    for control in [Controller::Slew { n_per_tick: 0.05 }, Controller::LowPass] {
        let late = held(control, &device, released);
        assert!(!late.quiet && late.created_mj > 3.0 * raw.created_mj, "{}: {late:?}, raw {raw:?}", control.name());
    }
    // it damps after the energy was created: less is created than without it, but not zero
    let observed = held(Controller::TimeDomainPassivity, &device, released);
    assert!(observed.created_mj > 0.1 && observed.created_mj < 0.5 * raw.created_mj, "{observed:?}, raw {raw:?}");
    // constant damping is enough at a delay of one tick; at two ticks 1 N s/m is not enough for 400
    // N/m
    let constant = Controller::ConstantDamping { n_s_per_m: 1.0 };
    assert!(held(constant, &device, released).created_mj < 0.05);
    let late = HANDS.map(|h| held(constant, &touch(2), h).created_mj);
    assert!(late.iter().any(|mj| *mj > 1.0), "{late:?}");
}
