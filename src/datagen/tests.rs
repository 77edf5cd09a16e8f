//! What the folders hold, read with the format's own library and worked out anew.

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicU32, Ordering};

use safetensors::SafeTensors;

use super::*;
use crate::action::{Grasp, Push};
use crate::error::Error;
use crate::geom::{Pose2, Shape, vec2};
use crate::grasp::{GraspParams, GraspScratch, GraspTest};
use crate::net::{Kind, LoadOptions, Model};
use crate::physics::{self, PhysicsOptions, Purpose, PushStatus};
use crate::run::Stop;
use crate::scene::{BodyDef, Friction, Gripper, PushTip, Scene, SceneBuilder, State};

const SHAPE_SEED: u64 = 1;

/// A folder that goes with the value.
struct Folder(PathBuf);

impl Folder {
    fn new() -> Folder {
        static NEXT: AtomicU32 = AtomicU32::new(0);
        let name = format!("jostle-datagen-{}-{}", std::process::id(), NEXT.fetch_add(1, Ordering::Relaxed));
        Folder(std::env::temp_dir().join(name))
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        let _ = std::fs::remove_dir_all(&self.0);
    }
}

fn family() -> Arc<ShapeFamily> {
    Arc::new(ShapeFamily::new(SHAPE_SEED, 120).unwrap())
}

fn planar() -> PhysicsOptions {
    PhysicsOptions::named("planar", Some("fast"), Purpose::Planning).unwrap()
}

fn store(count: usize, shard: usize, threads: usize) -> StoreParams {
    StoreParams { count, shard, seed: 5, threads }
}

fn pushes(folder: &Path, to: &StoreParams) -> crate::Result<Manifest> {
    push(&PushParams::new(planar()), &family(), SHAPE_SEED, folder, to, &Stop::never(), &mut |_| ())
}

fn values(folder: &Path, to: &StoreParams) -> crate::Result<Manifest> {
    let params = PpnParams { iterations: 60, ..PpnParams::new()? };
    ppn(&params, &family(), SHAPE_SEED, folder, to, &Stop::never(), &mut |_| ())
}

fn grasps(folder: &Path, to: &StoreParams) -> crate::Result<Manifest> {
    grasp(&GraspDataParams::default(), &family(), SHAPE_SEED, folder, to, &Stop::never(), &mut |_| ())
}

fn labels(folder: &Path, to: &StoreParams) -> crate::Result<Manifest> {
    segment(&SegmentParams::default(), &family(), SHAPE_SEED, folder, to, &Stop::never(), &mut |_| ())
}

/// Every file of the folder with its bytes, by name.
fn files(folder: &Path) -> Vec<(String, Vec<u8>)> {
    let mut files: Vec<_> = std::fs::read_dir(folder)
        .unwrap()
        .map(|entry| {
            let entry = entry.unwrap();
            (entry.file_name().into_string().unwrap(), std::fs::read(entry.path()).unwrap())
        })
        .collect();
    files.sort();
    files
}

/// A shard read with the format's own library.
struct Shard(Vec<u8>);

impl Shard {
    fn read(folder: &Path, name: &str) -> Shard {
        Shard(std::fs::read(folder.join(name)).unwrap())
    }

    fn bytes(&self, name: &str) -> (Vec<usize>, Vec<u8>) {
        let file = SafeTensors::deserialize(&self.0).unwrap();
        let tensor = file.tensor(name).unwrap();
        (tensor.shape().to_vec(), tensor.data().to_vec())
    }

    fn real(&self, name: &str) -> Vec<f32> {
        self.bytes(name).1.chunks(4).map(|b| f32::from_le_bytes(b.try_into().unwrap())).collect()
    }

    fn long(&self, name: &str) -> Vec<i64> {
        self.bytes(name).1.chunks(8).map(|b| i64::from_le_bytes(b.try_into().unwrap())).collect()
    }

    fn word(&self, name: &str) -> Vec<u32> {
        self.bytes(name).1.chunks(4).map(|b| u32::from_le_bytes(b.try_into().unwrap())).collect()
    }

    fn index(&self, name: &str) -> Vec<u16> {
        self.bytes(name).1.chunks(2).map(|b| u16::from_le_bytes(b.try_into().unwrap())).collect()
    }

