use super::*;
use crate::action::Grasp;
use crate::geom::{Footprint, Pose2, Shape, Vec2, pieces_gap, vec2};
use crate::run::{Key, Stop, Stream};
use crate::scene::{BodyDef, Gripper, Scene, SceneBuilder, State};

const MM: f64 = 1e-3;

fn cube() -> Shape {
    Shape::rectangle(0.045, 0.045)
}

fn triangle() -> Shape {
    Shape::ConvexPolygon(vec![[0.0225, 0.045], [-0.0225, 0.0], [0.0225, -0.045]])
}

fn scene_with(gripper: Gripper, shapes: Vec<Shape>) -> Scene {
    let mut b = SceneBuilder::new();
    b.gripper(gripper);
    for shape in shapes {
        b.add_body(BodyDef::new(shape)).unwrap();
    }
    b.build().unwrap()
}

fn scene_of(shapes: Vec<Shape>) -> Scene {
    scene_with(Gripper::robotiq_2f85(), shapes)
}

fn test_for(scene: &Scene) -> GraspTest {
    GraspTest::new(GraspParams::default()).unwrap().prepared(scene)
}

fn best(scene: &Scene, state: &State, body: usize) -> Option<Grasp> {
    test_for(scene).best(scene, state, body, &mut GraspScratch::default())
}

fn at(x: f64, y: f64, theta: f64) -> Pose2 {
    Pose2::new(0.5 + x, y, theta)
}

fn grasp(body: usize, x: f64, y: f64, angle: f64) -> Grasp {
    Grasp { body, position: [0.5 + x, y], angle, opening: 0.0807, ..Grasp::default() }
}

fn check(scene: &Scene, state: &State, grasp: &Grasp) -> GraspCheck {
    test_for(scene).check(scene, state, grasp, &mut GraspScratch::default())
}

/// Angle between two closing directions.
fn apart(a: f64, b: f64) -> f64 {
    let d = (a - b).rem_euclid(std::f64::consts::PI);
    d.min(std::f64::consts::PI - d)
}

#[test]
fn lone_bodies_score_as_the_simulated_robot_held_them() {
    let lone = |shape: Shape| {
        let scene = scene_of(vec![shape]);
        best(&scene, &State::new([at(0.0, 0.0, 0.4)]), 0)
    };
    let half_cylinder: Vec<[f64; 2]> = (0..=16)
        .map(|i| std::f64::consts::PI * (1.0 + i as f64 / 16.0))
        .map(|a| [0.022 * a.cos(), 0.011 + 0.022 * a.sin()])
        .collect();
    for shape in [
        cube(),
        Shape::Disc { radius: 0.022 },
        Shape::rectangle(0.045, 0.09),
        triangle(),
        Shape::ConvexPolygon(half_cylinder),
    ] {
        let g = lone(shape.clone()).unwrap();
        assert!(g.score > 0.95 && g.margin > 5.0 * MM, "{shape:?}: {g:?}");
        assert!((vec2(g.position[0], g.position[1]) - vec2(0.5, 0.0)).norm() < 12.0 * MM, "{shape:?}: {g:?}");
    }
    let g = lone(Shape::rectangle(0.045, 0.09)).unwrap();
    assert!(apart(g.angle, 0.4) < 1e-6 && (g.width - 0.045).abs() < 1e-9, "across the short side: {g:?}");
    let g = lone(triangle()).unwrap();
    assert!(apart(g.angle, 0.4) < 1e-6, "apex against hypotenuse: {g:?}");
}

