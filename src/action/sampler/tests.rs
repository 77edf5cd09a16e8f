use super::*;
use crate::geom::{Pose2, Shape, Vec2, pieces_gap, vec2};
use crate::run::Key;
use crate::scene::{BodyDef, SceneBuilder, Workspace};

fn scene_of(shapes: Vec<Shape>) -> Scene {
    let mut b = SceneBuilder::new();
    for shape in shapes {
        b.add_body(BodyDef::new(shape)).unwrap();
    }
    b.build().unwrap()
}

fn cube() -> Shape {
    Shape::rectangle(0.045, 0.045)
}

fn concave() -> Shape {
    Shape::Polygon(vec![
        [-0.045, 0.0225],
        [-0.045, -0.0225],
        [0.045, -0.0225],
        [0.045, 0.0225],
        [0.02, 0.0225],
        [0.015, 0.0],
        [-0.015, 0.0],
        [-0.02, 0.0225],
    ])
}

fn sample(sampler: &dyn PushSampler, scene: &Scene, state: &State, previous: Option<&Push>, seed: u64) -> Vec<Push> {
    let (mut scratch, mut out) = (SamplerScratch::default(), Vec::new());
    sampler.sample(scene, state, 0, previous, &mut Key::new(seed).stream(), &mut scratch, &mut out);
    out
}

fn preset(name: &str) -> ContourSampler {
    ContourSampler::preset(name).unwrap()
}

/// The pushes are, in any order, those from `distance` behind the centre at each angle (degrees).
fn assert_pushes(got: &[Push], centre: Vec2, want: &[(f64, f64)], length: f64) {
    assert_eq!(got.len(), want.len(), "{got:?}");
    for &(angle, distance) in want {
        let d = vec2(angle.to_radians().cos(), angle.to_radians().sin());
        let start = centre - d * distance;
        let found =
            got.iter().any(|p| (p.start() - start).norm() < 1e-8 && (p.end() - (start + d * length)).norm() < 1e-8);
        assert!(found, "none at {angle} deg from {distance}: {got:?}");
    }
}

/// Stand-off from the face and from the corner of the cube: 22.5 mm and 31.8 mm behind the centre.
fn axes_and_diagonals(stand_off: f64) -> Vec<(f64, f64)> {
    let corner = 0.0225 * 2f64.sqrt();
    (0..8).map(|k| (45.0 * k as f64, stand_off + if k % 2 == 0 { 0.0225 } else { corner })).collect()
}

#[test]
fn a_lone_cube_gets_the_pushes_of_each_preset() {
    let scene = scene_of(vec![cube()]);
    let centre = vec2(0.5, 0.0);
    let state = State::new([Pose2::new(0.5, 0.0, 0.0)]);
    assert_pushes(&sample(&preset("dense"), &scene, &state, None, 1), centre, &axes_and_diagonals(0.020), 0.1);
    assert_pushes(&sample(&preset("more"), &scene, &state, None, 1), centre, &axes_and_diagonals(0.020), 0.1);
    assert_pushes(&sample(&preset("pmbs"), &scene, &state, None, 1), centre, &axes_and_diagonals(0.018), 0.05);

    // Contour points every 15 mm: the corners and those 7.5 mm off the middle of a side, 0.32 rad off the axis, where
    // the corner is the farthest in the strip.
    let off = (7.5f64 / 22.5).atan();
    let behind = 0.0225 * (off.sin() + off.cos());
    let mut want = axes_and_diagonals(0.024);
    for k in 0..4 {
        for sign in [-1.0, 1.0] {
            want.push((90.0 * k as f64 + sign * off.to_degrees(), behind + 0.024));
        }
    }
    let got = sample(&preset("vft"), &scene, &state, None, 1);
    assert_pushes(&got, centre, &want, 0.074);
    let on_axis = |p: &Push| (2.0 * p.angle()).sin().abs() < 1e-6;
    assert!(got[..4].iter().all(on_axis) && !got[4..].iter().any(on_axis), "axes come first: {got:?}");
}

