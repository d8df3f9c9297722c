//! An arm from its maker's file (URDF or MJCF): which of its joints were recorded, and how it stands in space.

use std::collections::BTreeSet;
use std::path::PathBuf;

use egui::{ComboBox, Label, RichText, ScrollArea, Ui, WidgetInfo, WidgetText};

use super::frame::Shell;
use super::hanging::hanging;
use super::primary::primary;
use crate::app::plot::spatial::{self, Sight, SpatialPose};
use crate::app::plot::{PanelView, ticks};
use crate::app::theme::{GAP, Palette, SMALL};
use crate::app::widgets;
use crate::arm::robot::{MovingJoint, RobotError, SerialArm, SerialJoint};
use crate::file;
use crate::recording::JointKind;
use crate::recording::read::ReadOptions;
use crate::session::{Command, Session};
use crate::work::{Job, Outcome};

/// Width of the dialog, and height of the drawing \[points\].
const WIDTH: f32 = 560.0;
const DRAWING: f32 = 240.0;
/// Most height of the list of joints, and of what is stated of them \[points\].
const LIST: f32 = 190.0;
const STATED: f32 = 150.0;

/// The question, while it is open.
pub struct RobotFile {
    path: PathBuf,
    job: Option<Job<Read>>,
    read: Option<Result<Read, String>>,
    /// The last joint of the arm, by its place among all that move, once somebody has chosen it.
    end: Option<usize>,
    /// Joints on the way to it that stood still.
    fixed: BTreeSet<String>,
    /// The arm whose joints of these names move, as it was read last.
    arm: Option<(Vec<String>, Result<SerialArm, String>)>,
    sight: Sight,
}

/// What stands in the file.
struct Read {
    text: String,
    joints: Vec<MovingJoint>,
}

impl Read {
    /// The joints from the base to this one, by their places.
    fn way(&self, end: usize) -> Vec<usize> {
        let mut way: Vec<usize> = std::iter::successors(Some(end), |joint| self.joints[*joint].before).collect();
        way.reverse();
        way
    }

    /// The first joint to which so many lead, else that to which most do.
    fn end_of(&self, count: Option<usize>) -> usize {
        let lengths: Vec<usize> = (0..self.joints.len()).map(|joint| self.way(joint).len()).collect();
        let fits = lengths.iter().position(|length| Some(*length) == count);
        fits.or_else(|| (0..lengths.len()).max_by_key(|joint| lengths[*joint])).unwrap_or(0)
    }
}

impl RobotFile {
    /// Reads a robot's file.
    pub fn new(path: PathBuf, ctx: &egui::Context) -> Self {
        let (context, file) = (ctx.clone(), path.clone());
        let read = move |_: &crate::progress::Monitor| {
            let text = file::read_text(&file).map_err(|error| format!("It can't be read: {error}."))?;
            let told = |error: RobotError| widgets::sentence_case(&error.to_string()) + ".";
            let joints = SerialArm::moving_joints(&text).map_err(told)?;
            if joints.is_empty() { Err("None of its joints moves.".to_owned()) } else { Ok(Read { text, joints }) }
        };
        let job = Job::spawn("read the robot's file", move || context.request_repaint(), read);
        let (fixed, sight) = (BTreeSet::new(), Sight::default());
        RobotFile { path, job: Some(job), read: None, end: None, fixed, arm: None, sight }
    }

    /// Whether the file is being read.
    pub fn is_busy(&self) -> bool {
        self.job.is_some()
    }

    /// Receives what was read.
    fn poll(&mut self) {
        let Some(outcome) = self.job.as_mut().and_then(Job::poll) else { return };
        self.job = None;
        self.read = Some(match outcome {
            Outcome::Done(read) => Ok(read),
            Outcome::Failed(reason) | Outcome::Stopped(reason) | Outcome::Panicked(reason) => Err(reason),
        });
    }

    /// The arm whose joints of these names move; it is read anew only when they change.
    fn arm(&mut self, read: &Read, moving: &[String]) -> Result<SerialArm, String> {
        if let Some((_, arm)) = self.arm.as_ref().filter(|(of, _)| of == moving) {
            return arm.clone();
        }
        let arm = match moving.is_empty() {
            true => Err("No joint is left that moves.".to_owned()),
            false => SerialArm::moving_only(&read.text, moving)
                .map_err(|error| widgets::sentence_case(&error.to_string()) + "."),
        };
        self.arm = Some((moving.to_vec(), arm.clone()));
        arm
    }

