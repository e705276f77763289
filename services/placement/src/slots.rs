//! A grid of slots in a region, so that the first samples of several hops do not lie on one another.

use crate::footprint::{Footprint, Rectangle};

/// Equal cells of a region's rectangle, numbered row by row.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Slots {
    rectangle: Rectangle,
    columns: usize,
    rows: usize,
}

impl Slots {
    /// As many cells as there are footprints, or fewer if not each footprint fits a cell with `clearance` (m) to spare;
    /// at least one cell, in which a footprint need not fit.
    pub fn new(rectangle: Rectangle, footprints: &[&Footprint], clearance: f64) -> Self {
        let extents: Vec<[f64; 2]> =
            footprints.iter().map(|footprint| footprint.extent(0.0).map(|edge| edge + clearance)).collect();
        let fitting = (2..=extents.len()).rev().find_map(|wanted| best_grid(rectangle, wanted, &extents));
        fitting.unwrap_or(Self { rectangle, columns: 1, rows: 1 })
    }

    /// Number of cells.
    pub fn count(&self) -> usize {
        self.columns * self.rows
    }

    /// Edge lengths of a cell (m).
    pub fn cell(&self) -> [f64; 2] {
        [self.rectangle.size[0] / self.columns as f64, self.rectangle.size[1] / self.rows as f64]
    }

    /// Middle of a cell (m, in the region's frame); numbers past the last begin again.
    pub fn middle(&self, number: usize) -> [f64; 2] {
        let (column, row) = (number % self.columns, number / self.columns % self.rows);
        let cell = self.cell();
        [
            (column as f64 + 0.5) * cell[0] - self.rectangle.size[0] / 2.0,
            (row as f64 + 0.5) * cell[1] - self.rectangle.size[1] / 2.0,
        ]
    }
}

/// How much of a cell an extent leaves over, at the better of the two quarter turns (m); negative if it does not fit.
fn slack(extent: [f64; 2], cell: [f64; 2]) -> f64 {
    let straight = (cell[0] - extent[0]).min(cell[1] - extent[1]);
    let across = (cell[0] - extent[1]).min(cell[1] - extent[0]);
    straight.max(across)
}

/// The grid of at least `wanted` cells that leaves the tightest footprint the most room, if all fit.
fn best_grid(rectangle: Rectangle, wanted: usize, extents: &[[f64; 2]]) -> Option<Slots> {
    let grids = (1..=wanted).map(|columns| Slots { rectangle, columns, rows: wanted.div_ceil(columns) });
    let with_slack = grids.map(|grid| {
        let least = extents.iter().map(|extent| slack(*extent, grid.cell())).fold(f64::MAX, f64::min);
        (least, grid)
    });
    let fitting = with_slack.filter(|(least, _)| *least >= 0.0);
    fitting.reduce(|best, next| if next.0 > best.0 { next } else { best }).map(|(_, grid)| grid)
}

#[cfg(test)]
mod tests {
    use super::*;
    use model::{Body, MovableObject, Pose, Shape};

    fn brick() -> Footprint {
        Footprint::of(&MovableObject {
            name: "brick".into(),
            body: Body { owner_from_shape: Pose::identity(), shape: Shape::Box { size: [0.07, 0.05, 0.15] } },
            world_from_start: Pose::identity(),
            start_support: None,
            grasps: vec![],
        })
    }

    #[test]
    fn a_long_shelf_is_cut_along_its_length_and_a_tiny_region_not_at_all() {
        let brick = brick();
        let four = [&brick; 4];
        let shelf = Slots::new(Rectangle { size: [0.79, 0.19] }, &four, 0.002);
        assert_eq!((shelf.columns, shelf.rows), (4, 1));
        assert!((shelf.middle(0)[0] + 0.29625).abs() < 1e-12 && shelf.middle(0)[1].abs() < 1e-12);
        assert_eq!(shelf.middle(5), shelf.middle(1));
        let tiny = Slots::new(Rectangle { size: [0.08, 0.06] }, &four, 0.002);
        assert_eq!((tiny.count(), tiny.middle(3)), (1, [0.0, 0.0]));
        let two = Slots::new(Rectangle { size: [0.15, 0.06] }, &four, 0.002);
        assert_eq!((two.columns, two.rows), (2, 1), "only two fit");
    }
}
