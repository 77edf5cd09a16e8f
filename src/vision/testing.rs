//! What the tests of this module share.

use super::{Frame, Image, ImageMut, PixelMap, Rasteriser, Region, RegionFinder};
use crate::geom::{Footprint, Pose2, Shape, convex_hull, normalize_angle, vec2};
use crate::run::random::Stream;
use crate::scene::Problem;
use crate::scene::generate::{Generator, GeneratorParams};

/// A generated problem of ten blocks.
pub fn ten(index: u64) -> Problem {
    let params = GeneratorParams { bodies: 10..=10, ..GeneratorParams::default() };
    Generator::new(params, 4).unwrap().problem(index).unwrap()
}

/// Labels and heights of all of a problem's table, at 2 mm.
pub fn camera(problem: &Problem) -> (Frame, Vec<u8>, Vec<f32>) {
    let frame = Frame::new(Pose2::new(0.5, 0.0, 0.0), 0.002, 224, 224);
    let (mut labels, mut heights) = (vec![0; frame.len()], vec![0.0; frame.len()]);
    let (l, h) = (ImageMut::packed(&mut labels, 224, 224), ImageMut::packed(&mut heights, 224, 224));
    Rasteriser::new()
        .labels_and_heights(&problem.scene, &problem.state, &frame, &mut l.unwrap(), &mut h.unwrap())
        .unwrap();
    (frame, labels, heights)
}

/// A convex polygon of random corners.
pub fn polygon(r: &mut Stream) -> Shape {
    let points: Vec<_> = (0..14).map(|_| vec2(r.uniform(-0.04, 0.04), r.uniform(-0.03, 0.03))).collect();
    Shape::ConvexPolygon(convex_hull(&points).iter().map(|p| [p.x, p.y]).collect())
}

/// A footprint's mask at 2 mm, its pixels on either side of the border turned over with a probability.
pub fn region(footprint: &Footprint, pose: &Pose2, noise: f64, r: &mut Stream) -> Region {
    let side = 80;
    let frame = Frame::new(Pose2::new(0.5, 0.0, 0.0), 0.002, side, side);
    let mut mask = vec![0u8; frame.len()];
    let mut image = ImageMut::packed(&mut mask, side, side).unwrap();
    Rasteriser::new().footprint(footprint, pose, &frame, &mut image).unwrap();
    let clean = mask.clone();
    for at in side + 1..side * (side - 1) - 1 {
        let border = [at - 1, at + 1, at - side, at + side].iter().any(|&beside| clean[beside] != clean[at]);
        if border && r.chance(noise) {
            mask[at] = 1 - mask[at];
        }
    }
    let image = Image::packed(&mask, side, side).unwrap();
    RegionFinder::new().mask(&image, &PixelMap::from(&frame)).unwrap().unwrap()
}

/// Distance between the footprint's centres, mm, and the least angle, degrees, by which a pose differs from the true
/// one or from one that looks the same.
pub fn error(footprint: &Footprint, got: &Pose2, truth: &Pose2) -> (f64, f64) {
    let c = footprint.centroid;
    let apart = (got.transform_point(c) - truth.transform_point(c)).norm() * 1e3;
    if matches!(footprint.shape, Shape::Disc { .. }) {
        return (apart, 0.0);
    }
    let turned = normalize_angle(got.theta - truth.theta);
    let same = (0..4).map(|k| f64::from(k) * std::f64::consts::FRAC_PI_2).filter(|&turn| {
        let about = Pose2::at(c - Pose2::new(0.0, 0.0, turn).transform_point(c), turn);
        footprint.iou(&Pose2::IDENTITY, &about) > 0.9999
    });
    let angle = same.map(|turn| normalize_angle(turned - turn).abs()).fold(f64::INFINITY, f64::min);
    (apart, angle.to_degrees())
}
