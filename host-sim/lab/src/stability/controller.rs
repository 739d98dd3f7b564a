//! Stabilising controllers for comparison: the product's own, no controller, and published ones.
//! Each of them can be wrapped around any surface.
//!
//! A controller other than the product's modifies the force that the surface returns. The cycle's
//! own damping is then off, and the threshold of its energy alarm is as high as the settings
//! permit. The inputs are those of a real controller: the quantised depth, the model's force and
//! stiffness, and the forces that the controller sent itself. All controllers act along the normal
//! of the contact.

mod constant_damping;
mod energy_bounding;
mod low_pass;
mod slew;
mod time_domain_passivity;
mod virtual_coupling;

use std::sync::Arc;

use palpate::haptic::account::AccountSettings;
use palpate::haptic::cycle::{Renderer, Settings};
use palpate::haptic::damping::DampingSettings;
use palpate::haptic::limits::LoopLimitSettings;
use palpate::stages::probe::ProbePose;
use palpate::{Output, Vector3};

use self::constant_damping::ConstantDamping;
use self::energy_bounding::EnergyBounding;
use self::low_pass::LowPass;
use self::slew::Slew;
use self::time_domain_passivity::TimeDomainPassivity;
use self::virtual_coupling::VirtualCoupling;
use palpate_loop::closed_loop::device::DeviceProfile;
use palpate_loop::closed_loop::stimulus::{Change, Site};
use palpate_loop::closed_loop::surface::Surface;
use palpate_loop::closed_loop::watch::RestShape;

/// Duration of a tick [s].
const TICK_S: f32 = palpate_tissue::scene::TICK_S as f32;

/// Method by which the loop is kept free of vibration.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Controller {
    /// The product's controller, with [`Settings::safe`].
    Ours,
    /// The model's force, unchanged.
    Direct,
    /// Constant damping in contact, `F + B v`, with the velocity low-passed at 50 Hz.
    ConstantDamping {
        /// Damping coefficient `B` [N s/m].
        n_s_per_m: f32,
    },
    /// Time-domain passivity control.
    TimeDomainPassivity,
    /// Time-domain passivity control with the energy stored in the model as reference.
    ReferenceEnergy,
    /// Energy bounding, after Kim and Ryu.
    EnergyBounding,
    /// A spring and a damper between the handle and a proxy, at whose depth the model is evaluated.
    VirtualCoupling,
    /// A limit on the change of the force per tick.
    Slew {
        /// Largest change of the force per tick [N].
        n_per_tick: f32,
    },
    /// A low-pass of 50 Hz on the force.
    LowPass,
}

/// All controllers that are compared, the product's first.
pub const CONTROLLERS: [Controller; 10] = [
    Controller::Ours,
    Controller::Direct,
    Controller::ConstantDamping { n_s_per_m: 1.0 },
    Controller::ConstantDamping { n_s_per_m: 2.0 },
    Controller::TimeDomainPassivity,
    Controller::ReferenceEnergy,
    Controller::EnergyBounding,
    Controller::VirtualCoupling,
    Controller::Slew { n_per_tick: 0.05 },
    Controller::LowPass,
];

impl Controller {
    /// Name in tables and pictures.
    pub fn name(self) -> String {
        match self {
            Self::Ours => "ours".into(),
            Self::Direct => "direct".into(),
            Self::ConstantDamping { n_s_per_m } => format!("damping {n_s_per_m} N s/m"),
            Self::TimeDomainPassivity => "TDPA".into(),
            Self::ReferenceEnergy => "TDPA + reference".into(),
            Self::EnergyBounding => "energy bounding".into(),
            Self::VirtualCoupling => "virtual coupling".into(),
            Self::Slew { n_per_tick } => format!("slew {n_per_tick} N/tick"),
            Self::LowPass => "low-pass 50 Hz".into(),
        }
    }

    /// Settings of the cycle under this controller.
    pub fn settings(self, device: &DeviceProfile) -> Settings {
        let safe = Settings::safe(&device.limits(Vector3::zeros()));
        let max_force_n = safe.limits.max_force_n.min(device.force_limit_n as f32);
        let safe = Settings { limits: LoopLimitSettings { max_force_n, ..safe.limits }, ..safe };
        match self {
            Self::Ours => safe,
            _ => Settings { damping: DampingSettings::NONE, account: AccountSettings::HIGHEST, ..safe },
        }
    }

    /// Wraps a surface in this controller.
    pub fn over<S: Surface>(self, surface: S, device: &DeviceProfile) -> Controlled<S> {
        let max_force_n = self.settings(device).limits.max_force_n;
        let device = Known {
            max_force_n,
            damping_n_s_per_m: device.damping_n_s_per_m as f32,
            delay_ticks: usize::from(device.delay_ticks),
        };
        Controlled { surface, control: self, device, law: self.law(&device), normal: Vector3::zeros() }
    }

