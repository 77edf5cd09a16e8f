use super::testing::{camera, ten};
use super::*;
use crate::geom::{Footprint, Pose2, Shape};
use crate::scene::{Scene, SceneBuilder, State};

fn views<'a>(frame: &Frame, labels: &'a [u8], heights: &'a [f32]) -> (Image<'a, u8>, Image<'a, f32>) {
    let (rows, cols) = (frame.rows, frame.cols);
    (Image::packed(labels, rows, cols).unwrap(), Image::packed(heights, rows, cols).unwrap())
}

/// The share of two bodies' area that they have in common, by an image of half a millimetre.
fn iou(a: (&Footprint, Pose2), b: (&Footprint, Pose2)) -> f64 {
    let frame = Frame::new(Pose2::at(a.1.position(), 0.3), 0.0005, 260, 260);
    let mask = |(footprint, pose): (&Footprint, Pose2)| {
        let mut mask = vec![0u8; frame.len()];
        let mut image = ImageMut::packed(&mut mask, frame.rows, frame.cols).unwrap();
        Rasteriser::new().footprint(footprint, &pose, &frame, &mut image).unwrap();
        mask
    };
    let (a, b) = (mask(a), mask(b));
    let both = a.iter().zip(&b).filter(|(a, b)| **a + **b == 2).count();
    both as f64 / a.iter().zip(&b).filter(|(a, b)| **a + **b > 0).count() as f64
}

#[test]
fn the_scene_of_an_image_is_nearly_the_scene_that_was_seen() {
    let mut corners = std::collections::BTreeMap::new();
    for index in 0..20 {
        let problem = ten(index);
        let (frame, labels, heights) = camera(&problem);
        let (labels, heights) = views(&frame, &labels, &heights);
        let map = PixelMap::from(&frame);
        let shapes = ShapeFinder::new().labels(&labels, Some(&heights), &map, &ShapeOptions::default()).unwrap();
        assert!(shapes.bodies.len() == 10 && shapes.skipped.is_empty(), "{index}: {:?}", shapes.skipped);
        let mut builder = SceneBuilder::new();
        let poses = shapes.add_to(&mut builder).unwrap();
        let scene: Scene = builder.build().unwrap();
        scene.check_state(&State::new(poses.iter().copied())).unwrap();
        for (body, found) in shapes.bodies.iter().enumerate() {
            let truth = problem.scene.body(found.label as usize - 1);
            let made = scene.body(body);
            let same = iou((&truth.footprint, problem.state.pose(body)), (&made.footprint, poses[body]));
            assert!(same > 0.9 && found.deviation[0] < 1.2, "{index} {body}: {same} {found:?}");
            assert!((made.footprint.area / truth.footprint.area - 1.0).abs() < 0.06, "{index} {body}: {found:?}");
            assert!(made.footprint.centroid.norm() < 1e-6, "{:?}", made.footprint.centroid);
            assert!((made.height - truth.height).abs() < 1e-6);
            let (kind, count) = match (&truth.footprint.shape, &found.def.shape) {
                (Shape::Disc { .. }, Shape::Disc { .. }) => ("disc", 0),
                (Shape::ConvexPolygon(wanted), Shape::Polygon(got)) if wanted.len() <= 4 => {
                    ("few", got.len() - wanted.len())
                }
                (_, Shape::Polygon(got)) => ("many", got.len()),
                other => panic!("{index} {body}: {other:?}"),
            };
            let most: &mut usize = corners.entry(kind).or_default();
            *most = count.max(*most);
        }
    }
    // Triangles and rectangles keep their corners, but for a rare one more; the arc of 16 sides becomes one of fewer.
    assert!(corners["few"] <= 2 && corners["many"] <= 14 && corners.contains_key("disc"), "{corners:?}");
}

/// A table of 40 by 40 pixels of 5 mm with a square of 12 pixels.
fn square(at: usize) -> (Frame, Vec<u8>) {
    let frame = Frame::new(Pose2::IDENTITY, 0.005, 40, 40);
    let mut labels = vec![0; frame.len()];
    for row in at..at + 12 {
        labels[row * 40 + at..row * 40 + at + 12].fill(7);
    }
    (frame, labels)
}

