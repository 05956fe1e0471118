//! Packed arrays within files.

use std::io::Read;

/// A compressed element as it was, if it has no more than `most` bytes.
pub(super) fn unpacked(data: &[u8], most: u64) -> std::io::Result<Vec<u8>> {
    let mut plain = Vec::new();
    let length = flate2::read::ZlibDecoder::new(data).take(most + 1).read_to_end(&mut plain)?;
    if length as u64 > most {
        return Err(std::io::Error::other(format!("more than {most} bytes when it is unpacked")));
    }
    Ok(plain)
}
