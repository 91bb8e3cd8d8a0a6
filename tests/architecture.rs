//! Goal: the house stays as ARCHITECTURE.md draws it: files of a crate use each other one way, but for the exceptions that are named
//! there with their reason, crates depend on each other one way, and files stay short enough to be read in one sitting.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};

/// Lines of a file without its tests.
const MOST_LINES: usize = 600;

/// Files that are longer, with the lines that they may have. The list may only become shorter, and its numbers smaller.
const LONG: &[(&str, usize)] = &[
    ("element/src/hex8_one_point.rs", 618),
    ("io/src/abaqus/sets.rs", 749),
    ("material/src/plastic_metric.rs", 618),
    ("solver/src/simulation.rs", 655),
];

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).to_owned()
}

fn crates() -> Vec<PathBuf> {
    let entries = fs::read_dir(root().join("crates")).unwrap().map(|entry| entry.unwrap().path());
    let mut folders: Vec<PathBuf> = entries.filter(|path| path.join("src/lib.rs").exists()).collect();
    folders.sort();
    assert!(folders.len() > 5, "{folders:?}");
    folders
}

fn name(folder: &Path) -> String {
    folder.file_name().unwrap().to_str().unwrap().to_owned()
}

/// The files of a crate below a folder, by their places in it.
fn sources(folder: &Path, place: &str, found: &mut BTreeMap<String, String>) {
    for entry in fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()) {
        let name = name(&entry);
        let place = if place.is_empty() { name.clone() } else { format!("{place}/{name}") };
        if entry.is_dir() {
            sources(&entry, &place, found);
        } else if name.ends_with(".rs") {
            found.insert(place, without_tests(&fs::read_to_string(&entry).unwrap()).to_owned());
        }
    }
}

/// What stands before the module of tests.
fn without_tests(text: &str) -> &str {
    let is_test = |line: &str| line.starts_with("#[cfg(test") || line.starts_with("#[cfg(all(test");
    let mut lines = text.split_inclusive('\n').peekable();
    let mut length = 0;
    while let Some(line) = lines.next() {
        if is_test(line) && lines.peek().is_some_and(|next| next.starts_with("mod ") && next.contains('{')) {
            break;
        }
        length += line.len();
    }
    &text[..length]
}

/// The modules of a crate: paths such as `deck::units`, the crate itself as the empty path.
struct Modules {
    /// The place of the file and its text, without comments.
    files: BTreeMap<String, (String, String)>,
    /// What a module gives out by `pub use`, and where it has it from.
    passed_on: BTreeMap<String, String>,
}

impl Modules {
    fn of(folder: &Path) -> Self {
        let mut texts = BTreeMap::new();
        sources(&folder.join("src"), "", &mut texts);
        let mut files = BTreeMap::new();
        for (place, text) in texts {
            let path = place.trim_end_matches(".rs").replace('/', "::");
            let path = path.strip_suffix("::mod").unwrap_or(&path).to_owned();
            let path = if path == "lib" || path == "main" { String::new() } else { path };
            let code = |line: &str| line.split("//").next().unwrap_or("").to_owned();
            let text: String = text.lines().map(|line| code(line) + "\n").collect();
            // of lib.rs and main.rs the library counts
            if place != "main.rs" {
                files.insert(path, (place, text));
            }
        }
        let mut modules = Self { files, passed_on: BTreeMap::new() };
        for module in modules.files.keys().cloned().collect::<Vec<_>>() {
            for used in modules.uses(&module, true) {
                let (path, alias) = used.split_once(" as ").unwrap_or((&used, last(&used)));
                if let Some(from) = modules.absolute(&module, path) {
                    modules.passed_on.insert(below(&module, alias), from);
                }
            }
        }
        modules
    }

    /// The paths of the `use` lines of a module: of those that give out what they use, or of the others.
    fn uses(&self, module: &str, given_out: bool) -> Vec<String> {
        let mut found = Vec::new();
        for statement in self.files[module].1.split(';') {
            let Some(start) = statement.rfind("use ").filter(|start| starts_a_word(statement, *start)) else {
                continue;
            };
            let is_pub = statement[..start].trim_end().ends_with("pub");
            if is_pub == given_out {
                let tree = statement[start + 4..].split_whitespace().collect::<Vec<_>>().join(" ");
                expand("", &tree, &mut found);
            }
        }
        found
    }

    /// The paths with `crate`, `super` or `self` that stand elsewhere than in `use` lines.
    fn mentions(&self, module: &str) -> Vec<String> {
        let text = &self.files[module].1;
        let mut found = Vec::new();
        for root in ["crate::", "super::", "self::"] {
            for (start, _) in text.match_indices(root).filter(|(start, _)| starts_a_word(text, *start)) {
                let is_part = |character: char| character.is_alphanumeric() || character == '_' || character == ':';
                let path: String = text[start..].chars().take_while(|character| is_part(*character)).collect();
                found.push(path.trim_end_matches(':').to_owned());
            }
        }
        found
    }

