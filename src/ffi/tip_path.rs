//! How the robot moves the tip of its gripper in a push.

use super::abi::{Sized32, init_sized, jostle_vec2, read_sized, slice};
use super::guard::guard;
use super::scene::{jostle_scene, with_mut};
use super::status::{Failure, jostle_status};
use crate::scene::{Table, TipPath};

/// How the robot moves the tip when it is told to push: one of the JOSTLE_TIP_ values.
pub type jostle_tip = i32;
/// Straight from the commanded start to the commanded end, at the height that the engine has (the default).
pub const JOSTLE_TIP_STRAIGHT: jostle_tip = 0;
/// As a UR5e with its base in the origin does: the tip sinks on the way and lifts before it has arrived (docs/robot.md).
pub const JOSTLE_TIP_UR5E: jostle_tip = 1;
/// A path of the scene's own, which this struct does not hold: a scene that has one keeps it (jostle_scene_set_tip_path).
pub const JOSTLE_TIP_OWN: jostle_tip = 2;

/// How the tip's lower end goes along the straight line from a push's commanded start to its commanded end. Metres. The
/// engines "planar", "prism" and "bullet" follow it; a planner or simulator with another engine is refused.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct jostle_tip_path {
    /// Set by jostle_tip_path_default().
    pub struct_size: u32,
    /// 1 where `base` is given, else 0.
    pub has_base: u32,
    /// x: way from the start, y: height above the table, before the arm lifts. x rises, y never does. 1 to 64 points.
    pub sink: *const jostle_vec2,
    pub sink_count: usize,
    /// x: share of the shortfall that is gone, from 0 to 1; y: how far the tip has risen since the lift began, from 0 on,
    /// never falling. 2 to 64 points.
    pub rise: *const jostle_vec2,
    pub rise_count: usize,
    /// How long before the commanded end the arm begins to lift, in pushes along the line to the base: 0 to 1 m.
    pub shortfall_along: f64,
    /// And in pushes across it. Without a base the mean of the two holds.
    pub shortfall_across: f64,
    /// Where the robot stands, in the scene's frame.
    pub base: jostle_vec2,
}

// SAFETY: repr(C), struct_size first, numbers and pointers without padding.
unsafe impl Sized32 for jostle_tip_path {
    const NAME: &'static str = "jostle_tip_path";
    const FIRST_SIZE: usize = 72;
    fn defaults() -> Self {
        jostle_tip_path {
            struct_size: size_of::<Self>() as u32,
            has_base: 0,
            sink: std::ptr::null(),
            sink_count: 0,
            rise: std::ptr::null(),
            rise_count: 0,
            shortfall_along: 0.0,
            shortfall_across: 0.0,
            base: jostle_vec2 { x: 0.0, y: 0.0 },
        }
    }
}

/// Sets every field to its default; `size` is sizeof(jostle_tip_path) as the caller was compiled. The tables are yours to
/// give. jostle_tip_path_default() in this header does it for you.
///
/// Thread: any.
/// RT: yes.
/// Nullable: none.
/// Owns: the caller.
/// Errors: ARGUMENT (null, a size that no version has).
#[unsafe(no_mangle)]
pub unsafe extern "C" fn jostle_tip_path_init(path: *mut jostle_tip_path, size: usize) -> jostle_status {
    // SAFETY: the caller promises `size` writable bytes.
    guard("jostle_tip_path_init", |_| unsafe { init_sized(path, "path", size) })
}

/// Gives the scene's robot this path of the tip, or with null a straight one. A gripper that is set later keeps it where its
/// tip_path is JOSTLE_TIP_OWN.
///
/// Thread: exclusive use of scene.
/// RT: no.
/// Nullable: path (straight).
/// Owns: `path` and its tables are copied.
/// Errors: ARGUMENT (null, a field: the message names it), HANDLE, BUSY, POISONED, ABI.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn jostle_scene_set_tip_path(
    scene: *mut jostle_scene,
    path: *const jostle_tip_path,
) -> jostle_status {
    with_mut("jostle_scene_set_tip_path", scene, |content| {
        let mut gripper = content.gripper.clone();
        gripper.path = None;
        if !path.is_null() {
            // SAFETY: the caller promises an initialised struct with tables of their counts.
            let (p, sink, rise) = unsafe {
                let p = read_sized(path, "path")?;
                (p, slice(p.sink, p.sink_count, "path.sink")?, slice(p.rise, p.rise_count, "path.rise")?)
            };
            if p.has_base > 1 {
                return Err(Failure::argument("path.has_base", format!("is {}; it must be 0 or 1", p.has_base)));
            }
            let table = |points: &[jostle_vec2]| Table { points: points.iter().map(|p| [p.x, p.y]).collect() };
            let new = TipPath {
                sink: table(sink),
                shortfall_along: p.shortfall_along,
                shortfall_across: p.shortfall_across,
                base: (p.has_base != 0).then_some([p.base.x, p.base.y]),
                rise: table(rise),
            };
            new.validate().map_err(Failure::from)?;
            gripper.path = Some(new);
        }
        gripper.name = gripper.known_name().unwrap_or("custom").to_string();
        content.gripper = gripper;
        content.changed();
        Ok(())
    })
}
