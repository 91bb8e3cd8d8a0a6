//! Goal: the page of `estar view` and `estar run --watch` shows a run, to this machine only, whatever is asked of it; and a run that
//! is watched ends in the same bits, with the same status and words, as one that is not.
//!
//! The page itself is loaded by headless Chromium; without it that test says that it was skipped.

mod common;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use common::{DECK, Workshop};
use serde_json::{Value, json};
use std::io::{BufRead, BufReader, Read, Write};
use std::net::{Ipv4Addr, Shutdown, SocketAddr, TcpStream};
use std::process::{Child, ChildStdin, ChildStdout, Command, Stdio};
use std::time::{Duration, Instant};

/// `estar view` of a directory of a workshop, ended with the test.
struct Viewer {
    process: Child,
    port: u16,
    /// What all paths begin with.
    key: String,
}

impl Viewer {
    fn of(workshop: &Workshop, directory: &str) -> Self {
        let mut command = Command::new(env!("CARGO_BIN_EXE_estar"));
        command.args(["view", directory]).current_dir(workshop.directory.path()).stdout(Stdio::piped());
        let mut process = command.spawn().unwrap();
        let mut line = String::new();
        BufReader::new(process.stdout.take().unwrap()).read_line(&mut line).unwrap();
        let (port, key) = address_in(&line);
        Self { process, port, key }
    }

    fn get(&self, target: &str) -> Answer {
        let Self { port, key, .. } = self;
        ask(*port, &format!("GET {key}{target} HTTP/1.1\r\nHost: 127.0.0.1:{port}\r\n\r\n"))
    }

    fn state(&self) -> Value {
        self.get("/state.json").json()
    }
}

impl Drop for Viewer {
    fn drop(&mut self) {
        let _ = self.process.kill();
        let _ = self.process.wait();
    }
}

/// Port and key.
fn address_in(line: &str) -> (u16, String) {
    let (_, after) = line.split_once("http://127.0.0.1:").unwrap_or_else(|| panic!("no address in {line:?}"));
    let mut parts = after.split('/');
    let (port, key) = (parts.next().unwrap().parse().unwrap(), parts.next().unwrap());
    assert!(key.len() == 32 && key.bytes().all(|byte| byte.is_ascii_hexdigit()), "{line:?}");
    (port, format!("/{key}"))
}

/// An answer of the page.
struct Answer {
    status: u16,
    head: String,
    body: Vec<u8>,
}

impl Answer {
    fn of(bytes: &[u8]) -> Self {
        let end = bytes.windows(4).position(|window| window == b"\r\n\r\n").expect("an answer has a head");
        let head = String::from_utf8(bytes[..end].to_vec()).unwrap();
        let status = head.split(' ').nth(1).unwrap().parse().unwrap();
        Self { status, head, body: bytes[end + 4..].to_vec() }
    }

    fn text(&self) -> String {
        String::from_utf8_lossy(&self.body).into_owned()
    }

    fn json(&self) -> Value {
        assert_eq!(self.status, 200, "{}", self.text());
        serde_json::from_slice(&self.body).unwrap()
    }

    fn header(&self, name: &str) -> &str {
        let mut lines = self.head.lines().filter_map(|line| line.split_once(": "));
        lines.find(|(known, _)| known.eq_ignore_ascii_case(name)).map_or("", |(_, value)| value)
    }
}

fn connect(port: u16) -> TcpStream {
    let stream = TcpStream::connect((Ipv4Addr::LOCALHOST, port)).unwrap();
    stream.set_read_timeout(Some(Duration::from_secs(20))).unwrap();
    stream
}

fn ask(port: u16, request: &str) -> Answer {
    let mut stream = connect(port);
    stream.write_all(request.as_bytes()).unwrap();
    let mut bytes = Vec::new();
    stream.read_to_end(&mut bytes).unwrap();
    Answer::of(&bytes)
}

/// The deck with a title of signs that a page could take for its own.
fn run_box(workshop: &Workshop) {
    let deck = DECK.replace("A box flies", "A box <b>flies</b> & lands");
    workshop.run_deck(&format!("{deck}{PROBE}"), &["--quiet"]).assert(0, &[]);
}

const PROBE: &str = "\n[[probe]]\nname = \"place\"\nkind = \"extent\"\ngroup = \"box\"\naxis = \"x\"\n\n\
[[expect]]\nprobe = \"place\"\nat = \"end\"\nvalue = 1.0\ntolerance = 1e-6\n";

