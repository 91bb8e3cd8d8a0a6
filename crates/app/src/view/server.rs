//! Serves the page on this machine, and on no other address, to those who know its key: a thread that listens, and one for each connection, of which there
//! are never many.

use super::http::{self, Request, Response};
use super::results::Results;
use std::io;
use std::net::{Ipv4Addr, SocketAddr, TcpListener, TcpStream};
use std::path::Path;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread;
use std::time::{Duration, Instant};

/// Connections at one time; a browser has six.
const MOST_CONNECTIONS: usize = 32;
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

/// Counts a connection as long as it lives.
struct Ticket(Arc<Shared>);

impl Ticket {
    /// None where there are too many.
    fn of(shared: &Arc<Shared>) -> Option<Self> {
        let ticket = Self(Arc::clone(shared));
        (shared.connections.fetch_add(1, Ordering::AcqRel) < MOST_CONNECTIONS).then_some(ticket)
    }
}

impl Drop for Ticket {
    fn drop(&mut self) {
        self.0.connections.fetch_sub(1, Ordering::AcqRel);
    }
}

fn listen(listener: &TcpListener, shared: &Arc<Shared>) {
    while !shared.is_stopping.load(Ordering::Acquire) {
        let Ok((mut stream, _)) = listener.accept() else {
            // a client that gave up, or no file left: both pass
            thread::sleep(PAUSE);
            continue;
        };
        match Ticket::of(shared) {
            Some(ticket) => {
                let serve = move || serve(stream, &ticket.0);
                // without a thread the connection is closed, and the page asks again
                let _ = thread::Builder::new().name("view-answer".to_owned()).spawn(serve);
            }
            None => {
                let full = Response::refusal("503 Service Unavailable", "too many connections");
                // short enough for the system's own buffer, so that nobody is waited for
                let _ = full.write(&mut stream, false);
            }
        }
    }
}

fn serve(mut stream: TcpStream, shared: &Shared) {
    let (is_head, response) = match http::read(&mut stream, &shared.hosts, &shared.key) {
        Ok(request) => (request.is_head, shared.answer(&request)),
        Err(Some(refusal)) => (false, refusal),
        Err(None) => return,
    };
    if response.write(&mut stream, is_head).is_ok() {
        http::close(&mut stream);
    }
}

impl Shared {
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
