//! Writing a session file, frame by frame.

use std::io::{self, ErrorKind, Write};

use crate::layout::{FORMAT_VERSION, HEADER_CHECKED, HEADER_LENGTH, KIND_END, MAGIC, MAX_PAYLOAD};

/// Appends frames to a sink.
///
/// The sink should not buffer (a `File`, not a `BufWriter`): bytes in a buffer of the process die with it.
/// Dropping a writer does not close the file: only a frame of kind [`KIND_END`] that the caller appends states that the
/// session came to its regular end.
#[derive(Debug)]
pub struct Writer<W> {
    sink: W,
    sequence: u64,
    state: State,
    /// The frame under construction; held to spare an allocation per frame.
    frame: Vec<u8>,
}

#[derive(Debug)]
enum State {
    Open,
    /// A frame of kind [`KIND_END`] was written.
    Closed,
    /// The sink failed, with this message; the file may end inside a frame.
    Poisoned(String),
}

impl<W: Write> Writer<W> {
    /// Starts a file: writes the magic line and the format version.
    ///
    /// # Errors
    /// Those of the sink.
    pub fn create(mut sink: W) -> io::Result<Self> {
        let mut prelude = MAGIC.to_vec();
        prelude.extend_from_slice(&FORMAT_VERSION.to_le_bytes());
        sink.write_all(&prelude)?;
        Ok(Self {
            sink,
            sequence: 0,
            state: State::Open,
            frame: Vec::new(),
        })
    }

    /// Appends one frame, handed to the sink in one piece. A frame of kind [`KIND_END`] closes the file.
    ///
    /// # Errors
    /// `InvalidInput`, with nothing written and the writer as before, if the payload exceeds [`MAX_PAYLOAD`] or the
    /// file is closed. An error of the sink is passed on; the frame may then be torn, so this writer refuses every
    /// later frame. What was appended before stays readable.
    pub fn append(&mut self, kind: u8, tick: u64, payload: &[u8]) -> io::Result<()> {
        match &self.state {
            State::Open => {}
            State::Closed => {
                return Err(refusal(
                    "the session file is closed: nothing may follow its end".into(),
                ));
            }
            State::Poisoned(cause) => {
                return Err(io::Error::other(format!(
                    "the session file takes no more frames after an earlier failure: {cause}"
                )));
            }
        }
        let length = match u32::try_from(payload.len()) {
            Ok(length) if payload.len() <= MAX_PAYLOAD => length,
            _ => {
                return Err(refusal(format!(
                    "a frame of {} bytes is too large for a session file, whose limit is {MAX_PAYLOAD}",
                    payload.len()
                )));
            }
        };

        self.frame.clear();
        self.frame.reserve(HEADER_LENGTH + payload.len());
        self.frame.extend_from_slice(&length.to_le_bytes());
        self.frame.push(kind);
        self.frame.extend_from_slice(&self.sequence.to_le_bytes());
        self.frame.extend_from_slice(&tick.to_le_bytes());
        self.frame
            .extend_from_slice(&crc32fast::hash(payload).to_le_bytes());
        debug_assert_eq!(self.frame.len(), HEADER_CHECKED);
        let header_checksum = crc32fast::hash(&self.frame);
        self.frame.extend_from_slice(&header_checksum.to_le_bytes());
        self.frame.extend_from_slice(payload);

        if let Err(error) = self.sink.write_all(&self.frame) {
            self.state = State::Poisoned(error.to_string());
            return Err(error);
        }
        self.sequence += 1;
        if kind == KIND_END {
            self.state = State::Closed;
        }
        Ok(())
    }

    /// Flushes the sink.
    ///
    /// # Errors
    /// Those of the sink. A sink that fails to flush may have lost bytes, so the writer then refuses further frames.
    pub fn flush(&mut self) -> io::Result<()> {
        self.sink.flush().inspect_err(|error| {
            self.state = State::Poisoned(error.to_string());
        })
    }

    /// The sink, for instance to synchronise a file with its disk. Bytes written to it directly damage the session.
    pub fn get_ref(&self) -> &W {
        &self.sink
    }

    /// Gives the sink back, without closing the session.
    pub fn into_inner(self) -> W {
        self.sink
    }
}

