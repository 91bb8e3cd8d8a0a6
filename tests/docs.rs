//! Goal: what the documentation says is so. Of `README.md`, `meshes/README.md` and `docs/*.md`
//! - every line of a block `sh` is run, in order, page by page, in a directory that has the meshes and examples of a checkout;
//!   it ends with status 0, or with the one that its comment tells (`# exit status 2`);
//! - a block `text` that follows such lines, with no heading between, is found line by line in what they printed; `…` stands
//!   for what differs from machine to machine;
//! - a block whose first line names a file of the checkout in a comment is an excerpt of it, word for word;
//! - links lead somewhere, `docs/README.md` has every page, and commands in the text have the options that they are given.
//!
//! Lines that start another program are run where it is there. Which are not run, and which runs are cut short on every commit,
//! is listed here; `cargo test --release --test docs -- --ignored` runs them at full length and checks the figures that they print.

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};
use tempfile::TempDir;

/// Lines that are not run here, by how they begin, and why.
const ELSEWHERE: &[(&str, &str)] = &[
    ("cargo build", "this test has been built"),
    ("cargo doc", "a step of .ci/run"),
    ("cargo install", "writes to the home directory"),
    ("cargo test", "this is one of the tests"),
    ("estar bench", "minutes; tests/command_line.rs runs it on a small mesh"),
    ("estar view", "stays open until it is told to stop"),
    ("estar verify", "tests/verification.rs runs the cases"),
    ("git clone", "needs the network"),
    ("ldd", "is of a build for another target"),
    ("paraview", "a window"),
    ("pip install", "needs the network"),
    ("pvbatch", "needs ParaView"),
    ("rustup", "needs the network"),
    ("source", "is of the shell"),
    ("target/", "is of another build"),
];

/// What is added to runs of these decks on every commit, so that they take a second.
const SHORT_RUNS: &[(&str, &[&str])] = &[
    ("taylor.toml", &["time.end=\"2 us\"", "expect=[]"]),
    ("rod.toml", &["time.end=\"2 us\"", "expect=[]"]),
    ("taylor-wall.toml", &["time.end=\"2 us\"", "expect=[]"]),
    ("necking.toml", &["time.end=\"0.05 ms\"", "expect=[]"]),
    ("tensile.toml", &["time.end=\"0.02 ms\"", "expect=[]"]),
    ("upset.toml", &["time.quasi_static.transits=15", "expect=[]"]),
];

/// Packages of Python, without which the scripts that import them are not run.
const PACKAGES: &[&str] = &["gmsh", "matplotlib", "meshio", "numpy", "paraview", "pyvista", "vtk"];

/// What the lines with `gmsh` write.
const MESHES_OF_GMSH: &[&str] = &["meshes/necking/tensile.msh"];

/// After this a command counts as hanging.
const PATIENCE: Duration = Duration::from_secs(300);

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

fn read(path: &str) -> String {
    fs::read_to_string(root().join(path)).unwrap_or_else(|error| panic!("{path}: {error}"))
}

/// The pages of the book, as paths from the top.
fn pages() -> Vec<String> {
    let names = fs::read_dir(root().join("docs")).unwrap().map(|entry| entry.unwrap().file_name());
    let mut pages: Vec<String> = names
        .map(|name| format!("docs/{}", name.to_string_lossy()))
        .filter(|name| Path::new(name).extension().is_some_and(|extension| extension == "md"))
        .collect();
    pages.sort();
    pages.extend(["README.md", "meshes/README.md"].map(str::to_owned));
    pages
}

/// What a page consists of, as far as it is looked at here.
#[derive(Debug)]
enum Piece {
    Heading(String),
    Prose(String),
    Block { language: String, line: usize, text: String },
}

