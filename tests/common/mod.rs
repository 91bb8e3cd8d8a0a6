//! A workshop in which the program is used as a user does.
#![allow(dead_code, reason = "each test file uses its own part")]

use std::fs;
use std::path::PathBuf;
use std::process::{Child, Command, Output, Stdio};
use std::time::Duration;
use tempfile::TempDir;

/// A directory with a box mesh of 2 × 2 × 2 hexes, 1 m long, and decks.
pub struct Workshop {
    pub directory: TempDir,
}

/// A box that flies.
pub const DECK: &str = r#"
title = "A box flies"

[mesh]
file = "box.msh"

[material.rubber]
theory = "elastic"
density = 1000.0
young_modulus = "100 MPa"
poisson_ratio = 0.3

[[part]]
group = "box"
material = "rubber"

[[initial_velocity]]
group = "box"
value = [1.0, 0.0, 0.0]

[time]
end = "20 ms"

[output]
frames = 4
history_steps = 2
"#;

impl Workshop {
    pub fn new() -> Self {
        let workshop = Self { directory: tempfile::tempdir().unwrap() };
        let made = workshop.estar(&["mesh", "box", "--output", "box.msh", "--cells", "2", "2", "2"]);
        assert_eq!(made.code, 0, "{}", made.errors);
        workshop
    }

    pub fn path(&self, name: &str) -> PathBuf {
        self.directory.path().join(name)
    }

    pub fn write(&self, name: &str, text: &str) {
        fs::write(self.path(name), text).unwrap();
    }

    pub fn read(&self, name: &str) -> String {
        fs::read_to_string(self.path(name)).unwrap_or_else(|error| panic!("{name}: {error}"))
    }

    pub fn read_bytes(&self, name: &str) -> Vec<u8> {
        fs::read(self.path(name)).unwrap()
    }

    /// Runs the program in the directory.
    pub fn estar(&self, arguments: &[&str]) -> Said {
        let mut command = Command::new(env!("CARGO_BIN_EXE_estar"));
        command.args(arguments).current_dir(self.directory.path());
        Said::of(&command.output().unwrap())
    }

    /// Starts the program in the directory.
    pub fn start(&self, arguments: &[&str]) -> Child {
        let mut command = Command::new(env!("CARGO_BIN_EXE_estar"));
        command.args(arguments).current_dir(self.directory.path()).stdout(Stdio::null()).stderr(Stdio::piped());
        command.spawn().unwrap()
    }

    /// Waits until a file has a whole line.
    pub fn wait_for(&self, name: &str) {
        for _ in 0..1000 {
            if fs::read_to_string(self.path(name)).is_ok_and(|text| text.contains('\n')) {
                return;
            }
            std::thread::sleep(Duration::from_millis(10));
        }
        panic!("{name} has no line");
    }

    /// Runs the deck with an addition.
    pub fn run(&self, addition: &str, arguments: &[&str]) -> Said {
        self.run_deck(&format!("{DECK}{addition}"), arguments)
    }

    pub fn run_deck(&self, deck: &str, arguments: &[&str]) -> Said {
        self.write("deck.toml", deck);
        self.estar(&[&["run", "deck.toml", "--force"], arguments].concat())
    }

    pub fn summary(&self) -> serde_json::Value {
        serde_json::from_str(&self.read("deck/summary.json")).unwrap()
    }
}

/// What the program said.
pub struct Said {
    pub code: i32,
    pub text: String,
    pub errors: String,
}

impl Said {
    pub fn of(output: &Output) -> Self {
        Self {
            code: output.status.code().unwrap_or(-1),
            text: String::from_utf8_lossy(&output.stdout).into_owned(),
            errors: String::from_utf8_lossy(&output.stderr).into_owned(),
        }
    }

    /// Asserts the exit status and parts of the error messages.
    #[track_caller]
    pub fn assert(&self, code: i32, parts: &[&str]) {
        assert_eq!(self.code, code, "{}\n{}", self.text, self.errors);
        for part in parts {
            assert!(self.errors.contains(part), "no {part:?} in\n{}", self.errors);
        }
        assert!(!self.errors.contains("panicked"), "{}", self.errors);
    }
}
