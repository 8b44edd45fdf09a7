//! What a picture's file says about its making: the pairs of [`Metadata`](super::Metadata), read back.

use ::exr::meta::MetaData;
use std::fs;
use std::io::Cursor;
use std::path::Path;

/// Keywords and texts of the file: text chunks of a PNG, `comments` of an EXR, comments in the header of an HDR or PPM.
/// Empty if it has none, or is no picture.
pub fn read_metadata(path: &Path) -> Vec<(String, String)> {
    let Ok(bytes) = fs::read(path) else { return Vec::new() };
    match bytes.as_slice() {
        [0x89, b'P', b'N', b'G', ..] => png(&bytes),
        [0x76, 0x2f, 0x31, 0x01, ..] => exr(&bytes),
        [b'#', b'?', ..] => comments(&bytes, |line| line.is_empty()),
        [b'P', b'6', ..] => comments(&bytes, |line| line.first().is_some_and(u8::is_ascii_digit)),
        _ => Vec::new(),
    }
}

fn png(bytes: &[u8]) -> Vec<(String, String)> {
    let Ok(reader) = ::png::Decoder::new(Cursor::new(bytes)).read_info() else { return Vec::new() };
    let info = reader.info();
    let plain = info.uncompressed_latin1_text.iter().map(|chunk| (chunk.keyword.clone(), chunk.text.clone()));
    let unicode =
        info.utf8_text.iter().filter_map(|chunk| Some((chunk.keyword.clone(), chunk.get_text().ok()?)));
    plain.chain(unicode).collect()
}

fn exr(bytes: &[u8]) -> Vec<(String, String)> {
    let Ok(meta) = MetaData::read_from_buffered(Cursor::new(bytes), false) else { return Vec::new() };
    let comments = meta.headers.first().and_then(|header| header.own_attributes.comments.as_ref());
    let text: Vec<u8> = comments.map_or(Vec::new(), |text| text.as_slice().to_vec());
    String::from_utf8_lossy(&text).lines().filter_map(pair).collect()
}

/// The lines `# keyword: text` before the first that `ends` the header.
fn comments(bytes: &[u8], ends: impl Fn(&[u8]) -> bool) -> Vec<(String, String)> {
    let lines = bytes.split(|b| *b == b'\n').skip(1).take_while(|line| !ends(line));
    let texts = lines.filter_map(|line| line.strip_prefix(b"# "));
    texts.filter_map(|line| pair(&String::from_utf8_lossy(line))).collect()
}

fn pair(line: &str) -> Option<(String, String)> {
    line.split_once(": ").map(|(keyword, text)| (keyword.to_owned(), text.to_owned()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::image::{Bits, Format, Metadata, View};

    #[test]
    fn what_was_written_comes_back() {
        let metadata = Metadata::new([("Software", "whitted"), ("Scene", "scenes/ö: 1.toml"), ("Seed", "7")]);
        let folder = tempfile::tempdir().unwrap();
        let view = View { width: 2, height: 1, linear: &[[0.5; 3]; 2] };
        for (format, holds) in [
            (Format::Png(Bits::Eight), 3),
            (Format::Exr, 3),
            (Format::Hdr, 3),
            (Format::Ppm(Bits::Eight), 3),
            (Format::Pfm, 0),
        ] {
            let path = folder.path().join("picture");
            let mut bytes = Vec::new();
            format.encode(view, &metadata, &mut bytes).unwrap();
            fs::write(&path, bytes).unwrap();
            let mut read = read_metadata(&path);
            let mut want: Vec<_> = metadata.iter().map(|(k, v)| (k.to_owned(), v.to_owned())).collect();
            read.sort();
            want.sort();
            assert_eq!(read, want[..holds], "{format:?}");
        }
        assert_eq!(read_metadata(&folder.path().join("none")), []);
    }
}
