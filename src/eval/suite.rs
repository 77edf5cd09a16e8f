//! Suites of problems: a folder, a file, or problems generated on the spot.

use std::path::Path;
use std::sync::Arc;

use super::closed_loop::DEFAULT_MAX_ACTIONS;
use super::folder::{Problems, Refused};
use crate::error::{Error, Result};
use crate::grasp::{GraspParams, GraspScratch, GraspTest};
use crate::plan::{Control, GraspDecision, Planner, PlannerOptions};
use crate::scene::arc::{ArcOptions, ArcProfile};
use crate::scene::generate::{Generator, GeneratorParams};
use crate::scene::{AnyProblem, Gripper, Input, Problem};

/// Actions after which a trial of an original test case fails. PMBS stops after 16; MORE has no cap, and a generous one
/// stands for it.
pub fn max_actions(profile: ArcProfile) -> usize {
    match profile {
        ArcProfile::More => DEFAULT_MAX_ACTIONS,
        ArcProfile::Pmbs => 16,
    }
}

/// What a push of an original test case travels, metres: 0.10 m in MORE (whose simulated robot falls about 9 mm short of
/// its command; here a push travels what it says), 0.05 m in PMBS.
pub fn push_travel(profile: ArcProfile) -> f64 {
    profile.push_length()
}

/// Problems to be tried, by name.
#[derive(Debug, Clone)]
pub struct Suite {
    pub name: String,
    pub problems: Vec<Problem>,
    /// Files that hold no usable problem. They are not counted.
    pub refused: Vec<Refused>,
    /// The conventions that were asked for, or those of its original test cases; none if it holds none.
    pub profile: Option<ArcProfile>,
}

impl Suite {
    /// Opens `generated:N[:SEED]`, a folder of scenes (`.json` and original `.txt` cases), or one such file.
    /// Without a `profile`, original cases follow the one that their folder's name says.
    pub fn open(spec: &str, profile: Option<ArcProfile>) -> Result<Suite> {
        if let Some(rest) = spec.strip_prefix("generated:") {
            let (count, seed) = parse_generated(rest)?;
            let mut suite = Suite::generated(count, seed, profile)?;
            suite.profile = profile;
            return Ok(suite);
        }
        let mut problems = Problems::open(Path::new(spec), profile)?;
        let single = problems.refused.is_empty() && !Path::new(spec).is_dir();
        problems.keep(0);
        match problems.refused.first() {
            // One file that is asked for by name is an error of its own.
            Some(refused) if single => Err(Error::argument("suite", refused.reason.clone())),
            _ => Ok(Suite::of(spec, problems)),
        }
    }

    /// The retrieval problems among these.
    pub fn of(name: &str, problems: Problems) -> Suite {
        let Problems { retrievals: problems, refused, profile, .. } = problems;
        Suite { name: name.to_owned(), problems, refused, profile }
    }

    /// `count` random problems, none of which is solved by a grasp alone.
    pub fn generated(count: usize, seed: u64, profile: Option<ArcProfile>) -> Result<Suite> {
        let profile = profile.unwrap_or_default();
        let generator = Generator::new(GeneratorParams { profile, ..GeneratorParams::default() }, seed)?;
        Ok(Suite {
            name: format!("generated:{count}:{seed}"),
            problems: generator.generate_filtered(count, |problem| needs_push(problem).unwrap_or(false))?,
            refused: Vec::new(),
            profile: None,
        })
    }

    /// Takes another gripper for every problem.
    pub fn set_gripper(&mut self, gripper: &Gripper) -> Result<()> {
        for problem in &mut self.problems {
            *problem = with_gripper(problem, gripper)?;
        }
        Ok(())
    }

    /// The grippers' names.
    pub fn gripper(&self) -> String {
        let mut names: Vec<&str> = self.problems.iter().map(|p| p.scene.gripper().name.as_str()).collect();
        names.sort_unstable();
        names.dedup();
        names.join(", ")
    }
}

/// The problem with another gripper.
pub fn with_gripper(problem: &Problem, gripper: &Gripper) -> Result<Problem> {
    let mut builder = problem.scene.to_builder();
    builder.gripper(gripper.clone());
    Ok(Problem { scene: Arc::new(builder.build()?), ..problem.clone() })
}

/// Reads a retrieval problem: a scene file or an original test case, as the content says.
pub fn read_problem(path: &Path, profile: Option<ArcProfile>) -> Result<Problem> {
    retrieval_of(&Input::read(path)?, profile)
}

