use super::*;
use crate::action::Push;
use crate::error::Result;
use crate::geom::{CompoundPart, Piece, Pose2, Shape, Vec2, vec2};
use crate::run::random::Key;
use crate::scene::generate::{Generator, GeneratorParams};
use crate::scene::{BodyDef, MAX_BODIES, Scene, SceneBuilder, State, library};

/// Compares with a committed file; `UPDATE_GOLDEN=1` writes it instead.
fn check_golden(name: &str, text: &str) {
    let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("tests/golden/image_{name}.txt"));
    if std::env::var_os("UPDATE_GOLDEN").is_some() {
        std::fs::write(&path, text).unwrap();
    }
    let wanted = std::fs::read_to_string(&path).unwrap_or_default();
    assert!(wanted == text, "{name} differs from {}; it is now\n{text}", path.display());
}

/// The seven blocks, heights that differ, some overlapping, one outside of most frames.
fn blocks() -> (Scene, State) {
    let mut builder = SceneBuilder::new();
    for (index, name) in library::BLOCKS.into_iter().enumerate() {
        let mut def = library::block(name).unwrap();
        def.height = 0.02 + 0.01 * (index % 4) as f64;
        builder.add_body(def).unwrap();
    }
    let state = State::new([
        Pose2::new(0.50, 0.00, 0.3),
        Pose2::new(0.545, 0.01, 1.1),
        Pose2::new(0.46, 0.06, -0.4),
        Pose2::new(0.50, -0.045, 0.0),
        Pose2::new(0.56, -0.04, 2.2),
        Pose2::new(0.43, -0.03, 0.8),
        Pose2::new(0.54, 0.07, 0.5),
    ]);
    (builder.build().unwrap(), state)
}

fn text(frame: &Frame, labels: &[u8], heights: &[f32]) -> String {
    let mut text = String::new();
    for row in 0..frame.rows {
        let range = row * frame.cols..(row + 1) * frame.cols;
        text.extend(labels[range.clone()].iter().map(|&l| if l == 0 { '.' } else { char::from(b'a' - 1 + l) }));
        text.push(' ');
        text.extend(heights[range].iter().map(|&h| if h == 0.0 { '.' } else { char::from(b'0' + (h * 100.0) as u8) }));
        text.push('\n');
    }
    text
}

fn images(scene: &Scene, state: &State, frame: &Frame) -> Result<(Vec<u8>, Vec<f32>)> {
    let (mut labels, mut heights) = (vec![9; frame.len()], vec![9.0; frame.len()]);
    Rasteriser::new().labels_and_heights(
        scene,
        state,
        frame,
        &mut ImageMut::packed(&mut labels, frame.rows, frame.cols)?,
        &mut ImageMut::packed(&mut heights, frame.rows, frame.cols)?,
    )?;
    Ok((labels, heights))
}

#[test]
fn images_are_as_recorded() {
    let (scene, state) = blocks();
    let push = Push::new(vec2(0.6, 0.02), vec2(0.52, 0.0));
    for (name, frame) in [
        ("whole", Frame::new(Pose2::new(0.5, 0.0, 0.0), 0.004, 56, 64)),
        ("target", Frame::around(&scene, &state, 6, 0.0, 0.003, 40).unwrap()),
        ("turned", Frame::around(&scene, &state, 5, -0.8, 0.003, 40).unwrap()),
        ("push", Frame::along(&push, 0.05, 0.003, 32, 48)),
    ] {
        let (labels, heights) = images(&scene, &state, &frame).unwrap();
        check_golden(name, &text(&frame, &labels, &heights));
    }
}

/// Distance of a point from the border of a piece, metres: nearer than this the rounding decides.
fn from_border(piece: &Piece, p: Vec2) -> f64 {
    match piece {
        Piece::Disc { centre, radius } => ((p - centre).norm() - radius).abs(),
        Piece::Convex(points) => (0..points.len())
            .map(|i| {
                let (a, b) = (points[i], points[(i + 1) % points.len()]);
                let t = ((p - a).dot(&(b - a)) / (b - a).norm_squared()).clamp(0.0, 1.0);
                (p - a - (b - a) * t).norm()
            })
            .fold(f64::INFINITY, f64::min),
    }
}

