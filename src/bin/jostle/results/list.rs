//! The list of experiments (`bench/results.toml`): sections, suites, plots and rows. A row is one `jostle run`.

use super::metrics::Kind;
use super::tables::{self, Entry, Table, Value};

/// Everything that the results document is made of.
#[derive(Debug, Clone, Default)]
pub struct List {
    pub sections: Vec<Section>,
    pub suites: Vec<Suite>,
    pub plots: Vec<Plot>,
    pub rows: Vec<Row>,
}

/// A table of the document.
#[derive(Debug, Clone)]
pub struct Section {
    pub id: String,
    pub title: String,
    pub kind: Kind,
    /// Lines before the table; an empty one ends a paragraph.
    pub text: Vec<String>,
}

/// What a row runs on.
#[derive(Debug, Clone)]
pub struct Suite {
    pub id: String,
    /// As `jostle run` takes it; `$CASES` stands for the folder of the original test cases.
    pub path: String,
    /// Number of its cases where it is whole.
    pub of: usize,
}

/// A picture of a section's rows that have a point: a value over a setting.
#[derive(Debug, Clone)]
pub struct Plot {
    pub id: String,
    /// The section it belongs to.
    pub section: String,
    pub title: String,
    /// Title of the horizontal axis, with the unit.
    pub x: String,
    /// Key of the value upwards.
    pub y: String,
    pub logarithmic: bool,
}

/// What a row asks of the machine beyond the tool itself.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Need {
    /// ONNX Runtime, for networks.
    Networks,
}

/// One experiment.
#[derive(Debug, Clone)]
pub struct Row {
    pub id: String,
    pub section: String,
    pub suite: String,
    pub planner: String,
    /// Further options of `jostle run`.
    pub options: Vec<String>,
    pub trials: u64,
    pub threads: usize,
    /// Seconds that it takes, as measured once; for the plan and the estimate of what is left.
    pub seconds: f64,
    /// What the table calls it.
    pub label: String,
    pub needs: Option<Need>,
    pub published: Option<Published>,
    /// Where it stands in its section's plots.
    pub point: Option<Point>,
}

/// What the dissertation has in this place.
#[derive(Debug, Clone, PartialEq)]
pub struct Published {
    /// The system's name there.
    pub of: String,
    pub values: Vec<PublishedValue>,
}

#[derive(Debug, Clone, PartialEq)]
pub struct PublishedValue {
    /// A key of the section's kind.
    pub key: String,
    pub value: f64,
    /// With the decimals that were published.
    pub text: String,
}

#[derive(Debug, Clone, PartialEq)]
pub struct Point {
    pub series: String,
    pub x: f64,
    /// Where the published value stands; as `x` if absent.
    pub published_x: Option<f64>,
}

impl Row {
    /// The arguments of the tool, with `$CASES` in the suite's path as it is.
    pub fn arguments(&self, suite: &Suite, trials: u64) -> Vec<String> {
        let mut arguments = vec!["run".into(), suite.path.clone(), "--planner".into(), self.planner.clone()];
        arguments.extend(self.options.iter().cloned());
        arguments.extend(["--trials".into(), trials.to_string(), "--threads".into(), self.threads.to_string()]);
        arguments
    }

    /// What a reader types.
    pub fn command(&self, suite: &Suite, trials: u64) -> String {
        format!("jostle {}", self.arguments(suite, trials).join(" "))
    }
}

impl List {
    /// Reads a list and checks that it fits together.
    ///
    /// # Errors
    /// One line that names the entry and the key.
    pub fn parse(text: &str) -> Result<List, String> {
        let mut list = List::default();
        for table in tables::parse(text)? {
            let mut keys = Keys::new(&table);
            match table.name.as_str() {
                "section" => list.sections.push(Section::read(&mut keys)?),
                "suite" => list.suites.push(Suite::read(&mut keys)?),
                "plot" => list.plots.push(Plot::read(&mut keys)?),
                "row" => list.rows.push(Row::read(&mut keys)?),
                other => return Err(format!("line {}: there are no [[{other}]]", table.line)),
            }
            keys.end()?;
        }
        list.check()?;
        Ok(list)
    }

    pub fn section(&self, id: &str) -> Option<&Section> {
        self.sections.iter().find(|section| section.id == id)
    }

    pub fn suite(&self, id: &str) -> Option<&Suite> {
        self.suites.iter().find(|suite| suite.id == id)
    }

