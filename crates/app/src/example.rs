//! `estar example`: decks with their meshes, ready to run.

use crate::console::print;
use crate::failure::Failure;
use clap::Args;
use std::path::{Path, PathBuf};

/// What the command line asks for.
#[derive(Debug, Args)]
pub struct ExampleArguments {
    /// Which one
    #[arg(value_name = "NAME", required_unless_present = "list")]
    name: Option<String>,
    /// Print the names
    #[arg(long)]
    list: bool,
    /// Directory to write to; named after the example unless given
    #[arg(long, value_name = "DIR")]
    output: Option<PathBuf>,
    /// Overwrite files that are there
    #[arg(long)]
    force: bool,
}

/// A deck with its mesh.
struct Example {
    name: &'static str,
    about: &'static str,
    files: &'static [(&'static str, &'static [u8])],
}

macro_rules! files {
    ($name:literal) => {
        &[
            (concat!($name, ".toml"), include_bytes!(concat!("../../../meshes/", $name, "/", $name, ".toml"))),
            (concat!($name, ".msh"), include_bytes!(concat!("../../../meshes/", $name, "/", $name, ".msh"))),
        ]
    };
}

const EXAMPLES: [Example; 4] = [
    Example {
        name: "taylor",
        about: "a copper rod hits a rigid wall at 227 m/s and mushrooms",
        files: files!("taylor"),
    },
    Example { name: "necking", about: "a round bar is pulled until it necks", files: files!("necking") },
    Example { name: "cook", about: "Cook's membrane: bending and shear of a plastic panel", files: files!("cook") },
    Example {
        name: "upset",
        about: "a billet is upset between rough platens: moving rigid walls, a quasi-static process",
        files: files!("upset"),
    },
];

/// Writes an example, or lists them.
///
/// # Errors
/// No such example, files that are there already, or that cannot be written.
pub fn example(arguments: &ExampleArguments) -> Result<(), Failure> {
    let name = match &arguments.name {
        Some(name) if !arguments.list => name,
        _ => {
            let lines: Vec<_> =
                EXAMPLES.iter().map(|example| format!("{:10} {}", example.name, example.about)).collect();
            return print(&lines.join("\n"));
        }
    };
    let Some(example) = EXAMPLES.iter().find(|example| example.name == name) else {
        let names: Vec<&str> = EXAMPLES.iter().map(|example| example.name).collect();
        return Err(Failure::Input(format!(
            "error: there is no example `{name}`\nhelp: the examples are {}",
            names.join(", ")
        )));
    };
    let directory = arguments.output.clone().unwrap_or_else(|| PathBuf::from(example.name));
    write(example, &directory, arguments.force)?;
    let deck = directory.join(example.files[0].0);
    print(&format!("{}: {}\nrun it: estar run {}", directory.display(), example.about, deck.display()))
}

fn write(example: &Example, directory: &Path, force: bool) -> Result<(), Failure> {
    let paths = || example.files.iter().map(|(name, _)| directory.join(name));
    if let Some(path) = paths().find(|path| path.exists()).filter(|_| !force) {
        let message = format!("error: {} is there already\nhelp: overwrite it with --force", path.display());
        return Err(Failure::Input(message));
    }
    std::fs::create_dir_all(directory).map_err(Failure::writing(directory))?;
    for ((_, content), path) in example.files.iter().zip(paths()) {
        estar_io::write_atomically(&path, content).map_err(Failure::writing(&path))?;
    }
    Ok(())
}
