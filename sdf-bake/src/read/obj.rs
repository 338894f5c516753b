//! Wavefront OBJ, parsed by `tobj`.
//!
//! `tobj` gets positions and faces only. Texture and normal indices, which can overflow in it, materials and colours
//! are not needed, and its own options would split vertices at every crease. Line numbers stay those of the file.

use std::fmt::Write;

use glam::DVec3;

use super::{Format, ReadError, Surface, polygon};
use files::input::quoted_line;

/// Number of comment lines that are searched for a unit.
const HEADER_LINES: usize = 50;

/// True if one of the first statements is a vertex.
pub(super) fn looks_like(bytes: &[u8]) -> bool {
    bytes.split(|&byte| byte == b'\n').take(200).any(|line| {
        line.starts_with(b"v ") && line.iter().all(|byte| byte.is_ascii_graphic() || byte.is_ascii_whitespace())
    })
}

pub(super) fn read(bytes: &[u8]) -> Result<Surface, ReadError> {
    let text = String::from_utf8_lossy(bytes);
    let statements = Statements::collect(&text);
    let options = tobj::LoadOptions { ignore_points: true, ignore_lines: true, ..Default::default() };
    let mut rest = statements.text.as_bytes();
    let no_materials = |_: &std::path::Path| Err(tobj::LoadError::OpenFileFailed);
    let loaded = tobj::load_obj_buf(&mut rest, &options, no_materials);
    let (models, _) = loaded.map_err(|error| {
        let consumed = statements.text.len() - rest.len();
        explain(error, &statements.text, consumed)
    })?;
    if models.iter().all(|model| model.mesh.indices.is_empty()) {
        let vertices = vertices(&statements.text);
        return Err(ReadError::NoFaces { format: Format::Obj, vertices, left_out: String::new() });
    }
    let mut surface = Surface { header: statements.header, ..Default::default() };
    for model in models {
        append(&mut surface, &model.mesh)?;
    }
    if let Some(vertex) = surface.mesh.positions.iter().position(|p| !p.is_finite()) {
        let unknown = (format!("vertex {vertex}"), surface.mesh.positions[vertex]);
        let (place, position) = non_finite_line(&statements.text).unwrap_or(unknown);
        return Err(ReadError::NonFinite { place, position });
    }
    if statements.free_form > 0 {
        surface.notes.push(format!("left out {} free-form curve or surface statements", statements.free_form));
    }
    Ok(surface)
}

/// The relevant statements, one line each, with blank lines for the others.
#[derive(Default)]
struct Statements {
    text: String,
    header: String,
    free_form: usize,
}

impl Statements {
    fn collect(text: &str) -> Self {
        let mut statements = Self { text: String::with_capacity(text.len()), ..Default::default() };
        let mut lines = text.lines().enumerate();
        while let Some((number, line)) = lines.next() {
            let mut joined = String::new();
            let mut line = line;
            let mut continued = 0;
            while let Some(head) = line.trim_end().strip_suffix('\\') {
                joined.push_str(head);
                joined.push(' ');
                continued += 1;
                line = lines.next().map_or("", |(_, next)| next);
            }
            if continued == 0 {
                statements.add(line, number);
            } else {
                joined.push_str(line);
                statements.add(&joined, number);
            }
            statements.text.extend(std::iter::repeat_n('\n', continued + 1));
        }
        statements
    }

    fn add(&mut self, line: &str, number: usize) {
        let mut words = line.split_whitespace();
        match words.next() {
            Some("v") => {
                self.text.push('v');
                // Six or more words are a position with a colour.
                let keep = if words.clone().count() == 4 { 4 } else { 3 };
                words.take(keep).for_each(|word| self.push(word));
            }
            Some("f" | "fo") => {
                self.text.push('f');
                words.for_each(|word| self.push(word.split('/').next().unwrap_or("")));
            }
            Some("curv" | "surf" | "curv2") => self.free_form += 1,
            Some(word) if word.starts_with('#') && number < HEADER_LINES => {
                let _ = writeln!(self.header, "{line}");
            }
            _ => {}
        }
    }

