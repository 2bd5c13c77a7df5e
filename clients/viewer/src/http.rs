//! The head of a request, and the answer to it: a page and its parts, on loopback only.
//!
//! A page of another site can send requests here, and by DNS rebinding even read the
//! answers. Therefore `Host` must be an address of this server, whole; a socket is opened
//! only for an `Origin` that is this server's, whole; and a socket shows nothing before
//! it was given the token of [`Rights`](crate::access::Rights). The socket for apps is given
//! the token in the query of its address, and opens for some other sites, too.

use std::collections::BTreeMap;
use std::io::Read;
use std::time::{Duration, Instant};

/// Longest head of a request, bytes.
const MOST_HEAD_BYTES: usize = 8 << 10;
/// Time for the head of a request.
const HEAD_TIME: Duration = Duration::from_secs(5);

/// The path of the socket.
pub const SOCKET: &str = "/socket";
/// The path of the socket for apps with the protocol of Foxglove.
pub const FOXGLOVE: &str = "/foxglove";
/// The sites of these apps, which may open that socket.
const APPS: [&str; 2] = ["https://app.foxglove.dev", "https://lichtblick-suite.github.io"];

/// The head of a request.
#[derive(Debug, Default, PartialEq)]
pub struct Head {
    /// Method and path.
    pub method: String,
    /// Path without the query.
    pub path: String,
    query: String,
    fields: BTreeMap<String, String>,
}

impl Head {
    /// Reads a head. `None` of one that is too long, too slow, or malformed.
    pub fn read(stream: &mut impl Read) -> Option<Self> {
        let deadline = Instant::now() + HEAD_TIME;
        let mut bytes = Vec::new();
        while !bytes.ends_with(b"\r\n\r\n") {
            let mut byte = [0];
            if bytes.len() >= MOST_HEAD_BYTES || Instant::now() > deadline {
                return None;
            }
            stream.read_exact(&mut byte).ok()?;
            bytes.push(byte[0]);
        }
        Self::parse(std::str::from_utf8(&bytes).ok()?)
    }

    fn parse(text: &str) -> Option<Self> {
        let mut lines = text.split("\r\n");
        let mut words = lines.next()?.split(' ');
        let (method, target) = (words.next()?, words.next()?);
        if words.next() != Some("HTTP/1.1") || words.next().is_some() {
            return None;
        }
        let mut fields = BTreeMap::new();
        for line in lines.take_while(|line| !line.is_empty()) {
            let (name, value) = line.split_once(':')?;
            // Which of two values would count is nothing to rely on.
            if fields.insert(name.to_ascii_lowercase(), value.trim().to_owned()).is_some() {
                return None;
            }
        }
        let (path, query) = target.split_once('?').unwrap_or((target, ""));
        let [method, path, query] = [method, path, query].map(str::to_owned);
        Some(Self { method, path, query, fields })
    }

    /// The value of a field, by its name in lower case.
    #[must_use]
    pub fn field(&self, name: &str) -> Option<&str> {
        self.fields.get(name).map(String::as_str)
    }

    /// The value of a parameter of the query.
    #[must_use]
    pub fn parameter(&self, name: &str) -> Option<&str> {
        let mut parts = self.query.split('&').filter_map(|part| part.split_once('='));
        parts.find(|(key, _)| *key == name).map(|(_, value)| value)
    }

    /// The refusal of a request that does not come from a page of this server, or to one.
    /// The socket for apps opens also for programs, which have no `Origin`, for the known
    /// sites, and for those of `allowed`.
    ///
    /// # Errors
    /// The status of the answer.
    pub fn check(&self, port: u16, allowed: &[String]) -> Result<(), Status> {
        let own = [format!("127.0.0.1:{port}"), format!("localhost:{port}")];
        let host = self.field("host").filter(|host| own.iter().any(|own| own == host));
        let host = host.ok_or(Status::Misdirected)?;
        let origin = self.field("origin");
        let is_own = |origin: &str| origin.strip_prefix("http://") == Some(host);
        let is_app = |origin: &str| {
            let is_known = APPS.contains(&origin) || allowed.iter().any(|other| other == origin);
            self.path == FOXGLOVE && is_known
        };
        match (origin, self.path == SOCKET) {
            (Some(origin), _) if !is_own(origin) && !is_app(origin) => Err(Status::Forbidden),
            (None, true) => Err(Status::Forbidden),
            _ if self.method != "GET" => Err(Status::NotAllowed),
            _ => Ok(()),
        }
    }
}

