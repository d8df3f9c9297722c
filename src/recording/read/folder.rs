//! Folders that hold logs: the parts of a ROS 2 bag, the episodes of a LeRobot dataset, or runs of one kind.

use std::collections::BTreeSet;
use std::io;
use std::path::{Path, PathBuf};

use super::sniff::{Format, PACKED};
use crate::file;

/// What rosbag2 writes beside the parts of a bag.
const BAG: &str = "metadata.yaml";
/// Where LeRobot keeps episodes, beside what it tells of them.
const EPISODES: [&str; 2] = ["data", "meta"];
/// Folders in the folder of episodes: one for each thousand of them.
const DEEPEST: usize = 3;

/// The logs of a folder, in the order of their names; `None` if it is none, or holds arrays that belong together.
///
/// # Errors
/// If it can't be read, holds no log, or logs of several kinds.
pub fn logs(path: &Path) -> io::Result<Option<Vec<PathBuf>>> {
    if !path.is_dir() {
        return Ok(None);
    }
    let [data, meta] = EPISODES.map(|name| path.join(name));
    let is_bag = path.join(BAG).is_file();
    let files = match data.is_dir() && meta.is_dir() {
        true => file::within(&data, DEEPEST)?,
        false => file::within(path, 0)?,
    };
    let mut logs: Vec<(Format, PathBuf)> =
        files.into_iter().filter_map(|file| Some((format_of(&file)?, file))).collect();
    if logs.iter().any(|(format, _)| *format == Format::Npy) {
        return Ok(None);
    }
    logs.retain(|(format, _)| !is_bag || [Format::Bag, Format::Mcap].contains(format));
    logs.sort_by(|(_, one), (_, other)| one.cmp(other));
    let kinds: BTreeSet<&str> = logs.iter().map(|(format, _)| format.name()).collect();
    match kinds.len() {
        0 => Err(io::Error::other("it is a folder without a log that can be read; name the files themselves")),
        1 => Ok(Some(logs.into_iter().map(|(_, file)| file).collect())),
        _ => {
            let kinds = kinds.into_iter().collect::<Vec<_>>().join(", ");
            let what = format!("it is a folder with logs of several kinds ({kinds}); name the files themselves");
            Err(io::Error::other(what))
        }
    }
}

/// What a file is by the ending of its name, below that of what packs it.
fn format_of(file: &Path) -> Option<Format> {
    let ending = |file: &Path| file.extension().map(|ending| ending.to_string_lossy().to_lowercase());
    let own = match ending(file)? {
        packed if packed == PACKED => ending(Path::new(file.file_stem()?))?,
        own => own,
    };
    Format::ALL.into_iter().find(|format| format.endings().contains(&own.as_str()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_logs_of_a_folder_are_of_one_kind() {
        let folder = tempfile::tempdir().unwrap();
        let with = |name: &str, files: &[&str]| {
            let path = folder.path().join(name);
            for file in files {
                let file = path.join(file);
                std::fs::create_dir_all(file.parent().unwrap()).unwrap();
                std::fs::write(file, "").unwrap();
            }
            path
        };
        let names = |path: &Path| -> Result<Vec<String>, String> {
            let logs = logs(path).map_err(|problem| problem.to_string())?.unwrap();
            Ok(logs.iter().map(|log| log.strip_prefix(path).unwrap().to_string_lossy().replace('\\', "/")).collect())
        };
        let runs = with("runs", &["b.csv", "a.csv.gz", "photo.png", "deeper/c.csv"]);
        assert_eq!(names(&runs).unwrap(), ["a.csv.gz", "b.csv"]);
        let bag = with("bag", &["bag_1.mcap", "bag_0.mcap", "metadata.yaml", "notes.txt"]);
        assert_eq!(names(&bag).unwrap(), ["bag_0.mcap", "bag_1.mcap"]);
        let episodes = with("lerobot", &["data/chunk-000/episode_0.parquet", "meta/info.json", "videos/x.mp4"]);
        assert_eq!(names(&episodes).unwrap(), ["data/chunk-000/episode_0.parquet"]);
        let mixed = with("mixed", &["a.csv", "b.mat"]);
        assert!(names(&mixed).unwrap_err().contains("several kinds (CSV, MATLAB)"));
        assert!(names(&with("none", &["photo.png"])).unwrap_err().contains("without a log"));
        assert_eq!(logs(&with("arrays", &["q.npy", "README.txt"])).unwrap(), None);
        assert_eq!(logs(&runs.join("b.csv")).unwrap(), None);
    }
}