#[test]
fn a_square_becomes_its_four_corners_exactly() {
    let (frame, labels) = square(10);
    let image = Image::packed(&labels, 40, 40).unwrap();
    let found = ShapeFinder::new().labels(&image, None, &PixelMap::from(&frame), &ShapeOptions::default()).unwrap();
    let body = &found.bodies[0];
    let Shape::Polygon(corners) = &body.def.shape else { panic!("{body:?}") };
    assert!(corners.len() == 4 && body.label == 7 && body.def.name == "label 7", "{body:?}");
    assert!(corners.iter().flatten().all(|v| (v.abs() - 0.03).abs() < 1e-9), "{corners:?}");
    assert!((body.pose.position() - frame.point(15.5, 15.5)).norm() < 1e-9 && body.def.height == 0.045);
}

#[test]
fn what_is_left_out_is_reported_with_its_reason() {
    let (frame, mut labels) = square(0);
    labels[30 * 40 + 30] = 3;
    for row in 20..26 {
        labels[row * 40 + 5..row * 40 + 11].fill(4);
    }
    let map = PixelMap::from(&frame);
    let heights = vec![f32::NAN; frame.len()];
    let (image, unknown) = views(&frame, &labels, &heights);
    let mut finder = ShapeFinder::new();
    let mut options = ShapeOptions::default();
    let reasons =
        |shapes: &Shapes| -> Vec<_> { shapes.skipped.iter().map(|s| (s.label, s.pixels, s.reason)).collect() };
    let shapes = finder.labels(&image, Some(&unknown), &map, &options).unwrap();
    let wanted = [(3, 1, SkipReason::TooSmall), (4, 36, SkipReason::NoHeight), (7, 144, SkipReason::AtBorder)];
    assert!(shapes.bodies.is_empty() && reasons(&shapes) == wanted, "{shapes:?}");
    options.at_border = AtBorder::Keep;
    options.min_area = 0.0;
    let shapes = finder.labels(&image, None, &map, &options).unwrap();
    // A single pixel has no outline to speak of, even where nothing is too small.
    assert_eq!(reasons(&shapes), [(3, 1, SkipReason::NoOutline)]);
    assert_eq!(shapes.bodies.iter().map(|b| b.label).collect::<Vec<_>>(), [4, 7], "{shapes:?}");
    assert!(shapes.bodies[1].at_border && !shapes.bodies[0].at_border);
    options.at_border = AtBorder::Refuse;
    let error = finder.labels(&image, None, &map, &options).unwrap_err().to_string();
    assert!(error.starts_with("labels[7]: reaches the image's border"), "{error}");
    options.tolerance = f64::NAN;
    assert!(finder.labels(&image, None, &map, &options).unwrap_err().to_string().starts_with("tolerance: "));
    let short = Image::packed(&heights[..40 * 39], 39, 40).unwrap();
    let error = finder.labels(&image, Some(&short), &map, &ShapeOptions::default()).unwrap_err().to_string();
    assert!(error.starts_with("heights: has 39 rows"), "{error}");
}

#[test]
fn the_height_is_a_high_quantile_that_outliers_do_not_move() {
    let (frame, labels) = square(10);
    let mut heights = vec![0.0f32; frame.len()];
    for (i, height) in heights.iter_mut().enumerate() {
        if labels[i] > 0 {
            // A camera smears the border down and has a few wild values.
            *height = match i % 50 {
                0 => f32::INFINITY,
                1 => 0.0,
                2 => 0.4,
                k if k < 20 => 0.03,
                _ => 0.06,
            };
        }
    }
    let (image, heights) = views(&frame, &labels, &heights);
    let map = PixelMap::from(&frame);
    let found = ShapeFinder::new().labels(&image, Some(&heights), &map, &ShapeOptions::default()).unwrap();
    assert!((found.bodies[0].def.height - 0.06).abs() < 1e-6, "{}", found.bodies[0].def.height);
}

#[test]
fn masks_that_overlap_become_bodies_of_their_own() {
    let (frame, labels) = square(10);
    let (_, other) = square(16);
    let empty = vec![0u8; frame.len()];
    let image = |data| Image::packed(data, 40, 40).unwrap();
    let map = PixelMap::from(&frame);
    let masks = [image(&labels), image(&empty), image(&other)];
    let found = ShapeFinder::new().masks(&masks, None, &map, &ShapeOptions::default()).unwrap();
    assert_eq!(found.bodies.iter().map(|b| b.label).collect::<Vec<_>>(), [1, 3]);
    let apart = found.bodies[1].pose.position() - found.bodies[0].pose.position();
    assert!((apart.x - 0.03).abs() < 1e-9 && (apart.y - 0.03).abs() < 1e-9, "{apart:?}");
}
