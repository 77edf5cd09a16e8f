//! Rows of bodies of very unequal masses in front of the tip: what is pushed goes along, however light or heavy it is, or
//! the push says that it could not be solved.

use std::sync::Arc;

use jostle::action::{Action, Push};
use jostle::eval::{Effect, Judge, JudgeOptions};
use jostle::geom::{Obb, Pose2, Shape, pieces_gap_below, vec2};
use jostle::physics::{
    DEEPEST, EngineInfo, PhysicsOptions, Purpose, PushJob, PushResult, PushStatus, Transition, engine,
};
use jostle::run::{Key, Stop, Stream};
use jostle::scene::{BodyDef, Friction, Problem, PushTip, Scene, SceneBuilder, State};

/// A row of blocks along a heading, the tip in front of the first, centred.
#[derive(Debug, Clone)]
struct Row {
    masses: Vec<f64>,
    /// Along and across the push, metres.
    sizes: Vec<[f64; 2]>,
    /// Before each block: the first is the tip's.
    gaps: Vec<f64>,
    heading: f64,
    travel: f64,
    tip_friction: f64,
}

impl Row {
    fn of(masses: &[f64]) -> Row {
        Row {
            masses: masses.to_vec(),
            sizes: vec![[0.045, 0.045]; masses.len()],
            gaps: [0.007].into_iter().chain(masses.iter().skip(1).map(|_| 0.0)).collect(),
            heading: 0.0,
            travel: 0.06,
            tip_friction: 0.9,
        }
    }

    /// Two or three blocks; neighbours' masses differ by up to 10^`decades`, either way.
    fn random(random: &mut Stream, decades: f64) -> Row {
        let count = 2 + random.index(2);
        let ratios: Vec<f64> = (1..count).map(|_| 10f64.powf(random.uniform(-decades, decades))).collect();
        let mut masses = vec![1.0];
        ratios.iter().for_each(|ratio| masses.push(masses[masses.len() - 1] * ratio));
        let middle = masses.iter().product::<f64>().powf(1.0 / count as f64);
        Row {
            masses: masses.iter().map(|m| 0.3 * m / middle).collect(),
            sizes: (0..count).map(|_| [random.uniform(0.03, 0.06), random.uniform(0.035, 0.06)]).collect(),
            gaps: (0..count).map(|i| random.uniform(0.0, 0.004) + if i == 0 { 0.004 } else { 0.0 }).collect(),
            heading: random.uniform(-3.1, 3.1),
            travel: random.uniform(0.03, 0.07),
            tip_friction: random.uniform(0.3, 1.0),
        }
    }

    fn scene(&self) -> (Arc<Scene>, State, Push) {
        let mut builder = SceneBuilder::new();
        builder.friction(Friction { tip: self.tip_friction, ..Friction::default() });
        let along = vec2(self.heading.cos(), self.heading.sin());
        let start = vec2(0.5, 0.0);
        let (mut at, mut poses) = (PushTip::default().thickness / 2.0, Vec::new());
        for ((&mass, &[x, y]), gap) in self.masses.iter().zip(&self.sizes).zip(&self.gaps) {
            builder.add_body(BodyDef { mass, ..BodyDef::new(Shape::rectangle(x, y)) }).unwrap();
            at += gap + x / 2.0;
            let centre = start + along * at;
            poses.push(Pose2::new(centre.x, centre.y, self.heading));
            at += x / 2.0;
        }
        let push = Push::new(start, start + along * self.travel);
        (Arc::new(builder.build().unwrap()), State::new(poses), push)
    }

    /// How far each block has to go: the travel less the gaps before it, of which the engines' borders of 1 mm round
    /// every body may fill `borders`.
    fn wanted(&self, borders: f64) -> Vec<f64> {
        let mut left = self.travel;
        let mut less = |gap: &f64| {
            left -= (gap - borders).max(0.0);
            left.max(0.0)
        };
        self.gaps.iter().map(&mut less).collect()
    }

    /// How far each block went along the push.
    fn went(&self, before: &State, after: &State) -> Vec<f64> {
        let along = vec2(self.heading.cos(), self.heading.sin());
        let way = |i: usize| (after.pose(i).position() - before.pose(i).position()).dot(&along);
        (0..self.masses.len()).map(way).collect()
    }
}

fn named(engine: &str, preset: &str, scene: &Arc<Scene>) -> Arc<dyn Transition> {
    let options = PhysicsOptions::named(engine, Some(preset), Purpose::Planning).unwrap();
    jostle::physics::engine(&options, Arc::clone(scene)).unwrap()
}

fn run(engine: &dyn Transition, state: &State, push: Push) -> PushResult {
    engine.step(&mut engine.scratch(), state, &push, &Stop::never())
}

