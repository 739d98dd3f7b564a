//! Reads a binary mesh file from start to end.

use super::error::{Defect, MeshError, quoted};

/// Order of the bytes of a number.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Order {
    Little,
    Big,
}

/// Type of a number in a file.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Number {
    Real(usize),
    Signed(usize),
    Unsigned(usize),
}

impl Number {
    /// Type of this name in legacy VTK, whatever its case; `None` for text and bits.
    pub fn of_vtk(name: &str) -> Option<Self> {
        Some(match name.to_ascii_lowercase().as_str() {
            "float" => Self::Real(4),
            "double" => Self::Real(8),
            "char" | "signed_char" | "vtktypeint8" => Self::Signed(1),
            "short" | "vtktypeint16" => Self::Signed(2),
            "int" | "vtkidtype" | "vtktypeint32" => Self::Signed(4),
            "long" | "long_long" | "vtktypeint64" => Self::Signed(8),
            "unsigned_char" | "vtktypeuint8" => Self::Unsigned(1),
            "unsigned_short" | "vtktypeuint16" => Self::Unsigned(2),
            "unsigned_int" | "vtktypeuint32" => Self::Unsigned(4),
            "unsigned_long" | "unsigned_long_long" | "vtktypeuint64" => Self::Unsigned(8),
            _ => return None,
        })
    }

    /// Type of this name in PLY.
    pub fn of_ply(name: &str) -> Option<Self> {
        Some(match name {
            "float" | "float32" => Self::Real(4),
            "double" | "float64" => Self::Real(8),
            "char" | "int8" => Self::Signed(1),
            "short" | "int16" => Self::Signed(2),
            "int" | "int32" => Self::Signed(4),
            "uchar" | "uint8" => Self::Unsigned(1),
            "ushort" | "uint16" => Self::Unsigned(2),
            "uint" | "uint32" => Self::Unsigned(4),
            _ => return None,
        })
    }

    /// Size of a number [bytes].
    pub fn size(self) -> usize {
        match self {
            Self::Real(size) | Self::Signed(size) | Self::Unsigned(size) => size,
        }
    }
}

/// The bytes not yet read. A count from the file is used only as a loop bound or as a length that
/// is checked against the remaining bytes: no memory is allocated for it.
pub(super) struct Bytes<'a> {
    pub file: &'a str,
    pub order: Order,
    rest: &'a [u8],
}

impl<'a> Bytes<'a> {
    pub fn new(file: &'a str, data: &'a [u8], order: Order) -> Self {
        Self { file, order, rest: data }
    }

    /// An error for a defect that belongs to no line.
    pub fn error(&self, defect: Defect) -> MeshError {
        MeshError { file: self.file.to_owned(), line: None, defect }
    }

    /// An error: the file has `found` where `what` is expected.
    pub fn unexpected(&self, what: &'static str, found: &str) -> MeshError {
        self.error(Defect::Expected { what, found: quoted(found) })
    }

