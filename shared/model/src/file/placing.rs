//! Where movable objects stand at the start.

use nalgebra::{Point3, Vector3};

use super::at::At;
use super::surfaces::{Surface, surfaces};
use super::syntax::MovableFile;
use crate::problem_error::{FindingKind, Found, Source, Span};
use crate::{FixedId, FixedObject, MovableObject, Pair, Region};

/// Slack for footprints that end on a region's border (m).
const BORDER: f64 = 1.0e-6;

/// Whether an object stands in a region: its whole footprint inside, its bottom within `tolerance` of the surface (m).
pub(crate) fn stands_in(object: &MovableObject, region: &Region, tolerance: f64) -> bool {
    (bottom(object) - region.world_from_region.translation.z).abs() <= tolerance && is_over(object, region)
}

/// Height of an object's lowest point at the start (m).
pub(crate) fn bottom(object: &MovableObject) -> f64 {
    object.world_from_start.translation.z - object.origin_height()
}

/// Whether an object's whole footprint lies above or below a region.
pub(crate) fn is_over(object: &MovableObject, region: &Region) -> bool {
    let region_from_object = region.world_from_region.inverse() * object.world_from_start;
    let outside = |along: f64, size: f64| along.abs() > size / 2.0 + BORDER;
    object.footprint().iter().all(|[x, y]| {
        let point = region_from_object * Point3::new(*x, *y, 0.0);
        !outside(point.x, region.size[0]) && !outside(point.y, region.size[1])
    })
}

/// All surfaces of a scene, with their objects.
pub(crate) fn all_surfaces(fixed: &[FixedObject]) -> Vec<(FixedId, Surface)> {
    let of = |(index, object): (usize, &FixedObject)| {
        surfaces(object).into_iter().map(move |surface| (FixedId::at(index), surface)).collect::<Vec<_>>()
    };
    fixed.iter().enumerate().flat_map(of).collect()
}

/// The fixed object that an object stands on at the start: the one whose surface is under its middle.
pub(crate) fn support(
    source: &Source,
    file: &MovableFile,
    object: &MovableObject,
    fixed: &[FixedObject],
    surfaces: &[(FixedId, Surface)],
    tolerance: f64,
) -> Found<FixedId> {
    let middle = middle(object);
    let gap = |surface: &Surface| bottom(object) - surface.height;
    let under = || surfaces.iter().filter(|(_, surface)| surface.contains([middle.x, middle.y]));
    let nearest = under().min_by(|a, b| gap(&a.1).abs().total_cmp(&gap(&b.1).abs()));
    match nearest {
        Some((support, surface)) if gap(surface).abs() <= tolerance => Ok(*support),
        Some((support, surface)) => {
            let (name, gap, top) = (&fixed[support.index()].name, gap(surface), surface.height);
            let place = file.pose.xyz.as_ref().map_or(file.pose.span, |at| at.span);
            let how = if gap > 0.0 { "floats" } else { "sinks" };
            let where_to = if gap > 0.0 { "above" } else { "into" };
            Err(source
                .finding(
                    place,
                    FindingKind::BadPlace,
                    format!("`{}` {how} {:.1} mm {where_to} `{name}`", object.name, gap.abs() * 1.0e3),
                )
                .help(format!("its z must be {:.4}: the top of `{name}` is at {top:.4}", top + object.origin_height())))
        }
        None => Err(source
            .finding(file.pose.span, FindingKind::BadPlace, format!("`{}` stands on nothing", object.name))
            .help("put it on a fixed object with a level top; a floor is a fixed object too")),
    }
}

/// The middle of the footprint, in the world.
fn middle(object: &MovableObject) -> Point3<f64> {
    let corners = object.footprint();
    let count = corners.len().max(1);
    let sum: Vector3<f64> = corners.iter().map(|[x, y]| Vector3::new(*x, *y, 0.0)).sum();
    object.world_from_start * Point3::from(sum / count as f64)
}

/// Checks that an object stands in the region where its first pair picks it.
pub(crate) fn first_hop(
    source: &Source,
    file: &At<MovableFile>,
    first: Option<(&Pair, Span)>,
    standing: &MovableObject,
    regions: &[Region],
    tolerance: f64,
) -> Found<Option<FixedId>> {
    let Some((pair, pair_span)) = first else { return Ok(None) };
    let region = &regions[pair.from.index()];
    if stands_in(standing, region, tolerance) {
        return Ok(Some(region.support));
    }
    let place = file.pose.xyz.as_ref().map_or(file.pose.span, |at| at.span);
    let inside = is_over(standing, region);
    let message = format!("`{}` does not stand in `{}`, where `{}` picks it", standing.name, region.name, pair.name);
    let help = if inside {
        let z = region.world_from_region.translation.z + standing.origin_height();
        format!("its z must be {z:.4}")
    } else {
        let other = regions.iter().find(|region| stands_in(standing, region, tolerance));
        other.map_or_else(
            || "its whole footprint must lie inside the region".to_owned(),
            |other| format!("it stands in `{}`", other.name),
        )
    };
    Err(source.finding(place, FindingKind::BadPlace, message).note(source, pair_span, "picked here").help(help))
}
