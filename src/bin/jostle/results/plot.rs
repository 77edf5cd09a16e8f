//! A picture of values over a setting, as SVG: ours with standard errors, the published ones hollow. The colours can be
//! read on light and on dark pages, and nothing is drawn behind them.

use std::fmt::Write as _;

use super::metrics::{Figure, Form};

/// What a picture shows.
#[derive(Debug, Clone)]
pub struct Chart {
    pub title: String,
    /// Titles of the axes, with units.
    pub x: String,
    pub y: String,
    pub form: Form,
    pub logarithmic: bool,
    pub series: Vec<Series>,
}

#[derive(Debug, Clone, Default)]
pub struct Series {
    pub name: String,
    /// In the order of `x`.
    pub points: Vec<(f64, Figure)>,
    pub published: Vec<(f64, f64)>,
}

const SIZE: [f64; 2] = [640.0, 380.0];
/// Left, top, right, bottom of the field.
const FIELD: [f64; 4] = [64.0, 66.0, 620.0, 324.0];
const COLOURS: [&str; 6] = ["#3b7dd8", "#e0701a", "#229a63", "#a35bc9", "#c8485b", "#8a8f2a"];
const INK: &str = "#7a818a";

/// A linear or logarithmic scale from values to pixels.
struct Axis {
    from: f64,
    to: f64,
    pixels: [f64; 2],
    logarithmic: bool,
}

impl Axis {
    fn at(&self, value: f64) -> f64 {
        let of = |v: f64| if self.logarithmic { v.log10() } else { v };
        let share = (of(value) - of(self.from)) / (of(self.to) - of(self.from));
        self.pixels[0] + share * (self.pixels[1] - self.pixels[0])
    }
}

impl Chart {
    /// Whether there is anything of ours to show.
    pub fn is_empty(&self) -> bool {
        self.series.iter().all(|series| series.points.is_empty())
    }

    fn scale(&self) -> f64 {
        if self.form == Form::Share { 100.0 } else { 1.0 }
    }

    pub fn svg(&self) -> String {
        let mut svg = String::new();
        let [width, height] = SIZE;
        let [left, top, right, bottom] = FIELD;
        // Writing to a string does not fail.
        let _ = writeln!(
            svg,
            "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{width}\" height=\"{height}\" viewBox=\"0 0 {width} {height}\" \
             font-family=\"DejaVu Sans, Verdana, Helvetica, Arial, sans-serif\" font-size=\"12\" fill=\"{INK}\">"
        );
        let _ = writeln!(svg, "<title>{}</title>", escape(&self.title));
        text(&mut svg, [left, 22.0], "font-size=\"15\" font-weight=\"bold\"", &self.title);
        let (x, y) = self.axes();
        let (ticks, digits) = self.y_ticks(&y);
        for tick in ticks {
            let at = y.at(tick);
            line(&mut svg, [left, at], [right, at], &format!("stroke=\"{INK}\" stroke-opacity=\"0.25\""));
            text(&mut svg, [left - 8.0, at + 4.0], "text-anchor=\"end\"", &format!("{tick:.digits$}"));
        }
        line(&mut svg, [left, bottom], [right, bottom], &format!("stroke=\"{INK}\""));
        let mut last = f64::NEG_INFINITY;
        for value in self.values_of_x() {
            let at = x.at(value);
            line(&mut svg, [at, bottom], [at, bottom + 5.0], &format!("stroke=\"{INK}\""));
            let label = format!("{value}");
            // Labels that would run into each other are left out.
            if at - last > 8.0 * label.len() as f64 + 4.0 {
                text(&mut svg, [at, bottom + 19.0], "text-anchor=\"middle\"", &label);
                last = at;
            }
        }
        text(&mut svg, [(left + right) / 2.0, height - 10.0], "text-anchor=\"middle\"", &self.x);
        let turned = format!("text-anchor=\"middle\" transform=\"rotate(-90 16 {})\"", short((top + bottom) / 2.0));
        text(&mut svg, [16.0, (top + bottom) / 2.0], &turned, &self.y);
        let mut legend = left;
        for (series, colour) in self.series.iter().zip(COLOURS.iter().cycle()) {
            self.draw(&mut svg, series, colour, &x, &y);
            circle(&mut svg, [legend + 5.0, 44.0], &format!("fill=\"{colour}\""));
            text(&mut svg, [legend + 15.0, 48.0], "", &series.name);
            legend += 34.0 + 7.2 * series.name.chars().count() as f64;
        }
        if self.series.iter().any(|series| !series.published.is_empty()) {
            diamond(&mut svg, [legend + 5.0, 44.0], INK);
            text(&mut svg, [legend + 15.0, 48.0], "", "published");
        }
        svg.push_str("</svg>\n");
        svg
    }

