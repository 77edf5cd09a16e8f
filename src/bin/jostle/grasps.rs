//! `jostle grasps`: the best grasps of a body, or given ones examined.

use std::fmt::Write as _;

use jostle::action::{Action, Grasp};
use jostle::grasp::{APART, GraspExamination, GraspParams, GraspScratch, GraspTest};
use jostle::record::SvgPicture;
use jostle::scene::arc::ArcOptions;
use jostle::scene::{AnyProblem, GraspFeatures, Input, Scene, State};
use serde::Serialize;

use crate::args::{GraspsArgs, gripper};
use crate::output::{self, Failure, Outcome};
use crate::table::{Table, number};

/// The report. What a grasp does not have, and what is infinite, is null.
#[derive(Serialize)]
struct Report<'a> {
    scene: &'a str,
    gripper: &'a str,
    target: &'a str,
    /// Listed grasps are so far apart or their closing directions so much.
    apart_m: f64,
    turned_rad: f64,
    grasps: Vec<Entry<'a>>,
}

#[derive(Serialize)]
struct Entry<'a> {
    position: [f64; 2],
    angle: f64,
    opening: f64,
    width: f64,
    margin: f64,
    score: f64,
    allowed: bool,
    limit: &'static str,
    limit_body: Option<&'a str>,
    reason: String,
    chance: Option<f64>,
    wedge: f64,
    spares: Option<Spares<'a>>,
    features: Option<GraspFeatures>,
    depth: Option<f64>,
}

#[derive(Serialize)]
struct Spares<'a> {
    fit: f64,
    cover: f64,
    finger: f64,
    between: f64,
    opening: f64,
    wedge: f64,
    finger_body: Option<&'a str>,
    between_body: Option<&'a str>,
}

pub fn run(args: &GraspsArgs) -> Outcome<()> {
    if args.k == 0 {
        return Err(Failure::usage("k: is 0; ask for at least one grasp"));
    }
    let input = Input::read(&args.scene)?;
    let problem = input.problem(ArcOptions { profile: args.profile.profile(), ..ArcOptions::default() })?;
    let (name, scene, state, target) = match &problem {
        AnyProblem::Retrieval(p) => (&p.name, &p.scene, &p.state, Some(p.target)),
        AnyProblem::Rearrangement(p) => (&p.name, &p.scene, &p.start, None),
        AnyProblem::Clearing(p) => (&p.name, &p.scene, &p.state, None),
    };
    let other = args.gripper.as_deref().map(gripper).transpose()?;
    let other = other.map(|gripper| scene.with_gripper(gripper)).transpose()?;
    let scene = other.as_ref().unwrap_or(scene);
    let body = match &args.target {
        Some(named) => find(scene, named)?,
        None => target.ok_or_else(|| Failure::usage("target: the scene has none; name a body with --target"))?,
    };
    let found = examinations(args, scene, state, body)?;
    if let Some(path) = &args.svg {
        output::write_file(path, &picture(name, scene, state, body, &found))?;
    }
    let report = Report {
        scene: name,
        gripper: &scene.gripper().name,
        target: &scene.body(body).name,
        apart_m: APART.0 * scene.gripper().scale(),
        turned_rad: APART.1,
        grasps: found.iter().map(|examined| entry(scene, examined)).collect(),
    };
    output::report(args.json.json.as_deref(), &report, &text(&report))
}

/// A body by its number, else by its name.
fn find(scene: &Scene, named: &str) -> Outcome<usize> {
    let by_number = named.parse().ok().filter(|index| *index < scene.len());
    by_number.or_else(|| scene.bodies().iter().position(|body| body.name == named)).ok_or_else(|| {
        let names: Vec<_> = scene.bodies().iter().map(|body| body.name.as_str()).collect();
        Failure::usage(format!("target: no body has the number or name `{named}`; known: {}", names.join(", ")))
    })
}

fn examinations(args: &GraspsArgs, scene: &Scene, state: &State, body: usize) -> Outcome<Vec<GraspExamination>> {
    let test = GraspTest::new(GraspParams::default())?;
    let mut scratch = GraspScratch::default();
    if args.at.is_empty() {
        return Ok(test.best_apart(scene, state, body, args.k, &mut scratch)?);
    }
    let examine = |[x, y, angle]: &[f64; 3]| {
        let grasp = Grasp { body, position: [*x, *y], angle: *angle, ..Grasp::default() };
        Ok(test.examine(scene, state, &grasp, &mut scratch)?)
    };
    args.at.iter().map(examine).collect()
}

fn entry<'a>(scene: &'a Scene, examined: &GraspExamination) -> Entry<'a> {
    let name = |body: usize| scene.body(body).name.as_str();
    let grasp = &examined.grasp;
    Entry {
        position: grasp.position,
        angle: grasp.angle,
        opening: grasp.opening,
        width: grasp.width,
        margin: grasp.margin,
        score: grasp.score,
        allowed: examined.allowed,
        limit: examined.limit.name(),
        limit_body: examined.limit.body().map(name),
        reason: examined.reason(scene),
        chance: examined.chance,
        wedge: examined.wedge,
        spares: examined.spares.map(|s| Spares {
            fit: s.fit,
            cover: s.cover,
            finger: s.finger,
            between: s.between,
            opening: s.opening,
            wedge: s.wedge,
            finger_body: s.finger_body.map(name),
            between_body: s.between_body.map(name),
        }),
        features: examined.features,
        depth: examined.depth,
    }
}

/// The report for people.
fn text(report: &Report) -> String {
    let Report { scene, gripper, target, grasps, .. } = report;
    let mut out = format!("scene   {scene}: \"{target}\", gripper {gripper}\n");
    if grasps.is_empty() {
        return out + "no grasp of it is allowed where the bodies are\n";
    }
    let heading =
        ["", "x m", "y m", "deg", "opening mm", "width mm", "margin mm", "clearance mm", "score", "chance", ""];
    let mut table = Table::new(heading);
    let mm = |metres: Option<f64>| number(metres.filter(|m| m.is_finite()).map(|m| 1e3 * m), 1);
    for (i, grasp) in grasps.iter().enumerate() {
        table.row([
            format!("{}.", i + 1),
            format!("{:.4}", grasp.position[0]),
            format!("{:.4}", grasp.position[1]),
            format!("{:.1}", grasp.angle.to_degrees()),
            mm(Some(grasp.opening)),
            mm(grasp.features.map(|f| f.width)),
            mm(Some(grasp.margin)),
            mm(grasp.features.map(|f| f.clearance)),
            format!("{:.3}", grasp.score),
            number(grasp.chance, 3),
            if grasp.allowed { "allowed".into() } else { format!("no: {}", grasp.limit) },
        ]);
    }
    // Writing to a string does not fail.
    let _ = write!(out, "{table}");
    for (i, grasp) in grasps.iter().enumerate() {
        let _ = writeln!(out, "{}. {}", i + 1, grasp.reason);
    }
    out
}

/// A panel for every grasp.
fn picture(name: &str, scene: &Scene, state: &State, body: usize, found: &[GraspExamination]) -> String {
    let mut picture = SvgPicture::new();
    picture.title(name);
    for (i, examined) in found.iter().enumerate() {
        let verdict = if examined.allowed { "allowed" } else { examined.limit.name() };
        let caption = format!("{}: score {:.2}, {verdict}", i + 1, examined.grasp.score);
        picture.panel(scene, state, Some(body), Some(&Action::Grasp(examined.grasp)), None, &caption);
    }
    if found.is_empty() {
        picture.panel(scene, state, Some(body), None, None, "no grasp");
    }
    picture.render()
}
