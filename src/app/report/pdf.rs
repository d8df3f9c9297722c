//! A report as pages of paper: text and tables are set here, figures stand between them as they are. Each page is an SVG, which the
//! printer of figures turns into PDF.

use std::fmt::Write as _;

use super::document::{Block, Document, Table};
use crate::figure::font::Ruler;
use crate::figure::{self, Family, FigureError, svg_escaped};

/// A4 \[points\].
const PAGE: [f64; 2] = [595.0, 842.0];
const MARGIN: f64 = 49.5;
const WIDTH: f64 = PAGE[0] - 2.0 * MARGIN;
/// From line to line, in letters.
const LEADING: f64 = 1.4;
/// Between the columns of a table \[points\].
const GAP: f64 = 8.0;

/// Heights of letters \[points\].
const TITLE: f64 = 16.0;
const HEADING: f64 = 12.0;
const TEXT: f64 = 9.0;
const SMALL: f64 = 7.5;

const INK: &str = "#1a1a1a";
const WEAK: &str = "#666666";

/// The pages as PDF.
///
/// # Errors
/// [`FigureError`] if a page can't be written.
pub(super) fn pages(document: &Document) -> Result<Vec<u8>, FigureError> {
    let mut paper = Paper { ruler: Ruler::of(Family::Sans), pages: vec![String::new()], y: MARGIN };
    paper.paragraph(&document.title, TITLE, INK);
    document.blocks.iter().for_each(|block| paper.block(block));
    figure::pages(&paper.finished(&document.title), Family::Sans)
}

/// Pages that fill from above.
struct Paper {
    ruler: Ruler,
    /// What is on each, as SVG.
    pages: Vec<String>,
    /// Where the next line begins on the last.
    y: f64,
}

impl Paper {
    fn block(&mut self, block: &Block) {
        match block {
            Block::Heading(text) => {
                self.y += HEADING;
                // A heading does not stand alone at the foot of a page.
                self.make_room(5.0 * HEADING);
                self.paragraph(text, HEADING, INK);
                self.rule(self.y - 2.0);
                self.y += 4.0;
            }
            Block::Text(text) => {
                self.paragraph(text, TEXT, INK);
                self.y += 0.5 * TEXT;
            }
            Block::List(lines) => {
                lines.iter().for_each(|line| self.paragraph(&format!("– {line}"), TEXT, INK));
                self.y += 0.5 * TEXT;
            }
            Block::Code(code) => code.lines().for_each(|line| self.paragraph(line, SMALL, WEAK)),
            Block::Table(table) => self.table(table),
            Block::Figure { title, svg } => self.figure(title, svg),
            Block::Beside(parts) => self.beside(parts),
        }
    }

    /// Two sides: their texts and tables one after the other, their figures beside each other below.
    fn beside(&mut self, parts: &[(String, Vec<Block>); 2]) {
        let is_figure = |block: &&Block| matches!(block, Block::Figure { .. });
        for (name, blocks) in parts {
            let texts: Vec<&Block> = blocks.iter().filter(|block| !is_figure(block)).collect();
            if !texts.is_empty() {
                self.paragraph(name, TEXT, WEAK);
            }
            texts.into_iter().for_each(|block| self.block(block));
        }
        let figures = parts.each_ref().map(|(_, blocks)| blocks.iter().filter(is_figure).collect::<Vec<_>>());
        for row in 0..figures.each_ref().map(Vec::len).into_iter().max().unwrap_or(0) {
            let names = parts.each_ref().map(|(name, _)| name.as_str());
            self.pair(figures.each_ref().map(|side| side.get(row).copied()), names);
        }
    }

    /// Two figures at one height, each below the name of its side.
    fn pair(&mut self, figures: [Option<&Block>; 2], names: [&str; 2]) {
        const COLUMN: f64 = 0.5 * (WIDTH - GAP);
        let drawn = figures.map(|figure| match figure {
            Some(Block::Figure { title, svg }) => Some((title, svg, size_of(svg)?)),
            _ => None,
        });
        let scaled = |[width, height]: [f64; 2]| (COLUMN / width).min(1.0) * height;
        let height = drawn.iter().flatten().map(|(.., size)| scaled(*size)).fold(0.0, f64::max);
        self.make_room(height + 4.0 * LEADING * SMALL);
        let top = self.y;
        let mut end = top;
        for (side, (figure, name)) in drawn.into_iter().zip(names).enumerate() {
            let Some((title, svg, size)) = figure else { continue };
            let x = MARGIN + side as f64 * (COLUMN + GAP);
            self.y = top;
            self.words(x, name, SMALL, WEAK);
            self.y += LEADING * SMALL;
            let (y, scale) = (self.y, (COLUMN / size[0]).min(1.0));
            self.put(format_args!("<g transform=\"translate({x:.2} {y:.2}) scale({scale:.4})\">{svg}</g>\n"));
            self.y += height;
            for line in wrapped(&self.ruler, title, SMALL, COLUMN) {
                self.words(x, &line, SMALL, WEAK);
                self.y += LEADING * SMALL;
            }
            end = end.max(self.y);
        }
        self.y = end + TEXT;
    }

