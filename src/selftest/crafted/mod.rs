//! Files that somebody crafted: bombs, entries that overlap, views, lies about sizes, and files that are no files.

mod containers;

use std::path::{Path, PathBuf};
use std::process::Command;

use zip::CompressionMethod;

use crate::file;
use crate::recording::npy;
use crate::selftest::opener::{Kind, Opener, Request};
use crate::selftest::{Bench, Measure, Score, SelftestError, logs, seeds};

/// See its promise.
pub static MEASURE: Measure = Measure {
    id: "crafted",
    promise: "crafted files of all kinds, and files that are no files: no panic, none computes over 5 s or takes over 64 MiB or \
              four times its size",
    take,
};

/// What is to be opened as what.
struct Craft {
    what: String,
    kind: Kind,
    path: PathBuf,
}

fn take(bench: &Bench) -> Result<Score, SelftestError> {
    let mut crafts = Vec::new();
    let mut left_out = Vec::new();
    let all = [archives()?, texts(), others()?, containers::all()?].concat();
    for (number, (what, kind, bytes)) in all.into_iter().enumerate() {
        let path = bench.path(&format!("{number}-{what}"));
        file::write(&path, &bytes)?;
        crafts.push(Craft { what: what.to_owned(), kind, path });
    }
    match no_files(bench.folder) {
        Ok(paths) => {
            for kind in KINDS {
                let craft =
                    |path: &PathBuf| Craft { what: format!("{kind:?} {}", path.display()), kind, path: path.clone() };
                crafts.extend(paths.iter().map(craft));
            }
        }
        Err(error) => left_out.push(format!("pipes, sockets and devices: {error}")),
    }
    let every = if bench.effort.long { 1 } else { 8 };
    let crafts: Vec<Craft> = crafts.into_iter().step_by(every).take(bench.cases(usize::MAX, usize::MAX)).collect();
    let mut score = Score { cases: crafts.len(), left_out, ..Score::default() };
    let mut opener = Opener::new(&bench.program);
    for (case, craft) in crafts.iter().enumerate() {
        bench.report(case, crafts.len(), "crafted files")?;
        let answer = opener.open_alone(&Request { kind: craft.kind, path: craft.path.clone(), clean: None })?;
        // What is no plain file has no size.
        let size = file::size(&craft.path).unwrap_or(0).min(file::LARGEST);
        logs::survived(&mut score, &craft.what, &answer, size, 0);
    }
    Ok(score)
}

const KINDS: [Kind; 7] =
    [Kind::Log, Kind::Session, Kind::Model, Kind::Checkpoint, Kind::Experiment, Kind::Mapping, Kind::Arm];

