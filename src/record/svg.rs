//! Pictures of scenes, actions and plans as SVG.
//!
//! A picture is a grid of panels, each a scene from above with x to the right and y up. The text is the same for the
//! same input on every machine: coordinates have fixed decimals.

use std::path::Path;

use super::drawing::{Drawing, DrawnAction, DrawnBody, Outline, Role};
use super::xml::{Anchor, Canvas, escape, number, wrap};
use crate::action::Action;
use crate::error::Result;
use crate::files;
use crate::geom::{Obb, Vec2};
use crate::scene::{Problem, Scene, State};

/// Greatest extent of what a panel shows, pixels.
const PLOT: f64 = 380.0;
const MARGIN: f64 = 18.0;
/// Between a view's edge and what is in it, pixels.
const RIM: f64 = 8.0;
/// Below a plot: axes and scale.
const STRIP: f64 = 34.0;
const LINE: f64 = 16.0;
const LEGEND: f64 = 30.0;
/// Width of a character of text in relation to its size, about.
const CHARACTER: f64 = 0.58;

const INK: &str = "#333333";
const FAINT: &str = "#777777";
const TARGET: &str = "#4e79a7";
const PUSH: &str = "#d1495b";
const GRASP: &str = "#2e8b57";

/// What is written on bodies.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Labels {
    /// Their indices. (Names show where the pointer rests on a body.)
    #[default]
    Index,
    /// Their names, as large as fits.
    Name,
    None,
}

/// A picture in the making: add panels, then [`render`](Self::render) or [`write`](Self::write).
#[derive(Default)]
pub struct SvgPicture {
    title: String,
    columns: Option<usize>,
    labels: Labels,
    panels: Vec<Drawing>,
}

impl SvgPicture {
    pub fn new() -> Self {
        Self::default()
    }

    /// A picture of a problem as it stands, with its name as the title.
    pub fn of_problem(problem: &Problem) -> Self {
        let mut picture = Self::new();
        picture.title(&problem.name);
        picture.panel(&problem.scene, &problem.state, Some(problem.target), None, None, "");
        picture
    }

    /// Written above the panels.
    pub fn title(&mut self, title: &str) -> &mut Self {
        self.title = title.to_owned();
        self
    }

    /// Panels side by side; at most three if not set.
    pub fn columns(&mut self, columns: usize) -> &mut Self {
        self.columns = Some(columns.max(1));
        self
    }

    pub fn labels(&mut self, labels: Labels) -> &mut Self {
        self.labels = labels;
        self
    }

    /// Adds a panel: the bodies at `state`, the target in blue, an action, and dashed where the bodies that move are
    /// expected `after` it. The caption stands above. Bodies at poses that are not finite are left out.
    pub fn panel(
        &mut self,
        scene: &Scene,
        state: &State,
        target: Option<usize>,
        action: Option<&Action>,
        after: Option<&State>,
        caption: &str,
    ) -> &mut Self {
        self.panels.push(Drawing::new(scene, state, target, action, after, caption));
        self
    }

    /// Draws a bar below the last panel, filled to a share between 0 and 1, with a text beside it.
    pub fn gauge(&mut self, share: f64, text: &str) -> &mut Self {
        if let Some(panel) = self.panels.last_mut() {
            panel.gauge = Some((share, text.to_owned()));
        }
        self
    }

    /// Adds a panel for every action of a plan: `steps` holds each action with the state expected after it.
    pub fn plan(&mut self, problem: &Problem, steps: &[(Action, Option<State>)]) -> &mut Self {
        self.steps(&problem.scene, &problem.state, Some(problem.target), steps)
    }

    /// The same for a problem without a target.
    pub fn steps(
        &mut self,
        scene: &Scene,
        state: &State,
        target: Option<usize>,
        steps: &[(Action, Option<State>)],
    ) -> &mut Self {
        let mut state = state;
        for (i, (action, after)) in steps.iter().enumerate() {
            let caption = format!("{} of {}", i + 1, steps.len());
            self.panel(scene, state, target, Some(action), after.as_ref(), &caption);
            state = after.as_ref().unwrap_or(state);
        }
        self
    }

    /// Writes the picture to a file.
    pub fn write(&self, path: impl AsRef<Path>) -> Result<()> {
        files::write(path, self.render())
    }

