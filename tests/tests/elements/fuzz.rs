//! Damaged files of every format, read in a process of their own: each is answered without a panic,
//! within two seconds of a processor and a gigabyte of memory. In the long form each reader is
//! tried for an hour.

use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Duration;

use palpate_tests::surface_text::{Triangles, ball};
use palpate_tissue::clock::thread_time;
use palpate_tissue::mesh::import::open;
use proptest::prelude::*;
use proptest::strategy::ValueTree;
use proptest::test_runner::TestRunner;

use crate::file_variants::{gmsh, polydata, polydata_xml, solids, stl_text, vtk};
use crate::mesh_import::block::regular;
use crate::mesh_import::damage::{apply, damage};
use crate::mesh_import::write::{FORMATS, Format, write};

/// Folder of the file that is read, given to the process that reads.
const FOLDER: &str = "PALPATE_TEST_READS_IN";
/// CPU time of each reader [s], in the same process.
const SECONDS: &str = "PALPATE_TEST_READS_FOR_S";
const QUICK_S: u64 = 1;
const LONG_S: u64 = 3600;
/// Most CPU time for one file.
const SLOWEST: Duration = Duration::from_secs(2);
/// Most address space of the process that reads [bytes].
#[cfg(target_os = "linux")]
const MOST_BYTES: u64 = 1 << 30;

struct Seed {
    name: &'static str,
    content: Vec<u8>,
    unit_m: f64,
}

fn tets(of: impl Fn(Format) -> bool) -> Vec<Seed> {
    let mesh = regular([2; 3]);
    let seed = |format| {
        let (name, content) = write(format, &mesh, 3);
        Seed { name, content, unit_m: 1.0 }
    };
    FORMATS.into_iter().filter(|format| of(*format)).map(seed).collect()
}

fn seeds(reader: &str) -> Vec<Seed> {
    let small = ball(20.0, 1);
    let seed = |name, content: Vec<u8>| Seed { name, content, unit_m: 1e-3 };
    let text = |name, content: String| seed(name, content.into_bytes());
    match reader {
        "gmsh" => {
            let mixed = solids("mixed");
            let own = ["2.2", "4.0", "4.1"].map(|version| text("a.msh", gmsh(&mixed, version, 2, false)));
            let format =
                |f| matches!(f, Format::Gmsh1 | Format::Gmsh2 | Format::Gmsh4 | Format::Gmsh2Binary(_) | Format::Gmsh4Binary(_));
            tets(format).into_iter().chain(own).collect()
        }
        "vtk" => {
            let prisms = solids("prisms");
            let own = [
                text("a.vtk", vtk(&prisms, false, true, false)),
                text("a.vtk", polydata(&small, true, false)),
                text("a.vtk", polydata(&small, false, true)),
            ];
            let format = |f| matches!(f, Format::Vtk4 | Format::Vtk5 | Format::Vtk4Binary | Format::Vtk5Binary);
            tets(format).into_iter().chain(own).collect()
        }
        "vtu" => {
            let own = text("a.vtp", polydata_xml(&small, true));
            tets(|f| matches!(f, Format::Vtu(..))).into_iter().chain([own]).collect()
        }
        "stl" => vec![
            text("a.stl", small.stl()),
            seed("a.stl", small.binary_stl()),
            text("a.stl", stl_text(&small, "SOLID", (true, true))),
        ],
        "obj" => vec![text("a.obj", small.obj()), text("a.obj", quads(&small))],
        _ => vec![text("a.ply", small.ply()), seed("a.ply", binary_ply(&small))],
    }
}

/// OBJ with lines that are continued, numbers that count backward, and a polygon of many corners.
fn quads(surface: &Triangles) -> String {
    let all = (1..=surface.corners_mm.len()).map(|n| n.to_string()).collect::<Vec<_>>().join(" \\\n");
    surface.obj().replace("f 1//1", "f -18//1") + &format!("f {all}\n")
}

fn binary_ply(surface: &Triangles) -> Vec<u8> {
    let head = surface.ply().replace("ascii", "binary_big_endian");
    let end = head.find("end_header\n").map_or(0, |at| at + "end_header\n".len());
    let mut bytes = head.as_bytes()[..end].to_vec();
    bytes.extend(surface.corners_mm.iter().flatten().flat_map(|x| (*x as f32).to_be_bytes()));
    for triangle in &surface.triangles {
        bytes.push(3);
        bytes.extend(triangle.iter().flat_map(|n| (*n as u32).to_be_bytes()));
    }
    bytes
}

