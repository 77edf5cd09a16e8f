//! The floating-point state of a thread: rounding, flushing of subnormal numbers, traps.
//!
//! It is the thread's, not the program's, and belongs to the host: a host may trap on invalid operations, round upwards or
//! flush subnormal numbers to zero, and a library that it calls (ONNX Runtime's first session is one) may change all that
//! behind its back. Rust's arithmetic is defined for the default state only. So every entry takes the default and gives
//! the caller's back ([`Standard`]).

use std::marker::PhantomData;

/// Rounding, flushing, masks of traps and the flags of what has occurred; of vector and scalar arithmetic, not of the x87.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct FloatState(u64);

impl FloatState {
    /// This thread's.
    #[inline]
    pub fn current() -> FloatState {
        FloatState(machine::read())
    }

    /// To the nearest, subnormal numbers kept, no traps: what a process begins with.
    pub const DEFAULT: FloatState = FloatState(machine::DEFAULT);

    /// Whether it computes as the default does; what has occurred so far does not matter.
    #[inline]
    pub fn computes_as_default(self) -> bool {
        (self.0 ^ machine::DEFAULT) & machine::CONTROL == 0
    }

    /// Makes it this thread's.
    #[inline]
    pub fn set(self) {
        machine::write(self.0);
    }
}

/// While it lives its thread has the default state; then the one it had before, flags and all.
#[derive(Debug)]
pub struct Standard {
    before: FloatState,
    /// Of one thread.
    _here: PhantomData<*const ()>,
}

impl Standard {
    #[inline]
    pub fn enter() -> Standard {
        let before = FloatState::current();
        FloatState::DEFAULT.set();
        Standard { before, _here: PhantomData }
    }
}

impl Drop for Standard {
    #[inline]
    fn drop(&mut self) {
        self.before.set();
    }
}

/// MXCSR.
#[cfg(target_arch = "x86_64")]
#[allow(unsafe_code)]
mod machine {
    use std::arch::asm;

    /// All traps masked.
    pub const DEFAULT: u64 = 0x1f80;
    /// All but the six flags of what has occurred.
    pub const CONTROL: u64 = 0xffc0;

    #[inline]
    pub fn read() -> u64 {
        let mut state = 0_u32;
        // SAFETY: stores the register at the address of four bytes of ours.
        unsafe { asm!("stmxcsr [{}]", in(reg) &raw mut state, options(nostack, preserves_flags)) };
        u64::from(state)
    }

    #[inline]
    pub fn write(state: u64) {
        let state = state as u32;
        // SAFETY: the value is one that was read or the default, so no reserved bit is set.
        unsafe { asm!("ldmxcsr [{}]", in(reg) &raw const state, options(nostack, preserves_flags)) };
    }
}

/// FPCR in the lower half, FPSR in the upper.
#[cfg(target_arch = "aarch64")]
#[allow(unsafe_code)]
mod machine {
    use std::arch::asm;

    pub const DEFAULT: u64 = 0;
    pub const CONTROL: u64 = 0xffff_ffff;

    #[inline]
    pub fn read() -> u64 {
        let (control, flags): (u64, u64);
        // SAFETY: reads two registers.
        unsafe {
            asm!("mrs {}, fpcr", "mrs {}, fpsr", out(reg) control, out(reg) flags, options(nostack, preserves_flags));
        }
        control & 0xffff_ffff | flags << 32
    }

    #[inline]
    pub fn write(state: u64) {
        let (control, flags) = (state & 0xffff_ffff, state >> 32);
        // SAFETY: the values were read or are the default, so no reserved bit is set.
        unsafe {
            asm!("msr fpcr, {}", "msr fpsr, {}", in(reg) control, in(reg) flags, options(nostack, preserves_flags))
        };
    }
}

/// Elsewhere the state is left as it is (docs/c-api.md says so).
#[cfg(not(any(target_arch = "x86_64", target_arch = "aarch64")))]
mod machine {
    pub const DEFAULT: u64 = 0;
    pub const CONTROL: u64 = 0;

    pub fn read() -> u64 {
        0
    }

    pub fn write(_: u64) {}
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    #[cfg(target_arch = "x86_64")]
    fn a_thread_computes_by_default_within_and_as_before_outside() {
        // Rounding upwards and downwards, flushing to zero, subnormal inputs as zero, and traps on none of what follows.
        for state in [0x5f80, 0x3f80, 0x9f80, 0x1fc0, 0x1f80].map(FloatState) {
            let outside = FloatState::current();
            state.set();
            let third = || std::hint::black_box(1.0_f64) / std::hint::black_box(3.0);
            let half = || std::hint::black_box(f64::MIN_POSITIVE) * std::hint::black_box(0.5);
            let within = {
                let _standard = Standard::enter();
                assert!(FloatState::current().computes_as_default());
                (third(), half())
            };
            let after = FloatState::current();
            outside.set();
            assert_eq!(after, state, "flags and all");
            assert_eq!(within, (1.0 / 3.0, f64::MIN_POSITIVE / 2.0), "{state:?}");
        }
    }
}
