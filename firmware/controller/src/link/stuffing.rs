//! Consistent overhead byte stuffing (Cheshire and Baker, IEEE/ACM Trans. Networking 7, 1999): no
//! zero occurs inside a frame, so a zero ends it. The encoding is implemented here because the
//! link-time proof that a tick cannot panic covers it. Frames are shorter than 254 bytes, so one
//! code byte leads to the next zero.

/// Longest run that one code byte describes.
const RUN: usize = 254;

/// Stuffs a frame in place; its first byte is the place of the first code byte. `None` if the frame
/// is too long for one code byte.
pub fn stuff(frame: &mut [u8]) -> Option<()> {
    let (mut code, plain) = frame.split_first_mut().filter(|(_, plain)| plain.len() < RUN)?;
    let mut run = 1_u8;
    for place in plain {
        if *place == 0 {
            *core::mem::replace(&mut code, place) = core::mem::replace(&mut run, 1);
        } else {
            run = run.wrapping_add(1); // it stays below `RUN`
        }
    }
    *code = run;
    Some(())
}

/// Removes the stuffing, in place; returns the number of bytes left. `None` if the code bytes do
/// not end exactly at the frame's end, or the frame contains a zero.
pub fn unstuff(frame: &mut [u8]) -> Option<usize> {
    let mut next = usize::from(*frame.first()?);
    let length = frame.len();
    for at in 1..length {
        let byte = *frame.get(at)?;
        if byte == 0 {
            return None;
        }
        let plain = if at == next {
            next += usize::from(byte);
            0
        } else {
            byte
        };
        *frame.get_mut(at - 1)? = plain;
    }
    (next == length && length <= RUN).then(|| length - 1)
}

#[cfg(test)]
mod tests {
    use super::{stuff, unstuff};

    #[test]
    fn the_paper_s_examples() {
        for (plain, stuffed) in [
            (&[0][..], &[1, 1][..]),
            (&[0, 0], &[1, 1, 1]),
            (&[0x11, 0x22, 0, 0x33], &[3, 0x11, 0x22, 2, 0x33]),
            (&[0x11, 0, 0, 0], &[2, 0x11, 1, 1, 1]),
            (&[], &[1]),
        ] {
            let mut frame = std::vec::Vec::from(plain);
            frame.insert(0, 0xEE);
            stuff(&mut frame).unwrap();
            assert_eq!(frame, stuffed);
            assert_eq!(unstuff(&mut frame), Some(plain.len()));
            assert_eq!(&frame[..plain.len()], plain);
        }
    }

    #[test]
    fn every_length_goes_there_and_back_and_what_is_too_long_is_none() {
        for zeros in [1, 2, 3, 7, 500] {
            for length in 0..254 {
                let plain: std::vec::Vec<u8> = (0..length).map(|n| if n % zeros == 0 { 0 } else { n as u8 | 1 }).collect();
                let mut frame = plain.clone();
                frame.insert(0, 0);
                stuff(&mut frame).unwrap();
                assert!(frame.iter().all(|byte| *byte != 0));
                assert_eq!(unstuff(&mut frame), Some(length));
                assert_eq!(frame[..length], plain);
            }
        }
        assert_eq!(stuff(&mut [1; 255]), None, "another code byte would be needed");
        assert_eq!(stuff(&mut []), None);
        for bad in [&mut [3, 1][..], &mut [1, 1, 5], &mut [2, 0, 1], &mut []] {
            assert_eq!(unstuff(bad), None);
        }
    }
}
