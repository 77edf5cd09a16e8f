use super::*;
use crate::datagen::ShapeFamily;
use crate::physics::{PhysicsOptions, Purpose, engine};
use crate::run::{Budget, CancelToken, Stop};

fn family() -> Arc<ShapeFamily> {
    Arc::new(ShapeFamily::new(1, 120).unwrap())
}

fn make(name: &'static str) -> impl Fn(Arc<Scene>) -> Result<Arc<dyn Transition>> {
    move |scene| engine(&PhysicsOptions::parse(name, Purpose::Planning)?, scene)
}

fn compare(chains_wanted: usize, stop: &Stop) -> Result<ChainReport> {
    let params = ChainParams { chains: chains_wanted, pushes: 3, seed: 4, ..ChainParams::default() };
    let (reference, other) = (make("planar:fast"), make("rapier:fast"));
    let same = make("planar:fast");
    let mut heard = 0;
    let report = chains(&params, &family(), &reference, &[&same, &other], stop, &mut |n| heard = n)?;
    assert_eq!(heard, report.chains);
    Ok(report)
}

#[test]
fn the_reference_agrees_with_itself_and_a_world_that_stands_still_strays() {
    let report = compare(4, &Stop::never()).unwrap();
    assert_eq!((report.reference.as_str(), report.chains), ("planar fast", 4));
    let [still, same, other] = report.engines.as_slice() else { panic!("{report:?}") };
    assert_eq!((still.engine.as_str(), other.engine.as_str()), ("static", "rapier fast"));
    for k in 0..3 {
        let (still, same, other) = (still.steps[k], same.steps[k], other.steps[k]);
        assert_eq!((same.push, same.refused), (k + 1, 0));
        assert!(same.moved >= 4 && same.moved_one_minus_iou < 1e-9, "{same:?}");
        // rapier is another model of the same world: nearer than nothing, and not the same.
        assert!(other.moved_one_minus_iou > 1e-4, "{other:?}");
        assert!(other.moved_one_minus_iou < still.moved_one_minus_iou, "{other:?} {still:?}");
    }
    assert!(still.steps[2].moved >= still.steps[0].moved, "more pushes move more bodies");
    assert_eq!(report, compare(4, &Stop::never()).unwrap(), "a seed repeats itself");
}

#[test]
fn a_stop_ends_the_comparison_with_what_is_known() {
    let token = CancelToken::new();
    token.trigger();
    let stop = Budget::default().start(&[token]);
    assert_eq!(compare(4, &stop).unwrap().chains, 0);
}

#[test]
fn only_an_engine_that_grasps_can_judge_grasps() {
    let params = GraspTrialParams { targets: 1, ..GraspTrialParams::default() };
    let judge = make("planar:fast");
    let error = try_grasps(&params, &family(), &judge, &mut |_, _, _| Ok(None), &Stop::never(), &mut |_| ());
    let text = error.unwrap_err().to_string();
    assert!(text.starts_with("judge: planar fast cannot grasp"), "{text}");
}

#[cfg(feature = "bullet")]
#[test]
fn grasps_of_the_geometric_test_succeed_and_none_at_all_does_not() {
    use crate::grasp::{GraspParams, GraspScratch, GraspTest};
    let params = GraspTrialParams { targets: 8, seed: 2, ..GraspTrialParams::default() };
    let judge = make("bullet:fast");
    let mut scratch = GraspScratch::default();
    // Names the test's own best where there is one, else nothing.
    let mut named = |scene: &Scene, state: &crate::scene::State, target: usize| {
        Ok(GraspTest::new(GraspParams::default())?.best(scene, state, target, &mut scratch))
    };
    let trials = try_grasps(&params, &family(), &judge, &mut named, &Stop::never(), &mut |_| ()).unwrap();
    assert_eq!((trials.graspable, trials.grid.targets, trials.network.targets), (8, 8, 8));
    assert_eq!(trials.network, trials.geometric);
    assert!(trials.grid.succeeded >= 6 && trials.looked_at >= 8, "{trials:?}");
    let none = try_grasps(&params, &family(), &judge, &mut |_, _, _| Ok(None), &Stop::never(), &mut |_| ()).unwrap();
    assert_eq!((none.network.named, none.network.succeeded, none.grid), (0, 0, trials.grid));
}

#[cfg(feature = "bullet")]
#[test]
fn a_classifier_that_asks_the_geometric_test_agrees_with_it_and_one_that_never_says_yes_does_not() {
    use crate::grasp::{GraspParams, GraspScratch, GraspTest};
    let params = GraspTrialParams { targets: 10, seed: 2, ..GraspTrialParams::default() };
    let judge = make("bullet:fast");
    let mut scratch = GraspScratch::default();
    let mut asked = |scene: &Scene, state: &crate::scene::State, target: usize| {
        let found = GraspTest::new(GraspParams::default())?.assess(scene, state, target, &mut scratch);
        Ok(if found.grasp.is_some() { found.score } else { 0.0 })
    };
    let trials = try_classifier(&params, &family(), &judge, (&mut asked, 0.3), &Stop::never(), &mut |_| ()).unwrap();
    assert_eq!((trials.network.targets, trials.network.right), (10, 10), "{trials:?}");
    assert_eq!(trials.network_in_engine, trials.geometric_in_engine);
    assert!(trials.network.yes > 0 && trials.network.yes < 10, "{trials:?}");
    assert!(trials.network_in_engine.said_rightly > 0 && trials.network_in_engine.accuracy >= 0.7, "{trials:?}");
    assert_eq!(trials.reliability.iter().map(|bin| bin.targets).sum::<usize>(), 10);
    assert!(
        trials.reliability.iter().filter(|bin| bin.from >= 0.3).all(|bin| bin.targets == 0 || bin.geometric == 1.0)
    );

    let mut never = |_: &Scene, _: &crate::scene::State, _: usize| Ok(0.0);
    let none = try_classifier(&params, &family(), &judge, (&mut never, 0.3), &Stop::never(), &mut |_| ()).unwrap();
    assert_eq!((none.network.said, none.network.recall), (0, 0.0));
    assert_eq!(none.network.right, 10 - trials.network.yes);
    assert_eq!(
        none.geometric_in_engine, trials.geometric_in_engine,
        "the targets and what the engine does are the same"
    );
}
