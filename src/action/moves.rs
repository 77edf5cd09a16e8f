//! Moves of a rearrangement: pick-and-place and the drag (REMP, dissertation chapter 7), and what they cost.

use std::sync::Arc;

use serde::{Deserialize, Serialize};

use crate::error::{Result, check_positive, check_range};
use crate::geom::{Pose2, normalize_angle};

/// One move of one body.
#[derive(Debug, Clone, PartialEq)]
pub enum Move {
    /// The body is lifted over the others and set down ("pick-n-place").
    PickPlace { body: usize, pick: Pose2, place: Pose2 },
    /// The end-effector holds the body on the table and takes it along the waypoints ("push from top"). The first is
    /// where the body is, the last where it ends; between two the pose changes linearly, the heading the shorter way.
    Drag { body: usize, waypoints: Arc<[Pose2]> },
}

impl Default for Move {
    fn default() -> Self {
        Move::PickPlace { body: 0, pick: Pose2::IDENTITY, place: Pose2::IDENTITY }
    }
}

impl Move {
    /// Index of the body that moves.
    pub fn body(&self) -> usize {
        match self {
            Move::PickPlace { body, .. } | Move::Drag { body, .. } => *body,
        }
    }

    /// Where the body is before.
    pub fn from(&self) -> Pose2 {
        match self {
            Move::PickPlace { pick, .. } => *pick,
            Move::Drag { waypoints, .. } => waypoints.first().copied().unwrap_or_default(),
        }
    }

    /// Where the body is afterwards.
    pub fn to(&self) -> Pose2 {
        match self {
            Move::PickPlace { place, .. } => *place,
            Move::Drag { waypoints, .. } => waypoints.last().copied().unwrap_or_default(),
        }
    }

    /// The poses of the move in order: two, or the waypoints.
    pub fn poses(&self) -> Vec<Pose2> {
        match self {
            Move::PickPlace { pick, place, .. } => vec![*pick, *place],
            Move::Drag { waypoints, .. } => waypoints.to_vec(),
        }
    }
}

/// What moves cost: in metres for the search (REMP, "reward shaping": distance plus a fixed cost), and in seconds of a
/// robot. The source gives no numbers; `docs/rearrangement.md` says where these come from.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct MoveCosts {
    /// Fixed cost of a pick-and-place, metres.
    pub pick_place: f64,
    /// Fixed cost of a drag, metres.
    pub drag: f64,
    /// Length of a turn along a drag, metres per radian.
    pub turn: f64,
    /// Greatest speed of the end-effector, metres per second.
    pub speed: f64,
    /// Its acceleration and deceleration, metres per second squared.
    pub acceleration: f64,
    /// Seconds that one pick-and-place takes beyond the way: down, grip, up, down, release, up.
    pub pick_place_seconds: f64,
    /// Seconds that one drag takes beyond the way: down, hold, release, up.
    pub drag_seconds: f64,
}

impl Default for MoveCosts {
    fn default() -> Self {
        MoveCosts {
            pick_place: 0.10,
            drag: 0.15,
            turn: 0.1,
            speed: 0.25,
            acceleration: 1.0,
            pick_place_seconds: 2.0,
            drag_seconds: 1.5,
        }
    }
}

impl MoveCosts {
    /// Refuses numbers that make no sense, by name.
    pub fn validate(&self) -> Result<()> {
        check_range("costs.pick_place", self.pick_place, 0.0..=100.0)?;
        check_range("costs.drag", self.drag, 0.0..=100.0)?;
        check_range("costs.turn", self.turn, 0.0..=100.0)?;
        check_positive("costs.speed", self.speed)?;
        check_positive("costs.acceleration", self.acceleration)?;
        check_range("costs.pick_place_seconds", self.pick_place_seconds, 0.0..=1000.0)?;
        check_range("costs.drag_seconds", self.drag_seconds, 0.0..=1000.0)
    }

    /// Distance between two poses with the turn weighed in, metres.
    pub fn distance(&self, a: &Pose2, b: &Pose2) -> f64 {
        (a.position() - b.position()).norm() + self.turn * normalize_angle(a.theta - b.theta).abs()
    }

    /// The way of the end-effector: between pick and place the distance, along a drag the length with its turns.
    pub fn length(&self, action: &Move) -> f64 {
        match action {
            Move::PickPlace { pick, place, .. } => (pick.position() - place.position()).norm(),
            Move::Drag { waypoints, .. } => waypoints.windows(2).map(|pair| self.distance(&pair[0], &pair[1])).sum(),
        }
    }

    /// Cost in the planner's terms, metres.
    pub fn metres(&self, action: &Move) -> f64 {
        let fixed = if matches!(action, Move::PickPlace { .. }) { self.pick_place } else { self.drag };
        self.length(action) + fixed
    }

    /// Seconds of robot time.
    pub fn seconds(&self, action: &Move) -> f64 {
        let fixed = if matches!(action, Move::PickPlace { .. }) { self.pick_place_seconds } else { self.drag_seconds };
        self.travel_seconds(self.length(action)) + fixed
    }

    /// Seconds for a way of this length from rest to rest: a trapezoidal speed profile, or a triangular one where the
    /// way is too short to reach full speed.
    pub fn travel_seconds(&self, length: f64) -> f64 {
        let ramps = self.speed * self.speed / self.acceleration;
        if length >= ramps {
            length / self.speed + self.speed / self.acceleration
        } else {
            2.0 * (length / self.acceleration).sqrt()
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn costs_are_the_way_plus_a_fixed_part() {
        let costs = MoveCosts::default();
        let at = Pose2::new;
        let lift = Move::PickPlace { body: 0, pick: at(0.0, 0.0, 0.0), place: at(0.3, 0.4, 1.0) };
        assert!((costs.metres(&lift) - 0.6).abs() < 1e-12);
        // 0.5 m at 0.25 m/s, a quarter of a second of ramps, and two seconds.
        assert!((costs.seconds(&lift) - 4.25).abs() < 1e-12);
        let waypoints = [at(0.0, 0.0, 3.1), at(0.3, 0.0, 3.1), at(0.3, 0.0, -3.1)].into();
        let drag = Move::Drag { body: 0, waypoints };
        let turned = std::f64::consts::TAU - 6.2;
        assert!((costs.metres(&drag) - (0.45 + 0.1 * turned)).abs() < 1e-12);
        assert_eq!((drag.from(), drag.to()), (at(0.0, 0.0, 3.1), at(0.3, 0.0, -3.1)));
    }

    #[test]
    fn short_ways_never_reach_full_speed() {
        let costs = MoveCosts::default();
        assert_eq!(costs.travel_seconds(0.0), 0.0);
        assert!((costs.travel_seconds(0.0625) - 0.5).abs() < 1e-12);
        assert!((costs.travel_seconds(0.01) - 0.2).abs() < 1e-12);
    }

    #[test]
    fn bad_constants_are_refused_by_name() {
        let bad = MoveCosts { speed: 0.0, ..MoveCosts::default() };
        assert!(bad.validate().unwrap_err().to_string().starts_with("costs.speed"));
        let bad = MoveCosts { drag: f64::NAN, ..MoveCosts::default() };
        assert!(bad.validate().unwrap_err().to_string().starts_with("costs.drag"));
    }
}
