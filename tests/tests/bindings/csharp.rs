//! The C# file: its declarations are those of the header, and what runs under mono gives the bits
//! of Rust.

use std::path::{Path, PathBuf};
use std::process::Command;

use palpate_tests::c_compiler::{has, library, run};
use palpate_tests::palpate_command::repository;

use crate::c_programs::{bits, example, force_n, numbers, session, source};

/// Words of a declaration in C that C# says differently, and how the file says them.
const TYPES: [(&str, &str); 24] = [
    ("const char *", "byte[]"),
    ("char *", "[Out] byte[]"),
    ("const uint8_t *", "byte[]"),
    ("uint32_t *", "[Out] uint[]"),
    ("palpate_session *", "out ulong"),
    ("uint64_t *", "out ulong"),
    ("int32_t *", "out int"),
    ("const struct palpate_input *", "ref Input"),
    ("struct palpate_report *", "out Report"),
    ("struct palpate_info *", "out Info"),
    ("struct palpate_contact *", "out Contact"),
    ("double axes[2][3]", "Axes axes"),
    ("double half_lengths_m[2]", "Pair half_lengths_m"),
    ("palpate_session ", "ulong "),
    ("size_t ", "UIntPtr "),
    ("uint64_t ", "ulong "),
    ("uint32_t ", "uint "),
    ("int32_t ", "int "),
    ("uint8_t reserved[6]", "Six reserved"),
    ("uint8_t ", "byte "),
    ("const double *orientation", "double[] orientation"),
    ("const double *", "ref Vector"),
    ("double *positions_m", "[Out] double[]positions_m"),
    ("double *", "out Vector"),
];

fn csharp() -> PathBuf {
    repository().join("host-sim/bindings/csharp/Palpate.cs")
}

fn text(path: &Path) -> String {
    std::fs::read_to_string(path).unwrap()
}

/// A text without its line comments, and with single spaces.
fn bare(text: &str) -> String {
    let lines = text.lines().map(|line| line.split("//").next().unwrap_or_default());
    lines.flat_map(str::split_whitespace).collect::<Vec<_>>().join(" ")
}

fn packed(text: &str) -> String {
    text.replace(' ', "")
}

fn in_csharp(declared: &str) -> String {
    let array = |text: &str| match text.strip_suffix("[3]").and_then(|text| text.strip_prefix("double ")) {
        Some(name) => format!("Vector {name}"),
        None => text.to_owned(),
    };
    let said = TYPES.iter().find(|(c, _)| declared.starts_with(c));
    packed(&said.map_or_else(|| array(declared), |(c, sharp)| declared.replacen(c, sharp, 1)))
}

/// Functions of the header with their arguments, as C# declares them.
fn functions_of_header(header: &str) -> Vec<String> {
    let statements = bare(header);
    let found = statements.split(';').filter_map(|statement| {
        let (head, arguments) = statement.strip_suffix(')')?.split_once('(')?;
        let (result, name) = head.rsplit_once([' ', '*'])?;
        let arguments = if arguments == "void" { "" } else { arguments };
        let result = if result.ends_with("const char ") { "IntPtr" } else { "Code" };
        Some(format!("{result} {name}({})", arguments.split(", ").map(in_csharp).collect::<Vec<_>>().join(",")))
    });
    sorted(found.collect())
}

fn functions_of_csharp(text: &str) -> Vec<String> {
    let statements = bare(text);
    let found = statements.split(';').filter_map(|statement| statement.split_once("static extern ").map(|(_, rest)| rest));
    let said = found.map(|function| {
        let (head, arguments) = function.split_once('(').unwrap();
        format!("{head}({}", packed(arguments))
    });
    sorted(said.collect())
}

fn sorted(mut lines: Vec<String>) -> Vec<String> {
    lines.sort();
    lines
}

/// Fields of a struct in their order, as C# declares them.
fn fields(text: &str, head: &str) -> Vec<String> {
    let body = text.split_once(head).unwrap_or_else(|| panic!("no {head}")).1.split_once('}').unwrap().0;
    let declared = body.split(';').map(str::trim).filter(|field| !field.is_empty());
    let each = declared.flat_map(|field| {
        let (kind, names) = field.strip_prefix("public ").unwrap_or(field).split_once(' ').unwrap();
        names.split(", ").map(|name| in_csharp(&format!("{kind} {name}"))).collect::<Vec<_>>()
    });
    each.collect()
}

/// Names and numbers of an enum, without the prefix that they have in C.
fn values(text: &str, head: &str, prefix: &str) -> Vec<String> {
    let body = text.split_once(head).unwrap_or_else(|| panic!("no {head}")).1.split_once('}').unwrap().0;
    let named = body.split(',').map(|value| value.trim().replacen(prefix, "", 1).replace([' ', '_'], "").to_lowercase());
    named.filter(|value| !value.is_empty()).collect()
}

/// All differences between the header and the C# file.
fn differences(header: &str, sharp: &str) -> Vec<String> {
    let (c, cs) = (bare(header), bare(sharp));
    let mut pairs = vec![("functions".to_owned(), functions_of_header(header), functions_of_csharp(sharp))];
    for (name, sharp_name) in [("input", "Input"), ("report", "Report"), ("contact", "Contact"), ("info", "Info")] {
        let (head, sharp_head) = (format!("typedef struct palpate_{name} {{"), format!("struct {sharp_name} {{"));
        pairs.push((name.into(), fields(&c, &head), fields(&cs, &sharp_head)));
    }
    for (name, sharp_name) in [("code", "Code"), ("mode", "Mode"), ("stage", "Stage")] {
        let (head, sharp_head) = (format!("typedef enum palpate_{name} {{"), format!("enum {sharp_name} {{"));
        let prefix = format!("PALPATE_{}_", name.to_uppercase());
        pairs.push((name.into(), values(&c, &head, &prefix), values(&cs, &sharp_head, "")));
    }
    let unlike = |(name, c, cs): &(String, Vec<String>, Vec<String>)| {
        let missing = c.iter().find(|line| !cs.contains(line)).or_else(|| cs.iter().find(|line| !c.contains(line)));
        (c != cs || c.is_empty()).then(|| format!("{name}: {missing:?}"))
    };
    pairs.iter().filter_map(unlike).collect()
}

