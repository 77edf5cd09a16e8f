//! Gaps and contact points of two convex pieces in the plane, by separating axes.

use super::model::{Flat, Real};

/// A piece at its place: corners and edge normals in the world, counter-clockwise, or a disc.
#[derive(Clone, Copy)]
pub enum Outline<'a> {
    Polygon {
        corners: &'a [Flat],
        normals: &'a [Flat],
    },
    /// The radius is in the piece's border.
    Disc(Flat),
}

/// Where two pieces are nearest. `gap` is that of the bare pieces, without their borders.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Touch {
    /// From the first piece to the second, of unit length.
    pub normal: Flat,
    /// On the first piece and on the second.
    pub points: [Flat; 2],
    pub gap: Real,
}

#[inline]
pub fn dot(a: Flat, b: Flat) -> Real {
    a[0] * b[0] + a[1] * b[1]
}

#[inline]
pub fn sub(a: Flat, b: Flat) -> Flat {
    [a[0] - b[0], a[1] - b[1]]
}

#[inline]
pub fn along(a: Flat, d: Flat, t: Real) -> Flat {
    [a[0] + d[0] * t, a[1] + d[1] * t]
}

/// The nearest points where the gap is less than `reach`. `axis` remembers the edge that parted the pieces last, which
/// will mostly do so again: edges of the first piece, then those of the second.
pub fn touch(a: Outline<'_>, b: Outline<'_>, reach: Real, axis: &mut u32) -> Option<Touch> {
    match (a, b) {
        (Outline::Polygon { corners, normals }, Outline::Polygon { corners: others, normals: other_normals }) => {
            polygons((corners, normals), (others, other_normals), reach, axis)
        }
        (Outline::Polygon { corners, normals }, Outline::Disc(centre)) => polygon_disc(corners, normals, centre, reach),
        (Outline::Disc(centre), Outline::Polygon { corners, normals }) => polygon_disc(corners, normals, centre, reach)
            .map(|t| Touch { normal: [-t.normal[0], -t.normal[1]], points: [t.points[1], t.points[0]], gap: t.gap }),
        (Outline::Disc(a), Outline::Disc(b)) => {
            let d = sub(b, a);
            let distance = dot(d, d).sqrt();
            let normal = if distance > 0.0 { [d[0] / distance, d[1] / distance] } else { [1.0, 0.0] };
            (distance < reach).then_some(Touch { normal, points: [a, b], gap: distance })
        }
    }
}

type Polygon<'a> = (&'a [Flat], &'a [Flat]);

/// Least distance of the corners from the line through `corner` with this normal, and which one it is.
#[inline]
fn deepest(corner: Flat, normal: Flat, others: &[Flat]) -> (Real, usize) {
    let level = dot(corner, normal);
    let (mut least, mut at) = (Real::INFINITY, 0);
    for (j, &q) in others.iter().enumerate() {
        let d = dot(q, normal);
        if d < least {
            (least, at) = (d, j);
        }
    }
    (least - level, at)
}

/// The edge of `a` that parts it farthest from `b`; `None` as soon as one parts them by `reach`, with that edge.
#[inline]
fn face(a: Polygon<'_>, b: &[Flat], reach: Real) -> Result<(Real, usize, usize), usize> {
    let mut best = (Real::NEG_INFINITY, 0, 0);
    for i in 0..a.0.len() {
        let (gap, j) = deepest(a.0[i], a.1[i], b);
        if gap >= reach {
            return Err(i);
        }
        if gap > best.0 {
            best = (gap, i, j);
        }
    }
    Ok(best)
}

