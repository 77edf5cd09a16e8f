//! Triangles of a simple polygon by clipping ears, with exact predicates (Shewchuk 1997, crate `robust`).
//!
//! The two-ears theorem (Meisters 1975) holds for corners that lie on a straight line as well, as long as an ear may have
//! no corner on its diagonal. With exact signs it holds in the machine too: no simple polygon is left without an ear.

use std::cmp::Ordering;

use super::pose::Vec2;

/// Twice the signed area of a triangle, positive where `a`, `b`, `c` run counter-clockwise. The sign is exact.
pub(crate) fn orientation(a: Vec2, b: Vec2, c: Vec2) -> f64 {
    let coord = |p: Vec2| robust::Coord { x: p.x, y: p.y };
    robust::orient2d(coord(a), coord(b), coord(c))
}

/// A corner of what is left of the polygon.
struct Corner {
    previous: usize,
    next: usize,
    /// Turns left: only corners that do not can lie in an ear.
    convex: bool,
    /// Its sharpness where it may be clipped.
    ear: Option<f32>,
}

/// Triangles, counter-clockwise, as indices of the corners of a simple, counter-clockwise polygon; the sharpest ear goes
/// first. `None` where the polygon is not simple.
pub(super) fn triangles(points: &[Vec2]) -> Option<Vec<[usize; 3]>> {
    let n = points.len();
    let sharpness = Sharpness::new(points);
    let mut corners: Vec<Corner> =
        (0..n).map(|i| Corner { previous: (i + n - 1) % n, next: (i + 1) % n, convex: false, ear: None }).collect();
    for i in 0..n {
        corners[i].convex = turns_left(points, &corners, i);
    }
    // The corners that an ear must not hold, in any order.
    let mut blunt: Vec<usize> = (0..n).filter(|&i| !corners[i].convex).collect();
    for i in 0..n {
        corners[i].ear = is_ear(points, &corners, &blunt, i).then(|| sharpness.of(&corners, i));
    }
    let mut left: Vec<usize> = (0..n).collect();
    let mut triangles = Vec::with_capacity(n.saturating_sub(2));
    while left.len() > 3 {
        let ears = left.iter().enumerate().filter_map(|(place, &i)| Some((place, corners[i].ear?)));
        let (place, _) = ears.max_by(|(_, a), (_, b)| a.partial_cmp(b).unwrap_or(Ordering::Equal))?;
        let tip = left[place];
        left.remove(place);
        let (previous, next) = (corners[tip].previous, corners[tip].next);
        triangles.push([previous, tip, next]);
        corners[previous].next = next;
        corners[next].previous = previous;
        for i in [previous, next] {
            if !corners[i].convex && turns_left(points, &corners, i) {
                corners[i].convex = true;
                blunt.retain(|&other| other != i);
            }
        }
        for i in [previous, next] {
            corners[i].ear = is_ear(points, &corners, &blunt, i).then(|| sharpness.of(&corners, i));
        }
    }
    let last = *left.first()?;
    triangles.push([corners[last].previous, last, corners[last].next]);
    Some(triangles)
}

fn turns_left(points: &[Vec2], corners: &[Corner], i: usize) -> bool {
    let corner = &corners[i];
    orientation(points[corner.previous], points[i], points[corner.next]) > 0.0
}

/// How sharp corners are: the cosine of the angle. It only says which ear goes first, and single precision is enough for
/// that; how it rounds decides between the equal corners of symmetrical outlines, and so which pieces these have.
struct Sharpness(Vec<[f32; 2]>);

impl Sharpness {
    fn new(points: &[Vec2]) -> Self {
        let centre = points.iter().sum::<Vec2>() / points.len() as f64;
        let size = points.iter().map(|p| (p - centre).norm()).fold(0.0, f64::max);
        let unit = |p: &Vec2| {
            let q = (p - centre) / size;
            [q.x as f32, q.y as f32]
        };
        Sharpness(points.iter().map(unit).collect())
    }

