//! Settings of a scene: gripper, workspace, friction, tolerance.

use std::ffi::c_char;

use super::abi::{Sized32, init_sized, jostle_vec2, out, read_sized, text, write_sized};
use super::guard::guard;
use super::scene::{jostle_scene, with, with_mut};
use super::status::{Failure, Outcome, jostle_status};
use super::tip_path::{JOSTLE_TIP_OWN, JOSTLE_TIP_STRAIGHT, JOSTLE_TIP_UR5E, jostle_tip};
use crate::bounds;
use crate::scene::{Friction, Grasper, Gripper, Keeping, LeaveRule, LeaveScope, PushTip, TipPath, Workspace};

/// What the score of a grasp is: one of the JOSTLE_SCORE_ values.
pub type jostle_grasp_score = i32;
/// A judgement by the shape of the grip (the default).
pub const JOSTLE_SCORE_SHAPE: jostle_grasp_score = 0;
/// The chance that the gripper keeps the body, by shape, height and mass of the body and the room of the fingers: the model
/// of robotiq_2f85_kept, at this gripper's size.
pub const JOSTLE_SCORE_KEPT: jostle_grasp_score = 1;
/// A chance by the tables of the scene's own file, which a struct does not hold: a scene that has them keeps them.
pub const JOSTLE_SCORE_OWN: jostle_grasp_score = 2;

/// The measures of a two-finger gripper: the closed fingers it pushes with, the jaw it grasps with. Metres and radians.
/// Widths, thicknesses and the opening lie in 1e-4 to 10 m, free gaps (clearances, fit) in 0 to 0.1 m.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct jostle_gripper {
    /// Set by jostle_gripper_default().
    pub struct_size: u32,
    /// What scores grasps: one of the JOSTLE_SCORE_ values.
    pub grasp_score: jostle_grasp_score,
    /// Closed fingers: extent across the push.
    pub push_width: f64,
    /// Closed fingers: extent along the push.
    pub push_thickness: f64,
    /// Free gap needed round the closed fingers where they come down.
    pub push_clearance: f64,
    /// Free distance between the pads when open.
    pub opening: f64,
    /// Extent of a finger across the closing direction (the pad's width).
    pub finger_width: f64,
    /// Extent of a finger along the closing direction.
    pub finger_thickness: f64,
    /// Free gap needed on every side of a finger.
    pub finger_clearance: f64,
    /// Free gap needed between each pad and the body before closing.
    pub fit: f64,
    /// Strip at either end of the pads that another body may block while closing.
    pub pad_edge: f64,
    /// Least length of the body that the pads must cover.
    pub min_cover: f64,
    /// Greatest angle between the two gripped faces.
    pub max_wedge: f64,
    /// How the robot moves the tip in a push: one of the JOSTLE_TIP_ values.
    pub tip_path: jostle_tip,
    /// 0.
    pub reserved: u32,
    /// The fingers' ends come no nearer to the table than this: 0 by default, at most 10. A body that they would not reach
    /// down by 5 mm (for robotiq_2f85) cannot be grasped; one that they end above is in no finger's way.
    pub lowest: f64,
    /// Length of the fingers below the palm, which stops at the body's top: over a tall one they end higher up. Infinity, the
    /// default: longer than any body is high.
    pub finger_length: f64,
}

impl From<&Gripper> for jostle_gripper {
    fn from(gripper: &Gripper) -> Self {
        let (p, g) = (&gripper.push, &gripper.grasp);
        jostle_gripper {
            struct_size: size_of::<Self>() as u32,
            grasp_score: match &gripper.keeping {
                None => JOSTLE_SCORE_SHAPE,
                Some(keeping) if *keeping == Keeping::robotiq_2f85().scaled(gripper.scale()) => JOSTLE_SCORE_KEPT,
                Some(_) => JOSTLE_SCORE_OWN,
            },
            push_width: p.width,
            push_thickness: p.thickness,
            push_clearance: p.clearance,
            opening: g.opening,
            finger_width: g.finger_width,
            finger_thickness: g.finger_thickness,
            finger_clearance: g.finger_clearance,
            fit: g.fit,
            pad_edge: g.pad_edge,
            min_cover: g.min_cover,
            max_wedge: g.max_wedge,
            tip_path: match &gripper.path {
                None => JOSTLE_TIP_STRAIGHT,
                Some(path) if *path == TipPath::ur5e().scaled(gripper.scale()) => JOSTLE_TIP_UR5E,
                Some(_) => JOSTLE_TIP_OWN,
            },
            reserved: 0,
            lowest: g.lowest,
            finger_length: g.finger_length,
        }
    }
}

