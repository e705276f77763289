//! What there is room for in a region: areas covered at a common height, and widths.

use glamx::{DVec2, DVec3};
use model::{Problem, Region, RegionId, Settings, Shape};

use crate::contact::UPRIGHT;
use crate::frame::Frame;
use crate::infeasible::named::Occupation;
use crate::section::{Inside, Polygon};
use crate::solid::Solid;

/// Cosine short of 1 of a tilt that counts as none.
const LEVEL: f64 = 1e-9;
/// Relative allowance for rounding, for leaning within tolerance, and for what rule V7 lets a footprint stick out.
const SLACK: f64 = 1e-6;
/// Heights tried between the greatest bottom and the least top of a crowd.
const HEIGHTS: usize = 5;
/// Greatest number of halvings of a half turn.
const MOST_HALVINGS: u32 = 40;

/// A region's rectangle that footprints must stay in, with its frame made ready.
pub(crate) struct Rectangle {
    pub(crate) world_from_region: Frame,
    /// Half edge lengths less the margin (m); negative if nothing is left.
    pub(crate) half: DVec2,
    /// Height of the surface (m).
    pub(crate) height: f64,
}

impl Rectangle {
    /// `None` for a region that is not level.
    pub(crate) fn of(region: &Region, settings: &Settings) -> Option<Self> {
        let world_from_region = Frame::of(&region.world_from_region);
        let half = DVec2::from(region.size) / 2.0 - DVec2::splat(settings.region_margin);
        let level = world_from_region.rotation.z_axis.z >= 1.0 - LEVEL;
        level.then_some(Self { world_from_region, half, height: world_from_region.origin.z })
    }

    pub(crate) fn area(&self) -> f64 {
        let free = self.half.max(DVec2::ZERO) * 2.0;
        free.x * free.y
    }

    /// The part of a polygon (in the world) that lies within.
    fn clip(&self, polygon: Polygon) -> Polygon {
        let origin = self.world_from_region.origin.truncate();
        let axes = [self.world_from_region.rotation.x_axis, self.world_from_region.rotation.y_axis];
        let sides = axes.into_iter().zip([self.half.x, self.half.y]).flat_map(|(axis, half)| {
            let axis = axis.truncate().normalize();
            [(axis, axis.dot(origin) + half), (-axis, half - axis.dot(origin))]
        });
        sides.fold(polygon, |polygon, (normal, offset)| polygon.cut(normal, offset))
    }
}

/// A body that is in a region during a stay: where it is known to be.
struct Guest {
    inside: Inside,
    /// Area (m²) at every height, where it is that of an upright cylinder.
    disc: Option<f64>,
    /// Heights between which it is for certain (m).
    bottom: f64,
    top: f64,
    /// How much higher or lower it may stand than given (m).
    tolerance: f64,
    /// Whether it stands where the problem says, rather than anywhere within the rectangle.
    is_start: bool,
}

impl Guest {
    fn of(problem: &Problem, stay: &Occupation, region: RegionId, rectangle: &Rectangle) -> Result<Self, String> {
        let object = &problem.movable[stay.object.index()];
        let start = Frame::of(&object.world_from_start);
        let (frame, tolerance) = match stay.placed_by.map(|pair| problem.pair(pair)) {
            None => (start, SLACK),
            Some(pair) if pair.to == region => {
                let solid = Solid::new(&object.body);
                let lowest = -solid.height_along(&solid.owner_from_shape, -DVec3::Z);
                let frame = Frame::shifted(DVec3::new(0.0, 0.0, rectangle.height - lowest));
                (frame, problem.settings.support_tolerance + SLACK)
            }
            Some(pair) => return Err(format!("{} does not bring {} there", pair.name, object.name)),
        };
        let inside = Inside::of(&object.body, &frame);
        let (low, high) = inside.heights();
        let is_start = stay.placed_by.is_none();
        let disc = match &object.body.shape {
            Shape::Cylinder { radius, .. } if is_upright(&(frame * Frame::of(&object.body.owner_from_shape))) => {
                Some(std::f64::consts::PI * radius * radius)
            }
            _ => None,
        };
        Ok(Self { inside, disc, bottom: low + tolerance, top: high - tolerance, tolerance, is_start })
    }

