//! Grasps of a scene's bodies: the best, the best few, and any one examined.

use std::ffi::c_char;

use super::abi::{fill, fill_text, jostle_body, out, read};
use super::action::{c_grasp, jostle_grasp};
use super::scene::{Bodies, Content, Observed, jostle_scene, with};
use super::status::{Failure, Outcome, jostle_status};
use crate::action::Grasp;
use crate::error::Error;
use crate::grasp::{APART, GraspExamination, GraspScratch, Limit};

/// A condition of the grasp rule: one of the JOSTLE_LIMIT_ values.
pub type jostle_grasp_limit = i32;
/// No part of the body is between the pads.
pub const JOSTLE_LIMIT_NOTHING_BETWEEN: jostle_grasp_limit = 1;
/// The body is not pickable.
pub const JOSTLE_LIMIT_NOT_PICKABLE: jostle_grasp_limit = 2;
/// The gripper does not open so far.
pub const JOSTLE_LIMIT_OPENING: jostle_grasp_limit = 3;
/// The body's width in the opening: it does not fit between the fingers, wherever along the closing direction they are.
pub const JOSTLE_LIMIT_WIDTH: jostle_grasp_limit = 4;
/// A finger's clearance to `limit_body`: another body, or the one to be grasped where the fingers come down on it or too
/// near to it.
pub const JOSTLE_LIMIT_FINGER: jostle_grasp_limit = 5;
/// `limit_body`, another one, reaches into the space between the fingers.
pub const JOSTLE_LIMIT_BETWEEN: jostle_grasp_limit = 6;
/// The length of the body that the pads cover.
pub const JOSTLE_LIMIT_COVER: jostle_grasp_limit = 7;
/// The angle between the gripped faces.
pub const JOSTLE_LIMIT_WEDGE: jostle_grasp_limit = 8;
/// How far the fingers reach down the body: it is too low for them.
pub const JOSTLE_LIMIT_DEPTH: jostle_grasp_limit = 9;

/// Two grasps of a list are at least so far apart, metres, or their closing directions JOSTLE_GRASPS_TURNED. For a gripper
/// of another size than robotiq_2f85 the distance grows with it.
pub const JOSTLE_GRASPS_APART: f64 = 0.010;
/// Two grasps of a list are JOSTLE_GRASPS_APART from each other, or their closing directions differ at least by this, radians.
pub const JOSTLE_GRASPS_TURNED: f64 = 0.35;

const _: () = assert!(JOSTLE_GRASPS_APART == APART.0 && JOSTLE_GRASPS_TURNED == APART.1);

/// What a grasp is known by (docs/grasp-score.md). Every value is NaN where no part of the body is between the pads. Frozen:
/// never changes.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct jostle_grasp_features {
    /// Extent of the body between the pads along the closing direction, metres.
    pub width: f64,
    /// Length along the pads of what comes to lie on a pad, the lesser of both sides, metres.
    pub touch: f64,
    /// Least turn that lays a face flat on its pad, radians.
    pub turn: f64,
    /// How far the body reaches past the pads' middle along them, the lesser of both ways, metres.
    pub end: f64,
    /// Least gap of the open fingers to the body and to the others, metres; below 0 they come down on one.
    pub clearance: f64,
    /// How far the closed pads reach down the body, metres; NaN for a gripper without a chance of keeping.
    pub depth: f64,
    /// Of the body's top above the table, metres.
    pub height: f64,
    /// Of the body, kg.
    pub mass: f64,
}