/// The retrieval problem that an input holds.
pub fn retrieval_of(input: &Input, profile: Option<ArcProfile>) -> Result<Problem> {
    match input.problem(ArcOptions { profile, ..ArcOptions::default() })? {
        AnyProblem::Retrieval(problem) => Ok(problem),
        AnyProblem::Rearrangement(_) => Err(input.error("is a rearrangement; here a retrieval problem is needed")),
        AnyProblem::Clearing(_) => Err(input.error("is a table to be cleared; here a retrieval problem is needed")),
    }
}

/// The target cannot be grasped as the problem stands, or not well enough for a planner to do so by default.
pub fn needs_push(problem: &Problem) -> Result<bool> {
    let test = GraspTest::new(GraspParams::default())?;
    let best = test.best(&problem.scene, &problem.state, problem.target, &mut GraspScratch::default());
    Ok(best.is_none_or(|grasp| grasp.score < GraspDecision::default().execute_score))
}

/// Every plan of fewer than `pushes` pushes was tried and none frees the target, with the published pushes (`pmbs_contour`)
/// of this length (metres) and the model of the default planner.
pub fn needs_pushes(problem: &Problem, pushes: u32, push_length: f64) -> Result<bool> {
    if !needs_push(problem)? {
        return Ok(pushes == 0);
    }
    if pushes < 2 {
        return Ok(true);
    }
    let sampler = Some("pmbs_contour".into());
    let options = PlannerOptions { sampler, push_length: Some(push_length), ..PlannerOptions::default() };
    let plan = Planner::new(options.search_only(pushes - 1)?)?.solve(problem, &Control::default())?;
    Ok(plan.statistics.no_plan_within.is_some_and(|tried| tried >= pushes - 1))
}

/// `N[:SEED]`.
fn parse_generated(text: &str) -> Result<(usize, u64)> {
    let (count, seed) = text.split_once(':').unwrap_or((text, "0"));
    let bad = |what: &str| {
        Error::argument("suite", format!("generated:{text}: {what}; write generated:N or generated:N:SEED"))
    };
    let count = count.parse().ok().filter(|n| (1..=100_000).contains(n)).ok_or_else(|| bad("N is not a count"))?;
    let seed = seed.parse().map_err(|_| bad("SEED is not a number"))?;
    Ok((count, seed))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_generated_suite_is_named_by_count_and_seed() {
        assert_eq!(parse_generated("20").unwrap(), (20, 0));
        assert_eq!(parse_generated("3:7").unwrap(), (3, 7));
        for bad in ["", "0", "-1", "x", "3:", "3:x", "1000000"] {
            let error = parse_generated(bad).unwrap_err().to_string();
            assert!(error.starts_with("suite: generated:"), "{error}");
        }
        let suite = Suite::open("generated:2:5", None).unwrap();
        assert_eq!((suite.problems.len(), suite.refused.len(), suite.profile), (2, 0, None));
        assert_eq!(suite.gripper(), "robotiq_2f85");
        assert!(suite.problems.iter().all(|p| needs_push(p).unwrap()));
        let again = Suite::open("generated:2:5", None).unwrap();
        assert_eq!(suite.problems[1].state, again.problems[1].state);
    }

    #[test]
    fn a_folder_lists_what_it_refuses() {
        let folder = std::env::temp_dir().join(format!("jostle-suite-{}", std::process::id()));
        std::fs::create_dir_all(&folder).unwrap();
        super::super::testing::row().write(folder.join("b.json")).unwrap();
        std::fs::write(folder.join("a.json"), "{").unwrap();
        std::fs::write(folder.join("c.txt"), "cube.urdf 0 0 0 0.5 0 0.0225 0 0\n").unwrap();
        std::fs::write(folder.join("notes.md"), "no scene").unwrap();
        let mut suite = Suite::open(&folder.to_string_lossy(), None).unwrap();
        let broken = Suite::open(&folder.join("a.json").to_string_lossy(), None);
        std::fs::remove_dir_all(&folder).unwrap();
        assert!(broken.is_err(), "a file asked for by name is an error");
        assert_eq!(suite.problems.len(), 1);
        let refused: Vec<_> = suite.refused.iter().map(|r| r.name.as_str()).collect();
        assert_eq!(refused, ["a", "c"]);
        assert!(suite.refused[1].reason.contains("line 1"), "{:?}", suite.refused);
        assert_eq!(suite.profile, Some(ArcProfile::More));
        suite.set_gripper(&Gripper::dissertation_mask()).unwrap();
        assert_eq!(suite.gripper(), "dissertation_mask");
        assert!(Suite::open("no such folder", None).is_err());
    }
}
