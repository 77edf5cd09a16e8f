//! A folder of shards: what is there already is kept, what is missing is made, and a manifest says what it all is.
//!
//! Shard `k` holds the rows of its own scenes, which are numbered within the shard: it is the same whatever shards were
//! made before it, on any number of threads. Every file is written under another name and then renamed, so that an end
//! at any moment leaves whole shards, with which the next run goes on.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;
use std::sync::Mutex;

use serde::{Deserialize, Serialize};
use serde_json::Value;

use super::shapes::ShapeFamily;
use super::tensors::{Tensor, file, sha256};
use crate::error::{Error, Result, check_range};
use crate::files::{self, json};
use crate::run::{Key, Pool, Stop};

/// The name of the manifest in its folder.
pub const MANIFEST: &str = "manifest.json";
/// The name of the file of shapes in its folder.
pub const SHAPES: &str = "shapes.safetensors";
/// Greatest number of rows of a shard.
pub const MAX_SHARD: usize = 65_536;
/// Scenes made between two looks at how many rows there are.
const WAVE: usize = 64;
/// Scenes of a shard, at most: the places that a shard has among the scenes' numbers.
const SCENES: u64 = 1 << 20;

/// Sums over the rows of a shard, by name.
pub type Statistics = BTreeMap<String, f64>;

/// A shard that is there.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ShardEntry {
    pub file: String,
    /// Rows.
    pub count: usize,
    /// Of the file, in hexadecimal digits.
    pub sha256: String,
    pub statistics: Statistics,
}

/// The file of shapes.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ShapesEntry {
    pub file: String,
    pub count: usize,
    pub seed: u64,
    pub sha256: String,
    /// Shapes of each split.
    pub splits: BTreeMap<String, usize>,
}

/// What a folder holds. Neither time nor threads are noted: equal data have equal manifests.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Manifest {
    /// Name and number of the shards' format, such as `jostle/push/1`.
    pub format: String,
    pub kind: String,
    /// Version of the library that made the data.
    pub jostle: String,
    pub seed: u64,
    /// Rows asked for.
    pub count: usize,
    /// Rows of a shard.
    pub shard: usize,
    /// All that the rows depend on besides the seed.
    pub configuration: Value,
    pub shapes: ShapesEntry,
    pub shards: Vec<ShardEntry>,
    /// Sums over all shards.
    pub statistics: Statistics,
}

/// Where the data goes, and how much of it.
#[derive(Debug, Clone, PartialEq)]
pub struct StoreParams {
    /// Rows.
    pub count: usize,
    /// Rows of a shard, at most [`MAX_SHARD`].
    pub shard: usize,
    pub seed: u64,
    pub threads: usize,
}

impl Default for StoreParams {
    fn default() -> Self {
        StoreParams { count: 16_384, shard: 16_384, seed: 0, threads: 1 }
    }
}

impl StoreParams {
    fn validate(&self) -> Result<()> {
        check_range("count", self.count as f64, 1.0..=1e9)?;
        check_range("shard", self.shard as f64, 1.0..=MAX_SHARD as f64)
    }
}

/// How far the making of a folder is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Made {
    /// Rows, those found included.
    pub rows: usize,
    /// Rows asked for.
    pub of: usize,
}

/// The rows of a scene, with what is to be summed over them.
#[derive(Debug)]
pub(super) struct SceneRows<R> {
    pub rows: Vec<R>,
    pub statistics: Statistics,
}

impl<R> Default for SceneRows<R> {
    fn default() -> Self {
        SceneRows { rows: Vec::new(), statistics: Statistics::new() }
    }
}

/// A kind of training data.
pub(super) trait Task: Sync {
    type Row: Send;
    /// Working memory of a thread.
    type Worker: Send;

    /// `push`, for the format `jostle/push/1` and the files `push-00000.safetensors`.
    fn kind(&self) -> &'static str;
    fn configuration(&self) -> Result<Value>;
    fn worker(&self) -> Result<Self::Worker>;
    /// Most rows of a scene.
    fn rows_of_scene(&self) -> usize;
    /// The rows of a scene; a function of `key` and nothing else. `scene` is the number that the rows bear.
    fn scene(&self, worker: &mut Self::Worker, key: Key, scene: i64, stop: &Stop) -> Result<SceneRows<Self::Row>>;
    fn tensors(&self, rows: Vec<Self::Row>) -> Vec<Tensor>;
}

