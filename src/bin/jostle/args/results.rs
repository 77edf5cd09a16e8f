//! The arguments of `jostle results`.

use std::path::PathBuf;

use clap::Args;

#[derive(Debug, Args)]
pub struct ResultsArgs {
    /// The document
    #[arg(long, short, default_value = "RESULTS.md", value_name = "FILE")]
    pub output: PathBuf,
    /// The list of experiments
    #[arg(long, default_value = "bench/results.toml", value_name = "FILE")]
    pub list: PathBuf,
    /// Measure the rows of these sections only; the others stand in the document as far as they are kept
    #[arg(long, value_delimiter = ',', value_name = "SECTION,...")]
    pub only: Vec<String>,
    /// Trials of each case in every row [default: the list's]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..=1000))]
    pub trials: Option<u64>,
    /// Rows that run side by side [default: one for each core]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..=256))]
    pub jobs: Option<u64>,
    /// Folder in which finished rows are kept; a run goes on where an earlier one with the same tool and suites ended
    #[arg(long, default_value = "out/results", value_name = "FOLDER")]
    pub kept: PathBuf,
    /// Folder of the pictures
    #[arg(long, default_value = "docs/img/results", value_name = "FOLDER")]
    pub plots: PathBuf,
    /// Measure everything anew
    #[arg(long, conflicts_with_all = ["any_build", "document"])]
    pub fresh: bool,
    /// Take kept rows of other builds of the tool too; the document says what build each is of
    #[arg(long)]
    pub any_build: bool,
    /// Measure nothing, and write the document from what is kept, of any build
    #[arg(long, conflicts_with = "dry_run")]
    pub document: bool,
    /// List the rows with what each would take, and do nothing
    #[arg(long)]
    pub dry_run: bool,
}
