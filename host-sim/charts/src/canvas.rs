//! The canvas that a picture is drawn on, and how drawing on it fails.

use plotters::coord::Shift;
use plotters::drawing::{DrawingArea, DrawingAreaErrorKind};
use plotters::prelude::DrawingBackend;

/// A part of the canvas, in canvas units.
pub type Area<DB> = DrawingArea<DB, Shift>;

/// Result of a drawing routine on back end `DB`.
pub type Drawn<DB> = Result<(), DrawingAreaErrorKind<<DB as DrawingBackend>::ErrorType>>;
