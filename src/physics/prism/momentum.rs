//! More sweeps for bodies whose masses differ greatly.
//!
//! A light body between the tip and a heavy one hands on little of what is asked of it in each sweep: the error falls by a
//! share that is about the ratio of their masses. Such steps go on after the usual sweeps, and between two of these each
//! normal impulse goes on by a share of its last change, which grows while the changes become smaller (Nesterov 1983): as many
//! sweeps are enough as the root of the ratio, and not the ratio.

use super::kernel::{Four, Number};
use super::model::Real;
use super::solver::{Rows, push_bodies, push_ground};
use crate::physics::lanes::LANES;

/// Impulses and rolling torques of a contact.
type Impulses = (Four<Real>, [Real; 2]);

/// What the last sweep left of the normal impulses, and how long the changes have become smaller.
#[derive(Default)]
pub struct Gathered {
    /// Of the contacts of bodies and of those with the ground.
    bodies: Vec<Real>,
    ground: Vec<[Real; LANES]>,
    /// Sweeps since the momentum was last given up; 0 before the first of them.
    steady: u32,
    last_change: Real,
}

impl Gathered {
    /// A new step begins.
    pub fn forget(&mut self) {
        self.steady = 0;
    }

    /// The usual sweeps of the step are over.
    pub fn is_used(&self) -> bool {
        self.steady > 0
    }

    /// The share of their last change by which impulses go on, after a sweep with this greatest change.
    fn share(&mut self, change: Real) -> Real {
        let first = self.steady == 0;
        self.steady = if first || change > self.last_change { 1 } else { self.steady + 1 };
        self.last_change = change;
        let k = (self.steady - 1) as Real;
        if first { 0.0 } else { k / (k + 3.0) }
    }
}

impl Rows {
    /// By how much a normal velocity of two bodies misses what is wanted, at most, m/s.
    pub(super) fn lack(&self) -> Real {
        let lacks = self.bodies.iter().zip(&self.body_pair).map(|(row, pair)| {
            let [a, b] = pair.map(|i| &self.motion[i as usize]);
            let [nx, ny, ..] = row.normal;
            let turning = |m: Four<Real>, w: Four<Real>| m[0] * w[0] + m[1] * w[1] + m[2] * w[2];
            let parting = nx * (b.v[0] - a.v[0])
                + ny * (b.v[1] - a.v[1])
                + (turning(row.moment_b, b.w) - turning(row.moment_a, a.w));
            let lack = row.moment_a[3] - parting;
            if row.impulse[0] > 0.0 { lack.abs() } else { lack }
        });
        lacks.fold(0.0, Real::max)
    }

    /// Lets the normal impulses go on as they changed in the last sweep.
    pub(super) fn go_on(&mut self) {
        let Rows { motion, ground, footings, bodies, body_pair, momentum, change, .. } = self;
        let share = momentum.share(*change);
        momentum.bodies.resize(bodies.len(), Default::default());
        momentum.ground.resize(ground.len(), Default::default());
        for ((row, pair), before) in bodies.iter_mut().zip(body_pair).zip(&mut momentum.bodies) {
            let now: Impulses = (row.impulse, [row.roll[0], row.roll[1]]);
            let next = further(now, *before, share, row.normal[2], row.normal[3]);
            *before = now.0[0];
            let (d, roll) = difference(next, now);
            push_bodies(motion, row, *pair, d, roll);
            row.impulse = next.0;
            [row.roll[0], row.roll[1]] = next.1;
        }
        for footing in footings {
            for (lane, &body) in footing.bodies[..footing.used].iter().enumerate() {
                let motion = &mut motion[body as usize];
                let blocks = ground[footing.first..footing.end].iter_mut();
                for (block, before) in blocks.zip(&mut momentum.ground[footing.first..footing.end]) {
                    let now: Impulses =
                        (block.impulse.map(|column| column[lane]), [block.roll[0][lane], block.roll[1][lane]]);
                    let next = further(now, before[lane], share, block.roll[3][lane], block.roll[2][lane]);
                    before[lane] = now.0[0];
                    let (d, roll) = difference(next, now);
                    push_ground(motion, block, lane, d, roll);
                    block.impulse.iter_mut().zip(next.0).for_each(|(column, x)| column[lane] = x);
                    block.roll.iter_mut().zip(next.1).for_each(|(column, x)| column[lane] = x);
                }
            }
        }
    }
}

fn difference(a: Impulses, b: Impulses) -> Impulses {
    (std::array::from_fn(|k| a.0[k] - b.0[k]), std::array::from_fn(|k| a.1[k] - b.1[k]))
}

/// The normal impulse goes on by a share of its change; the others only come back into what it allows. (Friction that
/// goes on too topples light bodies.)
fn further(now: Impulses, before: Real, share: Real, friction: Real, rolling: Real) -> Impulses {
    let ([load, across, up, spin], roll) = now;
    let load = (load + share * (load - before)).max(0.0);
    let [across, up] = Real::in_circle([across, up], friction * load);
    let limit = rolling * load;
    ([load, across, up, spin.clamp(-limit, limit)], Real::in_circle(roll, limit))
}