    /// Names are there, unique, and of the right kind.
    fn check(&self) -> Result<(), String> {
        if self.rows.is_empty() {
            return Err("holds no [[row]]: there is nothing to be measured".into());
        }
        unique("section", self.sections.iter().map(|s| &s.id))?;
        unique("suite", self.suites.iter().map(|s| &s.id))?;
        unique("plot", self.plots.iter().map(|p| &p.id))?;
        unique("row", self.rows.iter().map(|r| &r.id))?;
        for plot in &self.plots {
            let place = |key: &str| format!("plot `{}`: {key}", plot.id);
            let section = self.named(&plot.section).map_err(|e| format!("{}: {e}", place("section")))?;
            section.kind.metric(&plot.y).map_err(|e| format!("{}: {e}", place("y")))?;
        }
        for row in &self.rows {
            let place = |key: &str| format!("row `{}`: {key}", row.id);
            let section = self.named(&row.section).map_err(|e| format!("{}: {e}", place("section")))?;
            if self.suite(&row.suite).is_none() {
                return Err(format!("{}: there is no suite `{}`", place("suite"), row.suite));
            }
            for value in row.published.iter().flat_map(|p| &p.values) {
                section.kind.metric(&value.key).map_err(|e| format!("{}: {e}", place("published")))?;
            }
            if let Some(point) = &row.point {
                let mut plots = self.plots.iter().filter(|plot| plot.section == row.section).peekable();
                if plots.peek().is_none() {
                    return Err(format!("{}: the section has no plot", place("point")));
                }
                if plots.any(|plot| plot.logarithmic) && !(point.x > 0.0 && point.published_x.is_none_or(|x| x > 0.0)) {
                    return Err(format!("{}: is not above 0, and the axis is logarithmic", place("point.x")));
                }
            }
        }
        Ok(())
    }

    fn named(&self, section: &str) -> Result<&Section, String> {
        self.section(section).ok_or_else(|| format!("there is no section `{section}`"))
    }
}

fn unique<'a>(what: &str, ids: impl Iterator<Item = &'a String>) -> Result<(), String> {
    let mut seen = std::collections::BTreeSet::new();
    for id in ids {
        if !seen.insert(id) {
            return Err(format!("{what} `{id}`: id: is given twice"));
        }
    }
    Ok(())
}

impl Section {
    fn read(keys: &mut Keys) -> Result<Section, String> {
        let kind = keys.text("kind")?;
        Ok(Section {
            id: keys.text("id")?,
            title: keys.text("title")?,
            kind: Kind::by_name(&kind).map_err(|e| keys.wrong("kind", &e))?,
            text: keys.texts("text")?,
        })
    }
}

impl Suite {
    fn read(keys: &mut Keys) -> Result<Suite, String> {
        Ok(Suite { id: keys.text("id")?, path: keys.text("path")?, of: keys.count("of")?.unwrap_or(0) as usize })
    }
}

impl Plot {
    fn read(keys: &mut Keys) -> Result<Plot, String> {
        Ok(Plot {
            id: keys.text("id")?,
            section: keys.text("section")?,
            title: keys.text("title")?,
            x: keys.text("x")?,
            y: keys.text("y")?,
            logarithmic: keys.flag("logarithmic")?,
        })
    }
}

impl Row {
    fn read(keys: &mut Keys) -> Result<Row, String> {
        let planner = keys.text("planner")?;
        let needs = match keys.optional_text("needs")?.as_deref() {
            None => None,
            Some("networks") => Some(Need::Networks),
            Some(other) => return Err(keys.wrong("needs", &format!("is `{other}`; known: networks"))),
        };
        let at_least_one = |keys: &Keys, key: &str, value: Option<u64>, default: u64| match value {
            Some(0) => Err(keys.wrong(key, "is 0; it must be at least 1")),
            value => Ok(value.unwrap_or(default)),
        };
        let trials = keys.count("trials")?;
        let threads = keys.count("threads")?;
        Ok(Row {
            id: keys.text("id")?,
            section: keys.text("section")?,
            suite: keys.text("suite")?,
            options: keys.optional_text("options")?.unwrap_or_default().split_whitespace().map(Into::into).collect(),
            trials: at_least_one(keys, "trials", trials, 5)?,
            threads: at_least_one(keys, "threads", threads, 1)? as usize,
            seconds: keys.number("seconds")?,
            label: keys.optional_text("label")?.unwrap_or_else(|| format!("`{planner}`")),
            needs,
            published: keys.optional_table("published")?.map(published).transpose().map_err(|e| keys.within(&e))?,
            point: keys.optional_table("point")?.map(point).transpose().map_err(|e| keys.within(&e))?,
            planner,
        })
    }
}

fn published(entries: Vec<Entry>) -> Result<Published, String> {
    let mut of = None;
    let mut values = Vec::new();
    for (key, value) in entries {
        match value {
            Value::Text(text) if key == "of" => of = Some(text),
            Value::Number(value, text) if key != "of" => values.push(PublishedValue { key, value, text }),
            other => return Err(format!("published.{key}: is {}", other.kind())),
        }
    }
    Ok(Published { of: of.ok_or("published.of: is missing")?, values })
}

