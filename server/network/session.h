// One client's session as the server keeps it. Plain data; what happens to it is in sessions.h and
// request_queue.h. Not RT.
#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "proto/wire/channel.h"
#include "proto/wire/hello.h"
#include "server/network/address.h"
#include "server/network/encoded_states.h"
#include "server/network/item_flow.h"
#include "server/network/server_host.h"
#include "server/network/state_flow.h"
#include "server/network/time_budget.h"

namespace hapticd {

/// Requests of one session that wait for their turn; the next is answered BUSY. Half of what may be
/// unacknowledged, so that their Results at once do not end the session.
inline constexpr std::size_t kMaxWaitingRequests = 512;
/// Bytes of them: one scene as text, and as much again of all others.
inline constexpr std::size_t kMaxWaitingBytes = 2 * wire::kBlobBytes;
/// Stops and Run{STOP}s of one session that the host has not answered; the next is answered BUSY.
inline constexpr std::size_t kMaxOvertaking = 64;

/// Shortest time between two requests of one session that look at files, ns.
inline constexpr std::int64_t kDearPeriod_ns = 10 * wire::kMillisecond_ns;

/// A request that waits for its turn.
struct WaitingRequest {
  std::uint64_t item = 0;
  std::size_t bytes = 0;
  v1::Item body;
};

/// The request that is being carried out.
struct CurrentRequest {
  std::uint64_t item = 0;
  bool is_pose_batch = false;
  bool is_run_of_steps = false;
  bool at_host = false;  ///< passed on and not answered
};

enum class Phase : std::uint8_t {
  kOpen,
  kLeaving,  ///< our Bye is the last Item: repeated until the time is over
  kLeft,     ///< the client's Bye came: acknowledged until the time is over
  kGone,     ///< to be removed
};

struct Session {
  Session(std::uint64_t serial_number, const Address& from, std::uint32_t number)
      : serial(serial_number), address(from), channel(wire::Side::kServer, number) {}

  std::uint64_t serial;
  Address address;
  wire::Channel channel;
  wire::Role role = wire::Role::kControl;  ///< of the key it was opened with; PLAIN may control
  Phase phase = Phase::kOpen;
  bool asked_control = false;          ///< it has made a request that needs the right to control
  bool pumping = false;                ///< pump() is on the stack
  bool may_cost = false;               ///< its next request may cost much: its turn among sessions
  std::optional<noise::KeyId> key_id;  ///< of its key; none: PLAIN
  std::string key_name;  ///< of its key; empty: it came without, or with view.key or control.key
  wire::ClockEcho clock;
  std::int64_t heard_ns = 0;        ///< last valid datagram
  std::int64_t asked_ns = 0;        ///< last Item of the client
  std::int64_t phase_since_ns = 0;  ///< beginning of kLeaving and kLeft
  std::int64_t phase_until_ns = 0;  ///< end of them

  std::deque<WaitingRequest> waiting;
  std::size_t waiting_bytes = 0;
  std::optional<CurrentRequest> current;
  std::vector<std::uint64_t> overtaking;  ///< at the host, beside `current`
  /// Results of those, held until the Run of steps they end is answered.
  std::vector<std::pair<std::uint64_t, v1::Result>> held_results;
  std::int64_t dear_due_ns = 0;  ///< its next request that looks at files waits until then
  TimeBudget budget;             ///< for its requests that cost much

  StateFlow flow;
  ItemFlow items;
  std::shared_ptr<const EncodedState> newest_state;  ///< under the virtual clock; null: none left

  /// A Run of steps is under way.
  [[nodiscard]] bool runs_steps() const { return current.has_value() && current->is_run_of_steps; }
};

}  // namespace hapticd
