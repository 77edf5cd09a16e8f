//! Outlines of every kind, turned, scaled, moved, roughened: what holds of their pieces and of what simplifying leaves.

use std::f64::consts::{PI, TAU};

use super::polygon::{area_moments, contains_point, edges, is_convex};
use super::pose::{Pose2, Vec2, vec2};
use super::simplify::OUTLINE_TOLERANCE;
use super::{CompoundPart, Footprint, MAX_CORNERS, Piece, Shape};

type Outline = Vec<[f64; 2]>;

/// A seeded stream of numbers in [0, 1).
struct Numbers(u64);

impl Numbers {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (self.0 >> 11) as f64 / (1u64 << 53) as f64
    }
}

/// Teeth of `width` by `height`, `gap` apart, on a base.
fn comb(teeth: usize, width: f64, gap: f64, height: f64, base: f64) -> Outline {
    let at = |i: usize| i as f64 * (width + gap);
    let mut outline = vec![[0.0, 0.0], [at(teeth - 1) + width, 0.0]];
    for i in (0..teeth).rev() {
        outline.extend([[at(i) + width, base + height], [at(i), base + height]]);
        if i > 0 {
            outline.extend([[at(i), base], [at(i) - gap, base]]);
        }
    }
    outline
}

/// Corners at radii that repeat, evenly spaced in angle.
fn wheel(corners: usize, radii: &[f64]) -> Outline {
    let at = |i: usize| {
        let (angle, radius) = (TAU * i as f64 / corners as f64, radii[i % radii.len()]);
        [radius * angle.cos(), radius * angle.sin()]
    };
    (0..corners).map(at).collect()
}

fn spiral(steps: usize) -> Outline {
    let at = |i: usize, inner: f64| {
        let angle = 12.0 * i as f64 / steps as f64;
        let radius = inner + 0.003 * angle;
        [radius * angle.cos(), radius * angle.sin()]
    };
    (0..steps).map(|i| at(i, 0.01)).chain((0..steps).rev().map(|i| at(i, 0.0085))).collect()
}

/// Columns of pixels of 2 mm, with every pixel's corner or only where the outline turns.
fn pixels(seed: u64, columns: usize, every: bool) -> Outline {
    let mut numbers = Numbers(seed);
    let mut step = |from: i32, least: i32| (from + (numbers.next() * 5.0) as i32 - 2).max(least);
    let (mut low, mut high) = (0, 4);
    let (mut lower, mut upper) = (Vec::new(), Vec::new());
    for column in 0..columns as i32 {
        let (before_low, before_high) = (low, high);
        low = step(low, -20).min(before_high - 1);
        high = step(high, low + 1).max(before_low + 1);
        lower.extend([[column, low], [column + 1, low]]);
        upper.extend([[column, high], [column + 1, high]]);
    }
    lower.extend(upper.into_iter().rev());
    lower.dedup();
    let straight = |i: usize| {
        let [a, b, c] = [i + lower.len() - 1, i, i + 1].map(|k| lower[k % lower.len()]);
        (b[0] - a[0]) * (c[1] - b[1]) == (b[1] - a[1]) * (c[0] - b[0])
    };
    let lower: Vec<[i32; 2]> = (0..lower.len()).filter(|&i| !straight(i)).map(|i| lower[i]).collect();
    let mut outline: Outline = Vec::new();
    for (i, from) in lower.iter().enumerate() {
        let to = lower[(i + 1) % lower.len()];
        let steps = if every { (to[0] - from[0]).abs().max((to[1] - from[1]).abs()) } else { 1 };
        for k in 0..steps {
            let part = |axis: usize| f64::from(from[axis] * (steps - k) + to[axis] * k) / f64::from(steps) * 0.002;
            outline.push([part(0), part(1)]);
        }
    }
    outline
}

/// Further corners on every edge, off it by at most `noise`.
fn roughened(outline: &[[f64; 2]], per_edge: usize, noise: f64) -> Outline {
    let mut numbers = Numbers(9);
    let mut rough = Outline::new();
    for (i, p) in outline.iter().enumerate() {
        let q = outline[(i + 1) % outline.len()];
        rough.push(*p);
        for k in 1..per_edge {
            let t = k as f64 / per_edge as f64;
            rough.push([0, 1].map(|axis| p[axis] + (q[axis] - p[axis]) * t + noise * (numbers.next() - 0.5)));
        }
    }
    rough
}

