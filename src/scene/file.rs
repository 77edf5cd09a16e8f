//! Scene files: a [`Problem`], a [`Rearrangement`] or a [`Clearing`] as JSON. `docs/scene-format.md` documents the format.
//!
//! What is written is read back bit for bit. Reading refuses unknown fields, and every error names the field and
//! where it stands.

use std::path::Path;
use std::sync::Arc;

use serde::{Deserialize, Deserializer, Serialize, de};

use super::body::BodyDef;
use super::clearing::Clearing;
use super::gripper::Gripper;
use super::library;
use super::rearrangement::{Goal, Rearrangement};
use super::state::{BodyPose, State, check_pose};
use super::workspace::Workspace;
use super::world::{Friction, Problem, Scene, SceneBuilder};
use crate::error::{Error, Result};
use crate::files::json::{located, one_line as json, parse};
use crate::files::{self, without_mark};
use crate::geom::{Pose2, Shape};

/// The version of the format that this library writes, and the only one it reads.
pub const SCENE_VERSION: u64 = 1;

#[derive(Deserialize)]
#[serde(deny_unknown_fields, expecting = "an object with `version`, `bodies` and `target`")]
struct SceneFile {
    #[serde(rename = "version")]
    _version: u64,
    #[serde(default)]
    name: String,
    bodies: Vec<BodyEntry>,
    target: Option<TargetEntry>,
    /// Everything is to be taken off the table.
    #[serde(default)]
    clear: bool,
    #[serde(default)]
    gripper: GripperEntry,
    #[serde(default)]
    workspace: Workspace,
    #[serde(default)]
    friction: Friction,
    overlap_tolerance: Option<f64>,
}

/// A body: its shape given or taken from the library, what differs from the defaults, and its pose.
#[derive(Deserialize, Serialize, Default)]
#[serde(deny_unknown_fields)]
struct BodyEntry {
    #[serde(skip_serializing_if = "Option::is_none")]
    name: Option<String>,
    #[serde(skip_serializing_if = "Option::is_none")]
    block: Option<String>,
    #[serde(skip_serializing_if = "Option::is_none")]
    shape: Option<Shape>,
    #[serde(skip_serializing_if = "Option::is_none")]
    height: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    mass: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    friction: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pickable: Option<bool>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pushable: Option<bool>,
    #[serde(skip_serializing_if = "Option::is_none")]
    centre_of_mass: Option<[f64; 2]>,
    #[serde(skip_serializing_if = "Option::is_none")]
    inertia: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    outline_tolerance: Option<f64>,
    pose: Pose2,
    #[serde(default = "yes", skip_serializing_if = "is_true")]
    present: bool,
    /// Where the body is wanted: makes the file a rearrangement.
    #[serde(skip_serializing_if = "Option::is_none")]
    goal: Option<Goal>,
}

fn yes() -> bool {
    true
}

fn is_true(value: &bool) -> bool {
    *value
}

impl BodyEntry {
    fn def(&self, index: usize) -> Result<BodyDef> {
        let field = format!("bodies[{index}]");
        let (mut def, default_name) = match (&self.block, &self.shape) {
            (Some(block), None) => {
                let def = library::block(block).map_err(|e| e.within(&field))?;
                (def, format!("{} {index}", library::canonical(block)?))
            }
            (None, Some(shape)) => (BodyDef::new(shape.clone()), String::new()),
            (Some(_), Some(_)) => return Err(Error::argument(field, "has a `block` and a `shape`; give one of them")),
            (None, None) => {
                return Err(Error::argument(field, "has neither a `block` nor a `shape`; give one of them"));
            }
        };
        def.name = self.name.clone().unwrap_or(default_name);
        def.height = self.height.unwrap_or(def.height);
        def.mass = self.mass.unwrap_or(def.mass);
        def.friction = self.friction.unwrap_or(def.friction);
        def.pickable = self.pickable.unwrap_or(def.pickable);
        def.pushable = self.pushable.unwrap_or(def.pushable);
        def.centre_of_mass = self.centre_of_mass;
        def.inertia = self.inertia;
        def.outline_tolerance = self.outline_tolerance;
        Ok(def)
    }