    fn byte(&self, name: &str) -> Vec<u8> {
        self.bytes(name).1
    }
}

/// The shapes of a folder, out of its own file.
fn shapes(folder: &Path) -> Vec<Shape> {
    let bytes = std::fs::read(folder.join(SHAPES)).unwrap();
    let (_, header) = SafeTensors::read_metadata(&bytes).unwrap();
    let notes = header.metadata().clone().unwrap();
    assert_eq!(notes["format"], "jostle/shapes/1");
    serde_json::from_str(&notes["shapes"]).unwrap()
}

/// The scene and state of a row, made of what the files hold and nothing else.
fn rebuilt(folder: &Path, shard: &Shard, row: usize, pose_name: &str) -> (Arc<Scene>, State) {
    let shapes = shapes(folder);
    let offsets = Shard::read(folder, SHAPES).real("offset");
    let (n, shape, pose, body) = (shard.byte("n"), shard.index("shape"), shard.real(pose_name), shard.real("body"));
    let has_tip = SafeTensors::deserialize(&shard.0).unwrap().tensor("tip").is_ok();
    let tip = if has_tip { shard.real("tip")[row * 3..][..3].to_vec() } else { vec![0.03, 0.022, 0.45] };
    let mut builder = SceneBuilder::new();
    let mut poses = Vec::new();
    for i in row * WIDTH..row * WIDTH + usize::from(n[row]) {
        let mut def = BodyDef::new(shapes[usize::from(shape[i])].clone());
        let [mass, ground, surfaces, height] = [0, 1, 2, 3].map(|k| f64::from(body[i * 4 + k]));
        def.friction = surfaces.sqrt();
        (def.mass, def.height) = (mass, height);
        builder.friction(Friction { ground: ground / def.friction, tip: f64::from(tip[2]) / def.friction });
        builder.add_body(def).unwrap();
        let theta = f64::from(pose[i * 3 + 2]);
        let offset = [0, 1].map(|k| f64::from(offsets[usize::from(shape[i]) * 2 + k]));
        let turned = Pose2::new(0.0, 0.0, theta).transform_point(vec2(offset[0], offset[1]));
        poses.push(Pose2::new(f64::from(pose[i * 3]) - turned.x, f64::from(pose[i * 3 + 1]) - turned.y, theta));
    }
    let push = PushTip { width: f64::from(tip[0]), thickness: f64::from(tip[1]), ..PushTip::default() };
    builder.gripper(Gripper { push, ..Gripper::robotiq_2f85() });
    (Arc::new(builder.build().unwrap()), State::new(poses))
}

#[test]
fn threads_change_no_byte_of_a_folder() {
    type Make = fn(&Path, &StoreParams) -> crate::Result<Manifest>;
    let kinds: [(Make, usize); 4] = [(pushes, 100), (values, 6), (grasps, 40), (labels, 10)];
    for (make, count) in kinds {
        let (one, two) = (Folder::new(), Folder::new());
        let manifest = make(&one.0, &store(count, count / 2, 1)).unwrap();
        assert_eq!(make(&two.0, &store(count, count / 2, 2)).unwrap(), manifest);
        assert_eq!(manifest.shards.iter().map(|s| s.count).collect::<Vec<_>>(), [count / 2, count / 2]);
        let (a, b) = (files(&one.0), files(&two.0));
        // Two shards, the shapes, the manifest.
        assert_eq!(a.len(), 4, "{}", manifest.kind);
        assert!(a == b, "{}", manifest.kind);
    }
}

#[test]
fn a_folder_is_completed_and_whole_shards_are_kept() {
    let (whole, parts) = (Folder::new(), Folder::new());
    let manifest = pushes(&whole.0, &store(90, 40, 1)).unwrap();
    assert_eq!(manifest.shards.iter().map(|s| s.count).collect::<Vec<_>>(), [40, 40, 10]);
    // First a smaller folder, whose last shard is not whole; then a shard is damaged and one is lost.
    pushes(&parts.0, &store(50, 40, 1)).unwrap();
    assert_eq!(pushes(&parts.0, &store(90, 40, 1)).unwrap(), manifest);
    std::fs::write(parts.0.join("push-00000.safetensors"), b"damaged").unwrap();
    std::fs::remove_file(parts.0.join("push-00002.safetensors")).unwrap();
    let kept = std::fs::metadata(parts.0.join("push-00001.safetensors")).unwrap().modified().unwrap();
    assert_eq!(pushes(&parts.0, &store(90, 40, 1)).unwrap(), manifest);
    assert_eq!(std::fs::metadata(parts.0.join("push-00001.safetensors")).unwrap().modified().unwrap(), kept);
    assert!(files(&whole.0) == files(&parts.0));
}

