//! Holds the source tree to the map in `ARCHITECTURE.md`. Every failure names file, line and rule.
//!
//! The checks read text, not syntax trees: [`Source`] blanks comments and literals, after which a word is a word. What
//! this misses (macros that build paths, names brought in by a glob) a reviewer sees.

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

/// What each top-level module may use. `lib.rs` and the command-line tool may use everything.
const MAY_USE: &[(&str, &[&str])] = &[
    ("error", &[]),
    ("bounds", &["error"]),
    ("files", &["error"]),
    ("host", &["error"]),
    ("run", &["error", "host"]),
    ("search", &["error", "run"]),
    ("geom", &["error", "bounds"]),
    ("scene", &["error", "bounds", "files", "geom", "run"]),
    ("action", &["error", "bounds", "files", "geom", "scene", "run"]),
    ("vision", &["error", "bounds", "files", "geom", "scene", "action", "run"]),
    ("net", &["error", "host", "bounds", "files", "geom", "scene", "action", "vision", "run"]),
    ("physics", &["error", "bounds", "files", "geom", "scene", "action", "net", "run"]),
    ("grasp", &["error", "bounds", "files", "geom", "scene", "action", "vision", "net", "run"]),
    ("motion", &["error", "bounds", "files", "geom", "scene", "run"]),
    (
        "plan",
        &["error", "bounds", "files", "geom", "scene", "action", "net", "physics", "grasp", "motion", "search", "run"],
    ),
    ("record", &["error", "bounds", "files", "geom", "scene", "action", "plan"]),
    (
        "eval",
        &["error", "bounds", "files", "geom", "scene", "action", "physics", "grasp", "motion", "search", "run", "plan"],
    ),
    (
        "datagen",
        &[
            "error", "bounds", "files", "geom", "scene", "action", "vision", "net", "physics", "grasp", "motion",
            "search", "run", "plan", "eval",
        ],
    ),
    (
        "ffi",
        &[
            "error", "host", "bounds", "files", "geom", "scene", "action", "vision", "net", "physics", "grasp",
            "motion", "search", "run", "plan", "eval", "record",
        ],
    ),
];

const MAX_LINES: usize = 700;

#[test]
fn modules_use_only_what_lies_before_them() {
    let mut faults = Vec::new();
    for source in sources() {
        let Some(module) = source.module() else { continue };
        let Some((_, allowed)) = MAY_USE.iter().find(|(name, _)| *name == module) else {
            faults.push(format!(
                "{}:1: `{module}` has no place in the order; add it to MAY_USE and to ARCHITECTURE.md",
                source.name()
            ));
            continue;
        };
        for (line, used) in source.modules_used() {
            if used != module && !allowed.contains(&used.as_str()) {
                let may = if allowed.is_empty() { "nothing".into() } else { allowed.join(", ") };
                faults.push(format!("{}:{line}: `{module}` uses `{used}`; it may use {may}", source.name()));
            }
        }
    }
    report(&faults);
}

#[test]
fn the_map_names_every_module() {
    let page = read(&root().join("ARCHITECTURE.md"));
    let modules: BTreeSet<_> = sources().iter().filter_map(|s| s.module().map(str::to_owned)).collect();
    let missing: Vec<_> = modules
        .iter()
        .filter(|m| {
            !page.lines().any(|l| l.trim_start().starts_with(&format!("{m}/")) || l.contains(&format!("{m}.rs")))
        })
        .map(|m| format!("ARCHITECTURE.md: the map has no line for `src/{m}`"))
        .collect();
    report(&missing);
}

#[test]
fn every_test_named_on_the_page_exists() {
    let page = read(&root().join("ARCHITECTURE.md"));
    let mut files = Vec::new();
    walk(&root().join("src"), &mut files);
    walk(&root().join("tests"), &mut files);
    let code: String = files.iter().map(|f| read(f)).collect();
    let mut faults = Vec::new();
    for (number, line) in page.lines().enumerate().filter(|(_, line)| line.starts_with('|')) {
        // The last cell of a row of the invariants is a test, or a script.
        let Some(name) = line.trim_end_matches([' ', '|']).rsplit('|').next().map(|cell| cell.trim()) else { continue };
        let Some(name) = name.strip_prefix('`').and_then(|n| n.strip_suffix('`')) else { continue };
        let exists =
            if name.contains('/') { root().join(name).exists() } else { code.contains(&format!("fn {name}(")) };
        if !exists {
            faults.push(format!("ARCHITECTURE.md:{}: there is no test `{name}`", number + 1));
        }
    }
    report(&faults);
}