    /// The shortest entry that gives this body again.
    fn new(def: BodyDef, pose: Pose2, present: bool, goal: Option<Goal>) -> BodyEntry {
        let block = library::BLOCKS.into_iter().find_map(|name| {
            let block = library::block(name).ok()?;
            (block.shape == def.shape).then_some((name, block))
        });
        let (block, shape, base) = match block {
            Some((name, base)) => (Some(name.to_owned()), None, base),
            None => (None, Some(def.shape.clone()), BodyDef::new(def.shape)),
        };
        BodyEntry {
            name: Some(def.name),
            block,
            shape,
            height: (def.height != base.height).then_some(def.height),
            mass: (def.mass != base.mass).then_some(def.mass),
            friction: (def.friction != base.friction).then_some(def.friction),
            pickable: (def.pickable != base.pickable).then_some(def.pickable),
            pushable: (def.pushable != base.pushable).then_some(def.pushable),
            centre_of_mass: def.centre_of_mass,
            inertia: def.inertia,
            outline_tolerance: def.outline_tolerance,
            pose,
            present,
            goal,
        }
    }
}

/// The target by name or by index.
enum TargetEntry {
    Name(String),
    Index(usize),
}

impl<'de> Deserialize<'de> for TargetEntry {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> std::result::Result<Self, D::Error> {
        struct Visitor;
        impl de::Visitor<'_> for Visitor {
            type Value = TargetEntry;

            fn expecting(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
                f.write_str("the name or the index of a body")
            }

            fn visit_str<E: de::Error>(self, name: &str) -> std::result::Result<TargetEntry, E> {
                Ok(TargetEntry::Name(name.to_owned()))
            }

            fn visit_u64<E: de::Error>(self, index: u64) -> std::result::Result<TargetEntry, E> {
                // An index too large for the machine is too large for any scene.
                Ok(TargetEntry::Index(usize::try_from(index).unwrap_or(usize::MAX)))
            }
        }
        deserializer.deserialize_any(Visitor)
    }
}

/// A gripper of the library by name, or all its measures.
enum GripperEntry {
    Name(String),
    Full(Box<Gripper>),
}

impl Default for GripperEntry {
    fn default() -> Self {
        GripperEntry::Full(Box::default())
    }
}

impl<'de> Deserialize<'de> for GripperEntry {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> std::result::Result<Self, D::Error> {
        struct Visitor;
        impl<'de> de::Visitor<'de> for Visitor {
            type Value = GripperEntry;

            fn expecting(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
                f.write_str("the name of a gripper or an object of its measures")
            }

            fn visit_str<E: de::Error>(self, name: &str) -> std::result::Result<GripperEntry, E> {
                Ok(GripperEntry::Name(name.to_owned()))
            }

            fn visit_map<A: de::MapAccess<'de>>(self, map: A) -> std::result::Result<GripperEntry, A::Error> {
                Gripper::deserialize(de::value::MapAccessDeserializer::new(map))
                    .map(|gripper| GripperEntry::Full(Box::new(gripper)))
            }
        }
        deserializer.deserialize_any(Visitor)
    }
}

impl SceneFile {
    /// The table: bodies, where they are, and what surrounds them.
    fn table(&mut self) -> Result<(Arc<Scene>, State)> {
        let mut builder = SceneBuilder::new();
        let mut state = State::new(self.bodies.iter().map(|b| b.pose));
        for (i, body) in self.bodies.iter().enumerate() {
            check_pose(&format!("bodies[{i}].pose"), &body.pose)?;
            builder.add_body(body.def(i)?)?;
            if !body.present {
                state.set_present(i, false);
            }
        }
        builder.workspace(self.workspace).friction(self.friction);
        builder.gripper(match std::mem::take(&mut self.gripper) {
            GripperEntry::Name(name) => Gripper::by_name(&name)?,
            GripperEntry::Full(gripper) => *gripper,
        });
        if let Some(tolerance) = self.overlap_tolerance {
            builder.overlap_tolerance(tolerance);
        }
        Ok((Arc::new(builder.build()?), state))
    }

