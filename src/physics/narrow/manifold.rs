//! Contact points of two placed pieces.
//!
//! The axis of contact is the face normal of greatest separation (Gottschalk 1996), or, where the pieces are apart and
//! corner faces corner, the line between the corners. Along a face the other polygon's opposing edge is clipped to it
//! (Catto, "Contact manifolds", GDC 2007).

use super::outline::Placed;
use crate::physics::lanes::{LANES, Simd8};

/// A contact point.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Point {
    /// Midway between the surfaces, world frame, metres.
    pub x: f32,
    pub y: f32,
    /// Distance of the surfaces along the normal, metres; negative where they overlap.
    pub gap: f32,
    /// Which features meet: equal for the same contact a moment later.
    pub feature: u32,
}

/// Up to two contact points along one normal.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Manifold {
    /// Unit vector from the first piece to the second.
    pub normal: [f32; 2],
    pub points: [Point; 2],
    /// 0 where the pieces are farther apart than asked for.
    pub count: usize,
}

impl Manifold {
    #[inline(always)]
    fn one(normal: [f32; 2], point: Point) -> Manifold {
        Manifold { normal, points: [point, Point::default()], count: 1 }
    }

    fn flipped(mut self) -> Manifold {
        self.normal = [-self.normal[0], -self.normal[1]];
        self
    }

    /// The least gap of its points; infinite if there are none.
    pub fn gap(&self) -> f32 {
        self.points[..self.count].iter().fold(f32::INFINITY, |least, p| least.min(p.gap))
    }
}

/// How much better an axis of the second polygon has to be, metres: without it the choice flickers where two faces meet
/// flat.
const PREFERENCE: f32 = 1e-5;

/// The contact of two pieces where they are nearer than `within` metres.
#[inline(never)]
pub fn contact<S: Simd8>(s: S, a: Placed<'_>, b: Placed<'_>, within: f32) -> Manifold {
    s.vectorize(
        #[inline(always)]
        || pieces(s, a, b, within),
    )
}

#[inline(always)]
fn pieces<S: Simd8>(s: S, a: Placed<'_>, b: Placed<'_>, within: f32) -> Manifold {
    match (a.corners, b.corners) {
        (0, 0) => discs(a, b, within),
        (_, 0) => polygon_disc(s, a, b, within),
        (0, _) => polygon_disc(s, b, a, within).flipped(),
        _ => polygons(s, a, b, within),
    }
}

fn discs(a: Placed<'_>, b: Placed<'_>, within: f32) -> Manifold {
    let (dx, dy) = (b.centre[0] - a.centre[0], b.centre[1] - a.centre[1]);
    let distance = (dx * dx + dy * dy).sqrt();
    let gap = distance - a.radius - b.radius;
    if gap >= within {
        return Manifold::default();
    }
    // Concentric discs have no direction: any will do, as long as it is always the same.
    let (nx, ny) = if distance > 1e-9 { (dx / distance, dy / distance) } else { (1.0, 0.0) };
    let reach = a.radius + 0.5 * gap;
    Manifold::one([nx, ny], Point { x: a.centre[0] + nx * reach, y: a.centre[1] + ny * reach, gap, feature: 0 })
}

#[inline(always)]
fn polygon_disc<S: Simd8>(s: S, a: Placed<'_>, b: Placed<'_>, within: f32) -> Manifold {
    let [cx, cy] = b.centre;
    let (px, py) = (s.splat(cx), s.splat(cy));
    let (mut best, mut edge) = (f32::NEG_INFINITY, 0);
    for (o, octet) in a.octets.iter().enumerate() {
        let along = s.add(s.mul(s.load(&octet.nx), px), s.mul(s.load(&octet.ny), py));
        take_greatest(&s.store(s.sub(along, s.load(&octet.offset))), o, a.corners, &mut best, &mut edge);
    }
    if best >= within + b.radius {
        return Manifold::default();
    }
    let next = if edge + 1 == a.corners { 0 } else { edge + 1 };
    let ([nx, ny], p, q) = (a.normal(edge), a.corner(edge), a.corner(next));
    // Along the edge from its first corner.
    let from_p = nx * (cy - p[1]) - ny * (cx - p[0]);
    let to_q = ny * (cx - q[0]) - nx * (cy - q[1]);
    let corner = if best <= 0.0 {
        None
    } else if from_p < 0.0 {
        Some((p, edge))
    } else if to_q < 0.0 {
        Some((q, next))
    } else {
        None
    };
    match corner {
        None => {
            let gap = best - b.radius;
            let back = best - 0.5 * gap;
            let point = Point { x: cx - nx * back, y: cy - ny * back, gap, feature: edge as u32 };
            Manifold::one([nx, ny], point)
        }
        Some((c, i)) => {
            let (dx, dy) = (cx - c[0], cy - c[1]);
            let distance = (dx * dx + dy * dy).sqrt();
            let gap = distance - b.radius;
            if gap >= within {
                return Manifold::default();
            }
            let (nx, ny) = (dx / distance, dy / distance);
            let point = Point { x: c[0] + nx * 0.5 * gap, y: c[1] + ny * 0.5 * gap, gap, feature: 0x8000 | i as u32 };
            Manifold::one([nx, ny], point)
        }
    }
}

