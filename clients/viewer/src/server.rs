//! The server of pages and apps: a thread that accepts, and two for each that is open.

use std::io::{self, Read, Write};
use std::net::{Ipv4Addr, Shutdown, TcpListener, TcpStream};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, Once};
use std::time::Duration;

use serde::Deserialize;
use tungstenite::handshake::derive_accept_key;
use tungstenite::protocol::{Role, WebSocketConfig};
use tungstenite::{Message, WebSocket};

use rusty_contract::errln;

use crate::access::Rights;
use crate::command::Command;
use crate::foxglove::{App, subprotocol};
use crate::http::{FOXGLOVE, Head, SOCKET, Status, answer, refusal};
use crate::hub::Hub;
use crate::outbox::{Outbox, Parcel};
use crate::scene::PageRequest;

/// Most connections at a time.
const MOST_CONNECTIONS: usize = 64;
/// Longest message of a page, and of an app, which describes its messages, bytes.
const MOST_PAGE_BYTES: usize = 1 << 10;
const MOST_APP_BYTES: usize = 64 << 10;
/// Time in which a connection must make its request, and a socket give its token.
const ASKING_TIME: Duration = Duration::from_secs(5);
/// Time after which a page that takes nothing is given up.
const STALLED_TIME: Duration = Duration::from_secs(20);

/// Carries out what a page asks for.
pub type OnRequest = dyn Fn(PageRequest) + Send + Sync;
/// Passes on a command of one who may drive.
pub type OnCommand = dyn Fn(Command) + Send + Sync;

/// What all connections share.
pub struct Shared {
    /// What pages show.
    pub hub: Arc<Hub>,
    /// Who may see and drive.
    pub rights: Rights,
    /// Other sites whose pages may open the socket for apps.
    pub origins: Vec<String>,
    /// Carries out what a page asks for.
    pub on_request: Box<OnRequest>,
    /// Passes commands on.
    pub on_command: Box<OnCommand>,
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

    /// The address of the page, with the tokens. A browser keeps them to itself.
    #[must_use]
    pub fn address(&self, rights: &Rights) -> String {
        format!("http://127.0.0.1:{}/#{}", self.port, rights.text())
    }

