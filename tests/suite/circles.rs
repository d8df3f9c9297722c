//! No circle of files that import each other is larger than three: what stands in a circle can only be understood whole.

use std::collections::{BTreeMap, BTreeSet};

use crate::architecture::{Source, sources};

/// A type and its parts may know each other; more files are a tangle.
const LARGEST: usize = 3;

/// Module paths, as `["effect", "load"]`, and the number of the file that holds each.
type Modules = BTreeMap<Vec<String>, usize>;

fn module(path: &str) -> Vec<String> {
    let bare = path.trim_end_matches(".rs").trim_end_matches("/mod");
    bare.split('/').map(str::to_owned).collect()
}

/// Every path of a `use` tree, groups and names of one's own resolved: `a::{b, c::D as E}` is `a::b` and `a::c::D`.
fn leaves(tree: &str) -> Vec<Vec<String>> {
    let tree = tree.trim();
    let Some((head, group)) = tree.split_once('{') else {
        let path = tree.split(" as ").next().unwrap_or_default();
        return vec![path.split("::").map(|part| part.trim().to_owned()).filter(|part| !part.is_empty()).collect()];
    };
    let head: Vec<String> =
        head.split("::").map(|part| part.trim().to_owned()).filter(|part| !part.is_empty()).collect();
    let group = &group[..group.rfind('}').unwrap_or(group.len())];
    let (mut depth, mut start, mut parts) = (0, 0, Vec::new());
    for (at, letter) in group.char_indices() {
        match letter {
            '{' => depth += 1,
            '}' => depth -= 1,
            ',' if depth == 0 => {
                parts.push(&group[start..at]);
                start = at + 1;
            }
            _ => {}
        }
    }
    parts.push(&group[start..]);
    let own = parts.into_iter().filter(|part| !part.trim().is_empty()).flat_map(leaves);
    own.map(|leaf| head.iter().cloned().chain(leaf.into_iter().filter(|part| part != "self")).collect()).collect()
}

/// The trees of its `use` items, those that only hand on (`pub use`) or not.
fn uses(code: &str, handed_on: bool) -> Vec<Vec<String>> {
    let mut trees = Vec::new();
    let mut item: Option<String> = None;
    for line in code.lines().map(str::trim) {
        let begins = match line.strip_prefix("pub") {
            Some(rest) => {
                let rest = rest.trim_start_matches("(crate)").trim_start_matches("(super)");
                rest.trim_start().strip_prefix("use ").filter(|_| handed_on)
            }
            None => line.strip_prefix("use ").filter(|_| !handed_on),
        };
        match (&mut item, begins) {
            (None, Some(tree)) => item = Some(tree.to_owned()),
            (Some(tree), _) => tree.push_str(line),
            (None, None) => continue,
        }
        if line.ends_with(';') {
            trees.extend(leaves(item.take().unwrap_or_default().trim_end_matches(';')));
        }
    }
    trees
}

/// A path from the crate's root: `crate`, `self` and `super` resolved; `None` for another crate.
fn absolute(leaf: &[String], own: &[String], modules: &Modules) -> Option<Vec<String>> {
    let (first, rest) = leaf.split_first()?;
    let ups = leaf.iter().take_while(|part| *part == "super").count();
    match first.as_str() {
        "crate" => Some(rest.to_vec()),
        "self" => Some([own, rest].concat()),
        "super" => Some([&own[..own.len().checked_sub(ups)?], &leaf[ups..]].concat()),
        _ => {
            let child = [own, &leaf[..1]].concat();
            modules.contains_key(&child).then(|| [own, leaf].concat())
        }
    }
}

/// The file that holds what a path names; what a module hands on is followed to where it stands.
fn home(path: &[String], modules: &Modules, sources: &[Source]) -> Option<usize> {
    let mut path = path.to_vec();
    for _ in 0..8 {
        let known = (1..=path.len()).rev().find(|length| modules.contains_key(&path[..*length]))?;
        let file = modules[&path[..known]];
        let Some(name) = path.get(known) else { return Some(file) };
        let handed = uses(&sources[file].code, true).into_iter().find(|leaf| leaf.last() == Some(name));
        let further = handed.and_then(|leaf| absolute(&leaf, &path[..known], modules));
        match further {
            Some(further) if further != path => path = further,
            _ => return Some(file),
        }
    }
    None
}

fn imports(sources: &[Source]) -> Vec<BTreeSet<usize>> {
    let modules: Modules = sources.iter().enumerate().map(|(file, source)| (module(&source.path), file)).collect();
    let of_file = |(file, source): (usize, &Source)| {
        let own = module(&source.path);
        let paths = uses(&source.code, false).into_iter().filter_map(|leaf| absolute(&leaf, &own, &modules));
        paths.filter_map(|path| home(&path, &modules, sources)).filter(|other| *other != file).collect()
    };
    sources.iter().enumerate().map(of_file).collect()
}

fn reached(from: usize, imports: &[BTreeSet<usize>]) -> BTreeSet<usize> {
    let (mut seen, mut open) = (BTreeSet::new(), vec![from]);
    while let Some(file) = open.pop() {
        open.extend(imports[file].iter().filter(|next| seen.insert(**next)));
    }
    seen
}

/// Files that import each other, over however many others.
fn circles(imports: &[BTreeSet<usize>]) -> BTreeSet<BTreeSet<usize>> {
    let reached: Vec<BTreeSet<usize>> = (0..imports.len()).map(|file| reached(file, imports)).collect();
    let circle = |file: usize| reached[file].iter().copied().filter(|other| reached[*other].contains(&file)).collect();
    (0..imports.len()).map(circle).filter(|circle: &BTreeSet<usize>| !circle.is_empty()).collect()
}

#[test]
fn no_circle_of_imports_is_large() {
    let sources = sources();
    let imports = imports(&sources);
    let arrows: usize = imports.iter().map(BTreeSet::len).sum();
    assert!(arrows > 3 * sources.len() / 2, "{arrows} imports were read in {} files", sources.len());
    for circle in circles(&imports) {
        let files: Vec<&str> = circle.iter().map(|file| sources[*file].path.as_str()).collect();
        assert!(circle.len() <= LARGEST, "{} files import each other: {files:?}", circle.len());
    }
}

#[test]
fn a_circle_is_seen_through_what_a_module_hands_on() {
    let source = |path: &str, code: &str| Source { path: path.to_owned(), code: code.to_owned() };
    let sources = [
        source("room/mod.rs", "mod first;\nmod second;\npub use first::{First, Other as Another};"),
        source("room/first.rs", "use super::second::Second;"),
        source("room/second.rs", "use std::fmt;\nuse crate::{\n    room::{First},\n};"),
    ];
    let imports = imports(&sources);
    assert_eq!(imports, [BTreeSet::new(), BTreeSet::from([2]), BTreeSet::from([1])]);
    assert_eq!(circles(&imports), BTreeSet::from([BTreeSet::from([1, 2])]));
}
