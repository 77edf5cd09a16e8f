//! Images across modules: memory, and speed as a printed figure.

use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;

use jostle::scene::Problem;
use jostle::scene::generate::{Generator, GeneratorParams};
use jostle::vision::{Frame, ImageMut, Rasteriser};

thread_local! {
    static ALLOCATIONS: Cell<u64> = const { Cell::new(0) };
}

struct Counting;

// SAFETY: passes every request on.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        let _ = ALLOCATIONS.try_with(|count| count.set(count.get() + 1));
        // SAFETY: as promised by the caller.
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        // SAFETY: as promised by the caller.
        unsafe { System.dealloc(pointer, layout) }
    }
}

#[global_allocator]
static COUNTING: Counting = Counting;

fn ten(index: u64) -> Problem {
    let params = GeneratorParams { bodies: 10..=10, ..GeneratorParams::default() };
    Generator::new(params, 4).unwrap().problem(index).unwrap()
}

#[test]
fn a_warm_rasteriser_allocates_nothing() {
    let problem = ten(0);
    let (scene, state) = (&*problem.scene, &problem.state);
    let frame = Frame::around(scene, state, problem.target, 0.3, 0.002, 112).unwrap();
    let (rows, cols) = (frame.rows, frame.cols);
    let mut rasteriser = Rasteriser::new();
    let mut labels = vec![0u8; frame.len()];
    let mut view = vec![0f32; 2 * frame.len()];
    let mut masks = vec![0u8; scene.len() * frame.len()];
    let mut counted = 0;
    for _ in 0..2 {
        let before = ALLOCATIONS.get();
        let mut image = ImageMut::packed(&mut labels, rows, cols).unwrap();
        rasteriser.labels(scene, state, &frame, &mut image).unwrap();
        rasteriser.target_view(scene, state, problem.target, &frame, &mut view).unwrap();
        rasteriser.masks(scene, state, &frame, &mut masks).unwrap();
        counted = ALLOCATIONS.get() - before;
    }
    assert!(labels.iter().any(|&label| label > 0));
    assert_eq!(counted, 0);
    let start = std::time::Instant::now();
    for turn in 0..1000 {
        let frame = Frame::around(scene, state, problem.target, f64::from(turn) * 0.01, 0.002, 112).unwrap();
        rasteriser.target_view(scene, state, problem.target, &frame, &mut view).unwrap();
    }
    println!("a crop of 112 pixels of 10 bodies: {:.1} us", start.elapsed().as_secs_f64() * 1e3);
}
