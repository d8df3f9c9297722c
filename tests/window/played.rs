//! Every lesson, played to its end through the real widgets: all right, and all wrong; and what the panel shows at each step.

use egui_kittest::{SnapshotOptions, SnapshotResults, try_image_snapshot_options};
use image::codecs::png::{CompressionType, FilterType, PngEncoder};
use torquescope::effect::place::Place;
use torquescope::lesson::grade::{Grade, verified};
use torquescope::lesson::{Course, Lesson, Offer, Stage, Step, Task, Wish, begin, catalogue, right_answer};
use torquescope::recording::seal::{HiddenEffect, Truth};
use torquescope::session::study::{Answer, Source};

use super::*;

/// The window while a lesson is played: its screens are only clicked where a lesson asks for it.
const WINDOW: [f32; 2] = [960.0, 800.0];
/// Heights of what lies above and below the panel of a lesson, the same on all pictures \[pixels\].
const BARS: [u32; 2] = [74, 38];
/// How many steps of brightness the pictures have between black and white, which makes them smaller.
const SHADES: u32 = 11;
/// Width of the panel of a lesson, and of its picture on a sheet \[pixels\].
const PANEL: u32 = 352;
const SHOWN: u32 = PANEL / 2;
/// Panels beside each other on a sheet.
const COLUMNS: u32 = 8;

/// A lesson whose networks are trained for a moment, on fewer runs; all else is as students have it.
fn brief(lesson: &Lesson) -> Lesson {
    let shorter = |line: &str| match line.strip_prefix("training = { epochs = ") {
        Some(rest) => {
            format!("training = {{ epochs = 2{}", rest.trim_start_matches(|letter: char| letter.is_ascii_digit()))
        }
        None => line.replace("trajectories = 300", "trajectories = 20"),
    };
    let data = lesson.source.data.lines().map(shorter).collect::<Vec<_>>().join("\n");
    Lesson::read(&Source { data, ..lesson.source.clone() }).unwrap()
}

struct Player {
    window: Window,
    lesson: Lesson,
    /// Pictures of the panel, light and dark, if they are wanted.
    panels: Option<[Vec<image::RgbaImage>; 2]>,
}

impl Player {
    fn begins(number: &str) -> Player {
        let lesson = brief(&catalogue::find(number).unwrap());
        let mut window = window(Session::default(), &data::ABOUT, Theme::Light);
        window.set_size(WINDOW.into());
        window.state_mut().order(Order::run(begin(&lesson, 3, torquescope::app::now()).unwrap().command));
        settle(&mut window);
        Player { window, lesson, panels: None }
    }

    fn course(&self) -> Course {
        Course::of(&self.lesson, self.window.state().session().study.as_ref().unwrap())
    }

    fn step(&self) -> Step {
        self.lesson.steps[self.course().place].clone()
    }

    fn looks(&mut self) {
        let Some(panels) = &mut self.panels else { return };
        // What passes by itself is no part of the panel.
        step_until(&mut self.window, "nothing passes by", |window| window.query_by_label_contains(": done.").is_none());
        for (panels, theme) in panels.iter_mut().zip([Theme::Dark, Theme::Light]).rev() {
            self.window.ctx.set_theme(theme);
            self.window.run_steps(2);
            let picture = self.window.render().unwrap();
            let (width, height) = (picture.width(), WINDOW[1] as u32 - BARS[0] - BARS[1]);
            let panel = image::imageops::crop_imm(&picture, width - PANEL, BARS[0], PANEL, height).to_image();
            let mut small = image::imageops::thumbnail(&panel, SHOWN, height * SHOWN / PANEL);
            for value in small.pixels_mut().flat_map(|pixel| &mut pixel.0[..3]) {
                let step = (u32::from(*value) * SHADES + 127) / 255;
                *value = (step * 255 / SHADES) as u8;
            }
            panels.push(small);
        }
    }

    /// Plays to the end, each step by `does`.
    fn plays(&mut self, does: fn(&mut Player, &Step)) -> Grade {
        for _ in 0..100 {
            let step = self.step();
            if !matches!(step.task, Task::Read) {
                does(self, &step);
            }
            self.looks();
            if self.course().is_finished(&self.lesson) {
                assert!(self.window.query_by_label_contains("the lesson is done").is_some());
                return verified(self.window.state().session()).unwrap();
            }
            self.presses("Go on →");
            assert_ne!(self.step().id, step.id, "lesson {}: {} is left", self.lesson.number, step.id);
        }
        panic!("the lesson does not end");
    }

