//! A report as Markdown: text and tables, without pictures.

use super::document::{Block, Document, Table};

/// The text.
pub(super) fn text(document: &Document) -> String {
    let mut text = format!("# {}\n", document.title);
    for block in &document.blocks {
        text.push('\n');
        match block {
            Block::Heading(heading) => text.push_str(&format!("## {heading}\n")),
            Block::Text(line) => text.push_str(&format!("{line}\n")),
            Block::List(lines) => lines.iter().for_each(|line| text.push_str(&format!("- {line}\n"))),
            Block::Code(code) => code.lines().for_each(|line| text.push_str(&format!("    {line}\n"))),
            Block::Table(table) => text.push_str(&table_of(table)),
            Block::Figure { .. } => {}
        }
    }
    text
}

fn table_of(table: &Table) -> String {
    let row = |cells: &[String]| {
        let cells: Vec<String> = cells.iter().map(|cell| cell.replace('|', "\\|")).collect();
        format!("| {} |\n", cells.join(" | "))
    };
    let rows: String = table.rows.iter().map(|cells| row(cells)).collect();
    let line = "| --- ".repeat(table.head.len());
    format!("**{}**\n\n{}{line}|\n{rows}", table.title, row(&table.head))
}
