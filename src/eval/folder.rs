//! The problems of a folder or a file, whatever their kind. Nothing is dropped without a word: a file that is meant as a
//! problem and is none is refused with its reason.

use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use crate::error::{Error, Result};
use crate::files;
use crate::scene::arc::{ArcOptions, ArcProfile};
use crate::scene::{AnyProblem, Clearing, Input, InputKind, Problem, Rearrangement, is_meant, trlb};

/// A file that holds no usable problem.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Refused {
    pub name: String,
    pub reason: String,
}

impl Refused {
    fn new(path: &Path, reason: impl ToString) -> Refused {
        Refused { name: files::stem(path), reason: reason.to_string() }
    }
}

/// What a folder holds, in the order of the names.
#[derive(Debug, Clone, Default)]
pub struct Problems {
    pub retrievals: Vec<Problem>,
    pub rearrangements: Vec<Rearrangement>,
    pub clearings: Vec<Clearing>,
    pub refused: Vec<Refused>,
    /// The conventions that were asked for, or those of the original test cases; none if there are none.
    pub profile: Option<ArcProfile>,
    asked: Option<ArcProfile>,
    /// Where the problems of each kind come from.
    sources: [Vec<PathBuf>; 3],
}

impl Problems {
    /// Reads a folder's files named `.json` or `.txt`, in letters of either case, or one file of any name. What is wrong
    /// with the one file is an error.
    pub fn open(path: &Path, profile: Option<ArcProfile>) -> Result<Problems> {
        let mut problems = Problems { profile, asked: profile, ..Problems::default() };
        let about = std::fs::metadata(path).map_err(|e| Error::io(path, e))?;
        if !about.is_dir() {
            problems.add(&Input::read(path)?)?;
            return Ok(problems);
        }
        let mut arrangements = Vec::new();
        for file in meant(path)? {
            // A pipe in a folder would be waited for.
            let read = match std::fs::metadata(&file) {
                Ok(about) if !about.is_file() => Err(Error::io(&file, "is no regular file")),
                Err(error) => Err(Error::io(&file, error)),
                Ok(_) => Input::read(&file),
            };
            match read {
                Ok(input) if input.kind == InputKind::Arrangement => arrangements.push(file),
                read => {
                    if let Err(error) = read.and_then(|input| problems.add(&input)) {
                        problems.refused.push(Refused::new(&file, error));
                    }
                }
            }
        }
        for pair in trlb::pairs(arrangements) {
            match pair.read() {
                Ok(problem) => {
                    problems.sources[1].push(pair.from);
                    problems.rearrangements.push(problem);
                }
                Err(error) => problems.refused.push(Refused::new(&pair.from, error)),
            }
        }
        Ok(problems)
    }

    /// Adds the problem of a file.
    fn add(&mut self, input: &Input) -> Result<()> {
        let profile = self.asked;
        if input.kind == InputKind::Original {
            self.profile.get_or_insert_with(|| ArcProfile::of_path(&input.path));
        }
        let kind = match input.problem(ArcOptions { profile, ..ArcOptions::default() })? {
            AnyProblem::Retrieval(problem) => {
                self.retrievals.push(problem);
                0
            }
            AnyProblem::Rearrangement(problem) => {
                self.rearrangements.push(problem);
                1
            }
            AnyProblem::Clearing(problem) => {
                self.clearings.push(problem);
                2
            }
        };
        self.sources[kind].push(input.path.clone());
        Ok(())
    }

    /// A run is of problems of one kind: refuses those of other kinds than rearrangements if there are any, else those of
    /// other kinds than tables to be cleared, else none.
    #[must_use]
    pub fn of_one_kind(mut self) -> Problems {
        let kind = match () {
            () if !self.rearrangements.is_empty() => 1,
            () if !self.clearings.is_empty() => 2,
            () => 0,
        };
        self.keep(kind);
        self
    }

    /// Refuses the problems of other kinds.
    pub(super) fn keep(&mut self, kind: usize) {
        const NAMES: [&str; 3] = ["a retrieval problem", "a rearrangement", "a table to be cleared"];
        for other in (0..3).filter(|&other| other != kind) {
            for path in std::mem::take(&mut self.sources[other]) {
                let (path_shown, is, wanted) = (path.display(), NAMES[other], NAMES[kind]);
                let reason = format!("{path_shown}: is {is} among problems of another kind ({wanted}); run them apart");
                self.refused.push(Refused::new(&path, reason));
            }
        }
        self.refused.sort_by(|a, b| a.name.cmp(&b.name));
        match kind {
            0 => (self.rearrangements, self.clearings) = (Vec::new(), Vec::new()),
            1 => (self.retrievals, self.clearings) = (Vec::new(), Vec::new()),
            _ => (self.retrievals, self.rearrangements) = (Vec::new(), Vec::new()),
        }
    }
}

/// The files of a folder that are meant as problems, by name.
fn meant(folder: &Path) -> Result<Vec<PathBuf>> {
    let mut files = Vec::new();
    for entry in std::fs::read_dir(folder).map_err(|e| Error::io(folder, e))? {
        let path = entry.map_err(|e| Error::io(folder, e))?.path();
        if is_meant(&path) {
            files.push(path);
        }
    }
    if files.is_empty() {
        return Err(Error::format(folder, "holds no scenes; a suite is a folder of .json or .txt files"));
    }
    files.sort();
    Ok(files)
}

#[cfg(test)]
#[path = "folder_tests.rs"]
mod tests;
