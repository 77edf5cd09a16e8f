//! Networks: every check of a file has its own fault, results depend on nothing but the input, and the learned engine and
//! scorers keep their contracts. What needs a runtime is skipped, with the reason, where there is none.

#[path = "common/onnx.rs"]
mod onnx;

use std::path::{Path, PathBuf};
use std::sync::Arc;

use jostle::action::Push;
use jostle::error::{Error, ModelFault};
use jostle::geom::{Pose2, Shape, vec2};
use jostle::grasp::{GraspAssessment, Networks, scorer};
use jostle::net::{
    Configuration, Device, Gc, Gn, GraspMap, ImageScratch, Kind, LoadOptions, Model, MotionModel, ObjectBatch,
    OnnxInfo, Ppn, PushValue, SegmentOptions, Segmentation, TargetProbability, inspect,
};
use jostle::physics::{Dipn, DipnSettings, PhysicsOptions, PushJob, PushResult, PushStatus, Transition, engine};
use jostle::plan::{Control, Planner, PlannerOptions};
use jostle::run::{Budget, CancelToken, Stop};
use jostle::scene::{BodyDef, Problem, Scene, SceneBuilder, State};
use onnx::{bytes, net, runs, with_dims, with_dtype, with_name, with_property};
use proptest::prelude::*;

/// A file of this test's own, gone when it is dropped.
struct Temporary(PathBuf);

impl Temporary {
    fn new(name: &str, content: &[u8]) -> Temporary {
        let path = std::env::temp_dir().join(format!("jostle-nets-{}-{name}", std::process::id()));
        std::fs::write(&path, content).unwrap();
        Temporary(path)
    }
}

impl Drop for Temporary {
    fn drop(&mut self) {
        let _ = std::fs::remove_file(&self.0);
    }
}

fn fault(error: &Error) -> ModelFault {
    match error {
        Error::Model { fault, expected, found, .. } => {
            assert!(!expected.is_empty() && !found.is_empty(), "{error}");
            *fault
        }
        other => panic!("{other}"),
    }
}

/// What the checks that need no runtime say of a file with this content.
fn refused(name: &str, content: &[u8], kind: Option<Kind>) -> (ModelFault, String) {
    let file = Temporary::new(name, content);
    let error = inspect(&file.0, kind, &LoadOptions::default()).expect_err(name);
    assert!(error.to_string().contains(name), "the message names the file: {error}");
    (fault(&error), error.to_string())
}

#[test]
fn a_good_file_of_every_kind_passes_the_checks_without_a_runtime() {
    for (name, kind) in [
        ("dipn", Kind::Dipn),
        ("dipn_none", Kind::Dipn),
        ("ppn", Kind::Ppn),
        ("gc", Kind::Gc),
        ("gn", Kind::Gn),
        ("segmentation", Kind::Segmentation),
        ("torchvision", Kind::Segmentation),
    ] {
        let info = inspect(&net(name), Some(kind), &LoadOptions::default()).unwrap_or_else(|e| panic!("{e}"));
        assert_eq!((info.kind, info.onnx.opset), (kind, 18), "{name}");
        assert_eq!(info.bytes, bytes(name).len());
    }
    let info = inspect(&net("gc"), None, &LoadOptions::default()).unwrap();
    assert_eq!(
        (info.gripper(), info.side, info.pixel(), info.threshold()),
        (Some("robotiq_2f85"), Some(32), 0.002, 0.5)
    );
}