fn pieces(page: &str) -> Vec<Piece> {
    let mut pieces = Vec::new();
    let mut lines = page.lines().enumerate();
    while let Some((number, line)) = lines.next() {
        if let Some(language) = line.trim_start().strip_prefix("```") {
            let inside = lines.by_ref().map(|(_, line)| line).take_while(|line| !line.trim_start().starts_with("```"));
            let text = inside.map(|line| format!("{line}\n")).collect();
            pieces.push(Piece::Block { language: language.to_owned(), line: number + 1, text });
        } else if line.starts_with('#') {
            pieces.push(Piece::Heading(line.trim_start_matches('#').trim().to_owned()));
        } else {
            pieces.push(Piece::Prose(line.to_owned()));
        }
    }
    pieces
}

/// A line of a shell: its words, and the exit status that its comment tells.
#[derive(Debug, PartialEq)]
struct Line {
    number: usize,
    words: Vec<String>,
    status: i32,
}

impl Line {
    fn text(&self) -> String {
        self.words.join(" ")
    }
}

/// Lines of a block: `\` at the end of one goes on, `#` begins a comment, quotes keep words together.
fn shell_lines(block: &str, first: usize) -> Vec<Line> {
    let mut lines = Vec::new();
    let mut pending = String::new();
    for (number, line) in block.lines().enumerate() {
        if let Some(part) = line.strip_suffix('\\') {
            pending.push_str(part);
            continue;
        }
        let (words, comment) = words(&format!("{}{line}", std::mem::take(&mut pending)));
        if !words.is_empty() {
            let told = comment.split_once("exit status ").map(|(_, told)| told);
            let status = told.map_or(0, |told| {
                let digits: String = told.chars().take_while(char::is_ascii_digit).collect();
                digits.parse().expect("a number after \"exit status\"")
            });
            lines.push(Line { number: first + 1 + number, words, status });
        }
    }
    assert!(pending.is_empty(), "the block ends within a line: {pending}");
    lines
}

/// The words of a line, and its comment.
fn words(line: &str) -> (Vec<String>, String) {
    let mut words: Vec<String> = Vec::new();
    let mut word: Option<String> = None;
    let mut letters = line.chars();
    while let Some(letter) = letters.next() {
        match letter {
            '#' if word.is_none() => return (words, letters.collect()),
            ' ' | '\t' => words.extend(word.take()),
            '\'' | '"' => {
                let quoted = letters.by_ref().take_while(|&inner| inner != letter);
                word.get_or_insert_default().extend(quoted);
            }
            _ => word.get_or_insert_default().push(letter),
        }
    }
    words.extend(word);
    (words, String::new())
}

#[test]
fn lines_of_a_shell_are_read_as_a_shell_reads_them() {
    let lines =
        shell_lines("estar run a.toml \\\n  --set time.end='\"1 us\"'  # short; exit status 3\n\n# nothing\ncd b\n", 9);
    assert_eq!(lines.len(), 2);
    assert_eq!(lines[0].words, ["estar", "run", "a.toml", "--set", "time.end=\"1 us\""]);
    assert_eq!((lines[0].status, lines[1].status), (3, 0));
    assert_eq!((lines[0].number, lines[1].number), (11, 14));
}

/// Where the lines of a page are run.
struct Place {
    directory: TempDir,
    now: PathBuf,
    is_short: bool,
    /// Whether a run was cut short here: what scripts say of it then is not what the page shows.
    has_shortened: bool,
}

/// What became of a line.
enum Outcome {
    Printed(String),
    /// Run, but not as it stands there: what it prints is not what the page shows.
    Shortened,
    NotRun(String),
}

impl Place {
    fn new(is_short: bool) -> Self {
        let directory = tempfile::tempdir().unwrap();
        for folder in ["meshes", "examples", "docs/paraview"] {
            copy(&root().join(folder), &directory.path().join(folder));
        }
        let now = directory.path().to_owned();
        Self { directory, now, is_short, has_shortened: false }
    }

