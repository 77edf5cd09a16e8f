use super::*;
use crate::geom::vec2;
use crate::scene::{BodyDef, SceneBuilder, Workspace};

fn table() -> SceneBuilder {
    let mut builder = SceneBuilder::new();
    builder.workspace(Workspace::rectangle(vec2(0.0, 0.0), vec2(0.78, 0.52)));
    builder
}

fn two(first: BodyDef, second: BodyDef) -> Arc<Scene> {
    let mut builder = table();
    builder.add_body(first.named("a")).unwrap();
    builder.add_body(second.named("b")).unwrap();
    Arc::new(builder.build().unwrap())
}

fn square() -> BodyDef {
    BodyDef::new(Shape::rectangle(0.1, 0.1))
}

fn at(x: f64, y: f64) -> Pose2 {
    Pose2::new(x, y, 0.0)
}

fn refused(scene: &Arc<Scene>, start: [Pose2; 2], goals: [Option<Pose2>; 2]) -> String {
    let goals = goals.iter().map(|goal| goal.map(Goal::at)).collect();
    Rearrangement::new("test", Arc::clone(scene), State::new(start), goals).unwrap_err().to_string()
}

#[test]
fn a_goal_is_reached_within_its_tolerances() {
    let goal = Goal::at(Pose2::new(0.3, 0.2, 0.5));
    assert!(goal.reached(&Pose2::new(0.3049, 0.2, 0.5)));
    assert!(!goal.reached(&Pose2::new(0.3051, 0.2, 0.5)));
    assert!(goal.reached(&Pose2::new(0.3, 0.2, 0.5 + 2.9f64.to_radians())));
    assert!(!goal.reached(&Pose2::new(0.3, 0.2, 0.5 + 3.1f64.to_radians())));
}

#[test]
fn symmetric_goals_are_reached_by_every_turn_that_looks_the_same() {
    use std::f64::consts::{FRAC_PI_2, PI};
    let with = |symmetry| Goal { symmetry, ..Goal::at(Pose2::new(0.3, 0.2, 3.0)) };
    let turned = |angle: f64| Pose2::new(0.3, 0.2, normalize_angle(3.0 + angle));
    assert!(!with(1).reached(&turned(PI)));
    assert!(with(2).reached(&turned(PI)) && !with(2).reached(&turned(FRAC_PI_2)));
    assert!(with(4).reached(&turned(-FRAC_PI_2)) && with(0).reached(&turned(1.234)));
    let nearest = with(2).nearest(&turned(PI - 0.1));
    assert!(normalize_angle(nearest.theta - turned(PI).theta).abs() < 1e-12, "{nearest:?}");
}

#[test]
fn discs_are_symmetric_by_themselves() {
    let disc = || BodyDef::new(Shape::Disc { radius: 0.03 });
    let goals = vec![Some(Goal::at(at(0.5, 0.1))), Some(Goal::at(at(0.6, 0.1)))];
    let start = State::new([at(0.1, 0.1), at(0.2, 0.1)]);
    let problem = Rearrangement::new("discs", two(disc(), disc()), start, goals).unwrap();
    assert!(problem.at_goal(0, &Pose2::new(0.5, 0.1, 2.0)));
}

#[test]
fn problems_without_a_solution_are_refused_by_the_name_of_the_field() {
    let scene = two(square(), square());
    let (here, there) = (at(0.1, 0.1), at(0.3, 0.1));
    let apart = [here, there];
    let cases = [
        (refused(&scene, [here, at(0.15, 0.1)], [None, None]), "poses[1]: `b` overlaps `a`"),
        (refused(&scene, [at(0.04, 0.1), there], [None, None]), "poses[0]: `a` reaches 10.0 mm out"),
        (refused(&scene, apart, [Some(at(0.77, 0.1)), None]), "goals[0]: `a` reaches 40.0 mm out"),
        (refused(&scene, apart, [Some(at(0.5, 0.1)), Some(at(0.59, 0.1))]), "goals[1]: `b` overlaps `a` by 10.00"),
        (refused(&scene, apart, [Some(at(f64::NAN, 0.1)), None]), "goals[0].pose.x: is NaN"),
    ];
    for (error, wanted) in cases {
        assert!(error.starts_with(wanted), "{error}\n{wanted}");
    }
    let fixed = BodyDef { pickable: false, pushable: false, ..square() };
    let scene = two(square(), fixed);
    let error = refused(&scene, apart, [None, Some(at(0.5, 0.1))]);
    assert!(error.starts_with("goals[1]: `b` is neither pickable nor pushable"), "{error}");
    let error = refused(&scene, apart, [Some(at(0.35, 0.1)), None]);
    assert!(error.starts_with("goals[1]: `b` overlaps `a`"), "{error}");
    let few = Rearrangement::new("few", Arc::clone(&scene), State::new(apart), vec![None]);
    assert!(few.unwrap_err().to_string().starts_with("goals: has 1 goals for 2 bodies"));
}

#[test]
fn a_problem_is_solved_when_every_goal_is_reached() {
    let scene = two(square(), square());
    let goals = vec![Some(Goal::at(at(0.5, 0.1))), None];
    let problem = Rearrangement::new("one", scene, State::new([at(0.1, 0.1), at(0.3, 0.1)]), goals).unwrap();
    assert!(!problem.solved(&problem.start));
    let mut state = problem.start.clone();
    state.set_pose(0, at(0.503, 0.1));
    assert!(problem.solved(&state));
}
