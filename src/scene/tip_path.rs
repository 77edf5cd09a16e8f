//! How a robot's tip really goes when it is told to push: it comes down higher than it is sent and sinks on the way, and
//! the arm begins to lift before it has arrived, so that the last part of the way is made while the tip rises. Engines
//! that know heights simulate it; in the plane the tip passes over a body from where it is above the body's top.

use serde::{Deserialize, Serialize};

use super::table::Table;
use crate::bounds;
use crate::error::{Error, Result};
use crate::geom::{Vec2, vec2};

/// The way of the tip's lower end in a push, along the straight line from the commanded start to the commanded end.
/// Metres.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TipPath {
    /// Its height above the table over the way from the start, before the arm lifts. Never rises.
    pub sink: Table,
    /// How long before the commanded end the arm begins to lift, in pushes along the line to the robot's base ...
    pub shortfall_along: f64,
    /// ... and in pushes across it. In between the square of the cosine weighs; without a base the mean of the two holds.
    pub shortfall_across: f64,
    /// Where the robot stands, in the scene's frame.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub base: Option<[f64; 2]>,
    /// By how much it is above the height where the lift began, over the share of the shortfall that it has gone, from
    /// 0 to 1. Begins at 0 and never falls.
    pub rise: Table,
}

/// The lengths of one push, metres.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Stroke {
    /// From the commanded start to the commanded end.
    pub length: f64,
    /// From the start to where the arm begins to lift.
    pub lift: f64,
}

impl TipPath {
    /// A UR5e with a Robotiq 2F-85, sent to 10 mm above the table, its base in the origin: fitted to recorded pushes
    /// (docs/robot.md).
    pub fn ur5e() -> TipPath {
        TipPath {
            sink: Table::new(&[
                [0.0, 0.0271],
                [0.005, 0.0223],
                [0.01, 0.0206],
                [0.015, 0.0184],
                [0.02, 0.0169],
                [0.03, 0.0143],
                [0.04, 0.0133],
                [0.06, 0.0116],
                [0.08, 0.0105],
                [0.12, 0.0102],
            ]),
            shortfall_along: 0.0181,
            shortfall_across: 0.0276,
            base: Some([0.0, 0.0]),
            rise: Table::new(&[
                [0.0, 0.0],
                [0.1, 0.0014],
                [0.2, 0.0035],
                [0.3, 0.0057],
                [0.4, 0.0089],
                [0.5, 0.0128],
                [0.6, 0.0168],
                [0.7, 0.0228],
                [0.8, 0.0285],
                [0.9, 0.042],
                [1.0, 0.0626],
            ]),
        }
    }

    /// The lengths of a push.
    pub fn stroke(&self, start: Vec2, end: Vec2) -> Stroke {
        let length = (end - start).norm();
        Stroke { length, lift: (length - self.shortfall(start, end)).max(0.0) }
    }

    fn shortfall(&self, start: Vec2, end: Vec2) -> f64 {
        let arm = self.base.map(|base| (start + end) / 2.0 - vec2(base[0], base[1]));
        let size = arm.map_or(0.0, |arm| arm.norm() * (end - start).norm());
        let along = match arm {
            Some(arm) if size > 0.0 => (arm.dot(&(end - start)) / size).powi(2).min(1.0),
            _ => 0.5,
        };
        self.shortfall_across + (self.shortfall_along - self.shortfall_across) * along
    }

    /// The height of the tip's lower end after `way` of a push.
    pub fn height(&self, stroke: &Stroke, way: f64) -> f64 {
        let sunk = self.sink.at(way.min(stroke.lift));
        if way <= stroke.lift { sunk } else { sunk + self.rise.at(stroke.share(way)) }
    }

    /// By how much the height changes with the way there.
    pub fn slope(&self, stroke: &Stroke, way: f64) -> f64 {
        if way < stroke.lift {
            return self.sink.slope(way);
        }
        let shortfall = stroke.length - stroke.lift;
        if shortfall > 0.0 { self.rise.slope(stroke.share(way)) / shortfall } else { 0.0 }
    }

