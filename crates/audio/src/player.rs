//! The samples to an audio server: PulseAudio, or PipeWire, which speaks its protocol. Nothing has to be installed to build it.

use crate::mixer::Mixer;
use crate::tone::{RATE, Tone};
use pulseaudio::protocol::{
    self, AuthParams, AuthReply, Command, CreatePlaybackStreamReply, PlaybackStreamParams, Prop,
    Props, ProtocolError, SampleFormat, SampleSpec, SetClientNameReply, stream::BufferAttr,
    stream::StreamFlags,
};
use std::ffi::CString;
use std::io::{BufReader, Cursor, Read};
use std::net::Shutdown;
use std::os::unix::net::UnixStream;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread::{self, JoinHandle};
use std::time::Duration;

/// Length of a sample \[bytes\].
const SAMPLE: usize = 4;
/// How long a tone waits in the server \[ms\], and how much it asks for at once.
const LATENCY: [u32; 2] = [40, 10];
/// Length of the key that servers compare \[bytes\]; they refuse a client without that many, also where they ask for none.
const COOKIE: usize = 256;
/// How long a server may take to answer while it is opened.
const PATIENCE: Duration = Duration::from_secs(2);

fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Gives the reason to whoever is to have it, once.
fn inform(failed: &Mutex<Option<impl FnOnce(String)>>, why: String) {
    let failed = lock(failed).take();
    if let Some(failed) = failed {
        failed(why);
    }
}

fn bytes(milliseconds: u32) -> u32 {
    RATE / 1000 * milliseconds * SAMPLE as u32
}

/// The connection to a server, as far as it has come.
#[derive(Debug, Default)]
struct Line {
    socket: Option<UnixStream>,
    /// Whether samples are played.
    is_open: bool,
    /// Whether nobody plays any more.
    is_left: bool,
}

/// Plays tones until it is dropped. A server is opened in the thread that plays: one that does not answer delays nobody.
#[derive(Debug)]
pub struct Player {
    mixer: Arc<Mutex<Mixer>>,
    line: Arc<Mutex<Line>>,
    thread: Option<JoinHandle<()>>,
}

impl Player {
    /// Opens the audio server of the user. Where that fails, `failed` is given the reason, in the thread that plays: there is none, it does not answer, it has no device.
    pub fn open(volume: f64, failed: impl FnOnce(String) + Send + 'static) -> Self {
        let place = || {
            let socket = pulseaudio::socket_path_from_env()
                .ok_or("no audio server (PulseAudio, PipeWire) of this user runs")?;
            let cookie = pulseaudio::cookie_path_from_env();
            let cookie = cookie.and_then(|path| std::fs::read(path).ok());
            Ok((socket, cookie.unwrap_or_default()))
        };
        Self::start(place, volume, failed)
    }

    /// Opens the audio server that listens at a path; else as [`open`](Self::open).
    pub fn open_at(
        path: &Path,
        cookie: Vec<u8>,
        volume: f64,
        failed: impl FnOnce(String) + Send + 'static,
    ) -> Self {
        let place = (path.to_path_buf(), cookie);
        Self::start(move || Ok(place), volume, failed)
    }

    fn start(
        place: impl FnOnce() -> Result<(PathBuf, Vec<u8>), String> + Send + 'static,
        volume: f64,
        failed: impl FnOnce(String) + Send + 'static,
    ) -> Self {
        let mixer = Arc::new(Mutex::new(Mixer::new(volume)));
        let line = Arc::new(Mutex::new(Line::default()));
        let (played, seat) = (Arc::clone(&mixer), Arc::clone(&line));
        // For the thread, or where there is none.
        let failed = Arc::new(Mutex::new(Some(failed)));
        let informed = Arc::clone(&failed);
        let play = move || match place().and_then(|(path, cookie)| {
            let named = |error| format!("the audio server at {}: {error}", path.display());
            connect(&path, cookie, &seat).map_err(named)
        }) {
            Err(why) => {
                // One that was left is ended by that.
                if !lock(&seat).is_left {
                    inform(&informed, why);
                }
            }
            Ok(None) => {}
            Ok(Some((mut server, stream))) => {
                // The socket is closed when nobody plays any more.
                if let Err(error) = serve(&mut server, &stream, &played) {
                    tracing::warn!("no more tones: the audio server: {error}");
                }
            }
        };
        let thread = thread::Builder::new().name("audio".into()).spawn(play);
        let thread = thread.map_err(|error| inform(&failed, format!("no thread: {error}")));
        Self {
            mixer,
            line,
            thread: thread.ok(),
        }
    }

    /// Whether a server takes tones.
    pub fn is_open(&self) -> bool {
        lock(&self.line).is_open
    }

    /// Plays a tone; none is played later that came before a server was open.
    pub fn play(&self, tone: Tone) {
        if self.is_open() {
            lock(&self.mixer).play(tone);
        }
    }
}