#[test]
fn pmbs_agrees_with_its_tables_for_the_rectangle() {
    // Tabulated starts (2 mm pixels; first y, then x) of the 45 x 90 mm block; ours are exact, theirs rounded.
    let table = [[30, 0], [0, 19], [0, -20], [-31, 0], [23, 23], [23, -23], [-23, 23], [-23, -23]];
    let scene = scene_of(vec![Shape::rectangle(0.045, 0.09)]);
    let got = sample(&preset("pmbs"), &scene, &State::new([Pose2::new(0.5, 0.0, 0.0)]), None, 3);
    assert_eq!(got.len(), 8);
    for [y, x] in table {
        let start = vec2(0.5 + 0.002 * f64::from(x), 0.002 * f64::from(y));
        let nearest = got.iter().map(|p| (p.start() - start).norm()).fold(f64::INFINITY, f64::min);
        assert!(nearest < 0.0031, "{x} {y}: {nearest}");
    }
}

#[test]
fn a_rectangle_has_corner_pushes_and_a_disc_none() {
    let scene = scene_of(vec![Shape::rectangle(0.045, 0.09), Shape::Disc { radius: 0.022 }]);
    let state = State::new([Pose2::new(0.4, 0.0, 0.7), Pose2::new(0.6, 0.0, 0.0)]);
    let got = sample(&preset("dense"), &scene, &state, None, 1);
    let of = |body| got.iter().filter(|p| p.body == Some(body)).count();
    assert_eq!((of(0), of(1)), (12, 8));
    let lengths = preset("dense").with_length(0.07).unwrap().with_travel(0.9).unwrap();
    assert!(sample(&lengths, &scene, &state, None, 1).iter().all(|p| (p.length() - 0.063).abs() < 1e-9));
    assert!(preset("dense").with_length(0.0).is_err());
}

#[test]
fn a_rich_set_has_every_length_and_pushes_beside_the_centroid() {
    let scene = scene_of(vec![cube()]);
    let state = State::new([Pose2::new(0.5, 0.0, 0.0)]);
    let plain = sample(&preset("pmbs_contour"), &scene, &state, None, 1);
    let rich = sample(&preset("rich"), &scene, &state, None, 1);
    assert!(plain.iter().all(|p| rich.iter().any(|q| (p.start() - q.start()).norm() < 1e-9 && p.end == q.end)));
    let of_length = |length: f64| rich.iter().filter(|p| (p.length() - length).abs() < 1e-9).count();
    // Four axes and four diagonals of each length, and two pushes beside each axis.
    assert_eq!([of_length(0.03), of_length(0.05), of_length(0.07), rich.len()], [8, 16, 8, 32]);
    let beside = |sign: f64| {
        let start = vec2(0.5 - 0.0225 - 0.018, 0.010 * sign);
        rich.iter().any(|p| (p.start() - start).norm() < 1e-9 && (p.end() - start - vec2(0.05, 0.0)).norm() < 1e-9)
    };
    assert!(beside(1.0) && beside(-1.0), "{rich:?}");
}