#[test]
fn the_page_tells_what_a_run_has_written() {
    let workshop = Workshop::new();
    run_box(&workshop);
    let viewer = Viewer::of(&workshop, "deck");
    let summary = workshop.summary();

    let state = viewer.state();
    assert_eq!((&state["status"], &state["frames"]), (&"finished".into(), &5.into()));
    assert_eq!(state["title"], "A box <b>flies</b> & lands");
    assert_eq!((&state["progress"]["time"], &state["progress"]["end_time"]), (&0.02.into(), &0.02.into()));
    assert_eq!((&state["progress"]["step"], &state["summary"]), (&summary["steps"], &summary));

    let history = viewer.get("/history.json").json();
    let rows = workshop.read("deck/history.csv").lines().count() - 1;
    assert_eq!((history["rows"].as_u64(), history["time"].as_array().unwrap().len()), (Some(rows as u64), rows));
    let panels = history["panels"].as_array().unwrap();
    assert_eq!((&panels[0]["label"], &panels[0]["unit"]), (&"energy".into(), &"J".into()));
    let place = panels.iter().find(|panel| panel["label"] == "place").unwrap();
    assert!((place["curves"][0]["values"][0].as_f64().unwrap() - 1.0).abs() < 1e-6);

    // 24 faces over the 26 nodes on the outside of 2 x 2 x 2 hexes
    let head = |answer: &Answer| -> Value {
        assert_eq!(answer.status, 200, "{}", answer.text());
        let length = u32::from_le_bytes(answer.body[..4].try_into().unwrap()) as usize;
        serde_json::from_slice(&answer.body[4..4 + length]).unwrap()
    };
    let newest = viewer.get("/surface?field=velocity&component=x");
    let described = head(&newest);
    assert_eq!((&described["frame"], &described["faces"], &described["vertices"]), (&4.into(), &24.into(), &26.into()));
    assert_eq!((&described["unit"], described["range"][0].as_f64().unwrap().round()), (&"m/s".into(), 1.0));
    assert_eq!(head(&viewer.get("/surface?frame=0&field=displacement"))["range"], json!([0.0, 0.0]));
    for missing in
        ["/surface?frame=9", "/surface?field=heat", "/surface?field=velocity&component=xx", "/surface?frame=-1"]
    {
        assert_eq!(viewer.get(missing).status, 404, "{missing}");
    }
}

#[test]
fn only_fixed_parts_are_served_and_only_to_this_host_and_only_to_be_looked_at() {
    let workshop = Workshop::new();
    run_box(&workshop);
    let viewer = Viewer::of(&workshop, "deck");
    let (port, key) = (viewer.port, &viewer.key);
    for (target, kind) in [
        ("/", "text/html; charset=utf-8"),
        ("/page.css", "text/css; charset=utf-8"),
        ("/page.js", "text/javascript; charset=utf-8"),
        ("/body.js", "text/javascript; charset=utf-8"),
        ("/curves.js", "text/javascript; charset=utf-8"),
        ("/icon.svg", "image/svg+xml"),
        ("/state.json", "application/json"),
    ] {
        let answer = viewer.get(target);
        assert_eq!((answer.status, answer.header("Content-Type")), (200, kind), "{target}");
        assert_eq!(answer.header("Content-Length"), answer.body.len().to_string());
        let policy = answer.header("Content-Security-Policy");
        assert!(policy.starts_with("default-src 'none';") && policy.contains("frame-ancestors 'none'"), "{policy}");
        assert!(!policy.contains("unsafe") && !policy.contains('*') && !policy.contains("http"), "{policy}");
        assert_eq!((answer.header("X-Content-Type-Options"), answer.header("Cache-Control")), ("nosniff", "no-store"));
        assert_eq!(answer.header("Cross-Origin-Resource-Policy"), "same-origin");
        assert_eq!(answer.header("Access-Control-Allow-Origin"), "");
        // nothing of another address is loaded
        for wrong in [String::new(), key.replace(|sign: char| sign.is_ascii_digit(), "a"), "/".repeat(33)] {
            let answer = ask(port, &format!("GET {wrong}{target} HTTP/1.1\r\nHost: 127.0.0.1:{port}\r\n\r\n"));
            assert_eq!(answer.status, 404, "{wrong}{target}");
        }
        let text = answer.text().replace("http://www.w3.org/2000/svg", "");
        assert!(!text.contains("http://") && !text.contains("https://"), "{target}");
        let head = ask(port, &format!("HEAD {key}{target} HTTP/1.1\r\nHost: localhost:{port}\r\n\r\n"));
        assert_eq!((head.status, head.body.len(), head.header("Content-Type")), (200, 0, kind));
    }
    for target in [
        "/summary.json",
        "/deck/summary.json",
        "/../deck.toml",
        "//",
        "/state.json/",
        "/%2e%2e/deck.toml",
        "/history.csv",
        "*",
    ] {
        assert!([400, 404].contains(&viewer.get(target).status), "{target}");
    }
    for host in ["example.org", "127.0.0.1", "localhost:1", &format!("127.0.0.1.example.org:{port}"), ""] {
        let answer = ask(port, &format!("GET {key}/state.json HTTP/1.1\r\nHost: {host}\r\n\r\n"));
        assert_eq!(answer.status, 403, "{host}");
        assert!(!answer.text().contains("flies"));
    }
    for method in ["POST", "PUT", "DELETE", "OPTIONS", "TRACE", "PATCH", "BREW"] {
        let answer = ask(port, &format!("{method} / HTTP/1.1\r\nHost: 127.0.0.1:{port}\r\n\r\n"));
        assert_eq!((answer.status, answer.header("Allow")), (405, "GET, HEAD"), "{method}");
    }
}

