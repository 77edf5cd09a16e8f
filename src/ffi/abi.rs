//! Crossing the boundary: sized structs, strings, arrays and outputs.

use std::ffi::{CStr, CString, c_char};

use super::handle::{self, Object};
use super::status::{Failure, JOSTLE_ERROR_ABI, JOSTLE_ERROR_BUFFER, Outcome};
use crate::error::Error;
use crate::geom::Pose2;
use crate::scene::check_pose;

/// A point or a vector in the plane, metres. Frozen: never changes.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct jostle_vec2 {
    pub x: f64,
    pub y: f64,
}

/// Position (metres) and heading (radians, counter-clockwise from +x) of a body. Frozen: never changes.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct jostle_pose2 {
    pub p: jostle_vec2,
    pub theta: f64,
}

/// Names a body of a scene. Plain data: copy and store it as you like; it is valid in the scene that gave it and in
/// that scene's clones, plans and simulators. Zero is no body. Frozen: never changes.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub struct jostle_body {
    pub id: u64,
}

/// Where a body is, or that it is not there. Frozen: never changes.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct jostle_body_pose {
    pub body: jostle_body,
    pub pose: jostle_pose2,
    /// 1 if the body is there, 0 if it was taken away (then `pose` is kept but means nothing).
    pub present: u32,
    /// 0.
    pub reserved: u32,
}

impl From<jostle_pose2> for Pose2 {
    fn from(pose: jostle_pose2) -> Pose2 {
        Pose2::new(pose.p.x, pose.p.y, pose.theta)
    }
}

impl From<Pose2> for jostle_pose2 {
    fn from(pose: Pose2) -> jostle_pose2 {
        jostle_pose2 { p: jostle_vec2 { x: pose.x, y: pose.y }, theta: pose.theta }
    }
}

impl From<[f64; 2]> for jostle_vec2 {
    fn from([x, y]: [f64; 2]) -> jostle_vec2 {
        jostle_vec2 { x, y }
    }
}

/// A struct whose first field is `uint32_t struct_size`, set by the caller to the size that the caller knows.
///
/// # Safety
/// `repr(C)`, the first field is `struct_size: u32`, every bit pattern of every field is a value, and there is no
/// padding (a test compares the sizes of fields and struct), so that every size of a version ends with a field.
pub(super) unsafe trait Sized32: Copy {
    /// The C name.
    const NAME: &'static str;
    /// The size of the first version: less cannot be a caller of this API.
    const FIRST_SIZE: usize;
    /// All defaults; those of appended fields keep the behaviour from before they existed.
    fn defaults() -> Self;
}

/// No struct grows beyond this; a larger size is a struct that was never initialised.
const GREATEST_SIZE: usize = 4096;

unsafe fn size_of_callers<T: Sized32>(pointer: *const T, field: &str) -> Outcome<usize> {
    if pointer.is_null() {
        return Err(Failure::null(field));
    }
    aligned(pointer, field)?;
    // SAFETY: not null and aligned; the caller says that it points to a struct of at least its first field.
    let size = unsafe { pointer.cast::<u32>().read() } as usize;
    if size == 0 || size > GREATEST_SIZE {
        let name = T::NAME;
        return Err(Failure::argument(
            &format!("{field}.struct_size"),
            format!("is {size}: the struct is not initialised; begin with {name}_default() or {name}_init()"),
        ));
    }
    if size < T::FIRST_SIZE || !size.is_multiple_of(align_of::<T>()) {
        return Err(Failure::argument(
            &format!("{field}.struct_size"),
            format!("is {size}; no version of {} has this size (the first has {})", T::NAME, T::FIRST_SIZE),
        ));
    }
    Ok(size)
}

/// Reads a caller's struct of any version: fields it does not know get their defaults, fields this library does not
/// know must be zero.
///
/// # Safety
/// `pointer` is null or points to as many readable bytes as its `struct_size` says.
pub(super) unsafe fn read_sized<T: Sized32>(pointer: *const T, field: &str) -> Outcome<T> {
    // SAFETY: as promised by the caller.
    let size = unsafe { size_of_callers(pointer, field) }?;
    let known = size.min(size_of::<T>());
    let mut value = T::defaults();
    // SAFETY: `known` bytes are readable by the caller's promise and fit into `value`; every bit pattern is a value.
    unsafe { std::ptr::copy_nonoverlapping(pointer.cast::<u8>(), (&raw mut value).cast::<u8>(), known) };
    for offset in known..size {
        // SAFETY: within the caller's struct.
        if unsafe { pointer.cast::<u8>().add(offset).read() } != 0 {
            return Err(Failure::new(
                JOSTLE_ERROR_ABI,
                format!(
                    "{field}: byte {offset} is set, but this library's {} has {} bytes; use the header of this library",
                    T::NAME,
                    size_of::<T>()
                ),
            ));
        }
    }
    Ok(value)
}

