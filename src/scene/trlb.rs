//! The arrangements of the TRLB experiments (Gao, Lau, Huang, Bekris, Yu 2021): equal discs or equal sticks on a table
//! of 1000 x 1000 units, taken as a metre each way.
//!
//! A file is one arrangement. Two of a folder make an instance: object k goes from entry k of the one to entry k of the
//! other, by overhand pick-and-place only. A file's name begins with its number: `0.json` and `1.json` are a pair, and so
//! are `0_10_0.3.json` and `1_10_0.3.json`.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use serde::Deserialize;

use super::body::{Body, BodyDef};
use super::rearrangement::{Goal, Rearrangement};
use super::state::{State, check_pose};
use super::workspace::{LeaveRule, Workspace};
use super::world::SceneBuilder;
use crate::error::{Error, Result};
use crate::files::{self, json};
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

/// An arrangement with the text it was read of, which errors point into.
struct Source<'a> {
    path: &'a Path,
    text: String,
    arrangement: Arrangement,
}

impl<'a> Source<'a> {
    fn read(path: &'a Path) -> Result<Source<'a>> {
        let text = files::read_text(path)?;
        let arrangement: Arrangement = json::parse(&text, "arrangement").map_err(|e| Error::format(path, e))?;
        let source = Source { path, text, arrangement };
        source.arrangement.check().map_err(|e| source.error(e))?;
        Ok(source)
    }

    /// An error about a field of the file with its place.
    fn error(&self, error: Error) -> Error {
        Error::format(self.path, json::located(&self.text, error))
    }
}

/// An error under the name of the file's field.
fn renamed(error: Error, field: impl FnOnce(&str) -> String) -> Error {
    match error {
        Error::Argument { field: of, reason } => Error::Argument { field: field(&of), reason },
        other => other,
    }
}

impl Arrangement {
    /// Refuses what no table and no body may be, under the names of the file.
    fn check(&self) -> Result<()> {
        let measure = if self.radius.is_some() { "Object_Radius" } else { "Object_Length" };
        Body::new(BodyDef::new(self.shape()?)).map_err(|e| renamed(e, |_| measure.into()))?;
        let side = |field: &str| if field.ends_with('x') { "Workspace_Width" } else { "Workspace_Height" };
        self.workspace().validate().map_err(|e| renamed(e, |field| side(field).into()))?;
        for (i, pose) in self.poses()?.iter().enumerate() {
            let field = format!("point_list[{i}]");
            check_pose(&field, pose).map_err(|e| renamed(e, |_| field.clone()))?;
        }
        Ok(())
    }

