use std::path::{Path, PathBuf};

use anyhow::{Context, anyhow};
use clap::Args;
use serde_json::json;

use super::choice::{Choice, one_of};
use super::data::OptionalLog;
use super::failure::OrUsage;
use super::saved::Of;
use super::table::{number, titled};
use super::{progress, write_file};
use crate::arm::body::Body;
use crate::export::controller::{self, Code, Language, LeftOut, Wish};
use crate::export::network::{self, Package};
use crate::export::robot::{self, Format, NotHeld, Spliced, Weighed, WeighedLink};
use crate::export::share;
use crate::file;
use crate::model::Fitted;
use crate::recording::Recording;

/// Write a model as the code of a controller, with a test, into the robot's own file, or as the weights of its network.
///
/// For code and robots' files it is one that is solved for: a rigid body with named effects. As code it is one function
/// tau(q, qd, qdd), in which dry friction turns round smoothly, within --smooth. What no function of the present motion can give (an
/// effect with a memory, a reading that comes late) is left out, and told. Beside the code stands a test with states and the torque
/// of the model there.
///
/// Into a URDF go damping and friction of the joints, into an MJCF also armature and springs; nothing else in the file changes. What
/// the format can't hold is told. With --log it is told how much of the torque all that is; with --inertials the links get masses and
/// inertias that can exist and give the identified torque, as nearly as links can.
///
/// A trained network goes into a folder: its weights as safetensors and NPZ, its torque as ONNX, and an evaluator for NumPy that tests
/// itself.
#[derive(Args)]
#[command(after_help = "Examples:
  torquescope export c model.json -o controller/arm_torque.c
  torquescope export cpp model.json --smooth 0.02 -o arm_torque.hpp
  torquescope export python model.json --log arm.npz -o arm_torque.py
  torquescope export ros2 model.json -o arm_torque.yaml
  torquescope export urdf model.json --into robot.urdf --log arm.npz
  torquescope export urdf model.json --into robot.urdf --log arm.npz --inertials -o identified.urdf
  torquescope export mjcf model.json --into robot.xml --joints shoulder,elbow -o identified.xml
  torquescope export network delan.model --log arm.npz -o network
  torquescope export c mine.torquescope --of 'rigid body + Coulomb 1, 2' -o arm_torque.c")]
pub struct Export {
    /// What to write.
    #[arg(value_parser = one_of(KINDS))]
    kind: Kind,
    /// A model that `train` saved, or a session that the window saved (.torquescope): its current model, with its recording where
    /// no --log is named.
    model: PathBuf,
    #[command(flatten)]
    of: Of,
    /// Of code: the file, whose name is that of the function; or a folder, for a function `torque_model`. The test stands beside
    /// it. Of a robot's file: where the changed one goes; without, it takes the place of --into, which is kept as .bak. Of a
    /// network: the folder.
    #[arg(short, long, value_name = "FILE|DIR")]
    output: Option<PathBuf>,
    /// The robot's own file.
    #[arg(long, value_name = "ROBOT")]
    into: Option<PathBuf>,
    /// The model's joints by their names in the robot's file, base first; without, those that move.
    #[arg(long, value_name = "NAMES", value_delimiter = ',')]
    joints: Vec<String>,
    /// Of a robot's file: write the masses and inertias of its links too, those that can exist and are nearest to what was identified.
    /// They follow from the motion of --log.
    #[arg(long)]
    inertials: bool,
    /// The speed within which dry friction turns round [rad/s or m/s]; where the model found a wider reversal, that is kept.
    #[arg(long, value_name = "WIDTH", default_value_t = 0.01)]
    smooth: f64,
    /// Print the result as JSON.
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    log: OptionalLog,
}

/// What can be written.
#[derive(Debug, Clone, Copy)]
enum Kind {
    Code(Language),
    Robot(Format),
    Network,
}

const KINDS: [Choice<Kind>; 8] = [
    ("c", "C99: a header, a source and a test", Kind::Code(Language::C)),
    ("cpp", "C++11: a header with everything in it, and a test", Kind::Code(Language::Cpp)),
    ("python", "Python with NumPy, for one state or many", Kind::Code(Language::Python)),
    ("matlab", "MATLAB or Octave", Kind::Code(Language::Matlab)),
    ("ros2", "the parameters of a ROS 2 node (YAML)", Kind::Code(Language::Ros2)),
    ("urdf", "damping and friction, into the robot's URDF", Kind::Robot(Format::Urdf)),
    ("mjcf", "the same, armature and springs, into the robot's MJCF", Kind::Robot(Format::Mjcf)),
    (
        "network",
        "a trained network: weights (safetensors, NPZ), ONNX, and what computes its torque in NumPy",
        Kind::Network,
    ),
];

