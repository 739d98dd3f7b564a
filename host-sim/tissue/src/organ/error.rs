//! Errors of the meshing of organs.

/// An organ that cannot be meshed as requested. Displays as one line that says what is wrong,
/// where, and how to fix it.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[allow(missing_docs, reason = "each message names what its fields hold")]
pub enum OrganError {
    #[error("no organ is called `{name}`: give one of {known}")]
    Unknown { name: String, known: String },
    #[error("{organ}: {what} is {value}: give {wanted}")]
    Number { organ: String, what: &'static str, value: f64, wanted: &'static str },
    #[error(
        "{organ}: a spacing of {spacing_m} m needs a lattice of {points:.0} points, at most {limit} fit: give a larger spacing"
    )]
    TooFine { organ: String, spacing_m: f64, points: f64, limit: usize },
    #[error("{organ}: nothing of it is left at a spacing of {spacing_m} m: give a smaller spacing")]
    Empty { organ: String, spacing_m: f64 },
    #[error("{organ}: at a spacing of {spacing_m} m the mesh {defect}: give a smaller spacing")]
    TooCoarse { organ: String, spacing_m: f64, defect: &'static str },
    #[error("{organ}: {tets} tets of {all} are turned inside out where the spacing grows: give a smaller growth or spacing")]
    Inverted { organ: String, tets: usize, all: usize },
    #[error("{organ}: no mesh has {wanted} tets, the nearest sound one has {nearest}: ask for that, or give a spacing")]
    Count { organ: String, wanted: usize, nearest: usize },
}