    fn run(&mut self, line: &Line, place: &str) -> Outcome {
        let text = line.text();
        let text = text.strip_prefix("cargo run --release -- ").map_or(text.clone(), |rest| format!("estar {rest}"));
        let mut words = line.words.clone();
        if words.starts_with(&["cargo", "run", "--release", "--"].map(str::to_owned)) {
            words.splice(..4, ["estar".to_owned()]);
        }
        if let Some((_, why)) = ELSEWHERE.iter().find(|(start, _)| text.starts_with(start)) {
            return Outcome::NotRun((*why).to_owned());
        }
        if words[0] == "cd" {
            self.now.push(&words[1]);
            assert!(self.now.is_dir() && self.now.starts_with(self.directory.path()), "{place}: no such directory");
            return Outcome::Printed(String::new());
        }
        let target = words.iter().position(|word| word == ">").map(|at| words.split_off(at)[1].clone());
        let is_short = self.shorten(&mut words, &text, line.status);

        let mut command = match words[0].as_str() {
            "estar" => Command::new(env!("CARGO_BIN_EXE_estar")),
            "python" => {
                let script = self.now.join(&words[1]);
                let missing: Vec<_> = packages(&script).into_iter().filter(|name| !can_import(name)).collect();
                if !missing.is_empty() {
                    return Outcome::NotRun(format!("Python has no {}", missing.join(", ")));
                }
                Command::new("python3")
            }
            "gmsh" => Command::new("gmsh"),
            other => panic!("{place}: no rule says how `{other}` is run here"),
        };
        command.args(&words[1..]).current_dir(&self.now);
        if words[0] == "gmsh" {
            return self.mesh_by_gmsh(command, place);
        }
        let (status, mut printed) = output(command, place);
        assert_eq!(status, line.status, "{place}: {text}\n{printed}");
        assert!(!printed.contains("panicked"), "{place}: {text}\n{printed}");
        if let Some(target) = target {
            fs::write(self.now.join(target), std::mem::take(&mut printed)).unwrap();
        }
        self.has_shortened |= is_short;
        let is_of_short_run = self.has_shortened && words[0] == "python";
        if is_short || is_of_short_run { Outcome::Shortened } else { Outcome::Printed(printed) }
    }

    /// Runs Gmsh where it is there. What follows goes on with the meshes of the checkout: another version makes other ones.
    fn mesh_by_gmsh(&self, command: Command, place: &str) -> Outcome {
        let is_there = Command::new("gmsh").arg("--version").output().is_ok_and(|output| output.status.success());
        if is_there {
            let (status, printed) = output(command, place);
            assert_eq!(status, 0, "{place}: {printed}");
        }
        for mesh in MESHES_OF_GMSH {
            let made = self.directory.path().join(mesh);
            assert!(!is_there || fs::metadata(&made).unwrap().len() > 1000, "{place}: {mesh}");
            fs::copy(root().join(mesh), made).unwrap();
        }
        if is_there { Outcome::Shortened } else { Outcome::NotRun("gmsh is not installed".to_owned()) }
    }

    /// Adds what makes a long run short, but for keys that the page sets; says whether it did. Expectations that are to be
    /// missed (status 5) stay.
    fn shorten(&self, words: &mut Vec<String>, text: &str, status: i32) -> bool {
        let deck = words.get(2).and_then(|word| Path::new(word).file_name()).and_then(|name| name.to_str());
        let short = SHORT_RUNS.iter().find(|(name, _)| deck == Some(name));
        let Some((_, settings)) = short.filter(|_| self.is_short && text.starts_with("estar run")) else {
            return false;
        };
        // so short a run stops early, too
        if let Some(stop) = words.iter().position(|word| word == "--stop-at-step") {
            words[stop + 1] = "20".to_owned();
        }
        for setting in *settings {
            let key = setting.split_once('=').unwrap().0;
            let is_wanted = key == "expect" && status == 5;
            if !is_wanted && !words.iter().any(|word| word.split_once('=').is_some_and(|(set, _)| set == key)) {
                words.extend(["--set".to_owned(), (*setting).to_owned()]);
            }
        }
        true
    }
}