/// Like [`read_sized`]; all defaults if the pointer is null.
///
/// # Safety
/// As for [`read_sized`].
pub(super) unsafe fn read_sized_or_default<T: Sized32>(pointer: *const T, field: &str) -> Outcome<T> {
    if pointer.is_null() {
        return Ok(T::defaults());
    }
    // SAFETY: as promised by the caller.
    unsafe { read_sized(pointer, field) }
}

/// Writes a result into the caller's struct of any version. `value.struct_size` is replaced by the caller's.
///
/// # Safety
/// `pointer` is null or points to as many writable bytes as its `struct_size` says.
pub(super) unsafe fn write_sized<T: Sized32>(pointer: *mut T, field: &str, value: &T) -> Outcome {
    // SAFETY: as promised by the caller.
    let size = unsafe { size_of_callers(pointer, field) }?;
    // SAFETY: `size` bytes are writable.
    unsafe { fill_sized(pointer, size, value) };
    Ok(())
}

/// # Safety
/// `pointer` is aligned and points to `size >= 4` writable bytes.
unsafe fn fill_sized<T: Sized32>(pointer: *mut T, size: usize, value: &T) {
    let known = size.min(size_of::<T>());
    let bytes = pointer.cast::<u8>();
    // SAFETY: `known` does not exceed either struct, the rest lies within the caller's.
    unsafe {
        std::ptr::copy_nonoverlapping((&raw const *value).cast::<u8>(), bytes, known);
        std::ptr::write_bytes(bytes.add(known), 0, size - known);
        pointer.cast::<u32>().write(size as u32);
    }
}

/// The body of every `_init` function: defaults in the first `size` bytes.
///
/// # Safety
/// `pointer` is null or points to `size` writable bytes.
pub(super) unsafe fn init_sized<T: Sized32>(pointer: *mut T, field: &str, size: usize) -> Outcome {
    if pointer.is_null() {
        return Err(Failure::null(field));
    }
    aligned(pointer, field)?;
    if !(T::FIRST_SIZE..=GREATEST_SIZE).contains(&size) || !size.is_multiple_of(align_of::<T>()) {
        return Err(Failure::argument("size", format!("is {size}; pass sizeof of {}", T::NAME)));
    }
    // SAFETY: `size` bytes are writable by the caller's promise.
    unsafe { fill_sized(pointer, size, &T::defaults()) };
    Ok(())
}

fn aligned<T>(pointer: *const T, field: &str) -> Outcome {
    if pointer.is_aligned() {
        Ok(())
    } else {
        Err(Failure::argument(field, format!("is not aligned to {} bytes", align_of::<T>())))
    }
}

/// A place for a plain result.
pub(super) struct Out<T>(*mut T);

impl<T> Out<T> {
    pub fn set(self, value: T) {
        // SAFETY: `out` checked it, and its caller promised that it is writable during the call.
        unsafe { self.0.write(value) };
    }
}

/// # Safety
/// `pointer` is null or writable until the call returns.
pub(super) unsafe fn out<T>(pointer: *mut T, field: &str) -> Outcome<Out<T>> {
    if pointer.is_null() {
        return Err(Failure::null(field));
    }
    aligned(pointer, field)?;
    Ok(Out(pointer))
}

/// A place for a new handle; null until [`OutHandle::give`].
pub(super) struct OutHandle<H>(*mut *mut H);

impl<H> OutHandle<H> {
    /// Gives the object a handle and hands it to the caller.
    pub fn give<T: Object<Handle = H>>(self, object: T) -> Outcome {
        let handle = handle::insert(object)?;
        // SAFETY: `out_handle` checked it, and its caller promised that it is writable during the call.
        unsafe { self.0.write(handle) };
        Ok(())
    }
}

/// # Safety
/// `pointer` is null or writable until the call returns.
pub(super) unsafe fn out_handle<H>(pointer: *mut *mut H, field: &str) -> Outcome<OutHandle<H>> {
    // SAFETY: as promised by the caller.
    let Out(pointer) = unsafe { out(pointer, field) }?;
    // SAFETY: checked, and writable by the caller's promise.
    unsafe { pointer.write(std::ptr::null_mut()) };
    Ok(OutHandle(pointer))
}