    /// The joints that are taken to move, of those up to the last one.
    fn moving(&self, read: &Read, end: usize) -> Vec<String> {
        let names = read.way(end).into_iter().map(|joint| read.joints[joint].name.clone());
        names.filter(|name| !self.fixed.contains(name)).collect()
    }
}

/// What reads the log that is open anew, with these axes.
fn reading(arm: &SerialArm, session: &Session) -> Result<Command, String> {
    let none = "Open a log of this arm first, or drop both files onto the window at once.";
    let source = session.source.as_ref().ok_or(none)?;
    let spec = source.options.mapping.clone().unwrap_or_default();
    let mapping = spec.with_axes_of(arm).map_err(|error| widgets::sentence_case(&error.to_string()) + ".")?;
    let options = ReadOptions { mapping: Some(mapping), ..source.options.clone() };
    Command::read_again(source, options).ok_or_else(|| none.to_owned())
}

/// The question, while it is open.
pub fn show(ui: &mut Ui, shell: &mut Shell, place: &mut Option<RobotFile>) {
    let Some(mut open) = place.take() else { return };
    open.poll();
    let mut is_over = false;
    let modal = hanging("robot").show(ui.ctx(), |ui| {
        ui.set_width(WIDTH.min(ui.ctx().content_rect().width() - 80.0));
        ui.heading("Which joints of this robot were recorded?");
        ui.add(Label::new(RichText::new(open.path.display().to_string()).size(SMALL).color(Palette::in_ui(ui).weak)));
        ui.add_space(GAP);
        let read = open.read.take();
        match &read {
            None => drop(widgets::weak(ui, "It is being read…")),
            Some(Err(reason)) => drop(ui.label(RichText::new(reason).color(Palette::in_ui(ui).error))),
            Some(Ok(read)) => is_over = choose(ui, shell, &mut open, read),
        }
        open.read = read;
        ui.add_space(GAP);
        if !matches!(open.read, Some(Ok(_))) {
            is_over |= ui.button("Cancel").clicked();
        }
    });
    if !is_over && !modal.should_close() {
        *place = Some(open);
    }
}

/// The arm that is chosen; whether it is decided.
fn choose(ui: &mut Ui, shell: &mut Shell, open: &mut RobotFile, read: &Read) -> bool {
    let recorded = shell.desk.session.recording.as_ref().map(|recording| recording.joint_count());
    let end = joints(ui, open, read, recorded);
    let moving = open.moving(read, end);
    let arm = open.arm(read, &moving);
    if let Ok(arm) = &arm {
        stated(ui, arm);
        drawing(ui, shell, open, arm);
    }
    let fits = match recorded {
        Some(count) if count != moving.len() => Err(format!(
            "The log has {count} joint{}, and {} are ticked.",
            if count == 1 { "" } else { "s" },
            moving.len()
        )),
        _ => Ok(()),
    };
    let plane = arm.as_ref().ok().and_then(SerialArm::plane_told);
    let weighs = arm.as_ref().is_ok_and(|arm| arm.mass() > 0.0);
    let command = arm.and_then(|arm| fits.and_then(|()| reading(&arm, shell.desk.session)));
    match &command {
        Ok(_) if weighs => drop(widgets::weak(
            ui,
            "Its axes are taken; what its links weigh is identified from the log, and as it is stated the model “stated arm”.",
        )),
        Ok(_) => drop(widgets::weak(ui, "Its axes are taken; what its links weigh is identified from the log.")),
        Err(problem) => drop(ui.label(RichText::new(problem).color(Palette::in_ui(ui).warning))),
    }
    if let (Ok(_), Some(told)) = (&command, plane) {
        widgets::weak(ui, widgets::sentence_case(&told) + ".");
    }
    ui.add_space(GAP);
    ui.horizontal(|ui| {
        let can = command.is_ok() && shell.desk.busy.is_none();
        let taken = primary(ui, can, "Take these axes").clicked();
        if let (true, Ok(command)) = (taken, command) {
            shell.desk.run(command);
            return true;
        }
        ui.button("Cancel").clicked()
    })
    .inner
}

