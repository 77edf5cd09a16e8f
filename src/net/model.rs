//! A loaded network: tensors in, tensors out.

use std::borrow::Cow;
use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

use ort::ep::{self, ExecutionProvider};
use ort::logging::LogLevel;
use ort::session::builder::{GraphOptimizationLevel, SessionBuilder};
use ort::session::{RunOptions, Session, SessionInputValue};
use ort::value::TensorRef;

use super::file;
use super::info::{Configuration, ModelInfo};
use super::kind::{Axis, Interface, Kind, TensorSpec};
use super::onnx;
use super::runtime::{Backend, Runtime, RuntimeInfo, RuntimeOptions};
use super::watch::{WORTH_WATCHING, watched};
use crate::error::{Error, ModelFault, Result};
use crate::host::{Home, Standard};
use crate::run::{Budget, Stop, within};
use crate::scene::MAX_SIMULATED;

/// Longest time that a runtime may take to accept a network, and again to run its self-test. The biggest networks take a
/// few seconds.
const LONGEST: Duration = Duration::from_secs(60);

/// Where a network runs.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Device {
    #[default]
    Cpu,
    /// An NVIDIA graphics card by its number. Needs an ONNX Runtime that has the provider; results are not bit for bit.
    Cuda(i32),
}

/// How a network is loaded and run.
#[derive(Debug, Clone, PartialEq)]
pub struct LoadOptions {
    pub runtime: RuntimeOptions,
    pub device: Device,
    /// Threads of one call of the network. More than one pays for big networks that are called one at a time; planners
    /// have threads of their own.
    pub threads: usize,
    /// What it has to have been made for.
    pub configuration: Configuration,
    /// Refuse a file whose SHA-256 is not this (hexadecimal digits).
    pub sha256: Option<String>,
    /// Run the self-test.
    pub self_test: bool,
}

impl Default for LoadOptions {
    fn default() -> Self {
        Self {
            runtime: RuntimeOptions::default(),
            device: Device::Cpu,
            threads: 1,
            configuration: Configuration::default(),
            sha256: None,
            self_test: true,
        }
    }
}

/// A network ready to run. Cheap to clone.
///
/// Thread rule: shared freely between threads. The runtime's sessions serve one thread at a time, so every thread that runs
/// the network at the same time has a session of its own, made when it is first needed and kept.
///
/// Every call of the runtime has the same number of items ([`super::Interface::chunk`]): another number may take another
/// kernel, which rounds differently (ONNX Runtime 1.32: one item and four of a trained network differ in the last bits).
/// So the result of an item does not depend on the others, on how many there are, or on the thread: same input, same bits
/// (on a processor).
#[derive(Clone)]
pub struct Model {
    shared: Arc<Shared>,
}

struct Shared {
    info: ModelInfo,
    /// What sessions are made of.
    bytes: Cow<'static, [u8]>,
    runtime: &'static Runtime,
    device: Device,
    threads: usize,
    idle: Mutex<Vec<Worker>>,
    /// Where the threads of sessions live, if they have any.
    home: Home,
}

/// A session with the memory that fills up an incomplete chunk.
struct Worker {
    session: Session,
    filled: Vec<Vec<f32>>,
    usual: Usual,
}

/// What a call with so many bodies usually takes: the least of late, as a busy machine makes some of them longer.
#[derive(Debug, Clone, Copy, Default)]
struct Usual {
    objects: usize,
    seconds: f64,
    /// Calls that were not made since the last that was.
    refused: u32,
}

impl Usual {
    /// What to count on. More bodies take at least as many times longer. None before the first call.
    ///
    /// What was measured may be of a busy moment: the more calls are not made for it, the less is it believed.
    fn seconds(&self, objects: usize) -> Option<f64> {
        let times = (objects as f64 / self.objects.max(1) as f64).max(1.0);
        let doubt = (1.0 - DOUBTS).powf(self.refused.into());
        (self.seconds > 0.0).then_some(self.seconds * times * doubt)
    }

