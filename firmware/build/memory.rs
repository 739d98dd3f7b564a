//! The memories of an image's chip, and the parts of the image that are placed in each.

/// Size of the stack, which is below the statics [bytes].
const STACK_BYTES: u32 = 16 * 1024;

/// Size of a memory for code that does not hold the whole core [bytes].
const LEAST_FAST_CODE: u32 = 32 * 1024;

/// A piece of the address space.
#[derive(Clone, Copy)]
pub struct Region {
    origin: u32,
    bytes: u32,
}

/// Memories of a chip.
pub struct Memories {
    flash: Region,
    /// RAM for stack and statics.
    ram: Region,
    /// Memory for code that the core reads without wait states; zero bytes if that is the RAM
    /// itself.
    fast_code: Option<Region>,
    /// Whether the patch is copied to RAM, because reads of the flash wait.
    patch_in_ram: bool,
    /// Memory for large data that is rarely read.
    large: Option<Region>,
    /// Whether the chip's boot loader searches for a block after the vector table.
    boot_block: bool,
}

/// The emulated MPS2 boards have 4 MB each of flash and RAM. Declaring 1 MB of flash and the
/// smallest supported board's 128 KB of RAM keeps the figures realistic.
pub const MPS2: Memories = Memories {
    flash: Region { origin: 0, bytes: 1024 * 1024 },
    ram: Region { origin: 0x2000_0000, bytes: 128 * 1024 },
    fast_code: None,
    patch_in_ram: false,
    large: None,
    boot_block: false,
};

/// Reads the chip's description: flash and RAM begin at the addresses common to all STM32 and
/// extend over all adjoining regions.
#[cfg(feature = "stm32")]
pub fn of_chip() -> Option<Memories> {
    use stm32_metapac::metadata::{METADATA, MemoryRegionKind};

    let memory = METADATA.memory.first()?;
    let named = |name: &str| memory.iter().find(|r| r.name == name).map(|r| Region { origin: r.address, bytes: r.size });
    let from = |origin: u32, flash: bool| {
        let mut end = origin;
        while let Some(next) = memory.iter().find(|r| r.address == end && matches!(r.kind, MemoryRegionKind::Flash) == flash) {
            end += next.size;
        }
        Region { origin, bytes: end - origin }
    };
    for peripheral in METADATA.peripherals {
        let registers = peripheral.registers.as_ref().map(|registers| (registers.kind, registers.version));
        match (peripheral.name, registers) {
            ("TIM1", Some((_, version))) if version != "v1" => println!("cargo:rustc-cfg=break_source"),
            ("DMA1", Some(("dma", _))) => println!("cargo:rustc-cfg=dma_streams"),
            _ => {}
        }
    }
    let fast_code = named("ITCM").or(named("CCMRAM_ICODE"));
    let ram = from(0x2000_0000, false);
    // the same memory under another address
    let again = named("CCMRAM_DCODE").map_or(0, |region| region.bytes);
    // the last two sectors hold profiles (`stm32/profile_slots.rs`)
    let sectors = memory.iter().filter(|r| matches!(r.kind, MemoryRegionKind::Flash)).filter_map(|r| r.settings.as_ref());
    let sector_bytes = sectors.map(|settings| settings.erase_size).max().unwrap_or(0);
    let flash = from(0x0800_0000, true);
    Some(Memories {
        flash: Region { bytes: flash.bytes - 2 * sector_bytes, ..flash },
        ram: Region { bytes: ram.bytes - again, ..ram },
        fast_code,
        patch_in_ram: true,
        large: named("AXISRAM"),
        boot_block: false,
    })
}

/// RP2350 of a Pico 2, by its data sheet: 4 MB of serial flash, of which the last two sectors of
/// 4 KB hold profiles, and 512 KB of contiguous RAM. Its boot ROM looks for a block in the first
/// 4 KB of flash.
#[cfg(feature = "pico2")]
pub fn of_chip() -> Option<Memories> {
    let ram = Region { origin: 0x2000_0000, bytes: 512 * 1024 };
    let flash = Region { origin: 0x1000_0000, bytes: (4 * 1024 - 8) * 1024 };
    Some(Memories { flash, ram, fast_code: Some(Region { bytes: 0, ..ram }), patch_in_ram: true, large: None, boot_block: true })
}

