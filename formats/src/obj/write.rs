//! Writes Wavefront OBJ and MTL. Reading a number back gives the same bits.

use super::mtl::{self, Meaning};
use crate::colours::SrgbValues;
use crate::far::single;
use crate::flatten::{FileCoordinates, Placed, Vertices, component};
use crate::images::{ImagePlace, PlacedTextures};
use crate::loose::Loose;
use crate::provenance::Provenance;
use crate::{ObjDocument, ObjMaterial, OutputFile, SubmeshInfo};
use lodc_mesh::{Mesh, Semantic};
use lodc_scene::stream;
use std::collections::{BTreeMap, BTreeSet, HashMap};
use std::hash::Hash;
use std::io::Write;
use std::path::Path;

/// The OBJ and, if there are materials and `path` is not standard output, the MTL beside it.
pub(crate) fn export(
    path: &Path,
    placed: &[Placed<'_>],
    library: &Library,
    loose: &Loose,
    provenance: Option<&Provenance>,
) -> Vec<OutputFile> {
    let origin = provenance.map(Provenance::line);
    let mut text = format!("# {}\n", origin.as_deref().unwrap_or("lodc")).into_bytes();
    let library_path = path.with_extension("mtl");
    let has_library = !library.text.is_empty() && path.as_os_str() != "-";
    if has_library {
        let name = library_path.file_name().map(|n| n.to_string_lossy().into_owned());
        line(&mut text, "mtllib", &name.unwrap_or_default());
    }
    let mut writer = Writer {
        text,
        v: Table::new(),
        vt: Table::new(),
        vn: Table::new(),
        numbers: Vec::new(),
        material: String::new(),
        srgb: SrgbValues::default(),
    };
    for placed in placed {
        writer.object(placed, library);
    }
    if !loose.is_empty() {
        line(&mut writer.text, "o", "points_and_lines");
        loose.statements().iter().for_each(|statement| line(&mut writer.text, statement, ""));
    }
    let mut files = vec![OutputFile { path: path.to_owned(), bytes: writer.text }];
    if has_library {
        files.push(OutputFile { path: library_path, bytes: library.text.clone() });
    }
    files
}

/// The numbers of values already written, from 1, by their bits.
type Table<K> = HashMap<K, usize>;

struct Writer {
    text: Vec<u8>,
    /// Positions with colours.
    v: Table<([u64; 3], [u32; 4])>,
    /// Texture coordinates.
    vt: Table<[u32; 3]>,
    /// Normals.
    vn: Table<[u32; 3]>,
    /// For each vertex of the object the numbers of its v, vt and vn; zeros before it is written.
    numbers: Vec<[usize; 3]>,
    /// The material of the last `usemtl`.
    material: String,
    srgb: SrgbValues,
}

impl Writer {
    fn object(&mut self, placed: &Placed<'_>, library: &Library) {
        let (mesh, info) = (placed.object.mesh, placed.object.info);
        line(&mut self.text, "o", &clean(&placed.name));
        self.numbers.clear();
        self.numbers.resize(mesh.vertex_count(), [0; 3]);
        let vertices = placed.vertices();
        let mut label = String::new();
        for (i, (submesh, submesh_info)) in mesh.submeshes().iter().zip(&info.submeshes).enumerate()
        {
            if submesh.triangle_count == 0 {
                continue;
            }
            let faces = self.vertices(mesh, &vertices, i, placed.coordinates(i));
            let name = clean(&submesh_info.name);
            if name != label {
                line(&mut self.text, "g", &name);
                label = name;
            }
            let material = library.material_name(info.document_mesh, submesh_info);
            if material != self.material {
                line(&mut self.text, "usemtl", &material);
                self.material = material;
            }
            self.text.extend_from_slice(&faces);
        }
    }

    /// Writes the vertices of a submesh that were not written before; returns its faces.
    fn vertices(
        &mut self,
        mesh: &Mesh,
        placed: &Vertices<'_>,
        submesh: usize,
        coordinates: FileCoordinates,
    ) -> Vec<u8> {
        let uv = Semantic::TexCoord(coordinates.set);
        let [color, uv, normal] = [Semantic::Color(0), uv, Semantic::Normal]
            .map(|semantic| stream(mesh, submesh, &semantic));
        let mut faces = Vec::new();
        for &triangle in &mesh.triangles()[mesh.submeshes()[submesh].triangles()] {
            faces.push(b'f');
            for vertex in placed.corners(triangle) {
                let numbers = &mut self.numbers[vertex as usize];
                if numbers[0] == 0 {
                    let position = match placed.far {
                        Some(_) => placed.exact_position(vertex),
                        None => placed.position(vertex).map(f64::from),
                    };
                    let components = color.map_or(0, |c| usize::from(c.components).clamp(3, 4));
                    let rgba: [f32; 4] = std::array::from_fn(|i| match color {
                        Some(c) if i < 3 => self.srgb.of(c, vertex, i),
                        Some(c) if i < components => component(c, vertex, i),
                        _ => 0.0,
                    });
                    let key = (position.map(f64::to_bits), rgba.map(f32::to_bits));
                    numbers[0] = number(&mut self.v, key, &mut self.text, "v", |text| {
                        for c in position {
                            text.push(b' ');
                            coordinate(text, c, placed);
                        }
                        floats(text, &rgba[..components]);
                    });
                    if let Some(s) = uv {
                        let uvw = coordinates.at(s, vertex);
                        let count = usize::from(s.components).clamp(2, 3);
                        numbers[1] = number(
                            &mut self.vt,
                            uvw.map(f32::to_bits),
                            &mut self.text,
                            "vt",
                            |text| floats(text, &uvw[..count]),
                        );
                    }
                    if let Some(s) = normal {
                        let n = placed.normal(s, vertex);
                        let key = n.map(f32::to_bits);
                        numbers[2] = number(&mut self.vn, key, &mut self.text, "vn", |text| {
                            floats(text, &n);
                        });
                    }
                }
                corner(&mut faces, *numbers);
            }
            faces.push(b'\n');
        }
        faces
    }
}

/// A coordinate of a placed object.
fn coordinate(text: &mut Vec<u8>, c: f64, placed: &Vertices<'_>) {
    match placed.far {
        Some(rounding) if placed.are_posed() => double(text, c, rounding),
        Some(rounding) => far_float(text, single(c), rounding),
        None => float(text, single(c)),
    }
}

/// By how much the text of a placed object is off its coordinates at most.
pub(crate) fn rounding(placed: &Vertices<'_>, mesh: &Mesh) -> f64 {
    if placed.far.is_none() {
        return placed.rounding();
    }
    let mut text = Vec::new();
    let mut off = |c: f64| {
        text.clear();
        coordinate(&mut text, c, placed);
        let read = std::str::from_utf8(&text).ok().and_then(|text| text.parse::<f64>().ok());
        read.map_or(0.0, |read| (read - c).abs())
    };
    let vertices = 0..mesh.vertex_count() as u32;
    vertices.flat_map(|v| placed.exact_position(v)).map(&mut off).fold(0.0, f64::max)
}

/// A corner of a face: ` v`, ` v/vt`, ` v//vn` or ` v/vt/vn`.
fn corner(text: &mut Vec<u8>, [v, vt, vn]: [usize; 3]) {
    text.push(b' ');
    decimal(text, v);
    if vt > 0 || vn > 0 {
        text.push(b'/');
    }
    if vt > 0 {
        decimal(text, vt);
    }
    if vn > 0 {
        text.push(b'/');
        decimal(text, vn);
    }
}

fn decimal(text: &mut Vec<u8>, mut value: usize) {
    let mut digits = [0; 20];
    let mut first = digits.len();
    while first == digits.len() || value > 0 {
        first -= 1;
        digits[first] = b'0' + (value % 10) as u8;
        value /= 10;
    }
    text.extend_from_slice(&digits[first..]);
}

/// The number of a value; writes it first if it is new.
fn number<K: Eq + Hash>(
    table: &mut Table<K>,
    key: K,
    text: &mut Vec<u8>,
    word: &str,
    write: impl FnOnce(&mut Vec<u8>),
) -> usize {
    let next = table.len() + 1;
    *table.entry(key).or_insert_with(|| {
        text.extend_from_slice(word.as_bytes());
        write(text);
        text.push(b'\n');
        next
    })
}

/// Values, each after a space.
fn floats(text: &mut Vec<u8>, values: &[f32]) {
    for &value in values {
        text.push(b' ');
        float(text, value);
    }
}

/// The decimal with the fewest digits that is at most `rounding` from a number: that of the file
/// which the number was read from, if it had no more digits than a mesh holds.
fn double(text: &mut Vec<u8>, value: f64, rounding: f64) {
    // More than an f64 has.
    const MAX_DECIMALS: usize = 17;
    let written = (0..MAX_DECIMALS)
        .map(|decimals| format!("{value:.decimals$}"))
        .find(|spelt| spelt.parse().is_ok_and(|read: f64| (read - value).abs() <= rounding));
    text.extend_from_slice(written.unwrap_or_else(|| value.to_string()).as_bytes());
}

/// A decimal that reads back as the same number and is at most `rounding` off: read in double
/// precision, the shortest may be as far off as single precision rounds.
fn far_float(text: &mut Vec<u8>, value: f32, rounding: f64) {
    let start = text.len();
    float(text, value);
    let is_near = |spelt: &[u8]| {
        let spelt = std::str::from_utf8(spelt).unwrap_or_default();
        let off = |read: f64| (read - f64::from(value)).abs();
        spelt.parse().is_ok_and(|read| off(read) <= rounding) && spelt.parse() == Ok(value)
    };
    if value.is_finite() && !is_near(&text[start..]) {
        text.truncate(start);
        double(text, value.into(), rounding);
        if !is_near(&text[start..]) {
            text.truncate(start);
            text.extend_from_slice(f64::from(value).to_string().as_bytes());
        }
    }
}

/// The shortest decimal that reads back as the same number.
fn float(text: &mut Vec<u8>, value: f32) {
    let plain = value == 0.0 || !value.is_finite() || (1e-5..1e9).contains(&value.abs());
    let written = if plain { write!(text, "{value}") } else { write!(text, "{value:e}") };
    written.expect("a Vec takes everything");
}

fn line(text: &mut Vec<u8>, word: &str, name: &str) {
    text.extend_from_slice(word.as_bytes());
    if !name.is_empty() {
        text.push(b' ');
        text.extend_from_slice(name.as_bytes());
    }
    text.push(b'\n');
}

/// A name on one line that reads back as itself: without line ends, a `#` between spaces and a
/// backslash at the end.
fn clean(name: &str) -> String {
    let one_line: String = name.chars().map(|c| if c.is_control() { '_' } else { c }).collect();
    let mut out = one_line.trim().to_owned();
    while let Some(space) = out.find(" # ").or_else(|| out.ends_with(" #").then(|| out.len() - 2)) {
        out.replace_range(space + 1..space + 2, "_");
    }
    if out.ends_with('\\') {
        out.push('_');
    }
    if out == "#" { "_".to_owned() } else { out }
}

/// The text of a material library, and the names of materials that primitives have.
#[derive(Debug, Default)]
pub(crate) struct Library {
    text: Vec<u8>,
    names: Vec<String>,
    taken_names: BTreeSet<String>,
    /// Files of base colour textures by the names of materials.
    textures: BTreeMap<String, String>,
    /// Indices into the names by mesh and primitive, of a glTF only.
    by_primitive: BTreeMap<(usize, usize), usize>,
}

/// Name, colour, opacity and texture: what an MTL and other formats have in common.
#[derive(Debug)]
pub(crate) struct SimpleMaterial<'a> {
    pub(crate) name: &'a str,
    pub(crate) colour: [f64; 3],
    pub(crate) opacity: Option<f64>,
    pub(crate) texture: Option<String>,
    /// True if the texture is not repeated.
    pub(crate) clamped: bool,
}