/// The status of an answer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Status {
    /// Here it is.
    Found,
    /// The request is malformed.
    Malformed,
    /// The request comes from another site, or has no right.
    Forbidden,
    /// There is no such path.
    Missing,
    /// The method is not GET.
    NotAllowed,
    /// The host is not this server.
    Misdirected,
    /// The request offers no subprotocol that is known.
    Unspoken,
}

impl Status {
    fn line(self) -> &'static str {
        match self {
            Self::Found => "200 OK",
            Self::Malformed | Self::Unspoken => "400 Bad Request",
            Self::Forbidden => "403 Forbidden",
            Self::Missing => "404 Not Found",
            Self::NotAllowed => "405 Method Not Allowed",
            Self::Misdirected => "421 Misdirected Request",
        }
    }

    fn content(self) -> &'static str {
        match self {
            Self::Unspoken => {
                "connecting failed: /foxglove: expected the subprotocol foxglove.sdk.v1 or \
                 foxglove.websocket.v1, got another one or none; connect with Foxglove, \
                 Lichtblick or a client of their protocol"
            }
            other => other.line(),
        }
    }
}

/// The parts of the page: path, type, content.
const PARTS: [(&str, &str, &str); 8] = [
    ("/", "text/html; charset=utf-8", include_str!("../page/index.html")),
    ("/look.css", "text/css; charset=utf-8", rusty_plot::assets::LOOK_CSS),
    ("/view.css", "text/css; charset=utf-8", rusty_plot::assets::VIEW_CSS),
    ("/draw.js", "text/javascript; charset=utf-8", rusty_plot::assets::DRAW_JS),
    ("/charts.js", "text/javascript; charset=utf-8", rusty_plot::assets::CHARTS_JS),
    ("/drive.js", "text/javascript; charset=utf-8", rusty_plot::assets::DRIVE_JS),
    ("/sensors.js", "text/javascript; charset=utf-8", include_str!("../page/sensors.js")),
    ("/view.js", "text/javascript; charset=utf-8", include_str!("../page/view.js")),
];

/// Returns the answer to a request for a part of the page, after [`Head::check`].
#[must_use]
pub fn answer(head: &Head) -> Vec<u8> {
    let Some((_, kind, content)) = PARTS.iter().find(|(path, ..)| *path == head.path) else {
        return refusal(Status::Missing);
    };
    let host = head.field("host").unwrap_or_default();
    let policy = format!(
        "default-src 'none'; script-src 'self'; style-src 'self'; img-src data:; \
         connect-src ws://{host}; base-uri 'none'; form-action 'none'; frame-ancestors 'none'"
    );
    response(Status::Found, kind, &format!("Content-Security-Policy: {policy}\r\n"), content)
}

/// Returns an answer that refuses.
#[must_use]
pub fn refusal(status: Status) -> Vec<u8> {
    response(status, "text/plain; charset=utf-8", "", status.content())
}