    fn problem(mut self) -> Result<Problem> {
        if self.clear {
            return Err(Error::argument(
                "clear",
                "belongs to a clearing problem, which has no target; plan with greedy",
            ));
        }
        if self.target.is_none() {
            return Err(Error::argument(
                "scene",
                "missing field `target`, the body to retrieve, or a `goal` of a body, or `clear`",
            ));
        }
        if let Some(i) = self.bodies.iter().position(|body| body.goal.is_some()) {
            let reason =
                "belongs to a rearrangement, not to a retrieval problem; leave out the goals, or plan with rearrange";
            return Err(Error::argument(format!("bodies[{i}].goal"), reason));
        }
        let (scene, state) = self.table()?;
        let target = match self.target {
            Some(TargetEntry::Index(index)) => index,
            Some(TargetEntry::Name(name)) => scene.find(&name).ok_or_else(|| {
                let known: Vec<_> = scene.bodies().iter().map(|b| b.name.as_str()).collect();
                Error::not_found("target", format!("no body is named `{name}`; the bodies are {}", known.join(", ")))
            })?,
            None => usize::MAX,
        };
        Problem::new(self.name, scene, state, target)
    }

    fn clearing(mut self) -> Result<Clearing> {
        if !self.clear {
            return Err(Error::argument("clear", "is not true; everything is to be taken off the table where it is"));
        }
        if self.target.is_some() {
            return Err(Error::argument("target", "belongs to a retrieval problem; with `clear` every body is one"));
        }
        if let Some(i) = self.bodies.iter().position(|body| body.goal.is_some()) {
            let reason = "belongs to a rearrangement; with `clear` the bodies are taken away";
            return Err(Error::argument(format!("bodies[{i}].goal"), reason));
        }
        let (scene, state) = self.table()?;
        Clearing::new(self.name, scene, state)
    }

    fn rearrangement(mut self) -> Result<Rearrangement> {
        if self.target.is_some() {
            return Err(Error::argument("target", "belongs to a retrieval problem; a rearrangement has goals instead"));
        }
        let (scene, state) = self.table()?;
        let goals: Vec<Option<Goal>> = self.bodies.iter().map(|body| body.goal).collect();
        if goals.iter().all(Option::is_none) {
            return Err(Error::argument("bodies", "none has a `goal`; a rearrangement needs at least one"));
        }
        Rearrangement::new(self.name, scene, state, goals)
    }
}

/// What every version of the format has.
#[derive(Deserialize)]
#[serde(expecting = "an object with `version`, `bodies` and `target`")]
struct Versioned {
    version: Option<u64>,
}

/// What a scene's document is called where no field is.
const WHOLE: &str = "scene";

/// An error with its place in the file, where the poses and goals of a problem are written with the bodies.
fn placed(text: &str, error: Error) -> Error {
    let of_body = |field: &str, list: &str, entry: &str| {
        let (index, rest) = field.strip_prefix(list)?.strip_prefix('[')?.split_once(']')?;
        Some(format!("bodies[{index}].{entry}{rest}"))
    };
    let rename =
        |field: String| of_body(&field, "poses", "pose").or_else(|| of_body(&field, "goals", "goal")).unwrap_or(field);
    let error = match error {
        Error::Argument { field, reason } => Error::Argument { field: rename(field), reason },
        other => other,
    };
    located(text, error)
}

/// A pose whose numbers are the shortest that give the stored ones again.
fn short_pose(pose: &BodyPose) -> Pose2 {
    let short = |stored: f32| {
        // The shortest decimal for single precision, unless rounding it twice on the way back would go wrong.
        let decimal = stored.to_string().parse::<f64>().unwrap_or(f64::from(stored));
        if decimal as f32 == stored { decimal } else { f64::from(stored) }
    };
    Pose2::new(short(pose.x), short(pose.y), short(pose.theta))
}

fn check_finite(state: &State) -> Result<()> {
    for (i, pose) in state.poses().iter().enumerate() {
        if !Pose2::from(*pose).is_finite() {
            return Err(Error::argument(format!("poses[{i}]"), "is not finite and cannot be written"));
        }
    }
    Ok(())
}

