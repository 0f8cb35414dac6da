//! JSON that goes out as it came in: members in their order, numbers as they are spelt. Bounded
//! while it is parsed, and read through small accessors that never panic.

use crate::{Fault, FormatError, Limits};
use hifijson::SliceLexer;
use hifijson::num::LexWrite;
use hifijson::str::LexAlloc;
use hifijson::token::{Expect, Lex};
use indexmap::IndexMap;
use std::fmt::{self, Display, Formatter, Write};
use std::ops::{Deref, DerefMut, Index, IndexMut};

/// More values than this are refused before parsing: in memory each takes around a hundred bytes.
/// Chosen by hand.
const MAX_VALUES: usize = 4 << 20;

/// A bound on nesting which no limit may exceed: documents are walked by recursion.
/// Chosen by hand.
const MAX_DEPTH: u32 = 126;

/// A JSON value.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Json {
    Null,
    Bool(bool),
    /// As it is spelt.
    Number(Box<str>),
    String(String),
    Array(Vec<Json>),
    Object(Object),
}

/// A JSON object: members in order. A name that comes twice has its first place and its last value.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Object(IndexMap<String, Json>);

/// `object! { "name" => value, … }`: an object as JSON.
macro_rules! object {
    ($($key:expr => $value:expr),* $(,)?) => {
        $crate::gltf::json::Json::Object(
            [$((($key).to_owned(), $crate::gltf::json::Json::from($value))),*]
                .into_iter()
                .collect(),
        )
    };
}
pub(crate) use object;

/// Something that breaks the rules of glTF.
pub(crate) fn malformed(location: impl Into<String>, problem: impl Into<String>) -> FormatError {
    FormatError::new(Fault::Malformed, location, problem)
}

#[cfg(test)]
thread_local! {
    /// How many documents this thread has parsed.
    pub(super) static PARSED: std::cell::Cell<usize> = const { std::cell::Cell::new(0) };
}

/// Parses a document whose root is an object.
pub(crate) fn parse(text: &[u8], limits: &Limits) -> Result<Object, FormatError> {
    #[cfg(test)]
    PARSED.set(PARSED.get() + 1);
    if value_bound(text) > MAX_VALUES {
        let problem = format!("JSON of more than {MAX_VALUES} values");
        return Err(FormatError::new(Fault::Limit, "", problem));
    }
    let mut lexer = SliceLexer::new(text);
    let mut parser = Parser { depth: 0, max_depth: limits.json_depth.min(MAX_DEPTH) };
    let parsed = lexer.exactly_one(Lex::ws_peek, |next, lexer| parser.value(next, lexer));
    let problem = match parsed {
        Ok(Json::Object(root)) => return Ok(root),
        Ok(_) => return Err(malformed("", "the JSON document is not an object")),
        Err(Refusal::Limit(problem)) => return Err(FormatError::new(Fault::Limit, "", problem)),
        Err(Refusal::Syntax(problem)) => problem,
    };
    let read = &text[..text.len() - lexer.as_slice().len()];
    let line = 1 + read.iter().filter(|b| **b == b'\n').count();
    let column = 1 + read.iter().rev().take_while(|b| **b != b'\n').count();
    Err(malformed(format!("line {line} column {column}"), format!("not valid JSON: {problem}")))
}

/// An upper bound of the number of values in a text, without allocating: one more than its commas
/// and opening brackets outside strings.
fn value_bound(text: &[u8]) -> usize {
    let (mut values, mut in_string, mut escaped) = (1, false, false);
    for &b in text {
        match b {
            _ if escaped => escaped = false,
            b'\\' => escaped = in_string,
            b'"' => in_string = !in_string,
            b',' | b'[' | b'{' if !in_string => values += 1,
            _ => {}
        }
    }
    values
}

/// Why a text is no document.
enum Refusal {
    Syntax(hifijson::Error),
    Limit(String),
}

impl<E: Into<hifijson::Error>> From<E> for Refusal {
    fn from(error: E) -> Self {
        Self::Syntax(error.into())
    }
}

struct Parser {
    depth: u32,
    max_depth: u32,
}