fn t() -> Outline {
    vec![
        [-0.03, 0.02],
        [-0.03, 0.0],
        [-0.01, 0.0],
        [-0.01, -0.04],
        [0.01, -0.04],
        [0.01, 0.0],
        [0.03, 0.0],
        [0.03, 0.02],
    ]
}

fn outlines() -> Vec<(&'static str, Outline)> {
    let u = comb(2, 0.02, 0.02, 0.04, 0.02);
    let e = comb(3, 0.012, 0.012, 0.03, 0.012);
    let notched: Outline = [[-0.045, 0.0225], [-0.045, -0.0225], [0.045, -0.0225], [0.045, 0.0225]]
        .into_iter()
        .chain((0..=16).map(|i| {
            let angle = PI * f64::from(i) / 16.0;
            [0.0235 * angle.cos(), 0.0225 - 0.0235 * angle.sin()]
        }))
        .collect();
    let mut all = vec![
        ("T", t()),
        ("T with corners along its edges", roughened(&t(), 2, 0.0)),
        ("U", u),
        ("E rough by a micrometre", roughened(&e, 4, 1e-6)),
        ("E rough by a nanometre", roughened(&e, 4, 1e-9)),
        ("E rough by rounding", roughened(&e, 4, 1e-17)),
        ("E", e),
        ("comb", comb(7, 0.004, 0.004, 0.03, 0.01)),
        ("heat sink", comb(16, 0.0015, 0.0025, 0.025, 0.005)),
        ("notched", notched),
        ("star of 5", wheel(10, &[0.04, 0.016])),
        ("star of 60", wheel(120, &[0.03, 0.025])),
        ("star of 250", wheel(500, &[0.03, 0.025])),
        ("gear of 20", wheel(80, &[0.03, 0.03, 0.025, 0.025])),
        ("spiral", spiral(60)),
    ];
    for seed in 0..12 {
        all.push(("pixels", pixels(seed, 10 + seed as usize, false)));
        all.push(("every pixel", pixels(seed, 10 + seed as usize, true)));
    }
    all
}

/// Turned, scaled, then moved.
fn placed(outline: &[[f64; 2]], angle: f64, scale: f64, to: Vec2) -> Outline {
    let pose = Pose2::at(to, angle);
    let at = |p: &[f64; 2]| {
        let q = pose.transform_point(vec2(p[0], p[1]) * scale);
        [q.x, q.y]
    };
    outline.iter().map(at).collect()
}

/// About a corner: no cancellation far from the origin.
fn area(points: &[Vec2]) -> f64 {
    area_moments(points).0
}

fn corners(outline: &[[f64; 2]]) -> Vec<Vec2> {
    outline.iter().map(|p| vec2(p[0], p[1])).collect()
}

/// The corners of the pieces of a footprint; discs have none.
fn pieces(footprint: &Footprint) -> Vec<&[Vec2]> {
    footprint
        .pieces
        .iter()
        .map(|piece| if let Piece::Convex(points) = piece { points.as_slice() } else { &[] })
        .collect()
}

/// Distance of a point from a closed line.
fn distance(line: &[Vec2], p: Vec2) -> f64 {
    let to = |(a, b): (Vec2, Vec2)| {
        let t = ((p - a).dot(&(b - a)) / (b - a).norm_squared()).clamp(0.0, 1.0);
        (p - a - (b - a) * t).norm()
    };
    edges(line).map(to).fold(f64::INFINITY, f64::min)
}

/// Convex pieces that cover the outline and do not overlap.
fn check_pieces(what: &str, footprint: &Footprint, outline: &[Vec2], samples: usize) {
    let size = outline.iter().map(|p| (p - outline[0]).norm()).fold(0.0, f64::max);
    let pieces = pieces(footprint);
    assert!(pieces.iter().all(|piece| is_convex(piece, 1e-12 * size)), "{what}: a piece is not convex");
    let total: f64 = pieces.iter().map(|piece| area(piece)).sum();
    let want = area(outline).abs();
    assert!((total / want - 1.0).abs() < 1e-9, "{what}: pieces of {total}, outline of {want}");
    assert!((footprint.area / want - 1.0).abs() < 1e-9, "{what}: {} is not {want}", footprint.area);
    // Where the areas agree, what is covered everywhere is covered once.
    let mut numbers = Numbers(outline.len() as u64);
    let (low, high) = outline.iter().fold((outline[0], outline[0]), |(low, high), p| (low.inf(p), high.sup(p)));
    for _ in 0..samples {
        let p = vec2(low.x + (high.x - low.x) * numbers.next(), low.y + (high.y - low.y) * numbers.next());
        let holding = pieces.iter().filter(|piece| contains_point(piece, p)).count();
        if distance(outline, p) > 1e-9 * size {
            assert_eq!(holding > 0, contains_point(outline, p), "{what}: {p:?} lies in {holding} pieces");
        }
    }
}

