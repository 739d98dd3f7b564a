//! The header is identical to the output of cbindgen for the present sources.

use std::path::PathBuf;

use palpate_tests::palpate_command::repository;

fn folder() -> PathBuf {
    repository().join("host-sim/bindings")
}

fn generated() -> Vec<u8> {
    let config = cbindgen::Config::from_file(folder().join("cbindgen.toml")).unwrap();
    let sources = ["code.rs", "records.rs", "ffi.rs"].map(|file| folder().join("src").join(file));
    let builder = sources.iter().fold(cbindgen::Builder::new().with_config(config), |builder, file| builder.with_src(file));
    let mut header = Vec::new();
    builder.generate().unwrap().write(&mut header);
    header
}

#[test]
fn the_header_is_current() {
    let (header, path) = (String::from_utf8(generated()).unwrap(), folder().join("include/palpate.h"));
    assert!(header.contains("palpate_tick(palpate_session session, const double *tip_m, double *force_n)"));
    assert!(
        std::fs::read_to_string(&path).unwrap() == header,
        "{} is not what its sources give: cargo test --release --workspace --test bindings -- --ignored rewrite_the_header",
        path.display()
    );
}

#[test]
#[ignore = "writes the header anew"]
fn rewrite_the_header() {
    std::fs::write(folder().join("include/palpate.h"), generated()).unwrap();
}
