//! A figure for a paper that is set with LaTeX: a picture of pgfplots for its `\input`, in the letters of the paper.
//!
//! It holds its numbers, lines thinned to what can be seen: TeX could not read half a million of them. All of them are in the table
//! beside it.

use std::fmt::Write as _;

use super::axis::{Axis, Scale};
use super::colours::{Ink, Rgb};
use super::decimate::Decimator;
use super::font::{Family, Ruler};
use super::latex::escaped;
use super::mark::{Entry, Key, Mark, Row};
use super::size::POINTS_PER_MILLIMETRE;
use super::tex::{Drawn, FOOTNOTE, Paper, color, number};
use super::{Figure, Panel, Style};

/// Room of the numbers and the label beside a plot \[mm\].
const BESIDE: f64 = 17.0;
/// The same below it, with the title of the next one \[mm\].
const BELOW: f64 = 20.0;

/// Between two names below an axis, and the least width of one that is set in lines \[mm\].
const BETWEEN_NAMES: f64 = 2.0;
const LEAST_NAME: f64 = 12.0;

/// A logarithmic axis over less has its own numbers, and about so many.
const FEWEST_DECADES: f64 = 2.0;
const FEW_NUMBERS: usize = 5;

/// Height of a title with its distance to the plot \[mm\].
const TITLE: f64 = 6.0;

/// Height of a line of a legend, and the width of what stands before and behind each of its names \[mm\].
const LINE: f64 = 4.0;
const BEFORE_NAME: f64 = 11.0;

/// The file, beside a table of this name.
pub fn picture(figure: &Figure, style: &Style, table: &str) -> String {
    let columns = style.columns.unwrap_or(figure.columns).clamp(1, figure.panels.len().max(1));
    let rows = figure.panels.len().div_ceil(columns);
    let whole = style.size.width() / POINTS_PER_MILLIMETRE;
    let width = whole / columns as f64 - BESIDE;
    let usual = if style.size.is_narrow() || columns > 1 { 0.62 } else { 0.3 };
    let height = style.height.unwrap_or(usual * width);
    let panels = figure.panels.iter().map(|panel| panel.fitted(width / FOOTNOTE)).collect();
    let figure = Figure { panels, columns };
    let marks = figure.panels.iter().map(|panel| panel.marks.len()).sum();
    let common = Legend::of(&figure.common_legend(), whole);
    let own: Vec<Legend> = match common.lines {
        0 => figure.panels.iter().map(|panel| Legend::of(&panel.legend(), width)).collect(),
        _ => Vec::new(),
    };
    let group_of = |(number, panel): (usize, &Panel)| {
        let legend = match own.get(number) {
            Some(own) => Some(own.above()),
            None => (number == 0).then(|| common.above_all()),
        };
        group(panel, marks, style, [width, height], legend)
    };
    let groups: String = figure.panels.iter().enumerate().map(group_of).collect();
    let legend = own.iter().map(Legend::height).fold(0.0, f64::max);
    format!(
        "% \\input of this file draws it, where the head of the paper has\n\
         % \\usepackage{{pgfplots}} \\usepgfplotslibrary{{groupplots}} \\pgfplotsset{{compat=1.16}}\n\
         % All numbers are in {table}; lines are thinned to what is seen.\n\
         \\begin{{tikzpicture}}\n\\begin{{groupplot}}[\n  \
         group style={{group size={columns} by {rows}, horizontal sep={BESIDE}mm, vertical sep={below}mm}},\n  \
         width={width:.1}mm, height={height:.1}mm, scale only axis, grid=major, grid style={{gray!20}}, unbounded coords=jump,\n  \
         log origin=infty, legend cell align=left, legend style={{font=\\footnotesize, draw=none, fill=none}},\n  \
         legend image post style={{mark size=1.6pt}},\n  \
         label style={{font=\\small}}, tick label style={{font=\\footnotesize}}, title style={{font=\\small}},\n]\n{groups}\
         \\end{{groupplot}}\n\\end{{tikzpicture}}\n",
        below = BELOW + legend,
    )
}