#[test]
#[cfg(target_os = "linux")]
fn it_listens_on_the_loopback_address_and_on_no_other() {
    let workshop = Workshop::new();
    run_box(&workshop);
    let viewer = Viewer::of(&workshop, "deck");
    // inodes of the sockets of the process, then the addresses on which one of them listens (state 0A)
    let descriptors = std::fs::read_dir(format!("/proc/{}/fd", viewer.process.id())).unwrap();
    let links = descriptors.filter_map(|entry| std::fs::read_link(entry.unwrap().path()).ok());
    let inodes: Vec<String> = links
        .filter_map(|link| link.to_str()?.strip_prefix("socket:[")?.strip_suffix(']').map(str::to_owned))
        .collect();
    let mut listening = Vec::new();
    for table in ["tcp", "tcp6", "udp", "udp6"] {
        let text = std::fs::read_to_string(format!("/proc/{}/net/{table}", viewer.process.id())).unwrap_or_default();
        for line in text.lines().skip(1) {
            let cells: Vec<&str> = line.split_whitespace().collect();
            if inodes.iter().any(|inode| inode == cells[9]) && (cells[3] == "0A" || table.starts_with("udp")) {
                listening.push(cells[1].to_owned());
            }
        }
    }
    assert_eq!(listening, [format!("0100007F:{:04X}", viewer.port)]);
    // every address of 127.0.0.0/8 is this machine, but not this page's
    let other = SocketAddr::from((Ipv4Addr::new(127, 0, 0, 2), viewer.port));
    assert!(TcpStream::connect_timeout(&other, Duration::from_secs(1)).is_err());
}

#[test]
fn hostile_requests_neither_stop_the_page_nor_fill_the_memory() {
    let workshop = Workshop::new();
    run_box(&workshop);
    let viewer = Viewer::of(&workshop, "deck");
    let (port, key) = (viewer.port, &viewer.key);
    let host = format!("Host: 127.0.0.1:{port}\r\n");
    // what is answered, or that the connection is closed
    let told = |bytes: &[u8]| -> Option<u16> {
        let mut stream = connect(port);
        // it may be closed while this is still being sent
        let _ = stream.write_all(bytes);
        let _ = stream.shutdown(Shutdown::Write);
        let mut answer = Vec::new();
        let _ = stream.read_to_end(&mut answer);
        answer.starts_with(b"HTTP/1.1 ").then(|| Answer::of(&answer).status)
    };
    let noise: Vec<u8> = (0..4096_u32).map(|i| (i.wrapping_mul(2_654_435_761) >> 13) as u8).collect();
    for bytes in [
        Vec::new(),
        b"\r\n\r\n".to_vec(),
        b"\0\0\0\0".to_vec(),
        b"GET".to_vec(),
        b"GET / HTTP/1.1\r\n".to_vec(),
        b"\x16\x03\x01\x02\x00\x01\x00\x01\xfc\x03\x03".to_vec(),
        b"PRI * HTTP/2.0\r\n\r\nSM\r\n\r\n".to_vec(),
        noise,
        format!("GET /{} HTTP/1.1\r\n{host}\r\n", "a".repeat(100_000)).into_bytes(),
        format!("GET / HTTP/1.1\r\n{host}{}\r\n", "A: b\r\n".repeat(20_000)).into_bytes(),
        format!("GET / HTTP/1.1\r\n{host}X: {}", "x".repeat(8 << 20)).into_bytes(),
        format!("GET / HTTP/1.1\r\n{host}Content-Length: 99999999999999999999\r\n\r\n").into_bytes(),
        format!("GET / HTTP/1.1\r\n{host}Transfer-Encoding: chunked\r\n\r\nffffffffffffffff\r\n").into_bytes(),
        format!("GET {key}/surface?frame=99999999999999999999999 HTTP/1.1\r\n{host}\r\n").into_bytes(),
        format!("GET {key}/surface?field={} HTTP/1.1\r\n{host}\r\n", "v".repeat(10_000)).into_bytes(),
        format!("GET {key}/surface?{} HTTP/1.1\r\n{host}\r\n", "frame=0&".repeat(1000)).into_bytes(),
        format!("GET / HTTP/1.1\r\nHost: \u{202e}\r\n{host}\r\n").into_bytes(),
    ] {
        let status = told(&bytes);
        let shown = String::from_utf8_lossy(&bytes[..bytes.len().min(60)]).into_owned();
        assert!(
            status.is_none_or(|status| (400..500).contains(&status) || shown.contains("frame=0&")),
            "{status:?} {shown}"
        );
    }

    // connections that say nothing, or never come to an end: more than are served at one time
    let silent: Vec<TcpStream> =
        (0..200).filter_map(|_| TcpStream::connect((Ipv4Addr::LOCALHOST, port)).ok()).collect();
    for mut stream in silent.iter().take(100) {
        let _ = stream.write_all(b"GET / HTTP/1.1\r\nX: ");
    }
    if cfg!(target_os = "linux") {
        let value = |name: &str| -> u64 {
            let status = std::fs::read_to_string(format!("/proc/{}/status", viewer.process.id())).unwrap();
            let line = status.lines().find_map(|line| line.strip_prefix(name)).unwrap();
            line.split_whitespace().next().unwrap().parse().unwrap()
        };
        // on a busy machine those that had to give way take a moment to end
        let patience = Instant::now();
        while value("Threads:") >= 50 {
            assert!(patience.elapsed() < Duration::from_secs(3), "{} threads", value("Threads:"));
            std::thread::sleep(Duration::from_millis(20));
        }
        assert!(value("VmRSS:") < 200_000, "{} KiB", value("VmRSS:"));
    }
    // those that are slow are given up, and the page is there again although they never closed
    let begin = Instant::now();
    loop {
        let mut bytes = Vec::new();
        let mut stream = connect(port);
        let sent = stream.write_all(format!("GET {key}/state.json HTTP/1.1\r\n{host}\r\n").as_bytes());
        if sent.is_ok() && stream.read_to_end(&mut bytes).is_ok() && bytes.starts_with(b"HTTP/1.1 200") {
            break;
        }
        assert!(begin.elapsed() < Duration::from_secs(30), "{}", String::from_utf8_lossy(&bytes));
        std::thread::sleep(Duration::from_millis(200));
    }
    drop(silent);
    assert_eq!(viewer.state()["status"], "finished");
}

