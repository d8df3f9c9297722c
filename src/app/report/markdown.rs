//! A report as Markdown: text and tables, without pictures.

use super::document::{Block, Document};
use crate::figure::table::TableFormat;

/// The text.
pub(super) fn text(document: &Document) -> String {
    let mut text = format!("# {}\n", document.title);
    document.blocks.iter().for_each(|part| text.push_str(&block(part)));
    text
}

fn block(part: &Block) -> String {
    match part {
        Block::Heading(heading) => format!("\n## {heading}\n"),
        Block::Text(line) => format!("\n{line}\n"),
        Block::List(lines) => format!("\n{}", lines.iter().map(|line| format!("- {line}\n")).collect::<String>()),
        Block::Code(code) => format!("\n{}", code.lines().map(|line| format!("    {line}\n")).collect::<String>()),
        Block::Table(table) => format!("\n{}", table.to_text(TableFormat::Markdown)),
        Block::Beside(parts) => {
            let below = |(name, blocks): &(String, Vec<Block>)| {
                format!("\n### {name}\n{}", blocks.iter().map(block).collect::<String>())
            };
            parts.iter().map(below).collect()
        }
        Block::Figure { .. } => String::new(),
    }
}
