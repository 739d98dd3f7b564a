//! The PNG back end: a bitmap `FINE` times finer than the picture, averaged down at the end.
//!
//! The plotting library's own bitmap drops the side bearing of every glyph, sizes text unlike its
//! SVG, and fills a thick line that crosses itself by parity. Here text and lines follow the SVG.

use std::convert::Infallible;

use ab_glyph::{Font, PxScale, ScaleFont, point};
use plotters_backend::text_anchor::{HPos, VPos};
use plotters_backend::{
    BackendColor, BackendCoord, BackendStyle, BackendTextStyle, DrawingBackend, DrawingErrorKind,
    FontTransform,
};

use super::style::{EM_PER_SIZE, FINE, face};

type Done = Result<(), DrawingErrorKind<Infallible>>;

/// A canvas of fine pixels.
pub struct Raster<'a> {
    rgb: &'a mut [[u8; 3]],
    width: u32,
    height: u32,
}

impl<'a> Raster<'a> {
    /// Borrows `rgb`, row by row from the top; `None` unless it holds `width * height` [fine px].
    pub fn new(rgb: &'a mut [[u8; 3]], width: u32, height: u32) -> Option<Self> {
        (rgb.len() == width as usize * height as usize).then_some(Self { rgb, width, height })
    }

    /// Lays `color` over one fine pixel, weighted by `coverage` (0 to 1).
    fn blend(&mut self, (x, y): BackendCoord, color: BackendColor, coverage: f64) {
        let (Ok(x), Ok(y)) = (u32::try_from(x), u32::try_from(y)) else {
            return;
        };
        if x >= self.width || y >= self.height {
            return;
        }
        let at = y as usize * self.width as usize + x as usize;
        let Some(pixel) = self.rgb.get_mut(at) else {
            return;
        };
        let alpha = (color.alpha * coverage).clamp(0.0, 1.0);
        let over = [color.rgb.0, color.rgb.1, color.rgb.2];
        for (under, over) in pixel.iter_mut().zip(over) {
            let mixed = f64::from(*under) + (f64::from(over) - f64::from(*under)) * alpha;
            *under = mixed.round() as u8;
        }
    }

    /// A line with round ends: every fine pixel nearer than half the width.
    fn stroke(&mut self, from: BackendCoord, to: BackendCoord, color: BackendColor, width: u32) {
        let radius = f64::from(width.max(1)) / 2.0;
        let reach = radius.ceil() as i32;
        let (dx, dy) = (f64::from(to.0 - from.0), f64::from(to.1 - from.1));
        let length2 = dx * dx + dy * dy;
        let clip = |low: i32, high: i32, size: u32| {
            (low - reach).max(0)..(high + reach + 1).min(size.cast_signed())
        };
        for y in clip(from.1.min(to.1), from.1.max(to.1), self.height) {
            let qy = f64::from(y - from.1);
            for x in clip(from.0.min(to.0), from.0.max(to.0), self.width) {
                let qx = f64::from(x - from.0);
                let along = if length2 > 0.0 {
                    ((qx * dx + qy * dy) / length2).clamp(0.0, 1.0)
                } else {
                    0.0
                };
                let (ex, ey) = (qx - along * dx, qy - along * dy);
                if ex * ex + ey * ey <= radius * radius {
                    self.blend((x, y), color, 1.0);
                }
            }
        }
    }
}

impl DrawingBackend for Raster<'_> {
    type ErrorType = Infallible;

    fn get_size(&self) -> (u32, u32) {
        (self.width, self.height)
    }

    fn ensure_prepared(&mut self) -> Done {
        Ok(())
    }

    fn present(&mut self) -> Done {
        Ok(())
    }

    fn draw_pixel(&mut self, at: BackendCoord, color: BackendColor) -> Done {
        self.blend(at, color, 1.0);
        Ok(())
    }

    fn draw_line<S: BackendStyle>(
        &mut self,
        from: BackendCoord,
        to: BackendCoord,
        style: &S,
    ) -> Done {
        self.stroke(from, to, style.color(), style.stroke_width());
        Ok(())
    }

    fn draw_path<S: BackendStyle, I: IntoIterator<Item = BackendCoord>>(
        &mut self,
        path: I,
        style: &S,
    ) -> Done {
        let mut last = None;
        for to in path {
            let from = last.replace(to).unwrap_or(to);
            self.stroke(from, to, style.color(), style.stroke_width());
        }
        Ok(())
    }

    fn draw_text<S: BackendTextStyle>(&mut self, text: &str, style: &S, at: BackendCoord) -> Done {
        let Some(face) = face(&style.style()) else {
            return Ok(());
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

        // the same offsets as the `text-anchor` and `dy` of the SVG back end
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
                self.blend((at.0 + x, at.1 + y), style.color(), f64::from(coverage));
            });
        }
        Ok(())
    }
}

/// Height of a lower-case x of the built-in font [em].
const EX_PER_EM: f32 = 0.536;

/// Averages every `FINE` x `FINE` block of a canvas `width` fine pixels wide to one RGB pixel.
pub fn average(fine: &[[u8; 3]], width: u32) -> Vec<u8> {
    let side = FINE as usize;
    let mut out = Vec::with_capacity(fine.len() * 3 / (side * side));
    for band in fine.chunks_exact(width as usize * side) {
        for column in 0..width as usize / side {
            let mut sum = [0_u32; 3];
            for row in band.chunks_exact(width as usize) {
                for pixel in row.iter().skip(column * side).take(side) {
                    for (sum, value) in sum.iter_mut().zip(pixel) {
                        *sum += u32::from(*value);
                    }
                }
            }
            out.extend(sum.map(|s| (s / (FINE * FINE)) as u8));
        }
    }
    out
}