#[test]
fn borders_hold_where_each_preset_says() {
    let inside = |p: Vec2, half: f64| (p.x - 0.5).abs() <= half && p.y.abs() <= half;
    let confined = Workspace::rectangle(vec2(0.356, -0.144), vec2(0.644, 0.144));
    for (name, workspace, start, end) in [
        ("vft", Workspace::default(), 0.214, 1.0),
        ("more", Workspace::default(), 0.194, 1.0),
        ("dense", Workspace::default(), 0.224, 1.0),
        ("pmbs", confined, 0.196, 0.196),
    ] {
        let mut b = scene_of(vec![cube()]).to_builder();
        b.workspace(workspace);
        let scene = b.build().unwrap();
        let sampler = preset(name);
        let (mut kept, mut lost) = (0, 0);
        for k in 0..400 {
            let r = |prime: f64| ((k as f64 * prime.sqrt()).fract() - 0.5) * 0.44;
            let state = State::new([Pose2::new(0.5 + r(2.0), r(3.0), 7.0 * r(5.0))]);
            let got = sample(&sampler, &scene, &state, None, 1);
            assert!(got.iter().all(|p| inside(p.start(), start + 1e-12) && inside(p.end(), end + 1e-12)), "{name}");
            kept += got.len();
            lost += 8usize.saturating_sub(got.len());
        }
        assert!(kept > 1000 && lost > 20, "{name}: {kept} {lost}");
    }
    // PMBS, strict: nothing outside the inner square, and a push that would end outside is not moved inside.
    let params = SamplerParams {
        region: Region::Workspace,
        start_inset: 0.0,
        end_inset: Some(0.0),
        ..preset("pmbs").params().clone()
    };
    let mut b = scene_of(vec![cube()]).to_builder();
    b.workspace(confined);
    let scene = b.build().unwrap();
    let strict = ContourSampler::new("pmbs", params).unwrap();
    let got = sample(&strict, &scene, &State::new([Pose2::new(0.62, 0.0, 0.0)]), None, 1);
    assert!(!got.is_empty() && got.iter().all(|p| inside(p.start(), 0.144) && inside(p.end(), 0.144)), "{got:?}");
}

#[test]
fn a_blocked_start_is_moved_back_with_the_whole_push() {
    // A thin wall just behind the cube blocks the first start (29.5 to 55.5 mm behind), not one 10 mm farther back.
    let scene = scene_of(vec![cube(), Shape::rectangle(0.006, 0.03)]);
    let state = State::new([Pose2::new(0.5, 0.0, 0.0), Pose2::new(0.4660, 0.0, 0.0)]);
    let forward = |name: &str| {
        sample(&preset(name), &scene, &state, None, 1)
            .into_iter()
            .find(|p| p.body == Some(0) && (p.direction() - vec2(1.0, 0.0)).norm() < 1e-6)
    };
    let push = forward("dense").unwrap();
    assert!((push.start() - vec2(0.4475, 0.0)).norm() < 1e-7 && (push.length() - 0.1).abs() < 1e-9, "{push:?}");
    let push = forward("pmbs").unwrap();
    assert!((push.start() - vec2(0.4495, 0.0)).norm() < 1e-7 && (push.length() - 0.05).abs() < 1e-9, "{push:?}");
    // The wall a little farther out: the start needs the second retry.
    let state = State::new([Pose2::new(0.5, 0.0, 0.0), Pose2::new(0.4575, 0.0, 0.0)]);
    let got = sample(&preset("dense"), &scene, &state, None, 1);
    let starts: Vec<f64> =
        got.iter().filter(|p| p.body == Some(0) && p.angle().abs() < 1e-6).map(|p| p.start[0]).collect();
    assert!(starts.len() == 1 && (starts[0] - 0.4375).abs() < 1e-7, "{starts:?}");
    assert!(sample(&preset("vft"), &scene, &state, None, 1).iter().all(|p| p.body != Some(0) || p.angle().abs() > 0.1));
}

#[test]
fn vft_continues_the_previous_push_first_and_unchecked() {
    let scene = scene_of(vec![cube(), cube(), cube()]);
    // Body 1 stands right behind the contact: a fresh push could not start there.
    let state = State::new([Pose2::new(0.5, 0.0, 0.3), Pose2::new(0.44, 0.0, 0.0), Pose2::new(0.6, 0.15, 0.0)]);
    let previous = Push::new(vec2(0.39, 0.002), vec2(0.464, 0.002));
    let got = sample(&preset("vft"), &scene, &state, Some(&previous), 4);
    assert!((got[0].direction() - vec2(1.0, 0.0)).norm() < 1e-6 && got[0].body == Some(0), "{:?}", got[0]);
    let without = sample(&preset("vft"), &scene, &state, None, 4);
    assert_eq!(without.len() + 1, got.len());
    assert!(without.iter().all(|p| p.body != Some(0) || p.angle().abs() > 1e-6));
    // Out of reach, or another sampler: nothing is added.
    let far = Push::new(vec2(0.3, -0.2), vec2(0.35, -0.2));
    assert_eq!(sample(&preset("vft"), &scene, &state, Some(&far), 4), without);
    assert_eq!(
        sample(&preset("more"), &scene, &state, Some(&previous), 4),
        sample(&preset("more"), &scene, &state, None, 4)
    );
}

