//! The structure of a model as a drawing: what goes into each term, the layers of its networks with their sizes, and the sum.

use crate::figure::mark::{Arrow, Frame, Line, Word};
use crate::figure::{Axis, Ink, Panel};
use crate::model::learned::{Layers, LearnedTerm};
use crate::model::{Model, Term};

/// Height of one line of boxes \[points\].
const ROW: f64 = 46.0;
/// Width of the boxes at both ends \[points\].
const END: f64 = 46.0;
/// Between boxes of a line \[points\].
const GAP: f64 = 16.0;
/// Height of a box \[points\].
const BOX: f64 = ROW - 10.0;
/// Above the first and below the last line \[points\].
const EDGE: f64 = 4.0;
/// Radius of the sum \[points\].
const SUM: f64 = 12.0;
/// Between the lines of text in a box \[points\].
const LINE: f64 = 16.0;
/// Corners of the polygon that stands for a circle.
const CORNERS: usize = 48;

/// One line from the motion to the sum: boxes with a title and, below it, a size.
struct Lane {
    boxes: Vec<[String; 2]>,
    term: usize,
}

/// Where a box stands: its middle, width and height.
#[derive(Clone, Copy)]
struct Place {
    middle: [f64; 2],
    size: [f64; 2],
}

impl Place {
    fn left(self) -> [f64; 2] {
        [self.middle[0] - self.size[0] / 2.0, self.middle[1]]
    }

    fn right(self) -> [f64; 2] {
        [self.middle[0] + self.size[0] / 2.0, self.middle[1]]
    }
}

/// How high the drawing of a model is \[points\].
pub fn height(model: &Model, joints: usize) -> f64 {
    lanes_of(model, joints).len().max(2) as f64 * ROW + 2.0 * EDGE
}

/// The drawing, laid out for this width \[points\].
pub fn figure(model: &Model, joints: usize, width: f64) -> Panel {
    let (lanes, height) = (lanes_of(model, joints), height(model, joints));
    // The edges of boxes at the border have a width, too.
    let axis = |size: f64| Axis::default().range([-2.0, size + 2.0]);
    let panel = Panel::new("structure of the model", [axis(width), axis(height)]).aspect(height / width).bare();
    let middle = height / 2.0;
    let input = Place { middle: [END / 2.0, middle], size: [END, height - 2.0 * EDGE] };
    let output = Place { middle: [width - END / 2.0, middle], size: [END, BOX] };
    let sum = [width - END - 34.0, middle];
    let mut panel = boxed(panel, input, &["q", "q̇", "q̈"], Ink::Text);
    for (number, lane) in lanes.iter().enumerate() {
        let y = middle + ROW * (0.5 * lanes.len() as f64 - 0.5 - number as f64);
        let (left, right) = (input.right()[0] + 22.0, sum[0] - 46.0);
        let count = lane.boxes.len() as f64;
        let width = (right - left - GAP * (count - 1.0)) / count;
        let mut from = [input.right()[0], y];
        for (column, [title, size]) in lane.boxes.iter().enumerate() {
            let x = left + (column as f64 + 0.5) * width + column as f64 * GAP;
            let place = Place { middle: [x, y], size: [width, BOX] };
            panel.push(Arrow { ends: [from, place.left()], ink: Ink::Text });
            let lines: Vec<&str> =
                [title, size].into_iter().filter(|line| !line.is_empty()).map(String::as_str).collect();
            panel = boxed(panel, place, &lines, Ink::Series(lane.term));
            from = place.right();
        }
        let away = [from[0] - sum[0], from[1] - sum[1]];
        let share = (SUM + 1.0) / away[0].hypot(away[1]);
        let at_sum = [sum[0] + share * away[0], sum[1] + share * away[1]];
        panel.push(Arrow { ends: [from, at_sum], ink: Ink::Text });
    }
    panel.push(Arrow { ends: [[sum[0] + SUM, sum[1]], output.left()], ink: Ink::Text });
    let panel = boxed(panel, output, &["τ̂", &joints.to_string()], Ink::Predicted);
    let corner = |number: usize| {
        let (sin, cos) = (std::f64::consts::TAU * number as f64 / CORNERS as f64).sin_cos();
        [sum[0] + SUM * cos, sum[1] + SUM * sin]
    };
    panel.with(Line::path("", (0..=CORNERS).map(corner), Ink::Measured)).with(Word {
        text: "+".to_owned(),
        at: sum,
        room: SUM,
        ink: Ink::Text,
    })
}