#[test]
fn faces_out_of_parallel_or_short_or_too_wide_are_told() {
    let one = |shape: Shape| scene_of(vec![shape]);
    let state = State::new([at(0.0, 0.0, 0.0)]);
    let quarter = std::f64::consts::FRAC_PI_2;
    // Along the triangle's long side the legs stand at right angles. (Near the apex it fits the opening.)
    let c = check(&one(triangle()), &state, &grasp(0, -0.008, 0.0, quarter));
    assert!(!c.holds() && c.limit == Limit::Wedge && (c.wedge - quarter).abs() < 1e-6 && c.score == 0.0, "{c:?}");
    // Rectangle by its 90 mm side.
    let c = check(&one(Shape::rectangle(0.045, 0.09)), &state, &grasp(0, 0.0, 0.0, quarter));
    assert!(!c.holds() && c.limit == Limit::Width && (c.width - 0.09).abs() < 1e-6, "{c:?}");
    assert!((c.margin - ((0.0807 - 0.09) / 2.0 - 0.00125)).abs() < 1e-7, "{c:?}");
    // A wedge of 20 degrees scores less than parallel faces.
    let (a, h) = (10f64.to_radians().tan() * 0.03, 0.02);
    let wedge = Shape::ConvexPolygon(vec![[-h - a, -0.03], [h + a, -0.03], [h - a, 0.03], [-h + a, 0.03]]);
    let c = check(&one(wedge), &state, &grasp(0, 0.0, 0.0, 0.0));
    assert!(c.holds() && (c.wedge.to_degrees() - 20.0).abs() < 1e-6 && (0.5..0.8).contains(&c.score), "{c:?}");
    // Parallel faces at an angle to the pads have no wedge.
    let c = check(&one(Shape::rectangle(0.04, 0.12)), &state, &grasp(0, 0.0, 0.0, 0.15));
    assert!(c.holds() && c.wedge < 1e-9 && c.score > 0.9, "{c:?}");
    // A small face: the half-cube by its 22.5 mm side held 14 of 24.
    let half = one(Shape::rectangle(0.0225, 0.045));
    let (small, large) =
        (check(&half, &state, &grasp(0, 0.0, 0.0, quarter)), check(&half, &state, &grasp(0, 0.0, 0.0, 0.0)));
    assert!((small.score - 14.0 / 24.0).abs() < 0.02 && large.score > 0.99, "{small:?} {large:?}");
    // Pads that cover too little of it; pads beside it.
    let c = check(&half, &state, &grasp(0, 0.0, 0.025, 0.0));
    assert!(!c.holds() && c.limit == Limit::Cover && (c.margin + 3.5 * MM).abs() < 1e-7, "{c:?}");
    assert_eq!(check(&half, &state, &grasp(0, 0.0, 0.04, 0.0)).limit, Limit::Missing);
    assert_eq!(check(&half, &state, &Grasp { opening: f64::NAN, ..grasp(0, 0.0, 0.0, 0.0) }).limit, Limit::Missing);
    // A disc off the pads' middle is gripped on slanting faces.
    let disc = one(Shape::Disc { radius: 0.022 });
    let c = check(&disc, &state, &grasp(0, 0.0, 0.016, 0.0));
    assert!((c.wedge - 2.0 * (5.0f64 / 22.0).asin()).abs() < 1e-6 && c.holds(), "{c:?}");
    assert!(check(&disc, &state, &grasp(0, 0.0, 0.0, 0.0)).wedge < 1e-9);
}

#[test]
fn a_cube_with_flush_neighbours_is_not_graspable() {
    let scene = scene_of(vec![cube(); 5]);
    let state = State::new([
        at(0.0, 0.0, 0.0),
        at(0.045, 0.0, 0.0),
        at(-0.045, 0.0, 0.0),
        at(0.0, 0.045, 0.0),
        at(0.0, -0.045, 0.0),
    ]);
    assert_eq!(best(&scene, &state, 0), None);
    let mut open = state.clone();
    open.set_present(1, false);
    open.set_present(2, false);
    let g = best(&scene, &open, 0).unwrap();
    assert!(apart(g.angle, 0.0) < 1e-6, "{g:?}");
    let c = check(&scene, &state, &grasp(0, 0.0, 0.0, 0.0));
    assert!(matches!(c.limit, Limit::Jaw { body: 1 | 2 } | Limit::Finger { body: 1 | 2 }) && !c.holds(), "{c:?}");
}

/// A cube in a corridor: walls at `gap` from its sides in x, long blocks flush in y.
fn corridor(gap: f64) -> (Scene, State) {
    let wall = || Shape::rectangle(0.02, 0.3);
    let long = || Shape::rectangle(0.06, 0.1);
    let scene = scene_of(vec![cube(), wall(), wall(), long(), long()]);
    let x = 0.0225 + gap + 0.01;
    let state =
        State::new([at(0.0, 0.0, 0.0), at(x, 0.0, 0.0), at(-x, 0.0, 0.0), at(0.0, 0.0725, 0.0), at(0.0, -0.0725, 0.0)]);
    (scene, state)
}

