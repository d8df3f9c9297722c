//! What a command that can't do its work says, and how it ends: 1 if it failed, 2 if it was used in a wrong way.

use std::process::ExitCode;

use serde_json::json;

use crate::file;

/// Wrong usage: something on the command line, or in a file that an option names, can't be. Nothing was begun.
#[derive(Debug, thiserror::Error)]
#[error(transparent)]
struct Usage(anyhow::Error);

/// Marks errors as wrong usage.
pub trait OrUsage<T> {
    /// The same, ending with the exit code of wrong usage if it is an error.
    ///
    /// # Errors
    /// As before.
    fn or_usage(self) -> anyhow::Result<T>;
}

impl<T, E: Into<anyhow::Error>> OrUsage<T> for Result<T, E> {
    fn or_usage(self) -> anyhow::Result<T> {
        self.map_err(|error| Usage(error.into()).into())
    }
}

/// Tells why a command ended, on standard error, and with `--json` as an object on standard output too.
pub fn tell(error: &anyhow::Error, as_json: bool) -> ExitCode {
    let reason = file::without_number(&reason(error));
    eprintln!("error: {reason}");
    end(&reason, if error.is::<Usage>() { 2 } else { 1 }, as_json)
}

/// The same of arguments that could not be parsed. Help and version are no failures: they are printed, too.
pub fn tell_parsing(error: &clap::Error, as_json: bool) -> ExitCode {
    // A closed pipe is not worth a message.
    let _ = error.print();
    if !error.use_stderr() {
        return ExitCode::SUCCESS;
    }
    let text = error.render().to_string();
    let reason = text.split("\n\nUsage:").next().unwrap_or_default();
    end(reason.strip_prefix("error: ").unwrap_or(reason).trim(), 2, as_json)
}

fn end(reason: &str, code: u8, as_json: bool) -> ExitCode {
    if as_json {
        println!("{}", json!({ "reason": reason, "code": code }));
    }
    ExitCode::from(code)
}

/// The error with its causes. Most of the library's errors say their cause themselves, and are not to say it twice.
fn reason(error: &anyhow::Error) -> String {
    let mut text = String::new();
    for cause in error.chain().map(ToString::to_string) {
        if text.is_empty() {
            text = cause;
        } else if !text.contains(&cause) {
            text = format!("{text}: {cause}");
        }
    }
    text
}

#[cfg(test)]
mod tests {
    use anyhow::Context;

    use super::*;
    use crate::effect::registry;
    use crate::simulation::SimulationError;

    #[test]
    fn a_cause_is_told_once() {
        let Err(unknown) = registry::find("magic") else { panic!("there is magic") };
        let simulation = SimulationError::from(unknown);
        let told = reason(&anyhow::Error::from(simulation).context("arm.json"));
        assert_eq!(told.matches("there is no effect `magic`").count(), 1, "{told}");
        assert!(told.starts_with("arm.json: hidden effect: there is no effect"), "{told}");
        let system = std::fs::read("no/such/file").context("can't read it").unwrap_err();
        assert!(reason(&system).starts_with("can't read it: No such file"), "{}", reason(&system));
    }

    #[test]
    fn wrong_usage_keeps_its_words() {
        let error = std::fs::read("no/such/file").context("can't read it").or_usage().unwrap_err();
        assert!(error.is::<Usage>() && reason(&error).starts_with("can't read it: No such file"), "{error:#}");
    }
}
