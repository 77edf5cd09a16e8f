//! The list, the document and what the tool accepts, without running anything.

use std::path::Path;

use clap::Parser;
use serde_json::json;

use super::document::{State, chart, document};
use super::list::List;
use super::metrics::{Kind, Measured};
use super::store::Origin;
use crate::args::{Cli, Command};

fn committed() -> List {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("bench/results.toml");
    List::parse(&std::fs::read_to_string(file).unwrap()).unwrap()
}

#[test]
fn the_tool_accepts_every_row_of_the_committed_list() {
    let list = committed();
    assert!(list.rows.len() > 30 && !list.plots.is_empty());
    for row in &list.rows {
        let suite = list.suite(&row.suite).unwrap();
        let arguments = ["jostle".to_string()].into_iter().chain(row.arguments(suite, row.trials));
        let cli = Cli::try_parse_from(arguments).unwrap_or_else(|e| panic!("row {}: {e}", row.id));
        let Command::Run(run) = cli.command else { panic!("row {}: is no run", row.id) };
        assert_eq!((run.suite(), run.trials), (suite.path.as_str(), row.trials), "{}", row.id);
        assert!(row.seconds > 0.0, "{}", row.id);
        let kind = list.section(&row.section).unwrap().kind;
        if matches!(kind, Kind::Retrieval | Kind::RetrievalPerTrial) {
            run.planner.options().unwrap_or_else(|e| panic!("row {}: {e:?}", row.id));
        }
    }
    // Every plot has points, and every section rows.
    for plot in &list.plots {
        assert!(list.rows.iter().any(|row| row.point.is_some() && row.section == plot.section), "{}", plot.id);
    }
    for section in &list.sections {
        assert!(list.rows.iter().any(|row| row.section == section.id), "{}", section.id);
    }
}

#[test]
fn the_committed_list_takes_an_hour_at_most_on_two_cores() {
    let mut commands = std::collections::BTreeMap::new();
    let list = committed();
    for row in &list.rows {
        let command = row.command(list.suite(&row.suite).unwrap(), row.trials);
        commands.insert(command, row.seconds * row.threads.min(2) as f64);
    }
    let minutes = commands.values().sum::<f64>() / 2.0 / 60.0;
    assert!(minutes < 57.0, "{minutes:.0} minutes");
}

const LIST: &str = r#"
[[suite]]
id = "hard"
path = "$CASES/hard"
of = 22
[[section]]
id = "hard"
title = "Hard cases"
kind = "retrieval"
text = ["A paragraph,", "in two lines."]
[[plot]]
id = "budgets"
section = "hard"
title = "Over budgets"
x = "iterations"
y = "actions"
[[row]]
id = "mcts-10"
section = "hard"
suite = "hard"
planner = "mcts"
options = "--iterations 10 --judge bullet"
trials = 2
seconds = 10
label = "`mcts`, 10 iterations"
published = { of = "MCTS-10", actions = 3.19, grasps = 99.1 }
point = { series = "mcts", x = 10 }
[[row]]
id = "unknown"
section = "hard"
suite = "hard"
planner = "no_such"
seconds = 10
[[row]]
id = "later"
section = "hard"
suite = "hard"
planner = "pmbs"
seconds = 10
point = { series = "pmbs", x = 50 }
"#;

/// Two cases with two trials each: three successes with 2, 3 and 4 actions, a failure with 5.
fn report() -> serde_json::Value {
    let trial = |end: &str, actions: u64, grasps: u64| {
        json!({"end": end, "actions": actions, "grasps": grasps, "planning_s": 0.25,
               "decisions": [{"simulations": 10}, {"simulations": 20}]})
    };
    let physics = |engine: &str, preset: &str| json!({"engine": engine, "preset": preset});
    json!({
        "configuration": {"physics": physics("planar", "fast"), "confirm": physics("prism", "fast"),
                          "gripper": "robotiq_2f85", "judge": {"physics": physics("bullet", "reference")}},
        "cases": [{"trials": [trial("grasped", 2, 1), trial("grasped", 3, 1)]},
                  {"trials": [trial("grasped", 4, 2), trial("action_cap", 5, 0)]}],
        "total": {"decision_ms": {"median": 12.4, "p99": 90.6}},
    })
}

