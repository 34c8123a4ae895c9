//! libhapticd-client for Rust: its C functions, and a struct around them that returns Result. The meaning of every function and field is
//! in hapticd_client.h.
use std::ffi::{CStr, CString};
use std::mem::{size_of, zeroed};
use std::os::raw::{c_char, c_int};
use std::ptr::null_mut;

pub const EVENT_TONE: i32 = 1;

#[repr(C)]
#[derive(Clone, Copy)]
pub struct Pose {
    pub p_m: [f64; 3],
    pub q: [f64; 4],
}

#[repr(C)]
#[derive(Clone, Copy)]
pub struct RunResult {
    size: u32,
    pub missing_states: u32,
    pub steps: u64,
    pub next_tick: u64,
    pub held_inputs: u64,
    pub state_hash: [u8; 32],
}

#[repr(C)]
#[derive(Clone, Copy)]
pub struct Tool {
    pub tool_id: i32,
    pub flags: u32,
    pub p_wh_m: [f64; 3],
    pub p_wg_m: [f64; 3],
    pub q_wh: [f32; 4],
    pub q_wg: [f32; 4],
    pub wrench_h_w: [f32; 6],
    pub minimum_gap_m: f32,
    reserved: u32,
}

#[repr(C)]
#[derive(Clone, Copy)]
pub struct StringState {
    pub string_index: i32,
    pub phase: u32,
    pub deflection_w_m: [f32; 3],
    pub lambda: f32,
    pub radius_m: f32,
    reserved: u32,
}

#[repr(C)]
#[derive(Clone, Copy)]
pub struct State {
    size: u32,
    pub scene_id: u32,
    pub tick: u64,
    pub t_ns: u64,
    pub loop_state: i32,
    pub cause: i32,
    pub tool_count: u32,
    pub string_count: u32,
    pub tools: [Tool; 8],
    pub strings: [StringState; 32],
}

#[repr(C)]
#[derive(Clone, Copy)]
pub struct Event {
    size: u32,
    pub kind: i32,
    pub t_ns: u64,
    pub own_ns: i64,
    pub dropped: u64,
    pub tool_id: i32,
    pub part_index: u32,
    pub string_index: i32,
    pub body_index: i32,
    pub line_index: i32,
    pub phase: i32,
    pub cause: i32,
    pub latched: i32,
    pub frequency_hz: f32,
    pub amplitude_m: f32,
    pub level: f32,
    pub lambda: f32,
    pub decay_s: f32,
    pub delta_m: f32,
    pub force_n: f32,
    pub normal_speed_m_per_s: f32,
    pub tangential_speed_m_per_s: f32,
    pub p_wc_m: [f32; 3],
    pub nhat_og_w: [f32; 3],
    pub message: [c_char; 257],
    reserved: [c_char; 3],
}

#[repr(C)]
struct Options {
    size: u32,
    timeout_ms: u32,
    server: *const c_char,
    key_file: *const c_char,
}

enum Native {}

#[link(name = "hapticd-client")]
extern "C" {
    fn hapticd_open(options: *const Options, session: *mut *mut Native) -> c_int;
    fn hapticd_close(session: *mut Native);
    fn hapticd_last_error(session: *const Native) -> *const c_char;
    fn hapticd_poll(session: *mut Native, wait_ms: u32) -> c_int;
    fn hapticd_acquire(session: *mut Native, holder: *const c_char) -> c_int;
    fn hapticd_load_scene(session: *mut Native, scene: *const c_char) -> c_int;
    fn hapticd_set(session: *mut Native, path: *const c_char, values: *const f64, count: usize) -> c_int;
    fn hapticd_get(session: *mut Native, path: *const c_char, values: *mut f64, capacity: usize, count: *mut usize) -> c_int;
    fn hapticd_subscribe(session: *mut Native, divisor: u32) -> c_int;
    fn hapticd_run(session: *mut Native, steps: u64, poses: *const Pose, count: usize, result: *mut RunResult) -> c_int;
    fn hapticd_next_state(session: *mut Native, state: *mut State) -> c_int;
    fn hapticd_next_event(session: *mut Native, event: *mut Event) -> c_int;
    fn hapticd_play_gesture(session: *mut Native, gesture: *const c_char, repeat: u32) -> c_int;
    fn hapticd_order(session: *mut Native, order: c_int) -> c_int;
}

/// The code of hapticd_client.h, and what it is about.
#[derive(Debug)]
pub struct Error {
    pub code: i32,
    pub message: String,
}