/// Reads damaged files in a folder until the time is over.
fn read_in(folder: &Path, reader: &str) {
    let all = Duration::from_secs(std::env::var(SECONDS).unwrap().parse().unwrap());
    let seeds = seeds(reader);
    for seed in &seeds {
        let path = folder.join(seed.name);
        std::fs::write(&path, &seed.content).unwrap();
        // the polygon of many corners is no sound surface, but is read as far as its faces
        let sound = open(&path, seed.unit_m).map(|_| ()).map_err(|error| error.to_string());
        assert!(sound.is_ok() || reader == "obj", "{}: {sound:?}", seed.name);
    }
    // from here on: the process itself is in memory
    #[cfg(target_os = "linux")]
    {
        use rustix::process::{Resource, Rlimit, setrlimit};
        setrlimit(Resource::As, Rlimit { current: Some(MOST_BYTES), maximum: Some(MOST_BYTES) }).unwrap();
    }
    let damages = (0..seeds.len(), prop::collection::vec(damage(), 1..8));
    let mut runner = if all.as_secs() == QUICK_S { TestRunner::deterministic() } else { TestRunner::default() };
    let mut files = 0_u64;
    while thread_time() < all {
        let (n, damages) = damages.new_tree(&mut runner).unwrap().current();
        let mut content = seeds[n].content.clone();
        damages.iter().for_each(|damage| apply(&mut content, damage));
        let path = folder.join(seeds[n].name);
        std::fs::write(&path, &content).unwrap();
        let began = thread_time();
        let read = open(&path, seeds[n].unit_m);
        let spent = thread_time() - began;
        assert!(spent < SLOWEST, "{} takes {spent:?}", path.display());
        if let Err(error) = read {
            let line = error.to_string();
            assert!(!line.contains(['\n', '\r']) && line.contains(": ") && line.len() < 600, "{line:?}");
        }
        files += 1;
    }
    println!("{reader}: {files} files");
    assert!(files > 10, "{reader} read {files} files");
}

/// Tries a reader in a process of its own for this CPU time; the file that ends it is kept.
#[track_caller]
fn try_reader(reader: &str, test: &str, seconds: u64) {
    if let Some(folder) = std::env::var_os(FOLDER) {
        return read_in(Path::new(&folder), reader);
    }
    let folder = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join(format!("read-{test}"));
    let _ = std::fs::remove_dir_all(&folder);
    std::fs::create_dir_all(&folder).unwrap();
    let output = Command::new(std::env::current_exe().unwrap())
        .args(["--exact", &format!("fuzz::{test}"), "--include-ignored", "--nocapture"])
        .envs([(FOLDER, folder.as_os_str()), (SECONDS, seconds.to_string().as_ref())])
        .output()
        .unwrap();
    let said = [output.stdout, output.stderr].map(|bytes| String::from_utf8_lossy(&bytes).into_owned()).concat();
    assert!(output.status.success(), "a file in {} ends the reader ({}):\n{said}", folder.display(), output.status);
    assert!(said.contains(&format!("{reader}: ")), "the process read nothing:\n{said}");
    print!("{said}");
}

macro_rules! readers {
    ($($reader:literal: $quick:ident, $long:ident;)*) => {$(
        #[test]
        fn $quick() {
            try_reader($reader, stringify!($quick), QUICK_S);
        }

        #[test]
        #[ignore = "long: an hour"]
        fn $long() {
            try_reader($reader, stringify!($long), LONG_S);
        }
    )*};
}

readers! {
    "gmsh": damaged_gmsh_is_answered, damaged_gmsh_is_answered_for_an_hour;
    "vtk": damaged_vtk_is_answered, damaged_vtk_is_answered_for_an_hour;
    "vtu": damaged_xml_vtk_is_answered, damaged_xml_vtk_is_answered_for_an_hour;
    "stl": damaged_stl_is_answered, damaged_stl_is_answered_for_an_hour;
    "obj": damaged_obj_is_answered, damaged_obj_is_answered_for_an_hour;
    "ply": damaged_ply_is_answered, damaged_ply_is_answered_for_an_hour;
}
