//! The power fails at every byte while a profile is written. The board then starts with the
//! complete previous profile or the complete new one, never with anything else. Profiles with
//! flipped bits or values out of range are refused.

use palpate_controller::config::{Flash, FlashError, Profile, SLOT_BYTES, Slot, StoreError, load, store};

/// Two slots whose power fails after this many bytes have been erased or written.
#[derive(Clone)]
struct Cut {
    slots: [[u8; SLOT_BYTES]; 2],
    bytes_left: usize,
}

impl Cut {
    fn whole(slots: [[u8; SLOT_BYTES]; 2]) -> Self {
        Self { slots, bytes_left: usize::MAX }
    }

    fn put(&mut self, slot: Slot, at: usize, byte: u8) -> Result<(), FlashError> {
        self.bytes_left = self.bytes_left.checked_sub(1).ok_or(FlashError)?;
        let kept = &mut self.slots[slot as usize][at];
        // writing to flash changes ones to zeros; only erasing changes zeros back to ones
        *kept = if byte == 0xFF { 0xFF } else { *kept & byte };
        Ok(())
    }
}

impl Flash for Cut {
    fn read(&self, slot: Slot, bytes: &mut [u8; SLOT_BYTES]) {
        *bytes = self.slots[slot as usize];
    }

    fn erase(&mut self, slot: Slot) -> Result<(), FlashError> {
        (0..SLOT_BYTES).try_for_each(|at| self.put(slot, at, 0xFF))
    }

    fn write(&mut self, slot: Slot, bytes: &[u8; SLOT_BYTES]) -> Result<(), FlashError> {
        bytes.iter().enumerate().try_for_each(|(at, byte)| {
            if *byte == 0xFF {
                return Ok(()); // already erased
            }
            self.put(slot, at, *byte)
        })
    }
}

fn profile(n: u8) -> Profile {
    let mut profile = Profile::desktop();
    profile.limits.scalars[0] = 1.0 + f32::from(n) * 0.1;
    profile.home_counts = [i32::from(n), -7, 1 << 20];
    profile
}

#[test]
fn power_cut_at_every_byte_leaves_the_profile_before_or_the_new_one() {
    let empty = Cut::whole([[0xFF; SLOT_BYTES]; 2]);
    assert_eq!(load(&empty), None);
    let mut flash = empty;
    for n in 0..5_u8 {
        let before = load(&flash).map(|kept| kept.0);
        let (mut kept_old, mut took_new) = (0, 0);
        for cut in 0.. {
            let mut torn = Cut { bytes_left: cut, ..flash.clone() };
            let answer = store(&mut torn, &profile(n));
            let after = load(&Cut::whole(torn.slots)).map(|kept| kept.0);
            assert!(after == before || after == Some(profile(n)), "cut after {cut} bytes: {after:?}");
            kept_old += usize::from(after == before);
            took_new += usize::from(after == Some(profile(n)));
            // the next attempt succeeds
            torn.bytes_left = usize::MAX;
            assert!(store(&mut torn, &profile(n)).is_ok() && load(&torn).map(|kept| kept.0) == Some(profile(n)));
            if answer.is_ok() {
                break;
            }
        }
        assert!(kept_old > SLOT_BYTES && took_new == 1, "{kept_old} and {took_new}: nothing was cut");
        store(&mut flash, &profile(n)).unwrap();
        assert_eq!(load(&flash).map(|kept| kept.2), Some(u32::from(n) + 1), "generations count");
    }
}

#[test]
fn one_to_three_flipped_bits_are_never_taken() {
    let mut flash = Cut::whole([[0xFF; SLOT_BYTES]; 2]);
    store(&mut flash, &profile(1)).unwrap();
    let used = flash.slots[0].iter().rposition(|byte| *byte != 0xFF).unwrap() + 1;
    let bits = 8 * used;
    let flipped = |flips: &[usize]| {
        let mut slots = flash.slots;
        flips.iter().for_each(|bit| slots[0][bit / 8] ^= 1 << (bit % 8));
        load(&Cut::whole(slots))
    };
    for a in 0..bits {
        assert_eq!(flipped(&[a]), None, "bit {a}");
        for b in a + 1..bits {
            assert_eq!(flipped(&[a, b]), None, "bits {a} and {b}");
            let c = (a * 31 + b * 17) % bits;
            assert!(c == a || c == b || flipped(&[a, b, c]).is_none(), "bits {a}, {b} and {c}");
        }
    }
}

#[test]
fn a_profile_out_of_range_is_not_kept() {
    let mut flash = Cut::whole([[0xFF; SLOT_BYTES]; 2]);
    store(&mut flash, &profile(1)).unwrap();
    let spoil: [fn(&mut Profile); 6] = [
        |p| p.max_force_n = 1e3,
        |p| p.max_force_n = f32::NAN,
        |p| p.limits.scalars[2] = 50.0,
        |p| p.limits.counts[0] = 0,
        |p| p.damping[0] = -1.0,
        |p| p.delay_ticks = 200,
    ];
    for (n, spoil) in spoil.into_iter().enumerate() {
        let mut bad = profile(2);
        spoil(&mut bad);
        assert!(matches!(store(&mut flash, &bad), Err(StoreError::Profile(_))), "{n}");
        assert_eq!(load(&flash).map(|kept| kept.0), Some(profile(1)), "{n}");
    }
}
