//! JSON with errors that name the field and where it stands, by the path of a place and the place of a path. And the
//! layout in which scene files are written.

use std::io;
use std::path::Path;

use serde::Deserialize;

use crate::error::{Error, Result};

/// Steps of a path that a message names; of a deeper one the rest is left out.
const MAX_STEPS: usize = 16;

/// A parser's complaint with the path of the field; `whole` is what the document is called.
pub fn parse<'de, T: Deserialize<'de>>(text: &'de str, whole: &str) -> Result<T> {
    serde_json::from_str(text).map_err(|e| {
        let path = path_at(text, e.line(), e.column());
        let mut reason = e.to_string();
        // serde_json says the place at the end; here it is said as everywhere else.
        if let Some(cut) = reason.rfind(" at line ") {
            reason.truncate(cut);
        }
        if after_comma(text, e.line(), e.column()) {
            "trailing comma".clone_into(&mut reason);
        }
        let field = if path.is_empty() { whole.to_owned() } else { path };
        Error::argument(field, format!("{reason} (line {}, column {})", e.line(), e.column()))
    })
}

/// A container is closed there, right behind a comma: serde_json calls it that only where it keeps what it reads.
fn after_comma(text: &str, line: usize, column: usize) -> bool {
    let read = &text[..end_of(text, line, column)];
    read.strip_suffix([']', '}']).is_some_and(|before| before.trim_end().ends_with(','))
}

/// The offset behind the character at a line and a column as serde_json counts them: bytes, both from 1.
fn end_of(text: &str, line: usize, column: usize) -> usize {
    let before: usize = text.split_inclusive('\n').take(line.saturating_sub(1)).map(str::len).sum();
    let mut end = (before + column).min(text.len());
    while !text.is_char_boundary(end) {
        end -= 1;
    }
    end
}

/// Reads a file of JSON; errors name the file, the field and where it stands.
pub fn read<T: for<'de> Deserialize<'de>>(path: &Path, whole: &str) -> Result<T> {
    parse(&super::read_text(path)?, whole).map_err(|e| Error::format(path, e))
}

/// Adds to an error about a field where in the text it stands. A place that it has already, of another text, goes.
pub fn located(text: &str, error: Error) -> Error {
    let place = |field: &str, reason: String| {
        let reason = match reason.rfind(" (line ") {
            Some(cut) if reason.ends_with(')') => reason[..cut].to_owned(),
            _ => reason,
        };
        match place_of(text, field) {
            Some((line, column)) => format!("{reason} (line {line}, column {column})"),
            None => reason,
        }
    };
    match error {
        Error::Argument { field, reason } => Error::Argument { reason: place(&field, reason), field },
        Error::NotFound { field, reason } => Error::NotFound { reason: place(&field, reason), field },
        other => other,
    }
}

/// An error with a place in one line as one with a place in the file whose line that is.
pub fn on_line(error: Error, line: usize) -> Error {
    let place = |reason: String| match reason.rfind(" (line 1, column ") {
        Some(cut) => format!("{} (line {line}{}", &reason[..cut], &reason[cut + " (line 1".len()..]),
        None => format!("{reason} (line {line})"),
    };
    match error {
        Error::Argument { field, reason } => Error::Argument { field, reason: place(reason) },
        Error::NotFound { field, reason } => Error::NotFound { field, reason: place(reason) },
        other => other,
    }
}

/// The keys of the document's outermost object, as far as the text is JSON.
pub fn top_keys(text: &str) -> Vec<String> {
    let mut keys = Vec::new();
    scan(text, |frames, _| {
        if let [Frame::Object(Some(key))] = frames {
            keys.push(key.clone());
        }
        true
    });
    keys
}

/// Line and column (from 1, in characters) of what follows a text.
pub(super) fn line_and_column(before: &str) -> (usize, usize) {
    let line_start = before.rfind('\n').map_or(0, |i| i + 1);
    (before.matches('\n').count() + 1, before[line_start..].chars().count() + 1)
}

/// A container that encloses the place where the scan is.
enum Frame {
    /// With the key read last.
    Object(Option<String>),
    /// With the index of the element that began last.
    Array(Option<usize>),
}

fn path_of(frames: &[Frame]) -> String {
    let mut path = String::new();
    for frame in frames.iter().take(MAX_STEPS) {
        match frame {
            Frame::Object(Some(key)) if path.is_empty() => path.push_str(key),
            Frame::Object(Some(key)) => path.extend([".", key]),
            Frame::Array(Some(index)) => path.push_str(&format!("[{index}]")),
            Frame::Object(None) | Frame::Array(None) => {}
        }
    }
    path
}