#[test]
fn a_gap_just_wide_enough_decides() {
    // Fingers reach to 80.7/2 + 15 + 1 mm from the middle.
    let enough = 0.0807 / 2.0 + 0.016 - 0.0225;
    let (scene, state) = corridor(enough + 0.1 * MM);
    let g = best(&scene, &state, 0).unwrap();
    assert!((g.margin - 0.1 * MM).abs() < 1e-6, "{g:?}");
    assert!(g.score < 0.52, "a knife's edge is worth half: {g:?}");
    let c = check(&scene, &state, &g);
    assert!(matches!(c.limit, Limit::Finger { body: 1 | 2 }) && c.holds(), "{c:?}");
    let (scene, state) = corridor(enough - 0.1 * MM);
    assert_eq!(best(&scene, &state, 0), None);
    let c = check(&scene, &state, &grasp(0, 0.0, 0.0, 0.0));
    assert!((c.margin + 0.1 * MM).abs() < 1e-6 && !c.holds(), "{c:?}");
    // A narrower opening lets the fingers in.
    let params = GraspParams { pre_openings: vec![0.0807, 0.07, 0.055], ..GraspParams::default() };
    let chosen = GraspTest::new(params).unwrap().best(&scene, &state, 0, &mut GraspScratch::default()).unwrap();
    assert!(chosen.opening < 0.08 && chosen.score > 0.9, "{chosen:?}");
}

#[test]
fn the_jaw_strip_but_for_the_pad_edges_must_be_empty() {
    // A small block beside the target, in the way of the closing pads but clear of the open fingers.
    let scene = scene_of(vec![cube(), Shape::rectangle(0.01, 0.04)]);
    let beside = |y: f64| State::new([at(0.0, 0.0, 0.0), at(0.03, y, 0.0)]);
    for (edge, holds) in [(8.1, true), (7.9, false)] {
        let c = check(&scene, &beside(edge * MM + 0.02), &grasp(0, 0.0, 0.0, 0.0));
        assert!(c.holds() == holds && (c.margin - (edge - 8.0) * MM).abs() < 1e-6, "{edge}: {c:?}");
        assert_eq!(c.limit, Limit::Jaw { body: 1 });
    }
    // Off the middle the jaw makes room between two obstacles.
    let scene = scene_of(vec![Shape::rectangle(0.02, 0.045), Shape::rectangle(0.02, 0.3), Shape::rectangle(0.02, 0.3)]);
    let state = State::new([at(0.0, 0.0, 0.0), at(0.085, 0.0, 0.0), at(-0.045, 0.0, 0.0)]);
    let c = check(&scene, &state, &grasp(0, 0.0, 0.0, 0.0));
    assert!(!c.holds());
    let (right, left) = (0.585 - 0.01, 0.455 + 0.01);
    if let Some(g) = best(&scene, &state, 0) {
        // Whatever is found, both fingers keep away from both walls.
        let jaw = &scene.gripper().grasp;
        let (sin, cos) = g.angle.sin_cos();
        let half = (cos.abs() * jaw.finger_thickness + sin.abs() * jaw.finger_width) / 2.0;
        for side in [-1.0, 1.0] {
            let x = g.position[0] + side * cos * (g.opening + jaw.finger_thickness) / 2.0;
            assert!(left < x - half && x + half < right, "{g:?}");
        }
    }
}

#[test]
fn absent_and_unpickable_bodies_have_no_grasp() {
    let mut b = SceneBuilder::new();
    b.add_body(BodyDef { pickable: false, ..BodyDef::new(cube()) }).unwrap();
    b.add_body(BodyDef::new(cube())).unwrap();
    b.add_body(BodyDef::new(Shape::rectangle(0.0225, 0.045))).unwrap();
    let scene = b.build().unwrap();
    let mut state = State::new([at(-0.12, 0.0, 0.0), at(0.0, 0.0, 0.0), at(0.12, 0.1, 0.0)]);
    let test = test_for(&scene);
    let mut scratch = GraspScratch::default();
    assert_eq!(test.best(&scene, &state, 0, &mut scratch), None);
    assert_eq!(test.best_any(&scene, &state, &mut scratch).unwrap().body, 1);
    state.set_present(1, false);
    assert_eq!(test.best(&scene, &state, 1, &mut scratch), None);
    assert_eq!(test.best_any(&scene, &state, &mut scratch).unwrap().body, 2);
    assert_eq!(test.best(&scene, &state, 7, &mut scratch), None);
    let gone = test.assess(&scene, &state, 1, &mut scratch);
    assert_eq!((gone.grasp, gone.score, gone.nearness), (None, 0.0, 0.0));
}

