//! Pictures of rearrangements: a panel for the start, for each move and for the goal; or one panel that moves (SMIL).
//!
//! Bodies that can only be dragged have a bold edge; goals are dashed outlines in the colour of their body.

use super::xml::{Anchor, Canvas, escape, number};
use crate::action::Move;
use crate::geom::{Piece, Pose2, Vec2, normalize_angle, vec2};
use crate::scene::{Body, Rearrangement, State};

/// Pixels of a panel's longer side.
const PLOT: f64 = 360.0;
const MARGIN: f64 = 16.0;
/// Above a panel, for its caption.
const CAPTION: f64 = 22.0;
const COLUMNS: usize = 3;
/// Seconds of an animation for a metre of way, for a move at the least, and of rest at both ends.
const SECONDS_PER_METRE: f64 = 2.5;
const LEAST_SECONDS: f64 = 0.4;
const REST: f64 = 1.0;

const INK: &str = "#333333";
const WAY: &str = "#d1495b";
const COLOURS: [&str; 10] =
    ["#4e79a7", "#f28e2b", "#59a14f", "#b07aa1", "#76b7b2", "#edc948", "#9c755f", "#ff9da7", "#86bc86", "#a0cbe8"];
/// A body that can only be dragged has a bold edge.
const EDGES: [&str; 2] = ["1", "2.6"];

fn colour(body: usize) -> &'static str {
    COLOURS[body % COLOURS.len()]
}

/// World to pixels of a panel.
struct Plot {
    corner: [f64; 2],
    low: Vec2,
    size: [f64; 2],
    scale: f64,
}

impl Plot {
    fn new(problem: &Rearrangement, corner: [f64; 2]) -> Plot {
        let w = problem.scene.workspace();
        let extent = [w.max[0] - w.min[0], w.max[1] - w.min[1]];
        let scale = PLOT / extent[0].max(extent[1]);
        Plot { corner, low: vec2(w.min[0], w.min[1]), size: extent.map(|e| e * scale), scale }
    }

    fn at(&self, p: Vec2) -> [f64; 2] {
        let q = (p - self.low) * self.scale;
        [self.corner[0] + q.x, self.corner[1] + self.size[1] - q.y]
    }
}

/// Outlines of a body in its frame: discs as such, everything else as polygons.
enum Outline {
    Disc(Vec2, f64),
    Polygon(Vec<Vec2>),
}

fn outlines(body: &Body) -> Vec<Outline> {
    let footprint = &body.footprint;
    if footprint.pieces.iter().all(|p| matches!(p, Piece::Disc { .. })) {
        let disc = |p: &Piece| match p {
            Piece::Disc { centre, radius } => Some(Outline::Disc(*centre, *radius)),
            Piece::Convex(_) => None,
        };
        footprint.pieces.iter().filter_map(disc).collect()
    } else {
        footprint.outlines.iter().map(|o| Outline::Polygon(o.clone())).collect()
    }
}

fn draw_body(canvas: &mut Canvas, plot: &Plot, body: &Body, pose: &Pose2, style: &str) {
    let frame = pose.frame();
    for outline in outlines(body) {
        match outline {
            Outline::Disc(centre, radius) => {
                canvas.circle(plot.at(frame.point(centre)), radius * plot.scale, style);
            }
            Outline::Polygon(points) => {
                let points: Vec<_> = points.iter().map(|&p| plot.at(frame.point(p))).collect();
                canvas.polygon(&points, style);
            }
        }
    }
}

fn filled(problem: &Rearrangement, body: usize) -> String {
    let b = problem.scene.body(body);
    let edge = EDGES[usize::from(!b.pickable)];
    format!("fill=\"{}\" fill-opacity=\"0.75\" stroke=\"{INK}\" stroke-width=\"{edge}\"", colour(body))
}

fn dashed(body: usize) -> String {
    format!("fill=\"none\" stroke=\"{}\" stroke-width=\"1.4\" stroke-dasharray=\"5 3\"", colour(body))
}

fn draw_table(canvas: &mut Canvas, plot: &Plot) {
    canvas.rect(plot.corner, plot.size, &format!("fill=\"#fafafa\" stroke=\"{INK}\" stroke-width=\"1\""));
}

fn draw_goals(canvas: &mut Canvas, plot: &Plot, problem: &Rearrangement) {
    for (body, goal) in problem.goals.iter().enumerate() {
        if let Some(goal) = goal {
            draw_body(canvas, plot, problem.scene.body(body), &goal.pose, &dashed(body));
        }
    }
}

fn draw_state(canvas: &mut Canvas, plot: &Plot, problem: &Rearrangement, state: &State) {
    for (index, pose) in state.iter().filter(|(i, _)| *i < problem.scene.len()) {
        let body = problem.scene.body(index);
        draw_body(canvas, plot, body, &pose, &filled(problem, index));
        let middle = plot.at(pose.transform_point(body.footprint.centroid));
        let style = format!("fill=\"{INK}\"");
        canvas.label([middle[0], middle[1] + 4.0], 12.0, Anchor::Middle, &style, &index.to_string());
    }
}

