//! The learned planners with stand-ins in the networks' place, and with the built-in networks where they can be run.

use std::sync::Arc;

use jostle::action::{Action, Push};
use jostle::error::{Error, Result};
use jostle::geom::{Pose2, Shape};
use jostle::net::{ImageScratch, MotionModel, ObjectBatch, PushValue, PushValueScratch, TargetProbability};
use jostle::plan::{Control, Outcome, OwnNetworks, Plan, Planner, PlannerOptions};
use jostle::run::{Budget, Stop};
use jostle::scene::{BodyDef, Problem, Scene, SceneBuilder, State};

/// The target between four squares that leave no room for a finger.
fn walled() -> Problem {
    let offsets = [[0.0, 0.0], [0.046, 0.0], [-0.046, 0.0], [0.0, 0.046], [0.0, -0.046]];
    let mut builder = SceneBuilder::new();
    for _ in &offsets {
        builder.add_body(BodyDef::new(Shape::rectangle(0.045, 0.045))).unwrap();
    }
    let state = State::new(offsets.iter().map(|o| Pose2::new(0.5 + o[0], o[1], 0.0)));
    Problem::new("walled", Arc::new(builder.build().unwrap()), state, 0).unwrap()
}

/// Values the pushes that go along +y most.
struct LikesUp;

impl PushValue for LikesUp {
    fn name(&self) -> &str {
        "likes up"
    }

    fn values(
        &self,
        _: &mut PushValueScratch,
        _: &Scene,
        _: &State,
        _: usize,
        pushes: &[Push],
        values: &mut Vec<f32>,
        _: &Stop,
    ) -> Result<()> {
        values.clear();
        values.extend(pushes.iter().map(|p| up(p) as f32));
        Ok(())
    }
}

/// From 0 for a push along -y to 1 for one along +y.
fn up(push: &Push) -> f64 {
    0.5 + 0.5 * push.angle().sin()
}

/// Moves every body whose centre lies before the tip, and less than its half width beside it, by the push; the others stay.
struct CarriesAlong;

impl MotionModel for CarriesAlong {
    fn name(&self) -> &str {
        "carries along"
    }

    fn wants_guess(&self) -> bool {
        false
    }

    fn chunk(&self) -> usize {
        4
    }

    fn predict(&self, batch: &ObjectBatch, motions: &mut Vec<[f32; 3]>) -> Result<()> {
        motions.clear();
        for item in 0..batch.items() {
            let length = batch.push_length(item);
            for body in 0..batch.objects() {
                let [x, y] = batch.centre(item, body);
                // The tip touches a square of 45 mm this far before its centre.
                let reach = (length - (x - 0.0335)).clamp(0.0, length);
                motions.push([if y.abs() < 0.02 && x > 0.0 { reach } else { 0.0 }, 0.0, 0.0]);
            }
        }
        Ok(())
    }
}

/// Graspable when nothing lies within so many metres of the target.
struct Alone(f64);

impl TargetProbability for Alone {
    fn probability(&self, _: &mut ImageScratch, _: &Scene, state: &State, target: usize) -> Result<f64> {
        let here = state.pose(target).position();
        let near = state.iter().filter(|(i, p)| *i != target && (p.position() - here).norm() < self.0).count();
        Ok(1.0 / (1.0 + near as f64))
    }

    fn threshold(&self) -> f64 {
        0.3
    }
}

fn options(planner: &str) -> PlannerOptions {
    PlannerOptions { planner: planner.into(), seed: 5, ..PlannerOptions::default() }
}

fn solve(options: PlannerOptions, own: OwnNetworks, problem: &Problem) -> Plan {
    Planner::with_networks(options, own).unwrap().solve(problem, &Control::default()).unwrap()
}

fn first_push(plan: &Plan) -> Push {
    match plan.actions.first().map(|a| &a.action) {
        Some(Action::Push(push)) => *push,
        other => panic!("{other:?}"),
    }
}

