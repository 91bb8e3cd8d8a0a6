//! Serves the page on this machine, and on no other address, to those who know its key: a thread that listens, and one for each
//! connection, of which there are never many.
//!
//! Whoever has an account on this machine can connect. A connection is a stranger's until its request has shown the key; of strangers
//! there are so many at a time, and when another comes the one that has waited longest is closed. Those who know the key ask at once,
//! and have places of their own afterwards, so that strangers who say nothing keep nobody out.

use super::http::{self, Request, Response};
use super::results::Results;
use std::collections::VecDeque;
use std::io;
use std::net::{Ipv4Addr, Shutdown, SocketAddr, TcpListener, TcpStream};
use std::path::Path;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread;
use std::time::{Duration, Instant};

/// Connections at one time of those who have shown the key; a browser has six.
const MOST_CONNECTIONS: usize = 24;
/// Connections at one time whose request is not read yet.
const MOST_STRANGERS: usize = 16;
/// After a connection that could not be accepted.
const PAUSE: Duration = Duration::from_millis(50);
/// A page that has not asked for so long is closed.
const PAGE_IS_CLOSED: Duration = Duration::from_secs(4);

/// The page that shows a directory, served until this is dropped.
#[derive(Debug)]
pub struct Server {
    address: SocketAddr,
    shared: Arc<Shared>,
}

#[derive(Debug)]
struct Shared {
    results: Results,
    hosts: [String; 2],
    /// What the paths of all parts begin with.
    key: String,
    is_stopping: AtomicBool,
    connections: AtomicUsize,
    strangers: Mutex<Strangers>,
    asked: Mutex<Asked>,
}

/// When a page last asked.
#[derive(Clone, Copy, Debug, Default)]
struct Asked {
    at: Option<Instant>,
    /// Whether it has been told that the run has ended.
    knows_end: bool,
}

impl Server {
    /// Begins to serve what is in a directory, on a port that the system chooses.
    ///
    /// # Errors
    /// What the system says.
    pub fn start(directory: &Path) -> io::Result<Self> {
        let listener = TcpListener::bind((Ipv4Addr::LOCALHOST, 0))?;
        let address = listener.local_addr()?;
        let port = address.port();
        let key = key()?;
        let shared = Arc::new(Shared {
            results: Results::of(directory),
            hosts: [format!("127.0.0.1:{port}"), format!("localhost:{port}")],
            key,
            is_stopping: AtomicBool::new(false),
            connections: AtomicUsize::new(0),
            strangers: Mutex::default(),
            asked: Mutex::default(),
        });
        let own = Arc::clone(&shared);
        thread::Builder::new().name("view".to_owned()).spawn(move || listen(&listener, &own))?;
        Ok(Self { address, shared })
    }

    /// Where a browser finds the page.
    pub fn address(&self) -> String {
        format!("http://{}{}/", self.address, self.shared.key)
    }

    /// Waits until a page that is open has been told how the run ended, but not longer than this.
    pub fn tell_end(&self, at_most: Duration) {
        /// A page asks for what is new as soon as it knows of it.
        const QUIET: Duration = Duration::from_millis(250);
        let end = Instant::now() + at_most;
        while Instant::now() < end {
            let Asked { at, knows_end } = *self.shared.asked.lock().unwrap_or_else(PoisonError::into_inner);
            let is_idle = self.shared.connections.load(Ordering::Acquire) == 0;
            let silence = at.map(|at| at.elapsed());
            if silence.is_none_or(|silence| silence > PAGE_IS_CLOSED || (knows_end && is_idle && silence > QUIET)) {
                return;
            }
            thread::sleep(PAUSE);
        }
    }
}

impl Drop for Server {
    fn drop(&mut self) {
        self.shared.is_stopping.store(true, Ordering::Release);
        // the listener looks up when somebody comes
        let _ = TcpStream::connect_timeout(&self.address, PAUSE);
    }
}

/// A path that nobody guesses: whoever has an account on this machine can reach the port.
fn key() -> io::Result<String> {
    let mut bytes = [0; 16];
    getrandom::fill(&mut bytes).map_err(io::Error::other)?;
    Ok(format!("/{:032x}", u128::from_ne_bytes(bytes)))
}

/// Connections that have not shown the key yet, those that have waited longest first.
#[derive(Debug, Default)]
struct Strangers {
    last: u64,
    waiting: VecDeque<(u64, TcpStream)>,
}

