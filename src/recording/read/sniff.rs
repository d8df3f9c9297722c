//! What a file is, told from its bytes, and whether its name says so.

use super::hdf5::MATLAB;

/// What we can read: the one list of it, for file dialogs, texts and help.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Format {
    /// Numbers as text, in columns.
    Csv,
    /// A ZIP archive, which we hope holds numpy arrays.
    Npz,
    /// A single numpy array.
    Npy,
    /// A MATLAB file of version 5 to 7.2.
    Mat,
    /// A ROS 2 bag: an SQLite database.
    Bag,
    /// JSON, or JSON Lines.
    Json,
    /// HDF5, which MATLAB writes since version 7.3.
    Hdf5,
    /// A log of messages, as rosbag2 writes it now.
    Mcap,
    /// A table by columns, as pandas and LeRobot write it.
    Parquet,
    /// What Python's `pickle` writes, as far as it is plain data.
    Pickle,
}

/// All formats in the words of a sentence, such as `Recordings (…)`.
pub const READABLE: &str = "CSV, NPZ, NPY, JSON, MATLAB, HDF5, MCAP, Parquet, Python pickle or ROS 2 bag";

impl Format {
    /// All of them, the commonest first.
    pub const ALL: [Format; 10] = [
        Format::Csv,
        Format::Npz,
        Format::Npy,
        Format::Json,
        Format::Mat,
        Format::Hdf5,
        Format::Mcap,
        Format::Parquet,
        Format::Pickle,
        Format::Bag,
    ];

    /// Its name for people.
    pub fn name(self) -> &'static str {
        match self {
            Format::Csv => "CSV",
            Format::Npz => "NPZ",
            Format::Npy => "NPY",
            Format::Mat => "MATLAB",
            Format::Bag => "ROS 2 bag",
            Format::Json => "JSON",
            Format::Hdf5 => "HDF5",
            Format::Mcap => "MCAP",
            Format::Parquet => "Parquet",
            Format::Pickle => "Python pickle",
        }
    }

    /// The endings of its files' names.
    pub fn endings(self) -> &'static [&'static str] {
        match self {
            Format::Csv => &["csv", "tsv", "txt"],
            Format::Npz => &["npz"],
            Format::Npy => &["npy"],
            Format::Mat => &["mat"],
            Format::Bag => &["db3"],
            Format::Json => &["json", "jsonl", "ndjson"],
            Format::Hdf5 => &["h5", "hdf5", "mat"],
            Format::Mcap => &["mcap"],
            Format::Parquet => &["parquet"],
            Format::Pickle => &["pickle", "pkl"],
        }
    }

    /// What a file of it is, seen from its bytes alone.
    fn is(self) -> &'static str {
        match self {
            Format::Csv => "text",
            Format::Npz => "a ZIP archive",
            Format::Npy => "a single numpy array",
            Format::Mat => "a MATLAB file",
            Format::Bag => "an SQLite database",
            Format::Json => "JSON",
            Format::Hdf5 => "an HDF5 file",
            Format::Mcap => "an MCAP log",
            Format::Parquet => "a Parquet file",
            Format::Pickle => "a Python pickle",
        }
    }
}

/// The ending of files that are packed with gzip; the one before it tells what is in them.
pub const PACKED: &str = "gz";

/// The endings of all files that can be read.
pub fn endings() -> impl Iterator<Item = &'static str> {
    Format::ALL.into_iter().flat_map(Format::endings).copied().chain([PACKED])
}

/// The file is not one that we read.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum FormatError {
    /// No byte at all, or blanks only.
    #[error("the file is empty; perhaps the recording or the copy was broken off")]
    Empty,
    /// Something we know, but do not read.
    #[error("it is {is}, which is not read; {remedy}")]
    Unsupported {
        /// What it is.
        is: &'static str,
        /// How to get something readable.
        remedy: &'static str,
    },
    /// Bytes that look like nothing we know.
    #[error(
        "it is neither text with columns of numbers nor anything else that is read ({READABLE}); export the log as CSV or NPZ"
    )]
    Unknown,
    /// It is readable, but its name promises something else.
    #[error("its name ends in .{ending}, but it holds {is}; rename it if that is what you want to read")]
    Misnamed {
        /// The ending.
        ending: String,
        /// What it holds.
        is: &'static str,
    },
}

