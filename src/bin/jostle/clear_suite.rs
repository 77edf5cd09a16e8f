//! The tables that `--suite clear-random` and `--suite clear-packed` stand for; `suites` has them as files.

macro_rules! suite {
    ($doc:literal, $suite:ident, $folder:literal, $($name:literal,)*) => {
        #[doc = $doc]
        pub const $suite: &[&str] =
            &[$(include_str!(concat!("../../../suites/", $folder, "/", $name, ".json")),)*];
    };
}

suite! {
    "Random clutter, in the order of the files' names.",
    RANDOM,
    "clear-random",
    "clear-random-0-00",
    "clear-random-0-01",
    "clear-random-0-02",
    "clear-random-0-03",
    "clear-random-0-04",
    "clear-random-0-05",
    "clear-random-0-06",
    "clear-random-0-07",
    "clear-random-0-08",
    "clear-random-0-09",
    "clear-random-0-10",
    "clear-random-0-11",
    "clear-random-0-12",
    "clear-random-0-13",
    "clear-random-0-14",
    "clear-random-0-15",
    "clear-random-0-16",
    "clear-random-0-17",
    "clear-random-0-18",
    "clear-random-0-19",
    "clear-random-0-20",
    "clear-random-0-21",
    "clear-random-0-22",
    "clear-random-0-23",
    "clear-random-0-24",
    "clear-random-0-25",
    "clear-random-0-26",
    "clear-random-0-27",
    "clear-random-0-28",
    "clear-random-0-29",
}

suite! {
    "Tight packs, in the order of the files' names.",
    PACKED,
    "clear-packed",
    "clear-packed-0-00",
    "clear-packed-0-01",
    "clear-packed-0-02",
    "clear-packed-0-03",
    "clear-packed-0-04",
    "clear-packed-0-05",
    "clear-packed-0-06",
    "clear-packed-0-07",
    "clear-packed-0-08",
    "clear-packed-0-09",
}
