//! Bad input through the C boundary: every function of the header, with every pointer null and every handle dead, and
//! a table of values that cannot be used. Nothing crashes, the status is typed, the message names the parameter, and
//! objects stay as they were.

mod common;

use common::calls::{bad_input, generated_calls};
use common::{Link, header, root, run};

#[test]
fn every_function_refuses_what_it_cannot_use() {
    for link in [Link::Shared, Link::Static] {
        let text = run(&bad_input("bad_input", link, &[]));
        assert!(text.ends_with("bad input: all refused\n"), "{text}");
    }
}

/// The hand-written table has a row for every function that can refuse more than a pointer.
#[test]
fn the_table_covers_every_function() {
    let table = std::fs::read_to_string(root().join("tests/capi/bad_input.c")).expect("the table");
    let generated = generated_calls();
    let missing: Vec<String> = header()
        .functions
        .iter()
        .map(|f| f.name.clone())
        .filter(|name| !table.contains(&format!("{name}(")) && !generated.contains(&format!("BAD({name}(")))
        .collect();
    assert!(missing.is_empty(), "tests/capi/bad_input.c calls none of {missing:?}");
}
