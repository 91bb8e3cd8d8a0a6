//! The command line.

use crate::bench::{BenchOptions, bench};
use crate::check::{CheckOptions, check};
use crate::console::{print, print_json, tell, tell_failure};
use crate::example::{self, ExampleArguments};
use crate::failure::Failure;
use crate::mesh_command::{ConvertArguments, MeshCommand, convert, mesh};
use crate::plot_command::{self, PlotArguments};
use crate::point::{PointOptions, point};
use crate::run::{RunOptions, run};
use crate::signals::survive_file_size_limit;
use crate::verify::{self, VerifyArguments};
use crate::view::{self, ViewArguments};
use clap::{Args, CommandFactory, Parser, Subcommand};
use clap_complete::Shell;
use estar_deck::json_schema;
use estar_solver::LaneLevel;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// Explicit finite elements for solids that deform a lot and yield.
#[derive(Debug, Parser)]
#[command(version, after_help = AFTER_HELP)]
struct Cli {
    #[command(subcommand)]
    command: Command,
}

const AFTER_HELP: &str = "\
Read on: `estar example --list` has ready decks; `estar COMMAND --help` and `estar man | man -l -` tell every option; \
docs/README.md beside the source is the book: tutorials, the keys of a deck (docs/deck.md), what to do about a message \
(docs/troubleshooting.md).

Exit status: 0 done; 2 bad input (deck, mesh, command line); 3 the simulation failed (inverted element, value not \
finite, energy error over the limit); 4 a file could not be read or written; 5 an expectation was not met; 130 stopped \
by Ctrl-C.";

#[derive(Debug, Subcommand)]
enum Command {
    /// Simulate what a deck describes
    Run(RunArguments),
    /// Dry run: every error at once, mesh quality, time step, and what a run would cost
    Check(CheckArguments),
    /// Lead a material along a path, without a mesh: a table and plots
    Point(PointArguments),
    /// Run the cases of verification on this machine, and write a report
    Verify(VerifyArguments),
    /// Curves of a run and a shaded picture of its body, without a display
    Plot(PlotArguments),
    /// A page on this machine that shows a run while it runs, and afterwards
    View(ViewArguments),
    /// Write a ready deck and its mesh
    Example(ExampleArguments),
    /// Make structured meshes, or look into a mesh file
    #[command(subcommand)]
    Mesh(MeshCommand),
    /// Write a mesh for ParaView, with a field for each group
    Convert(ConvertArguments),
    /// Time per element step of every element and material, against the limits of this machine
    Bench(BenchArguments),
    /// Print the completions of a shell, to be put where it looks for them
    Completions {
        /// The shell
        shell: Shell,
    },
    /// Print the manual page, for `man -l -`
    Man,
    /// Print what others wrote of this program, and their licences
    Notices,
}

#[derive(Debug, Args)]
struct RunningArguments {
    /// Replace or add a key of the deck, its value written as there: --set time.end='"1 us"'
    #[arg(long = "set", value_name = "KEY=VALUE")]
    overrides: Vec<String>,
    /// Number of threads; all cores unless given
    #[arg(long, value_name = "N", value_parser = thread_count)]
    threads: Option<usize>,
    /// Vector instructions: avx512, avx2 or portable; the best of this machine unless given. The results have the same
    /// bits with each
    #[arg(long, value_name = "LEVEL", value_parser = lane_level)]
    lanes: Option<LaneLevel>,
}

#[derive(Debug, Args)]
struct RunArguments {
    /// The deck (TOML)
    #[arg(value_name = "DECK")]
    deck: PathBuf,
    #[command(flatten)]
    running: RunningArguments,
    /// Directory of the results; beside the deck and named after it unless given
    #[arg(long, value_name = "DIR")]
    output: Option<PathBuf>,
    /// Print nothing but errors
    #[arg(long)]
    quiet: bool,
    /// Overwrite results that are in the directory
    #[arg(long)]
    force: bool,
    /// Go on from the newest checkpoint in the directory that is whole
    #[arg(long, conflicts_with = "force")]
    resume: bool,
    /// Write a checkpoint at this step and stop there
    #[arg(long, value_name = "N")]
    stop_at_step: Option<u64>,
    /// Serve a page on this machine that shows the run while it runs
    #[arg(long)]
    watch: bool,
}

