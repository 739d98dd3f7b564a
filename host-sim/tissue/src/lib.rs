//! Soft tissue on the desktop: a scene becomes a patch, and a patch is pressed.
//!
//! ```text
//! scene ─ tissue (mesh, organ) ─ patch ─ stable_step ─ session ─ press ─ output
//! ```
//!
//! A [`scene`] describes the tissue, the probe and its motion. [`tissue`] meshes it ([`mesh`],
//! [`organ`]), [`patch`] derives springs, tets and the foundation, [`stable_step`] finds the number
//! of substeps, and [`session`] bundles all that a run needs. [`press`] runs it tick by tick with a
//! [`finger`].

pub mod answer;
pub mod budget;
pub mod clock;
pub mod error;
pub mod exact;
pub mod finger;
pub mod fit_record;
pub mod machine;
pub mod measure;
pub mod mesh;
pub mod moving;
pub mod organ;
pub mod output;
pub mod patch;
pub mod press;
pub mod probe_surface;
pub mod recorded_tips;
pub mod reference_values;
pub mod scene;
pub mod session;
pub mod stable_step;
pub mod terminal;
pub mod tissue;
pub mod trace_file;
pub mod trials;
mod truth_error;

pub use error::Error;
