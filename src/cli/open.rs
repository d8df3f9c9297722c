use std::path::Path;

use anyhow::bail;
use clap::error::ErrorKind;
use clap::{Args, Subcommand};

use super::data::OptionalData;
use super::{Arguments, Command};
use crate::app;
use crate::recording::gallery;
use crate::recording::read::parts;

/// Open the window, on recordings or on a saved session.
#[derive(Args)]
#[command(after_help = "Examples:
  torquescope open my-log.csv --zero down
  torquescope open gallery/sticky-shoulder
  torquescope open mine.torquescope")]
pub struct Open {
    #[command(flatten)]
    data: OptionalData,
}

impl Open {
    /// Opens the window and returns when it is closed.
    pub fn run(&self) -> anyhow::Result<()> {
        // Better told here than in a window that has nothing to show.
        for path in self.data.files() {
            let side_by_side = parts(path);
            let are_there = side_by_side.len() > 1 && side_by_side.iter().all(|file| file.exists());
            if !path.exists() && !are_there && gallery::at(path)?.is_none() {
                bail!("there is no file {}", path.display());
            }
        }
        app::run_window(self.data.start()?, Some(self.data.command()?))
    }
}

/// A word that is neither a command nor a file opens no window: it is a command that was mistyped.
pub fn refuse_mistyped_command(arguments: Arguments) -> Result<Arguments, clap::Error> {
    let files = arguments.window.data.files();
    let is_word = |path: &Path| path.extension().is_none() && path.components().count() == 1 && !path.exists();
    match files.first() {
        Some(word) if arguments.command.is_none() && is_word(word) => {
            // clap knows what was meant, once it takes no files.
            let commands = Command::augment_subcommands(clap::Command::new("torquescope").subcommand_required(true));
            let told = commands.try_get_matches_from([Path::new("torquescope"), word]);
            Err(told.err().unwrap_or_else(|| clap::Error::new(ErrorKind::InvalidSubcommand)))
        }
        _ => Ok(arguments),
    }
}

#[cfg(test)]
mod tests {
    use clap::Parser;

    use super::*;
    use crate::session::Command;

    #[test]
    fn a_session_is_restored_by_either_way() {
        for words in [&["torquescope", "mine.torquescope"][..], &["torquescope", "open", "mine.torquescope"]] {
            let arguments = Arguments::try_parse_from(words).unwrap();
            let open = match &arguments.command {
                Some(super::super::Command::Open(open)) => open,
                _ => &arguments.window,
            };
            assert!(
                matches!(open.data.command().unwrap(), Command::Restore { path } if path.ends_with("mine.torquescope"))
            );
        }
    }

    #[test]
    fn a_mistyped_command_is_no_file() {
        let refused = |word: &str| {
            let parsed = Arguments::try_parse_from(["torquescope", word]).and_then(refuse_mistyped_command);
            parsed.err().map(|error| error.to_string())
        };
        assert!(refused("diagnoze").unwrap().contains("a similar subcommand exists: 'diagnose'"));
        assert_eq!(refused("missing.csv"), None);
        assert_eq!(refused("src"), None, "a folder that is there");
    }
}
