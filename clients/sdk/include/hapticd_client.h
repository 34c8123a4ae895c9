// The C interface of libhapticd-client: a session with hapticd for languages that call C. C11, and
// C++.
//
// Every function returns a code, HAPTICD_OK or below 0, unless it says otherwise, and changes
// nothing when an argument makes no sense: null, not finite, out of range, a text without end.
// Nothing throws, ends the program or starts a thread. A session belongs to one thread at a time;
// sessions know nothing of each other. Call hapticd_poll() all the time, each frame or every 10 ms:
// the daemon takes the lease back after 2 s of silence.
//
// Structs begin with their size, which the caller sets to sizeof before each call. A later version
// only adds members at the end; a library fills as much as it is given, and a newer struct's
// members that it does not know with 0.
//
// Frames, units and the meaning of every number: state.proto, event.proto and PROTOCOL.md. Poses
// are a position x y z and a quaternion w x y z.
#pragma once

// NOLINTBEGIN(readability-identifier-naming): names as C has them

#include <stddef.h>
#include <stdint.h>

#ifdef __GNUC__
#pragma GCC visibility push(default)
#endif
#ifdef __cplusplus
extern "C" {
#endif

enum {
  HAPTICD_OK = 0,
  HAPTICD_INVALID = -1,       ///< an argument makes no sense, or the daemon found it malformed
  HAPTICD_SILENT = -2,        ///< the daemon does not answer; whether it obeyed is not known
  HAPTICD_REFUSED = -3,       ///< someone else has the lease, or the key does not permit it
  HAPTICD_OUT_OF_RANGE = -4,  ///< a value is outside its range
  HAPTICD_NOT_FOUND = -5,     ///< nothing has that name
  HAPTICD_WRONG_STATE = -6,   ///< not in this loop state, clock or device
  HAPTICD_BUSY = -7,          ///< a queue is full, or another session has the lease
  HAPTICD_FAILED = -8,        ///< tried and failed: memory, disk, device, an address or a key
  HAPTICD_LOST = -9,          ///< the run is done, but some of its States were lost on the way
  HAPTICD_UNSUPPORTED = -10   ///< the daemon is older than this library
};

/// Room in hapticd_state. Of more tools or strings the first ones are told.
enum { HAPTICD_MOST_TOOLS = 8, HAPTICD_MOST_STRINGS = 32 };

/// Longest texts, in bytes without the end. A longer one is HAPTICD_INVALID, and read no further.
enum { HAPTICD_MOST_NAME = 256, HAPTICD_MOST_SCENE = 4194000 };

typedef struct hapticd_session hapticd_session;

typedef struct hapticd_options {
  uint32_t size;
  uint32_t timeout_ms;   ///< for the daemon at the start and for each answer; 0: 5000
  const char* server;    ///< HOST:PORT; null: 127.0.0.1:47800
  const char* key_file;  ///< null: the daemon has no keys
} hapticd_options;

typedef struct hapticd_pose {
  double p_m[3];
  double q[4];  ///< norm in [0.5, 2]
} hapticd_pose;

typedef struct hapticd_run_result {
  uint32_t size;
  uint32_t missing_states;  ///< that were subscribed to and got lost
  uint64_t steps;           ///< ticks advanced; fewer than asked for where a fault came
  uint64_t next_tick;       ///< tick that would run next
  uint64_t held_inputs;     ///< ticks in which some scripted tool had no pose of its own
  uint8_t state_hash[32];   ///< over the States of all ticks since the scene began
} hapticd_run_result;

typedef struct hapticd_tool {
  int32_t tool_id;  ///< -1: not told
  uint32_t flags;   ///< bit f - 1: ToolFlag f
  double p_wh_m[3];
  double p_wg_m[3];
  float q_wh[4];
  float q_wg[4];
  float wrench_h_w[6];  ///< N and N m: what the device does to the hand
  float minimum_gap_m;
  uint32_t reserved;  ///< 0
} hapticd_tool;

typedef struct hapticd_string {
  int32_t string_index;  ///< -1: not told
  uint32_t phase;        ///< StringPhase
  float deflection_w_m[3];
  float lambda;
  float radius_m;
  uint32_t reserved;  ///< 0
} hapticd_string;

typedef struct hapticd_state {
  uint32_t size;
  uint32_t scene_id;
  uint64_t tick;
  uint64_t t_ns;
  int32_t loop_state;   ///< LoopState: 4 = engaged, 6 = fault
  int32_t cause;        ///< Cause
  uint32_t tool_count;  ///< there are; told are HAPTICD_MOST_TOOLS at most
  /// That are not asleep. Told are HAPTICD_MOST_STRINGS at most, and fewer than there are where a
  /// State had no room for them: the first entry with string_index -1 is the end.
  uint32_t string_count;
  hapticd_tool tools[HAPTICD_MOST_TOOLS];
  hapticd_string strings[HAPTICD_MOST_STRINGS];
} hapticd_state;

enum {
  HAPTICD_EVENT_TONE = 1,
  HAPTICD_EVENT_CONTACT = 2,
  HAPTICD_EVENT_STRING_RADIUS = 3,
  HAPTICD_EVENT_FAULT = 4,
  HAPTICD_EVENT_SCENE = 5,  ///< another scene plays
  HAPTICD_EVENT_LEASE = 6   ///< the lease has changed hands
};

/// Members that an event of its kind does not have are 0, an object's index and tool_id -1.
typedef struct hapticd_event {
  uint32_t size;
  int32_t kind;
  uint64_t t_ns;
  int64_t own_ns;    ///< t_ns on this machine's CLOCK_MONOTONIC; 0: not known, or virtual time
  uint64_t dropped;  ///< events that were not read in time, as of the last poll or run
  int32_t tool_id;
  uint32_t part_index;
  int32_t string_index;
  int32_t body_index;
  int32_t line_index;
  int32_t phase;    ///< of a contact: 1 begins, 2 ends; StringRadiusPhase
  int32_t cause;    ///< of a fault
  int32_t latched;  ///< 1: the fault begins
  float frequency_hz;
  float amplitude_m;  ///< of a tone; r_max_m of a radius
  float level;
  float lambda;
  float decay_s;
  float delta_m;
  float force_n;
  float normal_speed_m_per_s;
  float tangential_speed_m_per_s;
  float p_wc_m[3];
  float nhat_og_w[3];
  char message[257];  ///< of a fault, UTF-8; cut off after a whole character where it is longer
  char reserved[3];   ///< 0
} hapticd_event;

enum { HAPTICD_ENGAGE = 1, HAPTICD_DISENGAGE = 2, HAPTICD_STOP = 3, HAPTICD_CLEAR = 4 };

/// Version of the library, as in "0.1.0". Never null.
const char* hapticd_version(void);

/// Joins the daemon; options may be null. On failure *session is null.
int hapticd_open(const hapticd_options* options, hapticd_session** session);
/// Says goodbye and frees the session. Null does nothing.
void hapticd_close(hapticd_session* session);
/// What the last function of this session that failed had to say, in English; of null: what the
/// last hapticd_open() in this thread that failed had to say. Never null; valid until the next
/// call.
const char* hapticd_last_error(const hapticd_session* session);
/// Takes what has arrived and sends what is due. Waits for a datagram, wait_ms or 10 ms at most.
int hapticd_poll(hapticd_session* session, uint32_t wait_ms);

/// Takes the lease; holder has 64 bytes at most. HAPTICD_BUSY when another session has it.
int hapticd_acquire(hapticd_session* session, const char* holder);
/// The same, also from a session that has it. All are told the reason, 1 to 400 bytes. A run of its
/// steps ends with HAPTICD_REFUSED there, and force fades to zero.
int hapticd_take_over(hapticd_session* session, const char* holder, const char* reason);
/// Loads an installed scene by its name, or a scene as text where that has a brace or a line break.
/// Returns once it plays.
int hapticd_load_scene(hapticd_session* session, const char* scene);
/// Sets a live parameter to a number, or to 2 to 1024 numbers where it has so many; 7 are a pose.
/// It moves to its new value within 50 ms.
int hapticd_set(hapticd_session* session, const char* path, const double* values, size_t count);
/// The value of a live parameter: *count numbers, of which the first `capacity` are written. A
/// truth value is 0 or 1; HAPTICD_INVALID where it is a text.
int hapticd_get(hapticd_session* session, const char* path, double* values, size_t capacity,
                size_t* count);
/// Asks for the State of every divisor-th tick with its tools and strings; 0 ends it. Unread States
/// are forgotten.
int hapticd_subscribe(hapticd_session* session, uint32_t divisor);

/// Lockstep, with a daemon in virtual time: advances it by `steps` ticks, 1 to 1e9, while tool 0
/// follows the poses, one per tick; without more it holds the last one. Poses may be null where
/// pose_count is 0, and result where nobody wants it. Its States and events are unread afterwards,
/// behind those of before, all of them, however many; those of before make room. So it is where
/// the run fails, with what came until then. Nothing runs after a pose that the daemon refuses.
/// Waits as long as the daemon is there.
int hapticd_run(hapticd_session* session, uint64_t steps, const hapticd_pose* poses,
                size_t pose_count, hapticd_run_result* result);
/// Takes the oldest unread State. Returns 1, or 0 when there is none. Unread ones are kept, 16384
/// at most, or as many as the last run had; then the oldest makes room.
int hapticd_next_state(hapticd_session* session, hapticd_state* state);
/// Takes the oldest unread event. Returns 1, or 0 when there is none. Unread ones are kept, 65536
/// at most, or as many as the last run had; then the oldest makes room.
int hapticd_next_event(hapticd_session* session, hapticd_event* event);

/// The simulated hand plays an installed gesture `repeat` times, 0: until told otherwise. Null or
/// an empty name ends it.
int hapticd_play_gesture(hapticd_session* session, const char* gesture, uint32_t repeat);
/// HAPTICD_ENGAGE: force on. HAPTICD_DISENGAGE: off. HAPTICD_STOP: zero wrench at the next tick,
/// needs no lease. HAPTICD_CLEAR: leaves the stop or fault.
int hapticd_order(hapticd_session* session, int order);

#ifdef __cplusplus
}
#endif
#ifdef __GNUC__
#pragma GCC visibility pop
#endif
// NOLINTEND(readability-identifier-naming)