type Crafted = (&'static str, Kind, Vec<u8>);

/// Archives of zeros, of parts that are passed over, of too many or overlapping entries, of arrays that lie.
fn archives() -> Result<Vec<Crafted>, SelftestError> {
    let mut all: Vec<Crafted> = Vec::new();
    let zeros = |element: &str, shape: &[usize]| {
        let size = shape.iter().product::<usize>() * 8;
        npy::encode(element, shape, std::iter::repeat_n(0, size))
    };
    let archive = |entries: &[(&str, Vec<u8>)]| {
        let entries: Vec<(String, Vec<u8>)> =
            entries.iter().map(|(name, bytes)| ((*name).to_owned(), bytes.clone())).collect();
        seeds::packed(&entries, CompressionMethod::Deflated)
    };
    for rows in [100_000, 300_000, 1_000_000, 3_000_000, 10_000_000] {
        all.push((
            "zeros.npz",
            Kind::Log,
            archive(&[("q.npy", zeros("<f8", &[rows, 1])), ("tau.npy", zeros("<f8", &[rows, 1]))])?,
        ));
        all.push(("wide.npz", Kind::Log, archive(&[("tau.npy", zeros("<f8", &[rows / 2, 2]))])?));
        all.push(("objects.npz", Kind::Log, archive(&[("a.npy", zeros("|O", &[rows]))])?));
        all.push(("cubes.npz", Kind::Log, archive(&[("a.npy", zeros("<f8", &[rows / 100, 10, 10, 1]))])?));
        all.push(("notes.npz", Kind::Log, archive(&[("notes.txt", vec![b' '; 8 * rows])])?));
        let lists = [b"{\"a\": [".to_vec(), b"[],".repeat(rows / 8), b"[]]}".to_vec()].concat();
        for (name, kind, entry) in [
            ("session.torquescope", Kind::Session, "session.json"),
            ("model.npz", Kind::Model, "model.json"),
            ("run.npz", Kind::Checkpoint, "run.json"),
        ] {
            all.push((name, kind, archive(&[(entry, vec![b'['; 8 * rows]), ("checkpoint.npz", vec![0; 8 * rows])])?));
            all.push((name, kind, archive(&[(entry, vec![b' '; 8 * rows]), ("networks.npz", vec![0; 8 * rows])])?));
            all.push((name, kind, archive(&[(entry, lists.clone()), ("networks.npz", Vec::new())])?));
        }
    }
    for count in [100, 1_000, 10_000, 60_000] {
        let entries: Vec<(String, Vec<u8>)> = (0..count).map(|number| (format!("{number}.npy"), Vec::new())).collect();
        for (name, kind) in [("many.npz", Kind::Log), ("many.torquescope", Kind::Session), ("many.model", Kind::Model)]
        {
            all.push((name, kind, seeds::packed(&entries, CompressionMethod::Stored)?));
        }
    }
    for (size, count) in [(1 << 16, 100), (1 << 18, 500), (1 << 20, 1000), (1 << 20, 4000)] {
        let bomb = archive(&[("a.npy", zeros("<f8", &[size]))])?;
        all.push(("overlapping.npz", Kind::Log, overlapping(&bomb, count)));
        all.push(("overlapping.torquescope", Kind::Session, overlapping(&bomb, count)));
        all.push(("overlapping.model", Kind::Model, overlapping(&bomb, count)));
    }
    for shape in
        ["(1000000000000, 2)", "(18446744073709551615, 2)", "(-3,)", "(", "", "(3000000000,)", "(0, 99999999999)"]
    {
        for element in ["<f8", "|O", "<U4000000000", "[('a', '<f8')]", "<c16"] {
            let header = format!("{{'descr': '{element}', 'fortran_order': False, 'shape': {shape}, }}\n");
            let mut array = b"\x93NUMPY\x01\x00".to_vec();
            array.extend((header.len() as u16).to_le_bytes());
            array.extend(header.bytes());
            array.extend([0; 800]);
            all.push(("lying.npy", Kind::Log, array.clone()));
            all.push(("lying.npz", Kind::Log, archive(&[("q.npy", array.clone()), ("tau.npy", array)])?));
        }
    }
    Ok(all)
}

/// The same archive with its only entry listed so many times.
fn overlapping(archive: &[u8], count: usize) -> Vec<u8> {
    const END: usize = 22;
    const LISTED: [u8; 4] = *b"PK\x01\x02";
    let Some(list) = archive.windows(4).rposition(|part| part == LISTED) else { return archive.to_vec() };
    let end = archive.len() - END;
    let mut bytes = archive[..list].to_vec();
    for number in 0..count {
        let mut entry = archive[list..end].to_vec();
        // Another name for each: its first letter stands behind 46 bytes.
        entry[46] = b'a' + (number % 26) as u8;
        bytes.extend(entry);
    }
    let size = (bytes.len() - list) as u32;
    let mut tail = archive[end..].to_vec();
    tail[8..10].copy_from_slice(&(count as u16).to_le_bytes());
    tail[10..12].copy_from_slice(&(count as u16).to_le_bytes());
    tail[12..16].copy_from_slice(&size.to_le_bytes());
    bytes.extend(tail);
    bytes
}

/// Texts of one line, of no lines, of deep nests, of very many names.
fn texts() -> Vec<Crafted> {
    let mut all: Vec<Crafted> = Vec::new();
    for size in [1_000, 10_000, 100_000, 1_000_000, 8_000_000] {
        let logs: [(&str, Vec<u8>); 10] = [
            ("carriage-returns.csv", b"1,2\r".repeat(size / 4)),
            ("blank-lines.csv", vec![b'\n'; size]),
            ("one-line.csv", b"1,".repeat(size / 2)),
            ("one-word.csv", vec![b'x'; size]),
            ("open-quote.csv", [b"t,q,tau\n\"".to_vec(), b"1,2\n".repeat(size / 4)].concat()),
            ("quotes.csv", vec![b'"'; size]),
            ("comments.csv", b"#\n".repeat(size / 2)),
            ("digits.csv", [b"time,q1,tau1\n0,0,".to_vec(), vec![b'9'; size]].concat()),
            ("zeros.csv", vec![0; size]),
            ("blanks.txt", [b"1".to_vec(), vec![b' '; size], b"2\n".to_vec()].concat()),
        ];
        all.extend(logs.into_iter().map(|(name, bytes)| (name, Kind::Log, bytes)));
        let objects: [(&str, Vec<u8>); 6] = [
            ("nothing.jsonl", b"{}\n".repeat(size / 3)),
            ("nothing.json", [b"[{}".to_vec(), b",{}".repeat(size / 3), b"]".to_vec()].concat()),
            ("lists.json", [b"{\"q\":[[]".to_vec(), b",[]".repeat(size / 3), b"]}".to_vec()].concat()),
            ("keys.jsonl", (0..size / 12).flat_map(|key| format!("{{\"k{key}\":1}}\n").into_bytes()).collect()),
            ("same-key.json", [b"{\"q\":1".to_vec(), b",\"q\":1".repeat(size / 6), b"}".to_vec()].concat()),
            ("name.jsonl", format!("{{\"{}\":1}}\n", "x".repeat(size / 2)).repeat(2).into_bytes()),
        ];
        all.extend(objects.into_iter().map(|(name, bytes)| (name, Kind::Log, bytes)));
        let nested = |open: &str, close: &str| {
            let depth = size / 2;
            [open.repeat(depth), close.repeat(depth)].concat().into_bytes()
        };
        let json = nested("[", "]");
        let toml = [b"a = ".to_vec(), json.clone()].concat();
        let tables = nested("[a.", "b]\n");
        all.push(("nested.json", Kind::Log, json.clone()));
        all.push(("nested.json", Kind::Arm, json.clone()));
        all.push(("nested.json", Kind::Model, nested("{\"a\":", "}")));
        for kind in [Kind::Experiment, Kind::Mapping] {
            all.push(("nested.toml", kind, toml.clone()));
            all.push(("tables.toml", kind, tables.clone()));
            all.push(("dotted.toml", kind, [b"a".to_vec(), b".a".repeat(size / 2), b" = 1\n".to_vec()].concat()));
            all.push((
                "keys.toml",
                kind,
                (0..size / 10).flat_map(|key| format!("k{key} = 1\n").into_bytes()).collect(),
            ));
        }
        let link = r#"{"mass": 1, "length": 1, "com": 0.5, "inertia": 0.1},"#;
        let links = link.repeat(size / link.len());
        all.push(("links.json", Kind::Arm, format!("{{\"links\": [{}]}}", links.trim_end_matches(',')).into_bytes()));
    }
    all
}

/// MATLAB files and bags.
fn others() -> Result<Vec<Crafted>, SelftestError> {
    let mut all: Vec<Crafted> = Vec::new();
    let text = |count: usize| seeds::mat_numbers("", [1, 1], &vec![1.0; count]);
    for size in [1_000, 10_000, 100_000, 1_000_000] {
        let name = "x".repeat(size);
        let fields: Vec<(&str, Vec<u8>)> = (0..2000).map(|_| ("field", text(1))).collect();
        all.push((
            "names.mat",
            Kind::Log,
            seeds::mat_file(&[seeds::mat_packed(&seeds::mat_structure(&name, &fields))?]),
        ));
        let zeros = seeds::mat_numbers("x", [size as u32, 1], &vec![0.0; size]);
        all.push(("zeros.mat", Kind::Log, seeds::mat_file(&[seeds::mat_packed(&zeros)?])));
        all.push(("twice.mat", Kind::Log, seeds::mat_file(&[seeds::mat_packed(&seeds::mat_packed(&zeros)?)?])));
        all.push(("liar.mat", Kind::Log, seeds::mat_file(&[seeds::mat_numbers("x", [u32::MAX, size as u32], &[0.0])])));
        let mut nested = text(1);
        for _ in 0..(size / 1000).min(300) {
            nested = seeds::mat_structure("", &[("a", nested)]);
        }
        all.push(("nested.mat", Kind::Log, seeds::mat_file(&[nested])));
    }
    const TOPICS: &str = "CREATE TABLE topics(id INTEGER PRIMARY KEY, name TEXT, type TEXT, serialization_format TEXT);
         INSERT INTO topics VALUES (1, '/joint_states', 'sensor_msgs/msg/JointState', 'cdr');";
    const MESSAGES: &str =
        "CREATE TABLE messages(id INTEGER PRIMARY KEY, topic_id INTEGER, timestamp INTEGER, data BLOB);";
    let endless = "WITH RECURSIVE n(i) AS (SELECT 1 UNION ALL SELECT i + 1 FROM n)";
    let statements = [
        format!(
            "{TOPICS} CREATE VIEW messages AS {endless} SELECT i AS id, 1 AS topic_id, i AS timestamp, x'00' AS data FROM n;"
        ),
        format!(
            "{TOPICS} CREATE VIEW messages AS SELECT 1 AS id, 1 AS topic_id, 1 AS timestamp, randomblob(900000000) AS data;"
        ),
        format!("{TOPICS} CREATE VIRTUAL TABLE messages USING fts5(topic_id, timestamp, data);"),
        format!(
            "{TOPICS} CREATE TABLE messages(id INTEGER PRIMARY KEY, topic_id INTEGER, timestamp INTEGER, \
             data BLOB GENERATED ALWAYS AS (zeroblob(900000000))); INSERT INTO messages(topic_id, timestamp) VALUES (1, 1);"
        ),
        format!(
            "CREATE VIEW topics AS {endless} SELECT i AS id, 'a' AS name, 'b' AS type, 'c' AS serialization_format FROM n; \
             {MESSAGES}"
        ),
        format!("{TOPICS} {MESSAGES} CREATE TRIGGER t AFTER INSERT ON messages BEGIN DELETE FROM topics; END;"),
        format!("{TOPICS} {MESSAGES} CREATE INDEX i ON messages(timestamp + randomblob(100000000));"),
        format!("{TOPICS} {MESSAGES} INSERT INTO messages VALUES (1, 1, 1, zeroblob(50000000));"),
        format!("{TOPICS} {MESSAGES} {endless} INSERT INTO messages SELECT i, 1, i, x'' FROM n LIMIT 200000;"),
        format!("{endless} SELECT i FROM n LIMIT 1; {MESSAGES}"),
        format!(
            "{TOPICS} CREATE VIEW messages AS SELECT 1 AS topic_id, 2 AS timestamp, x'00' AS data; PRAGMA writable_schema = ON; \
             UPDATE sqlite_master SET type = 'table', rootpage = 2 WHERE name = 'messages';"
        ),
    ];
    for statements in statements {
        // What SQLite itself refuses to make can't be crafted so.
        if let Ok(bytes) = seeds::database(&statements) {
            all.push(("crafted.db3", Kind::Log, bytes));
        }
    }
    Ok(all)
}

/// Files that have no end, no beginning, or no bytes.
#[cfg(unix)]
fn no_files(folder: &Path) -> std::io::Result<Vec<PathBuf>> {
    let path = |name: &str| folder.join(name);
    let pipe = path("pipe.toml");
    if !Command::new("mkfifo").arg(&pipe).status()?.success() {
        return Err(std::io::Error::other("mkfifo fails"));
    }
    let socket = path("socket.toml");
    std::os::unix::net::UnixListener::bind(&socket)?;
    let (looped, link) = (path("loop.toml"), path("zero.toml"));
    std::os::unix::fs::symlink(&looped, &looped)?;
    std::os::unix::fs::symlink("/dev/zero", &link)?;
    let sparse = path("sparse.toml");
    std::fs::OpenOptions::new().create_new(true).write(true).open(&sparse)?.set_len(1 << 33)?;
    let few = path("few-hundred-megabytes.toml");
    std::fs::OpenOptions::new().create_new(true).write(true).open(&few)?.set_len(300 << 20)?;
    let folder = path("folder.toml");
    std::fs::create_dir(&folder)?;
    Ok(vec![pipe, socket, looped, link, sparse, few, folder, PathBuf::from("/dev/zero"), path("nothing.toml")])
}

#[cfg(not(unix))]
fn no_files(_: &Path) -> std::io::Result<Vec<PathBuf>> {
    Err(std::io::Error::other("this system has none"))
}
