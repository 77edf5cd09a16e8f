//! The case files of the originals (VFT, MORE, PMBS).
//!
//! One body a line, ten columns: `mesh r g b x y z roll pitch yaw` (colour from 0 to 1, metres, radians,
//! R = Rz(yaw) Ry(pitch) Rx(roll)). The frame is the robot's base with the table at z = 0, and the body of the first
//! line is the target. The file says nothing else: workspace, push length, friction and masses come from an
//! [`ArcProfile`].
//!
//! A block that does not stand upright is laid down in the plane. Upside down it has its mirrored outline; on another
//! side it has its silhouette from above, and the height of that side. A tilt of up to 0.15 rad is put down to the
//! block not having settled. A block that rests on another one has no place in a planar scene: the file is refused.

use std::path::Path;
use std::sync::Arc;

use super::gripper::Gripper;
use super::library::{self, BlockConvention, BlockSet};
use super::solid;
use super::state::State;
use super::workspace::Workspace;
use super::world::{Friction, Problem, SceneBuilder};
use crate::error::{Error, Result};
use crate::files;
use crate::geom::{Pose2, vec2};

/// How high the lowest point of a body may be above the table, or below it, metres. The files hold blocks that float
/// or sink by a few millimetres, which the simulators let settle.
const STANDS_WITHIN: f64 = 0.010;
const COLUMNS: [&str; 10] = ["mesh", "r", "g", "b", "x", "y", "z", "roll", "pitch", "yaw"];

/// The setting in which the cases are to be solved.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum ArcProfile {
    /// VFT and MORE: a square of 0.448 m, pushes of 0.10 m, blocks of 0.1 kg.
    #[default]
    More,
    /// PMBS: a square of 0.288 m, pushes of 0.05 m, blocks with masses by size.
    Pmbs,
}

impl ArcProfile {
    /// PMBS for files in a folder named `confined`, otherwise MORE.
    pub fn of_path(path: impl AsRef<Path>) -> ArcProfile {
        match path.as_ref().parent().and_then(Path::file_name) {
            Some(folder) if folder == "confined" => ArcProfile::Pmbs,
            _ => ArcProfile::More,
        }
    }

    /// No block's centre may leave it.
    pub fn workspace(self) -> Workspace {
        let half = match self {
            ArcProfile::More => 0.224,
            ArcProfile::Pmbs => 0.144,
        };
        Workspace::rectangle(vec2(0.5 - half, -half), vec2(0.5 + half, half))
    }

    /// Metres.
    pub fn push_length(self) -> f64 {
        match self {
            ArcProfile::More => 0.10,
            ArcProfile::Pmbs => 0.05,
        }
    }

    pub fn block_set(self) -> BlockSet {
        match self {
            ArcProfile::More => BlockSet::More,
            ArcProfile::Pmbs => BlockSet::Pmbs,
        }
    }

    /// Coefficients that give the originals' contacts with the profile's blocks: MORE 0.55 on the ground, 0.25 between
    /// blocks and 0.45 at the tip; PMBS 0.7, 0.3 and 0.45.
    pub fn friction(self) -> Friction {
        match self {
            ArcProfile::More => Friction { ground: 1.1, tip: 0.9 },
            ArcProfile::Pmbs => {
                let block = BlockSet::Pmbs.friction();
                Friction { ground: 0.7 / block, tip: 0.45 / block }
            }
        }
    }
}

/// What is not in the files.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct ArcOptions {
    /// By the file's folder if absent: [`ArcProfile::of_path`].
    pub profile: Option<ArcProfile>,
    pub convention: BlockConvention,
}

/// A case with what belongs to it but not to a scene.
#[derive(Debug, Clone)]
pub struct ArcCase {
    /// Named after the file; the bodies are named after mesh and line: `cube 3` is on the fourth line.
    pub problem: Problem,
    pub profile: ArcProfile,
    /// The bodies that do not stand upright in the file and were laid down in the plane.
    pub laid_down: Vec<usize>,
}

impl ArcCase {
    /// The length of the profile's pushes, metres.
    pub fn push_length(&self) -> f64 {
        self.profile.push_length()
    }
}

/// Reads a case file.
pub fn read(path: impl AsRef<Path>, options: ArcOptions) -> Result<ArcCase> {
    let path = path.as_ref();
    of_text(path, &files::read_text(path)?, options)
}

/// A case file whose text was read.
pub(super) fn of_text(path: &Path, text: &str, options: ArcOptions) -> Result<ArcCase> {
    let profile = options.profile.unwrap_or_else(|| ArcProfile::of_path(path));
    parse(text, &files::stem(path), profile, options.convention).map_err(|e| Error::format(path, e))
}