fn states() -> Vec<State> {
    let origin = Origin {
        version: "0.1.0".into(),
        commit: "0123456789".into(),
        date: "2026-01-02".into(),
        processor: "a processor".into(),
        cores: 2,
        jobs: 2,
        wall_s: 600.0,
    };
    let measured = Measured::read(Kind::Retrieval, &report()).unwrap();
    let refused = "not available: planner: no planner is named `no_such`";
    vec![State::Done { measured, origin: Box::new(origin), trials: 2 }, State::Missing(refused.into()), State::NotRun]
}

#[test]
fn the_time_of_a_run_that_two_rows_share_counts_once() {
    let list = List::parse(LIST).unwrap();
    let with = |second: f64| {
        let mut all = vec![states().remove(0), states().remove(0), State::NotRun];
        if let State::Done { origin, .. } = &mut all[1] {
            origin.wall_s = second;
        }
        document(&list, &all, "docs/img/results")
    };
    let line = |text: &str| text.lines().find(|l| l.starts_with("* 2 rows")).expect("a line").to_string();
    assert!(line(&with(600.0)).ends_with("; 5 min"), "{}", with(600.0));
    assert!(line(&with(660.0)).ends_with("; 10 min") || line(&with(660.0)).ends_with("; 11 min"), "{}", with(660.0));
}

/// `UPDATE_GOLDEN=1` writes tests/golden/results.md anew.
#[test]
fn the_document_of_a_stored_report_is_as_recorded() {
    let list = List::parse(LIST).unwrap();
    let text = document(&list, &states(), "docs/img/results");
    let golden = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/golden/results.md");
    if std::env::var_os("UPDATE_GOLDEN").is_some() {
        std::fs::write(&golden, &text).unwrap();
    }
    assert_eq!(text, std::fs::read_to_string(golden).unwrap());
}

#[test]
fn a_report_is_read_by_hand() {
    let measured = Measured::read(Kind::Retrieval, &report()).unwrap();
    let value = |key| measured.figure(key).unwrap().value;
    assert_eq!((measured.cases, measured.trials), (2, 4));
    assert!((value("actions") - 14.0 / 3.0).abs() < 1e-12, "all actions over the successes");
    assert_eq!((value("completed"), value("grasps")), (0.75, 0.75));
    assert_eq!((value("simulated"), value("decision"), value("planning")), (30.0, 12.4, 0.25));
    assert_eq!(
        (measured.planned_in.as_str(), measured.judged_in.as_str()),
        ("planar fast, prism fast", "bullet reference")
    );
    let each = Measured::read(Kind::RetrievalPerTrial, &report()).unwrap();
    assert_eq!(each.figure("actions").unwrap().value, 3.5);
    assert!(Measured::read(Kind::Retrieval, &json!({"cases": []})).is_err());
}

#[test]
fn tables_and_rearrangements_are_read_too() {
    let trial = |end: &str, taken: u64, grasps: u64, actions: u64| json!({"end": end, "taken": taken, "grasps": grasps, "actions": actions, "pushes": actions - grasps, "planning_s": 1.0});
    let cleared = json!({
        "physics": {"engine": "planar", "preset": "fast"}, "confirm": null, "gripper": "g",
        "judge": {"physics": {"engine": "rapier", "preset": "fine"}},
        "cases": [{"trials": [trial("cleared", 4, 4, 5), trial("body_left", 2, 4, 5)]}],
        "total": {"decision_ms": {"median": 1.0, "p99": 2.0}},
    });
    let measured = Measured::read(Kind::Clearing, &cleared).unwrap();
    let value = |key| measured.figure(key).unwrap().value;
    assert_eq!((value("completed"), value("kept"), value("grasps"), value("efficiency")), (0.5, 0.5, 0.75, 0.6));
    assert_eq!((value("pushes"), value("planning")), (1.0, 1.0));
    assert_eq!((measured.planned_in.as_str(), measured.judged_in.as_str()), ("planar fast", "rapier fine"));

    let trial = |end: &str, actions: u64| json!({"end": end, "actions": actions, "robot_s": 3.0 * actions as f64, "planning_s": 2.0, "iterations": [10, 30]});
    let trials = [trial("completed", 6), trial("completed", 8), trial("no_action", 4)];
    let moved = json!({"max_actions": 20, "cases": [{"trials": trials}]});
    let measured = Measured::read(Kind::Rearrangement, &moved).unwrap();
    let value = |key| measured.figure(key).unwrap().value;
    assert!((value("actions") - 34.0 / 3.0).abs() < 1e-12, "a failed trial counts with the cap");
    assert_eq!((value("of_completed"), value("robot"), value("iterations")), (7.0, 18.0, 20.0));
    assert!((value("completed") - 2.0 / 3.0).abs() < 1e-12);
}

