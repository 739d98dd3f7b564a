//! Types of the canvas on which a picture is drawn and of the errors that drawing may return.

use plotters::coord::Shift;
use plotters::drawing::{DrawingArea, DrawingAreaErrorKind};
use plotters::prelude::DrawingBackend;

/// A rectangular part of the canvas; coordinates are in canvas units.
pub type Area<DB> = DrawingArea<DB, Shift>;

/// Result of a drawing routine on the back end `DB`.
pub type Drawn<DB> = Result<(), DrawingAreaErrorKind<<DB as DrawingBackend>::ErrorType>>;
