use super::mark::{Arrow, Band, Bars, Boxes, Frame, Line, Points, Shade, Word};
use super::*;

fn everything() -> Figure {
    let wave = |phase: f64| -> Vec<[f64; 2]> {
        (0..2000).map(|n| [f64::from(n) * 0.01, (f64::from(n) * 0.01 + phase).sin()]).collect()
    };
    let mut broken = wave(0.5);
    broken[700][1] = f64::NAN;
    let torque = Panel::new("joint 1: torque", [Axis::new("time t", "s"), Axis::new("", "N m")])
        .with(Shade([4.0, 7.0]))
        .with(Line::through("measured τ", wave(0.0), Ink::Measured))
        .with(Line::through("predicted τ̂ & q̈ <1>", broken, Ink::Predicted));
    let error = Panel::new("error", [Axis::new("scale", ""), Axis::new("nMSE", "").logarithmic()])
        .with(Band::new("", vec![[1.0, 1e-6, 1e-5], [3.0, 1e-3, 1e-1]], Ink::Series(1)))
        .with(Points::new("seeds", vec![[1.0, 3e-6], [2.0, 0.0], [3.0, 1e-2]], Ink::Series(1)));
    let names = vec!["rigid body".to_owned(), "FF-NN".to_owned()];
    let bars = Panel::new("by model", [Axis::names("", names), Axis::new("nMSE", "")])
        .with(Bars {
            name: "iid".to_owned(),
            bars: vec![[0.0, 2.0, 1.5, 2.5], [1.0, 3.0, f64::NAN, f64::NAN]],
            width: 0.5,
            ink: Ink::Series(0),
            written: None,
        })
        .with(Boxes {
            name: "draws".to_owned(),
            boxes: vec![[0.5, 0.0, 1.0, 2.0, 2.5, 4.0]],
            width: 0.2,
            ink: Ink::Series(2),
        });
    let path = Panel::new("path of the tool", [Axis::new("x", "m"), Axis::new("z", "m")]).aspect(1.0).with(Line::path(
        "tool",
        (0..100).map(|n| [(f64::from(n) / 9.0).cos(), (f64::from(n) / 9.0).sin()]),
        Ink::Series(3),
    ));
    let axis = || Axis::default().range([0.0, 4.0]);
    let drawing = Panel::new("structure", [axis(), axis()])
        .bare()
        .with(Frame { sides: [[0.0, 1.0], [1.0, 3.0]], ink: Ink::Series(0) })
        .with(Arrow { ends: [[1.0, 2.0], [2.0, 2.0]], ink: Ink::Text })
        .with(Word { text: "H = L Lᵀ".to_owned(), at: [0.5, 2.0], room: [0.9, 1.0], ink: Ink::Text });
    Figure { panels: vec![torque, error, bars, path, drawing], columns: 2 }
}

fn text(figure: &Figure, format: Format) -> String {
    String::from_utf8(render(figure, format, &Style::default()).unwrap()).unwrap()
}

/// What a reader on a screen is told at a mark is the value that was drawn there.
#[test]
fn values_can_be_read_off_a_drawing() {
    let svg = text(&everything(), Format::Svg);
    let attribute = |from: &str, name: &str| {
        let value = from.split_once(&format!(" {name}=\"")).unwrap().1.split_once('"').unwrap().0;
        value.replace("&quot;", "\"")
    };
    let error = &svg[svg.find("#plot1)").unwrap()..];
    let seeds = &error[error.find("data-series=\"seeds\"").unwrap()..];
    let value = |axis: &str, key: &str| {
        let told: serde_json::Value = serde_json::from_str(&attribute(error, axis)).unwrap();
        let [low, high, from, to] = ["low", "high", "from", "to"].map(|key| told[key].as_f64().unwrap());
        let at: f64 = attribute(seeds, key).parse().unwrap();
        let measured = from + (at - low) / (high - low) * (to - from);
        if told["log"] == true { 10f64.powf(measured) } else { measured }
    };
    let (x, y) = (value("data-x", "cx"), value("data-y", "cy"));
    assert!((x - 1.0).abs() < 1e-3 && (y / 3e-6 - 1.0).abs() < 1e-2, "{x} {y}");
    assert!(svg.contains("data-series=\"predicted τ̂ &amp; q̈ &lt;1&gt;\""), "a name is data, not markup");
}