#[test]
fn declarations_in_csharp_are_those_of_the_header() {
    let header = text(&repository().join("host-sim/bindings/include/palpate.h"));
    let sharp = text(&csharp());
    assert_eq!(differences(&header, &sharp), [""; 0]);
    assert!(functions_of_header(&header).len() > 20);
    // the comparison sees each kind of difference
    for (from, to, what) in [
        ("palpate_stop(ulong session)", "palpate_stop(ulong session, int more)", "functions"),
        ("palpate_arm(", "palpate_arms(", "functions"),
        ("ref Vector tip_m, out Vector force_n", "ref Vector tip_m, ref Vector force_n", "functions"),
        ("Vector tip_m, force_n, tissue_n", "Vector force_n, tip_m, tissue_n", "report"),
        ("public ulong nodes, triangles", "public uint nodes, triangles", "info"),
        ("public uint late_ticks;", "", "input"),
        ("Busy = 7", "Busy = 8", "code"),
    ] {
        let changed = sharp.replace(from, to);
        let found = differences(&header, &changed);
        assert!(changed != sharp && found.len() == 1 && found[0].starts_with(what), "{from}: {found:?}");
    }
}

/// Compiles C# files with mono and runs them with the library that cargo built; `None`, with a
/// message, where mono is not installed.
fn ran(files: &[PathBuf], arguments: &[&str]) -> Option<String> {
    let skipped = "C# is compared with the header only: apt-get install mono-mcs mono-runtime";
    if !has("mcs", "--version", skipped) || !has("mono", "--version", skipped) {
        return None;
    }
    let folder = tempfile::tempdir().unwrap();
    let program = folder.path().join("program.exe");
    let _compiled = run(Command::new("mcs").arg("-warnaserror").arg(format!("-out:{}", program.display())).args(files));
    let found = library().with_file_name("");
    Some(run(Command::new("mono").arg(program).args(arguments).env("LD_LIBRARY_PATH", found)))
}

/// Mono prints -0 as 0.
fn unsigned_zero(force_n: [u32; 3]) -> [u32; 3] {
    force_n.map(|bits| if bits == (-0.0_f32).to_bits() { 0 } else { bits })
}

#[test]
fn a_press_in_csharp_equals_rust_to_the_bit() {
    let Some(said) = ran(&[csharp(), example("press.cs")], &["trace"]) else { return };
    let (mut own, mut felt) = (session(), 0);
    let site_m: [f64; 3] = own.tissue().patch().site_m().cast().into();
    let axis: [f64; 3] = own.tissue().params().probe.axis.cast().into();
    let (ticks, state) = said.trim_end().rsplit_once('\n').unwrap();
    assert_eq!(ticks.lines().count(), 2500);
    for (tick, line) in (0_i32..).zip(ticks.lines()) {
        let steps = if tick < 700 { 0 } else { (tick - 700).min(2500 - tick) };
        let depth_m = 1e-5 * f64::from(steps) - 5e-3;
        let found = force_n(&mut own, std::array::from_fn(|k| site_m[k] - axis[k] * depth_m));
        let line = numbers(line);
        assert_eq!(bits(&line[2..]), unsigned_zero(found), "tick {tick}");
        felt += usize::from(line[4] > 0.01);
    }
    assert!(felt > 500, "felt in {felt} ticks");
    assert_eq!(state, format!("state {}", own.hash()));
}

/// The component of Unity with a stand-in of the engine's types: forces, drawing, and a late tick.
#[test]
fn the_component_of_unity_equals_rust_to_the_bit() {
    let component = csharp().with_file_name("PalpateTissue.cs");
    assert!(text(&component).contains("UNTESTED IN UNITY"));
    let Some(said) = ran(&[csharp(), component, source("unity.cs")], &[]) else { return };
    let (mut own, mut felt) = (session(), 0);
    let site_m: [f64; 3] = own.tissue().patch().site_m().cast().into();
    let (ticks, end) = said.trim_end().rsplit_once('\n').unwrap();
    assert_eq!(ticks.lines().count(), 2500);
    for (tick, line) in ticks.lines().map(numbers).enumerate() {
        let found = force_n(&mut own, std::array::from_fn(|k| line[k] + site_m[k]));
        assert_eq!(bits(&line[3..]), unsigned_zero(found), "tick {tick}");
        felt += usize::from(line[5] > 0.01);
    }
    assert!(felt > 500, "felt in {felt} ticks");
    // dented under the tip, drawn from outside, copied once per 16 ticks, no force after a fault
    let [_, dent_m, outside, drawn, last_n, fault] = end.splitn(6, ' ').collect::<Vec<_>>()[..] else { panic!("{end}") };
    assert!((-4e-3..-2e-3).contains(&dent_m.parse::<f64>().unwrap()), "{end}");
    assert_eq!((outside, drawn, last_n, fault), ("True", "158", "0", "palpate: ticks ended too late"), "{end}");
}
