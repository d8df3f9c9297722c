//! What packs or nests other things: gzip, MCAP, Parquet, HDF5 and pickles that lie, repeat themselves or have no bottom.

use std::io::Write;

use flate2::Compression;
use flate2::write::GzEncoder;

use super::Crafted;
use crate::selftest::opener::Kind;
use crate::selftest::seeds::hdf5::File;

/// How much is repeated.
const SIZES: [usize; 4] = [1_000, 30_000, 1_000_000, 8_000_000];

/// All of them; each is a log.
pub fn all() -> std::io::Result<Vec<Crafted>> {
    let mut all = Vec::new();
    for size in SIZES {
        all.extend(packed(size)?);
        all.extend(messages(size));
        all.extend(columns(size));
        all.extend(trees(size));
        all.extend(pickles(size));
    }
    Ok(all.into_iter().map(|(name, bytes)| (name, Kind::Log, bytes)).collect())
}

type Named = (&'static str, Vec<u8>);

fn gzip(bytes: &[u8]) -> std::io::Result<Vec<u8>> {
    let mut encoder = GzEncoder::new(Vec::new(), Compression::best());
    encoder.write_all(bytes)?;
    encoder.finish()
}

/// Zeros, blank lines and a table that packs a hundredfold; files that are packed twice; a file of very many small ones.
fn packed(size: usize) -> std::io::Result<Vec<Named>> {
    let table = [b"time,q1,tau1\n".to_vec(), b"0,0,0\n".repeat(size)].concat();
    Ok(vec![
        ("zeros.csv.gz", gzip(&vec![0; 8 * size])?),
        ("lines.csv.gz", gzip(&vec![b'\n'; 8 * size])?),
        ("table.csv.gz", gzip(&table)?),
        ("twice.csv.gz", gzip(&gzip(&vec![b'1'; 8 * size])?)?),
        ("members.csv.gz", gzip(b"")?.repeat(size / 20)),
    ])
}

/// A record of an MCAP log with this length, true or not.
fn record(kind: u8, length: u64, data: &[u8]) -> Vec<u8> {
    [&[kind][..], &length.to_le_bytes(), data].concat()
}

fn whole(kind: u8, data: &[u8]) -> Vec<u8> {
    record(kind, data.len() as u64, data)
}

/// A text behind its length.
fn text(text: &[u8]) -> Vec<u8> {
    [&(text.len() as u32).to_le_bytes()[..], text].concat()
}

/// Logs of messages: of a schema without a bottom, of arrays without an end, of nothing, and of lengths that lie.
fn messages(size: usize) -> Vec<Named> {
    const MAGIC: &[u8] = b"\x89MCAP0\r\n";
    let log = |records: &[Vec<u8>]| {
        let ends = [whole(0x0f, &[0; 4]), whole(0x02, &[0; 20]), MAGIC.to_vec()].concat();
        [MAGIC.to_vec(), whole(0x01, &[0; 8]), records.concat(), ends].concat()
    };
    let schema =
        |definition: &[u8]| whole(0x03, &[&[1, 0][..], &text(b"p/A"), &text(b"ros2msg"), &text(definition)].concat());
    let channel =
        |id: u16| whole(0x04, &[&id.to_le_bytes()[..], &[1, 0], &text(b"/t"), &text(b"cdr"), &[0; 4]].concat());
    let message = |data: &[u8]| whole(0x05, &[&[1, 0][..], &[0; 4], &[0; 16], data].concat());
    let of = |definition: &[u8], data: &[u8], count: usize| {
        log(&[schema(definition), channel(1), message(data).repeat(count)])
    };
    let rule = format!("\n{}\n", "=".repeat(80));
    let chain: String = (0..size / 100).map(|at| format!("{rule}MSG: p/T{at}\nT{} x\nT{0} y\n", at + 1)).collect();
    vec![
        ("itself.mcap", of(format!("A a{rule}MSG: p/A\nA a\n").as_bytes(), &[0; 64], 10)),
        ("doubled.mcap", of(format!("T0 a\n{chain}").as_bytes(), &[0; 64], 10)),
        ("endless.mcap", of(b"float64[4294967295] position\n", &[0; 64], 10)),
        ("long.mcap", of(b"float64[] position\n", &[0, 1, 0, 0, 255, 255, 255, 255, 0, 0, 0, 0], 10)),
        ("fields.mcap", of("float64 position\n".repeat(size / 20).as_bytes(), &[0; 64], 10)),
        ("nothing.mcap", of(b"\n", &[], size / 31)),
        ("channels.mcap", log(&(0..size / 30).map(|id| channel(id as u16)).collect::<Vec<_>>())),
        ("empty-records.mcap", log(&[whole(0x80, b"").repeat(size / 9)])),
        ("lying.mcap", log(&[record(0x06, u64::MAX, &vec![0; size])])),
        ("chunk.mcap", log(&[whole(0x06, &[&[255; 28][..], &text(b"zstd"), &[255; 8], &vec![0; size]].concat())])),
    ]
}

/// Tables by columns and trees of arrays that are nothing but a beginning.
fn columns(size: usize) -> Vec<Named> {
    let parquet = |footer: &[u8], length: u32| [b"PAR1", footer, &length.to_le_bytes(), b"PAR1"].concat();
    let of = |byte: u8| parquet(&vec![byte; size], size as u32);
    vec![
        ("lying.parquet", parquet(&vec![0; size], u32::MAX)),
        ("lists.parquet", of(0x19)),
        ("structs.parquet", of(0x1c)),
        ("full.parquet", of(0xff)),
        ("zeros.h5", [b"\x89HDF\r\n\x1a\n".to_vec(), vec![0; size]].concat()),
        ("full.h5", [b"\x89HDF\r\n\x1a\n".to_vec(), vec![0xff; size]].concat()),
    ]
}

/// A table that is none of the lies: others differ from it in one thing.
const HONEST: &str = "table.h5";

/// Trees of arrays: tables of rows that lie, whose fields overlap or are wider than they, and groups that all hold the same.
fn trees(size: usize) -> Vec<Named> {
    /// Numbers of eight bytes, the least one first.
    const DOUBLE: [u8; 20] = [0x11, 0x20, 63, 0, 8, 0, 0, 0, 0, 0, 64, 0, 52, 11, 0, 52, 0xff, 3, 0, 0];
    // Rows of so many bytes, and fields: name, where each begins in a row, type.
    let rows = |size: u32, fields: &[(String, u32, Vec<u8>)]| {
        let field = |(name, at, kind): &(String, u32, Vec<u8>)| {
            let wide = if size < 1 << 8 { 1 } else { 4 };
            [name.as_bytes(), &[0], &at.to_le_bytes()[..wide], kind].concat()
        };
        let fields_of: Vec<u8> = fields.iter().flat_map(field).collect();
        let count = (fields.len() as u16).to_le_bytes();
        [&[0x36, count[0], count[1], 0][..], &size.to_le_bytes(), &fields_of].concat()
    };
    let array = |width: u32| {
        let bytes = width.wrapping_mul(8).to_le_bytes();
        [&[0x3a, 0, 0, 0][..], &bytes, &[1], &width.to_le_bytes(), &DOUBLE].concat()
    };
    let named = |count: usize, kind: &[u8]| {
        (0..count).map(|number| (format!("f{number}"), 0, kind.to_vec())).collect::<Vec<_>>()
    };
    let table = |shape: &[u64], kind: &[u8], claimed: u64| {
        let mut file = File::default();
        let data = file.data(&vec![0; size]);
        let table = file.dataset(shape, kind, data, claimed);
        let root = file.group(&[("log", table)]);
        file.finish(root)
    };
    let pair = [("q".to_owned(), 0, DOUBLE.to_vec()), ("tau".to_owned(), 8, DOUBLE.to_vec())];
    let held = size as u64;
    let of_groups = |groups: usize, names: &[&str]| {
        let mut file = File::default();
        let data = file.data(&vec![0; size]);
        let numbers = file.dataset(&[held / 8], &DOUBLE, data, held);
        let links: Vec<(&str, u64)> = names.iter().map(|name| (*name, numbers)).collect();
        let runs: Vec<(String, u64)> = (0..groups).map(|run| (format!("demo_{run}"), file.group(&links))).collect();
        let root = file.group(&runs);
        file.finish(root)
    };
    let ring = {
        let mut file = File::default();
        let here = file.end();
        let root = file.group(&[("demo_0", here), ("demo_1", here)]);
        file.finish(root)
    };
    let shared = {
        let mut file = File::default();
        let data = file.data(&vec![0; size]);
        let link = |number: usize| (format!("q{number}"), file.dataset(&[held / 8], &DOUBLE, data, held));
        let links: Vec<(String, u64)> = (0..500).map(link).collect();
        let root = file.group(&links);
        file.finish(root)
    };
    vec![
        (HONEST, table(&[held / 16], &rows(16, &pair), held)),
        ("shared.h5", shared),
        ("rows.h5", table(&[u64::MAX / 16], &rows(16, &pair), held)),
        ("rows-claimed.h5", table(&[1 << 40], &rows(16, &pair), 16 << 40)),
        ("rows-of-nothing.h5", table(&[held], &rows(0, &pair), held)),
        ("rows-too-short.h5", table(&[held / 4], &rows(4, &pair), held)),
        ("no-fields.h5", table(&[held], &rows(1, &[]), held)),
        ("overlapping-fields.h5", table(&[held / 8], &rows(8, &named(2000, &DOUBLE)), held)),
        ("wide-field.h5", table(&[held / 8], &rows(8, &named(1, &array(u32::MAX))), held)),
        ("fields-in-fields.h5", table(&[held / 8], &rows(8, &named(1, &rows(8, &named(1, &array(1 << 29))))), held)),
        ("same-in-all-runs.h5", of_groups(1000, &["q", "tau"])),
        ("same-in-one-run.h5", of_groups(2, &(0..500).map(|_| "q").collect::<Vec<_>>())),
        ("runs-of-nothing.h5", of_groups((size / 100).min(50_000), &[])),
        ("ring.h5", ring),
    ]
}

/// Python's pickles: nests, lists of themselves, lists that double, lengths that lie, numbers of very many digits.
fn pickles(size: usize) -> Vec<Named> {
    let pickle = |parts: &[&[u8]]| [b"\x80\x03", parts.concat().as_slice(), b"."].concat();
    let doubled: Vec<u8> = (0..(size / 10).min(250) as u8)
        .flat_map(|at| [&[b'(', b'h', at, b'h', at, b'l', b'q', at + 1][..]].concat())
        .collect();
    vec![
        ("nested.pickle", pickle(&[&b"(".repeat(size / 2), &b"l".repeat(size / 2)])),
        ("tuples.pickle", pickle(&[b")", &b"\x85".repeat(size)])),
        ("doubled.pickle", pickle(&[b"]q\x00", &doubled])),
        ("itself.pickle", pickle(&[b"]q\x00", &b"h\x00a".repeat(size / 3)])),
        ("lying.pickle", pickle(&[b"X\xff\xff\xff\xff", &vec![b'x'; size]])),
        ("digits.pickle", pickle(&[b"L", &vec![b'9'; size], b"L\n"])),
        ("marks.pickle", pickle(&[&b"(".repeat(size)])),
        ("copies.pickle", pickle(&[b"K\x01", &b"2".repeat(size)])),
        ("memos.pickle", pickle(&[b"]", &b"\x94".repeat(size)])),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::progress::Monitor;
    use crate::recording::read::{ReadOptions, preview};

    /// Else the others would be refused for something that nobody meant.
    #[test]
    fn a_table_without_lies_is_read() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join(HONEST);
        let (_, bytes) = trees(1600).into_iter().find(|(name, _)| *name == HONEST).unwrap();
        std::fs::write(&path, bytes).unwrap();
        let seen = preview(&path, &ReadOptions::default(), &Monitor::new()).unwrap();
        assert_eq!(seen.names(), ["log.q", "log.tau"]);
        assert_eq!(seen.columns[1].values, [0.0; 100]);
    }
}
