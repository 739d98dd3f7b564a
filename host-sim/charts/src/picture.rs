//! Draws one picture on both back ends and publishes the two files together.

use std::path::{Path, PathBuf};

use plotters::drawing::IntoDrawingArea;
use plotters::prelude::{DrawingBackend, SVGBackend};

use super::ChartError;
use super::canvas::{Area, Drawn};
use super::raster::{Raster, average};
use super::style::{FINE, register_fonts};

/// Size of every picture [px].
const SIZE_PX: (u32, u32) = (1000, 700);

/// A validated picture that can be drawn on any back end.
pub trait Picture {
    /// Draws on `area`, a white canvas of `SIZE_PX` in units of 1/`FINE` pixel.
    fn draw<DB: DrawingBackend>(&self, area: &Area<DB>) -> Drawn<DB>;
}

/// Writes `folder/name.svg` and `folder/name.png`, either both or neither.
pub fn save(folder: &Path, name: &str, picture: &impl Picture) -> Result<(), ChartError> {
    let svg_path = folder.join(format!("{name}.svg"));
    let png_path = folder.join(format!("{name}.png"));
    let svg = svg(picture).map_err(|message| refused(&svg_path, &message))?;
    let png = png(picture).map_err(|message| refused(&png_path, &message))?;
    let files = [Staged::write(folder, svg_path, svg.as_bytes())?, Staged::write(folder, png_path, &png)?];
    for (done, file) in files.iter().enumerate() {
        if let Err(error) = file.publish() {
            // one file of the two would be taken for a finished picture
            for earlier in &files[..done] {
                let _ = std::fs::remove_file(&earlier.path);
            }
            return Err(error);
        }
    }
    Ok(())
}

fn svg(picture: &impl Picture) -> Result<String, String> {
    register_fonts()?;
    let (width, height) = SIZE_PX;
    let fine = (width * FINE, height * FINE);
    let mut text = String::new();
    {
        let area = SVGBackend::with_string(&mut text, fine).into_drawing_area();
        draw_on(picture, &area)?;
    }
    // the back end rounds to whole units: the view box keeps the fine units, and width and height
    // are in picture pixels
    Ok(text.replacen(&format!(r#"width="{}" height="{}""#, fine.0, fine.1), &format!(r#"width="{width}" height="{height}""#), 1))
}

fn png(picture: &impl Picture) -> Result<Vec<u8>, String> {
    register_fonts()?;
    let (width, height) = SIZE_PX;
    let (fine_width, fine_height) = (width * FINE, height * FINE);
    let mut fine = vec![[0; 3]; fine_width as usize * fine_height as usize];
    let raster = Raster::new(&mut fine, fine_width, fine_height).ok_or("canvas size mismatch")?;
    draw_on(picture, &raster.into_drawing_area())?;
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, width, height);
    encoder.set_color(png::ColorType::Rgb);
    encoder
        .write_header()
        .and_then(|mut writer| writer.write_image_data(&average(&fine, fine_width)))
        .map_err(|e| e.to_string())?;
    Ok(bytes)
}

fn draw_on<DB: DrawingBackend>(picture: &impl Picture, area: &Area<DB>) -> Result<(), String> {
    area.fill(&plotters::style::WHITE).and_then(|()| picture.draw(area)).and_then(|()| area.present()).map_err(|e| e.to_string())
}

fn refused(path: &Path, message: &str) -> ChartError {
    ChartError::Draw { path: path.to_owned(), message: message.replace('\n', " ") }
}

/// A complete file under a temporary name in its final folder; it is deleted when dropped before
/// [`Self::publish`].
struct Staged {
    temporary: PathBuf,
    path: PathBuf,
}

impl Staged {
    fn write(folder: &Path, path: PathBuf, bytes: &[u8]) -> Result<Self, ChartError> {
        let mut hidden = std::ffi::OsString::from(".");
        hidden.push(path.file_name().unwrap_or_default());
        hidden.push(".part");
        let staged = Self { temporary: folder.join(hidden), path };
        match std::fs::write(&staged.temporary, bytes) {
            Ok(()) => Ok(staged),
            Err(source) => Err(staged.failed(source)),
        }
    }

    fn publish(&self) -> Result<(), ChartError> {
        std::fs::rename(&self.temporary, &self.path).map_err(|source| self.failed(source))
    }

    fn failed(&self, source: std::io::Error) -> ChartError {
        ChartError::Write { path: self.path.clone(), source }
    }
}

impl Drop for Staged {
    fn drop(&mut self) {
        // after `publish` the temporary name no longer exists and this has no effect
        let _ = std::fs::remove_file(&self.temporary);
    }
}