    /// The picture as an SVG document.
    pub fn render(&self) -> String {
        let frame = Layout::new(self);
        let mut canvas = Canvas::default();
        let [width, height] = frame.size.map(number);
        canvas.open(&format!(
            "svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{width}\" height=\"{height}\" viewBox=\"0 0 {width} \
             {height}\" font-family=\"DejaVu Sans, Verdana, Helvetica, Arial, sans-serif\""
        ));
        canvas.rect([0.0, 0.0], frame.size, "fill=\"#ffffff\"");
        for (i, line) in frame.title.iter().enumerate() {
            let at = [MARGIN, MARGIN + 15.0 + 20.0 * i as f64];
            canvas.label(at, 17.0, Anchor::Start, &format!("font-weight=\"bold\" fill=\"{INK}\""), line);
        }
        for (i, panel) in self.panels.iter().enumerate() {
            let [x, y] = frame.corner(i);
            canvas.open(&format!("g transform=\"translate({} {})\"", number(x), number(y)));
            self.draw_panel(&mut canvas, &frame, panel);
            canvas.close("g");
        }
        self.draw_legend(&mut canvas, &frame);
        canvas.close("svg");
        canvas.text
    }

    fn draw_panel(&self, canvas: &mut Canvas, layout: &Layout, panel: &Drawing) {
        let mut y = 0.0;
        for (text, style) in [
            (&panel.caption, format!("font-weight=\"bold\" fill=\"{INK}\"")),
            (&panel.details, format!("fill=\"{FAINT}\"")),
        ] {
            for line in wrap(text, layout.characters(12.0)) {
                y += LINE;
                canvas.label([0.0, y - 4.0], 12.0, Anchor::Start, &style, &line);
            }
        }
        let plot = Plot { view: panel.view, scale: layout.scale };
        let size = plot.size();
        let [w, h] = size.map(number);
        canvas
            .open(&format!("svg y=\"{}\" width=\"{w}\" height=\"{h}\" viewBox=\"0 0 {w} {h}\"", number(layout.header)));
        canvas.rect([0.0, 0.0], size, "fill=\"#eceae6\"");
        let [low, high] = panel.workspace.map(|p| plot.point(p));
        let inner = [high[0] - low[0], low[1] - high[1]];
        canvas.rect([low[0], high[1]], inner, "fill=\"#fbfaf8\" stroke=\"#9a958c\" stroke-dasharray=\"6 3\"");
        for body in &panel.bodies {
            plot.draw_body(canvas, body);
        }
        for body in &panel.predicted {
            plot.draw_predicted(canvas, body);
        }
        if let Some(action) = &panel.action {
            plot.draw_action(canvas, action);
        }
        for body in &panel.bodies {
            plot.draw_label(canvas, body, self.labels);
        }
        canvas.close("svg");
        draw_strip(canvas, layout, size, layout.header + size[1]);
        if let Some((share, text)) = &panel.gauge {
            draw_gauge(canvas, *share, text, layout.header + size[1]);
        }
    }

    /// Explains the marks that occur.
    fn draw_legend(&self, canvas: &mut Canvas, layout: &Layout) {
        let mut at = [MARGIN, layout.size[1] - MARGIN - 4.0];
        let has_role = |role| self.panels.iter().any(|p| p.bodies.iter().any(|b| b.role == role));
        let has_push = self.panels.iter().any(|p| matches!(p.action, Some(DrawnAction::Push { .. })));
        let has_grasp = self.panels.iter().any(|p| matches!(p.action, Some(DrawnAction::Grasp { .. })));
        for (shown, style, text) in [
            (has_role(Role::Target), body_style(Role::Target).to_owned(), "target"),
            (has_role(Role::Body), body_style(Role::Body).to_owned(), "body"),
            (has_role(Role::Obstacle), body_style(Role::Obstacle).to_owned(), "obstacle"),
            (self.panels.iter().any(|p| !p.predicted.is_empty()), predicted_style(INK), "expected afterwards"),
            (has_push, tool_style(PUSH), "push tip"),
            (has_grasp, tool_style(GRASP), "finger"),
        ] {
            if !shown {
                continue;
            }
            let width = 18.0 + 11.0 * CHARACTER * text.len() as f64 + 16.0;
            if at[0] + width > layout.size[0] && at[0] > MARGIN {
                // A narrow picture loses the last entries rather than its shape.
                break;
            }
            canvas.rect([at[0], at[1] - 9.0], [12.0, 10.0], &style);
            canvas.label([at[0] + 18.0, at[1]], 11.0, Anchor::Start, &format!("fill=\"{INK}\""), text);
            at[0] += width;
        }
    }
}