    fn of(&self, corners: &[Corner], i: usize) -> f32 {
        let towards = |j: usize| {
            let (x, y) = (self.0[j][0] - self.0[i][0], self.0[j][1] - self.0[i][1]);
            let per_length = 1.0 / (x * x + y * y).sqrt();
            [x * per_length, y * per_length]
        };
        let (p, q) = (towards(corners[i].previous), towards(corners[i].next));
        let cosine = p[0] * q[0] + p[1] * q[1];
        // Corners may be one in single precision.
        if cosine.is_nan() { -1.0 } else { cosine }
    }
}

/// A corner may be clipped: it turns left, and the triangle it makes with its neighbours holds no other corner.
fn is_ear(points: &[Vec2], corners: &[Corner], blunt: &[usize], i: usize) -> bool {
    let Corner { previous, next, convex, .. } = corners[i];
    let (a, b, c) = (points[previous], points[i], points[next]);
    let (low, high) = (a.inf(&b).inf(&c), a.sup(&b).sup(&c));
    let holds = |j: usize| {
        let p = points[j];
        j != previous
            && j != next
            && p.x >= low.x
            && p.x <= high.x
            && p.y >= low.y
            && p.y <= high.y
            && [(a, b), (b, c), (c, a)].into_iter().all(|(from, to)| orientation(from, to, p) >= 0.0)
    };
    convex && !blunt.iter().any(|&j| holds(j))
}

/// Merges triangles to convex pieces by leaving diagonals out (Hertel and Mehlhorn 1983). A merged piece may be dented by
/// `slack` metres, for rounding.
pub(super) fn merged(points: &[Vec2], triangles: &[[usize; 3]], slack: f64) -> Vec<Vec<usize>> {
    let mut pieces: Vec<Vec<usize>> = triangles.iter().map(|triangle| triangle.to_vec()).collect();
    let mut first = 0;
    while first < pieces.len() {
        let mut edge = 0;
        while edge < pieces[first].len() {
            match joined(points, &pieces, first, edge, slack) {
                Some((second, piece)) => {
                    pieces.swap_remove(second);
                    pieces[first] = piece;
                    edge = 0;
                }
                None => edge += 1,
            }
        }
        first += 1;
    }
    pieces
}

/// A piece and the later one on the other side of one of its edges made one, if that is convex.
fn joined(
    points: &[Vec2],
    pieces: &[Vec<usize>],
    first: usize,
    edge: usize,
    slack: f64,
) -> Option<(usize, Vec<usize>)> {
    let one = &pieces[first];
    let (from, to) = (one[edge], one[(edge + 1) % one.len()]);
    let (second, at) = pieces.iter().enumerate().skip(first + 1).find_map(|(second, piece)| {
        let at = (0..piece.len()).find(|&k| piece[k] == to && piece[(k + 1) % piece.len()] == from)?;
        Some((second, at))
    })?;
    let other = &pieces[second];
    let of = |piece: &[usize], k: usize| points[piece[k % piece.len()]];
    // What turns back by 180 degrees has no area either, but is not straight.
    let straight = |a: Vec2, b: Vec2, c: Vec2| {
        let turn = orientation(a, b, c);
        turn > 0.0 || (turn >= -slack * (c - a).norm() && (b - a).dot(&(c - b)) > 0.0)
    };
    let (n, m) = (one.len(), other.len());
    let convex = straight(of(one, edge + n - 1), points[from], of(other, at + 2))
        && straight(of(other, at + m - 1), points[to], of(one, edge + 2));
    if !convex {
        return None;
    }
    let mut piece = Vec::with_capacity(n + m - 2);
    piece.extend(one.iter().cycle().skip(edge + 1).take(n - 1));
    piece.extend(other.iter().cycle().skip(at + 1).take(m - 1));
    Some((second, piece))
}