fn polygons(a: Polygon<'_>, b: Polygon<'_>, reach: Real, axis: &mut u32) -> Option<Touch> {
    let (n, last) = (a.0.len(), *axis as usize);
    let parted = if last < n {
        deepest(a.0[last], a.1[last], b.0).0
    } else {
        let i = (last - n).min(b.0.len() - 1);
        deepest(b.0[i], b.1[i], a.0).0
    };
    if parted >= reach {
        return None;
    }
    let (gap_a, edge_a, corner_b) = match face(a, b.0, reach) {
        Ok(best) => best,
        Err(i) => {
            *axis = i as u32;
            return None;
        }
    };
    let (gap_b, edge_b, corner_a) = match face(b, a.0, reach) {
        Ok(best) => best,
        Err(i) => {
            *axis = (n + i) as u32;
            return None;
        }
    };
    // Where both do as well the first piece's face is taken, so that it does not change with every rounding.
    if gap_a + 1e-6 >= gap_b {
        edge_against(a, edge_a, b, corner_b, gap_a, reach)
    } else {
        edge_against(b, edge_b, a, corner_a, gap_b, reach).map(|t| Touch {
            normal: [-t.normal[0], -t.normal[1]],
            points: [t.points[1], t.points[0]],
            gap: t.gap,
        })
    }
}

/// The deepest point of `b` against an edge of `a`, cut to the edge's length; corner to corner beyond its ends.
fn edge_against(a: Polygon<'_>, edge: usize, b: Polygon<'_>, corner: usize, gap: Real, reach: Real) -> Option<Touch> {
    let (p, q) = (a.0[edge], a.0[if edge + 1 == a.0.len() { 0 } else { edge + 1 }]);
    let normal = a.1[edge];
    let tangent = [-normal[1], normal[0]];
    let length = dot(sub(q, p), tangent);
    let deep = b.0[corner];
    let t = dot(sub(deep, p), tangent);
    if t >= 0.0 && t <= length {
        return Some(Touch { normal, points: [along(p, tangent, t), deep], gap });
    }
    // The deepest corner lies beside the edge: follow the edge of `b` that leads back over it.
    let m = b.0.len();
    let (next, previous) = (if corner + 1 == m { 0 } else { corner + 1 }, if corner == 0 { m - 1 } else { corner - 1 });
    // `b` runs counter-clockwise, so seen from the edge its next corner lies towards smaller t.
    let other = b.0[if t > length { next } else { previous }];
    let end = if t > length { length } else { 0.0 };
    let u = dot(sub(other, p), tangent);
    let crosses = if t > length { u < length } else { u > 0.0 };
    let (d, e) = (sub(deep, p), sub(other, p));
    let (height, rise) = (dot(d, normal), dot(e, normal) - dot(d, normal));
    if crosses {
        let share = (end - t) / (u - t);
        let at = height + rise * share;
        let slope = rise.abs() / (u - t).abs();
        // Nearly parallel faces: the end of the edge against a face.
        if at <= 0.0 || slope < 0.1 {
            let on = along(p, tangent, end);
            return (at < reach).then_some(Touch { normal, points: [on, along(on, normal, at)], gap: at });
        }
    }
    let from = if t > length { q } else { p };
    let apart = sub(deep, from);
    let distance = dot(apart, apart).sqrt();
    if distance >= reach {
        return None;
    }
    if gap <= 0.0 || distance <= 1e-9 {
        return Some(Touch { normal, points: [from, deep], gap });
    }
    Some(Touch { normal: [apart[0] / distance, apart[1] / distance], points: [from, deep], gap: distance })
}

fn polygon_disc(corners: &[Flat], normals: &[Flat], centre: Flat, reach: Real) -> Option<Touch> {
    let (mut gap, mut edge) = (Real::NEG_INFINITY, 0);
    for i in 0..corners.len() {
        let d = dot(sub(centre, corners[i]), normals[i]);
        if d >= reach {
            return None;
        }
        if d > gap {
            (gap, edge) = (d, i);
        }
    }
    let (p, q) = (corners[edge], corners[if edge + 1 == corners.len() { 0 } else { edge + 1 }]);
    let normal = normals[edge];
    let tangent = [-normal[1], normal[0]];
    let (t, length) = (dot(sub(centre, p), tangent), dot(sub(q, p), tangent));
    if gap <= 0.0 || (t >= 0.0 && t <= length) {
        return Some(Touch { normal, points: [along(p, tangent, t.clamp(0.0, length)), centre], gap });
    }
    let from = if t < 0.0 { p } else { q };
    let apart = sub(centre, from);
    let distance = dot(apart, apart).sqrt();
    (distance < reach).then(|| Touch {
        normal: [apart[0] / distance, apart[1] / distance],
        points: [from, centre],
        gap: distance,
    })
}