    /// Presses a button, wherever the panel is scrolled to, and waits for what it does.
    fn presses(&mut self, name: &str) {
        self.window.get_by_role_and_label(Role::Button, name).click_accesskit();
        self.window.run_steps(2);
        step_until(&mut self.window, "every job ended", |window| !window.state().is_busy());
        self.window.run_steps(2);
    }

    /// Enters an answer and clicks the button that gives it.
    fn answers(&mut self, step: &Step, answer: &Answer) {
        self.enters(step, answer);
        self.gives(step);
    }

    fn gives(&mut self, step: &Step) {
        self.presses(if step.stage == Stage::Predict { "Lock it in" } else { "Check" });
    }

    fn enters(&mut self, step: &Step, answer: &Answer) {
        let window = &mut self.window;
        match answer {
            Answer::Choice(option) => {
                let name = step.name_of(option).unwrap();
                let name = name[..1].to_uppercase() + &name[1..];
                // The screen beside the lesson may have a choice of the same name.
                let edge = window.ctx.content_rect().right() - PANEL as f32;
                let all = |window: &Window| -> Vec<f32> {
                    let nodes = window.query_all_by_role_and_label(Role::RadioButton, &name);
                    nodes.map(|node| node.rect().left()).collect()
                };
                let place = all(window).iter().position(|left| *left > edge).unwrap();
                window.query_all_by_role_and_label(Role::RadioButton, &name).nth(place).unwrap().scroll_to_me();
                window.run_steps(3);
                window.query_all_by_role_and_label(Role::RadioButton, &name).nth(place).unwrap().click();
            }
            Answer::Number(value) => {
                type_into(window, "Your number", value);
            }
            Answer::Pose(_) | Answer::Session => (),
        }
        self.window.run_steps(3);
    }

    fn orders(&mut self, command: Command) {
        self.window.state_mut().order(Order::run(command));
        settle(&mut self.window);
    }

    fn adds(&mut self, effect: &str, joints: Vec<usize>) {
        self.orders(Command::AddEffect { effect: effect.to_owned(), joints });
    }

    /// What was hidden, as only a test may look at it.
    fn hidden(&self) -> Vec<HiddenEffect> {
        let open = Session { study: None, ..self.window.state().session().clone() };
        let truth = Command::OpenSeal.run(&open, &torquescope::progress::Monitor::new()).ok().and_then(|it| it.truth);
        truth.map_or_else(Vec::new, |truth| Truth::clone(&truth).effects)
    }

    /// Clicks offers until what is wrong in the recording is set right: one of them, or two.
    fn cures(&mut self, step: &Step) {
        let count = step.offers.len();
        let alone = (0..count).map(|one| vec![one]);
        let pairs = (0..count).flat_map(|one| (one + 1..count).map(move |other| vec![one, other]));
        for offers in alone.chain(pairs) {
            for offer in offers {
                self.offers(step, offer);
            }
            self.presses("Check");
            if self.course().here().right {
                return;
            }
            self.presses("Bring the recording again");
        }
    }

    fn offers(&mut self, step: &Step, place: usize) {
        let name = step.name_of_offer(&step.offers[place]);
        let first: String = name.chars().take(1).flat_map(char::to_uppercase).collect();
        let rest: String = name.chars().skip(1).collect();
        self.presses(&(first + &rest));
    }
}

/// As somebody does who knows it all.
fn right(player: &mut Player, step: &Step) {
    match &step.task {
        Task::Read | Task::Pose(_) => (),
        Task::Reveal(_) => player.presses("Reveal"),
        Task::Choice(choice) => {
            // What can't be known before it was done is guessed.
            let guess = Answer::Choice(choice.options[0].clone());
            let answer = right_answer(player.window.state().session()).unwrap_or(guess);
            player.answers(step, &answer);
        }
        Task::Number(_) => {
            let answer = right_answer(player.window.state().session()).unwrap_or(Answer::Number(3.0));
            player.answers(step, &answer);
        }
        Task::Want(_) if step.offers.iter().any(|offer| matches!(offer, Offer::SetRight(_))) => player.cures(step),
        Task::Want(wishes) => {
            (0..step.offers.len()).for_each(|offer| player.offers(step, offer));
            for wish in wishes {
                match wish {
                    Wish::HasHidden | Wish::ErrorFell(_) => {
                        for hidden in player.hidden() {
                            player.adds(&hidden.effect, hidden.joint.into_iter().collect());
                        }
                    }
                    Wish::Has(places) => {
                        for Place { effect, joints } in places {
                            player.adds(effect.id, joints.clone().unwrap_or_default());
                        }
                    }
                    Wish::SealOpen => player.orders(Command::OpenSeal),
                    Wish::Diagnosed => player.orders(Command::Diagnose),
                    _ => (),
                }
            }
            player.presses("Check");
        }
    }
}

