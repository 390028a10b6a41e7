//! `config/openigtlink.toml`: where trackers that speak OpenIGTLink are, and what their tools are called here.

use crate::check::{items, texts, unique};
use crate::document::{Loaded, Reading, load_text};
use crate::error::{ConfigErrors, KeyPath};
use crate::files::schema_of;
use crate::kinds::{identifier, quantity, time};
use crate::table::{choices, table};
use microsim_vocabulary::{Unit, terms};
use std::net::{IpAddr, SocketAddr};
use std::path::Path;

/// Bytes of a name in the protocol.
const NAME: usize = 20;

table! {
    /// A connection to trackers.
    pub struct OpenIgtLink {
        /// Who connects: this program as `client`, or the trackers, to this program as `server`.
        role: LinkRole => "client",
        /// HOST:PORT to connect to, or to wait at; 18944 is the port of the protocol.
        address: String => "127.0.0.1:18944",
        /// Whether an address other than this machine's own is allowed: whoever reaches it moves the tools, and nothing is encrypted.
        network: bool => false,
        /// The stream of tracked tools that a client asks for when it is connected; `none` where the tracker sends unasked.
        stream: TrackedStream => "TDATA",
        /// Least time between two messages of that stream \[s\].
        interval: f64 = time(0.001, 1.0) => 0.01,
        /// How long to wait before connecting again \[s\].
        retry: f64 = time(0.01, 60.0) => 1.0,
        /// A connection on which nothing comes for this long has failed \[s\].
        silence: f64 = time(0.05, 3600.0) => 2.0,
        /// Which time decides when a sample counts: that of its `arrival`, or that of the `device`. With `device` a run waits for samples and takes as long as the peer
        /// does, each sample counts in the tick in which its time lies, and the first one is that of the start: for peers that play motion back.
        clock: LinkClock => "arrival",
        /// Devices of which the position counts without an orientation, by their names here; markers of config/translator.toml are such without being named.
        marker: Vec<String> [0, 256],
        /// Tools whose names in the protocol are not those of devices in config/translator.toml, or whose openings come by themselves.
        device: Vec<LinkDevice> [0, 32],
    }
}

table! {
    /// What a tool of a tracker is called.
    pub struct LinkDevice {
        /// Its name in TDATA and QTDATA, or the device that sends TRANSFORM or POSITION; at most 20 bytes.
        name: String,
        /// The device of config/translator.toml.
        device: String = identifier(),
        /// Where its opening comes from; the protocol has no place for it.
        opening: Option<LinkOpening>,
    }
}

table! {
    /// An opening that comes as the x coordinate of a device of its own: the width of the jaws, for example. It is that of the next pose of the tool.
    pub struct LinkOpening {
        /// The name of that device in the protocol; at most 20 bytes.
        name: String,
        /// Coordinate that means closed \[m\].
        closed: f64 = quantity(Unit::Length, -10.0, 10.0) => 0.0,
        /// Coordinate that means open \[m\].
        open: f64 = quantity(Unit::Length, -10.0, 10.0),
    }
}

terms! {
    /// Whose time counts.
    pub enum LinkClock {
        /// That of the arrival.
        Arrival = "arrival",
        /// That of the device.
        Device = "device",
    }
}

terms! {
    /// Who connects to whom.
    pub enum LinkRole {
        /// This program connects.
        Client = "client",
        /// Trackers connect.
        Server = "server",
    }
}

terms! {
    /// A stream of tracked tools.
    pub enum TrackedStream {
        /// With matrices.
        Matrices = "TDATA",
        /// With quaternions.
        Quaternions = "QTDATA",
        /// None is asked for.
        Unasked = "none",
    }
}

choices! { LinkClock, LinkRole, TrackedStream }

impl LinkOpening {
    /// The opening from 0 closed to 1 open that a coordinate means \[m\]; beyond the ends it is that of the ends.
    pub fn opening(&self, x: f64) -> f64 {
        ((x - self.closed) / (self.open - self.closed)).clamp(0.0, 1.0)
    }
}

impl OpenIgtLink {
    /// The same as a client of another address.
    ///
    /// # Errors
    /// What is wrong with the address, in words.
    pub fn client_of(self, address: &str) -> Result<Self, String> {
        match wrong_address(address, self.network) {
            None => Ok(Self {
                role: LinkRole::Client,
                address: address.to_owned(),
                ..self
            }),
            Some((found, expected)) => Err(format!("{found}; expected {expected}")),
        }
    }

    /// The device whose opening a device of this name in the protocol is, and how.
    pub fn opening(&self, name: &str) -> Option<(&str, &LinkOpening)> {
        self.device.iter().find_map(|listed| {
            let opening = listed
                .opening
                .as_ref()
                .filter(|opening| opening.name == name)?;
            Some((&listed.device[..], opening))
        })
    }

    /// Whether a device has a position alone.
    pub fn is_marker(&self, device: &str) -> bool {
        self.marker.iter().any(|marker| marker == device)
    }

    /// What a tool of this name in the protocol is called.
    pub fn device<'a>(&'a self, name: &'a str) -> &'a str {
        let listed = self.device.iter().find(|listed| listed.name == name);
        listed.map_or(name, |listed| &listed.device)
    }
}

