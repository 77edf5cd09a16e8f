//! Scenes from images: bodies of a label image, and the poses of known bodies.

use super::abi::{
    Sized32, boolean, fill, init_sized, jostle_body, jostle_pose2, jostle_vec2, read_sized, read_sized_or_default,
};
use super::guard::guard;
use super::image::{jostle_pixel_map, layout, read_map};
use super::scene::{jostle_scene, with, with_mut};
use super::status::{Failure, Outcome, jostle_status};
use crate::geom::{Pose2, Shape};
use crate::scene::BodyDef;
use crate::vision::{
    AtBorder, Image, MAX_SIDE, MatchOptions, Matcher, PixelMap, RegionFinder, ShapeFinder, ShapeOptions, SkipReason,
};

/// A camera's image of the table.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct jostle_camera_image {
    /// Set by jostle_camera_image_default().
    pub struct_size: u32,
    /// 0.
    pub reserved: u32,
    /// At most 16384.
    pub rows: usize,
    /// At most 16384.
    pub cols: usize,
    /// Which body each pixel shows, from a segmentation: 0 for the table, 1 to 255 for bodies. Null if there are masks.
    pub labels: *const u8,
    /// From a row of labels to the next, bytes.
    pub label_stride: usize,
    /// In place of labels, a mask for each body, one after the other: 0 where a pixel does not show it. The mask at k
    /// counts as label k + 1. Masks may overlap.
    pub masks: *const u8,
    /// At most 255.
    pub mask_count: usize,
    /// From a row of a mask to the next, bytes.
    pub mask_stride: usize,
    /// From a mask to the next, bytes.
    pub mask_plane_stride: usize,
    /// Height of what each pixel shows above the table, metres; NaN, 0 and less where it is not known. May be null.
    pub heights: *const f32,
    /// From a row of heights to the next, bytes.
    pub height_stride: usize,
    /// Where the pixels lie on the table.
    pub map: jostle_pixel_map,
}

// SAFETY: repr(C), struct_size first, numbers and pointers without padding.
unsafe impl Sized32 for jostle_camera_image {
    const NAME: &'static str = "jostle_camera_image";
    const FIRST_SIZE: usize = 136;
    fn defaults() -> Self {
        jostle_camera_image {
            struct_size: size_of::<Self>() as u32,
            reserved: 0,
            rows: 0,
            cols: 0,
            labels: std::ptr::null(),
            label_stride: 0,
            masks: std::ptr::null(),
            mask_count: 0,
            mask_stride: 0,
            mask_plane_stride: 0,
            heights: std::ptr::null(),
            height_stride: 0,
            map: jostle_pixel_map {
                origin: jostle_vec2::default(),
                column: jostle_vec2 { x: 0.002, y: 0.0 },
                row: jostle_vec2 { x: 0.0, y: 0.002 },
            },
        }
    }
}

/// What becomes of a body that reaches the image's border: one of the JOSTLE_BORDER_ values.
pub type jostle_border = i32;
/// It is taken as far as it is seen.
pub const JOSTLE_BORDER_KEEP: jostle_border = 1;
/// It is left out and reported (the default).
pub const JOSTLE_BORDER_SKIP: jostle_border = 2;
/// The image is refused.
pub const JOSTLE_BORDER_REFUSE: jostle_border = 3;

/// How images are read.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct jostle_image_options {
    /// Set by jostle_image_options_default().
    pub struct_size: u32,
    /// JOSTLE_BORDER_SKIP by default. For new bodies only.
    pub at_border: jostle_border,
    /// How far the simplified outline of a new body may be from that between the pixels, pixels: 1 by default.
    pub tolerance: f64,
    /// Smaller regions are left out, square metres: 1e-4 by default.
    pub min_area: f64,
    /// A new body's height is this quantile of the heights of its pixels: 0.9 by default.
    pub height_quantile: f64,
    /// Of new bodies where the image has no heights, metres: 0.045 by default.
    pub height: f64,
    /// Of new bodies, kilograms: 0.1 by default.
    pub mass: f64,
    /// Of new bodies, 0.5 by default.
    pub friction: f64,
    /// A known body is not taken for a region that fits it worse than this, pixels: 3 by default.
    pub greatest_cost: f64,
    /// 1 (the default) if round outlines become discs.
    pub discs: u32,
    /// 0.
    pub reserved: u32,
}

// SAFETY: repr(C), struct_size first, numbers without padding.
unsafe impl Sized32 for jostle_image_options {
    const NAME: &'static str = "jostle_image_options";
    const FIRST_SIZE: usize = 72;
    fn defaults() -> Self {
        let options = ShapeOptions::default();
        jostle_image_options {
            struct_size: size_of::<Self>() as u32,
            at_border: JOSTLE_BORDER_SKIP,
            tolerance: options.tolerance,
            min_area: options.min_area,
            height_quantile: options.height_quantile,
            height: options.body.height,
            mass: options.body.mass,
            friction: options.body.friction,
            greatest_cost: MatchOptions::default().greatest_cost,
            discs: u32::from(options.discs),
            reserved: 0,
        }
    }
}

