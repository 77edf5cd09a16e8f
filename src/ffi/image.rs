//! Images of scenes: what an orthographic camera above the table sees.

use super::abi::{jostle_body, jostle_pose2, jostle_vec2, out, pose, read};
use super::guard::guard;
use super::scene::{Content, jostle_scene, with};
use super::status::{Failure, Outcome, jostle_status};
use crate::scene::Scene;
use crate::vision::{Frame, ImageMut, MAX_SIDE, PixelMap, Rasteriser};

/// Where an image lies over the table. Columns run along +x of the image's frame, rows along +y (row 0 has the least y),
/// the frame's origin is the middle of the image: pixel (row, column) has its centre at x = (column + 1/2 - cols/2) pixel,
/// y = (row + 1/2 - rows/2) pixel. Frozen: never changes.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct jostle_image_frame {
    /// Of the image's middle in the world.
    pub pose: jostle_pose2,
    /// Side of a pixel, metres.
    pub pixel: f64,
    /// At most 16384.
    pub rows: usize,
    /// At most 16384.
    pub cols: usize,
}

/// From the pixels of a camera's image to the table: pixel (row, column) has its centre at origin + column `column` +
/// row `row`. Any axes will do, turned and mirrored ones too, if they span pixels that are about square. Frozen: never
/// changes.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct jostle_pixel_map {
    /// World position of the centre of the first pixel of the first row.
    pub origin: jostle_vec2,
    /// From a pixel to the next one in its row, metres.
    pub column: jostle_vec2,
    /// From a row to the next, metres.
    pub row: jostle_vec2,
}

pub(super) fn read_map(map: &jostle_pixel_map, field: &str) -> Outcome<PixelMap> {
    let jostle_pixel_map { origin, column, row } = map;
    let map = PixelMap { x: [column.x, row.x, origin.x], y: [column.y, row.y, origin.y] };
    map.validate().map_err(|error| match error {
        crate::Error::Argument { reason, .. } => Failure::argument(field, reason),
        other => other.into(),
    })?;
    Ok(map)
}

/// # Safety
/// `frame` is null or readable.
unsafe fn read_frame(frame: *const jostle_image_frame) -> Outcome<Frame> {
    // SAFETY: as promised by the caller.
    let given = unsafe { read(frame, "frame") }?;
    let frame = Frame::new(pose(given.pose, "frame.pose")?, given.pixel, given.rows, given.cols);
    frame.validate()?;
    Ok(frame)
}

/// The length in elements of rows that lie `row_stride` bytes apart, and the stride in elements.
pub(super) fn layout<T>(
    pointer: *const T,
    rows: usize,
    cols: usize,
    row_stride: usize,
    field: &str,
) -> Outcome<(usize, usize)> {
    let size = size_of::<T>();
    if !pointer.is_aligned() || !row_stride.is_multiple_of(size) {
        return Err(Failure::argument(field, format!("pixels and row_stride must be aligned to {size} bytes")));
    }
    let stride = row_stride / size;
    if stride < cols {
        return Err(Failure::argument(
            field,
            format!("row_stride is {row_stride} bytes; a row has {cols} pixels of {size}"),
        ));
    }
    // Rows and columns are 16384 at most.
    if stride > isize::MAX as usize / size / (2 * MAX_SIDE) {
        return Err(Failure::argument(field, format!("row_stride is {row_stride} bytes, which is impossible")));
    }
    Ok(((rows.max(1) - 1) * stride + cols, stride))
}

/// Paints into the caller's pixels.
///
/// # Safety
/// `frame` is null or readable; `pixels` is null or points to as many writable rows as the frame has.
unsafe fn paint<T: Copy>(
    content: &Content,
    frame: *const jostle_image_frame,
    pixels: *mut T,
    row_stride: usize,
    paint: impl FnOnce(&mut Rasteriser, &Scene, &Frame, &mut ImageMut<T>) -> crate::Result<()>,
) -> Outcome {
    if pixels.is_null() {
        return Err(Failure::null("pixels"));
    }
    // SAFETY: as promised by the caller.
    let frame = unsafe { read_frame(frame) }?;
    let model = content.model()?;
    let (length, stride) = layout(pixels, frame.rows, frame.cols, row_stride, "pixels")?;
    // SAFETY: not null, aligned, of a possible size, and writable by the caller's promise.
    let data = unsafe { std::slice::from_raw_parts_mut(pixels, length) };
    let mut image = ImageMut::new(data, frame.rows, frame.cols, stride)?;
    Ok(paint(&mut Rasteriser::new(), &model, &frame, &mut image)?)
}

