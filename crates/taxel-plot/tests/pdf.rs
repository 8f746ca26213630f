//! PDFs, read back: pages of the size of their pictures, text that can be searched, pixels as they were.
#![cfg(feature = "pdf")]

use std::collections::BTreeMap;
use std::io::Read;

use taxel_plot::report::{Figure, Report, Section, Table};
use taxel_plot::{Format, Interpolation, Panel, Picture, cells};

fn panel(interpolation: Interpolation) -> Picture {
    let values: Vec<f64> = (0..48).map(f64::from).collect();
    let panel = Panel::new(6, 8, &values)
        .unwrap()
        .title("one press")
        .unit("S");
    panel.interpolation(interpolation).picture().unwrap()
}

/// The content of every stream, inflated where it is deflated; pixels are left out.
fn streams(pdf: &[u8]) -> Vec<Vec<u8>> {
    let find = |from: usize, what: &[u8]| {
        let at = pdf[from..].windows(what.len()).position(|w| w == what);
        at.map(|at| from + at)
    };
    let (mut out, mut from) = (Vec::new(), 0);
    while let Some(start) = find(from, b">>\nstream\n") {
        let end = find(start, b"\nendstream").unwrap();
        let head = pdf[..start].windows(4).rposition(|w| w == b" obj").unwrap();
        let head = String::from_utf8_lossy(&pdf[head..start]).into_owned();
        let data = &pdf[start + 10..end];
        from = end;
        if head.contains("/Subtype/Image") {
            continue;
        }
        let mut content = Vec::new();
        if head.contains("/FlateDecode") {
            flate2::read::ZlibDecoder::new(data)
                .read_to_end(&mut content)
                .unwrap();
        } else {
            content = data.to_vec();
        }
        out.push(content);
    }
    out
}

fn from_hex(hex: &str) -> Vec<u16> {
    let digits: Vec<u8> = hex.bytes().filter(u8::is_ascii_hexdigit).collect();
    let number = |four: &[u8]| u16::from_str_radix(std::str::from_utf8(four).unwrap(), 16).unwrap();
    digits.chunks_exact(4).map(number).collect()
}

/// What each code of the font stands for.
fn codes(streams: &[Vec<u8>]) -> BTreeMap<u16, String> {
    let mut out = BTreeMap::new();
    for stream in streams {
        let text = String::from_utf8_lossy(stream);
        for part in text.split("beginbfchar").skip(1) {
            let part = part.split("endbfchar").next().unwrap();
            for line in part.lines().filter(|line| line.starts_with('<')) {
                let (code, meaning) = line.split_once('>').unwrap();
                let meaning = String::from_utf16(&from_hex(meaning)).unwrap();
                out.insert(from_hex(code)[0], meaning);
            }
        }
    }
    out
}

/// The bytes of the strings of a page's content, in their order.
fn strings(content: &[u8]) -> Vec<u8> {
    let (mut out, mut i) = (Vec::new(), 0);
    while i < content.len() {
        let (open, next) = (content[i], content.get(i + 1));
        i += 1;
        if open == b'<' && next == Some(&b'<') {
            i += 1;
        } else if open == b'<' {
            let end = i + content[i..].iter().position(|&b| b == b'>').unwrap();
            let hex = String::from_utf8_lossy(&content[i..end]);
            out.extend(from_hex(&hex).into_iter().flat_map(u16::to_be_bytes));
            i = end;
        } else if open == b'(' {
            i += literal(&content[i..], &mut out);
        }
    }
    out
}

/// Appends the bytes of a string after its opening bracket; gives back how many it is written with.
fn literal(content: &[u8], out: &mut Vec<u8>) -> usize {
    let (mut depth, mut i) = (1, 0);
    loop {
        match content[i] {
            b'\\' if content[i + 1].is_ascii_digit() => {
                let octal = std::str::from_utf8(&content[i + 1..i + 4]).unwrap();
                out.push(u8::from_str_radix(octal, 8).unwrap());
                i += 3;
            }
            b'\\' => {
                i += 1;
                out.push(match content[i] {
                    b'n' => b'\n',
                    b'r' => b'\r',
                    b't' => b'\t',
                    b'b' => 8,
                    b'f' => 12,
                    other => other,
                });
            }
            b')' if depth == 1 => return i,
            byte => {
                depth += i32::from(byte == b'(') - i32::from(byte == b')');
                out.push(byte);
            }
        }
        i += 1;
    }
}

