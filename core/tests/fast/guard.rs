//! The guard of a shipped patch: how deep and how fast it is pressed, and the force that it
//! outputs.

use palpate::stages::probe;
use palpate::{
    Bristle, ClampFlags, Faded, Fault, Node, NodeStep, Output, Params, PatchFile, ProbePose, State, TetShapes, Tuned, Vector3,
    tick,
};

/// Bytes of a patch on a word boundary.
#[repr(align(4))]
struct Words<Bytes: ?Sized>(Bytes);

static BLOCK: &Words<[u8]> = &Words(*include_bytes!("../../../firmware/patches/block-m4f-168.patch"));
static FINE_BLOCK: &Words<[u8]> = &Words(*include_bytes!("../../../firmware/patches/block-m7-480.patch"));
static LIVER: &Words<[u8]> = &Words(*include_bytes!("../../../firmware/patches/liver-m4f-168.patch"));

/// A block of tissue that is pressed along its normal at its site.
pub struct Tissue {
    pub file: PatchFile<'static>,
    pub tuned: Tuned<'static>,
    pub state: State<'static>,
}

impl Tissue {
    /// Creates the tissue at rest, not yet touched.
    pub fn new() -> Self {
        Self::with(|_| ())
    }

    /// Creates the tissue with parameters changed by `change`.
    pub fn with(change: impl Fn(&mut Params)) -> Self {
        Self::of(&BLOCK.0, change)
    }

    /// A piece that was cut out of a liver; its sides cannot be touched.
    pub fn cut() -> Self {
        Self::of(&LIVER.0, |_| ())
    }

    /// A block of smaller tets.
    pub fn fine(change: impl Fn(&mut Params)) -> Self {
        Self::of(&FINE_BLOCK.0, change)
    }

    fn of(bytes: &'static [u8], change: impl Fn(&mut Params)) -> Self {
        let mut file = PatchFile::open(bytes).unwrap();
        change(&mut file.params);
        Self::of_file(file)
    }

    /// Tissue of an opened file.
    pub fn of_file(file: PatchFile<'static>) -> Self {
        let (nodes, triangles) = (file.model.nodes.len(), file.model.triangles.len());
        let tuned = file.params.build(&file.model, vec![NodeStep::ZERO; nodes].leak()).unwrap();
        let shapes = vec![TetShapes::ZERO; TetShapes::count(&file.model)].leak();
        let state = State::new(&file.model, vec![Node::ZERO; nodes].leak(), vec![0; triangles].leak(), shapes).unwrap();
        let state = state.with_relaxation(vec![Faded::ZERO; nodes].leak()).unwrap();
        let state = state.with_friction(vec![Bristle::ZERO; nodes].leak());
        Self { file, tuned, state }
    }

    /// Runs one tick with the tip at this place above the site [m].
    pub fn at(&mut self, above_m: Vector3<f32>) -> Output {
        tick(&self.file.model, &self.tuned, &mut self.state, ProbePose { tip_m: self.file.site_m + above_m })
    }

    /// Runs one tick with the tip this high above the site [m].
    pub fn high(&mut self, z_m: f32) -> Output {
        self.at(Vector3::new(0.0, 0.0, z_m))
    }

    /// Approaches from free space, presses to a depth [m] at 40 mm/s, and waits.
    pub fn press(&mut self, depth_m: f32) -> Output {
        self.high(5e-3);
        let ticks = ((5e-3 + depth_m) / 40e-6) as usize;
        (0..ticks).for_each(|n| _ = self.high(5e-3 - 40e-6 * n as f32));
        (0..200).map(|_| self.high(-depth_m)).last().expect("at least one")
    }
}