fn response(status: Status, kind: &str, fields: &str, content: &str) -> Vec<u8> {
    format!(
        "HTTP/1.1 {}\r\nContent-Type: {kind}\r\nContent-Length: {}\r\nConnection: close\r\n\
         Cache-Control: no-store\r\nX-Content-Type-Options: nosniff\r\n\
         Referrer-Policy: no-referrer\r\nCross-Origin-Resource-Policy: same-origin\r\n\
         Cross-Origin-Opener-Policy: same-origin\r\n{fields}\r\n{content}",
        status.line(),
        content.len()
    )
    .into_bytes()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn head(path: &str, fields: &str) -> Option<Head> {
        Head::read(&mut format!("GET {path} HTTP/1.1\r\n{fields}\r\n").as_bytes())
    }

    #[test]
    fn host_and_origin_are_compared_whole() {
        let own = "Host: 127.0.0.1:7000\r\n";
        let allowed = ["file://".to_owned()];
        let check = |path: &str, fields: &str| head(path, fields).unwrap().check(7000, &allowed);
        for (path, fields, expected) in [
            ("/", own.to_owned(), Ok(())),
            ("/?x=1", "host: localhost:7000\r\n".to_owned(), Ok(())),
            ("/", String::new(), Err(Status::Misdirected)),
            ("/", "Host: 127.0.0.1:70001\r\n".to_owned(), Err(Status::Misdirected)),
            ("/", "Host: 127.0.0.1\r\n".to_owned(), Err(Status::Misdirected)),
            ("/", "Host: rebind.test:7000\r\n".to_owned(), Err(Status::Misdirected)),
            ("/socket", own.to_owned(), Err(Status::Forbidden)),
            ("/socket", format!("{own}Origin: http://127.0.0.1:7000\r\n"), Ok(())),
            ("/socket", format!("{own}Origin: http://localhost:7000\r\n"), Err(Status::Forbidden)),
            (
                "/socket",
                format!("{own}Origin: http://127.0.0.1:7000.evil.test\r\n"),
                Err(Status::Forbidden),
            ),
            ("/socket", format!("{own}Origin: null\r\n"), Err(Status::Forbidden)),
            ("/", format!("{own}Origin: http://127.0.0.1:7001\r\n"), Err(Status::Forbidden)),
            ("/foxglove", own.to_owned(), Ok(())),
            ("/foxglove", "Host: rebind.test:7000\r\n".to_owned(), Err(Status::Misdirected)),
            ("/foxglove", format!("{own}Origin: http://127.0.0.1:7000\r\n"), Ok(())),
            ("/foxglove", format!("{own}Origin: https://app.foxglove.dev\r\n"), Ok(())),
            ("/foxglove", format!("{own}Origin: file://\r\n"), Ok(())),
            ("/foxglove", format!("{own}Origin: null\r\n"), Err(Status::Forbidden)),
            (
                "/foxglove",
                format!("{own}Origin: https://app.foxglove.dev.x\r\n"),
                Err(Status::Forbidden),
            ),
            (
                "/socket",
                format!("{own}Origin: https://app.foxglove.dev\r\n"),
                Err(Status::Forbidden),
            ),
            ("/socket", format!("{own}Origin: file://\r\n"), Err(Status::Forbidden)),
        ] {
            assert_eq!(check(path, &fields), expected, "{path} {fields}");
        }
    }

    #[test]
    fn a_parameter_is_read_by_its_whole_name() {
        let head = head("/foxglove?review=1&view=abc&drive=&x", "").unwrap();
        assert_eq!((&*head.path, head.parameter("view")), ("/foxglove", Some("abc")));
        assert_eq!((head.parameter("drive"), head.parameter("x")), (Some(""), None));
    }

    #[test]
    fn heads_that_are_malformed_doubled_or_endless_are_refused() {
        for fields in ["Host: a\r\nhost: b\r\n", "no colon\r\n"] {
            assert_eq!(head("/", fields), None, "{fields}");
        }
        assert_eq!(head("/ x", ""), None);
        assert_eq!(Head::read(&mut std::io::repeat(b'x')), None);
        assert_eq!(Head::read(&mut &b"GET / HT"[..]), None);
    }

    #[test]
    fn every_part_of_the_page_is_served_and_asks_no_other_site() {
        for (path, ..) in PARTS {
            let head = head(path, "Host: 127.0.0.1:7000\r\n").unwrap();
            let text = String::from_utf8(answer(&head)).unwrap();
            assert!(text.starts_with("HTTP/1.1 200 OK\r\n"), "{path}");
            assert!(text.contains("connect-src ws://127.0.0.1:7000;"), "{path}");
            assert!(!text.contains("https://") && !text.contains("innerHTML"), "{path}");
        }
        let missing = head("/etc/passwd", "Host: 127.0.0.1:7000\r\n").unwrap();
        assert!(answer(&missing).starts_with(b"HTTP/1.1 404"));
    }
}
