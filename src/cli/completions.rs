use std::io::{self, Write};

use anyhow::Context;
use clap::{Args, CommandFactory};
use clap_complete::Shell;

use super::Arguments;

/// Print what lets a shell complete commands, options and their values.
#[derive(Args)]
#[command(after_help = "Examples:
  torquescope completions bash  # append it to ~/.bashrc, or save it as ~/.local/share/bash-completion/completions/torquescope
  torquescope completions zsh   # save it as _torquescope in a folder of $fpath
  torquescope completions fish  # save it as ~/.config/fish/completions/torquescope.fish")]
pub struct Completions {
    /// Which shell.
    shell: Shell,
}

impl Completions {
    /// Prints the script.
    pub fn run(&self) -> anyhow::Result<()> {
        let mut script = Vec::new();
        clap_complete::generate(self.shell, &mut Arguments::command(), "torquescope", &mut script);
        io::stdout().write_all(&script).context("can't print the script")
    }
}
