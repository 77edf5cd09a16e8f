//! Friction between a body and the ground: an ellipsoidal limit surface (Goyal, Ruina and Papadopoulos 1991),
//! solved implicitly for one time step.

/// The limit surface of one body: greatest friction force and greatest friction torque.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LimitSurface {
    /// Newton.
    pub force: f64,
    /// Newton metres.
    pub torque: f64,
}

/// What the friction acts on: mass (kg), inertia about the centre of mass (kg m^2).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Inertia {
    pub mass: f64,
    pub about_centre: f64,
}

/// Planar velocity of the centre of mass (m/s) and turning rate (rad/s).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Twist {
    pub linear: [f64; 2],
    pub angular: f64,
}

/// Velocity after `dt` seconds of friction.
///
/// The friction acts at a centre of pressure that lies `lead` metres ahead of the centre of mass in the direction of
/// motion (a body pushed above the ground loads its front). With u the velocity there (vx, vy, w), M the mass matrix
/// about that point and D = diag(f^2, f^2, t^2), the friction impulse is -l D u' with l such that it lies on the
/// ellipsoid |j|^2 / f^2 + T^2 / t^2 = dt^2, and M (u' - u) = -l D u'. A body whose stopping impulse lies inside the
/// ellipsoid stops.
///
/// With s = 1/l the function 1/|j| is nearly linear in s (exactly, in one dimension), so a secant finds it in a few
/// rounds.
#[inline]
pub fn after_friction(twist: Twist, inertia: Inertia, surface: LimitSurface, lead: f64, dt: f64) -> Twist {
    let Twist { linear: [vx, vy], angular: w } = twist;
    let speed = vx.hypot(vy);
    if speed == 0.0 && w == 0.0 {
        return twist;
    }
    if surface.force <= 0.0 {
        return twist;
    }
    let (f2, t2) = (surface.force * surface.force, surface.torque * surface.torque);
    let m = inertia.mass;
    // Frame along the motion. While the body mostly spins in place there is no "ahead": the lead fades out.
    let (dx, dy) = if speed > 0.0 { (vx / speed, vy / speed) } else { (1.0, 0.0) };
    let a = lead * speed / speed.hypot(w.abs() * surface.torque / surface.force).max(f64::MIN_POSITIVE);
    // Velocity at the centre of pressure: x along the motion, y across it.
    let (ux, uy) = (speed, w * a);
    // Momentum conjugate to it, M u, with M = [[m,0,0],[0,m,-m a],[0,-m a,I + m a^2]].
    let inertia_at = inertia.about_centre + m * a * a;
    let (px, py, pw) = (m * ux, m * (uy - a * w), inertia_at * w - m * a * uy);
    // q(s) = (s M + D)^-1 M u, so that u' = s q and the impulse is -D q.
    let solve = |s: f64| -> (f64, f64, f64) {
        let (myy, myw, mww) = (s * m + f2, -s * m * a, s * inertia_at + t2);
        let det = myy * mww - myw * myw;
        (px / (s * m + f2), (mww * py - myw * pw) / det, (myy * pw - myw * py) / det)
    };
    let impulse = |q: (f64, f64, f64)| (f2 * (q.0 * q.0 + q.1 * q.1) + t2 * q.2 * q.2).sqrt();
    let stopping = impulse(solve(0.0));
    if stopping <= dt {
        return Twist { linear: [0.0, 0.0], angular: 0.0 };
    }
    let wanted = 1.0 / dt;
    let (mut s0, mut y0) = (0.0, 1.0 / stopping);
    let mut s = (wanted - y0) * (f2 * (ux * ux + uy * uy) + t2 * w * w).sqrt();
    let mut q = solve(s);
    for _ in 0..8 {
        let y = 1.0 / impulse(q);
        if (y - wanted).abs() <= 1e-9 * wanted || y == y0 {
            break;
        }
        let next = s + (wanted - y) * (s - s0) / (y - y0);
        (s0, y0) = (s, y);
        s = next.max(0.0);
        q = solve(s);
    }
    let (qx, qy, qw) = (s * q.0, s * q.1, s * q.2);
    // Back to the centre of mass and the world frame.
    let (cx, cy) = (qx, qy - qw * a);
    Twist { linear: [dx * cx - dy * cy, dy * cx + dx * cy], angular: qw }
}

#[cfg(test)]
mod tests {
    use super::*;

    const BODY: Inertia = Inertia { mass: 0.1, about_centre: 3e-5 };
    const GROUND: LimitSurface = LimitSurface { force: 0.55, torque: 0.017 };

    #[test]
    fn a_sliding_body_loses_mu_g_dt() {
        let before = Twist { linear: [0.3, 0.4], angular: 0.0 };
        let after = after_friction(before, BODY, GROUND, 0.0, 0.01);
        let speed = after.linear[0].hypot(after.linear[1]);
        assert!((speed - (0.5 - 5.5 * 0.01)).abs() < 1e-9, "{speed}");
        assert!((after.linear[1] / after.linear[0] - 4.0 / 3.0).abs() < 1e-9);
    }

    #[test]
    fn a_slow_body_stops_dead() {
        let after = after_friction(Twist { linear: [0.01, 0.0], angular: 0.1 }, BODY, GROUND, 0.01, 0.01);
        assert_eq!(after, Twist { linear: [0.0, 0.0], angular: 0.0 });
    }

    #[test]
    fn the_impulse_lies_on_the_ellipsoid_and_opposes_the_motion() {
        for (lead, w) in [(0.0, 3.0), (0.01, -3.0), (0.01, 0.5), (0.0, 20.0)] {
            let before = Twist { linear: [0.1, -0.05], angular: w };
            let dt = 1.0 / 240.0;
            let after = after_friction(before, BODY, GROUND, lead, dt);
            let energy = |t: Twist| {
                BODY.mass * (t.linear[0].powi(2) + t.linear[1].powi(2)) + BODY.about_centre * t.angular.powi(2)
            };
            assert!(energy(after) < energy(before));
            if lead == 0.0 {
                let j: Vec<f64> = (0..2).map(|i| BODY.mass * (after.linear[i] - before.linear[i])).collect();
                let torque = BODY.about_centre * (after.angular - before.angular);
                let on = (j[0].powi(2) + j[1].powi(2)) / GROUND.force.powi(2) + (torque / GROUND.torque).powi(2);
                assert!((on.sqrt() - dt).abs() < 1e-7 * dt.max(1e-3), "{} {dt}", on.sqrt());
            }
        }
    }
}
