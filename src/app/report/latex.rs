//! The tables of a report for a paper: LaTeX with booktabs.

use super::document::{Block, Document};
use crate::figure::table::TableFormat;

/// All tables, one after the other.
pub(super) fn tables(document: &Document) -> String {
    let mut text = format!("% {}\n% needs \\usepackage{{booktabs}}\n", document.title);
    document.blocks.iter().for_each(|part| text.push_str(&block(part)));
    text
}

fn block(part: &Block) -> String {
    match part {
        Block::Heading(heading) => format!("\n% {heading}\n"),
        Block::Table(table) => table.to_text(TableFormat::Latex),
        Block::Beside(parts) => {
            let below = |(name, blocks): &(String, Vec<Block>)| {
                format!("\n% {name}\n{}", blocks.iter().map(block).collect::<String>())
            };
            parts.iter().map(below).collect()
        }
        Block::Text(_) | Block::List(_) | Block::Figure { .. } | Block::Code(_) => String::new(),
    }
}
