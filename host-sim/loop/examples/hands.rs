//! tuning
use palpate::haptic::cycle::Settings;
use palpate_loop::closed_loop::device::DeviceProfile;
use palpate_loop::closed_loop::paths::PathGround;
use palpate_loop::closed_loop::yielding::*;
use rayon::prelude::*;

fn main() {
    let arg = |k: &str, d: f64| {
        std::env::args().find_map(|a| a.strip_prefix(&format!("{k}=")).map(|v| v.parse::<f64>().unwrap())).unwrap_or(d)
    };
    let ground = PathGround::load().unwrap();
    let base = DeviceProfile::load("touch").unwrap();
    let (n, seed, sec) = (arg("n", 200.0) as u64, arg("seed", 1.0) as u64, arg("s", 6.0));
    let (a, selfs, eps, p, _) = (arg("a", 3.0), arg("self", 0.7), arg("eps", 20e-6), arg("p", 30e-6), 0.0);
    let dd = arg("d", -1.0);
    let list = arg("list", 0.0) as usize;
    let only = arg("only", -1.0);
    let change = |s: &mut Settings| {
        s.account.acceleration_m_per_s2 = a as f32;
        s.account.handle_share = selfs as f32;
        s.account.allowance_j = eps as f32;
        s.account.refill_w = p as f32;
    };
    // V1
    let v1 = |ground: &PathGround, patch: usize, e: f64, count: f64, delay: u8, hand_kg: f64, device_kg: f64| {
        let genes = [0.5; GENES];
        let mut c = YieldingCase::of(ground, &genes, &base);
        c.patch = patch;
        c.params = palpate::Params { youngs_modulus_pa: e as f32, ..ground.patches[patch].params };
        c.device = DeviceProfile {
            count_m: count,
            delay_ticks: delay,
            amplifier_lag_s: 0.0,
            mass_kg: device_kg,
            stiffness_ceiling_n_per_m: arg("ceil", 400.0),
            force_limit_n: arg("lim", 3.0),
            friction_n: arg("fric", 0.0),
            damping_n_s_per_m: arg("damp", 0.1),
            ..base.clone()
        };
        c.hand = palpate_tissue::finger::Impedance { mass_kg: hand_kg, damping_n_s_per_m: 3.5, stiffness_n_per_m: 287.0 };
        c.motion = Motion {
            kind: MotionKind::Hold,
            reach_m: arg("reach", 4.7e-3),
            depth_m: 4.7e-3,
            press_s: 0.18,
            share: 0.5,
            hz: 1.0,
            tremor_m: 0.024e-3,
            tremor_hz: 5.7,
            aside_m_per_s: 0.0,
            place_m: [0.0; 2],
            phase: 0.0,
        };
        c.follow(ground, sec, change, |s| if arg("trace", -1.0) == e && count == 55e-6 && delay == 0 && hand_kg == 0.021 && patch == 4 { println!("{:.3} z {:.3} mm acting {:.3} out {:.3} wanted {:.3} applied {:.3} bal {:.4} mJ accgiven {:.4} given {:.4} flags {:08b} {:?} depth {:.3}", s.t_s, s.at_m.z*1e3, s.acting_n.norm(), s.telemetry.output.force_n.norm(), s.telemetry.wanted_n.norm(), s.telemetry.applied_n.norm(), s.telemetry.energy.balance_j*1e3, s.telemetry.energy.given_j*1e3, s.given_j*1e3, s.telemetry.limiters.bits(), s.telemetry.mode, s.telemetry.output.depth_m*1e3) }).unwrap()
    };
    let mut big = PathGround { patches: vec![], devices: vec![] };
    for r in [2e-3, 3e-3, 4e-3, 6e-3, 8e-3] {
        let probe = palpate::Probe { shape: palpate::ProbeShape::Flat, radius_m: r, ..ground.patches[0].params.probe };
        big.patches.push(ground.patches[0].with_probe(probe).unwrap());
    }
    for k in 0..big.patches.len() {
        for (e, count, delay, kg, dev) in [
            (100e3, 55e-6, 0, 0.066, 0.045),
            (100e3, 55e-6, 0, 0.021, 0.045),
            (80e3, 55e-6, 0, 0.021, 0.045),
            (100e3, 45e-6, 0, 0.066, 0.045),
            (100e3, 55e-6, 1, 0.021, 0.045),
            (20e3, 55e-6, 0, 0.021, 0.045),
            (100e3, 20e-6, 0, 0.021, 0.045),
            (100e3, 55e-6, 0, 0.2, 0.045),
        ] {
            let o = v1(&big, k, e, count, delay, kg, dev);
            println!(
                "V1 r {:.0} E {e} {count} {delay} {kg}+{dev}: shake {:.3} N most {:.3} mJ given {:.3} felt {:.3} lost {} peak {:.2} {:?}",
                big.patches[k].params.probe.radius_m * 1e3,
                o.shake_n,
                o.most_j * 1e3,
                o.given_j * 1e3,
                o.felt_n_s / o.asked_n_s,
                o.lost_ticks,
                o.peak_n,
                o.fault
            );
        }
    }
    let runs: Vec<(u64, YieldingCase, Outcome)> = (0..n).into_par_iter().filter(|k| only < 0.0 || *k == only as u64).map(|k| {
        let mut c = YieldingCase::of(&ground, &YieldingCase::draw(k, seed), &base);
        if dd >= 0.0 { c.device.delay_ticks = dd as u8; }
        let o = c.follow(&ground, sec, change, |s| if only >= 0.0 { println!("{:.3} z {:.3} mm acting {:.3} out {:.3} wanted {:.3} applied {:.3} bal {:.4} mJ given {:.4} acc {:.4} flags {:08b} {:?} depth {:.3} n {:?} F {:?}", s.t_s, s.at_m.dot(&ground.patches[c.patch].site.normal)*1e3, s.acting_n.norm(), s.telemetry.output.force_n.norm(), s.telemetry.wanted_n.norm(), s.telemetry.applied_n.norm(), s.telemetry.energy.balance_j*1e3, s.given_j*1e3, s.telemetry.energy.given_j*1e3, s.telemetry.limiters.bits(), s.telemetry.mode, s.telemetry.output.depth_m*1e3, s.telemetry.output.normal.data.0, s.telemetry.output.force_n.data.0) }).unwrap();
        (k, c, o)
    }).collect();
    for (name, low, high) in [("0-1", 0, 1), ("2-3", 2, 3), ("4-7", 4, 7)] {
        let mine: Vec<_> = runs.iter().filter(|(_, c, _)| (low..=high).contains(&c.device.delay_ticks)).collect();
        let contacts: Vec<f64> = mine.iter().flat_map(|(_, _, o)| o.contacts_j.clone()).collect();
        let over = |x: f64| contacts.iter().filter(|j| **j > x).count();
        let (asked, felt): (f64, f64) = mine.iter().fold((0.0, 0.0), |(a, f), (_, _, o)| (a + o.asked_n_s, f + o.felt_n_s));
        let (at, lost, silent) =
            mine.iter().fold((0, 0, 0), |(a, l, s), (_, _, o)| (a + o.asked_ticks, l + o.lost_ticks, s + o.silent_ticks));
        let shakes = mine.iter().filter(|(_, _, o)| o.shake_n > 0.05).count();
        let shake10 = mine.iter().filter(|(_, _, o)| o.shake_n > 0.1).count();
        let faults = mine.iter().filter(|(_, _, o)| o.fault.is_some()).count();
        let worst = contacts.iter().fold(0.0_f64, |a, b| a.max(*b));
        let mean_share: f64 = mine.iter().filter(|r| r.2.asked_n_s > 0.0).map(|(_, _, o)| o.felt_n_s / o.asked_n_s).sum::<f64>()
            / mine.iter().filter(|r| r.2.asked_n_s > 0.0).count() as f64;
        println!(
            "{name}: {} runs {} contacts >.01 {} >.1 {} >1 {} worst {:.3} mJ | felt {:.3} (mean {:.3}) lost {:.3} % silent {} | shake>50mN {} >100 {} | faults {}",
            mine.len(),
            contacts.len(),
            over(1e-5),
            over(1e-4),
            over(1e-3),
            worst * 1e3,
            felt / asked,
            mean_share,
            100.0 * lost as f64 / at as f64,
            silent,
            shakes,
            shake10,
            faults
        );
    }
    let mut by: Vec<_> = runs.iter().collect();
    by.sort_by(|a, b| b.2.most_j.total_cmp(&a.2.most_j));
    let show = |(k, c, o): &(u64, YieldingCase, Outcome)| {
        println!(
            "#{k} {} E {:.0} count {:.0} um d {} lag {:.1} ms F {:.1} N m {:.3} hand {:.3} kg {:.0} N/m {:.2} Ns/m mu {:.2} {:?} depth {:.2} mm press {:.2}: most {:.3} mJ given {:.3} felt {:.2} lost {} shake {:.3} {:?}",
            ground.patches[c.patch].label(),
            c.params.youngs_modulus_pa,
            c.device.count_m * 1e6,
            c.device.delay_ticks,
            c.device.amplifier_lag_s * 1e3,
            c.device.force_limit_n,
            c.device.mass_kg,
            c.hand.mass_kg,
            c.hand.stiffness_n_per_m,
            c.hand.damping_n_s_per_m,
            c.params.friction,
            c.motion.kind,
            c.motion.depth_m * 1e3,
            c.motion.press_s,
            o.most_j * 1e3,
            o.given_j * 1e3,
            o.felt_n_s / o.asked_n_s,
            o.lost_ticks,
            o.shake_n,
            o.fault
        )
    };
    for r in by.iter().take(list) {
        show(r);
    }
    by.sort_by(|a, b| (b.2.lost_ticks).cmp(&a.2.lost_ticks));
    for r in by.iter().take(list) {
        show(r);
    }
    by.sort_by(|a, b| (b.2.shake_n).total_cmp(&a.2.shake_n));
    for r in by.iter().take(list) {
        show(r);
    }
}
