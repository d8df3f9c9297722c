//! What is stated of a torque has its consequences: no gravity where none is in it, and silence that is not taken for absence.

use torquescope::arm::chain::{Axis, Chain, Convention};
use torquescope::diagnosis::{NotKnown, Report, Verdict};
use torquescope::model::Preset;
use torquescope::prelude::*;
use torquescope::recording::encoders::Side;
use torquescope::recording::finding::FindingKind;
use torquescope::recording::mapping::MappingSpec;
use torquescope::recording::read::{Import, read};
use torquescope::recording::torque::{TorqueFact, TorqueFacts};
use torquescope::recording::write::{to_csv_bytes, to_npz_bytes};
use torquescope::signals::Signals;

/// The embedded arm with what is hidden in it, from fewer and shorter runs.
fn simulated(hides: bool) -> (Scenario, Recording) {
    let mut scenario = Scenario::embedded();
    if let Excitation::MultiSine { trajectories, duration, rate, .. } = &mut scenario.motion {
        (*trajectories, *duration, *rate) = (6, 5.0, 60.0);
    }
    if !hides {
        scenario.effects.clear();
    }
    let recording = simulate(&scenario, &Monitor::new()).unwrap();
    (scenario, Recording { seal: None, ..recording })
}

/// What a controller that compensates gravity writes down.
fn less_gravity(scenario: &Scenario, mut recording: Recording) -> Recording {
    for run in &mut recording.trajectories {
        let still = Signals::zeros(run.joint_count(), run.len());
        let mut torque = run.tau.clone();
        torque.add(&scenario.arm.inverse_dynamics_along(&run.q, &still, &still), -1.0);
        run.set_torque(torque).unwrap();
    }
    recording
}

fn stating(recording: &Recording, facts: &[TorqueFact]) -> Recording {
    Recording { torque: TorqueFacts::new(facts.iter().copied()).unwrap(), ..recording.clone() }
}

/// The greatest held-out nMSE over that of noise alone.
fn over_noise(preset: Preset, recording: &Recording) -> f64 {
    let split = Split::automatic(recording);
    let model = preset.model(recording).unwrap();
    let fitted = torquescope::model::fit(&model, recording, &split, &Monitor::new()).unwrap();
    let evaluation = Evaluation::of(&fitted, recording, &split).unwrap();
    let floor = evaluation.noise_floor_nmse.clone().unwrap();
    evaluation.held_out_nmse().iter().zip(floor).map(|(nmse, floor)| nmse / floor).fold(0.0, f64::max)
}

fn diagnosed(recording: &Recording) -> Report {
    let split = Split::automatic(recording);
    let model = Preset::RigidBody.model(recording).unwrap();
    let fitted = torquescope::model::fit(&model, recording, &split, &Monitor::new()).unwrap();
    torquescope::diagnosis::diagnose(&fitted, recording, &split, &Monitor::new()).unwrap()
}

/// The axes of the planar arm as those of one in space, whose gravity and inertia share their parameters.
fn in_space(scenario: &Scenario, recording: &Recording) -> Recording {
    let theta = |joint: usize| if joint == 0 { scenario.arm.posture.zero_angle } else { 0.0 };
    let axis = |(joint, link): (usize, &torquescope::arm::Link)| Axis {
        a: link.length,
        theta: theta(joint),
        ..Axis::default()
    };
    let axes = scenario.arm.links.iter().enumerate().map(axis).collect();
    let chain = Chain { convention: Convention::Standard, axes, gravity: [0.0, -scenario.arm.gravity, 0.0] };
    Recording { chain: Some(chain), stated_arm: None, posture: None, ..recording.clone() }
}

#[test]
fn without_gravity_the_rigid_body_fits_to_the_noise_if_that_is_stated() {
    let (scenario, recording) = simulated(false);
    let logged = less_gravity(&scenario, recording);
    let stated = stating(&logged, &[TorqueFact::WithoutGravity]);
    for (preset, of) in [(Preset::StatedArm, logged.clone()), (Preset::RigidBody, in_space(&scenario, &logged))] {
        let told = over_noise(preset, &stating(&of, &[TorqueFact::WithoutGravity]));
        let untold = over_noise(preset, &of);
        assert!(told < 1.5 && untold > 10.0, "{}: {told} of the noise if stated, {untold} if not", preset.id());
    }
    assert!(over_noise(Preset::RigidBody, &stated) < 1.5);
    let report = diagnosed(&stated);
    assert!(report.effects.is_empty(), "{}", report.advice());
    assert!(report.advice().contains("what the links weigh"), "{}", report.advice());
}

#[test]
fn effects_are_found_in_a_torque_without_gravity_too() {
    let (scenario, recording) = simulated(true);
    let report = diagnosed(&stating(&less_gravity(&scenario, recording), &[TorqueFact::WithoutGravity]));
    assert_eq!((report.verdict, report.effects[0].effect.id), (Verdict::Missing, "coulomb-friction"));
    assert_eq!(report.effects[0].joints, [0, 1]);
}

