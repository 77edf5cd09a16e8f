//! What C says of a body.

use std::ffi::c_char;

use super::abi::{
    Sized32, boolean, c_pose, init_sized, jostle_body, jostle_pose2, jostle_vec2, optional_text, out, pose, read_sized,
    slice, text,
};
use super::guard::guard;
use super::scene::{jostle_scene, with};
use super::status::{Failure, Outcome, jostle_status};
use crate::error::Error;
use crate::geom::{CompoundPart, Pose2, Shape, check_corner_count};
use crate::scene::{Body, BodyDef, library};

/// What a shape is: one of the JOSTLE_SHAPE_ values.
pub type jostle_shape = i32;
/// A simple polygon, convex or not: `points`, in order round the outline, in either direction. Corners within 0.1 um of the
/// one before them count once, also where the last repeats the first.
pub const JOSTLE_SHAPE_POLYGON: jostle_shape = 1;
/// As JOSTLE_SHAPE_POLYGON, but refused where it is not convex.
pub const JOSTLE_SHAPE_CONVEX_POLYGON: jostle_shape = 2;
/// A disc of `radius` about the origin.
pub const JOSTLE_SHAPE_DISC: jostle_shape = 3;
/// `parts` at poses in the body frame; they should touch.
pub const JOSTLE_SHAPE_COMPOUND: jostle_shape = 4;
/// A block of the library by its name `block`, with its measured mass, height and friction.
pub const JOSTLE_SHAPE_BLOCK: jostle_shape = 5;

/// A part of a compound shape. Frozen: never changes.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct jostle_shape_part {
    /// JOSTLE_SHAPE_POLYGON, JOSTLE_SHAPE_CONVEX_POLYGON or JOSTLE_SHAPE_DISC.
    pub shape: jostle_shape,
    /// 0.
    pub reserved: u32,
    /// In the body frame, each coordinate in -10 to 10 m.
    pub pose: jostle_pose2,
    /// Corners of a polygon, metres: 3 to 4096 corners, each coordinate in -10 to 10 m.
    pub points: *const jostle_vec2,
    pub point_count: usize,
    /// Of a disc, 6e-4 to 10 m.
    pub radius: f64,
}

/// A body: an upright prism on the table. SI units. Everything it points to is copied.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct jostle_body_def {
    /// Set by jostle_body_def_default().
    pub struct_size: u32,
    /// JOSTLE_SHAPE_POLYGON by default.
    pub shape: jostle_shape,
    /// Where it is at first: (0, 0, 0) by default. Like every pose in the world, x and y lie in -100 to 100 m (poses are
    /// stored in single precision: put the origin near the workspace) and theta in -1e6 to 1e6 rad.
    pub pose: jostle_pose2,
    /// Corners of a polygon in the body frame, metres: 3 to 4096 corners, each coordinate in -10 to 10 m.
    pub points: *const jostle_vec2,
    pub point_count: usize,
    /// Of a disc, 6e-4 to 10 m.
    pub radius: f64,
    /// Parts of a compound: 1 to 256 parts.
    pub parts: *const jostle_shape_part,
    pub part_count: usize,
    /// Name of a block of the library.
    pub block: *const c_char,
    /// Unique in its scene; null (the default) for "body N".
    pub name: *const c_char,
    /// From the table up, 1e-4 to 10 m: 0.045 by default. A block has its own: leave height, mass, friction,
    /// centre_of_mass, inertia and outline_tolerance at their defaults.
    pub height: f64,
    /// 1e-9 to 1000 kg: 0.1 by default.
    pub mass: f64,
    /// Coefficient of its surface, 0 to 10: 0.5 by default; a contact uses the product of the two surfaces' coefficients.
    pub friction: f64,
    /// 1 (the default) if a grasp may take it.
    pub pickable: u32,
    /// 1 (the default) if a push may be aimed at it. Any body may be moved by the others.
    pub pushable: u32,
    /// 1 (the default) if it is there.
    pub present: u32,
    /// 1 if `centre_of_mass` is given; 0 (the default) takes the centroid.
    pub has_centre_of_mass: u32,
    /// In the body frame, each coordinate in -10 to 10 m.
    pub centre_of_mass: jostle_vec2,
    /// About the centre of mass, kg m^2; 0 (the default) takes a uniform prism's. Its radius of gyration, the root of
    /// inertia over mass, lies in 1e-4 to 10 m.
    pub inertia: f64,
    /// Corners of a polygon that lie within so many metres of the outline without them are left out: planning takes
    /// longer the more there are. 0 keeps all, 0.01 is the most; -1 (the default) is 0.1 mm, or a hundredth of the
    /// shape's thickness (twice the area over the perimeter) where that is less. jostle_scene_body_info says what
    /// became of the outline.
    pub outline_tolerance: f64,
}

