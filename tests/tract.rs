//! Every network of the repository gives the same answers on the embedded backend as on ONNX Runtime. `make test-tract`.
//!
//! A process has one runtime, so each backend runs in a child process of its own: this test again, told by a variable to
//! print what its networks answer.

#![cfg(feature = "tract")]

#[path = "common/onnx.rs"]
mod onnx;

use std::collections::BTreeMap;
use std::path::PathBuf;
use std::process::Command;

use jostle::net::{Axis, BUILTINS, Backend, LoadOptions, Model, Runtime, RuntimeOptions};

const VARIABLE: &str = "JOSTLE_TEST_BACKEND";
/// Greatest difference of an answer; networks answer with metres, radians and probabilities.
const TOLERANCE: f64 = 1e-4;
const OBJECTS: usize = 5;
const ITEMS: usize = 3;

type Answers = BTreeMap<String, Vec<Vec<f32>>>;

/// Every network: those of the tests and those that are built in.
fn networks() -> Vec<String> {
    let tests =
        ["dipn", "dipn_none", "ppn", "gc", "gn", "segmentation"].map(|name| onnx::net(name).display().to_string());
    tests.into_iter().chain(BUILTINS.iter().map(|b| b.name.to_string())).collect()
}

fn answers(backend: Backend) -> Answers {
    let options =
        LoadOptions { runtime: RuntimeOptions { library: None, backend: Some(backend) }, ..LoadOptions::default() };
    networks()
        .into_iter()
        .map(|name| {
            let model = Model::open(&name, None, &options).unwrap_or_else(|e| panic!("{e}"));
            assert_eq!(model.runtime().backend, backend);
            let info = model.info();
            let mut seed = 7_u64;
            let mut value = || {
                seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
                (seed >> 40) as f32 / (1 << 24) as f32 * 0.1
            };
            let inputs: Vec<Vec<f32>> = info
                .interface
                .inputs
                .iter()
                .map(|spec| {
                    let count: usize = spec
                        .axes
                        .iter()
                        .map(|axis| match axis {
                            Axis::Batch => ITEMS,
                            Axis::Objects => OBJECTS,
                            Axis::Fixed(n) => *n,
                            _ => info.side.expect("an image"),
                        })
                        .product();
                    if spec.name == "present" { vec![1.0; count] } else { (0..count).map(|_| value()).collect() }
                })
                .collect();
            let inputs: Vec<&[f32]> = inputs.iter().map(Vec::as_slice).collect();
            let mut outputs = vec![Vec::new(); info.interface.outputs.len()];
            model.run(ITEMS, OBJECTS, &inputs, &mut outputs).unwrap_or_else(|e| panic!("{e}"));
            // The same bits alone, on this backend as well.
            let one: Vec<&[f32]> = inputs.iter().map(|input| &input[input.len() / ITEMS * 2..]).collect();
            let mut alone = vec![Vec::new(); outputs.len()];
            model.run(1, OBJECTS, &one, &mut alone).unwrap_or_else(|e| panic!("{e}"));
            for (all, alone) in outputs.iter().zip(&alone) {
                assert_eq!(all[all.len() / ITEMS * 2..], alone[..], "{name}: the last item alone");
            }
            (name, outputs)
        })
        .collect()
}

/// What a child process answers.
fn ask(backend: Backend) -> Answers {
    let file: PathBuf = std::env::temp_dir().join(format!("jostle-tract-{}-{}.json", std::process::id(), backend.id()));
    let output = Command::new(std::env::current_exe().expect("this program"))
        .args(["--exact", "both_backends_give_the_same_answers", "--nocapture"])
        .env(VARIABLE, format!("{}={}", backend.id(), file.display()))
        .output()
        .expect("the child runs");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let text = std::fs::read_to_string(&file).expect("the child's answers");
    let _ = std::fs::remove_file(&file);
    serde_json::from_str(&text).expect("the child's answers are JSON")
}

#[test]
fn both_backends_give_the_same_answers() {
    if let Ok(order) = std::env::var(VARIABLE) {
        let (backend, file) = order.split_once('=').expect("BACKEND=FILE");
        let found = answers(Backend::by_name(backend).expect("a backend"));
        std::fs::write(file, serde_json::to_string(&found).expect("numbers")).expect("the file can be written");
        return;
    }
    let wanted = RuntimeOptions { library: None, backend: Some(Backend::OnnxRuntime) };
    if let Err(error) = Runtime::open(&wanted) {
        println!("ONNX Runtime is not here, so there is nothing to compare with: {error}");
        assert!(!ask(Backend::Tract).is_empty());
        return;
    }
    let (ort, tract) = (ask(Backend::OnnxRuntime), ask(Backend::Tract));
    assert_eq!(ort.keys().collect::<Vec<_>>(), tract.keys().collect::<Vec<_>>());
    for (name, ours) in &ort {
        let mut greatest = 0.0_f64;
        for (a, b) in ours.iter().flatten().zip(tract[name].iter().flatten()) {
            greatest = greatest.max(f64::from((a - b).abs()));
        }
        println!("{name}: greatest difference {greatest:.1e}");
        assert!(greatest <= TOLERANCE, "{name}: {greatest}");
    }
}
