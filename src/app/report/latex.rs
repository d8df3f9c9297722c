//! The tables of a report for a paper: LaTeX with booktabs.

use super::document::{Block, Document, Table};
use crate::figure::latex::escaped;

/// All tables, one after the other.
pub(super) fn tables(document: &Document) -> String {
    let mut text = format!("% {}\n% needs \\usepackage{{booktabs}}\n", document.title);
    document.blocks.iter().for_each(|part| text.push_str(&block(part)));
    text
}

fn block(part: &Block) -> String {
    match part {
        Block::Heading(heading) => format!("\n% {heading}\n"),
        Block::Table(table) => table_of(table),
        Block::Beside(parts) => {
            let below = |(name, blocks): &(String, Vec<Block>)| {
                format!("\n% {name}\n{}", blocks.iter().map(block).collect::<String>())
            };
            parts.iter().map(below).collect()
        }
        Block::Text(_) | Block::List(_) | Block::Figure { .. } | Block::Code(_) => String::new(),
    }
}

fn table_of(table: &Table) -> String {
    let row = |cells: &[String]| {
        let cells: Vec<String> = cells.iter().map(|cell| escaped(cell)).collect();
        format!("    {} \\\\\n", cells.join(" & "))
    };
    let rows: String = table.rows.iter().map(|cells| row(cells)).collect();
    format!(
        "\\begin{{table}}\n  \\caption{{{}}}\n  \\begin{{tabular}}{{{}}}\n    \\toprule\n{}    \\midrule\n{rows}    \\bottomrule\n  \
         \\end{{tabular}}\n\\end{{table}}\n",
        escaped(&table.title),
        "l".repeat(table.head.len()),
        row(&table.head)
    )
}