fn refusal(message: String) -> io::Error {
    io::Error::new(ErrorKind::InvalidInput, message)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::layout::PRELUDE_LENGTH;
    use crate::reader::{Ending, read};

    /// A disk with room for `room` bytes: takes what fits, then fails; counts the calls of `write`.
    struct SmallDisk {
        bytes: Vec<u8>,
        room: usize,
        writes: usize,
    }

    impl SmallDisk {
        fn new(room: usize) -> Self {
            Self {
                bytes: Vec::new(),
                room,
                writes: 0,
            }
        }
    }

    impl Write for &mut SmallDisk {
        fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
            self.writes += 1;
            let fits = bytes.len().min(self.room - self.bytes.len());
            if fits == 0 {
                return Err(io::Error::new(ErrorKind::StorageFull, "disk full"));
            }
            self.bytes.extend_from_slice(&bytes[..fits]);
            Ok(fits)
        }

        fn flush(&mut self) -> io::Result<()> {
            Ok(())
        }
    }

    const PAYLOADS: [&[u8]; 4] = [b"first", b"", b"a third, longer one", b"end"];

    /// The layout in the crate's documentation, byte by byte. Both checksums are those of Python's `zlib.crc32`.
    #[test]
    fn bytes_are_those_of_the_documented_layout() {
        let mut writer = Writer::create(Vec::new()).unwrap();
        writer.append(7, 0x0102, b"abc").unwrap();
        let mut expected = b"MicroSim session\n\x01\0\0\0".to_vec();
        expected.extend_from_slice(b"\x03\0\0\0\x07\0\0\0\0\0\0\0\0\x02\x01\0\0\0\0\0\0");
        expected.extend_from_slice(&0x3524_41c2_u32.to_le_bytes());
        expected.extend_from_slice(&0x9237_9b24_u32.to_le_bytes());
        expected.extend_from_slice(b"abc");
        assert_eq!(writer.into_inner(), expected);
    }

    #[test]
    fn each_frame_is_one_write() {
        let mut disk = SmallDisk::new(10_000);
        let mut writer = Writer::create(&mut disk).unwrap();
        for (tick, payload) in PAYLOADS.iter().enumerate() {
            writer.append(1, tick as u64, payload).unwrap();
        }
        drop(writer);
        assert_eq!(disk.writes, 1 + PAYLOADS.len());
    }

    /// A disk that is full after any number of bytes: the error is passed on, later frames are refused, and every
    /// frame that was acknowledged is read back.
    #[test]
    fn full_disk_keeps_every_acknowledged_frame() {
        let total = PRELUDE_LENGTH
            + PAYLOADS
                .iter()
                .map(|payload| HEADER_LENGTH + payload.len())
                .sum::<usize>();
        for room in 0..total {
            let mut disk = SmallDisk::new(room);
            let Ok(mut writer) = Writer::create(&mut disk) else {
                assert!(room < PRELUDE_LENGTH, "room {room}");
                continue;
            };
            let mut acknowledged = 0;
            let mut failed = false;
            for (tick, payload) in PAYLOADS.iter().enumerate() {
                match writer.append(1, tick as u64, payload) {
                    Ok(()) => {
                        assert!(!failed, "room {room}: a frame was taken after a failure");
                        acknowledged += 1;
                    }
                    Err(error) if failed => {
                        assert!(
                            error.to_string().contains("disk full"),
                            "room {room}: {error}"
                        );
                    }
                    Err(error) => {
                        assert_eq!(error.kind(), ErrorKind::StorageFull, "room {room}");
                        failed = true;
                    }
                }
            }
            assert!(failed, "room {room}: nothing failed");
            drop(writer);

            let reading = read(&disk.bytes).unwrap();
            let payloads: Vec<&[u8]> = reading.frames.iter().map(|frame| frame.payload).collect();
            assert_eq!(payloads, PAYLOADS[..acknowledged], "room {room}");
            assert!(
                matches!(reading.ending, Ending::Open | Ending::Torn { .. }),
                "room {room}: {:?}",
                reading.ending
            );
        }
    }

    /// A disk that is full for one frame only: the frame is torn, and a later one behind it would not be found.
    #[test]
    fn nothing_follows_a_torn_frame() {
        /// Takes three bytes of the second frame, fails once, and then works again.
        struct Hiccup(Vec<u8>, usize);

        impl Write for &mut Hiccup {
            fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
                self.1 += 1;
                let taken = if self.1 == 3 { 3 } else { bytes.len() };
                if self.1 == 4 {
                    return Err(io::Error::new(ErrorKind::StorageFull, "disk full"));
                }
                self.0.extend_from_slice(&bytes[..taken]);
                Ok(taken)
            }

            fn flush(&mut self) -> io::Result<()> {
                Ok(())
            }
        }

        let mut disk = Hiccup(Vec::new(), 0);
        let mut writer = Writer::create(&mut disk).unwrap();
        writer.append(1, 0, b"first").unwrap();
        assert_eq!(
            writer.append(1, 1, b"second").unwrap_err().to_string(),
            "disk full"
        );
        assert_eq!(
            writer.append(1, 2, b"third").unwrap_err().to_string(),
            "the session file takes no more frames after an earlier failure: disk full"
        );
        drop(writer);
        let reading = read(&disk.0).unwrap();
        assert_eq!(reading.frames.len(), 1);
        let expected = Ending::Torn {
            offset: PRELUDE_LENGTH + HEADER_LENGTH + 5,
            after_tick: Some(0),
            bytes_lost: 3,
        };
        assert_eq!(reading.ending, expected);
    }

    #[test]
    fn refusals_leave_the_writer_usable() {
        let mut writer = Writer::create(Vec::new()).unwrap();
        let error = writer.append(1, 0, &vec![0; MAX_PAYLOAD + 1]).unwrap_err();
        assert_eq!(error.kind(), ErrorKind::InvalidInput);
        writer.append(1, 0, b"small").unwrap();
        writer.append(KIND_END, 1, b"").unwrap();
        let error = writer.append(1, 2, b"late").unwrap_err();
        assert_eq!(error.kind(), ErrorKind::InvalidInput);

        let bytes = writer.into_inner();
        let reading = read(&bytes).unwrap();
        assert_eq!(reading.frames.len(), 2);
        assert_eq!(reading.ending, Ending::Clean);
    }

    #[test]
    fn largest_frame_comes_back() {
        let payload = vec![0xa5; MAX_PAYLOAD];
        let mut writer = Writer::create(Vec::new()).unwrap();
        writer.append(3, 9, &payload).unwrap();
        let bytes = writer.into_inner();
        let reading = read(&bytes).unwrap();
        assert_eq!(reading.ending, Ending::Open);
        assert!(reading.frames[0].payload == payload);
    }
}