    /// The address for apps, with the tokens.
    #[must_use]
    pub fn foxglove_address(&self, rights: &Rights) -> String {
        format!("ws://127.0.0.1:{}{FOXGLOVE}?{}", self.port, rights.text())
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
    if let Err(status) = head.check(port, &shared.origins) {
        if status == Status::Forbidden {
            report_origin(&head, shared);
        }
        return stream.write_all(&refusal(status));
    }
    let is_upgrade =
        head.field("upgrade").is_some_and(|kind| kind.eq_ignore_ascii_case("websocket"));
    let key = head.field("sec-websocket-key").filter(|_| is_upgrade);
    let key = key.filter(|_| head.field("sec-websocket-version") == Some("13"));
    match (&*head.path, key) {
        (SOCKET, Some(key)) => {
            accept(&mut stream, key, "")?;
            talk(stream, shared)
        }
        (FOXGLOVE, Some(key)) => talk_to_app(stream, &head, key, shared),
        (SOCKET | FOXGLOVE, None) => stream.write_all(&refusal(Status::Malformed)),
        _ => stream.write_all(&answer(&head)),
    }
}

/// Prints the remedy once for one who knows the secret, because an app shows no reason.
fn report_origin(head: &Head, shared: &Shared) {
    static REPORTED: Once = Once::new();
    let knows = |token| shared.rights.view.is(token);
    if let (true, Some(origin)) = (head.parameter("view").is_some_and(knows), head.field("origin"))
    {
        REPORTED.call_once(|| {
            errln!(
                "view: connecting an app failed: {FOXGLOVE}: expected a known Origin, got \
                 {origin:?}; if you trust it, add --allow-origin {origin:?}"
            );
        });
    }
}

/// Accepts a WebSocket, with more fields of the head.
fn accept(stream: &mut TcpStream, key: &str, more: &str) -> io::Result<()> {
    let accept = derive_accept_key(key.as_bytes());
    let fields = "HTTP/1.1 101 Switching Protocols\r\nUpgrade: websocket\r\n\
                  Connection: Upgrade\r\nSec-WebSocket-Accept: ";
    stream.write_all(format!("{fields}{accept}\r\n{more}\r\n").as_bytes())
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

/// Returns the half of a socket that reads messages of at most this length.
fn reading(stream: &TcpStream, most_bytes: usize) -> io::Result<WebSocket<ReadHalf>> {
    let mut config = WebSocketConfig::default();
    config.max_message_size = Some(most_bytes);
    config.max_frame_size = Some(most_bytes);
    let half = ReadHalf(stream.try_clone()?);
    Ok(WebSocket::from_raw_socket(half, Role::Server, Some(config)))
}

fn talk(stream: TcpStream, shared: &Shared) -> io::Result<()> {
    let mut pages = reading(&stream, MOST_PAGE_BYTES)?;
    let first = pages.read().ok().and_then(|message| message.into_text().ok());
    let first = first.and_then(|text| serde_json::from_str::<Introduction>(&text).ok());
    let Some(first) = first.filter(|first| shared.rights.view.is(&first.view)) else {
        let mut socket = WebSocket::from_raw_socket(stream, Role::Server, None);
        let text = r#"{"message":"refused"}"#;
        let _ = socket.send(Message::text(text));
        let _ = socket.close(None);
        return Ok(());
    };
    let may_drive = may_drive(shared, first.drive.as_deref());
    let page = OpenPage { hub: &shared.hub, outbox: shared.hub.open() };
    let outbox = Arc::clone(&page.outbox);
    let on_message = move |message| {
        let _page = &page;
        let Message::Text(text) = message else { return true };
        match serde_json::from_str(&text) {
            Ok(PageRequest::Drive { .. }) if !may_drive => {}
            Ok(PageRequest::Drive { ahead, left }) => {
                (shared.on_command)(Command::Parts { ahead, left });
            }
            Ok(request) => (shared.on_request)(request),
            // The page of this server sends nothing else.
            Err(_) => return false,
        }
        true
    };
    let rights = format!(r#"{{"message":"rights","drive":{may_drive}}}"#);
    exchange(stream, pages, outbox, Some(rights), on_message)
}

/// A page. Dropped, it is closed.
struct OpenPage<'a> {
    hub: &'a Hub,
    outbox: Arc<Outbox>,
}

impl Drop for OpenPage<'_> {
    fn drop(&mut self) {
        self.hub.close(&self.outbox);
    }
}

fn may_drive(shared: &Shared, text: Option<&str>) -> bool {
    text.zip(shared.rights.drive).is_some_and(|(text, token)| token.is(text))
}

fn talk_to_app(mut stream: TcpStream, head: &Head, key: &str, shared: &Shared) -> io::Result<()> {
    if !head.parameter("view").is_some_and(|text| shared.rights.view.is(text)) {
        return stream.write_all(&refusal(Status::Forbidden));
    }
    let Some(spoken) = head.field("sec-websocket-protocol").and_then(subprotocol) else {
        return stream.write_all(&refusal(Status::Unspoken));
    };
    accept(&mut stream, key, &format!("Sec-WebSocket-Protocol: {spoken}\r\n"))?;
    let messages = reading(&stream, MOST_APP_BYTES)?;
    let mut app = App::open(&shared.hub.feed, may_drive(shared, head.parameter("drive")));
    let outbox = Arc::clone(app.outbox());
    let on_message = move |message| match message {
        Message::Text(text) => app.request(&text),
        Message::Binary(bytes) => {
            app.command(&bytes).into_iter().for_each(&*shared.on_command);
            true
        }
        _ => true,
    };
    exchange(stream, messages, outbox, None, on_message)
}

/// Reads messages until one is not wanted, while another thread sends the outbox: with a
/// greeting all records of a parcel in one message, as a page reads them, and without one
/// each in its own.
fn exchange(
    stream: TcpStream,
    mut messages: WebSocket<ReadHalf>,
    outbox: Arc<Outbox>,
    greeting: Option<String>,
    mut on_message: impl FnMut(Message) -> bool,
) -> io::Result<()> {
    stream.set_read_timeout(None)?;
    let (writing, to_write) = (stream.try_clone()?, Arc::clone(&outbox));
    let writer = std::thread::Builder::new().name("page-out".to_owned());
    let writer = writer.spawn(move || send_all(writing, greeting, &to_write))?;
    while let Ok(message) = messages.read() {
        match message {
            Message::Ping(content) => outbox.pong(content.to_vec()),
            message if on_message(message.clone()) => {}
            _ => break,
        }
    }
    // What it belongs to is closed.
    drop(on_message);
    let _ = stream.shutdown(Shutdown::Read);
    let _ = writer.join();
    Ok(())
}

/// Sends what is in the outbox until it is closed, or nothing is taken any more.
fn send_all(stream: TcpStream, greeting: Option<String>, outbox: &Outbox) {
    let ending = stream.try_clone();
    let mut socket = WebSocket::from_raw_socket(stream, Role::Server, None);
    let is_page = greeting.is_some();
    let mut sent = greeting.map_or(Ok(()), |text| socket.send(Message::text(text)));
    while sent.is_ok() {
        sent = match outbox.next() {
            Some(Parcel::Text(json)) => socket.send(Message::text(&*json)),
            Some(Parcel::Pong(content)) => socket.send(Message::Pong(content.into())),
            Some(Parcel::Records(records)) if is_page => {
                socket.send(Message::binary(records.concat()))
            }
            Some(Parcel::Records(records)) => {
                let mut records = records.iter().map(|record| Message::binary(record.to_vec()));
                records.try_for_each(|message| socket.write(message)).and_then(|()| socket.flush())
            }
            None => break,
        };
    }
    let _ = socket.close(None).and_then(|()| socket.flush());
    // The thread that reads ends, too.
    let _ = ending.map(|stream| stream.shutdown(Shutdown::Both));
}