impl Drop for Player {
    fn drop(&mut self) {
        let mut line = lock(&self.line);
        line.is_left = true;
        // A server that is gone has closed it.
        let is_connected = line
            .socket
            .as_ref()
            .map(|socket| socket.shutdown(Shutdown::Both));
        drop(line);
        // One that has not even taken the connection is not waited for; its thread ends after that.
        if let (Some(_), Some(thread)) = (is_connected, self.thread.take()) {
            let _ = thread.join();
        }
    }
}

/// A server with a stream of its own; `None` where it was left meanwhile.
fn connect(
    path: &Path,
    cookie: Vec<u8>,
    line: &Mutex<Line>,
) -> Result<Option<(BufReader<UnixStream>, Stream)>, ProtocolError> {
    let socket = UnixStream::connect(path)?;
    socket.set_read_timeout(Some(PATIENCE))?;
    socket.set_write_timeout(Some(PATIENCE))?;
    let mut server = BufReader::new(socket.try_clone()?);
    {
        let mut line = lock(line);
        if line.is_left {
            return Ok(None);
        }
        line.socket = Some(socket.try_clone()?);
    }
    let stream = greet(&mut server, cookie)?;
    // From here on the server asks for samples whenever it likes.
    socket.set_read_timeout(None)?;
    lock(line).is_open = true;
    Ok(Some((server, stream)))
}

/// A stream of the server.
struct Stream {
    version: u16,
    channel: u32,
    /// Bytes that it asks for at first.
    requested: u32,
}

/// Makes a client with a stream of one channel.
fn greet(server: &mut BufReader<UnixStream>, mut cookie: Vec<u8>) -> Result<Stream, ProtocolError> {
    cookie.resize(COOKIE, 0);
    let auth = Command::Auth(AuthParams {
        version: protocol::MAX_VERSION,
        supports_shm: false,
        supports_memfd: false,
        cookie,
    });
    protocol::write_command_message(server.get_mut(), 0, &auth, protocol::MAX_VERSION)?;
    let (_, reply) = protocol::read_reply_message::<AuthReply>(server, protocol::MAX_VERSION)?;
    let version = protocol::MAX_VERSION.min(reply.version);

    let mut props = Props::new();
    props.set(Prop::ApplicationName, c"MicroSim");
    let name = Command::SetClientName(props);
    protocol::write_command_message(server.get_mut(), 1, &name, version)?;
    protocol::read_reply_message::<SetClientNameReply>(server, version)?;

    let [latency, request] = LATENCY.map(bytes);
    let mut props = Props::new();
    props.set(Prop::MediaName, c"tones");
    let create = Command::CreatePlaybackStream(PlaybackStreamParams {
        sample_spec: SampleSpec {
            format: SampleFormat::Float32Le,
            channels: 1,
            sample_rate: RATE,
        },
        channel_map: protocol::ChannelMap::mono(),
        cvolume: Some(protocol::ChannelVolume::norm(1)),
        sink_name: Some(CString::from(protocol::DEFAULT_SINK)),
        buffer_attr: BufferAttr {
            max_length: 2 * latency,
            target_length: latency,
            pre_buffering: request,
            minimum_request_length: request,
            ..BufferAttr::default()
        },
        flags: StreamFlags {
            adjust_latency: true,
            ..StreamFlags::default()
        },
        props,
        ..PlaybackStreamParams::default()
    });
    protocol::write_command_message(server.get_mut(), 2, &create, version)?;
    let (_, reply) = protocol::read_reply_message::<CreatePlaybackStreamReply>(server, version)?;
    Ok(Stream {
        version,
        channel: reply.channel,
        requested: reply.requested_bytes,
    })
}

/// Gives the server what it asks for, until the socket is closed here.
fn serve(
    server: &mut BufReader<UnixStream>,
    stream: &Stream,
    mixer: &Mutex<Mixer>,
) -> Result<(), ProtocolError> {
    send(server, stream, mixer, stream.requested)?;
    loop {
        let descriptor = match protocol::read_descriptor(server) {
            Ok(descriptor) => descriptor,
            Err(ProtocolError::Io(error)) if error.kind() == std::io::ErrorKind::UnexpectedEof => {
                return Ok(());
            }
            Err(error) => return Err(error),
        };
        let mut message = vec![0; descriptor.length as usize];
        server.read_exact(&mut message)?;
        let command = Command::read_tag_prefixed(&mut Cursor::new(&message), stream.version);
        match command {
            Ok((_, Command::Request(request))) if request.channel == stream.channel => {
                send(server, stream, mixer, request.length)?;
            }
            Ok((_, Command::Error(error))) => return Err(ProtocolError::ServerError(error)),
            // Whatever else the server states, also what the library does not know, asks for nothing.
            Ok(_) | Err(_) => {}
        }
    }
}

/// Sends samples.
fn send(
    server: &mut BufReader<UnixStream>,
    stream: &Stream,
    mixer: &Mutex<Mixer>,
    length: u32,
) -> Result<(), ProtocolError> {
    let mut samples = vec![0.0; length as usize / SAMPLE];
    lock(mixer).fill(&mut samples);
    let bytes: Vec<u8> = samples.iter().flat_map(|s| s.to_le_bytes()).collect();
    protocol::write_memblock(server.get_mut(), stream.channel, &bytes, 0)
}