// SAFETY: repr(C), struct_size first, numbers without padding.
unsafe impl Sized32 for jostle_gripper {
    const NAME: &'static str = "jostle_gripper";
    const FIRST_SIZE: usize = 96;
    fn defaults() -> Self {
        (&Gripper::default()).into()
    }
}

/// Sets every field to the gripper robotiq_2f85; `size` is sizeof(jostle_gripper) as the caller was compiled.
/// jostle_gripper_default() in this header does it for you.
///
/// Thread: any.
/// RT: no.
/// Nullable: none.
/// Owns: the caller.
/// Errors: ARGUMENT (null, a size that no version has).
#[unsafe(no_mangle)]
pub unsafe extern "C" fn jostle_gripper_init(gripper: *mut jostle_gripper, size: usize) -> jostle_status {
    // SAFETY: the caller promises `size` writable bytes.
    guard("jostle_gripper_init", |_| unsafe { init_sized(gripper, "gripper", size) })
}

/// The measures of a gripper of the library: "robotiq_2f85", "robotiq_2f85_kept" (the same, which scores grasps by the chance
/// that it keeps the body), "robotiq_2f85_ur5e" (that one, whose tip goes as a UR5e moves it) or "dissertation_mask".
///
/// Thread: any.
/// RT: no.
/// Nullable: none.
/// Owns: the caller; gripper->struct_size says how much is written.
/// Errors: ARGUMENT (null, not UTF-8, gripper not initialised), NOT_FOUND (the message lists the names).
#[unsafe(no_mangle)]
pub unsafe extern "C" fn jostle_gripper_by_name(name: *const c_char, gripper: *mut jostle_gripper) -> jostle_status {
    guard("jostle_gripper_by_name", |_| {
        // SAFETY: the caller promises text and an initialised struct.
        unsafe { write_sized(gripper, "gripper", &(&Gripper::by_name(text(name, "name")?)?).into()) }
    })
}

/// Gives the scene's robot this gripper.
///
/// Thread: exclusive use of scene.
/// RT: no.
/// Nullable: none.
/// Owns: `gripper` is copied.
/// Errors: ARGUMENT (null, a field: the message names it), HANDLE, BUSY, POISONED, ABI.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn jostle_scene_set_gripper(
    scene: *mut jostle_scene,
    gripper: *const jostle_gripper,
) -> jostle_status {
    with_mut("jostle_scene_set_gripper", scene, |content| {
        // SAFETY: the caller promises an initialised struct.
        content.gripper = unsafe { read_gripper(gripper, "gripper", Some(&content.gripper)) }?;
        content.changed();
        Ok(())
    })
}

/// Reads and checks a caller's gripper, which failures call `field`; `own` is what JOSTLE_SCORE_OWN keeps.
///
/// # Safety
/// `gripper` is null or a struct of its size.
pub(super) unsafe fn read_gripper(
    gripper: *const jostle_gripper,
    field: &str,
    own: Option<&Gripper>,
) -> Outcome<Gripper> {
    // SAFETY: as promised by the caller.
    let g = unsafe { read_sized(gripper, field) }?;
    let mut new = Gripper {
        name: String::new(),
        push: PushTip { width: g.push_width, thickness: g.push_thickness, clearance: g.push_clearance },
        grasp: Grasper {
            opening: g.opening,
            finger_width: g.finger_width,
            finger_thickness: g.finger_thickness,
            finger_clearance: g.finger_clearance,
            fit: g.fit,
            pad_edge: g.pad_edge,
            min_cover: g.min_cover,
            max_wedge: g.max_wedge,
            lowest: g.lowest,
            finger_length: g.finger_length,
        },
        keeping: None,
        path: None,
    };
    new.path = path_of(g.tip_path, &new, own.and_then(|own| own.path.as_ref()), field)?;
    new.keeping = keeping_of(g.grasp_score, &new, own.and_then(|own| own.keeping.as_ref()), field)?;
    new.validate().map_err(|error| {
        let mut failure = Failure::from(error);
        failure.message = failure
            .message
            .replace("gripper.push.", &format!("{field}.push_"))
            .replace("gripper.grasp.", &format!("{field}."));
        failure
    })?;
    // Files and reports name a gripper of the library by its name.
    new.name = new.known_name().unwrap_or("custom").to_string();
    Ok(new)
}

/// The model that a value of `grasp_score` names, for a gripper of these measures.
fn keeping_of(
    score: jostle_grasp_score,
    gripper: &Gripper,
    own: Option<&Keeping>,
    field: &str,
) -> Outcome<Option<Keeping>> {
    let field = format!("{field}.grasp_score");
    match (score, own) {
        (JOSTLE_SCORE_SHAPE, _) => Ok(None),
        (JOSTLE_SCORE_KEPT, _) => Ok(Some(Keeping::robotiq_2f85().scaled(gripper.scale()))),
        (JOSTLE_SCORE_OWN, Some(own)) => Ok(Some(own.clone())),
        (JOSTLE_SCORE_OWN, None) => {
            Err(Failure::argument(&field, "is 2, but the scene has no tables of its own to score by"))
        }
        _ => Err(Failure::argument(&field, format!("is {score}; it must be a JOSTLE_SCORE_ value"))),
    }
}