#[test]
fn a_press_is_answered_along_the_normal_and_ends_with_the_contact() {
    let mut tissue = Tissue::new();
    let free = tissue.high(5e-3);
    assert_eq!((free.force_n, free.depth_m, free.normal, free.fault), (Vector3::zeros(), 0.0, Vector3::zeros(), None));
    let pressed = tissue.press(3e-3);
    assert!(pressed.force_n.z > 0.05 && pressed.normal.z > 0.99, "{pressed:?}");
    assert!((pressed.depth_m - 3e-3).abs() < 0.2e-3, "{pressed:?}");
    assert!((pressed.force_n - pressed.normal * pressed.force_n.norm()).norm() < 1e-5);
    assert!(pressed.active_nodes > 20 && pressed.limiters == ClampFlags::default());
    let gone = (0..50).map(|n| tissue.high(1e-3 * f32::from(n as u8))).last().expect("ticks");
    assert_eq!((gone.force_n, gone.depth_m), (Vector3::zeros(), 0.0));
}

#[test]
fn the_patch_is_never_shown_deeper_than_it_answers() {
    let mut tissue = Tissue::new();
    let limit_m = tissue.file.model.depth_limit_m;
    tissue.press(limit_m - 0.1e-3);
    let mut held = false;
    (0..60_u8).for_each(|n| held |= tissue.high(0.1e-3 - limit_m - 40e-6 * f32::from(n)).limiters.contains(ClampFlags::DEPTH));
    assert!(held, "and it says so");
    let pressed = tissue.high(-limit_m - 2.3e-3);
    let shown_m = pressed.depth_m - pressed.apart_m;
    assert!(shown_m < 1.02 * limit_m && shown_m > 0.9 * limit_m, "{shown_m} of {limit_m} m");
    assert_eq!(pressed.fault, None);
}

/// Without a continuation, the force of the block stays at 0.19 N from 5 mm on, and the hand falls
/// through.
#[test]
fn beyond_the_depth_limit_the_force_goes_on_rising_and_comes_back_the_same() {
    for mut tissue in [Tissue::new(), Tissue::cut(), Tissue::fine(|_| ())] {
        let limit_m = tissue.file.model.depth_limit_m;
        tissue.press(limit_m - 0.5e-3);
        let normal = tissue.tuned.probe().axis;
        let mut held = |depth_m: f32| (0..100).map(|_| tissue.at(normal * -depth_m)).last().unwrap();
        let own_n = [0.0, 5e-3].map(|beyond_m| held(limit_m + beyond_m)).map(|at| at.force_n.dot(&normal) - at.continuation_n);
        assert!((own_n[1] / own_n[0] - 1.0).abs() < 0.01, "the tissue's own force stays: {own_n:?} N");
        let mut held_n = |depth_m: f32| held(depth_m).force_n.dot(&normal);
        let depths_m: Vec<f32> = (0..12).map(|n| limit_m + 0.5e-3 * (n as f32 - 1.0)).collect();
        let way_in: Vec<f32> = depths_m.iter().map(|m| held_n(*m)).collect();
        let slope = |pair: &[f32]| (pair[1] - pair[0]) / 0.5e-3;
        let before = slope(&way_in[..2]);
        for pair in way_in[1..].windows(2) {
            assert!((0.6 * before..1.2 * before).contains(&slope(pair)), "{way_in:?}");
        }
        for (depth_m, force_n) in depths_m.iter().zip(&way_in).rev() {
            let back_n = held_n(*depth_m);
            assert!((back_n / force_n - 1.0).abs() < 0.01, "{depth_m} m: {force_n} N, then {back_n} N");
        }
    }
}

#[test]
fn the_largest_force_holds_beyond_the_depth_limit_too() {
    let mut tissue = Tissue::with(|params| params.limits.max_force_n = 0.25);
    let limit_m = tissue.file.model.depth_limit_m;
    let pressed = tissue.press(limit_m + 4e-3);
    assert!(pressed.limiters.contains(ClampFlags::FORCE) && (pressed.force_n.norm() - 0.25).abs() < 1e-6, "{pressed:?}");
}

