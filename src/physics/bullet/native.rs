//! The C interface to Bullet (`bindings/bullet/shim.h`) made safe. The only unsafe code of the engines.

use std::ffi::CStr;
use std::ptr::{self, NonNull};

use self::sys::jostle_bt_status as status;
use crate::error::{Error, Result};

/// The committed output of bindgen.
#[allow(non_camel_case_types, non_snake_case, non_upper_case_globals, dead_code, unused_imports, clippy::all)]
mod sys {
    include!(concat!(env!("CARGO_MANIFEST_DIR"), "/bindings/bullet/bindings.rs"));
}

pub(super) use self::sys::jostle_bt_box_def as BoxDef;
pub(super) use self::sys::jostle_bt_ground as ground;
pub(super) use self::sys::jostle_bt_motion as Motion;
pub(super) use self::sys::jostle_bt_settings as WorldSettings;
pub(super) use self::sys::jostle_bt_solver as solver;

/// Convex pieces as Bullet takes them: x, y, z of corner after corner, piece after piece, each number representable in
/// single precision (see `hull::rounded`).
#[derive(Debug, Clone, Default, PartialEq)]
pub(super) struct Pieces {
    pub points: Vec<f64>,
    pub sizes: Vec<u32>,
}

/// A body to be added to a world.
#[derive(Debug, Clone, Copy)]
pub(super) struct BodyDef<'a> {
    pub mass: f64,
    pub inertia: [f64; 3],
    pub friction: f64,
    pub rolling_friction: f64,
    pub spinning_friction: f64,
    pub position: [f64; 3],
    pub rotation: [f64; 4],
    pub pieces: &'a Pieces,
}

/// Refuses to go on if another build of Bullet stands in this process in the place of ours.
pub(super) fn check_library() -> Result<()> {
    let mut text = [0u8; 512];
    // SAFETY: the buffer has the size that is passed, and is written as a C string.
    let code = unsafe { sys::jostle_bt_check(text.as_mut_ptr().cast(), text.len() as u32) };
    if code == status::JOSTLE_BT_OK {
        return Ok(());
    }
    let found = CStr::from_bytes_until_nul(&text).map(|s| s.to_string_lossy()).unwrap_or_default();
    Err(Error::Unsupported(format!(
        "physics.engine: `bullet` needs Bullet in double precision, but this process has another build of it in its \
         place ({found}), with which every number would be wrong; do not link that one, or run this engine in a process \
         of its own"
    )))
}

fn check(code: status::Type) -> Result<()> {
    match code {
        status::JOSTLE_BT_OK => Ok(()),
        status::JOSTLE_BT_NO_MEMORY => Err(Error::Memory("Bullet ran out of memory".into())),
        code => Err(Error::Internal(format!("Bullet refused a call (status {code})"))),
    }
}

fn finite(motion: Motion) -> Result<Motion> {
    let mut numbers = motion.position.iter().chain(&motion.rotation).chain(&motion.linear).chain(&motion.angular);
    if !numbers.all(|v| v.is_finite()) {
        return Err(Error::Internal("Bullet gave a pose that is not finite".into()));
    }
    Ok(motion)
}

/// A world of Bullet's, with everything in it.
pub(super) struct World {
    handle: NonNull<sys::jostle_bt_world>,
    bodies: u32,
}

// SAFETY: a world refers to nothing but what it owns and is used by one thread at a time (`&mut` for what changes it).
unsafe impl Send for World {}

impl World {
    pub fn new(settings: &WorldSettings) -> Result<World> {
        let mut handle = ptr::null_mut();
        // SAFETY: both pointers are valid for the call.
        check(unsafe { sys::jostle_bt_world_new(settings, &mut handle) })?;
        let handle = NonNull::new(handle).ok_or_else(|| Error::Internal("Bullet gave no world".into()))?;
        Ok(World { handle, bodies: 0 })
    }

