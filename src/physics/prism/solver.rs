//! Impulses of one step: projected Gauss-Seidel over contacts with friction, warm-started.

use super::collide::dot;
use super::model::{Flat, Real};

/// Velocity of a body and what resists its change. A body that does not move has inverse masses of 0.
#[derive(Debug, Clone, Copy, Default)]
pub struct Motion {
    pub v: [Real; 3],
    pub w: [Real; 3],
    pub inverse_mass: Real,
    /// Inverse inertia in the world's directions: xx, xy, yy, zz.
    pub inverse_inertia: [Real; 4],
}

impl Motion {
    #[inline(always)]
    fn turn_response(&self, t: [Real; 3]) -> [Real; 3] {
        let [xx, xy, yy, zz] = self.inverse_inertia;
        [xx * t[0] + xy * t[1], xy * t[0] + yy * t[1], zz * t[2]]
    }

    #[inline(always)]
    fn velocity_at(&self, r: [Real; 3]) -> [Real; 3] {
        let (v, w) = (self.v, self.w);
        [v[0] + w[1] * r[2] - w[2] * r[1], v[1] + w[2] * r[0] - w[0] * r[2], v[2] + w[0] * r[1] - w[1] * r[0]]
    }

    #[inline(always)]
    fn push_at(&mut self, r: [Real; 3], p: [Real; 3]) {
        let m = self.inverse_mass;
        let t = [r[1] * p[2] - r[2] * p[1], r[2] * p[0] - r[0] * p[2], r[0] * p[1] - r[1] * p[0]];
        let dw = self.turn_response(t);
        for i in 0..3 {
            self.v[i] += m * p[i];
            self.w[i] += dw[i];
        }
    }

    #[inline(always)]
    fn twist(&mut self, t: [Real; 3]) {
        let dw = self.turn_response(t);
        for i in 0..3 {
            self.w[i] += dw[i];
        }
    }

    /// Velocity along `d` at `r` for a unit impulse along `d` there.
    #[inline(always)]
    fn mobility(&self, r: [Real; 3], d: [Real; 3]) -> Real {
        let t = [r[1] * d[2] - r[2] * d[1], r[2] * d[0] - r[0] * d[2], r[0] * d[1] - r[1] * d[0]];
        let dw = self.turn_response(t);
        self.inverse_mass + t[0] * dw[0] + t[1] * dw[1] + t[2] * dw[2]
    }

    #[inline(always)]
    fn turn_mobility(&self, d: [Real; 3]) -> Real {
        let dw = self.turn_response(d);
        d[0] * dw[0] + d[1] * dw[1] + d[2] * dw[2]
    }
}

/// A contact with the ground: normal is up, friction along x and y.
#[derive(Debug, Clone, Copy, Default)]
struct GroundRow {
    body: u32,
    arm: [Real; 3],
    /// Normal velocity that is wanted.
    target: Real,
    friction: Real,
    /// Effective masses: up, x, y.
    mass: [Real; 3],
    /// Turning rates about x and y for a unit impulse upwards.
    response: [Real; 2],
    /// Velocity for a unit impulse upwards.
    mobility: Real,
    impulse: [Real; 3],
}

/// A contact of two bodies: normal is horizontal, friction across it and up.
#[derive(Debug, Clone, Copy, Default)]
struct BodyRow {
    bodies: [u32; 2],
    arm: [[Real; 3]; 2],
    normal: Flat,
    target: Real,
    friction: Real,
    /// Effective masses: normal, across, up.
    mass: [Real; 3],
    /// Moments of a unit impulse along the normal, and the turning rates that they give.
    moment: [[Real; 3]; 2],
    response: [[Real; 3]; 2],
    mobility: Real,
    impulse: [Real; 3],
}

/// Spinning and rolling friction of a manifold.
#[derive(Debug, Clone, Copy, Default)]
struct TorqueRow {
    /// The first is none for the ground.
    bodies: [u32; 2],
    /// The manifold's rows.
    rows: (u32, u32),
    /// Metres.
    rolling: Real,
    normal: Flat,
    /// Effective inertias: about the normal, and about the other two axes.
    mass: [Real; 3],
    impulse: [Real; 3],
}

