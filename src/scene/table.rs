//! A function of one number, given by its points.

use serde::{Deserialize, Serialize};

use crate::error::{Error, Result, check_range};

/// Most points of a table.
const MAX_POINTS: usize = 64;
/// No value is farther from 0 than this: log odds or metres.
pub(super) const MAX_VALUE: f64 = 50.0;

/// A function of one number, by its points `[x, value]`: straight between them, level beyond.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(transparent)]
pub struct Table {
    pub points: Vec<[f64; 2]>,
}

impl Table {
    /// Points with rising x.
    pub fn new(points: &[[f64; 2]]) -> Table {
        Table { points: points.to_vec() }
    }

    /// The value at `x`.
    pub fn at(&self, x: f64) -> f64 {
        let (below, share) = self.place(x);
        match (self.points.get(below), self.points.get(below + 1)) {
            (Some(a), Some(b)) => a[1] + (b[1] - a[1]) * share,
            (Some(end), None) => end[1],
            (None, _) => 0.0,
        }
    }

    /// Where `x` lies: the index of a point, and the share of the way from there to the next, in [0, 1).
    pub fn place(&self, x: f64) -> (usize, f64) {
        let points = &self.points;
        let above = points.partition_point(|p| p[0] <= x);
        match (above.checked_sub(1), points.get(above)) {
            (Some(below), Some(b)) => (below, (x - points[below][0]) / (b[0] - points[below][0])),
            (Some(end), None) => (end, 0.0),
            (None, _) => (0, 0.0),
        }
    }

    /// By how much the value changes with x there; 0 beyond the ends.
    pub fn slope(&self, x: f64) -> f64 {
        let points = &self.points;
        let above = points.partition_point(|p| p[0] <= x);
        match (above.checked_sub(1), points.get(above)) {
            (Some(below), Some(b)) => (b[1] - points[below][1]) / (b[0] - points[below][0]),
            _ => 0.0,
        }
    }

    /// The first x where the value is `value` or more. None if it never is. For tables that never fall.
    pub fn reaches(&self, value: f64) -> Option<f64> {
        let points = &self.points;
        let above = points.partition_point(|p| p[1] < value);
        let b = points.get(above)?;
        Some(match above.checked_sub(1) {
            Some(below) => {
                let a = points[below];
                a[0] + (b[0] - a[0]) * (value - a[1]) / (b[1] - a[1])
            }
            None => b[0],
        })
    }

    /// The last x: beyond it the value does not change.
    pub fn end(&self) -> f64 {
        self.points.last().map_or(0.0, |p| p[0])
    }

    /// The same with x and values multiplied.
    #[must_use]
    pub(super) fn scaled(&self, x: f64, value: f64) -> Table {
        Table { points: self.points.iter().map(|p| [x * p[0], value * p[1]]).collect() }
    }

    pub(super) fn validate(&self, field: &str) -> Result<()> {
        if !(1..=MAX_POINTS).contains(&self.points.len()) {
            let reason = format!("has {} points; it must have 1 to {MAX_POINTS}", self.points.len());
            return Err(Error::argument(field, reason));
        }
        for (i, point) in self.points.iter().enumerate() {
            let field = format!("{field}[{i}]");
            check_range(&field, point[0], -1e3..=1e3)?;
            check_range(&field, point[1], -MAX_VALUE..=MAX_VALUE)?;
        }
        match self.points.windows(2).position(|w| w[1][0] <= w[0][0]) {
            Some(i) => {
                let reason = format!("is not above the point before, {}; x must rise", self.points[i][0]);
                Err(Error::argument(format!("{field}[{}]", i + 1), reason))
            }
            None => Ok(()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_table_is_straight_between_its_points_and_level_beyond() {
        let table = Table::new(&[[0.0, 1.0], [1.0, 3.0], [4.0, 0.0]]);
        for (x, value) in [(-5.0, 1.0), (0.0, 1.0), (0.25, 1.5), (1.0, 3.0), (3.0, 1.0), (4.0, 0.0), (9.0, 0.0)] {
            assert!((table.at(x) - value).abs() < 1e-12, "{x}: {}", table.at(x));
        }
        assert_eq!((Table::new(&[[2.0, 7.0]]).at(-1.0), Table::new(&[[2.0, 7.0]]).at(5.0)), (7.0, 7.0));
    }

    #[test]
    fn a_table_that_never_falls_can_be_read_backwards() {
        let table = Table::new(&[[0.0, 0.0], [0.5, 0.0], [1.0, 4.0], [2.0, 4.0], [3.0, 5.0]]);
        for (value, x) in [(-1.0, 0.0), (0.0, 0.0), (2.0, 0.75), (4.0, 1.0), (4.5, 2.5), (5.0, 3.0)] {
            assert_eq!(table.reaches(value), Some(x), "{value}");
        }
        assert_eq!(table.reaches(5.1), None);
        for (x, slope) in [(-1.0, 0.0), (0.2, 0.0), (0.7, 8.0), (1.5, 0.0), (2.5, 1.0), (3.5, 0.0)] {
            assert_eq!(table.slope(x), slope, "{x}");
        }
    }
}
