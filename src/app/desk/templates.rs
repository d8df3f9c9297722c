//! Templates of mappings that were saved, to be offered again for logs of the same columns.

use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use crate::file;

/// How many are remembered.
const MOST: usize = 16;

/// A mapping file, and the columns of the log that it was made for.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
struct Template {
    columns: Vec<String>,
    path: PathBuf,
}

/// Mapping files, the newest first.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(transparent)]
pub struct Templates(Vec<Template>);

impl Templates {
    /// Remembers a mapping file for logs of these columns, in place of an older one.
    pub fn add(&mut self, columns: Vec<String>, path: &Path) {
        self.0.retain(|other| other.columns != columns);
        self.0.insert(0, Template { columns, path: file::absolute(path) });
        self.0.truncate(MOST);
    }

    /// The mapping file for a log of these columns, if it is still there.
    pub fn of<'a>(&self, columns: impl Iterator<Item = &'a str> + Clone) -> Option<&Path> {
        let is_alike = |template: &&Template| template.columns.iter().map(String::as_str).eq(columns.clone());
        self.0.iter().find(is_alike).map(|template| template.path.as_path()).filter(|path| path.exists())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_newest_template_of_the_same_columns_is_found_while_it_is_there() {
        let folder = tempfile::tempdir().unwrap();
        let [old, new] = ["old.toml", "new.toml"].map(|name| folder.path().join(name));
        [&old, &new].iter().for_each(|path| std::fs::write(path, "").unwrap());
        let mut templates = Templates::default();
        templates.add(vec!["t".into(), "a".into()], &old);
        templates.add(vec!["t".into(), "a".into()], &new);
        assert_eq!(templates.of(["t", "a"].into_iter()), Some(new.as_path()));
        assert_eq!(templates.of(["a", "t"].into_iter()), None);
        std::fs::remove_file(&new).unwrap();
        assert_eq!(templates.of(["t", "a"].into_iter()), None);
    }
}
