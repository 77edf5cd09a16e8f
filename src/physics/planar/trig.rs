//! Sine and cosine whose bits do not depend on the system's mathematical library.

/// Sine and cosine of an angle of at most some thousand radians, to about one unit in the last place.
///
/// Reduction by quarter turns (Cody and Waite 1980) and the polynomials of Cephes (Moshier 1989), without fused
/// operations.
#[inline(always)]
#[allow(clippy::excessive_precision)]
pub fn sin_cos(angle: f32) -> (f32, f32) {
    let quarters = angle * std::f32::consts::FRAC_2_PI;
    let k = (quarters + if quarters < 0.0 { -0.5 } else { 0.5 }) as i32;
    let q = k as f32;
    // Half pi in three parts, the first of few digits so that its products are exact.
    let r = ((angle - q * 1.570_312_5) - q * 4.837_512_969_970_703e-4) - q * 7.549_789_948_768_648e-8;
    let r2 = r * r;
    let sin = r + r * r2 * (-1.666_665_461_1e-1 + r2 * (8.332_160_873_6e-3 + r2 * -1.951_529_589_1e-4));
    let cos = 1.0 - 0.5 * r2
        + r2 * r2 * (4.166_664_568_298_827e-2 + r2 * (-1.388_731_625_493_765e-3 + r2 * 2.443_315_711_809_948e-5));
    match k & 3 {
        0 => (sin, cos),
        1 => (cos, -sin),
        2 => (-sin, -cos),
        _ => (-cos, sin),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sine_and_cosine_are_right_to_the_last_places() {
        let mut worst = 0.0f64;
        for i in -20_000..20_000 {
            let angle = i as f32 * 7.3e-4;
            let (sin, cos) = sin_cos(angle);
            let (s, c) = f64::from(angle).sin_cos();
            worst = worst.max((f64::from(sin) - s).abs()).max((f64::from(cos) - c).abs());
        }
        assert!(worst < 1.5e-7, "{worst}");
        assert_eq!(sin_cos(0.0), (0.0, 1.0));
    }
}
