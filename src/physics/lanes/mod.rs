//! What engines share that run several pushes side by side: eight lanes of numbers on any instruction set ([`simd`]),
//! groups of one to sixteen lanes ([`group`]), and the schedule that keeps every lane busy ([`schedule`]).

pub mod group;
pub mod schedule;
pub mod simd;
#[cfg(target_arch = "x86_64")]
mod x86;

pub use group::{Group, One, Twice};
pub use schedule::{LaneWork, run};
pub use simd::{InstructionSet, LANES, Numbers, Simd8};
