//! The layouts of structs as data for bindings to other languages: bindings/layout/layout.json, and layout.txt for people,
//! which `make install` installs. They are what the C compiler makes of the header.
//!
//! `UPDATE_ABI=1 cargo test --test layout` writes them anew.

mod common;

use std::collections::BTreeMap;
use std::fmt::Write;
use std::sync::OnceLock;

use common::{Link, build, header, root, run, scratch, structs};
use serde::{Deserialize, Serialize};

/// The version of the document's form.
const FORMAT: u32 = 1;

#[derive(Debug, PartialEq, Serialize, Deserialize)]
struct Layout {
    format: u32,
    library: String,
    version: String,
    abi: i64,
    pointer_size: usize,
    structs: Vec<StructLayout>,
    enums: Vec<Enum>,
    constants: Vec<Constant>,
    /// Types that are known by pointers to them alone.
    handles: Vec<String>,
}

#[derive(Debug, PartialEq, Serialize, Deserialize)]
struct StructLayout {
    name: String,
    size: usize,
    alignment: usize,
    /// It begins with `struct_size`, which its caller sets, and may grow at its end.
    sized: bool,
    fields: Vec<Field>,
}

#[derive(Debug, PartialEq, Serialize, Deserialize)]
struct Field {
    name: String,
    #[serde(rename = "type")]
    kind: String,
    offset: usize,
    size: usize,
}

#[derive(Debug, PartialEq, Serialize, Deserialize)]
struct Enum {
    name: String,
    #[serde(rename = "type")]
    kind: String,
    size: usize,
    values: Vec<Value>,
}

#[derive(Debug, PartialEq, Serialize, Deserialize)]
struct Value {
    name: String,
    value: i64,
}

#[derive(Debug, PartialEq, Serialize, Deserialize)]
struct Constant {
    name: String,
    #[serde(rename = "type")]
    kind: String,
    value: serde_json::Number,
}

/// What the sources say of constants and the header of enumerations: names, and the types that they have.
struct Named {
    enums: Vec<String>,
    /// Name and type, in the header's order.
    constants: Vec<(String, String)>,
    handles: Vec<String>,
}

fn named() -> Named {
    let text = header().text;
    let typed = types_of_constants();
    let enums = text.lines().filter_map(|l| l.strip_prefix("typedef int32_t jostle_")?.strip_suffix(';'));
    let handle = |line: &str| {
        let (first, second) = line.strip_prefix("typedef struct ")?.strip_suffix(';')?.split_once(' ')?;
        (first == second).then(|| first.to_string())
    };
    let constants = text.lines().filter_map(|line| {
        let name = line.strip_prefix("#define ")?.split_whitespace().next()?;
        Some((name.to_string(), typed.get(name)?.clone()))
    });
    Named {
        enums: enums.map(|name| format!("jostle_{name}")).collect(),
        constants: constants.collect(),
        handles: text.lines().filter_map(handle).collect(),
    }
}

/// `pub const NAME: TYPE` of the C API's sources, types as C has them.
fn types_of_constants() -> BTreeMap<String, String> {
    let mut types = BTreeMap::new();
    for entry in std::fs::read_dir(root().join("src/ffi")).expect("the sources") {
        let path = entry.expect("an entry").path();
        if path.extension().is_none_or(|e| e != "rs") {
            continue;
        }
        let text = std::fs::read_to_string(&path).expect("a source");
        let constants = text.lines().filter_map(|l| l.strip_prefix("pub const JOSTLE_")?.split_once(": "));
        for (name, rest) in constants {
            let kind = match rest.split(" =").next().expect("a type") {
                "u32" => "uint32_t",
                "u64" => "uint64_t",
                "i32" => "int32_t",
                "f64" => "double",
                other => other,
            };
            types.insert(format!("JOSTLE_{name}"), kind.to_string());
        }
    }
    types
}

/// A program that prints what the compiler makes of the header, and compiles only where the types are those named.
fn program(named: &Named) -> String {
    let mut text = String::from("#include <jostle/jostle.h>\n#include <stdio.h>\nint main(void)\n{\n");
    for s in structs() {
        let name = &s.name;
        let _ = writeln!(text, "    printf(\"struct {name} %zu %zu\\n\", sizeof({name}), _Alignof({name}));");
        for (field, kind) in s.fields.iter().zip(&s.types) {
            let _ = writeln!(
                text,
                "    _Static_assert(_Generic(&(({name} *)0)->{field}, {kind} *: 1, default: 0), \"{name}.{field}\");\n    \
                 printf(\"field %zu %zu\\n\", offsetof({name}, {field}), sizeof((({name} *)0)->{field}));"
            );
        }
    }
    for name in &named.enums {
        let _ = writeln!(text, "    printf(\"enum %zu\\n\", sizeof({name}));");
    }
    for (name, kind) in &named.constants {
        let _ = match kind.as_str() {
            "double" => writeln!(text, "    printf(\"{name} %.17g\\n\", (double){name});"),
            kind if kind.starts_with('u') => {
                writeln!(text, "    printf(\"{name} %llu\\n\", (unsigned long long){name});")
            }
            _ => writeln!(text, "    printf(\"{name} %lld\\n\", (long long){name});"),
        };
    }
    text.push_str("    printf(\"pointer %zu\\n\", sizeof(void *));\n    return 0;\n}\n");
    text
}

/// The layout by the compiler, worked out once for all tests.
fn compiled() -> &'static Layout {
    static LAYOUT: OnceLock<Layout> = OnceLock::new();
    LAYOUT.get_or_init(compile)
}