/// Whoever has an account on this machine can connect.
#[test]
fn connections_without_the_key_keep_nobody_out() {
    let workshop = Workshop::new();
    run_box(&workshop);
    let viewer = Viewer::of(&workshop, "deck");
    let port = viewer.port;
    let come = |count: usize| -> Vec<TcpStream> {
        let strangers = (0..count).filter_map(|_| TcpStream::connect((Ipv4Addr::LOCALHOST, port)).ok());
        let mut strangers: Vec<TcpStream> = strangers.collect();
        for (number, stranger) in strangers.iter_mut().enumerate() {
            // some say nothing, some begin a request, some ask without the key and do not read the answer
            let said = ["", "GET /0 HTTP/1.1\r\nX: ", "GET / HTTP/1.1\r\nHost: localhost\r\n\r\n"][number % 3];
            let _ = stranger.write_all(said.as_bytes());
        }
        strangers
    };
    let mut strangers = come(300);
    for _ in 0..20 {
        let begin = Instant::now();
        assert_eq!(viewer.state()["status"], "finished");
        // not the five seconds that a request may take
        assert!(begin.elapsed() < Duration::from_secs(2), "{:?}", begin.elapsed());
        strangers.extend(come(40));
    }
    // one who knows the key and is slow to read keeps its place
    let mut slow = connect(port);
    let request = format!("GET {}/surface HTTP/1.1\r\nHost: 127.0.0.1:{port}\r\n\r\n", viewer.key);
    slow.write_all(request.as_bytes()).unwrap();
    let mut answer = vec![0];
    slow.read_exact(&mut answer).unwrap();
    strangers.extend(come(100));
    std::thread::sleep(Duration::from_millis(500));
    slow.read_to_end(&mut answer).unwrap();
    assert_eq!(Answer::of(&answer).status, 200);
}

#[test]
fn a_page_of_a_strangers_results_shows_nothing_that_steers_and_waits_for_no_pipe() {
    let workshop = Workshop::new();
    run_box(&workshop);
    let probes: String = (0..400).map(|probe| format!(",p{probe}")).collect();
    let row: String = (0..400).map(|probe| format!(",{probe}")).collect();
    workshop.write("deck/history.csv", &format!("time,kinetic_energy{probes}\n0,1{row}\n"));
    let log = workshop.read("deck/estar.log");
    workshop.write("deck/estar.log", &log.replace("A box", "A \u{202e}\u{1b}[2J box"));
    let summary = workshop.read("deck/summary.json");
    workshop.write("deck/summary.json", &summary.replace("A box", "A \\u202e\\u001b[2J box"));
    let viewer = Viewer::of(&workshop, "deck");
    assert_eq!(viewer.get("/history.json").json()["panels"].as_array().unwrap().len(), 101);
    let state = viewer.state();
    let notes = state["notes"].to_string();
    assert!(notes.contains("400 probes, of which this page shows the first 100"), "{notes}");
    assert!(state["title"].as_str().unwrap().starts_with("A \u{fffd}\u{fffd}[2J box"), "{}", state["title"]);
    let told = viewer.get("/state.json").text();
    for hidden in ["\u{202e}", "\u{1b}", "u202e", "u001b"] {
        assert!(!told.contains(hidden), "{hidden:?}");
    }
    if cfg!(unix) {
        for name in ["history.csv", "summary.json", "run.jsonl", "estar.log", "results.pvd", "estar.lock"] {
            let path = workshop.path("deck").join(name);
            std::fs::remove_file(&path).unwrap();
            assert!(Command::new("mkfifo").arg(path).status().unwrap().success());
            let begin = Instant::now();
            viewer.state();
            viewer.get("/history.json").json();
            assert!(begin.elapsed() < Duration::from_secs(2), "{name}");
        }
    }
}

