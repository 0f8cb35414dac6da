//! A value that is made when it is first asked for and then kept, of a type that its owner need not
//! know.

use std::any::Any;
use std::fmt;
use std::sync::{Arc, OnceLock};

/// A place for one value of a type that its owner need not know. Copies made after it was filled
/// share it.
#[derive(Clone, Default)]
pub(crate) struct Known(OnceLock<Arc<dyn Any + Send + Sync>>);

impl Known {
    /// The value; made, and kept, the first time.
    ///
    /// # Errors
    /// If it is not known and cannot be made. Nothing is kept then.
    pub(crate) fn or_make<T: Any + Send + Sync, E>(
        &self,
        make: impl FnOnce() -> Result<T, E>,
    ) -> Result<&T, E> {
        let known = match self.0.get() {
            Some(known) => known,
            None => {
                let made = make()?;
                self.0.get_or_init(|| Arc::new(made))
            }
        };
        Ok(known.downcast_ref().expect("one reader, one type"))
    }
}

impl fmt::Debug for Known {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(if self.0.get().is_some() { "known" } else { "unknown" })
    }
}
