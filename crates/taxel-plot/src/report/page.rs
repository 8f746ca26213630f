//! A report as one page of HTML.

use std::fmt::Write;

use super::{Report, Section, Table};
use crate::svg::escaped;

/// Labels of pictures are 10 units high: they are read at 12 pixels on a screen, and at 8 points on paper.
const STYLE: &str = "\
:root{color-scheme:light;--ink:#1d1d1f;--soft:#5b5b60;--line:#d9d9de}\
body{font:15px/1.5 Inter,system-ui,Helvetica,Arial,sans-serif;color:var(--ink);background:#fff;max-width:64rem;margin:2.5rem auto;padding:0 1.5rem}\
h1{font-size:1.8rem;line-height:1.2;margin:0 0 1rem}h2{font-size:1.25rem;margin:2.6rem 0 .6rem;padding-top:.9rem;border-top:1px solid var(--line)}\
@page{size:A4;margin:14mm 12mm;@bottom-right{content:counter(page) \" / \" counter(pages);font:8pt sans-serif;color:#5b5b60}}\
p{margin:.5rem 0;max-width:46rem}code{font:.92em ui-monospace,Menlo,Consolas,monospace}nav ol{columns:2;padding-left:1.4rem}nav a{color:inherit}\
dl{display:grid;grid-template-columns:max-content 1fr;gap:.15rem 1.2rem;margin:0 0 1.2rem}dt{color:var(--soft)}dd{margin:0;overflow-wrap:anywhere}\
figure{margin:1.2rem 0;width:calc(1.2*var(--width));max-width:100%}.figures{display:flex;flex-wrap:wrap;column-gap:1.5rem;align-items:flex-start}figcaption,caption{color:var(--soft);font-size:.87rem;text-align:left;max-width:46rem}figcaption{margin-top:.3rem}caption{padding-bottom:.35rem}\
.wide{overflow-x:auto;margin:1.2rem 0;width:max-content;min-width:min(100%,20rem);max-width:calc(100vw - max(1.5rem,(100vw - 64rem)/2) - 1.5rem)}\
caption span{display:inline-block;position:sticky;left:0;max-width:min(46rem,calc(100vw - 3rem))}table{border-collapse:collapse;font-variant-numeric:tabular-nums;font-size:.86rem}\
th,td{padding:.22rem .8rem .22rem 0;text-align:right;vertical-align:top}.words{text-align:left!important}td{white-space:nowrap}.words:not(:first-child){white-space:normal;min-width:11rem}th:first-child,td:first-child{text-align:left}\
th{font-weight:600;border-bottom:1.5px solid var(--ink)}tr+tr td{border-top:1px solid #efeff2}\
svg{width:100%;height:auto}footer{margin-top:3rem;color:var(--soft);font-size:.85rem}\
@media print{html{font-size:11px}body{margin:0;padding:0;max-width:none;font-size:9pt}dl{grid-template-columns:max-content 1fr max-content 1fr}h2{margin-top:1.2rem}\
figure{margin:.6rem 0;width:calc(1.07*var(--width))}figure svg{margin-bottom:-.8rem}.wide{margin:.7rem 0}table,figcaption,caption{font-size:8.5pt}\
.wide{overflow:visible;width:100%;max-width:none;break-inside:avoid}caption span{position:static;max-width:none}\
th,td{white-space:normal!important;padding-right:.5rem;overflow-wrap:break-word}.many{font-size:8pt}.many th,.many td{padding-right:.8rem}\
tr,figure{break-inside:avoid}h2,caption{break-after:avoid}nav{display:none}}";

/// More columns than a sheet of paper has room for at the size of the text.
const MANY: usize = 6;

impl Report {
    /// One HTML file: styles and pictures inside, no scripts, nothing fetched; tables and pictures are numbered.
    pub fn html(&self) -> String {
        let mut out = String::new();
        let title = escaped(&self.title);
        // Writing to a string cannot fail.
        let _ = write!(
            out,
            "<!doctype html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
             <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n<title>{title}</title>\n\
             <style>{STYLE}</style>\n</head>\n<body>\n<h1>{title}</h1>\n<dl>\n"
        );
        for (what, said) in &self.about {
            let _ = writeln!(out, "<dt>{}</dt><dd>{}</dd>", escaped(what), escaped(said));
        }
        out.push_str("</dl>\n");
        if self.sections.len() > 2 {
            out.push_str("<nav><ol>\n");
            for (i, section) in self
                .sections
                .iter()
                .enumerate()
                .filter(|(_, section)| !section.title.is_empty())
            {
                let _ = writeln!(
                    out,
                    "<li><a href=\"#s{i}\">{}</a></li>",
                    escaped(&section.title)
                );
            }
            out.push_str("</ol></nav>\n");
        }
        for (i, section) in self.numbered().sections.iter().enumerate() {
            section.html(i, &mut out);
        }
        out.push_str("</body>\n</html>\n");
        out
    }
}

