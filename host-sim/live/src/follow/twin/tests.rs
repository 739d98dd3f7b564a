use super::super::patches::Given;
use super::*;

/// Shipped patches for boards; the second one is tilted and away from the centre.
const BOARDS: [&str; 2] = ["block-m4f-168", "liver-m4f-168"];

fn chosen(name: &str) -> Chosen {
    let path = format!("{}/../../firmware/patches/{name}.patch", env!("CARGO_MANIFEST_DIR"));
    Given::of(None, Some(path.as_ref())).unwrap().chosen(0).unwrap()
}

/// Number of the record that a board sends in a tick.
fn at(tick: u32) -> usize {
    (tick / RECORD_TICKS) as usize
}

/// Position of the tip in a press of 3 mm that also slides, in the frame of the device [m].
fn pressed_m(tick: u32) -> V {
    let share = (f32::from(tick as u16) / 1000.0).min(1.0);
    let deep = 0.5 - 0.5 * (share * std::f32::consts::PI).cos();
    V::new(0.002 * share, -0.001 * share, 0.004 - 0.007 * deep)
}

/// Records of a board that is pressed along this path, computed from every tick.
fn records(name: &str, youngs_modulus_pa: Option<f32>) -> Vec<Step> {
    let Chosen { mut tissue, checksum, .. } = chosen(name);
    let params = *tissue.params();
    if let Some(youngs_modulus_pa) = youngs_modulus_pa {
        tissue.retune(Params { youngs_modulus_pa, ..params }).unwrap();
    }
    let placement = Placement::new(tissue.patch().site_m(), params.probe.axis);
    let mut steps = Vec::new();
    for tick in 0..1400 {
        let tip_m = pressed_m(tick);
        let output = placement.output_to_device(tissue.render(placement.pose_to_patch(ProbePose { tip_m })));
        assert_eq!(output.fault, None);
        if tick % RECORD_TICKS == 0 {
            let row = Row {
                tick,
                mode: Mode::Active as u8,
                tip_m: tip_m.into(),
                depth_m: output.depth_m,
                model_n: output.force_n.into(),
                applied_n: (output.force_n * 0.5).into(),
                limiters: output.limiters.bits(),
                patch_checksum: checksum.unwrap(),
                youngs_modulus_pa: tissue.params().youngs_modulus_pa,
                ..Row::default()
            };
            steps.push(Step { row, ticks: (tick > 0).then_some(RECORD_TICKS) });
        }
    }
    steps
}

/// Largest force of the board, largest difference where the forces are compared [N], and number of
/// compared records.
fn compared(twin: &mut Twin, steps: &[Step]) -> (f32, f32, usize) {
    let (mut most_n, mut apart_n, mut count) = (0.0_f32, 0.0_f32, 0);
    for step in steps {
        most_n = most_n.max(V::from(step.row.model_n).norm());
        if let Ok(differs_n) = twin.go(step).differs_n {
            (apart_n, count) = (apart_n.max(differs_n), count + 1);
        }
    }
    (most_n, apart_n, count)
}

#[test]
fn the_same_patch_at_the_same_tips_gives_the_boards_force() {
    for name in BOARDS {
        let steps = records(name, None);
        let (most_n, apart_n, count) = compared(&mut Twin::of(chosen(name)), &steps);
        assert!(most_n > 0.03 && apart_n < 0.02 * most_n, "{name}: {apart_n} of {most_n} N");
        assert!(count >= steps.len() - SETTLING as usize - 1, "{name}: {count} of {}", steps.len());
    }
}

#[test]
fn it_has_the_modulus_of_the_board() {
    let own_pa = chosen(BOARDS[0]).tissue.params().youngs_modulus_pa;
    let stiff = records(BOARDS[0], Some(1.5 * own_pa));
    let (most_n, apart_n, _) = compared(&mut Twin::of(chosen(BOARDS[0])), &stiff);
    assert!(apart_n < 0.02 * most_n, "{apart_n} of {most_n} N");
    let row = Row { youngs_modulus_pa: -1.0, ..stiff[at(800)].row };
    let answer = Twin::of(chosen(BOARDS[0])).go(&Step { row, ticks: None });
    assert_eq!(answer.differs_n, Err(Apart::Modulus(-1.0)));
}