    fn push(&mut self, word: &str) {
        self.text.push(' ');
        self.text.push_str(word);
    }
}

fn append(surface: &mut Surface, model: &tobj::Mesh) -> Result<(), ReadError> {
    let mesh = &mut surface.mesh;
    let offset = mesh.positions.len() as u32;
    mesh.positions.extend(model.positions.chunks_exact(3).map(|p| DVec3::new(p[0], p[1], p[2])));
    if model.face_arities.is_empty() {
        mesh.triangles.extend(model.indices.chunks_exact(3).map(|t| [t[0], t[1], t[2]].map(|v| v + offset)));
        return Ok(());
    }
    let mut rest = model.indices.as_slice();
    for &arity in &model.face_arities {
        let (face, after) = rest.split_at(arity as usize);
        rest = after;
        polygon::append_face(surface, Format::Obj, face.iter().map(|&v| v + offset))?;
    }
    Ok(())
}

/// Returns the first line whose coordinates are not all finite.
fn non_finite_line(text: &str) -> Option<(String, DVec3)> {
    text.lines().enumerate().find_map(|(number, line)| {
        let mut words = line.strip_prefix("v ")?.split_whitespace();
        let mut coordinate = || words.next()?.parse::<f64>().ok();
        let position = DVec3::new(coordinate()?, coordinate()?, coordinate()?);
        (!position.is_finite()).then(|| (format!("the vertex on line {}", number + 1), position))
    })
}

fn vertices(text: &str) -> usize {
    text.lines().filter(|line| line.starts_with("v ")).count()
}

/// Describes the first face that refers to a missing vertex, with the accepted indices.
fn face_out_of_bounds(text: &str) -> Option<String> {
    let all = vertices(text);
    let mut before = 0;
    for (number, line) in text.lines().enumerate() {
        before += usize::from(line.starts_with("v "));
        let Some(face) = line.strip_prefix("f ") else { continue };
        let exists = |index: i64| match index {
            ..=-1 => index.unsigned_abs() <= before as u64,
            _ => (1..=all as u64).contains(&index.unsigned_abs()),
        };
        let Some(bad) = face.split(' ').find(|word| !word.parse().is_ok_and(exists)) else { continue };
        let (line, bad) = (number + 1, quoted_line(bad));
        return Some(match (all, before) {
            (0, _) => format!("line {line}: a face names vertex {bad}, and the file has no vertices"),
            (_, 0) => format!("line {line}: a face names vertex {bad}; 1 to {all} are accepted"),
            _ => format!(
                "line {line}: a face names vertex {bad}; 1 to {all} are accepted, or counted back from here -1 to -{before}"
            ),
        });
    }
    None
}

fn explain(error: tobj::LoadError, text: &str, consumed: usize) -> ReadError {
    use tobj::LoadError::{FaceParseError, FaceVertexOutOfBounds, PositionParseError, ScalingByZeroError};
    let consumed = &text[..consumed];
    let line = consumed.lines().count();
    let statement = consumed.lines().last().unwrap_or("");
    let statement = quoted_line(statement);
    let reason = match error {
        PositionParseError => format!("line {line}: {statement} is not a vertex; `v x y z` with numbers is accepted"),
        FaceParseError => {
            format!("line {line}: {statement} is not a face; `f i j k ...` with vertex numbers is accepted")
        }
        ScalingByZeroError => format!("line {line}: {statement} has weight 0"),
        // The parser reports this error without a line number; the text is searched for the line.
        FaceVertexOutOfBounds => face_out_of_bounds(text).unwrap_or_else(|| error.to_string()),
        other => other.to_string(),
    };
    ReadError::malformed(Format::Obj, reason)
}