#[test]
fn nearness_rises_as_the_way_clears() {
    let nearness = |gap: f64| {
        let (scene, state) = corridor(gap);
        let a = test_for(&scene).assess(&scene, &state, 0, &mut GraspScratch::default());
        assert_eq!(a.grasp.is_some(), a.nearness == 1.0);
        assert!(a.grasp.is_some() || (a.score == 0.0 && a.nearness < 1.0));
        a.nearness
    };
    let values: Vec<f64> = (0..8).map(|k| nearness(0.005 * k as f64)).collect();
    // Not at every step: the wall at first clears the far edge of a finger, then the near one.
    assert!(values.windows(3).all(|w| w[0] < w[2]), "{values:?}");
    assert!(values[0] > 0.0 && values[6] > values[0] + 0.1 && values[7] == 1.0, "{values:?}");
    // Nothing makes a body graspable that no opening takes.
    let scene = scene_of(vec![Shape::rectangle(0.2, 0.2)]);
    let a = test_for(&scene).assess(&scene, &State::new([at(0.0, 0.0, 0.0)]), 0, &mut GraspScratch::default());
    assert_eq!(a.nearness, 0.0);
}

/// Shapes by turns, thrown together without overlap; the first is the target.
fn packed(rng: &mut Stream, target: usize, spread: f64) -> (Scene, State) {
    let kinds = [
        cube(),
        Shape::rectangle(0.045, 0.09),
        Shape::Disc { radius: 0.022 },
        triangle(),
        Shape::rectangle(0.0225, 0.045),
    ];
    let shapes: Vec<Shape> =
        (0..7).map(|i| kinds[if i == 0 { target } else { rng.index(kinds.len()) }].clone()).collect();
    let scene = scene_of(shapes);
    let mut poses: Vec<Pose2> = Vec::new();
    for body in scene.bodies() {
        let mut reach = if poses.is_empty() { 0.0 } else { spread };
        loop {
            let pose = at(rng.uniform(-reach, reach), rng.uniform(-reach, reach), rng.uniform(-3.0, 3.0));
            let free =
                |(p, b): (&Pose2, &crate::scene::Body)| pieces_gap(&b.footprint, p, &body.footprint, &pose) > 1e-4;
            if poses.iter().zip(scene.bodies()).all(free) {
                poses.push(pose);
                break;
            }
            reach += 0.001;
        }
    }
    (scene, State::new(poses))
}

#[test]
fn the_best_grasp_passes_its_own_check() {
    let mut rng = Key::new(11).stream();
    let (mut scratch, mut found) = (GraspScratch::default(), 0);
    for k in 0..150 {
        let (scene, state) = packed(&mut rng, k % 5, 0.05 + 0.0007 * k as f64);
        let test = test_for(&scene);
        let Some(g) = test.best(&scene, &state, 0, &mut scratch) else { continue };
        found += 1;
        let c = test.check(&scene, &state, &g, &mut scratch);
        assert!(c.margin > -1e-7 && (c.margin - g.margin).abs() < 1e-7, "{k}: {g:?} {c:?}");
        assert!((c.score - g.score).abs() < 1e-4 || c.margin < 1e-7, "{k}: {g:?} {c:?}");
        assert!((c.width - g.width).abs() < 1e-7);
        // A fresh scratch, and a test without preparation, say the same.
        assert_eq!(
            GraspTest::new(GraspParams::default()).unwrap().best(&scene, &state, 0, &mut GraspScratch::default()),
            Some(g)
        );
    }
    assert!(found > 60, "{found}");
}