    fn law(self, device: &Known) -> Option<Box<dyn Law>> {
        Some(match self {
            Self::Ours | Self::Direct => return None,
            Self::ConstantDamping { n_s_per_m } => Box::new(ConstantDamping::new(n_s_per_m)),
            Self::TimeDomainPassivity => Box::new(TimeDomainPassivity::new(device, false)),
            Self::ReferenceEnergy => Box::new(TimeDomainPassivity::new(device, true)),
            Self::EnergyBounding => Box::new(EnergyBounding::new(device)),
            Self::VirtualCoupling => Box::<VirtualCoupling>::default(),
            Self::Slew { n_per_tick } => Box::new(Slew::new(n_per_tick)),
            Self::LowPass => Box::<LowPass>::default(),
        })
    }
}

/// Device parameters available to a controller.
#[derive(Clone, Copy, Debug)]
struct Known {
    max_force_n: f32,
    damping_n_s_per_m: f32,
    delay_ticks: usize,
}

/// Inputs of a controller in one tick, along the normal.
#[derive(Clone, Copy, Debug)]
struct Seen {
    /// Depth of the handle as read by the encoder, negative outside the tissue [m].
    depth_m: f32,
    /// Force of the model, positive out of the tissue [N].
    model_n: f32,
    /// Stiffness of the model at this depth [N/m].
    tangent_n_per_m: f32,
}

/// Control law of a controller other than the product's, evaluated once per tick.
trait Law: std::fmt::Debug {
    /// Depth at which the model is evaluated [m] when the handle is at `depth_m`.
    fn shown_m(&mut self, depth_m: f32) -> f32 {
        depth_m
    }

    /// Force on the hand, out of the tissue [N].
    fn force_n(&mut self, seen: &Seen) -> f32;
}

/// Velocity from differences between ticks, low-passed by one pole.
#[derive(Clone, Copy, Debug)]
struct Velocity {
    share: f32,
    depth_m: Option<f32>,
    m_per_s: f32,
}

impl Velocity {
    const SHARE_50_HZ: f32 = 0.2696;
    const SHARE_100_HZ: f32 = 0.4665;

    fn new(share: f32) -> Self {
        Self { share, depth_m: None, m_per_s: 0.0 }
    }

    /// Updates and returns the velocity into the tissue [m/s]; called in every tick, also outside
    /// the tissue.
    fn track(&mut self, depth_m: f32) -> f32 {
        let last_m = self.depth_m.replace(depth_m).unwrap_or(depth_m);
        self.m_per_s += self.share * ((depth_m - last_m) / TICK_S - self.m_per_s);
        self.m_per_s
    }
}

/// A surface wrapped in a controller.
#[derive(Debug)]
pub struct Controlled<S> {
    surface: S,
    control: Controller,
    device: Known,
    law: Option<Box<dyn Law>>,
    /// Normal of the last contact: a force that lingers acts along it.
    normal: Vector3<f32>,
}

impl<S: Surface> Renderer for Controlled<S> {
    fn render(&mut self, pose: ProbePose) -> Output {
        let Some(law) = &mut self.law else { return self.surface.render(pose) };
        let site = self.surface.site();
        let out_of: Vector3<f32> = site.normal.cast();
        let depth_m = (site.at_m.cast() - pose.tip_m).dot(&out_of);
        let shown_m = law.shown_m(depth_m);
        let output = self.surface.render(ProbePose { tip_m: pose.tip_m + out_of * (depth_m - shown_m) });
        if output.fault.is_some() {
            return output;
        }
        if output.normal != Vector3::zeros() {
            self.normal = output.normal;
        }
        let model_n = output.force_n.dot(&output.normal);
        let tangent_n_per_m = self.surface.tangent_n_per_m(&output);
        let force_n = law.force_n(&Seen { depth_m, model_n, tangent_n_per_m });
        if force_n == model_n {
            return output;
        }
        // a force that lingers outside the tissue is part of the comparison, so `outside` is false
        // and the product's rule does not cut it off
        let force_n = output.force_n + self.normal * (force_n - model_n);
        Output { force_n, normal: self.normal, outside: false, ..output }
    }

    fn reset(&mut self) {
        self.surface.reset();
        self.law = self.control.law(&self.device);
    }

    fn tangent_n_per_m(&self, output: &Output) -> f32 {
        self.surface.tangent_n_per_m(output)
    }

    fn stiffness_n_per_m(&self) -> f32 {
        self.surface.stiffness_n_per_m()
    }
}

impl<S: Surface> Surface for Controlled<S> {
    fn site(&self) -> Site {
        self.surface.site()
    }

    fn rest_shape(&self) -> Arc<dyn RestShape> {
        self.surface.rest_shape()
    }

    fn creeps(&self) -> bool {
        self.surface.creeps()
    }

    fn change(&mut self, change: Change) {
        self.surface.change(change);
    }

    fn settle(&mut self, in_contact: bool) {
        self.surface.settle(in_contact);
    }

    fn unsound(&self) -> Option<&'static str> {
        self.surface.unsound()
    }
}
