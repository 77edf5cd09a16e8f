//! The results document: a table for each section, with the published figures beside ours, the commands, the pictures.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write as _;

use super::list::{List, Plot, Row, Section};
use super::metrics::{Form, Measured, Metric, written};
use super::plot::{Chart, Series};
use super::store::Origin;

/// What is known of a row.
#[derive(Debug, Clone)]
pub enum State {
    /// Measured, with so many trials of each case.
    Done { measured: Measured, origin: Box<Origin>, trials: u64 },
    /// It cannot be measured here, and why.
    Missing(String),
    /// It was not measured yet.
    NotRun,
}

impl State {
    fn measured(&self) -> Option<&Measured> {
        if let State::Done { measured, .. } = self { Some(measured) } else { None }
    }
}

const HEAD: &str = "\
# Results

Written by `make results`; what is changed by hand is lost. [bench/results.toml](bench/results.toml) lists the experiments;
each row is one run of the command below its table, in which `$CASES` is the folder of the original test cases.
";

const HOW_TO_READ: &str = "\
The *published* columns are the dissertation that describes the planners, with its own simulators, networks and machine. Ours
is measured in simulation, with friction scaled by up to 20 % for every body and the tip, and observations with noise of 1 mm
and 1 degree; Bullet `reference`, where it judges, executes pushes and grasps. `n of N`: so many of a suite's cases were at
hand; *trials* is their number over all cases. `±` is the standard error of the mean over trials, which holds the differences between
cases as well; none is given where it would be zero. *Planned in*: the engine of the search, then the one that plans are confirmed in.
";

/// The document; `states` has one entry for each row of the list. `plots`: the folder of the pictures, as a link says it.
pub fn document(list: &List, states: &[State], plots: &str) -> String {
    let mut out = String::from(HEAD);
    // Writing to a string does not fail.
    let _ = write!(out, "\n{}\n{HOW_TO_READ}", origins(states));
    for section in &list.sections {
        let rows: Vec<(&Row, &State)> = list.rows.iter().zip(states).filter(|(r, _)| r.section == section.id).collect();
        let _ = writeln!(out, "\n## {}\n", section.title);
        if !section.text.is_empty() {
            let _ = writeln!(out, "{}\n", section.text.join("\n"));
        }
        out.push_str(&table(list, section, &rows));
        out.push_str(&commands(list, &rows));
        for plot in list.plots.iter().filter(|plot| plot.section == section.id) {
            if chart(list, plot, states).is_some_and(|chart| !chart.is_empty()) {
                let _ = writeln!(out, "\n![{}]({plots}/{}.svg)", plot.title, plot.id);
            }
        }
    }
    out.push_str(&missing(list, states));
    out
}

/// When and on what the rows were measured: one line for each date, build and machine.
fn origins(states: &[State]) -> String {
    let mut groups: BTreeMap<String, (usize, f64)> = BTreeMap::new();
    let mut runs = BTreeSet::new();
    for state in states {
        let State::Done { origin: o, .. } = state else { continue };
        let jobs = if o.jobs == 1 { "one row at a time".into() } else { format!("{} rows side by side", o.jobs) };
        let key = format!(
            "{}, jostle {}, commit `{}`, {}, {} cores, {jobs}",
            o.date, o.version, o.commit, o.processor, o.cores
        );
        let group = groups.entry(key).or_default();
        group.0 += 1;
        // Rows with the same command share one run, and have its time to the nanosecond.
        if runs.insert(o.wall_s.to_bits()) {
            group.1 += o.wall_s / o.jobs.max(1) as f64;
        }
    }
    if groups.is_empty() {
        return "Nothing was measured yet.\n".into();
    }
    let mut out = format!("{} of {} rows are measured:\n\n", groups.values().map(|g| g.0).sum::<usize>(), states.len());
    for (key, (rows, seconds)) in groups {
        let _ = writeln!(out, "* {rows} rows: {key}; {:.0} min", (seconds / 60.0).max(1.0));
    }
    out
}

