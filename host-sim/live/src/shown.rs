//! Display options of the picture, and its colours.

use eframe::egui::Color32;

/// Quantity that the colour shows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Colour {
    /// Displacement of the surface.
    Displacement,
    /// Volume of a node's tets over their volume at rest.
    J,
    /// Pressure of the probe, with the ellipse of the contact.
    Pressure,
}

/// Display options of the picture.
#[derive(Clone, Copy, Debug)]
pub struct Shown {
    /// Quantity that the colour shows.
    pub colour: Colour,
    /// Whether the tissue is cut through the tip.
    pub cut: bool,
    /// Whether springs are drawn.
    pub springs: bool,
    /// Whether the edge is marked: fixed nodes, and nodes with a far field behind them.
    pub rim: bool,
    /// Whether the background is dark.
    pub dark: bool,
    /// Displacement at the end of the scale [m].
    pub most_m: f32,
    /// Pressure at the end of the scale [Pa].
    pub most_pa: f32,
}

impl Shown {
    /// The options with which a window begins.
    pub const FIRST: Self =
        Self { colour: Colour::Displacement, cut: false, springs: false, rim: false, dark: false, most_m: 4e-3, most_pa: 3.5e3 };
}

/// Volume ratio at the end of the scale (1).
pub const LEAST_J: f32 = 0.9;
const TISSUE: [f32; 3] = [0.84, 0.60, 0.55];
/// Colour scale in perceptually even steps, from the tissue's own colour to deep blue.
const SCALE: [[f32; 3]; 5] = [TISSUE, [0.93, 0.76, 0.42], [0.45, 0.75, 0.55], [0.16, 0.52, 0.66], [0.16, 0.20, 0.52]];

/// Colour at a share of the scale, with components 0 .. 1.
#[must_use]
pub fn scale(share: f32) -> [f32; 3] {
    let at = share.clamp(0.0, 1.0) * (SCALE.len() - 1) as f32;
    let low = (at as usize).min(SCALE.len() - 2);
    let t = at - low as f32;
    [0, 1, 2].map(|k| SCALE[low][k] * (1.0 - t) + SCALE[low + 1][k] * t)
}

/// Converts a colour with components 0 .. 1 to one for a screen.
#[must_use]
pub fn screen([r, g, b]: [f32; 3]) -> Color32 {
    let byte = |c: f32| (c.clamp(0.0, 1.0) * 255.0) as u8;
    Color32::from_rgb(byte(r), byte(g), byte(b))
}
