use palpate::Params;
use palpate_sim::calibrate::accuracy::Accuracy;
use palpate_sim::calibrate::reference_map::ReferenceMap;
use palpate_sim::calibrate::{Fit, Settings, Targets, calibrate};
use palpate_sim::far_field::{FarField, Sizes};
use palpate_sim::mesh::block_with_rim;
use palpate_sim::patch::{Material, Tissue};
use palpate_sim::reference::answer::Answer;
use palpate_sim::statics::Vector;

fn main() {
    // R mm, fine mm, growth, variant, places, rounds, points, glued 0/1
    let a: Vec<f64> = std::env::args().skip(1).map(|a| a.parse().unwrap()).collect();
    let size_m = [0.08, 0.08, 0.04];
    let sizes = Sizes { radius_m: a[0] * 1e-3, fine_m: a[1] * 1e-3, fine_radius_m: 0.008, growth: a[2], stroke_m: [0.0; 3] };
    let (places, rounds, points) = (a[4] as usize, a[5] as usize, a[6] as usize);
    let mesh = block_with_rim(size_m, [0.0; 2], &sizes, a[3] as u32).unwrap();
    let anchors = (0_u32..).zip(&mesh.nodes_m).filter(|(_, x)| x[2] < -0.0399).map(|(n, _)| n).collect();
    let stiffness_ratio = vec![1.0; mesh.tets.len()];
    let whole = Tissue::closed(mesh, stiffness_ratio, anchors, [0.0; 3], 0.01);
    let material = Material { points_per_triangle: points, ..Material::default() };
    let params = Params::default();
    let far = FarField::of(&whole, &sizes, &material, &params).unwrap();
    let tissue = &far.cut.patch;
    println!(
        "{a:?}: {} nodes {} tets rim {} mended {}",
        tissue.mesh.nodes_m.len(),
        tissue.mesh.tets.len(),
        far.cut.rim.len(),
        far.springs.mended
    );
    let answer = Answer::block();
    let map = ReferenceMap::of(&answer).unwrap();
    let mut top: Vec<usize> = tissue.skin.iter().flatten().map(|n| *n as usize).collect();
    top.sort_unstable();
    top.dedup();
    let surface: Vec<(usize, Vector)> = top.into_iter().map(|n| (n, Vector::from(tissue.mesh.nodes_m[n]))).collect();
    let mut targets = Targets::over_a_disc(&map, &surface, Vector::zeros(), 0.008, 1.15, places).unwrap();
    if a[7] > 0.0 {
        targets = targets.with_glued(&answer.glued[..2]);
    }
    let settings = Settings { places, rounds, fit: Fit::GaussNewton };
    let mut last = String::new();
    let fit = calibrate(tissue, &material, Some(&far.springs), &params, &targets, &settings, &mut |r| {
        last = format!(
            "{:>3} cost {:>9.1} rms {:.3} dent {:.4} {:.1}s",
            r.evaluations, r.cost, r.force_rms_pct, r.dent_mean_mm, r.elapsed_s
        );
        println!("{last}");
    })
    .unwrap();
    let acc = Accuracy::of(&fit.patch, &fit.params, &map, 1.0, 60).unwrap();
    for f in &acc.forces {
        println!(
            "{:>5.2} mm centred {:+.2}  disc rms {:.2} worst {:+.2}",
            f.depth_mm,
            f.centred_pct,
            f.disc_rms_pct.unwrap_or(f64::NAN),
            f.disc_worst_pct.unwrap_or(f64::NAN)
        );
    }
    println!(
        "{a:?} centred rms .5-8: {:.2}; disc 1-4: {:?} glued {:?}",
        acc.centred_rms_pct(&[0.5, 1.0, 2.0, 3.0, 4.0, 6.0, 8.0]),
        acc.disc_pct(&[1.0, 2.0, 4.0]),
        acc.glued
    );
}
