//! Damage as disks, copies, editors and fuzzers do it: one random change of some bytes.

use std::io::{Cursor, Read, Write};
use std::ops::Range;

use flate2::read::GzDecoder;
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, DateTime, ZipArchive, ZipWriter};

use super::seeds::gzip;

/// No stretch that is taken out, doubled or overwritten is longer \[bytes\].
const LONGEST: usize = 400;
/// No entry of an archive that is damaged is larger \[bytes\].
const LARGEST_ENTRY: u64 = 1 << 24;

/// Damages what is packed, and packs it again.
type Inside = fn(&[u8], &mut ChaCha8Rng) -> Option<Vec<u8>>;

/// The bytes with one damage. Half of all that is packed is damaged inside and packed again, so that its checksums are right.
pub fn damage(bytes: &[u8], random: &mut ChaCha8Rng) -> Vec<u8> {
    let inside: Option<Inside> = match bytes {
        [b'P', b'K', ..] => Some(in_an_entry),
        [0x1f, 0x8b, ..] => Some(in_the_packed),
        _ => None,
    };
    if let Some(inside) = inside
        && random.random()
        && let Some(packed) = inside(bytes, random)
    {
        return packed;
    }
    let is_text = !bytes.contains(&0) && bytes.contains(&b'\n');
    if is_text && random.random() { in_text(bytes, random) } else { anywhere(bytes, random) }
}

fn stretch(length: usize, random: &mut ChaCha8Rng) -> Range<usize> {
    let start = random.random_range(0..length);
    start..(start + random.random_range(1..=LONGEST)).min(length)
}

fn anywhere(bytes: &[u8], random: &mut ChaCha8Rng) -> Vec<u8> {
    let mut damaged = bytes.to_vec();
    if bytes.is_empty() {
        return vec![random.random()];
    }
    let range = stretch(bytes.len(), random);
    match random.random_range(0..8) {
        0 => {
            for _ in 0..random.random_range(1..=3) {
                let at = random.random_range(0..bytes.len());
                damaged[at] ^= 1 << random.random_range(0..8);
            }
        }
        1 => damaged[range.start] = random.random(),
        2 => damaged.truncate(range.start),
        3 => drop(damaged.drain(range)),
        4 => drop(damaged.splice(range.end..range.end, bytes[range].iter().copied())),
        5 => damaged[range].fill(*[0, 0xff, b'9', b'\n'].get(random.random_range(0..4)).unwrap_or(&0)),
        6 => random.fill(&mut damaged[range]),
        _ => {
            let to = random.random_range(0..bytes.len() - range.len() + 1);
            damaged.copy_within(range, to);
        }
    }
    damaged
}

fn in_text(bytes: &[u8], random: &mut ChaCha8Rng) -> Vec<u8> {
    let mut lines: Vec<Vec<u8>> = bytes.split_inclusive(|byte| *byte == b'\n').map(<[u8]>::to_vec).collect();
    let (one, other) = (random.random_range(0..lines.len()), random.random_range(0..lines.len()));
    let line = &mut lines[one];
    let at = random.random_range(0..line.len());
    match random.random_range(0..7) {
        0 => drop(lines.remove(one)),
        1 => lines.insert(other, lines[one].clone()),
        2 => lines.swap(one, other),
        3 => line[at] = b'0' + random.random_range(0..10),
        4 => drop(line.remove(at)),
        5 => {
            let words: [&[u8]; 6] = [b"nan", b"1e999", b"-1e300", b"", b"[[", b"\"x"];
            drop(line.splice(at..at, words[random.random_range(0..words.len())].iter().copied()));
        }
        _ => line.insert(at, b",;\t.-e\"'{}=#"[random.random_range(0..12)]),
    }
    lines.concat()
}

/// `None` if it is nothing whole that gzip has packed.
fn in_the_packed(bytes: &[u8], random: &mut ChaCha8Rng) -> Option<Vec<u8>> {
    let mut content = Vec::new();
    GzDecoder::new(bytes).take(LARGEST_ENTRY).read_to_end(&mut content).ok()?;
    gzip(&damage(&content, random)).ok()
}

/// `None` if it is no whole archive.
fn in_an_entry(bytes: &[u8], random: &mut ChaCha8Rng) -> Option<Vec<u8>> {
    let mut archive = ZipArchive::new(Cursor::new(bytes)).ok()?;
    let count = archive.len();
    if count == 0 {
        return None;
    }
    let which = random.random_range(0..count);
    let mut packed = ZipWriter::new(Cursor::new(Vec::new()));
    let options = SimpleFileOptions::default()
        .compression_method(CompressionMethod::Stored)
        .last_modified_time(DateTime::default());
    for index in 0..count {
        let entry = archive.by_index(index).ok()?;
        let name = entry.name().ok()?.into_owned();
        let mut content = Vec::new();
        entry.take(LARGEST_ENTRY).read_to_end(&mut content).ok()?;
        if index == which {
            content = damage(&content, random);
        }
        packed.start_file(name, options).ok()?;
        packed.write_all(&content).ok()?;
    }
    Some(packed.finish().ok()?.into_inner())
}

#[cfg(test)]
mod tests {
    use rand::SeedableRng;

    use super::*;

    #[test]
    fn every_draw_changes_something_and_the_same_seed_changes_the_same() {
        let text: Vec<u8> = (0..40).flat_map(|row| format!("{row},{}\n", 0.5 * f64::from(row)).into_bytes()).collect();
        let draw = |seed| damage(&text, &mut ChaCha8Rng::seed_from_u64(seed));
        let changed = (0..100).filter(|&seed| draw(seed) != text).count();
        assert!(changed > 80, "{changed}");
        assert!((0..100).all(|seed| draw(seed) == draw(seed)));
        for odd in [&b""[..], b"\n", b"PK", b"\x1f\x8b"] {
            (0..50).for_each(|seed| drop(damage(odd, &mut ChaCha8Rng::seed_from_u64(seed))));
        }
    }
}