/// Copies `values` to the caller's buffer and says how many there are. Too small a buffer gets the count alone; a null
/// buffer of capacity 0 asks for it.
///
/// # Safety
/// `buffer` is null or has room for `capacity` values; `count` is null or writable.
pub(super) unsafe fn fill<T: Copy>(buffer: *mut T, capacity: usize, count: *mut usize, values: &[T]) -> Outcome {
    // SAFETY: as promised by the caller.
    let count = unsafe { out(count, "count") }?;
    if buffer.is_null() && capacity > 0 {
        return Err(Failure::argument("buffer", format!("is null, but capacity is {capacity}")));
    }
    aligned(buffer, "buffer")?;
    count.set(values.len());
    if buffer.is_null() {
        return Ok(());
    }
    if values.len() > capacity {
        return Err(Failure::new(JOSTLE_ERROR_BUFFER, format!("capacity: is {capacity}; {} are needed", values.len())));
    }
    // SAFETY: the buffer has room for `capacity` values, at least as many as there are.
    unsafe { std::ptr::copy_nonoverlapping(values.as_ptr(), buffer, values.len()) };
    Ok(())
}

/// Copies text with its closing zero, which counts. See [`fill`].
///
/// # Safety
/// As for [`fill`].
pub(super) unsafe fn fill_text(buffer: *mut c_char, capacity: usize, count: *mut usize, text: &str) -> Outcome {
    let text = CString::new(text.replace('\0', "?")).unwrap_or_default();
    let chars: Vec<c_char> = text.as_bytes_with_nul().iter().map(|&byte| byte as c_char).collect();
    if count.is_null() {
        return Err(Failure::null("length"));
    }
    // SAFETY: as promised by the caller.
    unsafe { fill(buffer, capacity, count, &chars) }
}

/// A caller's array; null is allowed where the count is 0.
///
/// # Safety
/// `pointer` points to `count` values that do not change while the result is used.
pub(super) unsafe fn slice<'a, T>(pointer: *const T, count: usize, field: &str) -> Outcome<&'a [T]> {
    if count == 0 {
        return Ok(&[]);
    }
    if pointer.is_null() {
        return Err(Failure::argument(field, format!("is null, but its count is {count}")));
    }
    aligned(pointer, field)?;
    if count > isize::MAX as usize / size_of::<T>().max(1) {
        return Err(Failure::argument(field, format!("its count {count} is impossible")));
    }
    // SAFETY: not null, aligned, of a possible size, and readable by the caller's promise.
    Ok(unsafe { std::slice::from_raw_parts(pointer, count) })
}

/// A caller's text.
///
/// # Safety
/// `pointer` is null or points to text that ends with a zero and does not change while the result is used.
pub(super) unsafe fn text<'a>(pointer: *const c_char, field: &str) -> Outcome<&'a str> {
    if pointer.is_null() {
        return Err(Failure::null(field));
    }
    // SAFETY: not null, ended by a zero by the caller's promise.
    unsafe { CStr::from_ptr(pointer) }.to_str().map_err(|_| Failure::argument(field, "is not UTF-8"))
}

/// A caller's text that may be absent.
///
/// # Safety
/// As for [`text`].
pub(super) unsafe fn optional_text<'a>(pointer: *const c_char, field: &str) -> Outcome<Option<&'a str>> {
    if pointer.is_null() {
        return Ok(None);
    }
    // SAFETY: as promised by the caller.
    unsafe { text(pointer, field) }.map(Some)
}

/// A caller's plain struct.
///
/// # Safety
/// `pointer` is null or readable, and every bit pattern of `T` is a value.
pub(super) unsafe fn read<T: Copy>(pointer: *const T, field: &str) -> Outcome<T> {
    if pointer.is_null() {
        return Err(Failure::null(field));
    }
    aligned(pointer, field)?;
    // SAFETY: not null, aligned, readable by the caller's promise.
    Ok(unsafe { pointer.read() })
}

/// A caller's boolean: 0 or 1, since anything else is more likely a mistake than a yes.
pub(super) fn boolean(value: u32, field: &str) -> Outcome<bool> {
    match value {
        0 => Ok(false),
        1 => Ok(true),
        _ => Err(Failure::argument(field, format!("is {value}; it must be 0 or 1"))),
    }
}

/// A caller's pose, as scenes may have it.
pub(super) fn pose(value: jostle_pose2, field: &str) -> Outcome<Pose2> {
    let pose = Pose2::from(value);
    check_pose(field, &pose).map_err(c_pose)?;
    Ok(pose)
}

/// Puts the C names of a pose's position in place of the library's.
pub(super) fn c_pose(error: Error) -> Error {
    match error {
        Error::Argument { field, reason } => {
            let c = ["x", "y"].into_iter().find_map(|axis| {
                Some(format!("{}.p.{axis}", field.strip_suffix(&format!(".{axis}")).filter(|f| f.ends_with("pose"))?))
            });
            Error::Argument { field: c.unwrap_or(field), reason }
        }
        other => other,
    }
}

