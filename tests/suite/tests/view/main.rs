//! The viewer: what its page shows, that it costs a run nothing, who may see and drive.

mod attacks;
mod costs;
mod driving;
mod foxglove;
mod page;

use std::net::TcpStream;

use rusty_tests::viewed::Viewed;
use rusty_tests::*;
use tungstenite::client::IntoClientRequest as _;
use tungstenite::{Message, WebSocket};

/// A page of a viewer without a browser.
trait Opened {
    fn page(&self) -> Page;
}

impl Opened for Viewed {
    fn page(&self) -> Page {
        let origin = format!("http://127.0.0.1:{}", self.port());
        let mut page = Page::connect(self.port(), &origin).expect("the socket opens");
        let token = format!(r#"{{"view":"{}"}}"#, self.view_token());
        page.0.send(Message::text(token)).unwrap();
        page
    }
}

/// The socket of a page.
struct Page(WebSocket<TcpStream>);

impl Page {
    fn connect(port: u16, origin: &str) -> Option<Self> {
        let mut request = format!("ws://127.0.0.1:{port}/socket").into_client_request().unwrap();
        request.headers_mut().insert("Origin", origin.parse().unwrap());
        let stream = TcpStream::connect(("127.0.0.1", port)).unwrap();
        stream.set_read_timeout(Some(WATCHDOG)).unwrap();
        tungstenite::client(request, stream).ok().map(|(socket, _)| Self(socket))
    }

    /// Reads until a message in JSON is the one that is wanted; returns it and the number
    /// of bytes of records before it.
    #[track_caller]
    fn until(&mut self, is_it: impl Fn(&Value) -> bool) -> (Value, usize) {
        let mut bytes = 0;
        loop {
            match self.0.read().expect("a message") {
                Message::Text(text) => {
                    let message: Value = serde_json::from_str(&text).unwrap();
                    if is_it(&message) {
                        return (message, bytes);
                    }
                }
                Message::Binary(records) => bytes += records.len(),
                other => panic!("{other:?}"),
            }
        }
    }

    fn ask(&mut self, request: &Value) {
        self.0.send(Message::text(request.to_string())).unwrap();
    }
}
