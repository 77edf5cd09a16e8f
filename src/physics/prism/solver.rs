//! Impulses of one step: projected Gauss-Seidel over contacts with friction, warm-started.
//!
//! A sweep solves all normal impulses and then friction, spinning and rolling, as Bullet does; solving a contact's
//! friction right after its normal impulse needs many more sweeps. Sweeps go forth and back in turn.

use super::kernel::{self, BodyRow, GroundRow, Motion};
use super::model::{Flat, Real};

/// Where a manifold's rows lie, to take the impulses back from.
pub type Span = (u32, u32);

/// The rows of one step.
#[derive(Default)]
pub struct Rows {
    pub motion: Vec<Motion<f32>>,
    pub ground: Vec<GroundRow<f32>>,
    /// The body of each ground row, twice.
    pub ground_body: Vec<[u32; 2]>,
    pub bodies: Vec<BodyRow<f32>>,
    /// The bodies of each body row.
    pub body_pair: Vec<[u32; 2]>,
    /// Sweeps since the rows were made.
    pub sweeps: u32,
    /// Greatest change of a normal velocity in the last sweep, m/s.
    pub change: Real,
    /// More sweeps are wanted.
    pub solving: bool,
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

impl Rows {
    pub fn clear(&mut self) {
        self.ground.clear();
        self.ground_body.clear();
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

    /// Impulses: up, x, y.
    pub fn add_ground(&mut self, body: usize, arm: [Real; 3], target: Real, rub: Rubbing, impulse: [Real; 3]) {
        let m = &self.motion[body];
        let [x, y, z] = arm;
        let [xx, xy, yy, zz] = m.i;
        let turn = [xx * y - xy * x, xy * y - yy * x];
        let up = m.v[3] + (y * turn[0] - x * turn[1]);
        let sides = [m.v[3] + (z * z * yy + y * y * zz), m.v[3] + (z * z * xx + x * x * zz)].map(inverse);
        self.ground.push(GroundRow {
            arm: [x, y, z, target],
            lift: [turn[0], turn[1], inverse(up), up],
            impulse: [impulse[0], impulse[1], impulse[2], 0.0],
            roll: [0.0, 0.0, rub.rolling, rub.friction],
            mass: [sides[0], sides[1], inverse(m.i[0]), inverse(m.i[2])],
        });
        self.ground_body.push([body as u32; 2]);
    }

    /// Shares the manifold's torque impulses (up, about x, about y) among its rows.
    pub fn end_ground(&mut self, from: u32, torque: [Real; 3]) -> Span {
        let rows = (from, self.ground.len() as u32);
        let share = 1.0 / (rows.1 - rows.0).max(1) as Real;
        for row in &mut self.ground[rows.0 as usize..] {
            row.impulse[3] = torque[0] * share;
            (row.roll[0], row.roll[1]) = (torque[1] * share, torque[2] * share);
        }
        rows
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
        let moments = arm.map(|[x, y, z]| {
            [[-z * ny, z * nx, x * ny - y * nx], [-z * nx, -z * ny, x * nx + y * ny], [y, -x, 0.0]]
        });
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

    /// Impulses of a row: up, x, y.
    #[inline]
    pub fn ground_impulse(&self, row: u32) -> [Real; 3] {
        let [n, x, y, _] = self.ground[row as usize].impulse;
        [n, x, y]
    }

    /// Impulses of a row: normal, across, up.
    #[inline]
    pub fn body_impulse(&self, row: u32) -> [Real; 3] {
        let [n, t, z, _] = self.bodies[row as usize].impulse;
        [n, t, z]
    }

    /// Torque impulses of a manifold: up, about x, about y.
    pub fn ground_torque(&self, rows: Span) -> [Real; 3] {
        let rows = &self.ground[rows.0 as usize..rows.1 as usize];
        rows.iter().fold([0.0; 3], |sum, r| [sum[0] + r.impulse[3], sum[1] + r.roll[0], sum[2] + r.roll[1]])
    }

    /// Torque impulses of a manifold: about the normal, across, up.
    pub fn body_torque(&self, rows: Span) -> [Real; 3] {
        let rows = &self.bodies[rows.0 as usize..rows.1 as usize];
        rows.iter().fold([0.0; 3], |sum, r| [sum[0] + r.impulse[3], sum[1] + r.roll[0], sum[2] + r.roll[1]])
    }

    /// Applies the impulses that the rows begin with.
    pub fn warm_start(&mut self) {
        for (row, pair) in self.bodies.iter().zip(&self.body_pair) {
            let [nx, ny, ..] = row.normal;
            let ([n, t, z, s], [rt, rz, ..]) = (row.impulse, row.roll);
            let p = [nx * n - ny * t, ny * n + nx * t, z];
            let torque = [nx * s - ny * rt, ny * s + nx * rt, rz];
            for (body, arm, sign) in [(pair[0], row.arm_a, -1.0), (pair[1], row.arm_b, 1.0)] {
                let moment = cross([arm[0], arm[1], arm[2]], p);
                let turn = [0, 1, 2].map(|k| sign * (moment[k] + torque[k]));
                self.motion[body as usize].push(p.map(|x| sign * x), turn);
            }
        }
        for (row, &[body, _]) in self.ground.iter().zip(&self.ground_body) {
            let ([n, x, y, s], [rx, ry, ..]) = (row.impulse, row.roll);
            let moment = cross([row.arm[0], row.arm[1], row.arm[2]], [x, y, n]);
            self.motion[body as usize].push([x, y, n], [moment[0] + rx, moment[1] + ry, moment[2] + s]);
        }
        self.sweeps = 0;
        self.change = 0.0;
        self.solving = true;
    }

    /// The next sweep goes from the last row to the first.
    #[inline]
    pub fn goes_back(&self) -> bool {
        self.sweeps % 2 == 1
    }

    /// Ends the solving where the last sweep changed little or there were enough.
    pub fn end_sweep(&mut self, iterations: usize, tolerance: Real) {
        self.solving = self.change >= tolerance && (self.sweeps as usize) < iterations;
        if self.solving {
            self.change = 0.0;
        }
    }

    /// One sweep over all rows.
    pub fn sweep(&mut self) {
        let back = self.goes_back();
        let turned = |k: usize, of: usize| if back { of - 1 - k } else { k };
        let mut change: Real = 0.0;
        let (bodies, grounds) = (self.bodies.len(), self.ground.len());
        for k in 0..bodies {
            let k = turned(k, bodies);
            let [a, b] = self.body_pair[k].map(|i| i as usize);
            let (mut ma, mut mb) = (self.motion[a], self.motion[b]);
            change = change.max(kernel::body_normal(&mut self.bodies[k], &mut ma, &mut mb));
            (self.motion[a], self.motion[b]) = (ma, mb);
        }
        for k in 0..grounds {
            let k = turned(k, grounds);
            let body = &mut self.motion[self.ground_body[k][0] as usize];
            change = change.max(kernel::ground_normal(&mut self.ground[k], body));
        }
        for k in 0..bodies {
            let k = turned(k, bodies);
            let [a, b] = self.body_pair[k].map(|i| i as usize);
            let (mut ma, mut mb) = (self.motion[a], self.motion[b]);
            kernel::body_friction(&mut self.bodies[k], &mut ma, &mut mb);
            (self.motion[a], self.motion[b]) = (ma, mb);
        }
        for k in 0..grounds {
            let k = turned(k, grounds);
            let body = &mut self.motion[self.ground_body[k][0] as usize];
            kernel::ground_friction(&mut self.ground[k], body);
        }
        self.sweeps += 1;
        self.change = change;
    }
}