#[test]
fn unsafe_code_is_where_the_library_meets_others_only() {
    // `host` reads registers and loads libraries: neither can be said in safe Rust.
    let outside =
        |s: &Source| !matches!(s.module(), Some("ffi" | "host")) && !s.path.ends_with("src/physics/bullet/native.rs");
    let rule = "`unsafe` belongs in src/ffi, src/host and src/physics/bullet/native.rs only";
    report(&words(&["unsafe"], outside, true, rule));
}

#[test]
fn the_library_neither_prints_nor_ends_the_process() {
    let banned =
        ["println!", "eprintln!", "print!", "eprint!", "dbg!", "panic!", "todo!", "unimplemented!", "process::exit"];
    report(&words(&banned, |s| !s.is_tool(), false, "the library returns errors; it does not print, panic or exit"));
}

#[test]
fn time_is_read_in_budget_only() {
    let outside = |s: &Source| !s.is_tool() && !s.path.ends_with("src/run/budget.rs");
    report(&words(&["Instant::now", "SystemTime"], outside, false, "only src/run/budget.rs reads a clock"));
}

#[test]
fn files_are_short() {
    let long: Vec<_> = sources()
        .iter()
        .filter(|s| s.lines > MAX_LINES)
        .map(|s| format!("{}:{}: {} lines; split it, {MAX_LINES} are enough", s.name(), s.lines, s.lines))
        .collect();
    report(&long);
}

/// A file of `src/`, with comments and literals blanked. Line numbers are those of the file.
struct Source {
    /// Relative to the repository.
    path: PathBuf,
    lines: usize,
    /// All code.
    code: String,
    /// The code without its `#[cfg(test)]` items; empty if the whole file is one.
    shipped: String,
}

impl Source {
    fn name(&self) -> String {
        self.path.display().to_string()
    }

    fn is_tool(&self) -> bool {
        self.path.starts_with("src/bin")
    }

    /// The top-level module the file belongs to; `None` for `lib.rs` and the command-line tool.
    fn module(&self) -> Option<&str> {
        let part = self.path.iter().nth(1)?.to_str()?;
        let name = part.strip_suffix(".rs").unwrap_or(part);
        (!self.is_tool() && name != "lib").then_some(name)
    }

    /// The top-level modules that paths in this file name, each with its line.
    fn modules_used(&self) -> Vec<(usize, String)> {
        let mut used = Vec::new();
        for at in find_word(&self.code, "crate::") {
            let line = line_of(&self.code, at);
            let rest = self.code[at + "crate::".len()..].trim_start();
            let names = if rest.starts_with('{') { group(rest) } else { vec![identifier(rest)] };
            for name in names {
                // The root re-exports the error types; every other item is reached through its module.
                let exported = name.starts_with(char::is_uppercase);
                used.push((line, if exported { "error".into() } else { name }));
            }
        }
        // Two steps up from a file of a module is the root, if what follows is a module of the root.
        for at in find_word(&self.code, "super::super::") {
            let name = identifier(&self.code[at + "super::super::".len()..]);
            if MAY_USE.iter().any(|(module, _)| *module == name) {
                used.push((line_of(&self.code, at), name));
            }
        }
        used
    }
}

/// Every file under `src/`.
fn sources() -> Vec<Source> {
    let mut files = Vec::new();
    walk(&root().join("src"), &mut files);
    files.sort();
    let mut test_files = BTreeSet::new();
    let mut sources: Vec<_> = files
        .iter()
        .map(|file| {
            let text = read(file);
            let code = blank_comments_and_literals(&text);
            let (shipped, test_modules) = blank_test_items(&code);
            // `#[cfg(test)] mod name;` makes another file test code.
            let folder = match file.file_stem().and_then(|s| s.to_str()) {
                Some("mod" | "lib" | "main") => file.parent().map(Path::to_path_buf),
                _ => Some(file.with_extension("")),
            };
            for name in test_modules {
                test_files.extend(folder.iter().flat_map(|f| [f.join(format!("{name}.rs")), f.join(name.clone())]));
            }
            let path = file.strip_prefix(root()).expect("a file of the repository").to_path_buf();
            Source { path, lines: text.lines().count(), code, shipped }
        })
        .collect();
    for source in &mut sources {
        let file = root().join(&source.path);
        // By convention `x_tests.rs` holds the tests of `x.rs`.
        let by_name = file.file_stem().and_then(|s| s.to_str()).is_some_and(|s| s == "tests" || s.ends_with("_tests"));
        if by_name || test_files.iter().any(|t| file.starts_with(t)) {
            source.shipped.clear();
        }
    }
    assert!(sources.len() > 10, "src/ was not found");
    sources
}

