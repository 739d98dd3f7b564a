//! Consistent overhead byte stuffing (Cheshire and Baker, IEEE/ACM Trans. Networking 7, 1999): no
//! zero occurs inside a frame, so a zero ends it. The encoding is implemented here because the
//! link-time proof that a tick cannot panic covers it. Frames are shorter than 254 bytes, so one
//! code byte leads to the next zero.

/// Longest run that one code byte describes.
const RUN: usize = 254;

/// Stuffs `plain` into `out`; returns the number of bytes written. `None` if they do not fit or
/// `plain` is too long for one code byte.
pub fn stuff(plain: &[u8], out: &mut [u8]) -> Option<usize> {
    let mut places = out.iter_mut().enumerate();
    let mut length = 1;
    let (_, mut code) = places.next()?;
    let mut run = 1_u8;
    for byte in plain {
        let (at, place) = places.next()?;
        if *byte == 0 {
            *core::mem::replace(&mut code, place) = core::mem::replace(&mut run, 1);
        } else {
            *place = *byte;
            run = run.checked_add(1)?;
        }
        length = at + 1;
    }
    *code = run;
    (plain.len() < RUN).then_some(length)
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
            let mut out = [0; 8];
            let length = stuff(plain, &mut out).unwrap();
            assert_eq!(&out[..length], stuffed);
            assert_eq!(unstuff(&mut out[..length]), Some(plain.len()));
            assert_eq!(&out[..plain.len()], plain);
        }
    }

    #[test]
    fn every_length_goes_there_and_back_and_what_does_not_fit_is_none() {
        for zeros in [1, 2, 3, 7, 500] {
            for length in 0..254 {
                let plain: std::vec::Vec<u8> = (0..length).map(|n| if n % zeros == 0 { 0 } else { n as u8 | 1 }).collect();
                let mut out = [0xEE; 256];
                let took = stuff(&plain, &mut out).unwrap();
                assert!(took == length + 1 && out[..took].iter().all(|byte| *byte != 0));
                assert_eq!(unstuff(&mut out[..took]), Some(length));
                assert_eq!(out[..length], plain);
                assert_eq!(stuff(&plain, &mut [0; 256][..length]), None);
            }
        }
        assert_eq!(stuff(&[1; 254], &mut [0; 300]), None, "another code byte would be needed");
        for bad in [&mut [3, 1][..], &mut [1, 1, 5], &mut [2, 0, 1], &mut []] {
            assert_eq!(unstuff(bad), None);
        }
    }
}
