//! The part of TOML that the list of experiments uses: tables in arrays (`[[row]]`), and keys with texts, numbers,
//! booleans, arrays and inline tables. Enough for one file, and no further dependency.

/// A value of a key.
#[derive(Debug, Clone, PartialEq)]
pub enum Value {
    Text(String),
    /// With its text, as figures are shown as they were published.
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
    let mut reader = Reader { text, at: 0 };
    let mut tables: Vec<Table> = Vec::new();
    loop {
        reader.skip_lines();
        if reader.rest().is_empty() {
            return Ok(tables);
        }
        if reader.take("[[") {
            let name = reader.key()?;
            if !reader.take("]]") {
                return Err(reader.wrong("the name of a table ends with ]]"));
            }
            tables.push(Table { name, line: reader.line(), entries: Vec::new() });
        } else {
            let (key, value) = reader.pair()?;
            let Some(table) = tables.last_mut() else {
                return Err(reader.wrong("a key stands before the first [[table]]"));
            };
            if table.entries.iter().any(|(known, _)| *known == key) {
                return Err(reader.wrong(&format!("`{key}` is given twice")));
            }
            table.entries.push((key, value));
        }
        reader.end_of_line()?;
    }
}

struct Reader<'a> {
    text: &'a str,
    at: usize,
}

impl Reader<'_> {
    fn rest(&self) -> &str {
        &self.text[self.at..]
    }

    fn line(&self) -> usize {
        self.text[..self.at].matches('\n').count() + 1
    }

    fn wrong(&self, what: &str) -> String {
        format!("line {}: {what}", self.line())
    }

    fn take(&mut self, token: &str) -> bool {
        let found = self.rest().starts_with(token);
        if found {
            self.at += token.len();
        }
        found
    }

    fn skip_while(&mut self, skipped: impl Fn(char) -> bool) {
        let rest = self.rest();
        self.at += rest.find(|c| !skipped(c)).unwrap_or(rest.len());
    }

    /// Blanks within a line.
    fn skip_blanks(&mut self) {
        self.skip_while(|c| c == ' ' || c == '\t');
    }

    /// Blanks, ends of lines and comments.
    fn skip_lines(&mut self) {
        loop {
            self.skip_while(char::is_whitespace);
            if !self.rest().starts_with('#') {
                return;
            }
            self.skip_while(|c| c != '\n');
        }
    }

    fn end_of_line(&mut self) -> Result<(), String> {
        self.skip_blanks();
        let rest = self.rest();
        if rest.is_empty() || rest.starts_with(['\n', '\r', '#']) {
            return Ok(());
        }
        Err(self.wrong("something follows at the end of the line"))
    }

    fn key(&mut self) -> Result<String, String> {
        self.skip_blanks();
        let start = self.at;
        self.skip_while(|c| c.is_ascii_alphanumeric() || c == '_' || c == '-');
        let key = self.text[start..self.at].to_string();
        self.skip_blanks();
        if key.is_empty() { Err(self.wrong("a key is missing")) } else { Ok(key) }
    }

    fn pair(&mut self) -> Result<Entry, String> {
        let key = self.key()?;
        if !self.take("=") {
            return Err(self.wrong(&format!("`{key}` is not followed by =")));
        }
        self.skip_blanks();
        let value = self.value().map_err(|error| match error.split_once(": ") {
            Some((line, what)) if line.starts_with("line ") => format!("{line}: {key}: {what}"),
            _ => error,
        })?;
        Ok((key, value))
    }

    fn value(&mut self) -> Result<Value, String> {
        if self.take("\"") {
            return self.string();
        }
        if self.take("[") {
            let mut items = Vec::new();
            loop {
                self.skip_lines();
                if self.take("]") {
                    return Ok(Value::List(items));
                }
                items.push(self.value()?);
                self.skip_lines();
                if !self.take(",") && !self.rest().starts_with(']') {
                    return Err(self.wrong("an array's values have commas between and a ] at the end"));
                }
            }
        }
        if self.take("{") {
            let mut entries: Vec<Entry> = Vec::new();
            loop {
                self.skip_blanks();
                if self.take("}") {
                    return Ok(Value::Table(entries));
                }
                let pair = self.pair()?;
                if entries.iter().any(|(known, _)| *known == pair.0) {
                    return Err(self.wrong(&format!("`{}` is given twice", pair.0)));
                }
                entries.push(pair);
                self.skip_blanks();
                if !self.take(",") && !self.rest().starts_with('}') {
                    return Err(self.wrong("an inline table's keys have commas between and a } at the end"));
                }
            }
        }
        let start = self.at;
        self.skip_while(|c| !c.is_whitespace() && !",]}#".contains(c));
        match &self.text[start..self.at] {
            "true" => Ok(Value::Flag(true)),
            "false" => Ok(Value::Flag(false)),
            word => match word.replace('_', "").parse::<f64>() {
                Ok(number) if number.is_finite() => Ok(Value::Number(number, word.to_string())),
                _ => Err(self.wrong(&format!("`{word}` is no text in quotes, number, true, false, array or table"))),
            },
        }
    }

    /// The rest of a text after its first quote; it ends in the same line.
    fn string(&mut self) -> Result<Value, String> {
        let mut text = String::new();
        let mut escaped = false;
        let mut length = 0;
        for c in self.rest().chars() {
            length += c.len_utf8();
            match c {
                '\n' => break,
                '"' | '\\' if escaped => text.push(c),
                _ if escaped => return Err(self.wrong("only \\\" and \\\\ can follow a backslash")),
                '\\' => {
                    escaped = true;
                    continue;
                }
                '"' => {
                    self.at += length;
                    return Ok(Value::Text(text));
                }
                _ => text.push(c),
            }
            escaped = false;
        }
        Err(self.wrong("a text ends in its line with a quote"))
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
            ("[[row]\n", "line 1: the name of a table ends with ]]"),
            ("[[row]]\na = b\n", "line 2: a: `b` is no text in quotes, number, true, false, array or table"),
            ("[[row]]\na = inf\n", "line 2: a: `inf` is no text in quotes, number, true, false, array or table"),
            ("[[row]]\n\na = \"x\n\"", "line 3: a: a text ends in its line with a quote"),
            ("[[row]]\na = \"\\n\"", "line 2: a: only \\\" and \\\\ can follow a backslash"),
            ("[[row]]\na = 1 b = 2", "line 2: something follows at the end of the line"),
            ("[[row]]\na = 1\na = 2", "line 3: `a` is given twice"),
            ("[[row]]\na 1", "line 2: `a` is not followed by ="),
            ("[[row]]\na = [1 2]", "line 2: a: an array's values have commas between and a ] at the end"),
            ("[[row]]\na = { b = 1", "line 2: a: an inline table's keys have commas between and a } at the end"),
            ("[[row]]\na = { b = 1, b = 2 }", "line 2: a: `b` is given twice"),
            ("[[row]]\n= 2", "line 2: a key is missing"),
        ] {
            assert_eq!(parse(text).unwrap_err(), error, "{text}");
        }
    }
}