/// What became of a region or of a known body: one of the JOSTLE_SEEN_ values.
pub type jostle_seen = i32;
/// It is a body, with its pose.
pub const JOSTLE_SEEN_BODY: jostle_seen = 0;
/// The region's area is less than min_area.
pub const JOSTLE_SEEN_TOO_SMALL: jostle_seen = 1;
/// The region reaches the image's border.
pub const JOSTLE_SEEN_AT_BORDER: jostle_seen = 2;
/// No pixel of the region has a height.
pub const JOSTLE_SEEN_NO_HEIGHT: jostle_seen = 3;
/// The region's outline has no simple polygon within the tolerance.
pub const JOSTLE_SEEN_NO_OUTLINE: jostle_seen = 4;
/// No region fits the known body.
pub const JOSTLE_SEEN_NOWHERE: jostle_seen = 5;

/// A region of an image and its body. Frozen: never changes.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct jostle_seen_body {
    /// Zero where the region became no body.
    pub body: jostle_body,
    /// Where the body is; means something for JOSTLE_SEEN_BODY only.
    pub pose: jostle_pose2,
    /// In the image; 0 for a known body that was not seen.
    pub label: u32,
    pub seen: jostle_seen,
    /// How far the region's outline is from the body's, pixels: root mean square. About 0.3 for clean images.
    pub deviation: f64,
    /// Pixels of holes of the region, which were filled.
    pub hole_pixels: u32,
    /// Pixels of the label apart from the region, which were dropped.
    pub dropped_pixels: u32,
}

/// Sets every field to its default; `size` is sizeof(jostle_camera_image) as the caller was compiled.
/// jostle_camera_image_default() in this header does it for you.
///
/// Thread: any.
/// RT: yes.
/// Nullable: none.
/// Owns: the caller.
/// Errors: ARGUMENT (null, a size that no version has).
#[unsafe(no_mangle)]
pub unsafe extern "C" fn jostle_camera_image_init(image: *mut jostle_camera_image, size: usize) -> jostle_status {
    // SAFETY: the caller promises `size` writable bytes.
    guard("jostle_camera_image_init", |_| unsafe { init_sized(image, "image", size) })
}

/// Sets every field to its default; `size` is sizeof(jostle_image_options) as the caller was compiled.
/// jostle_image_options_default() in this header does it for you.
///
/// Thread: any.
/// RT: yes.
/// Nullable: none.
/// Owns: the caller.
/// Errors: ARGUMENT (null, a size that no version has).
#[unsafe(no_mangle)]
pub unsafe extern "C" fn jostle_image_options_init(options: *mut jostle_image_options, size: usize) -> jostle_status {
    // SAFETY: the caller promises `size` writable bytes.
    guard("jostle_image_options_init", |_| unsafe { init_sized(options, "options", size) })
}

enum Segments<'a> {
    Labels(Image<'a, u8>),
    Masks(Vec<Image<'a, u8>>),
}

struct Given<'a> {
    segments: Segments<'a>,
    heights: Option<Image<'a, f32>>,
    map: PixelMap,
    shapes: ShapeOptions,
    matching: MatchOptions,
}

/// # Safety
/// The pointers of the image point to what its sizes say and do not change while the result is used.
unsafe fn read_given<'a>(
    image: *const jostle_camera_image,
    options: *const jostle_image_options,
) -> Outcome<Given<'a>> {
    // SAFETY: as promised by the caller.
    let (image, given) = unsafe { (read_sized(image, "image")?, read_sized_or_default(options, "options")?) };
    for (field, side) in [("image.rows", image.rows), ("image.cols", image.cols)] {
        if !(1..=MAX_SIDE).contains(&side) {
            return Err(Failure::argument(field, format!("is {side}; it must lie in 1 to {MAX_SIDE}")));
        }
    }
    // SAFETY: as promised by the caller.
    let segments = unsafe { read_segments(&image) }?;
    let heights = match image.heights.is_null() {
        true => None,
        // SAFETY: as promised by the caller.
        false => Some(unsafe { view(image.heights, &image, image.height_stride, "image.heights") }?),
    };
    let mut shapes = ShapeOptions {
        tolerance: given.tolerance,
        min_area: given.min_area,
        height_quantile: given.height_quantile,
        discs: boolean(given.discs, "options.discs")?,
        at_border: match given.at_border {
            JOSTLE_BORDER_KEEP => AtBorder::Keep,
            JOSTLE_BORDER_SKIP => AtBorder::Skip,
            JOSTLE_BORDER_REFUSE => AtBorder::Refuse,
            other => {
                return Err(Failure::argument(
                    "options.at_border",
                    format!("is {other}; it must be one of the JOSTLE_BORDER_ values"),
                ));
            }
        },
        body: BodyDef::new(Shape::Disc { radius: 1.0 }),
    };
    (shapes.body.height, shapes.body.mass, shapes.body.friction) = (given.height, given.mass, given.friction);
    shapes.validate().map_err(|error| match error {
        crate::Error::Argument { field, reason } => {
            Failure::argument(&format!("options.{}", field.trim_start_matches("body.")), reason)
        }
        other => other.into(),
    })?;
    let matching = MatchOptions { greatest_cost: given.greatest_cost };
    crate::error::check_range("options.greatest_cost", given.greatest_cost, 0.0..=1e6)?;
    Ok(Given { segments, heights, map: read_map(&image.map, "image.map")?, shapes, matching })
}

