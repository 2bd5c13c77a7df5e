//! Pages of other sites, in a real browser, that know the token: none opens the socket,
//! and none reads the page.

use std::io::{Read as _, Write as _};
use std::net::{TcpListener, TcpStream};

use rusty_tests::browser::Browser;
use rusty_tests::viewed::Viewed;
use rusty_tests::*;
use tungstenite::Message;

use crate::Page;
use crate::foxglove::AppClient;

/// The page of another site, which tries the sockets and then the page of the viewer.
fn serve_attacker(port: u16, token: &str) -> u16 {
    let script = format!(
        "const done = [];\n\
         const host = location.hostname === 'rebind.test' ? 'rebind.test' : '127.0.0.1';\n\
         const address = `ws://${{host}}:{port}/foxglove?view={token}`;\n\
         const app = new WebSocket(address, ['foxglove.sdk.v1']);\n\
         app.onopen = app.onmessage = () => done.push('app');\n\
         app.onclose = () => done.push('closed');\n\
         const socket = new WebSocket('ws://127.0.0.1:{port}/socket');\n\
         socket.onopen = () => {{ done.push('opened'); socket.send('{{\"view\":\"{token}\"}}'); }};\n\
         socket.onmessage = () => done.push('read');\n\
         socket.onclose = async () => {{\n\
           try {{ await (await fetch('http://127.0.0.1:{port}/')).text(); done.push('fetched'); }}\n\
           catch {{ done.push('no fetch'); }}\n\
           while (done.length < 2) await new Promise((done) => setTimeout(done, 10));\n\
           document.title = 'done: ' + done.sort().join(', ');\n\
         }};"
    );
    let html = format!("<!doctype html><title>trying</title><script>{script}</script>");
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let own = listener.local_addr().unwrap().port();
    std::thread::spawn(move || {
        for mut stream in listener.incoming().flatten() {
            let html = html.clone();
            // A browser also opens connections on which it asks nothing.
            std::thread::spawn(move || {
                let _ = stream.read(&mut [0; 4096]);
                let head = "HTTP/1.1 200 OK\r\nContent-Type: text/html\r\nConnection: close\r\n";
                let _ = write!(stream, "{head}Content-Length: {}\r\n\r\n{html}", html.len());
            });
        }
    });
    own
}

#[test]
fn pages_of_other_ports_and_hosts_and_rebound_names_are_refused() {
    let (_out, log) = logged("attacked", &["--ticks", "50"]);
    let viewed = Viewed::view(&[arg(&log)]);
    let map = "--host-resolver-rules=MAP evil.test 127.0.0.1, MAP rebind.test 127.0.0.1";
    let Some(mut browser) = Browser::start_with(&[map]) else { return };
    let (port, attacker) = (viewed.port(), serve_attacker(viewed.port(), viewed.view_token()));
    for host in ["127.0.0.1", "localhost", "evil.test", "rebind.test"] {
        browser.visit(&format!("http://{host}:{attacker}/"));
        browser.until("document.title.startsWith('done')");
        let refused = "done: closed, no fetch";
        assert_eq!(browser.value("document.title"), refused, "{host}");
    }
    // A name of the attacker that leads to the port of the viewer.
    browser.visit(&format!("http://rebind.test:{port}/#{}", viewed.tokens()));
    assert_eq!(browser.value("document.body.innerText"), "421 Misdirected Request");
    // The same browser sees what it may see.
    browser.visit(&viewed.address);
    browser.until("globalThis.rustyView && rustyView.ticks > 0");
    let own = format!("new WebSocket({:?}, ['foxglove.sdk.v1'])", viewed.foxglove());
    browser.value(&format!(
        "{{ const app = {own}; app.onmessage = () => app.isRead = true; globalThis.app = app; }} 0"
    ));
    browser.until("app.isRead");
}