    fn note(&mut self, objects: usize, seconds: f64) {
        let before = if self.objects == objects { self.seconds } else { seconds };
        *self = Usual { objects, seconds: seconds.min(before + (seconds - before) * FORGETS), refused: 0 };
    }

    /// A call was ended before it had an answer: it takes longer than that, and the doubt was not justified.
    fn note_ended(&mut self, objects: usize, seconds: f64) {
        self.refused = 0;
        if self.seconds(objects).is_none_or(|usual| usual < seconds) {
            (self.objects, self.seconds) = (objects, seconds);
        }
    }

    /// A call was not made for what it usually takes. In the long run it is tried again.
    fn refuse(&mut self) {
        self.refused = self.refused.saturating_add(1);
    }
}

/// Most pairs of bodies in one call, over its items, where it has more than one: `ppn` holds a node of 3 ms at 32 768.
const MOST_PAIRS: usize = 32_768;

/// Share by which what is known of the time of calls follows later ones.
const FORGETS: f64 = 0.05;
/// Share by which each call that is not made lessens it: a call that was measured at twice its time is tried after 140.
const DOUBTS: f64 = 0.005;
/// A call is begun where this many times its usual time is left, for some take longer than the least of late.
const SPARE: f64 = 1.2;

/// Two are equal if they are the same loaded network.
impl PartialEq for Model {
    fn eq(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.shared, &other.shared)
    }
}

impl std::fmt::Debug for Model {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Model").field("path", &self.info().path).field("kind", &self.info().kind).finish()
    }
}

/// A session's raw result: for every output of the interface its shape and values.
pub(super) type RawOutputs = Vec<(Vec<i64>, Vec<f32>)>;

impl Model {
    /// Loads a file and checks it. `kind`: what it must be; any if absent.
    ///
    /// # Errors
    /// [`Error::Model`] names file, check, expected and found, in the order in which `docs/networks.md` lists the checks;
    /// [`Error::Runtime`] if nothing runs networks; [`Error::Io`] for a file that cannot be read.
    pub fn load(path: impl AsRef<Path>, kind: Option<Kind>, options: &LoadOptions) -> Result<Model> {
        let bytes = file::read(path.as_ref())?;
        Self::from_bytes(path.as_ref(), bytes, kind, options)
    }

    /// A network that is in memory. `path` is its name in messages.
    pub fn from_bytes(
        path: impl AsRef<Path>,
        bytes: impl Into<Cow<'static, [u8]>>,
        kind: Option<Kind>,
        options: &LoadOptions,
    ) -> Result<Model> {
        let (path, bytes) = (path.as_ref(), bytes.into());
        let onnx = file::check_bytes(path, &bytes)?;
        // Before a runtime sees it.
        let info = file::check(path, &bytes, onnx, kind, options)?;
        if options.threads == 0 || options.threads > 1024 {
            return Err(Error::argument("threads", format!("is {}; it must lie in 1 to 1024", options.threads)));
        }
        let runtime = Runtime::open(&options.runtime)?;
        let fixed = with_fixed_batch(&bytes, info.interface, runtime);
        let content = fixed.as_deref().unwrap_or(&bytes);
        let builder = builder(path, runtime, options.device, options.threads)?;
        let canceler = builder.canceler();
        let session = in_time(path, || drop(canceler.cancel()), || commit(path, builder, content, runtime))?;
        let bytes = fixed.map_or(bytes, Cow::Owned);
        let worker = Worker { session, filled: Vec::new(), usual: Usual::default() };
        let (device, threads) = (options.device, options.threads);
        let model = Model {
            shared: Arc::new(Shared {
                info,
                bytes,
                runtime,
                device,
                threads,
                idle: Mutex::new(vec![worker]),
                home: Home::here(),
            }),
        };
        if options.self_test {
            let stop = Budget::seconds(LONGEST.as_secs_f64()).start(&[]);
            super::self_test::run(&model, &stop)
                .map_err(|error| if stop.requested() { too_late(path) } else { error })?;
        }
        Ok(model)
    }

