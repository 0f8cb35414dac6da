//! The JSON of a glTF: checked before it is parsed, and read through small accessors that never
//! panic.

use crate::{Fault, FormatError, GltfDocument, Limits};
use serde_json::{Map, Value};

/// A JSON object.
pub(crate) type Object = Map<String, Value>;

/// More values than this are refused before parsing: in memory each takes around a hundred bytes.
const VALUES: u64 = 4 << 20;

/// The parser's own bound on nesting, which no limit may exceed.
const PARSER_DEPTH: u32 = 126;

/// Something that breaks the rules of glTF.
pub(crate) fn malformed(place: impl Into<String>, what: impl Into<String>) -> FormatError {
    FormatError::new(Fault::Malformed, place, what)
}

/// Parses a document whose root is an object.
pub(crate) fn parse(text: &[u8], limits: &Limits) -> Result<Object, FormatError> {
    scan(text, limits)?;
    match serde_json::from_slice(text) {
        Ok(Value::Object(root)) => Ok(root),
        Ok(_) => Err(malformed("", "the JSON document is not an object")),
        Err(e) => Err(malformed(
            format!("line {} column {}", e.line(), e.column()),
            format!("not valid JSON: {e}"),
        )),
    }
}

/// Refuses deep nesting and huge numbers of values without recursion and without allocating.
fn scan(text: &[u8], limits: &Limits) -> Result<(), FormatError> {
    let (mut depth, mut values) = (0u32, 0u64);
    let (mut in_string, mut escaped) = (false, false);
    for &b in text {
        if in_string {
            match b {
                _ if escaped => escaped = false,
                b'\\' => escaped = true,
                b'"' => in_string = false,
                _ => {}
            }
            continue;
        }
        match b {
            b'"' => in_string = true,
            b'[' | b'{' => {
                depth += 1;
                values += 1;
                if depth > limits.json_depth.min(PARSER_DEPTH) {
                    return Err(FormatError::new(
                        Fault::Limit,
                        "",
                        format!("JSON nested deeper than {depth} levels"),
                    ));
                }
            }
            b']' | b'}' => depth = depth.saturating_sub(1),
            b',' => values += 1,
            _ => {}
        }
        if values > VALUES {
            return Err(FormatError::new(
                Fault::Limit,
                "",
                format!("JSON of more than {VALUES} values"),
            ));
        }
    }
    Ok(())
}

/// A number without a fraction, however it is spelt.
pub(crate) fn integer(value: &Value) -> Option<u64> {
    let whole = |x: f64| (x >= 0.0 && x.fract() == 0.0 && x < 9e15).then_some(x as u64);
    value.as_u64().or_else(|| value.as_f64().and_then(whole))
}

/// The member `key`, which must be a whole number if it is there.
pub(crate) fn optional(
    object: &Object,
    key: &str,
    place: &str,
) -> Result<Option<u64>, FormatError> {
    let number =
        |v| integer(v).ok_or_else(|| malformed(format!("{place}.{key}"), "must be a whole number"));
    object.get(key).map(number).transpose()
}

/// The member `key`, a whole number that must be there.
pub(crate) fn required(object: &Object, key: &str, place: &str) -> Result<u64, FormatError> {
    optional(object, key, place)?.ok_or_else(|| malformed(place, format!("has no `{key}`")))
}

/// The objects of the top-level array `key`; none if there is no such array.
pub(crate) fn entries<'a>(
    root: &'a Object,
    key: &str,
) -> impl ExactSizeIterator<Item = &'a Object> {
    static EMPTY: std::sync::LazyLock<Object> = std::sync::LazyLock::new(Object::new);
    list(root, key).iter().map(|v| v.as_object().unwrap_or(&EMPTY))
}

/// The elements of the array `key`; none if there is no such array.
pub(crate) fn list<'a>(object: &'a Object, key: &str) -> &'a [Value] {
    object.get(key).and_then(Value::as_array).map_or(&[], Vec::as_slice)
}

/// The extension `name` of an object.
pub(crate) fn extension<'a>(object: &'a Object, name: &str) -> Option<&'a Object> {
    object.get("extensions")?.as_object()?.get(name)?.as_object()
}

/// Takes the extension `name` off an object, and `extensions` with the last one.
pub(crate) fn remove_extension(object: &mut Object, name: &str) {
    if let Some(all) = object.get_mut("extensions").and_then(Value::as_object_mut) {
        all.shift_remove(name);
        if all.is_empty() {
            object.shift_remove("extensions");
        }
    }
}

/// An index into one of the document's lists.
pub(crate) fn as_index(value: &Value) -> Option<usize> {
    value.as_u64().and_then(|i| usize::try_from(i).ok())
}

/// As many numbers as there should be, or the default.
pub(crate) fn numbers<const N: usize>(value: &Value, default: [f64; N]) -> [f64; N] {
    match value.as_array() {
        Some(a) if a.len() == N => std::array::from_fn(|i| a[i].as_f64().unwrap_or(default[i])),
        _ => default,
    }
}

/// The document's JSON.
pub(crate) fn parse_json(gltf: &GltfDocument) -> Result<Value, FormatError> {
    serde_json::from_str(&gltf.json).map_err(|e| {
        FormatError::new(Fault::Malformed, "", format!("the stored glTF document is damaged: {e}"))
    })
}
