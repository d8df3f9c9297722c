//! Mappings that come with the program: one file in `assets/mappings/` and one line here.

use super::mapping::MappingSpec;

/// Name and text of each.
pub const ALL: &[(&str, &str)] = &[
    ("emps", include_str!("../../assets/mappings/emps.toml")),
    ("kuka-kr300", include_str!("../../assets/mappings/kuka-kr300.toml")),
    ("sarcos", include_str!("../../assets/mappings/sarcos.toml")),
    ("tx40", include_str!("../../assets/mappings/tx40.toml")),
    ("ur10", include_str!("../../assets/mappings/ur10.toml")),
];

/// No mapping has this name.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("there is no mapping `{name}`; there are: {known}")]
pub struct UnknownMapping {
    /// What was asked for.
    pub name: String,
    /// What there is.
    pub known: String,
}

/// The mapping of this name.
///
/// # Errors
/// [`UnknownMapping`] lists the names that exist.
pub fn mapping(name: &str) -> Result<MappingSpec, UnknownMapping> {
    let (_, text) = ALL.iter().find(|(other, _)| *other == name).ok_or_else(|| UnknownMapping {
        name: name.to_owned(),
        known: ALL.iter().map(|(name, _)| *name).collect::<Vec<_>>().join(", "),
    })?;
    Ok(MappingSpec::from_toml(text).expect("a test reads every mapping of the program"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_mapping_can_be_read() {
        for (name, _) in ALL {
            mapping(name).unwrap();
        }
        let message = mapping("panda").unwrap_err().to_string();
        assert!(message.contains("no mapping `panda`; there are: emps, kuka-kr300"), "{message}");
    }
}
