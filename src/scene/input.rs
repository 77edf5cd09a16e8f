//! A file of which nobody said what it holds: its content says it, and where that does not, its name.

use std::path::{Path, PathBuf};

use super::arc::{self, ArcOptions};
use super::file::AnyProblem;
use crate::error::{Error, Result};
use crate::files::{self, json};

/// What a file holds.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum InputKind {
    /// A scene file: a retrieval problem, a rearrangement or a table to be cleared.
    Scene,
    /// A case file of the originals.
    Original,
    /// One of the two arrangements of a TRLB instance.
    Arrangement,
    /// A plan for a retrieval problem or a table, with its problem.
    Plan,
    /// A plan for a rearrangement, with its problem.
    RearrangementPlan,
}

/// A file that was read once, whatever it holds: a pipe has its text no second time.
#[derive(Debug, Clone)]
pub struct Input {
    pub path: PathBuf,
    pub text: String,
    pub kind: InputKind,
}

impl Input {
    pub fn read(path: impl Into<PathBuf>) -> Result<Input> {
        let path = path.into();
        let text = files::read_text(&path)?;
        let kind = kind(&path, &text);
        Ok(Input { path, text, kind })
    }

    /// The problem; of a plan that for which it was made. One without a name is named after the file.
    pub fn problem(&self, options: ArcOptions) -> Result<AnyProblem> {
        match self.kind {
            InputKind::Original => {
                arc::of_text(&self.path, &self.text, options).map(|case| AnyProblem::Retrieval(case.problem))
            }
            InputKind::Arrangement => Err(self.error("is half of a TRLB instance; give the folder with both halves")),
            InputKind::Plan | InputKind::RearrangementPlan => {
                Err(self.error("is a plan, not a problem; `jostle render` draws it"))
            }
            InputKind::Scene => {
                let mut problem = AnyProblem::from_json(&self.text).map_err(|e| self.error(e))?;
                let name = problem.name_mut();
                if name.is_empty() {
                    *name = files::stem(&self.path);
                }
                Ok(problem)
            }
        }
    }

    /// An error of this file.
    pub fn error(&self, reason: impl std::fmt::Display) -> Error {
        Error::format(&self.path, reason)
    }
}

/// By what the text begins with and its outermost keys, which a text with a fault has too: so it is its own reader that
/// says what the fault is. A text that is neither JSON nor named so is a case of the originals.
fn kind(path: &Path, text: &str) -> InputKind {
    if !text.trim_start().starts_with(['{', '[']) {
        let json = path.extension().is_some_and(|e| e.eq_ignore_ascii_case("json"));
        return if json || text.trim().is_empty() && !named_text(path) {
            InputKind::Scene
        } else {
            InputKind::Original
        };
    }
    let keys = json::top_keys(text);
    let has = |key: &str| keys.iter().any(|known| known == key);
    match () {
        () if has("plan_version") => InputKind::Plan,
        () if has("rearrange_plan_version") => InputKind::RearrangementPlan,
        () if has("point_list") && !has("bodies") => InputKind::Arrangement,
        () => InputKind::Scene,
    }
}

fn named_text(path: &Path) -> bool {
    path.extension().is_some_and(|e| e.eq_ignore_ascii_case("txt"))
}

/// Whether a folder's file is meant as a problem, by its name: others lie there for other reasons.
pub fn is_meant(path: &Path) -> bool {
    named_text(path) || path.extension().is_some_and(|e| e.eq_ignore_ascii_case("json"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_content_says_what_a_file_holds_whatever_its_name() {
        let scene = r#"{"version": 1, "bodies": [{"block": "cube", "pose": {"x": 0.5, "y": 0}}], "target": 0}"#;
        let texts = [
            (scene.to_owned(), InputKind::Scene),
            (scene.replace("0}", "0,}"), InputKind::Scene),
            ("cube.urdf 0 0 0 0.5 0 0.0225 0 0 0\n".into(), InputKind::Original),
            (r#"{"Object_Shape": "disc", "point_list": [[1, 2],]}"#.into(), InputKind::Arrangement),
            (r#"{"plan_version": 1, "problem": {}}"#.into(), InputKind::Plan),
            (r#"{"rearrange_plan_version": 7"#.into(), InputKind::RearrangementPlan),
        ];
        for (text, wanted) in &texts {
            for name in ["a.json", "a.JSON", "a.txt", "a", "/dev/stdin", "a.scene"] {
                for blank in ["", "\n \t"] {
                    let got = kind(Path::new(name), &format!("{blank}{text}"));
                    // A broken JSON file is not taken for an original case, nor an original case for JSON but by its name.
                    let json = name.to_lowercase().ends_with(".json") && *wanted == InputKind::Original;
                    assert_eq!(got, if json { InputKind::Scene } else { *wanted }, "{name}: {text}");
                }
            }
        }
        assert_eq!(kind(Path::new("a"), ""), InputKind::Scene);
        assert_eq!(kind(Path::new("a.TXT"), ""), InputKind::Original);
        assert!(is_meant(Path::new("x/a.Json")) && is_meant(Path::new("a.txt")) && !is_meant(Path::new("notes.md")));
    }

    #[test]
    fn an_input_is_read_once_and_names_its_problem() {
        let path = std::env::temp_dir().join(format!("jostle-input-{}.JSON", std::process::id()));
        let text = "\u{feff}{\"version\": 1, \"bodies\": [{\"block\": \"cube\", \"pose\": {\"x\": 0.5, \"y\": 0}}], \"clear\": true}";
        std::fs::write(&path, text).unwrap();
        let input = Input::read(&path).unwrap();
        std::fs::remove_file(&path).unwrap();
        let AnyProblem::Clearing(problem) = input.problem(ArcOptions::default()).unwrap() else { panic!("{input:?}") };
        assert_eq!(problem.name, files::stem(&path));
        let half = Input { text: "{\"point_list\": []}".into(), kind: InputKind::Arrangement, ..input };
        assert!(half.problem(ArcOptions::default()).unwrap_err().to_string().contains("half of a TRLB instance"));
    }
}