/// What there is to know of one grasp. A `_spare` is the room that a condition has, and is not met while that is negative;
/// each is NaN where no part of the body is between the pads. Frozen: never changes.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct jostle_grasp_report {
    /// The grasp as it was given (an opening of 0 as the gripper's), with its width, margin and score. The margin is minus
    /// infinity where no part of the body is between the pads, the score 0 for a grasp that is not allowed.
    pub grasp: jostle_grasp,
    /// The body that it takes.
    pub body: jostle_body,
    /// 1 if a planner may execute it: all conditions are met; else 0.
    pub allowed: u32,
    /// The condition that is not met; of an allowed grasp, the one with the least spare room.
    pub limit: jostle_grasp_limit,
    /// The body that JOSTLE_LIMIT_FINGER and _BETWEEN mean; else zero.
    pub limit_body: jostle_body,
    /// Chance that the gripper keeps the body, allowed or not; NaN for a gripper without a chance of keeping (its score is
    /// a judgement by the shape of the grip: JOSTLE_SCORE_SHAPE).
    pub chance: f64,
    /// Angle between the gripped faces, radians.
    pub wedge: f64,
    /// Between the open fingers and the body itself, metres.
    pub fit_spare: f64,
    /// Of the length that the pads cover, metres.
    pub cover_spare: f64,
    /// Between the fingers and the other bodies, metres; infinite without any.
    pub finger_spare: f64,
    /// Between the space between the fingers and the other bodies, metres; infinite without any.
    pub between_spare: f64,
    /// Of the gripper's opening over the one asked for, metres.
    pub opening_spare: f64,
    /// Of the angle between the gripped faces, radians.
    pub wedge_spare: f64,
    /// The body that `finger_spare` is to; zero without any.
    pub finger_body: jostle_body,
    /// The body that `between_spare` is to; zero without any.
    pub between_body: jostle_body,
    pub features: jostle_grasp_features,
}

fn c_limit(limit: Limit) -> jostle_grasp_limit {
    match limit {
        Limit::Missing => JOSTLE_LIMIT_NOTHING_BETWEEN,
        Limit::NotPickable => JOSTLE_LIMIT_NOT_PICKABLE,
        Limit::Opening => JOSTLE_LIMIT_OPENING,
        Limit::Width => JOSTLE_LIMIT_WIDTH,
        Limit::Finger { .. } => JOSTLE_LIMIT_FINGER,
        Limit::Jaw { .. } => JOSTLE_LIMIT_BETWEEN,
        Limit::Cover => JOSTLE_LIMIT_COVER,
        Limit::Wedge => JOSTLE_LIMIT_WEDGE,
        Limit::Depth => JOSTLE_LIMIT_DEPTH,
    }
}

fn c_features(examined: &GraspExamination) -> jostle_grasp_features {
    let of = |value: Option<f64>| value.unwrap_or(f64::NAN);
    let f = examined.features;
    jostle_grasp_features {
        width: of(f.map(|f| f.width)),
        touch: of(f.map(|f| f.touch)),
        turn: of(f.map(|f| f.turn)),
        end: of(f.map(|f| f.end)),
        clearance: of(f.map(|f| f.clearance)),
        depth: of(examined.depth),
        height: of(f.map(|f| f.height)),
        mass: of(f.map(|f| f.mass)),
    }
}

fn c_report(examined: &GraspExamination, bodies: &Bodies) -> jostle_grasp_report {
    let of = |value: Option<f64>| value.unwrap_or(f64::NAN);
    let id = |body: Option<usize>| body.map(|index| bodies.id(index)).unwrap_or_default();
    let spares = examined.spares;
    jostle_grasp_report {
        grasp: c_grasp(&examined.grasp),
        body: bodies.id(examined.grasp.body),
        allowed: u32::from(examined.allowed),
        limit: c_limit(examined.limit),
        limit_body: id(examined.limit.body()),
        chance: of(examined.chance),
        wedge: examined.wedge,
        fit_spare: of(spares.map(|s| s.fit)),
        cover_spare: of(spares.map(|s| s.cover)),
        finger_spare: of(spares.map(|s| s.finger)),
        between_spare: of(spares.map(|s| s.between)),
        opening_spare: of(spares.map(|s| s.opening)),
        wedge_spare: of(spares.map(|s| s.wedge)),
        finger_body: id(spares.and_then(|s| s.finger_body)),
        between_body: id(spares.and_then(|s| s.between_body)),
        features: c_features(examined),
    }
}