fn body_style(role: Role) -> &'static str {
    match role {
        Role::Target => "fill=\"#4e79a7\" stroke=\"#2f4f73\" stroke-width=\"1.2\"",
        Role::Body => "fill=\"#e3d5bd\" stroke=\"#8c7650\" stroke-width=\"1.2\"",
        Role::Obstacle => "fill=\"#a9a6a1\" stroke=\"#5f5c57\" stroke-width=\"1.2\"",
    }
}

fn predicted_style(colour: &str) -> String {
    format!("fill=\"none\" stroke=\"{colour}\" stroke-width=\"1.3\" stroke-dasharray=\"4 2.5\"")
}

fn tool_style(colour: &str) -> String {
    format!("fill=\"{colour}\" fill-opacity=\"0.45\" stroke=\"{colour}\" stroke-width=\"1.2\"")
}

/// Axes and a bar of 5 cm, below a plot.
fn draw_strip(canvas: &mut Canvas, layout: &Layout, size: [f64; 2], top: f64) {
    let origin = [6.0, top + 27.0];
    let style = format!("fill=\"{FAINT}\"");
    canvas.arrow(origin, [origin[0] + 22.0, origin[1]], 1.4, FAINT);
    canvas.arrow(origin, [origin[0], origin[1] - 20.0], 1.4, FAINT);
    canvas.label([origin[0] + 25.0, origin[1] + 3.5], 11.0, Anchor::Start, &style, "x");
    canvas.label([origin[0] + 5.0, origin[1] - 13.0], 11.0, Anchor::Start, &style, "y");
    let bar = 0.05 * layout.scale;
    let (right, y) = (size[0] - 1.0, top + 12.0);
    let stroke = format!("stroke=\"{FAINT}\" stroke-width=\"1.4\"");
    canvas.segment([right - bar, y], [right, y], &stroke);
    for x in [right - bar, right] {
        canvas.segment([x, y - 4.0], [x, y + 4.0], &stroke);
    }
    canvas.label([right - bar / 2.0, y + 15.0], 11.0, Anchor::Middle, &style, "5 cm");
}

/// A bar that is filled to a share, between the axes and the scale below a plot.
fn draw_gauge(canvas: &mut Canvas, share: f64, text: &str, top: f64) {
    let (corner, size) = ([50.0, top + 8.0], [110.0, 9.0]);
    let filled = if share.is_finite() { share.clamp(0.0, 1.0) * size[0] } else { 0.0 };
    canvas.rect(corner, [filled, size[1]], &format!("fill=\"{GRASP}\""));
    canvas.rect(corner, size, &format!("fill=\"none\" stroke=\"{FAINT}\""));
    canvas.label([corner[0], top + 30.0], 11.0, Anchor::Start, &format!("fill=\"{INK}\""), text);
}

/// Where everything goes.
struct Layout {
    size: [f64; 2],
    title: Vec<String>,
    columns: usize,
    /// Pixels a metre, the same for all panels.
    scale: f64,
    plot: [f64; 2],
    /// Height of caption and details.
    header: f64,
    top: f64,
}

impl Layout {
    fn new(picture: &SvgPicture) -> Layout {
        let extent = picture.panels.iter().map(|p| p.view[1] - p.view[0]).reduce(|a, b| a.sup(&b));
        let extent = extent.unwrap_or_else(|| Vec2::new(1.0, 1.0));
        let scale = (PLOT - 2.0 * RIM) / extent.max();
        let plot = [extent.x * scale + 2.0 * RIM, extent.y * scale + 2.0 * RIM];
        let columns = picture.columns.unwrap_or(3).min(picture.panels.len()).max(1);
        let rows = picture.panels.len().div_ceil(columns);
        let width = MARGIN + columns as f64 * (plot[0] + MARGIN);
        let title = wrap(&picture.title, ((width - 2.0 * MARGIN) / (17.0 * 0.66)) as usize);
        let mut layout = Layout { size: [width, 0.0], title, columns, scale, plot, header: 0.0, top: MARGIN };
        let lines = |p: &Drawing| {
            wrap(&p.caption, layout.characters(12.0)).len() + wrap(&p.details, layout.characters(12.0)).len()
        };
        layout.header = LINE * picture.panels.iter().map(lines).max().unwrap_or(0) as f64;
        if !layout.title.is_empty() {
            layout.top += 20.0 * layout.title.len() as f64 + 8.0;
        }
        layout.size[1] = layout.top + rows as f64 * layout.row() + LEGEND;
        layout
    }