impl Parser {
    /// The value that begins with the byte `next`.
    fn value(&mut self, next: u8, lexer: &mut SliceLexer<'_>) -> Result<Json, Refusal> {
        Ok(match next {
            b'a'..=b'z' => match lexer.null_or_bool().ok_or(Expect::Value)? {
                Some(flag) => Json::Bool(flag),
                None => Json::Null,
            },
            b'0'..=b'9' | b'-' => Json::Number(lexer.num_string().validated()?.0.into()),
            b'"' => Json::String(lexer.discarded().str_string()?.into_owned()),
            b'[' => {
                let mut elements = Vec::new();
                self.inside(lexer, b']', |parser, next, lexer| {
                    elements.push(parser.value(next, lexer)?);
                    Ok(())
                })?;
                // A vector of one element has room for four: in documents of many lists of one
                // child that is most of the memory. To shrink long ones would copy much for little.
                if elements.len() < 4 {
                    elements.shrink_to_fit();
                }
                Json::Array(elements)
            }
            b'{' => {
                let mut members = Object::default();
                self.inside(lexer, b'}', |parser, next, lexer| {
                    lexer.expect(|_| Some(next), b'"').ok_or(Expect::String)?;
                    let name = lexer.str_string()?.into_owned();
                    lexer.expect(Lex::ws_peek, b':').ok_or(Expect::Colon)?;
                    let next = lexer.ws_peek().ok_or(Expect::Value)?;
                    members.insert(name, parser.value(next, lexer)?);
                    Ok(())
                })?;
                Json::Object(members)
            }
            _ => return Err(Expect::Value.into()),
        })
    }

    /// Reads the elements of an array or object, one level down, each by `read_element`.
    fn inside<'t>(
        &mut self,
        lexer: &mut SliceLexer<'t>,
        end: u8,
        mut read_element: impl FnMut(&mut Self, u8, &mut SliceLexer<'t>) -> Result<(), Refusal>,
    ) -> Result<(), Refusal> {
        self.depth += 1;
        if self.depth > self.max_depth {
            return Err(Refusal::Limit(format!("JSON nested deeper than {} levels", self.depth)));
        }
        let read =
            lexer.discarded().seq(end, Lex::ws_peek, |next, lexer| read_element(self, next, lexer));
        self.depth -= 1;
        read
    }
}

static NULL: Json = Json::Null;

impl Json {
    pub(crate) fn get(&self, key: &str) -> Option<&Self> {
        self.as_object()?.get(key)
    }
    pub(crate) fn get_mut(&mut self, key: &str) -> Option<&mut Self> {
        self.as_object_mut()?.get_mut(key)
    }
    pub(crate) fn as_str(&self) -> Option<&str> {
        if let Self::String(text) = self { Some(text) } else { None }
    }
    pub(crate) fn as_bool(&self) -> Option<bool> {
        if let Self::Bool(flag) = self { Some(*flag) } else { None }
    }
    /// A finite number.
    pub(crate) fn as_f64(&self) -> Option<f64> {
        let Self::Number(spelt) = self else { return None };
        spelt.parse().ok().filter(|number: &f64| number.is_finite())
    }
    /// A number without a fraction, however it is spelt.
    pub(crate) fn as_u64(&self) -> Option<u64> {
        let Self::Number(spelt) = self else { return None };
        // Below 2^53 doubles tell all whole numbers apart.
        let whole = |x: f64| (x >= 0.0 && x.fract() == 0.0 && x < 9e15).then_some(x as u64);
        spelt.parse().ok().or_else(|| self.as_f64().and_then(whole))
    }
    /// An index into one of a document's lists.
    pub(crate) fn as_index(&self) -> Option<usize> {
        self.as_u64().and_then(|i| usize::try_from(i).ok())
    }
    /// An array of exactly `N` numbers; the default for anything else.
    pub(crate) fn numbers<const N: usize>(&self, default: [f64; N]) -> [f64; N] {
        match self.list() {
            all if all.len() == N => std::array::from_fn(|i| all[i].as_f64().unwrap_or(default[i])),
            _ => default,
        }
    }
    pub(crate) fn as_array(&self) -> Option<&Vec<Self>> {
        if let Self::Array(elements) = self { Some(elements) } else { None }
    }
    pub(crate) fn as_array_mut(&mut self) -> Option<&mut Vec<Self>> {
        if let Self::Array(elements) = self { Some(elements) } else { None }
    }
    /// The elements of an array; none of anything else.
    pub(crate) fn list(&self) -> &[Self] {
        self.as_array().map_or(&[], Vec::as_slice)
    }
    pub(crate) fn as_object(&self) -> Option<&Object> {
        if let Self::Object(members) = self { Some(members) } else { None }
    }
    pub(crate) fn as_object_mut(&mut self) -> Option<&mut Object> {
        if let Self::Object(members) = self { Some(members) } else { None }
    }
    pub(crate) fn is_object(&self) -> bool {
        self.as_object().is_some()
    }
}