/// Of plots below each other over the same time the last one names it, each of those beside each other does.
#[test]
fn the_axis_is_named_below_each_column() {
    let panel = |title: &str| {
        let x = Axis::new("time t", "s").range([0.0, 1.0]).linked("time");
        Panel::new(title, [x, Axis::new("", "N m")]).with(Line::through("", [[0.0, 0.0], [1.0, 1.0]], Ink::Measured))
    };
    let named = |count: usize, columns: usize| {
        let figure = Figure { panels: (0..count).map(|number| panel(&format!("joint {number}"))).collect(), columns };
        text(&figure, Format::Svg).matches("time t [s]").count()
    };
    assert_eq!([named(1, 1), named(3, 1), named(4, 2), named(3, 3)], [1, 1, 2, 3]);
}

/// What is held out is shaded, unless somebody wants it white; nothing else changes.
#[test]
fn shades_are_left_out_on_demand() {
    let drawn = |shaded| {
        let style = Style { shaded, ..Style::default() };
        String::from_utf8(render(&everything(), Format::Svg, &style).unwrap()).unwrap()
    };
    let rectangles = |svg: &str| svg.matches("<rect").count();
    let (with, without) = (drawn(true), drawn(false));
    assert_eq!(rectangles(&with), rectangles(&without) + 1);
    assert_eq!(with.matches("<path").count(), without.matches("<path").count());
}

#[test]
fn an_svg_is_well_formed_and_holds_its_font_and_symbols() {
    let svg = text(&everything(), Format::Svg);
    assert!(resvg::usvg::Tree::from_str(&svg, &resvg::usvg::Options::default()).is_ok());
    for part in [
        "@font-face",
        "predicted τ̂ &amp; q̈ &lt;1&gt;",
        "joint 1: torque [N m]",
        "time t [s]",
        "stroke-dasharray",
        "H = L Lᵀ",
    ] {
        assert!(svg.contains(part), "no {part}");
    }
    assert!(!svg.contains("NaN") && !svg.contains("inf"), "a hole was drawn");
}

#[test]
fn a_pdf_holds_its_font_and_a_png_has_the_asked_pixels() {
    let pdf = render(&everything(), Format::Pdf, &Style::default()).unwrap();
    let holds = |part: &[u8]| pdf.windows(part.len()).any(|window| window == part);
    assert!(pdf.starts_with(b"%PDF"));
    assert!(holds(b"DejaVuSans") && holds(b"/FontFile2"), "the font is not embedded");
    for (family, name) in [(Family::Sans, "DejaVuSans"), (Family::Serif, "DejaVuSerif")] {
        let pdf = render(&everything(), Format::Pdf, &Style { family, ..Style::default() }).unwrap();
        let fonts = embedded::fonts(&pdf);
        assert!(!fonts.is_empty() && fonts.iter().all(|font| font.contains(name)), "{fonts:?}");
        embedded::pdffonts_agrees(&pdf);
    }
    let style = Style { size: Size::OneColumn, dpi: 144.0, ..Style::default() };
    let png = render(&everything(), Format::Png, &style).unwrap();
    let reader = png::Decoder::new(std::io::Cursor::new(png)).read_info().unwrap();
    assert_eq!(reader.info().width, 2 * 241);
}

