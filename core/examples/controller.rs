//! Opens a patch file and runs 1 000 ticks of the haptic loop on a simulated device.

use palpate::haptic::cycle::{Ask, Command, Cycle, PatchRenderer, Settings};
use palpate::haptic::device::{DeviceSpec, HapticDevice, Sensed, SensorStatus};
use palpate::{BuildError, Memory, PatchFile, Vector3};

/// Aligns the bytes of a patch file to 4 bytes, because the file is read in place as words.
#[repr(C, align(4))]
struct Words<B: ?Sized>(B);
static PATCH: &Words<[u8]> = &Words(*include_bytes!(concat!(env!("CARGO_MANIFEST_DIR"), "/examples/block-m4f-168.patch")));

/// A handle that waits 1 mm outside for 700 ticks, then moves to a depth of 3 mm in 0.3 s.
struct Handle {
    tick: u32,
    site_m: Vector3<f32>,
    force_n: Vector3<f32>,
}

impl HapticDevice for Handle {
    fn limits(&self) -> DeviceSpec {
        let corner_m = Vector3::new(0.1, 0.1, 0.1);
        let (workspace_low_m, workspace_high_m) = (self.site_m - corner_m, self.site_m + corner_m);
        DeviceSpec { workspace_low_m, workspace_high_m, ..DeviceSpec::STYLUS }
    }
    fn sense(&mut self) -> Sensed {
        self.tick += 1;
        let height_m = 1e-3 - 4e-3 * self.tick.saturating_sub(700) as f32 / 300.0;
        Sensed { position_m: self.site_m + Vector3::z() * height_m, sequence: self.tick, status: SensorStatus::Good }
    }
    fn actuate(&mut self, force_n: Vector3<f32>) {
        self.force_n = force_n;
    }
    fn release(&mut self) {
        self.force_n = Vector3::zeros();
    }
}

fn main() -> Result<(), BuildError> {
    let PatchFile { model, params, site_m, .. } = PatchFile::open(&PATCH.0)?;
    // all memory of the patch; on a board this is a static
    let mut memory = Memory::<64, 128, 0, 0>::RESERVED;
    let (tuned, mut state) = memory.start(&model, &params)?;
    let mut handle = Handle { tick: 0, site_m, force_n: Vector3::zeros() };
    let mut cycle = Cycle::build(&Settings::safe(&handle.limits()), &handle.limits())?;
    for tick in 0..1000 {
        let asked = [Ask::Booted, Ask::TestPassed, Ask::Arm].get(tick).copied();
        let mut patch = PatchRenderer { model: &model, tuned: &tuned, state: &mut state };
        let telemetry = cycle.tick(&mut handle, &mut patch, Command { asked, ..Command::HEARD });
        if tick % 100 == 99 {
            let (mode, depth_mm) = (telemetry.mode, telemetry.output.depth_m * 1e3);
            println!("{tick:>4} ms: {mode:?}, {depth_mm:.2} mm deep, {:.3} N", handle.force_n.z);
        }
    }
    assert!(handle.force_n.z > 0.02, "3 mm deep the handle is pushed out");
    Ok(())
}