impl Library {
    /// The library of an OBJ, its images under the names that their copies have.
    pub(crate) fn new(document: &ObjDocument, textures: &PlacedTextures) -> Self {
        let (mut text, mut files) = (Vec::new(), BTreeMap::new());
        for material in &document.materials {
            let lines = material.lines.iter();
            let lines = lines.map(|l| renamed(&l.replace(['\n', '\r'], " "), textures)).collect();
            let material = ObjMaterial { name: clean(&material.name), lines };
            line(&mut text, "newmtl", &material.name);
            material.lines.iter().for_each(|l| line(&mut text, l, ""));
            if let Some(map) = Meaning::of(&material).map() {
                // Of several materials with one name the first holds.
                files.entry(material.name.clone()).or_insert_with(|| clean(map.file));
            }
        }
        Self { text, textures: files, ..Self::default() }
    }

    /// Adds a material. One without a name, or with that of another, gets a name with a number.
    pub(crate) fn add(&mut self, material: &SimpleMaterial<'_>) {
        let mut name = clean(material.name);
        if name.is_empty() || self.taken_names.contains(&name) {
            name =
                format!("{name}_material{}", self.names.len()).trim_start_matches('_').to_owned();
        }
        let text = &mut self.text;
        line(text, "newmtl", &name);
        let [r, g, b] = material.colour;
        line(text, &format!("Kd {r} {g} {b}"), "");
        if let Some(opacity) = material.opacity {
            line(text, &format!("d {opacity}"), "");
        }
        if let Some(file) = &material.texture {
            let file = clean(file);
            line(text, if material.clamped { "map_Kd -clamp on" } else { "map_Kd" }, &file);
            self.textures.insert(name.clone(), file);
        }
        self.taken_names.insert(name.clone());
        self.names.push(name);
    }