fn document(size: [f64; 2], title: &str, body: &str) -> String {
    let [w, h] = size.map(number);
    let title = escape(title);
    format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{w}\" height=\"{h}\" viewBox=\"0 0 {w} {h}\" \
         font-family=\"sans-serif\">\n<title>{title}</title>\n<rect width=\"{w}\" height=\"{h}\" fill=\"#ffffff\"/>\n\
         {body}</svg>\n"
    )
}

fn caption(problem: &Rearrangement, step: usize, action: &Move) -> String {
    let name = problem.scene.bodies().get(action.body()).map_or("?", |b| b.name.as_str());
    match action {
        Move::PickPlace { .. } => format!("{}. pick and place {name}", step + 1),
        Move::Drag { .. } => format!("{}. drag {name}", step + 1),
    }
}

/// Start, every move, goal: a panel each. Without moves, start and goal.
pub fn rearrangement_svg(problem: &Rearrangement, moves: &[Move]) -> String {
    let mut canvas = Canvas::default();
    let probe = Plot::new(problem, [0.0, 0.0]);
    let step = [probe.size[0] + MARGIN, probe.size[1] + CAPTION + MARGIN];
    let panels = moves.len() + 2;
    let columns = COLUMNS.min(panels);
    let mut state = problem.start.clone();
    for panel in 0..panels {
        let corner =
            [MARGIN + (panel % columns) as f64 * step[0], MARGIN + CAPTION + (panel / columns) as f64 * step[1]];
        let plot = Plot::new(problem, corner);
        let text = match panel {
            0 => format!("{}: start", problem.name),
            _ if panel == panels - 1 => "goal".to_owned(),
            _ => caption(problem, panel - 1, &moves[panel - 1]),
        };
        let style = format!("fill=\"{INK}\"");
        canvas.label([corner[0], corner[1] - 7.0], 13.0, Anchor::Start, &style, &text);
        draw_table(&mut canvas, &plot);
        if panel == panels - 1 {
            let mut goal = state.clone();
            for (body, wanted) in problem.goals.iter().enumerate() {
                // After a plan, what it has reached; of the problem alone, what is wanted.
                if let (Some(wanted), true) = (wanted, moves.is_empty()) {
                    goal.set_pose(body, wanted.pose);
                }
            }
            draw_state(&mut canvas, &plot, problem, &goal);
            draw_goals(&mut canvas, &plot, problem);
            continue;
        }
        draw_state(&mut canvas, &plot, problem, &state);
        if panel == 0 {
            draw_goals(&mut canvas, &plot, problem);
            continue;
        }
        let action = &moves[panel - 1];
        if action.body() >= problem.scene.len() {
            continue;
        }
        let body = problem.scene.body(action.body());
        draw_body(&mut canvas, &plot, body, &action.to(), &dashed(action.body()));
        let poses = action.poses();
        let middle = |pose: &Pose2| plot.at(pose.transform_point(body.footprint.centroid));
        let style = format!("stroke=\"{WAY}\" stroke-width=\"1.6\"");
        for (i, pair) in poses.windows(2).enumerate() {
            if i + 2 == poses.len() {
                canvas.arrow(middle(&pair[0]), middle(&pair[1]), 1.6, WAY);
            } else {
                canvas.segment(middle(&pair[0]), middle(&pair[1]), &style);
            }
        }
        state.set_pose(action.body(), action.to());
    }
    let rows = panels.div_ceil(columns) as f64;
    let size = [MARGIN + columns as f64 * step[0], MARGIN + rows * step[1]];
    document(size, &problem.name, &canvas.text)
}