impl Object {
    /// The elements of the array `key`; none if there is no such array.
    pub(crate) fn list(&self, key: &str) -> &[Json] {
        self[key].list()
    }
    /// The elements of the array `key` that are objects, to be changed.
    pub(crate) fn objects_mut(&mut self, key: &str) -> impl Iterator<Item = &mut Object> {
        let elements = self.get_mut(key).and_then(Json::as_array_mut);
        elements.into_iter().flatten().filter_map(Json::as_object_mut)
    }
    /// Element `i` of the array `key`, if it is there and an object, to be changed.
    pub(crate) fn object_mut(&mut self, key: &str, i: usize) -> Option<&mut Object> {
        self.get_mut(key)?.as_array_mut()?.get_mut(i)?.as_object_mut()
    }
    /// The elements of the array `key` as objects, empty ones for others; none if there is no such
    /// array.
    pub(crate) fn entries(&self, key: &str) -> impl ExactSizeIterator<Item = &Object> {
        static EMPTY: std::sync::LazyLock<Object> = std::sync::LazyLock::new(Object::default);
        self.list(key).iter().map(|value| value.as_object().unwrap_or(&EMPTY))
    }
    /// Adds elements to the array `key`.
    pub(crate) fn append(&mut self, key: &str, values: Vec<Json>) {
        if values.is_empty() {
            return;
        }
        let all = self.entry(key.to_owned()).or_insert_with(|| Json::Array(Vec::new()));
        if let Json::Array(all) = all {
            all.extend(values);
        }
    }
    /// The member `key`, which must be a whole number if it is there.
    pub(crate) fn optional(&self, key: &str, location: &str) -> Result<Option<u64>, FormatError> {
        let wrong = || malformed(format!("{location}.{key}"), "must be a whole number");
        self.get(key).map(|value| value.as_u64().ok_or_else(wrong)).transpose()
    }
    /// The member `key`, a whole number that must be there.
    pub(crate) fn required(&self, key: &str, location: &str) -> Result<u64, FormatError> {
        self.optional(key, location)?.ok_or_else(|| malformed(location, format!("has no `{key}`")))
    }
    /// The extension `name`.
    pub(crate) fn extension(&self, name: &str) -> Option<&Object> {
        self.get("extensions")?.get(name)?.as_object()
    }
    /// Takes the extension `name` away, and `extensions` with the last one.
    pub(crate) fn remove_extension(&mut self, name: &str) {
        if let Some(all) = self.get_mut("extensions").and_then(Json::as_object_mut) {
            all.shift_remove(name);
            if all.is_empty() {
                self.shift_remove("extensions");
            }
        }
    }
}

impl Json {
    fn make_object(&mut self) -> &mut Object {
        if !self.is_object() {
            *self = Self::Object(Object::default());
        }
        self.as_object_mut().expect("it was just made one")
    }
}

impl Deref for Object {
    type Target = IndexMap<String, Json>;
    fn deref(&self) -> &Self::Target {
        &self.0
    }
}

impl DerefMut for Object {
    fn deref_mut(&mut self) -> &mut Self::Target {
        &mut self.0
    }
}

impl FromIterator<(String, Json)> for Object {
    fn from_iter<I: IntoIterator<Item = (String, Json)>>(members: I) -> Self {
        Self(members.into_iter().collect())
    }
}

/// Null for members that are not there.
impl Index<&str> for Object {
    type Output = Json;
    fn index(&self, key: &str) -> &Json {
        self.get(key).unwrap_or(&NULL)
    }
}

/// A member that is not there is made, as null.
impl IndexMut<&str> for Object {
    fn index_mut(&mut self, key: &str) -> &mut Json {
        self.entry(key.to_owned()).or_insert(Json::Null)
    }
}

/// Null for members that are not there, and of what is no object.
impl Index<&str> for Json {
    type Output = Self;
    fn index(&self, key: &str) -> &Self {
        self.get(key).unwrap_or(&NULL)
    }
}

/// What is no object becomes one; a member that is not there is made, as null.
impl IndexMut<&str> for Json {
    fn index_mut(&mut self, key: &str) -> &mut Self {
        &mut self.make_object()[key]
    }
}

/// Null for elements that are not there, and of what is no array.
impl Index<usize> for Json {
    type Output = Self;
    fn index(&self, i: usize) -> &Self {
        self.list().get(i).unwrap_or(&NULL)
    }
}