/// What was made of a body's shape. Frozen: never changes.
#[repr(C)]
#[derive(Debug, Clone, Copy, Default)]
pub struct jostle_body_info {
    /// Corners that stand for its outlines; a disc has 32.
    pub corners: u32,
    /// Convex pieces.
    pub pieces: u32,
    /// Square metres, of the shape as given.
    pub area: f64,
    /// Greatest distance of a corner that was left out from the outline, metres.
    pub deviation: f64,
}

/// The outline tolerance that leaves the choice to the library.
const AUTOMATIC: f64 = -1.0;

// SAFETY: repr(C), struct_size first, numbers and pointers without padding.
unsafe impl Sized32 for jostle_body_def {
    const NAME: &'static str = "jostle_body_def";
    const FIRST_SIZE: usize = 152;
    fn defaults() -> Self {
        let body = BodyDef::new(Shape::Disc { radius: 0.0 });
        jostle_body_def {
            struct_size: size_of::<Self>() as u32,
            shape: JOSTLE_SHAPE_POLYGON,
            pose: jostle_pose2::default(),
            points: std::ptr::null(),
            point_count: 0,
            radius: 0.0,
            parts: std::ptr::null(),
            part_count: 0,
            block: std::ptr::null(),
            name: std::ptr::null(),
            height: body.height,
            mass: body.mass,
            friction: body.friction,
            pickable: 1,
            pushable: 1,
            present: 1,
            has_centre_of_mass: 0,
            centre_of_mass: jostle_vec2::default(),
            inertia: 0.0,
            outline_tolerance: AUTOMATIC,
        }
    }
}

/// Sets every field to its default; `size` is sizeof(jostle_body_def) as the caller was compiled.
/// jostle_body_def_default() in this header does it for you.
///
/// Thread: any.
/// RT: yes.
/// Nullable: none.
/// Owns: the caller.
/// Errors: ARGUMENT (null, a size that no version has).
#[unsafe(no_mangle)]
pub unsafe extern "C" fn jostle_body_def_init(def: *mut jostle_body_def, size: usize) -> jostle_status {
    // SAFETY: the caller promises `size` writable bytes.
    guard("jostle_body_def_init", |_| unsafe { init_sized(def, "def", size) })
}

/// What was made of a body's shape: how many corners and pieces, and how far its outline went from the given one.
///
/// Thread: shared use of scene.
/// RT: no.
/// Nullable: none.
/// Owns: nothing.
/// Errors: ARGUMENT (null, zero body), HANDLE, BUSY, NOT_FOUND, POISONED.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn jostle_scene_body_info(
    scene: *const jostle_scene,
    body: jostle_body,
    info: *mut jostle_body_info,
) -> jostle_status {
    with("jostle_scene_body_info", scene, |content| {
        // SAFETY: the caller promises a writable place.
        let out = unsafe { out(info, "info") }?;
        let index = content.index(body, "body")?;
        let model = content.model()?;
        let footprint = &model.body(index).footprint;
        out.set(jostle_body_info {
            corners: footprint.outlines.iter().map(Vec::len).sum::<usize>() as u32,
            pieces: footprint.pieces.len() as u32,
            area: footprint.area,
            deviation: footprint.deviation,
        });
        Ok(())
    })
}

/// A body that was checked.
pub(super) struct NewBody {
    pub def: BodyDef,
    pub pose: Pose2,
    pub present: bool,
}