#[test]
fn what_is_not_there_yet_or_cut_short_is_waited_for() {
    let workshop = Workshop::new();
    std::fs::create_dir(workshop.path("empty")).unwrap();
    let viewer = Viewer::of(&workshop, "empty");
    let state = viewer.state();
    assert_eq!((&state["status"], state["notes"].as_array().unwrap().len()), (&"waiting".into(), 3));
    assert_eq!(viewer.get("/history.json").json()["rows"], 0);
    let answer = viewer.get("/surface");
    assert_eq!(answer.status, 404);
    assert!(answer.text().contains("waiting for the first frame"), "{}", answer.text());

    // a run comes, piece by piece
    run_box(&workshop);
    for (name, share) in
        [("history.csv", 0.5), ("results.pvd", 0.6), ("run.jsonl", 0.5), ("fields/frame_00000.vtu", 0.5)]
    {
        let whole = std::fs::read(workshop.path("deck").join(name)).unwrap();
        let part = workshop.path("empty").join(name);
        std::fs::create_dir_all(part.parent().unwrap()).unwrap();
        std::fs::write(part, &whole[..(whole.len() as f64 * share) as usize]).unwrap();
    }
    viewer.state();
    assert!(viewer.get("/history.json").json()["rows"].as_u64().unwrap() > 0);
    assert_eq!(viewer.get("/surface?frame=0").status, 404);
    for name in ["history.csv", "results.pvd", "run.jsonl", "summary.json"] {
        std::fs::copy(workshop.path("deck").join(name), workshop.path("empty").join(name)).unwrap();
    }
    for entry in std::fs::read_dir(workshop.path("deck/fields")).unwrap() {
        let entry = entry.unwrap();
        std::fs::copy(entry.path(), workshop.path("empty/fields").join(entry.file_name())).unwrap();
    }
    assert_eq!((&viewer.state()["status"], viewer.get("/surface").status), (&"finished".into(), 200));

    workshop.estar(&["view", "nowhere"]).assert(4, &["nowhere is no directory"]);
    workshop.estar(&["view", "deck.toml"]).assert(4, &["deck.toml is no directory"]);
    // the folder of the deck, where nothing would ever come
    workshop.estar(&["view", "."]).assert(2, &[". has no results of a run", "deck", "empty"]);
}

/// A box of more hexes that takes some seconds.
fn long_deck(workshop: &Workshop) -> String {
    let cells = ["--cells", "12", "12", "12"];
    let made = workshop.estar(&[&["mesh", "box", "--output", "long.msh"][..], &cells[..]].concat());
    assert_eq!(made.code, 0, "{}", made.errors);
    DECK.replace("box.msh", "long.msh")
        .replace("\"20 ms\"", "\"1 s\"")
        .replace("history_steps = 2", "history_steps = 20")
}

#[test]
fn a_watched_run_is_shown_while_it_runs_and_ends_as_any_other() {
    let workshop = Workshop::new();
    workshop.write("deck.toml", &long_deck(&workshop));
    let steps = ["--stop-at-step", "1500"];
    let plain = workshop.estar(&[&["run", "deck.toml", "--output", "plain"], &steps[..]].concat());
    plain.assert(0, &[]);

    let mut command = Command::new(env!("CARGO_BIN_EXE_estar"));
    command.args(["run", "deck.toml", "--output", "watched", "--watch"]).args(steps);
    let mut process =
        command.current_dir(workshop.directory.path()).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    let mut errors = BufReader::new(process.stderr.take().unwrap());
    let mut line = String::new();
    errors.read_line(&mut line).unwrap();
    let (port, key) = address_in(&line);
    let get = |target: &str| ask(port, &format!("GET {key}{target} HTTP/1.1\r\nHost: 127.0.0.1:{port}\r\n\r\n"));

    let mut seen = Vec::new();
    let begin = Instant::now();
    loop {
        let state = get("/state.json").json();
        let status = state["status"].as_str().unwrap().to_owned();
        if state["frames"].as_u64().unwrap() > 0 {
            get("/history.json").json();
            assert_eq!(get("/surface").status, 200);
        }
        let has_ended = !["waiting", "running"].contains(&status.as_str());
        seen.push(status);
        // the page is told how the run ended before the program ends
        if has_ended {
            break;
        }
        assert!(begin.elapsed() < Duration::from_secs(120), "{seen:?}");
        std::thread::sleep(Duration::from_millis(50));
    }
    let watched = process.wait_with_output().unwrap();
    assert!(seen.contains(&"running".to_owned()), "{seen:?}");
    assert_eq!(seen.last().unwrap(), "stopped");
    let mut rest = String::new();
    errors.read_to_string(&mut rest).unwrap();
    assert_eq!((watched.status.code(), rest), (Some(0), plain.errors.clone()));

    let summary =
        |name: &str| -> Value { serde_json::from_str(&workshop.read(&format!("{name}/summary.json"))).unwrap() };
    assert_eq!(summary("plain")["state_hash"], summary("watched")["state_hash"]);
    assert_eq!(workshop.read("plain/history.csv"), workshop.read("watched/history.csv"));
    // the same words but for times and the directory
    let words = |text: &str| {
        let lines = text.lines().filter(|line| !line.contains("steps/s") && !line.contains("results.pvd"));
        lines.map(str::to_owned).collect::<Vec<_>>()
    };
    assert_eq!(words(&String::from_utf8_lossy(&watched.stdout)), words(&plain.text));
    // the page has left nothing behind
    let files = |name: &str| {
        let entries = std::fs::read_dir(workshop.path(name)).unwrap();
        let mut names: Vec<_> = entries.map(|entry| entry.unwrap().file_name()).collect();
        names.sort();
        names
    };
    assert_eq!(files("plain"), files("watched"));
}