    pub fn add_body(&mut self, def: &BodyDef<'_>) -> Result<()> {
        let corners: u64 = def.pieces.sizes.iter().map(|n| u64::from(*n)).sum();
        if corners * 3 != def.pieces.points.len() as u64 {
            return Err(Error::Internal("a hull's points do not fit its pieces".into()));
        }
        let def = sys::jostle_bt_body_def {
            mass: def.mass,
            inertia: def.inertia,
            friction: def.friction,
            rolling_friction: def.rolling_friction,
            spinning_friction: def.spinning_friction,
            position: def.position,
            rotation: def.rotation,
            points: def.pieces.points.as_ptr(),
            piece_sizes: def.pieces.sizes.as_ptr(),
            piece_count: def.pieces.sizes.len() as u32,
        };
        // SAFETY: the arrays hold as many numbers as was checked above and outlive the call, which copies them.
        check(unsafe { sys::jostle_bt_add_body(self.handle.as_ptr(), &def) })?;
        self.bodies += 1;
        Ok(())
    }

    /// Adds a box that is moved from outside; boxes are numbered from 0.
    pub fn add_box(&mut self, def: &BoxDef) -> Result<()> {
        // SAFETY: the world is alive and the definition valid for the call.
        check(unsafe { sys::jostle_bt_add_box(self.handle.as_ptr(), def) })
    }

    pub fn place_bodies(&mut self) -> Result<()> {
        // SAFETY: the world is alive.
        check(unsafe { sys::jostle_bt_place_bodies(self.handle.as_ptr()) })
    }

    pub fn move_box(&mut self, index: u32, motion: &Motion) -> Result<()> {
        // SAFETY: the world is alive; the index is checked on the other side.
        check(unsafe { sys::jostle_bt_move_box(self.handle.as_ptr(), index, motion) })
    }

    pub fn remove_box(&mut self, index: u32) -> Result<()> {
        // SAFETY: as for `move_box`.
        check(unsafe { sys::jostle_bt_remove_box(self.handle.as_ptr(), index) })
    }

    pub fn step(&mut self) -> Result<()> {
        // SAFETY: the world is alive.
        check(unsafe { sys::jostle_bt_step(self.handle.as_ptr()) })
    }

    /// Where a body is and how it moves; an error if a number is not finite.
    pub fn body(&self, index: usize) -> Result<Motion> {
        let mut motion = Motion::default();
        // SAFETY: the world is alive, the index is checked on the other side, and the output is valid for the call.
        check(unsafe { sys::jostle_bt_body(self.handle.as_ptr(), index as u32, &mut motion) })?;
        finite(motion)
    }

    /// The same of a box.
    pub fn box_motion(&self, index: u32) -> Result<Motion> {
        let mut motion = Motion::default();
        // SAFETY: as for `body`.
        check(unsafe { sys::jostle_bt_box(self.handle.as_ptr(), index, &mut motion) })?;
        finite(motion)
    }

    /// Sets `touching[i]` for every body that a box touches (no farther apart than `within`, margins included) and adds
    /// the normal force of the last step to `force[i]`, newton. Both are as long as there are bodies.
    pub fn contacts(&self, index: u32, within: f64, touching: &mut [u8], force: &mut [f64]) -> Result<()> {
        let count = touching.len().min(force.len()) as u32;
        // SAFETY: the world is alive and no more than `count` elements of both arrays are written.
        check(unsafe {
            sys::jostle_bt_contacts(
                self.handle.as_ptr(),
                index,
                within,
                touching.as_mut_ptr(),
                force.as_mut_ptr(),
                count,
            )
        })
    }

    pub fn bodies(&self) -> usize {
        self.bodies as usize
    }
}

impl Drop for World {
    fn drop(&mut self) {
        // SAFETY: the handle was made by `jostle_bt_world_new` and is freed once.
        unsafe { sys::jostle_bt_world_free(self.handle.as_ptr()) }
    }
}

/// The corners of one piece as Bullet keeps them.
#[cfg(test)]
pub(super) fn hull(points: &[f64], margin: f64) -> Result<Vec<[f64; 3]>> {
    let mut out = vec![0.0; 3 * 256];
    let mut written = 0;
    // SAFETY: the arrays hold as many points as is said.
    check(unsafe {
        sys::jostle_bt_hull(points.as_ptr(), points.len() as u32 / 3, margin, out.as_mut_ptr(), 256, &mut written)
    })?;
    Ok(out.chunks(3).take(written as usize).map(|p| [p[0], p[1], p[2]]).collect())
}
