// See hapticd_client.h: the functions, each around one of hapticd::client::Session, with every
// argument judged first and every exception made a code.
#include <hapticd/client/session.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <deque>
#include <iterator>
#include <new>
#include <stdexcept>

#include "clients/sdk/c_structs.h"
#include "clients/sdk/unread_queue.h"

using namespace hapticd;

namespace {

constexpr std::size_t kErrorBytes = 512;
constexpr std::uint32_t kDefaultTimeout_ms = 5000;
constexpr std::size_t kMostHolder = 64;
constexpr std::size_t kMostReason = 400;
constexpr std::size_t kMostValues = 1024;
constexpr std::uint64_t kMostSteps = 1'000'000'000;

using ErrorText = std::array<char, kErrorBytes>;

/// Of this thread's hapticd_open().
thread_local ErrorText open_error{};

void say(const char* text, ErrorText& error) {
  const std::size_t length = client::whole_characters(text, error.size() - 1);
  std::memcpy(error.data(), text, length);
  error[length] = '\0';
}

/// An argument that makes no sense.
struct Bad {
  const char* what;
};

int code_of(v1::ResultCode code) {
  switch (code) {
    case v1::RESULT_CODE_UNSPECIFIED:
      return HAPTICD_SILENT;
    case v1::RESULT_CODE_OK:
      return HAPTICD_OK;
    case v1::RESULT_CODE_UNSUPPORTED:
      return HAPTICD_UNSUPPORTED;
    case v1::RESULT_CODE_NOT_OWNER:
    case v1::RESULT_CODE_NOT_PERMITTED:
      return HAPTICD_REFUSED;
    case v1::RESULT_CODE_INVALID:
      return HAPTICD_INVALID;
    case v1::RESULT_CODE_OUT_OF_RANGE:
      return HAPTICD_OUT_OF_RANGE;
    case v1::RESULT_CODE_NOT_FOUND:
      return HAPTICD_NOT_FOUND;
    case v1::RESULT_CODE_WRONG_STATE:
      return HAPTICD_WRONG_STATE;
    case v1::RESULT_CODE_BUSY:
      return HAPTICD_BUSY;
    default:
      return HAPTICD_FAILED;
  }
}

/// What `act` returns, or the code of what it throws, which is said in `error`.
template <typename Act>
int guarded(ErrorText& error, const Act& act) noexcept {
  try {
    return act();
  } catch (const Bad& bad) {
    say(bad.what, error);
    return HAPTICD_INVALID;
  } catch (const client::Error& refused) {
    say(refused.what(), error);
    return code_of(refused.code());
  } catch (const std::invalid_argument& bad) {
    say(bad.what(), error);
    return HAPTICD_INVALID;
  } catch (const std::exception& failed) {
    say(failed.what(), error);
    return HAPTICD_FAILED;
  } catch (...) {
    say("something unknown went wrong", error);
    return HAPTICD_FAILED;
  }
}

/// The text, of which no more than `most` bytes and its end are read.
std::string text_of(const char* text, std::size_t most, const char* otherwise) {
  if (text == nullptr) throw Bad{otherwise};
  const std::size_t length = strnlen(text, most + 1);
  if (length > most) throw Bad{otherwise};
  return {text, length};
}

client::SessionOptions options_of(const hapticd_options* options) {
  client::SessionOptions made;
  if (options == nullptr) return made;
  if (!client::is_large_enough(options)) throw Bad{"options: set size to sizeof(hapticd_options)"};
  made.timeout = std::chrono::milliseconds(options->timeout_ms != 0 ? options->timeout_ms
                                                                    : kDefaultTimeout_ms);
  if (options->server != nullptr) {
    made.server = text_of(options->server, HAPTICD_MOST_NAME, "server: 256 bytes at most");
  }
  if (options->key_file != nullptr) {
    made.key_file = text_of(options->key_file, 4096, "key_file: 4096 bytes at most");
  }
  return made;
}

client::Pose pose_of(const hapticd_pose& pose) {
  client::Pose made;
  std::copy(std::begin(pose.p_m), std::end(pose.p_m), std::begin(made.p_m));
  std::copy(std::begin(pose.q), std::end(pose.q), std::begin(made.q));
  return made;
}

std::vector<double> numbers_of(const client::Value& value) {
  if (const auto* number = std::get_if<double>(&value.data)) return {*number};
  if (const auto* flag = std::get_if<bool>(&value.data)) return {*flag ? 1.0 : 0.0};
  if (const auto* numbers = std::get_if<std::vector<double>>(&value.data)) return *numbers;
  throw Bad{"path: its value is a text"};
}

hapticd_run_result c_result(const client::RunResult& result) {
  hapticd_run_result made{};
  made.steps = result.steps;
  made.next_tick = result.next_tick;
  made.held_inputs = result.held_inputs;
  made.missing_states = static_cast<std::uint32_t>(result.missing.size());
  std::memcpy(made.state_hash, result.state_hash.data(),
              std::min(sizeof made.state_hash, result.state_hash.size()));
  return made;
}

}  // namespace

