//! Fixed objects, movable objects and regions of a problem.

use nalgebra::{Translation3, UnitQuaternion, Vector3};

use super::at::At;
use super::names::Names;
use super::numbers::{finite, number, pose, positive, positive_number};
use super::surfaces::{covers, surfaces};
use super::syntax::{FixedFile, MovableFile, RegionFile, ShapeFile};
use crate::problem_error::{FindingKind, Found, Source, Span};
use crate::urdf::load_hull;
use crate::{Body, Files, FixedId, FixedObject, MovableObject, Pose, Region, Shape};

/// Most parts of one fixed object.
const MAX_PARTS: usize = 1_000;
/// Cosine above which an axis counts as vertical.
const UPRIGHT: f64 = 1.0 - 1.0e-9;

fn shape(files: &dyn Files, source: &Source, at: &At<ShapeFile>) -> Found<Shape> {
    Ok(match &at.value {
        ShapeFile::Box(size) => Shape::Box { size: positive(source, size, "a box's edge length")? },
        ShapeFile::Sphere(sphere) => Shape::Sphere { radius: positive_number(source, &sphere.radius, "a radius")? },
        ShapeFile::Cylinder(cylinder) => Shape::Cylinder {
            radius: positive_number(source, &cylinder.radius, "a radius")?,
            length: positive_number(source, &cylinder.height, "a height")?,
        },
        ShapeFile::Capsule(capsule) => Shape::Capsule {
            radius: positive_number(source, &capsule.radius, "a radius")?,
            length: positive_number(source, &capsule.length, "a length")?,
        },
        ShapeFile::Mesh(mesh) => {
            let scale = match &mesh.scale {
                Some(scale) => Vector3::from(finite(source, scale, "a scale")?),
                None => Vector3::repeat(1.0),
            };
            load_hull(files, source, mesh.file.span, &mesh.file, scale)?
        }
    })
}

/// Resolves a fixed object.
pub(crate) fn fixed(files: &dyn Files, source: &Source, file: &At<FixedFile>) -> Found<FixedObject> {
    let name = &file.name.value;
    let bodies = match (&file.shape, &file.shapes) {
        (Some(at), None) => vec![Body { owner_from_shape: Pose::identity(), shape: shape(files, source, at)? }],
        (None, Some(parts)) if !parts.is_empty() && parts.len() <= MAX_PARTS => {
            let mut bodies = Vec::with_capacity(parts.len());
            for part in &parts.value {
                let owner_from_shape = pose(source, part.pose.as_ref(), "a part's pose")?;
                bodies.push(Body { owner_from_shape, shape: shape(files, source, &part.shape)? });
            }
            bodies
        }
        (None, Some(parts)) => {
            return Err(source
                .finding(parts.span, FindingKind::TooLarge, format!("`{name}` has {} parts", parts.len()))
                .help(format!("give 1 to {MAX_PARTS} parts")));
        }
        (None, None) | (Some(_), Some(_)) => {
            let message = format!("`{name}` needs either `shape` or `shapes`");
            return Err(source
                .finding(file.name.span, FindingKind::Malformed, message)
                .help("for example `shape: {box: [0.4, 0.4, 0.6]}`"));
        }
    };
    let world_from_object = pose(source, file.pose.as_ref(), "the object's pose")?;
    Ok(FixedObject { name: name.clone(), world_from_object, bodies })
}

/// Resolves a movable object; its support and its grasps come later.
pub(crate) fn movable(files: &dyn Files, source: &Source, file: &At<MovableFile>) -> Found<MovableObject> {
    let world_from_start = pose(source, Some(&file.pose), "the object's pose")?;
    if (world_from_start.rotation * Vector3::z()).z < UPRIGHT {
        let place = file.pose.rpy.as_ref().map(|at| at.span).or(file.pose.quat_xyzw.as_ref().map(|at| at.span));
        return Err(source
            .finding(
                place.unwrap_or(file.pose.span),
                FindingKind::BadPlace,
                format!("`{}` does not stand upright", file.name.value),
            )
            .help("turn it about z only: objects stand with their z axis up; turn the shape's axes instead"));
    }
    Ok(MovableObject {
        name: file.name.value.clone(),
        body: Body { owner_from_shape: Pose::identity(), shape: shape(files, source, &file.shape)? },
        world_from_start,
        start_support: None,
        grasps: Vec::new(),
    })
}

/// Resolves a region.
///
/// `tolerance` is how far it may be from a surface of its fixed object (m).
pub(crate) fn region(
    source: &Source,
    file: &At<RegionFile>,
    fixed: &[FixedObject],
    names: &Names<'_>,
    tolerance: f64,
) -> Found<Region> {
    let support = names.find(source, &file.on)?;
    let object = &fixed[support];
    let size = positive(source, &file.size, "a region's size")?;
    let [x, y] = file.centre.as_ref().map_or(Ok([0.0; 2]), |at| finite(source, at, "a region's centre"))?;
    let yaw = file.yaw.as_ref().map_or(Ok(0.0), |at| number(source, at, "a region's yaw"))?;
    if (object.world_from_object.rotation * Vector3::z()).z < UPRIGHT {
        return Err(source
            .finding(file.on.span, FindingKind::BadPlace, format!("`{}` is tilted", object.name))
            .help("regions lie on objects whose z axis is up; turn its parts instead of the object"));
    }
    let surfaces = surfaces(object);
    let origin = object.world_from_object.translation.z;
    let height = match &file.height {
        Some(at) => number(source, at, "a region's height")?,
        None => {
            let highest = surfaces.iter().map(|surface| surface.height).reduce(f64::max);
            highest.ok_or_else(|| no_surface(source, file.on.span, &object.name))? - origin
        }
    };
    let object_from_region =
        Pose::from_parts(Translation3::new(x, y, height), UnitQuaternion::from_axis_angle(&Vector3::z_axis(), yaw));
    let region = Region {
        name: file.name.value.clone(),
        world_from_region: object.world_from_object * object_from_region,
        size,
        support: FixedId::at(support),
    };
    if covers(&surfaces, &region, tolerance) {
        return Ok(region);
    }
    let heights: Vec<String> = surfaces.iter().map(|surface| format!("{:.4}", surface.height - origin)).collect();
    Err(source
        .finding(
            file.size.span,
            FindingKind::BadPlace,
            format!("region `{}` sticks out of the surface of `{}`", region.name, object.name),
        )
        .help(format!(
            "at height {height} the surface does not cover the whole rectangle; surfaces of `{}` are at {}",
            object.name,
            heights.join(", ")
        )))
}

fn no_surface(source: &Source, span: Span, name: &str) -> Box<crate::Finding> {
    source
        .finding(span, FindingKind::BadPlace, format!("`{name}` has no level top surface"))
        .help("put regions on boxes, upright cylinders or meshes with a level top")
}