impl Strangers {
    /// Takes one more, and closes the one that has waited longest if there are too many; by which number it is known.
    fn take(&mut self, stream: &TcpStream) -> io::Result<u64> {
        self.last += 1;
        self.waiting.push_back((self.last, stream.try_clone()?));
        if self.waiting.len() > MOST_STRANGERS
            && let Some((_, longest)) = self.waiting.pop_front()
        {
            // whoever reads from it meets its end
            let _ = longest.shutdown(Shutdown::Both);
        }
        Ok(self.last)
    }

    fn leave(&mut self, number: u64) {
        self.waiting.retain(|(known, _)| *known != number);
    }
}

/// Counts a connection that has shown the key, as long as it lives.
struct Ticket<'a>(&'a Shared);

impl<'a> Ticket<'a> {
    /// None where there are too many.
    fn of(shared: &'a Shared) -> Option<Self> {
        let ticket = Self(shared);
        (shared.connections.fetch_add(1, Ordering::AcqRel) < MOST_CONNECTIONS).then_some(ticket)
    }
}

impl Drop for Ticket<'_> {
    fn drop(&mut self) {
        self.0.connections.fetch_sub(1, Ordering::AcqRel);
    }
}

fn listen(listener: &TcpListener, shared: &Arc<Shared>) {
    while !shared.is_stopping.load(Ordering::Acquire) {
        let taken = listener.accept().and_then(|(stream, _)| {
            let number = shared.strangers().take(&stream)?;
            let own = Arc::clone(shared);
            let serve = move || {
                own.serve(stream, number);
                own.strangers().leave(number);
            };
            let spawned = thread::Builder::new().name("view-answer".to_owned()).spawn(serve);
            // without a thread the connection is closed, and the page asks again
            spawned.map(|_| ()).inspect_err(|_| shared.strangers().leave(number))
        });
        if taken.is_err() {
            // a client that gave up, or no file or thread left: all of them pass
            thread::sleep(PAUSE);
        }
    }
}

impl Shared {
    fn strangers(&self) -> MutexGuard<'_, Strangers> {
        self.strangers.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Answers a connection, which is known by a number among the strangers.
    fn serve(&self, mut stream: TcpStream, number: u64) {
        let asked = http::read(&mut stream, &self.hosts, &self.key);
        let ticket = asked.is_ok().then(|| {
            self.strangers().leave(number);
            Ticket::of(self)
        });
        let (is_head, response) = match (asked, &ticket) {
            (Ok(_), Some(None)) => (false, Response::refusal("503 Service Unavailable", "too many connections")),
            (Ok(request), _) => (request.is_head, self.answer(&request)),
            (Err(Some(refusal)), _) => (false, refusal),
            (Err(None), _) => return,
        };
        if response.write(&mut stream, is_head).is_ok() {
            http::close(&mut stream);
        }
    }

    /// The fixed parts of the page, and what they ask for. No file has its name from a request.
    fn answer(&self, request: &Request) -> Response {
        const HTML: &str = "text/html; charset=utf-8";
        const CSS: &str = "text/css; charset=utf-8";
        const SCRIPT: &str = "text/javascript; charset=utf-8";
        const JSON: &str = "application/json";
        let part = |kind: &'static str, text: &str| Response::found(kind, text.as_bytes());
        match request.path.as_str() {
            "/" => {
                self.note(false);
                part(HTML, include_str!("page.html"))
            }
            "/page.css" => part(CSS, include_str!("page.css")),
            "/page.js" => part(SCRIPT, include_str!("page.js")),
            "/body.js" => part(SCRIPT, include_str!("body.js")),
            "/curves.js" => part(SCRIPT, include_str!("curves.js")),
            "/icon.svg" => part("image/svg+xml", include_str!("icon.svg")),
            "/state.json" => {
                let state = self.results.state();
                self.note(state.has_ended());
                Response::found(JSON, state.json())
            }
            "/history.json" => Response::found(JSON, self.results.history()),
            "/surface" => match self.surface(request) {
                Ok(content) => Response::found("application/octet-stream", content),
                Err(reason) => Response::refusal("404 Not Found", &reason),
            },
            _ => Response::refusal("404 Not Found", "the page has no such part"),
        }
    }

    /// That a page is open, and whether it has been told the end.
    fn note(&self, knows_end: bool) {
        let mut asked = self.asked.lock().unwrap_or_else(PoisonError::into_inner);
        *asked = Asked { at: Some(Instant::now()), knows_end };
    }

    fn surface(&self, request: &Request) -> Result<Arc<[u8]>, String> {
        let frame = request.value("frame").map(|number| number.parse().map_err(|_| "a frame is a number"));
        self.results.surface(frame.transpose()?, request.value("field"), request.value("component"))
    }
}