proptest::proptest! {
    #![proptest_config(proptest::prelude::ProptestConfig { cases: 64, failure_persistence: None, ..Default::default() })]

    /// The result moves with the scene.
    #[test]
    fn a_rigid_motion_changes_nothing(seed in 0u64..10_000, x in -0.2f64..0.2, y in -0.2f64..0.2, turn in -3.0f64..3.0) {
        let mut rng = Key::new(seed).stream();
        let (scene, state) = packed(&mut rng, (seed % 5) as usize, 0.06 + 1e-5 * (seed % 5000) as f64);
        let motion = Pose2::new(x, y, turn);
        let moved = State::new(state.iter().map(|(_, p)| motion.compose(&p)));
        let (a, b) = (best(&scene, &state, 0), best(&scene, &moved, 0));
        match (a, b) {
            (Some(a), Some(b)) => {
                proptest::prop_assert!((a.score - b.score).abs() < 1e-3, "{:?} {:?}", a, b);
                // The moved grasp is as good where it is now.
                let p = motion.transform_point(vec2(a.position[0], a.position[1]));
                let c = check(&scene, &moved, &Grasp { position: [p.x, p.y], angle: a.angle + turn, ..a });
                proptest::prop_assert!((c.margin - a.margin).abs() < 1e-6, "{:?} {:?}", a, c);
            }
            (None, None) => {}
            // Single precision moves bodies by a tenth of a micrometre.
            (Some(g), None) | (None, Some(g)) => proptest::prop_assert!(g.margin < 1e-6, "{:?}", g),
        }
    }
}

/// An independent grasp test by points: bodies are clouds of points 1.5 mm apart, and fingers, strip and pads are
/// compared with the points in bins.
mod cloud {
    use super::*;

    const STEP: f64 = 1.5e-3;
    const BIN: f64 = 0.25e-3;

    pub fn points(f: &Footprint, pose: &Pose2) -> Vec<Vec2> {
        let (min, max) = f.bounds();
        let count = |a: f64, b: f64| ((b - a) / STEP).ceil() as usize;
        let (nx, ny) = (count(min.x, max.x), count(min.y, max.y));
        let mut out = Vec::new();
        for i in 0..=nx {
            for j in 0..=ny {
                let p = pose.transform_point(vec2(
                    min.x + (max.x - min.x) * i as f64 / nx as f64,
                    min.y + (max.y - min.y) * j as f64 / ny as f64,
                ));
                // Dense near the border, coarse inside: no finger fits between the inner points.
                let inner = [(2.0, 0.0), (-2.0, 0.0), (0.0, 2.0), (0.0, -2.0)]
                    .iter()
                    .all(|&(x, y)| f.contains(pose, p + vec2(x, y) * STEP));
                if f.contains(pose, p) && (!inner || (i % 5 == 0 && j % 5 == 0)) {
                    out.push(p);
                }
            }
        }
        out
    }

    /// Taken places along x.
    #[derive(Clone)]
    struct Bins(Vec<bool>);

    impl Bins {
        fn new() -> Self {
            Bins(vec![false; 2000])
        }
        fn set(&mut self, x: f64) {
            let i = (x / BIN).floor() as i64 + 1000;
            if (0..2000).contains(&i) {
                self.0[i as usize] = true;
            }
        }
        fn any(&self, lo: f64, hi: f64) -> bool {
            let at = |x: f64| ((x / BIN).floor() as i64 + 1000).clamp(0, 1999) as usize;
            lo < hi && self.0[at(lo)..=at(hi)].contains(&true)
        }
    }

    /// The pads' profile of the target in the rows of a band: extents to +x and to -x.
    fn profile(corners: &[Vec2], disc: Option<(Vec2, f64)>, lo: f64, hi: f64) -> Vec<Option<(f64, f64)>> {
        let rows = 220;
        (0..=rows)
            .map(|k| {
                let y = lo + (hi - lo) * k as f64 / rows as f64;
                if let Some((c, r)) = disc {
                    let d = y - c.y;
                    return (d.abs() < r).then(|| ((r * r - d * d).sqrt() + c.x, (r * r - d * d).sqrt() - c.x));
                }
                let mut found: Option<(f64, f64)> = None;
                for i in 0..corners.len() {
                    let (p, q) = (corners[i], corners[(i + 1) % corners.len()]);
                    if (p.y <= y) != (q.y <= y) {
                        let x = p.x + (q.x - p.x) * (y - p.y) / (q.y - p.y);
                        let (r, l) = found.unwrap_or((f64::NEG_INFINITY, f64::NEG_INFINITY));
                        found = Some((r.max(x), l.max(-x)));
                    }
                }
                found
            })
            .collect()
    }

