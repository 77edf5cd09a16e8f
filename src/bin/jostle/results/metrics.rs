//! What the reports of `jostle run` say: for each kind of suite its values, with standard errors.

use serde_json::Value;

/// What a suite asks of a planner.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// A target is to be grasped. Actions are counted over the successful trials (VFT, MORE).
    Retrieval,
    /// The same, with the mean over all trials, failed ones included (PMBS).
    RetrievalPerTrial,
    /// A table is to be cleared.
    Clearing,
    /// Every body has a goal.
    Rearrangement,
}

/// How a value is written.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Form {
    /// With so many decimals.
    Number(usize),
    /// A share, as a percentage.
    Share,
}

/// One column of a table.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Metric {
    pub key: &'static str,
    pub heading: &'static str,
    pub form: Form,
}

const fn metric(key: &'static str, heading: &'static str, form: Form) -> Metric {
    Metric { key, heading, form }
}

const RETRIEVAL: &[Metric] = &[
    metric("actions", "actions", Form::Number(2)),
    metric("completed", "completed", Form::Share),
    metric("grasps", "grasps held", Form::Share),
    metric("planning", "planning, s a case", Form::Number(2)),
    metric("decision", "decision, median ms", Form::Number(0)),
    metric("p99", "p99 ms", Form::Number(0)),
    metric("simulated", "pushes simulated a case", Form::Number(0)),
];

const CLEARING: &[Metric] = &[
    metric("completed", "completed", Form::Share),
    metric("kept", "nothing off the table", Form::Share),
    metric("grasps", "grasp success", Form::Share),
    metric("efficiency", "efficiency", Form::Share),
    metric("pushes", "pushes a table", Form::Number(2)),
    metric("planning", "planning, s a table", Form::Number(2)),
    metric("p99", "decision, p99 ms", Form::Number(0)),
];

const REARRANGEMENT: &[Metric] = &[
    metric("completed", "completed", Form::Share),
    metric("actions", "actions", Form::Number(2)),
    metric("of_completed", "of completed trials", Form::Number(2)),
    metric("robot", "robot s", Form::Number(1)),
    metric("planning", "planning, s a case", Form::Number(1)),
    metric("iterations", "iterations a decision", Form::Number(0)),
];

impl Kind {
    pub fn by_name(name: &str) -> Result<Kind, String> {
        match name {
            "retrieval" => Ok(Kind::Retrieval),
            "retrieval-per-trial" => Ok(Kind::RetrievalPerTrial),
            "clearing" => Ok(Kind::Clearing),
            "rearrangement" => Ok(Kind::Rearrangement),
            _ => Err(format!("is `{name}`; known: retrieval, retrieval-per-trial, clearing, rearrangement")),
        }
    }

    /// The columns in their order.
    pub fn metrics(self) -> &'static [Metric] {
        match self {
            Kind::Retrieval | Kind::RetrievalPerTrial => RETRIEVAL,
            Kind::Clearing => CLEARING,
            Kind::Rearrangement => REARRANGEMENT,
        }
    }

    pub fn metric(self, key: &str) -> Result<Metric, String> {
        let found = self.metrics().iter().find(|metric| metric.key == key);
        found.copied().ok_or_else(|| {
            let known: Vec<_> = self.metrics().iter().map(|metric| metric.key).collect();
            format!("there is no value `{key}`; known: {}", known.join(", "))
        })
    }
}

/// A value and its standard error.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Figure {
    pub value: f64,
    /// None where there is one trial or where it is a quantile.
    pub error: Option<f64>,
}

impl Figure {
    /// A sum over a sum, such as actions over successes. The standard error is that of a ratio of means over
    /// independent trials: the root of the mean square of `numerator - ratio denominator`, over the mean denominator and
    /// the root of n. With ones as denominators it is the usual one.
    pub fn ratio(pairs: &[(f64, f64)]) -> Option<Figure> {
        let n = pairs.len() as f64;
        let (above, below) = pairs.iter().fold((0.0, 0.0), |(a, b), (x, y)| (a + x, b + y));
        if below <= 0.0 {
            return None;
        }
        let value = above / below;
        let squares: f64 = pairs.iter().map(|(x, y)| (x - value * y).powi(2)).sum();
        let error = (pairs.len() > 1).then(|| (squares / (n * (n - 1.0))).sqrt() / (below / n));
        Some(Figure { value, error })
    }

