//! Decodes a `DataArray` of XML VTK, from its text or its bytes.
//!
//! Bytes begin with a header. Without compression it is their length. With compression it has the
//! number of blocks, the unpacked lengths of a block and of the last block, and the packed length
//! of each block.

use std::io::Read;

use base64::Engine;
use base64::prelude::BASE64_STANDARD;
use flate2::read::ZlibDecoder;

use crate::mesh::bytes::Order;
use crate::mesh::error::{Defect, quoted};
use crate::mesh::file::MAX_FILE_MIB;

/// Encoding of numbers that a file does not write as text.
#[derive(Clone, Copy, Debug)]
pub(super) struct Encoding {
    pub order: Order,
    /// Whether headers are 64 bits wide, not 32.
    pub wide: bool,
    pub zlib: bool,
}

/// An array that is not decoded yet.
pub(super) struct Array<'a> {
    data: Data<'a>,
    kind: Kind,
    encoding: Encoding,
}

#[derive(Clone, Copy)]
pub(super) enum Data<'a> {
    Text(&'a str),
    Base64(&'a [u8]),
    Raw(&'a [u8]),
}

/// Type of a number, with its size [bytes].
#[derive(Clone, Copy, PartialEq)]
enum Kind {
    Real(usize),
    Signed(usize),
    Unsigned(usize),
}

impl Array<'_> {
    /// Decodes `count` finite numbers.
    pub fn reals(&self, count: u64) -> Result<Vec<f64>, Defect> {
        let Kind::Real(size) = self.kind else {
            return Err(Defect::Expected { what: "coordinates of type Float32 or Float64", found: "whole numbers".into() });
        };
        let values: Vec<f64> = if let Data::Text(text) = self.data {
            words(text, count, "a coordinate")?
        } else {
            let bytes = self.bytes(count, size)?;
            let real =
                |b: &[u8]| if size == 4 { f64::from(f32::from_bits(self.bits(b) as u32)) } else { f64::from_bits(self.bits(b)) };
            bytes.chunks_exact(size).map(real).collect()
        };
        match values.iter().find(|value| !value.is_finite()) {
            Some(value) => Err(Defect::NotFinite { what: "a coordinate", found: value.to_string() }),
            None => Ok(values),
        }
    }

    /// Decodes `count` numbers that are whole and at least 0.
    pub fn wholes(&self, count: u64) -> Result<Vec<u64>, Defect> {
        let what = "a whole number from 0";
        let (size, signed) = match self.kind {
            Kind::Signed(size) => (size, true),
            Kind::Unsigned(size) => (size, false),
            Kind::Real(_) => return Err(Defect::Expected { what, found: "an array of reals".into() }),
        };
        if let Data::Text(text) = self.data {
            return words(text, count, what);
        }
        let bytes = self.bytes(count, size)?;
        let values: Vec<u64> = bytes.chunks_exact(size).map(|b| self.bits(b)).collect();
        let is_negative = |bits: &u64| signed && bits >> (8 * size - 1) & 1 == 1;
        match values.iter().find(|bits| is_negative(bits)) {
            Some(_) => Err(Defect::Expected { what, found: "a negative one".into() }),
            None => Ok(values),
        }
    }

    /// The bits of a number of up to eight bytes.
    fn bits(&self, bytes: &[u8]) -> u64 {
        let join = |bits: u64, byte: &u8| bits << 8 | u64::from(*byte);
        match self.encoding.order {
            Order::Big => bytes.iter().fold(0, join),
            Order::Little => bytes.iter().rev().fold(0, join),
        }
    }

    /// The bytes of `count` numbers.
    fn bytes(&self, count: u64, size: usize) -> Result<Vec<u8>, Defect> {
        let most = MAX_FILE_MIB << 20;
        let length = count.checked_mul(size as u64).filter(|length| *length <= most);
        let length = length.ok_or(Defect::FileTooLarge { limit_mib: MAX_FILE_MIB })? as usize;
        let mut source: Box<dyn Read> = match self.data {
            Data::Raw(data) => Box::new(data),
            Data::Base64(data) => Box::new(Base64::new(data)),
            Data::Text(_) => Box::new(std::io::empty()),
        };
        let found = if self.encoding.zlib { self.unpacked(&mut source, length)? } else { self.plain(&mut source, length)? };
        if found.len() == length {
            return Ok(found);
        }
        let (announced, found) = (count, (found.len() / size) as u64);
        Err(Defect::TooFew { section: "the DataArray", items: "numbers", announced, found })
    }

    fn plain(&self, source: &mut dyn Read, length: usize) -> Result<Vec<u8>, Defect> {
        let says = self.header(source)?;
        if says != length as u64 {
            return Err(Defect::Disagree { what: "the DataArray's header (bytes)", says, found: length as u64 });
        }
        read_up_to(source, length)
    }

    fn unpacked(&self, source: &mut dyn Read, length: usize) -> Result<Vec<u8>, Defect> {
        let blocks = self.header(source)?;
        let (block, last) = (self.header(source)?, self.header(source)?);
        let mut packed = Vec::new();
        for _ in 0..blocks {
            packed.push(self.header(source)?);
        }
        // The last block may be a full one; the header then has 0 for its length.
        let total = if last == 0 {
            blocks.checked_mul(block)
        } else {
            blocks.saturating_sub(1).checked_mul(block).and_then(|n| n.checked_add(last))
        };
        if blocks > 0 && total != Some(length as u64) {
            let says = total.unwrap_or(u64::MAX);
            return Err(Defect::Disagree { what: "the DataArray's header (bytes)", says, found: length as u64 });
        }
        let mut bytes = Vec::new();
        for size in packed {
            let size = usize::try_from(size).map_err(|_| truncated())?;
            let data = read_up_to(source, size)?;
            let room = (length - bytes.len()) as u64;
            let unpacked = ZlibDecoder::new(data.as_slice()).take(room).read_to_end(&mut bytes);
            unpacked.map_err(|_| Defect::Expected { what: "data packed by zlib", found: "other bytes".into() })?;
        }
        Ok(bytes)
    }

    fn header(&self, source: &mut dyn Read) -> Result<u64, Defect> {
        let size = if self.encoding.wide { 8 } else { 4 };
        let bytes = read_up_to(source, size)?;
        if bytes.len() == size { Ok(self.bits(&bytes)) } else { Err(truncated()) }
    }
}

impl<'a> Data<'a> {
    /// Combines the data with the type of its numbers; `None` if the type is not one of numbers.
    pub fn of_type(self, name: &str, encoding: Encoding) -> Option<Array<'a>> {
        let kind = match name {
            "Float32" => Kind::Real(4),
            "Float64" => Kind::Real(8),
            "Int8" => Kind::Signed(1),
            "Int16" => Kind::Signed(2),
            "Int32" => Kind::Signed(4),
            "Int64" => Kind::Signed(8),
            "UInt8" => Kind::Unsigned(1),
            "UInt16" => Kind::Unsigned(2),
            "UInt32" => Kind::Unsigned(4),
            "UInt64" => Kind::Unsigned(8),
            _ => return None,
        };
        Some(Array { data: self, kind, encoding })
    }
}

