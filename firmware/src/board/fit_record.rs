//! The record of the patch's fit, in a section of the ELF file that no board loads. Hosts read the
//! patch's error from it (`palpate board status`).

/// Content of the record as JSON; empty for a patch without a record.
const JSON: &[u8] = include_bytes!(concat!(env!("OUT_DIR"), "/packed.patch.json"));

// SAFETY: nothing else is put into this section, and no code reads it.
#[used]
#[unsafe(link_section = ".palpate_record")]
static RECORD: [u8; JSON.len()] = *include_bytes!(concat!(env!("OUT_DIR"), "/packed.patch.json"));
