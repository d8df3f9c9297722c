//! A figure for a paper that is set with LaTeX: a picture of pgfplots for its `\input`, in the letters of the paper.
//!
//! It holds its numbers, lines thinned to what can be seen: TeX could not read half a million of them. All of them are in the table
//! beside it.

use std::fmt::Write as _;

use super::axis::{Axis, Scale};
use super::colours::{Colours, Dash, Ink};
use super::decimate::{self, Sight};
use super::latex::escaped;
use super::mark::{Key, Mark, Row};
use super::size::POINTS_PER_MILLIMETRE;
use super::{Figure, Panel, Style};

/// So many columns of pixels hold all that is seen of a line on paper.
const COLUMNS: usize = 400;
/// So many points are drawn of a cloud, or of a path.
const MOST_POINTS: usize = 2000;
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
    let bars = panel.marks.iter().filter(|mark| kind_of(mark.as_ref(), &panel.x) == Some("bar")).count();
    let mut named: Vec<&str> = Vec::new();
    for mark in &panel.marks {
        let is_first = |name: &&str| !name.is_empty() && !named.contains(name);
        let name = mark.entry().map(|entry| entry.name).filter(is_first);
        named.extend(name);
        plot(&mut text, panel, mark.as_ref(), style.theme.colours(), bars, name);
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

/// The kind of a mark's rows, if it has any.
fn kind_of(mark: &dyn Mark, x: &Axis) -> Option<&'static str> {
    let mut kind = None;
    mark.rows(x, &mut |row| kind = Some(row.kind));
    kind
}

/// Adds what draws one mark.
fn plot(text: &mut String, panel: &Panel, mark: &dyn Mark, colours: &Colours, bars: usize, name: Option<&str>) {
    let (mut kind, mut rows) = ("", Vec::new());
    mark.rows(&panel.x, &mut |row| {
        kind = row.kind;
        let Row { x, y, low, high, least, most, value, .. } = row;
        rows.push(Row { x, y, low, high, least, most, value, ..Row::new(kind, "") });
    });
    let key = mark.entry().map_or(Key::Patch(Ink::Text), |entry| entry.key);
    let color = color(colours.of(key.ink()));
    let points = |rows: &[Row]| rows.iter().map(|row| [row.x, row.y]).collect::<Vec<_>>();
    let (options, body) = match kind {
        "line" => (stroke(key), coordinates(&thinned(panel, &points(&rows)))),
        "points" => ("only marks, mark size=0.7pt".to_owned(), coordinates(&some(&points(&rows)))),
        "bar" => (bar_options(panel, bars), with_errors(&rows)),
        "band" => ("draw=none, fill, fill opacity=0.2".to_owned(), around(&rows)),
        "cell" => ("scatter, only marks, mark=square*, scatter src=explicit".to_owned(), valued(&rows)),
        "box" => (String::new(), coordinates(&boxes(&rows))),
        "held out" => return text.push_str(&shades(&rows, colours)),
        other => return text.push_str(&format!("% A mark of a drawing is left out: {other}\n")),
    };
    let forget = if name.is_none() { "forget plot, " } else { "" };
    let _ = writeln!(text, "\\addplot[{forget}{color}, {options}] {body};");
    if let Some(name) = name {
        let _ = writeln!(text, "\\addlegendentry{{{}}}", escaped(name));
    }
}

fn color([red, green, blue]: [u8; 3]) -> String {
    format!("color={{rgb,255:red,{red};green,{green};blue,{blue}}}")
}

/// Width and dash of a line.
fn stroke(key: Key) -> String {
    let (dash, opacity, width): (Dash, f64, f64) = match key {
        Key::Line(_, dash, opacity, width) => (dash, opacity, width),
        other => (other.ink().dash(), 1.0, 1.0),
    };
    // Dashes are told for lines of the screen; on paper they are half as long.
    let pattern: Vec<String> =
        dash.chunks_exact(2).map(|pair| format!("on {}pt off {}pt", pair[0] / 2.0, pair[1] / 2.0)).collect();
    let dashed = if pattern.is_empty() { String::new() } else { format!(", dash pattern={}", pattern.join(" ")) };
    format!("line width={:.2}pt, opacity={opacity}{dashed}", 0.7 * width)
}

/// Bars of one series among some, with intervals.
fn bar_options(panel: &Panel, series: usize) -> String {
    let origin = if panel.y.scale == Scale::Logarithmic { ", log origin=infty" } else { "" };
    let width = 0.6 / series.max(1) as f64;
    format!("ybar, bar width={width:.3}, fill, fill opacity=0.35{origin}, error bars/.cd, y dir=both, y explicit")
}