    /// The way from which on the tip passes over what is so high; 0 where it always does, infinite where it never does.
    pub fn over(&self, stroke: &Stroke, top: f64) -> f64 {
        let lowest = self.sink.at(stroke.lift);
        if lowest >= top {
            return 0.0;
        }
        match self.rise.reaches(top - lowest) {
            Some(share) => stroke.lift + share * (stroke.length - stroke.lift),
            None => f64::INFINITY,
        }
    }

    /// The same for a robot of another size.
    #[must_use]
    pub fn scaled(&self, factor: f64) -> TipPath {
        TipPath {
            sink: self.sink.scaled(factor, factor),
            shortfall_along: factor * self.shortfall_along,
            shortfall_across: factor * self.shortfall_across,
            base: self.base.map(|base| base.map(|v| factor * v)),
            rise: self.rise.scaled(1.0, factor),
        }
    }

    /// Checks every number; errors name the field.
    pub fn validate(&self) -> Result<()> {
        let wrong = |field: String, reason: &str| Err(Error::argument(field, reason));
        for (i, point) in self.sink.points.iter().enumerate() {
            bounds::TIP_HEIGHT.check(&format!("path.sink[{i}]"), point[1])?;
        }
        self.sink.validate("path.sink")?;
        if self.sink.points[0][0] < 0.0 {
            return wrong("path.sink[0]".into(), "begins before the start of the push; give ways from 0 on");
        }
        if let Some(i) = self.sink.points.windows(2).position(|w| w[1][1] > w[0][1]) {
            return wrong(format!("path.sink[{}]", i + 1), "is above the point before; the tip rises only by `rise`");
        }
        for (i, point) in self.rise.points.iter().enumerate() {
            bounds::TIP_HEIGHT.check(&format!("path.rise[{i}]"), point[1])?;
        }
        self.rise.validate("path.rise")?;
        if let Some(i) = self.rise.points.windows(2).position(|w| w[1][1] < w[0][1]) {
            return wrong(format!("path.rise[{}]", i + 1), "is below the point before; a lift never falls");
        }
        let ends = (self.rise.points[0], self.rise.end());
        if ends != ([0.0, 0.0], 1.0) {
            return wrong(
                "path.rise".into(),
                "does not go from [0, 0] to a share of 1; the shares of the shortfall are 0 to 1",
            );
        }
        bounds::SHORTFALL.check("path.shortfall_along", self.shortfall_along)?;
        bounds::SHORTFALL.check("path.shortfall_across", self.shortfall_across)?;
        self.base.map_or(Ok(()), |base| bounds::POSITION.check_all("path.base", base))
    }
}