    /// Gives a primitive the material of this number, if there is one.
    pub(crate) fn assign(&mut self, mesh: usize, primitive: usize, material: usize) {
        if material < self.names.len() {
            self.by_primitive.insert((mesh, primitive), material);
        }
    }

    /// The name of a submesh's material; empty without one.
    fn material_name(&self, mesh: u32, submesh: &SubmeshInfo) -> String {
        let primitive = (mesh as usize, submesh.document_primitive as usize);
        match &submesh.material {
            Some(name) => clean(name),
            None => {
                let material = self.by_primitive.get(&primitive);
                material.map(|&m| self.names[m].clone()).unwrap_or_default()
            }
        }
    }

    /// The file of the base colour texture of a submesh; none without one.
    pub(crate) fn texture(&self, mesh: u32, submesh: &SubmeshInfo) -> Option<&str> {
        self.textures.get(&self.material_name(mesh, submesh)).map(String::as_str)
    }
}

/// A line of a material in which the copy of an image replaces the image.
fn renamed(source: &str, textures: &PlacedTextures) -> String {
    let file = mtl::file(source).map(|name| name.replace('\\', "/"));
    match file.as_deref().and_then(|name| Some((name, textures.of(name)?))) {
        Some((name, ImagePlace::Beside(other))) if name != other => mtl::with_file(source, other),
        _ => source.to_owned(),
    }
}

#[cfg(test)]
#[path = "write_tests.rs"]
mod tests;