/// Where a manifold's rows lie, to take the impulses back from.
#[derive(Debug, Clone, Copy)]
pub struct Span {
    pub rows: (u32, u32),
    torque: u32,
}

/// The rows of one step.
#[derive(Default)]
pub struct Rows {
    pub motion: Vec<Motion>,
    ground: Vec<GroundRow>,
    bodies: Vec<BodyRow>,
    ground_torque: Vec<TorqueRow>,
    body_torque: Vec<TorqueRow>,
    /// Sweeps of the last solve.
    pub sweeps: usize,
}

#[inline(always)]
fn inverse(x: Real) -> Real {
    if x > 0.0 { 1.0 / x } else { 0.0 }
}

impl Rows {
    pub fn clear(&mut self) {
        self.ground.clear();
        self.bodies.clear();
        self.ground_torque.clear();
        self.body_torque.clear();
    }

    /// Velocity at which the halves of a contact part now.
    #[inline]
    pub fn parting(&self, bodies: [usize; 2], arm: &[[Real; 3]; 2], normal: Flat) -> Real {
        let [a, b] = bodies.map(|i| &self.motion[i]);
        let (ua, ub) = (a.velocity_at(arm[0]), b.velocity_at(arm[1]));
        dot([ub[0] - ua[0], ub[1] - ua[1]], normal)
    }

    #[inline]
    pub fn lifting(&self, body: usize, arm: &[Real; 3]) -> Real {
        self.motion[body].velocity_at(*arm)[2]
    }

    #[inline]
    pub fn ground_rows(&self) -> u32 {
        self.ground.len() as u32
    }

    #[inline]
    pub fn body_rows(&self) -> u32 {
        self.bodies.len() as u32
    }

    pub fn add_ground(&mut self, body: usize, arm: [Real; 3], target: Real, friction: Real, impulse: [Real; 3]) {
        let m = &self.motion[body];
        let mass = [[0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]].map(|d| inverse(m.mobility(arm, d)));
        let [x, y, _] = m.turn_response([arm[1], -arm[0], 0.0]);
        let mobility = m.inverse_mass + x * arm[1] - y * arm[0];
        let body = body as u32;
        self.ground.push(GroundRow { body, arm, target, friction, mass, response: [x, y], mobility, impulse });
    }

    pub fn end_ground(&mut self, body: usize, from: u32, rolling: Real, impulse: [Real; 3]) -> Span {
        let rows = (from, self.ground_rows());
        let m = &self.motion[body];
        let mass = [[0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]].map(|d| inverse(m.turn_mobility(d)));
        let bodies = [body as u32; 2];
        self.ground_torque.push(TorqueRow { bodies, rows, rolling, normal: [0.0; 2], mass, impulse });
        Span { rows, torque: self.ground_torque.len() as u32 - 1 }
    }

    pub fn add_bodies(
        &mut self,
        bodies: [usize; 2],
        arm: [[Real; 3]; 2],
        normal: Flat,
        target: Real,
        friction: Real,
        impulse: [Real; 3],
    ) {
        let axes = axes(normal);
        let [a, b] = bodies.map(|i| &self.motion[i]);
        let mobilities = axes.map(|d| a.mobility(arm[0], d) + b.mobility(arm[1], d));
        let [x, y] = normal;
        let moment = arm.map(|r| [-r[2] * y, r[2] * x, r[0] * y - r[1] * x]);
        let response = [a.turn_response(moment[0]), b.turn_response(moment[1])];
        self.bodies.push(BodyRow {
            bodies: bodies.map(|i| i as u32),
            arm,
            normal,
            target,
            friction,
            mass: mobilities.map(inverse),
            moment,
            response,
            mobility: mobilities[0],
            impulse,
        });
    }

    pub fn end_bodies(&mut self, bodies: [usize; 2], from: u32, rolling: Real, impulse: [Real; 3]) -> Span {
        let rows = (from, self.body_rows());
        let normal = self.bodies[from as usize].normal;
        let axes = axes(normal);
        let [a, b] = bodies.map(|i| &self.motion[i]);
        let mass = axes.map(|d| inverse(a.turn_mobility(d) + b.turn_mobility(d)));
        let bodies = bodies.map(|i| i as u32);
        self.body_torque.push(TorqueRow { bodies, rows, rolling, normal, mass, impulse });
        Span { rows, torque: self.body_torque.len() as u32 - 1 }
    }

