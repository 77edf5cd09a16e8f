//! A hand that keeps, loses and shoves bodies as the recorded robot did.

use std::f64::consts::TAU;

use crate::geom::{Pose2, pieces_gap_below};
use crate::run::{Key, Stream};
use crate::scene::{Scene, State, Table};

/// Bodies are not all alike in what no feature of a grasp says: the standard deviation of a body's own share of the log
/// odds in a world. By the recorded repeats of `fit` (22 grasps, 8 attempts each) the likeliest of 0, 0.5, 1 ... 6.
const LUCK: f64 = 1.0;
/// So much steeper are log odds within a world, so that over worlds the chance is what it was.
const STEEPER: f64 = 1.16;
/// Where a body that was lost in the air comes down: the median of the recordings, farther than a workspace's half, metres.
const THROWN: f64 = 0.75;

/// How grasps end in one world.
#[derive(Debug, Clone)]
pub struct RobotHand {
    key: Key,
    attempts: u64,
}

/// What became of a body that was grasped.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Held {
    Kept,
    /// The fingers did not lift it; they moved it by this, in the world's axes, about its origin.
    Slipped(Pose2),
    /// It was lifted and fell, so far from where it lay.
    Lost(Pose2),
}

impl RobotHand {
    pub fn new(key: Key) -> RobotHand {
        RobotHand { key, attempts: 0 }
    }

    /// One attempt at a body whose grasp has this chance of keeping it.
    pub fn attempt(&mut self, body: usize, chance: f64) -> Held {
        let luck = LUCK * self.key.child(0).child(body as u64).stream().normal();
        let mut stream = self.key.child(1).child(self.attempts).stream();
        self.attempts += 1;
        if stream.chance(in_this_world(chance, luck)) {
            return Held::Kept;
        }
        if stream.chance(lost_of_failed().at(chance)) {
            return Held::Lost(moved(&mut stream, THROWN, TAU / 2.0));
        }
        let distance = slip_distance().at(stream.unit());
        let turn = slip_turn().at(stream.unit());
        Held::Slipped(moved(&mut stream, distance, turn))
    }
}

/// The chance in a world where the body has so much luck. No chance stays none.
fn in_this_world(chance: f64, luck: f64) -> f64 {
    if chance <= 0.0 {
        return 0.0;
    }
    let odds = (chance / (1.0 - chance)).ln() * STEEPER + luck;
    1.0 / (1.0 + (-odds).exp())
}

/// Of the grasps of `fit` that kept nothing: the share that lifted the body first, over their chance.
fn lost_of_failed() -> Table {
    Table::new(&[[0.03, 0.01], [0.12, 0.22], [0.35, 0.19], [0.65, 0.45], [0.9, 0.48]])
}

/// Of those that did not: how far the body was shoved, metres, over the quantile.
fn slip_distance() -> Table {
    Table::new(&[[0.0, 0.0], [0.1, 0.001], [0.25, 0.0046], [0.5, 0.0122], [0.75, 0.023], [0.9, 0.0344], [1.0, 0.06]])
}

/// And turned, radians.
fn slip_turn() -> Table {
    Table::new(&[[0.0, 0.0], [0.25, 0.0314], [0.5, 0.096], [0.75, 0.2025], [0.9, 0.3665], [1.0, 0.7]])
}

fn moved(stream: &mut Stream, distance: f64, turn: f64) -> Pose2 {
    let way = stream.uniform(0.0, TAU);
    let turn = if stream.chance(0.5) { turn } else { -turn };
    Pose2::new(distance * way.cos(), distance * way.sin(), turn)
}

/// Moves a body on the table by a motion in the world's axes; by as much of it as leaves it clear of the others.
pub fn shove(scene: &Scene, state: &mut State, body: usize, motion: &Pose2) {
    let before = state.pose(body);
    for quarters in (1..=4).rev() {
        let share = f64::from(quarters) / 4.0;
        let pose =
            Pose2::new(before.x + share * motion.x, before.y + share * motion.y, before.theta + share * motion.theta);
        let footprint = &scene.body(body).footprint;
        let free = state
            .iter()
            .filter(|(i, _)| *i != body)
            .all(|(i, other)| pieces_gap_below(footprint, &pose, &scene.body(i).footprint, &other, 0.0) >= 0.0);
        if free {
            return state.set_pose(body, pose);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::eval::testing::row;

    fn kept(chance: f64, worlds: u64, attempts: u64) -> Vec<u64> {
        let keeps = |world: u64| {
            let mut hand = RobotHand::new(Key::new(world));
            (0..attempts).filter(|_| hand.attempt(2, chance) == Held::Kept).count() as u64
        };
        (0..worlds).map(keeps).collect()
    }

    #[test]
    fn over_worlds_it_keeps_what_the_chance_says() {
        for chance in [0.05, 0.3, 0.5, 0.8, 0.95] {
            let share = kept(chance, 4000, 1).iter().sum::<u64>() as f64 / 4000.0;
            assert!((share - chance).abs() < 0.025, "{chance}: {share}");
        }
        assert_eq!(kept(0.0, 200, 5).iter().sum::<u64>(), 0);
    }

    #[test]
    fn a_body_has_its_luck_for_as_long_as_the_world_is() {
        // Independent attempts would agree in all of eight less often.
        let eight = kept(0.7, 2000, 8);
        let unanimous = eight.iter().filter(|&&k| k == 0 || k == 8).count() as f64 / 2000.0;
        assert!(unanimous > 0.7f64.powi(8) + 0.05, "{unanimous}");
        assert_eq!(eight, kept(0.7, 2000, 8), "the same again");
    }

    #[test]
    fn what_is_not_kept_is_shoved_or_thrown() {
        let (mut slips, mut lost) = (Vec::new(), 0);
        for world in 0..3000 {
            match RobotHand::new(Key::new(world)).attempt(0, 0.65) {
                Held::Kept => {}
                Held::Slipped(motion) => slips.push(motion.position().norm()),
                Held::Lost(motion) => {
                    lost += 1;
                    assert!((motion.position().norm() - THROWN).abs() < 1e-12);
                }
            }
        }
        let share = f64::from(lost) / (f64::from(lost) + slips.len() as f64);
        assert!((share - 0.45).abs() < 0.06, "{share}");
        slips.sort_by(f64::total_cmp);
        assert!((slips[slips.len() / 2] - 0.0122).abs() < 0.0025);
    }

    #[test]
    fn a_shoved_body_stays_clear_of_the_others() {
        let problem = row();
        for k in 0..64 {
            let way = TAU * f64::from(k) / 64.0;
            let mut state = problem.state.clone();
            shove(&problem.scene, &mut state, 0, &Pose2::new(0.03 * way.cos(), 0.03 * way.sin(), 0.3));
            let (a, b) = (&problem.scene.body(0).footprint, &problem.scene.body(1).footprint);
            assert!(pieces_gap_below(a, &state.pose(0), b, &state.pose(1), 0.0) >= -1e-9);
            assert!((state.pose(0).position() - problem.state.pose(0).position()).norm() <= 0.03 + 1e-6);
        }
    }
}