fn truncated() -> Defect {
    Defect::Truncated { what: "the numbers of the DataArray" }
}

/// The next `length` bytes, or as many as there are.
fn read_up_to(source: &mut dyn Read, length: usize) -> Result<Vec<u8>, Defect> {
    let mut bytes = Vec::new();
    match source.take(length as u64).read_to_end(&mut bytes) {
        Ok(_) => Ok(bytes),
        Err(cause) => Err(Defect::Expected { what: "base64", found: quoted(&cause.to_string()) }),
    }
}

fn words<T: std::str::FromStr>(text: &str, count: u64, what: &'static str) -> Result<Vec<T>, Defect> {
    let mut values = Vec::new();
    for word in text.split_ascii_whitespace() {
        values.push(word.parse().map_err(|_| Defect::Expected { what, found: quoted(word) })?);
    }
    let (section, items, announced, found) = ("the DataArray", "numbers", count, values.len() as u64);
    match found.cmp(&announced) {
        std::cmp::Ordering::Equal => Ok(values),
        std::cmp::Ordering::Less => Err(Defect::TooFew { section, items, announced, found }),
        std::cmp::Ordering::Greater => Err(Defect::TooMany { section, items, announced }),
    }
}

/// Decodes base64. VTK ends the code after a header and begins again, so that `=` may occur
/// anywhere.
struct Base64<'a> {
    rest: &'a [u8],
    decoded: [u8; 3],
    /// Bytes of `decoded` not yet returned.
    left: std::ops::Range<usize>,
}

impl<'a> Base64<'a> {
    fn new(rest: &'a [u8]) -> Self {
        Self { rest, decoded: [0; 3], left: 0..0 }
    }

    /// Decodes the next four characters, skipping white space between them.
    fn refill(&mut self) -> std::io::Result<()> {
        let (mut quad, mut have) = ([0; 4], 0);
        while have < quad.len() {
            let Some((byte, rest)) = self.rest.split_first() else { break };
            // `<` ends an appended array, or all of them.
            if *byte == b'<' {
                break;
            }
            self.rest = rest;
            if !byte.is_ascii_whitespace() {
                quad[have] = *byte;
                have += 1;
            }
        }
        if have == 0 {
            return Ok(());
        }
        let length = BASE64_STANDARD.decode_slice_unchecked(&quad[..have], &mut self.decoded).map_err(std::io::Error::other)?;
        self.left = 0..length;
        Ok(())
    }
}

impl Read for Base64<'_> {
    fn read(&mut self, into: &mut [u8]) -> std::io::Result<usize> {
        let mut given = 0;
        while given < into.len() {
            if self.left.is_empty() {
                self.refill()?;
            }
            let Some(at) = self.left.next() else { break };
            into[given] = self.decoded[at];
            given += 1;
        }
        Ok(given)
    }
}