    /// Area (m²) that it covers within the rectangle at a height, at least. The section's area as a function of the height
    /// has no minimum in between: its square root is concave (Brunn and Minkowski).
    fn covered(&self, z: f64, rectangle: &Rectangle) -> f64 {
        let area = |z: f64| {
            let section = self.inside.section(z);
            if !self.is_start {
                return self.disc.unwrap_or(section.area());
            }
            let (whole, within) = (section.area(), rectangle.clip(section).area());
            if within >= whole * (1.0 - SLACK) { self.disc.unwrap_or(within) } else { within }
        };
        area(z - self.tolerance).min(area(z + self.tolerance))
    }
}

fn is_upright(frame: &Frame) -> bool {
    frame.rotation.z_axis.z.abs() >= 1.0 - LEVEL
}

/// Checks that stays cover together, at some height, more of a region than there is, and no less than claimed.
pub(crate) fn check_crowd(
    problem: &Problem,
    region: RegionId,
    region_area: f64,
    stays: &[(Occupation, f64)],
) -> Result<(), String> {
    let model = &problem.regions[region.index()];
    let rectangle = Rectangle::of(model, &problem.settings).ok_or_else(|| format!("{} is not level", model.name))?;
    for (i, (stay, _)) in stays.iter().enumerate() {
        if stays[..i].iter().any(|(other, _)| other.object == stay.object) {
            return Err("two stays of one object never overlap".to_owned());
        }
    }
    if region_area < rectangle.area() * (1.0 - SLACK) {
        return Err(format!("{} has {} m² within its margin, not {region_area}", model.name, rectangle.area()));
    }
    let claimed: f64 = stays.iter().map(|(_, area)| area).sum();
    let exceeds = claimed > region_area * (1.0 + 2.0 * SLACK);
    if !exceeds {
        return Err(format!("{claimed} m² are no more than the {region_area} m² of {}", model.name));
    }
    let guests = stays.iter().map(|(stay, _)| Guest::of(problem, stay, region, &rectangle));
    let guests = guests.collect::<Result<Vec<_>, String>>()?;
    let bottom = guests.iter().map(|guest| guest.bottom).fold(f64::MIN, f64::max);
    let top = guests.iter().map(|guest| guest.top).fold(f64::MAX, f64::min);
    if bottom >= top {
        return Err("the objects have no height in common".to_owned());
    }
    let covers = |z: f64| {
        let mut pairs = guests.iter().zip(stays);
        pairs.all(|(guest, (_, area))| guest.covered(z, &rectangle) >= area * (1.0 - SLACK) - SLACK * SLACK)
    };
    let heights = (0..HEIGHTS).map(|i| bottom + (top - bottom) * (i as f64 + 0.5) / HEIGHTS as f64);
    if heights.into_iter().any(covers) { Ok(()) } else { Err("an object covers less than is claimed".to_owned()) }
}

/// Checks that a body sticks out of a region's rectangle at every yaw.
pub(crate) fn check_too_large(problem: &Problem, object: usize, region: RegionId) -> Result<(), String> {
    let model = &problem.regions[region.index()];
    let rectangle = Rectangle::of(model, &problem.settings).ok_or_else(|| format!("{} is not level", model.name))?;
    let body = &problem.movable[object].body;
    let solid = Solid::new(body);
    // Widths change by at most the diameter per radian; and by this much where the object leans within tolerance.
    let diameter = 2.0 * solid.radius;
    let free = rectangle.half * 2.0 + DVec2::splat(2.0 * UPRIGHT * diameter + SLACK * SLACK);
    let width = |direction: DVec3| {
        let frame = &solid.owner_from_shape;
        solid.height_along(frame, direction) + solid.height_along(frame, -direction)
    };
    let mut open = vec![(0.0, std::f64::consts::PI, 0)];
    while let Some((from, to, halvings)) = open.pop() {
        let (middle, half) = (f64::midpoint(from, to), (to - from) / 2.0);
        let (sin, cos) = middle.sin_cos();
        let [x, y] = [DVec3::new(cos, sin, 0.0), DVec3::new(-sin, cos, 0.0)].map(|axis| width(axis) - diameter * half);
        if x > free.x || y > free.y {
            continue;
        }
        if halvings == MOST_HALVINGS
            || width(DVec3::new(cos, sin, 0.0)).max(0.0) <= free.x - SLACK
                && width(DVec3::new(-sin, cos, 0.0)) <= free.y - SLACK
        {
            let name = &problem.movable[object].name;
            return Err(format!("{name} fits into {} when turned by {middle:.4} rad", model.name));
        }
        open.extend([(from, middle, halvings + 1), (middle, to, halvings + 1)]);
    }
    Ok(())
}