/// The path that a value of `tip_path` names, for a gripper of these measures.
fn path_of(tip: jostle_tip, gripper: &Gripper, own: Option<&TipPath>, field: &str) -> Outcome<Option<TipPath>> {
    let field = format!("{field}.tip_path");
    match (tip, own) {
        (JOSTLE_TIP_STRAIGHT, _) => Ok(None),
        (JOSTLE_TIP_UR5E, _) => Ok(Some(TipPath::ur5e().scaled(gripper.scale()))),
        (JOSTLE_TIP_OWN, Some(own)) => Ok(Some(own.clone())),
        (JOSTLE_TIP_OWN, None) => {
            Err(Failure::argument(&field, "is 2, but the scene has no path of its own for the tip"))
        }
        _ => Err(Failure::argument(&field, format!("is {tip}; it must be a JOSTLE_TIP_ value"))),
    }
}

/// The gripper of the scene's robot.
///
/// Thread: shared use of scene.
/// RT: no.
/// Nullable: none.
/// Owns: the caller; gripper->struct_size says how much is written.
/// Errors: ARGUMENT (null, gripper not initialised), HANDLE, BUSY, POISONED.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn jostle_scene_get_gripper(
    scene: *const jostle_scene,
    gripper: *mut jostle_gripper,
) -> jostle_status {
    // SAFETY: the caller promises an initialised struct.
    with("jostle_scene_get_gripper", scene, |content| unsafe {
        write_sized(gripper, "gripper", &(&content.gripper).into())
    })
}

/// When a body counts as having left the workspace: one of the JOSTLE_LEAVE_ values.
pub type jostle_leave_rule = i32;
/// Its frame's origin is outside (the default).
pub const JOSTLE_LEAVE_CENTRE: jostle_leave_rule = 1;
/// Any part of its footprint is outside.
pub const JOSTLE_LEAVE_FOOTPRINT: jostle_leave_rule = 2;

/// Which bodies must not leave: one of the JOSTLE_SCOPE_ values.
pub type jostle_leave_scope = i32;
/// All bodies (the default).
pub const JOSTLE_SCOPE_ALL_BODIES: jostle_leave_scope = 1;
/// The target alone.
pub const JOSTLE_SCOPE_TARGET_ONLY: jostle_leave_scope = 2;

/// The rectangle that bodies must not leave, in the world frame: its sides are 0.001 to 200 m, its corners lie where
/// poses may. The target of a problem must be in it, by the rule.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct jostle_workspace {
    /// Set by jostle_workspace_default().
    pub struct_size: u32,
    /// JOSTLE_LEAVE_CENTRE or JOSTLE_LEAVE_FOOTPRINT.
    pub leave_rule: jostle_leave_rule,
    /// Least x and y, metres.
    pub min: jostle_vec2,
    /// Greatest x and y, metres.
    pub max: jostle_vec2,
    /// JOSTLE_SCOPE_ALL_BODIES or JOSTLE_SCOPE_TARGET_ONLY.
    pub leave_scope: jostle_leave_scope,
    /// 0.
    pub reserved: u32,
}

impl From<&Workspace> for jostle_workspace {
    fn from(w: &Workspace) -> Self {
        jostle_workspace {
            struct_size: size_of::<Self>() as u32,
            leave_rule: match w.leave_rule {
                LeaveRule::Centre => JOSTLE_LEAVE_CENTRE,
                LeaveRule::Footprint => JOSTLE_LEAVE_FOOTPRINT,
            },
            min: w.min.into(),
            max: w.max.into(),
            leave_scope: match w.leave_scope {
                LeaveScope::AllBodies => JOSTLE_SCOPE_ALL_BODIES,
                LeaveScope::TargetOnly => JOSTLE_SCOPE_TARGET_ONLY,
            },
            reserved: 0,
        }
    }
}

// SAFETY: repr(C), struct_size first, numbers without padding.
unsafe impl Sized32 for jostle_workspace {
    const NAME: &'static str = "jostle_workspace";
    const FIRST_SIZE: usize = 48;
    fn defaults() -> Self {
        (&Workspace::default()).into()
    }
}

