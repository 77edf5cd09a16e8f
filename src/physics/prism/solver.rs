//! Impulses of one step: projected Gauss-Seidel over contacts with friction, warm-started.
//!
//! The ground's contacts of different bodies have nothing to do with each other: eight bodies' are solved side by side.
//!
//! A sweep solves all normal impulses and then friction, spinning and rolling, as Bullet does; solving a contact's
//! friction right after its normal impulse needs many more sweeps. Sweeps go forth and back in turn.

use super::kernel::{self, BodyRow, Four, GroundRow, Motion, Number};
use super::model::{Flat, Real};
use super::momentum::Gathered;
use super::wide::{self, Wide};
use crate::physics::lanes::simd::WithSimd;
use crate::physics::lanes::{LANES, Simd8};

/// Where a manifold's rows lie, to take the impulses back from.
pub type Span = (u32, u32);

/// Where a manifold's rows with the ground lie.
#[derive(Debug, Clone, Copy)]
pub struct GroundSpan {
    lane: usize,
    /// The first block and the one after the last.
    first: usize,
    end: usize,
}

/// Eight contacts with the ground, each of another body.
pub(super) type Block = GroundRow<[f32; LANES]>;

/// Eight bodies and the blocks of their contacts with the ground. A body that has fewer than others has rows of zeros,
/// which do nothing.
#[derive(Debug, Clone, Copy)]
pub(super) struct Footing {
    pub(super) bodies: [u32; LANES],
    pub(super) used: usize,
    /// The first block and the one after the last.
    pub(super) first: usize,
    pub(super) end: usize,
}

/// The rows of one step.
#[derive(Default)]
pub struct Rows {
    /// The bodies, the tip, and one that stands for nobody.
    pub motion: Vec<Motion<f32>>,
    pub(super) ground: Vec<Block>,
    pub(super) footings: Vec<Footing>,
    pub bodies: Vec<BodyRow<f32>>,
    /// The bodies of each body row.
    pub body_pair: Vec<[u32; 2]>,
    /// Rows with the ground of the last body.
    rank: usize,
    /// Sweeps since the rows were made.
    pub sweeps: u32,
    /// Greatest change of a normal velocity in the last sweep, m/s.
    pub change: Real,
    /// Sweeps that the step may take.
    pub most_sweeps: u32,
    /// More sweeps are wanted.
    pub solving: bool,
    /// Sweeps that the step may take where its bodies' masses differ greatly; 0 where they do not.
    pub uneven_sweeps: u32,
    /// What a normal velocity may miss then, m/s.
    pub uneven_residual: Real,
    pub momentum: Gathered,
}

/// How a manifold's bodies rub against each other.
#[derive(Debug, Clone, Copy)]
pub struct Rubbing {
    /// Coefficient of friction.
    pub friction: Real,
    /// Torque per normal impulse, metres.
    pub rolling: Real,
}

#[inline(always)]
fn inverse(x: Real) -> Real {
    if x > 0.0 { 1.0 / x } else { 0.0 }
}

#[inline(always)]
fn cross(r: [Real; 3], p: [Real; 3]) -> [Real; 3] {
    [r[1] * p[2] - r[2] * p[1], r[2] * p[0] - r[0] * p[2], r[0] * p[1] - r[1] * p[0]]
}

impl Motion<f32> {
    #[inline(always)]
    fn response(&self, t: [Real; 3]) -> [Real; 3] {
        let [xx, xy, yy, zz] = self.i;
        [xx * t[0] + xy * t[1], xy * t[0] + yy * t[1], zz * t[2]]
    }

    /// Turning about a horizontal axis for a unit torque about it, times the axis' length squared.
    #[inline(always)]
    fn tilting(&self, x: Real, y: Real) -> Real {
        let [xx, xy, yy, _] = self.i;
        x * x * xx + 2.0 * (x * y) * xy + y * y * yy
    }

    #[inline(always)]
    fn velocity_at(&self, r: [Real; 3]) -> [Real; 3] {
        let turning = cross([self.w[0], self.w[1], self.w[2]], r);
        [self.v[0] + turning[0], self.v[1] + turning[1], self.v[2] + turning[2]]
    }

    #[inline(always)]
    fn push(&mut self, p: [Real; 3], t: [Real; 3]) {
        let dw = self.response(t);
        for k in 0..3 {
            self.v[k] += self.v[3] * p[k];
            self.w[k] += dw[k];
        }
    }
}

