//! Protocol buffers, as far as ONNX needs them here.

/// One field of a message.
pub(super) enum Field<'a> {
    /// Number of the field, value.
    Number(u64, u64),
    /// Number of the field, its bytes.
    Bytes(u64, &'a [u8]),
    /// Number of the field, four bytes.
    Four(u64, [u8; 4]),
}

/// The fields of a message, in order, read as they are asked for: a list of all would take many times the message's
/// size.
pub(super) fn fields(mut bytes: &[u8]) -> impl Iterator<Item = Result<Field<'_>, String>> {
    std::iter::from_fn(move || {
        while !bytes.is_empty() {
            match field(&mut bytes) {
                Ok(None) => {}
                Ok(Some(field)) => return Some(Ok(field)),
                Err(why) => {
                    bytes = &[];
                    return Some(Err(why));
                }
            }
        }
        None
    })
}

/// The next field; none where it is of a kind that ONNX does not need here.
fn field<'a>(bytes: &mut &'a [u8]) -> Result<Option<Field<'a>>, String> {
    let key = varint(bytes)?;
    let (number, kind) = (key >> 3, key & 7);
    Ok(Some(match kind {
        0 => Field::Number(number, varint(bytes)?),
        1 => {
            take(bytes, 8)?;
            return Ok(None);
        }
        2 => {
            let length = varint(bytes)?;
            let length = usize::try_from(length).map_err(|_| cut())?;
            Field::Bytes(number, take(bytes, length)?)
        }
        5 => {
            let four = take(bytes, 4)?;
            Field::Four(number, [four[0], four[1], four[2], four[3]])
        }
        other => return Err(format!("not ONNX: a field of kind {other}")),
    }))
}

/// Numbers one after the other.
pub(super) fn packed(mut bytes: &[u8]) -> Result<Vec<u64>, String> {
    let mut numbers = Vec::new();
    while !bytes.is_empty() {
        numbers.push(varint(&mut bytes)?);
    }
    Ok(numbers)
}

fn cut() -> String {
    "not ONNX, or cut short".to_owned()
}

fn take<'a>(bytes: &mut &'a [u8], count: usize) -> Result<&'a [u8], String> {
    let (head, rest) = bytes.split_at_checked(count).ok_or_else(cut)?;
    *bytes = rest;
    Ok(head)
}

fn varint(bytes: &mut &[u8]) -> Result<u64, String> {
    let mut value = 0u64;
    for shift in (0..70).step_by(7) {
        let (&first, rest) = bytes.split_first().ok_or_else(cut)?;
        *bytes = rest;
        if shift < 64 {
            value |= u64::from(first & 0x7f) << shift;
        }
        if first < 0x80 {
            return Ok(value);
        }
    }
    Err(cut())
}

/// An attribute of an operator.
#[derive(Default)]
pub(super) struct Attribute<'a> {
    pub(super) name: String,
    pub(super) float: f32,
    pub(super) number: u64,
    pub(super) tensor: Option<&'a [u8]>,
    pub(super) floats: Vec<f32>,
}

pub(super) fn attribute(bytes: &[u8]) -> Result<Attribute<'_>, String> {
    let mut found = Attribute::default();
    for field in fields(bytes) {
        match field? {
            Field::Bytes(1, name) => found.name = String::from_utf8_lossy(name).into_owned(),
            Field::Four(2, float) => found.float = f32::from_le_bytes(float),
            Field::Number(3, number) => found.number = number,
            Field::Bytes(5, tensor) => found.tensor = Some(tensor),
            Field::Four(7, float) => found.floats.push(f32::from_le_bytes(float)),
            Field::Bytes(7, packed) => found.floats.extend(
                packed
                    .chunks_exact(4)
                    .map(|b| f32::from_le_bytes([b[0], b[1], b[2], b[3]])),
            ),
            _ => {}
        }
    }
    Ok(found)
}

/// Builds a message.
#[derive(Default)]
pub(super) struct Writer {
    bytes: Vec<u8>,
}

impl Writer {
    pub(super) fn into_bytes(self) -> Vec<u8> {
        self.bytes
    }

    fn varint(&mut self, mut value: u64) {
        while value >= 0x80 {
            self.bytes.push((value & 0x7f) as u8 | 0x80);
            value >>= 7;
        }
        self.bytes.push(value as u8);
    }

    pub(super) fn number(&mut self, field: u64, value: u64) {
        self.varint(field << 3);
        self.varint(value);
    }

    pub(super) fn bytes(&mut self, field: u64, bytes: &[u8]) {
        self.varint(field << 3 | 2);
        self.varint(bytes.len() as u64);
        self.bytes.extend_from_slice(bytes);
    }

    pub(super) fn text(&mut self, field: u64, text: &str) {
        self.bytes(field, text.as_bytes());
    }

    pub(super) fn message(&mut self, field: u64, message: &Writer) {
        self.bytes(field, &message.bytes);
    }

    /// Adds an operator to a graph.
    pub(super) fn node(&mut self, operator: &str, inputs: &[&str], output: &str) {
        let mut node = Writer::default();
        for input in inputs {
            node.text(1, input);
        }
        node.text(2, output);
        node.text(3, output);
        node.text(4, operator);
        self.message(1, &node);
    }
}

/// A tensor of 4-byte numbers.
pub(super) fn tensor(name: &str, shape: &[usize], values: &[f32]) -> Writer {
    let mut tensor = Writer::default();
    for &size in shape {
        tensor.number(1, size as u64);
    }
    tensor.number(2, super::FLOAT);
    tensor.text(8, name);
    let raw: Vec<u8> = values.iter().flat_map(|v| v.to_le_bytes()).collect();
    tensor.bytes(9, &raw);
    tensor
}

/// An input or output of any number of rows of `width` 4-byte numbers.
pub(super) fn value_info(name: &str, width: usize) -> Writer {
    let (mut any, mut fixed) = (Writer::default(), Writer::default());
    any.text(2, "n");
    fixed.number(1, width as u64);
    let mut shape = Writer::default();
    shape.message(1, &any);
    shape.message(1, &fixed);
    let mut of = Writer::default();
    of.number(1, super::FLOAT);
    of.message(2, &shape);
    let mut kind = Writer::default();
    kind.message(1, &of);
    let mut info = Writer::default();
    info.text(1, name);
    info.message(2, &kind);
    info
}