/// Where `banned` words occur in the files that `applies` picks.
fn words(banned: &[&str], applies: impl Fn(&Source) -> bool, with_tests: bool, rule: &str) -> Vec<String> {
    let mut faults = Vec::new();
    for source in sources().iter().filter(|s| applies(s)) {
        let text = if with_tests { &source.code } else { &source.shipped };
        for word in banned {
            for at in find_word(text, word) {
                faults.push(format!("{}:{}: `{word}`: {rule}", source.name(), line_of(text, at)));
            }
        }
    }
    faults
}

/// Offsets of `word` where it is not a part of a longer identifier.
fn find_word(text: &str, word: &str) -> Vec<usize> {
    let part = |c: char| c.is_alphanumeric() || c == '_';
    let open_end = word.ends_with(part);
    text.match_indices(word)
        .map(|(at, _)| at)
        .filter(|&at| !text[..at].ends_with(part))
        .filter(|&at| !open_end || !text[at + word.len()..].starts_with(part))
        .collect()
}

fn line_of(text: &str, at: usize) -> usize {
    text[..at].matches('\n').count() + 1
}

fn identifier(text: &str) -> String {
    text.chars().take_while(|c| c.is_alphanumeric() || *c == '_').collect()
}

/// The first names of the outermost entries of `{a::b, c::{d, e}}`.
fn group(text: &str) -> Vec<String> {
    let mut names = Vec::new();
    let mut depth = 0;
    let mut entry = String::new();
    for c in text.chars() {
        match c {
            '{' => depth += 1,
            '}' => depth -= 1,
            ',' if depth == 1 => names.push(std::mem::take(&mut entry)),
            _ if depth == 1 => entry.push(c),
            _ => {}
        }
        if depth == 0 {
            break;
        }
    }
    names.push(entry);
    names.iter().map(|n| identifier(n.trim())).filter(|n| !n.is_empty()).collect()
}

/// Replaces comments, strings and characters by blanks and keeps the lines.
fn blank_comments_and_literals(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    let mut rest = text;
    while let Some(c) = rest.chars().next() {
        let after_identifier = out.ends_with(|c: char| c.is_alphanumeric() || c == '_');
        let length = if rest.starts_with("//") {
            rest.find('\n').unwrap_or(rest.len())
        } else if rest.starts_with("/*") {
            block_comment(rest)
        } else if c == '"' {
            string(rest)
        } else if c == 'r' && !after_identifier {
            raw_string(rest)
        } else if c == '\'' {
            character(rest)
        } else {
            0
        };
        let (blanked, kept) = rest.split_at(length);
        out.extend(blanked.chars().map(|c| if c == '\n' { '\n' } else { ' ' }));
        rest = kept;
        if length == 0 {
            out.push(c);
            rest = &rest[c.len_utf8()..];
        }
    }
    out
}

/// Bytes of the block comment, with those nested in it, that `text` begins with.
fn block_comment(text: &str) -> usize {
    let (mut depth, mut at) = (0, 0);
    while at < text.len() {
        let step = &text.as_bytes()[at..];
        if step.starts_with(b"/*") {
            depth += 1;
            at += 2;
        } else if step.starts_with(b"*/") {
            depth -= 1;
            at += 2;
            if depth == 0 {
                return at;
            }
        } else {
            at += 1;
        }
    }
    text.len()
}

/// Bytes of the string that `text` begins with.
fn string(text: &str) -> usize {
    let mut escaped = false;
    for (at, c) in text.char_indices().skip(1) {
        match c {
            _ if escaped => escaped = false,
            '\\' => escaped = true,
            '"' => return at + 1,
            _ => {}
        }
    }
    text.len()
}

