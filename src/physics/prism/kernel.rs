//! The arithmetic of one contact in a sweep, written once for one contact or for eight side by side.
//!
//! Order of operations is part of the contract: a push gives the same bits alone and in a batch. So a kernel only adds,
//! subtracts, multiplies, divides, takes square roots and chooses, and never fuses two of these.

use std::ops::{Add, Div, Mul, Sub};

/// A number, or eight of them.
pub trait Number:
    Copy + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self> + Div<Output = Self> + Sized
{
    /// The same constant everywhere.
    fn constant(self, x: f32) -> Self;
    fn root(self) -> Self;
    /// `self > other ? self : other`
    fn greater(self, other: Self) -> Self;
    /// `self < other ? self : other`
    fn less(self, other: Self) -> Self;
    fn magnitude(self) -> Self;
    /// `self < limit ? yes : no`
    fn if_below(self, limit: Self, yes: Self, no: Self) -> Self;

    /// A pair brought into a circle.
    #[inline(always)]
    fn in_circle(p: [Self; 2], limit: Self) -> [Self; 2] {
        let squared = p[0] * p[0] + p[1] * p[1];
        let allowed = limit * limit;
        // Inside, the square root is not looked at; the greater one keeps it away from a division by zero.
        let scale = limit / squared.greater(limit.constant(1e-30)).root();
        let scale = allowed.if_below(squared, scale, limit.constant(1.0));
        [p[0] * scale, p[1] * scale]
    }
}

impl Number for f32 {
    #[inline(always)]
    fn constant(self, x: f32) -> f32 {
        x
    }
    #[inline(always)]
    fn root(self) -> f32 {
        self.sqrt()
    }
    #[inline(always)]
    fn greater(self, other: f32) -> f32 {
        if self > other { self } else { other }
    }
    #[inline(always)]
    fn less(self, other: f32) -> f32 {
        if self < other { self } else { other }
    }
    #[inline(always)]
    fn magnitude(self) -> f32 {
        self.abs()
    }
    #[inline(always)]
    fn if_below(self, limit: f32, yes: f32, no: f32) -> f32 {
        if self < limit { yes } else { no }
    }

    /// As for many, but without the root and the division where they are not looked at: times 1 changes no bit.
    #[inline(always)]
    fn in_circle(p: [f32; 2], limit: f32) -> [f32; 2] {
        let squared = p[0] * p[0] + p[1] * p[1];
        if limit * limit < squared {
            let scale = limit / squared.greater(1e-30).root();
            [p[0] * scale, p[1] * scale]
        } else {
            p
        }
    }
}

/// Four numbers that lie side by side in memory.
pub type Four<N> = [N; 4];

/// A body while velocities are solved for. What does not move has inverse masses of 0.
#[derive(Debug, Clone, Copy, Default)]
#[repr(C)]
pub struct Motion<N> {
    /// Velocity of the centre of mass, and one over the mass.
    pub v: Four<N>,
    /// Turning rates, and the inertia about the vertical.
    pub w: Four<N>,
    /// Inverse inertia in the world's directions: xx, xy, yy, zz.
    pub i: Four<N>,
}

/// A contact with the ground: normal is up, friction along x and y, as in Bullet, whose friction solves each of these
/// directions with its own effective mass before the pair is brought into the cone.
#[derive(Debug, Clone, Copy, Default)]
#[repr(C)]
pub struct GroundRow<N> {
    /// Arm from the centre of mass; normal velocity that is wanted.
    pub arm: Four<N>,
    /// Turning rates about x and y for a unit impulse up; effective mass; one over it.
    pub lift: Four<N>,
    /// Impulses: up, x, y; spinning torque.
    pub impulse: Four<N>,
    /// Rolling torques about x and y; their limit and friction's per normal impulse.
    pub roll: Four<N>,
    /// Effective masses along x and y, effective inertias about x and y.
    pub mass: Four<N>,
}

