//! Python pickles as data only: dicts, lists, texts, numbers and numpy arrays of protocols 0 to 5, as numpy, plain Python and dill write
//! them.
//!
//! The `machine` makes the things that a pickle holds, without ever running anything; `log` makes a table of those that are arrays.

mod log;
mod machine;

use log::Log;
use machine::Machine;

use super::arrays::{ArraysError, DEEPEST};
use super::budget::Budget;
use super::table::Table;
use crate::progress::Monitor;
use crate::recording::npy::NpyError;

/// The file can't be read.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum PickleError {
    /// It asks for something of Python that is no plain data.
    #[error(
        "it asks for `{name}` of Python, which is no plain data and is not run here. Convert it where you trust it, in Python: \
         d = pickle.load(open('log.pickle', 'rb')); numpy.savez('log.npz', time=d['t'], q=d['q'], qd=d['qd'], tau=d['tau'])"
    )]
    Global {
        /// Module and name.
        name: String,
    },
    /// It is cut or damaged.
    #[error("byte {at}: {problem}; copy the file again, or write it anew with pickle.dump")]
    Damaged {
        /// Counted from 0.
        at: usize,
        /// What is wrong.
        problem: &'static str,
    },
    /// An array of it is damaged.
    #[error("byte {at}: {problem}")]
    Array {
        /// Where it is put together, counted from 0.
        at: usize,
        /// What is wrong.
        problem: NpyError,
    },
    /// Its numbers are not in the file.
    #[error(
        "the numbers of its arrays were written into another file (`buffer_callback`); write it with pickle.dump(d, file) alone"
    )]
    Elsewhere,
    /// Each of its numbers is a thing of Python.
    #[error(
        "its numbers are single ones of Python, and too many of them; make arrays of them before you write it: \
         pickle.dump({{key: numpy.array(value) for key, value in d.items()}}, file)"
    )]
    Plain,
    /// Things in things in things.
    #[error(
        "its dicts and lists lie more than {DEEPEST} deep in each other, or in themselves; a log is a dict of arrays"
    )]
    Deep,
    /// Its arrays make no table, would take too much memory, or were not read to the end.
    #[error(transparent)]
    Arrays(ArraysError),
}

impl<E: Into<ArraysError>> From<E> for PickleError {
    fn from(problem: E) -> Self {
        PickleError::Arrays(problem.into())
    }
}