#[test]
fn a_plot_has_what_was_measured_and_what_was_published() {
    let list = List::parse(LIST).unwrap();
    let chart = chart(&list, &list.plots[0], &states()).unwrap();
    assert_eq!(chart.series.len(), 2, "a line without a point keeps its colour");
    assert_eq!((chart.series[0].points.len(), &chart.series[0].published), (1, &vec![(10.0, 3.19)]));
    assert!(chart.series[1].points.is_empty() && !chart.is_empty());
}

#[test]
fn mistakes_in_a_list_name_the_row_and_the_key() {
    assert_eq!(List::parse("").unwrap_err(), "holds no [[row]]: there is nothing to be measured");
    let changed = |from: &str, to: &str| {
        assert!(LIST.contains(from), "{from}");
        List::parse(&LIST.replacen(from, to, 1)).unwrap_err()
    };
    for (from, to, error) in [
        ("trials = 2", "trials = \"2\"", "row `mcts-10`: trials: is a text; it must be a number"),
        ("trials = 2", "trials = 0", "row `mcts-10`: trials: is 0; it must be at least 1"),
        ("trials = 2", "trials = 2.5", "row `mcts-10`: trials: is 2.5; it must be a whole number"),
        ("trials = 2", "tirals = 2", "row `mcts-10`: tirals: is not known"),
        ("planner = \"mcts\"\n", "", "row `mcts-10`: planner: is missing"),
        ("id = \"mcts-10\"\n", "", "row in line 17: id: is missing"),
        ("id = \"later\"", "id = \"unknown\"", "row `unknown`: id: is given twice"),
        (
            "suite = \"hard\"\nplanner = \"mcts\"",
            "suite = \"soft\"\nplanner = \"mcts\"",
            "row `mcts-10`: suite: there is no suite `soft`",
        ),
        (
            "grasps = 99.1",
            "grips = 99.1",
            "row `mcts-10`: published: there is no value `grips`; known: actions, completed, grasps, planning, decision, p99, simulated",
        ),
        ("of = \"MCTS-10\", ", "", "row `mcts-10`: published.of: is missing"),
        (
            "series = \"mcts\"",
            "line = \"mcts\"",
            "row `mcts-10`: point.line: is not known; known: series, x, published_x",
        ),
        (
            "section = \"hard\"\ntitle",
            "section = \"soft\"\ntitle",
            "plot `budgets`: section: there is no section `soft`",
        ),
        (
            "y = \"actions\"",
            "y = \"joy\"",
            "plot `budgets`: y: there is no value `joy`; known: actions, completed, grasps, planning, decision, p99, simulated",
        ),
        (
            "kind = \"retrieval\"",
            "kind = \"chess\"",
            "section `hard`: kind: is `chess`; known: retrieval, retrieval-per-trial, clearing, rearrangement",
        ),
        ("[[plot]]", "[[graph]]", "line 11: there are no [[graph]]"),
        ("of = 22", "of = x", "line 5: `of = x`: string values must be quoted, expected literal string"),
    ] {
        assert_eq!(changed(from, to), error);
    }
}

#[test]
fn days_become_dates() {
    for (days, date) in [(0, "1970-01-01"), (59, "1970-03-01"), (11_016, "2000-02-29"), (20_781, "2026-11-24")] {
        assert_eq!(super::date(days), date);
    }
}