#[test]
fn it_catches_up_with_a_press_that_had_begun() {
    let steps = records(BOARDS[0], None);
    let mut twin = Twin::of(chosen(BOARDS[0]));
    let mut late: Vec<Step> = steps[at(600)..].to_vec();
    late[0].ticks = None;
    for step in &late[..SETTLING as usize] {
        assert_eq!(twin.go(step).differs_n, Err(Apart::UnknownWay));
    }
    let (most_n, apart_n, count) = compared(&mut twin, &late[SETTLING as usize..]);
    assert!(apart_n < 0.03 * most_n && count > at(400), "{apart_n} of {most_n} N, {count} records");
}

#[test]
fn lost_records_are_no_known_way() {
    let mut steps = records(BOARDS[0], None);
    let gap = at(400);
    steps.drain(gap..gap + 4);
    steps[gap].ticks = Some(5 * RECORD_TICKS);
    assert_eq!(steps[gap].lost(), 4);
    let mut twin = Twin::of(chosen(BOARDS[0]));
    let answers: Vec<Answer> = steps.iter().map(|step| twin.go(step)).collect();
    let known = gap + SETTLING as usize;
    assert!(answers[gap - 1].differs_n.is_ok());
    assert!(answers[gap..known].iter().all(|answer| answer.differs_n == Err(Apart::UnknownWay)));
    assert!(answers[gap].force_n.is_some() && answers[known].differs_n.is_ok(), "and then it is known again");
}

#[test]
fn what_cannot_be_compared_is_not() {
    let steps = records(BOARDS[0], None);
    let pressed = steps[at(1100)];
    let go = |row: Row| {
        let mut twin = Twin::of(chosen(BOARDS[0]));
        for step in &steps[..at(1100)] {
            twin.go(step);
        }
        let answer = twin.go(&Step { row, ..pressed });
        let (moved, rest) = (twin.frame(&row, 1).nodes_m, Twin::of(chosen(BOARDS[0])).frame(&row, 1).nodes_m);
        (answer, moved.iter().zip(&rest).map(|(a, b)| (V::from(*a) - V::from(*b)).norm()).fold(0.0, f32::max))
    };
    assert!(matches!(go(pressed.row), (Answer { force_n: Some(_), differs_n: Ok(_) }, moved_m) if moved_m > 1e-3));
    for mode in [Mode::Boot, Mode::Idle, Mode::Fault] {
        let (answer, moved_m) = go(Row { mode: mode as u8, ..pressed.row });
        assert_eq!((answer, moved_m), (Answer { force_n: None, differs_n: Err(Apart::Rests) }, 0.0), "{mode:?}");
    }
    let (other, _) = go(Row { patch_checksum: 1, ..pressed.row });
    assert!(other.force_n.is_some() && other.differs_n == Err(Apart::OtherPatch));
    assert_eq!(go(Row { limiters: ClampFlags::SPEED.bits(), ..pressed.row }).0.differs_n, Err(Apart::HeldBack));
    let (buried, moved_m) = go(Row { limiters: ClampFlags::BURIED.bits(), ..pressed.row });
    let none = Answer { force_n: None, differs_n: Err(Apart::HeldBack) };
    assert_eq!((buried, moved_m), (none, 0.0), "the board's patch gives none either");
    // 40 mm from one record to the next, which the patch's guard does not follow
    let far_m = [pressed.row.tip_m[0] + 0.04, pressed.row.tip_m[1], pressed.row.tip_m[2]];
    assert_eq!(go(Row { tip_m: far_m, ..pressed.row }).0.differs_n, Err(Apart::HeldBack));
}

#[test]
fn tip_and_force_stand_where_the_patch_is() {
    for name in BOARDS {
        let twin = Twin::of(chosen(name));
        let (site_m, axis) = (twin.tissue.patch().site_m(), twin.tissue.params().probe.axis);
        let row = Row { tip_m: [0.0, 0.0, 0.003], applied_n: [0.0, 0.0, 0.25], ..Row::default() };
        let frame = twin.frame(&row, 7);
        // the tip is outside, 3 mm above the site along the axis of the press
        assert!((V::from(frame.tip_m) - (site_m + axis * 0.003)).norm() < 1e-7, "{name}: {:?}", frame.tip_m);
        assert!((V::from(frame.force_n) - axis * 0.25).norm() < 1e-7, "{name}: {:?}", frame.force_n);
        assert_eq!((frame.body, frame.contact_m), (7, frame.tip_m));
    }
    let liver = chosen(BOARDS[1]).tissue;
    assert!(liver.patch().site_m().norm() > 0.01 && liver.params().probe.axis.z < 0.99, "no trial of the frame");
}
