// What stands behind a Session: the client, the lease, and what has arrived and is not read yet.
// One thread. Not RT.
#pragma once

#include <hapticd/client/session.h>

#include <cstdint>
#include <deque>
#include <optional>
#include <string>
#include <vector>

#include "clients/library/client.h"
#include "clients/library/controller.h"

namespace hapticd::client {

class SessionStream {
 public:
  /// As Session's constructor.
  explicit SessionStream(const SessionOptions& options);

  /// Sends a request under the lease; throws Error unless its Result is OK, and for poses that were
  /// refused before it.
  v1::Result request(v1::Item item);
  /// The same with another time to wait for the Result.
  v1::Result request_within(std::chrono::nanoseconds timeout, v1::Item item);
  void acquire(const std::string& holder);
  void subscribe(const v1::Item& item);
  [[nodiscard]] const v1::SceneInfo& scene() const;
  void load_scene(v1::Item item);
  RunResult run(std::uint64_t steps, const std::vector<Pose>& poses, std::uint32_t tool_id);
  Unread poll(std::chrono::nanoseconds wait);
  std::optional<v1::State> next_state();
  std::optional<v1::Item> next_event();
  [[nodiscard]] std::optional<std::int64_t> own_time_ns(std::uint64_t t_ns) const;
  [[nodiscard]] Unread unread() const;

 private:
  ClientHandlers handlers();
  void take_item(const v1::Item& item);
  void take_state(const v1::State& state);
  void check(const v1::Result& result);
  /// Throws Error unless the daemon answers within the time, and for poses that were refused
  /// before.
  void ping();
  /// Advances by `steps` along the poses, in pieces that the daemon's queue holds.
  void advance(std::uint64_t steps, const std::vector<Pose>& poses, std::uint32_t tool_id,
               RunResult& result);
  /// Adds the answer to a Run of `piece` steps to the result; throws Error when it cannot be true.
  void take_answer(const v1::Result& answer, std::uint64_t piece, RunResult& result);
  /// What a run that failed has collected is unread.
  void keep_unread(RunResult& result);
  /// Waits for States that are still under way, and moves those of the run into its result.
  void collect_states(RunResult& result);

  SessionOptions options_;
  std::deque<v1::State> states_;
  std::deque<v1::Item> events_;
  std::uint64_t dropped_states_ = 0;
  std::uint64_t dropped_events_ = 0;
  std::vector<v1::Result> refused_poses_;
  std::uint32_t divisor_ = 0;
  RunResult* running_ = nullptr;  ///< takes what arrives, while a run is under way
  Client client_;
  Controller controller_;
};

}  // namespace hapticd::client