/// Reads a file.
pub(super) fn read(bytes: &[u8], budget: &mut Budget, monitor: &Monitor) -> Result<Table, PickleError> {
    let mut machine = Machine::new(bytes, budget);
    let root = machine.run(monitor)?;
    let (things, budget) = machine.made();
    let mut log = Log::new(&things, budget);
    log.take(&[root], "", 0)?;
    log.table(monitor)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The same log in four protocols (`tests/data/README.md` tells how).
    const LOGS: [&[u8]; 4] = [
        include_bytes!("../../../../tests/data/log0.pickle"),
        include_bytes!("../../../../tests/data/log2.pickle"),
        include_bytes!("../../../../tests/data/log4.pickle"),
        include_bytes!("../../../../tests/data/log5.pickle"),
    ];
    /// Three runs of different lengths.
    const RUNS: &[u8] = include_bytes!("../../../../tests/data/runs.pickle");

    fn table(bytes: &[u8]) -> Result<Table, PickleError> {
        read(bytes, &mut Budget::of(bytes.len() as u64, 1 << 30), &Monitor::new())
    }

    fn problem(bytes: &[u8]) -> String {
        table(bytes).unwrap_err().to_string()
    }

    #[test]
    fn every_protocol_gives_the_same_columns() {
        for (number, bytes) in LOGS.iter().enumerate() {
            let table = table(bytes).unwrap_or_else(|error| panic!("{number}: {error}"));
            let value = |name: &str, row: usize| {
                table.column(name).unwrap_or_else(|| panic!("{:?}", table.names())).values[row]
            };
            assert_eq!((value("t", 30), value("q[0]", 31), value("q[1]", 31)), (0.3, 31.0, -31.0));
            assert_eq!((value("qd[0]", 7), value("qd[1]", 7), value("tau[1]", 59)), (3.5, -3.5, -58.5));
            assert_eq!((value("count", 59), value("big", 58)), (59.0, 58.0));
            assert_eq!((table.constants["gear"].first(), table.constants["n"].first()), (Some(&2.5), Some(&3.0)));
            assert!(table.passed_over.iter().any(|part| part.contains("`labels`")), "{:?}", table.passed_over);
        }
    }

    #[test]
    fn lists_of_arrays_are_runs() {
        let table = table(RUNS).unwrap();
        assert_eq!(table.runs, [0..20, 20..50, 50..60]);
        assert_eq!((table.run_name(19), table.run_name(20)), (Some("x"), Some("y")));
        let values = |name: &str| &table.column(name).unwrap().values;
        assert_eq!((values("qp[1]")[25], values("tau[0]")[59], values("t")[20]), (-25.0, 59.5, 0.0));
        assert!(table.passed_over.iter().any(|part| part.contains("mass_matrix")), "{:?}", table.passed_over);
    }

    /// `[{"q": [i, 2 i], "tau": 0.5 i} for i in range(3)]` of plain Python, in protocol 0.
    #[test]
    fn a_list_of_dicts_is_read_by_their_keys() {
        let sample = |i: i32| format!("(dS'q'\n(lI{i}\naI{}\nasS'tau'\nF{}\nsa", 2 * i, 0.5 * f64::from(i));
        let text = format!("(l{}.", (0..3).map(sample).collect::<String>());
        let table = table(text.as_bytes()).unwrap();
        assert_eq!(table.names(), ["q[0]", "q[1]", "tau"]);
        assert_eq!((table.column("q[1]").unwrap().values[2], table.column("tau").unwrap().values[2]), (4.0, 1.0));
    }

    #[test]
    fn whatever_is_no_data_is_refused_by_its_name() {
        assert!(problem(b"cos\nsystem\n(S'true'\ntR.").contains("`os.system`"));
        assert!(problem(b"\x80\x04\x8c\x08builtins\x8c\x04eval\x93\x8c\x011\x85R.").contains("`builtins.eval`"));
        assert!(problem(b"(S'true'\nios\nsystem\n.").contains("`os.system`"));
        assert!(problem(b"cdill._dill\n_import_module\n(S'os'\ntR.").contains("`os`"));
        assert!(problem(b"\x80\x02cpandas.core.frame\nDataFrame\n)\x81.").contains("`pandas.core.frame.DataFrame`"));
        assert!(problem(b"cos\nsystem\n.").contains("numpy.savez"), "it says how to convert");
        assert!(problem(b"\x80\x05\x97.").contains("another file"));
        for persistent in [&b"Pfile\n."[..], b"N\x82\x01.", b"N)\x81.", b"NNo."] {
            assert!(matches!(table(persistent), Err(PickleError::Global { .. } | PickleError::Damaged { .. })));
        }
    }

    #[test]
    fn bombs_and_circles_are_refused() {
        // A list that holds itself, and lists that hold the one before twenty times, thirty deep.
        assert_eq!(table(b"]q\0h\0a."), Err(PickleError::Deep));
        let mut shared = b"](K\x01K\x02eq\0".to_vec();
        for _ in 0..30 {
            shared.extend(b"](");
            shared.extend(b"h\0".repeat(20));
            shared.extend(b"eq\0");
        }
        shared.push(b'.');
        assert!(matches!(table(&shared), Err(PickleError::Deep | PickleError::Arrays(ArraysError::TooMuch(_)))));
        // The same as dicts.
        let mut shared = b"}(S'a'\nK\x01uq\0".to_vec();
        for _ in 0..12 {
            shared.extend(b"}(");
            (0..20).for_each(|key| shared.extend(format!("S'{key}'\nh\0").bytes()));
            shared.extend(b"uq\0");
        }
        shared.push(b'.');
        assert!(matches!(table(&shared), Err(PickleError::Deep | PickleError::Arrays(ArraysError::TooMuch(_)))));
        // Sizes that are not there.
        for lie in [
            &b"\x80\x03B\xff\xff\xff\xff"[..],
            b"\x80\x04\x8e\xff\xff\xff\xff\xff\xff\xff\xff",
            b"\x80\x04\x8b\xff\xff\xff\x7f",
        ] {
            assert!(problem(lie).contains("announced"), "{}", problem(lie));
        }
        // One byte of a file makes a thing of many.
        let nothing = [vec![b'N'; 2 << 20], vec![b'.']].concat();
        assert!(matches!(table(&nothing), Err(PickleError::Arrays(ArraysError::TooMuch(_)))));
        let numbers = [vec![b'K'; 2 << 20], vec![b'.']].concat();
        assert_eq!(table(&numbers), Err(PickleError::Plain));
        let array = b"cnumpy.core.multiarray\n_reconstruct\n(cnumpy\nndarray\n(I0\ntS'b'\ntR(I1\n(I1000000000\nI1000000000\ntcnumpy\ndtype\n(S'f8'\nI0\nI1\ntR(I3\nS'<'\nNNNI-1\nI-1\nI0\ntbI00\nS'12345678'\ntb.";
        assert!(problem(array).contains("takes 8000000000000000000 bytes, but 8 follow"), "{}", problem(array));
    }

    #[test]
    fn cut_and_damaged_files_are_errors_and_never_more() {
        for bytes in [LOGS[0], LOGS[3], RUNS] {
            for end in (0..bytes.len() - 1).step_by(31) {
                assert!(table(&bytes[..end]).is_err(), "{end}");
            }
            for place in (0..bytes.len()).step_by(13) {
                for flip in [0xff, 0x01, 0x20] {
                    let mut damaged = bytes.to_vec();
                    damaged[place] ^= flip;
                    let _ = table(&damaged);
                }
            }
        }
    }
}
