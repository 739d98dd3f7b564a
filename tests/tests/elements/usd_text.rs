//! USD text: what is read of it, and what is refused.

use palpate_tissue::mesh::Imported;
use palpate_tissue::mesh::import::{MeshFile, open};

/// A tet of 40 mm, with what other programs write around one.
pub const TET: &str = "#usda 1.0
(
    doc = \"\"\"A { def TetMesh
}\"\"\"
    customLayerData = { double metersPerUnit = 3 }
    metersPerUnit = 0.001 # millimetres
    upAxis = \"Z\"
)
def Xform \"a\" (
    kind = \"component\"
)
{
    double3 xformOp:translate = (0, 0, 0)
    float3 xformOp:scale = (1, 1, 1)
    matrix4d xformOp:transform = ( (1, 0, 0, 0), (0, 1, 0, 0), (0, 0, 1, 0), (0, 0, 0, 1) )
    uniform token[] xformOpOrder = [\"xformOp:translate\", \"xformOp:scale\"]
    def TetMesh \"t\" (
        customData = { int points = 3 }
        prepend apiSchemas = [\"PhysicsVolumeDeformableSimAPI\"]
    )
    {
        point3f[] physics:restShapePoints = [(7, 7, 7)]
        point3f[] points = [(0, 0, 0), (40, 0, 0),
            (0, 40, 0), (0, 0, 4e1),]
        point3f[] points.timeSamples = { 0: [(1, 1, 1)] }
        int4[] tetVertexIndices = [(0, 1, 2, 3)]
    }
}
";

fn read(content: &[u8]) -> Result<Imported, String> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.usda");
    std::fs::write(&path, content).unwrap();
    match open(&path, 1e-3).map_err(|error| error.to_string().replace(&path.display().to_string(), "FILE"))? {
        MeshFile::Tets(imported) => Ok(imported),
        MeshFile::Surface(_) => panic!("USD has no surfaces"),
    }
}

#[test]
fn the_tets_of_usd_text_are_read() {
    let found = read(TET.as_bytes()).unwrap();
    assert_eq!(found.mesh.nodes_m, [[0.0; 3], [0.04, 0.0, 0.0], [0.0, 0.04, 0.0], [0.0, 0.0, 0.04]]);
    assert_eq!((found.mesh.tets, found.report.format), (vec![[0, 1, 2, 3]], "USD text"));
    // a left-handed file
    let turned = read(TET.replace("(0, 1, 2, 3)", "(0, 2, 1, 3)").as_bytes()).unwrap();
    assert_eq!((turned.report.flipped_tets, turned.mesh.volume_m3()), (1, found.report.volume_m3));
}

#[test]
fn an_up_axis_turns_the_mesh_and_a_light_beside_it_does_not_matter() {
    let up = read(TET.replace("\"Z\"", "\"Y\"").as_bytes()).unwrap();
    // z, x, y of the file are the scene's x, y, z
    assert_eq!(up.mesh.nodes_m, [[0.0; 3], [0.0, 0.04, 0.0], [0.0, 0.0, 0.04], [0.04, 0.0, 0.0]]);
    assert!(up.report.notes().iter().any(|note| note.contains("turned, unless the scene has tissue.up")));
    let light = "def DistantLight \"l\" {\n float3 xformOp:rotateXYZ = (315, 0, 0)\n double3 xformOp:translate.timeSamples = { 0: (1, 1, 1) }\n}\n";
    let lit = TET.replace("def Xform", &format!("{light}def Xform")) + light;
    assert_eq!(read(lit.as_bytes()).unwrap().mesh, read(TET.as_bytes()).unwrap().mesh);
}

#[test]
fn what_usd_text_cannot_give_is_one_sentence() {
    for (from, to, says) in [
        ("TetMesh \"t\"", "Mesh \"t\"", "FILE: no tets, only 1 surface (Mesh): mesh the volume"),
        ("= 0.001", "= 0.01", "FILE:6: the file says metersPerUnit = 0.01, but 0.001 m per unit were given"),
        ("translate = (0, 0, 0)", "translate = (0, 0, 1)", "FILE:13: the transform `xformOp:translate` is not read: export with"),
        ("translate = (0, 0, 0)", "translate.timeSamples = { 0: (1, 1, 1) }", "FILE:13: the transform `xformOp:translate.timeSa"),
        (
            "point3f[] points = [",
            "float3 xformOp:scale = (2, 1, 1)\n point3f[] points = [",
            "FILE:23: the transform `xformOp:scale` is not read",
        ),
        ("(0, 1, 0, 0), (0", "(0, 2, 0, 0), (0", "FILE:15: the transform `xformOp:transform` is not read"),
        ("(0, 1, 2, 3)", "(0, 1, 2, 4)", "FILE:26: tet 0 names node 4, but the file has 4 nodes"),
        ("(0, 1, 2, 3)", "(0, 1, 2)", "FILE:26: expected `,` between numbers, found `)`"),
        ("(0, 1, 2, 3)]", "", "FILE:27: expected `(` or the end of an array, found `}`"),
        ("(40, 0, 0)", "(nan, 0, 0)", "FILE:23: a coordinate is `nan`, not a finite number"),
        ("(0, 1, 2, 3)]\n    }\n}\n", "(0, 1, 2", "FILE:26: the file ends before"),
        ("    }\n}\n", "    }\n    def TetMesh \"u\" {}\n}\n", "FILE:28: second TetMesh: keep one"),
    ] {
        let content = TET.replace(from, to);
        assert_ne!(content, TET, "{from}");
        let said = read(content.as_bytes()).expect_err(from);
        assert!(said.starts_with(says) && !said.contains('\n'), "{from} -> {to}: {said}");
    }
    assert!(read(b"PXR-USDC\0\x08").unwrap_err().contains("usdcat FILE -o FILE.usda"));
}
