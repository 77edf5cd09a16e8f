//! Whether corners make an outline, and where they do not.

use super::polygon::edges;
use super::pose::Vec2;
use super::triangulate::orientation;

/// What keeps a closed line from being the border of an area. Edge `i` leads from corner `i` to the next.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum OutlineFault {
    /// Two corners that are not neighbours lie at one place.
    Repeats {
        corner: usize,
        other: usize,
    },
    /// The edge behind a corner runs back over the edge before it.
    FoldsBack {
        corner: usize,
    },
    /// A corner lies on an edge that is not its own.
    Touches {
        corner: usize,
        edge: usize,
    },
    Crosses {
        edge: usize,
        other: usize,
    },
}

impl OutlineFault {
    /// The same fault of a line whose corners (and the edges that begin there) have other numbers.
    pub fn numbered(self, number: impl Fn(usize) -> usize) -> OutlineFault {
        match self {
            OutlineFault::Repeats { corner, other } => {
                OutlineFault::Repeats { corner: number(corner), other: number(other) }
            }
            OutlineFault::FoldsBack { corner } => OutlineFault::FoldsBack { corner: number(corner) },
            OutlineFault::Touches { corner, edge } => {
                OutlineFault::Touches { corner: number(corner), edge: number(edge) }
            }
            OutlineFault::Crosses { edge, other } => OutlineFault::Crosses { edge: number(edge), other: number(other) },
        }
    }

    /// In words, with the coordinates.
    pub fn describe(&self, points: &[Vec2]) -> String {
        let at = |i: usize| format!("({}, {})", points[i % points.len()].x, points[i % points.len()].y);
        let edge = |i: usize| format!("edge {i} from {} to {}", at(i), at(i + 1));
        match *self {
            OutlineFault::Repeats { corner, other } => {
                format!("corner {corner} repeats corner {other} at {}", at(corner))
            }
            OutlineFault::FoldsBack { corner } => {
                format!("the outline folds back over itself at corner {corner}, {}", at(corner))
            }
            OutlineFault::Touches { corner, edge: on } => {
                format!("corner {corner} at {} lies on {}", at(corner), edge(on))
            }
            OutlineFault::Crosses { edge: one, other } => format!("{} crosses {}", edge(one), edge(other)),
        }
    }
}

/// The first fault of a closed line, exactly: no rounding decides.
pub fn outline_fault(points: &[Vec2]) -> Option<OutlineFault> {
    let n = points.len();
    let boxes: Vec<(Vec2, Vec2)> = edges(points).map(|(a, b)| (a.inf(&b), a.sup(&b))).collect();
    let apart = |i: usize, j: usize| {
        let ((low, high), (least, most)) = (boxes[i], boxes[j]);
        low.x > most.x || least.x > high.x || low.y > most.y || least.y > high.y
    };
    for i in 0..n {
        let (a, b, c) = (points[i], points[(i + 1) % n], points[(i + 2) % n]);
        if orientation(a, b, c) == 0.0 && (b - a).dot(&(c - b)) < 0.0 {
            return Some(OutlineFault::FoldsBack { corner: (i + 1) % n });
        }
        let others = (i + 2..n).filter(|&j| (j + 1) % n != i && !apart(i, j));
        if let Some(fault) = others.into_iter().find_map(|j| meeting(points, i, j)) {
            return Some(fault);
        }
    }
    None
}