/// The whole plan as one picture that moves, over and over.
pub fn rearrangement_animation(problem: &Rearrangement, moves: &[Move]) -> String {
    let mut canvas = Canvas::default();
    let plot = Plot::new(problem, [MARGIN, MARGIN + CAPTION]);
    let style = format!("fill=\"{INK}\"");
    canvas.label([MARGIN, MARGIN + CAPTION - 7.0], 13.0, Anchor::Start, &style, &problem.name);
    draw_table(&mut canvas, &plot);
    draw_goals(&mut canvas, &plot, problem);
    // Key frames of each body: time, position in pixels, heading in degrees that never jumps.
    let frame = |pose: &Pose2, before: Option<f64>| {
        let at = plot.at(pose.position());
        let turned = -pose.theta.to_degrees();
        let turned = before.map_or(turned, |b| b + normalize_angle((turned - b).to_radians()).to_degrees());
        (at, turned)
    };
    let mut keys: Vec<Vec<(f64, [f64; 2], f64)>> = Vec::new();
    for body in 0..problem.scene.len() {
        let (at, turned) = frame(&problem.start.pose(body), None);
        keys.push(vec![(0.0, at, turned)]);
    }
    let mut now = REST;
    for action in moves.iter().filter(|action| action.body() < problem.scene.len()) {
        let keys = &mut keys[action.body()];
        for (i, pose) in action.poses().iter().enumerate() {
            let last = keys.last().map_or(([0.0; 2], 0.0), |k| (k.1, k.2));
            let (at, turned) = frame(pose, Some(last.1));
            if i > 0 {
                let pixels = (at[0] - last.0[0]).hypot(at[1] - last.0[1]);
                let turn = (turned - last.1).abs().to_radians();
                now += (SECONDS_PER_METRE * (pixels / plot.scale + 0.1 * turn)).max(LEAST_SECONDS / 4.0);
            }
            keys.push((now, at, turned));
        }
        now += LEAST_SECONDS / 2.0;
    }
    let total = now + REST;
    for (index, keys) in keys.iter().enumerate() {
        let (_, at, turned) = keys[0];
        canvas.open(&format!("g transform=\"translate({} {})\"", number(at[0]), number(at[1])));
        animate(&mut canvas, "translate", keys, total, |k| format!("{} {}", number(k.1[0]), number(k.1[1])));
        canvas.open(&format!("g transform=\"rotate({})\"", number(turned)));
        animate(&mut canvas, "rotate", keys, total, |k| number(k.2));
        let body = problem.scene.body(index);
        let own = Plot { corner: [0.0, 0.0], low: vec2(0.0, 0.0), size: [0.0, 0.0], scale: plot.scale };
        draw_body(&mut canvas, &own, body, &Pose2::IDENTITY, &filled(problem, index));
        let middle = own.at(body.footprint.centroid);
        canvas.label([middle[0], middle[1] + 4.0], 12.0, Anchor::Middle, &style, &index.to_string());
        canvas.close("g");
        canvas.close("g");
    }
    let size = [plot.size[0] + 2.0 * MARGIN, plot.size[1] + CAPTION + 2.0 * MARGIN];
    document(size, &problem.name, &canvas.text)
}

fn animate(
    canvas: &mut Canvas,
    kind: &str,
    keys: &[(f64, [f64; 2], f64)],
    total: f64,
    value: impl Fn(&(f64, [f64; 2], f64)) -> String,
) {
    if keys.len() < 2 {
        return;
    }
    let mut times: Vec<String> = keys.iter().map(|k| format!("{:.5}", k.0 / total)).collect();
    let mut values: Vec<String> = keys.iter().map(&value).collect();
    times.push("1".to_owned());
    values.push(values[values.len() - 1].clone());
    let (times, values, total) = (times.join(";"), values.join(";"), number(total));
    canvas.open(&format!(
        "animateTransform attributeName=\"transform\" type=\"{kind}\" dur=\"{total}s\" repeatCount=\"indefinite\" \
         keyTimes=\"{times}\" values=\"{values}\"/"
    ));
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geom::Shape;
    use crate::scene::{BodyDef, Goal, SceneBuilder};
    use std::sync::Arc;

    fn example() -> (Rearrangement, Vec<Move>) {
        let mut builder = SceneBuilder::new();
        builder.add_body(BodyDef::new(Shape::rectangle(0.05, 0.03)).named("a <b>")).unwrap();
        builder.add_body(BodyDef { pickable: false, ..BodyDef::new(Shape::Disc { radius: 0.03 }) }).unwrap();
        let at = Pose2::new;
        let start = [at(0.4, 0.0, 3.0), at(0.5, 0.1, 0.0)];
        let goal = [at(0.6, 0.0, -3.0), at(0.4, -0.1, 0.0)];
        let problem = Rearrangement::new(
            "two",
            Arc::new(builder.build().unwrap()),
            State::new(start),
            goal.iter().map(|g| Some(Goal::at(*g))).collect(),
        )
        .unwrap();
        let moves = vec![
            Move::PickPlace { body: 0, pick: start[0], place: goal[0] },
            Move::Drag { body: 1, waypoints: [start[1], at(0.45, 0.1, 0.0), goal[1]].into() },
        ];
        (problem, moves)
    }

    #[test]
    fn there_is_a_panel_for_start_goal_and_each_move() {
        let (problem, moves) = example();
        let svg = rearrangement_svg(&problem, &moves);
        for text in ["two: start", "1. pick and place a &lt;b&gt;", "2. drag body 1", ">goal<"] {
            assert!(svg.contains(text), "{text} is missing from\n{svg}");
        }
        assert_eq!(svg.matches("fill=\"#fafafa\"").count(), 4);
        assert_eq!(rearrangement_svg(&problem, &[]).matches("fill=\"#fafafa\"").count(), 2);
        assert_eq!(svg, rearrangement_svg(&problem, &moves));
    }

    #[test]
    fn an_animation_turns_the_shorter_way_and_ends_at_the_goal() {
        let (problem, moves) = example();
        let svg = rearrangement_animation(&problem, &moves);
        assert_eq!(svg.matches("<animateTransform").count(), 4);
        // From -171.9 degrees on to -188.1, not back through 0.
        assert!(svg.contains("values=\"-171.89;-171.89;-188.11;-188.11\""), "{svg}");
        assert_eq!(svg.matches("<g").count(), svg.matches("</g>").count());
    }
}
