//! Thrift's compact protocol, as far as Parquet's footer needs it: writing structs, lists, numbers, words.

/// Types of fields and list elements.
#[derive(Clone, Copy)]
#[repr(u8)]
pub(super) enum Kind {
    True = 1,
    False = 2,
    I8 = 3,
    I32 = 5,
    I64 = 6,
    Binary = 8,
    List = 9,
    Struct = 12,
}

/// A struct being written.
pub(super) struct Struct<'a> {
    out: &'a mut Vec<u8>,
    last: u8,
}

impl<'a> Struct<'a> {
    /// Begins a struct that stands alone or in a list.
    pub fn begin(out: &'a mut Vec<u8>) -> Self {
        Self { out, last: 0 }
    }

    fn field(&mut self, id: u8, kind: Kind) {
        // Identifiers rise, by less than 16.
        self.out.push((id - self.last) << 4 | kind as u8);
        self.last = id;
    }

    pub fn i8(&mut self, id: u8, value: i8) {
        self.field(id, Kind::I8);
        self.out.push(value as u8);
    }

    pub fn i32(&mut self, id: u8, value: i32) {
        self.field(id, Kind::I32);
        varint(self.out, zigzag(i64::from(value)));
    }

    pub fn i64(&mut self, id: u8, value: i64) {
        self.field(id, Kind::I64);
        varint(self.out, zigzag(value));
    }

    pub fn boolean(&mut self, id: u8, value: bool) {
        self.field(id, if value { Kind::True } else { Kind::False });
    }

    pub fn text(&mut self, id: u8, value: &str) {
        self.field(id, Kind::Binary);
        text(self.out, value);
    }

    /// A struct inside.
    pub fn inner(&mut self, id: u8, write: impl FnOnce(&mut Struct)) {
        self.field(id, Kind::Struct);
        let mut inner = Struct::begin(self.out);
        write(&mut inner);
        inner.end();
    }

    /// A list of structs.
    pub fn structs<T>(&mut self, id: u8, items: &[T], write: impl Fn(&T, &mut Struct)) {
        self.list(id, Kind::Struct, items.len());
        for item in items {
            let mut inner = Struct::begin(self.out);
            write(item, &mut inner);
            inner.end();
        }
    }

    pub fn i32s(&mut self, id: u8, items: &[i32]) {
        self.list(id, Kind::I32, items.len());
        for item in items {
            varint(self.out, zigzag(i64::from(*item)));
        }
    }

    pub fn texts(&mut self, id: u8, items: &[impl AsRef<str>]) {
        self.list(id, Kind::Binary, items.len());
        for item in items {
            text(self.out, item.as_ref());
        }
    }

    fn list(&mut self, id: u8, kind: Kind, length: usize) {
        self.field(id, Kind::List);
        match u8::try_from(length) {
            Ok(short) if short < 15 => self.out.push(short << 4 | kind as u8),
            _ => {
                self.out.push(0xf0 | kind as u8);
                varint(self.out, length as u64);
            }
        }
    }

    pub fn end(self) {
        self.out.push(0);
    }
}

fn text(out: &mut Vec<u8>, value: &str) {
    varint(out, value.len() as u64);
    out.extend(value.as_bytes());
}

/// Seven bits a byte, low ones first.
pub(super) fn varint(out: &mut Vec<u8>, mut value: u64) {
    while value >= 0x80 {
        out.push(value as u8 | 0x80);
        value >>= 7;
    }
    out.push(value as u8);
}

fn zigzag(value: i64) -> u64 {
    ((value << 1) ^ (value >> 63)) as u64
}