/// The frame of a square image about the centre of a body's footprint, its x axis at `heading` (radians) in the world:
/// `side` pixels of `pixel` metres.
///
/// Thread: shared use of scene.
/// RT: no.
/// Nullable: none.
/// Owns: nothing.
/// Errors: ARGUMENT (null, zero body, a value out of range), HANDLE, BUSY, NOT_FOUND, POISONED.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn jostle_scene_frame_around(
    scene: *const jostle_scene,
    body: jostle_body,
    heading: f64,
    pixel: f64,
    side: usize,
    frame: *mut jostle_image_frame,
) -> jostle_status {
    with("jostle_scene_frame_around", scene, |content| {
        // SAFETY: the caller promises a writable place.
        let out = unsafe { out(frame, "frame") }?;
        let index = content.index(body, "body")?;
        let model = content.model()?;
        let found = Frame::around(&model, &content.state(), index, heading, pixel, side)?;
        found.validate().map_err(|error| match error {
            crate::Error::Argument { field, reason } => Failure::argument(
                match field.as_str() {
                    "frame.pixel" => "pixel",
                    field if field.starts_with("frame.pose") => "heading",
                    _ => "side",
                },
                reason,
            ),
            other => other.into(),
        })?;
        out.set(jostle_image_frame { pose: found.pose.into(), pixel, rows: side, cols: side });
        Ok(())
    })
}

/// The map of an image of the library: what makes of its pixels a camera's.
///
/// Thread: any.
/// RT: yes.
/// Nullable: none.
/// Owns: `frame` is copied.
/// Errors: ARGUMENT (null, a field of frame out of range).
#[unsafe(no_mangle)]
pub unsafe extern "C" fn jostle_image_frame_map(
    frame: *const jostle_image_frame,
    map: *mut jostle_pixel_map,
) -> jostle_status {
    guard("jostle_image_frame_map", |_| {
        // SAFETY: the caller promises a frame and a writable place.
        let (out, frame) = unsafe { (out(map, "map")?, read_frame(frame)?) };
        let PixelMap { x, y } = PixelMap::from(&frame);
        let vector = |i: usize| jostle_vec2 { x: x[i], y: y[i] };
        out.set(jostle_pixel_map { column: vector(0), row: vector(1), origin: vector(2) });
        Ok(())
    })
}

/// Writes to each pixel which body it shows: 0 is the table, k + 1 the body that jostle_scene_poses lists at k. A pixel
/// shows a body if its centre lies in the body's footprint; where footprints overlap the higher body shows, of equally
/// high ones the earlier. Rows begin `row_stride` bytes apart; what lies between them is left as it is.
///
/// Thread: shared use of scene.
/// RT: no.
/// Nullable: none.
/// Owns: the caller owns the pixels.
/// Errors: ARGUMENT (null, frame or row_stride out of range, a scene without bodies or with more than 255), HANDLE, BUSY,
/// POISONED.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn jostle_scene_label_image(
    scene: *const jostle_scene,
    frame: *const jostle_image_frame,
    pixels: *mut u8,
    row_stride: usize,
) -> jostle_status {
    with("jostle_scene_label_image", scene, |content| {
        // SAFETY: the caller promises a frame and pixels.
        unsafe {
            paint(content, frame, pixels, row_stride, |rasteriser, model, frame, image| {
                rasteriser.labels(model, &content.state(), frame, image)
            })
        }
    })
}

/// Writes to each pixel how high what it shows reaches above the table, metres; 0 is the table. See
/// jostle_scene_label_image.
///
/// Thread: shared use of scene.
/// RT: no.
/// Nullable: none.
/// Owns: the caller owns the pixels.
/// Errors: ARGUMENT (null, frame or row_stride out of range, a scene without bodies), HANDLE, BUSY, POISONED.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn jostle_scene_height_image(
    scene: *const jostle_scene,
    frame: *const jostle_image_frame,
    pixels: *mut f32,
    row_stride: usize,
) -> jostle_status {
    with("jostle_scene_height_image", scene, |content| {
        // SAFETY: the caller promises a frame and pixels.
        unsafe {
            paint(content, frame, pixels, row_stride, |rasteriser, model, frame, image| {
                rasteriser.heights(model, &content.state(), frame, image)
            })
        }
    })
}

/// Writes 1 to each pixel that shows the body, 0 to all others. See jostle_scene_label_image.
///
/// Thread: shared use of scene.
/// RT: no.
/// Nullable: none.
/// Owns: the caller owns the pixels.
/// Errors: ARGUMENT (null, zero body, frame or row_stride out of range), HANDLE, BUSY, NOT_FOUND, POISONED.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn jostle_scene_mask_image(
    scene: *const jostle_scene,
    body: jostle_body,
    frame: *const jostle_image_frame,
    pixels: *mut u8,
    row_stride: usize,
) -> jostle_status {
    with("jostle_scene_mask_image", scene, |content| {
        let index = content.index(body, "body")?;
        // SAFETY: the caller promises a frame and pixels.
        unsafe {
            paint(content, frame, pixels, row_stride, |rasteriser, model, frame, image| {
                rasteriser.mask(model, &content.state(), index, frame, image)
            })
        }
    })
}