fn liking() -> OwnNetworks {
    OwnNetworks { push_value: Some(Arc::new(LikesUp)), ..OwnNetworks::default() }
}

#[test]
fn the_network_alone_takes_the_push_that_it_values_most() {
    let plan = solve(options("ppn"), liking(), &walled());
    assert!(up(&first_push(&plan)) > 0.99, "{:?}", first_push(&plan));
    assert!(plan.statistics.simulations <= 4, "{:?}", plan.statistics);
    assert!(plan.considered.iter().all(|c| (c.prior - up(push_of(&c.action))).abs() < 1e-6));
}

fn push_of(action: &Action) -> &Push {
    match action {
        Action::Push(push) => push,
        other => panic!("{other:?}"),
    }
}

#[test]
fn a_guided_search_tries_first_what_the_network_values_most() {
    let few = PlannerOptions { budget: Budget::iterations(2), ..options("more") };
    let plan = solve(few, liking(), &walled());
    assert!(!plan.considered.is_empty());
    assert!(plan.considered.iter().all(|c| c.prior > 0.8), "{:?}", plan.considered);
}

#[test]
fn a_guided_search_finds_a_plan_whatever_the_network_likes() {
    let plan = solve(PlannerOptions { budget: Budget::iterations(200), ..options("more") }, liking(), &walled());
    assert_eq!(plan.outcome, Outcome::Solved);
}

#[test]
fn foresight_plans_with_the_motions_that_the_network_predicts() {
    let own = || OwnNetworks {
        motion: Some(Arc::new(CarriesAlong)),
        graspability: Some(Arc::new(Alone(0.05))),
        ..OwnNetworks::default()
    };
    let problem = walled();
    for planner in ["vft", "dipn"] {
        let plan = solve(options(planner), own(), &problem);
        let push = first_push(&plan);
        let predicted = &plan.actions[0].predicted;
        // What moved went along the push and did not turn: nothing but the stand-in does that.
        let moved: Vec<_> = problem
            .state
            .iter()
            .filter(|(i, p)| (predicted.pose(*i).position() - p.position()).norm() > 1e-4)
            .collect();
        assert!(!moved.is_empty(), "{planner}");
        for (i, pose) in moved {
            let by = predicted.pose(i).position() - pose.position();
            assert!(by.normalize().dot(&push.direction()) > 0.999, "{planner}: {i} {by:?}");
            assert!((predicted.pose(i).theta - pose.theta).abs() < 1e-4);
        }
    }
}

#[test]
fn threads_change_no_bit_of_a_learned_plan() {
    let problem = walled();
    let with = |threads| {
        let own = OwnNetworks {
            motion: Some(Arc::new(CarriesAlong)),
            graspability: Some(Arc::new(Alone(0.07))),
            push_value: Some(Arc::new(LikesUp)),
        };
        let options = PlannerOptions { threads, lanes: Some(8), budget: Budget::iterations(60), ..options("vft") };
        format!("{:?}", solve(options, own, &problem).actions)
    };
    assert_eq!(with(1), with(2));
    assert_eq!(with(1), with(5));
}

#[test]
fn a_prior_that_is_not_there_is_named() {
    let options = PlannerOptions { prior: Some("oracle".into()), ..options("more") };
    match Planner::new(options) {
        Err(Error::NotFound { field, .. }) => assert_eq!(field, "prior"),
        other => panic!("{:?}", other.map(|_| ())),
    }
}

/// The built-in networks, from the choice of a push to the grasp of the target, in the model of the search.
#[test]
fn the_built_in_networks_free_a_walled_target() {
    let problem = walled();
    for planner in ["vft", "dipn", "more", "ppn"] {
        let mut planner_object = match Planner::new(options(planner)) {
            Ok(planner) => planner,
            Err(error) => {
                println!("skipped: {planner}: {error}");
                continue;
            }
        };
        let plan = planner_object.solve(&problem, &Control::default()).unwrap();
        assert!(!plan.actions.is_empty(), "{planner}: {:?}", plan.outcome);
        first_push(&plan);
    }
}
