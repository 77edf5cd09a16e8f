//! What a gripper keeps of what it grasps: the chance that the body is still between the pads when the arm has carried
//! it away, as a function of a few measures of the grasp.
//!
//! The form is additive: each measure looks up its share of the log odds in a table, straight between its points and
//! level beyond them. So a model is a page of numbers that can be read, drawn and given in a file.

use serde::{Deserialize, Serialize};

use super::table::{MAX_VALUE, Table};
use crate::bounds;
use crate::error::{Error, Result, check_range};

/// What a grasp is known by, in the frame of the jaw: x along the closing direction, y along the pads. Metres, radians,
/// kilograms.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct GraspFeatures {
    /// Extent of the target along x within the breadth of the pads.
    pub width: f64,
    /// Extent along y, within the breadth of the pads, of what lies within 2 mm (for the published gripper) of the target's
    /// outermost point: the lesser of both sides. Little for a corner or an end, the pad's breadth for a face.
    pub touch: f64,
    /// The least turn that lays a face flat on its pad.
    pub turn: f64,
    /// How far the target reaches beyond the pads' middle along y, the lesser of both ways; negative where the middle is
    /// beyond its end.
    pub end: f64,
    /// Least gap of the open fingers to the target and to the other bodies; negative where they come down on one.
    pub clearance: f64,
    /// Of the target's top above the table.
    pub height: f64,
    /// Of the target.
    pub mass: f64,
}

/// The chance that a gripper keeps what it grasps, as log odds: `bias` and what the tables say of the features. The
/// tables' x are metres, radians and kilograms; their values log odds, but for `pads`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Keeping {
    /// How far below the top of a body the gripper is sent, metres: never below the table.
    pub descent: f64,
    /// How far above the place where the gripper is sent the pads end when they have closed to a width: metres over
    /// metres. (Fingers on linkages swing down as they close.)
    pub pads: Table,
    pub bias: f64,
    pub width: Table,
    pub touch: Table,
    pub turn: Table,
    pub end: Table,
    /// Never falls: more room is never worse.
    pub clearance: Table,
    /// Of how far the closed pads reach down the target, by `descent`, `pads`, width and height.
    pub depth: Table,
    pub mass: Table,
}

impl Keeping {
    /// The Robotiq 2F-85 on a UR5e, 240 Hz simulation: fitted to recorded grasps with `jostle fit grasp` (docs/grasp-score.md
    /// has its quality on grasps that it was not fitted to).
    pub fn robotiq_2f85() -> Keeping {
        Keeping {
            descent: 0.04,
            pads: Table::new(&[
                [0.01, 0.0138],
                [0.02, 0.015],
                [0.03, 0.0156],
                [0.04, 0.0172],
                [0.05, 0.019],
                [0.06, 0.0206],
                [0.07, 0.0239],
                [0.08, 0.028],
            ]),
            bias: -5.144,
            width: Table::new(&[
                [0.008, -1.229],
                [0.016, -0.778],
                [0.022, -1.093],
                [0.028, -1.054],
                [0.034, -0.176],
                [0.042, 0.602],
                [0.052, 0.645],
                [0.064, 1.09],
                [0.076, 1.604],
                [0.082, 0.388],
            ]),
            touch: Table::new(&[
                [0.0, -2.778],
                [0.001, -2.778],
                [0.002, -0.688],
                [0.004, 0.82],
                [0.008, 1.809],
                [0.014, 1.809],
                [0.022, 1.809],
            ]),
            turn: Table::new(&[[0.0, 0.624], [0.1, 0.624], [0.2, 0.096], [0.4, -0.181], [0.6, -0.181], [0.8, -0.983]]),
            end: Table::new(&[
                [-0.01, -1.004],
                [-0.005, -0.555],
                [0.0, -0.555],
                [0.005, 0.011],
                [0.011, 0.95],
                [0.022, 1.154],
            ]),
            clearance: Table::new(&[
                [-0.004, -1.404],
                [-0.001, -0.225],
                [0.0, -0.076],
                [0.001, -0.076],
                [0.002, 0.484],
                [0.004, 0.484],
                [0.008, 0.814],
            ]),
            depth: Table::new(&[
                [-0.006, -3.116],
                [0.0, -2.855],
                [0.005, -0.948],
                [0.01, 1.115],
                [0.02, 2.717],
                [0.026, 3.087],
            ]),
            mass: Table::new(&[[0.03, -2.927], [0.045, -0.665], [0.06, 0.715], [0.1, 1.258], [0.2, 1.619]]),
        }
    }

    /// How far down the target the pads reach when they have closed on it, metres; negative: they close above it.
    pub fn depth(&self, width: f64, height: f64) -> f64 {
        height.min(self.descent) - self.pads.at(width)
    }

    /// Log odds of keeping, but for the share of the clearance.
    pub fn without_clearance(&self, f: &GraspFeatures) -> f64 {
        self.bias
            + self.width.at(f.width)
            + self.touch.at(f.touch)
            + self.turn.at(f.turn)
            + self.end.at(f.end)
            + self.depth.at(self.depth(f.width, f.height))
            + self.mass.at(f.mass)
    }

    /// The chance for log odds without the clearance's share, and a clearance.
    pub fn with_clearance(&self, log_odds: f64, clearance: f64) -> f64 {
        1.0 / (1.0 + (-(log_odds + self.clearance.at(clearance))).exp())
    }

    /// The chance that the target is kept, in (0, 1).
    pub fn chance(&self, features: &GraspFeatures) -> f64 {
        self.with_clearance(self.without_clearance(features), features.clearance)
    }

