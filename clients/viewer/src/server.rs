//! The server of the page: a thread that accepts, and two for each page that is open.

use std::io::{self, Read, Write};
use std::net::{Ipv4Addr, Shutdown, TcpListener, TcpStream};
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::Duration;

use serde::Deserialize;
use tungstenite::handshake::derive_accept_key;
use tungstenite::protocol::{Role, WebSocketConfig};
use tungstenite::{Message, WebSocket};

use crate::access::Rights;
use crate::http::{Head, SOCKET, Status, answer, refusal};
use crate::hub::{Hub, Outbox, Parcel};
use crate::scene::PageRequest;

/// Most connections at a time.
const MOST_CONNECTIONS: usize = 64;
/// Longest message of a page, bytes.
const MOST_MESSAGE_BYTES: usize = 1 << 10;
/// Time in which a connection must make its request, and a socket give its token.
const ASKING_TIME: Duration = Duration::from_secs(5);
/// Time after which a page that takes nothing is given up.
const STALLED_TIME: Duration = Duration::from_secs(20);

/// Carries out what a page asks for.
pub type OnRequest = dyn Fn(PageRequest) + Send + Sync;

/// What all connections share.
pub struct Shared {
    /// What pages show.
    pub hub: Arc<Hub>,
    /// Who may see and drive.
    pub rights: Rights,
    /// Carries out what a page asks for; driving only for those who may.
    pub on_request: Box<OnRequest>,
}

/// A port on the loopback address.
pub struct Server {
    listener: TcpListener,
    port: u16,
}

impl Server {
    /// Takes a port of 127.0.0.1; 0 is any.
    ///
    /// # Errors
    /// [`io::Error`], for instance because another process has the port.
    pub fn bind(port: u16) -> io::Result<Self> {
        let listener = TcpListener::bind((Ipv4Addr::LOCALHOST, port))?;
        let port = listener.local_addr()?.port();
        Ok(Self { listener, port })
    }

    /// The address of the page, with the tokens.
    #[must_use]
    pub fn address(&self, rights: &Rights) -> String {
        format!("http://127.0.0.1:{}/{}", self.port, rights.fragment())
    }

    /// Serves pages from now on, in threads that end with the process.
    ///
    /// # Errors
    /// [`io::Error`] if there is no thread.
    pub fn serve(self, shared: Shared) -> io::Result<()> {
        let (shared, open) = (Arc::new(shared), Arc::new(AtomicUsize::new(0)));
        std::thread::Builder::new().name("pages".to_owned()).spawn(move || {
            for stream in self.listener.incoming() {
                let Ok(stream) = stream else {
                    // Too many files, for instance: others may be closed soon.
                    std::thread::sleep(Duration::from_millis(50));
                    continue;
                };
                let (shared, open) = (Arc::clone(&shared), Arc::clone(&open));
                if open.fetch_add(1, Ordering::Relaxed) >= MOST_CONNECTIONS {
                    open.fetch_sub(1, Ordering::Relaxed);
                    continue;
                }
                let port = self.port;
                let done = Arc::clone(&open);
                let page = std::thread::Builder::new().name("page".to_owned()).spawn(move || {
                    // One that breaks off is nothing to report.
                    let _ = converse(stream, port, &shared);
                    done.fetch_sub(1, Ordering::Relaxed);
                });
                if page.is_err() {
                    open.fetch_sub(1, Ordering::Relaxed);
                }
            }
        })?;
        Ok(())
    }
}