    /// A new page, unless so much fits on this one; whether it is new.
    fn make_room(&mut self, height: f64) -> bool {
        let is_full = self.y + height > PAGE[1] - MARGIN && self.y > MARGIN;
        if is_full {
            self.pages.push(String::new());
            self.y = MARGIN;
        }
        is_full
    }

    /// Adds SVG to the page; a string takes everything.
    fn put(&mut self, svg: std::fmt::Arguments) {
        if let Some(page) = self.pages.last_mut() {
            let _ = page.write_fmt(svg);
        }
    }

    fn rule(&mut self, y: f64) {
        let right = PAGE[0] - MARGIN;
        self.put(format_args!("<path d=\"M{MARGIN} {y:.2}H{right}\" stroke=\"#999999\" stroke-width=\"0.5\"/>\n"));
    }

    /// Words side by side at the height of the next line.
    fn words(&mut self, x: f64, text: &str, size: f64, color: &str) {
        let y = self.y + size;
        let text = svg_escaped(text);
        self.put(format_args!("<text x=\"{x:.2}\" y=\"{y:.2}\" font-size=\"{size}\" fill=\"{color}\">{text}</text>\n"));
    }

    fn paragraph(&mut self, text: &str, size: f64, color: &str) {
        for line in wrapped(&self.ruler, text, size, WIDTH) {
            self.make_room(LEADING * size);
            self.words(MARGIN, &line, size, color);
            self.y += LEADING * size;
        }
    }

    fn table(&mut self, table: &Table) {
        self.y += 0.5 * TEXT;
        self.make_room(5.0 * TEXT);
        self.paragraph(&table.title, TEXT, INK);
        let widths = widths(&self.ruler, table);
        self.row(&table.head, &widths, None);
        self.rule(self.y);
        self.y += 3.0;
        table.rows.iter().for_each(|row| self.row(row, &widths, Some(&table.head)));
        self.y += TEXT;
    }

    /// A row, line by line; on a new page its head stands above it.
    fn row(&mut self, cells: &[String], widths: &[f64], head: Option<&[String]>) {
        let wrap = |(cell, width): (&String, &f64)| wrapped(&self.ruler, cell, SMALL, *width);
        let columns: Vec<Vec<String>> = cells.iter().zip(widths).map(wrap).collect();
        for line in 0..columns.iter().map(Vec::len).max().unwrap_or(0) {
            if self.make_room(LEADING * SMALL)
                && let Some(head) = head
            {
                self.row(head, widths, None);
                self.rule(self.y);
                self.y += 3.0;
            }
            let mut x = MARGIN;
            for (column, width) in columns.iter().zip(widths) {
                if let Some(text) = column.get(line) {
                    self.words(x, text, SMALL, if head.is_some() { INK } else { WEAK });
                }
                x += width + GAP;
            }
            self.y += LEADING * SMALL;
        }
    }

    fn figure(&mut self, title: &str, svg: &str) {
        let Some([width, height]) = size_of(svg) else { return };
        let scale = (WIDTH / width).min(1.0);
        self.make_room(scale * height + 2.0 * LEADING * SMALL);
        let y = self.y;
        self.put(format_args!("<g transform=\"translate({MARGIN} {y:.2}) scale({scale:.4})\">{svg}</g>\n"));
        self.y += scale * height;
        self.paragraph(title, SMALL, WEAK);
        self.y += TEXT;
    }

    /// The pages, each with its number.
    fn finished(mut self, title: &str) -> Vec<String> {
        let count = self.pages.len();
        let [width, height] = PAGE;
        let name = wrapped(&self.ruler, title, SMALL, WIDTH - 50.0).swap_remove(0);
        let mut pages = Vec::new();
        for number in 0..count {
            let content = std::mem::take(&mut self.pages[number]);
            pages.push(format!(
                "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{width}pt\" height=\"{height}pt\" viewBox=\"0 0 {width} {height}\" \
                 font-family=\"{}\">\n{content}<text x=\"{MARGIN}\" y=\"{foot}\" font-size=\"{SMALL}\" fill=\"{WEAK}\">{}</text>\n\
                 <text x=\"{right}\" y=\"{foot}\" font-size=\"{SMALL}\" fill=\"{WEAK}\" text-anchor=\"end\">{} / {count}</text>\n</svg>\n",
                Family::Sans.name(),
                svg_escaped(&name),
                number + 1,
                foot = height - 0.5 * MARGIN,
                right = width - MARGIN,
            ));
        }
        pages
    }
}

