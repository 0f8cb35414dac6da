//! Reads accessors and buffer views of the glTF document that a `.lodc` or `.lods` file stores: all
//! that an import left after taking the triangles out. It is checked again, because the file may be
//! crafted.

use super::accessor::Accessor;
#[cfg(feature = "import")]
use super::accessor::{Shape, component_number};
use super::budget::Budget;
use super::json::{self, Object, malformed};
use super::schema;
use super::views::{Buffers, Views};
use crate::{FormatError, GltfDocument, Limits};
use lodc_mesh::{Attribute, Semantic};
#[cfg(feature = "import")]
use std::convert::Infallible;
#[cfg(feature = "import")]
use xxhash_rust::xxh3::{Xxh3, xxh3_128};

impl GltfDocument {
    /// The document of a checked root, and the bytes that its buffer views refer to.
    #[cfg(feature = "import")]
    pub(crate) fn of_root(root: Object, blob: Vec<u8>) -> Self {
        let document = Self::new(root.to_string(), blob);
        let Ok(_) = document.root.or_make(|| Ok::<_, Infallible>(root));
        document
    }

    /// The JSON document, every reference of which leads somewhere.
    ///
    /// # Errors
    /// If it is damaged.
    pub(crate) fn root(&self, limits: &Limits) -> Result<&Object, FormatError> {
        self.root.or_make(|| {
            let mut root = json::parse(self.json().as_bytes(), limits)?;
            schema::check(&mut root)?;
            Ok(root)
        })
    }
}

/// A stored document that is open for reading.
pub(crate) struct Stored<'a> {
    accessors: &'a [Option<Accessor>],
    views: &'a Views<'a>,
}

impl Stored<'_> {
    /// Lets `work` read a document, checked.
    ///
    /// # Errors
    /// If it is damaged, or `work` fails.
    pub(crate) fn read<T>(
        document: &GltfDocument,
        limits: &Limits,
        work: impl FnOnce(&Stored<'_>, &Object) -> Result<T, FormatError>,
    ) -> Result<T, FormatError> {
        let root = document.root(limits)?;
        let blob = document.blob();
        let mut buffers: Buffers<'_> = vec![None; root.entries("buffers").len()];
        if let Some(first) = buffers.first_mut() {
            *first = Some(blob.into());
        }
        check_length(root, blob.len())?;
        let budget = Budget::new(blob.len() as u64);
        let views = Views::new(root, &buffers, &budget)?;
        let accessors = document.accessors.or_make(|| Accessor::all(root, &views))?;
        work(&Stored { accessors, views: &views }, root)
    }

    /// All components of all elements of an accessor, and how many components an element has.
    ///
    /// # Errors
    /// If it is not there, or its bytes are damaged.
    pub(crate) fn numbers(&self, accessor: usize) -> Result<(Vec<f64>, usize), FormatError> {
        numbers(self.accessors, self.views, accessor)
    }

    /// A hash of the elements of an accessor and of what they are; none if it cannot be read.
    #[cfg(feature = "import")]
    pub(crate) fn accessor_hash(&self, accessor: usize) -> Option<u128> {
        let accessor = self.accessors.get(accessor)?.as_ref()?;
        let reader = accessor.reader(self.views).ok()?;
        let mut hasher = Xxh3::new();
        let Shape { columns, rows } = accessor.shape;
        let kind = component_number(accessor.component);
        for number in [columns as u32, rows as u32, kind, accessor.normalized.into()] {
            hasher.update(&number.to_le_bytes());
        }
        let mut element = Vec::new();
        for i in 0..accessor.count as u32 {
            element.clear();
            reader.append(i, &mut element);
            hasher.update(&element);
        }
        Some(hasher.digest128())
    }

    /// A hash of the bytes of a buffer view; none if it has none.
    #[cfg(feature = "import")]
    pub(crate) fn view_hash(&self, view: usize) -> Option<u128> {
        self.views.bytes(view).ok().map(xxh3_128)
    }

    /// The bytes of a buffer view.
    ///
    /// # Errors
    /// If it has none.
    pub(crate) fn view(&self, view: usize) -> Result<Vec<u8>, FormatError> {
        self.views.bytes(view).map(<[u8]>::to_vec)
    }
}

/// All components of all elements of an accessor, and how many components an element has.
///
/// # Errors
/// If it is not there, or its bytes are damaged.
pub(super) fn numbers(
    accessors: &[Option<Accessor>],
    views: &Views<'_>,
    accessor: usize,
) -> Result<(Vec<f64>, usize), FormatError> {
    let location = format!("accessors[{accessor}]");
    let missing = || malformed(&*location, "cannot be read");
    let accessor = accessors.get(accessor).and_then(Option::as_ref).ok_or_else(missing)?;
    let components = accessor.shape.components();
    // Four bytes at most as it is stored, and eight as a double.
    views.budget.charge(accessor.count as u64, 12 * components as u64, &location)?;
    let reader = accessor.reader(views)?;
    let mut bytes = Vec::new();
    (0..accessor.count as u32).for_each(|i| reader.append(i, &mut bytes));
    let stream = Attribute {
        semantic: Semantic::Custom(String::new()),
        morph_target: None,
        component: accessor.component,
        components: components as u8,
        normalized: accessor.normalized,
        bytes,
    };
    let value = |i: usize| f64::from(stream.value((i / components) as u32, i % components));
    Ok(((0..accessor.count * components).map(value).collect(), components))
}

/// Buffer 0 must have the bytes that its views count on.
fn check_length(root: &Object, blob: usize) -> Result<(), FormatError> {
    match root.entries("buffers").next() {
        Some(first) if first.required("byteLength", "buffers[0]")? > blob as u64 => {
            Err(malformed("buffers[0]", format!("says more bytes than the {blob} that there are")))
        }
        _ => Ok(()),
    }
}

#[cfg(all(test, feature = "import", feature = "export"))]
#[path = "document_tests.rs"]
mod tests;