/// Memories of the chip; `None` if no description of it exists.
#[cfg(not(any(feature = "pico2", feature = "stm32")))]
pub fn of_chip() -> Option<Memories> {
    None
}

impl Memories {
    /// The memories as a list for the linker.
    pub fn regions(&self) -> String {
        let line = |name: &str, region: Region| format!("{name} : ORIGIN = {:#x}, LENGTH = {}\n", region.origin, region.bytes);
        let stack = Region { bytes: STACK_BYTES, ..self.ram };
        let ram = Region { origin: self.ram.origin + STACK_BYTES, bytes: self.ram.bytes - STACK_BYTES };
        let fast_code =
            self.fast_code.filter(|region| region.bytes > 0).map_or(String::new(), |region| line("FAST_CODE", region));
        let large = self.large.map_or(String::new(), |region| line("LARGE", region));
        line("FLASH", self.flash) + &line("STACK", stack) + &line("RAM", ram) + &fast_code + &large
    }

    /// The linker's sections: tick and patch in fast memory and the upload in large memory, if the
    /// chip has them; otherwise the symbols exist with zero size.
    ///
    /// All sections are placed after `.uninit`, since the start-up code clears and fills whatever
    /// directly follows `.bss` and `.data`.
    pub fn placement(&self) -> String {
        let section = |name: &str, inputs: &str, place: &str| {
            format!(
                "SECTIONS {{ .{name} : ALIGN(8) {{ __{name}_start = .; {inputs} . = ALIGN(8); __{name}_end = .; }} {place} \
                 __{name}_load = LOADADDR(.{name}); }} INSERT AFTER .uninit;\n"
            )
        };
        let none = |name: &str| format!("__{name}_start = 0; __{name}_end = 0; __{name}_load = 0;\n");
        let all = "*(.text._ZN7palpate4tick* .text._ZN7palpate6stages* .text._ZN7palpate6haptic* .text.palpate*)";
        // what every tick of tissue without memory runs, and sending its record
        let most = "*(.text._ZN7palpate4tick* .text._ZN7palpate6stages5force7armv7em* .text._ZN7palpate6stages5force3rim* \
                    .text._ZN7palpate6stages5force10foundation5press* .text._ZN7palpate6stages9integrate* .text._ZN7palpate6stages8presence* \
                    .text._ZN89_$LT$palpate..haptic..account* .text._ZN7palpate6haptic7account* \
                    .text._ZN18palpate_controller5serve4line7encoded* .text._ZN18palpate_controller4link*)";
        let patch = "*(.rodata._ZN16palpate_firmware11flash_patch*)";
        let fast = self.fast_code.map_or(none("fast_code"), |region| match region.bytes {
            0 => section("fast_code", all, "> RAM AT > FLASH"),
            bytes => section("fast_code", if bytes > LEAST_FAST_CODE { all } else { most }, "> FAST_CODE AT > FLASH"),
        });
        let fast = fast + &if self.patch_in_ram { section("patch", patch, "> RAM AT > FLASH") } else { none("patch") };
        let upload = "*(.bss._ZN16palpate_firmware6UPLOAD*)";
        let large = self.large.map_or(none("large"), |_| section("large", upload, "> LARGE"));
        let block = "SECTIONS { .start_block : ALIGN(4) { KEEP(*(.start_block)); } > FLASH } INSERT AFTER .vector_table;\n\
                     _stext = ADDR(.start_block) + SIZEOF(.start_block);\n";
        // in the ELF file and in no memory
        let record = "SECTIONS { .palpate_record 0 (INFO) : { KEEP(*(.palpate_record)); } }\n";
        fast + &large + if self.boot_block { block } else { "" } + record
    }
}
