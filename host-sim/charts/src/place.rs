//! Finds a free place beside a point for its label.

use plotters::style::text_anchor::{HPos, VPos};
use plotters_backend::BackendCoord;

/// An axis-aligned box on the canvas [canvas units]; y points down.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Frame {
    /// Upper left corner.
    pub low: BackendCoord,
    /// Lower right corner.
    pub high: BackendCoord,
}

impl Frame {
    /// Whether the interiors of the two boxes overlap.
    pub fn meets(&self, other: &Self) -> bool {
        self.low.0 < other.high.0 && other.low.0 < self.high.0 && self.low.1 < other.high.1 && other.low.1 < self.high.1
    }

    fn holds(&self, p: BackendCoord) -> bool {
        self.low.0 <= p.0 && p.0 <= self.high.0 && self.low.1 <= p.1 && p.1 <= self.high.1
    }

    /// Squared distance from `p` to the nearest point of the box [canvas units squared].
    fn distance2(&self, p: BackendCoord) -> i64 {
        let dx = i64::from((self.low.0 - p.0).max(p.0 - self.high.0).max(0));
        let dy = i64::from((self.low.1 - p.1).max(p.1 - self.high.1).max(0));
        dx * dx + dy * dy
    }

    fn encloses(&self, other: &Self) -> bool {
        self.holds(other.low) && self.holds(other.high)
    }
}

/// A drawing surface that records where something is already drawn.
pub struct Page {
    frame: Frame,
    ink: Vec<BackendCoord>,
    boxes: Vec<Frame>,
    dots: Vec<BackendCoord>,
}

impl Page {
    /// An empty page whose labels must stay inside `frame`.
    pub fn new(frame: Frame) -> Self {
        Self { frame, ink: Vec::new(), boxes: Vec::new(), dots: Vec::new() }
    }

    /// Marks a curve as ink, by points at most `step` apart [canvas units].
    pub fn add_curve(&mut self, curve: impl IntoIterator<Item = BackendCoord>, step: i32) {
        let mut last: Option<BackendCoord> = None;
        for to in curve {
            let from = last.replace(to).unwrap_or(to);
            let marks = (to.0 - from.0).abs().max((to.1 - from.1).abs()) / step.max(1) + 1;
            for k in 1..=marks {
                let along = |a: i32, b: i32| a + (b - a) * k / marks;
                self.ink.push((along(from.0, to.0), along(from.1, to.1)));
            }
        }
    }

    /// Marks a box, such as a legend, as occupied.
    pub fn add_box(&mut self, taken: Frame) {
        self.boxes.push(taken);
    }

    /// Marks a labelled point of `radius` [canvas units].
    pub fn add_dot(&mut self, at: BackendCoord, radius: i32) {
        self.dots.push(at);
        self.boxes.push(Frame { low: (at.0 - radius, at.1 - radius), high: (at.0 + radius, at.1 + radius) });
    }

    /// Reserves a free box of `size` at a distance of `gap` from `at`, and returns the position and
    /// the alignment of the label. Returns `None` if every side is occupied, because an unlabelled
    /// point is easier to read than two labels on top of each other.
    pub fn place(&mut self, at: BackendCoord, size: (i32, i32), gap: i32) -> Option<(BackendCoord, (HPos, VPos))> {
        let (w, h) = size;
        // above left is tried first: a press curve bends upward and leaves that side free
        let mut sides = [gap, 2 * gap, 4 * gap].into_iter().flat_map(|gap| {
            [
                (HPos::Right, (at.0 - gap - w, at.1 - gap - h)),
                (HPos::Right, (at.0 - 2 * gap - w, at.1 - h / 2)),
                (HPos::Left, (at.0 + gap, at.1 + gap)),
                (HPos::Left, (at.0 + 2 * gap, at.1 - h / 2)),
                (HPos::Left, (at.0 + gap, at.1 - gap - h)),
                (HPos::Right, (at.0 - gap - w, at.1 + gap)),
            ]
        });
        sides.find_map(|(anchor, low)| {
            let spot = Frame { low, high: (low.0 + w, low.1 + h) };
            let free = self.frame.encloses(&spot)
                && !self.boxes.iter().any(|b| b.meets(&spot))
                && !self.ink.iter().any(|p| spot.holds(*p))
                // a label nearer to another point would be taken for that point's label
                && !(self.dots.iter()).any(|d| spot.distance2(*d) < spot.distance2(at));
            free.then(|| {
                self.boxes.push(spot);
                let x = match anchor {
                    HPos::Right => spot.high.0,
                    _ => spot.low.0,
                };
                ((x, low.1 + h / 2), (anchor, VPos::Center))
            })
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn labels_keep_off_each_other_the_curve_and_the_frame() {
        let frame = Frame { low: (0, 0), high: (400, 400) };
        let mut page = Page::new(frame);
        page.add_curve((0..=40).map(|i| (i * 10, 400 - i * i / 4)), 4);
        let points: Vec<_> = (0..=40).map(|i| (i * 10, 400 - i * i / 4)).collect();
        let placed = points.iter().filter_map(|p| page.place(*p, (60, 16), 6)).count();
        assert!(placed >= 5 && placed < points.len(), "{placed}");
        for (i, a) in page.boxes.iter().enumerate() {
            assert!(frame.encloses(a));
            assert!(!page.ink.iter().any(|p| a.holds(*p)));
            assert!(page.boxes.iter().skip(i + 1).all(|b| !a.meets(b)));
        }
    }
}
