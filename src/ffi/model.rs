//! Networks: files and built-in ones, and what runs them.

use std::ffi::c_char;
use std::path::PathBuf;
use std::sync::Arc;

use super::abi::{Sized32, boolean, fill_text, init_sized, optional_text, out_handle, read_sized_or_default, text};
use super::context::{Context, jostle_context};
use super::guard::{free, guard};
use super::handle::{Kind, Object};
use super::log::Log;
use super::status::{Failure, jostle_status};
use crate::error::Error;
use crate::net::{self, Backend, Configuration, Device, LoadOptions, Model, Runtime, RuntimeOptions};

/// A network that is ready to run. It does not change and may be used by any number of planners. Opaque.
pub struct jostle_model(());

/// Networks run on the processor.
pub const JOSTLE_DEVICE_CPU: i32 = -1;

/// How a network is loaded and run. Texts are copied.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct jostle_model_options {
    /// Set by jostle_model_options_default().
    pub struct_size: u32,
    /// JOSTLE_DEVICE_CPU (the default), or the number of an NVIDIA graphics card: then ONNX Runtime needs its CUDA
    /// provider, and results are not bit for bit.
    pub device: i32,
    /// Threads of one call of the network, 1 by default. More pay for big networks that are called one at a time;
    /// planners have threads of their own.
    pub threads: u32,
    /// 1 (the default) runs the file's self-test.
    pub self_test: u32,
    /// File of ONNX Runtime's shared library; null (the default) to look for it (docs/networks.md says where). A process
    /// has one runtime, that of the first network it loads.
    pub runtime: *const c_char,
    /// "onnxruntime" or "tract" (where it was built in); null (the default) for the first that is found.
    pub backend: *const c_char,
    /// Name of the gripper that it must have been made for; null (the default) for any.
    pub gripper: *const c_char,
    /// SHA-256 that the file must have, hexadecimal digits; null (the default) for any.
    pub sha256: *const c_char,
    /// 1 lets a network for another gripper pass, here (jostle_model_info() has a warning then) and in planners. 0 by default.
    pub tolerate: u32,
    /// 0.
    pub reserved: u32,
}

// SAFETY: repr(C), struct_size first, numbers and pointers without padding.
unsafe impl Sized32 for jostle_model_options {
    const NAME: &'static str = "jostle_model_options";
    const FIRST_SIZE: usize = 56;
    fn defaults() -> Self {
        jostle_model_options {
            struct_size: size_of::<Self>() as u32,
            device: JOSTLE_DEVICE_CPU,
            threads: 1,
            self_test: 1,
            runtime: std::ptr::null(),
            backend: std::ptr::null(),
            gripper: std::ptr::null(),
            sha256: std::ptr::null(),
            tolerate: 0,
            reserved: 0,
        }
    }
}

pub(super) struct LoadedModel {
    log: Arc<Log>,
    pub model: Model,
}

impl Object for LoadedModel {
    const KIND: Kind = Kind::Model;
    type Handle = jostle_model;
    fn log(&self) -> &Arc<Log> {
        &self.log
    }
}

/// Sets every field to its default; `size` is sizeof(jostle_model_options) as the caller was compiled.
/// jostle_model_options_default() in this header does it for you.
///
/// Thread: any.
/// RT: yes.
/// Nullable: none.
/// Owns: the caller.
/// Errors: ARGUMENT (null, a size that no version has).
#[unsafe(no_mangle)]
pub unsafe extern "C" fn jostle_model_options_init(options: *mut jostle_model_options, size: usize) -> jostle_status {
    // SAFETY: the caller promises `size` writable bytes.
    guard("jostle_model_options_init", |_| unsafe { init_sized(options, "options", size) })
}