    /// The same for a gripper and bodies of another size: lengths times `factor`, masses times its cube.
    #[must_use]
    pub fn scaled(&self, factor: f64) -> Keeping {
        let length = |table: &Table| table.scaled(factor, 1.0);
        Keeping {
            descent: factor * self.descent,
            pads: self.pads.scaled(factor, factor),
            bias: self.bias,
            width: length(&self.width),
            touch: length(&self.touch),
            turn: self.turn.clone(),
            end: length(&self.end),
            clearance: length(&self.clearance),
            depth: length(&self.depth),
            mass: self.mass.scaled(factor * factor * factor, 1.0),
        }
    }

    /// Checks every number; errors name the field.
    pub fn validate(&self) -> Result<()> {
        bounds::FINGER.check("keeping.descent", self.descent)?;
        check_range("keeping.bias", self.bias, -MAX_VALUE..=MAX_VALUE)?;
        for (name, table) in [
            ("pads", &self.pads),
            ("width", &self.width),
            ("touch", &self.touch),
            ("turn", &self.turn),
            ("end", &self.end),
            ("clearance", &self.clearance),
            ("depth", &self.depth),
            ("mass", &self.mass),
        ] {
            table.validate(&format!("keeping.{name}"))?;
        }
        // The search takes the grasp with all the room in the world for the best that a place can offer.
        match self.clearance.points.windows(2).position(|w| w[1][1] < w[0][1]) {
            Some(i) => {
                let field = format!("keeping.clearance[{}]", i + 1);
                Err(Error::argument(field, "is worse than with less room; give values that never fall"))
            }
            None => Ok(()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_bad_table_is_named() {
        let good = Keeping::robotiq_2f85();
        good.validate().unwrap();
        let spoilt = |spoil: fn(&mut Keeping)| {
            let mut keeping = good.clone();
            spoil(&mut keeping);
            keeping.validate().unwrap_err().to_string()
        };
        for (error, wanted) in [
            (spoilt(|k| k.width.points.clear()), "keeping.width: has 0 points"),
            (spoilt(|k| k.mass.points[1][0] = f64::NAN), "keeping.mass[1]: is NaN"),
            (spoilt(|k| k.depth.points[2][1] = 51.0), "keeping.depth[2]: is 51"),
            (spoilt(|k| k.touch.points[3][0] = 0.0), "keeping.touch[3]: is not above the point before"),
            (spoilt(|k| k.clearance.points[1][1] = -40.0), "keeping.clearance[1]: is worse than with less room"),
            (spoilt(|k| k.descent = -1.0), "keeping.descent: is -1"),
            (spoilt(|k| k.bias = 1e9), "keeping.bias: is 1000000000"),
        ] {
            assert!(error.contains(wanted), "{error}");
        }
    }

    #[test]
    fn the_chance_of_the_2f85_is_that_of_the_eye() {
        let keeping = Keeping::robotiq_2f85();
        // A cube of 45 mm, square between the pads.
        let good = GraspFeatures {
            width: 0.045,
            touch: 0.022,
            turn: 0.0,
            end: 0.0225,
            clearance: 0.0178,
            height: 0.045,
            mass: 0.1,
        };
        assert!(keeping.chance(&good) > 0.9, "{}", keeping.chance(&good));
        type Change<'a> = &'a dyn Fn(&mut GraspFeatures, f64);
        let chance = |change: Change, x: f64| {
            let mut features = good;
            change(&mut features, x);
            keeping.chance(&features)
        };
        // What is never worse for being more: the gap of the fingers, the body's height and mass, how far it reaches past, the
        // face on the pads; and for being less: the turn.
        let changes: [(Change, f64, f64); 6] = [
            (&|f, x| f.clearance = x, -0.006, 0.02),
            (&|f, x| f.height = x, 0.02, 0.08),
            (&|f, x| f.mass = x, 0.02, 0.3),
            (&|f, x| f.end = x, -0.02, 0.04),
            (&|f, x| f.touch = x, 0.0, 0.025),
            (&|f, x| f.turn = -x, -1.0, 0.0),
        ];
        for (k, (change, from, to)) in changes.into_iter().enumerate() {
            let values: Vec<f64> = (0..=50).map(|i| chance(change, from + (to - from) * i as f64 / 50.0)).collect();
            assert!(values.windows(2).all(|w| w[1] >= w[0]), "{k}: {values:?}");
            assert!(values[50] > values[0] + 0.02, "{k}: {values:?}");
        }
        assert!(chance(&|f, x| (f.touch, f.turn) = (x, 0.785), 0.0005) < 0.5, "a corner");
        assert!(chance(&|f, x| f.height = x, 0.0235) < keeping.chance(&good) - 0.3, "a flat body");
        let half_cube = keeping.chance(&GraspFeatures { width: 0.0225, clearance: 0.029, ..good });
        assert!(half_cube < keeping.chance(&good), "{half_cube}");
    }

    #[test]
    fn larger_grippers_keep_larger_bodies_alike() {
        let keeping = Keeping::robotiq_2f85();
        let at = |s: f64| GraspFeatures {
            width: 0.03 * s,
            touch: 0.01 * s,
            turn: 0.3,
            end: 0.004 * s,
            clearance: 0.0015 * s,
            height: 0.035 * s,
            mass: 0.07 * s * s * s,
        };
        for factor in [0.1, 3.0] {
            let scaled = keeping.scaled(factor).chance(&at(factor));
            assert!((scaled - keeping.chance(&at(1.0))).abs() < 1e-9, "{factor}");
        }
    }
}
