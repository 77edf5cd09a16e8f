//! Free-running lanes: a lane that has finished its job takes the next one while the others go on.

use crate::run::Stop;

/// Greatest number of lanes.
pub const MOST_LANES: usize = 32;

/// Slices between two looks at the stop: some tens of microseconds of work.
const POLL_EVERY: usize = 4;

/// What an engine does in a lane. A job consists of slices (time steps, say): its own part of each is done lane by lane
/// in [`LaneWork::begin`] and [`LaneWork::advance`], the part that all lanes share in [`LaneWork::sweep`].
pub trait LaneWork {
    /// How many lanes there are, at most [`MOST_LANES`].
    const LANES: usize;

    /// Loads a job into a lane that has none and prepares its first slice. False if the job is done already.
    fn begin(&mut self, lane: usize, job: usize) -> bool;

    /// Works on the slices of all lanes at once until at least one is finished, or for some tens of microseconds. The finished
    /// lanes, one bit each.
    fn sweep(&mut self) -> u32;

    /// Ends the lane's slice and prepares its next. False if the job is done; its results are written then.
    fn advance(&mut self, lane: usize) -> bool;

    /// The lane has no job any more.
    fn idle(&mut self, lane: usize);

    /// The job, begun or not, will not be finished.
    fn interrupt(&mut self, job: usize);
}

/// Runs jobs `0..jobs`, each in the next lane that is free. Which lane a job gets, and with whom, must not show in its
/// result. A requested stop interrupts whatever is not finished.
pub fn run<W: LaneWork>(work: &mut W, jobs: usize, stop: &Stop) {
    let mut held = [None; MOST_LANES];
    let mut next = 0;
    let mut busy = 0u32;
    let mut stopped = stop.requested();
    let mut slices = 0;
    if !stopped {
        for (lane, held) in held.iter_mut().enumerate().take(W::LANES) {
            *held = load(work, lane, &mut next, jobs, stop, &mut stopped);
            busy |= u32::from(held.is_some()) << lane;
        }
    }
    while busy != 0 && !stopped {
        let mut finished = work.sweep() & busy;
        if finished == 0 && stop.requested() {
            stopped = true;
        }
        while finished != 0 {
            let lane = finished.trailing_zeros() as usize;
            finished &= finished - 1;
            slices += 1;
            if slices % POLL_EVERY == 0 && stop.requested() {
                stopped = true;
                break;
            }
            let goes_on = work.advance(lane);
            // A slice that takes long is broken off by itself, and its result is none.
            if !goes_on && stop.requested() {
                stopped = true;
                break;
            }
            if !goes_on {
                held[lane] = load(work, lane, &mut next, jobs, stop, &mut stopped);
                if held[lane].is_none() {
                    busy &= !(1 << lane);
                }
            }
        }
    }
    if stopped {
        for (lane, job) in held.into_iter().enumerate() {
            if let Some(job) = job {
                work.interrupt(job);
                work.idle(lane);
            }
        }
        (next..jobs).for_each(|job| work.interrupt(job));
    }
}

/// The next job that is not done as soon as it is loaded, and none once the stop was requested.
fn load(
    work: &mut impl LaneWork,
    lane: usize,
    next: &mut usize,
    jobs: usize,
    stop: &Stop,
    stopped: &mut bool,
) -> Option<usize> {
    while *next < jobs {
        if *stopped || stop.requested() {
            *stopped = true;
            break;
        }
        let job = *next;
        *next += 1;
        let begun = work.begin(lane, job);
        if stop.requested() {
            *stopped = true;
            work.interrupt(job);
            break;
        }
        if begun {
            return Some(job);
        }
    }
    work.idle(lane);
    None
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::run::{Budget, CancelToken};

    const LANES: usize = 8;

    /// Job `j` takes `j % 5` slices, or none.
    #[derive(Default)]
    struct Counting {
        left: [usize; LANES],
        job: [usize; LANES],
        done: Vec<usize>,
        interrupted: Vec<usize>,
        sweeps: usize,
    }

    impl LaneWork for Counting {
        const LANES: usize = LANES;

        fn begin(&mut self, lane: usize, job: usize) -> bool {
            self.left[lane] = job % 5;
            self.job[lane] = job;
            if self.left[lane] == 0 {
                self.done.push(job);
            }
            self.left[lane] > 0
        }
        fn sweep(&mut self) -> u32 {
            self.sweeps += 1;
            u32::MAX
        }
        fn advance(&mut self, lane: usize) -> bool {
            self.left[lane] -= 1;
            if self.left[lane] == 0 {
                self.done.push(self.job[lane]);
            }
            self.left[lane] > 0
        }
        fn idle(&mut self, _: usize) {}
        fn interrupt(&mut self, job: usize) {
            self.interrupted.push(job);
        }
    }

    #[test]
    fn every_job_is_done_once_and_no_lane_waits_for_another() {
        for jobs in [0, 1, 7, 8, 9, 100] {
            let mut work = Counting::default();
            run(&mut work, jobs, &Stop::never());
            work.done.sort_unstable();
            assert_eq!(work.done, (0..jobs).collect::<Vec<_>>());
            assert!(work.interrupted.is_empty());
            if jobs == 100 {
                // 200 slices on eight lanes.
                assert!(work.sweeps <= 200 / LANES + 4, "{}", work.sweeps);
            }
        }
    }

    /// Its slices take for ever.
    #[derive(Default)]
    struct Endless {
        sweeps: u64,
        interrupted: Vec<usize>,
    }

    impl LaneWork for Endless {
        const LANES: usize = LANES;

        fn begin(&mut self, _: usize, _: usize) -> bool {
            true
        }
        fn sweep(&mut self) -> u32 {
            self.sweeps += 1;
            0
        }
        fn advance(&mut self, _: usize) -> bool {
            true
        }
        fn idle(&mut self, _: usize) {}
        fn interrupt(&mut self, job: usize) {
            self.interrupted.push(job);
        }
    }

    #[test]
    fn a_slice_that_does_not_end_is_interrupted_too() {
        for (jobs, looks) in [(1, 3), (5, 40), (20, 100), (20, 1)] {
            let mut work = Endless::default();
            run(&mut work, jobs, &Budget::default().start(&[CancelToken::after_looks(looks)]));
            work.interrupted.sort_unstable();
            assert_eq!(work.interrupted, (0..jobs).collect::<Vec<_>>(), "{looks} looks");
            assert!(work.sweeps <= looks, "{} sweeps, {looks} looks", work.sweeps);
        }
    }

    #[test]
    fn a_stop_leaves_every_job_either_done_or_interrupted() {
        let stop = Stop::never();
        stop.interrupt();
        let mut work = Counting::default();
        run(&mut work, 20, &stop);
        assert_eq!((work.done.len(), work.interrupted), (0, (0..20).collect()));
    }
}