/// How deep the tip or a body is in a body after the push.
fn deepest(scene: &Scene, state: &State, push: &Push) -> f64 {
    let start = push.tip_at_start(&scene.gripper().push);
    let tip = Obb { centre: start.centre + push.direction() * push.length(), ..start };
    let mut deepest = 0.0f64;
    for (i, pose) in state.iter() {
        let footprint = &scene.body(i).footprint;
        deepest = deepest.max(-tip.gap_below(footprint, &pose, 0.0));
        for (j, other) in state.iter().filter(|(j, _)| *j < i) {
            deepest = deepest.max(-pieces_gap_below(footprint, &pose, &scene.body(j).footprint, &other, 0.0));
        }
    }
    deepest
}

const OURS: [(&str, &str); 4] = [("planar", "fast"), ("planar", "fine"), ("prism", "fast"), ("prism", "fine")];

/// Runs random rows in our own engines. The share of pushes that each executed without toppling a body; each of these
/// went as the row says.
fn solved(rows: u64, decades: f64) -> [f64; 4] {
    let mut solved = [0.0; 4];
    for case in 0..rows {
        let row = Row::random(&mut Key::new(17).child(case).stream(), decades);
        let (scene, state, push) = row.scene();
        for (share, (name, preset)) in solved.iter_mut().zip(OURS) {
            let result = run(&*named(name, preset, &scene), &state, push);
            match result.status {
                PushStatus::Executed if result.toppled.is_empty() => *share += 1.0 / rows as f64,
                PushStatus::Executed => continue,
                status => {
                    assert_eq!(status, PushStatus::Unsolved, "{name} {preset} {row:?}");
                    assert_eq!(result.state, state, "nothing was moved");
                    continue;
                }
            }
            let deep = deepest(&scene, &result.state, &push);
            assert!(deep <= DEEPEST, "{name} {preset} {row:?}: {deep}");
            let (least, most) = (row.wanted(0.0), row.wanted(0.002));
            for (i, went) in row.went(&state, &result.state).into_iter().enumerate() {
                let range = 0.95 * least[i] - 0.002..1.05 * most[i] + 0.002;
                assert!(range.contains(&went), "{name} {preset} {row:?}: block {i} went {went}, not {range:?}");
            }
        }
    }
    solved
}

#[test]
fn a_row_goes_as_far_as_the_tip_whatever_its_masses_or_the_push_says_that_it_is_unsolved() {
    let solved = solved(60, 3.0);
    println!("{OURS:?}: {solved:?}");
    assert!(solved.iter().all(|share| *share > 0.6), "{solved:?}");
}

#[test]
fn masses_that_differ_a_hundredfold_are_solved() {
    let solved = solved(20, 2.0);
    println!("{OURS:?}: {solved:?}");
    // A light block can be squeezed upright no longer: `prism` topples it.
    assert!(
        solved[..2].iter().all(|share| *share > 0.94) && solved[2..].iter().all(|share| *share > 0.8),
        "{solved:?}"
    );
}

#[test]
fn a_light_block_before_a_heavy_one_hands_the_push_on() {
    let row = Row::of(&[0.05, 5.0]);
    let (scene, state, push) = row.scene();
    for (name, preset) in OURS {
        let result = run(&*named(name, preset, &scene), &state, push);
        let went = row.went(&state, &result.state);
        assert!(went.iter().all(|way| (way - 0.053).abs() < 0.004), "{name} {preset}: {went:?}");
    }
}

#[test]
fn no_engine_calls_a_push_executed_whose_tip_ends_in_a_body() {
    let mut unsolved = 0;
    for case in 0..12 {
        let row = Row::random(&mut Key::new(5).child(case).stream(), 4.0);
        let (scene, state, push) = row.scene();
        for info in EngineInfo::available().filter(|info| !["dipn", "bullet"].contains(&info.id)) {
            for preset in info.presets {
                let result = run(&*named(info.id, preset, &scene), &state, push);
                let deep = deepest(&scene, &result.state, &push);
                let executed = result.status == PushStatus::Executed && result.toppled.is_empty();
                assert!(!executed || deep <= DEEPEST, "{} {preset} {row:?}: {deep}", info.id);
                unsolved += usize::from(result.status == PushStatus::Unsolved);
            }
        }
    }
    assert!(unsolved > 0, "there are such pushes");
}

#[test]
fn a_judge_takes_an_unsolved_push_for_blocked_and_moves_nothing() {
    let row = Row::of(&[0.005, 5.0]);
    let (scene, state, push) = row.scene();
    let problem = Problem { name: "row".into(), scene, state, target: 1 };
    let mut judge = Judge::new(&problem, &JudgeOptions::exact(PhysicsOptions::preset("fast")), 0).unwrap();
    assert_eq!(judge.execute(&Action::Push(push)).unwrap(), Effect::Blocked);
    assert_eq!(*judge.truth(), problem.state);
}

