use super::super::limits::tests::device;
use super::*;

fn observer(delay_ticks: u8) -> PassivityObserver {
    counting(delay_ticks, 0.0)
}

fn counting(delay_ticks: u8, count_m: f32) -> PassivityObserver {
    PassivityObserver::build(&PassivitySettings::DEFAULT, &DeviceSpec { delay_ticks, count_m, ..device() }, 1e-3).unwrap()
}

/// Presses a spring of `k` N/m in and out along half a sine of amplitude `depth_m` within 100
/// ticks; returns the energy at the end.
fn press(observer: &mut PassivityObserver, k: f32, depth_m: f32) -> Energy {
    let depth = |n: u16| depth_m * libm::sinf(core::f32::consts::PI * f32::from(n) * 0.01);
    for n in 1..=100 {
        let way = Vector3::new(0.0, 0.0, depth(n - 1) - depth(n));
        observer.observe(&way, true).unwrap();
        observer.sent(Vector3::new(0.0, 0.0, if n < 100 { k * depth(n) } else { 0.0 }));
    }
    observer.energy()
}

#[test]
fn a_held_and_late_spring_creates_its_closed_form_energy() {
    // E = b integral v^2 with b = K (d + 1/2) T, over x = a sin(pi t / 100 ms): integral = a^2
    // (pi / 0.1)^2 0.1 / 2
    for delay in [0, 1, 2] {
        let mut observer = observer(delay);
        let (k, a) = (100.0, 2e-3);
        let created_j = press(&mut observer, k, a).created_j;
        let pi = core::f32::consts::PI;
        let right_j = k * (f32::from(delay) + 0.5) * 1e-3 * a * a * pi * pi / 0.2;
        assert!((created_j / right_j - 1.0).abs() < 0.05, "delay {delay}: {created_j} J, closed form {right_j} J");
    }
}

#[test]
fn a_hold_on_the_edge_of_a_count_creates_nothing() {
    let mut observer = counting(0, 55e-6);
    let count = |n: u16| Vector3::new(0.0, 0.0, if n.is_multiple_of(2) { 55e-6 } else { -55e-6 });
    for n in 0..60_000 {
        // one count out under the force of the deeper count, and in again under the weaker one
        observer.observe(&count(n), true).unwrap();
        observer.sent(Vector3::new(0.0, 0.0, if n.is_multiple_of(2) { 0.8 } else { 0.83 }));
    }
    assert!(observer.gain() == 1.0 && observer.energy().created_j < 1e-4, "{:?}", observer.energy());
}

#[test]
fn the_alarm_fades_the_force_until_the_probe_has_left() {
    let mut observer = observer(1);
    press(&mut observer, 400.0, 6e-3);
    assert!(observer.gain() < 1.0, "{:?}", observer.energy());
    let mut last = observer.gain();
    for _ in 0..100 {
        observer.observe(&Vector3::zeros(), true).unwrap();
        assert!(observer.gain() <= last);
        last = observer.gain();
    }
    assert_eq!(last, 0.0);
    for _ in 0..23 {
        observer.sent(Vector3::zeros());
        observer.observe(&Vector3::zeros(), false).unwrap();
    }
    assert_eq!(observer.gain(), 0.5, "the next contact is half as stiff");
    assert!(observer.energy().total_created_j > 0.5e-3 && observer.energy().created_j == 0.0);
}

#[test]
fn five_bad_contacts_in_a_row_are_a_fault_and_so_are_five_within_seconds() {
    // a force of 1 N acts over a displacement of 1 mm out of the tissue (bad) or into it
    let contact = |observer: &mut PassivityObserver, displacement_m: f32| {
        observer.sent(Vector3::z());
        observer.sent(Vector3::zeros());
        let answer = observer.observe(&Vector3::new(0.0, 0.0, displacement_m), true);
        for _ in 0..30 {
            observer.sent(Vector3::zeros());
            observer.observe(&Vector3::zeros(), false)?;
        }
        answer
    };
    let rest = |observer: &mut PassivityObserver, ticks: u32| {
        for _ in 0..ticks {
            observer.observe(&Vector3::zeros(), false).unwrap();
        }
    };
    let mut apart = observer(1);
    for round in 0..3 {
        for _ in 0..4 {
            assert_eq!(contact(&mut apart, 1e-3), Ok(()), "round {round}");
        }
        assert_eq!(apart.gain(), 0.0625);
        for _ in 0..5 {
            contact(&mut apart, -1e-3).unwrap();
        }
        assert_eq!(apart.gain(), 1.0, "good contacts bring it back");
        rest(&mut apart, 20_000);
    }
    let faults = (0..5).filter(|_| contact(&mut apart, 1e-3) == Err(Fault::EnergyCreated)).count();
    assert_eq!(faults, 1);
    // a handle that bounces: every other contact is good
    let mut bounces = observer(1);
    let after = (0..20).position(|n| contact(&mut bounces, if n % 2 == 0 { 1e-3 } else { -1e-3 }).is_err());
    assert_eq!(after, Some(10), "the sixth bad one: the first has faded a little");
    bounces.clear();
    assert_eq!(contact(&mut bounces, 1e-3), Ok(()));
}

#[test]
fn a_way_of_two_counts_is_energy() {
    let mut observer = counting(0, 55e-6);
    for _ in 0..10 {
        observer.sent(Vector3::z());
        observer.observe(&Vector3::new(0.0, 0.0, 2.0 * 55e-6), true).unwrap();
    }
    // all of the displacement but the backlash of one count
    let right_j = 55e-6 * (20.0 - 1.01);
    assert!((observer.energy().given_j / right_j - 1.0).abs() < 1e-3, "{:?}", observer.energy());
}

#[test]
fn after_the_alarm_a_hundredth_is_left_in_twenty_one_ticks() {
    let mut observer = observer(0);
    observer.sent(Vector3::z());
    observer.observe(&Vector3::new(0.0, 0.0, 1e-3), true).unwrap();
    let ticks = (1..100).find(|_| {
        observer.observe(&Vector3::zeros(), true).unwrap();
        observer.gain() == 0.0
    });
    assert_eq!(ticks, Some(20));
}

#[test]
fn a_contact_lasts_while_forces_are_on_their_way() {
    let mut observer = observer(3);
    observer.sent(Vector3::z());
    for tick in 0..3 {
        observer.observe(&Vector3::zeros(), false).unwrap();
        observer.sent(Vector3::zeros());
        assert_eq!(observer.energy().given_j, 0.0, "tick {tick}");
    }
    observer.observe(&Vector3::new(0.0, 0.0, 1e-4), false).unwrap();
    assert!(observer.energy().given_j > 0.9e-4, "the force acts three ticks late: {:?}", observer.energy());
}
