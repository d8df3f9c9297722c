//! The structure of a model as a drawing: what goes into each term, the layers of its networks with their sizes, and the sum.

use crate::figure::font::Ruler;
use crate::figure::mark::{Arrow, Frame, Line, Word};
use crate::figure::{Axis, Family, Ink, Panel};
use crate::model::learned::{Layers, LearnedTerm};
use crate::model::{Model, Term};

/// Height of the letters for which it is laid out \[points\].
const LETTER: f64 = 11.0;
/// Width for which it is laid out where nothing is known of the page \[points\].
const WIDTH: f64 = 760.0;
/// Least width for which it is laid out; where there is less, it is drawn smaller, letters and all \[points\].
const LEAST_WIDTH: f64 = 280.0;
/// Beside the text of a box \[points\].
const INSET: f64 = 4.0;
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

/// A lane in lines of boxes, each with its width: one line where there is room, else as many as it takes.
struct Folded {
    lines: Vec<Vec<([String; 2], f64)>>,
    term: usize,
}

impl Folded {
    /// In lines that are so wide \[points\].
    fn of(lane: Lane, room: f64, ruler: &Ruler) -> Self {
        let needed =
            |texts: &[String; 2]| texts.iter().map(|text| ruler.width(text, LETTER)).fold(0.0, f64::max) + 2.0 * INSET;
        let mut lines: Vec<Vec<([String; 2], f64)>> = vec![Vec::new()];
        let mut used = 0.0;
        for texts in lane.boxes {
            let width = needed(&texts);
            if used + GAP + width > room && used > 0.0 {
                lines.push(Vec::new());
                used = 0.0;
            }
            used += if used > 0.0 { GAP + width } else { width };
            if let Some(line) = lines.last_mut() {
                line.push((texts, width));
            }
        }
        for line in &mut lines {
            let count = line.len() as f64;
            let free = room - GAP * (count - 1.0);
            let widest = line.iter().map(|(_, width)| *width).fold(0.0, f64::max);
            let spare = (free - line.iter().map(|(_, width)| width).sum::<f64>()) / count;
            for (_, width) in line {
                *width = if widest * count <= free { free / count } else { *width + spare };
            }
        }
        Folded { lines, term: lane.term }
    }
}

/// How high the drawing of a model is at this width \[points\].
pub fn height(model: &Model, joints: usize, width: f64) -> f64 {
    height_of(&folded(model, joints, width))
}

fn height_of(lanes: &[Folded]) -> f64 {
    let lines: usize = lanes.iter().map(|lane| lane.lines.len()).sum();
    lines.max(2) as f64 * ROW + 2.0 * EDGE
}

fn folded(model: &Model, joints: usize, width: f64) -> Vec<Folded> {
    let (ruler, [left, right]) = (Ruler::of(Family::Sans), between(width));
    lanes_of(model, joints).into_iter().map(|lane| Folded::of(lane, right - left, &ruler)).collect()
}

/// From where to where lanes go.
fn between(width: f64) -> [f64; 2] {
    [END + 22.0, width - END - 80.0]
}

/// The drawing for a page, laid out for whatever width it gets there.
pub fn for_paper(model: &Model, joints: usize) -> Panel {
    let own = model.clone();
    figure(model, joints, WIDTH).laid_out_by(move |letters| figure(&own, joints, (LETTER * letters).max(LEAST_WIDTH)))
}