#[test]
fn a_watched_run_that_nobody_looks_at_ends_at_once_and_fails_as_any_other() {
    let workshop = Workshop::new();
    let missed = format!("{PROBE}\n[[expect]]\nprobe = \"place\"\nat = \"end\"\nvalue = 2.0\ntolerance = 1e-6\n");
    let begin = Instant::now();
    let said = workshop.run(&missed, &["--quiet", "--watch"]);
    said.assert(5, &["watch this run at http://127.0.0.1:", "1 of 2 expectations missed"]);
    assert_eq!(said.text, "");
    assert!(begin.elapsed() < Duration::from_secs(30));
}

#[test]
#[cfg(unix)]
fn a_killed_run_is_told_from_one_that_runs() {
    let workshop = Workshop::new();
    workshop.write("deck.toml", &long_deck(&workshop));
    let mut process = workshop.start(&["run", "deck.toml", "--quiet"]);
    workshop.wait_for("deck/run.jsonl");
    let viewer = Viewer::of(&workshop, "deck");
    assert_eq!(viewer.state()["status"], "running");
    process.kill().unwrap();
    process.wait().unwrap();
    let expected = if cfg!(target_os = "linux") { "killed" } else { "running" };
    assert_eq!(viewer.state()["status"], expected);
}

/// A browser without a window, which is told what to do by its DevTools protocol: messages of JSON that end with a zero byte, to its
/// file descriptor 3 and from its descriptor 4.
#[cfg(unix)]
struct Browser {
    process: Child,
    to: ChildStdin,
    from: BufReader<ChildStdout>,
    session: Option<String>,
    count: u64,
    /// Errors that pages have had.
    errors: Vec<String>,
}

#[cfg(unix)]
impl Browser {
    const PATIENCE: Duration = Duration::from_secs(60);

