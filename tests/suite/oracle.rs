//! Reference vectors that were computed by other programs.

use std::fs::File;
use std::io::Read;
use std::path::Path;

use zip::ZipArchive;

/// One NPZ file of reference vectors.
pub struct Oracle(ZipArchive<File>);

impl Oracle {
    /// Opens the file.
    pub fn open(path: &Path) -> Self {
        let file = File::open(path).unwrap();
        Oracle(ZipArchive::new(file).unwrap())
    }

    /// An array of whole or real numbers of 8 bytes, in C order.
    ///
    /// Read by hand (NPY format 1.0), so that the reference does not pass through the readers that are under test.
    pub fn array(&mut self, name: &str) -> Vec<f64> {
        let mut bytes = Vec::new();
        self.0.by_name(&format!("{name}.npy")).unwrap().read_to_end(&mut bytes).unwrap();
        assert_eq!(&bytes[..8], b"\x93NUMPY\x01\x00", "{name} is not an NPY array of version 1.0");
        let start = 10 + usize::from(u16::from_le_bytes([bytes[8], bytes[9]]));
        let header = String::from_utf8_lossy(&bytes[10..start]);
        let decode = match &header {
            real if real.contains("'<f8'") => f64::from_le_bytes,
            whole if whole.contains("'<i8'") => |bytes| i64::from_le_bytes(bytes) as f64,
            other => panic!("{name} is neither of f64 nor of i64: {other}"),
        };
        bytes[start..].as_chunks().0.iter().copied().map(decode).collect()
    }
}
