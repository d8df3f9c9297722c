//! A page that needs nothing else: pictures stand in it, and it asks no network for anything.

use super::document::{Block, Document, Table};

const STYLE: &str = "body{font:15px/1.5 'DejaVu Sans',Verdana,sans-serif;max-width:60em;margin:2em auto;padding:0 1em;color:#1a1a1a;\
background:#fff}h1{font-size:1.6em}h2{font-size:1.25em;margin-top:2em;border-bottom:1px solid #bbb}\
table{border-collapse:collapse;margin:1em 0;font-size:.87em}caption{text-align:left;font-weight:bold;padding:.3em 0}\
th,td{border-bottom:1px solid #ddd;padding:.25em .7em;text-align:left;vertical-align:top}th{border-bottom:2px solid #888}\
pre{background:#f3f3f3;padding:.8em;overflow-x:auto}figure{margin:1.2em 0;break-inside:avoid}figcaption{font-size:.87em}\
svg{max-width:100%;height:auto}.beside{display:grid;grid-template-columns:1fr 1fr;gap:2em}.beside>div{min-width:0;overflow-x:auto}\
.beside h3{font-size:1em;color:#555;margin:.8em 0 0}.note{display:none;position:absolute;pointer-events:none;background:#fff;border:1px solid #888;border-radius:3px;padding:.2em .6em;\
font-size:.8em;white-space:nowrap}body:has(.beside){max-width:110em}@media print{.note{display:none!important}body{margin:0;max-width:none}\
h2,h3,caption{break-after:avoid}tr,.short{break-inside:avoid}}.number{white-space:nowrap}";

/// A table of at most so many rows stands on one page.
const SHORT: usize = 16;

/// What lets charts tell the values at the pointer.
const HOVER: &str = include_str!("hover.js");

/// The page.
pub(super) fn page(document: &Document) -> String {
    let title = escaped(&document.title);
    let mut page = format!(
        "<!doctype html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
         <meta name=\"viewport\" content=\"width=device-width\">\n<title>{title}</title>\n<style>{STYLE}</style>\n</head>\n<body>\n\
         <h1>{title}</h1>\n"
    );
    document.blocks.iter().for_each(|part| page.push_str(&block(part)));
    page.push_str(&format!("<script>\n{HOVER}</script>\n</body>\n</html>\n"));
    page
}

fn block(part: &Block) -> String {
    match part {
        Block::Heading(text) => format!("<h2>{}</h2>\n", escaped(text)),
        Block::Text(text) => format!("<p>{}</p>\n", escaped(text)),
        Block::Code(text) => format!("<pre>{}</pre>\n", escaped(text)),
        Block::Figure { title, svg } => {
            format!("<figure>\n{svg}\n<figcaption>{}</figcaption>\n</figure>\n", escaped(title))
        }
        Block::List(lines) => {
            let lines: String = lines.iter().map(|line| format!("<li>{}</li>\n", escaped(line))).collect();
            if lines.is_empty() { String::new() } else { format!("<ul>\n{lines}</ul>\n") }
        }
        Block::Table(table) => table_of(table),
        Block::Beside(parts) => {
            let column = |(name, blocks): &(String, Vec<Block>)| {
                let inside: String = blocks.iter().map(block).collect();
                format!("<div>\n<h3>{}</h3>\n{inside}</div>\n", escaped(name))
            };
            format!("<div class=\"beside\">\n{}</div>\n", parts.iter().map(column).collect::<String>())
        }
    }
}

fn table_of(table: &Table) -> String {
    let cell = |tag: &str, text: &String| {
        // A number is not broken at its sign.
        let class = if text.parse::<f64>().is_ok() { " class=\"number\"" } else { "" };
        format!("<{tag}{class}>{}</{tag}>", escaped(text))
    };
    let row = |tag: &str, cells: &[String]| {
        format!("<tr>{}</tr>\n", cells.iter().map(|text| cell(tag, text)).collect::<String>())
    };
    let rows: String = table.rows.iter().map(|cells| row("td", cells)).collect();
    let (title, head) = (escaped(&table.title), row("th", &table.head));
    let class = if table.rows.len() <= SHORT { " class=\"short\"" } else { "" };
    format!("<table{class}>\n<caption>{title}</caption>\n<thead>{head}</thead>\n<tbody>\n{rows}</tbody>\n</table>\n")
}

fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}
