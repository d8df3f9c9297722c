use std::io::{self, Write};
use std::path::PathBuf;

use anyhow::Context;
use clap::{Args, CommandFactory};

use super::{Arguments, output_folder};

/// Print the manual page, or write the pages of all commands.
#[derive(Args)]
#[command(after_help = "Examples:
  torquescope man          # read it with: torquescope man | man -l -
  torquescope man -o man1  # torquescope.1, torquescope-train.1, …")]
pub struct Man {
    /// Folder of the pages of all commands; without it, the first page is printed.
    #[arg(short, long, value_name = "FOLDER")]
    output: Option<PathBuf>,
}

impl Man {
    /// Prints or writes.
    pub fn run(&self) -> anyhow::Result<()> {
        let command = Arguments::command();
        let Some(folder) = &self.output else {
            let mut page = Vec::new();
            clap_mangen::Man::new(command).render(&mut page)?;
            return io::stdout().write_all(&page).context("can't print the page");
        };
        output_folder(folder)?;
        clap_mangen::generate_to(command, folder)
            .with_context(|| format!("can't write the pages into {}", folder.display()))
    }
}