#[derive(Debug, Args)]
struct CheckArguments {
    /// The deck (TOML)
    #[arg(value_name = "DECK", required_unless_present = "schema")]
    deck: Option<PathBuf>,
    #[command(flatten)]
    running: RunningArguments,
    /// Print JSON
    #[arg(long)]
    json: bool,
    /// Print the JSON Schema of decks, with which editors complete and check them
    #[arg(long, exclusive = true)]
    schema: bool,
}

#[derive(Debug, Args)]
struct PointArguments {
    /// The deck (TOML)
    #[arg(value_name = "DECK", required_unless_present = "schema")]
    deck: Option<PathBuf>,
    /// Replace or add a key of the deck, its value written as there: --set path.steps=100
    #[arg(long = "set", value_name = "KEY=VALUE")]
    overrides: Vec<String>,
    /// Directory of the results; beside the deck and named after it unless given
    #[arg(long, value_name = "DIR")]
    output: Option<PathBuf>,
    /// Print the JSON Schema of such decks, with which editors complete and check them
    #[arg(long, exclusive = true)]
    schema: bool,
}

#[derive(Debug, Args)]
struct BenchArguments {
    /// Number of threads beside one; all cores unless given
    #[arg(long, value_name = "N", value_parser = thread_count)]
    threads: Option<usize>,
    /// Vector instructions: avx512, avx2, portable, or all that this machine has; the best unless given
    #[arg(long, value_name = "LEVEL", value_parser = lane_levels)]
    lanes: Option<LaneLevels>,
    /// Hexes of the mesh, about; 41472 unless given
    #[arg(long, value_name = "N", value_parser = element_count, conflicts_with = "sizes")]
    hexes: Option<usize>,
    /// One element and material on meshes of 1.5 thousand to 2 million hexes (ten minutes, and gigabytes)
    #[arg(long)]
    sizes: bool,
    /// A look in place of a measurement: small meshes and arrays, few repetitions
    #[arg(long)]
    quick: bool,
    /// Print JSON
    #[arg(long)]
    json: bool,
}

/// More threads than this are a slip of the pen.
const MOST_THREADS: usize = 4096;

fn thread_count(text: &str) -> Result<usize, String> {
    match text.parse() {
        Ok(count) if (1..=MOST_THREADS).contains(&count) => Ok(count),
        _ => Err(format!("a whole number from 1 to {MOST_THREADS} is needed")),
    }
}

fn lane_level(text: &str) -> Result<LaneLevel, String> {
    let names = || LaneLevel::ALL.iter().map(|level| level.name());
    let level = LaneLevel::ALL.into_iter().find(|level| level.name() == text);
    level.ok_or_else(|| format!("the choices are {}", names().collect::<Vec<_>>().join(", ")))
}

/// The sets of vector instructions that `estar bench` measures.
#[derive(Clone, Debug)]
struct LaneLevels(Vec<LaneLevel>);

fn lane_levels(text: &str) -> Result<LaneLevels, String> {
    if text == "all" {
        return Ok(LaneLevels(LaneLevel::ALL.into_iter().rev().filter(|level| level.is_available()).collect()));
    }
    let level = lane_level(text).map_err(|error| format!("{error}, all"))?;
    Ok(LaneLevels(vec![level]))
}

/// A bar with more hexes than this is a slip of the pen.
const MOST_HEXES: usize = 10_000_000;

fn element_count(text: &str) -> Result<usize, String> {
    match text.parse() {
        Ok(count) if (1..=MOST_HEXES).contains(&count) => Ok(count),
        _ => Err(format!("a whole number from 1 to {MOST_HEXES} is needed")),
    }
}

/// The program: reads the command line, does what it says, and returns the exit status. The notices are of what others wrote of it.
pub fn main(notices: &str) -> ExitCode {
    survive_file_size_limit();
    let cli = match Cli::try_parse() {
        Ok(cli) => cli,
        Err(error) => return refuse(&error),
    };
    match execute(cli.command, notices) {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => {
            tell_failure(&failure);
            ExitCode::from(failure.exit_code())
        }
    }
}

