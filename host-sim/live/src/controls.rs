//! Choices of the user and their consequences; the user makes them with `panel` and `keys`.

use eframe::egui::{Align2, Color32, FontId, Painter, Stroke, vec2};
use palpate::Vector3;
use palpate_loop::live::{Choice, Exercise, Found, Holding, Inside, Nodule};
use palpate_tissue::scene::PRESETS;
use web_time::Instant;

use crate::camera::Lens;
use crate::cut::Cut;
use crate::drawn_body::DrawnBody;
use crate::message::{Body, Frame};
use crate::shown::Shown;

/// Nodule with which the sliders begin.
pub(crate) const NODULE: Nodule = Nodule { place_m: [0.004, 0.0], depth_m: 9e-3, radius_m: 6e-3, ratio: 10.0 };

/// Choices of the user.
pub struct Controls {
    /// Scene to press, and the changes to it.
    pub choice: Choice,
    /// Device and hand that hold the probe.
    pub holding: Holding,
    /// Display options of the picture.
    pub shown: Shown,
    /// Stiffness [kPa] and damping [1/s] on the sliders.
    pub(crate) stiffness_kpa: f32,
    pub(crate) damping_per_s: f32,
    /// Nodules in the block; a nodule that is searched for is not among them.
    pub(crate) inside: Inside,
    /// Nodules of the scene itself.
    pub(crate) own: Vec<Nodule>,
    pub(crate) block: bool,
    pub(crate) exercise: Option<Search>,
    pub(crate) found: Option<Answered>,
    pub(crate) seed: u64,
    pub(crate) light: bool,
    /// Exercise and answer, kept while another scene is loading, in case it is refused.
    pub(crate) put_by: Option<(Option<Search>, Option<Answered>)>,
}

/// Result of the exercise, position of the answer [m], and the nodule.
type Answered = (Found, [f64; 2], Nodule);

/// Names of the presets.
pub(crate) fn presets() -> impl Iterator<Item = &'static str> {
    PRESETS.iter().map(|(name, _)| *name)
}

/// A running exercise.
pub(crate) struct Search {
    pub(crate) exercise: Exercise,
    /// Time at which the tissue of the exercise appeared.
    pub(crate) begun: Option<Instant>,
    pub(crate) peak_n: f32,
}

impl Search {
    pub(crate) fn taken_s(&self) -> f64 {
        self.begun.map_or(0.0, |begun| begun.elapsed().as_secs_f64())
    }
}

/// Points of a ring around a place on the surface [m], the first once more at the end.
fn ring(middle: Vector3<f32>, radius_m: f32) -> impl Iterator<Item = Vector3<f32>> {
    (0..=32_u8).map(move |k| {
        let turn = f32::from(k) * std::f32::consts::TAU / 32.0;
        middle + Vector3::new(turn.cos(), turn.sin(), 0.0) * radius_m
    })
}

/// Name of a preset, or of a file without its folders.
pub(crate) fn short(scene: &str) -> &str {
    scene.rsplit(['/', '\\']).next().unwrap_or(scene)
}

impl Controls {
    /// Creates the controls with the choice that was sent to the physics.
    #[must_use]
    pub fn new(choice: Choice, holding: Holding) -> Self {
        Self {
            inside: choice.inside,
            own: Vec::new(),
            choice,
            holding,
            shown: Shown::FIRST,
            stiffness_kpa: 3.5,
            damping_per_s: 40.0,
            block: true,
            exercise: None,
            found: None,
            seed: 1,
            light: true,
            put_by: None,
        }
    }

    /// Called when another body appears.
    pub fn of_body(&mut self, body: &Body) {
        self.stiffness_kpa = body.youngs_modulus_pa * 1e-3;
        self.damping_per_s = body.node_damping_per_s;
        self.block = body.block;
        self.own.clone_from(&body.own_nodules);
        self.shown.most_m = body.depth_limit_m * 0.6;
        self.put_by = None;
        if let Some(search) = &mut self.exercise {
            search.begun.get_or_insert_with(Instant::now);
        }
        if let Some(choice) = &body.choice {
            self.choice = choice.clone();
        }
    }

