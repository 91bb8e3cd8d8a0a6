//! As much of HTTP/1.1 as one page of fixed parts needs: one request a connection, GET and HEAD, no bodies of requests. Whatever
//! else comes is refused with a status that says why; every wait has an end and every buffer a size.

use std::io::{self, ErrorKind, Read, Write};
use std::net::{Shutdown, TcpStream};
use std::sync::Arc;
use std::time::{Duration, Instant};

/// A request must be here within this time.
const READ_TIME: Duration = Duration::from_secs(5);
/// An answer must be taken within this time.
const WRITE_TIME: Duration = Duration::from_secs(60);
/// What a client still sends after its request is read for so long, so that it sees the answer and no reset.
const DRAIN_TIME: Duration = Duration::from_millis(300);
/// Bytes of the longest request.
const LONGEST_HEAD: usize = 16 * 1024;
/// Headers of the longest request.
const MOST_HEADERS: usize = 64;
/// Bytes written between two looks at the clock.
const PIECE: usize = 64 * 1024;

/// Headers of every answer. Nothing but what this address serves is loaded, run, framed or sent to; nothing is kept.
const HEADERS: &str = "Content-Security-Policy: default-src 'none'; script-src 'self'; style-src 'self'; connect-src 'self'; \
img-src 'self'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'\r\n\
X-Content-Type-Options: nosniff\r\n\
Cross-Origin-Resource-Policy: same-origin\r\n\
Cross-Origin-Opener-Policy: same-origin\r\n\
Referrer-Policy: no-referrer\r\n\
Cache-Control: no-store\r\n\
Connection: close\r\n";

/// What is asked for.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Request {
    /// Whether only the head of the answer is wanted.
    pub is_head: bool,
    /// The path of the address behind the key.
    pub path: String,
    /// Names and values behind the question mark.
    pub query: Vec<(String, String)>,
}

impl Request {
    /// A value by its name.
    pub fn value(&self, name: &str) -> Option<&str> {
        self.query.iter().find(|(known, _)| known == name).map(|(_, value)| value.as_str())
    }
}

/// What is answered.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Response {
    /// Status with its reason.
    pub status: &'static str,
    /// Media type.
    pub kind: &'static str,
    /// The content.
    pub body: Arc<[u8]>,
}

/// Media type of words.
const TEXT: &str = "text/plain; charset=utf-8";

impl Response {
    /// What was asked for.
    pub fn found(kind: &'static str, body: impl Into<Arc<[u8]>>) -> Self {
        Self { status: "200 OK", kind, body: body.into() }
    }

    /// A refusal with its reason.
    pub fn refusal(status: &'static str, reason: &str) -> Self {
        Self { status, kind: TEXT, body: format!("{reason}\n").into_bytes().into() }
    }

    /// Writes the answer, within its time.
    ///
    /// # Errors
    /// The client does not take it.
    pub fn write(&self, stream: &mut TcpStream, is_head: bool) -> io::Result<()> {
        let Self { status, kind, body } = self;
        let allow = if status.starts_with("405") { "Allow: GET, HEAD\r\n" } else { "" };
        let length = body.len();
        let head =
            format!("HTTP/1.1 {status}\r\nContent-Type: {kind}\r\nContent-Length: {length}\r\n{allow}{HEADERS}\r\n");
        let end = Instant::now() + WRITE_TIME;
        let body: &[u8] = if is_head { &[] } else { body };
        for piece in std::iter::once(head.as_bytes()).chain(body.chunks(PIECE)) {
            stream.set_write_timeout(Some(left(end)?))?;
            stream.write_all(piece)?;
        }
        Ok(())
    }
}

/// The time to a moment.
fn left(end: Instant) -> io::Result<Duration> {
    let left = end.saturating_duration_since(Instant::now());
    if left.is_zero() { Err(ErrorKind::TimedOut.into()) } else { Ok(left) }
}

/// Reads a request to one of these hosts by one who knows the key, which the path begins with.
///
/// # Errors
/// The answer to what is no such request; none where nobody waits for one.
pub fn read(stream: &mut TcpStream, hosts: &[String], key: &str) -> Result<Request, Option<Response>> {
    let end = Instant::now() + READ_TIME;
    let mut head = Vec::new();
    loop {
        let mut piece = [0; 2048];
        let wait = left(end).and_then(|left| stream.set_read_timeout(Some(left)));
        match wait.and_then(|()| stream.read(&mut piece)) {
            Ok(0) => return Err(None),
            Ok(count) => head.extend_from_slice(&piece[..count]),
            Err(error) if error.kind() == ErrorKind::Interrupted => continue,
            Err(error) if matches!(error.kind(), ErrorKind::TimedOut | ErrorKind::WouldBlock) => {
                let late = Response::refusal("408 Request Timeout", "the request did not come to its end");
                return Err(Some(late).filter(|_| !head.is_empty()));
            }
            Err(_) => return Err(None),
        }
        match parse(&head, hosts, key) {
            Ok(Some(request)) => return Ok(request),
            Ok(None) if head.len() > LONGEST_HEAD => {
                return Err(Some(Response::refusal("431 Request Header Fields Too Large", "the request is too long")));
            }
            Ok(None) => {}
            Err(refusal) => return Err(Some(refusal)),
        }
    }
}