/// Tells what is wrong with the command line, or the help that it asks for. An argument that would steer the terminal is shown
/// without, and the message then without colours.
fn refuse(error: &clap::Error) -> ExitCode {
    let plain = error.to_string();
    if estar_io::visible(&plain) == plain {
        // nobody is left to tell that this could not be told
        let _ = error.print();
    } else {
        tell(&plain);
    }
    ExitCode::from(u8::try_from(error.exit_code()).unwrap_or(2))
}

fn execute(command: Command, notices: &str) -> Result<(), Failure> {
    match command {
        Command::Run(arguments) => run(&RunOptions {
            deck: arguments.deck,
            overrides: arguments.running.overrides,
            output: arguments.output,
            threads: arguments.running.threads,
            lanes: arguments.running.lanes,
            is_quiet: arguments.quiet,
            force: arguments.force,
            resume: arguments.resume,
            stop_at_step: arguments.stop_at_step,
            watch: arguments.watch,
        }),
        Command::Check(CheckArguments { deck: Some(deck), running, json, .. }) => check(&CheckOptions {
            deck,
            overrides: running.overrides,
            threads: running.threads,
            lanes: running.lanes,
            json,
        }),
        Command::Check(CheckArguments { deck: None, .. }) => print_schema(&json_schema::of_deck()),
        Command::Point(PointArguments { deck: Some(deck), overrides, output, .. }) => {
            point(&PointOptions { deck, overrides, output })
        }
        Command::Point(PointArguments { deck: None, .. }) => print_schema(&json_schema::of_point_deck()),
        Command::Verify(arguments) => verify::verify(&arguments),
        Command::Plot(arguments) => plot_command::plot(&arguments),
        Command::View(arguments) => view::view(&arguments),
        Command::Example(arguments) => example::example(&arguments),
        Command::Mesh(command) => mesh(&command),
        Command::Convert(arguments) => convert(&arguments),
        Command::Completions { shell } => print_completions(shell),
        Command::Man => print_manual(),
        Command::Notices => print(notices),
        Command::Bench(arguments) => bench(&BenchOptions {
            threads: arguments.threads,
            lanes: arguments.lanes.map_or_else(|| vec![LaneLevel::best()], |levels| levels.0),
            hexes: arguments.hexes,
            sizes: arguments.sizes,
            quick: arguments.quick,
            json: arguments.json,
        }),
    }
}

fn print_completions(shell: Shell) -> Result<(), Failure> {
    let mut script = Vec::new();
    clap_complete::generate(shell, &mut Cli::command(), "estar", &mut script);
    print(&String::from_utf8_lossy(&script))
}

/// The page of the program, and those of its commands one after another.
fn print_manual() -> Result<(), Failure> {
    let mut program = Cli::command();
    program.build();
    let mut pages = String::new();
    write_manual(&program, "estar", &mut pages)?;
    print(&pages)
}

/// The page of a command called `name`, then those of its commands.
fn write_manual(command: &clap::Command, name: &str, pages: &mut String) -> Result<(), Failure> {
    let mut page = Vec::new();
    let version = env!("CARGO_PKG_VERSION");
    let titled = command.clone().name(name.to_owned()).version(version);
    let titled = titled.display_name(name.to_owned()).bin_name(name.to_owned());
    clap_mangen::Man::new(titled).render(&mut page).map_err(Failure::writing(Path::new("standard output")))?;
    let mut page = String::from_utf8_lossy(&page).into_owned();
    for inner in command.get_subcommands() {
        // the pages are all in one, and no other page is installed
        let reference = format!("{name}-{}(1)", inner.get_name()).replace('-', "\\-");
        page = page.replace(&reference, &format!("{name} {}", inner.get_name()).replace('-', "\\-"));
    }
    pages.push_str(&page);
    for inner in command.get_subcommands().filter(|inner| inner.get_name() != "help") {
        write_manual(inner, &format!("{name} {}", inner.get_name()), pages)?;
    }
    Ok(())
}

fn print_schema(schema: &serde_json::Value) -> Result<(), Failure> {
    print_json(schema)
}