/// The bodies of a scene with their poses, one a line.
fn body_lines(scene: &Scene, state: &State, goals: &[Option<Goal>]) -> Result<String> {
    let lines: Result<Vec<String>> = scene
        .bodies()
        .iter()
        .zip(state.poses())
        .enumerate()
        .map(|(i, (body, pose))| {
            let entry =
                BodyEntry::new(body.def(), short_pose(pose), state.is_present(i), goals.get(i).copied().flatten());
            Ok(format!("    {}", json(&entry)?))
        })
        .collect();
    Ok(lines?.join(",\n"))
}

/// Reads a file by `of`. A problem without a name is named after the file.
fn read_named<T>(path: &Path, of: impl Fn(&str) -> Result<T>, name: impl Fn(&mut T) -> &mut String) -> Result<T> {
    let mut problem = of(&files::read_text(path)?).map_err(|e| Error::format(path, e))?;
    let name = name(&mut problem);
    if name.is_empty() {
        *name = files::stem(path);
    }
    Ok(problem)
}

impl Problem {
    /// Reads a scene file. A file that gives no name is named after itself.
    pub fn read(path: impl AsRef<Path>) -> Result<Problem> {
        read_named(path.as_ref(), Problem::from_json, |problem| &mut problem.name)
    }

    /// Writes a scene file; what is read back is equal bit for bit.
    pub fn write(&self, path: impl AsRef<Path>) -> Result<()> {
        files::write(path, self.to_json()?)
    }

    /// Reads the text of a scene file. Errors name the field, and the line and column where it stands.
    pub fn from_json(text: &str) -> Result<Problem> {
        document(text, SceneFile::problem)
    }

    /// The text of a scene file.
    pub fn to_json(&self) -> Result<String> {
        let target = format!("  \"target\": {},\n", json(&self.scene.body(self.target).name)?);
        file_text(&self.name, &self.scene, &self.state, &[], &target)
    }

    /// The same problem with the bodies observed anew: a pose for each, `None` for a body that is not there any more
    /// (its last pose is kept).
    pub fn with_poses(&self, poses: &[Option<Pose2>]) -> Result<Problem> {
        if poses.len() != self.scene.len() {
            let reason = format!("has {} poses for {} bodies; give one for each", poses.len(), self.scene.len());
            return Err(Error::argument("poses", reason));
        }
        let mut state = self.state.clone();
        for (i, pose) in poses.iter().enumerate() {
            state.set_present(i, pose.is_some());
            if let Some(pose) = pose {
                state.set_pose(i, *pose);
            }
        }
        Problem::new(self.name.clone(), self.scene.clone(), state, self.target)
    }

    /// [`with_poses`](Self::with_poses) from JSON: `[{"x": 0.5, "y": 0, "theta": 0}, null, ...]`.
    pub fn with_poses_json(&self, text: &str) -> Result<Problem> {
        let poses: Vec<Option<Pose2>> = parse(text, "poses").map_err(|e| match e {
            Error::Argument { field, reason } if field.starts_with('[') => {
                Error::Argument { field: format!("poses{field}"), reason }
            }
            Error::Argument { reason, .. } => Error::argument("poses", reason),
            other => other,
        })?;
        self.with_poses(&poses)
    }
}

/// Makes something of the text of a file; errors name the field and its place.
fn document<T>(text: &str, make: impl FnOnce(SceneFile) -> Result<T>) -> Result<T> {
    let text = without_mark(text).unwrap_or(text);
    make(checked(text)?).map_err(|e| placed(text, e))
}

/// Parses a file after looking at its version.
fn checked(text: &str) -> Result<SceneFile> {
    let version = match parse::<Versioned>(text, WHOLE)?.version {
        Some(SCENE_VERSION) => None,
        Some(other) => Some(format!("is {other}; this library reads version {SCENE_VERSION}")),
        None => Some(format!("is missing; write `\"version\": {SCENE_VERSION}`")),
    };
    match version {
        Some(reason) => Err(located(text, Error::argument("version", reason))),
        None => parse::<SceneFile>(text, WHOLE),
    }
}

