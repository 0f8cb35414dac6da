//! Sessions, by number.

use lodc_web::{Session, Sessions, Status};
use std::cell::RefCell;

thread_local! {
    static SESSIONS: RefCell<Sessions> = const { RefCell::new(Sessions::new()) };
}

fn with<T>(number: u32, otherwise: T, act: impl FnOnce(&mut Session) -> T) -> T {
    SESSIONS.with_borrow_mut(|sessions| sessions.get(number).map_or(otherwise, act))
}

/// Opens a session; returns its number.
#[unsafe(no_mangle)]
pub extern "C" fn lodc_session() -> u32 {
    SESSIONS.with_borrow_mut(Sessions::open)
}

/// Closes a session.
#[unsafe(no_mangle)]
pub extern "C" fn lodc_close(session: u32) {
    SESSIONS.with_borrow_mut(|sessions| sessions.close(session));
}

/// Returns the address where the host writes the next `length` bytes of input; 0 without a session.
#[unsafe(no_mangle)]
pub extern "C" fn lodc_input(session: u32, length: usize) -> usize {
    with(session, 0, |s| s.input(length).as_mut_ptr() as usize)
}

/// Takes the input as a `.lodc` file; see `Session::open`. Returns a `Status`.
#[unsafe(no_mangle)]
pub extern "C" fn lodc_open(session: u32) -> u32 {
    with(session, Status::Failed, Session::open) as u32
}

/// Takes the input as the next bytes of a stream; see `Session::feed`. Returns a `Status`.
#[unsafe(no_mangle)]
pub extern "C" fn lodc_feed(session: u32) -> u32 {
    with(session, Status::Failed, Session::feed) as u32
}

/// Makes the mesh of a stream so far; see `Session::mesh`. Returns a `Status`.
#[unsafe(no_mangle)]
pub extern "C" fn lodc_mesh(session: u32) -> u32 {
    with(session, Status::Failed, Session::mesh) as u32
}

/// Returns the address of the output.
#[unsafe(no_mangle)]
pub extern "C" fn lodc_output(session: u32) -> usize {
    with(session, 0, |s| s.output().as_ptr() as usize)
}

/// Returns the number of bytes of the output.
#[unsafe(no_mangle)]
pub extern "C" fn lodc_output_length(session: u32) -> usize {
    with(session, 0, |s| s.output().len())
}
