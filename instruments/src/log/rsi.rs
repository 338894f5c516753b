//! Streams of KUKA's Robot Sensor Interface: one XML element `<Rob>` per cycle, concatenated, as programs store the
//! controller's messages. Source: KUKA, "KUKA.RobotSensorInterface", section on the Ethernet object and its XML
//! strings.

use std::collections::HashMap;
use std::path::Path;

use roxmltree::Document;

use super::text::decode;
use super::{Channels, Format, check_size};
use crate::misread::{Misread, Place};

const OPEN: &str = "<Rob";
const CLOSE: &str = "</Rob>";
/// Number of bytes in which the first frame is searched for.
const HEAD: usize = 1 << 16;
/// Maximum number of bytes of a frame; a datagram has fewer.
const LONGEST_FRAME: usize = 1 << 16;

/// A stream of the Robot Sensor Interface.
pub(super) struct Rsi;

/// Values by name while frames are read.
#[derive(Default)]
struct Frames {
    index: HashMap<String, usize>,
    names: Vec<String>,
    values: Vec<Vec<f64>>,
    lines: Vec<u64>,
}

impl Format for Rsi {
    fn name(&self) -> &'static str {
        "stream of KUKA RSI"
    }

    fn recognises(&self, bytes: &[u8]) -> bool {
        let head = String::from_utf8_lossy(&bytes[..bytes.len().min(HEAD)]);
        head.contains(OPEN) && (head.contains("<RIst") || head.contains("<IPOC"))
    }

    fn read(&self, file: &Path, bytes: &[u8]) -> Result<Channels, Misread> {
        let (text, mut notes) = decode(file, bytes)?;
        let mut frames = Frames::default();
        let (mut rest, mut line) = (&*text, 1);
        while let Some(start) = rest.find(OPEN) {
            line += newlines(&rest[..start]);
            rest = &rest[start..];
            let Some(end) = rest.find(CLOSE).map(|end| end + CLOSE.len()) else {
                notes.push(format!("the frame in line {line} is cut short and left out"));
                break;
            };
            frames.push(&rest[..end], Place::line(file, line))?;
            line += newlines(&rest[..end]);
            rest = &rest[end..];
        }
        if frames.lines.is_empty() {
            return Err(Place::file(file).bad("no frame <Rob>…</Rob>", "a stream of KUKA RSI is expected"));
        }
        notes.push("IPOC counts milliseconds; positions are millimetres and angles degrees".to_owned());
        let mut channels = Channels { format: self.name(), notes, lines: frames.lines, ..Channels::default() };
        let rows = channels.lines.len();
        for (name, mut values) in frames.names.iter().zip(frames.values) {
            values.resize(rows, f64::NAN);
            channels.push(name, unit(name).map(str::to_owned), values);
        }
        Ok(channels)
    }
}

fn newlines(text: &str) -> u64 {
    text.bytes().filter(|&byte| byte == b'\n').count() as u64
}

/// Units of the values that the controller itself sends.
fn unit(name: &str) -> Option<&'static str> {
    let (element, component) = name.split_once('.').unwrap_or((name, ""));
    match (element, component) {
        ("RIst" | "RSol", "X" | "Y" | "Z") => Some("mm"),
        ("RIst" | "RSol", _) | ("AIPos" | "ASPos", _) => Some("deg"),
        ("IPOC", _) => Some("ms"),
        _ => None,
    }
}

impl Frames {
    fn push(&mut self, frame: &str, place: Place) -> Result<(), Misread> {
        const ACCEPTED: &str = "a frame <Rob>…</Rob> of KUKA RSI is expected";
        if frame.len() > LONGEST_FRAME {
            return Err(place.bad(format!("a frame of {} bytes", frame.len()), ACCEPTED));
        }
        let document = Document::parse(frame);
        let document = document.map_err(|_| place.clone().bad::<Misread>("a frame that is not XML", ACCEPTED))?;
        check_size(place.clone(), self.names.len(), self.lines.len() + 1)?;
        for element in document.root_element().children().filter(|node| node.is_element()) {
            let name = element.tag_name().name();
            let attributes = element.attributes().map(|given| (format!("{name}.{}", given.name()), given.value()));
            let text = element.text().map(|text| (name.to_owned(), text));
            for (name, value) in attributes.chain(text) {
                if let Ok(value) = value.trim().parse::<f64>() {
                    self.value(name, value, &place)?;
                }
            }
        }
        self.lines.push(place.line.unwrap_or_default());
        Ok(())
    }

    fn value(&mut self, name: String, value: f64, place: &Place) -> Result<(), Misread> {
        let row = self.lines.len();
        let next = self.names.len();
        let column = *self.index.entry(name).or_insert_with_key(|name| {
            self.names.push(name.clone());
            self.values.push(Vec::new());
            next
        });
        check_size(place.clone(), self.names.len(), row + 1)?;
        let values = &mut self.values[column];
        // If a value occurs twice in a frame, the first one is used.
        if values.len() <= row {
            values.resize(row, f64::NAN);
            values.push(if value.is_finite() { value } else { f64::NAN });
        }
        Ok(())
    }
}