/// A number of six digits, or what TeX takes for none.
fn number(value: f64) -> String {
    if !value.is_finite() {
        return "nan".to_owned();
    }
    let text = format!("{value:.5e}");
    let (digits, exponent) = text.split_once('e').unwrap_or((&text, "0"));
    let digits = digits.trim_end_matches('0').trim_end_matches('.');
    if exponent == "0" { digits.to_owned() } else { format!("{digits}e{exponent}") }
}

fn coordinates(points: &[[f64; 2]]) -> String {
    let points: Vec<String> = points.iter().map(|[x, y]| format!("({},{})", number(*x), number(*y))).collect();
    format!("coordinates {{{}}}", points.join(" "))
}

/// A line as it is seen, with a hole between its pieces; a path that turns back keeps its shape.
fn thinned(panel: &Panel, points: &[[f64; 2]]) -> Vec<[f64; 2]> {
    let shown = points.iter().filter(|[x, _]| x.is_finite()).map(|[x, y]| (panel.x.measure(*x), *y));
    let (x, y): (Vec<f64>, Vec<f64>) = shown.filter(|(x, _)| x.is_finite()).unzip();
    let (Some(first), Some(last)) = (x.first(), x.last()) else { return Vec::new() };
    if x.windows(2).any(|pair| pair[1] < pair[0]) || last <= first {
        return some(points);
    }
    let positive = panel.y.scale == Scale::Logarithmic;
    let sight = Sight { range: [*first, *last], columns: COLUMNS, gaps: false, positive };
    let mut line: Vec<[f64; 2]> = Vec::new();
    for piece in decimate::pieces(&x, &y, sight) {
        if let Some([end, _]) = line.last() {
            line.push([*end, f64::NAN]);
        }
        line.extend(piece.into_iter().map(|[x, y]| [panel.x.value(x), y]));
    }
    line
}

/// Every point, or every n-th.
fn some(points: &[[f64; 2]]) -> Vec<[f64; 2]> {
    points.iter().step_by(points.len().div_ceil(MOST_POINTS).max(1)).copied().collect()
}

/// The outline of a band: its lower line, and back along the upper one.
fn around(rows: &[Row]) -> String {
    let seen: Vec<&Row> = rows.iter().filter(|row| row.low.is_finite() && row.high.is_finite()).collect();
    let lower = seen.iter().map(|row| [row.x, row.low]);
    let outline: Vec<[f64; 2]> = lower.chain(seen.iter().rev().map(|row| [row.x, row.high])).collect();
    format!("{} -- cycle", coordinates(&outline))
}

/// Heights of bars with the ends of their intervals.
fn with_errors(rows: &[Row]) -> String {
    let error = |end: f64, from: f64| if end.is_finite() { (end - from).abs() } else { 0.0 };
    let bar = |row: &Row| {
        let [x, y, up, down] = [row.x, row.y, error(row.high, row.y), error(row.low, row.y)].map(number);
        format!("({x},{y}) += (0,{up}) -= (0,{down})")
    };
    let bars: Vec<String> = rows.iter().map(bar).collect();
    format!("coordinates {{{}}}", bars.join(" "))
}

/// Points with the value that their colour tells.
fn valued(rows: &[Row]) -> String {
    let seen = rows.iter().filter(|row| row.value.is_finite());
    let points: Vec<String> =
        seen.map(|row| format!("({},{}) [{}]", number(row.x), number(row.y), number(row.value))).collect();
    format!("coordinates {{{}}}", points.join(" "))
}

/// Boxes with whiskers as one line with holes.
fn boxes(rows: &[Row]) -> Vec<[f64; 2]> {
    const HALF: f64 = 0.1;
    let hole = [f64::NAN; 2];
    let of = |row: &Row| {
        let [left, right] = [row.x - HALF, row.x + HALF];
        let frame = [[left, row.low], [right, row.low], [right, row.high], [left, row.high], [left, row.low], hole];
        let lines = [[row.x, row.least], [row.x, row.low], hole, [row.x, row.high], [row.x, row.most], hole];
        [frame.to_vec(), lines.to_vec(), vec![[left, row.y], [right, row.y], hole]].concat()
    };
    rows.iter().flat_map(of).collect()
}

/// Stretches that are held out, from below to above.
fn shades(rows: &[Row], colours: &Colours) -> String {
    let fill = color(colours.held_out);
    // The height of a corner is that of the axis; 1 is a number on a logarithmic one, too.
    let corner = |x: f64, end: u8| format!("({{axis cs:{},1}} |- {{rel axis cs:0,{end}}})", number(x));
    let shade = |row: &Row| {
        format!("\\fill[{fill}, fill opacity=0.6] {} rectangle {};\n", corner(row.low, 0), corner(row.high, 1))
    };
    rows.iter().map(shade).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::figure::mark::Line;

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
        assert_eq!([0.0, 1.5, -1.234_567e-7, f64::NAN].map(number), ["0", "1.5", "-1.23457e-7", "nan"]);
    }
}
