//! The table of live handles.
//!
//! A handle looks like a pointer to C but is a number: kind, slot and generation. It is looked up here, never
//! followed, so a handle that was freed, is of another kind or was never made is found out with certainty, and no
//! memory behind it is touched. A look-up is a few atomic operations, without a lock: `jostle_cancel_trigger` and the
//! polls may be called from a real-time thread.
//!
//! Looking up pins the object until the [`Pin`] is dropped. Freeing takes the handle out at once and drops the object
//! with its last pin, so an object that is freed while another thread is inside a call on it is not pulled away.
//!
//! The table is the one thing in the C API that is global to the process: a handle has nothing else to hold on to.
//! Its memory grows with the greatest number of handles alive at once and is not given back.

use std::any::Any;
use std::cell::UnsafeCell;
use std::ops::Deref;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex, OnceLock, PoisonError};

use super::log::Log;
use super::status::{Failure, JOSTLE_ERROR_HANDLE, JOSTLE_ERROR_MEMORY, Outcome};

/// What a handle stands for. Part of the handle, so that a cast in C is found out.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(u8)]
pub(super) enum Kind {
    Context = 1,
    Scene = 2,
    Planner = 3,
    Job = 4,
    Plan = 5,
    Cancel = 6,
    Simulator = 7,
    Model = 8,
}

/// Something that C holds a handle to.
pub(super) trait Object: Any + Send + Sync {
    const KIND: Kind;
    /// The type of the handle in C.
    type Handle;
    /// Where failures of calls on this object are logged.
    fn log(&self) -> &Arc<Log>;
}

type Stored = Box<dyn Any + Send + Sync>;

/// `state`: generation in the upper half, then the closing bit, then the number of pins (the owner's is one).
struct Slot {
    state: AtomicU64,
    object: UnsafeCell<Option<Stored>>,
}

// SAFETY: `object` is written only while nobody else can reach it (no pins before a handle is given out, or the last
// pin gone after closing), and only shared otherwise; the stored objects are Send and Sync.
unsafe impl Sync for Slot {}

const CLOSING: u64 = 1 << 31;
const PINS: u64 = CLOSING - 1;

/// Segment `k` holds `64 << k` slots; segments are made when needed and stay.
const FIRST: usize = 64;
const SEGMENTS: usize = 18;
static TABLE: [OnceLock<Box<[Slot]>>; SEGMENTS] = [const { OnceLock::new() }; SEGMENTS];

struct Spare {
    /// Slots never used so far begin here.
    next: usize,
    /// Slots used before and free again.
    free: Vec<usize>,
}

static SPARE: Mutex<Spare> = Mutex::new(Spare { next: 0, free: Vec::new() });
static LIVE: AtomicU64 = AtomicU64::new(0);

/// Handles alive in the process.
pub(super) fn live() -> u64 {
    LIVE.load(Ordering::Acquire)
}

fn place(index: usize) -> (usize, usize) {
    let n = index + FIRST;
    let segment = (usize::BITS - 1 - n.leading_zeros()) as usize - FIRST.trailing_zeros() as usize;
    (segment, n - (FIRST << segment))
}

fn slot(index: usize) -> Option<&'static Slot> {
    let (segment, offset) = place(index);
    TABLE.get(segment)?.get()?.get(offset)
}

fn encode(kind: Kind, index: usize, generation: u64) -> usize {
    // The lowest bit is set: no pointer to an aligned object looks like a handle.
    (generation as usize) << 32 | index << 8 | (kind as usize) << 1 | 1
}