/// Applies impulses (normal, across, up; spinning) and rolling torques (across, up) of a contact of two bodies.
pub(super) fn push_bodies(
    motion: &mut [Motion<f32>],
    row: &BodyRow<f32>,
    pair: [u32; 2],
    [n, t, z, s]: Four<f32>,
    [rt, rz]: [Real; 2],
) {
    let [nx, ny, ..] = row.normal;
    let p = [nx * n - ny * t, ny * n + nx * t, z];
    let torque = [nx * s - ny * rt, ny * s + nx * rt, rz];
    for (body, arm, sign) in [(pair[0], row.arm_a, -1.0), (pair[1], row.arm_b, 1.0)] {
        let moment = cross([arm[0], arm[1], arm[2]], p);
        let turn = [0, 1, 2].map(|k| sign * (moment[k] + torque[k]));
        motion[body as usize].push(p.map(|x| sign * x), turn);
    }
}

/// Applies impulses (up, x, y; spinning) and rolling torques (about x, about y) of a contact with the ground.
pub(super) fn push_ground(
    motion: &mut Motion<f32>,
    block: &Block,
    lane: usize,
    [n, x, y, s]: Four<f32>,
    [rx, ry]: [Real; 2],
) {
    let moment = cross([0, 1, 2].map(|k| block.arm[k][lane]), [x, y, n]);
    motion.push([x, y, n], [moment[0] + rx, moment[1] + ry, moment[2] + s]);
}

impl Rows {
    pub fn clear(&mut self) {
        self.ground.clear();
        self.footings.clear();
        self.bodies.clear();
        self.body_pair.clear();
    }

    /// Velocity at which the halves of a contact part now.
    #[inline]
    pub fn parting(&self, bodies: [usize; 2], arm: &[[Real; 3]; 2], normal: Flat) -> Real {
        let [a, b] = bodies.map(|i| &self.motion[i]);
        let (ua, ub) = (a.velocity_at(arm[0]), b.velocity_at(arm[1]));
        (ub[0] - ua[0]) * normal[0] + (ub[1] - ua[1]) * normal[1]
    }

    #[inline]
    pub fn lifting(&self, body: usize, arm: &[Real; 3]) -> Real {
        self.motion[body].velocity_at(*arm)[2]
    }

    /// The contacts with the ground that are added next are this body's.
    pub fn begin_ground(&mut self, body: usize) {
        match self.footings.last_mut() {
            Some(footing) if footing.used < LANES => {
                footing.bodies[footing.used] = body as u32;
                footing.used += 1;
            }
            _ => {
                let nobody = self.motion.len() as u32 - 1;
                let mut bodies = [nobody; LANES];
                bodies[0] = body as u32;
                let first = self.ground.len();
                self.footings.push(Footing { bodies, used: 1, first, end: first });
            }
        }
        self.rank = 0;
    }

    /// Impulses: up, x, y.
    pub fn add_ground(&mut self, body: usize, arm: [Real; 3], target: Real, rub: Rubbing, impulse: [Real; 3]) {
        let m = &self.motion[body];
        let [x, y, z] = arm;
        let [xx, xy, yy, zz] = m.i;
        let turn = [xx * y - xy * x, xy * y - yy * x];
        let up = m.v[3] + (y * turn[0] - x * turn[1]);
        let sides = [m.v[3] + (z * z * yy + y * y * zz), m.v[3] + (z * z * xx + x * x * zz)].map(inverse);
        let turning = [inverse(m.i[0]), inverse(m.i[2])];
        let Some(footing) = self.footings.last_mut() else { return };
        let (at, lane) = (footing.first + self.rank, footing.used - 1);
        if at == self.ground.len() {
            self.ground.push(Block::default());
            footing.end = at + 1;
        }
        self.rank += 1;
        let block = &mut self.ground[at];
        let put = |four: &mut Four<[f32; LANES]>, values: [Real; 4]| {
            four.iter_mut().zip(values).for_each(|(column, x)| column[lane] = x);
        };
        put(&mut block.arm, [x, y, z, target]);
        put(&mut block.lift, [turn[0], turn[1], inverse(up), up]);
        put(&mut block.impulse, [impulse[0], impulse[1], impulse[2], 0.0]);
        put(&mut block.roll, [0.0, 0.0, rub.rolling, rub.friction]);
        put(&mut block.mass, [sides[0], sides[1], turning[0], turning[1]]);
    }

    /// Shares the manifold's torque impulses (up, about x, about y) among its rows, the last `count` that were added.
    pub fn end_ground(&mut self, count: usize, torque: [Real; 3]) -> GroundSpan {
        let (first, used) = self.footings.last().map_or((0, 1), |f| (f.first, f.used));
        let span = GroundSpan { lane: used - 1, first: first + self.rank - count, end: first + self.rank };
        let share = 1.0 / count.max(1) as Real;
        for block in &mut self.ground[span.first..span.end] {
            block.impulse[3][span.lane] = torque[0] * share;
            block.roll[0][span.lane] = torque[1] * share;
            block.roll[1][span.lane] = torque[2] * share;
        }
        span
    }