#[test]
fn every_pixel_shows_the_highest_body_that_holds_its_centre() {
    let compound = Shape::Compound(vec![
        CompoundPart { pose: Pose2::new(0.02, 0.0, 0.5), shape: Shape::rectangle(0.06, 0.01) },
        CompoundPart { pose: Pose2::new(-0.01, 0.01, 0.0), shape: Shape::Disc { radius: 0.015 } },
    ]);
    let mut rasteriser = Rasteriser::new();
    let (mut shown, mut near) = (0, 0);
    for trial in 0..60 {
        let mut r = Key::new(5).child(trial).stream();
        let mut builder = SceneBuilder::new();
        for _ in 0..12 {
            let pick = r.index(8);
            let mut def = match library::BLOCKS.get(pick) {
                Some(name) => library::block(name).unwrap(),
                None => BodyDef::new(compound.clone()),
            };
            def.height = 0.03 + 0.01 * r.index(3) as f64;
            builder.add_body(def).unwrap();
        }
        let scene = builder.build().unwrap();
        let mut state = State::new(
            (0..12).map(|_| Pose2::new(r.uniform(0.35, 0.65), r.uniform(-0.15, 0.15), r.uniform(-3.1, 3.1))),
        );
        state.set_present(3, false);
        let pose = Pose2::new(r.uniform(0.45, 0.55), r.uniform(-0.05, 0.05), r.uniform(-4.0, 4.0));
        let frame = Frame::new(pose, r.uniform(0.0015, 0.006), 20 + r.index(40), 20 + r.index(40));
        let (rows, cols) = (frame.rows, frame.cols);
        let mut labels = vec![0u8; frame.len()];
        let mut heights = vec![0f32; frame.len()];
        let mut image = ImageMut::packed(&mut labels, rows, cols).unwrap();
        rasteriser.labels(&scene, &state, &frame, &mut image).unwrap();
        let mut image = ImageMut::packed(&mut heights, rows, cols).unwrap();
        rasteriser.heights(&scene, &state, &frame, &mut image).unwrap();
        for row in 0..rows {
            for col in 0..cols {
                let p = frame.point(row as f64, col as f64);
                let there = state.iter().filter(|(body, pose)| scene.body(*body).footprint.contains(pose, p));
                let best = there.max_by(|(a, _), (b, _)| {
                    let height = |body: usize| scene.body(body).height;
                    height(*a).total_cmp(&height(*b)).then(b.cmp(a))
                });
                let (want, height) = best.map_or((0, 0.0), |(body, _)| (body as u8 + 1, scene.body(body).height));
                let got = (labels[row * cols + col], heights[row * cols + col]);
                if got == (want, height as f32) {
                    shown += usize::from(want > 0);
                    continue;
                }
                let nearest = state.iter().flat_map(|(body, pose)| {
                    let q = pose.inverse_transform_point(p);
                    scene.body(body).footprint.pieces.iter().map(move |piece| from_border(piece, q))
                });
                let nearest = nearest.fold(f64::INFINITY, f64::min);
                assert!(nearest < 1e-9, "{trial} {row} {col}: {got:?}, not {want} {height}; {nearest} from a border");
                near += 1;
            }
        }
    }
    assert!(shown > 15_000 && near < 5, "{shown} {near}");
}

#[test]
fn borders_count_and_overlaps_go_to_the_higher_then_to_the_earlier_body() {
    let mut builder = SceneBuilder::new();
    for height in [0.03, 0.04, 0.03, 0.03] {
        let mut def = BodyDef::new(Shape::rectangle(0.25, 0.5));
        def.height = height;
        builder.add_body(def).unwrap();
    }
    let scene = builder.build().unwrap();
    // Numbers that are exact in binary: pixels of 1/16, borders on the centres of pixels.
    let at = |x: f64| Pose2::new(x, 0.0, 0.0);
    let state = State::new([at(0.03125), at(0.15625), at(-0.09375), at(0.40625)]);
    let frame = Frame::new(Pose2::IDENTITY, 0.0625, 1, 16);
    let (labels, _) = images(&scene, &state, &frame).unwrap();
    assert_eq!(labels, [0, 0, 0, 0, 3, 3, 1, 1, 2, 2, 2, 2, 2, 4, 4, 4], "{labels:?}");
}

#[test]
fn masks_and_views_say_what_the_labels_say() {
    let problem = Generator::new(GeneratorParams::default(), 3).unwrap().problem(1).unwrap();
    let (scene, state) = (&*problem.scene, &problem.state);
    let frame = Frame::around(scene, state, problem.target, 0.4, 0.002, 112).unwrap();
    let (labels, heights) = images(scene, state, &frame).unwrap();
    let mut rasteriser = Rasteriser::new();
    let mut masks = vec![7u8; scene.len() * frame.len()];
    rasteriser.masks(scene, state, &frame, &mut masks).unwrap();
    for body in 0..scene.len() {
        let mut mask = vec![7.0f32; frame.len()];
        let mut image = ImageMut::packed(&mut mask, frame.rows, frame.cols).unwrap();
        rasteriser.mask(scene, state, body, &frame, &mut image).unwrap();
        for (i, &label) in labels.iter().enumerate() {
            let there = usize::from(label) == body + 1;
            assert_eq!((masks[body * frame.len() + i] == 1, mask[i] == 1.0), (there, there), "{body} {i}");
        }
    }
    let mut foreground = vec![7u8; frame.len()];
    let mut image = ImageMut::packed(&mut foreground, frame.rows, frame.cols).unwrap();
    rasteriser.foreground(scene, state, &frame, &mut image).unwrap();
    let mut view = vec![7f32; 2 * frame.len()];
    rasteriser.target_view(scene, state, problem.target, &frame, &mut view).unwrap();
    for (i, &label) in labels.iter().enumerate() {
        assert_eq!(foreground[i], u8::from(label > 0));
        assert_eq!(view[i], heights[i]);
        assert_eq!(view[frame.len() + i], f32::from(u8::from(usize::from(label) == problem.target + 1)));
    }
    assert!(view[frame.len()..].iter().sum::<f32>() > 100.0, "the target is in its crop");
    // One body alone, which nothing hides.
    let mut alone = vec![7u8; frame.len()];
    let mut image = ImageMut::packed(&mut alone, frame.rows, frame.cols).unwrap();
    let (footprint, pose) = (&scene.body(problem.target).footprint, state.pose(problem.target));
    rasteriser.footprint(footprint, &pose, &frame, &mut image).unwrap();
    let area = alone.iter().map(|&v| f64::from(v)).sum::<f64>() * frame.pixel * frame.pixel;
    assert!((area / footprint.area - 1.0).abs() < 0.03, "{area} {}", footprint.area);
}

