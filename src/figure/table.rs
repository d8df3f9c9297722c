//! A table as data, and as the text that papers, notes and other programs take: LaTeX (booktabs), Markdown, CSV.

use super::latex::escaped;

/// A table with its title; it may be empty.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Table {
    /// What it is about.
    pub title: String,
    /// The name of each column.
    pub head: Vec<String>,
    /// The cells, row by row.
    pub rows: Vec<Vec<String>>,
}

/// What a table is written as.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum TableFormat {
    /// For notes and for the web.
    Markdown,
    /// For papers; needs the package booktabs.
    Latex,
    /// For other programs.
    Csv,
}

impl TableFormat {
    /// What it is called, and how its files end.
    pub const ALL: [(TableFormat, &'static str, &'static str); 3] = [
        (TableFormat::Markdown, "Markdown", "md"),
        (TableFormat::Latex, "LaTeX", "tex"),
        (TableFormat::Csv, "CSV", "csv"),
    ];
}

impl Table {
    /// The text of the table, which ends with a line break.
    pub fn to_text(&self, format: TableFormat) -> String {
        match format {
            TableFormat::Markdown => self.markdown(),
            TableFormat::Latex => self.latex(),
            TableFormat::Csv => self.csv(),
        }
    }

    /// Whether the cells of a column are numbers, or stand for such.
    pub fn is_number(&self, column: usize) -> bool {
        let cells = self.rows.iter().filter_map(|row| row.get(column));
        cells.into_iter().all(|text| text.starts_with(|first: char| first.is_ascii_digit() || "<−-—–".contains(first)))
    }

    fn markdown(&self) -> String {
        let row = |cells: &[String]| {
            let cells: Vec<String> = cells.iter().map(|cell| cell.replace('|', "\\|").replace('\n', " ")).collect();
            format!("| {} |\n", cells.join(" | "))
        };
        let rows: String = self.rows.iter().map(|cells| row(cells)).collect();
        let title = if self.title.is_empty() { String::new() } else { format!("**{}**\n\n", self.title) };
        format!("{title}{}{}|\n{rows}", row(&self.head), "| --- ".repeat(self.head.len()))
    }

    fn latex(&self) -> String {
        let row = |cells: &[String]| {
            let cells: Vec<String> = cells.iter().map(|cell| escaped(cell)).collect();
            // Behind the end of a row these would be read as belonging to it.
            let apart = if cells.first().is_some_and(|cell| cell.starts_with(['[', '*'])) { "{}" } else { "" };
            format!("    {apart}{} \\\\\n", cells.join(" & "))
        };
        let rows: String = self.rows.iter().map(|cells| row(cells)).collect();
        let columns: String =
            (0..self.head.len()).map(|column| if self.is_number(column) { 'r' } else { 'l' }).collect();
        let caption =
            if self.title.is_empty() { String::new() } else { format!("  \\caption{{{}}}\n", escaped(&self.title)) };
        format!(
            "\\begin{{table}}\n{caption}  \\begin{{tabular}}{{{columns}}}\n    \\toprule\n{}    \\midrule\n{rows}    \\bottomrule\n  \
             \\end{{tabular}}\n\\end{{table}}\n",
            row(&self.head)
        )
    }

    fn csv(&self) -> String {
        let field = |cell: &String| match cell.contains([',', '"', '\n', '\r']) {
            true => format!("\"{}\"", cell.replace('"', "\"\"")),
            false => cell.clone(),
        };
        let line = |cells: &Vec<String>| cells.iter().map(field).collect::<Vec<_>>().join(",") + "\n";
        std::iter::once(&self.head).chain(&self.rows).map(line).collect()
    }
}

/// Several tables in one text, with an empty line between them.
pub fn written(tables: &[Table], format: TableFormat) -> String {
    let head = if format == TableFormat::Latex { "% needs \\usepackage{booktabs}\n" } else { "" };
    let texts: Vec<String> = tables.iter().map(|table| table.to_text(format)).collect();
    format!("{head}{}", texts.join("\n"))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn errors() -> Table {
        let row = |cells: [&str; 3]| cells.map(str::to_owned).to_vec();
        Table {
            title: "errors of 50 % of it".to_owned(),
            head: row(["joint", "nMSE", "why"]),
            rows: vec![row(["1", "0.5", "a|b, \"c\""]), row(["2", "–", "τ_c"])],
        }
    }

    #[test]
    fn a_table_is_the_same_in_every_format() {
        assert_eq!(
            errors().to_text(TableFormat::Markdown),
            "**errors of 50 % of it**\n\n| joint | nMSE | why |\n| --- | --- | --- |\n| 1 | 0.5 | a\\|b, \"c\" |\n| 2 | – | τ_c |\n"
        );
        assert_eq!(errors().to_text(TableFormat::Csv), "joint,nMSE,why\n1,0.5,\"a|b, \"\"c\"\"\"\n2,–,τ_c\n");
        let tex = errors().to_text(TableFormat::Latex);
        assert!(tex.contains("\\caption{errors of 50 \\% of it}") && tex.contains("\\begin{tabular}{rrl}"), "{tex}");
        assert!(tex.contains("    2 & -- & $\\tau$\\_c \\\\\n"), "{tex}");
    }

    /// LaTeX takes `[…]` and `*` behind the end of a row for words of its own.
    #[test]
    fn a_row_of_latex_does_not_begin_with_a_bracket() {
        let rows = ["[1, 2]", "*", "1"].map(|cell| vec![cell.to_owned()]).to_vec();
        let table = Table { head: vec!["interval".to_owned()], rows, ..Table::default() };
        let tex = table.to_text(TableFormat::Latex);
        assert!(tex.contains("    {}[1, 2] \\\\\n    {}* \\\\\n    1 \\\\\n"), "{tex}");
    }

    #[test]
    fn several_tables_follow_each_other() {
        let bare = Table { title: String::new(), ..errors() };
        let text = written(&[bare.clone(), bare.clone()], TableFormat::Latex);
        assert!(text.starts_with("% needs \\usepackage{booktabs}\n\\begin{table}\n  \\begin{tabular}"), "{text}");
        assert_eq!(text.matches("\\end{table}\n").count(), 2);
        assert_eq!(written(&[bare.clone(), bare], TableFormat::Csv).split("\n\n").count(), 2);
    }
}