#[test]
fn silence_about_friction_is_no_absence_where_friction_was_compensated() {
    let (_, recording) = simulated(false);
    let silent = diagnosed(&recording);
    assert_eq!(silent.headline(), "Nothing is missing.");
    for fact in [TorqueFact::WithoutFriction, TorqueFact::Link] {
        let report = diagnosed(&stating(&recording, &[fact]));
        assert!(report.not_known.contains(&NotKnown::NotInTorque { fact }));
        assert!(report.headline().contains("not all that the joints felt"), "{}", report.headline());
        assert!(report.advice().contains("no sign that none is there"), "{}", report.advice());
        let json = serde_json::to_value(&report).unwrap();
        assert_eq!(json["not_known"][0]["fact"], fact.name());
    }
}

/// A formula that takes the encoders to be where they are not is not tried, and that is said.
#[test]
fn where_the_encoders_are_rules_out_what_takes_them_to_be_elsewhere() {
    let (_, recording) = simulated(true);
    let left_out = |encoders| -> Vec<String> {
        let report = diagnosed(&Recording { encoders, ..recording.clone() });
        let is_elsewhere = |unknown: &&NotKnown| unknown.text().contains("the other side of the gears");
        let tried = |id: &str| report.ranking.iter().any(|candidate| candidate.effect.id == id);
        assert_eq!(tried("joint-elasticity"), encoders != Some(Side::Motor));
        assert_eq!(tried("motor-side-elasticity"), encoders != Some(Side::Link));
        report.not_known.iter().filter(is_elsewhere).map(NotKnown::text).collect()
    };
    assert_eq!(left_out(None).len(), 0);
    for (side, other) in [(Side::Motor, "links"), (Side::Link, "motors")] {
        let told = left_out(Some(side));
        assert!(told.len() == 2 && told.iter().all(|text| text.contains(other)), "{told:?}");
    }
}

fn read_csv(recording: &Recording, options: &ReadOptions) -> Import {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("log.csv");
    std::fs::write(&path, to_csv_bytes(&recording.trajectories[0])).unwrap();
    read(&[path], options, &Monitor::new()).unwrap()
}

#[test]
fn what_is_stated_is_read_kept_and_told() {
    let (_, recording) = simulated(false);
    let spec =
        MappingSpec::from_toml("torque = [\"motor\", \"commanded\", \"without-friction\"]\nencoders = \"motor\"\n")
            .unwrap();
    assert_eq!(MappingSpec::from_toml(&spec.to_toml().unwrap()).unwrap(), spec);
    let options = ReadOptions { mapping: Some(spec), ..ReadOptions::default() };
    let import = read_csv(&recording, &options);
    assert!(import.recording.torque.has(TorqueFact::Motor) && import.recording.torque.has(TorqueFact::WithoutFriction));
    assert_eq!(import.recording.encoders, Some(Side::Motor));
    let kinds: Vec<FindingKind> = import.findings.iter().map(|finding| finding.kind).collect();
    assert!(kinds.contains(&FindingKind::MotorSide) && kinds.contains(&FindingKind::Commanded), "{kinds:?}");
    // What is said beside the mapping counts more.
    let link = TorqueFacts::new([TorqueFact::Link]).unwrap();
    let options = ReadOptions { torque: Some(link.clone()), encoders: Some(Side::Link), ..options };
    let said_anew = read_csv(&recording, &options).recording;
    assert_eq!((said_anew.torque, said_anew.encoders), (link.clone(), Some(Side::Link)));
    // Our own file keeps it, and it may be said anew.
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("log.npz");
    std::fs::write(&path, to_npz_bytes(&import.recording).unwrap()).unwrap();
    let again = |options: &ReadOptions| read(std::slice::from_ref(&path), options, &Monitor::new()).unwrap().recording;
    assert_eq!(again(&ReadOptions::default()), import.recording);
    assert_eq!((again(&options).torque, again(&options).encoders), (link, Some(Side::Link)));
    let both = MappingSpec::from_toml("torque = [\"link\", \"motor\"]\n").unwrap_err().to_string();
    assert!(both.contains("both `link` and `motor`"), "{both}");
}

// ── encoder only ──

/// Runs with the command that makes this torque, instead of it.
fn commanded(recording: &Recording, command: impl Fn(f64, f64, f64) -> f64) -> Vec<String> {
    let text = |run: &torquescope::recording::Trajectory| {
        let joints = 0..run.joint_count();
        let head: String = joints.clone().map(|joint| format!(",q{joint},qd{joint},qdd{joint},u{joint}")).collect();
        let row = |sample: usize| {
            let of = |joint: usize| {
                let [q, qd, qdd, tau] = [&run.q, &run.qd, &run.qdd, &run.tau].map(|signal| signal[joint][sample]);
                format!(",{q:?},{qd:?},{qdd:?},{:?}", command(q, qd, tau))
            };
            format!("{:?}{}\n", run.time[sample], joints.clone().map(of).collect::<String>())
        };
        format!("time{head}\n{}", (0..run.len()).map(row).collect::<String>())
    };
    recording.trajectories.iter().map(text).collect()
}