#[test]
fn a_socket_shows_nothing_without_its_origin_and_its_token() {
    let (_out, log) = logged("tokens", &["--ticks", "50"]);
    let viewed = Viewed::view(&[arg(&log)]);
    let (port, own) = (viewed.port(), format!("http://127.0.0.1:{}", viewed.port()));
    for origin in ["null", "http://127.0.0.1", &format!("{own}.evil.test"), "https://127.0.0.1"] {
        assert!(Page::connect(port, origin).is_none(), "{origin}");
    }
    let token = viewed.view_token();
    let other = token.replace(|c: char| c != '0', "0");
    for first in [format!(r#"{{"view":"{other}"}}"#), r#"{"view":""}"#.to_owned(), "x".to_owned()] {
        let mut page = Page::connect(port, &own).unwrap();
        page.0.send(Message::text(first)).unwrap();
        let (refused, bytes) = page.until(|_| true);
        assert_eq!((&refused["message"], bytes), (&json!("refused"), 0));
        assert!(page.0.read().is_ok_and(|m| m.is_close()) || page.0.read().is_err());
    }
}

#[test]
fn an_app_needs_its_token_a_known_site_and_a_subprotocol() {
    let (_out, log) = logged("apps", &["--ticks", "50"]);
    let viewed = Viewed::view(&[arg(&log), "--allow-origin", "file://"]);
    let (address, own) = (viewed.foxglove(), format!("http://127.0.0.1:{}", viewed.port()));
    let bare = address.split('?').next().unwrap();
    let other = format!("{bare}?view={}", "0".repeat(32));
    let (sdk, origin) = ("foxglove.sdk.v1", Some("null"));
    for (address, origin, protocols, expected) in [
        (&*address, None, sdk, Ok(sdk)),
        (&address, Some(&*own), "foxglove.websocket.v1", Ok("foxglove.websocket.v1")),
        (&address, Some("https://app.foxglove.dev"), "x, foxglove.sdk.v1", Ok(sdk)),
        (&address, Some("https://lichtblick-suite.github.io"), sdk, Ok(sdk)),
        (&address, Some("file://"), sdk, Ok(sdk)),
        (&address, origin, sdk, Err(403)),
        (&address, Some("https://app.foxglove.dev.evil.test"), sdk, Err(403)),
        (&address, Some("http://localhost"), sdk, Err(403)),
        (&address, None, "foxglove.sdk.v2", Err(400)),
        (bare, None, sdk, Err(403)),
        (&other, None, sdk, Err(403)),
        (&address.replace("view=", "drive="), None, sdk, Err(403)),
    ] {
        let spoken = AppClient::connect(address, origin, protocols).map(|app| app.subprotocol);
        assert_eq!(spoken.as_deref().map_err(|e| *e), expected, "{address} {origin:?} {protocols}");
    }
}

#[test]
fn malformed_and_endless_requests_end_and_the_page_is_still_served() {
    let (_out, log) = logged("malformed", &["--ticks", "50"]);
    let viewed = Viewed::view(&[arg(&log)]);
    let answer = |request: &[u8]| {
        let mut stream = TcpStream::connect(("127.0.0.1", viewed.port())).unwrap();
        let _ = stream.write_all(request);
        let mut text = Vec::new();
        let _ = stream.read_to_end(&mut text);
        String::from_utf8_lossy(&text).into_owned()
    };
    assert!(answer(b"\0\xff\r\n\r\n").starts_with("HTTP/1.1 400"));
    let host = format!("Host: 127.0.0.1:{}\r\n", viewed.port());
    let post = answer(format!("POST / HTTP/1.1\r\n{host}\r\n").as_bytes());
    assert!(post.starts_with("HTTP/1.1 405"), "{post}");
    // More than a head may have: the connection ends, whatever arrives of the answer.
    let _ = answer(&[b'x'; 1 << 16]);
    let page = answer(format!("GET / HTTP/1.1\r\n{host}\r\n").as_bytes());
    assert!(page.starts_with("HTTP/1.1 200") && page.contains("frame-ancestors 'none'"), "{page}");
}
