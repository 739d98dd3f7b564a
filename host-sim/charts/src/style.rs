//! The common style of all charts: sizes, colours, lines and the built-in font.

use ab_glyph::FontRef;
use plotters::style::text_anchor::{HPos, Pos, VPos};
use plotters::style::{Color, FontDesc, FontFamily, FontStyle, RGBColor, ShapeStyle, TextStyle};

/// Number of canvas units per picture pixel. The plotting library rounds to whole units; with units
/// of a quarter of a pixel this is invisible, and edges are smoothed to 17 levels.
pub const FINE: u32 = 4;

/// Font size that the SVG back end writes, divided by the requested size; the PNG uses the same
/// factor.
pub const EM_PER_SIZE: f64 = 1.0 / 1.24;

/// The built-in font, followed by fonts that a viewer without it is likely to have.
const FAMILY: &str = "Noto Sans, Open Sans, Helvetica, Arial, sans-serif";

pub const INK: RGBColor = RGBColor(0x22, 0x26, 0x2a);
pub const MUTED: RGBColor = RGBColor(0x66, 0x6c, 0x72);
pub const GRID: RGBColor = RGBColor(0xe3, 0xe6, 0xe9);
pub const REFERENCE: RGBColor = RGBColor(0xc8, 0x4b, 0x1e);
pub const WARN: RGBColor = RGBColor(0xb3, 0x26, 0x1e);

/// Text sizes [px].
pub const TITLE_PX: f64 = 19.0;
pub const LABEL_PX: f64 = 15.0;
pub const TICK_PX: f64 = 14.0;

/// Converts picture pixels to canvas units.
pub fn px(pixels: f64) -> i32 {
    (pixels * f64::from(FINE)).round() as i32
}

/// The built-in face for `style`; the charts use only regular and bold.
pub fn face(style: FontStyle) -> Option<FontRef<'static>> {
    FontRef::try_from_slice(match style {
        FontStyle::Bold => notosans::BOLD_TTF,
        _ => notosans::REGULAR_TTF,
    })
    .ok()
}

/// Registers the built-in font with the plotting library, which measures text with it.
pub fn register_fonts() -> Result<(), String> {
    // the browser page draws no charts with this library
    #[cfg(not(target_family = "wasm"))]
    for (style, bytes) in [(FontStyle::Normal, notosans::REGULAR_TTF), (FontStyle::Bold, notosans::BOLD_TTF)] {
        plotters::style::register_font(FAMILY, style, bytes).map_err(|_| "the built-in font does not parse".to_owned())?;
    }
    Ok(())
}

/// Text style of `size_px`, aligned by `anchor` (horizontal, vertical).
pub fn text(size_px: f64, color: RGBColor, anchor: (HPos, VPos)) -> TextStyle<'static> {
    styled(size_px, FontStyle::Normal, color, anchor)
}

/// Bold text style of `size_px`, aligned by the top left corner.
pub fn heading(size_px: f64, color: RGBColor) -> TextStyle<'static> {
    styled(size_px, FontStyle::Bold, color, (HPos::Left, VPos::Top))
}

/// Text style of `size_px` in a font style, aligned by `anchor` (horizontal, vertical).
pub fn styled(size_px: f64, style: FontStyle, color: RGBColor, anchor: (HPos, VPos)) -> TextStyle<'static> {
    let size = size_px * f64::from(FINE) / EM_PER_SIZE;
    let mut text = TextStyle::from(FontDesc::new(FontFamily::Name(FAMILY), size, style));
    text.color = color.to_backend_color();
    text.pos(Pos::new(anchor.0, anchor.1))
}

/// Line style of width `width_px` [px].
pub fn line(color: RGBColor, width_px: f64) -> ShapeStyle {
    ShapeStyle::from(color).stroke_width(px(width_px).unsigned_abs().max(1))
}
