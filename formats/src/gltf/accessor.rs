//! Accessors: typed, strided, sparse views of bytes, checked once and then read element by element.

use super::json::{Object, malformed};
use super::typed;
use super::views::Views;
use crate::FormatError;
use ::gltf::json;
use json::accessor::{ComponentType, IndexComponentType, Type, sparse};
use json::buffer::View;
use json::validation::{Checked, USize64};
use lodc_mesh::Component;

/// The shape of an element: columns of rows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Shape {
    /// 1 except for matrices.
    pub(crate) columns: usize,
    /// Components of a column.
    pub(crate) rows: usize,
}

/// Shapes by their types in glTF.
const SHAPES: [(Type, &str, Shape); 7] = [
    (Type::Scalar, "SCALAR", Shape { columns: 1, rows: 1 }),
    (Type::Vec2, "VEC2", Shape { columns: 1, rows: 2 }),
    (Type::Vec3, "VEC3", Shape { columns: 1, rows: 3 }),
    (Type::Vec4, "VEC4", Shape { columns: 1, rows: 4 }),
    (Type::Mat2, "MAT2", Shape { columns: 2, rows: 2 }),
    (Type::Mat3, "MAT3", Shape { columns: 3, rows: 3 }),
    (Type::Mat4, "MAT4", Shape { columns: 4, rows: 4 }),
];

/// Types of components by those of glTF.
const COMPONENTS: [(ComponentType, Component); 6] = [
    (ComponentType::I8, Component::I8),
    (ComponentType::U8, Component::U8),
    (ComponentType::I16, Component::I16),
    (ComponentType::U16, Component::U16),
    (ComponentType::U32, Component::U32),
    (ComponentType::F32, Component::F32),
];

impl Shape {
    /// The shape of this many components and its type; none if glTF has no such type.
    pub(crate) fn of_components(count: usize) -> Option<(Self, &'static str)> {
        let entry = SHAPES.iter().find(|(_, _, shape)| shape.components() == count);
        entry.map(|&(_, name, shape)| (shape, name))
    }
    /// The shape of a type by its name.
    pub(crate) fn named(name: &str) -> Option<Self> {
        SHAPES.iter().find(|(_, other, _)| *other == name).map(|&(_, _, shape)| shape)
    }
    /// Components in all.
    pub(crate) const fn components(self) -> usize {
        self.columns * self.rows
    }
    /// Bytes from one column to the next: columns of matrices start at multiples of four (glTF 2.0,
    /// 3.6.2.4).
    pub(crate) const fn column_stride(self, component: Component) -> usize {
        let bytes = self.rows * component.size();
        if self.columns == 1 { bytes } else { bytes.next_multiple_of(4) }
    }
}

fn component(kind: ComponentType) -> Component {
    COMPONENTS.iter().find(|(other, _)| *other == kind).expect("the table has all").1
}

/// The component type of a number in glTF.
pub(super) fn numbered_component(number: u64) -> Option<Component> {
    let entry = COMPONENTS.iter().find(|(kind, _)| u64::from(kind.as_gl_enum()) == number);
    entry.map(|&(_, component)| component)
}

/// The number of a component type in glTF.
pub(crate) fn component_number(component: Component) -> u32 {
    let entry = COMPONENTS.iter().find(|(_, other)| *other == component);
    entry.expect("the table has all").0.as_gl_enum()
}

/// Description of an accessor, known to fit its buffer views.
#[derive(Clone, Debug)]
pub(super) struct Accessor {
    pub(super) shape: Shape,
    pub(super) component: Component,
    pub(super) normalized: bool,
    pub(super) count: usize,
    location: String,
    /// Where its elements are; none means zeros.
    data: Option<StridedBytes>,
    sparse: Option<Sparse>,
}

/// Elements in a buffer view.
#[derive(Clone, Copy, Debug)]
struct StridedBytes {
    view: usize,
    /// Offset of the first element in the view, in bytes.
    offset: usize,
    /// Bytes from one element to the next.
    stride: usize,
}