#[test]
fn a_row_of_uneven_masses_has_the_same_bits_alone_and_in_a_batch() {
    let rows: Vec<Row> = (0..3).map(|case| Row::random(&mut Key::new(9).child(case).stream(), 2.0)).collect();
    for row in rows {
        let (scene, state, push) = row.scene();
        let shorter = Push::new(push.start(), push.start() + push.direction() * 0.04);
        for (name, preset) in OURS {
            let engine = named(name, preset, &scene);
            let alone = [push, shorter].map(|push| run(&*engine, &state, push));
            for count in [2, 5, 20] {
                let jobs: Vec<PushJob<'_>> =
                    (0..count).map(|k| PushJob { state: &state, push: [push, shorter][k % 2] }).collect();
                let mut results = vec![PushResult::default(); count];
                engine.step_batch(&mut engine.scratch(), &jobs, &mut results, &Stop::never());
                for (k, result) in results.iter().enumerate() {
                    assert_eq!(*result, alone[k % 2], "{name} {preset} {row:?}: {k} of {count}");
                }
            }
        }
    }
}

/// Friction of 2 to 10 between bodies, which is allowed, makes solvers diverge: then the push is unsolved.
#[test]
fn what_is_executed_throws_no_body_away_however_rough_bodies_are() {
    let mut random = Key::new(77).stream();
    let mut unsolved = 0;
    for (name, preset) in [("planar", "fast"), ("planar", "fine"), ("prism", "fast"), ("rapier", "fast")] {
        for _ in 0..40 {
            let friction = random.uniform(2.0, 10.0);
            let mut builder = SceneBuilder::new();
            let mut poses = Vec::new();
            let mut right = 0.0;
            for _ in 0..2 + random.index(3) {
                let [half_x, half_y] = [random.uniform(0.01, 0.03), random.uniform(0.01, 0.03)];
                let body = BodyDef { friction, ..BodyDef::new(Shape::rectangle(2.0 * half_x, 2.0 * half_y)) };
                builder.add_body(body).unwrap();
                poses.push(Pose2::new(right + half_x, random.uniform(-0.005, 0.005), 0.0));
                right += 2.0 * half_x;
            }
            let (scene, state) = (Arc::new(builder.build().unwrap()), State::new(poses));
            let x = random.uniform(0.0, right);
            let push = Push::new(vec2(x, -0.05), vec2(x + random.uniform(-0.02, 0.02), 0.08));
            let options = PhysicsOptions {
                preset: preset.into(),
                ..PhysicsOptions::named(name, None, Purpose::Planning).unwrap()
            };
            let result = run(&*engine(&options, scene).unwrap(), &state, push);
            unsolved += u32::from(result.status == PushStatus::Unsolved);
            for (i, pose) in result.state.iter() {
                let went = (pose.position() - state.pose(i).position()).norm();
                assert!(pose.is_finite() && went < 0.5, "{name} {preset}, friction {friction}: body {i} went {went} m");
            }
        }
    }
    assert!(unsolved > 0, "none of the scenes is as bad as it should be");
}

/// The table of `docs/engines.md`: `cargo test --release --features bullet --test mass_ratios table -- --ignored
/// --nocapture`.
#[test]
#[ignore = "prints a table"]
fn table() {
    type Masses = fn(f64) -> Vec<f64>;
    let rows: [(&str, Masses); 4] = [
        ("light, heavy", |ratio| vec![5.0 / ratio, 5.0]),
        ("heavy, light", |ratio| vec![0.05 * ratio, 0.05]),
        ("light, heavy, light", |ratio| vec![5.0 / ratio, 5.0, 5.0 / ratio]),
        ("heavy, light, heavy", |ratio| vec![0.05 * ratio, 0.05, 0.05 * ratio]),
    ];
    let options = EngineInfo::available().filter(|info| info.id != "dipn").flat_map(|info| {
        info.presets.iter().map(|preset| PhysicsOptions { engine: info.id.into(), ..PhysicsOptions::preset(preset) })
    });
    let options: Vec<PhysicsOptions> = options.filter(|o| o.engine != "bullet" || o.preset == "reference").collect();
    let names: Vec<String> = options.iter().map(|o| format!("`{} {}`", o.engine, o.preset)).collect();
    println!("| row | ratio | {} |", names.join(" | "));
    for (name, masses) in rows {
        for ratio in [1.0, 10.0, 20.0, 50.0, 100.0, 300.0, 1000.0] {
            let row = Row::of(&masses(ratio));
            let (scene, state, push) = row.scene();
            let cells: Vec<String> =
                options.iter().map(|o| cell(&row, &*engine(o, Arc::clone(&scene)).unwrap(), &state, push)).collect();
            println!("| {name} | {ratio} | {} |", cells.join(" | "));
        }
    }
}

/// Millimetres that each block went.
fn cell(row: &Row, engine: &dyn Transition, state: &State, push: Push) -> String {
    let result = run(engine, state, push);
    if result.status != PushStatus::Executed {
        return "unsolved".into();
    }
    let ways: Vec<String> = row.went(state, &result.state).iter().map(|way| format!("{:.0}", way * 1e3)).collect();
    let toppled = if result.toppled.is_empty() { "" } else { " (toppled)" };
    format!("{}{toppled}", ways.join(", "))
}
