//! Draws text at the positions at which a viewer places the text of the SVG back end.

use ab_glyph::{Font, PxScale, ScaleFont, point};
use plotters_backend::text_anchor::{HPos, VPos};
use plotters_backend::{BackendCoord, BackendTextStyle, FontTransform};

use super::Raster;
use crate::style::{EM_PER_SIZE, face};

/// Height of a lower-case x of the built-in font [em].
const EX_PER_EM: f32 = 0.536;

/// Draws `text` in the built-in font, aligned to `at` [fine px] by the anchor of `style`.
pub fn draw<S: BackendTextStyle>(canvas: &mut Raster, text: &str, style: &S, at: BackendCoord) {
    let Some(face) = face(style.style()) else {
        return;
    };
    let em = style.size() * EM_PER_SIZE;
    let units_per_em = face.units_per_em().unwrap_or(1000.0);
    let scale = PxScale::from(em as f32 * face.height_unscaled() / units_per_em);
    let scaled = face.as_scaled(scale);

    let mut pen = 0.0_f32;
    let mut last = None;
    let mut glyphs = Vec::new();
    for id in text.chars().map(|c| face.glyph_id(c)) {
        pen += last.map_or(0.0, |last| scaled.kern(last, id));
        glyphs.push(id.with_scale_and_position(scale, point(pen, 0.0)));
        pen += scaled.h_advance(id);
        last = Some(id);
    }

    // equal to the offsets of `text-anchor` and `dy` in the SVG back end
    let left = match style.anchor().h_pos {
        HPos::Left => 0.0,
        HPos::Center => -pen / 2.0,
        HPos::Right => -pen,
    };
    let half_ex = EX_PER_EM / 2.0 * em as f32;
    let baseline = match style.anchor().v_pos {
        VPos::Top => 0.76 * em as f32,
        VPos::Center => half_ex,
        VPos::Bottom => -half_ex,
    };
    let turn = style.transform();
    for outline in glyphs.into_iter().filter_map(|g| face.outline_glyph(g)) {
        let corner = outline.px_bounds().min;
        outline.draw(|x, y, coverage| {
            let x = (left + corner.x + x as f32).round() as i32;
            let y = (baseline + corner.y + y as f32).round() as i32;
            let (x, y) = match turn {
                FontTransform::None => (x, y),
                FontTransform::Rotate90 => (-y, x),
                FontTransform::Rotate180 => (-x, -y),
                FontTransform::Rotate270 => (y, -x),
            };
            canvas.blend((at.0 + x, at.1 + y), style.color(), f64::from(coverage));
        });
    }
}
