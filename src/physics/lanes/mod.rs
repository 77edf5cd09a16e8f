//! What engines share that run several pushes side by side: eight lanes of numbers on any instruction set ([`simd`]),
//! and the schedule that keeps every lane busy ([`schedule`]).

pub mod schedule;
pub mod simd;

pub use schedule::{LaneWork, run};
pub use simd::{InstructionSet, LANES, Numbers, Simd8, Twice};