    /// A path from the top of the crate; none where it leads out of it.
    fn absolute(&self, module: &str, path: &str) -> Option<String> {
        if let Some(path) = path.strip_prefix("crate::") {
            return Some(path.to_owned());
        }
        let (mut module, mut path) = (module.to_owned(), path);
        if let Some(rest) = path.strip_prefix("self::") {
            return Some(below(&module, rest));
        }
        let mut is_inside = false;
        while let Some(rest) = path.strip_prefix("super::") {
            module = module.rsplit_once("::").map_or(String::new(), |(parent, _)| parent.to_owned());
            (path, is_inside) = (rest, true);
        }
        let first = path.split("::").next().unwrap_or(path);
        (is_inside || self.files.contains_key(&below(&module, first))).then(|| below(&module, path))
    }

    /// The module that has what a path names.
    fn owner(&self, path: &str, depth: usize) -> String {
        let parts: Vec<&str> = path.split("::").collect();
        for length in (0..=parts.len()).rev() {
            let module = parts[..length].join("::");
            if !self.files.contains_key(&module) {
                continue;
            }
            let item = parts.get(length).map(|item| below(&module, item));
            return match item.and_then(|item| self.passed_on.get(&item)) {
                Some(from) if depth < 8 => {
                    self.owner(&[&[from.as_str()], &parts[length + 1..]].concat().join("::"), depth + 1)
                }
                _ => module,
            };
        }
        String::new()
    }

    /// Which modules each module uses.
    fn edges(&self) -> BTreeMap<&str, BTreeSet<String>> {
        let of_module = |module: &String| {
            let paths = self.uses(module, false).into_iter().chain(self.mentions(module));
            let plain = paths.map(|path| path.split(" as ").next().unwrap_or("").to_owned());
            let owners = plain.filter_map(|path| Some(self.owner(&self.absolute(module, &path)?, 0)));
            owners.filter(|owner| owner != module).collect()
        };
        self.files.keys().map(|module| (module.as_str(), of_module(module))).collect()
    }
}

fn starts_a_word(text: &str, start: usize) -> bool {
    !text[..start].ends_with(|before: char| before.is_alphanumeric() || "_:$".contains(before))
}

fn below(module: &str, item: &str) -> String {
    if module.is_empty() { item.to_owned() } else { format!("{module}::{item}") }
}

fn last(path: &str) -> &str {
    path.rsplit("::").next().unwrap_or(path)
}

/// The paths of a tree such as `a::{b, c::{d, self}}`.
fn expand(before: &str, tree: &str, found: &mut Vec<String>) {
    let tree = tree.trim();
    let Some((head, rest)) = tree.split_once('{') else {
        let path = format!("{before}{tree}");
        found.push(path.strip_suffix("::self").map_or(path.clone(), str::to_owned));
        return;
    };
    let before = format!("{before}{head}");
    let (mut depth, mut start) = (0, 0);
    for (index, character) in rest.char_indices() {
        match character {
            '{' => depth += 1,
            '}' if depth > 0 => depth -= 1,
            ',' | '}' if depth == 0 => {
                if !rest[start..index].trim().is_empty() {
                    expand(&before, &rest[start..index], found);
                }
                start = index + 1;
            }
            _ => {}
        }
    }
}

/// The sets of nodes that can be reached from each other, of two nodes or more.
fn circles(edges: &BTreeMap<&str, BTreeSet<String>>) -> BTreeSet<BTreeSet<String>> {
    let reached = |start: &str| {
        let (mut seen, mut open) = (BTreeSet::new(), vec![start.to_owned()]);
        while let Some(node) = open.pop() {
            for next in edges.get(node.as_str()).into_iter().flatten() {
                if seen.insert(next.clone()) {
                    open.push(next.clone());
                }
            }
        }
        seen
    };
    let reached: BTreeMap<&str, BTreeSet<String>> = edges.keys().map(|node| (*node, reached(node))).collect();
    let circle = |node: &&str| -> BTreeSet<String> {
        let back = |other: &&String| reached.get(other.as_str()).is_some_and(|from| from.contains(*node));
        reached[*node].iter().filter(back).cloned().collect()
    };
    edges.keys().map(circle).filter(|circle| circle.len() > 1).collect()
}

/// The exceptions of ARCHITECTURE.md: crate and files.
fn exceptions() -> BTreeSet<(String, BTreeSet<String>)> {
    let text = fs::read_to_string(root().join("ARCHITECTURE.md")).unwrap();
    let (_, section) = text.split_once("## Files that know each other\n").expect("a section on circles");
    let exception = |line: &str| {
        let (of, rest) = line.strip_prefix("- `")?.split_once("`: ")?;
        let (files, reason) = rest.split_once("; ")?;
        assert!(!reason.is_empty(), "{line}");
        let files = files.split(", ").map(|file| file.trim_matches('`').to_owned());
        Some((of.to_owned(), files.collect()))
    };
    section.lines().take_while(|line| !line.starts_with("## ")).filter_map(exception).collect()
}

