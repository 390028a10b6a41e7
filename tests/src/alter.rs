//! Sessions written again, every checksum right, with one value changed: as a forger would, or a fault in memory.

use microsim_bus::Frames;
use microsim_bus::frame::push_stamped;
use microsim_host::record::{EndRecord, Header, Session, TickRecord, kind};
use microsim_message::{InputSample, Message, decode, decode_bytes, encode};
use microsim_session::{History, KIND_END, StationKey, Writer, read};

/// The session with the payload of every record passed through `change` (kind, tick, payload); `None` leaves a record
/// out.
pub fn rewrite(
    session: &[u8],
    mut change: impl FnMut(u8, u64, &[u8]) -> Option<Vec<u8>>,
) -> Vec<u8> {
    let reading = read(session).expect("a session");
    let mut writer = Writer::create(Vec::new()).expect("memory");
    for frame in &reading.frames {
        if let Some(payload) = change(frame.kind, frame.tick, frame.payload) {
            writer
                .append(frame.kind, frame.tick, &payload)
                .expect("memory");
        }
    }
    writer.into_inner()
}

/// The session with one tick changed.
pub fn change_tick(session: &[u8], tick: u64, change: impl Fn(&mut TickRecord)) -> Vec<u8> {
    rewrite(session, |record_kind, record_tick, payload| {
        if record_kind != kind::TICK || record_tick != tick {
            return Some(payload.to_vec());
        }
        let mut record: TickRecord = decode_bytes(payload).expect("a tick");
        change(&mut record);
        Some(encode(&record))
    })
}

/// The session with the record changed that states how the run ended.
pub fn change_end(session: &[u8], change: impl Fn(&mut EndRecord)) -> Vec<u8> {
    rewrite(session, |record_kind, _, payload| {
        if record_kind != kind::CLOSE {
            return Some(payload.to_vec());
        }
        let mut record: EndRecord = decode_bytes(payload).expect("an end");
        change(&mut record);
        Some(encode(&record))
    })
}

/// The session with its header changed.
pub fn change_header(session: &[u8], change: impl Fn(&mut Header)) -> Vec<u8> {
    rewrite(session, |record_kind, _, payload| {
        if record_kind != kind::HEADER {
            return Some(payload.to_vec());
        }
        let mut header: Header = decode_bytes(payload).expect("a header");
        change(&mut header);
        Some(encode(&header))
    })
}

/// The session with every tick passed through `tick`, and its end through `end` with what the last tick gave.
pub fn change_records<T: Default>(
    session: &[u8],
    mut tick: impl FnMut(u64, &mut TickRecord) -> T,
    end: impl Fn(u64, &mut EndRecord, T),
) -> Vec<u8> {
    let mut last = T::default();
    rewrite(session, |record_kind, record_tick, payload| {
        Some(match record_kind {
            kind::TICK => {
                let mut record: TickRecord = decode_bytes(payload).expect("a tick");
                last = tick(record_tick, &mut record);
                encode(&record)
            }
            kind::CLOSE => {
                let mut record: EndRecord = decode_bytes(payload).expect("an end");
                end(record_tick, &mut record, std::mem::take(&mut last));
                encode(&record)
            }
            _ => payload.to_vec(),
        })
    })
}

/// The session with the signatures of another key, or of none.
pub fn signed_again(session: &[u8], key: Option<&StationKey>) -> Vec<u8> {
    let mut history = History::new();
    let mut writer = Writer::create(Vec::new()).expect("memory");
    for frame in &read(session).expect("a session").frames {
        let payload = match (frame.kind, key) {
            (kind::SIGNATURE, None) => continue,
            (KIND_END, None) => Vec::new(),
            (kind::SIGNATURE | KIND_END, Some(key)) => {
                key.sign(&history, frame.kind, frame.tick).to_vec()
            }
            _ => frame.payload.to_vec(),
        };
        history.add(frame.kind, frame.tick, &payload);
        writer
            .append(frame.kind, frame.tick, &payload)
            .expect("memory");
    }
    writer.into_inner()
}

/// The session with one more record before its end.
pub fn insert_before_end(session: &[u8], kind: u8, payload: &[u8]) -> Vec<u8> {
    let reading = read(session).expect("a session");
    let mut writer = Writer::create(Vec::new()).expect("memory");
    for frame in &reading.frames {
        if frame.kind == kind::CLOSE {
            writer.append(kind, frame.tick, payload).expect("memory");
        }
        writer
            .append(frame.kind, frame.tick, frame.payload)
            .expect("memory");
    }
    writer.into_inner()
}

/// Changes the first message of its kind in the log of a tick.
///
/// # Panics
/// If there is none.
pub fn change_message<M: Message>(log: &mut Vec<u8>, change: impl Fn(&mut M)) {
    let mut new = Vec::new();
    let mut found = false;
    for frame in Frames::new(log) {
        let frame = frame.expect("a good log");
        match decode::<M>(&frame).filter(|_| !found) {
            Some(message) => {
                found = true;
                let mut message = message.expect("a good message");
                change(&mut message);
                push_stamped(&mut new, &frame.header, &encode(&message));
            }
            None => push_stamped(&mut new, &frame.header, frame.payload),
        }
    }
    assert!(found, "no message \"{}\" in this tick", M::KIND);
    *log = new;
}

/// The ticks of a session in which an input sample arrived.
pub fn ticks_with_samples(session: &Session) -> Vec<u64> {
    let has_sample = |record: &TickRecord| {
        Frames::new(&record.log)
            .filter_map(Result::ok)
            .any(|frame| decode::<InputSample>(&frame).is_some())
    };
    let ticks = session.ticks.iter().filter(|(_, r)| has_sample(r));
    ticks.map(|(tick, _)| *tick).collect()
}

/// The neighbouring double: the last bit is flipped.
pub fn last_bit_flipped(value: f64) -> f64 {
    f64::from_bits(value.to_bits() ^ 1)
}
