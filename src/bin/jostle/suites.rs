//! What a suite's name stands for. The retrieval problems that come with the tool are files in `suites/`.
//!
//! Made by
//! `jostle generate suites/own-hard -n 22 --gripper dissertation_mask --seed 122`,
//! `jostle generate suites/own-confined -n 20 --profile pmbs --gripper dissertation_mask --seed 120` and
//! `jostle generate suites/deep -n 20 --profile pmbs --gripper dissertation_mask --seed 320 --pushes 3`.

use std::path::Path;

use jostle::eval::{Problems, Refused, Suite};
use jostle::scene::arc::ArcProfile;
use jostle::scene::{Clearing, Problem, Rearrangement};

use crate::output::Outcome;
use crate::{clear_suite, rearrange_suite};

/// Name, conventions (travel of a push, greatest number of actions), scene files.
type Builtin = (&'static str, ArcProfile, &'static [&'static str]);

macro_rules! suites {
    ($($suite:literal $profile:ident { $($name:literal)* })*) => {
        const SUITES: &[Builtin] = &[$((
            $suite,
            ArcProfile::$profile,
            &[$(include_str!(concat!("../../../suites/", $suite, "/", $name, ".json")),)*],
        ),)*];
    };
}

suites! {
    "own-hard" More {
        "generated-122-1" "generated-122-10" "generated-122-11" "generated-122-12" "generated-122-13"
        "generated-122-14" "generated-122-15" "generated-122-16" "generated-122-17" "generated-122-19" "generated-122-2"
        "generated-122-21" "generated-122-22" "generated-122-23" "generated-122-24" "generated-122-27"
        "generated-122-3" "generated-122-5" "generated-122-6" "generated-122-7" "generated-122-8"
        "generated-122-9"
    }
    "own-confined" Pmbs {
        "generated-120-0" "generated-120-1" "generated-120-10" "generated-120-11" "generated-120-12"
        "generated-120-14" "generated-120-15" "generated-120-16" "generated-120-17" "generated-120-18"
        "generated-120-19" "generated-120-2" "generated-120-20" "generated-120-21" "generated-120-3" "generated-120-5"
        "generated-120-6" "generated-120-7" "generated-120-8" "generated-120-9"
    }
    "deep" Pmbs {
        "generated-320-137" "generated-320-138" "generated-320-141" "generated-320-150"
        "generated-320-166" "generated-320-178" "generated-320-19" "generated-320-193" "generated-320-201"
        "generated-320-214" "generated-320-218" "generated-320-231" "generated-320-242" "generated-320-248" "generated-320-46"
        "generated-320-54" "generated-320-73" "generated-320-85" "generated-320-86" "generated-320-87"
    }
}

/// Problems of one kind.
pub enum Opened {
    Retrievals(Suite),
    Rearrangements(Vec<Rearrangement>, Vec<Refused>),
    Clearings(Vec<Clearing>, Vec<Refused>),
}

/// What a suite's name stands for: one of the tool, generated problems, else a folder of that name or a file.
pub fn open(name: &str, profile: Option<ArcProfile>) -> Outcome<Opened> {
    if let Some((name, profile, files)) = SUITES.iter().find(|(known, ..)| *known == name) {
        let problems = files.iter().map(|text| Problem::from_json(text)).collect::<Result<_, _>>()?;
        let suite = Suite { name: (*name).into(), problems, refused: Vec::new(), profile: Some(*profile) };
        return Ok(Opened::Retrievals(suite));
    }
    let clearings = |texts: &[&str]| -> Outcome<Opened> {
        Ok(Opened::Clearings(texts.iter().map(|text| Clearing::from_json(text)).collect::<Result<_, _>>()?, Vec::new()))
    };
    match name {
        "rearrange" => {
            let read = |text: &&str| Rearrangement::from_json(text);
            return Ok(Opened::Rearrangements(
                rearrange_suite::SUITE.iter().map(read).collect::<Result<_, _>>()?,
                Vec::new(),
            ));
        }
        "clear-random" => return clearings(clear_suite::RANDOM),
        "clear-packed" => return clearings(clear_suite::PACKED),
        _ if name.starts_with("generated:") => return Ok(Opened::Retrievals(Suite::open(name, profile)?)),
        _ => {}
    }
    let found = Problems::open(Path::new(name), profile)?.of_one_kind();
    Ok(match () {
        () if !found.rearrangements.is_empty() => Opened::Rearrangements(found.rearrangements, found.refused),
        () if !found.clearings.is_empty() => Opened::Clearings(found.clearings, found.refused),
        () => Opened::Retrievals(Suite::of(name, found)),
    })
}