#[test]
fn every_outline_is_split_whichever_way_it_lies_wherever_and_at_any_size() {
    for (kind, outline) in outlines() {
        let turns = (40_000 / outline.len()).clamp(24, 720);
        // From about a millimetre to ten metres, a square millimetre at least.
        let least = (2e-6 / area(&corners(&outline)).abs()).sqrt().max(0.02);
        for turn in 0..turns {
            let scale = [1.0, least, 1.0, 100.0][turn % 4];
            let far = if scale > 1.0 { 0.0 } else { 8.0 };
            let to = [vec2(0.0, 0.0), vec2(0.3, -0.2), vec2(far, -far)][turn % 3];
            let mut turned = placed(&outline, TAU * turn as f64 / turns as f64, scale, to);
            if turn % 2 == 0 {
                turned.reverse();
            }
            let what = format!("{kind}, turn {turn} of {turns}, scale {scale}");
            let footprint = Footprint::new(Shape::Polygon(turned.clone())).unwrap_or_else(|e| panic!("{what}: {e}"));
            check_pieces(&what, &footprint, &corners(&turned), 3);
            assert!(footprint.deviation == 0.0, "{what}");
        }
    }
}

#[test]
fn a_part_of_a_compound_has_the_same_pieces_whichever_way_it_lies() {
    for (kind, outline) in outlines() {
        let lying = Footprint::new(Shape::Polygon(outline.clone())).unwrap();
        let turns = (20_000 / outline.len()).clamp(12, 360);
        for turn in 0..turns {
            let pose = Pose2::new(0.1, -0.05, TAU * turn as f64 / turns as f64);
            let part = CompoundPart { pose, shape: Shape::Polygon(outline.clone()) };
            let footprint =
                Footprint::new(Shape::Compound(vec![part])).unwrap_or_else(|e| panic!("{kind} {turn}: {e}"));
            assert_eq!(footprint.pieces.len(), lying.pieces.len(), "{kind} {turn}");
            let moved: Vec<Vec2> = corners(&outline).into_iter().map(|p| pose.transform_point(p)).collect();
            check_pieces(kind, &footprint, &moved, 0);
        }
    }
}

#[test]
fn simplifying_moves_no_corner_keeps_the_tolerance_and_says_how_far_it_went() {
    for (kind, plain) in outlines() {
        for (i, scale) in [1.0, 0.3, 3.0].into_iter().enumerate() {
            let noise = [2e-5, 5e-5, 1e-8][i];
            let outline = placed(&roughened(&plain, 5, noise), 0.1 + i as f64, scale, vec2(0.1, 0.2));
            let all = corners(&outline);
            let exact = Footprint::new(Shape::Polygon(outline.clone()));
            for asked in [None, Some(1e-4), Some(5e-5 * scale)] {
                let what = format!("{kind}, scale {scale}, {asked:?}");
                let simple = match Footprint::simplified(Shape::Polygon(outline.clone()), asked) {
                    Ok(simple) => simple,
                    Err(e) => {
                        // Only what keeps too many corners.
                        assert!(exact.is_err() && e.to_string().contains("corners after simplifying"), "{what}: {e}");
                        continue;
                    }
                };
                let kept = &simple.outlines[0];
                assert!(kept.iter().all(|p| all.contains(p)), "{what}: a corner moved");
                assert!(simple.deviation <= asked.unwrap_or(OUTLINE_TOLERANCE), "{what}: {}", simple.deviation);
                let off = all.iter().map(|&p| distance(kept, p)).fold(0.0, f64::max);
                assert!(off <= simple.deviation + 1e-12, "{what}: {off} {}", simple.deviation);
                assert!(kept.len() < all.len(), "{what}: {} of {} corners stay", kept.len(), all.len());
                let (own, given) = (area(kept), area(&all).abs());
                let perimeter: f64 = edges(&all).map(|(a, b)| (b - a).norm()).sum();
                assert!((own - given).abs() <= perimeter * simple.deviation + 1e-12, "{what}: {own} {given}");
                assert!((simple.area / given - 1.0).abs() < 1e-9, "{what}: the mass is that of the shape as given");
                let again = Footprint::simplified(Shape::Polygon(kept.iter().map(|p| [p.x, p.y]).collect()), Some(0.0));
                assert_eq!(again.unwrap().pieces.len(), simple.pieces.len(), "{what}");
            }
        }
    }
}