/// The best grasp of a body where all bodies are now. *found is 1 if there is one, else 0 and *grasp stays as it was.
///
/// Thread: shared use of scene.
/// RT: no.
/// Nullable: none.
/// Owns: nothing.
/// Errors: ARGUMENT (null, zero body, absent body, bodies that overlap), HANDLE, BUSY, NOT_FOUND, POISONED.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn jostle_scene_best_grasp(
    scene: *const jostle_scene,
    body: jostle_body,
    grasp: *mut jostle_grasp,
    found: *mut u32,
) -> jostle_status {
    with("jostle_scene_best_grasp", scene, |content| {
        // SAFETY: the caller promises writable places.
        let (grasp, found) = unsafe { (out(grasp, "grasp")?, out(found, "found")?) };
        let (observed, test, index) = content.graspable(body)?;
        let best = test.best(&observed.model, &observed.state, index, &mut GraspScratch::default());
        found.set(u32::from(best.is_some()));
        if let Some(best) = best {
            grasp.set(c_grasp(&best));
        }
        Ok(())
    })
}

/// The best grasps of a body where all bodies are now, best first: at most `most`, fewer where there are no more. No two are
/// alike: their positions are JOSTLE_GRASPS_APART from each other, or their closing directions JOSTLE_GRASPS_TURNED. The
/// first is that of jostle_scene_best_grasp (whose lengths and score may differ in the last bits), and what a planner without networks would execute; each of the others is the
/// best of those that are unlike the ones before it. (Scores closer than 1e-9 count as equal.) All are allowed, and each
/// report is what jostle_scene_examine_grasp says of its grasp, to the bit. A buffer for `most` reports is large enough.
///
/// Thread: shared use of scene.
/// RT: no.
/// Nullable: buffer (with capacity 0: asks for the count).
/// Owns: the caller owns the buffer.
/// Errors: ARGUMENT (null, zero body, absent body, most of 0, bodies that overlap), HANDLE, BUSY, BUFFER (count was written),
/// NOT_FOUND, POISONED.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn jostle_scene_best_grasps(
    scene: *const jostle_scene,
    body: jostle_body,
    most: usize,
    buffer: *mut jostle_grasp_report,
    capacity: usize,
    count: *mut usize,
) -> jostle_status {
    with("jostle_scene_best_grasps", scene, |content| {
        // SAFETY: the caller promises a writable place.
        unsafe { out(count, "count") }?;
        if most == 0 {
            return Err(Failure::argument("most", "is 0; ask for at least one grasp"));
        }
        let (observed, test, index) = content.graspable(body)?;
        let scratch = &mut GraspScratch::default();
        let found = test.best_apart(&observed.model, &observed.state, index, most, scratch)?;
        let reports: Vec<_> = found.iter().map(|examined| c_report(examined, &observed.bodies)).collect();
        // SAFETY: the caller promises room for `capacity` reports.
        unsafe { fill(buffer, capacity, count, &reports) }
    })
}

/// Examines a grasp of a body.
///
/// # Safety
/// `grasp` is null or readable.
unsafe fn examined(
    content: &Content,
    body: jostle_body,
    grasp: *const jostle_grasp,
) -> Outcome<(GraspExamination, Observed)> {
    // SAFETY: as promised by the caller.
    let given = unsafe { read(grasp, "grasp") }?;
    let (observed, test, index) = content.graspable(body)?;
    let position = [given.position.x, given.position.y];
    let grasp = Grasp { body: index, position, angle: given.angle, opening: given.opening, ..Grasp::default() };
    let found = test.examine(&observed.model, &observed.state, &grasp, &mut GraspScratch::default());
    Ok((found.map_err(c_field)?, observed))
}

/// Puts the C names of a position in place of the Rust ones.
fn c_field(error: Error) -> Failure {
    match error {
        Error::Argument { field, reason } => {
            let field = field.replace("position[0]", "position.x").replace("position[1]", "position.y");
            Error::Argument { field, reason }.into()
        }
        other => other.into(),
    }
}