    #[inline]
    pub fn ground_impulse(&self, row: u32) -> [Real; 3] {
        self.ground[row as usize].impulse
    }

    #[inline]
    pub fn body_impulse(&self, row: u32) -> [Real; 3] {
        self.bodies[row as usize].impulse
    }

    #[inline]
    pub fn ground_torque(&self, span: Span) -> [Real; 3] {
        self.ground_torque[span.torque as usize].impulse
    }

    #[inline]
    pub fn body_torque(&self, span: Span) -> [Real; 3] {
        self.body_torque[span.torque as usize].impulse
    }

    /// Applies the impulses that the rows begin with.
    fn warm_start(&mut self) {
        for row in &self.bodies {
            let p = combine(&axes(row.normal), row.impulse);
            self.motion[row.bodies[0] as usize].push_at(row.arm[0], p.map(|x| -x));
            self.motion[row.bodies[1] as usize].push_at(row.arm[1], p);
        }
        for row in &self.ground {
            self.motion[row.body as usize].push_at(row.arm, [row.impulse[1], row.impulse[2], row.impulse[0]]);
        }
        for row in &self.body_torque {
            let t = combine(&axes(row.normal), row.impulse);
            self.motion[row.bodies[0] as usize].twist(t.map(|x| -x));
            self.motion[row.bodies[1] as usize].twist(t);
        }
        for row in &self.ground_torque {
            self.motion[row.bodies[1] as usize].twist([row.impulse[1], row.impulse[2], row.impulse[0]]);
        }
    }

    /// Sweeps until no normal velocity changes by more than `tolerance`, at most `iterations` times.
    pub fn solve(&mut self, iterations: usize, tolerance: Real) {
        self.sweeps = 0;
        self.warm_start();
        for _ in 0..iterations {
            self.sweeps += 1;
            let change = self.normals();
            self.torques();
            self.friction();
            if change < tolerance {
                break;
            }
        }
    }

    #[inline]
    fn normals(&mut self) -> Real {
        let mut change: Real = 0.0;
        for row in &mut self.bodies {
            let [a, b] = row.bodies.map(|i| i as usize);
            let (n, m) = (row.normal, self.motion[a].v);
            let (wa, wb, v) = (self.motion[a].w, self.motion[b].w, self.motion[b].v);
            let [ja, jb] = row.moment;
            let linear = n[0] * (v[0] - m[0]) + n[1] * (v[1] - m[1]);
            let turning =
                (jb[0] * wb[0] + jb[1] * wb[1] + jb[2] * wb[2]) - (ja[0] * wa[0] + ja[1] * wa[1] + ja[2] * wa[2]);
            let next = (row.impulse[0] + (row.target - (linear + turning)) * row.mass[0]).max(0.0);
            let d = next - row.impulse[0];
            row.impulse[0] = next;
            change = change.max(d.abs() * row.mobility);
            for (body, d, response) in [(a, -d, &row.response[0]), (b, d, &row.response[1])] {
                let motion = &mut self.motion[body];
                let p = d * motion.inverse_mass;
                motion.v[0] += n[0] * p;
                motion.v[1] += n[1] * p;
                for i in 0..3 {
                    motion.w[i] += response[i] * d;
                }
            }
        }
        for row in &mut self.ground {
            let m = &mut self.motion[row.body as usize];
            let lifting = m.v[2] + m.w[0] * row.arm[1] - m.w[1] * row.arm[0];
            let next = (row.impulse[0] + (row.target - lifting) * row.mass[0]).max(0.0);
            let d = next - row.impulse[0];
            row.impulse[0] = next;
            change = change.max(d.abs() * row.mobility);
            m.v[2] += m.inverse_mass * d;
            m.w[0] += row.response[0] * d;
            m.w[1] += row.response[1] * d;
        }
        change
    }