    fn draw(&self, svg: &mut String, series: &Series, colour: &str, x: &Axis, y: &Axis) {
        let place = |at: f64, value: f64| [x.at(at), y.at(value * self.scale())];
        let mut path = String::new();
        for (i, (at, figure)) in series.points.iter().enumerate() {
            let [px, py] = place(*at, figure.value);
            let _ = write!(path, "{}{} {}", if i == 0 { "M" } else { " L" }, short(px), short(py));
            if let Some(error) = figure.error {
                // No share is above all or below nothing.
                let most = if self.form == Form::Share { 1.0 } else { f64::INFINITY };
                let low = place(*at, (figure.value - error).max(0.0));
                let high = place(*at, (figure.value + error).min(most));
                line(svg, low, high, &format!("stroke=\"{colour}\" stroke-width=\"1.5\""));
            }
        }
        if series.points.len() > 1 {
            let _ = writeln!(svg, "<path d=\"{path}\" fill=\"none\" stroke=\"{colour}\" stroke-width=\"2\"/>");
        }
        for (at, figure) in &series.points {
            circle(svg, place(*at, figure.value), &format!("fill=\"{colour}\""));
        }
        for (at, value) in &series.published {
            // Published shares are percentages already.
            diamond(svg, [x.at(*at), y.at(*value)], colour);
        }
    }

    /// Every setting, published ones too, once and in order.
    fn values_of_x(&self) -> Vec<f64> {
        let ours = self.series.iter().flat_map(|s| s.points.iter().map(|(x, _)| *x));
        let mut values: Vec<f64> =
            ours.chain(self.series.iter().flat_map(|s| s.published.iter().map(|(x, _)| *x))).collect();
        values.sort_by(f64::total_cmp);
        values.dedup();
        values
    }

    fn axes(&self) -> (Axis, Axis) {
        let [left, top, right, bottom] = FIELD;
        let xs = self.values_of_x();
        let (from, to) = (xs.first().copied().unwrap_or(1.0), xs.last().copied().unwrap_or(2.0));
        let x = if self.logarithmic {
            // Half a step of margin on both sides, and some width for a single value.
            let margin = (to / from).powf(0.06).max(1.2);
            Axis { from: from / margin, to: to * margin, pixels: [left, right], logarithmic: true }
        } else {
            let margin = (0.06 * (to - from)).max(0.5);
            Axis { from: from - margin, to: to + margin, pixels: [left, right], logarithmic: false }
        };
        let scale = self.scale();
        let ours = self.series.iter().flat_map(|s| &s.points).flat_map(|(_, figure)| {
            let error = figure.error.unwrap_or(0.0);
            [(figure.value - error).max(0.0) * scale, (figure.value + error) * scale]
        });
        let published = self.series.iter().flat_map(|s| s.published.iter().map(|(_, y)| *y));
        let (low, high) =
            ours.chain(published).fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), y| (a.min(y), b.max(y)));
        let margin = (0.08 * (high - low)).max(0.02 * high.abs()).max(1e-3);
        let (low, high) = (low - margin, high + margin);
        let high = if self.form == Form::Share { high.min(102.0) } else { high };
        (x, Axis { from: low, to: high, pixels: [bottom, top], logarithmic: false })
    }

    /// Round values upwards, and their decimals.
    fn y_ticks(&self, y: &Axis) -> (Vec<f64>, usize) {
        let rough = (y.to - y.from) / 7.0;
        let power = 10f64.powf(rough.log10().floor());
        let step = [1.0, 2.0, 5.0, 10.0].into_iter().map(|f| f * power).find(|step| *step >= rough).unwrap_or(rough);
        let digits = (-step.log10().floor()).clamp(0.0, 4.0) as usize;
        let mut ticks = Vec::new();
        let mut index = (y.from / step).ceil();
        while index * step <= y.to && ticks.len() < 20 {
            ticks.push(index * step);
            index += 1.0;
        }
        (ticks, digits)
    }
}

/// At most one decimal.
fn short(value: f64) -> String {
    let text = format!("{:.1}", value + 0.0);
    text.strip_suffix(".0").map_or(text.clone(), Into::into)
}

fn escape(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}

fn text(svg: &mut String, at: [f64; 2], style: &str, content: &str) {
    let space = if style.is_empty() { "" } else { " " };
    let _ =
        writeln!(svg, "<text x=\"{}\" y=\"{}\"{space}{style}>{}</text>", short(at[0]), short(at[1]), escape(content));
}