impl Stroke {
    /// The share of the shortfall that is gone after `way`.
    fn share(&self, way: f64) -> f64 {
        ((way - self.lift) / (self.length - self.lift)).clamp(0.0, 1.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_tip_sinks_then_rises_and_ends_at_the_commanded_end() {
        let path = TipPath::ur5e();
        path.validate().unwrap();
        for length in [0.01, 0.03, 0.05, 0.1, 0.3] {
            let stroke = path.stroke(vec2(0.5, 0.0), vec2(0.5 + length, 0.0));
            assert!((stroke.lift - (length - 0.0181).max(0.0)).abs() < 1e-12, "{stroke:?}");
            let heights: Vec<f64> = (0..=100).map(|i| path.height(&stroke, length * f64::from(i) / 100.0)).collect();
            let lowest = heights.iter().copied().fold(f64::INFINITY, f64::min);
            assert_eq!(lowest.max(path.sink.at(stroke.lift)), lowest);
            assert!(heights[100] - path.sink.at(stroke.lift) > 0.06, "{heights:?}");
            let fallen = heights.iter().position(|h| *h == lowest).unwrap();
            assert!(heights[..=fallen].is_sorted_by(|a, b| a >= b) && heights[fallen..].is_sorted());
            // The slope is what the height changes by.
            for way in [0.12 * length, 0.55 * length, 0.93 * length] {
                let change = (path.height(&stroke, way + 1e-7) - path.height(&stroke, way)) / 1e-7;
                assert!((change - path.slope(&stroke, way)).abs() < 1e-3, "{length} {way} {change}");
            }
        }
    }

    #[test]
    fn shortfall_follows_the_direction_to_the_base() {
        let path = TipPath::ur5e();
        let short = |from: Vec2, to: Vec2| {
            let stroke = path.stroke(from, to);
            stroke.length - stroke.lift
        };
        for (from, to, wanted) in [
            (vec2(0.4, 0.0), vec2(0.5, 0.0), 0.0181),
            (vec2(0.5, 0.0), vec2(0.4, 0.0), 0.0181),
            (vec2(0.5, -0.05), vec2(0.5, 0.05), 0.0276),
            (vec2(0.45, -0.05), vec2(0.55, 0.05), 0.02285),
        ] {
            assert!((short(from, to) - wanted).abs() < 1e-12, "{from:?} {to:?}: {}", short(from, to));
        }
        let anywhere = TipPath { base: None, ..TipPath::ur5e() };
        let stroke = anywhere.stroke(vec2(0.4, 0.0), vec2(0.5, 0.0));
        assert!((stroke.length - stroke.lift - 0.02285).abs() < 1e-12);
        // A push whose middle is the base itself has no direction to it.
        assert!((short(vec2(-0.05, 0.0), vec2(0.05, 0.0)) - 0.02285).abs() < 1e-12);
    }

    #[test]
    fn the_tip_passes_over_a_body_once_it_is_above_its_top() {
        let path = TipPath::ur5e();
        let stroke = path.stroke(vec2(0.5, 0.0), vec2(0.6, 0.0));
        assert_eq!(path.over(&stroke, 0.005), 0.0, "lower than the tip ever is");
        assert_eq!(path.over(&stroke, 0.3), f64::INFINITY);
        let ways = [0.012, 0.023, 0.045, 0.07].map(|top| (top, path.over(&stroke, top)));
        assert!(ways.is_sorted_by(|a, b| a.1 < b.1), "{ways:?}");
        for (top, way) in ways {
            assert!(way > stroke.lift && way < stroke.length, "{top}: {way}");
            assert!((path.height(&stroke, way) - top).abs() < 1e-12, "{top}: {way}");
        }
    }

    #[test]
    fn a_robot_of_another_size_goes_the_same_way() {
        let path = TipPath::ur5e();
        for factor in [0.1, 0.5, 3.0] {
            let large = path.scaled(factor);
            let (a, b) = (vec2(0.5, 0.02), vec2(0.57, -0.04));
            let (stroke, grown) = (path.stroke(a, b), large.stroke(factor * a, factor * b));
            assert!((grown.lift - factor * stroke.lift).abs() < 1e-12);
            for share in [0.1, 0.5, 0.8, 0.95] {
                let here = path.height(&stroke, share * stroke.length);
                assert!((large.height(&grown, share * grown.length) - factor * here).abs() < 1e-12);
            }
        }
    }

    #[test]
    fn a_bad_path_is_named() {
        let spoilt = |spoil: fn(&mut TipPath)| {
            let mut path = TipPath::ur5e();
            spoil(&mut path);
            path.validate().unwrap_err().to_string()
        };
        for (error, wanted) in [
            (spoilt(|p| p.sink.points.clear()), "path.sink: has 0 points"),
            (spoilt(|p| p.sink.points[3][1] = 0.03), "path.sink[3]: is above the point before"),
            (spoilt(|p| p.sink.points[9][1] = -0.01), "path.sink[9]: is -0.01"),
            (spoilt(|p| p.rise.points[4][1] = 0.0), "path.rise[4]: is below the point before"),
            (spoilt(|p| p.rise.points[0][1] = 0.001), "path.rise: does not go from [0, 0]"),
            (spoilt(|p| p.rise.points.truncate(10)), "path.rise: does not go from [0, 0]"),
            (spoilt(|p| p.sink.points[0][0] = -0.1), "path.sink[0]: begins before"),
            (spoilt(|p| p.shortfall_along = f64::NAN), "path.shortfall_along: is NaN"),
            (spoilt(|p| p.base = Some([1e9, 0.0])), "path.base"),
        ] {
            assert!(error.contains(wanted), "{error} | {wanted}");
        }
    }
}