/// Copies what git has of a folder, by the endings of its names: results are none of it.
fn copy(from: &Path, to: &Path) {
    fs::create_dir_all(to).unwrap();
    for entry in fs::read_dir(from).unwrap().map(Result::unwrap) {
        let (path, name) = (entry.path(), entry.file_name());
        if path.is_dir() {
            if !path.join("summary.json").exists() {
                copy(&path, &to.join(name));
            }
        } else if path
            .extension()
            .is_some_and(|end| ["msh", "toml", "geo", "py", "inp"].iter().any(|kept| end == *kept))
        {
            fs::copy(&path, to.join(name)).unwrap();
        }
    }
}

/// The packages that a script of Python imports at its top, and those of the scripts beside and above it that it imports.
fn packages(script: &Path) -> BTreeSet<&'static str> {
    let text = fs::read_to_string(script).unwrap_or_else(|error| panic!("{}: {error}", script.display()));
    let mut found = BTreeSet::new();
    for line in text.lines() {
        let Some(module) = line.strip_prefix("import ").or_else(|| line.strip_prefix("from ")) else { continue };
        let module = module.split([' ', '.', ',']).next().unwrap();
        found.extend(PACKAGES.iter().filter(|package| **package == module));
        for folder in script.ancestors().skip(1).take(2) {
            let imported = folder.join(module).with_extension("py");
            if imported.is_file() {
                found.extend(packages(&imported));
            }
        }
    }
    found
}

fn can_import(package: &str) -> bool {
    let import = format!("import {package}");
    Command::new("python3").args(["-c", &import]).output().is_ok_and(|output| output.status.success())
}

/// Exit status of a command and what it printed; it is ended if it takes too long.
fn output(mut command: Command, place: &str) -> (i32, String) {
    // one file, which both write on at its end
    let printed = tempfile::NamedTempFile::new().unwrap();
    let [out, errors] = [printed.as_file().try_clone().unwrap(), printed.as_file().try_clone().unwrap()];
    let mut child = command
        .stdin(Stdio::null())
        .stdout(out)
        .stderr(errors)
        .spawn()
        .unwrap_or_else(|error| panic!("{place}: {error}"));
    let start = Instant::now();
    let status = loop {
        if let Some(status) = child.try_wait().unwrap() {
            break status;
        }
        if start.elapsed() > PATIENCE {
            child.kill().unwrap();
            panic!("{place}: still running after {PATIENCE:?}");
        }
        std::thread::sleep(Duration::from_millis(5));
    };
    (status.code().unwrap_or(-1), fs::read_to_string(printed.path()).unwrap_or_default())
}

/// Whether a line of a page, in which `…` stands for anything, is in a line of what was printed; any blank is one blank.
fn is_in(expected: &str, printed: &str) -> bool {
    let plain = |text: &str| text.split_whitespace().collect::<Vec<_>>().join(" ");
    let expected = plain(expected);
    printed.lines().map(plain).any(|line| {
        let mut rest = line.as_str();
        expected.split('…').map(str::trim).all(|part| {
            let found = rest.find(part);
            found.is_some_and(|at| {
                rest = &rest[at + part.len()..];
                true
            })
        })
    })
}

/// Runs the lines of all pages. All lines that were not printed are told together, at the end.
fn follow_the_pages(is_short: bool) {
    let mut not_run = BTreeSet::new();
    let mut missing = String::new();
    for page in pages() {
        let mut place = Place::new(is_short);
        // what the lines since the last heading printed, if they were all run as they stand there
        let mut printed = None;
        let start = Instant::now();
        let mut count = 0;
        for piece in pieces(&read(&page)) {
            match piece {
                Piece::Heading(_) => printed = None,
                Piece::Prose(_) => (),
                Piece::Block { language, line, text } if language == "sh" => {
                    let mut all = Some(String::new());
                    for line in shell_lines(&text, line) {
                        let outcome = place.run(&line, &format!("{page}:{}", line.number));
                        all = match (all, outcome) {
                            (Some(all), Outcome::Printed(printed)) => Some(all + &printed),
                            (_, Outcome::NotRun(why)) => {
                                not_run.insert(format!("{page}:{}: {} ({why})", line.number, line.text()));
                                None
                            }
                            _ => None,
                        };
                        count += 1;
                    }
                    printed = all;
                }
                Piece::Block { language, line, text } if language == "text" => {
                    let Some(printed) = &printed else { continue };
                    let expected = text.lines().enumerate().filter(|(_, line)| !["", "…"].contains(&line.trim()));
                    let before = missing.len();
                    for (number, expected) in expected.filter(|(_, expected)| !is_in(expected, printed)) {
                        missing += &format!("{page}:{}: not printed: {expected}\n", line + 1 + number);
                    }
                    if missing.len() > before {
                        missing += &format!("but\n{printed}\n");
                    }
                }
                Piece::Block { line, text, .. } => write_or_compare(&place, &page, line, &text),
            }
        }
        if count > 0 {
            eprintln!("{page}: {count} lines, {:.1} s", start.elapsed().as_secs_f64());
        }
    }
    not_run.iter().for_each(|line| eprintln!("not run: {line}"));
    assert!(missing.is_empty(), "{missing}");
}