#[test]
fn outlines_of_few_corners_stay_as_they_are_to_the_bit() {
    for (kind, outline) in outlines() {
        if kind.contains("rough") || kind.contains("along") || kind.starts_with("every") {
            continue;
        }
        for scale in [0.3, 1.0, 10.0] {
            let given = Shape::Polygon(placed(&outline, 0.7, scale, vec2(0.0, 0.0)));
            let exact = Footprint::new(given.clone()).unwrap();
            assert_eq!(Footprint::simplified(given, None).unwrap(), exact, "{kind} at {scale}");
        }
    }
}

#[test]
fn a_rounded_hull_is_one_convex_piece_within_the_tolerance() {
    for grain in [1e-4, 5e-5, 1e-5] {
        for (corners_given, radius) in [(24, 0.012), (100, 0.02), (360, 0.025), (360, 0.06), (1024, 0.1)] {
            for squeeze in [1.0, 0.6] {
                let round = |v: f64| (v / grain).round() * grain;
                let mut outline: Outline = (0..corners_given)
                    .map(|i| TAU * f64::from(i) / f64::from(corners_given))
                    .map(|angle| [round(radius * angle.cos()), round(squeeze * radius * angle.sin())])
                    .collect();
                outline.dedup();
                let given = corners(&outline);
                for shape in [Shape::Polygon(outline.clone()), Shape::ConvexPolygon(outline)] {
                    let what = format!("{corners_given} corners, radius {radius}, grain {grain}, {squeeze}");
                    let footprint =
                        Footprint::simplified(shape, Some(OUTLINE_TOLERANCE)).unwrap_or_else(|e| panic!("{what}: {e}"));
                    assert_eq!(footprint.pieces.len(), 1, "{what}");
                    assert!(is_convex(&footprint.outlines[0], 1e-15), "{what}");
                    let off = given.iter().map(|&p| distance(&footprint.outlines[0], p)).fold(0.0, f64::max);
                    assert!(
                        off <= footprint.deviation + 1e-12 && footprint.deviation <= 1.42 * OUTLINE_TOLERANCE,
                        "{what}"
                    );
                    assert!(footprint.outlines[0].len() <= 100.max(given.len() / 4), "{what}");
                }
            }
        }
    }
}

#[test]
fn a_shallow_bay_of_many_corners_is_not_taken_for_a_straight_edge() {
    // Every corner lies within a tenth of a micrometre of the line between its neighbours; the bay is 4 mm deep.
    let mut outline = vec![[0.03, 0.02], [-0.03, 0.02], [-0.03, 0.0]];
    outline.extend((1..400).map(|i| {
        let t = f64::from(i) / 400.0;
        [-0.03 + 0.06 * t, 0.016 * t * (1.0 - t)]
    }));
    outline.push([0.03, 0.0]);
    for tolerance in [None, Some(0.0)] {
        let bay = Footprint::simplified(Shape::Polygon(outline.clone()), tolerance).unwrap();
        assert!(bay.pieces.len() > 1 && !bay.contains(&Pose2::IDENTITY, vec2(0.0, 0.003)), "{tolerance:?}");
        assert!(Footprint::simplified(Shape::ConvexPolygon(outline.clone()), tolerance).is_err());
    }
}

#[test]
fn the_tolerance_follows_the_thickness() {
    for (radius, want) in [(0.001, 1e-5), (0.005, 5e-5), (0.02, 1e-4), (0.5, 1e-4)] {
        let fine = Footprint::simplified(Shape::Polygon(wheel(500, &[radius])), None).unwrap();
        assert!(fine.deviation <= want && fine.deviation > want / 8.0, "{radius}: {}", fine.deviation);
    }
    // A ruler of 0.5 by 100 mm keeps a notch of 0.02 mm, which a plate loses.
    let notch = |thick: f64| {
        vec![[0.0, 0.0], [0.1, 0.0], [0.1, thick], [0.06, thick], [0.05, thick - 2e-5], [0.04, thick], [0.0, thick]]
    };
    assert_eq!(Footprint::simplified(Shape::Polygon(notch(5e-4)), None).unwrap().outlines[0].len(), 7);
    assert_eq!(Footprint::simplified(Shape::Polygon(notch(0.05)), None).unwrap().outlines[0].len(), 4);
}

