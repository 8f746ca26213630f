//! The description of a table's columns, as its end has it.

use super::Column;
use super::thrift::Struct;

/// One line of the schema.
pub(super) struct Element {
    kind: Option<i32>,
    repetition: Option<i32>,
    name: &'static str,
    children: Option<i32>,
    meaning: Meaning,
}

#[derive(Clone, Copy, PartialEq)]
pub(super) enum Meaning {
    Plain,
    List,
    Uint8,
    Uint16,
    Micros,
}

fn element(
    kind: Option<i32>,
    repetition: Option<i32>,
    name: &'static str,
    children: Option<i32>,
    meaning: Meaning,
) -> Element {
    Element {
        kind,
        repetition,
        name,
        children,
        meaning,
    }
}

const REQUIRED: Option<i32> = Some(0);
const REPEATED: Option<i32> = Some(2);

/// The lines of the schema of a table with these columns.
pub(super) fn elements(columns: &[Column]) -> Vec<Element> {
    let children = Some(columns.len() as i32);
    let mut lines = vec![element(None, None, "schema", children, Meaning::Plain)];
    for column in columns {
        let kind = Some(column.kind);
        if column.is_list {
            lines.extend([
                element(None, REQUIRED, column.name, Some(1), Meaning::List),
                element(None, REPEATED, "list", Some(1), Meaning::Plain),
                element(kind, REQUIRED, "element", None, column.meaning),
            ])
        } else {
            lines.push(element(kind, REQUIRED, column.name, None, column.meaning))
        }
    }
    lines
}

impl Element {
    pub(super) fn write(&self, fields: &mut Struct) {
        if let Some(kind) = self.kind {
            fields.i32(1, kind);
        }
        if let Some(repetition) = self.repetition {
            fields.i32(3, repetition);
        }
        fields.text(4, self.name);
        if let Some(children) = self.children {
            fields.i32(5, children);
        }
        // Once as old readers know it, once as new ones do.
        match self.meaning {
            Meaning::Plain => {}
            Meaning::List => {
                fields.i32(6, 3);
                fields.inner(10, |kind| kind.inner(3, |_| ()));
            }
            Meaning::Uint8 => unsigned(fields, 11, 8),
            Meaning::Uint16 => unsigned(fields, 12, 16),
            Meaning::Micros => {
                fields.i32(6, 10);
                fields.inner(10, |kind| {
                    kind.inner(8, |time| {
                        time.boolean(1, true);
                        time.inner(2, |unit| unit.inner(2, |_| ()));
                    });
                });
            }
        }
    }
}

/// A whole number from 0 on of so many bits.
fn unsigned(fields: &mut Struct, old: i32, bits: i8) {
    fields.i32(6, old);
    fields.inner(10, |kind| {
        kind.inner(10, |integer| {
            integer.i8(1, bits);
            integer.boolean(2, false);
        });
    });
}