/// How two edges that are not neighbours meet, if they do. Their boxes do.
fn meeting(points: &[Vec2], i: usize, j: usize) -> Option<OutlineFault> {
    let n = points.len();
    let (next_i, next_j) = ((i + 1) % n, (j + 1) % n);
    let side = |edge: usize, p: usize| orientation(points[edge], points[(edge + 1) % n], points[p]);
    let (c, d) = (side(i, j), side(i, next_j));
    let (a, b) = (side(j, i), side(j, next_i));
    let opposite = |p: f64, q: f64| (p < 0.0 && q > 0.0) || (p > 0.0 && q < 0.0);
    if opposite(a, b) && opposite(c, d) {
        return Some(OutlineFault::Crosses { edge: i, other: j });
    }
    let within = |edge: usize, p: usize| {
        let (from, to, p) = (points[edge], points[(edge + 1) % n], points[p]);
        let (low, high) = (from.inf(&to), from.sup(&to));
        p.x >= low.x && p.x <= high.x && p.y >= low.y && p.y <= high.y
    };
    let ends = [(c, i, j), (d, i, next_j), (a, j, i), (b, j, next_i)];
    let (_, edge, corner) = ends.into_iter().find(|&(side, edge, p)| side == 0.0 && within(edge, p))?;
    let same = [edge, (edge + 1) % n].into_iter().find(|&end| points[end] == points[corner]);
    Some(match same {
        Some(other) => OutlineFault::Repeats { corner: corner.max(other), other: corner.min(other) },
        None => OutlineFault::Touches { corner, edge },
    })
}

/// No two edges cross or touch, other than neighbours in their shared corner.
pub fn is_simple(points: &[Vec2]) -> bool {
    outline_fault(points).is_none()
}

#[cfg(test)]
mod tests {
    use super::super::pose::vec2;
    use super::*;

    #[test]
    fn every_fault_is_named_with_its_corners_and_edges() {
        let square = [vec2(0., 0.), vec2(1., 0.), vec2(1., 1.), vec2(0., 1.)];
        assert!(is_simple(&square));
        for (points, fault, words) in [
            (
                vec![vec2(0., 0.), vec2(1., 1.), vec2(1., 0.), vec2(0., 1.)],
                OutlineFault::Crosses { edge: 0, other: 2 },
                "edge 0 from (0, 0) to (1, 1) crosses edge 2 from (1, 0) to (0, 1)",
            ),
            (
                vec![vec2(0., 0.), vec2(1., 0.), vec2(0.5, 0.), vec2(0.5, 1.)],
                OutlineFault::FoldsBack { corner: 1 },
                "the outline folds back over itself at corner 1, (1, 0)",
            ),
            (
                vec![vec2(0., 0.), vec2(2., 0.), vec2(2., 1.), vec2(1., 0.), vec2(0., 1.)],
                OutlineFault::Touches { corner: 3, edge: 0 },
                "corner 3 at (1, 0) lies on edge 0 from (0, 0) to (2, 0)",
            ),
            (
                vec![vec2(0., 0.), vec2(1., -1.), vec2(1., 1.), vec2(0., 0.), vec2(-1., 1.), vec2(-1., -1.)],
                OutlineFault::Repeats { corner: 3, other: 0 },
                "corner 3 repeats corner 0 at (0, 0)",
            ),
        ] {
            assert_eq!(outline_fault(&points), Some(fault), "{words}");
            assert_eq!(fault.describe(&points), words);
        }
    }

    #[test]
    fn a_fault_is_found_wherever_the_list_begins_and_at_any_scale() {
        let bow_tie = [vec2(0., 0.), vec2(3., 3.), vec2(3., 1.), vec2(0., 2.), vec2(-1., 1.)];
        for scale in [1e-9, 1e-3, 1.0, 1e6] {
            for start in 0..bow_tie.len() {
                for reversed in [false, true] {
                    let mut points: Vec<Vec2> = (0..5).map(|i| bow_tie[(start + i) % 5] * scale).collect();
                    if reversed {
                        points.reverse();
                    }
                    let fault = outline_fault(&points);
                    let Some(OutlineFault::Crosses { edge, other }) = fault else { panic!("{points:?}: {fault:?}") };
                    let crossing = [points[edge], points[(edge + 1) % 5], points[other], points[(other + 1) % 5]];
                    for corner in [0, 1, 2, 3] {
                        assert!(crossing.contains(&(bow_tie[corner] * scale)), "{fault:?} {points:?}");
                    }
                }
            }
        }
    }
}