impl Export {
    /// Reads, writes, tells.
    pub fn run(&self) -> anyhow::Result<()> {
        let saved = self.of.read(&self.model)?;
        let recording = self.log.recording_for(&saved)?;
        match self.kind {
            Kind::Code(language) => self.write_code(language, &saved.fitted, recording.as_deref()),
            Kind::Robot(format) => self.splice(format, &saved.fitted, recording.as_deref()),
            Kind::Network => self.write_network(&saved.fitted, recording.as_deref()),
        }
    }

    fn splice(&self, format: Format, fitted: &Fitted, recording: Option<&Recording>) -> anyhow::Result<()> {
        let Some(path) = &self.into else {
            return Err(anyhow!("name the robot's own file with --into, such as --into robot.urdf")).or_usage();
        };
        let text = file::read_text(path).with_context(|| format!("can't read {}", path.display())).or_usage()?;
        let spliced = robot::write(fitted, format, &text, &self.joints, recording, self.inertials);
        let Spliced { text, written, weighed, not_held } =
            spliced.with_context(|| path.display().to_string()).or_usage()?;
        match &self.output {
            Some(output) => write_file(output, text.as_bytes())?,
            None => file::write_keeping_old(path, text.as_bytes())
                .with_context(|| format!("can't write {}", path.display()))?,
        }
        if self.json {
            let written: Vec<_> = written.iter().map(|one| {
                json!({ "joint": one.joint, "attribute": one.attribute, "before": one.before, "value": one.value })
            }).collect();
            let not_held: Vec<_> = not_held
                .iter()
                .map(|one| {
                    let (value, unit) = one.value.clone().unzip();
                    json!({ "what": one.what, "value": value, "unit": unit, "why": one.why, "share": one.share })
                })
                .collect();
            let links = weighed.as_ref().map(|weighed| weighed.links.iter().map(link_json).collect::<Vec<_>>());
            let cost = weighed.map(|weighed| {
                weighed
                    .cost
                    .iter()
                    .map(|[free, links]| json!({ "nmse_identified": free, "nmse_of_links": links }))
                    .collect::<Vec<_>>()
            });
            let told = json!({ "written": written, "links": links, "cost": cost, "not_held": not_held });
            println!("{}", serde_json::to_string_pretty(&told)?);
            return Ok(());
        }
        let row = |one: &robot::Change| {
            let before = one.before.clone().unwrap_or_else(|| "–".to_owned());
            vec![one.joint.clone(), one.attribute.to_owned(), before, number(one.value)]
        };
        let rows: Vec<Vec<String>> = written.iter().map(row).collect();
        println!("{}", titled("written", &["joint", "attribute", "before", "now"], &rows));
        if let Some(weighed) = &weighed {
            tell_masses(weighed);
        }
        let rows: Vec<Vec<String>> = not_held.iter().map(not_held_row).collect();
        println!("\n{}", titled("not in the file", &["what", " value", "share of the torque", " why"], &rows));
        Ok(())
    }

    fn write_code(&self, language: Language, fitted: &Fitted, recording: Option<&Recording>) -> anyhow::Result<()> {
        let (folder, name) = self.place()?;
        let motion = recording.and_then(|recording| recording.trajectories.first());
        let wish = Wish { name: &name, width: self.smooth, motion };
        let Code { files, left_out } = controller::write(fitted, language, &wish).or_usage()?;
        let files: Vec<(&str, &[u8])> = files.iter().map(|file| (&*file.name, file.text.as_bytes())).collect();
        self.save(&folder, &files, &left_out, fitted, recording)
    }

