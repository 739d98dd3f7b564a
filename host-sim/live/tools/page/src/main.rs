//! `palpate-live-page MODULE.wasm FOLDER`: writes the module and its JavaScript.

use std::io::Write;
use std::path::Path;
use std::process::ExitCode;

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [module, folder] = arguments.as_slice() else {
        eprintln!("palpate-live-page: give the module and the folder");
        return ExitCode::from(2);
    };
    let mut bindgen = wasm_bindgen_cli_support::Bindgen::new();
    let made = bindgen
        .input_path(Path::new(module))
        .web(true)
        .and_then(|b| b.typescript(false).remove_producers_section(true).remove_name_section(true).generate(folder));
    match made.map_err(|why| format!("{why:#}")).and_then(|()| pack(Path::new(folder)).map_err(|why| why.to_string())) {
        Ok(()) => ExitCode::SUCCESS,
        Err(why) => {
            eprintln!("palpate-live-page: {module}: {why}");
            ExitCode::from(2)
        }
    }
}

/// The module as the page loads it.
fn pack(folder: &Path) -> std::io::Result<()> {
    let bound = folder.join("palpate_live_bg.wasm");
    let file = std::fs::File::create(folder.join("palpate_live.wasm.gz"))?;
    let mut packer = flate2::write::GzEncoder::new(file, flate2::Compression::best());
    packer.write_all(&std::fs::read(&bound)?)?;
    packer.finish()?;
    std::fs::remove_file(bound)
}