fn line(svg: &mut String, from: [f64; 2], to: [f64; 2], style: &str) {
    let [a, b, c, d] = [from[0], from[1], to[0], to[1]].map(short);
    let _ = writeln!(svg, "<line x1=\"{a}\" y1=\"{b}\" x2=\"{c}\" y2=\"{d}\" {style}/>");
}

fn circle(svg: &mut String, at: [f64; 2], style: &str) {
    let _ = writeln!(svg, "<circle cx=\"{}\" cy=\"{}\" r=\"4\" {style}/>", short(at[0]), short(at[1]));
}

fn diamond(svg: &mut String, at: [f64; 2], colour: &str) {
    let [x, y] = at;
    let points = [[x, y - 6.5], [x + 6.5, y], [x, y + 6.5], [x - 6.5, y]];
    let list: Vec<String> = points.iter().map(|p| format!("{},{}", short(p[0]), short(p[1]))).collect();
    let _ =
        writeln!(svg, "<polygon points=\"{}\" fill=\"none\" stroke=\"{colour}\" stroke-width=\"2\"/>", list.join(" "));
}

#[cfg(test)]
mod tests {
    use super::*;

    fn chart() -> Chart {
        let figure = |value, error| Figure { value, error };
        Chart {
            title: "MCTS & MORE <50>".into(),
            x: "iterations a decision".into(),
            y: "actions".into(),
            form: Form::Number(2),
            logarithmic: true,
            series: vec![
                Series {
                    name: "mcts".into(),
                    points: vec![(10.0, figure(3.2, Some(0.1))), (50.0, figure(2.7, None))],
                    published: vec![(10.0, 3.19)],
                },
                Series { name: "more".into(), points: vec![(10.0, figure(2.8, Some(0.1)))], published: Vec::new() },
            ],
        }
    }

    /// Names of elements open and close in order, and every attribute has its quotes.
    pub fn well_formed(svg: &str) -> bool {
        let mut open: Vec<&str> = Vec::new();
        let mut rest = svg;
        while let Some(at) = rest.find('<') {
            if rest[..at].contains('>') {
                return false;
            }
            let Some(end) = rest[at..].find('>') else { return false };
            let tag = &rest[at + 1..at + end];
            rest = &rest[at + end + 1..];
            if tag.matches('"').count() % 2 == 1 || tag.contains('<') {
                return false;
            }
            if let Some(name) = tag.strip_prefix('/') {
                if open.pop() != Some(name) {
                    return false;
                }
            } else if !tag.ends_with('/') {
                open.push(tag.split_whitespace().next().unwrap_or_default());
            }
        }
        open.is_empty()
    }

    #[test]
    fn a_picture_is_well_formed_and_shows_every_point_within_its_field() {
        for logarithmic in [true, false] {
            let svg = Chart { logarithmic, ..chart() }.svg();
            assert!(well_formed(&svg), "{svg}");
            assert!(svg.contains("MCTS &amp; MORE &lt;50&gt;"));
            // Three points and two of the legend; one published point and its legend.
            assert_eq!((svg.matches("<circle").count(), svg.matches("<polygon").count()), (5, 2), "{svg}");
            assert!(!svg.contains("NaN") && !svg.contains("inf"));
            let number = |text: &str, key: &str| -> Vec<f64> {
                let key = format!("{key}=\"");
                let quoted = text.split(&key).skip(1);
                quoted.map(|rest| rest.split('"').next().unwrap().parse().unwrap()).collect()
            };
            let (xs, ys) = (number(&svg, "cx"), number(&svg, "cy"));
            assert!(xs.iter().all(|x| (FIELD[0]..=FIELD[2]).contains(x)), "{xs:?}");
            assert!(ys.iter().all(|y| (40.0..=FIELD[3]).contains(y)), "{ys:?}");
        }
    }

    #[test]
    fn a_picture_of_one_value_or_of_equal_ones_has_axes() {
        let one = Figure { value: 1.0, error: Some(0.0) };
        let series = vec![Series { name: "s".into(), points: vec![(1.0, one)], published: vec![(1.0, 100.0)] }];
        let chart = Chart { form: Form::Share, series, ..chart() };
        let svg = chart.svg();
        assert!(well_formed(&svg) && !svg.contains("NaN"), "{svg}");
        assert!(!chart.is_empty() && Chart { series: vec![Series::default()], ..chart }.is_empty());
    }
}
