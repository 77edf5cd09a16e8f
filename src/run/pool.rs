//! The worker threads of one planner.

use std::any::Any;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::JoinHandle;

use rayon::prelude::*;

use crate::error::{Error, Result};
use crate::host::{Home, Standard};

/// Worker threads of its own, never the process-wide ones. With 0 or 1 threads there are none: work runs on the
/// thread that asks for it.
///
/// Dropping the pool ends its threads and waits for them. A pool is shared by `&` among threads; several may use it at
/// once.
#[derive(Debug)]
pub struct Pool {
    workers: Option<rayon::ThreadPool>,
    handles: Vec<JoinHandle<()>>,
    /// Where the threads live.
    home: Home,
}

impl Pool {
    /// A pool of `threads` workers named `name-0`, `name-1`, ...
    pub fn new(threads: usize, name: &str) -> Result<Self> {
        if threads <= 1 {
            return Ok(Pool::inline());
        }
        let mut handles = Vec::with_capacity(threads);
        let built = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .spawn_handler(|worker| {
                let builder = std::thread::Builder::new().name(format!("{name}-{}", worker.index()));
                handles.push(builder.spawn(|| {
                    // Threads begin with the state of the one that starts them.
                    let _standard = Standard::enter();
                    worker.run();
                })?);
                Ok(())
            })
            .build();
        match built {
            Ok(workers) => Ok(Pool { workers: Some(workers), handles, home: Home::here() }),
            Err(error) => {
                // The builder has told the threads that did start to end.
                join(handles);
                Err(Error::argument("threads", format!("is {threads}, and they cannot be started: {error}")))
            }
        }
    }

    /// A pool without threads.
    pub fn inline() -> Self {
        Pool { workers: None, handles: Vec::new(), home: Home::here() }
    }

    /// How many pieces of work run at once, at least 1.
    pub fn workers(&self) -> usize {
        self.handles.len().max(1)
    }

    /// Refuses to wait for threads that are not there.
    fn check_home(&self) -> Result<()> {
        if self.workers.is_some() { self.home.check("threads") } else { Ok(()) }
    }

    /// Runs `work` on a thread of the pool and waits for it. Batches started from there begin sooner (no hand-over),
    /// but callbacks then come from that thread.
    pub fn install<R: Send>(&self, work: impl FnOnce() -> R + Send) -> Result<R> {
        self.check_home()?;
        let guarded = AssertUnwindSafe(work);
        let outcome = match &self.workers {
            // The closure is unwrapped inside the guard: a method call captures the whole wrapper.
            Some(workers) => workers.install(move || catch_unwind(guarded)),
            None => catch_unwind(guarded),
        };
        outcome.map_err(|panic| Error::Internal(message(&*panic)))
    }

    /// Splits `items` into runs of at most `group` and calls `work` on every run, several at once. Each worker has a
    /// scratch of its own: `scratches` holds at least [`workers`](Self::workers) of them.
    ///
    /// Groups become smaller where there would be fewer groups than workers, and each is given to the next free
    /// worker, so uneven times balance out. One group, or a pool without threads, runs on the calling thread with the
    /// first scratch. A panic in `work` is caught: the other groups are dropped if not yet begun, and the result is
    /// [`Error::Internal`]. `work` must not use this pool itself.
    pub fn for_each_group<T: Send, S: Send>(
        &self,
        items: &mut [T],
        group: usize,
        scratches: &[Mutex<S>],
        work: impl Fn(&mut S, &mut [T]) + Sync,
    ) -> Result<()> {
        if items.is_empty() {
            return Ok(());
        }
        self.check_home()?;
        if scratches.len() < self.workers() {
            return Err(Error::Internal(format!("{} scratches for {} workers", scratches.len(), self.workers())));
        }
        let size = group.clamp(1, items.len().div_ceil(self.workers()));
        let batch = Batch { scratches, work, failed: AtomicBool::new(false), first: Mutex::new(None) };
        match &self.workers {
            Some(workers) if items.len() > size => workers.install(|| {
                items
                    .par_chunks_mut(size)
                    .with_max_len(1)
                    .for_each(|run| batch.run(rayon::current_thread_index().unwrap_or(0), run));
            }),
            _ => items.chunks_mut(size).for_each(|run| batch.run(0, run)),
        }
        match batch.first.into_inner().unwrap_or_else(|poisoned| poisoned.into_inner()) {
            None => Ok(()),
            Some(text) => Err(Error::Internal(text)),
        }
    }
}

impl Drop for Pool {
    fn drop(&mut self) {
        if self.check_home().is_err() {
            // There is nobody to tell and nobody to wait for.
            std::mem::forget(self.workers.take());
            std::mem::forget(std::mem::take(&mut self.handles));
            return;
        }
        drop(self.workers.take());
        join(std::mem::take(&mut self.handles));
    }
}

/// Waits for threads; never for the current one, which would wait for ever.
fn join(handles: Vec<JoinHandle<()>>) {
    let here = std::thread::current().id();
    for handle in handles {
        if handle.thread().id() != here {
            // A worker that panicked has nothing to tell: panics of the work are caught above it.
            let _ = handle.join();
        }
    }
}

