//! Whatever a report holds: all of it is on the sheets, within the margins, and nothing on anything else.

use std::collections::BTreeMap;

use resvg::tiny_skia::Rect as Area;
use resvg::usvg::{Group, Node};

use super::super::{Cell, Figure, Report, Section, Table};
use super::*;
use crate::glyphs::{Line, outlined, tree_of};
use crate::{Panel, cells};

/// A text of a page: what it says, its ink, and its type size as it is seen, in points.
#[derive(Debug, Clone)]
struct Seen {
    text: String,
    ink: Area,
    size: f64,
}

/// Texts, and the ink of everything, the white ground of the page aside.
fn seen(page: &Picture) -> (Vec<Seen>, Vec<Area>) {
    fn walk(group: &Group, lines: &[Line], texts: &mut Vec<Seen>, ink: &mut Vec<Area>) {
        for node in group.children() {
            if let Node::Group(group) = node {
                walk(group, lines, texts, ink);
                continue;
            }
            ink.push(node.abs_bounding_box());
            let number = node.id().strip_prefix("taxel-text-");
            if let Some(line) = number.and_then(|number| lines.get(number.parse::<usize>().ok()?)) {
                texts.push(Seen {
                    text: line.text.clone(),
                    ink: node.abs_bounding_box(),
                    size: line.size * f64::from(node.abs_transform().get_scale().1),
                });
            }
        }
    }
    let (outlines, lines) = outlined(page.svg());
    let (mut texts, mut ink) = (Vec::new(), Vec::new());
    walk(
        tree_of(&outlines).unwrap().root(),
        &lines,
        &mut texts,
        &mut ink,
    );
    ink.remove(0);
    (texts, ink)
}

fn is_footer(seen: &Seen) -> bool {
    f64::from(seen.ink.top()) > SHEET.1 - TOP - words::leading(FOOTER)
}

/// What the pages say, footers aside, text by text.
fn said(paper: &Paper) -> Vec<Seen> {
    let texts = paper.pages().iter().flat_map(|page| seen(page).0);
    texts.filter(|seen| !is_footer(seen)).collect()
}

fn letters(text: &str) -> String {
    text.chars().filter(|c| !c.is_whitespace()).collect()
}

fn counted<'a>(texts: impl Iterator<Item = &'a str>) -> BTreeMap<char, usize> {
    let mut counts = BTreeMap::new();
    for character in texts.flat_map(|text| text.chars().filter(|c| !c.is_whitespace())) {
        *counts.entry(character).or_default() += 1;
    }
    counts
}

/// All words of a report, pictures aside, as they are to be shown.
fn words_of(report: &Report) -> Vec<String> {
    let mut out = vec![report.title.clone()];
    out.extend(
        report
            .about
            .iter()
            .flat_map(|(key, said)| [key.clone(), said.clone()]),
    );
    for section in &report.sections {
        out.push(section.title.clone());
        out.extend(section.paragraphs.iter().map(|text| without_ticks(text)));
        for table in &section.tables {
            out.push(without_ticks(&table.caption));
            out.extend(table.lines().concat());
        }
        let captions = section.figures.iter().map(|figure| &figure.caption);
        out.extend(captions.map(|text| without_ticks(text)));
    }
    out
}

/// All is there as often as in the report or more often, within the margins; outside of pictures nothing is small or drawn
/// over.
fn check(report: &Report) -> Paper {
    let paper = report.paper("Laboratory 3, signed: ________").unwrap();
    let all = said(&paper);
    let found = counted(all.iter().map(|seen| seen.text.as_str()));
    let words = words_of(report);
    for (character, count) in counted(words.iter().map(String::as_str)) {
        assert!(
            found.get(&character) >= Some(&count),
            "{character}: {count}, {found:?}"
        );
    }
    let has_pictures = report.sections.iter().any(|s| !s.figures.is_empty());
    for (number, page) in paper.pages().iter().enumerate() {
        assert_eq!((page.width(), page.height()), (595, 842));
        let (texts, ink) = seen(page);
        for area in &ink {
            let inside = f64::from(area.left()) >= SIDE - 0.3
                && f64::from(area.right()) <= SHEET.0 - SIDE + 0.3
                && f64::from(area.top()) >= TOP - 0.1
                && f64::from(area.bottom()) <= SHEET.1 - TOP + 0.1;
            assert!(inside, "page {number}: {area:?}");
        }
        let number = page_number(number + 1, paper.pages().len());
        assert!(texts.iter().any(|seen| seen.text == number), "{number}");
        if !has_pictures {
            assert!(texts.iter().all(|seen| seen.size > 7.99), "{number}");
            assert_apart(&texts);
        }
    }
    paper
}

