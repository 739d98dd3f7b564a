//! Modes, faults and limiters in words.

use palpate::haptic::mode::Mode;
use palpate::{ClampFlags, Fault, Vector3};

use crate::message::Contact;

/// Name of the mode with this number.
#[must_use]
pub fn mode(number: u8) -> &'static str {
    match Mode::ALL.get(usize::from(number)) {
        Some(Mode::Boot) => "starting",
        Some(Mode::SelfTest) => "self-test",
        Some(Mode::Idle) => "idle: no force",
        Some(Mode::Arming) => "arming: wait above the tissue",
        Some(Mode::Active) => "active: the force is felt",
        Some(Mode::Degraded) => "degraded: scaled down until you let go",
        Some(Mode::SafeRamp) => "letting the force go",
        Some(Mode::Fault) => "fault: no force, press C to clear",
        None => "unknown",
    }
}

/// Whether a force can act in this mode.
#[must_use]
pub fn felt(number: u8) -> bool {
    matches!(Mode::ALL.get(usize::from(number)), Some(Mode::Active | Mode::Degraded | Mode::SafeRamp))
}

/// Description of the fault with this number; `None` for 0.
#[must_use]
pub fn fault(number: u8) -> Option<String> {
    Fault::ALL.into_iter().find(|f| *f as u8 == number).map(|f| f.to_string())
}

/// Returns the names of the limiters that acted.
#[must_use]
pub fn limiters(bits: u8) -> Vec<&'static str> {
    [
        (ClampFlags::SPEED, "speed held back"),
        (ClampFlags::DEPTH, "depth at its limit"),
        (ClampFlags::FORCE, "force at its limit"),
        (ClampFlags::BURIED, "began inside: lift first"),
        (ClampFlags::SLEW, "force growing as fast as it may"),
        (ClampFlags::HELD, "an older pose"),
        (ClampFlags::GAIN, "scaled: ramp-in, relief, or stiffer than the device renders"),
        (ClampFlags::ENERGY, "scaled: the contact took too little energy"),
    ]
    .into_iter()
    .filter(|(flag, _)| bits & flag.bits() == flag.bits())
    .map(|(_, text)| text)
    .collect()
}

/// Says how a tissue differs from an elastic one under a probe that slides freely.
#[must_use]
pub fn terms(lasting_share: f32, stiffening_b: f32, friction: f32) -> String {
    let said = [
        (lasting_share < 1.0).then(|| format!("a hold fades to {:.0} %", lasting_share * 100.0)),
        (stiffening_b > 0.0).then(|| format!("stiffens, b = {stiffening_b:.1}")),
        (friction > 0.0).then(|| format!("friction {friction:.2}")),
    ];
    let said: Vec<String> = said.into_iter().flatten().collect();
    if said.is_empty() { "elastic, without friction".into() } else { said.join("; ") }
}

/// Names the nodules of a scene.
#[must_use]
pub fn own_nodules(count: usize) -> String {
    match count {
        1 => "the scene's own nodule".into(),
        _ => format!("the scene's own {count} nodules"),
    }
}

/// Describes a contact map in one line.
#[must_use]
pub fn contact(map: Option<&Contact>) -> String {
    let Some(map) = map.filter(|map| map.area_m2 > 0.0) else { return "no contact".into() };
    let [a, b] = map.half_axes_m.map(|axis| Vector3::from(axis).norm() * 1e3);
    let [x, y, _] = map.centre_m.map(|c| c * 1e3);
    format!(
        "{:.0} mm2, axes {a:.1} and {b:.1} mm, centre {x:.1}, {y:.1} mm, peak {:.2} kPa",
        map.area_m2 * 1e6,
        map.peak_pa * 1e-3
    )
}
