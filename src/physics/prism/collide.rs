//! Gaps and contact points of two convex pieces in the plane, by separating axes.

use super::model::{Flat, Real};

/// A piece at its place: corners and edge normals in the world, counter-clockwise, or a disc.
#[derive(Clone, Copy)]
pub enum Outline<'a> {
    /// `middle` is some point inside.
    Polygon { corners: &'a [Flat], normals: &'a [Flat], middle: Flat },
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

impl Touch {
    /// The same of the second piece and the first.
    fn turned(self) -> Touch {
        let ([x, y], [p, q]) = (self.normal, self.points);
        Touch { normal: [-x, -y], points: [q, p], gap: self.gap }
    }
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

/// Edges of the two pieces that parted them farthest when they were last looked at: they will mostly do so again.
pub type Axes = [u16; 2];

/// The nearest points where the gap is less than `reach`; else a bound on the gap from below.
pub fn touch(a: Outline<'_>, b: Outline<'_>, reach: Real, axes: &mut Axes) -> Result<Touch, Real> {
    match (a, b) {
        (Outline::Polygon { corners, normals, middle }, Outline::Polygon { corners: c, normals: n, middle: m }) => {
            polygons(Polygon { corners, normals, middle }, Polygon { corners: c, normals: n, middle: m }, reach, axes)
        }
        (Outline::Polygon { corners, normals, .. }, Outline::Disc(centre)) => {
            polygon_disc(corners, normals, centre, reach)
        }
        (Outline::Disc(centre), Outline::Polygon { corners, normals, .. }) => {
            polygon_disc(corners, normals, centre, reach).map(Touch::turned)
        }
        (Outline::Disc(a), Outline::Disc(b)) => {
            let d = sub(b, a);
            let distance = dot(d, d).sqrt();
            let normal = if distance > 0.0 { [d[0] / distance, d[1] / distance] } else { [1.0, 0.0] };
            if distance < reach { Ok(Touch { normal, points: [a, b], gap: distance }) } else { Err(distance) }
        }
    }
}

#[derive(Clone, Copy)]
struct Polygon<'a> {
    corners: &'a [Flat],
    normals: &'a [Flat],
    middle: Flat,
}

/// How far an edge of the first polygon parts it from the second.
#[derive(Clone, Copy)]
struct Face {
    gap: Real,
    edge: usize,
    /// The corner of the second polygon that lies deepest.
    corner: usize,
}

impl Polygon<'_> {
    #[inline]
    fn face(&self, edge: usize, others: &[Flat]) -> Face {
        let (normal, level) = (self.normals[edge], dot(self.corners[edge], self.normals[edge]));
        let mut face = Face { gap: Real::INFINITY, edge, corner: 0 };
        for (j, &q) in others.iter().enumerate() {
            let d = dot(q, normal);
            if d < face.gap {
                (face.gap, face.corner) = (d, j);
            }
        }
        face.gap -= level;
        face
    }

    /// The edge that parts farthest, where that is farther than `best` and than `least`. Ends at an edge that parts by
    /// `reach`. An edge parts by no more than the other's middle is before it, which spares most of the looking.
    #[inline]
    fn farthest(&self, other: &Polygon<'_>, mut best: Face, least: Real, reach: Real) -> Face {
        for (edge, (&corner, &normal)) in self.corners.iter().zip(self.normals).enumerate() {
            if dot(sub(other.middle, corner), normal) <= best.gap.max(least) || edge == best.edge {
                continue;
            }
            let face = self.face(edge, other.corners);
            if face.gap > best.gap {
                best = face;
                if best.gap >= reach {
                    break;
                }
            }
        }
        best
    }
}

fn polygons(a: Polygon<'_>, b: Polygon<'_>, reach: Real, axes: &mut Axes) -> Result<Touch, Real> {
    let [hint_a, hint_b] = axes.map(usize::from);
    let face_b = b.face(hint_b, a.corners);
    if face_b.gap >= reach {
        return Err(face_b.gap);
    }
    let face_a = a.farthest(&b, a.face(hint_a, b.corners), Real::NEG_INFINITY, reach);
    axes[0] = face_a.edge as u16;
    if face_a.gap >= reach {
        return Err(face_a.gap);
    }
    let face_b = b.farthest(&a, face_b, face_a.gap, reach);
    axes[1] = face_b.edge as u16;
    if face_b.gap >= reach {
        return Err(face_b.gap);
    }
    // Where both do as well the first piece's face is taken, so that it does not change with every rounding.
    if face_a.gap + 1e-6 >= face_b.gap {
        edge_against(a, b, face_a, reach)
    } else {
        edge_against(b, a, face_b, reach).map(Touch::turned)
    }
}

/// The deepest point of `b` against an edge of `a`, cut to the edge's length; corner to corner beyond its ends.
fn edge_against(a: Polygon<'_>, b: Polygon<'_>, face: Face, reach: Real) -> Result<Touch, Real> {
    let Face { gap, edge, corner } = face;
    let (p, q) = (a.corners[edge], a.corners[if edge + 1 == a.corners.len() { 0 } else { edge + 1 }]);
    let normal = a.normals[edge];
    let tangent = [-normal[1], normal[0]];
    let length = dot(sub(q, p), tangent);
    let deep = b.corners[corner];
    let t = dot(sub(deep, p), tangent);
    if t >= 0.0 && t <= length {
        return Ok(Touch { normal, points: [along(p, tangent, t), deep], gap });
    }
    // The deepest corner lies beside the edge: follow the edge of `b` that leads back over it.
    let m = b.corners.len();
    let (next, previous) = (if corner + 1 == m { 0 } else { corner + 1 }, if corner == 0 { m - 1 } else { corner - 1 });
    // `b` runs counter-clockwise, so seen from the edge its next corner lies towards smaller t.
    let other = b.corners[if t > length { next } else { previous }];
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
            return if at < reach {
                Ok(Touch { normal, points: [on, along(on, normal, at)], gap: at })
            } else {
                Err(gap)
            };
        }
    }
    let from = if t > length { q } else { p };
    let apart = sub(deep, from);
    let distance = dot(apart, apart).sqrt();
    if distance >= reach {
        return Err(gap);
    }
    if gap <= 0.0 || distance <= 1e-9 {
        return Ok(Touch { normal, points: [from, deep], gap });
    }
    Ok(Touch { normal: [apart[0] / distance, apart[1] / distance], points: [from, deep], gap: distance })
}

fn polygon_disc(corners: &[Flat], normals: &[Flat], centre: Flat, reach: Real) -> Result<Touch, Real> {
    let (mut gap, mut edge) = (Real::NEG_INFINITY, 0);
    for i in 0..corners.len() {
        let d = dot(sub(centre, corners[i]), normals[i]);
        if d >= reach {
            return Err(d);
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
        return Ok(Touch { normal, points: [along(p, tangent, t.clamp(0.0, length)), centre], gap });
    }
    let from = if t < 0.0 { p } else { q };
    let apart = sub(centre, from);
    let distance = dot(apart, apart).sqrt();
    if distance >= reach {
        return Err(distance);
    }
    Ok(Touch { normal: [apart[0] / distance, apart[1] / distance], points: [from, centre], gap: distance })
}