/// Elements that replace others of an accessor.
#[derive(Clone, Debug)]
struct Sparse {
    count: usize,
    /// The numbers of the elements that are replaced.
    indices: StridedBytes,
    index_component: Component,
    values: StridedBytes,
}

impl Accessor {
    /// All accessors of a document, as [`Self::new`] has them.
    pub(super) fn all(root: &Object, views: &Views<'_>) -> Result<Vec<Option<Self>>, FormatError> {
        let all = root.entries("accessors").enumerate();
        all.map(|(i, object)| Self::new(object, format!("accessors[{i}]"), views)).collect()
    }

    /// Reads and checks the description, no data. `None` for a type or component type that glTF
    /// does not know: such an accessor can be kept, but not read.
    fn new(
        object: &Object,
        location: String,
        views: &Views<'_>,
    ) -> Result<Option<Self>, FormatError> {
        let stated: json::Accessor = typed::entry(object, &location)?;
        let count = stated.count.0;
        if count == 0 {
            return Err(malformed(location, "count must be at least 1"));
        }
        let (Checked::Valid(shape), Checked::Valid(number)) = (stated.type_, stated.component_type)
        else {
            return Ok(None);
        };
        let &(_, _, shape) = SHAPES.iter().find(|s| s.0 == shape).expect("the table has all");
        let component = component(number.0);
        // A vertex number is 32 bits wide and its largest value is reserved.
        let count = usize::try_from(count).ok().filter(|&c| c < u32::MAX as usize);
        let count =
            count.ok_or_else(|| malformed(&*location, "count is larger than any index can be"))?;
        let offset = stated.byte_offset.map(|offset| offset.0);
        let view = stated.buffer_view.map(|view| view.value());
        if offset.is_some() && view.is_none() {
            return Err(malformed(location, "byteOffset without bufferView"));
        }
        let size = shape.columns * shape.column_stride(component);
        // The last element needs no padding behind its last column.
        let last_size = size - (shape.column_stride(component) - shape.rows * component.size());
        let data = match view {
            None => None,
            Some(view) => {
                let stride = views.stride(view).unwrap_or(size);
                if stride < size {
                    return Err(malformed(
                        location,
                        format!("byteStride {stride} is less than an element of {size} bytes"),
                    ));
                }
                let offset = offset.unwrap_or(0);
                fits(offset, stride, count, last_size, views.len(view))
                    .map_err(|problem| malformed(&*location, problem))?;
                Some(StridedBytes { view, offset: offset as usize, stride })
            }
        };
        let sparse = stated.sparse.as_ref();
        let sparse =
            sparse.map(|s| Sparse::new(s, &format!("{location}.sparse"), count, size, views));
        let (sparse, normalized) = (sparse.transpose()?, stated.normalized);
        Ok(Some(Self { shape, component, normalized, count, location, data, sparse }))
    }

    /// Its elements.
    pub(super) fn reader<'v>(&self, views: &'v Views<'_>) -> Result<Reader<'v>, FormatError> {
        let (bytes, stride) = match self.data {
            Some(data) => (&views.bytes(data.view)?[data.offset..], data.stride),
            None => (&[][..], 0),
        };
        let mut reader = Reader {
            bytes,
            stride,
            columns: self.shape.columns,
            column_bytes: self.shape.rows * self.component.size(),
            column_stride: self.shape.column_stride(self.component),
            replaced: Vec::new(),
            replacements: &[],
        };
        if let Some(sparse) = &self.sparse {
            reader.replaced = sparse.read_indices(views, self.count, &self.location)?;
            reader.replacements = &views.bytes(sparse.values.view)?[sparse.values.offset..];
        }
        Ok(reader)
    }
}

