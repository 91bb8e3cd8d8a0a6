//! The outer surface of a frame with a field on it, packed for the page.

use super::stamp::Stamp;
use crate::plot::surface::{GHOSTS, PART, Part, Skin, Surface};
use estar_deck::fields;
use estar_deck::memory;
use estar_io::{FrameContent, FrameLimits, read_frame_with};
use serde_json::json;
use std::collections::VecDeque;
use std::hash::{DefaultHasher, Hash, Hasher};
use std::path::Path;
use std::sync::Arc;

/// A page has one field at a time; so many are kept for those who go to and fro.
const MOST_KEPT: usize = 4;
/// A frame whose file is larger takes more memory than a look at it is worth beside a run.
const LARGEST_FILE: u64 = 1 << 30;
/// Fields that are shown unless another is chosen: the first that a frame has. All have the last.
const CHOICES: [&str; 5] = ["equivalent_plastic_strain", "von_mises_stress", "displacement", "velocity", "part"];

/// Surfaces that have been asked for.
#[derive(Debug, Default)]
pub struct Bodies {
    /// The outer faces, with a mark of the cells that they are of.
    skin: Option<(u64, Skin)>,
    kept: VecDeque<(Key, Arc<[u8]>)>,
}

/// What is asked for.
#[derive(Clone, Debug, PartialEq, Eq)]
struct Key {
    number: usize,
    stamp: Stamp,
    field: Option<String>,
    component: Option<String>,
}

impl Bodies {
    /// The surface of a frame in a file.
    ///
    /// # Errors
    /// The file cannot be read, or has no such field.
    pub fn surface(
        &mut self,
        number: usize,
        path: &Path,
        field: Option<&str>,
        component: Option<&str>,
    ) -> Result<Arc<[u8]>, String> {
        let stamp = Stamp::of(path).map_err(|error| format!("{}: {error}", path.display()))?;
        let key = Key { number, stamp, field: field.map(str::to_owned), component: component.map(str::to_owned) };
        if let Some((_, content)) = self.kept.iter().find(|(known, _)| *known == key) {
            return Ok(Arc::clone(content));
        }
        if stamp.length() > LARGEST_FILE {
            return Err(format!(
                "the frames are too large for this page ({} MB): ParaView shows them",
                stamp.length() >> 20
            ));
        }
        // values are worked out within a part
        let is_needed = |name: &str| [GHOSTS, PART].contains(&name);
        let is_wanted =
            |name: &str| is_needed(name) || field.map_or_else(|| CHOICES.contains(&name), |field| field == name);
        let limits = FrameLimits { file: LARGEST_FILE, numbers: memory::available().unwrap_or(u64::MAX) };
        let frame = read_frame_with(path, limits, is_wanted).map_err(|error| error.to_string())?;
        let content: Arc<[u8]> = self.packed(number, &frame, field, component)?.into();
        self.kept.push_front((key, Arc::clone(&content)));
        self.kept.truncate(MOST_KEPT);
        Ok(content)
    }

    fn packed(
        &mut self,
        number: usize,
        frame: &FrameContent,
        field: Option<&str>,
        component: Option<&str>,
    ) -> Result<Vec<u8>, String> {
        let fields = || frame.cell_fields.iter().chain(&frame.node_fields).filter(|(name, _)| *name != GHOSTS);
        let chosen = match field {
            Some(field) => fields().find(|(name, _)| *name == field),
            None => CHOICES.iter().find_map(|choice| fields().find(|(name, _)| name == choice)),
        };
        let (name, content) = chosen.ok_or_else(|| "the frames have no such field".to_owned())?;
        let names = Part::names(content.components);
        let part = match component.map(|component| names.iter().position(|known| *known == component)) {
            None => Part::Magnitude,
            Some(Some(index)) => Part::Component(index),
            Some(None) => return Err("the field has no such component".to_owned()),
        };
        let mark = mark(frame);
        if self.skin.as_ref().is_none_or(|(of, _)| *of != mark) {
            self.skin = Some((mark, Skin::of(frame)));
        }
        let Some((_, skin)) = &self.skin else { return Err("the frame has no faces".to_owned()) };
        let surface = Surface::on(skin, frame, name, part).ok_or("the frames have no such field")?;

        let described: Vec<_> = fields()
            .map(|(name, field)| {
                let (unit, components) = (fields::unit_of(name), Part::names(field.components));
                json!({ "name": name, "unit": unit, "components": components })
            })
            .collect();
        // small numbers of single precision around the middle, where a body far from the origin has its digits, too
        let middle = middle(&surface.vertices);
        let head = json!({
            "frame": number,
            "time": frame.time,
            "field": name,
            "component": component,
            "unit": fields::unit_of(name),
            "label": fields::is_label(name),
            "range": surface.range(),
            "middle": middle,
            "vertices": surface.vertices.len(),
            "faces": surface.faces.len(),
            "corners": surface.faces.iter().map(Vec::len).sum::<usize>(),
            "cells": frame.types.len(),
            "fields": described,
        });
        Ok(bytes(&head.to_string(), &surface, middle))
    }
}