/// Reads and checks a definition; failures name its fields as C has them.
///
/// # Safety
/// The pointers of the definition point to what their counts say, until the call returns.
pub(super) unsafe fn read_def(def: *const jostle_body_def) -> Outcome<NewBody> {
    // SAFETY: as promised by the caller.
    let given = unsafe { read_sized(def, "def") }?;
    let pose = pose(given.pose, "def.pose")?;
    let present = boolean(given.present, "def.present")?;
    // SAFETY: as promised by the caller.
    let name = unsafe { optional_text(given.name, "def.name") }?.unwrap_or("");
    let flags = (boolean(given.pickable, "def.pickable")?, boolean(given.pushable, "def.pushable")?);
    let has_centre = boolean(given.has_centre_of_mass, "def.has_centre_of_mass")?;
    let mut body = if given.shape == JOSTLE_SHAPE_BLOCK {
        own_measures_only(&given)?;
        // SAFETY: as promised by the caller.
        library::block(unsafe { text(given.block, "def.block") }?).map_err(|error| c_field(error.within("def")))?
    } else {
        // SAFETY: as promised by the caller.
        let mut body = BodyDef::new(unsafe { read_shape(&given) }?);
        (body.height, body.mass, body.friction) = (given.height, given.mass, given.friction);
        body.centre_of_mass = has_centre.then_some([given.centre_of_mass.x, given.centre_of_mass.y]);
        // Not `> 0`: what is negative or not a number goes on to the check and is refused there.
        body.inertia = (given.inertia != 0.0).then_some(given.inertia);
        body.outline_tolerance = (given.outline_tolerance != AUTOMATIC).then_some(given.outline_tolerance);
        body
    };
    body.name = name.to_string();
    (body.pickable, body.pushable) = flags;
    Body::new(body.clone()).map_err(|error| c_field(error.within("def")))?;
    Ok(NewBody { def: body, pose, present })
}

/// A block brings its own measures: one that is set beside it would be ignored in silence.
fn own_measures_only(given: &jostle_body_def) -> Outcome {
    let usual = jostle_body_def::defaults();
    for (field, given, usual) in [
        ("def.height", given.height, usual.height),
        ("def.mass", given.mass, usual.mass),
        ("def.friction", given.friction, usual.friction),
        ("def.inertia", given.inertia, usual.inertia),
        ("def.has_centre_of_mass", f64::from(given.has_centre_of_mass), 0.0),
        ("def.outline_tolerance", given.outline_tolerance, usual.outline_tolerance),
    ] {
        if given != usual {
            return Err(Failure::argument(
                field,
                "is set, but a block of the library brings its own; leave the default",
            ));
        }
    }
    Ok(())
}

unsafe fn read_shape(given: &jostle_body_def) -> Outcome<Shape> {
    if given.shape != JOSTLE_SHAPE_COMPOUND {
        // SAFETY: as promised by the caller of `read_def`.
        return unsafe { simple_shape(given.shape, given.points, given.point_count, given.radius, "def") };
    }
    // SAFETY: as promised by the caller of `read_def`.
    let parts = unsafe { slice(given.parts, given.part_count, "def.parts") }?;
    let mut shapes = Vec::with_capacity(parts.len());
    for (i, part) in parts.iter().enumerate() {
        let field = format!("def.parts[{i}]");
        shapes.push(CompoundPart {
            // Checked with the shape: it lies in the body's frame, not in the world.
            pose: part.pose.into(),
            // SAFETY: as promised by the caller of `read_def`.
            shape: unsafe { simple_shape(part.shape, part.points, part.point_count, part.radius, &field) }?,
        });
    }
    Ok(Shape::Compound(shapes))
}

unsafe fn simple_shape(
    shape: jostle_shape,
    points: *const jostle_vec2,
    count: usize,
    radius: f64,
    field: &str,
) -> Outcome<Shape> {
    match shape {
        JOSTLE_SHAPE_POLYGON | JOSTLE_SHAPE_CONVEX_POLYGON => {
            // Before that many are read.
            check_corner_count(&format!("{field}.points"), count)?;
            // SAFETY: as promised by the caller of `read_def`.
            let points = unsafe { slice(points, count, &format!("{field}.points")) }?;
            let points = points.iter().map(|p| [p.x, p.y]).collect();
            Ok(if shape == JOSTLE_SHAPE_POLYGON { Shape::Polygon(points) } else { Shape::ConvexPolygon(points) })
        }
        JOSTLE_SHAPE_DISC => Ok(Shape::Disc { radius }),
        _ => Err(Failure::argument(&format!("{field}.shape"), format!("is {shape}; no shape has this number here"))),
    }
}

/// Puts the C names of fields in place of the Rust ones: `def.shape.polygon[2]` is `def.points[2]`.
fn c_field(error: Error) -> Failure {
    let rename = |field: String| {
        field
            .replace("shape.compound[", "parts[")
            .replace(".shape.disc.", ".")
            .replace("].disc.", "].")
            .replace(".shape.convex_polygon", ".points")
            .replace(".shape.polygon", ".points")
            .replace("].convex_polygon", "].points")
            .replace("].polygon", "].points")
            .replace(".shape.compound", ".parts")
    };
    match error {
        Error::Argument { field, reason } => c_pose(Error::Argument { field: rename(field), reason }).into(),
        other => other.into(),
    }
}