fn converse(mut stream: TcpStream, port: u16, shared: &Shared) -> io::Result<()> {
    stream.set_read_timeout(Some(ASKING_TIME))?;
    stream.set_write_timeout(Some(STALLED_TIME))?;
    stream.set_nodelay(true)?;
    let Some(head) = Head::read(&mut stream) else {
        return stream.write_all(&refusal(Status::Malformed));
    };
    if let Err(status) = head.check(port) {
        return stream.write_all(&refusal(status));
    }
    if head.path != SOCKET {
        return stream.write_all(&answer(&head));
    }
    let is_upgrade =
        head.field("upgrade").is_some_and(|kind| kind.eq_ignore_ascii_case("websocket"));
    match (is_upgrade, head.field("sec-websocket-key"), head.field("sec-websocket-version")) {
        (true, Some(key), Some("13")) => {
            let accept = derive_accept_key(key.as_bytes());
            let fields = "HTTP/1.1 101 Switching Protocols\r\nUpgrade: websocket\r\n\
                          Connection: Upgrade\r\nSec-WebSocket-Accept: ";
            stream.write_all(format!("{fields}{accept}\r\n\r\n").as_bytes())?;
            talk(stream, shared)
        }
        _ => stream.write_all(&refusal(Status::Malformed)),
    }
}

/// The first message of a page.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Introduction {
    view: String,
    drive: Option<String>,
}

/// One direction of a connection: the other is another thread's.
struct ReadHalf(TcpStream);

impl Read for ReadHalf {
    fn read(&mut self, bytes: &mut [u8]) -> io::Result<usize> {
        self.0.read(bytes)
    }
}

impl Write for ReadHalf {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

fn talk(stream: TcpStream, shared: &Shared) -> io::Result<()> {
    let mut config = WebSocketConfig::default();
    config.max_message_size = Some(MOST_MESSAGE_BYTES);
    config.max_frame_size = Some(MOST_MESSAGE_BYTES);
    let half = ReadHalf(stream.try_clone()?);
    let mut pages = WebSocket::from_raw_socket(half, Role::Server, Some(config));
    let first = pages.read().ok().and_then(|message| message.into_text().ok());
    let first = first.and_then(|text| serde_json::from_str::<Introduction>(&text).ok());
    let Some(first) = first.filter(|first| shared.rights.view.is(&first.view)) else {
        let mut socket = WebSocket::from_raw_socket(stream, Role::Server, None);
        let text = r#"{"message":"refused"}"#;
        let _ = socket.send(Message::text(text));
        let _ = socket.close(None);
        return Ok(());
    };
    let token = first.drive.as_deref().zip(shared.rights.drive);
    let may_drive = token.is_some_and(|(text, token)| token.is(text));
    stream.set_read_timeout(None)?;
    let outbox = shared.hub.open();
    let (writing, to_write) = (stream.try_clone()?, Arc::clone(&outbox));
    let writer = std::thread::Builder::new().name("page-out".to_owned());
    let writer = writer.spawn(move || send_all(writing, may_drive, &to_write))?;
    while let Ok(message) = pages.read() {
        let Message::Text(text) = message else { continue };
        match serde_json::from_str(&text) {
            Ok(PageRequest::Drive { .. }) if !may_drive => {}
            Ok(request) => (shared.on_request)(request),
            // The page of this server sends nothing else.
            Err(_) => break,
        }
    }
    shared.hub.close(&outbox);
    let _ = stream.shutdown(Shutdown::Read);
    let _ = writer.join();
    Ok(())
}

/// Sends what is in the outbox until the page is closed, or takes nothing any more.
fn send_all(stream: TcpStream, may_drive: bool, outbox: &Outbox) {
    let ending = stream.try_clone();
    let mut socket = WebSocket::from_raw_socket(stream, Role::Server, None);
    let rights = format!(r#"{{"message":"rights","drive":{may_drive}}}"#);
    let mut sent = socket.send(Message::text(rights));
    while sent.is_ok() {
        sent = match outbox.next() {
            Some(Parcel::Text(json)) => socket.send(Message::text(&*json)),
            Some(Parcel::Records(bytes)) => socket.send(Message::binary(bytes)),
            None => break,
        };
    }
    let _ = socket.close(None).and_then(|()| socket.flush());
    // The thread that reads ends, too.
    let _ = ending.map(|stream| stream.shutdown(Shutdown::Both));
}