/// Length of the head, the head, then as single-precision and 32-bit numbers in the little-endian order of every browser: places
/// relative to the middle, vertices of the corners of the faces one after another, a value for each of the corners; at the end a byte
/// a face with its number of corners.
fn bytes(head: &str, surface: &Surface, middle: [f64; 3]) -> Vec<u8> {
    let padded = head.len().next_multiple_of(4);
    let corners = || surface.faces.iter().flatten();
    let size = 12 * surface.vertices.len() + 8 * corners().count() + surface.faces.len();
    let mut bytes = Vec::with_capacity(4 + padded + size);
    bytes.extend((padded as u32).to_le_bytes());
    bytes.extend(head.as_bytes());
    bytes.resize(4 + padded, b' ');
    for vertex in &surface.vertices {
        for (place, middle) in vertex.iter().zip(middle) {
            bytes.extend(((place - middle) as f32).to_le_bytes());
        }
    }
    corners().for_each(|corner| bytes.extend(corner.vertex.to_le_bytes()));
    corners().for_each(|corner| bytes.extend((corner.value as f32).to_le_bytes()));
    bytes.extend(surface.faces.iter().map(|face| face.len() as u8));
    bytes
}

/// Frames with the same mark have the same faces.
fn mark(frame: &FrameContent) -> u64 {
    let mut hasher = DefaultHasher::new();
    frame.connectivity.hash(&mut hasher);
    frame.offsets.hash(&mut hasher);
    frame.types.hash(&mut hasher);
    if let Some(ghosts) = frame.cell_fields.get(GHOSTS) {
        ghosts.data.iter().for_each(|ghost| (*ghost as u8).hash(&mut hasher));
    }
    hasher.finish()
}

/// The middle of the finite vertices' extent.
fn middle(vertices: &[[f64; 3]]) -> [f64; 3] {
    std::array::from_fn(|axis| {
        let places = || vertices.iter().map(|vertex| vertex[axis]).filter(|place| place.is_finite());
        let (low, high) = (places().fold(f64::INFINITY, f64::min), places().fold(f64::NEG_INFINITY, f64::max));
        if low <= high { 0.5 * low + 0.5 * high } else { 0.0 }
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use estar_io::FieldContent;
    use std::collections::BTreeMap;

    /// A tet of 1 m far from the origin.
    fn frame() -> FrameContent {
        let points = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        let velocity = FieldContent { components: 3, data: [3.0, 0.0, 4.0].repeat(4) };
        let strain = FieldContent { components: 1, data: vec![0.25] };
        FrameContent {
            time: 2e-6,
            points: points.map(|[x, y, z]| [x + 1e9, y, z]).to_vec(),
            connectivity: vec![0, 1, 2, 3],
            offsets: vec![4],
            types: vec![10],
            node_fields: BTreeMap::from([("velocity".to_owned(), velocity)]),
            cell_fields: BTreeMap::from([("equivalent_plastic_strain".to_owned(), strain)]),
        }
    }

    #[test]
    fn a_packed_surface_has_its_parts_one_after_another() {
        let packed = Bodies::default().packed(7, &frame(), Some("velocity"), None).unwrap();
        let length = u32::from_le_bytes(packed[..4].try_into().unwrap()) as usize;
        let head: serde_json::Value = serde_json::from_slice(&packed[4..4 + length]).unwrap();
        assert_eq!((&head["frame"], &head["unit"], &head["range"]), (&json!(7), &json!("m/s"), &json!([5.0, 5.0])));
        assert_eq!((&head["vertices"], &head["faces"], &head["corners"]), (&json!(4), &json!(4), &json!(12)));
        assert_eq!(packed.len(), 4 + length + 4 * (3 * 4 + 12 + 12) + 4);
        let number = |index: usize| {
            let start = 4 + length + 4 * index;
            f32::from_le_bytes(packed[start..start + 4].try_into().unwrap())
        };
        // half a metre on either side of the middle
        assert!((0..12).all(|index| number(index).abs() == 0.5));
        assert!((24..36).all(|index| number(index) == 5.0));
        assert_eq!(packed[packed.len() - 4..], [3; 4]);
    }

    #[test]
    fn a_field_is_chosen_or_said_not_to_be_there() {
        let mut bodies = Bodies::default();
        let head = |packed: Vec<u8>| String::from_utf8_lossy(&packed).into_owned();
        assert!(
            head(bodies.packed(0, &frame(), None, None).unwrap()).contains("\"field\":\"equivalent_plastic_strain\"")
        );
        assert!(head(bodies.packed(0, &frame(), Some("velocity"), Some("z")).unwrap()).contains("\"range\":[4.0,4.0]"));
        let mut numbered = frame();
        numbered.cell_fields.insert(PART.to_owned(), FieldContent { components: 1, data: vec![3.0] });
        let numbered = head(bodies.packed(0, &numbered, Some(PART), None).unwrap());
        assert!(numbered.contains("\"label\":true") && numbered.contains("\"range\":[3.0,3.0]"), "{numbered}");
        assert!(bodies.packed(0, &frame(), Some("heat"), None).is_err());
        assert!(bodies.packed(0, &frame(), Some("velocity"), Some("xx")).is_err());
    }
}
