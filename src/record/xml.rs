//! Writes SVG elements: numbers with fixed decimals, escaped text.

use std::fmt::Write as _;

/// A number with at most two decimals, the same on every machine.
pub(super) fn number(value: f64) -> String {
    let rounded = (value * 100.0).round() / 100.0;
    // Adding zero turns a negative zero into a positive one.
    let mut text = format!("{:.2}", rounded + 0.0);
    let kept = text.trim_end_matches('0').trim_end_matches('.').len();
    text.truncate(kept);
    text
}

/// Text as XML holds it. Characters that XML cannot hold become the replacement character.
pub(super) fn escape(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '&' => out.push_str("&amp;"),
            '<' => out.push_str("&lt;"),
            '>' => out.push_str("&gt;"),
            '"' => out.push_str("&quot;"),
            '\'' => out.push_str("&#39;"),
            '\t' | '\n' | '\r' => out.push(' '),
            c if c.is_control() || matches!(c, '\u{fffe}' | '\u{ffff}') => out.push('\u{fffd}'),
            c => out.push(c),
        }
    }
    out
}

/// Where text is anchored.
#[derive(Clone, Copy, PartialEq)]
pub(super) enum Anchor {
    Start,
    Middle,
}

/// An SVG document in the making. Coordinates are pixels, y down.
#[derive(Default)]
pub(super) struct Canvas {
    pub text: String,
}

type Point = [f64; 2];

impl Canvas {
    fn line(&mut self, element: &str) {
        self.text.push_str(element);
        self.text.push('\n');
    }

    pub(super) fn open(&mut self, element: &str) {
        self.line(&format!("<{element}>"));
    }

    pub(super) fn close(&mut self, name: &str) {
        self.line(&format!("</{name}>"));
    }

    pub(super) fn rect(&mut self, corner: Point, size: Point, style: &str) {
        let [x, y, w, h] = [corner[0], corner[1], size[0], size[1]].map(number);
        self.line(&format!("<rect x=\"{x}\" y=\"{y}\" width=\"{w}\" height=\"{h}\" {style}/>"));
    }

    pub(super) fn segment(&mut self, from: Point, to: Point, style: &str) {
        let [a, b, c, d] = [from[0], from[1], to[0], to[1]].map(number);
        self.line(&format!("<line x1=\"{a}\" y1=\"{b}\" x2=\"{c}\" y2=\"{d}\" {style}/>"));
    }

    pub(super) fn circle(&mut self, centre: Point, radius: f64, style: &str) {
        let [x, y, r] = [centre[0], centre[1], radius].map(number);
        self.line(&format!("<circle cx=\"{x}\" cy=\"{y}\" r=\"{r}\" {style}/>"));
    }

    pub(super) fn polygon(&mut self, points: &[Point], style: &str) {
        let mut list = String::new();
        for (i, p) in points.iter().enumerate() {
            let space = if i == 0 { "" } else { " " };
            // Writing to a string does not fail.
            let _ = write!(list, "{space}{},{}", number(p[0]), number(p[1]));
        }
        self.line(&format!("<polygon points=\"{list}\" {style}/>"));
    }

    /// A line with a head at `to`; the line ends within the head. Shorter than a pixel it is left out.
    pub(super) fn arrow(&mut self, from: Point, to: Point, width: f64, colour: &str) {
        let (dx, dy) = (to[0] - from[0], to[1] - from[1]);
        let length = dx.hypot(dy);
        if length < 1.0 {
            return;
        }
        let (ux, uy) = (dx / length, dy / length);
        let head = (4.0 * width).min(0.7 * length);
        let neck = [to[0] - ux * head * 0.8, to[1] - uy * head * 0.8];
        self.segment(from, neck, &format!("stroke=\"{colour}\" stroke-width=\"{}\"", number(width)));
        let side = head * 0.42;
        let back = [to[0] - ux * head, to[1] - uy * head];
        let wings = [[back[0] - uy * side, back[1] + ux * side], [back[0] + uy * side, back[1] - ux * side]];
        self.polygon(&[to, wings[0], wings[1]], &format!("fill=\"{colour}\""));
    }

    pub(super) fn label(&mut self, at: Point, size: f64, anchor: Anchor, style: &str, text: &str) {
        let [x, y, size] = [at[0], at[1], size].map(number);
        let anchor = match anchor {
            Anchor::Start => "",
            Anchor::Middle => " text-anchor=\"middle\"",
        };
        let text = escape(text);
        self.line(&format!("<text x=\"{x}\" y=\"{y}\" font-size=\"{size}\"{anchor} {style}>{text}</text>"));
    }
}

/// Breaks a text between words into lines of about `width` characters.
pub(super) fn wrap(text: &str, width: usize) -> Vec<String> {
    let mut lines: Vec<String> = Vec::new();
    for word in text.split_whitespace() {
        match lines.last_mut() {
            Some(line) if line.chars().count() + 1 + word.chars().count() <= width => {
                line.push(' ');
                line.push_str(word);
            }
            _ => lines.push(word.to_owned()),
        }
    }
    lines
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_short_and_have_no_negative_zero() {
        for (value, text) in [(1.0, "1"), (-0.001, "0"), (0.125, "0.13"), (-2.5, "-2.5"), (100.0, "100"), (0.0, "0")] {
            assert_eq!(number(value), text);
        }
    }

    #[test]
    fn text_is_escaped() {
        assert_eq!(escape("a<b> & \"c\"\u{0}'\n"), "a&lt;b&gt; &amp; &quot;c&quot;\u{fffd}&#39; ");
    }

    #[test]
    fn words_are_wrapped() {
        assert_eq!(wrap("push the  cube aside", 8), ["push the", "cube", "aside"]);
        assert!(wrap("  ", 8).is_empty());
        assert_eq!(wrap("unbreakable", 4), ["unbreakable"]);
    }
}