/// As somebody does who knows nothing, and gives up wherever that is allowed.
fn wrong(player: &mut Player, step: &Step) {
    let answer = match &step.task {
        Task::Choice(choice) => {
            let right = right_answer(player.window.state().session()).ok();
            let mut options = choice.options.iter().cloned().map(Answer::Choice);
            options.find(|option| Some(option) != right.as_ref()).unwrap()
        }
        Task::Number(_) => Answer::Number(-1.0),
        _ => Answer::Session,
    };
    // The screen beside it is no matter to him, and this one is drawn quickly.
    player.window.state_mut().order(Order::Show(&ladder::ABOUT));
    if let Task::Reveal(_) = step.task {
        player.presses("Reveal");
    } else if step.stage == Stage::Predict {
        return player.answers(step, &answer);
    } else {
        player.enters(step, &answer);
        (0..3).for_each(|_| player.gives(step));
    }
    if !player.course().may_go_on(&player.lesson) {
        player.presses("Give up");
    }
}

/// Lesson 1 is posed by hand in `lessons.rs`; lesson 11 asks for a log of one's own.
#[test]
fn lessons_are_played_right() {
    for number in ["2", "3", "4", "5", "6", "7", "8", "9", "10"] {
        let grade = Player::begins(number).plays(right);
        assert!(grade.finished && grade.tampered.is_none() && grade.gave_up == 0, "lesson {number}: {grade:?}");
        // What was guessed before it was done may be wrong; all that could be known was right.
        let of = catalogue::find(number).unwrap();
        for one in &grade.steps {
            let is_guessed = of.step(&one.step).unwrap().stage == Stage::Predict;
            assert!(is_guessed || one.points > 0.0, "lesson {number}: {one:?}");
        }
    }
}

/// Who knows nothing earns nothing; and a sheet for each lesson shows its panel at each step, with what was answered.
#[test]
fn lessons_are_played_wrong_and_look_as_they_did() {
    let mut results = SnapshotResults::new();
    for lesson in catalogue::all() {
        let mut player = Player::begins(&lesson.number.to_string());
        player.panels = Some(Default::default());
        let grade = player.plays(wrong);
        assert!(grade.finished && !grade.passed && grade.points < 0.3 * grade.most, "{grade:?}");
        for (panels, suffix) in player.panels.iter().flatten().zip(["dark", "light"]) {
            let options = SnapshotOptions::new().max_failed_pixels(60 * panels.len());
            let (name, sheet) = (format!("lesson-{}-{suffix}", lesson.number), sheet(panels));
            results.add(try_image_snapshot_options(&sheet, &name, &options));
            if std::env::var_os("UPDATE_SNAPSHOTS").is_some() {
                write_small(&sheet, &name);
            }
        }
    }
}

/// The panels beside and below each other.
fn sheet(panels: &[image::RgbaImage]) -> image::RgbaImage {
    let (count, height) = (panels.len() as u32, panels[0].height());
    let mut sheet = image::RgbaImage::new(COLUMNS.min(count) * SHOWN, count.div_ceil(COLUMNS) * height);
    for (place, panel) in (0..).zip(panels) {
        let corner = [place % COLUMNS * SHOWN, place / COLUMNS * height].map(i64::from);
        image::imageops::replace(&mut sheet, panel, corner[0], corner[1]);
    }
    sheet
}

/// Writes a new sheet as small as it can be: there are many, of few shades.
fn write_small(sheet: &image::RgbaImage, name: &str) {
    let file = std::fs::File::create(format!("tests/snapshots/{name}.png")).unwrap();
    let encoder = PngEncoder::new_with_quality(file, CompressionType::Best, FilterType::NoFilter);
    sheet.write_with_encoder(encoder).unwrap();
}