/// What the groups of one call share.
struct Batch<'a, S, F> {
    scratches: &'a [Mutex<S>],
    work: F,
    failed: AtomicBool,
    first: Mutex<Option<String>>,
}

impl<S, F> Batch<'_, S, F> {
    fn run<T>(&self, worker: usize, items: &mut [T])
    where
        F: Fn(&mut S, &mut [T]),
    {
        if self.failed.load(Ordering::Relaxed) {
            return;
        }
        // Only a batch within a batch finds its own scratch taken: refuse rather than wait for ever.
        let mut scratch = match self.scratches[worker].try_lock() {
            Ok(scratch) => scratch,
            Err(std::sync::TryLockError::Poisoned(poisoned)) => poisoned.into_inner(),
            Err(std::sync::TryLockError::WouldBlock) => return self.fail("a batch was started within a batch".into()),
        };
        if let Err(panic) = catch_unwind(AssertUnwindSafe(|| (self.work)(&mut scratch, items))) {
            self.fail(message(&*panic));
        }
    }

    fn fail(&self, text: String) {
        self.failed.store(true, Ordering::Relaxed);
        let mut first = self.first.lock().unwrap_or_else(|poisoned| poisoned.into_inner());
        first.get_or_insert(text);
    }
}

/// The text of a panic.
fn message(panic: &(dyn Any + Send)) -> String {
    let text = panic.downcast_ref::<&str>().copied().or(panic.downcast_ref::<String>().map(String::as_str));
    format!("panic: {}", text.unwrap_or("without a message"))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn scratches(pool: &Pool) -> Vec<Mutex<u64>> {
        (0..pool.workers()).map(|_| Mutex::new(0)).collect()
    }

    #[test]
    fn every_item_is_worked_on_once_at_any_number_of_threads() {
        for threads in [0, 1, 2, 5] {
            let pool = Pool::new(threads, "test").unwrap();
            assert_eq!(pool.workers(), threads.max(1));
            for (count, group) in [(0, 1), (1, 8), (7, 3), (100, 8), (100, 1), (3, 0)] {
                let scratches = scratches(&pool);
                let mut items: Vec<u64> = (0..count).collect();
                pool.for_each_group(&mut items, group, &scratches, |scratch, run| {
                    assert!(run.len() <= group.max(1));
                    for item in run {
                        *item += 1000;
                        *scratch += 1;
                    }
                })
                .unwrap();
                assert!(items.iter().enumerate().all(|(i, &item)| item == 1000 + i as u64));
                let done: u64 = scratches.into_iter().map(|s| s.into_inner().unwrap()).sum();
                assert_eq!(done, count);
            }
        }
    }

    #[test]
    fn a_panic_becomes_an_error_and_the_pool_lives_on() {
        for threads in [1, 3] {
            let pool = Pool::new(threads, "test").unwrap();
            let scratches = scratches(&pool);
            let mut items = [0u64; 20];
            let result = pool.for_each_group(&mut items, 2, &scratches, |_, _| panic!("boom {}", 1));
            assert_eq!(result, Err(Error::Internal("panic: boom 1".into())));
            assert_eq!(pool.install(|| -> u32 { panic!("again") }), Err(Error::Internal("panic: again".into())));
            assert_eq!(pool.install(|| 3), Ok(3));
            pool.for_each_group(&mut items, 2, &scratches, |_, run| run.fill(1)).unwrap();
            assert_eq!(items, [1; 20]);
        }
    }

    #[test]
    fn a_batch_within_a_batch_is_refused() {
        let pool = Pool::inline();
        let scratches = scratches(&pool);
        let inner_result = Mutex::new(Ok(()));
        pool.for_each_group(&mut [0u8], 1, &scratches, |_, _| {
            *inner_result.lock().unwrap() = pool.for_each_group(&mut [0u8], 1, &scratches, |_, _| ());
        })
        .unwrap();
        assert!(matches!(inner_result.into_inner().unwrap(), Err(Error::Internal(_))));
        let missing = pool.for_each_group(&mut [0u8], 1, &[] as &[Mutex<u64>], |_, _| ());
        assert!(matches!(missing, Err(Error::Internal(_))));
    }

    #[cfg(target_os = "linux")]
    #[test]
    fn dropping_the_pool_joins_its_threads() {
        // Other tests run beside this one, so the threads are told apart by name.
        let named = || {
            std::fs::read_dir("/proc/self/task")
                .unwrap()
                .filter_map(|task| std::fs::read_to_string(task.ok()?.path().join("comm")).ok())
                .filter(|name| name.starts_with("joined-pool-"))
                .count()
        };
        for _ in 0..20 {
            let pool = Pool::new(3, "joined-pool").unwrap();
            // A thread names itself when it starts to run, which the first batch makes sure of.
            let scratches = scratches(&pool);
            pool.for_each_group(&mut [0u8; 64], 1, &scratches, |_, _| ()).unwrap();
            assert!((1..=3).contains(&named()));
            drop(pool);
            // The kernel wakes the joiner a moment before it takes the thread off the list.
            let gone = (0..1000).any(|_| {
                named() == 0 || {
                    std::thread::sleep(std::time::Duration::from_millis(1));
                    false
                }
            });
            assert!(gone);
        }
    }
}