/// Reads the text of a case file. Errors name the line, counted from 1, and the column.
pub fn parse(text: &str, name: &str, profile: ArcProfile, convention: BlockConvention) -> Result<ArcCase> {
    let mut builder = SceneBuilder::new();
    builder.workspace(profile.workspace()).friction(profile.friction()).gripper(Gripper::robotiq_2f85());
    let mut poses: Vec<Pose2> = Vec::new();
    let mut line_of: Vec<usize> = Vec::new();
    let mut laid_down = Vec::new();
    for (i, line) in text.lines().enumerate().filter(|(_, line)| !line.trim().is_empty()) {
        let field = format!("line {}", i + 1);
        let body = poses.len();
        let (block, position, angles) = columns(line).map_err(|e| prefixed(e, &field))?;
        let mut def = library::block_of(block, profile.block_set(), convention).map_err(|e| prefixed(e, &field))?;
        def.name = format!("{block} {body}");
        let placed = solid::lay_down(def, block, position[2], angles, convention).map_err(|e| prefixed(e, &field))?;
        if placed.lowest > STANDS_WITHIN {
            return Err(Error::argument(
                field,
                format!(
                    "the `{block}` hangs {:.0} mm above the table, so it rests on another body; a planar scene has no \
                     place for it",
                    placed.lowest * 1e3
                ),
            ));
        }
        if placed.lowest < -STANDS_WITHIN {
            let depth = -placed.lowest * 1e3;
            return Err(Error::argument(
                field,
                format!("the `{block}` reaches {depth:.0} mm below the table; check z"),
            ));
        }
        if !placed.upright {
            laid_down.push(body);
        }
        builder.add_body(placed.def).map_err(|e| prefixed(e, &field))?;
        poses.push(Pose2::new(position[0], position[1], placed.theta));
        line_of.push(i + 1);
    }
    let scene = Arc::new(builder.build()?);
    let state = State::new(poses);
    let problem = Problem::new(name, scene, state, 0).map_err(|e| on_its_line(e, &line_of))?;
    Ok(ArcCase { problem, profile, laid_down })
}

/// The mesh as the library names it, position and angles of a line.
fn columns(line: &str) -> Result<(&'static str, [f64; 3], [f64; 3])> {
    let found: Vec<&str> = line.split_whitespace().collect();
    if found.len() != COLUMNS.len() {
        let reason = format!("has {} columns; {} are needed: {}", found.len(), COLUMNS.len(), COLUMNS.join(" "));
        return Err(Error::argument("", reason));
    }
    let block = library::canonical(found[0].strip_suffix(".urdf").unwrap_or(found[0])).map_err(|e| match e {
        Error::NotFound { reason, .. } => Error::not_found("mesh", reason),
        other => other,
    })?;
    let mut numbers = [0.0f64; 9];
    for ((number, text), column) in numbers.iter_mut().zip(&found[1..]).zip(&COLUMNS[1..]) {
        *number = text.parse().map_err(|_| Error::argument(*column, format!("`{text}` is not a number")))?;
        if !number.is_finite() {
            return Err(Error::argument(*column, format!("is {text}; it must be a finite number")));
        }
    }
    let [_, _, _, x, y, z, roll, pitch, yaw] = numbers;
    Ok((block, [x, y, z], [roll, pitch, yaw]))
}

/// Puts the line before the field, or in its place where there is none.
fn prefixed(error: Error, line: &str) -> Error {
    let join = |field: String| if field.is_empty() { line.to_owned() } else { format!("{line}: {field}") };
    match error {
        Error::Argument { field, reason } => Error::Argument { field: join(field), reason },
        Error::NotFound { field, reason } => Error::NotFound { field: join(field), reason },
        other => other,
    }
}

/// An error about a pose as one about the line it comes from.
fn on_its_line(error: Error, line_of: &[usize]) -> Error {
    if let Error::Argument { field, reason } = &error {
        let found = field.strip_prefix("poses[").and_then(|rest| rest.split_once(']'));
        let index = found.and_then(|(index, _)| index.parse().ok());
        if let Some(line) = index.and_then(|i: usize| line_of.get(i)) {
            let column = found.map_or("", |(_, column)| column).replace('.', ": ");
            return Error::argument(format!("line {line}{column}"), reason.clone());
        }
    }
    error
}

#[cfg(test)]
#[path = "arc_tests.rs"]
mod tests;