#[test]
fn a_folder_of_other_data_is_refused_by_name() {
    let folder = Folder::new();
    pushes(&folder.0, &store(20, 20, 1)).unwrap();
    let other_seed = StoreParams { seed: 6, ..store(20, 20, 1) };
    for (result, wanted) in [
        (pushes(&folder.0, &other_seed), "another seed"),
        (pushes(&folder.0, &store(20, 10, 1)), "another shard size"),
        (labels(&folder.0, &store(20, 20, 1)), "another format, configuration"),
    ] {
        let error = result.unwrap_err();
        assert!(matches!(error, Error::Format { .. }) && error.to_string().contains(wanted), "{error}");
    }
    for (to, field) in [(store(0, 10, 1), "count: is 0"), (store(10, 70_000, 1), "shard: is 70000")] {
        assert!(pushes(&folder.0, &to).unwrap_err().to_string().starts_with(field));
    }
}

#[test]
fn a_requested_stop_leaves_whole_shards() {
    let (folder, whole) = (Folder::new(), Folder::new());
    let cancel = crate::run::CancelToken::new();
    let stop = crate::run::Budget::default().start(std::slice::from_ref(&cancel));
    let manifest =
        push(&PushParams::new(planar()), &family(), SHAPE_SEED, &folder.0, &store(90, 30, 1), &stop, &mut |made| {
            if made.rows >= 30 {
                cancel.trigger();
            }
        })
        .unwrap();
    assert!(!manifest.shards.is_empty() && manifest.shards.len() < 3, "{}", manifest.shards.len());
    pushes(&folder.0, &store(90, 30, 1)).unwrap();
    pushes(&whole.0, &store(90, 30, 1)).unwrap();
    assert!(files(&folder.0) == files(&whole.0));
}

#[test]
fn splits_share_no_shape_and_each_has_its_part() {
    let folder = Folder::new();
    let manifest = pushes(&folder.0, &store(2000, 2000, 1)).unwrap();
    let family = family();
    let shard = Shard::read(&folder.0, "push-00000.safetensors");
    let (n, shape, split, scene) = (shard.byte("n"), shard.index("shape"), shard.byte("split"), shard.long("scene"));
    let mut rows = [0; 3];
    let mut of_scene = std::collections::BTreeMap::new();
    for row in 0..n.len() {
        rows[usize::from(split[row])] += 1;
        for i in 0..usize::from(n[row]) {
            assert_eq!(family.shape(shape[row * WIDTH + i]).split as u8, split[row], "row {row}");
        }
        assert_eq!(*of_scene.entry(scene[row]).or_insert(split[row]), split[row]);
    }
    assert!(rows[0] > 1000 && rows[1] > 50 && rows[2] > 50, "{rows:?}");
    // Statistics are those of whole scenes, of which the last may reach beyond the last row.
    let counted = manifest.statistics["rows_test"] as usize;
    assert!((rows[2]..rows[2] + 24).contains(&counted), "{counted} {rows:?}");
    // The blocks of the originals may be learned from.
    let names = crate::scene::library::BLOCKS;
    assert!(names.iter().all(|name| family.shape(family.block(name).unwrap()).split == Split::Train));
    // Another seed may draw the same shape, and then it has the same split.
    let other = ShapeFamily::new(2, 400).unwrap();
    for shape in other.shapes() {
        let same = family.shapes().iter().find(|s| s.footprint.shape == shape.footprint.shape);
        assert!(same.is_none_or(|s| s.split == shape.split));
    }
}

