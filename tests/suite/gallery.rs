//! The recordings that come with the program: each opens from any folder, and is diagnosed as it should be.

use std::process::{Command as Process, Output};

use torquescope::diagnosis::{Note, Verdict};
use torquescope::progress::Monitor;
use torquescope::recording::finding::{FindingKind, Severity};
use torquescope::recording::gallery::{self, Sample};
use torquescope::recording::hold_out::HoldOut;
use torquescope::recording::read::ReadOptions;
use torquescope::session::{Command, Session};
use torquescope::trial::{answer_of, world::truth_of};

/// What else a log says of itself: readings that end at a limit are told when it is opened.
const TOLD: [(&str, FindingKind); 1] = [("clipped-sensor", FindingKind::Saturated)];

/// What stands in for something that no catalogue has, and is named in its place: it must be doubted.
const STANDS_IN: [(&str, &str); 1] = [("welding-hose", "lower-stop")];

fn run(command: Command, session: &Session) -> Session {
    command.run(session, &Monitor::new()).unwrap()
}

fn opened(sample: &Sample) -> Session {
    run(Command::open(vec![sample.path()], ReadOptions::default(), HoldOut::default()), &Session::default())
}

/// Nothing unexpected is found when a sample is opened, a wrong set-up is told with what sets it right, and then the diagnosis
/// names what is sealed and nothing else. What no catalogue has is told to be unknown, and what is known to stand in for it is doubted.
#[test]
fn every_sample_is_diagnosed_as_its_seal_says() {
    let mut kinds = [0; 4];
    for sample in gallery::all() {
        let name = sample.name;
        let mut session = opened(sample);
        let sealed = run(Command::OpenSeal, &session).truth.unwrap();
        let proposed = session.findings.iter().flat_map(|finding| finding.set_right.clone());
        assert_eq!(proposed.collect::<Vec<_>>(), sealed.set_up, "{name}");
        for finding in session.findings.iter().filter(|finding| finding.severity > Severity::Info) {
            let is_sealed = finding.kind == FindingKind::SetUp && !sealed.set_up.is_empty();
            assert!(is_sealed || TOLD.contains(&(name, finding.kind)), "{name}: {finding}");
        }
        if !sealed.set_up.is_empty() {
            session = run(Command::SetRight(sealed.set_up.clone()), &session);
        }
        let report = run(Command::Diagnose, &session).report.unwrap();
        let truth = truth_of(session.recording.as_deref().unwrap(), "gallery", true).unwrap();
        let named: Vec<_> =
            report.effects.iter().flat_map(answer_of).map(|(id, joint)| (id, joint.map(|it| it + 1))).collect();
        for wanted in truth.wanted() {
            let is_named = named.iter().any(|(effect, joint)| wanted.judge(effect, *joint).is_good());
            assert!(is_named, "{name}: {} is not among {named:?}", wanted.effect);
        }
        let is_unknown = truth.planted.iter().any(|planted| planted.unknown);
        for (effect, joint) in &named {
            let is_doubted = STANDS_IN.contains(&(name, effect.as_str())) && report.notes.contains(&Note::MayStandIn);
            assert!(truth.judge(effect, *joint).is_good() || is_doubted, "{name}: {effect} on {joint:?} is not there");
        }
        let is_nothing = truth.planted.is_empty();
        assert_eq!(report.verdict == Verdict::UnknownEffect, is_unknown, "{name}: {:?}", report.verdict);
        assert_eq!(report.verdict == Verdict::NothingMissing, is_nothing, "{name}: {:?}", report.verdict);
        let is_wrong = !sealed.set_up.is_empty();
        for (count, is_so) in kinds.iter_mut().zip([is_nothing && !is_wrong, is_wrong, is_unknown, true]) {
            *count += usize::from(is_so);
        }
    }
    let [nothing, wrong, unknown, all] = kinds;
    assert!(nothing >= 1 && wrong >= 1 && unknown >= 1 && all >= 10, "{kinds:?}");
}

fn torquescope(words: &[&str]) -> Output {
    let folder = tempfile::tempdir().unwrap();
    Process::new(env!("CARGO_BIN_EXE_torquescope")).args(words).current_dir(folder.path()).output().unwrap()
}

fn succeeds(words: &[&str]) -> String {
    let output = torquescope(words);
    assert!(output.status.success(), "{words:?}: {}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8(output.stdout).unwrap()
}

/// They are in the program: no folder has to be there.
#[test]
fn commands_read_samples_from_any_folder() {
    let list = succeeds(&["gallery"]);
    assert!(gallery::all().iter().all(|sample| list.contains(&format!("gallery/{}", sample.name))), "{list}");
    assert!(succeeds(&["inspect", "gallery/healthy-arm"]).contains("Nothing wrong, says the mechanic: 2 joints"));
    let wrong = succeeds(&["seal", "open", "gallery/lost-zero"]);
    assert!(
        wrong.starts_with("set up wrongly: the first link points up at q = 0; right with --set-right zero=up"),
        "{wrong}"
    );
    assert!(
        !succeeds(&["inspect", "gallery/lost-zero", "--zero", "up"]).contains("error:"),
        "what the user says counts"
    );
    let refused = torquescope(&["inspect", "gallery/nowhere"]);
    let said = String::from_utf8_lossy(&refused.stderr).into_owned();
    assert!(
        !refused.status.success() && said.contains("no sample `nowhere` in the gallery; there are: sticky-shoulder"),
        "{said}"
    );
    let two = torquescope(&["inspect", "gallery/healthy-arm", "gallery/lost-zero"]);
    assert!(String::from_utf8_lossy(&two.stderr).contains("read it alone"));
}