    pub fn info(&self) -> &ModelInfo {
        &self.shared.info
    }

    /// What it runs on.
    pub fn runtime(&self) -> &'static RuntimeInfo {
        self.shared.runtime.info()
    }

    /// Refuses a network of another kind.
    pub(crate) fn expect(&self, kind: Kind) -> Result<()> {
        if self.info().kind == kind {
            return Ok(());
        }
        Err(Error::model(&self.info().path, ModelFault::Kind, kind, self.info().kind))
    }

    /// Same input, same bits.
    pub(super) fn repeats_bits(&self) -> bool {
        self.shared.device == Device::Cpu
    }

    /// Whether the file has this input.
    pub(crate) fn has_input(&self, name: &str) -> bool {
        self.info().onnx.inputs.iter().any(|input| input.name == name)
    }

    /// Runs `items` items with `objects` bodies each (1 for networks that know no bodies). Inputs and outputs are in the
    /// interface's order, row-major; an input that the file does not have is not looked at. Outputs keep their memory.
    pub fn run(&self, items: usize, objects: usize, inputs: &[&[f32]], outputs: &mut [Vec<f32>]) -> Result<()> {
        self.run_until(items, objects, inputs, outputs, &Stop::never())
    }

    /// The same until the stop is requested: then it is an error ([`Error::State`]) and the outputs are not to be used. A call
    /// of ONNX Runtime that is under way ends between two nodes of the network.
    pub fn run_until(
        &self,
        items: usize,
        objects: usize,
        inputs: &[&[f32]],
        outputs: &mut [Vec<f32>],
        stop: &Stop,
    ) -> Result<()> {
        let interface = self.info().interface;
        if inputs.len() != interface.inputs.len() || outputs.len() != interface.outputs.len() {
            return Err(Error::Internal("a network was called with another number of tensors".into()));
        }
        if self.shared.threads > 1 {
            self.shared.home.check("network")?;
        }
        if objects > MAX_SIMULATED {
            return Err(Error::argument("objects", format!("is {objects}; networks run for at most {MAX_SIMULATED}")));
        }
        for (spec, input) in interface.inputs.iter().zip(inputs) {
            let wanted = items * self.stride(spec, objects);
            if self.has_input(spec.name) && input.len() != wanted {
                let reason = format!("has {} values for {items} items; {wanted} are needed", input.len());
                return Err(Error::argument(spec.name, reason));
            }
        }
        outputs.iter_mut().for_each(Vec::clear);
        if items == 0 {
            return Ok(());
        }
        let mut worker = self.worker()?;
        let mut done = Ok(());
        let chunk = self.chunk(objects);
        for first in (0..items).step_by(chunk) {
            let count = chunk.min(items - first);
            let usual = worker.usual.seconds(self.counted(objects));
            if usual.map_or_else(|| stop.requested(), |seconds| stop.leaves_less_than(seconds * SPARE)) {
                worker.usual.refuse();
                done = Err(interrupted());
            } else {
                done = self.run_chunk(&mut worker, first, count, objects, inputs, outputs, stop);
            }
            if done.is_err() {
                break;
            }
        }
        // Also after an error: another session takes long to make.
        self.give_back(worker);
        done
    }

    /// Runs one chunk and appends its outputs.
    #[allow(clippy::too_many_arguments)]
    fn run_chunk(
        &self,
        worker: &mut Worker,
        first: usize,
        count: usize,
        objects: usize,
        inputs: &[&[f32]],
        outputs: &mut [Vec<f32>],
        stop: &Stop,
    ) -> Result<()> {
        let interface = self.info().interface;
        let chunk = self.chunk(objects);
        worker.filled.resize_with(inputs.len(), Vec::new);
        let mut tensors: Vec<(&'static str, Vec<i64>, &[f32])> = Vec::with_capacity(inputs.len());
        for ((spec, input), filled) in interface.inputs.iter().zip(inputs).zip(&mut worker.filled) {
            if !self.has_input(spec.name) {
                continue;
            }
            let stride = self.stride(spec, objects);
            let mut values = &input[first * stride..(first + count) * stride];
            if count < chunk {
                filled.clear();
                filled.extend_from_slice(values);
                filled.resize(chunk * stride, 0.0);
                values = filled;
            }
            tensors.push((spec.name, self.shape(spec, objects), values));
        }
        // One that is known to be short needs no watch.
        let counted = self.counted(objects);
        let long = worker.usual.seconds(counted).is_none_or(|seconds| seconds > WORTH_WATCHING);
        let before = stop.elapsed();
        let watch = (stop.is_bounded() && long).then_some(stop);
        let results = self.run_session(&mut worker.session, &tensors, watch);
        let took = (stop.elapsed() - before).as_secs_f64();
        match &results {
            Ok(_) => worker.usual.note(counted, took),
            Err(_) => worker.usual.note_ended(counted, took),
        }
        let results = results?;
        for ((spec, (shape, values)), output) in interface.outputs.iter().zip(results).zip(outputs) {
            let wanted = self.shape(spec, objects);
            if shape != wanted {
                let text = |shape: &[i64]| format!("`{}` of shape {shape:?}", spec.name);
                return Err(Error::model(&self.info().path, ModelFault::Run, text(&wanted), text(&shape)));
            }
            // What fills the call up has no bodies: nobody asked what such an item does.
            let values = &values[..count * self.stride(spec, objects)];
            self.check_finite(spec, values)?;
            output.extend_from_slice(values);
        }
        Ok(())
    }

    /// Runs one call with shapes of the caller's, for which the network's sizes are looked at again.
    pub(super) fn run_free(
        &self,
        tensors: &[(&'static str, Vec<i64>, &[f32])],
        stop: Option<&Stop>,
    ) -> Result<RawOutputs> {
        let sizes: Vec<(&str, Vec<u64>)> =
            tensors.iter().map(|(name, shape, _)| (*name, shape.iter().map(|n| n.unsigned_abs()).collect())).collect();
        file::check_call(&self.info().path, &self.shared.bytes, &sizes)?;
        let mut worker = self.worker()?;
        let results = self.run_session(&mut worker.session, tensors, stop);
        self.give_back(worker);
        let results = results?;
        for (spec, (_, values)) in self.info().interface.outputs.iter().zip(&results) {
            self.check_finite(spec, values)?;
        }
        Ok(results)
    }

    fn check_finite(&self, spec: &TensorSpec, values: &[f32]) -> Result<()> {
        let Some(at) = values.iter().position(|v| !v.is_finite()) else { return Ok(()) };
        let found = format!("{} as value {at} of `{}`", values[at], spec.name);
        Err(Error::model(&self.info().path, ModelFault::Run, "finite numbers", found))
    }

    /// One call of the runtime, under watch of a stop or not.
    fn run_session(
        &self,
        session: &mut Session,
        tensors: &[(&'static str, Vec<i64>, &[f32])],
        watch: Option<&Stop>,
    ) -> Result<RawOutputs> {
        // The runtime changes the thread's state, and its results follow it.
        let _standard = Standard::enter();
        let path = &self.info().path;
        let failed = |error: ort::Error| Error::model(path, ModelFault::Run, "a result", error.message());
        let mut values: Vec<(&str, SessionInputValue<'_>)> = Vec::with_capacity(tensors.len());
        for (name, shape, data) in tensors {
            let tensor = TensorRef::from_array_view((shape.as_slice(), *data)).map_err(failed)?;
            values.push((name, tensor.into()));
        }
        let options = watch.and_then(|stop| Some((stop, RunOptions::new().ok()?)));
        let found = match &options {
            Some((stop, options)) => watched(options, stop, || session.run_with_options(values, options)),
            None => session.run(values),
        };
        if watch.is_some_and(Stop::requested) {
            return Err(interrupted());
        }
        let found = found.map_err(failed)?;
        let mut results = RawOutputs::with_capacity(found.len());
        for spec in self.info().interface.outputs {
            let Some(value) = found.get(spec.name) else {
                return Err(Error::model(path, ModelFault::Run, format!("an output `{}`", spec.name), "none"));
            };
            let (shape, data) = if spec.integer {
                let (shape, data) = value.try_extract_tensor::<i64>().map_err(failed)?;
                (shape.to_vec(), data.iter().map(|n| *n as f32).collect::<Vec<_>>())
            } else {
                let (shape, data) = value.try_extract_tensor::<f32>().map_err(failed)?;
                (shape.to_vec(), data.to_vec())
            };
            results.push((shape, data));
        }
        Ok(results)
    }

    /// Items of one call of the runtime: fewer in large scenes, as a call ends at a limit or a cancel between two nodes, and
    /// a node's work grows with the square of the bodies.
    fn chunk(&self, objects: usize) -> usize {
        let most = self.info().interface.chunk;
        if self.shared.runtime.info().backend == Backend::Tract {
            // Loaded for this many.
            return most;
        }
        let pairs = self.counted(objects).pow(2);
        let mut chunk = most;
        while chunk > 1 && chunk * pairs > MOST_PAIRS {
            chunk = chunk.div_ceil(2);
        }
        chunk
    }

    /// The bodies that the time of a call depends on.
    fn counted(&self, objects: usize) -> usize {
        let by_object = self.info().interface.inputs.iter().any(|spec| spec.axes.contains(&Axis::Objects));
        if by_object { objects } else { 1 }
    }

    /// The tensor's shape in a call of the runtime.
    fn shape(&self, spec: &TensorSpec, objects: usize) -> Vec<i64> {
        spec.axes.iter().map(|axis| self.extent(*axis, objects) as i64).collect()
    }

    /// Values of one item.
    pub(super) fn stride(&self, spec: &TensorSpec, objects: usize) -> usize {
        spec.axes.iter().filter(|axis| **axis != Axis::Batch).map(|axis| self.extent(*axis, objects)).product()
    }

    fn extent(&self, axis: Axis, objects: usize) -> usize {
        let side = self.info().side.unwrap_or(0);
        match axis {
            Axis::Batch => self.chunk(objects),
            Axis::Objects => objects,
            Axis::Fixed(n) => n,
            Axis::Side | Axis::Free => side,
            Axis::HalfSide => side / 2,
            Axis::Found => 0,
        }
    }

    fn worker(&self) -> Result<Worker> {
        let shared = &self.shared;
        if let Some(worker) = shared.idle.lock().unwrap_or_else(PoisonError::into_inner).pop() {
            return Ok(worker);
        }
        let path = &shared.info.path;
        let builder = builder(path, shared.runtime, shared.device, shared.threads)?;
        let session = commit(path, builder, &shared.bytes, shared.runtime)?;
        Ok(Worker { session, filled: Vec::new(), usual: Usual::default() })
    }

    fn give_back(&self, worker: Worker) {
        self.shared.idle.lock().unwrap_or_else(PoisonError::into_inner).push(worker);
    }
}

/// For the embedded backend: the file with the batch that every call has. It chooses its kernels when it loads, and the
/// good ones only where it knows the shapes. ONNX Runtime looks at the shapes of a call.
fn with_fixed_batch(bytes: &[u8], interface: &Interface, runtime: &Runtime) -> Option<Vec<u8>> {
    if runtime.info().backend != Backend::Tract {
        return None;
    }
    onnx::with_batch(bytes, interface.chunk as u64).ok()
}

/// Does a part of loading a network; what lasts longer than it may is told to end, and then is a fault of its own.
fn in_time<R>(path: &Path, stop: impl FnOnce() + Send, work: impl FnOnce() -> Result<R>) -> Result<R> {
    let late = AtomicBool::new(false);
    let end = || {
        late.store(true, Ordering::Relaxed);
        stop();
    };
    let result = within(LONGEST, end, work)?;
    if result.is_err() && late.load(Ordering::Relaxed) {
        return Err(too_late(path));
    }
    result
}

fn too_late(path: &Path) -> Error {
    let expected = format!("an end within {} s", LONGEST.as_secs());
    Error::model(path, ModelFault::Deadline, expected, "a network that was still at work")
}

fn refused(path: &Path, runtime: &Runtime, error: &ort::Error) -> Error {
    let expected = format!("a network that {} accepts", runtime.info());
    Error::model(path, ModelFault::Session, expected, error.message())
}

fn interrupted() -> Error {
    Error::State("the network was asked to end before it had an answer".into())
}

/// A session of the runtime.
fn commit(path: &Path, mut builder: SessionBuilder, bytes: &[u8], runtime: &Runtime) -> Result<Session> {
    // The first session of a process sets the thread's floating-point state.
    let _standard = Standard::enter();
    builder.commit_from_memory(bytes).map_err(|e| refused(path, runtime, &e))
}

/// The settings of a session.
fn builder(path: &Path, runtime: &Runtime, device: Device, threads: usize) -> Result<SessionBuilder> {
    let _standard = Standard::enter();
    let mut builder = Session::builder(runtime.environment()).map_err(|e| refused(path, runtime, &e))?;
    // A backend that does not know a setting goes without it.
    // ONNX Runtime optimises unasked; the embedded backend only where it is asked to.
    builder = builder.with_optimization_level(GraphOptimizationLevel::All).unwrap_or_else(|e| e.recover());
    builder = builder.with_intra_threads(threads).unwrap_or_else(|e| e.recover());
    builder = builder.with_inter_threads(1).unwrap_or_else(|e| e.recover());
    builder = builder.with_intra_op_spinning(false).unwrap_or_else(|e| e.recover());
    builder = builder.with_inter_op_spinning(false).unwrap_or_else(|e| e.recover());
    builder = builder.with_log_level(LogLevel::Fatal).unwrap_or_else(|e| e.recover());
    if let Device::Cuda(number) = device {
        if runtime.info().backend != Backend::OnnxRuntime || !ep::CUDA::is_available().unwrap_or(false) {
            return Err(Error::Unsupported(format!(
                "device: CUDA was asked for, but {} has no CUDA provider; name the library of a GPU build in \
                 `runtime.library`, or use the CPU",
                runtime.info()
            )));
        }
        let provider = ep::CUDA::default().with_device_id(number).build().error_on_failure();
        builder = builder
            .with_execution_providers([provider])
            .map_err(|e| Error::Unsupported(format!("device: CUDA device {number} cannot be used: {}", e.message())))?;
    }
    Ok(builder)
}

#[cfg(test)]
mod tests {
    use super::Usual;

    #[test]
    fn the_usual_time_follows_the_least_and_never_sticks() {
        let mut usual = Usual::default();
        assert_eq!(usual.seconds(5), None);
        usual.note(5, 0.010);
        assert_eq!((usual.seconds(5), usual.seconds(2), usual.seconds(20)), (Some(0.010), Some(0.010), Some(0.040)));
        // One that the machine held up says little; a shorter one is believed.
        usual.note(5, 0.110);
        assert!((usual.seconds(5).unwrap() - 0.015).abs() < 1e-12);
        usual.note(5, 0.008);
        assert_eq!(usual.seconds(5), Some(0.008));
        // Ended calls raise it, and what is not tried for it is tried in the end.
        usual.note_ended(5, 0.002);
        assert_eq!(usual.seconds(5), Some(0.008));
        usual.note_ended(5, 0.020);
        assert_eq!(usual.seconds(5), Some(0.020));
        (0..140).for_each(|_| usual.refuse());
        assert!(usual.seconds(5).unwrap() < 0.010, "twice the time");
        // Tried for the doubt, and it does take longer than what there was.
        usual.note_ended(5, 0.005);
        assert_eq!(usual.seconds(5), Some(0.020));
        (0..10_000).for_each(|_| usual.refuse());
        assert!(usual.seconds(5).unwrap() < 1e-9);
        usual.note(7, 0.5);
        assert_eq!(usual.seconds(7), Some(0.5));
    }
}