    pub fn take(&mut self, length: usize, what: &'static str) -> Result<&'a [u8], MeshError> {
        let (taken, rest) = self.rest.split_at_checked(length).ok_or_else(|| self.error(Defect::Truncated { what }))?;
        self.rest = rest;
        Ok(taken)
    }

    /// Skips `count` items of `size` bytes.
    pub fn skip(&mut self, count: u64, size: usize, what: &'static str) -> Result<(), MeshError> {
        let length = usize::try_from(count).ok().and_then(|count| count.checked_mul(size));
        let length = length.ok_or_else(|| self.error(Defect::Truncated { what }))?;
        self.take(length, what).map(drop)
    }

    fn number<const N: usize>(&mut self, what: &'static str) -> Result<[u8; N], MeshError> {
        let mut bytes = [0; N];
        bytes.copy_from_slice(self.take(N, what)?);
        if self.order == Order::Big {
            bytes.reverse();
        }
        Ok(bytes)
    }

    pub fn i32(&mut self, what: &'static str) -> Result<i32, MeshError> {
        self.number(what).map(i32::from_le_bytes)
    }

    /// Reads an `i32` that is a count, number or code: at least 0.
    pub fn whole_i32(&mut self, what: &'static str) -> Result<u64, MeshError> {
        let value = self.i32(what)?;
        u64::try_from(value).map_err(|_| self.unexpected(what, &value.to_string()))
    }

    pub fn u64(&mut self, what: &'static str) -> Result<u64, MeshError> {
        self.number(what).map(u64::from_le_bytes)
    }

    /// Reads a number of any type; of 64 bits, 53 are kept.
    pub fn any(&mut self, number: Number, what: &'static str) -> Result<f64, MeshError> {
        let size = number.size();
        let taken = self.take(size, what)?;
        let join = |bits: u64, byte: &u8| bits << 8 | u64::from(*byte);
        let bits = match self.order {
            Order::Big => taken.iter().fold(0, join),
            Order::Little => taken.iter().rev().fold(0, join),
        };
        let unused = 64 - 8 * size as u32;
        Ok(match number {
            Number::Real(4) => f64::from(f32::from_bits(bits as u32)),
            Number::Real(_) => f64::from_bits(bits),
            // shifted up and down again, the sign is that of the number
            Number::Signed(_) => ((bits << unused) as i64 >> unused) as f64,
            Number::Unsigned(_) => bits as f64,
        })
    }

    /// Reads a number of any type as a finite coordinate in file units.
    pub fn any_coordinate(&mut self, number: Number) -> Result<f64, MeshError> {
        let what = "a coordinate";
        let value = self.any(number, what)?;
        if value.is_finite() { Ok(value) } else { Err(self.error(Defect::NotFinite { what, found: value.to_string() })) }
    }

    /// Reads a number of any type as a count, index or code: whole and at least 0.
    pub fn any_whole(&mut self, number: Number, what: &'static str) -> Result<u64, MeshError> {
        let value = self.any(number, what)?;
        // beyond this a 64-bit number is not exact, and no file has as many of anything
        let most = (1_u64 << 53) as f64;
        let is_whole = value.fract() == 0.0 && (0.0..most).contains(&value);
        if is_whole { Ok(value as u64) } else { Err(self.unexpected(what, &value.to_string())) }
    }

    /// Reads a finite coordinate in file units, in single or double precision.
    pub fn coordinate(&mut self, double: bool) -> Result<f64, MeshError> {
        let what = "a coordinate";
        let value =
            if double { f64::from_le_bytes(self.number(what)?) } else { f64::from(f32::from_le_bytes(self.number(what)?)) };
        if value.is_finite() { Ok(value) } else { Err(self.error(Defect::NotFinite { what, found: value.to_string() })) }
    }

    pub fn position(&mut self, double: bool) -> Result<[f64; 3], MeshError> {
        Ok([self.coordinate(double)?, self.coordinate(double)?, self.coordinate(double)?])
    }

    /// The next line of text that is not blank, trimmed; `None` at the end of the file.
    pub fn line(&mut self) -> Option<String> {
        self.rest = self.rest.trim_ascii_start();
        if self.rest.is_empty() { None } else { Some(self.any_line()) }
    }

    /// The next line of text even if it is blank.
    pub fn any_line(&mut self) -> String {
        let end = self.rest.iter().position(|byte| *byte == b'\n').map_or(self.rest.len(), |at| at + 1);
        let (line, rest) = self.rest.split_at(end);
        self.rest = rest;
        String::from_utf8_lossy(line).trim().to_owned()
    }

    /// The next line, without which the file is incomplete.
    pub fn required(&mut self, what: &'static str) -> Result<String, MeshError> {
        self.line().ok_or_else(|| self.error(Defect::Truncated { what }))
    }

    /// Whether the next line starts with `word`, in any case.
    pub fn starts_with(&self, word: &str) -> bool {
        let next = self.rest.trim_ascii_start();
        next.get(..word.len()).is_some_and(|start| start.eq_ignore_ascii_case(word.as_bytes()))
    }

    /// Skips everything up to the line after `tag`; returns whether there is one.
    pub fn skip_past(&mut self, tag: &str) -> bool {
        let found = self.rest.windows(tag.len()).position(|window| window == tag.as_bytes());
        self.rest = found.map_or(&[], |at| &self.rest[at..]);
        if found.is_some() {
            self.any_line();
        }
        found.is_some()
    }
}