/// The text of a file; `target` is the line that only retrieval problems have.
fn file_text(name: &str, scene: &Scene, state: &State, goals: &[Option<Goal>], target: &str) -> Result<String> {
    check_finite(state)?;
    let gripper = match Gripper::by_name(&scene.gripper().name) {
        Ok(known) if known == *scene.gripper() => json(&known.name)?,
        _ => json(scene.gripper())?,
    };
    Ok(format!(
        "{{\n  \"version\": {SCENE_VERSION},\n  \"name\": {},\n  \"bodies\": [\n{}\n  ],\n{target}  \
         \"gripper\": {gripper},\n  \"workspace\": {},\n  \"friction\": {},\n  \"overlap_tolerance\": {}\n}}\n",
        json(name)?,
        body_lines(scene, state, goals)?,
        json(scene.workspace())?,
        json(scene.friction())?,
        json(&scene.overlap_tolerance())?,
    ))
}

/// A problem as a file has it: what to retrieve, how to arrange, or a table to clear.
#[derive(Debug, Clone)]
pub enum AnyProblem {
    Retrieval(Problem),
    Rearrangement(Rearrangement),
    Clearing(Clearing),
}

impl AnyProblem {
    pub(super) fn name_mut(&mut self) -> &mut String {
        match self {
            AnyProblem::Retrieval(problem) => &mut problem.name,
            AnyProblem::Rearrangement(problem) => &mut problem.name,
            AnyProblem::Clearing(problem) => &mut problem.name,
        }
    }

    /// Reads a scene file. A file that gives no name is named after itself.
    pub fn read(path: impl AsRef<Path>) -> Result<AnyProblem> {
        read_named(path.as_ref(), AnyProblem::from_json, AnyProblem::name_mut)
    }

    /// Reads the text of a scene file: a clearing if it says so, a rearrangement if a body has a goal, else a retrieval
    /// problem.
    pub fn from_json(text: &str) -> Result<AnyProblem> {
        document(text, |file| {
            let rearranges = file.bodies.iter().any(|body| body.goal.is_some());
            if file.clear {
                file.clearing().map(AnyProblem::Clearing)
            } else if rearranges {
                file.rearrangement().map(AnyProblem::Rearrangement)
            } else {
                file.problem().map(AnyProblem::Retrieval)
            }
        })
    }
}

impl Rearrangement {
    /// Reads a scene file with goals. A file that gives no name is named after itself.
    pub fn read(path: impl AsRef<Path>) -> Result<Rearrangement> {
        read_named(path.as_ref(), Rearrangement::from_json, |problem| &mut problem.name)
    }

    /// Writes a scene file; what is read back is equal bit for bit.
    pub fn write(&self, path: impl AsRef<Path>) -> Result<()> {
        files::write(path, self.to_json()?)
    }

    /// Reads the text of a scene file with goals. Errors name the field, and the line and column where it stands.
    pub fn from_json(text: &str) -> Result<Rearrangement> {
        document(text, SceneFile::rearrangement)
    }

    /// The text of a scene file.
    pub fn to_json(&self) -> Result<String> {
        file_text(&self.name, &self.scene, &self.start, &self.goals, "")
    }
}

impl Clearing {
    /// Reads a scene file with `clear`. A file that gives no name is named after itself.
    pub fn read(path: impl AsRef<Path>) -> Result<Clearing> {
        read_named(path.as_ref(), Clearing::from_json, |problem| &mut problem.name)
    }

    /// Writes a scene file; what is read back is equal bit for bit.
    pub fn write(&self, path: impl AsRef<Path>) -> Result<()> {
        files::write(path, self.to_json()?)
    }

    /// Reads the text of a scene file with `clear`. Errors name the field, and the line and column where it stands.
    pub fn from_json(text: &str) -> Result<Clearing> {
        document(text, SceneFile::clearing)
    }

    /// The text of a scene file.
    pub fn to_json(&self) -> Result<String> {
        file_text(&self.name, &self.scene, &self.state, &[], "  \"clear\": true,\n")
    }
}

impl State {
    /// The poses as [`Problem::with_poses_json`] reads them: `null` for a body that is not present.
    pub fn to_json(&self) -> Result<String> {
        check_finite(self)?;
        let poses: Vec<Option<Pose2>> =
            self.poses().iter().enumerate().map(|(i, p)| self.is_present(i).then(|| short_pose(p))).collect();
        json(&poses)
    }
}

#[cfg(test)]
#[path = "file_tests.rs"]
mod tests;