/// Width, letters and pixels of what is printed, by the numbers that the journals state.
#[test]
fn a_figure_is_as_large_as_its_journal_asks() {
    for (name, millimetres, letters) in [
        ("ieee", 88.9, 8.0..=10.0),
        ("ieee-two-column", 182.0, 8.0..=10.0),
        ("nature", 89.0, 5.0..=7.0),
        ("nature-two-column", 183.0, 5.0..=7.0),
    ] {
        let style = Style { size: name.parse().unwrap(), ..Style::default() };
        // A drawing makes its words as small as its boxes want.
        let mut figure = everything();
        figure.panels.pop();
        let svg = String::from_utf8(render(&figure, Format::Svg, &style).unwrap()).unwrap();
        let numbers = |key: &str| -> Vec<f64> {
            let head = format!(" {key}=\"");
            let found = svg.split(&head).skip(1).filter_map(|rest| rest.split('"').next());
            found.filter_map(|text| text.trim_end_matches("pt").parse().ok()).collect()
        };
        let width = numbers("width")[0] / 72.0 * 25.4;
        assert!((width - millimetres).abs() < 0.1, "{name}: {width} mm");
        let sizes = numbers("font-size");
        assert!(sizes.len() > 5 && sizes.iter().all(|size| letters.contains(size)), "{name}: {sizes:?}");
        let lines = numbers("stroke-width");
        assert!(lines.iter().all(|width| (0.25..=2.0).contains(width)), "{name}: {lines:?}");
    }
    let style = Style { size: Size::Ieee, ..Style::default() };
    let png = render(&everything(), Format::Png, &style).unwrap();
    let reader = png::Decoder::new(std::io::Cursor::new(png)).read_info().unwrap();
    assert_eq!(reader.info().width, 2100, "3.5 inches of 600 pixels");
    assert!("iee".parse::<Size>().unwrap_err().contains("ieee-two-column"));
}

#[test]
fn equal_figures_give_equal_bytes() {
    for format in [Format::Svg, Format::Pdf, Format::Png, Format::Csv] {
        let style = Style { dpi: 100.0, ..Style::default() };
        let twice = [(); 2].map(|()| render(&everything(), format, &style).unwrap());
        assert_eq!(twice[0], twice[1], "{format:?}");
    }
}

#[test]
fn the_table_has_every_number_bit_by_bit() {
    let figure = everything();
    let table = text(&figure, Format::Csv);
    let rows: Vec<Vec<String>> = ::csv::Reader::from_reader(table.as_bytes())
        .records()
        .map(|row| row.unwrap().iter().map(str::to_owned).collect())
        .collect();
    let mut points: Vec<[f64; 2]> = Vec::new();
    figure.panels[0].marks[2].rows(&figure.panels[0].x, &mut |row| points.push([row.x, row.y]));
    let found: Vec<&Vec<String>> = rows.iter().filter(|row| row[2].starts_with("predicted")).collect();
    assert_eq!(found.len(), points.len());
    for (row, [x, y]) in found.iter().zip(&points) {
        assert_eq!(row[3].parse::<f64>().unwrap().to_bits(), x.to_bits());
        assert_eq!(row[4].parse::<f64>().ok().map(f64::to_bits), Some(*y).filter(|y| !y.is_nan()).map(f64::to_bits));
    }
    let zoomed = Figure::new(vec![Panel { x: Axis::new("t", "s").range([2.0, 3.0]), ..figure.panels[0].clone() }]);
    let table = text(&zoomed, Format::Csv);
    assert_eq!(table.lines().filter(|row| row.contains("measured")).count(), 101, "only what is in view");
}

#[test]
fn reliability_counts_and_confusion_keeps_the_order() {
    let answers = [(0.95, true), (0.95, true), (0.95, false), (0.15, false)];
    let table = text(&diagnosis::reliability(&answers, 10), Format::Csv);
    assert!(table.contains(&format!("line,diagnosis,{},{}", (0.95 + 0.95 + 0.95) / 3.0, 2.0 / 3.0)), "{table}");
    assert!(table.contains("line,diagnosis,0.15,0,"));
    let names = ["friction", "payload"].map(str::to_owned);
    let table = text(&diagnosis::confusion(&names, &names, &[vec![9, 1], vec![2, 8]]), Format::Csv);
    let values: Vec<&str> = table.lines().skip(1).map(|row| row.split(',').nth(9).unwrap()).collect();
    assert_eq!(values, ["2", "8", "9", "1"], "rows from below: the first hidden effect is at the top");
}

#[test]
fn what_can_not_be_drawn_is_told() {
    assert!(matches!(render(&Figure::default(), Format::Svg, &Style::default()), Err(FigureError::Empty)));
    for dpi in [0.0, -1.0, 1e9, f64::NAN] {
        let style = Style { dpi, ..Style::default() };
        assert!(matches!(render(&everything(), Format::Png, &style), Err(FigureError::Pixels { .. })), "{dpi}");
    }
    assert!(Format::of(Path::new("figure.gif")).unwrap_err().to_string().contains(".svg, .pdf, .png or .csv"));
}