/// # Safety
/// The pointers of the image point to what its sizes say and do not change while the result is used.
unsafe fn read_segments<'a>(image: &jostle_camera_image) -> Outcome<Segments<'a>> {
    const MOST: usize = 255;
    if image.masks.is_null() {
        if image.labels.is_null() {
            return Err(Failure::argument("image.labels", "is null, and there are no masks"));
        }
        // SAFETY: as promised by the caller.
        return Ok(Segments::Labels(unsafe { view(image.labels, image, image.label_stride, "image.labels") }?));
    }
    if !image.labels.is_null() {
        return Err(Failure::argument("image.masks", "are given beside labels; leave one of them null"));
    }
    if !(1..=MOST).contains(&image.mask_count) {
        return Err(Failure::argument(
            "image.mask_count",
            format!("is {}; it must lie in 1..={MOST}", image.mask_count),
        ));
    }
    let (length, _) = layout(image.masks, image.rows, image.cols, image.mask_stride, "image.masks")?;
    let plane = image.mask_plane_stride;
    if plane < length || plane > isize::MAX as usize / (2 * MOST) {
        return Err(Failure::argument("image.mask_plane_stride", format!("is {plane} bytes; a mask has {length}")));
    }
    (0..image.mask_count)
        // SAFETY: as promised by the caller; the offset is a possible one.
        .map(|k| unsafe { view(image.masks.add(k * plane), image, image.mask_stride, "image.masks") })
        .collect::<Outcome<Vec<_>>>()
        .map(Segments::Masks)
}

/// # Safety
/// `pixels` points to as many readable rows as the image has.
unsafe fn view<'a, T>(
    pixels: *const T,
    image: &jostle_camera_image,
    row_stride: usize,
    field: &str,
) -> Outcome<Image<'a, T>> {
    let (length, stride) = layout(pixels, image.rows, image.cols, row_stride, field)?;
    // SAFETY: not null, aligned, of a possible size, and readable by the caller's promise.
    let data = unsafe { std::slice::from_raw_parts(pixels, length) };
    Ok(Image::new(data, image.rows, image.cols, stride)?)
}

fn count(pixels: usize) -> u32 {
    u32::try_from(pixels).unwrap_or(u32::MAX)
}

/// Adds the bodies that an image shows, which need not be known: each label becomes a body with a simplified outline (a
/// polygon or a disc, its frame at the centroid), the height that the image says and the name "label N". What became of
/// each label goes to `buffer`, by label. A null buffer of capacity 0 asks for the count and adds nothing.
///
/// Of a label in several parts the largest is taken; holes are filled. Bodies that overlap, as they may in an unclean
/// image, are found by jostle_scene_check.
///
/// Thread: exclusive use of scene.
/// RT: no.
/// Nullable: options (takes the defaults), buffer (with capacity 0).
/// Owns: the pixels are not kept; the caller owns the buffer.
/// Errors: ARGUMENT (null, a field of image or options: the message names it, more bodies than a scene holds, a label at
/// the border that is refused), HANDLE, BUSY, BUFFER (count was written), POISONED, ABI. On failure the scene is
/// unchanged.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn jostle_scene_add_image(
    scene: *mut jostle_scene,
    image: *const jostle_camera_image,
    options: *const jostle_image_options,
    buffer: *mut jostle_seen_body,
    capacity: usize,
    count: *mut usize,
) -> jostle_status {
    with_mut("jostle_scene_add_image", scene, |content| {
        if count.is_null() {
            return Err(Failure::null("count"));
        }
        // SAFETY: the caller promises an image that keeps its promises.
        let given = unsafe { read_given(image, options) }?;
        let (mut finder, heights) = (ShapeFinder::new(), given.heights.as_ref());
        let shapes = match &given.segments {
            Segments::Labels(labels) => finder.labels(labels, heights, &given.map, &given.shapes),
            Segments::Masks(masks) => finder.masks(masks, heights, &given.map, &given.shapes),
        }
        .map_err(|error| error.within("image"))?;
        let mut whole = content.clone();
        let mut seen = Vec::with_capacity(shapes.bodies.len() + shapes.skipped.len());
        for found in &shapes.bodies {
            seen.push(jostle_seen_body {
                body: whole.add(found.def.clone(), found.pose, &format!("image.label {}", found.label))?,
                pose: found.pose.into(),
                label: found.label,
                seen: JOSTLE_SEEN_BODY,
                deviation: found.deviation[1],
                hole_pixels: self::count(found.hole_pixels),
                dropped_pixels: self::count(found.dropped_pixels),
            });
        }
        seen.extend(shapes.skipped.iter().map(|skipped| jostle_seen_body {
            label: skipped.label,
            seen: match skipped.reason {
                SkipReason::TooSmall => JOSTLE_SEEN_TOO_SMALL,
                SkipReason::AtBorder => JOSTLE_SEEN_AT_BORDER,
                SkipReason::NoHeight => JOSTLE_SEEN_NO_HEIGHT,
                SkipReason::NoOutline => JOSTLE_SEEN_NO_OUTLINE,
            },
            ..NOWHERE
        }));
        seen.sort_by_key(|entry| entry.label);
        // SAFETY: the caller promises room for `capacity` values.
        unsafe { fill(buffer, capacity, count, &seen) }?;
        if !buffer.is_null() {
            *content = whole;
        }
        Ok(())
    })
}