    /// None where no browser is installed.
    fn start(workshop: &Workshop) -> Option<Self> {
        let names = ["chromium", "chromium-browser", "google-chrome"];
        let has =
            |name: &&str| Command::new(name).arg("--version").output().is_ok_and(|output| output.status.success());
        let Some(name) = names.into_iter().find(has) else {
            eprintln!("skipped: no Chromium is installed (apt-get install chromium)");
            return None;
        };
        let mut command = Command::new("sh");
        command.args(["-c", "exec \"$0\" \"$@\" 3<&0 4>&1 0</dev/null 1>/dev/null", name]);
        command.args(["--headless", "--no-sandbox", "--disable-dev-shm-usage", "--no-first-run", "--hide-scrollbars"]);
        command.args(["--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"]);
        command.args(["--window-size=1400,1000", "--remote-debugging-pipe"]);
        command.arg(format!("--user-data-dir={}", workshop.path("profile").display()));
        let mut process = command.stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::null()).spawn().unwrap();
        let (to, from) = (process.stdin.take().unwrap(), BufReader::new(process.stdout.take().unwrap()));
        Some(Self { process, to, from, session: None, count: 0, errors: Vec::new() })
    }

    fn open(&mut self, port: u16, key: &str) {
        let page = self.tell("Target.createTarget", json!({ "url": "about:blank" }));
        let attached = json!({ "targetId": page["targetId"], "flatten": true });
        self.session = self.tell("Target.attachToTarget", attached)["sessionId"].as_str().map(str::to_owned);
        for domain in ["Page.enable", "Runtime.enable", "Log.enable"] {
            self.tell(domain, json!({}));
        }
        self.tell("Page.navigate", json!({ "url": format!("http://127.0.0.1:{port}{key}/") }));
    }

    /// What a method answers.
    fn tell(&mut self, method: &str, parameters: Value) -> Value {
        self.count += 1;
        let mut message = json!({ "id": self.count, "method": method, "params": parameters });
        if let Some(session) = &self.session {
            message["sessionId"] = session.as_str().into();
        }
        self.to.write_all(format!("{message}\0").as_bytes()).unwrap();
        loop {
            let mut bytes = Vec::new();
            self.from.read_until(0, &mut bytes).unwrap();
            assert_eq!(bytes.pop(), Some(0), "the browser has ended");
            let answer: Value = serde_json::from_slice(&bytes).unwrap();
            let told = &answer["params"];
            match answer["method"].as_str() {
                Some("Runtime.exceptionThrown") => self.errors.push(told["exceptionDetails"].to_string()),
                Some("Log.entryAdded") if told["entry"]["level"] == "error" => {
                    self.errors.push(told["entry"].to_string())
                }
                _ if answer["id"] == self.count => {
                    assert!(answer["error"].is_null(), "{method}: {answer}");
                    return answer["result"].clone();
                }
                _ => {}
            }
        }
    }

    fn value(&mut self, expression: &str) -> Value {
        let told = self.tell("Runtime.evaluate", json!({ "expression": expression, "returnByValue": true }));
        assert!(told["exceptionDetails"].is_null(), "{expression}: {told}");
        told["result"]["value"].clone()
    }

    /// Waits until an expression is true of the page.
    #[track_caller]
    fn wait_until(&mut self, expression: &str) {
        let begin = Instant::now();
        while self.value(expression) != true {
            let seen = self.value("document.body.innerText");
            assert!(begin.elapsed() < Self::PATIENCE, "never {expression}\n{:?}\n{seen}", self.errors.last());
            std::thread::sleep(Duration::from_millis(50));
        }
        // what was asked for is drawn with the next picture
        self.tell(
            "Runtime.evaluate",
            json!({
                "expression": "new Promise((drawn) => requestAnimationFrame(() => requestAnimationFrame(drawn)))",
                "awaitPromise": true,
            }),
        );
    }

    fn text(&mut self) -> String {
        self.value("document.body.innerText").as_str().unwrap().to_owned()
    }

    fn mouse(&mut self, kind: &str, at: [f64; 2], more: Value) {
        let mut event =
            json!({ "type": kind, "x": at[0], "y": at[1], "button": "left", "buttons": 1, "clickCount": 1 });
        event.as_object_mut().unwrap().extend(more.as_object().unwrap().clone());
        self.tell("Input.dispatchMouseEvent", event);
    }

    fn drag(&mut self, from: [f64; 2], by: [f64; 2], more: &Value) {
        let to = [from[0] + by[0], from[1] + by[1]];
        self.mouse("mousePressed", from, more.clone());
        self.mouse("mouseMoved", to, more.clone());
        self.mouse("mouseReleased", to, more.clone());
        self.wait_until("true");
    }

    fn press(&mut self, key: &str) {
        self.tell("Input.dispatchKeyEvent", json!({ "type": "keyDown", "key": key, "text": key }));
        self.tell("Input.dispatchKeyEvent", json!({ "type": "keyUp", "key": key }));
        self.wait_until("true");
    }

    /// The picture of an element.
    fn picture(&mut self, id: &str) -> Picture {
        let place = self.value(&format!(
            "(({{x, y, width, height}}) => ({{x, y, width, height, scale: 1}}))(document.getElementById('{id}').getBoundingClientRect())"
        ));
        let picture = self.tell("Page.captureScreenshot", json!({ "format": "png", "clip": place }));
        Picture::of(&STANDARD.decode(picture["data"].as_str().unwrap()).unwrap())
    }
}

#[cfg(unix)]
impl Drop for Browser {
    fn drop(&mut self) {
        let _ = self.process.kill();
        let _ = self.process.wait();
    }
}

#[cfg(unix)]
#[derive(PartialEq)]
struct Picture {
    width: usize,
    pixels: Vec<[u8; 3]>,
}

#[cfg(unix)]
impl Picture {
    fn of(png: &[u8]) -> Self {
        let mut reader = png::Decoder::new(png).read_info().unwrap();
        let mut bytes = vec![0; reader.output_buffer_size()];
        let info = reader.next_frame(&mut bytes).unwrap();
        let parts = info.color_type.samples();
        assert!(parts >= 3, "{:?}", info.color_type);
        let pixels = bytes[..info.buffer_size()].chunks_exact(parts).map(|pixel| [pixel[0], pixel[1], pixel[2]]);
        Self { width: info.width as usize, pixels: pixels.collect() }
    }

    /// Number of pixels of a kind, and where their middle is.
    fn share(&self, is_such: impl Fn([u8; 3]) -> bool) -> (usize, [f64; 2]) {
        let (mut count, mut sum) = (0, [0.0; 2]);
        for (index, _) in self.pixels.iter().enumerate().filter(|(_, pixel)| is_such(**pixel)) {
            count += 1;
            sum = [sum[0] + (index % self.width) as f64, sum[1] + (index / self.width) as f64];
        }
        (count, sum.map(|sum| sum / f64::max(count as f64, 1.0)))
    }

    /// The body of one value: the red in the middle of the colours, in light and in shade.
    fn body(&self) -> (usize, [f64; 2]) {
        self.share(|[red, green, blue]| red > 110 && green < 150 && blue < 110)
    }
}

