//! The one decoder of an instance of this module: a host makes an instance for each file, and
//! gives its memory back with it. A `Status` is 0 if the output is the result, 1 if it is a line
//! that says what is wrong.

use lodc_web::Decoder;
use std::cell::RefCell;

thread_local! {
    static DECODER: RefCell<Option<Decoder>> = const { RefCell::new(None) };
}

fn with<T>(act: impl FnOnce(&mut Decoder) -> T) -> T {
    DECODER.with_borrow_mut(|decoder| act(decoder.get_or_insert_default()))
}

/// Returns the address where the host writes the next `length` bytes of input. It holds until the
/// next call.
#[unsafe(no_mangle)]
pub extern "C" fn lodc_input(length: usize) -> usize {
    with(|d| d.input(length).as_mut_ptr() as usize)
}

/// Takes the input as a `.lodc` file; see `Decoder::open`. Returns a `Status`.
#[cfg(feature = "file")]
#[unsafe(no_mangle)]
pub extern "C" fn lodc_open() -> u32 {
    with(Decoder::open) as u32
}

/// Takes the input as the next bytes of a stream; see `Decoder::feed`. Returns a `Status`.
#[cfg(feature = "stream")]
#[unsafe(no_mangle)]
pub extern "C" fn lodc_feed() -> u32 {
    with(Decoder::feed) as u32
}

/// Makes a message of what has come of a stream; see `Decoder::grown`. Returns a `Status`.
#[cfg(feature = "stream")]
#[unsafe(no_mangle)]
pub extern "C" fn lodc_grown() -> u32 {
    with(Decoder::grown) as u32
}

/// Returns the address of the output of the last call, which holds until the next one.
#[unsafe(no_mangle)]
pub extern "C" fn lodc_output() -> usize {
    with(|d| d.output().as_ptr() as usize)
}

/// Returns the number of bytes of the output.
#[unsafe(no_mangle)]
pub extern "C" fn lodc_output_length() -> usize {
    with(|d| d.output().len())
}