#[test]
fn the_mask_of_an_overlap_belongs_to_one_body() {
    let (scene, mut state) = blocks();
    for body in 0..scene.len() {
        state.set_pose(body, Pose2::new(0.5 + 0.003 * body as f64, 0.0, body as f64));
    }
    let frame = Frame::new(Pose2::new(0.5, 0.0, 0.2), 0.002, 60, 70);
    let (labels, _) = images(&scene, &state, &frame).unwrap();
    let mut masks = vec![7u8; scene.len() * frame.len()];
    Rasteriser::new().masks(&scene, &state, &frame, &mut masks).unwrap();
    for (i, &label) in labels.iter().enumerate() {
        for body in 0..scene.len() {
            assert_eq!(masks[body * frame.len() + i], u8::from(usize::from(label) == body + 1));
        }
    }
}

#[test]
fn what_does_not_fit_is_refused_by_name() {
    let (scene, state) = blocks();
    let frame = Frame::new(Pose2::IDENTITY, 0.002, 8, 8);
    let mut data = [0u8; 64];
    let mut r = Rasteriser::new();
    let mut short = ImageMut::packed(&mut data, 8, 7).unwrap();
    let refused = |result: Result<()>| result.unwrap_err().to_string();
    assert!(refused(r.labels(&scene, &state, &frame, &mut short)).starts_with("image: has 8 rows and 7 columns"));
    let mut image = ImageMut::packed(&mut data, 8, 8).unwrap();
    assert!(refused(r.labels(&scene, &State::default(), &frame, &mut image)).starts_with("state: has 0 poses"));
    assert!(refused(r.mask(&scene, &state, 7, &frame, &mut image)).starts_with("body: there is no body 7"));
    assert!(
        refused(r.target_view(&scene, &state, 0, &frame, &mut [0.0; 127])).starts_with("image: its buffer has 127")
    );
    let mut bad = state.clone();
    bad.set_pose(2, Pose2::new(f64::NAN, 0.0, 0.0));
    assert!(refused(r.labels(&scene, &bad, &frame, &mut image)).starts_with("state[2]: is not finite"));
    assert!(Frame::around(&scene, &state, 9, 0.0, 0.002, 8).is_err());
}

#[test]
fn scenes_of_more_bodies_than_labels_have_masks_and_no_labels() {
    let mut builder = SceneBuilder::new();
    for _ in 0..MAX_BODIES {
        builder.add_body(BodyDef::new(Shape::rectangle(0.01, 0.01))).unwrap();
    }
    let scene = builder.build().unwrap();
    let place = |k: usize| Pose2::new(0.012 * (k % 16) as f64, 0.012 * (k / 16) as f64, 0.0);
    let state = State::new((0..MAX_BODIES).map(place));
    let frame = Frame::new(Pose2::new(0.09, 0.09, 0.0), 0.002, 100, 100);
    let mut masks = vec![0u8; scene.len() * frame.len()];
    Rasteriser::new().masks(&scene, &state, &frame, &mut masks).unwrap();
    let counts: Vec<usize> =
        masks.chunks(frame.len()).map(|mask| mask.iter().map(|&pixel| usize::from(pixel)).sum()).collect();
    assert!(counts.iter().all(|&count| (16..=36).contains(&count)), "{counts:?}");
    let mut labels = vec![0u8; frame.len()];
    let mut image = ImageMut::packed(&mut labels, 100, 100).unwrap();
    let error = Rasteriser::new().labels(&scene, &state, &frame, &mut image).unwrap_err().to_string();
    assert!(error.starts_with("scene: has 256 bodies; an image of labels tells 255 apart"), "{error}");
}