/// Bodies thrown close together without overlap.
fn packed(seed: u64) -> (Scene, State) {
    let shapes = vec![
        Shape::Disc { radius: 0.022 },
        concave(),
        Shape::rectangle(0.045, 0.09),
        cube(),
        Shape::ConvexPolygon(vec![[0.0225, 0.045], [-0.0225, 0.0], [0.0225, -0.045]]),
        Shape::rectangle(0.0225, 0.045),
        concave(),
    ];
    let scene = scene_of(shapes);
    let mut rng = Key::new(seed).stream();
    let mut poses: Vec<Pose2> = Vec::new();
    for body in scene.bodies() {
        let mut spread = 0.04;
        loop {
            spread += 0.0005;
            let pose =
                Pose2::new(0.5 + rng.uniform(-spread, spread), rng.uniform(-spread, spread), rng.uniform(-3.0, 3.0));
            let free = poses
                .iter()
                .zip(scene.bodies())
                .all(|(p, b)| pieces_gap(&b.footprint, p, &body.footprint, &pose) > 1e-4);
            if free {
                poses.push(pose);
                break;
            }
        }
    }
    (scene, State::new(poses))
}

#[test]
fn starts_are_clear_of_every_body_by_point_sampling() {
    let mut pushes = 0;
    for seed in 0..12 {
        let (scene, state) = packed(seed);
        for name in NAMES {
            let sampler = preset(name).prepared(&scene);
            for push in sample(&sampler, &scene, &state, None, seed) {
                pushes += 1;
                let d = push.direction();
                let near: Vec<_> = state.iter().filter(|(_, p)| (p.position() - push.start()).norm() < 0.08).collect();
                // The tip with its clearance of 2 mm, shrunk by what single precision leaves.
                for i in 0..=13 {
                    for j in 0..=17 {
                        let (x, y) = (0.0129999 * (i as f64 / 6.5 - 1.0), 0.0169999 * (j as f64 / 8.5 - 1.0));
                        let p = push.start() + vec2(d.x * x - d.y * y, d.y * x + d.x * y);
                        for (body, pose) in &near {
                            assert!(!scene.body(*body).footprint.contains(pose, p), "{name} {seed} {push:?} {body}");
                        }
                    }
                }
            }
        }
    }
    assert!(pushes > 800, "{pushes}");
}

#[test]
fn a_scratch_and_a_preparation_change_nothing() {
    let (mut scratch, mut out) = (SamplerScratch::default(), vec![Push::default(); 3]);
    let (other, _) = packed(99);
    for seed in 0..10 {
        let (scene, state) = packed(seed);
        for name in NAMES {
            let plain = sample(&preset(name), &scene, &state, None, seed);
            preset(name).prepare(&scene).sample(
                &scene,
                &state,
                0,
                None,
                &mut Key::new(seed).stream(),
                &mut scratch,
                &mut out,
            );
            assert_eq!(plain, out);
            // Prepared for one scene, used on another.
            let wrong = preset(name).prepared(&scene_of(vec![cube(), cube()]));
            assert_eq!(sample(&wrong, &scene, &state, None, seed), plain);
            assert_eq!(sample(&preset(name).prepared(&other), &scene, &state, None, seed), plain);
        }
    }
}