#[test]
#[cfg(unix)]
fn chromium_shows_progress_curves_and_a_body_that_turns_with_the_mouse() {
    let workshop = Workshop::new();
    let Some(mut browser) = Browser::start(&workshop) else { return };
    run_box(&workshop);
    let viewer = Viewer::of(&workshop, "deck");
    browser.open(viewer.port, &viewer.key);
    browser.wait_until("document.getElementById('scene')?.dataset.frame === '4'");
    let text = browser.text();
    let hash = workshop.summary()["state_hash"].as_str().unwrap().to_owned();
    for part in [
        // the title is words and no markup
        "A box <b>flies</b> & lands",
        "finished",
        "100.0 %",
        "energy error",
        "0.02 of 0.02 s",
        "kinetic energy",
        "expected of",
        "5 of 5",
        "equivalent plastic strain",
        &hash,
    ] {
        assert!(text.contains(part), "no {part:?} in\n{text}");
    }
    browser.wait_until("document.querySelector('[aria-label=\"place over time\"]') !== null");
    // lines in the blue of the first curve
    let is_blue = |[red, green, blue]: [u8; 3]| blue > 150 && red < 60 && (90..150).contains(&green);
    let curves = browser.picture("curves").share(is_blue).0;
    assert!(curves > 200, "{curves} pixels of curves");

    let iso = browser.picture("scene");
    let (size, middle) = iso.body();
    assert!(size > 20_000, "{size} pixels of a body");
    let pressed = "document.querySelector('[data-view][aria-pressed=true]')?.dataset.view ?? ''";
    assert_eq!(browser.value(pressed), "iso");
    let place = browser.value("(({x, y}) => [x, y])(document.getElementById('scene').getBoundingClientRect())");
    let at = [place[0].as_f64().unwrap() + middle[0], place[1].as_f64().unwrap() + middle[1]];
    browser.drag(at, [80.0, 40.0], &json!({}));
    assert!(browser.picture("scene") != iso, "it has not turned");
    assert_eq!(browser.value(pressed), "");
    // back by the keyboard
    browser.value("document.getElementById('scene').focus()");
    browser.press("x");
    assert_eq!(browser.value(pressed), "x");
    browser.press("i");
    assert_eq!(browser.value(pressed), "iso");
    browser.value("document.getElementById('scene').blur()");
    browser.wait_until("true");
    assert!(browser.picture("scene") == iso, "it is not back");
    // the wheel zooms, shift and the right button move
    browser.mouse("mouseWheel", at, json!({ "deltaX": 0, "deltaY": 150, "buttons": 0, "button": "none" }));
    browser.wait_until("true");
    let (smaller, before) = browser.picture("scene").body();
    assert!((smaller as f64) < 0.7 * size as f64, "{size} {smaller}");
    browser.drag(at, [30.0, 20.0], &json!({ "modifiers": 8 }));
    browser.drag(at, [30.0, 20.0], &json!({ "button": "right", "buttons": 2 }));
    let (same, after) = browser.picture("scene").body();
    assert!(same.abs_diff(smaller) < smaller / 50, "{smaller} {same}");
    let by = [after[0] - before[0], after[1] - before[1]];
    assert!((by[0] - 60.0).abs() < 3.0 && (by[1] - 40.0).abs() < 3.0, "{by:?}");

    // another field and an earlier frame
    let choose = |id: &str, value: &str, event: &str| {
        format!(
            "{{ const at = document.getElementById('{id}'); at.value = '{value}'; at.dispatchEvent(new Event('{event}')) }}"
        )
    };
    browser.value(&choose("field", "velocity", "change"));
    browser.wait_until("document.getElementById('quantity').innerText === 'velocity [m/s]'");
    browser.value(&choose("component", "x", "change"));
    browser.wait_until("document.getElementById('quantity').innerText === 'velocity x [m/s]'");
    browser.value(&choose("frame", "1", "input"));
    browser.wait_until("document.getElementById('scene').dataset.frame === '1'");
    assert!(browser.text().contains("2 of 5"));

    let ground = "getComputedStyle(document.body).backgroundColor.match(/\\d+/g).map(Number)[0]";
    assert!(browser.value(ground).as_u64().unwrap() > 200);
    let dark = json!({ "features": [{ "name": "prefers-color-scheme", "value": "dark" }] });
    browser.tell("Emulation.setEmulatedMedia", dark);
    assert!(browser.value(ground).as_u64().unwrap() < 50);
    assert_eq!(browser.errors, Vec::<String>::new());
}

#[test]
#[cfg(unix)]
fn chromium_follows_a_watched_run_to_its_end() {
    let workshop = Workshop::new();
    let Some(mut browser) = Browser::start(&workshop) else { return };
    workshop.write("deck.toml", &long_deck(&workshop));
    let mut process = workshop.start(&["run", "deck.toml", "--watch", "--set", "time.end=\"3 s\""]);
    let mut errors = BufReader::new(process.stderr.take().unwrap());
    let mut line = String::new();
    errors.read_line(&mut line).unwrap();
    let (port, key) = address_in(&line);
    browser.open(port, &key);
    browser.wait_until("document.getElementById('status')?.innerText === 'running'");
    browser.wait_until("document.getElementById('scene').dataset.frame !== undefined");
    browser.wait_until("document.getElementById('status').innerText === 'finished'");
    assert!(process.wait().unwrap().success());
    browser.wait_until("document.getElementById('notes').innerText.includes('has ended')");
    let text = browser.text();
    for part in ["finished at t = 3 s", "5 of 5", "100.0 %", "What is shown stays"] {
        assert!(text.contains(part), "no {part:?} in\n{text}");
    }
    assert!(browser.picture("scene").body().0 > 20_000);
}