/// One plot of this width and usual height \[mm\], in a figure of so many marks, with what places its legend if it has one.
fn group(panel: &Panel, marks: usize, style: &Style, [width, usual]: [f64; 2], legend: Option<String>) -> String {
    let height = panel.aspect.map_or(usual, |aspect| aspect * width);
    let axes = [&panel.x, &panel.y];
    let measured = panel.ranges(Paper::columns(width), &mut Decimator::default());
    let ranges = [0, 1].map(|which| measured[which].map(|end| axes[which].value(end)));
    let look = if panel.bare { "hide axis, " } else { "" };
    let mut text = format!(
        "\\nextgroupplot[{look}height={height:.1}mm, title={{{}}}, {}{}, {}{}]\n",
        escaped(&panel.heading()),
        axis("x", &panel.x, ranges[0]),
        in_lines(&panel.x, width),
        axis("y", &panel.y, ranges[1]),
        legend.as_deref().unwrap_or_default(),
    );
    let paper = Paper { axes, ranges, size: [width, height], colours: style.theme.colours(), marks };
    let mut named: Vec<&str> = Vec::new();
    for mark in &panel.marks {
        let is_first = |entry: &Entry| legend.is_some() && !entry.name.is_empty() && !named.contains(&entry.name);
        let entry = mark.entry().filter(is_first);
        named.extend(entry.map(|entry| entry.name));
        plot(&mut text, mark.as_ref(), &paper, entry);
    }
    text
}

/// The names of one plot, or of all, in lines above.
struct Legend {
    columns: usize,
    lines: usize,
}

impl Legend {
    /// Above what has this width \[mm\].
    fn of(entries: &[Entry], width: f64) -> Self {
        let ruler = Ruler::of(Family::Serif);
        let widest = entries.iter().map(|entry| ruler.width(entry.name, FOOTNOTE)).fold(0.0, f64::max);
        let columns = ((width / (widest + BEFORE_NAME)) as usize).clamp(1, entries.len().max(1));
        Legend { columns, lines: entries.len().div_ceil(columns) }
    }

    /// Its height \[mm\].
    fn height(&self) -> f64 {
        LINE * self.lines as f64
    }

    /// What places it between the plot and its title.
    fn above(&self) -> String {
        let title = format!(", title style={{yshift={}mm}}", self.height());
        if self.lines == 0 { String::new() } else { title + &self.placed("at={(0.5,1)}, anchor=south") }
    }

    /// What places it above the title of the first plot.
    fn above_all(&self) -> String {
        self.placed(&format!("at={{(0,1)}}, yshift={TITLE}mm, anchor=south west"))
    }

    fn placed(&self, at: &str) -> String {
        let columns = self.columns;
        format!(
            ", legend columns={columns}, legend style={{{at}, /tikz/every even column/.append style={{column sep=2mm}}}}"
        )
    }
}

/// Label, scale, range and names along an axis.
fn axis(which: &str, axis: &Axis, [low, high]: [f64; 2]) -> String {
    // What has a unit only is named by the title of the plot.
    let title = if axis.label.is_empty() { String::new() } else { axis.title() };
    let mut text = format!("{which}label={{{}}}", escaped(&title));
    // Writing to a String can't fail.
    match &axis.scale {
        Scale::Linear => {}
        Scale::Logarithmic => {
            let _ = write!(text, ", {which}mode=log");
            if (high / low).log10() < FEWEST_DECADES {
                // pgfplots would write powers with broken exponents.
                let ticks = axis.ticks([low, high].map(|end| axis.measure(end)), FEW_NUMBERS);
                let (at, said): (Vec<String>, Vec<String>) =
                    ticks.into_iter().map(|(at, said)| (number(axis.value(at)), escaped(&said))).unzip();
                let _ = write!(text, ", {which}tick={{{}}}, {which}ticklabels={{{}}}", at.join(","), said.join(","));
            }
        }
        Scale::Names(names) => {
            let places = (0..names.len()).map(|place| place.to_string()).collect::<Vec<_>>().join(",");
            let names = names.iter().map(|name| format!("{{{}}}", escaped(name))).collect::<Vec<_>>().join(",");
            let _ = write!(text, ", {which}tick={{{places}}}, {which}ticklabels={{{names}}}");
        }
    }
    let _ = write!(text, ", {which}min={low:?}, {which}max={high:?}");
    text
}

/// How names below an axis of this width \[mm\] stand: in lines, or upright where there is no room for words.
fn in_lines(axis: &Axis, width: f64) -> String {
    let Scale::Names(names) = &axis.scale else { return String::new() };
    let room = width / names.len().max(1) as f64 - BETWEEN_NAMES;
    let style = match room >= LEAST_NAME {
        true => format!("align=center, text width={room:.1}mm"),
        false => "rotate=90, anchor=east".to_owned(),
    };
    format!(", xticklabel style={{{style}}}")
}

