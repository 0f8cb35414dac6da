//! Entries of a document as the types of the package `gltf`.
//!
//! Its `Root` is not read as a whole: it demands what glTF leaves out at will (the nodes of a
//! scene, the node of an animation's channel). Attributes and morph targets stay JSON, because its
//! types sort and merge their names; so do transformations, which it has in single precision.

use super::json::{Json, Object, malformed};
use crate::FormatError;
use serde::de::DeserializeOwned;

/// Members that are left out, whatever they hold: the JSON of the document keeps them.
const NOT_READ: [&str; 6] = ["extensions", "extras", "max", "min", "name", "target"];

/// Reads an accessor, a buffer view or a buffer. Its references have been checked.
///
/// # Errors
/// If a member has the wrong type, or one is missing that must be there.
pub(super) fn entry<T: DeserializeOwned>(
    object: &Object,
    location: &str,
) -> Result<T, FormatError> {
    serde_json::from_str(&read_members(object).to_string()).map_err(|e| {
        // A place in the text of this entry alone says nothing.
        let problem = e.to_string();
        malformed(location, problem.split(" at line ").next().unwrap_or(&problem))
    })
}

/// The members of an object that are read, its whole numbers spelt as such: `3.0` is one, too.
fn read_members(object: &Object) -> Object {
    let read = |value: &Json| match value {
        Json::Object(members) => Json::Object(read_members(members)),
        other => other.as_u64().map_or_else(|| other.clone(), Json::from),
    };
    let members = object.iter().filter(|(name, _)| !NOT_READ.contains(&name.as_str()));
    members.map(|(name, value)| (name.clone(), read(value))).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Limits;
    use crate::gltf::json::parse;
    use ::gltf::json::{Accessor, buffer::View};

    fn typed<T: DeserializeOwned>(text: &str) -> Result<T, FormatError> {
        entry(&parse(text.as_bytes(), &Limits::DEFAULT).expect("an object"), "here")
    }

    #[test]
    fn whole_numbers_may_have_a_point_or_an_exponent() {
        let with_count = |count: &str| {
            let sparse = r#"{"count": 2.0, "indices": {"bufferView": 0.0, "componentType": 5121.0},
                "values": {"bufferView": 7, "byteOffset": 4.0}}"#;
            typed::<Accessor>(&format!(
                r#"{{"componentType": 5126.0, "count": {count}, "type": "VEC3", "bufferView": 1.0,
                "sparse": {sparse}}}"#
            ))
        };
        let accessor = with_count("3e0").expect("sound");
        assert_eq!((accessor.count.0, accessor.buffer_view.map(|v| v.value())), (3, Some(1)));
        let sparse = accessor.sparse.expect("sparse");
        assert_eq!((sparse.values.buffer_view.value(), sparse.values.byte_offset.0), (7, 4));
        for count in ["1.5", "-1", "1e300", "1e999", "\"3\"", "null"] {
            let error = with_count(count).expect_err("not whole");
            assert!(error.location == "here" && !error.problem.contains("line"), "{error}");
        }
    }

    #[test]
    fn what_is_passed_through_may_hold_anything() {
        let view = r#"{"buffer": 0, "byteLength": 4, "name": 5, "target": "x", "extras": [1],
            "extensions": {"X": 1}}"#;
        assert_eq!(typed::<View>(view).expect("sound").byte_length.0, 4);
    }
}
