//! Eight contacts side by side: of eight bodies of a world with the ground, or of bodies in eight worlds.
//!
//! A sweep has four parts (normal impulses of bodies and of the ground, then friction of both). In the parts of bodies a
//! lane walks through one world's rows in that world's order; when it has come to the end it takes the next world, so that
//! lanes do not wait for the longest list. The parts of the ground are wide within each world. The arithmetic is
//! [`kernel`]'s, and worlds share nothing: a world gets the same bits here as in `Rows::sweep`.

use std::ops::{Add, Div, Mul, Sub};

use super::kernel::{self, BodyRow, Four, GroundRow, Motion, Number};
use super::world::World;
use crate::physics::lanes::simd::WithSimd;
use crate::physics::lanes::{LANES, Simd8};

/// Eight numbers with the instruction set that works on them.
#[derive(Clone, Copy)]
pub struct Wide<S: Simd8>(S, S::F);

macro_rules! operator {
    ($name:ident, $method:ident) => {
        impl<S: Simd8> $name for Wide<S> {
            type Output = Self;
            #[inline(always)]
            fn $method(self, other: Self) -> Self {
                Wide(self.0, self.0.$method(self.1, other.1))
            }
        }
    };
}
operator!(Add, add);
operator!(Sub, sub);
operator!(Mul, mul);
operator!(Div, div);

impl<S: Simd8> Number for Wide<S> {
    #[inline(always)]
    fn constant(self, x: f32) -> Self {
        Wide(self.0, self.0.splat(x))
    }
    #[inline(always)]
    fn root(self) -> Self {
        Wide(self.0, self.0.sqrt(self.1))
    }
    #[inline(always)]
    fn greater(self, other: Self) -> Self {
        Wide(self.0, self.0.max(self.1, other.1))
    }
    #[inline(always)]
    fn less(self, other: Self) -> Self {
        Wide(self.0, self.0.min(self.1, other.1))
    }
    #[inline(always)]
    fn magnitude(self) -> Self {
        Wide(self.0, self.0.abs(self.1))
    }
    #[inline(always)]
    fn if_below(self, limit: Self, yes: Self, no: Self) -> Self {
        Wide(self.0, self.0.if_less(self.1, limit.1, yes.1, no.1))
    }
}

/// A group of four of each of eight places, written out: closures that go through the standard library's array
/// functions are not always inlined.
macro_rules! load {
    ($s:expr, $places:expr, $($field:tt)+) => {{
        let [p0, p1, p2, p3, p4, p5, p6, p7] = &$places;
        let [a, b, c, d] = $s.columns([
            p0.$($field)+, p1.$($field)+, p2.$($field)+, p3.$($field)+,
            p4.$($field)+, p5.$($field)+, p6.$($field)+, p7.$($field)+,
        ]);
        [Wide($s, a), Wide($s, b), Wide($s, c), Wide($s, d)]
    }};
}

/// Eight numbers of a block.
type Column = [f32; LANES];

#[inline(always)]
fn column<S: Simd8>(s: S, column: &Column) -> Wide<S> {
    Wide(s, s.load(column))
}

#[inline(always)]
fn columns<S: Simd8>(s: S, four: &Four<Column>) -> Four<Wide<S>> {
    let [a, b, c, d] = four;
    [column(s, a), column(s, b), column(s, c), column(s, d)]
}

#[inline(always)]
pub fn zero<S: Simd8>(s: S) -> Wide<S> {
    Wide(s, s.splat(0.0))
}

#[inline(always)]
pub fn greatest<S: Simd8>(x: Wide<S>) -> f32 {
    x.0.store(x.1).into_iter().fold(0.0, f32::max)
}

/// Eight bodies of a world.
#[inline(always)]
pub fn load_bodies<S: Simd8>(s: S, motion: &[Motion<f32>], bodies: &[u32; LANES]) -> Motion<Wide<S>> {
    let [a, b, c, d, e, f, g, h] = bodies;
    let at = [a, b, c, d, e, f, g, h].map(
        #[inline(always)]
        |i| &motion[*i as usize],
    );
    Motion { v: load!(s, at, v), w: load!(s, at, w), i: load!(s, at, i) }
}

/// Puts their velocities back.
#[inline(always)]
pub fn store_bodies<S: Simd8>(s: S, motion: &mut [Motion<f32>], bodies: &[u32; LANES], from: Motion<Wide<S>>) {
    let ([a, b, c, d], [e, f, g, h]) = (from.v, from.w);
    let (v, w) = (s.rows([a.1, b.1, c.1, d.1]), s.rows([e.1, f.1, g.1, h.1]));
    for ((&body, v), w) in bodies.iter().zip(v).zip(w) {
        let motion = &mut motion[body as usize];
        (motion.v, motion.w) = (v, w);
    }
}