/// Adds what draws one mark, and its entry in the legend.
fn plot(text: &mut String, mark: &dyn Mark, paper: &Paper, entry: Option<Entry>) {
    let mut rows = Vec::new();
    mark.rows(paper.axes[0], &mut |row| rows.push(Row { series: "", ..row }));
    // Writing to a String can't fail.
    match mark.pgfplots(&rows, paper) {
        Drawn::Plot(options, body) => {
            let color = color(paper.colours.of(mark.entry().map_or(Ink::Text, |entry| entry.key.ink())));
            let forget = if entry.is_none() { "forget plot, " } else { "" };
            let _ = writeln!(text, "\\addplot[{forget}{color}, {options}] {body};");
        }
        Drawn::Commands(commands) => {
            text.push_str(&commands);
            if let Some(Key::Scale(shades)) = entry.map(|entry| entry.key) {
                let _ = writeln!(text, "{}", bar(&shades.all(paper.colours)));
            }
        }
    }
    if let Some(entry) = entry {
        let _ = writeln!(text, "\\addlegendentry{{{}}}", escaped(entry.name));
    }
}

/// A bar of colours before an entry of the legend.
fn bar(colours: &[Rgb]) -> String {
    let end = |part: usize| 6.0 * part as f64 / colours.len() as f64;
    let piece = |(part, color_of): (usize, &Rgb)| {
        format!("\\fill[{}] ({:.3}mm,-1mm) rectangle ({:.3}mm,1mm);", color(*color_of), end(part), end(part + 1))
    };
    let pieces: String = colours.iter().enumerate().map(piece).collect();
    format!("\\addlegendimage{{legend image code/.code={{{pieces}}}}}")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::figure::mark::{Bars, Line};

    #[test]
    fn a_legend_that_all_plots_have_stands_once_and_bars_stand_on_their_axis() {
        let bars = |name: &str| {
            let axes = [Axis::names("", vec!["iid".to_owned()]), Axis::new("nMSE", "").logarithmic()];
            Panel::new(name, axes).with(Bars::beside("model", [0, 1], &[[0.5, -1.0, 0.7]], Ink::Series(0)))
        };
        let text = picture(&Figure::new(vec![bars("a"), bars("b")]), &Style::default(), "a.csv");
        assert!(text.matches("\\addlegendentry{model}").count() == 1 && text.matches("forget plot").count() == 1);
        assert!(
            text.contains("log origin=infty") && !text.contains("-= (0,1.5)"),
            "no whisker below a logarithmic axis"
        );
        let drawn = |one: Figure| picture(&one, &Style::default(), "a.csv");
        assert!(drawn(Figure::new(vec![bars("a")])).contains("title style={yshift=4mm}"));
        let arm = Panel::new("arm", [Axis::default(), Axis::default()]).aspect(1.0);
        assert!(drawn(Figure::new(vec![arm])).contains("height=158.0mm"), "as high as it is wide");
    }

    #[test]
    fn the_picture_holds_what_is_seen_of_every_line() {
        let spike = |n: u32| if n == 70_001 { 9.0 } else { 0.25 };
        let points = (0..100_000).map(|n| [f64::from(n) * 1e-3, spike(n)]);
        let axes = [Axis::new("time", "s"), Axis::new("torque τ", "N m").range([0.0, 10.0])];
        let panel = Panel::new("joint_1", axes).with(Line::through("measured", points, Ink::Measured));
        let text = picture(&Figure::new(vec![panel]), &Style::default(), "a.csv");
        assert!(
            text.contains("title={joint\\_1}") && text.contains("ylabel={torque $\\tau$ [N m]}, ymin=0.0, ymax=10.0")
        );
        assert!(text.contains("(7.0001e1,9)"), "the spike is there");
        assert!(
            text.matches(",2.5e-1)").count() < 4 * Paper::columns(200.0) && text.contains("\\addlegendentry{measured}")
        );
        let of_models = |count: usize| {
            let axes = [Axis::names("", vec!["structured DeLaN".to_owned(); count]), Axis::default()];
            picture(&Figure::new(vec![Panel::new("errors", axes)]), &Style::default(), "a.csv")
        };
        assert!(of_models(4).contains("xticklabel style={align=center, text width="));
        assert!(of_models(20).contains("xticklabel style={rotate=90, anchor=east}"));
    }
}