#[test]
fn outlines_are_evenly_spaced_about_the_centre() {
    for shape in family().shapes() {
        let points = outline_points(&shape.footprint);
        let offset = shape.footprint.centroid;
        let on = |p: crate::geom::Vec2| shape.footprint.contains(&Pose2::IDENTITY, p + offset);
        for p in points {
            // On the border: inside when drawn towards the inside, outside when moved away.
            assert!(
                (0..64).any(|k| on(p + 1e-5 * vec2((0.1 * k as f64).cos(), (0.1 * k as f64).sin()))),
                "{}",
                shape.kind
            );
        }
        // The hull of the points has nearly the area: they go once round.
        let ring = crate::geom::area(&points);
        assert!(ring > 0.85 * shape.footprint.area && ring < 1.02 * shape.footprint.area, "{}", shape.kind);
    }
    let square = crate::geom::Footprint::new(Shape::rectangle(0.04, 0.04)).unwrap();
    let points = outline_points(&square);
    assert!((0..OUTLINE_POINTS).all(|k| ((points[(k + 1) % 32] - points[k]).norm() - 0.005).abs() < 1e-12));
    assert!((points[0] - square.outlines[0][0]).norm() < 1e-12);
}

#[test]
fn a_recorded_push_can_be_done_again_from_the_files_alone() {
    let folder = Folder::new();
    pushes(&folder.0, &store(60, 60, 1)).unwrap();
    let shard = Shard::read(&folder.0, "push-00000.safetensors");
    let (n, push, guess) = (shard.byte("n"), shard.real("push"), shard.real("guess"));
    let (before, after) = (shard.real("pose0"), shard.real("pose1"));
    let (mut near, mut all, mut moved) = (0, 0, 0);
    for row in 0..60 {
        let (scene, state) = rebuilt(&folder.0, &shard, row, "pose0");
        let engine = physics::engine(&planar(), Arc::clone(&scene)).unwrap();
        let [x0, y0, x1, y1] = [0, 1, 2, 3].map(|k| f64::from(push[row * 4 + k]));
        let result = engine.step(&mut engine.scratch(), &state, &Push::new(vec2(x0, y0), vec2(x1, y1)), &Stop::never());
        assert_eq!(result.status, PushStatus::Executed, "row {row}");
        for i in 0..usize::from(n[row]) {
            let at = (row * WIDTH + i) * 3;
            let centre = result.state.pose(i).transform_point(scene.body(i).footprint.centroid);
            let wanted = vec2(f64::from(after[at]), f64::from(after[at + 1]));
            let began = vec2(f64::from(before[at]), f64::from(before[at + 1]));
            let turn = crate::geom::normalize_angle(result.state.pose(i).theta - f64::from(after[at + 2])).abs();
            moved += usize::from((wanted - began).norm() > 0.005);
            near += usize::from((centre - wanted).norm() < 5e-4 && turn < 0.02);
            all += 1;
            // The engine of the guess is the one that was recorded.
            assert!((f64::from(guess[at]) - (wanted - began).x).abs() < 1e-5);
            assert!(f64::from(after[at + 2] - before[at + 2]).abs() <= std::f64::consts::PI);
        }
        let beyond = (row * WIDTH + usize::from(n[row])) * 3..(row + 1) * WIDTH * 3;
        assert!(after[beyond].iter().all(|v| *v == 0.0));
    }
    assert!(moved > 60, "{moved}");
    // Poses are stored in single precision, which decides a few close contacts differently.
    assert!(near as f64 > 0.95 * all as f64, "{near} of {all}");
}

