//! Whether two footprints are apart: a quick yes or no, without memory of its own.

use super::footprint::{Footprint, Piece};
use super::polygon::edges;
use super::pose::{Frame, Vec2, vec2};

/// Whether some straight line keeps every pair of pieces at least `gap` apart; metres, the bodies given by their frames.
///
/// "Yes" is certain. For `gap <= 0` "no" is as well: the footprints overlap by more than `-gap`. For a positive gap two
/// polygons that are nearest corner to corner may be a little farther apart than a "no" says.
pub fn footprints_apart(a: &Footprint, at_a: &Frame, b: &Footprint, at_b: &Frame, gap: f64) -> bool {
    let away = at_b.origin - at_a.origin;
    let reach = a.radius + b.radius + gap.max(0.0);
    if away.norm_squared() >= reach * reach {
        return true;
    }
    // Where `b` is in the frame of `a`.
    let b_in_a = Frame {
        origin: at_a.inverse_vector(away),
        sin: at_b.sin * at_a.cos - at_b.cos * at_a.sin,
        cos: at_b.cos * at_a.cos + at_b.sin * at_a.sin,
    };
    a.pieces.iter().all(|p| b.pieces.iter().all(|q| pieces_apart(p, q, &b_in_a, gap)))
}

fn pieces_apart(a: &Piece, b: &Piece, b_in_a: &Frame, gap: f64) -> bool {
    match (a, b) {
        (Piece::Disc { centre: p, radius: r }, Piece::Disc { centre: q, radius: s }) => {
            let least = (r + s + gap).max(0.0);
            (b_in_a.point(*q) - p).norm_squared() >= least * least
        }
        (Piece::Convex(points), Piece::Disc { centre, radius }) => {
            disc_apart(points, b_in_a.point(*centre), radius + gap)
        }
        (Piece::Disc { centre, radius }, Piece::Convex(points)) => {
            disc_apart(points, b_in_a.inverse_point(*centre), radius + gap)
        }
        (Piece::Convex(p), Piece::Convex(q)) => {
            // The edges of `a` against the corners of `b`, and the other way round.
            let of_a = edges(p).any(|(from, to)| {
                let n = outward(from, to);
                least(q, b_in_a.inverse_vector(n)) + n.dot(&b_in_a.origin) - n.dot(&from) >= gap
            });
            of_a || edges(q).any(|(from, to)| {
                let n = outward(from, to);
                let turned = b_in_a.vector(n);
                least(p, turned) - turned.dot(&b_in_a.origin) - n.dot(&from) >= gap
            })
        }
    }
}

#[inline]
fn outward(from: Vec2, to: Vec2) -> Vec2 {
    let d = to - from;
    vec2(d.y, -d.x) / d.norm()
}

#[inline]
fn least(points: &[Vec2], direction: Vec2) -> f64 {
    points.iter().map(|p| p.dot(&direction)).fold(f64::INFINITY, f64::min)
}

/// Whether a disc's centre is `distance` or more from a polygon; negative distances reach into it.
fn disc_apart(points: &[Vec2], centre: Vec2, distance: f64) -> bool {
    let mut deepest = f64::NEG_INFINITY;
    let mut nearest = f64::INFINITY;
    for (from, to) in edges(points) {
        let (along, to_centre) = (to - from, centre - from);
        deepest = deepest.max(outward(from, to).dot(&to_centre));
        let t = (to_centre.dot(&along) / along.norm_squared()).clamp(0.0, 1.0);
        nearest = nearest.min((to_centre - along * t).norm_squared());
    }
    let signed = if deepest > 0.0 { nearest.sqrt() } else { -nearest.sqrt() };
    signed >= distance
}

#[cfg(test)]
mod tests {
    use super::super::{Pose2, Shape, pieces_gap};
    use super::*;

    #[test]
    fn the_answer_agrees_with_the_signed_gap() {
        let l = vec![[-0.04, -0.03], [0.04, -0.03], [0.04, 0.0], [0.0, 0.0], [0.0, 0.03], [-0.04, 0.03]];
        let shapes = [
            Shape::rectangle(0.045, 0.09),
            Shape::Disc { radius: 0.022 },
            Shape::Polygon(l),
            Shape::ConvexPolygon(vec![[0.0225, 0.045], [-0.0225, 0.0], [0.0225, -0.045]]),
        ]
        .map(|shape| Footprint::new(shape).unwrap());
        let mut together = 0;
        for k in 0..8000 {
            let r = |prime: f64| (f64::from(k) * prime.sqrt()).fract();
            let (a, b) = (&shapes[k as usize % 4], &shapes[k as usize / 4 % 4]);
            let pa = Pose2::new(0.5, 0.1, 6.3 * r(7.0));
            let pb = Pose2::new(0.4 + 0.2 * r(2.0), 0.2 * r(3.0), 6.3 * r(5.0));
            let gap = pieces_gap(a, &pa, b, &pb);
            for wanted in [0.0, -0.002, 0.003] {
                let got = footprints_apart(a, &pa.frame(), b, &pb.frame(), wanted);
                assert_eq!(got, footprints_apart(b, &pb.frame(), a, &pa.frame(), wanted));
                // A positive gap is promised where the answer is yes, and always found with a margin.
                let lax = if wanted > 0.0 { 1.5 * wanted } else { wanted };
                assert!(
                    if got { gap >= wanted - 1e-9 } else { gap <= lax + 1e-9 },
                    "{gap} {wanted} {got} {pa:?} {pb:?}"
                );
                together += usize::from(!got);
            }
        }
        assert!(together > 2000 && together < 22000, "{together}");
    }
}
