//! A figure for a paper that is set with LaTeX: a picture of pgfplots for its `\input`, in the letters of the paper.
//!
//! It holds its numbers, lines thinned to what can be seen: TeX could not read half a million of them. All of them are in the table
//! beside it.

use std::fmt::Write as _;

use super::axis::{Axis, Scale};
use super::colours::Ink;
use super::latex::escaped;
use super::mark::{Mark, Row};
use super::size::POINTS_PER_MILLIMETRE;
use super::tex::{Drawn, Paper, color};
use super::{Figure, Panel, Style};

/// Room of the numbers and the label beside a plot \[mm\].
const BESIDE: f64 = 17.0;
/// The same below it, with the title of the next one \[mm\].
const BELOW: f64 = 20.0;

/// Between two names below an axis, and the least width of one that is set in lines \[mm\].
const BETWEEN_NAMES: f64 = 2.0;
const LEAST_NAME: f64 = 12.0;

/// The file, beside a table of this name.
pub fn picture(figure: &Figure, style: &Style, table: &str) -> String {
    let columns = style.columns.unwrap_or(figure.columns).clamp(1, figure.panels.len().max(1));
    let rows = figure.panels.len().div_ceil(columns);
    let whole = style.size.width() / POINTS_PER_MILLIMETRE;
    let width = whole / columns as f64 - BESIDE;
    let usual = if style.size.is_narrow() || columns > 1 { 0.62 } else { 0.3 };
    let height = style.height.unwrap_or(usual * width);
    let panels: String = figure.panels.iter().map(|panel| group(panel, style, width)).collect();
    format!(
        "% \\input of this file draws it, where the head of the paper has\n\
         % \\usepackage{{pgfplots}} \\usepgfplotslibrary{{groupplots}} \\pgfplotsset{{compat=1.16}}\n\
         % All numbers are in {table}; lines are thinned to what is seen.\n\
         \\begin{{tikzpicture}}\n\\begin{{groupplot}}[\n  \
         group style={{group size={columns} by {rows}, horizontal sep={BESIDE}mm, vertical sep={BELOW}mm}},\n  \
         width={width:.1}mm, height={height:.1}mm, scale only axis, grid=major, grid style={{gray!20}}, unbounded coords=jump,\n  \
         enlarge x limits=false, legend cell align=left, legend style={{font=\\footnotesize, draw=none, fill opacity=0.8, text opacity=1}},\n  \
         label style={{font=\\small}}, tick label style={{font=\\footnotesize}}, title style={{font=\\small}},\n]\n{panels}\
         \\end{{groupplot}}\n\\end{{tikzpicture}}\n"
    )
}

/// One plot of this width \[mm\].
fn group(panel: &Panel, style: &Style, width: f64) -> String {
    let heading = if panel.bare { "hide axis, " } else { "" };
    let mut text = format!(
        "\\nextgroupplot[{heading}title={{{}}}, {}{}, {}]\n",
        escaped(&panel.heading()),
        axis("x", &panel.x),
        in_lines(&panel.x, width),
        axis("y", &panel.y)
    );
    let colours = style.theme.colours();
    let mut named: Vec<&str> = Vec::new();
    for mark in &panel.marks {
        let is_first = |name: &&str| !name.is_empty() && !named.contains(name);
        let name = mark.entry().map(|entry| entry.name).filter(is_first);
        named.extend(name);
        let of_kind = panel.marks.iter().filter(|other| other.kind() == mark.kind()).count();
        plot(&mut text, mark.as_ref(), &Paper { axes: [&panel.x, &panel.y], colours, of_kind }, name);
    }
    text
}

/// Label, scale, range and names along an axis.
fn axis(which: &str, axis: &Axis) -> String {
    // What has a unit only is named by the title of the plot.
    let title = if axis.label.is_empty() { String::new() } else { axis.title() };
    let mut text = format!("{which}label={{{}}}", escaped(&title));
    // Writing to a String can't fail.
    match &axis.scale {
        Scale::Linear => {}
        Scale::Logarithmic => text.push_str(&format!(", {which}mode=log")),
        Scale::Names(names) => {
            let places = (0..names.len()).map(|place| place.to_string()).collect::<Vec<_>>().join(",");
            let names = names.iter().map(|name| format!("{{{}}}", escaped(name))).collect::<Vec<_>>().join(",");
            let _ = write!(text, ", {which}tick={{{places}}}, {which}ticklabels={{{names}}}");
        }
    }
    if let Some([low, high]) = axis.range {
        let _ = write!(text, ", {which}min={low:?}, {which}max={high:?}");
    }
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

/// Adds what draws one mark.
fn plot(text: &mut String, mark: &dyn Mark, paper: &Paper, name: Option<&str>) {
    let mut rows = Vec::new();
    mark.rows(paper.axes[0], &mut |row| rows.push(Row { series: "", ..row }));
    let (options, body) = match mark.pgfplots(&rows, paper) {
        Some(Drawn::Plot(options, body)) => (options, body),
        Some(Drawn::Ground(commands)) => return text.push_str(&commands),
        None => return text.push_str(&format!("% A mark of a drawing is left out: {}\n", mark.kind())),
    };
    let color = color(paper.colours.of(mark.entry().map_or(Ink::Text, |entry| entry.key.ink())));
    let forget = if name.is_none() { "forget plot, " } else { "" };
    // Writing to a String can't fail.
    let _ = writeln!(text, "\\addplot[{forget}{color}, {options}] {body};");
    if let Some(name) = name {
        let _ = writeln!(text, "\\addlegendentry{{{}}}", escaped(name));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::figure::mark::Line;
    use crate::figure::tex::COLUMNS;

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
        assert!(text.matches(",2.5e-1)").count() < 4 * COLUMNS && text.contains("\\addlegendentry{measured}"));
        let of_models = |count: usize| {
            let axes = [Axis::names("", vec!["structured DeLaN".to_owned(); count]), Axis::default()];
            picture(&Figure::new(vec![Panel::new("errors", axes)]), &Style::default(), "a.csv")
        };
        assert!(of_models(4).contains("xticklabel style={align=center, text width="));
        assert!(of_models(20).contains("xticklabel style={rotate=90, anchor=east}"));
    }
}
