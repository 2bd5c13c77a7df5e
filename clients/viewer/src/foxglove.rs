//! The protocol of Foxglove: a run or log as topics of ROS 2, for Foxglove, Lichtblick and
//! programs that read the same.
//!
//! Source: *Foxglove WebSocket protocol v1* (github.com/foxglove/ws-protocol,
//! docs/spec.md). In reading order: [`message`] (text and bytes), [`feed`] (ticks to
//! subscribers) and [`teleop`] (commands from an app).

pub mod feed;
pub mod message;
pub mod teleop;

pub use feed::Feed;

use std::sync::Arc;

use crate::command::Command;
use crate::outbox::Outbox;
use message::{AppRequest, status};
use teleop::Publications;

/// Subprotocols, which are one protocol by two names.
const SUBPROTOCOLS: [&str; 2] = ["foxglove.sdk.v1", "foxglove.websocket.v1"];

/// Returns the subprotocol that a list of them offers first.
#[must_use]
pub fn subprotocol(offered: &str) -> Option<&'static str> {
    let mut offered = offered.split(',').map(str::trim);
    offered.find_map(|name| SUBPROTOCOLS.into_iter().find(|known| *known == name))
}

/// An app that is connected. Dropped, it is closed.
pub struct App<'a> {
    feed: &'a Feed,
    outbox: Arc<Outbox>,
    publications: Publications,
}

impl<'a> App<'a> {
    /// Opens an app.
    #[must_use]
    pub fn open(feed: &'a Feed, may_drive: bool) -> Self {
        let outbox = feed.open(may_drive);
        Self { feed, outbox, publications: Publications::new(may_drive) }
    }

    /// What waits for it.
    #[must_use]
    pub fn outbox(&self) -> &Arc<Outbox> {
        &self.outbox
    }

    /// Carries out a request in JSON; returns whether it is one.
    pub fn request(&mut self, json: &str) -> bool {
        match serde_json::from_str(json) {
            Ok(AppRequest::Subscribe { subscriptions }) => {
                self.feed.subscribe(&self.outbox, &subscriptions);
            }
            Ok(AppRequest::Unsubscribe { ids }) => self.feed.unsubscribe(&self.outbox, &ids),
            Ok(AppRequest::Advertise { channels }) => {
                for channel in channels {
                    if let Err(refused) = self.publications.add(channel) {
                        self.outbox.text(status(&refused).into());
                    }
                }
            }
            Ok(AppRequest::Unadvertise { ids }) => self.publications.remove(&ids),
            Ok(AppRequest::Other) => {}
            Err(_) => return false,
        }
        true
    }

    /// Returns the command in a message that it publishes.
    #[must_use]
    pub fn command(&mut self, bytes: &[u8]) -> Option<Command> {
        match self.publications.command(bytes) {
            Ok(command) => command,
            Err(refused) => {
                self.outbox.text(status(&refused).into());
                None
            }
        }
    }
}

impl Drop for App<'_> {
    fn drop(&mut self) {
        self.feed.close(&self.outbox);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_subprotocol_that_is_offered_first_is_taken() {
        for (offered, expected) in [
            ("foxglove.sdk.v1", Some("foxglove.sdk.v1")),
            ("x, foxglove.websocket.v1 ,foxglove.sdk.v1", Some("foxglove.websocket.v1")),
            ("foxglove.sdk.v2, foxglove", None),
            ("", None),
        ] {
            assert_eq!(subprotocol(offered), expected, "{offered}");
        }
    }
}