/// A session with a daemon, for one thread; dropping it ends it.
pub struct Session {
    native: *mut Native,
}

fn text(text: &str) -> Result<CString, Error> {
    CString::new(text).map_err(|_| Error { code: -1, message: "a text has a zero in it".into() })
}

fn checked(native: *const Native, code: c_int) -> Result<c_int, Error> {
    if code >= 0 {
        return Ok(code);
    }
    // SAFETY: it is never null, and copied before the next call.
    let message = unsafe { CStr::from_ptr(hapticd_last_error(native)) };
    Err(Error { code, message: message.to_string_lossy().into_owned() })
}

// SAFETY of all calls below: `native` is what hapticd_open() gave until it is dropped; texts and arrays outlive the call; the structs are
// those of hapticd_client.h, whose numbers may all be zero.
impl Session {
    pub fn open(server: &str) -> Result<Session, Error> {
        let server = text(server)?;
        let options = Options { size: size_of::<Options>() as u32, timeout_ms: 0, server: server.as_ptr(), key_file: std::ptr::null() };
        let mut native = null_mut();
        checked(null_mut(), unsafe { hapticd_open(&options, &mut native) })?;
        Ok(Session { native })
    }

    pub fn poll(&mut self, wait_ms: u32) -> Result<(), Error> {
        checked(self.native, unsafe { hapticd_poll(self.native, wait_ms) }).map(drop)
    }

    pub fn acquire(&mut self, holder: &str) -> Result<(), Error> {
        let holder = text(holder)?;
        checked(self.native, unsafe { hapticd_acquire(self.native, holder.as_ptr()) }).map(drop)
    }

    pub fn load_scene(&mut self, scene: &str) -> Result<(), Error> {
        let scene = text(scene)?;
        checked(self.native, unsafe { hapticd_load_scene(self.native, scene.as_ptr()) }).map(drop)
    }

    pub fn set(&mut self, path: &str, values: &[f64]) -> Result<(), Error> {
        let path = text(path)?;
        checked(self.native, unsafe { hapticd_set(self.native, path.as_ptr(), values.as_ptr(), values.len()) }).map(drop)
    }

    pub fn get(&mut self, path: &str) -> Result<Vec<f64>, Error> {
        let path = text(path)?;
        let mut values = vec![0.0; 1024];
        let mut count = 0;
        checked(self.native, unsafe { hapticd_get(self.native, path.as_ptr(), values.as_mut_ptr(), values.len(), &mut count) })?;
        values.truncate(count);
        Ok(values)
    }

    pub fn subscribe(&mut self, divisor: u32) -> Result<(), Error> {
        checked(self.native, unsafe { hapticd_subscribe(self.native, divisor) }).map(drop)
    }

    pub fn run(&mut self, steps: u64, poses: &[Pose]) -> Result<RunResult, Error> {
        let mut result: RunResult = unsafe { zeroed() };
        result.size = size_of::<RunResult>() as u32;
        checked(self.native, unsafe { hapticd_run(self.native, steps, poses.as_ptr(), poses.len(), &mut result) })?;
        Ok(result)
    }

    /// The oldest unread State.
    pub fn next_state(&mut self) -> Result<Option<State>, Error> {
        let mut state: State = unsafe { zeroed() };
        state.size = size_of::<State>() as u32;
        let code = checked(self.native, unsafe { hapticd_next_state(self.native, &mut state) })?;
        Ok((code == 1).then_some(state))
    }

    /// The oldest unread event.
    pub fn next_event(&mut self) -> Result<Option<Event>, Error> {
        let mut event: Event = unsafe { zeroed() };
        event.size = size_of::<Event>() as u32;
        let code = checked(self.native, unsafe { hapticd_next_event(self.native, &mut event) })?;
        Ok((code == 1).then_some(event))
    }

    pub fn play_gesture(&mut self, gesture: &str, repeat: u32) -> Result<(), Error> {
        let gesture = text(gesture)?;
        checked(self.native, unsafe { hapticd_play_gesture(self.native, gesture.as_ptr(), repeat) }).map(drop)
    }

    /// 1: engage, 2: disengage, 3: stop, 4: clear.
    pub fn order(&mut self, order: i32) -> Result<(), Error> {
        checked(self.native, unsafe { hapticd_order(self.native, order) }).map(drop)
    }
}

impl Drop for Session {
    fn drop(&mut self) {
        unsafe { hapticd_close(self.native) }
    }
}
