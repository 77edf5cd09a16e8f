//! What a network's file says: kind, interface, and the settings it was made for.

use std::path::{Path, PathBuf};

use serde::Deserialize;

use super::kind::{Interface, Kind};
use super::onnx::{OnnxInfo, TensorInfo};
use crate::error::{Error, ModelFault, Result};

/// The settings that a network was made for (metadata `spec`). What a kind does not have is absent.
#[derive(Debug, Clone, PartialEq, Default, Deserialize)]
#[serde(default)]
pub struct ModelSpec {
    /// Points of an outline.
    pub outline_points: Option<usize>,
    /// What the input `guess` holds: "planar" or "none".
    pub guess: Option<String>,
    /// Most bodies of a training scene. More are allowed, and less certain.
    pub max_objects: Option<usize>,
    /// Least and greatest length of a training push, metres.
    pub lengths: Option<[f64; 2]>,
    /// The engine that it was trained on.
    pub engine: Option<String>,
    /// Side of a pixel, metres.
    pub pixel: Option<f64>,
    /// Side of the image, pixels.
    pub size: Option<usize>,
    /// Name of the gripper.
    pub gripper: Option<String>,
    /// Closing directions over half a turn.
    pub angles: Option<usize>,
    /// The output from which on the answer is yes.
    pub threshold: Option<f64>,
}

/// What is known of a network without running it.
#[derive(Debug, Clone, PartialEq)]
pub struct ModelInfo {
    /// The file, or the built-in network's name.
    pub path: PathBuf,
    pub bytes: usize,
    /// Of the whole file, in hexadecimal digits.
    pub sha256: String,
    pub kind: Kind,
    pub interface: &'static Interface,
    pub spec: ModelSpec,
    pub onnx: OnnxInfo,
    /// The image's side, for networks that take images.
    pub side: Option<usize>,
    /// What does not keep it from being used.
    pub warnings: Vec<String>,
    /// It was loaded to be used with whatever gripper ([`Configuration::tolerate`]).
    pub tolerated: bool,
}

impl ModelInfo {
    /// A property of the file's metadata; empty if it has none.
    pub fn property(&self, key: &str) -> &str {
        self.onnx.metadata.get(key).map_or("", String::as_str)
    }

    /// All of it, for reports.
    pub fn to_json(&self) -> serde_json::Value {
        let list = |tensors: &[TensorInfo]| tensors.iter().map(TensorInfo::to_string).collect::<Vec<_>>();
        serde_json::json!({
            "file": self.path.display().to_string(),
            "bytes": self.bytes,
            "sha256": self.sha256,
            "kind": self.kind.id(),
            "interface": self.interface.number,
            "opset": self.onnx.opset,
            "ir_version": self.onnx.ir_version,
            "producer": self.onnx.producer,
            "inputs": list(&self.onnx.inputs),
            "outputs": list(&self.onnx.outputs),
            "metadata": self.onnx.metadata,
            "warnings": self.warnings,
        })
    }

    /// The gripper it was trained for.
    pub fn gripper(&self) -> Option<&str> {
        self.spec.gripper.as_deref()
    }

    /// The output from which on the answer is yes.
    pub fn threshold(&self) -> f64 {
        self.spec.threshold.unwrap_or(0.5)
    }

    /// Side of a pixel, metres.
    pub fn pixel(&self) -> f64 {
        self.spec.pixel.unwrap_or(0.002)
    }
}

/// What a network has to have been made for. Absent: anything.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Configuration {
    /// Name of the gripper.
    pub gripper: Option<String>,
    /// Side of a pixel, metres.
    pub pixel: Option<f64>,
    /// Side of the image, pixels.
    pub size: Option<usize>,
    /// Differences become warnings, and planners do not ask for the network's gripper.
    pub tolerate: bool,
}

