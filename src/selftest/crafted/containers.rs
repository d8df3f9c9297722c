//! What packs or nests other things: gzip, MCAP, Parquet, HDF5 and pickles that lie, repeat themselves or have no bottom.

use std::io::Write;

use flate2::Compression;
use flate2::write::GzEncoder;

use super::Crafted;
use crate::selftest::opener::Kind;

/// How much is repeated.
const SIZES: [usize; 4] = [1_000, 30_000, 1_000_000, 8_000_000];

/// All of them; each is a log.
pub fn all() -> std::io::Result<Vec<Crafted>> {
    let mut all = Vec::new();
    for size in SIZES {
        all.extend(packed(size)?);
        all.extend(messages(size));
        all.extend(columns(size));
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