    /// Impulses: normal, across, up.
    pub fn add_bodies(
        &mut self,
        bodies: [usize; 2],
        arm: [[Real; 3]; 2],
        normal: Flat,
        target: Real,
        rub: Rubbing,
        impulse: [Real; 3],
    ) {
        let [nx, ny] = normal;
        let [a, b] = bodies.map(|i| &self.motion[i]);
        // Moments of unit impulses along the normal, across it and up, and the turning that they give.
        let moments = arm
            .map(|[x, y, z]| [[-z * ny, z * nx, x * ny - y * nx], [-z * nx, -z * ny, x * nx + y * ny], [y, -x, 0.0]]);
        let [moment_a, moment_b] = moments.map(|m| m[0]);
        let (turn_a, turn_b) = (a.response(moment_a), b.response(moment_b));
        let dot = |p: [Real; 3], q: [Real; 3]| p[0] * q[0] + p[1] * q[1] + p[2] * q[2];
        let masses = a.v[3] + b.v[3];
        let [_, across_a, up_a] = moments[0];
        let [_, across_b, up_b] = moments[1];
        let mobility = [
            masses + (dot(moment_a, turn_a) + dot(moment_b, turn_b)),
            masses + (dot(across_a, a.response(across_a)) + dot(across_b, b.response(across_b))),
            masses + (a.tilting(up_a[0], up_a[1]) + b.tilting(up_b[0], up_b[1])),
        ];
        let i_spin = inverse(a.tilting(nx, ny) + b.tilting(nx, ny));
        let i_across = inverse(a.tilting(-ny, nx) + b.tilting(-ny, nx));
        let join = |v: [Real; 3], x: Real| [v[0], v[1], v[2], x];
        self.bodies.push(BodyRow {
            normal: [nx, ny, rub.friction, rub.rolling],
            moment_a: join(moment_a, target),
            moment_b: join(moment_b, inverse(mobility[0])),
            turn_a: join(turn_a, mobility[0]),
            turn_b: join(turn_b, 0.0),
            impulse: join(impulse, 0.0),
            roll: [0.0, 0.0, inverse(mobility[1]), inverse(mobility[2])],
            arm_a: join(arm[0], i_spin),
            arm_b: join(arm[1], i_across),
        });
        self.body_pair.push(bodies.map(|i| i as u32));
    }

    /// Shares the manifold's torque impulses (about the normal, across, up) among its rows.
    pub fn end_bodies(&mut self, from: u32, torque: [Real; 3]) -> Span {
        let rows = (from, self.bodies.len() as u32);
        let share = 1.0 / (rows.1 - rows.0).max(1) as Real;
        for row in &mut self.bodies[rows.0 as usize..] {
            row.impulse[3] = torque[0] * share;
            (row.roll[0], row.roll[1]) = (torque[1] * share, torque[2] * share);
        }
        rows
    }

    /// Impulses of a manifold's `k`-th row: up, x, y.
    #[inline]
    pub fn ground_impulse(&self, span: GroundSpan, k: usize) -> [Real; 3] {
        let block = &self.ground[span.first + k];
        [0, 1, 2].map(|i| block.impulse[i][span.lane])
    }

    /// Impulses of a row: normal, across, up.
    #[inline]
    pub fn body_impulse(&self, row: u32) -> [Real; 3] {
        let [n, t, z, _] = self.bodies[row as usize].impulse;
        [n, t, z]
    }

    /// Torque impulses of a manifold: up, about x, about y.
    pub fn ground_torque(&self, span: GroundSpan) -> [Real; 3] {
        let GroundSpan { lane, first, end } = span;
        self.ground[first..end].iter().fold([0.0; 3], |sum, block| {
            [sum[0] + block.impulse[3][lane], sum[1] + block.roll[0][lane], sum[2] + block.roll[1][lane]]
        })
    }

    /// Torque impulses of a manifold: about the normal, across, up.
    pub fn body_torque(&self, rows: Span) -> [Real; 3] {
        let rows = &self.bodies[rows.0 as usize..rows.1 as usize];
        rows.iter().fold([0.0; 3], |sum, r| [sum[0] + r.impulse[3], sum[1] + r.roll[0], sum[2] + r.roll[1]])
    }

