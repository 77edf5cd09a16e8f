//! Sweeps of many worlds at once: eight contacts side by side, each of another world.
//!
//! A sweep has four parts (normal impulses of bodies and of the ground, then friction of both). In each part a lane walks
//! through one world's rows in that world's order; when it has come to the end it takes the next world, so that lanes do
//! not wait for the longest list. The arithmetic is [`kernel`]'s, and worlds share nothing: a world gets the same bits
//! here as in `Rows::sweep`.

use std::ops::{Add, Div, Mul, Sub};

use super::kernel::{self, BodyRow, Four, GroundRow, Motion, Number};
use super::world::World;
use crate::physics::lanes::simd::WithSimd;
use crate::physics::lanes::{LANES, Simd8};

/// Eight numbers with the instruction set that works on them.
#[derive(Clone, Copy)]
struct Wide<S: Simd8>(S, S::F);

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

    #[inline(always)]
    fn row_mut(&mut self) -> &mut R {
        &mut self.rows[self.at]
    }

    #[inline(always)]
    fn row(&self) -> &R {
        &self.rows[self.at]
    }

    #[inline(always)]
    fn body(&self, which: usize) -> &Motion<f32> {
        &self.motion[self.bodies[self.at][which] as usize]
    }

    #[inline(always)]
    fn body_mut(&mut self, which: usize) -> &mut Motion<f32> {
        &mut self.motion[self.bodies[self.at][which] as usize]
    }
}

#[inline(always)]
fn load<S: Simd8, R>(s: S, walks: &[Walk<'_, R>; LANES], four: impl Fn(&Walk<'_, R>) -> Four<f32>) -> Four<Wide<S>> {
    // Written out: closures of the standard library's array functions are not always inlined.
    let w = walks;
    let rows = [four(&w[0]), four(&w[1]), four(&w[2]), four(&w[3]), four(&w[4]), four(&w[5]), four(&w[6]), four(&w[7])];
    let [a, b, c, d] = s.columns(rows);
    [Wide(s, a), Wide(s, b), Wide(s, c), Wide(s, d)]
}

#[inline(always)]
fn store<S: Simd8, R>(
    s: S,
    walks: &mut [Walk<'_, R>; LANES],
    four: Four<Wide<S>>,
    mut put: impl FnMut(&mut Walk<'_, R>, Four<f32>),
) {
    let [a, b, c, d] = four;
    let rows = s.rows([a.1, b.1, c.1, d.1]);
    for l in 0..LANES {
        put(&mut walks[l], rows[l]);
    }
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
                ground_part(
                    s,
                    worlds,
                    #[inline(always)]
                    |s, walks| ground_normals(s, walks),
                );
                body_part(
                    s,
                    worlds,
                    #[inline(always)]
                    |s, walks| body_frictions(s, walks),
                );
                ground_part(
                    s,
                    worlds,
                    #[inline(always)]
                    |s, walks| ground_frictions(s, walks),
                );
            },
        );
        for world in worlds.iter_mut().filter(|w| w.rows.solving) {
            world.rows.sweeps += 1;
        }
    }
}