impl Sparse {
    fn new(
        stated: &sparse::Sparse,
        location: &str,
        accessor_count: usize,
        size: usize,
        views: &Views<'_>,
    ) -> Result<Self, FormatError> {
        let count = stated.count.0;
        if count == 0 || count > accessor_count as u64 {
            return Err(malformed(
                location,
                format!("count {count} is not between 1 and the accessor's {accessor_count}"),
            ));
        }
        let packed = |view: json::Index<View>, offset: USize64, size: usize| {
            let (view, offset) = (view.value(), offset.0);
            if views.stride(view).is_some() {
                return Err(malformed(location, "sparse data must not have a byteStride"));
            }
            fits(offset, size, count as usize, size, views.len(view))
                .map_err(|problem| malformed(location, problem))?;
            Ok(StridedBytes { view, offset: offset as usize, stride: size })
        };
        let (indices, values) = (&stated.indices, &stated.values);
        let Checked::Valid(IndexComponentType(index)) = indices.component_type else {
            let location = format!("{location}.indices");
            return Err(malformed(location, "componentType is not an unsigned integer"));
        };
        let index_component = component(index);
        let index_size = index_component.size();
        Ok(Self {
            count: count as usize,
            indices: packed(indices.buffer_view, indices.byte_offset, index_size)?,
            index_component,
            values: packed(values.buffer_view, values.byte_offset, size)?,
        })
    }

    fn read_indices(
        &self,
        views: &Views<'_>,
        count: usize,
        location: &str,
    ) -> Result<Vec<u32>, FormatError> {
        let StridedBytes { view, offset, .. } = self.indices;
        let index_size = self.index_component.size();
        views.budget.charge(self.count as u64, 4, location)?;
        let bytes = &views.bytes(view)?[offset..][..self.count * index_size];
        let indices: Vec<u32> = bytes.chunks_exact(index_size).map(unsigned).collect();
        let rising = indices.windows(2).all(|w| w[0] < w[1]);
        if !rising || indices.last().is_some_and(|&i| i as usize >= count) {
            return Err(malformed(
                format!("{location}.sparse.indices"),
                "must rise and stay below the accessor's count",
            ));
        }
        Ok(indices)
    }
}

/// Checks that `count` elements from `offset` on, the last one of `last_size` bytes, fit into
/// `length` bytes; else says what is wrong.
fn fits(
    offset: u64,
    stride: usize,
    count: usize,
    last_size: usize,
    length: usize,
) -> Result<(), String> {
    let last_start = (count as u64 - 1).checked_mul(stride as u64);
    let end = last_start.and_then(|s| offset.checked_add(s)?.checked_add(last_size as u64));
    if end.is_some_and(|end| end <= length as u64) {
        return Ok(());
    }
    Err(format!(
        "{count} elements of {last_size} bytes from byte {offset} on do not fit the buffer view of \
         {length} bytes"
    ))
}

/// Reads the elements of one accessor, tightly packed.
#[derive(Debug)]
pub(super) struct Reader<'v> {
    bytes: &'v [u8],
    stride: usize,
    columns: usize,
    /// Bytes of a column without padding.
    column_bytes: usize,
    column_stride: usize,
    /// Numbers of the elements that sparse data replaces, rising.
    replaced: Vec<u32>,
    /// The elements that take their place.
    replacements: &'v [u8],
}

impl Reader<'_> {
    /// Appends the bytes of element `i`, which is below the accessor's count.
    pub(super) fn append(&self, i: u32, out: &mut Vec<u8>) {
        let element = match self.replaced.binary_search(&i) {
            Ok(index) => &self.replacements[index * self.columns * self.column_stride..],
            Err(_) if self.bytes.is_empty() => {
                out.resize(out.len() + self.columns * self.column_bytes, 0);
                return;
            }
            Err(_) => &self.bytes[i as usize * self.stride..],
        };
        for column in 0..self.columns {
            out.extend_from_slice(&element[column * self.column_stride..][..self.column_bytes]);
        }
    }
}

/// An unsigned integer of 1, 2 or 4 bytes.
pub(super) fn unsigned(bytes: &[u8]) -> u32 {
    bytes.iter().rev().fold(0, |value, &b| value << 8 | u32::from(b))
}