#[test]
fn grasps_and_images_are_those_of_the_state() {
    let folder = Folder::new();
    let manifest = grasps(&folder.0, &store(60, 60, 1)).unwrap();
    let share = manifest.statistics["graspable"] / manifest.statistics["rows"];
    assert!((0.3..0.7).contains(&share), "{share}");
    let shard = Shard::read(&folder.0, "grasp-00000.safetensors");
    let (target, score, map) = (shard.byte("target"), shard.real("score"), shard.byte("label_map"));
    let (start, cell, cell_score) = (shard.long("cell_start"), shard.word("cell"), shard.real("cell_score"));
    assert_eq!(shard.bytes("label_map").0, [60, GRASP_SIZE, GRASP_SIZE]);
    let (mut agree, mut cells, mut missed) = (0, 0, 0);
    for row in 0..60 {
        let (scene, state) = rebuilt(&folder.0, &shard, row, "pose");
        let body = usize::from(target[row]);
        let test = GraspTest::new(GraspParams::default()).unwrap();
        let mut scratch = GraspScratch::default();
        let best = test.best(&scene, &state, body, &mut scratch).map_or(0.0, |g| g.score);
        agree += usize::from((best - f64::from(score[row])).abs() < 0.02);
        let centre = state.pose(body).transform_point(scene.body(body).footprint.centroid);
        // The image shows the target at its middle cells and nothing that is not there.
        for (r, c) in [(3, 90), (56, 56), (30, 40), (80, 70), (100, 5)] {
            let at = |k: usize| (k as f64 + 0.5 - GRASP_SIZE as f64 / 2.0) * GRASP_PIXEL;
            let point = centre + vec2(at(c), at(r));
            let label = map[(row * GRASP_SIZE + r) * GRASP_SIZE + c];
            // Pixels on a border may fall to either side.
            let clear = |d: crate::geom::Vec2| -> Vec<usize> {
                state.iter().filter(|(i, p)| scene.body(*i).footprint.contains(p, point + d)).map(|(i, _)| i).collect()
            };
            let here = clear(vec2(0.0, 0.0));
            let sure = [vec2(1e-4, 1e-4), vec2(-1e-4, 1e-4), vec2(1e-4, -1e-4), vec2(-1e-4, -1e-4)];
            if sure.iter().all(|d| clear(*d) == here) && here.len() < 2 {
                assert_eq!(usize::from(label), here.first().map_or(0, |i| i + 1), "row {row}, pixel {r} {c}");
            }
        }
        let range = start[row] as usize..start[row + 1] as usize;
        for k in range.clone().step_by(range.len().div_ceil(7).max(1)) {
            let index = cell[k] as usize;
            let (angle, r, c) =
                (index / (GRASP_CELLS * GRASP_CELLS), index / GRASP_CELLS % GRASP_CELLS, index % GRASP_CELLS);
            let at = |k: usize| (k as f64 + 0.5 - GRASP_CELLS as f64 / 2.0) * 2.0 * GRASP_PIXEL;
            let point = centre + vec2(at(c), at(r));
            let grasp = Grasp {
                body,
                position: [point.x, point.y],
                angle: std::f64::consts::PI * angle as f64 / GRASP_ANGLES as f64,
                opening: scene.gripper().grasp.opening,
                ..Grasp::default()
            };
            let check = test.check(&scene, &state, &grasp, &mut scratch);
            if check.margin.abs() > 1e-5 {
                assert!(
                    (check.score - f64::from(cell_score[k])).abs() < 0.02,
                    "row {row}: {check:?} {}",
                    cell_score[k]
                );
                cells += 1;
            }
        }
        // Where a cell is good, the test's own search mostly finds a grasp as well: its directions are others.
        let most = range.map(|k| cell_score[k]).fold(0.0, f32::max);
        missed += usize::from(most >= 0.3 && score[row] == 0.0);
    }
    assert!(agree >= 58 && missed <= 18, "{agree} {missed}");
    assert!(cells > 50, "{cells}");
}

#[test]
fn the_value_of_a_push_is_at_least_that_of_the_state_it_leads_to() {
    let folder = Folder::new();
    values(&folder.0, &store(6, 6, 1)).unwrap();
    let shard = Shard::read(&folder.0, "ppn-00000.safetensors");
    let (start, push, q, visits) =
        (shard.long("push_start"), shard.real("push"), shard.real("q"), shard.word("visits"));
    let target = shard.byte("target");
    assert_eq!(start[6] as usize, q.len());
    assert_eq!(shard.bytes("push").0, [q.len(), 4]);
    assert!(q.iter().all(|v| (0.0..=1.0).contains(v)));
    let (mut solved, mut dead, mut low) = (0, 0, 0);
    for row in 0..6 {
        let (scene, state) = rebuilt(&folder.0, &shard, row, "pose");
        let engine = physics::engine(&planar(), Arc::clone(&scene)).unwrap();
        let test = GraspTest::new(GraspParams::default()).unwrap();
        for k in start[row] as usize..start[row + 1] as usize {
            let [x0, y0, x1, y1] = [0, 1, 2, 3].map(|c| f64::from(push[k * 4 + c]));
            let done =
                engine.step(&mut engine.scratch(), &state, &Push::new(vec2(x0, y0), vec2(x1, y1)), &Stop::never());
            if visits[k] == 0 {
                assert_eq!(q[k], 0.0);
                dead += 1;
                continue;
            }
            let found = test.assess(&scene, &done.state, usize::from(target[row]), &mut GraspScratch::default());
            let is_solution = found.grasp.is_some() && found.score >= 0.35;
            let judged = if found.grasp.is_some() { 0.5 + 0.5 * found.score } else { 0.5 * found.nearness };
            let own = (f64::from(u8::from(is_solution)) + 0.2 * judged) / 1.2;
            solved += usize::from(is_solution);
            // A single contact that falls differently after rounding may change one value.
            low += usize::from(f64::from(q[k]) < own - 0.02);
        }
    }
    assert!(low <= 2, "{low} values are below what the push leads to");
    assert!(solved > 0 && solved + dead < q.len(), "{solved} {dead} {}", q.len());
}

