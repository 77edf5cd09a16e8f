//! What a score says of recorded grasps.

use serde::{Deserialize, Serialize};

use crate::error::{Error, Result};

/// Bands of the score, all as wide.
pub const BANDS: usize = 10;
/// No score counts as more certain than this: one grasp that went otherwise must not decide the log-loss alone.
const CERTAIN: f64 = 1e-6;

/// Grasps whose score lies in a band.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct ReliabilityBand {
    /// Scores from here to below `to`; the last band has 1 too.
    pub from: f64,
    pub to: f64,
    pub count: usize,
    /// Of them went well.
    pub held: usize,
    /// `held / count`; 0 of none.
    pub share: f64,
    /// Mean score; 0 of none.
    pub mean_score: f64,
}

/// How a score agrees with what happened.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct GraspReliability {
    pub count: usize,
    /// Grasps that went well.
    pub held: usize,
    /// Share of the grasps that went well where the score says so, from `threshold` on, or badly where it does not.
    pub accuracy: f64,
    pub threshold: f64,
    /// Mean of `-ln` of the chance that the score gave to what happened, natural; scores beyond 1e-6 of 0 or 1 count as
    /// that.
    pub log_loss: f64,
    /// Area under the curve of true against false positives: the share of pairs, one well and one badly, that the score
    /// puts in order; pairs of equals count half. Absent where all went one way.
    pub auc: Option<f64>,
    pub bands: Vec<ReliabilityBand>,
}

/// Holds scores in [0, 1] against what happened. Errors name `scores`.
pub fn grasp_reliability(scores: &[(f64, bool)], threshold: f64) -> Result<GraspReliability> {
    if let Some((score, _)) = scores.iter().find(|(score, _)| !(0.0..=1.0).contains(score)) {
        return Err(Error::argument("scores", format!("one is {score}; all must lie in 0 to 1")));
    }
    let count = scores.len();
    let share = |part: usize| if count == 0 { 0.0 } else { part as f64 / count as f64 };
    let loss = |&(score, well): &(f64, bool)| {
        let score = score.clamp(CERTAIN, 1.0 - CERTAIN);
        -(if well { score } else { 1.0 - score }).ln()
    };
    Ok(GraspReliability {
        count,
        held: scores.iter().filter(|(_, well)| *well).count(),
        accuracy: share(scores.iter().filter(|(score, well)| (*score >= threshold) == *well).count()),
        threshold,
        log_loss: scores.iter().map(loss).sum::<f64>() / count.max(1) as f64,
        auc: area_under_the_curve(scores),
        bands: bands(scores),
    })
}

fn bands(scores: &[(f64, bool)]) -> Vec<ReliabilityBand> {
    let edge = |k: usize| k as f64 / BANDS as f64;
    let mut bands: Vec<ReliabilityBand> =
        (0..BANDS).map(|k| ReliabilityBand { from: edge(k), to: edge(k + 1), ..Default::default() }).collect();
    for &(score, well) in scores {
        let band = bands.iter().rposition(|band| score >= band.from).unwrap_or(0);
        let band = &mut bands[band];
        band.count += 1;
        band.held += usize::from(well);
        band.mean_score += score;
    }
    for band in bands.iter_mut().filter(|band| band.count > 0) {
        band.share = band.held as f64 / band.count as f64;
        band.mean_score /= band.count as f64;
    }
    bands
}

/// By ranks, equals sharing the middle of theirs.
fn area_under_the_curve(scores: &[(f64, bool)]) -> Option<f64> {
    let mut sorted = scores.to_vec();
    sorted.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut ranks_of_well = 0.0;
    let mut first = 0;
    for equals in sorted.chunk_by(|a, b| a.0 == b.0) {
        let middle = first as f64 + (equals.len() + 1) as f64 / 2.0;
        ranks_of_well += middle * equals.iter().filter(|(_, well)| *well).count() as f64;
        first += equals.len();
    }
    let well = sorted.iter().filter(|(_, well)| *well).count() as f64;
    let badly = sorted.len() as f64 - well;
    (well > 0.0 && badly > 0.0).then(|| (ranks_of_well - well * (well + 1.0) / 2.0) / (well * badly))
}
