//! What certainly stands in a region, and how much of it it covers: for proofs.

use model::{Problem, RegionId};
use plan::{Cover, Stay};

use crate::footprint::{Footprint, Rectangle};
use crate::layout::{Layout, Site};
use crate::outline::{Outline, is_upright};

/// Relative excess of areas that counts: proofs are checked with other mathematics.
const EXCESS: f64 = 1e-5;

/// Sites whose bodies stand wholly inside of one region's rectangle and cover the same area of it at every height.
#[derive(Clone, Debug)]
pub(crate) struct Guests {
    pub region: RegionId,
    /// Area of the region less its margin (m²).
    pub region_area_m2: f64,
    /// Sites with the areas (m²) that they cover, largest first.
    pub sites: Vec<(usize, f64)>,
}

impl Guests {
    pub fn of(problem: &Problem, layout: &Layout, region: RegionId) -> Self {
        let rectangle = Rectangle::new(&problem.regions[region.index()], &problem.settings);
        let inside = |site: &Site| match site.region(problem) {
            Some(to) => to == region,
            None => starts_inside(problem, site, region, &rectangle),
        };
        let area = |site: &Site| Outline::new(&problem.movable[site.object().index()].body).prism_area();
        let sites = layout.sites.iter().enumerate().filter(|(_, site)| inside(site));
        let mut sites: Vec<(usize, f64)> = sites.filter_map(|(index, site)| Some((index, area(site)?))).collect();
        sites.sort_by(|a, b| b.1.total_cmp(&a.1).then(a.0.cmp(&b.0)));
        Self { region, region_area_m2: rectangle.area(), sites }
    }

    /// Guests of every region.
    pub fn of_regions<'a>(problem: &'a Problem, layout: &'a Layout) -> impl Iterator<Item = Self> + 'a {
        (0..problem.regions.len()).map(|region| Self::of(problem, layout, RegionId::at(region)))
    }

    /// Whether an area is more than there is.
    pub fn exceed(&self, area_m2: f64) -> bool {
        area_m2 > self.region_area_m2 * (1.0 + EXCESS)
    }

    /// The stay at a site, with what it covers (m²).
    pub fn cover(problem: &Problem, layout: &Layout, (site, area_m2): (usize, f64)) -> Cover {
        let site = &layout.sites[site];
        let object = problem.movable[site.object().index()].name.clone();
        let placed_by = site.placed_by.map(|pair| problem.pair(pair).name.clone());
        Cover { stay: Stay { object, placed_by }, area_m2 }
    }
}

fn starts_inside(problem: &Problem, site: &Site, region: RegionId, rectangle: &Rectangle) -> bool {
    let object = &problem.movable[site.object().index()];
    let region_from_object = problem.regions[region.index()].world_from_region.inverse() * object.world_from_start;
    let height = region_from_object.translation.z - object.origin_height();
    let yaw = region_from_object.rotation.euler_angles().2;
    let at = [region_from_object.translation.x, region_from_object.translation.y];
    let room = Footprint::of(object).room(rectangle, yaw);
    is_upright(&region_from_object)
        && height.abs() <= problem.settings.support_tolerance
        && room.is_some_and(|room| (0..2).all(|i| (room.least[i]..=room.greatest[i]).contains(&at[i])))
}