impl Section {
    fn html(&self, number: usize, out: &mut String) {
        let title = escaped(&self.title);
        let _ = writeln!(out, "<section id=\"s{number}\">");
        if !title.is_empty() {
            let _ = writeln!(out, "<h2>{title}</h2>");
        }
        for paragraph in &self.paragraphs {
            let _ = writeln!(out, "<p>{}</p>", marked_up(paragraph));
        }
        for table in &self.tables {
            table.html(out);
        }
        if !self.figures.is_empty() {
            out.push_str("<div class=\"figures\">\n");
        }
        for (i, figure) in self.figures.iter().enumerate() {
            // Names inside a picture are its own: two pictures of one page must not share them.
            let picture = inlined(figure.picture.svg(), &format!("s{number}f{i}-"));
            let caption = marked_up(&figure.caption);
            let width = figure.picture.width();
            let _ = writeln!(
                out,
                "<figure style=\"--width:{width}px\">\n{picture}\n<figcaption>{caption}</figcaption>\n</figure>"
            );
        }
        if !self.figures.is_empty() {
            out.push_str("</div>\n");
        }
        out.push_str("</section>\n");
    }
}

impl Table {
    fn html(&self, out: &mut String) {
        let _ = writeln!(
            out,
            "<div class=\"wide\"><table{}>\n<caption><span>{}</span></caption>",
            if self.head.len() > MANY {
                " class=\"many\""
            } else {
                ""
            },
            marked_up(&self.caption)
        );
        let lines = self.lines();
        let words = self.columns_of_words();
        let line = |cells: &[String], tag: &str| {
            let cells = cells.iter().zip(&words).map(|(cell, words)| {
                let class = if *words { " class=\"words\"" } else { "" };
                format!("<{tag}{class}>{}</{tag}>", escaped(cell))
            });
            format!("<tr>{}</tr>\n", cells.collect::<String>())
        };
        let _ = write!(out, "<thead>{}</thead>\n<tbody>\n", line(&lines[0], "th"));
        for row in &lines[1..] {
            out.push_str(&line(row, "td"));
        }
        out.push_str("</tbody></table></div>\n");
    }
}

/// A picture's SVG as part of a page: without the line that makes it a file, its names its own.
fn inlined(svg: &str, prefix: &str) -> String {
    let start = svg.find("<svg").unwrap_or(0);
    svg[start..]
        .replace(" id=\"", &format!(" id=\"{prefix}"))
        .replace("url(#", &format!("url(#{prefix}"))
        .replace("href=\"#", &format!("href=\"#{prefix}"))
}

/// Words between back-ticks as code; a back-tick without another stands for itself.
fn marked_up(text: &str) -> String {
    let text = escaped(text);
    let mut parts = text.split('`');
    let mut out = parts.next().unwrap_or_default().to_owned();
    while let Some(code) = parts.next() {
        match parts.next() {
            Some(rest) => {
                out += &format!("<code>{code}</code>{rest}");
            }
            None => {
                out.push('`');
                out += code;
            }
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::super::tests::report;
    use super::*;

    #[test]
    fn a_page_is_whole_and_nothing_in_it_is_markup_by_mistake() {
        let html = report().html();
        assert!(html.contains("<title>A &lt;report&gt;</title>"));
        assert!(html.contains("raw &amp; plain"));
        assert!(!html.contains("<script"), "a script");
        // The names of SVG's parts are addresses that nobody fetches.
        let addresses = html.replace("http://www.w3.org/", "");
        assert!(!addresses.contains("http://") && !addresses.contains("https://"));
        assert!(!addresses.contains("url(//") && !addresses.contains("@import"));
        assert_eq!(html.matches("<svg").count(), 2);
        for caption in [
            "Table 1. Error, g<",
            "Figure 1. what is seen<",
            "Figure 2. what is seen<",
        ] {
            assert_eq!(html.matches(caption).count(), 1, "{caption}");
        }
        assert!(!html.contains("<?xml"));
        assert_eq!(html, report().html());
        // No name twice.
        let mut names: Vec<&str> = html
            .split(" id=\"")
            .skip(1)
            .map(|t| t.split('"').next().unwrap())
            .collect();
        let count = names.len();
        names.sort_unstable();
        names.dedup();
        assert_eq!(names.len(), count);
    }

    #[test]
    fn code_is_set_as_code_and_markup_in_it_is_not() {
        assert_eq!(
            marked_up("`taxel <x>` draws `both`, ` not"),
            "<code>taxel &lt;x&gt;</code> draws <code>both</code>, ` not"
        );
        let mut report = report();
        report.sections[0].tables[0].caption = "By `taxel rig`".to_owned();
        assert!(report.html().contains("Table 1. By <code>taxel rig</code>"));
    }

    #[test]
    fn a_table_of_many_columns_is_set_smaller_on_paper() {
        let mut wide = report();
        wide.sections[0].tables[0].head = (0..10).map(|i| i.to_string()).collect();
        assert!(wide.html().contains("<table class=\"many\">"));
        assert!(!report().html().contains("<table class=\"many\">"));
        let print = STYLE.split("@media print").nth(1).unwrap();
        assert!(print.contains(".wide{overflow:visible"));
    }
}