/// A contact of two bodies: normal is horizontal, friction across it and up.
#[derive(Debug, Clone, Copy, Default)]
#[repr(C)]
pub struct BodyRow<N> {
    /// Normal, from the first body to the second; limits of friction and of torques per normal impulse.
    pub normal: Four<N>,
    /// Moment of a unit normal impulse about the first body; normal velocity that is wanted.
    pub moment_a: Four<N>,
    /// About the second body; effective mass.
    pub moment_b: Four<N>,
    /// Turning rates that the moment gives the first body; one over the effective mass.
    pub turn_a: Four<N>,
    /// The second body.
    pub turn_b: Four<N>,
    /// Impulses: normal, across, up; spinning torque.
    pub impulse: Four<N>,
    /// Rolling torques across and up; effective masses across and up.
    pub roll: Four<N>,
    /// Arm of the first body; effective inertia about the normal.
    pub arm_a: Four<N>,
    /// Arm of the second body; effective inertia about the direction across.
    pub arm_b: Four<N>,
}

#[inline(always)]
fn clamp<N: Number>(x: N, limit: N) -> N {
    let low = limit.constant(0.0) - limit;
    x.less(limit).greater(low)
}

/// Normal impulse of a ground contact. Gives the change of velocity at the contact.
#[inline(always)]
pub fn ground_normal<N: Number>(row: &mut GroundRow<N>, body: &mut Motion<N>) -> N {
    let [x, y, _, target] = row.arm;
    let [turn_x, turn_y, mass, mobility] = row.lift;
    let lifting = body.v[2] + (body.w[0] * y - body.w[1] * x);
    let old = row.impulse[0];
    let next = (old + (target - lifting) * mass).greater(old.constant(0.0));
    let d = next - old;
    row.impulse[0] = next;
    body.v[2] = body.v[2] + body.v[3] * d;
    body.w[0] = body.w[0] + turn_x * d;
    body.w[1] = body.w[1] + turn_y * d;
    d.magnitude() * mobility
}

/// Friction, spinning and rolling of a ground contact.
#[inline(always)]
pub fn ground_friction<N: Number>(row: &mut GroundRow<N>, body: &mut Motion<N>) {
    let [x, y, z, _] = row.arm;
    let [load, jx, jy, js] = row.impulse;
    let [rx, ry, rolling, friction] = row.roll;
    let [mx, my, ix, iy] = row.mass;
    let (v, w) = (body.v, body.w);
    let u = [v[0] + (w[1] * z - w[2] * y), v[1] + (w[2] * x - w[0] * z)];
    let slide = N::in_circle([jx - u[0] * mx, jy - u[1] * my], friction * load);
    let limit = rolling * load;
    let spin = clamp(js - w[2] * w[3], limit);
    let roll = N::in_circle([rx - w[0] * ix, ry - w[1] * iy], limit);
    let d = [slide[0] - jx, slide[1] - jy];
    let turn = [roll[0] - rx - z * d[1], roll[1] - ry + z * d[0], spin - js + (x * d[1] - y * d[0])];
    row.impulse = [load, slide[0], slide[1], spin];
    row.roll = [roll[0], roll[1], rolling, friction];
    body.v[0] = v[0] + v[3] * d[0];
    body.v[1] = v[1] + v[3] * d[1];
    twist(body, turn);
}

#[inline(always)]
fn velocity_at<N: Number>(m: &Motion<N>, r: [N; 3]) -> [N; 3] {
    let (v, w) = (m.v, m.w);
    [v[0] + (w[1] * r[2] - w[2] * r[1]), v[1] + (w[2] * r[0] - w[0] * r[2]), v[2] + (w[0] * r[1] - w[1] * r[0])]
}

#[inline(always)]
fn moment<N: Number>(r: [N; 3], p: [N; 3]) -> [N; 3] {
    [r[1] * p[2] - r[2] * p[1], r[2] * p[0] - r[0] * p[2], r[0] * p[1] - r[1] * p[0]]
}