/// What is found at an address that is none or not allowed, and what is expected.
fn wrong_address(address: &str, network: bool) -> Option<(String, &'static str)> {
    let port = |text: &str| text.parse::<u16>().is_ok_and(|port| port > 0);
    let host = match (address.parse::<SocketAddr>(), address.rsplit_once(':')) {
        (Ok(socket), _) if socket.port() > 0 => socket.ip().to_string(),
        (Err(_), Some((host, digits))) if port(digits) && is_name(host) => host.to_owned(),
        _ => {
            return Some((
                format!("`{address}`"),
                "HOST:PORT, such as `127.0.0.1:18944` or `[::1]:18944`",
            ));
        }
    };
    let own = host == "localhost" || host.parse().is_ok_and(|ip: IpAddr| ip.is_loopback());
    (!own && !network).then(|| {
        (
            format!("`{host}`, which is not this machine alone"),
            "an address of this machine, or `network = true` in config/openigtlink.toml",
        )
    })
}

fn is_name(host: &str) -> bool {
    let is_part = |byte: u8| byte.is_ascii_alphanumeric() || matches!(byte, b'-' | b'.' | b'_');
    !host.is_empty() && host.bytes().all(is_part)
}

/// Reads the file from a text; `file` is the name that complaints use.
pub fn read_openigtlink(text: &str, file: &str) -> Result<Loaded<OpenIgtLink>, ConfigErrors> {
    let mut reading = Reading::new(text, file, &schema_of::<OpenIgtLink>("openigtlink"))?;
    let root = KeyPath::root();
    let network = reading.value()["network"].as_bool().unwrap_or_default();
    let address = reading.value()["address"].as_str();
    if let Some((found, expected)) = address.and_then(|text| wrong_address(text, network)) {
        reading.complain(&root.key("address"), &found, expected);
    }
    let names = texts(reading.value(), "device", "name");
    unique(&mut reading, &root, &names, "device", "name");
    let long: Vec<usize> = items(reading.value(), "device")
        .filter(|(_, device)| {
            device["name"]
                .as_str()
                .is_some_and(|name| name.len() > NAME)
        })
        .map(|(at, _)| at)
        .collect();
    for at in long {
        let key = root.key("device").at(at).key("name");
        reading.complain(
            &key,
            "a longer one",
            "at most 20 bytes, as the protocol has no more",
        );
    }
    let ends: Vec<(usize, Option<(f64, f64)>)> = items(reading.value(), "device")
        .map(|(at, device)| {
            let opening = &device["opening"];
            (at, opening["closed"].as_f64().zip(opening["open"].as_f64()))
        })
        .collect();
    for (at, ends) in ends {
        if ends.is_some_and(|(closed, open)| closed == open) {
            let key = root.key("device").at(at).key("opening");
            reading.complain(
                &key,
                "one coordinate for closed and open",
                "`closed` other than `open`",
            );
        }
    }
    reading.finish()
}

/// Reads the file at `path`.
pub fn load_openigtlink(path: &Path) -> Result<Loaded<OpenIgtLink>, ConfigErrors> {
    let text = load_text(path, "the connection to trackers (config/openigtlink.toml)")?;
    read_openigtlink(&text, &path.display().to_string())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_left_out_connects_to_this_machine_alone() {
        let link = read_openigtlink("", "test").expect("defaults").settings;
        assert_eq!(
            (link.role, &link.address[..]),
            (LinkRole::Client, "127.0.0.1:18944")
        );
        assert_eq!(
            (link.stream, link.interval),
            (TrackedStream::Matrices, 0.01)
        );
        assert_eq!(link.device("left"), "left");
    }

    #[test]
    fn addresses_elsewhere_are_allowed_on_request_alone() {
        let read = |text: &str| read_openigtlink(text, "test").map_err(|e| e.to_string());
        for own in ["127.0.0.9:1", "localhost:18944", "[::1]:18944"] {
            assert!(read(&format!("address = \"{own}\"")).is_ok(), "{own}");
        }
        for other in [
            "192.168.0.7:18944",
            "0.0.0.0:18944",
            "tracker.clinic:18944",
            "[::]:1",
        ] {
            let address = format!("address = \"{other}\"");
            let refused = read(&address).expect_err(other);
            assert!(
                refused.contains("test:1") && refused.contains("network = true"),
                "{refused}"
            );
            assert!(
                read(&format!("{address}\nnetwork = true")).is_ok(),
                "{other}"
            );
        }
        for wrong in [
            "",
            "18944",
            "localhost",
            "localhost:",
            "localhost:0",
            ":18944",
            "a b:1",
            "127.0.0.1:70000",
            "::1:x",
        ] {
            assert!(
                read(&format!("address = \"{wrong}\"\nnetwork = true")).is_err(),
                "{wrong}"
            );
        }
        let link = read("role = \"server\"").expect("a file").settings;
        let client = link.clone().client_of("localhost:7").expect("a client");
        assert_eq!(
            (client.role, &client.address[..]),
            (LinkRole::Client, "localhost:7")
        );
        assert!(
            link.client_of("10.0.0.1:7")
                .is_err_and(|text| text.contains("network = true"))
        );
    }

    #[test]
    fn names_are_of_the_protocol_and_stand_once() {
        let device = |name: &str| format!("[[device]]\nname = \"{name}\"\ndevice = \"left\"\n");
        let read = |text: &str| read_openigtlink(text, "test").map_err(|e| e.to_string());
        let link = read(&device("Left Forceps")).expect("a file").settings;
        assert_eq!(link.device("Left Forceps"), "left");
        assert!(read(&device("ABCDEFGHIJKLMNOPQRST")).is_ok());
        assert!(read(&device("ABCDEFGHIJKLMNOPQRSTU")).is_err_and(|e| e.contains("20 bytes")));
        let twice = device("a") + &device("a");
        assert!(read(&twice).is_err_and(|e| e.contains("a second time")));
    }
}