    /// Applies the impulses that the rows begin with.
    pub fn warm_start(&mut self) {
        for (row, pair) in self.bodies.iter().zip(&self.body_pair) {
            push_bodies(&mut self.motion, row, *pair, row.impulse, [row.roll[0], row.roll[1]]);
        }
        for footing in &self.footings {
            for (lane, &body) in footing.bodies[..footing.used].iter().enumerate() {
                let mut motion = self.motion[body as usize];
                for block in &self.ground[footing.first..footing.end] {
                    let roll = [block.roll[0][lane], block.roll[1][lane]];
                    push_ground(&mut motion, block, lane, block.impulse.map(|column| column[lane]), roll);
                }
                self.motion[body as usize] = motion;
            }
        }
        self.sweeps = 0;
        self.change = 0.0;
        self.solving = true;
        self.momentum.forget();
    }

    /// The next sweep goes from the last row to the first.
    #[inline]
    pub fn goes_back(&self) -> bool {
        self.sweeps % 2 == 1
    }

    /// Ends the solving where the last sweep changed little or there were enough; where masses differ greatly, not before
    /// the bodies' contacts have what they want.
    pub fn end_sweep(&mut self, tolerance: Real) {
        let usual = self.change >= tolerance && self.sweeps < self.most_sweeps && !self.momentum.is_used();
        self.solving = usual || (self.sweeps < self.uneven_sweeps && self.lack() > self.uneven_residual);
        if self.solving && !usual {
            self.go_on();
        }
        if self.solving {
            self.change = 0.0;
        }
    }

    /// One sweep over all rows.
    #[inline(always)]
    pub fn sweep<S: Simd8>(&mut self, s: S) {
        let mut change: Real = 0.0;
        self.each_pair(
            #[inline(always)]
            |row, a, b| change = change.max(kernel::body_normal(row, a, b)),
        );
        self.change = change;
        self.ground_normals(s);
        self.each_pair(kernel::body_friction);
        self.ground_frictions(s);
        self.sweeps += 1;
    }

    /// Visits the contacts of bodies. Rows of the same bodies lie side by side: these are taken up once for all of them.
    #[inline(always)]
    fn each_pair(&mut self, mut visit: impl FnMut(&mut BodyRow<f32>, &mut Motion<f32>, &mut Motion<f32>)) {
        let back = self.goes_back();
        let Rows { motion, bodies, body_pair, .. } = self;
        let of = bodies.len().min(body_pair.len());
        let mut k = 0;
        while k < of {
            let at = |k: usize| if back { of - 1 - k } else { k };
            let pair = body_pair[at(k)];
            let [a, b] = pair.map(|i| i as usize);
            let (mut ma, mut mb) = (motion[a], motion[b]);
            while k < of && body_pair[at(k)] == pair {
                visit(&mut bodies[at(k)], &mut ma, &mut mb);
                k += 1;
            }
            (motion[a], motion[b]) = (ma, mb);
        }
    }

    /// Visits the contacts with the ground, eight bodies at a time, which are taken up once for all of theirs.
    #[inline(always)]
    fn each_block<S: Simd8>(&mut self, s: S, mut visit: impl FnMut(&mut Block, &mut Motion<Wide<S>>)) {
        let back = self.goes_back();
        for footing in &self.footings {
            let mut body = wide::load_bodies(s, &self.motion, &footing.bodies);
            let blocks = &mut self.ground[footing.first..footing.end];
            let of = blocks.len();
            for k in 0..of {
                visit(&mut blocks[if back { of - 1 - k } else { k }], &mut body);
            }
            wide::store_bodies(s, &mut self.motion, &footing.bodies, body);
        }
    }

    /// Normal impulses of the contacts with the ground.
    #[inline(always)]
    pub fn ground_normals<S: Simd8>(&mut self, s: S) {
        let mut change = wide::zero(s);
        self.each_block(
            s,
            #[inline(always)]
            |block, body| change = wide::ground_normal(s, block, body).greater(change),
        );
        self.change = wide::greatest(change).max(self.change);
    }

    /// Friction, spinning and rolling of the contacts with the ground.
    #[inline(always)]
    pub fn ground_frictions<S: Simd8>(&mut self, s: S) {
        self.each_block(
            s,
            #[inline(always)]
            |block, body| wide::ground_friction(s, block, body),
        );
    }
}

/// Sweeps one world until its step is solved.
pub struct Solve<'a> {
    pub rows: &'a mut Rows,
    pub tolerance: Real,
}

impl WithSimd for Solve<'_> {
    type Output = ();

    fn run<S: Simd8>(self, s: S) {
        s.vectorize(
            #[inline(always)]
            || {
                while self.rows.solving {
                    self.rows.sweep(s);
                    self.rows.end_sweep(self.tolerance);
                }
            },
        );
    }
}