/// A block that begins with the name of a file: an excerpt of that of the checkout, or to be written.
fn write_or_compare(place: &Place, page: &str, line: usize, text: &str) {
    let Some((first, rest)) = text.split_once('\n') else { return };
    let Some(name) = first.strip_prefix("# ").or_else(|| first.strip_prefix("// ")) else { return };
    let endings = [".toml", ".geo", ".py"];
    if name.contains(' ') || !endings.iter().any(|ending| name.ends_with(ending)) {
        return;
    }
    if name.contains('/') {
        assert!(read(name).contains(rest.trim()), "{page}:{line}: {name} does not have this word for word");
    } else {
        fs::write(place.now.join(name), text).unwrap();
    }
}

#[test]
fn every_command_of_the_documentation_runs() {
    follow_the_pages(true);
}

#[test]
#[ignore = "a minute or two: the runs at full length, and the figures that the pages quote"]
fn every_figure_that_a_page_quotes_is_printed_at_full_length() {
    follow_the_pages(false);
}

#[test]
fn the_message_in_the_readme_is_what_the_program_says() {
    let readme = read("README.md");
    let text = pieces(&readme).into_iter().find_map(|piece| match piece {
        Piece::Block { language, text, .. } if language == "text" => Some(text),
        _ => None,
    });
    let place = Place::new(true);
    let folder = place.directory.path().join("meshes/taylor");
    let deck = fs::read_to_string(folder.join("taylor.toml")).unwrap().replace("117 GPa", "117 GPs");
    fs::write(folder.join("taylor.toml"), deck).unwrap();
    let mut command = Command::new(env!("CARGO_BIN_EXE_estar"));
    command.args(["run", "taylor.toml"]).current_dir(folder);
    let (status, printed) = output(command, "README.md");
    assert_eq!(status, 2);
    assert!(printed.starts_with(&text.unwrap()), "{printed}");
}

#[test]
fn every_message_of_troubleshooting_is_one_of_the_program() {
    let mut sources = vec![read("docs/bad-input.md")];
    let mut folders = vec![root().join("crates")];
    while let Some(folder) = folders.pop() {
        for path in fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()) {
            if path.is_dir() {
                folders.push(path);
            } else if path.extension().is_some_and(|extension| extension == "rs") {
                sources.push(joined(&fs::read_to_string(path).unwrap()));
            }
        }
    }
    let mut count = 0;
    for piece in pieces(&read("docs/troubleshooting.md")) {
        let Piece::Heading(heading) = piece else { continue };
        let Some(message) = heading.strip_prefix('`').and_then(|message| message.strip_suffix('`')) else { continue };
        let parts: Vec<&str> = message.split('…').map(str::trim).filter(|part| part.len() > 2).collect();
        let has = |source: &String| source.lines().any(|line| parts.iter().all(|part| line.contains(part)));
        assert!(sources.iter().any(has), "no such message: {message}");
        count += 1;
    }
    assert!(count > 15, "{count}");
}

