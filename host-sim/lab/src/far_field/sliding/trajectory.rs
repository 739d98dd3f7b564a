//! Trajectory of the tip: it is pressed in at one end of the stroke, held, moved forth, held, moved
//! back, and held.

use palpate_fit::statics::Vector;
use palpate_tissue::scene::TICK_S;

/// Speed of the press [m/s].
const PRESS_M_PER_S: f64 = 0.04;
/// Duration of the hold before the first stroke [s], in which node damping stops all motion.
const SETTLE_S: f64 = 0.4;
/// Duration of the hold at the far end, and of that after the return [s].
const PAUSE_S: f64 = 0.2;

/// A slide forth and back at constant depth over a flat top with normal z.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Trajectory {
    /// Middle of the path, on the rest surface [m].
    pub centre_m: Vector,
    /// Displacement from end to end [m].
    pub stroke_m: Vector,
    /// Depth of the tip [m].
    pub depth_m: f64,
    /// Speed, constant from the first tick of a stroke to the last [m/s].
    pub speed_m_per_s: f64,
}

/// Part of a trajectory.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Leg {
    /// The press, and the hold until the first stroke.
    Press,
    /// From the first end to the other.
    Forth,
    /// The hold at the other end.
    Turn,
    /// From there to the first end again.
    Back,
    /// The hold at the first end.
    End,
}

/// A pose of a trajectory.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pose {
    /// Part of the trajectory to which the pose belongs.
    pub leg: Leg,
    /// Signed distance from the middle along the path [m].
    pub along_m: f64,
    /// Position of the tip [m].
    pub tip_m: Vector,
}

impl Trajectory {
    /// Direction of the first stroke, a unit vector.
    #[must_use]
    pub fn direction(&self) -> Vector {
        self.stroke_m.try_normalize(0.0).unwrap_or_else(Vector::x)
    }

    /// Place on the rest surface above a tip at `along_m` [m].
    #[must_use]
    pub fn place_m(&self, along_m: f64) -> Vector {
        self.centre_m + self.direction() * along_m
    }

    /// Pose in every tick of the trajectory, which starts outside the tissue.
    #[must_use]
    pub fn poses(&self) -> Vec<Pose> {
        let half_m = 0.5 * self.stroke_m.norm();
        let mut poses = Vec::new();
        let mut add = |leg, along_m: f64, depth_m: f64| {
            poses.push(Pose { leg, along_m, tip_m: self.place_m(along_m) - Vector::z() * depth_m });
        };
        let step_m = PRESS_M_PER_S * TICK_S;
        let down = (self.depth_m / step_m).ceil() as i32;
        (-2..down).for_each(|n| add(Leg::Press, -half_m, f64::from(n) * step_m));
        (0..ticks(SETTLE_S)).for_each(|_| add(Leg::Press, -half_m, self.depth_m));
        let way = ticks(2.0 * half_m / self.speed_m_per_s).max(1);
        let share = |n: usize| 2.0 * n as f64 / way as f64 - 1.0;
        (1..=way).for_each(|n| add(Leg::Forth, half_m * share(n), self.depth_m));
        (0..ticks(PAUSE_S)).for_each(|_| add(Leg::Turn, half_m, self.depth_m));
        (1..=way).for_each(|n| add(Leg::Back, -half_m * share(n), self.depth_m));
        (0..ticks(PAUSE_S)).for_each(|_| add(Leg::End, -half_m, self.depth_m));
        poses
    }
}

fn ticks(time_s: f64) -> usize {
    (time_s / TICK_S).round() as usize
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_course_is_closed_and_never_faster_than_it_says() {
        let trajectory = Trajectory {
            centre_m: Vector::new(0.01, 0.0, 0.0),
            stroke_m: Vector::new(0.0, 0.03, 0.0),
            depth_m: 0.003,
            speed_m_per_s: 0.07,
        };
        let poses = trajectory.poses();
        let of = |leg: Leg| poses.iter().filter(move |p| p.leg == leg);
        assert!(poses[0].tip_m.z > 0.0, "starts outside");
        assert_eq!(of(Leg::Press).next_back().unwrap().tip_m, of(Leg::End).next_back().unwrap().tip_m);
        let (first, last) = (of(Leg::Turn).next().unwrap(), of(Leg::Press).next_back().unwrap());
        assert!((first.tip_m - last.tip_m - trajectory.stroke_m).norm() < 1e-12);
        for pair in poses.windows(2) {
            let way = pair[1].tip_m - pair[0].tip_m;
            assert!(way.norm() <= 1.02 * 0.07 * TICK_S + 1e-12, "{way}");
            assert!(pair[0].leg == Leg::Press || way.z == 0.0);
        }
    }
}
