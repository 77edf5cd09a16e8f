//! The chance that a gripper keeps what it grasps, fitted to recorded grasps.
//!
//! A penalised logistic regression: the values of all tables at once by Newton's method. The penalty draws neighbouring
//! points of a table together, and all values a little towards 0, so that a table is level where nothing was recorded.

use nalgebra::{DMatrix, DVector};

use crate::error::{Error, Result};
use crate::scene::{GraspFeatures, Keeping, Table};

/// Weight of the squared difference of neighbouring points.
const SMOOTHNESS: f64 = 1.0;
/// Weight of the squared values.
const RIDGE: f64 = 0.05;
/// Weight of the squared difference of neighbours against the trend of their table.
const FORBIDDEN: f64 = 1e4;
const MAX_STEPS: usize = 100;
/// The fit has converged when no value moves by more.
const SETTLED: f64 = 1e-8;
/// Fewer grasps say nothing.
const LEAST_GRASPS: usize = 50;
/// Fitted values are given in steps of one over this: a page of numbers to be read.
const STEPS: f64 = 1e3;

/// A table to be fitted.
struct Term {
    table: fn(&mut Keeping) -> &mut Table,
    x: fn(&Keeping, &GraspFeatures) -> f64,
    trend: Trend,
}

/// What is known of a table beforehand.
#[derive(Clone, Copy, PartialEq)]
enum Trend {
    Free,
    /// The values must not fall,
    Rises,
    /// or not rise.
    Falls,
}

impl Trend {
    /// A step from one point to the next is against it.
    fn forbids(self, step: f64) -> bool {
        match self {
            Trend::Free => false,
            Trend::Rises => step < 0.0,
            Trend::Falls => step > 0.0,
        }
    }
}

/// More face on the pads, more of the body past them, more room, depth and mass are never worse, and more turn never better:
/// a planner takes the best grasp of thousands, and would find the places where chance made a table say otherwise.
const TERMS: [Term; 7] = [
    Term { table: |k| &mut k.width, x: |_, f| f.width, trend: Trend::Free },
    Term { table: |k| &mut k.touch, x: |_, f| f.touch, trend: Trend::Rises },
    Term { table: |k| &mut k.turn, x: |_, f| f.turn, trend: Trend::Falls },
    Term { table: |k| &mut k.end, x: |_, f| f.end, trend: Trend::Rises },
    Term { table: |k| &mut k.clearance, x: |_, f| f.clearance, trend: Trend::Rises },
    Term { table: |k| &mut k.depth, x: |k, f| k.depth(f.width, f.height), trend: Trend::Rises },
    Term { table: |k| &mut k.mass, x: |_, f| f.mass, trend: Trend::Rises },
];

/// Fits bias and tables to grasps that went well or not. `base` gives the points' x, and `descent` and `pads` as they
/// are. The same grasps in the same order give the same bits.
pub fn fit_keeping(base: &Keeping, grasps: &[(GraspFeatures, bool)]) -> Result<Keeping> {
    base.validate()?;
    let well = grasps.iter().filter(|(_, well)| *well).count();
    if grasps.len() < LEAST_GRASPS || well == 0 || well == grasps.len() {
        let reason = format!(
            "{well} of {} went well; a fit takes at least {LEAST_GRASPS}, and some of either outcome",
            grasps.len()
        );
        return Err(Error::argument("grasps", reason));
    }
    let mut fitted = base.clone();
    let counts = TERMS.map(|term| (term.table)(&mut fitted).points.len());
    let rows: Vec<Row> = grasps.iter().map(|(features, well)| Row::new(base, features, *well, &counts)).collect();
    let mut values = DVector::zeros(1 + counts.iter().sum::<usize>());
    for _ in 0..MAX_STEPS {
        let next = newton(&rows, &values, &counts)?;
        let moved = (&next - &values).amax();
        values = next;
        if moved < SETTLED {
            break;
        }
    }
    fitted.bias = rounded(values[0]);
    let mut first = 1;
    for (term, count) in TERMS.iter().zip(counts) {
        let mut last: Option<f64> = None;
        for (point, value) in (term.table)(&mut fitted).points.iter_mut().zip(values.iter().skip(first)) {
            let value = rounded(*value);
            // The penalty leaves a hair of what is forbidden.
            point[1] = last.filter(|last| term.trend.forbids(value - last)).unwrap_or(value);
            last = Some(point[1]);
        }
        first += count;
    }
    fitted.validate()?;
    Ok(fitted)
}

fn rounded(value: f64) -> f64 {
    (value * STEPS).round() / STEPS
}

/// One grasp: the values that make up its log odds, with their weights.
struct Row {
    weights: Vec<(usize, f64)>,
    well: f64,
}

impl Row {
    fn new(base: &Keeping, features: &GraspFeatures, well: bool, counts: &[usize; 7]) -> Row {
        let mut base = base.clone();
        let mut weights = vec![(0, 1.0)];
        let mut first = 1;
        for (term, count) in TERMS.iter().zip(counts) {
            let x = (term.x)(&base, features);
            let (below, share) = (term.table)(&mut base).place(x);
            weights.push((first + below, 1.0 - share));
            if share > 0.0 {
                weights.push((first + below + 1, share));
            }
            first += count;
        }
        Row { weights, well: f64::from(u8::from(well)) }
    }
}

/// The values after a step of Newton's method for the penalised likelihood.
fn newton(rows: &[Row], values: &DVector<f64>, counts: &[usize; 7]) -> Result<DVector<f64>> {
    let mut curvature = penalty(values, counts);
    let mut slope = DVector::zeros(values.len());
    for row in rows {
        let log_odds: f64 = row.weights.iter().map(|(i, weight)| weight * values[*i]).sum();
        let chance = 1.0 / (1.0 + (-log_odds).exp());
        let spread = (chance * (1.0 - chance)).max(1e-6);
        for &(i, a) in &row.weights {
            slope[i] += a * (spread * log_odds + row.well - chance);
            for &(j, b) in &row.weights {
                curvature[(i, j)] += spread * a * b;
            }
        }
    }
    let solved = curvature.cholesky().map(|factors| factors.solve(&slope));
    solved.ok_or_else(|| Error::Internal("the fit's normal equations have no solution".into()))
}

fn penalty(values: &DVector<f64>, counts: &[usize; 7]) -> DMatrix<f64> {
    let mut penalty = DMatrix::zeros(values.len(), values.len());
    let mut first = 1;
    for (term, count) in TERMS.iter().zip(counts) {
        for i in first..first + count {
            penalty[(i, i)] += RIDGE;
        }
        for i in first..first + count - 1 {
            let forbidden = term.trend.forbids(values[i + 1] - values[i]);
            let weight = if forbidden { FORBIDDEN } else { SMOOTHNESS };
            penalty[(i, i)] += weight;
            penalty[(i + 1, i + 1)] += weight;
            penalty[(i, i + 1)] -= weight;
            penalty[(i + 1, i)] -= weight;
        }
        first += count;
    }
    penalty
}