    fn write_network(&self, fitted: &Fitted, recording: Option<&Recording>) -> anyhow::Result<()> {
        let Some(folder) = self.output.as_deref().filter(|output| !output.is_file()) else {
            return Err(anyhow!("name the folder into which the network goes with -o, such as -o network")).or_usage();
        };
        let motion = recording.and_then(|recording| recording.trajectories.first());
        let Package { files, left_out } = network::write(fitted, self.smooth, motion).or_usage()?;
        let files: Vec<(&str, &[u8])> = files.iter().map(|(name, bytes)| (*name, bytes.as_slice())).collect();
        self.save(folder, &files, &left_out, fitted, recording)
    }

    /// Saves files in a folder, and tells of them and of what is in none.
    fn save(
        &self,
        folder: &Path,
        files: &[(&str, &[u8])],
        left_out: &[LeftOut],
        fitted: &Fitted,
        recording: Option<&Recording>,
    ) -> anyhow::Result<()> {
        std::fs::create_dir_all(folder).with_context(|| format!("can't make the folder {}", folder.display()))?;
        let mut written = Vec::new();
        for (name, bytes) in files {
            let path = folder.join(name);
            write_file(&path, bytes)?;
            written.push(path.display().to_string());
        }
        let mut told = Vec::new();
        for out in left_out {
            let share = recording.map(|recording| share::of_torque(fitted, recording, out.term, None)).transpose()?;
            let known = share.map_or("name --log to be told how much of the torque it is".to_owned(), |share| {
                format!("{:.1} % of the torque (RMS)", 100.0 * share)
            });
            if !self.json {
                progress::told(format_args!("left out: {}, {}; {known}", out.name, out.why));
            }
            told.push(json!({ "term": out.name, "why": out.why, "share": share }));
        }
        if self.json {
            println!("{}", serde_json::to_string_pretty(&json!({ "files": written, "left_out": told }))?);
        } else {
            println!("{}", written.join("\n"));
        }
        Ok(())
    }

    /// The folder, and the name of the function.
    fn place(&self) -> anyhow::Result<(PathBuf, String)> {
        let Some(output) = &self.output else {
            return Err(anyhow!("say with -o where the code goes: a file, or a folder")).or_usage();
        };
        if output.is_dir() || output.extension().is_none() {
            return Ok((output.clone(), "torque_model".to_owned()));
        }
        let stem = output.file_stem().ok_or_else(|| anyhow!("-o names no file")).or_usage()?;
        let folder = output.parent().unwrap_or(Path::new("")).to_owned();
        Ok((folder, stem.to_string_lossy().into_owned()))
    }
}

fn link_json(link: &WeighedLink) -> serde_json::Value {
    let body = |body: &Body| {
        let rows: Vec<Vec<f64>> = body.inertia.row_iter().map(|row| row.iter().copied().collect()).collect();
        json!({ "mass": body.mass, "com": body.com.as_slice(), "inertia": rows })
    };
    json!({ "link": link.name, "before": link.before.as_ref().map(body), "now": body(&link.now) })
}

/// What the links weigh now, and what it costs that they can exist.
fn tell_masses(weighed: &Weighed) {
    let row = |link: &WeighedLink| {
        let before = link.before.map_or_else(|| "–".to_owned(), |body| number(body.mass));
        let com = link.now.com.iter().copied().map(number).collect::<Vec<_>>().join(" ");
        let moments = link.now.inertia.diagonal().iter().copied().map(number).collect::<Vec<_>>().join(" ");
        vec![link.name.clone(), before, number(link.now.mass), com, moments]
    };
    let rows: Vec<Vec<String>> = weighed.links.iter().map(row).collect();
    let heads = ["link", "kg before", "kg now", " centre of mass [m]", " ixx iyy izz [kg m²]"];
    println!("\n{}", titled("links that can exist", &heads, &rows));
    let row = |(joint, [free, links]): (usize, &[f64; 2])| vec![(joint + 1).to_string(), number(*free), number(*links)];
    let rows: Vec<Vec<String>> = weighed.cost.iter().enumerate().map(row).collect();
    println!("\n{}", titled("nMSE of the model on the log", &["joint", "as identified", "with these links"], &rows));
}

fn not_held_row(one: &NotHeld) -> Vec<String> {
    let value = one.value.as_ref().map_or_else(|| "–".to_owned(), |(value, unit)| format!("{} {unit}", number(*value)));
    let share = one.share.map_or_else(|| "name --log".to_owned(), |share| format!("{:.1} %", 100.0 * share));
    vec![one.what.clone(), value, share, one.why.to_owned()]
}