/// Gives an object a handle.
pub(super) fn insert<T: Object>(object: T) -> Outcome<*mut T::Handle> {
    let index = {
        let mut spare = SPARE.lock().unwrap_or_else(PoisonError::into_inner);
        match spare.free.pop() {
            Some(index) => index,
            None if place(spare.next).0 < SEGMENTS => {
                spare.next += 1;
                spare.next - 1
            }
            None => return Err(Failure::new(JOSTLE_ERROR_MEMORY, "more than 16 million handles are alive")),
        }
    };
    let (segment, offset) = place(index);
    let segment = TABLE[segment].get_or_init(|| {
        // Generations begin at 1: a handle is never null, whatever its kind.
        (0..FIRST << segment).map(|_| Slot { state: AtomicU64::new(1 << 32), object: UnsafeCell::new(None) }).collect()
    });
    let slot = &segment[offset];
    // SAFETY: the slot is free: no handle leads to it and it has no pins, so nobody else reads `object`.
    unsafe { *slot.object.get() = Some(Box::new(object)) };
    let generation = slot.state.load(Ordering::Relaxed) >> 32;
    slot.state.store(generation << 32 | 1, Ordering::Release);
    LIVE.fetch_add(1, Ordering::AcqRel);
    Ok(std::ptr::without_provenance_mut(encode(T::KIND, index, generation)))
}

fn dead(field: &str) -> Failure {
    Failure::new(
        JOSTLE_ERROR_HANDLE,
        format!("{field}: is not a live handle of its type; it was freed, or this library did not make it"),
    )
}

fn find<T: Object>(handle: *const T::Handle, field: &str) -> Outcome<(usize, &'static Slot, u64)> {
    if handle.is_null() {
        return Err(Failure::null(field));
    }
    let bits = handle.addr();
    if bits & 0xff != (T::KIND as usize) << 1 | 1 {
        return Err(dead(field));
    }
    let index = bits >> 8 & 0xff_ffff;
    let slot = slot(index).ok_or_else(|| dead(field))?;
    Ok((index, slot, (bits >> 32) as u64))
}

/// The object of a handle, held in place.
pub(super) fn open<T: Object>(handle: *const T::Handle, field: &str) -> Outcome<Pin<T>> {
    let (index, slot, generation) = find::<T>(handle, field)?;
    let mut state = slot.state.load(Ordering::Acquire);
    loop {
        let pins = state & PINS;
        if state >> 32 != generation || state & CLOSING != 0 || pins == 0 || pins == PINS {
            return Err(dead(field));
        }
        match slot.state.compare_exchange_weak(state, state + 1, Ordering::AcqRel, Ordering::Acquire) {
            Ok(_) => break,
            Err(now) => state = now,
        }
    }
    let held = Held { index, slot };
    // SAFETY: the pin keeps `object` in place and unchanged; the kind in the handle fixes its type.
    let object =
        unsafe { (*slot.object.get()).as_ref() }.and_then(|o| o.downcast_ref::<T>()).ok_or_else(|| dead(field))?;
    Ok(Pin { object, _held: held })
}

/// Takes the handle out of the table. The object is dropped with its last pin: here, or when the call that still
/// uses it ends. With `wait` it is always dropped here.
pub(super) fn close<T: Object>(handle: *const T::Handle, field: &str, wait: bool) -> Outcome {
    let (index, slot, generation) = find::<T>(handle, field)?;
    let mut state = slot.state.load(Ordering::Acquire);
    loop {
        if state >> 32 != generation || state & CLOSING != 0 || state & PINS == 0 {
            return Err(dead(field));
        }
        match slot.state.compare_exchange_weak(state, state | CLOSING, Ordering::AcqRel, Ordering::Acquire) {
            Ok(_) => break,
            Err(now) => state = now,
        }
    }
    LIVE.fetch_sub(1, Ordering::AcqRel);
    while wait && slot.state.load(Ordering::Acquire) & PINS > 1 {
        // Asleep, not spinning: the other thread may have a lower priority than this one.
        std::thread::sleep(std::time::Duration::from_micros(20));
    }
    drop(Held { index, slot });
    Ok(())
}

/// One pin of a slot.
struct Held {
    index: usize,
    slot: &'static Slot,
}

impl Drop for Held {
    fn drop(&mut self) {
        let before = self.slot.state.fetch_sub(1, Ordering::AcqRel);
        if before & PINS != 1 {
            return;
        }
        // SAFETY: the owner's pin goes only in `close`, so the slot is closing, has no pins left and can get none.
        let object = unsafe { (*self.slot.object.get()).take() };
        let generation = (before >> 32) + 1;
        self.slot.state.store(generation << 32, Ordering::Release);
        // A slot whose generations are used up stays out of use: old handles must never come alive again.
        if generation < u64::from(u32::MAX) {
            SPARE.lock().unwrap_or_else(PoisonError::into_inner).free.push(self.index);
        }
        drop(object);
    }
}