/// A session, and what a run has left to be read before what came later.
// NOLINTNEXTLINE(readability-identifier-naming): its name in C
struct hapticd_session {
  client::Session session;
  std::deque<v1::State> states;
  std::deque<v1::Item> events;
  std::uint64_t dropped_by_session = 0;  ///< events, as of the last hapticd_poll()
  std::uint64_t dropped_here = 0;        ///< events
  ErrorText error{};

  explicit hapticd_session(const client::SessionOptions& options) : session(options) {}

  /// What is unread so far, so that what a run has can be put behind it.
  void set_aside() {
    client::RunResult unread;
    while (std::optional<v1::State> state = session.next_state()) {
      unread.states.push_back(std::move(*state));
    }
    while (std::optional<v1::Item> event = session.next_event()) {
      unread.events.push_back(std::move(*event));
    }
    append(unread);
  }
  /// What was unread before makes room for it.
  void append(client::RunResult& come) {
    const client::SessionOptions kept;
    client::append_unread(std::move(come.states), kept.keep_states, states);
    dropped_here += client::append_unread(std::move(come.events), kept.keep_events, events);
  }
  std::optional<v1::State> next_state() {
    if (states.empty()) return session.next_state();
    std::optional<v1::State> state = std::move(states.front());
    states.pop_front();
    return state;
  }
  std::optional<v1::Item> next_event() {
    if (events.empty()) return session.next_event();
    std::optional<v1::Item> event = std::move(events.front());
    events.pop_front();
    return event;
  }
};

namespace {

/// As guarded(), for a session that may be null.
template <typename Act>
int with(hapticd_session* session, const Act& act) noexcept {
  if (session == nullptr) return HAPTICD_INVALID;
  return guarded(session->error, [&] { return act(*session); });
}

int run(hapticd_session& session, std::uint64_t steps, const std::vector<client::Pose>& poses,
        hapticd_run_result* result) {
  session.set_aside();
  client::RunResult done = session.session.run(steps, poses);
  session.append(done);
  if (result != nullptr) client::hand_over(c_result(done), result);
  if (done.missing.empty()) return HAPTICD_OK;
  say("States of the run were lost on the way. Subscribe with a larger divisor.", session.error);
  return HAPTICD_LOST;
}

}  // namespace

const char* hapticd_version(void) { return client::library_version(); }

int hapticd_open(const hapticd_options* options, hapticd_session** session) {
  return guarded(open_error, [&]() -> int {
    if (session == nullptr) throw Bad{"session: give the address of a pointer"};
    *session = nullptr;
    *session = new hapticd_session(options_of(options));
    return HAPTICD_OK;
  });
}

void hapticd_close(hapticd_session* session) { delete session; }

const char* hapticd_last_error(const hapticd_session* session) {
  return session != nullptr ? session->error.data() : open_error.data();
}

int hapticd_poll(hapticd_session* session, uint32_t wait_ms) {
  return with(session, [&](hapticd_session& open) {
    open.dropped_by_session = open.session.poll(std::chrono::milliseconds(wait_ms)).dropped_events;
    return HAPTICD_OK;
  });
}

int hapticd_acquire(hapticd_session* session, const char* holder) {
  return with(session, [&](hapticd_session& open) {
    open.session.acquire(text_of(holder, kMostHolder, "holder: a text of 64 bytes at most"));
    return HAPTICD_OK;
  });
}

int hapticd_take_over(hapticd_session* session, const char* holder, const char* reason) {
  return with(session, [&](hapticd_session& open) {
    v1::Item item;
    item.mutable_acquire()->set_holder(
        text_of(holder, kMostHolder, "holder: a text of 64 bytes at most"));
    item.mutable_acquire()->set_take_over(
        text_of(reason, kMostReason, "reason: a text of 1 to 400 bytes"));
    open.session.request(std::move(item));
    return HAPTICD_OK;
  });
}

int hapticd_load_scene(hapticd_session* session, const char* scene) {
  return with(session, [&](hapticd_session& open) {
    open.session.load_scene(
        text_of(scene, HAPTICD_MOST_SCENE, "scene: a name, or a scene as text"));
    return HAPTICD_OK;
  });
}

