//! Lessons on the command line: listed, checked, graded; and a seal that is opened there.

use std::fs;

use torquescope::lesson::{begin, catalogue};
use torquescope::progress::Monitor;
use torquescope::session::{Session, file};

use crate::runner::{fails, json, succeeds, torquescope};

#[test]
fn lessons_are_listed_and_drawn_for_a_class() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    let text = succeeds(&["lesson"], at);
    assert!(text.contains("Find the hidden effect") && text.contains("Take one: torquescope lesson 1"), "{text}");
    let listed = json(&["lesson", "--json"], at);
    assert!(listed.as_array().unwrap().iter().any(|lesson| lesson["number"] == 6 && lesson["points"] == 12.0));
    let seeds = |class: &str| succeeds(&["lesson", "seeds", "6", "--class", class, "--count", "3"], at);
    assert_eq!(seeds("one"), seeds("one"));
    assert_ne!(seeds("one"), seeds("two"));
    assert_eq!(seeds("one").lines().count(), 3);
    assert!(fails(&["lesson", "77", "--seed", "3"], at, 2).contains("there is no lesson `77`"));
}

#[test]
fn a_lecturers_file_is_checked() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    let source = catalogue::find("6").unwrap().source;
    fs::create_dir(at.join("en")).unwrap();
    fs::write(at.join("mine.toml"), &source.data).unwrap();
    assert!(fails(&["lesson", "check", "mine.toml"], at, 2).contains("can't read en/mine.toml"));
    fs::write(at.join("en/mine.toml"), &source.text).unwrap();
    assert!(succeeds(&["lesson", "check", "mine.toml"], at).contains("10 steps, 12 points"));
    fs::write(at.join("mine.toml"), source.data.replacen("\"compare\"", "\"compere\"", 1)).unwrap();
    let line = 1 + source.data[..source.data.find("\"compare\"").unwrap()].matches('\n').count();
    let message = fails(&["lesson", "check", "mine.toml"], at, 2);
    assert!(message.contains(&format!("line {line}, column 10: there is no screen `compere`")), "{message}");
}

#[test]
fn sessions_are_graded_and_seals_opened() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    let begun = begin(&catalogue::find("6").unwrap(), 17, 1000).unwrap().command;
    let session = begun.run(&Session::default(), &Monitor::new()).unwrap();
    file::save(&at.join("student.torquescope"), &session.into()).unwrap();
    let graded = &json(&["lesson", "grade", "student.torquescope", "--json"], at)[0];
    assert_eq!((&graded["lesson"], &graded["seed"]), (&"hidden-effect".into(), &17.into()));
    assert_eq!((&graded["finished"], &graded["tampered"]), (&false.into(), &serde_json::Value::Null));
    let locked = fails(&["seal", "open", "student.torquescope"], at, 1);
    assert!(locked.contains("the lesson keeps the seal locked"), "{locked}");
    succeeds(&["simulate", "--effect", "coulomb-friction@2=1.5", "-o", "mystery.npz"], at);
    let opened = succeeds(&["seal", "open", "mystery.npz"], at);
    assert!(opened.contains("coulomb-friction on joint 2") && opened.contains("1.500"), "{opened}");
    let opened = json(&["seal", "open", "mystery.npz", "--json"], at);
    assert_eq!((&opened["effects"][0]["joint"], &opened["seed"]), (&2.into(), &1.into()));
    // A file that is no session does not keep the others from their grade.
    fs::write(at.join("broken.torquescope"), "no session").unwrap();
    let words = ["lesson", "grade", "broken.torquescope", "student.torquescope", "--csv"];
    let output = torquescope(&words, at).output().unwrap();
    let (table, told) = (String::from_utf8(output.stdout).unwrap(), String::from_utf8(output.stderr).unwrap());
    assert!(output.status.code() == Some(1) && told.contains("1 of 2 sessions could not be graded"), "{told}");
    let lines: Vec<&str> = table.lines().collect();
    assert!(lines[0].starts_with("file,lesson,seed,points,of,passed") && lines[1].contains("not a session"), "{table}");
    assert!(lines[2].starts_with("student.torquescope,hidden-effect,17,0.00,12,no,no,0.0,0,0,no"), "{table}");
}
