// A session with hapticd, for what a script does: control it, step it, hear it. Blocking: a request
// is a function that returns once the daemon has answered, and throws Error when it refused.
//
// No thread is started. States and events arrive while a function of the session runs, so poll()
// has to be called all the time: the daemon takes the lease back after 2 s of silence, and ends the
// session after 10 s. A session belongs to one thread at a time; sessions know nothing of each
// other. When the daemon was restarted, the session joins anew and asks for the same States; the
// lease and the scene are then those of the new daemon.
//
// Frames, units and the meaning of every field: the .proto files and PROTOCOL.md.
#pragma once

#include <hapticd/client/error.h>
#include <hapticd/client/messages.h>
#include <hapticd/client/value.h>
#include <hapticd/v1/stream.pb.h>

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#pragma GCC visibility push(default)
namespace hapticd::client {

/// Behind a Session; no part of the interface.
class SessionStream;

inline namespace abi_0 {

/// Version of the library, as in "0.1.0".
[[nodiscard]] const char* library_version() noexcept;

/// Where the daemon is, and what of its stream is kept until it is read.
struct SessionOptions {
  std::string server = "127.0.0.1:47800";  ///< HOST:PORT, [V6]:PORT, HOST or :PORT
  std::string key_file;                    ///< empty: the daemon has no keys
  std::string role;                        ///< view or control; empty: the key's own
  /// How long to wait for the daemon at the start, and for each answer. A scene has a minute in any
  /// case, and run() waits as long as the daemon is there.
  std::chrono::milliseconds timeout{5000};
  std::size_t keep_states = 16384;  ///< unread States; the oldest makes room. At least 1
  std::size_t keep_events = 65536;  ///< unread events; the oldest makes room. At least 1
};

/// X_DH, where the handle of a scripted device is: position, and a unit quaternion w x y z.
struct Pose {
  double p_m[3] = {0.0, 0.0, 0.0};
  double q[4] = {1.0, 0.0, 0.0, 0.0};
};

/// What a run in lockstep did.
struct RunResult {
  std::uint64_t steps = 0;        ///< ticks advanced; fewer than asked for where a fault came
  std::uint64_t next_tick = 0;    ///< the tick that would run next
  std::uint64_t held_inputs = 0;  ///< ticks in which some scripted tool had no pose of its own
  std::string state_hash;         ///< 32 bytes: over the States of all ticks since the scene began
  std::vector<v1::State> states;  ///< those of its ticks that were subscribed to, in order
  std::vector<v1::Item> events;   ///< what happened in it, in order, none missing
  std::vector<std::uint64_t> missing;  ///< ticks of States that were subscribed to and got lost
};

/// What waits to be read, and what was not read in time since the session began.
struct Unread {
  std::size_t states = 0;
  std::size_t events = 0;
  std::uint64_t dropped_states = 0;
  std::uint64_t dropped_events = 0;
};

class Session {
 public:
  /// Joins the daemon. Throws Error when it does not answer within the time, and
  /// std::invalid_argument or std::runtime_error when an option makes no sense (keep_states or
  /// keep_events is 0, say), the address does not exist or the key cannot be read. `messages` is
  /// left as it is: where the library has others than the program was compiled with, Error
  /// UNSUPPORTED says so.
  explicit Session(const SessionOptions& options = {}, std::uint64_t messages = kMessages);
  /// Says goodbye, without waiting; the lease ends.
  ~Session();
  Session(const Session&) = delete;
  Session& operator=(const Session&) = delete;
  Session(Session&& other) noexcept;
  Session& operator=(Session&& other) noexcept;

  /// Takes the lease under the name `holder`, 64 bytes at most: who holds it controls. BUSY when
  /// another session does; request() with Acquire.take_over takes it from that one.
  void acquire(const std::string& holder);
  /// Loads an installed scene by its name, or a scene as text where that has a brace or a line
  /// break; returns once it plays. Needs the lease.
  void load_scene(const std::string& scene);
  /// Sets a live parameter; a number moves to its new value within 50 ms. Needs the lease.
  void set(const std::string& path, const Value& value);
  /// Sets several, all or none. 1 to 64.
  void set(const std::vector<std::pair<std::string, Value>>& values);
  /// The value of one live parameter.
  [[nodiscard]] Value get(const std::string& path);
  /// The values of those that `paths` name, with [*] for every index; without any, of all.
  [[nodiscard]] std::map<std::string, Value> values(const std::vector<std::string>& paths = {});
  /// Asks for the State of every divisor-th tick, with these sections, or else tools, strings and
  /// contacts; 0 ends it. Unread States of before are forgotten.
  void subscribe(std::uint32_t divisor, const std::vector<v1::Section>& sections = {});

  /// Lockstep, with a daemon in virtual time: advances it by `steps` ticks while the scripted tool
  /// follows `poses`, one per tick from the next tick on; without more poses it holds the last one.
  /// Poses beyond `steps` are not sent. Needs the lease. Before anything runs, Error OUT_OF_RANGE
  /// when `steps` is not in [1, 1e9] or gives more than a million States, and INVALID when a pose
  /// is not finite or its quaternion has a norm outside [0.5, 2]. Poses go 2048 at a time, and the
  /// ticks of those that the daemon refuses do not run. The States and events of a run that fails
  /// are unread afterwards, those that came, all of them.
  RunResult run(std::uint64_t steps, const std::vector<Pose>& poses = {},
                std::uint32_t tool_id = 0);
  /// Takes what has arrived and sends what is due; waits for a datagram, `wait` or 10 ms at most.
  Unread poll(std::chrono::nanoseconds wait = std::chrono::milliseconds(10));
  /// The oldest unread State, if there is one. They come in order; some may be lost.
  [[nodiscard]] std::optional<v1::State> next_state();
  /// The oldest unread event, if there is one: tones, contacts, radii, faults, and what becomes of
  /// scene, lease and recorder. Each comes once, in order, and none is lost on the way.
  [[nodiscard]] std::optional<v1::Item> next_event();
  /// The scene that plays, every default filled in, with its live parameters, rate and clock.
  [[nodiscard]] const v1::SceneInfo& scene() const;
  /// When the instant `t_ns` of an event or State is on this machine's CLOCK_MONOTONIC, in ns.
  /// Present an event 8 ms after it. Empty before the first exchange and in virtual time.
  [[nodiscard]] std::optional<std::int64_t> own_time_ns(std::uint64_t t_ns) const;

  /// The simulated hand plays an installed gesture, or one as text where that has a brace or a line
  /// break; `repeat` 0: until told otherwise. An empty name ends it. Needs the lease.
  void play_gesture(const std::string& gesture, std::uint32_t repeat = 1);
  /// Force on, from zero in 200 ms. Needs the lease.
  void engage();
  /// Force to zero in 50 ms. Needs the lease.
  void disengage();
  /// Zero wrench at the next tick, latched until clear(). Needs no lease.
  void stop();
  /// Leaves FAULT once its cause is gone. Needs the lease.
  void clear();
  /// Starts or stops a recording, or writes the last 60 s; returns once that is done, with the
  /// file's path on the daemon's machine. `file` is its name in the daemon's folder of recordings;
  /// empty: one made from the time. Needs the lease.
  std::string record(v1::RecordMode mode, const std::string& file = {});

  /// Sends any request under the lease and waits for its answer.
  v1::Result request(v1::Item item);

 private:
  std::unique_ptr<SessionStream> stream_;
};

}  // namespace abi_0
}  // namespace hapticd::client
#pragma GCC visibility pop
