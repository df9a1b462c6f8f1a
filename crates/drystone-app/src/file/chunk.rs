//! Files of this program's own: a line with their kind, then chunks, each with its length and
//! checksum.

use serde::Serialize;
use serde::de::DeserializeOwned;

/// Version of all such files; it goes up whenever their content changes.
const VERSION: u32 = 1;

/// Length and checksum.
const HEAD: usize = 8 + 4;

/// First bytes of a file of a kind, which has eight letters.
pub(crate) fn title(kind: [u8; 8]) -> Vec<u8> {
    [&kind[..], &VERSION.to_le_bytes()].concat()
}

/// Why a file was not understood, for a message that names it.
pub(crate) type Trouble = String;

/// The bytes after the title, in a file of this kind; `called` is the name of such a file in
/// errors.
pub(crate) fn after_title<'a>(
    bytes: &'a [u8],
    kind: [u8; 8],
    called: &str,
) -> Result<&'a [u8], Trouble> {
    let Some((version, rest)) = bytes.strip_prefix(&kind).and_then(|b| b.split_first_chunk())
    else {
        return Err(format!("is no {called}"));
    };
    let version = u32::from_le_bytes(*version);
    if version == VERSION {
        return Ok(rest);
    }
    Err(format!("is a {called} of version {version}, expected version {VERSION}"))
}

/// A value as a chunk.
pub(crate) fn put(value: &impl Serialize) -> Result<Vec<u8>, Trouble> {
    let data = postcard::to_stdvec(value).map_err(|e| format!("cannot be written: {e}"))?;
    let mut bytes = Vec::with_capacity(HEAD + data.len());
    bytes.extend_from_slice(&(data.len() as u64).to_le_bytes());
    bytes.extend_from_slice(&crc32fast::hash(&data).to_le_bytes());
    bytes.extend_from_slice(&data);
    Ok(bytes)
}

/// The next chunk, taken off the bytes. `None`: it was cut off or changed.
pub(crate) fn take<T: DeserializeOwned>(bytes: &mut &[u8]) -> Option<T> {
    let (length, rest) = bytes.split_first_chunk()?;
    let (sum, rest) = rest.split_first_chunk()?;
    let length = usize::try_from(u64::from_le_bytes(*length)).ok()?;
    let (data, rest) = rest.split_at_checked(length)?;
    if crc32fast::hash(data) != u32::from_le_bytes(*sum) {
        return None;
    }
    let (value, unread) = postcard::take_from_bytes(data).ok()?;
    *bytes = rest;
    unread.is_empty().then_some(value)
}

#[cfg(test)]
mod tests {
    use super::{after_title, put, take, title};

    #[test]
    fn chunks_come_back_and_damage_is_noticed() {
        let mut file = title(*b"a thing ");
        file.extend(put(&(1_u32, "one")).unwrap());
        file.extend(put(&vec![2_u64; 3]).unwrap());
        let read = |file: &[u8]| {
            let mut bytes = after_title(file, *b"a thing ", "thing").unwrap();
            let first: Option<(u32, String)> = take(&mut bytes);
            let second: Option<Vec<u64>> = take(&mut bytes);
            (first, second, bytes.len())
        };
        assert_eq!(read(&file), (Some((1, "one".to_owned())), Some(vec![2; 3]), 0));
        for at in 12..file.len() {
            let mut changed = file.clone();
            changed[at] ^= 4;
            assert!(matches!(read(&changed), (None, ..) | (_, None, _)), "{at}");
            assert!(read(&file[..at]).1.is_none(), "{at}");
        }
        let wrong = |file: &[u8], kind: &[u8; 8]| after_title(file, *kind, "thing").unwrap_err();
        assert_eq!(wrong(&file, b"another "), "is no thing");
        assert_eq!(wrong(&file[..11], b"a thing "), "is no thing");
        file[8] = 9;
        assert!(wrong(&file, b"a thing ").contains("version 9, expected version 1"));
    }
}