/// Ends a connection once the answer is written.
pub fn close(stream: &mut TcpStream) {
    let end = Instant::now() + DRAIN_TIME;
    // whether the client minds is its own affair
    let _ = stream.shutdown(Shutdown::Write);
    let mut rest = [0; 4096];
    while let Ok(left) = left(end) {
        let read = stream.set_read_timeout(Some(left)).and_then(|()| stream.read(&mut rest));
        if !matches!(read, Ok(count) if count > 0) {
            break;
        }
    }
}

/// A request from its bytes; none while they are only its beginning.
///
/// # Errors
/// The answer to what is no request to one of these hosts.
fn parse(bytes: &[u8], hosts: &[String], key: &str) -> Result<Option<Request>, Response> {
    let malformed = |what: &str| Response::refusal("400 Bad Request", what);
    let mut headers = [httparse::EMPTY_HEADER; MOST_HEADERS];
    let mut parsed = httparse::Request::new(&mut headers);
    match parsed.parse(bytes) {
        Ok(httparse::Status::Complete(_)) => {}
        Ok(httparse::Status::Partial) => return Ok(None),
        Err(httparse::Error::TooManyHeaders) => {
            return Err(Response::refusal("431 Request Header Fields Too Large", "the request has too many headers"));
        }
        Err(_) => return Err(malformed("this is no request of HTTP/1.1")),
    }
    let values = |name: &str| -> Vec<&[u8]> {
        let named = parsed.headers.iter().filter(|header| header.name.eq_ignore_ascii_case(name));
        named.map(|header| header.value).collect()
    };
    // a page elsewhere whose name was made to lead here is not to read what is served here
    let is_ours = |host: &[u8]| hosts.iter().any(|ours| host.eq_ignore_ascii_case(ours.as_bytes()));
    match values("Host")[..] {
        [host] if is_ours(host) => {}
        [_] => {
            return Err(Response::refusal("403 Forbidden", &format!("this is the host {} only", hosts.join(" or "))));
        }
        _ => return Err(malformed("a request names one host")),
    }
    let is_head = match parsed.method {
        Some("GET") => false,
        Some("HEAD") => true,
        _ => return Err(Response::refusal("405 Method Not Allowed", "this page is only looked at")),
    };
    let is_empty = |length: &&[u8]| length.trim_ascii() == b"0";
    if !values("Transfer-Encoding").is_empty() || !values("Content-Length").iter().all(is_empty) {
        return Err(malformed("a request here has no content"));
    }
    let target = parsed.path.unwrap_or("");
    let (path, query) = target.split_once('?').unwrap_or((target, ""));
    let is_plain = |byte: u8| byte.is_ascii_alphanumeric() || b"/._-=&".contains(&byte);
    if !path.starts_with('/') || !path.bytes().chain(query.bytes()).all(is_plain) {
        return Err(malformed("the address has signs that none of this page has"));
    }
    let path = behind(path, key).ok_or_else(|| Response::refusal("404 Not Found", "the page has no such part"))?;
    let pair = |piece: &str| piece.split_once('=').map(|(name, value)| (name.to_owned(), value.to_owned()));
    // browsers say whose page asks; one of another site may lead here, but is given no work to do
    let is_of_others = |site: &&[u8]| !matches!(site.trim_ascii(), b"same-origin" | b"none");
    if path != "/" && values("Sec-Fetch-Site").iter().any(is_of_others) {
        return Err(Response::refusal("403 Forbidden", "this is asked for by another page"));
    }
    let query: Option<Vec<_>> = query.split('&').filter(|piece| !piece.is_empty()).map(pair).collect();
    let query = query.ok_or_else(|| malformed("the address asks without a value"))?;
    Ok(Some(Request { is_head, path: path.to_owned(), query }))
}

