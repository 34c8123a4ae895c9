// See session_stream.h.
#include "clients/sdk/session_stream.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <stdexcept>
#include <utility>

#include "clients/library/endpoint.h"
#include "clients/library/named_key.h"
#include "clients/sdk/unread_queue.h"

namespace hapticd::client {
namespace {

/// The daemon queues 4096 poses of a tool; a longer path is run in pieces.
constexpr std::size_t kPosesPerPiece = 2048;
constexpr std::uint64_t kMostSteps = 1'000'000'000;
/// States that one run collects: a kilobyte or more each.
constexpr std::uint64_t kMostRunStates = 1'000'000;
/// A large scene is built in this time.
constexpr std::chrono::seconds kSceneTimeout{60};
/// How long States may come after the Result of their run; the daemon sends each once.
constexpr std::chrono::milliseconds kStragglers{500};
/// A run ends when it is done, or when the session ends because the daemon is silent.
constexpr std::chrono::hours kRunTimeout{24 * 365};

SessionOptions checked(const SessionOptions& options) {
  if (options.keep_states < 1 || options.keep_events < 1) {
    throw std::invalid_argument("keep_states, keep_events: 1 at least");
  }
  return options;
}

Client open_client(const SessionOptions& options, ClientHandlers handlers) {
  const Endpoint server = parse_endpoint(options.server);
  return Client(server.host, server.port, std::move(handlers),
                named_key(options.key_file, options.role));
}

v1::Pose message_of(const Pose& pose) {
  v1::Pose message;
  for (const double x : pose.p_m) message.add_p_m(x);
  for (const double q : pose.q) message.add_q(q);
  return message;
}

bool usable(const Pose& pose) {
  const double norm =
      std::hypot(std::hypot(pose.q[0], pose.q[1]), std::hypot(pose.q[2], pose.q[3]));
  const auto finite = [](double x) { return std::isfinite(x); };
  return std::all_of(std::begin(pose.p_m), std::end(pose.p_m), finite) && norm >= 0.5 &&
         norm <= 2.0;
}

void refuse_bad_run(std::uint64_t steps, const std::vector<Pose>& poses) {
  if (steps < 1 || steps > kMostSteps) {
    throw Error(v1::RESULT_CODE_OUT_OF_RANGE, "steps", "steps: not in [1, 1e9]. Nothing was run.");
  }
  const auto bad = std::find_if_not(poses.begin(), poses.end(), usable);
  if (bad == poses.end()) return;
  throw Error(
      v1::RESULT_CODE_INVALID, "poses",
      "pose " + std::to_string(bad - poses.begin()) +
          " is not finite, or its quaternion has a norm outside [0.5, 2]. Nothing was run.");
}

}  // namespace

SessionStream::SessionStream(const SessionOptions& options)
    : options_(checked(options)), client_(open_client(options, handlers())), controller_(client_) {
  if (client_.connect(options.timeout)) return;
  throw Error(v1::RESULT_CODE_UNSPECIFIED, "",
              "no daemon answers at " + options.server +
                  ". Start hapticd, or name where it listens; if it has keys, give one of them.");
}

ClientHandlers SessionStream::handlers() {
  ClientHandlers handlers;
  handlers.item = [this](const v1::Item& item) { take_item(item); };
  handlers.state = [this](const v1::State& state) { take_state(state); };
  handlers.pose_refused = [this](const v1::Result& result) { refused_poses_.push_back(result); };
  return handlers;
}

void SessionStream::take_item(const v1::Item& item) {
  if (running_ != nullptr) {
    running_->events.push_back(item);
    return;
  }
  if (events_.size() >= options_.keep_events) {
    events_.pop_front();
    ++dropped_events_;
  }
  events_.push_back(item);
}

void SessionStream::take_state(const v1::State& state) {
  if (running_ != nullptr) {
    running_->states.push_back(state);
    return;
  }
  if (states_.size() >= options_.keep_states) {
    states_.pop_front();
    ++dropped_states_;
  }
  states_.push_back(state);
}

void SessionStream::check(const v1::Result& result) {
  const std::vector<v1::Result> refused = std::exchange(refused_poses_, {});
  const v1::Result& worst = refused.empty() ? result : refused.front();
  if (worst.code() != v1::RESULT_CODE_OK) throw Error(worst.code(), worst.path(), worst.message());
}

v1::Result SessionStream::request(v1::Item item) {
  return request_within(options_.timeout, std::move(item));
}

v1::Result SessionStream::request_within(std::chrono::nanoseconds timeout, v1::Item item) {
  v1::Result result = controller_.call(std::move(item), timeout);
  check(result);
  return result;
}

void SessionStream::acquire(const std::string& holder) {
  check(controller_.acquire(holder, options_.timeout));
}

void SessionStream::subscribe(const v1::Item& item) {
  states_.clear();
  request(item);
  divisor_ = item.subscribe().divisor();
}

const v1::SceneInfo& SessionStream::scene() const {
  if (client_.scene().has_value()) return *client_.scene();
  throw Error(v1::RESULT_CODE_UNSPECIFIED, "",
              "the session with " + options_.server + " is over, and no other has begun yet");
}

void SessionStream::load_scene(v1::Item item) {
  const std::uint32_t before = scene().scene_id();
  request_within(std::max<std::chrono::nanoseconds>(kSceneTimeout, options_.timeout),
                 std::move(item));
  const auto plays = [&] {
    return client_.scene().has_value() && client_.scene()->scene_id() != before;
  };
  if (client_.poll_until(plays, options_.timeout)) return;
  throw Error(v1::RESULT_CODE_UNSPECIFIED, "",
              "the daemon took the scene and has not told of it since");
}

RunResult SessionStream::run(std::uint64_t steps, const std::vector<Pose>& poses,
                             std::uint32_t tool_id) {
  refuse_bad_run(steps, poses);
  if (divisor_ != 0 && steps / divisor_ > kMostRunStates) {
    throw Error(
        v1::RESULT_CODE_OUT_OF_RANGE, "steps",
        "a run collects a million States at most. Run in pieces, or subscribe with a larger "
        "divisor.");
  }
  // Found out within the time for an answer; a run itself may take any time.
  ping();

  RunResult result;
  running_ = &result;
  try {
    advance(steps, poses, tool_id, result);
    collect_states(result);
  } catch (...) {
    running_ = nullptr;
    keep_unread(result);
    throw;
  }
  running_ = nullptr;
  return result;
}

void SessionStream::keep_unread(RunResult& result) {
  dropped_states_ += append_unread(std::move(result.states), options_.keep_states, states_);
  dropped_events_ += append_unread(std::move(result.events), options_.keep_events, events_);
}

void SessionStream::ping() {
  v1::Item item;
  item.mutable_ping();
  request(std::move(item));
}

void SessionStream::advance(std::uint64_t steps, const std::vector<Pose>& poses,
                            std::uint32_t tool_id, RunResult& result) {
  std::uint64_t left = steps;
  std::size_t at = 0;
  while (true) {
    const std::size_t rest = poses.size() - at;
    const std::uint64_t piece = rest > 0 ? std::min<std::uint64_t>(left, kPosesPerPiece) : left;
    const std::size_t end = at + static_cast<std::size_t>(std::min<std::uint64_t>(piece, rest));
    if (at < end) {
      for (; at < end; ++at) controller_.pose(tool_id, message_of(poses[at]));
      // Answers come in order: what the daemon has against the poses is known before they are run.
      ping();
    }
    const std::uint64_t done = result.steps;
    take_answer(controller_.run(piece, kRunTimeout), piece, result);
    left -= piece;
    if (left == 0 || result.steps - done < piece) return;
  }
}

void SessionStream::take_answer(const v1::Result& answer, std::uint64_t piece, RunResult& result) {
  check(answer);
  const v1::RunResult& run = answer.run();
  if (run.steps() > piece || run.next_tick() < result.steps + run.steps()) {
    throw Error(v1::RESULT_CODE_FAILED, "run",
                "the daemon says that it ran " + std::to_string(run.steps()) + " ticks of " +
                    std::to_string(piece) + " and that tick " + std::to_string(run.next_tick()) +
                    " is next, which cannot be. Use a daemon of this version.");
  }
  result.steps += run.steps();
  result.held_inputs += run.held_inputs();
  result.next_tick = run.next_tick();
  result.state_hash = run.state_hash();
}

void SessionStream::collect_states(RunResult& result) {
  if (divisor_ == 0) return;
  const std::uint64_t begin = result.next_tick - result.steps;
  const std::uint64_t before_first = (divisor_ - begin % divisor_) % divisor_;
  if (before_first >= result.steps) return;
  const std::uint64_t first = begin + before_first;
  const std::uint64_t count = (result.steps - before_first - 1) / divisor_ + 1;
  const std::uint64_t last = first + (count - 1) * divisor_;
  client_.poll_until([&] { return !result.states.empty() && result.states.back().tick() >= last; },
                     kStragglers);
  // Ticks of a State grow; those of before the run, if any, were under way when it began.
  std::vector<v1::State>& states = result.states;
  states.erase(states.begin(),
               std::find_if(states.begin(), states.end(),
                            [&](const v1::State& state) { return state.tick() >= first; }));
  std::size_t at = 0;
  for (std::uint64_t k = 0; k < count; ++k) {
    const std::uint64_t tick = first + k * divisor_;
    while (at < states.size() && states[at].tick() < tick) ++at;
    if (at >= states.size() || states[at].tick() != tick) result.missing.push_back(tick);
  }
}

Unread SessionStream::poll(std::chrono::nanoseconds wait) {
  client_.poll(wait);
  return unread();
}

Unread SessionStream::unread() const {
  return {states_.size(), events_.size(), dropped_states_, dropped_events_};
}

std::optional<v1::State> SessionStream::next_state() {
  if (states_.empty()) return std::nullopt;
  std::optional<v1::State> state = std::move(states_.front());
  states_.pop_front();
  return state;
}

std::optional<v1::Item> SessionStream::next_event() {
  if (events_.empty()) return std::nullopt;
  std::optional<v1::Item> event = std::move(events_.front());
  events_.pop_front();
  return event;
}

std::optional<std::int64_t> SessionStream::own_time_ns(std::uint64_t t_ns) const {
  const bool real =
      client_.scene().has_value() && client_.scene()->clock() == v1::CLOCK_MODE_REALTIME;
  if (!real || !client_.clock().known()) return std::nullopt;
  const std::int64_t offset_ns = client_.clock().at(monotonic_now_ns()).offset_ns;
  return static_cast<std::int64_t>(t_ns) - offset_ns;
}

}  // namespace hapticd::client
