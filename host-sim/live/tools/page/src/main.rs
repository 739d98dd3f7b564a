//! `palpate-live-page MODULE.wasm FOLDER [WEB]`: writes the module and its JavaScript. With `WEB`,
//! the folder of the page's own files, it also writes the whole page as one file, which needs no
//! server.

mod one_file;

use std::io::Write;
use std::path::Path;
use std::process::ExitCode;

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let (module, folder, web) = match arguments.as_slice() {
        [module, folder] => (module, folder, None),
        [module, folder, web] => (module, folder, Some(web)),
        _ => {
            eprintln!("palpate-live-page: give the module, the folder and, for one file as well, that of the page's own files");
            return ExitCode::from(2);
        }
    };
    let mut bindgen = wasm_bindgen_cli_support::Bindgen::new();
    let made = bindgen
        .input_path(Path::new(module))
        .web(true)
        .and_then(|b| b.typescript(false).remove_producers_section(true).remove_name_section(true).generate(folder));
    let made = made.map_err(|why| format!("{why:#}")).and_then(|()| {
        let folder = Path::new(folder);
        pack(folder).map_err(|why| why.to_string())?;
        web.map_or(Ok(()), |web| one_file::write(folder, Path::new(web)))
    });
    match made {
        Ok(()) => ExitCode::SUCCESS,
        Err(why) => {
            eprintln!("palpate-live-page: {module}: {why}");
            ExitCode::from(2)
        }
    }
}

/// Packs the module in the form that the page loads.
fn pack(folder: &Path) -> std::io::Result<()> {
    let bound = folder.join("palpate_live_bg.wasm");
    let file = std::fs::File::create(folder.join("palpate_live.wasm.gz"))?;
    let mut packer = flate2::write::GzEncoder::new(file, flate2::Compression::best());
    packer.write_all(&std::fs::read(&bound)?)?;
    packer.finish()?;
    std::fs::remove_file(bound)
}
