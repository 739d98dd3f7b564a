//! Palpate on the desktop: emulated finger, meshes, charts, command line.
//!
//! A scene ([`scene`]) becomes a tissue ([`tissue`], [`mesh`]), that a patch ([`patch`]) with its stable step ([`stable_step`]): a [`session`].
//! [`press`] runs it tick by tick with a [`finger`]; [`summary`] writes what came out.

pub mod budget;
pub mod calibrate;
pub mod chart;
pub mod charts;
pub mod clock;
pub mod closed_loop;
#[cfg(not(target_family = "wasm"))]
pub mod command;
#[cfg(not(target_family = "wasm"))]
pub mod emulate;
pub mod error;
pub mod far_field;
pub mod finger;
pub mod live;
pub mod measure;
pub mod mesh;
pub mod organ;
pub mod output;
#[cfg(not(target_family = "wasm"))]
pub mod paper;
pub mod patch;
#[cfg(not(target_family = "wasm"))]
pub mod plan;
pub mod press;
pub mod reference;
pub mod reference_values;
pub mod rivals;
pub mod scene;
pub mod score;
pub mod session;
#[cfg(not(target_family = "wasm"))]
pub mod stability;
pub mod stable_step;
pub mod statics;
pub mod summary;
pub mod tissue;
pub mod trace_file;
pub mod vtu;
