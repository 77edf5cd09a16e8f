use super::*;
use crate::action::{Grasp, Push};
use crate::geom::{Pose2, Shape, vec2};
use crate::scene::{BodyDef, SceneBuilder, Workspace, library};

fn problem() -> Problem {
    let mut b = SceneBuilder::new();
    for (i, block) in ["cube", "concave", "rect", "cylinder", "triangle", "half_cube"].into_iter().enumerate() {
        b.add_body(library::block(block).unwrap().named(format!("{block} {i}"))).unwrap();
    }
    let mut bottle = BodyDef::new(Shape::Disc { radius: 0.03 }).named("bottle <1> & co");
    (bottle.pickable, bottle.pushable) = (false, false);
    b.add_body(bottle).unwrap();
    let state = State::new([
        Pose2::new(0.5, 0.0, 0.3),
        Pose2::new(0.505, 0.056, 3.4),
        Pose2::new(0.448, -0.02, 0.3),
        Pose2::new(0.55, 0.02, 0.0),
        Pose2::new(0.54, -0.05, -1.27),
        Pose2::new(0.39, 0.03, 1.0),
        Pose2::new(0.64, 0.14, 0.0),
    ]);
    Problem::new("seven & more", std::sync::Arc::new(b.build().unwrap()), state, 0).unwrap()
}

fn plan() -> (Problem, Vec<(Action, Option<State>)>) {
    let problem = problem();
    let mut push = Push::new(vec2(0.60, -0.09), vec2(0.51, -0.11));
    push.body = Some(4);
    let mut after = problem.state.clone();
    after.set_pose(4, Pose2::new(0.47, -0.1, -1.5));
    after.set_pose(2, Pose2::new(0.425, -0.02, 0.45));
    after.set_pose(0, Pose2::new(0.495, 0.002, 0.35));
    let grasp = Grasp {
        body: 0,
        position: [0.495, 0.002],
        angle: 0.35,
        opening: 0.075,
        width: 0.045,
        margin: 0.0031,
        score: 0.92,
    };
    let mut gone = after.clone();
    gone.set_present(0, false);
    (problem, vec![(Action::Push(push), Some(after)), (Action::Grasp(grasp), Some(gone))])
}

/// Every element is closed, and quotes and angle brackets are where XML has them.
fn check_xml(text: &str) {
    let mut open: Vec<&str> = Vec::new();
    let mut rest = text;
    while let Some(start) = rest.find('<') {
        assert!(!rest[..start].contains('>'), "{}", &rest[..start]);
        let end = start + rest[start..].find('>').unwrap();
        let tag = &rest[start + 1..end];
        assert!(!tag.contains('<') && tag.matches('"').count().is_multiple_of(2), "{tag}");
        let name = tag.trim_start_matches('/').split([' ', '/']).next().unwrap();
        if tag.starts_with('/') {
            assert_eq!(open.pop(), Some(name));
        } else if !tag.ends_with('/') {
            open.push(name);
        }
        rest = &rest[end + 1..];
    }
    assert!(open.is_empty() && rest.trim().is_empty());
    assert!(!text.contains("NaN") && !text.contains("inf"));
}

#[test]
fn a_plan_has_a_panel_for_every_action() {
    let (problem, steps) = plan();
    let mut picture = SvgPicture::new();
    picture.title("A plan: \"push\" & grasp").plan(&problem, &steps);
    let text = picture.render();
    check_xml(&text);
    assert_eq!(text, picture.render());
    for part in [
        "1 of 2",
        "2 of 2",
        "push triangle 4: 92 mm at -167\u{b0}",
        "grasp cube 0: score 0.92, margin 3.1 mm, opening",
        "<title>bottle &lt;1&gt; &amp; co</title>",
        "A plan: &quot;push&quot; &amp; grasp",
        "expected afterwards",
        "5 cm",
    ] {
        assert!(text.contains(part), "{part}");
    }
    // Only what moves is shown again: three bodies in the first panel, none in the second, and the tip's end.
    assert_eq!(text.matches("fill=\"none\"").count(), 3 + 1 + 1);
    if let Some(path) = std::env::var_os("JOSTLE_PICTURE") {
        picture.write(path).unwrap();
    }
}

#[test]
fn a_small_picture_is_as_it_was() {
    let mut b = SceneBuilder::new();
    b.add_body(BodyDef::new(Shape::rectangle(0.04, 0.02)).named("<bar>")).unwrap();
    b.add_body(BodyDef::new(Shape::Disc { radius: 0.01 }).named("disc")).unwrap();
    b.workspace(Workspace::rectangle(vec2(0.0, 0.0), vec2(0.1, 0.05)));
    let scene = b.build().unwrap();
    let state = State::new([Pose2::new(0.03, 0.025, 0.0), Pose2::new(0.07, 0.025, 0.0)]);
    let mut after = state.clone();
    after.set_pose(1, Pose2::new(0.08, 0.025, 0.0));
    let push = Action::Push(Push::new(vec2(0.04, 0.02), vec2(0.06, 0.02)));
    let mut picture = SvgPicture::new();
    picture.title("bar & disc").panel(&scene, &state, Some(1), Some(&push), Some(&after), "aside");
    let text = picture.render();
    check_xml(&text);
    let golden = include_str!("golden/small.svg");
    if std::env::var_os("JOSTLE_BLESS").is_some() {
        let path = concat!(env!("CARGO_MANIFEST_DIR"), "/src/record/golden/small.svg");
        std::fs::write(path, &text).unwrap();
    } else {
        assert_eq!(text, golden, "run with JOSTLE_BLESS=1 if the change is meant, and look at the picture");
    }
}

#[test]
fn nothing_breaks_a_picture() {
    let (problem, steps) = plan();
    check_xml(&SvgPicture::new().render());
    let mut far = problem.state.clone();
    far.set_pose(1, Pose2::new(f64::NAN, 0.0, 0.0));
    far.set_pose(2, Pose2::new(1e30, -1e30, 0.0));
    far.set_pose(3, Pose2::new(0.8, 0.3, 0.0));
    let nowhere = Action::Push(Push::new(vec2(f64::NAN, 0.0), vec2(0.0, 0.0)));
    let still = Action::Push(Push::new(vec2(0.5, 0.0), vec2(0.5, 0.0)));
    let odd = Action::Grasp(Grasp { body: 99, angle: f64::INFINITY, ..Grasp::default() });
    let few = State::new([Pose2::new(0.5, 0.0, 0.0)]);
    let mut picture = SvgPicture::new();
    for labels in [Labels::Index, Labels::Name, Labels::None] {
        picture.labels(labels).columns(0);
        for action in [None, Some(&nowhere), Some(&still), Some(&odd), Some(&steps[1].0)] {
            picture.panel(&problem.scene, &far, Some(99), action, Some(&few), "caption < & > \u{1}");
            picture.panel(&problem.scene, &few, None, action, Some(&far), &"long ".repeat(50));
        }
        let text = picture.render();
        check_xml(&text.replace("NaN mm", ""));
    }
}

#[test]
fn a_picture_is_written_to_a_file() {
    let path = std::env::temp_dir().join(format!("jostle-picture-{}.svg", std::process::id()));
    let mut picture = SvgPicture::of_problem(&problem());
    picture.labels(Labels::Name).write(&path).unwrap();
    assert_eq!(std::fs::read_to_string(&path).unwrap(), picture.render());
    std::fs::remove_file(&path).unwrap();
    assert!(matches!(picture.write("/no/such/folder/x.svg"), Err(crate::Error::Io { .. })));
}