    /// Restores the choice that is still pressed, after a request was refused.
    pub fn kept(&mut self, choice: Choice, holding: Holding, body: &Body) {
        if let Some((exercise, found)) = self.put_by.take() {
            (self.exercise, self.found) = (exercise, found);
        }
        self.inside = if self.exercise.is_none() { choice.inside } else { Inside::Own };
        self.stiffness_kpa = choice.youngs_modulus_pa.map_or(body.youngs_modulus_pa, |pa| pa as f32) * 1e-3;
        self.damping_per_s = choice.node_damping_per_s.map_or(body.node_damping_per_s, |per_s| per_s as f32);
        (self.choice, self.holding) = (choice, holding);
    }

    /// Nodules that are known to be inside, without one that is searched for.
    #[must_use]
    pub fn nodules(&self) -> &[Nodule] {
        match &self.inside {
            Inside::Own => &self.own,
            Inside::Nothing => &[],
            Inside::Nodule(nodule) => std::slice::from_ref(nodule),
        }
    }

    /// Returns the state of the controls in numbers, as JSON.
    #[must_use]
    pub fn numbers(&self) -> serde_json::Value {
        serde_json::json!({
            "stiffness_kpa": self.stiffness_kpa, "searching": self.exercise.is_some(),
            "score": self.found.map(|(found, ..)| found.score), "found": self.found.map(|(found, ..)| found.found),
            "scene": self.choice.scene, "device": self.holding.device, "hand": self.holding.hand, "dark": !self.light,
            "damping_per_s": self.damping_per_s, "cut": self.shown.cut, "nodule": !self.nodules().is_empty(),
        })
    }

    /// Returns the title: that of the running exercise, or else the short name of the scene.
    #[must_use]
    pub fn title(&self) -> String {
        match &self.exercise {
            Some(_) => "Find the nodule".into(),
            None => short(&self.choice.scene).to_owned(),
        }
    }

    /// Returns the sentence that tells the user what to do with a new body.
    #[must_use]
    pub fn ready(&self) -> String {
        match &self.exercise {
            Some(_) => "A nodule is hidden in the plain block: press around, and Enter where it is stiffest.".into(),
            None => format!("{} is ready: press it.", self.title()),
        }
    }

    /// Updates the strongest press of a running exercise from a frame.
    pub fn felt(&mut self, frame: &Frame) {
        if let Some(search) = &mut self.exercise {
            search.peak_n = search.peak_n.max(Vector3::from(frame.force_n).norm());
        }
    }

    /// Marks the answer and the nodule on the surface, where the cut leaves tissue.
    pub(crate) fn marks(&self, painter: &Painter, lens: &Lens, shape: &DrawnBody, cut: Option<&Cut>) {
        let Some((_, answer, nodule)) = &self.found else { return };
        let axis = Vector3::from(shape.body.axis);
        let on_tissue = |x: Vector3<f32>| {
            let on_m = shape.meets(&(x + axis * 0.5), &-axis)?;
            cut.is_none_or(|cut| cut.ahead_m(&on_m) <= 0.0).then(|| on_m + axis * 0.5e-3)
        };
        // their names are on opposite sides, since one would hide the other
        for (place, radius_m, colour, name, side) in [
            (nodule.place_m, nodule.radius_m as f32, Color32::from_rgb(200, 40, 40), "nodule", -1.0),
            (*answer, 1.5e-3, Color32::from_rgb(20, 60, 160), "your answer", 1.0),
        ] {
            let middle = Vector3::new(place[0] as f32, place[1] as f32, shape.body.site_m[2]);
            let ring: Vec<_> = ring(middle, radius_m).map(|x| Some(lens.project(&on_tissue(x)?)?.0)).collect();
            for pair in ring.windows(2) {
                if let [Some(a), Some(b)] = *pair {
                    painter.line_segment([a, b], Stroke::new(2.5, colour));
                }
            }
            let named = on_tissue(middle + Vector3::x() * (side * radius_m));
            if let Some((pixel, _)) = named.and_then(|x| lens.project(&x)) {
                let align = if side < 0.0 { Align2::RIGHT_CENTER } else { Align2::LEFT_CENTER };
                painter.text(pixel + vec2(6.0 * side, 0.0), align, name, FontId::proportional(14.0), colour);
            }
        }
    }
}
