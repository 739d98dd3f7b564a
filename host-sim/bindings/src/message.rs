//! Message of the last call that failed, one per thread, in a fixed buffer, so that a tick that
//! fails does not allocate either.

use std::cell::RefCell;
use std::ffi::c_char;
use std::fmt::{Display, Write};

/// Size of the buffer for a message and its closing zero [bytes]; longer messages are truncated.
const BYTES: usize = 1024;

struct Text {
    bytes: [u8; BYTES],
    length: usize,
}

thread_local! {
    static LAST: RefCell<Text> = const { RefCell::new(Text { bytes: [0; BYTES], length: 0 }) };
}

/// Stores a message as one line.
pub fn keep(message: &dyn Display) {
    LAST.with_borrow_mut(|text| {
        text.length = 0;
        // writing fails only if the message is truncated
        let _cut = write!(text, "{message}");
        let length = text.length;
        text.bytes[length] = 0;
    });
}

/// Pointer to the message, which ends with a zero; valid in this thread until its next call that
/// fails.
pub fn last() -> *const c_char {
    LAST.with_borrow(|text| text.bytes.as_ptr().cast())
}

impl Write for Text {
    fn write_str(&mut self, more: &str) -> std::fmt::Result {
        for letter in more.chars() {
            let letter = if letter.is_control() { ' ' } else { letter };
            if self.length + letter.len_utf8() >= BYTES {
                return Err(std::fmt::Error);
            }
            self.length += letter.encode_utf8(&mut self.bytes[self.length..]).len();
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn kept(message: &str) -> String {
        keep(&message);
        LAST.with_borrow(|text| {
            let end = text.bytes.iter().position(|b| *b == 0).unwrap();
            String::from_utf8(text.bytes[..end].to_vec()).unwrap()
        })
    }

    #[test]
    fn a_message_is_one_line_and_a_long_one_is_cut_between_letters() {
        assert_eq!(kept("two\nlines"), "two lines");
        assert_eq!(kept(&"\u{fc}".repeat(2000)), "\u{fc}".repeat((BYTES - 1) / 2));
        assert_eq!(kept("short"), "short");
    }
}
