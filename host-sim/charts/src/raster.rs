//! The PNG back end: a bitmap `FINE` times finer than the picture, averaged to picture pixels at
//! the end.
//!
//! The plotting library's own bitmap back end drops the side bearing of every glyph, sizes text
//! differently from its SVG back end, and fills a thick line that crosses itself by the even-odd
//! rule. Here text and lines follow the SVG back end.

mod glyphs;

use std::convert::Infallible;

use plotters_backend::{BackendColor, BackendCoord, BackendStyle, BackendTextStyle, DrawingBackend, DrawingErrorKind};

use super::style::FINE;

type Done = Result<(), DrawingErrorKind<Infallible>>;

/// A canvas of fine pixels, `FINE` of which make one picture pixel along each side.
pub struct Raster<'a> {
    rgb: &'a mut [[u8; 3]],
    width: u32,
    height: u32,
}

impl<'a> Raster<'a> {
    /// Borrows `rgb`, row by row from the top; `None` unless it has `width * height` elements [fine
    /// px].
    pub fn new(rgb: &'a mut [[u8; 3]], width: u32, height: u32) -> Option<Self> {
        (rgb.len() == width as usize * height as usize).then_some(Self { rgb, width, height })
    }

    /// The fine pixel at a position, or `None` outside the canvas.
    fn pixel(&mut self, (x, y): BackendCoord) -> Option<&mut [u8; 3]> {
        let (x, y) = (u32::try_from(x).ok()?, u32::try_from(y).ok()?);
        if x >= self.width {
            return None;
        }
        self.rgb.get_mut(y as usize * self.width as usize + x as usize)
    }

    /// Blends `color` over one fine pixel, weighted by `coverage` (0 to 1).
    fn blend(&mut self, at: BackendCoord, color: BackendColor, coverage: f64) {
        let Some(pixel) = self.pixel(at) else {
            return;
        };
        let over = [color.rgb.0, color.rgb.1, color.rgb.2];
        let alpha = (color.alpha * coverage).clamp(0.0, 1.0);
        if alpha >= 1.0 {
            *pixel = over;
            return;
        }
        for (under, over) in pixel.iter_mut().zip(over) {
            let mixed = f64::from(*under) + (f64::from(over) - f64::from(*under)) * alpha;
            *under = mixed.round() as u8;
        }
    }

    /// Fills the fine pixels of row `y` from `from` up to, but not including, `to`.
    fn span(&mut self, y: i32, from: i32, to: i32, color: BackendColor) {
        let from = from.max(0);
        let to = to.min(self.width.cast_signed());
        if color.alpha < 1.0 {
            for x in from..to {
                self.blend((x, y), color, 1.0);
            }
        } else if from < to && 0 <= y && y < self.height.cast_signed() {
            let row = y as usize * self.width as usize;
            if let Some(row) = self.rgb.get_mut(row + from as usize..row + to as usize) {
                row.fill([color.rgb.0, color.rgb.1, color.rgb.2]);
            }
        }
    }

    /// Draws a line with round ends: it fills every fine pixel whose distance is at most half the
    /// width.
    fn stroke(&mut self, from: BackendCoord, to: BackendCoord, color: BackendColor, width: u32) {
        let upright = from.0 == to.0 || from.1 == to.1;
        if width <= 1 && upright {
            // the plotting library fills polygons by such lines, by far the most frequent ones, so
            // they skip the distance computation below
            for y in from.1.min(to.1)..=from.1.max(to.1) {
                self.span(y, from.0.min(to.0), from.0.max(to.0) + 1, color);
            }
            return;
        }
        let radius = f64::from(width.max(1)) / 2.0;
        let reach = radius.ceil() as i32;
        let (dx, dy) = (f64::from(to.0 - from.0), f64::from(to.1 - from.1));
        let length2 = dx * dx + dy * dy;
        let clip = |low: i32, high: i32, size: u32| (low - reach).max(0)..(high + reach + 1).min(size.cast_signed());
        for y in clip(from.1.min(to.1), from.1.max(to.1), self.height) {
            let qy = f64::from(y - from.1);
            for x in clip(from.0.min(to.0), from.0.max(to.0), self.width) {
                let qx = f64::from(x - from.0);
                let along = if length2 > 0.0 { ((qx * dx + qy * dy) / length2).clamp(0.0, 1.0) } else { 0.0 };
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

    fn draw_line<S: BackendStyle>(&mut self, from: BackendCoord, to: BackendCoord, style: &S) -> Done {
        self.stroke(from, to, style.color(), style.stroke_width());
        Ok(())
    }

    fn draw_rect<S: BackendStyle>(&mut self, low: BackendCoord, high: BackendCoord, style: &S, fill: bool) -> Done {
        if fill {
            for y in low.1.max(0)..high.1.min(self.height.cast_signed()) {
                self.span(y, low.0, high.0, style.color());
            }
            return Ok(());
        }
        let corners = [low, (high.0, low.1), high, (low.0, high.1), low];
        self.draw_path(corners, style)
    }

    fn draw_path<S: BackendStyle, I: IntoIterator<Item = BackendCoord>>(&mut self, path: I, style: &S) -> Done {
        let mut last = None;
        for to in path {
            let from = last.replace(to).unwrap_or(to);
            self.stroke(from, to, style.color(), style.stroke_width());
        }
        Ok(())
    }

    fn draw_text<S: BackendTextStyle>(&mut self, text: &str, style: &S, at: BackendCoord) -> Done {
        glyphs::draw(self, text, style, at);
        Ok(())
    }
}

/// Averages every `FINE` x `FINE` block of a canvas, `width` fine pixels wide, to one RGB pixel.
pub fn average(fine: &[[u8; 3]], width: u32) -> Vec<u8> {
    let side = FINE as usize;
    let mut out = Vec::with_capacity(fine.len() * 3 / (side * side));
    let mut sums = vec![[0_u32; 3]; width as usize / side];
    for band in fine.chunks_exact(width as usize * side) {
        sums.fill([0; 3]);
        for row in band.chunks_exact(width as usize) {
            for (sum, block) in sums.iter_mut().zip(row.chunks_exact(side)) {
                for [r, g, b] in block {
                    sum[0] += u32::from(*r);
                    sum[1] += u32::from(*g);
                    sum[2] += u32::from(*b);
                }
            }
        }
        out.extend(sums.iter().flatten().map(|s| (s / (FINE * FINE)) as u8));
    }
    out
}