/// All text of a PDF.
fn text(pdf: &[u8]) -> String {
    let streams = streams(pdf);
    let codes = codes(&streams);
    let is_page = |content: &&Vec<u8>| content.windows(4).any(|w| w == b"BT 0");
    let bytes: Vec<u8> = streams
        .iter()
        .filter(is_page)
        .flat_map(|c| strings(c))
        .collect();
    let code = |pair: &[u8]| u16::from_be_bytes([pair[0], pair[1]]);
    let meaning = |pair| codes.get(&code(pair)).map_or("", String::as_str);
    bytes.chunks_exact(2).map(meaning).collect()
}

fn count(pdf: &[u8], what: &str) -> usize {
    pdf.windows(what.len())
        .filter(|w| *w == what.as_bytes())
        .count()
}

#[test]
fn a_picture_is_a_page_of_its_size_with_its_text() {
    let picture = panel(Interpolation::Nearest);
    let pdf = picture.render(Format::Pdf).unwrap();
    assert!(pdf.starts_with(b"%PDF-1.7"));
    let size = format!("/MediaBox[0 0 {} {}]", picture.width(), picture.height());
    assert_eq!((count(&pdf, &size), count(&pdf, "/Type/Page/")), (1, 1));
    let text = text(&pdf);
    assert!(
        text.contains("one press") && text.contains("columnrow"),
        "{text}"
    );
    assert_eq!(pdf, picture.render(Format::Pdf).unwrap());
    assert_eq!(count(&pdf, "CreationDate"), 0);
}

/// The font draws an empty box; what it stands for is written beside it.
#[test]
fn a_character_that_the_font_has_not_is_found_as_well() {
    let of = |title: &str| {
        let panel = Panel::new(2, 2, &[1.0, 2.0, 3.0, 4.0])
            .unwrap()
            .title(title);
        streams(&panel.picture().unwrap().render(Format::Pdf).unwrap()).concat()
    };
    assert_eq!(count(&of("a 字 and b"), "/ActualText<FEFF5B57>"), 1);
    assert_eq!(count(&of("a and b"), "/ActualText"), 0);
}

#[test]
fn pixels_are_smoothed_only_where_the_picture_says_so() {
    // The bar of colours is never smoothed.
    let smoothed = |interpolation| {
        let pdf = panel(interpolation).render(Format::Pdf).unwrap();
        (
            count(&pdf, "/Subtype/Image"),
            count(&pdf, "/Interpolate true"),
        )
    };
    assert_eq!(smoothed(Interpolation::Nearest), (2, 0));
    assert_eq!(smoothed(Interpolation::Bilinear(4)), (2, 1));
}

#[test]
fn a_paper_is_one_document_with_all_words_in_order() {
    let mut table = Table::new("Error, g", &["method", "error <g>"]);
    for row in 0..80 {
        table.push(cells![format!("raw & plain {row}"), 25.2]);
    }
    let report = Report {
        title: "A <report> (Ω)".to_owned(),
        about: vec![("sensor".to_owned(), "e-Cone \\ 3".to_owned())],
        sections: vec![
            Section {
                title: "Accuracy".to_owned(),
                paragraphs: vec!["the error of every load".to_owned()],
                tables: vec![table],
                figures: Vec::new(),
            },
            Section {
                title: "Picture".to_owned(),
                figures: vec![Figure {
                    caption: "what is seen".to_owned(),
                    picture: panel(Interpolation::default()),
                }],
                ..Section::default()
            },
        ],
    };
    let paper = report.paper("Laboratory 3").unwrap();
    let pdf = paper.pdf().unwrap();
    assert!(paper.pages().len() > 1);
    assert_eq!(count(&pdf, "/Type/Page/"), paper.pages().len());
    assert_eq!(count(&pdf, "/MediaBox[0 0 595 842]"), paper.pages().len());
    assert_eq!(pdf, report.paper("Laboratory 3").unwrap().pdf().unwrap());
    let (text, mut from) = (text(&pdf), 0);
    for words in [
        "A <report> (Ω)",
        "sensor",
        "e-Cone \\ 3",
        "Accuracy",
        "the error of every load",
        "Error, g",
        "error <g>",
        "raw & plain 0",
        "page 1 of",
        "raw & plain 79",
        "Picture",
        "one press",
        "what is seen",
    ] {
        let found = text[from..].find(words);
        from += found.unwrap_or_else(|| panic!("{words} after {from} in {text}"));
    }
}
