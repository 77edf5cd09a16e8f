//! Sweeps of many worlds at once: eight or sixteen contacts side by side, each of another world.
//!
//! A sweep has four parts (normal impulses of bodies and of the ground, then friction of both). In each part a lane walks
//! through one world's rows in that world's order; when it has come to the end it takes the next world, so that lanes do
//! not wait for the longest list. The arithmetic is [`kernel`]'s, and worlds share nothing: a world gets the same bits
//! here as in `Rows::sweep`.

use std::ops::{Add, Div, Mul, Sub};

use super::kernel::{self, BodyRow, Four, GroundRow, Motion, Number};
use super::solver::Rows;
use super::world::World;
use crate::physics::lanes::simd::WithSimd;
use crate::physics::lanes::{Group, LANES, Numbers, Simd8};

/// The most worlds that are swept side by side.
const MOST: usize = 2 * LANES;

/// Numbers with the instruction set that works on them.
#[derive(Clone, Copy)]
struct Wide<S: Numbers>(S, S::F);

macro_rules! operator {
    ($name:ident, $method:ident) => {
        impl<S: Numbers> $name for Wide<S> {
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

impl<S: Numbers> Number for Wide<S> {
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

/// One world's place in a part of the sweep.
struct Walk<'a, R> {
    rows: &'a mut [R],
    /// The bodies of each row; the ground's rows have one.
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

    /// The first body of the row at which it is, and the second.
    #[inline(always)]
    fn pair(&self) -> [usize; 2] {
        let [a, b] = self.bodies[self.at];
        [a as usize, b as usize]
    }
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
        // An inertia keeps divisions finite.
        let motion = Motion { i: [1.0; 4], ..Motion::default() };
        Idle { rows: [R::default()], motion: [motion; 2], change: 0.0 }
    }

    #[inline(always)]
    fn walk(&mut self) -> Walk<'_, R> {
        let walk = Walk::new(&mut self.rows, NOBODY, &mut self.motion, &mut self.change, false);
        Walk { left: usize::MAX, step: 0, ..walk }
    }
}

/// What idle lanes work on.
pub struct Idles {
    bodies: [Idle<BodyRow<f32>>; MOST],
    ground: [Idle<GroundRow<f32>>; MOST],
}

impl Default for Idles {
    fn default() -> Self {
        Self { bodies: std::array::from_fn(|_| Idle::new()), ground: std::array::from_fn(|_| Idle::new()) }
    }
}

/// Walks all worlds through one part of the sweep. `tick` works on one row of every lane and gives the changes.
#[inline(always)]
fn walk<'a, const N: usize, S: Group<N>, R: Copy + Default + 'a>(
    s: S,
    mut worlds: impl Iterator<Item = Walk<'a, R>>,
    idle: &'a mut [Idle<R>; N],
    tick: impl Fn(&mut [Walk<'a, R>; N]) -> S::F,
) {
    let mut busy = 0;
    let mut walks: [Walk<'a, R>; N] = idle.each_mut().map(Idle::walk);
    // What a busy lane goes back to.
    let mut shelf: [Option<Walk<'a, R>>; N] = std::array::from_fn(|_| None);
    let mut left = [usize::MAX; N];
    for ((walk, shelf), left) in walks.iter_mut().zip(&mut shelf).zip(&mut left) {
        let Some(world) = worlds.next() else { break };
        *left = world.rows.len();
        *shelf = Some(std::mem::replace(walk, world));
        busy += 1;
    }
    let mut change = s.splat(0.0);
    while busy > 0 {
        let ticks = left.iter().fold(usize::MAX, |least, &l| least.min(l));
        for _ in 0..ticks {
            change = s.max(tick(&mut walks), change);
            for walk in &mut walks {
                walk.at = walk.at.wrapping_add_signed(walk.step);
            }
        }
        let mut changes = s.split(change);
        for (((walk, change), shelf), left) in walks.iter_mut().zip(&mut changes).zip(&mut shelf).zip(&mut left) {
            if walk.step == 0 {
                continue;
            }
            *left -= ticks;
            if *left > 0 {
                continue;
            }
            *walk.change = walk.change.max(*change);
            *change = 0.0;
            if let Some(world) = worlds.next() {
                *left = world.rows.len();
                *walk = world;
            } else if let Some(idle) = shelf.take() {
                *left = usize::MAX;
                *walk = idle;
                busy -= 1;
            }
        }
        change = s.join(&changes);
    }
}

/// One sweep over the rows of all worlds that are being solved.
pub struct Sweep<'a> {
    pub worlds: &'a mut [World],
    pub idle: &'a mut Idles,
    /// How many of the worlds are being solved.
    pub solving: usize,
}

impl WithSimd for Sweep<'_> {
    type Output = ();

    fn run<S: Simd8>(self, s: S) {
        let Sweep { worlds, idle, solving } = self;
        s.vectorize(
            #[inline(always)]
            || {
                if solving > LANES {
                    parts(s.wide(), worlds, &mut idle.bodies, &mut idle.ground);
                } else if let (Some(bodies), Some(ground)) =
                    (idle.bodies.first_chunk_mut::<LANES>(), idle.ground.first_chunk_mut::<LANES>())
                {
                    parts(s, worlds, bodies, ground);
                }
            },
        );
        for world in worlds.iter_mut().filter(|w| w.rows.solving) {
            world.rows.sweeps += 1;
        }
    }
}

#[inline(always)]
fn parts<const N: usize, S: Group<N>>(
    s: S,
    worlds: &mut [World],
    bodies: &mut [Idle<BodyRow<f32>>; N],
    ground: &mut [Idle<GroundRow<f32>>; N],
) {
    walk(
        s,
        body_walks(worlds),
        bodies,
        #[inline(always)]
        |walks| body_normals(s, walks),
    );
    walk(
        s,
        ground_walks(worlds),
        ground,
        #[inline(always)]
        |walks| ground_normals(s, walks),
    );
    walk(
        s,
        body_walks(worlds),
        bodies,
        #[inline(always)]
        |walks| body_frictions(s, walks),
    );
    walk(
        s,
        ground_walks(worlds),
        ground,
        #[inline(always)]
        |walks| ground_frictions(s, walks),
    );
}

fn solving(worlds: &mut [World]) -> impl Iterator<Item = &mut Rows> {
    worlds.iter_mut().map(|w| &mut w.rows).filter(|r| r.solving)
}

fn body_walks(worlds: &mut [World]) -> impl Iterator<Item = Walk<'_, BodyRow<f32>>> {
    solving(worlds).filter(|r| !r.bodies.is_empty()).map(|r| {
        let back = r.goes_back();
        Walk::new(&mut r.bodies, &r.body_pair, &mut r.motion, &mut r.change, back)
    })
}

fn ground_walks(worlds: &mut [World]) -> impl Iterator<Item = Walk<'_, GroundRow<f32>>> {
    solving(worlds).filter(|r| !r.ground.is_empty()).map(|r| {
        let back = r.goes_back();
        Walk::new(&mut r.ground, &r.ground_body, &mut r.motion, &mut r.change, back)
    })
}

/// The lanes' rows.
macro_rules! rows {
    ($g:ident, $walks:expr) => {
        $g::every(
            #[inline(always)]
            |l| &$walks[l].rows[$walks[l].at],
        )
    };
}

/// The lanes' bodies of one side: 0 or 1.
macro_rules! bodies {
    ($g:ident, $walks:expr, $pairs:expr, $side:literal) => {
        $g::every(
            #[inline(always)]
            |l| &$walks[l].motion[$pairs[l][$side]],
        )
    };
}

/// A group of four of each lane's place.
macro_rules! load {
    ($s:expr, $places:expr, $field:ident) => {{
        let [a, b, c, d] = $s.gather(
            #[inline(always)]
            |l| $places[l].$field,
        );
        [Wide($s, a), Wide($s, b), Wide($s, c), Wide($s, d)]
    }};
}

#[inline(always)]
fn scattered<const N: usize, S: Group<N>>(s: S, [a, b, c, d]: Four<Wide<S>>) -> [[f32; 4]; N] {
    s.scatter([a.1, b.1, c.1, d.1])
}

#[inline(always)]
fn zeros<S: Numbers>(s: S) -> Four<Wide<S>> {
    [Wide(s, s.splat(0.0)); 4]
}

#[inline(always)]
fn ground_normals<const N: usize, S: Group<N>>(s: S, walks: &mut [Walk<'_, GroundRow<f32>>; N]) -> S::F {
    let pairs = S::every(
        #[inline(always)]
        |l| walks[l].pair(),
    );
    let (rows, at) = (rows!(S, walks), bodies!(S, walks, pairs, 0));
    let mut row = GroundRow {
        arm: load!(s, rows, arm),
        lift: load!(s, rows, lift),
        impulse: load!(s, rows, impulse),
        roll: zeros(s),
        mass: zeros(s),
    };
    let mut body = Motion { v: load!(s, at, v), w: load!(s, at, w), i: zeros(s) };
    let change = kernel::ground_normal(&mut row, &mut body);
    let (v, w, impulse) = (scattered(s, body.v), scattered(s, body.w), scattered(s, row.impulse));
    S::each(
        #[inline(always)]
        |l| {
            let walk = &mut walks[l];
            let motion = &mut walk.motion[pairs[l][0]];
            (motion.v, motion.w) = (v[l], w[l]);
            walk.rows[walk.at].impulse = impulse[l];
        },
    );
    change.1
}

#[inline(always)]
fn ground_frictions<const N: usize, S: Group<N>>(s: S, walks: &mut [Walk<'_, GroundRow<f32>>; N]) -> S::F {
    let pairs = S::every(
        #[inline(always)]
        |l| walks[l].pair(),
    );
    let (rows, at) = (rows!(S, walks), bodies!(S, walks, pairs, 0));
    let mut row = GroundRow {
        arm: load!(s, rows, arm),
        lift: zeros(s),
        impulse: load!(s, rows, impulse),
        roll: load!(s, rows, roll),
        mass: load!(s, rows, mass),
    };
    let mut body = Motion { v: load!(s, at, v), w: load!(s, at, w), i: load!(s, at, i) };
    kernel::ground_friction(&mut row, &mut body);
    let (v, w) = (scattered(s, body.v), scattered(s, body.w));
    let (impulse, roll) = (scattered(s, row.impulse), scattered(s, row.roll));
    S::each(
        #[inline(always)]
        |l| {
            let walk = &mut walks[l];
            let motion = &mut walk.motion[pairs[l][0]];
            (motion.v, motion.w) = (v[l], w[l]);
            let row = &mut walk.rows[walk.at];
            (row.impulse, row.roll) = (impulse[l], roll[l]);
        },
    );
    s.splat(0.0)
}

#[inline(always)]
fn body_normals<const N: usize, S: Group<N>>(s: S, walks: &mut [Walk<'_, BodyRow<f32>>; N]) -> S::F {
    let pairs = S::every(
        #[inline(always)]
        |l| walks[l].pair(),
    );
    let (rows, first, second) = (rows!(S, walks), bodies!(S, walks, pairs, 0), bodies!(S, walks, pairs, 1));
    let mut row = BodyRow {
        normal: load!(s, rows, normal),
        moment_a: load!(s, rows, moment_a),
        moment_b: load!(s, rows, moment_b),
        turn_a: load!(s, rows, turn_a),
        turn_b: load!(s, rows, turn_b),
        impulse: load!(s, rows, impulse),
        roll: zeros(s),
        arm_a: zeros(s),
        arm_b: zeros(s),
    };
    let mut a = Motion { v: load!(s, first, v), w: load!(s, first, w), i: zeros(s) };
    let mut b = Motion { v: load!(s, second, v), w: load!(s, second, w), i: zeros(s) };
    let change = kernel::body_normal(&mut row, &mut a, &mut b);
    let impulse = scattered(s, row.impulse);
    put_bodies(s, walks, &pairs, a, b);
    S::each(
        #[inline(always)]
        |l| {
            let walk = &mut walks[l];
            walk.rows[walk.at].impulse = impulse[l];
        },
    );
    change.1
}

#[inline(always)]
fn body_frictions<const N: usize, S: Group<N>>(s: S, walks: &mut [Walk<'_, BodyRow<f32>>; N]) -> S::F {
    let pairs = S::every(
        #[inline(always)]
        |l| walks[l].pair(),
    );
    let (rows, first, second) = (rows!(S, walks), bodies!(S, walks, pairs, 0), bodies!(S, walks, pairs, 1));
    let mut row = BodyRow {
        normal: load!(s, rows, normal),
        moment_a: zeros(s),
        moment_b: zeros(s),
        turn_a: zeros(s),
        turn_b: zeros(s),
        impulse: load!(s, rows, impulse),
        roll: load!(s, rows, roll),
        arm_a: load!(s, rows, arm_a),
        arm_b: load!(s, rows, arm_b),
    };
    let mut a = Motion { v: load!(s, first, v), w: load!(s, first, w), i: load!(s, first, i) };
    let mut b = Motion { v: load!(s, second, v), w: load!(s, second, w), i: load!(s, second, i) };
    kernel::body_friction(&mut row, &mut a, &mut b);
    let (impulse, roll) = (scattered(s, row.impulse), scattered(s, row.roll));
    put_bodies(s, walks, &pairs, a, b);
    S::each(
        #[inline(always)]
        |l| {
            let walk = &mut walks[l];
            let row = &mut walk.rows[walk.at];
            (row.impulse, row.roll) = (impulse[l], roll[l]);
        },
    );
    s.splat(0.0)
}

/// Puts the velocities of both bodies back.
#[inline(always)]
fn put_bodies<const N: usize, S: Group<N>, R>(
    s: S,
    walks: &mut [Walk<'_, R>; N],
    pairs: &[[usize; 2]; N],
    a: Motion<Wide<S>>,
    b: Motion<Wide<S>>,
) {
    let (va, wa, vb, wb) = (scattered(s, a.v), scattered(s, a.w), scattered(s, b.v), scattered(s, b.w));
    S::each(
        #[inline(always)]
        |l| {
            let motion = &mut *walks[l].motion;
            let [first, second] = pairs[l];
            (motion[first].v, motion[first].w) = (va[l], wa[l]);
            (motion[second].v, motion[second].w) = (vb[l], wb[l]);
        },
    );
}