/// All that is known of a grasp of a body where all bodies are now: whether it is allowed and why not, score, chance of
/// keeping, width, spare room, features. Of `grasp` position, angle and opening are read; an opening of 0 is the gripper's. A
/// grasp that is not allowed is no failure of the call.
///
/// Thread: shared use of scene.
/// RT: no.
/// Nullable: none.
/// Owns: `grasp` is copied.
/// Errors: ARGUMENT (null, zero body, absent body, a number that is none or out of range: the message names the field; bodies
/// that overlap), HANDLE, BUSY, NOT_FOUND, POISONED.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn jostle_scene_examine_grasp(
    scene: *const jostle_scene,
    body: jostle_body,
    grasp: *const jostle_grasp,
    report: *mut jostle_grasp_report,
) -> jostle_status {
    with("jostle_scene_examine_grasp", scene, |content| {
        // SAFETY: the caller promises a writable place and a readable grasp.
        let (out, (found, observed)) = unsafe { (out(report, "report")?, examined(content, body, grasp)?) };
        out.set(c_report(&found, &observed.bodies));
        Ok(())
    })
}

/// Copies why a grasp is not allowed and what to change, or what leaves an allowed one the least room: a sentence with names
/// and millimetres, for people. `length` counts the closing zero. Of `grasp` the same is read as by
/// jostle_scene_examine_grasp.
///
/// Thread: shared use of scene.
/// RT: no.
/// Nullable: buffer (with capacity 0: asks for the length).
/// Owns: the caller owns the buffer; `grasp` is copied.
/// Errors: as jostle_scene_examine_grasp, and BUFFER (length was written).
#[unsafe(no_mangle)]
pub unsafe extern "C" fn jostle_scene_explain_grasp(
    scene: *const jostle_scene,
    body: jostle_body,
    grasp: *const jostle_grasp,
    buffer: *mut c_char,
    capacity: usize,
    length: *mut usize,
) -> jostle_status {
    with("jostle_scene_explain_grasp", scene, |content| {
        // SAFETY: the caller promises a writable place, a readable grasp and room for `capacity` characters.
        unsafe {
            out(length, "length")?;
            let (found, observed) = examined(content, body, grasp)?;
            fill_text(buffer, capacity, length, &found.reason(&observed.model))
        }
    })
}

/// The name of a condition of the grasp rule, such as "cover"; "unknown limit" for other numbers.
///
/// Thread: any.
/// RT: yes.
/// Nullable: never returns null.
/// Owns: the library, for ever.
/// Errors: none.
#[unsafe(no_mangle)]
pub extern "C" fn jostle_grasp_limit_name(limit: jostle_grasp_limit) -> *const c_char {
    match limit {
        JOSTLE_LIMIT_NOTHING_BETWEEN => c"nothing between",
        JOSTLE_LIMIT_NOT_PICKABLE => c"not pickable",
        JOSTLE_LIMIT_OPENING => c"opening",
        JOSTLE_LIMIT_WIDTH => c"width",
        JOSTLE_LIMIT_FINGER => c"finger",
        JOSTLE_LIMIT_BETWEEN => c"between",
        JOSTLE_LIMIT_COVER => c"cover",
        JOSTLE_LIMIT_WEDGE => c"wedge",
        JOSTLE_LIMIT_DEPTH => c"depth",
        _ => c"unknown limit",
    }
    .as_ptr()
}

#[cfg(test)]
mod tests {
    use std::ffi::CStr;

    use super::*;

    #[test]
    fn a_limit_has_the_same_name_in_c_and_rust() {
        let all = [
            Limit::Missing,
            Limit::NotPickable,
            Limit::Opening,
            Limit::Width,
            Limit::Finger { body: 0 },
            Limit::Jaw { body: 0 },
            Limit::Cover,
            Limit::Wedge,
            Limit::Depth,
        ];
        for (i, limit) in all.into_iter().enumerate() {
            assert_eq!(c_limit(limit), i as i32 + 1);
            // SAFETY: the names are literals.
            let name = unsafe { CStr::from_ptr(jostle_grasp_limit_name(c_limit(limit))) };
            assert_eq!(name.to_str(), Ok(limit.name()));
        }
    }
}