/// Walks over the tokens of `text` and calls `value(frames, offset)` where a value begins; goes on until it returns
/// `false` or the text ends. Makes what it can of a text that is not JSON. Returns the frames open at the end.
fn scan(text: &str, mut value: impl FnMut(&[Frame], usize) -> bool) -> Vec<Frame> {
    let bytes = text.as_bytes();
    let mut frames: Vec<Frame> = Vec::new();
    let mut expects_key = false;
    let mut at = 0;
    while at < bytes.len() {
        let start = at;
        at += 1;
        match bytes[start] {
            b' ' | b'\t' | b'\r' | b'\n' | b':' => continue,
            b',' => {
                expects_key = matches!(frames.last(), Some(Frame::Object(_)));
                continue;
            }
            b'}' | b']' => {
                frames.pop();
                expects_key = false;
                continue;
            }
            b'"' => {
                while at < bytes.len() && bytes[at] != b'"' {
                    at += if bytes[at] == b'\\' { 2 } else { 1 };
                }
                at = (at + 1).min(bytes.len());
                if expects_key {
                    expects_key = false;
                    if let Some(Frame::Object(key)) = frames.last_mut() {
                        *key = text.get(start + 1..at - 1).map(str::to_owned);
                    }
                    continue;
                }
            }
            b'{' | b'[' => {}
            _ => {
                while at < bytes.len() && !b",:]}\" \t\r\n".contains(&bytes[at]) {
                    at += 1;
                }
            }
        }
        if let Some(Frame::Array(index)) = frames.last_mut() {
            *index = Some(index.map_or(0, |i| i + 1));
        }
        if !value(&frames, start) {
            return frames;
        }
        match bytes[start] {
            b'{' => {
                frames.push(Frame::Object(None));
                expects_key = true;
            }
            b'[' => frames.push(Frame::Array(None)),
            _ => {}
        }
    }
    frames
}

/// The path of the value that a parser had read when it stopped at a line and a column (in bytes, both from 1), such
/// as `bodies[2].mass`; empty for the whole document.
fn path_at(text: &str, line: usize, column: usize) -> String {
    // A complaint at a closing bracket is about the whole container; at a comma, about the value before it.
    let read = &text[..end_of(text, line, column)];
    let closes = read.ends_with(['}', ']']);
    let frames = scan(read.strip_suffix(['}', ']', ',']).unwrap_or(read), |_, _| true);
    path_of(if closes { &frames[..frames.len().saturating_sub(1)] } else { &frames })
}

/// A step of a path.
enum Step<'a> {
    Key(&'a str),
    Index(usize),
}

impl Step<'_> {
    fn is(&self, frame: &Frame) -> bool {
        match (self, frame) {
            (Step::Key(wanted), Frame::Object(Some(key))) => key == wanted,
            (Step::Index(wanted), Frame::Array(Some(index))) => index == wanted,
            _ => false,
        }
    }
}

/// The steps of `bodies[2].pose.x`. What is no index in brackets belongs to a key.
fn steps(path: &str) -> Vec<Step<'_>> {
    let mut steps = Vec::new();
    for part in path.split('.') {
        let mut rest = part.split('[');
        steps.extend(rest.next().filter(|key| !key.is_empty()).map(Step::Key));
        steps.extend(rest.filter_map(|index| index.strip_suffix(']')?.parse().ok()).map(Step::Index));
    }
    steps
}

/// The line and column (from 1) where the value of a path begins, or that of the nearest container of it, and be it the
/// document.
pub fn place_of(text: &str, path: &str) -> Option<(usize, usize)> {
    let steps = steps(path);
    let mut best: Option<(usize, usize)> = None;
    // How many of the outermost frames are the path's: as only the last frame goes on, one look at it is enough, and the
    // scan takes no longer in deep documents.
    let mut same = 0;
    scan(text, |frames, offset| {
        if let Some(last) = frames.len().checked_sub(1) {
            same = same.min(last);
            if same == last && steps.get(last).is_some_and(|step| step.is(&frames[last])) {
                same = last + 1;
            }
        }
        if same == frames.len() && best.is_none_or(|(depth, _)| same > depth) {
            best = Some((same, offset));
        }
        same < steps.len() || frames.len() != same
    });
    best.map(|(_, offset)| line_and_column(&text[..offset]))
}

/// JSON on one line, with a space after commas and colons.
#[derive(Clone, Copy)]
struct OneLine;

impl serde_json::ser::Formatter for OneLine {
    fn begin_array_value<W: ?Sized + io::Write>(&mut self, writer: &mut W, first: bool) -> io::Result<()> {
        if first { Ok(()) } else { writer.write_all(b", ") }
    }

    fn begin_object_key<W: ?Sized + io::Write>(&mut self, writer: &mut W, first: bool) -> io::Result<()> {
        if first { Ok(()) } else { writer.write_all(b", ") }
    }