    fn row(&self) -> f64 {
        self.header + self.plot[1] + STRIP + MARGIN
    }

    /// Characters of a size that fit over a plot.
    fn characters(&self, size: f64) -> usize {
        (self.plot[0] / (size * CHARACTER)) as usize
    }

    fn corner(&self, panel: usize) -> [f64; 2] {
        let (column, row) = (panel % self.columns, panel / self.columns);
        [MARGIN + column as f64 * (self.plot[0] + MARGIN), self.top + row as f64 * self.row()]
    }
}

/// From the world to a panel's pixels.
struct Plot {
    view: [Vec2; 2],
    scale: f64,
}

impl Plot {
    fn size(&self) -> [f64; 2] {
        let extent = self.view[1] - self.view[0];
        [extent.x * self.scale + 2.0 * RIM, extent.y * self.scale + 2.0 * RIM]
    }

    fn point(&self, p: Vec2) -> [f64; 2] {
        [(p.x - self.view[0].x) * self.scale + RIM, (self.view[1].y - p.y) * self.scale + RIM]
    }

    fn draw_outline(&self, canvas: &mut Canvas, outline: &Outline, style: &str) {
        match outline {
            Outline::Polygon(points) => {
                let points: Vec<_> = points.iter().map(|p| self.point(*p)).collect();
                canvas.polygon(&points, style);
            }
            Outline::Disc { centre, radius } => canvas.circle(self.point(*centre), radius * self.scale, style),
        }
    }

    fn draw_body(&self, canvas: &mut Canvas, body: &DrawnBody) {
        canvas.open("g stroke-linejoin=\"round\"");
        canvas.text.push_str(&format!("<title>{}</title>\n", escape(&body.name)));
        for outline in &body.outlines {
            self.draw_outline(canvas, outline, body_style(body.role));
        }
        canvas.close("g");
    }

    fn draw_predicted(&self, canvas: &mut Canvas, body: &DrawnBody) {
        let colour = if body.role == Role::Target { TARGET } else { INK };
        for outline in &body.outlines {
            self.draw_outline(canvas, outline, &predicted_style(colour));
        }
    }

    fn draw_label(&self, canvas: &mut Canvas, body: &DrawnBody, labels: Labels) {
        let text = match labels {
            Labels::Index => body.index.to_string(),
            Labels::Name => body.name.clone(),
            Labels::None => return,
        };
        let (at, room) = body.label;
        let [x, y] = self.point(at);
        let width = text.chars().count().max(1) as f64 * CHARACTER;
        let size = (2.0 * room * self.scale / width.max(1.0)).clamp(6.0, 12.0);
        let fill = if body.role == Role::Target { "#ffffff" } else { INK };
        canvas.label([x, y + 0.36 * size], size, Anchor::Middle, &format!("fill=\"{fill}\""), &text);
    }

    fn draw_tool(&self, canvas: &mut Canvas, tool: &Obb, style: &str) {
        canvas.polygon(&tool.corners().map(|c| self.point(c)), style);
    }

    fn draw_action(&self, canvas: &mut Canvas, action: &DrawnAction) {
        match action {
            DrawnAction::Push { tip, way } => {
                self.draw_tool(canvas, &tip[0], &tool_style(PUSH));
                self.draw_tool(canvas, &tip[1], &predicted_style(PUSH));
                canvas.arrow(self.point(way[0]), self.point(way[1]), 2.6, PUSH);
            }
            DrawnAction::Grasp { fingers, closing } => {
                for finger in fingers {
                    self.draw_tool(canvas, finger, &tool_style(GRASP));
                }
                for [from, to] in closing {
                    canvas.arrow(self.point(*from), self.point(*to), 2.0, GRASP);
                }
            }
        }
    }
}

#[cfg(test)]
#[path = "svg_tests.rs"]
mod tests;