/// Up to which joint the arm goes, and which of those before it moved. At first it is the arm that has as many joints as the log.
fn joints(ui: &mut Ui, open: &mut RobotFile, read: &Read, recorded: Option<usize>) -> usize {
    let mut end = open.end.unwrap_or_else(|| read.end_of(recorded));

    let text = |joint: usize| {
        let count = read.way(joint).len();
        format!("{} ({count} joint{})", read.joints[joint].name, if count == 1 { "" } else { "s" })
    };
    ui.horizontal_wrapped(|ui| {
        let label = ui.label("From the base to");
        let chooser = ComboBox::from_id_salt("end of the arm").width(220.0).selected_text(text(end));
        let chooser = chooser.show_ui(ui, |ui| {
            for joint in 0..read.joints.len() {
                if ui.selectable_value(&mut end, joint, text(joint)).clicked() {
                    open.end = Some(joint);
                }
            }
        });
        chooser.response.labelled_by(label.id);
    });
    ScrollArea::vertical().id_salt("joints").max_height(LIST).show(ui, |ui| {
        ui.horizontal_wrapped(|ui| {
            for joint in read.way(end) {
                let MovingJoint { name, slides, .. } = &read.joints[joint];
                let mut moves = !open.fixed.contains(name);
                let check = ui.checkbox(&mut moves, name);
                check.widget_info(|| WidgetInfo::selected(egui::Role::CheckBox, true, moves, format!("{name} moves")));
                let what = if *slides { "It slides" } else { "It turns" };
                if check.on_hover_text(format!("{what}; without a tick it is taken for fixed")).changed() {
                    match moves {
                        true => drop(open.fixed.remove(name)),
                        false => drop(open.fixed.insert(name.clone())),
                    }
                }
            }
        });
    });
    end
}

/// What the file states of the joints that move, if it states anything.
fn stated(ui: &mut Ui, arm: &SerialArm) {
    if arm.joints.iter().all(|joint| joint.limits.is_none()) && arm.mass() == 0.0 {
        return;
    }
    let row = |joint: &SerialJoint| -> Vec<WidgetText> {
        let kind = if joint.slides { JointKind::Prismatic } else { JointKind::Revolute };
        let [position, velocity, _, effort] = kind.units();
        let most = |value: Option<f64>, unit: &str| value.map(|value| format!("{} {unit}", ticks::number(value)));
        let range = joint.limits.position.map(|ends| format!("{} {position}", ends.map(ticks::number).join(" … ")));
        let cells =
            [range, most(joint.limits.velocity, velocity), most(joint.limits.effort, effort), most(joint.mass(), "kg")];
        let cells = cells.into_iter().map(|cell| cell.unwrap_or_else(|| "—".to_owned()).into());
        [joint.name.clone().into()].into_iter().chain(cells).collect()
    };
    let rows: Vec<Vec<WidgetText>> = arm.joints.iter().map(row).collect();
    ScrollArea::both().id_salt("stated").max_height(STATED).show(ui, |ui| {
        widgets::table(ui, "stated of joints", &["joint", "range", "speed", "effort", "mass"], &rows);
    });
}

/// The arm at q = 0, which can be turned.
fn drawing(ui: &mut Ui, shell: &mut Shell, open: &mut RobotFile, arm: &SerialArm) {
    let (chain, sliding) = (arm.chain(), arm.sliding());
    let q = vec![0.0; sliding.len()];
    let (sight, none) = (open.sight, &[][..]);
    let pose = SpatialPose {
        time: 0.0,
        chain: &chain,
        sliding: &sliding,
        sight,
        q: &q,
        measured: none,
        predicted: none,
        largest: none,
        path: &[],
    };
    let view = PanelView::new(spatial::panel(&pose)).drawing().spoken("the arm of the file at q = 0").height(DRAWING);
    let drawn = view.show(ui, &mut shell.desk.focus.views, &mut shell.desk.memo.decimator).response;
    spatial::turn(ui, &drawn, &mut open.sight);
    widgets::weak(ui, "At q = 0. Drag it to turn it (or arrow keys; a double click turns it back).");
}