/// Makes what the folder lacks of the data. `progress` hears of every few scenes. A requested stop ends the work with
/// the shards that are whole; the manifest then lists fewer rows than were asked for.
pub(super) fn make<T: Task>(
    task: &T,
    family: &ShapeFamily,
    shape_seed: u64,
    folder: &Path,
    params: &StoreParams,
    stop: &Stop,
    progress: &mut dyn FnMut(Made),
) -> Result<Manifest> {
    params.validate()?;
    fs::create_dir_all(folder).map_err(|e| Error::io(folder, e))?;
    let (tensors, notes) = family.tensors();
    let shapes = file(tensors, &notes);
    let mut manifest = Manifest {
        format: format!("jostle/{}/1", task.kind()),
        kind: task.kind().into(),
        jostle: env!("CARGO_PKG_VERSION").into(),
        seed: params.seed,
        count: params.count,
        shard: params.shard,
        configuration: task.configuration()?,
        shapes: ShapesEntry {
            file: SHAPES.into(),
            count: family.shapes().len(),
            seed: shape_seed,
            sha256: sha256(&shapes),
            splits: super::Split::ALL.map(|s| (s.name().to_string(), family.of(s).len())).into(),
        },
        shards: Vec::new(),
        statistics: Statistics::new(),
    };
    let found = read(folder, &manifest)?;
    files::write(folder.join(SHAPES), &shapes)?;

    let pool = Pool::new(params.threads, "jostle-data")?;
    let workers: Result<Vec<_>> = (0..pool.workers()).map(|_| task.worker().map(Mutex::new)).collect();
    let workers = workers?;
    let mut rows_made = 0;
    for shard in 0..params.count.div_ceil(params.shard) {
        let wanted = params.shard.min(params.count - shard * params.shard);
        let name = format!("{}-{shard:05}.safetensors", task.kind());
        let path = folder.join(&name);
        let entry = match found.iter().find(|e| e.file == name && e.count == wanted) {
            Some(entry) if fs::read(&path).is_ok_and(|bytes| sha256(&bytes) == entry.sha256) => entry.clone(),
            _ => {
                let place = Place { key: Key::new(params.seed).child(shard as u64), first: shard as u64 * SCENES };
                let made = Made { rows: rows_made, of: params.count };
                let Some((rows, statistics)) = rows(task, place, wanted, &pool, &workers, made, stop, progress)? else {
                    break;
                };
                let notes = [("format", manifest.format.clone()), ("jostle", manifest.jostle.clone())];
                let bytes = file(task.tensors(rows), &notes);
                files::write(&path, &bytes)?;
                ShardEntry { file: name, count: wanted, sha256: sha256(&bytes), statistics }
            }
        };
        rows_made += entry.count;
        manifest.shards.push(entry);
        manifest.statistics = total(&manifest.shards);
        write_manifest(folder, &manifest)?;
        progress(Made { rows: rows_made, of: params.count });
    }
    Ok(manifest)
}

/// Where the scenes of a shard are among all scenes.
#[derive(Clone, Copy)]
struct Place {
    key: Key,
    first: u64,
}

/// What becomes of a scene within a wave.
struct Slot<R> {
    number: u64,
    made: Result<SceneRows<R>>,
}

/// Exactly `wanted` rows, from the shard's scenes in their order; `None` if a stop was requested.
#[allow(clippy::too_many_arguments)]
fn rows<T: Task>(
    task: &T,
    place: Place,
    wanted: usize,
    pool: &Pool,
    workers: &[Mutex<T::Worker>],
    made: Made,
    stop: &Stop,
    progress: &mut dyn FnMut(Made),
) -> Result<Option<(Vec<T::Row>, Statistics)>> {
    let mut rows = Vec::with_capacity(wanted + task.rows_of_scene());
    let mut statistics = Statistics::new();
    let mut next = 0;
    while rows.len() < wanted {
        // The number of scenes follows from the rows so far, not from the threads.
        let scenes = (wanted - rows.len()).div_ceil(task.rows_of_scene().max(1)).clamp(1, WAVE) as u64;
        if next + scenes > SCENES {
            return Err(Error::State(format!("{SCENES} scenes gave {} of {wanted} rows", rows.len())));
        }
        let mut wave: Vec<Slot<T::Row>> = (next..next + scenes)
            .map(|number| Slot { number, made: Err(Error::Internal("not made".into())) })
            .collect();
        next += scenes;
        pool.for_each_group(&mut wave, 1, workers, |worker, slots| {
            for slot in slots {
                let scene = (place.first + slot.number) as i64;
                slot.made = task.scene(worker, place.key.child(slot.number), scene, stop);
            }
        })?;
        if stop.requested() {
            return Ok(None);
        }
        for slot in wave {
            let scene = slot.made?;
            rows.extend(scene.rows);
            add(&mut statistics, &scene.statistics);
        }
        progress(Made { rows: made.rows + rows.len().min(wanted), ..made });
    }
    rows.truncate(wanted);
    Ok(Some((rows, statistics)))
}

/// Adds sums to sums.
fn add(to: &mut Statistics, from: &Statistics) {
    for (name, value) in from {
        *to.entry(name.clone()).or_default() += value;
    }
}

fn total(shards: &[ShardEntry]) -> Statistics {
    let mut sum = Statistics::new();
    shards.iter().for_each(|s| add(&mut sum, &s.statistics));
    sum
}

/// The shards of the folder, if it is one of the same data. A folder of other data is refused.
fn read(folder: &Path, wanted: &Manifest) -> Result<Vec<ShardEntry>> {
    let path = folder.join(MANIFEST);
    if !path.exists() {
        return Ok(Vec::new());
    }
    let found: Manifest = json::read(&path, "manifest")?;
    let same = Manifest { count: found.count, shards: Vec::new(), statistics: Statistics::new(), ..wanted.clone() };
    let there = Manifest { shards: Vec::new(), statistics: Statistics::new(), ..found.clone() };
    if same != there {
        let differs = [
            ("format", same.format != there.format),
            ("version", same.jostle != there.jostle),
            ("seed", same.seed != there.seed),
            ("shard size", same.shard != there.shard),
            ("configuration", same.configuration != there.configuration),
            ("shapes", same.shapes != there.shapes),
        ];
        let names: Vec<_> = differs.iter().filter(|(_, d)| *d).map(|(name, _)| *name).collect();
        let reason =
            format!("is of other data (another {}); choose another folder, or empty this one", names.join(", "));
        return Err(Error::format(path, reason));
    }
    Ok(found.shards)
}

fn write_manifest(folder: &Path, manifest: &Manifest) -> Result<()> {
    let mut text =
        serde_json::to_string_pretty(manifest).map_err(|e| Error::Internal(format!("the manifest as JSON: {e}")))?;
    text.push('\n');
    files::write(folder.join(MANIFEST), text)
}
