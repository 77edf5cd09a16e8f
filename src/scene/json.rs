//! Where in a JSON text a value stands: the path of a place, and the place of a path, for error messages.
//! And the layout in which scene files are written.

use std::io;

/// A container that encloses the place where the scan is.
enum Frame {
    /// With the key read last.
    Object(Option<String>),
    /// With the index of the element that began last.
    Array(Option<usize>),
}

fn path_of(frames: &[Frame]) -> String {
    let mut path = String::new();
    for frame in frames {
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
pub(super) fn path_at(text: &str, line: usize, column: usize) -> String {
    let before: usize = text.split_inclusive('\n').take(line.saturating_sub(1)).map(str::len).sum();
    let mut end = (before + column).min(text.len());
    while !text.is_char_boundary(end) {
        end -= 1;
    }
    // A complaint at a closing bracket is about the whole container; at a comma, about the value before it.
    let read = &text[..end];
    let closes = read.ends_with(['}', ']']);
    let frames = scan(read.strip_suffix(['}', ']', ',']).unwrap_or(read), |_, _| true);
    path_of(if closes { &frames[..frames.len().saturating_sub(1)] } else { &frames })
}

/// The line and column (from 1) where the value of a path begins, or that of the nearest container of it.
pub(super) fn place_of(text: &str, path: &str) -> Option<(usize, usize)> {
    let mut best: Option<(usize, usize)> = None;
    scan(text, |frames, offset| {
        let here = path_of(frames);
        let encloses = path
            .strip_prefix(&here)
            .is_some_and(|rest| here.is_empty() || rest.is_empty() || rest.starts_with(['.', '[']));
        if encloses && best.is_none_or(|(length, _)| here.len() > length) {
            best = Some((here.len(), offset));
        }
        here != path
    });
    let (length, offset) = best?;
    // The document as a whole is no place.
    (length > 0).then(|| {
        let before = &text[..offset];
        let line_start = before.rfind('\n').map_or(0, |i| i + 1);
        (before.matches('\n').count() + 1, before[line_start..].chars().count() + 1)
    })
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
pub(super) fn one_line<T: serde::Serialize + ?Sized>(value: &T) -> serde_json::Result<String> {
    let mut out = Vec::new();
    value.serialize(&mut serde_json::Serializer::with_formatter(&mut out, OneLine))?;
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
            ("gripper", None),
        ] {
            assert_eq!(place_of(TEXT, path), place, "{path}");
        }
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