const NOWHERE: jostle_seen_body = jostle_seen_body {
    body: jostle_body { id: 0 },
    pose: jostle_pose2 { p: jostle_vec2 { x: 0.0, y: 0.0 }, theta: 0.0 },
    label: 0,
    seen: JOSTLE_SEEN_NOWHERE,
    deviation: 0.0,
    hole_pixels: 0,
    dropped_pixels: 0,
};

/// Finds the bodies of the scene, whose shapes are known, in an image whose labels say nothing of which is which: one
/// entry for each body that is present, in the order of jostle_scene_poses, with its label and pose, or
/// JOSTLE_SEEN_NOWHERE. The scene stays as it is; give the poses to jostle_scene_update. Of shapes that look the same
/// from several sides any of the headings may come.
///
/// Thread: shared use of scene.
/// RT: no.
/// Nullable: options (takes the defaults), buffer (with capacity 0: asks for the count).
/// Owns: the pixels are not kept; the caller owns the buffer.
/// Errors: ARGUMENT (null, a field of image or options: the message names it, a scene without bodies), HANDLE, BUSY,
/// BUFFER (count was written), POISONED, ABI.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn jostle_scene_match_image(
    scene: *const jostle_scene,
    image: *const jostle_camera_image,
    options: *const jostle_image_options,
    buffer: *mut jostle_seen_body,
    capacity: usize,
    count: *mut usize,
) -> jostle_status {
    with("jostle_scene_match_image", scene, |content| {
        if count.is_null() {
            return Err(Failure::null("count"));
        }
        // SAFETY: the caller promises an image that keeps its promises.
        let given = unsafe { read_given(image, options) }?;
        let (model, state) = (content.model()?, content.state());
        let known: Vec<(usize, Pose2)> = state.iter().collect();
        let mut finder = RegionFinder::new();
        let mut regions = match &given.segments {
            Segments::Labels(labels) => finder.labels(labels, &given.map)?,
            Segments::Masks(masks) => {
                let mut regions = Vec::with_capacity(masks.len());
                for (label, mask) in (1..).zip(masks) {
                    if let Some(mut region) = finder.mask(mask, &given.map)? {
                        region.label = label;
                        regions.push(region);
                    }
                }
                regions
            }
        };
        regions.retain(|region| region.area >= given.shapes.min_area);
        let shapes = known.iter().map(|&(index, _)| &model.body(index).footprint);
        let matches = Matcher::new(shapes, given.matching)?.assign(&regions);
        let seen: Vec<jostle_seen_body> = known
            .iter()
            .zip(&matches)
            .map(|(&(index, _), found)| match found {
                None => jostle_seen_body { body: content.id(index), ..NOWHERE },
                Some((region, found)) => jostle_seen_body {
                    body: content.id(index),
                    pose: found.pose.into(),
                    label: regions[*region].label,
                    seen: JOSTLE_SEEN_BODY,
                    deviation: found.rms,
                    hole_pixels: self::count(regions[*region].hole_pixels),
                    dropped_pixels: self::count(regions[*region].dropped_pixels),
                },
            })
            .collect();
        // SAFETY: the caller promises room for `capacity` values.
        unsafe { fill(buffer, capacity, count, &seen) }
    })
}