    fn begin_object_value<W: ?Sized + io::Write>(&mut self, writer: &mut W) -> io::Result<()> {
        writer.write_all(b": ")
    }
}

/// A value on one line.
pub fn one_line<T: serde::Serialize + ?Sized>(value: &T) -> Result<String> {
    let mut out = Vec::new();
    value
        .serialize(&mut serde_json::Serializer::with_formatter(&mut out, OneLine))
        .map_err(|e| Error::Internal(format!("a value could not be written as JSON: {e}")))?;
    Ok(String::from_utf8_lossy(&out).into_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    const TEXT: &str = r#"{
  "version": 1,
  "bodies": [
    {"name": "a \"b\" {", "pose": {"x": 1, "y": [2, 3]}},
    {"name": "c", "mass": "heavy"}
  ]
}"#;

    /// Just behind the first occurrence of `what`.
    fn behind(what: &str) -> (usize, usize) {
        let end = TEXT.find(what).unwrap() + what.len();
        let before = &TEXT[..end];
        (before.matches('\n').count() + 1, end - before.rfind('\n').map_or(0, |i| i + 1))
    }

    #[test]
    fn a_place_has_a_path() {
        for (what, path) in [
            ("\"version\": 1", "version"),
            ("\"version\": 1,", "version"),
            ("{\"name\"", "bodies[0].name"),
            ("\"x\": 1", "bodies[0].pose.x"),
            ("[2, 3", "bodies[0].pose.y[1]"),
            ("[2, 3]", "bodies[0].pose.y"),
            ("[2, 3]}", "bodies[0].pose"),
            ("[2, 3]}}", "bodies[0]"),
            ("\"heavy\"", "bodies[1].mass"),
            ("\"heavy\"}", "bodies[1]"),
            ("\"heavy\"}\n  ]", "bodies"),
        ] {
            let (line, column) = behind(what);
            assert_eq!(path_at(TEXT, line, column), path, "{what}");
        }
        assert_eq!(path_at(TEXT, 7, 1), "");
    }

    #[test]
    fn a_path_has_a_place() {
        for (path, place) in [
            ("version", Some((2, 14))),
            ("bodies[0].pose.y[1]", Some((4, 53))),
            ("bodies[1].mass", Some((5, 27))),
            ("bodies[1].pose.x", Some((5, 5))),
            ("bodies[10]", Some((3, 13))),
            ("gripper", Some((1, 1))),
            ("version.x", Some((2, 14))),
        ] {
            assert_eq!(place_of(TEXT, path), place, "{path}");
        }
    }

    /// Every place is looked at once, however deep it lies.
    #[test]
    fn deep_documents_take_no_longer_than_flat_ones() {
        for depth in [10, 1_000, 200_000] {
            let text = format!("{{\"x\": {}{}, \"version\": 2}}", "[".repeat(depth), "]".repeat(depth));
            assert_eq!(place_of(&text, "version"), Some((1, 2 * depth + 20)));
            assert_eq!(path_at(&text, 1, depth + 6).len(), 1 + 3 * (depth - 1).min(MAX_STEPS - 1));
            assert_eq!(top_keys(&text), ["x", "version"]);
        }
    }

    #[test]
    fn a_trailing_comma_is_called_so_wherever_it_stands() {
        #[derive(Deserialize)]
        struct Known {
            #[serde(rename = "a")]
            _a: Vec<u32>,
        }
        for (text, place) in [
            ("{\"a\": [1,]}", "(line 1, column 10)"),
            ("{\"a\": [1],\n}", "(line 2, column 1)"),
            ("{\"b\": [1, ], \"a\": []}", "(line 1, column 11)"),
            ("{\"b\": {\"c\": [[1], [2,\n ]]}, \"a\": []}", "(line 2, column 2)"),
            ("{\"b\": {\"c\": 1,}, \"a\": []}", "(line 1, column 15)"),
        ] {
            let error = parse::<Known>(text, "file").err().unwrap().to_string();
            assert!(error.contains("trailing comma") && error.ends_with(place), "{text}: {error}");
        }
    }

    #[test]
    fn a_text_that_is_no_json_has_keys_too() {
        assert_eq!(top_keys("{\"a\": {\"b\": 1,}, \"c\": [1,],}"), ["a", "c"]);
        assert!(top_keys("[{\"a\": 1}]").is_empty() && top_keys("cube.urdf 0 0 0").is_empty());
    }

    #[test]
    fn any_text_is_scanned_to_its_end() {
        for text in ["", "}", "]]", "{\"", "\"\\", "[1,,2", "{\"a\":}", "nul", "{\"ä\": ü, \"b\": 1}"] {
            for column in 0..=text.len() + 1 {
                path_at(text, 1, column);
            }
            place_of(text, "a.b[3]");
        }
    }
}