/// A box with lines of text, added to a panel.
fn boxed(panel: Panel, place: Place, lines: &[&str], ink: Ink) -> Panel {
    let [x, y] = place.middle;
    let sides = [0, 1].map(|axis| [-0.5, 0.5].map(|side| place.middle[axis] + side * place.size[axis]));
    let first = y + LINE * 0.5 * (lines.len() as f64 - 1.0);
    let word = |(number, text): (usize, &&str)| {
        let at = [x, first - LINE * number as f64];
        Word { text: (*text).to_owned(), at, room: place.size[0] - 6.0, ink: Ink::Text }
    };
    panel.with(Frame { sides, ink }).with_all(lines.iter().enumerate().map(word))
}

fn lanes_of(model: &Model, joints: usize) -> Vec<Lane> {
    model.terms.iter().enumerate().flat_map(|(place, term)| lanes(term, place, joints)).collect()
}

/// The boxes of a term; a structured Lagrangian has two networks, so two lines.
fn lanes(term: &Term, place: usize, joints: usize) -> Vec<Lane> {
    let lane = |boxes: Vec<[String; 2]>| Lane { boxes, term: place };
    let named = |title: &str, size: String| [title.to_owned(), size];
    let features = |sum: usize, text: &str| named(text, sum.to_string());
    let hidden = |layers: &Layers| {
        let activation = format!("{:?}", layers.activation).to_lowercase();
        layers.hidden.iter().map(move |width| [activation.clone(), width.to_string()]).collect::<Vec<_>>()
    };
    let chain = |first: [String; 2], layers: &Layers, last: Vec<[String; 2]>| {
        lane([first].into_iter().chain(hidden(layers)).chain(last).collect())
    };
    let lagrange = || named("d/dt ∂ℒ/∂q̇ − ∂ℒ/∂q", joints.to_string());
    match term {
        Term::RigidBody(_) | Term::Effect(_) => vec![lane(vec![named(&term.label(), String::new())])],
        Term::Learned(LearnedTerm::StructuredLagrangian { layers, positive }) => {
            let triangle = (joints * (joints + 1) / 2).to_string();
            let matrix = if positive.is_some() { "H = C Cᵀ" } else { "H = C + Cᵀ" };
            let mass = vec![named("C", triangle), named(matrix, format!("{joints}×{joints}")), lagrange()];
            let potential = vec![named("V", "1".to_owned()), named("∂V/∂q", joints.to_string())];
            let angles = || features(2 * joints, "cos q, sin q");
            vec![chain(angles(), layers, mass), chain(angles(), layers, potential)]
        }
        Term::Learned(LearnedTerm::BlackBoxLagrangian { layers }) => {
            let last = vec![named("ℒ", "1".to_owned()), lagrange()];
            vec![chain(features(3 * joints, "cos q, sin q, q̇"), layers, last)]
        }
        Term::Learned(LearnedTerm::FeedForward { layers, .. }) => {
            let last = vec![named("τ", joints.to_string())];
            vec![chain(features(4 * joints, "cos q, sin q, q̇, q̈"), layers, last)]
        }
        Term::Learned(LearnedTerm::Friction) => vec![lane(vec![named("friction", format!("4 × {joints}"))])],
        Term::Learned(LearnedTerm::Columns { names }) => {
            vec![lane(vec![named("effects", names.len().to_string())])]
        }
    }
}
