use palpate::*;
use palpate_sim::mesh::*;
use palpate_sim::patch::*;
fn main() {
    let n: usize = std::env::args().nth(1).map_or(410, |a| a.parse().unwrap());
    let t0 = std::time::Instant::now();
    let mesh = block(&BlockSpec { size_m: [0.08, 0.08, 0.04], nodes: n, fine_at_m: [0.0, 0.0], fine_radius_m: 0.008 }).unwrap();
    let anchors: Vec<u32> = (0..mesh.nodes_m.len() as u32).filter(|&i| mesh.nodes_m[i as usize][2] <= -0.04).collect();
    println!("mesh {:?} nodes {} tets {} anchors {}", t0.elapsed(), mesh.nodes_m.len(), mesh.tets.len(), anchors.len());
    let tissue = Tissue { stiffness_ratio: vec![1.0; mesh.tets.len()], mesh, anchors, site_m: [0.0; 3], depth_limit_m: std::env::var("D").map_or(0.012, |v| v.parse().unwrap()) };
    let mut mat = Material::default();
    let arg = |k: &str, d: f64| std::env::var(k).ok().map_or(d, |v| v.parse().unwrap());
    mat.foundation_stiffness = arg("KW", mat.foundation_stiffness);
    mat.foundation_stiffening = arg("S", mat.foundation_stiffening);
    mat.per_tet_share = arg("BETA", mat.per_tet_share);
    let t0 = std::time::Instant::now();
    let patch = Patch::build(&tissue, &mat, None);
    println!("build {:?}", t0.elapsed());
    let mut params = Params::default();
    params.mass_floor = arg("F", 6.0) as f32;
    params.compensation = arg("CHI", 1.13) as f32;
    params.compensation_threshold = arg("TAU", 0.073) as f32;
    params.youngs_modulus_pa = arg("E", 3500.0) as f32;
    if arg("SPRINGS", 0.0) > 0.0 { params.terms = Terms::SPRINGS_ONLY; }
    let e = params.youngs_modulus_pa;
    let models = [patch.model(), patch.wide_model()];
    println!("springs {} tris {}", models[0].springs.len(), models[0].triangles.len());
    let t0 = std::time::Instant::now();
    let st = palpate_sim::stable_step::StableStep::measure(&patch.wide_model(), &params, patch.site_m()).unwrap();
    println!("stable {st:?} {:?}", t0.elapsed());
    for (name, terms) in [("plain springs", Terms::SPRINGS_ONLY), ("all", Terms::ALL)] {
        let p = Params { terms, ..params };
        let mut mem = Memory::for_model(&models[0]);
        for (m, model) in models.iter().enumerate() {
        let (tuned, mut state) = mem.start(model, &p).unwrap();
        for z in [0.01f32] {
        let mut best = f64::MAX;
        for _ in 0..40 { let t0 = std::time::Instant::now(); for _ in 0..100 { tick(model, &tuned, &mut state, ProbePose { tip_m: Vector3::new(0.0, 0.0, z) }); } best = best.min(t0.elapsed().as_secs_f64() * 1e4); }
        println!("{name} {m} z {z} {best:.2} us");
        }}
    }
    let mut mem = Memory::for_model(&models[0]);
    for model in &models[..0] {
        let (tuned, mut state) = mem.start(model, &params).unwrap();
        let mut z = 0.003_f32;
        let reference = [(0.0005, 1.700*1.0), (0.001, 5.0), (0.002, 14.065), (0.004, 39.65), (0.006, 71.9), (0.008, 107.0)];
        for (hold, r) in reference {
            while z > -hold { z = (z - 4e-5).max(-hold); tick(model, &tuned, &mut state, ProbePose { tip_m: Vector3::new(0.0, 0.0, z) }); }
            let mut o = Output::NONE;
            for _ in 0..300 { o = tick(model, &tuned, &mut state, ProbePose { tip_m: Vector3::new(0.0, 0.0, z) }); }
            let t0 = std::time::Instant::now();
            for _ in 0..2000 { o = tick(model, &tuned, &mut state, ProbePose { tip_m: Vector3::new(0.0, 0.0, z) }); }
            let us = t0.elapsed().as_secs_f64() / 2000.0 * 1e6;
            let f = o.force_n.z / e * 1e6;
            println!("{hold} F/E {f:.3} mm2 err {:+.1}% depth {:.4} fault {:?} {us:.2} us {:x}", (f / r - 1.0) * 100.0, o.depth_m, o.fault, state.hash());
        }
    }
}