#[test]
fn more_corners_than_can_be_planned_with_are_refused_unless_the_tolerance_takes_them() {
    let star = Shape::Polygon(wheel(1000, &[0.025, 0.03]));
    for tolerance in [None, Some(0.0), Some(1e-4)] {
        let error = Footprint::simplified(star.clone(), tolerance).unwrap_err().to_string();
        assert!(
            error.contains(&format!("has 1000 corners after simplifying, and a body at most {MAX_CORNERS}")),
            "{error}"
        );
    }
    let round = Footprint::simplified(star, Some(0.006)).unwrap();
    assert!(round.outlines[0].len() < 100 && round.deviation <= 0.006, "{}", round.deviation);
    let error = Footprint::new(Shape::Polygon(wheel(4097, &[0.03]))).unwrap_err().to_string();
    assert!(error.starts_with("shape.polygon: has 4097 corners; a polygon has 3 to 4096"), "{error}");
    let part =
        |x: f64| CompoundPart { pose: Pose2::new(x, 0.0, 0.0), shape: Shape::Polygon(wheel(300, &[0.03, 0.025])) };
    let error = Footprint::new(Shape::Compound(vec![part(0.0), part(0.06)])).unwrap_err().to_string();
    assert!(error.starts_with("shape: has 600 corners"), "{error}");
}

#[test]
fn a_bad_outline_is_refused_with_the_corners_as_they_were_given() {
    for (outline, want) in [
        (vec![[0.0, 0.0], [0.0, 0.04], [0.04, 0.0], [0.04, 0.04]], "edge 1 from (0, 0.04) to (0.04, 0) crosses edge 3"),
        (vec![[0.0, 0.0], [0.04, 0.0], [0.02, 0.0], [0.02, 0.04]], "folds back over itself at corner 1, (0.04, 0)"),
        (
            vec![[0.0, 0.0], [0.04, 0.0], [0.04, 0.04], [0.0, 0.0], [-0.04, -0.04], [-0.04, 0.0]],
            "corner 3 repeats corner 0 at (0, 0)",
        ),
        // Corners that repeat their neighbours count, but do not hide what is wrong behind them.
        (
            vec![[0.0, 0.0], [0.0, 0.0], [0.0, 0.04], [0.04, 0.0], [0.04, 0.0], [0.04, 0.04]],
            "edge 2 from (0, 0.04) to (0.04, 0) crosses edge 5 from (0.04, 0.04) to (0, 0)",
        ),
        (vec![[0.0, 0.0], [0.04, 0.0], [0.04, 0.0], [0.0, 0.0]], "has 2 corners at places of their own"),
        (vec![[0.01, 0.0]; 4], "has 1 corners at places of their own"),
    ] {
        let error = Footprint::new(Shape::Polygon(outline)).unwrap_err().to_string();
        assert!(error.contains(want), "{error}");
    }
}

#[test]
fn corners_that_lie_where_their_neighbours_lie_count_once() {
    // An L as it was cut out of a mesh: a vertex in the plane gives a corner for each of its triangles, and the ring is closed.
    let plain = [[0.0, 0.0], [0.06, 0.0], [0.06, 0.02], [0.02, 0.02], [0.02, 0.06], [0.0, 0.06]];
    let near = |p: [f64; 2], off: f64| [p[0] + off, p[1] - off];
    let cut = |off: f64| -> Vec<[f64; 2]> {
        let each = plain.iter().enumerate();
        let twice = each.flat_map(|(i, &p)| std::iter::repeat_n(p, 1 + i % 3).enumerate());
        twice.map(|(k, p)| near(p, off * k as f64)).chain([plain[0]]).collect()
    };
    let want = Footprint::new(Shape::Polygon(plain.to_vec())).unwrap();
    for off in [0.0, 1e-15, 1e-12, 3e-8] {
        let mut given = cut(off);
        for _ in 0..given.len() {
            let got = Footprint::new(Shape::Polygon(given.clone())).unwrap();
            assert_eq!(got.outlines[0].len(), 6, "{off} {given:?}");
            assert_eq!(got.pieces.len(), want.pieces.len());
            assert!((got.area - want.area).abs() < 1e-8 && (got.centroid - want.centroid).norm() < 1e-7, "{off}");
            given.rotate_left(1);
        }
        given.reverse();
        assert_eq!(Footprint::new(Shape::Polygon(given)).unwrap().outlines[0].len(), 6);
    }
}