#[test]
fn every_spoilt_file_has_its_own_fault_and_a_message_with_file_expected_and_found() {
    let gc = bytes("gc");
    let dipn = bytes("dipn");
    let missing = inspect(Path::new("/nowhere/x.onnx"), None, &LoadOptions::default()).unwrap_err();
    assert_eq!(fault(&missing), ModelFault::Missing);
    let pointer = b"version https://git-lfs.github.com/spec/v1\noid sha256:00\nsize 12345\n";
    let spec = |text| with_property(&gc, "spec", Some(text));
    #[allow(clippy::type_complexity)]
    let cases: Vec<(&str, Vec<u8>, Option<Kind>, ModelFault, &str)> = vec![
        ("empty", vec![], None, ModelFault::Empty, "0 bytes"),
        ("pointer", pointer.to_vec(), None, ModelFault::LfsPointer, "git lfs pull"),
        ("text", b"a picture of a network".to_vec(), None, ModelFault::NotOnnx, "protocol buffer"),
        ("truncated", gc[..gc.len() - 20].to_vec(), None, ModelFault::NotOnnx, "ends within a field"),
        ("kind-asked", gc.clone(), Some(Kind::Gn), ModelFault::Kind, "expected `gn`; found `gc`"),
        ("kind-none", with_property(&gc, "kind", None), None, ModelFault::Kind, "docs/networks.md"),
        ("kind-odd", with_property(&gc, "kind", Some("cat")), None, ModelFault::Kind, "found `cat`"),
        ("interface", with_property(&gc, "interface", Some("7")), None, ModelFault::Interface, "found `7`"),
        ("interface-none", with_property(&gc, "interface", None), None, ModelFault::Interface, "no metadata"),
        ("dims", with_dims(&gc, "image", &[0, 3, 32, 32]), None, ModelFault::Tensors, "[batch, 3, 32, 32]"),
        ("rank", with_dims(&gc, "image", &[0, 2, 32]), None, ModelFault::Tensors, "[batch, 2, 32]"),
        ("square", with_dims(&gc, "image", &[0, 2, 32, 30]), None, ModelFault::Tensors, "[batch, 2, 32, 30]"),
        ("batch", with_dims(&gc, "probability", &[4]), None, ModelFault::Tensors, "[4]"),
        ("fixed", with_dims(&gc, "image", &[2, 2, 32, 32]), None, ModelFault::Tensors, "export with dynamic shapes"),
        ("objects", with_dims(&dipn, "centre", &[0, 5, 2]), None, ModelFault::Tensors, "[batch, num_objects, 2]"),
        ("dtype", with_dtype(&gc, "image", 10), None, ModelFault::Tensors, "float16"),
        ("name", with_name(&gc, "image", "photo"), None, ModelFault::Tensors, "found `photo`"),
        ("spec-text", spec("{"), None, ModelFault::Spec, "JSON"),
        ("spec-size", spec(r#"{"pixel":0.002,"size":112}"#), None, ModelFault::Spec, "`size` 32"),
        ("spec-pixel", spec(r#"{"size":32}"#), None, ModelFault::Spec, "`pixel`"),
        ("gripper-none", with_property(&gc, "gripper", None), None, ModelFault::Spec, "`gripper`"),
        ("threshold", with_property(&gc, "threshold", Some("high")), None, ModelFault::Spec, "`threshold`"),
        (
            "guess",
            with_property(&bytes("dipn_none"), "spec", Some(r#"{"guess":"planar"}"#)),
            None,
            ModelFault::Spec,
            "an input `guess`",
        ),
    ];
    for (name, content, kind, wanted, says) in cases {
        let (found, text) = refused(name, &content, kind);
        assert_eq!(found, wanted, "{name}: {text}");
        assert!(text.contains(says), "{name}: {text}");
    }
}

#[test]
fn a_file_for_another_gripper_or_hash_is_refused_unless_tolerated() {
    let wanted = |tolerate| LoadOptions {
        configuration: Configuration { gripper: Some("dissertation_mask".into()), tolerate, ..Default::default() },
        ..LoadOptions::default()
    };
    let error = inspect(&net("gc"), None, &wanted(false)).unwrap_err();
    assert_eq!(fault(&error), ModelFault::Spec);
    assert!(error.to_string().ends_with("expected the gripper `dissertation_mask`; found `robotiq_2f85`"), "{error}");
    assert_eq!(inspect(&net("gc"), None, &wanted(true)).unwrap().warnings.len(), 1);
    let pixel = Configuration { pixel: Some(0.001), ..Configuration::default() };
    let error = inspect(&net("gc"), None, &LoadOptions { configuration: pixel, ..LoadOptions::default() }).unwrap_err();
    assert_eq!(fault(&error), ModelFault::Spec);
    let hash = LoadOptions { sha256: Some("00".repeat(32)), ..LoadOptions::default() };
    assert_eq!(fault(&inspect(&net("gc"), None, &hash).unwrap_err()), ModelFault::Hash);
}

#[test]
fn a_failed_self_test_and_a_refused_graph_have_their_own_faults() {
    if !runs() {
        return;
    }
    let options = LoadOptions::default();
    let load = |content: &[u8]| Model::from_bytes("x.onnx", content.to_vec(), None, &options).map(drop).unwrap_err();
    let gc = bytes("gc");
    let test = |text| with_property(&gc, "selftest", Some(text));
    let off = load(&test(r#"{"seed":20,"expected":{"probability":[0.123]},"atol":0.001}"#));
    assert_eq!(fault(&off), ModelFault::SelfTest);
    assert!(off.to_string().contains("`probability`[0] = 0.123 within 0.001"), "{off}");
    for odd in ["{}", r#"{"seed":1,"batch":100000}"#, r#"{"seed":1,"expected":{"what":[0]}}"#] {
        assert_eq!(fault(&load(&test(odd))), ModelFault::SelfTest, "{odd}");
    }
    // A version of the format that no runtime has.
    assert_eq!(gc[..2], [8, 10], "the version comes first");
    let error = load(&[&[8, 99], &gc[2..]].concat());
    assert_eq!(fault(&error), ModelFault::Session, "{error}");
    // An operator that nobody has does not come so far.
    let error = load(&with_name(&gc, "GlobalAveragePool", "GlobalAveragePoor"));
    assert_eq!(fault(&error), ModelFault::Operator, "{error}");
    // Without a self-test the answers' shape is looked at.
    let quiet = Model::from_bytes("x.onnx", with_property(&gc, "selftest", None), None, &options).unwrap();
    assert_eq!(quiet.info().warnings.len(), 1);
}

/// An attention that masks absent bodies gives NaN where there is none, as in the items that fill a call up.
#[test]
fn what_a_network_says_of_items_without_bodies_matters_to_those_who_ask_only() {
    if !runs() {
        return;
    }
    // A mean over the bodies that are there, with 0 in the place of what keeps it from dividing by zero.
    let mut content = bytes("dipn_none");
    let least = 1e-6f32.to_le_bytes();
    let at: Vec<usize> = (0..content.len() - 3).filter(|&k| content[k..k + 4] == least).collect();
    let [at] = at[..] else { panic!("{at:?}") };
    content[at..at + 4].fill(0);
    let model = Model::from_bytes("x.onnx", content, Some(Kind::Dipn), &LoadOptions::default()).unwrap();
    let [outline, centre, body, push] = [2 * 64, 2 * 2, 2 * 4, 4].map(|n| vec![0.1; n]);
    let run = |present: f32| {
        let mut outputs = vec![Vec::new()];
        let inputs: [&[f32]; 6] = [&outline, &centre, &body, &push, &[], &[present; 2]];
        model.run(1, 2, &inputs, &mut outputs).map(|()| outputs.remove(0))
    };
    assert!(run(1.0).unwrap().iter().all(|v| v.is_finite()));
    let error = run(0.0).unwrap_err();
    assert!(fault(&error) == ModelFault::Run && error.to_string().contains("finite numbers; found NaN as"), "{error}");
}

#[test]
fn a_self_test_looks_at_the_values_at_its_positions_for_inputs_as_they_occur() {
    if !runs() {
        return;
    }
    let model = Path::new(env!("CARGO_MANIFEST_DIR")).join("models/ppn.onnx");
    let content = std::fs::read(&model).unwrap();
    let options = LoadOptions::default();
    let info = inspect(&model, Some(Kind::Ppn), &options).unwrap();
    let text = info.property("selftest").to_string();
    let told: serde_json::Value = serde_json::from_str(&text).unwrap();
    let values: Vec<f64> = serde_json::from_value(told["expected"]["value"].clone()).unwrap();
    let spread = values.iter().fold(0.0, |most: f64, v| most.max((v - values[0]).abs()));
    assert!(told["inputs"] == "scene" && spread > 0.1, "values that differ: {text}");
    let load = |edit: &dyn Fn(&mut serde_json::Value)| {
        let mut test = told.clone();
        edit(&mut test);
        let content = with_property(&content, "selftest", Some(&test.to_string()));
        Model::from_bytes("x.onnx", content, None, &options).map(drop)
    };
    load(&|_| ()).unwrap();
    // Each of the values counts.
    for k in 0..values.len() {
        let error = load(&|test| test["expected"]["value"][k] = (values[k] + 0.002).into()).unwrap_err();
        assert_eq!(fault(&error), ModelFault::SelfTest);
        assert!(error.to_string().contains(&format!("`value`[{}]", told["at"]["value"][k])), "{error}");
    }
    let odd: [&dyn Fn(&mut serde_json::Value); 4] = [
        &|test| test["at"]["value"][0] = 1_000_000.into(),
        &|test| drop(test["at"]["value"].as_array_mut().unwrap().pop()),
        &|test| test["inputs"] = "noise".into(),
        &|test| test["inputs"] = "plain".into(),
    ];
    for (k, edit) in odd.iter().enumerate() {
        assert_eq!(fault(&load(edit).unwrap_err()), ModelFault::SelfTest, "{k}");
    }
}

#[test]
fn a_graphics_card_that_is_not_there_is_refused_with_what_to_do_and_the_processor_runs() {
    if !runs() {
        return;
    }
    let load = |device| Model::load(net("gc"), None, &LoadOptions { device, ..LoadOptions::default() });
    match load(Device::Cuda(0)) {
        Ok(_) => println!("this machine has a card and a runtime for it"),
        Err(Error::Unsupported(text)) => {
            assert!(text.starts_with("device: CUDA"), "{text}");
            let told = text.contains("`runtime.library`") && text.contains("use the CPU");
            assert!(told || text.contains("device 0 cannot be used"), "{text}");
        }
        Err(other) => panic!("{other}"),
    }
    // Nothing of the refusal stays.
    load(Device::Cpu).unwrap();
}

#[test]
fn a_graph_that_answers_in_another_shape_than_it_says_is_found_out() {
    if !runs() {
        return;
    }
    // The file says 16 planes of 16 x 16; the kernel of the first layer is walked in steps of 2 from 30 pixels.
    let gn = with_dims(&with_dims(&bytes("gn"), "image", &[0, 2, 30, 30]), "quality", &[0, 16, 16, 16]);
    assert!(Model::from_bytes("x.onnx", gn, None, &LoadOptions::default()).is_err());
}

#[test]
fn an_item_has_the_same_bits_alone_in_any_batch_and_place_and_on_any_thread() {
    if !runs() {
        return;
    }
    let model = Model::load(net("dipn"), Some(Kind::Dipn), &LoadOptions::default()).unwrap();
    let (items, objects) = (23, 7);
    let mut seed = 1_u64;
    let mut value = || {
        seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
        (seed >> 40) as f32 / (1 << 24) as f32 - 0.5
    };
    let strides = [objects * 64, objects * 2, objects * 4, 4, objects * 3, objects];
    let data: Vec<Vec<f32>> = strides.iter().map(|n| (0..items * n).map(|_| value()).collect()).collect();
    let run = |order: &[usize]| {
        let inputs: Vec<Vec<f32>> = data
            .iter()
            .zip(strides)
            .map(|(d, n)| order.iter().flat_map(|&i| d[i * n..(i + 1) * n].iter().copied()).collect())
            .collect();
        let inputs: Vec<&[f32]> = inputs.iter().map(Vec::as_slice).collect();
        let mut outputs = vec![Vec::new()];
        model.run(order.len(), objects, &inputs, &mut outputs).unwrap();
        outputs[0].chunks(objects * 3).map(|o| o.iter().map(|v| v.to_bits()).collect()).collect::<Vec<Vec<u32>>>()
    };
    let forward: Vec<usize> = (0..items).collect();
    let all = run(&forward);
    let backward = run(&forward.iter().rev().copied().collect::<Vec<_>>());
    for i in 0..items {
        assert_eq!(all[i], backward[items - 1 - i], "item {i} in another place");
        assert_eq!(run(&[i]), [all[i].clone()], "item {i} alone");
    }
    let again = std::thread::scope(|s| {
        let threads: Vec<_> = (0..4).map(|_| s.spawn(|| run(&forward))).collect();
        threads.into_iter().map(|t| t.join().unwrap()).collect::<Vec<_>>()
    });
    assert!(again.iter().all(|other| *other == all), "on another thread");
}

/// A sum over the items in place of the bodies: each answer depends on the others.
#[test]
fn a_network_whose_items_depend_on_each_other_is_refused_when_it_is_loaded() {
    if !runs() {
        return;
    }
    for name in ["dipn", "dipn_none"] {
        let plain = with_property(&bytes(name), "selftest", None);
        let options = LoadOptions::default();
        Model::from_bytes("x.onnx", plain.clone(), None, &options).unwrap();
        // The second constant that is 1: the axis of both sums (the first is that of `push`).
        let one = [&[0x4a, 8, 1][..], &[0; 7]].concat();
        let at = plain.windows(one.len()).enumerate().filter(|(_, w)| **w == one).map(|(at, _)| at).nth(1).unwrap();
        let mut mixed = plain;
        mixed[at + 2] = 0;
        let error = Model::from_bytes("x.onnx", mixed, None, &options).map(drop).unwrap_err();
        assert_eq!(fault(&error), ModelFault::SelfTest);
        assert!(error.to_string().contains("the same bits for an item alone"), "{error}");
    }
}

fn square() -> Shape {
    Shape::rectangle(0.045, 0.045)
}

fn scene_of(shapes: &[Shape]) -> Arc<Scene> {
    let mut builder = SceneBuilder::new();
    for shape in shapes {
        builder.add_body(BodyDef::new(shape.clone())).unwrap();
    }
    Arc::new(builder.build().unwrap())
}

/// Two blocks side by side, a disc apart, and pushes among them.
fn clutter() -> (Arc<Scene>, State, Vec<Push>) {
    let scene = scene_of(&[square(), square(), Shape::Disc { radius: 0.02 }]);
    let state = State::new([Pose2::new(0.5, 0.0, 0.0), Pose2::new(0.55, 0.0, 0.3), Pose2::new(0.5, 0.12, 0.0)]);
    let pushes = (0..19).map(|i| {
        let y = -0.03 + 0.008 * f64::from(i);
        Push::new(vec2(0.42, y), vec2(0.52, y + 0.01))
    });
    (scene, state, pushes.collect())
}

/// Moves every body by the push, whatever it is told: a stand-in for a network.
struct Straight {
    fails: bool,
}

impl MotionModel for Straight {
    fn name(&self) -> &str {
        "straight"
    }

    fn wants_guess(&self) -> bool {
        false
    }

    fn chunk(&self) -> usize {
        4
    }

    fn predict(&self, batch: &ObjectBatch, motions: &mut Vec<[f32; 3]>, _: &Stop) -> jostle::Result<()> {
        motions.clear();
        if self.fails {
            return Err(Error::Internal("broken".into()));
        }
        // The first body goes along the push, the others are nearly still.
        for _ in 0..batch.items() {
            motions.extend((0..batch.objects()).map(|i| if i == 0 { [0.04, 0.0, 0.1] } else { [2e-4, 0.0, 1e-3] }));
        }
        Ok(())
    }
}

fn step(engine: &dyn Transition, state: &State, pushes: &[Push]) -> Vec<PushResult> {
    let jobs: Vec<PushJob> = pushes.iter().map(|&push| PushJob { state, push }).collect();
    let mut results = vec![PushResult::default(); jobs.len()];
    engine.step_batch(&mut engine.scratch(), &jobs, &mut results, &Stop::never());
    results
}

#[test]
fn a_learned_engine_keeps_the_rules_that_need_no_network() {
    let (scene, state, _) = clutter();
    let engine = Dipn::new(scene, DipnSettings::default(), Arc::new(Straight { fails: false })).unwrap();
    let hits = Push::new(vec2(0.44, 0.0), vec2(0.50, 0.0));
    let misses = Push::new(vec2(0.4, -0.2), vec2(0.5, -0.2));
    let lands = Push::new(vec2(0.5, 0.0), vec2(0.6, 0.0));
    let nowhere = Push::new(vec2(0.4, 0.0), vec2(0.4, 0.0));
    let results = step(&engine, &state, &[hits, misses, lands, nowhere]);
    assert_eq!(results[0].status, PushStatus::Executed);
    assert!((results[0].state.pose(0).x - 0.54).abs() < 1e-6 && (results[0].state.pose(0).theta - 0.1).abs() < 1e-6);
    // The noise of a network moves nothing.
    assert_eq!(results[0].state.poses()[1..], state.poses()[1..]);
    assert_eq!(results[0].touched.iter().collect::<Vec<_>>(), [0]);
    assert_eq!((results[1].status, &results[1].state), (PushStatus::Executed, &state));
    assert_eq!(results[2].status, PushStatus::Illegal { body: Some(0) });
    assert_eq!(results[3].status, PushStatus::Illegal { body: None });
}

#[test]
fn a_network_that_fails_leaves_the_push_illegal_and_a_stop_interrupts() {
    let (scene, state, pushes) = clutter();
    let broken = Dipn::new(Arc::clone(&scene), DipnSettings::default(), Arc::new(Straight { fails: true })).unwrap();
    let hits = Push::new(vec2(0.44, 0.0), vec2(0.50, 0.0));
    assert_eq!(step(&broken, &state, &[hits])[0].status, PushStatus::Illegal { body: None });
    let engine = Dipn::new(scene, DipnSettings::default(), Arc::new(Straight { fails: false })).unwrap();
    let cancel = CancelToken::new();
    cancel.trigger();
    let stop = Budget::default().start(&[cancel]);
    let jobs: Vec<PushJob> = pushes.iter().map(|&push| PushJob { state: &state, push }).collect();
    let mut results = vec![PushResult::default(); jobs.len()];
    engine.step_batch(&mut engine.scratch(), &jobs, &mut results, &stop);
    assert!(results.iter().all(|r| r.status == PushStatus::Interrupted));
}

#[test]
fn a_push_of_the_learned_engine_has_the_same_bits_alone_and_in_a_batch() {
    if !runs() {
        return;
    }
    let (scene, state, pushes) = clutter();
    for name in ["dipn", "dipn_none"] {
        let options = PhysicsOptions { engine: "dipn".into(), preset: net(name).display().to_string(), settings: None };
        let engine = engine(&options, Arc::clone(&scene)).unwrap();
        assert_eq!(engine.name(), format!("dipn {name}"));
        let all = step(&*engine, &state, &pushes);
        assert!(all.iter().any(|r| r.status == PushStatus::Executed && r.state != state), "something moves");
        for (i, push) in pushes.iter().enumerate() {
            assert_eq!(step(&*engine, &state, &[*push])[0], all[i], "{name}: push {i}");
        }
    }
}

#[test]
fn the_planar_guess_is_what_a_correcting_network_corrects() {
    if !runs() {
        return;
    }
    let (scene, state, pushes) = clutter();
    let learned = PhysicsOptions { engine: "dipn".into(), preset: net("dipn").display().to_string(), settings: None };
    let planar = PhysicsOptions::parse("planar:fast", jostle::physics::Purpose::Planning).unwrap();
    let a = step(&*engine(&learned, Arc::clone(&scene)).unwrap(), &state, &pushes);
    let b = step(&*engine(&planar, scene).unwrap(), &state, &pushes);
    for (a, b) in a.iter().zip(&b).filter(|(a, _)| a.status == PushStatus::Executed) {
        for i in 0..3 {
            // The network of the tests corrects by at most 2 mm in x and in y.
            let off = (a.state.pose(i).position() - b.state.pose(i).position()).norm();
            assert!(off < 0.003, "body {i}: {off}");
        }
        assert_eq!(a.touched, b.touched);
    }
}

#[test]
fn an_unknown_network_of_the_learned_engine_is_named() {
    let (scene, ..) = clutter();
    let of = |preset: &str| PhysicsOptions { engine: "dipn".into(), preset: preset.into(), settings: None };
    let error = engine(&of("/nowhere/dipn.onnx"), Arc::clone(&scene)).map(drop).unwrap_err();
    assert_eq!(fault(&error), ModelFault::Missing);
    let error = engine(&of("no_such_network"), scene).map(drop).unwrap_err().to_string();
    assert!(error.starts_with("model: no built-in network is named `no_such_network`"), "{error}");
}

#[test]
fn networks_on_images_answer_within_their_ranges_and_alike() {
    if !runs() {
        return;
    }
    let (scene, state, _) = clutter();
    let load = |name: &str| Model::load(net(name), None, &LoadOptions::default()).unwrap();
    let (gc, gn) = (Gc::new(load("gc")).unwrap(), Gn::new(load("gn")).unwrap());
    let (mut scratch, never) = (ImageScratch::default(), Stop::never());
    let first = gc.probability(&mut scratch, &scene, &state, 0, &never).unwrap();
    assert!((0.0..=1.0).contains(&first));
    assert_ne!(first, gc.probability(&mut scratch, &scene, &state, 2, &never).unwrap(), "it sees the target");
    let again = gc.probability(&mut ImageScratch::default(), &scene, &state, 0, &never).unwrap();
    assert_eq!(first.to_bits(), again.to_bits());
    let mut found = Vec::new();
    gn.best(&mut scratch, &scene, &state, 1, 40, &mut found, &never).unwrap();
    assert_eq!(found.len(), 40);
    assert!(found.windows(2).all(|pair| pair[0].quality >= pair[1].quality));
    let (cells, quality) = gn.map(&mut scratch, &scene, &state, 1, &never).unwrap();
    assert_eq!((cells.rows, cells.pixel), (16, 0.004));
    let greatest = quality.iter().copied().fold(0.0, f32::max);
    assert_eq!(found[0].quality, f64::from(greatest));
    assert!((found[0].position - state.pose(1).position()).norm() < 0.032 * 1.5);
    assert!(Gc::new(load("gn")).is_err() && Gn::new(load("gc")).is_err());
}

#[test]
fn instances_come_from_offsets_and_from_masks() {
    if !runs() {
        return;
    }
    let load = |name: &str| Model::load(net(name), None, &LoadOptions::default()).unwrap();
    let own =
        Segmentation::new(load("segmentation"), SegmentOptions { least_pixels: 1, ..Default::default() }).unwrap();
    let image: Vec<f32> = (0..32 * 32).map(|i| if i % 32 < 16 { 0.04 } else { 0.0 }).collect();
    let found = own.segment(&image, 32, 32).unwrap();
    assert!(found.labels.iter().all(|l| usize::from(*l) <= found.scores.len()));
    assert!(own.segment(&image, 16, 64).is_err() && own.segment(&image[1..], 32, 32).is_err());
    // The stand-in for torchvision's finds the two halves of any picture, with scores 0.95 and 0.4.
    let masks = |score| Segmentation::new(load("torchvision"), SegmentOptions { score, ..Default::default() }).unwrap();
    let picture = vec![0.5; 3 * 32 * 32];
    let both = masks(0.3).segment(&picture, 32, 32).unwrap();
    assert_eq!((both.labels[0], both.labels[31], both.scores.len()), (1, 2, 2));
    let one = masks(0.5).segment(&picture, 32, 32).unwrap();
    assert_eq!((one.labels[0], one.labels[31], one.scores.len()), (1, 0, 1));
    assert!(Segmentation::new(load("gc"), SegmentOptions::default()).is_err());
}

#[test]
fn a_scorer_by_name_wants_the_gripper_of_its_network() {
    assert!(Networks::new("magic", None).unwrap_err().to_string().starts_with("scorer: no scorer is named `magic`"));
    if !runs() {
        return;
    }
    let load = |name: &str| Some(Model::load(net(name), None, &LoadOptions::default()).unwrap());
    assert!(Networks::new("geometric", load("gc")).is_err());
    let (scene, state, _) = clutter();
    for name in ["gc", "gn"] {
        let networks = Networks::new(name, load(name)).unwrap();
        let scorer = scorer(name, &scene, &networks).unwrap();
        let mut out = [GraspAssessment::default()];
        scorer.assess(scorer.scratch().as_mut(), &scene, &[&state], 0, &mut out, &Stop::never());
        assert!((0.0..=1.0).contains(&out[0].score) && (0.0..=1.0).contains(&out[0].nearness), "{out:?}");
        let mut builder = scene.to_builder();
        builder.gripper(jostle::scene::Gripper::dissertation_mask());
        let other = builder.build().unwrap();
        let error = jostle::grasp::scorer(name, &other, &networks).map(drop).unwrap_err();
        assert!(matches!(&error, Error::Argument { field, .. } if field == "scene.gripper"), "{error}");
    }
    // The network of another scorer.
    let error = Networks::new("gc", load("gn")).unwrap_err();
    assert_eq!(fault(&error), ModelFault::Kind);
}

#[test]
fn a_push_has_the_same_value_alone_and_among_others() {
    if !runs() {
        return;
    }
    let (scene, state, pushes) = clutter();
    let ppn = Ppn::new(Model::load(net("ppn"), None, &LoadOptions::default()).unwrap()).unwrap();
    let (mut scratch, mut all, mut one) = (Default::default(), Vec::new(), Vec::new());
    ppn.values(&mut scratch, &scene, &state, 1, &pushes, &mut all, &Stop::never()).unwrap();
    assert!(all.iter().all(|v| (0.0..=1.0).contains(v)));
    assert!(all.windows(2).any(|pair| pair[0] != pair[1]));
    for (push, value) in pushes.iter().zip(&all) {
        ppn.values(&mut scratch, &scene, &state, 1, &[*push], &mut one, &Stop::never()).unwrap();
        assert_eq!(one, [*value]);
    }
    assert!(ppn.values(&mut scratch, &scene, &state, 3, &pushes, &mut one, &Stop::never()).is_err());
}

#[test]
fn a_planner_searches_with_the_learned_engine_and_scorer_and_threads_change_no_bit() {
    if !runs() {
        return;
    }
    let scene = scene_of(&[square(), square(), square()]);
    let state = State::new([Pose2::new(0.5, 0.0, 0.0), Pose2::new(0.55, 0.0, 0.0), Pose2::new(0.5, 0.05, 0.0)]);
    let problem = Problem::new("three", scene, state, 0).unwrap();
    let plan = |threads: usize, scorer: &str| {
        let mut options = PlannerOptions {
            budget: Budget::iterations(64),
            threads,
            scorer: Some(scorer.into()),
            scorer_model: (scorer != "geometric")
                .then(|| Model::load(net(scorer), None, &LoadOptions::default()).unwrap()),
            ..PlannerOptions::default()
        };
        options.set_physics(Some("dipn"), net("dipn").to_str()).unwrap();
        options.set_confirm(Some("none")).unwrap();
        Planner::new(options).unwrap().solve(&problem, &Control::default()).unwrap()
    };
    for scorer in ["geometric", "gc"] {
        let (one, two) = (plan(1, scorer), plan(3, scorer));
        assert!(!one.actions.is_empty(), "{scorer}");
        assert_eq!((one.outcome, &one.actions), (two.outcome, &two.actions), "{scorer}");
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(300))]

    #[test]
    fn any_bytes_are_read_or_refused(bytes in proptest::collection::vec(any::<u8>(), 0..400)) {
        let _ = OnnxInfo::read(&bytes);
    }

    #[test]
    fn a_file_that_is_cut_off_is_refused(at in 0.0..1.0_f64) {
        let whole = bytes("dipn");
        let part = &whole[..(whole.len() as f64 * at) as usize];
        // Cut between two fields it may still be a model, but then one without what is checked.
        if let Ok(info) = OnnxInfo::read(part) {
            prop_assert!(info.metadata.len() < OnnxInfo::read(&whole).unwrap().metadata.len());
        }
    }

    #[test]
    fn flipped_bits_never_break_the_reader(
        name in prop::sample::select(vec!["dipn", "gc", "segmentation"]),
        flips in proptest::collection::vec((any::<prop::sample::Index>(), 0..8_u32), 1..6),
    ) {
        let mut spoilt = bytes(name);
        for (at, bit) in flips {
            let at = at.index(spoilt.len());
            spoilt[at] ^= 1 << bit;
        }
        let file = Temporary::new("flipped", &spoilt);
        let _ = inspect(&file.0, None, &LoadOptions::default());
    }
}
