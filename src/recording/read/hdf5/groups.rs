//! Groups that are runs: beside each other in the tree, with the same datasets in each, of different lengths or named like runs
//! (`data/demo_0/q`, `data/demo_1/q`).

use std::collections::BTreeMap;

use ndarray::ArrayD;

/// With one of these words begins the name of a run. Groups of equal lengths with other names are more likely joints.
const WORDS: [&str; 9] = ["run", "demo", "episode", "traj", "trial", "test", "sequence", "experiment", "record"];

/// A run has positions and torques at least.
const FEWEST: usize = 2;

/// Groups of datasets, each a run.
pub(super) struct Runs {
    /// Their names, in the order of what they count.
    names: Vec<String>,
    /// For each dataset of a run, by its number: which run, and its name within.
    places: BTreeMap<usize, (usize, String)>,
}

/// Groups with the same parent: the datasets of each by their names within.
type Siblings<'a> = BTreeMap<&'a str, BTreeMap<&'a str, usize>>;

/// The groups that are runs, nearest to the root, if there are such; datasets are named by their paths and have these lengths.
pub(super) fn runs(names: &[&str], length: impl Fn(usize) -> usize) -> Option<Runs> {
    // By the depth of the parent and its path.
    let mut all: BTreeMap<(usize, &str), Siblings> = BTreeMap::new();
    for (number, name) in names.iter().enumerate() {
        let mut start = 0;
        for (depth, (dot, _)) in name.match_indices('.').enumerate() {
            let parent = &name[..start];
            let siblings = all.entry((depth, parent)).or_default();
            siblings.entry(&name[start..dot]).or_default().insert(&name[dot + 1..], number);
            start = dot + 1;
        }
    }
    let (_, siblings) = all.into_iter().find(|(_, siblings)| are_runs(siblings, &length))?;
    let mut groups: Vec<(&str, BTreeMap<&str, usize>)> = siblings.into_iter().collect();
    groups.sort_by_key(|(name, _)| counted(name));
    let place = |(run, (_, datasets)): (usize, &(&str, BTreeMap<&str, usize>))| {
        datasets.iter().map(|(name, number)| (*number, (run, (*name).to_owned()))).collect::<Vec<_>>()
    };
    let places = groups.iter().enumerate().flat_map(place).collect();
    Some(Runs { names: groups.iter().map(|(name, _)| (*name).to_owned()).collect(), places })
}

/// Whether several groups have most datasets in common, and these are of different lengths or the groups are named like runs.
fn are_runs(siblings: &Siblings, length: &impl Fn(usize) -> usize) -> bool {
    let Some(first) = siblings.values().next() else { return false };
    let most = siblings.values().map(BTreeMap::len).max().unwrap_or(0);
    let is_common = |name: &&&str| siblings.values().all(|datasets| datasets.contains_key(**name));
    let lengths = |name: &str| siblings.values().map(|datasets| length(datasets[name])).collect::<Vec<_>>();
    // What has one row in a run is a constant.
    let signals = first.keys().filter(is_common).map(|name| lengths(name)).filter(|all| all.iter().all(|own| *own > 1));
    let signals: Vec<Vec<usize>> = signals.collect();
    let are_named = siblings.keys().all(|group| {
        let group = group.to_lowercase();
        WORDS.iter().any(|word| group.starts_with(word))
    });
    let differ = |all: &Vec<usize>| all.windows(2).any(|pair| pair[0] != pair[1]);
    let are_alike = siblings.len() > 1 && signals.len() >= FEWEST && 2 * signals.len() >= most;
    are_alike && (are_named || signals.iter().any(differ))
}

/// A name before the number at its end, and that number: run 2 comes before run 10.
fn counted(name: &str) -> (String, u64, String) {
    let word = name.trim_end_matches(|letter: char| letter.is_ascii_digit());
    (word.to_owned(), name[word.len()..].parse().unwrap_or(0), name.to_owned())
}

/// A name within the runs, and its array in each of them.
pub type List = (String, Vec<ArrayD<f64>>);

impl Runs {
    /// Whether a dataset is in a run.
    pub fn has(&self, dataset: usize) -> bool {
        self.places.contains_key(&dataset)
    }

    /// The names of the runs.
    pub fn names(&self) -> Vec<String> {
        self.names.clone()
    }

    /// The arrays of the runs, each given with its dataset and its path, in lists by their names within; and the paths of those that are
    /// not in every run.
    pub fn lists(&self, arrays: Vec<(usize, String, ArrayD<f64>)>) -> (Vec<List>, Vec<String>) {
        let mut by_name: BTreeMap<String, BTreeMap<usize, (String, ArrayD<f64>)>> = BTreeMap::new();
        for (dataset, path, array) in arrays {
            let Some((run, name)) = self.places.get(&dataset) else { continue };
            // A field of a table stands behind the name of the table.
            let tail = path.rfind(name.as_str()).map_or("", |start| &path[start + name.len()..]);
            by_name.entry(format!("{name}{tail}")).or_default().insert(*run, (path, array));
        }
        let (mut lists, mut one_sided) = (Vec::new(), Vec::new());
        for (name, of_runs) in by_name {
            if of_runs.len() == self.names.len() {
                lists.push((name, of_runs.into_values().map(|(_, array)| array).collect()));
            } else {
                one_sided.extend(of_runs.into_values().map(|(path, _)| path));
            }
        }
        (lists, one_sided)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn groups_of_different_lengths_or_named_like_runs_are_runs_and_joints_are_none() {
        let found = |names: &[&str], lengths: &[usize]| {
            runs(names, |dataset| lengths[dataset]).map_or(Vec::new(), |runs| runs.names())
        };
        let swings = ["swings.b10.q", "swings.b10.tau", "swings.b2.q", "swings.b2.tau", "swings.rate"];
        assert_eq!(found(&swings, &[50, 50, 60, 60, 1]), ["b2", "b10"]);
        assert_eq!(found(&["joint1.q", "joint1.tau", "joint2.q", "joint2.tau"], &[50; 4]), [""; 0]);
        assert_eq!(
            found(&["demo_0.obs.q", "demo_0.tau", "demo_1.obs.q", "demo_1.tau"], &[50; 4]),
            ["demo_0", "demo_1"]
        );
        assert_eq!(found(&["robot.q", "robot.tau", "time"], &[50; 3]), [""; 0]);
        let devices = ["arm.time", "arm.q", "arm.tau", "camera.time", "camera.frame"];
        assert_eq!(found(&devices, &[50, 50, 50, 60, 60]), [""; 0], "only a clock in common");
    }
}
