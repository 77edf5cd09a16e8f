//! Means and percentiles of small samples.

/// The arithmetic mean; 0 of nothing.
pub fn mean(values: &[f64]) -> f64 {
    if values.is_empty() { 0.0 } else { values.iter().sum::<f64>() / values.len() as f64 }
}

/// The value below which a fraction `p` of the sample lies, interpolated linearly between neighbours (type 7 of
/// Hyndman and Fan, the usual default); 0 of nothing.
pub fn percentile(values: &[f64], p: f64) -> f64 {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    let Some(last) = sorted.len().checked_sub(1) else { return 0.0 };
    let place = p.clamp(0.0, 1.0) * last as f64;
    let below = place.floor() as usize;
    let above = (below + 1).min(last);
    sorted[below] + (sorted[above] - sorted[below]) * (place - below as f64)
}

/// The middle value; 0 of nothing.
pub fn median(values: &[f64]) -> f64 {
    percentile(values, 0.5)
}

/// The greatest value; 0 of nothing.
pub fn max(values: &[f64]) -> f64 {
    values.iter().copied().reduce(f64::max).unwrap_or(0.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn by_hand() {
        let v = [4.0, 1.0, 3.0, 2.0];
        assert_eq!((mean(&v), median(&v), max(&v)), (2.5, 2.5, 4.0));
        assert_eq!((percentile(&v, 0.0), percentile(&v, 1.0)), (1.0, 4.0));
        assert!((percentile(&v, 0.9) - 3.7).abs() < 1e-12);
        assert_eq!(percentile(&[7.0], 0.99), 7.0);
        assert_eq!((mean(&[]), median(&[]), max(&[])), (0.0, 0.0, 0.0));
        assert_eq!(max(&[-2.0, -3.0]), -2.0);
    }
}
