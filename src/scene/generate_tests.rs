use super::*;
use crate::geom::pieces_gap;
use crate::scene::{LeaveRule, Workspace};

fn params(profile: ArcProfile) -> GeneratorParams {
    GeneratorParams { profile, ..GeneratorParams::default() }
}

/// Least gap between any two bodies.
fn least_gap(problem: &Problem) -> f64 {
    let Problem { scene, state, .. } = problem;
    let mut least = f64::INFINITY;
    for (i, a) in state.iter() {
        for (j, b) in state.iter().filter(|(j, _)| *j > i) {
            least = least.min(pieces_gap(&scene.body(i).footprint, &a, &scene.body(j).footprint, &b));
        }
    }
    least
}

#[test]
fn scenes_are_packed_free_of_overlaps_and_inside() {
    for profile in [ArcProfile::More, ArcProfile::Pmbs] {
        for seed in 0..100 {
            let generator = Generator::new(params(profile), seed).unwrap();
            for index in seed..=seed {
                let problem = generator.problem(index).unwrap();
                let Problem { scene, state, target, .. } = &problem;
                assert!((5..=12).contains(&scene.len()) && *target == 0);
                let gap = least_gap(&problem);
                assert!(gap > 0.0005 && gap < 0.0025, "{}: {gap}", problem.name);
                let strict = Workspace { leave_rule: LeaveRule::Footprint, ..*scene.workspace() };
                for (i, pose) in state.iter() {
                    let body = scene.body(i);
                    assert!(strict.holds(&body.footprint, &pose), "{} {i}", problem.name);
                    // Every body has a neighbour, as near as the bounding polygons are; those of the cylinder and of
                    // the concave block leave room.
                    let loose = |name: &str| name.starts_with('c') && !name.starts_with("cube");
                    let touches = |j: usize| {
                        let other = scene.body(j);
                        let near = if loose(&body.name) || loose(&other.name) { 0.027 } else { 0.0025 };
                        j != i && pieces_gap(&body.footprint, &pose, &other.footprint, &state.pose(j)) < near
                    };
                    assert!((0..scene.len()).any(touches), "{} {i}", problem.name);
                    assert!(body.name.ends_with(&format!(" {i}")));
                }
            }
        }
    }
}

#[test]
fn a_scene_depends_on_seed_and_index_alone() {
    let generator = Generator::new(params(ArcProfile::More), 7).unwrap();
    let (second, first) = (generator.problem(1).unwrap(), generator.problem(0).unwrap());
    let again = Generator::new(params(ArcProfile::More), 7).unwrap();
    for (index, problem) in [(0, &first), (1, &second)] {
        let other = again.problem(index).unwrap();
        assert!(other.state == problem.state && other.scene == problem.scene && other.name == problem.name);
    }
    assert!(first.state != second.state && first.name == "generated-7-0");
    let other_seed = Generator::new(params(ArcProfile::More), 8).unwrap().problem(0).unwrap();
    assert!(other_seed.state != first.state);
}

#[test]
fn numbers_kinds_and_headings_are_spread_as_documented() {
    let generator = Generator::new(params(ArcProfile::More), 3).unwrap();
    let mut sizes = [0usize; 13];
    let mut kinds = std::collections::BTreeMap::new();
    let mut quarters = [0usize; 4];
    let mut total = 0usize;
    for index in 0..300 {
        let Problem { scene, state, .. } = generator.problem(index).unwrap();
        sizes[scene.len()] += 1;
        quarters[((state.pose(0).theta + PI) / (PI / 2.0)) as usize % 4] += 1;
        for body in scene.bodies() {
            let kind = body.name.split(' ').next().unwrap().to_owned();
            *kinds.entry(kind).or_insert(0usize) += 1;
            total += 1;
        }
    }
    assert!(sizes[5..].iter().all(|&n| (15..=65).contains(&n)), "{sizes:?}");
    assert!(quarters.iter().all(|&n| n > 45), "{quarters:?}");
    let part = |kind: &str| kinds.get(kind).copied().unwrap_or(0) as f64 / total as f64;
    for kind in ["cube", "half_cube", "rect", "triangle"] {
        assert!((0.12..0.25).contains(&part(kind)), "{kinds:?}");
    }
    // The sandwich adds two concave blocks and a cylinder.
    assert!((0.12..0.25).contains(&part("concave")) && (0.05..0.15).contains(&part("cylinder")), "{kinds:?}");
    assert_eq!(part("half_cylinder"), 0.0);
}