#[test]
fn the_seed_decides_the_order_and_nothing_else() {
    let (scene, state) = packed(5);
    for name in NAMES {
        let sampler = preset(name);
        let (a, b, c) = (
            sample(&sampler, &scene, &state, None, 1),
            sample(&sampler, &scene, &state, None, 1),
            sample(&sampler, &scene, &state, None, 2),
        );
        assert_eq!(a, b);
        assert_ne!(a, c);
        let sorted = |mut v: Vec<Push>| {
            v.sort_by(|p, q| (p.start, p.end).partial_cmp(&(q.start, q.end)).unwrap());
            v
        };
        assert_eq!(sorted(a), sorted(c));
    }
}

#[test]
fn absent_and_fixed_bodies_are_not_aimed_at() {
    let mut b = SceneBuilder::new();
    b.add_body(BodyDef::new(cube())).unwrap();
    b.add_body(BodyDef { pushable: false, ..BodyDef::new(cube()) }).unwrap();
    b.add_body(BodyDef::new(cube())).unwrap();
    let scene = b.build().unwrap();
    // Body 1 blocks pushes at body 0 from one side; body 2 would from the other, were it there.
    let mut state = State::new([Pose2::new(0.5, 0.0, 0.0), Pose2::new(0.455, 0.0, 0.0), Pose2::new(0.545, 0.0, 0.0)]);
    state.set_present(2, false);
    for name in NAMES {
        let got = sample(&preset(name), &scene, &state, None, 1);
        assert!(!got.is_empty() && got.iter().all(|p| p.body == Some(0)), "{name}");
        let along = |sign: f64| got.iter().any(|p| (p.direction() - vec2(sign, 0.0)).norm() < 1e-6);
        assert!(along(-1.0) && !along(1.0), "{name}: {got:?}");
    }
}

#[test]
fn more_turns_to_another_direction_where_one_is_blocked() {
    let scene = scene_of(vec![cube(), Shape::rectangle(0.09, 0.03)]);
    // The wall covers one side of the cube but leaves its ends free.
    let state = State::new([Pose2::new(0.5, 0.0, 0.0), Pose2::new(0.5, -0.04, 0.0)]);
    let got = sample(&preset("more"), &scene, &state, None, 1);
    let angles: Vec<f64> = got.iter().filter(|p| p.body == Some(0)).map(Push::angle).collect();
    assert!(angles.iter().all(|a| (a - std::f64::consts::FRAC_PI_2).abs() > 0.3), "{angles:?}");
    for (i, a) in angles.iter().enumerate() {
        for b in &angles[i + 1..] {
            assert!(crate::geom::normalize_angle(a - b).abs() > 0.74, "{angles:?}");
        }
    }
}

#[test]
fn names_and_bad_parameters_are_reported() {
    for name in NAMES {
        assert_eq!(by_name(name).unwrap().name(), name);
    }
    let error = by_name("best").err().unwrap().to_string();
    assert_eq!(error, "sampler: no sampler is named `best`; known: vft, more, pmbs, pmbs_contour, dense, rich");
    let bad = |params: SamplerParams| params.validate().unwrap_err().to_string();
    assert!(bad(SamplerParams { length: -1.0, ..SamplerParams::default() }).starts_with("sampler.length: is -1"));
    assert!(
        bad(SamplerParams { back_off: vec![0.0, f64::NAN], ..SamplerParams::default() })
            .starts_with("sampler.back_off[1]")
    );
    let none = SamplerParams { axes: false, diagonals: false, corners: None, ..SamplerParams::default() };
    assert!(bad(none).starts_with("sampler.axes"));
    for name in NAMES {
        let params = preset(name).params().clone();
        let text = serde_json::to_string(&params).unwrap();
        assert_eq!(serde_json::from_str::<SamplerParams>(&text).unwrap(), params, "{text}");
    }
    let part: SamplerParams =
        serde_json::from_str(r#"{"region": {"grown": {"by": 0.08}}, "end_inset": 0.028}"#).unwrap();
    assert_eq!((part.region, part.end_inset), (Region::Grown { by: 0.08 }, Some(0.028)));
}