#[test]
fn the_patch_sinks_no_faster_than_its_limit() {
    // below the speed limit, which is the sink limit of a coarse patch and would hold in its place
    let mut tissue = Tissue::with(|params| params.limits.max_sink_m_per_s = 0.4 * params.limits.max_speed_m_per_s);
    tissue.press(1e-3);
    let most_m = tissue.file.params.limits.max_sink_m_per_s * 1e-3;
    let before_m = tissue.high(-1e-3).depth_m;
    let output = tissue.high(-1e-3 - 5.0 * most_m);
    assert!(output.limiters.contains(ClampFlags::SPEED));
    assert!(output.depth_m - before_m < 1.05 * most_m, "{} m in a tick, limit {most_m}", output.depth_m - before_m);
    let output = tissue.high(-1e-3 - 5.0 * most_m);
    assert!((output.depth_m - before_m - 2.0 * most_m).abs() < 0.15 * most_m, "and it follows");
}

#[test]
fn a_probe_that_starts_inside_gets_no_force_until_it_has_been_outside() {
    let mut tissue = Tissue::new();
    for _ in 0..50 {
        let output = tissue.high(-3e-3);
        assert_eq!((output.force_n, output.fault), (Vector3::zeros(), None));
        assert!(output.limiters.contains(ClampFlags::BURIED));
    }
    (0..80).for_each(|n| _ = tissue.high(-3e-3 + 0.2e-3 * n as f32));
    let pressed = tissue.press(2e-3);
    assert!(pressed.force_n.z > 0.02 && !pressed.limiters.contains(ClampFlags::BURIED));
}

#[test]
fn a_pose_that_is_not_finite_is_a_latched_fault() {
    for axis in 0..3 {
        for bad in [f32::NAN, f32::INFINITY] {
            let mut tissue = Tissue::new();
            tissue.press(1e-3);
            let mut above_m = Vector3::new(0.0, 0.0, -1e-3);
            above_m[axis] = bad;
            let output = tissue.at(above_m);
            assert_eq!((output.fault, output.force_n), (Some(Fault::PoseNotFinite), Vector3::zeros()));
            assert_eq!(tissue.high(-1e-3).fault, Some(Fault::PoseNotFinite), "latched");
            assert_eq!(tissue.state.fault(), Some(Fault::PoseNotFinite));
            tissue.state.reset(&tissue.file.model);
            assert_eq!(tissue.high(5e-3).fault, None);
        }
    }
}

#[test]
fn a_node_faster_than_a_hundred_metres_per_second_is_a_fault() {
    let node = |tissue: &Tissue| {
        tissue
            .file
            .model
            .nodes
            .iter()
            .enumerate()
            .find(|(n, _)| tissue.tuned.mass_kg(*n).is_some_and(f32::is_finite))
            .map(|(n, _)| n)
    };
    for (m_per_s, fault) in
        [(50.0, None), (160.0, Some(Fault::Diverged)), (f32::NAN, Some(Fault::Diverged)), (1e5, Some(Fault::Diverged))]
    {
        let mut tissue = Tissue::new();
        tissue.high(30e-3);
        let n = node(&tissue).unwrap();
        let at_m = tissue.state.nodes()[n].position_m();
        tissue.state.place(n, at_m, Vector3::new(m_per_s, 0.0, 0.0));
        let output = tissue.high(30e-3);
        assert_eq!((output.fault, output.force_n), (fault, Vector3::zeros()), "{m_per_s} m/s");
        assert_eq!(tissue.high(30e-3).fault, fault, "latched");
    }
}

#[test]
fn pressed_along_the_surface_the_patch_is_shown_no_faster_than_its_limit() {
    for out in [Vector3::x(), -Vector3::x(), Vector3::y(), -Vector3::y()] {
        let mut tissue = Tissue::new();
        tissue.press(2e-3);
        let longest_m = tissue.file.params.limits.max_speed_m_per_s * tissue.file.params.tick_s;
        let tip_m = tissue.file.site_m + out * (3.0 * longest_m) - Vector3::new(0.0, 0.0, 2e-3);
        let motion = probe::admit(&tissue.file.model, &tissue.tuned, &mut tissue.state, ProbePose { tip_m }).unwrap();
        let moved_m = motion.to_m - motion.from_m;
        assert!((moved_m - out * longest_m).norm() < 0.05 * longest_m, "{moved_m} of {longest_m} m");
        assert!((motion.velocity_m_per_s - moved_m * 1e3).norm() < 1e-3 && motion.limiters.contains(ClampFlags::SPEED));
    }
}