/// No two texts share ink.
fn assert_apart(texts: &[Seen]) {
    for (i, a) in texts.iter().enumerate() {
        for b in &texts[i + 1..] {
            let across = a.ink.right().min(b.ink.right()) - a.ink.left().max(b.ink.left());
            let down = a.ink.bottom().min(b.ink.bottom()) - a.ink.top().max(b.ink.top());
            assert!(across < 0.05 || down < 0.05, "{a:?} on {b:?}");
        }
    }
}

fn of_one_section(section: Section) -> Report {
    Report {
        title: "Acceptance of a mat".to_owned(),
        about: vec![("sensor".to_owned(), "e-Cone 3".to_owned())],
        sections: vec![section],
    }
}

fn figure(rows: usize, columns: usize, caption: &str) -> Figure {
    let values: Vec<f64> = (0..rows * columns).map(|i| (i % 17) as f64).collect();
    let panel = Panel::new(rows, columns, &values).unwrap().title("a press");
    Figure {
        caption: caption.to_owned(),
        picture: panel.picture().unwrap(),
    }
}

fn section(title: &str) -> Section {
    Section {
        title: title.to_owned(),
        ..Section::default()
    }
}

const SENTENCE: &str =
    "The error of a load is the mean over `ten` presses, each in newtons, Ω → µS — ‰ and 字.";

#[test]
fn what_is_long_is_wrapped() {
    let endless = "W".repeat(400);
    let mut report = of_one_section(Section {
        paragraphs: vec![endless.clone(), SENTENCE.repeat(40), "— ‰".repeat(300)],
        ..section(&format!("A section of {endless}"))
    });
    report.title = SENTENCE.repeat(5);
    let pair = |i: usize| {
        (
            format!("key {i}"),
            format!("{SENTENCE} {}", &endless[..40 * i]),
        )
    };
    report.about = (0..7).map(pair).collect();
    let paper = check(&report);
    // Lines of a text follow each other.
    let all: String = said(&paper)
        .iter()
        .map(|seen| letters(&seen.text))
        .collect();
    for text in [&report.title, &report.sections[0].title] {
        assert!(all.contains(&letters(&without_ticks(text))));
    }
    for text in &report.sections[0].paragraphs {
        assert!(all.contains(&letters(&without_ticks(text))));
    }
    // Nothing is shown twice.
    let words = words_of(&report);
    let expected = counted(words.iter().map(String::as_str));
    let texts = said(&paper);
    assert_eq!(
        counted(texts.iter().map(|seen| seen.text.as_str())),
        expected
    );
}

#[test]
fn tables_of_every_shape_fit() {
    let words = |count: usize| SENTENCE.chars().cycle().take(count).collect::<String>();
    for columns in [1, 2, 6, 12, 40] {
        for longest in [3, 60, 99] {
            let head: Vec<String> = (0..columns).map(|i| format!("column {i} of all")).collect();
            let head: Vec<&str> = head.iter().map(String::as_str).collect();
            let mut table = Table::new(SENTENCE, &head);
            for row in 0..9 {
                let cell = |column: usize| match (row + column) % 3 {
                    0 => Cell::Words(words(longest * (column % 2) + 2)),
                    1 => Cell::Words("x".repeat(longest)),
                    _ => Cell::Number(row as f64 * 1.2345),
                };
                table.push((0..columns).map(cell).collect());
            }
            check(&of_one_section(Section {
                tables: vec![table],
                ..section("Numbers")
            }));
        }
    }
}

#[test]
fn a_long_table_is_broken_between_rows_and_repeats_its_head() {
    let mut table = Table::new("Loads", &["taxel", "error, g", "remark"]);
    for row in 0..200_usize {
        table.push(cells![format!("taxel-{row}"), row, format!("remark-{row}")]);
    }
    let paper = check(&of_one_section(Section {
        tables: vec![table],
        ..section("Numbers")
    }));
    assert!(paper.pages().len() > 2);
    let mut rows = 0;
    for page in paper.pages() {
        let (texts, _) = seen(page);
        let at = |text: &str| texts.iter().find(|seen| seen.text == text);
        assert!(at("error, g").is_some());
        let head = at("taxel").unwrap().ink.bottom();
        for row in 0..200 {
            let Some(first) = at(&format!("taxel-{row}")) else {
                continue;
            };
            let last = at(&format!("remark-{row}")).expect("the whole row on one page");
            assert!((first.ink.bottom() - last.ink.bottom()).abs() < 3.0 && first.ink.top() > head);
            rows += 1;
        }
    }
    assert_eq!(rows, 200);
}