    /// Tilts of the faces met at the farthest row, from the profile's slopes.
    fn cone(rows: &[f64], ends: (bool, bool), dy: f64) -> (f64, f64) {
        let top = (0..rows.len()).max_by(|&a, &b| rows[a].total_cmp(&rows[b])).unwrap();
        let tilt = |a: usize, b: usize| -((rows[b] - rows[a]) / (dy * (b as f64 - a as f64))).atan();
        let right_angle = std::f64::consts::FRAC_PI_2;
        let mut all = Vec::new();
        if top > 0 {
            all.push(tilt(top - 1, top));
        } else if ends.0 {
            all.push(-right_angle);
        }
        if top + 1 < rows.len() {
            all.push(tilt(top, top + 1));
        } else if ends.1 {
            all.push(right_angle);
        }
        (all.iter().copied().fold(f64::INFINITY, f64::min), all.iter().copied().fold(f64::NEG_INFINITY, f64::max))
    }

    pub struct Jaw {
        pub centre: Vec2,
        pub angle: f64,
        /// Positions across the opening to try.
        pub across: Vec<f64>,
    }

    /// Some position of the jaw is legal with `slack` metres to spare (negative: with so much allowed).
    pub fn graspable(scene: &Scene, state: &State, clouds: &[Vec<Vec2>], jaw: &Jaw, slack: f64) -> bool {
        let g = scene.gripper().grasp;
        let half = g.finger_width / 2.0;
        let (s, c) = jaw.angle.sin_cos();
        let see = |p: Vec2| {
            let r = p - jaw.centre;
            vec2(c * r.x + s * r.y, c * r.y - s * r.x)
        };
        let (mut fingers, mut strip) = (Bins::new(), Bins::new());
        let (mut left, mut right) = (f64::INFINITY, f64::NEG_INFINITY);
        let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
        for (body, cloud) in clouds.iter().enumerate() {
            for p in cloud {
                let q = see(*p);
                if q.y.abs() < half + g.finger_clearance + slack {
                    fingers.set(q.x);
                }
                if body != 0 && q.y.abs() < half - g.pad_edge + slack {
                    strip.set(q.x);
                }
                if body == 0 {
                    low = low.min(q.y);
                    high = high.max(q.y);
                    if q.y.abs() < half {
                        left = left.min(q.x);
                        right = right.max(q.x);
                    }
                }
            }
        }
        if left > right || high.min(half) - low.max(-half) < g.min_cover + slack {
            return false;
        }
        let target = &scene.body(0).footprint;
        let pose = state.pose(0);
        let disc = matches!(target.shape, Shape::Disc { .. }).then(|| (see(pose.position()), target.radius));
        let corners: Vec<Vec2> = target.outlines[0].iter().map(|&p| see(pose.transform_point(p))).collect();
        let rows = profile(&corners, disc, -half, half);
        let ends = (rows[0].is_none(), rows[rows.len() - 1].is_none());
        let rows: Vec<(f64, f64)> = rows.into_iter().flatten().collect();
        let dy = 2.0 * half / 220.0;
        let r = cone(&rows.iter().map(|r| r.0).collect::<Vec<_>>(), ends, dy);
        let l = cone(&rows.iter().map(|r| r.1).collect::<Vec<_>>(), ends, dy);
        // The mirrored side's tilts change sign.
        let (l0, l1) = (-l.1, -l.0);
        let wedge = (r.0 - l1).max(l0 - r.1).max(0.0);
        if wedge > g.max_wedge - slack.signum() * 0.1 {
            return false;
        }
        jaw.across.iter().any(|&x| {
            let o = g.opening / 2.0;
            let (near, far) = (o - g.finger_clearance - slack, o + g.finger_thickness + g.finger_clearance + slack);
            right - x <= o - g.fit - slack
                && x - left <= o - g.fit - slack
                && !fingers.any(x + near, x + far)
                && !fingers.any(x - far, x - near)
                && !strip.any(x - o - slack, x + o + slack)
        })
    }
}