/// Normal impulses of eight contacts with the ground. Gives the changes of velocity.
#[inline(always)]
pub fn ground_normal<S: Simd8>(s: S, block: &mut GroundRow<Column>, body: &mut Motion<Wide<S>>) -> Wide<S> {
    let mut row = GroundRow {
        arm: columns(s, &block.arm),
        lift: columns(s, &block.lift),
        impulse: [column(s, &block.impulse[0]), zero(s), zero(s), zero(s)],
        roll: [zero(s); 4],
        mass: [zero(s); 4],
    };
    let change = kernel::ground_normal(&mut row, body);
    block.impulse[0] = s.store(row.impulse[0].1);
    change
}

/// Friction, spinning and rolling of eight contacts with the ground.
#[inline(always)]
pub fn ground_friction<S: Simd8>(s: S, block: &mut GroundRow<Column>, body: &mut Motion<Wide<S>>) {
    let mut row = GroundRow {
        arm: columns(s, &block.arm),
        lift: [zero(s); 4],
        impulse: columns(s, &block.impulse),
        roll: columns(s, &block.roll),
        mass: columns(s, &block.mass),
    };
    kernel::ground_friction(&mut row, body);
    for k in 1..4 {
        block.impulse[k] = s.store(row.impulse[k].1);
    }
    for k in 0..2 {
        block.roll[k] = s.store(row.roll[k].1);
    }
}

/// One world's place in a part of the sweep.
struct Walk<'a, R> {
    rows: &'a mut [R],
    /// The bodies of each row.
    bodies: &'a [[u32; 2]],
    motion: &'a mut [Motion<f32>],
    change: &'a mut f32,
    at: usize,
    left: usize,
    /// Towards the next row: 1 or -1, and 0 for a lane that has nothing to do.
    step: isize,
}

impl<'a, R> Walk<'a, R> {
    #[inline(always)]
    fn new(
        rows: &'a mut [R],
        bodies: &'a [[u32; 2]],
        motion: &'a mut [Motion<f32>],
        change: &'a mut f32,
        back: bool,
    ) -> Self {
        let left = rows.len();
        Walk {
            at: if back { left.saturating_sub(1) } else { 0 },
            step: if back { -1 } else { 1 },
            left,
            rows,
            bodies,
            motion,
            change,
        }
    }

    /// The row at which it is, and its two bodies.
    #[inline(always)]
    fn pair(&mut self) -> (&mut R, &mut Motion<f32>, &mut Motion<f32>) {
        let [a, b] = self.bodies[self.at];
        let (low, high) = (a.min(b) as usize, a.max(b) as usize);
        let (lower, upper) = self.motion.split_at_mut(high);
        let (first, second) = (&mut lower[low], &mut upper[0]);
        let row = &mut self.rows[self.at];
        if a < b { (row, first, second) } else { (row, second, first) }
    }
}

macro_rules! store {
    ($s:expr, $places:expr, $four:expr, $($field:tt)+) => {{
        let [a, b, c, d] = $four;
        let rows = $s.rows([a.1, b.1, c.1, d.1]);
        for (place, row) in $places.iter_mut().zip(rows) {
            place.$($field)+ = row;
        }
    }};
}

macro_rules! places {
    ($walks:expr, $method:ident) => {{
        let [w0, w1, w2, w3, w4, w5, w6, w7] = $walks;
        [w0.$method(), w1.$method(), w2.$method(), w3.$method(), w4.$method(), w5.$method(), w6.$method(), w7.$method()]
    }};
}

#[inline(always)]
fn zeros<S: Simd8>(s: S) -> Four<Wide<S>> {
    [Wide(s, s.splat(0.0)); 4]
}

/// Rows and bodies of nobody, for a lane that has nothing to do.
struct Idle<R> {
    rows: [R; 1],
    motion: [Motion<f32>; 2],
    change: f32,
}

const NOBODY: &[[u32; 2]] = &[[0, 1]];

impl<R: Copy + Default> Idle<R> {
    fn new() -> Self {
        Idle { rows: [R::default()], motion: [Motion::default(); 2], change: 0.0 }
    }

    fn walk(&mut self) -> Walk<'_, R> {
        let walk = Walk::new(&mut self.rows, NOBODY, &mut self.motion, &mut self.change, false);
        Walk { left: usize::MAX, step: 0, ..walk }
    }
}

