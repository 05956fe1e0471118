//! Bytes of a logger's or spreadsheet's file as UTF-8: gzip, byte order marks, UTF-16, Latin-1, Chinese and Japanese encodings.

use crate::elements::Parts;
use crate::error::{Fault, Malformed, Result};
use chardetng::EncodingDetector;
use encoding_rs::{BIG5, CoderResult, Decoder, EUC_JP, EUC_KR, Encoding, GBK, SHIFT_JIS, UTF_8, UTF_16BE, UTF_16LE};
use std::io::{self, BufRead, BufReader, Read};

/// How much is read at a time.
const CHUNK: usize = 1 << 18;

/// A stream of bytes, unpacked where it is gzip and converted to UTF-8 where it is UTF-16 (by its byte order mark, or by its zero bytes), Shift-JIS, GBK and the like; lines that end in a carriage return
/// alone (classic Mac OS) end in a line feed.
///
/// Latin-1 stays as it is: its numbers are ASCII, and [`decoded`] reads its names. Errors: none yet; a truncated gzip shows as it is read.
pub(super) fn unpacked(from: impl Read + Send + 'static) -> io::Result<Box<dyn BufRead + Send>> {
    let mut from = BufReader::with_capacity(CHUNK, from);
    let mut plain: Box<dyn BufRead + Send> = if from.fill_buf()?.starts_with(&[0x1F, 0x8B]) {
        Box::new(BufReader::with_capacity(CHUNK, flate2::bufread::MultiGzDecoder::new(from)))
    } else {
        Box::new(from)
    };
    let start = plain.fill_buf()?;
    let encoding = match Encoding::for_bom(start) {
        Some((encoding, length)) => {
            plain.consume(length);
            Some(encoding).filter(|encoding| *encoding != UTF_8)
        }
        None => wide_of(start).or_else(|| eastern(start)),
    };
    let mut text: Box<dyn BufRead + Send> = match encoding {
        None => plain,
        Some(encoding) => {
            let decoder = encoding.new_decoder_without_bom_handling();
            Box::new(BufReader::with_capacity(CHUNK, Decoded { from: plain, decoder, ended: false }))
        }
    };
    let start = text.fill_buf()?;
    // a quoted cell may hold a break of the other kind; a return at the end may have its line feed still to come
    let (mut quoted, mut returns, mut feeds) = (false, 0, 0);
    for pair in start.windows(2) {
        match pair {
            [b'"', _] => quoted = !quoted,
            [b'\r', other] if !quoted && *other != b'\n' => returns += 1,
            [b'\n', _] if !quoted => feeds += 1,
            _ => {}
        }
    }
    if returns > feeds {
        text = Box::new(BufReader::with_capacity(CHUNK, Returns(text)));
    }
    Ok(text)
}

/// The order of the bytes of UTF-16 without a mark: of most characters of a table one of the two bytes is zero, and always the same one, and it has lines. A
/// table of UTF-8 has no zeros, and a binary format has them in both places, or few.
fn wide_of(start: &[u8]) -> Option<&'static Encoding> {
    let pairs = start.part(..start.len().min(CHUNK)).as_chunks::<2>().0;
    let (mut high, mut low) = (0, 0);
    for [first, second] in pairs {
        (high, low) = (high + usize::from(*first == 0), low + usize::from(*second == 0));
    }
    // nine characters of ten are of ASCII
    let has_lines = pairs.iter().any(|pair| matches!(pair, [b'\n', 0] | [0, b'\n']));
    let most = |zeros: usize, others: usize| others == 0 && has_lines && 10 * zeros >= 9 * pairs.len();
    match (most(low, high), most(high, low)) {
        (true, _) => Some(UTF_16LE),
        (_, true) => Some(UTF_16BE),
        _ => None,
    }
}

/// Text whose lines end in carriage returns, with line feeds in their place.
struct Returns(Box<dyn BufRead + Send>);

impl Read for Returns {
    fn read(&mut self, to: &mut [u8]) -> io::Result<usize> {
        let length = self.0.read(to)?;
        to.iter_mut().take(length).filter(|byte| **byte == b'\r').for_each(|byte| *byte = b'\n');
        Ok(length)
    }
}

/// Text of another encoding as UTF-8.
struct Decoded {
    from: Box<dyn BufRead + Send>,
    decoder: Decoder,
    /// The decoder has seen the end; it is not asked again.
    ended: bool,
}

impl Read for Decoded {
    fn read(&mut self, to: &mut [u8]) -> io::Result<usize> {
        while !self.ended {
            let chunk = self.from.fill_buf()?;
            let is_last = chunk.is_empty();
            let (result, read, written, _) = self.decoder.decode_to_utf8(chunk, to, is_last);
            self.from.consume(read);
            self.ended = is_last && result == CoderResult::InputEmpty;
            if written > 0 {
                return Ok(written);
            }
        }
        Ok(0)
    }
}

/// The encoding of a table whose words are Chinese, Japanese or Korean and not UTF-8; `None` for others, of which Latin-1 is the most frequent.
fn eastern(start: &[u8]) -> Option<&'static Encoding> {
    let cut = |error: std::str::Utf8Error| error.error_len().is_none();
    if std::str::from_utf8(start).map_or_else(cut, |_| true) || start.contains(&0) {
        return None;
    }
    let mut detector = EncodingDetector::new();
    detector.feed(start, false);
    let encoding = detector.guess(None, false);
    let is_eastern = [SHIFT_JIS, GBK, BIG5, EUC_JP, EUC_KR].contains(&encoding);
    // one foreign character may be a unit's sign
    let (text, _, _) = encoding.decode(start);
    let words = text.chars().filter(|c| ('\u{3040}'..='\u{D7A3}').contains(c)).count();
    (is_eastern && words > 1).then_some(encoding)
}

/// Bytes as text: UTF-8, or else Latin-1, of which every byte is a character.
pub(super) fn decoded(bytes: &[u8]) -> String {
    match std::str::from_utf8(bytes) {
        Ok(text) => text.to_string(),
        Err(_) => bytes.iter().map(|byte| char::from(*byte)).collect(),
    }
}

/// A whole table of a spreadsheet as UTF-8 text, whatever its encoding; `None` where it is UTF-8 already.
///
/// Errors: a gzip that ends too early.
pub(crate) fn table_text(name: &str, bytes: &[u8]) -> Result<Option<String>> {
    let starts = |mark: &[u8]| bytes.starts_with(mark);
    let packed = starts(&[0x1F, 0x8B]) || starts(&[0xFF, 0xFE]) || starts(&[0xFE, 0xFF]) || wide_of(bytes).is_some();
    let foreign = std::str::from_utf8(bytes).is_err() && !bytes.contains(&0);
    if !packed && !foreign {
        return Ok(None);
    }
    let mut plain = Vec::new();
    let read = unpacked(io::Cursor::new(bytes.to_vec())).and_then(|mut stream| stream.read_to_end(&mut plain));
    read.map_err(|error| broken(name, &error))?;
    Ok(Some(decoded(&plain)))
}

/// A stream that ended too early, or is no gzip inside.
pub(super) fn broken(name: &str, error: &io::Error) -> Malformed {
    let early = error.kind() == io::ErrorKind::UnexpectedEof;
    Malformed::new(Fault::File, format!("'{name}' cannot be read to its end"))
        .expected(if early { "a whole file; this one was cut off, or is still being written" } else { "a sound file" })
        .found(error.to_string())
        .in_file(name)
}