fn compile() -> Layout {
    let named = named();
    let source = scratch("layout_data").join("layout_data.c");
    std::fs::write(&source, program(&named)).expect("the source can be written");
    let text = run(&build(&[&source.display().to_string()], "layout_data", Link::Static, &[]));
    let mut lines = text.lines().map(|l| l.split_whitespace().collect::<Vec<_>>());
    let mut next = || lines.next().expect("a line");
    let number = |word: &str| word.parse::<usize>().expect("a number");
    let structs = structs()
        .into_iter()
        .map(|s| {
            let line = next();
            assert_eq!(line[..2], ["struct", s.name.as_str()]);
            let (size, alignment) = (number(line[2]), number(line[3]));
            let sized = s.fields.first().is_some_and(|field| field == "struct_size");
            let fields = s.fields.into_iter().zip(s.types).map(|(name, kind)| {
                let line = next();
                Field { name, kind, offset: number(line[1]), size: number(line[2]) }
            });
            let fields = fields.collect();
            StructLayout { name: s.name, size, alignment, sized, fields }
        })
        .collect();
    let mut enums: Vec<Enum> = (named.enums.iter())
        .map(|name| Enum { name: name.clone(), kind: "int32_t".into(), size: number(next()[1]), values: Vec::new() })
        .collect();
    let mut constants = Vec::new();
    for (name, kind) in named.constants {
        let line = next();
        assert_eq!(line[0], name);
        match enums.iter_mut().find(|e| e.name == kind) {
            Some(one) => one.values.push(Value { name, value: line[1].parse().expect("a value") }),
            None => constants.push(Constant { name, kind, value: line[1].parse().expect("a value") }),
        }
    }
    let pointer_size = number(next()[1]);
    Layout {
        format: FORMAT,
        library: "jostle".into(),
        version: env!("CARGO_PKG_VERSION").into(),
        abi: i64::from(jostle::ffi::version::JOSTLE_ABI_VERSION),
        pointer_size,
        structs,
        enums,
        constants,
        handles: named.handles,
    }
}

/// The same for people.
fn page(layout: &Layout) -> String {
    let mut text = format!(
        "The C API of jostle {}, ABI {}, where pointers have {} bytes. layout.json beside this file has the same for \
         programs.\n\nStructs: offset and size of every field, bytes.\n",
        layout.version, layout.abi, layout.pointer_size
    );
    for s in &layout.structs {
        let grows = if s.sized { ", may grow: struct_size" } else { "" };
        let _ = writeln!(text, "\n{}: size {}, alignment {}{grows}", s.name, s.size, s.alignment);
        for f in &s.fields {
            let gap = if f.kind.ends_with('*') { "" } else { " " };
            let _ = writeln!(text, "{:6} {:4}  {}{gap}{}", f.offset, f.size, f.kind, f.name);
        }
    }
    text.push_str("\nEnumerations: numbers of these types.\n");
    for e in &layout.enums {
        let _ = writeln!(text, "\n{}: {}, size {}", e.name, e.kind, e.size);
        for v in &e.values {
            let _ = writeln!(text, "{:6}  {}", v.value, v.name);
        }
    }
    text.push_str("\nConstants.\n\n");
    for c in &layout.constants {
        let _ = writeln!(text, "{} {} = {}", c.kind, c.name, c.value);
    }
    let _ = writeln!(text, "\nHandles, known by pointers alone: {}.", layout.handles.join(", "));
    text
}

fn compare(name: &str, now: &str) {
    let path = root().join("bindings/layout").join(name);
    if std::env::var_os("UPDATE_ABI").is_some() {
        std::fs::write(&path, now).expect("the file can be written");
    }
    let committed = std::fs::read_to_string(&path).unwrap_or_default();
    let differs = committed.lines().zip(now.lines()).find(|(a, b)| a != b);
    assert!(
        committed == now,
        "{} is out of date (first {differs:?}); run UPDATE_ABI=1 cargo test --test layout",
        path.display()
    );
}

#[test]
fn the_layouts_for_bindings_are_what_the_compiler_makes_of_the_header() {
    let layout = compiled();
    compare("layout.json", &(serde_json::to_string_pretty(layout).expect("JSON") + "\n"));
    compare("layout.txt", &page(layout));
    let text = std::fs::read_to_string(root().join("bindings/layout/layout.json")).expect("the file");
    let read: Layout = serde_json::from_str(&text).expect("the layout");
    assert_eq!(&read, layout, "what was written is read again");
}

/// Nothing of the header is left out: every struct, enumeration, handle and number is there, once.
#[test]
fn the_layouts_for_bindings_hold_all_of_the_header() {
    let layout = compiled();
    let header = header().text;
    let count =
        |begins: &str, ends: &str| header.lines().filter(|l| l.starts_with(begins) && l.ends_with(ends)).count();
    assert_eq!(layout.structs.len(), count("typedef struct ", "{"));
    assert_eq!(layout.handles.len(), count("typedef struct ", ";"));
    assert_eq!(layout.enums.len(), count("typedef int32_t jostle_", ";"));
    let numbers: Vec<&str> = (header.lines())
        .filter(|l| l.starts_with("#define JOSTLE_") && l.split_whitespace().count() == 3)
        .filter_map(|l| l.split_whitespace().nth(1))
        // Those of the version are in the document's head.
        .filter(|name| !name.starts_with("JOSTLE_VERSION"))
        .collect();
    let values = layout.enums.iter().flat_map(|e| e.values.iter().map(|v| v.name.as_str()));
    let mut held: Vec<&str> = values.chain(layout.constants.iter().map(|c| c.name.as_str())).collect();
    held.sort_unstable();
    let mut wanted = numbers.clone();
    wanted.sort_unstable();
    assert_eq!(held, wanted);
    assert!(layout.enums.iter().all(|e| !e.values.is_empty()), "an enumeration without values");
}
