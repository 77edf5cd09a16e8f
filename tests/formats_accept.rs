//! What the entrances for other people's data accept (case files, arrangements of TRLB, recorded pushes, images of labels), a
//! scene file accepts too; and what they refuse has an error that says where. Every number of a format is varied.

use std::collections::BTreeMap;
use std::path::PathBuf;
use std::sync::Arc;

use jostle::bounds;
use jostle::error::{Error, Result};
use jostle::eval::read_recordings;
use jostle::run::{Key, Stream};
use jostle::scene::arc::{self, ArcProfile};
use jostle::scene::library::BlockConvention;
use jostle::scene::{AnyProblem, Clearing, SceneBuilder, State, Workspace, trlb};
use jostle::vision::{Image, PixelMap, ShapeFinder, ShapeOptions};
use serde_json::{Value, json};

/// A folder for the files of this test.
struct Folder(PathBuf);

impl Folder {
    fn write(&self, name: &str, document: &Value) -> PathBuf {
        let path = self.0.join(name);
        std::fs::write(&path, document.to_string()).unwrap();
        path
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        let _ = std::fs::remove_dir_all(&self.0);
    }
}

/// A number of a format, by name, and what reads the format with that value: the answer is what was read as the text of a
/// scene file. Without an answer the format has no way to write the number.
type Slot = (&'static str, fn(&Folder, f64) -> Option<Result<String>>);

const SLOTS: &[Slot] = &[
    ("case: x", |_, v| Some(case(v, 90.0, 0.0))),
    ("case: y", |_, v| Some(case(0.5, v, 0.0))),
    ("case: yaw", |_, v| Some(case(0.5, 0.1, v))),
    ("TRLB: Object_Radius", |f, v| arrangement(f, |d| d["Object_Radius"] = json!(v))),
    ("TRLB: Workspace_Width", |f, v| arrangement(f, |d| d["Workspace_Width"] = json!(v))),
    ("TRLB: point_list", |f, v| arrangement(f, |d| d["point_list"][1][0] = json!(v))),
    ("recording: mass", |f, v| recording(f, |d| d["shapes"][0]["mass"] = json!(v))),
    ("recording: izz", |f, v| recording(f, |d| d["shapes"][0]["izz"] = json!(v))),
    ("recording: pieces", |f, v| recording(f, |d| d["shapes"][0]["pieces"][0][1][0] = json!(v))),
    ("recording: before", |f, v| recording(f, |d| d["before"][0][1] = json!(v))),
    ("recording: heading", |f, v| recording(f, |d| d["before"][0][2] = json!(v))),
    ("recording: tip.w", |f, v| recording(f, |d| d["tip"]["w"] = json!(v))),
    ("recording: push", |f, v| recording(f, |d| d["push"][2] = json!(v))),
    ("image: pixel", |_, v| Some(image([v, 0.0, 0.3], [0.0, v, 0.0], 0.04))),
    ("image: origin", |_, v| Some(image([0.002, 0.0, v], [0.0, 0.002, 0.0], 0.04))),
    ("image: height", |_, v| Some(image([0.002, 0.0, 0.3], [0.0, 0.002, 0.0], v))),
];

fn case(x: f64, y: f64, yaw: f64) -> Result<String> {
    let text = format!("cube 0 0 0 0.5 0.0 0.0235 0 0 0\ncube 0 0 0 {x:e} {y:e} 0.0235 0 0 {yaw:e}");
    arc::parse(&text, "case", ArcProfile::More, BlockConvention::Simulator)?.problem.to_json()
}

/// None where the changed document has a null, which is what JSON has for a number that is none.
fn changed(mut document: Value, change: impl Fn(&mut Value)) -> Option<Value> {
    change(&mut document);
    (!document.to_string().contains("null")).then_some(document)
}

fn arrangement(folder: &Folder, change: impl Fn(&mut Value)) -> Option<Result<String>> {
    let document = json!({
        "Object_Shape": "disc", "Object_Radius": 40.0, "Workspace_Width": 1000.0, "Workspace_Height": 1000.0,
        "point_list": [[200.0, 300.0], [500.0, 800.0]],
    });
    let document = changed(document, change)?;
    let (from, to) = (folder.write("0.json", &document), folder.write("1.json", &document));
    Some(trlb::read_pair(from, to).and_then(|problem| problem.to_json()))
}

fn recording(folder: &Folder, change: impl Fn(&mut Value)) -> Option<Result<String>> {
    let document = json!({
        "push": [0.4, 0.0, 0.5, 0.0], "tip": {"w": 0.02, "t": 0.01},
        "shapes": [{"pieces": [[[-0.02, -0.02], [0.02, -0.02], [0.02, 0.02], [-0.02, 0.02]]], "mass": 0.1, "izz": 3e-5}],
        "before": [[0.5, 0.0, 0.0]], "after": [[0.55, 0.0, 0.0]],
    });
    let path = folder.write("pushes.jsonl", &changed(document, change)?);
    let read = || {
        let recording = read_recordings(&path)?.remove(0);
        Clearing::new("", Arc::new(recording.scene()?), recording.state())?.to_json()
    };
    Some(read())
}

fn image(x: [f64; 3], y: [f64; 3], height: f64) -> Result<String> {
    const SIDE: usize = 40;
    let inside = |i: usize| (10..30).contains(&(i / SIDE)) && (10..25).contains(&(i % SIDE));
    let labels: Vec<u8> = (0..SIDE * SIDE).map(|i| u8::from(inside(i))).collect();
    let heights: Vec<f32> = (0..SIDE * SIDE).map(|i| if inside(i) { height as f32 } else { 0.0 }).collect();
    let (labels, heights) = (Image::packed(&labels, SIDE, SIDE)?, Image::packed(&heights, SIDE, SIDE)?);
    let shapes = ShapeFinder::new().labels(&labels, Some(&heights), &PixelMap { x, y }, &ShapeOptions::default())?;
    if shapes.bodies.is_empty() {
        return Err(Error::argument("image", format!("shows nothing: {:?}", shapes.skipped)));
    }
    let mut builder = SceneBuilder::new();
    let poses = shapes.add_to(&mut builder)?;
    builder.workspace(Workspace { min: [-90.0, -90.0], max: [90.0, 90.0], ..Workspace::default() });
    Clearing::new("", Arc::new(builder.build()?), State::new(poses))?.to_json()
}

/// Numbers of every magnitude, the ends of every bound and their neighbours in metres and in thousandths, and what is none.
fn numbers(draw: &mut Stream) -> Vec<f64> {
    let mut values = vec![0.0, -0.0, f64::NAN, f64::INFINITY, f64::NEG_INFINITY, f64::MAX, -f64::MAX, 5e-324];
    for bound in bounds::BOUNDS {
        for end in [bound.least, bound.greatest, bound.least * 1e3, bound.greatest * 1e3] {
            values.extend([end, end.next_up(), end.next_down(), -end]);
        }
    }
    for _ in 0..24 {
        let near = 10f64.powf(draw.uniform(-7.0, 4.0));
        values.extend([10f64.powf(draw.uniform(-320.0, 308.0)), near, -near]);
    }
    values
}

#[test]
fn what_other_formats_accept_a_scene_file_accepts() {
    let folder = Folder(std::env::temp_dir().join(format!("jostle-formats-{}", std::process::id())));
    std::fs::create_dir_all(&folder.0).unwrap();
    let mut draw = Key::new(20).stream();
    let mut verdicts: BTreeMap<&str, [usize; 2]> = BTreeMap::new();
    for &(name, read) in SLOTS {
        for value in numbers(&mut draw) {
            let Some(verdict) = read(&folder, value) else { continue };
            verdicts.entry(name).or_default()[usize::from(verdict.is_err())] += 1;
            match verdict {
                Ok(text) => {
                    assert!(value.is_finite(), "{name} = {value} is accepted");
                    if let Err(error) = AnyProblem::from_json(&text) {
                        panic!("{name} = {value:e} is accepted, and not by a scene file: {error}\n{text}");
                    }
                }
                Err(Error::Argument { field, reason }) => assert!(!field.is_empty(), "{name} = {value:e}: {reason}"),
                Err(error @ Error::Format { .. }) => {
                    let said = error.to_string();
                    assert!(said.contains("line 1"), "{name} = {value:e}: {said}");
                }
                Err(error) => panic!("{name} = {value:e}: {error}"),
            }
        }
    }
    println!("accepted, refused: {verdicts:?}");
    assert_eq!(verdicts.len(), SLOTS.len());
    for (name, [accepted, refused]) in verdicts {
        assert!(accepted > 0 && refused > 0, "{name}: {accepted} accepted, {refused} refused");
    }
}

/// One of the cases' own numbers is as good as it was: the test above would pass if everything but it were refused.
#[test]
fn ordinary_values_are_accepted() {
    let folder = Folder(std::env::temp_dir().join(format!("jostle-ordinary-{}", std::process::id())));
    std::fs::create_dir_all(&folder.0).unwrap();
    for (name, value) in [
        ("case: x", 0.6),
        ("case: yaw", -3.0),
        ("TRLB: Object_Radius", 35.0),
        ("TRLB: point_list", 700.0),
        ("recording: mass", 2.5),
        ("recording: pieces", 0.03),
        ("recording: before", -0.4),
        ("image: pixel", 0.003),
        ("image: height", 0.2),
    ] {
        let (_, read) = SLOTS.iter().find(|(slot, _)| *slot == name).unwrap();
        let text = read(&folder, value).unwrap().unwrap_or_else(|error| panic!("{name} = {value}: {error}"));
        AnyProblem::from_json(&text).unwrap_or_else(|error| panic!("{name} = {value}: {error}"));
    }
}