const TO_CSV: &str = "export the log as CSV or NPZ";
const UNPACK: &str = "unpack it and read the file inside";
const UTF_16: &str = "text in UTF-16";
/// First bytes, what they tell, and what to do.
const SIGNATURES: &[(&[u8], &str, &str)] = &[
    (b"#ROSBAG", "a ROS bag", TO_CSV),
    (b"ULog\x01", "a ULog file", TO_CSV),
    (b"\x89PNG\r\n\x1a\n", "a PNG image", "choose the log itself"),
    (b"\xff\xd8\xff", "a JPEG image", "choose the log itself"),
    (b"%PDF", "a PDF document", "choose the log itself"),
    (b"\x7fELF", "a program", "choose the log itself"),
    (b"BZh", "compressed with bzip2", UNPACK),
    (b"\xfd7zXZ\0", "compressed with xz", UNPACK),
    (b"7z\xbc\xaf\x27\x1c", "a 7z archive", UNPACK),
    (b"\xff\xfe", UTF_16, "save it as UTF-8 (in a terminal: iconv -f UTF-16 -t UTF-8 log.csv > log8.csv)"),
    (b"\xfe\xff", UTF_16, "save it as UTF-8 (in a terminal: iconv -f UTF-16 -t UTF-8 log.csv > log8.csv)"),
    (b"version https://git-lfs", "a Git LFS pointer, not the data", "fetch the data with `git lfs pull`"),
];

/// As much of a file tells what it is \[bytes\].
pub(super) const LOOKED_AT: usize = 1 << 16;
/// Endings that promise something that is not read.
const UNREAD: [&str; 3] = ["bag", "xlsx", "png"];

/// Tells the format from the first bytes, and compares it with the ending of the name (without dot, any case, may be empty).
///
/// # Errors
/// [`FormatError`] says what it seems to be instead, and what to do.
pub fn sniff(bytes: &[u8], ending: &str) -> Result<Format, FormatError> {
    let format = by_bytes(bytes)?;
    let ending = ending.to_lowercase();
    let is_of = |other: &Format| other.endings().contains(&ending.as_str());
    let promises_other = |other: &Format| !is_of(&format) && is_of(other);
    if UNREAD.contains(&ending.as_str()) || Format::ALL.iter().any(promises_other) {
        return Err(FormatError::Misnamed { ending, is: format.is() });
    }
    Ok(format)
}

fn by_bytes(bytes: &[u8]) -> Result<Format, FormatError> {
    let head = &bytes[..bytes.len().min(LOOKED_AT)];
    let text = head.strip_prefix(b"\xef\xbb\xbf").unwrap_or(head);
    let Some(first) = text.iter().find(|byte| !byte.is_ascii_whitespace()) else {
        // A file that begins with many blanks is no log either.
        return Err(FormatError::Empty);
    };
    let unsupported = |is, remedy| Err(FormatError::Unsupported { is, remedy });
    if let Some((_, is, remedy)) = SIGNATURES.iter().find(|(signature, ..)| bytes.starts_with(signature)) {
        return unsupported(is, remedy);
    }
    if bytes.starts_with(b"\x93NUMPY") {
        return Ok(Format::Npy);
    }
    if bytes.starts_with(MATLAB) || bytes.starts_with(b"\x89HDF\r\n\x1a\n") {
        return Ok(Format::Hdf5);
    }
    if bytes.starts_with(b"MATLAB 5.0") {
        return Ok(Format::Mat);
    }
    if bytes.starts_with(b"SQLite format 3\0") {
        return Ok(Format::Bag);
    }
    if bytes.starts_with(b"\x89MCAP0\r\n") {
        return Ok(Format::Mcap);
    }
    if bytes.starts_with(b"PAR1") {
        return Ok(Format::Parquet);
    }
    if bytes.starts_with(b"PK\x03\x04") || bytes.starts_with(b"PK\x05\x06") {
        return Ok(Format::Npz);
    }
    if is_pickle(bytes) {
        return Ok(Format::Pickle);
    }
    if let Some(remedy) = unmarked_utf_16(head) {
        return unsupported(UTF_16, remedy);
    }
    if head.iter().any(|byte| byte.is_ascii_control() && !byte.is_ascii_whitespace()) {
        return Err(FormatError::Unknown);
    }
    match first {
        b'{' | b'[' => Ok(Format::Json),
        b'<' => unsupported("XML or a web page", "download the file itself, as CSV or NPZ"),
        _ => Ok(Format::Csv),
    }
}

