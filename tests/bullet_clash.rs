//! In a process that links single-precision Bullet our calls could reach that one. Then the engine must refuse to work.
#![cfg(feature = "bullet")]

mod common;

#[test]
fn placeholder() {}