#[test]
fn a_network_that_guides_the_search_is_named_in_the_manifest_and_the_data_repeat() {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/nets/ppn.onnx");
    let prior = match Model::load(file, Some(Kind::Ppn), &LoadOptions::default()) {
        Ok(model) => model,
        Err(Error::Runtime(reason)) => return println!("skipped: {reason}"),
        Err(error) => panic!("{error}"),
    };
    let sha256 = prior.info().sha256.clone();
    let guided = |folder: &Path, threads| {
        let params = PpnParams { iterations: 60, prior: Some(prior.clone()), ..PpnParams::new().unwrap() };
        ppn(&params, &family(), SHAPE_SEED, folder, &store(6, 3, threads), &Stop::never(), &mut |_| ())
    };
    let (one, two, free) = (Folder::new(), Folder::new(), Folder::new());
    let manifest = guided(&one.0, 1).unwrap();
    assert_eq!(manifest.configuration["search"]["planner"], "more");
    assert_eq!(manifest.configuration["search"]["prior_sha256"], sha256);
    assert_eq!(guided(&two.0, 2).unwrap(), manifest);
    assert!(files(&one.0) == files(&two.0));
    // The scenes are those of an unguided search, what is found of their pushes is not; and neither goes on in the other's
    // folder.
    let unguided = values(&free.0, &store(6, 3, 1)).unwrap();
    assert_eq!(unguided.configuration["search"].get("prior_sha256"), None);
    let shard = |folder: &Folder| Shard::read(&folder.0, "ppn-00000.safetensors");
    let (a, b) = (shard(&one), shard(&free));
    assert_eq!(a.real("pose")[..36], b.real("pose")[..36]);
    assert_ne!((a.word("visits"), a.real("q")), (b.word("visits"), b.real("q")));
    let error = guided(&free.0, 1).unwrap_err().to_string();
    assert!(error.contains("another configuration"), "{error}");
}

#[test]
fn trials_need_an_engine_that_can_grasp() {
    let folder = Folder::new();
    let params = GraspDataParams { trials: Some(planar()), ..GraspDataParams::default() };
    let make = |params: &GraspDataParams, folder: &Path, count: usize| {
        grasp(params, &family(), SHAPE_SEED, folder, &store(count, count, 1), &Stop::never(), &mut |_| ())
    };
    let error = make(&params, &folder.0, 4).unwrap_err().to_string();
    assert!(error.starts_with("label: planar cannot grasp"), "{error}");
    if !physics::EngineInfo::available().any(|e| e.id == "bullet") {
        println!("skipped: this build has no bullet");
        return;
    }
    let bullet = PhysicsOptions::named("bullet", Some("fast"), Purpose::Judging).unwrap();
    let params = GraspDataParams { trials: Some(bullet), trial_share: 1.0, ..GraspDataParams::default() };
    let manifest = make(&params, &folder.0, 12).unwrap();
    let shard = Shard::read(&folder.0, "grasp-00000.safetensors");
    let (trial, score) = (shard.byte("trial"), shard.real("score"));
    assert!(trial.iter().zip(&score).all(|(t, s)| (*t == 0) == (*s == 0.0)), "{trial:?} {score:?}");
    assert!(trial.contains(&2), "{trial:?}");
    assert!(manifest.statistics["trials"] > 0.0);
}
