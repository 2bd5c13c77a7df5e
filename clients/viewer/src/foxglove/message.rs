//! Messages to and from an app, as text and bytes.

use rusty_ros::Channel;
use serde::{Deserialize, Serialize};
use serde_json::json;

/// First byte of a message on a channel, in both directions.
pub const DATA: u8 = 1;
/// First byte of a time.
const TIME: u8 = 2;

/// A request of an app.
#[derive(Debug, Deserialize)]
#[serde(tag = "op", rename_all = "camelCase")]
pub enum AppRequest {
    /// Messages of some channels from now on.
    Subscribe {
        /// The channels.
        subscriptions: Vec<Subscription>,
    },
    /// No more of them.
    Unsubscribe {
        /// The subscriptions.
        #[serde(rename = "subscriptionIds")]
        ids: Vec<u32>,
    },
    /// Channels on which the app will publish.
    Advertise {
        /// The channels.
        channels: Vec<AppChannel>,
    },
    /// Channels on which it publishes no more.
    Unadvertise {
        /// Their numbers.
        #[serde(rename = "channelIds")]
        ids: Vec<u32>,
    },
    /// A request that needs a capability that is not offered here.
    #[serde(other)]
    Other,
}

/// A subscription.
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub struct Subscription {
    /// Its number, chosen by the app.
    pub id: u32,
    /// Number of the channel.
    pub channel_id: u32,
}

/// A channel of an app.
#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub struct AppChannel {
    /// Its number, chosen by the app.
    pub id: u32,
    /// Name of its topic.
    pub topic: String,
    /// Encoding of its messages.
    pub encoding: String,
    /// Type of its messages.
    pub schema_name: String,
}

/// Returns the first message of a session. An app forgets the session before it.
#[must_use]
pub fn server_info(session: &str, may_drive: bool) -> String {
    let capabilities: &[&str] = if may_drive { &["time", "clientPublish"] } else { &["time"] };
    // An app publishes in the first encoding that it knows.
    let encodings: &[&str] = if may_drive { &["json", "cdr"] } else { &[] };
    let metadata = json!({ "ROS_DISTRO": "kilted" });
    json!({
        "op": "serverInfo", "name": "Rusty's laboratory", "capabilities": capabilities,
        "supportedEncodings": encodings, "metadata": metadata, "sessionId": session,
    })
    .to_string()
}

/// Returns a message that offers channels, the first with this number.
#[must_use]
pub fn advertise(channels: &[Channel], first_id: u32) -> String {
    #[derive(Serialize)]
    #[serde(rename_all = "camelCase")]
    struct Offered<'a> {
        id: u32,
        topic: &'a str,
        encoding: &'static str,
        schema_name: &'static str,
        schema: String,
        schema_encoding: &'static str,
    }
    let offered = |(id, channel): (u32, &'_ Channel)| {
        serde_json::to_value(Offered {
            id,
            topic: &channel.topic,
            encoding: "cdr",
            schema_name: channel.type_name,
            schema: channel.schema(),
            schema_encoding: "ros2msg",
        })
        .unwrap_or_default()
    };
    let offered: Vec<_> = (first_id..).zip(channels).map(offered).collect();
    json!({ "op": "advertise", "channels": offered }).to_string()
}

/// Returns a message that takes channels back.
#[must_use]
pub fn unadvertise(ids: &[u32]) -> String {
    json!({ "op": "unadvertise", "channelIds": ids }).to_string()
}

/// Returns a warning for people.
#[must_use]
pub fn status(text: &str) -> String {
    json!({ "op": "status", "level": 1, "message": text }).to_string()
}

/// Returns a message for a subscription.
#[must_use]
pub fn data(subscription: u32, time_ns: u64, content: &[u8]) -> Vec<u8> {
    let mut bytes = Vec::with_capacity(13 + content.len());
    bytes.push(DATA);
    bytes.extend(subscription.to_le_bytes());
    bytes.extend(time_ns.to_le_bytes());
    bytes.extend(content);
    bytes
}

/// Returns a message with the time.
#[must_use]
pub fn time(time_ns: u64) -> Vec<u8> {
    let mut bytes = vec![TIME];
    bytes.extend(time_ns.to_le_bytes());
    bytes
}
