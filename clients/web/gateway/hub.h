// The middle of the gateway: what is shown (a daemon, or a recording meanwhile) goes to all
// viewers, what they ask goes to where it belongs. It keeps what a late joiner needs, of both, and
// knows nothing of sockets. One thread calls everything. Not RT.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <string_view>

#include "clients/library/client_core.h"
#include "clients/web/gateway/page_lease.h"
#include "clients/web/gateway/viewer_queue.h"
#include "hapticd/v1/gateway.pb.h"

namespace hapticd::web {

/// Requests of a viewer that may be under way.
inline constexpr std::size_t kMaxUnderWay = 64;

/// Why a viewer is closed.
enum class CloseReason : std::uint8_t {
  kTooSlow,     ///< it does not keep up with what must not be lost
  kGarbage,     ///< it sent something that is not a PageRequest
  kUnfinished,  ///< a message of it did not end in time
  kGaveWay,     ///< another viewer needed its place
  kEnd,         ///< the gateway ends
};

/// What a viewer may do beside looking.
struct ViewerRights {
  bool control = false;
  bool steer = false;  ///< move and pause what is shown of a recording
};

/// How the hub reaches a viewer. Neither function calls back into the hub before it returns, but
/// for Hub::next().
struct ViewerPort {
  std::function<void()> wake;  ///< something waits in Hub::next()
  std::function<void(CloseReason)> close;
};

/// Takes what became of a request to the gateway itself.
using Answer = std::function<void(const v1::Result&)>;

/// Where the hub's requests go, and what it says of itself.
struct HubOptions {
  std::string version;
  double presentation_delay_s = 0.008;
  QueueLimits limits;
  /// Sends a request to the daemon; false: it cannot be reached, `done` is not called.
  std::function<bool(const v1::Item&, client::ResultHandler done)> call;
  /// Steers a recording.
  std::function<void(const v1::PagePlayback&)> steer;
  /// Shows the recording of that name, or with an empty one the daemon again; Hub::show() follows
  /// before the answer if it is done.
  std::function<void(const std::string& recording, Answer)> show;
  /// What can be shown.
  std::function<v1::Listing()> recordings;
  /// What a viewer asks of an experiment, with its answer; Hub::experiment() follows.
  std::function<v1::Result(ViewerId, bool control, const v1::PageExperiment&)> experiment;
  /// A viewer is gone.
  std::function<void(ViewerId)> gone;
  /// The daemon's clock now, ns; 0 = not known.
  std::function<std::int64_t()> daemon_now_ns;
};

/// That the daemon is shown.
[[nodiscard]] v1::PageShown daemon_shown();

/// What happened so far.
struct HubCounters {
  std::uint64_t viewers_ever = 0;
  std::uint64_t closed_slow = 0;
  std::uint64_t closed_garbage = 0;
  std::uint64_t closed_unfinished = 0;
  std::uint64_t gave_way = 0;
  std::uint64_t states = 0;          ///< of daemon and recordings
  std::uint64_t items = 0;           ///< of daemon and recordings
  std::uint64_t dropped_states = 0;  ///< of viewers that have gone; total_dropped() has all
  std::uint64_t requests = 0;
  std::uint64_t refused = 0;  ///< by the gateway
};

class Hub {
 public:
  explicit Hub(HubOptions options) : options_(std::move(options)) {}

  /// A viewer joins, and is welcomed.
  ViewerId add(ViewerRights rights, ViewerPort port);
  /// It is gone; what it held is given back.
  void remove(ViewerId viewer);
  /// Closes it, and counts why.
  void end(ViewerId viewer, CloseReason why);
  /// A message of a viewer.
  void take(ViewerId viewer, std::string_view message);
  /// The next message to a viewer, whole.
  [[nodiscard]] std::optional<std::string> next(ViewerId viewer);
  /// Closes all.
  void close_all();

  /// From the daemon. While a recording is shown only lease, recorder and link reach the viewers.
  void state(const v1::State& state);
  void item(const v1::Item& item);
  void session_ended();
  void link(const v1::PageLink& link);
  /// From a recording, while it is shown.
  void recorded_state(const v1::State& state);
  void recorded_item(const v1::Item& item);
  void playback(const v1::PagePlayback& playback);
  /// A screen of an experiment, which `owner` may answer.
  void experiment(const v1::ExperimentScreen& screen, ViewerId owner);
  /// From here on this is shown: all viewers are told, and told what they need of it.
  void show(const v1::PageShown& shown);

  [[nodiscard]] std::size_t viewers() const noexcept { return viewers_.size(); }
  [[nodiscard]] const HubCounters& counters() const noexcept { return counters_; }
  /// States that had to go, of all viewers there ever were.
  [[nodiscard]] std::uint64_t total_dropped() const;

 private:
  struct Viewer {
    ViewerRights rights;
    bool closing = false;
    std::size_t under_way = 0;
    ViewerPort port;
    ViewerQueue queue;
  };
  /// What a late joiner needs to know of a source.
  struct Newest {
    std::optional<v1::Item> scene;
    std::optional<v1::Item> fault;  ///< while it is latched
    SharedBody state;               ///< a recording that is paused sends no other
  };

  [[nodiscard]] bool shows_recording() const noexcept {
    return shown_.source() == v1::PAGE_SOURCE_RECORDING;
  }
  [[nodiscard]] const Newest& newest() const noexcept {
    return shows_recording() ? recording_ : daemon_;
  }
  void put(Viewer& viewer, SharedBody body);
  void put_all(const SharedBody& body);
  void put_state(Viewer& viewer);
  void put_item(ViewerId id, Viewer& viewer, const v1::Item& item);
  void put_experiment(ViewerId id, Viewer& viewer);
  void close(Viewer& viewer, CloseReason reason);
  static void remember(const v1::Item& item, Newest& newest);
  void remember_daemon(const v1::Item& item);
  void tell_fault();
  void welcome(ViewerId id, Viewer& viewer);
  void call(ViewerId id, Viewer& viewer, std::uint64_t request_id, const v1::Item& item);
  void show(ViewerId id, const Viewer& viewer, std::uint64_t request_id,
            const v1::PageShow& wanted);
  void steer(ViewerId id, const Viewer& viewer, std::uint64_t request_id,
             const v1::PagePlayback& wanted);
  void list(ViewerId id, const Viewer& viewer, std::uint64_t request_id);
  void refuse(ViewerId id, std::uint64_t request_id, v1::Result why);
  void answer(ViewerId id, std::uint64_t request_id, v1::Result result);
  void give_back_lease();

  HubOptions options_;
  std::map<ViewerId, Viewer> viewers_;
  ViewerId last_id_ = 0;
  PageLease desk_;
  HubCounters counters_;
  v1::PageShown shown_ = daemon_shown();
  Newest daemon_;
  Newest recording_;
  std::optional<v1::Item> lease_;
  std::optional<v1::Item> recorder_;
  std::optional<v1::PageLink> link_;
  std::optional<v1::PagePlayback> playback_;
  std::optional<v1::ExperimentScreen> experiment_;  ///< the newest
  ViewerId experimenter_ = 0;                       ///< who may answer it
};

}  // namespace hapticd::web
