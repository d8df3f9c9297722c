//! A fitted model as a file: JSON, with a version, readable by people.

use serde::{Deserialize, Serialize};

use super::Fitted;

/// Written into every file; a file of another version is refused.
const VERSION: u32 = 1;

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct ModelFile {
    /// The version; the key says what the file is.
    torquescope_model: u32,
    fitted: Fitted,
}

/// The text is not a model that this program can read.
#[derive(Debug, thiserror::Error)]
pub enum ModelFileError {
    /// Another version.
    #[error(
        "the model file has version {0}, this program reads version {VERSION}: use the program that wrote it, or train again"
    )]
    Version(u64),
    /// Not a model at all.
    #[error(
        "this is not a model file (it has no key `torquescope_model`): make one with `torquescope train FILE -o model.json`"
    )]
    NotAModel,
    /// Damaged.
    #[error("the model file is damaged: {0} (line {line}, column {column}): train again", line = .0.line(), column = .0.column())]
    Damaged(#[from] serde_json::Error),
    /// The parts do not fit together.
    #[error("the model file is damaged: it holds {found} factors, its terms need {needed}: train again")]
    Factors {
        /// In the file.
        found: usize,
        /// By its terms.
        needed: usize,
    },
}

impl Fitted {
    /// The model as text.
    pub fn to_json(&self) -> String {
        let file = ModelFile { torquescope_model: VERSION, fitted: self.clone() };
        serde_json::to_string_pretty(&file).expect("numbers and texts always have a JSON form")
    }

    /// A model from text.
    ///
    /// # Errors
    /// [`ModelFileError`] says what is wrong and where.
    pub fn from_json(text: &str) -> Result<Fitted, ModelFileError> {
        let value: serde_json::Value = serde_json::from_str(text)?;
        match value.get("torquescope_model").and_then(serde_json::Value::as_u64) {
            None => Err(ModelFileError::NotAModel),
            Some(version) if version != u64::from(VERSION) => Err(ModelFileError::Version(version)),
            Some(_) => {
                let ModelFile { fitted, .. } = serde_json::from_str(text)?;
                let needed = fitted.model.factors(fitted.setting()).map_or(0, |factors| factors.len());
                let found = fitted.factor_count();
                if found == needed { Ok(fitted) } else { Err(ModelFileError::Factors { found, needed }) }
            }
        }
    }
}