/// Walks all worlds through one part of the sweep. `tick` works on one row of every lane and gives the changes.
#[inline(always)]
fn walk<'a, S: Simd8, R: Copy + Default + 'a>(
    s: S,
    mut worlds: impl Iterator<Item = Walk<'a, R>>,
    idle: &'a mut [Idle<R>; LANES],
    tick: impl Fn(&mut [Walk<'a, R>; LANES]) -> Wide<S>,
) {
    let mut busy = 0;
    let mut walks: [Walk<'a, R>; LANES] = idle.each_mut().map(Idle::walk);
    // What a busy lane goes back to.
    let mut shelf: [Option<Walk<'a, R>>; LANES] = Default::default();
    for (walk, shelf) in walks.iter_mut().zip(&mut shelf) {
        let Some(world) = worlds.next() else { break };
        *shelf = Some(std::mem::replace(walk, world));
        busy += 1;
    }
    let mut change = Wide(s, s.splat(0.0));
    while busy > 0 {
        let ticks = walks.iter().fold(usize::MAX, |least, w| least.min(w.left));
        for _ in 0..ticks {
            change = tick(&mut walks).greater(change);
            for walk in &mut walks {
                walk.at = walk.at.wrapping_add_signed(walk.step);
            }
        }
        let mut changes = s.store(change.1);
        for ((walk, change), shelf) in walks.iter_mut().zip(&mut changes).zip(&mut shelf) {
            if walk.step == 0 {
                continue;
            }
            walk.left -= ticks;
            if walk.left > 0 {
                continue;
            }
            *walk.change = walk.change.max(*change);
            *change = 0.0;
            if let Some(world) = worlds.next() {
                *walk = world;
            } else if let Some(idle) = shelf.take() {
                *walk = idle;
                busy -= 1;
            }
        }
        change = Wide(s, s.load(&changes));
    }
}

/// One sweep over the rows of all worlds that are being solved.
pub struct Sweep<'a> {
    pub worlds: &'a mut [World],
}

impl WithSimd for Sweep<'_> {
    type Output = ();

    fn run<S: Simd8>(self, s: S) {
        let worlds = self.worlds;
        s.vectorize(
            #[inline(always)]
            || {
                body_part(
                    s,
                    worlds,
                    #[inline(always)]
                    |s, walks| body_normals(s, walks),
                );
                for world in worlds.iter_mut().filter(|w| w.rows.solving) {
                    world.rows.ground_normals(s);
                }
                body_part(
                    s,
                    worlds,
                    #[inline(always)]
                    |s, walks| body_frictions(s, walks),
                );
                for world in worlds.iter_mut().filter(|w| w.rows.solving) {
                    world.rows.ground_frictions(s);
                }
            },
        );
        for world in worlds.iter_mut().filter(|w| w.rows.solving) {
            world.rows.sweeps += 1;
        }
    }
}

#[inline(always)]
fn body_part<S: Simd8>(s: S, worlds: &mut [World], tick: impl Fn(S, &mut [Walk<'_, BodyRow<f32>>; LANES]) -> Wide<S>) {
    let mut idle: [Idle<BodyRow<f32>>; LANES] = std::array::from_fn(|_| Idle::new());
    let list = worlds.iter_mut().map(|w| &mut w.rows).filter(|r| r.solving && !r.bodies.is_empty()).map(|r| {
        let back = r.goes_back();
        Walk::new(&mut r.bodies, &r.body_pair, &mut r.motion, &mut r.change, back)
    });
    walk(
        s,
        list,
        &mut idle,
        #[inline(always)]
        |walks| tick(s, walks),
    );
}

#[inline(always)]
fn body_normals<S: Simd8>(s: S, walks: &mut [Walk<'_, BodyRow<f32>>; LANES]) -> Wide<S> {
    let mut at = places!(walks, pair);
    let mut row = BodyRow {
        normal: load!(s, at, 0.normal),
        moment_a: load!(s, at, 0.moment_a),
        moment_b: load!(s, at, 0.moment_b),
        turn_a: load!(s, at, 0.turn_a),
        turn_b: load!(s, at, 0.turn_b),
        impulse: load!(s, at, 0.impulse),
        roll: zeros(s),
        arm_a: zeros(s),
        arm_b: zeros(s),
    };
    let mut a = Motion { v: load!(s, at, 1.v), w: load!(s, at, 1.w), i: zeros(s) };
    let mut b = Motion { v: load!(s, at, 2.v), w: load!(s, at, 2.w), i: zeros(s) };
    let change = kernel::body_normal(&mut row, &mut a, &mut b);
    store!(s, at, a.v, 1.v);
    store!(s, at, a.w, 1.w);
    store!(s, at, b.v, 2.v);
    store!(s, at, b.w, 2.w);
    store!(s, at, row.impulse, 0.impulse);
    change
}

#[inline(always)]
fn body_frictions<S: Simd8>(s: S, walks: &mut [Walk<'_, BodyRow<f32>>; LANES]) -> Wide<S> {
    let mut at = places!(walks, pair);
    let mut row = BodyRow {
        normal: load!(s, at, 0.normal),
        moment_a: zeros(s),
        moment_b: zeros(s),
        turn_a: zeros(s),
        turn_b: zeros(s),
        impulse: load!(s, at, 0.impulse),
        roll: load!(s, at, 0.roll),
        arm_a: load!(s, at, 0.arm_a),
        arm_b: load!(s, at, 0.arm_b),
    };
    let mut a = Motion { v: load!(s, at, 1.v), w: load!(s, at, 1.w), i: load!(s, at, 1.i) };
    let mut b = Motion { v: load!(s, at, 2.v), w: load!(s, at, 2.w), i: load!(s, at, 2.i) };
    kernel::body_friction(&mut row, &mut a, &mut b);
    store!(s, at, a.v, 1.v);
    store!(s, at, a.w, 1.w);
    store!(s, at, b.v, 2.v);
    store!(s, at, b.w, 2.w);
    store!(s, at, row.impulse, 0.impulse);
    store!(s, at, row.roll, 0.roll);
    Wide(s, s.splat(0.0))
}
