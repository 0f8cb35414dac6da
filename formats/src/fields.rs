//! Values one after another, as a manifest has them (docs/FORMAT.md, section 4).
//!
//! Written by hand, since `serde` makes more code of it than the decoder of a browser has otherwise.

/// A value that a manifest may have.
pub(crate) trait Field: Sized {
    /// Appends its bytes.
    fn put(&self, out: &mut Vec<u8>);
    /// Takes it off the front; none if bytes are missing or cannot be one.
    fn take(bytes: &mut &[u8]) -> Option<Self>;
}

/// Makes a type of named fields a [`Field`]: the fields in their order.
macro_rules! fields {
    ($type:ty { $($field:ident),* $(,)? }) => {
        impl crate::fields::Field for $type {
            fn put(&self, out: &mut Vec<u8>) {
                $(self.$field.put(out);)*
            }
            fn take(bytes: &mut &[u8]) -> Option<Self> {
                Some(Self { $($field: crate::fields::Field::take(bytes)?),* })
            }
        }
    };
}
pub(crate) use fields;

/// Returns the bytes of a value.
pub(crate) fn to_bytes(value: &impl Field) -> Vec<u8> {
    let mut out = Vec::new();
    value.put(&mut out);
    out
}

/// Takes so many bytes off the front.
fn take_bytes<'a>(bytes: &mut &'a [u8], length: usize) -> Option<&'a [u8]> {
    let (taken, rest) = bytes.split_at_checked(length)?;
    *bytes = rest;
    Some(taken)
}

macro_rules! numbers {
    ($($type:ty),*) => {$(
        impl Field for $type {
            fn put(&self, out: &mut Vec<u8>) {
                out.extend_from_slice(&self.to_le_bytes());
            }
            fn take(bytes: &mut &[u8]) -> Option<Self> {
                let taken = take_bytes(bytes, size_of::<Self>())?;
                Some(Self::from_le_bytes(taken.try_into().ok()?))
            }
        }
    )*};
}
numbers!(u8, u32, u64, u128, f64);

impl Field for bool {
    fn put(&self, out: &mut Vec<u8>) {
        u8::from(*self).put(out);
    }
    fn take(bytes: &mut &[u8]) -> Option<Self> {
        match u8::take(bytes)? {
            0 => Some(false),
            1 => Some(true),
            _ => None,
        }
    }
}

impl Field for String {
    fn put(&self, out: &mut Vec<u8>) {
        (self.len() as u64).put(out);
        out.extend_from_slice(self.as_bytes());
    }
    fn take(bytes: &mut &[u8]) -> Option<Self> {
        let length = usize::try_from(u64::take(bytes)?).ok()?;
        Some(str::from_utf8(take_bytes(bytes, length)?).ok()?.to_owned())
    }
}

impl<T: Field> Field for Vec<T> {
    fn put(&self, out: &mut Vec<u8>) {
        (self.len() as u64).put(out);
        self.iter().for_each(|entry| entry.put(out));
    }
    fn take(bytes: &mut &[u8]) -> Option<Self> {
        // Each entry takes a byte at least, so that no count can make it longer than the bytes.
        (0..u64::take(bytes)?).map(|_| T::take(bytes)).collect()
    }
}

impl<T: Field> Field for Option<T> {
    fn put(&self, out: &mut Vec<u8>) {
        self.is_some().put(out);
        self.iter().for_each(|value| value.put(out));
    }
    fn take(bytes: &mut &[u8]) -> Option<Self> {
        if bool::take(bytes)? { T::take(bytes).map(Some) } else { Some(None) }
    }
}

impl<A: Field, B: Field> Field for (A, B) {
    fn put(&self, out: &mut Vec<u8>) {
        self.0.put(out);
        self.1.put(out);
    }
    fn take(bytes: &mut &[u8]) -> Option<Self> {
        Some((A::take(bytes)?, B::take(bytes)?))
    }
}

/// A value with the number of its bytes (u64) in front. Bytes behind its known fields belong to
/// later versions.
pub(crate) struct Record<T>(pub(crate) T);

impl<T> std::ops::Deref for Record<T> {
    type Target = T;

    fn deref(&self) -> &T {
        &self.0
    }
}

impl<T: Field> Field for Record<T> {
    fn put(&self, out: &mut Vec<u8>) {
        let bytes = to_bytes(&self.0);
        (bytes.len() as u64).put(out);
        out.extend_from_slice(&bytes);
    }
    fn take(bytes: &mut &[u8]) -> Option<Self> {
        let length = usize::try_from(u64::take(bytes)?).ok()?;
        T::take(&mut take_bytes(bytes, length)?).map(Self)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[derive(PartialEq, Debug)]
    struct Later {
        known: u32,
        name: String,
        added: Vec<u64>,
    }
    fields!(Later { known, name, added });

    #[derive(PartialEq, Debug)]
    struct Known {
        known: u32,
        name: String,
    }
    fields!(Known { known, name });

    #[test]
    fn fields_of_later_versions_are_passed_over() {
        let later = |known| Later { known, name: "n".to_owned(), added: vec![7; 3] };
        let bytes = to_bytes(&vec![Record(later(1)), Record(later(2))]);
        let mut rest = &bytes[..];
        let read = Vec::<Record<Known>>::take(&mut rest).expect("records of a later version");
        assert_eq!((read.len(), rest), (2, &[][..]));
        assert_eq!(read[1].0, Known { known: 2, name: "n".to_owned() });
        // A number of records, then the length of the first, then its fields.
        assert_eq!(
            bytes[..24],
            [2, 0, 0, 0, 0, 0, 0, 0, 45, 0, 0, 0, 0, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0]
        );
    }

    #[test]
    fn what_ends_too_early_or_cannot_be_is_refused() {
        let bytes = to_bytes(&Record(Known { known: 1, name: "name".to_owned() }));
        for cut in 0..8 {
            let mut shorter = bytes.clone();
            shorter[0] -= 1 + cut;
            assert!(Record::<Known>::take(&mut &shorter[..]).is_none(), "{cut}");
            assert!(Record::<Known>::take(&mut &bytes[..bytes.len() - 1 - cut as usize]).is_none());
        }
        assert_eq!(<Option<u8> as Field>::take(&mut &[2, 0][..]), None);
        assert_eq!(Vec::<u8>::take(&mut &[255; 20][..]), None);
        assert_eq!(String::take(&mut &[1, 0, 0, 0, 0, 0, 0, 0, 255][..]), None);
    }
}
