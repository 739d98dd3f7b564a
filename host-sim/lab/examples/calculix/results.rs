//! Reads the forces that `CalculiX` prints.

use std::path::Path;

use super::{Failure, in_doing};

/// Force on the ball at the end of every step [mN], for the symmetric piece that was computed.
pub fn forces_mn(folder: &Path, name: &str) -> Result<Vec<[f64; 3]>, Failure> {
    let path = folder.join(format!("{name}.dat"));
    let text = std::fs::read_to_string(&path).map_err(in_doing(path.display()))?;
    let mut lines = text.lines();
    let mut forces = Vec::new();
    while let Some(line) = lines.next() {
        if line.trim_start().starts_with("total force") {
            let numbers = lines.by_ref().find(|line| !line.trim().is_empty()).unwrap_or_default();
            let numbers: Vec<f64> = numbers.split_whitespace().map_while(|word| word.parse().ok()).collect();
            let force = numbers.try_into().map_err(|_| format!("{}: a total force has no three components", path.display()))?;
            forces.push(force);
        }
    }
    Ok(forces)
}
