//! The page beside the table: served to this machine, or to the network where that is asked for.
//!
//! A token that nobody can guess is part of every address; requests of other pages (with a foreign `Origin`) are refused. What is shown is never
//! changed from the page.

use crate::bench::{Bench, Link};
use crate::error::{Fault, Malformed, Result};
use serde_json::json;
use std::hash::{BuildHasher, Hasher, RandomState};
use std::io::{BufRead, BufReader, Read, Write};
use std::net::{IpAddr, SocketAddr, TcpListener, TcpStream};
use std::sync::{Arc, Condvar, Mutex, PoisonError};
use std::time::{Duration, Instant};

const PAGE: &str = include_str!("../../../data/templates/guide.html");
/// Bytes of a request's head.
const HEAD: u64 = 16 << 10;
/// How long a request may take to arrive, and how often a page hears that the guide is still there.
const PATIENCE: Duration = Duration::from_secs(5);
const MOST: usize = 64;

/// The events so far, and who is listening.
#[derive(Default)]
struct Told {
    events: Vec<String>,
    /// The last of those that replace each other, and how many there were.
    latest: (String, usize),
    ended: bool,
    connections: usize,
}

type Shared = Arc<(Mutex<Told>, Condvar)>;

/// A page that is served while this lives.
pub(super) struct Page {
    shared: Shared,
    /// Where it is.
    pub address: String,
}

impl Page {
    /// Serve on a port (0: any that is free). Errors: an address that cannot be listened on.
    pub fn open(address: IpAddr, port: u16, bench: &Bench) -> Result<Self> {
        let fault = |error: std::io::Error| {
            Malformed::new(Fault::File, format!("the page cannot be served on {address}, port {port}: {error}"))
                .expected("an address of this machine and a port that is free, or --serve without a port")
        };
        let listener = TcpListener::bind(SocketAddr::new(address, port)).map_err(fault)?;
        let local = listener.local_addr().map_err(fault)?;
        let token = token();
        let shared: Shared = Shared::default();
        let page = Page { shared: shared.clone(), address: format!("http://{local}/{token}/") };
        page.publish("bench", &drawn(bench).to_string());
        std::thread::spawn(move || {
            for stream in listener.incoming().flatten() {
                let (shared, token) = (shared.clone(), token.clone());
                {
                    let mut state = shared.0.lock().unwrap_or_else(PoisonError::into_inner);
                    if state.connections >= MOST || state.ended {
                        continue;
                    }
                    state.connections += 1;
                }
                std::thread::spawn(move || {
                    // a page that was closed is no fault
                    let _ = answer(stream, &token, &shared);
                    shared.0.lock().unwrap_or_else(PoisonError::into_inner).connections -= 1;
                    shared.1.notify_all();
                });
            }
        });
        Ok(page)
    }

    /// What holds until the next one of its kind, or the next event.
    pub fn replace(&self, event: &str, data: &str) {
        let mut shared = self.shared.0.lock().unwrap_or_else(PoisonError::into_inner);
        shared.latest = (format!("event: {event}\ndata: {data}\n\n"), shared.latest.1 + 1);
        self.shared.1.notify_all();
    }

    /// One more event, for every page that is open or will be.
    pub fn publish(&self, event: &str, data: &str) {
        let mut shared = self.shared.0.lock().unwrap_or_else(PoisonError::into_inner);
        shared.events.push(format!("event: {event}\ndata: {data}\n\n"));
        shared.latest.0.clear();
        self.shared.1.notify_all();
    }
}

impl Drop for Page {
    /// Pages that are open hear the end.
    fn drop(&mut self) {
        self.publish("end", "{}");
        let mut shared = self.shared.0.lock().unwrap_or_else(PoisonError::into_inner);
        shared.ended = true;
        self.shared.1.notify_all();
        let until = Instant::now() + PATIENCE;
        while shared.connections > 0 && Instant::now() < until {
            let waited = self.shared.1.wait_timeout(shared, Duration::from_millis(100));
            shared = waited.unwrap_or_else(PoisonError::into_inner).0;
        }
    }
}

/// 128 bits that come from the operating system's randomness, as the keys of the standard library's hashes do.
fn token() -> String {
    let half = || format!("{:016x}", RandomState::new().build_hasher().finish());
    let other = std::thread::spawn(half).join().unwrap_or_default();
    half() + &other
}

