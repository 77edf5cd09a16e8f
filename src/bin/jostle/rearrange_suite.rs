//! The 40 rearrangements that `--suite rearrange` stands for; `suites/rearrange` has them as files.

macro_rules! suite {
    ($($name:literal,)*) => {
        /// Scene files, in the order of their names.
        pub const SUITE: &[&str] = &[$(include_str!(concat!("../../../suites/rearrange/", $name, ".json")),)*];
    };
}

suite! {
    "rearrange-0-00",
    "rearrange-0-01",
    "rearrange-0-02",
    "rearrange-0-03",
    "rearrange-0-04",
    "rearrange-0-05",
    "rearrange-0-06",
    "rearrange-0-07",
    "rearrange-0-08",
    "rearrange-0-09",
    "rearrange-0-10",
    "rearrange-0-11",
    "rearrange-0-12",
    "rearrange-0-13",
    "rearrange-0-14",
    "rearrange-0-15",
    "rearrange-0-16",
    "rearrange-0-17",
    "rearrange-0-18",
    "rearrange-0-19",
    "rearrange-0-20",
    "rearrange-0-21",
    "rearrange-0-22",
    "rearrange-0-23",
    "rearrange-0-24",
    "rearrange-0-25",
    "rearrange-0-26",
    "rearrange-0-27",
    "rearrange-0-28",
    "rearrange-0-29",
    "rearrange-0-30",
    "rearrange-0-31",
    "rearrange-0-32",
    "rearrange-0-33",
    "rearrange-0-34",
    "rearrange-0-35",
    "rearrange-0-36",
    "rearrange-0-37",
    "rearrange-0-38",
    "rearrange-0-39",
}
