// SPDX-License-Identifier: MIT
//! A bus of twins: bus/library.h in Rust.

use std::ffi::{c_char, c_int, c_uint, c_void, CStr, CString};

const MESSAGE: usize = 1280;
const FRAME: usize = 2048;

extern "C" {
    fn ectwin_bus_open(count: c_int, words: *const *const c_char, now_ns: u64, message: *mut c_char) -> *mut c_void;
    fn ectwin_bus_close(bus: *mut c_void);
    fn ectwin_bus_frame(bus: *mut c_void, end: c_uint, frame: *const u8, length: usize, now_ns: u64);
    fn ectwin_bus_reply(bus: *mut c_void, end: *mut c_uint, frame: *mut u8, room: usize) -> usize;
    fn ectwin_bus_run(bus: *mut c_void, now_ns: u64) -> u64;
    fn ectwin_bus_get(bus: *const c_void, slave: usize, name: *const c_char, text: *mut c_char, room: usize) -> c_int;
}

/// One thread at a time; not `Sync`, as it holds a raw pointer.
pub struct Bus(*mut c_void);

impl Bus {
    /// Options of `ectwin with` and devices. The error is the reason, in one line.
    pub fn open(words: &[String], now_ns: u64) -> Result<Self, String> {
        let texts: Vec<CString> = words.iter().map(|word| CString::new(word.as_str()).expect("no zero byte")).collect();
        let pointers: Vec<*const c_char> = texts.iter().map(|text| text.as_ptr()).collect();
        let mut message = [0 as c_char; MESSAGE];
        // SAFETY: the words live during the call, the message has the room that the library demands.
        let bus = unsafe { ectwin_bus_open(pointers.len() as c_int, pointers.as_ptr(), now_ns, message.as_mut_ptr()) };
        if bus.is_null() {
            // SAFETY: the library has written a text with its zero.
            return Err(unsafe { CStr::from_ptr(message.as_ptr()) }.to_string_lossy().into_owned());
        }
        Ok(Self(bus))
    }

    /// Passes a frame in at the first twin.
    pub fn frame(&mut self, frame: &[u8], now_ns: u64) {
        // SAFETY: the bus is open, and the frame is only read during the call.
        unsafe { ectwin_bus_frame(self.0, 0, frame.as_ptr(), frame.len(), now_ns) }
    }

    /// The next frame that has left the bus.
    pub fn reply(&mut self) -> Option<Vec<u8>> {
        let mut frame = vec![0; FRAME];
        let mut end = 0;
        // SAFETY: the bus is open, and the library writes at most as much as the room.
        let length = unsafe { ectwin_bus_reply(self.0, &mut end, frame.as_mut_ptr(), frame.len()) };
        frame.truncate(length);
        (length > 0).then_some(frame)
    }

    /// Lets time pass.
    pub fn run(&mut self, now_ns: u64) {
        // SAFETY: the bus is open.
        unsafe { ectwin_bus_run(self.0, now_ns) };
    }

    /// A signal as text. Slaves count from 1.
    pub fn get(&self, slave: usize, name: &str) -> Option<String> {
        let name = CString::new(name).ok()?;
        let mut text = [0 as c_char; MESSAGE];
        // SAFETY: the bus is open, and the library writes at most as much as the room.
        let result = unsafe { ectwin_bus_get(self.0, slave, name.as_ptr(), text.as_mut_ptr(), text.len()) };
        // SAFETY: on success the library has written a text with its zero.
        (result == 0).then(|| unsafe { CStr::from_ptr(text.as_ptr()) }.to_string_lossy().into_owned())
    }
}

impl Drop for Bus {
    fn drop(&mut self) {
        // SAFETY: nothing uses the bus after this.
        unsafe { ectwin_bus_close(self.0) }
    }
}