/// What the page draws the bench from.
fn drawn(bench: &Bench) -> serde_json::Value {
    let joint = |link: &Link| match link {
        Link::Joint { name, about, .. } => Some(json!({ "joint": name, "about": about.unit().as_slice() })),
        Link::Tilt { .. } => None,
    };
    let sensor = |sensor: &crate::bench::Sensor| {
        let axis = sensor.input().map(|axis| axis.as_slice().to_vec());
        json!({ "id": sensor.id, "axis": axis })
    };
    let rate = bench.earth_rate();
    json!({
        "title": if bench.title.is_empty() { &bench.id } else { &bench.title },
        "chain": bench.chain.iter().filter_map(joint).collect::<Vec<_>>(),
        "sensors": bench.sensors.iter().map(sensor).collect::<Vec<_>>(),
        "earth_rate": rate.as_slice(),
    })
}

fn answer(mut stream: TcpStream, token: &str, shared: &Shared) -> std::io::Result<()> {
    stream.set_read_timeout(Some(PATIENCE))?;
    stream.set_write_timeout(Some(PATIENCE))?;
    // an event is small, and does not wait for the answer to the one before
    stream.set_nodelay(true)?;
    let mut lines = BufReader::new(stream.try_clone()?.take(HEAD)).lines();
    let first = lines.next().transpose()?.unwrap_or_default();
    let (mut host, mut origin) = (String::new(), None);
    for line in lines {
        let line = line?;
        let Some((key, value)) = line.split_once(':') else { break };
        match key.to_ascii_lowercase().as_str() {
            "host" => host = value.trim().to_string(),
            "origin" => origin = Some(value.trim().to_string()),
            _ => {}
        }
    }
    let mut words = first.split_whitespace();
    let (method, path) = (words.next().unwrap_or_default(), words.next().unwrap_or_default());
    if origin.is_some_and(|from| from != format!("http://{host}")) {
        return plain(&mut stream, "403 Forbidden", "another page may not ask");
    }
    if method != "GET" {
        return plain(&mut stream, "405 Method Not Allowed", "GET only");
    }
    match path.strip_prefix('/').and_then(|path| path.strip_prefix(token)) {
        Some("/") => {
            let nonce = self::token();
            let body = PAGE.replace("NONCE", &nonce);
            let policy = format!(
                "default-src 'none'; connect-src 'self'; style-src 'unsafe-inline'; script-src 'nonce-{nonce}'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'"
            );
            let kind = format!("text/html; charset=utf-8\r\nContent-Security-Policy: {policy}");
            respond(&mut stream, "200 OK", &kind, &body)
        }
        Some("/events") => events(stream, shared),
        _ => plain(&mut stream, "404 Not Found", "not found; the address with its token is shown in the terminal"),
    }
}

fn plain(stream: &mut TcpStream, status: &str, body: &str) -> std::io::Result<()> {
    respond(stream, status, "text/plain; charset=utf-8", body)
}

fn respond(stream: &mut TcpStream, status: &str, kind: &str, body: &str) -> std::io::Result<()> {
    let length = body.len();
    write!(
        stream,
        "HTTP/1.1 {status}\r\nContent-Type: {kind}\r\nContent-Length: {length}\r\nCache-Control: no-store\r\nReferrer-Policy: no-referrer\r\nX-Content-Type-Options: nosniff\r\nConnection: close\r\n\r\n{body}"
    )
}

/// Every event from the first on, until the guide ends or the page is closed.
fn events(mut stream: TcpStream, shared: &Shared) -> std::io::Result<()> {
    write!(
        stream,
        "HTTP/1.1 200 OK\r\nContent-Type: text/event-stream\r\nCache-Control: no-store\r\nX-Content-Type-Options: nosniff\r\nConnection: close\r\n\r\n"
    )?;
    let mut sent = (0, 0);
    loop {
        let (count, fresh, ended) = {
            let state = shared.0.lock().unwrap_or_else(PoisonError::into_inner);
            let is_told = |state: &Told| (state.events.len(), state.latest.1) == sent;
            let waited = shared.1.wait_timeout_while(state, PATIENCE, |state| is_told(state) && !state.ended);
            let state = waited.unwrap_or_else(PoisonError::into_inner).0;
            let latest = (state.latest.1 > sent.1).then_some(&state.latest.0);
            let fresh = state.events.iter().skip(sent.0).chain(latest).cloned().collect::<String>();
            ((state.events.len(), state.latest.1), fresh, state.ended)
        };
        sent = count;
        // a comment where there is nothing new shows whether the page is still open
        stream.write_all(if fresh.is_empty() { b": here\n\n" } else { fresh.as_bytes() })?;
        stream.flush()?;
        if ended {
            return Ok(());
        }
    }
}