/// Check 6: the settings that a file names fit its kind and tensors.
pub(super) fn read_spec(path: &Path, kind: Kind, onnx: &OnnxInfo, side: Option<usize>) -> Result<ModelSpec> {
    let wrong = |expected: String, found: String| Error::model(path, ModelFault::Spec, expected, found);
    let property = |key: &str| onnx.metadata.get(key).map(String::as_str).filter(|text| !text.is_empty());
    let mut spec: ModelSpec = match property("spec") {
        None => ModelSpec::default(),
        Some(text) => serde_json::from_str(text)
            .map_err(|e| wrong("metadata `spec` that is a JSON object of settings".into(), format!("{e}")))?,
    };
    if let Some(gripper) = property("gripper") {
        spec.gripper = Some(gripper.into());
    }
    if let Some(text) = property("threshold") {
        let number = text.parse().map_err(|_| wrong("metadata `threshold` that is a number".into(), text.into()))?;
        spec.threshold = Some(number);
    }
    let needed = |name: &str, value: Option<String>, wanted: Option<String>| match (value, wanted) {
        (None, _) => Err(wrong(format!("metadata `spec` with `{name}`"), "none".into())),
        (Some(value), Some(wanted)) if value != wanted => {
            Err(wrong(format!("`{name}` {wanted}, as its tensors have it"), value))
        }
        _ => Ok(()),
    };
    if let Some(threshold) = spec.threshold.filter(|t| !(0.0..=1.0).contains(t)) {
        return Err(wrong("`threshold` of 0 to 1".into(), threshold.to_string()));
    }
    let number = |n: usize| n.to_string();
    match kind {
        Kind::Dipn | Kind::Ppn => {
            let points = Some(number(super::kind::OUTLINE_POINTS));
            needed("outline_points", spec.outline_points.map(number).or(points.clone()), points)?;
            if kind == Kind::Dipn {
                let has = onnx.inputs.iter().any(|input| input.name == "guess");
                match spec.guess.as_deref() {
                    Some("planar") if has => {}
                    Some("planar") => {
                        return Err(wrong("an input `guess`, as `guess` is \"planar\"".into(), "none".into()));
                    }
                    Some("none") | None => {}
                    Some(other) => return Err(wrong("`guess` \"planar\" or \"none\"".into(), format!("\"{other}\""))),
                }
            }
        }
        Kind::Gc | Kind::Gn | Kind::Segmentation => {
            if let Some(side) = side {
                needed("size", spec.size.map(number), Some(number(side)))?;
                needed("pixel", spec.pixel.map(|p| p.to_string()), None)?;
            }
            if let Some(pixel) = spec.pixel.filter(|p| !(1e-4..=0.1).contains(p)) {
                return Err(wrong("`pixel` of 0.0001 to 0.1 metres".into(), pixel.to_string()));
            }
            if kind == Kind::Gn {
                let angles = number(super::kind::GRASP_ANGLES);
                needed("angles", spec.angles.map(number).or(Some(angles.clone())), Some(angles))?;
            }
            if kind != Kind::Segmentation {
                needed("gripper", spec.gripper.clone(), None)?;
            }
        }
    }
    Ok(spec)
}

/// Check 6, second part: the settings are those that the user has.
pub(super) fn check_configuration(info: &mut ModelInfo, wanted: &Configuration) -> Result<()> {
    info.tolerated = wanted.tolerate;
    let mut faults: Vec<(String, String)> = Vec::new();
    if let (Some(wanted), Some(found)) = (&wanted.gripper, info.gripper())
        && wanted != found
    {
        faults.push((format!("the gripper `{wanted}`"), format!("`{found}`")));
    }
    if let (Some(wanted), Some(found)) = (wanted.pixel, info.spec.pixel)
        && (wanted - found).abs() > 1e-9
    {
        faults.push((format!("pixels of {wanted} m"), format!("{found} m")));
    }
    if let (Some(wanted), Some(found)) = (wanted.size, info.side)
        && wanted != found
    {
        faults.push((format!("images of {wanted} pixels a side"), format!("{found}")));
    }
    for (expected, found) in faults {
        if !wanted.tolerate {
            return Err(Error::model(&info.path, ModelFault::Spec, expected, found));
        }
        info.warnings.push(format!("{}: expected {expected}; found {found}", ModelFault::Spec));
    }
    Ok(())
}