fn point(entries: Vec<Entry>) -> Result<Point, String> {
    let (mut series, mut x, mut published_x) = (None, None, None);
    for (key, value) in entries {
        match (key.as_str(), value) {
            ("series", Value::Text(text)) => series = Some(text),
            ("x", Value::Number(number, _)) => x = Some(number),
            ("published_x", Value::Number(number, _)) => published_x = Some(number),
            ("series" | "x" | "published_x", other) => {
                return Err(format!("point.{key}: is {}", other.kind()));
            }
            _ => return Err(format!("point.{key}: is not known; known: series, x, published_x")),
        }
    }
    let missing = |key: &str| format!("point.{key}: is missing");
    Ok(Point { series: series.ok_or_else(|| missing("series"))?, x: x.ok_or_else(|| missing("x"))?, published_x })
}

/// The keys of a table, taken one by one; what is left in the end is a mistake.
struct Keys {
    /// How messages call the table.
    place: String,
    entries: Vec<Entry>,
}

impl Keys {
    fn new(table: &Table) -> Keys {
        let id = table.entries.iter().find_map(|(key, value)| match value {
            Value::Text(text) if key == "id" => Some(text.as_str()),
            _ => None,
        });
        let place =
            id.map_or_else(|| format!("{} in line {}", table.name, table.line), |id| format!("{} `{id}`", table.name));
        Keys { place, entries: table.entries.clone() }
    }

    fn within(&self, what: &str) -> String {
        format!("{}: {what}", self.place)
    }

    fn wrong(&self, key: &str, what: &str) -> String {
        self.within(&format!("{key}: {what}"))
    }

    fn take(&mut self, key: &str) -> Option<Value> {
        let at = self.entries.iter().position(|(known, _)| known == key)?;
        Some(self.entries.remove(at).1)
    }

    fn mistaken(&self, key: &str, value: &Value, wanted: &str) -> String {
        self.wrong(key, &format!("is {}; it must be {wanted}", value.kind()))
    }

    fn optional_text(&mut self, key: &str) -> Result<Option<String>, String> {
        match self.take(key) {
            None => Ok(None),
            Some(Value::Text(text)) => Ok(Some(text)),
            Some(other) => Err(self.mistaken(key, &other, "a text")),
        }
    }

    fn text(&mut self, key: &str) -> Result<String, String> {
        self.optional_text(key)?.ok_or_else(|| self.wrong(key, "is missing"))
    }

    /// A text or several; none if absent.
    fn texts(&mut self, key: &str) -> Result<Vec<String>, String> {
        let items = match self.take(key) {
            None => Vec::new(),
            Some(Value::List(items)) => items,
            Some(value) => vec![value],
        };
        let text = |value| match value {
            Value::Text(text) => Ok(text),
            other => Err(self.mistaken(key, &other, "a text or an array of texts")),
        };
        items.into_iter().map(text).collect()
    }

    fn optional_number(&mut self, key: &str) -> Result<Option<f64>, String> {
        match self.take(key) {
            None => Ok(None),
            Some(Value::Number(number, _)) => Ok(Some(number)),
            Some(other) => Err(self.mistaken(key, &other, "a number")),
        }
    }

    fn number(&mut self, key: &str) -> Result<f64, String> {
        self.optional_number(key)?.ok_or_else(|| self.wrong(key, "is missing"))
    }

    fn count(&mut self, key: &str) -> Result<Option<u64>, String> {
        match self.optional_number(key)? {
            Some(number) if number < 0.0 || number.fract() != 0.0 || number > 1e9 => {
                Err(self.wrong(key, &format!("is {number}; it must be a whole number")))
            }
            number => Ok(number.map(|number| number as u64)),
        }
    }

    fn flag(&mut self, key: &str) -> Result<bool, String> {
        match self.take(key) {
            None => Ok(false),
            Some(Value::Flag(flag)) => Ok(flag),
            Some(other) => Err(self.mistaken(key, &other, "true or false")),
        }
    }

    fn optional_table(&mut self, key: &str) -> Result<Option<Vec<Entry>>, String> {
        match self.take(key) {
            None => Ok(None),
            Some(Value::Table(entries)) => Ok(Some(entries)),
            Some(other) => Err(self.mistaken(key, &other, "a table, as in { of = \"X\", actions = 2.5 }")),
        }
    }

    fn end(self) -> Result<(), String> {
        match self.entries.first() {
            None => Ok(()),
            Some((key, _)) => Err(self.wrong(key, "is not known")),
        }
    }
}