fn read_texts(texts: &[String], mapping: &str, more: &ReadOptions) -> Result<Import, String> {
    let folder = tempfile::tempdir().unwrap();
    let path = |number: usize| folder.path().join(format!("run{number}.csv"));
    texts.iter().enumerate().for_each(|(number, text)| std::fs::write(path(number), text).unwrap());
    let paths: Vec<_> = (0..texts.len()).map(path).collect();
    let mapping = MappingSpec::from_toml(mapping).map_err(|error| error.to_string())?;
    assert_eq!(MappingSpec::from_toml(&mapping.to_toml().unwrap()).unwrap(), mapping);
    let options = ReadOptions { mapping: Some(mapping), ..more.clone() };
    read(&paths, &options, &Monitor::new()).map_err(|error| error.to_string())
}

#[test]
fn a_log_of_commands_is_diagnosed_by_the_law_of_the_drive() {
    let (scenario, recording) = simulated(true);
    let (kp, kd) = (80.0, 6.0);
    let position = commanded(&recording, |q, qd, tau| q + (tau + kd * qd) / kp);
    // A motor of 0.06 N m/A, 0.05 V s/rad and 1.5 Ω behind a gear of 60, whose drive logs the share of 48 V.
    let duty = commanded(&recording, |_, qd, tau| (tau * 1.5 / (0.06 * 60.0) + 0.05 * 60.0 * qd) / 48.0);
    let by_position = "[command]\ncolumns = \"u*\"\n[drive]\nlaw = \"position\"\nkp = 80\nkd = [6, 6, 6]\n";
    let by_voltage = "[command]\ncolumns = \"u*\"\nfactor = 48\n[drive]\nlaw = \"voltage\"\nkt = 0.06\nke = 0.05\n\
                      resistance = 1.5\nratio = 60\n";
    let options = ReadOptions { arm: Some(scenario.arm.clone()), ..ReadOptions::default() };
    for (texts, mapping, absorbs) in [(position, by_position, "kd is viscous"), (duty, by_voltage, "ke is viscous")] {
        let import = read_texts(&texts, mapping, &options).unwrap();
        let told = import.findings.iter().find(|finding| finding.kind == FindingKind::Drive).unwrap();
        assert!(told.remedy.contains(absorbs), "{told}");
        for (read, true_run) in import.recording.trajectories.iter().zip(&recording.trajectories) {
            let error =
                read.tau[1].iter().zip(&true_run.tau[1]).map(|(read, truth)| (read - truth).abs()).fold(0.0, f64::max);
            assert!(error < 1e-9, "{error}");
        }
        let report = diagnosed(&import.recording);
        assert_eq!((report.effects[0].effect.id, &report.effects[0].joints[..]), ("coulomb-friction", &[0, 1][..]));
        assert!(report.not_known.contains(&NotKnown::NotInTorque { fact: TorqueFact::Commanded }));
    }
}

#[test]
fn what_a_law_lacks_is_told_by_name() {
    let (_, recording) = simulated(false);
    let texts = commanded(&recording, |q, _, _| q);
    let refused = |mapping: &str| read_texts(&texts, mapping, &ReadOptions::default()).unwrap_err();
    let command = "[command]\ncolumns = \"u*\"\n";
    let of = |law: &str| refused(&format!("{command}[drive]\n{law}\n"));
    assert!(of("law = \"position\"\nkd = 1").contains("missing field `kp`"), "{}", of("law = \"position\"\nkd = 1"));
    assert!(of("law = \"voltage\"\nkt = 1\nke = 1\nratio = 1").contains("missing field `resistance`"));
    assert!(of("law = \"position\"\nkp = 1\nkd = 1\nki = 2").contains("unknown field `ki`"));
    assert!(of("law = \"current\"\nkp = 1").contains("unknown variant `current`"));
    assert!(of("law = \"position\"\nkp = [1, 2]\nkd = 1").contains("`kp` of the drive has 2 numbers for 3 joints"));
    assert!(of("law = \"velocity\"\nkv = 0").contains("`kv` of the drive is 0 on joint 1"));
    assert!(refused(command).contains("lacks the law"), "{}", refused(command));
    assert!(refused("[drive]\nlaw = \"velocity\"\nkv = 1\n").contains("no table `command`"));
    let both = "[tau]\ncolumns = \"u*\"\n[command]\ncolumns = \"u*\"\n[drive]\nlaw = \"velocity\"\nkv = 1\n";
    assert!(refused(both).contains("both `tau` and `command`"));
}
