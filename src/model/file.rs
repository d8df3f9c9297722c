//! A fitted model as a file: JSON, with a version, readable by people.

use serde::{Deserialize, Serialize};

use super::{Fitted, Model};
use crate::effect::own::{self, OwnEffectError};

/// Written into every file; a file of another version is refused.
const VERSION: u32 = 1;

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct ModelFile {
    /// The version; the key says what the file is.
    torquescope_model: u32,
    /// The files of effects of one's own that are in it.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    own_effects: Vec<String>,
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
    /// An effect of one's own that it brings along.
    #[error("an effect of one's own in the model file: {0}")]
    OwnEffect(#[from] OwnEffectError),
    /// The parts do not fit together.
    #[error("the model file is damaged: it holds {found} factors, its terms need {needed}: train again")]
    Factors {
        /// In the file.
        found: usize,
        /// By its terms.
        needed: usize,
    },
}

/// Loads the effects of one's own that a file brings along under the key `own_effects`: before anything in it that has one
/// by its id can be read.
///
/// # Errors
/// [`OwnEffectError`] if one is damaged, or is another one than that which is in use.
pub fn load_own_effects(file: &serde_json::Value) -> Result<(), OwnEffectError> {
    let texts = file.get("own_effects").and_then(serde_json::Value::as_array);
    texts.into_iter().flatten().filter_map(serde_json::Value::as_str).try_for_each(|text| own::load(text).map(|_| ()))
}

impl Model {
    /// The files of effects of one's own that are in it.
    pub fn own_effects(&self) -> Vec<String> {
        own::texts(self.effects().map(|term| term.effect))
    }
}

impl Fitted {
    /// The model as text.
    pub fn to_json(&self) -> String {
        let file =
            ModelFile { torquescope_model: VERSION, own_effects: self.model.own_effects(), fitted: self.clone() };
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
                load_own_effects(&value)?;
                let ModelFile { fitted, .. } = serde_json::from_str(text)?;
                let needed = fitted.model.factors(fitted.setting()).map_or(0, |factors| factors.len());
                let found = fitted.factor_count();
                if found == needed { Ok(fitted) } else { Err(ModelFileError::Factors { found, needed }) }
            }
        }
    }
}
