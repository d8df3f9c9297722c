//! Mappings that come with the program: one file in `assets/mappings/` and one line here.

use super::mapping::{Mapping, MappingSpec};

/// Name and text of each.
pub const ALL: &[(&str, &str)] = &[
    ("emps", include_str!("../../assets/mappings/emps.toml")),
    ("kuka-kr300", include_str!("../../assets/mappings/kuka-kr300.toml")),
    ("panda", include_str!("../../assets/mappings/panda.toml")),
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

/// The mappings that find position and torque of every joint among columns of these names, with what each is for.
pub fn fitting(columns: &[String]) -> Vec<(&'static str, &'static str, MappingSpec)> {
    let told = |text: &'static str| text.lines().next().unwrap_or_default().trim_start_matches(['#', ' ']);
    let read = |(name, text): &(&'static str, &'static str)| Some((*name, told(text), mapping(name).ok()?));
    let fits = |(.., spec): &(&str, &str, MappingSpec)| {
        let joints = Mapping::find(columns, spec).ok().map(|found| found.q.len());
        joints.is_some_and(|joints| spec.chain.as_ref().is_none_or(|chain| chain.axes.len() == joints))
    };
    ALL.iter().filter_map(read).filter(fits).collect()
}

/// A mapping that states nothing but so many axes, so that it is for any log of its robot, and the name of that.
pub fn with_axes(count: usize) -> Option<(&'static str, &'static str)> {
    let robot = |text: &'static str| text.split(':').next().unwrap_or_default().trim_start_matches(['#', ' ']);
    let is_it = |name: &str| {
        let spec = mapping(name).ok();
        spec.is_some_and(|spec| spec.q.is_none() && spec.chain.is_some_and(|chain| chain.axes.len() == count))
    };
    ALL.iter().find(|(name, _)| is_it(name)).map(|(name, text)| (*name, robot(text)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn mappings_are_offered_for_logs_that_have_their_columns() {
        let named = |columns: &[String]| fitting(columns).iter().map(|(name, ..)| *name).collect::<Vec<_>>();
        assert_eq!(named(&["qm", "t", "vir", "qg"].map(str::to_owned)), ["emps"]);
        assert!(named(&["qm", "t", "current"].map(str::to_owned)).is_empty());
        let of = |file: &str| (1..=6).map(|joint| format!("{file}.Joint_{joint}")).collect::<Vec<_>>();
        assert_eq!(named(&[of("pos_read_data"), of("curr_data")].concat()), ["tx40"]);
    }

    #[test]
    fn axes_that_are_stated_alone_are_of_the_robots_with_as_many() {
        assert_eq!(with_axes(6), Some(("ur10", "Universal Robots UR10")));
        assert_eq!(with_axes(7), Some(("panda", "Franka Emika Panda (FER) and Franka Research 3")));
        assert_eq!(with_axes(3), None);
    }

    #[test]
    fn every_mapping_can_be_read() {
        for (name, _) in ALL {
            mapping(name).unwrap();
        }
        let message = mapping("pander").unwrap_err().to_string();
        assert!(message.contains("no mapping `pander`; there are: emps, kuka-kr300, panda"), "{message}");
    }
}
