//! Pointers of the caller, read and written with checks for NULL and for room.
#![expect(unsafe_code, reason = "pointers of C are followed here, for the functions of `ffi`")]

use std::ffi::{CStr, c_char};

use crate::code::Failure;

/// Checks the size of a record that the caller names.
pub(crate) fn fits<T>(item: &'static str, have: usize) -> Result<(), Failure> {
    let need = size_of::<T>();
    if have == need { Ok(()) } else { Err(Failure::WrongSize { item, need, have }) }
}

/// # Safety
/// `pointer` is NULL or points to a text that ends with a zero byte and lives as long as the call.
pub(crate) unsafe fn text<'a>(item: &'static str, pointer: *const c_char) -> Result<&'a str, Failure> {
    if pointer.is_null() {
        return Err(Failure::Null(item));
    }
    // SAFETY: it is not NULL, and the caller guarantees the rest
    unsafe { CStr::from_ptr(pointer) }.to_str().map_err(|_| Failure::NotText(item))
}

/// # Safety
/// As [`text`].
pub(crate) unsafe fn maybe_text<'a>(item: &'static str, pointer: *const c_char) -> Result<Option<&'a str>, Failure> {
    // SAFETY: the caller guarantees the pointer
    if pointer.is_null() { Ok(None) } else { unsafe { text(item, pointer) }.map(Some) }
}

/// # Safety
/// `pointer` is NULL or points to `capacity` bytes.
pub(crate) unsafe fn write_text(item: &'static str, pointer: *mut c_char, capacity: usize, content: &str) -> Result<(), Failure> {
    let need = content.len() + 1;
    if capacity < need {
        return Err(Failure::TooSmall { item, need, have: capacity });
    }
    // SAFETY: the caller guarantees the pointer, and there is room
    content
        .bytes()
        .chain([0])
        .enumerate()
        .try_for_each(|(n, byte)| unsafe { write(item, pointer.cast::<u8>().wrapping_add(n), byte) })
}

/// # Safety
/// `pointer` is NULL or points to `capacity` numbers.
pub(crate) unsafe fn write_threes<T>(
    item: &'static str,
    pointer: *mut T,
    capacity: usize,
    threes: impl ExactSizeIterator<Item = [T; 3]>,
) -> Result<(), Failure> {
    let need = 3 * threes.len();
    if capacity < need {
        return Err(Failure::TooSmall { item, need, have: capacity });
    }
    let place = pointer.cast::<[T; 3]>();
    // SAFETY: the caller guarantees the pointer, and there is room for all
    threes.enumerate().try_for_each(|(n, three)| unsafe { write(item, place.wrapping_add(n), three) })
}

/// # Safety
/// `pointer` is NULL or points to `length` bytes that live as long as the call.
pub(crate) unsafe fn array<'a>(item: &'static str, pointer: *const u8, length: usize) -> Result<&'a [u8], Failure> {
    match pointer.is_null() {
        true => Err(Failure::Null(item)),
        false if isize::try_from(length).is_err() => Err(Failure::TooSmall { item, need: length, have: isize::MAX as usize }),
        // SAFETY: not NULL, no longer than memory can be, and the caller guarantees the rest
        false => Ok(unsafe { std::slice::from_raw_parts(pointer, length) }),
    }
}

/// # Safety
/// `pointer` is NULL or points to a `T`, aligned or not.
pub(crate) unsafe fn read<T: Copy>(item: &'static str, pointer: *const T) -> Result<T, Failure> {
    // SAFETY: it is not NULL, and the caller guarantees the rest
    if pointer.is_null() { Err(Failure::Null(item)) } else { Ok(unsafe { pointer.read_unaligned() }) }
}

/// # Safety
/// `pointer` is NULL or points to room for a `T`, aligned or not.
pub(crate) unsafe fn write<T>(item: &'static str, pointer: *mut T, value: T) -> Result<(), Failure> {
    if pointer.is_null() {
        return Err(Failure::Null(item));
    }
    // SAFETY: it is not NULL, and the caller guarantees the rest
    unsafe { pointer.write_unaligned(value) };
    Ok(())
}
