// See stop_road.h.
#include "server/stop_road/stop_road.h"

#include <system_error>

#include "core/rt/monotonic_clock.h"
#include "core/rt/thread_role.h"
#include "server/haptic_loop/thread_policy.h"

namespace hapticd {
namespace {

/// The thread waits no longer than this, ns: it sees Clears, and its end.
constexpr std::int64_t kLook_ns = 20'000'000;
/// What a turn may take begins anew after this, ns.
constexpr std::int64_t kTurn_ns = 1'000'000;
/// Datagrams read in a turn, where a call that reads counts as kCallCost of them, and answers, at
/// most. More: a flood takes more of a processor from all threads but the loop's; fewer: a true
/// Stop among junk is lost more often.
constexpr int kReadPerTurn = 128;
constexpr int kCallCost = 3;
constexpr int kAnswersPerTurn = 32;

StopSocket bound_socket(const StopRoadOptions& options) {
  try {
    return StopSocket(options.host, options.port);
  } catch (const std::system_error& refused) {
    if (!options.elsewhere || refused.code() != std::errc::address_in_use) throw;
  }
  return StopSocket(options.host, 0);
}

}  // namespace

StopRoad::StopRoad(const StopRoadOptions& options, StopLine& line)
    : socket_(bound_socket(options)), judge_(options.rules, line) {}

StopRoad::~StopRoad() {
  ended_.store(true);
  if (thread_.joinable()) thread_.join();
}

void StopRoad::start() {
  thread_ = std::thread([this] { run(); });
  // What the machine refuses it has refused the loop too, which says so.
  static_cast<void>(make_fifo(thread_, kLoopPriority - 1));
}

void StopRoad::run() noexcept {
  name_thread("stop");
  begin_role(ThreadRole::kStop);
  while (!ended_.load(std::memory_order_relaxed)) {
    socket_.wait(kLook_ns);
    const std::int64_t now_ns = monotonic_now_ns();
    if (now_ns - turn_.begun_ns >= kTurn_ns) turn_ = {now_ns, kReadPerTurn, kAnswersPerTurn};
    judge_.look(now_ns);
    take();
    if (turn_.reads <= 0) sleep_until(turn_.begun_ns + kTurn_ns);
  }
}

/// Takes what is there, as far as the turn allows.
void StopRoad::take() noexcept {
  std::size_t came = StopSocket::kBatch;
  while (came == StopSocket::kBatch && turn_.reads > 0) {
    came = socket_.read();
    turn_.reads -= static_cast<int>(came) + kCallCost;
    const std::int64_t now_ns = monotonic_now_ns();
    for (std::size_t k = 0; k < came; ++k) {
      const auto answer = judge_.receive(socket_.datagram(k), socket_.peer(k), now_ns);
      if (!answer) continue;
      if (--turn_.answers < 0 || !socket_.answer(k, *answer)) judge_.note_unanswered();
    }
  }
}

}  // namespace hapticd