/// Loads a network and checks it: `name` is a built-in network's name, such as "gc", or the path of an ONNX file. `kind` is
/// what it must be: "dipn", "ppn", "gc", "gn" or "segmentation"; null for any.
///
/// Every check has its own status, and the message names the file, what was expected and what was found. A failed load
/// leaves nothing behind, except that a runtime that was found stays loaded.
///
/// Thread: any.
/// RT: no.
/// Nullable: kind, options (all defaults).
/// Owns: the caller owns *model and frees it with jostle_model_free; `options` is copied.
/// Errors: ARGUMENT (null, an option: the message names it), HANDLE, NOT_FOUND (no such file, network, kind or backend), IO,
/// MODEL_EMPTY, MODEL_TOO_BIG, MODEL_LFS_POINTER, MODEL_PARSE, MODEL_HASH, MODEL_EXTERNAL, MODEL_OPERATOR, MODEL_KIND,
/// MODEL_INTERFACE, MODEL_IO_MISMATCH, MODEL_SPEC_MISMATCH, MODEL_SIZE, MODEL_RUNTIME, MODEL_SESSION, MODEL_SELFTEST,
/// MODEL_DEADLINE, UNSUPPORTED (device), MEMORY, ABI.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn jostle_model_load(
    context: *const jostle_context,
    name: *const c_char,
    kind: *const c_char,
    options: *const jostle_model_options,
    model: *mut *mut jostle_model,
) -> jostle_status {
    guard("jostle_model_load", |call| {
        // SAFETY: the caller promises a writable place.
        let out = unsafe { out_handle(model, "model") }?;
        let context = call.open::<Context>(context, "context")?;
        // SAFETY: the caller promises texts and an initialised struct.
        let (name, kind, o, runtime, backend, gripper, sha256) = unsafe {
            let o = read_sized_or_default(options, "options")?;
            (
                text(name, "name")?,
                optional_text(kind, "kind")?,
                o,
                optional_text(o.runtime, "options.runtime")?,
                optional_text(o.backend, "options.backend")?,
                optional_text(o.gripper, "options.gripper")?,
                optional_text(o.sha256, "options.sha256")?,
            )
        };
        let device = match o.device {
            JOSTLE_DEVICE_CPU => Device::Cpu,
            number if number >= 0 => Device::Cuda(number),
            other => return Err(Failure::argument("options.device", format!("is {other}; it must be -1 or more"))),
        };
        let backend = backend.map(Backend::by_name).transpose().map_err(c_field)?;
        let options = LoadOptions {
            runtime: RuntimeOptions { library: runtime.map(PathBuf::from), backend },
            device,
            threads: o.threads as usize,
            configuration: Configuration {
                gripper: gripper.map(String::from),
                tolerate: boolean(o.tolerate, "options.tolerate")?,
                ..Configuration::default()
            },
            sha256: sha256.map(String::from),
            self_test: boolean(o.self_test, "options.self_test")?,
        };
        let kind = kind.map(net::Kind::by_name).transpose()?;
        let model = Model::open(name, kind, &options).map_err(c_field)?;
        out.give(LoadedModel { log: Arc::clone(&context.log), model })
    })
}

/// Puts the C names of options in place of the Rust ones.
fn c_field(error: Error) -> Failure {
    match error {
        Error::Argument { field, reason } if field == "threads" => {
            Error::Argument { field: "options.threads".into(), reason }.into()
        }
        Error::NotFound { field, reason } if field == "runtime.backend" => {
            Error::NotFound { field: "options.backend".into(), reason }.into()
        }
        Error::NotFound { field, reason } if field == "model" => {
            Error::NotFound { field: "name".into(), reason }.into()
        }
        other => other.into(),
    }
}

/// Copies what is known of a network as JSON text: file, kind, interface, hash, metadata, inputs, outputs, warnings, and
/// what runs it. `length` counts the closing zero.
///
/// Thread: shared use of model.
/// RT: no.
/// Nullable: buffer (with capacity 0: asks for the length).
/// Owns: the caller owns the buffer.
/// Errors: ARGUMENT (null), HANDLE, BUFFER (length was written).
#[unsafe(no_mangle)]
pub unsafe extern "C" fn jostle_model_info(
    model: *const jostle_model,
    buffer: *mut c_char,
    capacity: usize,
    length: *mut usize,
) -> jostle_status {
    guard("jostle_model_info", |call| {
        if length.is_null() {
            return Err(Failure::null("length"));
        }
        let loaded = call.open::<LoadedModel>(model, "model")?;
        let mut json = loaded.model.info().to_json();
        json["runtime"] = loaded.model.runtime().to_json();
        // SAFETY: the caller promises room for `capacity` characters.
        unsafe { fill_text(buffer, capacity, length, &json.to_string()) }
    })
}

/// Frees a network. Planners that were made with it keep it until they are freed themselves.
///
/// Thread: any.
/// RT: no.
/// Nullable: model (does nothing).
/// Owns: the handle is dead afterwards.
/// Errors: none returned; a dead handle leaves a message in jostle_last_error().
#[unsafe(no_mangle)]
pub unsafe extern "C" fn jostle_model_free(model: *mut jostle_model) {
    free::<LoadedModel>("jostle_model_free", model, "model", false);
}

/// Copies which runtime this process runs networks with, as JSON text: backend, version, file, build. Looks for one if none
/// was used yet. `length` counts the closing zero.
///
/// Thread: any.
/// RT: no.
/// Nullable: buffer (with capacity 0: asks for the length).
/// Owns: the caller owns the buffer.
/// Errors: ARGUMENT (null), BUFFER (length was written), MODEL_RUNTIME (there is none; the message says what was tried).
#[unsafe(no_mangle)]
pub unsafe extern "C" fn jostle_runtime_info(
    buffer: *mut c_char,
    capacity: usize,
    length: *mut usize,
) -> jostle_status {
    guard("jostle_runtime_info", |_| {
        if length.is_null() {
            return Err(Failure::null("length"));
        }
        let runtime = Runtime::open(&RuntimeOptions::default())?;
        // SAFETY: the caller promises room for `capacity` characters.
        unsafe { fill_text(buffer, capacity, length, &runtime.info().to_json().to_string()) }
    })
}