#[test]
fn columns_of_numbers_end_together_and_columns_of_words_begin_together() {
    let mut table = Table::new("", &["who", "error, g", "remark"]);
    table.push(cells!["a", 0.5, "good"]);
    table.push(cells!["bb", 1234.5, "better"]);
    let paper = check(&of_one_section(Section {
        tables: vec![table],
        ..section("Numbers")
    }));
    let all = said(&paper);
    let ink = |text: &str| all.iter().find(|seen| seen.text == text).unwrap().ink;
    // Ink is not the advance of a glyph: a point to each side.
    assert!(
        (ink("0.5").right() - ink("1235").right()).abs() < 1.0,
        "{all:?}"
    );
    assert!((ink("good").left() - ink("better").left()).abs() < 1.0);
    assert!((ink("0.5").left() - ink("1235").left()).abs() > 1.0);
}

#[test]
fn no_heading_stands_alone() {
    for lines in 20..45 {
        let mut table = Table::new("Loads", &["who", "error"]);
        table.push(cells!["exact", 0.07]);
        let mut report = of_one_section(Section {
            paragraphs: vec!["word ".to_owned(); lines],
            ..section("First")
        });
        report.sections.push(Section {
            tables: vec![table],
            ..section("Second")
        });
        report.sections.push(Section {
            figures: vec![figure(4, 4, "shown")],
            ..section("Third")
        });
        let paper = report.paper("").unwrap();
        let place = |text: &str| {
            let on = |page: &Picture| seen(page).0.iter().any(|seen| seen.text == text);
            paper.pages().iter().position(on).unwrap()
        };
        assert_eq!(place("Second"), place("exact"), "{lines}");
        assert_eq!(place("Third"), place("a press"), "{lines}");
        assert_eq!(place("a press"), place("Figure 1. shown"), "{lines}");
        let listed: Vec<usize> = paper.headings.iter().map(|heading| heading.page).collect();
        assert_eq!(listed, ["First", "Second", "Third"].map(place));
    }
}

#[test]
fn pictures_are_whole_and_legible_and_share_rows() {
    let long = SENTENCE.repeat(6);
    let shapes = [
        (4, 4),
        (4, 4),
        (2, 300),
        (300, 2),
        (64, 64),
        (8, 8),
        (8, 8),
        (8, 8),
        (8, 8),
    ];
    let figures = shapes.map(|(rows, columns)| figure(rows, columns, &long));
    let report = of_one_section(Section {
        figures: figures.to_vec(),
        ..section("Pictures")
    });
    let paper = check(&report);
    let titles: Vec<Seen> = said(&paper)
        .into_iter()
        .filter(|s| s.text == "a press")
        .collect();
    assert_eq!(titles.len(), shapes.len());
    let beside = titles
        .windows(2)
        .filter(|pair| pair[0].ink.top() == pair[1].ink.top());
    assert!(beside.count() > 2);
    for (i, figure) in figures.iter().enumerate() {
        let alone = figures::scale(&figures[i..=i], (SHEET.0 - 2.0 * SIDE, 600.0));
        let smallest = figures::smallest_text(figure);
        assert!(
            titles[i].size / 12.0 * smallest > 5.99_f64.min(alone * smallest),
            "{i}"
        );
    }
}

#[test]
fn what_is_empty_takes_no_room() {
    let paper = check(&Report::default());
    assert_eq!(paper.pages().len(), 1);
    let mut report = of_one_section(section("Nothing to say"));
    report.sections.push(Section::default());
    report.sections.push(Section {
        tables: vec![Table::default(), Table::new("no rows", &["a", "b"])],
        paragraphs: vec![String::new()],
        ..section("Little")
    });
    assert_eq!(check(&report).pages().len(), 1);
}

#[test]
fn a_footer_is_cut_before_it_takes_the_page() {
    let paper = Report::default()
        .paper(&"a long address ".repeat(200))
        .unwrap();
    let (texts, ink) = seen(&paper.pages()[0]);
    assert_eq!(texts.len(), 4);
    assert!(texts[2].text.ends_with('…'));
    assert!(
        ink.iter()
            .all(|area| f64::from(area.right()) <= SHEET.0 - SIDE + 0.3)
    );
    assert_apart(&texts);
}

#[test]
fn a_report_of_too_many_pages_is_refused() {
    let mut table = Table::new("", &["n"]);
    for row in 0..50_000_usize {
        table.push(cells![row]);
    }
    let report = of_one_section(Section {
        tables: vec![table],
        ..section("Numbers")
    });
    assert_eq!(
        report.paper(""),
        Err(Error::TooManyPages { limit: MAX_PAGES })
    );
}

#[test]
fn back_ticks_about_code_are_dropped_and_others_stay() {
    assert_eq!(
        without_ticks("by `taxel rig`, ` not"),
        "by taxel rig, ` not"
    );
    assert_eq!(without_ticks("plain"), "plain");
}