int hapticd_set(hapticd_session* session, const char* path, const double* values, size_t count) {
  return with(session, [&](hapticd_session& open) {
    const std::string name = text_of(path, HAPTICD_MOST_NAME, "path: a text of 256 bytes at most");
    if (values == nullptr || count < 1 || count > kMostValues) throw Bad{"values: 1 to 1024"};
    const std::vector<double> numbers(values, values + count);
    if (!std::all_of(numbers.begin(), numbers.end(), [](double x) { return std::isfinite(x); })) {
      throw Bad{"values: not finite"};
    }
    open.session.set(name, count == 1 ? client::Value(values[0]) : client::Value(numbers));
    return HAPTICD_OK;
  });
}

int hapticd_get(hapticd_session* session, const char* path, double* values, size_t capacity,
                size_t* count) {
  return with(session, [&](hapticd_session& open) {
    const std::string name = text_of(path, HAPTICD_MOST_NAME, "path: a text of 256 bytes at most");
    if (count == nullptr || (values == nullptr && capacity > 0)) throw Bad{"values, count: null"};
    const std::vector<double> numbers = numbers_of(open.session.get(name));
    *count = numbers.size();
    std::copy_n(numbers.begin(), std::min(capacity, numbers.size()), values);
    return HAPTICD_OK;
  });
}

int hapticd_subscribe(hapticd_session* session, uint32_t divisor) {
  return with(session, [&](hapticd_session& open) {
    open.session.subscribe(divisor, {v1::SECTION_TOOLS, v1::SECTION_STRINGS});
    open.states.clear();
    return HAPTICD_OK;
  });
}

int hapticd_run(hapticd_session* session, uint64_t steps, const hapticd_pose* poses,
                size_t pose_count, hapticd_run_result* result) {
  return with(session, [&](hapticd_session& open) {
    if (steps < 1 || steps > kMostSteps) throw Bad{"steps: 1 to 1e9"};
    if (poses == nullptr && pose_count > 0) throw Bad{"poses: null"};
    if (result != nullptr && !client::is_large_enough(result)) {
      throw Bad{"result: set size to sizeof(hapticd_run_result)"};
    }
    std::vector<client::Pose> path;
    std::transform(poses, poses + std::min<std::uint64_t>(pose_count, steps),
                   std::back_inserter(path), pose_of);
    return run(open, steps, path, result);
  });
}

int hapticd_next_state(hapticd_session* session, hapticd_state* state) {
  return with(session, [&](hapticd_session& open) {
    if (!client::is_large_enough(state)) throw Bad{"state: set size to sizeof(hapticd_state)"};
    const std::optional<v1::State> next = open.next_state();
    if (!next.has_value()) return 0;
    client::hand_over(client::c_state(*next), state);
    return 1;
  });
}

int hapticd_next_event(hapticd_session* session, hapticd_event* event) {
  return with(session, [&](hapticd_session& open) {
    if (!client::is_large_enough(event)) throw Bad{"event: set size to sizeof(hapticd_event)"};
    while (const std::optional<v1::Item> next = open.next_event()) {
      if (!client::is_c_event(*next)) continue;
      hapticd_event made = client::c_event(*next);
      if (made.t_ns != 0) made.own_ns = open.session.own_time_ns(made.t_ns).value_or(0);
      made.dropped = open.dropped_by_session + open.dropped_here;
      client::hand_over(made, event);
      return 1;
    }
    return 0;
  });
}

int hapticd_play_gesture(hapticd_session* session, const char* gesture, uint32_t repeat) {
  return with(session, [&](hapticd_session& open) {
    open.session.play_gesture(
        gesture == nullptr ? std::string()
                           : text_of(gesture, HAPTICD_MOST_SCENE, "gesture: a name, or a text"),
        repeat);
    return HAPTICD_OK;
  });
}

int hapticd_order(hapticd_session* session, int order) {
  return with(session, [&](hapticd_session& open) {
    switch (order) {
      case HAPTICD_ENGAGE:
        open.session.engage();
        return HAPTICD_OK;
      case HAPTICD_DISENGAGE:
        open.session.disengage();
        return HAPTICD_OK;
      case HAPTICD_STOP:
        open.session.stop();
        return HAPTICD_OK;
      case HAPTICD_CLEAR:
        open.session.clear();
        return HAPTICD_OK;
      default:
        throw Bad{"order: HAPTICD_ENGAGE, _DISENGAGE, _STOP or _CLEAR"};
    }
  });
}
