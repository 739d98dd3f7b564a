//! The mechanisms that a profile can name. **Add a device of your own here, in one place.**

use palpate::Vector3;
use serde::{Deserialize, Serialize};

use super::{DIMENSIONS, Mechanism, MechanismError, Paddle, Pantograph, YourDevice};

macro_rules! catalogue {
    ($($mechanism:ident),+ $(,)?) => {
        /// Kinds of mechanism that a profile can name.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
        pub enum Kind {
            $(#[doc = concat!("A [`", stringify!($mechanism), "`].")] $mechanism),+
        }

        impl Kind {
            /// All kinds, for look-up by name.
            pub const ALL: &'static [Self] = &[$(Self::$mechanism),+];

            /// Name in profile files.
            #[must_use]
            pub fn name(self) -> &'static str {
                match self { $(Self::$mechanism => $mechanism::NAME),+ }
            }

            /// Number of joints, each with an encoder and a motor.
            #[must_use]
            pub fn joints(self) -> usize {
                match self { $(Self::$mechanism => $mechanism::JOINTS),+ }
            }

            /// Names of the kind's dimensions in profile files.
            #[must_use]
            pub fn dimension_names(self) -> &'static [&'static str] {
                match self { $(Self::$mechanism => $mechanism::DIMENSION_NAMES),+ }
            }

            /// Builds a mechanism of this kind.
            ///
            /// # Errors
            /// Errors of [`Mechanism::build`].
            pub fn build(self, dimensions: [f32; DIMENSIONS]) -> Result<Linkage, MechanismError> {
                match self { $(Self::$mechanism => $mechanism::build(dimensions).map(Linkage::$mechanism)),+ }
            }
        }

        /// A mechanism of any kind.
        #[derive(Clone, Copy, Debug)]
        pub enum Linkage {
            $(#[doc = concat!("A [`", stringify!($mechanism), "`].")] $mechanism($mechanism)),+
        }

        impl Linkage {
            /// Like [`Mechanism::tip_m`].
            #[must_use]
            pub fn tip_m(&mut self, joints_rad: [f32; 3]) -> Option<Vector3<f32>> {
                match self { $(Self::$mechanism(it) => it.tip_m(joints_rad)),+ }
            }

            /// Like [`Mechanism::torques_n_m`].
            #[must_use]
            pub fn torques_n_m(&self, force_n: Vector3<f32>) -> [f32; 3] {
                match self { $(Self::$mechanism(it) => it.torques_n_m(force_n)),+ }
            }

            /// Like [`Mechanism::reaches`].
            #[must_use]
            pub fn reaches(&self, tip_m: Vector3<f32>) -> bool {
                match self { $(Self::$mechanism(it) => it.reaches(tip_m)),+ }
            }
        }
    };
}

catalogue!(Paddle, Pantograph, YourDevice);