#[inline(always)]
fn twist<N: Number>(body: &mut Motion<N>, t: [N; 3]) {
    let [xx, xy, yy, zz] = body.i;
    body.w[0] = body.w[0] + (xx * t[0] + xy * t[1]);
    body.w[1] = body.w[1] + (xy * t[0] + yy * t[1]);
    body.w[2] = body.w[2] + zz * t[2];
}

/// Normal impulse of a contact of two bodies. Gives the change of velocity at the contact.
#[inline(always)]
pub fn body_normal<N: Number>(row: &mut BodyRow<N>, a: &mut Motion<N>, b: &mut Motion<N>) -> N {
    let [nx, ny, ..] = row.normal;
    let ([ax, ay, az, target], [bx, by, bz, mass]) = (row.moment_a, row.moment_b);
    let parting = nx * (b.v[0] - a.v[0]) + ny * (b.v[1] - a.v[1]);
    let turning_b = bx * b.w[0] + by * b.w[1] + bz * b.w[2];
    let turning_a = ax * a.w[0] + ay * a.w[1] + az * a.w[2];
    let old = row.impulse[0];
    let next = (old + (target - (parting + (turning_b - turning_a))) * mass).greater(old.constant(0.0));
    let d = next - old;
    row.impulse[0] = next;
    let (pa, pb) = (d * a.v[3], d * b.v[3]);
    a.v[0] = a.v[0] - nx * pa;
    a.v[1] = a.v[1] - ny * pa;
    b.v[0] = b.v[0] + nx * pb;
    b.v[1] = b.v[1] + ny * pb;
    for k in 0..3 {
        a.w[k] = a.w[k] - row.turn_a[k] * d;
        b.w[k] = b.w[k] + row.turn_b[k] * d;
    }
    d.magnitude() * row.turn_a[3]
}

/// Friction, spinning and rolling of a contact of two bodies.
#[inline(always)]
pub fn body_friction<N: Number>(row: &mut BodyRow<N>, a: &mut Motion<N>, b: &mut Motion<N>) {
    let [nx, ny, friction, rolling] = row.normal;
    let [load, jt, jz, js] = row.impulse;
    let [rt, rz, mt, mz] = row.roll;
    let ([ax, ay, az, i_spin], [bx, by, bz, i_across]) = (row.arm_a, row.arm_b);
    let (ua, ub) = (velocity_at(a, [ax, ay, az]), velocity_at(b, [bx, by, bz]));
    let u = [ub[0] - ua[0], ub[1] - ua[1], ub[2] - ua[2]];
    let across = u[1] * nx - u[0] * ny;
    let slide = N::in_circle([jt - across * mt, jz - u[2] * mz], friction * load);
    let w = [b.w[0] - a.w[0], b.w[1] - a.w[1], b.w[2] - a.w[2]];
    let limit = rolling * load;
    let spin = clamp(js - (w[0] * nx + w[1] * ny) * i_spin, limit);
    // One of the two moves, so the sum is not zero.
    let i_up = load.constant(1.0) / (a.i[3] + b.i[3]);
    let roll = N::in_circle([rt - (w[1] * nx - w[0] * ny) * i_across, rz - w[2] * i_up], limit);
    row.impulse = [load, slide[0], slide[1], spin];
    row.roll = [roll[0], roll[1], mt, mz];
    let (dt, dz) = (slide[0] - jt, slide[1] - jz);
    let (ds, dr, du) = (spin - js, roll[0] - rt, roll[1] - rz);
    let p = [load.constant(0.0) - ny * dt, nx * dt, dz];
    let t = [nx * ds - ny * dr, ny * ds + nx * dr, du];
    let (ta, tb) = (moment([ax, ay, az], p), moment([bx, by, bz], p));
    for (k, &p) in p.iter().enumerate() {
        a.v[k] = a.v[k] - a.v[3] * p;
        b.v[k] = b.v[k] + b.v[3] * p;
    }
    let zero = load.constant(0.0);
    twist(a, [zero - (ta[0] + t[0]), zero - (ta[1] + t[1]), zero - (ta[2] + t[2])]);
    twist(b, [tb[0] + t[0], tb[1] + t[1], tb[2] + t[2]]);
}