/// Sets every field to its default; `size` is sizeof(jostle_workspace) as the caller was compiled.
/// jostle_workspace_default() in this header does it for you.
///
/// Thread: any.
/// RT: yes.
/// Nullable: none.
/// Owns: the caller.
/// Errors: ARGUMENT (null, a size that no version has).
#[unsafe(no_mangle)]
pub unsafe extern "C" fn jostle_workspace_init(workspace: *mut jostle_workspace, size: usize) -> jostle_status {
    // SAFETY: the caller promises `size` writable bytes.
    guard("jostle_workspace_init", |_| unsafe { init_sized(workspace, "workspace", size) })
}

/// Sets the rectangle that bodies must not leave, and the rule.
///
/// Thread: exclusive use of scene.
/// RT: no.
/// Nullable: none.
/// Owns: `workspace` is copied.
/// Errors: ARGUMENT (null, a field: the message names it), HANDLE, BUSY, POISONED, ABI.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn jostle_scene_set_workspace(
    scene: *mut jostle_scene,
    workspace: *const jostle_workspace,
) -> jostle_status {
    with_mut("jostle_scene_set_workspace", scene, |content| {
        // SAFETY: the caller promises an initialised struct.
        let w = unsafe { read_sized(workspace, "workspace") }?;
        let unknown =
            |field: &str, value: i32| Failure::argument(field, format!("is {value}; no rule has this number"));
        let new = Workspace {
            min: [w.min.x, w.min.y],
            max: [w.max.x, w.max.y],
            leave_rule: match w.leave_rule {
                JOSTLE_LEAVE_CENTRE => LeaveRule::Centre,
                JOSTLE_LEAVE_FOOTPRINT => LeaveRule::Footprint,
                other => return Err(unknown("workspace.leave_rule", other)),
            },
            leave_scope: match w.leave_scope {
                JOSTLE_SCOPE_ALL_BODIES => LeaveScope::AllBodies,
                JOSTLE_SCOPE_TARGET_ONLY => LeaveScope::TargetOnly,
                other => return Err(unknown("workspace.leave_scope", other)),
            },
        };
        new.validate()?;
        content.workspace = new;
        content.changed();
        Ok(())
    })
}

/// The rectangle that bodies must not leave, and the rule.
///
/// Thread: shared use of scene.
/// RT: no.
/// Nullable: none.
/// Owns: the caller; workspace->struct_size says how much is written.
/// Errors: ARGUMENT (null, workspace not initialised), HANDLE, BUSY, POISONED.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn jostle_scene_get_workspace(
    scene: *const jostle_scene,
    workspace: *mut jostle_workspace,
) -> jostle_status {
    // SAFETY: the caller promises an initialised struct.
    with("jostle_scene_get_workspace", scene, |content| unsafe {
        write_sized(workspace, "workspace", &(&content.workspace).into())
    })
}

/// Sets the friction coefficients of the table and of the fingertips. A contact uses the product of its two surfaces'
/// coefficients. Defaults: 1.1 and 0.9.
///
/// Thread: exclusive use of scene.
/// RT: no.
/// Nullable: none.
/// Owns: nothing.
/// Errors: ARGUMENT (not finite, out of 0..10), HANDLE, BUSY, POISONED.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn jostle_scene_set_friction(scene: *mut jostle_scene, ground: f64, tip: f64) -> jostle_status {
    with_mut("jostle_scene_set_friction", scene, |content| {
        bounds::FRICTION.check("ground", ground)?;
        bounds::FRICTION.check("tip", tip)?;
        content.friction = Friction { ground, tip };
        content.changed();
        Ok(())
    })
}

/// The friction coefficients of the table and of the fingertips.
///
/// Thread: shared use of scene.
/// RT: no.
/// Nullable: none.
/// Owns: nothing.
/// Errors: ARGUMENT (null), HANDLE, BUSY, POISONED.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn jostle_scene_get_friction(
    scene: *const jostle_scene,
    ground: *mut f64,
    tip: *mut f64,
) -> jostle_status {
    with("jostle_scene_get_friction", scene, |content| {
        // SAFETY: the caller promises writable places.
        let (ground, tip) = unsafe { (out(ground, "ground")?, out(tip, "tip")?) };
        ground.set(content.friction.ground);
        tip.set(content.friction.tip);
        Ok(())
    })
}

/// Sets how far two bodies may overlap before an observation is refused, metres: 0.006 by default.
///
/// Thread: exclusive use of scene.
/// RT: no.
/// Nullable: none.
/// Owns: nothing.
/// Errors: ARGUMENT (not finite, out of 0..0.05), HANDLE, BUSY, POISONED.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn jostle_scene_set_overlap_tolerance(scene: *mut jostle_scene, metres: f64) -> jostle_status {
    with_mut("jostle_scene_set_overlap_tolerance", scene, |content| -> Outcome {
        bounds::OVERLAP.check("metres", metres)?;
        content.overlap_tolerance = metres;
        content.changed();
        Ok(())
    })
}