impl From<bool> for Json {
    fn from(flag: bool) -> Self {
        Self::Bool(flag)
    }
}

impl From<&str> for Json {
    fn from(text: &str) -> Self {
        Self::String(text.to_owned())
    }
}

impl From<String> for Json {
    fn from(text: String) -> Self {
        Self::String(text)
    }
}

macro_rules! from_whole {
    ($($whole:ty),*) => {$(
        impl From<$whole> for Json {
            fn from(number: $whole) -> Self {
                Self::Number(number.to_string().into())
            }
        }
    )*};
}
from_whole!(u32, u64, usize, i64);

/// The shortest spelling that means the same number; null if it is not finite.
#[cfg(feature = "gltf")]
impl From<f64> for Json {
    fn from(number: f64) -> Self {
        if !number.is_finite() {
            return Self::Null;
        }
        Self::Number(serde_json::to_string(&number).expect("a finite number").into())
    }
}

impl<T: Into<Json>> From<Option<T>> for Json {
    fn from(value: Option<T>) -> Self {
        value.map_or(Self::Null, T::into)
    }
}

impl<T: Into<Json>> From<Vec<T>> for Json {
    fn from(elements: Vec<T>) -> Self {
        elements.into_iter().collect()
    }
}

impl<T: Into<Json>, const N: usize> From<[T; N]> for Json {
    fn from(elements: [T; N]) -> Self {
        elements.into_iter().collect()
    }
}

impl<T: Into<Json>> FromIterator<T> for Json {
    fn from_iter<I: IntoIterator<Item = T>>(elements: I) -> Self {
        Self::Array(elements.into_iter().map(T::into).collect())
    }
}

/// One line; `{:#}` has a line for each member and element.
impl Display for Json {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        self.write(f, 0)
    }
}

/// As of [`Json`].
impl Display for Object {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        write_object(self, f, 0)
    }
}

impl Json {
    fn write(&self, f: &mut Formatter<'_>, depth: usize) -> fmt::Result {
        match self {
            Self::Null => f.write_str("null"),
            Self::Bool(flag) => write!(f, "{flag}"),
            Self::Number(spelt) => f.write_str(spelt),
            Self::String(text) => write_text(text, f),
            Self::Object(members) => write_object(members, f, depth),
            Self::Array(elements) => {
                write_all(f, ['[', ']'], depth, elements, |f, element| element.write(f, depth + 1))
            }
        }
    }
}

fn write_object(members: &Object, f: &mut Formatter<'_>, depth: usize) -> fmt::Result {
    write_all(f, ['{', '}'], depth, members.iter(), |f, (name, value)| {
        write_text(name, f)?;
        f.write_str(if f.alternate() { ": " } else { ":" })?;
        value.write(f, depth + 1)
    })
}

fn write_all<T>(
    f: &mut Formatter<'_>,
    [open, close]: [char; 2],
    depth: usize,
    all: impl IntoIterator<Item = T>,
    one: impl Fn(&mut Formatter<'_>, T) -> fmt::Result,
) -> fmt::Result {
    let line = |f: &mut Formatter<'_>, depth: usize| {
        if f.alternate() { write!(f, "\n{:1$}", "", 2 * depth) } else { Ok(()) }
    };
    f.write_char(open)?;
    let mut is_empty = true;
    for value in all {
        if !is_empty {
            f.write_char(',')?;
        }
        is_empty = false;
        line(f, depth + 1)?;
        one(f, value)?;
    }
    if !is_empty {
        line(f, depth)?;
    }
    f.write_char(close)
}

fn write_text(text: &str, f: &mut Formatter<'_>) -> fmt::Result {
    f.write_char('"')?;
    let mut unwritten = text;
    while let Some(special) = unwritten.find(|c: char| c < ' ' || c == '"' || c == '\\') {
        f.write_str(&unwritten[..special])?;
        match unwritten.as_bytes()[special] {
            b'\n' => f.write_str("\\n"),
            b'\r' => f.write_str("\\r"),
            b'\t' => f.write_str("\\t"),
            0x08 => f.write_str("\\b"),
            0x0c => f.write_str("\\f"),
            c if c < b' ' => write!(f, "\\u{c:04x}"),
            c => write!(f, "\\{}", char::from(c)),
        }?;
        unwritten = &unwritten[special + 1..];
    }
    f.write_str(unwritten)?;
    f.write_char('"')
}

#[cfg(test)]
#[path = "json_tests.rs"]
mod tests;