#[test]
fn the_target_is_enclosed_more_than_the_first_placed() {
    let enclosed = Generator::new(params(ArcProfile::More), 5).unwrap();
    let first = GeneratorParams { target: TargetRule::FirstPlaced, ..params(ArcProfile::More) };
    let first = Generator::new(first, 5).unwrap();
    let mut moved = 0;
    for index in 0..30 {
        let (a, b) = (enclosed.problem(index).unwrap(), first.problem(index).unwrap());
        let bodies: Vec<_> = a.state.iter().map(|(i, pose)| (a.scene.body(i).clone(), pose)).collect();
        // A state's single precision may tip a probe from one side of an edge to the other.
        let parts: Vec<f64> = (0..bodies.len()).map(|i| enclosed_part(&bodies, i)).collect();
        assert!(parts.iter().all(|part| *part <= parts[0] + 0.05), "{parts:?}");
        assert_eq!(a.scene.len(), b.scene.len());
        moved += usize::from(a.state != b.state);
    }
    assert!(moved > 10, "{moved}");
}

#[test]
fn a_filter_keeps_what_it_accepts_in_order() {
    let generator = Generator::new(params(ArcProfile::Pmbs), 1).unwrap();
    let kept = generator.generate_filtered(5, |p| p.scene.len() >= 8).unwrap();
    assert!(kept.len() == 5 && kept.iter().all(|p| p.scene.len() >= 8));
    let indices: Vec<u64> = kept.iter().map(|p| p.name.rsplit('-').next().unwrap().parse().unwrap()).collect();
    assert!(indices.is_sorted());
    assert!(generator.generate_filtered(0, |_| false).unwrap().is_empty());
    let full = GeneratorParams { bodies: 12..=12, ..params(ArcProfile::Pmbs) };
    let full = Generator::new(full, 2).unwrap().generate_filtered(3, |p| p.scene.len() == 12).unwrap();
    assert_eq!(full.len(), 3);
    let few = GeneratorParams { bodies: 1..=1, ..params(ArcProfile::Pmbs) };
    let error = Generator::new(few, 1).unwrap().generate_filtered(1, |_| false).unwrap_err().to_string();
    assert_eq!(error, "the filter kept 0 of 1000 scenes; 1 were asked for");
}

#[test]
fn impossible_parameters_are_refused() {
    let base = || params(ArcProfile::Pmbs);
    for (params, wanted) in [
        (GeneratorParams { bodies: 0..=3, ..base() }, "generator.bodies: is 0..=3; it must be a range within 1..=128"),
        (GeneratorParams { bodies: RangeInclusive::new(5, 4), ..base() }, "generator.bodies: is 5..=4"),
        (GeneratorParams { bodies: 5..=129, ..base() }, "generator.bodies: is 5..=129"),
        (GeneratorParams { gap: [-0.001, 0.0], ..base() }, "generator.gap[0]: is -0.001"),
        (GeneratorParams { gap: [0.002, 0.001], ..base() }, "generator.gap[1]: is 0.001; it must lie in 0.002 to 0.02"),
        (GeneratorParams { gap: [0.001, f64::NAN], ..base() }, "generator.gap[1]: is NaN"),
        (GeneratorParams { midpoint_chance: 1.5, ..base() }, "generator.midpoint_chance: is 1.5"),
    ] {
        let error = Generator::new(params, 0).unwrap_err().to_string();
        assert!(error.starts_with(wanted), "{error}");
    }
    let crowd = GeneratorParams { bodies: 60..=60, ..base() };
    let error = Generator::new(crowd, 0).unwrap().problem(0).unwrap_err().to_string();
    assert!(error.starts_with("generator.bodies: found no room for scene 0 of 60..=60 bodies"), "{error}");
}

#[test]
fn growing_moves_every_side() {
    let square = grown(&rectangle(0.04, 0.02), 0.001);
    assert!(square.iter().zip(rectangle(0.042, 0.022)).all(|(p, q)| (p - q).norm() < 1e-12));
    // Sides that face each other across a line share what lies opposite.
    let other: Vec<Vec2> = square.iter().map(|p| p + vec2(0.032, 0.022)).collect();
    assert!((contact(&square, &other) - 0.010).abs() < 1e-9);
    let corner: Vec<Vec2> = square.iter().map(|p| p + vec2(0.042, 0.022)).collect();
    assert!(contact(&square, &corner) < 1e-9);
}