#[cfg(test)]
mod tests {
    use super::super::status::JOSTLE_ERROR_ARGUMENT;
    use super::*;

    #[repr(C)]
    #[derive(Debug, Clone, Copy, PartialEq)]
    struct Old {
        struct_size: u32,
        a: u32,
    }
    #[repr(C, align(8))]
    #[derive(Debug, Clone, Copy, PartialEq)]
    struct New {
        struct_size: u32,
        a: u32,
        b: f64,
    }
    // SAFETY: repr(C), struct_size first, no padding, all bit patterns are values.
    unsafe impl Sized32 for New {
        const NAME: &'static str = "thing";
        const FIRST_SIZE: usize = 8;
        fn defaults() -> Self {
            New { struct_size: 16, a: 1, b: 2.5 }
        }
    }
    #[repr(C, align(8))]
    struct Aligned<T>(T);

    #[test]
    fn an_older_struct_gets_defaults_and_its_neighbour_stays_whole() {
        let old = Aligned([Old { struct_size: 8, a: 7 }, Old { struct_size: 9999, a: 9999 }]);
        // SAFETY: `struct_size` is true.
        let new = unsafe { read_sized::<New>((&raw const old).cast(), "o") }.unwrap();
        assert_eq!((new.a, new.b), (7, 2.5));
        let mut pair = Aligned([Old { struct_size: 8, a: 0 }, Old { struct_size: 5, a: 6 }]);
        // SAFETY: 8 bytes are the first element.
        unsafe { init_sized::<New>((&raw mut pair).cast(), "o", 8) }.unwrap();
        assert_eq!(pair.0, [Old { struct_size: 8, a: 1 }, Old { struct_size: 5, a: 6 }]);
        // SAFETY: `struct_size` is true.
        unsafe { write_sized((&raw mut pair).cast(), "o", &New { struct_size: 0, a: 3, b: 4.0 }) }.unwrap();
        assert_eq!(pair.0, [Old { struct_size: 8, a: 3 }, Old { struct_size: 5, a: 6 }]);
    }

    #[test]
    fn a_newer_struct_passes_while_its_tail_is_zero() {
        let mut newer = Aligned([24u32, 7, 0, 0, 0, 0]);
        // SAFETY: `struct_size` is true, here and below.
        assert_eq!(unsafe { read_sized::<New>((&raw const newer).cast(), "o") }.unwrap().a, 7);
        newer.0[5] = 1 << 16;
        let failure = unsafe { read_sized::<New>((&raw const newer).cast(), "o") }.unwrap_err();
        assert_eq!(failure.status, JOSTLE_ERROR_ABI);
        assert!(failure.message.starts_with("o: byte 22 is set"), "{}", failure.message);
        unsafe { init_sized::<New>((&raw mut newer).cast(), "o", 24) }.unwrap();
        assert_eq!((newer.0[0], newer.0[1], newer.0[4], newer.0[5]), (24, 1, 0, 0));
    }

    #[test]
    fn sizes_that_no_version_has_are_refused_by_name() {
        for size in [0u32, 4, 12, 5000, u32::MAX] {
            let thing = Aligned([size, 0, 0, 0]);
            // SAFETY: only the size is read.
            let failure = unsafe { read_sized::<New>((&raw const thing).cast(), "o") }.unwrap_err();
            assert_eq!(failure.status, JOSTLE_ERROR_ARGUMENT);
            assert!(failure.message.starts_with("o.struct_size: is "), "{}", failure.message);
        }
    }

    #[test]
    fn a_short_buffer_gets_the_count_alone() {
        let (mut buffer, mut count) = ([9u32; 2], 0);
        // SAFETY: buffer and capacity agree, here and below.
        unsafe {
            assert_eq!(fill(buffer.as_mut_ptr(), 2, &mut count, &[1, 2, 3]).unwrap_err().status, JOSTLE_ERROR_BUFFER);
            assert_eq!((buffer, count), ([9, 9], 3));
            fill(std::ptr::null_mut(), 0, &mut count, &[1u32]).unwrap();
            assert_eq!(count, 1);
            assert!(fill(std::ptr::null_mut(), 1, &mut count, &[1u32]).is_err());
            fill(buffer.as_mut_ptr(), 2, &mut count, &[4]).unwrap();
            assert_eq!((buffer, count), ([4, 9], 1));
            let mut chars = [0 as c_char; 3];
            fill_text(chars.as_mut_ptr(), 3, &mut count, "ab").unwrap();
            assert_eq!((chars.map(|c| c as u8), count), ([b'a', b'b', 0], 3));
        }
    }
}