/// Bytes of the raw string that `text` begins with; 0 if it is something else.
fn raw_string(text: &str) -> usize {
    let hashes = text[1..].chars().take_while(|c| *c == '#').count();
    if !text[1 + hashes..].starts_with('"') {
        return 0;
    }
    let end = format!("\"{}", "#".repeat(hashes));
    let body = 2 + hashes;
    text[body..].find(&end).map_or(text.len(), |at| body + at + end.len())
}

/// Bytes of the character that `text` begins with; 0 if it is a lifetime.
fn character(text: &str) -> usize {
    let mut chars = text.char_indices().skip(1);
    match chars.next() {
        Some((_, '\\')) => text[3..].find('\'').map_or(text.len(), |at| 3 + at + 1),
        Some(_) => match chars.next() {
            Some((at, '\'')) => at + 1,
            _ => 0,
        },
        None => 0,
    }
}

/// Blanks every item under `#[cfg(test)]`; also gives the names of such modules that lie in files of their own.
fn blank_test_items(code: &str) -> (String, Vec<String>) {
    let mut out = code.to_owned();
    let mut modules = Vec::new();
    let starts = ["#[cfg(test)]", "#[cfg(all(test"];
    for at in starts.iter().flat_map(|s| code.match_indices(s).map(|(at, _)| at)) {
        let (mut depth, mut end) = (0_i32, code.len());
        for (i, c) in code[at..].char_indices() {
            match c {
                '{' | '(' | '[' => depth += 1,
                '}' | ')' | ']' => depth -= 1,
                _ => {}
            }
            if depth == 0 && (c == ';' || c == '}') {
                end = at + i + 1;
                break;
            }
        }
        let item = &code[at..end];
        if let (Some(name), true) = (item.find("mod ").map(|m| identifier(&item[m + 4..])), item.ends_with(';')) {
            modules.push(name);
        }
        let blank: String = item.chars().map(|c| if c == '\n' { '\n' } else { ' ' }).collect();
        // Blanks take a byte, other characters may take more; then the lines still fit but the offsets would not.
        assert_eq!(blank.len(), item.len(), "identifiers are plain ASCII");
        out.replace_range(at..end, &blank);
    }
    (out, modules)
}

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

fn read(path: &Path) -> String {
    fs::read_to_string(path).unwrap_or_else(|e| panic!("{}: {e}", path.display()))
}

fn walk(folder: &Path, files: &mut Vec<PathBuf>) {
    for entry in fs::read_dir(folder).unwrap_or_else(|e| panic!("{}: {e}", folder.display())) {
        let path = entry.expect("a readable folder").path();
        if path.is_dir() {
            walk(&path, files);
        } else if path.extension().is_some_and(|e| e == "rs") {
            files.push(path);
        }
    }
}

fn report(faults: &[String]) {
    assert!(faults.is_empty(), "\n{}\n", faults.join("\n"));
}

/// The checks themselves, on text that breaks each rule.
#[test]
fn the_checks_see_what_they_should() {
    let text = "use crate::{geom::Pose2,\n    scene::{State, Mask}, Error};\n// crate::ffi::x\nlet s = \"crate::eval\"; let c = '\"';\nfn f<'a>(x: &'a str) { crate::plan::go() }\n";
    let code = blank_comments_and_literals(text);
    assert_eq!(code.lines().count(), text.lines().count());
    let source = Source { path: "src/action/x.rs".into(), lines: 5, shipped: String::new(), code };
    let used: Vec<_> = source.modules_used();
    let expected = [(1, "geom"), (1, "scene"), (1, "error"), (5, "plan")];
    assert_eq!(used, expected.map(|(line, name)| (line, name.to_owned())));

    let code = "fn a() { panic!() }\n#[cfg(test)]\nmod tests {\n  fn b() { panic!() }\n}\n#[cfg(test)]\nmod toy;\nfn c() { panic!() }\n";
    let (shipped, modules) = blank_test_items(code);
    assert_eq!(modules, ["toy"]);
    let lines: Vec<_> = find_word(&shipped, "panic!").iter().map(|&at| line_of(&shipped, at)).collect();
    assert_eq!(lines, [1, 8]);

    assert!(find_word("eprintln!() unsafe_code", "println!").is_empty());
    assert!(find_word("unsafe_code an_unsafe", "unsafe").is_empty());
    assert_eq!(
        blank_comments_and_literals("a /* b /* c */ d */ r#\"e\"f\"# g '\\'' h").split_whitespace().collect::<String>(),
        "agh"
    );
}