#[test]
fn an_independent_test_by_points_agrees() {
    let mut rng = Key::new(3).stream();
    let (mut yes, mut no, mut unclear) = (0, 0, 0);
    for k in 0..104 {
        let (scene, state) = packed(&mut rng, k % 4, 0.02 + 0.0005 * k as f64);
        let clouds: Vec<Vec<Vec2>> = state.iter().map(|(i, p)| cloud::points(&scene.body(i).footprint, &p)).collect();
        let own = state.pose(0);
        let slack = 1.8 * MM;
        if let Some(g) = best(&scene, &state, 0) {
            // The points lie within the bodies: what is legal is so by points, bins and edges allowed for.
            let centre = vec2(g.position[0], g.position[1]);
            let jaw = cloud::Jaw { centre, angle: g.angle, across: vec![0.0] };
            assert!(cloud::graspable(&scene, &state, &clouds, &jaw, -0.6 * MM), "{k}: {g:?}");
            yes += 1;
            continue;
        }
        // Nothing found: no grasp on the same grid may be legal with room to spare. The grid starts at the normal of
        // the longest side: x for these shapes (and a half step of the disc's 32 corners).
        let zero = if k % 4 == 2 { std::f64::consts::PI / 32.0 } else { 0.0 };
        let centroid = own.transform_point(scene.body(0).footprint.centroid);
        let across: Vec<f64> = (-36..=36).map(|i| f64::from(i) * 0.5 * MM).collect();
        let tried = |slack: f64| {
            (0..16).any(|a| {
                let angle = own.theta + zero + std::f64::consts::PI * f64::from(a) / 16.0;
                (-3..=3).any(|j| {
                    let along = vec2(-angle.sin(), angle.cos()) * (6.0 * MM * f64::from(j));
                    let jaw = cloud::Jaw { centre: centroid + along, angle, across: across.clone() };
                    cloud::graspable(&scene, &state, &clouds, &jaw, slack)
                })
            })
        };
        assert!(!tried(slack), "{k}: a grasp was missed");
        if tried(-slack) { unclear += 1 } else { no += 1 }
    }
    assert!(yes >= 20 && no >= 20 && yes + no >= 70, "{yes} {no} {unclear}");
}

#[test]
fn the_scorer_is_the_test_in_a_batch() {
    let (scene, near) = corridor(0.01);
    let mut far = near.clone();
    far.set_pose(1, at(0.2, 0.0, 0.0));
    far.set_pose(2, at(-0.2, 0.0, 0.0));
    let scorer: Box<dyn Scorer> = Box::new(GeometricScorer::new(&scene, GraspParams::default()).unwrap());
    assert_eq!(scorer.name(), "geometric");
    let mut scratch = scorer.scratch();
    let mut out = [GraspAssessment::default(); 3];
    scorer.assess(scratch.as_mut(), &scene, &[&near, &far, &near], 0, &mut out, &Stop::never());
    assert!(out[0].grasp.is_none() && out[1].score > 0.9 && out[0] == out[2], "{out:?}");
    // A foreign scratch is no reason to fail.
    let mut foreign: Box<dyn std::any::Any + Send> = Box::new(3u8);
    let mut again = out;
    scorer.assess(foreign.as_mut(), &scene, &[&near, &far, &near], 0, &mut again, &Stop::never());
    assert_eq!(out, again);
}

#[test]
fn bad_parameters_are_named() {
    let bad = |p: GraspParams| GraspTest::new(p).unwrap_err().to_string();
    assert!(bad(GraspParams { angles: 0, ..GraspParams::default() }).starts_with("grasp.angles: is 0"));
    assert!(
        bad(GraspParams { pre_openings: vec![0.05, -0.1], ..GraspParams::default() })
            .starts_with("grasp.pre_openings[1]")
    );
    let text = serde_json::to_string(&GraspParams::default()).unwrap();
    assert_eq!(serde_json::from_str::<GraspParams>(&text).unwrap(), GraspParams::default());
}