#[inline(always)]
fn body_part<'a, S: Simd8>(
    s: S,
    worlds: &'a mut [World],
    tick: impl Fn(S, &mut [Walk<'_, BodyRow<f32>>; LANES]) -> Wide<S>,
) {
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
fn ground_part<S: Simd8>(
    s: S,
    worlds: &mut [World],
    tick: impl Fn(S, &mut [Walk<'_, GroundRow<f32>>; LANES]) -> Wide<S>,
) {
    let mut idle: [Idle<GroundRow<f32>>; LANES] = std::array::from_fn(|_| Idle::new());
    let list = worlds.iter_mut().map(|w| &mut w.rows).filter(|r| r.solving && !r.ground.is_empty()).map(|r| {
        let back = r.goes_back();
        Walk::new(&mut r.ground, &r.ground_body, &mut r.motion, &mut r.change, back)
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
fn body<S: Simd8, R>(s: S, walks: &[Walk<'_, R>; LANES], which: usize, with_inertia: bool) -> Motion<Wide<S>> {
    Motion {
        v: load(
            s,
            walks,
            #[inline(always)]
            |w| w.body(which).v,
        ),
        w: load(
            s,
            walks,
            #[inline(always)]
            |w| w.body(which).w,
        ),
        i: if with_inertia {
            load(
                s,
                walks,
                #[inline(always)]
                |w| w.body(which).i,
            )
        } else {
            zeros(s)
        },
    }
}

#[inline(always)]
fn put_body<S: Simd8, R>(s: S, walks: &mut [Walk<'_, R>; LANES], which: usize, body: Motion<Wide<S>>) {
    store(
        s,
        walks,
        body.v,
        #[inline(always)]
        |w, v| w.body_mut(which).v = v,
    );
    store(
        s,
        walks,
        body.w,
        #[inline(always)]
        |w, x| w.body_mut(which).w = x,
    );
}

#[inline(always)]
fn ground_normals<S: Simd8>(s: S, walks: &mut [Walk<'_, GroundRow<f32>>; LANES]) -> Wide<S> {
    let mut row = GroundRow {
        arm: load(
            s,
            walks,
            #[inline(always)]
            |w| w.row().arm,
        ),
        lift: load(
            s,
            walks,
            #[inline(always)]
            |w| w.row().lift,
        ),
        impulse: load(
            s,
            walks,
            #[inline(always)]
            |w| w.row().impulse,
        ),
        roll: zeros(s),
        mass: zeros(s),
    };
    let mut motion = body(s, walks, 0, false);
    let change = kernel::ground_normal(&mut row, &mut motion);
    put_body(s, walks, 0, motion);
    store(
        s,
        walks,
        row.impulse,
        #[inline(always)]
        |w, x| w.row_mut().impulse = x,
    );
    change
}

#[inline(always)]
fn ground_frictions<S: Simd8>(s: S, walks: &mut [Walk<'_, GroundRow<f32>>; LANES]) -> Wide<S> {
    let mut row = GroundRow {
        arm: load(
            s,
            walks,
            #[inline(always)]
            |w| w.row().arm,
        ),
        lift: zeros(s),
        impulse: load(
            s,
            walks,
            #[inline(always)]
            |w| w.row().impulse,
        ),
        roll: load(
            s,
            walks,
            #[inline(always)]
            |w| w.row().roll,
        ),
        mass: load(
            s,
            walks,
            #[inline(always)]
            |w| w.row().mass,
        ),
    };
    let mut motion = body(s, walks, 0, true);
    kernel::ground_friction(&mut row, &mut motion);
    put_body(s, walks, 0, motion);
    store(
        s,
        walks,
        row.impulse,
        #[inline(always)]
        |w, x| w.row_mut().impulse = x,
    );
    store(
        s,
        walks,
        row.roll,
        #[inline(always)]
        |w, x| w.row_mut().roll = x,
    );
    Wide(s, s.splat(0.0))
}

#[inline(always)]
fn body_normals<S: Simd8>(s: S, walks: &mut [Walk<'_, BodyRow<f32>>; LANES]) -> Wide<S> {
    let mut row = BodyRow {
        normal: load(
            s,
            walks,
            #[inline(always)]
            |w| w.row().normal,
        ),
        moment_a: load(
            s,
            walks,
            #[inline(always)]
            |w| w.row().moment_a,
        ),
        moment_b: load(
            s,
            walks,
            #[inline(always)]
            |w| w.row().moment_b,
        ),
        turn_a: load(
            s,
            walks,
            #[inline(always)]
            |w| w.row().turn_a,
        ),
        turn_b: load(
            s,
            walks,
            #[inline(always)]
            |w| w.row().turn_b,
        ),
        impulse: load(
            s,
            walks,
            #[inline(always)]
            |w| w.row().impulse,
        ),
        roll: zeros(s),
        arm_a: zeros(s),
        arm_b: zeros(s),
    };
    let (mut a, mut b) = (body(s, walks, 0, false), body(s, walks, 1, false));
    let change = kernel::body_normal(&mut row, &mut a, &mut b);
    put_body(s, walks, 0, a);
    put_body(s, walks, 1, b);
    store(
        s,
        walks,
        row.impulse,
        #[inline(always)]
        |w, x| w.row_mut().impulse = x,
    );
    change
}

#[inline(always)]
fn body_frictions<S: Simd8>(s: S, walks: &mut [Walk<'_, BodyRow<f32>>; LANES]) -> Wide<S> {
    let mut row = BodyRow {
        normal: load(
            s,
            walks,
            #[inline(always)]
            |w| w.row().normal,
        ),
        moment_a: zeros(s),
        moment_b: zeros(s),
        turn_a: zeros(s),
        turn_b: zeros(s),
        impulse: load(
            s,
            walks,
            #[inline(always)]
            |w| w.row().impulse,
        ),
        roll: load(
            s,
            walks,
            #[inline(always)]
            |w| w.row().roll,
        ),
        arm_a: load(
            s,
            walks,
            #[inline(always)]
            |w| w.row().arm_a,
        ),
        arm_b: load(
            s,
            walks,
            #[inline(always)]
            |w| w.row().arm_b,
        ),
    };
    let (mut a, mut b) = (body(s, walks, 0, true), body(s, walks, 1, true));
    kernel::body_friction(&mut row, &mut a, &mut b);
    put_body(s, walks, 0, a);
    put_body(s, walks, 1, b);
    store(
        s,
        walks,
        row.impulse,
        #[inline(always)]
        |w, x| w.row_mut().impulse = x,
    );
    store(
        s,
        walks,
        row.roll,
        #[inline(always)]
        |w, x| w.row_mut().roll = x,
    );
    Wide(s, s.splat(0.0))
}