/// The rest of a path that begins with the key. How much of it is wrong cannot be told from the time that this takes.
fn behind<'a>(path: &'a str, key: &str) -> Option<&'a str> {
    let (own, rest) = path.split_at_checked(key.len())?;
    let difference = own.bytes().zip(key.bytes()).fold(0, |sum, (own, key)| sum | (own ^ key));
    (difference == 0 && rest.starts_with('/')).then_some(rest)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn asked(text: &str) -> Result<Option<Request>, &'static str> {
        asked_with(text, "")
    }

    fn asked_with(text: &str, key: &str) -> Result<Option<Request>, &'static str> {
        let hosts = ["127.0.0.1:8000", "localhost:8000"].map(str::to_owned);
        parse(text.as_bytes(), &hosts, key).map_err(|refusal| &refusal.status[..3])
    }

    #[test]
    fn a_request_is_known_when_it_is_whole() {
        let whole = "GET /body?field=velocity&component=x HTTP/1.1\r\nHost: LocalHost:8000\r\nAccept: */*\r\n\r\n";
        for end in 0..whole.len() {
            assert_eq!(asked(&whole[..end]), Ok(None), "{end}");
        }
        let request = asked(whole).unwrap().unwrap();
        assert_eq!(
            (request.path.as_str(), request.value("field"), request.is_head),
            ("/body", Some("velocity"), false)
        );
        assert_eq!(request.value("frame"), None);
        for site in ["/ HTTP/1.1\r\nSec-Fetch-Site: cross-site", "/page.js HTTP/1.1\r\nSec-Fetch-Site: same-origin"] {
            assert!(asked(&format!("GET {site}\r\nHost: localhost:8000\r\n\r\n")).unwrap().is_some(), "{site}");
        }
        assert!(asked("HEAD / HTTP/1.1\r\nHost: 127.0.0.1:8000\r\n\r\n").unwrap().unwrap().is_head);
    }

    #[test]
    fn a_request_has_the_key() {
        let path = |path: &str, site: &str| {
            let text = format!("GET {path} HTTP/1.1\r\nHost: localhost:8000\r\nSec-Fetch-Site: {site}\r\n\r\n");
            asked_with(&text, "/0a1b").map(|request| request.unwrap().path)
        };
        assert_eq!(path("/0a1b/", "cross-site").unwrap(), "/");
        assert_eq!(path("/0a1b/page.js", "same-origin").unwrap(), "/page.js");
        assert_eq!(path("/0a1b/page.js", "cross-site"), Err("403"));
        for wrong in ["/", "/page.js", "/0a1b", "/0a1", "/0a1c/", "/0A1B/", "/0a1b0/", "/0a1bpage.js", "//0a1b/"] {
            assert_eq!(path(wrong, "same-origin"), Err("404"), "{wrong}");
        }
    }

    #[test]
    fn what_is_no_request_to_this_page_is_refused() {
        let host = "Host: 127.0.0.1:8000\r\n";
        for (text, status) in [
            ("GET / HTTP/1.1\r\nHost: example.org\r\n\r\n".to_owned(), "403"),
            ("GET / HTTP/1.1\r\nHost: 127.0.0.1:8001\r\n\r\n".to_owned(), "403"),
            ("GET / HTTP/1.1\r\nHost: 127.0.0.1\r\n\r\n".to_owned(), "403"),
            ("GET / HTTP/1.1\r\n\r\n".to_owned(), "400"),
            (format!("GET / HTTP/1.1\r\n{host}{host}\r\n"), "400"),
            (format!("GET /surface HTTP/1.1\r\n{host}Sec-Fetch-Site: cross-site\r\n\r\n"), "403"),
            (format!("GET /surface HTTP/1.1\r\n{host}Sec-Fetch-Site: same-site\r\n\r\n"), "403"),
            (format!("POST / HTTP/1.1\r\n{host}\r\n"), "405"),
            (format!("get / HTTP/1.1\r\n{host}\r\n"), "405"),
            (format!("GET / HTTP/1.1\r\n{host}Content-Length: 7\r\n\r\n"), "400"),
            (format!("GET / HTTP/1.1\r\n{host}Transfer-Encoding: chunked\r\n\r\n"), "400"),
            (format!("GET http://127.0.0.1:8000/ HTTP/1.1\r\n{host}\r\n"), "400"),
            (format!("GET /body?field=%2e%2e HTTP/1.1\r\n{host}\r\n"), "400"),
            (format!("GET /body?field HTTP/1.1\r\n{host}\r\n"), "400"),
            (format!("GET / HTTP/7.1\r\n{host}\r\n"), "400"),
            (format!("GET / HTTP/1.1\r\n{host}{}\r\n", "A: b\r\n".repeat(80)), "431"),
            ("\u{1}\u{2}\u{3}".to_owned(), "400"),
        ] {
            assert_eq!(asked(&text), Err(status), "{text:?}");
        }
    }
}
