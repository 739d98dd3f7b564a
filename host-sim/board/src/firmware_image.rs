//! The firmware's ELF file: it gives the function at an address, the opcode there, and the symbols
//! that must not be linked in.

use object::{Object, ObjectSection, ObjectSymbol, SectionKind, SymbolKind};

/// Why an image could not be read.
#[derive(Debug, thiserror::Error)]
#[error("not a readable ELF image: {0}; build it with `cargo fw`")]
pub struct ImageError(#[from] object::read::Error);

/// A function of the image.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Function {
    /// Address of the first instruction.
    pub address: u32,
    /// Length [bytes]; 0 where the assembler gave none.
    pub bytes: u32,
    /// Path of the function, without the compiler's hash.
    pub name: String,
}

/// Code and names of a linked image.
pub struct FirmwareImage {
    /// Functions by address.
    functions: Vec<Function>,
    code: Vec<(u32, Vec<u8>)>,
    symbols: Vec<String>,
}

impl FirmwareImage {
    /// Reads a linked ELF file.
    pub fn parse(elf: &[u8]) -> Result<Self, ImageError> {
        let file = object::File::parse(elf)?;
        let symbols: Vec<String> =
            file.symbols().filter_map(|s| s.name().ok().map(|n| format!("{:#}", rustc_demangle::demangle(n)))).collect();
        let mut functions: Vec<Function> = file
            .symbols()
            .filter(|s| s.kind() == SymbolKind::Text && s.is_definition())
            .filter_map(|s| {
                let name = s.name().ok().filter(|n| !n.starts_with('$'))?; // $t, $d: mapping symbols, not names
                Some(Function {
                    address: u32::try_from(s.address()).ok()? & !1, // bit 0 marks Thumb
                    bytes: u32::try_from(s.size()).ok()?,
                    name: format!("{:#}", rustc_demangle::demangle(name)),
                })
            })
            .collect();
        // of several functions with one address, keep the longest, then the first name in the
        // alphabet
        functions.sort_by(|a, b| (a.address, b.bytes, &a.name).cmp(&(b.address, a.bytes, &b.name)));
        functions.dedup_by_key(|f| f.address);
        let mut code = Vec::new();
        for section in file.sections().filter(|s| s.kind() == SectionKind::Text) {
            if let Ok(address) = u32::try_from(section.address()) {
                code.push((address, section.data()?.to_vec()));
            }
        }
        Ok(Self { functions, code, symbols })
    }

    /// Functions in the order of their addresses.
    #[must_use]
    pub fn functions(&self) -> &[Function] {
        &self.functions
    }

    /// The function that contains an address.
    #[must_use]
    pub fn function_at(&self, address: u32) -> Option<&Function> {
        let at = self.functions.partition_point(|f| f.address <= address).checked_sub(1)?;
        self.functions.get(at).filter(|f| f.bytes == 0 || address - f.address < f.bytes)
    }

    /// The function with this path, if there is exactly one.
    #[must_use]
    pub fn function_named(&self, name: &str) -> Option<&Function> {
        let mut named = self.functions.iter().filter(|f| f.name == name);
        named.next().filter(|_| named.next().is_none())
    }

    /// The halfword at an address, from the code sections.
    #[must_use]
    pub fn halfword_at(&self, address: u32) -> Option<u16> {
        self.code.iter().find_map(|(start, bytes)| {
            let at = usize::try_from(address.checked_sub(*start)?).ok()?;
            bytes.get(at..)?.first_chunk().map(|b| u16::from_le_bytes(*b))
        })
    }

    /// Names of all symbols, demangled.
    pub fn symbols(&self) -> impl Iterator<Item = &str> {
        self.symbols.iter().map(String::as_str)
    }
}

#[cfg(test)]
mod tests {
    use super::{FirmwareImage, Function};

    fn image(symbols: &[&str]) -> FirmwareImage {
        let function = |address, bytes, name: &str| Function { address, bytes, name: name.into() };
        FirmwareImage {
            functions: vec![function(0x100, 8, "a"), function(0x108, 0, "b"), function(0x200, 4, "c")],
            code: vec![(0x100, vec![0x70, 0x47, 0x00, 0xBF])],
            symbols: symbols.iter().map(|s| (*s).into()).collect(),
        }
    }

    #[test]
    fn addresses_find_their_function() {
        let image = image(&[]);
        let name = |address| image.function_at(address).map(|f| f.name.as_str());
        assert_eq!(name(0x0FE), None);
        assert_eq!(name(0x106), Some("a"));
        assert_eq!(name(0x1FE), Some("b")); // a function without a size extends to the next
        assert_eq!(name(0x204), None);
    }

    #[test]
    fn halfwords_are_little_endian_and_bounded() {
        let image = image(&[]);
        assert_eq!(image.halfword_at(0x100), Some(0x4770));
        assert_eq!(image.halfword_at(0x103), None);
        assert_eq!(image.halfword_at(0x0FF), None);
    }
}
