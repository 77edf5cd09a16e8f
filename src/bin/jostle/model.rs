//! `jostle model`: what a network's file is, and its checks.

use std::path::Path;

use jostle::Error;
use jostle::net::{
    BUILTINS, Builtin, Kind, LoadOptions, Model, ModelInfo, Runtime, RuntimeInfo, RuntimeOptions, inspect,
    inspect_bytes,
};
use serde_json::{Value, json};

use crate::args::ModelArgs;
use crate::output::{self, Outcome};

pub fn run(args: &ModelArgs) -> Outcome<()> {
    let runtime = Runtime::open(&RuntimeOptions { library: args.runtime.clone(), backend: None });
    let Some(name) = &args.model else { return list(args, runtime.map(Runtime::info)) };
    let kind = args.kind.as_deref().map(Kind::by_name).transpose()?;
    let options = LoadOptions::default();
    // What can be known without a runtime comes first: the file's own faults.
    let info = match Builtin::find(name) {
        Ok(builtin) => inspect_bytes(Path::new(name), builtin.bytes, kind, &options)?,
        Err(_) => inspect(Path::new(name), kind, &options)?,
    };
    let loaded = runtime.is_ok().then(|| Model::open(name, kind, &options));
    let checks = match &loaded {
        None => "the file's own passed; no runtime here for the self-test".to_string(),
        Some(Ok(_)) => "all passed".into(),
        Some(Err(error)) => error.to_string(),
    };
    let mut report = info.to_json();
    report["checks"] = checks.clone().into();
    report["runtime"] = match &runtime {
        Ok(runtime) => runtime.info().to_json(),
        Err(error) => error.to_string().into(),
    };
    output::report(args.json.json.as_deref(), &report, &text(&info, &checks, runtime.map(Runtime::info)))?;
    match loaded {
        Some(Err(error)) => Err(error.into()),
        _ => Ok(()),
    }
}

fn text(info: &ModelInfo, checks: &str, runtime: Result<&RuntimeInfo, Error>) -> String {
    let report = info.to_json();
    let mut text = format!(
        "{}\n  kind       {}, interface {}\n  size       {} bytes, sha256 {}\n  operators  version {}, IR {}\n",
        info.path.display(),
        info.kind,
        info.interface.number,
        info.bytes,
        info.sha256,
        info.onnx.opset,
        info.onnx.ir_version,
    );
    for (label, key) in [("inputs", "inputs"), ("outputs", "outputs"), ("warnings", "warnings")] {
        for line in report[key].as_array().into_iter().flatten().filter_map(Value::as_str) {
            text += &format!("  {label:<10} {line}\n");
        }
    }
    for (key, value) in info.onnx.metadata.iter().filter(|(key, _)| *key != "selftest") {
        text += &format!("  {key:<10} {value}\n");
    }
    text += &format!("  checks     {checks}\n");
    text += &match runtime {
        Ok(runtime) => format!("  runtime    {runtime}\n"),
        Err(error) => format!("  runtime    {error}\n"),
    };
    text
}

/// The built-in networks, and what runs them.
fn list(args: &ModelArgs, runtime: Result<&RuntimeInfo, Error>) -> Outcome<()> {
    let models: Vec<Value> = BUILTINS
        .iter()
        .map(|b| json!({ "name": b.name, "kind": b.kind, "bytes": b.bytes.len(), "sha256": b.sha256 }))
        .collect();
    let mut text = String::new();
    for b in BUILTINS {
        text += &format!("{:<16} {:<14} {:>9} bytes\n", b.name, b.kind, b.bytes.len());
    }
    if BUILTINS.is_empty() {
        text += "no built-in networks\n";
    }
    let runtime = match runtime {
        Ok(runtime) => {
            text += &format!("runtime: {runtime}\n");
            runtime.to_json()
        }
        Err(error) => {
            text += &format!("runtime: {error}\n");
            error.to_string().into()
        }
    };
    output::report(args.json.json.as_deref(), &json!({ "builtin": models, "runtime": runtime }), &text)
}