/// Greatest separation along the edge normals of `a`, and the edge.
#[inline(always)]
fn face_gap<S: Simd8>(s: S, a: &Placed<'_>, b: &Placed<'_>) -> (f32, usize) {
    let (mut best, mut edge) = (f32::NEG_INFINITY, 0);
    for (o, octet) in a.octets.iter().enumerate() {
        let (nx, ny) = (s.load(&octet.nx), s.load(&octet.ny));
        let mut least = s.splat(f32::INFINITY);
        for v in 0..b.corners {
            let [x, y] = b.corner(v);
            least = s.min(s.add(s.mul(nx, s.splat(x)), s.mul(ny, s.splat(y))), least);
        }
        take_greatest(&s.store(s.sub(least, s.load(&octet.offset))), o, a.corners, &mut best, &mut edge);
    }
    (best, edge)
}

#[inline(always)]
fn take_greatest(values: &[f32; LANES], octet: usize, corners: usize, best: &mut f32, edge: &mut usize) {
    let used = (corners - octet * LANES).min(LANES);
    for (lane, &value) in values.iter().enumerate().take(used) {
        if value > *best {
            *best = value;
            *edge = octet * LANES + lane;
        }
    }
}

#[inline(always)]
fn polygons<S: Simd8>(s: S, a: Placed<'_>, b: Placed<'_>, within: f32) -> Manifold {
    let (gap_a, edge_a) = face_gap(s, &a, &b);
    if gap_a >= within {
        return Manifold::default();
    }
    let (gap_b, edge_b) = face_gap(s, &b, &a);
    if gap_b >= within {
        return Manifold::default();
    }
    if gap_b > gap_a + PREFERENCE {
        clip(s, &b, edge_b, &a, within, 0x8000_0000).flipped()
    } else {
        clip(s, &a, edge_a, &b, within, 0)
    }
}

/// The manifold on the face `edge` of `a`.
#[inline(always)]
fn clip<S: Simd8>(s: S, a: &Placed<'_>, edge: usize, b: &Placed<'_>, within: f32, flag: u32) -> Manifold {
    let [nx, ny] = a.normal(edge);
    let offset = a.offset(edge);
    let next = if edge + 1 == a.corners { 0 } else { edge + 1 };
    let (p, q) = (a.corner(edge), a.corner(next));
    // The edge of `b` that opposes the face most.
    let (mut best, mut facing) = (f32::NEG_INFINITY, 0);
    for (o, octet) in b.octets.iter().enumerate() {
        let against = s.add(s.mul(s.load(&octet.nx), s.splat(-nx)), s.mul(s.load(&octet.ny), s.splat(-ny)));
        take_greatest(&s.store(against), o, b.corners, &mut best, &mut facing);
    }
    let after = if facing + 1 == b.corners { 0 } else { facing + 1 };
    let (u, v) = (b.corner(facing), b.corner(after));
    // Along the face, in the direction from p to q; the opposing edge runs the other way.
    let along = |c: [f32; 2]| nx * c[1] - ny * c[0];
    let (low, high) = (along(p), along(q));
    let (mut t0, mut t1) = (along(v), along(u));
    let mut g0 = nx * v[0] + ny * v[1] - offset;
    let mut g1 = nx * u[0] + ny * u[1] - offset;
    let feature = flag | (edge as u32 & 0x3fff) << 16 | (facing as u32 & 0x7fff) << 1;
    if t0 > high || t1 < low {
        // The faces do not lie opposite each other: corner against corner.
        let (ca, cb) = if t0 > high { (q, v) } else { (p, u) };
        let (dx, dy) = (cb[0] - ca[0], cb[1] - ca[1]);
        let distance = (dx * dx + dy * dy).sqrt();
        let gap = nx * dx + ny * dy;
        if gap > 0.0 && distance > 1e-9 {
            if distance >= within {
                return Manifold::default();
            }
            let middle = Point {
                x: 0.5 * (ca[0] + cb[0]),
                y: 0.5 * (ca[1] + cb[1]),
                gap: distance,
                feature: feature | 0x4000_0000,
            };
            return Manifold::one([dx / distance, dy / distance], middle);
        }
        // Deep overlap of thin pieces: the corner behind the face.
        let point = Point { x: cb[0] - nx * 0.5 * gap, y: cb[1] - ny * 0.5 * gap, gap, feature };
        return Manifold::one([nx, ny], point);
    }
    let width = t1 - t0;
    if width > 0.0 {
        let slope = (g1 - g0) / width;
        if t0 < low {
            g0 += slope * (low - t0);
            t0 = low;
        }
        if t1 > high {
            g1 -= slope * (t1 - high);
            t1 = high;
        }
    }
    let at = |t: f32, gap: f32, end: u32| {
        let out = offset + 0.5 * gap;
        Point { x: nx * out - ny * t, y: ny * out + nx * t, gap, feature: feature | end }
    };
    let (first, second) = (at(t0, g0, 0), at(t1, g1, 1));
    match (g0 < within, g1 < within) {
        // Nearer than a tenth of a millimetre to each other the two would say the same twice.
        (true, true) if t1 - t0 > 1e-4 => Manifold { normal: [nx, ny], points: [first, second], count: 2 },
        (true, true) | (true, false) | (false, true) => Manifold::one([nx, ny], if g0 <= g1 { first } else { second }),
        (false, false) => Manifold::default(),
    }
}
