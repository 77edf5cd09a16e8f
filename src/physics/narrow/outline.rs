//! Convex pieces as the narrow phase wants them.

use crate::geom::{Piece, Vec2};
use crate::physics::lanes::{LANES, Simd8};

/// Eight corners of a convex polygon, each with the edge that begins there. Metres.
#[derive(Debug, Clone, Copy, PartialEq)]
#[repr(C, align(32))]
pub struct Octet {
    pub x: [f32; LANES],
    pub y: [f32; LANES],
    /// Outward unit normals of the edges.
    pub nx: [f32; LANES],
    pub ny: [f32; LANES],
    /// The edge lies where the product of its normal with a point is this.
    pub offset: [f32; LANES],
}

impl Octet {
    pub const ZERO: Octet = Octet { x: [0.0; 8], y: [0.0; 8], nx: [0.0; 8], ny: [0.0; 8], offset: [0.0; 8] };
}

/// A position and a direction.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Frame2 {
    pub x: f32,
    pub y: f32,
    pub cos: f32,
    pub sin: f32,
}

impl Frame2 {
    #[inline(always)]
    pub fn vector(&self, x: f32, y: f32) -> [f32; 2] {
        [self.cos * x - self.sin * y, self.sin * x + self.cos * y]
    }

    #[inline(always)]
    pub fn point(&self, x: f32, y: f32) -> [f32; 2] {
        let [x, y] = self.vector(x, y);
        [self.x + x, self.y + y]
    }
}

/// A convex piece in its body's frame: a polygon of any number of corners, or a disc. The last octet of a polygon is
/// filled up with the first corner, which changes no extent.
#[derive(Debug, Clone, PartialEq)]
pub struct Outline {
    pub octets: Vec<Octet>,
    /// Corners of the polygon, counter-clockwise; 0 for a disc.
    pub corners: usize,
    /// The middle of the bounding circle; a disc's centre.
    pub centre: [f32; 2],
    /// Of the bounding circle; a disc's own. Metres.
    pub radius: f32,
}

impl Outline {
    pub fn new(piece: &Piece) -> Outline {
        match piece {
            Piece::Disc { centre, radius } => Outline {
                octets: Vec::new(),
                corners: 0,
                centre: [centre.x as f32, centre.y as f32],
                radius: *radius as f32,
            },
            Piece::Convex(points) => Outline::polygon(points),
        }
    }

    /// A convex polygon, corners counter-clockwise.
    pub fn polygon(points: &[Vec2]) -> Outline {
        let n = points.len();
        let mut octets = vec![Octet::ZERO; n.div_ceil(LANES)];
        for k in 0..octets.len() * LANES {
            let i = if k < n { k } else { 0 };
            let (p, q) = (points[i], points[(i + 1) % n]);
            let along = (q - p).normalize();
            let octet = &mut octets[k / LANES];
            let lane = k % LANES;
            octet.x[lane] = p.x as f32;
            octet.y[lane] = p.y as f32;
            octet.nx[lane] = along.y as f32;
            octet.ny[lane] = -along.x as f32;
            octet.offset[lane] = (along.y * p.x - along.x * p.y) as f32;
        }
        let low = points.iter().fold(points[0], |a, b| a.inf(b));
        let high = points.iter().fold(points[0], |a, b| a.sup(b));
        let middle = (low + high) / 2.0;
        let radius = points.iter().map(|p| (p - middle).norm()).fold(0.0, f64::max);
        // Rounded up, so that the circle holds the polygon in single precision too.
        Outline {
            octets,
            corners: n,
            centre: [middle.x as f32, middle.y as f32],
            radius: (radius * (1.0 + 1e-6)) as f32,
        }
    }

    /// Writes the octets at a place in the world into `placed`, which has as many, and gives the placed centre.
    #[inline(never)]
    pub fn place<S: Simd8>(&self, s: S, frame: &Frame2, placed: &mut [Octet]) -> [f32; 2] {
        s.vectorize(
            #[inline(always)]
            || self.place_octets(s, frame, placed),
        );
        frame.point(self.centre[0], self.centre[1])
    }

    #[inline(always)]
    fn place_octets<S: Simd8>(&self, s: S, frame: &Frame2, placed: &mut [Octet]) {
        let (cos, sin) = (s.splat(frame.cos), s.splat(frame.sin));
        let (ox, oy) = (s.splat(frame.x), s.splat(frame.y));
        for (local, out) in self.octets.iter().zip(placed) {
            let (x, y) = (s.load(&local.x), s.load(&local.y));
            let (nx, ny) = (s.load(&local.nx), s.load(&local.ny));
            let px = s.add(ox, s.sub(s.mul(cos, x), s.mul(sin, y)));
            let py = s.add(oy, s.add(s.mul(sin, x), s.mul(cos, y)));
            let mx = s.sub(s.mul(cos, nx), s.mul(sin, ny));
            let my = s.add(s.mul(sin, nx), s.mul(cos, ny));
            out.x = s.store(px);
            out.y = s.store(py);
            out.nx = s.store(mx);
            out.ny = s.store(my);
            out.offset = s.store(s.add(s.mul(mx, px), s.mul(my, py)));
        }
    }
}

/// A piece at a place in the world.
#[derive(Debug, Clone, Copy)]
pub struct Placed<'a> {
    pub octets: &'a [Octet],
    /// 0 for a disc.
    pub corners: usize,
    pub centre: [f32; 2],
    pub radius: f32,
}

impl Placed<'_> {
    #[inline(always)]
    pub fn corner(&self, i: usize) -> [f32; 2] {
        let octet = &self.octets[i / LANES];
        [octet.x[i % LANES], octet.y[i % LANES]]
    }

    #[inline(always)]
    pub fn normal(&self, i: usize) -> [f32; 2] {
        let octet = &self.octets[i / LANES];
        [octet.nx[i % LANES], octet.ny[i % LANES]]
    }

    #[inline(always)]
    pub fn offset(&self, i: usize) -> f32 {
        self.octets[i / LANES].offset[i % LANES]
    }
}
