//! Footprints: where an upright object may stand in a region's rectangle.

use std::f64::consts::TAU;

use model::{MovableObject, Region, Settings};

/// Rounding error forgiven when an object fits exactly (m).
const FIT_TOLERANCE: f64 = 1e-12;
/// Parts of a full turn that are tried for yaws that fit: a window narrower than 0.25° may be missed.
const YAW_CELLS: usize = 1440;

/// The rectangle of a region that footprints must stay inside of, about the region's origin.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Rectangle {
    /// Full edge lengths along the region's x and y (m); negative if the margin leaves nothing.
    pub size: [f64; 2],
}

impl Rectangle {
    pub fn new(region: &Region, settings: &Settings) -> Self {
        Self { size: region.size.map(|edge| edge - 2.0 * settings.region_margin) }
    }

    pub fn area(&self) -> f64 {
        self.size[0].max(0.0) * self.size[1].max(0.0)
    }
}

/// Origins (m, in the region's frame) at which a footprint of some yaw is inside the rectangle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Room {
    pub least: [f64; 2],
    pub greatest: [f64; 2],
}

impl Room {
    /// The origin at fractions in [0, 1] of the room.
    pub fn at(&self, fractions: [f64; 2]) -> [f64; 2] {
        std::array::from_fn(|i| self.least[i] + fractions[i] * (self.greatest[i] - self.least[i]))
    }

    /// The origin nearest to a point.
    pub fn nearest(&self, point: [f64; 2]) -> [f64; 2] {
        std::array::from_fn(|i| point[i].clamp(self.least[i], self.greatest[i]))
    }
}

/// The convex footprint of an object seen from above, in its own frame.
#[derive(Clone, Debug)]
pub(crate) struct Footprint {
    corners: Vec<[f64; 2]>,
}

impl Footprint {
    pub fn of(object: &MovableObject) -> Self {
        Self { corners: object.footprint() }
    }

    /// Least and greatest coordinates of the footprint turned by `yaw` (m).
    pub fn bounds(&self, yaw: f64) -> ([f64; 2], [f64; 2]) {
        let (sin, cos) = yaw.sin_cos();
        let turned = self.corners.iter().map(|[x, y]| [cos * x - sin * y, sin * x + cos * y]);
        turned.fold(([f64::MAX; 2], [f64::MIN; 2]), |(low, high), p| {
            (std::array::from_fn(|i| low[i].min(p[i])), std::array::from_fn(|i| high[i].max(p[i])))
        })
    }

    /// Edge lengths of the bounds (m).
    pub fn extent(&self, yaw: f64) -> [f64; 2] {
        let (low, high) = self.bounds(yaw);
        std::array::from_fn(|i| high[i] - low[i])
    }

    /// Where it may stand with this yaw; `None` if it does not fit.
    pub fn room(&self, rectangle: &Rectangle, yaw: f64) -> Option<Room> {
        let (low, high) = self.bounds(yaw);
        let mut room = Room { least: [0.0; 2], greatest: [0.0; 2] };
        let mut fits = true;
        for i in 0..2 {
            let (least, greatest) = (-rectangle.size[i] / 2.0 - low[i], rectangle.size[i] / 2.0 - high[i]);
            let middle = (least + greatest) / 2.0;
            (room.least[i], room.greatest[i]) = (least.min(middle), greatest.max(middle));
            fits &= greatest - least >= -FIT_TOLERANCE;
        }
        fits.then_some(room)
    }
}

/// Yaws (rad, relative to the region) with which an object fits a rectangle.
#[derive(Clone, Debug)]
pub(crate) struct FittingYaws {
    /// Those among 0°, 90°, 180°, 270°.
    pub quarters: Vec<f64>,
    /// Middles of the fitting cells of a full turn.
    cells: Vec<f64>,
}

impl FittingYaws {
    pub fn new(footprint: &Footprint, rectangle: &Rectangle) -> Self {
        let fits = |yaw: &f64| footprint.room(rectangle, *yaw).is_some();
        let turn = |parts: usize| move |part: usize| TAU * part as f64 / parts as f64;
        let quarters = (0..4).map(turn(4)).filter(fits).collect();
        let cells = (0..YAW_CELLS).map(turn(YAW_CELLS)).filter(fits).collect();
        Self { quarters, cells }
    }

    /// One of the quarter turns, by a fraction in [0, 1).
    pub fn quarter(&self, fraction: f64) -> Option<f64> {
        pick(&self.quarters, fraction).map(|(yaw, _)| yaw)
    }

    /// Any fitting yaw, by a fraction in [0, 1): uniform over the fitting cells.
    pub fn any(&self, fraction: f64, footprint: &Footprint, rectangle: &Rectangle) -> Option<f64> {
        let (middle, within) = pick(&self.cells, fraction)?;
        let yaw = middle + (within - 0.5) * TAU / YAW_CELLS as f64;
        // At the edge of a fitting window the rest of the cell may not fit.
        Some(if footprint.room(rectangle, yaw).is_some() { yaw } else { middle })
    }
}

/// The element at a fraction of the list, and the fraction within that element.
fn pick(list: &[f64], fraction: f64) -> Option<(f64, f64)> {
    let position = fraction * list.len() as f64;
    let index = (position as usize).min(list.len().checked_sub(1)?);
    Some((list[index], (position - index as f64).clamp(0.0, 1.0)))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn brick() -> Footprint {
        Footprint { corners: vec![[0.035, 0.025], [-0.035, 0.025], [-0.035, -0.025], [0.035, -0.025]] }
    }

    #[test]
    fn room_is_what_the_turned_footprint_leaves() {
        let room = brick().room(&Rectangle { size: [0.08, 0.06] }, 0.0).unwrap();
        assert!((room.greatest[0] - 0.005).abs() < 1e-12 && (room.greatest[1] - 0.005).abs() < 1e-12);
        assert!(brick().room(&Rectangle { size: [0.08, 0.06] }, TAU / 4.0).is_none());
        assert!(brick().room(&Rectangle { size: [-0.01, 0.06] }, 0.0).is_none());
    }

    #[test]
    fn an_object_that_fits_exactly_fits() {
        let room = brick().room(&Rectangle { size: [0.07, 0.05] }, 0.0).unwrap();
        assert_eq!(room.at([0.3, 0.9]).map(|x| x.abs() < 1e-12), [true; 2]);
    }

    #[test]
    fn yaws_of_a_tight_rectangle_are_those_that_fit() {
        let rectangle = Rectangle { size: [0.08, 0.06] };
        let yaws = FittingYaws::new(&brick(), &rectangle);
        assert_eq!(yaws.quarters, [0.0, TAU / 2.0]);
        assert!(!yaws.cells.is_empty() && yaws.cells.len() < YAW_CELLS / 4);
        for i in 0..1000 {
            let yaw = yaws.any(f64::from(i) / 1000.0, &brick(), &rectangle).unwrap();
            assert!(brick().room(&rectangle, yaw).is_some(), "yaw {yaw}");
        }
    }
}