/// How to read text in UTF-16 without the mark that it should begin with; `None` if it is none: in a log every other byte is zero.
fn unmarked_utf_16(head: &[u8]) -> Option<&'static str> {
    let (pairs, _) = head.as_chunks::<2>();
    let are = |zero: usize| pairs.len() > 1 && pairs.iter().all(|pair| pair[zero] == 0 && pair[1 - zero] != 0);
    if are(1) {
        return Some("save it as UTF-8 (in a terminal: iconv -f UTF-16LE -t UTF-8 log.csv > log8.csv)");
    }
    are(0).then_some("save it as UTF-8 (in a terminal: iconv -f UTF-16BE -t UTF-8 log.csv > log8.csv)")
}

/// A pickle tells its protocol, or begins as dicts, lists and arrays do without one.
fn is_pickle(bytes: &[u8]) -> bool {
    /// How those without a protocol begin: lists and dicts are put away by a number at once.
    const BEGINNINGS: [&[u8]; 10] = [
        b"(dp0\n",
        b"(dp1\n",
        b"(lp0\n",
        b"(lp1\n",
        b"}q",
        b"]q",
        b"ccopy_reg\n",
        b"cnumpy",
        b"c_codecs\n",
        b"ccollections\n",
    ];
    let is_told = matches!(bytes, [0x80, 2..=5, ..]);
    is_told || BEGINNINGS.iter().any(|beginning| bytes.starts_with(beginning))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tells_files_apart_by_their_bytes() {
        assert_eq!(sniff(b"time,q1\n0,1\n", "csv"), Ok(Format::Csv));
        assert_eq!(sniff(b"\xef\xbb\xbftime,q1\n0,1\n", ""), Ok(Format::Csv));
        assert_eq!(sniff(b"PK\x03\x04...", "NPZ"), Ok(Format::Npz));
        for (bytes, word) in [
            (&b""[..], "empty"),
            (b" \n\t\r\n", "empty"),
            (b"\x80\x03}q\x00.", "a Python pickle; rename"),
            (b"(dp0\n.", "a Python pickle; rename"),
            (b"MATLAB 7.3 MAT-file, Platform", "an HDF5 file; rename"),
            (b"MATLAB 5.0 MAT-file, Platform", "a MATLAB file; rename"),
            (b"\x89HDF\r\n\x1a\n", "an HDF5 file; rename"),
            (b"SQLite format 3\0", "an SQLite database; rename"),
            (b"PAR1\0PAR1", "a Parquet file; rename"),
            (b"\x89PNG\r\n\x1a\n", "PNG"),
            (b"\xff\xfet\0i\0", "UTF-16"),
            (b"t\0i\0m\0e\0,\0", "UTF-16LE"),
            (b"\0t\0i\0m\0e\0,", "UTF-16BE"),
            (b"{\"q\": 1}", "JSON"),
            (b"<!doctype html>", "web page"),
            (b"\x93NUMPY\x01\0", "a single numpy array; rename"),
            (b"\0\x01\x02\x03", "neither"),
        ] {
            let message = sniff(bytes, "csv").unwrap_err().to_string();
            assert!(message.contains(word), "{message}");
        }
    }

    #[test]
    fn the_words_for_what_is_read_name_every_format() {
        let names = Format::ALL.map(Format::name);
        let (last, others) = names.split_last().unwrap();
        assert_eq!(READABLE, format!("{} or {last}", others.join(", ")));
        assert!(["csv", "tsv", "npy", "mat", "db3"].iter().all(|ending| endings().any(|known| known == *ending)));
    }

    #[test]
    fn a_name_that_promises_something_else_is_an_error() {
        assert!(sniff(b"time,q1\n", "npz").unwrap_err().to_string().contains(".npz, but it holds text"));
        assert!(sniff(b"PK\x03\x04", "csv").unwrap_err().to_string().contains("ZIP"));
        assert!(sniff(b"time,q1\n", "mat").is_err());
        assert!(sniff(b"time,q1\n", "log").is_ok());
    }
}