/// An interval that reaches below 0 has no lower end on a logarithmic axis, but is drawn all the same.
#[test]
fn no_whisker_is_dropped_from_a_logarithmic_axis() {
    let bars = Bars::beside(
        "nMSE",
        [0, 1],
        &[[1e-3, 1e-4, 1e-2], [1e-3, -1e-3, 3e-3], [1e-3, f64::NAN, f64::NAN]],
        Ink::Series(0),
    );
    let names = ["one", "two", "three"].map(str::to_owned).to_vec();
    let panel = Panel::new("errors", [Axis::names("", names), Axis::new("nMSE", "").logarithmic()]).with(bars);
    let svg = text(&Figure::new(vec![panel]), Format::Svg);
    assert_eq!(svg.matches("stroke=\"#000000\" stroke-width=\"0.80\"").count(), 2, "of the third none is known");
}

/// Marks share the numbers of whoever has them: a panel of half a million samples costs no copy of them.
#[test]
fn marks_share_their_numbers() {
    struct Log {
        time: Vec<f64>,
    }
    let log = std::sync::Arc::new(Log { time: vec![0.0, 1.0, 2.0] });
    let time = Shared::of(&log, |log| &log.time);
    let line = Line::new("t", time.clone(), time, Ink::Text);
    assert_eq!(line.x.as_ptr(), log.time.as_ptr());
    assert_eq!(line.clone().y.as_ptr(), log.time.as_ptr());
}

