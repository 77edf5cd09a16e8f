//! A list of experiments as tables of keys, read by the crate `toml`. Lines are kept for messages, and numbers with their text:
//! figures are shown with the decimals that were published.

use toml::Spanned;
use toml::de::{DeTable, DeValue};

/// A value of a key.
#[derive(Debug, Clone, PartialEq)]
pub enum Value {
    Text(String),
    /// With its text.
    Number(f64, String),
    Flag(bool),
    List(Vec<Value>),
    Table(Vec<Entry>),
}

impl Value {
    /// What it is, for messages.
    pub fn kind(&self) -> &'static str {
        match self {
            Value::Text(_) => "a text",
            Value::Number(..) => "a number",
            Value::Flag(_) => "true or false",
            Value::List(_) => "an array",
            Value::Table(_) => "a table",
        }
    }
}

/// A key with its value.
pub type Entry = (String, Value);

/// One `[[name]]` and its keys.
#[derive(Debug, Clone, PartialEq)]
pub struct Table {
    pub name: String,
    /// From 1.
    pub line: usize,
    pub entries: Vec<Entry>,
}

/// The tables of a text in their order.
///
/// # Errors
/// One line that names the line of the text.
pub fn parse(text: &str) -> Result<Vec<Table>, String> {
    let reader = Reader { text };
    let (document, errors) = DeTable::parse_recoverable(text);
    let place = |e: &toml::de::Error| e.span().map_or(0, |span| span.start);
    if let Some(first) = errors.iter().min_by_key(|e| place(e)) {
        let line = text.lines().nth(reader.line(place(first)) - 1).unwrap_or_default();
        return Err(reader.wrong(place(first), &format!("`{}`: {}", line.trim(), first.message().replace('\n', " "))));
    }
    let mut tables: Vec<Table> = Vec::new();
    for (name, value) in document.get_ref() {
        let first = || reader.wrong(name.span().start, "a key stands before the first [[table]]");
        for item in value.get_ref().as_array().ok_or_else(first)? {
            let keys = item.get_ref().as_table().ok_or_else(first)?;
            let line = reader.line(item.span().start);
            tables.push(Table { name: name.get_ref().to_string(), line, entries: reader.entries(keys)? });
        }
    }
    tables.sort_by_key(|table| table.line);
    Ok(tables)
}

struct Reader<'a> {
    text: &'a str,
}

impl Reader<'_> {
    fn line(&self, at: usize) -> usize {
        let before = self.text.as_bytes().get(..at).unwrap_or(self.text.as_bytes());
        before.iter().filter(|&&byte| byte == b'\n').count() + 1
    }

    fn wrong(&self, at: usize, what: &str) -> String {
        format!("line {}: {what}", self.line(at))
    }

    /// In the order of the text.
    fn entries(&self, table: &DeTable<'_>) -> Result<Vec<Entry>, String> {
        let mut keys: Vec<_> = table.iter().collect();
        keys.sort_by_key(|(key, _)| key.span().start);
        keys.into_iter()
            .map(|(key, value)| Ok((key.get_ref().to_string(), self.value(key.get_ref(), value)?)))
            .collect()
    }

    fn value(&self, key: &str, value: &Spanned<DeValue<'_>>) -> Result<Value, String> {
        let number = || {
            let text = self.text.get(value.span()).unwrap_or_default();
            match text.replace('_', "").parse::<f64>() {
                Ok(number) if number.is_finite() => Ok(Value::Number(number, text.to_string())),
                _ => Err(self.wrong(value.span().start, &format!("{key}: `{text}` is no finite decimal number"))),
            }
        };
        match value.get_ref() {
            DeValue::String(text) => Ok(Value::Text(text.to_string())),
            DeValue::Integer(_) | DeValue::Float(_) => number(),
            DeValue::Boolean(flag) => Ok(Value::Flag(*flag)),
            DeValue::Array(items) => {
                Ok(Value::List(items.iter().map(|item| self.value(key, item)).collect::<Result<_, _>>()?))
            }
            DeValue::Table(table) => Ok(Value::Table(self.entries(table)?)),
            DeValue::Datetime(_) => Err(self.wrong(value.span().start, &format!("{key}: is a date"))),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tables_keys_and_every_kind_of_value_are_read() {
        let text = "# a comment\n[[row]]\nid = \"a \\\"b\\\" # no comment\" # one\ntrials = 1_000\nx = -2.5e-1\nlog = true\n\
                    text = [\n  \"one\", # here too\n  \"two\",\n]\npublished = { actions = 2.00, of = \"X\" }\n\n[[plot]]\n";
        let tables = parse(text).unwrap();
        assert_eq!(tables.len(), 2);
        assert_eq!((tables[0].name.as_str(), tables[0].line, tables[1].line), ("row", 2, 13));
        let text = |text: &str| Value::Text(text.into());
        let number = |number, text: &str| Value::Number(number, text.into());
        let expected = [
            ("id", text("a \"b\" # no comment")),
            ("trials", number(1000.0, "1_000")),
            ("x", number(-0.25, "-2.5e-1")),
            ("log", Value::Flag(true)),
            ("text", Value::List(vec![text("one"), text("two")])),
            ("published", Value::Table(vec![("actions".into(), number(2.0, "2.00")), ("of".into(), text("X"))])),
        ];
        assert_eq!(tables[0].entries, expected.map(|(key, value)| (key.to_string(), value)));
    }

    #[test]
    fn what_is_wrong_is_named_with_its_line() {
        for (text, error) in [
            ("a = 1", "line 1: a key stands before the first [[table]]"),
            ("[[row]]\na = inf\n", "line 2: a: `inf` is no finite decimal number"),
            ("[[row]]\na = 2026-01-02\n", "line 2: a: is a date"),
        ] {
            assert_eq!(parse(text).unwrap_err(), error, "{text}");
        }
        // What follows is the crate's.
        for (text, start) in [
            ("[[row]\n", "line 1: `[[row]`: "),
            ("[[row]]\na = b\n", "line 2: `a = b`: "),
            ("[[row]]\n\na = \"x\n\"", "line 3: `a = \"x`: "),
            ("[[row]]\na = 1 b = 2", "line 2: `a = 1 b = 2`: "),
            ("[[row]]\na = 1\na = 2", "line 3: `a = 2`: "),
            ("[[row]]\na 1", "line 2: `a 1`: "),
            ("[[row]]\na = [1 2]", "line 2: `a = [1 2]`: "),
            ("[[row]]\na = { b = 1", "line 2: `a = { b = 1`: "),
            ("[[row]]\na = { b = 1, b = 2 }", "line 2: `a = { b = 1, b = 2 }`: "),
            ("[[row]]\n= 2", "line 2: `= 2`: "),
        ] {
            let error = parse(text).unwrap_err();
            assert!(error.starts_with(start) && error.len() > start.len() && !error.contains('\n'), "{text}: {error}");
        }
    }
}