/// A text in lines of this width; a word that is longer is broken. At least one line.
fn wrapped(ruler: &Ruler, text: &str, size: f64, width: f64) -> Vec<String> {
    let mut lines = vec![String::new()];
    for word in text.split_whitespace() {
        let Some(line) = lines.last_mut() else { break };
        let longer = if line.is_empty() { word.to_owned() } else { format!("{line} {word}") };
        if ruler.width(&longer, size) <= width {
            *line = longer;
            continue;
        }
        if !line.is_empty() {
            lines.push(String::new());
        }
        for letter in word.chars() {
            let Some(line) = lines.last_mut() else { break };
            line.push(letter);
            if ruler.width(line, size) > width && line.chars().count() > 1 {
                line.pop();
                lines.push(letter.to_string());
            }
        }
    }
    lines
}

/// How wide the columns of a table are: as wide as they like or, where that is too much, the widest share what the others leave.
fn widths(ruler: &Ruler, table: &Table) -> Vec<f64> {
    let cells = |column: usize| table.rows.iter().chain([&table.head]).filter_map(move |row| row.get(column));
    let like = |column: usize| cells(column).map(|cell| ruler.width(cell, SMALL)).fold(0.0, f64::max) + 0.1;
    let mut widths: Vec<f64> = (0..table.head.len()).map(like).collect();
    let available = WIDTH - GAP * widths.len().saturating_sub(1) as f64;
    let mut sorted = widths.clone();
    sorted.sort_by(f64::total_cmp);
    let (mut left, mut most) = (available, f64::INFINITY);
    for (number, width) in sorted.iter().enumerate() {
        let share = left / (sorted.len() - number) as f64;
        if *width > share {
            most = share;
            break;
        }
        left -= width;
    }
    widths.iter_mut().for_each(|width| *width = width.min(most));
    widths
}

/// Width and height of a figure \[points\].
fn size_of(svg: &str) -> Option<[f64; 2]> {
    let document = roxmltree::Document::parse(svg).ok()?;
    let numbers: Vec<f64> =
        document.root_element().attribute("viewBox")?.split(' ').map(str::parse).collect::<Result<_, _>>().ok()?;
    Some([*numbers.get(2)?, *numbers.get(3)?])
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A log may have any letter in its names, and SVG not.
    #[test]
    fn signs_below_the_space_are_printed_as_spaces() {
        let document =
            Document { title: "arm \u{1b}[31m <1>".to_owned(), blocks: vec![Block::Code("a\tb\u{1}".into())] };
        assert!(pages(&document).is_ok_and(|pdf| pdf.starts_with(b"%PDF")));
    }

    #[test]
    fn figures_of_two_sides_stand_beside_each_other() {
        let figure = |title: &str| Block::Figure {
            title: title.to_owned(),
            svg: "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 400 300\"/>".to_owned(),
        };
        let side = |name: &str, count: usize| (name.to_owned(), (0..count).map(|_| figure("torque")).collect());
        let mut paper = Paper { ruler: Ruler::of(Family::Sans), pages: vec![String::new()], y: MARGIN };
        paper.beside(&[side("before", 2), side("after", 1)]);
        let places: Vec<Vec<f64>> = paper.pages[0]
            .split("translate(")
            .skip(1)
            .map(|rest| rest.split(')').next().unwrap().split(' ').map(|number| number.parse().unwrap()).collect())
            .collect();
        assert_eq!((places.len(), places[0][0], places[2][0]), (3, MARGIN, MARGIN));
        assert!(
            places[1][0] > 0.5 * PAGE[0] && places[0][1] == places[1][1] && places[2][1] > places[1][1],
            "{places:?}"
        );
    }

    #[test]
    fn text_and_tables_fit_the_page() {
        let ruler = Ruler::of(Family::Sans);
        let text = "a word and anotherwordthatismuchlongerthanthewidthofitscolumn, and more";
        let lines = wrapped(&ruler, text, SMALL, 100.0);
        assert!(lines.len() > 3 && lines.iter().all(|line| ruler.width(line, SMALL) <= 100.0), "{lines:?}");
        let kept: String = lines.concat().replace(' ', "");
        assert_eq!(kept, text.replace(' ', ""), "no letter is lost");
        let row = |cells: [&str; 3]| cells.map(str::to_owned).to_vec();
        let rows = vec![row(["1", &"long ".repeat(60), &"longer ".repeat(60)]); 200];
        let table = Table { title: "t".to_owned(), head: row(["a", "b", "c"]), rows };
        let widths = widths(&ruler, &table);
        assert!(widths.iter().sum::<f64>() + 2.0 * GAP <= WIDTH + 0.1 && widths[0] < 10.0, "{widths:?}");
        let mut paper = Paper { ruler, pages: vec![String::new()], y: MARGIN };
        paper.table(&table);
        assert!(paper.pages.len() > 3 && paper.pages.iter().all(|page| page.contains(">a</text>")), "heads on each");
        let pages = paper.finished("title");
        assert!(pages[1].contains(&format!("2 / {}", pages.len())));
        let heights = |page: &String| {
            let of = |part: &str| part.split('"').next().and_then(|y| y.parse::<f64>().ok());
            page.split(" y=\"").skip(1).filter_map(of).fold(0.0, f64::max)
        };
        assert!(pages.iter().all(|page| heights(page) < PAGE[1]));
    }
}