    #[inline]
    fn torques(&mut self) {
        for row in &mut self.body_torque {
            let [a, b] = row.bodies.map(|i| i as usize);
            let load: Real = self.bodies[row.rows.0 as usize..row.rows.1 as usize].iter().map(|r| r.impulse[0]).sum();
            let limit = row.rolling * load;
            let (wa, wb) = (self.motion[a].w, self.motion[b].w);
            let w = [wb[0] - wa[0], wb[1] - wa[1], wb[2] - wa[2]];
            let n = row.normal;
            let about = [w[0] * n[0] + w[1] * n[1], w[1] * n[0] - w[0] * n[1], w[2]];
            let d = row.limited(about, limit);
            let t = [n[0] * d[0] - n[1] * d[1], n[1] * d[0] + n[0] * d[1], d[2]];
            self.motion[a].twist(t.map(|x| -x));
            self.motion[b].twist(t);
        }
        for row in &mut self.ground_torque {
            let load: Real = self.ground[row.rows.0 as usize..row.rows.1 as usize].iter().map(|r| r.impulse[0]).sum();
            let m = &mut self.motion[row.bodies[1] as usize];
            let limit = row.rolling * load;
            let d = row.limited([m.w[2], m.w[0], m.w[1]], limit);
            m.twist([d[1], d[2], d[0]]);
        }
    }

    #[inline]
    fn friction(&mut self) {
        for row in &mut self.bodies {
            let [a, b] = row.bodies.map(|i| i as usize);
            let (ua, ub) = (self.motion[a].velocity_at(row.arm[0]), self.motion[b].velocity_at(row.arm[1]));
            let u = [ub[0] - ua[0], ub[1] - ua[1], ub[2] - ua[2]];
            let n = row.normal;
            let across = u[1] * n[0] - u[0] * n[1];
            let limit = row.friction * row.impulse[0];
            let next = in_circle([row.impulse[1] - across * row.mass[1], row.impulse[2] - u[2] * row.mass[2]], limit);
            let d = [next[0] - row.impulse[1], next[1] - row.impulse[2]];
            row.impulse = [row.impulse[0], next[0], next[1]];
            let p = [-n[1] * d[0], n[0] * d[0], d[1]];
            self.motion[a].push_at(row.arm[0], p.map(|x| -x));
            self.motion[b].push_at(row.arm[1], p);
        }
        for row in &mut self.ground {
            let m = &mut self.motion[row.body as usize];
            let [x, y, z] = row.arm;
            let u = [m.v[0] + m.w[1] * z - m.w[2] * y, m.v[1] + m.w[2] * x - m.w[0] * z];
            let limit = row.friction * row.impulse[0];
            let next = in_circle([row.impulse[1] - u[0] * row.mass[1], row.impulse[2] - u[1] * row.mass[2]], limit);
            let d = [next[0] - row.impulse[1], next[1] - row.impulse[2]];
            row.impulse = [row.impulse[0], next[0], next[1]];
            m.v[0] += m.inverse_mass * d[0];
            m.v[1] += m.inverse_mass * d[1];
            m.twist([-z * d[1], z * d[0], x * d[1] - y * d[0]]);
        }
    }
}

impl TorqueRow {
    /// Impulses that stop the turning, within the limit: about the normal by itself, about the other axes as a pair.
    #[inline(always)]
    fn limited(&mut self, w: [Real; 3], limit: Real) -> [Real; 3] {
        let spin = (self.impulse[0] - w[0] * self.mass[0]).clamp(-limit, limit);
        let roll = in_circle([self.impulse[1] - w[1] * self.mass[1], self.impulse[2] - w[2] * self.mass[2]], limit);
        let next = [spin, roll[0], roll[1]];
        let d = [next[0] - self.impulse[0], next[1] - self.impulse[1], next[2] - self.impulse[2]];
        self.impulse = next;
        d
    }
}

#[inline(always)]
fn in_circle(p: Flat, limit: Real) -> Flat {
    let squared = dot(p, p);
    if squared <= limit * limit {
        return p;
    }
    let scale = limit / squared.sqrt();
    [p[0] * scale, p[1] * scale]
}

/// Normal, tangent and up.
#[inline(always)]
fn axes(n: Flat) -> [[Real; 3]; 3] {
    [[n[0], n[1], 0.0], [-n[1], n[0], 0.0], [0.0, 0.0, 1.0]]
}

#[inline(always)]
fn combine(axes: &[[Real; 3]; 3], p: [Real; 3]) -> [Real; 3] {
    [0, 1, 2].map(|i| axes[0][i] * p[0] + axes[1][i] * p[1] + axes[2][i] * p[2])
}