#[test]
fn files_of_a_crate_use_each_other_one_way() {
    let mut found = BTreeSet::new();
    for folder in crates() {
        let modules = Modules::of(&folder);
        for circle in circles(&modules.edges()) {
            let files = circle.iter().map(|module| modules.files[module].0.clone()).collect();
            found.insert((name(&folder), files));
        }
    }
    let known = exceptions();
    let new: Vec<_> = found.difference(&known).collect();
    let gone: Vec<_> = known.difference(&found).collect();
    assert!(new.is_empty(), "these files use each other, and ARCHITECTURE.md does not say why: {new:#?}");
    assert!(gone.is_empty(), "these are no circles of files any more; take them out of ARCHITECTURE.md: {gone:#?}");
}

#[test]
fn circles_are_found_where_there_are_some() {
    let edges = |pairs: &[(&'static str, &[&str])]| -> BTreeMap<&'static str, BTreeSet<String>> {
        pairs.iter().map(|(node, to)| (*node, to.iter().map(|to| (*to).to_owned()).collect())).collect()
    };
    let none = edges(&[("a", &["b", "c"]), ("b", &["c"]), ("c", &[])]);
    assert!(circles(&none).is_empty());
    let one = edges(&[("a", &["b"]), ("b", &["c"]), ("c", &["b", "d"]), ("d", &[])]);
    assert_eq!(circles(&one), [["b", "c"].map(str::to_owned).into()].into());
    let mut paths = Vec::new();
    expand("", "crate::a::{self, b, c::{d as e, f}}", &mut paths);
    assert_eq!(paths, ["crate::a", "crate::a::b", "crate::a::c::d as e", "crate::a::c::f"]);
    // the edges are those of the code: session runs what set-up makes of the deck
    let session = Modules::of(&root().join("crates/session"));
    let edges = session.edges();
    assert!(edges["session"].contains("setup") && edges["setup"].contains("problem"), "{edges:?}");
}

#[test]
fn files_are_short_enough_to_be_read_in_one_sitting() {
    let mut too_long = Vec::new();
    let mut known: BTreeMap<&str, usize> = LONG.iter().copied().collect();
    let folders = crates().into_iter().chain([root().join("crates/app")]).collect::<BTreeSet<_>>();
    for folder in folders {
        let mut texts = BTreeMap::new();
        sources(&folder.join("src"), "", &mut texts);
        for (place, text) in texts {
            let (place, lines) = (format!("{}/src/{place}", name(&folder)), text.lines().count());
            let most = known.remove(place.as_str()).unwrap_or(MOST_LINES);
            if lines > most {
                too_long.push(format!("{place} has {lines} lines, where {most} are allowed"));
            }
            assert!(most == MOST_LINES || lines > MOST_LINES, "{place} is short now: take it out of the list");
        }
    }
    assert!(too_long.is_empty(), "{too_long:#?}");
    assert!(known.is_empty(), "these are not there any more: {known:?}");
}

#[test]
fn crates_depend_on_each_other_one_way() {
    let mut edges = BTreeMap::new();
    let names: Vec<String> = crates().iter().map(|folder| name(folder)).collect();
    for (folder, own) in crates().iter().zip(&names) {
        let manifest = folder.join("Cargo.toml");
        let manifest = if manifest.exists() { manifest } else { root().join("Cargo.toml") };
        let text = fs::read_to_string(manifest).unwrap();
        let (_, after) = text.split_once("\n[dependencies]\n").unwrap();
        let own_lines = after.lines().take_while(|line| !line.starts_with('['));
        let needed = own_lines.filter_map(|line| line.strip_prefix("estar-")?.split(['.', ' ', '=']).next());
        edges.insert(own.as_str(), needed.map(str::to_owned).collect::<BTreeSet<String>>());
    }
    assert!(edges["app"].contains("session") && edges["session"].contains("deck"), "{edges:?}");
    assert!(circles(&edges).is_empty());
    // what reads a deck starts no run, and what runs it draws nothing
    for (of, not) in [("deck", "session"), ("deck", "post"), ("session", "post"), ("solver", "deck"), ("io", "solver")]
    {
        assert!(!edges[of].contains(not), "{of} needs {not}");
    }
}

#[test]
fn only_the_program_prints() {
    for folder in crates().iter().filter(|folder| name(folder) != "app") {
        let mut texts = BTreeMap::new();
        sources(&folder.join("src"), "", &mut texts);
        for (place, text) in texts {
            let code = text.lines().map(|line| line.split("//").next().unwrap_or(""));
            for line in code {
                let prints =
                    ["print!(", "println!(", "stdout()", "stderr()", "dbg!("].iter().any(|word| line.contains(word));
                assert!(!prints, "{}/src/{place}: {line}", name(folder));
            }
        }
    }
}