fn table(list: &List, section: &Section, rows: &[(&Row, &State)]) -> String {
    let published = |metric: &Metric| {
        rows.iter().any(|(row, _)| row.published.iter().flat_map(|p| &p.values).any(|value| value.key == metric.key))
    };
    let any_published = rows.iter().any(|(row, _)| row.published.is_some());
    let gripper = rows.iter().any(|(_, state)| state.measured().is_some_and(|m| m.gripper.is_some()));
    let mut heading: Vec<String> = vec!["#".into(), "system".into(), "suite".into()];
    if gripper {
        heading.push("gripper".into());
    }
    heading.extend(["planned in".into(), "judged in".into(), "trials".into()]);
    if any_published {
        heading.push("published as".into());
    }
    for metric in section.kind.metrics() {
        heading.push(metric.heading.into());
        if published(metric) {
            heading.push("published".into());
        }
    }
    let mut out = format!("| {} |\n|{}\n", heading.join(" | "), "---|".repeat(heading.len()));
    for (number, (row, state)) in rows.iter().enumerate() {
        let measured = state.measured();
        let of = list.suite(&row.suite).map_or(0, |suite| suite.of);
        let name = row.suite.as_str();
        let suite = match measured {
            Some(m) if of > 0 => format!("{name} ({} of {of})", m.cases),
            _ => name.to_string(),
        };
        let mut cells = vec![(number + 1).to_string(), row.label.clone(), suite];
        if gripper {
            cells.push(measured.and_then(|m| m.gripper.as_ref()).map(|g| format!("`{g}`")).unwrap_or_default());
        }
        match (measured, state) {
            (Some(m), _) => cells.extend([m.planned_in.clone(), m.judged_in.clone(), m.trials.to_string()]),
            (None, State::Missing(why)) => cells.extend([format!("*{}*", cell(why)), String::new(), String::new()]),
            (None, _) => cells.extend(["*not measured*".into(), String::new(), String::new()]),
        }
        if any_published {
            cells.push(row.published.as_ref().map(|p| p.of.clone()).unwrap_or_default());
        }
        for metric in section.kind.metrics() {
            let ours = measured.and_then(|m| m.figure(metric.key));
            cells.push(ours.map(|figure| written(figure, metric.form)).unwrap_or_default());
            if published(metric) {
                let value = row.published.iter().flat_map(|p| &p.values).find(|value| value.key == metric.key);
                let unit = if metric.form == Form::Share { " %" } else { "" };
                cells.push(value.map(|value| format!("{}{unit}", value.text)).unwrap_or_default());
            }
        }
        let _ = writeln!(out, "| {} |", cells.join(" | "));
    }
    out
}

/// A text that cannot break a table.
fn cell(text: &str) -> String {
    text.replace('|', "/").split_whitespace().collect::<Vec<_>>().join(" ")
}

fn commands(list: &List, rows: &[(&Row, &State)]) -> String {
    let mut out = String::from("\n```sh\n");
    for (number, (row, state)) in rows.iter().enumerate() {
        let Some(suite) = list.suite(&row.suite) else { continue };
        let trials = if let State::Done { trials, .. } = state { *trials } else { row.trials };
        let _ = writeln!(out, "{} # {}", row.command(suite, trials), number + 1);
    }
    out.push_str("```\n");
    out
}

/// What was left out, and why.
fn missing(list: &List, states: &[State]) -> String {
    let mut reasons: BTreeMap<&str, Vec<&str>> = BTreeMap::new();
    for (row, state) in list.rows.iter().zip(states) {
        match state {
            State::Done { .. } => {}
            State::Missing(why) => reasons.entry(why).or_default().push(&row.id),
            State::NotRun => reasons.entry("not measured").or_default().push(&row.id),
        }
    }
    if reasons.is_empty() {
        return String::new();
    }
    let mut out = String::from("\n## Left out\n\n");
    for (why, rows) in reasons {
        let _ = writeln!(out, "* {}: {}", cell(why), rows.join(", "));
    }
    out
}

/// The picture of a plot; none if the plot's section is not there.
pub fn chart(list: &List, plot: &Plot, states: &[State]) -> Option<Chart> {
    let metric = list.section(&plot.section)?.kind.metric(&plot.y).ok()?;
    let mut series: Vec<Series> = Vec::new();
    for (row, state) in list.rows.iter().zip(states) {
        let Some(point) = row.point.as_ref().filter(|_| row.section == plot.section) else { continue };
        if !series.iter().any(|s| s.name == point.series) {
            series.push(Series { name: point.series.clone(), ..Series::default() });
        }
        let Some(line) = series.iter_mut().find(|s| s.name == point.series) else { continue };
        if let Some(figure) = state.measured().and_then(|m| m.figure(&plot.y)) {
            line.points.push((point.x, figure));
        }
        let published = row.published.iter().flat_map(|p| &p.values).filter(|value| value.key == plot.y);
        line.published.extend(published.map(|p| (point.published_x.unwrap_or(point.x), p.value)));
    }
    for line in &mut series {
        line.points.sort_by(|a, b| a.0.total_cmp(&b.0));
    }
    let y = if metric.form == Form::Share { format!("{}, %", metric.heading) } else { metric.heading.to_string() };
    let (title, x) = (plot.title.clone(), plot.x.clone());
    Some(Chart { title, x, y, form: metric.form, logarithmic: plot.logarithmic, series })
}
