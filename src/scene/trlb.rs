//! The arrangements of the TRLB experiments (Gao, Lau, Huang, Bekris, Yu 2021): equal discs or equal sticks on a table
//! of 1000 x 1000 units, taken as a metre each way.
//!
//! A file is one arrangement. Two of a folder make an instance: object k goes from entry k of the one to entry k of the
//! other, by overhand pick-and-place only.

use std::path::Path;
use std::sync::Arc;

use serde::Deserialize;

use super::body::BodyDef;
use super::rearrangement::{Goal, Rearrangement};
use super::state::State;
use super::workspace::{LeaveRule, Workspace};
use super::world::SceneBuilder;
use crate::error::{Error, Result};
use crate::geom::{Pose2, Shape, vec2};

/// Units of the files in a metre.
const UNITS: f64 = 1000.0;

#[derive(Deserialize)]
struct Arrangement {
    #[serde(rename = "Object_Shape")]
    shape: String,
    #[serde(rename = "Object_Radius")]
    radius: Option<f64>,
    #[serde(rename = "Object_Length")]
    length: Option<f64>,
    #[serde(rename = "Object_Width")]
    width: Option<f64>,
    #[serde(rename = "Workspace_Width")]
    workspace_width: f64,
    #[serde(rename = "Workspace_Height")]
    workspace_height: f64,
    point_list: Vec<Vec<f64>>,
}

impl Arrangement {
    fn read(path: &Path) -> Result<Arrangement> {
        let text = std::fs::read_to_string(path).map_err(|e| Error::io(path, e))?;
        serde_json::from_str(&text).map_err(|e| Error::format(path, e))
    }

    fn shape(&self) -> Result<Shape> {
        match (self.shape.as_str(), self.radius, self.length, self.width) {
            ("disc", Some(radius), ..) => Ok(Shape::Disc { radius: radius / UNITS }),
            ("cuboid", _, Some(length), Some(width)) => Ok(Shape::rectangle(length / UNITS, width / UNITS)),
            (shape, ..) => Err(Error::argument("Object_Shape", format!("`{shape}` is unknown or lacks its measures"))),
        }
    }

    fn poses(&self) -> Result<Vec<Pose2>> {
        let pose = |(i, point): (usize, &Vec<f64>)| match point.as_slice() {
            [x, y] => Ok(Pose2::new(x / UNITS, y / UNITS, 0.0)),
            [x, y, theta] => Ok(Pose2::new(x / UNITS, y / UNITS, *theta)),
            _ => Err(Error::argument(format!("point_list[{i}]"), "must have two or three numbers")),
        };
        self.point_list.iter().enumerate().map(pose).collect()
    }
}

/// The instance from one arrangement to another.
pub fn read_pair(from: impl AsRef<Path>, to: impl AsRef<Path>) -> Result<Rearrangement> {
    let (from_path, to_path) = (from.as_ref(), to.as_ref());
    let (from, to) = (Arrangement::read(from_path)?, Arrangement::read(to_path)?);
    let name = |path: &Path| path.file_stem().map(|s| s.to_string_lossy().into_owned()).unwrap_or_default();
    let name = format!("{}-{}", name(from_path), name(to_path));
    instance(name, &from, &to).map_err(|e| Error::format(to_path, e))
}

fn instance(name: String, from: &Arrangement, to: &Arrangement) -> Result<Rearrangement> {
    let shape = from.shape()?;
    let same = to.shape()? == shape && to.point_list.len() == from.point_list.len();
    if !same {
        return Err(Error::argument("point_list", "the two arrangements are not of the same objects"));
    }
    let mut builder = SceneBuilder::new();
    for _ in &from.point_list {
        let def = BodyDef { pushable: false, ..BodyDef::new(shape.clone()) };
        builder.add_body(def)?;
    }
    let far = vec2(from.workspace_width / UNITS, from.workspace_height / UNITS);
    let mut workspace = Workspace::rectangle(vec2(0.0, 0.0), far);
    workspace.leave_rule = LeaveRule::Footprint;
    builder.workspace(workspace);
    let symmetry = if matches!(shape, Shape::Disc { .. }) { 0 } else { 2 };
    let goals = to.poses()?.into_iter().map(|pose| Some(Goal { symmetry, ..Goal::at(pose) })).collect();
    Rearrangement::new(name, Arc::new(builder.build()?), State::new(from.poses()?), goals)
}

/// The published pairs of a folder: 0 to 1, 2 to 3 and so on. Instances are named after the folder too.
pub fn read_folder(folder: impl AsRef<Path>) -> Result<Vec<Rearrangement>> {
    let folder = folder.as_ref();
    let mut instances = Vec::new();
    // `D=0.3/n=10` says more than either alone.
    let parts: Vec<_> = folder.components().rev().take(2).map(|c| c.as_os_str().to_string_lossy()).collect();
    let prefix = parts.iter().rev().map(|p| p.as_ref()).collect::<Vec<_>>().join("/");
    for first in (0..).step_by(2) {
        let path = |number: usize| folder.join(format!("{number}.json"));
        if !path(first + 1).exists() {
            break;
        }
        let mut instance = read_pair(path(first), path(first + 1))?;
        instance.name = format!("{prefix}/{}", instance.name);
        instances.push(instance);
    }
    Ok(instances)
}

/// Whether a folder holds such arrangements.
pub fn is_folder(folder: impl AsRef<Path>) -> bool {
    std::fs::read_to_string(folder.as_ref().join("0.json")).is_ok_and(|text| text.contains("\"point_list\""))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::testing::shared;

    #[test]
    fn every_published_pair_is_a_problem() {
        let mut pairs = 0;
        for folder in ["disk/D=0.3/n=10", "disk/D=0.3/n=20", "disk/D=0.5/n=6", "stick/D=0.2/n=5", "stick/D=0.3/n=10"] {
            let Some(path) = shared(&format!("cases/trlb/{folder}")) else { return };
            assert!(is_folder(&path));
            for problem in read_folder(&path).unwrap() {
                assert_eq!(problem.scene.len().to_string(), folder.rsplit('=').next().unwrap());
                assert!(problem.scene.bodies().iter().all(|b| b.pickable && !b.pushable));
                pairs += 1;
            }
        }
        assert_eq!(pairs, 25);
    }

    #[test]
    fn arrangements_of_different_objects_are_refused() {
        let text = |radius: f64| {
            format!(
                r#"{{"Object_Shape": "disc", "Object_Radius": {radius}, "Workspace_Width": 1000, "Workspace_Height": 1000,
                "point_list": [[300, 300]]}}"#
            )
        };
        let read = |radius| serde_json::from_str::<Arrangement>(&text(radius)).unwrap();
        assert!(instance("a".into(), &read(50.0), &read(50.0)).is_ok());
        let error = instance("a".into(), &read(50.0), &read(60.0)).unwrap_err();
        assert!(error.to_string().starts_with("point_list"), "{error}");
        let error = instance("a".into(), &read(400.0), &read(400.0)).unwrap_err();
        assert!(error.to_string().contains("out of the workspace"), "{error}");
    }
}
