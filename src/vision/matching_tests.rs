use super::testing::{camera, error, polygon, region, ten};
use super::*;
use crate::geom::{Footprint, Pose2, Shape};
use crate::run::random::Key;
use crate::scene::library;

const TRIALS: usize = 200;

/// Distances (mm) and angles (degrees) of many poses, sorted, and the share of poses within the limits.
fn trials(kind: usize, noise: f64, limit: (f64, f64)) -> (Vec<f64>, Vec<f64>, f64) {
    let (mut distances, mut angles, mut good) = (Vec::new(), Vec::new(), 0);
    for trial in 0..TRIALS {
        let mut r = Key::new(77 + kind as u64).child(trial as u64).stream();
        let shape = match library::BLOCKS.get(kind) {
            Some(name) => library::block(name).unwrap().shape,
            None => polygon(&mut r),
        };
        let footprint = Footprint::new(shape).unwrap();
        let truth = Pose2::new(r.uniform(0.49, 0.51), r.uniform(-0.01, 0.01), r.uniform(-3.1, 3.1));
        let region = region(&footprint, &truth, noise, &mut r);
        let found = Matcher::new([&footprint], MatchOptions::default()).unwrap().pose(0, &region).unwrap();
        let (distance, angle) = error(&footprint, &found.pose, &truth);
        good += usize::from(distance <= limit.0 && angle <= limit.1);
        distances.push(distance);
        angles.push(angle);
    }
    distances.sort_by(f64::total_cmp);
    angles.sort_by(f64::total_cmp);
    (distances, angles, good as f64 / TRIALS as f64)
}

fn check(noise: f64, limit: (f64, f64), least: impl Fn(usize) -> f64) {
    let at = |v: &[f64], q: f64| v[((v.len() - 1) as f64 * q) as usize];
    for kind in 0..=library::BLOCKS.len() {
        let (mm, degrees, share) = trials(kind, noise, limit);
        let name = library::BLOCKS.get(kind).unwrap_or(&"polygon");
        let text = format!(
            "{name}, noise {noise}: {:.1} % within {} mm and {} degrees; median {:.2} mm {:.2} degrees, 95 % {:.2} {:.2}, all {:.2} {:.2}",
            share * 100.0,
            limit.0,
            limit.1,
            at(&mm, 0.5),
            at(&degrees, 0.5),
            at(&mm, 0.95),
            at(&degrees, 0.95),
            at(&mm, 1.0),
            at(&degrees, 1.0)
        );
        println!("{text}");
        assert!(share >= least(kind), "{text}");
        assert!(at(&mm, 1.0) <= limit.0, "{text}");
    }
}

/// Of the two smallest blocks (22 mm across: 11 pixels) several headings give the same mask.
fn small(kind: usize) -> bool {
    matches!(library::BLOCKS.get(kind), Some(&("half_cube" | "half_cylinder")))
}

#[test]
fn clean_masks_give_poses_within_a_millimetre_and_a_degree() {
    check(0.0, (1.0, 1.0), |kind| if small(kind) { 0.93 } else { 0.99 });
}

#[test]
fn noisy_edges_give_poses_within_two_millimetres_and_two_degrees() {
    check(0.2, (2.0, 2.0), |kind| if small(kind) { 0.88 } else { 0.98 });
}

#[test]
fn ten_blocks_are_told_apart_and_found() {
    for index in 0..20 {
        let problem = ten(index);
        let (frame, labels, _) = camera(&problem);
        let image = Image::packed(&labels, frame.rows, frame.cols).unwrap();
        let regions = RegionFinder::new().labels(&image, &PixelMap::from(&frame)).unwrap();
        let shapes = problem.scene.bodies().iter().map(|body| &body.footprint);
        let found = Matcher::new(shapes, MatchOptions::default()).unwrap().assign(&regions);
        let mut taken = vec![false; regions.len()];
        for (body, found) in found.iter().enumerate() {
            let (region, found) = found.unwrap();
            assert!(!std::mem::replace(&mut taken[region], true), "{index}: region {region} twice");
            // Of equal blocks any may be meant.
            let shown = regions[region].label as usize - 1;
            let footprint = &problem.scene.body(shown).footprint;
            assert_eq!(footprint.shape, problem.scene.body(body).footprint.shape, "{index} {body} {shown}");
            let (mm, degrees) = error(footprint, &found.pose, &problem.state.pose(shown));
            assert!(mm < 1.0 && degrees < 3.0, "{index} {body}: {mm} mm {degrees} degrees {found:?}");
        }
    }
}

#[test]
fn what_is_not_there_is_not_found() {
    let [cube, disc] =
        [Shape::rectangle(0.045, 0.045), Shape::Disc { radius: 0.022 }].map(|s| Footprint::new(s).unwrap());
    let mut r = Key::new(3).stream();
    let seen = region(&cube, &Pose2::new(0.5, 0.0, 0.2), 0.0, &mut r);
    let mut matcher = Matcher::new([&disc, &cube, &cube], MatchOptions::default()).unwrap();
    let found = matcher.assign(std::slice::from_ref(&seen));
    assert!(found[0].is_none() && found.iter().flatten().count() == 1, "{found:?}");
    assert!(matcher.assign(&[]).iter().all(Option::is_none));
    assert!(matcher.pose(3, &seen).unwrap_err().to_string().starts_with("shape: there is no shape 3"));
    assert!(Matcher::new([&cube], MatchOptions { greatest_cost: f64::NAN }).is_err());
    // Fitted all the same when asked for, and rated badly.
    let (good, bad) = (matcher.pose(1, &seen).unwrap(), matcher.pose(0, &seen).unwrap());
    assert!(good.cost < 0.6 && bad.cost > 2.0, "{good:?} {bad:?}");
}

#[test]
fn a_compound_and_a_body_whose_frame_is_elsewhere_are_found() {
    use crate::geom::CompoundPart;
    let hammer = Footprint::new(Shape::Compound(vec![
        CompoundPart { pose: Pose2::new(0.05, 0.0, 0.0), shape: Shape::rectangle(0.02, 0.05) },
        CompoundPart { pose: Pose2::new(0.0, 0.0, 0.0), shape: Shape::rectangle(0.08, 0.015) },
    ]))
    .unwrap();
    for trial in 0..20 {
        let mut r = Key::new(9).child(trial).stream();
        let truth = Pose2::new(0.5 - 0.01, 0.0, r.uniform(-3.1, 3.1));
        let seen = region(&hammer, &truth, 0.0, &mut r);
        let found = Matcher::new([&hammer], MatchOptions::default()).unwrap().pose(0, &seen).unwrap();
        let (mm, degrees) = error(&hammer, &found.pose, &truth);
        assert!(mm < 1.0 && degrees < 1.0, "{trial}: {mm} {degrees} {found:?}");
    }
}