/// The drawing, laid out for this width \[points\].
pub fn figure(model: &Model, joints: usize, width: f64) -> Panel {
    let lanes = folded(model, joints, width);
    let height = height_of(&lanes);
    // The edges of boxes at the border have a width, too.
    let axis = |size: f64| Axis::default().range([-2.0, size + 2.0]);
    let panel = Panel::new("structure of the model", [axis(width), axis(height)]).aspect(height / width).bare();
    let middle = height / 2.0;
    let input = Place { middle: [END / 2.0, middle], size: [END, height - 2.0 * EDGE] };
    let output = Place { middle: [width - END / 2.0, middle], size: [END, BOX] };
    let sum = [width - END - 34.0, middle];
    let mut panel = boxed(panel, input, &["q", "q̇", "q̈"], Ink::Text);
    let [left, _] = between(width);
    let count: usize = lanes.iter().map(|lane| lane.lines.len()).sum();
    let mut y = middle + ROW * (0.5 * count as f64 - 0.5);
    for lane in &lanes {
        let mut from = [input.right()[0], y];
        for (number, line) in lane.lines.iter().enumerate() {
            let mut x = left;
            for (column, ([title, size], width)) in line.iter().enumerate() {
                let place = Place { middle: [x + width / 2.0, y], size: [*width, BOX] };
                if column == 0 && number > 0 {
                    // On in the next line.
                    let (aside, between) = (GAP / 2.0, y + ROW / 2.0);
                    let way = [
                        from,
                        [from[0] + aside, from[1]],
                        [from[0] + aside, between],
                        [x - aside, between],
                        [x - aside, y],
                    ];
                    panel.push(Line::path("", way, Ink::Text).dash(&[]));
                    from = [x - aside, y];
                }
                panel.push(Arrow { ends: [from, place.left()], ink: Ink::Text });
                let lines: Vec<&str> =
                    [title, size].into_iter().filter(|line| !line.is_empty()).map(String::as_str).collect();
                panel = boxed(panel, place, &lines, Ink::Series(lane.term));
                from = place.right();
                x += width + GAP;
            }
            y -= ROW;
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
    let plus = Word { text: "+".to_owned(), at: sum, room: [SUM, 2.0 * SUM], ink: Ink::Text };
    panel.with(Line::path("", (0..=CORNERS).map(corner), Ink::Measured)).with(plus)
}

/// A box with lines of text, added to a panel.
fn boxed(panel: Panel, place: Place, lines: &[&str], ink: Ink) -> Panel {
    let [x, y] = place.middle;
    let sides = [0, 1].map(|axis| [-0.5, 0.5].map(|side| place.middle[axis] + side * place.size[axis]));
    let first = y + LINE * 0.5 * (lines.len() as f64 - 1.0);
    let word = |(number, text): (usize, &&str)| {
        let at = [x, first - LINE * number as f64];
        Word { text: (*text).to_owned(), at, room: [place.size[0] - 6.0, LINE], ink: Ink::Text }
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
        Term::RigidBody(_) | Term::Resistance(_) | Term::Effect(_) => {
            vec![lane(vec![named(&term.label(), String::new())])]
        }
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::figure::{Figure, Format, Size, Style, render};
    use crate::model::Preset;
    use crate::model::learned::LearnedPreset;
    use crate::progress::Monitor;
    use crate::simulation::{Excitation, Scenario, simulate};
    use crate::training::fit::Plan;

    /// Texts of a drawing as an SVG has them: what they say, how high their letters are, and their sides.
    fn texts(svg: &str) -> Vec<(String, f64, [[f64; 2]; 2])> {
        let ruler = Ruler::of(Family::Sans);
        let text = |part: &str| {
            let (tag, rest) = part.split_once('>')?;
            let number =
                |key: &str| -> Option<f64> { tag.split_once(&format!(" {key}=\""))?.1.split('"').next()?.parse().ok() };
            let (x, y, size) = (number("x")?, number("y")?, number("font-size")?);
            let text = rest.split('<').next()?.to_owned();
            let half = ruler.width(&text, size) / 2.0;
            let [left, right] = if tag.contains("middle") { [x - half, x + half] } else { [x, x + 2.0 * half] };
            Some((text, size, [[left, right], [y - 0.8 * size, y + 0.2 * size]]))
        };
        svg.split("<text").skip(1).filter_map(text).collect()
    }

    #[test]
    fn letters_of_a_drawing_never_overlap() {
        let motion = Excitation::PaperPointToPoint { trajectories: 2, duration: 4.0, samples: 80, range: 2.0 };
        let recording = simulate(&Scenario { motion, ..Scenario::embedded() }, &Monitor::new()).unwrap();
        for preset in [LearnedPreset::StructuredDelan, LearnedPreset::BlackBoxDelan, LearnedPreset::FfNn] {
            let model = Plan::default().shaped(&Preset::Learned(preset).model(&recording).unwrap());
            let panel = for_paper(&model, 3);
            for size in Size::ALL {
                for (count, height) in [(1, None), (2, None), (4, None), (1, Some(15.0))] {
                    let style = Style { size, columns: Some(count), height, ..Style::default() };
                    let svg = render(&Figure::new(vec![panel.clone(); count]), Format::Svg, &style).unwrap();
                    let texts = texts(std::str::from_utf8(&svg).unwrap());
                    assert!(texts.iter().any(|(text, ..)| text == "q̈"), "{size:?}");
                    for (place, (text, _, [x, y])) in texts.iter().enumerate() {
                        for (other, _, [others_x, others_y]) in &texts[..place] {
                            let meet = |one: &[f64; 2], other: &[f64; 2]| one[0] < other[1] && other[0] < one[1];
                            let is_over = meet(x, others_x) && meet(y, others_y);
                            assert!(!is_over, "{size:?}, {count} columns: “{text}” over “{other}”");
                        }
                    }
                    // In one column of a page all can be read.
                    let least = texts.iter().map(|(_, size, _)| *size).fold(f64::INFINITY, f64::min);
                    let usual = texts.iter().map(|(_, size, _)| *size).fold(0.0, f64::max);
                    assert!(
                        (count, height) != (1, None) || size == Size::Slide || least > 0.75 * usual,
                        "{size:?}: {least}"
                    );
                }
            }
        }
    }
}