/// A body of each height at x, and a gripper whose fingers end so high and are so long.
fn high(bodies: &[(f64, f64, f64)], lowest: f64, finger_length: f64) -> (Scene, State) {
    let mut b = SceneBuilder::new();
    let jaw = Gripper::robotiq_2f85();
    let grasp = crate::scene::Grasper { lowest, finger_length, ..jaw.grasp };
    b.gripper(Gripper { grasp, ..jaw });
    for (_, side, height) in bodies {
        b.add_body(BodyDef { height: *height, ..BodyDef::new(Shape::rectangle(0.045, *side)) }).unwrap();
    }
    (b.build().unwrap(), State::new(bodies.iter().map(|(x, ..)| at(*x, 0.0, 0.0))))
}

#[test]
fn fingers_that_end_above_a_body_cannot_grasp_it() {
    for (height, lowest, held) in [
        (0.023, 0.0, true),
        (0.023, 0.0179, true),
        (0.023, 0.0181, false),
        (0.023, 0.035, false),
        (0.045, 0.035, true),
        (0.001, 0.0, true),
    ] {
        let (scene, state) = high(&[(0.0, 0.045, height)], lowest, f64::INFINITY);
        assert_eq!(best(&scene, &state, 0).is_some(), held, "{height} {lowest}");
        let one = check(&scene, &state, &grasp(0, 0.0, 0.0, 0.0));
        assert_eq!(one.holds(), held);
        if !held {
            let missing = lowest + 0.005 - height;
            assert!(one.limit == Limit::Depth && (one.margin + missing).abs() < 1e-12, "{one:?}");
            let why = test_for(&scene).unholdable(&scene, 0);
            assert!(matches!(why, Some(Unholdable::TooLow { missing: m }) if (m - missing).abs() < 1e-12), "{why:?}");
            assert_eq!(test_for(&scene).greatest_score(&scene, 0), None);
        }
    }
    // A gripper twice the size has to reach down twice as far.
    let twice = |height: f64| {
        let jaw = Gripper::robotiq_2f85().scaled(2.0);
        let gripper = Gripper { grasp: crate::scene::Grasper { lowest: 0.02, ..jaw.grasp }, ..jaw };
        gripper.too_low(height).is_some()
    };
    assert!(twice(0.0299) && !twice(0.0301));
}

/// Tables that were made for other heights are not taken for a scene where heights count.
#[test]
fn heights_count_in_prepared_tests_too() {
    let (low, state) = high(&[(0.0, 0.045, 0.023)], 0.035, f64::INFINITY);
    let (high, _) = high(&[(0.0, 0.045, 0.07)], 0.035, f64::INFINITY);
    let mut scratch = GraspScratch::default();
    assert!(test_for(&high).best(&low, &state, 0, &mut scratch).is_none());
    assert!(test_for(&low).best(&high, &state, 0, &mut scratch).is_some());
}

#[test]
fn what_the_fingers_end_above_is_in_no_finger_s_way() {
    // Long neighbours on both sides, 1 mm away, and no room along the pads' other direction.
    let packed = |neighbours: f64, lowest: f64, finger_length: f64| {
        let bodies = [(0.0, 0.2, 0.07), (-0.046, 0.2, neighbours), (0.046, 0.2, neighbours)];
        let (scene, state) = high(&bodies, lowest, finger_length);
        let found = best(&scene, &state, 0);
        if let Some(found) = found {
            assert!(check(&scene, &state, &found).holds(), "{found:?}");
        }
        found.is_some()
    };
    assert!(!packed(0.02, 0.0, f64::INFINITY), "in the way");
    assert!(packed(0.02, 0.02, f64::INFINITY), "below the fingers' ends");
    assert!(!packed(0.021, 0.02, f64::INFINITY));
    assert!(packed(0.02, 0.0, 0.05), "short fingers end at 20 mm on a body of 70 mm");
    assert!(!packed(0.02, 0.0, 0.051));
}

#[test]
fn fingers_too_short_to_hold_anything_are_refused() {
    let jaw = Gripper::robotiq_2f85();
    let short = |finger_length: f64| {
        let grasp = crate::scene::Grasper { finger_length, ..jaw.grasp };
        Gripper { grasp, ..jaw.clone() }.validate().err().map(|error| error.to_string())
    };
    assert!(short(0.0049).unwrap().starts_with("gripper.grasp.finger_length: is 0.0049; fingers must reach"));
    assert!(short(0.006).is_none() && short(f64::INFINITY).is_none() && short(f64::NAN).is_some());
}