    fn workspace(&self) -> Workspace {
        let far = vec2(self.workspace_width / UNITS, self.workspace_height / UNITS);
        Workspace { leave_rule: LeaveRule::Footprint, ..Workspace::rectangle(vec2(0.0, 0.0), far) }
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
    let (from, to) = (Source::read(from.as_ref())?, Source::read(to.as_ref())?);
    let name = format!("{}-{}", files::stem(from.path), files::stem(to.path));
    instance(name, &from.arrangement, &to.arrangement).map_err(|error| {
        let of_from = matches!(&error, Error::Argument { field, .. } if field.starts_with("poses["));
        let error =
            renamed(error, |field| field.replacen("poses[", "point_list[", 1).replacen("goals[", "point_list[", 1));
        if of_from { from.error(error) } else { to.error(error) }
    })
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
    builder.workspace(from.workspace());
    let symmetry = if matches!(shape, Shape::Disc { .. }) { 0 } else { 2 };
    let goals = to.poses()?.into_iter().map(|pose| Some(Goal { symmetry, ..Goal::at(pose) })).collect();
    Rearrangement::new(name, Arc::new(builder.build()?), State::new(from.poses()?), goals)
}

/// Two files that make an instance, or one whose other half is missing.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Pair {
    pub from: PathBuf,
    pub to: Option<PathBuf>,
}

/// The published pairs of the arrangements in a folder: number 0 to 1, 2 to 3 and so on, of files whose names go on alike
/// behind the number.
pub fn pairs(files: impl IntoIterator<Item = PathBuf>) -> Vec<Pair> {
    let mut groups: BTreeMap<(String, u64), Vec<(u64, PathBuf)>> = BTreeMap::new();
    let mut pairs = Vec::new();
    for file in files {
        let name = files::stem(&file);
        let digits = name.bytes().take_while(u8::is_ascii_digit).count();
        match name[..digits].parse::<u64>() {
            Ok(number) => {
                groups.entry((name[digits..].to_owned(), number / 2)).or_default().push((number % 2, file));
            }
            Err(_) => pairs.push(Pair { from: file, to: None }),
        }
    }
    for mut halves in groups.into_values() {
        halves.sort();
        match <[_; 2]>::try_from(halves) {
            Ok([(0, from), (1, to)]) => pairs.push(Pair { from, to: Some(to) }),
            Ok(halves) => pairs.extend(halves.map(|(_, from)| Pair { from, to: None })),
            Err(halves) => pairs.extend(halves.into_iter().map(|(_, from)| Pair { from, to: None })),
        }
    }
    pairs
}

impl Pair {
    /// The instance, named after the folder too.
    pub fn read(&self) -> Result<Rearrangement> {
        let Some(to) = &self.to else {
            let reason = "has no other half: files 2k and 2k + 1, whose names begin with these numbers and go on alike, \
                          make an instance";
            return Err(Error::format(&self.from, reason));
        };
        let mut instance = read_pair(&self.from, to)?;
        // `D=0.3/n=10` says more than either alone.
        let folder = self.from.parent().unwrap_or(Path::new(""));
        let parts: Vec<_> = folder.components().rev().take(2).map(|c| c.as_os_str().to_string_lossy()).collect();
        let prefix = parts.iter().rev().map(|p| p.as_ref()).collect::<Vec<_>>().join("/");
        instance.name = format!("{prefix}/{}", instance.name);
        Ok(instance)
    }
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
            let files = std::fs::read_dir(path).unwrap().map(|entry| entry.unwrap().path());
            for pair in super::pairs(files) {
                let problem = pair.read().unwrap();
                assert_eq!(problem.scene.len().to_string(), folder.rsplit('=').next().unwrap());
                assert!(problem.scene.bodies().iter().all(|b| b.pickable && !b.pushable));
                pairs += 1;
            }
        }
        assert_eq!(pairs, 25);
    }

    #[test]
    fn files_are_paired_by_the_number_that_their_names_begin_with() {
        let names =
            ["2_10_0.3", "0_10_0.3", "3_10_0.3", "1_10_0.3", "0", "1", "10", "11", "7_5_0.2", "4_10_0.3", "notes"];
        let found = pairs(names.map(|name| PathBuf::from(format!("D/{name}.json"))));
        let name = |path: &PathBuf| files::stem(path);
        let found: Vec<_> = found.iter().map(|p| (name(&p.from), p.to.as_ref().map(name))).collect();
        let wanted = [
            ("notes", None),
            ("0", Some("1")),
            ("10", Some("11")),
            ("0_10_0.3", Some("1_10_0.3")),
            ("2_10_0.3", Some("3_10_0.3")),
            ("4_10_0.3", None),
            ("7_5_0.2", None),
        ];
        assert_eq!(found, wanted.map(|(from, to)| (from.to_owned(), to.map(str::to_owned))));
    }

    /// File, line, column and field, under the names of the file.
    #[test]
    fn what_is_wrong_with_an_arrangement_has_its_field_and_place() {
        let folder = std::env::temp_dir().join(format!("jostle-trlb-{}", std::process::id()));
        std::fs::create_dir_all(&folder).unwrap();
        let (good, bad) = (folder.join("0_1_0.1.json"), folder.join("1_1_0.1.json"));
        let text = "{\"Object_Shape\": \"disc\", \"Object_Radius\": 50,\n \"Workspace_Width\": 1000, \"Workspace_Height\": \
                    1000,\n \"point_list\": [[300, 300], [500, 300]]}";
        std::fs::write(&good, text).unwrap();
        for (what, with, wanted) in [
            ("\"disc\"", "\"ring\"", "Object_Shape: `ring` is unknown or lacks its measures (line 1, column 18)"),
            (
                "50",
                "0",
                "Object_Radius: is 0; it must lie in 6e-4 to 10 m (from a square millimetre to what a table holds) \
                (line 1, column 43)",
            ),
            ("50", "\"50\"", "Object_Radius: invalid type: string \"50\", expected f64 (line 1, column 46)"),
            ("Width\": 1000", "Width\": 1e9", "Workspace_Width: is 1e6; it must lie in"),
            ("[500, 300]", "[500, 300, 1, 2]", "point_list[1]: must have two or three numbers (line 3, column 29)"),
            ("[500, 300]", "[500, 1e12]", "point_list[1]: is 1e9; it must lie in -100 to 100 m"),
            (
                "[500, 300]",
                "[1000, 300]",
                "point_list[1]: `body 1` reaches 50.0 mm out of the workspace; move it inside (line 3, column 29)",
            ),
            ("[500, 300]", "[500, 300],", "point_list: trailing comma (line 3, column "),
            ("300], ", "300]]}", "arrangement: trailing characters"),
        ] {
            std::fs::write(&bad, text.replacen(what, with, 1)).unwrap();
            let pair = &pairs([bad.clone(), good.clone()])[0];
            let error = pair.read().unwrap_err().to_string();
            let wanted = format!("{}: {wanted}", bad.display());
            assert!(error.starts_with(&wanted), "got  {error}\nwant {wanted}");
        }
        std::fs::remove_dir_all(&folder).unwrap();
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
