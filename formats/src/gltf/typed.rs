//! Entries of a document as the types of the package `gltf`.
//!
//! Its `Root` is not read as a whole: it demands what glTF leaves out at will (the nodes of a
//! scene, the node of an animation's channel). Attributes and morph targets stay JSON, because its
//! types sort and merge their names; so do transformations, which it has in single precision.

use super::json::{Object, integer, malformed};
use crate::FormatError;
use serde::de::DeserializeOwned;
use serde_json::Value;

/// Members that are passed through as they are, whatever they hold.
const PASSED_THROUGH: [&str; 6] = ["extensions", "extras", "max", "min", "name", "target"];

/// Reads an accessor, a buffer view or a buffer. Its references have been checked.
///
/// # Errors
/// If a member has the wrong type, or one is missing that must be there.
pub(super) fn entry<T: DeserializeOwned>(object: &Object, place: &str) -> Result<T, FormatError> {
    serde_json::from_value(Value::Object(read(object))).map_err(|e| malformed(place, e.to_string()))
}

/// The members of an object that are read, its whole numbers spelt as such: `3.0` is one, too.
fn read(object: &Object) -> Object {
    let read = |value: &Value| match value {
        Value::Object(members) => Value::Object(read(members)),
        Value::Number(_) => integer(value).map_or_else(|| value.clone(), Value::from),
        _ => value.clone(),
    };
    let members = object.iter().filter(|(name, _)| !PASSED_THROUGH.contains(&name.as_str()));
    members.map(|(name, value)| (name.clone(), read(value))).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use ::gltf::json::{Accessor, buffer::View};
    use serde_json::json;

    fn typed<T: DeserializeOwned>(value: &Value) -> Result<T, FormatError> {
        entry(value.as_object().expect("an object"), "here")
    }

    #[test]
    fn whole_numbers_may_have_a_point_or_an_exponent() {
        let value = json!({
            "componentType": 5126.0, "count": 3e0, "type": "VEC3", "bufferView": 1.0,
            "sparse": {
                "count": 2.0,
                "indices": { "bufferView": 0.0, "componentType": 5121.0 },
                "values": { "bufferView": 7, "byteOffset": 4.0 },
            },
        });
        let accessor: Accessor = typed(&value).expect("sound");
        assert_eq!((accessor.count.0, accessor.buffer_view.map(|v| v.value())), (3, Some(1)));
        let sparse = accessor.sparse.expect("sparse");
        assert_eq!((sparse.values.buffer_view.value(), sparse.values.byte_offset.0), (7, 4));
        for count in [json!(1.5), json!(-1), json!(1e300), json!("3"), json!(null)] {
            let mut value = value.clone();
            value["count"] = count;
            assert_eq!(typed::<Accessor>(&value).expect_err("not whole").place, "here");
        }
    }

    #[test]
    fn what_is_passed_through_may_hold_anything() {
        let value = json!({
            "buffer": 0, "byteLength": 4,
            "name": 5, "target": "x", "extras": [1], "extensions": { "X": 1 },
        });
        assert_eq!(typed::<View>(&value).expect("sound").byte_length.0, 4);
    }
}