    fn mean(values: impl Iterator<Item = f64>) -> Option<Figure> {
        Figure::ratio(&values.map(|value| (value, 1.0)).collect::<Vec<_>>())
    }
}

/// What a report says.
#[derive(Debug, Clone, PartialEq)]
pub struct Measured {
    pub cases: usize,
    pub trials: usize,
    pub figures: Vec<(&'static str, Figure)>,
    /// Engines of the planner's model and of confirming.
    pub planned_in: String,
    pub judged_in: String,
    pub gripper: Option<String>,
}

impl Measured {
    pub fn figure(&self, key: &str) -> Option<Figure> {
        self.figures.iter().find(|(known, _)| *known == key).map(|(_, figure)| *figure)
    }

    /// Reads a report of `jostle run --json`.
    pub fn read(kind: Kind, report: &Value) -> Result<Measured, String> {
        let cases = report["cases"].as_array().ok_or("the report has no cases")?;
        let trials: Vec<&Value> = cases.iter().filter_map(|case| case["trials"].as_array()).flatten().collect();
        if trials.is_empty() {
            return Err("the report has no trials".into());
        }
        let mut figures = Vec::new();
        for metric in kind.metrics() {
            if let Some(figure) = value(kind, metric.key, report, &trials) {
                figures.push((metric.key, figure));
            }
        }
        let (planned_in, judged_in, gripper) = engines(kind, report);
        Ok(Measured { cases: cases.len(), trials: trials.len(), figures, planned_in, judged_in, gripper })
    }
}

fn value(kind: Kind, key: &str, report: &Value, trials: &[&Value]) -> Option<Figure> {
    let ended = |trial: &Value, end: &str| f64::from(u8::from(trial["end"] == end));
    let success = |trial: &Value| {
        let end = match kind {
            Kind::Retrieval | Kind::RetrievalPerTrial => "grasped",
            Kind::Clearing => "cleared",
            Kind::Rearrangement => "completed",
        };
        ended(trial, end)
    };
    let number = |trial: &Value, key: &str| trial[key].as_f64().unwrap_or(0.0);
    let ratio = |pair: &dyn Fn(&Value) -> (f64, f64)| {
        Figure::ratio(&trials.iter().map(|trial| pair(trial)).collect::<Vec<_>>())
    };
    let quantile =
        |name: &str| report["total"]["decision_ms"][name].as_f64().map(|value| Figure { value, error: None });
    match (kind, key) {
        (_, "completed") => ratio(&|t| (success(t), 1.0)),
        (_, "planning") => Figure::mean(trials.iter().map(|t| number(t, "planning_s"))),
        (_, "decision") => quantile("median"),
        (_, "p99") => quantile("p99"),
        (Kind::Retrieval, "actions") => ratio(&|t| (number(t, "actions"), success(t))),
        (Kind::RetrievalPerTrial, "actions") => ratio(&|t| (number(t, "actions"), 1.0)),
        (Kind::Retrieval | Kind::RetrievalPerTrial, "grasps") => ratio(&|t| (success(t), number(t, "grasps"))),
        (_, "simulated") => {
            let decisions = |t: &Value| t["decisions"].as_array().cloned().unwrap_or_default();
            Figure::mean(trials.iter().map(|t| decisions(t).iter().map(|d| number(d, "simulations")).sum()))
        }
        (Kind::Clearing, "kept") => ratio(&|t| (1.0 - ended(t, "body_left"), 1.0)),
        (Kind::Clearing, "grasps") => ratio(&|t| (number(t, "taken"), number(t, "grasps"))),
        (Kind::Clearing, "efficiency") => ratio(&|t| (number(t, "taken"), number(t, "actions"))),
        (Kind::Clearing, "pushes") => ratio(&|t| (number(t, "pushes"), 1.0)),
        // A failed trial counts with the cap, as in the source.
        (Kind::Rearrangement, "actions") => {
            let cap = report["max_actions"].as_f64().unwrap_or(0.0);
            ratio(&|t| (if success(t) > 0.0 { number(t, "actions") } else { cap.max(number(t, "actions")) }, 1.0))
        }
        (Kind::Rearrangement, "of_completed") => ratio(&|t| (number(t, "actions") * success(t), success(t))),
        (Kind::Rearrangement, "robot") => ratio(&|t| (number(t, "robot_s"), 1.0)),
        (Kind::Rearrangement, "iterations") => {
            let of = |t: &Value| t["iterations"].as_array().cloned().unwrap_or_default();
            ratio(&|t| (of(t).iter().filter_map(Value::as_f64).sum(), of(t).len() as f64))
        }
        _ => None,
    }
}

/// Engines of planning and of judging, and the gripper.
fn engines(kind: Kind, report: &Value) -> (String, String, Option<String>) {
    let named = |physics: &Value| {
        let preset = physics["preset"].as_str().unwrap_or_default();
        // A network's preset may be a file of the machine; its name tells enough.
        let preset = preset.rsplit('/').next().unwrap_or(preset);
        match physics["engine"].as_str().unwrap_or("?") {
            engine if engine == preset || preset.is_empty() => engine.to_string(),
            engine => format!("{engine} {preset}"),
        }
    };
    let asked = match kind {
        Kind::Retrieval | Kind::RetrievalPerTrial => &report["configuration"],
        Kind::Clearing => report,
        Kind::Rearrangement => return ("exact motion".into(), "certificate".into(), None),
    };
    let mut planned = named(&asked["physics"]);
    if asked["confirm"].is_object() {
        planned = format!("{planned}, {}", named(&asked["confirm"]));
    }
    (planned, named(&asked["judge"]["physics"]), asked["gripper"].as_str().map(Into::into))
}

/// A number as it stands in a table; its standard error behind it if it has one that shows.
pub fn written(figure: Figure, form: Form) -> String {
    let (scale, digits, unit) = match form {
        Form::Number(digits) => (1.0, digits, ""),
        Form::Share => (100.0, 1, " %"),
    };
    let value = format!("{:.digits$}", figure.value * scale);
    let shows = |text: &str| text.chars().any(|c| c.is_ascii_digit() && c != '0');
    if figure.value > 0.0 && !shows(&value) {
        return format!("< {:.digits$}{unit}", 10f64.powi(-(digits as i32)));
    }
    let value = if form == Form::Share && value == "100.0" { "100".into() } else { value };
    match figure.error.map(|error| format!("{:.digits$}", error * scale)) {
        Some(error) if shows(&error) => format!("{value} ± {error}{unit}"),
        _ => format!("{value}{unit}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn standard_errors_are_those_of_a_mean_and_of_a_ratio() {
        let mean = Figure::mean([1.0, 2.0, 3.0, 6.0].into_iter()).unwrap();
        // Deviations -2, -1, 0, 3: variance 14 / 3, over 4.
        assert!((mean.value - 3.0).abs() < 1e-12 && (mean.error.unwrap() - (14.0f64 / 12.0).sqrt()).abs() < 1e-12);
        // Three actions over two successes: 1.5; rests 0.5, -0.5 of two trials with mean denominator 1.
        let ratio = Figure::ratio(&[(2.0, 1.0), (1.0, 1.0)]).unwrap();
        assert!((ratio.value - 1.5).abs() < 1e-12 && (ratio.error.unwrap() - 0.5).abs() < 1e-12);
        assert_eq!(Figure::ratio(&[(2.0, 1.0)]).unwrap().error, None);
        assert_eq!(Figure::ratio(&[(2.0, 0.0)]), None, "no success, no actions a success");
    }

    #[test]
    fn figures_are_written_with_the_error_that_shows() {
        let figure = |value, error| Figure { value, error };
        assert_eq!(written(figure(2.664, Some(0.104)), Form::Number(2)), "2.66 ± 0.10");
        assert_eq!(written(figure(12.0, Some(0.2)), Form::Number(0)), "12");
        assert_eq!(written(figure(0.9857, Some(0.0142)), Form::Share), "98.6 ± 1.4 %");
        assert_eq!(written(figure(1.0, Some(0.0)), Form::Share), "100 %");
        assert_eq!(written(figure(0.5, None), Form::Share), "50.0 %");
        assert_eq!(written(figure(0.004, Some(0.1)), Form::Number(2)), "< 0.01");
        assert_eq!(written(figure(0.0, Some(0.0)), Form::Number(2)), "0.00");
    }
}
