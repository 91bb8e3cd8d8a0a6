//! `estar example`: decks with their meshes, ready to run.

use crate::console::print;
use crate::failure::Failure;
use crate::shipped;
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

/// A deck with its mesh, in the folder `meshes` of the repository under its name.
struct Example {
    name: &'static str,
    about: &'static str,
}

impl Example {
    fn files(&self) -> impl Iterator<Item = (String, &'static [u8])> {
        let file = |ending: &str| {
            let name = format!("{}.{ending}", self.name);
            shipped::file(&format!("meshes/{}/{name}", self.name)).map(|content| (name, content))
        };
        ["toml", "msh"].into_iter().filter_map(file)
    }
}

const EXAMPLES: [Example; 4] = [
    Example { name: "taylor", about: "a copper rod hits a rigid wall at 227 m/s and mushrooms" },
    Example { name: "necking", about: "a round bar is pulled until it necks" },
    Example { name: "cook", about: "Cook's membrane: bending and shear of a plastic panel" },
    Example {
        name: "upset",
        about: "a billet is upset between rough platens: moving rigid walls, a quasi-static process",
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
    let deck = directory.join(format!("{}.toml", example.name));
    print(&format!("{}: {}\nrun it: estar run {}", directory.display(), example.about, deck.display()))
}

fn write(example: &Example, directory: &Path, force: bool) -> Result<(), Failure> {
    let files: Vec<_> = example.files().map(|(name, content)| (directory.join(name), content)).collect();
    if let Some((path, _)) = files.iter().find(|(path, _)| path.exists()).filter(|_| !force) {
        let message = format!("error: {} is there already\nhelp: overwrite it with --force", path.display());
        return Err(Failure::Input(message));
    }
    std::fs::create_dir_all(directory).map_err(Failure::writing(directory))?;
    for (path, content) in files {
        estar_io::write_atomically(&path, content).map_err(Failure::writing(&path))?;
    }
    Ok(())
}