/// Every kind of mark is set by LaTeX without a complaint, if it is there.
#[test]
fn the_picture_of_pgfplots_is_set() {
    let has =
        |file: &str| std::process::Command::new("kpsewhich").arg(file).output().is_ok_and(|out| out.status.success());
    if !has("pgfplots.sty") || !has("article.cls") {
        eprintln!("left out: the picture of pgfplots is not set, because there is no LaTeX with pgfplots here");
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    for (path, bytes) in files(&everything(), Format::Csv, &Style::default(), &at.join("all.csv")).unwrap() {
        std::fs::write(path, bytes).unwrap();
    }
    let paper = "\\documentclass{article}\n\\usepackage{pgfplots}\\usepgfplotslibrary{groupplots}\\pgfplotsset{compat=1.16}\n\
                 \\begin{document}\\input{all.tex}\\end{document}\n";
    std::fs::write(at.join("paper.tex"), paper).unwrap();
    let set = std::process::Command::new("pdflatex")
        .args(["-halt-on-error", "-interaction=nonstopmode", "paper.tex"])
        .current_dir(at)
        .output()
        .unwrap();
    let said = String::from_utf8_lossy(&set.stdout);
    assert!(set.status.success() && at.join("paper.pdf").exists(), "{said}");
    assert!(!said.contains("Missing character") && !said.contains("Package pgfplots Warning"), "{said}");
}

/// The SVG of a figure in a style.
fn svg(figure: &Figure, style: &Style) -> String {
    String::from_utf8(render(figure, Format::Svg, style).unwrap()).unwrap()
}

/// The value of an attribute at the first place where `tag` stands.
fn number(svg: &str, tag: &str, attribute: &str) -> f64 {
    let rest = &svg[svg.find(tag).unwrap_or_else(|| panic!("no {tag}"))..];
    let value = rest.split_once(&format!(" {attribute}=\"")).unwrap().1;
    value.split(['"', 'p']).next().unwrap().parse().unwrap()
}

/// Names of models grow with every effect; they stand in lines, whole, and leave the figure to the plot.
#[test]
fn long_names_below_bars_leave_room_for_the_plot() {
    let effects =
        ["", " + Coulomb 1, 2", " + Coulomb 1, 2 + viscous 1", " + Coulomb 1, 2 + viscous 1 + torque offset 2"];
    let few: Vec<String> = effects.iter().map(|effects| format!("rigid body{effects}")).collect();
    let many: Vec<String> = (0..9).map(|number| format!("{}, seed {number}", few[3])).collect();
    for (names, sizes) in [(few, &[Size::OneColumn, Size::TwoColumn][..]), (many, &[Size::Ieee, Size::NatureTwoColumn])]
    {
        let bars = |joint: usize| {
            let heights: Vec<[f64; 3]> = names.iter().map(|_| [0.0123, f64::NAN, f64::NAN]).collect();
            Bars::beside(format!("joint {}", joint + 1), [joint, 3], &heights, Ink::Series(joint))
                .written(ticks::percent)
        };
        let axes = [Axis::names("", names.clone()), Axis::new("nMSE", "").logarithmic().range([1e-3, 1.0])];
        let figure = Figure::new(vec![Panel::new("held-out error by step", axes).with_all((0..3).map(bars))]);
        for size in sizes {
            let svg = svg(&figure, &Style { size: *size, ..Style::default() });
            let share = number(&svg, "<clipPath", "height") / number(&svg, "<svg", "height");
            assert!(share >= 0.6, "{size:?}: the plot has {share} of the height");
            for word in names.iter().flat_map(|name| name.split(' ')) {
                assert!(svg.contains(word), "{size:?}: {word} is lost");
            }
            assert!(!svg.contains('…'));
        }
    }
}

/// What is written over bars does not reach over the neighbours.
#[test]
fn numbers_over_narrow_bars_are_smaller_or_left_out() {
    let drawn = |joints: usize| {
        let bars = |joint: usize| {
            let heights = vec![[0.00038, f64::NAN, f64::NAN]; 4];
            Bars::beside("", [joint, joints], &heights, Ink::Series(joint)).written(ticks::percent)
        };
        let names = (0..4).map(|number| number.to_string()).collect();
        let axes = [Axis::names("", names), Axis::new("nMSE", "").logarithmic().range([1e-4, 1.0])];
        let figure = Figure::new(vec![Panel::new("errors", axes).with_all((0..joints).map(bars))]);
        svg(&figure, &Style { size: Size::TwoColumn, ..Style::default() })
    };
    let size = |svg: &str| {
        let text = svg.split("<text").find(|text| text.contains("0.038 %"))?;
        Some(number(&format!("<text{text}"), "<text", "font-size"))
    };
    assert_eq!(size(&drawn(1)), Some(8.0));
    assert!(size(&drawn(3)).is_some_and(|size| (4.8..8.0).contains(&size)));
    assert_eq!(size(&drawn(7)), None);
}

/// A title that is longer than its plot goes on in the next line, and the legend stands below it.
#[test]
fn a_long_title_stands_in_lines() {
    let panel = Panel::new(
        "joint 1: what is left beside inertia, Coriolis and gravity",
        [Axis::default(), Axis::new("", "N m")],
    )
    .with(Line::through("measured", [[0.0, 0.0], [1.0, 1.0]], Ink::Measured));
    let figure = Figure { panels: vec![panel.clone(), panel], columns: 2 };
    let svg = svg(&figure, &Style { size: Size::OneColumn, legend: Legend::Own, ..Style::default() });
    assert!(!svg.contains("beside inertia, Coriolis and gravity"), "it is broken");
    assert!(svg.contains("gravity") && svg.contains("[N m]"), "the unit is not");
}

/// Numbers at the left of a low plot have room below each other.
#[test]
fn a_low_plot_has_fewer_numbers() {
    let line = Line::through("", [[0.0, -40.0], [1.0, 3.0]], Ink::Measured);
    let figure = Figure::new(vec![Panel::new("torque", [Axis::default(), Axis::new("", "N m")]).with(line)]);
    let numbers = |height: f64| {
        let svg = svg(&figure, &Style { height: Some(height), ..Style::default() });
        let at_the_left = svg.split("<text").filter(|text| text.contains("\"end\""));
        let mut lines: Vec<f64> = at_the_left.map(|text| number(&format!("<text{text}"), "<text", "y")).collect();
        lines.sort_by(f64::total_cmp);
        lines
    };
    for height in [8.0, 15.0, 60.0] {
        let lines = numbers(height);
        assert!(lines.len() > 1 && lines.windows(2).all(|pair| pair[1] - pair[0] > 8.0), "{height} mm: {lines:?}");
    }
    assert!(numbers(60.0).len() > numbers(8.0).len());
}