/// An object that cannot go away while this lives.
pub(super) struct Pin<T: 'static> {
    object: &'static T,
    _held: Held,
}

impl<T> Deref for Pin<T> {
    type Target = T;

    fn deref(&self) -> &T {
        self.object
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    struct Thing(Arc<Log>, Arc<AtomicU64>);
    impl Object for Thing {
        const KIND: Kind = Kind::Cancel;
        type Handle = u8;
        fn log(&self) -> &Arc<Log> {
            &self.0
        }
    }
    impl Drop for Thing {
        fn drop(&mut self) {
            self.1.fetch_add(1, Ordering::SeqCst);
        }
    }
    struct Other(Arc<Log>);
    impl Object for Other {
        const KIND: Kind = Kind::Plan;
        type Handle = u8;
        fn log(&self) -> &Arc<Log> {
            &self.0
        }
    }

    #[test]
    fn indices_fill_the_segments_without_gaps() {
        let mut wanted = (0, 0);
        for index in 0..10_000 {
            assert_eq!(place(index), wanted);
            wanted.1 += 1;
            if wanted.1 == FIRST << wanted.0 {
                wanted = (wanted.0 + 1, 0);
            }
        }
        assert!(place((1 << 24) - 1).0 <= SEGMENTS);
    }

    #[test]
    fn dead_foreign_and_mistaken_handles_are_found_out() {
        let (log, dropped) = (Log::silent(), Arc::new(AtomicU64::new(0)));
        let a = insert(Thing(log.clone(), dropped.clone())).unwrap();
        assert!(open::<Thing>(a, "a").is_ok());
        assert_eq!(open::<Other>(a, "a").err().unwrap().status, JOSTLE_ERROR_HANDLE);
        let local = 7u64;
        assert!(open::<Thing>((&raw const local).cast(), "a").is_err());
        for bits in [1, 13, usize::MAX, 0xffff_ffff_0000_000d] {
            assert!(open::<Thing>(std::ptr::without_provenance(bits), "a").is_err(), "{bits:x}");
        }
        close::<Thing>(a, "a", false).unwrap();
        assert_eq!(dropped.load(Ordering::SeqCst), 1);
        assert!(close::<Thing>(a, "a", false).is_err());
        // The slot is used again; the old handle stays dead.
        let more: Vec<_> = (0..200).map(|_| insert(Thing(log.clone(), dropped.clone())).unwrap()).collect();
        assert!(open::<Thing>(a, "a").is_err());
        more.iter().for_each(|&h| close::<Thing>(h, "h", true).unwrap());
        assert_eq!(dropped.load(Ordering::SeqCst), 201);
    }

    #[test]
    fn freeing_a_pinned_object_waits_for_the_pin() {
        let dropped = Arc::new(AtomicU64::new(0));
        let a = insert(Thing(Log::silent(), dropped.clone())).unwrap();
        let pin = open::<Thing>(a, "a").unwrap();
        close::<Thing>(a, "a", false).unwrap();
        assert!(open::<Thing>(a, "a").is_err());
        assert_eq!(dropped.load(Ordering::SeqCst), 0);
        drop(pin);
        assert_eq!(dropped.load(Ordering::SeqCst), 1);
    }

    #[test]
    fn threads_may_race_for_a_handle() {
        for _ in 0..200 {
            let dropped = Arc::new(AtomicU64::new(0));
            let a = insert(Thing(Log::silent(), dropped.clone())).unwrap().addr();
            std::thread::scope(|scope| {
                for _ in 0..3 {
                    scope.spawn(move || {
                        while let Ok(pin) = open::<Thing>(std::ptr::without_provenance(a), "a") {
                            assert_eq!(pin.1.load(Ordering::SeqCst), 0);
                        }
                    });
                }
                scope.spawn(move || close::<Thing>(std::ptr::without_provenance(a), "a", true).unwrap());
            });
            assert_eq!(dropped.load(Ordering::SeqCst), 1);
        }
    }
}