/// The source with each string on one line.
fn joined(source: &str) -> String {
    let mut text = String::new();
    for line in source.lines() {
        match line.strip_suffix('\\') {
            Some(start) if text.ends_with('\n') || text.is_empty() => text.push_str(start),
            Some(start) => text.push_str(start.trim_start()),
            None if text.ends_with('\n') || text.is_empty() => {
                text.push_str(line);
                text.push('\n');
            }
            None => {
                text.push_str(line.trim_start());
                text.push('\n');
            }
        }
    }
    text
}

#[test]
fn links_lead_somewhere_and_the_contents_have_every_page() {
    let mut all = pages();
    all.extend(["ARCHITECTURE.md", "CONTRIBUTING.md"].map(str::to_owned));
    for page in &all {
        let folder = Path::new(page).parent().unwrap();
        for piece in pieces(&read(page)) {
            let (Piece::Prose(text) | Piece::Heading(text)) = piece else { continue };
            for link in text.split("](").skip(1) {
                let link = link.split_once(')').unwrap_or_else(|| panic!("{page}: a link without an end: {link}")).0;
                if link.contains("://") {
                    continue;
                }
                let (file, anchor) = link.split_once('#').map_or((link, None), |(file, anchor)| (file, Some(anchor)));
                let target = if file.is_empty() { PathBuf::from(page) } else { folder.join(file) };
                let path = root().join(&target);
                assert!(path.exists(), "{page}: {link}");
                if let Some(anchor) = anchor {
                    let text = fs::read_to_string(path).unwrap();
                    let is_anchor =
                        |piece: &Piece| matches!(piece, Piece::Heading(heading) if anchor_of(heading) == anchor);
                    assert!(pieces(&text).iter().any(is_anchor), "{page}: no heading {link}");
                }
            }
        }
    }
    let contents = read("docs/README.md");
    for page in pages().iter().filter_map(|page| page.strip_prefix("docs/")).filter(|page| *page != "README.md") {
        assert!(contents.contains(&format!("({page})")), "docs/README.md lacks {page}");
    }
}

/// The anchor of a heading, as code hosts make it.
fn anchor_of(heading: &str) -> String {
    let kept = heading
        .to_lowercase()
        .chars()
        .filter(|letter| letter.is_alphanumeric() || " -_".contains(*letter))
        .collect::<String>();
    kept.replace(' ', "-")
}

#[test]
fn commands_have_the_options_that_they_are_given() {
    for page in pages() {
        for piece in pieces(&read(&page)) {
            let commands: Vec<Vec<String>> = match piece {
                Piece::Prose(text) => text.split('`').skip(1).step_by(2).map(|code| words(code).0).collect(),
                Piece::Block { language, line, text } if language == "sh" => {
                    shell_lines(&text, line).into_iter().map(|line| line.words).collect()
                }
                _ => continue,
            };
            for command in commands.iter().filter(|command| command[..].first().is_some_and(|word| word == "estar")) {
                assert_has_options(&page, &command[1..]);
            }
        }
    }
}

/// Asserts that the help of a command has its options.
#[track_caller]
fn assert_has_options(page: &str, given: &[String]) {
    let is_name =
        |word: &&String| word.starts_with(|letter: char| letter.is_ascii_lowercase()) && !word.contains(['.', '/']);
    let mut names: Vec<&String> = given.iter().take_while(is_name).collect();
    let help = |names: &[&String]| {
        let mut command = Command::new(env!("CARGO_BIN_EXE_estar"));
        command.args(names).arg("--help");
        output(command, page)
    };
    let (mut status, mut told) = help(&names);
    // `estar example taylor`: the second word is a value
    while status != 0 && names.len() > 1 {
        names.pop();
        (status, told) = help(&names);
    }
    assert_eq!(status, 0, "{page}: {given:?}");
    for option in given.iter().filter(|word| word.starts_with("--")) {
        let option = option.split('=').next().unwrap().trim_end_matches(|letter: char| !letter.is_ascii_alphanumeric());
        assert!(told.contains(option), "{page}: {given:?}: no {option}");
    }
}
