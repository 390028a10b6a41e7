//! Messages with their length before them, over a pair of sockets.

use super::wire::LONGEST;
use std::io::{Error, ErrorKind, Read, Result, Write};
use std::os::unix::net::UnixStream;

/// Sends a message.
pub fn send(channel: &mut UnixStream, message: &[u8]) -> Result<()> {
    send_with(message, &mut |bytes| once(channel.write(bytes)))
}

/// Sends a message; `write` writes once, and gives `None` where it is to be asked again.
pub fn send_with(
    message: &[u8],
    write: &mut dyn FnMut(&[u8]) -> Result<Option<usize>>,
) -> Result<()> {
    // One write where it fits: each wakes the other process.
    let mut bytes = Vec::with_capacity(8 + message.len());
    bytes.extend_from_slice(&(message.len() as u64).to_le_bytes());
    bytes.extend_from_slice(message);
    let mut left = &bytes[..];
    while !left.is_empty() {
        match write(left)? {
            Some(0) => return Err(ErrorKind::WriteZero.into()),
            Some(n) => left = &left[n..],
            None => {}
        }
    }
    Ok(())
}

/// Receives a message; `None`: the other end has hung up.
pub fn receive(channel: &mut UnixStream) -> Result<Option<Vec<u8>>> {
    receive_with(&mut |bytes| once(channel.read(bytes)))
}

/// A read or write; `None`: a signal has interrupted it.
fn once(done: Result<usize>) -> Result<Option<usize>> {
    match done {
        Err(error) if error.kind() == ErrorKind::Interrupted => Ok(None),
        done => done.map(Some),
    }
}

/// Receives a message; `read` reads once, and gives `None` where it is to be asked again.
pub fn receive_with(
    read: &mut dyn FnMut(&mut [u8]) -> Result<Option<usize>>,
) -> Result<Option<Vec<u8>>> {
    let mut length = [0; 8];
    if !fill(&mut length, read)? {
        return Ok(None);
    }
    let length = u64::from_le_bytes(length);
    if length > LONGEST {
        let text = format!("a message of {length} bytes, more than {LONGEST}");
        return Err(Error::new(ErrorKind::InvalidData, text));
    }
    let mut message = vec![0; length as usize];
    Ok(fill(&mut message, read)?.then_some(message))
}

/// Fills `bytes`; whether they came before the other end hung up.
fn fill(
    mut bytes: &mut [u8],
    read: &mut dyn FnMut(&mut [u8]) -> Result<Option<usize>>,
) -> Result<bool> {
    while !bytes.is_empty() {
        match read(bytes)? {
            Some(0) => return Ok(false),
            Some(n) => bytes = &mut bytes[n..],
            None => {}
        }
    }
    Ok(true)
}
