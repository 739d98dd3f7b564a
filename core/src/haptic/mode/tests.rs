//! Every mode with every event, checked against rules that are stated differently from the table.

use super::*;

/// Modes that can be reached from `start` without passing through a mode of `shut`.
fn reach(start: Mode, shut: &[Mode]) -> [bool; 8] {
    let mut seen = [false; 8];
    seen[start as usize] = true;
    for _ in Mode::ALL {
        for from in Mode::ALL {
            if !seen[from as usize] {
                continue;
            }
            for to in Event::ALL.into_iter().filter_map(|e| next(from, e)) {
                seen[to as usize] |= !shut.contains(&to);
            }
        }
    }
    seen
}

#[test]
fn no_pair_stands_twice_and_the_machine_follows_the_table() {
    for mode in Mode::ALL {
        for event in Event::ALL {
            let rows = TRANSITIONS.iter().filter(|(from, on, _)| (*from, *on) == (mode, event));
            assert!(rows.count() <= 1, "{mode:?} {event:?}");
            let mut machine = ModeMachine { mode, fault: None, ticks: 7 };
            if event == Event::Faulted {
                assert!(!machine.handle(event), "a fault needs its reason");
                machine.fail(Fault::Diverged);
                assert_eq!(machine.mode(), Mode::Fault);
                assert_eq!(machine.fault().is_some(), mode != Mode::Fault);
            } else {
                let moved = machine.handle(event);
                assert_eq!((machine.mode(), moved), next(mode, event).map_or((mode, false), |to| (to, true)));
                assert_eq!(machine.ticks(), if moved { 0 } else { 7 });
            }
        }
    }
}

#[test]
fn force_is_reached_through_arming_alone_and_arming_through_idle() {
    for gate in [Mode::SelfTest, Mode::Idle, Mode::Arming] {
        let seen = reach(Mode::Boot, &[gate]);
        assert!(Mode::ALL.into_iter().all(|m| !(m.allows_force() && seen[m as usize])), "round {gate:?}");
    }
    for from in Mode::ALL.into_iter().filter(|m| !m.allows_force()) {
        for event in Event::ALL {
            let to = next(from, event);
            assert!(!to.is_some_and(Mode::allows_force) || (from, event) == (Mode::Arming, Event::Armed), "{from:?} {event:?}");
        }
    }
    // a force that is being ramped down never returns by itself
    assert!(Event::ALL.into_iter().filter_map(|e| next(Mode::SafeRamp, e)).all(|to| !to.allows_force()));
}

#[test]
fn a_fault_takes_every_mode_and_only_clearing_ends_it() {
    for mode in Mode::ALL {
        let to = next(mode, Event::Faulted);
        assert_eq!(to, (mode != Mode::Fault).then_some(Mode::Fault), "{mode:?}");
    }
    for event in Event::ALL {
        assert_eq!(next(Mode::Fault, event), (event == Event::Cleared).then_some(Mode::SelfTest));
    }
    let mut machine = ModeMachine::BOOT;
    machine.fail(Fault::PoseStale);
    machine.fail(Fault::OverSpeed);
    assert_eq!(machine.fault(), Some(Fault::PoseStale), "the first one is kept");
    machine.fail(Fault::EmergencyStop);
    machine.fail(Fault::OverSpeed);
    assert_eq!((machine.mode(), machine.fault()), (Mode::Fault, Some(Fault::EmergencyStop)), "the stop is told");
    assert!(machine.handle(Event::Cleared) && machine.fault().is_none());
}

#[test]
fn stop_silence_and_an_absent_operator_take_the_force_away_everywhere() {
    for mode in Mode::ALL.into_iter().filter(|m| m.runs_patch()) {
        for event in [Event::StopAsked, Event::HostLost, Event::OperatorLeft] {
            let to = next(mode, event).unwrap_or(mode);
            assert!(matches!(to, Mode::SafeRamp | Mode::Idle), "{mode:?} {event:?} {to:?}");
        }
    }
}

#[test]
fn every_mode_is_reached_and_left() {
    assert_eq!(reach(Mode::Boot, &[]), [true; 8]);
    for mode in Mode::ALL {
        assert!(mode == Mode::Idle || reach(mode, &[])[Mode::Idle as usize], "{mode:?}");
    }
}

#[test]
fn only_idle_takes_a_mesh() {
    for mode in Mode::ALL {
        for request in [Request::Mesh, Request::Config] {
            assert_eq!(mode.accepts(request), mode == Mode::Idle);
        }
        assert!(mode.accepts(Request::LowerLimits), "stricter is always possible");
        assert!(!mode.accepts(Request::Parameter) || mode == Mode::Idle || mode.allows_force());
    }
}
