//! A figure's numbers drawn anew by matplotlib: a script to stand beside the table, for whoever wants it in another look.

use super::{Axis, Figure, Scale, Style, with_unit};

const POINTS_PER_INCH: f64 = 72.0;

/// The script for a table of this name, which stands beside it.
///
/// It draws the figure's marks in the width and the letters of the style.
pub fn script(figure: &Figure, style: &Style, table: &str) -> String {
    let panels: String = figure
        .panels
        .iter()
        .map(|panel| {
            let [x, y] = [&panel.x, &panel.y].map(axis);
            let aspect = panel.aspect.map_or("None".to_owned(), |aspect| format!("{aspect:.3}"));
            let bare = if panel.bare { "True" } else { "False" };
            format!("    {}: dict(x={x}, y={y}, aspect={aspect}, bare={bare}),\n", text(&panel.title))
        })
        .collect();
    let (width, letter) = (style.size.width() / POINTS_PER_INCH, style.letter.unwrap_or(style.size.letter()));
    let look = format!("WIDTH, LETTER, LINE = {width:.3}, {letter}, {}  # inches, points, points", letter / 8.0);
    format!("{HEAD}TABLE = {}\n{look}\nPANELS = {{\n{panels}}}\n\n{BODY}{}{END}", text(table), branches(figure))
}

/// What draws each kind of mark that the figure has.
fn branches(figure: &Figure) -> String {
    let (mut kinds, mut branches): (Vec<&str>, String) = Default::default();
    for mark in figure.panels.iter().flat_map(|panel| &panel.marks) {
        if !kinds.contains(&mark.kind()) {
            let lines: String = mark.matplotlib().lines().map(|line| format!("            {line}\n")).collect();
            branches += &format!("        if mark == {}:\n{lines}", text(mark.kind()));
            kinds.push(mark.kind());
        }
    }
    branches
}

/// Label, scale and range of an axis.
fn axis(axis: &Axis) -> String {
    let scale = if axis.scale == Scale::Logarithmic { "log" } else { "linear" };
    let range = axis.range.map_or("None".to_owned(), |[low, high]| format!("({low:?}, {high:?})"));
    let names = match &axis.scale {
        Scale::Names(names) => format!("[{}]", names.iter().map(|name| text(name)).collect::<Vec<_>>().join(", ")),
        Scale::Linear | Scale::Logarithmic => "None".to_owned(),
    };
    format!(
        "dict(label={}, scale=\"{scale}\", range={range}, names={names})",
        text(&with_unit(&axis.label, &axis.unit))
    )
}

/// A text as Python writes it, which is how JSON does.
fn text(text: &str) -> String {
    serde_json::Value::String(text.to_owned()).to_string()
}

const HEAD: &str = "\"\"\"Draws the table beside this script with matplotlib: python3 plot.py [FIGURE.pdf]\"\"\"\n\n\
import csv\nimport os\nimport sys\nfrom collections import defaultdict\n\nimport matplotlib.pyplot as plt\n\n";

const BODY: &str = r#"folder = os.path.dirname(os.path.abspath(__file__))
series = defaultdict(list)
with open(os.path.join(folder, TABLE), newline="", encoding="utf-8") as file:
    for row in csv.DictReader(file):
        series[row["panel"], row["mark"], row["series"]].append(row)


def column(rows, name):
    return [float(row[name]) if row[name] else float("nan") for row in rows]


plt.rcParams.update({"font.size": LETTER, "axes.titlesize": LETTER, "legend.fontsize": LETTER})
# Publishers ask for fonts that are embedded whole (TrueType, not Type 3) and for 600 dots per inch.
plt.rcParams.update({"pdf.fonttype": 42, "ps.fonttype": 42, "savefig.dpi": 600})
figure, axes = plt.subplots(len(PANELS), squeeze=False, figsize=(WIDTH, 2.5 * len(PANELS)), constrained_layout=True)
for ax, (title, panel) in zip(axes[:, 0], PANELS.items()):
    ax.set_title(title)
    for (of, mark, name), rows in series.items():
        if of != title:
            continue
        x, y = column(rows, "x"), column(rows, "y")
        count = sum(1 for other in series if other[:2] == (of, mark))
"#;

const END: &str = r#"    for axis, along in (("x", panel["x"]), ("y", panel["y"])):
        ax.set(**{f"{axis}label": along["label"], f"{axis}scale": along["scale"]})
        if along["range"]:
            ax.set(**{f"{axis}lim": along["range"]})
        if along["names"]:
            ax.set(**{f"{axis}ticks": range(len(along["names"])), f"{axis}ticklabels": along["names"]})
    if panel["aspect"]:
        ax.set_box_aspect(panel["aspect"])
    if panel["bare"]:
        ax.axis("off")
    if ax.get_legend_handles_labels()[0]:
        ax.legend(fontsize="small")
if len(sys.argv) > 1:
    figure.savefig(sys.argv[1])
else:
    plt.show()
"#;

#[cfg(test)]
mod tests {
    use super::*;
    use crate::figure::mark::{Arrow, Boxes, Line};
    use crate::figure::{Ink, Panel};

    #[test]
    fn the_script_names_its_table_and_every_panel() {
        let axes = [Axis::new("time", "s"), Axis::new("nMSE", "").logarithmic()];
        let panel =
            Panel::new("joint \"1\"", axes).with(Line::through("model", [[0.0, 1.0], [1.0, 0.1]], Ink::Series(0)));
        let text = script(&Figure::new(vec![panel]), &Style::default(), "a.csv");
        assert!(
            text.contains("TABLE = \"a.csv\"") && text.contains("\"joint \\\"1\\\"\": dict(x=dict(label=\"time"),
            "{text}"
        );
        assert!(text.contains("scale=\"log\"") && text.contains("[s]"), "{text}");
    }

    #[test]
    fn the_script_draws_the_kinds_of_its_figure_and_no_others() {
        let ink = Ink::Series(0);
        let spread = Boxes { name: "errors".to_owned(), boxes: vec![[0.0, 1.0, 2.0, 3.0, 4.0, 5.0]], width: 0.2, ink };
        let of = |panel: Panel| script(&Figure::new(vec![panel]), &Style::default(), "a.csv");
        let panel = || Panel::new("errors", [Axis::default(), Axis::default()]);
        let text = of(panel().with(spread.clone()).with(spread).with(Arrow { ends: [[0.0; 2], [1.0; 2]], ink }));
        assert!(text.matches("        if mark == ").count() == 2, "{text}");
        assert!(text.contains("        if mark == \"box\":\n            ends = (column(rows, end)"), "{text}");
        assert!(
            !of(panel()).contains("if mark == ") && of(panel().bare().aspect(0.5)).contains("aspect=0.500, bare=True")
        );
    }
}
